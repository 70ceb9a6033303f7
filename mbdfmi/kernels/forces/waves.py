"""What the waves of the sea do to bodies: sums of components over time (docs/theory.md 16.17).

F(t) = sum over k of Re(F_k e^(i omega_k t)) of six numbers, force and moment at a marker in inertial axes. F_k is what a file says
of the component's frequency and heading: bicubic between its points, by values and derivatives at these. A sum of hundreds of
components is dear, so its value and three derivatives are kept at knots j D of time, a ring of them, and between two knots there
is a polynomial of degree 7. What a knot holds depends on its time and on parameters alone: what is kept in scratch changes no result.

Where waves meet a body where it is, and not where it starts, each component lags by k . (p - p_0), p its marker's place now: that
is the plain sum, anew at each evaluation. Where loads turn with the body (water_axes.py), heading less yaw is what counts: of each
component what it does is kept at the headings of the file, cubic between them, and the sum is in the axes of the body's yaw.
"""

import math

from ..language import apart, inlined, kernel
from ..math import algebra as al
from ..motion import markers
from ..signatures import DATA, MODEL, Tuple, float64, int64, void
from . import sea, water_axes

RING = 8
PER_KNOT = 24

# knots in the shortest of the periods
KNOTS = 8.0

# rad, by which a heading may be beyond the last one that is known
BESIDE = 1e-6

WRENCH = Tuple((float64,) * 6)


@inlined
def ready(m, d):
    """The components, and what they do to bodies, of the parameters as they are."""
    if not sea.is_made(m, d):
        sea.make(m, d)

        for k in range(m.n_excitation):
            if m.excitation_turns[k] < 0:
                make_parts(m, d, k)
            else:
                make_heading_parts(m, d, k)


@kernel
def elevation(m, d, t, x, y):
    """Of the undisturbed sea at (x, y) at time t (m)."""
    ready(m, d)
    return sea.elevation(m, d, t, x, y)


@inlined
def interval(m, first, n, x):
    """The last of the first n - 1 of n ascending grid values that is not above x, the first where all are."""
    j = 0

    while j < n - 2 and m.grid_value[first + j + 1] <= x:
        j += 1

    return j


@inlined
def heading_known(m, k, heading):
    """A heading (rad) as the grid of excitation k counts them: less than one turn above its first, but for rounding."""
    first = m.grid_value[m.excitation_grid[4 * k] + m.excitation_grid[4 * k + 1]]
    turns = math.floor((heading - first + BESIDE) / (2.0 * math.pi))
    return heading - 2.0 * math.pi * turns


@inlined
def knows_headings(m, k):
    """Whether the file of excitation k has waves of all the sea's directions."""
    at = m.excitation_grid[4 * k] + m.excitation_grid[4 * k + 1]
    last = m.grid_value[at + m.excitation_grid[4 * k + 2] - 1]

    for p in range(m.n_sea_wave):
        if heading_known(m, k, m.sea_value[2] + m.sea_unit[4 * p + 3]) > last + BESIDE:
            return False

    return True


@inlined
def are_known(m):
    """Whether that is so of all excitations."""
    known = True

    for k in range(m.n_excitation):
        known = known and knows_headings(m, k)

    return known


@inlined
def weights(t, h):
    """Of values and slopes at the ends of an interval of length h, at t from 0 to 1 (Hermite)."""
    u = 1.0 - t
    return u * u * (1.0 + 2.0 * t), h * t * u * u, t * t * (3.0 - 2.0 * t), -h * t * t * u


@inlined
def share(m, first, n, x):
    """(interval, weights at x) in n grid values; held beyond the ends, all of one value is that."""
    if n == 1:
        return 0, (1.0, 0.0, 0.0, 0.0)

    j = interval(m, first, n, x)
    h = m.grid_value[first + j + 1] - m.grid_value[first + j]
    t = min(max((x - m.grid_value[first + j]) / h, 0.0), 1.0)
    return j, weights(t, h)


@inlined
def arriving(m, d, k, p):
    """(real, imaginary) amplitude (m) of component p at time 0 where excitation k is told to be."""
    way = d.sea_wave[7 * p + 3] * m.excitation_place[2 * k]
    way += d.sea_wave[7 * p + 4] * m.excitation_place[2 * k + 1]
    phase = d.sea_wave[7 * p + 2] - way
    return d.sea_wave[7 * p] * math.cos(phase), d.sea_wave[7 * p] * math.sin(phase)


@inlined
def at_frequency(m, q, headings, n, along, i):
    """Number i of a point, of values or derivatives by heading, between two frequencies, whose derivatives stand 12 behind.

    q : where the point at the lower frequency stands; of n frequencies, with weights `along`.
    """
    found = along[0] * m.point_force[q + i] + along[1] * m.point_force[q + 12 + i]

    if n > 1:
        q += 48 * headings
        found += along[2] * m.point_force[q + i] + along[3] * m.point_force[q + 12 + i]

    return found


@apart(void(MODEL, DATA, int64))
def make_heading_parts(m, d, k):
    """What the components of excitation k do as they arrive at its place, at all headings of the file, in axes that turn with it."""
    first = m.excitation_grid[4 * k]
    n = m.excitation_grid[4 * k + 1]
    headings = m.excitation_grid[4 * k + 2]

    for p in range(m.n_sea_wave):
        j, along = share(m, first, n, d.sea_wave[7 * p + 1])
        c, s = arriving(m, d, k, p)

        for l in range(headings):
            q = 48 * (m.excitation_grid[4 * k + 3] + headings * j + l)
            at = 24 * (m.excitation_turns[k] + headings * p + l)

            for i in range(6):
                for slope in range(2):
                    re = at_frequency(m, q, headings, n, along, 24 * slope + i)
                    im = at_frequency(m, q, headings, n, along, 24 * slope + 6 + i)
                    d.heading_force[at + 12 * slope + i] = re * c - im * s
                    d.heading_force[at + 12 * slope + 6 + i] = re * s + im * c


@apart(void(MODEL, DATA, int64))
def make_parts(m, d, k):
    """F_k of the components of excitation k, as they arrive at its place."""
    first = m.excitation_grid[4 * k]
    n = m.excitation_grid[4 * k + 1]
    headings = m.excitation_grid[4 * k + 2]

    for p in range(m.n_sea_wave):
        heading = heading_known(m, k, m.sea_value[2] + m.sea_unit[4 * p + 3])
        j, along = share(m, first, n, d.sea_wave[7 * p + 1])
        l, across = share(m, first + n, headings, heading)
        c, s = arriving(m, d, k, p)
        at = 12 * (m.n_sea_wave * k + p)

        for i in range(6):
            re = 0.0
            im = 0.0

            # corners of the cell, where there are two
            for a in range(2 if n > 1 else 1):
                for b in range(2 if headings > 1 else 1):
                    q = 48 * (m.excitation_grid[4 * k + 3] + headings * (j + a) + l + b)
                    w, w_slope = along[2 * a], along[2 * a + 1]
                    v, v_slope = across[2 * b], across[2 * b + 1]
                    re += w * (v * m.point_force[q + i] + v_slope * m.point_force[q + 24 + i])
                    re += w_slope * (v * m.point_force[q + 12 + i] + v_slope * m.point_force[q + 36 + i])
                    im += w * (v * m.point_force[q + 6 + i] + v_slope * m.point_force[q + 30 + i])
                    im += w_slope * (v * m.point_force[q + 18 + i] + v_slope * m.point_force[q + 42 + i])

            d.part_force[at + i] = re * c - im * s
            d.part_force[at + 6 + i] = re * s + im * c


@inlined
def step(d):
    """s, from knot to knot."""
    return 2.0 * math.pi / (KNOTS * d.sea_known[5])


@apart(void(MODEL, DATA, int64, int64, int64))
def fill_knot(m, d, k, j, slot):
    """Knot j of element k into its ring: values, then three derivatives of 6 components each, by D."""
    at = PER_KNOT * (RING * k + slot)
    D = step(d)
    t = j * D

    for i in range(PER_KNOT):
        d.excitation_knot[at + i] = 0.0

    for p in range(m.n_sea_wave):
        omega = d.sea_wave[7 * p + 1]
        c = math.cos(omega * t)
        s = math.sin(omega * t)
        turn = omega * D
        square = turn * turn
        begin = 12 * (m.n_sea_wave * k + p)

        for i in range(6):
            re = d.part_force[begin + i]
            im = d.part_force[begin + 6 + i]
            value = re * c - im * s
            rate = -turn * (re * s + im * c)
            d.excitation_knot[at + i] += value
            d.excitation_knot[at + 6 + i] += rate
            d.excitation_knot[at + 12 + i] -= square * value
            d.excitation_knot[at + 18 + i] -= square * rate

    d.excitation_key[RING * k + slot] = 2.0 * j + 1.0


@inlined
def knot(m, d, k, j):
    """Where knot j of element k stands in the ring."""
    slot = j % RING

    # an odd number, since scratch is zero at first
    if d.excitation_key[RING * k + slot] != 2.0 * j + 1.0:
        fill_knot(m, d, k, j, slot)

    return PER_KNOT * (RING * k + slot)


@inlined
def between(p, a, b, i, s):
    """Component i of the polynomial from knot a to knot b at s from 0 to 1."""
    y = p[a + i]
    v = p[a + 6 + i]
    c = 0.5 * p[a + 12 + i]
    e = p[a + 18 + i] / 6.0
    y1 = p[b + i] - (y + v + c + e)
    v1 = p[b + 6 + i] - (v + 2.0 * c + 3.0 * e)
    c1 = 0.5 * p[b + 12 + i] - (c + 3.0 * e)
    e1 = p[b + 18 + i] / 6.0 - e
    c4 = 35.0 * y1 - 15.0 * v1 + 5.0 * c1 - e1
    c5 = -84.0 * y1 + 39.0 * v1 - 14.0 * c1 + 3.0 * e1
    c6 = 70.0 * y1 - 34.0 * v1 + 13.0 * c1 - 3.0 * e1
    c7 = -20.0 * y1 + 10.0 * v1 - 4.0 * c1 + e1
    return y + s * (v + s * (c + s * (e + s * (c4 + s * (c5 + s * (c6 + s * c7))))))


@inlined
def follows(m, k):
    """Whether waves meet element k where it is."""
    return m.n_follow > 0 and m.excitation_follows[k] == 1


@inlined
def strayed(m, d, k):
    """(x, y) of the marker of element k from where phases are told about (m); 0 of one that does not follow."""
    if not follows(m, k):
        return 0.0, 0.0

    r = markers.position(m, d, m.excitation_marker[k])
    return r[0] - m.follow_place[2 * k], r[1] - m.follow_place[2 * k + 1]


@apart(WRENCH(MODEL, DATA, int64, float64, float64, float64))
def sum_beside(m, d, k, t, x, y):
    """Force (N) and moment (N m) on element k at time t (s) by all components, phases those at (x, y) m from its first place."""
    ready(m, d)
    force = al.ZERO3
    moment = al.ZERO3

    for p in range(m.n_sea_wave):
        phase = d.sea_wave[7 * p + 1] * t - d.sea_wave[7 * p + 3] * x - d.sea_wave[7 * p + 4] * y
        c = math.cos(phase)
        s = -math.sin(phase)
        at = 4 * (m.n_sea_wave * k + p)
        force = al.axpy(c, al.vec3(d.part_force, at), al.axpy(s, al.vec3(d.part_force, at + 2), force))
        moment = al.axpy(c, al.vec3(d.part_force, at + 1), al.axpy(s, al.vec3(d.part_force, at + 3), moment))

    return force[0], force[1], force[2], moment[0], moment[1], moment[2]


@apart(WRENCH(MODEL, DATA, int64))
def sum_as_it_heads(m, d, k):
    """Force (N) and moment (N m) on element k now by all components, of their headings less its yaw."""
    ready(m, d)
    headings = m.excitation_grid[4 * k + 2]
    cosine, sine = water_axes.heading(markers.axes(m, d, m.excitation_marker[k]))
    yaw = math.atan2(sine, cosine)
    x, y = strayed(m, d, k)
    l = 0
    across = (1.0, 0.0, 0.0, 0.0)
    force = al.ZERO3
    moment = al.ZERO3

    for p in range(m.n_sea_wave):
        # most seas travel one way
        if p == 0 or m.sea_unit[4 * p + 3] != m.sea_unit[4 * p - 1]:
            beside = heading_known(m, k, m.sea_value[2] + m.sea_unit[4 * p + 3] - yaw)
            l, across = share(m, m.excitation_grid[4 * k] + m.excitation_grid[4 * k + 1], headings, beside)

        phase = d.sea_wave[7 * p + 1] * d.now[0] - d.sea_wave[7 * p + 3] * x - d.sea_wave[7 * p + 4] * y
        c = math.cos(phase)
        s = -math.sin(phase)

        for b in range(2):
            at = 8 * (m.excitation_turns[k] + headings * p + l + b)

            for slope in range(2):
                share_c = across[2 * b + slope] * c
                share_s = across[2 * b + slope] * s
                q = at + 4 * slope
                force = al.axpy(share_c, al.vec3(d.heading_force, q), force)
                moment = al.axpy(share_c, al.vec3(d.heading_force, q + 1), moment)
                force = al.axpy(share_s, al.vec3(d.heading_force, q + 2), force)
                moment = al.axpy(share_s, al.vec3(d.heading_force, q + 3), moment)

    A = water_axes.turned(cosine, sine)
    force = al.mat_vec(A, force)
    moment = al.mat_vec(A, moment)
    return force[0], force[1], force[2], moment[0], moment[1], moment[2]


@inlined
def at_place(m, d, k, t):
    """Force (N) and moment (N m) on element k at time t (s), as waves meet it where it starts."""
    ready(m, d)
    D = step(d)
    j = math.floor(t / D)
    s = t / D - j
    a = knot(m, d, k, j)
    b = knot(m, d, k, j + 1)
    p = d.excitation_knot
    force = (between(p, a, b, 0, s), between(p, a, b, 1, s), between(p, a, b, 2, s))
    moment = (between(p, a, b, 3, s), between(p, a, b, 4, s), between(p, a, b, 5, s))
    return force[0], force[1], force[2], moment[0], moment[1], moment[2]


@inlined
def wrench(m, d, k):
    """Of element k on its body at its marker now: (moment N m, force N), inertial axes."""
    if m.excitation_turns[k] >= 0:
        f = sum_as_it_heads(m, d, k)
    elif follows(m, k):
        x, y = strayed(m, d, k)
        f = sum_beside(m, d, k, d.now[0], x, y)
    else:
        f = at_place(m, d, k, d.now[0])

    return (f[3], f[4], f[5]), (f[0], f[1], f[2])


@inlined
def add(m, d):
    """Their wrenches onto the bodies."""
    for k in range(m.n_excitation):
        moment, force = wrench(m, d, k)
        b = m.excitation_marker[k]
        markers.add_wrench(m, d, m.marker_body[b], markers.position(m, d, b), moment, force)


@inlined
def power_of(m, d, k):
    """W, of element k on its body."""
    moment, force = wrench(m, d, k)
    return markers.power(m, d, m.excitation_marker[k], moment, force)


@inlined
def power(m, d):
    """W, on the bodies."""
    total = 0.0

    for k in range(m.n_excitation):
        total += power_of(m, d, k)

    return total


@inlined
def supplied(m, d):
    """W, all of it from the sea."""
    return power(m, d)
