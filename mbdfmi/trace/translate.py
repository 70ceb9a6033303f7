"""A kernel of scalars as a function in C99, statement by statement: for the few loops that end by values.

Numbers are int64_t or double: parameters as told, variables by what is assigned to them first.
"""

import ast
import inspect
import math
import textwrap
from types import FunctionType

from .graph import Untraceable

_OPERATORS: dict[type, str] = {ast.Add: "+", ast.Sub: "-", ast.Mult: "*", ast.Div: "/", ast.FloorDiv: "/"}
_COMPARISONS: dict[type, str] = {ast.Lt: "<", ast.LtE: "<=", ast.Gt: ">", ast.GtE: ">=", ast.Eq: "=="}
_BOOLEANS: dict[type, str] = {ast.And: "&&", ast.Or: "||"}
_CALLS = {"min": "minimum", "max": "maximum", "abs": "fabs"}


def c_function(function: FunctionType, name: str, parameters: dict[str, str]) -> str:
    """A kernel written out in C as a static function of that name.

    parameters : of each its type in C, in order.
    """
    tree = ast.parse(textwrap.dedent(inspect.getsource(function))).body[0]
    assert isinstance(tree, ast.FunctionDef)
    writer = _Writer(function, dict(parameters))
    lines = writer.block(tree.body[1:] if ast.get_docstring(tree) else tree.body, 1)
    given = ", ".join(f"{kind}{'' if kind.endswith('*') else ' '}{name}" for name, kind in parameters.items())
    return "\n".join([f"static {writer.returned} {name}({given})", "{", *lines, "}"])


class _Writer:
    """Statements and expressions of one function; what its names are."""

    def __init__(self, function, kinds):
        self.function = function
        self.kinds = kinds
        self.returned = "double"

    def block(self, statements, depth):
        return [line for statement in statements for line in self.statement(statement, depth)]

    def statement(self, node, depth):
        """Lines of a statement."""
        indent = "    " * depth

        match node:
            case ast.Assign(targets=[ast.Name(id=name)], value=value):
                text, kind = self.expression(value)
                declared = "" if name in self.kinds else f"{self.kinds.setdefault(name, kind)} "
                return [f"{indent}{declared}{name} = {text};"]
            case ast.AugAssign(target=ast.Name(id=name), op=op, value=value):
                return [f"{indent}{name} {_OPERATORS[type(op)]}= {self.expression(value)[0]};"]
            case ast.While(test=test, body=body):
                return self._looped(f"while ({self.expression(test)[0]})", body, indent, depth)
            case ast.For(target=ast.Name(id=name), iter=ast.Call(args=[count]), body=body):
                end = self.expression(count)[0]
                return self._looped(f"for (int {name} = 0; {name} < {end}; {name}++)", body, indent, depth)
            case ast.If(test=test, body=body, orelse=other):
                lines = self._looped(f"if ({self.expression(test)[0]})", body, indent, depth)
                return lines + (self._looped("else", other, indent, depth) if other else [])
            case ast.Break():
                return [f"{indent}break;"]
            case ast.Return(value=value):
                text, self.returned = self.expression(value)
                return [f"{indent}return {text};"]

        raise Untraceable(f"{self.function.__name__}: {ast.unparse(node)} is not translated")

    def _looped(self, head, body, indent, depth):
        return [f"{indent}{head} {{", *self.block(body, depth + 1), f"{indent}}}"]

    def expression(self, node):
        """(text, type) of an expression."""
        match node:
            case ast.Constant(value=value):
                return repr(value), "int64_t" if isinstance(value, int) else "double"
            case ast.Name(id=name) if name in self.kinds:
                return name, self.kinds[name]
            case ast.Name(id=name):
                return self._number(self.function.__globals__[name])
            case ast.Attribute(value=ast.Name(id="math"), attr=name):
                return self._number(getattr(math, name))
            case ast.Subscript(value=ast.Name(id=name), slice=place):
                return f"{name}[{self.expression(place)[0]}]", self.kinds[name].removesuffix(
                    " *"
                ).removeprefix("const ")
            case ast.UnaryOp(op=ast.USub(), operand=operand):
                text, kind = self.expression(operand)
                return f"-{text}", kind
            case ast.BinOp(left=left, op=op, right=right):
                (a, one), (b, two) = self.expression(left), self.expression(right)
                whole = one == two == "int64_t" and not isinstance(op, ast.Div)
                return f"({a} {_OPERATORS[type(op)]} {b})", "int64_t" if whole else "double"
            case ast.Compare(left=left, ops=[op], comparators=[right]):
                return (
                    f"{self.expression(left)[0]} {_COMPARISONS[type(op)]} {self.expression(right)[0]}",
                    "int",
                )
            case ast.BoolOp(op=op, values=values):
                words = f" {_BOOLEANS[type(op)]} "
                return words.join(f"({self.expression(value)[0]})" for value in values), "int"
            case ast.IfExp(test=test, body=body, orelse=other):
                (a, kind), (b, _) = self.expression(body), self.expression(other)
                return f"({self.expression(test)[0]} ? {a} : {b})", kind
            case ast.Call(func=ast.Attribute(attr=name) | ast.Name(id=name), args=args):
                given = ", ".join(self.expression(value)[0] for value in args)
                return f"{_CALLS.get(name, name)}({given})", "double"

        raise Untraceable(f"{self.function.__name__}: {ast.unparse(node)} is not translated")

    @staticmethod
    def _number(value):
        return repr(value), "int64_t" if isinstance(value, int) else "double"
