"""Symbolic scalars: what kernels compute with while they are traced."""

import math
from types import SimpleNamespace

from .graph import Graph, Untraceable

_MATH_NAMES = ("sqrt", "sin", "cos", "atan2", "asin", "exp", "log", "tanh", "copysign", "asinh", "pow")


class Symbol:
    """A number of a graph, in the arithmetic of Python."""

    __slots__ = ("k", "tracer")
    __hash__ = None  # type: ignore[assignment]

    def __init__(self, tracer, k):
        self.tracer = tracer
        self.k = k

    @property
    def graph(self) -> Graph:
        return self.tracer.graph

    def __repr__(self):
        return f"<{self.graph.nodes[self.k].op} {self.graph.values[self.k]}>"

    def __add__(self, other):
        return _made(self, Graph.sum, self, other)

    def __radd__(self, other):
        return _made(self, Graph.sum, other, self)

    def __sub__(self, other):
        return _made(self, Graph.difference, self, other)

    def __rsub__(self, other):
        return _made(self, Graph.difference, other, self)

    def __mul__(self, other):
        return _made(self, Graph.product, self, other)

    def __rmul__(self, other):
        return _made(self, Graph.product, other, self)

    def __truediv__(self, other):
        return _made(self, Graph.quotient, self, other)

    def __rtruediv__(self, other):
        return _made(self, Graph.quotient, other, self)

    def __pow__(self, power: int):
        """A whole power, by products: its derivatives are there at zero, too."""
        result = self if power else 1.0
        for _ in range(power - 1):
            result = result * self
        return result

    def __neg__(self):
        return _made(self, Graph.negative, self)

    def __abs__(self):
        return _made(self, Graph.absolute, self)

    def __lt__(self, other):
        return _made(self, _less, self, other)

    def __le__(self, other):
        return _made(self, _less_or_equal, self, other)

    def __gt__(self, other):
        return _made(self, _less, other, self)

    def __ge__(self, other):
        return _made(self, _less_or_equal, other, self)

    def __eq__(self, other):
        return _made(self, _equal, self, other)

    def __ne__(self, other):
        return _made(self, _unequal, self, other)

    def __bool__(self):
        return self.tracer.decide(self.k)

    def __index__(self):
        raise Untraceable("how often a loop turns, or where something is written, depends on values")

    __int__ = __float__ = __index__

    def __mod__(self, other):
        raise Untraceable("a remainder, where something is kept in turn, depends on values")

    __rmod__ = __floordiv__ = __rfloordiv__ = __mod__


def _less(graph, a, b):
    return graph.comparison("<", a, b)


def _less_or_equal(graph, a, b):
    return graph.comparison("<=", a, b)


def _equal(graph, a, b):
    return graph.comparison("==", a, b)


def _unequal(graph, a, b):
    return graph.comparison("!=", a, b)


def node_of(tracer, value):
    """The node of a number, symbolic or not."""
    return value.k if isinstance(value, Symbol) else tracer.graph.constant(value)


def symbol_of(tracer, k):
    """A node as kernels take it: a plain number where it is known."""
    known = tracer.graph.known(k)
    return Symbol(tracer, k) if known is None else known


def _made(self, operation, *operands):
    """The result of an operation of the graph."""
    tracer = self.tracer
    return symbol_of(tracer, operation(tracer.graph, *(node_of(tracer, value) for value in operands)))


def _tracer_of(args):
    return next((value.tracer for value in args if isinstance(value, Symbol)), None)


def _function(name):
    plain = getattr(math, name)

    def function(*args):
        tracer = _tracer_of(args)

        if tracer is None:
            return plain(*args)

        nodes = (node_of(tracer, value) for value in args)
        return symbol_of(tracer, tracer.graph.function(name, *nodes))

    function.__name__ = name
    return function


def _is_finite(x):
    return _made(x, Graph.finite, x) if isinstance(x, Symbol) else math.isfinite(x)


def _extreme(name):
    plain = min if name == "min" else max

    def extreme(first, *others):
        tracer = _tracer_of((first, *others))

        if tracer is None:
            return plain(first, *others)

        found = node_of(tracer, first)

        for value in others:
            found = tracer.graph.extreme(name, found, node_of(tracer, value))

        return symbol_of(tracer, found)

    return extreme


def _floor(x):
    """`math.floor`, which is a whole number."""
    return whole(NUMPY.floor(x)) if isinstance(x, Symbol) else math.floor(x)


def whole(x):
    """`int`, towards zero."""
    return _made(x, Graph.whole, x) if isinstance(x, Symbol) else int(x)


MATH = SimpleNamespace(
    pi=math.pi,
    inf=math.inf,
    isfinite=_is_finite,
    floor=_floor,
    **{name: _function(name) for name in _MATH_NAMES},
)
"""What kernels find as `math`."""

NUMPY = SimpleNamespace(floor=_function("floor"))
"""What kernels that run on symbols find as `np`."""

minimum = _extreme("min")
maximum = _extreme("max")
