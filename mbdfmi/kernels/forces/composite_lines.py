"""Lines of several sections, with weights and buoys between them, and lines on a bed with friction (docs/theory.md 16.15).

The pull is that of composite_pulls.py, what the line does under it in composite_shapes.py. Friction has no memory: it is a
function of where the ends are, and so gives back, as the pull falls, some of what it took.
"""

import math

from ..language import inlined, kernel
from ..math import algebra as al
from ..motion import markers
from . import line_ends
from .composite_pulls import pull
from .composite_shapes import (
    WEIGHT,
    bottom,
    bounds,
    distances,
    last_section,
    least_pull,
    parts,
    pull_below,
    weigh,
    weight,
)
from .line_pieces import complement_of, piece


@inlined
def is_line(m, k):
    """Whether line k has values that lines may have: nothing floats where friction holds it to the bed."""
    grips = m.composite_bed[k] == 1 and m.composite_friction[k] > 0.0
    size = 0.0
    right = m.composite_friction[k] >= 0.0

    for i in range(m.composite_section[k], last_section(m, k) + 1):
        w = m.section_mass[i]
        size += abs(w) + abs(m.section_clump[i])
        right = right and m.section_length[i] > 0.0 and m.section_stiffness[i] > 0.0
        right = right and math.isfinite(m.section_length[i] + m.section_stiffness[i])
        right = right and not (grips and (w < 0.0 or m.section_clump[i] < 0.0))

    return right and size > 0.0 and math.isfinite(size + m.composite_friction[k])


@inlined
def reach(m, d, k):
    """(x, z) m from the first end of line k to the second, and the horizontal direction from one to the other."""
    span = line_ends.from_lower(m, d, m.composite_from[k], m.composite_to[k])
    x, along = line_ends.across(span)
    return x, span[2], along


@inlined
def line(m, d, k):
    """(line k now, its pull on the first end as of `anchor_pull`); its first end is the lower one, wherever that is."""
    x, z, along = reach(m, d, k)
    H, V, out, up = pulls(m, d, k, x, z)
    return line_ends.Line(m.composite_from[k], m.composite_to[k], along, x, z, H, V), out, up


@inlined
def anchor_pull(m, d, k, H, V):
    """(N towards the second end, N upwards): the pull on the first end."""
    if m.composite_bed[k] == 0:
        return H, V - d.composite_known[20 * k + WEIGHT]

    i = m.composite_section[k]
    whole = bottom(m, d, i)
    floor, cap = bounds(m, d, k, i, V)
    level = max(floor.at, min(whole, cap.at))
    return max(H - m.composite_friction[k] * (level - V), 0.0), level - whole


@inlined
def pulls(m, d, k, x, z):
    """(H, V, out, up): the pull (N) at the second end, x and z (m) from the first, and at the first."""
    H, V = pull(m, d, k, x, z)
    out, up = anchor_pull(m, d, k, H, V)
    return H, V, out, up


@inlined
def forces_of(m, d, k):
    """(line, force on the second end, on the first end), N, inertial axes."""
    now, out, up = line(m, d, k)
    on_second, on_first = line_ends.forces(now, out, up)
    return now, on_second, on_first


@inlined
def add(m, d):
    """Their forces onto the bodies."""
    for k in range(m.n_composite):
        now, on_second, on_first = forces_of(m, d, k)
        line_ends.add(m, d, now, on_second, on_first)


@inlined
def piece_energy(w, L, EA, H, c, top, bottom):
    """J, of stretch, and of weight over where it is lowest, of a piece at level c."""
    now = piece(w, L, EA, H, top, bottom)
    return c * now.z + H * now.x - complement_of(now, L, EA, H, top, bottom)


@kernel
def stored(m, d, k, x, z):
    """J, of stretch and weight, that over the bed or, without one, over the first end, of line k whose ends are x and z (m) apart."""
    pulled, V = pull(m, d, k, x, z)
    H = max(pulled, least_pull(d, k))
    energy = 0.0

    for i in range(m.composite_section[k], last_section(m, k) + 1):
        w = weight(m, i)
        EA = m.section_stiffness[i]
        floor, cap = bounds(m, d, k, i, V)
        of = parts(m, d, k, i, floor.at, cap.at, pulled, V)

        if of.up > 0.0:
            energy += piece_energy(w, of.up, EA, H, floor.at, of.up_top, of.up_bottom)

        if of.down > 0.0:
            energy += piece_energy(w, of.down, EA, H, cap.at, of.down_top, of.down_bottom)

        end = pull_below(m, k, i, of)
        energy += (of.pull * of.pull + of.pull * end + end * end) / 6.0 * of.slid / EA

    return energy


@inlined
def whole_weight(m, d, k):
    """N, of line k in water."""
    weigh(m, d, k)
    return d.composite_known[20 * k + WEIGHT]


@inlined
def energy_of(m, d, k):
    """J, of stretch and weight, that over the bed or, without one, over z = 0."""
    x, z, _ = reach(m, d, k)
    energy = stored(m, d, k, x, z)

    if m.composite_bed[k] == 0:
        energy += whole_weight(m, d, k) * markers.position(m, d, m.composite_from[k])[2]

    return energy


@inlined
def energy(m, d):
    """J, of all of them."""
    total = 0.0

    for k in range(m.n_composite):
        total += energy_of(m, d, k)

    return total


@inlined
def power_of(m, d, k):
    """W, of line k on the bodies."""
    now, on_second, on_first = forces_of(m, d, k)
    return line_ends.power(m, d, now, on_second, on_first)


@inlined
def power(m, d):
    """W, on the bodies."""
    total = 0.0

    for k in range(m.n_composite):
        total += power_of(m, d, k)

    return total


@inlined
def pull_rates(m, d, k, now, away, up):
    """(dH/dt, dV/dt), N/s, of line k whose ends part with `away` and `up` (m/s)."""
    x, z, x_H, x_V, z_H, z_V = distances(m, d, k, now.H, now.V)

    if now.z <= 0.0:
        return away / x_H, 0.0

    share = 1.0 / (x_H * z_V - x_V * z_H)
    return share * (z_V * away - x_V * up), share * (x_H * up - z_H * away)


@inlined
def dissipated_of(m, d, k):
    """W, that friction of the bed takes from line k: its force by the velocity of what slides."""
    CB = m.composite_friction[k]

    if CB == 0.0 or m.composite_bed[k] == 0:
        return 0.0

    now, out, _ = line(m, d, k)

    if now.H <= 0.0:
        return 0.0

    of_first = markers.velocity(m, d, m.composite_from[k])
    parting = al.sub(markers.velocity(m, d, m.composite_to[k]), of_first)
    H_rate, V_rate = pull_rates(m, d, k, now, al.dot(parting, now.along), parting[2])
    lost = (now.H - out) * al.dot(of_first, now.along)

    for i in range(m.composite_section[k], last_section(m, k) + 1):
        floor, cap = bounds(m, d, k, i, now.V)
        of = parts(m, d, k, i, floor.at, cap.at, now.H, now.V)
        held = now.H - 0.5 * (of.pull + pull_below(m, k, i, of))
        lost += held * of.slid / m.section_stiffness[i] * (H_rate + CB * V_rate)

    return lost


@inlined
def dissipated(m, d):
    """W, of all of them."""
    total = 0.0

    for k in range(m.n_composite):
        total += dissipated_of(m, d, k)

    return total


@inlined
def force_on(m, d, k, end):
    """Force (N, inertial axes) of line k on its first (0) or second (1) end."""
    now, on_second, on_first = forces_of(m, d, k)
    return on_second if end == 1 else on_first


@kernel
def flat(m, d, k, x, z):
    """Length (m) that lies on the bed of line k whose ends are x and z (m) apart."""
    H, V = pull(m, d, k, x, z)
    total = 0.0

    for i in range(m.composite_section[k], last_section(m, k) + 1):
        floor, cap = bounds(m, d, k, i, V)
        total += parts(m, d, k, i, floor.at, cap.at, H, V).flat

    return total


@inlined
def grounded(m, d, k):
    """Length (m) of line k that lies on the bed."""
    if m.composite_bed[k] == 0:
        return 0.0

    x, z, _ = reach(m, d, k)
    return flat(m, d, k, x, z)
