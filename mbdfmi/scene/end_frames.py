"""Joints that keep end frames on curves and surfaces of markers."""

from typing import ClassVar

import numpy as np

from ..vocabulary import PARAMETERS, REACTIONS
from .fields import Array, Empty, Number, Part, SomeOf
from .joint_base import Constraint


class CurveStart(Part):
    """s : parameter of the curve at the start."""

    s: Number | None = None


class PairStart(Part):
    """s : the two parameters at the start."""

    s: Array((2,), what="2 numbers [s1, s2]") | None = None


class EndFrame(Constraint):
    """A joint with parameters s of a curve or surface.

    shapes : what the first and the second marker must have, "curve", "surface" or None.
    """

    shapes: ClassVar[tuple]

    @property
    def start_s(self):
        """Parameters (1,) or (2,) near the start, or None: the nearest."""
        return None if self.start.s is None else np.atleast_1d(self.start.s)


class PointOnCurve(EndFrame):
    """The second marker's origin stays on the first one's curve."""

    kind: ClassVar[str] = "point_on_curve"
    shapes: ClassVar[tuple] = ("curve", None)

    point_on_curve: Empty
    start: CurveStart = CurveStart()
    output: SomeOf(*PARAMETERS, *REACTIONS) = []


class CurveOnCurve(EndFrame):
    """The markers' curves, in parallel planes, touch: cam and follower."""

    kind: ClassVar[str] = "curve_on_curve"
    shapes: ClassVar[tuple] = ("curve", "curve")

    curve_on_curve: Empty
    start: PairStart = PairStart()
    output: SomeOf(*PARAMETERS, *REACTIONS) = []


class PointOnSurface(EndFrame):
    """The second marker's origin stays on the first one's surface."""

    kind: ClassVar[str] = "point_on_surface"
    shapes: ClassVar[tuple] = ("surface", None)

    point_on_surface: Empty
    start: PairStart = PairStart()
    output: SomeOf(*PARAMETERS, *REACTIONS) = []


END_FRAMES = (PointOnCurve, CurveOnCurve, PointOnSurface)
