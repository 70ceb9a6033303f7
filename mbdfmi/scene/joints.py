"""Joints between two markers."""

from typing import TYPE_CHECKING, Annotated, ClassVar

import numpy as np
from pydantic import BeforeValidator, Field, model_validator

from ..vocabulary import (
    ANGLE,
    ANGLE_BESIDE_SLIDE,
    EFFORT_OUTPUTS,
    FREE_ORIENTATION,
    IN_PLANE,
    IN_SPACE,
    ORIENTATION,
    POSE_OUTPUTS,
    REACTIONS,
    ROTATION_OUTPUTS,
    SLIDE,
    TWO_ANGLES,
    coordinate_names,
)
from .errors import listed, show
from .fields import (
    Axis,
    Empty,
    NotNegative,
    NotZero,
    Number,
    Part,
    SomeOf,
    by_key,
    left_out,
    number_or,
    plane_axes,
    unit_vector,
)
from .joint_base import AxisOptions, JointBase, NormalOptions, Plain, two_axes
from .rare import CONSTRAINTS, END_FRAMES, rare, rare_kinds
from .starts import (
    CylindricalStart,
    FreeStart,
    PlanarStart,
    PrismaticStart,
    RevoluteStart,
    ScrewStart,
    SphericalStart,
    TranslationStart,
    UniversalStart,
)

if TYPE_CHECKING:
    from .efforts import (
        AngularDriver,
        AngularSpring,
        AngularStop,
        Friction,
        LinearDriver,
        LinearSpring,
        LinearStop,
    )
    from .tables import EffortDamper
else:
    AngularDriver, LinearDriver, Friction = rare("efforts", "AngularDriver", "LinearDriver", "Friction")
    AngularSpring, LinearSpring = rare("efforts", "AngularSpring", "LinearSpring")
    AngularStop, LinearStop = rare("efforts", "AngularStop", "LinearStop")
    (EffortDamper,) = rare("tables", "EffortDamper")

PARTS = {"friction": "friction", "input": "an input"}


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


class Driveable(JointBase):
    """A joint whose motion a driver may prescribe."""

    @model_validator(mode="after")
    def _check_efforts(self):
        for output, part in EFFORT_OUTPUTS.items():
            if output in self.output and not getattr(self, part):
                raise ValueError(
                    f"output {show(output)} is that of {PARTS.get(part, f'a {part}')}, and there is none"
                )
        return self

    @model_validator(mode="after")
    def _check_driver(self):
        if not self.driver:
            return self

        if self.input:
            raise ValueError(f"{listed(self.input)} cannot act on a driven joint; drop the input")
        if self.driver.kind not in ("constant_speed", "hold", "speed_table", "input") and self.start_given:
            raise ValueError("the driver says where the joint starts and how fast; drop the start")
        if self.driver.kind == "input" and self.holds_velocity and "speed" not in self.driver.commands():
            raise ValueError(
                'the driver is told the position alone; drop the speed of the start, or add "speed" to its input'
            )
        if self.driver.kind in ("constant_speed", "hold", "speed_table") and self.holds_velocity:
            raise ValueError("the driver says how fast the joint starts; drop that of the start")
        return self


class Turning(Part):
    """A rotor that turns with a joint, as that of a geared motor, borne by the body of the joint's first marker.

    inertia : about its axis, which is parallel to the joint's, kg m2.
    ratio : its speed relative to that body, by the joint's; on a prismatic joint rad/m.

    Its mass, and its inertia as if it were locked, belong to the body that bears it. Beside them come ratio^2 inertia on the
    joint, and the angular momentum ratio inertia speed of that body about the axis: where the body turns the rotor resists,
    and where the joint speeds up it turns the body. A joint with a rotor does not close loops: where all joints of a loop
    have rotors, one of them must go without. Efforts of inputs and drivers are those on the joint, behind the gear.
    """

    inertia: NotNegative = Field(description="inertia about its axis in kg m2")
    ratio: Number = Field(description="speed of the rotor by the joint's (rad/m on a prismatic joint)")


class Revolute(Driveable):
    """Rotation about an axis. damper : N m s/rad. input : torque, N m. turning : a rotor that turns with it.

    output : beside motion and reactions, what spring, damper, friction, stop, input and driver each exert on the second
        marker along the joint, N m ("effort" is the driver's, too: it needs one), and the power of all these on the bodies, W.
    """

    kind: ClassVar[str] = "revolute"
    coordinates: ClassVar[tuple] = (ANGLE,)

    revolute: AxisOptions
    start: RevoluteStart = left_out(RevoluteStart)
    spring: AngularSpring | None = None
    damper: number_or(NotNegative, EffortDamper) = 0.0
    friction: Friction | None = None
    turning: Turning | None = None
    stop: AngularStop | None = None
    driver: AngularDriver | None = None
    input: SomeOf("torque", bare=True) = []
    output: SomeOf(*coordinate_names(coordinates), "acceleration", *EFFORT_OUTPUTS, "power", *REACTIONS) = []


class Prismatic(Driveable):
    """Translation along an axis. damper : N s/m. input : force, N. turning : a rotor that turns with it.

    output : beside motion and reactions, what spring, damper, friction, stop, input and driver each exert on the second
        marker along the joint, N ("effort" is the driver's, too: it needs one), and the power of all these on the bodies, W.
    """

    kind: ClassVar[str] = "prismatic"
    coordinates: ClassVar[tuple] = (SLIDE,)

    prismatic: AxisOptions
    start: PrismaticStart = left_out(PrismaticStart)
    spring: LinearSpring | None = None
    damper: number_or(NotNegative, EffortDamper) = 0.0
    friction: Friction | None = None
    turning: Turning | None = None
    stop: LinearStop | None = None
    driver: LinearDriver | None = None
    input: SomeOf("force", bare=True) = []
    output: SomeOf(*coordinate_names(coordinates), "acceleration", *EFFORT_OUTPUTS, "power", *REACTIONS) = []


class ScrewOptions(AxisOptions):
    """axis : of the joint, in both markers' frames alike. pitch : m per turn."""

    pitch: NotZero = Field(description="advance in m per turn")


class Screw(Plain):
    """Rotation about an axis that advances along it. input : torque, N m."""

    kind: ClassVar[str] = "screw"
    coordinates: ClassVar[tuple] = (SLIDE, ANGLE_BESIDE_SLIDE)

    screw: ScrewOptions
    start: ScrewStart = left_out(ScrewStart)
    input: SomeOf("torque", bare=True) = []
    output: SomeOf(*coordinate_names(coordinates), *REACTIONS) = []

    @property
    def pitch(self):
        """m per turn."""
        return self.screw.pitch


# more freedoms


class Cylindrical(Plain):
    """Rotation about an axis and translation along it. input : force (N), torque (N m)."""

    kind: ClassVar[str] = "cylindrical"
    coordinates: ClassVar[tuple] = (SLIDE, ANGLE_BESIDE_SLIDE)

    cylindrical: AxisOptions
    start: CylindricalStart = left_out(CylindricalStart)
    input: SomeOf("force", "torque", bare=True) = []
    output: SomeOf(*coordinate_names(coordinates), *REACTIONS) = []


def _perpendicular(value):
    first, second = axes = two_axes(value)
    if abs(unit_vector(first) @ unit_vector(second)) > 1e-6:
        raise ValueError(f"{show(first)} and {show(second)} are not perpendicular")
    return axes


class UniversalOptions(Part):
    """axes : of the cross, the first as it is in the first marker, the second in the second."""

    axes: Annotated[tuple[Axis, Axis], BeforeValidator(_perpendicular)] = ("x", "y")


class Universal(Plain):
    """Rotation about an axis in the first marker, then about one in the second (Hooke, Cardan)."""

    kind: ClassVar[str] = "universal"
    coordinates: ClassVar[tuple] = (TWO_ANGLES,)
    input: ClassVar[tuple] = ()

    universal: UniversalOptions
    start: UniversalStart = left_out(UniversalStart)
    output: SomeOf(*coordinate_names(coordinates), *REACTIONS) = []

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
    coordinates: ClassVar[tuple] = (IN_PLANE, ANGLE_BESIDE_SLIDE)
    input: ClassVar[tuple] = ()

    planar: NormalOptions
    start: PlanarStart = left_out(PlanarStart)
    output: SomeOf(*coordinate_names(coordinates), *REACTIONS) = []

    @property
    def axes(self):
        """(3, 3): the two axes of the plane and its normal by column, in either marker's axes."""
        return plane_axes(self.axis)


class Translation(Plain):
    """Three translations and no rotation, as of a particle."""

    kind: ClassVar[str] = "translation"
    coordinates: ClassVar[tuple] = (IN_SPACE,)
    input: ClassVar[tuple] = ()

    translation: Empty
    start: TranslationStart = left_out(TranslationStart)
    output: SomeOf(*coordinate_names(coordinates), *REACTIONS) = []


class Spherical(Plain):
    """Rotation about a point. input : torque (3,) in N m on the second marker."""

    kind: ClassVar[str] = "spherical"
    coordinates: ClassVar[tuple] = (ORIENTATION,)

    spherical: Empty
    start: SphericalStart = left_out(SphericalStart)
    input: SomeOf("torque", bare=True) = []
    output: SomeOf(*ROTATION_OUTPUTS, *REACTIONS) = []


class Free(Plain):
    """All motions."""

    kind: ClassVar[str] = "free"
    coordinates: ClassVar[tuple] = (IN_SPACE, FREE_ORIENTATION)
    input: ClassVar[tuple] = ()

    free: Empty
    start: FreeStart = left_out(FreeStart)
    output: SomeOf(*POSE_OUTPUTS) = []


Joint = by_key(
    "a joint",
    Fixed,
    Revolute,
    Prismatic,
    Cylindrical,
    Universal,
    Spherical,
    Planar,
    Translation,
    Screw,
    Free,
    *rare_kinds("prescribed", prescribed="Prescribed"),
    *CONSTRAINTS,
    *END_FRAMES,
)
