"""Loads of waves, water that they move, pulls of lines: what is summed or solved for is one operation.

Such an operation `solve` gives several numbers, which are nodes `found`; its value is what the kernel gives
(kernels/forces/solutions.py), in C, in Python and on tapes alike. Where derivatives are wanted each number is
the node `along` of itself and of its derivatives by what goes in, which the same kernel knows: by the
implicit function's theorem, or those of an interpolant.
"""

from collections.abc import Callable, Sequence

import numpy as np

from ..kernels.forces import solutions
from ..kernels.forces.solutions import (
    AT_PLACE,
    BESIDE,
    CATENARY,
    ELEVATION,
    FLAT,
    N_KIND,
    PULLS,
    STATION,
    STORED,
    WIDTHS,
)
from .graph import REAL, Untraceable
from .plain import plain_function
from .program.shapes import ANY_INT, Array, View
from .symbols import Symbol, node_of, symbol_of

SEVERAL = "several"
"""The kind of a node that is several numbers."""

COUNTED = (
    *("n_excitation", "n_excitation", "n_sea", "n_station"),
    *("n_line", "n_composite", "n_composite", "n_composite"),
)
"""Of each kind of kernels/forces/solutions.py, how many there are."""

IN_C = ("solutions_solve", plain_function(solutions.solve))
"""The kernel in C: name, and the Python function."""

TAKES = [View(), View(), ANY_INT, ANY_INT, Array(REAL), Array(REAL)]
"""What it takes."""

_OF_TIME = (AT_PLACE, BESIDE, ELEVATION, STATION)
"""Kinds whose first number is the time; they rest on the sea's own parameters."""

_OF_SECTIONS = ("section_mass", "section_clump", "section_length", "section_stiffness")


def gives(kind: int) -> int:
    """How many numbers a kind gives."""
    takes, found = WIDTHS[kind % N_KIND]
    return found if kind < N_KIND else found * takes


def value(m, d, about, *x) -> tuple[float, ...]:
    """The numbers of an operation on the buffers of an instance. about : (kind, element)."""
    kind, k = about
    y = np.zeros(gives(kind))
    solutions.solve(m, d, kind, k, np.array(x, float), y)
    return tuple(y.tolist())


def text_in_c(name: str, node, operands: Sequence[str]) -> list[str]:
    """Statements in C that find the numbers of an operation, as an array."""
    kind, k = node.about
    given = ", ".join(operands)
    call = f"{IN_C[0]}(run, {kind}, {k}, (const double[]){{{given}}}, {name});"
    return [f"double {name}[{gives(kind)}];", call]


def _solved(tracer, kind, k, x):
    """The numbers of element k for x, as symbols."""
    graph = tracer.graph
    nodes = tuple(node_of(tracer, each) for each in x)
    found = _numbers(tracer, kind, k, nodes)

    if tracer.slopes:
        moving = [j for j, each in enumerate(x) if isinstance(each, Symbol) and _moves(tracer, kind, j)]

        if moving:
            slopes = _numbers(tracer, N_KIND + kind, k, nodes)
            takes = len(nodes)
            found = [
                graph.node(
                    "along", (y, *_pairs(slopes, nodes, takes * i, moving)), None, REAL, graph.values[y]
                )
                for i, y in enumerate(found)
            ]

    return [symbol_of(tracer, node) for node in found]


def _pairs(slopes, nodes, row, moving):
    return (node for j in moving for node in (slopes[row + j], nodes[j]))


def _moves(tracer, kind, j):
    """Whether derivatives by what goes in at place j are wanted."""
    return tracer.by_time or j > 0 or kind not in _OF_TIME


def _numbers(tracer, kind, k, nodes):
    """Nodes of the numbers of an operation."""
    graph = tracer.graph
    about = (kind, k)

    if (known := graph.found("solve", nodes, about, SEVERAL)) is None:
        numbers = value(tracer.model, tracer.data, about, *(graph.values[node] for node in nodes))
        known = graph.node("solve", nodes, about, SEVERAL, numbers)

    return [graph.node("found", (known,), i, REAL, number) for i, number in enumerate(graph.values[known])]


def _rests_on(m, names, n):
    """By what a solution rests on there are no derivatives. n : numbers in each of these arrays."""
    if m.tracer.slopes:
        read = (getattr(m, name)[k] for name in names for k in range(n))
        m.tracer.opaque |= {each.k for each in read if isinstance(each, Symbol)}


def _of_sea(m, d, kind, k, *x):
    _rests_on(m, ["sea_value"], 4)
    return _solved(m.tracer, kind, k, x)


def _of_sections(m, d, kind, k, *x):
    first = m.composite_section[k]
    _rests_on(m, ["gravity"], 3)

    if m.tracer.slopes:
        for i in range(first, first + m.composite_sections[k]):
            read = [getattr(m, name)[i] for name in _OF_SECTIONS]
            m.tracer.opaque |= {each.k for each in read if isinstance(each, Symbol)}

        if isinstance(friction := m.composite_friction[k], Symbol):
            m.tracer.opaque.add(friction.k)

    return _solved(m.tracer, kind, k, x)


def _at_place(function):
    """`waves.at_place`."""
    return lambda m, d, k, t: tuple(_of_sea(m, d, AT_PLACE, k, t))


def _not_asked(function):
    """`waves.ready`: operations see to it."""
    return lambda m, d: None


def _beside(function):
    """`waves.sum_beside`."""
    return lambda m, d, k, t, x, y: tuple(_of_sea(m, d, BESIDE, k, t, x, y))


def _elevation(function):
    """`waves.elevation`."""
    return lambda m, d, t, x, y: _of_sea(m, d, ELEVATION, 0, t, x, y)[0]


def _by_heading(function):
    """`waves.sum_as_it_heads`."""

    def sum_as_it_heads(m, d, k):
        raise Untraceable("loads of waves that turn with the body are not traced")

    return sum_as_it_heads


def _here(function):
    """`stations.here`."""

    def here(m, d, x, y, z):
        raise Untraceable("waves that a member meets where it is are not traced")

    return here


def _when(function):
    """`stations.at_time`: the time alone."""
    return lambda m, d, t: t


def _station(function):
    """`stations.value`."""

    def value(m, d, when, n, i):
        numbers = _of_sea(m, d, STATION, n, when)
        return numbers[2 * i], numbers[2 * i + 1]

    return value


def _pull(function):
    """`catenaries.pull`."""
    names = function.__globals__

    def pull(m, d, k, x, z):
        L, EA, w = m.line_length[k], m.line_stiffness[k], names["weight"](m, k)
        limited, H, V = names["limit"](w, L, EA, m.line_bed[k], x, z)

        if limited:
            return H, V

        rest = (w, L, EA) if m.tracer.slopes else (0.0, 0.0, 0.0)
        H, V = _solved(m.tracer, CATENARY, k, (x, z, *rest))
        return H, V

    return pull


def _pulls(function):
    """`composite_lines.pulls`."""
    return lambda m, d, k, x, z: tuple(_of_sections(m, d, PULLS, k, x, z))


def _pull_of_sections(function):
    """`composite_pulls.pull`, for what is written out of it: nothing may have to be searched for then."""
    names = function.__globals__

    def pull(m, d, k, x, z):
        names["weigh"](m, d, k)

        if names["lies"](m, d, k):
            raise Untraceable("levels of a line that floats in part are searched for")

        H, V, *_ = _of_sections(m, d, PULLS, k, x, z)
        return H, V

    return pull


def _stored(function):
    """`composite_lines.stored`: with friction it is no potential of the pull, and is written out."""

    def stored(m, d, k, x, z):
        if m.tracer.slopes and _grips(m, k):
            return function(m, d, k, x, z)

        return _of_sections(m, d, STORED, k, x, z)[0]

    return stored


def _flat(function):
    """`composite_lines.flat`."""
    return lambda m, d, k, x, z: _of_sections(m, d, FLAT, k, x, z)[0]


def _dissipated(function):
    """`composite_lines.dissipated_of`, written out."""

    def dissipated_of(m, d, k):
        if not _grips(m, k):
            return 0.0

        function.__globals__["weigh"](m, d, k)
        return function(m, d, k)

    return dissipated_of


def _grips(m, k):
    """Whether friction of the bed holds composite line k."""
    return m.composite_bed[k] == 1 and m.composite_friction[k] != 0.0


REPLACED: dict[str, Callable] = {
    "forces.waves.at_place": _at_place,
    "forces.waves.sum_beside": _beside,
    "forces.waves.elevation": _elevation,
    "forces.waves.ready": _not_asked,
    "forces.waves.sum_as_it_heads": _by_heading,
    "forces.stations.here": _here,
    "forces.stations.at_time": _when,
    "forces.stations.value": _station,
    "forces.catenaries.pull": _pull,
    "forces.composite_pulls.pull": _pull_of_sections,
    "forces.composite_lines.pulls": _pulls,
    "forces.composite_lines.stored": _stored,
    "forces.composite_lines.flat": _flat,
    "forces.composite_lines.dissipated_of": _dissipated,
}
"""Kernels in whose places these operations are."""
