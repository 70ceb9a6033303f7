"""x' = f of one scene in C99, traced: what stands for the kernel in the scene's own code.

Where a guard does not hold, a branch would go otherwise than where the kernel was traced: the kernel as it is
written, translated by `program`, is called.
"""

from dataclasses import dataclass

from .c99 import C99
from .graph import Graph
from .places import GIVEN_WORK, KEPT_WORK, PREPARED, Everywhere, places, places_of, tunable
from .record import Guard, Tracer
from .searches import VALUES
from .symbols import Symbol
from .write import Body, Places

NAME = "traced_rates"
"""What the function is called in C."""

HEAD = f"static int32_t {NAME}(const Run *run)"
"""Its declaration; a Run has the buffers of an instance."""


@dataclass(frozen=True)
class Traced:
    """x' = f of one scene.

    calls : functions in C that it calls. lines : its statements, in which `{kernel}` is what is called where
    a guard fails. operations : how many it does. guards : what it rests on. graph : of all that.
    """

    calls: set[str]
    lines: list[str]
    operations: int
    guards: list[Guard]
    graph: Graph

    def text(self, kernel: str) -> str:
        """The function in C. kernel : the function that does all where a guard fails."""
        inside = "\n".join(f"    {line}" if line else "" for line in self.lines).replace("{kernel}", kernel)
        return f"{HEAD}\n{{\n{inside}\n}}"

    def failing(self, m, d) -> set[str]:
        """Where in the kernels the branches are that go otherwise in a run's present state."""
        buffers = {"reals": m.reals_buffer, "state": d.state_buffer, "work": d.work_buffer, "u": d.u_buffer}
        found = self.graph.values_at([guard.node for guard in self.guards], buffers, VALUES)
        return {guard.place for guard in self.guards if bool(found[guard.node]) is not guard.holds}


def trace_rates(instance) -> Traced:
    """`rates.evaluate_now` of the scene of an instance, traced at its state. Raises Untraceable."""
    model = instance.model
    of_state = Everywhere()
    free = tunable(model)
    tracer = Tracer(
        instance.m,
        instance.d,
        {"reals": free, "state": of_state, "work": places_of(model, GIVEN_WORK), "u": of_state},
        {"reals": free, "state": places_of(model, PREPARED)},
    )
    known = _prepared(tracer, model) if model.of_causality("constant") else {}
    status = tracer.run("dynamics.rates", "evaluate_now")
    return _written_out(tracer, model, status, known)


def _prepared(tracer, model):
    """What follows from constants alone: place in the state -> node, all that stays of a run of `prepare`,
    with its guards.
    """
    tracer.run("prepare", "prepare")
    state = tracer.buffers["state"]
    of_prepared = places_of(model, PREPARED)
    known = [j for j, value in state.now.items() if j in of_prepared and not isinstance(value, Symbol)]
    state.now = {j: state.initial[j] for j in known}
    tracer.buffers["work"].now = {}
    return {j: tracer.node_of(state.initial[j]) for j in known}


def _written_out(tracer, model, status, known):
    """The C of what was traced. known : what stands in the state already."""
    graph = tracer.graph
    of_work = places_of(model, KEPT_WORK)
    stores = [("state", j, k) for j, k in tracer.written("state").items() if known.get(j) != k]
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
        counted = f"run->work[{places(model, 'generic_evaluations').start}] += 1.0;"
        lines.append(f"const int holds = {' & '.join(conditions)};")
        lines += ["", "if (!holds) {", f"    {counted}", "    return {kernel}(run);", "}", ""]

    lines += [f"{_read((buffer, j))} = {body[k]};" for buffer, j, k in stores]
    lines.append(f"return {status};")
    return Traced(body.calls, lines, len(needed), guards, graph)


def _read(place):
    """What stands at a place of a buffer."""
    return f"run->{place[0]}[{place[1]}]"


def _looked_up(graph, node, operands):
    """A number of a table, or where in a table one is searched."""
    if node.op == "interval":
        first, knots, at = node.about
        return f"({at} + left_knot(run->reals + {first}, 0, {knots}, {operands[0]}))"

    buffer, first, _ = node.about
    return f"run->{buffer}[{first} + {operands[0]}]"
