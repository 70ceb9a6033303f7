"""Whole runs against closed forms and reference digits (benchmarks/reference/*.json, each with its source).

Tolerances: what is asked for stands some ten times above what a run with the solver's tolerance reaches, and where the
problem amplifies errors, its notes say how many digits there are.
"""

import numpy as np
import pytest
from scenes import assert_near, energies, inverse_dynamics, mass_matrix, rotation
from scipy.spatial.transform import Rotation
from scipy.special import ellipk

from benchmarks.problem_files import problem_file
from mbdfmi import Scene
from mbdfmi.compiler.model import compile_scene
from mbdfmi.run.instance import Instance

TIGHT = {"tolerance": 1e-14}
POSE = ["position", "euler_parameters", "omega_body"]


def reference(name):
    """A reference file; `column` by quantity, E (scalar last) and the times beside."""
    data = problem_file(name)

    if "q3" in data["column"]:
        data["E"] = np.column_stack([data["column"][q] for q in ("q1", "q2", "q3", "q0")])

    return data


def run(scene, times):
    """(instance, outputs at the times by name, arrays as [row, component])."""
    instance = Instance(compile_scene(Scene.model_validate(scene)))
    rows = []

    for t in times:
        if t > instance.time:
            instance.step(t - instance.time)

        rows.append(instance.outputs().copy())

    names = [v.name.partition("[")[0] for v in instance.model.of_causality("output")]
    rows = np.array(rows)
    return instance, {
        name: np.squeeze(rows[:, [k for k, other in enumerate(names) if other == name]])
        for name in set(names)
    }


def orientation_error(E, F):
    """Largest |E -+ F| by rows: both signs are the same orientation."""
    sign = np.sign(np.sum(E * F, axis=-1, keepdims=True))
    return np.abs(sign * E - F).max(axis=-1)


def single(kind, body, start, gravity=(0, 0, 0), solver=TIGHT, **joint):
    """A scene of one body on one joint to the ground."""
    body = {"mass": 1.0, "output": POSE} | body
    spec = {kind: {}, "between": ["ground", "body"], "start": start} | joint
    return {
        "name": "single",
        "gravity": gravity,
        "body": {"body": body},
        "joint": {"joint": spec},
        "solver": solver,
        "output": ["total_energy"],
    }


def bars(n, **more):
    """n uniform bars of 1 m on revolute joints about z, all along x, weight along -y."""
    marker = {"end": {"position": [1, 0, 0]}}
    inertia = [0.001, 1 / 12, 1 / 12]
    body = {
        f"bar{k}": {"mass": 1.0, "com": [0.5, 0, 0], "inertia": inertia, "marker": marker}
        for k in range(1, n + 1)
    }
    body[f"bar{n}"] = body[f"bar{n}"] | {
        "marker": {"end": marker["end"] | {"output": ["position", "velocity"]}}
    }
    joint = {
        f"j{k}": {"revolute": {}, "between": [f"bar{k - 1}.end" if k > 1 else "ground", f"bar{k}"]}
        for k in range(1, n + 1)
    }
    return {"name": "bars", "gravity": [0, -9.81, 0], "body": body, "joint": joint, "solver": TIGHT} | more


# rotation of a free body


def test_energy_and_angular_momentum_over_1000_revolutions(record_property):
    inertia = np.diag([1.0, 2.0, 2.8])
    w = np.array([0.8, 1.1, -0.6])
    scene = single("free", {"inertia": [1.0, 2.0, 2.8]}, {"omega": w.tolist()})
    instance = Instance(compile_scene(Scene.model_validate(scene)))
    L0, T0 = inertia @ w, 0.5 * w @ inertia @ w

    # the axis of rotation goes about in the body and in space; 1,000 revolutions at the mean speed
    end = 1000 * 2 * np.pi / np.linalg.norm(w)
    L_drift = T_drift = 0.0

    for _ in range(100):
        instance.step(end / 100)
        E, w = instance.d.x[3:7], instance.d.x[10:13]
        A = rotation(E).as_matrix()
        L_drift = max(L_drift, np.linalg.norm(A @ inertia @ w - L0) / np.linalg.norm(L0))
        T_drift = max(T_drift, abs(energies(instance)[0] / T0 - 1))
        assert np.linalg.norm(E) == pytest.approx(1.0, abs=1e-15)

    record_property("L_drift", float(L_drift))
    record_property("T_drift", float(T_drift))

    # about 1e5 steps, each within a tolerance of 1e-13
    assert L_drift < 1e-10
    assert T_drift < 1e-10


def test_torque_free_axisymmetric_body():
    ref = reference("torque_free_axisymmetric")
    _, y = run(single("free", {"inertia": [2, 2, 1]}, {"omega": [0.3, 0.4, 4.0]}), ref["t"])
    assert orientation_error(y["body.euler_parameters"], ref["E"]).max() < 1e-9


def test_intermediate_axis():
    """Errors grow by e^(0.577 t) between flips, so digits are asked for by time."""
    ref = reference("dzhanibekov_jacobi")
    _, y = run(single("free", {"inertia": [1, 2, 3]}, {"omega": [0.01, 1, 0.01]}), ref["t"])
    wrong = orientation_error(y["body.euler_parameters"], ref["E"])
    w = np.column_stack([ref["column"][f"w{c}_body"] for c in "xyz"])
    wrong = np.maximum(wrong, np.abs(y["body.omega_body"] - w).max(axis=1))
    assert wrong[ref["t"] <= 10].max() < 1e-11
    assert wrong[ref["t"] <= 50].max() < 1e-8
    assert wrong.max() < 1e-6


@pytest.mark.parametrize("variant", [False, True])
def test_gimbal_lock_leaves_no_trace(variant):
    """A body that turns through pitch = 90 degrees: orientation to rounding, angles finite and consistent."""
    ref = reference("gimbal_lock_pass")
    E = ref["E"]
    q, w = ref["bodies"][0]["q0"], ref["bodies"][0]["w0"]

    # another axis, from no rotation on
    if variant:
        q, w = [1, 0, 0, 0], ref["variant_w"]
        E = np.array(ref["variant_values"])[:, [2, 3, 4, 1]]

    free = {"euler_parameters": [*q[1:], q[0]], "omega": w}
    body = {"inertia": [1, 1, 1], "output": ["euler_parameters", "zyx", "omega"]}
    instance, y = run(single("free", body, free), ref["t"])
    assert orientation_error(y["body.euler_parameters"], E).max() < 1e-13

    # angular velocity is constant in space
    assert_near(y["body.omega"], np.broadcast_to(w, (len(E), 3)), atol=1e-14)

    # the angles say what the Euler parameters say, in lock too
    for angles, e in zip(y["body.zyx"], E):
        A = rotation(e).as_matrix()
        B = Rotation.from_euler("ZYX", angles).as_matrix()
        assert_near(B, A, atol=1e-12)


def test_steps_do_not_shrink_in_gimbal_lock():
    """The passage costs what the same rotation about another axis costs."""
    steps = []

    for turned in ([0, 0, 0], [90, 0, 0], [0, 0, 90], [0, 89.9, 0]):
        start = {"omega": [0, 1, 0], "zyx_deg": turned}
        instance, _ = run(
            single("free", {"inertia": [1, 1, 1]}, start, solver={"tolerance": 1e-9}), [2 * np.pi]
        )
        steps.append(instance.d.steps[0])

    assert max(steps) - min(steps) <= 2


# tops


def test_heavy_top():
    ref = reference("heavy_top_bruls")
    top = ref["bodies"][0]
    body = {"mass": top["mass"], "com": [0, 1, 0], "inertia": top["inertia"]}
    body["marker"] = {"com": {"position": [0, 1, 0], "output": ["position"]}}
    scene = single("spherical", body, {"omega": top["w0"]}, ref["gravity"])
    _, y = run(scene, ref["t"])
    column = ref["column"]
    position = np.column_stack([column[c] for c in "xyz"])
    w = np.column_stack([column[f"w{c}_body"] for c in "xyz"])

    # 150 rad/s for 2 s: phase errors of 1e-13 a step over 48 revolutions
    assert_near(y["body.com.position"], position, atol=1e-9)
    assert orientation_error(y["body.euler_parameters"], ref["E"]).max() < 1e-9
    assert_near(y["body.omega_body"], w, atol=1e-8)

    # the reference counts height from the fixed point too
    assert_near(y["total_energy"], column["total_energy_J"], rtol=1e-11)


def test_steady_precession_of_a_cone():
    ref = reference("steady_precession_cone_top")
    cone = ref["bodies"][0]
    q = cone["q0"]
    E = [*q[1:], q[0]]
    body = {"mass": cone["mass"], "inertia": cone["inertia"]}
    com = rotation(E).as_matrix().T @ cone["r0"]
    body |= {"com": com.tolist(), "marker": {"com": {"position": com.tolist(), "output": ["position"]}}}
    scene = single("spherical", body, {"euler_parameters": E, "omega": cone["w0"]}, ref["gravity"])
    _, y = run(scene, ref["t"])
    position = np.column_stack([ref["column"][c] for c in "xyz"])

    # no nutation: the height stays
    assert_near(y["body.com.position"][:, 2], 0.0375, atol=2e-11)
    assert_near(y["body.com.position"], position, atol=2e-10)
    assert orientation_error(y["body.euler_parameters"], ref["E"]).max() < 1e-9


# pendulums


def test_simple_pendulum():
    """A point mass: no inertia but m l^2. Angle from the start at (-1, 0)."""
    ref = reference("A01_simple_pendulum")
    body = {"com": [-1, 0, 0], "inertia": [0, 0, 0]}
    body["marker"] = {"p": {"position": [-1, 0, 0], "output": ["position", "velocity"]}}
    _, y = run(single("revolute", body, {}, ref["gravity"]), ref["t"])
    expected = np.column_stack([ref["column"][c] for c in ("x", "y", "vx", "vy")])
    found = np.column_stack([y["body.p.position"][:, :2], y["body.p.velocity"][:, :2]])
    assert_near(found, expected, atol=1e-9)


@pytest.mark.parametrize("amplitude", [0.1, 1.5, 3.0, 3.14])
def test_large_angle_period(amplitude):
    """T = 4 K(sin(a/2)) / w0 of a bar on a revolute joint: after one period it is back, at rest."""
    w0 = np.sqrt(9.81 * 0.5 / (1 / 3))
    period = 4 * ellipk(np.sin(amplitude / 2) ** 2) / w0
    body = {"com": [0, 0, -0.5], "inertia": [1 / 12, 1 / 12, 0.001]}
    scene = single("revolute", body, {"angle": amplitude}, (0, 0, -9.81), revolute={"axis": "y"})
    instance, _ = run(scene, [period / 2, period])
    angle, speed = instance.d.x

    # dt = error of speed / acceleration; near the top errors grow by e^(w0 t)
    assert angle == pytest.approx(amplitude, abs=1e-9)
    assert speed == pytest.approx(0, abs=1e-9)


def test_spherical_pendulum():
    """Its bob is a sphere, not a point, that does not spin; a weight greater by (m l^2 + J) / m l^2 makes up for J."""
    ref = reference("spherical_pendulum")
    J = 0.1
    body = {"com": [1, 0, 0], "inertia": [J] * 3}
    body["marker"] = {"p": {"position": [1, 0, 0], "output": ["position", "velocity"]}}
    scene = single("spherical", body, {"omega": [0, 0, 2]}, (0, 0, -9.81 * (1 + J)))
    _, y = run(scene, ref["t"])
    expected = np.column_stack([ref["column"][c] for c in ("x", "y", "z", "vx", "vy", "vz")])
    assert_near(np.hstack([y["body.p.position"], y["body.p.velocity"]]), expected, atol=1e-10)


def test_double_pendulum():
    """To t = 5 s; the motion is chaotic."""
    ref = reference("double_pendulum_bars")
    instance, y = run(bars(2), ref["t"])
    tip = np.column_stack([ref["column"]["tip_x"], ref["column"]["tip_y"]])
    assert_near(y["bar2.end.position"][:, :2], tip, atol=1e-9)
    assert sum(energies(instance)) == pytest.approx(0, abs=1e-9)


def test_chain_of_ten_bars():
    ref = reference("chain_bars_N10")
    instance, y = run(bars(10), ref["t"])
    tip = np.column_stack([ref["column"][c] for c in ("tip_x", "tip_y", "tip_vx", "tip_vy")])
    found = np.hstack([y["bar10.end.position"][:, :2], y["bar10.end.velocity"][:, :2]])
    assert_near(found, tip, atol=1e-10)
    assert sum(energies(instance)) == pytest.approx(0, abs=1e-10)


def test_two_link_arm():
    """Mass matrix, Coriolis and weight terms, accelerations at an instant."""
    ref = reference("two_link_arm")
    inertias = [body["inertia"] for body in ref["bodies"]]
    scene = {
        "name": "arm",
        "gravity": ref["gravity"],
        "body": {
            "upper": {"mass": 2.0, "com": [0.4, 0, 0], "inertia": inertias[0]},
            "lower": {"mass": 1.5, "com": [0.3, 0, 0], "inertia": inertias[1]},
        },
        "joint": {
            "shoulder": {
                "revolute": {},
                "between": ["ground", "upper"],
                "start": {"angle": 0.4, "speed": 1.2},
            },
            "elbow": {
                "revolute": {},
                "between": ["upper.end", "lower"],
                "start": {"angle": -0.9, "speed": -0.7},
            },
        },
    }
    scene["body"]["upper"]["marker"] = {"end": {"position": [0.8, 0, 0]}}

    for joint in scene["joint"].values():
        joint["output"] = ["acceleration"]

    instance, y = run(scene, [0.0])
    accelerations = [float(y["shoulder.acceleration"]), float(y["elbow.acceleration"])]
    assert_near(accelerations, ref["values"][0], rtol=1e-14)
    assert_near(mass_matrix(instance), ref["reference_M"], rtol=1e-14)
    bias = inverse_dynamics(instance, np.zeros(2))
    assert_near(bias, np.add(ref["reference_coriolis"], ref["reference_gravity"]), rtol=1e-14)


# springs between markers


def two_bodies(strut, velocity):
    """Masses of 2 and 3 kg, 1 m apart, that a strut holds together; the centre of mass rests."""
    m1, m2 = 2.0, 3.0
    v = np.array(velocity)
    starts = {
        "one": {"position": [-0.6, 0, 0], "velocity": (-v * m2 / (m1 + m2)).tolist()},
        "two": {"position": [0.4, 0, 0], "velocity": (v * m1 / (m1 + m2)).tolist()},
    }
    return {
        "name": "planets",
        "gravity": [0, 0, 0],
        "solver": TIGHT,
        "body": {
            "one": {"mass": m1, "inertia": [0.1, 0.2, 0.25], "output": ["position", "omega"]},
            "two": {"mass": m2, "inertia": [0.1, 0.2, 0.25], "output": ["position", "omega"]},
        },
        "joint": {
            name: {"free": {}, "between": ["ground", name], "start": start} for name, start in starts.items()
        },
        "force": {
            "strut": {"spring_damper": strut, "between": ["one", "two"], "output": ["length", "force"]}
        },
    }


def test_planets_on_a_slack_free_spring_run_on_an_ellipse():
    """Rest length 0: r = r0 cos wt + v0/w sin wt, w^2 = k / mu."""
    k, mu = 7.0, 2.0 * 3.0 / 5.0
    w = np.sqrt(k / mu)
    v = np.array([0.3, 1.4, 0.5])
    t = np.linspace(0, 20, 41)
    _, y = run(two_bodies({"stiffness": k, "rest_length": 0}, v), t)
    apart = np.outer(np.cos(w * t), [1, 0, 0]) + np.outer(np.sin(w * t) / w, v)
    assert_near(y["two.position"] - y["one.position"], apart, atol=1e-10)
    assert_near(2 * y["one.position"] + 3 * y["two.position"], 0, atol=1e-11)
    assert_near(y["strut.length"], np.linalg.norm(apart, axis=1), atol=1e-10)
    assert_near(y["strut.force"], k * np.linalg.norm(apart, axis=1), atol=1e-9)


def test_planets_on_a_circle():
    """mu w^2 r = k (r - L), at a distance of 1 m for ever; a damper has nothing to do."""
    k, L, mu = 7.0, 0.4, 2.0 * 3.0 / 5.0
    w = np.sqrt(k * (1 - L) / mu)
    t = np.linspace(0, 20, 41)
    _, y = run(two_bodies({"stiffness": k, "rest_length": L, "damping": 3.0}, [0, w, 0]), t)
    circle = np.column_stack([np.cos(w * t), np.sin(w * t), 0 * t])
    assert_near(y["two.position"] - y["one.position"], circle, atol=1e-10)
    assert_near(y["strut.length"], 1.0, atol=1e-11)
    assert_near(y["strut.force"], k * (1 - L), atol=1e-10)


def test_strut_without_rest_length_is_slack_at_the_start():
    _, y = run(two_bodies({"stiffness": 7.0}, [0, 0, 0]), [0.0])
    assert y["strut.length"] == pytest.approx(1.0, abs=1e-15)
    assert y["strut.force"] == pytest.approx(0.0, abs=1e-14)


def damped(t, m, c, k, x0):
    """x of m x'' + c x' + k x = 0 from rest at x0, underdamped."""
    s = -c / (2 * m) + 1j * np.sqrt(k / m - (c / (2 * m)) ** 2)
    return (x0 * np.exp(s * t)).real - x0 * s.real / s.imag * (np.exp(s * t)).imag


@pytest.mark.parametrize("kind", ["strut", "joint"])
def test_damped_oscillator(kind):
    m, c, k, rest, x0 = 2.0, 0.7, 30.0, 1.5, 2.2
    t = np.linspace(0, 5, 21)
    scene = single("prismatic", {"mass": m, "inertia": [1, 1, 1]}, {"position": x0}, output=["position"])

    if kind == "joint":
        scene["joint"]["joint"] |= {"spring": {"stiffness": k, "rest": rest}, "damper": c}
    else:
        spec = {"stiffness": k, "damping": c, "rest_length": rest}
        scene["force"] = {"strut": {"spring_damper": spec, "between": ["ground", "body"]}}

    _, y = run(scene, t)
    assert_near(y["joint.position"], rest + damped(t, m, c, k, x0 - rest), atol=1e-11)


def test_added_mass_moves_as_mass_without_weight():
    """A buoy that heaves: (m + a) z'' + c z' + k z = -m g, a body that surges and yaws feels no restoring."""
    m, a, c, k, z0 = 2.0, 3.0, 0.7, 30.0, 0.4
    matrices = {
        "stiffness": np.diag([0, 0, k, 0, 0, 0]),
        "damping": np.diag([0, 0, c, 0, 0, 0]),
        "added_mass": np.diag([0.0, 0, a, 0, 0, 0]),
    }
    scene = single("free", {"mass": m, "inertia": [1, 1, 1]}, {"position": [0, 0, z0]}, (0, 0, -9.81))
    linear = {key: matrix.tolist() for key, matrix in matrices.items()}
    scene["force"] = {"water": {"linear": linear, "between": ["ground", "body"]}}
    t = np.linspace(0, 5, 21)
    _, y = run(scene, t)
    rest = -m * 9.81 / k
    assert_near(y["body.position"][:, 2], rest + damped(t, m + a, c, k, z0 - rest), atol=1e-11)
