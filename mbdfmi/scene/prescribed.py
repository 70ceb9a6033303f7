"""A joint whose six coordinates are prescribed: an end frame that moves as told."""

from typing import ClassVar

import numpy as np
from pydantic import Field, model_validator

from ..vocabulary import IN_SPACE, POSE_EFFORTS, POSE_OUTPUTS, REACTIONS, YAW_PITCH_ROLL
from .efforts import AngularDriver, LinearDriver
from .errors import quoted
from .fields import Empty, Part, SomeOf, Vector, in_si, left_out
from .joint_base import Passive

PLACE = ("x", "y", "z")
TURN = ("yaw", "pitch", "roll")

# drivers that go on from the start
FROM_START = ("constant_speed", "hold", "speed_table", "input")


class PoseDriver(Part):
    """x, y, z : drivers of the second marker's position in the first, as of a prismatic joint. yaw, pitch, roll : drivers of its
    orientation, about z, then y, then x, as of a revolute joint.

    What is not driven is held where the start has it.
    """

    x: LinearDriver | None = None
    y: LinearDriver | None = None
    z: LinearDriver | None = None
    yaw: AngularDriver | None = None
    pitch: AngularDriver | None = None
    roll: AngularDriver | None = None

    @property
    def kind(self):
        """What there is of a driver of one coordinate, each of its own has."""
        return "pose"

    @model_validator(mode="after")
    def _check_not_empty(self):
        if not any(getattr(self, key) for key in PLACE + TURN):
            raise ValueError(
                'needs one of "x", "y", "z", "yaw", "pitch" and "roll"; a body that does not move is "fixed"'
            )
        return self


class PrescribedStart(Part):
    """position : of the second marker in the first, m. zyx_deg or zyx_rad : yaw, pitch and roll. Of coordinates that are held, or
    whose drivers go on from the start.
    """

    exclusive = (("zyx_deg", "zyx_rad"),)

    position: Vector = (0.0, 0.0, 0.0)
    zyx_deg: Vector | None = None
    zyx_rad: Vector | None = None

    def values(self):
        """(6,) m and rad."""
        return np.concatenate([self.position, in_si(self, "zyx", np.zeros(3))])


class Prescribed(Passive):
    """The second marker moves in the first as told, in all six freedoms: a platform, an end frame.

    Position and yaw, pitch and roll each follow a driver of their own; where the pitch passes 90 deg that is no trouble here. What
    drives it bears all that hangs on it, however heavy.

    output : pose and motion of the second marker in the first, what the drivers exert on it (driver_force along x, y, z of the
        first marker, driver_torque about the axes of yaw, pitch, roll: times the rates of the coordinates these are its power), and
        reactions.
    """

    kind: ClassVar[str] = "prescribed"
    coordinates: ClassVar[tuple] = (IN_SPACE, YAW_PITCH_ROLL)
    input: ClassVar[tuple] = ()

    prescribed: Empty
    driver: PoseDriver = Field(
        description="drivers of its coordinates, as in { x = { harmonic = { amplitude = 0.1, frequency = 1 } } }"
    )
    start: PrescribedStart = left_out(PrescribedStart)
    output: SomeOf(*POSE_OUTPUTS, *POSE_EFFORTS, *REACTIONS) = []

    @property
    def stays_in_tree(self):
        """It has no equations, but coordinates that are known."""
        return True

    def driven(self):
        """(key, driver, start value in m or rad) of each of the six coordinates; what no driver moves is held."""
        held = LinearDriver(hold=True), AngularDriver(hold=True)
        start = self.start_position()
        return [
            (key, getattr(self.driver, key) or held[k // 3], float(start[k]))
            for k, key in enumerate(PLACE + TURN)
        ]

    @model_validator(mode="after")
    def _check_start(self):
        for key, driver, value in self.driven():
            if value and driver.kind not in FROM_START:
                raise ValueError(f"the driver of {quoted(key)} says where it starts; drop it from the start")
        return self

    def start_position(self):
        """(6,) x, y, z in m, yaw, pitch, roll in rad, of what is held or goes on from there."""
        return self.start.values()

    def start_velocity(self):
        """(6,) zeros."""
        return np.zeros(6)
