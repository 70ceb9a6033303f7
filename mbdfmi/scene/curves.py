"""Curves on markers, each by a parameter s, in the marker's axes."""

import itertools
from math import dist
from typing import Annotated, ClassVar

import numpy as np
from pydantic import BeforeValidator, Field, model_validator

from .errors import show
from .fields import Boolean, Empty, NotZero, Part, Positive, array, by_key
from .tables import Ascending

# Points closer than this part of the curve's length are the same.
SAME = 1e-9


class CurveBase(Part):
    """A curve. Without points, it lies in the marker's xy plane."""

    @property
    def is_planar(self):
        """Whether the curve lies in a plane z = constant."""
        return True

    @property
    def unit(self):
        """Of its parameter; None where the user gave it."""
        return "m"


class Line(CurveBase):
    """line = {}: the x axis, s = x in m."""

    kind: ClassVar[str] = "line"

    line: Empty


class CircleOptions(Part):
    """radius : m."""

    radius: Positive = Field(description="radius in m")


class Circle(CurveBase):
    """circle = { radius }: about the origin; s is the arc length from the x axis, m."""

    kind: ClassVar[str] = "circle"

    circle: CircleOptions

    @property
    def radius(self):
        """m."""
        return self.circle.radius


class ParabolaOptions(Part):
    """coefficient : 1/m."""

    coefficient: NotZero = Field(description="coefficient c of y = c x^2, in 1/m")


class Parabola(CurveBase):
    """parabola = { coefficient }: y = coefficient x^2, s = x in m."""

    kind: ClassVar[str] = "parabola"

    parabola: ParabolaOptions

    @property
    def coefficient(self):
        """1/m."""
        return self.parabola.coefficient


class CycloidOptions(Part):
    """radius : of the rolling circle, m."""

    radius: Positive = Field(description="radius of the rolling circle in m")


class Cycloid(CurveBase):
    """cycloid = { radius }: x = radius (s + sin s), y = radius (1 - cos s), s in rad."""

    kind: ClassVar[str] = "cycloid"

    cycloid: CycloidOptions

    @property
    def radius(self):
        """m."""
        return self.cycloid.radius

    @property
    def unit(self):
        """Of its parameter."""
        return "rad"


def _points(value):
    """Rows of two or three numbers, none the same as the one before, or ValueError."""
    what = "points [x, y, z] or [x, y]"
    if isinstance(value, np.ndarray):
        value = value.tolist()
    if not isinstance(value, (list, tuple)):
        raise ValueError(f"needs a list of {what}, found {show(value)}")
    if len(value) < 2:
        raise ValueError(f"needs at least 2 {what}, found {len(value)}")

    points = array(value, (len(value), 3), (len(value), 2), what="a list of " + what)
    chords = [dist(*pair) for pair in itertools.pairwise(points)]
    for i, chord in enumerate(chords):
        if chord <= SAME * sum(chords):
            raise ValueError(f"[{i + 2}] is the same point as [{i + 1}], {show(points[i])}")
    return points


Points = Annotated[tuple, BeforeValidator(_points)]


class SplineOptions(Part):
    """points : (n, 3) or (n, 2), z = 0, in m.

    closed : whether the curve goes back to the first point, which is not repeated.
    s : parameter at the points, and, of a closed curve, back at the first; else the length along
        the chords, m.
    """

    points: Points = Field(description="points in m, as in points = [[0, 0, 0], [1, 0, 0]]")
    closed: Boolean = False
    s: Ascending | None = None

    @model_validator(mode="after")
    def _check_points(self):
        length = sum(dist(*pair) for pair in zip(self.points, self.points[1:]))
        if self.closed and dist(self.points[0], self.points[-1]) <= SAME * length:
            raise ValueError("the last point is the first again; leave it out of a closed curve")
        if self.closed and len(self.points) < 3:
            raise ValueError(f"a closed curve needs at least 3 points, found {len(self.points)}")

        needed = len(self.points) + self.closed
        if self.s is not None and len(self.s) != needed:
            why = ", one for each point" + " and one back at the first" * self.closed
            raise ValueError(f"s needs {needed} values{why}; found {len(self.s)}")
        return self

    def nodes(self):
        """(points (n, 3) in m, s (n,)); of a closed curve the last point is the first again."""
        points = np.array(self.points)
        if points.shape[1] == 2:
            points = np.column_stack([points, np.zeros(len(points))])
        if self.closed:
            points = np.vstack([points, points[:1]])

        if self.s is not None:
            return points, np.array(self.s)
        chords = [dist(*pair) for pair in itertools.pairwise(points)]
        return points, np.concatenate([[0.0], np.cumsum(chords)])


class PointCurve(CurveBase):
    """A cubic spline through points: not-a-knot, or periodic when closed."""

    @property
    def points(self):
        """(n, 3) in m; of a closed curve the last is the first again."""
        return getattr(self, self.kind).nodes()[0]

    @property
    def s(self):
        """Parameter (n,) at the points."""
        return getattr(self, self.kind).nodes()[1]

    @property
    def unit(self):
        """Of its parameter; None where the user gave it."""
        return "m" if getattr(self, self.kind).s is None else None

    @property
    def closed(self):
        """Whether it goes back to the first point."""
        return getattr(self, self.kind).closed

    @property
    def is_planar(self):
        """Whether the curve lies in a plane z = constant."""
        z = self.points[:, 2]
        return bool(np.ptp(z) <= 1e-9 * np.ptp(self.points, axis=0).max())


class Spline(PointCurve):
    """spline = { points, closed, s }"""

    kind: ClassVar[str] = "spline"

    spline: SplineOptions


class TableOptions(SplineOptions):
    """As of a spline, with the parameter s given."""

    s: Ascending = Field(description="the parameter at each point")


class TableCurve(PointCurve):
    """table = { s, points, closed }"""

    kind: ClassVar[str] = "table"

    table: TableOptions


Curve = by_key("a curve", Line, Circle, Parabola, Cycloid, Spline, TableCurve)
