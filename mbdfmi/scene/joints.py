"""Joints between two markers, and how they start."""

from typing import Annotated, ClassVar

import numpy as np
from pydantic import BeforeValidator, Field

from .errors import quoted, show
from .fields import Axis, Empty, NotNegative, Number, OneOf, Part, SomeOf, Vector, by_key
from .fields import unit_vector
from .orientation import Oriented, Placed

RPM = np.pi / 30


def _between(value):
    if not isinstance(value, (list, tuple)) or len(value) != 2:
        raise ValueError(f'needs two ends, as in ["ground", "body.marker"]; found {show(value)}')
    return tuple(_end(end) for end in value)


def _end(value):
    if not isinstance(value, str):
        raise ValueError(f'an end is a text, "body" or "body.marker"; found {show(value)}')

    names = [name.strip() for name in value.split(".")]
    if len(names) > 2 or not all(names):
        raise ValueError(f'an end is "body" or "body.marker", found {quoted(value)}')
    return ".".join(names)


# Two ends, each "body", "body.marker", "ground" or "ground.marker".
Between = Annotated[tuple[str, str], BeforeValidator(_between)]
BETWEEN = 'the two ends, as in between = ["ground", "body.marker"]'


# starts and springs

class RevoluteStart(Part):
    """angle or angle_deg; speed (rad/s), speed_deg (deg/s) or speed_rpm."""

    exclusive = (("angle", "angle_deg"), ("speed", "speed_deg", "speed_rpm"))

    angle: Number | None = None
    angle_deg: Number | None = None
    speed: Number | None = None
    speed_deg: Number | None = None
    speed_rpm: Number | None = None

    def q(self):
        """[angle] in rad."""
        return np.array([self.angle or np.radians(self.angle_deg or 0.0)])

    def v(self):
        """[speed] in rad/s."""
        speed = self.speed or np.radians(self.speed_deg or 0.0) or (self.speed_rpm or 0.0) * RPM
        return np.array([speed])


class PrismaticStart(Part):
    """position : m. speed : m/s."""

    position: Number = 0.0
    speed: Number = 0.0

    def q(self):
        """[position] in m."""
        return np.array([self.position])

    def v(self):
        """[speed] in m/s."""
        return np.array([self.speed])


class SphericalStart(Oriented):
    """Orientation of the second marker in the first, and angular velocity.

    omega, omega_body : rad/s, in the first marker's axes or in the second's.
    """

    exclusive = (*Oriented.exclusive, ("omega", "omega_body"))

    omega: Vector | None = None
    omega_body: Vector | None = None

    def q(self):
        """Euler parameters (4,), scalar last."""
        return self.rotation().as_quat()

    def v(self):
        """Angular velocity (3,) in the first marker's axes, rad/s."""
        if self.omega_body is not None:
            return self.rotation().apply(self.omega_body)
        return np.array(self.omega or (0.0, 0.0, 0.0))


class FreeStart(SphericalStart, Placed):
    """Place and motion of the second marker in the first.

    position, velocity : m and m/s, in the first marker's axes.
    omega, omega_body : rad/s, in the first marker's axes or in the second's.
    """

    velocity: Vector = (0.0, 0.0, 0.0)

    def q(self):
        """[position (3,) in m, Euler parameters (4,)]."""
        return np.concatenate([self.position, super().q()])

    def v(self):
        """[velocity (3,) in m/s, angular velocity (3,) in rad/s] in the first marker's axes."""
        return np.concatenate([self.velocity, super().v()])


class AngularSpring(Part):
    """stiffness : N m/rad. rest (rad) or rest_deg : the angle at which it is slack."""

    exclusive = (("rest", "rest_deg"),)

    stiffness: NotNegative = Field(description="stiffness in N m/rad")
    rest: Number | None = None
    rest_deg: Number | None = None

    def rest_value(self):
        """rad."""
        return self.rest or np.radians(self.rest_deg or 0.0)


class LinearSpring(Part):
    """stiffness : N/m. rest : the position at which it is slack, m."""

    stiffness: NotNegative = Field(description="stiffness in N/m")
    rest: Number = 0.0

    def rest_value(self):
        """m."""
        return self.rest


# joints

class AxisOptions(Part):
    """axis : of the joint, in both markers' frames alike."""

    axis: Axis = "z"


class JointBase(Part):
    """A joint lets the second of two markers move in the first.

    between : the two ends. At the joint's zero position their frames coincide.
    start : position and speed at the start.
    spring, damper : in the joint itself; None and 0 for kinds that have none.
    input : name of the effort that comes from outside, or None.
    output : names of what goes out.
    """

    between: Between = Field(description=BETWEEN)

    @property
    def axis(self):
        """The unit vector (3,) of the axis, in either marker's axes; z where a kind has none."""
        return unit_vector(getattr(getattr(self, self.kind), "axis", "z"))

    def start_position(self):
        """Joint coordinates q at the start.

        revolute [rad], prismatic [m], spherical [E1..E4], free [x, y, z, E1..E4], fixed [].
        """
        return self.start.q()

    def start_velocity(self):
        """Joint velocities v at the start.

        revolute [rad/s], prismatic [m/s], spherical omega, free [velocity, omega], fixed [];
        vectors are in the first marker's axes.
        """
        return self.start.v()


class Fixed(JointBase):
    """No motion."""

    kind: ClassVar[str] = "fixed"
    spring: ClassVar[None] = None
    damper: ClassVar[float] = 0.0
    input: ClassVar[None] = None
    output: ClassVar[tuple] = ()

    fixed: Empty

    def start_position(self):
        """[]"""
        return np.empty(0)

    def start_velocity(self):
        """[]"""
        return np.empty(0)


class Revolute(JointBase):
    """Rotation about an axis. damper : N m s/rad. input : torque, N m."""

    kind: ClassVar[str] = "revolute"

    revolute: AxisOptions
    start: RevoluteStart = RevoluteStart()
    spring: AngularSpring | None = None
    damper: NotNegative = 0.0
    input: OneOf("torque") | None = None
    output: SomeOf("angle", "speed", "acceleration") = []


class Prismatic(JointBase):
    """Translation along an axis. damper : N s/m. input : force, N."""

    kind: ClassVar[str] = "prismatic"

    prismatic: AxisOptions
    start: PrismaticStart = PrismaticStart()
    spring: LinearSpring | None = None
    damper: NotNegative = 0.0
    input: OneOf("force") | None = None
    output: SomeOf("position", "speed", "acceleration") = []


class Spherical(JointBase):
    """Rotation about a point. input : torque (3,) in N m on the second marker."""

    kind: ClassVar[str] = "spherical"
    spring: ClassVar[None] = None
    damper: ClassVar[float] = 0.0

    spherical: Empty
    start: SphericalStart = SphericalStart()
    input: OneOf("torque") | None = None
    output: SomeOf("euler_parameters", "zyx", "omega", "alpha") = []


class Free(JointBase):
    """All motions."""

    kind: ClassVar[str] = "free"
    spring: ClassVar[None] = None
    damper: ClassVar[float] = 0.0
    input: ClassVar[None] = None

    free: Empty
    start: FreeStart = FreeStart()
    output: SomeOf("position", "velocity", "euler_parameters", "zyx", "omega") = []


Joint = by_key("a joint", Fixed, Revolute, Prismatic, Spherical, Free)
