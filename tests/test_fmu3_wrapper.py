"""The C wrapper of an FMU of FMI 3.0, call by call: it is the FMU of FMI 2.0 in other words, to the bit."""

import ctypes
import re
from ctypes import c_bool, c_double, c_size_t, c_void_p
from pathlib import Path

import fmpy
import fmu_host
import fmu_host3
import numpy as np
import pytest
from fmu_host import DISCARD, ERROR, OK
from fmu_host3 import UPDATE, Instance
from lxml import etree

from mbdfmi.compiler.model import compile_scene
from mbdfmi.export import export_fmu
from mbdfmi.scene import read_scene

MODELS = Path(__file__).parents[1] / "models"


def load(path, folder):
    """A model's libraries of FMI 2 and FMI 3."""
    model = compile_scene(read_scene(MODELS / path))
    hosts = ((2, fmu_host), (3, fmu_host3))
    return [
        host.Library(export_fmu(model, folder / f"{fmi}.fmu", fmi=fmi), folder / str(fmi))
        for fmi, host in hosts
    ]


@pytest.fixture(scope="module")
def arms(tmp_path_factory):
    return load("two_link_arm.toml", tmp_path_factory.mktemp("arm"))


@pytest.fixture(scope="module")
def turbine(tmp_path_factory):
    path = "floating_wind_turbine/floating_wind_turbine.toml"
    return load(path, tmp_path_factory.mktemp("turbine"))[1]


@pytest.fixture
def new(arms):
    """Makes instances of the arm in FMI 3 and frees them at the end."""
    made = []

    def make(library=arms[1], **arguments):
        made.append(Instance(library, **arguments))
        return made[-1]

    yield make
    for instance in made:
        instance.free()


@pytest.fixture
def arm(new):
    """An arm before its first step."""
    return new().start()


def run(instance, n, H=0.01, first=0):
    """Outputs after each of n steps."""
    rows = []
    for i in range(first, first + n):
        assert instance.set({"shoulder.torque": 3 * np.sin(5 * i * H)}) == instance.step(i * H, H) == OK
        rows.append(instance.outputs())
    return rows


# the same FMU


def test_bits_of_fmi_2(arms, arm):
    two = fmu_host.Instance(arms[0]).start()
    assert run(arm, 100) == run(two, 100)

    # one state: it goes from the one to the other
    status, snapshot = two.deserialise(arm.serialise(arm.save()))
    assert status == two.restore(snapshot) == OK
    assert run(arm, 30, first=100) == run(two, 30, first=100)
    two.free()


def test_version(arms):
    ask = arms[1].dll.fmi3GetVersion
    ask.restype = ctypes.c_char_p
    assert ask() == b"3.0"


@pytest.mark.parametrize(
    "arguments, complaint",
    [
        ({"token": b"{another}"}, "the GUID is '{another}', that of the resource file is '{"),
        ({"token": b""}, "the GUID is missing"),
        ({"name": b""}, "needs a name"),
        ({"path": b""}, "the resource location is missing"),
        ({"path": b"/nowhere/at/all/"}, "'/nowhere/at/all/model.bin' cannot be opened"),
        ({"kind": "ScheduledExecution"}, "not for scheduled execution"),
        (
            {"extra": (c_bool(False), c_bool(False), (ctypes.c_uint * 1)(0), c_size_t(1))},
            "there is no intermediateUpdate to tell them to",
        ),
    ],
)
def test_instantiate_refuses(arms, arguments, complaint):
    instance = Instance(arms[1], logging=False, **arguments)

    assert instance.component is None
    assert [entry[:2] for entry in instance.log] == [(ERROR, "logStatusError")]
    assert complaint in instance.message


# states

ANY = {"instantiated", "initialization", "step", "terminated"}
NOTHING = (None, c_size_t(0), None, c_size_t(0))
RESULTS = [(c_bool * 1)(), (c_bool * 1)(), (c_bool * 1)(), (c_double * 1)()]

ALLOWED = {
    "fmi3SetDebugLogging": (ANY, (c_bool(False), c_size_t(0), None)),
    "fmi3EnterInitializationMode": (
        {"instantiated"},
        (c_bool(False), c_double(0), c_double(0), c_bool(False), c_double(0)),
    ),
    "fmi3ExitInitializationMode": ({"initialization"}, ()),
    "fmi3Terminate": ({"step"}, ()),
    "fmi3Reset": (ANY, ()),
    "fmi3GetFloat64": (ANY, NOTHING),
    "fmi3GetInt32": (ANY, NOTHING),
    "fmi3GetString": (ANY, NOTHING),
    "fmi3GetBinary": (ANY, (None, c_size_t(0), None, None, c_size_t(0))),
    "fmi3SetFloat64": (ANY - {"terminated"}, NOTHING),
    "fmi3SetBoolean": (ANY - {"terminated"}, NOTHING),
    "fmi3GetOutputDerivatives": ({"step", "terminated"}, (None, c_size_t(0), None, None, c_size_t(0))),
    "fmi3DoStep": ({"step"}, (c_double(0.01), c_double(0.01), c_bool(True), *RESULTS)),
    "fmi3EnterEventMode": (set(), ()),
    "fmi3EnterStepMode": (set(), ()),
    "fmi3EnterConfigurationMode": (set(), ()),
    "fmi3ExitConfigurationMode": (set(), ()),
    "fmi3EvaluateDiscreteStates": (set(), ()),
    "fmi3SetTime": (set(), (c_double(0),)),
    "fmi3ActivateModelPartition": (set(), (0, c_double(0))),
}


@pytest.mark.parametrize("state", sorted(ANY))
@pytest.mark.parametrize("function", ALLOWED)
def test_state_machine(new, function, state):
    instance = new()
    if state != "instantiated":
        assert instance.enter() == OK
    if state in ("step", "terminated"):
        assert instance.exit() == instance.step(0, 0.01) == OK
    if state == "terminated":
        assert instance.call("fmi3Terminate") == OK

    states, arguments = ALLOWED[function]
    status = instance.call(function, *arguments)
    assert status == (OK if state in states else ERROR)
    if state not in states:
        assert f"{function} is not allowed in the state '" in instance.message


def test_all_functions_are_there(arms):
    header = (Path(fmpy.__file__).parent / "c-code" / "fmi3Functions.h").read_text()
    names = set(re.findall(r"FMI3_Export \w+\s+(fmi3\w+);", header))
    assert len(names) > 70 and all(hasattr(arms[1].dll, name) for name in names)

    nothing = object.__new__(Instance)
    nothing.library, nothing.component = arms[1], None
    pure = {"fmi3GetVersion", "fmi3FreeInstance", "fmi3DoStep", "fmi3EnterInitializationMode"}
    for name in names - pure:
        if "Instantiate" not in name:
            assert nothing.call(name, *[None] * 9) == ERROR, name
    assert nothing.step(0, 1) == nothing.enter() == ERROR
    nothing.free()


# values


def test_arrays(turbine):
    """Vectors and matrices by rows; their elements have no reference of their own; time is a variable."""
    variables = turbine.variables
    assert [int(d.start) for d in variables["hydrostatics.stiffness"].dimensions] == [6, 6]
    assert [int(d.start) for d in variables["platform.force"].dimensions] == [3]
    stiffness = np.array(variables["hydrostatics.stiffness"].start.split(), float)

    fmu = Instance(turbine)
    assert fmu.get("hydrostatics.stiffness") == (OK, list(stiffness))
    new = list(stiffness * 1.01)
    assert fmu.set({"hydrostatics.stiffness": new, "gravity": [0.0, 0.0, -9.8]}) == OK
    assert fmu.get("gravity", "hydrostatics.stiffness") == (OK, [0.0, 0.0, -9.8, *new])
    fmu.start(start=2.0)
    assert fmu.set({"platform.force": [1e5, 0.0, 0.0]}) == fmu.step(2.0, 0.1) == OK
    assert fmu.get("platform.force", "time") == (OK, [1e5, 0.0, 0.0, 2.1])
    assert fmu.outputs() and fmu.told == (False, False, False, 2.1)

    inner = variables["platform.force"].valueReference + 1
    assert fmu.get(inner)[0] == fmu.set({inner: 1.0}) == ERROR
    assert f"value reference {inner} is the element 'platform.force[2]' of an array" in fmu.message
    assert fmu.get("platform.force", room=2)[0] == ERROR and "2 values for variables of 3" in fmu.message
    assert fmu.set({"platform.force": [1.0, 2.0]}) == ERROR
    assert fmu.set({"platform.force": [1.0, 2.0, float("nan")]}) == ERROR
    assert fmu.set({"time": 1.0}) == ERROR and "time cannot be set" in fmu.message
    assert fmu.get(10**6)[0] == ERROR and "unknown value reference 1000000" in fmu.message
    assert fmu.get("platform.force") == (OK, [1e5, 0.0, 0.0])
    fmu.free()


def test_before_the_start(new):
    """Start values are there at once, what follows from them is not."""
    instance = new()
    assert instance.set({"lower.mass": 2.0}) == OK and instance.get("lower.mass") == (OK, [2.0])
    assert instance.get("elbow.angle")[0] == ERROR and "before the initialization" in instance.message
    assert instance.enter() == OK and instance.get("elbow.angle")[0] == OK


def test_other_types(arm):
    one = (ctypes.c_uint * 1)(0)
    for kind in (
        "Float32",
        "Int8",
        "UInt8",
        "Int16",
        "UInt16",
        "Int32",
        "UInt32",
        "Int64",
        "UInt64",
        "Boolean",
        "String",
    ):
        for verb in ("Get", "Set"):
            assert arm.call(f"fmi3{verb}{kind}", one, c_size_t(1), None, c_size_t(0)) == ERROR
            assert f"value reference 0 is no {kind}" in arm.message
    assert arm.call("fmi3GetClock", one, c_size_t(1), None) == ERROR and "no Clock" in arm.message


def test_what_the_flags_deny_is_refused(arm):
    root = etree.parse(arm.library.folder / "modelDescription.xml")
    flags = root.find("CoSimulation").attrib
    true = {name for name, value in flags.items() if value == "true"}
    assert true == {
        "canGetAndSetFMUState",
        "canReturnEarlyAfterIntermediateUpdate",
        "canSerializeFMUState",
        "hasEventMode",
        "mightReturnEarlyFromDoStep",
        "providesIntermediateUpdate",
        "canHandleVariableCommunicationStepSize",
        "providesAdjointDerivatives",
        "providesDirectionalDerivatives",
    }
    assert flags["maxOutputDerivativeOrder"] == "2"

    assert arm.call("fmi3GetNumberOfVariableDependencies", 0, None) == ERROR


# steps


def test_a_discarded_step_leaves_the_fmu_as_it_was(new, arm):
    run(arm, 5)
    before = arm.serialise(arm.save())
    assert arm.set({"shoulder.torque": 1e308}) == OK
    assert arm.step(0.05, 0.01) == DISCARD
    assert arm.told == (False, False, False, 0.05)
    assert arm.log[-1][:2] == (DISCARD, "logStatusDiscard")

    assert arm.set({"shoulder.torque": 3 * np.sin(5 * 0.04)}) == OK
    assert arm.serialise(arm.save()) == before
    other = new().start()
    run(other, 5)
    assert run(arm, 10, first=5) == run(other, 10, first=5)


def test_refused_steps(arm):
    for t, H in ((0.0, 0.0), (0.0, -1.0), (0.5, 0.1), (0.0, float("nan"))):
        assert arm.step(t, H) == ERROR
    assert arm.call("fmi3DoStep", c_double(0), c_double(0.1), c_bool(True), None, None, None, None) == ERROR
    assert "NULL" in arm.message
    assert arm.step(0.0, 0.1) == OK


def test_experiment(new):
    for wrong in ({"tolerance": -1.0}, {"stop": -1.0}, {"start": float("nan")}):
        assert new().enter(**wrong) == ERROR
    instance = new()
    assert instance.enter(tolerance=1e-4) == OK
    assert "1e-4" not in instance.message and "takes fixed steps" in instance.message
    instance = new().start(stop=0.1)
    assert instance.step(0.0, 0.1) == OK and instance.step(0.1, 0.1) == ERROR


def test_snapshots(arm):
    run(arm, 20)
    snapshot = arm.save()
    first = run(arm, 50, first=20)
    assert arm.restore(snapshot) == OK
    assert run(arm, 50, first=20) == first

    status, again = arm.deserialise(arm.serialise(snapshot))
    assert status == arm.restore(again) == OK
    assert run(arm, 50, first=20) == first
    assert arm.forget(again) == arm.forget(snapshot) == OK
    assert arm.deserialise(b"nothing")[0] == ERROR

    assert arm.call("fmi3Reset") == OK
    fresh = arm.start().outputs()
    assert fresh != first[0]


# points within a step


class Watched(Instance):
    """One whose master is called at points within a step; `at`: what it does there, and the time that it would return at."""

    def __init__(self, library, at=lambda self, time: None, early=True):
        self.points = []
        self.at = at
        self.callback = UPDATE(self._update)
        extra = c_bool(False), c_bool(early), (ctypes.c_uint * 1)(0), c_size_t(1)
        super().__init__(library, extra=extra, update=self.callback)

    def _update(self, _, time, wants, allowed, finished, may, requested, until):
        assert not wants and allowed and finished
        self.points.append((time, may))
        wanted = self.at(self, time)
        if wanted is not None:
            requested[0], until[0] = True, wanted


@pytest.fixture
def watched(arms):
    made = []

    def make(*arguments, **more):
        made.append(Watched(arms[1], *arguments, **more))
        assert made[-1].component, made[-1].log
        return made[-1]

    yield make
    for instance in made:
        instance.free()


def test_points_within_a_step(watched, new):
    """Outputs at tenths of it are those of a run with tenths as steps; the end is that of one without."""
    seen = []
    instance = watched(lambda self, time: seen.append(self.outputs())).start()
    other = new().start()
    expected = []
    for i in range(5):
        assert instance.step(0.1 * i, 0.1) == OK
        assert instance.told == (False, False, False, pytest.approx(0.1 * (i + 1)))
        for k in range(10):
            assert other.step(0.1 * i + 0.01 * k, 0.01) == OK
            expected.append(other.outputs())
    np.testing.assert_allclose(seen, expected, rtol=1e-6, atol=1e-7)
    times = [time for time, _ in instance.points]
    np.testing.assert_allclose(times, 0.01 * np.arange(1, 51), rtol=1e-14)
    assert [may for _, may in instance.points] == ([True] * 9 + [False]) * 5

    plain = new().start()
    for i in range(5):
        assert plain.step(0.1 * i, 0.1) == OK
    np.testing.assert_allclose(instance.outputs(), plain.outputs(), rtol=1e-6, atol=1e-7)


def test_early_return(watched):
    """At once, later within the step, and not where it is not allowed; the run goes on from there."""
    instance = watched(lambda self, time: time if time > 0.045 else None).start()
    assert instance.step(0.0, 0.1) == OK and instance.told[2:] == (True, pytest.approx(0.05))
    reached = instance.told[3]
    instance.at = lambda self, time: 0.0765
    assert instance.step(reached, 0.1) == OK and instance.told[2:] == (True, 0.0765)
    instance.at = lambda self, time: None
    assert instance.step(0.0765, 0.0235) == OK and instance.told[2:] == (False, pytest.approx(0.1))
    instance.at = lambda self, time: 5.0
    assert instance.step(0.1, 0.1) == OK and instance.told[2:] == (False, pytest.approx(0.2))

    plain = watched(early=False, at=lambda self, time: time).start()
    assert plain.step(0.0, 0.2) == OK and plain.told[2:] == (False, 0.2)
    assert not any(may for _, may in plain.points)
    np.testing.assert_allclose(instance.outputs(), plain.outputs(), rtol=1e-6, atol=1e-7)


def test_what_may_be_asked_within_a_step(watched, arms):
    """Values and derivatives; nothing that would change it."""
    told = []

    def ask(self, time):
        outputs = arms[1].names("output")
        torque = self.derivatives("Directional", outputs, ["shoulder.torque"], [1.0], len(self.outputs()))
        refused = [
            self.set({"shoulder.torque": 1.0}),
            self.step(time, 0.01),
            self.call("fmi3Reset"),
            self.call("fmi3Terminate"),
            self.call("fmi3GetFMUState", ctypes.byref(c_void_p())),
        ]
        told.append(
            (self.get("time")[1] == [time], torque[0], self.output_derivatives(outputs, 1)[0], refused)
        )

    instance = watched(ask).start()
    assert instance.step(0.0, 0.1) == OK
    assert told == [(True, OK, OK, [ERROR] * 5)] * 10
    assert "intermediate update" in instance.message


def test_a_discarded_step_with_points(watched):
    """What was seen of it does not count: the FMU is as before the call."""
    instance = watched().start()
    run(instance, 5)
    before = instance.serialise(instance.save())
    assert instance.set({"shoulder.torque": 1e30}) == OK
    assert instance.step(0.05, 0.01) == DISCARD
    assert instance.told == (False, False, False, 0.05)
    assert instance.set({"shoulder.torque": 3 * np.sin(5 * 0.04)}) == OK
    assert instance.serialise(instance.save()) == before
