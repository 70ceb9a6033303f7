"""Dynamics by the joint-space mass matrix: M = J^T M J by composite bodies, its Cholesky factor, rows in joint coordinates.

The embedding technique of the lecture (section 5.2), n^3 in the number of coordinates. What it leaves in d means the same as what the
articulated-body passes leave: x_rate, the bodies' accelerations, whitened responses of the rows.
"""

import math

from . import algebra as al
from . import constraints, joints, markers, rows, tree
from .language import inlined, kernel
from .status import OK, SINGULAR_INERTIA, status


@kernel
def factor(m, d):
    """M = L L^T into d.mass_matrix (lower triangle, by rows). Held joints stand apart as if of unit inertia. Returns a status."""
    n = m.n_v
    L = d.mass_matrix
    tree.crba(m, d, L)

    for i in range(1, m.n_body):
        if d.held[i] > 0.0:
            for v in range(m.body_v[i], m.body_v[i] + joints.n_v(m.body_joint[i])):
                for k in range(n):
                    L[n * v + k] = 0.0
                    L[n * k + v] = 0.0

                L[n * v + v] = 1.0

    for j in range(n):
        for k in range(j + 1):
            value = L[n * j + k]

            for l in range(k):
                value -= L[n * j + l] * L[n * k + l]

            if k < j:
                L[n * j + k] = value / L[n * k + k]
            elif value > 0.0:
                L[n * j + j] = math.sqrt(value)
            else:
                return status(SINGULAR_INERTIA, body_of(m, j))

    return OK


@inlined
def body_of(m, v):
    """The body whose joint has the velocity coordinate v."""
    i = m.n_body - 1

    while i > 1 and m.body_v[i] > v:
        i -= 1

    return i


@inlined
def solve_lower(L, n, b, at):
    """b[at:at+n] = L^-1 b."""
    for j in range(n):
        value = b[at + j]

        for k in range(j):
            value -= L[n * j + k] * b[at + k]

        b[at + j] = value / L[n * j + j]


@inlined
def solve_upper(L, n, b):
    """b[:n] = L^-T b."""
    for j in range(n - 1, -1, -1):
        value = b[j] / L[n * j + j]
        b[j] = value

        for k in range(j):
            b[k] -= L[n * j + k] * value


@kernel
def forward(m, d):
    """v' = M^-1 (tau - bias) into d.x_rate, and the bodies' accelerations. Returns a status."""
    failure = factor(m, d)

    if failure != OK:
        return failure

    for i in range(1, m.n_body):
        for k in range(joints.n_v(m.body_joint[i]) if d.held[i] == 0.0 else 0):
            d.x_rate[m.n_q + m.body_v[i] + k] = 0.0

    tree.rnea(m, d, d.change)

    for v in range(m.n_v):
        d.change[v] = d.tau[v] - d.change[v]

    for i in range(1, m.n_body):
        for k in range(joints.n_v(m.body_joint[i]) if d.held[i] > 0.0 else 0):
            d.change[m.body_v[i] + k] = 0.0

    solve_lower(d.mass_matrix, m.n_v, d.change, 0)
    solve_upper(d.mass_matrix, m.n_v, d.change)

    for i in range(1, m.n_body):
        for k in range(joints.n_v(m.body_joint[i]) if d.held[i] == 0.0 else 0):
            d.x_rate[m.n_q + m.body_v[i] + k] = d.change[m.body_v[i] + k]

    tree.accelerations(m, d)
    return OK


@inlined
def add_jacobian(m, d, row, r, i, moment, force):
    """Efforts S^T (moment, force) that a wrench about body i's origin means in all joints below it, onto the row of d.reach.

    Adds to row_size what they could be if the wrench, whose force acts at r, met the axes of these joints.
    """
    n = m.n_v

    while i > 0:
        kind = m.body_joint[i]
        v = m.body_v[i]

        for k in range(joints.n_v(kind) if d.held[i] == 0.0 else 0):
            S_w, S_r = joints.subspace(m, d, i, k)
            diagonal = d.mass_matrix[n * (v + k) + v + k]
            d.reach[row * n + v + k] += al.dot(S_w, moment) + al.dot(S_r, force)

            if kind == joints.REVOLUTE or kind == joints.PRISMATIC:
                lever = al.sub(r, al.vec3(d.r, i))
                d.row_size[row] += constraints.largest_effort(kind, moment, force, lever) / (diagonal * diagonal)

        moment = al.add(moment, al.cross(al.vec3(d.arm, i), force))
        i = m.body_parent[i]


@kernel
def reach_rows(m, d, everything):
    """Rows of C L^-T, each over all velocity coordinates; redundant ones only with `everything`."""
    n = m.n_v

    for row in range(m.n_row):
        c = m.row_constraint[row]
        at = row * n

        if constraints.is_idle(d, row, everything):
            continue

        d.row_size[row] = 0.0

        for v in range(n):
            d.reach[at + v] = 0.0

        a = m.marker_body[m.constraint_from[c]]
        b = m.marker_body[m.constraint_to[c]]
        r = markers.position(m, d, m.constraint_to[c])
        add_jacobian(m, d, row, r, a, al.vec3(d.row_moment_from, row), al.vec3(d.row_force_from, row))
        add_jacobian(m, d, row, r, b, al.vec3(d.row_moment_to, row), al.vec3(d.row_force_to, row))

        if m.row_kind[row] == rows.COUPLING:
            for i in range(1, m.n_body):
                if d.held[i] == 0.0:
                    d.reach[at + m.body_v[i]] += rows.effort_on(m, row, i)

            if m.constraint_from_2[c] >= 0:
                a = m.marker_body[m.constraint_from_2[c]]
                b = m.marker_body[m.constraint_to_2[c]]
                add_jacobian(m, d, row, r, a, al.vec3(d.row_moment_from_2, row), al.vec3(d.row_force_from_2, row))
                add_jacobian(m, d, row, r, b, al.vec3(d.row_moment_to_2, row), al.vec3(d.row_force_to_2, row))

        solve_lower(d.mass_matrix, n, d.reach, at)


@kernel
def respond(m, d):
    """Changes of v' by the whitened efforts d.white, and those of the bodies' accelerations."""
    for v in range(m.n_v):
        d.change[v] = d.white[v]

    solve_upper(d.mass_matrix, m.n_v, d.change)
    al.set_vec3(d.change_alpha, 0, al.ZERO3)
    al.set_vec3(d.change_rdd, 0, al.ZERO3)

    for i in range(1, m.n_body):
        parent = m.body_parent[i]
        alpha = al.vec3(d.change_alpha, parent)
        rdd = al.add(al.vec3(d.change_rdd, parent), al.cross(alpha, al.vec3(d.arm, i)))

        for k in range(joints.n_v(m.body_joint[i])):
            S_w, S_r = joints.subspace(m, d, i, k)
            alpha = al.axpy(d.change[m.body_v[i] + k], S_w, alpha)
            rdd = al.axpy(d.change[m.body_v[i] + k], S_r, rdd)

        al.set_vec3(d.change_alpha, i, alpha)
        al.set_vec3(d.change_rdd, i, rdd)
