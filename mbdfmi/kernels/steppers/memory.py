"""What steppers remember from one communication step to the next; all of it stands in the state."""

from ..language import inlined
from . import control


@inlined
def forget(d):
    """What steppers remember of a motion that does not go on so: an input jumped, a parameter or the method changed."""
    d.ahead[0] = 0.0
    d.early_stages[0] = 0.0
    d.rate_known[0] = 0.0
    d.span[0] = 0.0
    d.error_before[0] = control.LEAST_ERROR
    d.step_before[0] = 0.0


@inlined
def remember_rate(m, d, known):
    """Keep the rates of stage 0 for the next communication step, if they are known."""
    d.rate_known[0] = 1.0 if known else 0.0

    if known:
        for k in range(m.n_x):
            d.front_rate[k] = d.stage[k]


@inlined
def recall_rate(m, d):
    """Stage 0 as `remember_rate` kept it; False when it kept nothing."""
    if d.rate_known[0] == 0.0:
        return False

    for k in range(m.n_x):
        d.stage[k] = d.front_rate[k]

    return True
