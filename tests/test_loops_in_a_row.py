"""Loops in a row: bodies are taken apart where that is predicted to be much cheaper, and move as by joint coordinates."""

from math import cos, pi

import numpy as np
import pytest
from scipy.spatial.transform import Rotation

from mbdfmi import Scene
from mbdfmi.compiler import partition
from mbdfmi.compiler.model import compile_scene
from mbdfmi.compiler.topology import spanning_tree
from mbdfmi.run.instance import Instance
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


def seen_from(lift, seed):
    """The same lift in a plane of another direction, all bodies and markers in frames of their own, not at one height."""
    rng = np.random.default_rng(seed)
    turn = {name: Rotation.random(random_state=rng).as_matrix().T for name in ("ground", *lift.body)}
    height = {name: rng.uniform(-0.2, 0.2) for name in lift.body} | {"ground": 0.0}

    def marker(body, position):
        Q = turn[body]
        at = Q @ (np.array(position) - [0, 0, height[body]])
        return {"position": at.tolist(), "axes": {"x": Q[:, 0].tolist(), "z": Q[:, 2].tolist()}}

    def holder(name, body):
        own = {"frame": [0.0, 0.0, 0.0]} | {key: list(m.position) for key, m in body.marker.items()}
        return {"marker": {key: marker(name, position) for key, position in own.items()}}

    body = {}

    for name, given in lift.body.items():
        I = turn[name] @ given.mass_properties()[2] @ turn[name].T
        inertia = [*np.diag(I), I[0, 1], I[0, 2], I[1, 2]]
        com = turn[name] @ np.array([0, 0, -height[name]])
        body[name] = holder(name, given) | {"mass": given.mass, "com": com.tolist(), "inertia": inertia}

    tables = lift.model_dump(exclude_unset=True)
    joint = tables["joint"]

    for given in joint.values():
        given["between"] = [end if "." in end else f"{end}.frame" for end in given["between"]]

    gravity = turn["ground"] @ lift.gravity
    ground = holder("ground", lift.ground)
    return Scene(
        name="seen", gravity=gravity.tolist(), ground=ground, body=body, joint=joint, solver=tables["solver"]
    )


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
    ("scene", "apart"), [(scissor_lift(40), True), (scissor_lift(9), False), (ladder(60), False)]
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


def apart_here(monkeypatch, scene):
    """The model of a scene with its bodies apart."""
    monkeypatch.setattr(partition, "FEW_LOOPS", 2)
    monkeypatch.setattr(partition, "GAIN", 0.0)
    model = compile_scene(scene)
    assert model.formulation == "apart"
    return model


@pytest.mark.parametrize("planar", [True, False])
def test_the_plane_may_lie_anywhere(monkeypatch, planar):
    """Frames of the user's choice, bars beside each other: the same motion, by two rows a pin, or by five."""
    if not planar:
        monkeypatch.setattr(partition, "find_planes", lambda *tree: None)

    solver = {"tolerance": 1e-9, "integrator": "rk853"}
    model = apart_here(monkeypatch, seen_from(scissor_lift(3, **solver), 5))
    assert model.tree.in_plane == planar
    there = simulate(model, 0.04, 0.01)
    here = simulate(compile_scene(scissor_lift(3, **solver, formulation="recursive")), 0.04, 0.01)

    for name in here:
        np.testing.assert_allclose(there[name], here[name], rtol=1e-8, atol=1e-8)

    assert there.notices == []


def test_starts_of_bodies_in_a_plane_are_parameters(monkeypatch):
    """What is written into them is where the lift starts: a run goes on where another ended."""
    model = apart_here(monkeypatch, scissor_lift(3, tolerance=1e-10))
    starts = [v for v in model.of_causality("parameter") if v.name.startswith("up2.") and "_start" in v.name]
    assert [v.name for v in starts] == [
        "up2.position_start[1]", "up2.position_start[2]", "up2.angle_start",
        "up2.velocity_start[1]", "up2.velocity_start[2]", "up2.omega_start",
    ]  # fmt: skip
    assert [v.unit for v in starts] == ["m", "m", "rad", "m/s", "m/s", "rad/s"]

    instance = Instance(model, {"up2.omega_start": 0.3})
    told = [notice for notice in instance.notices if "up2" in notice]
    assert not told, "the loops decide, and nobody gave this in the scene"


@pytest.mark.parametrize("leaves", ["axis", "height", "reaction", "pin of another kind"])
def test_what_leaves_the_plane_is_apart_in_space(leaves):
    scene = scissor_lift(3)
    tables = scene.model_dump(exclude_unset=True)

    if leaves == "axis":
        tables["joint"]["right2"]["revolute"] = {"axis": [0.0, 1e-6, 1.0]}
    elif leaves == "height":
        tables["body"]["up1"]["marker"]["high"]["position"] = [0.5, 0.0, 1e-9]
    elif leaves == "reaction":
        tables["joint"]["left1"]["output"] = ["reaction_force"]
    else:
        tables["joint"]["left1"] = {"spherical": {}, "between": tables["joint"]["left1"]["between"]}

    scene = Scene.model_validate(tables)
    tree = spanning_tree(scene)
    assert partition.find_planes(scene, tree, tree.cuts) is None
