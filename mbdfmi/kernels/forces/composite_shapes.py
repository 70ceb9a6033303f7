"""How a line of several sections lies and hangs that is pulled with (H, V) at its second end (docs/theory.md 16.15).

Of the weight W(s) above s (N) the vertical pull at s is V - W(s) where nothing carries the line. A bed adds what it bears above s,
R = max(W' - V, 0), where W' is W made not to rise towards the second end. It is W itself, but where a buoy or a section that floats
lifts part of the line off the bed: there it is level, so high that this part comes down to the bed again. Pools of what is out of
order, as in isotonic regression, give the levels: what is lifted between two places on the bed is at rest as it is.

Friction takes CB R off H on the way down. It goes with lines of which nothing floats, so that what is lifted is pulled with H.
"""

from typing import NamedTuple

from ..language import inlined, kernel
from .catenaries import MET
from .line_pieces import piece

MOST_LEVELS = 80

# of a line's weight: H below is none, and none lower is tried
LEAST = 1e-14

# in composite_known: the line's length (m), its weight and what counts for its size (N), 1: something floats
LENGTH, WEIGHT, SIZE, LIFTS = 16, 17, 18, 19


class Distances(NamedTuple):
    """Distances (m) of the ends of a line or of part of it, and their derivatives by the pull (H, V), m/N."""

    x: float
    z: float
    x_H: float
    x_V: float
    z_H: float
    z_V: float


class Level(NamedTuple):
    """A level (N), and its derivatives by H and V."""

    at: float
    by_H: float
    by_V: float


class Parts(NamedTuple):
    """A section now, from above: what rises towards the second end, lies on the bed, falls towards the second end.

    up, flat, down : their lengths (m). up_top, up_bottom, down_top, down_bottom : vertical pull (N) at their ends. pull, slid : of
    what lies, the pull at its upper end (N), and how far from there it is tight (m).
    """

    up: float
    up_top: float
    up_bottom: float
    flat: float
    pull: float
    slid: float
    down: float
    down_top: float
    down_bottom: float


@inlined
def weight(m, i):
    """N/m, of section i in water."""
    return -m.gravity[2] * m.section_mass[i]


@inlined
def hung(m, i):
    """N, in water, of what hangs at the upper end of section i."""
    return -m.gravity[2] * m.section_clump[i]


@inlined
def last_section(m, k):
    """The section of line k at its second end."""
    return m.composite_section[k] + m.composite_sections[k] - 1


@inlined
def least_pull(d, k):
    """N, below which H is none."""
    return LEAST * d.composite_known[20 * k + SIZE]


@inlined
def lies(m, d, k):
    """Whether line k has a bed, and something that floats, so that levels have to be found."""
    return m.composite_bed[k] == 1 and d.composite_known[20 * k + LIFTS] == 1.0


@kernel
def weigh(m, d, k):
    """The weight above each section of line k (N), and what is told of the whole in composite_known."""
    last = last_section(m, k)
    above = 0.0
    size = 0.0
    length = 0.0
    lifts = 0.0

    for i in range(last, m.composite_section[k] - 1, -1):
        w = weight(m, i)

        if i < last:
            above += hung(m, i)
            size += abs(hung(m, i))

        if w < 0.0 or (i < last and hung(m, i) < 0.0):
            lifts = 1.0

        d.section_top[i] = above
        above += w * m.section_length[i]
        size += abs(w) * m.section_length[i]
        length += m.section_length[i]

    d.composite_known[20 * k + LENGTH] = length
    d.composite_known[20 * k + WEIGHT] = above
    d.composite_known[20 * k + SIZE] = size
    d.composite_known[20 * k + LIFTS] = lifts


@inlined
def bottom(m, d, i):
    """N, the weight above the lower end of section i."""
    return d.section_top[i] + weight(m, i) * m.section_length[i]


@inlined
def whole_piece(m, d, i, H, c):
    """Section i lifted to level c."""
    L = m.section_length[i]
    return piece(weight(m, i), L, m.section_stiffness[i], H, c - d.section_top[i], c - bottom(m, d, i))


@kernel
def heave(m, d, k, i, c, H):
    """(m, m/N, m/N): how far the line rises over what of section i and above is at level c, its derivatives by level and by H."""
    w = weight(m, i)
    top = d.section_top[i]
    z = 0.0
    by_c = 0.0
    by_H = 0.0

    if w <= 0.0 or c >= bottom(m, d, i):
        now = whole_piece(m, d, i, H, c)
        z, by_c, by_H = now.z, now.z_v, now.x_v
    elif c > top:
        now = piece(w, (c - top) / w, m.section_stiffness[i], H, c - top, 0.0)
        z, by_c, by_H = now.z, now.z_v, now.x_v

    for j in range(i + 1, last_section(m, k) + 1):
        if d.section_level[4 * j] > c:
            now = whole_piece(m, d, j, H, c)
        elif d.section_level[4 * j + 2] > c:
            low = bottom(m, d, j) - c
            w = weight(m, j)
            now = piece(w, low / w, m.section_stiffness[j], H, 0.0, -low)
        else:
            break

        z += now.z
        by_c += now.z_v
        by_H += now.x_v

    return z, by_c, by_H


@kernel
def level(m, d, k, i, H, low, high):
    """(c, dc/dH): the level between low and high (N) from which what is lifted with section i comes down to the bed again."""
    met = 0.1 * MET * d.composite_known[20 * k + LENGTH]
    c = 0.5 * (low + high)
    by_c = 1.0
    by_H = 0.0

    for step in range(MOST_LEVELS):
        z, by_c, by_H = heave(m, d, k, i, c, H)

        if abs(z) <= met:
            break

        if z > 0.0:
            high = c
        else:
            low = c

        tried = c - z / by_c
        c = tried if low < tried < high else 0.5 * (low + high)

    return c, -by_H / by_c


@inlined
def set_floor(d, i, c, by_H):
    """W' in section i is c (N) at least."""
    d.section_level[4 * i] = c
    d.section_level[4 * i + 1] = by_H


@inlined
def set_cap(d, i, c, by_H):
    """W' in section i is c (N) at most."""
    d.section_level[4 * i + 2] = c
    d.section_level[4 * i + 3] = by_H


@kernel
def find_levels(m, d, k, H):
    """Floor and cap of W' in each section of line k on a bed, from its second end on, for H > 0 (N)."""
    last = last_section(m, k)
    end = d.section_top[last]

    for i in range(last, m.composite_section[k] - 1, -1):
        top = d.section_top[i]
        bot = bottom(m, d, i)

        if weight(m, i) >= 0.0 and top >= end:
            set_floor(d, i, top, 0.0)
            set_cap(d, i, bot, 0.0)
        else:
            c, by_H = level(m, d, k, i, H, min(top, bot), max(top, end))
            set_floor(d, i, c, by_H)

            if weight(m, i) > 0.0 and bot > c:
                set_cap(d, i, bot, 0.0)
            else:
                set_cap(d, i, c, by_H)

            for j in range(i + 1, last + 1):
                if d.section_level[4 * j + 2] <= c:
                    break

                if d.section_level[4 * j] > c:
                    set_floor(d, j, c, by_H)

                set_cap(d, j, c, by_H)

        end = d.section_level[4 * i + 2]


@inlined
def lowest(m, d, k, H):
    """(V, dV/dH) of line k on a bed whose second end is as high as that: W' there."""
    if not lies(m, d, k):
        return 0.0, 0.0

    find_levels(m, d, k, H)
    i = last_section(m, k)
    p = d.section_level

    if d.section_top[i] < p[4 * i]:
        return p[4 * i], p[4 * i + 1]

    if d.section_top[i] > p[4 * i + 2]:
        return p[4 * i + 2], p[4 * i + 3]

    return d.section_top[i], 0.0


@inlined
def raised(at, by_H, V):
    """A level, or V where that is higher."""
    return Level(at, by_H, 0.0) if at > V else Level(V, 0.0, 1.0)


@inlined
def bounds(m, d, k, i, V):
    """(floor, cap) of W' in section i, or V where that is higher: without a bed all hangs from V."""
    if m.composite_bed[k] == 0:
        return Level(V, 0.0, 1.0), Level(V, 0.0, 1.0)

    if not lies(m, d, k):
        return raised(d.section_top[i], 0.0, V), raised(bottom(m, d, i), 0.0, V)

    p = d.section_level
    return raised(p[4 * i], p[4 * i + 1], V), raised(p[4 * i + 2], p[4 * i + 3], V)


@inlined
def parts(m, d, k, i, lo, hi, H, V):
    """What section i is made of, between the levels `lo` and `hi` (N)."""
    L = m.section_length[i]
    w = weight(m, i)
    top = d.section_top[i]
    bot = bottom(m, d, i)

    if lo >= hi:
        return Parts(L, lo - top, lo - bot, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0)

    rises = max(lo - top, 0.0)
    falls = max(bot - hi, 0.0)
    flat = max(L - (rises + falls) / w, 0.0)
    CB = m.composite_friction[k]
    pull = max(H - CB * (max(lo, top) - V), 0.0)
    slid = min(flat, pull / (CB * w)) if CB > 0.0 else flat
    return Parts(rises / w, rises, 0.0, flat, pull, slid, falls / w, 0.0, -falls)


@inlined
def pull_below(m, k, i, now):
    """N, in the part of section i that lies, where it is tight no more or ends."""
    return max(now.pull - m.composite_friction[k] * weight(m, i) * now.slid, 0.0)


@inlined
def with_hung(reached, w, L, EA, H, top, bottom, level):
    """Distances and those of what hangs, or is lifted, from a level: L m of it, with `top` and `bottom` (N) down at its ends."""
    if not L > 0.0:
        return reached

    now = piece(w, L, EA, H, top, bottom)
    return Distances(
        reached.x + now.x,
        reached.z + now.z,
        reached.x_H + (now.x_h + now.x_v * level.by_H),
        reached.x_V + now.x_v * level.by_V,
        reached.z_H + (now.x_v + now.z_v * level.by_H),
        reached.z_V + now.z_v * level.by_V,
    )


@inlined
def with_lying(reached, m, k, i, now):
    """Distances and those of what of section i lies."""
    if not now.flat > 0.0:
        return reached

    EA = m.section_stiffness[i]
    return Distances(
        reached.x + (now.flat + 0.5 * (now.pull + pull_below(m, k, i, now)) * now.slid / EA),
        reached.z,
        reached.x_H + now.slid / EA,
        reached.x_V + m.composite_friction[k] * now.slid / EA,
        reached.z_H,
        reached.z_V,
    )


@kernel
def distances(m, d, k, H, V):
    """(x, z, dx/dH, dx/dV, dz/dH, dz/dV) of the ends of line k, weighed, pulled with H >= 0, V."""
    H = max(H, least_pull(d, k))

    if lies(m, d, k):
        find_levels(m, d, k, H)

    reached = Distances(0.0, 0.0, 0.0, 0.0, 0.0, 0.0)

    for i in range(m.composite_section[k], last_section(m, k) + 1):
        w = weight(m, i)
        EA = m.section_stiffness[i]
        floor, cap = bounds(m, d, k, i, V)
        now = parts(m, d, k, i, floor.at, cap.at, H, V)
        reached = with_hung(reached, w, now.up, EA, H, now.up_top, now.up_bottom, floor)
        reached = with_lying(reached, m, k, i, now)
        reached = with_hung(reached, w, now.down, EA, H, now.down_top, now.down_bottom, cap)

    return reached
