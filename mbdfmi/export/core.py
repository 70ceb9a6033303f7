"""A scene's own code: one file in C99 with all that the scene needs of the kernels, x' = f traced, and nothing else.

It allocates nothing, and no function calls itself, which is checked as it is written; with a stepper of fixed steps each call is a
bounded number of operations, but for Newton's method where loops are closed (at most `MAX_ITERATIONS` times) and iterative stages.
"""

import inspect

from ..kernels.dynamics import rates
from ..kernels.entry import ENTRIES
from ..kernels.signatures import DATA, MODEL, REALS, float64, int64
from ..trace import searches
from ..trace.graph import REAL
from ..trace.plain import plain_function
from ..trace.program import shapes
from ..trace.program.functions import Program
from ..trace.specialise import HEAD, NAME, Traced
from . import header

_SHAPES = {MODEL: shapes.View(), DATA: shapes.View(), float64: shapes.ANY_REAL, int64: shapes.ANY_INT}
_SHAPES[REALS] = shapes.Array(REAL)

PREAMBLE = """#include <math.h>
#include <stdbool.h>
#include <stdint.h>

/* bits are kept: products and sums are rounded each */
#ifdef __clang__
#pragma STDC FP_CONTRACT OFF
#endif

/* The buffers of an instance; kernels.h says what they are. */
typedef struct {
    const double *reals;
    double *state, *work, *u;
} Run;"""


def core(model, traced: Traced | None) -> str:
    """The text of the file: the entries that the wrapper calls. Raises Untraceable for what has no translation.

    traced : x' = f, or None for the kernel as it is written.
    """
    evaluate = plain_function(rates.evaluate_now)
    program = Program(model.ints, {evaluate: NAME} if traced else {})
    wanted = searches.called(program, traced.calls) if traced else []
    entries = [program.add(plain_function(kernel), _arguments(kernel)) for kernel in ENTRIES.values()]
    behind = []

    if traced:
        kernel = program.add(evaluate, [shapes.View(), shapes.View()])
        behind.append(traced.text(kernel.name))
        wanted += [kernel] if traced.guards else []

    behind += [_entry(name, function.name) for name, function in zip(ENTRIES, entries)]
    declared, functions = program.text([*wanted, *entries], "\n".join(behind))
    parts = [f"/* {model.name}: written by mbdfmi from the kernels that simulate it. */", PREAMBLE]
    parts += [declared, *([f"{HEAD};"] if traced else []), functions, *behind]
    return "\n\n".join(parts) + "\n"


def _arguments(kernel):
    return [_SHAPES[kind] for kind in kernel.signature.args]


def _entry(symbol, function):
    """An entry as the wrapper calls it."""
    others = [
        name
        for kind, name in zip(ENTRIES[symbol].signature.args, inspect.signature(ENTRIES[symbol]).parameters)
        if kind not in (MODEL, DATA)
    ]
    head = header.prototype(symbol)
    return f"""{head};

{head}
{{
    const Run run = {{m_reals, d_state, d_work, d_u}};

    (void)excinfo;
    (void)m_ints;
    (void)d_ints;
    *status = {function}({", ".join(["&run", *others])});
    return 0;
}}"""
