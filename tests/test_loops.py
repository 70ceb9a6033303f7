"""Closed loops: three formulations, every kind of row against differences, projection, assembly, drives, energy."""

import numpy as np
import pytest
from hypothesis import assume, given
from hypothesis import strategies as st
from loop_scenes import LOOP, random_loops, with_solver
from scenes import assert_near, body_motion, evaluate, examples

from mbdfmi import Scene
from mbdfmi.compiler.model import compile_scene
from mbdfmi.kernels import joints
from mbdfmi.kernels.dynamics import multipliers, projection, rows
from mbdfmi.kernels.motion import kinematics
from mbdfmi.run.instance import Instance, SimulationError

FORMULATIONS = ["recursive", "embedding", "augmented"]
formulations = pytest.mark.parametrize("formulation", FORMULATIONS)
seeds = st.integers(0, 2**32 - 1)
loop_kinds = st.lists(st.sampled_from(sorted(LOOP)), min_size=1, max_size=3)


def instances(scene):
    """An instance in each formulation."""
    return [Instance(compile_scene(with_solver(scene, formulation=name))) for name in FORMULATIONS]


def close(a, b, relative, size=1.0):
    """Assert that arrays are equal to within `relative` of their largest number, or of `size`."""
    a, b = np.asarray(a), np.asarray(b)
    assert_near(a, b, relative * max(size, np.abs(a).max(initial=0.0)))


def accelerations(instance):
    """Of all bodies (n, 6), angular and of the centre of mass."""
    evaluate(instance)
    return np.array(
        [np.concatenate(motion[4:]) for motion in body_motion(instance, accelerated=True).values()]
    )


def velocities_of(instance):
    """Of all bodies (n, 6)."""
    return np.array([np.concatenate(motion[2:4]) for motion in body_motion(instance).values()])


# formulations


@examples
@given(seeds, loop_kinds, st.integers(0, 2))
def test_three_formulations_agree(seed, loops, couplings):
    scene = random_loops(seed, loops, couplings=couplings)
    one, *others = instances(scene)
    motion, velocity = accelerations(one), velocities_of(one)

    for other in others:
        close(velocity, velocities_of(other), 1e-11)
        close(motion, accelerations(other), 1e-10)


@examples
@given(seeds, loop_kinds)
def test_residuals_stay_at_rounding(seed, loops):
    """After a run in which everything moves, positions, velocities and accelerations keep to the constraints."""
    scene = random_loops(seed, loops, couplings=1)

    for formulation in FORMULATIONS[::2]:
        instance = Instance(
            compile_scene(with_solver(scene, formulation=formulation, integrator="rk853", tolerance=1e-6))
        )
        instance.step(0.3)
        evaluate(instance)
        m, d = instance.m, instance.d

        # rows that are dropped here alone: loops that lock each other, whose rank hangs on rounding
        assume(not ((d.pivot == 0.0) & (d.row_redundant != 1.0)).any())
        size = max(1.0, np.abs(d.r).max(), np.abs(d.x).max())
        assert np.abs(d.row_gap).max(initial=0.0) < 1e-12 * size
        assert np.abs(d.row_rate).max(initial=0.0) < 1e-11 * size
        found = [multipliers.row_acceleration(m, d, row) for row in range(m.n_row)]
        assert np.abs(found).max(initial=0.0) < 1e-9 * max(size, np.abs(d.x_rate).max())


# rows


def along(instance, q, v, a, t):
    """Everything at time t of a motion with velocities v + a t through positions q; rows are written, x_rate holds a.

    Positions by the classical method of order 4 in one step.
    """
    m, d = instance.m, instance.d

    def rates(q, t):
        d.q[:] = q
        d.v[:] = v + a * t

        for i in range(1, m.n_body):
            joints.position_rates(m, d, i)

        return d.q_rate.copy()

    k1 = rates(q, 0.0)
    k2 = rates(q + t / 2 * k1, t / 2)
    k3 = rates(q + t / 2 * k2, t / 2)
    k4 = rates(q + t * k3, t)
    d.q[:] = q + t / 6 * (k1 + 2 * k2 + 2 * k3 + k4)
    d.v[:] = v + a * t
    d.v_rate[:] = a
    kinematics.kinematics(m, d)
    kinematics.accelerations(m, d)
    rows.write_rows(m, d)
    return d.row_gap.copy(), d.row_rate.copy()


def slopes(instance, q, v, a):
    """(g', g'') of all rows along a motion by differences, and what rows say: (g', g'')."""
    h = 1e-3
    gap, rate = (np.array(x) for x in zip(*[along(instance, q, v, a, t) for t in (-2 * h, -h, h, 2 * h)]))
    slope = np.array([1, -8, 8, -1]) / (12 * h)
    _, now = along(instance, q, v, a, 0.0)
    m, d = instance.m, instance.d
    acceleration = [multipliers.row_acceleration(m, d, row) for row in range(m.n_row)]
    return (slope @ gap, slope @ rate), (now, np.array(acceleration))


@pytest.mark.parametrize("formulation", FORMULATIONS[::2])
@pytest.mark.parametrize("kind", sorted(LOOP))
def test_rows_against_differences(kind, formulation):
    """Along any motion, gaps open or not: g' is the slope of g, g'' that of g', and the wrenches' power is g'."""
    for seed in range(5):
        scene = random_loops(seed, [kind], elements=False)
        instance = Instance(compile_scene(with_solver(scene, formulation=formulation)))
        m, d = instance.m, instance.d
        rng = np.random.default_rng(seed)
        d.q[:] += 0.1 * rng.normal(size=m.n_q)
        projection.unit_E(m, d)
        (rate, acceleration), found = slopes(instance, d.q.copy(), *rng.normal(size=(2, m.n_v)))

        # angles of joints that close loops are exact where these are closed
        plain = m.row_kind != rows.COUPLING
        rolling = np.isin(m.row_kind, [rows.ROLL_SPHERE, rows.ROLL_DISK])
        positional = plain & (m.row_kind != rows.KNIFE) & ~(rolling & (m.row_i < 2))
        close(rate[positional], found[0][positional], 1e-8, 10.0)
        close(acceleration[plain], found[1][plain], 1e-8, 100.0)

        w, rd = d.w.reshape(-1, 3), d.rd.reshape(-1, 3)
        power = np.zeros(m.n_row)

        for side, marker in (("from", m.constraint_from), ("to", m.constraint_to)):
            body = m.marker_body[marker[m.row_constraint]]
            moment, force = (getattr(d, f"row_{what}_{side}").reshape(-1, 3) for what in ("moment", "force"))
            power += np.sum(moment * w[body] + force * rd[body], axis=1)

        close(power[plain], found[0][plain], 1e-12, 10.0)


@pytest.mark.parametrize("formulation", FORMULATIONS[::2])
def test_couplings_against_differences(formulation):
    """Along the motion of the same scene without couplings, which they do not fit."""
    for seed in range(10):
        scene = random_loops(seed, ["revolute"], tree=("revolute", "prismatic"), couplings=2, elements=False)
        free, coupled = (
            Instance(compile_scene(with_solver(case, formulation=formulation)))
            for case in (scene | {"coupling": {}}, scene)
        )
        evaluate(free)
        n, end = free.m.n_q, free.m.n_q + free.m.n_v
        x, a = free.d.x, free.d.x_rate[n:end].copy()
        along, found = slopes(coupled, x[:n].copy(), x[n:end].copy(), a)
        row = coupled.m.row_kind == rows.COUPLING
        assert np.abs(found[0][row]).max() > 1e-3
        close(along[0][row], found[0][row], 1e-7, 10.0)
        close(along[1][row], found[1][row], 1e-7, 100.0)


# redundancy


@formulations
@pytest.mark.parametrize(
    "seed, loops", [(2966859346, ["rolling_sphere", "point_on_plane", "cylindrical"]), (0, ["rolling_disk"])]
)
def test_a_gap_that_rolling_rows_imply_is_closed_all_the_same(seed, loops, formulation):
    """What follows from rows about velocities is no less a condition on positions."""
    solver = {"formulation": formulation, "integrator": "rk853", "tolerance": 1e-6}
    instance = Instance(compile_scene(with_solver(random_loops(seed, loops, couplings=1), **solver)))
    instance.step(0.3)
    evaluate(instance)
    assert np.abs(instance.d.row_gap).max() < 1e-13


@examples
@given(seeds, st.sampled_from(sorted(set(LOOP) - {"fixed", "knife_edge", "rolling_disk", "rolling_sphere"})))
def test_a_joint_twice_changes_no_motion(seed, kind):
    scene = random_loops(seed, [kind], solver={"integrator": "rk853", "tolerance": 1e-11})
    twice = scene | {"joint": scene["joint"] | {"again": scene["joint"]["loop0"]}}

    for formulation in FORMULATIONS[::2]:
        one, other = (
            Instance(compile_scene(with_solver(case, formulation=formulation))) for case in (scene, twice)
        )

        for instance in (one, other):
            instance.step(0.3)

        close(velocities_of(one), velocities_of(other), 1e-8)


@formulations
def test_an_implied_joint_changes_no_motion(formulation):
    """A planar four-bar of revolutes has three rows too many; a plane and a rod that hold anyway add two more."""
    plain = four_bar({}, formulation)
    more = four_bar({}, formulation)
    more["joint"] |= {
        "flat": {"point_on_plane": {}, "between": ["ground", "coupler.end"]},
        "rod": {"distance": {}, "between": ["ground", "crank.end"]},
    }
    motions = []

    for scene in (plain, more):
        instance = Instance(compile_scene(Scene.model_validate(scene)))
        instance.step(1.0)
        motions.append(velocities_of(instance))

    close(*motions, 1e-10)


# a four-bar whose joints all have something of their own


def four_bar(
    parts,
    formulation="recursive",
    order=("crank", "coupler", "rocker", "last"),
    lengths=(0.5, 1.5, 1.2, 1.6),
    start=True,
):
    """Crank, coupler, rocker in the plane, the ground's two pins apart on x; the crank turns fully.

    parts : what each of the joints has beside. order : of the joints in the file. start : angles that close the loop.
    """
    a, b, c, d = lengths
    crank = 0.6
    pin = a * np.array([np.cos(crank), np.sin(crank)])
    span = np.hypot(*(np.array([d, 0]) - pin))
    direction = np.arctan2(-pin[1], d - pin[0])
    inner = np.arccos(np.clip((b**2 + span**2 - c**2) / (2 * b * span), -1, 1))
    coupler = direction + inner
    tip = pin + b * np.array([np.cos(coupler), np.sin(coupler)])
    rocker = np.arctan2(tip[1], tip[0] - d)
    angles = {"crank": crank, "coupler": coupler - crank, "rocker": rocker, "last": coupler - rocker}
    between = {
        "crank": ["ground", "crank"],
        "coupler": ["crank.end", "coupler"],
        "rocker": ["ground.far", "rocker"],
        "last": ["rocker.end", "coupler.end"],
    }
    bars = {
        name: {
            "mass": length,
            "com": [length / 2, 0, 0],
            "inertia": [0.01, 0.1 * length, 0.1 * length],
            "marker": {"end": {"position": [length, 0, 0]}},
        }
        for name, length in zip(("crank", "coupler", "rocker"), (a, b, c))
    }
    joints_ = {
        name: {"revolute": {}, "between": between[name], "output": ["angle", "speed", "acceleration"]}
        | ({"start": {"angle": angles[name]}} if start else {})
        | parts.get(name, {})
        for name in order
    }
    return {
        "name": "four bar",
        "gravity": [0, -9.81, 0],
        "ground": {"marker": {"far": {"position": [d, 0, 0]}}},
        "body": bars,
        "joint": joints_,
        "output": ["total_energy", "constraint_gap"],
        "solver": {"integrator": "rk853", "tolerance": 1e-12, "formulation": formulation},
    }


OWN = {
    name: {
        "spring": {"stiffness": 0.1 + 0.1 * k, "rest": 0.3 * k},
        "damper": 0.05,
        "friction": {"coulomb": 0.02, "smoothing_speed": 0.5},
        "stop": {"upper": 100.0, "stiffness": 10.0},
        "input": "torque",
    }
    for k, name in enumerate(("crank", "coupler", "rocker", "last"))
}
ORDERS = [
    ("crank", "coupler", "rocker", "last"),
    ("last", "rocker", "coupler", "crank"),
    ("rocker", "last", "crank", "coupler"),
    ("coupler", "crank", "last", "rocker"),
]


def outputs_by_name(instance):
    names = [v.name for v in instance.model.of_causality("output")]
    return dict(zip(names, instance.outputs().copy()))


@pytest.mark.parametrize("order", ORDERS[1:])
@formulations
def test_it_does_not_matter_where_the_loop_is_cut(order, formulation):
    """Springs, dampers, friction, stops, inputs, outputs of all joints, the crank over several full turns."""
    cuts = set()
    found = []

    for case, how in ((ORDERS[0], "recursive"), (order, formulation)):
        model = compile_scene(Scene.model_validate(four_bar(OWN, how, case)))
        cuts.add(tuple(model.tree.cuts))
        instance = Instance(model)

        for v in model.of_causality("input"):
            instance.u[v.index] = 15.0 if v.name == "crank.torque" else 0.2

        history = []

        for _ in range(40):
            instance.step(0.1)
            history.append(outputs_by_name(instance))

        found.append(history)

    assert len(cuts) == 2
    assert found[0][-1]["crank.angle"] > 4 * np.pi

    for one, other in zip(*found):
        for name in one.keys() - {"constraint_gap"}:
            assert_near(other[name], one[name], 1e-6 * max(1.0, abs(one[name])))


@pytest.mark.parametrize("order", ORDERS)
@formulations
def test_energy_of_a_loop(order, formulation):
    springs = {name: {"spring": part["spring"]} for name, part in OWN.items()}
    instance = Instance(compile_scene(Scene.model_validate(four_bar(springs, formulation, order))))
    energy = [outputs_by_name(instance)["total_energy"]]

    for _ in range(20):
        instance.step(0.5)
        energy.append(outputs_by_name(instance)["total_energy"])

    assert np.ptp(energy) < 1e-9 * max(np.abs(energy))


@examples
@given(seeds, loop_kinds)
def test_energy_of_random_loops(seed, loops):
    """Joints do no work: neither do those of loops."""
    solver = {"integrator": "rk853", "tolerance": 1e-11}
    scene = random_loops(
        seed, loops, couplings=1, elements=False, solver=solver, output=["kinetic_energy", "total_energy"]
    )

    for formulation in FORMULATIONS[::2]:
        instance = Instance(compile_scene(with_solver(scene, formulation=formulation)))
        kinetic, total = instance.outputs()[:2].copy()
        instance.step(0.3)
        later = instance.outputs()[:2]
        assert abs(later[1] - total) < 1e-8 * max(1.0, kinetic, later[0])


# drives


DRIVES = {
    "constant": ({"constant_speed": 7.0}, {"start": {"angle": 0.6}}),
    "harmonic": ({"harmonic": {"amplitude": 0.4, "frequency": 0.5, "mean": 0.6}}, {}),
    "table": ({"table": {"time": [0, 1, 2, 4], "position": [0.6, 1.5, 1.0, 4.0]}}, {}),
}


@pytest.mark.parametrize("kind", DRIVES)
def test_driven_loop(kind):
    """A drive in the tree and as a row: one motion, and an effort that brings the energy."""
    driver, start = DRIVES[kind]
    found = []

    for formulation in FORMULATIONS:
        scene = four_bar({}, formulation, start=False)
        scene["joint"]["crank"] |= {
            "driver": driver,
            "output": ["angle", "speed", "acceleration", "effort"],
        } | start
        scene["joint"]["coupler"]["start"] = {"angle": 0.2}
        scene["joint"]["rocker"]["start"] = {"angle": 1.5}
        instance = Instance(compile_scene(Scene.model_validate(scene)))
        history = []

        for _ in range(30):
            instance.step(0.1)
            history.append(outputs_by_name(instance))

        found.append(history)
        assert max(y["constraint_gap"] for y in history) < 1e-12

    for history in found[1:]:
        for one, other in zip(found[0], history):
            for name in one.keys() - {"constraint_gap"}:
                assert_near(other[name], one[name], 1e-8 * max(1.0, abs(one[name])))


@formulations
def test_two_drives_close_a_loop(formulation):
    """A five-bar: two cranks driven at the ground, one of them behind the loop; the tip where two circles meet."""

    def bar(length):
        return {
            "mass": 1.0,
            "com": [length / 2, 0, 0],
            "inertia": [0.1] * 3,
            "marker": {"end": {"position": [length, 0, 0]}},
        }

    pin = {"revolute": {}}
    scene = {
        "name": "five bar",
        "ground": {"marker": {"far": {"position": [1, 0, 0]}}},
        "gravity": [0, -9.81, 0],
        "solver": {"integrator": "rk853", "tolerance": 1e-11, "formulation": formulation},
        "body": {"a": bar(0.3), "b": bar(1.0), "c": bar(1.0), "d": bar(0.3)},
        "joint": {
            "left": pin | {"between": ["ground", "a"], "driver": {"constant_speed": 3.0}},
            "right": pin
            | {"between": ["ground.far", "d"], "driver": {"harmonic": {"amplitude": 1.0, "frequency": 1.0}}},
            "ab": pin | {"between": ["a.end", "b"], "start": {"angle": 1.0}},
            "dc": pin | {"between": ["d.end", "c"], "start": {"angle": 2.0}},
            "tip": pin | {"between": ["b.end", "c.end"]},
        },
        "measure": {"tip": {"between": ["ground", "b.end"], "output": ["position"]}},
    }
    instance = Instance(compile_scene(Scene.model_validate(scene)))

    for _ in range(20):
        instance.step(0.1)
        t = instance.time
        left = 0.3 * np.array([np.cos(3 * t), np.sin(3 * t)])
        angle = np.sin(2 * np.pi * t)
        right = [1, 0] + 0.3 * np.array([np.cos(angle), np.sin(angle)])
        middle, span = (left + right) / 2, right - left
        half = np.hypot(*span) / 2
        tip = middle + np.sqrt(1 - half**2) / (2 * half) * np.array([-span[1], span[0]])
        assert_near(instance.outputs()[:2], tip, 1e-11)


# assembly


@formulations
def test_given_start_values_are_kept(formulation):
    """From an approximate start: the crank's angle and speed are given, the others adapt."""
    scene = four_bar({}, formulation, start=False)
    scene["joint"]["crank"]["start"] = {"angle": 0.9, "speed": 2.0}
    y = outputs_by_name(Instance(compile_scene(Scene.model_validate(scene))))
    assert_near([y["crank.angle"], y["crank.speed"]], [0.9, 2.0], 1e-12)
    assert y["constraint_gap"] < 1e-13


@formulations
def test_a_start_that_fits_nowhere_gives_way(formulation):
    """All angles given, and wrongly: the loop closes near them."""
    scene = four_bar({}, formulation)
    scene["joint"]["crank"]["start"] = {"angle": 0.7}
    scene["joint"]["rocker"]["start"]["angle"] += 0.1
    y = outputs_by_name(Instance(compile_scene(Scene.model_validate(scene))))
    assert y["constraint_gap"] < 1e-13
    assert 0.4 < y["crank.angle"] < 0.9


@formulations
def test_a_loop_that_cannot_close_names_its_joint(formulation):
    scene = four_bar({}, formulation, start=False)
    scene["body"]["coupler"]["marker"]["end"]["position"] = [5, 0, 0]

    with pytest.raises(SimulationError, match="cannot be closed at (last|coupler|rocker|crank)"):
        Instance(compile_scene(Scene.model_validate(scene)))


def test_a_free_joint_with_a_start_is_kept_in_the_tree():
    """Where it stands is where its body starts, though joints of fewer freedoms hold the body as well."""
    body = {"mass": 1.0, "inertia": [0.1] * 3, "marker": {"a": {"position": [0, 0, 0.3]}}}
    ground = {"marker": {"site": {"position": [2, 1, 0.3]}}}
    scene = {
        "name": "held",
        "ground": ground,
        "body": {"body": body},
        "joint": {
            "free": {
                "free": {},
                "between": ["ground", "body"],
                "start": {
                    "position": [2, 1, 0],
                    "axis_angle": {"axis": "z", "angle_deg": 50},
                    "omega": [0, 0, 1],
                },
                "output": ["position", "zyx", "omega"],
            },
            "cross": {"universal": {"axes": ["z", "y"]}, "between": ["ground.site", "body.a"]},
        },
    }
    y = Instance(compile_scene(Scene.model_validate(scene))).outputs()
    assert_near(y, [2, 1, 0, np.deg2rad(50), 0, 0, 0, 0, 1], 1e-12)


@formulations
def test_a_constraint_within_a_rigid_part_says_nothing(formulation):
    """A rod between two bodies that are fixed together, once without and once with a reaction asked for."""
    for output in ([], ["reaction_force"]):
        body = {"mass": 1.0, "inertia": [0.1] * 3}
        scene = {
            "name": "rigid",
            "body": {"a": body, "b": body},
            "joint": {
                "hinge": {
                    "revolute": {"axis": "y"},
                    "between": ["ground", "a"],
                    "start": {"speed": 1.0},
                    "output": ["acceleration"],
                },
                "weld": {"fixed": {}, "between": ["a", "b.m"], "output": output},
                "rod": {"distance": {}, "between": ["a.m", "b"]},
                "ball": {"spherical": {}, "between": ["a", "b.m"]},
            },
            "solver": {"formulation": formulation},
        }
        scene["body"]["a"] = body | {"marker": {"m": {"position": [0.2, 0.1, 0]}}}
        scene["body"]["b"] = body | {"marker": {"m": {"position": [-0.7, 0, 0.1]}}}
        instance = Instance(compile_scene(Scene.model_validate(scene)))
        inertia = 0.1 + 0.1 + 0.7**2 + 0.1**2
        assert_near(instance.outputs()[0], 9.81 * 0.7 / inertia, 1e-10)


@formulations
@pytest.mark.parametrize(
    "motion",
    [
        {"acceleration": [1, 2, 3], "position": [4, 5, 6]},
        {"rotation": {"speed": 0.5, "angle": 0.7, "point": [1, 2, 3]}},
        {"orbit": {"radius": 5.0, "rate": 0.1, "phase_deg": 30, "normal": "y"}},
        {
            "elliptic_orbit": {
                "semi_major_axis": 5.0,
                "eccentricity": 0.6,
                "mu": 2.0,
                "node_deg": 40,
                "mean_anomaly_deg": -50,
            }
        },
        {"table": {"time": [-1, 0, 1, 2], "position": [[0, 0, 0], [1, 0, 2], [1, 1, 1], [0, 0, 0]]}},
        {"input": True},
    ],
)
def test_lengths_at_the_start_on_a_moving_ground(motion, formulation):
    """The rod from the inertial frame to a body on the moving ground is as long as the way is at the start."""
    scene = {
        "name": "moving",
        "ground": {"motion": motion},
        "body": {"bob": {"mass": 1.0, "inertia": [0.1] * 3}},
        "joint": {
            "hold": {
                "translation": {},
                "between": ["ground", "bob"],
                "start": {"position": [0.5, -1, 2]},
                "output": ["position"],
            },
            "rod": {"distance": {}, "between": ["inertial", "bob"]},
        },
        "solver": {"formulation": formulation},
    }
    assert_near(Instance(compile_scene(Scene.model_validate(scene))).outputs(), [0.5, -1, 2], 1e-12)
