"""Linear models of a scene about a state of it (docs/theory.md 19.4)."""

from collections.abc import Callable, Mapping, Sequence
from dataclasses import replace

from ..scene import SceneData
from .linear import Linear, about
from .manifold import AUTO, BODY, INERTIAL, Manifold
from .places import state_at
from .sensitivity import sensitivities

AXES = (AUTO, BODY, INERTIAL)


def linearise(
    scene: SceneData,
    inputs: Sequence[str] | None = None,
    outputs: Sequence[str] | None = None,
    at: str | float | None = None,
    *,
    axes: str = AUTO,
    hold: Mapping[str, float] | None = None,
    parameters: Mapping[str, float] | Sequence[str] | None = None,
    by: Sequence[str] = (),
    progress: Callable[[str], None] | None = None,
) -> Linear:
    """A, B, C, D of a scene about a state, on its constraints, in minimal coordinates.

    inputs, outputs : names of the FMU's variables, an array's name means all its elements; by default all,
        but inputs that command motion.
    at : "start", as the scene starts, moving or not; "equilibrium", the static equilibrium near the start; a
        number, so many seconds into a run from the start. By default the equilibrium where the scene starts
        at rest, else the start.
    axes : of deviations of spherical and free joints and their rates: "body", the body's; "inertial", those
        of the joint's first side; by default those in which the motion is steady, if any are
        (`Manifold._frame`). A body that spins about gravity, as a top that sleeps, is seen from itself then;
        "inertial" shows its whirl as seen from outside, if it is round.
    hold : values of inputs by name. parameters : values other than the scene's, by name; or names alone, as
        `by`.
    by : names of parameters: `sensitivities` then has derivatives by them of the state, where that is the
        equilibrium, of outputs, frequencies and damping.

    Coordinates are deviations from the state, which may move on. Derivatives are exact where the scene's
    equations can be traced, else differences with control of the step; `error` is their estimated error.
    Raises SimulationError where the state is not reached, NoState where the motion cannot go on from there,
    NoEquilibrium, KeyError for unknown names, ValueError.
    """
    if axes not in AXES:
        raise ValueError(f"axes = {axes!r}: write {' or '.join(map(repr, AXES))}")

    if parameters is not None and not isinstance(parameters, Mapping):
        by = [*by, *([parameters] if isinstance(parameters, str) else parameters)]
        parameters = None

    mechanism, where, notices = state_at(scene, at, hold, parameters, progress)
    linear = replace(about(Manifold(mechanism, axes), inputs, outputs, notices, traced=True), where=where)

    if not by:
        return linear

    found = sensitivities(scene, by, outputs, at, axes, hold, parameters, linear)
    return replace(linear, sensitivities=found)
