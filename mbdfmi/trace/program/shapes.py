"""What an expression of a kernel is, as far as that is known without running it."""

import itertools
from collections.abc import Callable
from typing import Any, NamedTuple

from ..graph import BOOL, INT, REAL, Untraceable

MOST_VALUES = 32
"""Whole numbers that are told apart at most; of more it may be any."""


class Number(NamedTuple):
    """A number. values : those that it may be, of whole numbers and truths, None for any."""

    kind: str
    values: frozenset | None = None

    @property
    def only(self):
        """The one value that it has, else None."""
        return next(iter(self.values)) if self.values is not None and len(self.values) == 1 else None


class Array(NamedTuple):
    """An array of numbers. name : of the model's array that it is, or None."""

    kind: str
    name: str | None = None


class Tuple(NamedTuple):
    """A tuple, of a class that names its members or none."""

    named: Any
    members: tuple


class Known(NamedTuple):
    """Something of Python that is no number: a module, a function, a class, a table."""

    what: Any


class View(NamedTuple):
    """`m` or `d`."""


NOTHING = None
"""What a kernel returns that returns nothing."""

ANY_INT, ANY_REAL, ANY_BOOL = Number(INT), Number(REAL), Number(BOOL)


def number(value) -> Number:
    """A number that is known."""
    if isinstance(value, bool):
        return Number(BOOL, frozenset([value]))

    return Number(INT, frozenset([int(value)])) if isinstance(value, int) else ANY_REAL


def some(kind: str, values) -> Number:
    """A number that is one of some."""
    values = frozenset(values)
    return Number(kind, values if len(values) <= MOST_VALUES else None)


def join(a, b):
    """What is either of two; Untraceable where that is nothing that C has."""
    if a == b or b is None:
        return a

    if a is None:
        return b

    if isinstance(a, Number) and isinstance(b, Number):
        if REAL in (a.kind, b.kind):
            return ANY_REAL

        kind = a.kind if a.kind == b.kind else INT
        both = None if a.values is None or b.values is None else a.values | b.values
        return Number(kind, None) if both is None else some(kind, both)

    if isinstance(a, Array) and isinstance(b, Array) and a.kind == b.kind:
        return Array(a.kind)

    a, b = as_value(a), as_value(b)

    if (
        isinstance(a, Tuple)
        and isinstance(b, Tuple)
        and (a.named, len(a.members)) == (b.named, len(b.members))
    ):
        return Tuple(a.named, tuple(map(join, a.members, b.members)))

    raise Untraceable(f"what is {a} in one way is {b} in another")


def as_value(shape):
    """A table that is a tuple of Python as the tuple that it is."""
    if isinstance(shape, Known) and isinstance(shape.what, tuple):
        return Tuple(None, tuple(as_value(of_object(member)) for member in shape.what))

    return shape


def of_object(thing):
    """The shape of something that a kernel finds by name."""
    if isinstance(thing, (bool, int, float)):
        return number(thing)

    return Known(thing)


def loose(shape):
    """A shape without what is known of its values: what tells one function in C from another."""
    if isinstance(shape, Number):
        return Number(shape.kind)

    if isinstance(shape, Array):
        return Array(shape.kind)

    shape = as_value(shape)
    return Tuple(shape.named, tuple(map(loose, shape.members))) if isinstance(shape, Tuple) else shape


def computed(kind: str, operation: Callable, *operands: Number) -> Number:
    """The result of an operation on whole numbers or truths, for all that they may be."""
    if any(operand.values is None for operand in operands):
        return Number(kind)

    try:
        return some(
            kind, {operation(*each) for each in itertools.product(*(o.values or () for o in operands))}
        )
    except ZeroDivisionError:
        return Number(kind)
