"""Joints that keep end frames on curves and surfaces of markers.

An end frame has the axes i = tangent, j = binormal, k = normal, j = k x i, which outputs tell in the first marker's axes.
"""

from typing import ClassVar

import numpy as np

from ..vocabulary import CONTACT_OUTPUTS, END_FRAME_AXES, PARAMETERS, REACTIONS
from .fields import Array, Axis, Empty, Number, OneOf, Part, SomeOf, unit_vector
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
    output : the parameter and its rate, unit vectors along the end frame's axes in the first marker's axes (tangent, binormal =
        normal x tangent, normal; of two curves those of the first), reactions.
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
    output: SomeOf(*PARAMETERS, *END_FRAME_AXES, *REACTIONS) = []


class CurveOnCurve(EndFrame):
    """The markers' curves, in parallel planes, touch: cam and follower."""

    kind: ClassVar[str] = "curve_on_curve"
    shapes: ClassVar[tuple] = ("curve", "curve")

    curve_on_curve: Empty
    start: PairStart = PairStart()
    output: SomeOf(*PARAMETERS, *END_FRAME_AXES, *REACTIONS) = []


class PointOnSurface(EndFrame):
    """The second marker's origin stays on the first one's surface."""

    kind: ClassVar[str] = "point_on_surface"
    shapes: ClassVar[tuple] = ("surface", None)

    point_on_surface: Empty
    start: PairStart = PairStart()
    output: SomeOf(*PARAMETERS, *END_FRAME_AXES, *REACTIONS) = []


class FrameOptions(Part):
    """spin : whether the second marker may spin about its tangent or normal: "held" or "free"."""

    spin: OneOf("held", "free") = "held"


class FrameOnCurveOptions(FrameOptions):
    """side : a direction of the first marker that the curve is never parallel to; y of the second marker stays as near to it as can
    be. None: z of a planar curve, of others the direction that keeps farthest from the curve's.
    """

    side: Axis | None = None


class Framed(EndFrame):
    """A joint that holds axes, too, to those of the end frame."""

    @property
    def spin_is_free(self):
        """Whether a spin about the axis along the curve, or normal to the surface, is left free."""
        return self.options.spin == "free"


class FrameOnCurve(Framed):
    """The second marker moves along the first one's curve as its moving frame does, like a car on a track.

    Its origin stays on the curve, its x along the tangent, its y as near to the direction `side` as it can be: up, for a road; across
    the track, for a loop. z is normal to both; of a planar curve with the side z it is the normal that points out of a bend to the
    left. Where an open spline ends, it goes on straight, and the frame stops turning at once.
    """

    kind: ClassVar[str] = "frame_on_curve"
    shapes: ClassVar[tuple] = ("curve", None)

    frame_on_curve: FrameOnCurveOptions
    start: CurveStart = CurveStart()
    output: SomeOf(*PARAMETERS, *END_FRAME_AXES, *REACTIONS) = []

    @property
    def side(self):
        """The unit vector (3,) that the curve is never parallel to, or None."""
        return None if self.options.side is None else unit_vector(self.options.side)


class FrameOnSurface(Framed):
    """The second marker moves on the first one's surface as its frame does.

    Its origin stays on the surface, its z along the normal r1 x r2 (derivatives by the parameters), and its x along r1, unless it may
    spin about the normal. On a sphere or an ellipsoid x points east, which at the poles means nothing: on a sphere the spin must be free
    there, an ellipsoid's poles cannot be passed.
    """

    kind: ClassVar[str] = "frame_on_surface"
    shapes: ClassVar[tuple] = ("surface", None)

    frame_on_surface: FrameOptions
    start: PairStart = PairStart()
    output: SomeOf(*PARAMETERS, *END_FRAME_AXES, *REACTIONS) = []


class SurfaceStart(Part):
    """s : parameters of the first marker's surface at the start, near which they touch. Those of the second one follow."""

    s: Array((2,), what="2 numbers [s1, s2], of the first marker's surface") | None = None


FORCES = [name for name in CONTACT_OUTPUTS if name != "friction_force"]


class SurfaceOnSurface(EndFrame):
    """The markers' surfaces touch, and slide on each other without friction.

    The second one is a sphere, an ellipsoid, a disk (by its edge) or a torus (by its outer half, as a wheel by its rim), the first
    one any surface; where that is hollow, it is wider than the second one. They touch on that side of the first surface where the
    start puts the second marker's origin (on the outer side, that of its normal, if it lies in the surface). The output s has four
    numbers, two of each surface; of a disk or a torus the last is the angle from its plane, 0 where it stands upright.
    """

    kind: ClassVar[str] = "surface_on_surface"
    shapes: ClassVar[tuple] = ("surface", "surface")

    surface_on_surface: Empty
    start: SurfaceStart = SurfaceStart()
    output: SomeOf(*PARAMETERS, *FORCES, *REACTIONS) = []


class RollingSurface(EndFrame):
    """As surface_on_surface, but they roll on each other without slip: a wheel on a road, a ball in a bowl, a rattleback."""

    kind: ClassVar[str] = "rolling_surface"
    shapes: ClassVar[tuple] = ("surface", "surface")

    rolling_surface: Empty
    start: SurfaceStart = SurfaceStart()
    output: SomeOf(*PARAMETERS, *CONTACT_OUTPUTS, *REACTIONS) = []


END_FRAMES = (
    PointOnCurve,
    CurveOnCurve,
    PointOnSurface,
    FrameOnCurve,
    FrameOnSurface,
    SurfaceOnSurface,
    RollingSurface,
)
