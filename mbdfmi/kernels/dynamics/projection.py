"""Projection of positions and velocities onto the constraints, in the mass metric (docs/theory.md 12)."""

import math


from .. import joints
from ..end_frames import touching
from ..language import apart, inlined, kernel
from ..math import algebra as al
from ..motion import coordinates, drives, kinematics
from ..status import LOOP_OPEN, NOT_FINITE, OK, TOUCHES_ALONG, status
from ..signatures import DATA, MODEL, float64, int64
from . import forward, multipliers, rows
from .rates import is_finite

MAX_ITERATIONS = 50

# Newton's method has done what it can when the gaps (m, rad) are at rounding, or no longer shrink
ROUNDING = 1e-15
STALLED = 0.5

# likewise at the start, which may be far off
MAX_AT_START = 400
MOST_STALLED = 25

# iterations that may be damped, and down to which part of the scene's length
MOST_DAMPED = 60
DAMPED = 0.02

# gap (m, rad) of a loop that repeats itself not quite exactly, in a run, and up to which a start is taken for such a loop
GAP_MOST = 1e-3


@kernel
def unit_E(m, d):
    """Euler parameters of d.q to unit length."""
    for i in range(1, m.n_body):
        k = joints.E_offset(m.body_joint[i])

        if k >= 0:
            k += m.body_q[i]
            E = al.E_at(d.q, k)
            al.set_E_at(d.q, k, al.E_scale(1.0 / math.sqrt(al.E_dot(E, E)), E))


@kernel
def move_by_change(m, d, factor):
    """Positions moved along d.change, as if it were v for a time `factor`."""
    for i in range(1, m.n_body):
        joints.retract(m, d, i, factor)


@inlined
def worst_constraint(m, d):
    """The constraint of the largest position residual."""
    worst = 0

    for row in range(m.n_row):
        if abs(d.row_gap[row]) > abs(d.row_gap[worst]):
            worst = row

    return m.row_constraint[worst]


@inlined
def see_rows(m, d):
    """Rows at the positions and velocities of d.x, contacts at their closest points, angles outside the tree read anew."""
    kinematics.kinematics(m, d)
    touching.find_parameters(m, d)
    coordinates.read_turns(m, d)
    rows.write_rows(m, d)


@inlined
def gap_left(m, d, starting, first):
    """Largest gap among the rows; of loops that repeat themselves not quite exactly without the rows left out.

    At the start these are the ones that the last factor, if not this is the `first`, has dropped.
    """
    size = 0.0

    for row in range(m.n_row):
        gap = abs(d.row_gap[row])
        left_out = (
            (d.pivot[row] == 0.0 and not first) if starting else d.row_redundant[row] == multipliers.REDUNDANT
        )
        left_out = left_out and d.loose[0] > 0.0 and gap <= GAP_MOST

        if not (left_out or gap <= size):
            size = gap if gap < math.inf else math.inf

    return size


@inlined
def step_size(m, d, starting):
    """How far (rad, m) d.change goes; when `starting`, rotations of joints in loops, and how far anything goes beside the scene."""
    if not starting:
        return al.largest(d.change, m.n_v)

    size = 0.0

    for i in range(1, m.n_body):
        for k in range(joints.n_v(m.body_joint[i])):
            change = abs(d.change[m.body_v[i] + k])
            slides = joints.slides(m.body_joint[i], k)
            change *= 0.1 / m.scene_length[0] if slides else d.in_loop[i]

            if not change <= size:
                size = change if change < math.inf else math.inf

    return size


@apart(int64(MODEL, DATA, float64, float64))
def close_gaps(m, d, gap_allowed, stride):
    """Newton's method to the nearest positions (in the metric of the inertia) where all gaps close. Returns a status.

    gap_allowed : m, rad, what may be left when the gaps no longer shrink.
    stride : rad, how far a step may turn joints at the start; 0 in a run, which is never far from the constraints.

    Leaves rows and a factor of (nearly) the positions found, in any case at least one of this call.
    """
    starting = stride > 0.0
    limit = stride if starting else 0.5
    gap_before = math.inf
    least = math.inf
    stalled = 0

    for iteration in range(MAX_AT_START if starting else MAX_ITERATIONS):
        d.evaluation_limit[0] -= 1.0
        see_rows(m, d)
        gap = gap_left(m, d, starting, iteration == 0)
        done = gap <= ROUNDING or (gap > STALLED * gap_before and gap <= gap_allowed)

        if done and iteration > 0:
            return OK

        # near the constraints and in a run nothing is damped
        damping = d.damping[0]
        damps = starting and iteration < MOST_DAMPED and gap > DAMPED * m.scene_length[0]
        d.damping[0] = damping if damps else 0.0
        failure = forward.factor_rows_here(m, d, True)
        d.damping[0] = damping

        if failure != OK or done:
            return failure

        stalled = 0 if gap < 0.9 * least else stalled + 1
        least = min(least, gap)

        if stalled > MOST_STALLED:
            break

        for row in range(m.n_row):
            d.row_rhs[row] = -d.row_gap[row]

        forward.correct(m, d)
        size = step_size(m, d, starting)

        if not size < math.inf:
            break

        # far from the constraints full steps may overshoot
        move_by_change(m, d, 1.0 if size < limit else limit / size)
        gap_before = gap

    see_rows(m, d)
    return status(LOOP_OPEN, m.n_body + worst_constraint(m, d))


@inlined
def project_positions(m, d, gap_allowed):
    """`close_gaps` of a run."""
    return close_gaps(m, d, gap_allowed, 0.0)


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
def gap_of(m, d, c, taken):
    """A constraint's gap: (vector in m, inertial axes; angle in rad); with `taken` the one that a loop not quite exact is left."""
    span = al.ZERO3
    turned = 0.0

    for row in range(m.constraint_row[c], m.constraint_row[c] + m.constraint_rows[c]):
        gap = d.row_taken[row] if taken else d.row_gap[row]
        u = al.vec3(d.row_force_to, row)

        # rows tell by how much the cosine is off
        if m.row_kind[row] == rows.DOT and m.row_value[row] != 0.0:
            cosine = max(-1.0, min(1.0, m.row_value[row] + gap))
            gap = math.acos(cosine) - math.acos(m.row_value[row])

        if al.dot(u, u) > 0.0 and not rows.is_of_axes(m, row):
            span = al.axpy(gap, u, span)
        else:
            turned += gap * gap

    return span, math.sqrt(turned)


@inlined
def factor_for_velocities(m, d):
    """The factor that project_positions leaves, with rows that are about velocities alone."""
    for row in range(m.n_row):
        if rows.is_of_velocity(m, row):
            multipliers.factor_rows(m, d, False)
            return


@inlined
def see_contacts(m, d):
    """Whether surfaces that touch do so in a point. Returns a status."""
    for row in range(m.n_row):
        if m.row_kind[row] == rows.CONTACT and touching.touches_along(m, d, m.row_j[row]):
            return status(TOUCHES_ALONG, m.n_body + m.row_constraint[row])

    return OK


@kernel
def project_velocities(m, d):
    """The nearest velocities (in the mass metric) that the rows allow; needs rows and their factor."""
    for row in range(m.n_row):
        d.row_rhs[row] = -d.row_rate[row]

    forward.correct(m, d)

    for v in range(m.n_v):
        d.v[v] += d.change[v]


@apart(int64(MODEL, DATA))
def project(m, d):
    """After an accepted inner step: E to unit length, positions, then velocities onto the constraints. Returns a status.

    `d.now` is the end of that step: every method evaluates its last stage there.
    """
    if m.n_drive > 0:
        drives.prescribe(m, d)

    unit_E(m, d)
    failure = OK

    if m.n_row > 0:
        failure = project_positions(m, d, m.closing_tolerance[0])

        if failure == OK:
            failure = see_contacts(m, d)

        if failure == OK:
            factor_for_velocities(m, d)
            forward.exchange_rows(m, d)
            project_velocities(m, d)

    if failure == OK and not is_finite(d, m.n_x):
        failure = status(NOT_FINITE, 0)

    return failure


@kernel
def follow_commands(m, d):
    """Loops at the present commands, for outputs alone: the run leads its bodies there over the step to come. Needs d.x_own = x.

    Where that cannot be, x stays.
    """
    failure = project_positions(m, d, m.closing_tolerance[0])

    # the commands may have gone far: a factor of these positions
    if failure == OK:
        failure = forward.factor_rows_here(m, d, False)

    if failure == OK:
        project_velocities(m, d)

    if failure != OK or not is_finite(d, m.n_x):
        for k in range(m.n_x):
            d.x[k] = d.x_own[k]


@inlined
def keep_x(m, d):
    """Remember x, for `restore_x`."""
    for k in range(m.n_x):
        d.x_before[k] = d.x[k]


@inlined
def restore_x(m, d):
    """Back to the x kept last."""
    for k in range(m.n_x):
        d.x[k] = d.x_before[k]
