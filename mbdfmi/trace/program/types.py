"""Tuples and tables of numbers as C declares them."""

import numpy as np

from ..c99 import number as number_text
from ..graph import BOOL, INT, REAL, Untraceable
from .shapes import Array, Number, Tuple, as_value

KINDS = {REAL: "double", INT: "int32_t", BOOL: "bool"}
"""What numbers are in C. Whole numbers count, and are small: 32 bits do on any processor; but see WIDE."""

WIDE = "math.dice"
"""Where kernels multiply words of 32 bits: where one of these is called whole numbers have 64."""


def constant(value) -> str:
    """A number in C."""
    if isinstance(value, bool):
        return "true" if value else "false"

    return number_text(value)


class Types:
    """Structures and tables that a program declares, in the order in which they were met.

    structures : members -> (name, its definition and that of the function that takes a member by its number).
    tables : identity -> (name, definition, (lengths, kind, the table)).
    """

    def __init__(self):
        self.structures: dict[tuple, tuple[str, list[str]]] = {}
        self.tables: dict[int, tuple[str, str, tuple]] = {}
        self._names: set[str] = set()

    def name(self, shape) -> str:
        """The type of a shape."""
        shape = as_value(shape)

        if shape is None:
            return "void"

        if isinstance(shape, Number):
            return KINDS[shape.kind]

        if isinstance(shape, Array):
            return f"const {KINDS[shape.kind]} *"

        if isinstance(shape, Tuple):
            return self._structure(shape)[0]

        raise Untraceable(f"{shape} is nothing that C has")

    def declared(self, shape, name: str) -> str:
        """A name with its type before it."""
        kind = self.name(shape)
        return f"{kind}{'' if kind.endswith('*') else ' '}{name}"

    def at(self, shape) -> str:
        """The function that takes a member of a tuple by its number."""
        name, _ = self._structure(shape)
        return f"{name}_at"

    def _structure(self, shape):
        members = tuple(self.name(member) for member in shape.members)
        key = (shape.named, members)

        if key not in self.structures:
            name = self._free(shape.named.__name__ if shape.named else _described(members))
            fields = "".join(f"    {kind} {field};\n" for kind, field in zip(members, self.fields(shape)))
            texts = [f"typedef struct {{\n{fields}}} {name};"]

            if not shape.named and len(set(members)) == 1:
                cases = " : ".join(f"k == {k} ? tuple.e{k}" for k in range(len(members) - 1))
                last = f"tuple.e{len(members) - 1}"
                head = f"static inline {members[0]} {name}_at({name} tuple, int32_t k)"
                texts.append(f"{head}\n{{\n    return {f'{cases} : {last}' if cases else last};\n}}")

            self.structures[key] = name, texts

        return self.structures[key]

    @staticmethod
    def fields(shape) -> list[str]:
        """Names of the members of a tuple."""
        return list(shape.named._fields) if shape.named else [f"e{k}" for k in range(len(shape.members))]

    def table(self, values, name: str) -> tuple[str, tuple, str]:
        """A table of numbers that never change: (its name in C, its lengths, its kind)."""
        if id(values) not in self.tables:
            array = np.asarray(values)
            kind = INT if array.dtype.kind in "iu" else REAL
            numbers = ", ".join(constant(value) for value in array.ravel().tolist())
            chosen = self._free(name)
            text = f"static const {KINDS[kind]} {chosen}[{array.size}] = {{{numbers}}};"
            self.tables[id(values)] = chosen, text, (array.shape, kind, values)

        chosen, _, (lengths, kind, _) = self.tables[id(values)]
        return chosen, lengths, kind

    def _free(self, name):
        found = (
            name
            if name not in self._names
            else next(f"{name}_{k}" for k in range(2, 10**6) if f"{name}_{k}" not in self._names)
        )
        self._names.add(found)
        return found


def _described(members):
    """A name for a tuple of such members: real3, real3x3, or what it is made of."""
    if len(set(members)) == 1:
        kind = "real" if members[0] == "double" else members[0].removesuffix("_t")
        return f"{kind}x{len(members)}" if kind[-1].isdigit() else f"{kind}{len(members)}"

    return "tuple_" + "_".join({"double": "real", "int32_t": "whole"}.get(kind, kind) for kind in members)
