"""What follows from parameters alone: the inertia of each node, checked."""

import math

from .forces import composite_lines, sea, six_by_six, waves
from .language import apart, inlined, kernel
from .math import algebra as al
from .motion import coordinates
from .signatures import DATA, MODEL, int64
from .status import (
    BAD_ABSOLUTE_TOLERANCE,
    BAD_EFFORT,
    BAD_INERTIA,
    BAD_MASS,
    BAD_MAX_EVALUATIONS,
    BAD_PARAMETER,
    BAD_ROTOR,
    BAD_SEA,
    BAD_SOLVER_SETTING,
    BAD_TOLERANCE,
    OK,
    status,
)
from .steppers import memory

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
def prepare_added_mass(m, d, k):
    """Blocks of linear force k's added mass, about its second marker, in the axes that `added_mass.axes` turns."""
    M = block(m.six_by_six_added, k, 0, 0)
    H = block(m.six_by_six_added, k, 1, 0)
    I = block(m.six_by_six_added, k, 1, 1)

    if m.six_by_six_axes[k] != six_by_six.HEADING:
        A = al.mat3(
            m.marker_A,
            m.six_by_six_to[k] if m.six_by_six_axes[k] == six_by_six.BODY else m.six_by_six_from[k],
        )
        A_T = al.transpose(A)
        M = al.mat_mat(al.mat_mat(A, M), A_T)
        H = al.mat_mat(al.mat_mat(A, H), A_T)
        I = al.mat_mat(al.mat_mat(A, I), A_T)

    al.set_sym3(d.added_I, k, al.sym_of_mat(I))
    al.set_mat3(d.added_H, k, H)
    al.set_sym3(d.added_M, k, al.sym_of_mat(M))


@inlined
def has_finite_inertia(d, i):
    """Whether all that was summed up for node i is finite: then the sum is, and nothing in it cancels to NaN."""
    total = d.body_m[i]

    for k in range(3):
        total += abs(d.body_h[3 * i + k])

    for k in range(6):
        total += abs(d.body_I[6 * i + k])

    return math.isfinite(total)


@inlined
def has_finite_added_mass(d, k):
    """Whether all blocks of force k's added mass are finite."""
    total = 0.0

    for j in range(6):
        total += abs(d.added_I[6 * k + j]) + abs(d.added_M[6 * k + j])

    for j in range(9):
        total += abs(d.added_H[9 * k + j])

    return math.isfinite(total)


@inlined
def node_moved(m, c):
    """The node that an effort along coordinate c acts on."""
    in_tree = m.coordinate_kind[c] == coordinates.IN_TREE
    return m.coordinate_body[c] if in_tree else m.marker_body[m.coordinate_to[c]]


@kernel
def wrongly_moved(m):
    """The node that a spring, damper, stop, friction or line acts on whose constants no scene may have; -1: all are right."""
    for k in range(m.n_joint_spring):
        if not (m.joint_stiffness[k] >= 0.0 and m.joint_damping[k] >= 0.0):
            return node_moved(m, m.joint_spring_coordinate[k])

    for k in range(m.n_stop):
        if not (m.stop_stiffness[k] >= 0.0 and m.stop_damping[k] >= 0.0):
            return node_moved(m, m.stop_coordinate[k])

    for k in range(m.n_friction):
        dry = m.friction_coulomb[k] >= 0.0 and m.friction_static[k] >= 0.0 and m.friction_viscous[k] >= 0.0

        if not (dry and m.friction_stribeck[k] > 0.0 and m.friction_smoothing[k] > 0.0):
            return node_moved(m, m.friction_coordinate[k])

    for k in range(m.n_strut):
        if not (m.strut_stiffness[k] >= 0.0 and m.strut_damping[k] >= 0.0):
            return m.marker_body[m.strut_to[k]]

    for k in range(m.n_line):
        finite = math.isfinite(m.line_length[k] + m.line_mass[k] + m.line_stiffness[k])

        if not (finite and m.line_length[k] > 0.0 and m.line_mass[k] > 0.0 and m.line_stiffness[k] > 0.0):
            return m.marker_body[m.line_to[k]]

    for k in range(m.n_composite):
        if not composite_lines.is_line(m, k):
            return m.marker_body[m.composite_to[k]]

    return -1


@inlined
def find_lightness(m, d):
    """How light the lightest node is beside the heaviest, nodes without mass left out."""
    least = math.inf
    most = 0.0

    for i in range(1, m.n_body):
        most = max(most, d.body_m[i])

        if d.body_m[i] > 0.0:
            least = min(least, d.body_m[i])

    d.lightness[0] = least / most if most > 0.0 else 1.0


@apart(int64(MODEL, DATA), "mbdfmi_prepare")
def prepare(m, d):
    """To be called after any parameter changed: node inertias from the solids' and the added masses, into the state. Returns a status."""
    zero = (0.0, 0.0, 0.0, 0.0, 0.0, 0.0)
    d.notices[0] = 0.0
    memory.forget(d)
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

    find_lightness(m, d)

    for k in range(m.n_six_by_six):
        prepare_added_mass(m, d, k)

        if not has_finite_added_mass(d, k):
            return status(BAD_PARAMETER, m.marker_body[m.six_by_six_to[k]])

    for k in range(m.n_rotor):
        if not (
            m.rotor_inertia[k] >= 0.0
            and math.isfinite(m.rotor_inertia[k] * m.rotor_ratio[k] * m.rotor_ratio[k])
        ):
            return status(BAD_ROTOR, m.rotor_body[k])

    for i in range(m.n_body):
        if not has_finite_inertia(d, i):
            return status(BAD_PARAMETER, i)

    if m.n_sea > 0 and not (sea.is_one(m) and waves.are_known(m)):
        return status(BAD_SEA, 0)

    wrong = wrongly_moved(m)

    if wrong >= 0:
        return status(BAD_EFFORT, wrong)

    return OK
