"""How joints start: position and motion of the second marker in the first."""

from typing import ClassVar

import numpy as np

from .fields import Components, Number, Part, filled, in_si
from .orientation import Oriented, Placed

# How the keys begin that say how fast it starts; the others say where.
RATES = ("speed", "angular_speed", "velocity", "omega")


# how the keys end, and the factor from SI units to those that they are in
ENDINGS = {"": 1.0, "_body": 1.0, "_deg": 180 / np.pi, "_rpm": 30 / np.pi}

ORIENTATION = "orientation"

Vector = Components("xyz", "3 numbers [x, y, z]")
Vector2 = Components("xy", "2 numbers [x, y]")
TwoNumbers = Components(("first", "second"), "2 numbers, one for each axis")


class Start(Part):
    """Where a joint starts and how fast; what is not written follows from the rest of the scene.

    Of each group of the joint's coordinates, `places` and `rates` have the key's beginning and the names of its components, ("",)
    for one number; an orientation counts as three.
    """

    places: ClassVar[tuple] = ()
    rates: ClassVar[tuple] = ()

    def given(self, groups):
        """For each coordinate of `places` or `rates` how its key ends, None where it is not given."""
        found = []

        for beginning, names in groups:
            key = self._key(beginning)
            value = getattr(self, key, None) if key else None

            for name in names:
                written = key and (not isinstance(value, dict) or name in value)
                found.append(key.removeprefix(beginning) if written else None)

        return found

    def _key(self, beginning):
        """The key that a group of coordinates was written with, or None."""
        if not self.model_fields_set:
            return None

        keys = [beginning + ending for ending in ENDINGS]

        if beginning == ORIENTATION:
            return (
                ORIENTATION if any(getattr(self, key) is not None for key in Oriented.model_fields) else None
            )

        return next(
            (key for key in keys if key in self.model_fields_set and getattr(self, key) is not None), None
        )


class RevoluteStart(Start):
    """angle or angle_deg; speed (rad/s), speed_deg (deg/s) or speed_rpm."""

    places = (("angle", ("",)),)
    rates = (("speed", ("",)),)

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


class PrismaticStart(Start):
    """position : m. speed : m/s."""

    places = (("position", ("",)),)
    rates = (("speed", ("",)),)

    position: Number = 0.0
    speed: Number = 0.0

    def q(self):
        """[position] in m."""
        return np.array([self.position])

    def v(self):
        """[speed] in m/s."""
        return np.array([self.speed])


class ScrewStart(Start):
    """angle or angle_deg; angular_speed (rad/s), angular_speed_deg (deg/s) or angular_speed_rpm."""

    # its position follows the angle
    places = (("angle", ("", "")),)
    rates = (("angular_speed", ("", "")),)

    exclusive = (
        ("angle", "angle_deg"),
        ("angular_speed", "angular_speed_deg", "angular_speed_rpm"),
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
    """angle and angular_speed as of a screw, and position : m, speed : m/s, along the axis."""

    places = (("position", ("",)), ("angle", ("",)))
    rates = (("speed", ("",)), ("angular_speed", ("",)))

    position: Number = 0.0
    speed: Number = 0.0

    def q(self):
        """[position in m, angle in rad]."""
        return np.concatenate([[self.position], super().q()])

    def v(self):
        """[speed in m/s, angular speed in rad/s]."""
        return np.concatenate([[self.speed], super().v()])


class PlanarStart(ScrewStart):
    """angle and angular_speed as of a screw, about the normal, and position : (2,) in m, velocity : (2,) in m/s."""

    places = (("position", "xy"), ("angle", ("",)))
    rates = (("velocity", "xy"), ("angular_speed", ("",)))

    position: Vector2 = (0.0, 0.0)
    velocity: Vector2 = (0.0, 0.0)

    def q(self):
        """[x, y in m, angle in rad]."""
        return np.concatenate([filled(self.position, "xy"), super().q()])

    def v(self):
        """[velocity (2,) in m/s, angular speed in rad/s]."""
        return np.concatenate([filled(self.velocity, "xy"), super().v()])


class UniversalStart(Start):
    """angles or angles_deg; speeds (rad/s) or speeds_deg (deg/s); each about the two axes."""

    places = (("angles", ("first", "second")),)
    rates = (("speeds", ("first", "second")),)

    exclusive = (("angles", "angles_deg"), ("speeds", "speeds_deg"))

    angles: TwoNumbers | None = None
    angles_deg: TwoNumbers | None = None
    speeds: TwoNumbers | None = None
    speeds_deg: TwoNumbers | None = None

    def q(self):
        """Angles (2,) in rad."""
        return in_si(self, "angles", np.zeros(2), ("first", "second"))

    def v(self):
        """Speeds (2,) in rad/s."""
        return in_si(self, "speeds", np.zeros(2), ("first", "second"))


class TranslationStart(Start):
    """position, velocity : (3,) in m and m/s, in the first marker's axes."""

    places = (("position", "xyz"),)
    rates = (("velocity", "xyz"),)

    position: Vector = (0.0, 0.0, 0.0)
    velocity: Vector = (0.0, 0.0, 0.0)

    def q(self):
        """Position (3,) in m."""
        return filled(self.position, "xyz")

    def v(self):
        """Velocity (3,) in m/s."""
        return filled(self.velocity, "xyz")


class SphericalStart(Oriented, Start):
    """Orientation of the second marker in the first, and angular velocity.

    omega, omega_body : rad/s, in the first marker's axes or in the second's.
    """

    exclusive = (*Oriented.exclusive, ("omega", "omega_body"))
    places = ((ORIENTATION, "xyz"),)
    rates = (("omega", "xyz"),)

    omega: Vector | None = None
    omega_body: Vector | None = None

    def q(self):
        """Euler parameters (4,), scalar last."""
        return self.rotation().as_quat()

    def v(self):
        """Angular velocity (3,) in the first marker's axes, rad/s."""
        if self.omega_body is not None:
            return self.rotation().apply(filled(self.omega_body, "xyz"))
        return filled(self.omega or (0.0, 0.0, 0.0), "xyz")


class FreeStart(SphericalStart, Placed):
    """Place and motion of the second marker in the first.

    position, velocity : m and m/s, in the first marker's axes.
    omega, omega_body : rad/s, in the first marker's axes or in the second's.
    """

    places = (("position", "xyz"), (ORIENTATION, "xyz"))
    rates = (("velocity", "xyz"), ("omega", "xyz"))

    position: Vector = (0.0, 0.0, 0.0)
    velocity: Vector = (0.0, 0.0, 0.0)

    def q(self):
        """[position (3,) in m, Euler parameters (4,)]."""
        return np.concatenate([filled(self.position, "xyz"), super().q()])

    def v(self):
        """[velocity (3,) in m/s, angular velocity (3,) in rad/s] in the first marker's axes."""
        return np.concatenate([filled(self.velocity, "xyz"), super().v()])
