"""The pull (H, V) of a line of several sections whose ends are some distances apart (docs/theory.md 16.15).

Without friction the distances are the gradient of a convex function of (H, V), and Newton's method comes there as in catenaries.py.
With it they are not, but x rises with H where V holds z: so it is searched for where Newton's method does not come there. What is
kept in scratch is, as there, a function of what it is asked for.
"""

import math

from ..language import apart, inlined, kernel
from ..signatures import DATA, MODEL, Tuple, float64, int64
from .catenaries import CELLS, KEPT, MET, MOST_HALVINGS, MOST_STEPS, ROUNDED, first_guess, kept_share
from .composite_shapes import (
    LENGTH,
    SIZE,
    WEIGHT,
    distances,
    find_levels,
    hung,
    last_section,
    least_pull,
    lies,
    lowest,
    weigh,
    weight,
)

# with friction, until it is searched for
MOST_STRIDES = 20
STRIDE_HALVINGS = 6

# of a line's weight: H below is none
SLACK = 1e-12


@kernel
def lift(m, d, k, z, H, V):
    """V of line k whose second end is z (m) over its first, z > 0 on a bed, pulled with H; V : a guess."""
    met = 0.1 * MET * d.composite_known[20 * k + LENGTH]
    stride = d.composite_known[20 * k + SIZE]
    low = lowest(m, d, k, H)[0] if m.composite_bed[k] == 1 else -math.inf
    high = math.inf
    V = max(V, low)

    for step in range(2 * MOST_STEPS):
        x1, z1, x_H, x_V, z_H, z_V = distances(m, d, k, H, V)
        gap = z1 - z

        if abs(gap) <= met:
            break

        if gap > 0.0:
            high = V
        else:
            low = V

        tried = V - gap / z_V if z_V > 0.0 else V

        # beyond what it is between, or so slow that halves are better
        if not low < tried < high or step > MOST_STEPS:
            tried = 0.5 * (low + high) if math.isfinite(high - low) else V - math.copysign(stride, gap)
            stride *= 2.0

        if tried == V:
            break

        V = tried

    return V


@kernel
def search(m, d, k, x, z, H, V):
    """(H, V) as of `solve`, slowly, and whatever Newton's method does: x rises with H, between two that come closer.

    z <= 0 on a bed: the second end is as high as that.
    """
    on_bed = m.composite_bed[k] == 1 and z <= 0.0
    least = least_pull(d, k)
    met = MET * d.composite_known[20 * k + LENGTH]
    low = 0.0
    high = math.inf

    for step in range(2 * MOST_STEPS):
        by_H = 0.0

        if on_bed:
            V, by_H = lowest(m, d, k, H)
        else:
            V = lift(m, d, k, z, H, V)

        x1, z1, x_H, x_V, z_H, z_V = distances(m, d, k, H, V)
        gap = x1 - x

        if abs(gap) <= met or (H <= least and gap > 0.0):
            break

        if gap > 0.0:
            high = H
        else:
            low = H

        slope = x_H + x_V * by_H if on_bed else x_H - x_V * z_H / z_V if z_V > 0.0 else 0.0
        tried = H - gap / slope if slope > 0.0 else H

        if not low < tried < high or step > MOST_STEPS:
            tried = (
                max(0.1 * H, least) if low == 0.0 else 10.0 * H if high == math.inf else 0.5 * (low + high)
            )

        if tried == H:
            break

        H = tried

    return H, V


@inlined
def gaps(x1, z1, x, z, H, least):
    """(gx, gz), m, by which the ends are too far apart: gx is none where no pull at all leaves them so."""
    gx = x1 - x
    return (0.0 if H <= least and gx > 0.0 else gx), z1 - z


@kernel
def solve(m, d, k, x, z, H, V):
    """(H, V) of line k, weighed, whose ends are x >= 0 and z (m) apart, z > 0 on a bed, from a guess."""
    least = least_pull(d, k)
    L = d.composite_known[20 * k + LENGTH]
    bed = m.composite_bed[k]
    grips = m.composite_friction[k] > 0.0
    H = max(H, least)
    x1, z1, x_H, x_V, z_H, z_V = distances(m, d, k, H, V)
    gx, gz = gaps(x1, z1, x, z, H, least)
    gap = abs(gx) + abs(gz)

    for step in range(MOST_STRIDES if grips else MOST_STEPS):
        if gap <= MET * L:
            break

        det = x_H * z_V - x_V * z_H

        if not (det > 0.0 and z_V > 0.0):
            break

        if H <= least and gx >= 0.0:
            change_H = 0.0
            change_V = -gz / z_V
            share = 1.0
        else:
            change_H = (x_V * gz - z_V * gx) / det
            change_V = (z_H * gx - x_H * gz) / det
            share = kept_share(H, change_H) if H > least else 1.0

        slope = abs(gx * change_H + gz * change_V)

        if bed == 1:
            share = min(share, kept_share(V - lowest(m, d, k, H)[0], change_V))

        left = gap

        for halving in range(STRIDE_HALVINGS if grips else MOST_HALVINGS):
            tried = max(H + share * change_H, least)
            x1, z1, x_H, x_V, z_H, z_V = distances(m, d, k, tried, V + share * change_V)
            gx, gz = gaps(x1, z1, x, z, tried, least)
            left = abs(gx) + abs(gz)

            # of a convex function: the derivative along the step falls in size, or the step was too long
            if gap <= ROUNDED * L or (left < gap if grips else abs(gx * change_H + gz * change_V) <= slope):
                break

            share *= 0.5

        if gap <= ROUNDED * L and left >= gap:
            break

        gap = left
        H = max(H + share * change_H, least)
        V += share * change_V

    if gap > ROUNDED * L:
        return search(m, d, k, x, z, H, V)

    return H, V


@inlined
def is_known(m, d, k):
    """Whether what is kept of line k is of its values now, which are kept."""
    same = True
    p = d.section_known

    for i in range(m.composite_section[k], last_section(m, k) + 1):
        w = weight(m, i)
        hangs = hung(m, i)
        L = m.section_length[i]
        EA = m.section_stiffness[i]
        CB = m.composite_friction[k]
        at = 5 * i
        same = same and p[at] == w and p[at + 1] == hangs and p[at + 2] == L
        same = same and p[at + 3] == EA and p[at + 4] == CB
        p[at] = w
        p[at + 1] = hangs
        p[at + 2] = L
        p[at + 3] = EA
        p[at + 4] = CB

    return same


@inlined
def guess(m, d, k, x, z):
    """(H, V) near that of a line of the same weight all along, which does not stretch."""
    p = d.composite_known
    L = p[20 * k + LENGTH]
    H, V = first_guess(L, p[20 * k + SIZE] / L, x, abs(z))

    if m.composite_bed[k] == 0:
        return H, (V if z >= 0.0 else p[20 * k + WEIGHT] - V)

    # off the bed
    return H, lowest(m, d, k, H)[0] + V


@inlined
def nearby(m, d, k, x, z):
    """A guess at (H, V): from the solution at the middle of the cell of a grid of distances, on by its derivative."""
    p = d.composite_known
    at = 20 * k
    cell = p[at + LENGTH] / CELLS
    x0 = (math.floor(x / cell) + 0.5) * cell
    z0 = (math.floor(z / cell) + 0.5) * cell

    if not (p[at + 5] == 1.0 and p[at + 6] == x0 and p[at + 7] == z0):
        H, V = guess(m, d, k, x0, z0)
        H, V = solve(m, d, k, x0, z0, H, V)
        x1, z1, x_H, x_V, z_H, z_V = distances(m, d, k, H, V)
        det = x_H * z_V - x_V * z_H
        slack = H <= least_pull(d, k) or not det > 0.0
        p[at + 5] = 1.0
        p[at + 6] = x0
        p[at + 7] = z0
        p[at + 8] = H
        p[at + 9] = V
        p[at + 10] = 0.0 if slack else z_V / det
        p[at + 11] = 0.0 if slack else -x_V / det
        p[at + 12] = 0.0 if slack else -z_H / det
        p[at + 13] = (1.0 / z_V if z_V > 0.0 else 0.0) if slack else x_H / det

    H = p[at + 8] + p[at + 10] * (x - x0) + p[at + 11] * (z - z0)
    V = p[at + 9] + p[at + 12] * (x - x0) + p[at + 13] * (z - z0)
    far = H < KEPT * p[at + 8] or not math.isfinite(H + V)

    if m.composite_bed[k] == 1 and not far:
        off = p[at + 9] - lowest(m, d, k, p[at + 8])[0]
        far = V - lowest(m, d, k, H)[0] <= KEPT * off

    # in a cell where the pull changes by more than itself its derivative says nothing
    if far:
        return guess(m, d, k, x, z)

    return H, V


@apart(Tuple((float64, float64))(MODEL, DATA, int64, float64, float64))
def pull(m, d, k, x, z):
    """(H, V) of line k whose second end is x >= 0 (m) from its first and z (m) over it. The weights and levels kept are its own then."""
    p = d.composite_known
    at = 20 * k
    weigh(m, d, k)

    if not is_known(m, d, k):
        p[at] = 0.0
        p[at + 5] = 0.0

    if p[at] == 1.0 and p[at + 1] == x and p[at + 2] == z:
        H = p[at + 3]
        V = p[at + 4]
    elif m.composite_bed[k] == 1 and z <= 0.0:
        H, V = search(m, d, k, x, z, least_pull(d, k), 0.0)
    else:
        H, V = nearby(m, d, k, x, z)
        H, V = solve(m, d, k, x, z, H, V)

    if H <= SLACK * p[at + SIZE]:
        H = 0.0

    p[at] = 1.0
    p[at + 1] = x
    p[at + 2] = z
    p[at + 3] = H
    p[at + 4] = V

    if lies(m, d, k):
        find_levels(m, d, k, max(H, least_pull(d, k)))

    return H, V
