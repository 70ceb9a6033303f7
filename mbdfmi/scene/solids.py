"""Simple solids of uniform density: mass, centre of mass, inertia."""

from math import pi, prod
from typing import ClassVar

import numpy as np
from pydantic import Field, PrivateAttr, model_validator

from ..vectors import dot
from .fields import Axis, Part, Positive, by_key, unit_vector
from .geometry import BoxGeometry, CylinderGeometry, MeshGeometry, SphereGeometry, TubeGeometry
from .meshes import enclosed
from .orientation import Placed

# shapes, each in its own axes about its centre


class Massive(Part):
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


class Sphere(SphereGeometry, Massive):
    """A full sphere."""

    def volume(self):
        """m3."""
        return 4 / 3 * pi * self.radius**3

    def moments(self):
        """Principal moments (3,) per unit of mass, m2."""
        return np.full(3, 2 / 5 * self.radius**2)


class Box(BoxGeometry, Massive):
    """A cuboid."""

    def volume(self):
        """m3."""
        return prod(self.size)

    def moments(self):
        """Principal moments (3,) per unit of mass, m2."""
        squares = np.square(self.size)
        return (squares.sum() - squares) / 12


class Cylinder(CylinderGeometry, Massive):
    """A full cylinder along z."""

    def volume(self):
        """m3."""
        return pi * self.radius**2 * self.length

    def moments(self):
        """Principal moments (3,) per unit of mass, m2."""
        return _round_moments(self.radius**2, self.length)


class Tube(TubeGeometry, Massive):
    """A hollow cylinder along z, open at its ends."""

    def volume(self):
        """m3."""
        return pi * (self.radius - self.inner_radius) * (self.radius + self.inner_radius) * self.length

    def moments(self):
        """Principal moments (3,) per unit of mass, m2."""
        return _round_moments(self.radius**2 + self.inner_radius**2, self.length)


def _round_moments(radii_squared, length):
    across = radii_squared / 4 + length**2 / 12
    return np.array([across, across, radii_squared / 2])


class Mesh(MeshGeometry, Massive):
    """What a closed surface of triangles encloses. A surface that is not closed is refused, its largest hole named."""

    _enclosed: tuple = PrivateAttr()

    @model_validator(mode="after")
    def _read(self):
        self._enclosed = enclosed(self.file, self.scale)
        return self

    def volume(self):
        """m3."""
        return self._enclosed[0]

    def mass_properties(self):
        """(mass kg, centre of mass (3,) m, inertia (3, 3) kg m2 about it), in the file's axes."""
        volume, centre, inertia = self._enclosed
        return self.total_mass(), centre, self.total_mass() / volume * inertia


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


class MeshSolid(SolidBase):
    """mesh = { file, scale, density | mass }; position is that of the file's origin."""

    kind: ClassVar[str] = "mesh"
    mesh: Mesh

    def mass_properties(self):
        """As of any solid."""
        mass, centre, inertia = self.mesh.mass_properties()
        position, A = self.pose()
        return mass, position + dot(A, centre), dot(A, inertia, A.T)


Solid = by_key("a solid", SphereSolid, BoxSolid, CylinderSolid, TubeSolid, PointSolid, MeshSolid)


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
