"""Angles of one FMU as the orientation and the angular velocity that another takes."""

from __future__ import annotations

import re
from collections.abc import Sequence
from dataclasses import dataclass, field

import numpy as np
import scipy  # which imports its parts when they are asked for

from ..vectors import dot
from .measures import Measure, known
from .signals import Signal

ROTATION_VECTOR = "rotation_vector"

CONVERSION = re.compile(rf"(?:euler_([xyz])(?!\1)([xyz])(?!\2)[xyz]|{ROTATION_VECTOR})(_rates)?")

WORDS = (
    '"euler_zyx", of angles about z, then the new y, then the newest x, and so for each order of axes, or '
    '"rotation_vector"; with "_rates", as "euler_zyx_rates", for the angular velocity'
)

# rad, rotation vectors shorter than which turn by their first terms
SMALL = 1e-4


@dataclass(frozen=True, eq=False)
class Made(Signal):
    """A component of what a conversion makes. sources : scalars that it is made of."""

    sources: tuple[Signal, ...] = ()


@dataclass(frozen=True, eq=False)
class Conversion:
    """Angles, and of angular velocities their rates, in; Euler parameters, scalar last, or an angular velocity
    out, in the axes that the angles begin with.

    kind : what CONVERSION knows. sources : scalars, three angles, then their rates; factors : that make rad and
    rad/s of them. results : what is made.
    """

    kind: str
    sources: tuple[Signal, ...]
    factors: np.ndarray
    results: list[Made] = field(default_factory=list)

    def of(self, values: np.ndarray, before: np.ndarray) -> np.ndarray:
        """What it makes of the sources' values; before : what it made last.

        Of the two sets of Euler parameters of one orientation it is the one nearer to the last, so that what
        lies between two communication points is between them.
        """
        values = self.factors * values
        angles, rates = values[:3], values[3:]

        if self.makes_rates:
            return _omega(self.kind, angles, rates)

        E = _rotation(self.kind, angles).as_quat()
        return -E if E @ before < 0.0 else E

    @property
    def makes_rates(self) -> bool:
        """Whether it makes an angular velocity."""
        return self.kind.endswith("_rates")


def takes(kind: str) -> tuple[list[Measure], str]:
    """(units of what it takes, these in words)."""
    rad, rate = known("rad"), known("rad/s")
    assert rad and rate

    if kind.endswith("_rates"):
        return [rad] * 3 + [rate] * 3, "3 angles and their 3 rates"

    return [rad] * 3, "3 angles"


def makes(kind: str) -> tuple[Measure, int, str]:
    """(unit of what it makes, how many of these, in words)."""
    if kind.endswith("_rates"):
        unit, size, words = known("rad/s"), 3, "3 components of an angular velocity"
    else:
        unit, size, words = known("1"), 4, "4 Euler parameters (scalar last)"

    assert unit
    return unit, size, words


def conversion(kind: str, sources: Sequence[Signal], factors: Sequence[float]) -> Conversion:
    """A conversion, with its results as signals."""
    unit, size, _ = makes(kind)
    words = f"{kind}({', '.join(s.name for s in sources)})"
    found = Conversion(kind, tuple(sources), np.array(factors))

    for k in range(size):
        found.results.append(
            Made(
                name=f"{words}[{k + 1}]",
                variable=words,
                kind="real",
                group=sources[0].group,
                causality="output",
                variability="continuous",
                reference=-1,
                element=k,
                size=size,
                unit=unit,
                unit_name=unit.name if found.makes_rates else None,
                start=None,
                nominal=0.0,
                sources=found.sources,
            )
        )

    return found


def _rotation(kind, angles):
    kind = kind.removesuffix("_rates")
    Rotation = scipy.spatial.transform.Rotation

    if kind == ROTATION_VECTOR:
        return Rotation.from_rotvec(angles)

    return Rotation.from_euler(kind[-3:].upper(), angles)


def _omega(kind, angles, rates):
    """Angular velocity in the fixed axes, rad/s."""
    if kind.startswith(ROTATION_VECTOR):
        return _omega_of_vector(angles, rates)

    Rotation = scipy.spatial.transform.Rotation
    turn, omega = np.eye(3), np.zeros(3)

    for letter, angle, rate in zip(kind[6:9], angles, rates):
        axis = np.eye(3)["xyz".index(letter)]
        omega += rate * dot(turn, axis)
        turn = dot(turn, Rotation.from_rotvec(angle * axis).as_matrix())

    return omega


def _omega_of_vector(vector, rate):
    """Of a rotation vector that changes at a rate: w = p' + (1 - cos a)/a^2 p x p' + (a - sin a)/a^3 p x (p x p')."""
    angle = float(np.linalg.norm(vector))

    if angle < SMALL:
        first, second = 0.5 - angle**2 / 24, 1 / 6 - angle**2 / 120
    else:
        first, second = (1 - np.cos(angle)) / angle**2, (angle - np.sin(angle)) / angle**3

    across = np.cross(vector, rate)
    return rate + first * across + second * np.cross(vector, across)
