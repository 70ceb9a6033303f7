"""Constraint rows: what each says of the motion of its two markers.

A row's Jacobian is a pair of wrenches, one on each body (moment about the body's origin, force; inertial axes): its power on
the bodies' velocities is g'. `row_gap` is g, `row_rate` g', `row_bias` g'' at zero accelerations.

Legend: a, b the first and second marker; u a direction; d = r_b - r_a; P, p levers from the bodies' origins to r_b;
"seen" = relative to a's body. The equations are in docs/theory.md 9; the reaction acts on the material point
of the first body that is where the second's is (docs/theory.md 9.1).
"""

import math
from typing import NamedTuple

from ..end_frames import frames, touching
from ..language import apart, inlined
from ..math import algebra as al
from ..motion import coordinates, drives, markers
from ..signatures import DATA, MODEL, int64, void

Vector = tuple[float, float, float]
Matrix = tuple[Vector, Vector, Vector]

POINT = 0  # d stays normal to axis i of a
DOT = 1  # the cosine of the angle from axis i of a to axis j of b stays value: 0, normal to each other
DISTANCE = 2  # |d| stays value
KNIFE = 3  # velocity of b's origin as seen from a has no component along axis j of b
ROLL_SPHERE = 4  # a sphere of radius value about b's origin rolls on the plane z = 0 of a: component i
ROLL_DISK = 5  # a thin disk of radius value about z of b rolls there: component i
COUPLING = 6  # sum of factor c over its terms + offset = target of a drive or 0, c joint coordinates
CONTACT = 7  # row i of contact j
TWIST = 8  # b's axes are a's turned about a direction normal to z: no twist
FRAME = 9  # row i of those that keep b's axes to those of end frame j
SLIP = 10  # row i of contact j, of velocities: one of the two along which it does not slip


@inlined
def is_of_velocity(m, row):
    """Whether a row says nothing of positions."""
    kind = m.row_kind[row]
    return kind == KNIFE or kind == SLIP or ((kind == ROLL_SPHERE or kind == ROLL_DISK) and m.row_i[row] < 2)


@inlined
def is_of_axes(m, row):
    """Whether a row is about axes alone: its gap is an angle."""
    kind = m.row_kind[row]
    return kind == DOT or kind == TWIST or kind == FRAME


@inlined
def set_row(d, row, moment_a, force_a, moment_b, force_b):
    """Store a row's wrenches."""
    al.set_vec3(d.row_moment_from, row, moment_a)
    al.set_vec3(d.row_force_from, row, force_a)
    al.set_vec3(d.row_moment_to, row, moment_b)
    al.set_vec3(d.row_force_to, row, force_b)


@inlined
def set_residuals(d, row, gap, rate, bias):
    """Store a row's residuals, the position's from where it rests."""
    d.row_gap[row] = gap - d.row_rest[row]
    d.row_rate[row] = rate
    d.row_bias[row] = bias


@inlined
def set_push(d, row, u, P, p):
    """A row whose wrenches are unit forces along u on b, -u on a, at levers p and P."""
    set_row(d, row, al.cross(u, P), al.neg(u), al.cross(p, u), u)


@inlined
def centripetal(w, lever):
    """w x (w x lever): acceleration of a body's point at zero alpha and rdd."""
    return al.cross(w, al.cross(w, lever))


@inlined
def axis_of(A, k):
    """Column k of a rotation matrix, by a choice that is not an index."""
    if k == 0:
        return al.column(A, 0)

    if k == 1:
        return al.column(A, 1)

    return al.column(A, 2)


@inlined
def rolling_contact(kind, radius, A_a, w_a, A_b, w_b):
    """Contact point of a rolling sphere or disk from b's origin: (lever, its time derivative), inertial axes.

    On a disk it is the rim's point nearest to the plane: -radius along m, the plane's normal N made normal to
    the disk's axis z. A negative radius stands for the other side of the plane.
    """
    N = al.column(A_a, 2)
    N_rate = al.cross(w_a, N)

    if kind == ROLL_SPHERE:
        return al.scale(-radius, N), al.scale(-radius, N_rate)

    z = al.column(A_b, 2)
    z_rate = al.cross(w_b, z)
    y = al.axpy(-al.dot(N, z), z, N)
    y_rate = al.axpy(-al.dot(N_rate, z) - al.dot(N, z_rate), z, N_rate)
    y_rate = al.axpy(-al.dot(N, z), z_rate, y_rate)
    length = al.norm(y)
    m = al.scale(1.0 / length, y)
    m_rate = al.scale(1.0 / length, al.axpy(-al.dot(m, y_rate), m, y_rate))
    return al.scale(-radius, m), al.scale(-radius, m_rate)


@inlined
def last_term(m, row):
    """Beyond a coupling's last term; the first is row_term."""
    return m.row_term[row] + m.row_terms[row]


@inlined
def body_of_term(m, t):
    """Body whose joint in the tree has the coordinate of term t; 0: the coordinate closes a loop."""
    return m.coordinate_body[m.term_coordinate[t]]


@inlined
def bodies_of_term(m, t):
    """Bodies of the first and the second marker of the coordinate of term t, where that closes a loop."""
    k = m.term_coordinate[t]
    return m.marker_body[m.coordinate_from[k]], m.marker_body[m.coordinate_to[k]]


@inlined
def write_coupling(m, d, row):
    """A coupling of joint coordinates, or the drive of one: factor c summed over its terms + offset = target of the drive.

    Coordinates in the tree take efforts instead of wrenches (effort_on). The row's wrenches are those of its first coordinate,
    those of the others stand with their terms.
    """
    gap = m.row_offset[row]
    rate = 0.0
    bias = 0.0
    set_row(d, row, al.ZERO3, al.ZERO3, al.ZERO3, al.ZERO3)

    for t in range(m.row_term[row], last_term(m, row)):
        k = m.term_coordinate[t]
        factor = m.term_factor[t]
        gap += factor * coordinates.value(m, d, k)
        rate += factor * coordinates.rate(m, d, k)
        bias += factor * coordinates.bias(m, d, k)

        if body_of_term(m, t) > 0:
            continue

        moment_a, force_a, moment_b, force_b = coordinates.wrenches(m, d, k, factor)

        if t == m.row_term[row]:
            set_row(d, row, moment_a, force_a, moment_b, force_b)
        else:
            al.set_vec3(d.term_moment_from, t, moment_a)
            al.set_vec3(d.term_force_from, t, force_a)
            al.set_vec3(d.term_moment_to, t, moment_b)
            al.set_vec3(d.term_force_to, t, force_b)

    if m.row_drive[row] >= 0:
        position, speed, acceleration = drives.target(m, d, m.row_drive[row])
        gap -= position
        rate -= speed
        bias -= acceleration

    # its offset is still to be found
    if d.row_settles[row] > 0.0:
        gap = 0.0

    set_residuals(d, row, gap, rate, bias)


@inlined
def start_turns(m, d):
    """Angles outside the tree near which to start: as given, or where their drives want them."""
    for t in range(m.n_turn):
        twists = m.coordinate_kind[m.turn_coordinate[t]] == coordinates.TWIST
        d.z[coordinates.turn(m, t)] = coordinates.HALF_TURN if twists else m.turn_start[t]

    for row in range(m.n_row):
        t = m.coordinate_turn[m.term_coordinate[m.row_term[row]]] if m.row_drive[row] >= 0 else -1

        if t >= 0:
            position, _, _ = drives.target(m, d, m.row_drive[row])
            d.z[coordinates.turn(m, t)] = position


@inlined
def start_parameters(m, d):
    """Parameters of end frames where their drives want them."""
    for row in range(m.n_row):
        c = m.term_coordinate[m.row_term[row]] if m.row_drive[row] >= 0 else -1

        if c >= 0 and m.coordinate_kind[c] == coordinates.PARAMETER:
            position, _, _ = drives.target(m, d, m.row_drive[row])
            d.z[m.end_frame_z[m.coordinate_end_frame[c]]] = position


@inlined
def effort_on(m, row, i):
    """A coupling's effort in the joint of body i, for a unit multiplier; 0 for other rows."""
    effort = 0.0

    for t in range(m.row_term[row], last_term(m, row)):
        if body_of_term(m, t) == i:
            effort += m.term_factor[t]

    return effort


@inlined
def turn_left(kind, A_a, A_b):
    """Rotation vector (rad, inertial axes) that brings a's axes, or with `kind` 1 its z axis, to b's, where it is beyond 90 deg; else 0.

    The rows are products of axes: they vanish also where axes are antiparallel, or have changed places.
    """
    if kind == 1:
        z_a = al.column(A_a, 2)
        z_b = al.column(A_b, 2)
        n = al.cross(z_a, z_b)
        s = al.norm(n)
        c = al.dot(z_a, z_b)

        if c >= 0.0:
            return al.ZERO3

        return al.scale(math.atan2(s, c) / s, n) if s > 0.0 else al.scale(math.pi, al.column(A_a, 0))

    E = al.matrix_E(al.mat_mat(A_b, al.transpose(A_a)))
    s = math.sqrt(E[0] * E[0] + E[1] * E[1] + E[2] * E[2])

    if s <= abs(E[3]):
        return al.ZERO3

    angle = 2.0 * math.atan2(s, abs(E[3])) * (1.0 if E[3] >= 0.0 else -1.0)
    return al.scale(angle / s, (E[0], E[1], E[2]))


@inlined
def aim_parallel(d, row, turn, e_i, e_j):
    """While assembling, a row of axes more than 90 deg apart: what is left to turn, about its axis at the end. e_i, e_j : of a."""
    u = al.cross(e_j, e_i)
    set_row(d, row, al.neg(u), al.ZERO3, u, al.ZERO3)
    set_residuals(d, row, al.dot(turn, u), 0.0, 0.0)


@inlined
def write_twist(d, row, A_a, A_b, w_a, w_b):
    """No twist from a to b about z: x_a . y_b = y_a . x_b (docs/theory.md 9.3)."""
    x_a = al.column(A_a, 0)
    y_a = al.column(A_a, 1)
    x_b = al.column(A_b, 0)
    y_b = al.column(A_b, 1)
    w = al.sub(w_b, w_a)
    n = al.sub(al.cross(y_b, x_a), al.cross(x_b, y_a))
    n_rate = al.add(al.cross(al.cross(w_b, y_b), x_a), al.cross(y_b, al.cross(w_a, x_a)))
    n_rate = al.sub(n_rate, al.cross(al.cross(w_b, x_b), y_a))
    n_rate = al.sub(n_rate, al.cross(x_b, al.cross(w_a, y_a)))
    gap = al.dot(x_a, y_b) - al.dot(y_a, x_b)
    along = al.dot(x_a, x_b) + al.dot(y_a, y_b)

    # while assembling beyond 90 deg, where the equation leads to the contrary: the twist itself
    if d.assembling[0] > 0.0 and along < 0.0:
        n = al.neg(al.add(al.column(A_a, 2), al.column(A_b, 2)))
        gap = 0.5 * al.dot(n, n) * math.atan2(gap, along)

    set_row(d, row, al.neg(n), al.ZERO3, n, al.ZERO3)
    set_residuals(d, row, gap, al.dot(w, n), al.dot(w, n_rate))


@inlined
def write_frame(m, d, c, row, A_b, w_b, p):
    """All rows that keep the axes of constraint c's second marker to those of an end frame, from row on (docs/theory.md 10.5).

    Products of axes as in DOT. The end frame turns as its point moves along the curve or surface, so that beside their moments
    there is a force along that on the point. p: its lever on the second body.
    """
    k = m.row_j[row]
    free = m.row_parallel[row] == 1
    e = frames.moving(m, d, k, free)
    E = e.E

    # the axis about which a spin may be free comes last
    if m.end_frame_kind[k] == touching.ON_CURVE:
        E = ((E[0][1], E[0][2], E[0][0]), (E[1][1], E[1][2], E[1][0]), (E[2][1], E[2][2], E[2][0]))

    body_a = m.marker_body[m.constraint_from[c]]
    P = al.sub(e.r, al.vec3(d.r, body_a))
    w = al.sub(w_b, e.w)
    turn = turn_left(m.row_parallel[row], E, A_b) if d.assembling[0] > 0.0 else al.ZERO3

    for at in range(row, m.constraint_row[c] + m.constraint_rows[c]):
        # all axes parallel: x y, y z, z x; two z alone: x z, y z
        i = at - row
        j = 2 if free else (i + 1) % 3
        e_a = axis_of(E, i)
        e_b = axis_of(A_b, j)
        n = al.cross(e_b, e_a)
        n_rate = al.add(al.cross(al.cross(w_b, e_b), e_a), al.cross(e_b, al.cross(e.w, e_a)))
        force = al.neg(frames.push(m, d, k, free, n))
        moment = al.add(n, al.cross(p, force))
        set_row(d, at, al.neg(al.add(n, al.cross(P, force))), al.neg(force), moment, force)
        set_residuals(d, at, al.dot(e_a, e_b), al.dot(w, n), al.dot(w, n_rate) - al.dot(n, e.alpha))

        if al.dot(turn, turn) > 0.0:
            aim_parallel(d, at, turn, e_a, axis_of(E, j))


class Pair(NamedTuple):
    """The two markers of a constraint, vectors in O. A_a, A_b: axes; w_a, w_b: angular velocities; span: d; P, p: levers; r_b, v_b:
    position and velocity of the second; seen: of that, as seen; swing: its acceleration as seen at zero accelerations, but for Coriolis'.
    """

    A_a: Matrix
    A_b: Matrix
    w_a: Vector
    w_b: Vector
    span: Vector
    P: Vector
    p: Vector
    r_b: Vector
    v_b: Vector
    seen: Vector
    swing: Vector


@inlined
def pair_of(m, d, c):
    """The markers of constraint c (Pair); needs kinematics."""
    a = m.constraint_from[c]
    b = m.constraint_to[c]
    body_a = m.marker_body[a]
    body_b = m.marker_body[b]
    w_a = al.vec3(d.w, body_a)
    w_b = al.vec3(d.w, body_b)
    r_b = markers.position(m, d, b)
    span = al.sub(r_b, markers.position(m, d, a))
    P = al.sub(r_b, al.vec3(d.r, body_a))
    p = al.sub(r_b, al.vec3(d.r, body_b))
    v_b = markers.velocity(m, d, b)
    seen = al.sub(v_b, markers.point_velocity(m, d, body_a, r_b))
    swing = al.sub(centripetal(w_b, p), centripetal(w_a, P))
    return Pair(markers.axes(m, d, a), markers.axes(m, d, b), w_a, w_b, span, P, p, r_b, v_b, seen, swing)


@apart(void(MODEL, DATA, int64))
def aim_row(m, d, row):
    """While assembling, a row of axes that are more than 90 deg apart aims at what is left to turn; needs kinematics."""
    c = m.row_constraint[row]
    A_a = markers.axes(m, d, m.constraint_from[c])
    turn = turn_left(m.row_parallel[row], A_a, markers.axes(m, d, m.constraint_to[c]))

    if al.dot(turn, turn) > 0.0:
        aim_parallel(d, row, turn, axis_of(A_a, m.row_i[row]), axis_of(A_a, m.row_j[row]))


@inlined
def write_point(d, row, i, pair):
    """A row of kind POINT."""
    u = axis_of(pair.A_a, i)
    set_push(d, row, u, pair.P, pair.p)
    bias = al.dot(u, al.sub(pair.swing, al.scale(2.0, al.cross(pair.w_a, pair.seen))))
    set_residuals(d, row, al.dot(u, pair.span), al.dot(u, pair.seen), bias)


@inlined
def write_dot(m, d, row, i, j, pair):
    """A row of kind DOT."""
    e_a = axis_of(pair.A_a, i)
    e_b = axis_of(pair.A_b, j)
    e_a_rate = al.cross(pair.w_a, e_a)
    e_b_rate = al.cross(pair.w_b, e_b)
    n = al.cross(e_b, e_a)
    w = al.sub(pair.w_b, pair.w_a)
    n_rate = al.add(al.cross(e_b_rate, e_a), al.cross(e_b, e_a_rate))
    set_row(d, row, al.neg(n), al.ZERO3, n, al.ZERO3)
    set_residuals(d, row, al.dot(e_a, e_b) - m.row_value[row], al.dot(w, n), al.dot(w, n_rate))

    if d.assembling[0] > 0.0 and m.row_parallel[row] > 0:
        aim_row(m, d, row)


@inlined
def has_hinge_rows_alone(m, c):
    """Whether all rows of constraint c are of the two kinds that pins, ball joints and their like are made of."""
    for row in range(m.constraint_row[c], m.constraint_row[c] + m.constraint_rows[c]):
        if m.row_kind[row] != POINT and m.row_kind[row] != DOT:
            return False

    return True


@apart(void(MODEL, DATA, int64))
def write_rows_of(m, d, c):
    """All rows of constraint c, of whatever kind."""
    pair = pair_of(m, d, c)
    a = m.constraint_from[c]
    body_a = m.marker_body[a]
    body_b = m.marker_body[m.constraint_to[c]]
    w_a = pair.w_a
    w_b = pair.w_b
    v_b = pair.v_b

    for row in range(m.constraint_row[c], m.constraint_row[c] + m.constraint_rows[c]):
        kind = m.row_kind[row]
        i = m.row_i[row]
        j = m.row_j[row]

        if kind == POINT:
            write_point(d, row, i, pair)

        elif kind == DOT:
            write_dot(m, d, row, i, j, pair)

        elif kind == TWIST:
            write_twist(d, row, pair.A_a, pair.A_b, w_a, w_b)

        elif kind == DISTANCE:
            length = m.row_value[row]
            u = al.scale(1.0 / length, pair.span)
            v = al.sub(v_b, markers.velocity(m, d, a))
            lever = markers.arm(m, d, a)
            set_push(d, row, u, lever, pair.p)
            gap = 0.5 * (al.dot(pair.span, pair.span) / length - length) if d.row_settles[row] == 0.0 else 0.0
            bias = al.dot(v, v) / length
            bias += al.dot(u, al.sub(centripetal(w_b, pair.p), centripetal(w_a, lever)))
            set_residuals(d, row, gap, al.dot(u, v), bias)

        elif kind == KNIFE:
            u = axis_of(pair.A_b, j)
            swept = al.cross(w_a, al.sub(v_b, al.vec3(d.rd, body_a)))
            bias = al.dot(u, al.sub(centripetal(w_b, pair.p), swept))
            bias += al.dot(al.cross(w_b, u), pair.seen)
            set_push(d, row, u, pair.P, pair.p)
            set_residuals(d, row, 0.0, al.dot(u, pair.seen), bias)

        elif kind == COUPLING:
            write_coupling(m, d, row)

        elif kind == FRAME:
            if i == 0:
                write_frame(m, d, c, row, pair.A_b, w_b, pair.p)

        elif kind == CONTACT or kind == SLIP:
            u, r_c, gap, rate, bias = touching.row(m, d, j, i)
            set_push(d, row, u, al.sub(r_c, al.vec3(d.r, body_a)), al.sub(r_c, al.vec3(d.r, body_b)))
            set_residuals(d, row, gap, rate, bias)

            if d.aim[j] > 0.0:
                couple = touching.aiming_couple(m, d, j, u)
                al.add_vec3(d.row_moment_from, row, al.neg(couple))
                al.add_vec3(d.row_moment_to, row, couple)

        else:
            u = axis_of(pair.A_a, i)
            radius = d.row_side[row] * m.row_value[row]
            to_contact, to_contact_rate = rolling_contact(kind, radius, pair.A_a, w_a, pair.A_b, w_b)
            r_c = al.add(pair.r_b, to_contact)
            v_c = al.add(v_b, to_contact_rate)
            slip = al.sub(
                markers.point_velocity(m, d, body_b, r_c), markers.point_velocity(m, d, body_a, r_c)
            )
            bias = al.sub(
                al.cross(w_b, al.sub(v_c, al.vec3(d.rd, body_b))),
                al.cross(w_a, al.sub(v_c, al.vec3(d.rd, body_a))),
            )
            gap = al.dot(u, al.add(pair.span, to_contact)) if i == 2 else 0.0
            set_push(d, row, u, al.add(pair.P, to_contact), al.add(pair.p, to_contact))
            set_residuals(d, row, gap, al.dot(u, slip), al.dot(u, bias) + al.dot(al.cross(w_a, u), slip))


@apart(void(MODEL, DATA))
def write_rows(m, d):
    """All rows' wrenches and residuals; needs kinematics.

    Hinges, which close most loops, stand here: among all kinds in one function they would take half as long again.
    """
    touching.find_ways(m, d)

    for c in range(m.n_constraint):
        if not has_hinge_rows_alone(m, c):
            write_rows_of(m, d, c)
            continue

        pair = pair_of(m, d, c)

        for row in range(m.constraint_row[c], m.constraint_row[c] + m.constraint_rows[c]):
            if m.row_kind[row] == POINT:
                write_point(d, row, m.row_i[row], pair)
            else:
                write_dot(m, d, row, m.row_i[row], m.row_j[row], pair)
