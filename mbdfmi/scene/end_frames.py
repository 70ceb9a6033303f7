"""Joints that keep end frames on curves and surfaces of markers.

An end frame has the axes i = tangent, j = binormal, k = normal, j = k x i, which outputs tell in the first marker's axes.
"""

from typing import ClassVar

import numpy as np
from pydantic import model_validator

from ..vocabulary import CONTACT_OUTPUTS, END_FRAME_AXES, PARAMETER_EFFORTS, PARAMETERS, REACTIONS
from .efforts import ParameterDriver
from .errors import show
from .fields import Array, Axis, Empty, Number, OneOf, Part, SomeOf, left_out, unit_vector
from .joint_base import Passive
from .rare import END_FRAMES as KINDS


class CurveStart(Part):
    """s : parameter of the curve at the start."""

    s: Number | None = None


class PairStart(Part):
    """s : the two parameters at the start."""

    s: Array((2,), what="2 numbers [s1, s2]") | None = None


class EndFrame(Passive):
    """A joint with parameters s of a curve or surface.

    shapes : what the first and the second marker must have, "curve", "surface" or None.
    output : the parameter and its rate, unit vectors along the end frame's axes in the first marker's axes (tangent, binormal =
        normal x tangent, normal; of two curves those of the first), reactions.
    """

    input: ClassVar[tuple] = ()
    shapes: ClassVar[tuple]

    @property
    def start_s(self):
        """Parameters (1,) or (2,) near the start, or None: the nearest."""
        return None if self.start.s is None else np.atleast_1d(self.start.s)

    def start_position(self):
        """[], or [s] where a driver begins; 0 where it needs none."""
        return np.atleast_1d(self.start.s or 0.0) if self.driver else np.empty(0)

    def start_velocity(self):
        """[], or [0] of a parameter that is driven."""
        return np.zeros(1) if self.driver else np.empty(0)


class OnCurve(EndFrame):
    """A joint whose end frame on a curve may be driven along it.

    driver : of the parameter s.
    output : beside what the others have, what drives it along s: its power (driver_power) is effort times s_rate, so that where s is
        the length along the curve it is the force along the tangent on the second marker.
    """

    driver: ParameterDriver | None = None

    @model_validator(mode="after")
    def _check_driver(self):
        told = next((output for output in self.output if output in PARAMETER_EFFORTS), None)
        if told and not self.driver:
            raise ValueError(f"output {show(told)} is that of a driver, and there is none")
        if not self.driver or self.driver.kind == "input":
            return self

        if self.driver.kind not in ("constant_speed", "hold", "speed_table"):
            if self.start.s is not None:
                raise ValueError("the driver says where the joint starts; drop the start")
        elif self.start.s is None:
            raise ValueError(
                f"the driver goes on from the parameter at the start ({self.driver.kind}): write start = {{ s = ... }}"
            )
        return self


class Undriven(EndFrame):
    """A joint with parameters that follow."""

    driver: ClassVar[None] = None


class PointOnCurve(OnCurve):
    """The second marker's origin stays on the first one's curve."""

    kind: ClassVar[str] = "point_on_curve"
    shapes: ClassVar[tuple] = ("curve", None)

    point_on_curve: Empty
    start: CurveStart = left_out(CurveStart)
    output: SomeOf(*PARAMETERS, *PARAMETER_EFFORTS, *END_FRAME_AXES, *REACTIONS) = []


class CurveOnCurve(Undriven):
    """The markers' curves, in parallel planes, touch: cam and follower."""

    kind: ClassVar[str] = "curve_on_curve"
    shapes: ClassVar[tuple] = ("curve", "curve")

    curve_on_curve: Empty
    start: PairStart = left_out(PairStart)
    output: SomeOf(*PARAMETERS, *END_FRAME_AXES, *REACTIONS) = []


class PointOnSurface(Undriven):
    """The second marker's origin stays on the first one's surface."""

    kind: ClassVar[str] = "point_on_surface"
    shapes: ClassVar[tuple] = ("surface", None)

    point_on_surface: Empty
    start: PairStart = left_out(PairStart)
    output: SomeOf(*PARAMETERS, *END_FRAME_AXES, *REACTIONS) = []


class FrameOptions(Part):
    """spin : whether the second marker may spin about its tangent or normal: "held" or "free"."""

    spin: OneOf("held", "free") = "held"

    @property
    def spin_is_free(self):
        """Whether it may."""
        return self.spin == "free"


class FrameOnCurveOptions(FrameOptions):
    """side : a direction of the first marker that the curve is never parallel to; y of the second marker stays as near to it as can
    be. None: z of a planar curve, of others the direction that keeps farthest from the curve's.
    """

    side: Axis | None = None


class FrameOnCurve(OnCurve):
    """The second marker moves along the first one's curve as its moving frame does, like a car on a track.

    Its origin stays on the curve, its x along the tangent, its y as near to the direction `side` as it can be: up, for a road; across
    the track, for a loop. z is normal to both; of a planar curve with the side z it is the normal that points out of a bend to the
    left. Where an open spline ends, it goes on straight, and the frame stops turning at once:
    what that costs a body in energy is lost (or gained), so let the points reach as far as the way does. A run that comes there says
    so once.
    """

    kind: ClassVar[str] = "frame_on_curve"
    shapes: ClassVar[tuple] = ("curve", None)

    frame_on_curve: FrameOnCurveOptions
    start: CurveStart = left_out(CurveStart)
    output: SomeOf(*PARAMETERS, *PARAMETER_EFFORTS, *END_FRAME_AXES, *REACTIONS) = []

    @property
    def side(self):
        """The unit vector (3,) that the curve is never parallel to, or None."""
        return None if self.options.side is None else unit_vector(self.options.side)


class FrameOnSurface(Undriven):
    """The second marker moves on the first one's surface as its frame does.

    Its origin stays on the surface, its z along the normal r1 x r2 (derivatives by the parameters), and its x along r1, unless it may
    spin about the normal. On a sphere or an ellipsoid x points east, which at the poles means nothing: on a sphere the spin must be free
    there, an ellipsoid's poles cannot be passed. Where points end, of a table or of an open profile, it goes on straight, and the frame
    stops turning at once: what that costs a body in energy is lost (or gained), so let them reach as far as the way does. A
    run that comes there says so once.
    """

    kind: ClassVar[str] = "frame_on_surface"
    shapes: ClassVar[tuple] = ("surface", None)

    frame_on_surface: FrameOptions
    start: PairStart = left_out(PairStart)
    output: SomeOf(*PARAMETERS, *END_FRAME_AXES, *REACTIONS) = []


class SurfaceStart(Part):
    """s : parameters of the first marker's surface at the start, near which they touch. Those of the second one follow."""

    s: Array((2,), what="2 numbers [s1, s2], of the first marker's surface") | None = None


FORCES = [name for name in CONTACT_OUTPUTS if name != "friction_force"]


class SurfaceOnSurface(Undriven):
    """The markers' surfaces touch, and slide on each other without friction.

    The second one is a sphere, an ellipsoid, a disk (by its edge) or a torus (by its outer half, as a wheel by its rim), the first
    one any surface; where that is hollow, it is wider than the second one. They touch on that side of the first surface where the
    start puts the second marker's origin (on the outer side, that of its normal, if it lies in the surface). The output s has four
    numbers, two of each surface; of a disk or a torus the last is the angle from its plane, 0 where it stands upright.
    """

    kind: ClassVar[str] = "surface_on_surface"
    shapes: ClassVar[tuple] = ("surface", "surface")

    surface_on_surface: Empty
    start: SurfaceStart = left_out(SurfaceStart)
    output: SomeOf(*PARAMETERS, *FORCES, *REACTIONS) = []


class RollingSurface(Undriven):
    """As surface_on_surface, but they roll on each other without slip: a wheel on a road, a ball in a bowl, a rattleback."""

    kind: ClassVar[str] = "rolling_surface"
    shapes: ClassVar[tuple] = ("surface", "surface")

    rolling_surface: Empty
    start: SurfaceStart = left_out(SurfaceStart)
    output: SomeOf(*PARAMETERS, *CONTACT_OUTPUTS, *REACTIONS) = []


END_FRAMES = tuple(kind.type for kind in KINDS)
