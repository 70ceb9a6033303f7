"""Which start values are kept, what follows from them, and what is told of those that cannot be kept."""

import itertools
import re
from math import cos, pi, radians, sin

import numpy as np
import pytest
from fmu_host import OK, WARNING, Library
from fmu_host import Instance as Slave

from mbdfmi import Scene, SceneError
from mbdfmi.cli import main
from mbdfmi.compiler.model import compile_scene
from mbdfmi.export import export_fmu
from mbdfmi.run.instance import Instance, SimulationError
from mbdfmi.scene import read_scene

FORMULATIONS = ("recursive", "embedding", "augmented")
formulations = pytest.mark.parametrize("formulation", FORMULATIONS)
BLOCK = {"mass": 1.0, "inertia": [0.1, 0.1, 0.1]}
HARMONIC = {"harmonic": {"amplitude_deg": 10, "frequency": 1, "phase_deg": 40, "mean_deg": 90}}


def start(scene, formulation="recursive", parameters=None, time=0.0):
    """An instance at its start, and its outputs by name."""
    instance = Instance(scene_of(scene, formulation).compile(), parameters, time)
    return instance, named(instance)


def scene_of(scene, formulation="recursive"):
    return Scene(
        **{"name": "start", "gravity": [0, 0, 0]}
        | scene
        | {"solver": {"formulation": formulation} | scene.get("solver", {})}
    )


def named(instance):
    return dict(zip([v.name for v in instance.model.of_causality("output")], instance.outputs().tolist()))


def wheels(starts, couplings, drivers=()):
    """Wheels on the ground by name -> start, coupled: (first, second) -> gear."""
    drivers = dict(drivers)
    joint = {}

    for name, begin in starts.items():
        joint[name] = {"revolute": {}, "between": ["ground", name], "output": ["angle", "speed"]}
        joint[name] |= {"start": begin} if begin else {}
        joint[name] |= {"driver": drivers[name]} if name in drivers else {}

    coupling = {f"{a}{b}": {"gear": gear, "between": [a, b]} for (a, b), gear in couplings.items()}
    return {"body": dict.fromkeys(starts, BLOCK), "joint": joint, "coupling": coupling}


def bar(length, mass=1.0):
    """A bar from its frame along x, a marker at its end."""
    inertia = [0.01 * mass, mass * length**2 / 12, mass * length**2 / 12]
    return {
        "mass": mass,
        "com": [length / 2, 0, 0],
        "inertia": inertia,
        "marker": {"end": {"position": [length, 0, 0]}},
    }


def four_bar(tilt, crank=pi / 3, shift=0.0, axis="x", **solver):
    """Bars of 0.5, 2.0 and 1.5 m on feet 2 m apart; the far foot's axis is tilted (rad) and shifted along itself (m)."""
    foot = {"position": [2.0, 0, shift], "axis_angle": {"axis": axis, "angle_rad": tilt}}
    pin = {"revolute": {}, "output": ["angle"]}
    return {
        "gravity": [0, -9.81, 0],
        "ground": {"marker": {"foot": foot}},
        "body": {"a": bar(0.5), "b": bar(2.0), "c": bar(1.5)},
        "joint": {
            "crank": pin | {"between": ["ground", "a"], "start": {"angle": crank}},
            "ab": pin | {"between": ["a.end", "b"]},
            "c": pin | {"between": ["ground.foot", "c"]},
            "bc": pin | {"between": ["b.end", "c.end"]},
        },
        "output": ["total_energy", "constraint_gap"],
        "solver": solver,
    }


# couplings


@formulations
@pytest.mark.parametrize("ratio", [0.02, -1.0, 7.3, 50.0, -60.0, 1e4])
@pytest.mark.parametrize("turns_of", ["first", "second"])
def test_a_wheel_without_a_start_follows_the_one_with(ratio, turns_of, formulation):
    """angle of the second = ratio times that of the first + offset, however far that is; nothing given is moved."""
    angle, speed = radians(30), 2.0
    gear = {(("a", "b") if turns_of == "first" else ("b", "a")): {"ratio": ratio, "offset": 0.7}}
    instance, y = start(wheels({"a": {"angle_deg": 30, "speed": 2.0}, "b": None}, gear), formulation)
    right = ratio * angle + 0.7 if turns_of == "first" else (angle - 0.7) / ratio
    assert y["a.angle"] == pytest.approx(angle, abs=1e-12)
    assert y["b.angle"] == pytest.approx(right, rel=1e-12)
    assert y["a.speed"] == pytest.approx(speed, abs=1e-12)
    assert y["b.speed"] == pytest.approx(ratio * speed if turns_of == "first" else speed / ratio, rel=1e-12)
    assert not instance.notices


@formulations
@pytest.mark.parametrize("joint, angle", [("a", -70), ("b", 100), ("c", 100), ("d", 40), ("d", -70)])
def test_the_start_of_any_joint_of_a_loop_is_kept(formulation, joint, angle):
    """Whichever joint of a four-bar has the start, others of its joints close the loop; nothing is moved."""
    places = {"a": ["ground", "crank"], "b": ["crank.end", "coupler"], "c": ["coupler.end", "rocker"]}
    places["d"] = ["rocker.end", "ground.far"]
    joints = {
        name: {"revolute": {}, "between": ends, "output": ["angle", "speed"], "damper": 0.1}
        for name, ends in places.items()
    }
    joints[joint]["start"] = {"angle_deg": angle, "speed": 0.3}
    instance, found = start(
        {
            "ground": {"marker": {"far": {"position": [2.5, 0, 0]}}},
            "body": {"crank": bar(2.0), "coupler": bar(3.0), "rocker": bar(2.5)},
            "joint": joints,
            "output": ["constraint_gap", "constraint_rate"],
        },
        formulation,
    )
    assert instance.notices == []
    assert found[f"{joint}.angle"] == pytest.approx(radians(angle), abs=1e-12)
    assert found[f"{joint}.speed"] == pytest.approx(0.3, abs=1e-12)
    assert max(found["constraint_gap"], found["constraint_rate"]) < 1e-9


@formulations
def test_a_free_joints_start_is_kept_beside_a_hinge(formulation):
    """The free joint's place is that of a hinge turned by 150 deg, which has no start: the hinge follows."""
    body = BLOCK | {"marker": {"eye": {"position": [0.4, 0, 0]}}}
    turned = {"axis_angle": {"axis": "z", "angle_deg": 150}}
    joints = {
        "hinge": {"revolute": {}, "between": ["ground", "b.eye"], "output": ["angle"]},
        "seen": {
            "free": {},
            "between": ["ground", "b"],
            "start": {"position": [-0.4 * cos(5 * pi / 6), -0.2, 0]} | turned,
        },
    }
    instance, found = start({"body": {"b": body}, "joint": joints}, formulation)
    assert instance.notices == []
    assert found["hinge.angle"] == pytest.approx(radians(150), abs=1e-12)


@formulations
def test_starts_spread_through_a_train_of_gears(formulation):
    """From the one wheel in the middle that has a start to both ends."""
    names = "abcdef"
    gears = {pair: {"ratio": -3.0, "offset_deg": 20} for pair in itertools.pairwise(names)}
    starts = dict.fromkeys(names) | {"c": {"angle": -2.5}}
    instance, y = start(wheels(starts, gears), formulation)

    assert y["c.angle"] == pytest.approx(-2.5, abs=1e-12)
    assert not instance.notices

    for a, b in gears:
        assert y[f"{b}.angle"] == pytest.approx(-3 * y[f"{a}.angle"] + radians(20), rel=1e-11)


@formulations
@pytest.mark.parametrize("driver, at", [
    (HARMONIC, lambda t: pi / 2 + radians(10) * sin(2 * pi * t + radians(40))),
    ({"table": {"time": [0, 1, 2, 3, 4], "position": [0, 1, 4, 9, 16]}}, lambda t: t**2),
    ({"constant_speed": 3.0}, lambda t: 0.4),
])  # fmt: skip
@pytest.mark.parametrize("time", [0.0, 1.0])
def test_a_coupling_without_offset_keeps_a_start_beside_a_driver(driver, at, time, formulation):
    """The offset is that between the start given and where the driver stands when the run starts; later it is kept."""
    begin = {"angle": 0.4} if "constant_speed" in driver else None
    scene = wheels({"a": begin, "b": {"angle_deg": -45}}, {("a", "b"): {"ratio": -0.5}}, {"a": driver})
    instance, y = start(scene, formulation, time=time)
    assert y["a.angle"] == pytest.approx(at(time), abs=1e-9)
    assert y["b.angle"] == pytest.approx(-pi / 4, abs=1e-12)
    assert y["b.speed"] == pytest.approx(-0.5 * y["a.speed"], abs=1e-9)
    instance.step(0.3)
    later = named(instance)
    assert later["b.angle"] - y["b.angle"] == pytest.approx(
        -0.5 * (later["a.angle"] - y["a.angle"]), abs=1e-9
    )


def test_a_coupling_without_offset_keeps_starts_that_parameters_change():
    scene = wheels({"a": {"angle": 0.1}, "b": {"angle": 0.2}}, {("a", "b"): {"ratio": 3.0}})
    instance, y = start(scene, parameters={"a.angle_start": 1.5, "b.angle_start": -20.0})
    assert [y["a.angle"], y["b.angle"]] == [1.5, -20.0]
    assert not instance.notices


@formulations
def test_a_driver_beyond_the_coupled_start_is_told(formulation):
    """With an offset the driver decides: the start given is moved, and told."""
    scene = wheels(
        {"a": None, "b": {"angle_deg": -45, "speed_rpm": 3}},
        {("a", "b"): {"ratio": -0.5, "offset": 0.0}},
        {"a": HARMONIC},
    )
    instance, y = start(scene, formulation)
    right = -0.5 * (90 + 10 * sin(radians(40)))
    assert y["b.angle"] == pytest.approx(radians(right), abs=1e-12)
    angle, speed = instance.notices
    assert re.match(rf"the angle of b in deg .*given as -45.*taken as {right:.6g}", angle)
    taken = y["b.speed"] * 30 / pi
    assert re.match(rf"the speed of b in rpm .*given as 3,.*taken as {taken:.6g}", speed)


@formulations
def test_lengths_of_the_start_are_those_beside_a_driver(formulation):
    """A rod and a spring without length, from the ground to a driven arm: the rod's way is none, the spring is slack."""
    arm = {"revolute": {}, "between": ["ground", "arm"], "driver": HARMONIC, "output": ["angle"]}
    bob = {
        "prismatic": {"axis": "x"},
        "between": ["ground", "bob"],
        "output": ["position"],
        "start": {"position": 3.0},
    }
    rod = {"distance": {}, "between": ["arm.end", "bob"]}
    spring = {
        "spring_damper": {"stiffness": 10.0},
        "between": ["ground.post", "arm.end"],
        "output": ["force"],
    }
    ground = {"marker": {"post": {"position": [0, -1.0, 0]}}}
    scene = {
        "ground": ground,
        "body": {"arm": bar(1.0), "bob": BLOCK},
        "joint": {"arm": arm, "bob": bob, "rod": rod},
        "force": {"s": spring},
    }
    instance, y = start(scene, formulation)
    assert y["bob.position"] == pytest.approx(3.0, abs=1e-12)
    assert y["s.force"] == pytest.approx(0.0, abs=1e-11)
    assert not instance.notices


# parts of a start


def disk(lean, **begin):
    """A disk of radius 0.3 m that rolls on the ground, its axis y turned by the lean about x."""
    position = [0.0, 0.0, 0.3 * cos(lean)]
    axis = {"axis_angle": {"axis": "x", "angle_rad": lean}}
    return {
        "gravity": [0, 0, -9.81],
        "body": {
            "disk": {
                "mass": 1.0,
                "inertia": [0.02, 0.04, 0.02],
                "output": ["position", "velocity", "omega", "omega_body"],
            }
        },
        "joint": {
            "free": {
                "free": {},
                "between": ["ground", "disk"],
                "start": {"position": position} | axis | begin,
            },
            "roll": {"rolling_disk": {"radius": 0.3, "axis": "y"}, "between": ["ground", "disk"]},
        },
        "output": ["constraint_rate", "total_energy"],
    }


@formulations
@pytest.mark.parametrize("lean", [0.0, 0.3, -0.7])
@pytest.mark.parametrize("begin", [
    {"velocity": {"x": 1.2}, "omega_body": {"z": 0.5}},
    {"velocity": {"x": 1.2}, "omega": {"x": 0.4}},
    {"omega_body": {"y": 4.0, "x": -0.3}},
    {"velocity": {"x": -0.5, "y": 0.2}},
])  # fmt: skip
def test_what_a_rolling_disk_is_given_of_its_motion_is_kept(begin, lean, formulation):
    """Components given are kept to rounding, the others follow: it rolls, v = omega x (from the point of contact to the centre)."""
    instance, y = start(disk(lean, **begin), formulation)
    w = np.array([y[f"disk.omega[{k}]"] for k in (1, 2, 3)])
    v = np.array([y[f"disk.velocity[{k}]"] for k in (1, 2, 3)])

    for key, given in begin.items():
        for name, value in given.items():
            assert y[f"disk.{key}[{'xyz'.index(name) + 1}]"] == pytest.approx(value, abs=1e-11)

    assert v == pytest.approx(np.cross(w, [0, -0.3 * sin(lean), 0.3 * cos(lean)]), abs=1e-11)
    assert not instance.notices


@formulations
def test_the_most_that_can_be_is_kept(formulation):
    """Three components decide the motion of a rolling disk: of a fourth that contradicts them, or one of them, it is told."""
    begin = {"velocity": {"x": 1.0, "y": 0.2, "z": 0.0}, "omega": {"z": 0.5}}
    instance, y = start(disk(0.4, **begin), formulation)
    told = [n for n in instance.notices if "given" in n]
    assert len(told) == 1
    assert re.match(r"the velocity\[[23]\] of free at the start is given as (0.2|0)", told[0])
    assert y["disk.velocity[1]"] == pytest.approx(1.0, abs=1e-11)
    assert y["disk.omega[3]"] == pytest.approx(0.5, abs=1e-11)
    assert y["constraint_rate"] < 1e-11


def test_parts_of_a_start_are_read_and_written():
    scene = scene_of(disk(0.0, velocity={"x": 1.0}, omega={"z": 2}))
    assert scene.joint["free"].start_velocity().tolist() == [1, 0, 0, 0, 0, 2]
    assert Scene.model_validate(scene.model_dump(exclude_unset=True)).joint["free"] == scene.joint["free"]
    assert (
        "velocity = { x = 1.0 }" in scene.to_toml().replace("\n", " ")
        or "velocity = {x = 1.0}" in scene.to_toml()
    )

    with pytest.raises(SceneError, match='no "w" here; there is "x", "y" and "z"'):
        scene_of(disk(0.0, velocity={"w": 1.0}))


@formulations
def test_one_coordinate_of_a_joint_is_kept(formulation):
    """Of a cylindrical joint in a screw-like coupling only the angle is given: its position follows from the loop."""
    scene = {
        "ground": {"marker": {"top": {"position": [0, 0, 2.0]}}},
        "body": {"nut": BLOCK, "rod": bar(1.0)},
        "joint": {
            "guide": {
                "cylindrical": {},
                "between": ["ground", "nut"],
                "start": {"angle": 0.3},
                "output": ["position", "angle"],
            },
            "swing": {
                "revolute": {"axis": "y"},
                "between": ["ground.top", "rod"],
                "start": {"angle": 1.0},
                "output": ["angle"],
            },
            "pin": {"point_on_plane": {}, "between": ["nut", "rod.end"]},
        },
    }
    instance, y = start(scene, formulation)
    assert [y["guide.angle"], y["swing.angle"]] == pytest.approx([0.3, 1.0], abs=1e-12)
    assert y["guide.position"] == pytest.approx(2.0 - sin(1.0), abs=1e-12)
    assert not instance.notices


# the nearest assembly


def slider_crank(r, length, crank, masses=(1.0, 1.0, 1.0), **starts):
    joint = {
        "crank": {
            "revolute": {},
            "between": ["ground", "crank"],
            "start": {"angle": crank},
            "output": ["angle"],
        },
        "rod": {"revolute": {}, "between": ["crank.end", "rod"], "output": ["angle"]},
        "slide": {"prismatic": {"axis": "x"}, "between": ["ground", "block"], "output": ["position"]},
        "pin": {"revolute": {}, "between": ["rod.end", "block"]},
    }
    body = {
        "crank": bar(r, masses[0]),
        "rod": bar(length, masses[1]),
        "block": {"mass": masses[2], "inertia": [0.01] * 3},
    }
    return {
        "body": body,
        "joint": {
            name: spec | ({"start": starts[name]} if name in starts else {}) for name, spec in joint.items()
        },
    }


@pytest.mark.parametrize("seed", range(12))
def test_the_nearest_of_two_assemblies_is_taken(seed):
    """A slider-crank whose crank alone is given, whatever its parts weigh: of both places of the slider the nearer."""
    rng = np.random.default_rng(seed)
    length, angle = rng.uniform(0.4, 2.0), rng.uniform(-3, 3)
    r = rng.uniform(0.2, 0.9) * length
    instance, y = start(slider_crank(r, length, angle, 10.0 ** rng.uniform(-2, 2, 3)))
    lean = np.arcsin(-r * sin(angle) / length)
    way = []

    for rod in (lean, pi - lean):
        x = r * cos(angle) + length * cos(rod)
        turn = (rod - angle + pi) % (2 * pi) - pi
        way.append((np.hypot(turn, x / instance.m.scene_length[0]), turn, x))

    assert y["crank.angle"] == pytest.approx(angle, abs=1e-12)
    chosen = min(way, key=lambda one: abs(one[2] - y["slide.position"]))
    assert y["slide.position"] == pytest.approx(chosen[2], abs=1e-9)
    assert y["rod.angle"] == pytest.approx(chosen[1], abs=1e-9)
    assert chosen[0] <= 1.06 * min(way)[0]


@formulations
def test_of_two_starts_that_contradict_one_is_kept(formulation):
    """Crank and slider are given and do not fit; the rod is not: one of them is kept to rounding, the other told."""
    instance, y = start(slider_crank(0.5, 1.2, 0.9, slide={"position": 1.0}), formulation)
    kept = [abs(y["crank.angle"] - 0.9) < 1e-11, abs(y["slide.position"] - 1.0) < 1e-11]
    assert sorted(kept) == [False, True]
    assert len(instance.notices) == 1
    assert ("crank" if kept[1] else "slide") in instance.notices[0]


def test_a_start_with_all_in_line_closes():
    """The bars of a four-bar start along one line, where no small motion brings its ends together."""
    instance, y = start(four_bar(0.0, crank=0.0))
    assert y["crank.angle"] == 0.0
    assert y["constraint_gap"] < 1e-12


# rolling on either side


@formulations
@pytest.mark.parametrize("kind", ["rolling_disk", "rolling_sphere"])
def test_what_rolls_below_its_plane_mirrors_what_rolls_above(kind, formulation):
    """Mirrored in the plane, weight included: positions and velocities stay mirror images, the energy is kept."""
    motions = []

    for side in (1.0, -1.0):
        w = np.array([0.3, 2.0, 0.5])
        lean = 0.3
        begin = {
            "position": [0, 0, side * 0.3 * (cos(lean) if kind == "rolling_disk" else 1.0)],
            "axis_angle": {"axis": "x", "angle_rad": side * lean},
            "omega": [side * w[0], side * w[1], w[2]],
        }
        scene = disk(0.0) | {"gravity": [0, 0, -9.81 * side]}
        scene["body"]["disk"]["inertia"] = (
            [0.03, 0.04, 0.02] if kind == "rolling_sphere" else [0.02, 0.04, 0.02]
        )
        scene["joint"]["free"]["start"] = begin
        options = {"radius": 0.3} | ({"axis": "y"} if kind == "rolling_disk" else {})
        scene["joint"]["roll"] = {kind: options, "between": ["ground", "disk"]}
        results = scene_of(scene, formulation).simulate(until=0.5, step=0.1)
        mirror = np.array([1.0, 1.0, side])
        motions.append(np.hstack([results["disk.position"] * mirror, results["disk.velocity"] * mirror]))
        assert results["total_energy"] == pytest.approx(results["total_energy"][0], abs=1e-6)

    assert motions[0] == pytest.approx(motions[1], abs=1e-6)
    assert np.ptp(motions[0], axis=0).max() > 0.1


# told


def test_starts_that_are_moved_are_told_by_every_command(tmp_path, capsys):
    scene = scene_of(
        wheels({"a": {"angle_deg": 30}, "b": {"angle_deg": 50}}, {("a", "b"): {"ratio": 2.0, "offset": 0.0}})
    )
    path = tmp_path / "gears.toml"
    path.write_text(scene.to_toml())

    for command in (["check"], ["info"], ["simulate", "--until", "0.1"]):
        assert main([command[0], str(path), *command[1:]]) == 0
        said = " ".join(capsys.readouterr().err.split())
        assert "the angle of a in deg at the start is given as 30, but taken as 26" in said
        assert "the angle of b in deg at the start is given as 50, but taken as 52" in said

    assert len(scene.simulate(until=0.1).notices) == 2


@formulations
def test_a_start_of_a_joint_that_closes_a_loop_is_told(formulation):
    """All four angles of a four-bar are given; only three of them can be in the tree."""
    scene = four_bar(0.0, crank=1.0)
    _, y = start(scene)
    right = {name: y[f"{name}.angle"] for name in ("crank", "ab", "c", "bc")}

    for name, wrong in (("bc", 0.0), ("bc", 0.25)):
        for joint, angle in right.items():
            scene["joint"][joint]["start"] = {"angle": angle + wrong * (joint == name)}

        instance, _ = start(scene, formulation)
        told = [n for n in instance.notices if n.startswith("the angle of ")]
        assert bool(told) == bool(wrong)


@pytest.mark.parametrize("begin, told", [
    ({"angle_deg": 50}, "j (in deg) starts at 50, beyond its stop at 40"),
    ({"angle_deg": -21}, "j (in deg) starts at -21, beyond its stop at -20"),
    ({"angle_deg": 40}, None),
])  # fmt: skip
def test_a_start_beyond_a_stop_is_told(begin, told):
    stop = {"lower_deg": -20, "upper_deg": 40, "stiffness": 100.0}
    joint = {"j": {"revolute": {}, "between": ["ground", "a"], "start": begin, "stop": stop}}
    instance, _ = start({"body": {"a": BLOCK}, "joint": joint})
    assert instance.notices == ([told] if told else [])


@formulations
def test_hinges_that_lock_a_body_are_told(formulation):
    """Two hinges about different axes leave a body nothing; about one axis, turned out of line by nothing, they do."""
    ground = {"marker": {"two": {"position": [1.0, 0, 0]}}}
    body = {"a": BLOCK | {"marker": {"two": {"position": [1.0, 0, 0]}}}, "free": BLOCK}
    free = {"revolute": {}, "between": ["ground", "free"]}

    for axis, locked in (("x", False), ("y", True)):
        hinge = {"revolute": {"axis": axis}, "between": ["ground", "a"]}
        other = {"revolute": {"axis": axis}, "between": ["ground.two", "a.two"]}
        instance, _ = start(
            {"ground": ground, "body": body, "joint": {"one": hinge, "two": other, "free": free}}, formulation
        )
        assert [n for n in instance.notices if "cannot move" in n] == [
            "a cannot move: its joints leave it 0 degrees of freedom"
        ] * locked


@formulations
def test_a_motion_that_a_joint_has_for_nothing_is_not_a_stuck_body(formulation):
    """Of a planar joint's motions one may stand still: the body moves by the others."""
    on_line = {"point_on_line": {"axis": "y"}, "between": ["ground", "a"]}
    joint = {"plane": {"planar": {}, "between": ["ground", "a"]}, "line": on_line}
    instance, _ = start({"body": {"a": BLOCK}, "joint": joint}, formulation)
    assert instance.notices == []


@formulations
def test_a_loop_of_held_joints_moves_nothing_below_it(formulation):
    """Speeds of all joints in the loop's tree are given: what its rows could move is rounding, and the body it hangs on stays."""
    last = BLOCK | {
        "marker": {
            "one": {"position": [0.438, 0, 0], "axes": {"x": "-x", "y": [0, 0, 1]}},
            "two": {"position": [0.438, 0, 1]},
        }
    }
    scene = {
        "body": {
            "a": BLOCK,
            "base": last,
            "b": BLOCK | {"marker": {"end": {"position": [0, 1, 0]}}},
            "c": BLOCK,
        },
        "joint": {
            "ball": {"spherical": {}, "between": ["a", "ground"], "start": {"omega_body": {"y": 1.0}}},
            "free": {"free": {}, "between": ["a", "base"], "output": ["velocity", "omega"]},
            "one": {"revolute": {}, "between": ["base.one", "b"]},
            "two": {"revolute": {}, "between": ["b.end", "c"], "start": {"speed": 0.0}},
            "three": {"revolute": {"axis": "x"}, "between": ["c", "base.two"], "start": {"speed": 0.0}},
        },
    }
    instance, found = start(scene, formulation)
    assert not instance.notices and np.max(np.abs(list(found.values()))) < 1e-12


# an FMU's start values


def test_start_values_say_whether_they_are_guesses():
    """Guesses say so, what is driven has none, a coupling's speeds follow where its offset is free."""
    about = {v.name: v.description for v in scene_of(four_bar(0.0)).compile().variables}
    assert "guess" not in about["crank.angle_start"]
    assert "guess" in about["crank.speed_start"]
    assert "guess" in about["ab.angle_start"] and "guess" in about["c.angle_start"]
    model = scene_of(wheels({"a": None, "b": None}, {("a", "b"): {"ratio": 2.0}}, {"a": HARMONIC})).compile()
    about = {v.name: v.description for v in model.variables}
    assert not [name for name in about if name.startswith("a.") and name.endswith("_start")]
    assert "guess" not in about["b.angle_start"] and "guess" in about["b.speed_start"]
    about = {v.name: v.description for v in compile_scene(read_scene("models/pendulum.toml")).variables}
    assert "guess" not in about["pivot.angle_start"] + about["pivot.speed_start"]


@formulations
@pytest.mark.parametrize("kind", ["free", "spherical"])
def test_an_orientation_starts_by_three_angles(kind, formulation):
    joint = {kind: {}, "between": ["ground", "a"], "start": {"zyx_deg": [10, 20, 30]}, "output": ["zyx"]}
    scene = {"body": {"a": BLOCK}, "joint": {"j": joint}}
    name = "a" if formulation == "augmented" else "j"
    _, y = start(scene, formulation)
    assert [y[f"j.zyx[{k}]"] for k in (1, 2, 3)] == pytest.approx(np.radians([10, 20, 30]), abs=1e-12)
    _, y = start(scene, formulation, {f"{name}.zyx_start[2]": -1.2, f"{name}.zyx_start[3]": 0.4})
    assert [y[f"j.zyx[{k}]"] for k in (1, 2, 3)] == pytest.approx([radians(10), -1.2, 0.4], abs=1e-12)


def test_an_fmu_warns_of_starts_that_are_moved(tmp_path):
    """What its master sets counts as what the scene gives; each start that is moved is one warning, initialisation is OK."""
    model = scene_of(
        wheels({"a": {"angle_deg": 30}, "b": {"angle_deg": 60}}, {("a", "b"): {"ratio": 2.0, "offset": 0.0}})
    ).compile()
    library = Library(export_fmu(model, tmp_path / "gears.fmu"), tmp_path / "gears")

    for angle, warnings in ((None, 0), (radians(55), 2)):
        slave = Slave(library)
        assert slave.setup() == OK
        assert angle is None or slave.set({"b.angle_start": angle}) == OK
        assert slave.enter() == slave.exit() == OK
        told = [entry for entry in slave.log if entry[0] == WARNING]
        assert [entry[1] for entry in told] == ["logStatusWarning"] * warnings
        slave.free()

    assert "the angle of b in deg at the start is given as 55, but taken as 56" in told[1][2]


# what is as at the start, the right way round


@formulations
@pytest.mark.parametrize(
    "kind", ["fixed", "translation", "prismatic", "revolute", "cylindrical", "screw", "planar"]
)
@pytest.mark.parametrize(
    "axis, angle",
    [((1, -1, 1), 120), ((1, 1, 1), -120), ((1, 0, 0), 180), ((0, 1, 1), 170), ((1, 0.1, 0), 100)],
)
def test_loops_close_the_right_way_round(formulation, kind, axis, angle):
    """Where products of axes vanish too, axes antiparallel or in each other's places, no loop is closed."""
    turned = {"axis_angle": {"axis": axis, "angle_deg": angle}}
    options = {"screw": {"pitch": 0.1}}.get(kind, {})
    joints = {
        "ball": {"spherical": {}, "between": ["ground", "b"], "output": ["omega"]},
        "keeps": {kind: options, "between": ["ground.turned", "b"]},
    }
    seen = {"between": ["ground.turned", "b"], "output": ["euler_parameters"]}
    scene = {
        "body": {"b": BLOCK},
        "joint": joints,
        "measure": {"seen": seen},
        "ground": {"marker": {"turned": turned}},
    }
    _, found = start(scene, formulation)
    x, y, _, w = (found[f"seen.euler_parameters[{k}]"] for k in (1, 2, 3, 4))
    assert 1 - 2 * (x * x + y * y) == pytest.approx(1.0, abs=1e-12)

    if kind in ("fixed", "translation", "prismatic"):
        assert abs(w) == pytest.approx(1.0, abs=1e-12)


def three_bars(**last):
    """Three bars of 1 m between hinges 2 m apart; only the first has a start, so that the loop is open at the guesses."""
    hinge = {"revolute": {"axis": "y"}}
    ends = [["ground", "a"], ["a.end", "b"], ["b.end", "c"], ["c.end", "ground.far"]]
    joints = {name: hinge | {"between": pair} for name, pair in zip("1234", ends)}
    joints["1"]["start"] = {"angle_deg": -60}
    bars = {name: bar(1.0) for name in "abc"}
    return {"ground": {"marker": {"far": {"position": [2, 0, 0]}}}, "body": bars, "joint": joints} | last


@formulations
def test_a_strut_without_rest_length_is_slack_at_the_start(formulation):
    """Once the loop is closed the knee is sqrt(3) m from the ground's hinge."""
    strut = {
        "spring_damper": {"stiffness": 100},
        "between": ["ground", "b.end"],
        "output": ["length", "tension"],
    }
    instance, found = start(three_bars(force={"strut": strut}, output=["spring_energy"]), formulation)
    assert found["strut.length"] == pytest.approx(3**0.5, abs=1e-12)
    assert found["strut.tension"] == found["spring_energy"] == 0.0
    instance, told = start(three_bars(force={"strut": strut}), formulation, {"strut.rest_length": 1.5})
    assert told["strut.tension"] == pytest.approx(100 * (3**0.5 - 1.5), abs=1e-9)

    # set in the run, and back to what the scene has: that of the start again
    parameter = next(v for v in instance.model.variables if v.name == "strut.rest_length")
    instance = Instance(instance.model)

    for rest, tension in ((1.5, 100 * (3**0.5 - 1.5)), (parameter.start, 0.0)):
        instance.reals[parameter.index] = rest
        instance.prepare()
        assert named(instance)["strut.tension"] == pytest.approx(tension, abs=1e-9)


@formulations
def test_a_distance_without_length_is_that_of_the_start(formulation):
    """It restricts no start, and holds what it finds there."""
    scene = three_bars(output=["constraint_gap"])
    scene["joint"]["rod"] = {"distance": {}, "between": ["ground", "b.end"]}
    scene["measure"] = {"seen": {"between": ["ground", "b.end"], "output": ["distance"]}}
    instance, found = start(scene, formulation)
    assert found["seen.distance"] == pytest.approx(3**0.5, abs=1e-12) and found["constraint_gap"] < 1e-12

    free = {name: joint for name, joint in scene["joint"].items() if name != "4"}
    instance, found = start(scene | {"joint": free}, formulation)
    length = found["seen.distance"]

    for _ in range(5):
        instance.step(0.1)
        assert named(instance)["seen.distance"] == pytest.approx(length, abs=1e-9)


def test_slack_at_the_start_of_this_run():
    """A start value that is set, or a drive at another start time, changes what the start's length is; restored states keep theirs."""
    strut = {
        "spring_damper": {"stiffness": 100},
        "between": ["ground.up", "b.end"],
        "output": ["length", "tension"],
    }
    scene = {
        "ground": {"marker": {"up": {"position": [0, 0, 2]}}},
        "body": {"b": bar(1.0)},
        "joint": {"j": {"revolute": {"axis": "y"}, "between": ["ground", "b"], "start": {"angle": 0.0}}},
        "force": {"strut": strut},
    }
    assert start(scene, parameters={"j.angle_start": 0.7})[1]["strut.tension"] == 0.0
    driven = {
        "revolute": {"axis": "y"},
        "between": ["ground", "b"],
        "driver": {"harmonic": {"amplitude": 1.0, "frequency": 0.3}},
    }
    instance, found = start(scene | {"joint": {"j": driven}}, time=0.8)
    assert found["strut.tension"] == 0.0
    instance.step(0.5)
    assert named(instance)["strut.tension"] == pytest.approx(
        100 * (named(instance)["strut.length"] - found["strut.length"]), abs=1e-9
    )


def test_an_output_does_not_change_how_a_start_gives_way():
    """The size of the parts, by which lengths count beside angles, is that of the joints' markers, not of what is looked at."""
    bar = {"mass": 1.0, "inertia": [0.1, 0.1, 0.1], "marker": {"end": {"position": [0, 0, -1.3]}}}
    hinge = {"revolute": {"axis": "y"}}
    scene = {
        "name": "arms",
        "ground": {"marker": {"far": {"position": [2.0, 0, 0]}}},
        "body": dict.fromkeys("abc", bar),
        "joint": {
            "p": hinge | {"between": ["ground", "a"], "start": {"angle": 0.3}},
            "q": hinge | {"between": ["a.end", "b"], "start": {"angle": -1.1}},
            "r": {"prismatic": {"axis": "x"}, "between": ["b.end", "c"], "start": {"position": 0.4}},
            "s": hinge | {"between": ["c", "ground.far"]},
        },
    }
    plain = Instance(compile_scene(Scene.model_validate(scene)))
    seen = bar | {
        "marker": bar["marker"] | {"mast": {"position": [0, 40.0, 0], "output": ["position"]}},
        "output": ["omega"],
    }
    watched = Instance(compile_scene(Scene.model_validate(scene | {"body": scene["body"] | {"b": seen}})))
    assert plain.d.x.tobytes() == watched.d.x.tobytes()


def test_an_angle_that_cannot_be_is_told_in_rad():
    """A block on a rail cannot lean: its x axis stays 60 deg off from where an angle of 30 deg to the vertical would have it."""
    scene = Scene(
        name="block",
        body={"block": {"mass": 1.0, "inertia": [1, 1, 1]}},
        joint={
            "rail": {"prismatic": {}, "between": ["ground", "block"]},
            "lean": {"angle": {"angle_deg": 30, "axes": ["z", "x"]}, "between": ["ground", "block"]},
        },
    )

    with pytest.raises(SimulationError, match=r"lean stay 0 m apart and turned by 1\.047\d* rad"):
        Instance(compile_scene(scene))
