"""Tables: quantities given at points, between which they are interpolated."""

from typing import Annotated, ClassVar

import numpy as np
from pydantic import AfterValidator, BeforeValidator, Field, model_validator

from .errors import quoted, show
from .fields import Part, array, in_si


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


def _ascending(values):
    for i, (before, after) in enumerate(zip(values, values[1:]), 2):
        if not before < after:
            raise ValueError(f"must ascend, but [{i}] is {show(after)} after {show(before)}")
    return values


Numbers = Rows(None, "numbers")
Vectors = Rows(3, "vectors [x, y, z]")
Ascending = Annotated[Numbers, AfterValidator(_ascending)]


class Table(Part):
    """A table has the argument first, then a value of each quantity for each of its values."""

    @model_validator(mode="after")
    def _check_lengths(self):
        given = {key: getattr(self, key) for key in type(self).model_fields}
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


class EffortOverPosition(Graph):
    """position : m. effort : what the spring bears there, N, as stiffness * (position - rest)."""

    argument = "position"
    value = "effort"

    position: Ascending
    effort: Numbers


class EffortOverAngle(Graph):
    """position (rad) or position_deg. effort : what the spring bears there, N m."""

    needed = (("position", "position_deg"),)
    argument = "position"
    value = "effort"

    position: Ascending | None = None
    position_deg: Ascending | None = None
    effort: Numbers


class EffortOverSpeed(Graph):
    """speed : m/s, rad/s. effort : what the damper bears there, N, N m, as damping * speed."""

    argument = "speed"
    value = "effort"

    speed: Ascending
    effort: Numbers


class ForceOverLength(Graph):
    """length : m. force : N, tension positive."""

    argument = "length"
    value = "force"

    length: Ascending
    force: Numbers


class ForceOverSpeed(Graph):
    """speed : at which it lengthens, m/s. force : N, tension positive."""

    argument = "speed"
    value = "force"

    speed: Ascending
    force: Numbers


class PositionOverTime(Graph):
    """time : s. position : m."""

    argument = "time"
    value = "position"

    time: Ascending
    position: Numbers


class AngleOverTime(Graph):
    """time : s. position (rad) or position_deg."""

    needed = (("position", "position_deg"),)
    argument = "time"
    value = "position"

    time: Ascending
    position: Numbers | None = None
    position_deg: Numbers | None = None


class EffortDamper(Part):
    """table = { speed, effort }"""

    table: EffortOverSpeed = Field(description="as in table = { speed = [...], effort = [...] }")


class ForceDamper(Part):
    """table = { speed, force }"""

    table: ForceOverSpeed = Field(description="as in table = { speed = [...], force = [...] }")
