"""Positions of the start (docs/theory.md 13.2, 13.3): loops closed near the start values, what was given kept.

First everything given is held. Where the loops cannot close so, the least is given up: the given coordinates are tried again
one by one, those first that stay nearest to their values when all of them may move, but unwillingly.
"""

import math


from .. import joints
from ..end_frames import touching
from ..language import apart, inlined, kernel
from ..math import algebra as al
from ..motion import coordinates
from ..status import LOOP_OPEN, OK, status
from ..signatures import DATA, MODEL, float64, int64
from . import forward, given, holding, rows
from .holding import POSITION
from .projection import (
    close_gaps,
    move_by_change,
    restore_x,
    see_rows,
    worst_constraint,
)

# rad, how far a step may turn joints in loops; and when another assembly is looked for
STRIDE = 0.5
SHORT_STRIDE = 0.1

# an assembly this far (rad, or parts of the scene's length) from the start is compared with others, which must be this much nearer
FAR = 0.3
NEARER = 0.95

# a gap up to this (m, rad) is left to loops that repeat themselves not quite exactly
GAP_TAKEN = 1e-4

# rad and m, ways off a singular start
NUDGE = 0.5
LONG_NUDGE = 1.5

# ways tried, and how much those are damped that are (see multipliers.raise_diagonal)
TURNS = 8
DAMPING = 0.1

# exact closing that goes no further than this from where such gaps are left is a matter of singular positions
NEAR = 1e-2

# a parameter of an end frame is not as given where it is off by more than this (and this part of it)
PARAMETER_MISSED = 1e-6

# tries to keep given coordinates one by one; what must be put back after each: rounding
MAX_TRIES = 32
PUT_BACK = 10
KEPT = 1e-13


@inlined
def travel(m, d, part):
    """How far x is from d.x_tried's part (START: from x_before): root of the sum of squares, rad or parts of the scene's length."""
    total = 0.0

    for i in range(1, m.n_body):
        kind = m.body_joint[i]
        q = m.body_q[i]

        for k in range(joints.n_q(kind)):
            before = d.x_before[q + k] if part < 0 else d.x_tried[part * m.n_x + q + k]
            change = d.q[q + k] - before

            # half the angle is the angle between E
            if joints.slides(kind, k):
                change /= m.scene_length[0]
            elif kind != joints.REVOLUTE:
                change *= 2.0

            total += change * change

    return math.sqrt(total)


@kernel
def close_loops(m, d, stride):
    """Positions onto the constraints, with joints held as they are. Returns a status.

    First to where contacts have their given parameters; where that cannot be, these are near which to begin.
    """
    allowed = m.closing_tolerance[0]
    given.store(m, d, given.OTHER)
    aimed = touching.aim(m, d)
    failure = close_gaps(m, d, allowed, stride)

    if aimed:
        if failure != OK:
            given.recall(m, d, given.OTHER)

        touching.release(m, d)
        failure = close_gaps(m, d, allowed, stride)

    return failure


@inlined
def remember_gap(m, d, gap):
    """Where the gaps were smallest, to be told if the loops cannot be closed."""
    if gap < d.least_gap[0]:
        d.least_gap[0] = gap
        given.store(m, d, given.LEAST)


@kernel
def close(m, d, stride):
    """As close_loops; where loops repeat themselves not quite exactly, with gaps, and d.loose is 1. Returns a status."""
    given.store(m, d, given.BEGIN)
    d.loose[0] = 1.0
    failure = close_loops(m, d, stride)
    gap = al.largest(d.row_gap, m.n_row)
    remember_gap(m, d, gap)

    if failure == OK and gap <= m.closing_tolerance[0]:
        d.loose[0] = 0.0
        return OK

    loose = failure == OK and gap <= GAP_TAKEN
    d.loose[0] = 0.0

    if loose:
        given.store(m, d, given.LOOSE)
    else:
        given.recall(m, d, given.BEGIN)

    failure = close_loops(m, d, stride)
    remember_gap(m, d, al.largest(d.row_gap, m.n_row))

    if not loose or (failure == OK and travel(m, d, given.LOOSE) < NEAR):
        return failure

    given.recall(m, d, given.LOOSE)
    d.loose[0] = 1.0
    see_rows(m, d)
    return forward.factor_rows_here(m, d, True)


@apart(int64(MODEL, DATA, float64, float64, int64))
def attempt(m, d, stride, nudge, source):
    """Close the loops with what d.kept says, from the start values or a part of d.x_tried. Returns a status.

    nudge : rad and m, by which joints that are not held are moved first, for a start may be singular.
    """
    if source >= 0:
        given.recall(m, d, source)
    else:
        restore_x(m, d)

    partly = holding.begin(m, d, POSITION)

    for i in range(1, m.n_body):
        v = m.body_v[i]

        if joints.n_v(m.body_joint[i]) == 1 and d.kept[v] > 0.0:
            d.q[m.body_q[i]] = m.q_start[m.body_q[i]]

        for k in range(joints.n_v(m.body_joint[i])):
            d.change[v + k] = 0.0 if d.held[i] > 0.0 else nudge * math.cos(1.7 * (v + k) * (v + k) + 0.3)

    if nudge != 0.0:
        move_by_change(m, d, 1.0)

    holding.put_back(m, d, POSITION)
    failure = close(m, d, stride)

    for turn in range(PUT_BACK):
        unwind(m, d)

        if failure != OK or not partly or holding.put_back(m, d, POSITION) <= KEPT:
            return failure

        failure = close(m, d, stride)

    return status(LOOP_OPEN, m.n_body)


@kernel
def unwind(m, d):
    """Full turns that joints made on their way are taken back where no coupling counts them."""
    for v in range(m.n_v):
        d.white[v] = 0.0

    for i in range(1, m.n_body):
        if m.body_joint[i] == joints.REVOLUTE and d.held[i] == 0.0:
            d.white[m.body_v[i]] = 1.0

    for row in range(m.n_row):
        for t in range(m.row_term[row], rows.last_term(m, row)):
            if rows.body_of_term(m, t) > 0:
                d.white[m.body_v[rows.body_of_term(m, t)]] = 0.0

    for i in range(1, m.n_body):
        if m.body_joint[i] == joints.REVOLUTE and d.white[m.body_v[i]] > 0.0:
            q = m.body_q[i]
            d.q[q] = coordinates.unwrapped(d.q[q], d.x_before[q])


@inlined
def parameters_missed(m, d):
    """How many end frames are not at the parameters that were given."""
    missed = 0

    for k in range(m.n_end_frame):
        z = m.end_frame_z[k]
        missed += m.end_frame_given[k] * int(
            abs(d.z[z] - m.s_start[z]) > PARAMETER_MISSED * (1.0 + abs(d.z[z]))
        )

    return missed


@apart(int64(MODEL, DATA))
def close_nearest(m, d):
    """The nearest assembly to the start values with what d.kept says, of those that several ways lead to. Returns a status.

    The first way is the last when it ends near. None that misses given parameters of end frames takes the place of one that keeps them.
    """
    result = attempt(m, d, STRIDE, 0.0, given.START)
    missed = parameters_missed(m, d)
    way = travel(m, d, given.START) if result == OK else math.inf

    if way < FAR:
        return OK

    loose = d.loose[0]
    given.store(m, d, given.FOUND)
    weighs = d.weighs[0]

    for turn in range(TURNS):
        # small steps; in the metric of the coordinates; damped, which passes folds; then from elsewhere
        nudge = 0.0 if turn < 3 else (NUDGE if turn < 6 else LONG_NUDGE) * (-1.0 if turn % 2 == 0 else 1.0)
        d.damping[0] = DAMPING if turn == 2 or turn == 3 else 0.0

        if turn == 1 and weighs != holding.ALL:
            holding.weigh_all(m, d, POSITION)

        if (
            attempt(m, d, SHORT_STRIDE, nudge, given.START) == OK
            and travel(m, d, given.START) < NEARER * way
            and (result != OK or parameters_missed(m, d) <= missed)
        ):
            way = travel(m, d, given.START)
            missed = parameters_missed(m, d)
            loose = d.loose[0]
            given.store(m, d, given.FOUND)
            result = OK

        if turn == 1 and weighs != holding.ALL:
            holding.weigh_none(m, d)

    d.damping[0] = 0.0

    if result == OK:
        given.recall(m, d, given.FOUND)
        d.loose[0] = loose

    return result


@kernel
def give_way(m, d):
    """Positions where what was given cannot all be kept: as much of it as can. Returns a status."""
    holding.keep_none(m, d)

    if given.gives_all(m, POSITION):
        return close_nearest(m, d)

    holding.weigh_all(m, d, POSITION)

    if close_nearest(m, d) != OK:
        holding.keep_none(m, d)
        return close_nearest(m, d)

    loose = d.loose[0]
    given.store(m, d, given.BEST)
    given.measure(m, d, POSITION)

    for turn in range(MAX_TRIES):
        v = given.nearest_left(m, d)

        if v < 0:
            break

        d.x_tried[given.DEVIATION * m.n_x + v] = -1.0
        given.mark(m, d, v, POSITION, 1.0)

        if attempt(m, d, STRIDE, 0.0, given.BEST) == OK or close_nearest(m, d) == OK:
            loose = d.loose[0]
            given.store(m, d, given.BEST)
        else:
            given.mark(m, d, v, POSITION, 0.0)

    given.recall(m, d, given.BEST)
    d.loose[0] = loose
    return OK


@kernel
def find_positions(m, d):
    """Positions that close the loops, nearest to the start values in x_before. Returns a status."""
    d.least_gap[0] = math.inf
    holding.keep_none(m, d)
    holding.keep_given(m, d, POSITION)
    failure = close_nearest(m, d)

    if failure != OK:
        failure = give_way(m, d)

    holding.keep_none(m, d)

    if failure % 256 == LOOP_OPEN and d.least_gap[0] < math.inf:
        given.recall(m, d, given.LEAST)
        see_rows(m, d)
        failure = status(LOOP_OPEN, m.n_body + worst_constraint(m, d))

    return failure
