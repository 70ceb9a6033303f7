"""In-process runs from start to end, with inputs over time."""

from collections.abc import Callable, Mapping

import numpy as np

from ..compiler.model import Model
from ..kernels import entry
from ..kernels.motion.inputs import N_DERIVATIVE
from .inputs import Inputs, numbers
from .instance import Entries, Instance
from .results import Results
from .states import States


def simulate(
    model: Model,
    until: float,
    step: float | None = None,
    inputs: Mapping[str, float | np.ndarray | Callable[[float], float]] | None = None,
    parameters: Mapping[str, float] | None = None,
    start_time: float = 0.0,
    progress: Callable[[float], None] | None = None,
    kernels: Entries | None = None,
) -> Results:
    """Run a model in process from start_time to `until` (s).

    step : communication step (s), by default a 500th of the run, at whose ends results are kept.
    inputs : by variable name, as in an FMU or with the scene's names as they are: a number, an array of one
        value for each communication point, held until the next, or a function of time (s) alone, which is
        followed between communication points too, jumps and corners included (a pulse shorter than a tenth of
        a step may be missed). The name of an array variable without index takes as many of these as it has
        elements, or a function that returns them.
    parameters : values other than the scene's, by variable name; of an array without index all its elements.
    progress : called with the time reached (s) after each communication step.
    kernels : of a library that is this scene's own.

    Returns all outputs and inputs by name, and what the solver had to say. Raises SimulationError when the
    motion cannot go on, KeyError for unknown names, ValueError for times or arrays that do not fit.
    """
    start_time = float(numbers(start_time, "start_time", ()))
    times, steps = communication_points(start_time, until, step)
    n = len(steps)
    signals = Inputs(model, inputs or {}, times, _tolerance(model, parameters))
    instance = Instance(model, parameters, start_time, signals.first(), kernels or entry)
    u = instance.u.reshape(N_DERIVATIVE, -1)
    columns = np.empty((n + 1, model.n_u + model.n_y))
    states = States(model, n + 1)

    for k in range(n + 1):
        for position, value in signals.held(k).items():
            u[0, position] = value

        parts = signals.parts(k, steps[k] if k < n else 0.0)
        u[:, signals.positions] = parts[0][1]
        columns[k, : model.n_u] = instance.u[: model.n_u]
        columns[k, model.n_u :] = instance.outputs()
        states.keep(k, instance)

        for i, (length, derivatives) in enumerate(parts if k < n else ()):
            if i > 0:
                u[:, signals.positions] = derivatives

            instance.step(length)

        if progress and k < n:
            progress(instance.time)

    shown = [v for v in model.variables if v.causality != "parameter"]
    units = {"time": "s"} | {v.name: v.unit for v in shown}
    by_name = {"time": times} | {v.name: columns[:, k] for k, v in enumerate(shown)}
    return Results(by_name, units, model.title, instance.notices + signals.notices, states)


def inputs_at_start(model, until, step=None, inputs=None, start_time=0.0) -> dict[str, float]:
    """Values, by the variables' names, that inputs given as to `simulate` have at its start."""
    times, _ = communication_points(start_time, until, step)
    first = Inputs(model, inputs or {}, times, model.scene.solver.tolerance).first()
    return {v.name: float(first[v.index]) for v in model.of_causality("input") if v.index in first}


def _tolerance(model, parameters):
    """The solver's relative tolerance, a parameter."""
    return (parameters or {}).get("solver.tolerance", model.scene.solver.tolerance)


def communication_points(start_time, until, step=None):
    """(times (n + 1,), steps (n,)), s, of a run that ends at `until`; the last step is what is left.

    step : s, by default a 500th of the run. Raises ValueError for times that make no run.
    """
    until = float(numbers(until, "until", (), False))
    duration = until - start_time

    if not 0.0 < duration < np.inf:
        raise ValueError(f"the run must end after it starts at {start_time} s; found until = {until}")

    step = duration / 500 if step is None else float(numbers(step, "step", (), False))

    if not 0.0 < step < np.inf:
        raise ValueError(f"the communication step must be positive; found {step}")

    n = max(1, round(duration / step))

    if abs(n * step - duration) > 1e-6 * step:
        n = int(np.ceil(duration / step))

    steps = np.full(n, step)
    steps[-1] = duration - (n - 1) * step
    return start_time + np.append(np.arange(n) * step, duration), steps
