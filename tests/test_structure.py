"""Degrees of freedom by rank, redundant equations and undetermined reactions of mechanisms for
which they are known.
"""

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from loop_scenes import random_loops

from mbdfmi import Scene
from mbdfmi.analysis.mechanism import Mechanism

BOX = {"mass": 1.0, "inertia": [1, 1, 1]}


def bar(length):
    """A uniform bar along its x axis, with a marker at its end."""
    return {
        "mass": 1.0,
        "com": [length / 2, 0, 0],
        "inertia": [0.001 * length**2, length**2 / 12, length**2 / 12],
        "marker": {"end": {"position": [length, 0, 0]}},
    }


def four_bar(lengths=(0.5, 2.0, 1.5), span=2.0, angle=1.0, last=("revolute",), size=1.0, **joint_a):
    """Crank, coupler, rocker in the x-y plane on revolutes A, B, C and a last joint D."""
    names = ("crank", "coupler", "rocker")
    return Scene(
        name="four bar",
        gravity=[0, -9.81, 0],
        ground={"marker": {"right": {"position": [size * span, 0, 0]}}},
        body={name: bar(size * length) for name, length in zip(names, lengths)},
        joint={
            "A": {"revolute": {}, "between": ["ground", "crank"], "start": {"angle": angle}} | joint_a,
            "B": {"revolute": {}, "between": ["crank.end", "coupler"]},
            "C": {"revolute": {}, "between": ["ground.right", "rocker"], "start": {"angle": angle * 1.7}},
            "D": {last[0]: dict(last[1:]), "between": ["coupler.end", "rocker.end"]},
        },
    )


def owners(rows):
    return [row.owner for row in rows]


@pytest.mark.parametrize("size", [1e-3, 1.0, 1e3])
def test_planar_four_bar(size):
    """Grübler in space counts 6 (4 - 1) - 4 5 = -2 freedoms; three of the 20 equations repeat."""
    found = four_bar(size=size).structure()

    assert (found.coordinates, found.equations, found.rank, found.freedom) == (3, 5, 2, 1)
    assert found.freedom_at_start == 1
    assert found.closing == ["D"]
    assert found.driveable == ["A", "B", "C", "D"]
    assert owners(found.redundant) == ["D"] * 3
    assert found.redundant[0].keeps == "position along z"
    assert all(row.keeps.startswith("rotation about") for row in found.redundant[1:])
    assert {r.owner: r.what for r in found.undetermined} == dict.fromkeys(
        "ABCD", "force along z, moment about x and y"
    )


def test_four_bar_with_a_spherical_joint_has_one_redundant_equation():
    found = four_bar(last=("spherical",)).structure()

    assert found.freedom == 1
    assert [(row.owner, row.keeps) for row in found.redundant] == [("D", "position along z")]
    assert next(r.what for r in found.undetermined if r.owner == "D") == "force along z"


def test_four_bar_with_spherical_and_cylindrical_joints_is_determined():
    """Of an RSCR's 18 equations none repeats: 6 3 - 5 - 5 - 4 - 3 = 1."""
    scene = four_bar(last=("spherical",)).model_dump(exclude_unset=True)
    scene["joint"]["C"] = {"cylindrical": {}, "between": ["ground.right", "rocker"]}
    found = Scene(**scene).structure()

    assert found.freedom == 1
    assert found.redundant == [] and found.undetermined == []


def test_flat_parallelogram_is_singular_for_a_moment():
    """Stretched out it can leave as a parallelogram or an antiparallelogram: two freedoms there,
    one elsewhere.
    """
    found = four_bar((1, 2, 1), angle=0.0).structure()
    assert (found.freedom, found.freedom_at_start) == (1, 2)
    assert len(found.redundant) == 3

    found = four_bar((1, 2, 1), angle=0.7).structure()
    assert (found.freedom, found.freedom_at_start) == (1, 1)


def test_bricard():
    """Threefold symmetric, six revolutes: one of the loop's equations repeats."""
    spots = [[0, 0, 0], [1, 0, 0], [1, -1, 0], [1, -1, 1], [0, -1, 1], [0, 0, 1]]
    axes = ["y", "z", "x", "y", "z", "x"]
    body = {f"rod{k}": {"mass": 1, "inertia": [0.1] * 3} for k in range(1, 6)}
    ground, joint = {}, {}

    for k, (spot, axis) in enumerate(zip(spots, axes)):
        ends = [f"rod{k}" if k else "ground", f"rod{k + 1}" if k < 5 else "ground"]

        for end in ends:
            (ground if end == "ground" else body[end].setdefault("marker", {}))[f"j{k}"] = {"position": spot}

        joint[f"hinge {k}"] = {"revolute": {"axis": axis}, "between": [f"{end}.j{k}" for end in ends]}

    found = Scene(name="bricard", ground={"marker": ground}, body=body, joint=joint).structure()

    assert (found.equations, found.rank, found.freedom) == (5, 4, 1)
    assert len(found.redundant) == 1
    assert sorted(owners(found.undetermined)) == [f"hinge {k}" for k in range(6)]


def test_free_body():
    found = Scene(
        name="free", body={"b": BOX}, joint={"j": {"free": {}, "between": ["ground", "b"]}}
    ).structure()

    assert found.freedom == found.coordinates == 6
    assert not (found.redundant or found.undetermined or found.driveable or found.closing)


def test_two_fixed_joints_side_by_side():
    twice = {name: {"fixed": {}, "between": ["ground", "b"]} for name in ("left", "right")}
    found = Scene(name="held twice", body={"b": BOX}, joint=twice).structure()

    assert found.freedom == 0
    assert owners(found.redundant) == ["right"] * 6
    assert [(r.owner, r.what) for r in found.undetermined] == [
        ("left", "force, moment"),
        ("right", "force, moment"),
    ]


def test_a_door_on_two_hinges():
    """Both bear the weight, nobody knows which how much."""
    top = {"marker": {"top": {"position": [0, 0, 1]}}}
    joint = {
        "lower": {"revolute": {}, "between": ["ground", "door"]},
        "upper": {"revolute": {}, "between": ["ground.top", "door.top"]},
    }
    found = Scene(name="door", ground=top, body={"door": BOX | top}, joint=joint).structure()

    assert found.freedom == 1 and found.driveable == ["lower", "upper"]
    assert [r.what for r in found.undetermined] == ["force, moment about x and y"] * 2


@pytest.mark.parametrize(
    "kind, rank, redundant",
    [("rolling_sphere", 3, 0), ("rolling_disk", 3, 0), ("knife_edge", 1, 0), ("point_on_plane", 1, 0)],
)
def test_constraints_of_a_free_body(kind, rank, redundant):
    options = {"radius": 1.0} if kind.startswith("rolling") else {}
    joint = {
        "free": {
            "free": {},
            "between": ["ground", "b"],
            "start": {"position": [0, 0, 1], "zyx_deg": [0, 0, 80]},
        },
        "on": {kind: options, "between": ["ground", "b"]},
    }

    if kind == "point_on_plane":
        joint["free"]["start"]["position"] = [0, 0, 0]

    found = Scene(name="on", body={"b": BOX}, joint=joint).structure()
    assert (found.rank, found.freedom, len(found.redundant)) == (rank, 6 - rank, redundant)


def test_drives_and_couplings_take_freedoms():
    wheel = {"mass": 1, "inertia": [0.1] * 3}
    joint = {name: {"revolute": {}, "between": ["ground", name]} for name in ("a", "b")}
    gear = {"mesh": {"gear": {"ratio": -2}, "between": ["a", "b"]}}
    scene = {"name": "gears", "body": {"a": wheel, "b": wheel}, "joint": joint, "coupling": gear}
    assert Scene(**scene).structure().freedom == 1

    joint["a"]["driver"] = {"constant_speed": 1}
    found = Scene(**scene).structure()
    assert found.freedom == 0 and found.driven == ["a"] and found.driveable == []


def test_two_motors_on_one_door_fight_each_other():
    top = {"marker": {"top": {"position": [0, 0, 1]}}}
    motor = {"revolute": {}, "driver": {"constant_speed": 0.1}}
    joint = {
        "lower": motor | {"between": ["ground", "door"]},
        "upper": motor | {"between": ["ground.top", "door.top"]},
    }
    found = Scene(name="door", ground=top, body={"door": BOX | top}, joint=joint).structure()

    assert found.freedom == 0
    assert all(r.what.endswith("driving effort") for r in found.undetermined) and len(found.undetermined) == 2
    assert found.redundant[-1].keeps == "prescribed motion"


@settings(max_examples=8, deadline=None)
@given(st.integers(0, 2**32 - 1))
def test_freedom_does_not_depend_on_where_things_are_or_which_joint_is_cut(seed):
    """A spatial loop of n revolutes in general position has n - 6 freedoms."""
    rng = np.random.default_rng(seed)
    n = int(rng.integers(7, 10))
    body, joint, ground = {}, {}, {}
    spots, axes = rng.normal(size=(n, 3)), rng.normal(size=(n, 3))

    for k in range(n):
        ends = [f"b{k}" if k else "ground", f"b{k + 1}" if k < n - 1 else "ground"]

        for end in ends:
            markers = (
                ground
                if end == "ground"
                else body.setdefault(end, {"mass": 1, "inertia": [1, 1, 1], "marker": {}})["marker"]
            )
            markers[f"j{k}"] = {"position": spots[k].tolist()}

        joint[f"j{k}"] = {"revolute": {"axis": axes[k].tolist()}, "between": [f"{end}.j{k}" for end in ends]}

    names = rng.permutation(list(joint)).tolist()
    found = Scene(
        name="loop", ground={"marker": ground}, body=body, joint={name: joint[name] for name in names}
    ).structure()

    assert found.freedom == n - 6
    assert found.redundant == [] and found.undetermined == []


@pytest.mark.parametrize(
    "loops", [["revolute"], ["screw", "spherical"], ["cylindrical", "distance"], ["universal", "prismatic"]]
)
def test_reactions_are_undetermined_where_absolute_coordinates_find_self_stress(loops):
    """In absolute coordinates all joints are rows: the left null space of their Jacobian is the self-stress."""
    scene = Scene.model_validate(random_loops(3, loops, freedoms=-2))
    found = scene.structure()
    solver = scene.solver.model_copy(update={"formulation": "augmented"})
    parted = Mechanism(scene.model_copy(update={"solver": solver}))
    owners_of = np.array([parted.owner(row) for row in range(parted.m.n_row)])
    touched, count = set(), 0

    for rows, stress in parted.generic().self_stress:
        size = np.abs(stress / stress.max(axis=0)).max(axis=1)
        touched |= set(owners_of[rows[size > 1e-5]])
        count += stress.shape[1]

    assert count == found.equations - found.rank
    assert {reaction.owner for reaction in found.undetermined} == touched


def test_a_row_of_loops_has_three_equations_too_many_a_loop():
    """A planar ladder of n cells: each of its loops repeats three equations, each of its hinges bears what no one knows."""
    n = 12
    body, joint = {}, {}

    for k in range(n):
        up, down = f"up{k}", f"down{k}"
        markers = {"low": {"position": [-0.5, 0, 0]}, "high": {"position": [0.5, 0, 0]}}
        body |= {bar: BOX | {"marker": markers} for bar in (up, down)}
        joint[f"middle{k}"] = {"revolute": {}, "between": [up, down]}
        left, right = (f"down{k - 1}.high", f"up{k - 1}.high") if k else ("ground", "shoe")
        angles = (1.0, np.pi - 1.0) if k == 0 else (2.0 - np.pi, np.pi - 2.0)
        joint[f"left{k}"] = {"revolute": {}, "between": [left, f"{up}.low"], "start": {"angle": angles[0]}}
        joint[f"right{k}"] = {
            "revolute": {},
            "between": [right, f"{down}.low"],
            "start": {"angle": angles[1]},
        }

    body["shoe"] = BOX
    joint["slide"] = {
        "prismatic": {"axis": "x"},
        "between": ["ground", "shoe"],
        "start": {"position": np.cos(1.0)},
    }
    found = Scene(name="lift", body=body, joint=joint).structure()
    assert (found.freedom, found.equations - found.rank) == (1, 3 * n)
    assert {reaction.owner for reaction in found.undetermined} == set(joint)
