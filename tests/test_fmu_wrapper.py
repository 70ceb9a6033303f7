"""The C wrapper of an FMU, call by call: statuses, life, snapshots, steps, and what it refuses."""

import ctypes
import itertools
import math
import os
import re
import struct
import subprocess
import sys
import zlib
from ctypes import byref, c_double, c_size_t, c_void_p
from pathlib import Path

import fmu_host
import numpy as np
import pytest
from fmu_host import DISCARD, ERROR, OK, WARNING, Instance, Library

from mbdfmi import Scene
from mbdfmi.compiler.model import compile_scene
from mbdfmi.export import export_fmu
from mbdfmi.kernels.status import MESSAGES
from mbdfmi.run.instance import Instance as InProcess
from mbdfmi.scene import read_scene

MODELS = Path(__file__).parents[1] / "models"


def load(name, folder):
    model = compile_scene(read_scene(MODELS / f"{name}.toml"))
    return model, Library(export_fmu(model, folder / f"{name}.fmu"), folder / name)


@pytest.fixture(scope="module")
def arm_model_and_library(tmp_path_factory):
    return load("two_link_arm", tmp_path_factory.mktemp("arm"))


@pytest.fixture(scope="module")
def arm_library(arm_model_and_library):
    return arm_model_and_library[1]


@pytest.fixture(scope="module")
def pendulum_library(tmp_path_factory):
    return load("pendulum", tmp_path_factory.mktemp("pendulum"))[1]


@pytest.fixture
def new(arm_library):
    """Makes instances of the arm and frees them at the end."""
    made = []

    def make(library=arm_library, **arguments):
        made.append(Instance(library, **arguments))
        return made[-1]

    yield make
    for instance in made:
        instance.free()


@pytest.fixture
def arm(new):
    """An arm before its first step."""
    return new().start()


def resource_of(library):
    """The bytes of an FMU's model."""
    return (library.folder / "resources" / "model.bin").read_bytes()


def run(instance, n, H=0.01, first=0, torque=lambda t: 3 * np.sin(5 * t)):
    """Outputs after each of n steps of size H."""
    rows = []
    for i in range(first, first + n):
        assert instance.set({"shoulder.torque": torque(i * H)}) == OK
        assert instance.step(i * H, H) == OK
        rows.append(instance.outputs())
    return rows


# life


def test_version(arm_library):
    for function, text in (("fmi2GetVersion", b"2.0"), ("fmi2GetTypesPlatform", b"default")):
        ask = arm_library.dll[function]
        ask.restype = ctypes.c_char_p
        assert ask() == text


@pytest.mark.parametrize(
    "arguments, complaint",
    [
        ({"guid": b"{another}"}, "the GUID is '{another}', that of the resource file is '{"),
        ({"guid": b""}, "the GUID is missing"),
        ({"name": b""}, "needs a name"),
        ({"location": b""}, "the resource location is missing"),
        ({"location": b"http://host/resources"}, "is not a file: URI"),
        ({"location": b"file://host/resources"}, "names another host"),
        ({"location": b"file:///tmp%00/resources"}, "holds a %%00"),
        ({"location": b"file:///nowhere/at/all"}, "'/nowhere/at/all/model.bin' cannot be opened"),
    ],
)
def test_instantiate_refuses(arm_library, arguments, complaint):
    instance = Instance(arm_library, logging=False, **arguments)

    assert instance.component is None
    assert [entry[:2] for entry in instance.log] == [(ERROR, "logStatusError")]
    assert complaint in instance.message


@pytest.mark.parametrize(
    "form", ["file://{}", "file:{}", "file://localhost{}", "FILE://{}", "file://{}/", "plain"]
)
def test_resource_location(arm_library, tmp_path, form):
    folder = tmp_path / "a b%20ü #1" / "resources"
    folder.mkdir(parents=True)
    (folder / "model.bin").write_bytes(resource_of(arm_library))
    encoded = folder.as_uri().removeprefix("file://")
    location = str(folder) if form == "plain" else form.format(encoded)

    instance = Instance(arm_library, location=location.encode())
    assert instance.component, instance.log
    instance.free()


def test_long_paths(arm_library, tmp_path):
    """Of some thousand letters, with spaces and odd ones; beyond what the system takes the message says how long it is."""
    folder = tmp_path

    for k in range(12):
        folder = folder / (f"{k} ä%41 " + "long " * 45).strip()
    assert 2600 < len(str(folder)) < 4000
    folder.mkdir(parents=True)
    (folder / "model.bin").write_bytes(resource_of(arm_library))

    for location in (folder.as_uri(), str(folder)):
        instance = Instance(arm_library, location=location.encode())
        assert instance.component, instance.log
        instance.free()

    for location in (folder.as_uri() + "/x" * 3000, str(folder) + "/x" * 3000):
        refused = Instance(arm_library, location=location.encode())
        assert refused.component is None
        assert re.search(
            r"'/.{190,200}\.\.\..{190,200}/model\.bin' cannot be opened: its path is of \d{4} bytes, and this "
            r"system takes 4095; unpack the FMU in a folder nearer to the root$",
            refused.message,
        ), refused.message

    (folder / "model.bin").write_bytes(b"MBDFMI")
    refused = Instance(arm_library, location=folder.as_uri().encode())
    assert refused.component is None and "model.bin' is refused: " in refused.message


def test_without_callbacks(new, arm_library):
    instance = new(callbacks=False)
    assert instance.component
    assert instance.get(0)[0] == ERROR
    assert Instance(arm_library, callbacks=False, guid=b"{another}").component is None


def test_null_component(arm_library):
    nothing = object.__new__(Instance)
    nothing.library, nothing.component = arm_library, None
    functions = [name for name in dir(fmu_host.fmpy.fmi2.FMU2Slave) if name.startswith("fmi2")]
    without = {"fmi2GetVersion", "fmi2GetTypesPlatform", "fmi2Instantiate", "fmi2FreeInstance"}

    for function in set(functions) - without - {"fmi2DoStep", "fmi2SetupExperiment"}:
        assert nothing.call(function, *[None] * 6) == ERROR, function
    assert nothing.step(0, 1) == nothing.setup() == ERROR
    nothing.free()


def test_null_arguments(arm):
    one = c_size_t(1)
    calls = {
        "fmi2SetDebugLogging": (1, one, None),
        "fmi2GetReal": (None, one, None),
        "fmi2SetReal": (None, one, None),
        "fmi2GetInteger": (None, one, None),
        "fmi2SetString": (None, one, None),
        "fmi2SetRealInputDerivatives": (None, one, None, None),
        "fmi2GetRealOutputDerivatives": (None, one, None, None),
        "fmi2GetDirectionalDerivative": (None, one, None, one, None, None),
        "fmi2GetFMUstate": (None,),
        "fmi2SetFMUstate": (None,),
        "fmi2SerializedFMUstateSize": (None, None),
        "fmi2SerializeFMUstate": (None, None, one),
        "fmi2DeSerializeFMUstate": (None, one, None),
        "fmi2GetRealStatus": (fmu_host.LAST_SUCCESSFUL_TIME, None),
        "fmi2GetBooleanStatus": (fmu_host.TERMINATED, None),
    }
    for function, arguments in calls.items():
        assert arm.call(function, *arguments) == ERROR, function
        assert arm.message.startswith(function), arm.message

    assert arm.call("fmi2FreeFMUstate", None) == OK
    assert arm.call("fmi2GetReal", None, c_size_t(0), None) == OK


ANY = {"instantiated", "initialization", "complete", "failed", "terminated"}
READABLE = ANY - {"instantiated"}
WRITABLE = {"instantiated", "initialization", "complete"}
STEPPED = {"complete", "failed", "terminated"}

ALLOWED = {
    # the table of FMI 2.0.4, section 4.2.4, without the states that need a pending step
    "fmi2SetDebugLogging": (ANY, (0, c_size_t(0), None)),
    "fmi2SetupExperiment": ({"instantiated"}, (0, c_double(0), c_double(0), 0, c_double(0))),
    "fmi2EnterInitializationMode": ({"instantiated"}, ()),
    "fmi2ExitInitializationMode": ({"initialization"}, ()),
    "fmi2Terminate": ({"complete", "failed"}, ()),
    "fmi2Reset": (ANY, ()),
    "fmi2GetReal": (READABLE, (None, c_size_t(0), None)),
    "fmi2GetInteger": (READABLE, (None, c_size_t(0), None)),
    "fmi2GetBoolean": (READABLE, (None, c_size_t(0), None)),
    "fmi2GetString": (READABLE, (None, c_size_t(0), None)),
    "fmi2SetReal": (WRITABLE, (None, c_size_t(0), None)),
    "fmi2SetInteger": (WRITABLE, (None, c_size_t(0), None)),
    "fmi2SetBoolean": (WRITABLE, (None, c_size_t(0), None)),
    "fmi2SetString": (WRITABLE, (None, c_size_t(0), None)),
    "fmi2SetRealInputDerivatives": (WRITABLE, (None, c_size_t(0), None, None)),
    "fmi2GetRealOutputDerivatives": (STEPPED, (None, c_size_t(0), None, None)),
    "fmi2DoStep": ({"complete"}, (c_double(0.01), c_double(0.01), 0)),
    "fmi2CancelStep": (set(), ()),
}


def bring_to(instance, state):
    """An instance in a state of the standard's state machine, at 0.01 s where it has stepped."""
    if state == "instantiated":
        return instance
    assert instance.setup() == instance.enter() == OK
    if state == "initialization":
        return instance
    assert instance.exit() == instance.step(0, 0.01) == OK
    if state == "failed":
        assert instance.set({"shoulder.torque": 1e308}) == OK
        assert instance.step(0.01, 0.01) == DISCARD
    if state == "terminated":
        assert instance.terminate() == OK
    return instance


@pytest.mark.parametrize("state", sorted(ANY))
@pytest.mark.parametrize("function", ALLOWED)
def test_state_machine(new, function, state):
    instance = bring_to(new(), state)
    states, arguments = ALLOWED[function]
    instance.log.clear()
    status = instance.call(function, *arguments)

    if state in states:
        assert status == OK
    else:
        assert status == ERROR
        assert f"{function} is not allowed in the state '" in instance.message


@pytest.mark.parametrize("state", sorted(ANY))
def test_snapshots_in_every_state(new, state):
    instance = bring_to(new(), state)
    snapshot = instance.save()
    data = instance.serialise(snapshot)

    assert instance.restore(snapshot) == OK
    status, other = instance.deserialise(data)
    assert status == instance.restore(other) == OK
    assert instance.forget(other) == instance.forget(snapshot) == OK
    assert instance.serialise(instance.save()) == data


def test_reset_resets(new, arm):
    before = run(arm, 50)
    assert arm.set({"lower.mass": 3.0}) == OK
    assert arm.step(0.5, 0.25) == OK
    assert arm.set({"shoulder.torque": 1e308}) == OK
    assert arm.step(0.75, 0.01) == DISCARD

    assert arm.reset() == OK
    snapshot = arm.serialise(arm.save())
    assert snapshot == new().serialise(new().save())
    arm.start()
    assert run(arm, 50) == before


def test_instances_are_apart(new):
    def prepare(k):
        instance = new(name=f"arm {k}".encode())
        assert instance.set({"lower.mass": 1.0 + k}) == OK
        return instance.start()

    alone = [run(prepare(k), 40, torque=lambda t: k + t) for k in range(2)]
    first, second = prepare(0), prepare(1)
    together = [[], []]
    for i in range(40):
        together[0] += run(first, 1, first=i, torque=lambda t: 0 + t)
        together[1] += run(second, 1, first=i, torque=lambda t: 1 + t)

    assert together == alone


@pytest.mark.skipif(not Path("/proc/self/statm").exists(), reason="reads /proc")
def test_memory_stays_flat(arm_library):
    def resident():
        return int(Path("/proc/self/statm").read_text().split()[1]) * os.sysconf("SC_PAGE_SIZE")

    def cycle(n):
        for _ in range(n):
            instance = Instance(arm_library, logging=False).start()
            snapshot = instance.save()
            assert instance.step(0, 0.001) == instance.restore(snapshot) == OK
            assert instance.forget(snapshot) == OK
            instance.free()
            Instance(arm_library, logging=False, guid=b"{another}")

    cycle(1000)
    before = resident()
    cycle(10_000)
    assert resident() - before < 500_000


# log


def test_categories(new):
    instance = new(logging=False)

    def select(on, *names):
        array = (ctypes.c_char_p * len(names))(*names)
        return instance.call("fmi2SetDebugLogging", on, c_size_t(len(names)), array)

    assert instance.setup() == instance.enter() == instance.exit() == OK
    assert instance.log == []

    assert select(1, b"logEvents") == instance.terminate() == OK
    assert [(status, category) for status, category, _ in instance.log] == [(OK, "logEvents")]
    assert instance.call("fmi2GetStatus", fmu_host.DO_STEP_STATUS, None) == DISCARD
    assert len(instance.log) == 1

    assert select(1, b"logStatusDiscard") == OK
    assert instance.call("fmi2GetStatus", fmu_host.DO_STEP_STATUS, None) == DISCARD
    assert instance.log[-1][:2] == (DISCARD, "logStatusDiscard")

    # the logger takes a format with #...# for variables: both signs come doubled
    assert select(1, b"100%s#") == ERROR
    assert "unknown category '100%%s##'" in instance.message


# values


def test_unknown_reference(arm):
    for value in (len(arm.library.variables), 2**31, 2**32 - 1):
        assert arm.get(value)[0] == arm.set({value: 1.0}) == ERROR
        assert arm.set_derivatives(value, 1, 0.0) == ERROR
        assert all(f"unknown value reference {value}" in message for _, _, message in arm.log[-3:])


@pytest.mark.parametrize("value", [float("nan"), float("inf"), -float("inf")])
def test_not_finite(new, arm, value):
    for name in ("elbow.torque", "lower.mass"):
        assert arm.set({name: value}) == ERROR
        assert f"'{name}'" in arm.message
    assert arm.set_derivatives("elbow.torque", 1, value) == ERROR
    assert "'elbow.torque'" in arm.message
    assert run(arm, 3) == run(new().start(), 3)


def test_set_all_or_nothing(arm):
    assert arm.set({"shoulder.torque": 5.0, "elbow.torque": float("nan")}) == ERROR
    assert arm.value("shoulder.torque") == 0


def test_outputs_cannot_be_set(arm):
    assert arm.set({"elbow.angle": 1.0}) == ERROR
    assert "'elbow.angle'" in arm.message and "output" in arm.message


def test_parameters(new):
    instance = new()
    assert instance.set({"shoulder.angle_start": 0.1, "lower.mass": 2.0}) == OK
    assert instance.setup() == instance.enter() == OK
    assert instance.set({"shoulder.speed_start": 0.2}) == OK
    names = "lower.mass", "shoulder.angle_start", "shoulder.speed_start"
    assert instance.get(*names) == (OK, [2.0, 0.1, 0.2])
    assert instance.exit() == OK

    assert instance.set({"shoulder.angle_start": 0.3}) == ERROR
    assert "'shoulder.angle_start'" in instance.message and "fixed" in instance.message
    assert instance.set({"lower.mass": 3.0}) == OK
    assert instance.value("lower.mass") == 3.0


def test_tunable_parameter_acts_at_once(arm):
    before = arm.value("elbow.acceleration"), arm.value("elbow.angle")
    assert arm.set({"lower.com[1]": 0.2}) == OK

    assert arm.value("elbow.acceleration") != before[0]
    assert arm.value("elbow.angle") == before[1]


@pytest.mark.parametrize("which", ["arm_library", "pendulum_library"])
def test_a_value_that_stands_changes_nothing(request, new, which):
    """Inputs and parameters written again before every step: all that the solver keeps stays the same, to the bit."""
    library = request.getfixturevalue(which)
    plain, written = new(library).start(), new(library).start()
    parameters = [v.valueReference for v in library.variables.values() if v.variability == "tunable"]
    again = [*library.references("input"), *parameters]

    for i in range(30):
        status, values = written.get(*again)
        assert status == written.set(dict(zip(again, values))) == OK
        assert plain.step(i * 0.03, 0.03) == written.step(i * 0.03, 0.03) == OK
        assert written.outputs() == plain.outputs()

    assert written.serialise(written.save()) == plain.serialise(plain.save())


def test_a_parameter_that_stands_changes_nothing_in_process(arm_model_and_library):
    plain, prepared = (InProcess(arm_model_and_library[0]) for _ in range(2))

    for _ in range(30):
        prepared.prepare()
        plain.step(0.03), prepared.step(0.03)

    np.testing.assert_array_equal(prepared.d.state_buffer, plain.d.state_buffer)
    prepared.reals[:] *= 1 + 1e-3
    prepared.prepare()
    assert not np.array_equal(prepared.d.body_m, plain.d.body_m)


def test_impossible_parameter(new):
    instance = new()
    assert instance.set({"lower.mass": -1.0}) == instance.setup() == instance.enter() == OK
    assert instance.get("elbow.angle")[0] == instance.exit() == ERROR
    assert "the mass of lower is negative" in instance.message

    assert instance.set({"lower.mass": 1.0}) == instance.exit() == OK
    assert instance.set({"lower.mass": -1.0}) == OK
    assert instance.step(0, 0.01) == ERROR
    assert instance.set({"lower.mass": 1.0}) == instance.step(0, 0.01) == OK


def test_initialization_mode_gives_right_values(new):
    instance = new()
    assert instance.setup() == instance.enter() == OK
    first = instance.value("elbow.acceleration")

    assert instance.value("shoulder.angle") == 0.4
    assert instance.set({"shoulder.angle_start": 0.7}) == OK
    assert instance.value("shoulder.angle") == 0.7
    assert instance.set({"elbow.torque": 10.0}) == OK
    assert instance.value("elbow.acceleration") != first


def test_other_types(arm):
    for kind in ("Integer", "Boolean", "String"):
        for verb in ("Get", "Set"):
            reference, value = (ctypes.c_uint * 1)(0), (c_void_p * 1)()
            assert arm.call(f"fmi2{verb}{kind}", reference, c_size_t(1), value) == ERROR
            assert f"value reference 0 is no {kind}" in arm.message


def test_dependencies_are_exact(arm):
    """What an input changes at once is what the description says, for values as good as random: all of them, where it lists none."""
    run(arm, 7)
    described, inputs = arm.library.description.outputs, ("shoulder.torque", "elbow.torque")
    told = {u.variable.name: u.dependencies for u in described}
    outputs = {name: set(inputs) if on is None else {v.name for v in on} for name, on in told.items()}

    for name in inputs:
        before = arm.outputs()
        assert arm.set({name: 12.3}) == OK
        changed = {output for output, a, b in zip(outputs, before, arm.outputs()) if a != b}
        assert changed == {output for output, inputs in outputs.items() if name in inputs}


# steps


@pytest.mark.parametrize("H", [0.0, -0.01, float("nan"), float("inf")])
def test_bad_step_size(arm, H):
    assert arm.step(0, H) == ERROR
    assert "step size" in arm.message
    assert arm.step(0, 0.01) == OK


@pytest.mark.parametrize("t", [0.0, 0.005, 0.02, -0.01, float("nan"), float("inf")])
def test_misplaced_step(arm, t):
    assert arm.step(0, 0.01) == OK
    assert arm.step(t, 0.01) == ERROR
    assert "this FMU is at t = 0.01" in arm.message
    assert arm.step(0.01, 0.01) == OK


def test_stop_time(new):
    instance = new().start(stop=1.0)
    t = 0.0
    for _ in range(10):  # the sum of the steps misses 1 by a rounding error
        assert instance.step(t, 0.1) == OK
        t += 0.1
    assert instance.step(t, 0.1) == ERROR
    assert "after the stop time 1 s" in instance.message

    assert new().setup(0.0, -1.0) == ERROR
    assert new().setup(float("nan")) == ERROR


def with_tolerance(instance, tolerance):
    """The status of the call that tells it."""
    return instance.call("fmi2SetupExperiment", 1, c_double(tolerance), c_double(0.0), 0, c_double(0.0))


@pytest.mark.parametrize("wrong", [-1.0, 0.0, 1e-15, 0.2, math.nan, math.inf])
def test_absurd_tolerances_are_refused(new, pendulum_library, wrong):
    instance = new(pendulum_library)
    assert with_tolerance(instance, wrong) == ERROR
    assert "must be from 1e-14 to 0.1" in instance.message
    assert instance.start().step(0.0, 0.01) == OK


def test_fixed_steps_have_no_tolerance(new):
    plain, told = new().start(), new()
    assert with_tolerance(told, 1e-4) == OK and "takes fixed steps" in told.message
    assert told.enter() == told.exit() == told.step(0.0, 0.1) == plain.step(0.0, 0.1) == OK
    assert told.outputs() == plain.outputs()


def test_whose_tolerance_counts(new, pendulum_library):
    """A parameter that was set, else the master's, else the scene's; a looser one is told."""
    names = "solver.tolerance", "solver.absolute_tolerance"

    def outcome(tolerance=None, before=None, after=None):
        instance = new(pendulum_library)
        assert instance.set(before or {}) == OK
        assert (instance.setup() if tolerance is None else with_tolerance(instance, tolerance)) == OK
        warned = any("looser" in text for status, _, text in instance.log if status == WARNING)
        assert instance.set(after or {}) == instance.enter() == instance.exit() == OK
        for i in range(20):
            assert instance.step(0.05 * i, 0.05) == OK
        return instance.get(*names)[1], instance.outputs(), warned

    scene, own, warned = outcome()
    assert outcome(scene[0]) == (scene, own, False)

    loose, rough, warned = outcome(1e-4)
    assert warned and loose == [1e-4, pytest.approx(scene[1] * 1e-4 / scene[0])] and rough != own
    assert outcome(before=dict(zip(names, loose)))[1] == rough

    tight, _, warned = outcome(1e-11)
    assert not warned and tight == [1e-11, pytest.approx(scene[1] * 1e-11 / scene[0])]

    given = {"solver.tolerance": 1e-6}
    for order in ({"before": given}, {"after": given}):
        found, _, warned = outcome(1e-4, **order)
        assert found[0] == 1e-6
    assert outcome(1e-4, before={"solver.tolerance": scene[0]})[0][0] == scene[0]
    assert outcome(1e-4, before=dict(zip(names, scene)))[:2] == (scene, own)

    # a second call forgets the first, and a reset both
    instance = new(pendulum_library)
    assert with_tolerance(instance, 1e-4) == instance.setup() == instance.enter() == OK
    assert instance.get(*names)[1] == scene
    assert instance.set(given) == instance.reset() == with_tolerance(instance, 1e-4) == instance.enter() == OK
    assert instance.get(*names)[1] == loose


def counts_of_time(H, n, start=0.0):
    """Communication points and step sizes as masters compute them."""
    products = [start + i * H for i in range(n + 1)]
    sums = list(itertools.accumulate([H] * n, initial=start))
    grid = np.linspace(start, start + n * H, n + 1)
    yield products[:-1], [H] * n
    yield sums[:-1], [H] * n
    yield products[:-1], list(np.diff(products))
    yield sums[:-1], list(np.diff(sums))
    yield list(grid[:-1]), list(np.diff(grid))


@pytest.mark.parametrize("which", ["arm_library", "pendulum_library"])
@pytest.mark.parametrize("H", [0.001, 0.01, 1 / 3, 0.007])
def test_ways_to_count_time(request, new, which, H):
    library = request.getfixturevalue(which)
    finals = []

    for points, sizes in counts_of_time(H, 2000):
        instance = new(library).start()
        for t, h in zip(points, sizes):
            assert instance.step(t, h) == OK
        finals.append(instance.outputs())

    assert all(final == finals[0] for final in finals)


def test_start_time_far_away(new):
    start, finals = 1e6, []
    for points, sizes in list(counts_of_time(0.01, 2000, start))[:2]:
        instance = new().start(start)
        for t, h in zip(points, sizes):
            assert instance.step(t, h) == OK
        finals.append(instance.outputs())
    assert finals[0] == finals[1]


def test_variable_steps(new):
    """Steps of any size, some of them smaller than the integrator's own."""
    rng = np.random.default_rng(1)
    instance, t = new().start(), 0.0

    for H in rng.choice([1e-5, 1e-3, 0.0123, 0.2], 200):
        assert instance.step(t, H) == OK
        t += H
    assert instance.last_successful_time() == (OK, t)


def test_failed_step(arm):
    for i in range(3):
        assert arm.step(i * 0.01, 0.01) == OK
    assert arm.last_successful_time() == (OK, 0.03) and arm.terminated() == (OK, 0)
    snapshot = arm.save()
    before = arm.outputs()

    assert arm.set({"shoulder.torque": 1e308}) == OK
    assert arm.step(0.03, 0.01) == DISCARD
    assert arm.log[-1][:2] == (DISCARD, "logStatusDiscard")
    assert any(text.split("%s")[0] in arm.message for text in MESSAGES.values())
    status, time = arm.last_successful_time()
    assert status == OK and 0.03 <= time < 0.04
    assert arm.terminated() == (OK, 1)
    assert np.isfinite(arm.value("shoulder.angle"))
    assert arm.step(time, 0.01) == ERROR

    # back, and on with a bearable input
    assert arm.restore(snapshot) == OK
    assert arm.terminated() == (OK, 0) and arm.last_successful_time() == (OK, 0.03)
    assert arm.outputs() == before
    assert arm.set({"shoulder.torque": 1.0}) == arm.step(0.03, 0.01) == OK


def test_statuses_without_meaning(arm):
    for function in ("Status", "IntegerStatus", "StringStatus"):
        value = c_void_p()
        for kind in range(4):
            assert arm.call(f"fmi2Get{function}", kind, byref(value)) == DISCARD
    real = c_double()
    assert arm.call("fmi2GetRealStatus", fmu_host.TERMINATED, byref(real)) == DISCARD


# input derivatives


def test_input_derivatives_refused(arm):
    assert arm.set_derivatives("shoulder.torque", 0, 1.0) == ERROR
    assert arm.set_derivatives("shoulder.torque", 6, 1.0) == ERROR
    assert "order 6 of 'shoulder.torque'" in arm.message
    assert arm.set_derivatives("elbow.angle", 1, 1.0) == ERROR
    assert "'elbow.angle'" in arm.message and "not an input" in arm.message


def test_input_derivatives_act_in_the_step(new):
    """A torque quadratic in time: a few steps with derivatives, many short steps without."""

    def torque(t):
        return 3 + 40 * t - 70 * t**2

    coarse, fine = new().start(), new().start()
    n, H = 4, 0.25
    for i in range(n):
        t = i * H
        assert coarse.set({"shoulder.torque": torque(t)}) == OK
        assert coarse.set_derivatives("shoulder.torque", 1, 40 - 140 * t) == OK
        assert coarse.set_derivatives("shoulder.torque", 2, -140.0) == OK
        assert coarse.step(t, H) == OK
        assert coarse.value("shoulder.torque") == pytest.approx(torque(t + H), rel=1e-12)

    m = 5000
    for i in range(m):
        t, h = i / m, 1 / m
        assert fine.set({"shoulder.torque": torque(t + h / 2)}) == fine.step(t, h) == OK

    assert coarse.value("shoulder.angle") == pytest.approx(fine.value("shoulder.angle"), abs=1e-6)

    # they last one step
    snapshot = coarse.save()
    assert coarse.step(1.0, H) == OK
    held = coarse.outputs()
    assert coarse.restore(snapshot) == coarse.set_derivatives("shoulder.torque", 1, 0.0) == OK
    assert coarse.step(1.0, H) == OK
    assert coarse.outputs() == held


def test_outputs_follow_input_derivatives(tmp_path):
    """Where a position alone is commanded, its derivative is the speed: read, told, read again, as in process."""
    joint = {
        "revolute": {},
        "between": ["ground", "b"],
        "driver": {"input": ["angle"]},
        "output": ["angle", "speed"],
    }
    scene = Scene(name="told", body={"b": {"mass": 1, "inertia": [1, 1, 1]}}, joint={"j": joint})
    library = Library(export_fmu(compile_scene(scene), tmp_path / "told.fmu"), tmp_path / "told")
    fmu = Instance(library).start()
    assert (
        fmu.set({"j.angle_command": 0.2}) == OK
        and fmu.value("j.angle") == 0.2
        and fmu.value("j.speed") == 0.0
    )
    assert fmu.set_derivatives("j.angle_command", 1, 0.7) == OK
    assert fmu.value("j.speed") == pytest.approx(0.7, abs=1e-15)
    fmu.free()


def test_as_in_process(arm_model_and_library, new):
    """The same kernels in process give the same numbers."""
    model, _ = arm_model_and_library
    rng = np.random.default_rng(0)
    instance, inside = new().start(), InProcess(model)
    names = [v.name for v in model.of_causality("input")]

    for i in range(100):
        inside.u[:] = rng.normal(size=inside.u.size) * 5
        u = inside.u.reshape(6, -1)
        assert instance.set(dict(zip(names, u[0]))) == OK
        for order, name in itertools.product(range(1, 6), names):
            assert instance.set_derivatives(name, order, u[order][names.index(name)]) == OK

        inside.step(0.02)
        assert instance.step(i * 0.02, 0.02) == OK
        np.testing.assert_allclose(instance.outputs(), inside.outputs(), rtol=1e-12, atol=1e-12)


# snapshots


def test_snapshot_is_exact(arm):
    run(arm, 20)
    snapshot = arm.save()
    assert arm.set({"shoulder.torque": 1.5}) == OK
    first = run(arm, 100, first=20)

    assert arm.set({"lower.mass": 2.5}) == OK
    assert arm.restore(snapshot) == OK
    assert arm.value("lower.mass") == 1.5
    assert run(arm, 100, first=20) == first

    # one snapshot restored often, and written over
    assert arm.restore(snapshot) == OK
    assert run(arm, 1, first=20) == first[:1]
    arm.save(snapshot)
    assert arm.restore(snapshot) == OK
    assert run(arm, 1, first=21) == first[1:2]
    assert arm.forget(snapshot) == OK


def test_snapshot_of_an_unprepared_change(arm):
    """A parameter set but not used yet when the state is saved."""
    assert arm.set({"lower.mass": 2.5}) == OK
    snapshot = arm.save()
    first = run(arm, 3)
    assert arm.restore(snapshot) == OK
    assert run(arm, 3) == first


def test_snapshot_of_adaptive_steps(new, pendulum_library):
    instance = new(pendulum_library).start()
    for i in range(10):
        assert instance.step(i * 0.1, 0.1) == OK
    snapshot, ends = instance.save(), []
    for _ in range(2):
        assert instance.restore(snapshot) == OK
        for i in range(10, 110):
            assert instance.step(i * 0.1, 0.1) == OK
        ends.append(instance.outputs())
    assert ends[0] == ends[1]


def test_serialised_across_processes(arm, tmp_path):
    run(arm, 20)
    (tmp_path / "state").write_bytes(arm.serialise(arm.save()))
    program = f"""
import sys; sys.path.insert(0, {str(Path(__file__).parent)!r})
from fmu_host import Instance, Library
from pathlib import Path
import fmpy
class Unpacked(Library):
    def __init__(self, folder):
        fmpy.extract = lambda *_: None
        super().__init__(None, folder)
instance = Instance(Unpacked(Path({str(arm.library.folder)!r})))
status, snapshot = instance.deserialise(Path({str(tmp_path / "state")!r}).read_bytes())
assert status == instance.restore(snapshot) == 0, instance.log
for i in range(20, 120):
    assert instance.step(i*0.01, 0.01) == 0, instance.log
print([x.hex() for x in instance.outputs()])
"""
    there = subprocess.run([sys.executable, "-c", program], capture_output=True, text=True)
    assert there.returncode == 0, there.stderr

    for i in range(20, 120):
        assert arm.step(i * 0.01, 0.01) == OK
    assert there.stdout.strip() == str([x.hex() for x in arm.outputs()])


def test_a_state_begins_with_a_word_of_zeros(arm):
    """fmusim 0.0.39 takes the first word of a state for a pointer to it: NULL is refused, and nothing falls."""
    snapshot = arm.save()
    first = ctypes.cast(snapshot, ctypes.POINTER(ctypes.c_uint64))[0]
    assert first == 0 and arm.serialise(snapshot)[:8] == bytes(8)
    assert arm.call("fmi2SerializedFMUstateSize", c_void_p(first or None), byref(c_size_t())) == ERROR
    assert arm.forget(snapshot) == OK


def test_damaged_states_are_refused(new, arm, pendulum_library):
    run(arm, 5)
    data = arm.serialise(arm.save())
    before = arm.outputs()

    for i in range(len(data)):
        damaged = bytearray(data)
        damaged[i] ^= 1 << i % 8
        status, snapshot = arm.deserialise(bytes(damaged))
        assert status == ERROR and not snapshot.value, i
        assert "the serialised state is refused" in arm.message
    for length in (0, 1, 8, 100, len(data) - 1):
        assert arm.deserialise(data[:length])[0] == ERROR
    assert arm.deserialise(data + b"\0")[0] == ERROR

    other = new(pendulum_library).start()
    assert other.deserialise(data)[0] == ERROR
    assert other.restore(arm.save()) == ERROR
    assert "it belongs to another FMU" in other.message
    assert arm.outputs() == before

    short = ctypes.create_string_buffer(len(data))
    assert arm.call("fmi2SerializeFMUstate", arm.save(), short, c_size_t(len(data) - 1)) == ERROR


# resource


def instantiate_with(library, folder, data):
    """An instance that reads other resources, and its log."""
    (folder / "model.bin").unlink(missing_ok=True)
    (folder / "model.bin").write_bytes(data)
    return Instance(library, location=folder.as_uri().encode(), logging=False)


def test_damaged_resources_are_refused(arm_library, tmp_path):
    data = resource_of(arm_library)
    rng = np.random.default_rng(0)

    def refused(damaged):
        instance = instantiate_with(arm_library, tmp_path, damaged)
        return instance.component is None and "is refused: " in instance.message

    for i in range(len(data)):
        damaged = bytearray(data)
        damaged[i] ^= 1 << int(rng.integers(8))
        assert refused(bytes(damaged)), i
    for length in [*range(0, len(data), 7), len(data) - 1]:
        assert refused(data[:length]), length
    assert refused(data + b"\0")
    assert refused(b"")


@pytest.mark.parametrize("value", [-1, 0, 1, 10**6, 2**31, 2**40, 2**62, -(2**63)])
@pytest.mark.parametrize("count", range(10))
def test_contradicting_resources_are_refused(arm_library, tmp_path, count, value):
    """A right checksum over wrong sizes: refused, or (sizes of memory) harmless, never a crash."""
    data = resource_of(arm_library)
    body = bytearray(data[24:])
    if struct.unpack_from("<q", body, 8 * count)[0] == value:
        pytest.skip("the true size")

    struct.pack_into("<q", body, 8 * count, value)
    damaged = data[:12] + struct.pack("<I", zlib.crc32(body)) + data[16:24] + bytes(body)
    instance = instantiate_with(arm_library, tmp_path, damaged)

    if count in (2, 3) and instance.component:
        instance.free()
    else:
        assert instance.component is None and instance.log
