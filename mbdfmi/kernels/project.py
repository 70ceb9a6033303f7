"""Projection of positions and velocities onto the constraints, in the metric of the mass matrix."""

import math

from . import algebra as al
from . import constraints, coordinates, joints, rows, tree
from .language import inlined, kernel
from .status import LOOP_OPEN, OK, status

MAX_ITERATIONS = 30

# Newton converges quadratically: after a change of this size (m, rad) the next would be at rounding
SMALL_CHANGE = 1e-9


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


@kernel
def factor_here(m, d):
    """Rows and their factor for the positions of d.x. Returns a status."""
    tree.kinematics(m, d)
    tree.inertias(m, d)
    failure = tree.aba(m, d)

    if failure != OK:
        return failure

    rows.write_rows(m, d)
    constraints.reach_rows(m, d)
    constraints.factor_rows(m, d)
    return OK


@kernel
def project_positions(m, d, gap_allowed):
    """Newton's method to the nearest positions (in the mass metric) where all gaps close. Returns a status.

    `gap_allowed` (m, rad): what may be left where the rows contradict each other by rounding alone.
    """
    for iteration in range(MAX_ITERATIONS):
        failure = factor_here(m, d)

        if failure != OK:
            return failure

        for row in range(m.n_row):
            d.row_left[row] = -d.row_gap[row]

        constraints.correct(m, d)
        size = largest(d.change, m.n_v)

        if not size < math.inf:
            break

        # far from the constraints full steps may overshoot
        factor = 1.0 if size < 0.5 else 0.5 / size
        move_by_change(m, d, factor)

        if size < SMALL_CHANGE:
            tree.kinematics(m, d)
            rows.write_rows(m, d)

            if largest(d.row_gap, m.n_row) <= gap_allowed:
                return OK

            break

    tree.kinematics(m, d)
    rows.write_rows(m, d)
    return status(LOOP_OPEN, m.n_body + worst_constraint(m, d))


@kernel
def project_velocities(m, d):
    """The nearest velocities (in the mass metric) that the rows allow; rows and factor as project_positions leaves them."""
    for row in range(m.n_row):
        d.row_left[row] = -d.row_rate[row]

    constraints.correct(m, d)

    for v in range(m.n_v):
        d.x[m.n_q + v] += d.change[v]


@kernel
def project(m, d):
    """After an accepted inner step: E to unit length, positions, then velocities onto the constraints. Returns a status."""
    unit_E(m, d)
    failure = OK

    if m.n_row > 0:
        failure = project_positions(m, d, 1e-6)

        if failure == OK:
            project_velocities(m, d)

    coordinates.follow_turns(m, d)
    return failure
