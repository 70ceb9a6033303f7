"""Curves by a parameter s, in their marker's axes: r(s), r', r'' (docs/theory.md 10.1).

==========  ==============================================  =========
kind        r(s)                                            s
==========  ==============================================  =========
LINE        (s, 0, 0)                                       m
CIRCLE      R (cos s/R, sin s/R, 0)                         m, runs on
PARABOLA    (s, c s^2, 0)                                   m
CYCLOID     R (s + sin s, 1 - cos s, 0)                     rad
SPLINE      cubic pieces; beyond its ends straight on, or   as given
            from its start again where it is closed
==========  ==============================================  =========
"""

import math

import numpy as np

from ..language import inlined, kernel
from ..math import algebra as al
from ..math import tables

LINE = 0
CIRCLE = 1
PARABOLA = 2
CYCLOID = 3
SPLINE = 4

KINDS = {
    "line": LINE,
    "circle": CIRCLE,
    "parabola": PARABOLA,
    "cycloid": CYCLOID,
    "spline": SPLINE,
    "table": SPLINE,
}


@inlined
def within(m, k, s):
    """s of a spline, of a closed one on its first turn."""
    period = m.curve_value[k]
    return s - period * np.floor((s - tables.first(m, m.curve_table[k])) / period) if period > 0.0 else s


@inlined
def spline(m, k, s):
    """(r, r', r'') of a spline: a table for each component."""
    table = m.curve_table[k]
    s = within(m, k, s)
    x = tables.evaluate(m, table, s)
    y = tables.evaluate(m, table + 1, s)
    z = tables.evaluate(m, table + 2, s)
    return (x[0], y[0], z[0]), (x[1], y[1], z[1]), (x[2], y[2], z[2])


@kernel
def point(m, k, s):
    """(r, r', r'') of curve k at s: m and m per unit of s, in its marker's axes."""
    kind = m.curve_kind[k]
    R = m.curve_value[k]

    if kind == LINE:
        return (s, 0.0, 0.0), (1.0, 0.0, 0.0), al.ZERO3

    if kind == CIRCLE:
        c = math.cos(s / R)
        y = math.sin(s / R)
        return (R * c, R * y, 0.0), (-y, c, 0.0), (-c / R, -y / R, 0.0)

    if kind == PARABOLA:
        return (s, R * s * s, 0.0), (1.0, 2.0 * R * s, 0.0), (0.0, 2.0 * R, 0.0)

    if kind == CYCLOID:
        c = math.cos(s)
        y = math.sin(s)
        return (R * (s + y), R * (1.0 - c), 0.0), (R * (1.0 + c), R * y, 0.0), (-R * y, R * c, 0.0)

    return spline(m, k, s)


@kernel
def third(m, k, s):
    """r''' of curve k at s."""
    kind = m.curve_kind[k]
    R = m.curve_value[k]

    if kind == CIRCLE:
        return math.sin(s / R) / (R * R), -math.cos(s / R) / (R * R), 0.0

    if kind == CYCLOID:
        return -R * math.cos(s), -R * math.sin(s), 0.0

    if kind == SPLINE:
        table = m.curve_table[k]
        s = within(m, k, s)
        return tables.third(m, table, s), tables.third(m, table + 1, s), tables.third(m, table + 2, s)

    return al.ZERO3


@inlined
def window(m, k, p, margin):
    """(lowest, highest) s at which curve k may be closest to a point within `margin` of p (m)."""
    kind = m.curve_kind[k]
    R = m.curve_value[k]

    if kind == LINE:
        return p[0] - margin, p[0] + margin

    if kind == CIRCLE:
        return 0.0, 2.0 * math.pi * R

    if kind == PARABOLA:
        reach = abs(p[0]) + margin + math.sqrt((abs(p[1]) + margin) / abs(R))
        return -reach, reach

    if kind == CYCLOID:
        return (p[0] - margin) / R - 1.0, (p[0] + margin) / R + 1.0

    table = m.curve_table[k]
    return tables.first(m, table), tables.last(m, table)


@inlined
def nearest(m, k, s):
    """s of curve k, moved to the nearest end where it lies beyond one."""
    ends = m.curve_kind[k] == SPLINE and m.curve_value[k] == 0.0
    return tables.clamped(m, m.curve_table[k], s) if ends else s


@inlined
def pieces(m, k):
    """Number of pieces of curve k."""
    return m.table_knots[m.curve_table[k]] - 1 if m.curve_kind[k] == SPLINE else 1
