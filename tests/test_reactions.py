"""Reactions of joints: closed forms, multipliers of absolute coordinates, wherever a loop is cut."""

import numpy as np
import pytest
from hypothesis import given
from referee.independent import System
from scenes import assert_near, examples, inputs_of, random_instance, trees
from test_outputs import REACTIONS, named_outputs

from mbdfmi import Scene
from mbdfmi.compiler.model import compile_scene
from mbdfmi.run.instance import Instance
from mbdfmi.run.simulate import simulate
from mbdfmi.scene import fmi_name


def with_outputs(scene):
    """A scene whose joints tell their reactions."""
    joints = {
        name: joint if joint.kind == "free" else joint.model_copy(update={"output": REACTIONS})
        for name, joint in scene.joint.items()
    }
    return scene.model_copy(update={"joint": joints})


# closed forms


def test_tension_of_a_pendulum():
    m, l, angle, w = 2.0, 0.7, 0.6, 3.0
    scene = Scene.model_validate(
        {
            "name": "pendulum",
            "body": {"bob": {"mass": m, "com": [0, 0, -l], "inertia": [0.1, 0.1, 0.1]}},
            "joint": {
                "pin": {
                    "revolute": {"axis": "y"},
                    "between": ["ground", "bob"],
                    "start": {"angle": angle, "speed": w},
                    "output": REACTIONS,
                }
            },
        }
    )
    found = named_outputs(Instance(compile_scene(scene)))
    g, I = 9.81, 0.1 + m * l * l
    along = np.array([np.sin(angle), 0, np.cos(angle)])
    across = np.array([np.cos(angle), 0, -np.sin(angle)])
    tension = m * g * np.cos(angle) + m * l * w**2

    # the bob's own acceleration across takes the rest of its weight
    shear = m * g * (m * l * l / I - 1) * np.sin(angle)
    assert_near(found["pin.reaction_force"], tension * along + shear * across, 1e-13)
    assert_near(found["pin.reaction_moment"], 0, 1e-13)


@pytest.mark.parametrize("reverse", [False, True])
def test_cantilever_of_fixed_parts(reverse):
    """Parts held together one behind another: each joint bears what is beyond it. No freedom is left."""
    masses, length, n = [3.0, 2.0, 1.0], 0.5, 3
    body = {
        f"part {k}": {
            "mass": mass,
            "com": [length / 2, 0, 0],
            "inertia": [0, 0.1, 0.1],
            "marker": {"end": {"position": [length, 0, 0]}},
        }
        for k, mass in enumerate(masses)
    }
    joint = {}

    for k in range(n):
        ends = ["ground" if k == 0 else f"part {k - 1}.end", f"part {k}"]
        joint[f"weld {k}"] = {"fixed": {}, "between": ends[::-1] if reverse else ends, "output": REACTIONS}

    found = named_outputs(
        Instance(compile_scene(Scene.model_validate({"name": "beam", "body": body, "joint": joint})))
    )
    sign = -1 if reverse else 1

    for k in range(n):
        weight = 9.81 * np.array(masses[k:])
        arms = length * (np.arange(n - k) + 0.5)
        name = fmi_name(f"weld {k}")
        assert_near(found[f"{name}.reaction_force"], [0, 0, sign * weight.sum()], 1e-13)
        assert_near(found[f"{name}.reaction_moment"], [0, -sign * weight @ arms, 0], 1e-13)


def test_multiplier_and_reaction_of_a_rod():
    """A massless rod's tension: m g cos + m l w^2, in the multiplier and in the reaction of both formulations."""
    l, m, w = 1.3, 2.0, 0.9
    angle = 0.4
    at = l * np.array([np.sin(angle), 0, -np.cos(angle)])
    v = l * w * np.array([np.cos(angle), 0, np.sin(angle)])
    scene = {
        "name": "rod",
        "output": ["multipliers", "constraint_gap", "constraint_rate"],
        "body": {"bob": {"mass": m, "inertia": [0, 0, 0]}},
        "joint": {
            "way": {
                "translation": {},
                "between": ["ground", "bob"],
                "start": {"position": at.tolist(), "velocity": v.tolist()},
            },
            "rod": {"distance": {"length": l}, "between": ["ground", "bob"], "output": REACTIONS},
        },
    }
    found = named_outputs(Instance(compile_scene(Scene.model_validate(scene))))
    tension = m * 9.81 * np.cos(angle) + m * l * w * w
    assert_near(found["multipliers"], [-tension], 1e-12)
    assert_near(found["rod.reaction_force"], -tension * at / l, 1e-12)
    assert_near(found["rod.reaction_moment"], 0, 1e-12)
    assert found["constraint_gap"] < 1e-15 and found["constraint_rate"] < 1e-14


def test_of_two_joints_between_the_same_markers_each_bears_its_own():
    """Two slides and two hinges, closing loops side by side: along its axis each passes on what its own spring does."""
    joint = {"lift": {"prismatic": {}, "between": ["ground", "a"], "start": {"position": 0.3}}}
    joint["turn"] = {"revolute": {}, "between": ["a", "b"], "start": {"angle": 0.2}}

    for name, stiffness in {"one": 5.0, "two": 70.0}.items():
        spring = {"spring": {"stiffness": stiffness}, "output": REACTIONS}
        joint[f"slide {name}"] = {"prismatic": {}, "between": ["ground", "a"]} | spring
        joint[f"hinge {name}"] = {"revolute": {}, "between": ["a", "b"]} | spring

    body = {key: {"mass": 1.0, "inertia": [0.1] * 3} for key in "ab"}
    scene = Scene.model_validate({"name": "twice", "body": body, "joint": joint})
    found = named_outputs(Instance(compile_scene(scene)))

    for name, stiffness in {"one": 5.0, "two": 70.0}.items():
        assert found[f"'slide {name}'.reaction_force"][2] == pytest.approx(-0.3 * stiffness, abs=1e-12)
        assert found[f"'hinge {name}'.reaction_moment"][2] == pytest.approx(-0.2 * stiffness, abs=1e-12)


# absolute coordinates


@examples
@given(trees())
def test_reactions_are_the_multipliers_of_absolute_coordinates(case):
    """What each joint bears beside what it moves, against the independent route, where no tree is."""
    scene = case.scene()
    instance = random_instance(with_outputs(scene))
    found = named_outputs(instance)
    system = System(scene.model_dump(exclude_unset=True))
    expected = system.evaluate(0.0, system.start_motions(), inputs_of(instance))
    size = 1.0 + max((np.abs(value).max() for value in found.values()), default=0.0)

    for name, value in found.items():
        assert_near(value, expected[name], 1e-10 * size)


def four_bar(**solver):
    """A spatial loop of one freedom that determines its reactions (revolute, spherical, universal, revolute), with something
    in every revolute joint, a second revolute on the way and an input.
    """
    bar = {"mass": 1.0, "inertia": [0.02, 0.03, 0.04]}
    return Scene.model_validate(
        {
            "name": "four bar",
            "solver": solver,
            "output": ["total_energy", "constraint_gap"],
            "ground": {"marker": {"far": {"position": [1.0, 0.1, 0.0]}}},
            "body": {
                "crank": bar | {"com": [0, 0, 0.2], "marker": {"tip": {"position": [0, 0, 0.4]}}},
                "coupler": bar | {"com": [0.5, 0, 0], "marker": {"tip": {"position": [1.0, 0, 0]}}},
                "rocker": bar | {"com": [0, 0, 0.3], "marker": {"tip": {"position": [0, 0, 0.6]}}},
            },
            "joint": {
                "a": {
                    "revolute": {"axis": [0.1, 1, 0]},
                    "between": ["ground", "crank"],
                    "start": {"angle": 0.3, "speed": 2.0},
                    "input": "torque",
                    "friction": {"coulomb": 0.3, "smoothing_speed": 0.1},
                    "output": REACTIONS + ["angle"],
                },
                "b": {
                    "spherical": {},
                    "between": ["coupler", "crank.tip"],
                    "input": "torque",
                    "output": REACTIONS,
                },
                "c": {
                    "universal": {"axes": ["y", "z"]},
                    "between": ["coupler.tip", "rocker.tip"],
                    "output": REACTIONS,
                },
                "d": {
                    "revolute": {"axis": "y"},
                    "between": ["rocker", "ground.far"],
                    "spring": {"stiffness": 4.0, "rest": 0.2},
                    "damper": 0.5,
                    "stop": {"upper": -0.5, "stiffness": 30.0},
                    "output": REACTIONS,
                },
            },
        }
    )


def test_reactions_do_not_depend_on_where_the_loop_is_cut():
    found = []

    for formulation in ("recursive", "embedding", "augmented"):
        instance = Instance(compile_scene(four_bar(formulation=formulation, tolerance=1e-12)))
        instance.u[:4] = [3.0, 0.3, -0.4, 0.5]
        outputs = [named_outputs(instance)]
        instance.step(0.4)
        outputs.append(named_outputs(instance))
        found.append(outputs)

    for others in found[1:]:
        for before, after in zip(found[0], others):
            for name, value in before.items():
                assert_near(after[name], value, 1e-8 * max(1, np.abs(value).max()))


def slider_crank(driver, **solver):
    """A driven crank with spring and friction of its own, a rod, a piston under load: determinate, of no freedom."""
    bar = {"mass": 1.0, "inertia": [0.02, 0.03, 0.04]}
    return Scene.model_validate(
        {
            "name": "slider-crank",
            "solver": {"tolerance": 1e-11} | solver,
            "output": ["total_energy"],
            "body": {
                "crank": bar | {"com": [0.1, 0, 0], "marker": {"tip": {"position": [0.2, 0, 0]}}},
                "rod": bar | {"com": [0.3, 0, 0], "marker": {"tip": {"position": [0.6, 0, 0]}}},
                "piston": {"mass": 2.0, "inertia": [0.1, 0.1, 0.1], "output": ["velocity"]},
            },
            "joint": {
                "crank pin": {
                    "revolute": {"axis": "y"},
                    "between": ["ground", "crank"],
                    "driver": driver,
                    "spring": {"stiffness": 2.0},
                    "friction": {"coulomb": 0.5, "smoothing_speed": 0.1},
                    "output": ["angle", "speed", "effort", *REACTIONS],
                },
                "big end": {"spherical": {}, "between": ["crank.tip", "rod"], "output": REACTIONS},
                "small end": {
                    "universal": {"axes": ["y", "z"]},
                    "between": ["piston", "rod.tip"],
                    "output": REACTIONS,
                },
                "bore": {
                    "prismatic": {"axis": "x"},
                    "between": ["ground", "piston"],
                    "start": {"position": 0.8},
                    "output": ["position", *REACTIONS],
                },
            },
            "force": {"gas": {"load": {"force": [-5.0, 0, 0]}, "on": "piston"}},
        }
    )


DRIVERS = {
    "constant": {"constant_speed": 3.0},
    "harmonic": {"harmonic": {"amplitude": 0.8, "frequency": 1.5}},
}


@pytest.mark.parametrize("driver", DRIVERS.values(), ids=DRIVERS)
def test_driven_slider_crank(driver):
    """Effort and reactions are the same wherever loops are cut; the crank's reaction about its axis is all that acts in it."""
    found = []

    for formulation in ("recursive", "embedding", "augmented"):
        instance = Instance(compile_scene(slider_crank(driver, formulation=formulation)))
        instance.step(0.3)
        found.append(named_outputs(instance))

    for others in found[1:]:
        for name, value in found[0].items():
            assert_near(others[name], value, 1e-7 * max(1, np.abs(value).max()))

    angle, speed, effort = (found[0][f"'crank pin'.{name}"][0] for name in ("angle", "speed", "effort"))
    in_joint = effort - 2.0 * angle - 0.5 * np.tanh(speed / 0.1)
    assert_near(found[0]["'crank pin'.reaction_moment"][1], in_joint, 1e-9)


def test_driving_effort_brings_the_energy():
    """Five-point slopes of the energy along a run: power of the drive and of the load, less that of friction."""
    h = 1e-3
    run = simulate(compile_scene(slider_crank(DRIVERS["harmonic"])), 0.1, h)
    speed = run["'crank pin'.speed"]
    power = (
        run["'crank pin'.effort"] * speed
        - 0.5 * np.tanh(speed / 0.1) * speed
        - 5.0 * run["piston.velocity[1]"]
    )
    at = np.arange(3, 97)
    steps = np.array([-1, 9, -45, 45, -9, 1]) / (60 * h)
    slope = sum(step * run["total_energy"][at + k] for step, k in zip(steps, (-3, -2, -1, 1, 2, 3)))
    assert_near(slope, power[at], 1e-6 * np.abs(power).max())


@pytest.mark.parametrize("formulation", ["recursive", "augmented"])
def test_gear_loads_its_joints(formulation):
    """Two wheels on parallel shafts: the gear's effort in each shaft is what its wheel needs beside its input."""
    wheel = {"mass": 1.0, "inertia": [0.1, 0.1, 0.2]}
    pin = {"revolute": {}, "output": ["acceleration", *REACTIONS]}
    scene = Scene.model_validate(
        {
            "name": "gear",
            "gravity": [0, 0, 0],
            "solver": {"formulation": formulation},
            "body": {"small": wheel, "large": wheel | {"inertia": [0.5, 0.5, 1.0]}},
            "ground": {"marker": {"far": {"position": [1, 0, 0]}}},
            "joint": {
                "in": pin | {"between": ["ground", "small"], "input": "torque"},
                "out": pin | {"between": ["ground.far", "large"]},
            },
            "coupling": {"gear": {"gear": {"ratio": -0.25}, "between": ["in", "out"]}},
        }
    )
    instance = Instance(compile_scene(scene))
    instance.u[0] = 3.0
    found = named_outputs(instance)
    acceleration = 3.0 / (0.2 + 1.0 / 16)
    assert_near(found["in.acceleration"], [acceleration], 1e-12)
    assert_near(found["out.acceleration"], [-acceleration / 4], 1e-12)
    assert_near(found["in.reaction_moment"], [0, 0, 0.2 * acceleration], 1e-12)
    assert_near(found["out.reaction_moment"], [0, 0, -acceleration / 4], 1e-12)
