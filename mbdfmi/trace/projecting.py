"""The projection onto the constraints of one scene, traced: what stands for `projection.project` in its own code.

Newton's method ends by values. Nearly always it does so at once, or after one correction, so these two ways
are traced, and what both do is done once; a second correction, and what guards do not allow, is the kernel's.
"""

from typing import NamedTuple

from ..kernels.dynamics import projection
from .c99 import C99
from .graph import Untraceable
from .places import GIVEN_WORK, places_of
from .plain import plain_function
from .record import Guard, Tracer
from .specialise import PROJECTIONS, READING, Traced, Writing, held, kept, prepared, tracer_of
from .write import Body

NAME = "traced_projection"
CLOSING = "dynamics.projection.close_gaps"
LIMIT = "evaluation_limit"


class _Way(NamedTuple):
    """A way through the kernel. gaps : nodes of the largest gap before each correction, and at the end."""

    status: int
    guards: dict[int, Guard]
    gaps: list[int]
    stores: list[tuple[str, int]]


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


def trace_projection(instance) -> Traced:
    """`projection.project` of the scene of an instance, traced at its state. Raises Untraceable."""
    # accelerations come along with the factor, of forces that nobody has found here
    tracer = tracer_of(instance, None)
    known = prepared(tracer, instance.model)
    beginning = dict(tracer.guards)
    writing = Writing(tracer, instance, known, ())
    ways = []

    for corrections in range(2):
        state = {j: tracer.buffers["state"].initial[j] for j in known}
        tracer.begin_anew()
        tracer.buffers["state"].now |= state
        tracer.guards |= beginning
        closing = tracer.told = _Closing(tracer, corrections)
        status = tracer.run("dynamics.projection", "project")
        stores = writing.written(known, (*(name for name in kept(instance) if name != "x_rate"), LIMIT))
        ways.append(_Way(status, tracer.guards, closing.gaps, stores))

    tracer.told = None

    if any(way.status or len(way.gaps) != k + 1 for k, way in enumerate(ways)):
        raise Untraceable("the projection ends otherwise")

    return _written_out(writing, tracer, *ways)


def _written_out(writing, tracer, at_once, corrected):
    graph = tracer.graph
    rounding = graph.constant(projection.ROUNDING)
    closed = graph.comparison("<=", at_once.gaps[0], rounding)
    common = [guard for k, guard in at_once.guards.items() if k in corrected.guards]
    ways = [[guard for k, guard in way.guards.items() if guard not in common] for way in (at_once, corrected)]
    ways[1].append(Guard(_is_done(tracer, graph, *corrected.gaps), True, f"{CLOSING}, at its end"))
    first = [closed, *(guard.node for guard in common)]
    wanted = [
        [k for _, k in way.stores] + [guard.node for guard in guards]
        for way, guards in zip((at_once, corrected), ways)
    ]
    everything = [*first, *wanted[0], *wanted[1]]
    over = writing.first(everything, [*at_once.stores, *corrected.stores])
    body = Body(graph, first, C99, READING, over, wanted)
    counted = writing.left("generic_calls", PROJECTIONS)
    lines = [*body.lines, *held(common, body.__getitem__, "holds", counted)]
    blocks = []

    for way, guards, each in zip((at_once, corrected), ways, wanted):
        branch = body.branch(each)
        block = [*branch.lines, *held(guards, branch.text.__getitem__, "closes", counted)]
        block += [f"{place} = {branch.text[k]};" for place, k in way.stores]
        blocks.append([*block, "return 0;"])

    lines += [f"if ({body[closed]}) {{", *(f"    {line}" for line in blocks[0]), "}", *blocks[1]]
    needed = graph.needed(everything)
    _check(writing, [graph.nodes[k].about for k in needed if graph.nodes[k].op == "leaf"])
    kernel = plain_function(projection.project)
    return Traced(kernel, NAME, body.calls, lines, len(needed), [common, *ways], graph, branch=closed)


def _check(writing, leaves):
    """Nothing goes in that a call before has left in scratch."""
    given = places_of(writing.model, (*GIVEN_WORK, LIMIT))

    for buffer, place in leaves:
        if buffer == "work" and place not in given:
            raise Untraceable(f"`{writing.tracer.array_at(buffer, place)}` of the work arrays is read")


def _is_done(tracer, graph, before, gap):
    """Whether a gap is at rounding, or no longer shrinks where that is allowed (`projection.close_gaps`)."""
    allowed = tracer.node_of(tracer.m.closing_tolerance[0])
    stalls = graph.comparison("<", graph.product(graph.constant(projection.STALLED), before), gap)
    small = graph.comparison("<=", gap, graph.constant(projection.ROUNDING))
    return graph.either(small, graph.both(stalls, graph.comparison("<=", gap, allowed)))
