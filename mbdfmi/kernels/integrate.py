"""Steppers: x' = f(x, u(s)) over a communication step, then project(x).

After each accepted inner step the state is projected: Euler parameters to unit length, positions and velocities
onto the constraints. Time inside a communication step is counted from its start, so results do not depend on
how a master sums its time.
"""

import math

from . import algebra as al
from . import contacts, drives, dynamics, forces, joints, tree
from .language import inlined, kernel
from .project import keep_x, project, restore_x
from .status import NOT_FINITE, OK, STEP_TOO_SMALL, status
from .tableaux import ERRORS, NODES, ORDER, PAIR_54, STAGE_COUNT, STAGES

RK4 = 0
RK54 = 1
RK853 = 2

INTEGRATORS = {"rk4": RK4, "rk54": RK54, "rk853": RK853}

# step-size control after Hairer, Norsett, Wanner, Solving ODEs I, section II.4: PI controller for order 5
SAFETY = 0.9
PI_BETA = 0.04
SHRINK = 0.2
GROW = 10.0


@inlined
def set_time(m, d, s):
    """Time and inputs at s (s) after the start of the communication step: u + u' s + u'' s^2 / 2."""
    n = m.n_u
    d.now[0] = d.time[0] + s

    for k in range(n):
        d.input[k] = d.u_buffer[k] + s * (d.u_buffer[n + k] + 0.5 * s * d.u_buffer[2 * n + k])


@kernel
def evaluate(m, d, s):
    """x' into d.x_rate for d.x and the inputs at time s of the communication step. Returns a status."""
    set_time(m, d, s)
    drives.prescribe(m, d)
    tree.kinematics(m, d)
    tree.inertias(m, d)
    forces.apply(m, d)

    for i in range(1, m.n_body):
        joints.position_rates(m, d, i)

    contacts.parameter_rates(m, d)
    d.evaluations[0] += 1.0
    return dynamics.accelerate(m, d)


@inlined
def is_finite(d, n):
    """True when x[:n] holds no NaN and no infinity."""
    total = 0.0

    for k in range(n):
        total += 0.0 * d.x[k]

    return total == 0.0


@inlined
def store_rate(m, d, stage):
    """Keep d.x_rate as that of a stage."""
    n = m.n_x

    for k in range(n):
        d.stage[stage * n + k] = d.x_rate[k]


@kernel
def rk4(m, d, H):
    """Classical Runge-Kutta method of order 4: equal inner steps of at most m.step over H (s).

    Returns (status, time reached within H).
    """
    n = m.n_x
    n_step = max(1, int(math.ceil(H / m.step[0] * (1.0 - 1e-12))))
    h = H / n_step

    for step in range(n_step):
        s = step * h
        keep_x(m, d)

        for stage in range(4):
            c = 0.0 if stage == 0 else (1.0 if stage == 3 else 0.5)

            if stage > 0:
                for k in range(n):
                    d.x[k] = d.x_before[k] + c * h * d.stage[(stage - 1) * n + k]

            failure = evaluate(m, d, s + c * h)

            if failure != OK:
                restore_x(m, d)
                return failure, s

            store_rate(m, d, stage)

        for k in range(n):
            slope = d.stage[k] + 2.0 * (d.stage[n + k] + d.stage[2 * n + k]) + d.stage[3 * n + k]
            d.x[k] = d.x_before[k] + h / 6.0 * slope

        if not is_finite(d, n):
            restore_x(m, d)
            return status(NOT_FINITE, 0), s

        failure = project(m, d)

        if failure != OK:
            restore_x(m, d)
            return failure, s

        d.steps[0] += 1.0

    return OK, H


@inlined
def weigh(m, d):
    """Error weights: absolute + relative tolerance times |x|; an orientation's is its unit length.

    Angles and Euler parameters are weighed as rotations: their error does not become less with many turns.
    """
    for k in range(m.n_x):
        d.x_scale[k] = m.absolute_tolerance[0] + m.tolerance[0] * abs(d.x[k])

    for i in range(1, m.n_body):
        kind = m.body_joint[i]
        q = m.body_q[i]
        rotation = m.absolute_tolerance[0] + m.tolerance[0]

        if kind == joints.REVOLUTE:
            d.x_scale[q] = rotation
        elif joints.E_offset(kind) >= 0:
            q += joints.E_offset(kind)

            for k in range(4):
                d.x_scale[q + k] = rotation


@inlined
def first_step(m, d, H):
    """A first inner step (s) from the rates of stage 0: Hairer, Norsett, Wanner I, section II.4, simplified."""
    n = m.n_x
    size = 0.0
    speed = 0.0

    for k in range(n):
        x = d.x[k] / d.x_scale[k]
        rate = d.stage[k] / d.x_scale[k]
        size += x * x
        speed += rate * rate

    h = 1e-6 if size < 1e-10 * n or speed < 1e-10 * n else 0.01 * math.sqrt(size / speed)
    return min(h, H)


@inlined
def advance(m, d, pair, stage, step):
    """d.x for a stage of a pair, from x_before and the rates of the stages before."""
    n = m.n_x

    for k in range(n):
        slope = 0.0

        for j in range(stage):
            slope += STAGES[pair, stage, j] * d.stage[j * n + k]

        d.x[k] = d.x_before[k] + step * slope


@inlined
def local_error(m, d, pair, step):
    """Estimated error of a step, 1: just allowed. Root mean square over the weighed states.

    The 8(5,3) pair damps its estimate of order 5 by that of order 3 (Hairer, Norsett, Wanner I, eq. II.10.17).
    """
    n = m.n_x
    squares = 0.0
    rough = 0.0

    for k in range(n):
        fine = 0.0
        coarse = 0.0

        for j in range(STAGE_COUNT[pair]):
            fine += ERRORS[pair, 0, j] * d.stage[j * n + k]
            coarse += ERRORS[pair, 1, j] * d.stage[j * n + k]

        fine /= d.x_scale[k]
        coarse /= d.x_scale[k]
        squares += fine * fine
        rough += coarse * coarse

    if squares == 0.0:
        return 0.0

    return step * squares / math.sqrt((squares + 0.01 * rough) * n)


@inlined
def keep_last_rate(m, d, pair):
    """The last stage becomes the first of the next step: unit length changed the rates of Euler parameters alone."""
    n = m.n_x
    last = (STAGE_COUNT[pair] - 1) * n

    for k in range(n):
        d.stage[k] = d.stage[last + k]

    for i in range(1, m.n_body):
        k = joints.E_offset(m.body_joint[i])

        if k >= 0:
            k += m.body_q[i]
            rate = al.E_rate(al.E_at(d.x, k), al.vec_at(d.x, m.n_q + m.body_v[i] + joints.E_offset(m.body_joint[i])))
            al.set_E_at(d.stage, k, rate)


@kernel
def adaptive(m, d, H, pair):
    """An explicit Runge-Kutta pair with adaptive inner steps over H (s).

    The step to try next survives in d.next_step, also when the end of H cut the last one short. Returns
    (status, time reached within H).
    """
    n = m.n_x
    s = 0.0
    failure = evaluate(m, d, 0.0)

    if failure != OK:
        return failure, s

    store_rate(m, d, 0)
    weigh(m, d)
    h = d.next_step[0]
    error_before = 1e-4
    power = 1.0 / ORDER[pair]
    beta = PI_BETA if pair == PAIR_54 else 0.0

    if not h > 0.0:
        h = first_step(m, d, H)

    while s < H:
        h = min(h, m.max_step[0])
        left = H - s
        cut = h >= left * (1.0 - 1e-9)
        step = left if cut else h
        keep_x(m, d)

        for stage in range(1, STAGE_COUNT[pair]):
            advance(m, d, pair, stage, step)
            failure = evaluate(m, d, s + NODES[pair, stage] * step)

            if failure != OK:
                break

            store_rate(m, d, stage)

        error = local_error(m, d, pair, step)
        finite = failure == OK and error < math.inf and is_finite(d, n)

        if finite and error <= 1.0:
            failure = project(m, d)
            finite = failure == OK

        if finite and error <= 1.0:
            s = H if cut else s + step

            if m.n_row == 0:
                keep_last_rate(m, d, pair)
            else:
                failure = evaluate(m, d, s)
                store_rate(m, d, 0)

                if failure != OK:
                    return failure, s

            weigh(m, d)
            d.steps[0] += 1.0
            factor = SAFETY * max(error, 1e-10) ** -(power - 0.75 * beta) * error_before**beta
            proposed = step * min(GROW, max(SHRINK, factor))
            error_before = max(error, 1e-4)

            # a step that the end cut short says little about a longer one
            h = max(h, proposed) if cut and step < h else proposed

        else:
            restore_x(m, d)
            d.rejected[0] += 1.0
            h = step * (max(SHRINK, SAFETY * error**-power) if finite else 0.1)

            if h < 1e-13 * H:
                if finite:
                    failure = status(STEP_TOO_SMALL, 0)
                elif failure == OK:
                    failure = status(NOT_FINITE, 0)

                return failure, s

    d.next_step[0] = h
    return OK, H
