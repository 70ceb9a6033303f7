"""The variables of an FMU as scalars, whatever the version of FMI: names, types, where they are found."""

from __future__ import annotations

import ctypes
import math
from dataclasses import dataclass, field
from typing import Any

from ..compiler.variables import subscripts
from .measures import Measure, measure, of_description

# type of a variable -> (what is said of it, group of calls, type in C)
TYPES = {
    2: {
        "Real": ("real", "Real", ctypes.c_double),
        "Integer": ("integer", "Integer", ctypes.c_int),
        "Enumeration": ("enumeration", "Integer", ctypes.c_int),
        "Boolean": ("boolean", "Boolean", ctypes.c_int),
        "String": ("string", "String", ctypes.c_char_p),
    },
    3: {
        "Float64": ("real", "Float64", ctypes.c_double),
        "Float32": ("real", "Float32", ctypes.c_float),
        "Boolean": ("boolean", "Boolean", ctypes.c_bool),
        "String": ("string", "String", ctypes.c_char_p),
        "Enumeration": ("enumeration", "Int64", ctypes.c_int64),
    }
    | {
        f"{sign}Int{size}": ("integer", f"{sign}Int{size}", getattr(ctypes, f"c_{sign.lower()}int{size}"))
        for sign in ("", "U")
        for size in (8, 16, 32, 64)
    },
}

REAL_GROUPS = ("Real", "Float64")
"""Calls whose values are doubles: signals that are followed within a step."""


@dataclass(frozen=True, eq=False)
class Signal:
    """A scalar variable, or an element of an array variable.

    kind : "real", "integer", "enumeration", "boolean" or "string"; group : the calls that set and get it.
    variable : name of the variable; element : its place in it; size : the number of its elements.
    items : of an enumeration: its values by name. initial : as FMI has it.
    """

    name: str
    variable: str
    kind: str
    group: str
    causality: str
    variability: str
    reference: int
    element: int
    size: int
    unit: Measure | None
    unit_name: str | None
    start: Any
    nominal: float
    items: dict[str, int] = field(default_factory=dict)
    initial: str | None = None

    @property
    def is_real(self) -> bool:
        """Whether it is a double, which is followed within a step."""
        return self.group in REAL_GROUPS


@dataclass
class Structure:
    """Which inputs an output depends on at once, by names of scalars: None where that is not told (perhaps all)."""

    during: dict[str, tuple[str, ...] | None]
    at_start: dict[str, tuple[str, ...] | None]


def version_of(description) -> int:
    """2 or 3."""
    return int(str(description.fmiVersion).split(".")[0])


def signals_of(description) -> dict[str, Signal]:
    """All scalars of a description by name: elements of arrays are `name[1]`, `name[1,2]`."""
    types, units = TYPES[version_of(description)], of_description(description)
    found = {}

    for variable in description.modelVariables:
        if variable.type not in types:
            continue

        shape = tuple(variable.shape or ())
        size = math.prod(shape)
        starts = _starts(variable, size)

        for k, ending in enumerate(subscripts(shape)):
            name = variable.name + ending
            found[name] = _signal(name, variable, types, units, k, size, starts[k])

    return found


def _signal(name, variable, types, units, element, size, start):
    kind, group, _ = types[variable.type]
    declared = variable.declaredType
    unit = variable.unit or (declared.unit if declared else None)
    items = {item.name: int(item.value) for item in declared.items} if declared else {}
    nominal = variable.nominal or (declared.nominal if declared else None)
    return Signal(
        name,
        variable.name,
        kind,
        group,
        variable.causality or "local",
        variable.variability or "continuous",
        variable.valueReference,
        element,
        size,
        measure(unit, units) if kind == "real" else None,
        unit,
        start,
        abs(float(nominal)) if nominal else 0.0,
        items,
        variable.initial,
    )


def _starts(variable, size):
    """Start values of a variable's elements as texts, None where there is none."""
    text = variable.start
    if text is None:
        return [None] * size
    if variable.type == "String" or (size == 1 and not variable.shape):
        return [text] * size

    parts = str(text).split() if not isinstance(text, (list, tuple)) else list(text)
    return parts * size if len(parts) == 1 else (parts + [None] * size)[:size]


def structure_of(description, signals: dict[str, Signal]) -> Structure:
    """What outputs depend on, of the description's ModelStructure."""
    elements: dict[str, list[str]] = {}

    for signal in signals.values():
        elements.setdefault(signal.variable, []).append(signal.name)

    inputs = {v.name for v in description.modelVariables if v.causality == "input"}

    def read(unknowns):
        found = {}

        for unknown in unknowns:
            told = unknown.dependencies
            names = (
                None
                if told is None
                else tuple(
                    e for v in told if v is not None and v.name in inputs for e in elements.get(v.name, ())
                )
            )
            for element in elements.get(unknown.variable.name, ()) if unknown.variable else ():
                found[element] = names

        return found

    during = read(description.outputs)
    # what is not listed at the start depends as it does later
    return Structure(during, during | read(description.initialUnknowns))


@dataclass(frozen=True)
class Capabilities:
    """What an FMU says that it can do, of what a master may use; fields are the words that it is told in."""

    variable_steps: bool
    rollback: bool
    input_derivatives: bool
    directional_derivatives: bool
    event_mode: bool

    def words(self) -> list[str]:
        """Those that it has."""
        return [name.replace("_", " ") for name, has in vars(self).items() if has]


def capabilities(description) -> Capabilities:
    """What the description says."""
    told = description.coSimulation
    two = version_of(description) == 2
    return Capabilities(
        bool(told.canHandleVariableCommunicationStepSize),
        bool(told.canGetAndSetFMUstate),
        bool(two and told.canInterpolateInputs),
        bool(told.providesDirectionalDerivative),
        bool(not two and told.hasEventMode),
    )
