"""Prescribed motions of joints: each way against its closed form, in the tree and where the joint closes a loop."""

import numpy as np
import pytest
from scenes import assert_near
from scipy.integrate import quad

import mbdfmi
from mbdfmi.compiler.interpolation import curve
from mbdfmi.compiler.model import compile_scene
from mbdfmi.run.simulate import simulate

INERTIA = [0.01] * 3
SPEEDS = ([0.5, 1.0, 2.0, 2.5, 4.0], [0.0, 0.0, 1.5, -0.5, 0.7])


def ramp(t, begin=0.5, end=2.5, start=0.2, rise=1.3):
    """Position, speed and acceleration of the quintic ramp."""
    T = end - begin
    s = np.clip((t - begin) / T, 0, 1)
    x = np.polynomial.Polynomial([0, 0, 0, 10, -15, 6])
    return start + rise * x(s), rise / T * x.deriv()(s), rise / T**2 * x.deriv(2)(s)


def waves(t):
    """Of two waves."""
    a, f, p = np.array([0.3, 0.1]), np.array([0.5, 1.7]), np.radians([0, 40])
    w = 2 * np.pi * f
    angle = np.outer(t, w) + p
    return 0.25 + np.sin(angle) @ a, np.cos(angle) @ (a * w), -np.sin(angle) @ (a * w * w)


def polynomial(t):
    p = np.polynomial.Polynomial([0.3, -0.2, 0.1, 0.05, -0.02])
    return p(t), p.deriv()(t), p.deriv(2)(t)


def speeds(interpolation, start):
    """Of a speed over time: the position is its integral."""
    t, v = map(np.array, SPEEDS)
    law = curve(interpolation, t, v)

    def motion(now):
        inside = np.clip(now, t[0], t[-1])
        beyond = (now > t[0]) & (now < t[-1])
        speed = law(inside)
        way = [
            quad(lambda s: law(np.clip(s, t[0], t[-1])), 0, end, points=[p for p in t if p < end] or None)[0]
            for end in now
        ]
        return start + np.array(way), speed, np.where(beyond, law(inside, 1), 0.0)

    return motion


def still(t):
    return np.full_like(t, 0.4), 0 * t, 0 * t


COEFFICIENTS = [0.3, -0.2, 0.1, 0.05, -0.02]
WAYS = {
    "hold": ({"hold": True}, 0.4, still),
    "harmonics": (
        {"harmonics": {"amplitude": [0.3, 0.1], "frequency": [0.5, 1.7], "phase_deg": [0, 40], "mean": 0.25}},
        None,
        waves,
    ),
    "polynomial": ({"polynomial": {"coefficients": COEFFICIENTS}}, None, polynomial),
    "ramp": ({"ramp": {"time": [0.5, 2.5], "position": [0.2, 1.5]}}, None, ramp),
    "ramp down": ({"ramp": {"time": [-1, 1], "position": [1, -1]}}, None, lambda t: ramp(t, -1, 1, 1, -2)),
    "speed_table": ({"speed_table": {"time": SPEEDS[0], "speed": SPEEDS[1]}}, 0.4, speeds("smooth", 0.4)),
    "linear speeds": (
        {"speed_table": {"time": SPEEDS[0], "speed": SPEEDS[1], "interpolation": "linear"}},
        0.4,
        speeds("linear", 0.4),
    ),
}


def crank(driver, start, kind="revolute"):
    """A body on a joint that is driven."""
    quantity = {"revolute": "angle", "prismatic": "position"}[kind]
    joint = {
        kind: {},
        "between": ["ground", "a"],
        "driver": driver,
        "output": [quantity, "speed", "acceleration"],
    }
    joint |= {} if start is None else {"start": {quantity: start}}
    return mbdfmi.Scene(
        name="crank", gravity=[0, 0, 0], body={"a": {"mass": 1, "inertia": INERTIA}}, joint={"turn": joint}
    )


@pytest.mark.parametrize("kind", ["revolute", "prismatic"])
@pytest.mark.parametrize("way", WAYS)
def test_a_driver_moves_its_joint_as_it_says(kind, way):
    driver, start, motion = WAYS[way]
    quantity = {"revolute": "angle", "prismatic": "position"}[kind]
    run = crank(driver, start, kind).simulate(until=5, step=0.1)
    t = run["time"]

    # a jump of the acceleration has no value
    kinks = np.min(np.abs(t[:, None] - np.array(SPEEDS[0])), axis=1) < 1e-9
    some = np.full(len(t), True) if "speed" not in way else ~kinks
    position, speed, acceleration = motion(t)
    assert_near(run[f"turn.{quantity}"], position, 1e-12)
    assert_near(run["turn.speed"], speed, 1e-12)
    assert_near(run["turn.acceleration"][some], acceleration[some], 1e-11)


def four_bar(driver, start, formulation):
    """A crank and rocker, its crank driven."""

    def bar(length):
        return {
            "mass": 1,
            "com": [length / 2, 0, 0],
            "inertia": INERTIA,
            "marker": {"e": {"position": [length, 0, 0]}},
        }

    pin = {"revolute": {}}
    crank = pin | {"between": ["ground", "a"], "driver": driver, "output": ["angle", "speed", "acceleration"]}
    return mbdfmi.Scene(
        name="four_bar",
        gravity=[0, -9.81, 0],
        solver={"formulation": formulation},
        ground={"marker": {"r": {"position": [2.0, 0, 0]}}},
        body={"a": bar(0.5), "b": bar(2.0), "c": bar(1.5)},
        joint={
            "a": crank | ({} if start is None else {"start": {"angle": start}}),
            "ab": pin | {"between": ["a.e", "b"]},
            "c": pin | {"between": ["ground.r", "c"], "start": {"angle_deg": 100}},
            "bc": pin | {"between": ["b.e", "c.e"]},
        },
    )


@pytest.mark.parametrize("formulation", ["recursive", "augmented"])
@pytest.mark.parametrize("way", WAYS)
def test_a_driver_moves_a_loop_as_it_says(way, formulation):
    """In the tree, or, in absolute coordinates, by an equation."""
    driver, start, motion = WAYS[way]
    run = four_bar(driver, start, formulation).simulate(until=1.9, step=0.1)
    position, speed, _ = motion(run["time"])
    assert_near(run["a.angle"], position, 1e-8)
    assert_near(run["a.speed"], speed, 1e-8)


@pytest.mark.parametrize("way", WAYS)
def test_a_coupling_without_offset_starts_from_where_the_driver_is(way):
    driver, start, motion = WAYS[way]
    scene = crank(driver, start).model_dump(exclude_unset=True)
    scene["body"]["b"] = {"mass": 1, "inertia": INERTIA}
    scene["joint"]["b"] = {
        "revolute": {},
        "between": ["ground", "b"],
        "start": {"angle": -0.7},
        "output": ["angle"],
    }
    scene["coupling"] = {"mesh": {"gear": {"ratio": -0.5}, "between": ["turn", "b"]}}
    run = mbdfmi.Scene.model_validate(scene).simulate(until=3, step=0.25)
    position = motion(run["time"])[0]
    assert_near(run["b.angle"], -0.7 - 0.5 * (position - position[0]), 1e-9)


def test_a_strut_without_rest_length_is_slack_at_the_driven_start():
    scene = crank({"ramp": {"time": [1, 2], "position": [0.7, 0.1]}}, None, "prismatic").model_dump(
        exclude_unset=True
    )
    scene["body"]["a"]["marker"] = {"m": {"position": [0.3, 0, 0]}}
    strut = {"spring_damper": {"stiffness": 10}, "between": ["ground", "a.m"], "output": ["force", "length"]}
    scene["force"] = {"strut": strut}
    run = mbdfmi.Scene.model_validate(scene).simulate(until=0.5, step=0.25)
    assert_near(run["strut.length"], np.hypot(0.7, 0.3), 1e-15)
    assert_near(run["strut.force"], 0.0, 1e-14)


def test_parameters_of_drivers():
    """Amplitudes, frequencies and phases, ends of ramps, coefficients can be set before a run."""
    model = compile_scene(crank(*WAYS["harmonics"][:2]))
    changed = {
        "turn.driver.amplitude[2]": 0.0,
        "turn.driver.mean": 1.0,
        "turn.driver.frequency[1]": 0.25,
        "turn.driver.phase[1]": 0.3,
    }
    run = simulate(model, 3, 0.5, parameters=changed)
    assert_near(run["turn.angle"], 1 + 0.3 * np.sin(np.pi / 2 * run["time"] + 0.3), 1e-14)

    model = compile_scene(crank(*WAYS["ramp"][:2], "prismatic"))
    run = simulate(model, 3, 0.5, parameters={"turn.driver.time_end": 1.5, "turn.driver.position_end": 2.2})
    assert_near(run["turn.position"], ramp(run["time"], 0.5, 1.5, 0.2, 2.0)[0], 1e-14)

    model = compile_scene(crank(*WAYS["polynomial"][:2]))
    run = simulate(model, 3, 0.5, parameters={"turn.driver.coefficients[2]": 2.0})
    assert_near(run["turn.angle"], polynomial(run["time"])[0] + 2.2 * run["time"], 1e-13)


def test_degrees_and_turns_a_minute():
    t, rpm = [0, 1, 2], [0, 30, 60]
    run = crank({"speed_table": {"time": t, "speed_rpm": rpm, "interpolation": "linear"}}, None).simulate(
        until=2, step=0.5
    )
    assert_near(run["turn.angle"], np.pi / 2 * run["time"] ** 2, 1e-14)
    run = crank({"ramp": {"time": [0, 1], "position_deg": [0, 90]}}, None).simulate(until=2, step=0.5)
    assert_near(run["turn.angle"], ramp(run["time"], 0, 1, 0, np.pi / 2)[0], 1e-15)
    run = crank({"polynomial": {"coefficients_deg": [90, 0, 10]}}, None).simulate(until=2, step=0.5)
    assert_near(run["turn.angle"], np.radians(90 + 10 * run["time"] ** 2), 1e-15)
    run = crank({"harmonics": {"amplitude_deg": [10], "frequency": [1], "mean_deg": 5}}, None).simulate(
        until=1, step=0.1
    )
    assert_near(run["turn.angle"], np.radians(5 + 10 * np.sin(2 * np.pi * run["time"])), 1e-15)


def test_a_ramp_is_the_table_of_its_ends():
    """Smooth tables go from one rest to another in the same way."""
    t = np.linspace(0, 3, 301)
    p = curve("smooth", [0, 0.5, 2.5, 3], [0.2, 0.2, 1.5, 1.5])
    assert_near(p(t), ramp(t)[0], 1e-14)
    assert_near(p(t, 2), ramp(t)[2], 1e-13)


def test_straight_lines_of_a_position_are_told():
    driver = {"table": {"time": [0, 1, 2], "position": [0, 1, 0], "interpolation": "linear"}}
    run = crank(driver, None, "prismatic").simulate(until=2, step=0.125)
    assert_near(run["turn.position"], 1 - np.abs(run["time"] - 1), 1e-15)
    assert any("joint.turn" in notice and "speed jump" in notice for notice in run.notices)


@pytest.mark.parametrize(
    "driver, start, said",
    [
        ({"hold": True}, {"speed": 1.0}, "the driver says how fast the joint starts"),
        (
            {"ramp": {"time": [0, 1], "position": [0, 1]}},
            {"angle": 1.0},
            "the driver says where the joint starts",
        ),
        ({"ramp": {"time": [1, 1], "position": [0, 1]}}, {}, "must ascend"),
        ({"harmonics": {"amplitude": [1, 2], "frequency": [1]}}, {}, "each needs one of the other"),
        ({"harmonics": {"amplitude": [1], "frequency": [0]}}, {}, "must be greater than 0"),
        ({"polynomial": {"coefficients": [1.0] * 17}}, {}, "at most 16"),
        ({"rampe": {}}, {}, 'Did you mean "ramp"?'),
    ],
)
def test_what_cannot_be_meant_is_refused(driver, start, said):
    joint = {"revolute": {}, "between": ["ground", "a"], "driver": driver} | (
        {"start": start} if start else {}
    )

    with pytest.raises(mbdfmi.SceneError, match=said.replace("?", r"\?")):
        mbdfmi.Scene(name="x", body={"a": {"mass": 1, "inertia": INERTIA}}, joint={"j": joint})
