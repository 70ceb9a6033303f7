"""Prescribed motion of the ground, the frame of the whole assembly, in the inertial frame."""

from typing import Annotated, ClassVar

import numpy as np
from pydantic import AfterValidator, Field, field_validator, model_validator

from .. import rotations
from ..vocabulary import GROUND_INPUTS
from .errors import listed, quoted, show
from .fields import (
    AllOrSome,
    Axis,
    Boolean,
    NotNegative,
    NotZero,
    Number,
    Part,
    Positive,
    Vector,
    by_key,
    in_si,
    plane_axes,
    unit_vector,
)
from .orientation import unit_euler_parameters
from .tables import Ascending, MotionReading, Rows, Table, Vectors


class ConstantAcceleration(Part):
    """acceleration, and velocity and position at time 0 : (3,) in m/s2, m/s, m. No rotation."""

    kind: ClassVar[str] = "acceleration"

    acceleration: Vector
    velocity: Vector = (0.0, 0.0, 0.0)
    position: Vector = (0.0, 0.0, 0.0)


class RotationOptions(Part):
    """A uniform rotation about an axis through a point; where the angle is 0, ground is inertial.

    axis : fixed in both frames.
    speed (rad/s), speed_deg (deg/s) or speed_rpm.
    point : (3,) in m, in both frames.
    angle (rad) or angle_deg : at time 0.
    """

    exclusive = (("angle", "angle_deg"),)
    needed = (("speed", "speed_deg", "speed_rpm"),)

    axis: Axis = "z"
    speed: Number | None = None
    speed_deg: Number | None = None
    speed_rpm: Number | None = None
    point: Vector = (0.0, 0.0, 0.0)
    angle: Number | None = None
    angle_deg: Number | None = None

    def direction(self):
        """The axis, a unit vector (3,)."""
        return unit_vector(self.axis)

    def speed_value(self):
        """rad/s."""
        return in_si(self, "speed")

    def angle_value(self):
        """rad, at time 0."""
        return in_si(self, "angle")


class Rotation(Part):
    """rotation = { axis, speed, point, angle }"""

    kind: ClassVar[str] = "rotation"

    rotation: RotationOptions


class OrbitOptions(Part):
    """A circular orbit about the inertial origin.

    radius : m.
    rate : rad/s.
    normal : of the orbit's plane. The angle in it counts from the inertial x axis, projected into
        the plane (the y axis where the normal is the x axis).
    phase_deg : angle at time 0.
    pointing : whether the ground's x axis stays radial and its y axis along the track; else the
        ground keeps the axes of the inertial frame.
    """

    radius: Positive = Field(description="radius in m")
    rate: NotZero = Field(description="rate in rad/s")
    normal: Axis = "z"
    phase_deg: Number = 0.0
    pointing: Boolean = True

    def axes(self):
        """(3, 3), by column: the radial direction and the track's at angle 0, and the normal."""
        return plane_axes(unit_vector(self.normal))

    def phase_value(self):
        """rad."""
        return in_si(self, "phase")


class Orbit(Part):
    """orbit = { radius, rate, normal, phase_deg, pointing }"""

    kind: ClassVar[str] = "orbit"

    orbit: OrbitOptions


def _below_1(value):
    if value >= 1.0:
        raise ValueError(f"must be below 1, that of a closed orbit; found {show(value)}")
    return value


class EllipticOrbitOptions(Part):
    """An elliptic Kepler orbit about the inertial origin.

    semi_major_axis : m.
    eccentricity : from 0, a circle, to below 1.
    mu or period : of what attracts, m3/s2; of a revolution, s.
    inclination_deg, node_deg, periapsis_deg : of the plane to the inertial x-y plane; of the ascending node, from the x axis
        about z; and of the periapsis, from the node in the plane.
    mean_anomaly_deg or true_anomaly_deg : at time 0, from the periapsis.
    pointing : whether the ground's x axis stays radial, its z axis normal to the plane and its y axis forward; else the
        ground keeps the axes of the inertial frame.
    """

    exclusive = (("mu", "period"), ("mean_anomaly_deg", "true_anomaly_deg"))
    needed = (("mu", "period"),)

    semi_major_axis: Positive = Field(description="semi-major axis in m")
    eccentricity: Annotated[NotNegative, AfterValidator(_below_1)] = Field(description="from 0 to below 1")
    mu: Positive | None = None
    period: Positive | None = None
    inclination_deg: Number = 0.0
    node_deg: Number = 0.0
    periapsis_deg: Number = 0.0
    mean_anomaly_deg: Number | None = None
    true_anomaly_deg: Number | None = None
    pointing: Boolean = True

    def axes(self):
        """(3, 3), by column: towards the periapsis, along the track there, and the normal."""
        angles = [in_si(self, key) for key in ("node", "inclination", "periapsis")]
        return rotations.Rotation.from_euler("ZXZ", angles).as_matrix()

    def mean_motion(self):
        """rad/s."""
        return 2 * np.pi / self.period if self.period else np.sqrt(self.mu / self.semi_major_axis**3)

    def mean_anomaly_value(self):
        """rad, at time 0."""
        nu, e = in_si(self, "true_anomaly", None), self.eccentricity
        if nu is None:
            return in_si(self, "mean_anomaly")

        # from the true to the eccentric anomaly, on the same turn
        E = nu - 2 * np.arctan2(e * np.sin(nu), 1 + np.sqrt(1 - e * e) + e * np.cos(nu))
        return E - e * np.sin(E)


class EllipticOrbit(Part):
    """elliptic_orbit = { semi_major_axis, eccentricity, mu, inclination_deg, node_deg, periapsis_deg, mean_anomaly_deg, pointing }"""

    kind: ClassVar[str] = "elliptic_orbit"

    elliptic_orbit: EllipticOrbitOptions


def _unit_rows(rows):
    for i, row in enumerate(rows, 1):
        try:
            unit_euler_parameters(row)
        except ValueError as error:
            raise ValueError(f"[{i}]: {error}") from None
    return rows


class PoseOverTime(Table):
    """time : s, and either or both of

    position : (n, 3) in m.
    zyx_deg, zyx_rad : (n, 3) yaw, pitch, roll; or euler_parameters : (n, 4), scalar last.
    interpolation : of positions and Euler parameters between the points, as told above under Tables; before the first and
        after the last the ground stands still.
    """

    exclusive = (("zyx_deg", "zyx_rad", "euler_parameters"),)

    time: Ascending
    position: Vectors | None = None
    zyx_deg: Rows(3, "rows of angles [yaw, pitch, roll] in degrees") | None = None
    zyx_rad: Rows(3, "rows of angles [yaw, pitch, roll] in rad") | None = None
    euler_parameters: (
        Annotated[
            Rows(4, "rows of Euler parameters [E1, E2, E3, E4], scalar last"),
            AfterValidator(_unit_rows),
        ]
        | None
    ) = None
    interpolation: MotionReading = "smooth"

    @model_validator(mode="after")
    def _check_not_empty(self):
        if not self.model_fields_set - {"time", "interpolation"}:
            raise ValueError('needs "position" or an orientation: "zyx_deg", "zyx_rad" or "euler_parameters"')
        return self

    def points(self):
        """(time (n,), position (n, 3), Euler parameters (n, 4) that do not jump in sign)."""
        time = np.array(self.time)
        position = np.zeros((len(time), 3)) if self.position is None else np.array(self.position)

        if self.euler_parameters is not None:
            E = rotations.Rotation.from_quat(self.euler_parameters).as_quat()
        else:
            angles = in_si(self, "zyx", np.zeros((len(time), 3)))
            E = rotations.Rotation.from_euler("ZYX", angles).as_quat()

        turns = np.sum(E[1:] * E[:-1], axis=1) < 0
        E[1:][np.cumsum(turns) % 2 == 1] *= -1
        return time, position, E


class Tabulated(Part):
    """table = { time, position, zyx_deg, interpolation }"""

    kind: ClassVar[str] = "table"

    table: PoseOverTime


# what some of GROUND_INPUTS need beside them
BESIDE = {
    "velocity": ("position",),
    "acceleration": ("velocity",),
    "omega": ("euler_parameters", "zyx"),
    "alpha": ("omega",),
}


class FromInputs(Part):
    """What inputs tell of the motion. input = true: position, velocity, acceleration, euler_parameters, omega, alpha.

    input : true, or a list of these, or with zyx (yaw, pitch, roll in rad) in place of euler_parameters, as in
        input = ["position", "zyx"]. What is not told is found from the last commands. speed stands for velocity.
    """

    kind: ClassVar[str] = "input"

    input: AllOrSome(*GROUND_INPUTS, "speed")

    @field_validator("input")
    @classmethod
    def _check_commands(cls, told):
        if told is True:
            return told
        if "speed" in told and "velocity" in told:
            raise ValueError('"speed" and "velocity" are one and the same; keep one of them')
        told = ["velocity" if what == "speed" else what for what in told]
        if "euler_parameters" in told and "zyx" in told:
            raise ValueError('"euler_parameters" and "zyx" tell the same; keep one of them')
        for what in told:
            beside = BESIDE.get(what)
            if beside and not set(beside) & set(told):
                raise ValueError(f"{quoted(what)} needs {listed(beside, 'or')} beside it")
        return told

    def commands(self):
        """What inputs tell, in the order of GROUND_INPUTS."""
        return [
            what
            for what in GROUND_INPUTS
            if (what in self.input if self.input is not True else what != "zyx")
        ]


Motion = by_key("a motion", ConstantAcceleration, Rotation, Orbit, EllipticOrbit, Tabulated, FromInputs)
