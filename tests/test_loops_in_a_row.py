"""Loops in a row: bodies are taken apart where that is predicted to be much cheaper, and move as by joint coordinates."""

from math import cos, pi

import numpy as np
import pytest

from mbdfmi import Scene
from mbdfmi.compiler import partition
from mbdfmi.compiler.model import compile_scene
from mbdfmi.compiler.topology import spanning_tree
from mbdfmi.run.simulate import simulate

UP, DOWN = 0.5, pi - 0.5


def scissor_lift(cells, wrong=0.0, **solver):
    """Two bars a cell, crossed in the middle, on a pin and a sprung shoe; one start value is off by `wrong` rad."""
    bar = {"mass": 1, "inertia": [0.001, 1 / 12, 1 / 12]}
    bar["marker"] = {"low": {"position": [-0.5, 0, 0]}, "high": {"position": [0.5, 0, 0]}}
    body = {"shoe": {"mass": 0.1, "inertia": [0.001] * 3}}
    slide = {"prismatic": {"axis": "x"}, "between": ["ground", "shoe"], "output": ["position", "speed"]}
    joint = {"slide": slide | {"start": {"position": cos(UP)}, "spring": {"stiffness": 3000.0 * cells**2}}}

    for k in range(cells):
        up, down = f"up{k}", f"down{k}"
        body |= {up: bar, down: bar}
        left, right = (f"down{k - 1}.high", f"up{k - 1}.high") if k else ("ground", "shoe")
        angles = (UP, DOWN) if k == 0 else (UP - DOWN, DOWN - UP)
        joint[f"middle{k}"] = {"revolute": {}, "between": [up, down], "output": ["angle"]}
        joint[f"left{k}"] = {"revolute": {}, "between": [left, f"{up}.low"], "start": {"angle": angles[0]}}
        joint[f"right{k}"] = {
            "revolute": {},
            "between": [right, f"{down}.low"],
            "start": {"angle": angles[1]},
        }

    joint[f"left{cells - 1}"]["start"]["angle"] += wrong
    return Scene(name="lift", gravity=[0, -9.81, 0], body=body, joint=joint, solver=solver)


def ladder(cells):
    """Parallelogram four-bars side by side, each with its own pins on the ground."""
    bar = {"mass": 1.0, "inertia": [0.001, 0.1, 0.1], "marker": {"end": {"position": [1, 0, 0]}}}
    pins = {f"p{k}": {"position": [float(k), 0, 0]} for k in range(cells + 1)}
    body = {f"crank{k}": bar for k in range(cells + 1)} | {f"rod{k}": bar for k in range(cells)}
    joint = {f"pin{k}": {"revolute": {}, "between": [f"ground.p{k}", f"crank{k}"]} for k in range(cells + 1)}

    for k in range(cells):
        joint[f"a{k}"] = {"revolute": {}, "between": [f"crank{k}.end", f"rod{k}"]}
        joint[f"b{k}"] = {"revolute": {}, "between": [f"rod{k}.end", f"crank{k + 1}.end"]}

    return Scene(name="ladder", ground={"marker": pins}, body=body, joint=joint)


def test_predicted_cost_grows_as_the_lift_does():
    cost = {}

    for cells in (20, 40, 80):
        scene = scissor_lift(cells)
        tree = spanning_tree(scene)
        cost[cells] = [partition.predicted_cost(scene, t) for t in (tree, partition._parted(scene, tree))]

    whole, apart = zip(*cost.values())
    assert whole[2] > 5 * whole[1] > 25 * whole[0]
    assert apart[2] < 2.1 * apart[1] < 4.4 * apart[0]


@pytest.mark.parametrize(
    ("scene", "apart"), [(scissor_lift(40), True), (scissor_lift(16), False), (ladder(60), False)]
)
def test_bodies_are_taken_apart_where_loops_stand_in_a_row(scene, apart):
    assert bool(partition.parted_tree(scene, spanning_tree(scene))) == apart


def test_bodies_that_cannot_move_by_themselves_are_not_taken_apart():
    scene = scissor_lift(40)
    scene.body["up7"].inertia = [0, 0, 0]
    assert partition.parted_tree(scene, spanning_tree(scene)) is None


@pytest.mark.parametrize("wrong", [0.0, 0.02])
def test_a_lift_apart_moves_as_by_joint_coordinates(monkeypatch, wrong):
    """Also from where the given start does not close the loops: the same start is taken, and told."""
    monkeypatch.setattr(partition, "FEW_LOOPS", 2)
    monkeypatch.setattr(partition, "GAIN", 0.0)
    apart = compile_scene(scissor_lift(3, wrong))
    joined = compile_scene(scissor_lift(3, wrong, formulation="recursive"))
    assert (apart.formulation, joined.formulation) == ("apart", "recursive")
    assert [v.name for v in apart.of_causality("output")] == [v.name for v in joined.of_causality("output")]
    there, here = simulate(apart, 0.02, 0.002), simulate(joined, 0.02, 0.002)

    for variable in joined.of_causality("output"):
        np.testing.assert_allclose(there[variable.name], here[variable.name], rtol=1e-7, atol=1e-7)

    assert there.notices == here.notices
    assert bool(there.notices) == (wrong != 0.0)
