"""A stabilised explicit method for motions that decay fast, of `auto` alone: Runge, Kutta, Chebyshev, order 2 (docs/theory.md 18.10).

With s stages a decay of rate |lambda| is stable up to h |lambda| = 0.65 s^2, so that the cost grows as the root of the stiffness, and in
proportion to the evaluation's: no Jacobian is found and nothing factored, which is what a large scene that hangs together would pay most for.

Source: Sommeijer, Shampine, Verwer, RKC: an explicit solver for parabolic PDEs, J. Comp. Appl. Math. 88 (1998) 315-326.
"""

import math

import numpy as np

from ...steppers import RKC
from ..dynamics.ends import see_ends
from ..dynamics.projection import keep_x, project, restore_x
from ..dynamics.rates import evaluate, is_finite, store_rate
from ..language import apart, inlined, kernel
from ..signatures import DATA, MODEL, Tuple, float64, int64
from ..status import CHANGE_METHOD, CHANGE_PAIR, OK, TOO_MUCH_WORK, status
from . import choice, control, memory

NUMBER = RKC.number
ORDER = 3  # of the error estimate

# how far the polynomial is damped
DAMPING = 2.0 / 13.0

# stages: at most; a step longer than these allow is shortened
MOST_STAGES = 200.0

# steps for which a spectral radius holds, by how much it may be more then, and iterations that find it: at most, and when they settle
KEPT_FOR = 25.0
MORE = 1.1
MOST_ITERATIONS = 40
SETTLED = 0.02

# rows of d.stage: f at the start; the last two states; what a power iteration moves along
F0, LAST, BEFORE, ALONG = 0, 1, 2, 3


@kernel
def find_radius(m, d, s):
    """The spectral radius (1/s) of the Jacobian at x_before, where f stands in row F0, by the power method on differences. 0: none found.

    Begins from the same direction each time, so that a restored run finds the same.
    """
    n = m.n_x
    size = 0.0

    for k in range(n):
        value = math.cos(1.7 * k * k + 0.3) * d.x_scale[k]
        d.stage[ALONG * n + k] = value
        size += (value / d.x_scale[k]) ** 2

    radius = 0.0

    for turn in range(MOST_ITERATIONS):
        scale = math.sqrt(n / size) * 1e-2

        for k in range(n):
            d.x[k] = d.x_before[k] + scale * d.stage[ALONG * n + k]

        if evaluate(m, d, s) != OK:
            return 0.0

        size = 0.0

        for k in range(n):
            change = (d.x_rate[k] - d.stage[F0 * n + k]) / 1e-2
            d.stage[ALONG * n + k] = change
            size += (change / d.x_scale[k]) ** 2

        if not 0.0 < size < math.inf:
            return 0.0

        before = radius
        radius = math.sqrt(size / n)

        if turn > 3 and abs(radius - before) < SETTLED * radius:
            break

    return MORE * radius


@inlined
def stages_of(h, radius):
    """How many stages make a step of h (s) stable; `length_to_try` keeps them few."""
    stages = np.ceil(math.sqrt(1.0 + 1.54 * h * radius))
    return stages if 2.0 <= stages <= MOST_STAGES + 1.0 else 2.0


@kernel
def try_step(m, d, s, h, stages):
    """d.x a step of h (s) after x_before, at s (s). Needs f there in row F0. Returns a status."""
    n = m.n_x
    w0 = 1.0 + DAMPING / (stages * stages)

    # Chebyshev's polynomial and its derivatives at w0
    t = w0
    t_before = 1.0
    dt = 1.0
    dt_before = 0.0
    ddt = 0.0
    ddt_before = 0.0

    for j in range(2, int(stages) + 1):
        t, t_before = 2.0 * w0 * t - t_before, t
        dt, dt_before = 2.0 * w0 * dt - dt_before + 2.0 * t_before, dt
        ddt, ddt_before = 2.0 * w0 * ddt - ddt_before + 4.0 * dt_before, ddt

    w1 = dt / ddt
    b = 1.0 / (4.0 * w0 * w0)
    b_before = b
    node_before = 0.0
    node = w1 * b
    t = w0
    t_before = 1.0
    dt = 1.0
    dt_before = 0.0
    ddt = 0.0
    ddt_before = 0.0

    for k in range(n):
        d.stage[BEFORE * n + k] = d.x_before[k]
        d.stage[LAST * n + k] = d.x_before[k] + h * node * d.stage[F0 * n + k]

    for j in range(2, int(stages) + 1):
        a = 1.0 - t * b
        t, t_before = 2.0 * w0 * t - t_before, t
        dt, dt_before = 2.0 * w0 * dt - dt_before + 2.0 * t_before, dt
        ddt, ddt_before = 2.0 * w0 * ddt - ddt_before + 4.0 * dt_before, ddt
        next_b = ddt / (dt * dt)
        mu = 2.0 * w0 * next_b / b
        nu = -next_b / b_before
        slope = mu * w1 / w0

        for k in range(n):
            d.x[k] = d.stage[LAST * n + k]

        failure = evaluate(m, d, s + node * h)

        if failure != OK:
            return failure

        for k in range(n):
            last = d.stage[LAST * n + k]
            value = mu * last + nu * d.stage[BEFORE * n + k] + (1.0 - mu - nu) * d.x_before[k]
            d.stage[BEFORE * n + k] = last
            d.stage[LAST * n + k] = value + h * slope * (d.x_rate[k] - a * d.stage[F0 * n + k])

        node, node_before = mu * node + nu * node_before + slope * (1.0 - a), node
        b_before = b
        b = next_b

    for k in range(n):
        d.x[k] = d.stage[LAST * n + k]

    return OK


@inlined
def error_of(m, d, h):
    """Estimated error of a step of h (s) from x_before to d.x, whose rate is d.x_rate. 1: just allowed, inf: not a number."""
    n = m.n_x
    squares = 0.0

    for k in range(n):
        error = 0.8 * (d.x_before[k] - d.x[k]) + 0.4 * h * (d.stage[F0 * n + k] + d.x_rate[k])
        error /= d.x_scale[k]
        squares += error * error

    error = math.sqrt(squares / n)
    return error if error < math.inf and is_finite(d, n) else math.inf


@inlined
def length_to_try(h, left, radius):
    """(step (s) of at most h, whether it ends at the communication point, `left` (s) away): equal ones to there."""
    if radius > 0.0:
        h = min(h, (MOST_STAGES * MOST_STAGES - 1.0) / (1.54 * radius))

    step = control.equal_steps(left, h)[1] if left < 1e6 * h else h
    ends = step >= left * (1.0 - 1e-9)
    return left if ends else step, ends


@apart(Tuple((int64, float64))(MODEL, DATA, float64, float64))
def adaptive(m, d, s, H):
    """Adaptive inner steps from s to H (s) of the communication step.

    Returns (status, time reached within H); status CHANGE_METHOD or CHANGE_PAIR when another method costs less.
    """
    n = m.n_x
    h = d.next_step[NUMBER]
    known = memory.recall_rate(m, d)
    end = OK

    while s < H and end == OK:
        if control.is_spent(d):
            end = status(TOO_MUCH_WORK, 0)
            break

        see_ends(m, d)
        keep_x(m, d)

        if not known:
            failure = evaluate(m, d, s)

            if failure != OK:
                return failure, s

            store_rate(m, d, F0)
            known = True

        control.weigh(m, d)

        if d.radius_steps[0] <= 0.0:
            choice.see_border(d, find_radius(m, d, s))
            d.radius_steps[0] = KEPT_FOR
            restore_x(m, d)

        h = min(h, m.max_step[0])
        step, ends = length_to_try(h, H - s, d.border_radius[0])

        if not s + step > s:
            return control.too_small(0.0 < step < math.inf, OK), s

        failure = try_step(m, d, s, step, stages_of(step, d.border_radius[0]))
        error = math.inf

        if failure == OK:
            failure = evaluate(m, d, s + step)

        if failure == OK:
            error = error_of(m, d, step)

        if error <= 1.0:
            for k in range(n):
                d.stage[F0 * n + k] = d.x_rate[k]

            failure = project(m, d)

        if error <= 1.0 and failure == OK:
            known = m.n_row == 0
            s = H if ends else s + step
            d.steps[0] += 1.0
            d.error_sum[0] += error
            d.radius_steps[0] -= 1.0
            length = step * min(control.GROW, max(control.SHRINK, 0.8 * max(error, 1e-10) ** (-1.0 / ORDER)))
            h = max(h, length) if ends and step < h else length

            if choice.leaves_decaying(m, d, step):
                end = status(CHANGE_METHOD, 0)
            elif choice.watch_border(d, NUMBER, step, H):
                end = status(CHANGE_PAIR, 0)

        else:
            restore_x(m, d)
            d.rejected[0] += 1.0
            known = known and not error <= 1.0
            h = step * (max(0.1, 0.8 * error ** (-1.0 / ORDER)) if 1.0 < error < math.inf else 0.1)
            d.radius_steps[0] = 0.0

            if not h >= control.least_step(H):
                return control.too_small(error < math.inf, failure), s

    d.next_step[NUMBER] = h
    memory.remember_rate(m, d, known)
    return end, s
