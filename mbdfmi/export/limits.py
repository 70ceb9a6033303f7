"""Between which values a variable is, where that is sure: what the scene's own checks ask of parameters, and what outputs cannot leave."""

import bisect
import math
import re
from collections.abc import Iterable
from typing import NamedTuple

from ..compiler.variables import Variable
from ..kernels import layout
from ..kernels.prepare import LARGEST_TOLERANCE, LEAST_TOLERANCE


class Limits(NamedTuple):
    """The least and the largest value; None where there is none."""

    least: float | None = None
    largest: float | None = None


NONE = Limits()
NOT_NEGATIVE = Limits(0.0)

_PARAMETERS = {
    "tolerance": Limits(LEAST_TOLERANCE, LARGEST_TOLERANCE),
    "absolute_tolerance": Limits(LEAST_TOLERANCE, LARGEST_TOLERANCE),
    "max_evaluations": Limits(1.0),
    **dict.fromkeys(
        (
            *("step", "closing_tolerance", "solid_mass", "central_mu", "rotor_inertia"),
            *("joint_stiffness", "joint_damping", "strut_stiffness", "strut_damping"),
            *("friction_coulomb", "friction_static", "friction_stribeck", "friction_viscous"),
            *("friction_smoothing", "stop_stiffness", "stop_damping"),
        ),
        NOT_NEGATIVE,
    ),
}
"""By their array in kernels/layout.py."""

_MOMENTS = 3
"""Of the six numbers of an inertia: those on the diagonal, which come first."""

_OUTPUTS = dict.fromkeys(
    (
        "distance",
        "length",
        "kinetic_energy",
        "constraint_gap",
        "constraint_rate",
        "steps",
        "rejected_steps",
        "evaluations",
        "estimated_error",
    ),
    NOT_NEGATIVE,
)
"""By their last word; those of rotations below."""

_ZYX = {
    "zyx[1]": Limits(-math.pi, math.pi),
    "zyx[2]": Limits(-math.pi / 2, math.pi / 2),
    "zyx[3]": Limits(-math.pi, math.pi),
}


def limits_of(model) -> list[Limits]:
    """Of each of the variables of an FMU, by value reference."""
    arrays = _Arrays(model)
    return [
        _of_parameter(arrays, v) if v.causality == "parameter" else _of_output(model, v) for v in model.listed
    ]


def widest(limits: Iterable[Limits]) -> Limits:
    """What holds for every element of an array."""
    low, high = zip(*limits)
    return Limits(None if None in low else min(low), None if None in high else max(high))


class _Arrays:
    """Which array a place in `reals` belongs to."""

    def __init__(self, model):
        rows = [row for row in layout.ARRAYS if row.buffer == "reals"]
        counts = {name: getattr(model, name) for name in layout.COUNTS}
        lengths = {row.name: layout.array_length(row, counts) for row in rows}
        found = sorted((int(model.ints[layout.SLOT[r.name]]), r.name) for r in rows if lengths[r.name])
        self.first = [first for first, _ in found]
        self.names = [name for _, name in found]

    def at(self, index: int) -> tuple[str, int]:
        """Its name, and the place in it."""
        k = bisect.bisect_right(self.first, index) - 1
        return self.names[k], index - self.first[k]


def _of_parameter(arrays, variable: Variable) -> Limits:
    name, at = arrays.at(variable.index)

    limits = _PARAMETERS.get(name, NONE)

    if name == "solid_inertia" and at % layout.ARRAY[name].width < _MOMENTS:
        limits = NOT_NEGATIVE

    # moments of inertia may be negative by rounding
    negative = limits.least is not None and variable.start is not None and variable.start < limits.least
    return NONE if negative else limits


def _of_output(model, variable: Variable) -> Limits:
    if variable.causality != "output":
        return NONE

    word = re.split(r"\.(?=[^.']*$)", variable.name)[-1]

    if word == "kinetic_energy" and model.n_six_by_six:
        return NONE  # nothing is asked of an added mass

    return _ZYX.get(word) or _OUTPUTS.get(word, NONE)
