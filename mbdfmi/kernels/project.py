"""Projection of positions and velocities onto the constraints, in the metric of the mass matrix."""

import math

from numba.types import float64, int64

from . import algebra as al
from . import constraints, contacts, coordinates, drives, dynamics, joints, rows, tree
from .language import apart, inlined, kernel
from .rates import is_finite
from .status import LOOP_OPEN, NOT_FINITE, OK, status
from .views import DATA, MODEL

MAX_ITERATIONS = 50

# Newton's method has done what it can when the gaps (m, rad) are at rounding, or no longer shrink
ROUNDING = 1e-15
STALLED = 0.5

# what may be left then: rows dropped near a singular position cannot be corrected, and need not be
GAP_ALLOWED = 1e-9


@kernel
def unit_E(m, d):
    """Euler parameters of d.x to unit length."""
    for i in range(1, m.n_body):
        k = joints.E_offset(m.body_joint[i])

        if k >= 0:
            k += m.body_q[i]
            E = al.E_at(d.x, k)
            al.set_E_at(d.x, k, al.E_scale(1.0 / math.sqrt(al.E_dot(E, E)), E))


@inlined
def move_by_change(m, d, factor):
    """Positions moved along d.change, as if it were v for a time `factor`."""
    for i in range(1, m.n_body):
        kind = m.body_joint[i]
        q = m.body_q[i]
        v = m.body_v[i]

        if kind == joints.REVOLUTE or kind == joints.PRISMATIC:
            d.x[q] += factor * d.change[v]
            continue

        if kind == joints.FREE:
            moved = al.axpy(factor, al.vec_at(d.change, v), al.vec_at(d.x, q))
            al.set_vec_at(d.x, q, moved)

        k = joints.E_offset(kind)

        if k < 0:
            continue

        E = al.E_at(d.x, q + k)
        turn = al.scale(factor, al.vec_at(d.change, v + k))
        rate = al.E_rate(E, turn)
        E = (E[0] + rate[0], E[1] + rate[1], E[2] + rate[2], E[3] + rate[3])
        al.set_E_at(d.x, q + k, al.E_scale(1.0 / math.sqrt(al.E_dot(E, E)), E))


@inlined
def largest(p, n):
    """Largest magnitude among p[:n]; infinite when one is NaN."""
    size = 0.0

    for k in range(n):
        if not abs(p[k]) <= size:
            size = abs(p[k]) if abs(p[k]) < math.inf else math.inf

    return size


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
    tree.kinematics(m, d)
    contacts.find_parameters(m, d)
    coordinates.read_turns(m, d)
    rows.write_rows(m, d)


@apart(int64(MODEL, DATA, float64))
def project_positions(m, d, gap_allowed):
    """Newton's method to the nearest positions (in the mass metric) where all gaps close. Returns a status.

    `gap_allowed` (m, rad): what may be left when the gaps no longer shrink. Leaves rows and a factor of (nearly) the
    positions found, in any case at least one of this call.
    """
    gap_before = math.inf

    for iteration in range(MAX_ITERATIONS):
        d.evaluation_limit[0] -= 1.0
        see_rows(m, d)
        gap = largest(d.row_gap, m.n_row)
        done = gap <= ROUNDING or (gap > STALLED * gap_before and gap <= gap_allowed)

        if done and iteration > 0:
            return OK

        failure = dynamics.factor_rows_here(m, d, True)

        if failure != OK or done:
            return failure

        for row in range(m.n_row):
            d.row_left[row] = -d.row_gap[row]

        dynamics.correct(m, d)
        size = largest(d.change, m.n_v)

        if not size < math.inf:
            break

        # far from the constraints full steps may overshoot
        move_by_change(m, d, 1.0 if size < 0.5 else 0.5 / size)
        gap_before = gap

    see_rows(m, d)
    return status(LOOP_OPEN, m.n_body + worst_constraint(m, d))


@inlined
def factor_for_velocities(m, d):
    """The factor that project_positions leaves, with rows that are about velocities alone."""
    for row in range(m.n_row):
        if rows.is_of_velocity(m, row):
            constraints.factor_rows(m, d, False)
            return


@kernel
def project_velocities(m, d):
    """The nearest velocities (in the mass metric) that the rows allow; needs rows and their factor."""
    for row in range(m.n_row):
        d.row_left[row] = -d.row_rate[row]

    dynamics.correct(m, d)

    for v in range(m.n_v):
        d.x[m.n_q + v] += d.change[v]


@apart(int64(MODEL, DATA))
def project(m, d):
    """After an accepted inner step: E to unit length, positions, then velocities onto the constraints. Returns a status.

    `d.now` is the end of that step: every method evaluates its last stage there.
    """
    drives.prescribe(m, d)
    unit_E(m, d)
    failure = OK

    if m.n_row > 0:
        failure = project_positions(m, d, GAP_ALLOWED)

        if failure == OK:
            factor_for_velocities(m, d)
            dynamics.exchange_rows(m, d)
            project_velocities(m, d)

    if failure == OK and not is_finite(d, m.n_x):
        failure = status(NOT_FINITE, 0)

    return failure


@inlined
def hold(m, d, what):
    """Joints with a drive are held, and those whose start values are given for `what` (1 position, 2 velocity)."""
    for i in range(1, m.n_body):
        given = (m.body_given[i] // what) % 2 == 1
        d.held[i] = 1.0 if given or m.body_drive[i] >= 0 or m.body_joint[i] == joints.FIXED else 0.0


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


@kernel
def close_loops(m, d, what):
    """Positions onto the constraints, with joints held as `hold` says. Returns a status.

    First to where contacts have their given parameters; where that cannot be, these are near which to begin.
    """
    hold(m, d, what)
    aimed = contacts.aim(m, d)
    failure = project_positions(m, d, GAP_ALLOWED)

    if aimed:
        if failure != OK:
            restore_x(m, d)

        contacts.release(m, d)
        failure = project_positions(m, d, GAP_ALLOWED)

    return failure


@apart(int64(MODEL, DATA))
def assemble(m, d):
    """Close the loops from approximate start values in d.x, then make the velocities fit. Returns a status.

    Start values that the user gave are kept where the loops can close so; only where they cannot does everything move.
    """
    drives.prescribe(m, d)
    unit_E(m, d)
    hold(m, d, 4)
    tree.kinematics(m, d)
    dynamics.lend_inertia(m, d)

    if m.n_row == 0:
        return OK

    rows.start_turns(m, d)
    tree.kinematics(m, d)
    contacts.start(m, d)

    keep_x(m, d)

    failure = close_loops(m, d, 1)

    if failure != OK:
        restore_x(m, d)
        failure = close_loops(m, d, 4)

    if failure != OK:
        return failure

    speed = 1.0 + largest(d.x, m.n_x)

    for what in (2, 4):
        hold(m, d, what)
        failure = dynamics.factor_rows_here(m, d, False)

        if failure != OK:
            return failure

        project_velocities(m, d)
        tree.kinematics(m, d)
        rows.write_rows(m, d)

        if largest(d.row_rate, m.n_row) <= 1e-9 * speed:
            break

    find_redundant(m, d)
    return OK


@kernel
def find_redundant(m, d):
    """Mark rows that follow from others not just here but in every position: they are dropped at a position nearby too.

    Keeps d.x. Nearby: a little way along an allowed motion in which every joint takes part.
    """
    keep_x(m, d)

    hold(m, d, 4)

    for i in range(1, m.n_body):
        for v in range(m.body_v[i], m.body_v[i] + joints.n_v(m.body_joint[i])):
            d.x[m.n_q + v] = math.cos(1.7 * v * v + 0.3) if d.held[i] == 0.0 else 0.0

    tree.kinematics(m, d)
    rows.write_rows(m, d)

    if dynamics.factor_rows_here(m, d, False) == OK:
        project_velocities(m, d)
        size = largest(d.x, m.n_x)

        for v in range(m.n_v):
            d.change[v] = d.x[m.n_q + v]

        move_by_change(m, d, 0.1 / (1.0 + size))

        if project_positions(m, d, GAP_ALLOWED) == OK:
            factor_for_velocities(m, d)

            for row in range(m.n_row):
                d.row_redundant[row] = 1.0 if d.pivot[row] == 0.0 else 0.0

            dynamics.exchange_rows(m, d)

    restore_x(m, d)
