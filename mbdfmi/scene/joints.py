"""Joints between two markers."""

from typing import Annotated, ClassVar

import numpy as np
from pydantic import BeforeValidator, Field

from .constraints import CONSTRAINTS
from .efforts import AngularSpring, LinearSpring
from .errors import show
from .fields import Axis, Empty, NotNegative, NotZero, Part, SomeOf, axis, by_key, unit_vector
from .joint_base import REACTIONS, AxisOptions, JointBase, NormalOptions, Plain
from .starts import (
    CylindricalStart, FreeStart, PlanarStart, PrismaticStart, RevoluteStart, ScrewStart,
    SphericalStart, TranslationStart, UniversalStart,
)


class Fixed(Plain):
    """No motion."""

    kind: ClassVar[str] = "fixed"
    input: ClassVar[tuple] = ()

    fixed: Empty
    output: SomeOf(*REACTIONS) = []

    def start_position(self):
        """[]"""
        return np.empty(0)

    def start_velocity(self):
        """[]"""
        return np.empty(0)


# one freedom

class Revolute(JointBase):
    """Rotation about an axis. damper : N m s/rad. input : torque, N m."""

    kind: ClassVar[str] = "revolute"

    revolute: AxisOptions
    start: RevoluteStart = RevoluteStart()
    spring: AngularSpring | None = None
    damper: NotNegative = 0.0
    input: SomeOf("torque", bare=True) = []
    output: SomeOf("angle", "speed", "acceleration", *REACTIONS) = []


class Prismatic(JointBase):
    """Translation along an axis. damper : N s/m. input : force, N."""

    kind: ClassVar[str] = "prismatic"

    prismatic: AxisOptions
    start: PrismaticStart = PrismaticStart()
    spring: LinearSpring | None = None
    damper: NotNegative = 0.0
    input: SomeOf("force", bare=True) = []
    output: SomeOf("position", "speed", "acceleration", *REACTIONS) = []


class ScrewOptions(AxisOptions):
    """axis : of the joint, in both markers' frames alike. pitch : m per turn."""

    pitch: NotZero = Field(description="advance in m per turn")


class Screw(Plain):
    """Rotation about an axis that advances along it. input : torque, N m."""

    kind: ClassVar[str] = "screw"

    screw: ScrewOptions
    start: ScrewStart = ScrewStart()
    input: SomeOf("torque", bare=True) = []
    output: SomeOf("position", "speed", "angle", "angular_speed", *REACTIONS) = []

    @property
    def pitch(self):
        """m per turn."""
        return self.screw.pitch


# more freedoms

class Cylindrical(Plain):
    """Rotation about an axis and translation along it. input : force (N), torque (N m)."""

    kind: ClassVar[str] = "cylindrical"

    cylindrical: AxisOptions
    start: CylindricalStart = CylindricalStart()
    input: SomeOf("force", "torque", bare=True) = []
    output: SomeOf("position", "speed", "angle", "angular_speed", *REACTIONS) = []


def _two_axes(value):
    if not isinstance(value, (list, tuple)) or len(value) != 2:
        raise ValueError(f'needs two axes, as in ["x", "y"]; found {show(value)}')

    first, second = axes = [axis(item) for item in value]
    if abs(unit_vector(first) @ unit_vector(second)) > 1e-6:
        raise ValueError(f"{show(first)} and {show(second)} are not perpendicular")
    return tuple(axes)


class UniversalOptions(Part):
    """axes : of the cross, the first as it is in the first marker, the second in the second."""

    axes: Annotated[tuple[Axis, Axis], BeforeValidator(_two_axes)] = ("x", "y")


class Universal(Plain):
    """Rotation about an axis in the first marker, then about one in the second (Hooke, Cardan)."""

    kind: ClassVar[str] = "universal"
    input: ClassVar[tuple] = ()

    universal: UniversalOptions
    start: UniversalStart = UniversalStart()
    output: SomeOf("angles", "speeds", *REACTIONS) = []

    @property
    def axes(self):
        """The unit vectors (2, 3) of the axes, one by row."""
        return np.array([unit_vector(item) for item in self.universal.axes])


class Planar(Plain):
    """Translations in a plane and rotation about its normal, which both markers share.

    Positions in the plane count along two axes of the first marker's: its x axis projected into
    the plane (its y axis where the normal is the x axis), and what is normal to both.
    """

    kind: ClassVar[str] = "planar"
    input: ClassVar[tuple] = ()

    planar: NormalOptions
    start: PlanarStart = PlanarStart()
    output: SomeOf("position", "angle", "velocity", "angular_speed", *REACTIONS) = []

    @property
    def axes(self):
        """(3, 3): the two axes of the plane and its normal by column, in either marker's axes."""
        return plane_axes(self.axis)


def plane_axes(normal):
    """(3, 3): x in the plane, y in the plane and the unit vector `normal`, by column."""
    helper = np.eye(3)[0 if np.linalg.norm(normal[1:]) > 1e-6 else 1]
    x = helper - normal * (normal @ helper)
    x /= np.linalg.norm(x)
    return np.column_stack([x, np.cross(normal, x), normal])


class Translation(Plain):
    """Three translations and no rotation, as of a particle."""

    kind: ClassVar[str] = "translation"
    input: ClassVar[tuple] = ()

    translation: Empty
    start: TranslationStart = TranslationStart()
    output: SomeOf("position", "velocity", *REACTIONS) = []


class Spherical(Plain):
    """Rotation about a point. input : torque (3,) in N m on the second marker."""

    kind: ClassVar[str] = "spherical"

    spherical: Empty
    start: SphericalStart = SphericalStart()
    input: SomeOf("torque", bare=True) = []
    output: SomeOf("euler_parameters", "zyx", "omega", "alpha", *REACTIONS) = []


class Free(Plain):
    """All motions."""

    kind: ClassVar[str] = "free"
    input: ClassVar[tuple] = ()

    free: Empty
    start: FreeStart = FreeStart()
    output: SomeOf("position", "velocity", "euler_parameters", "zyx", "omega") = []


Joint = by_key(
    "a joint", Fixed, Revolute, Prismatic, Cylindrical, Universal, Spherical, Planar, Translation,
    Screw, Free, *CONSTRAINTS,
)
