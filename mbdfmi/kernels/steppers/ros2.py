"""A linearly implicit method (ROS2, docs/theory.md 18.8): of order 2 with any J, L-stable with the true one.

Each step does the same work: made for real time.
"""

import math

from ..dynamics.rates import evaluate, store_rate
from ..language import kernel
from ..math import linear
from ..status import OK
from . import control
from .jacobian import find_jacobian

GAMMA = 1.0 - 1.0 / math.sqrt(2.0)


@kernel
def step(m, d, s, h):
    """d.x a step of h (s) after x_before, at s (s) of the communication step. Returns a status.

    (1 - g h J) k1 = f(t, x), (1 - g h J) k2 = f(t + h, x + h k1) - 2 k1, x += h (3 k1 + k2) / 2.
    """
    n = m.n_x
    mu = 1.0 / (GAMMA * h)
    failure = evaluate(m, d, s)

    if failure == OK:
        store_rate(m, d, 0)
        failure = find_jacobian(m, d, 0)

    if failure != OK:
        return failure

    linear.factor(m, d.jacobian, mu, d.lu_real, d.swaps_real)
    control.spend(d, m.lu_work[0])

    for k in range(n):
        d.stage[k] *= mu

    linear.solve(m, d.lu_real, d.swaps_real, d.stage, 0, d.right)

    for k in range(n):
        d.x[k] = d.x_before[k] + h * d.stage[k]

    failure = evaluate(m, d, s + h)

    if failure != OK:
        return failure

    for k in range(n):
        d.stage[n + k] = mu * (d.x_rate[k] - 2.0 * d.stage[k])

    linear.solve(m, d.lu_real, d.swaps_real, d.stage, n, d.right)

    for k in range(n):
        d.x[k] = d.x_before[k] + 0.5 * h * (3.0 * d.stage[k] + d.stage[n + k])

    return OK
