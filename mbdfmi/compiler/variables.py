"""The variables that an FMU, or a result table, shows: names, units, meanings, dependencies."""

import itertools
import re
from collections.abc import Collection, Iterable
from dataclasses import dataclass, field

import numpy as np

from ..scene import fmi_name
from ..scene.errors import nearest

KINDS = ("input", "output", "fixed", "tunable", "state", "rate", "indicator", "constant", "local")
"""What a value reference is, as numbers in an FMU: its causality; of a parameter its variability."""

TABLE = np.dtype([("kind", "<i8"), ("index", "<i8"), ("length", "<i8")])
"""A row of the table of value references in an FMU: `length` is that of the array whose first element it is (1 for a
scalar), 0 for its other elements."""


@dataclass(frozen=True)
class Variable:
    """A scalar variable. Its FMI value reference is its position in `Model.variables`.

    name : structured FMI name, indices 1-based.
    causality : "input", "output", "parameter", or "constant", a parameter that is bound; of what model exchange adds "state", "rate" or "indicator"; "local" of what is told beside them.
    variability : "continuous"; parameters: "tunable" at any time, or "fixed" after initialisation; "constant".
    start : value at the start; None for outputs.
    unit : key of `units.UNITS`, None without unit.
    index : position in the buffer `u`, `y` or `reals`, in x or x', among the indicators.
    depends : of an output: value references of the inputs that act on it at the same instant; at the start all parameters do too.
    led_by : of an output: value references of the states that it may depend on; many, the same for many outputs, and left out
    of `repr`, which the GUID is made of.
    """

    name: str
    causality: str
    variability: str
    start: float | None
    unit: str | None
    description: str
    index: int
    depends: tuple[int, ...] = ()
    led_by: tuple[int, ...] = field(default=(), repr=False)

    @property
    def kind(self) -> int:
        """Its place in KINDS."""
        return KINDS.index(self.variability if self.causality == "parameter" else self.causality)


@dataclass(frozen=True)
class ArrayVariable:
    """Variables that make an array, by rows, or a scalar one.

    name : without indices.
    first : value reference of its first element.
    shape : () for a scalar.
    elements : its variables.
    """

    name: str
    first: int
    shape: tuple[int, ...]
    elements: tuple[Variable, ...]


def arrays(variables: list[Variable]) -> list[ArrayVariable]:
    """The variables as arrays, in their order: elements that follow each other, by rows, and fill the array."""
    names = {v.name for v in variables}
    found = []

    for name, group in itertools.groupby(variables, lambda v: array_of(v.name)):
        elements = tuple(group)
        shape = _shape(elements[-1].name)
        alike = len({(v.causality, v.variability) for v in elements}) == 1
        whole = [v.name for v in elements] == [_element(name, k) for k in subscripts(shape)]
        first = found[-1].first + len(found[-1].elements) if found else 0

        if alike and whole and (name == elements[0].name or name not in names):
            found.append(ArrayVariable(name, first, shape, elements))
        else:
            found += [ArrayVariable(v.name, first + k, (), (v,)) for k, v in enumerate(elements)]

    return found


def _shape(name: str) -> tuple[int, ...]:
    """The shape of the array whose last element has this name."""
    last = re.search(_INDICES, name)
    return tuple(map(int, last[1].split(","))) if last else ()


def _element(array: str, indices: str) -> str:
    """The name of an element of an array; that of a rate is der(x[1])."""
    return f"{array[:-1]}{indices})" if array.startswith("der(") else array + indices


def reference_table(variables: list[Variable]) -> np.ndarray:
    """The table of value references, rows of TABLE."""
    rows = np.array([(v.kind, v.index, 0) for v in variables], TABLE)

    for array in arrays(variables):
        rows["length"][array.first] = len(array.elements)

    return rows


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


_INDICES = r"\[(\d+(?:,\d+)*)\](\)?)$"


def array_of(name: str) -> str:
    """The name of the array that a variable is an element of, or its own."""
    return re.sub(_INDICES, r"\2", name)


def meant(name: str, names: Iterable[str]) -> list[str]:
    """Those of the variables' names that a name means: itself, or all elements of an array without index; [] for none."""
    names = list(names)
    return [name] if name in names else [element for element in names if array_of(element) == name]


WORDS = (
    ("velocity", "speed", "omega", "rate"),
    ("angle", "position"),
    ("torque", "force", "moment", "effort"),
    ("acceleration", "alpha"),
)
"""Words of one meaning, each of which a joint of some kind has its own of."""


def _by_another_word(name, names):
    """Names of the same thing's quantities that another word of the same meaning names."""
    stem, dot, word = array_of(name).rpartition(".")
    alike = [
        f"{stem}.{other}" for words in WORDS if word in words for other in words if dot and other != word
    ]
    return [other for other in alike if other in names]


def hint(name: str, names: Collection[str], limit: int = 12) -> str:
    """What to say of a name that is none of these: which it may be, else some of those there are."""
    known = [*dict.fromkeys(map(array_of, names)), *names]

    if near := _by_another_word(name, known) or nearest(name, known):
        return "did you mean " + " or ".join(map(repr, near)) + "?"

    names = list(names)
    some = ", ".join(list(names)[:limit]) or "none"
    return f"there are {some}" + (f" and {len(names) - limit} more" if len(names) > limit else "")
