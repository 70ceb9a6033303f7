"""What single keys of a scene mean, each in a closed form that it enters: phases, axes, which input is which."""

import numpy as np
import pytest
from scenes import assert_near
from scipy.spatial.transform import Rotation
from test_powers import named_outputs

from mbdfmi import Scene
from mbdfmi.run.instance import Instance

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
    expected |= {
        f"{key}_body": turned.T @ expected[key] for key in ("velocity", "acceleration", "omega", "alpha")
    }
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
    n = {"z": [0, 0, 1], "-y": [0, -1, 0], "x": [1, 0, 0]}.get(
        normal if isinstance(normal, str) else "", normal
    )
    n = np.array(n) / np.linalg.norm(n)
    e, track = plane_of(n)
    radial = np.cos(phase) * e + np.sin(phase) * track
    along = np.cross(n, radial)
    A = np.column_stack([radial, along, n]) if pointing else np.eye(3)
    w = rate * n if pointing else np.zeros(3)
    found = found_at_start(carried({"orbit": orbit}))
    assert_carried(found, R * radial, A, R * rate * along, w, -R * rate**2 * radial, np.zeros(3))


@pytest.mark.parametrize("formulation", ["recursive", "embedding", "augmented"])
def test_angle_speed_and_point_of_a_turning_ground(formulation):
    """It turns about an axis through a point that rests."""
    axis, point, speed, angle = np.array([2, 1, 2]) / 3, np.array([0.4, -1, 0.2]), 1.3, np.radians(35)
    motion = {"rotation": {"axis": [2, 1, 2], "speed": speed, "point": point.tolist(), "angle_deg": 35}}
    A = Rotation.from_rotvec(angle * axis).as_matrix()
    w = speed * axis
    out = -A @ point
    found = found_at_start(carried(motion, solver={"formulation": formulation}))
    assert_carried(found, point + out, A, np.cross(w, out), w, np.cross(w, np.cross(w, out)), np.zeros(3))


@pytest.mark.parametrize("formulation", ["recursive", "embedding", "augmented"])
def test_a_free_body_starts_as_a_turned_ground_sees_it(formulation):
    """Place, axes and velocities of its start are in the ground's axes, which turn."""
    r, v, w_rel = np.array([1, -2, 0.5]), np.array([0.3, 0.4, -0.2]), np.array([0.2, -0.1, 0.6])
    seen = Rotation.from_euler("ZYX", [40, 20, -30], degrees=True)
    A = Rotation.from_rotvec([0, 0, np.radians(35)])
    w = np.array([0, 0, 1.3])
    start = {
        "position": r.tolist(),
        "velocity": v.tolist(),
        "zyx_deg": [40, 20, -30],
        "omega": w_rel.tolist(),
    }
    scene = {
        "name": "free", "solver": {"formulation": formulation},
        "ground": {"motion": {"rotation": {"speed": 1.3, "angle_deg": 35}}},
        "body": {"a": {"mass": 1, "inertia": [0.1, 0.2, 0.25], "output": MOTION}},
        "joint": {"f": {"free": {}, "between": ["ground", "a"], "start": start}},
    }  # fmt: skip
    found = found_at_start(scene)
    assert_near(found["a.position"], A.apply(r), 1e-12)
    assert_near(found["a.velocity"], A.apply(v) + np.cross(w, A.apply(r)), 1e-12)
    assert_same_turn(found["a.euler_parameters"], (A * seen).as_matrix())
    assert_near(found["a.omega"], w + A.apply(w_rel), 1e-12)
    assert_near(found["a.acceleration"], [0, 0, -9.81], 1e-12)


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


@pytest.mark.parametrize("beside", [[], ["omega"], ["velocity", "omega"]])
@pytest.mark.parametrize("turned", ["euler_parameters", "zyx"])
def test_a_ground_told_by_its_pose(turned, beside):
    """Angles that grow evenly, told step by step: once some are known, the ground turns at their rate, be it told or not."""
    angles, rates = np.array([0.2, -0.3, 0.4]), np.array([0.3, 0.2, -0.1])
    r, v = np.array([1, 2, 3.0]), np.array([0.5, -0.4, 0.2])
    instance = Instance(Scene.model_validate(carried({"input": ["position", turned, *beside]})).compile())
    place = {v.name: v.index for v in instance.model.of_causality("input")}
    H = 1 / 64

    def tell(t):
        A = Rotation.from_euler("ZYX", angles + rates * t)
        yaw = angles[0] + rates[0] * t

        # w = yaw' z + pitch' y1 + roll' x2
        w = (
            rates[0] * np.array([0, 0, 1])
            + rates[1] * np.array([-np.sin(yaw), np.cos(yaw), 0])
            + rates[2] * A.as_matrix()[:, 0]
        )
        told = {
            "position": r + v * t,
            "zyx": angles + rates * t,
            "euler_parameters": A.as_quat(),
            "velocity": v,
            "omega": w,
        }

        for key in ("position", turned, *beside):
            for k, value in enumerate(told[key], 1):
                instance.u[place[f"ground.{key}[{k}]"]] = value

        return A, w

    for n in range(6):
        A, _ = tell(n * H)
        found = named_outputs(instance)
        assert_same_turn(found["a.euler_parameters"], A.as_matrix() @ AXES)
        assert_near(found["a.position"], r + v * n * H + A.apply(PLACE["position"]), 1e-12)
        instance.step(H)

    A, w = tell(6 * H)
    found = named_outputs(instance)
    near = 1e-11 if turned == "zyx" or beside else 1e-5
    assert_near(found["a.omega"], w, near)
    assert_near(found["a.velocity"], v + np.cross(w, A.apply(PLACE["position"])), near)


# drivers


def test_a_command_that_begins_to_move_evenly_is_followed():
    """At rest, then at a constant speed, told by the position alone: from the second command after the corner on it is met."""
    joint = {
        "prismatic": {},
        "between": ["ground", "a"],
        "driver": {"input": ["position"]},
        "output": ["position", "speed"],
    }
    scene = {"name": "corner", "body": {"a": {"mass": 1, "inertia": [1, 1, 1]}}, "joint": {"j": joint}}
    instance = Instance(Scene.model_validate(scene).compile())
    H, v = 0.125, 0.8
    met = []

    for n in range(12):
        instance.u[0] = v * H * max(0, n - 4)
        instance.step(H)
        found = named_outputs(instance)
        met.append(found["j.position"] - v * H * max(0, n - 3))

    # nothing moves before; the corner itself, and one step more, are missed by what no one could know
    assert_near(met[:4], 0.0, 1e-14)
    assert_near(met[4], -v * H, 1e-14)
    assert_near(met[6:], 0.0, 1e-12)


@pytest.mark.parametrize("begin", [0.0, 0.7])
def test_a_motion_that_starts_later(begin):
    """Where a driver's joint is at the start time, and what a coupling makes follow."""
    wave = {"amplitude": 0.4, "frequency": 0.3, "mean": 0.1}
    slide = {"prismatic": {}, "output": ["position", "speed"]}
    scene = {
        "name": "later", "body": {name: {"mass": 1, "inertia": [1, 1, 1]} for name in "ab"},
        "joint": {
            "a": slide | {"between": ["ground", "a"], "driver": {"harmonic": wave}}, "b": slide | {"between": ["ground", "b"]},
        },
        "coupling": {"rope": {"linear": {"ratio": -2, "offset": 0.5}, "between": ["a", "b"]}},
    }  # fmt: skip
    model = Scene.model_validate(scene).compile()
    found = named_outputs(Instance(model, start_time=begin))
    w = 2 * np.pi * 0.3
    x, v = 0.1 + 0.4 * np.sin(w * begin), 0.4 * w * np.cos(w * begin)
    assert_near([found["a.position"], found["a.speed"]], [x, v], 1e-14)
    assert_near([found["b.position"], found["b.speed"]], [0.5 - 2 * x, -2 * v], 1e-12)


@pytest.mark.parametrize("kind, quantity", [("revolute", "angle"), ("prismatic", "position")])
@pytest.mark.parametrize("phase", [0, 25, -120])
def test_phase_of_a_harmonic(kind, quantity, phase):
    """mean + amplitude sin(2 pi f t + phase), and its rates."""
    wave = {"amplitude": 0.4, "frequency": 0.8, "phase_deg": phase, "mean": -0.3}
    joint = {
        kind: {},
        "between": ["ground", "a"],
        "driver": {"harmonic": wave},
        "output": [quantity, "speed", "acceleration"],
    }
    scene = {
        "name": "h",
        "gravity": [0, 0, 0],
        "body": {"a": {"mass": 1, "inertia": [1, 1, 1]}},
        "joint": {"j": joint},
    }
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
    joint = {
        kind: {},
        "between": ["ground", "a"],
        "driver": driver,
        "output": ["position", "speed", "acceleration"],
    }
    scene = {
        "name": "d",
        "gravity": [0, 0, 0],
        "body": {"a": {"mass": 1, "inertia": [1, 1, 1]}},
        "joint": {"j": joint},
    }
    run = Scene.model_validate(scene).simulate(1.9, 0.1)
    return run["time"], run["j.position"], run["j.speed"], run["j.acceleration"]


def test_six_points_make_a_polynomial_of_degree_five():
    """The quintic spline through six points has nothing else to be."""
    time, *found = driven(
        {"table": {"time": TIMES, "position": QUINTIC(np.array(TIMES)).tolist(), "interpolation": "quintic"}}
    )

    for order, values in enumerate(found):
        assert_near(values, QUINTIC.deriv(order)(time), 1e-12)


def test_samples_of_a_sine_are_a_sine():
    """Where smooth tables hold what leaves its points, peaks on both sides are let out."""
    t = np.arange(0.0, 2.01, 0.05)
    time, *found = driven({"table": {"time": t.tolist(), "position": np.sin(7 * t + 0.3).tolist()}})

    for order, values in enumerate(found):
        right = 7**order * np.sin(7 * time + 0.3 + order * np.pi / 2)
        assert_near(values[3:-3], right[3:-3], 7**order * [1e-6, 1e-5, 1e-3][order])


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


@pytest.mark.parametrize("formulation", ["recursive", "embedding"])
def test_a_rack_without_mass(formulation):
    """It follows its wheel, which alone has inertia: alpha = T / I."""
    T, I, radius = 2.0, 0.1, 0.5
    scene = {
        "name": "rack", "gravity": [0, 0, 0], "solver": {"formulation": formulation},
        "body": {"wheel": {"mass": 1, "inertia": [I] * 3}, "rack": {"mass": 0, "inertia": [0, 0, 0]}},
        "joint": {
            "wheel": {"revolute": {}, "between": ["ground", "wheel"], "input": "torque", "output": ["acceleration"]},
            "rack": {"prismatic": {"axis": "x"}, "between": ["ground", "rack"], "output": ["acceleration"]},
        },
        "coupling": {"mesh": {"rack": {"radius": radius}, "between": ["wheel", "rack"]}},
    }  # fmt: skip
    found = found_at_start(scene, {"wheel.torque": T})
    assert_near(found["wheel.acceleration"], T / I, 1e-12)
    assert_near(found["rack.acceleration"], radius * T / I, 1e-12)


# starts


@pytest.mark.parametrize("kind", ["spherical", "free"])
@pytest.mark.parametrize("ends", [["ground", "a"], ["a", "ground"]])
def test_a_start_that_is_kept_is_not_told(kind, ends):
    """Whichever end comes first, beside a coupling that has to be met."""
    start = {"zyx_deg": [30, -20, 50], "omega": [0.3, -0.2, 0.5]}
    start |= {"position": [1, 2, 3], "velocity": [0.5, 0.4, 0.3]} if kind == "free" else {}
    slide = {"prismatic": {}}
    scene = {
        "name": "kept", "body": {name: {"mass": 1, "inertia": [0.1, 0.2, 0.25], "output": ["omega"]} for name in "abc"},
        "joint": {
            "j": {kind: {}, "between": ends, "start": start, "output": ["euler_parameters"]},
            "b": slide | {"between": ["ground", "b"], "start": {"position": 0.2}}, "c": slide | {"between": ["ground", "c"]},
        },
        "coupling": {"rope": {"linear": {"ratio": -2, "offset": 0.5}, "between": ["b", "c"]}},
    }  # fmt: skip
    instance = Instance(Scene.model_validate(scene).compile())
    found = named_outputs(instance)
    A = Rotation.from_euler("ZYX", [30, -20, 50], degrees=True)
    assert instance.notices == []
    assert_same_turn(found["j.euler_parameters"], A.as_matrix())
    w = np.array(start["omega"])
    assert_near(found["a.omega"], w if ends[0] == "ground" else -A.inv().apply(w), 1e-14)


def test_the_place_given_to_a_free_body_is_kept():
    """A hinge without a start goes to where a rod of length 1 reaches the body."""
    scene = {
        "name": "place", "gravity": [0, 0, 0],
        "body": {
            "p": {"mass": 1, "inertia": [0.1, 0.1, 0.1], "output": ["position"]},
            "h": {"mass": 1, "inertia": [0.1, 0.1, 0.1], "marker": {"m": {"position": [1, 0, 0]}}},
        },
        "joint": {
            "h": {"revolute": {}, "between": ["ground", "h"], "output": ["angle"]},
            "f": {"free": {}, "between": ["ground", "p"], "start": {"position": [1, 1.2, 0]}},
            "rod": {"distance": {"length": 1.0}, "between": ["h.m", "p"]},
        },
    }  # fmt: skip
    instance = Instance(Scene.model_validate(scene).compile())
    found = named_outputs(instance)
    assert_near(found["p.position"], [1, 1.2, 0], 1e-12)
    assert_near(np.hypot(np.cos(found["h.angle"]) - 1, np.sin(found["h.angle"]) - 1.2), 1.0, 1e-9)


@pytest.mark.parametrize("formulation", ["recursive", "embedding", "augmented"])
def test_a_gear_on_a_hinge_that_closes_a_loop_starts_beyond_a_turn(formulation):
    """Of two hinges on one axis one closes a loop; the gear is at that one: ten times 300 degrees."""
    hinge = {"revolute": {}, "output": ["angle"]}
    scene = {
        "name": "gear", "solver": {"formulation": formulation},
        "body": {name: {"mass": 1, "inertia": [0.1, 0.1, 0.1]} for name in ("m", "w")},
        "joint": {
            "m": hinge | {"between": ["ground", "m"], "start": {"angle_deg": 300}},
            "h1": hinge | {"between": ["ground", "w"]}, "h2": hinge | {"between": ["ground", "w"]},
        },
        "coupling": {"g": {"gear": {"ratio": 10, "offset": 0}, "between": ["m", "h2"]}},
    }  # fmt: skip
    instance = Instance(Scene.model_validate(scene).compile())
    found = {name: np.degrees(value) for name, value in named_outputs(instance).items()}
    assert instance.notices == []
    assert_near([found["m.angle"], found["h2.angle"]], [300, 3000], 1e-9)
    assert_near(np.cos(np.radians(found["h1.angle"] - 3000)), 1.0, 1e-14)


# curves and surfaces


def bead(shape, place, velocity, formulation="recursive"):
    """Acceleration of a particle that slides on a curve or surface of the ground without other forces."""
    kind = next(iter(shape))
    scene = {
        "name": "bead", "gravity": [0, 0, 0], "solver": {"formulation": formulation}, "ground": {"marker": {"m": shape}},
        "body": {"p": {"mass": 2, "inertia": [0, 0, 0], "output": ["acceleration", "velocity"]}},
        "joint": {
            "t": {"translation": {}, "between": ["ground", "p"], "start": {"position": place, "velocity": velocity}},
            "c": {f"point_on_{kind}": {}, "between": ["ground.m", "p"]},
        },
    }  # fmt: skip
    found = found_at_start(scene)
    assert_near(found["p.velocity"], velocity, 1e-12)
    return found["p.acceleration"]


# shape, place, velocity, acceleration: the square of the speed times the curvature, towards its centre
V = 1.5
BEADS = {
    "circle": ({"curve": {"circle": {"radius": 2.0}}}, [0, 2, 0], [-V, 0, 0], [0, -V * V / 2, 0]),
    "top of a parabola": ({"curve": {"parabola": {"coefficient": -0.7}}}, [0, 0, 0], [V, 0, 0], [0, -1.4 * V * V, 0]),
    "foot of a cycloid": ({"curve": {"cycloid": {"radius": 0.5}}}, [0, 0, 0], [V, 0, 0], [0, V * V / 2, 0]),
    "plane": ({"surface": {"plane": {}}}, [0.3, 0.2, 0], [V, 2 * V, 0], [0, 0, 0]),
    "sphere": ({"surface": {"sphere": {"radius": 2.0}}}, [0, 2, 0], [V, 0, 0], [0, -V * V / 2, 0]),
    "round a cylinder": ({"surface": {"cylinder": {"radius": 2.0}}}, [2, 0, 1], [0, V, 3], [-V * V / 2, 0, 0]),
    "round a torus": ({"surface": {"torus": {"radius": 2.0, "tube": 0.5}}}, [0, 2.5, 0], [V, 0, 0], [0, -V * V / 2.5, 0]),
    "inside a torus": ({"surface": {"torus": {"radius": 2.0, "tube": 0.5}}}, [1.5, 0, 0], [0, V, 0], [-V * V / 1.5, 0, 0]),
    "round its tube": ({"surface": {"torus": {"radius": 2.0, "tube": 0.5}}}, [2.5, 0, 0], [0, 0, V], [-V * V / 0.5, 0, 0]),
    "over a prism": (
        {"surface": {"prism": {"profile": {"parabola": {"coefficient": 0.7}}}}}, [0, 0, 2], [V, 0, V], [0, 1.4 * V * V, 0],
    ),
}  # fmt: skip


@pytest.mark.parametrize("formulation", ["recursive", "augmented"])
@pytest.mark.parametrize("name", BEADS)
def test_curvatures(name, formulation):
    shape, place, velocity, acceleration = BEADS[name]
    assert_near(bead(shape, place, velocity, formulation), acceleration, 1e-10)


@pytest.mark.parametrize("ratio", [0.5, 3.0])
def test_a_circle_that_slides_round_a_circle(ratio):
    """Its centre goes round at the sum of the radii; that it spins changes nothing."""
    R, V = 2.0, 1.5
    r = ratio * R
    start = {"position": [0, R + r], "velocity": [V, 0], "angular_speed": 0.8}
    plane = {"planar": {}, "between": ["ground", "p"], "start": start}
    scene = {
        "name": "circles", "gravity": [0, 0, 0], "ground": {"marker": {"m": {"curve": {"circle": {"radius": R}}}}},
        "body": {
            "p": {
                "mass": 2, "inertia": [1, 1, 1], "output": ["acceleration", "velocity", "alpha"],
                "marker": {"m": {"curve": {"circle": {"radius": r}}}},
            }
        },
        "joint": {"t": plane, "c": {"curve_on_curve": {}, "between": ["ground.m", "p.m"]}},
    }  # fmt: skip
    found = found_at_start(scene)
    assert_near(found["p.velocity"], [V, 0, 0], 1e-12)
    assert_near(found["p.acceleration"], [0, -V * V / (R + r), 0], 1e-10)
    assert_near(found["p.alpha"], [0, 0, 0], 1e-10)


# the solver


def test_short_communication_steps_cost_next_to_nothing():
    """Inner steps lead past communication points."""
    hinge = {"revolute": {"axis": "y"}, "between": ["ground", "a"], "start": {"angle": 0.5}}
    body = {"a": {"mass": 1, "com": [0, 0, -1], "inertia": [0.1, 0.1, 0.1]}}
    scene = Scene(name="p", solver={"output": ["evaluations"]}, body=body, joint={"h": hinge})
    few, many = (scene.simulate(1.0, H)["solver.evaluations"][-1] for H in (0.5, 0.002))
    assert many < 1.3 * few


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
