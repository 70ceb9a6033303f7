"""A frame that comes beyond the end of its curve or surface in a run: told once, in process and in the logs of FMUs of both kinds."""

import re
import tomllib
from zipfile import ZipFile

import numpy as np
import pytest
from fmu_host import WARNING, Library, warnings_of_runs
from fmu_host import Instance as Hosted
from test_model_exchange import Solver
from test_turns import SOLVERS

from mbdfmi import Scene
from mbdfmi.compiler.model import compile_scene
from mbdfmi.kernels.status import BEYOND_END, MESSAGES
from mbdfmi.run.instance import Instance

# an arc of radius 2 m, 1 m long on either side
ANGLES = np.linspace(-0.5, 0.5, 9)
ARC = [[2 * np.sin(a), 2 - 2 * np.cos(a), 0.0] for a in ANGLES]
LENGTH = np.linalg.norm(np.diff(ARC, axis=0), axis=1).sum()
STRAIGHT = [[-1.0, 0, 0], [0.0, 0, 0], [1.0, 0, 0]]
ACROSS = [-1.0, -0.5, 0.5, 1.0]


def grid(bend):
    """A surface over x and y from -1 to 1 m, bent along x."""
    x = np.linspace(-1, 1, 9)
    points = [[[a, b, bend * a * a] for b in ACROSS] for a in x]
    return {"table": {"s1": list(x), "s2": ACROSS, "points": points}}


SHAPES = {
    "spline": ("curve", {"spline": {"points": ARC}}),
    "table": ("curve", {"table": {"s": list(2 * ANGLES), "points": ARC}}),
    "prism": ("surface", {"prism": {"profile": {"spline": {"points": ARC}}}}),
    "grid": ("surface", grid(0.3)),
}
GOES_ON = {
    "straight": ("curve", {"spline": {"points": STRAIGHT}}),
    "flat": ("surface", grid(0.0)),
    "circle": ("curve", {"circle": {"radius": 2.0}}),
    "closed": ("curve", {"spline": {"points": ARC, "closed": True}}),
}


def sliding(shape, pull=6.0, **solver):
    """A body held to a frame, from rest near the middle on, pulled along x (m/s2): after half a second it is beyond the end."""
    kind, spec = shape
    hold = {f"frame_on_{kind}": {}, "between": ["ground.way", "b"], "output": ["s"]}
    start = {"position": [-1.0, 1.0, 0.0] if "circle" in spec else [0.1, 0.0, 0.0]}
    return Scene.model_validate(
        {
            "name": "ends",
            "gravity": [pull, 0, 0],
            "solver": solver,
            "ground": {"marker": {"way": {kind: spec}}},
            "body": {"b": {"mass": 1.0, "inertia": [0.02, 0.02, 0.02]}},
            "joint": {"move": {"free": {}, "between": ["ground", "b"], "start": start}, "hold": hold},
        }
    )


def beyond(texts):
    """What is said of ends."""
    return [text for text in texts if "beyond the end" in text]


@pytest.mark.parametrize("shape", SHAPES)
@pytest.mark.parametrize("formulation", ["recursive", "embedding", "augmented"])
def test_a_frame_beyond_an_end_is_told_once(shape, formulation):
    """Where it is and where the points end; not before it is there, nor again."""
    instance = Instance(compile_scene(sliding(SHAPES[shape], formulation=formulation)))
    instance.step(0.2)
    assert not beyond(instance.notices)

    for _ in range(8):
        instance.step(0.1)

    (text,) = beyond(instance.notices)
    assert text.startswith("hold has come beyond the end of its")
    at, end = map(float, re.search(r"s = (\S+), that is at (\S+)\):", text).groups())
    last = 1.0 if shape in ("table", "grid") else LENGTH
    assert abs(end - last) < 1e-5 and end <= at < end + 1.0


@pytest.mark.parametrize("integrator", SOLVERS)
def test_every_stepper_tells_it(integrator):
    """Those that look ahead too, in the communication step that it happens in."""
    options = SOLVERS[integrator] and {"step": 0.01}
    instance = Instance(compile_scene(sliding(SHAPES["spline"], integrator=integrator, **options)))
    passed = None

    while instance.time < 0.9:
        instance.step(0.1)
        s = instance.outputs()[[v.name for v in instance.model.of_causality("output")].index("hold.s")]
        passed = passed or (instance.time if s > LENGTH else None)

    (text,) = beyond(instance.notices)
    assert text.endswith(f"(time {passed:.9g} s)")


def test_a_way_out_and_back_within_a_step_is_told():
    """One communication step, which begins and ends on the arc: it swings over both ends and back."""
    scene = sliding(SHAPES["spline"], pull=0.0)
    scene.gravity = (0.0, -9.81, 0.0)
    scene.joint["move"].start.velocity = (4.0, 0.0, 0.0)
    instance = Instance(compile_scene(scene))
    instance.step(3.0)
    assert len(beyond(instance.notices)) == 1


@pytest.mark.parametrize("shape", GOES_ON)
def test_where_nothing_stops_turning_nothing_is_told(shape):
    """Straight at its end, or without one."""
    run = sliding(GOES_ON[shape]).simulate(1.0, 0.1)
    assert not beyond(run.notices)


def test_points_on_curves_turn_nothing():
    """A body whose axes are not held may leave the points of its curve."""
    data = tomllib.loads(sliding(SHAPES["spline"]).to_toml())
    data["joint"]["hold"] = {"point_on_curve": {}, "between": ["ground.way", "b"]}
    assert not beyond(Scene.model_validate(data).simulate(1.0, 0.1).notices)


@pytest.mark.parametrize("shape", SHAPES)
def test_in_the_log_of_an_fmu(shape, tmp_path):
    """As in process, once; a snapshot remembers whether it was said, a reset begins anew."""
    scene = sliding(SHAPES[shape])
    fmu = Hosted(Library(scene.export(tmp_path / "ends.fmu"), tmp_path / "ends")).start()
    wanted = beyond(scene.simulate(1.0, 0.1).notices)
    texts, restored, anew = warnings_of_runs(fmu, 0.1, 10, beyond)
    assert len(texts) == 1 and wanted[0].split(" (time")[0] in texts[0].replace("##", "#")
    assert restored == texts
    assert anew == texts
    fmu.free()


def test_in_the_log_in_model_exchange(tmp_path):
    """When a solver outside says that its step is complete."""
    scene = sliding(SHAPES["spline"])
    solver = Solver(Library(scene.export(tmp_path / "ends.fmu"), tmp_path / "ends"))
    solver.run(0.2, 0.01)
    assert not beyond(text for *_, text in solver.fmu.log)
    solver.run(1.0, 0.01)
    texts = beyond(text for status, _, text in solver.fmu.log if status == WARNING)
    assert len(texts) == 1 and "hold has come beyond" in texts[0]
    solver.fmu.free()


def test_models_without_end_frames_do_not_carry_the_text(tmp_path):
    """Theirs is as it was, to the byte."""
    text = MESSAGES[BEYOND_END].encode()

    body = {"b": {"mass": 1, "inertia": [1, 1, 1]}}
    ball = Scene(name="ball", body=body, joint={"j": {"free": {}, "between": ["ground", "b"]}})

    for scene, carries in ((sliding(SHAPES["spline"]), True), (ball, False)):
        with ZipFile(scene.export(tmp_path / "it.fmu")) as fmu:
            assert (text in fmu.read("resources/model.bin")) == carries
