"""How the waves of the sea move the water at stations, points that stand still where members start, and anywhere (docs/theory.md 16.19).

Of each: velocity of the water (m/s), its pressure by density (m2/s2), elevation above it (m). Linear waves: velocities along the
way that a wave travels k g a / omega C cos(theta), upwards -k g a / omega S sin(theta), pressure g a C cos(theta), with
C, S = cosh, sinh(k (z + depth)) / cosh(k depth). Above the mean surface those of z = 0, or, stretched (Wheeler 1970), everywhere
those of z' = depth (z - eta) / (depth + eta). Sums of hundreds of components are kept at knots of time with their rates, and
between two there is a quintic, as in `waves`. Where members feel the waves of where they are, it is the plain sum.
"""

import math

from ..language import apart, inlined
from ..signatures import DATA, MODEL, Tuple, float64, int64, void
from . import waves

RING = 8
PER_KNOT = 10

# knots in the shortest of the periods
KNOTS = 12.0

# k z, below which nothing moves
DEEPEST = -300.0

# places of what is known of a station
VELOCITY = 0
PRESSURE = 3
ELEVATION = 4

# in the place of a station: the waves of where a point is
HERE = -2

PLACE = Tuple((float64,) * 8)


@inlined
def step(d):
    """s, from knot to knot."""
    return 2.0 * math.pi / (KNOTS * d.sea_known[5])


@inlined
def rise(m, d, x, y, t):
    """(elevation m, its rate m/s) at x, y at time t; cosine and sine of each component there."""
    above = 0.0
    rate = 0.0

    for p in range(m.n_sea_wave):
        a = 7 * p
        omega = d.sea_wave[a + 1]
        theta = omega * t + d.sea_wave[a + 2] - d.sea_wave[a + 3] * x - d.sea_wave[a + 4] * y
        c = math.cos(theta)
        s = math.sin(theta)
        d.station_turn[2 * p] = c
        d.station_turn[2 * p + 1] = s
        above += d.sea_wave[a] * c
        rate -= d.sea_wave[a] * omega * s

    return above, rate


@inlined
def depth_of(m, z, above, rate):
    """(z', its rate) at which the water moves as it does at z under an elevation and its rate."""
    if m.sea_water[3] == 0.0:
        return min(z, 0.0), 0.0

    depth = m.sea_water[0]

    if z >= above:
        return 0.0, 0.0

    if depth == 0.0:
        return z - above, -rate

    share = depth / (depth + above)
    return share * (z - above), -share * (depth + z) / (depth + above) * rate


@inlined
def motion(m, d, z, above, rate):
    """(velocity and pressure by density, their rates), four numbers each, at z under an elevation and its rate, of `rise`."""
    z, sinking = depth_of(m, z, above, rate)
    g = m.sea_water[1]
    x = 0.0
    y = 0.0
    w = 0.0
    pressure = 0.0
    x_rate = 0.0
    y_rate = 0.0
    w_rate = 0.0
    pressure_rate = 0.0

    for p in range(m.n_sea_wave):
        a = 7 * p
        omega = d.sea_wave[a + 1]
        k = d.sea_wave[a + 5]
        c = d.station_turn[2 * p]
        s = d.station_turn[2 * p + 1]
        mirrored = d.sea_wave[a + 6]
        falls = math.exp(max(k * z, DEEPEST))
        share = g * d.sea_wave[a] / (1.0 + mirrored)
        C = share * (falls + mirrored / falls)
        S = share * (falls - mirrored / falls)

        # rates where the station stands, and as z' sinks
        p_rate = -omega * C * s + k * S * sinking * c
        up = -k / omega * S * s
        up_rate = -k / omega * (omega * S * c + k * C * sinking * s)

        along = d.sea_wave[a + 3] / omega
        x += along * C * c
        x_rate += along * p_rate
        along = d.sea_wave[a + 4] / omega
        y += along * C * c
        y_rate += along * p_rate
        w += up
        w_rate += up_rate
        pressure += C * c
        pressure_rate += p_rate

    return x, y, w, pressure, x_rate, y_rate, w_rate, pressure_rate


@apart(PLACE(MODEL, DATA, float64, float64, float64))
def here(m, d, x, y, z):
    """The same at a place (m, in O) now."""
    above, rate = rise(m, d, x, y, d.now[0])
    return motion(m, d, z, above, rate)


@inlined
def place(m, slot, n):
    """Where station n stands in the ring."""
    return PER_KNOT * (m.n_station * slot + n)


@apart(void(MODEL, DATA, int64, int64))
def fill_knot(m, d, j, slot):
    """Knot j of all stations into the ring."""
    t = j * step(d)

    for n in range(m.n_station):
        at = place(m, slot, n)
        alike = n > 0 and m.station_r[3 * n] == m.station_r[3 * n - 3]

        # along an upright member the waves are the same
        if alike and m.station_r[3 * n + 1] == m.station_r[3 * n - 2]:
            d.station_knot[at + ELEVATION] = d.station_knot[at - PER_KNOT + ELEVATION]
            d.station_knot[at + 5 + ELEVATION] = d.station_knot[at - PER_KNOT + 5 + ELEVATION]
        else:
            above, rate = rise(m, d, m.station_r[3 * n], m.station_r[3 * n + 1], t)
            d.station_knot[at + ELEVATION] = above
            d.station_knot[at + 5 + ELEVATION] = rate

        p = d.station_knot
        moved = motion(m, d, m.station_r[3 * n + 2], p[at + ELEVATION], p[at + 5 + ELEVATION])
        p[at], p[at + 1], p[at + 2], p[at + 3] = moved[0], moved[1], moved[2], moved[3]
        p[at + 5], p[at + 6], p[at + 7], p[at + 8] = moved[4], moved[5], moved[6], moved[7]

    d.sea_known[6 + slot] = 2.0 * j + 1.0


@inlined
def knot(m, d, j):
    """The slot of knot j in the ring."""
    slot = j % RING

    if d.sea_known[6 + slot] != 2.0 * j + 1.0:
        fill_knot(m, d, j, slot)

    return slot


@inlined
def at_time(m, d, t):
    """(slots of the four knots around time t (s), where t is between the middle two from 0 to 1)."""
    waves.ready(m, d)
    D = step(d)
    j = math.floor(t / D)
    return (knot(m, d, j - 1), knot(m, d, j), knot(m, d, j + 1), knot(m, d, j + 2)), t / D - j


@inlined
def bent(p, before, at, after, D):
    """Half the second derivative by D2 at a knot, of order 4, by values and rates at its neighbours."""
    return p[after] - 2.0 * p[at] + p[before] - 0.25 * D * (p[after + 5] - p[before + 5])


@inlined
def quintic(m, d, slots, n, i):
    """Coefficients of number i of station n between the middle two of four knots."""
    p = d.station_knot
    D = step(d)
    b = place(m, slots[1], n) + i
    c = place(m, slots[2], n) + i
    y = p[b]
    v = D * p[b + 5]
    w = bent(p, place(m, slots[0], n) + i, b, c, D)
    y1 = p[c] - (y + v + w)
    v1 = D * p[c + 5] - (v + 2.0 * w)
    w1 = bent(p, b, c, place(m, slots[3], n) + i, D) - w
    c3 = 10.0 * y1 - 4.0 * v1 + w1
    c4 = -15.0 * y1 + 7.0 * v1 - 2.0 * w1
    return y, v, w, c3, c4, 6.0 * y1 - 3.0 * v1 + w1


@inlined
def value(m, d, when, n, i):
    """(number i of station n, its rate) at a time; when : of `at_time`."""
    slots, s = when
    y, v, w, c3, c4, c5 = quintic(m, d, slots, n, i)
    rate = v + s * (2.0 * w + s * (3.0 * c3 + s * (4.0 * c4 + s * 5.0 * c5)))
    return y + s * (v + s * (w + s * (c3 + s * (c4 + s * c5)))), rate / step(d)


@inlined
def rate_of_rate(m, d, when, n, i):
    """The second derivative by time of number i of station n."""
    slots, s = when
    D = step(d)
    y, v, w, c3, c4, c5 = quintic(m, d, slots, n, i)
    return (2.0 * w + s * (6.0 * c3 + s * (12.0 * c4 + s * 20.0 * c5))) / (D * D)


@inlined
def moves(m, d, when, n):
    """(velocity m/s, acceleration m/s2) of the water at station n."""
    x, ax = value(m, d, when, n, 0)
    y, ay = value(m, d, when, n, 1)
    z, az = value(m, d, when, n, 2)
    return (x, y, z), (ax, ay, az)
