"""A scene as functions: x' = f(t, x, u, p) and y = g(t, x, u, p), and their exact derivatives.

    found = derivatives(instance)            # of a run at its present state
    found.A, found.B, found.C, found.D       # dx'/dx, dx'/du, dy/dx, dy/du

x is the state in the order of `kernels/layout.py`, joint coordinates, then velocities, as model exchange
shows it. Loops are closed by multipliers: A tells what x' = f does beside the constraints too.
"""

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from .derivatives import at_the_trace
from .graph import Graph, Untraceable
from .places import COMMANDED, places, places_of, tunable
from .record import Guard, Tracer


@dataclass(frozen=True)
class SceneGraph:
    """A scene as a graph, recorded at the state of an instance.

    time, states, inputs, parameters : nodes of its leaves. rates, outputs : nodes of x' and y; gap_rates : of
    the rates of the constraints' gaps. guards : what it rests on: where one does not hold, a branch goes
    otherwise. parameter_names : of the parameters, as in an FMU.
    """

    graph: Graph
    time: int
    states: list[int]
    inputs: list[int]
    parameters: list[int]
    rates: list[int]
    outputs: list[int]
    gap_rates: list[int]
    guards: list[Guard]
    parameter_names: list[str]


@dataclass(frozen=True)
class Derivatives:
    """Of x' and y by x, u, and by parameters p, as numbers; rates, outputs : x' and y themselves.

    gap_rates_by_states : of the rates of the constraints' gaps by x.
    """

    rates: np.ndarray
    outputs: np.ndarray
    A: np.ndarray
    B: np.ndarray
    C: np.ndarray
    D: np.ndarray
    rates_by_parameters: np.ndarray
    outputs_by_parameters: np.ndarray
    gap_rates_by_states: np.ndarray


def scene_graph(
    instance, parameters: Sequence[str] = (), outputs: bool = True, solves: bool = True
) -> SceneGraph:
    """The scene of an instance as a graph, at its state, time and inputs.

    parameters : names of those that are given; all others are numbers. outputs : whether y is wanted.
    solves : whether what is summed or solved for is one operation, else it is written out as far as that
    goes. What the start has found (lengths of springs, which rows are redundant) stays as it is, and how
    commanded motions go on. Raises Untraceable, KeyError for unknown names.
    """
    model = instance.model
    by_name = {v.name: v.index for v in model.of_causality("parameter")}
    reals = [by_name[name] for name in parameters]
    (now, _), x = places(model, "time"), places(model, "x")
    inputs = range(model.n_u)
    # joints that are held where no drive holds them (an equilibrium's) go on being held
    held = {j for j in places(model, "held") if instance.d.work_buffer[j] != 0.0}
    work = places_of(model, COMMANDED) | held
    given = {"reals": set(reals), "state": {now, *x}, "u": set(inputs), "work": work}
    tracer = Tracer(instance.m, instance.d, given, exact=False, solves=solves)
    graph = tracer.graph

    def leaves(buffer, found):
        initial = tracer.buffers[buffer].initial
        return [graph.leaf((buffer, j), initial[j]) for j in found]

    time, states = leaves("state", [now])[0], leaves("state", x)
    of_inputs, of_parameters = leaves("u", inputs), leaves("reals", reals)

    if not tunable(model).isdisjoint(reals):
        tracer.run("prepare", "prepare")

    tracer.run("dynamics.rates", "evaluate", 0.0)
    rates = [tracer.node_at("work", j) for j in places(model, "x_rate")]
    gap_rates = [tracer.node_at("work", j) for j in places(model, "row_rate")]
    y = [0.0] * (model.n_y if outputs else 0)

    if y:
        tracer.run("entry", "compute_outputs", y)

    if opaque := [name for name, k in zip(parameters, of_parameters) if k in tracer.opaque]:
        raise Untraceable(f"there are no derivatives by {opaque[0]!r} of what is solved for")

    return SceneGraph(
        graph,
        time,
        states,
        of_inputs,
        of_parameters,
        rates,
        [tracer.node_of(value) for value in y],
        gap_rates,
        list(tracer.guards.values()),
        list(parameters),
    )


def derivatives(instance, parameters: Sequence[str] = (), outputs: bool = True) -> Derivatives:
    """Exact derivatives of x' and y at the state, time and inputs of an instance, which stays as it is.

    parameters : names of those by which derivatives are wanted too. outputs : whether those of y are. Raises
    Untraceable.
    """
    scene = scene_graph(instance, parameters, outputs)
    graph = scene.graph
    n, u, y = len(scene.states), len(scene.inputs), len(scene.outputs)
    wanted = [*scene.rates, *scene.outputs, *scene.gap_rates]
    leaves = [*scene.states, *scene.inputs, *scene.parameters]
    whole = at_the_trace(graph, wanted, leaves)
    f, g, gaps = whole[:n], whole[n : n + y], whole[n + y :]
    return Derivatives(
        np.array([graph.values[k] for k in scene.rates], float),
        np.array([graph.values[k] for k in scene.outputs], float),
        f[:, :n],
        f[:, n : n + u],
        g[:, :n],
        g[:, n : n + u],
        f[:, n + u :],
        g[:, n + u :],
        gaps[:, :n],
    )
