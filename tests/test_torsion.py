"""The torsion spring-damper between two markers: closed forms over several turns, and its energy where nothing keeps axes parallel."""

import numpy as np
import pytest
from fmu_host import OK as GOOD
from fmu_host import Instance as Hosted
from fmu_host import Library
from scenes import assert_near

from mbdfmi import Scene, SceneError
from mbdfmi.compiler.model import compile_scene
from mbdfmi.run.instance import Instance

OUTPUTS = ["angle", "rate", "moment", "spring_moment", "damper_moment", "power"]


def run(data, end, steps=1, **solver):
    """Outputs at a time by name."""
    instance = Instance(compile_scene(Scene.model_validate(data | {"solver": {"tolerance": 1e-13} | solver})))

    for _ in range(steps):
        instance.step(end / steps)

    return dict(zip([v.name for v in instance.model.of_causality("output")], instance.outputs().copy()))


def shaft(torsion, joint=None, ends=("ground", "disk")):
    """A disk of 0.5 kg m2 on a hinge about z, with a torsion spring."""
    hinge = {"revolute": {}, "between": ["ground", "disk"], "output": ["angle", "speed"]} | (joint or {})
    return {
        "name": "shaft",
        "body": {"disk": {"mass": 1.0, "inertia": [0.3, 0.3, 0.5]}},
        "joint": {"hinge": hinge},
        "force": {"bar": {"torsion": torsion, "between": list(ends), "output": OUTPUTS}},
        "output": ["total_energy", "spring_energy", "dissipated_power"],
    }


@pytest.mark.parametrize("formulation", ["recursive", "embedding", "augmented"])
def test_a_wound_up_shaft_unwinds(formulation):
    """I a'' = -k (a - a0) - c a' from rest at 0 with a0 of two and a half turns."""
    k, c, rest, I, t = 4.0, 0.3, np.deg2rad(900), 0.5, 2.5
    y = run(shaft({"stiffness": k, "damping": c, "rest_deg": 900}), t, steps=5, formulation=formulation)
    decay = c / (2 * I)
    w = np.sqrt(k / I - decay**2)
    fade = np.exp(-decay * t)
    angle = rest - rest * fade * (np.cos(w * t) + decay / w * np.sin(w * t))
    rate = rest * fade * np.sin(w * t) * (w + decay**2 / w)
    assert_near([y["hinge.angle"], y["bar.angle"]], angle, 1e-9)
    assert_near([y["hinge.speed"], y["bar.rate"]], rate, 1e-9)
    assert_near(y["bar.spring_moment"], -k * (angle - rest), 1e-8)
    assert_near(y["bar.damper_moment"], -c * rate, 1e-8)
    assert_near(y["bar.moment"], y["bar.spring_moment"] + y["bar.damper_moment"], 1e-12)
    assert_near(y["bar.power"], y["bar.moment"] * y["bar.rate"], 1e-12)
    assert_near(y["spring_energy"], 0.5 * k * (angle - rest) ** 2, 1e-7)
    assert_near(y["dissipated_power"], c * rate**2, 1e-7)


def test_it_is_the_spring_of_a_joint_and_counts_backwards_from_the_other_end():
    """Tables too, over more than a turn."""
    table = {"position_deg": [-800.0, 0.0, 50.0, 900.0], "effort": [-9.0, 0.0, 2.0, 11.0]}
    damper = {"table": {"speed": [-1.0, 0.0, 2.0], "effort": [-0.2, 0.0, 0.1]}}
    start = {"start": {"angle": 0.5, "speed": 20.0}}
    apart = run(shaft({"table": table, "damping": damper}, start), 0.6)
    joint = shaft({"stiffness": 0.0}, start | {"spring": {"table": table}, "damper": damper})
    inside = run(joint, 0.6)
    assert inside["hinge.angle"] > 7.0
    assert_near(apart["hinge.angle"], inside["hinge.angle"], 1e-10)
    assert_near(apart["total_energy"], inside["total_energy"], 1e-9)
    back = run(shaft({"stiffness": 1.0, "rest": 2.0}, start, ("disk", "ground")), 0.6)
    assert_near(back["bar.angle"], -back["hinge.angle"], 1e-9)
    assert_near(back["bar.moment"], -(back["bar.angle"] - 2.0), 1e-9)


def test_turns_are_counted_where_a_joint_is_driven():
    """Three and a quarter turns in one step."""
    joint = {"driver": {"constant_speed_deg": 1170.0}}
    y = run(shaft({"stiffness": 2.0}, joint), 1.0)
    assert_near(y["bar.angle"], 6.5 * np.pi, 1e-9)
    assert_near(y["bar.moment"], -13 * np.pi, 1e-8)


def test_between_floating_bodies_energy_and_momentum_are_kept():
    """Axes far from parallel, which turn over a second."""
    free = lambda body, **start: {"free": {}, "between": ["ground", body], "start": start}
    data = {
        "name": "floating",
        "gravity": [0, 0, 0],
        "body": {
            "a": {"mass": 1.0, "inertia": [0.4, 0.5, 0.6], "marker": {"m": {"zyx_deg": [20, 30, 40]}}},
            "b": {"mass": 2.0, "inertia": [0.7, 0.5, 0.6], "marker": {"m": {"position": [0.1, 0.2, 0.3]}}},
        },
        "joint": {
            "fa": free("a", omega=[0.3, -0.5, 0.4]),
            "fb": free("b", omega=[-0.2, 0.4, 3.0], zyx_deg=[40, -20, 10]),
        },
        "force": {
            "bar": {"torsion": {"stiffness": 3.0, "rest": -0.7}, "between": ["a.m", "b.m"], "output": OUTPUTS}
        },
        "output": ["total_energy", "angular_momentum", "spring_energy"],
    }
    first, last = run(data, 1e-9), run(data, 1.0)
    assert abs(last["spring_energy"] - first["spring_energy"]) > 0.1

    for name in ("total_energy", *(f"angular_momentum[{k}]" for k in (1, 2, 3))):
        assert_near(last[name], first[name], 1e-10)


# starts at half a turn, where the twist may be read on either side

# their settings, and how near the angle comes to the closed form
STEPPERS = {
    "auto": ({"tolerance": 1e-12}, 1e-9),
    "rk54": ({"tolerance": 1e-12}, 1e-9),
    "rk853": ({"tolerance": 1e-12}, 1e-9),
    "radau": ({"tolerance": 1e-12}, 1e-9),
    "rk4": ({"step": 0.004}, 1e-7),
    "ros2": ({"step": 0.001}, 1e-4),
    "gauss": ({"step": 0.004}, 1e-7),
}
WAYS = [(f, "rk853") for f in ("recursive", "embedding", "augmented")]
WAYS += [("recursive", stepper) for stepper in STEPPERS if stepper != "rk853"]
HOLDS = ("revolute", "universal", "spherical", "free", "both")


def started(hold, start, speed, stiffness=4.0, rest=150.0):
    """A disk of 0.5 kg m2 about z, turned there at the start (deg, rad/s), held in one of many ways, on a torsion spring."""
    turned = {"revolute": {"angle_deg": start, "speed": speed}, "universal": {"angles_deg": [0, start]}}
    turned["universal"]["speeds"] = [0.0, speed]
    about = {"zyx_deg": [start, 0.0, 0.0], "omega": [0.0, 0.0, speed]}
    kind = "revolute" if hold == "both" else hold
    options = {"axes": ["x", "z"]} if kind == "universal" else {}
    joint = {kind: options, "between": ["ground", "disk"], "start": turned.get(kind, about)}

    # a spring of the joint counts turns from the joint's start
    if hold == "both":
        joint["spring"] = {"stiffness": 0.5 * stiffness, "rest_deg": rest + start - within(start)}
        stiffness *= 0.5

    return {
        "name": "half a turn",
        "gravity": [0, 0, 0],
        "body": {"disk": {"mass": 1.0, "inertia": [0.3, 0.3, 0.5]}},
        "joint": {"hold": joint},
        "force": {
            "bar": {
                "torsion": {"stiffness": stiffness, "rest_deg": rest},
                "between": ["ground", "disk"],
                "output": OUTPUTS,
            }
        },
        "output": ["total_energy"],
    }


def within(start):
    """The same angle (deg) from beyond -180 to 180."""
    return 180.0 - (180.0 - start) % 360.0


@pytest.mark.parametrize("formulation, stepper", WAYS)
@pytest.mark.parametrize("hold", HOLDS)
@pytest.mark.parametrize("start, speed", [(180, 0.0), (180, 3.0), (-180, -1.0), (540, 1.0), (-900, 0.0)])
def test_a_start_at_half_a_turn_swings_about_the_rest(formulation, stepper, hold, start, speed):
    """I a'' = -k (a - a0) from there, in closed form; the energy stays."""
    options, near = STEPPERS[stepper]
    instance = Instance(
        compile_scene(
            Scene.model_validate(
                started(hold, start, speed)
                | {"solver": {"formulation": formulation, "integrator": stepper} | options}
            )
        )
    )
    names = [v.name for v in instance.model.of_causality("output")]
    y = dict(zip(names, instance.outputs().copy()))
    energy = y["total_energy"]
    first, rest, w = np.pi, np.deg2rad(150.0), np.sqrt(4.0 / 0.5)
    assert_near(y["bar.angle"], first, 1e-9)

    for k in range(1, 5):
        instance.step(0.3)
        y = dict(zip(names, instance.outputs().copy()))
        t = 0.3 * k
        angle = rest + (first - rest) * np.cos(w * t) + speed / w * np.sin(w * t)
        assert_near(y["bar.angle"], angle, near)
        assert_near(y["total_energy"], energy, 20 * near)


@pytest.mark.parametrize("start", [180.0, -180.0, 540.0, 179.99, -179.99])
@pytest.mark.parametrize("hold", HOLDS)
def test_statics_and_runs_agree_on_the_turn_at_the_start(hold, start):
    """The rest is found where runs swing about it, and a run from there stays."""
    scene = Scene.model_validate(started(hold, start, 0.0, rest=170.0))
    found = scene.equilibrium()
    assert_near(found.outputs["bar.angle"], np.deg2rad(170.0), 1e-9)
    run = found.scene.simulate(1.0, 0.25)
    assert_near(run["bar.angle"], np.deg2rad(170.0), 1e-7)


def test_an_fmu_that_starts_at_half_a_turn_keeps_the_turn(tmp_path):
    """To the bits of a run in process; saved, taken on, restored, reset: the same again."""
    scene = Scene.model_validate(started("spherical", 180.0, 3.0))
    fmu = Hosted(Library(scene.export(tmp_path / "half.fmu"), tmp_path / "half")).start()
    instance = Instance(compile_scene(scene))
    seen = []

    for again in range(2):
        seen.append([fmu.outputs()])

        for k in range(4):
            if k == 1 and again == 0:
                snapshot = fmu.save()

            assert fmu.step(0.3 * k, 0.3) == GOOD
            seen[-1].append(fmu.outputs())

        if again == 0:
            assert fmu.restore(snapshot) == GOOD
            assert fmu.outputs() == seen[0][1]
            assert fmu.reset() == GOOD
            fmu.start()

    for k in range(5):
        assert list(instance.outputs()) == seen[0][k] == seen[1][k]
        instance.step(0.3)

    fmu.free()


def test_mistakes_are_told():
    for torsion, text in (
        ({"damping": 1.0}, "stiffness"),
        ({"stiffness": -1.0}, "stiffness"),
        ({"stiffness": 1.0, "rest": 0.1, "rest_deg": 3.0}, "rest_deg"),
        ({"stiffness": 1.0, "axis": "x"}, "axis"),
    ):
        with pytest.raises(SceneError, match=rf"force\.bar.*{text}"):
            Scene.model_validate(shaft(torsion))

    data = shaft({"stiffness": 1.0})
    data["force"]["bar"]["output"] = ["tension"]

    with pytest.raises(SceneError, match=r"force\.bar.*output.*moment"):
        Scene.model_validate(data)
