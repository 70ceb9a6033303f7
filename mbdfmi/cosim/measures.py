"""Units of variables, as FMUs define them: compared, and values converted from one into another."""

import math
import re
from typing import NamedTuple

from ..units import UNITS

BASES = ("kg", "m", "s", "A", "K", "mol", "cd", "rad")


class Measure(NamedTuple):
    """A unit: a value in SI base units is `factor` times the value in it, plus `offset`."""

    name: str
    exponents: tuple[int, ...]
    factor: float = 1.0
    offset: float = 0.0

    def fits(self, other: "Measure") -> bool:
        """Whether both measure one kind of quantity; radians count as numbers."""
        return self.exponents[:-1] == other.exponents[:-1]


def of_description(description) -> dict[str, Measure]:
    """The units of a model description by name: those with base units, and well-known names of those without."""
    found = {}

    for unit in description.unitDefinitions:
        if unit.baseUnit is not None:
            exponents = tuple(int(getattr(unit.baseUnit, base)) for base in BASES)
            numbers = float(unit.baseUnit.factor), float(unit.baseUnit.offset)
            found[unit.name] = Measure(unit.name, exponents, *numbers)

    return found


def measure(name: str | None, defined: dict[str, Measure]) -> Measure | None:
    """The unit of a name: as the FMU defines it, else as it is commonly known; None where nobody knows."""
    if not name:
        return None

    return defined.get(name) or known(name)


def known(name: str) -> Measure | None:
    """A unit by a common name, `N.m`, `deg/s`, `km/h`, `kN`; None for others."""
    name = SPELT.get(name, name)

    if name in UNITS:
        unit = UNITS[name]
        return Measure(name, (unit.kg, unit.m, unit.s, 0, 0, 0, 0, unit.rad))

    for unit in UNITS.values():
        for display, factor in unit.display:
            if display == name:
                return Measure(name, (unit.kg, unit.m, unit.s, 0, 0, 0, 0, unit.rad), 1 / factor)

    return _product(name)


SPELT = {"Nm": "N.m", "N*m": "N.m", "Nms/rad": "N.m.s/rad", "r/min": "rpm", "1/min": "rpm", "°": "deg"}
SPELT |= {"degC": "degC", "°C": "degC", "ms-1": "m/s", "m/s^2": "m/s2", "kg*m2": "kg.m2", "-": "1"}

#             kg m  s  A  K mol cd rad
ATOMS = {
    "1": (0, 0, 0, 0, 0, 0, 0, 0, 1.0),
    "g": (1, 0, 0, 0, 0, 0, 0, 0, 1e-3),
    "t": (1, 0, 0, 0, 0, 0, 0, 0, 1e3),
    "m": (0, 1, 0, 0, 0, 0, 0, 0, 1.0),
    "s": (0, 0, 1, 0, 0, 0, 0, 0, 1.0),
    "min": (0, 0, 1, 0, 0, 0, 0, 0, 60.0),
    "h": (0, 0, 1, 0, 0, 0, 0, 0, 3600.0),
    "A": (0, 0, 0, 1, 0, 0, 0, 0, 1.0),
    "K": (0, 0, 0, 0, 1, 0, 0, 0, 1.0),
    "mol": (0, 0, 0, 0, 0, 1, 0, 0, 1.0),
    "cd": (0, 0, 0, 0, 0, 0, 1, 0, 1.0),
    "rad": (0, 0, 0, 0, 0, 0, 0, 1, 1.0),
    "deg": (0, 0, 0, 0, 0, 0, 0, 1, math.pi / 180),
    "rev": (0, 0, 0, 0, 0, 0, 0, 1, 2 * math.pi),
    "Hz": (0, 0, -1, 0, 0, 0, 0, 0, 1.0),
    "N": (1, 1, -2, 0, 0, 0, 0, 0, 1.0),
    "Pa": (1, -1, -2, 0, 0, 0, 0, 0, 1.0),
    "bar": (1, -1, -2, 0, 0, 0, 0, 0, 1e5),
    "J": (1, 2, -2, 0, 0, 0, 0, 0, 1.0),
    "W": (1, 2, -3, 0, 0, 0, 0, 0, 1.0),
    "V": (1, 2, -3, -1, 0, 0, 0, 0, 1.0),
    "C": (0, 0, 1, 1, 0, 0, 0, 0, 1.0),
    "Ohm": (1, 2, -3, -2, 0, 0, 0, 0, 1.0),
    "F": (-1, -2, 4, 2, 0, 0, 0, 0, 1.0),
    "H": (1, 2, -2, -2, 0, 0, 0, 0, 1.0),
    "Wb": (1, 2, -2, -1, 0, 0, 0, 0, 1.0),
    "T": (1, 0, -2, -1, 0, 0, 0, 0, 1.0),
    "l": (0, 3, 0, 0, 0, 0, 0, 0, 1e-3),
}
PREFIXES = {"G": 1e9, "M": 1e6, "k": 1e3, "c": 1e-2, "m": 1e-3, "u": 1e-6, "n": 1e-9}


def _product(name):
    """A unit as Modelica writes it: `.` multiplies, `/` divides by all that follows, a number is a power."""
    if name in ("degC", "celsius"):
        return Measure(name, (0, 0, 0, 0, 1, 0, 0, 0), 1.0, 273.15)

    above, _, below = name.partition("/")
    exponents, factor = [0] * len(BASES), 1.0

    for text, sign in ((above, 1), (below, -1)):
        for part in filter(None, re.split(r"[.*()]+", text)):
            found = re.fullmatch(r"([A-Za-z]+|1)\^?(-?\d*)", part)
            atom = _atom(found[1]) if found else None

            if found is None or atom is None:
                return None

            power = sign * int(found[2] or 1)
            factor *= atom[-1] ** power
            exponents = [e + power * a for e, a in zip(exponents, atom)]

    return Measure(name, tuple(exponents), factor)


def _atom(name):
    if name in ATOMS:
        return ATOMS[name]

    if name[1:] in ATOMS and name[0] in PREFIXES:
        atom = ATOMS[name[1:]]
        return (*atom[:-1], atom[-1] * PREFIXES[name[0]])

    return None


def conversion(source: Measure, target: Measure) -> tuple[float, float]:
    """(factor, offset) that make a value in the target's unit of one in the source's."""
    return source.factor / target.factor, (source.offset - target.offset) / target.factor
