"""A graph of scalar operations: each operation on the same operands stands in it once, and what is known
folds away.

A node is an operation, its operands (nodes) and what else it is about. Every node carries the value that it
has at the place where it was recorded: by that the branches of a kernel are taken. Folding keeps the bits of
finite results but for the signs of zeros:

    x + 0, x - 0, 1 x, x / 1 -> x      0 x, 0 / x, x - x -> 0      -c x -> -(c x)

and changes of sign move outwards through * and / until a sum takes them: a + -b -> a - b, -(a - b) -> b - a.
"""

import math
import operator
from collections.abc import Callable
from typing import NamedTuple

import numpy as np

INT, REAL, BOOL = "int", "real", "bool"

COMPARISONS: dict[str, Callable] = {
    "<": operator.lt,
    "<=": operator.le,
    "==": operator.eq,
    "!=": operator.ne,
}

FUNCTIONS = ("sqrt", "sin", "cos", "atan2", "asin", "exp", "log", "tanh", "floor", "copysign", "asinh", "pow")
"""Functions of mathematics that kernels call."""


class Untraceable(ValueError):
    """Something in a kernel that no straight line of operations can do; the text says what."""


class Node(NamedTuple):
    """An operation. about : what it is besides its operands: a constant's value, a leaf's name, a search's
    kind.
    """

    op: str
    args: tuple[int, ...]
    about: object
    kind: str


_NUMPY_NAMES = {"atan2": "arctan2", "asin": "arcsin", "asinh": "arcsinh"}


def _quietly(function, *args):
    """A value, not a number where there is none: such a branch is not taken, or the guards will see it."""
    try:
        return float(function(*args))
    except (ValueError, ZeroDivisionError, OverflowError):
        with np.errstate(all="ignore"):
            return float(getattr(np, _NUMPY_NAMES.get(function.__name__, function.__name__))(*args))


def _divide(a, b):
    with np.errstate(all="ignore"):
        return float(np.float64(a) / np.float64(b))


_VALUES: dict[str, Callable] = {
    "+": operator.add,
    "-": operator.sub,
    "*": operator.mul,
    "/": _divide,
    "neg": operator.neg,
    "abs": abs,
    "min": lambda a, b: b if b < a else a,
    "max": lambda a, b: b if b > a else a,
    "select": lambda c, a, b: a if c else b,
    "not": operator.not_,
    "isfinite": math.isfinite,
    "carried": lambda a: a,
    **COMPARISONS,
}


class Graph:
    """Nodes in the order in which they were made: operands come first.

    exact : whether bits are kept; without, x (y / x) is y.
    """

    def __init__(self, exact: bool = True):
        self.exact = exact
        self.nodes: list[Node] = []
        self.values: list = []
        self._known: dict = {}

    def __len__(self):
        return len(self.nodes)

    def node(self, op, args=(), about=None, kind=REAL, value=None):
        """The node of an operation, a new one if there is none; `value` of what is no operation of
        mathematics.
        """
        key = (op, args, about, kind)
        found = self._known.get(key)

        if found is None:
            found = self._known[key] = len(self.nodes)
            self.nodes.append(Node(op, args, about, kind))
            self.values.append(self._value(op, args) if value is None else value)

        return found

    def found(self, op, args, about, kind):
        """The node of an operation that is there, or None."""
        return self._known.get((op, args, about, kind))

    def _value(self, op, args):
        operands = [self.values[k] for k in args]

        if op in FUNCTIONS:
            return _quietly(getattr(math, op), *operands)

        return _VALUES[op](*operands)

    def constant(self, value):
        """The node of a number."""
        if isinstance(value, (bool, np.bool_)):
            return self.node("constant", (), bool(value), BOOL, bool(value))

        if isinstance(value, (int, np.integer)):
            return self.node("constant", (), int(value), INT, int(value))

        value = float(value)
        return self.node("constant", (), value.hex(), REAL, value)

    def leaf(self, name, value, kind=REAL):
        """The node of something that is given; `name` tells it from others."""
        return self.node("leaf", (), name, kind, value)

    def carried(self, name, begin):
        """The node of what a pass through a loop leaves to the next. begin : the node before the first."""
        return self.node("carried", (begin,), name)

    def known(self, k):
        """The value of a node that is a number, else None."""
        return self.values[k] if self.nodes[k].op == "constant" else None

    def kind(self, k):
        """INT, REAL or BOOL."""
        return self.nodes[k].kind

    def _kind_of(self, *args):
        return INT if all(self.nodes[k].kind == INT for k in args) else REAL

    def _is_negative(self, k):
        """Whether a node is a change of sign, or a negative number."""
        known = self.known(k)
        return self.nodes[k].op == "neg" or (known is not None and known < 0)

    def negative(self, a):
        """-a."""
        node = self.nodes[a]

        if node.op == "constant":
            return self.constant(-self.values[a] if self.values[a] else self.values[a])

        if node.op == "neg":
            return node.args[0]

        if node.op == "-":
            return self.difference(node.args[1], node.args[0])

        return self.node("neg", (a,), None, node.kind)

    def sum(self, a, b):
        """a + b."""
        x, y = self.known(a), self.known(b)

        if x is not None and y is not None:
            return self.constant(x + y)

        if x == 0:
            return self._as(b, self._kind_of(a, b))

        if y == 0:
            return self._as(a, self._kind_of(a, b))

        if self._is_negative(b):
            return self.difference(a, self.negative(b))

        if self._is_negative(a):
            return self.difference(b, self.negative(a))

        return self.node("+", (min(a, b), max(a, b)), None, self._kind_of(a, b))

    def difference(self, a, b):
        """a - b."""
        x, y = self.known(a), self.known(b)

        if x is not None and y is not None:
            return self.constant(x - y)

        if a == b:
            return self.constant(0 if self.kind(a) == INT else 0.0)

        if y == 0:
            return self._as(a, self._kind_of(a, b))

        if x == 0:
            return self.negative(self._as(b, self._kind_of(a, b)))

        if self._is_negative(b):
            return self.sum(a, self.negative(b))

        if self._is_negative(a) and x is None:
            return self.negative(self.sum(self.negative(a), b))

        kind = self._kind_of(a, b)

        # the same the other way round is there already
        if (other := self._known.get(("-", (b, a), None, kind))) is not None:
            return self.node("neg", (other,), None, kind)

        return self.node("-", (a, b), None, kind)

    def product(self, a, b):
        """a b."""
        x, y = self.known(a), self.known(b)

        if x is not None and y is not None:
            return self.constant(x * y)

        kind = self._kind_of(a, b)

        if x == 0 or y == 0:
            return self.constant(0 if kind == INT else 0.0)

        if x == 1:
            return self._as(b, kind)

        if y == 1:
            return self._as(a, kind)

        if self._is_negative(a):
            return self.negative(self.product(self.negative(a), b))

        if self._is_negative(b):
            return self.negative(self.product(a, self.negative(b)))

        for one, other in ((a, b), (b, a)):
            if not self.exact and self.nodes[one].op == "/" and self.nodes[one].args[1] == other:
                return self.nodes[one].args[0]

        return self.node("*", (min(a, b), max(a, b)), None, kind)

    def quotient(self, a, b):
        """a / b."""
        x, y = self.known(a), self.known(b)

        if x is not None and y is not None:
            return self.constant(_divide(x, y))

        if x == 0:
            return self.constant(0.0)

        if y == 1:
            return a

        if self._is_negative(a):
            return self.negative(self.quotient(self.negative(a), b))

        if self._is_negative(b):
            return self.negative(self.quotient(a, self.negative(b)))

        return self.node("/", (a, b))

    def absolute(self, a):
        """|a|."""
        if self.known(a) is not None:
            return self.constant(abs(self.values[a]))

        if self.nodes[a].op in ("neg", "abs"):
            return self.absolute(self.nodes[a].args[0]) if self.nodes[a].op == "neg" else a

        return self.node("abs", (a,), None, self.kind(a))

    def extreme(self, op, a, b):
        """The smaller ("min") or the larger ("max") of two."""
        if a == b:
            return a

        if self.known(a) is not None and self.known(b) is not None:
            return a if _VALUES[op](self.values[a], self.values[b]) == self.values[a] else b

        if self._kind_of(a, b) == INT:
            first, second = (b, a) if op == "min" else (a, b)
            return self.select(self.comparison("<", first, second), b, a)

        return self.node(op, (a, b), None, REAL)

    def whole(self, a):
        """A number made a whole one, towards zero."""
        if self.known(a) is not None:
            return self.constant(int(self.values[a]))

        if self.nodes[a].kind == INT:
            return a

        value = self.values[a]
        return self.node("whole", (a,), None, INT, int(value) if math.isfinite(value) else 0)

    def function(self, name, *args):
        """A function of mathematics."""
        if all(self.known(k) is not None for k in args):
            return self.constant(_quietly(getattr(math, name), *(self.values[k] for k in args)))

        # sin is odd, cos even
        if name in ("sin", "cos") and self._is_negative(args[0]):
            found = self.function(name, self.negative(args[0]))
            return self.negative(found) if name == "sin" else found

        return self.node(name, args)

    def comparison(self, op, a, b):
        """A comparison (a key of COMPARISONS)."""
        if self.known(a) is not None and self.known(b) is not None:
            return self.constant(COMPARISONS[op](self.values[a], self.values[b]))

        if a == b:
            return self.constant(op in ("<=", "=="))

        return self.node(op, (a, b), None, BOOL)

    def finite(self, a):
        """Whether a number is finite."""
        if self.known(a) is not None:
            return self.constant(math.isfinite(self.values[a]))

        return self.node("isfinite", (a,), None, BOOL)

    def select(self, condition, a, b):
        """a where a condition holds, else b."""
        if self.known(condition) is not None:
            return a if self.values[condition] else b

        if a == b:
            return a

        truths = self.nodes[a].kind == self.nodes[b].kind == BOOL
        return self.node("select", (condition, a, b), None, BOOL if truths else self._kind_of(a, b))

    def both(self, a, b):
        """Whether two conditions hold."""
        return self.select(a, b, self.constant(False))

    def either(self, a, b):
        """Whether one of two conditions holds."""
        return self.select(a, self.constant(True), b)

    def _as(self, a, kind):
        """A node as a number of that kind."""
        if kind == REAL and self.kind(a) == INT:
            return self.node("real", (a,), None, REAL, float(self.values[a]))

        return a

    def needed(self, wanted, known=()):
        """The nodes that some need, themselves included, in order. known : those that need nothing."""
        seen = set()
        stack = list(wanted)

        while stack:
            k = stack.pop()

            if k not in seen:
                seen.add(k)
                stack += () if k in known else self.nodes[k].args

        return sorted(seen)

    def values_at(self, wanted, buffers, searches) -> dict:
        """Values of some nodes, and of all that they need, where leaves have other values.

        buffers : name -> numbers, in which a leaf stands that is called (name, place); what operations ask
        for besides. searches : other
        operation -> function of buffers, what it is about, and its operands.
        """
        found: dict = {}

        for k in self.needed(wanted):
            node = self.nodes[k]
            args = [found[a] for a in node.args]

            if node.op == "constant":
                found[k] = self.values[k]
            elif node.op == "leaf":
                found[k] = float(buffers[node.about[0]][node.about[1]])
            elif node.op == "load":
                found[k] = float(buffers[node.about[0]][node.about[1] + args[0]])
            elif node.op == "found":
                found[k] = args[0][node.about]
            elif node.op == "along":
                found[k] = args[0]
            elif node.op in ("real", "whole"):
                found[k] = float(args[0]) if node.op == "real" else int(args[0])
            elif node.op in FUNCTIONS:
                found[k] = _quietly(getattr(math, node.op), *args)
            elif node.op in _VALUES:
                found[k] = _VALUES[node.op](*args)
            else:
                found[k] = searches[node.op](buffers, node.about, *args)

        return found

    def depending(self, on):
        """The nodes that depend on some, these included (a set)."""
        found = set(on)

        for k, node in enumerate(self.nodes):
            if not found.isdisjoint(node.args):
                found.add(k)

        return found
