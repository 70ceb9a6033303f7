"""Model exchange: solvers outside reproduce the co-simulation of the same FMU, on and off the constraints."""

import ctypes
from ctypes import byref, c_double, c_int, c_size_t

import fmpy
import numpy as np
import pytest
from fmpy.validation import validate_fmu
from fmu_host import ERROR, MODEL_EXCHANGE, OK, Instance, Library

from mbdfmi import Scene
from mbdfmi.compiler.model import compile_scene
from mbdfmi.export import export_fmu
from mbdfmi.scene import read_scene
from tests.model_files import SCENES

UNTIL = 0.5  # s


class EventInfo(ctypes.Structure):
    """fmi2EventInfo."""

    _fields_ = [
        ("new_states_needed", c_int),
        ("terminate", c_int),
        ("nominals_changed", c_int),
        ("states_changed", c_int),
        ("next_time_defined", c_int),
        ("next_time", c_double),
    ]


class Solver:
    """An explicit solver of its own: classical Runge-Kutta, from event to event."""

    def __init__(self, library, **start):
        self.fmu = Instance(library, kind=MODEL_EXCHANGE)
        assert self.fmu.component, self.fmu.log
        if start:
            assert self.fmu.set(start) == OK
        assert self.fmu.setup() == self.fmu.enter() == self.fmu.exit() == OK
        self.n = len(library.description.derivatives)
        self.buffer = (c_double * self.n)()
        self.t, self.events, self.updates = 0.0, 0, 0
        self.update()

    def call(self, function, *arguments):
        assert self.fmu.call(function, *arguments) == OK, self.fmu.log

    def update(self):
        info = EventInfo()
        self.call("fmi2NewDiscreteStates", byref(info))
        self.call("fmi2EnterContinuousTimeMode")
        self.next_time = info.next_time if info.next_time_defined else np.inf
        self.updates += 1

    @property
    def x(self):
        self.call("fmi2GetContinuousStates", self.buffer, c_size_t(self.n))
        return np.array(self.buffer)

    def go(self, t, x):
        self.call("fmi2SetTime", c_double(t))
        self.call("fmi2SetContinuousStates", (c_double * self.n)(*x), c_size_t(self.n))

    def rates(self, t, x):
        self.go(t, x)
        self.call("fmi2GetDerivatives", self.buffer, c_size_t(self.n))
        return np.array(self.buffer)

    def euler_step(self, h):
        """A step of Euler's method, and what the FMU makes of it."""
        x = self.x
        rates = self.rates(self.t, x)
        self.t += h
        self.go(self.t, x + h * rates)
        event, end = c_int(), c_int()
        self.call("fmi2CompletedIntegratorStep", 1, byref(event), byref(end))

        if event.value:
            self.events += 1
            self.call("fmi2EnterEventMode")
            self.update()

    def step(self, h):
        t, x = self.t, self.x
        k1 = self.rates(t, x)
        k2 = self.rates(t + h / 2, x + h / 2 * k1)
        k3 = self.rates(t + h / 2, x + h / 2 * k2)
        k4 = self.rates(t + h, x + h * k3)
        self.t = t + h
        self.go(self.t, x + h / 6 * (k1 + 2 * k2 + 2 * k3 + k4))
        event, end = c_int(), c_int()
        self.call("fmi2CompletedIntegratorStep", 1, byref(event), byref(end))
        self.events += event.value

        if event.value or self.t >= self.next_time:
            self.call("fmi2EnterEventMode")
            self.update()

    def run(self, until, h):
        while self.t < until - 1e-9:
            to = min(self.t + h, self.next_time, until)
            self.step(to - self.t)

        return self.fmu.outputs()


@pytest.fixture(scope="module", params=SCENES, ids=lambda path: path.stem)
def exported(request, tmp_path_factory):
    model = compile_scene(read_scene(request.param))
    folder = tmp_path_factory.mktemp("fmu")
    return model, export_fmu(model, folder / "2.fmu"), export_fmu(model, folder / "3.fmu", fmi=3)


@pytest.fixture(scope="module")
def pendulum(tmp_path_factory):
    model = compile_scene(read_scene(next(path for path in SCENES if path.stem == "pendulum")))
    folder = tmp_path_factory.mktemp("pendulum")
    return Library(export_fmu(model, folder / "p.fmu"), folder / "p")


def tight(model):
    """Parameters of a co-simulation to compare with."""
    names = {v.name for v in model.of_causality("parameter")}
    wanted = {"solver.tolerance": 1e-11, "solver.absolute_tolerance": 1e-11, "solver.step": 2e-4}
    return {name: value for name, value in wanted.items() if name in names}


def compare(model, found, expected, bound):
    for v in model.of_causality("output"):
        scale = np.abs(expected[v.name]).max() + 1
        np.testing.assert_allclose(
            found[v.name], expected[v.name], rtol=0, atol=bound * scale, err_msg=v.name
        )


def test_solvers_reproduce_the_co_simulation(exported, tmp_path):
    """CVODE of fmpy in both versions of FMI, and a solver of the test's own, on every scene."""
    model, two, three = exported
    assert validate_fmu(str(two)) == validate_fmu(str(three)) == []
    run = {"stop_time": UNTIL, "output_interval": 0.05}
    expected = fmpy.simulate_fmu(str(two), start_values=tight(model), **run)
    fast = model.name == "spinning_top"  # 150 rad/s
    tolerance = 1e-10 if fast else 1e-9
    exchange = {"fmi_type": "ModelExchange", "relative_tolerance": tolerance, "record_events": False, **run}
    found = fmpy.simulate_fmu(str(two), **exchange)
    compare(model, found, expected, 1e-5)

    again = fmpy.simulate_fmu(str(three), **exchange)
    for name in again.dtype.names:
        flat = again[name].reshape(len(again), -1)
        ending = [""] if again[name].ndim == 1 else [f"[{k + 1}]" for k in range(flat.shape[1])]
        for k, end in enumerate(ending):
            np.testing.assert_array_equal(flat[:, k], found[name + end])

    solver = Solver(Library(two, tmp_path / "own"))
    own = solver.run(UNTIL, {"spinning_top": 1e-4, "rattleback": 1e-4}.get(model.name, 1e-3))
    last = {v.name: value for v, value in zip(model.of_causality("output"), own)}
    compare(model, last, {name: expected[name][-1] for name in last}, 1e-6)
    solver.fmu.free()


def test_the_method_of_euler_converges_to_it(exported):
    """Euler's of fmpy, twice, extrapolated: what is left is of the second order in its step.

    A top at 150 rad/s is followed for a tenth of the time.
    """
    model, two, _ = exported
    interval = 0.002 if model.name == "spinning_top" else 0.02
    stop = {"record_events": False, "stop_time": 5 * interval}
    expected = fmpy.simulate_fmu(str(two), start_values=tight(model), output_interval=interval, **stop)
    exchange = {"fmi_type": "ModelExchange", "solver": "Euler", **stop}
    fast = model.name == "rattleback"
    parts = (1600, 3200) if fast else (200, 400)
    runs = [
        fmpy.simulate_fmu(str(two), output_interval=interval / n, step_size=interval / n, **exchange)
        for n in parts
    ]
    coarse, fine = (run[::n] for run, n in zip(runs, parts))
    found = {name: 2 * fine[name] - coarse[name] for name in fine.dtype.names}
    compare(model, found, expected, 1e-3 if fast else 1e-5)


# on the constraints


def scene_of(name):
    return read_scene(next(path for path in SCENES if path.stem == name))


def library_of(scene, folder):
    model = compile_scene(scene)
    return model, Library(export_fmu(model, folder / "it.fmu"), folder / "it")


def test_loops_stay_closed_for_a_poor_solver(tmp_path):
    """Euler's method, 1e4 steps that lead off the loop each time: what the FMU tells keeps to it."""
    model, library = library_of(scene_of("four_bar"), tmp_path)
    solver = Solver(library)

    for _ in range(10_000):
        solver.euler_step(1e-4)

        assert abs(solver.fmu.value("constraint_gap")) < 1e-9

    assert 0 < solver.events < 100
    solver.fmu.free()


@pytest.mark.long
@pytest.mark.parametrize(
    "name", ["bicycle", "bricard", "four_bar", "marble_run", "satellite", "spinning_top"]
)
def test_a_hundred_thousand_steps_on_the_constraints(name, tmp_path, check):
    """Euler's method with steps of 1e-4 s: gaps below 1e-9 m, Euler parameters of length 1 to 1e-12 at each of them."""
    scene = scene_of(name)
    scene.output = sorted({*scene.output, "constraint_gap"})
    for body in scene.body.values():
        body.output = sorted({*body.output, "euler_parameters"})
    library = library_of(scene, tmp_path)[1]
    solver = Solver(library)
    names = [key for key in library.variables if key.endswith("euler_parameters[1]") and "state" not in key]
    wanted = ["constraint_gap"] + [f"{key[:-2]}{k}]" for key in names for k in (1, 2, 3, 4)]
    gap = length = 0.0

    for _ in range(100_000):
        solver.euler_step(1e-4)

        found = solver.fmu.get(*wanted)[1]
        gap = max(gap, abs(found[0]))
        E = np.reshape(found[1:], (-1, 4))
        length = max(length, np.abs(np.linalg.norm(E, axis=1) - 1).max(initial=0))

    solver.fmu.free()
    check(gap, 1e-9)
    check(length, 1e-12)


def test_orientations_stay_of_unit_length(tmp_path):
    model, library = library_of(scene_of("spinning_top"), tmp_path)
    solver = Solver(library)

    for _ in range(200):
        solver.step(2e-3)  # 0.3 rad
        E = solver.fmu.get(*(f"top.disc.euler_parameters[{k}]" for k in range(1, 5)))[1]
        assert abs(np.linalg.norm(E) - 1) < 1e-12

    solver.fmu.free()


def test_off_the_constraints_nothing_changes_but_what_lies_along_them(tmp_path):
    """A state and one that is pushed off the loop in the metric of the masses: rates are the same."""
    model, library = library_of(scene_of("spinning_top"), tmp_path)
    solver = Solver(library)
    x = solver.x
    rates = solver.rates(0.0, x)
    off = x.copy()
    off[:4] *= 1 + 1e-4
    np.testing.assert_allclose(solver.rates(0.0, off), rates, rtol=1e-12, atol=1e-10)
    np.testing.assert_array_equal(solver.x, off)
    event, end = c_int(), c_int()
    solver.call("fmi2CompletedIntegratorStep", 1, byref(event), byref(end))
    assert not event.value

    solver.go(0.0, x * np.array([*[1.01] * 4, 1, 1, 1]))
    solver.call("fmi2CompletedIntegratorStep", 1, byref(event), byref(end))
    assert event.value and not end.value
    solver.call("fmi2EnterEventMode")
    solver.update()
    np.testing.assert_allclose(solver.x, x, rtol=0, atol=1e-12)
    solver.fmu.free()


# events


def pushed(interpolation, **joint):
    """A mass on a rail under a force by a table over time."""
    load = {"table": {"time": [0.1, 0.2, 0.35], "force": [[1, 0, 0], [3, 0, 0], [2, 0, 0]]}}
    load["table"]["interpolation"] = interpolation
    rail = {"prismatic": {"axis": "x"}, "between": ["ground", "b"], "output": ["position", "speed"], **joint}
    body = {"b": {"mass": 2.0, "inertia": [1, 1, 1]}}
    return Scene(
        name="pushed",
        gravity=[0, 0, 0],
        body=body,
        joint={"rail": rail},
        force={"f": {"load": load, "on": "b"}},
    )


@pytest.mark.parametrize("interpolation, power, events", [("steps", 0, 2), ("linear", 1, 3)])
def test_time_events_at_kinks_of_tables(tmp_path, interpolation, power, events):
    """With a step that meets no knot, Runge-Kutta is exact: it stops at each kink, and sees the values from before it."""
    model, library = library_of(pushed(interpolation), tmp_path)
    solver = Solver(library)
    position, speed = solver.run(0.5, 0.03)
    t = np.linspace(0, 0.5, 500_001)
    knots, force = np.array([0.1, 0.2, 0.35]), np.array([1.0, 3.0, 2.0])
    f = np.interp(t, knots, force) if power else force[np.clip(np.searchsorted(knots, t, "right") - 1, 0, 2)]
    impulse = np.concatenate([[0], np.cumsum((f[1:] + f[:-1]) / 2)]) * (t[1] - t[0])
    if not power:
        impulse[-1] = 0.2 * 1 + 0.15 * 3 + 0.15 * 2
    assert speed == pytest.approx(impulse[-1] / 2.0, rel=1e-12 if not power else 1e-9)
    assert solver.updates == 1 + events
    solver.fmu.free()


def test_indicators_of_stops(tmp_path):
    """How far a joint is from its stops, with the sign that changes in touch; fmpy's CVODE stops there."""
    stop = {"lower": -0.1, "upper": 0.02, "stiffness": 1e4, "damping": 10}
    scene = pushed("linear", stop=stop, start={"position": 0.015, "speed": 0.5})
    model, library = library_of(scene, tmp_path)
    solver = Solver(library)
    z = (c_double * 2)()
    solver.call("fmi2GetEventIndicators", z, c_size_t(2))
    np.testing.assert_allclose(list(z), [0.005, 0.115], rtol=1e-12)
    assert solver.fmu.value("rail.stop.to_upper") == z[0]
    assert solver.fmu.call("fmi2GetEventIndicators", z, c_size_t(1)) == ERROR
    solver.fmu.free()

    run = {"stop_time": 0.3, "output_interval": 0.01}
    expected = fmpy.simulate_fmu(str(tmp_path / "it.fmu"), start_values=tight(model), **run)
    exchange = {"fmi_type": "ModelExchange", "relative_tolerance": 1e-9, **run}
    found = fmpy.simulate_fmu(str(tmp_path / "it.fmu"), record_events=False, **exchange)
    compare(model, found, expected, 1e-6)

    # in touch, and out of it again
    events = fmpy.simulate_fmu(str(tmp_path / "it.fmu"), **exchange)
    at = events["time"][np.flatnonzero(np.diff(events["time"]) == 0)]
    assert len(at) >= 2 and at[0] == pytest.approx(0.01, abs=1e-4)


# calls


def test_states_are_as_described(exported, tmp_path):
    """Names, units, nominals, rates; the rates of a co-simulation are those of model exchange."""
    model, two, _ = exported
    library = Library(two, tmp_path / "own")
    solver, step = Solver(library), Instance(library).start()
    rates = solver.rates(0.0, solver.x)
    states = [u.variable.derivative for u in library.description.derivatives]
    nominals = (c_double * solver.n)()
    solver.call("fmi2GetNominalsOfContinuousStates", nominals, c_size_t(solver.n))

    for k, (state, unknown) in enumerate(zip(states, library.description.derivatives)):
        assert unknown.variable.name == f"der({state.name})"
        assert float(state.nominal) == nominals[k] > 0
        assert step.value(state.name) == pytest.approx(solver.x[k], rel=1e-13, abs=1e-13)
        assert step.value(unknown.variable.name) == pytest.approx(rates[k], rel=1e-9, abs=1e-9)

    solver.fmu.free()
    step.free()


def test_outputs_list_the_states_that_lead_them(exported, tmp_path):
    """Each state moved in turn: what changes lists it."""
    model, two, _ = exported
    solver = Solver(Library(two, tmp_path / "own"))
    x, outputs = solver.x, model.of_causality("output")
    before = np.array(solver.fmu.outputs())

    for k, state in enumerate(model.of_causality("state")):
        reference = model.listed.index(state)
        moved = x.copy()
        moved[k] += 1e-4 * model.nominal_of(state)
        solver.go(0.0, moved)
        changed = np.abs(np.array(solver.fmu.outputs()) - before) > 1e-9 * (1 + np.abs(before))
        assert all(reference in v.led_by for v, feels in zip(outputs, changed) if feels), state.name

    solver.fmu.free()


ANY = {"instantiated", "initialization", "event", "continuous", "terminated"}
NONE = (None, c_size_t(0))
ALLOWED = {
    "fmi2SetTime": ({"event", "continuous"}, (c_double(0.0),)),
    "fmi2EnterEventMode": ({"continuous"}, ()),
    "fmi2NewDiscreteStates": ({"event"}, (byref(EventInfo()),)),
    "fmi2EnterContinuousTimeMode": ({"event"}, ()),
    "fmi2CompletedIntegratorStep": ({"continuous"}, (1, byref(c_int()), byref(c_int()))),
    "fmi2GetNominalsOfContinuousStates": (ANY, ((c_double * 2)(), c_size_t(2))),
    "fmi2GetContinuousStates": (ANY - {"instantiated"}, ((c_double * 2)(), c_size_t(2))),
    "fmi2GetDerivatives": (ANY - {"instantiated"}, ((c_double * 2)(), c_size_t(2))),
    "fmi2GetEventIndicators": (ANY - {"instantiated"}, NONE),
    "fmi2SetContinuousStates": ({"continuous"}, ((c_double * 2)(), c_size_t(2))),
    "fmi2DoStep": (set(), (c_double(0), c_double(0.1), 1)),
    "fmi2SetRealInputDerivatives": ({"instantiated", "initialization"}, (None, c_size_t(0), None, None)),
    "fmi2Terminate": ({"event", "continuous"}, ()),
    "fmi2Reset": (ANY, ()),
}


@pytest.mark.parametrize("state", sorted(ANY))
def test_state_machine(pendulum, state):
    for function, (states, arguments) in ALLOWED.items():
        fmu = Instance(pendulum, kind=MODEL_EXCHANGE)
        if state != "instantiated":
            assert fmu.setup() == fmu.enter() == OK
        if state not in ("instantiated", "initialization"):
            assert fmu.exit() == fmu.call("fmi2NewDiscreteStates", byref(EventInfo())) == OK
        if state == "continuous":
            assert fmu.call("fmi2EnterContinuousTimeMode") == OK
        if state == "terminated":
            assert fmu.terminate() == OK

        expected = OK if state in states and function != "fmi2SetRealInputDerivatives" else ERROR
        assert fmu.call(function, *arguments) == expected, function
        fmu.free()


def test_refusals(pendulum):
    solver = Solver(pendulum)
    fmu, x = solver.fmu, (c_double * 3)(0.1, float("nan"), 0.0)
    assert fmu.call("fmi2SetContinuousStates", x, c_size_t(2)) == ERROR and "state 2 is nan" in fmu.message
    assert fmu.call("fmi2SetContinuousStates", x, c_size_t(3)) == ERROR and "there are 2" in fmu.message
    assert fmu.call("fmi2SetTime", c_double(float("inf"))) == ERROR
    assert fmu.call("fmi2GetDerivatives", None, c_size_t(2)) == ERROR
    assert fmu.call("fmi2CompletedIntegratorStep", 1, None, None) == ERROR
    rate = next(v for v in pendulum.variables.values() if v.derivative)
    assert fmu.set({rate.name: 1.0}) == ERROR and "is calculated and cannot be set" in fmu.message
    parameter = next(v.name for v in pendulum.variables.values() if v.variability == "tunable")
    value = fmu.value(parameter)
    assert fmu.set({parameter: value}) == ERROR and "in event mode only" in fmu.message
    solver.call("fmi2EnterEventMode")
    assert fmu.set({parameter: value}) == OK
    fmu.free()


def test_snapshots_and_reset(pendulum):
    solver = Solver(pendulum)
    solver.run(0.1, 0.01)
    snapshot, t = solver.fmu.save(), solver.t
    data = solver.fmu.serialise(snapshot)
    first = solver.run(0.3, 0.01)
    assert solver.fmu.restore(snapshot) == OK
    solver.t = t
    assert solver.run(0.3, 0.01) == first

    other = Solver(pendulum)
    status, copy = other.fmu.deserialise(data)
    assert status == other.fmu.restore(copy) == OK
    other.t = t
    assert other.run(0.3, 0.01) == first

    step = Instance(pendulum).start()
    assert step.deserialise(data)[0] == ERROR and "it is one of model exchange" in step.message
    assert step.step(0.0, 0.1) == OK
    assert solver.fmu.deserialise(step.serialise(step.save()))[0] == ERROR
    assert solver.fmu.reset() == OK
    for fmu in (solver.fmu, other.fmu, step):
        fmu.free()


# commanded motions


def told(*quantities, **more):
    """A double pendulum whose first joint inputs command, True for position, speed and acceleration."""
    body = {f"b{k}": {"mass": 1.0, "inertia": [0.1, 0.1, 0.1], "com": [0.3, 0, 0]} for k in range(2)}
    body["b0"]["marker"] = {"tip": {"position": [1, 0, 0]}}
    first = {"revolute": {}, "between": ["ground", "b0"], "driver": {"input": list(quantities) or True}}
    second = {"revolute": {}, "between": ["b0.tip", "b1"], "output": ["angle", "speed", "acceleration"]}
    joint = {"j": first | {"output": ["angle", "speed", "effort"]}, "k": second}
    return Scene(name="told", gravity=[0, -9.81, 0], body=body, joint=joint, **more)


class Commanded(Solver):
    """With a joint's commands by (position, speed, acceleration) as a function of time."""

    def __init__(self, library, joint, motion):
        self.names = [f"{joint}.{quantity}_command" for quantity in ("angle", "speed", "acceleration")]
        self.motion = motion
        super().__init__(library, **dict(zip(self.names, map(float, motion(0.0)))))

    def go(self, t, x):
        super().go(t, x)
        assert self.fmu.set(dict(zip(self.names, map(float, self.motion(t))))) == OK


def same_as_driven(scene, joint, motion, driver, folder, until):
    """Outputs by name at the end of a run where `joint` is commanded, and where the scene drives it so."""
    found = []

    for name, given in (("commanded", {"input": True}), ("driven", driver)):
        tables = scene.model_dump(exclude_unset=True, by_alias=True)
        tables["joint"][joint]["driver"] = given
        if name == "driven":
            tables["joint"][joint].pop("start", None)
        (folder / name).mkdir()
        model, library = library_of(Scene.model_validate(tables), folder / name)
        assert validate_fmu(str(folder / name / "it.fmu")) == []
        solver = Commanded(library, joint, motion) if name == "commanded" else Solver(library)
        found.append(dict(zip((v.name for v in model.of_causality("output")), solver.run(until, 1e-3))))
        solver.fmu.free()

    return found


def test_commanded_motions_with_their_rates(tmp_path):
    """Runge-Kutta outside, inputs at each of its points: as the same motion prescribed by the scene, to 1e-9."""
    wave = {"mean": 0.4, "amplitude": 0.4, "frequency": 3 / (2 * np.pi), "phase_deg": -90}

    def motion(t):
        return 0.4 * (1 - np.cos(3 * t)), 1.2 * np.sin(3 * t), 3.6 * np.cos(3 * t)

    found, expected = same_as_driven(told(), "j", motion, {"harmonic": wave}, tmp_path, 1.0)
    for name, value in expected.items():
        assert found[name] == pytest.approx(value, rel=1e-9, abs=1e-9), name
    assert found["j.angle"] == pytest.approx(motion(1.0)[0], rel=1e-12)


def test_commanded_loops(tmp_path):
    """A four-bar whose crank is commanded: loops stay closed, and all is as with the crank driven by the scene."""
    tables = scene_of("four_bar").model_dump(exclude_unset=True, by_alias=True)
    crank = tables["joint"]["crank_pivot"]
    del crank["input"]
    crank |= {
        "driver": {"input": True},
        "output": ["angle", "speed"],
        "start": {"angle": 1.0, "speed": 0.3 * np.pi},
    }
    tables["output"] = ["constraint_gap"]
    tables.pop("view", None)
    wave = {"mean": 1.0, "amplitude": 0.3, "frequency": 0.5}

    def motion(t):
        s, c = np.sin(np.pi * t), np.cos(np.pi * t)
        return 1.0 + 0.3 * s, 0.3 * np.pi * c, -0.3 * np.pi**2 * s

    scene = Scene.model_validate(tables)
    found, expected = same_as_driven(scene, "crank_pivot", motion, {"harmonic": wave}, tmp_path, 0.5)
    assert found["constraint_gap"] < 1e-9
    for name, value in expected.items():
        assert found[name] == pytest.approx(value, rel=1e-8, abs=1e-8), name


def test_derivatives_by_commands(tmp_path):
    """Rates by a command, in model exchange, are those of differences; the state is not touched."""
    model, library = library_of(told(), tmp_path)
    solver = Commanded(library, "j", lambda t: (0.2, 0.5, 1.0))
    x = solver.x
    solver.go(0.1, x)
    rate = f"der({model.of_causality('state')[-1].name})"
    found = solver.fmu.along([rate], ["j.acceleration_command"], [1.0])[1][0]

    def at(value):
        assert solver.fmu.set({"j.acceleration_command": value}) == OK
        return solver.fmu.value(rate)

    assert found == pytest.approx((at(2.0) - at(0.0)) / 2, rel=1e-8)
    assert (solver.x == x).all()
    solver.fmu.free()


@pytest.mark.parametrize("quantities", (["angle"], ["angle", "speed"]))
def test_commands_without_accelerations_are_for_co_simulation_only(quantities, tmp_path):
    model, library = library_of(told(*quantities), tmp_path)
    assert library.description.modelExchange is None and not model.exchanges
    fmu = Instance(library, kind=MODEL_EXCHANGE)
    assert fmu.component is None and "for co-simulation only" in fmu.message
    said = []
    export_fmu(model, tmp_path / "again.fmu", progress=said.append)
    assert any("inputs command motions without their accelerations" in text for text in said)


@pytest.mark.parametrize("fmi", (2, 3))
def test_round_surfaces(tmp_path, fmi):
    """A ball in a bowl: the direction that its place on the bowl is read off belongs to the states."""
    scene = Scene(
        name="bowl",
        ground={"marker": {"bowl": {"surface": {"sphere": {"radius": 2.0}}}}},
        body={
            "ball": {
                "solid": {"sphere": {"radius": 0.2, "density": 1000.0}},
                "marker": {"skin": {"surface": {"sphere": {"radius": 0.2}}}},
                "output": ["position"],
            }
        },
        joint={
            "place": {
                "free": {},
                "between": ["ground", "ball"],
                "start": {"position": [0.3, 0, -1.77]},
            },
            "roll": {"rolling_surface": {}, "between": ["ground.bowl", "ball.skin"]},
        },
    )
    path = str(scene.export(tmp_path / "bowl.fmu", fmi=fmi) or tmp_path / "bowl.fmu")
    assert not validate_fmu(path)
    found = [
        fmpy.simulate_fmu(path, fmi_type=kind, stop_time=UNTIL, output_interval=0.01, relative_tolerance=1e-9)
        for kind in ("ModelExchange", "CoSimulation")
    ]

    rows = np.searchsorted(found[0]["time"], found[1]["time"] - 1e-9)  # events add rows

    for name in found[0].dtype.names:
        np.testing.assert_allclose(found[0][name][rows], found[1][name], atol=1e-6)


def test_states_one_by_one(pendulum):
    """As some solvers set them (CasADi): the same as all at once; not where the FMU solves by itself, and no NaN."""
    solver, other = Solver(pendulum), Solver(pendulum)
    states = [u.variable.derivative.name for u in pendulum.description.derivatives]
    x = solver.x + 0.1 * np.arange(1, solver.n + 1)
    solver.go(0.0, x)
    assert other.fmu.set(dict(zip(states, x))) == OK
    rates = [f"der({name})" for name in states]
    assert other.fmu.get(*rates, *states) == solver.fmu.get(*rates, *states)
    assert other.fmu.outputs() == solver.fmu.outputs()
    assert other.fmu.set({states[0]: float("nan")}) == ERROR
    solver.fmu.free(), other.fmu.free()

    fmu = Instance(pendulum).start()
    assert fmu.set({states[0]: 0.1}) == ERROR and "cannot be set" in fmu.message
    fmu.free()
