"""Quasi-static elastic lines between two markers; the first may lie on a flat sea bed (docs/theory.md 16.15).

The unknowns are the pull at the upper end: H (N) towards the lower end, V (N) downwards. The distances (x, z) of the ends are the
gradient of the line's complementary energy E*(H, V), which is convex: Newton's method on it finds the one solution from anywhere.
What is kept in scratch is a function of what it is asked for: the last solution, and that at the middle of a cell of distances,
near which Newton's method begins. So no result depends on what was evaluated before.
"""

import math

from ..language import apart, inlined, kernel
from ..math import algebra as al
from ..motion import markers
from ..signatures import DATA, MODEL, Tuple, float64, int64
from . import line_ends

# gaps of the ends by the line's length: at which they are met, and from which on a step that does not lessen them is the last
MET = 1e-13
ROUNDED = 1e-9

# of distances by the line's length, to each of which a solution to begin from belongs
CELLS = 1024.0

MOST_STEPS = 100
MOST_HALVINGS = 50

# part of itself that H, and V on the bed, keep in a step
KEPT = 0.1


@inlined
def weight(m, k):
    """N/m, of line k in water."""
    return -m.gravity[2] * m.line_mass[k]


@inlined
def distances(L, w, EA, bed, H, V):
    """(x, z, dx/dH, dx/dV = dz/dH, dz/dV) of the ends of a line of length L (m), weight w (N/m), EA (N), pulled with H > 0, V."""
    s = math.sqrt(H * H + V * V)
    a = V - w * L

    if bed == 1 and a < 0.0:
        turned = math.asinh(V / H)
        x = L - V / w + H / w * turned + H * L / EA
        z = V * V / (w * (s + H)) + 0.5 * V * V / (EA * w)
        across = -V * V / (w * s * (s + H))
        return x, z, (turned - V / s) / w + L / EA, across, V / (s * w) + V / (EA * w)

    s_a = math.sqrt(H * H + a * a)

    # without a difference of what is nearly the same where all of the line leans to one side
    if V * a > 0.0:
        turned = math.asinh(w * L * (V + a) / (V * s_a + a * s))
    else:
        turned = math.asinh(V / H) - math.asinh(a / H)

    rise = L * (V + a) / (s + s_a)
    bent = V / s - a / s_a
    x = H / w * turned + H * L / EA
    z = rise + 0.5 * L * (V + a) / EA
    return x, z, (turned - bent) / w + L / EA, -H * rise / (s * s_a), bent / w + L / EA


@inlined
def first_guess(L, w, x, z):
    """A pull (H, V) near that of a line that does not stretch (Peyrot and Goulois 1979)."""
    span = max(x, 1e-3 * L)
    slack = (L * L - z * z) / (span * span) - 1.0
    droop = math.sqrt(3.0 * slack) if slack > 0.02 else 0.25
    return 0.5 * w * span / droop, 0.5 * w * (z / math.tanh(min(droop, 30.0)) + L)


@inlined
def kept_share(value, change):
    """How much of a change a positive value can take."""
    return (KEPT - 1.0) * value / change if value + change < KEPT * value else 1.0


@inlined
def limit(w, L, EA, bed, x, z):
    """(known, H, V): the pull of a line that no iteration is needed for: slack, or all of it on the bed."""
    if bed == 1:
        hanging = 2.0 * w * z / (1.0 + math.sqrt(1.0 + 2.0 * w * max(z, 0.0) / EA))

        if z <= 0.0:
            return True, max(0.0, EA * (x / L - 1.0)), 0.0

        if hanging <= w * L and x <= L - hanging / w:
            return True, 0.0, hanging

    return False, 0.0, 0.0


@kernel
def solve(w, L, EA, bed, x, z, H, V):
    """(H, V) of a line whose ends are x >= 0 and z (m) apart, from a guess; z >= 0 without a bed."""
    x1, z1, dx, across, dz = distances(L, w, EA, bed, H, V)
    gap = abs(x1 - x) + abs(z1 - z)

    for step in range(MOST_STEPS):
        if gap <= MET * L:
            break

        gx = x1 - x
        gz = z1 - z
        share = 1.0 / (dx * dz - across * across)
        change_H = share * (across * gz - dz * gx)
        change_V = share * (across * gx - dx * gz)
        slope = abs(gx * change_H + gz * change_V)
        share = kept_share(H, change_H)

        if bed == 1:
            share = min(share, kept_share(V, change_V))

        for halving in range(MOST_HALVINGS):
            x1, z1, dx, across, dz = distances(L, w, EA, bed, H + share * change_H, V + share * change_V)

            # of a convex function: the derivative along the step falls in size, or the step was too long
            if gap <= ROUNDED * L or abs((x1 - x) * change_H + (z1 - z) * change_V) <= slope:
                break

            share *= 0.5

        left = abs(x1 - x) + abs(z1 - z)

        if gap <= ROUNDED * L and left >= gap:
            break

        gap = left
        H += share * change_H
        V += share * change_V

    return H, V


@inlined
def is_known(d, at, w, L, EA, x, z):
    """Whether a line of these values at these distances was solved for, and stands at `at`."""
    p = d.line_known
    return p[at] == w and p[at + 1] == L and p[at + 2] == EA and p[at + 3] == x and p[at + 4] == z


@inlined
def know(d, at, w, L, EA, x, z, H, V):
    """Keeps what was found."""
    p = d.line_known
    p[at] = w
    p[at + 1] = L
    p[at + 2] = EA
    p[at + 3] = x
    p[at + 4] = z
    p[at + 5] = H
    p[at + 6] = V


@inlined
def nearby(m, d, k, w, L, EA, bed, x, z):
    """A guess at (H, V): from the solution at the middle of the cell of a grid of distances, on by its derivative."""
    cell = L / CELLS
    x0 = (math.floor(x / cell) + 0.5) * cell
    z0 = (math.floor(z / cell) + 0.5) * cell
    at = 18 * k + 7
    p = d.line_known

    if not is_known(d, at, w, L, EA, x0, z0):
        limited, H, V = limit(w, L, EA, bed, x0, z0)

        if limited:
            return first_guess(L, w, x, z)

        H, V = first_guess(L, w, x0, z0)
        H, V = solve(w, L, EA, bed, x0, z0, H, V)
        know(d, at, w, L, EA, x0, z0, H, V)
        x1, z1, dx, across, dz = distances(L, w, EA, bed, H, V)
        share = 1.0 / (dx * dz - across * across)
        p[at + 7] = share * dz
        p[at + 8] = -share * across
        p[at + 9] = share * dx

    H = p[at + 5] + p[at + 7] * (x - x0) + p[at + 8] * (z - z0)
    V = p[at + 6] + p[at + 8] * (x - x0) + p[at + 9] * (z - z0)

    # in a cell where the pull changes by more than itself its derivative says nothing
    if H <= KEPT * p[at + 5] or (bed == 1 and V <= KEPT * p[at + 6]) or not math.isfinite(H + V):
        return first_guess(L, w, x, z)

    return H, V


@apart(Tuple((float64, float64))(MODEL, DATA, int64, float64, float64))
def pull(m, d, k, x, z):
    """(H, V) of line k whose ends are x >= 0 and z (m) apart; z >= 0 without a bed."""
    L = m.line_length[k]
    EA = m.line_stiffness[k]
    w = weight(m, k)
    bed = m.line_bed[k]
    limited, H, V = limit(w, L, EA, bed, x, z)

    if limited:
        return H, V

    at = 18 * k

    if is_known(d, at, w, L, EA, x, z):
        return d.line_known[at + 5], d.line_known[at + 6]

    H, V = nearby(m, d, k, w, L, EA, bed, x, z)
    H, V = solve(w, L, EA, bed, x, z, H, V)
    know(d, at, w, L, EA, x, z, H, V)
    return H, V


@inlined
def line(m, d, k):
    """Line k now."""
    lower = m.line_from[k]
    upper = m.line_to[k]
    span = line_ends.from_lower(m, d, lower, upper)

    if m.line_bed[k] == 0 and span[2] < 0.0:
        lower = m.line_to[k]
        upper = m.line_from[k]
        span = al.neg(span)

    x, along = line_ends.across(span)
    H, V = pull(m, d, k, x, span[2])
    return line_ends.Line(lower, upper, along, x, span[2], H, V)


@inlined
def lower_pull(m, k, V):
    """N, downwards, with which the line pulls at the lower end's part of it, which pulls as much upwards at the lower end."""
    left = V - weight(m, k) * m.line_length[k]
    return max(left, 0.0) if m.line_bed[k] == 1 else left


@inlined
def forces_of(m, d, k):
    """(line, force on the upper end, on the lower end), N, inertial axes."""
    now = line(m, d, k)
    on_upper, on_lower = line_ends.forces(now, now.H, lower_pull(m, k, now.V))
    return now, on_upper, on_lower


@inlined
def add(m, d):
    """Their forces onto the bodies."""
    for k in range(m.n_line):
        now, on_upper, on_lower = forces_of(m, d, k)
        line_ends.add(m, d, now, on_upper, on_lower)


@inlined
def arc(H, V):
    """Integral of sqrt(H^2 + V^2) over V from 0 (N2)."""
    return 0.5 * (V * math.sqrt(H * H + V * V) + (H * H * math.asinh(V / H) if H > 0.0 else 0.0))


@inlined
def complement(L, w, EA, bed, H, V):
    """E* (J), whose gradient by (H, V) is (x, z)."""
    a = V - w * L
    along = 0.5 * H * H * L / EA

    if bed == 1 and a < 0.0:
        return (arc(H, V) - H * V) / w + H * L + along + V * V * V / (6.0 * EA * w)

    bent = (arc(H, V) - arc(H, a)) / w
    return bent + along + L * (3.0 * V * (V - w * L) + w * w * L * L) / (6.0 * EA)


@inlined
def energy_of(m, d, k):
    """J, of stretch and weight, that of the weight from the lower end on."""
    now = line(m, d, k)
    L = m.line_length[k]
    w = weight(m, k)
    stored = now.H * now.x + now.V * now.z
    stored -= complement(L, w, m.line_stiffness[k], m.line_bed[k], now.H, now.V)

    if m.line_bed[k] == 0:
        stored += w * L * markers.position(m, d, now.lower)[2]

    return stored


@inlined
def energy(m, d):
    """J, of all of them."""
    total = 0.0

    for k in range(m.n_line):
        total += energy_of(m, d, k)

    return total


@inlined
def power_of(m, d, k):
    """W, of line k on the bodies."""
    now, on_upper, on_lower = forces_of(m, d, k)
    return line_ends.power(m, d, now, on_upper, on_lower)


@inlined
def power(m, d):
    """W, on the bodies."""
    total = 0.0

    for k in range(m.n_line):
        total += power_of(m, d, k)

    return total


@inlined
def force_on(m, d, k, end):
    """Force (N, inertial axes) of line k on its first (0) or second (1) end."""
    now, on_upper, on_lower = forces_of(m, d, k)
    marker = m.line_to[k] if end == 1 else m.line_from[k]
    return on_upper if now.upper == marker else on_lower


@inlined
def grounded(m, d, k):
    """Length (m) of line k that lies on the bed."""
    now = line(m, d, k)
    return max(0.0, m.line_length[k] - now.V / weight(m, k)) if m.line_bed[k] == 1 else 0.0
