"""How joints start: position and motion of the second marker in the first."""

import numpy as np

from .fields import Array, Number, Part, Vector, Vector2, in_si
from .orientation import Oriented, Placed

# How the keys begin that say how fast it starts; the others say where.
RATES = ("speed", "angular_speed", "velocity", "omega")


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
        return np.array([in_si(self, "angle")])

    def v(self):
        """[speed] in rad/s."""
        return np.array([in_si(self, "speed")])


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


class ScrewStart(Part):
    """angle or angle_deg; angular_speed (rad/s), angular_speed_deg (deg/s) or angular_speed_rpm."""

    exclusive = (
        ("angle", "angle_deg"), ("angular_speed", "angular_speed_deg", "angular_speed_rpm"),
    )

    angle: Number | None = None
    angle_deg: Number | None = None
    angular_speed: Number | None = None
    angular_speed_deg: Number | None = None
    angular_speed_rpm: Number | None = None

    def q(self):
        """[angle] in rad."""
        return np.array([in_si(self, "angle")])

    def v(self):
        """[angular speed] in rad/s."""
        return np.array([in_si(self, "angular_speed")])


class CylindricalStart(ScrewStart):
    """As of a screw, and position : m, speed : m/s, along the axis."""

    position: Number = 0.0
    speed: Number = 0.0

    def q(self):
        """[position in m, angle in rad]."""
        return np.concatenate([[self.position], super().q()])

    def v(self):
        """[speed in m/s, angular speed in rad/s]."""
        return np.concatenate([[self.speed], super().v()])


class PlanarStart(ScrewStart):
    """As of a screw, about the normal, and position : (2,) in m, velocity : (2,) in m/s."""

    position: Vector2 = (0.0, 0.0)
    velocity: Vector2 = (0.0, 0.0)

    def q(self):
        """[x, y in m, angle in rad]."""
        return np.concatenate([self.position, super().q()])

    def v(self):
        """[velocity (2,) in m/s, angular speed in rad/s]."""
        return np.concatenate([self.velocity, super().v()])


TwoNumbers = Array((2,), what="2 numbers, one for each axis")


class UniversalStart(Part):
    """angles or angles_deg; speeds (rad/s) or speeds_deg (deg/s); each about the two axes."""

    exclusive = (("angles", "angles_deg"), ("speeds", "speeds_deg"))

    angles: TwoNumbers | None = None
    angles_deg: TwoNumbers | None = None
    speeds: TwoNumbers | None = None
    speeds_deg: TwoNumbers | None = None

    def q(self):
        """Angles (2,) in rad."""
        return in_si(self, "angles", np.zeros(2))

    def v(self):
        """Speeds (2,) in rad/s."""
        return in_si(self, "speeds", np.zeros(2))


class TranslationStart(Part):
    """position, velocity : (3,) in m and m/s, in the first marker's axes."""

    position: Vector = (0.0, 0.0, 0.0)
    velocity: Vector = (0.0, 0.0, 0.0)

    def q(self):
        """Position (3,) in m."""
        return np.array(self.position)

    def v(self):
        """Velocity (3,) in m/s."""
        return np.array(self.velocity)


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
