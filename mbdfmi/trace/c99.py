"""A graph in C99: straight-line code, one constant for each operation.

Compiled without contraction of products and sums, and with the same mathematics library, it computes the
bits that the kernels compute.
"""

import math
from collections.abc import Iterable, Mapping

from . import searches
from .graph import BOOL, INT, Graph, Untraceable
from .translate import c_function

FLAGS = ("-std=c99", "-O3", "-ffp-contract=off", "-fno-math-errno")
"""What a compiler is told, so that the bits are those of the kernels."""

_TYPES = {BOOL: "int", INT: "int64_t"}
_INFIX = ("+", "-", "*", "/", "<", "<=", "==", "!=")
_CALLS = {"abs": "fabs", "min": "minimum", "max": "maximum", "isfinite": "isfinite"}
_MATH = ("sqrt", "sin", "cos", "atan2", "asin", "exp", "log", "tanh", "floor", "copysign")

_EXTREMES = {
    "minimum": "static double minimum(double a, double b)\n{\n    return b < a ? b : a;\n}",
    "maximum": "static double maximum(double a, double b)\n{\n    return b > a ? b : a;\n}",
}


def number(value) -> str:
    """A number in C, to the last bit."""
    if isinstance(value, bool):
        return str(int(value))

    if isinstance(value, int):
        return str(value) if value >= 0 else f"({value})"

    if math.isinf(value):
        return "INFINITY" if value > 0 else "(-INFINITY)"

    if math.isnan(value):
        return "NAN"

    return repr(value) if math.copysign(1.0, value) > 0 else f"({value!r})"


class Body:
    """The operations that some nodes need, as lines of C.

    leaf : name of a leaf -> how C reads it. arrays : buffer -> the name of its array, for numbers that are
    looked up.
    """

    def __init__(self, graph: Graph, wanted: Iterable[int], leaf, arrays: Mapping[str, str]):
        self.graph = graph
        self._leaf = leaf
        self._arrays = arrays
        self._text: dict[int, str] = {}
        self.lines: list[str] = []
        self.helpers: set[str] = set()

        for k in graph.needed(wanted):
            self._write(k)

    def __getitem__(self, k: int) -> str:
        """A node, as C reads it."""
        return self._text[k]

    def _write(self, k):
        node = self.graph.nodes[k]

        if node.op == "constant":
            self._text[k] = number(self.graph.values[k])
            return

        self._text[k] = name = f"t{k}"
        self.lines.append(f"const {_TYPES.get(node.kind, 'double')} {name} = {self._operation(node)};")

    def _operation(self, node):
        """An operation on its operands."""
        op = node.op

        if op == "leaf":
            return self._leaf(node.about)

        args = [self._text[k] for k in node.args]

        if op in _INFIX:
            return f"{args[0]} {op} {args[1]}"

        if op == "neg":
            return f"-{args[0]}"

        if op == "select":
            return f"{args[0]} ? {args[1]} : {args[2]}"

        if op == "real":
            return f"(double){args[0]}"

        if op == "load":
            buffer, first, _ = node.about
            return f"{self._arrays[buffer]}[{first} + {args[0]}]"

        if op == "interval":
            first, knots, at = node.about
            self.helpers.add("left_knot")
            table = f"{self._arrays['reals']} + {first}"
            return f"{at} + left_knot({table}, 0, {knots}, {args[0]})"

        if op == "eccentric_anomaly":
            self.helpers |= {op, "minimum"}
            return f"{op}({', '.join(args)})"

        if op in _CALLS or op in _MATH:
            name = _CALLS.get(op, op)
            self.helpers |= {name} & _EXTREMES.keys()
            return f"{name}({', '.join(args)})"

        raise Untraceable(f"{op} is not written in C")


def helpers(names: Iterable[str]) -> str:
    """Static functions that bodies need."""
    texts = [text for name, text in _EXTREMES.items() if name in names]
    texts += [
        c_function(function, name, parameters)
        for name, (function, parameters) in searches.FUNCTIONS.items()
        if name in names
    ]
    return "\n\n".join(texts)
