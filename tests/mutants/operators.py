"""What may be broken in a line: small changes of one node of the syntax tree,
each by an operator of one kind.

Names and strings go by twins: pairs that stand for the same kind of thing, one of which is easily written for
the other. Left alone: docstrings, annotations, and what a message says (inside `raise` and in strings with
values).
"""

import ast
from dataclasses import dataclass
from itertools import pairwise


@dataclass(frozen=True)
class Mutant:
    """One change: `text` for what stands between two offsets (characters) of `source`, the text of `file`."""

    file: str
    function: str
    kind: str
    line: int
    start: int
    end: int
    text: str
    reached_by: tuple[int, int]
    """First and last line of the statement, whose running reaches the place; (0, 0):
    importing the file does."""
    source: str

    def mutated(self) -> str:
        """The whole file with the change."""
        return self.source[: self.start] + self.text + self.source[self.end :]

    def _lines(self, text, length):
        begin = text.rfind("\n", 0, self.start) + 1
        end = text.find("\n", self.start + length)
        return " ".join(text[begin : len(text) if end < 0 else end].split())

    @property
    def before(self) -> str:
        """The lines of the change as they are, on one line."""
        return self._lines(self.source, self.end - self.start)

    @property
    def after(self) -> str:
        """The lines of the change, broken."""
        return self._lines(self.mutated(), len(self.text))


TWINS = [
    ("first", "second"), ("omega", "alpha"), ("w", "alpha"), ("velocity", "acceleration"),
    ("position", "velocity"), ("position", "speed"), ("angle", "speed"), ("lower", "upper"),
    ("stiffness", "damping"), ("force", "moment"), ("a", "b"), ("r", "rd"), ("rd", "rdd"), ("i", "j"),
    ("x", "y"), ("kinetic_energy", "gravity_energy"), ("marker_a", "marker_b"), ("end_frame_a", "end_frame_b"),
    ("q", "v"), ("n_q", "n_v"), ("row", "column"), ("amplitude", "mean"), ("yaw", "roll"),
    ("omega_body", "omega"), ("low", "high"), ("begin", "end"), ("min", "max"), ("sin", "cos"), ("s1", "s2"),
    ("r1", "r2"), ("r11", "r22"), ("t", "tt"), ("w_a", "w_b"), ("v_a", "v_b"), ("A_a", "A_b"), ("r_a", "r_b"),
    ("t_a", "t_b"), ("p", "P"), ("here", "there"), ("before", "after"), ("old", "new"), ("n_e", "n_v"),
    ("dx", "dy"), ("left", "right"), ("c", "s"), ("radius", "length"), ("radius", "tube"),
    ("radius", "inner_radius"), ("strut_a", "strut_b"), ("linear_a", "linear_b"), ("input_axes", "axes"),
    ("body_r", "body_A"), ("smaller", "larger"), ("value", "slope"), ("POSITION", "VELOCITY"),
]  # fmt: skip

TRANSPOSED = {"mat_vec": "matT_vec", "matT_vec": "mat_vec"}
SIGNED = {
    "add": "sub", "sub": "add", "mat_add": "mat_sub", "mat_sub": "mat_add", "sym_add": "sym_sub", "sym_sub":
    "sym_add",
}  # fmt: skip
ORDERED = {
    "cross", "sub", "mat_mat", "E_product", "mat_sub", "sym_sub", "outer", "atan2", "arctan2", "where", "dot",
}  # fmt: skip
"""Functions of two arguments of one type whose order counts (`dot` only of matrices, in numpy)."""

OPPOSITE = {
    ast.Lt: ">=", ast.LtE: ">", ast.Gt: "<=", ast.GtE: "<", ast.Eq: "!=", ast.NotEq: "==", ast.Is: "is not",
    ast.IsNot: "is", ast.In: "not in", ast.NotIn: "in",
}  # fmt: skip


def _twins_of(name):
    """Names that one easily writes for another."""
    return [b if name == a else a for a, b in TWINS if name in (a, b)]


class _Places(ast.NodeVisitor):
    """Walks a file and gathers all mutants of it."""

    def __init__(self, file, source, defaults):
        self.file, self.source, self.defaults = file, source, defaults
        self.offsets = [0]
        self.found = []
        self.functions = []
        self.statement = None
        self.names = [set()]

        for line in source.splitlines(keepends=True):
            # columns of the syntax tree count bytes
            self.offsets.append(self.offsets[-1] + len(line.encode()))

        self.characters = source.encode()

    # places

    def at(self, node):
        """(start, end) of a node, in characters."""
        start = self.offsets[node.lineno - 1] + node.col_offset
        end = self.offsets[node.end_lineno - 1] + node.end_col_offset
        return len(self.characters[:start].decode()), len(self.characters[:end].decode())

    def text(self, node):
        start, end = self.at(node)
        return self.source[start:end]

    def operand(self, node):
        """Text of a node that may stand anywhere: the tree knows no parentheses."""
        text = self.text(node)
        return (
            f"({text})"
            if isinstance(node, ast.BinOp | ast.UnaryOp | ast.BoolOp | ast.Compare | ast.IfExp)
            else text
        )

    def add(self, kind, node, text, at=None):
        start, end = at or self.at(node)
        reached = (0, 0)

        if self.functions:
            # of a statement with a body only its head
            last = (
                self.statement.body[0].lineno - 1
                if hasattr(self.statement, "body")
                else self.statement.end_lineno
            )
            reached = self.statement.lineno, max(last, self.statement.lineno)

        where = ".".join(self.functions) or "(module)"
        line = self.source.count("\n", 0, start) + 1
        self.found.append(Mutant(self.file, where, kind, line, start, end, text, reached, self.source))

    # what is walked

    def visit(self, node):
        if isinstance(node, ast.Raise | ast.JoinedStr | ast.Import | ast.ImportFrom | ast.Assert):
            return

        outer = self.statement

        if isinstance(node, ast.stmt):
            self.statement = node

        super().visit(node)
        self.statement = outer

    def visit_FunctionDef(self, node):
        self.functions.append(node.name)
        self.names.append({child.id for child in ast.walk(node) if isinstance(child, ast.Name)}
                          | {argument.arg for argument in node.args.args})  # fmt: skip
        self._body(node.body)
        self.functions.pop()
        self.names.pop()

    def visit_ClassDef(self, node):
        for child in node.body:
            if isinstance(child, ast.FunctionDef):
                self.functions.append(node.name)
                self.visit(child)
                self.functions.pop()
            else:
                self.visit(child)

    def _body(self, statements):
        if (
            statements
            and isinstance(statements[0], ast.Expr)
            and isinstance(statements[0].value, ast.Constant)
        ):
            statements = statements[1:]

        for statement in statements:
            self.visit(statement)

    def visit_AnnAssign(self, node):
        if node.value is not None:
            self.visit(node.value)

    # operators

    def visit_BinOp(self, node):
        left, right = self.operand(node.left), self.operand(node.right)

        if isinstance(node.op, ast.Add | ast.Sub):
            between = self.at(node.left)[1], self.at(node.right)[0]
            gap = self.source[slice(*between)]
            old, new = ("+", "-") if isinstance(node.op, ast.Add) else ("-", "+")
            indexing = isinstance(node.right, ast.Constant) or isinstance(node.left, ast.Constant)
            texts = [
                part
                for part in (node.left, node.right)
                if isinstance(part, ast.Constant | ast.JoinedStr | ast.List)
                and not isinstance(getattr(part, "value", None), int | float)
            ]

            if not texts and gap.count(old) == 1:
                self.add("sign", node, gap.replace(old, new), between)

                if not indexing:
                    self.add("term dropped", node, left)
                    self.add("term dropped", node, right)

        if isinstance(node.op, ast.Mult | ast.Div):
            for part, other in ((node.left, node.right), (node.right, node.left)):
                divided = part is node.left and isinstance(node.op, ast.Div)

                if self._factor(part) and not divided and not isinstance(other, ast.List | ast.Tuple):
                    self.add("factor", node, self.operand(other))

        if isinstance(node.op, ast.MatMult):
            for part in (node.left, node.right):
                if not isinstance(part, ast.Attribute | ast.Call):
                    self.add("transposed", part, f"{self.operand(part)}.T")

        if isinstance(node.op, ast.Pow) and isinstance(node.right, ast.Constant):
            self.add("factor", node.right, str(node.right.value + 1))

        self.generic_visit(node)

    @staticmethod
    def _factor(node):
        return (
            isinstance(node, ast.Constant)
            and isinstance(node.value, int | float)
            and node.value not in (0, 1)
        )

    def visit_UnaryOp(self, node):
        if isinstance(node.op, ast.USub) and not isinstance(node.operand, ast.Constant):
            self.add("unary minus", node, self.operand(node.operand))

        if isinstance(node.op, ast.Not):
            self.add("comparison", node, f"({self.text(node.operand)})")

        self.generic_visit(node)

    def visit_Compare(self, node):
        if len(node.ops) == 1:
            between = self.at(node.left)[1], self.at(node.comparators[0])[0]
            self.add("comparison", node, f" {OPPOSITE[type(node.ops[0])]} ", between)

        self.generic_visit(node)

    def visit_BoolOp(self, node):
        other = " or " if isinstance(node.op, ast.And) else " and "
        between = self.at(node.values[0])[1], self.at(node.values[1])[0]

        if len(node.values) == 2 and "\n" not in self.source[slice(*between)]:
            self.add("comparison", node, other, between)

        self.generic_visit(node)

    def visit_Subscript(self, node):
        if isinstance(node.value, ast.Name) and node.value.id in (
            "Annotated", "dict", "list", "Literal", "ClassVar",
        ):  # fmt: skip
            return

        index = node.slice
        entries = index.elts if isinstance(index, ast.Tuple) else [index]

        for entry in entries:
            if isinstance(entry, ast.Constant) and type(entry.value) is int:
                self.add("index", entry, {0: "1", 1: "0"}.get(entry.value, str(entry.value - 1)))

            elif isinstance(entry, ast.BinOp) and isinstance(entry.right, ast.Constant):
                self.add("index", entry, self.text(entry.left))

            elif (
                isinstance(entry, ast.Name)
                and len(entry.id) == 1
                and len(entries) == 1
                and "kernels" in self.file
            ):
                self.add("index", entry, f"{entry.id} + 1")

            elif isinstance(entry, ast.Slice):
                for limit in (entry.lower, entry.upper):
                    if isinstance(limit, ast.Constant) and type(limit.value) is int:
                        self.add("index", limit, str(limit.value + 1))

        self.generic_visit(node)

    def visit_Call(self, node):
        function = node.func
        name = function.attr if isinstance(function, ast.Attribute) else getattr(function, "id", "")

        if isinstance(function, ast.Attribute):
            span = self.at(function)[1] - len(name), self.at(function)[1]
        else:
            span = self.at(function)

        if name in SIGNED and len(node.args) == 2 and isinstance(function, ast.Attribute):
            self.add("sign", node, SIGNED[name], span)
            self.add("term dropped", node, self.text(node.args[0]))

            if name in ("add", "mat_add", "sym_add"):
                self.add("term dropped", node, self.text(node.args[1]))

        if name == "neg":
            self.add("unary minus", node, self.text(node.args[0]))

        if name == "axpy":
            self.add("term dropped", node, self.text(node.args[2]))
            self.add("sign", node.args[0], f"-({self.text(node.args[0])})")

        if name == "scale" and self._factor(node.args[0]):
            self.add("factor", node, self.text(node.args[1]))

        if name in ("dot", "norm") and len(node.args) == 2 and "kernels" in self.file:
            self.add("unary minus", node, f"(-{self.text(node)})")

        if name in TRANSPOSED:
            self.add("transposed", node, TRANSPOSED[name], span)

        if name == "transpose" and len(node.args) == 1:
            self.add("transposed", node, self.text(node.args[0]))

        if name == "mat_mat":
            prefix = self.source[self.at(node)[0] : span[0]]

            for part in node.args:
                if isinstance(part, ast.Name | ast.Call):
                    self.add("transposed", part, f"{prefix}transpose({self.text(part)})")

        if name == "E_conjugate" or (name in ("inv", "inverse") and len(node.args) == 1):
            self.add("transposed", node, self.text(node.args[0]))

        self._swaps(node, name)

        if name not in ("Field", "field_validator", "model_validator", "dict"):
            self._keywords(node, name)

        self.generic_visit(node)

    def _swaps(self, node, name):
        """Neighbouring arguments exchanged, where they are of one type."""
        for one, other in pairwise(node.args):
            names = [part.id if isinstance(part, ast.Name) else "" for part in (one, other)]
            alike = names[1] in _twins_of(names[0]) if all(names) else False
            ordered = (
                name in ORDERED and len(node.args) == 2 and not (name == "dot" and "kernels" in self.file)
            )

            if (alike and name not in ("dot", "add", "range", "zip", "min", "max")) or ordered:
                between = self.source[self.at(one)[1] : self.at(other)[0]]
                span = self.at(one)[0], self.at(other)[1]
                self.add("swapped arguments", node, self.text(other) + between + self.text(one), span)

    def _keywords(self, node, name):
        """A keyword left out that has a default."""
        for keyword in node.keywords:
            if (name, keyword.arg) in self.defaults.keywords and len(node.args) + len(node.keywords) > 1:
                start, end = self.at(keyword)

                while self.source[start - 1] in ", \n":
                    start -= 1

                if self.source[start - 1] != "(":
                    self.add("key ignored", node, "", (start, end))

    def visit_Name(self, node):
        for twin in _twins_of(node.id):
            if twin in self.names[-1] and isinstance(node.ctx, ast.Load):
                self.add("swapped names", node, twin)

    def visit_Attribute(self, node):
        span = self.at(node)[1] - len(node.attr), self.at(node)[1]

        if isinstance(node.ctx, ast.Load):
            if node.attr == "T":
                self.add("transposed", node, self.text(node.value))

            elif (
                node.attr in self.defaults.keys
                and "kernels" not in self.file
                and isinstance(node.value, ast.Name)
            ):
                self.add("key ignored", node, self.defaults.keys[node.attr])

            for twin in _twins_of(node.attr):
                if f".{twin}" in self.source and len(twin) > 1:
                    self.add("swapped names", node, twin, span)

        self.generic_visit(node)

    def visit_Constant(self, node):
        if isinstance(node.value, str) and node.value.isidentifier() and self.source[self.at(node)[0]] == '"':
            for twin in _twins_of(node.value):
                if f'"{twin}"' in self.source:
                    self.add("swapped names", node, f'"{twin}"')

    # statements

    def visit_Expr(self, node):
        if isinstance(node.value, ast.Call):
            self.add("statement dropped", node, "pass")
        elif isinstance(node.value, ast.Constant):
            return

        self.generic_visit(node)

    def visit_AugAssign(self, node):
        self.add("statement dropped", node, "pass")
        self.generic_visit(node)

    def visit_Assign(self, node):
        if isinstance(node.targets[0], ast.Subscript) and self.functions:
            self.add("statement dropped", node, "pass")

        self.generic_visit(node)


@dataclass
class Defaults:
    """keys : of the schema, with the text of a plain default. keywords :
    (function, keyword) that have one."""

    keys: dict[str, str]
    keywords: set[tuple[str, str]]


def defaults_of(sources: dict[str, str]) -> Defaults:
    """Of all keys and functions of these sources. A key with different defaults goes by none of them."""
    keys, keywords, clash = {}, set(), set()

    for source in sources.values():
        for node in ast.walk(ast.parse(source)):
            if isinstance(node, ast.FunctionDef):
                named = node.args.args[len(node.args.args) - len(node.args.defaults) :]
                named += [a for a, d in zip(node.args.kwonlyargs, node.args.kw_defaults) if d is not None]
                keywords |= {(node.name, argument.arg) for argument in named}

            if isinstance(node, ast.ClassDef):
                for line in node.body:
                    if (
                        isinstance(line, ast.AnnAssign)
                        and line.value is not None
                        and not isinstance(line.value, ast.Call)
                    ):
                        key, text = line.target.id, ast.unparse(line.value)
                        clash |= {key} if keys.setdefault(key, text) != text else set()

    return Defaults({key: text for key, text in keys.items() if key not in clash and key != "kind"}, keywords)


def mutants_of(file: str, source: str, defaults: Defaults) -> list[Mutant]:
    """All mutants of a file; a few may be no programs, or the same one (`changes`)."""
    places = _Places(file, source, defaults)
    places.visit(ast.parse(source))
    return places.found


def changes(mutant: Mutant) -> bool:
    """Whether it is a program, and another one."""
    try:
        return ast.dump(ast.parse(mutant.mutated())) != ast.dump(ast.parse(mutant.source))
    except SyntaxError:
        return False
