"""A scene as equations to be read and used elsewhere: x' = f(t, x, u, p), y = g(t, x, u, p).

They are written in C, numpy, sympy or casadi (`forms`).
"""

from collections.abc import Sequence
from dataclasses import dataclass, replace
from typing import NamedTuple

from .branches import words
from .derivatives import jacobian
from .forms import FORMS
from .functions import SceneGraph, scene_graph
from .places import LOOKED_UP, places


class Function(NamedTuple):
    """A function of (t, x, u, p): what it gives, as rows of nodes, None for zero. what : in words."""

    name: str
    what: str
    rows: list[list[int | None]]


@dataclass(frozen=True)
class Equations:
    """A scene's functions, and the names of all that goes in.

    name : of the scene. scene : its graph. states, inputs, outputs, parameters : names of variables, as in an
    FMU. x, u, p : values at the start. moving, lasting : what must hold where the equations are used, in
    words; the first end as the scene moves. tables : by name, where in `reals` an array of tables begins, and
    its numbers. functions : rates, outputs, derivatives.
    """

    name: str
    scene: SceneGraph
    states: list[str]
    inputs: list[str]
    outputs: list[str]
    parameters: list[str]
    x: list[float]
    u: list[float]
    p: list[float]
    moving: list[str]
    lasting: list[str]
    tables: dict[str, tuple[int, list[float]]]
    functions: list[Function]

    def text(self, form: str) -> str:
        """The equations in one of `forms.FORMS`. Raises Untraceable for what that cannot say."""
        return FORMS[form](self)


def equations(
    instance, parameters: Sequence[str] | None = None, outputs: bool = True, derivatives: bool = False
) -> Equations:
    """The equations of the scene of an instance, at whose state they are traced.

    parameters : names of those that stay free, all others are numbers; by default all that are not zero and
    matter.
    outputs : whether y is wanted. derivatives : whether dx'/dx, dx'/du, dy/dx, dy/du are, as functions too.
    Raises Untraceable, KeyError for unknown names.
    """
    model = instance.model
    reals = {v.name: instance.reals[v.index] for v in model.of_causality("parameter")}
    free = [name for name, value in reals.items() if value != 0.0] if parameters is None else list(parameters)
    scene = scene_graph(instance, free, outputs, solves=False)
    graph = scene.graph
    functions = [Function("rates", "x'", [[k] for k in scene.rates])]

    if scene.outputs:
        functions.append(Function("outputs", "y", [[k] for k in scene.outputs]))

    if derivatives:
        functions += _derivatives(scene)

    wanted = [k for function in functions for row in function.rows for k in row if k is not None]
    needed = set(graph.needed(wanted))
    kept = [j for j, k in enumerate(scene.parameters) if parameters is not None or k in needed]
    scene = replace(
        scene,
        parameters=[scene.parameters[j] for j in kept],
        parameter_names=[scene.parameter_names[j] for j in kept],
    )
    moving, lasting = words(scene.guards)
    return Equations(
        name=model.name,
        scene=scene,
        states=_state_names(model),
        inputs=[v.name for v in sorted(model.of_causality("input"), key=lambda v: v.index)],
        outputs=[v.name for v in sorted(model.of_causality("output"), key=lambda v: v.index)],
        parameters=scene.parameter_names,
        x=instance.d.x.tolist(),
        u=instance.u[: model.n_u].tolist(),
        p=[float(reals[name]) for name in scene.parameter_names],
        moving=moving,
        lasting=lasting,
        tables=_tables(instance, graph, needed),
        functions=functions,
    )


def _derivatives(scene):
    """The four Jacobians that are not empty."""
    pairs = {
        "rates_by_states": ("dx'/dx", scene.rates, scene.states),
        "rates_by_inputs": ("dx'/du", scene.rates, scene.inputs),
        "outputs_by_states": ("dy/dx", scene.outputs, scene.states),
        "outputs_by_inputs": ("dy/du", scene.outputs, scene.inputs),
    }
    return [
        Function(name, what, jacobian(scene.graph, wanted, leaves))
        for name, (what, wanted, leaves) in pairs.items()
        if wanted and leaves
    ]


def _state_names(model):
    """Names of all of x, as model exchange calls them where there is that."""
    found = {v.index: v.name for v in model.of_causality("state")}
    return [found.get(k, f"x[{k + 1}]") for k in range(model.n_x)]


def _tables(instance, graph, needed):
    """Arrays of `reals` that numbers are looked up in, by name, those alone that are needed."""
    model = instance.model
    found = {}

    for k in needed:
        node = graph.nodes[k]

        if node.op in ("load", "interval"):
            first = node.about[1] if node.op == "load" else node.about[0]
            name = next(n for n in LOOKED_UP if first in places(model, n))
            at = places(model, name)
            found[name] = at.start, instance.reals[at.start : at.stop].tolist()

    return found
