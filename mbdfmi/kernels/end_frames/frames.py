"""Axes of end frames: how they turn as the end frame moves along its curve or surface (docs/theory.md 10.5).

i lies along the tangent t (on a surface r_1), k along the normal, j = k x i. On a curve k is normal to a fixed vector that the
curve is never parallel to. Seen from the marker, the frame turns with W = w_1 s1' + w_2 s2', linear in the velocity of the point
that leads it; so a joint that holds axes to it has, beside moments, a force along the curve or surface, which does no work.

Legend as in touching.py; N the vector, of any length, that k lies along; D, DD the first and second derivative along the way.
"""

from typing import NamedTuple

from ..language import inlined, kernel
from ..math import algebra as al
from ..motion import markers
from . import curves, on_surfaces, surfaces, touching

Vector = tuple[float, float, float]
Matrix = tuple[Vector, Vector, Vector]

Z = (0.0, 0.0, 1.0)
X = (1.0, 0.0, 0.0)

# a radius this near to a sphere's axis has no longitude to tell by
NEAR_POLE = 0.9


class Axes(NamedTuple):
    """Axes of an end frame, in those of its marker. i, j, k: unit vectors; bend: length of the vector along which i lies;
    N: length of that along which k lies.
    """

    i: Vector
    j: Vector
    k: Vector
    bend: float
    N: float


class Moving(NamedTuple):
    """An end frame and how it moves, all in inertial axes. E: its axes by column; w: angular velocity; alpha: its derivative at
    zero accelerations of the bodies; r: the material point that leads it (m, from O).
    """

    E: Matrix
    w: Vector
    alpha: Vector
    r: Vector


@inlined
def axes_along(u, N):
    """Axes with i along u and k along N, which are normal to each other."""
    bend = al.norm(u)
    size = al.norm(N)
    i = al.scale(1.0 / bend, u)
    k = al.scale(1.0 / size, N)
    return Axes(i, al.cross(k, i), k, bend, size)


@inlined
def unit_rates(e, size, Du, DDu):
    """(De, DDe) of the unit vector e along u = size e."""
    along = al.dot(e, Du)
    De = al.scale(1.0 / size, al.axpy(-along, e, Du))
    second = al.dot(e, DDu) + al.dot(De, Du)
    return De, al.scale(1.0 / size, al.axpy(-2.0 * along, De, al.axpy(-second, e, DDu)))


@inlined
def turning(e, Di, DN):
    """Angular velocity of axes whose i has the derivative Di, and N has DN: i x Di - (j . DN / |N|) i."""
    return al.axpy(-al.dot(e.j, DN) / e.N, e.i, al.cross(e.i, Di))


@inlined
def turning_rate(e, Di, DDi, DN, DDN):
    """(`turning`, its derivative)."""
    w = turning(e, Di, DN)
    about = al.dot(e.j, DN) / e.N
    rate = (al.dot(al.cross(w, e.j), DN) + al.dot(e.j, DDN) - about * al.dot(e.k, DN)) / e.N
    second = al.axpy(-rate, e.i, al.cross(e.i, DDi))
    return w, al.axpy(-about, Di, second)


# on a curve


@inlined
def curve_axes(m, k, t):
    """Axes on curve k where its tangent is t."""
    tangent = al.scale(1.0 / al.norm(t), t)
    return axes_along(t, al.cross(tangent, al.vec3(m.curve_side, k)))


@inlined
def curve_turning(m, d, k, at):
    """(axes, w, derivative of w) by the parameter, of the end frame k at a point on a curve (touching.OnCurve)."""
    curve = m.end_frame_from[k]
    ttt = curves.third(m, curve, d.z[m.end_frame_z[k]])
    side = al.vec3(m.curve_side, curve)
    found = curve_axes(m, curve, at.t)
    Di, DDi = unit_rates(found.i, found.bend, at.tt, ttt)
    w, rate = turning_rate(found, Di, DDi, al.cross(Di, side), al.cross(DDi, side))
    return found, w, rate


# on a surface


@inlined
def surface_turning(e, r1, r2, D1, D2):
    """`turning` on a surface where r_1 and r_2 have the derivatives D1 and D2."""
    along = al.dot(e.i, D1)
    Di = al.scale(1.0 / e.bend, al.axpy(-along, e.i, D1))
    return turning(e, Di, al.add(al.cross(D1, r2), al.cross(r1, D2)))


@inlined
def sphere_pole(out):
    """A vector that is not along a radius, of which i on a sphere is normal to both: z, so that i points east, but at a pole."""
    square = al.dot(out, out)
    return X if out[2] * out[2] > NEAR_POLE * NEAR_POLE * square else Z


@inlined
def sphere_axes(m, d, k, free):
    """(radius to the point in a's axes, the vector that i is normal to, axes): where the spin is free, any will do for i."""
    out = markers.relative_position(m, d, m.end_frame_a[k], m.end_frame_b[k])
    pole = sphere_pole(out) if free else Z
    return out, pole, axes_along(al.cross(pole, out), out)


@kernel
def axes_of(m, d, k):
    """Axes (i, j, k) of end frame k in its marker's. Needs kinematics."""
    if touching.is_sphere(m, k):
        out, pole, found = sphere_axes(m, d, k, False)
        return found.i, found.j, found.k

    if m.end_frame_kind[k] == touching.ON_SURFACE:
        _, _, _, r1, r2, _, _, _ = on_surfaces.by_parameters(m, d, k)
        found = axes_along(r1, al.cross(r1, r2))
        return found.i, found.j, found.k

    _, t, _ = curves.point(m, m.end_frame_from[k], d.z[m.end_frame_z[k]])
    found = curve_axes(m, m.end_frame_from[k], t)
    return found.i, found.j, found.k


@inlined
def turned(A, found, w_a, w, rate, r):
    """`Moving` of axes in A's, which has the angular velocity w_a, and that turn with w in them, whose derivative is `rate`."""
    E = al.mat_mat(A, al.transpose((found.i, found.j, found.k)))
    w = al.mat_vec(A, w)
    return Moving(E, al.add(w_a, w), al.add(al.cross(w_a, w), al.mat_vec(A, rate)), r)


@kernel
def moving(m, d, k, free):
    """End frame k as it moves (Moving); while it is aimed at given parameters it stays there. free: its spin about k does not matter,
    which on a sphere has no meaning at the poles. Needs kinematics.
    """
    a = m.end_frame_a[k]
    A = markers.axes(m, d, a)
    w_a = al.vec3(d.w, m.marker_body[a])
    r = markers.position(m, d, m.end_frame_b[k])
    seen, bias = on_surfaces.seen_motion(m, d, k, r)
    v = al.matT_vec(A, seen)
    v_rate = al.matT_vec(A, bias)

    if touching.is_sphere(m, k):
        out, pole, found = sphere_axes(m, d, k, free)
        Di, DDi = unit_rates(found.i, found.bend, al.cross(pole, v), al.cross(pole, v_rate))
        w, rate = turning_rate(found, Di, DDi, v, v_rate)

    elif m.end_frame_kind[k] == touching.ON_SURFACE:
        found, w, rate = on_surface(m, d, k, v, v_rate)

    else:
        at = touching.point_on_curve(m, d, k)
        found, by_s, second = curve_turning(m, d, k, at)
        square = al.dot(at.t, at.t)
        speed = al.dot(at.t, v) / square
        faster = al.dot(at.t, v_rate) + al.dot(at.tt, v) * speed - 2.0 * al.dot(at.t, at.tt) * speed * speed
        w = al.scale(speed, by_s)
        rate = al.axpy(speed * speed, second, al.scale(faster / square, by_s))

    if d.aim[k] > 0.0:
        w = al.ZERO3
        rate = al.ZERO3

    return turned(A, found, w_a, w, rate, r)


@kernel
def on_surface(m, d, k, v, v_rate):
    """(axes, w, w' at zero accelerations of the bodies) of end frame k on a surface; v, v_rate : of the point that leads it, all in
    its marker's axes and seen from there.
    """
    s1, s2, _, r1, r2, r11, r12, r22 = on_surfaces.by_parameters(m, d, k)
    u1, u2 = on_surfaces.surface_rates(v, r1, r2)
    D1 = al.axpy(u1, r11, al.scale(u2, r12))
    D2 = al.axpy(u1, r12, al.scale(u2, r22))
    DD1, DD2 = surfaces.second_changes(m, m.end_frame_from[k], s1, s2, u1, u2)
    N = al.cross(r1, r2)
    found = axes_along(r1, N)
    DN = al.add(al.cross(D1, r2), al.cross(r1, D2))
    DDN = al.add(al.cross(DD1, r2), al.axpy(2.0, al.cross(D1, D2), al.cross(r1, DD2)))
    Di, DDi = unit_rates(found.i, found.bend, D1, DD1)
    w, rate = turning_rate(found, Di, DDi, DN, DDN)

    # what the second rates of the parameters are at zero accelerations: of r_k . r_l s_l' = r_k . v
    along1 = al.dot(r1, v_rate) + al.dot(D1, v)
    along2 = al.dot(r2, v_rate) + al.dot(D2, v)
    mixed = al.dot(D1, r2) + al.dot(r1, D2)
    along1 -= 2.0 * al.dot(r1, D1) * u1 + mixed * u2
    along2 -= mixed * u1 + 2.0 * al.dot(r2, D2) * u2
    a = al.dot(r1, r1)
    b = al.dot(r1, r2)
    c = al.dot(r2, r2)
    f1, f2 = on_surfaces.solve2(a, b, b, c, along1, along2)
    rate = al.axpy(f1, surface_turning(found, r1, r2, r11, r12), rate)
    return found, w, al.axpy(f2, surface_turning(found, r1, r2, r12, r22), rate)


@kernel
def push(m, d, k, free, n):
    """The force (inertial axes) on the point that leads end frame k which has the power n . (angular velocity of the frame, seen
    from its marker), n in inertial axes.
    """
    if d.aim[k] > 0.0:
        return al.ZERO3

    A = markers.axes(m, d, m.end_frame_a[k])
    x = al.matT_vec(A, n)

    if touching.is_sphere(m, k):
        out, pole, found = sphere_axes(m, d, k, free)
        force = al.scale(1.0 / found.bend, al.cross(al.cross(x, found.i), pole))
        return al.mat_vec(A, al.axpy(-al.dot(x, found.i) / found.N, found.j, force))

    if m.end_frame_kind[k] == touching.ON_SURFACE:
        _, _, _, r1, r2, r11, r12, r22 = on_surfaces.by_parameters(m, d, k)
        found = axes_along(r1, al.cross(r1, r2))
        f1 = al.dot(x, surface_turning(found, r1, r2, r11, r12))
        f2 = al.dot(x, surface_turning(found, r1, r2, r12, r22))
        a = al.dot(r1, r1)
        b = al.dot(r1, r2)
        c1, c2 = on_surfaces.solve2(a, b, b, al.dot(r2, r2), f1, f2)
        return al.mat_vec(A, al.axpy(c1, r1, al.scale(c2, r2)))

    on = touching.point_on_curve(m, d, k)
    found, by_s, second = curve_turning(m, d, k, on)
    return al.mat_vec(A, al.scale(al.dot(x, by_s) / al.dot(on.t, on.t), on.t))
