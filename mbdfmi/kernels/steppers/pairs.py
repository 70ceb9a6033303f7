"""Embedded pairs of explicit Runge-Kutta methods, with an adaptive step (docs/theory.md 18.4 to 18.6)."""

import math


from .. import joints
from ..dynamics.ends import see_ends
from ..dynamics.projection import keep_x, project, restore_x
from ..dynamics.rates import evaluate, set_time, store_rate
from ..language import apart, inlined, kernel
from ..math import algebra as al
from ..signatures import DATA, MODEL, Tuple, boolean, float64, int64
from ..status import CHANGE_METHOD, CHANGE_PAIR, NOT_ATTAINED, NOT_KNOWN, OK, TOO_MUCH_WORK, status, tell
from . import choice, control, early, memory, noise
from .estimates import MOST_TRIES, NOTHING, advance, allowance, extension_error, judge, length_again
from .tableaux import (
    DENSE,
    DENSE_COUNT,
    GAP_NOISE,
    NODES,
    NOISE,
    ORDER,
    STABLE,
    STAGE_COUNT,
    STAGE_TOTAL,
    STAGES,
)

# a step that would end this close behind the communication point ends there
SLACK = 0.01

# estimated error of a continuous extension, 1: just allowed at the end of a step, that is allowed for what is read off it: of a
# smooth motion, which the estimate exaggerates; and of one with kinks, or stiff, where it is far above that of the step
EXTENSION_ALLOWED = 20.0
UNSEEN_ALLOWED = 3.0

# h |lambda| of a decaying motion that lasts, and the cosine that tells decay
STIFF_DECAY = 1.5
ALONG = 0.9


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
            rate = al.E_rate(al.E_at(d.q, k), al.vec_at(d.v, m.body_v[i] + joints.E_offset(m.body_joint[i])))
            al.set_E_at(d.stage, k, rate)


@kernel
def find_extension(m, d, pair, s, step):
    """The continuous extension of an accepted step from s (s) on, between x_before and d.front. Returns a status.

    Leaves d.x at the front. Needs all stages of the step.
    """
    n = m.n_x
    failure = OK

    for stage in range(STAGE_COUNT[pair], STAGE_TOTAL[pair]):
        advance(m, d, pair, stage, step)
        failure = evaluate(m, d, s + NODES[pair, stage] * step)

        if failure != OK:
            break

        store_rate(m, d, stage)

    first = 0
    last = (STAGE_COUNT[pair] - 1) * n

    for k in range(n):
        change = d.front[k] - d.x_before[k]
        d.dense[k] = change
        d.dense[n + k] = step * d.stage[first + k] - change
        d.dense[2 * n + k] = 2.0 * change - step * (d.stage[first + k] + d.stage[last + k])

        for i in range(3, DENSE_COUNT[pair]):
            slope = 0.0

            for j in range(STAGE_TOTAL[pair]):
                slope += DENSE[pair, i - 3, j] * d.stage[j * n + k]

            d.dense[i * n + k] = step * slope

        d.x[k] = d.front[k]

    d.span[0] = step
    return failure


@apart(int64(MODEL, DATA, int64, float64))
def extend(m, d, pair, H):
    """d.x at H (s) by the continuous extension of the step that leads to the front, projected. Returns a status."""
    n = m.n_x
    theta = 1.0 - (d.ahead[0] - H) / d.span[0]

    for k in range(n):
        value = 0.0

        for j in range(DENSE_COUNT[pair] - 1, -1, -1):
            value = (value + d.dense[j * n + k]) * (theta if j % 2 == 0 else 1.0 - theta)

        d.x[k] = d.front[k] - d.dense[k] + value

    set_time(m, d, H)
    return project(m, d)


@inlined
def border_kind(m, d, pair, step):
    """Where a step is beside the border of stability (choice.py) by the last two stages, both of the end of the step.

    For a change of state (dq, dv) of an eigenvalue lambda, dv' = lambda dv = lambda^2 dq. Where it decays (dv' against dv), the
    border is lower: such a motion would be gone after some steps if it were part of the solution.
    """
    if not STABLE[pair] < math.inf:
        return choice.WITHIN

    n = m.n_x
    last = STAGE_COUNT[pair] - 1
    position = 0.0
    velocity = 0.0
    acceleration = 0.0
    power = 0.0

    for k in range(m.n_q + m.n_v):
        slope = 0.0

        for j in range(last):
            slope += (STAGES[pair, last, j] - STAGES[pair, last - 1, j]) * d.stage[j * n + k]

        if k < m.n_q:
            position += slope * slope
        else:
            velocity += slope * slope
            rate = d.stage[last * n + k] - d.stage[(last - 1) * n + k]
            acceleration += rate * rate
            power += rate * slope

    if acceleration == 0.0 or position == 0.0 or velocity == 0.0:
        return choice.WITHIN

    decays = power < -ALONG * math.sqrt(velocity * acceleration)
    z = min(math.sqrt(acceleration / velocity), math.sqrt(step * math.sqrt(acceleration / position)))

    if not z > (STIFF_DECAY if decays else STABLE[pair]):
        return choice.WITHIN

    return choice.DECAYS if decays else choice.OSCILLATES


@inlined
def length_to_try(m, d, h, left, onward):
    """(step (s) of at most h, whether it ends at the communication point, `left` (s) away, or would, whether it passes that).

    Steps pass it only `onward`, and where they would end well behind it.
    """
    reaches = h >= left * (1.0 - 1e-9)
    passes = reaches and onward and h > left * (1.0 + SLACK)
    return left if reaches and not passes else h, reaches, passes


@inlined
def tell_looser(m, d, singular, rounding):
    """Says once that the tolerance is not attained: past a singular position, or by how many times less for rounding."""
    if d.singular_told[0] == 0.0:
        d.singular_told[0] = 1.0
        looser = allowance(m, MOST_TRIES) if singular else rounding
        tell(d, status(NOT_ATTAINED if singular else NOT_KNOWN, 0), m.tolerance[0], looser * m.tolerance[0])


@inlined
def try_step(m, d, pair, s, step, passes, found, least, most, tries):
    """d.x a step (s) after x_before, at s (s), projected; with the continuous extension where the step `passes` H.

    Needs the rate at s in stage 0, and those of `found` stages in all; least, most : of d.least_share in them. Returns (error that
    decides about the step and the next, estimate of it that is told, whether it is past a singular position and whether that is
    too near, status).
    Errors: 1: just allowed, inf: not a number, or the status tells why there is no step.
    """
    failure = OK

    # the last of them is the state that the step leads to
    for stage in range(min(found, STAGE_COUNT[pair] - 1), STAGE_COUNT[pair]):
        advance(m, d, pair, stage, step)

        if stage < found:
            continue

        failure = evaluate(m, d, s + NODES[pair, stage] * step)

        if failure != OK:
            return math.inf, math.inf, False, False, failure

        store_rate(m, d, stage)

        if m.n_row > 0:
            least = min(least, d.least_share[0])
            most = max(most, d.least_share[0])

    error, fine, told, singular = judge(m, d, pair, step, least, most, tries)
    near = singular and least < NOTHING

    if error > 1.0:
        return error, told, singular, near, OK

    if told > 1.0:
        tell_looser(m, d, singular, noise.floor(m, d, NOISE[pair], step))

    # stages that were found early left another time
    set_time(m, d, s + step)
    failure = project(m, d)

    if failure != OK or not passes:
        return error if failure == OK else math.inf, told, singular, False, failure

    for k in range(m.n_x):
        d.front[k] = d.x[k]

    failure = find_extension(m, d, pair, s, step)
    extension, unseen = extension_error(m, d, pair, step, fine)

    if failure != OK or not extension < math.inf:
        return math.inf, math.inf, singular, False, failure

    extension /= noise.floor(m, d, GAP_NOISE[pair], step)

    if singular and extension > 1.0:
        extension /= allowance(m, tries)

    estimate = max(told, extension)

    # where the motion is smooth and the extension good, the step is what it would be without
    if unseen:
        error = max(error, extension / UNSEEN_ALLOWED)
    elif extension > EXTENSION_ALLOWED:
        error = extension / EXTENSION_ALLOWED

    return error, estimate, singular, near, OK


@inlined
def length_after(m, d, pair, step, error, estimate):
    """Length (s) of the step after one that is accepted; counts it."""
    d.steps[0] += 1.0
    d.error_sum[0] += estimate
    length = step * control.pi_factor(error, d.error_before[0], ORDER[pair])
    d.error_before[0] = max(error, control.LEAST_ERROR)
    return length


@inlined
def first_length(m, d, pair, s, H):
    """Length (s) of the first step from s (s) on, by x' there, in stage 0, and a little further."""
    for k in range(m.n_x):
        d.x_before[k] = d.x[k]

    h = control.first_step(m, d, H, 0)

    for k in range(m.n_x):
        d.x[k] += h * d.stage[k]

    # at the same time: a drive that changes is not stiff
    failure = evaluate(m, d, s)

    for k in range(m.n_x):
        d.x[k] = d.x_before[k]

    return control.second_step(m, d, h, ORDER[pair]) if failure == OK else h


@apart(Tuple((int64, float64))(MODEL, DATA, float64, float64, int64, boolean, boolean))
def adaptive(m, d, s, H, pair, onward, auto):
    """An explicit Runge-Kutta pair with adaptive inner steps from s to H (s) of the communication step.

    onward : steps may lead past H, for nothing is known to change there. auto : give up when another method is better.
    The step to try next survives in d.next_step, also when the end of H cut the last one short. Returns
    (status, time reached within H); status CHANGE_METHOD or CHANGE_PAIR when it gave up.
    """
    h = d.next_step[pair]
    found = early.take(m, d, pair)  # stages from s on that are known
    known = memory.recall_rate(m, d) or found > 0  # stage 0 holds the rate at s
    end = OK
    share = d.early_share[0] if found > 0 else -1.0  # least_share there
    tries = d.early_tries[0] if found > 0 else 0.0  # attempts of the step to come that were rejected

    while s < H and end == OK:
        if control.is_spent(d):
            end = status(TOO_MUCH_WORK, 0)
            break

        if not known:
            failure = evaluate(m, d, s)

            if failure != OK:
                return failure, s

            store_rate(m, d, 0)
            known = True
            share = d.least_share[0] if m.n_row > 0 else -1.0

        control.weigh(m, d)

        if not h > 0.0:
            h = first_length(m, d, pair, s, H)

        h = min(h, m.max_step[0])
        step, reaches, passes = length_to_try(m, d, h, H - s, onward)

        if not s + step > s:
            return control.too_small(0.0 < step < math.inf, OK), s

        see_ends(m, d)
        keep_x(m, d)

        if found > 1 and step == d.early_step[0]:
            least = d.early_share[1]
            most = d.early_share[2]
        else:
            found = 1
            least = share if share >= 0.0 else 1.0
            most = share

        error, estimate, singular, near, failure = try_step(
            m, d, pair, s, step, passes, found, least, most, tries
        )
        found = 1

        if error <= 1.0:
            if auto:
                if choice.leaves_pair(m, d, step, border_kind(m, d, pair, step), H):
                    end = status(CHANGE_METHOD, 0)

                if choice.watch_border(d, pair, step, H) and end == OK and not passes:
                    end = status(CHANGE_PAIR, 0)

            known = m.n_row == 0

            if known:
                keep_last_rate(m, d, pair)

            if passes:
                memory.remember_rate(m, d, known)
                d.ahead[0] = s + step
                d.front_time[0] = d.time[0] + d.ahead[0]

                if extend(m, d, pair, H) != OK:
                    # no way to read the state off there: end a step there instead
                    restore_x(m, d)
                    d.ahead[0] = 0.0
                    known = False
                    onward = False
                    end = OK
                    continue

                d.ahead[0] -= H

            s = H if reaches else s + step
            length = length_after(m, d, pair, step, error, estimate)
            noise.count_step(d)
            tries = 0.0

            # a step that the end cut short says little about a longer one
            h = max(h, length) if reaches and step < h else length

        else:
            restore_x(m, d)

            if error < math.inf and not singular and noise.is_due(m, d):
                set_time(m, d, s)
                noise.find(m, d, NOISE[pair], step)

            h = length_again(d, pair, step, error, near and share >= NOTHING)
            tries += 1.0

            if not h >= control.least_step(H):
                if not (auto and m.n_jacobian > 0 and error < math.inf):
                    return control.too_small(error < math.inf, failure), s

                d.pair_rate[0] = 0.0
                end = status(CHANGE_METHOD, 0)

    d.next_step[pair] = h

    if not (s == H and d.ahead[0] > 0.0):
        memory.remember_rate(m, d, known)

    return end, s
