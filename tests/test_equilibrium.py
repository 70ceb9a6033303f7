"""Static equilibria against closed forms, and against runs that die away."""

from pathlib import Path

import numpy as np
import pytest
from scipy import optimize

import mbdfmi
from mbdfmi import Scene
from mbdfmi.analysis.equilibrium import NoEquilibrium, settle
from mbdfmi.analysis.manifold import NoState
from mbdfmi.analysis.places import mechanism_of
from mbdfmi.kernels.motion import kinematics
from mbdfmi.run.instance import SimulationError
from mbdfmi.scene import SceneError
from tests.referee import generator

G = 9.81


def hanging(masses, length=1.0, **first):
    """Bars of equal length in a chain, each with its mass at the lower end."""
    bodies, joints = {}, {}

    for i, mass in enumerate(masses):
        bodies[f"b{i}"] = {
            "mass": mass,
            "com": [0, 0, -length],
            "inertia": [0, 0, 0],
            "marker": {"end": {"position": [0, 0, -length]}},
        }
        before = "ground" if i == 0 else f"b{i - 1}.end"
        joints[f"j{i}"] = {"revolute": {"axis": "y"}, "between": [before, f"b{i}"]} | (
            first if i == 0 else {}
        )

    return Scene(name="chain", gravity=[0, 0, -G], body=bodies, joint=joints)


def test_a_chain_pulled_aside_hangs_as_its_loads_have_it():
    """Each bar lies along the force that it bears: that on the last bead, and the weights below."""
    masses, pull = [0.5, 1.0, 2.0, 0.7, 0.3], 6.0
    scene = hanging(masses)
    scene.body["b4"].marker["end"].input = ["force"]
    found = scene.equilibrium(hold={"b4.end.force[1]": pull})
    below = np.cumsum(masses[::-1])[::-1] * G
    angles = -np.arctan2(pull, below)
    turned = np.cumsum([found.coordinates[f"j{i}.angle"] for i in range(5)])
    assert found.stable
    assert np.abs(turned - angles).max() < 1e-13
    force = found.reactions["j0"][0]
    assert np.abs(force - [-pull, 0, below[0]]).max() < 1e-11


def test_a_string_between_two_points_is_that_of_its_links():
    """A loop: n links with equal beads, its ends at one height; found by the closed form of a string of links, in which each
    bears the same pull and the weight beside it.
    """
    n, span, mass = 8, 5.0, 1.0
    scene = hanging([mass] * n)
    data = scene.model_dump(exclude_unset=True)
    data["body"][f"b{n - 1}"]["mass"] = 0.0
    data["ground"] = {"marker": {"hook": {"position": [span, 0, 0]}}}
    data["joint"]["hook"] = {
        "revolute": {"axis": "y"},
        "between": ["ground.hook", f"b{n - 1}.end"],
        "output": ["reaction_force"],
    }
    data["joint"]["j0"]["start"] = {"angle": -0.3}
    loads = mass * G * (np.arange(n)[::-1] - (n - 1) / 2)

    def sag(pull):
        return np.sum(pull / np.hypot(pull, loads)) - span

    pull = optimize.brentq(sag, 1e-3, 1e3, xtol=1e-14)
    found = Scene.model_validate(data).equilibrium()
    assert found.stable
    assert np.abs(np.abs(found.reactions["hook"][0]) - [pull, 0, (n - 1) / 2 * mass * G]).max() < 1e-9


def strut(load, start=0.0):
    """Two bars in a line under a load, held straight by a spring in the hinge; it buckles at k / (l / 4 * 2)."""
    bar = {
        "mass": 1e-3,
        "com": [0, 0, 0.25],
        "inertia": [1e-6, 1e-6, 1e-6],
        "marker": {"end": {"position": [0, 0, 0.5]}},
    }
    return Scene(
        name="strut",
        gravity=[0, 0, 0],
        body={"a": bar, "b": bar, "head": {"mass": 1e-3, "inertia": [0, 0, 0]}},
        joint={
            "foot": {"revolute": {"axis": "y"}, "between": ["ground", "a"], "start": {"angle": start}},
            "hinge": {"revolute": {"axis": "y"}, "between": ["a.end", "b"], "spring": {"stiffness": 10.0}},
            "pin": {"revolute": {"axis": "y"}, "between": ["b.end", "head"]},
            "guide": {"prismatic": {"axis": "z"}, "between": ["ground", "head"]},
        },
        force={"load": {"load": {"force": [0, 0, -load]}, "on": "head"}},
    )


def test_a_strut_buckles_at_its_load_into_its_branch():
    """k 2 a = P l / 2 ... : two bars of l = 0.5, hinge spring k: k (2 a) 2 = 2 P l sin a, so P = 2 k a / (l sin a)."""
    k, length = 10.0, 0.5
    critical = 2 * k / length
    straight = strut(0.98 * critical).equilibrium()
    assert straight.stable and abs(straight.coordinates["hinge.angle"]) < 1e-12

    for over in (1.02, 1.3, 2.0):
        bent = strut(over * critical).equilibrium()
        angle = optimize.brentq(lambda a: a / np.sin(a) - over, 1e-6, 3.0, xtol=1e-15)
        assert bent.stable and any("unstable" in notice for notice in bent.notices)
        assert abs(abs(bent.coordinates["hinge.angle"]) - 2 * angle) < 1e-11

    stays = strut(1.3 * critical).equilibrium(nearest=True)
    assert stays.stable is False and "hinge.angle" in stays.motions[0]
    both = strut(1.3 * critical).equilibria(n=20)
    assert [one.stable for one in both] == [True, True, False]


def arch(load, stiffness=1000.0, half=0.8, rise=0.25):
    """Two struts from a crown, on a vertical guide, to two abutments: von Mises' truss, under a load on the crown."""
    strut = {"spring_damper": {"stiffness": stiffness, "rest_length": float(np.hypot(half, rise))}}
    crown = {"mass": 1.0, "inertia": [0, 0, 0]}
    ends = {"left": {"position": [-half, 0, 0]}, "right": {"position": [half, 0, 0]}}
    guide = {"prismatic": {"axis": "z"}, "between": ["ground", "crown"], "start": {"position": rise}}
    return Scene(
        name="arch",
        gravity=[0, 0, 0],
        ground={"marker": ends},
        body={"crown": crown},
        joint={"guide": guide},
        force={
            "a": strut | {"between": ["ground.left", "crown"]},
            "b": strut | {"between": ["ground.right", "crown"]},
            "load": {"load": {"force": [0, 0, -load]}, "on": "crown"},
        },
    )


def test_an_arch_snaps_through_at_its_limit_load():
    """P(z) = 2 k z (l0 / sqrt(b^2 + z^2) - 1): all its roots are the equilibria, and beyond its maximum the crown is below."""
    k, half, rise = 1000.0, 0.8, 0.25
    length = np.hypot(half, rise)
    load = lambda z: 2 * k * z * (length / np.hypot(half, z) - 1)
    at = np.sqrt((length * half**2) ** (2 / 3) - half**2)
    limit = load(at)

    before = arch(0.999 * limit).equilibrium()
    above = optimize.brentq(lambda z: load(z) - 0.999 * limit, at, rise, xtol=1e-15)
    assert before.stable and abs(before.coordinates["guide.position"] - above) < 1e-10
    after = arch(1.001 * limit).equilibrium()
    below = optimize.brentq(lambda z: load(z) - 1.001 * limit, -2.0, -rise, xtol=1e-15)
    assert after.stable and abs(after.coordinates["guide.position"] - below) < 1e-10

    found = arch(0.5 * limit).equilibria(n=20)
    half_load = lambda z: load(z) - 0.5 * limit
    roots = [optimize.brentq(half_load, *ends) for ends in ((at, rise), (-2.0, -rise), (-at, at))]
    places = [one.coordinates["guide.position"] for one in found]
    assert [one.stable for one in found] == [True, True, False]
    assert abs(np.sort(places) - np.sort(roots)).max() < 1e-9

    # the limit itself, by the loads that are still borne above
    low, high = 0.9, 1.1

    while high - low > 1e-7:
        middle = 0.5 * (low + high)
        borne = arch(middle * limit).equilibrium().coordinates["guide.position"] > 0
        low, high = (middle, high) if borne else (low, middle)

    assert abs(low - 1) < 1e-6


def test_what_falls_or_turns_for_ever_has_no_equilibrium():
    ball = {"ball": {"mass": 1.0, "inertia": [0.1, 0.1, 0.1]}}
    free = Scene(
        name="ball", gravity=[0, 0, -G], body=ball, joint={"fly": {"free": {}, "between": ["ground", "ball"]}}
    )

    with pytest.raises(NoEquilibrium, match=r"fly\.position\[3\].* moves away"):
        free.equilibrium()

    wheel = {"revolute": {"axis": "z"}, "between": ["ground", "ball"], "input": "torque"}
    driven = Scene(name="wheel", gravity=[0, 0, -G], body=ball, joint={"axle": wheel})

    with pytest.raises(NoEquilibrium, match=r"axle\.angle.* moves away"):
        driven.equilibrium(hold={"axle.torque": 1.0})

    assert driven.equilibrium().stable is None


def test_stops_ropes_and_held_drives_at_rest():
    """A bar on a stop, against its closed form; drives stay where they are at the time asked for."""
    bar = {"mass": 2.0, "com": [0.5, 0, 0], "inertia": [0, 0.1, 0.1]}
    joint = {
        "revolute": {"axis": "y"},
        "between": ["ground", "bar"],
        "stop": {"upper": 0.2, "stiffness": 500.0},
        "output": ["stop_effort"],
    }
    found = Scene(name="stop", gravity=[0, 0, -G], body={"bar": bar}, joint={"hinge": joint}).equilibrium()
    angle = optimize.brentq(lambda a: 500 * (a - 0.2) - 2 * G * 0.5 * np.cos(a), 0.2, 0.3, xtol=1e-15)
    assert found.stable and abs(found.coordinates["hinge.angle"] - angle) < 1e-13
    assert abs(found.efforts["hinge.stop_effort"] + 500 * (angle - 0.2)) < 1e-9

    arm = {
        "slide": {
            "prismatic": {"axis": "x"},
            "between": ["ground", "cart"],
            "driver": {"harmonic": {"amplitude": 0.3, "frequency": 0.25}},
        },
        "swing": {"revolute": {"axis": "y"}, "between": ["cart", "bob"], "start": {"angle": 1.0}},
    }
    point = {"mass": 1.0, "inertia": [0.1, 0.1, 0.1]}
    driven = Scene(
        name="cart", gravity=[0, 0, -G], body={"cart": point, "bob": point | {"com": [0, 0, -1]}}, joint=arm
    )
    assert any('drives move "slide" at 0.5 s' in text for text in driven.equilibrium(time=0.5).notices)
    later = driven.equilibrium(time=1.0)
    assert abs(later.coordinates["slide.position"] - 0.3) < 1e-15
    assert abs(later.coordinates["swing.angle"]) < 1e-15
    assert np.abs(later.reactions["swing"][0] - [0, 0, G]).max() < 1e-12


def test_what_is_held_though_it_moves_is_told():
    """A turning ground, a driven joint in a loop; those that stand still are passed over."""
    bob = {"bob": {"mass": 1.0, "com": [0, 0, -1], "inertia": [0, 0, 0]}}
    swing = {"swing": {"revolute": {"axis": "y"}, "between": ["ground", "bob"]}}
    scene = Scene(name="bob", gravity=[0, 0, -G], body=bob, joint=swing)
    assert scene.equilibrium().notices == []
    scene.ground.motion = {"rotation": {"axis": "z", "speed": 2.0}}
    (told,) = scene.equilibrium().notices
    assert told.startswith("the ground moves at 0 s: it is held")
    assert scene.linearise(at="equilibrium").notices[-1] == told

    scene.joint["swing"] = {"free": {}, "between": ["ground", "bob"]}

    with pytest.raises(NoState, match="inertia about the joint of bob"):
        scene.equilibrium()

    scene.body["bob"].inertia = [0.1, 0.1, 0.1]

    with pytest.raises(NoEquilibrium, match=r"moves? away; the ground moves at 0 s"):
        scene.equilibrium()

    four_bar = mbdfmi.load(ROOT + "four_bar.toml")
    four_bar.joint["crank_pivot"].input = []
    four_bar.joint["crank_pivot"].start = {"angle_deg": 60}
    four_bar.joint["crank_pivot"].driver = {"constant_speed": 0.5}

    for formulation in ("recursive", "augmented"):
        four_bar.solver.formulation = formulation
        assert any('drives move "crank_pivot" at 0 s' in text for text in four_bar.equilibrium().notices)


ROOT = mbdfmi.__path__[0] + "/../models/"


@pytest.mark.parametrize(
    "name", ["pendulum", "four_bar", "double_pendulum", "bricard", "two_link_arm", "marble_run"]
)
def test_rest_is_where_a_damped_run_ends(name):
    """With dampers in its joints the scene comes to the equilibrium that was found, or to one of those that were."""
    scene = mbdfmi.load(ROOT + name + ".toml")

    for joint in scene.joint.values():
        if joint.kind in ("revolute", "prismatic") and not joint.driver:
            joint.damper = 2.0

    found = scene.equilibrium()
    assert found.stable is not False
    assert found.error < 1e-9
    stays = found.scene.simulate(1.0, 0.5)

    for body, (r, _) in found.positions.items():
        assert np.abs(stays.poses(body)[0] - r).max() < 1e-7

    if name in ("pendulum", "four_bar", "double_pendulum"):
        ends = scene.simulate(120.0, 60.0)
        r = {body: ends.poses(body)[0][-1] for body in scene.body}
        others = [found] if name == "pendulum" else scene.equilibria(n=10)
        assert min(max(np.abs(one.positions[b][0] - r[b]).max() for b in r) for one in others) < 1e-5


def test_a_scene_that_starts_at_rest_stays(tmp_path):
    """`start = "equilibrium"` in a run with inputs and parameters, in an FMU, and the speeds of what spins freely."""
    bar = {"mass": 2.0, "com": [0, 0, -0.5], "inertia": [0, 0.1, 0.1]}
    joint = {
        "revolute": {"axis": "y"},
        "between": ["ground", "bar"],
        "start": {"angle": 1.0},
        "input": "torque",
        "output": ["angle"],
    }
    scene = Scene(
        name="rest",
        gravity=[0, 0, -G],
        body={"bar": bar},
        joint={"pivot": joint},
        solver={"start": "equilibrium"},
    )
    run = scene.simulate(2.0, inputs={"pivot.torque": lambda t: 0.3 * G}, parameters={"gravity": [0, 0, -G]})
    assert np.ptp(run["pivot.angle"]) < 1e-12
    assert abs(np.sin(run["pivot.angle"][0]) - 0.3) < 1e-12
    linear = scene.linearise(at="start", hold={"pivot.torque": 0.3 * G})
    assert abs(linear.stiffness[0, 0] - G * np.sqrt(1 - 0.09)) < 1e-9

    path = scene.export(tmp_path / "rest.fmu")
    import fmpy

    result = fmpy.simulate_fmu(str(path), stop_time=1.0, output=["pivot.angle"])
    assert np.abs(result["pivot.angle"]).max() < 1e-12

    turbine = mbdfmi.load(ROOT + "floating_wind_turbine/floating_wind_turbine.toml").equilibrium().scene
    assert turbine.joint["shaft"].start.speed_rpm == 12.1
    assert turbine.joint["float"].start.position[2] < -0.1


def test_a_file_gets_its_new_start_and_keeps_its_words(tmp_path, capsys):
    from mbdfmi.cli import main

    path = tmp_path / "four_bar.toml"
    text = Path(ROOT, "four_bar.toml").read_text()
    path.write_text(text)
    assert main(["equilibrium", str(path), "--write", str(path)]) == 0
    told = capsys.readouterr().out
    assert "stable" in told and "crank_pivot.angle" in told
    comments = [line for line in text.splitlines() if line.startswith("#")]
    assert all(line in path.read_text() for line in comments)
    again = mbdfmi.load(path).equilibrium()
    assert again.iterations == 1
    assert main(["equilibrium", str(path), "--all", "--nearest"]) == 1
    assert main(["equilibrium", ROOT + "satellite.toml"]) == 1
    assert "moves away" in capsys.readouterr().err


def in_oil(seed):
    """A random scene of the referee with drag on every body, that takes no part in where it rests."""
    data = generator.draw(seed, size=1 + seed % 2)
    data["solver"] = {"tolerance": 1e-7, "formulation": "recursive"}
    drags = {}

    for name, body in Scene.model_validate(data).body.items():
        mass, _, inertia = body.mass_properties()

        if mass > 0.0:
            drag = np.diag([3 * mass] * 3 + [3 * max(np.trace(inertia), 1e-3 * mass)] * 3)
            drags[f"drag {name}"] = {
                "linear": {"damping": drag.tolist(), "axes": "body"},
                "between": ["ground", name],
            }

    return Scene.model_validate(data | {"force": data.get("force", {}) | drags})


@pytest.mark.parametrize("seed", [7, 14, 15, 16, 47, 49, 58])
def test_random_scenes_end_in_oil_where_their_equilibrium_is(seed):
    """Loops, springs, ropes, bushings, surfaces as the referee draws them: those of few seeds that rest in less than 80 s. Loads
    over time (seeds 7 and 58) are those of the end, when their tables have come to their last values.
    """
    scene = in_oil(seed)
    found = scene.equilibrium(time=80.0)
    end = scene.simulate(80.0, 80.0)
    assert found.stable
    assert max(np.abs(end.poses(body)[0][-1] - r).max() for body, (r, _) in found.positions.items()) < 1e-6


def test_a_random_scene_that_slides_on_for_ever_has_no_equilibrium():
    """Seed 1: a point passes the end of an open spline, whose straight continuation leads downhill: in oil it keeps its speed."""
    scene = in_oil(1)
    run = scene.simulate(80.0, 10.0)
    ways = np.linalg.norm(np.diff(run.poses("link5")[0], axis=0), axis=1)
    assert ways[-1] > 10.0 and abs(ways[-1] - ways[-2]) < 1e-2 * ways[-1]

    with pytest.raises(NoEquilibrium, match=r"hinge6\.position"):
        scene.equilibrium(time=80.0)


def rests_where(mechanism):
    """Positions (3 n_body,) where a run of at most 240 s comes to rest, None where it does not."""
    instance = mechanism.instance

    for _ in range(6):
        instance.step(40.0)

        if np.abs(instance.d.v).max(initial=0.0) < 1e-10:
            kinematics.kinematics(instance.m, instance.d)
            return instance.d.r.copy()

    return None


@pytest.mark.long
def test_all_random_scenes_that_come_to_rest_do_so_in_an_equilibrium():
    """Of the referee's first 120 seeds those without drives or a ground that moves: where a run in oil ends, statics stay. Where
    there are several equilibria the search may find another one, as where something rolls. Where it finds none, no run rests.
    Loads over time are those of the end.
    """
    ended, elsewhere = 0, 0

    for seed in range(1, 121):
        try:
            scene = in_oil(seed)
            mechanism = mechanism_of(scene)
            found = scene.equilibrium(time=240.0)
        except NoEquilibrium:
            assert rests_where(mechanism) is None, seed
            continue
        except (SceneError, SimulationError):
            continue

        if not found.stable or found.manifold.mechanism.stilled:
            continue

        r = rests_where(mechanism)

        if r is None:
            continue

        _, rest = settle(mechanism, stay=True)
        kinematics.kinematics(mechanism.m, mechanism.d)
        assert np.abs(mechanism.d.r - r).max() < 1e-8, seed
        assert rest.stable is not False, seed
        ended += 1
        found.manifold.put()
        kinematics.kinematics(found.manifold.m, found.manifold.d)
        elsewhere += np.abs(found.manifold.d.r - r).max() > 1e-6

    assert ended > 20 and elsewhere < 0.25 * ended


def wound(start, rest):
    """A disk on a hinge with a torsion spring, which nothing else turns; start, rest in deg."""
    disk = {"mass": 1.0, "inertia": [0.3, 0.3, 0.5]}
    hinge = {"revolute": {}, "between": ["ground", "disk"], "start": {"angle_deg": start}}
    bar = {
        "torsion": {"stiffness": 4.0, "rest_deg": rest},
        "between": ["ground", "disk"],
        "output": ["angle", "moment"],
    }
    return Scene(name="shaft", body={"disk": disk}, joint={"hinge": hinge}, force={"bar": bar})


@pytest.mark.parametrize("start, rest", [(179.9, 200.0), (-179.9, -190.0), (100.0, 900.0), (175.0, 170.0)])
def test_a_torsion_spring_unwinds_past_half_a_turn(start, rest):
    """Its twist is followed from the start; a rest that is beyond half a turn is told, as no run starts there."""
    found = wound(start, rest).equilibrium()
    assert found.stable
    assert abs(found.coordinates["hinge.angle"] - np.deg2rad(rest)) < 1e-12
    assert abs(found.outputs["bar.angle"] - np.deg2rad(rest)) < 1e-12
    told = [notice for notice in found.notices if "torsion spring" in notice]
    assert len(told) == (abs(rest) > 180.0) and all(f"{rest:.6g} deg" in notice for notice in told)
    run = found.scene.simulate(0.1, 0.1)
    assert (abs(run["bar.moment"][0]) > 1.0) == bool(told)


def test_wind_and_waves_are_left_out_unless_asked_for(tmp_path):
    """A rotor on a spring in steady wind: bent by its thrust only with `weather`, or where an input tells the wind."""
    rows = [f"{r},{p},{1e-3 + 0.8 * (r >= 0)},{0.0}" for r in (0, 1, 2, 3) for p in (0, 1, 2, 3)]
    (tmp_path / "rotor.csv").write_text("\n".join(["tip speed ratio,pitch,C_T,C_Q", *rows]))
    mast = {"mass": 10.0, "com": [0, 0, 1], "inertia": [1, 1, 1], "marker": {"top": {"position": [0, 0, 2]}}}
    data = {
        "name": "mast",
        "gravity": [0, 0, 0],
        "wind": {"density": 1.2, "steady": {"velocity": [8.0, 0, 0]}, "input": ["velocity"]},
        "body": {"mast": mast},
        "joint": {
            "foot": {"revolute": {"axis": "y"}, "between": ["ground", "mast"], "spring": {"stiffness": 5e4}}
        },
        "force": {
            "air": {
                "rotor": {"radius": 2.0, "table": str(tmp_path / "rotor.csv")},
                "on": "mast.top",
                "output": ["thrust"],
            }
        },
    }
    scene = Scene.model_validate(data)
    calm = scene.equilibrium()
    assert abs(calm.coordinates["foot.angle"]) < 1e-12
    assert any("wind and waves" in notice for notice in calm.notices)

    windy = scene.equilibrium(weather=True)
    assert windy.coordinates["foot.angle"] > 1e-3 and not any("wind" in notice for notice in windy.notices)
    assert abs(5e4 * windy.coordinates["foot.angle"] - 2.0 * windy.outputs["air.thrust"]) < 1e-6
    told = scene.equilibrium(hold={"wind.velocity": [8.0, 0, 0]})
    assert abs(told.coordinates["foot.angle"] - windy.coordinates["foot.angle"]) < 1e-12
