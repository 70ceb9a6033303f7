"""Loops behind commanded joints, at the communication points a master would choose."""

import numpy as np
import pytest
from numpy.testing import assert_allclose
from test_commands import POINT, Run

import mbdfmi


@pytest.mark.parametrize("formulation", ["recursive", "embedding", "augmented"])
def test_a_commanded_joint_in_a_loop(formulation):
    """A slider-crank whose crank, or whose rail, is commanded: closed form at all communication points."""
    r, l = 0.2, 0.6

    def scene(crank, rail):
        return mbdfmi.Scene(
            name="crank",
            gravity=[0, 0, 0],
            solver={"formulation": formulation},
            body={
                "crank": {"mass": 1, "inertia": [0.01] * 3, "marker": {"e": {"position": [r, 0, 0]}}},
                "rod": {"mass": 1, "inertia": [0.01] * 3, "marker": {"e": {"position": [l, 0, 0]}}},
                "shoe": {"mass": 1, "inertia": [0.01] * 3},
            },
            joint={
                "a": {"revolute": {}, "between": ["ground", "crank"], "output": ["angle", "speed"], **crank},
                "b": {"revolute": {}, "between": ["crank.e", "rod"]},
                "c": {"revolute": {}, "between": ["rod.e", "shoe"]},
                "rail": {
                    "prismatic": {"axis": "x"},
                    "between": ["ground", "shoe"],
                    "output": ["position", "speed"],
                    **rail,
                },
            },
        )

    def place(angle):
        return r * np.cos(angle) + np.sqrt(l**2 - (r * np.sin(angle)) ** 2)

    law = [np.polynomial.Polynomial([0.5, 0.8, -0.3]).deriv(k) for k in range(3)]
    angle = np.polynomial.Polynomial([0.5, 0.8, -0.3])
    run = Run(scene({"driver": {"input": True}}, {}), **{"a.angle_command": 0.5, "a.speed_command": 0.8})

    for k in range(20):
        for order in (0, 1):
            run.set(
                {
                    f"a.{name}_command": law[i](0.05 * (k + order))
                    for i, name in enumerate(("angle", "speed", "acceleration"))
                }
            )

            if order == 0:
                run.step(0.05)

        assert run.get("rail.position") == pytest.approx(place(angle(0.05 * k + 0.05)), abs=1e-8)

    # the other way round: by position alone
    course = place(angle(np.linspace(0, 1, 21)))
    run = Run(
        scene({"start": {"angle": 0.5}}, {"driver": {"input": ["position"]}}),
        **{"rail.position_command": course[0]},
    )

    for k in range(20):
        run.set({"rail.position_command": course[k]})
        run.step(0.05)
        run.set({"rail.position_command": course[k + 1]})

        if k > 5:
            assert run.get("rail.speed") == pytest.approx((course[k + 1] - course[k]) / 0.05, abs=0.05)


@pytest.mark.parametrize(
    "solver",
    [{"integrator": name, "tolerance": 1e-10} for name in ("rk54", "rk853", "radau", "auto")]
    + [{"integrator": "gauss", "step": 0.01}],
    ids=lambda solver: solver["integrator"],
)
@pytest.mark.parametrize("by", ["speed", "derivative", "positions"])
def test_a_speed_that_jumps_pulls_a_loop_along(solver, by):
    """A cart at the end of a rod is suddenly at speed: a particle at the other end is knocked along the rod, then goes around it.

    Whatever tells the speed (a command, the position's derivative, the second position), when nothing came before that
    the motion could be led on from. Closed form, for every stepper.
    """
    length, angle, speed, H = 0.8, 0.7, 1.5, 0.1
    scene = mbdfmi.Scene(
        name="towed",
        gravity=[0, 0, 0],
        solver=solver,
        body={"cart": POINT, "p": POINT | {"output": ["position"]}},
        joint={
            "j": {
                "prismatic": {"axis": "x"},
                "between": ["ground", "cart"],
                "driver": {"input": ["position", "speed"] if by == "speed" else ["position"]},
            },
            "t": {
                "translation": {},
                "between": ["ground", "p"],
                "start": {"position": [length * np.cos(angle), length * np.sin(angle), 0.0]},
            },
            "rod": {"distance": {}, "between": ["cart", "p"]},
        },
    )
    run, at = Run(scene), length * np.array([np.cos(angle), np.sin(angle)])

    for k in range(6):
        run.set({"j.position_command": speed * H * k})

        if by == "speed":
            run.set({"j.speed_command": speed})
        elif by == "derivative":
            run.set({"j.position_command": speed}, 1)

        run.step(H)
        begun = H if by == "positions" else 0.0
        t = H * (k + 1) - begun

        if t > 0.0:
            # where the cart jumped as well, the particle is drawn along the rod
            angle_then = np.arctan2(at[1], at[0] - speed * begun)
            turned = angle_then + speed * np.sin(angle_then) / length * t
            place = np.array([np.cos(turned), np.sin(turned), 0.0]) * length + [speed * H * (k + 1), 0, 0]
            assert_allclose(run.get("p.position"), place, atol=2e-8)


@pytest.mark.parametrize("formulation", ["recursive", "embedding", "augmented"])
@pytest.mark.parametrize("told", [["angle"], ["angle", "speed"]])
def test_loops_are_where_the_commands_are(formulation, told):
    """At every communication point, also after a jump, outputs tell a closed four-bar at the commanded angle.

    The run goes on from where it was: reading changes nothing.
    """

    def bar(length):
        return {
            "mass": 1.0,
            "inertia": [0.1] * 3,
            "marker": {"end": {"position": [length, 0, 0], "output": ["position", "velocity"]}},
        }

    hinge = {"revolute": {"axis": "y"}}
    scene = mbdfmi.Scene(
        name="bars",
        solver={"formulation": formulation, "tolerance": 1e-10},
        output=["constraint_gap", "constraint_rate"],
        ground={"marker": {"far": {"position": [2, 0, 0]}}},
        body={"a": bar(0.5), "b": bar(2.0), "c": bar(1.0)},
        joint={
            "crank": hinge
            | {"between": ["ground", "a"], "output": ["angle", "speed"], "driver": {"input": told}},
            "knee": hinge | {"between": ["a.end", "b"]},
            "elbow": hinge | {"between": ["b.end", "c"]},
            "rocker": hinge | {"between": ["c.end", "ground.far"], "start": {"angle_deg": -60}},
        },
    )
    run, quiet = Run(scene), Run(scene)

    for angle in (0.0, 0.02, 0.05, 0.06, 0.2, 0.21, 0.21):
        commands = {"crank.angle_command": angle} | ({"crank.speed_command": 0.3} if len(told) > 1 else {})
        run.set(commands), quiet.set(commands)
        assert run.get("crank.angle") == pytest.approx(angle, abs=1e-14)
        assert run.get("constraint_gap") < 1e-12 and run.get("constraint_rate") < 1e-11
        knee, elbow = run.get("a.end.position"), run.get("b.end.position")
        np.testing.assert_allclose(knee, [0.5 * np.cos(angle), 0, -0.5 * np.sin(angle)], atol=1e-14)
        assert np.linalg.norm(elbow - knee) == pytest.approx(2.0, abs=1e-12)
        assert np.linalg.norm(elbow - [2, 0, 0]) == pytest.approx(1.0, abs=1e-12)
        assert run.get("b.end.velocity") @ (elbow - [2, 0, 0]) == pytest.approx(0.0, abs=1e-10)
        run.step(0.1), quiet.step(0.1)
        np.testing.assert_array_equal(run.instance.d.x, quiet.instance.d.x)
