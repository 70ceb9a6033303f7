"""Step-size control: how errors are weighed, the first step, how the next follows from the error.

PI control of explicit pairs (docs/theory.md 18.4), predictive control of implicit methods (18.7).
"""

import math

import numpy as np

from .. import joints
from ..dynamics.projection import project, restore_x
from ..dynamics.rates import is_finite, set_time
from ..end_frames import touching
from ..language import inlined
from ..motion import coordinates
from ..status import NOT_FINITE, OK, STEP_TOO_SMALL, status

SAFETY = 0.9
PI_BETA = 0.2
SHRINK = 0.2
GROW = 10.0

# errors less than this are taken for it in the memory of the controllers
LEAST_ERROR = 1e-4

# a step that falls below this part of the communication step, or of a second where that is longer, will not do
LEAST_STEP = 1e-13


@inlined
def weigh(m, d):
    """Error weights: absolute + relative tolerance times |x|, of an orientation times 1 (docs/theory.md 18.2).

    Angles and Euler parameters are weighed as rotations: their error does not become less with many turns.
    """
    for k in range(m.n_x):
        d.x_scale[k] = m.absolute_tolerance[0] + m.tolerance[0] * abs(d.x[k])

    z = m.n_q + m.n_v
    rotation = m.absolute_tolerance[0] + m.tolerance[0]

    for t in range(m.n_turn):
        d.x_scale[z + coordinates.turn(m, t)] = rotation

    for k in range(m.n_contact):
        if touching.is_sphere(m, k):
            d.x_scale[z + m.contact_z[k]] = touching.LONGITUDE_ALLOWED

    for i in range(1, m.n_body):
        joints.weigh(m, d, i, rotation)


@inlined
def first_step(m, d, H, rate):
    """A first inner step (s) of at most H from x' (at d.stage[rate:]), simplified from HNW I, II.4."""
    n = m.n_x
    size = 0.0
    speed = 0.0

    for k in range(n):
        x = d.x[k] / d.x_scale[k]
        v = d.stage[rate + k] / d.x_scale[k]
        size += x * x
        speed += v * v

    h = 1e-6 if size < 1e-10 * n or speed < 1e-10 * n else 0.01 * math.sqrt(size / speed)
    return min(h, H)


@inlined
def pi_factor(error, error_before, order):
    """By how much the next step is longer after an accepted one of this error (1: just allowed)."""
    beta = PI_BETA / order
    factor = SAFETY * max(error, 1e-10) ** -(1.0 / order - 0.75 * beta) * error_before**beta
    return min(GROW, max(SHRINK, factor))


@inlined
def predictive_factor(error, error_before, h, h_before, order):
    """The same of an implicit method, which looks back at the step before as well (h_before 0: at none)."""
    factor = max(error, 1e-10) ** (-1.0 / order)

    if h_before > 0.0:
        factor *= min(1.0, h / h_before * (error_before / max(error, 1e-10)) ** (1.0 / order))

    return factor


@inlined
def equal_steps(H, most):
    """(number of equal steps of at most `most` (s) over H (s), their length (s)). The number may be beyond all integers."""
    n_step = max(1.0, np.ceil(H / most * (1.0 - 1e-12)))
    return n_step, H / n_step if n_step < math.inf else most


@inlined
def accept(m, d, s):
    """End, at s (s) of the communication step, of an inner step of fixed length: d.x is projected, or what it was before. Returns a status.

    Not every method has a stage there, where drives are to be met.
    """
    set_time(m, d, s)
    failure = project(m, d) if is_finite(d, m.n_x) else status(NOT_FINITE, 0)

    if failure == OK:
        d.steps[0] += 1.0
    else:
        restore_x(m, d)

    return failure


@inlined
def least_step(H):
    """The shortest inner step (s) that will do in a communication step of H (s)."""
    return LEAST_STEP * min(H, 1.0)


@inlined
def too_small(finite, failure):
    """Status where no step is small enough: the failure of the kernels, if it was one."""
    if failure != OK:
        return failure

    return status(STEP_TOO_SMALL if finite else NOT_FINITE, 0)


@inlined
def limit_work(m, d):
    """Begin to count the work of a communication step."""
    d.evaluation_limit[0] = d.evaluations[0] + m.max_evaluations[0]


@inlined
def is_spent(d):
    """Whether a communication step has had all the work that it may cost."""
    return not d.evaluations[0] < d.evaluation_limit[0]


@inlined
def spend(d, evaluations):
    """Count work other than evaluations, as if it were so many of them."""
    d.evaluation_limit[0] -= evaluations


@inlined
def forget(d):
    """What steppers remember of a motion that does not go on so: an input jumped, a parameter or the method changed."""
    d.ahead[0] = 0.0
    d.rate_known[0] = 0.0
    d.span[0] = 0.0
    d.error_before[0] = LEAST_ERROR
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
