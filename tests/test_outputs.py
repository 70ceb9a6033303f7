"""Accelerations, momenta, measures: Newton and Euler, differences, other formulations; what outputs depend on; and as an FMU."""

import fmpy
import numpy as np
import pytest
from hypothesis import given
from scenes import assert_near, examples, random_instance, trees

from mbdfmi import Scene
from mbdfmi.compiler.model import compile_scene
from mbdfmi.export import export_fmu
from mbdfmi.run.instance import Instance
from mbdfmi.run.simulate import simulate

REACTIONS = ["reaction_force", "reaction_moment"]
SOLVER = {"tolerance": 1e-12}


def named_outputs(instance):
    """Outputs now by name, arrays as one."""
    values = {}

    for v, value in zip(instance.model.of_causality("output"), instance.outputs()):
        values.setdefault(v.name.partition("[")[0], []).append(value)

    return {name: np.array(value) for name, value in values.items()}


# accelerations, momenta, measures


def everything():
    """A scene with every output and force element."""
    inertia = [0.3, 0.4, 0.5]
    seen = [
        "position",
        "velocity",
        "acceleration",
        "omega",
        "alpha",
        "acceleration_body",
        "alpha_body",
        "velocity_body",
    ]
    return Scene.model_validate(
        {
            "name": "everything",
            "solver": SOLVER,
            "output": [
                "kinetic_energy",
                "potential_energy",
                "total_energy",
                "gravity_energy",
                "spring_energy",
                "linear_momentum",
                "angular_momentum",
                "center_of_mass",
                "constraint_gap",
                "constraint_rate",
                "multipliers",
            ],
            "ground": {"marker": {"peg": {"position": [0.5, 1.0, 0.2]}}},
            "body": {
                "a": {
                    "mass": 2.0,
                    "com": [0, 0, -0.3],
                    "inertia": inertia,
                    "marker": {"m": {"position": [0.1, 0, -0.6]}},
                },
                "b": {
                    "mass": 1.0,
                    "com": [0.1, 0, -0.2],
                    "inertia": inertia,
                    "output": seen + ["omega_body"],
                    "marker": {"m": {"position": [0, 0.1, -0.5], "zyx_deg": [20, 30, 40], "output": seen}},
                },
                "c": {"mass": 0.5, "inertia": inertia, "marker": {"m": {"position": [0.2, 0, 0]}}},
                "d": {"mass": 0.7, "inertia": inertia},
            },
            "joint": {
                "ja": {
                    "revolute": {"axis": "y"},
                    "between": ["ground", "a"],
                    "start": {"angle": 0.4, "speed": 0.5},
                    "spring": {"table": {"position": [-1, 0, 1], "effort": [-5, 0, 9]}},
                    "damper": {"table": {"speed": [-2, 0, 2], "effort": [-0.4, 0, 0.6]}},
                    "input": "torque",
                    "output": ["angle", "speed", "acceleration", *REACTIONS],
                },
                "jb": {
                    "spherical": {},
                    "between": ["a.m", "b"],
                    "start": {"omega": [1, 2, 0.5]},
                    "output": REACTIONS,
                },
                "weld": {"fixed": {}, "between": ["b.m", "c"], "output": REACTIONS},
                "jd": {
                    "prismatic": {"axis": [1, 0, 1]},
                    "between": ["ground", "d"],
                    "start": {"position": 0.3, "speed": 1.0},
                    "friction": {"coulomb": 0.5, "static": 0.8, "viscous": 0.1, "smoothing_speed": 0.05},
                    "stop": {"lower": -0.5, "upper": 0.5, "stiffness": 300.0, "damping": 2.0},
                    "output": REACTIONS,
                },
                "rod": {"distance": {}, "between": ["d", "c.m"], "output": REACTIONS},
            },
            "force": {
                "strut": {
                    "spring_damper": {"table": {"length": [0.5, 1, 2], "force": [-4, 0, 6]}, "damping": 0.2},
                    "between": ["ground.peg", "b"],
                    "input": "force",
                    "output": ["length", "rate"],
                },
                "bush": {
                    "bushing": {"stiffness": [1, 2, 3, 4, 5, 6], "damping": [0.1] * 6},
                    "between": ["a", "c"],
                },
                "steady": {
                    "load": {"force": [0.1, 0.2, 0.3], "moment": [0.3, 0.2, 0.1], "axes": "body"},
                    "on": "b.m",
                },
                "gust": {
                    "load": {"table": {"time": [0, 0.1, 0.3], "force": [[0, 0, 0], [2, 1, 0], [0, 0, 1]]}},
                    "on": "c",
                },
            },
            "measure": {
                "m": {
                    "between": ["a.m", "c.m"],
                    "output": [
                        "distance",
                        "distance_rate",
                        "angle",
                        "position",
                        "velocity",
                        "acceleration",
                        "euler_parameters",
                        "zyx",
                        "omega",
                    ],
                }
            },
        }
    )


@pytest.fixture(scope="module")
def everything_model():
    return compile_scene(everything())


def test_rates_are_the_slopes_of_what_they_are_rates_of(everything_model):
    """Five-point differences along a run."""
    h, n = 1e-3, 5
    run = simulate(everything_model, 0.05, h, inputs={"ja.torque": 2.0, "strut.force": 1.5})
    at = np.arange(n, 50 - n)

    def columns(name):
        names = [key for key in run if key.partition("[")[0] == name]
        return np.column_stack([run[key] for key in names])

    def slopes(name):
        y = columns(name)
        steps = np.array([-1, 9, -45, 45, -9, 1]) / (60 * h)
        return sum(step * y[at + k] for step, k in zip(steps, (-3, -2, -1, 1, 2, 3)))

    pairs = {
        "b.position": "b.velocity",
        "b.velocity": "b.acceleration",
        "b.omega": "b.alpha",
        "b.omega_body": "b.alpha_body",
        "b.m.velocity": "b.m.acceleration",
        "b.m.omega": "b.m.alpha",
        "ja.angle": "ja.speed",
        "ja.speed": "ja.acceleration",
        "m.distance": "m.distance_rate",
        "m.position": "m.velocity",
        "m.velocity": "m.acceleration",
        "strut.length": "strut.rate",
    }

    for value, rate in pairs.items():
        expected = columns(rate)[at]
        assert_near(slopes(value), expected, 2e-6 * max(1, np.abs(expected).max()))

    # the same vectors in other axes
    for name in ("b", "b.m"):
        for quantity in ("acceleration", "alpha"):
            lengths = [np.linalg.norm(columns(f"{name}.{quantity}{axes}"), axis=1) for axes in ("", "_body")]
            assert_near(*lengths, 1e-11)

    momentum = 4.2 * slopes("center_of_mass")
    assert_near(columns("linear_momentum")[at], momentum, 1e-7)
    whole = sum(run[f"{kind}_energy"] for kind in ("kinetic", "gravity", "spring"))
    assert_near(run["total_energy"], whole, 1e-12)
    assert_near(run["potential_energy"], run["gravity_energy"] + run["spring_energy"], 1e-12)
    assert run["constraint_gap"].max() < 1e-12 and run["constraint_rate"].max() < 1e-11


def test_measures_by_hand(everything_model):
    found = named_outputs(Instance(everything_model))
    assert_near(found["m.distance"], np.linalg.norm(found["m.position"]), 1e-15)
    yaw, pitch, roll = found["m.zyx"]
    assert_near(found["m.angle"], np.arccos(np.cos(pitch) * np.cos(roll)), 1e-14)
    rate = found["m.position"] @ found["m.velocity"] / found["m.distance"]
    assert_near(found["m.distance_rate"], rate, 1e-14)


@pytest.mark.parametrize("formulation", ["recursive", "embedding", "augmented"])
@pytest.mark.parametrize("field", [{"gravity": [1, -2, -9]}, {"central_gravity": {"mu": 4.0}}])
def test_all_bodies_count_whatever_is_asked_for(formulation, field):
    """A body that is fixed to the ground has weight and a place too, also where its joint's reactions are asked for."""
    body = {"mass": 2.0, "inertia": [1, 1, 1], "com": [0, 0, 1.0]}
    data = {
        "name": "welded",
        "output": ["center_of_mass", "gravity_energy", "total_energy"],
        "solver": {"formulation": formulation},
        "ground": {"marker": {"m": {"position": [0.5, 0, 0]}}},
        "body": {"still": body, "turns": body | {"mass": 1.0, "com": [0, 3.0, 0]}},
        "joint": {
            "weld": {"fixed": {}, "between": ["ground.m", "still"]},
            "hinge": {"revolute": {}, "between": ["ground", "turns"]},
        },
    } | field
    r, R = np.array([0.5, 0, 1.0]), np.array([0, 3.0, 0])
    mu, g = field.get("central_gravity", {"mu": 0.0})["mu"], np.array(field.get("gravity", [0, 0, 0]))
    energy = -2 * g @ r - g @ R - mu * (2 / np.linalg.norm(r) + 1 / np.linalg.norm(R))

    for told in ({}, {"output": ["reaction_force"]}):
        data["joint"]["weld"] |= told
        found = named_outputs(Instance(compile_scene(Scene(**data))))
        assert_near(found["center_of_mass"], (2 * r + R) / 3, 1e-14)
        assert_near([found["gravity_energy"], found["total_energy"]], energy, 1e-13)


@examples
@given(trees(floating=True, added_mass=False))
def test_momentum_is_kept_without_the_world(case):
    """No gravity, no force to the ground: the momenta keep, and the centre of mass goes straight."""
    scene = case.scene().model_copy(
        update={
            "gravity": (0.0, 0.0, 0.0),
            "output": ["linear_momentum", "angular_momentum", "center_of_mass"],
        }
    )
    instance = random_instance(scene)
    first = named_outputs(instance)
    instance.step(0.02)
    last = named_outputs(instance)
    mass = sum(body.mass_properties()[0] for body in scene.body.values())

    for name in ("linear_momentum", "angular_momentum"):
        assert_near(last[name], first[name], 1e-6 * max(1, np.abs(first[name]).max()))

    moved = first["center_of_mass"] + 0.02 * first["linear_momentum"] / mass
    assert_near(last["center_of_mass"], moved, 1e-7)


# dependencies, FMU


def test_outputs_depend_on_what_they_feel_at_once(everything_model):
    variables = everything_model.variables
    inputs = {v.name: k for k, v in enumerate(variables) if v.causality == "input"}
    depends = {v.name: {variables[k].name for k in v.depends} for v in variables if v.causality == "output"}
    everyone = set(inputs)

    for name, found in depends.items():
        felt = any(word in name for word in ("accel", "alpha", "reaction", "multiplier"))
        assert found == (everyone if felt else set()), name

    model = compile_scene(
        Scene.model_validate(
            {
                "name": "two",
                "body": {name: {"mass": 1, "inertia": [0, 0, 0]} for name in ("a", "b")},
                "joint": {
                    name: {
                        "prismatic": {},
                        "between": ["ground", name[1]],
                        "input": "force",
                        "output": ["position", "reaction_force"],
                        "start": {"position": k},
                    }
                    for k, name in enumerate(("ja", "jb"))
                },
            }
        )
    )
    depends = {v.name: v.depends for v in model.of_causality("output")}
    assert depends["ja.position"] == depends["jb.position"] == ()
    assert depends["ja.reaction_force[1]"] == (0,) and depends["jb.reaction_force[3]"] == (1,)


def test_a_force_carries_prescribed_motion_across():
    """What an input leads pulls at once at what a spring hangs on it, not at what a force input pushes beyond."""
    scene = {
        "name": "pull",
        "body": {name: {"mass": 1, "inertia": [0, 0, 0]} for name in ("a", "b", "c")},
        "joint": {
            "ja": {"prismatic": {}, "driver": {"input": ["position"]}},
            "jb": {"prismatic": {}, "input": "force", "start": {"position": 1}},
            "jc": {"prismatic": {}, "start": {"position": 3}},
        },
        "force": {
            "ab": {"spring_damper": {"stiffness": 10}, "between": ["a", "b"]},
            "bc": {"spring_damper": {"stiffness": 10}, "between": ["b", "c"]},
        },
    }
    for name, joint in scene["joint"].items():
        joint |= {"between": ["ground", name[1]], "output": ["position", "acceleration"]}

    model = compile_scene(Scene.model_validate(scene))
    command, force = (v.index for v in model.of_causality("input"))
    depends = {v.name: v.depends for v in model.of_causality("output")}
    assert depends["ja.position"] == (command,) and depends["jb.position"] == ()
    assert depends["jb.acceleration"] == (command, force)
    assert force not in depends["jc.acceleration"] and command not in depends["jc.position"]
    instance = Instance(model, inputs={command: 0.0, force: 0.0})
    before = named_outputs(instance)["jb.acceleration"]
    instance.u[command] = 0.1
    assert abs(named_outputs(instance)["jb.acceleration"] - before) > 0.5


def test_a_moving_ground_feels_what_pushes_bodies_in_its_water():
    """Added mass presses on the ground as its body accelerates, though no joint leads there."""
    added = np.diag([1.0, 1.0, 1.0, 1.0, 1.0, 1.0])
    added[0, 2] = added[2, 0] = 0.5
    scene = {
        "name": "water",
        "gravity": [0, 0, 0],
        "output": ["driver_power"],
        "ground": {
            "motion": {"rotation": {"axis": "y", "speed": 0.3, "point": [1, 0, 0]}},
            "output": ["reaction_force"],
        },
        "body": {"b": {"mass": 1.0, "inertia": [0, 0, 0]}},
        "joint": {"slide": {"prismatic": {}, "input": "force", "between": ["inertial", "b"]}},
        "force": {"m": {"linear": {"added_mass": added.tolist()}, "between": ["ground", "b"]}},
    }
    model = compile_scene(Scene.model_validate(scene))
    instance = Instance(model)
    before = instance.outputs().copy()
    instance.u[0] = 2.0
    changed = dict(zip((v.name for v in model.of_causality("output")), np.abs(instance.outputs() - before)))
    assert changed["driver_power"] > 0.1 and changed["ground.reaction_force[3]"] > 0.1
    assert all(v.depends == (0,) for v in model.of_causality("output"))


def test_a_ground_at_rest_feels_by_forces_what_is_led():
    """A body that an input moves pulls at the ground by a spring, at once; what pushes it is not felt before it moves."""
    slide = {"prismatic": {"axis": "x"}}
    scene = {
        "name": "spring",
        "gravity": [0, 0, 0],
        "ground": {"output": ["reaction_force"]},
        "body": {name: {"mass": 1.0, "inertia": [1, 1, 1]} for name in "ab"},
        "joint": {
            "a": {"free": {}, "between": ["ground", "a"]},
            "b": slide | {"between": ["a", "b"], "driver": {"input": True}},
        },
        "force": {
            "spring": {"bushing": {"stiffness": np.diag([100.0] * 6).tolist()}, "between": ["ground", "b"]},
        },
    }
    scene["body"]["b"]["input"] = ["force"]
    model = compile_scene(Scene.model_validate(scene))
    instance = Instance(model)
    names = [v.name for v in model.of_causality("input")]
    before = instance.outputs().copy()
    instance.u[names.index("b.position_command")] = 0.1
    assert abs(instance.outputs()[0] - before[0]) > 1.0
    felt = {names[k] for k in model.of_causality("output")[0].depends}
    assert "b.position_command" in felt and not any(name.startswith("b.force") for name in felt)


def test_a_reaction_tells_what_its_dependencies_say(everything_model):
    """Outputs without dependencies do not change with the inputs, the others do (all but what is zero by nature)."""
    instance = Instance(everything_model)
    before = instance.outputs().copy()
    instance.u[:2] = [3.0, -2.0]
    changed = instance.outputs() != before
    depends = np.array([bool(v.depends) for v in everything_model.of_causality("output")])
    assert not np.any(changed & ~depends)
    assert np.sum(changed & depends) > 0.8 * np.sum(depends)


def test_fmu_says_the_same(everything_model, tmp_path):
    fmu = export_fmu(everything_model, tmp_path / "everything.fmu")
    inputs = {"ja.torque": 2.0, "strut.force": 1.5}
    H, n = 1 / 64, 32
    signals = np.array(
        [(0.0, *inputs.values()), (1.0, *inputs.values())], [("time", float), *((k, float) for k in inputs)]
    )
    there = fmpy.simulate_fmu(
        str(fmu), stop_time=n * H, output_interval=H, input=signals, start_values=inputs
    )
    inside = simulate(everything_model, n * H, H, inputs=inputs)

    for v in everything_model.of_causality("output"):
        scale = np.abs(inside[v.name]).max() + 1
        assert_near(there[v.name], inside[v.name], 1e-12 * scale)
