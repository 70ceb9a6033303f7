"""Tables: quantities given at points, between which they are interpolated (compiler/interpolation.py)."""

import itertools
from typing import Annotated, ClassVar

import numpy as np
from pydantic import AfterValidator, BeforeValidator, Field, model_validator

from .errors import quoted, show
from .fields import OneOf, Part, array, in_si


def rows(value, width, what, least=2):
    """A tuple of at least so many rows of `width` floats (of floats for None), or ValueError."""
    if isinstance(value, np.ndarray):
        value = value.tolist()
    if not isinstance(value, (list, tuple)):
        raise ValueError(f"needs a list of {what}, found {show(value)}")
    if len(value) < least:
        raise ValueError(f"needs at least {least} {what}, found {len(value)}")
    return array(value, (len(value),) if width is None else (len(value), width), what=what)


def Rows(width, what, least=2):
    """The pydantic type of such rows."""
    return Annotated[tuple, BeforeValidator(lambda value: rows(value, width, what, least))]


def ascending(values):
    for i, (before, after) in enumerate(itertools.pairwise(values), 2):
        if not before < after:
            raise ValueError(f"must ascend, but [{i}] is {show(after)} after {show(before)}")
    return values


Numbers = Rows(None, "numbers")
Some = Rows(None, "numbers", least=1)
Vectors = Rows(3, "vectors [x, y, z]")
Ascending = Annotated[Numbers, AfterValidator(ascending)]


# how tables of forces and of motions are read between their points
ForceReading = OneOf("linear", "monotone", "cubic")
LoadReading = OneOf("linear", "steps", "monotone", "cubic")
MotionReading = OneOf("smooth", "quintic", "cubic", "linear")


class Table(Part):
    """A table has the argument first, then a value of each quantity for each of its values, then how it is read."""

    @model_validator(mode="after")
    def _check_lengths(self):
        given = {key: getattr(self, key) for key in type(self).model_fields if key != "interpolation"}
        (first, xs), *others = ((key, v) for key, v in given.items() if v is not None)
        for key, values in others:
            if len(values) != len(xs):
                raise ValueError(
                    f"{quoted(first)} has {len(xs)} values and {quoted(key)} {len(values)}; "
                    "each needs one of the other"
                )
        return self


class Graph(Table):
    """One quantity over another: `value` over `argument`, the names of their keys."""

    argument: ClassVar[str]
    value: ClassVar[str]

    def points(self):
        """(argument (n,), value (n,)) in SI."""
        return in_si(self, self.argument), in_si(self, self.value)


class ForceGraph(Graph):
    """interpolation : between the points, as told above under Tables; beyond the first and the last it goes on straight."""


class EffortOverPosition(ForceGraph):
    """position : m. effort : what the spring bears there, N, as stiffness * (position - rest)."""

    argument = "position"
    value = "effort"

    position: Ascending
    effort: Numbers
    interpolation: ForceReading = "linear"


class EffortOverAngle(ForceGraph):
    """position (rad) or position_deg. effort : what the spring bears there, N m."""

    needed = (("position", "position_deg"),)
    argument = "position"
    value = "effort"

    position: Ascending | None = None
    position_deg: Ascending | None = None
    effort: Numbers
    interpolation: ForceReading = "linear"


class EffortOverSpeed(ForceGraph):
    """speed : m/s, rad/s. effort : what the damper bears there, N, N m, as damping * speed."""

    argument = "speed"
    value = "effort"

    speed: Ascending
    effort: Numbers
    interpolation: ForceReading = "linear"


class ForceOverLength(ForceGraph):
    """length : m. force : N, tension positive."""

    argument = "length"
    value = "force"

    length: Ascending
    force: Numbers
    interpolation: ForceReading = "linear"


class ForceOverSpeed(ForceGraph):
    """speed : at which it lengthens, m/s. force : N, tension positive."""

    argument = "speed"
    value = "force"

    speed: Ascending
    force: Numbers
    interpolation: ForceReading = "linear"


class MotionOverTime(Graph):
    """interpolation : between the points, as told above under Tables; before the first and after the last it stands still."""

    argument = "time"
    value = "position"


class PositionOverTime(MotionOverTime):
    """time : s. position : m."""

    time: Ascending
    position: Numbers
    interpolation: MotionReading = "smooth"


class AngleOverTime(MotionOverTime):
    """time : s. position (rad) or position_deg."""

    needed = (("position", "position_deg"),)

    time: Ascending
    position: Numbers | None = None
    position_deg: Numbers | None = None
    interpolation: MotionReading = "smooth"


class RateOverTime(Graph):
    """interpolation : between the points, as told above under Tables; before the first and after the last the speed is theirs."""

    argument = "time"
    value = "speed"


class SpeedOverTime(RateOverTime):
    """time : s. speed : m/s."""

    time: Ascending
    speed: Numbers
    interpolation: MotionReading = "smooth"


class AngularSpeedOverTime(RateOverTime):
    """time : s. speed (rad/s), speed_deg (deg/s) or speed_rpm."""

    needed = (("speed", "speed_deg", "speed_rpm"),)

    time: Ascending
    speed: Numbers | None = None
    speed_deg: Numbers | None = None
    speed_rpm: Numbers | None = None
    interpolation: MotionReading = "smooth"


class EffortDamper(Part):
    """table = { speed, effort }"""

    table: EffortOverSpeed = Field(description="as in table = { speed = [...], effort = [...] }")


class ForceDamper(Part):
    """table = { speed, force }"""

    table: ForceOverSpeed = Field(description="as in table = { speed = [...], force = [...] }")
