"""Inverse dynamics of joints of several freedoms, of floating bases and of idle spins: against forward dynamics and statics."""

from pathlib import Path

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from loop_scenes import TREE, pose_table, random_body, random_pose, unit
from scenes import assert_near, examples
from scipy.interpolate import CubicSpline, make_interp_spline
from scipy.spatial.transform import Rotation

import mbdfmi
from mbdfmi import Scene
from mbdfmi.cli import main
from mbdfmi.compiler.model import compile_scene
from mbdfmi.kernels import forces
from mbdfmi.kernels.dynamics import forward as dynamics
from mbdfmi.kernels.dynamics import inertia
from mbdfmi.kernels.motion import kinematics
from mbdfmi.run.instance import Instance

ALL_AXES = [0.01] * 3
TURBINE = Path(mbdfmi.__file__).parents[1] / "models" / "floating_wind_turbine" / "floating_wind_turbine.toml"

# quantities that tell the whole motion of a joint, with the size of each, and the names of its efforts
TOLD = {
    "revolute": ({"angle": 1}, ["torque"]),
    "prismatic": ({"position": 1}, ["force"]),
    "screw": ({"angle": 1}, ["torque"]),
    "cylindrical": ({"position": 1, "angle": 1}, ["force", "torque"]),
    "universal": ({"angles": 2}, ["torques"]),
    "planar": ({"position": 2, "angle": 1}, ["force", "torque"]),
    "translation": ({"position": 3}, ["force"]),
    "spherical": ({"zyx": 3}, ["torque"]),
    "free": ({"position": 3, "euler_parameters": 4}, ["force", "moment"]),
}


def polynomial(rng, size):
    """A random function of time, of degree 3, with its derivatives."""
    values = rng.normal(size=(4, size)) + (np.array([0, 0, 0, 5]) if size == 4 else 0)
    return CubicSpline([0.0, 0.3, 0.6, 1.0], values if size > 1 else values[:, 0])


def random_tree(seed, n, kinds):
    """A scene of n bodies on joints of these kinds in any direction, with springs and dampers, and a motion of all."""
    rng = np.random.default_rng(seed)
    body, joint, ground, motion = {}, {}, {}, {}

    def add_marker(owner):
        markers = ground if owner == "ground" else body[owner]["marker"]
        markers[f"m{len(markers)}"] = pose_table(random_pose(rng))
        return f"{owner}.m{len(markers) - 1}"

    for k in range(n):
        kind, name, parent = str(rng.choice(kinds)), f"body{k}", f"body{rng.integers(k)}" if k else "ground"
        body[name] = random_body(rng)
        ends = [add_marker(parent), add_marker(name)]
        options = {
            "universal": {"axes": np.linalg.qr(rng.normal(size=(3, 3)))[0][:2].tolist()},
            "planar": {"normal": unit(rng).tolist()},
        }
        plain = {} if kind in ("spherical", "free", "translation") else {"axis": unit(rng).tolist()}
        spec = {kind: options.get(kind, plain) | ({"pitch": 0.8} if kind == "screw" else {})}
        joint[f"j{k}"] = spec | {"between": ends[::-1] if rng.random() < 0.5 else ends}

        if kind in ("revolute", "prismatic"):
            joint[f"j{k}"] |= {"spring": {"stiffness": 3.0}, "damper": 0.4}

        motion |= {f"j{k}.{quantity}": polynomial(rng, size) for quantity, size in TOLD[kind][0].items()}

    force = {
        "strut": {
            "spring_damper": {"stiffness": 2.0, "damping": 0.5, "rest_length": 0.7},
            "between": ["ground", "body0"],
        }
    }
    return Scene(
        name="tree",
        body=body,
        joint=joint,
        ground={"marker": ground},
        force=force,
        gravity=(5 * unit(rng)).tolist(),
    ), motion


def marker_frame(instance, end):
    """(node, origin, axes) of an end of a joint, inertial."""
    i, (r, A) = instance.model.tree.marker(instance.model.scene, end)
    R = instance.d.A.reshape(-1, 3, 3)[i]
    return i, instance.d.r.reshape(-1, 3)[i] + R @ r, R @ A


def add_efforts(instance, name, joint, values):
    """The efforts of one joint (a dict) to what acts on the bodies."""
    m, d = instance.m, instance.d

    if joint.kind not in ("spherical", "free"):
        nodes = sorted((i for i, node in enumerate(instance.model.tree.nodes) if node.joint == name),
                       key=lambda i: instance.model.tree.nodes[i].coordinate)  # fmt: skip

        # of a screw the angle alone is told
        nodes = nodes[1:] if joint.kind == "screw" else nodes
        d.tau[[m.body_v[i] for i in nodes]] += np.concatenate([np.atleast_1d(v) for v in values.values()])
        return

    (first, _, A), (second, r, _) = (marker_frame(instance, end) for end in joint.between)
    moment = A @ values["moment" if joint.kind == "free" else "torque"]
    force = A @ values["force"] if joint.kind == "free" else np.zeros(3)

    for i, sign in ((first, -1), (second, 1)):
        arm = r - d.r.reshape(-1, 3)[i]
        d.moment.reshape(-1, 3)[i] += sign * (moment + np.cross(arm, force))
        d.force.reshape(-1, 3)[i] += sign * force


@examples
@given(
    st.integers(0, 2**32 - 1), st.integers(1, 6), st.sampled_from([tuple(TREE), *((kind,) for kind in TREE)])
)
def test_efforts_give_the_accelerations_back(seed, n, kinds):
    """By articulated bodies, with the efforts as forces on both sides of the joints, at the positions and speeds of the motion."""
    scene, motion = random_tree(seed, n, kinds)
    found = scene.inverse(motion, times=[0.4])
    starts = {}

    for name, joint in scene.joint.items():
        rates = (
            "position",
            "angle",
            "angles",
            "zyx",
            "euler_parameters",
            "speed",
            "angular_speed",
            "speeds",
            "velocity",
            "omega",
        )
        values = {
            key: found[f"{name}.{key}"][0]
            for key in rates
            if any(k.partition("[")[0] == f"{name}.{key}" for k in found)
        }

        # a screw's position follows
        if joint.kind == "screw":
            values = {key: values[key] for key in ("angle", "angular_speed")}

        starts[name] = {key: value.tolist() for key, value in values.items()}

    data = scene.model_dump(exclude_unset=True)

    for name, start in starts.items():
        data["joint"][name]["start"] = start

    instance = Instance(compile_scene(Scene.model_validate(data)))
    m, d = instance.m, instance.d
    kinematics.kinematics(m, d)
    inertia.inertias(m, d)
    forces.apply(m, d)

    for name, joint in scene.joint.items():
        add_efforts(
            instance, name, joint, {effort: found[f"{name}.{effort}"][0] for effort in TOLD[joint.kind][1]}
        )

    assert dynamics.accelerate(m, d) == 0

    for name, joint in scene.joint.items():
        for quantity in TOLD[joint.kind][0]:
            expected = motion[f"{name}.{quantity}"].derivative(2)(0.4)
            seen = second_rate(instance, name, joint, quantity, motion[f"{name}.{quantity}"])
            assert_near(seen, expected, 1e-9 * (1.0 + np.abs(d.x_rate).max()))


def second_rate(instance, name, joint, quantity, course):
    """Second rate of a quantity by the accelerations that forward dynamics found."""
    m, d, nodes = instance.m, instance.d, instance.model.tree.nodes
    mine = sorted(
        (i for i, node in enumerate(nodes) if node.joint == name), key=lambda i: nodes[i].coordinate
    )

    if joint.kind not in ("spherical", "free"):
        each = {"screw": {"angle": [1]}, "cylindrical": {"position": [0], "angle": [1]}}.get(joint.kind, {})
        each = each or {"planar": {"position": [0, 1], "angle": [2]}}.get(
            joint.kind, {quantity: range(len(mine))}
        )
        values = [d.v_rate[m.body_v[mine[k]]] for k in each[quantity]]
        return values if len(values) > 1 else values[0]

    # of poses the accelerations are told by markers; compare these with those of the course
    (a, r_a, A), (b, r_b, B) = (marker_frame(instance, end) for end in joint.between)
    w, alpha, r, rd, rdd = (getattr(d, key).reshape(-1, 3) for key in ("w", "alpha", "r", "rd", "rdd"))

    if quantity == "position":
        at = lambda i: rdd[i] + np.cross(alpha[i], r_b - r[i]) + np.cross(w[i], np.cross(w[i], r_b - r[i]))
        v = lambda i: rd[i] + np.cross(w[i], r_b - r[i])
        return A.T @ (at(b) - at(a) - 2 * np.cross(w[a], v(b) - v(a)))

    seen = A.T @ (alpha[b] - alpha[a] - np.cross(w[a], w[b] - w[a]))
    assert_near(seen, angular_acceleration(quantity, course, 0.4), 1e-5 * (1.0 + np.abs(d.x_rate).max()))
    return course.derivative(2)(0.4)


def angular_acceleration(quantity, course, t):
    """In base axes, by differences of orientations that the course tells, of order 4."""
    turn = (
        (lambda t: Rotation.from_euler("ZYX", course(t)))
        if quantity == "zyx"
        else (lambda t: Rotation.from_quat(course(t)))
    )
    spin = lambda t, h: (turn(t + h) * turn(t - h).inv()).as_rotvec() / (2 * h)
    alpha = lambda h: (spin(t + h, h) - spin(t - h, h)) / (2 * h)
    return (4 * alpha(5e-4) - alpha(1e-3)) / 3


# there and back


def forward(scene, efforts, times):
    """Outputs by name, at the times, of a run with inputs (name -> function with derivatives), parabolas over each step."""
    model = compile_scene(scene)
    at = {v.name: v.index for v in model.of_causality("input")}
    instance = Instance(model, inputs={at[name]: float(f(times[0])) for name, f in efforts.items()})
    rows = []

    for k, t in enumerate(times):
        for name, f in efforts.items():
            instance.u[at[name] :: model.n_u][:3] = [f(t, n) for n in range(3)]

        rows.append(instance.outputs().copy())

        if k + 1 < len(times):
            instance.step(times[k + 1] - t)

    return dict(zip([v.name for v in model.of_causality("output")], np.array(rows).T))


def test_a_free_body_there_and_back():
    """Six efforts as a force and a moment on the body move it as it was told, by position and angles."""
    shape = {"mass": 2.0, "com": [0.1, 0.2, -0.1], "inertia": [0.3, 0.4, 0.5], "input": ["force", "moment"]}
    scene = {"name": "free", "body": {"a": shape}, "solver": {"tolerance": 1e-12}}
    joint = {"free": {}, "between": ["ground", "a"], "output": ["position", "zyx"]}
    position = lambda t: np.array([np.sin(t), 0.5 * t * t, np.cos(2 * t)])
    zyx = lambda t: np.array([0.3 + t, 0.4 * np.sin(2 * t), 0.2 * t * t])
    times = np.linspace(0, 1, 401)
    found = Scene(**scene, joint={"f": joint}).inverse({"f.position": position, "f.zyx": zyx}, times)
    names = [f"{quantity}[{k}]" for quantity in ("force", "moment") for k in (1, 2, 3)]
    efforts = {f"a.{name}": make_interp_spline(times, found[f"f.{name}"], k=5) for name in names}
    start = {"position": position(0).tolist(), "zyx_rad": zyx(0).tolist()}
    start |= {"velocity": [1.0, 0.0, 0.0], "omega": found["f.omega"][0].tolist()}
    fine = np.linspace(0, 1, 4001)
    moved = forward(Scene(**scene, joint={"f": joint | {"start": start}}), efforts, fine)

    for name, f in (("position", position), ("zyx", zyx)):
        expected = np.array([f(t) for t in fine])
        assert_near(np.column_stack([moved[f"f.{name}[{k}]"] for k in (1, 2, 3)]), expected, 1e-8)


def turbine(**changes):
    """The floating wind turbine (NREL 5-MW on the ITI Energy barge) without the inputs of wind and waves."""
    data = mbdfmi.load(TURBINE).model_dump(exclude_unset=True)

    for body in data["body"].values():
        body.pop("input", None), body.pop("input_axes", None)

    data["solver"] = {"tolerance": 1e-12}
    return data | changes


@pytest.mark.parametrize("water", [False, True])
def test_heave_force_of_the_turbine_at_rest_is_its_weight(water):
    """In the water less the buoyancy of 6000 m3, and the mooring's pull more; upright and at its draught. The rotor stands off the axis."""
    data = turbine() if water else turbine(force={})
    scene = Scene.model_validate(data)
    found = scene.inverse(
        {"float.position": [0, 0, 0], "float.zyx": [0, 0, 0], "shaft.angle": 0.0}, times=[0.0]
    )
    mass = sum(body.mass_properties()[0] for body in scene.body.values())
    lift = sum(force.linear.preload_vector()[2] for force in scene.force.values())
    assert lift == 0 if not water else 58e6 < lift < 60_310_897.5
    assert_near(found["float.force"], [[0, 0, 9.80665 * mass - lift]], 1e-3)
    assert abs(found["float.moment"][0, 1]) > 1e6 and np.abs(found["float.moment"][0, ::2]).max() < 1e3
    assert abs(found["shaft.torque"][0]) < 1.0


def test_turbine_with_a_told_shaft_on_a_free_base_there_and_back():
    """Hybrid: the base moves freely; with the torque found as input, the shaft and the base move so again."""
    data = turbine()
    data["joint"]["shaft"] |= {"start": {"speed": 1.0}, "output": ["angle", "speed"]}
    data["joint"]["float"]["start"] |= {"omega": [0.01, 0.02, 0.0]}
    times = np.linspace(0, 4, 201)
    angle = lambda t: t + 0.05 * (1 - np.cos(2 * t))
    motion = {
        "shaft.angle": angle,
        "shaft.speed": lambda t: 1 + 0.1 * np.sin(2 * t),
        "shaft.acceleration": lambda t: 0.2 * np.cos(2 * t),
    }
    scene = Scene.model_validate(data)
    found = scene.inverse(motion, times)
    assert len(found.notices) == 1 and '"float"' in found.notices[0] and "go on freely" in found.notices[0]

    torque = make_interp_spline(times, found["shaft.torque"], k=5)
    fine = np.linspace(0, 4, 4001)
    moved = forward(scene, {"shaft.torque": torque}, fine)
    assert_near(moved["shaft.angle"], angle(fine), 1e-8)

    for k in (1, 2, 3):
        assert_near(moved[f"platform.position[{k}]"][::20], found[f"platform.position[{k}]"], 1e-8)
        assert_near(moved[f"platform.zyx[{k}]"][::20], found[f"platform.zyx[{k}]"], 1e-9)


def test_what_is_told_of_a_run_needs_no_effort():
    """A run's own table: position, velocity, orientation and angular velocity of a body that flies freely."""
    body = {"mass": 1.5, "inertia": [0.2, 0.3, 0.4], "com": [0.1, 0, 0]}
    start = {"position": [0, 0, 1], "velocity": [1, 0, 2], "omega": [1, 2, 3]}
    joint = {
        "free": {},
        "between": ["ground", "a"],
        "start": start,
        "output": ["position", "velocity", "euler_parameters", "omega"],
    }
    scene = Scene(name="f", body={"a": body}, joint={"f": joint}, solver={"tolerance": 1e-12})
    found = scene.inverse(scene.simulate(1.0))
    assert_near(found["f.force"], 0.0, 1e-6)
    assert_near(found["f.moment"], 0.0, 1e-6)


# what is left open


def rod_on_two_balls(spin=0.0):
    """A crank, a rod on two balls, a slider: the rod may spin about itself."""
    rod = (0.5**2 + 0.2**2) ** 0.5
    return Scene(
        name="rods",
        body={
            "crank": {"mass": 1, "inertia": ALL_AXES, "marker": {"e": {"position": [0, 0, 0.2]}}},
            "rod": {
                "mass": 0.1, "inertia": [1e-5, 1e-3, 1e-3], "com": [rod / 2, 0, 0],
                "marker": {"e": {"position": [rod, 0, 0]}}, "output": ["omega_body"],
            },
            "slider": {"mass": 2, "inertia": ALL_AXES},
        },
        joint={
            "crank": {"revolute": {"axis": "y"}, "between": ["ground", "crank"]},
            "a": {"spherical": {}, "between": ["crank.e", "rod"]},
            "b": {"spherical": {}, "between": ["rod.e", "slider"]},
            "rail": {"prismatic": {"axis": "x"}, "between": ["ground", "slider"], "start": {"position": 0.5}},
        },
    )  # fmt: skip


@pytest.mark.parametrize("speed", [0.5, 3.0])
@pytest.mark.parametrize("driven", ["crank", "rail"])
def test_idle_spin_takes_no_effort(speed, driven):
    """The rod does not spin, which is told; power of the drive is the rate of the energy."""
    scene = rod_on_two_balls().model_copy(update={"output": ["total_energy"]})
    times = np.linspace(0, 0.1, 51)
    motion = (
        {"crank.angle": lambda t: speed * t}
        if driven == "crank"
        else {"rail.position": lambda t: 0.5 + 0.2 * speed * t}
    )
    found = scene.inverse(motion, times)
    assert_near(found["rod.omega_body[1]"], 0.0, 1e-9)
    assert any("spin" in notice for notice in found.notices)
    effort, rate = ("crank.torque", "crank.speed") if driven == "crank" else ("rail.force", "rail.speed")
    energy = make_interp_spline(times, found["total_energy"], k=5).derivative()(times)
    assert_near((found[effort] * found[rate])[3:-3], energy[3:-3], 2e-5 * np.abs(energy).max())


def test_hybrid_lets_the_rest_of_an_arm_swing():
    """A double pendulum, its first angle told: the second swings as in a run in which a driver moves the first."""
    link = {"mass": 1.0, "com": [0.3, 0, 0], "inertia": ALL_AXES, "marker": {"e": {"position": [0.6, 0, 0]}}}
    joint = {
        "a": {"revolute": {"axis": "y"}, "between": ["ground", "one"]},
        "b": {
            "revolute": {"axis": "y"},
            "between": ["one.e", "two"],
            "start": {"angle": 0.4},
            "output": ["angle"],
        },
    }
    scene = {"name": "p", "body": {"one": link, "two": link}, "solver": {"tolerance": 1e-12}}
    times = np.linspace(0, 1, 101)
    w = 2 * np.pi
    motion = {
        "a.angle": lambda t: np.sin(w * t),
        "a.speed": lambda t: w * np.cos(w * t),
        "a.acceleration": lambda t: -w * w * np.sin(w * t),
    }
    told = Scene(**scene, joint=joint)

    with pytest.raises(ValueError, match='undetermined; of these could be driven too: "b"'):
        told.inverse(motion, times)

    found = told.inverse(motion, times, hybrid=True)
    driven = {
        "a": joint["a"] | {"driver": {"harmonic": {"amplitude": 1, "frequency": 1}}, "output": ["effort"]},
        "b": joint["b"],
    }
    run = Scene(**scene, joint=driven).simulate(1.0, 0.01)
    assert_near(found["b.angle"], run["b.angle"], 1e-8)
    assert_near(found["a.torque"], run["a.effort"], 1e-6)


@pytest.mark.parametrize("told", [False, True])
def test_formulations_agree(told):
    """A link on a ball, behind a told hinge: hanging freely, or told as well; its joint written from its own side."""
    link = {"mass": 1.0, "com": [0.3, 0, 0], "inertia": ALL_AXES, "marker": {"e": {"position": [0.6, 0, 0]}}}
    joint = {
        "a": {"revolute": {"axis": "y"}, "between": ["ground", "one"]},
        "b": {
            "spherical": {},
            "between": ["two", "one.e"],
            "start": {"omega": [0.1, 0.2, 0.3]},
            "output": ["zyx"],
        },
    }
    motion = {"a.angle": lambda t: np.sin(2 * t)} | ({"b.zyx": lambda t: [t, 2 * t, -t]} if told else {})
    found = []

    for formulation in ("recursive", "embedding", "augmented"):
        scene = Scene(
            name="p", body={"one": link, "two": link}, joint=joint, solver={"formulation": formulation}
        )
        found.append(scene.inverse(motion, np.linspace(0, 0.2, 5)))

    for other in found[1:]:
        assert list(other) == list(found[0])

        for name in other:
            assert_near(other[name], found[0][name], 1e-10)


# tables and messages


def test_a_table_tells_a_floating_body(tmp_path, capsys):
    """Columns of components, angles in degrees; by the command too."""
    body = {"mass": 2.0, "inertia": ALL_AXES}
    scene = Scene(name="f", body={"a": body}, joint={"float": {"free": {}, "between": ["ground", "a"]}})
    times = np.linspace(0, 1, 21)
    names = [
        "time",
        *(f"float.position[{k}]" for k in (1, 2, 3)),
        *(f"float.zyx[{k}] [deg]" for k in (1, 2, 3)),
    ]
    rows = np.column_stack([times, times**2, 0 * times, times**3, 90 * times, 0 * times, 0 * times])
    table = tmp_path / "motion.csv"
    table.write_text("\n".join([",".join(names), *(",".join(map(repr, map(float, row))) for row in rows)]))
    found = scene.inverse(table)
    assert_near(found["float.force"], 2 * np.column_stack([2 + 0 * times, 0 * times, 6 * times + 9.81]), 1e-8)
    assert_near(found["float.moment"], 0.0, 1e-8)
    assert_near(found["float.omega[3]"], np.pi / 2, 1e-10)
    (tmp_path / "f.toml").write_text(scene.to_toml())
    assert (
        main(
            ["inverse", str(tmp_path / "f.toml"), "--motion", str(table), "--csv", str(tmp_path / "out.csv")]
        )
        == 0
    )
    assert "float.force[3] [N]" in (tmp_path / "out.csv").read_text()


@pytest.mark.parametrize(
    "motion, text",
    [
        ({"f.position": [0, 0, 0]}, "not its position"),
        ({"f.zyx": [0, 0, 0]}, "not its position"),
        ({"f.position": [0, 0], "f.zyx": [0, 0, 0]}, "needs 3 values"),
        ({"f.position[1]": 0.0, "f.zyx": [0, 0, 0]}, "needs 3 components"),
        ({"f.position": [0, 0, 0], "f.euler_parameters": [0, 0, 0, 0]}, "zero length"),
        ({"f.positon": [0, 0, 0]}, "did you mean 'f.position'"),
    ],
)
def test_mistakes_are_told(motion, text):
    scene = Scene(
        name="f",
        body={"a": {"mass": 1, "inertia": ALL_AXES}},
        joint={"f": {"free": {}, "between": ["ground", "a"]}},
    )

    with pytest.raises(ValueError, match=text):
        scene.inverse(motion, times=[0.0, 1.0])
