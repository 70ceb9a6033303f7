"""Joints that only take freedoms away, from bodies which other joints lead to the ground."""

from typing import ClassVar

from pydantic import Field

from ..vocabulary import REACTIONS
from .fields import Axis, Part, Positive, SomeOf
from .joint_base import AxisOptions, Constraint, NormalOptions


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


CONSTRAINTS = (PointOnPlane, PointOnLine, Distance, RollingSphere, RollingDisk, KnifeEdge)
