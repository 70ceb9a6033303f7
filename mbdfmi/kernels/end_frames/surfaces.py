"""Surfaces by parameters s1 and s2, in their marker's axes: r(s1, s2), derivatives (docs/theory.md 10.2).

==========  ===========================================================  ===================
kind        r                                                            s1, s2
==========  ===========================================================  ===================
PLANE       (s1, s2, 0)                                                  m, m
SPHERE      R (cos s2 cos s1, cos s2 sin s1, sin s2)                     rad, rad
ELLIPSOID   (a cos s2 cos s1, b cos s2 sin s1, c sin s2)                 rad, rad
CYLINDER    (R cos s1, R sin s1, s2)                                     rad, m
TORUS       ((R + t cos s2) cos s1, (R + t cos s2) sin s1, t sin s2)     rad, rad
PRISM       a planar curve by s1, moved along z by s2                    the curve's, m
TABLE       bicubic patches; beyond its edges straight on                as given
==========  ===========================================================  ===================

Spheres and ellipsoids are *round*: longitude and latitude fail at their poles, so they are reckoned from the unit vector u whose
longitude and latitude these are, with r = (a u_x, b u_y, c u_z), by a chart about u of its own at each place.
"""

import math

from ..language import inlined, kernel
from ..math import algebra as al
from ..math import tables
from . import curves

PLANE = 0
SPHERE = 1
CYLINDER = 2
TORUS = 3
PRISM = 4
TABLE = 5
ELLIPSOID = 6

KINDS = {
    "plane": PLANE,
    "sphere": SPHERE,
    "cylinder": CYLINDER,
    "torus": TORUS,
    "prism": PRISM,
    "table": TABLE,
    "ellipsoid": ELLIPSOID,
    "disk": TORUS,  # its edge: a tube of no thickness
}

X = (1.0, 0.0, 0.0)
Z = (0.0, 0.0, 1.0)

# below this z of u its chart lies along the parallels
NEAR_POLE = 0.9


@inlined
def is_round(m, k):
    """Whether surface k is reckoned from a unit vector u."""
    return m.surface_kind[k] == SPHERE or m.surface_kind[k] == ELLIPSOID


@inlined
def stretched(m, k, u):
    """(a u_x, b u_y, c u_z) by the semi-axes of a sphere or an ellipsoid."""
    return (
        m.surface_value[3 * k] * u[0],
        m.surface_value[3 * k + 1] * u[1],
        m.surface_value[3 * k + 2] * u[2],
    )


@inlined
def circles(m, k):
    """(radius of a torus, of its tube); of what is round those of the unit sphere that it is stretched from: 0, 1."""
    if is_round(m, k):
        return 0.0, 1.0

    return m.surface_value[3 * k], m.surface_value[3 * k + 1]


@inlined
def shaped(m, k, v):
    """A vector of the surface of `circles`, on surface k."""
    return stretched(m, k, v) if is_round(m, k) else v


@inlined
def direction(longitude, latitude):
    """The unit vector u of that longitude and latitude (rad)."""
    c = math.cos(latitude)
    return (c * math.cos(longitude), c * math.sin(longitude), math.sin(latitude))


@inlined
def bearing(y):
    """(longitude, latitude) (rad) of a vector."""
    return math.atan2(y[1], y[0]), math.atan2(y[2], math.sqrt(y[0] * y[0] + y[1] * y[1]))


@inlined
def bearing_rates(y, y_rate):
    """Rates (rad/s) of longitude and latitude of a vector; 0 at the poles."""
    square = y[0] * y[0] + y[1] * y[1]

    if square <= 1e-24 * al.dot(y, y):
        return 0.0, 0.0

    along = y[0] * y_rate[0] + y[1] * y_rate[1]
    turning = (y[0] * y_rate[1] - y[1] * y_rate[0]) / square
    return turning, (y_rate[2] * square - y[2] * along) / (math.sqrt(square) * al.dot(y, y))


@inlined
def tangents(u):
    """Two unit vectors that make a right-handed frame with the unit vector u; to the east and north but near the poles."""
    east = al.cross(Z if abs(u[2]) < NEAR_POLE else X, u)
    east = al.scale(1.0 / al.norm(east), east)
    return east, al.cross(u, east)


@kernel
def around(m, k, u):
    """`point` of a sphere or an ellipsoid at u, by x1 and x2 of the chart u + x1 e1 + x2 e2, made a unit vector, e = tangents(u)."""
    e1, e2 = tangents(u)
    r = stretched(m, k, u)
    return r, stretched(m, k, e1), stretched(m, k, e2), al.neg(r), al.ZERO3, al.neg(r)


@inlined
def cubic(c, at, x):
    """c0 + c1 x + c2 x^2 + c3 x^3 of four numbers from c[at] on, and its two derivatives."""
    value = c[at] + x * (c[at + 1] + x * (c[at + 2] + x * c[at + 3]))
    slope = c[at + 1] + x * (2.0 * c[at + 2] + 3.0 * x * c[at + 3])
    return value, slope, 2.0 * c[at + 2] + 6.0 * x * c[at + 3]


@kernel
def bicubic(c, at, x, y):
    """A bicubic polynomial of 16 numbers from c[at] on, powers of y fastest, and its derivatives.

    Returns (value, d/dx, d/dy, d2/dx2, d2/dxdy, d2/dy2).
    """
    value = slope_x = slope_y = bend_x = twist = bend_y = 0.0

    # Horner's rule for the polynomial in x whose coefficients are cubics in y
    for power in range(3, -1, -1):
        f, f_y, f_yy = cubic(c, at + 4 * power, y)
        bend_x = 2.0 * slope_x + x * bend_x
        slope_x = value + x * slope_x
        value = f + x * value
        twist = slope_y + x * twist
        slope_y = f_y + x * slope_y
        bend_y = f_yy + x * bend_y

    return value, slope_x, slope_y, bend_x, twist, bend_y


@inlined
def patch(m, k, s1, s2):
    """(where its coefficients begin, s1 and s2 from its corner) of the patch of a table at (s1, s2).

    The surface's two tables hold the parameters at the edges of the patches.
    """
    table1 = m.surface_table[2 * k]
    table2 = m.surface_table[2 * k + 1]
    i = tables.interval(m, table1, s1)
    j = tables.interval(m, table2, s2)
    across = m.table_knots[table2] - 1
    at = 48 * (m.surface_patch[k] + (i - m.table_knot[table1]) * across + j - m.table_knot[table2])
    return at, s1 - m.knot_x[i], s2 - m.knot_x[j]


@inlined
def patched(m, k, s1, s2):
    """`point` of a table."""
    at, u, v = patch(m, k, s1, s2)
    x = bicubic(m.patch_c, at, u, v)
    y = bicubic(m.patch_c, at + 16, u, v)
    z = bicubic(m.patch_c, at + 32, u, v)
    return (
        (x[0], y[0], z[0]),
        (x[1], y[1], z[1]),
        (x[2], y[2], z[2]),
        (x[3], y[3], z[3]),
        (x[4], y[4], z[4]),
        (x[5], y[5], z[5]),
    )


@kernel
def point(m, k, s1, s2):
    """(r, r_1, r_2, r_11, r_12, r_22) of surface k at (s1, s2), in its marker's axes.

    Indices stand for derivatives by s1 and s2.
    """
    kind = m.surface_kind[k]
    R = m.surface_value[3 * k]
    zero = al.ZERO3

    if kind == PLANE:
        return (s1, s2, 0.0), (1.0, 0.0, 0.0), (0.0, 1.0, 0.0), zero, zero, zero

    if kind == PRISM:
        r, t, tt = curves.point(m, m.surface_curve[k], s1)
        return al.axpy(s2, Z, r), t, Z, tt, zero, zero

    if kind == TABLE:
        return patched(m, k, s1, s2)

    x = (math.cos(s1), math.sin(s1), 0.0)
    y = (-x[1], x[0], 0.0)

    if kind == CYLINDER:
        return al.axpy(s2, Z, al.scale(R, x)), al.scale(R, y), Z, al.scale(-R, x), zero, zero

    R, tube = circles(m, k)
    c = tube * math.cos(s2)
    s = tube * math.sin(s2)
    out = al.axpy(s, Z, al.scale(c, x))
    r = al.axpy(R, x, out)
    return (
        shaped(m, k, r),
        shaped(m, k, al.scale(R + c, y)),
        shaped(m, k, al.axpy(c, Z, al.scale(-s, x))),
        shaped(m, k, al.scale(-(R + c), x)),
        shaped(m, k, al.scale(-s, y)),
        shaped(m, k, al.neg(out)),
    )


@kernel
def bicubic_bends(c, at, x, y, u, v):
    """Second derivatives, along (u, v), of d/dx and d/dy of a bicubic polynomial as in `bicubic`."""
    bend_x = bend_y = 0.0

    for power in range(3, -1, -1):
        f, f_y, f_yy = cubic(c, at + 4 * power, y)
        f_yyy = 6.0 * c[at + 4 * power + 3]
        x0 = x**power
        x1 = power * x ** max(0, power - 1)
        x2 = power * (power - 1) * x ** max(0, power - 2)
        x3 = power * (power - 1) * (power - 2)
        bend_x += u * u * x3 * f + 2.0 * u * v * x2 * f_y + v * v * x1 * f_yy
        bend_y += u * u * x2 * f_y + 2.0 * u * v * x1 * f_yy + v * v * x0 * f_yyy

    return bend_x, bend_y


@inlined
def patched_bends(m, k, s1, s2, u, v):
    """`second_changes` of a table."""
    at, x, y = patch(m, k, s1, s2)
    one = bicubic_bends(m.patch_c, at, x, y, u, v)
    two = bicubic_bends(m.patch_c, at + 16, x, y, u, v)
    three = bicubic_bends(m.patch_c, at + 32, x, y, u, v)
    return (one[0], two[0], three[0]), (one[1], two[1], three[1])


@kernel
def second_changes(m, k, s1, s2, u1, u2):
    """Second derivatives of r_1 and of r_2 of surface k at (s1, s2) along a way of parameters at the steady rates (u1, u2)."""
    kind = m.surface_kind[k]
    zero = al.ZERO3

    if kind == PLANE:
        return zero, zero

    if kind == PRISM:
        return al.scale(u1 * u1, curves.third(m, m.surface_curve[k], s1)), zero

    if kind == TABLE:
        return patched_bends(m, k, s1, s2, u1, u2)

    x = (math.cos(s1), math.sin(s1), 0.0)
    y = (-x[1], x[0], 0.0)

    if kind == CYLINDER:
        return al.scale(-m.surface_value[3 * k] * u1 * u1, y), zero

    R, tube = circles(m, k)
    c = tube * math.cos(s2)
    s = tube * math.sin(s2)
    r_111 = shaped(m, k, al.scale(-(R + c), y))
    r_112 = shaped(m, k, al.scale(s, x))
    r_122 = shaped(m, k, al.scale(-c, y))
    r_222 = shaped(m, k, al.axpy(-c, Z, al.scale(s, x)))
    return (
        al.axpy(u1 * u1, r_111, al.axpy(2.0 * u1 * u2, r_112, al.scale(u2 * u2, r_122))),
        al.axpy(u1 * u1, r_112, al.axpy(2.0 * u1 * u2, r_122, al.scale(u2 * u2, r_222))),
    )


@inlined
def window(m, k, p, margin):
    """(lowest, highest) s1 and s2 at which surface k may be closest to a point within `margin` of p (m)."""
    kind = m.surface_kind[k]
    turn = 2.0 * math.pi

    if kind == PLANE:
        return (p[0] - margin, p[0] + margin), (p[1] - margin, p[1] + margin)

    if kind == PRISM:
        return curves.window(m, m.surface_curve[k], p, margin), (p[2] - margin, p[2] + margin)

    if kind == TABLE:
        one = m.surface_table[2 * k]
        two = m.surface_table[2 * k + 1]
        return (tables.first(m, one), tables.last(m, one)), (
            tables.first(m, two),
            tables.last(m, two),
        )

    if kind == CYLINDER:
        return (0.0, turn), (p[2] - margin, p[2] + margin)

    return (-0.5 * turn, 0.5 * turn), (-0.5 * turn, 0.5 * turn)


@inlined
def within_edges(m, table, s, part):
    """s moved to the nearest edge of a table's points, which has a straight patch more on either side; a part of the way farther in."""
    k = m.table_knot[table] + 1
    first = m.knot_x[k]
    last = m.knot_x[k + m.table_knots[table] - 3]
    margin = part * (last - first)
    return min(max(s, first + margin), last - margin)


@inlined
def pieces(m, k):
    """Numbers of pieces of surface k along s1 and s2."""
    if m.surface_kind[k] == TABLE:
        return m.table_knots[m.surface_table[2 * k]] - 1, m.table_knots[m.surface_table[2 * k + 1]] - 1

    return (curves.pieces(m, m.surface_curve[k]) if m.surface_kind[k] == PRISM else 1), 1
