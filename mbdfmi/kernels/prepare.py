"""What follows from parameters alone: the inertia of each node, checked."""

import math

from . import algebra as al
from . import control
from .language import inlined, kernel
from .status import (
    BAD_ABSOLUTE_TOLERANCE,
    BAD_INERTIA,
    BAD_MASS,
    BAD_MAX_EVALUATIONS,
    BAD_PARAMETER,
    BAD_SOLVER_SETTING,
    BAD_TOLERANCE,
    OK,
    status,
)

# below, rounding is all there is; above, errors are no longer small against the motion
LEAST_TOLERANCE = 1e-14
LARGEST_TOLERANCE = 0.1


@inlined
def is_semidefinite(S):
    """True when no principal minor of S is negative beyond rounding (False for NaN)."""
    size = S[0] + S[1] + S[2]
    eps = 1e-9 * size
    xy = S[0] * S[1] - S[3] * S[3]
    xz = S[0] * S[2] - S[4] * S[4]
    yz = S[1] * S[2] - S[5] * S[5]
    det = S[0] * yz - S[3] * (S[3] * S[2] - S[5] * S[4]) + S[4] * (S[3] * S[5] - S[1] * S[4])
    ok = S[0] >= -eps and S[1] >= -eps and S[2] >= -eps
    ok = ok and xy >= -eps * size and xz >= -eps * size and yz >= -eps * size
    return ok and det >= -eps * size * size


@inlined
def block(p, k, row, column):
    """3x3 block (row, column) of the 6x6 matrix k of p."""
    j = 36 * k + 18 * row + 3 * column
    return (al.vec_at(p, j), al.vec_at(p, j + 6), al.vec_at(p, j + 12))


@inlined
def add_added_mass(m, d, k):
    """Added mass of linear force k, given at its second marker, to the node: blocks shifted to the node's origin.

    With the point at p and V_p = (w, rd - p~ w): M' = M, H' = H + p~ M, I' = I + p~ H^T - H' p~.
    """
    b = m.linear_to[k]
    i = m.marker_body[b]
    A = al.mat3(m.marker_A, b)
    A_T = al.transpose(A)
    p = al.skew(al.vec3(m.marker_r, b))
    M = al.mat_mat(al.mat_mat(A, block(m.linear_added, k, 0, 0)), A_T)
    H = al.mat_mat(al.mat_mat(A, block(m.linear_added, k, 1, 0)), A_T)
    I = al.mat_mat(al.mat_mat(A, block(m.linear_added, k, 1, 1)), A_T)
    shifted = al.mat_add(H, al.mat_mat(p, M))
    I = al.mat_add(I, al.mat_sub(al.mat_mat(p, al.transpose(H)), al.mat_mat(shifted, p)))
    al.set_sym3(d.body_added_I, i, al.sym_add(al.sym3(d.body_added_I, i), al.sym_of_mat(I)))
    al.set_mat3(d.body_added_H, i, al.mat_add(al.mat3(d.body_added_H, i), shifted))
    al.set_sym3(d.body_added_M, i, al.sym_add(al.sym3(d.body_added_M, i), al.sym_of_mat(M)))


@inlined
def has_finite_inertia(d, i):
    """Whether all that was summed up for node i is finite: then the sum is, and nothing in it cancels to NaN."""
    total = d.body_m[i]

    for k in range(3):
        total += abs(d.body_h[3 * i + k])

    for k in range(6):
        total += abs(d.body_I[6 * i + k]) + abs(d.body_added_I[6 * i + k]) + abs(d.body_added_M[6 * i + k])

    for k in range(9):
        total += abs(d.body_added_H[9 * i + k])

    return math.isfinite(total)


@kernel
def prepare(m, d):
    """To be called after any parameter changed: node inertias from the solids' and the added masses, into the state. Returns a status."""
    zero = (0.0, 0.0, 0.0, 0.0, 0.0, 0.0)
    d.notices[0] = 0.0
    control.forget(d)
    d.jacobian_known[0] = 0.0

    if not LEAST_TOLERANCE <= m.tolerance[0] <= LARGEST_TOLERANCE:
        return status(BAD_TOLERANCE, 0)

    if not LEAST_TOLERANCE <= m.absolute_tolerance[0] <= LARGEST_TOLERANCE:
        return status(BAD_ABSOLUTE_TOLERANCE, 0)

    if not m.max_evaluations[0] >= 1.0:
        return status(BAD_MAX_EVALUATIONS, 0)

    if not (m.step[0] > 0.0 and m.max_step[0] > 0.0):
        return status(BAD_SOLVER_SETTING, 0)

    for i in range(m.n_body):
        d.body_m[i] = 0.0
        al.set_vec3(d.body_h, i, al.ZERO3)
        al.set_sym3(d.body_I, i, zero)
        al.set_sym3(d.body_added_I, i, zero)
        al.set_mat3(d.body_added_H, i, (al.ZERO3, al.ZERO3, al.ZERO3))
        al.set_sym3(d.body_added_M, i, zero)

    for k in range(m.n_solid):
        i = m.solid_body[k]
        mass = m.solid_mass[k]
        I = al.sym3(m.solid_inertia, k)

        if not mass >= 0.0:
            return status(BAD_MASS, i)

        if not is_semidefinite(I):
            return status(BAD_INERTIA, i)

        A = al.mat3(m.solid_A, k)
        com = al.add(al.vec3(m.solid_r, k), al.mat_vec(A, al.vec3(m.solid_com, k)))
        d.body_m[i] += mass
        al.add_vec3(d.body_h, i, al.scale(mass, com))
        about_origin = al.sym_add(al.sym_rotate(A, I), al.sym_point(mass, com))
        al.set_sym3(d.body_I, i, al.sym_add(al.sym3(d.body_I, i), about_origin))

    for k in range(m.n_linear):
        if m.linear_adds[k] == 1:
            add_added_mass(m, d, k)

    for i in range(m.n_body):
        if not has_finite_inertia(d, i):
            return status(BAD_PARAMETER, i)

    return OK
