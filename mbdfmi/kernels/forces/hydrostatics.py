"""Buoyancy of closed hulls of polygons at any angle (docs/theory.md 16.14): still water fills z < 0 of the inertial frame.

Of a closed surface what water presses on adds up to the weight of what is displaced, upwards through its centre. That is found
polygon by polygon from what stands between it and the water plane: for f linear or square in the place the integral of f over the
displaced volume is one over the wet surface's shadow on the plane, where the plane itself adds nothing. So neither the line along
which the plane cuts a hull nor a lid is looked for, and vertices of both sides of an edge are cut to the same bits.
"""

from ..language import apart, inlined
from ..math import algebra as al
from ..motion import markers
from ..signatures import DATA, MODEL, Tuple, float64, int64

# V, V x, V y, V z (m3, m4), and of the water plane A, A x, A y, A x^2, A y^2, A x y (m2, m3, m4), x and y from the marker
SUMS = Tuple((float64,) * 10)
NOTHING = (0.0, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0)


@inlined
def turn(m, d, k):
    """Vertices of hull k as it is turned, x and y from its marker's origin, z from the water plane (m)."""
    A = markers.axes(m, d, m.hull_marker[k])
    up = (0.0, 0.0, markers.position(m, d, m.hull_marker[k])[2])

    for j in range(m.hull_vertex[k], m.hull_vertex[k] + m.hull_vertices[k]):
        al.set_vec3(d.hull_point, j, al.add(up, al.mat_vec(A, al.vec3(m.vertex_r, j))))


@inlined
def add_prism(sums, a, b, c):
    """Sums (SUMS) and those of what stands between a triangle under water, its outside where a, b, c turn left, and the plane."""
    area = 0.5 * ((b[0] - a[0]) * (c[1] - a[1]) - (c[0] - a[0]) * (b[1] - a[1]))
    x = a[0] + b[0] + c[0]
    y = a[1] + b[1] + c[1]
    z = a[2] + b[2] + c[2]
    third = area / 3.0
    twelfth = area / 12.0
    return (
        sums[0] + third * z,
        sums[1] + twelfth * (x * z + a[0] * a[2] + b[0] * b[2] + c[0] * c[2]),
        sums[2] + twelfth * (y * z + a[1] * a[2] + b[1] * b[2] + c[1] * c[2]),
        sums[3] + 0.5 * twelfth * (z * z + a[2] * a[2] + b[2] * b[2] + c[2] * c[2]),
        sums[4] - area,
        sums[5] - third * x,
        sums[6] - third * y,
        sums[7] - twelfth * (x * x + a[0] * a[0] + b[0] * b[0] + c[0] * c[0]),
        sums[8] - twelfth * (y * y + a[1] * a[1] + b[1] * b[1] + c[1] * c[1]),
        sums[9] - twelfth * (x * y + a[0] * a[1] + b[0] * b[1] + c[0] * c[1]),
    )


@inlined
def surface_point(wet, dry):
    """Where an edge from a wet to a dry vertex comes out of the water."""
    t = wet[2] / (wet[2] - dry[2])
    return (wet[0] + t * (dry[0] - wet[0]), wet[1] + t * (dry[1] - wet[1]), 0.0)


@inlined
def add_polygon(m, d, p, sums):
    """Sums and those of the wet part of polygon p: triangles from the first point of it."""
    first = m.polygon_corner[p]
    last = first + m.polygon_corners[p] - 1
    before = al.vec3(d.hull_point, m.corner_vertex[last])
    apex = al.ZERO3
    left = al.ZERO3
    n = 0

    for j in range(first, last + 1):
        corner = al.vec3(d.hull_point, m.corner_vertex[j])

        # a corner on the plane is wet
        if (before[2] > 0.0) != (corner[2] > 0.0):
            point = surface_point(before, corner) if corner[2] > 0.0 else surface_point(corner, before)

            if n == 0:
                apex = point
            elif n > 1:
                sums = add_prism(sums, apex, left, point)

            left = point
            n += 1

        if corner[2] <= 0.0:
            if n == 0:
                apex = corner
            elif n > 1:
                sums = add_prism(sums, apex, left, corner)

            left = corner
            n += 1

        before = corner

    return sums


@apart(SUMS(MODEL, DATA, int64))
def displaced(m, d, k):
    """SUMS of hull k; needs kinematics."""
    turn(m, d, k)
    sums = NOTHING

    for p in range(m.hull_polygon[k], m.hull_polygon[k] + m.hull_polygons[k]):
        sums = add_polygon(m, d, p, sums)

    return sums


@inlined
def weight(m, k):
    """N/m3, of the water around hull k."""
    return -m.gravity[2] * m.hull_density[k]


@inlined
def wrench(m, d, k):
    """Of the water on hull k about its marker's origin: (moment N m, force N), inertial axes."""
    sums = displaced(m, d, k)
    w = weight(m, k)
    return (w * sums[2], -w * sums[1], 0.0), (0.0, 0.0, w * sums[0])


@inlined
def add(m, d):
    """Their wrenches onto the bodies."""
    for k in range(m.n_hull):
        moment, force = wrench(m, d, k)
        b = m.hull_marker[k]
        markers.add_wrench(m, d, m.marker_body[b], markers.position(m, d, b), moment, force)


@inlined
def energy_of(m, d, k):
    """J, that it took to press hull k so far down: the weight of what is displaced times its depth."""
    return -weight(m, k) * displaced(m, d, k)[3]


@inlined
def energy(m, d):
    """J, of all of them; 0 out of the water."""
    total = 0.0

    for k in range(m.n_hull):
        total += energy_of(m, d, k)

    return total


@inlined
def power_of(m, d, k):
    """W, of the water on hull k."""
    moment, force = wrench(m, d, k)
    return markers.power(m, d, m.hull_marker[k], moment, force)


@inlined
def power(m, d):
    """W, on the bodies."""
    total = 0.0

    for k in range(m.n_hull):
        total += power_of(m, d, k)

    return total


@inlined
def draught(m, d, k):
    """Depth of the lowest vertex of hull k (m), negative where it hangs in the air."""
    turn(m, d, k)
    lowest = d.hull_point[3 * m.hull_vertex[k] + 2]

    for j in range(m.hull_vertex[k], m.hull_vertex[k] + m.hull_vertices[k]):
        lowest = min(lowest, d.hull_point[3 * j + 2])

    return -lowest


@inlined
def center(m, d, k, sums):
    """Of buoyancy (m, in O); below the marker, in the plane, where nothing is displaced."""
    r = markers.position(m, d, m.hull_marker[k])
    share = 1.0 / sums[0] if sums[0] > 0.0 else 0.0
    return (r[0] + share * sums[1], r[1] + share * sums[2], share * sums[3])


@inlined
def waterplane(m, d, k):
    """(area m2, centre m in O, second moments about it m4: of y^2, x^2, x y) of hull k; none, the marker's place, where the
    plane does not cut it: rounding alone has no place.
    """
    r = markers.position(m, d, m.hull_marker[k])
    sums = displaced(m, d, k)
    comes_out = 0.0

    for j in range(m.hull_vertex[k], m.hull_vertex[k] + m.hull_vertices[k]):
        comes_out = max(comes_out, d.hull_point[3 * j + 2])

    area = sums[4] if comes_out > 0.0 else 0.0
    share = 1.0 / area if area > 0.0 else 0.0
    x = share * sums[5]
    y = share * sums[6]
    part = share * area
    moments = (part * (sums[8] - y * sums[6]), part * (sums[7] - x * sums[5]), part * (sums[9] - x * sums[6]))
    return area, (r[0] + x, r[1] + y, 0.0), moments
