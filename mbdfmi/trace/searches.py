"""Loops that end by values: each is one operation of the graph.

A graph has no loops, and how often such a one turns is no matter of structure. So it is called: in C it is
the kernel itself, translated by `program`, in Python the kernel.
"""

from collections.abc import Iterable

from ..kernels.math import tables
from ..kernels.motion import ellipses
from . import solutions
from .graph import INT, REAL, Untraceable
from .plain import plain_function
from .program.functions import Function, Program
from .program.shapes import ANY_INT, ANY_REAL, Array
from .symbols import Symbol, node_of, symbol_of

FUNCTIONS: dict[str, tuple] = {
    "left_knot": (plain_function(tables.left_knot), [Array(REAL), ANY_INT, ANY_INT, ANY_REAL]),
    "eccentric_anomaly": (plain_function(ellipses.eccentric_anomaly), [ANY_REAL, ANY_REAL]),
    solutions.IN_C[0]: (solutions.IN_C[1], solutions.TAKES),
}
"""The kernels that are such loops, by name, and what they take."""

_CALLED_BY = {
    "interval": "left_knot",
    "eccentric_anomaly": "eccentric_anomaly",
    "solve": solutions.IN_C[0],
}

FUNCTIONS_OF = ("interval", "eccentric_anomaly")
"""The operations that have names of their own in C, whoever else calls the kernels."""


def called(program: Program, calls: Iterable[str]) -> list[Function]:
    """The loops that some operations are, as functions of a program in C under their names."""
    names = sorted({_CALLED_BY[call] for call in calls if call in _CALLED_BY})
    found = [(name, *FUNCTIONS[name]) for name in names]
    return [program.add(python, arguments, name) for name, python, arguments in found]


def _interval(function):
    """`tables.interval`: a node of the argument, about (where its knots stand in `reals`, how many, index of
    the first).
    """

    def interval(m, k, x):
        if not isinstance(x, Symbol):
            return function(m, k, x)

        graph = x.graph
        first = m.table_knot[k]
        about = (m.knot_x.first + first, m.table_knots[k], first)
        return symbol_of(
            x.tracer, graph.node("interval", (x.k,), about, INT, function(m, k, graph.values[x.k]))
        )

    return interval


def _eccentric_anomaly(function):
    """`ellipses.eccentric_anomaly`: a node of the mean anomaly and the eccentricity."""

    def eccentric_anomaly(M, e):
        tracer = next((value.tracer for value in (M, e) if isinstance(value, Symbol)), None)

        if tracer is None:
            return function(M, e)

        args = (node_of(tracer, M), node_of(tracer, e))
        value = function(*(tracer.graph.values[k] for k in args))
        return symbol_of(tracer, tracer.graph.node("eccentric_anomaly", args, None, REAL, value))

    return eccentric_anomaly


def _kept_waves(function):
    """`waves.ready`."""

    def ready(m, d):
        raise Untraceable("sums over the waves of a sea are no equations to be read")

    return ready


def _unknown(function):
    """`catenaries.is_known`, `composite_pulls.is_known`: what scratch holds is no part of a graph."""
    return lambda *args: False


def _forgotten(function):
    """`catenaries.know`."""
    return lambda *args: None


def _from_cold(function):
    """`catenaries.nearby`: the guess of a line that nothing is known of."""

    def nearby(m, d, k, w, L, EA, bed, x, z):
        return function.__globals__["first_guess"](L, w, x, z)

    return nearby


def _guessed(function):
    """`composite_pulls.nearby`, likewise."""

    def nearby(m, d, k, x, z):
        return function.__globals__["guess"](m, d, k, x, z)

    return nearby


def _interval_at(buffers, about, x):
    first, knots, at = about
    return at + plain_function(tables.left_knot)(buffers["reals"], first, knots, x) - first


def _eccentric_anomaly_at(buffers, about, M, e):
    return plain_function(ellipses.eccentric_anomaly)(M, e)


def _solved_at(buffers, about, *x):
    return solutions.value(buffers["m"], buffers["d"], about, *x)


VALUES = {"interval": _interval_at, "eccentric_anomaly": _eccentric_anomaly_at, "solve": _solved_at}
"""Operation -> its value for the buffers of a model, what it is about, and its operands."""

REPLACED = {
    "math.tables.interval": _interval,
    "motion.ellipses.eccentric_anomaly": _eccentric_anomaly,
}
"""Kernels that call them, and what takes their places."""

WRITTEN_OUT = {
    "forces.waves.ready": _kept_waves,
    "forces.catenaries.is_known": _unknown,
    "forces.catenaries.know": _forgotten,
    "forces.catenaries.nearby": _from_cold,
    "forces.composite_pulls.is_known": _unknown,
    "forces.composite_pulls.nearby": _guessed,
}
"""Likewise of those that look at what an evaluation before left in scratch, where no operation stands for
them (`solutions`): equations to be read have nothing to call."""
