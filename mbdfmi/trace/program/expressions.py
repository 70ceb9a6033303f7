"""The expressions of a kernel in C."""

import ast
import math
import operator
from typing import Any, NamedTuple

import numpy as np

from ..graph import BOOL, INT, REAL, Untraceable
from ..plain import plain_function
from . import shapes
from .shapes import ANY_BOOL, ANY_INT, ANY_REAL, Known, Number, Tuple, View, join
from .types import constant

_CHOICE, _OR, _AND, _EQUALS, _ORDER, _ADDS, _MULTIPLIES, _SIGNS, ATOM = range(9)

_BINARY = {
    ast.Add: ("+", _ADDS, operator.add),
    ast.Sub: ("-", _ADDS, operator.sub),
    ast.Mult: ("*", _MULTIPLIES, operator.mul),
    ast.Div: ("/", _MULTIPLIES, operator.truediv),
    ast.FloorDiv: ("whole_quotient", ATOM, operator.floordiv),
    ast.Mod: ("whole_rest", ATOM, operator.mod),
    ast.BitAnd: ("&", _OR, operator.and_),
    ast.BitOr: ("|", _OR, operator.or_),
    ast.BitXor: ("^", _OR, operator.xor),
    ast.LShift: ("<<", _OR, operator.lshift),
    ast.RShift: (">>", _OR, operator.rshift),
    ast.Pow: ("pow", ATOM, operator.pow),
}
_BITS = {"&", "|", "^", "<<", ">>"}
_COMPARISONS = {
    ast.Lt: ("<", _ORDER, operator.lt),
    ast.LtE: ("<=", _ORDER, operator.le),
    ast.Gt: (">", _ORDER, operator.gt),
    ast.GtE: (">=", _ORDER, operator.ge),
    ast.Eq: ("==", _EQUALS, operator.eq),
    ast.NotEq: ("!=", _EQUALS, operator.ne),
}
_REAL_FUNCTIONS = {
    name: name
    for name in (
        "sqrt",
        "sin",
        "cos",
        "atan2",
        "asin",
        "acos",
        "exp",
        "log",
        "tanh",
        "copysign",
        "asinh",
        "pow",
    )
} | {"ceil": "ceil"}


class Text(NamedTuple):
    """An expression: what it is, how it is written, how strongly that binds, whether it changes anything, and
    of what parts it is made, if it is a tuple written out.
    """

    shape: Any
    text: str = ""
    order: int = ATOM
    acts: bool = False
    parts: tuple = ()

    @property
    def only(self):
        """The one value that it has, where nothing need be done for it."""
        return self.shape.only if isinstance(self.shape, Number) and not self.acts else None

    def within(self, least: int) -> str:
        """The text, in parentheses where it binds weaker than `least`."""
        return self.text if self.order >= least else f"({self.text})"


UNKNOWN = Text(None)
"""What nothing is known of yet: the function is looked at again when there is."""


def plain(value) -> Text:
    """A number that is known."""
    text = constant(value)
    return Text(shapes.number(value), text, _SIGNS if text.startswith("-") else ATOM)


class Expressions:
    """Of one kernel: `program` knows the others, `function` the shapes of its variables."""

    def __init__(self, program, function):
        self.program = program
        self.function = function
        self.types = program.types

    def expression(self, node) -> Text:
        """An expression."""
        found = self._expression(node)
        only = found.only
        return found if only is None or found.parts else plain(only)

    def _expression(self, node):
        match node:
            case ast.Constant(value=value) if isinstance(value, (bool, int, float)):
                return plain(value)
            case ast.Name(id=name):
                return self._name(name)
            case ast.Attribute(value=value, attr=name):
                return self._member(self.expression(value), name)
            case ast.Subscript(value=value, slice=place):
                return self._element(self.expression(value), place)
            case ast.Tuple(elts=members):
                return self._tuple(None, [self.expression(member) for member in members])
            case ast.UnaryOp(op=op, operand=operand):
                return self._unary(op, self.expression(operand))
            case ast.BinOp(left=left, op=op, right=right):
                return self.binary(op, self.expression(left), self.expression(right))
            case ast.Compare(left=left, ops=ops, comparators=others):
                return self._comparison(ops, [self.expression(each) for each in (left, *others)])
            case ast.BoolOp(op=op, values=values):
                return self._truths(isinstance(op, ast.And), values)
            case ast.IfExp(test=test, body=body, orelse=other):
                return self._choice(self.expression(test), body, other)
            case ast.Call(func=called, args=args, keywords=[]):
                return self._call(called, args)

        raise Untraceable(f"{ast.unparse(node)} is not translated")

    # names

    def _name(self, name):
        if name in self.function.names:
            shape = self.function.known(name)
            return UNKNOWN if shape is None else Text(shape, self.function.spelled(name))

        scope = self.function.python.__globals__
        return self.known(scope[name] if name in scope else _BUILTINS[name], name)

    def known(self, thing, name) -> Text:
        """Something that a kernel finds by name."""
        if isinstance(thing, (bool, int, float)):
            return plain(bool(thing) if isinstance(thing, bool) else thing)

        return Text(Known(thing), name)

    def _member(self, owner, name):
        shape = owner.shape

        if isinstance(shape, View):
            return self.program.member(name)

        if isinstance(shape, Tuple) and shape.named:
            place = shape.named._fields.index(name)
            return self._part(owner, place)

        if isinstance(shape, Known):
            return self.known(getattr(shape.what, name), name)

        return UNKNOWN

    def _part(self, owner, place):
        """A member of a tuple by its place."""
        shape = owner.shape
        place %= len(shape.members)

        if owner.parts and not any(part.acts for part in owner.parts):
            return owner.parts[place]

        field = self.types.fields(shape)[place]
        return Text(shape.members[place], f"{owner.within(ATOM)}.{field}", ATOM, owner.acts)

    def _element(self, owner, node):
        shape = owner.shape

        if isinstance(node, ast.Tuple):
            return self._of_table(owner, [self.expression(each) for each in node.elts])

        place = self.expression(node)

        if shape is None or place.shape is None:
            return UNKNOWN

        if isinstance(shape, Known):
            if place.only is not None and not isinstance(shape.what, np.ndarray):
                return self.known(shape.what[place.only], owner.text)

            return self._of_table(owner, [place])

        if isinstance(shape, Tuple):
            if place.only is not None:
                return self._part(owner, place.only)

            found = shape.members[0]

            for member in shape.members[1:]:
                found = join(found, member)

            acts = owner.acts or place.acts
            return Text(found, f"{self.types.at(shape)}({owner.text}, {place.text})", ATOM, acts)

        return self.program.element(owner, place)

    def _of_table(self, owner, places):
        """A number of a table of Python, which goes along as a table of C."""
        if any(place.shape is None for place in places):
            return UNKNOWN

        values = np.asarray(owner.shape.what)

        if all(place.only is not None for place in places) and values.ndim == len(places):
            return plain(values[tuple(place.only for place in places)].item())

        name, lengths, kind = self.types.table(owner.shape.what, owner.text)
        index = places[0]

        for place, length in zip(places[1:], lengths[1:]):
            index = self.binary(ast.Add(), self.binary(ast.Mult(), index, plain(length)), place)

        found = shapes.some(INT, values.ravel().tolist()) if kind == INT else ANY_REAL
        return Text(found, f"{name}[{index.text}]")

    # operations

    def _tuple(self, named, members):
        if any(member.shape is None for member in members):
            return UNKNOWN

        members = [self._value(member) for member in members]
        shape = Tuple(named, tuple(member.shape for member in members))
        text = f"({self.types.name(shape)}){{{', '.join(member.text for member in members)}}}"
        return Text(shape, text, ATOM, any(member.acts for member in members), tuple(members))

    def _value(self, found):
        """An expression as a value: what stands in Python as a table becomes a tuple written out."""
        if isinstance(found.shape, Known) and isinstance(found.shape.what, tuple):
            return self._tuple(None, [self.known(member, "") for member in found.shape.what])

        return found

    def _unary(self, op, operand):
        shape = operand.shape

        if shape is None:
            return UNKNOWN

        if isinstance(op, ast.Not):
            return Text(
                shapes.computed(BOOL, operator.not_, self._truth(operand).shape),
                f"!{operand.within(_SIGNS)}",
                _SIGNS,
                operand.acts,
            )

        if isinstance(op, ast.USub):
            found = ANY_REAL if shape.kind == REAL else shapes.computed(INT, operator.neg, shape)
            return Text(found, f"-{operand.within(ATOM)}", _SIGNS, operand.acts)

        raise Untraceable(f"{type(op).__name__} is not translated")

    def binary(self, op, a, b) -> Text:
        """An operation on two numbers."""
        if a.shape is None or b.shape is None:
            return UNKNOWN

        sign, order, operation = _BINARY[type(op)]
        acts = a.acts or b.acts
        whole = REAL not in (a.shape.kind, b.shape.kind)

        if isinstance(op, ast.Pow):
            name = "pow" if b.shape.kind == REAL else "whole_power"
            return Text(ANY_REAL, f"{name}({a.text}, {b.text})", ATOM, acts)

        if isinstance(op, ast.Div):
            first = f"(double){a.within(ATOM)}" if whole else a.within(order)
            return Text(ANY_REAL, f"{first} / {b.within(order + 1)}", order, acts)

        if not whole:
            assert order != ATOM, sign
            return Text(ANY_REAL, f"{a.within(order)} {sign} {b.within(order + 1)}", order, acts)

        found = shapes.computed(INT, operation, a.shape, b.shape)

        if order == ATOM:
            return Text(found, f"{sign}({a.text}, {b.text})", ATOM, acts)

        # nothing is added, and once is what it is
        if not acts and sign == "+" and 0 in (a.only, b.only):
            return b if a.only == 0 else a

        if not acts and sign == "*" and 1 in (a.only, b.only):
            return b if a.only == 1 else a

        bits = sign in _BITS
        left, right = (ATOM, ATOM) if bits else (order, order + 1)
        return Text(found, f"{a.within(left)} {sign} {b.within(right)}", order, acts)

    def _comparison(self, ops, operands):
        if any(operand.shape is None for operand in operands):
            return UNKNOWN

        return self._together(
            True, (self._compared(op, a, b) for op, a, b in zip(ops, operands, operands[1:]))
        )

    @staticmethod
    def _compared(op, a, b):
        sign, order, operation = _COMPARISONS[type(op)]
        whole = REAL not in (a.shape.kind, b.shape.kind)
        found = shapes.computed(BOOL, operation, a.shape, b.shape) if whole else ANY_BOOL
        return Text(found, f"{a.within(_ADDS)} {sign} {b.within(_ADDS)}", order, a.acts or b.acts)

    def _truth(self, found):
        """An expression as a condition."""
        if found.shape is None or found.shape.kind == BOOL:
            return found

        return self._compared(ast.NotEq(), found, plain(0))

    def _truths(self, all_of, nodes):
        """`and`, or `or`."""
        return self._together(all_of, (self._truth(self.expression(node)) for node in nodes))

    @staticmethod
    def _together(all_of, given):
        """All of some conditions, or any: what is known is left out, and what comes after the one that
        decides."""
        parts = []

        for part in given:
            if part.shape is None:
                return UNKNOWN

            if part.only is not all_of:
                parts.append(part)

            if part.only is not None and part.only is not all_of:
                break

        if not parts:
            return plain(all_of)

        acts = any(part.acts for part in parts)

        # one that decides, with nothing done before it
        if len(parts) == 1 or (parts[-1].only is not None and not acts):
            return parts[-1]

        sign, order = ("&&", _AND) if all_of else ("||", _OR)
        return Text(ANY_BOOL, f" {sign} ".join(part.within(_EQUALS) for part in parts), order, acts)

    def _choice(self, test, body, other):
        test = self._truth(test)

        if test.shape is None:
            return UNKNOWN

        if test.only is not None:
            return self.expression(body if test.only else other)

        ways = [self._value(self.expression(node)) for node in (body, other)]

        if any(way.shape is None for way in ways):
            return UNKNOWN

        shape = join(ways[0].shape, ways[1].shape)
        first, second = (self.coerced(way, shape) for way in ways)
        acts = test.acts or first.acts or second.acts
        text = f"{test.within(_OR)} ? {first.within(_OR)} : {second.within(_CHOICE)}"
        return Text(shape, text, _CHOICE, acts)

    def coerced(self, found: Text, shape) -> Text:
        """An expression as one of another shape that it is joined into."""
        found = self._value(found)

        if found.shape is None or shape is None or self.types.name(found.shape) == self.types.name(shape):
            return found

        if isinstance(shape, Number):
            return found

        if isinstance(shape, Tuple) and found.parts:
            parts = tuple(self.coerced(part, member) for part, member in zip(found.parts, shape.members))
            text = f"({self.types.name(shape)}){{{', '.join(part.text for part in parts)}}}"
            return Text(shape, text, ATOM, found.acts, parts)

        raise Untraceable(f"{found.text} is not {self.types.name(shape)}")

    # calls

    def _call(self, called, nodes):
        thing = self.expression(called)

        if thing.shape is None:
            return UNKNOWN

        what = thing.shape.what
        args = [self.expression(node) for node in nodes]

        if any(arg.shape is None for arg in args):
            return UNKNOWN

        if isinstance(what, type) and hasattr(what, "_fields"):
            return self._tuple(what, args)

        function = plain_function(what)

        if function is not None:
            return self.program.call(self, function, [self._value(arg) for arg in args])

        if what is math.floor:
            return Text(ANY_INT, f"(int32_t)floor({args[0].text})", _SIGNS, args[0].acts)

        return self._of_mathematics(getattr(what, "__name__", str(what)), args)

    def _of_mathematics(self, name, args):
        """A function of Python, of its mathematics or numpy's."""
        acts = any(arg.acts for arg in args)
        listed = ", ".join(arg.text for arg in args)
        kinds = [arg.shape.kind for arg in args]
        whole = REAL not in kinds

        if name in _REAL_FUNCTIONS:
            return Text(ANY_REAL, f"{_REAL_FUNCTIONS[name]}({listed})", ATOM, acts)

        if name == "isfinite":
            return Text(ANY_BOOL, f"(isfinite({listed}) != 0)", ATOM, acts)

        if name == "float":
            return Text(ANY_REAL, f"(double){args[0].within(_SIGNS)}", _SIGNS, acts) if whole else args[0]

        if name == "int":
            return args[0] if whole else Text(ANY_INT, f"(int32_t){args[0].within(_SIGNS)}", _SIGNS, acts)

        if name == "floor":
            return Text(ANY_REAL, f"floor({listed})", ATOM, acts)

        if name == "abs":
            text = f"{'whole_size' if whole else 'fabs'}({listed})"
            return Text(shapes.computed(INT, abs, args[0].shape) if whole else ANY_REAL, text, ATOM, acts)

        if name in ("min", "max"):
            return self._extreme(name, args)

        raise Untraceable(f"{name} is not translated")

    def _extreme(self, name, args):
        found = args[0]

        for other in args[1:]:
            whole = REAL not in (found.shape.kind, other.shape.kind)
            shape = (
                shapes.computed(INT, min if name == "min" else max, found.shape, other.shape)
                if whole
                else ANY_REAL
            )
            called = f"{'whole_' if whole else ''}{name}imum"
            found = Text(shape, f"{called}({found.text}, {other.text})", ATOM, found.acts or other.acts)

        return found


_BUILTINS = {"abs": abs, "min": min, "max": max, "int": int, "float": float, "range": range}
