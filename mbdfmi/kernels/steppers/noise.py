"""What rounding makes of the rates, and so of the estimated error of a step: no shorter step errs less (docs/theory.md 18.4).

Where a tight tolerance is asked of accelerations that are not known so well, an estimate falls no more as the square or the eighth
power of the step does, and steps would shrink without end or use. So, when steps are rejected, the rates are found once more at a state
that differs in its last digits; what they differ by is what they are known to.
"""

import math

from ..dynamics.rates import evaluate_now
from ..language import inlined, kernel
from ..status import OK

# tolerances that are looked at; the loosest that is allowed in place of one that rounding does not attain
TIGHT = 1e-7
MOST = 1e-8

# by how much a state is changed, relative; how many times what that makes of an error rounding may make of it: measured are 0.1 to 2
DIGIT = 2.0**-52
AMPLE = 3.0

# the part of an allowed error that says that rounding matters; accepted steps for which what was found holds
MATTERS = 0.3
KEPT_FOR = 25.0

# the factor on the rejections that are let pass where rounding did not matter, and the largest number of them
LESS_OFTEN = 4.0
PATIENCE = 4096.0


@inlined
def start(d):
    """Nothing is known of it."""
    d.rate_noise[0] = 0.0
    d.noise_steps[0] = 0.0
    d.noise_due[0] = 1.0
    d.noise_patience[0] = 1.0


@inlined
def tolerance(m):
    """The looser one of those of the user."""
    return max(m.tolerance[0], m.absolute_tolerance[0])


@inlined
def floor(m, d, gain, step):
    """How many times the allowed error rounding may make of an estimate over a step (s), 1 at least.

    gain : what an estimate makes of independent errors of the rates that are all of one size.
    """
    if d.rate_noise[0] == 0.0:
        return 1.0

    return max(1.0, min(AMPLE * gain * step * d.rate_noise[0], MOST / tolerance(m)))


@inlined
def is_due(m, d):
    """Whether a step that was rejected, away from singular positions, calls for `find`; counts it."""
    if tolerance(m) >= TIGHT:
        return False

    d.noise_due[0] -= 1.0
    return d.noise_due[0] <= 0.0


@kernel
def find(m, d, gain, step):
    """What rounding makes of the rates at x_before, which stand in stage 0, where it matters over a step (s); at the time now.

    Leaves d.x there.
    """
    for k in range(m.n_x):
        turn = DIGIT if math.cos(1.7 * k * k + 0.3) > 0.0 else -DIGIT
        d.x[k] = d.x_before[k] * (1.0 + turn)

    failure = evaluate_now(m, d)
    squares = 0.0

    for k in range(m.n_x):
        change = (d.x_rate[k] - d.stage[k]) / d.x_scale[k]
        squares += change * change
        d.x[k] = d.x_before[k]

    noise = math.sqrt(squares / m.n_x)

    if failure == OK and AMPLE * gain * step * noise > MATTERS and noise < math.inf:
        d.rate_noise[0] = noise
        d.noise_steps[0] = KEPT_FOR
        d.noise_patience[0] = 1.0
    else:
        d.rate_noise[0] = 0.0
        d.noise_patience[0] = min(PATIENCE, LESS_OFTEN * d.noise_patience[0])

    d.noise_due[0] = d.noise_patience[0]


@inlined
def count_step(d):
    """One more step was accepted."""
    if d.rate_noise[0] > 0.0:
        d.noise_steps[0] -= 1.0

        if d.noise_steps[0] <= 0.0:
            d.rate_noise[0] = 0.0
