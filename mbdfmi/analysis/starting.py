"""Where a scene starts that asks for another start than it has: at rest, or trimmed."""

import re
from collections.abc import Mapping
from dataclasses import dataclass, field, replace

import numpy as np

from ..compiler.model import Model, RestingStart, compile_scene, with_values
from ..kernels import exchange
from ..run.instance import Instance
from ..scene import SceneData, variable_name
from ..scene.errors import listed
from .equilibrium import NoEquilibrium
from .manifold import Manifold
from .places import mechanism_of
from .rest import equilibrium, observed, started_moving
from .trim import trim

START_VALUE = re.compile(r"_start(\[\d+\])?$")
"""How the names of parameters end that are start values."""

# how the messages of a trim begin
OF_TRIM = ("find:", "keep:", "steady:", "trim:", "no trim")


@dataclass(frozen=True)
class Starting:
    """A scene with the start that it asks for.

    hold, parameters : values of inputs and parameters that go with it, by variable name: those that were
        given, and those that were found; start values are in the scene. found : the latter alone.
    notices : what a user should be told of it.
    """

    scene: SceneData
    hold: dict[str, float]
    parameters: dict[str, float]
    found: dict[str, float] = field(default_factory=dict)
    notices: list[str] = field(default_factory=list)


def starting(
    scene: SceneData,
    hold: Mapping[str, float] | None = None,
    parameters: Mapping[str, float] | None = None,
    time: float = 0.0,
) -> Starting:
    """The scene with the start that `solver.start` asks for, by inputs, parameters and the time (s) of the
    start.

    Raises NoEquilibrium, and ValueError where no trim is found or its names do not fit the scene.
    """
    start = scene.solver.start
    hold, parameters = dict(hold or {}), dict(parameters or {})

    if start == "given":
        return Starting(scene, hold, parameters)

    kept = {name: value for name, value in parameters.items() if not START_VALUE.search(name)}

    try:
        if start == "equilibrium":
            rest = equilibrium(scene, hold=hold, parameters=parameters, time=time)
            return Starting(rest.scene, hold, kept, notices=rest.notices)

        return _trimmed(scene, hold, parameters, kept, time)
    except NoEquilibrium as error:
        raise NoEquilibrium(f'[solver] start = "{start}": {error}') from None
    except (KeyError, ValueError) as error:
        text = str(error.args[0])

        # names and values of the run itself are none of the trim's
        if start == "trim" and text.startswith(OF_TRIM):
            raise ValueError(f"[solver.trim] {text}") from None

        raise


def resting(model: Model, given: Starting, asked: bool) -> tuple[Model, Model, list[str]]:
    """A model whose FMU offers to start at its static equilibrium, the model of the scene that starts there,
    and what a user should be told of it.

    model : of `given`, whose start the search for the equilibrium begins at. asked : whether the FMU starts
    at rest where nothing else is said. Raises NoEquilibrium.
    """
    rest = equilibrium(given.scene, hold=given.hold, parameters=given.parameters)
    there = compile_scene(rest.scene, for_fmu=False)

    if not _are_alike(model, there):
        # bodies apart: which angles are states follows from what starts are given
        model = with_values(compile_scene(_assembled(given)), given.found)
        assert _are_alike(model, there)

    kept = {name: value for name, value in given.parameters.items() if not START_VALUE.search(name)}
    x = Instance(there, kept).d.x.copy()
    seen = Instance(model)
    seen.d.x[:] = x
    exchange.rates_now(seen.m, seen.d)
    return replace(model, rest=RestingStart(x, seen.d.x_rate.copy(), asked)), there, rest.notices


def _assembled(given):
    """The scene with all of its start told, as it is once its loops are closed."""
    mechanism = mechanism_of(observed(given.scene), given.hold, given.parameters)
    names = (v.name for v in mechanism.model.of_causality("output"))
    values = dict(zip(names, mechanism.instance.outputs().tolist()))
    return started_moving(given.scene, values, Manifold(mechanism))


def _are_alike(model, other):
    """Whether the states of two models are the same ones."""
    if model.n_x != other.n_x or len(model.tree.nodes) != len(other.tree.nodes):
        return False

    return all(
        (a.joint, a.part, a.kind, a.parent, a.reversed) == (b.joint, b.part, b.kind, b.parent, b.reversed)
        and all(np.array_equal(x, y) for x, y in zip(a.joint_frame, b.joint_frame))
        for a, b in zip(model.tree.nodes, other.tree.nodes)
    )


def _trimmed(scene, hold, parameters, kept, time):
    """The scene as [solver.trim] asks for it; kept : parameters that are no start values."""
    asked = scene.solver.trim
    unknown = {variable_name(name) for name in asked.find}
    both = [name for name in kept if variable_name(name) in unknown]

    if both:
        raise ValueError(
            f"find: {listed(both)} {'is' if len(both) == 1 else 'are'} to be found, and given as a "
            "parameter of this run"
        )

    given = {variable_name(name): value for name, value in hold.items() if variable_name(name) in unknown}
    others = {name: value for name, value in hold.items() if variable_name(name) not in given}
    found = trim(
        scene,
        asked.find,
        asked.keep,
        steady=asked.steady,
        rest=asked.rest,
        hold=others,
        parameters=parameters,
        time=time,
    )
    own = {name: value for name, value in found.values.items() if not START_VALUE.search(name)}
    apart = [
        f"[solver.trim] finds {name} = {own[name]:.6g}, and the run begins with {value:.6g}"
        for name, value in given.items()
        if value != own[name]
    ]
    return Starting(
        found.scene,
        hold=found.inputs | hold,
        parameters=kept | {name: value for name, value in own.items() if name not in found.inputs},
        found=own,
        notices=[*found.notices, *apart],
    )
