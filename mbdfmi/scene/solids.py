"""Simple solids of uniform density: mass, centre of mass, inertia."""

from math import inf, pi, prod
from typing import Annotated, ClassVar

import numpy as np
from pydantic import AfterValidator, Field, field_validator

from ..vectors import dot
from .errors import show
from .fields import SMALLEST, Array, Axis, NotNegative, Part, Positive, by_key, unit_vector
from .orientation import Placed

# shapes, each in its own axes about its centre


class Shape(Part):
    """A shape with its density or its mass.

    density : kg/m3.
    mass : kg.
    """

    needed = (("density", "mass"),)

    density: Positive | None = None
    mass: Positive | None = None

    def total_mass(self):
        """Mass in kg."""
        return self.density * self.volume() if self.mass is None else self.mass


class Sphere(Shape):
    """A full sphere. radius : m."""

    radius: Positive = Field(description="radius in m")

    def volume(self):
        """m3."""
        return 4 / 3 * pi * self.radius**3

    def moments(self):
        """Principal moments (3,) per unit of mass, m2."""
        return np.full(3, 2 / 5 * self.radius**2)


def _lengths(size):
    if min(size) < SMALLEST:
        raise ValueError(f"lengths must be greater than 0, at least 1e-30; found {show(size)}")
    return size


class Box(Shape):
    """A cuboid. size : lengths of the edges along x, y, z, m."""

    size: Annotated[Array((3,), what="3 lengths [x, y, z]"), AfterValidator(_lengths)] = Field(
        description="lengths of the edges [x, y, z] in m"
    )

    def volume(self):
        """m3."""
        return prod(self.size)

    def moments(self):
        """Principal moments (3,) per unit of mass, m2."""
        squares = np.square(self.size)
        return (squares.sum() - squares) / 12


class Cylinder(Shape):
    """A full cylinder along z. radius, length : m."""

    radius: Positive = Field(description="radius in m")
    length: Positive = Field(description="length along the axis in m")

    def volume(self):
        """m3."""
        return pi * self.radius**2 * self.length

    def moments(self):
        """Principal moments (3,) per unit of mass, m2."""
        return _round_moments(self.radius**2, self.length)


class Tube(Shape):
    """A hollow cylinder along z, open at its ends. radius, inner_radius, length : m."""

    radius: Positive = Field(description="outer radius in m")
    inner_radius: NotNegative = Field(description="inner radius in m")
    length: Positive = Field(description="length along the axis in m")

    @field_validator("inner_radius")
    @classmethod
    def _check_wall(cls, inner, info):
        if inner >= info.data.get("radius", inf):
            raise ValueError(
                f"must be smaller than the radius {show(info.data['radius'])}, found {show(inner)}"
            )
        return inner

    def volume(self):
        """m3."""
        return pi * (self.radius - self.inner_radius) * (self.radius + self.inner_radius) * self.length

    def moments(self):
        """Principal moments (3,) per unit of mass, m2."""
        return _round_moments(self.radius**2 + self.inner_radius**2, self.length)


def _round_moments(radii_squared, length):
    across = radii_squared / 4 + length**2 / 12
    return np.array([across, across, radii_squared / 2])


class Point(Part):
    """A point mass, without inertia of its own. mass : kg."""

    mass: Positive = Field(description="mass in kg")

    def total_mass(self):
        """Mass in kg."""
        return self.mass

    def moments(self):
        """None about itself."""
        return np.zeros(3)


# solids: shapes at their places on a body


class SolidBase(Placed):
    """A shape at a place on a body; position is that of its centre."""

    def mass_properties(self):
        """(mass kg, centre of mass (3,) m, inertia (3, 3) kg m2 about it), in the body's axes."""
        shape = getattr(self, self.kind)
        position, A = self.pose()
        mass = shape.total_mass()
        return mass, position, mass * dot(A, np.diag(shape.moments()), A.T)


class AxialSolid(SolidBase):
    """A solid of revolution; axis is its own, in the axes of its orientation."""

    axis: Axis = "z"

    def mass_properties(self):
        """As of any solid."""
        shape = getattr(self, self.kind)
        position, A = self.pose()
        mass = shape.total_mass()

        across, _, along = shape.moments()
        axis = dot(A, unit_vector(self.axis))
        moments = across * np.eye(3) + (along - across) * np.outer(axis, axis)
        return mass, position, mass * moments


class SphereSolid(SolidBase):
    """sphere = { radius, density | mass }"""

    kind: ClassVar[str] = "sphere"
    sphere: Sphere


class BoxSolid(SolidBase):
    """box = { size, density | mass }"""

    kind: ClassVar[str] = "box"
    box: Box


class CylinderSolid(AxialSolid):
    """cylinder = { radius, length, density | mass }"""

    kind: ClassVar[str] = "cylinder"
    cylinder: Cylinder


class TubeSolid(AxialSolid):
    """tube = { radius, inner_radius, length, density | mass }"""

    kind: ClassVar[str] = "tube"
    tube: Tube


class PointSolid(SolidBase):
    """point = { mass }"""

    kind: ClassVar[str] = "point"
    point: Point


Solid = by_key("a solid", SphereSolid, BoxSolid, CylinderSolid, TubeSolid, PointSolid)


def composite(parts):
    """The mass properties of rigidly joined parts.

    parts : list of (mass, centre of mass (3,), inertia (3, 3) about it), all in the same axes.
    Returns the same of the whole, by the parallel-axis theorem.
    """
    mass = sum(m for m, _, _ in parts)
    com = sum(m * c for m, c, _ in parts) / mass

    inertia = np.zeros((3, 3))
    for m, c, about_own in parts:
        r = c - com
        inertia += about_own + m * (dot(r, r) * np.eye(3) - np.outer(r, r))
    return mass, com, inertia
