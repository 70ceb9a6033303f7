"""FMUs that start at the static equilibrium of their scene: a Boolean parameter asks for it."""

import struct
import zlib
from ctypes import c_bool, c_int, c_size_t, c_uint
from pathlib import Path

import fmpy
import numpy as np
import pytest
from fmu_host import CO_SIMULATION, ERROR, MODEL_EXCHANGE, OK, WARNING, Instance, Library
from fmu_host3 import Instance as Instance3
from fmu_host3 import Library as Library3

import mbdfmi
from mbdfmi import Scene
from mbdfmi.analysis.equilibrium import NoEquilibrium
from mbdfmi.cli import main
from mbdfmi.export.resource import resource

ROOT = Path(__file__).parents[1] / "models"
NAME = "solver.start_at_equilibrium"
G = 9.81
INERTIA = 0.1 + 2.0 * 0.5**2
"""kg m2, of the bar about its pin."""


def pendulum(**solver):
    """A bar of 2 kg that hangs on a pin, its middle half a metre below, and starts at 1 rad."""
    return Scene(
        name="bar",
        gravity=[0, 0, -G],
        body={"bar": {"mass": 2.0, "com": [0, 0, -0.5], "inertia": [0, 0.1, 0.1]}},
        joint={
            "pivot": {
                "revolute": {"axis": "y"},
                "between": ["ground", "bar"],
                "start": {"angle": 1.0},
                "input": "torque",
                "output": ["angle", "speed"],
            }
        },
        solver=solver,
    )


@pytest.fixture(scope="module")
def library(tmp_path_factory):
    folder = tmp_path_factory.mktemp("rest")
    return Library(pendulum().export(folder / "bar.fmu", at_rest=True), folder / "bar")


def boolean(it, value=None, reference=None):
    """(status, value) of the parameter, set first where a value is given."""
    keys = (c_uint * 1)(it.library.reference(NAME) if reference is None else reference)

    if value is not None:
        return it.call("fmi2SetBoolean", keys, c_size_t(1), (c_int * 1)(value)), value

    found = (c_int * 1)(-1)
    return it.call("fmi2GetBoolean", keys, c_size_t(1), found), found[0]


def warnings(it):
    return [text for status, _, text in it.log if status == WARNING]


# a net of four-bar cells in a row, long enough for bodies to be taken apart


def net(cells):
    bar = {"mass": 1.0, "com": [0, 0, -0.5], "inertia": [0.1, 0.1, 0.1]}
    beam = {"mass": 1.0, "com": [0.5, 0, 0], "inertia": [0.1, 0.1, 0.1]}
    body, joint = {}, {}

    for i in range(cells):
        for side in "ab":
            body[f"{side}{i}"] = bar | {"marker": {"end": {"position": [0, 0, -1]}}}
            joint[f"{side}{i}"] = {
                "revolute": {"axis": "y"},
                "between": [f"{side}{i - 1}.end" if i else f"ground.{side}", f"{side}{i}"],
                "start": {"angle": 0.0 if i else 0.3},
                "output": ["angle"],
            }

        body[f"c{i}"] = beam | {"marker": {"a": {"position": [0, 0, 0]}, "b": {"position": [1, 0, 0]}}}

        for side in "ab":
            ends = [f"{side}{i}.end", f"c{i}.{side}"]
            joint[f"{side}c{i}"] = {"revolute": {"axis": "y"}, "between": ends}

    ground = {"marker": {"a": {"position": [0, 0, 0]}, "b": {"position": [1, 0, 0]}}}
    return Scene(name="net", gravity=[0, 0, -G], ground=ground, body=body, joint=joint)


SCENES = {
    name.split("/")[-1]: ROOT / f"{name}.toml"
    for name in (
        "double_pendulum",
        "four_bar",
        "marble_run",
        "floating_crane",
        "floating_wind_turbine/floating_wind_turbine",
    )
}


def outputs_of(run):
    """Names of columns, and those of whole arrays."""
    return [*run, *(name.partition("[")[0] for name in run)]


@pytest.mark.parametrize(
    "name, fmi", [*((name, 2) for name in (*SCENES, "net")), ("four_bar", 3), ("floating_wind_turbine", 3)]
)
def test_an_fmu_asked_to_rest_is_the_scene_that_starts_at_rest(name, fmi, tmp_path):
    """Its run is that in process with `start = "equilibrium"`, within 1e-10, and what does not turn freely stays;
    not asked, it starts as the scene says.
    """
    scene = net(20) if name == "net" else mbdfmi.load(SCENES[name])
    path = scene.export(tmp_path / "it.fmu", fmi=fmi, at_rest=True)
    given, step = scene.simulate(0.1, 0.05), {"stop_time": 1.0, "output_interval": 0.05}
    scene.solver.start = "equilibrium"
    right = scene.simulate(1.0, 0.05)
    moving = fmpy.simulate_fmu(str(path), fmi_type="CoSimulation", **step | {"stop_time": 0.1})
    found = fmpy.simulate_fmu(str(path), start_values={NAME: True}, fmi_type="CoSimulation", **step)
    compared = 0

    for column in set(found.dtype.names[1:]) & set(outputs_of(right)):
        compared += 1

        for run, of, within in ((found, right, 1e-10), (moving, given, 1e-9)):
            values, wanted = run[column].reshape(len(run), -1), of[column].reshape(len(run), -1)
            assert np.abs(values - wanted).max() <= within * max(np.abs(wanted).max(), 1.0), column

    assert compared > 2


@pytest.mark.parametrize("fmi", [2, 3])
def test_a_solver_outside_begins_at_rest_too(fmi, tmp_path):
    """In model exchange a pendulum hangs still."""
    path = pendulum().export(tmp_path / "bar.fmu", fmi=fmi, at_rest=True)
    run = {"fmi_type": "ModelExchange", "stop_time": 1.0, "start_values": {NAME: True}}
    found = fmpy.simulate_fmu(str(path), **run)
    assert np.abs(found["pivot.angle"]).max() < 1e-12
    assert fmpy.simulate_fmu(str(path), **run | {"start_values": {}})["pivot.angle"][0] == 1.0


def test_a_scene_that_starts_at_rest_has_it_true(tmp_path):
    """`[solver] start = "equilibrium"`: the parameter is true at first, and false leads to the start as given."""
    path = pendulum(start="equilibrium").export(tmp_path / "bar.fmu")
    variables = {v.name: v for v in fmpy.read_model_description(str(path)).modelVariables}
    assert variables[NAME].start == "true"
    assert float(variables["pivot.angle_start"].start) == 1.0
    rests = fmpy.simulate_fmu(str(path), stop_time=1.0)
    assert np.abs(rests["pivot.angle"]).max() < 1e-12
    given = fmpy.simulate_fmu(str(path), stop_time=1.0, start_values={NAME: False})
    swings = pendulum().simulate(1.0)
    assert given["pivot.angle"][-1] == pytest.approx(swings["pivot.angle"][-1], abs=1e-7)


def test_what_does_not_ask_has_none(tmp_path):
    path = pendulum().export(tmp_path / "bar.fmu")
    library = Library(path, tmp_path / "bar")
    assert NAME not in library.variables
    it = Instance(library)
    status, _ = boolean(it, True, 0)
    assert status == ERROR
    assert "offers no start at rest" in it.message
    it.free()


def test_values_that_the_rest_was_not_found_for_are_told(library):
    """A torque of 0.3 N m at the rest of none: 0.3/I rad/s2, told as a warning; a start value that does not act too."""
    it = Instance(library)
    assert boolean(it, True)[0] == OK
    it.start()
    assert warnings(it) == []
    it.free()

    it = Instance(library)
    boolean(it, True)
    assert it.set({"pivot.torque": 0.3}) == OK
    it.start()
    (told,) = warnings(it)
    assert "no rest with the present parameters and inputs" in told
    assert "'bar'" in told
    assert f"{0.3 / INERTIA:.3g} (m/s2 or rad/s2)" in told
    it.free()

    it = Instance(library)
    boolean(it, True)
    assert it.set({"pivot.angle_start": 0.5}) == OK
    it.start()
    (told,) = warnings(it)
    assert "'pivot.angle_start'" in told
    assert it.value("pivot.angle") == 0.0
    it.free()


# rests that changed parameters make unstable

BAR = {
    "mass": 2.0,
    "com": [0, 0, 0.5],
    "inertia": [0.1, 0.1, 0.1],
    "marker": {"top": {"position": [0, 0, 1]}},
}
PINS = {"revolute": {"axis": "y"}, "universal": {"axes": ["x", "y"]}, "spherical": {}}


def upright(kind):
    """A bar that springs of 12 N m/rad hold upright on a pin, whatever way it falls; stiff about itself."""
    spring = {"bushing": {"stiffness": [0, 0, 0, 12.0, 12.0, 1e4]}, "between": ["ground", "bar"]}
    joint = {kind: PINS[kind], "between": ["ground", "bar"], "output": ["reaction_force"]}
    return Scene(
        name="upright", gravity=[0, 0, -G], body={"bar": BAR}, joint={"pin": joint}, force={"hold": spring}
    )


def table():
    """A beam of 1 kg on two such bars, one of them on a spring of 40 N m/rad."""
    ground = {"marker": {"right": {"position": [1, 0, 0]}}}
    beam = {"mass": 1.0, "com": [0.5, 0, 0], "inertia": [0.1] * 3, "marker": {"end": {"position": [1, 0, 0]}}}
    pin = {"revolute": {"axis": "y"}}
    joint = {
        "left": pin | {"between": ["ground", "one"], "spring": {"stiffness": 40.0}},
        "right": pin | {"between": ["ground.right", "two"]},
        "over": pin | {"between": ["one.top", "beam"]},
        "closes": pin | {"between": ["two.top", "beam.end"], "output": ["angle"]},
    }
    return Scene(
        name="table",
        gravity=[0, 0, -G],
        ground=ground,
        body={"one": BAR, "two": BAR, "beam": beam},
        joint=joint,
    )


def growth(name, mass):
    """1/s, of the bar or the table whose bar or beam has this mass, by its closed form; 0 where it stays."""
    if name == "table":
        square = (2 * 2.0 * G * 0.5 + mass * G - 40.0) / (2 * (0.1 + 2.0 * 0.5**2) + mass)
    else:
        square = (mass * G * 0.5 - 12.0) / (0.1 + mass * 0.5**2)

    return np.sqrt(max(square, 0.0))


@pytest.mark.parametrize("name", [*PINS, "table"])
@pytest.mark.parametrize("mass", [1.9, 2.1, 2.5, 6.0])
@pytest.mark.parametrize("exchange", [False, True])
def test_a_rest_that_became_unstable_is_told(name, mass, exchange, tmp_path):
    """With the time in which what is off grows e-fold; nothing is told where it is stable still."""
    scene = table() if name == "table" else upright(name)
    library = Library(scene.export(tmp_path / "it.fmu", at_rest=True), tmp_path / "it")
    it = Instance(library, kind=MODEL_EXCHANGE if exchange else CO_SIMULATION)
    boolean(it, True)
    assert it.set({f"{'beam' if name == 'table' else 'bar'}.mass": mass}) == OK
    it.start()
    told = warnings(it)
    rate = growth(name, mass)
    assert len(told) == (rate > 0.0)

    if told:
        assert "it is not stable with the present parameters and inputs" in told[0]
        assert abs(float(told[0].split("e-fold in ")[1].split()[0]) - 1 / rate) < 5e-3 / rate

    it.free()


def test_motions_without_stiffness_are_not_called_unstable(tmp_path):
    """A ball that floats: a mass that changed changes nothing."""
    scene = Scene(
        name="ball",
        gravity=[0, 0, 0],
        body={"ball": {"mass": 1.0, "inertia": [0.1, 0.2, 0.3]}},
        joint={"free": {"free": {}, "between": ["ground", "ball"]}},
    )
    it = Instance(Library(scene.export(tmp_path / "it.fmu", at_rest=True), tmp_path / "it"))
    boolean(it, True)
    assert it.set({"ball.mass": 3.0}) == OK
    it.start()
    assert not warnings(it)
    it.free()


def test_when_it_may_be_set(library):
    """Before the start, also within the initialisation; a reset and a snapshot bring it back."""
    it = Instance(library)
    assert boolean(it) == (ERROR, -1)  # FMI 2.0 reads nothing before the initialisation
    it.setup()
    it.enter()
    assert boolean(it) == (OK, 0)
    assert it.value("pivot.angle") == 1.0
    assert boolean(it, True)[0] == OK
    assert abs(it.value("pivot.angle")) < 1e-12
    kept = it.save()
    assert boolean(it, False)[0] == OK
    assert it.value("pivot.angle") == 1.0
    assert it.restore(kept) == OK
    assert boolean(it) == (OK, 1)
    data = it.serialise(kept)
    it.exit()
    assert abs(it.value("pivot.angle")) < 1e-12
    assert boolean(it, False)[0] == ERROR
    assert "fixed after the initialization" in it.message
    assert boolean(it) == (OK, 1)
    assert it.reset() == OK
    it.setup()
    it.enter()
    assert boolean(it) == (OK, 0)
    status, other = it.deserialise(data)
    assert status == it.restore(other) == OK
    assert boolean(it) == (OK, 1)

    for wrong in (0, 10**6):
        assert boolean(it, True, wrong)[0] == ERROR
        assert f"the only one is {library.reference(NAME)}" in it.message

    it.free()


def test_when_it_may_be_set_in_fmi_3(tmp_path):
    library = Library3(pendulum().export(tmp_path / "bar.fmu", fmi=3, at_rest=True), tmp_path / "bar")
    it = Instance3(library)
    keys, one = (c_uint * 1)(library.variables[NAME].valueReference), c_size_t(1)
    value = (c_bool * 1)(True)
    assert it.call("fmi3SetBoolean", keys, one, value, one) == OK
    value[0] = False
    assert it.call("fmi3GetBoolean", keys, one, value, one) == OK
    assert value[0]
    assert it.call("fmi3SetBoolean", keys, one, value, c_size_t(2)) == ERROR
    assert "2 values for variables of 1" in it.message
    it.start()
    assert it.call("fmi3SetBoolean", keys, one, value, one) == ERROR
    assert "fixed after the initialization" in it.message
    it.free()


def test_a_rotor_spins_on(tmp_path):
    """What turns without stiffness keeps its speed, as in a run in process."""
    path = mbdfmi.load(SCENES["floating_wind_turbine"]).export(tmp_path / "it.fmu", at_rest=True)
    found = fmpy.simulate_fmu(str(path), stop_time=1.0, start_values={NAME: True})
    assert found["shaft.speed"] == pytest.approx(12.1 * np.pi / 30, rel=1e-9)


def test_a_scene_without_rest_is_told(tmp_path, capsys):
    scene = pendulum()
    scene.joint["pivot"] = {"prismatic": {"axis": "z"}, "between": ["ground", "bar"]}

    with pytest.raises(NoEquilibrium, match=r"at_rest \(--at-rest\): .*pivot.position.* moves away"):
        scene.export(tmp_path / "it.fmu", at_rest=True)

    scene.solver.start = "equilibrium"

    with pytest.raises(NoEquilibrium, match=r'\[solver\] start = "equilibrium": .*pivot.position.* moves'):
        scene.export(tmp_path / "it.fmu")

    assert not (tmp_path / "it.fmu").exists()
    path = str(ROOT / "turning_track.toml")
    assert main(["export", path, "-o", str(tmp_path / "track.fmu"), "--at-rest"]) != 0
    assert "moves away" in capsys.readouterr().err


def test_runs_from_rest_can_be_looked_at(tmp_path):
    """The recorder of a scene that starts at rest knows its FMU."""
    scene = pendulum(start="equilibrium")
    recorder = scene.recorder()
    fmpy.simulate_fmu(
        str(scene.export(tmp_path / "bar.fmu")), stop_time=0.1, step_finished=recorder, output_interval=0.05
    )
    assert np.abs(recorder.results()["pivot.angle"]).max() < 1e-12


def test_a_damaged_rest_is_refused(library, tmp_path):
    """Numbers that are none, in a file whose checksum is right."""
    model, _ = pendulum()._for_fmu(at_rest=True)
    data = bytearray(resource(model, {}))
    at = data.rindex(model.rest.x.tobytes() + model.rest.rates.tobytes())
    data[at : at + 8] = struct.pack("<d", float("nan"))
    data[12:16] = struct.pack("<I", zlib.crc32(bytes(data[24:])))
    (tmp_path / "model.bin").write_bytes(bytes(data))
    it = Instance(library, location=tmp_path.as_uri().encode())
    assert not it.component
    assert "its start at rest is damaged" in it.message
