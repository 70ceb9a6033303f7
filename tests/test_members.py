"""Drag on members: closed forms of what falls, moves sideways, turns, is half in the water; current; powers."""

import numpy as np
import pytest
from scenes import assert_near

from mbdfmi import Scene, SceneError
from mbdfmi.compiler.model import compile_scene
from mbdfmi.run.instance import Instance
from mbdfmi.run.simulate import simulate

RHO, G, D = 1025.0, 9.81, 2.0


def pile(start, top=10.0, bottom=-10.0, sea=None, member=None, gravity=0.0, **scene):
    """A body along z between two markers."""
    marker = {"keel": {"position": [0, 0, bottom]}, "deck": {"position": [0, 0, top]}}
    return Scene.model_validate(
        {
            "name": "pile",
            "gravity": [0, 0, -gravity],
            "sea": sea or {},
            "output": ["total_energy", "dissipated_power"],
            "solver": {"tolerance": 1e-11},
            "body": {
                "pile": {"mass": 1e4, "inertia": [1e5, 1e5, 1e4], "marker": marker, "output": ["velocity"]}
            },
            "joint": {"free": {"free": {}, "between": ["ground", "pile"], "start": start}},
            "force": {
                "drag": {
                    "member": {"diameter": D, "drag": 0.9, "axial_drag": 1.1} | (member or {}),
                    "between": ["pile.keel", "pile.deck"],
                    "output": ["force", "power"],
                }
            },
        }
        | scene
    )


def told(scene):
    instance = Instance(compile_scene(scene))
    values = dict(zip([v.name for v in instance.model.of_causality("output")], instance.outputs()))
    return np.array([values[f"drag.force[{k}]"] for k in (1, 2, 3)]), values["drag.power"]


@pytest.mark.parametrize("z, wet", [(-50, 20.0), (0, 10.0), (7, 3.0), (50, 0.0), (-10, 20.0)])
def test_what_is_wet_of_a_pile_that_moves_sideways(z, wet):
    force, power = told(pile({"position": [0, 0, z], "velocity": [3, 4, 0]}))
    assert_near(force, -0.5 * RHO * D * 0.9 * wet * 5 * np.array([3, 4, 0]), 1e-8)
    assert_near(power, -0.5 * RHO * D * 0.9 * wet * 125, 1e-7)


def test_a_pile_along_its_axis_is_held_by_its_wet_discs():
    for z, discs in ((-50, 2), (0, 1), (50, 0)):
        force, _ = told(pile({"position": [0, 0, z], "velocity": [0, 0, -2]}))
        assert_near(force, [0, 0, discs * 0.5 * RHO * np.pi * D**2 / 4 * 1.1 * 4], 1e-8)


def test_drag_of_turning_is_the_integral_of_its_square():
    """About one end, at 0: int (w s)^2 ds, which two points in each section have to 1 / (3 n^2) of a third; power int (w s)^3 ds."""
    start = {"position": [0, 0, -50], "omega": [0.5, 0, 0]}
    force, power = told(pile(start, top=20.0, bottom=0.0, member={"sections": 40}))
    assert_near(force, [0, 0.5 * RHO * D * 0.9 * 0.25 * 20**3 / 3, 0], 1e-6)
    assert_near(power, -0.5 * RHO * D * 0.9 * 0.125 * 20**4 / 4, 1e-6 * abs(power))


def test_a_current_drags_and_falls_towards_the_bed():
    sea = {"depth": 100, "current": {"velocity": [2, 0, 0], "exponent": 0.5}}
    force, power = told(pile({"position": [0, 0, -40]}, sea=sea, member={"sections": 50}))
    wanted = 0.5 * RHO * D * 0.9 * 4 * ((0.7**2 - 0.5**2) / 2 * 100)
    assert_near(force, [wanted, 0, 0], 1e-6 * wanted)
    assert power == 0.0


def test_a_pile_that_falls_comes_to_its_terminal_velocity():
    """m v' = m g - c v^2: v = v_t tanh(g t / v_t)."""
    run = simulate(compile_scene(pile({"position": [0, 0, -50]}, gravity=G)), 4.0, 0.1)
    c = 2 * 0.5 * RHO * np.pi * D**2 / 4 * 1.1
    v = np.sqrt(1e4 * G / c)
    assert_near(run["pile.velocity"][:, 2], -v * np.tanh(G * run["time"] / v), 1e-7)
    weights = np.ones(41)
    weights[1:-1:2], weights[2:-1:2] = 4, 2
    lost = weights @ run["dissipated_power"] * 0.1 / 3
    assert_near(lost, run["total_energy"][0] - run["total_energy"][-1], 1e-4 * lost)


def test_a_member_is_of_one_body_and_a_current_needs_a_bed_to_fall_to():
    data = pile({}).model_dump(exclude_unset=True)
    data["force"]["drag"]["between"] = ["ground", "pile.deck"]

    with pytest.raises(SceneError, match=r'a member is of one body, found "ground" and "pile"'):
        Scene.model_validate(data)

    with pytest.raises(SceneError, match=r"\[sea\].*needs a depth"):
        pile({}, sea={"current": {"velocity": [1, 0, 0], "exponent": 0.1}})


def test_a_member_without_length_is_told():
    with pytest.raises(SceneError, match=r"\[force.drag\] between: both ends are at one place"):
        compile_scene(pile({}, top=1.0, bottom=1.0))
