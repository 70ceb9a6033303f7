"""Every stepper on one scene: the error of its outputs against what a run costs."""

import csv
import time
from collections.abc import Callable, Iterable, Mapping
from dataclasses import dataclass, field
from pathlib import Path

import numpy as np

from ..compiler.model import compile_scene
from ..compiler.variables import array_of
from ..files import replacing, save_figure
from ..kernels import entry
from ..kernels.language import INTERPRETED
from ..kernels.status import OK
from ..run.follow import follow
from ..run.inputs import known, numbers
from ..run.instance import Instance, SimulationError, explain
from ..run.results import Results
from ..run.simulate import communication_points
from ..scene import SceneData, Solver, variable_name
from ..scene.fields import LARGEST_TOLERANCE, LEAST_TOLERANCE
from ..steppers import ADAPTIVE, FIXED_STEP

TOLERANCES = tuple(10.0**-k for k in range(4, 12))
"""Of the steppers that choose their step."""

PARTS = tuple(4**k for k in range(6))
"""Of a communication step, that those with a fixed step take."""

REFERENCE = (1e-13, 1e-12, 1e-11, 1e-10)
"""Tolerances of the reference run, the first that works; it is doubted by what the next one gives."""

LONGEST = 10.0
"""s of CPU that one run may take."""

TARGETS = (1e-3, 1e-6, 1e-9)
"""Errors for which the best choice is told."""

# what is no motion: what the solver did, and errors themselves
NO_MOTION = ("solver.", "constraint_gap", "constraint_rate")

# parts of the largest value of the same unit below which an output counts as zero
SMALL = 1e-6

NEEDLESS = "a longer step is as exact as the reference"

# most communication steps between looks at the clock, and s of CPU that as many steps at once may take
CHUNK = 64
BRIEF = 0.05

# s of CPU after which a run is not repeated, and how often at most
ENOUGH = 0.3
ROUNDS = 5


def short(number: float, digits: int = 4) -> str:
    """A positive number in few letters: 1e-7, 2.5e-4, 0.025."""
    if number >= 1e-2:
        return f"{number:.{digits}g}"

    mantissa, exponent = f"{number:.{digits - 1}e}".split("e")
    return f"{mantissa.rstrip('0').rstrip('.') if '.' in mantissa else mantissa}e{int(exponent)}"


@dataclass(frozen=True)
class Setting:
    """A stepper, and the tolerance (relative; the absolute one goes with it) or step (s) that it is given."""

    integrator: str
    value: float

    @property
    def key(self) -> str:
        """ "step" or "tolerance"."""
        return "step" if self.integrator in FIXED_STEP else "tolerance"

    @property
    def short(self) -> str:
        """The tolerance or step in few letters."""
        return short(self.value) + (" s" if self.key == "step" else "")

    def __str__(self):
        return f"{self.integrator}, {self.key} {self.short}"


@dataclass
class Run:
    """One stepper at one setting.

    error : largest over outputs and communication points, each by the size of its output; worst : name of
        that output.
    cpu : s, least of some rounds, of the steps and outputs alone. steps, rejected, evaluations (of the
        accelerations).
    reason : why there are no figures, or "".
    """

    setting: Setting
    error: float = np.nan
    worst: str = ""
    cpu: float = np.nan
    steps: int = 0
    rejected: int = 0
    evaluations: int = 0
    reason: str = ""


@dataclass(frozen=True)
class Comparison:
    """What came of all runs.

    title, until, step : of the scene, s, communication step (s).
    runs : by CPU time; those without figures come last.
    own : the run with the scene's own solver, one of `runs`.
    reference : setting of the reference run; doubt : how far it differs from one at the next looser
        tolerance: smaller errors mean nothing.
    compared : names of the outputs.
    """

    title: str
    until: float
    step: float
    runs: list[Run]
    own: Run
    reference: Setting
    doubt: float
    compared: list[str] = field(repr=False)

    @property
    def done(self) -> list[Run]:
        """Runs with figures, by CPU time."""
        return [run for run in self.runs if not run.reason]

    @property
    def front(self) -> list[Run]:
        """Runs that no other beats in both error and CPU time."""
        found, least = [], np.inf

        for run in self.done:
            error = max(run.error, self.doubt)

            if error < least:
                found.append(run)
                least = error

        return found

    def best(self, error: float, among: Iterable[str] = (*ADAPTIVE, *FIXED_STEP)) -> Run | None:
        """The fastest run, of some steppers, with an error of at most this."""
        fits = [run for run in self.done if run.error <= error and run.setting.integrator in among]
        return fits[0] if fits else None

    def to_csv(self, path) -> Path:
        """Write all runs as a table."""
        Results.check_csv(path)
        heading = (
            "integrator",
            "setting",
            "value",
            "error",
            "worst output",
            "cpu [s]",
            "evaluations",
            "steps",
            "rejected",
            "failure",
        )

        with replacing(path) as temporary, open(temporary, "w", newline="", encoding="utf-8") as file:
            writer = csv.writer(file, lineterminator="\n")
            writer.writerow(heading)

            for run in self.runs:
                setting = run.setting
                figures = (run.error, run.worst, run.cpu, run.evaluations, run.steps, run.rejected, "")
                rest = figures if not run.reason else (*[""] * 6, run.reason)
                writer.writerow((setting.integrator, setting.key, setting.value, *rest))

        return Path(path)

    def plot(self, path) -> Path:
        """Write a picture: error against CPU time, a line for each stepper. Raises ImportError, ValueError as
        of Results.
        """
        Results.check_plot(path)
        from .comparison_plot import figure_of

        save_figure(figure_of(self), path, dpi=130)

        return Path(path)


def compare_steppers(
    scene: SceneData,
    until: float,
    step: float | None = None,
    inputs: Mapping[str, float] | None = None,
    parameters: Mapping[str, float] | None = None,
    steppers: Iterable[str] = (*ADAPTIVE, *FIXED_STEP),
    longest: float = LONGEST,
    progress: Callable[[float, str], None] = lambda part, text: None,
) -> Comparison:
    """Run a scene with every stepper at several tolerances or steps, and see how far each is from a tight
    reference run.

    until, step : s, as of `simulate`. inputs : numbers by name, held.
    longest : s of CPU that one run may take; what would take longer is left out, and says so.
    progress : called with the part of the settings that is done, and what comes next.

    Raises ValueError where nothing can be compared, SimulationError where no reference run succeeds.
    """
    for name in steppers:
        if name not in (*ADAPTIVE, *FIXED_STEP):
            raise ValueError(f"no stepper {name!r}; there are {', '.join((*ADAPTIVE, *FIXED_STEP))}")

    trial = _Trial(scene, communication_points(0.0, until, step)[0], inputs, parameters, longest)
    progress(0.0, "the reference run")
    reference, rows, doubt = _reference(trial)
    settings = [setting for name in steppers for setting in _settings(name, trial.times[1] - trial.times[0])]
    own = Setting(scene.solver.integrator, scene.solver.step or scene.solver.tolerance)
    settings = [own, *(setting for setting in settings if setting != own)]
    runs, again = [], []

    for k, setting in enumerate(settings):
        progress(k / len(settings), str(setting))

        if reason := _left_out(setting, runs, doubt, longest):
            runs.append(Run(setting, reason=reason))
            continue

        run, instance = _compared(trial, setting, rows)
        runs.append(run)
        again += [(run, instance)] if instance else []

    trial.repeat(again, progress)
    by_time = sorted(runs, key=lambda run: (bool(run.reason), run.cpu if not run.reason else 0.0))
    names = [trial.outputs[k].name for k in trial.shown]
    title = trial.title
    return Comparison(
        title, float(trial.times[-1]), float(trial.times[1]), by_time, runs[0], reference, doubt, names
    )


def _settings(name, H):
    """From loose to tight; H: communication step (s)."""
    return (
        [Setting(name, float(H / n)) for n in PARTS]
        if name in FIXED_STEP
        else [Setting(name, t) for t in TOLERANCES]
    )


class _Trial:
    """A scene to be run with one solver after another.

    times : (n,) s, communication points. outputs : its output variables; shown : places of those that are
        compared.
    """

    def __init__(self, scene, times, inputs, parameters, longest):
        self.scene, self.times, self.longest = scene, times, longest
        self.parameters = dict(parameters or {})

        for name in self.parameters:
            if variable_name(name) in ("solver.tolerance", "solver.absolute_tolerance", "solver.step"):
                raise ValueError(f"{name} is what is varied here; leave it out")

        model = compile_scene(scene, for_fmu=False)
        self.title = model.title
        self.outputs = model.of_causality("output")
        self.shown = [k for k, v in enumerate(self.outputs) if not v.name.startswith(NO_MOTION)]
        at = {v.name: v.index for v in model.of_causality("input")}
        self.inputs = {
            at[part]: float(numbers(value, f"input {name!r}", ()))
            for name, value in (inputs or {}).items()
            for part in known(variable_name(name), at, "input")
        }

        if not self.shown:
            raise ValueError(
                "the scene has no outputs that could be compared; ask for some, as in "
                'output = ["angle"] of a joint or output = ["position"] of a marker'
            )

    def run(self, setting):
        """(Run without its error, outputs (n, n_y) at the communication points, instance). Raises
        SimulationError.
        """
        instance = Instance(
            compile_scene(self._solved(setting), for_fmu=False), self.parameters, 0.0, self.inputs
        )
        rows = np.empty((len(self.times), len(self.shown)))
        run = Run(setting, cpu=self._once(instance, rows))
        d = instance.d
        run.steps, run.rejected, run.evaluations = (int(a[0]) for a in (d.steps, d.rejected, d.evaluations))
        return run, rows, instance

    def repeat(self, runs, progress):
        """Runs (run, instance) again, in turns, and keeps the least CPU time of each."""
        rows = np.empty((len(self.times), len(self.shown)))
        spent = [run.cpu for run, _ in runs]

        for turn in range(1, 1 if INTERPRETED else ROUNDS):
            progress(1.0, f"round {turn + 1} of {ROUNDS}, for the times")

            for k, (run, instance) in enumerate(runs):
                if spent[k] < ENOUGH:
                    seconds = self._once(instance, rows)
                    spent[k] += seconds
                    run.cpu = min(run.cpu, seconds)

    def _once(self, instance, rows):
        """From the start to the end, outputs into rows; returns s of CPU. Raises SimulationError."""
        m, d, y = instance.m, instance.d, instance.y
        kept = np.empty((CHUNK, len(y)))
        status = entry.initialise(m, d, 0.0) or entry.compute_outputs(m, d, y)
        rows[0] = y[self.shown]
        follow(m, d, self.times[:0], y, kept)  # compiled, or found compiled, before anything is timed
        begin, seconds = time.process_time(), 0.0
        k, n = 1, 1

        while k < len(self.times):
            some = self.times[k : k + n]
            status = status or follow(m, d, some, y, kept)
            before, seconds = seconds, time.process_time() - begin

            if status != OK:
                text = f"{explain(instance.model, status)} (time {instance.time:.6g} s)"
                raise SimulationError(text, instance.time)

            rows[k : k + len(some)] = kept[: len(some), self.shown]
            k += len(some)
            n = min(2 * n, CHUNK) if seconds - before < BRIEF else 1

            if seconds > self.longest:
                text = f"takes more than {self.longest:g} s of CPU: stopped at {instance.time:.4g} s"
                raise SimulationError(text, instance.time)

        if not np.all(np.isfinite(rows)):
            raise SimulationError("its outputs are not finite", instance.time)

        return seconds

    def _solved(self, setting):
        """The scene with this solver; what else its own says (formulation, largest step) stays."""
        old = self.scene.solver
        new = {"integrator": setting.integrator, setting.key: setting.value}
        kept = {"formulation", "max_evaluations", "closing_tolerance"} | (
            {"max_step"} if setting.key == "tolerance" else set()
        )
        new |= {key: getattr(old, key) for key in kept & old.model_fields_set}

        if "absolute_tolerance" in old.model_fields_set and setting.key == "tolerance":
            absolute = setting.value * old.absolute_tolerance / old.tolerance
            new["absolute_tolerance"] = min(max(absolute, LEAST_TOLERANCE), LARGEST_TOLERANCE)

        return self.scene.model_copy(update={"solver": Solver(**new)})

    def error(self, rows, reference):
        """(largest difference of outputs by their sizes, name of the output)."""
        variables = [self.outputs[k] for k in self.shown]
        difference = abs(_difference(variables, rows, reference)).max(axis=0) / _sizes(variables, reference)
        worst = int(np.argmax(difference))
        return float(difference[worst]), variables[worst].name


def _groups(keys):
    """Places of equal keys, by key."""
    found = {}

    for k, key in enumerate(keys):
        found.setdefault(key, []).append(k)

    return found


def _sizes(variables, reference):
    """(n_y,) what each output's error is measured by: the largest value that it, or its array, has in the
    reference run; of those that are zero but for rounding, beside others of their unit, a small part of the
    largest of these."""
    largest = abs(reference).max(axis=0)
    sizes = np.empty(len(variables))

    for of in _groups(v.unit for v in variables).values():
        least = SMALL * largest[of].max()

        for group in _groups(array_of(variables[k].name) for k in of).values():
            members = [of[k] for k in group]
            sizes[members] = max(largest[members].max(), least)

    return np.where(sizes > 0.0, sizes, 1.0)


def _difference(variables, rows, reference):
    """Rows less those of the reference, where turns of a whole and the sign of Euler parameters do not
    count.
    """
    found = rows - reference

    for name, of in _groups(array_of(v.name) for v in variables).items():
        if name.endswith("zyx"):
            found[:, of] -= 2.0 * np.pi * np.round(found[:, of] / (2.0 * np.pi))
        elif name.endswith("euler_parameters"):
            sign = np.where(np.sum(rows[:, of] * reference[:, of], axis=1) < 0.0, -1.0, 1.0)
            found[:, of] = rows[:, of] * sign[:, None] - reference[:, of]

    return found


def _reference(trial):
    """(setting, outputs, doubt) of the tightest run that succeeds. Raises SimulationError, that of the
    loosest.
    """
    setting, rows, failures = None, None, []

    for tolerance in REFERENCE:
        tried = Setting("auto", tolerance)

        try:
            found = trial.run(tried)[1]
        except SimulationError as error:
            failures.append(error)
            continue

        if rows is not None:
            return setting, rows, trial.error(found, rows)[0]

        setting, rows = tried, found

    last = failures[-1]
    what = "no reference run succeeds" if rows is None else f"the reference run, {setting}, cannot be checked"
    raise SimulationError(f"{what}: {last}", last.time)


def _left_out(setting, before, doubt, longest):
    """Why a setting is not run, or ""; `before`: runs so far, the scene's own first."""
    kin = [run for run in before[1:] if run.setting.integrator == setting.integrator]

    if not kin:
        return ""

    last = kin[-1]

    if last.reason:
        return last.reason.partition(":")[0] if "more than" in last.reason or NEEDLESS in last.reason else ""

    if setting.key == "step" and last.error <= doubt:
        return NEEDLESS

    if setting.key == "step" and last.cpu * last.setting.value / setting.value > longest:
        return f"would take more than {longest:g} s of CPU"

    return ""


def _compared(trial, setting, reference):
    """(Run of a setting, its instance, or None without figures)."""
    try:
        run, rows, instance = trial.run(setting)
    except SimulationError as error:
        return Run(setting, reason=str(error)), None

    run.error, run.worst = trial.error(rows, reference)
    return run, instance
