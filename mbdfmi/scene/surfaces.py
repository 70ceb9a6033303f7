"""Surfaces on markers, each by parameters s1 and s2, in the marker's axes.

Their `units` are those of the two; None where the user gave them.
"""

from typing import Annotated, ClassVar

import numpy as np
from pydantic import AfterValidator, BeforeValidator, Field, field_validator, model_validator

from .curves import Curve
from .errors import show
from .fields import SMALLEST, Array, Empty, Part, Positive, array, by_key
from .tables import Ascending


class Plane(Part):
    """plane = {}: the xy plane, s1 = x, s2 = y in m."""

    kind: ClassVar[str] = "plane"
    semi_axes: ClassVar[None] = None
    units: ClassVar[tuple] = ("m", "m")

    plane: Empty


class RadiusOptions(Part):
    """radius : m."""

    radius: Positive = Field(description="radius in m")


class Round(Part):
    """A surface with a radius."""

    semi_axes: ClassVar[tuple | None] = None

    @property
    def radius(self):
        """m."""
        return getattr(self, self.kind).radius


class SphereSurface(Round):
    """sphere = { radius }: about the origin; s1 longitude from x to y, s2 latitude, rad."""

    kind: ClassVar[str] = "sphere"
    units: ClassVar[tuple] = ("rad", "rad")

    sphere: RadiusOptions

    @property
    def semi_axes(self):
        """m."""
        return (self.radius,) * 3


def _check_lengths(value):
    for k, length in enumerate(value, 1):
        if length < SMALLEST:
            raise ValueError(f"[{k}] must be greater than 0, at least 1e-30; found {show(length)}")

    return value


class EllipsoidOptions(Part):
    """semi_axes : [a, b, c] along x, y, z, m."""

    semi_axes: Annotated[Array((3,), what="3 semi-axes [a, b, c] in m"), AfterValidator(_check_lengths)]


class Ellipsoid(Part):
    """ellipsoid = { semi_axes }: about the origin, (a cos s2 cos s1, b cos s2 sin s1, c sin s2), s1, s2 in rad."""

    kind: ClassVar[str] = "ellipsoid"
    units: ClassVar[tuple] = ("rad", "rad")

    ellipsoid: EllipsoidOptions

    @property
    def semi_axes(self):
        """m."""
        return self.ellipsoid.semi_axes


class Disk(Round):
    """disk = { radius }: the edge of a thin disk about the z axis, which can only touch another surface, as the second one: a
    torus whose tube has no thickness.
    """

    kind: ClassVar[str] = "disk"
    units: ClassVar[tuple] = ("rad", "rad")
    tube: ClassVar[float] = 0.0

    disk: RadiusOptions


class CylinderSurface(Round):
    """cylinder = { radius }: about the z axis; s1 angle from x to y in rad, s2 = z in m."""

    kind: ClassVar[str] = "cylinder"
    units: ClassVar[tuple] = ("rad", "m")

    cylinder: RadiusOptions


class TorusOptions(Part):
    """radius : of the circle in the middle of the tube, m. tube : radius of the tube, m."""

    radius: Positive = Field(description="radius of the circle in the middle of the tube, in m")
    tube: Positive = Field(description="radius of the tube in m")

    @field_validator("tube")
    @classmethod
    def _check_tube(cls, tube, info):
        if tube >= info.data.get("radius", np.inf):
            raise ValueError(
                f"must be smaller than the radius {show(info.data['radius'])}, found {show(tube)}"
            )
        return tube


class Torus(Round):
    """torus = { radius, tube }: about the z axis; s1 angle about it from x to y, s2 angle about
    the tube from the outside to z, rad."""

    kind: ClassVar[str] = "torus"
    units: ClassVar[tuple] = ("rad", "rad")

    torus: TorusOptions

    @property
    def tube(self):
        """Radius of the tube, m."""
        return self.torus.tube


class PrismOptions(Part):
    """profile : a planar curve, by s1."""

    profile: Curve = Field(description="a curve, as in profile = { circle = { radius = 1 } }")

    @field_validator("profile")
    @classmethod
    def _check_profile(cls, profile):
        if not profile.is_planar:
            raise ValueError("must lie in the xy plane; its points differ in z")
        return profile


class Prism(Part):
    """prism = { profile }: a curve in the xy plane, by s1, moved along z, s2 = z in m."""

    kind: ClassVar[str] = "prism"
    semi_axes: ClassVar[None] = None

    prism: PrismOptions

    @property
    def profile(self):
        """The curve."""
        return self.prism.profile

    @property
    def units(self):
        """Of its parameters."""
        return self.profile.unit, "m"


def _grid(value):
    what = "rows of points [x, y, z], a row for each s1 and in it a point for each s2"
    if isinstance(value, np.ndarray):
        value = value.tolist()
    if not isinstance(value, (list, tuple)) or not value or not isinstance(value[0], (list, tuple)):
        raise ValueError(f"needs {what}; found {show(value)}")
    return array(value, (len(value), len(value[0]), 3), what=what)


class GridOptions(Part):
    """s1, s2 : parameters (n1,), (n2,), at least 4 each. points : (n1, n2, 3) in m."""

    s1: Ascending
    s2: Ascending
    points: Annotated[tuple, BeforeValidator(_grid)]

    @model_validator(mode="after")
    def _check_grid(self):
        for key in ("s1", "s2"):
            if len(getattr(self, key)) < 4:
                raise ValueError(f"{key} needs at least 4 values, found {len(getattr(self, key))}")

        found, needed = np.shape(self.points)[:2], (len(self.s1), len(self.s2))
        if found != needed:
            raise ValueError(
                f"points needs {needed[0]} rows of {needed[1]} points, as many as there are "
                f"values of s1 and s2; found {found[0]} of {found[1]}"
            )
        return self


class TableSurface(Part):
    """table = { s1, s2, points }: a bicubic spline through points."""

    kind: ClassVar[str] = "table"
    semi_axes: ClassVar[None] = None
    units: ClassVar[tuple] = (None, None)

    table: GridOptions

    @property
    def s1(self):
        """(n1,)"""
        return np.array(self.table.s1)

    @property
    def s2(self):
        """(n2,)"""
        return np.array(self.table.s2)

    @property
    def points(self):
        """(n1, n2, 3) in m."""
        return np.array(self.table.points)


Surface = by_key(
    "a surface",
    Plane,
    SphereSurface,
    Ellipsoid,
    CylinderSurface,
    Torus,
    Prism,
    TableSurface,
    Disk,
)

CONVEX = ("sphere", "ellipsoid", "disk", "torus")
"""Surfaces that can touch others: round outwards everywhere, or where they touch."""

HOLLOW = ("plane", "cylinder", "prism", "table")
"""Those that others can only touch: they may be straight or hollow."""
