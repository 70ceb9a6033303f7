"""Joints of end frames on curves and surfaces: where they touch, and what their rows say.

A contact's parameters s stand in d.z. They are those of the closest point (of a
curve or surface to a marker's origin) or of the common tangent (of two curves, of two surfaces): exactly so after
every accepted step, where Newton's method finds them anew. In between they are integrated; their
rates follow from the velocities. What is on surfaces is in on_surfaces.py.

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
from . import curves, on_surfaces, surfaces
from .on_surfaces import seen_motion, solve2

Vector = tuple[float, float, float]
Matrix = tuple[Vector, Vector, Vector]

ON_CURVE = 0
CURVES = 1
ON_SURFACE = 2  # a point, or a convex surface

KINDS = {
    "point_on_curve": ON_CURVE,
    "curve_on_curve": CURVES,
    "point_on_surface": ON_SURFACE,
    "frame_on_curve": ON_CURVE,
    "frame_on_surface": ON_SURFACE,
    "surface_on_surface": ON_SURFACE,
    "rolling_surface": ON_SURFACE,
}

MAX_ITERATIONS = 30

# Newton's method has found s when it moves less than this part
ROUNDING = 1e-15

# curvature is believed where it leaves this part of the metric: else the point found may be the
# farthest
TRUSTED = 0.1

# error (rad) of a longitude that is just allowed: it need but tell the turn
LONGITUDE_ALLOWED = 0.3

# samples of a curve, and of each side of a pair, in the search for a start
SAMPLES = 128
PAIR_SAMPLES = 64


@inlined
def is_sphere(m, k):
    """Whether contact k is of a point on a sphere."""
    return m.end_frame_kind[k] == ON_SURFACE and m.surface_kind[m.end_frame_from[k]] == surfaces.SPHERE


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


@kernel
def rates(m, d, k):
    """(s1', s2', s3', s4') of contact k; 0 of those that it does not have. Needs kinematics."""
    kind = m.end_frame_kind[k]

    if kind == ON_CURVE:
        at = point_on_curve(m, d, k)
        seen, _ = seen_motion(m, d, k, at.r)
        return al.dot(at.t, al.matT_vec(at.A, seen)) / al.dot(at.t, at.t), 0.0, 0.0, 0.0

    if kind == ON_SURFACE:
        return on_surfaces.rates(m, d, k)

    pair = curve_on_curve(m, d, k)
    seen, _ = seen_motion(m, d, k, pair.r)
    w = markers.angular_velocity(m, d, m.end_frame_b[k])
    w = al.sub(w, markers.angular_velocity(m, d, m.end_frame_a[k]))
    J = tangency(pair)
    turned = al.dot(pair.n, al.cross(w, pair.t_b))
    rate1, rate2 = solve2(J[0], J[1], J[2], J[3], al.dot(pair.tangent, seen), -turned)
    return rate1, rate2, 0.0, 0.0


@inlined
def find_ways(m, d):
    """How parameters that are coordinates follow from the motion of their points (docs/theory.md 10.7). Needs kinematics.

    A contact that is aimed at its parameter keeps it, whatever moves.
    """
    for c in range(m.n_coordinate):
        if m.coordinate_kind[c] == coordinates.PARAMETER:
            k = m.coordinate_end_frame[c]
            at = point_on_curve(m, d, k)
            seen, _ = seen_motion(m, d, k, at.r)
            v = al.matT_vec(at.A, seen)
            square = al.dot(at.t, at.t)
            speed = al.dot(at.t, v) / square
            moves = 0.0 if d.aim[k] > 0.0 else 1.0
            al.set_vec3(d.parameter_along, k, al.scale(moves / square, al.mat_vec(at.A, at.t)))
            bend = al.dot(at.tt, v) - 2.0 * al.dot(at.t, at.tt) * speed
            d.parameter_bend[k] = moves * bend * speed / square


@apart(void(MODEL, DATA))
def parameter_rates(m, d):
    """s' of all contacts into d.z_rate; needs kinematics."""
    for k in range(m.n_end_frame):
        if m.end_frame_kind[k] == ON_SURFACE:
            on_surfaces.write_rates(m, d, k)
            continue

        s = m.end_frame_z[k]
        rate = rates(m, d, k)
        d.z_rate[s] = rate[0]

        if m.end_frame_kind[k] == CURVES:
            d.z_rate[s + 1] = rate[1]


@inlined
def weigh(m, d, z):
    """Error weights of longitudes and latitudes that nothing depends on; `z`: where z stands in x."""
    for k in range(m.n_end_frame):
        if m.end_frame_kind[k] != ON_SURFACE:
            continue

        s = z + m.end_frame_z[k]

        for i in range(2 if m.end_frame_to[k] < 0 else 4):
            if i >= 2 or surfaces.is_round(m, m.end_frame_from[k]):
                d.x_scale[s + i] = LONGITUDE_ALLOWED


@inlined
def span(m, d, k):
    """(point at the contact in O, e in inertial axes) with s as it is."""
    kind = m.end_frame_kind[k]

    if kind == ON_CURVE:
        at = point_on_curve(m, d, k)
        return at.r, al.mat_vec(at.A, at.e)

    if kind == ON_SURFACE:
        on = on_surfaces.on_surface(m, d, k)
        return on.r, al.mat_vec(on.A, on.e)

    pair = curve_on_curve(m, d, k)
    along = al.scale(al.dot(pair.tangent, pair.e), pair.tangent)
    return pair.r, al.add(along, al.scale(al.dot(pair.n, pair.e), pair.n))


@inlined
def aiming_couple(m, d, k, u):
    """Moment on b beside the force u of an aimed row: where b turns, another of its points is the one that touches."""
    return on_surfaces.aiming_couple(m, d, k, u) if m.end_frame_kind[k] == ON_SURFACE else al.ZERO3


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

    if m.end_frame_kind[k] == ON_SURFACE:
        return on_surfaces.row(m, d, k, i)

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
        return on_surfaces.newton(m, d, k)

    pair = curve_on_curve(m, d, k)
    J = tangency(pair)
    return solve2(J[0], J[1], J[2], J[3], al.dot(pair.tangent, pair.e), -al.dot(pair.n, pair.t_b))


@inlined
def move(m, d, k, ds1, ds2):
    """Contact k's parameters moved. Returns how large they are."""
    if m.end_frame_kind[k] == ON_SURFACE:
        return on_surfaces.move(m, d, k, ds1, ds2)

    s = m.end_frame_z[k]
    d.z[s] += ds1

    if m.end_frame_kind[k] == ON_CURVE:
        return abs(d.z[s]), 0.0

    d.z[s + 1] += ds2
    return abs(d.z[s]), abs(d.z[s + 1])


@kernel
def find(m, d, k):
    """s of contact k from where it is: its closest point, or common tangent. Needs kinematics."""
    for iteration in range(MAX_ITERATIONS):
        ds1, ds2 = newton(m, d, k)
        size1, size2 = move(m, d, k, ds1, ds2)

        if abs(ds1) <= ROUNDING * (1.0 + size1) and abs(ds2) <= ROUNDING * (1.0 + size2):
            break


@apart(void(MODEL, DATA))
def find_parameters(m, d):
    """s of all contacts from where they are: closest points, common tangents. Needs kinematics."""
    for k in range(m.n_end_frame):
        if d.aim[k] == 0.0:
            find(m, d, k)

        if m.end_frame_kind[k] == ON_SURFACE:
            on_surfaces.read_bearings(m, d, k)


@inlined
def touches_along(m, d, k):
    """Whether contact k is of surfaces that touch in more than a point. Needs kinematics, and s."""
    of_surfaces = m.end_frame_kind[k] == ON_SURFACE and m.end_frame_to[k] >= 0
    return of_surfaces and not on_surfaces.touches_in_a_point(m, d, k)


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
        one, two = surfaces.window(m, i, p, on_surfaces.reach(m, k))
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


@inlined
def set_off(m, d, k):
    """What follows s of contact k, where s was set."""
    if m.end_frame_kind[k] == ON_SURFACE:
        on_surfaces.aim_at(m, d, k)


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

            set_off(m, d, k)
            missed = miss(m, d, k)

            if missed < best[0]:
                best = (missed, d.z[s], two[0] + (two[1] - two[0]) * j / two[2])

    d.z[s] = best[1]

    if two[2] > 1:
        d.z[s + 1] = best[2]

    set_off(m, d, k)


@kernel
def choose_side(m, d, k):
    """Surfaces touch on that side of the first one where the start puts the second one's origin, the outer side if it lies in it."""
    if m.end_frame_kind[k] != ON_SURFACE or m.end_frame_to[k] < 0:
        return

    if m.end_frame_given[k] == 0:
        search(m, d, k)
        find(m, d, k)

    d.end_frame_side[k] = on_surfaces.side_of(m, d, k)


@kernel
def start(m, d):
    """Start values of s, as given or near the bodies' start positions. Needs kinematics."""
    for k in range(m.n_end_frame):
        d.aim[k] = 0.0
        d.end_frame_side[k] = 0.0

        if m.end_frame_to[k] >= 0 and m.end_frame_kind[k] == ON_SURFACE:
            d.z[m.end_frame_z[k] + 2] = 0.0

        if m.end_frame_given[k] == 1:
            for i in range(1 if m.end_frame_kind[k] == ON_CURVE else 2):
                d.z[m.end_frame_z[k] + i] = m.s_start[m.end_frame_z[k] + i]

            set_off(m, d, k)

        choose_side(m, d, k)

        if m.end_frame_given[k] == 0:
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
