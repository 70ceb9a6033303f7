"""What single keys of a scene mean, each in a closed form that it enters: phases, axes, which input is which."""

import numpy as np
import pytest
from scenes import assert_near
from scipy.spatial.transform import Rotation
from test_powers import named_outputs

from mbdfmi import Scene
from mbdfmi.simulate import Instance

MOTION = ["position", "velocity", "acceleration", "euler_parameters", "omega", "alpha"]
BODY_MOTION = ["velocity_body", "acceleration_body", "omega_body", "alpha_body"]
PLACE = {"position": [0.3, -0.2, 0.5], "axis_angle": {"axis": [1, 2, -1], "angle_deg": 70}}
AXES = Rotation.from_rotvec(np.radians(70) * np.array([1, 2, -1]) / np.sqrt(6)).as_matrix()


def found_at_start(scene, inputs=()):
    """Outputs at the start, by the names that results have; inputs by name of a variable."""
    instance = Instance(Scene.model_validate(scene).compile())
    place = {v.name: v.index for v in instance.model.of_causality("input")}

    for name, value in dict(inputs).items():
        for k, component in enumerate(np.atleast_1d(value), 1):
            instance.u[place[name] if name in place else place[f"{name}[{k}]"]] = component

    return named_outputs(instance)


def assert_same_turn(E, A, allowed=1e-12):
    """Euler parameters of the rotation matrix, of either sign."""
    assert_near(Rotation.from_quat(E).as_matrix(), A, allowed)


# the ground


def carried(motion, **more):
    """A body held where a marker of the ground is, by a hinge that a driver holds at 0."""
    return {
        "name": "carried", "gravity": [0, 0, 0], "ground": {"motion": motion, "marker": {"m": PLACE}},
        "body": {"a": {"mass": 1, "inertia": [1, 1, 1], "output": MOTION + BODY_MOTION}},
        "joint": {"j": {"revolute": {}, "between": ["ground.m", "a"], "driver": {"hold": True}}},
    } | more  # fmt: skip


def assert_carried(found, r, A, v, w, a, alpha):
    """The body moves as a point and the axes of the ground at the marker, (r, A, v, w, a, alpha) being the ground's."""
    arm = A @ PLACE["position"]
    turned = A @ AXES
    expected = {
        "position": r + arm,
        "velocity": v + np.cross(w, arm),
        "acceleration": a + np.cross(alpha, arm) + np.cross(w, np.cross(w, arm)),
        "omega": np.array(w),
        "alpha": np.array(alpha),
    }
    expected |= {f"{key}_body": turned.T @ expected[key] for key in ("velocity", "acceleration", "omega", "alpha")}
    assert_same_turn(found.pop("a.euler_parameters"), turned)

    for name, value in found.items():
        assert_near(value, expected[name.partition(".")[2]], 1e-12)


def plane_of(normal):
    """(radial direction, track) at angle 0 of an orbit."""
    x = np.array([1.0, 0, 0]) if abs(normal[0]) < 1 else np.array([0, 1.0, 0])
    radial = x - (x @ normal) * normal
    radial /= np.linalg.norm(radial)
    return radial, np.cross(normal, radial)


@pytest.mark.parametrize("normal", ["z", "-y", "x", [1, -2, 2]])
@pytest.mark.parametrize("pointing", [True, False])
def test_phase_and_normal_of_an_orbit(normal, pointing):
    """r = R (cos, sin) of the phase, at uniform rate; the axes turn with it where they point."""
    R, rate, phase = 2.0, 0.7, np.radians(50)
    orbit = {"radius": R, "rate": rate, "normal": normal, "phase_deg": 50, "pointing": pointing}
    n = {"z": [0, 0, 1], "-y": [0, -1, 0], "x": [1, 0, 0]}.get(normal if isinstance(normal, str) else "", normal)
    n = np.array(n) / np.linalg.norm(n)
    e, track = plane_of(n)
    radial = np.cos(phase) * e + np.sin(phase) * track
    along = np.cross(n, radial)
    A = np.column_stack([radial, along, n]) if pointing else np.eye(3)
    w = rate * n if pointing else np.zeros(3)
    found = found_at_start(carried({"orbit": orbit}))
    assert_carried(found, R * radial, A, R * rate * along, w, -R * rate**2 * radial, np.zeros(3))


def test_angle_speed_and_point_of_a_turning_ground():
    """It turns about an axis through a point that rests."""
    axis, point, speed, angle = np.array([2, 1, 2]) / 3, np.array([0.4, -1, 0.2]), 1.3, np.radians(35)
    motion = {"rotation": {"axis": [2, 1, 2], "speed": speed, "point": point.tolist(), "angle_deg": 35}}
    A = Rotation.from_rotvec(angle * axis).as_matrix()
    w = speed * axis
    out = -A @ point
    found = found_at_start(carried(motion))
    assert_carried(found, point + out, A, np.cross(w, out), w, np.cross(w, np.cross(w, out)), np.zeros(3))


def test_a_ground_that_gathers_speed():
    """x = position + velocity t + acceleration t^2 / 2."""
    x, v, a = np.array([1, 2, 3.0]), np.array([-0.5, 0.2, 0.1]), np.array([0.3, -0.6, 0.9])
    motion = {"acceleration": a.tolist(), "velocity": v.tolist(), "position": x.tolist()}
    run = Scene.model_validate(carried(motion)).simulate(2.0, 0.5)
    still = np.array(PLACE["position"])

    for k, t in enumerate(run["time"]):
        assert_near(run["a.position"][k], x + v * t + a * t**2 / 2 + still, 1e-12)
        assert_near(run["a.velocity"][k], v + a * t, 1e-12)
        assert_near(run["a.acceleration"][k], a, 1e-12)


@pytest.mark.parametrize("turned", ["euler_parameters", "zyx"])
def test_each_input_of_a_moved_ground_is_what_it_says(turned):
    """Three numbers of each kind, no two alike."""
    r, v, a = np.array([0.1, 0.2, 0.3]), np.array([1.1, -1.2, 1.3]), np.array([2.1, 2.2, -2.3])
    w, alpha = np.array([-0.4, 0.5, 0.6]), np.array([0.7, 0.8, -0.9])
    A = Rotation.from_euler("ZYX", [0.5, -0.3, 0.8])
    told = ["position", "velocity", "acceleration", turned, "omega", "alpha"]
    inputs = {"position": r, "velocity": v, "acceleration": a, "omega": w, "alpha": alpha}
    inputs |= {"euler_parameters": A.as_quat(), "zyx": [0.5, -0.3, 0.8]}
    found = found_at_start(carried({"input": told}), {f"ground.{key}": inputs[key] for key in told})
    assert_carried(found, r, A.as_matrix(), v, w, a, alpha)


def test_a_ground_told_by_a_table():
    """A screw motion, sampled: a quintic spline has its speeds and accelerations."""
    t = np.linspace(-0.5, 1.5, 401)
    w, v = 0.8, 0.3
    table = {"time": t.tolist(), "position": np.outer(v * t, [0, 0, 1]).tolist()}
    table |= {"zyx_rad": np.outer(w * t, [1, 0, 0]).tolist()}
    run = Scene.model_validate(carried({"table": table})).simulate(1.0, 0.25)

    for k, now in enumerate(run["time"]):
        found = {name: run[f"a.{name}"][k] for name in MOTION}
        A = Rotation.from_rotvec([0, 0, w * now]).as_matrix()
        assert_near(found["position"], [0, 0, v * now] + A @ PLACE["position"], 1e-10)
        assert_near(found["velocity"], [0, 0, v] + np.cross([0, 0, w], A @ PLACE["position"]), 1e-8)
        assert_near(found["acceleration"], -(w**2) * (A @ PLACE["position"]) * [1, 1, 0], 1e-6)


# drivers


@pytest.mark.parametrize("kind, quantity", [("revolute", "angle"), ("prismatic", "position")])
@pytest.mark.parametrize("phase", [0, 25, -120])
def test_phase_of_a_harmonic(kind, quantity, phase):
    """mean + amplitude sin(2 pi f t + phase), and its rates."""
    wave = {"amplitude": 0.4, "frequency": 0.8, "phase_deg": phase, "mean": -0.3}
    joint = {kind: {}, "between": ["ground", "a"], "driver": {"harmonic": wave}, "output": [quantity, "speed", "acceleration"]}
    scene = {"name": "h", "gravity": [0, 0, 0], "body": {"a": {"mass": 1, "inertia": [1, 1, 1]}}, "joint": {"j": joint}}
    run = Scene.model_validate(scene).simulate(1.0, 0.125)
    w = 2 * np.pi * 0.8
    at = w * run["time"] + np.radians(phase)
    assert_near(run[f"j.{quantity}"], -0.3 + 0.4 * np.sin(at), 1e-12)
    assert_near(run["j.speed"], 0.4 * w * np.cos(at), 1e-12)
    assert_near(run["j.acceleration"], -0.4 * w * w * np.sin(at), 1e-11)


QUINTIC = np.polynomial.Polynomial([0.2, -0.4, 0.3, 0.5, -0.6, 0.2])
TIMES = [0.0, 0.3, 0.7, 1.2, 1.4, 2.0]


def driven(driver, kind="prismatic"):
    """Position, speed and acceleration of a joint that is driven, over time."""
    joint = {kind: {}, "between": ["ground", "a"], "driver": driver, "output": ["position", "speed", "acceleration"]}
    scene = {"name": "d", "gravity": [0, 0, 0], "body": {"a": {"mass": 1, "inertia": [1, 1, 1]}}, "joint": {"j": joint}}
    run = Scene.model_validate(scene).simulate(1.9, 0.1)
    return run["time"], run["j.position"], run["j.speed"], run["j.acceleration"]


def test_six_points_make_a_polynomial_of_degree_five():
    """The quintic spline through six points has nothing else to be."""
    time, *found = driven({"table": {"time": TIMES, "position": QUINTIC(np.array(TIMES)).tolist(), "interpolation": "quintic"}})

    for order, values in enumerate(found):
        assert_near(values, QUINTIC.deriv(order)(time), 1e-12)


def test_the_position_of_speeds_is_their_integral():
    speeds = QUINTIC(np.array(TIMES)).tolist()
    time, *found = driven({"speed_table": {"time": TIMES, "speed": speeds, "interpolation": "quintic"}})
    assert_near(found[0], QUINTIC.integ()(time), 1e-12)
    assert_near(found[1], QUINTIC(time), 1e-12)
    assert_near(found[2], QUINTIC.deriv()(time), 1e-12)


# mass


@pytest.mark.parametrize("angle", [30, -75])
@pytest.mark.parametrize("axis", range(3))
def test_axes_of_an_inertia(axis, angle):
    """Turned by an angle about one axis: Mohr's circle of the other two."""
    I = np.array([0.5, 0.7, 0.9])
    i, j = (axis + 1) % 3, (axis + 2) % 3
    c, s = np.cos(np.radians(angle)), np.sin(np.radians(angle))
    expected = np.diag(I)
    expected[i, i] = I[i] * c * c + I[j] * s * s
    expected[j, j] = I[i] * s * s + I[j] * c * c
    expected[i, j] = expected[j, i] = (I[i] - I[j]) * s * c
    turn = {"axis_angle": {"axis": "xyz"[axis], "angle_deg": angle}}
    body = {"mass": 2, "inertia": I.tolist(), "inertia_axes": turn, "input": ["moment"], "output": ["alpha"]}
    scene = {"name": "i", "body": {"a": body}, "joint": {"f": {"free": {}, "between": ["ground", "a"]}}}
    assert_near(Scene.model_validate(scene).body["a"].mass_properties()[2], expected, 1e-15)

    for moment in np.eye(3):
        assert_near(expected @ found_at_start(scene, {"a.moment": moment})["a.alpha"], moment, 1e-14)


# forces


@pytest.mark.parametrize("kind", ["bushing", "linear"])
@pytest.mark.parametrize("first", ["ground", "base"])
def test_a_bushing_far_from_its_place(kind, first):
    """A turn of any size about one axis, and a displacement: -k x and -c x' in each direction of the first marker's axes, on the
    second marker; its reaction on the first body at the same place. By Newton and Euler both bodies' accelerations follow.
    """
    k, c = np.array([30.0, 40, 50, 6, 7, 8]), np.array([1.0, 2, 3, 0.4, 0.5, 0.6])
    A = Rotation.from_euler("ZYX", [0.5, 0.2, -0.4])
    moved, v = np.array([0.3, -0.2, 0.1]), np.array([0.5, 0.6, -0.7])
    turn, rate = np.array([0, 0, 1.1]), np.array([0, 0, -0.9])
    start = {
        "position": A.apply(moved).tolist(), "velocity": A.apply(v).tolist(),
        "euler_parameters": (A * Rotation.from_rotvec(turn)).as_quat().tolist(), "omega": A.apply(rate).tolist(),
    }  # fmt: skip
    marker = {"m": {"euler_parameters": A.as_quat().tolist()}}
    I1, I2, m1, m2 = 0.7, 0.4, 3.0, 2.0
    output = ["acceleration", "alpha"]
    spec = {"stiffness": k.tolist(), "damping": c.tolist()}

    if kind == "linear":
        spec = {key: np.diag(value).tolist() for key, value in spec.items()}

    scene = {
        "name": "b", "gravity": [0, 0, 0], "ground": {"marker": marker},
        "body": {"a": {"mass": m2, "inertia": [I2] * 3, "output": output}},
        "joint": {"f": {"free": {}, "between": ["ground", "a"], "start": start}},
        "force": {"e": {kind: spec, "between": [f"{first}.m", "a"], "output": ["force", "moment"]}},
    }  # fmt: skip

    if first == "base":
        scene["body"]["base"] = {"mass": m1, "inertia": [I1] * 3, "marker": marker, "output": output}
        scene["joint"]["g"] = {"free": {}, "between": ["ground", "base"]}

    found = found_at_start(scene)
    force, moment = -k[:3] * moved - c[:3] * v, -k[3:] * turn - c[3:] * rate
    assert_near(found["e.force"], force, 1e-13)
    assert_near(found["e.moment"], moment, 1e-13)
    assert_near(found["a.acceleration"], A.apply(force) / m2, 1e-13)
    assert_near(found["a.alpha"], A.apply(moment) / I2, 1e-13)

    if first == "base":
        assert_near(found["base.acceleration"], -A.apply(force) / m1, 1e-13)
        assert_near(found["base.alpha"], -A.apply(moment + np.cross(moved, force)) / I1, 1e-13)
