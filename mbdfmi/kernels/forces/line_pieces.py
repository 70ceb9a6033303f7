"""A piece of an elastic line between two places of it, hung, standing or straight (docs/theory.md 16.15)."""

import math
from typing import NamedTuple

from ..language import inlined


class Piece(NamedTuple):
    """Distances (m) of its ends, how they change with the horizontal (h) and vertical (v) pull, m/N; `turned`: of its direction over w."""

    x: float
    z: float
    x_h: float
    x_v: float
    z_v: float
    turned: float


@inlined
def piece(w, L, EA, h, top, bottom):
    """Of length L (m), weight w (N/m, of any sign), EA (N), pulled with h > 0 (N) and with `top` and `bottom` = top - w L down at its ends.

    x = h (asinh(top / h) - asinh(bottom / h)) / w + h L / EA and so on, in forms that lose nothing where it is taut, or weighs nothing.
    """
    s = math.sqrt(h * h + top * top)
    s_b = math.sqrt(h * h + bottom * bottom)
    product = top * bottom

    # half of h^2 sinh^2 of half the turn, by w^2 L^2
    if product >= 0.0:
        inner = h * h + s * s_b + product
    else:
        inner = h * h * (1.0 + (h * h + top * top + bottom * bottom) / (s * s_b - product))

    half = L / math.sqrt(2.0 * inner)
    q = w * half
    turned = 2.0 * half * (math.asinh(q) / q if abs(q) > 0.0 else 1.0)
    straight = h * h * L * (s + s_b) / (inner * s * s_b)
    rise = L * (top + bottom) / (s + s_b)
    x = h * turned + h * L / EA
    z = rise + 0.5 * L * (top + bottom) / EA
    bent = max(turned - straight, 0.0)
    return Piece(x, z, bent + L / EA, -h * rise / (s * s_b), straight + L / EA, turned)


@inlined
def complement_of(now, L, EA, h, top, bottom):
    """J, whose gradient by (h, v) is (x, z) of a piece."""
    s = math.sqrt(h * h + top * top) + math.sqrt(h * h + bottom * bottom)
    mean = 0.25 * L * (s + (top + bottom) * (top + bottom) / s) + 0.5 * h * h * now.turned
    return mean + 0.5 * L * (h * h + (top * top + top * bottom + bottom * bottom) / 3.0) / EA
