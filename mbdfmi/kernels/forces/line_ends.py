"""A mooring line between two markers at an instant: its place, its forces on their bodies, the power of these."""

import math
from typing import NamedTuple

from ..language import inlined
from ..math import algebra as al
from ..motion import markers


class Line(NamedTuple):
    """A line now: the markers of its ends, the horizontal direction from the lower one to the upper, (x, z) m, pull (H, V) N on the upper."""

    lower: int
    upper: int
    along: tuple
    x: float
    z: float
    H: float
    V: float


@inlined
def from_lower(m, d, lower, upper):
    """(m, inertial axes) from the marker of the lower end to that of the upper one."""
    return al.sub(markers.position(m, d, upper), markers.position(m, d, lower))


@inlined
def across(span):
    """(x m, horizontal direction) of a span; none where its ends stand over each other."""
    x = math.sqrt(span[0] * span[0] + span[1] * span[1])
    share = 1.0 / x if x > 0.0 else 0.0
    return x, (share * span[0], share * span[1], 0.0)


@inlined
def forces(now, out, up):
    """(force on the upper end, on the lower end), N, inertial axes, of a line that pulls with `out` and `up` (N) at the lower one."""
    on_upper = (-now.H * now.along[0], -now.H * now.along[1], -now.V)
    return on_upper, (out * now.along[0], out * now.along[1], up)


@inlined
def add(m, d, now, on_upper, on_lower):
    """Its forces onto the bodies."""
    r = markers.position(m, d, now.upper)
    markers.add_wrench(m, d, m.marker_body[now.upper], r, al.ZERO3, on_upper)
    r = markers.position(m, d, now.lower)
    markers.add_wrench(m, d, m.marker_body[now.lower], r, al.ZERO3, on_lower)


@inlined
def power(m, d, now, on_upper, on_lower):
    """W, on the bodies."""
    total = al.dot(on_upper, markers.velocity(m, d, now.upper))
    return total + al.dot(on_lower, markers.velocity(m, d, now.lower))
