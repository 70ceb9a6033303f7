"""How a scene is run: formulation, stepper, tolerance, communication steps, in process or as FMU,
from snapshots, after a reset.

`run` gives all outputs at every communication point. At a shared point of the plan,
where inputs and parameters jump, they are read twice: before (ARRIVING) and after (LEAVING).
"""

import _ctypes
import json
import time as clock
import traceback
from dataclasses import dataclass, field
from pathlib import Path
from tempfile import TemporaryDirectory

import numpy as np
from fmu_host import OK, WARNING, Library
from fmu_host import Instance as Component

from mbdfmi import Scene
from mbdfmi.compiler.model import compile_scene
from mbdfmi.run.instance import Instance, SimulationError
from mbdfmi.run.simulate import simulate
from mbdfmi.scene import SceneError, fmi_name

from .masters import forget_work, tease
from .plan import N_DERIVATIVE, dice, pieces
from .telling import all_told

ARRIVING, LEAVING = 0, 1
FIXED = ("rk4", "ros2", "gauss")
ADAPTIVE = ("auto", "rk54", "rk853", "radau")

# evaluations of the accelerations in one communication step: more is told, and the way is not compared
MOST_EVALUATIONS = 20000
TIGHT = 1e-11
MODELS_KEPT = 8

# how far functions of time may be off at communication points, of their largest value
ECHO = 1e-6

# random changes of the state, in units of the error that a step of tolerance 1 may make
KICK = 1e-7


@dataclass(frozen=True)
class Way:
    """One way to run a scene.

    step : s, of steppers with a fixed step. pattern : of communication steps, see `plan.pieces`.
    host : "process", "fmu", or "simulate", the function a user calls.
    memory : "restore" (a snapshot taken in mid-run is gone back to), "serialise" (another instance goes on
        from its bytes), "reset", "second" (beside another instance of the same library that does otherwise),
        "teased" (a master does in mid-run what none should), "untouched" (no parameter is set to what it is).
    interpreted : kernels as plain Python, in a process of their own.
    exact : no inner step goes across a communication point, so nothing is read off between inner steps, where
        there are inputs.
    plain : with the scene's own outputs, not all there are.
    kick : seed of small changes of the state at every communication point, which tell how much an error grows.
    evaluations : as many as a communication step may cost. seconds :
    s of wall time after which the run ends where it is.
    """

    formulation: str = "recursive"
    integrator: str = "auto"
    tolerance: float = 1e-8
    step: float | None = None
    max_step: float | None = None
    pattern: tuple = ("shared",)
    host: str = "process"
    memory: str | None = None
    interpreted: bool = False
    exact: bool = False
    kick: int | None = None
    plain: bool = False
    evaluations: int = MOST_EVALUATIONS
    seconds: float = 20.0

    def __str__(self):
        of_step = f"step {self.step:.3g}" if self.step else f"tolerance {self.tolerance:g}"
        more = [f"max_step {self.max_step:.3g}" if self.max_step else "", self.memory or ""]
        more += [
            "own outputs" if self.plain else "",
            "interpreted" if self.interpreted else "",
            "exact" if self.exact else "",
            f"kick {self.kick}" if self.kick else "",
        ]
        pattern = " ".join(map(str, self.pattern))
        return " ".join(filter(None, [self.host, self.formulation, self.integrator, of_step, pattern, *more]))

    def solver(self):
        """Keys of the scene's solver."""
        table = {
            "formulation": self.formulation,
            "integrator": self.integrator,
            "max_evaluations": self.evaluations,
        }

        if self.step:
            return table | {"step": self.step}

        table |= {"tolerance": self.tolerance, "absolute_tolerance": self.tolerance}
        return table | ({"max_step": self.max_step} if self.max_step else {})


@dataclass
class Run:
    """What came of a way.

    names : of the outputs. times : s, (n,). phases : (n,), ARRIVING or LEAVING. values : (n, n_y).
    notices : as told to a user. start : rows are there. stopped : why the run ended early, None if it did
    not, and refused : why there was none. crashed : a traceback of what is no message to a user.
    most : evaluations in the dearest communication step. odd : what on the way was not as it must be, in
    words.
    """

    way: Way
    names: list[str] = field(default_factory=list)
    times: list[float] = field(default_factory=list)
    phases: list[int] = field(default_factory=list)
    values: list[np.ndarray] = field(default_factory=list)
    notices: list[str] = field(default_factory=list)
    odd: list[str] = field(default_factory=list)
    refused: str | None = None
    stopped: str | None = None
    crashed: str | None = None
    cut: bool = False
    steps: float = 0.0
    evaluations: float = 0.0
    most: float = 0.0
    seconds: float = 0.0

    def note(self, t, phase, values):
        self.times.append(float(t))
        self.phases.append(phase)
        self.values.append(np.array(values, float))

    @property
    def whole(self):
        """Whether the run came to its end."""
        return not (self.refused or self.stopped or self.crashed or self.cut)


def listed(value):
    """A list, where one name may stand alone."""
    return [value] if isinstance(value, str) else list(value)


def scene_of(data, way):
    """The `Scene` of a way. Raises SceneError."""
    solver = {
        key: value for key, value in data.get("solver", {}).items() if key in ("closing_tolerance", "output")
    }

    if way.step and "output" in solver:
        solver["output"] = [name for name in listed(solver["output"]) if name != "estimated_error"]

    return Scene.model_validate((data if way.plain else all_told(data)) | {"solver": solver | way.solver()})


_models = {}


def model_of(data, way):
    """The `Model` of a scene in a way; the last few are kept. Raises SceneError."""
    key = json.dumps([data, way.solver(), way.plain])

    if key not in _models:
        while len(_models) >= MODELS_KEPT:
            del _models[next(iter(_models))]

        _models[key] = compile_scene(scene_of(data, way))

    return _models[key]


def run(data, plan, way, libraries=None):
    """Run a scene (a dict) in a way. libraries : `Libraries`, of ways in an FMU."""
    result = Run(way)
    begun = clock.perf_counter()

    try:
        model = model_of(data, way)
        result.names = [v.name for v in model.of_causality("output")]
        HOSTS[way.host](model, plan, way, result, libraries)
    except SceneError as error:
        result.refused = str(error)
    except SimulationError as error:
        result.stopped = str(error)
        result.refused = str(error) if not result.values else None
    except Exception:
        result.crashed = traceback.format_exc()

    result.seconds = clock.perf_counter() - begun
    return result


class Libraries:
    """FMUs of models, each exported and unpacked once, and unloaded in the end. Use it in a `with`."""

    def __init__(self):
        self._folder = TemporaryDirectory()
        self._of = {}

    def __enter__(self):
        return self

    def __exit__(self, *_):
        for library in self._of.values():
            _ctypes.dlclose(library.dll._handle)

        self._folder.cleanup()

    def of(self, model):
        """The library of a model."""
        from mbdfmi.export import export_fmu

        if model.guid not in self._of:
            place = Path(self._folder.name) / model.guid.strip("{}")
            self._of[model.guid] = Library(export_fmu(model, place.with_suffix(".fmu")), place)

        return self._of[model.guid]


def _in_process(model, plan, way, result, libraries):
    _follow(lambda: _Process(model, plan, way), plan, way, result)


def _in_fmu(model, plan, way, result, libraries):
    library = libraries.of(model)
    _follow(lambda: _Component(library, plan), plan, way, result)


def _by_function(model, plan, way, result, libraries):
    """As a user calls it: inputs are Python functions of time alone."""
    edges = plan.points - 1e-12 * plan.until

    def function(signal):
        return lambda t: signal.value(t, max(0, int(np.searchsorted(edges, t, "right")) - 1))

    n = sum(map(len, pieces(plan, way.pattern)))
    inputs = {name: function(signal) for name, signal in plan.signals.items()}
    found = simulate(model, plan.until, plan.until / n, inputs, as_written(model))
    result.notices = found.notices

    for name, signal in inputs.items():
        given = np.array([signal(t) for t in found["time"]])

        if not np.abs(found[name] - given).max() <= ECHO * (1.0 + np.abs(given).max()):
            result.odd.append(f"input {name} is not told as it was given")

    for k, row in enumerate(np.column_stack([found[name] for name in result.names])):
        result.note(found["time"][k], LEAVING if k < n else ARRIVING, row)


def as_written(model):
    """Masses as they are, by the names that the scene has (which an FMU may write in another way)."""
    starts = {v.name: v.start for v in model.of_causality("parameter")}
    named = {f"{name}.mass": f"{fmi_name(name)}.mass" for name in model.scene.body}
    return {written: starts[name] for written, name in named.items() if name in starts}


HOSTS = {"process": _in_process, "fmu": _in_fmu, "simulate": _by_function}


def _follow(start, plan, way, result):
    """Do what the plan says with an instance that `start` makes, and read all outputs."""
    deadline = clock.perf_counter() + way.seconds
    steps = pieces(plan, way.pattern)
    back_at = int(dice(len(steps), "back", *way.pattern).integers(1, len(steps)))
    driver = start()
    other = start() if way.memory == "second" else None

    try:
        if way.memory == "reset":
            _astray(driver, plan, way, 0, 0.0, steps[0])
            driver.reset()

        t = 0.0
        result.note(t, ARRIVING, driver.begin())

        if other:
            other.begin()

        for k, own in enumerate(steps):
            if k == back_at and way.memory == "restore":
                snapshot = driver.save()
                _astray(driver, plan, way, k, t, own)
                driver.restore(snapshot)

            if k == back_at and way.memory == "teased":
                snapshot = driver.save()
                result.odd += tease(driver.instance)
                driver.restore(snapshot)

            if k == back_at and way.memory == "serialise":
                driver = driver.moved()

            if other and k < 3:
                _astray(other, plan, way, k, t, own)

            t = _interval(driver, plan, way, result, k, t, own)

            if clock.perf_counter() > deadline:
                result.cut = k + 1 < len(steps)
                break
    finally:
        result.notices = driver.notices()
        result.odd += driver.odd
        result.steps, result.evaluations, result.most = driver.work()
        driver.free()

        if other:
            other.free()


def _interval(driver, plan, way, result, k, t, steps):
    """From shared point k to the next; returns the time there (s)."""
    for j, H in enumerate(steps):
        driver.set(plan.settings.get(k, {}) if j == 0 else {}, plan.inputs(t, k))

        driver.kick(k, j)
        result.note(t, LEAVING, driver.outputs())
        driver.step(t, H)
        t += H

    result.note(t, ARRIVING, driver.outputs())
    return t


def _astray(driver, plan, way, k, t, steps):
    """An interval that is to be forgotten: under other inputs, as far as it goes."""
    driver.begin()

    try:
        for H in steps:
            inputs = plan.inputs(t, k)
            inputs[0] *= 1.0 + 1e-3
            driver.set({}, inputs)
            driver.step(t, H)
            driver.outputs()
            t += H
    except SimulationError:
        pass


class _Process:
    """A run in process, driven as a master drives an FMU."""

    def __init__(self, model, plan, way):
        self.model, self.plan, self.way = model, plan, way
        self.index = {v.name: v.index for v in model.of_causality("parameter")}
        self.instance = None
        self.most = 0.0
        self.odd = []

    def begin(self):
        """From the start on, unless it has begun; returns the outputs there."""
        if self.instance is None:
            self.instance = Instance(self.model, inputs=dict(enumerate(self.plan.inputs(0.0, 0)[0])))

        return self.outputs()

    reset = free = lambda self: setattr(self, "instance", None)

    def set(self, parameters, inputs):
        if self.way.memory == "untouched":
            reals = self.instance.reals
            parameters = {
                name: value for name, value in parameters.items() if reals[self.index[name]] != value
            }

        for name, value in parameters.items():
            self.instance.reals[self.index[name]] = value

        if parameters or self.way.memory != "untouched":
            self.instance.prepare()

        self.instance.u[: N_DERIVATIVE * self.model.n_u] = inputs.ravel()

    def kick(self, *step):
        """The state is kicked at the beginning of a step, if the way says so."""
        if self.way.kick is None:
            return

        d = self.instance.d
        rng = dice(self.way.kick, "kick", *step)
        unit = np.maximum(np.abs(d.x), 1.0)
        d.x[:] += KICK * unit * rng.normal(size=len(d.x))
        d.u_known[0] = 0.0

    def outputs(self):
        return self.instance.outputs()

    def step(self, t, H):
        d = self.instance.d

        if self.way.exact:
            d.u_known[0] = 0.0

        before = d.evaluations[0]

        try:
            self.instance.step(H)
        finally:
            self.most = max(self.most, d.evaluations[0] - before)

    def save(self):
        return [array.copy() for array in self._core()]

    def restore(self, snapshot):
        for array, kept in zip(self._core(), snapshot):
            array[:] = kept

        # as the FMU does: the parameters are prepared, and nothing of the work array counts
        self.instance._prepared = self.instance.reals.tobytes()
        forget_work(self.instance.d)

    def moved(self):
        """Another instance that goes on from here."""
        other = _Process(self.model, self.plan, self.way)
        other.begin()
        other.restore(self.save())
        other.instance.notices[:] = self.instance.notices
        return other

    def _core(self):
        return self.instance.d.state_buffer, self.instance.u, self.instance.reals

    def notices(self):
        return list(self.instance.notices) if self.instance else list(self.model.notices)

    def work(self):
        d = self.instance.d if self.instance else None
        return (float(d.steps[0]), float(d.evaluations[0]), self.most) if d else (0.0, 0.0, self.most)


class _Component:
    """A run of the FMU, call by call."""

    def __init__(self, library, plan):
        self.library, self.plan = library, plan
        self.component = Component(library)
        self.inputs = library.references("input")
        self.names = [v.name for v in library.variables.values() if v.causality == "input"]
        self.odd = []
        self.begun = False

    def begin(self):
        if not self.begun:
            c = self.component
            self._ok(c.setup())
            self._ok(c.set(dict(zip(self.inputs, self.plan.inputs(0.0, 0)[0]))) if self.inputs else OK)
            self._ok(c.enter())
            self._ok(c.exit())
            self.begun = True

        return self.outputs()

    def reset(self):
        self._ok(self.component.reset())
        self.component.log.clear()
        self.begun = False

    def set(self, parameters, inputs):
        c = self.component
        self._ok(c.set(parameters) if parameters else OK)
        self._ok(c.set(dict(zip(self.inputs, inputs[0]))) if self.inputs else OK)

        for reference, column in zip(self.inputs, inputs.T):
            for order in range(1, N_DERIVATIVE):
                self._ok(c.set_derivatives(reference, order, column[order]))

        status, echo = c.get(*self.inputs) if self.inputs else (OK, [])
        self._ok(status)

        if list(echo) != list(inputs[0]):
            self.odd.append("inputs are not told as they were set")

    def kick(self, *step):
        pass

    def outputs(self):
        status, values = self.component.get(*self.library.references("output"))
        self._ok(status)
        return np.array(values)

    def step(self, t, H):
        self._ok(self.component.step(t, H))

    def save(self):
        return self.component.save()

    def restore(self, snapshot):
        self._ok(self.component.restore(snapshot))
        self.component.forget(snapshot)

    def moved(self):
        """Another instance that goes on from the bytes of this one."""
        snapshot = self.component.save()
        data = self.component.serialise(snapshot)
        self.component.forget(snapshot)
        other = _Component(self.library, self.plan)
        status, snapshot = other.component.deserialise(data)
        other._ok(status)
        other._ok(other.component.restore(snapshot))
        other.begun = True
        other.component.log[:0] = self.component.log
        self.free()
        return other

    def free(self):
        if self.component and self.component.component:
            self.component.free()
            self.component.component = None

    def notices(self):
        """Warnings, and what steps tell, in the log."""
        return [
            text for status, _, text in self.component.log if status == WARNING or text.startswith("step at")
        ]

    def work(self):
        return 0.0, 0.0, 0.0

    def _ok(self, status):
        if status not in (OK, WARNING):
            text = self.component.message if self.component.log else f"status {status} without a message"
            raise SimulationError(text, 0.0)
