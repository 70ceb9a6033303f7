"""The classical Runge-Kutta method of order 4 (docs/theory.md 18.3)."""

from ..dynamics.rates import evaluate, store_rate
from ..language import kernel
from ..status import OK


@kernel
def step(m, d, s, h):
    """d.x a step of h (s) after x_before, at s (s) of the communication step. Returns a status."""
    n = m.n_x

    for stage in range(4):
        c = 0.0 if stage == 0 else (1.0 if stage == 3 else 0.5)

        if stage > 0:
            for k in range(n):
                d.x[k] = d.x_before[k] + c * h * d.stage[(stage - 1) * n + k]

        failure = evaluate(m, d, s + c * h)

        if failure != OK:
            return failure

        store_rate(m, d, stage)

    for k in range(n):
        slope = d.stage[k] + 2.0 * (d.stage[n + k] + d.stage[2 * n + k]) + d.stage[3 * n + k]
        d.x[k] = d.x_before[k] + h / 6.0 * slope

    return OK
