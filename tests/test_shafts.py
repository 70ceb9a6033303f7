"""Constant-velocity joints and angles between axes: closed forms, energy, formulations."""

import numpy as np
import pytest
from fmu_host import OK, Library
from fmu_host import Instance as FmuInstance
from scenes import assert_near
from scipy.spatial.transform import Rotation
from test_powers import named_outputs

from mbdfmi import Scene, SceneError
from mbdfmi.compiler.model import compile_scene
from mbdfmi.export import export_fmu
from mbdfmi.run.instance import Instance
from mbdfmi.run.simulate import simulate

formulations = pytest.mark.parametrize("formulation", ["recursive", "embedding", "augmented"])
EXACT = {"integrator": "rk853", "tolerance": 1e-12}
SHAFT = {"mass": 1.0, "inertia": [0.2, 0.2, 0.1]}
SPEED = ["angle", "speed", "acceleration"]


def started(scene):
    return Instance(compile_scene(Scene.model_validate(scene)))


def bent(joint, bend, start=None, formulation="recursive"):
    """Two shafts on the ground whose axes meet at an angle (deg), joined there; the first is driven, ever faster."""
    return {
        "name": "shafts", "gravity": [0, 0, 0], "solver": EXACT | {"formulation": formulation},
        "ground": {"marker": {"out": {"zyx_deg": [0, bend, 0]}}},
        "body": {"a": SHAFT, "b": SHAFT},
        "joint": {
            "in": {"revolute": {}, "between": ["ground", "a"], "driver": {"polynomial": {"coefficients": [0.0, 2.0, 1.5]}},
                   "output": [*SPEED, "driver_effort"]},
            "out": {"revolute": {}, "between": ["ground.out", "b"], "output": SPEED, "start": start or {}},
            "bend": joint | {"between": ["a", "b"]},
        },
    }  # fmt: skip


@formulations
@pytest.mark.parametrize("bend", [0, 30, 75])
def test_both_shafts_turn_equally_fast(formulation, bend):
    """At any bend, also where the turn is uneven; what drives the one bears the inertia of both."""
    run = simulate(
        compile_scene(Scene.model_validate(bent({"constant_velocity": {}}, bend, None, formulation))),
        2.0,
        0.25,
    )

    for what in SPEED:
        assert_near(run[f"out.{what}"], run[f"in.{what}"], 1e-10)

    assert_near(run["in.driver_effort"], 2 * 0.1 * 3.0, 1e-10)


def test_a_universal_joint_would_ripple():
    """Between cos 30 deg and its inverse."""
    run = simulate(compile_scene(Scene.model_validate(bent({"universal": {}}, 30))), 2.0, 0.02)
    ratio = run["out.speed"] / run["in.speed"]
    assert_near([ratio.min(), ratio.max()], [np.cos(np.pi / 6), 1 / np.cos(np.pi / 6)], 1e-3)


@pytest.mark.parametrize("angle", [-170, -100, 60, 100, 170])
def test_a_start_far_off_is_led_to_no_twist(angle):
    """The equation is 0 half a turn away as well: not there."""
    scene = bent({"constant_velocity": {}}, 30)
    scene["joint"]["in"]["driver"] = {"hold": True}
    scene["joint"]["in"]["start"] = {"angle_deg": angle}
    assert_near(named_outputs(started(scene))["out.angle"], np.radians(angle), 1e-9)


def test_an_axis_of_its_own():
    """Shafts along x of all markers."""
    scene = bent({"constant_velocity": {"axis": "x"}}, 0)
    scene["ground"]["marker"]["out"] = {"zyx_deg": [25, 0, 0]}

    for name in ("in", "out"):
        scene["joint"][name]["revolute"] = {"axis": "x"}

    run = simulate(compile_scene(Scene.model_validate(scene)), 1.0, 0.5)
    assert_near(run["out.speed"], run["in.speed"], 1e-10)


@formulations
def test_a_shaft_hung_on_a_joint(formulation):
    """It swings and spins with what turns it; nothing but the joint holds it: energy stays, the moment has no part across."""
    scene = {
        "name": "hung", "solver": EXACT | {"formulation": formulation}, "output": ["total_energy", "constraint_gap"],
        "body": {"a": SHAFT, "b": SHAFT | {"com": [0, 0, -0.4], "output": ["omega", "euler_parameters"]}},
        "joint": {
            "in": {"revolute": {}, "between": ["ground", "a"], "start": {"speed": 5.0}, "output": ["speed"]},
            "f": {"free": {}, "between": ["ground", "b"], "start": {"zyx_deg": [0, 40, 0]}},
            "cv": {"constant_velocity": {}, "between": ["a", "b"], "output": ["reaction_moment"]},
        },
    }  # fmt: skip
    run = simulate(compile_scene(Scene.model_validate(scene)), 1.0, 0.25)
    assert_near(run["total_energy"], run["total_energy"][0], 1e-9)
    assert_near(run["constraint_gap"], 0.0, 1e-9)

    # equal spins: along the bisector of the shafts there is no relative angular velocity, and along it alone a moment
    axes = Rotation.from_quat(run["b.euler_parameters"]).as_matrix()
    bisector = axes[:, :, 2] + [0, 0, 1]
    bisector /= np.linalg.norm(bisector, axis=1)[:, None]
    relative = run["b.omega"] - run["in.speed"][:, None] * [0, 0, 1]
    assert_near(np.sum(relative * bisector, axis=1), 0.0, 1e-9)


def test_formulations_agree_on_a_drive_shaft_that_floats():
    """Two joints with a shaft between that they alone hold, the last shaft turned and loaded."""
    found = []

    for formulation in ("recursive", "embedding", "augmented"):
        shaft = SHAFT | {"marker": {"end": {"position": [0, 0, 0.5]}}}
        scene = {
            "name": "drive shaft", "solver": EXACT | {"formulation": formulation}, "output": ["total_energy"],
            "ground": {"marker": {"out": {"position": [0.1, 0.05, 0.45], "zyx_deg": [0, 5, 15]}}},
            "body": {"a": shaft, "m": shaft, "b": shaft},
            "joint": {
                "in": {"revolute": {}, "between": ["ground", "a"], "start": {"speed": 4.0}, "output": SPEED},
                "f": {"free": {}, "between": ["ground", "m"], "start": {"zyx_deg": [20, 10, 0]}},
                "out": {"cylindrical": {}, "between": ["ground.out", "b"], "output": ["position", "angular_speed"]},
                "one": {"constant_velocity": {}, "between": ["a", "m"], "output": ["reaction_force", "reaction_moment"]},
                "two": {"constant_velocity": {}, "between": ["m.end", "b"]},
            },
        }  # fmt: skip
        instance = started(scene)
        energy = named_outputs(instance)["total_energy"]
        instance.step(0.3)
        y = named_outputs(instance)
        assert_near(y["total_energy"], energy, 1e-9)
        assert_near(y["out.angular_speed"], y["in.speed"], 1e-9)
        found.append(instance.outputs().copy())

    for y in found[1:]:
        assert_near(y, found[0], 1e-8)


@formulations
def test_a_top_at_a_constant_angle(formulation):
    """It turns steadily; the constraint bears (C (s + p cos b) - A p cos b) p sin b about the line of nodes."""
    A, C, b, p, s = 0.2, 0.1, np.radians(40), 1.5, 8.0
    scene = {
        "name": "top", "gravity": [0, 0, 0], "solver": EXACT | {"formulation": formulation},
        "body": {"t": SHAFT | {"output": ["euler_parameters", "omega"]}},
        "joint": {
            "s": {"spherical": {}, "between": ["ground", "t"],
                  "start": {"zyx_deg": [0, 40, 0], "omega": [s * np.sin(b), 0, p + s * np.cos(b)]}},
            "lean": {"angle": {"angle_deg": 40}, "between": ["ground", "t"], "output": ["reaction_moment"]},
        },
    }  # fmt: skip
    run = simulate(compile_scene(Scene.model_validate(scene)), 1.0, 0.25)
    axes = Rotation.from_quat(run["t.euler_parameters"]).as_matrix()[:, :, 2]
    assert_near(axes[:, 2], np.cos(b), 1e-11)
    assert_near(axes[:, 0], np.sin(b) * np.cos(p * run["time"]), 1e-9)
    moment = (C * (s + p * np.cos(b)) - A * p * np.cos(b)) * p * np.sin(b)
    assert_near(np.linalg.norm(run["lean.reaction_moment"], axis=1), moment, 1e-9)


@pytest.mark.parametrize("axes, angle", [(["x", [1, 2, 0]], 50), (["y", "x"], 120)])
def test_axes_at_an_angle(axes, angle):
    """A start that does not fit is led to it."""
    scene = {
        "name": "angle", "gravity": [0, 0, 0], "body": {"t": SHAFT | {"output": ["euler_parameters"]}},
        "joint": {
            "s": {"spherical": {}, "between": ["ground", "t"]},
            "lean": {"angle": {"angle_deg": angle, "axes": axes}, "between": ["ground", "t"]},
        },
    }  # fmt: skip
    first, second = (
        np.eye(3)["xyz".index(a)] if isinstance(a, str) else np.array(a) / np.linalg.norm(a) for a in axes
    )
    turned = Rotation.from_quat(named_outputs(started(scene))["t.euler_parameters"]).apply(second)
    assert_near(first @ turned, np.cos(np.radians(angle)), 1e-9)


@pytest.mark.parametrize("angle", [0, 180, -5])
def test_parallel_axes_are_refused(angle):
    scene = bent({"angle": {"angle_deg": angle}}, 30)

    with pytest.raises(SceneError, match="angle.angle_deg: must be between 0 and 180 deg"):
        Scene.model_validate(scene)


def test_shafts_turn_equally_fast_in_an_fmu(tmp_path):
    """To the bit as in process, with a differential beside them."""
    scene = bent({"constant_velocity": {}}, 30)
    scene["body"] |= {"left": SHAFT, "right": SHAFT}
    scene["joint"] |= {
        name: {"revolute": {}, "between": ["ground", name], "output": SPEED} for name in ("left", "right")
    }
    scene["coupling"] = {
        "d": {
            "linear": {"coefficients": [1, 1, -2]},
            "between": ["left", "right", "out"],
            "output": ["efforts"],
        }
    }
    model = compile_scene(Scene.model_validate(scene))
    here = Instance(model)
    fmu = FmuInstance(Library(export_fmu(model, tmp_path / "shafts.fmu"), tmp_path / "unpacked"))
    fmu.start()

    for k in range(5):
        assert fmu.step(0.25 * k, 0.25) == OK
        here.step(0.25)
        assert np.array_equal(fmu.outputs(), here.outputs())

    y = named_outputs(here)
    assert_near(y["out.speed"], y["in.speed"], 1e-10)
    assert_near(y["left.speed"] + y["right.speed"], 2 * y["out.speed"], 1e-10)
    fmu.free()
