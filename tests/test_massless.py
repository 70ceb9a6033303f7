"""Parts without mass or without inertia, moved by constraints, couplings, drives: closed forms, in three formulations."""

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from loop_scenes import LOOP, random_loops, with_solver
from scenes import assert_near, body_motion, examples

from mbdfmi import Scene, SceneError
from mbdfmi.compiler.model import compile_scene
from mbdfmi.kernels.dynamics import massless, multipliers, rates
from mbdfmi.kernels.status import OK
from mbdfmi.run.instance import Instance, SimulationError

formulations = pytest.mark.parametrize("formulation", ["recursive", "embedding", "augmented"])
G = 9.81


def point(mass, **more):
    """A point mass."""
    return {"mass": mass, "inertia": [0, 0, 0]} | more


def at(x, y=0.0, z=0.0):
    """A marker."""
    return {"position": [x, y, z]}


# pulleys


@formulations
@pytest.mark.parametrize("m1, m2, m3", [(1.0, 2.0, 3.0), (0.3, 5.0, 0.01), (40.0, 1e-3, 7.0)])
def test_a_pulley_that_only_a_rope_moves(formulation, m1, m2, m3, check):
    """Atwood's double machine: the mass that balances the pulley is 4 m1 m2 / (m1 + m2)."""

    def slide(a, b):
        return {"prismatic": {"axis": "z"}, "between": [a, b], "output": ["acceleration"]}

    def rope(a, b):
        return {"linear": {"ratio": -1}, "between": [a, b]}

    scene = Scene(
        name="pulleys",
        solver={"formulation": formulation},
        body={"m3": point(m3), "pulley": {"mass": 0}, "m1": point(m1), "m2": point(m2)},
        joint={
            "j3": slide("ground", "m3"),
            "jp": slide("ground", "pulley"),
            "j1": slide("pulley", "m1"),
            "j2": slide("pulley", "m2"),
        },
        coupling={"upper": rope("j3", "jp"), "lower": rope("j1", "j2")},
        output=["total_energy"],
    )
    r = scene.simulate(until=0.2, step=0.1)
    balance = 4 * m1 * m2 / (m1 + m2)
    a = G * (balance - m3) / (balance + m3)
    check(np.abs(r["j3.acceleration"] - a).max(), 1e-10 * G)
    relative = (G + -a) * (m2 - m1) / (m1 + m2)
    check(np.abs(r["j1.acceleration"] - relative).max(), 1e-9 * G)
    check(np.ptp(r["total_energy"]), 1e-9 * G)


# a rod without mass bears a force along itself alone


def crank_and_rod(formulation, joints="revolute", **rod):
    """Crank 0.2 m, rod 0.5 m, slider on x; the rod without mass unless told otherwise."""
    return Scene(
        name="crank",
        solver={"formulation": formulation},
        gravity=[0, -G, 0],
        body={
            "crank": {"mass": 1, "inertia": [0.01] * 3, "com": [0.05, 0, 0], "marker": {"e": at(0.2)}},
            "rod": {"mass": 0, "marker": {"e": at(0.5)}} | rod,
            "slider": {"mass": 2, "inertia": [0.01] * 3},
        },
        joint={
            "crank": {
                "revolute": {},
                "between": ["ground", "crank"],
                "start": {"angle": 0.7, "speed": 6.0},
                "output": ["angle", "speed", "acceleration"],
            },
            "pin": {
                joints: {},
                "between": ["crank.e", "rod"],
                "output": ["reaction_force_body", "reaction_moment_body"],
            },
            "rail": {
                "prismatic": {"axis": "x"},
                "between": ["ground", "slider"],
                "start": {"position": float(slider_of(0.7)[0])},
                "output": ["position", "speed", "acceleration"],
            },
            "wrist": {joints: {}, "between": ["rod.e", "slider"]},
        },
        output=["total_energy", "constraint_gap"],
    )


def slider_of(angle, r=0.2, l=0.5):
    """Position of the slider and its first two derivatives by the crank's angle."""
    s, c = np.sin(angle), np.cos(angle)
    w = np.sqrt(l**2 - (r * s) ** 2)
    w1 = -(r**2) * s * c / w
    w2 = -(r**2) * (c * c - s * s) / w - w1**2 / w
    return r * c + w, -r * s + w1, -r * c + w2


@formulations
@pytest.mark.parametrize("joints", ["revolute", "spherical"])
def test_a_connecting_rod_without_mass(formulation, joints, check):
    """The crank's angle obeys (J + M x'^2) a'' + M x' x'' a'^2 = -m g c cos a; the rod's force is along it and drives the slider."""
    r = crank_and_rod(formulation, joints).simulate(until=0.5, step=0.05)
    angle, speed = r["crank.angle"], r["crank.speed"]
    x, x1, x2 = slider_of(angle)
    J = 0.01 + 0.05**2
    expected = (-G * 0.05 * np.cos(angle) - 2 * x1 * x2 * speed**2) / (J + 2 * x1**2)
    check(np.abs(r["crank.acceleration"] - expected).max(), 1e-8)
    check(np.abs(r["rail.position"] - x).max(), 1e-10)
    check(np.ptp(r["total_energy"]), 1e-6)

    # on the rod, in its own axes: from the crank
    force = r["pin.reaction_force_body"]
    check(np.abs(force[:, 1:]).max(), 1e-8)
    check(np.abs(r["pin.reaction_moment_body"][:, 2]).max(), 1e-8)
    along = (x - 0.2 * np.cos(angle)) / 0.5
    check(np.abs(force[:, 0] * along - 2 * r["rail.acceleration"]).max(), 1e-7)


@formulations
def test_a_rod_without_inertia_about_itself_moves_as_one_with(formulation, check):
    """Between two ball joints nothing turns a rod about itself: its inertia there is of no account."""
    runs = [
        crank_and_rod(
            formulation, "spherical", mass=0.4, com=[0.25, 0, 0], inertia=[axial, 0.01, 0.01]
        ).simulate(0.3, 0.05)
        for axial in (0.0, 5e-3)
    ]

    for name in ("crank.angle", "rail.acceleration", "pin.reaction_force_body"):
        check(np.abs(runs[0][name] - runs[1][name]).max(), 1e-6)


@formulations
@pytest.mark.parametrize("axes", [[0, 0, 0], [20, -35, 70]])
def test_a_thin_rod_on_a_ball_joint(formulation, axes, check):
    """A spherical pendulum: energy and the moment of momentum about the vertical stay; at rest it swings as a plane one."""
    rod = {
        "mass": 1.2,
        "com": [0, 0, -0.4],
        "inertia": [0.064, 0.064, 0.0],
        "output": ["omega", "euler_parameters"],
    }
    scene = Scene(
        name="rod",
        solver={"formulation": formulation},
        ground={"marker": {"site": {"zyx_deg": axes}}},
        body={"rod": rod | {"marker": {"site": {"zyx_deg": axes}}}},
        joint={
            "ball": {
                "spherical": {},
                "between": ["ground.site", "rod.site"],
                "start": {"omega": [0.4, 0.3, 1.0]},
            }
        },
        output=["total_energy", "angular_momentum"],
    )
    r = scene.simulate(until=1.0, step=0.1)
    check(np.ptp(r["total_energy"]), 1e-7)
    check(np.ptp(r["angular_momentum[3]"]), 1e-7)


# point masses


@formulations
def test_two_point_masses_on_links_without_mass(formulation, check):
    """The double pendulum of the textbooks."""
    l1, l2, m1, m2 = 0.7, 0.4, 1.5, 0.6

    def hinge(a, b, angle):
        start = {"angle": angle, "speed": 1.0}
        return {
            "revolute": {},
            "between": [a, b],
            "start": start,
            "output": ["angle", "speed", "acceleration"],
        }

    scene = Scene(
        name="double",
        solver={"formulation": formulation},
        gravity=[0, -G, 0],
        body={"a": point(m1, com=[0, -l1, 0], marker={"e": at(0, -l1)}), "b": point(m2, com=[0, -l2, 0])},
        joint={"one": hinge("ground", "a", 0.5), "two": hinge("a.e", "b", 0.8)},
    )
    r = scene.simulate(until=0.6, step=0.1)
    p, q = r["one.angle"], r["one.angle"] + r["two.angle"]
    u, v = r["one.speed"], r["one.speed"] + r["two.speed"]

    for k in range(len(p)):
        c, s = np.cos(p[k] - q[k]), np.sin(p[k] - q[k])
        M = [[(m1 + m2) * l1, m2 * l2 * c], [l1 * c, l2]]
        f = [-m2 * l2 * s * v[k] ** 2 - (m1 + m2) * G * np.sin(p[k]), l1 * s * u[k] ** 2 - G * np.sin(q[k])]
        one, both = np.linalg.solve(M, f)
        check(abs(r["one.acceleration"][k] - one), 1e-9)
        check(abs(r["two.acceleration"][k] - (both - one)), 1e-9)


@formulations
@pytest.mark.parametrize("joint", ["spherical", "revolute"])
def test_a_particle_at_the_end_of_a_link(formulation, joint, check):
    """A link without mass, a particle on its end by a joint of its own: a simple pendulum, the particle turns as it did."""
    hinge = {"revolute": {}, "start": {"angle": 1.0}, "output": ["angle", "acceleration"]}
    end = {"revolute": {"axis": "x"}} if joint == "revolute" else {"spherical": {}}
    bead = point(2.0) if joint == "spherical" else {"mass": 2.0, "inertia": [1e-3, 0, 0]}
    scene = Scene(
        name="bead",
        solver={"formulation": formulation},
        gravity=[0, -G, 0],
        body={"link": {"mass": 0, "marker": {"e": at(0, -0.6)}}, "bead": bead | {"output": ["omega"]}},
        joint={
            "hinge": hinge | {"between": ["ground", "link"]},
            "end": end | {"between": ["link.e", "bead"]},
        },
    )
    r = scene.simulate(until=0.5, step=0.1)
    check(np.abs(r["hinge.acceleration"] + G / 0.6 * np.sin(r["hinge.angle"])).max(), 1e-9)


@formulations
@pytest.mark.parametrize("com", [[0, 0, 0], [0.3, -0.2, 0.7]])
@pytest.mark.parametrize("omega", [[0, 0, 0], [1.0, -2.0, 0.5]])
def test_a_particle_falls(formulation, com, omega, check):
    """Its place is that of a thrown stone; how its frame turns does not change."""
    scene = Scene(
        name="stone",
        solver={"formulation": formulation},
        body={
            "stone": point(
                0.2, com=com, marker={"c": {"position": com, "output": ["position"]}}, output=["omega"]
            )
        },
        joint={
            "free": {
                "free": {},
                "between": ["ground", "stone"],
                "start": {"velocity": [1, 2, 3], "omega": omega},
            },
        },
    )
    r = scene.simulate(until=1.0, step=0.1)
    start = np.array([1, 2, 3]) + np.cross(omega, com)
    fall = np.outer(r["time"], start) + np.outer(r["time"] ** 2 / 2, [0, 0, -G]) + np.array(com)
    check(np.abs(r["stone.c.position"] - fall).max(), 1e-7)
    check(np.abs(r["stone.omega"] - omega).max(), 1e-9)


# frames


@formulations
def test_driven_frames_without_mass(formulation, check):
    """A gyro in two driven rings: to turn its spin about z the inner ring's drive bears I spin speed."""
    spin, speed, I = 50.0, 2.0, 4e-3
    scene = Scene(
        name="gyro",
        solver={"formulation": formulation},
        gravity=[0, 0, 0],
        body={"outer": {"mass": 0}, "inner": {"mass": 0}, "rotor": {"mass": 1, "inertia": [I, 3e-3, 3e-3]}},
        joint={
            "outer": {
                "revolute": {"axis": "z"},
                "between": ["ground", "outer"],
                "driver": {"constant_speed": speed},
            },
            "inner": {
                "revolute": {"axis": "y"},
                "between": ["outer", "inner"],
                "driver": {"harmonic": {"amplitude": 0.4, "frequency": 1.0}},
                "output": ["effort", "angle", "speed", "acceleration"],
            },
            "spin": {
                "revolute": {"axis": "x"},
                "between": ["inner", "rotor"],
                "start": {"speed": spin},
                "output": ["speed"],
            },
        },
    )
    r = scene.simulate(until=0.5, step=0.1)
    tilt, w = r["inner.angle"], r["spin.speed"]
    along = w - speed * np.sin(tilt)
    check(np.ptp(along), 1e-7)

    # Lagrange: J b'' - d/db of the kinetic energy, with w_x = along, w_z = speed cos b
    J = 3e-3
    expected = (
        J * r["inner.acceleration"]
        + I * along * speed * np.cos(tilt)
        + J * speed**2 * np.cos(tilt) * np.sin(tilt)
    )
    check(np.abs(r["inner.effort"] - expected).max(), 1e-9)


@formulations
def test_a_rocker_and_a_coupler_without_mass(formulation, check):
    """A four-bar whose crank alone has inertia: it goes round at its speed."""
    bar = {"mass": 0}
    scene = Scene(
        name="four",
        solver={"formulation": formulation},
        gravity=[0, -G, 0],
        ground={"marker": {"r": at(2.0)}},
        body={
            "crank": {"mass": 1, "inertia": [0.1] * 3, "marker": {"e": at(0.5)}},
            "coupler": bar | {"marker": {"e": at(2.0)}},
            "rocker": bar | {"marker": {"e": at(1.5)}},
        },
        joint={
            "crank": {
                "revolute": {},
                "between": ["ground", "crank"],
                "start": {"angle_deg": 60, "speed": 3},
                "output": ["angle"],
            },
            "ab": {"revolute": {}, "between": ["crank.e", "coupler"]},
            "rocker": {"revolute": {}, "between": ["ground.r", "rocker"], "start": {"angle_deg": 100}},
            "bc": {"revolute": {}, "between": ["coupler.e", "rocker.e"]},
        },
        output=["kinetic_energy", "constraint_gap"],
    )
    r = scene.simulate(until=2.0, step=0.2)
    check(np.abs(r["crank.angle"] - r["crank.angle"][0] - 3 * r["time"]).max(), 1e-6)
    check(np.abs(r["kinetic_energy"] - 0.45).max(), 1e-7)


# what nothing determines

UNDETERMINED = {
    "hinge": ({"mass": 0}, {"revolute": {}}),
    "slide": ({"mass": 0}, {"prismatic": {}}),
    "ball": ({"mass": 0}, {"spherical": {}}),
    "free": ({"mass": 0}, {"free": {}}),
    "wheel": (point(1.0), {"revolute": {}}),
    "axle": ({"mass": 1.0, "inertia": [0.1, 0.1, 0.0]}, {"revolute": {}}),
    "sprung": ({"mass": 0}, {"prismatic": {}, "spring": {"stiffness": 5.0, "rest": 1.0}}),
    "pushed": ({"mass": 0, "input": ["force"]}, {"translation": {}}),
}


@formulations
@pytest.mark.parametrize("case", UNDETERMINED)
def test_what_nothing_determines_is_named(formulation, case):
    body, joint = UNDETERMINED[case]
    scene = Scene(
        name=case,
        solver={"formulation": formulation},
        body={"stand": {"mass": 3, "inertia": [1, 1, 1]}, "loose": body},
        joint={
            "rail": {"prismatic": {"axis": "x"}, "between": ["ground", "stand"], "start": {"speed": 1.0}},
            "j": joint | {"between": ["stand", "loose"]},
        },
    )

    with pytest.raises((SimulationError, SceneError), match="inertia about the joint of loose"):
        scene.simulate(until=0.1, step=0.05)


@formulations
def test_a_moment_about_a_thin_rod_is_refused(formulation):
    rod = {
        "mass": 1,
        "com": [0, 0, -0.5],
        "inertia": [0.1, 0.1, 0.0],
        "input": ["moment"],
        "input_axes": "body",
    }
    scene = Scene(
        name="rod",
        solver={"formulation": formulation},
        body={"rod": rod},
        joint={"ball": {"spherical": {}, "between": ["ground", "rod"]}},
    )
    scene.simulate(until=0.1, step=0.1, inputs={"rod.moment": [0.1, 0.2, 0.0]})

    with pytest.raises(SimulationError, match="inertia about the joint of rod"):
        scene.simulate(until=0.1, step=0.1, inputs={"rod.moment": [0.0, 0.0, 0.01]})


# random mechanisms


def without_inertia(scene, rng):
    """The scene with some parts made frames without mass, point masses, or rods."""
    for body in list(scene["body"].values())[1:]:
        kind = rng.integers(5)

        if kind == 0:
            body |= {"mass": 0.0}
            del body["inertia"], body["inertia_axes"], body["com"]
        elif kind == 1:
            body["inertia"] = [0, 0, 0]
        elif kind == 2:
            body["inertia"] = [0.1, 0.1, 0]

    return scene


@examples
@given(
    st.integers(0, 2**32 - 1),
    st.lists(st.sampled_from(sorted(LOOP)), min_size=1, max_size=3),
    st.integers(0, 2),
)
def test_random_mechanisms_move_alike_or_are_all_refused(seed, loops, couplings):
    rng = np.random.default_rng(seed)
    scene = without_inertia(random_loops(seed, loops, couplings=couplings), rng)
    seen = []

    for formulation in ("recursive", "embedding", "augmented"):
        try:
            instance = Instance(compile_scene(with_solver(scene, formulation=formulation)))
            instance.outputs()
        except (SimulationError, SceneError):
            seen.append(None)
            continue

        if rates.evaluate(instance.m, instance.d, 0.0) != OK:
            seen.append(None)
            continue

        m, d = instance.m, instance.d
        motion = body_motion(instance, accelerated=True)
        seen.append(np.array([motion[name][5] for name in scene["body"] if scene["body"][name]["mass"]]))
        assert (
            np.abs([multipliers.row_acceleration(m, d, row) for row in range(m.n_row)]).max(initial=0.0)
            < 1e-8
        )

    refused = [a is None for a in seen]
    assert all(refused) or not any(refused)

    for a in seen[1:] if not refused[0] else ():
        assert_near(a, seen[0], 1e-7 * max(1.0, np.abs(seen[0]).max()))


# inertia of no real body


@formulations
@pytest.mark.parametrize("inertia", [[0.066, 0.086, 0.0125], [0.0, 0.02, 0.0], [3.0, 1.0, 1.5]])
def test_an_inertia_that_no_body_has_is_taken_as_it_is(formulation, inertia, check):
    """Told, not refused: a torque about y turns it by the moment of inertia given."""
    scene = Scene(
        name="link",
        gravity=[0, 0, 0],
        solver={"formulation": formulation},
        body={"link": {"mass": 4.8, "inertia": inertia}},
        joint={
            "j": {
                "revolute": {"axis": "y"},
                "between": ["ground", "link"],
                "input": "torque",
                "output": ["acceleration"],
            }
        },
    )
    r = scene.simulate(until=0.1, step=0.05, inputs={"j.torque": 0.3})
    check(np.abs(r["j.acceleration"] - 0.3 / inertia[1]).max(), 1e-9)
    assert any("[body.link] inertia" in notice for notice in r.notices)


def test_a_part_without_mass_at_the_centre_of_gravity():
    """It has no weight there; the planet's moon hangs on it by a driven arm."""
    data = {
        "name": "hub",
        "central_gravity": {"mu": 4.0},
        "body": {
            "hub": {"mass": 0.0, "inertia": [0, 0, 1.0], "output": ["alpha"]},
            "moon": {"mass": 1.0, "inertia": [1, 1, 1]},
        },
        "joint": {
            "turn": {"revolute": {}, "between": ["inertial", "hub"], "start": {"speed": 0.5}},
            "arm": {
                "prismatic": {"axis": "x"},
                "between": ["hub", "moon"],
                "start": {"position": 2.0},
                "output": ["acceleration"],
            },
        },
        "output": ["gravity_energy"],
    }
    found = Instance(compile_scene(Scene(**data))).outputs()
    assert found == pytest.approx([2 * 0.25 - 1.0, 0, 0, 0, -2.0], abs=1e-14)


# how it is done


@pytest.mark.parametrize("formulation", ["recursive", "embedding"])
@pytest.mark.parametrize("joint", ["revolute", "prismatic"])
def test_what_an_effort_in_a_joint_moves(formulation, joint):
    """The response to a unit effort, by which it is found what determines parts, is what an effort of 1 changes."""
    bar = {"mass": 2.0, "com": [0.4, 0.1, 0.0], "inertia": [0.3, 0.2, 0.5]}
    scene = Scene(
        name="arms",
        solver={"formulation": formulation},
        body={"a": bar | {"marker": {"end": at(0.9, -0.2, 0.1)}}, "b": bar},
        joint={
            "root": {"revolute": {}, "between": ["ground", "a"], "start": {"angle": 0.3, "speed": 0.5}},
            "own": {joint: {"axis": [0.36, 0.48, 0.8]}, "between": ["a.end", "b"],
                    "input": "torque" if joint == "revolute" else "force"},
        },
    )  # fmt: skip
    i = Instance(compile_scene(scene))
    found = []

    for effort in (1.0, 0.0):
        i.u[0] = effort
        assert rates.evaluate(i.m, i.d, 0.0) == OK
        found.append(i.d.v_rate.copy())

    rate = massless.push_joint(i.m, i.d, 2, 0)
    np.testing.assert_allclose(i.d.change[: i.m.n_v], found[0] - found[1], atol=1e-13)
    assert rate == i.d.change[1] > 0.0


def test_what_was_found_to_be_determined_is_not_asked_again():
    """A rod without mass between a crank and a slider: once for all of a run."""
    i = Instance(compile_scene(crank_and_rod("recursive")))
    i.outputs()
    lent = i.d.lent_mass > 0.0
    assert lent.any() and np.all(i.d.lent_known[lent] == 1.0)
