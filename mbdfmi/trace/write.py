"""A graph written out in a language: statements for what is used more than once, the rest within them."""

from collections import Counter
from collections.abc import Callable, Collection, Iterable, Mapping, Sequence
from typing import NamedTuple

from .graph import Graph, Untraceable

_COMPARES, _ADDS, _MULTIPLIES, _SIGNS, _ATOM = range(5)
_INFIX = {"+": _ADDS, "-": _ADDS, "*": _MULTIPLIES, "/": _MULTIPLIES} | dict.fromkeys(
    ("<", "<=", "==", "!="), _COMPARES
)

LONGEST = 60
"""Letters of an expression that may stand within another one."""


class Language(NamedTuple):
    """How operations are written.

    calls : operation -> name of the function; others are called as they are. number : a number, exactly.
    select : what is one of two by a condition, with {0}, {1}, {2}. statement : of what is computed once,
    with {kind}, {name}, {value}.
    kinds : what {kind} is.
    """

    calls: dict[str, str]
    number: Callable
    select: str
    statement: str
    kinds: dict[str, str]


def _nothing_solves(name, node, operands):
    raise Untraceable("what is solved for cannot be written so")


class Places(NamedTuple):
    """How what is given is read.

    leaf : name of a leaf -> its text. look_up : (graph, node, texts of its operands) -> text of a number of
    a table, or of where one is searched. named : whether leaves are names already, and need no other. solve :
    (name, node, texts of its operands) -> statements that find an array of that name, of what is solved for.
    """

    leaf: Callable[[object], str]
    look_up: Callable
    named: bool
    solve: Callable = _nothing_solves


class Branch(NamedTuple):
    """Statements of a block, and the texts of what is wanted of it, by node."""

    lines: list[str]
    text: dict[int, str]


class Body:
    """What some nodes need, as statements, in order.

    first : nodes that are read before all else is done, being written over then. branches : what each of the
    branches wants that are written behind; what all need is done before them. known : nodes that are read
    somewhere, and how. later : what will be wanted besides. calls : what is called.
    """

    def __init__(
        self,
        graph: Graph,
        wanted: Iterable[int],
        language: Language,
        places: Places,
        first: Collection[int] = (),
        branches: Sequence[Iterable[int]] = (),
        known: Mapping[int, str] | None = None,
        later: Iterable[int] = (),
    ):
        wanted = list(wanted)
        all_wanted = [*wanted, *(k for branch in branches for k in branch), *later]
        self.graph = graph
        self.known = known or {}
        self.language = language
        self.places = places
        self.lines: list[str] = []
        self.calls: set[str] = set()
        self._text: dict[int, tuple[str, int]] = {}
        self._named = 0
        needed = [k for k in self._needed(all_wanted) if k not in self.known]
        self._uses = Counter(a for k in needed for a in graph.nodes[k].args) + Counter(all_wanted)
        self.lines = self.more(wanted, branches, first)

    def more(
        self, wanted: Iterable[int], branches: Sequence[Iterable[int]] = (), first: Collection[int] = ()
    ) -> list[str]:
        """Statements for what more is wanted, and for what all of some branches that come behind need."""
        common = set.intersection(*(set(self._needed(branch)) for branch in branches)) if branches else set()
        before, self.lines = self.lines, []
        self._state(sorted(common.union(self._needed(wanted))), first)
        found, self.lines = self.lines, before
        return found

    def branch(self, wanted: Iterable[int]) -> "Branch":
        """Statements of a block in braces, for what some nodes need and what does not stand before it."""
        text = dict(self._text)
        found = Branch(self.more(wanted), {k: self[k] for k in wanted})
        self._text = text
        return found

    def _needed(self, wanted):
        return self.graph.needed(wanted, self.known)

    def _state(self, needed, first):
        """Statements of some nodes that have none yet."""
        for k in [*sorted(first), *needed]:
            if k in self._text:
                continue

            if self.graph.nodes[k].op == "solve":
                self._text[k] = (self._solved(k), _ATOM)
                continue

            text, order = self._expression(k)
            alone = self._uses[k] == 1 and len(text) <= LONGEST and k not in first
            plain = self.graph.nodes[k].op == "constant"
            plain = plain or (self.graph.nodes[k].op == "leaf" and self.places.named)
            plain = plain or self.graph.nodes[k].op in ("found", "along")
            self._text[k] = (text, order) if alone or plain else (self._stated(k, text), _ATOM)

    def _solved(self, k):
        """The name of an array of what a kernel gives."""
        self._named += 1
        self.calls.add("solve")
        node = self.graph.nodes[k]
        name = f"t{self._named}"
        self.lines += self.places.solve(name, node, [self._text[a][0] for a in node.args])
        return name

    def __getitem__(self, k: int) -> str:
        """A node, as it is read where it stands alone."""
        return self._text[k][0]

    def _stated(self, k, text):
        """The name of what a statement computes."""
        self._named += 1
        name = f"t{self._named}"
        kind = self.language.kinds.get(self.graph.nodes[k].kind, "")
        self.lines.append(self.language.statement.format(kind=kind, name=name, value=text))
        return name

    def _operand(self, k, least):
        """An operand, in parentheses where it binds weaker than `least`."""
        text, order = self._text[k]
        return text if order >= least else f"({text})"

    def _expression(self, k):
        """(text, how strongly it binds) of an operation on its operands."""
        node = self.graph.nodes[k]
        op, args = node.op, node.args

        if k in self.known:
            return self.known[k], _ATOM

        if op == "constant":
            text = self.language.number(self.graph.values[k])
            return text, _SIGNS if text.startswith("-") else _ATOM

        if op == "leaf":
            return self.places.leaf(node.about), _ATOM

        if op in _INFIX:
            order = _INFIX[op]
            return f"{self._operand(args[0], order)} {op} {self._operand(args[1], order + 1)}", order

        if op == "neg":
            return f"-{self._operand(args[0], _ATOM)}", _SIGNS

        texts = [self._text[a][0] for a in args]

        if op == "select":
            return self.language.select.format(*texts), _ATOM

        if op == "found":
            return f"{texts[0]}[{node.about}]", _ATOM

        if op == "along":
            return self._text[args[0]]

        if op in ("load", "interval"):
            self.calls.add(op)
            return self.places.look_up(self.graph, node, texts), _ATOM

        name = self.language.calls.get(op, op)

        if not name:
            raise Untraceable(f"{op} cannot be written so")

        self.calls.add(name)
        return f"{name}({', '.join(texts)})", _ATOM
