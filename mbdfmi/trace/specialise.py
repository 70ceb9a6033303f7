"""A kernel of one scene in C99, with the signature and the effect of the generic one that it stands for.

Where a guard does not hold, a branch would go otherwise than where the kernel was traced: the generic one is
called.
"""

from dataclasses import dataclass

from ..kernels.language import APART
from .c99 import C99, helpers
from .graph import Graph
from .places import GIVEN_WORK, KEPT_WORK, PREPARED, Everywhere, places, places_of, tunable
from .plain import ROOM
from .record import Guard, Tracer
from .searches import VALUES
from .write import Body, Places

GENERIC = "_generic"
"""What a library calls the generic kernel that a traced one stands for, behind its symbol."""

_ARGUMENTS = ("m_ints", "m_reals", "d_ints", "d_state", "d_work", "d_u")
_ARRAYS = {"reals": "m_reals", "state": "d_state", "work": "d_work", "u": "d_u"}


@dataclass(frozen=True)
class Traced:
    """A kernel of one scene.

    symbol : what it is called in a library. text : its functions in C. operations : how many it does.
    guards : what it rests on. graph : of all that.
    """

    symbol: str
    text: str
    operations: int
    guards: list[Guard]
    graph: Graph

    def failing(self, m, d) -> set[str]:
        """Where in the kernels the branches are that go otherwise in a run's present state."""
        buffers = {"reals": m.reals_buffer, "state": d.state_buffer, "work": d.work_buffer, "u": d.u_buffer}
        found = self.graph.values_at([guard.node for guard in self.guards], buffers, VALUES)
        return {guard.place for guard in self.guards if bool(found[guard.node]) is not guard.holds}


def symbol_of(module: str, kernel: str) -> str:
    """What a kernel is called in a library."""
    name = f"{ROOM}.{module}.{kernel}".replace(".", "_")
    assert name in APART, name
    return name


def trace_rates(instance, bound=()) -> Traced:
    """`rates.evaluate_now` of the scene of an instance, traced at its state.

    bound : places of `reals` that are parameters and yet do not change. Raises Untraceable.
    """
    model = instance.model
    of_state = Everywhere()
    free = tunable(model) - set(bound)
    tracer = Tracer(
        instance.m,
        instance.d,
        {"reals": free, "state": of_state, "work": places_of(model, GIVEN_WORK), "u": of_state},
        {"reals": free, "state": places_of(model, PREPARED)},
    )
    status = tracer.run("dynamics.rates", "evaluate_now")
    return _written_out(tracer, model, symbol_of("dynamics.rates", "evaluate_now"), status, KEPT_WORK)


def _written_out(tracer, model, symbol, status, kept):
    """The C of what was traced; `kept`: work arrays that someone reads afterwards."""
    graph = tracer.graph
    of_work = places_of(model, kept)
    stores = [("state", j, k) for j, k in tracer.written("state").items()]
    stores += [("work", j, k) for j, k in tracer.written("work").items() if j in of_work]
    guards = list(tracer.guards.values())
    wanted = [k for _, _, k in stores] + [guard.node for guard in guards]
    needed = graph.needed(wanted)
    stored = {(buffer, j) for buffer, j, _ in stores}
    first = [k for k in needed if graph.nodes[k].op == "leaf" and graph.nodes[k].about in stored]
    body = Body(graph, wanted, C99, Places(_read, _looked_up, False), first)
    # of whole numbers, which may be joined without a branch each: truths joined so are warned of
    conditions = [f"(int)({body[g.node]})" if g.holds else f"(int)!({body[g.node]})" for g in guards]
    lines = [*body.lines]

    if conditions:
        lines.append(f"const int holds = {' & '.join(conditions)};")
        counted = f"d_work[{places(model, 'generic_evaluations').start}] += 1.0;"
        called = f"return {symbol}{GENERIC}({', '.join(_names())});"
        lines += ["", "if (!holds) {", f"    {counted}", f"    {called}", "}", ""]

    lines += [f"{_ARRAYS[buffer]}[{j}] = {body[k]};" for buffer, j, k in stores]
    lines += [f"*status = {status};", "return 0;"]
    inside = "\n".join(f"    {line}" if line else "" for line in lines)
    parts = [*helpers(body.calls), f"{_head(symbol + GENERIC)};", f"{_head(symbol)};"]
    parts.append(f"{_head(symbol)}\n{{\n{_unused(inside)}{inside}\n}}")
    return Traced(symbol, "\n\n".join(parts), len(needed), guards, graph)


def _read(place):
    """What stands at a place of a buffer."""
    return f"{_ARRAYS[place[0]]}[{place[1]}]"


def _looked_up(graph, node, operands):
    """A number of a table, or where in a table one is searched."""
    if node.op == "interval":
        first, knots, at = node.about
        return f"({at} + left_knot({_ARRAYS['reals']} + {first}, 0, {knots}, {operands[0]}))"

    buffer, first, _ = node.about
    return f"{_ARRAYS[buffer]}[{first} + {operands[0]}]"


def _names():
    return ["status", "excinfo", *_ARGUMENTS]


def _unused(inside):
    """Arguments that a scene has no use for."""
    return "".join(f"    (void){name};\n" for name in _names() if name not in inside)


def _head(symbol):
    given = [
        f"const int64_t *{name}" if name.endswith("ints") else f"double *restrict {name}"
        for name in _ARGUMENTS
    ]
    return f"int32_t {symbol}(int64_t *status, void **excinfo, {', '.join(given)})"


HEAD = "#include <math.h>\n#include <stdint.h>\n"
"""What a file with traced kernels begins with."""
