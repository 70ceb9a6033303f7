"""What all joints have in common."""

from typing import ClassVar

import numpy as np
from pydantic import Field

from .ends import BETWEEN, Between
from .errors import show
from .fields import Axis, Part, axis, unit_vector
from .starts import RATES, Start


class AxisOptions(Part):
    """axis : of the joint, in both markers' frames alike."""

    axis: Axis = "z"


def two_axes(value):
    """Two axes (a tuple), or ValueError."""
    if not isinstance(value, (list, tuple)) or len(value) != 2:
        raise ValueError(f'needs two axes, as in ["x", "y"]; found {show(value)}')
    return tuple(axis(item) for item in value)


class NormalOptions(Part):
    """normal : of the joint's plane, in the frames of the markers it belongs to."""

    normal: Axis = "z"


class JointBase(Part):
    """A joint lets the second of two markers move in the first.

    between : the two ends. At the joint's zero position their frames coincide.
    start : position and speed at the start.
    spring, damper, friction, stop, turning, driver : in the joint itself; None, 0 for kinds without.
    input : names of the efforts that come from outside.
    output : names of what goes out.
    """

    # what users call its coordinates (vocabulary.Coordinate), in the order of its simple motions
    coordinates: ClassVar[tuple] = ()

    between: Between = Field(description=BETWEEN)

    @property
    def options(self):
        """The table of the joint's kind."""
        return getattr(self, self.kind)

    @property
    def axis(self):
        """The unit vector (3,) of the axis, normal or lateral direction; z where there is none."""
        given = (getattr(self.options, key, None) for key in ("axis", "normal", "lateral"))
        return unit_vector(next(filter(None, given), "z"))

    @property
    def start_given(self):
        """The set of the keys that the start was written with."""
        start = getattr(self, "start", None)
        keys = start.model_fields_set if start else ()
        return {key for key in keys if getattr(start, key) is not None}

    @property
    def stays_in_tree(self):
        """Whether the joint needs its coordinates in every formulation."""
        return bool(self.turning)

    @property
    def holds_position(self):
        """Whether the start says where the joint is."""
        return any(not key.startswith(RATES) for key in self.start_given)

    @property
    def holds_velocity(self):
        """Whether the start says how fast the joint moves."""
        return any(key.startswith(RATES) for key in self.start_given)

    def given_position(self):
        """For each coordinate (an orientation counts as three) how its start was written, "" or "_deg", or None."""
        start = getattr(self, "start", None)
        return start.given(start.places) if isinstance(start, Start) else []

    def given_velocity(self):
        """The same of its rate: "", "_deg", "_rpm", or "_body" for a component in the second marker's axes."""
        start = getattr(self, "start", None)
        return start.given(start.rates) if isinstance(start, Start) else []

    def start_position(self):
        """Joint coordinates q at the start.

        revolute, screw [rad], prismatic [m], cylindrical [m, rad], universal [rad, rad],
        planar [m, m, rad], translation [x, y, z], spherical [E1..E4], free [x, y, z, E1..E4];
        fixed and those that only constrain [].
        """
        return self.start.q()

    def start_velocity(self):
        """Joint velocities v at the start.

        In the order of the coordinates, with omega (3,) for orientations; vectors are in the
        first marker's axes.
        """
        return self.start.v()


class Passive(JointBase):
    """A joint in which nothing acts but, maybe, efforts from outside and a driver."""

    spring: ClassVar[None] = None
    damper: ClassVar[float] = 0.0
    friction: ClassVar[None] = None
    turning: ClassVar[None] = None
    stop: ClassVar[None] = None


class Plain(Passive):
    """A joint in which nothing acts but, maybe, efforts from outside."""

    driver: ClassVar[None] = None


class Constraint(Plain):
    """A joint that only takes freedoms away: it has no coordinates and leads no body to ground."""

    input: ClassVar[tuple] = ()

    def start_position(self):
        """[]"""
        return np.empty(0)

    def start_velocity(self):
        """[]"""
        return np.empty(0)
