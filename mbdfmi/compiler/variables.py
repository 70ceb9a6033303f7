"""The variables that an FMU, or a result table, shows: names, units, meanings, dependencies."""

import re
from collections.abc import Collection, Iterable
from dataclasses import dataclass

import numpy as np

from ..scene import fmi_name
from ..scene.errors import nearest

KINDS = ("input", "output", "fixed", "tunable")
"""What a value reference is, as numbers in an FMU: its causality; of a parameter its variability."""

TABLE = np.dtype([("kind", "<i8"), ("index", "<i8")])
"""A row of the table of value references in an FMU."""


@dataclass(frozen=True)
class Variable:
    """A scalar variable. Its FMI value reference is its position in `Model.variables`.

    name : structured FMI name, indices 1-based.
    causality : "input", "output" or "parameter".
    variability : "continuous"; parameters: "tunable" at any time, or "fixed" after initialisation.
    start : value at the start; None for outputs.
    unit : key of `units.UNITS`, None without unit.
    index : position in the buffer `u`, `y` or `reals`.
    depends : of an output: value references of the inputs that act on it at the same instant; at the start all parameters do too.
    """

    name: str
    causality: str
    variability: str
    start: float | None
    unit: str | None
    description: str
    index: int
    depends: tuple[int, ...] = ()

    @property
    def row(self) -> tuple[int, int]:
        """Its row of TABLE."""
        return KINDS.index(self.variability if self.causality == "parameter" else self.causality), self.index


def dotted(*names: str) -> str:
    """A structured name from free-text parts: each an identifier or quoted."""
    return ".".join(fmi_name(name) for name in names)


def subscripts(shape: tuple[int, ...]) -> list[str]:
    """Names' endings for an array, by rows: [""], ["[1]", ...] or ["[1,1]", ...]."""
    if not shape:
        return [""]

    if len(shape) == 1:
        return [f"[{k + 1}]" for k in range(shape[0])]

    return [f"[{j + 1},{k + 1}]" for j in range(shape[0]) for k in range(shape[1])]


def array_of(name: str) -> str:
    """The name of the array that a variable is an element of, or its own."""
    return re.sub(r"\[\d+(,\d+)*\]$", "", name)


def meant(name: str, names: Iterable[str]) -> list[str]:
    """Those of the variables' names that a name means: itself, or all elements of an array without index; [] for none."""
    names = list(names)
    return [name] if name in names else [element for element in names if array_of(element) == name]


def hint(name: str, names: Collection[str], limit: int = 12) -> str:
    """What to say of a name that is none of these: which it may be, else some of those there are."""
    if near := nearest(name, [*dict.fromkeys(map(array_of, names)), *names]):
        return "did you mean " + " or ".join(map(repr, near)) + "?"

    names = list(names)
    some = ", ".join(list(names)[:limit]) or "none"
    return f"there are {some}" + (f" and {len(names) - limit} more" if len(names) > limit else "")
