"""A graph in C99: straight-line code.

Compiled without contraction of products and sums, and with the same mathematics library, it computes the
bits that the kernels compute.
"""

import math

from .graph import BOOL, INT, REAL
from .write import Language

FLAGS = ("-std=c99", "-O3", "-ffp-contract=off", "-fno-math-errno")
"""What a compiler is told, so that the bits are those of the kernels."""


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
        "whole": "(int32_t)",
        "not": "!",
    },
    number=number,
    select="({0} ? {1} : {2})",
    statement="const {kind} {name} = {value};",
    kinds={REAL: "double", INT: "int32_t", BOOL: "int"},
)
