"""Guards that are cheaper than what a kernel asks, and enough: where they hold, so does that.

Most of what kernels ask in every evaluation is far from being in question: whether inertia about a joint is
more than rounding, whether a row of a loop adds anything to the rows before it. To ask it exactly, sums are
needed that nothing else needs, of what things could be at most. Here these sums take bounds that do not
change in a run: absolute values are added where the kernel adds and subtracts, sines and cosines are 1, so
are squares beside a sum that they are in (rotation matrices by Euler parameters), and what is left follows
from parameters alone, and is computed once (`once.py`). Rounding does not matter: rounded sums and products
of larger numbers are not smaller.

Where such a guard fails the kernel itself is called, as where any guard fails.
"""

import math
from collections.abc import Collection, Iterable, Sequence

from .graph import BOOL, Graph
from .once import still_nodes
from .record import Guard

MARGIN = 16.0
"""How many times more than a guard asks what is compared must be where it is traced."""

FALLS = tuple(2.0**k for k in range(14, 3, -1))
"""To which part of what it is there inertia about a joint's axes may fall, as thin bodies turn: as far as
what is divided by it still has bounds that are of use."""

POSITIVE = ("joints.", "math.algebra.")
"""Rooms of the kernels that ask whether what they divide by is positive."""

ONE = 1.0 + 2.0**-52
"""Sines and cosines are not more, however a mathematics library rounds."""

RATIO = 1.0 + 2.0**-46
"""x^2 / (x^2 + y^2 + ...) is not more, nor twice x y / (x^2 + y^2 + ...), nor d (x / d)^2 beside x^2 / d,
however they are rounded."""

MOST = 1e300
"""Numbers below have reciprocals that are not 0."""


def sufficient(graph: Graph, guards: Iterable[Guard], wanted: Collection[int], is_still) -> list[Guard]:
    """Guards that imply some, in their order. wanted : nodes that are needed in any case. is_still : whether
    a leaf, by its name, does not change in a run.
    """
    guards = list(guards)
    best, least = guards, _cost(graph, guards, wanted, is_still)

    for fall in FALLS:
        found = _Bounds(graph, is_still, fall).guards(guards)

        if (cost := _cost(graph, found, wanted, is_still)) < least:
            best, least = found, cost

    return best


def _cost(graph, guards, wanted, is_still):
    """How many operations are left in every call."""
    still = still_nodes(graph, is_still)
    needed = graph.needed([*wanted, *(guard.node for guard in guards)])
    return sum(not still[k] for k in needed)


class _Bounds:
    """What is known of the size of nodes as guards are passed one by one.

    fall : to which part of what it is inertia may fall.
    still : whether a node stays as it is in a run. most, least : node -> the node of what its absolute value
    is at most, of what it is at least, where that is positive; these stay as they are in a run.
    """

    def __init__(self, graph: Graph, is_still, fall: float):
        self.graph = graph
        self.fall = fall
        self.is_still = is_still
        self.still = still_nodes(graph, is_still)
        self.most: dict[int, int] = {}
        self.least: dict[int, int] = {}
        self.seen = 0
        self.is_behind = False

    def guards(self, guards: Sequence[Guard]) -> list[Guard]:
        """Cheaper ones."""
        found: dict[int, Guard] = {}
        values = _equalities(self.graph, guards)

        for guard in guards:
            self._see(guard.node)

            for one in values.get(guard.node) or self._instead_of(guard):
                # what is known to hold is no guard
                if self.graph.known(one.node) is None:
                    found.setdefault(one.node, one)

        return self._together(found.values())

    def _together(self, guards):
        """Of several bounds that one number is to be above the largest."""
        graph = self.graph
        bounds: dict[int, int] = {}
        others, last = [], {}
        still = still_nodes(graph, self.is_still)

        for guard in guards:
            node = graph.nodes[guard.node]

            if node.op == "<" and guard.holds and still[node.args[0]] and not still[node.args[1]]:
                small, large = node.args
                bounds[large] = graph.extreme("max", bounds[large], small) if large in bounds else small
                last[large] = guard.place
            else:
                others.append(guard)

        return [*others, *(Guard(graph.comparison("<", bounds[k], k), True, last[k]) for k in bounds)]

    def _see(self, until):
        """Bounds of all nodes up to one."""
        # with what has become known of divisors
        for k in range(0 if self.is_behind else self.seen, until + 1):
            if not self.still[k] and k not in self.most and (most := self._most(k)) is not None:
                self.most[k] = most

        self.seen = max(self.seen, until + 1)
        self.is_behind = False

    def _absolute(self, k):
        """The node of what |k| is at most, or None."""
        if k < len(self.still) and not self.still[k]:
            return self.most.get(k)

        return self.graph.absolute(k)

    def _most(self, k):
        graph = self.graph
        node = graph.nodes[k]

        if node.kind == BOOL:
            return None

        if node.op in ("sin", "cos", "tanh"):
            return graph.constant(ONE)

        if node.op == "/":
            above, below = self._absolute(node.args[0]), self._divisor(node.args[1])
            return None if above is None or below is None else graph.quotient(above, below)

        if node.op == "*":
            for known in (self._ratio(*node.args), self._part(*node.args)):
                if known is not None:
                    return known

        args = [self._absolute(a) for a in (node.args[1:] if node.op == "select" else node.args)]

        if None in args or not args:
            return None

        match node.op:
            case "+" | "-":
                return graph.sum(*args)
            case "*":
                return graph.product(*args)
            case "neg" | "abs" | "real":
                return args[0]
            case "sqrt":
                return graph.function("sqrt", *args)
            case "min" | "max" | "select":
                return graph.extreme("max", *args)

        return None

    def _ratio(self, a, b):
        """The node of what |x y c / (x^2 + y^2 + ...)| is at most, for a = x and b = y c / (...), or None."""
        for x, other in ((a, b), (b, a)):
            node = self.graph.nodes[other]

            for y, quotient in (node.args, node.args[::-1]) if node.op == "*" else ():
                divided = self.graph.nodes[quotient]

                if (
                    divided.op == "/"
                    and self.still[divided.args[0]]
                    and {x, y} <= self._squared(divided.args[1])
                ):
                    part = self.graph.constant(RATIO if x == y else 0.5 * RATIO)
                    return self.graph.product(part, self.graph.absolute(divided.args[0]))

        return None

    def _part(self, a, b):
        """The node of what |d l^2| is at most, for d and l^2 of l = x / d: x^2 / d; or None."""
        for d, square in ((a, b), (b, a)):
            node = self.graph.nodes[square]
            divided = (
                self.graph.nodes[node.args[0]] if node.op == "*" and node.args[0] == node.args[1] else None
            )

            if divided is not None and divided.op == "/" and divided.args[1] == d:
                above, below = self._absolute(divided.args[0]), self._divisor(d)

                if above is not None and below is not None:
                    return self.graph.quotient(
                        self.graph.product(self.graph.constant(RATIO), self.graph.product(above, above)),
                        below,
                    )

        return None

    def _squared(self, k):
        """Nodes whose squares are added in a sum of squares; none where it is no such sum."""
        node = self.graph.nodes[k]

        if node.op == "+":
            parts = [self._squared(a) for a in node.args]
            return parts[0] | parts[1] if all(parts) else set()

        return {node.args[0]} if node.op == "*" and node.args[0] == node.args[1] else set()

    def _lower(self, k):
        """The node of what k is at least, where that is positive, or None."""
        node = self.graph.nodes[k]

        if node.op == "*" and not self.still[k]:
            args = [self._lower(a) for a in node.args]
            return None if None in args else self.graph.product(*args)

        found = k if self.still[k] else self.least.get(k)
        return found if found is not None and self.graph.values[found] > 0.0 else None

    def _divisor(self, k):
        """The node of what |k| is at least, or None."""
        return self.least.get(k) if not self.still[k] else self.graph.absolute(k)

    def _upper(self, k):
        """The node of what k, not its absolute value, is at most, or None."""
        graph = self.graph
        node = graph.nodes[k]

        if self.still[k]:
            return k

        if node.op == "min":
            args = [upper for a in node.args if (upper := self._upper(a)) is not None]
            return graph.extreme("min", *args) if len(args) == 2 else next(iter(args), None)

        if node.op == "max":
            args = [upper for a in node.args if (upper := self._upper(a)) is not None]
            return graph.extreme("max", *args) if len(args) == 2 else None

        if node.op == "*" and (factor := graph.known(node.args[0])) is not None and factor > 0:
            upper = self._upper(node.args[1])
            return None if upper is None else graph.product(node.args[0], upper)

        if node.op == "*" and (factor := graph.known(node.args[1])) is not None and factor > 0:
            upper = self._upper(node.args[0])
            return None if upper is None else graph.product(node.args[1], upper)

        return self.most.get(k)

    def _instead_of(self, guard):
        """Guards that imply one; it itself where nothing cheaper is known."""
        graph = self.graph
        node = graph.nodes[guard.node]

        if node.op == "==" and not guard.holds and self._is_no_reciprocal_of_zero(*node.args):
            below = graph.nodes[node.args[0]].args[1]
            finite = graph.comparison("<", self.most[below], graph.constant(MOST))
            return [Guard(finite, True, guard.place)]

        if node.op not in ("<", "<=") or self.still[guard.node]:
            return [guard]

        small, large = node.args if guard.holds else reversed(node.args)
        upper, lower = self._upper(small), self._lower(large)

        # what was asked before is enough
        if upper is not None and lower is not None and MARGIN * graph.values[upper] <= graph.values[lower]:
            return [Guard(graph.comparison("<", upper, lower), True, guard.place)]

        bound = self._raised(upper, large, guard.place)

        if bound is None:
            return [guard]

        if not self.still[large] and graph.values[bound] > 0.0:
            self.least[large] = bound
            self.is_behind = True

        return [Guard(graph.comparison("<", bound, large), True, guard.place)]

    def _raised(self, upper, large, place):
        """The node of a bound of at least `upper` that `large` is above, with some margin, or None."""
        graph = self.graph

        if upper is None:
            return None

        most, here = graph.values[upper], graph.values[large]

        if not (math.isfinite(here) and MARGIN * most <= here and here > 0.0):
            return None

        size = self.most.get(large)

        if self.still[large] or size is None or not place.startswith(POSITIVE):
            return upper

        # a part of what it is at most, whichever units masses are in
        part = graph.constant(2.0 ** math.floor(math.log2(here / (self.fall * graph.values[size]))))
        return graph.extreme("max", upper, graph.product(part, size))

    def _is_no_reciprocal_of_zero(self, a, b):
        """Whether 1 / x is asked to be other than 0 of an x that is bounded both ways."""
        node = self.graph.nodes[a]
        below = node.args[1] if node.op == "/" else None
        return (
            self.graph.known(b) == 0.0
            and below is not None
            and self.graph.known(node.args[0]) == 1.0
            and below in self.least
            and below in self.most
        )


def _equalities(graph, guards):
    """Node of a guard -> what is asked instead, of leaves that several guards compare with numbers: whether
    they are what they are here.
    """
    compared: dict[int, list[Guard]] = {}

    for guard in guards:
        node = graph.nodes[guard.node]

        if (
            node.op in ("==", "!=")
            and graph.nodes[node.args[0]].op == "leaf"
            and graph.known(node.args[1]) is not None
        ):
            compared.setdefault(node.args[0], []).append(guard)

    found = {}

    for leaf, several in compared.items():
        if len(several) > 1:
            same = graph.comparison("==", leaf, graph.constant(graph.values[leaf]))
            found |= {guard.node: [Guard(same, True, several[0].place)] for guard in several}

    return found
