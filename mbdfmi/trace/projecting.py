"""The projection of one scene onto its constraints, traced: what stands for `projection.project`.

Newton's method ends by values. Nearly always it does so at once, or after one or two corrections, so these
ways are traced, and what they have in common is done once. Where more are needed, the same statements begin
anew where the first correction has led: a loop, which forgets nothing but that correction. What guards do
not allow is the kernel's; until positions are found nothing is written, so it begins where this has begun.
"""

import math
from typing import NamedTuple

from ..kernels.dynamics import projection
from .c99 import C99
from .graph import Untraceable
from .once import Once, stillness
from .places import GIVEN_WORK, places, places_of
from .plain import plain_function
from .record import TOLD, Guard, Tracer
from .specialise import (
    PROJECTIONS,
    READING,
    Traced,
    Writing,
    held,
    indented,
    kept,
    prepared,
    tracer_of,
)
from .sufficient import sufficient
from .symbols import Symbol
from .write import Body

NAME = "traced_projection"
CLOSING = "dynamics.projection.close_gaps"
LIMIT = "evaluation_limit"

MOST_CORRECTIONS = 2
"""Corrections of positions in one pass, where that is not too long: steps of fixed length take one at most,
nearly all others two."""

MOST_PASSES = 10
"""How often they are gone through: far from where the kernel gives up for gaps that do not shrink."""

UNIT_E, MOVE = TOLD


class _Way(NamedTuple):
    """A way through the kernel. gaps : nodes of the largest gap before each correction, and at the end."""

    status: int
    guards: dict[int, Guard]
    gaps: list[int]
    stores: list[tuple[str, int]]


class _Passes:
    """What one pass leaves to the next: places that the first correction changes, as (buffer, place).

    begin, leave : nodes of what stands there before the first pass, and after the first correction of one.
    carried : nodes of what a pass finds there.
    """

    def __init__(self, tracer: Tracer, limit: int):
        self.tracer = tracer
        self.limit = ("work", limit)
        self.places: list[tuple[str, int]] = []
        self.begin: list[int] = []
        self.leave: list[int] = []
        self.carried: list[int] = []
        self._is_first = True

    def look(self):
        """Finds the places. Behind it the kernel is to be run anew."""
        before: dict[int, int] = {}

        def begun():
            before.update(self.tracer.written("state"))

        def moved():
            if not self.places:
                now = self.tracer.written("state").items()
                self.places = [*(("state", j) for j, k in now if before.get(j) != k), self.limit]

        self.tracer.after = {UNIT_E: begun, MOVE: moved}

    def follow(self):
        """From now on the kernel finds there what the pass before has left."""
        self.tracer.after = {UNIT_E: self._begun, MOVE: self._moved}

    def next_way(self):
        """Another way through the kernel begins."""
        self._is_first = True

    def _begun(self):
        tracer = self.tracer
        self.begin = [tracer.node_at(*place) for place in self.places]
        self.carried = [tracer.graph.carried(place, k) for place, k in zip(self.places, self.begin)]

        for (buffer, j), k in zip(self.places, self.carried):
            tracer.buffers[buffer].now[j] = Symbol(tracer, k)

    def _moved(self):
        if self._is_first:
            self.leave = [self.tracer.node_at(*place) for place in self.places]

        self._is_first = False

    def names(self) -> dict[int, str]:
        """Node of what is carried -> its name in C."""
        return {k: f"x{n}" for n, k in enumerate(self.carried, 1)}

    def next_pass(self, body: Body) -> list[str]:
        """Statements at the end of a pass."""
        names = self.names().values()
        lines = body.more(self.leave)
        # all are found before one is changed
        lines += [f"const double next_{name} = {body[k]};" for name, k in zip(names, self.leave)]
        return [*lines, *(f"{name} = next_{name};" for name in names)]


class _Closing:
    """Tells Newton's method to end after some corrections, and finds the gaps by which it does so."""

    def __init__(self, tracer: Tracer, corrections: int):
        self.graph = tracer.graph
        self.corrections = corrections
        self.gaps: list[int] = []

    def __call__(self, k: int, place: str) -> bool | None:
        if not place.startswith(CLOSING):
            return None

        node = self.graph.nodes[k]
        a, b = node.args

        if node.op == "<=" and self.graph.known(b) == projection.ROUNDING:
            if a not in self.gaps:
                self.gaps.append(a)

            return self.gaps.index(a) == self.corrections

        # before the first correction there is nothing that gaps could be smaller than
        if b in self.gaps:
            return False

        return True if a in self.gaps else None


def trace_projection(instance, most: float = math.inf) -> Traced:
    """`projection.project` of the scene of an instance, traced at its state. Raises Untraceable.

    most : operations of a pass that takes more than one correction.
    """
    found = _trace(instance, MOST_CORRECTIONS)
    return found if found.operations <= most else _trace(instance, 1)


def _trace(instance, most_corrections):
    # accelerations come along with the factor, of forces that nobody has found here
    tracer = tracer_of(instance, None)
    known = prepared(tracer, instance.model)
    beginning = dict(tracer.guards)
    writing = Writing(tracer, instance, known, ())
    passes = _Passes(tracer, places(instance.model, LIMIT).start)

    def way(corrections):
        state = {j: tracer.buffers["state"].initial[j] for j in known}
        tracer.begin_anew()
        tracer.buffers["state"].now |= state
        tracer.guards |= beginning
        passes.next_way()
        closing = tracer.told = _Closing(tracer, corrections)
        status = tracer.run("dynamics.projection", "project")
        stores = writing.written(known, (*(name for name in kept(instance) if name != "x_rate"), LIMIT))
        return _Way(status, tracer.guards, closing.gaps, stores)

    passes.look()
    way(1)
    passes.follow()
    ways = [way(corrections) for corrections in range(most_corrections + 1)]
    tracer.told, tracer.after = None, {}

    if any(way.status or len(way.gaps) != k + 1 for k, way in enumerate(ways)):
        raise Untraceable("the projection ends otherwise")

    return _written_out(writing, tracer, ways, passes)


def _written_out(writing, tracer, ways, passes):
    graph = tracer.graph
    ends = [_is_closed(tracer, graph, *way.gaps) for way in ways]
    is_still = stillness(writing.model)
    stored = [[end, *(k for _, k in way.stores)] for end, way in zip(ends, ways)]
    ways = [
        way._replace(guards={g.node: g for g in sufficient(graph, way.guards.values(), each, is_still)})
        for way, each in zip(ways, stored)
    ]
    once = Once(
        graph,
        [k for each in [*stored, passes.begin, passes.leave] for k in each],
        [guard for way in ways for guard in way.guards.values()],
        is_still,
        READING,
    )
    everything = [k for each, way in zip(stored, ways) for k in (*each, *way.guards)]
    rests = [(end, list(way.guards.values())) for end, way in zip(ends, ways)]
    moving = {guard.node for guard in once.moving}
    ways = [way._replace(guards={k: g for k, g in way.guards.items() if k in moving}) for way in ways]
    wanted = [[*each, *way.guards] for each, way in zip(stored, ways)]
    found = {**once.texts, **passes.names()}
    all_wanted = [*(k for each in wanted for k in each), *passes.begin, *passes.leave]
    over = writing.first(all_wanted, [store for way in ways for store in way.stores], once.texts)
    body = Body(graph, passes.begin, C99, READING, over, (), found, all_wanted)
    counted = writing.left("generic_calls", PROJECTIONS)
    begin = [f"double {name} = {body[k]};" for name, k in zip(passes.names().values(), passes.begin)]
    before = [*once.called(f"{NAME}_once", counted), *body.lines, *begin]
    lines: list[str] = []
    done: set[int] = set()

    for n, (end, way) in enumerate(zip(ends, ways)):
        common = set.intersection(*(set(each.guards) for each in ways[n:])) - done
        guards = [guard for k, guard in way.guards.items() if k in common]
        own = [guard for k, guard in way.guards.items() if k not in common | done]
        done |= common
        lines += body.more([end, *common], wanted[n:])
        lines += held(guards, body.__getitem__, f"holds_{n}", counted)
        branch = body.branch(wanted[n])
        block = [*branch.lines, *held(own, branch.text.__getitem__, "closes", counted)]
        block += [f"{place} = {branch.text[k]};" for place, k in way.stores]
        block.append("return 0;")
        lines += [f"if ({body[end]}) {{", *indented(block), "}", ""]

    lines += passes.next_pass(body)
    loop = [f"for (int pass = 0; pass < {MOST_PASSES}; pass++) {{", *indented(lines), "}"]
    lines = [*before, "", *loop, "", counted, "return {kernel};"]
    needed = graph.needed(everything + passes.leave)
    _check(writing, [graph.nodes[k].about for k in needed if graph.nodes[k].op == "leaf"])
    kernel = plain_function(projection.project)
    kept = (once.lines(), once.count) if once.count else ((), 0)
    operations = len(graph.needed(all_wanted, once.texts))
    return Traced(kernel, NAME, body.calls, lines, operations, rests, graph, once=kept)


def _check(writing, leaves):
    """Nothing goes in that a call before has left in scratch."""
    given = places_of(writing.model, (*GIVEN_WORK, LIMIT))

    for buffer, place in leaves:
        if buffer == "work" and place not in given:
            raise Untraceable(f"`{writing.tracer.array_at(buffer, place)}` of the work arrays is read")


def _is_closed(tracer, graph, *gaps):
    """Whether the last of some gaps is at rounding, or no longer shrinks where that is allowed (as in
    `projection.close_gaps`).
    """
    small = graph.comparison("<=", gaps[-1], graph.constant(projection.ROUNDING))

    if len(gaps) == 1:
        return small

    allowed = tracer.node_of(tracer.m.closing_tolerance[0])
    stalls = graph.comparison("<", graph.product(graph.constant(projection.STALLED), gaps[-2]), gaps[-1])
    return graph.either(small, graph.both(stalls, graph.comparison("<=", gaps[-1], allowed)))
