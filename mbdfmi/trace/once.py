"""What a trace computes that does not change in a run: from parameters, and what is prepared of them, alone.

It is computed when a trace is first called in a step of communication, and kept in `run->once`; so are the
guards that rest on nothing else. Parameters that stay tunable then cost hardly more than those bound. What
changes seldom (`places.SELDOM`) is taken for such too: where a kernel writes to it, all is forgotten.
"""

from collections.abc import Callable, Iterable, Sequence
from typing import Any

from .c99 import C99
from .graph import REAL, Graph
from .places import PREPARED, SELDOM, places_of
from .record import Guard
from .write import Body, Places

_PLACE = "run->once[{once} + %d]"
"""Where a number is kept; in the first place, whether guards hold: 1, -1, and 0 where that is not known
yet."""


def stillness(model) -> Callable[[Any], bool]:
    """Whether a leaf, by its name, does not change while a model runs."""
    of_state = places_of(model, (*PREPARED, *SELDOM))
    return lambda about: about[0] == "reals" or (about[0] == "state" and about[1] in of_state)


def still_nodes(graph: Graph, is_still: Callable[[Any], bool]) -> list[bool]:
    """Of each node whether it follows from what does not change alone."""
    found: list[bool] = []

    for node in graph.nodes:
        if node.op == "leaf":
            found.append(is_still(node.about))
        elif node.op in ("load", "interval", "carried", "solve"):
            found.append(False)
        else:
            found.append(all(found[a] for a in node.args))

    return found


FORGOTTEN = "forget_once"
"""What forgets it, in C: a macro that takes the run."""


def forgetting(places: Iterable[int]) -> str:
    """That macro. places : where the numbers of each trace begin."""
    kept = [f"(run)->once[{place}] = " for place in places]
    return (
        f"#define {FORGOTTEN}(run) ({''.join(kept)}0.0)"
        if kept
        else f"#define {FORGOTTEN}(run) ((void)(run))"
    )


class Once:
    """What is computed once of what some nodes need. guards : all that a trace rests on.

    texts : node -> how it is read in C, of what is kept. count : places that are taken. moving : guards that
    are asked in every call.
    """

    def __init__(
        self,
        graph: Graph,
        wanted: Iterable[int],
        guards: Sequence[Guard],
        is_still: Callable[[Any], bool],
        reading: Places,
    ):
        self.graph = graph
        self.reading = reading
        still = still_nodes(graph, is_still)
        self.moving = [guard for guard in guards if not still[guard.node]]
        self._guards = {guard.node: guard for guard in guards if still[guard.node]}
        moving = [*wanted, *(guard.node for guard in self.moving)]
        needed = [k for k in graph.needed(moving) if not still[k]]
        used = {a for k in needed for a in graph.nodes[k].args}.union(moving)
        self._kept = sorted(k for k in used if still[k] and self._is_worth_it(k))
        self.texts = {k: _PLACE % (place + 1) for place, k in enumerate(self._kept)}
        self.count = 1 + len(self._kept) if self._kept or self._guards else 0

    def _is_worth_it(self, k):
        """Whether to read a number costs less than to compute it."""
        node = self.graph.nodes[k]
        plain = node.op in ("constant", "leaf") or node.kind != REAL
        return not plain and not (node.op in ("neg", "abs") and self.graph.nodes[node.args[0]].op == "leaf")

    def lines(self) -> list[str]:
        """Statements that compute it."""
        body = Body(self.graph, [*self._kept, *self._guards], C99, self.reading)
        holding = [
            f"(int)({body[k]})" if guard.holds else f"(int)!({body[k]})" for k, guard in self._guards.items()
        ]
        holds = f"({' & '.join(holding)}) ? 1.0 : -1.0" if holding else "1.0"
        kept = [f"{self.texts[k]} = {body[k]};" for k in self._kept]
        return [*body.lines, *kept, f"{_PLACE % 0} = {holds};"]

    def called(self, name: str, counted: str) -> list[str]:
        """Statements at the beginning of a trace. name : of the function of `lines`. counted : the statement
        where a guard fails.
        """
        if not self.count:
            return []

        known = ["if (run->once[{once}] == 0.0) {", f"    {name}(run);", "}", ""]
        fails = ["if (run->once[{once}] < 0.0) {", f"    {counted}", "    return {kernel};", "}", ""]
        return [*known, *(fails if self._guards else [])]
