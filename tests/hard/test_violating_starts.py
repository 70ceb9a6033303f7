"""Starts that violate the constraints: far from assembled, impossible, with velocities that do not fit.

Criterion: assembled, with gaps and rates of rounding, and nothing moved that is in place; or told which joint
cannot close. Velocities become the nearest ones in kinetic energy, as numpy finds them.
"""

import numpy as np
import pytest
from hard import FORMULATIONS, start, stopped_in_good_order

from mbdfmi.run.instance import SimulationError

formulations = pytest.mark.parametrize("formulation", FORMULATIONS)
OUTPUTS = ["constraint_gap", "constraint_rate", "total_energy", "kinetic_energy"]


def bar(length):
    J = length**3 / 12
    marker = {"end": {"position": [length, 0, 0], "output": ["position", "velocity"]}}
    inertia = [J * 1e-2, J, J]
    return {
        "mass": length,
        "com": [length / 2, 0, 0],
        "inertia": inertia,
        "marker": marker,
        "output": ["omega"],
    }


def four_bar(formulation, angles, speeds=(0, 0, 0), coupler=3.0, rocker=2.5):
    """A crank of 1 m, feet 3 m apart. Angles of crank, coupler and rocker against the ground."""
    a, b, c = angles
    u, v, w = speeds
    return {
        "name": "four bar",
        "gravity": [0, -9.81, 0],
        "solver": {"formulation": formulation},
        "ground": {"marker": {"foot": {"position": [3, 0, 0]}}},
        "body": {"crank": bar(1.0), "coupler": bar(coupler), "rocker": bar(rocker)},
        "joint": {
            "crank": {"revolute": {}, "between": ["ground", "crank"], "start": {"angle": a, "speed": u}},
            "coupler": {
                "revolute": {},
                "between": ["crank.end", "coupler"],
                "start": {"angle": b - a, "speed": v - u},
            },
            "rocker": {
                "revolute": {},
                "between": ["ground.foot", "rocker"],
                "start": {"angle": c, "speed": w},
            },
            "pin": {"revolute": {}, "between": ["coupler.end", "rocker.end"]},
        },
        "output": OUTPUTS,
    }


def by_name(instance):
    """Outputs by name."""
    return dict(zip([v.name for v in instance.model.of_causality("output")], instance.outputs().tolist()))


def closed(a, coupler=3.0, rocker=2.5):
    """Angles of coupler and rocker to a crank angle, the rocker's end above."""
    x, y = 3 - np.cos(a), -np.sin(a)
    far = np.hypot(x, y)
    at = np.arctan2(y, x)
    inner = np.arccos((coupler**2 + far**2 - rocker**2) / (2 * coupler * far))
    tip = np.array([np.cos(a), np.sin(a)]) + coupler * np.array([np.cos(at + inner), np.sin(at + inner)])
    return at + inner, np.arctan2(tip[1], tip[0] - 3)


@formulations
def test_starts_far_off_are_assembled_or_told(formulation):
    """150 of any angles: all close, or the joint is named; what closes can run."""
    rng = np.random.default_rng(8)
    assembled = 0

    for _ in range(150):
        scene = four_bar(formulation, rng.uniform(-np.pi, np.pi, 3))

        try:
            instance = start(scene)
        except SimulationError as why:
            assert "cannot be closed at" in str(why)
            assert why.time == 0
            continue

        y = by_name(instance)
        assert y["constraint_gap"] < 1e-12
        assert y["constraint_rate"] < 1e-12
        before = y["total_energy"]
        instance.step(0.1)
        y = by_name(instance)
        assert y["constraint_gap"] < 1e-11
        assert y["total_energy"] == pytest.approx(before, abs=1e-4)
        assembled += 1

    assert assembled > 140


@formulations
def test_a_start_that_fits_stays(formulation):
    rng = np.random.default_rng(9)

    for a in rng.uniform(-np.pi, np.pi, 20):
        b, c = closed(a)
        y = by_name(start(four_bar(formulation, (a, b, c))))
        assert [y["crank.end.position[1]"], y["crank.end.position[2]"]] == pytest.approx(
            [np.cos(a), np.sin(a)], abs=1e-13
        )
        tip = [3 + 2.5 * np.cos(c), 2.5 * np.sin(c)]
        assert [y["rocker.end.position[1]"], y["rocker.end.position[2]"]] == pytest.approx(tip, abs=1e-13)


@formulations
@pytest.mark.parametrize("coupler", [1e-3, 0.3, 6.51, 100.0, 1e6])
def test_lengths_that_cannot_close_are_told(formulation, coupler):
    """The crank's end is 2 to 4 m from the rocker's foot. In absolute coordinates each joint of the loop may
    be the one.
    """
    rng = np.random.default_rng(10)
    named = "pin|crank|coupler|rocker" if formulation == "augmented" else "pin"

    for _ in range(10):
        scene = four_bar(
            formulation, rng.uniform(-np.pi, np.pi, 3), coupler=coupler, rocker=1.5 if coupler < 1 else 2.5
        )

        with pytest.raises(SimulationError, match=f"loop cannot be closed at ({named})") as caught:
            start(scene)

        assert caught.value.time == 0


@formulations
@pytest.mark.parametrize("size", [1.0, 1e6])
def test_velocities_that_do_not_fit_become_the_nearest_in_energy(formulation, size):
    """v = v0 - M^-1 J^T (J M^-1 J^T)^-1 J v0 in absolute angles, the two rows of the pin being J."""
    rng = np.random.default_rng(11)

    for _ in range(10):
        a = rng.uniform(-np.pi, np.pi)
        b, c = closed(a)
        v0 = size * rng.normal(size=3)
        y = by_name(start(four_bar(formulation, (a, b, c), v0)))

        # T of crank and coupler is coupled through the crank's end; the rocker is alone
        L = np.array([1.0, 3.0, 2.5])
        M = np.diag([1 / 3 + 3.0, 3.0**3 / 3, 2.5**3 / 3])
        M[0, 1] = M[1, 0] = 3.0 * 1.0 * 1.5 * np.cos(a - b)
        s, co = L * np.sin([a, b, c]), L * np.cos([a, b, c])
        J = np.array([[-s[0], -s[1], s[2]], [co[0], co[1], -co[2]]])
        W = np.linalg.solve(M, J.T)
        v = v0 - W @ np.linalg.solve(J @ W, J @ v0)
        found = [y[f"{name}.omega[3]"] for name in ("crank", "coupler", "rocker")]
        assert found == pytest.approx(v, abs=1e-11 * size)
        assert y["kinetic_energy"] == pytest.approx(0.5 * v @ M @ v, rel=1e-10)
        assert y["constraint_rate"] < 1e-12 * size


@formulations
def test_what_is_open_by_kilometres(formulation):
    """A free body, joined by a ball joint to a place 1e5 m away, and turned."""
    scene = {
        "name": "far",
        "solver": {"formulation": formulation},
        "ground": {"marker": {"site": {"position": [1e5, -2e5, 3e4]}}},
        "body": {
            "part": {"mass": 2.0, "inertia": [1, 2, 2.5], "marker": {"eye": {"position": [0.3, 0.2, -0.1]}}}
        },
        "joint": {
            "free": {"free": {}, "between": ["ground", "part"], "start": {"zyx_deg": [20, 100, -60]}},
            "ball": {"spherical": {}, "between": ["ground.site", "part.eye"]},
        },
        "output": OUTPUTS,
    }

    try:
        instance = start(scene)
    except SimulationError as why:
        assert "ball" in str(why)
        return

    # 1e5 m are known to 1e-11 m
    assert by_name(instance)["constraint_gap"] < 1e-9
    instance.step(0.5)
    assert by_name(instance)["constraint_gap"] < 1e-9


@formulations
def test_two_joints_that_contradict_each_other_are_told(formulation):
    """A bar pinned at both ends, to feet that are further apart than it is long."""
    scene = {
        "name": "contradiction",
        "solver": {"formulation": formulation},
        "ground": {"marker": {"foot": {"position": [1.5, 0, 0]}}},
        "body": {"bar": bar(1.0)},
        "joint": {
            "left": {"revolute": {}, "between": ["ground", "bar"]},
            "right": {"revolute": {}, "between": ["ground.foot", "bar.end"]},
        },
    }

    with pytest.raises(SimulationError, match="cannot be closed at (right|left)") as caught:
        start(scene)

    assert caught.value.time == 0


def test_a_drive_beyond_the_reach_stops_in_time():
    """The crank is driven to where the rocker cannot follow: told when, and which joint."""
    b, c = closed(0.5, coupler=2.0, rocker=1.2)
    scene = four_bar("auto", (0.5, b, c), coupler=2.0, rocker=1.2)
    scene["joint"]["crank"] |= {"driver": {"constant_speed": 1.0}, "start": {"angle": 0.5}}

    # all along a line when the crank's end is 3.2 m from the foot
    furthest = np.arccos((1 + 9 - 3.2**2) / 6)

    for solver in ({"tolerance": 1e-8}, {"integrator": "rk853"}, {"integrator": "rk4", "step": 1e-3}):
        instance = start(scene, solver)

        with pytest.raises(SimulationError) as caught:
            for _ in range(400):
                instance.step(0.01)
                instance.outputs()

        stopped_in_good_order(instance, caught.value)
        assert caught.value.time == pytest.approx(furthest - 0.5, abs=0.02)
