"""What a trace takes for one operation: loads of waves, water that they move, pulls of lines (mbdfmi/trace/solutions.py).

Each is a function of a few numbers x and of parameters, which loops that end by values find; what is kept in scratch changes no
result. `solve` gives its numbers y, or, of kind N_KIND + kind, their derivatives by x, a row for each of y: those of an interpolant are
its own, those of what is solved for follow from the implicit function's theorem.
"""

import math

from ..language import apart, inlined, kernel
from ..signatures import DATA, MODEL, REALS, int64
from . import catenaries, composite_lines, composite_shapes, stations, waves

# x -> y of each kind, and of what there is one each
AT_PLACE = 0  # t -> force, moment, of excitation k as waves meet it where it starts
BESIDE = 1  # t, x, y from there -> likewise
ELEVATION = 2  # t, x, y -> elevation
STATION = 3  # t -> numbers of station k and their rates, in turn
CATENARY = 4  # x, z, and weight by length, length, stiffness -> H, V of line k
PULLS = 5  # x, z -> H, V, out, up of composite line k
STORED = 6  # x, z -> its energy
FLAT = 7  # x, z -> what lies of it
N_KIND = 8

# of each: numbers x, numbers y
WIDTHS = ((1, 6), (3, 6), (3, 1), (1, 10), (5, 2), (2, 4), (2, 1), (2, 1))


@inlined
def store6(y, at, f):
    """Six numbers into y from `at` on."""
    for i in range(6):
        y[at + i] = f[i]


@inlined
def between_rate(p, a, b, i, s):
    """The derivative of `waves.between` by s."""
    y = p[a + i]
    v = p[a + 6 + i]
    c = 0.5 * p[a + 12 + i]
    e = p[a + 18 + i] / 6.0
    y1 = p[b + i] - (y + v + c + e)
    v1 = p[b + 6 + i] - (v + 2.0 * c + 3.0 * e)
    c1 = 0.5 * p[b + 12 + i] - (c + 3.0 * e)
    e1 = p[b + 18 + i] / 6.0 - e
    c4 = 4.0 * (35.0 * y1 - 15.0 * v1 + 5.0 * c1 - e1)
    c5 = 5.0 * (-84.0 * y1 + 39.0 * v1 - 14.0 * c1 + 3.0 * e1)
    c6 = 6.0 * (70.0 * y1 - 34.0 * v1 + 13.0 * c1 - 3.0 * e1)
    c7 = 7.0 * (-20.0 * y1 + 10.0 * v1 - 4.0 * c1 + e1)
    return v + s * (2.0 * c + s * (3.0 * e + s * (c4 + s * (c5 + s * (c6 + s * c7)))))


@kernel
def rates_at_place(m, d, k, t, y):
    """Of force and moment of excitation k, into y."""
    waves.ready(m, d)
    D = waves.step(d)
    j = math.floor(t / D)
    a = waves.knot(m, d, k, j)
    b = waves.knot(m, d, k, j + 1)

    for i in range(6):
        y[i] = between_rate(d.excitation_knot, a, b, i, t / D - j) / D


@kernel
def slopes_beside(m, d, k, t, x, y, found):
    """Of force and moment of excitation k by time and by its place (x, y), into `found`."""
    waves.ready(m, d)

    for i in range(18):
        found[i] = 0.0

    for p in range(m.n_sea_wave):
        omega = d.sea_wave[7 * p + 1]
        along = d.sea_wave[7 * p + 3]
        across = d.sea_wave[7 * p + 4]
        phase = omega * t - along * x - across * y
        c = math.cos(phase)
        s = math.sin(phase)
        at = 12 * (m.n_sea_wave * k + p)

        for i in range(6):
            turned = -s * d.part_force[at + i] - c * d.part_force[at + 6 + i]
            found[3 * i] += omega * turned
            found[3 * i + 1] -= along * turned
            found[3 * i + 2] -= across * turned


@kernel
def slopes_of_elevation(m, d, t, x, y, found):
    """Of the sea's elevation by time and by place (x, y), into `found`."""
    waves.ready(m, d)
    found[0] = 0.0
    found[1] = 0.0
    found[2] = 0.0

    for p in range(m.n_sea_wave):
        a = 7 * p
        phase = d.sea_wave[a + 1] * t + d.sea_wave[a + 2] - d.sea_wave[a + 3] * x - d.sea_wave[a + 4] * y
        falls = -d.sea_wave[a] * math.sin(phase)
        found[0] += d.sea_wave[a + 1] * falls
        found[1] -= d.sea_wave[a + 3] * falls
        found[2] -= d.sea_wave[a + 4] * falls


@kernel
def of_station(m, d, n, t, slopes, y):
    """Numbers of station n and their rates in turn, or, slopes : 1, the derivatives of these, into y."""
    when = stations.at_time(m, d, t)

    for i in range(5):
        value, rate = stations.value(m, d, when, n, i)
        y[2 * i] = rate if slopes == 1 else value
        y[2 * i + 1] = stations.rate_of_rate(m, d, when, n, i) if slopes == 1 else rate


@kernel
def slopes_of_catenary(m, d, k, x, z, y):
    """Of (H, V) of line k, no limit of which is met, by x, z, weight by length, length and stiffness, into y."""
    H, V = catenaries.pull(m, d, k, x, z)
    w = catenaries.weight(m, k)
    L = m.line_length[k]
    EA = m.line_stiffness[k]
    x1, z1, x_H, x_V, z_V = catenaries.distances(L, w, EA, m.line_bed[k], H, V)
    a = V - w * L

    # of the distances by length, and how much of them is stretch
    if m.line_bed[k] == 1 and a < 0.0:
        x_L = 1.0 + H / EA
        z_L = 0.0
        stretch = 0.5 * V * V / (EA * w)
    else:
        s = math.sqrt(H * H + a * a)
        x_L = H / s + H / EA
        z_L = a / s + a / EA
        stretch = 0.5 * L * (V + a) / EA

    x_EA = -H * L / (EA * EA)
    z_EA = -stretch / EA

    # all forces twice as large: the same distances
    x_w = -(H * x_H + V * x_V + EA * x_EA) / w
    z_w = -(H * x_V + V * z_V + EA * z_EA) / w
    share = 1.0 / (x_H * z_V - x_V * x_V)
    H_x = share * z_V
    H_z = -share * x_V
    V_z = share * x_H
    y[0] = H_x
    y[1] = H_z
    y[2] = -(H_x * x_w + H_z * z_w)
    y[3] = -(H_x * x_L + H_z * z_L)
    y[4] = -(H_x * x_EA + H_z * z_EA)
    y[5] = H_z
    y[6] = V_z
    y[7] = -(H_z * x_w + V_z * z_w)
    y[8] = -(H_z * x_L + V_z * z_L)
    y[9] = -(H_z * x_EA + V_z * z_EA)


@kernel
def stiffness(m, d, k, x, z):
    """(H, V, dH/dx, dH/dz, dV/dx, dV/dz) of composite line k whose ends are x and z (m) apart."""
    H, V = composite_lines.pull(m, d, k, x, z)
    x1, z1, x_H, x_V, z_H, z_V = composite_shapes.distances(m, d, k, H, V)

    if m.composite_bed[k] == 1 and z <= 0.0:
        if H <= 0.0:
            return H, V, 0.0, 0.0, 0.0, 0.0

        by_H = composite_shapes.lowest(m, d, k, H)[1]
        H_x = 1.0 / (x_H + x_V * by_H)
        return H, V, H_x, 0.0, H_x * by_H, 0.0

    if H <= 0.0:
        return H, V, 0.0, 0.0, 0.0, 1.0 / z_V

    share = 1.0 / (x_H * z_V - x_V * z_H)
    return H, V, share * z_V, -share * x_V, -share * z_H, share * x_H


@inlined
def anchored(m, d, k, H, V):
    """(dout/dH, dout/dV, dup/dH, dup/dV) of the pull on the first end of composite line k, by that on the second."""
    if m.composite_bed[k] == 0:
        return 1.0, 0.0, 0.0, 1.0

    i = m.composite_section[k]
    whole = composite_shapes.bottom(m, d, i)
    floor, cap = composite_shapes.bounds(m, d, k, i, V)
    by_H = 0.0
    by_V = 0.0

    if floor.at >= min(whole, cap.at):
        by_H = floor.by_H
        by_V = floor.by_V
    elif cap.at <= whole:
        by_H = cap.by_H
        by_V = cap.by_V

    level = max(floor.at, min(whole, cap.at))
    CB = m.composite_friction[k]
    pulls = 1.0 if H - CB * (level - V) > 0.0 else 0.0
    return pulls * (1.0 - CB * by_H), pulls * CB * (1.0 - by_V), by_H, by_V


@kernel
def slopes_of_pulls(m, d, k, x, z, y):
    """Of (H, V, out, up) of composite line k by x and z, into y."""
    H, V, H_x, H_z, V_x, V_z = stiffness(m, d, k, x, z)
    out_H, out_V, up_H, up_V = anchored(m, d, k, H, V)
    y[0] = H_x
    y[1] = H_z
    y[2] = V_x
    y[3] = V_z
    y[4] = out_H * H_x + out_V * V_x
    y[5] = out_H * H_z + out_V * V_z
    y[6] = up_H * H_x + up_V * V_x
    y[7] = up_H * H_z + up_V * V_z


@kernel
def slopes_of_flat(m, d, k, x, z, y):
    """Of what lies of composite line k by x and z, into y."""
    H, V, H_x, H_z, V_x, V_z = stiffness(m, d, k, x, z)
    by_H = 0.0
    by_V = 0.0

    for i in range(m.composite_section[k], composite_shapes.last_section(m, k) + 1):
        floor, cap = composite_shapes.bounds(m, d, k, i, V)

        if composite_shapes.parts(m, d, k, i, floor.at, cap.at, H, V).flat > 0.0:
            rises = 1.0 if floor.at > d.section_top[i] else 0.0
            falls = 1.0 if composite_shapes.bottom(m, d, i) > cap.at else 0.0
            w = composite_shapes.weight(m, i)
            by_H += (falls * cap.by_H - rises * floor.by_H) / w
            by_V += (falls * cap.by_V - rises * floor.by_V) / w

    y[0] = by_H * H_x + by_V * V_x
    y[1] = by_H * H_z + by_V * V_z


@inlined
def solve_waves(m, d, kind, k, x, y):
    """Those of waves."""
    if kind == AT_PLACE:
        store6(y, 0, waves.at_place(m, d, k, x[0]))
    elif kind == BESIDE:
        store6(y, 0, waves.sum_beside(m, d, k, x[0], x[1], x[2]))
    elif kind == ELEVATION:
        y[0] = waves.elevation(m, d, x[0], x[1], x[2])
    elif kind == N_KIND + AT_PLACE:
        rates_at_place(m, d, k, x[0], y)
    elif kind == N_KIND + BESIDE:
        slopes_beside(m, d, k, x[0], x[1], x[2], y)
    elif kind == N_KIND + ELEVATION:
        slopes_of_elevation(m, d, x[0], x[1], x[2], y)
    elif kind == STATION or kind == N_KIND + STATION:
        of_station(m, d, k, x[0], 1 if kind >= N_KIND else 0, y)


@inlined
def solve_composite(m, d, kind, k, x, y):
    """Those of lines of several sections."""
    if kind == PULLS:
        H, V, out, up = composite_lines.pulls(m, d, k, x[0], x[1])
        y[0] = H
        y[1] = V
        y[2] = out
        y[3] = up
    elif kind == STORED:
        y[0] = composite_lines.stored(m, d, k, x[0], x[1])
    elif kind == FLAT:
        y[0] = composite_lines.flat(m, d, k, x[0], x[1])
    elif kind == N_KIND + PULLS:
        slopes_of_pulls(m, d, k, x[0], x[1], y)
    elif kind == N_KIND + STORED:
        # without friction
        H, V = composite_lines.pull(m, d, k, x[0], x[1])
        y[0] = H
        y[1] = V
    elif kind == N_KIND + FLAT:
        slopes_of_flat(m, d, k, x[0], x[1], y)


@apart(int64(MODEL, DATA, int64, int64, REALS, REALS), "mbdfmi_solve")
def solve(m, d, kind, k, x, y):
    """What element k gives for x into y; kind N_KIND + kind: its derivatives. Returns a status, of success."""
    if m.n_sea > 0:
        solve_waves(m, d, kind, k, x, y)

    if m.n_line > 0:
        if kind == CATENARY:
            H, V = catenaries.pull(m, d, k, x[0], x[1])
            y[0] = H
            y[1] = V
        elif kind == N_KIND + CATENARY:
            slopes_of_catenary(m, d, k, x[0], x[1], y)

    if m.n_composite > 0:
        solve_composite(m, d, kind, k, x, y)

    return 0
