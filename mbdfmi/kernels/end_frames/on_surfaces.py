"""Contacts on a surface: of a point, or of a convex surface that touches it, or rolls on it (docs/theory.md 10.3 to 10.5).

The parameters s1, s2 of the first marker's surface are the unknowns: at the contact, e has no part along r1 and r2. A convex
surface of the second marker is there where its outward normal is contrary to that of the first one: that is a function of s1, s2,
and a point is one of no size. On round surfaces the unknown is the unit vector u, which follows s in d.z, and its longitude and
latitude s1, s2 are read off; so are those of the second surface, s3 and s4. Their rates tell the turns, nothing depends on them.

Legend: a, b the first and second marker; e from a's surface to b's point; w_a, w_b the bodies' angular velocities; "seen" = relative
to a's body, of the point of b's body that is at the contact. Vectors are in a's axes but where it says "in O".
"""

from typing import NamedTuple

from ..language import inlined, kernel
from ..math import algebra as al
from ..motion import coordinates, markers
from . import convex, surfaces

Vector = tuple[float, float, float]
Matrix = tuple[Vector, Vector, Vector]

IDENTITY = ((1.0, 0.0, 0.0), (0.0, 1.0, 0.0), (0.0, 0.0, 1.0))

# curvature is believed where it leaves this part of the metric: else the point found may be the
# farthest
TRUSTED = 0.1

# surfaces that touch in a point: as far, at least, as this part of the metric
PARTED = 1e-4


@inlined
def solve2(a, b, c, d, e, f):
    """(x, y) of a x + b y = e, c x + d y = f."""
    det = a * d - b * c
    return (e * d - b * f) / det, (a * f - e * c) / det


@kernel
def seen_motion(m, d, k, r):
    """Velocity and acceleration, seen from a, of the point of b's body that is at r (m, in O).

    The acceleration is that when the bodies have none. Both in O.
    """
    i = m.marker_body[m.end_frame_a[k]]
    j = m.marker_body[m.end_frame_b[k]]
    w_a = al.vec3(d.w, i)
    w_b = al.vec3(d.w, j)
    P = al.sub(r, al.vec3(d.r, i))
    p = al.sub(r, al.vec3(d.r, j))
    v_a = al.cross(w_a, P)
    v_b = al.cross(w_b, p)
    seen = al.sub(al.add(al.vec3(d.rd, j), v_b), al.add(al.vec3(d.rd, i), v_a))
    swing = al.sub(al.cross(w_b, v_b), al.cross(w_a, v_a))
    return seen, al.sub(swing, al.scale(2.0, al.cross(w_a, seen)))


class OnSurface(NamedTuple):
    """What touches a surface, at its parameters. A: a's axes to O, r: b's point (m, from O, in O); e: to it from a's surface; r1 ...
    r22: derivatives of this by its parameters, or by those of its chart; n: its unit normal, n1, n2: derivatives of this; B: b's axes
    to a's, normal: of b's surface outwards, in b's axes, C: its point by that, 0 of a point.
    """

    A: Matrix
    r: Vector
    e: Vector
    r1: Vector
    r2: Vector
    r11: Vector
    r12: Vector
    r22: Vector
    n: Vector
    n1: Vector
    n2: Vector
    B: Matrix
    normal: Vector
    C: Matrix


class Motion(NamedTuple):
    """How a contact moves. seen: velocity, bias: acceleration of b's point, seen; w: w_b - w_a; x1, x2: rates of the parameters, or
    of those of the chart; n_rate: of the normal, shift: velocity of b's point on b's surface.
    """

    seen: Vector
    bias: Vector
    w: Vector
    x1: float
    x2: float
    n_rate: Vector
    shift: Vector


@inlined
def round_at(m, k):
    """Where u of contact k's first surface stands in z; -1: it is not round."""
    if not surfaces.is_round(m, m.end_frame_from[k]):
        return -1

    return m.end_frame_z[k] + (2 if m.end_frame_to[k] < 0 else 4)


@inlined
def unit_at(d, at):
    """The unit vector u that stands there in z; between steps it is nearly one."""
    u = al.vec_at(d.z, at)
    return al.scale(1.0 / al.norm(u), u)


@inlined
def place(m, d, k):
    """(r, r1, r2, r11, r12, r22) of contact k's first surface at its parameters."""
    at = round_at(m, k)

    if at >= 0:
        return surfaces.around(m, m.end_frame_from[k], unit_at(d, at))

    s = m.end_frame_z[k]
    return surfaces.point(m, m.end_frame_from[k], d.z[s], d.z[s + 1])


@inlined
def by_parameters(m, d, k):
    """(s1, s2, r, r1, r2, r11, r12, r22) of contact k's first surface by its parameters themselves, which fail at poles."""
    s = m.end_frame_z[k]
    at = round_at(m, k)
    s1 = d.z[s]
    s2 = d.z[s + 1]

    # what z holds of these tells but the turn
    if at >= 0:
        s1, s2 = surfaces.bearing(unit_at(d, at))

    r, r1, r2, r11, r12, r22 = surfaces.point(m, m.end_frame_from[k], s1, s2)
    return s1, s2, r, r1, r2, r11, r12, r22


@inlined
def surface_rates(v, r1, r2):
    """(s1', s2') of a point that moves with v along a surface; 0 where these are singular."""
    a = al.dot(r1, r1)
    b = al.dot(r1, r2)
    c = al.dot(r2, r2)

    if a * c - b * b <= 1e-24 * (a + c) * (a + c):
        return 0.0, 0.0

    return solve2(a, b, b, c, al.dot(r1, v), al.dot(r2, v))


@inlined
def across(n, length, x):
    """The part of x / length that is normal to the unit vector n."""
    return al.scale(1.0 / length, al.axpy(-al.dot(n, x), n, x))


@kernel
def on_surface(m, d, k):
    """What touches a surface in contact k (OnSurface); without a side it is a point. Needs kinematics."""
    a = m.end_frame_a[k]
    b = m.end_frame_b[k]
    A = markers.axes(m, d, a)
    r_b = markers.position(m, d, b)
    r, r1, r2, r11, r12, r22 = place(m, d, k)
    n = al.cross(r1, r2)
    length = al.norm(n)
    n = al.scale(1.0 / length, n)
    n1 = across(n, length, al.add(al.cross(r11, r2), al.cross(r1, r12)))
    n2 = across(n, length, al.add(al.cross(r12, r2), al.cross(r1, r22)))
    e = al.sub(al.matT_vec(A, al.sub(r_b, markers.position(m, d, a))), r)
    side = d.end_frame_side[k]

    if m.end_frame_to[k] < 0 or side == 0.0:
        zero = (al.ZERO3, al.ZERO3, al.ZERO3)
        return OnSurface(A, r_b, e, r1, r2, r11, r12, r22, n, n1, n2, IDENTITY, al.ZERO3, zero)

    n = al.scale(side, n)
    B = markers.relative_axes(m, d, a, b)
    normal = al.neg(al.matT_vec(B, n))
    c, C = convex.support(m, m.end_frame_to[k], normal)
    c = al.mat_vec(B, c)
    return OnSurface(
        A,
        al.add(r_b, al.mat_vec(A, c)),
        al.add(e, c),
        r1,
        r2,
        r11,
        r12,
        r22,
        n,
        al.scale(side, n1),
        al.scale(side, n2),
        B,
        normal,
        C,
    )


@inlined
def shifted(on, turn):
    """How far b's point shifts on its surface where that's normal turns by `turn`."""
    return al.mat_vec(on.B, al.mat_vec(on.C, al.matT_vec(on.B, turn)))


@inlined
def metric(on):
    """r_i . r_j of the surface: of 11, 12, 22."""
    return al.dot(on.r1, on.r1), al.dot(on.r1, on.r2), al.dot(on.r2, on.r2)


@inlined
def tangency(on, bent):
    """Derivatives of -r1.e and -r2.e by the parameters: a, b, c, d of [[a, b], [c, d]]; without `bent`, as if e were zero."""
    s1 = shifted(on, on.n1)
    s2 = shifted(on, on.n2)
    g11, g12, g22 = metric(on)
    a = g11 + al.dot(on.r1, s1)
    b = g12 + al.dot(on.r1, s2)
    c = g12 + al.dot(on.r2, s1)
    d = g22 + al.dot(on.r2, s2)

    if not bent:
        return a, b, c, d

    twist = al.dot(on.r12, on.e)
    return a - al.dot(on.r11, on.e), b - twist, c - twist, d - al.dot(on.r22, on.e)


@inlined
def is_regular(on, J, part):
    """Whether J leaves that part of the metric."""
    g11, g12, g22 = metric(on)
    return J[0] > part * g11 and J[0] * J[3] - J[1] * J[2] > part * (g11 * g22 - g12 * g12)


@kernel
def newton(m, d, k):
    """Newton's step of contact k's parameters, or of those of its chart."""
    on = on_surface(m, d, k)
    f = al.dot(on.r1, on.e)
    g = al.dot(on.r2, on.e)
    J = tangency(on, True)

    if not is_regular(on, J, TRUSTED):
        J = tangency(on, False)

    if not is_regular(on, J, TRUSTED):
        g11, g12, g22 = metric(on)
        J = (g11, g12, g12, g22)

    return solve2(J[0], J[1], J[2], J[3], f, g)


@inlined
def move(m, d, k, x1, x2):
    """Contact k's parameters, or those of its chart, moved by x1 and x2. Returns how large they are."""
    at = round_at(m, k)

    if at >= 0:
        u = unit_at(d, at)
        e1, e2 = surfaces.tangents(u)
        u = al.add(u, al.axpy(x1, e1, al.scale(x2, e2)))
        al.set_vec_at(d.z, at, al.scale(1.0 / al.norm(u), u))
        return 1.0, 1.0

    s = m.end_frame_z[k]
    d.z[s] += x1
    d.z[s + 1] += x2
    return abs(d.z[s]), abs(d.z[s + 1])


@inlined
def read_bearings(m, d, k):
    """Longitudes and latitudes that contact k's parameters are, each on the turn closest to the one before."""
    s = m.end_frame_z[k]
    at = round_at(m, k)

    if at >= 0:
        longitude, latitude = surfaces.bearing(unit_at(d, at))
        d.z[s] = coordinates.unwrapped(longitude, d.z[s])
        d.z[s + 1] = latitude

    if m.end_frame_to[k] >= 0:
        on = on_surface(m, d, k)
        longitude, latitude = surfaces.bearing(convex.bearer(m, m.end_frame_to[k], on.normal))
        d.z[s + 2] = coordinates.unwrapped(longitude, d.z[s + 2])
        d.z[s + 3] = latitude


@inlined
def aim_at(m, d, k):
    """u of a round surface where s1 and s2 say."""
    at = round_at(m, k)

    if at >= 0:
        s = m.end_frame_z[k]
        al.set_vec_at(d.z, at, surfaces.direction(d.z[s], d.z[s + 1]))


@kernel
def motion(m, d, k, on):
    """How contact k moves (Motion). Needs kinematics."""
    seen, bias = seen_motion(m, d, k, on.r)
    seen = al.matT_vec(on.A, seen)
    w = al.sub(al.vec3(d.w, m.marker_body[m.end_frame_b[k]]), al.vec3(d.w, m.marker_body[m.end_frame_a[k]]))
    w = al.matT_vec(on.A, w)
    turn = al.cross(w, on.n)
    v = al.add(seen, shifted(on, turn))
    J = tangency(on, True)
    g11, g12, g22 = metric(on)
    x1 = 0.0
    x2 = 0.0

    # where a surface's parameters are singular they stand
    if g11 * g22 - g12 * g12 > 1e-24 * (g11 + g22) * (g11 + g22):
        x1, x2 = solve2(J[0], J[1], J[2], J[3], al.dot(on.r1, v), al.dot(on.r2, v))

    n_rate = al.axpy(x1, on.n1, al.scale(x2, on.n2))
    return Motion(seen, al.matT_vec(on.A, bias), w, x1, x2, n_rate, shifted(on, al.sub(turn, n_rate)))


@inlined
def chart_rate(u, x1, x2):
    """u' by the rates of its chart's parameters."""
    e1, e2 = surfaces.tangents(u)
    return al.axpy(x1, e1, al.scale(x2, e2))


@inlined
def parameter_rates(m, d, k, on, moves):
    """s1' to s4' of a contact that moves so."""
    at = round_at(m, k)
    one = (moves.x1, moves.x2)
    two = (0.0, 0.0)

    if at >= 0:
        u = unit_at(d, at)
        one = surfaces.bearing_rates(u, chart_rate(u, moves.x1, moves.x2))

    if m.end_frame_to[k] >= 0:
        j = m.end_frame_to[k]
        turn = al.matT_vec(on.B, al.sub(al.cross(moves.w, on.n), moves.n_rate))
        two = surfaces.bearing_rates(convex.bearer(m, j, on.normal), convex.bearer(m, j, turn))

    return one[0], one[1], two[0], two[1]


@kernel
def rates(m, d, k):
    """s1' to s4' of contact k; of a point s3' and s4' are zero. Needs kinematics."""
    on = on_surface(m, d, k)
    return parameter_rates(m, d, k, on, motion(m, d, k, on))


@kernel
def write_rates(m, d, k):
    """The rates of all that stands in z of contact k. Needs kinematics."""
    s = m.end_frame_z[k]
    on = on_surface(m, d, k)
    moves = motion(m, d, k, on)
    rate = parameter_rates(m, d, k, on, moves)
    at = round_at(m, k)
    d.z_rate[s] = rate[0]
    d.z_rate[s + 1] = rate[1]

    if m.end_frame_to[k] >= 0:
        d.z_rate[s + 2] = rate[2]
        d.z_rate[s + 3] = rate[3]

    if at >= 0:
        al.set_vec_at(d.z_rate, at, chart_rate(unit_at(d, at), moves.x1, moves.x2))


@kernel
def row(m, d, k, i):
    """Row i of contact k: (direction u in O, point of contact in O, g, g', g'' at zero accelerations). Needs kinematics.

    0 keeps it touching, 1 and 2 keep it from slipping.
    """
    on = on_surface(m, d, k)
    moves = motion(m, d, k, on)
    u = on.n
    u_rate = moves.n_rate
    gap = al.dot(u, on.e)

    # what rolls does not move there: how the direction turns does not matter
    if i > 0:
        gap = 0.0
        u = al.scale(1.0 / al.norm(on.r1), on.r1)
        u_rate = al.ZERO3

    if i == 2:
        u = al.cross(on.n, u)

    bias = al.dot(u, al.add(moves.bias, al.cross(moves.w, moves.shift))) + al.dot(u_rate, moves.seen)
    return al.mat_vec(on.A, u), on.r, gap, al.dot(u, moves.seen), bias


@kernel
def aiming_couple(m, d, k, u):
    """Moment on b, in O, by which the part of e along u changes where b turns and s stays; u in O."""
    on = on_surface(m, d, k)
    return al.mat_vec(on.A, al.cross(on.n, shifted(on, al.matT_vec(on.A, u))))


@kernel
def touches_in_a_point(m, d, k):
    """Whether what touches in contact k lies closer to the surface there than anywhere near."""
    on = on_surface(m, d, k)
    return is_regular(on, tangency(on, True), PARTED) and not convex.lies_flat(
        m, m.end_frame_to[k], on.normal
    )


@inlined
def point_of(m, d, k, on):
    """b's point, from a's origin."""
    return al.matT_vec(on.A, al.sub(on.r, markers.position(m, d, m.end_frame_a[k])))


@inlined
def side_of(m, d, k):
    """1 or -1: on which side of the surface b's origin is, with s at its closest point."""
    on = on_surface(m, d, k)
    return -1.0 if al.dot(on.n, on.e) < 0.0 else 1.0


@inlined
def reach(m, k):
    """How far from b's origin contact k may be (m)."""
    return convex.size(m, m.end_frame_to[k]) if m.end_frame_to[k] >= 0 else 0.0
