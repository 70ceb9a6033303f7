"""Exact derivatives of a graph, written onto it: forward (along directions) and reverse (of weighted sums).

Operations in common stand in the graph once, those of the values and those of the derivatives alike. One
table of partial derivatives serves both, and numbers as well.
"""

from collections.abc import Callable, Mapping, Sequence

import numpy as np

from .graph import REAL, Graph, Untraceable
from .symbols import MATH, node_of, symbol_of

CONSTANT = (
    "constant",
    "leaf",
    "floor",
    "interval",
    "load",
    "solve",
    "found",
    "real",
    "whole",
    "isfinite",
    "not",
    "<",
    "<=",
    "==",
    "!=",
)
"""Operations whose results do not change with their operands, but in jumps."""


def _quotient(y, a, b):
    inverse = 1.0 / b
    return inverse, -(y * inverse)


def _angle(y, a, b):
    inverse = 1.0 / (a * a + b * b)
    return b * inverse, -(a * inverse)


def _anomaly(y, M, e):
    inverse = 1.0 / (1.0 - e * MATH.cos(y))
    return inverse, MATH.sin(y) * inverse


def _along(y, number, *slopes_and_operands):
    """Of a number that something gives for some operands, with its derivatives by these."""
    slopes = slopes_and_operands[::2]
    return (1.0, *(each for slope in slopes for each in (0.0, slope)))


PARTIALS: dict[str, Callable] = {
    "+": lambda y, a, b: (1.0, 1.0),
    "-": lambda y, a, b: (1.0, -1.0),
    "*": lambda y, a, b: (b, a),
    "/": _quotient,
    "neg": lambda y, a: (-1.0,),
    "sqrt": lambda y, a: (0.5 / y,),
    "sin": lambda y, a: (MATH.cos(a),),
    "cos": lambda y, a: (-MATH.sin(a),),
    "atan2": _angle,
    "asin": lambda y, a: (1.0 / MATH.sqrt(1.0 - a * a),),
    "exp": lambda y, a: (y,),
    "log": lambda y, a: (1.0 / a,),
    "tanh": lambda y, a: (1.0 - y * y,),
    "asinh": lambda y, a: (1.0 / MATH.sqrt(1.0 + a * a),),
    "pow": lambda y, a, b: (y * b / a, y * MATH.log(a)),
    "eccentric_anomaly": _anomaly,
    "along": _along,
}
"""Partial derivatives of an operation's result y by its operands; what selects an operand is not among
them.
"""


def _choice(graph, node):
    """Of what is one of its operands: (condition, operand where it holds, operand where it does not)."""
    if node.op == "select":
        return node.args

    a, b = node.args[0], node.args[-1]

    if node.op == "min":
        return graph.comparison("<", b, a), b, a

    return (graph.comparison("<", a, b), b, a) if node.op == "max" else None


def _signed(graph, node):
    """Of what differs from its operand by a sign alone: the condition for another sign."""
    if node.op == "abs":
        return graph.comparison("<", node.args[0], graph.constant(0.0))

    if node.op == "copysign":
        zero = graph.constant(0.0)
        return graph.comparison(
            "!=",
            graph.select(graph.comparison("<", node.args[0], zero), graph.constant(1.0), zero),
            graph.select(graph.comparison("<", node.args[1], zero), graph.constant(1.0), zero),
        )

    return None


class _Rules:
    """Derivatives of a graph's operations, found on that graph: symbols take it for their tracer."""

    def __init__(self, graph: Graph):
        self.graph = graph

    def partials(self, k):
        """Nodes of the partial derivatives of node k by its operands."""
        node = self.graph.nodes[k]

        if node.op not in PARTIALS:
            raise Untraceable(f"{node.op} has no derivative here")

        found = PARTIALS[node.op](symbol_of(self, k), *(symbol_of(self, a) for a in node.args))
        return [node_of(self, value) for value in found]

    def sum(self, a, b):
        """a + b of derivatives, None standing for zero."""
        return b if a is None else a if b is None else self.graph.sum(a, b)

    def product(self, a, b):
        """a b, where a zero of a condition keeps what is not finite from being felt."""
        graph = self.graph

        for one, other in ((a, b), (b, a)):
            node = graph.nodes[one]

            if node.op == "select" and graph.known(node.args[2]) == 0:
                return graph.select(node.args[0], self.product(node.args[1], other), node.args[2])

            if node.op == "select" and graph.known(node.args[1]) == 0:
                return graph.select(node.args[0], node.args[1], self.product(node.args[2], other))

        return graph.product(a, b)

    def chosen(self, condition, a, b):
        """a or b by a condition, None standing for zero."""
        if a is None and b is None:
            return None

        zero = self.graph.constant(0.0)
        return self.graph.select(condition, zero if a is None else a, zero if b is None else b)


def forward(
    graph: Graph, wanted: Sequence[int], directions: Sequence[Mapping[int, int]]
) -> list[list[int | None]]:
    """For each direction (leaf -> its rate along it) the rates of some nodes; None where that is zero
    whatever the leaves are.
    """
    rules = _Rules(graph)
    needed = graph.needed(wanted)
    return [_one_way(rules, needed, wanted, direction) for direction in directions]


def _one_way(rules, needed, wanted, direction):
    graph = rules.graph
    rate: dict[int, int] = dict(direction)

    for k in needed:
        node = graph.nodes[k]

        if k in rate or node.op in CONSTANT or rate.keys().isdisjoint(node.args):
            continue

        if (way := _choice(graph, node)) is not None:
            found = rules.chosen(way[0], rate.get(way[1]), rate.get(way[2]))
        elif (other_sign := _signed(graph, node)) is not None:
            along = rate.get(node.args[0])
            found = None if along is None else graph.select(other_sign, graph.negative(along), along)
        else:
            found = None

            for a, partial in zip(node.args, rules.partials(k)):
                if a in rate:
                    found = rules.sum(found, graph.product(partial, rate[a]))

        if found is not None and graph.known(found) != 0:
            rate[k] = found

    return [rate.get(k) for k in wanted]


def reverse(graph: Graph, weights: Mapping[int, int], leaves: Sequence[int]) -> list[int | None]:
    """Derivatives by some leaves of the sum of nodes by their weights (node -> node of its weight); None
    where zero.
    """
    rules = _Rules(graph)
    depends = graph.depending(leaves)
    weight: dict[int, int | None] = {}

    for k, value in weights.items():
        weight[k] = rules.sum(weight.get(k), value)

    for k in reversed(graph.needed(weights)):
        of = weight.get(k)
        node = graph.nodes[k]

        if of is None or k not in depends or node.op in CONSTANT:
            continue

        if (way := _choice(graph, node)) is not None:
            passed = [
                (way[1], rules.chosen(way[0], of, None)),
                (way[2], rules.chosen(way[0], None, of)),
            ]
        elif (other_sign := _signed(graph, node)) is not None:
            passed = [(node.args[0], graph.select(other_sign, graph.negative(of), of))]
        else:
            passed = [(a, rules.product(of, partial)) for a, partial in zip(node.args, rules.partials(k))]

        for a, value in passed:
            if a in depends and value is not None and graph.known(value) != 0:
                weight[a] = rules.sum(weight.get(a), value)

    return [weight.get(k) for k in leaves]


def jacobian(graph: Graph, wanted: Sequence[int], leaves: Sequence[int]) -> list[list[int | None]]:
    """Rows of d wanted / d leaves as nodes of the graph, None where they are zero; in reverse where there
    are few rows.
    """
    one = graph.constant(1.0)

    if 2 * len(wanted) < len(leaves):
        return [reverse(graph, {k: one}, leaves) for k in wanted]

    columns = forward(graph, wanted, [{leaf: one} for leaf in leaves])
    return [[column[i] for column in columns] for i in range(len(wanted))]


def at_the_trace(graph: Graph, wanted: Sequence[int], leaves: Sequence[int]) -> np.ndarray:
    """d wanted / d leaves as numbers (n_wanted, n_leaves), where the graph was recorded; nothing is added to
    it.
    """
    rates: dict[int, np.ndarray] = dict(zip(leaves, np.eye(len(leaves))))
    values = [
        np.float64(value) if node.kind == REAL else value for node, value in zip(graph.nodes, graph.values)
    ]
    zero = np.zeros(len(leaves))

    with np.errstate(all="ignore"):
        for k in graph.needed(wanted):
            node = graph.nodes[k]

            if k not in rates and node.op not in CONSTANT and not rates.keys().isdisjoint(node.args):
                rates[k] = _numeric(node, k, values, rates)

    return np.array([rates.get(k, zero) for k in wanted]).reshape(len(wanted), len(leaves))


def _numeric(node, k, values, rates):
    """The rate of one operation from those of its operands, all numbers."""
    args = node.args
    zero = np.zeros_like(next(rates[a] for a in args if a in rates))

    if node.op == "select":
        return rates.get(args[1] if values[args[0]] else args[2], zero)

    if node.op in ("min", "max"):
        second = values[args[1]] < values[args[0]] if node.op == "min" else values[args[1]] > values[args[0]]
        return rates.get(args[1] if second else args[0], zero)

    if node.op in ("abs", "copysign"):
        rate = rates.get(args[0], zero)
        return -rate if np.signbit(values[args[0]]) != np.signbit(values[k]) else rate

    partials = PARTIALS[node.op](values[k], *(values[a] for a in args))
    return sum(partial * rates[a] for a, partial in zip(args, partials) if a in rates)
