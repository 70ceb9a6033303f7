"""Step-size control: how errors are weighed, the first step, how the next follows from the error, how much work it may be.

PI control of explicit pairs (docs/theory.md 18.4), predictive control of implicit methods (18.7).
"""

import math

import numpy as np

from .. import joints
from ..end_frames import touching
from ..language import inlined
from ..motion import coordinates
from ..status import NOT_FINITE, OK, STEP_TOO_SMALL, status

SAFETY = 0.9
PI_BETA = 0.2
SHRINK = 0.2
GROW = 10.0

# the first step, times the rate at which the rates change
AT_FIRST = 2.0

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

    touching.weigh(m, d, z)

    for i in range(1, m.n_body):
        joints.weigh(m, d, i, rotation)


@inlined
def second_step(m, d, h, order):
    """A first inner step (s) of a method of this order (HNW I, II.4), from x' in d.stage's row 0 and d.x_rate a step h (s) on."""
    n = m.n_x
    speed = 0.0
    change = 0.0

    for k in range(n):
        v = d.stage[k] / d.x_scale[k]
        dv = (d.x_rate[k] - d.stage[k]) / (h * d.x_scale[k])
        speed += v * v
        change += dv * dv

    fastest = math.sqrt(max(speed, change) / n)

    if not 0.0 < fastest < math.inf:
        return h

    # nor much longer than the motion takes to change: it may be stiff
    stable = AT_FIRST * math.sqrt(speed / change) if change > 0.0 else math.inf
    return min(stable, (0.01 / fastest) ** (1.0 / order))


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
    d.linear_work[0] += evaluations
