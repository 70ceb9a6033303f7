"""Joints that only take freedoms away, from bodies which other joints lead to the ground."""

from typing import Annotated, ClassVar

import numpy as np
from pydantic import AfterValidator, BeforeValidator, Field

from ..vocabulary import REACTIONS
from .errors import show
from .fields import Axis, Number, Part, Positive, SomeOf, in_si, unit_vector
from .joint_base import AxisOptions, Constraint, NormalOptions, two_axes
from .rare import CONSTRAINTS as KINDS


class PointOnPlane(Constraint):
    """The second marker's origin stays in a plane through the first one's, of that normal."""

    kind: ClassVar[str] = "point_on_plane"

    point_on_plane: NormalOptions
    output: SomeOf(*REACTIONS) = []


class PointOnLine(Constraint):
    """The second marker's origin stays on a line through the first one's, along that axis."""

    kind: ClassVar[str] = "point_on_line"

    point_on_line: AxisOptions
    output: SomeOf(*REACTIONS) = []


class DistanceOptions(Part):
    """length : m; None stands for the length at the start."""

    length: Positive | None = None


class Distance(Constraint):
    """The markers' origins keep their distance, as by a rod without mass."""

    kind: ClassVar[str] = "distance"

    distance: DistanceOptions
    output: SomeOf(*REACTIONS) = []

    @property
    def length(self):
        """m; None stands for the length at the start."""
        return self.distance.length


class RollingSphereOptions(Part):
    """radius : m."""

    radius: Positive = Field(description="radius in m")


class Rolling(Constraint):
    """Something round about the second marker's origin rolls, without slip, on a plane.

    The plane is z = 0 of the first marker.
    """

    @property
    def radius(self):
        """m."""
        return self.options.radius


class RollingSphere(Rolling):
    """A sphere rolls on the plane z = 0 of the first marker, on the side where its centre starts (above, if in the plane)."""

    kind: ClassVar[str] = "rolling_sphere"

    rolling_sphere: RollingSphereOptions
    output: SomeOf(*REACTIONS) = []


class RollingDiskOptions(Part):
    """radius : m. axis : of the disk, in the second marker."""

    radius: Positive = Field(description="radius in m")
    axis: Axis = "z"


class RollingDisk(Rolling):
    """A thin disk rolls on its edge on the plane z = 0 of the first marker, on the side where its centre starts (above, if in the
    plane).
    """

    kind: ClassVar[str] = "rolling_disk"

    rolling_disk: RollingDiskOptions
    output: SomeOf(*REACTIONS) = []


class KnifeEdgeOptions(Part):
    """lateral : the direction in which the edge does not move, in the second marker."""

    lateral: Axis = "y"


class KnifeEdge(Constraint):
    """The second marker's origin has no lateral velocity, seen from the first marker."""

    kind: ClassVar[str] = "knife_edge"

    knife_edge: KnifeEdgeOptions
    output: SomeOf(*REACTIONS) = []


class ConstantVelocity(Constraint):
    """A constant-velocity joint between two shafts that turn equally fast at any bend, as Rzeppa's.

    The markers' origins stay together. The joint's axis is that of the shafts; the markers' axes are parallel where it is
    straight. It only takes freedoms away: bearings, or a free joint, lead the shafts to the ground. Shafts that fold back on each
    other, by more than about 179.9 deg, are not told from each other any more, and come loose.
    """

    kind: ClassVar[str] = "constant_velocity"

    constant_velocity: AxisOptions
    output: SomeOf(*REACTIONS) = []


def _oblique(value):
    if not 0.0 < value < 180.0:
        raise ValueError(
            f"must be between 0 and 180 deg: axes that are parallel take two freedoms; found {show(value)}"
        )
    return value


class AngleOptions(Part):
    """angle_deg : between the axes, from above 0 to below 180.

    axes : of the first and of the second marker.
    """

    angle_deg: Annotated[Number, AfterValidator(_oblique)] = Field(description="angle in deg")
    axes: Annotated[tuple[Axis, Axis], BeforeValidator(two_axes)] = ("z", "z")


class Angle(Constraint):
    """An axis of the first marker and one of the second keep their angle."""

    kind: ClassVar[str] = "angle"

    angle: AngleOptions
    output: SomeOf(*REACTIONS) = []

    @property
    def axes(self):
        """The unit vectors (3,) of the two axes, each in its marker."""
        return [unit_vector(item) for item in self.angle.axes]

    @property
    def cosine(self):
        """Of the angle between them."""
        return np.cos(in_si(self.angle, "angle"))


CONSTRAINTS = tuple(kind.type for kind in KINDS)
