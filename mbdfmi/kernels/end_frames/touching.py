"""Joints of end frames on curves and surfaces: where they touch, and what their rows say.

A contact's parameters s stand in d.z. They are those of the closest point (of a
curve or surface to a marker's origin) or of the common tangent (of two curves): exactly so after
every accepted step, where Newton's method finds them anew. In between they are integrated; their
rates follow from the velocities. Only on a sphere, whose parameters are singular at its poles,
they are read off instead, and nothing depends on them; the longitude is integrated along to tell
its turn.

The reaction acts at the material points that are where the contact is (docs/theory.md 9.1); the
equations are in docs/theory.md 10.3 and 10.4.

Legend: a, b the first and second marker; e from the point on a's curve or surface to b's point;
t, tt derivatives of r(s); n a normal; "seen" = relative to a's body, of the point of b's body
that is at the contact.
"""

import math
from typing import NamedTuple


from ..language import apart, inlined, kernel
from ..math import algebra as al
from ..motion import coordinates, markers
from ..signatures import DATA, MODEL, void
from . import curves, surfaces

Vector = tuple[float, float, float]
Matrix = tuple[Vector, Vector, Vector]

ON_CURVE = 0
CURVES = 1
ON_SURFACE = 2

KINDS = {
    "point_on_curve": ON_CURVE,
    "curve_on_curve": CURVES,
    "point_on_surface": ON_SURFACE,
    "frame_on_curve": ON_CURVE,
    "frame_on_surface": ON_SURFACE,
}

MAX_ITERATIONS = 30

# Newton's method has found s when it moves less than this part
ROUNDING = 1e-15

# curvature is believed where it leaves this part of the metric: else the point found may be the
# farthest
TRUSTED = 0.1

# error (rad) of a longitude on a sphere that is just allowed: it need but tell the turn
LONGITUDE_ALLOWED = 0.3

# samples of a curve, and of each side of a pair, in the search for a start
SAMPLES = 128
PAIR_SAMPLES = 64


@inlined
def is_sphere(m, k):
    """Whether contact k is a point on a sphere."""
    return m.end_frame_kind[k] == ON_SURFACE and m.surface_kind[m.end_frame_from[k]] == surfaces.SPHERE


@kernel
def seen_motion(m, d, k, r):
    """Velocity and acceleration, seen from a, of the point of b's body that is at r (m, in O).

    The acceleration is that when the bodies have none.
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


@inlined
def solve2(a, b, c, d, e, f):
    """(x, y) of a x + b y = e, c x + d y = f."""
    det = a * d - b * c
    return (e * d - b * f) / det, (a * f - e * c) / det


@kernel
def curve_normal(m, k, t, i):
    """Axis j (i = 0) or k (i = 1) of the end frame on curve k where its tangent is t.

    By a fixed vector that the curve is never parallel to (docs/theory.md 10.1), so they pass points
    of inflection continuously.
    """
    tangent = al.scale(1.0 / al.norm(t), t)
    side = al.cross(tangent, al.vec3(m.curve_side, k))
    k_e = al.scale(1.0 / al.norm(side), side)
    return al.cross(k_e, tangent) if i == 0 else k_e


class OnCurve(NamedTuple):
    """A point on a curve at its parameter. A: a's axes to O, r: the point (m, from O, in O); in a's axes e: from the curve to the
    point, t, tt: derivatives of the curve by its parameter.
    """

    A: Matrix
    r: Vector
    e: Vector
    t: Vector
    tt: Vector


class OnSurface(NamedTuple):
    """Likewise of a point on a surface. r1 ... r22: derivatives of the surface by its parameters, in a's axes."""

    A: Matrix
    r: Vector
    e: Vector
    r1: Vector
    r2: Vector
    r11: Vector
    r12: Vector
    r22: Vector


class CurvePair(NamedTuple):
    """Two curves that touch, vectors in O. r: point on b's curve from O (m), e: to it from a's; tangent, n: unit tangent of a's
    curve, and normal in its plane, so that what separates the two planes does not count; length |t_a|, bend: n.tt_a; t_b, tt_b:
    derivatives of b's curve by its parameter.
    """

    r: Vector
    e: Vector
    tangent: Vector
    n: Vector
    length: float
    bend: float
    t_b: Vector
    tt_b: Vector


@kernel
def point_on_curve(m, d, k):
    """The point on a curve that contact k is (OnCurve). Needs kinematics."""
    a = m.end_frame_a[k]
    A = markers.axes(m, d, a)
    r_b = markers.position(m, d, m.end_frame_b[k])
    r, t, tt = curves.point(m, m.end_frame_from[k], d.z[m.end_frame_z[k]])
    e = al.sub(al.matT_vec(A, al.sub(r_b, markers.position(m, d, a))), r)
    return OnCurve(A, r_b, e, t, tt)


@kernel
def point_on_surface(m, d, k):
    """The point on a surface that contact k is (OnSurface). Needs kinematics."""
    a = m.end_frame_a[k]
    A = markers.axes(m, d, a)
    r_b = markers.position(m, d, m.end_frame_b[k])
    s = m.end_frame_z[k]
    r, r1, r2, r11, r12, r22 = surfaces.point(m, m.end_frame_from[k], d.z[s], d.z[s + 1])
    e = al.sub(al.matT_vec(A, al.sub(r_b, markers.position(m, d, a))), r)
    return OnSurface(A, r_b, e, r1, r2, r11, r12, r22)


@kernel
def curve_on_curve(m, d, k):
    """The two curves that contact k is (CurvePair). Needs kinematics."""
    a = m.end_frame_a[k]
    b = m.end_frame_b[k]
    A_a = markers.axes(m, d, a)
    A_b = markers.axes(m, d, b)
    s = m.end_frame_z[k]
    r_a, t_a, tt_a = curves.point(m, m.end_frame_from[k], d.z[s])
    r_b, t_b, tt_b = curves.point(m, m.end_frame_to[k], d.z[s + 1])
    r = al.add(markers.position(m, d, b), al.mat_vec(A_b, r_b))
    e = al.sub(r, al.add(markers.position(m, d, a), al.mat_vec(A_a, r_a)))
    length = al.norm(t_a)
    tangent = al.scale(1.0 / length, t_a)
    n = (-tangent[1], tangent[0], 0.0)
    return CurvePair(
        r,
        e,
        al.mat_vec(A_a, tangent),
        al.mat_vec(A_a, n),
        length,
        al.dot(n, tt_a),
        al.mat_vec(A_b, t_b),
        al.mat_vec(A_b, tt_b),
    )


@inlined
def tangency(pair):
    """Derivatives of -tangent.e and n.t_b of a CurvePair by s1 and s2: a, b, c, d of [[a, b], [c, d]]."""
    turn = pair.bend / pair.length
    along = al.dot(pair.tangent, pair.t_b)
    return pair.length - al.dot(pair.n, pair.e) * turn, -along, -along * turn, al.dot(pair.n, pair.tt_b)


@inlined
def surface_rates(v, r1, r2):
    """(s1', s2') of a point that moves with v along a surface; 0 where these are singular."""
    a = al.dot(r1, r1)
    b = al.dot(r1, r2)
    c = al.dot(r2, r2)

    if a * c - b * b <= 1e-24 * (a + c) * (a + c):
        return 0.0, 0.0

    return solve2(a, b, b, c, al.dot(r1, v), al.dot(r2, v))


@kernel
def rates(m, d, k):
    """(s1', s2') of contact k; of a point on a curve s2' is zero. Needs kinematics."""
    kind = m.end_frame_kind[k]

    if kind == ON_CURVE:
        at = point_on_curve(m, d, k)
        seen, _ = seen_motion(m, d, k, at.r)
        return al.dot(at.t, al.matT_vec(at.A, seen)) / al.dot(at.t, at.t), 0.0

    if kind == ON_SURFACE:
        on = point_on_surface(m, d, k)
        seen, _ = seen_motion(m, d, k, on.r)
        return surface_rates(al.matT_vec(on.A, seen), on.r1, on.r2)

    pair = curve_on_curve(m, d, k)
    seen, _ = seen_motion(m, d, k, pair.r)
    w = markers.angular_velocity(m, d, m.end_frame_b[k])
    w = al.sub(w, markers.angular_velocity(m, d, m.end_frame_a[k]))
    J = tangency(pair)
    return solve2(J[0], J[1], J[2], J[3], al.dot(pair.tangent, seen), -al.dot(pair.n, al.cross(w, pair.t_b)))


@inlined
def longitude_rate(m, d, k):
    """Rate (rad/s) of the longitude of a point on a sphere, 0 at the poles."""
    e = markers.relative_position(m, d, m.end_frame_a[k], m.end_frame_b[k])
    v = markers.relative_velocity(m, d, m.end_frame_a[k], m.end_frame_b[k])
    square = e[0] * e[0] + e[1] * e[1]
    return (e[0] * v[1] - e[1] * v[0]) / square if square > 1e-24 * al.dot(e, e) else 0.0


@apart(void(MODEL, DATA))
def parameter_rates(m, d):
    """s' of all contacts into d.z_rate; needs kinematics."""
    for k in range(m.n_end_frame):
        s = m.end_frame_z[k]

        if is_sphere(m, k):
            d.z_rate[s] = longitude_rate(m, d, k)
            d.z_rate[s + 1] = 0.0
            continue

        rate1, rate2 = rates(m, d, k)

        if m.end_frame_kind[k] == ON_CURVE:
            d.z_rate[s] = rate1
        else:
            d.z_rate[s] = rate1
            d.z_rate[s + 1] = rate2


@inlined
def span(m, d, k):
    """(point at the contact in O, e in inertial axes) with s as it is."""
    kind = m.end_frame_kind[k]

    if kind == ON_CURVE:
        at = point_on_curve(m, d, k)
        return at.r, al.mat_vec(at.A, at.e)

    if kind == ON_SURFACE:
        on = point_on_surface(m, d, k)
        return on.r, al.mat_vec(on.A, on.e)

    pair = curve_on_curve(m, d, k)
    along = al.scale(al.dot(pair.tangent, pair.e), pair.tangent)
    return pair.r, al.add(along, al.scale(al.dot(pair.n, pair.e), pair.n))


@kernel
def row(m, d, k, i):
    """Row i of contact k: (direction u, point of contact, g, g', g'' at zero accelerations).

    Needs kinematics. While a contact is aimed at given parameters its first row takes e itself to
    zero, and a second has nothing to say.
    """
    if d.aim[k] > 0.0:
        r, e = span(m, d, k)
        gap = al.norm(e)
        u = al.scale(1.0 / gap, e) if gap > 0.0 and i == 0 else al.ZERO3
        return u, r, al.dot(u, e), 0.0, 0.0

    if m.end_frame_kind[k] == ON_CURVE:
        at = point_on_curve(m, d, k)
        n = curve_normal(m, m.end_frame_from[k], at.t, i)
        u = al.mat_vec(at.A, n)
        seen, bias = seen_motion(m, d, k, at.r)
        rate = al.dot(at.t, al.matT_vec(at.A, seen)) / al.dot(at.t, at.t)
        return u, at.r, al.dot(n, at.e), al.dot(u, seen), al.dot(u, bias) - al.dot(n, at.tt) * rate * rate

    if is_sphere(m, k):
        a = m.end_frame_a[k]
        r = markers.position(m, d, m.end_frame_b[k])
        out = al.sub(r, markers.position(m, d, a))
        length = al.norm(out)
        u = al.scale(1.0 / length, out)
        seen, bias = seen_motion(m, d, k, r)
        away = al.dot(u, seen)
        bend = (al.dot(seen, seen) - away * away) / length
        return u, r, length - m.surface_value[2 * m.end_frame_from[k]], away, al.dot(u, bias) + bend

    if m.end_frame_kind[k] == ON_SURFACE:
        on = point_on_surface(m, d, k)
        n = al.cross(on.r1, on.r2)
        n = al.scale(1.0 / al.norm(n), n)
        u = al.mat_vec(on.A, n)
        seen, bias = seen_motion(m, d, k, on.r)
        rate1, rate2 = surface_rates(al.matT_vec(on.A, seen), on.r1, on.r2)
        bend = al.dot(n, on.r11) * rate1 * rate1 + 2.0 * al.dot(n, on.r12) * rate1 * rate2
        bend += al.dot(n, on.r22) * rate2 * rate2
        return u, on.r, al.dot(n, on.e), al.dot(u, seen), al.dot(u, bias) - bend

    pair = curve_on_curve(m, d, k)
    seen, bias = seen_motion(m, d, k, pair.r)
    w = markers.angular_velocity(m, d, m.end_frame_b[k])
    w = al.sub(w, markers.angular_velocity(m, d, m.end_frame_a[k]))
    J = tangency(pair)
    turned = al.dot(pair.n, al.cross(w, pair.t_b))
    slip = al.dot(pair.tangent, seen)
    rate1, rate2 = solve2(J[0], J[1], J[2], J[3], slip, -turned)
    bend = turned * rate2 - slip * pair.bend / pair.length * rate1
    return pair.n, pair.r, al.dot(pair.n, pair.e), al.dot(pair.n, seen), al.dot(pair.n, bias) + bend


@kernel
def newton(m, d, k):
    """Newton's step (ds1, ds2) of contact k's parameters."""
    kind = m.end_frame_kind[k]

    if kind == ON_CURVE:
        at = point_on_curve(m, d, k)
        metric = al.dot(at.t, at.t)
        bent = metric - al.dot(at.tt, at.e)
        return al.dot(at.t, at.e) / (bent if bent > TRUSTED * metric else metric), 0.0

    if kind == ON_SURFACE:
        on = point_on_surface(m, d, k)
        a = al.dot(on.r1, on.r1)
        b = al.dot(on.r1, on.r2)
        c = al.dot(on.r2, on.r2)
        f = al.dot(on.r1, on.e)
        g = al.dot(on.r2, on.e)
        a_bent = a - al.dot(on.r11, on.e)
        b_bent = b - al.dot(on.r12, on.e)
        c_bent = c - al.dot(on.r22, on.e)

        if a_bent > TRUSTED * a and a_bent * c_bent - b_bent * b_bent > TRUSTED * (a * c - b * b):
            return solve2(a_bent, b_bent, b_bent, c_bent, f, g)

        return solve2(a, b, b, c, f, g)

    pair = curve_on_curve(m, d, k)
    J = tangency(pair)
    return solve2(J[0], J[1], J[2], J[3], al.dot(pair.tangent, pair.e), -al.dot(pair.n, pair.t_b))


@inlined
def read_sphere(m, d, k):
    """Longitude and latitude of a point on a sphere, on the turn closest to the one before."""
    s = m.end_frame_z[k]
    e = markers.relative_position(m, d, m.end_frame_a[k], m.end_frame_b[k])
    d.z[s] = coordinates.unwrapped(math.atan2(e[1], e[0]), d.z[s])
    d.z[s + 1] = math.atan2(e[2], math.sqrt(e[0] * e[0] + e[1] * e[1]))


@apart(void(MODEL, DATA))
def find_parameters(m, d):
    """s of all contacts from where they are: closest points, common tangents. Needs kinematics."""
    for k in range(m.n_end_frame):
        s = m.end_frame_z[k]

        if d.aim[k] > 0.0:
            continue

        if is_sphere(m, k):
            read_sphere(m, d, k)
            continue

        for iteration in range(MAX_ITERATIONS):
            ds1, ds2 = newton(m, d, k)
            d.z[s] += ds1
            done = abs(ds1) <= ROUNDING * (1.0 + abs(d.z[s]))

            if m.end_frame_kind[k] != ON_CURVE:
                d.z[s + 1] += ds2
                done = done and abs(ds2) <= ROUNDING * (1.0 + abs(d.z[s + 1]))

            if done:
                break


# start values


@kernel
def miss(m, d, k):
    """How far (m2) contact k is from touching with its parameters as they are."""
    r, e = span(m, d, k)
    missed = al.dot(e, e)

    if m.end_frame_kind[k] == CURVES:
        pair = curve_on_curve(m, d, k)
        size = m.curve_size[m.end_frame_from[k]] + m.curve_size[m.end_frame_to[k]]
        sine = size * al.dot(pair.n, pair.t_b) / al.norm(pair.t_b)
        missed += sine * sine

    return missed


@kernel
def windows(m, d, k):
    """Where to search for contact k's parameters: (lowest, highest, samples) of each."""
    a = m.end_frame_a[k]
    b = m.end_frame_b[k]
    i = m.end_frame_from[k]
    p = markers.relative_position(m, d, a, b)

    if m.end_frame_kind[k] == ON_CURVE:
        low, high = curves.window(m, i, p, 0.0)
        return (low, high, max(SAMPLES, 4 * curves.pieces(m, i))), (0.0, 0.0, 1)

    if m.end_frame_kind[k] == ON_SURFACE:
        one, two = surfaces.window(m, i, p)
        n1, n2 = surfaces.pieces(m, i)
        return (one[0], one[1], max(PAIR_SAMPLES, 4 * n1)), (
            two[0],
            two[1],
            max(PAIR_SAMPLES, 4 * n2),
        )

    j = m.end_frame_to[k]
    low1, high1 = curves.window(m, i, p, m.curve_size[j])
    low2, high2 = curves.window(m, j, markers.relative_position(m, d, b, a), m.curve_size[i])
    n1 = max(PAIR_SAMPLES, 4 * curves.pieces(m, i))
    n2 = max(PAIR_SAMPLES, 4 * curves.pieces(m, j))
    return (low1, high1, n1), (low2, high2, n2)


@kernel
def search(m, d, k):
    """Parameters of contact k near which it touches, by samples."""
    s = m.end_frame_z[k]
    one, two = windows(m, d, k)
    best = (math.inf, one[0], two[0])

    for i in range(one[2]):
        for j in range(two[2]):
            d.z[s] = one[0] + (one[1] - one[0]) * i / one[2]

            if two[2] > 1:
                d.z[s + 1] = two[0] + (two[1] - two[0]) * j / two[2]

            missed = miss(m, d, k)

            if missed < best[0]:
                best = (missed, d.z[s], two[0] + (two[1] - two[0]) * j / two[2])

    d.z[s] = best[1]

    if two[2] > 1:
        d.z[s + 1] = best[2]


@kernel
def start(m, d):
    """Start values of s, as given or near the bodies' start positions. Needs kinematics."""
    for k in range(m.n_end_frame):
        d.aim[k] = 0.0

        if m.end_frame_given[k] == 1:
            for i in range(1 if m.end_frame_kind[k] == ON_CURVE else 2):
                d.z[m.end_frame_z[k] + i] = m.s_start[m.end_frame_z[k] + i]

        elif not is_sphere(m, k):
            search(m, d, k)


@inlined
def aim(m, d):
    """Aim contacts at their parameters where these were given. Returns whether there are any."""
    aimed = False

    for k in range(m.n_end_frame):
        d.aim[k] = float(m.end_frame_given[k])
        aimed = aimed or m.end_frame_given[k] == 1

    return aimed


@inlined
def release(m, d):
    """Contacts no longer aimed."""
    for k in range(m.n_end_frame):
        d.aim[k] = 0.0
