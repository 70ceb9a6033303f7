"""The start: loops closed near the start values, velocities made to fit, what was given kept wherever the equations allow it.

First everything given is held. Where the loops cannot close so, the least is given up: the given coordinates are tried again
one by one, those first that stay nearest to their values when all of them may move, but unwillingly.
"""

import math

from numba.types import boolean, float64, int64, void

from .. import joints
from ..end_frames import touching
from ..language import apart, inlined, kernel
from ..math import algebra as al
from ..motion import coordinates, drives, kinematics, markers
from ..status import LOOP_OPEN, OK, status
from ..views import DATA, MODEL
from . import forward, holding, rows
from .holding import POSITION, VELOCITY
from .projection import (
    close_gaps,
    factor_for_velocities,
    keep_x,
    largest,
    move_by_change,
    project_velocities,
    restore_x,
    see_rows,
    unit_E,
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

# ways tried, and how much those are damped that are (see constraints.raise_diagonal)
TURNS = 8
DAMPING = 0.1

# exact closing that goes no further than this from where such gaps are left is a matter of singular positions
NEAR = 1e-2

# tries to keep given coordinates one by one; what must be put back after each: rounding
MAX_TRIES = 32
PUT_BACK = 10
KEPT = 1e-13

# a body is stuck that moves this little beside the others
STUCK = 1e-10

# given speeds are kept when the rows' rates are this small a part of the largest speed
RATE_ALLOWED = 1e-9

# parts of d.stage, which no step uses yet: the best found, one to go back to, deviations, one with gaps, the
# one of least gaps, the nearest found, where an attempt begins
BEST = 0
OTHER = 1
DEVIATION = 2
LOOSE = 3
LEAST = 4
FOUND = 5
BEGIN = 6
START = -1  # no part: the start values in x_before


@inlined
def store(m, d, part):
    """x to a part of d.stage."""
    for k in range(m.n_x):
        d.stage[part * m.n_x + k] = d.x[k]


@inlined
def recall(m, d, part):
    """x from a part of d.stage."""
    for k in range(m.n_x):
        d.x[k] = d.stage[part * m.n_x + k]


@inlined
def is_linear(m, row):
    """Whether a row couples joints of the tree alone."""
    if m.row_kind[row] != rows.COUPLING or m.coordinate_kind[m.row_i[row]] != coordinates.IN_TREE:
        return False

    return m.row_j[row] < 0 or m.coordinate_kind[m.row_j[row]] == coordinates.IN_TREE


@kernel
def begin_rows(m, d):
    """Couplings whose offset is to be found, which joints are in loops; nothing rests anywhere yet."""
    d.loose[0] = 0.0

    for i in range(m.n_body):
        d.in_loop[i] = 0.0
        d.stuck[i] = 0.0

    for row in range(m.n_row):
        c = m.row_constraint[row]
        d.row_rest[row] = 0.0
        d.row_taken[row] = 0.0
        d.row_redundant[row] = 0.0
        d.row_side[row] = 1.0
        d.row_settles[row] = float(m.row_at_start[row])

        if not is_linear(m, row):
            for step in range(m.constraint_path[c], m.constraint_path[c] + m.constraint_paths[c]):
                d.in_loop[m.path_node[step]] = 1.0


@kernel
def choose_sides(m, d):
    """What rolls stays on the side of its plane where the start puts its centre. Needs kinematics."""
    for row in range(m.n_row):
        if m.row_kind[row] == rows.ROLL_SPHERE or m.row_kind[row] == rows.ROLL_DISK:
            c = m.row_constraint[row]
            height = markers.relative_position(m, d, m.constraint_from[c], m.constraint_to[c])[2]
            d.row_side[row] = -1.0 if height < 0.0 else 1.0


@kernel
def spread_couplings(m, d):
    """Joints of the tree that follow from given or driven ones by couplings alone, exactly: these are linear."""
    for v in range(m.n_v):
        d.white[v] = float(m.v_given[v] % 2)

    for i in range(1, m.n_body):
        if m.body_drive[i] >= 0 and joints.n_v(m.body_joint[i]) == 1:
            d.white[m.body_v[i]] = 1.0

    for sweep in range(m.n_row):
        spread = False

        for row in range(m.n_row):
            if not is_linear(m, row) or m.row_j[row] < 0 or d.row_settles[row] > 0.0:
                continue

            i = m.coordinate_body[m.row_i[row]]
            j = m.coordinate_body[m.row_j[row]]
            known_i = d.white[m.body_v[i]] > 0.0
            known_j = d.white[m.body_v[j]] > 0.0
            a = m.row_value[2 * row]
            b = m.row_value[2 * row + 1]

            if known_i and not known_j:
                d.x[m.body_q[j]] = -(m.row_offset[row] + a * d.x[m.body_q[i]]) / b
                d.white[m.body_v[j]] = 1.0
                spread = True
            elif known_j and not known_i:
                d.x[m.body_q[i]] = -(m.row_offset[row] + b * d.x[m.body_q[j]]) / a
                d.white[m.body_v[i]] = 1.0
                spread = True

        if not spread:
            return


@inlined
def travel(m, d, part):
    """How far x is from d.stage's part (START: from x_before): root of the sum of squares, rad or parts of the scene's length."""
    total = 0.0

    for i in range(1, m.n_body):
        kind = m.body_joint[i]
        q = m.body_q[i]

        for k in range(joints.n_q(kind)):
            before = d.x_before[q + k] if part < 0 else d.stage[part * m.n_x + q + k]
            change = d.x[q + k] - before

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
    store(m, d, OTHER)
    aimed = touching.aim(m, d)
    failure = close_gaps(m, d, allowed, stride)

    if aimed:
        if failure != OK:
            recall(m, d, OTHER)

        touching.release(m, d)
        failure = close_gaps(m, d, allowed, stride)

    return failure


@inlined
def remember_gap(m, d, gap):
    """Where the gaps were smallest, to be told if the loops cannot be closed."""
    if gap < d.least_gap[0]:
        d.least_gap[0] = gap
        store(m, d, LEAST)


@kernel
def close(m, d, stride):
    """As close_loops; where loops repeat themselves not quite exactly, with gaps, and d.loose is 1. Returns a status."""
    store(m, d, BEGIN)
    d.loose[0] = 1.0
    failure = close_loops(m, d, stride)
    gap = largest(d.row_gap, m.n_row)
    remember_gap(m, d, gap)

    if failure == OK and gap <= m.closing_tolerance[0]:
        d.loose[0] = 0.0
        return OK

    loose = failure == OK and gap <= GAP_TAKEN
    d.loose[0] = 0.0

    if loose:
        store(m, d, LOOSE)
    else:
        recall(m, d, BEGIN)

    failure = close_loops(m, d, stride)
    remember_gap(m, d, largest(d.row_gap, m.n_row))

    if not loose or (failure == OK and travel(m, d, LOOSE) < NEAR):
        return failure

    recall(m, d, LOOSE)
    d.loose[0] = 1.0
    see_rows(m, d)
    return forward.factor_rows_here(m, d, True)


@apart(int64(MODEL, DATA, float64, float64, int64))
def attempt(m, d, stride, nudge, source):
    """Close the loops with what d.kept says, from the start values or a part of d.stage. Returns a status.

    nudge : rad and m, by which joints that are not held are moved first, for a start may be singular.
    """
    if source >= 0:
        recall(m, d, source)
    else:
        restore_x(m, d)

    partly = holding.begin(m, d, POSITION)

    for i in range(1, m.n_body):
        v = m.body_v[i]

        if joints.n_v(m.body_joint[i]) == 1 and d.kept[v] > 0.0:
            d.x[m.body_q[i]] = m.q_start[m.body_q[i]]

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
        for k in range(2):
            c = m.row_i[row] if k == 0 else m.row_j[row]

            if m.row_kind[row] == rows.COUPLING and c >= 0 and m.coordinate_kind[c] == coordinates.IN_TREE:
                d.white[m.body_v[m.coordinate_body[c]]] = 0.0

    for i in range(1, m.n_body):
        if m.body_joint[i] == joints.REVOLUTE and d.white[m.body_v[i]] > 0.0:
            q = m.body_q[i]
            d.x[q] = coordinates.unwrapped(d.x[q], d.x_before[q])


@apart(int64(MODEL, DATA))
def close_nearest(m, d):
    """The nearest assembly to the start values with what d.kept says, of those that several ways lead to. Returns a status.

    The first way is the last when it ends near.
    """
    result = attempt(m, d, STRIDE, 0.0, START)
    way = travel(m, d, START) if result == OK else math.inf

    if way < FAR:
        return OK

    loose = d.loose[0]
    store(m, d, FOUND)
    weighs = d.weighs[0]

    for turn in range(TURNS):
        # small steps; in the metric of the coordinates; damped, which passes folds; then from elsewhere
        nudge = 0.0 if turn < 3 else (NUDGE if turn < 6 else LONG_NUDGE) * (-1.0 if turn % 2 == 0 else 1.0)
        d.damping[0] = DAMPING if turn == 2 or turn == 3 else 0.0

        if turn == 1 and weighs != holding.ALL:
            holding.weigh_all(m, d, POSITION)

        if attempt(m, d, SHORT_STRIDE, nudge, START) == OK and travel(m, d, START) < NEARER * way:
            way = travel(m, d, START)
            loose = d.loose[0]
            store(m, d, FOUND)
            result = OK

        if turn == 1 and weighs != holding.ALL:
            holding.weigh_none(m, d)

    d.damping[0] = 0.0

    if result == OK:
        recall(m, d, FOUND)
        d.loose[0] = loose

    return result


@inlined
def gives_all(m, what):
    """Whether the start values of all coordinates without a drive are given."""
    for i in range(1, m.n_body):
        for v in range(m.body_v[i], m.body_v[i] + joints.n_v(m.body_joint[i])):
            if m.body_drive[i] < 0 and (m.v_given[v] // what) % 2 == 0:
                return False

    return True


@inlined
def measure(m, d, what):
    """How far each given coordinate is from its start value, to d.stage; -1 where there is nothing to keep.

    An orientation counts as one at its first coordinate.
    """
    for i in range(1, m.n_body):
        kind = m.body_joint[i]

        for k in range(joints.n_v(kind)):
            v = m.body_v[i] + k
            off = -1.0

            if m.body_drive[i] < 0 and (m.v_given[v] // what) % 2 == 1:
                off = holding.deviation(m, d, i, k, what)

                if what == POSITION and not joints.slides(kind, k) and k % 3 > 0:
                    off = -1.0

            d.stage[DEVIATION * m.n_x + v] = off


@inlined
def nearest_left(m, d):
    """The given coordinate least off that was not tried, or -1."""
    best = -1

    for v in range(m.n_v):
        off = d.stage[DEVIATION * m.n_x + v]

        if off >= 0.0 and (best < 0 or off < d.stage[DEVIATION * m.n_x + best]):
            best = v

    return best


@inlined
def mark(m, d, v, what, value):
    """d.kept of a coordinate; of an orientation's three."""
    i = 1

    while i + 1 < m.n_body and m.body_v[i + 1] <= v:
        i += 1

    d.kept[v] = value
    kind = m.body_joint[i]

    if what == POSITION and joints.turns(kind, v - m.body_v[i]):
        d.kept[v + 1] = value
        d.kept[v + 2] = value


@kernel
def give_way(m, d):
    """Positions where what was given cannot all be kept: as much of it as can. Returns a status."""
    holding.keep_none(m, d)

    if gives_all(m, POSITION):
        return close_nearest(m, d)

    holding.weigh_all(m, d, POSITION)

    if close_nearest(m, d) != OK:
        holding.keep_none(m, d)
        return close_nearest(m, d)

    loose = d.loose[0]
    store(m, d, BEST)
    measure(m, d, POSITION)

    for turn in range(MAX_TRIES):
        v = nearest_left(m, d)

        if v < 0:
            break

        d.stage[DEVIATION * m.n_x + v] = -1.0
        mark(m, d, v, POSITION, 1.0)

        if attempt(m, d, STRIDE, 0.0, BEST) == OK or close_nearest(m, d) == OK:
            loose = d.loose[0]
            store(m, d, BEST)
        else:
            mark(m, d, v, POSITION, 0.0)

    recall(m, d, BEST)
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
        recall(m, d, LEAST)
        see_rows(m, d)
        failure = status(LOOP_OPEN, m.n_body + worst_constraint(m, d))

    return failure


@inlined
def rest_here(m, d):
    """Rows of loops that are not quite exact rest at the gaps they have."""
    if d.loose[0] > 0.0:
        for row in range(m.n_row):
            d.row_rest[row] += d.row_gap[row]
            d.row_gap[row] = 0.0


@inlined
def see_gaps(m, d):
    """Remember the largest gaps of loops that are not quite exact, to tell them."""
    for row in range(m.n_row):
        if m.row_at_start[row] == 0 and abs(d.row_gap[row]) > abs(d.row_taken[row]):
            d.row_taken[row] = d.row_gap[row] if d.loose[0] > 0.0 else 0.0


@kernel
def settle(m, d):
    """Gaps that stay are where rows rest: of couplings whose offset is that of the start, of loops not quite exact."""
    see_rows(m, d)
    see_gaps(m, d)
    rest_here(m, d)

    for row in range(m.n_row):
        d.row_settles[row] = 0.0

    rows.write_rows(m, d)

    for row in range(m.n_row):
        if m.row_at_start[row] == 1:
            d.row_rest[row] += d.row_gap[row]

    rows.write_rows(m, d)


@inlined
def rate_left(m, d):
    """Largest rate among the rows that are asked of."""
    size = 0.0

    for row in range(m.n_row):
        if d.loose[0] == 0.0 or d.row_redundant[row] == 0.0:
            size = max(size, abs(d.row_rate[row]))

    return size


@apart(boolean(MODEL, DATA))
def try_velocities(m, d):
    """Velocities from the start values onto the rows, with what d.kept says. Returns whether they fit."""
    for k in range(m.n_q, m.n_q + m.n_v):
        d.x[k] = d.x_before[k]

    # angular velocities told in the first marker's axes do not turn with the body
    for i in range(1, m.n_body):
        if m.body_drive[i] < 0 and joints.E_offset(m.body_joint[i]) >= 0:
            for k in range(joints.n_v(m.body_joint[i])):
                joints.put_back(m, d, i, k, False)

    speed = 1.0 + largest(d.x, m.n_x)
    partly = holding.begin(m, d, VELOCITY)

    for turn in range(PUT_BACK):
        kinematics.kinematics(m, d)
        rows.write_rows(m, d)

        if forward.factor_rows_here(m, d, False) != OK:
            return False

        project_velocities(m, d)
        kinematics.kinematics(m, d)
        rows.write_rows(m, d)

        if not rate_left(m, d) <= RATE_ALLOWED * speed:
            return False

        if not partly or holding.put_back(m, d, VELOCITY) <= KEPT * speed:
            return True

    return False


@kernel
def find_velocities(m, d):
    """Velocities that the rows allow: the given ones kept, as many of them as can be."""
    holding.keep_none(m, d)
    holding.keep_given(m, d, VELOCITY)

    if try_velocities(m, d):
        return

    holding.keep_none(m, d)

    if gives_all(m, VELOCITY):
        try_velocities(m, d)
        return

    holding.weigh_all(m, d, VELOCITY)
    try_velocities(m, d)
    store(m, d, BEST)
    measure(m, d, VELOCITY)

    for turn in range(MAX_TRIES):
        v = nearest_left(m, d)

        if v < 0:
            break

        d.stage[DEVIATION * m.n_x + v] = -1.0
        mark(m, d, v, VELOCITY, 1.0)

        if try_velocities(m, d):
            store(m, d, BEST)
        else:
            mark(m, d, v, VELOCITY, 0.0)

    recall(m, d, BEST)


@inlined
def stir(m, d):
    """Velocities in which every joint without a drive takes part."""
    for i in range(1, m.n_body):
        for v in range(m.body_v[i], m.body_v[i] + joints.n_v(m.body_joint[i])):
            d.x[m.n_q + v] = math.cos(1.7 * v * v + 0.3) if d.held[i] == 0.0 else 0.0

    kinematics.kinematics(m, d)
    rows.write_rows(m, d)
    failure = forward.factor_rows_here(m, d, False)

    if failure == OK:
        project_velocities(m, d)

    return failure


@kernel
def see_stuck(m, d, seen):
    """Bodies that do not move in the velocities of d.x: d.stuck is `seen` + 1 for those that were stuck before."""
    kinematics.kinematics(m, d)
    size = 0.0

    for v in range(m.n_q, m.n_q + m.n_v):
        size = max(size, STUCK * abs(d.x[v]))

    # what is held, as a ground that moves, is not stuck
    for i in range(1, m.n_body):
        moves = d.held[i] > 0.0 or al.norm(al.vec3(d.w, i)) > size or al.norm(al.vec3(d.rd, i)) > size * m.scene_length[0]
        d.stuck[i] = seen + 1.0 if not moves and d.stuck[i] == seen else 0.0


@apart(void(MODEL, DATA))
def find_redundant(m, d):
    """Mark rows that follow from others not just here but in every position: they are dropped at a position nearby too.

    Keeps d.x. Nearby: a little way along an allowed motion in which every joint takes part. Bodies that move neither here
    nor there are stuck, where no joint is driven.
    """
    allowed = m.closing_tolerance[0]
    undriven = not drives.moves_joints(m)
    store(m, d, BEST)
    holding.keep_none(m, d)
    holding.hold(m, d)

    if stir(m, d) == OK:
        if undriven:
            see_stuck(m, d, 0.0)

        size = largest(d.x, m.n_x)

        for v in range(m.n_v):
            d.change[v] = d.x[m.n_q + v]

        move_by_change(m, d, 0.1 / (1.0 + size))
        store(m, d, OTHER)
        failure = close_gaps(m, d, allowed, STRIDE)

        # a loop that is not quite exact may close exactly where it starts
        if failure != OK and d.loose[0] == 0.0:
            recall(m, d, OTHER)
            d.loose[0] = 1.0
            failure = close_gaps(m, d, allowed, STRIDE)
            d.loose[0] = 1.0 if failure == OK and largest(d.row_gap, m.n_row) <= GAP_TAKEN else 0.0

        if failure == OK:
            see_gaps(m, d)
            factor_for_velocities(m, d)

            for row in range(m.n_row):
                d.row_redundant[row] = 1.0 if d.pivot[row] == 0.0 else 0.0

            forward.exchange_rows(m, d)

            if undriven and stir(m, d) == OK:
                see_stuck(m, d, 1.0)

    recall(m, d, BEST)
    see_rows(m, d)
    rest_here(m, d)


@apart(int64(MODEL, DATA))
def assemble(m, d):
    """Close the loops from approximate start values in d.x, then make the velocities fit. Returns a status."""
    drives.prescribe(m, d)
    unit_E(m, d)
    begin_rows(m, d)
    holding.keep_none(m, d)
    holding.hold(m, d)
    kinematics.kinematics(m, d)
    forward.lend_inertia(m, d)

    if m.n_row == 0:
        return OK

    rows.start_turns(m, d)
    choose_sides(m, d)
    spread_couplings(m, d)
    kinematics.kinematics(m, d)
    touching.start(m, d)
    keep_x(m, d)
    d.assembling[0] = 1.0
    failure = find_positions(m, d)
    d.assembling[0] = 0.0

    if failure == OK:
        settle(m, d)
        find_redundant(m, d)
        find_velocities(m, d)

    for row in range(m.n_row):
        d.row_settles[row] = 0.0

    holding.keep_none(m, d)
    holding.hold(m, d)
    return failure
