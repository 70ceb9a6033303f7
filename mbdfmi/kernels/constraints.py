"""Multipliers of the constraint rows, and projection onto what they allow.

With M = L_M L_M^T the joint-space inertia and C the rows' Jacobian, every row's response is kept whitened, R = C L_M^-T, so
that C M^-1 C^T = R R^T. The articulated-body factor gives R in one pass from a row's bodies to the ground (the
innovations form of the operational-space inertia: Rodriguez, Jain, Kreutz-Delgado, Int. J. Robotics Research 10, 1991), and only in the
joints on that way. R R^T is factored in its envelope, rows dropped whose pivot is a small part of their
diagonal: they follow from rows before them.
"""

import math

from . import algebra as al
from . import coordinates, joints, rows
from .language import inlined, kernel

# a row is dropped when what it adds to the rows before it is this small beside the largest row of its kind in the same
# constraint (squared sine of an angle: the square root of the machine precision)
DROP = 1e-8

# ... or beside what its wrenches could do if they met the joints' axes: then it is hardly more than rounding
NOISE = 1e-14


@inlined
def subtract_scaled(d, i, s, U_w, U_r):
    """Wrench on its way past joint i less s U."""
    al.add_vec3(d.passed_moment, i, al.scale(-s, U_w))
    al.add_vec3(d.passed_force, i, al.scale(-s, U_r))


@inlined
def whiten(F, e):
    """D^-1/2 L^-1 e with F = sym_factor(S)."""
    y = e[1] - F[3] * e[0]
    z = e[2] - F[4] * e[0] - F[5] * y
    return (e[0] / math.sqrt(F[0]), y / math.sqrt(F[1]), z / math.sqrt(F[2]))


@inlined
def unwhiten(F, w):
    """L^-T D^-1/2 w: S^-1 e for w = whiten(F, e)."""
    z = w[2] / math.sqrt(F[2])
    y = w[1] / math.sqrt(F[1]) - F[5] * z
    return (w[0] / math.sqrt(F[0]) - F[3] * y - F[4] * z, y, z)


@inlined
def pass_joint(m, d, row, i, at, coefficient):
    """Take a row's wrench past joint i: its whitened response to d.reach from `at` on, the rest to the parent.

    `coefficient` is the row's effort in the joint itself (couplings).
    """
    kind = m.body_joint[i]

    if d.held[i] > 0.0:
        for k in range(joints.n_v(kind)):
            d.reach[at + k] = 0.0

    elif kind == joints.REVOLUTE or kind == joints.PRISMATIC:
        axis = al.vec3(d.axis, i)
        wrench = al.vec3(d.passed_moment, i) if kind == joints.REVOLUTE else al.vec3(d.passed_force, i)
        e = coefficient + al.dot(axis, wrench)
        D = d.D[6 * i]
        d.reach[at] = e / math.sqrt(D)
        d.row_size[row] += al.dot(wrench, wrench) / D
        subtract_scaled(d, i, e / D, al.vec3(d.U_w, i), al.vec3(d.U_r, i))

    elif kind == joints.SPHERICAL:
        F = al.sym3(d.D, i)
        e3 = al.vec3(d.passed_moment, i)
        al.set_vec_at(d.reach, at, whiten(F, e3))
        al.set_vec3(d.passed_moment, i, al.ZERO3)
        al.add_vec3(d.passed_force, i, al.neg(al.matT_vec(al.mat3(d.H_a, i), al.sym_solve(F, e3))))

    else:
        force = al.vec3(d.passed_force, i)
        left = al.sub(al.vec3(d.passed_moment, i), al.mat_vec(al.mat3(d.N, i), force))
        al.set_vec_at(d.reach, at, whiten(al.sym3(d.D_M, i), force))
        al.set_vec_at(d.reach, at + 3, whiten(al.sym3(d.D, i), left))
        return

    parent = m.body_parent[i]
    force = al.vec3(d.passed_force, i)
    moment = al.add(al.vec3(d.passed_moment, i), al.cross(al.vec3(d.arm, i), force))
    al.add_vec3(d.passed_moment, parent, moment)
    al.add_vec3(d.passed_force, parent, force)


@kernel
def reach_rows(m, d):
    """R: whitened responses of all rows; needs write_rows and the articulated inertias of aba."""
    for c in range(m.n_constraint):
        first = m.constraint_path[c]
        end = first + m.constraint_paths[c]
        body_a = m.marker_body[m.constraint_from[c]]
        body_b = m.marker_body[m.constraint_to[c]]

        for k in range(m.constraint_rows[c]):
            row = m.constraint_row[c] + k
            at = m.constraint_reach[c] + k * m.constraint_width[c]
            d.row_size[row] = 0.0
            al.set_vec3(d.passed_moment, 0, al.ZERO3)
            al.set_vec3(d.passed_force, 0, al.ZERO3)

            for step in range(first, end):
                al.set_vec3(d.passed_moment, m.path_node[step], al.ZERO3)
                al.set_vec3(d.passed_force, m.path_node[step], al.ZERO3)

            al.add_vec3(d.passed_moment, body_a, al.vec3(d.row_moment_from, row))
            al.add_vec3(d.passed_force, body_a, al.vec3(d.row_force_from, row))
            al.add_vec3(d.passed_moment, body_b, al.vec3(d.row_moment_to, row))
            al.add_vec3(d.passed_force, body_b, al.vec3(d.row_force_to, row))

            if m.constraint_from_2[c] >= 0:
                body_a2 = m.marker_body[m.constraint_from_2[c]]
                body_b2 = m.marker_body[m.constraint_to_2[c]]
                al.add_vec3(d.passed_moment, body_a2, al.vec3(d.row_moment_from_2, row))
                al.add_vec3(d.passed_force, body_a2, al.vec3(d.row_force_from_2, row))
                al.add_vec3(d.passed_moment, body_b2, al.vec3(d.row_moment_to_2, row))
                al.add_vec3(d.passed_force, body_b2, al.vec3(d.row_force_to_2, row))

            for step in range(end - 1, first - 1, -1):
                i = m.path_node[step]
                pass_joint(m, d, row, i, at + m.path_at[step], rows.effort_on(m, row, i))


@inlined
def product(m, d, row, other):
    """Element (row, other) of R R^T: over the joints that both rows reach."""
    c = m.row_constraint[row]
    e = m.row_constraint[other]
    at = m.constraint_reach[c] + (row - m.constraint_row[c]) * m.constraint_width[c]
    to = m.constraint_reach[e] + (other - m.constraint_row[e]) * m.constraint_width[e]
    total = 0.0

    if c == e:
        for k in range(m.constraint_width[c]):
            total += d.reach[at + k] * d.reach[to + k]

        return total

    step = m.constraint_path[c]
    end = step + m.constraint_paths[c]
    turn = m.constraint_path[e]
    last = turn + m.constraint_paths[e]

    while step < end and turn < last:
        i = m.path_node[step]
        j = m.path_node[turn]

        if i == j:
            x = at + m.path_at[step]
            y = to + m.path_at[turn]

            for k in range(joints.n_v(m.body_joint[i])):
                total += d.reach[x + k] * d.reach[y + k]

            step += 1
            turn += 1
        elif i < j:
            step += 1
        else:
            turn += 1

    return total


@inlined
def largest_of_kind(m, d, row):
    """Largest diagonal element among the rows of the same kind in the same constraint."""
    c = m.row_constraint[row]
    size = 0.0

    for other in range(m.constraint_row[c], m.constraint_row[c] + m.constraint_rows[c]):
        if m.row_kind[other] == m.row_kind[row]:
            size = max(size, d.row_diagonal[other])

    return size


@kernel
def factor_rows(m, d):
    """L D L^T of R R^T in its envelope; returns how many rows were dropped, structurally redundant ones not counted.

    The factor's unit rows overwrite the envelope; pivot holds 1 / D, 0 where a row was dropped.
    """
    dropped = 0

    for i in range(m.n_row):
        d.row_diagonal[i] = product(m, d, i, i)

    for i in range(m.n_row):
        first = m.row_first[i]
        at = m.row_envelope[i] - first
        pivot = d.row_diagonal[i]

        # unscaled row of L, then scaled
        for j in range(first, i):
            to = m.row_envelope[j] - m.row_first[j]
            value = product(m, d, i, j)

            for k in range(max(first, m.row_first[j]), j):
                value -= d.envelope[at + k] * d.envelope[to + k]

            d.envelope[at + j] = value

        for j in range(first, i):
            value = d.envelope[at + j]
            d.envelope[at + j] = value * d.pivot[j]
            pivot -= value * d.envelope[at + j]

        if d.row_redundant[i] > 0.0:
            d.pivot[i] = 0.0
        elif pivot > DROP * largest_of_kind(m, d, i) and pivot > NOISE * d.row_size[i]:
            d.pivot[i] = 1.0 / pivot
        else:
            d.pivot[i] = 0.0
            dropped += 1

    return dropped


@inlined
def solve_rows(m, d):
    """Multipliers of the right-hand side d.row_left: least changes in the metric of the inertia."""
    for i in range(m.n_row):
        at = m.row_envelope[i] - m.row_first[i]
        value = d.row_left[i]

        for j in range(m.row_first[i], i):
            value -= d.envelope[at + j] * d.multiplier[j]

        d.multiplier[i] = value

    for i in range(m.n_row):
        d.multiplier[i] *= d.pivot[i]

    for i in range(m.n_row - 1, -1, -1):
        at = m.row_envelope[i] - m.row_first[i]

        for j in range(m.row_first[i], i):
            d.multiplier[j] -= d.envelope[at + j] * d.multiplier[i]


@inlined
def gather_white(m, d):
    """R^T lambda."""
    for v in range(m.n_v):
        d.white[v] = 0.0

    for row in range(m.n_row):
        c = m.row_constraint[row]
        at = m.constraint_reach[c] + (row - m.constraint_row[c]) * m.constraint_width[c]
        factor = d.multiplier[row]

        for step in range(m.constraint_path[c], m.constraint_path[c] + m.constraint_paths[c]):
            i = m.path_node[step]

            for k in range(joints.n_v(m.body_joint[i])):
                d.white[m.body_v[i] + k] += factor * d.reach[at + m.path_at[step] + k]


@inlined
def respond(m, d):
    """Changes of v' (or of v, or q) and of the bodies' accelerations by the whitened efforts d.white."""
    al.set_vec3(d.change_alpha, 0, al.ZERO3)
    al.set_vec3(d.change_rdd, 0, al.ZERO3)

    for i in range(1, m.n_body):
        parent = m.body_parent[i]
        kind = m.body_joint[i]
        v = m.body_v[i]
        alpha = al.vec3(d.change_alpha, parent)
        rdd = al.add(al.vec3(d.change_rdd, parent), al.cross(alpha, al.vec3(d.arm, i)))

        if d.held[i] > 0.0:
            for k in range(joints.n_v(kind)):
                d.change[v + k] = 0.0

        elif kind == joints.REVOLUTE or kind == joints.PRISMATIC:
            D = d.D[6 * i]
            carried = al.dot(al.vec3(d.U_w, i), alpha) + al.dot(al.vec3(d.U_r, i), rdd)
            rate = d.white[v] / math.sqrt(D) - carried / D
            d.change[v] = rate

            if kind == joints.REVOLUTE:
                alpha = al.axpy(rate, al.vec3(d.axis, i), alpha)
            else:
                rdd = al.axpy(rate, al.vec3(d.axis, i), rdd)

        elif kind == joints.SPHERICAL:
            F = al.sym3(d.D, i)
            turned = unwhiten(F, al.vec_at(d.white, v))
            turned = al.sub(turned, al.sym_solve(F, al.mat_vec(al.mat3(d.H_a, i), rdd)))
            al.set_vec_at(d.change, v, al.matT_vec(al.mat3(d.joint_axes, i), al.sub(turned, alpha)))
            alpha = turned

        else:
            axes = al.mat3(d.joint_axes, i)
            turned = unwhiten(al.sym3(d.D, i), al.vec_at(d.white, v + 3))
            moved = unwhiten(al.sym3(d.D_M, i), al.vec_at(d.white, v))
            moved = al.sub(moved, al.matT_vec(al.mat3(d.N, i), turned))
            al.set_vec_at(d.change, v, al.matT_vec(axes, al.sub(moved, rdd)))
            al.set_vec_at(d.change, v + 3, al.matT_vec(axes, al.sub(turned, alpha)))
            alpha = turned
            rdd = moved

        al.set_vec3(d.change_alpha, i, alpha)
        al.set_vec3(d.change_rdd, i, rdd)


@inlined
def row_acceleration(m, d, row):
    """g'' of a row by the bodies' accelerations and its bias."""
    c = m.row_constraint[row]
    a = m.marker_body[m.constraint_from[c]]
    b = m.marker_body[m.constraint_to[c]]
    total = d.row_bias[row]
    total += al.dot(al.vec3(d.row_moment_from, row), al.vec3(d.alpha, a))
    total += al.dot(al.vec3(d.row_force_from, row), al.vec3(d.rdd, a))
    total += al.dot(al.vec3(d.row_moment_to, row), al.vec3(d.alpha, b))
    total += al.dot(al.vec3(d.row_force_to, row), al.vec3(d.rdd, b))

    if m.row_kind[row] == rows.COUPLING:
        total += coupling_acceleration(m, d, row, c)

    return total


@inlined
def coupling_acceleration(m, d, row, c):
    """What a coupling's coordinates in the tree, and the bodies of its second coordinate, add to g''."""
    total = 0.0

    for side in range(2):
        k = m.row_i[row] if side == 0 else m.row_j[row]

        if k >= 0 and m.coordinate_kind[k] == coordinates.IN_TREE:
            v = m.n_q + m.body_v[m.coordinate_body[k]]
            total += m.row_value[2 * row + side] * d.x_rate[v]

    if m.constraint_from_2[c] >= 0:
        a = m.marker_body[m.constraint_from_2[c]]
        b = m.marker_body[m.constraint_to_2[c]]
        total += al.dot(al.vec3(d.row_moment_from_2, row), al.vec3(d.alpha, a))
        total += al.dot(al.vec3(d.row_force_from_2, row), al.vec3(d.rdd, a))
        total += al.dot(al.vec3(d.row_moment_to_2, row), al.vec3(d.alpha, b))
        total += al.dot(al.vec3(d.row_force_to_2, row), al.vec3(d.rdd, b))

    return total


@inlined
def add_changes(m, d):
    """Add the response to v' and to the bodies' accelerations."""
    for v in range(m.n_v):
        d.x_rate[m.n_q + v] += d.change[v]

    for i in range(1, m.n_body):
        al.add_vec3(d.alpha, i, al.vec3(d.change_alpha, i))
        al.add_vec3(d.rdd, i, al.vec3(d.change_rdd, i))
