"""Rotors that turn with joints: closed forms, and the same rotors as bodies of their own, geared to the joints."""

import numpy as np
import pytest
from loop_scenes import random_loops
from scenes import assert_near, evaluate, inverse_dynamics, mass_matrix, random_scene, velocities

from mbdfmi import Scene, SceneError
from mbdfmi.compiler.model import compile_scene
from mbdfmi.export.description import description
from mbdfmi.run.instance import Instance, SimulationError
from mbdfmi.scene.fields import unit_vector
from mbdfmi.units import UNITS

FORMULATIONS = ("recursive", "embedding", "augmented")
TIGHT = {"tolerance": 1e-13}


def outputs_of(instance):
    """Outputs now by name."""
    return dict(zip([v.name for v in instance.model.of_causality("output")], instance.outputs().copy()))


def run(data, end, formulation="recursive", u=()):
    """Outputs at a time by name."""
    instance = Instance(
        compile_scene(Scene.model_validate(data | {"solver": TIGHT | {"formulation": formulation}}))
    )
    instance.u[: len(u)] = u
    instance.step(end)
    return outputs_of(instance)


def two_bodies(reverse, inertia=0.3, ratio=7.0):
    """A hub and an arm that float, on a hinge about z with a rotor; the hub bears it, unless `reverse`."""
    ends = ["hub", "arm"]
    return {
        "name": "two bodies",
        "gravity": [0, 0, 0],
        "body": {
            "hub": {"mass": 1.0, "inertia": [1.0, 1.0, 2.0], "output": ["omega", "alpha"]},
            "arm": {"mass": 1.0, "inertia": [1.0, 1.0, 1.5], "output": ["omega"]},
        },
        "joint": {
            "loose": {"free": {}, "between": ["ground", "hub"]},
            "hinge": {
                "revolute": {},
                "between": ends[::-1] if reverse else ends,
                "input": "torque",
                "turning": {"inertia": inertia, "ratio": ratio},
                "output": ["angle", "speed", "acceleration", "reaction_moment", "input_effort"],
            },
        },
        "output": ["kinetic_energy", "angular_momentum"],
    }


@pytest.mark.parametrize("formulation", FORMULATIONS)
@pytest.mark.parametrize("reverse", [False, True])
def test_a_motor_between_two_floating_bodies(reverse, formulation):
    """M (wa', v') = (0, T) with the host's inertia A, the other's B: [A + B, B + nJ; B + nJ, B + n^2 J]."""
    J, n, T, t = 0.3, 7.0, 2.0, 1.5
    A, B = (1.5, 2.0) if reverse else (2.0, 1.5)
    M = np.array([[A + B, B + n * J], [B + n * J, B + n * n * J]])
    wa, v = np.linalg.solve(M, [0.0, T]) * t
    y = run(two_bodies(reverse, J, n), t, formulation, [T])
    host, other = ("arm", "hub") if reverse else ("hub", "arm")
    assert_near(y["hinge.angle"], 0.5 * v * t, 1e-10)
    assert_near(y["hinge.speed"], v, 1e-10)
    assert_near(y[f"{host}.omega[3]"], wa, 1e-10)
    assert_near(y[f"{other}.omega[3]"], wa + v, 1e-10)
    assert_near(y["hinge.reaction_moment[3]"], B * (wa + v) / t, 1e-10)
    assert_near(y["kinetic_energy"], 0.5 * np.array([wa, v]) @ M @ [wa, v], 1e-10)
    assert_near(y["angular_momentum[3]"], 0.0, 1e-10)


@pytest.mark.parametrize("formulation", FORMULATIONS)
@pytest.mark.parametrize("reverse", [False, True])
def test_a_gyrostat_precesses(reverse, formulation):
    """Of a sphere I with a rotor of constant momentum h about z the angular velocity turns at h / I about z, in its own axes."""
    I, J, ratio, speed, small, w0, wz, t = 2.0, 0.05, 20.0, 3.0, 0.1, 0.4, 0.3, 4.0
    data = two_bodies(reverse, J, ratio)
    hinge = data["joint"]["hinge"]
    host, other = ("arm", "hub") if reverse else ("hub", "arm")
    data["body"][host] = {"mass": 1.0, "inertia": [I - small] * 3, "output": ["omega_body"]}
    data["body"][other] = {"mass": 1.0, "inertia": [small] * 3}
    loose = {
        "free": {},
        "between": ["ground", host],
        "start": {"omega": [w0, 0.0, wz], "velocity": [0.1, 0.2, 0.3]},
    }
    data["joint"] = {"loose": loose, "hinge": {key: hinge[key] for key in ("revolute", "between", "turning")}}
    data["joint"]["hinge"] |= {"driver": {"constant_speed": speed}}
    rate = (ratio * J + small) * speed / I
    y = run(data, t, formulation)
    found = [y[f"{host}.omega_body[{k}]"] for k in (1, 2, 3)]
    assert_near(found, [w0 * np.cos(rate * t), w0 * np.sin(rate * t), wz], 1e-10)


@pytest.mark.parametrize("formulation", FORMULATIONS)
def test_a_winch_on_a_turning_frame(formulation):
    """A slide along z with a rotor of n rad/m: its mass counts n^2 J more, and its push turns the frame by -n J v / I."""
    J, n, force, t = 0.02, 30.0, 4.0, 1.2
    data = {
        "name": "winch",
        "gravity": [0, 0, -9.81],
        "body": {
            "frame": {"mass": 1.0, "inertia": [1.0, 1.0, 0.5]},
            "load": {"mass": 3.0, "inertia": [0.1, 0.1, 0.2]},
        },
        "joint": {
            "turn": {"revolute": {}, "between": ["ground", "frame"], "output": ["speed"]},
            "lift": {
                "prismatic": {},
                "between": ["frame", "load"],
                "turning": {"inertia": J, "ratio": n},
                "input": "force",
                "output": ["speed"],
            },
        },
    }
    M = np.array([[0.7, n * J], [n * J, 3.0 + n * n * J]])
    expected = np.linalg.solve(M, [0.0, force - 3.0 * 9.81]) * t
    y = run(data, t, formulation, [force])
    assert_near([y["turn.speed"], y["lift.speed"]], expected, 1e-10)


def with_rotors(data, seed):
    """(scene with rotors that turn with its joints, the same with the rotors as bodies without mass, geared to them).

    Of the second the bodies are those of `data`; in the first the bodies that bear rotors have their inertia too.
    """
    rng = np.random.default_rng(seed)
    scene = Scene.model_validate(data)
    told = {name: dict(body) for name, body in data["body"].items()}
    more = {name: body.mass_properties()[2] for name, body in scene.body.items()}
    whole, apart = ({**data, "joint": dict(data["joint"]), "body": told} for _ in range(2))
    apart |= {"body": dict(told), "coupling": dict(data.get("coupling", {}))}

    for name, joint in data["joint"].items():
        kind = next((kind for kind in ("revolute", "prismatic") if kind in joint), None)

        if kind is None or name.startswith("loop") or rng.random() < 0.3:
            continue

        J, n = rng.uniform(0.1, 1.0), rng.choice([-1, 1]) * rng.uniform(0.3, 5.0)
        end = joint["between"][0]
        axis = joint[kind].get("axis", "z")
        a = unit_vector(axis)
        inertia = 0.5 * J * (np.eye(3) + np.outer(a, a))
        body, _, A = scene.marker_pose(end)

        if body in more:
            more[body] = more[body] + A @ inertia @ A.T

        whole["joint"][name] = joint | {"turning": {"inertia": J, "ratio": n}}
        apart["body"][f"rotor {name}"] = {
            "mass": 0.0,
            "inertia": inertia[[0, 1, 2, 0, 0, 1], [0, 1, 2, 1, 2, 2]].tolist(),
        }
        start = joint.get("start", {})
        angle, speed = n * start.get("angle", start.get("position", 0.0)), n * start.get("speed", 0.0)
        spin = {
            "revolute": {"axis": axis},
            "between": [end, f"rotor {name}"],
            "start": {"angle": angle, "speed": speed},
        }
        apart["joint"][f"spin {name}"] = spin
        apart["coupling"][f"gear {name}"] = {"linear": {"ratio": n}, "between": [name, f"spin {name}"]}

    for name, inertia in more.items():
        rest = {key: value for key, value in told[name].items() if key != "inertia_axes"}
        told[name] = rest | {"inertia": inertia[[0, 1, 2, 0, 0, 1], [0, 1, 2, 1, 2, 2]].tolist()}

    return whole, apart


def asked(data, seed):
    """Drives in some joints, and outputs of all that accelerates and passes through joints."""
    rng = np.random.default_rng(seed)

    for name, joint in data["joint"].items():
        kind = next((kind for kind in ("revolute", "prismatic") if kind in joint), None)

        if kind and not name.startswith("loop"):
            joint["output"] = ["acceleration", "reaction_force", "reaction_moment"]

            if "loop0" not in data["joint"] and rng.random() < 0.25:
                joint["driver"] = {"harmonic": {"amplitude": 0.7, "frequency": 0.5}}
                joint.pop("start", None)
                joint.pop("input", None)
                joint["output"].append("driver_effort")

    for body in data["body"].values():
        body["output"] = ["alpha", "acceleration"]

    data["ground"] = data.get("ground", {}) | {"output": ["reaction_force", "reaction_moment"]}
    return data | {
        "output": ["kinetic_energy", "total_energy", "angular_momentum", "linear_momentum", "driver_power"]
    }


def instance_of(data, formulation):
    """A run at its start with inputs of 0.3."""
    solver = {"formulation": formulation, "tolerance": 1e-10}
    instance = Instance(compile_scene(Scene.model_validate(data | {"solver": solver})))
    instance.u[: instance.model.n_u] = 0.3
    return instance


def random_tree(seed, **options):
    """A random tree as a dict, all told."""
    scene = random_scene(seed, 2 + seed % 5, kinds=("revolute", "prismatic", "spherical", "free"), **options)
    data = asked(scene.model_dump(exclude_unset=True), seed)

    if seed % 3 == 0:
        data["ground"]["motion"] = {
            "rotation": {"axis": [0.2, 1, 0.3], "speed": 0.7, "point": [0.1, 0.2, 0.3]}
        }

    return data


def assert_same(found, expected, names, relative):
    """Outputs equal to within `relative` of the largest."""
    size = 1.0 + max(abs(expected[name]) for name in names)

    for name in names:
        assert abs(found[name] - expected[name]) < relative * size, name


@pytest.mark.parametrize("seed", range(12))
def test_rotors_are_bodies_geared_to_their_joints(seed):
    """Random trees, forwards and backwards, driven or not, on grounds that move: accelerations, reactions, energies, momenta."""
    whole, apart = with_rotors(random_tree(seed), seed)
    expected = outputs_of(instance_of(apart, "recursive"))

    for formulation in FORMULATIONS:
        found = outputs_of(instance_of(whole, formulation))
        assert_same(found, expected, found, 1e-9)


@pytest.mark.parametrize("seed", range(4))
def test_rotors_in_loops(seed):
    """The same with loops that other joints close."""
    data = asked(random_loops(seed, ["point_on_line"], freedoms=2), seed)
    whole, apart = with_rotors(data, seed)

    try:
        expected = outputs_of(instance_of(apart, "recursive"))
    except SimulationError as error:
        pytest.skip(str(error))

    for formulation in FORMULATIONS:
        found = outputs_of(instance_of(whole, formulation))
        assert_same(found, expected, found, 1e-8)


@pytest.mark.parametrize("seed", range(1, 9))
def test_the_mass_matrix_with_rotors(seed):
    """It is that of RNEA, by columns, and of the kinetic energy; RNEA inverts articulated bodies."""
    whole, _ = with_rotors(random_tree(seed, floating=seed % 2 == 0), seed)
    instance = instance_of(whole, "recursive")

    if any(instance.m.body_drive >= 0):
        pytest.skip("RNEA and CRBA of the tests know no drives")

    rates = evaluate(instance)[instance.m.n_q :][: instance.m.n_v]
    tau = instance.d.tau.copy()
    M, v = mass_matrix(instance), velocities(instance)
    size = np.abs(M).max() * (1.0 + np.abs(rates).max())
    assert_near(inverse_dynamics(instance, rates), tau, 1e-12 * size)
    bias = inverse_dynamics(instance, 0 * rates)
    columns = [inverse_dynamics(instance, unit) - bias for unit in np.eye(len(M))]
    assert_near(np.array(columns).T, M, 1e-12 * (size + np.abs(bias).max()))
    assert outputs_of(instance)["kinetic_energy"] == pytest.approx(0.5 * v @ M @ v, rel=1e-12)


def test_energy_and_momentum_are_kept():
    """A free chain of hinges with rotors and a spring, a second of motion."""
    data = two_bodies(False, 0.3, -4.0)
    data["joint"]["loose"]["start"] = {"omega": [1.0, 2.0, -0.5]}
    data["joint"]["hinge"] |= {
        "revolute": {"axis": [1, 1, 0]},
        "spring": {"stiffness": 3.0},
        "start": {"angle": 0.5, "speed": 1.0},
    }
    data["output"] += ["total_energy"]
    names = ["total_energy", *(f"angular_momentum[{k}]" for k in (1, 2, 3))]
    first, last = run(data, 1e-9), run(data, 1.0)
    assert_same(last, first, names, 1e-10)


def test_a_loop_of_rotors_is_told():
    """One joint of a loop must go without."""
    hinge = lambda *ends: {"revolute": {}, "between": list(ends), "turning": {"inertia": 0.1, "ratio": 5.0}}
    corner = {"end": {"position": [1, 0, 0]}}
    body = {f"bar{k}": {"mass": 1.0, "inertia": [0.1] * 3, "marker": corner} for k in range(3)}
    joint = {
        "a": hinge("ground", "bar0"),
        "b": hinge("bar0.end", "bar1"),
        "c": hinge("bar1.end", "bar2"),
        "d": hinge("bar2.end", "ground.far"),
    }
    data = {
        "name": "loop",
        "body": body,
        "joint": joint,
        "ground": {"marker": {"far": {"position": [0, 1, 0]}}},
    }

    with pytest.raises(
        SceneError, match=r'joint\.d\] turning: all joints of this loop have a rotor.*leave "turning" out'
    ):
        compile_scene(Scene.model_validate(data))

    joint["b"].pop("turning")
    assert compile_scene(Scene.model_validate(data)).tree.cuts == ["b"]


def test_a_rotor_of_negative_inertia_is_told():
    """In the scene, and of a parameter later."""
    data = two_bodies(False, inertia=-0.1)

    with pytest.raises(SceneError, match=r"joint\.hinge.*inertia"):
        Scene.model_validate(data)

    model = compile_scene(Scene.model_validate(two_bodies(False)))

    with pytest.raises(SimulationError, match="rotor that turns with the joint of arm"):
        Instance(model, parameters={"hinge.turning.inertia": -1.0})


def test_a_description_knows_the_units_of_a_winch():
    """rad/m, the ratio of a rotor on a slide, is a unit of no other variable."""
    slide = {"prismatic": {}, "between": ["ground", "b"], "turning": {"inertia": 0.1, "ratio": 3.0}}
    model = compile_scene(
        Scene(name="winch", body={"b": {"mass": 1.0, "inertia": [1, 1, 1]}}, joint={"slide": slide})
    )
    assert {v.unit for v in model.variables if v.unit} <= UNITS.keys()
    assert b'<Unit name="rad/m">' in description(model)


def test_a_joint_may_be_called_as_its_body():
    """Where absolute coordinates begin with joints of their own, too."""
    hinge = {
        "revolute": {},
        "between": ["ground", "b"],
        "turning": {"inertia": 0.1, "ratio": 3.0},
        "start": {"angle": 0.4},
    }
    data = {
        "name": "twins",
        "body": {"b": {"mass": 1.0, "inertia": [1, 1, 1]}},
        "joint": {"b": hinge | {"output": ["angle"]}},
    }
    assert_near(run(data, 0.0, "augmented")["b.angle"], 0.4, 1e-15)


@pytest.mark.parametrize("reverse", [False, True])
@pytest.mark.parametrize("formulation", FORMULATIONS)
def test_inverse_dynamics_turns_the_rotor_too(formulation, reverse):
    """A base and an arm about parallel axes: (I + n^2 J) q'' and n J times the other's acceleration; the told efforts in closed form."""
    ends = ["base", "arm"]
    data = {
        "name": "motors", "gravity": [0, 0, 0], "solver": {"formulation": formulation},
        "body": {"base": {"mass": 1.0, "inertia": [1, 1, 3.0]}, "arm": {"mass": 1.0, "inertia": [1, 1, 0.5]}},
        "joint": {
            "yaw": {"revolute": {"axis": "z"}, "between": ["ground", "base"], "input": "torque"},
            "elbow": {
                "revolute": {"axis": "z"}, "between": ends[::-1] if reverse else ends, "input": "torque",
                "turning": {"inertia": 0.02, "ratio": 50.0},
            },
        },
    }  # fmt: skip
    times = np.linspace(0.0, 1.0, 21)
    sign = -1.0 if reverse else 1.0
    found = Scene.model_validate(data).inverse(
        {"yaw.angle": 0.7 * times**2, "elbow.angle": sign * 0.4 * times**2}, times
    )
    a, b, nJ = 1.4, 0.8, 1.0

    # T of the rotor: n^2 J b'^2 / 2 and n J b' times the speed of its host, the elbow's first body: base, or arm turned round
    yaw = 3.0 * a + 0.5 * (a + b) + sign * nJ * b
    elbow = 0.5 * (a + b) + 50.0 * nJ * b + (-nJ * (a + 2.0 * b) if reverse else nJ * a)
    inside = slice(3, -3)
    assert_near(sign * found["elbow.torque"][inside], elbow, 1e-8)
    assert_near(found["yaw.torque"][inside], yaw, 1e-8)


def test_rotors_determine_no_reaction():
    """Four parallel hinges in a loop share what acts across their plane, whatever turns with one of them."""
    bar = {"mass": 1.0, "inertia": [0.1, 0.1, 0.1], "marker": {"end": {"position": [0, 0, -1.0]}}}
    ends = [["ground", "a"], ["a.end", "b"], ["b.end", "c"], ["c.end", "ground.far"]]
    joint = {name: {"revolute": {"axis": "y"}, "between": between} for name, between in zip("pqrs", ends)}
    joint["p"]["start"], joint["q"]["start"], joint["r"]["start"] = (
        {"angle": 0.4},
        {"angle": -1.9},
        {"angle": -1.7},
    )
    joint["q"]["turning"] = {"inertia": 0.1, "ratio": 3.0}
    ground = {"marker": {"far": {"position": [1.0, 0, 0]}}}
    scene = Scene(name="loop", body=dict.fromkeys("abc", bar), joint=joint, ground=ground)
    assert {reaction.owner for reaction in scene.structure().undetermined} == set("pqrs")
