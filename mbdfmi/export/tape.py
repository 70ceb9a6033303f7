"""The tape of a scene: x' and outputs as one line of operations, by which an FMU finds exact derivatives (fmu_src/tape.h).

It is the trace of the kernels (docs/specialise.md) at a state near the start, in two parts: from the state that
a solver gave to the one that keeps to the constraints, `led`, and from there to x' and outputs. The first is
Newton's step alone, which has the derivative of all of them where the constraints are kept.
"""

from dataclasses import dataclass
from typing import Any

import numpy as np

from ..kernels import exchange
from ..kernels.entry import compute_outputs
from ..kernels.status import OK
from ..run.instance import Instance, SimulationError
from ..trace.derivatives import at_the_trace
from ..trace.graph import Graph, Untraceable
from ..trace.places import PREPARED, Everywhere, places, places_of, tunable
from ..trace.record import Tracer
from ..trace.solutions import gives
from ..trace.symbols import symbol_of

OPERATIONS = {
    "constant": "CONSTANT",
    "leaf": "LEAF",
    "led": "LED",
    "load": "LOAD",
    "interval": "INTERVAL",
    "+": "ADD",
    "-": "SUBTRACT",
    "*": "MULTIPLY",
    "/": "DIVIDE",
    "neg": "NEGATE",
    "abs": "ABSOLUTE",
    "min": "MINIMUM",
    "max": "MAXIMUM",
    "select": "SELECT",
    "not": "NOT",
    "isfinite": "ISFINITE",
    "<": "LESS",
    "<=": "NOT_MORE",
    "==": "EQUAL",
    "!=": "UNEQUAL",
    "real": "REAL",
    "whole": "WHOLE",
    "floor": "FLOOR",
    "sqrt": "SQRT",
    "sin": "SIN",
    "cos": "COS",
    "atan2": "ATAN2",
    "asin": "ASIN",
    "exp": "EXP",
    "log": "LOG",
    "tanh": "TANH",
    "asinh": "ASINH",
    "pow": "POW",
    "copysign": "COPYSIGN",
    "still": "STILL",
    "solve": "SOLVE",
    "found": "FOUND",
}
"""Operations of a trace, and what they are called in C."""

CODE = {name: number for number, name in enumerate(OPERATIONS)}
"""What they are on a tape."""

BUFFERS = ("reals", "state", "u")
"""Buffers that a leaf may stand in."""

LONGEST = 40_000
"""Operations of a tape at most, 0.8 MB."""

MOST_STATES = 160
"""States of a model that is traced at most: what grows beyond them is the time that an export takes."""

BEFORE = 1e-2
"""s, how far a run goes before it is traced: what is zero at the start alone is to be no zero of the tape."""

STRIDES = (1e-4, 2e-5)
"""Of differences that a derivative along a random direction is compared with."""

BESIDE = 3e-3
"""Of the states' sizes, how far beside the run it is traced, lest a symmetry be taken for a law."""

AGREEMENT, SMALL_PART, DOUBT, NOISE = 1e-5, 1e-3, 10.0, 1e-13
"""How far it may be off: parts of itself, of this part of the largest, of what the differences differ by; what of the
values is rounding.
"""


@dataclass(frozen=True)
class Tape:
    """operations : rows (operation, operands and places). constants : numbers. guards : rows (operation, whether it holds),
    those of the way to `led` first, of which there are n_led. rates, outputs : operations of x' and y.
    """

    operations: np.ndarray
    constants: np.ndarray
    guards: np.ndarray
    n_led: int
    rates: np.ndarray
    outputs: np.ndarray

    @property
    def sizes(self) -> tuple[int, int, int, int, int]:
        """As they stand in the head of an FMU's resource."""
        results = len(self.rates) + len(self.outputs)
        return len(self.operations), len(self.constants), len(self.guards), self.n_led, results

    def data(self) -> bytes:
        """As it lies there, a multiple of 8 bytes."""
        whole = [self.operations, self.guards, self.rates, self.outputs]
        numbers = np.concatenate([part.ravel() for part in whole]).astype("<i4")
        found = self.constants.astype("<f8").tobytes() + numbers.tobytes()
        return found + b"\0" * (-len(found) % 8)


NONE = Tape(*(np.zeros(0),) * 3, 0, *(np.zeros(0),) * 2)
"""Of a model that is not traced."""


def tape(model) -> Tape:
    """The tape of a model, kept by its GUID; NONE where it has none: too many states, commanded motions, or what no trace can follow."""
    if model.guid not in _known:
        if len(_known) >= MOST_KNOWN:
            _known.clear()

        _known[model.guid] = _traced(model)

    return _known[model.guid]


MOST_KNOWN = 16
"""Tapes that are kept for a scene's next export."""

_known: dict[str, Tape] = {}


def _traced(model):
    if not 0 < model.n_x <= MOST_STATES or model.n_command:
        return NONE

    try:
        instance = _moved(model)
        trace = _Trace(instance)
        found = trace.written()
    except (Untraceable, SimulationError):
        return NONE

    return found if len(found.operations) <= LONGEST and trace.agrees(instance) else NONE


def _moved(model):
    """An instance shortly after its start, or there where it cannot go on, and a little beside that."""
    instance = Instance(model)

    try:
        instance.step(BEFORE)
    except SimulationError:
        instance = Instance(model)

    m, d = instance.m, instance.d
    x = d.x.copy()
    d.x[:] += BESIDE * m.x_nominal * np.random.default_rng(2).standard_normal(len(x))

    if exchange.lead(m, d) != OK:
        d.x[:] = x

    return instance


class _Trace:
    """What the kernels did on the symbols of an instance."""

    def __init__(self, instance):
        model = instance.model
        instance.d.work_buffer[:] = 0.0  # what a step left there is nothing to go on from
        free, anywhere = tunable(model), Everywhere()
        self.tracer = tracer = Tracer(
            instance.m,
            instance.d,
            {"reals": free, "state": anywhere, "u": anywhere},
            {"reals": free, "state": places_of(model, PREPARED)},
            exact=False,
        )
        tracer.by_time = False
        self.x = places(model, "x")
        self.n_u = model.n_u
        tracer.run("dynamics.rates", "set_time", 0.0)
        self._lead(instance.m.n_row)
        self.led = [tracer.node_at("state", j) for j in self.x]
        self.n_led = len(tracer.guards)
        self._begin_anew()
        tracer.run("dynamics.rates", "evaluate", 0.0)
        self.rates = [tracer.node_at("work", j) for j in places(model, "x_rate")]
        y = [0.0] * model.n_y
        tracer.run("entry", "compute_outputs", y)
        self.outputs = [tracer.node_of(value) for value in y]

    @property
    def graph(self) -> Graph:
        return self.tracer.graph

    def _lead(self, n_row):
        """`projection.project`, of its iterations one."""
        tracer = self.tracer
        d: Any = tracer.d
        tracer.run("motion.drives", "prescribe")
        tracer.run("dynamics.projection", "unit_E")

        if n_row == 0:
            return

        tracer.run("dynamics.projection", "see_rows")
        tracer.run("dynamics.forward", "factor_rows_here", True)

        for row in range(n_row):
            d.row_rhs[row] = -d.row_gap[row]

        tracer.run("dynamics.forward", "correct")
        tracer.run("dynamics.projection", "move_by_change", 1.0)
        tracer.run("dynamics.projection", "see_rows")
        tracer.run("dynamics.forward", "factor_rows_here", False)
        tracer.run("dynamics.forward", "exchange_rows")
        tracer.run("dynamics.projection", "project_velocities")

    def _begin_anew(self):
        """The state that was led to is given from here on."""
        state = self.tracer.buffers["state"]

        for j, node in zip(self.x, self.led):
            leaf = self.graph.leaf(("led", j - self.x.start), self.graph.values[node])
            state.now[j] = symbol_of(self.tracer, leaf)

    def written(self) -> Tape:
        """The tape of it."""
        graph, guards = self.graph, list(self.tracer.guards.values())
        opaque = sorted(self.tracer.opaque)
        wanted = [*self.rates, *self.outputs, *self.led, *opaque, *(guard.node for guard in guards)]
        leaves = [graph.leaf(("led", k), 0.0) for k in range(len(self.led))]
        rows = _Rows(self)

        for k in graph.needed([*wanted, *leaves]):
            rows.add(k)

        # nothing that is moved may stand in what is solved for and has no derivatives there
        held = [(rows.equal_to_itself(k), True) for k in opaque]
        held = [*((rows.place[guard.node], guard.holds) for guard in guards), *held]
        place = rows.place
        return Tape(
            np.array(rows.rows, "<i4").reshape(-1, 5),
            np.array(list(rows.constants), float),
            np.array(held, "<i4").reshape(-1, 2),
            self.n_led,
            np.array([place[k] for k in self.rates], "<i4"),
            np.array([place[k] for k in self.outputs], "<i4"),
        )

    def agrees(self, instance) -> bool:
        """Whether its derivatives along a random direction are what differences tell: a loop that ends by values may hide one."""
        random = np.random.default_rng(1)
        seed = random.standard_normal(len(self.x) + self.n_u)
        graph = self.graph
        x = [graph.leaf(("state", j), 0.0) for j in self.x]
        u = [graph.leaf(("u", j), 0.0) for j in range(self.n_u)]
        led = [graph.leaf(("led", k), 0.0) for k in range(len(x))]
        to_led = at_the_trace(graph, self.led, [*x, *u]) @ seed
        wanted = [*self.rates, *self.outputs]
        found = at_the_trace(graph, wanted, [*led, *u]) @ np.concatenate([to_led, seed[len(x) :]])
        (far, _), (near, values) = (_differences(instance, seed, len(x), len(self.rates), h) for h in STRIDES)
        size = np.abs(near) + SMALL_PART * np.abs(near).max(initial=0.0)
        noise = np.abs(values) + SMALL_PART * np.abs(values).max(initial=0.0)
        allowed = AGREEMENT * size + DOUBT * np.abs(far - near) + NOISE / STRIDES[-1] * noise
        return bool(np.all(np.abs(found - near) <= allowed))


class _Rows:
    """The operations of a tape, one behind the other. place : node -> where it stands."""

    def __init__(self, trace: _Trace):
        self.trace = trace
        self.graph = trace.graph
        self.rows: list[tuple[int, ...]] = []
        self.place: dict[int, int] = {}
        self.constants: dict[float, int] = {}
        self._moved: dict[int, int] = {}

    def add(self, k: int):
        """A node whose operands stand there."""
        node: Any = self.graph.nodes[k]

        if node.op == "solve":
            self._add_solved(k, node)
        elif node.op == "found":
            self.place[k] = self.place[node.args[0]] + 1 + node.about
        elif node.op == "along":
            self.place[k] = self._add_along(*node.args)
        else:
            self.place[k] = self._row(*self._operation(k, node))

    def equal_to_itself(self, k: int) -> int:
        """Where it is asked whether a leaf is what it is: along a seed that moves it that no longer holds."""
        return self._row("==", self.place[k], self._row("still", self.place[k]))

    def _row(self, op, *about):
        """Where an operation comes to stand."""
        self.rows.append((CODE[op], *about, *[0] * (4 - len(about))))
        return len(self.rows) - 1

    def _add_solved(self, k, node):
        """What a kernel takes, the kernel, what it gives, one behind the other."""
        kind, element = node.about

        for a in node.args:
            self._row("still", self.place[a])

        self.place[k] = self._row("solve", kind, element, len(node.args), gives(kind))

        for _ in range(gives(kind)):
            self._row("found")

    def _add_along(self, number, *slopes_and_operands):
        """A number, and nothing by its derivatives, since its operands are where they are."""
        found = self.place[number]

        for slope, a in zip(slopes_and_operands[::2], slopes_and_operands[1::2]):
            if a not in self._moved:
                self._moved[a] = self._row("-", self.place[a], self._row("still", self.place[a]))

            found = self._row("+", found, self._row("*", self.place[slope], self._moved[a]))

        return found

    def _operation(self, k, node):
        """(operation, its operands and places) of a node."""
        if node.op not in CODE:
            raise Untraceable(f"{node.op} is no operation of a tape")

        operands = [self.place[a] for a in node.args]

        match node.op:
            case "constant":
                return "constant", self.constants.setdefault(float(self.graph.values[k]), len(self.constants))
            case "leaf" if node.about[0] == "led":
                return "led", self.place[self.trace.led[node.about[1]]], node.about[1]
            case "leaf":
                return "leaf", BUFFERS.index(node.about[0]), node.about[1]
            case "load" if node.about[0] != "reals":
                raise Untraceable(f"numbers of `{node.about[0]}` are looked up")
            case "load":
                return "load", *operands, *node.about[1:]
            case "interval":
                return "interval", *operands, *node.about

        return node.op, *operands


def _differences(instance, seed, n_x, n_rates, stride):
    """Derivatives of x' and y along a seed of x and u, by differences of order 4, not a number where there is none; x' and y."""
    d = instance.d
    x, u = d.x.copy(), d.u_buffer[: len(seed) - n_x].copy()
    total = values = np.zeros(n_rates + instance.model.n_y)

    for place, weight in ((1, 8), (-1, -8), (2, -1), (-2, 1)):
        d.x[:] = x + stride * place * seed[:n_x]
        d.u_buffer[: len(u)] = u + stride * place * seed[n_x:]
        y = np.zeros(instance.model.n_y)
        good = exchange.lead(instance.m, d) == OK == exchange.rates_now(instance.m, d)
        good = good and compute_outputs(instance.m, d, y) == OK
        values = np.concatenate([d.x_rate[:n_rates], y])
        total = total + weight / (12 * stride) * (values if good else np.full_like(values, np.nan))

    d.x[:], d.u_buffer[: len(u)] = x, u
    return total, values
