"""A scene's own code: one file in C99 with all that the scene needs of the kernels, x' = f traced, and nothing else.

It allocates nothing, and no function calls itself, which is checked as it is written; with a stepper of fixed steps each call is a
bounded number of operations, but for Newton's method where loops are closed (at most `MAX_ITERATIONS` times) and iterative stages.
"""

import inspect
import itertools
from collections.abc import Sequence

from ..kernels.entry import ENTRIES
from ..kernels.signatures import DATA, MODEL, REALS, float64, int64
from ..trace import searches
from ..trace.graph import REAL
from ..trace.once import FORGOTTEN, forgetting
from ..trace.places import SELDOM
from ..trace.plain import plain_function
from ..trace.program import shapes
from ..trace.program.functions import RUN, Program
from ..trace.program.layout_c import words
from ..trace.specialise import Traced
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
    double *once; /* what follows from parameters alone */
} Run;"""


def core(model, traced: Sequence[Traced] = ()) -> str:
    """The text of the file: the entries that the wrapper calls. Raises Untraceable for what has no translation.

    traced : kernels that their traces stand for; those that the scene calls are written.
    """
    keeps = any(each.once[1] for each in traced)
    forgets = dict.fromkeys(SELDOM, f"{FORGOTTEN}({RUN});") if keeps else {}
    program = Program(model.ints, {each.kernel: each.name for each in traced}, forgets)
    # under the names that traces call them by, before kernels do
    searches.called(program, searches.FUNCTIONS_OF)
    entries = [program.add(plain_function(kernel), _arguments(kernel)) for kernel in ENTRIES.values()]
    names = {kernel: program.replaced.get(plain_function(kernel)) for kernel in ENTRIES.values()}
    called = [names[kernel] or function.name for kernel, function in zip(ENTRIES.values(), entries)]
    found = _used(program, traced, entries, called)
    places = [0, *itertools.accumulate(each.once[1] for each in found)]
    ends = [_entry(symbol, name, places[-1]) for symbol, name in zip(ENTRIES, called)]
    texts = [_written(program, each, place) for each, place in zip(found, places)]
    others = searches.called(program, set().union(*(each.calls for each in found)))
    behind = [*texts, *ends]
    wanted = [
        *others,
        *(one for each in found for one in _needed(program, each)),
        *_not_replaced(program, entries),
    ]
    declared, functions = program.text(wanted, "\n".join(behind))
    parts = [f"/* {model.name}: written by mbdfmi from the kernels that simulate it. */", PREAMBLE]
    parts += [forgetting(place for each, place in zip(found, places) if each.once[1])] if keeps else []
    parts += [declared, *(f"{each.head};" for each in found), functions, *behind]
    return "\n\n".join(part for part in parts if part) + "\n"


def _not_replaced(program, functions):
    return [function for function in functions if function.python not in program.replaced]


def _used(program, traced, entries, called):
    """Of what is traced what the scene calls, also what stands for what is left to a kernel."""
    ends = " ".join(called)
    wanted = _not_replaced(program, entries)
    found: list[Traced] = []

    while True:
        told = words("\n".join([*program.text(wanted), ends]))
        more = [each for each in traced if each.name in told and each not in found]

        if not more:
            return found

        found += more
        wanted += [one for each in more for one in _needed(program, each)]


def _needed(program, traced):
    """Kernels that a traced one calls: what it leaves to them, and what comes first."""
    return [program.add(kernel, _shapes_of(traced, kernel)) for kernel in _calls_of(traced)]


def _calls_of(traced):
    return ([traced.kernel] if traced.guards else []) + ([traced.before] if traced.before else [])


def _shapes_of(traced, kernel):
    views = [shapes.View(), shapes.View()]
    others = [shapes.Array(REAL) if kind.endswith("*") else shapes.ANY_INT for kind, _ in traced.more]
    return views + (others if kernel is traced.kernel else [])


def _written(program, traced, place):
    """A traced function in C. place : of its own in `once`."""
    names = {kernel: program.add(kernel, _shapes_of(traced, kernel)).name for kernel in _calls_of(traced)}
    before = f"{names[traced.before]}(run)" if traced.before else ""
    return traced.text(names.get(traced.kernel, ""), before, place)


def _arguments(kernel):
    return [_SHAPES[kind] for kind in kernel.signature.args]


def _entry(symbol, function, places):
    """An entry as the wrapper calls it. places : in `once`."""
    others = [
        name
        for kind, name in zip(ENTRIES[symbol].signature.args, inspect.signature(ENTRIES[symbol]).parameters)
        if kind not in (MODEL, DATA)
    ]
    head = header.prototype(symbol)
    once = f"    double once[{places}] = {{0.0}};\n" if places else ""
    return f"""{head};

{head}
{{
{once}    const Run run = {{m_reals, d_state, d_work, d_u, {"once" if places else "0"}}};

    (void)excinfo;
    (void)m_ints;
    (void)d_ints;
    *status = {function}({", ".join(["&run", *others])});
    return 0;
}}"""
