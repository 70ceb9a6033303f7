"""Dynamics by the joint-space mass matrix: M = J^T M J by composite bodies, its Cholesky factor, rows in joint coordinates.

The embedding technique (docs/theory.md 7), n^3 in the number of coordinates. What it leaves in d means the same as what the
articulated-body passes leave: x_rate, the bodies' accelerations, whitened responses of the rows.
"""

import math


from .. import joints
from ..forces import shared_water
from ..joints import passing, rotors, virtual
from ..language import apart, inlined, kernel
from ..math import algebra as al
from ..motion import kinematics, markers
from ..status import OK
from ..signatures import DATA, MODEL, boolean, int64, void
from . import inertia, inverse, multipliers, rows

# a body takes part in a motion when it moves at more than this part of the fastest
MOVES = 1e-6

# pivots that fall below this part of their diagonal elements are looked at more closely
SUSPECT = 1e-6


@kernel
def crba(m, d, mass_matrix):
    """Joint-space mass matrix [n_v * n_v], by rows, by composite bodies; needs kinematics and inertias.

    docs/theory.md 7.1; Featherstone 2008, table 6.2.
    """
    inertia.start_articulated(m, d)

    for k in range(m.n_v * m.n_v):
        mass_matrix[k] = 0.0

    for i in range(m.n_body - 1, 0, -1):
        I = al.sym3(d.I_a, i)
        H = al.mat3(d.H_a, i)
        M = al.sym3(d.M_a, i)

        if m.body_parent[i] > 0:
            passing.add_inertia(d, m.body_parent[i], al.vec3(d.arm, i), I, H, M)

        for k in range(joints.n_v(m.body_joint[i])):
            S_w, S_r = joints.subspace(m, d, i, k)
            column = m.body_v[i] + k
            moment = al.add(al.sym_vec(I, S_w), al.mat_vec(H, S_r))
            force = al.add(al.matT_vec(H, S_w), al.sym_vec(M, S_r))
            j = i

            while j > 0:
                for l in range(joints.n_v(m.body_joint[j])):
                    T_w, T_r = joints.subspace(m, d, j, l)
                    row = m.body_v[j] + l
                    value = al.dot(T_w, moment) + al.dot(T_r, force)
                    mass_matrix[m.n_v * row + column] = value
                    mass_matrix[m.n_v * column + row] = value

                moment = al.add(moment, al.cross(al.vec3(d.arm, j), force))
                j = m.body_parent[j]

    for k in range(m.n_rotor):
        add_rotor(m, d, mass_matrix, m.rotor_body[k])

    if m.n_shared_water > 0:
        shared_water.add_to_mass_matrix(m, d, mass_matrix)

    if d.weighs[0] > 0.0:
        for i in range(1, m.n_body):
            if joints.is_one_axis(m.body_joint[i]):
                mass_matrix[(m.n_v + 1) * m.body_v[i]] += d.weight[m.body_v[i]]


@inlined
def add_rotor(m, d, mass_matrix, i):
    """What the rotor that turns with body i's joint adds to the mass matrix (docs/theory.md 5.5)."""
    v = m.body_v[i]
    mass_matrix[(m.n_v + 1) * v] += rotors.inertia(m, i)
    moment = al.scale(rotors.coupling(m, i), al.vec3(d.axis, i))
    j = m.body_parent[i]

    while j > 0:
        for l in range(joints.n_v(m.body_joint[j])):
            row = m.body_v[j] + l
            value = al.dot(joints.subspace(m, d, j, l)[0], moment)
            mass_matrix[m.n_v * row + v] += value
            mass_matrix[m.n_v * v + row] += value

        j = m.body_parent[j]


@apart(int64(MODEL, DATA))
def factor(m, d):
    """M = L L^T into d.mass_matrix (lower triangle, by rows). Held joints stand apart as if of unit inertia. Returns a status.

    What moves without inertia is lent some (virtual.py).
    """
    n = m.n_v
    more = True
    v = 0

    while more:
        crba(m, d, d.mass_matrix)
        more = lend_to_joints(m, d)

        if more:
            continue

        set_held_apart(m, d)
        v = cholesky(d.mass_matrix, n, d.change)

        if v < 0:
            return OK

        if not d.mass_matrix[n * v + v] >= -al.ROUNDING:
            return passing.no_inertia(d.mass_matrix[n * v + v], body_of(m, v))

        more = lend_to_idle(m, d)

    return passing.no_inertia(0.0, body_of(m, v))


@inlined
def set_held_apart(m, d):
    """Rows and columns of held joints in the mass matrix to those of the unit matrix."""
    n = m.n_v
    M = d.mass_matrix

    for i in range(1, m.n_body):
        if d.held[i] > 0.0:
            for v in range(m.body_v[i], m.body_v[i] + joints.n_v(m.body_joint[i])):
                for k in range(n):
                    M[n * v + k] = 0.0
                    M[n * k + v] = 0.0

                M[n * v + v] = 1.0


@inlined
def cholesky(L, n, x):
    """L of L L^T in place, with the inverses of its diagonal there: what is solved by it is many. Returns the first coordinate
    whose pivot is none, -1: all are good.

    Such a pivot is left in its place, in parts of what there is along the motion x that it belongs to.
    """
    for j in range(n):
        diagonal = L[n * j + j]

        for k in range(j + 1):
            value = L[n * j + k]

            for l in range(k):
                value -= L[n * j + l] * L[n * k + l]

            if k < j:
                L[n * j + k] = value * L[n * k + k]
            elif value > SUSPECT * diagonal:
                L[n * j + j] = 1.0 / math.sqrt(value)
            else:
                size = diagonal + idle_motion(L, n, j, x)

                if not value > al.ROUNDING * size:
                    L[n * j + j] = value / size if size > 0.0 else size
                    return j

                L[n * j + j] = 1.0 / math.sqrt(value)

    return -1


@kernel
def idle_motion(L, n, v, x):
    """The motion x with x_v = 1 whose inertia x . M x is the pivot of v: L^T x = 0 above v, nothing moves below.

    Returns the inertia that the coordinates above v have in it each by itself: what the pivot is left of.
    """
    for k in range(n):
        x[k] = -L[n * v + k] if k < v else 0.0

    x[v] = 1.0
    size = 0.0

    for j in range(v - 1, -1, -1):
        x[j] *= L[n * j + j]

        for k in range(j):
            x[k] -= L[n * j + k] * x[j]

        for k in range(j):
            size += L[n * j + k] * L[n * j + k] * x[j] * x[j]

        size += x[j] * x[j] / (L[n * j + j] * L[n * j + j])

    return size


@kernel
def lend_to_joints(m, d):
    """Bodies on spherical and free joints that lack inertia, with all they carry, are lent some. True when there are such."""
    found = False

    for i in range(1, m.n_body):
        kind = m.body_joint[i]

        if d.held[i] > 0.0:
            continue

        if kind == joints.SPHERICAL and joints.spherical.lacks_inertia(d, i):
            found = virtual.lend(m, d, i, False) > 0.0 or found

        elif kind == joints.FREE and not joints.free.factor(d, i):
            found = joints.free.lend(m, d, i) or found

    return found


@kernel
def lend_to_idle(m, d):
    """Bodies that take part in the motion d.change, which has no inertia, are lent some. True when there are such.

    Those that turn, if there are any; else those without mass that slide.
    """
    move_bodies(m, d)
    mass, inertia = virtual.measure(m, d)
    turned = 0.0
    moved = 0.0

    for i in range(1, m.n_body):
        turned = max(turned, al.norm(al.vec3(d.change_alpha, i)))
        moved = max(moved, al.norm(al.vec3(d.change_rdd, i)))

    turns = turned * math.sqrt(inertia / mass) > MOVES * moved
    found = False

    for i in range(1, m.n_body):
        if turns:
            if al.norm(al.vec3(d.change_alpha, i)) > MOVES * turned:
                found = virtual.lend(m, d, i, False) > 0.0 or found

        elif d.body_m[i] == 0.0 and al.norm(al.vec3(d.change_rdd, i)) > MOVES * moved:
            found = virtual.lend(m, d, i, True) > 0.0 or found

    return found


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

        b[at + j] = value * L[n * j + j]


@inlined
def solve_upper(L, n, b):
    """b[:n] = L^-T b."""
    for j in range(n - 1, -1, -1):
        value = b[j] * L[n * j + j]
        b[j] = value

        for k in range(j):
            b[k] -= L[n * j + k] * value


@apart(int64(MODEL, DATA))
def forward(m, d):
    """v' = M^-1 (tau - bias) into d.v_rate, and the bodies' accelerations. Returns a status."""
    failure = factor(m, d)

    if failure != OK:
        return failure

    for i in range(1, m.n_body):
        for k in range(joints.n_v(m.body_joint[i]) if d.held[i] == 0.0 else 0):
            d.v_rate[m.body_v[i] + k] = 0.0

    if d.lends[0] > 0.0:
        kinematics.accelerations(m, d)
        virtual.add_bias(m, d)

    inverse.rnea(m, d, d.change)

    for v in range(m.n_v):
        d.change[v] = d.tau[v] - d.change[v]

    for i in range(1, m.n_body):
        for k in range(joints.n_v(m.body_joint[i]) if d.held[i] > 0.0 else 0):
            d.change[m.body_v[i] + k] = 0.0

    solve_lower(d.mass_matrix, m.n_v, d.change, 0)
    solve_upper(d.mass_matrix, m.n_v, d.change)

    for i in range(1, m.n_body):
        for k in range(joints.n_v(m.body_joint[i]) if d.held[i] == 0.0 else 0):
            d.v_rate[m.body_v[i] + k] = d.change[m.body_v[i] + k]

    kinematics.accelerations(m, d)
    return OK


@inlined
def add_jacobian(m, d, row, r, i, moment, force):
    """Efforts S^T (moment, force) that a wrench about body i's origin means in all joints below it, onto the row of d.response.

    Adds to row_size what they could be if the wrench, whose force acts at r, met the axes of these joints.
    """
    n = m.n_v

    while i > 0:
        kind = m.body_joint[i]
        v = m.body_v[i]

        for k in range(joints.n_v(kind) if d.held[i] == 0.0 else 0):
            S_w, S_r = joints.subspace(m, d, i, k)
            inverse = d.mass_matrix[n * (v + k) + v + k]
            d.response[row * n + v + k] += al.dot(S_w, moment) + al.dot(S_r, force)

            if joints.is_one_axis(kind):
                lever = al.sub(r, al.vec3(d.r, i))
                d.row_size[row] += joints.largest_effort(kind, moment, force, lever) * (inverse * inverse)

        moment = al.add(moment, al.cross(al.vec3(d.arm, i), force))
        i = m.body_parent[i]


@inlined
def least_pivot(m, d, v, n):
    """Least square of the factor's diagonal elements v to v + n; infinite when there are none."""
    most = 0.0

    for k in range(v, v + n):
        most = max(most, d.mass_matrix[(m.n_v + 1) * k])

    return 1.0 / (most * most) if most > 0.0 else math.inf


@inlined
def pivots(m, d, i):
    """(kg m2, kg) least pivots of the joint-space inertia about joint i, of turning and of sliding; infinite where it does neither."""
    kind = m.body_joint[i]
    v = m.body_v[i]

    if d.held[i] > 0.0:
        return math.inf, math.inf

    slides = 0

    while joints.slides(kind, slides) and slides < joints.n_v(kind):
        slides += 1

    return least_pivot(m, d, v + slides, joints.n_v(kind) - slides), least_pivot(m, d, v, slides)


@apart(void(MODEL, DATA, boolean))
def respond_to_rows(m, d, everything):
    """Rows of C L^-T, each over all velocity coordinates; redundant ones only with `everything`."""
    n = m.n_v

    for c in range(m.n_constraint):
        r = markers.position(m, d, m.constraint_to[c])
        d.constraint_noise[c] = 0.0

        for step in range(m.constraint_path[c], m.constraint_path[c] + m.constraint_paths[c]):
            turning, sliding = pivots(m, d, m.path_node[step])
            square = multipliers.arm_square(d, m.path_node[step], r)
            d.constraint_noise[c] += (1.0 + square) * (1.0 / turning) + 1.0 / sliding

    for row in range(m.n_row):
        c = m.row_constraint[row]
        at = row * n

        if multipliers.is_idle(d, row, everything):
            continue

        d.row_size[row] = 0.0

        for v in range(n):
            d.response[at + v] = 0.0

        a = m.marker_body[m.constraint_from[c]]
        b = m.marker_body[m.constraint_to[c]]
        r = markers.position(m, d, m.constraint_to[c])
        add_jacobian(m, d, row, r, a, al.vec3(d.row_moment_from, row), al.vec3(d.row_force_from, row))
        add_jacobian(m, d, row, r, b, al.vec3(d.row_moment_to, row), al.vec3(d.row_force_to, row))

        if m.row_kind[row] == rows.COUPLING:
            for t in range(m.row_term[row], rows.last_term(m, row)):
                i = rows.body_of_term(m, t)

                if i > 0:
                    d.response[at + m.body_v[i]] += m.term_factor[t] if d.held[i] == 0.0 else 0.0
                elif t > m.row_term[row]:
                    a, b = rows.bodies_of_term(m, t)
                    add_jacobian(
                        m, d, row, r, a, al.vec3(d.term_moment_from, t), al.vec3(d.term_force_from, t)
                    )
                    add_jacobian(m, d, row, r, b, al.vec3(d.term_moment_to, t), al.vec3(d.term_force_to, t))

        solve_lower(d.mass_matrix, n, d.response, at)


@kernel
def whiten_wrenches(m, d):
    """Whitened efforts d.white of wrenches on all bodies (passed_moment, passed_force), which are gone then."""
    for i in range(m.n_body - 1, 0, -1):
        moment = al.vec3(d.passed_moment, i)
        force = al.vec3(d.passed_force, i)

        for k in range(joints.n_v(m.body_joint[i])):
            S_w, S_r = joints.subspace(m, d, i, k)
            effort = al.dot(S_w, moment) + al.dot(S_r, force)
            d.white[m.body_v[i] + k] = effort if d.held[i] == 0.0 else 0.0

        al.add_vec3(d.passed_moment, m.body_parent[i], al.add(moment, al.cross(al.vec3(d.arm, i), force)))
        al.add_vec3(d.passed_force, m.body_parent[i], force)

    solve_lower(d.mass_matrix, m.n_v, d.white, 0)


@kernel
def respond(m, d):
    """Changes of v' by the whitened efforts d.white, and those of the bodies' accelerations."""
    for v in range(m.n_v):
        d.change[v] = d.white[v]

    solve_upper(d.mass_matrix, m.n_v, d.change)
    move_bodies(m, d)


@kernel
def move_bodies(m, d):
    """The bodies' accelerations change_alpha and change_rdd by the velocity coordinates' d.change."""
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
