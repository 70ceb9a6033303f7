"""Radau IIA of order 5 with an adaptive step (docs/theory.md 18.7; HW II, sections IV.5 and IV.8).

The three stages Z_i = h sum_j a_ij f(t + c_j h, x + Z_j) are found by simplified Newton iterations in the variables
W = T^-1 Z, which split into one real and one complex system of the size of x. J = df/dx is found by differences, kept over
steps and communication points, and found anew when the iteration says that it is too old.
"""

import math

import numpy as np

from ..dynamics.ends import see_ends
from ..dynamics.projection import keep_x, project, restore_x
from ..dynamics.rates import evaluate, evaluate_now, is_finite, set_time, store_rate
from ..language import apart, inlined, kernel
from ..math import linear
from ..motion import coordinates
from ..status import CHANGE_METHOD, OK, TOO_MUCH_WORK, status
from ..signatures import DATA, MODEL, Tuple, boolean, float64, int64
from ...steppers import STEPPERS
from . import choice, control, memory
from .jacobian import find_jacobian, spectral_radius

# nodes (4 -+ sqrt 6) / 10 and 1, weights of the error estimate (-13 -+ 7 sqrt 6) / 3 and -1/3
NODES = np.array([0.1550510257216822, 0.6449489742783178, 1.0])
ERROR = np.array([-10.048809399827416, 1.382142733160749, -1.0 / 3.0])

# eigenvalues of A^-1, MU and MU_RE +- i MU_IM: 3 + 9^(1/3) - 3^(1/3), 3 + (3^(1/3) - 9^(1/3)) / 2, -(3^(5/6) + 3^(7/6)) / 2;
# columns of T are real and imaginary parts of its eigenvectors, scaled to 1 in the last component, so that
# T^-1 A^-1 T = [MU, 0, 0; 0, MU_RE, -MU_IM; 0, MU_IM, MU_RE]; to 17 digits, for every machine must have the same bits
MU = 3.637834252744496
MU_RE = 2.6810828736277523
MU_IM = -3.0504301992474105
T = np.array(
    [
        [0.09443876248897524, -0.1412552950209542, 0.030029194105147424],
        [0.2502131229653333, 0.20412935229379994, -0.3829421127572619],
        [1.0, 1.0, 0.0],
    ]
)
T_INVERSE = np.array(
    [
        [4.178718591551905, 0.32768282076106237, 0.5233764454994495],
        [-4.178718591551905, -0.32768282076106237, 0.47662355450055044],
        [0.5028726349457868, -2.571926949855605, 0.5960392048282249],
    ]
)

RADAU = STEPPERS["radau"].number

MAX_ITERATIONS = 7

# outcomes of the iteration for the stages
CONVERGED, DIVERGES, CREEPS = 0, 1, 2

# rates at which residuals of dry friction vanish that are beyond doubt, and those that are if they do not grow
FAST = 0.05
STEADY = 0.5

# residual of a speed beside the smoothing speed of dry friction that is nothing
SETTLED = 0.03

ORDER = 4  # of the error estimate

# the step is kept, and with it the factors, where it could grow by less than this
KEEP = 1.2

# J is still good when the iteration converges as fast as this; one that costs more evaluations than COSTLY, as fast as that
GOOD_RATE = 1e-3
FAIR_RATE = 0.05
COSTLY = 60.0

# relative change of a step that its factors bear
SAME_STEP = 1e-9

# d.jacobian_known: one that is not factored yet, and one that is
NEW, FACTORED = 1.0, 2.0

# d.lu_known: what the work arrays hold
JACOBIAN_HERE, LU_HERE = 1.0, 2.0

# rows of d.stage: f at the start, at the three stages; W; right-hand sides, real and complex
F0, F, W, RIGHT = 0, 1, 4, 7


@kernel
def guess_stages(m, d, h):
    """Z by extrapolation of the collocation polynomial of the step before, zero where there is none, or where dry friction may
    hold: extrapolated speeds slip, and a Jacobian that sticks would hardly correct them."""
    n = m.n_x
    ratio = h / d.span[0] if d.span[0] > 0.0 and m.n_friction == 0 else 0.0

    for k in range(n):
        z0 = d.dense[k]
        z1 = d.dense[n + k]
        z2 = d.dense[2 * n + k]

        for i in range(3):
            value = 0.0

            if ratio > 0.0:
                a = 1.0 + NODES[i] * ratio
                c0 = NODES[0]
                c1 = NODES[1]
                value = z0 * a * (a - c1) * (a - 1.0) / (c0 * (c0 - c1) * (c0 - 1.0))
                value += z1 * a * (a - c0) * (a - 1.0) / (c1 * (c1 - c0) * (c1 - 1.0))
                value += z2 * a * (a - c0) * (a - c1) / ((1.0 - c0) * (1.0 - c1)) - z2

            d.dense[i * n + k] = value


@inlined
def tolerance_of_estimate(m):
    """The relative tolerance for an error estimate of order 3 that keeps that of a method of order 5 (code RADAU5)."""
    return max(m.tolerance[0], 0.1 * m.tolerance[0] ** (2.0 / 3.0))


@inlined
def weigh(m, d):
    """Error weights by that tolerance."""
    control.weigh(m, d)
    wider = tolerance_of_estimate(m) / m.tolerance[0]

    for k in range(m.n_x):
        d.x_scale[k] *= wider


@inlined
def weighed_norm(m, d, first, count):
    """Root mean square of `count` rows of d.stage from `first` on, weighed."""
    n = m.n_x
    total = 0.0

    for i in range(count):
        for k in range(n):
            x = d.stage[(first + i) * n + k] / d.x_scale[k]
            total += x * x

    return math.sqrt(total / (count * n))


@inlined
def friction_residual(m, d, h):
    """Largest residual (weighed) of the stages' speeds along joints with dry friction, if nothing were stiff there.

    Of joints in the tree, beyond what is nothing beside their smoothing speeds; in d.stage's right-hand sides, before they are
    solved for.
    """
    n = m.n_x
    largest = 0.0

    for f in range(m.n_friction):
        c = m.friction_coordinate[f]

        if m.coordinate_kind[c] == coordinates.IN_TREE:
            k = m.n_q + m.body_v[m.coordinate_body[c]]

            for i in range(3):
                residual = h / MU * abs(d.stage[(RIGHT + i) * n + k])

                if residual > SETTLED * m.friction_smoothing[f]:
                    largest = max(largest, residual / d.x_scale[k])

    return largest


@kernel
def find_stages(m, d, s, h):
    """Z of a step from s (s) on by simplified Newton iterations. Returns (outcome, iterations, rate, status).

    With dry friction small changes do not yet mean that the stages are found: where a joint breaks loose, a J that sticks lets
    it creep a little further each time (docs/theory.md 18.7). There the residual of its speed must vanish steadily as well; if
    it does not, the outcome is CREEPS.
    """
    n = m.n_x
    slip = 0.0
    slip_rate = 0.0
    outcome = DIVERGES
    wanted = tolerance_of_estimate(m)
    tolerance = max(2.2e-15 / wanted, min(0.03, math.sqrt(wanted)))
    before = 0.0
    rate = 0.0

    for k in range(n):
        for i in range(3):
            d.stage[(W + i) * n + k] = (
                T_INVERSE[i, 0] * d.dense[k]
                + T_INVERSE[i, 1] * d.dense[n + k]
                + T_INVERSE[i, 2] * d.dense[2 * n + k]
            )

    for iteration in range(MAX_ITERATIONS):
        for i in range(3):
            for k in range(n):
                d.x[k] = d.x_before[k] + d.dense[i * n + k]

            failure = evaluate(m, d, s + NODES[i] * h)

            if failure != OK:
                return DIVERGES, iteration, rate, failure

            store_rate(m, d, F + i)

        for k in range(n):
            f0 = d.stage[F * n + k]
            f1 = d.stage[(F + 1) * n + k]
            f2 = d.stage[(F + 2) * n + k]
            w1 = d.stage[(W + 1) * n + k]
            w2 = d.stage[(W + 2) * n + k]
            real = T_INVERSE[0, 0] * f0 + T_INVERSE[0, 1] * f1 + T_INVERSE[0, 2] * f2
            re = T_INVERSE[1, 0] * f0 + T_INVERSE[1, 1] * f1 + T_INVERSE[1, 2] * f2
            im = T_INVERSE[2, 0] * f0 + T_INVERSE[2, 1] * f1 + T_INVERSE[2, 2] * f2
            d.stage[RIGHT * n + k] = real - MU / h * d.stage[W * n + k]
            d.stage[(RIGHT + 1) * n + k] = re - (MU_RE * w1 - MU_IM * w2) / h
            d.stage[(RIGHT + 2) * n + k] = im - (MU_RE * w2 + MU_IM * w1) / h

        slip_before = slip
        slip_rate_before = slip_rate
        slip = friction_residual(m, d, h)
        slip_rate = slip / slip_before if slip_before > 0.0 else 0.0
        linear.solve(m, d.lu_real, d.swaps_real, d.stage, RIGHT * n, d.right)
        linear.solve_complex(m, d.lu_complex, d.swaps_complex, d.stage, (RIGHT + 1) * n, d.right)
        control.spend(d, m.solve_work[0])
        size = weighed_norm(m, d, RIGHT, 3)

        if not size < math.inf:
            return DIVERGES, iteration, rate, OK

        if iteration > 0:
            rate = size / before if before > 0.0 else 0.0

            # diverges, or would not be there in time
            if rate >= 1.0 or rate ** (MAX_ITERATIONS - iteration) / (1.0 - rate) * size > tolerance:
                return outcome, iteration, rate, OK

        for k in range(n):
            for i in range(3):
                d.stage[(W + i) * n + k] += d.stage[(RIGHT + i) * n + k]

            w0 = d.stage[W * n + k]
            w1 = d.stage[(W + 1) * n + k]
            w2 = d.stage[(W + 2) * n + k]

            for i in range(3):
                d.dense[i * n + k] = T[i, 0] * w0 + T[i, 1] * w1 + T[i, 2] * w2

        if size == 0.0 or (iteration > 0 and rate / (1.0 - rate) * size < tolerance):
            steady = slip_rate < FAST or (
                iteration > 1 and slip_rate < STEADY and slip_rate < 1.1 * slip_rate_before
            )

            if slip == 0.0 or steady:
                return CONVERGED, iteration + 1, rate, OK

            outcome = CREEPS

        before = size

    return outcome, MAX_ITERATIONS, rate, OK


@kernel
def stage_error(m, d, s, h, again):
    """Estimated error of a step, 1: just allowed (HW II, eqs. IV.8.19, IV.8.20); `again`: filtered once more."""
    n = m.n_x

    for k in range(n):
        difference = ERROR[0] * d.dense[k] + ERROR[1] * d.dense[n + k] + ERROR[2] * d.dense[2 * n + k]
        d.stage[W * n + k] = difference / h
        d.stage[RIGHT * n + k] = d.stage[F0 * n + k] + difference / h

    linear.solve(m, d.lu_real, d.swaps_real, d.stage, RIGHT * n, d.right)
    error = weighed_norm(m, d, RIGHT, 1)

    if again and error > 1.0:
        for k in range(n):
            d.x[k] = d.x_before[k] + d.stage[RIGHT * n + k]

        if evaluate(m, d, s) == OK:
            for k in range(n):
                d.stage[RIGHT * n + k] = d.x_rate[k] + d.stage[W * n + k]

            linear.solve(m, d.lu_real, d.swaps_real, d.stage, RIGHT * n, d.right)
            error = weighed_norm(m, d, RIGHT, 1)

    return error


@inlined
def factor_newton(m, d, h):
    """Factors of the Newton matrices of steps of h (s), unless there are those of a step hardly other."""
    other = abs(d.lu_step[0] - h) > SAME_STEP * h

    if other:
        d.lu_step[0] = h
        d.lu_known[0] = JACOBIAN_HERE

    # a restored run counts what the run counted
    if other or d.jacobian_known[0] == NEW:
        control.spend(d, m.lu_work[0])
        d.jacobian_known[0] = FACTORED

    if d.lu_known[0] != LU_HERE:
        h = d.lu_step[0]
        linear.factor(m, d.jacobian, MU / h, d.lu_real, d.swaps_real)
        linear.factor_complex(m, d.jacobian, MU_RE / h, MU_IM / h, d.lu_complex, d.swaps_complex)
        d.lu_known[0] = LU_HERE


@inlined
def new_jacobian(m, d, row):
    """J here, where the rates stand in d.stage's `row`, and what it takes to find it again. Returns a status."""
    for k in range(m.n_x):
        d.jacobian_x[k] = d.x[k]

    d.jacobian_time[0] = d.now[0]

    for k in range(m.n_u):
        d.jacobian_input[k] = d.input[k]

    failure = find_jacobian(m, d, row)
    d.jacobian_known[0] = NEW if failure == OK else 0.0
    d.lu_known[0] = JACOBIAN_HERE
    return failure


@kernel
def jacobian_again(m, d):
    """J as it was found, where it is in use but not here: its place alone stands in the state. Not counted. Returns a status."""
    evaluations = d.evaluations[0]
    d.now[0] = d.jacobian_time[0]

    for k in range(m.n_u):
        d.input[k] = d.jacobian_input[k]

    for k in range(m.n_x):
        d.x[k] = d.jacobian_x[k]

    failure = evaluate_now(m, d)
    store_rate(m, d, W)

    if failure == OK:
        failure = find_jacobian(m, d, W)

    restore_x(m, d)
    d.evaluations[0] = evaluations
    d.lu_known[0] = JACOBIAN_HERE
    return failure


@inlined
def find_rate_and_jacobian(m, d, s, known, watch):
    """f at x and s (s) into stage F0 unless it is `known` to be there, J unless there is one. Returns (J is of this x, status)."""
    failure = OK

    if d.jacobian_known[0] != 0.0 and d.lu_known[0] == 0.0:
        failure = jacobian_again(m, d)

    if failure == OK and not known:
        failure = evaluate(m, d, s)
        store_rate(m, d, F0)

    if failure != OK or d.jacobian_known[0] != 0.0:
        return False, failure

    set_time(m, d, s)
    failure = new_jacobian(m, d, F0)

    if watch:
        choice.see_radius(d, spectral_radius(m, d, RIGHT))

    return True, failure


@kernel
def find_jacobian_ahead(m, d, s, step):
    """J where the stages of a step (s) from s (s) on have come to: there a joint slips that stuck before. Returns a status."""
    for k in range(m.n_x):
        d.x[k] = d.x_before[k] + d.dense[2 * m.n_x + k]

    failure = evaluate(m, d, s + step)
    store_rate(m, d, W)

    if failure == OK:
        failure = new_jacobian(m, d, W)

    restore_x(m, d)
    weigh(m, d)
    return failure


@inlined
def length_to_try(h, left):
    """(step (s) of at most h, whether it ends at the communication point, `left` (s) away).

    Equal steps to the end, so that their factors serve them all.
    """
    step = control.equal_steps(left, h * (1.0 + SAME_STEP))[1] if left < 1e6 * h else h
    ends = step >= left * (1.0 - SAME_STEP)
    return left if ends else step, ends


@inlined
def try_step(m, d, s, step, again):
    """d.x a step (s) after x_before, at s (s), projected. Returns (outcome, error, iterations, their rate of convergence, status).

    error : estimated, 1: just allowed; inf: the iteration did not converge, or the status tells why there is no step.
    """
    factor_newton(m, d, step)
    guess_stages(m, d, step)
    outcome, iterations, rate, failure = find_stages(m, d, s, step)

    if outcome == CREEPS:
        failure = find_jacobian_ahead(m, d, s, step)

        if failure == OK:
            factor_newton(m, d, step)
            guess_stages(m, d, step)
            outcome, iterations, rate, failure = find_stages(m, d, s, step)

        # the next attempt begins with that of the start again
        if outcome != CONVERGED:
            d.jacobian_known[0] = 0.0

    if outcome != CONVERGED:
        return outcome, math.inf, iterations, rate, failure

    error = stage_error(m, d, s, step, again)

    for k in range(m.n_x):
        d.x[k] = d.x_before[k] + d.dense[2 * m.n_x + k]

    if not is_finite(d, m.n_x):
        return DIVERGES, math.inf, iterations, rate, OK

    if error <= 1.0:
        # stage_error may have left another time
        d.now[0] = d.time[0] + s + step
        failure = project(m, d)

    found = failure == OK and error < math.inf
    return CONVERGED if found else DIVERGES, error if found else math.inf, iterations, rate, failure


@inlined
def length_after(m, d, step, error, iterations, rate):
    """Length (s) of the step after one that is accepted; counts it, and tells whether J is too old."""
    factor = min(
        control.GROW,
        safety(iterations)
        * control.predictive_factor(error, d.error_before[0], step, d.step_before[0], ORDER),
    )
    d.steps[0] += 1.0
    d.error_sum[0] += error
    d.span[0] = step
    d.error_before[0] = max(error, control.LEAST_ERROR)
    d.step_before[0] = step

    good = FAIR_RATE if m.jacobian_work[0] + m.lu_work[0] > COSTLY else GOOD_RATE

    if iterations > 2 and rate > good:
        d.jacobian_known[0] = 0.0
    elif factor < KEEP:
        factor = 1.0

    return step * factor


@inlined
def length_again(d, h, step, outcome, error, iterations, here, failure):
    """Length (s) of the step in place of one that is rejected: shorter where that is to blame, else h with a new J; counts it."""
    d.span[0] = 0.0
    d.rejected[0] += 1.0

    if error < math.inf:
        factor = safety(iterations) * control.predictive_factor(
            error, d.error_before[0], step, d.step_before[0], ORDER
        )
        return step * max(control.SHRINK, factor)

    if here:
        return 0.5 * step if failure == OK else 0.1 * step

    d.jacobian_known[0] = 0.0
    return h


@inlined
def safety(iterations):
    """The less, the more iterations the stages took (HW II, IV.8)."""
    return control.SAFETY * (2 * MAX_ITERATIONS + 1) / (2 * MAX_ITERATIONS + iterations)


@apart(Tuple((int64, float64))(MODEL, DATA, float64, float64, boolean))
def adaptive(m, d, s, H, auto):
    """Radau IIA of order 5 with adaptive inner steps from s to H (s) of the communication step.

    auto : give up when the motion is not stiff. Returns (status, time reached within H); status CHANGE_METHOD when it gave up.
    """
    # where it would be found again, commands are not what they were
    if m.n_command > 0:
        d.jacobian_known[0] = 0.0

    h = d.next_step[RADAU]
    known = memory.recall_rate(m, d)  # stage F0 holds the rate at s
    here = False  # J is of this x
    again = True  # an error of the first step, and after a rejected one, is filtered twice
    end = OK

    while s < H and end == OK:
        if control.is_spent(d):
            d.next_step[RADAU] = h
            return status(TOO_MUCH_WORK, 0), s

        see_ends(m, d)
        keep_x(m, d)
        found, failure = find_rate_and_jacobian(m, d, s, known, auto)

        if failure != OK:
            return failure, s

        known = True
        here = here or found
        weigh(m, d)

        if not h > 0.0:
            h = control.first_step(m, d, H, F0)

        h = min(h, m.max_step[0])
        step, ends = length_to_try(h, H - s)

        if not s + step > s:
            return control.too_small(0.0 < step < math.inf, OK), s

        outcome, error, iterations, rate, failure = try_step(m, d, s, step, again)

        if error <= 1.0:
            s = H if ends else s + step
            length = length_after(m, d, step, error, iterations, rate)
            h = max(h, length) if ends and step < h else length
            known = False
            here = False
            again = False

            if auto and choice.leaves_implicit(m, d, step):
                end = status(CHANGE_METHOD, 0)

        else:
            restore_x(m, d)
            h = length_again(d, h, step, outcome, error, iterations, here, failure)
            again = again or error < math.inf

            if not h >= control.least_step(H):
                return control.too_small(error < math.inf, failure), s

    d.next_step[RADAU] = h
    memory.remember_rate(m, d, known)
    return end, s
