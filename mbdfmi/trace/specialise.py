"""Kernels of one scene in C99, traced: what stands for them in the scene's own code.

Where a guard does not hold, a branch would go otherwise than where the kernel was traced: the kernel as it is
written, translated by `program`, is called.
"""

from collections.abc import Callable, Collection, Iterable, Sequence
from dataclasses import dataclass, replace
from types import FunctionType

from ..kernels import entry
from ..kernels.dynamics import rates
from ..kernels.steppers import control, jacobian
from ..steppers import STEPPERS
from .c99 import C99
from .derivatives import forward
from .graph import Graph, Untraceable
from .once import Once, stillness
from .places import (
    COMMANDED,
    GIVEN_WORK,
    KEPT_WORK,
    PREPARED,
    SELDOM,
    STILL_WORK,
    TIME_WORK,
    Everywhere,
    places,
    places_of,
    tunable,
)
from .plain import plain_function
from .record import Guard, Tracer
from .searches import VALUES
from .solutions import text_in_c
from .sufficient import sufficient
from .symbols import Symbol
from .write import Body, Places

PROJECTIONS, JACOBIANS, OUTPUTS = range(3)
"""Places in `generic_calls`."""


@dataclass(frozen=True)
class Traced:
    """A kernel of one scene.

    kernel : the function that it stands for. name : in C. calls : functions in C that it calls. lines : its
    statements, in which `{kernel}` is the call where a guard fails, `{before}` that of what is called first,
    and `{once}` the place of its own in `once`. operations : how many it does. ways : through it, the
    condition (a node) of each and what it rests on; the first is gone whose condition holds. graph : of all
    that. more : what it takes beside the run, (type, name) each. before : the kernel that is called first.
    spent : evaluations that it stands for, of a Jacobian. once : what it computes once, if anything, and how
    many places that takes.
    """

    kernel: FunctionType
    name: str
    calls: set[str]
    lines: list[str]
    operations: int
    ways: Sequence[tuple[int, Sequence[Guard]]]
    graph: Graph
    more: tuple[tuple[str, str], ...] = ()
    before: FunctionType | None = None
    spent: int = 0
    once: tuple[Sequence[str], int] = ((), 0)

    @property
    def guards(self) -> list[Guard]:
        """What it rests on, of all ways."""
        return [guard for _, way in self.ways for guard in way]

    @property
    def head(self) -> str:
        """Its declaration; a Run has the buffers of an instance."""
        more = "".join(f", {kind}{name}" for kind, name in self.more)
        return f"static int32_t {self.name}(const Run *run{more})"

    def text(self, kernel: str, before: str = "", place: int = 0) -> str:
        """The function in C, behind that of what it computes once. kernel : the function that does all where
        a guard fails. before : the call of `before`. place : of its own in `once`.
        """
        given = ", ".join(["run", *(name for _, name in self.more)])
        inside = _inside(self.lines).replace("{kernel}", f"{kernel}({given})").replace("{before}", before)
        text = f"{self.head}\n{{\n{inside}\n}}"

        if self.once[1]:
            first = f"static void {self.name}_once(const Run *run)\n{{\n{_inside(self.once[0])}\n}}"
            text = f"{first}\n\n{text}"

        return text.replace("{once}", str(place))

    def failing(self, m, d) -> set[str]:
        """Where in the kernels the branches are that go otherwise in a run's present state."""
        buffers = {"reals": m.reals_buffer, "state": d.state_buffer, "work": d.work_buffer, "u": d.u_buffer}
        buffers |= {"m": m, "d": d}
        wanted = [guard.node for guard in self.guards] + [condition for condition, _ in self.ways]
        found = self.graph.values_at(wanted, buffers, VALUES)
        way = next((guards for condition, guards in self.ways if found[condition]), None)

        if way is None:
            return {f"{self.kernel.__module__}.{self.kernel.__name__}, its ways"}

        return {guard.place for guard in way if bool(found[guard.node]) is not guard.holds}


def indented(lines: Iterable[str]) -> list[str]:
    """Lines of a block."""
    return [f"    {line}" if line else "" for line in lines]


def _inside(lines):
    return "\n".join(indented(lines))


def tracer_of(instance, work: Sequence[str] | None = GIVEN_WORK) -> Tracer:
    """A tracer at the state of an instance. State, inputs and tunable parameters are given, and some work
    arrays; None: all that change in a run.
    """
    model = instance.model
    free, anywhere = tunable(model), Everywhere()
    of_work = (
        set(range(model.n_work)) - places_of(model, STILL_WORK) if work is None else places_of(model, work)
    )
    return Tracer(
        instance.m,
        instance.d,
        {"reals": free, "state": anywhere, "work": of_work, "u": anywhere},
        {"reals": free, "state": places_of(model, PREPARED)},
    )


def trace_rates(instance) -> Traced:
    """`rates.evaluate_now` of the scene of an instance, traced at its state. Raises Untraceable."""
    tracer = tracer_of(instance)
    known = prepared(tracer, instance.model)
    status = tracer.run("dynamics.rates", "evaluate_now")
    writing = Writing(tracer, instance, known, kept(instance))
    return writing.one_way(rates.evaluate_now, "traced_rates", status, writing.left("generic_evaluations"))


def trace_outputs(instance) -> Traced:
    """`entry.compute_outputs`, likewise. Raises Untraceable."""
    tracer = tracer_of(instance, COMMANDED)
    known = prepared(tracer, instance.model)
    y = [0.0] * instance.model.n_y
    status = tracer.run("entry", "compute_outputs", y)
    writing = Writing(tracer, instance, known, (*TIME_WORK, "held"))
    writing.stores += [(f"y[{k}]", tracer.node_of(value)) for k, value in enumerate(y)]
    counted = writing.left("generic_calls", OUTPUTS)
    return writing.one_way(
        entry.compute_outputs, "traced_outputs", status, counted, more=(("double *", "y"),)
    )


def trace_jacobian(instance) -> Traced:
    """`jacobian.find_jacobian` by exact derivatives of x' = f, traced likewise. Raises Untraceable."""
    model, m = instance.model, instance.m
    tracer = tracer_of(instance)
    tracer.slopes, tracer.by_time = True, False
    prepared(tracer, model)
    status = tracer.run("dynamics.rates", "evaluate_now")
    graph = tracer.graph
    rates_of_x = [tracer.node_at("work", j) for j in places(model, "x_rate")]
    one, zero = graph.constant(1.0), graph.constant(0.0)
    columns = forward(graph, rates_of_x, [{graph.leaf(("state", j), 0.0): one} for j in places(model, "x")])
    found = {(i, j): k for j, column in enumerate(columns) for i, k in enumerate(column) if k is not None}
    at = elements(m)

    if not found.keys() <= at.keys():
        raise Untraceable("x' depends on states that the structure of its Jacobian does not know of")

    values = {place: found.get(where, zero) for where, place in at.items()}
    writing = Writing(tracer, instance, {}, ())
    first = places(model, "jacobian").start
    writing.stores = [(f"run->work[{first + k}]", values.get(k, zero)) for k in range(m.n_jacobian)]
    # as many evaluations as differences take: what they spend decides between methods
    spent = int(sum(m.colour_width[k] for k in range(m.n_colour)))
    writing.last = [f"run->state[{places(model, 'evaluations').start}] += {float(spent)!r};"]
    counted = writing.left("generic_calls", JACOBIANS)
    more = (("int32_t ", "row"),)
    name = "traced_jacobian"
    return replace(
        writing.one_way(jacobian.find_jacobian, name, status, counted, more, control.weigh), spent=spent
    )


def elements(m):
    """(row, column) of J -> where it stands in `jacobian`, of all that differences find."""
    found = {}

    for b in range(m.n_block):
        for k in range(m.block_column[b], m.block_column[b] + m.block_columns[b]):
            e, to = m.column_element[k], m.column_row[k]
            width = m.element_width[e]

            for c in range(width):
                column = m.place_x[m.block_place[b] + m.element_first[e] + c]

                for i in range(m.block_size[to]):
                    row = m.place_x[m.block_place[to] + i]
                    found[int(row), int(column)] = int(m.element_value[e] + width * i + c)

    return found


def kept(instance) -> tuple[str, ...]:
    """Work arrays that the stepper of an instance reads after an evaluation: explicit pairs alone ask for
    shares of rows.
    """
    others = [STEPPERS[name].number for name in ("rk4", "ros2", "gauss", "radau")]
    pairs = instance.m.integrator not in others
    return tuple(name for name in KEPT_WORK if pairs or name != "least_share")


def prepared(tracer, model):
    """What follows from constants alone: place in the state -> node, all that stays of a run of `prepare`,
    with its guards.
    """
    if not model.of_causality("constant"):
        return {}

    tracer.run("prepare", "prepare")
    state = tracer.buffers["state"]
    of_prepared = places_of(model, PREPARED)
    known = [j for j, value in state.now.items() if j in of_prepared and not isinstance(value, Symbol)]
    state.now = {j: state.initial[j] for j in known}
    tracer.buffers["work"].now = {}
    return {j: tracer.node_of(state.initial[j]) for j in known}


class Writing:
    """Writes what a tracer has recorded.

    known : place in the state -> node of what stands there already. names : work arrays that are kept.
    stores : (place in C, node) of all that is written; last : statements behind them.
    """

    def __init__(self, tracer: Tracer, instance, known: dict[int, int], names: Sequence[str]):
        self.tracer = tracer
        self.model = instance.model
        self.last: list[str] = []
        self.stores = self.written(known, names)

    def written(self, known, names) -> list[tuple[str, int]]:
        """What the tracer has written by now."""
        of_work = places_of(self.model, names)
        state, work = self.tracer.written("state").items(), self.tracer.written("work").items()
        found = [(read(("state", j)), k) for j, k in state if known.get(j) != k]
        seldom = places_of(self.model, SELDOM)

        # what is computed once of it would not be forgotten
        if any(j in seldom for j, _ in state):
            raise Untraceable("which rows are redundant, or what is lent, changes")

        return found + [(read(("work", j)), k) for j, k in work if j in of_work]

    def left(self, counter: str, k: int = 0) -> str:
        """The statement that counts what is left to the generic kernel."""
        return f"run->work[{places(self.model, counter).start + k}] += 1.0;"

    def first(
        self, wanted: Sequence[int], stores: Sequence[tuple[str, int]], known: Collection[int] = ()
    ) -> list[int]:
        """Nodes that are read before they are written over. known : what is read elsewhere."""
        graph = self.tracer.graph
        over = {place for place, _ in stores}
        needed = (graph.nodes[k] for k in graph.needed(wanted, known))
        leaves = {node.about for node in needed if node.op == "leaf"}
        return [graph.leaf(about, 0.0) for about in leaves if read(about) in over]

    def one_way(
        self,
        kernel: Callable,
        name: str,
        status: int,
        counted: str,
        more: tuple[tuple[str, str], ...] = (),
        before: Callable | None = None,
    ) -> Traced:
        """What has no branches that guards do not stand for. counted : the statement where one fails."""
        graph, stored = self.tracer.graph, [k for _, k in self.stores]
        is_still = stillness(self.model)
        guards = sufficient(graph, self.tracer.guards.values(), stored, is_still)
        once = Once(graph, stored, guards, is_still, READING)
        moving = stored + [guard.node for guard in once.moving]
        body = Body(graph, moving, C99, READING, self.first(moving, self.stores, once.texts), (), once.texts)
        lines = [f"(void){argument};" for _, argument in more if before and argument == "row" and not guards]
        lines += once.called(f"{name}_once", counted)
        lines += [*body.lines, *held(once.moving, body.__getitem__, "holds", counted)]
        lines += ["{before};"] if before else []
        lines += [f"{place} = {body[k]};" for place, k in self.stores]
        lines += [*self.last, f"return {status};"]
        return Traced(
            plain_function(kernel),
            name,
            body.calls,
            lines,
            len(graph.needed(moving, once.texts)),
            [(graph.constant(True), guards)],
            graph,
            more,
            plain_function(before) if before else None,
            once=(once.lines(), once.count) if once.count else ((), 0),
        )


def held(guards: Sequence[Guard], text: Callable[[int], str], name: str, counted: str) -> list[str]:
    """Statements that leave all to the generic kernel where a guard fails. text : of a node. name : of what
    tells it.
    """
    # of whole numbers, which may be joined without a branch each: truths joined so are warned of
    conditions = [f"(int)({text(g.node)})" if g.holds else f"(int)!({text(g.node)})" for g in guards]

    if not conditions:
        return []

    lines = [f"const int {name} = {' & '.join(conditions)};", "", f"if (!{name}) {{", f"    {counted}"]
    return [*lines, "    return {kernel};", "}", ""]


def read(place):
    """What stands at a place of a buffer."""
    return f"run->{place[0]}[{place[1]}]"


def _looked_up(graph, node, operands):
    """A number of a table, or where in a table one is searched."""
    if node.op == "interval":
        first, knots, at = node.about
        return f"({at} + left_knot(run->reals + {first}, 0, {knots}, {operands[0]}))"

    buffer, first, _ = node.about
    return f"run->{buffer}[{first} + {operands[0]}]"


READING = Places(read, _looked_up, False, text_in_c)
"""How leaves are read from a Run."""
