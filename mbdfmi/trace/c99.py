"""A graph in C99: straight-line code.

Compiled without contraction of products and sums, and with the same mathematics library, it computes the
bits that the kernels compute.
"""

import math
from collections.abc import Iterable

from . import searches
from .graph import BOOL, INT, REAL
from .translate import c_function
from .write import Language

FLAGS = ("-std=c99", "-O3", "-ffp-contract=off", "-fno-math-errno")
"""What a compiler is told, so that the bits are those of the kernels."""

_EXTREMES = {
    "minimum": "static double minimum(double a, double b)\n{\n    return b < a ? b : a;\n}",
    "maximum": "static double maximum(double a, double b)\n{\n    return b > a ? b : a;\n}",
}


def number(value) -> str:
    """A number in C, to the last bit."""
    if isinstance(value, bool):
        return str(int(value))

    if isinstance(value, int):
        return str(value)

    if math.isinf(value):
        return "INFINITY" if value > 0 else "-INFINITY"

    return "NAN" if math.isnan(value) else repr(value)


C99 = Language(
    calls={
        "abs": "fabs",
        "min": "minimum",
        "max": "maximum",
        "real": "(double)",
        "whole": "(int64_t)",
        "not": "!",
    },
    number=number,
    select="({0} ? {1} : {2})",
    statement="const {kind} {name} = {value};",
    kinds={REAL: "double", INT: "int64_t", BOOL: "int"},
)


def helpers(calls: Iterable[str]) -> list[str]:
    """Static functions in C that those called need."""
    needs = {name for call in calls for name in (_NEEDS.get(call, (call,)))}
    texts = [text for name, text in _EXTREMES.items() if name in needs]
    return texts + [
        c_function(function, name, parameters)
        for name, (function, parameters) in searches.FUNCTIONS.items()
        if name in needs
    ]


_NEEDS = {"interval": ("left_knot",), "eccentric_anomaly": ("eccentric_anomaly", "minimum")}
