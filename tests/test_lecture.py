"""The examples of K. Y. Lee's lecture "Topics in Ship Design Automation" (Seoul National
University, 2010) in closed form.

Section numbers are the lecture's ([Lee] in docs/theory.md). Each example that has constraints runs in all three formulations.
"""

from pathlib import Path

import numpy as np
import pytest

import mbdfmi
from mbdfmi import Scene

MODELS = Path(__file__).parents[1] / "models"
FORMULATIONS = ["recursive", "embedding", "augmented"]
G = 9.81
DOWN = [0, -G, 0]
PARTICLE = {"mass": 2.0, "inertia": [0, 0, 0]}

all_formulations = pytest.mark.parametrize("formulation", FORMULATIONS)


def start(scene, formulation="auto", inputs=None):
    """Outputs at the start by name, arrays whole."""
    tables = scene if isinstance(scene, dict) else scene.model_dump(exclude_unset=True)
    tables = tables | {"solver": {"tolerance": 1e-12, "formulation": formulation}}
    tables.setdefault("name", "example")
    results = Scene(**tables).simulate(1e-9, inputs=inputs)
    return {name: results[name][0] for name in {*results, *(name.partition("[")[0] for name in results)}}


# chapter 1: particles seen from moving frames


@pytest.mark.parametrize("a", [0.0, 2.5, -G])
def test_elevator(a):
    """1.2: a scale in an elevator that accelerates upwards shows m (g + a); nothing in free
    fall.
    """
    y = start(
        {
            "ground": {"motion": {"acceleration": [0, 0, a]}},
            "body": {"person": {"mass": 70.0, "inertia": [1, 1, 1]}},
            "joint": {"scale": {"fixed": {}, "between": ["ground", "person"], "output": ["reaction_force"]}},
        }
    )
    np.testing.assert_allclose(y["scale.reaction_force"], [0, 0, 70 * (G + a)], atol=1e-11)


def test_falling_in_an_elevator():
    """1.2: who falls beside an elevator sees nothing of gravity but how the elevator moves."""
    y = start(
        {
            "ground": {"motion": {"acceleration": [0, 0, 1.5]}},
            "body": {"ball": PARTICLE | {"output": ["acceleration"]}},
            "joint": {"free": {"translation": {}, "between": ["ground", "ball"]}},
            "measure": {"seen": {"between": ["ground", "ball"], "output": ["acceleration"]}},
        }
    )
    np.testing.assert_allclose(y["ball.acceleration"], [0, 0, -G], atol=1e-14)
    np.testing.assert_allclose(y["seen.acceleration"], [0, 0, -G - 1.5], atol=1e-14)


def chair(speed, omega=2.0, radius=1.5):
    """A chair that moves along a line on a turning disk, driven at a constant speed."""
    return {
        "ground": {"motion": {"rotation": {"speed": omega}}},
        "body": {"chair": {"mass": 60.0, "inertia": [2, 2, 2], "output": ["acceleration"]}},
        "joint": {
            "line": {
                "prismatic": {"axis": "x"},
                "between": ["ground", "chair"],
                "start": {"position": radius},
                "driver": {"constant_speed": speed},
                "output": ["reaction_force", "effort"],
            }
        },
    }


@pytest.mark.parametrize("speed", [0.0, 0.7])
def test_chair_on_a_turning_disk(speed):
    """1.8: its acceleration is -w^2 r inwards and 2 w v to the side; the disk must exert m times
    that.
    """
    y = start(chair(speed))
    expected = np.array([-(2.0**2) * 1.5, 2 * 2.0 * speed, 0])
    np.testing.assert_allclose(y["chair.acceleration"], expected, atol=1e-12)
    np.testing.assert_allclose(y["line.reaction_force"], 60 * (expected + [0, 0, G]), atol=1e-10)
    np.testing.assert_allclose(y["line.effort"], 60 * expected[0], atol=1e-10)


def test_ball_in_a_slot_with_constant_velocity():
    """1.9: who stands on the disk sees a straight line, who stands beside it a spiral of
    Archimedes.
    """
    scene = chair(0.4, radius=0.0)
    scene["body"]["chair"]["output"] = ["position", "velocity"]
    t = np.linspace(0, 3, 31)
    found = Scene(name="slot", **scene).simulate(3.0, 0.1)
    r, angle = 0.4 * t, 2.0 * t
    np.testing.assert_allclose(found["chair.position"][:, 0], r * np.cos(angle), atol=1e-9)
    np.testing.assert_allclose(found["chair.position"][:, 1], r * np.sin(angle), atol=1e-9)
    np.testing.assert_allclose(
        found["chair.velocity"][:, 0], 0.4 * np.cos(angle) - 2 * r * np.sin(angle), atol=1e-9
    )


def test_ball_in_a_free_slot():
    """1.8: without friction it runs outwards as cosh; the slot's side bears the Coriolis force 2 m
    w r'.
    """
    scene = mbdfmi.load(MODELS / "turntable.toml")
    found = scene.simulate(2.0, 0.1)
    w, t = 20 * np.pi / 30, found["time"]
    r = 0.05 * np.cosh(w * t) + 0.3 / w * np.sinh(w * t)
    rate = 0.05 * w * np.sinh(w * t) + 0.3 * np.cosh(w * t)

    np.testing.assert_allclose(found["slot.position"], r, rtol=1e-6)
    np.testing.assert_allclose(found["slot.reaction_force"][:, 1], 2 * 0.2 * w * rate, rtol=1e-6)
    np.testing.assert_allclose(found["slot.reaction_force"][:, 2], 0.2 * G, rtol=1e-12)
    np.testing.assert_allclose(found["ball.position"][:, 1], r * np.sin(w * t), atol=1e-5)


def test_thrown_ball_seen_from_a_turntable():
    """1.9: it flies straight on, and along a curve as the disk turns under it."""
    w, v = 1.3, np.array([2.0, 0.5, 0.0])
    scene = {
        "name": "thrown",
        "gravity": [0, 0, 0],
        "solver": {"tolerance": 1e-11},
        "ground": {"motion": {"rotation": {"speed": w}}},
        "body": {"ball": PARTICLE | {"output": ["position"]}},
        "joint": {
            "free": {
                "translation": {},
                "between": ["ground", "ball"],
                "start": {"velocity": v.tolist()},
                "output": ["position"],
            }
        },
    }
    found = Scene(**scene).simulate(4.0, 0.1)
    t = found["time"][:, None]
    np.testing.assert_allclose(found["ball.position"], v * t, atol=1e-8)
    turned = np.column_stack([np.cos(w * t), np.sin(w * t), -np.sin(w * t), np.cos(w * t)]).reshape(-1, 2, 2)
    np.testing.assert_allclose(
        found["free.position"][:, :2], np.squeeze(turned @ (v[:2] * t)[..., None]), atol=1e-8
    )


def test_projectile_along_a_meridian():
    """1.4: a'' = -(w^2 + g^2) part in the equator's plane, -g^2 part along the axis, Coriolis 2 w
    g to the side.

    r = R (cos gt b + sin gt k), b turning at w about k.
    """
    R, w, g, latitude = 6.4e6, 7.3e-5, 1.2e-3, 0.6
    hinge = {"between": ["ground", "earth"], "revolute": {"axis": "z"}, "driver": {"constant_speed": w}}
    y = start(
        {
            "gravity": [0, 0, 0],
            "body": {
                "earth": {"mass": 1.0, "inertia": [1, 1, 1]},
                "carrier": {
                    "mass": 1.0,
                    "inertia": [1, 1, 1],
                    "marker": {"projectile": {"position": [R, 0, 0], "output": ["acceleration"]}},
                },
            },
            "joint": {
                "day": hinge,
                "flight": {
                    "revolute": {"axis": "-y"},
                    "between": ["earth", "carrier"],
                    "start": {"angle": latitude},
                    "driver": {"constant_speed": g},
                },
            },
        }
    )
    c, s = np.cos(latitude), np.sin(latitude)
    expected = R * np.array([-(w**2 + g**2) * c, -2 * w * g * s, -(g**2) * s])
    np.testing.assert_allclose(y["carrier.projectile.acceleration"], expected, rtol=1e-12)


# chapter 3: one body that is constrained


@all_formulations
def test_vehicle_on_a_straight_track(formulation):
    """3.2, 3.3: r'' = J g sin(theta) with J = (cos, -sin), the reaction is m g cos(theta) (sin,
    cos).
    """
    theta = 0.4
    c, s = np.cos(theta), np.sin(theta)
    y = start(
        {
            "gravity": DOWN,
            "ground": {"marker": {"track": {"axes": {"x": [c, -s, 0], "y": [s, c, 0]}}}},
            "body": {"vehicle": {"mass": 3.0, "inertia": [1, 1, 1], "output": ["acceleration"]}},
            "joint": {
                "wheels": {
                    "prismatic": {"axis": "x"},
                    "between": ["ground.track", "vehicle"],
                    "start": {"position": 0.8, "speed": -2.0},
                    "output": ["acceleration", "reaction_force"],
                }
            },
        },
        formulation,
    )
    assert y["wheels.acceleration"] == pytest.approx(G * s, rel=1e-13)
    np.testing.assert_allclose(y["vehicle.acceleration"], G * s * np.array([c, -s, 0]), atol=1e-13)
    np.testing.assert_allclose(y["wheels.reaction_force"], [0, 3 * G * c, 0], atol=1e-12)


@all_formulations
def test_vehicle_on_a_turning_track(formulation):
    """3.2, 3.3: J^T M J q'' + J^T M J' q' = J^T F with r = q1 (cos q2, -sin q2): M and k of the
    lecture, by rows.
    """
    rng = np.random.default_rng(1)
    scene = mbdfmi.load(MODELS / "turning_track.toml").model_dump(exclude_unset=True)

    # a free body without inertia would be singular; the lecture's vehicle does not turn
    scene["body"]["vehicle"]["inertia"] = [1e-9] * 3

    for _ in range(5):
        q1, v1, q2, v2 = rng.uniform(-2, 2, 4)
        scene["joint"]["wheels"]["start"] = {"position": q1, "speed": v1}
        scene["joint"]["hinge"]["start"] = {"angle": q2, "speed": v2}
        y = start(scene, formulation)
        m, inertia = 2.0, 3.0 + 1e-9
        J = np.array([[np.cos(q2), -q1 * np.sin(q2)], [-np.sin(q2), -q1 * np.cos(q2)], [0, 1]])
        rate = np.array(
            [
                [-np.sin(q2) * v2, -v1 * np.sin(q2) - q1 * np.cos(q2) * v2],
                [-np.cos(q2) * v2, -v1 * np.cos(q2) + q1 * np.sin(q2) * v2],
                [0, 0],
            ]
        )
        M, F = np.diag([m, m, inertia]), np.array([0, -m * G, 0])
        expected = np.linalg.solve(J.T @ M @ J, J.T @ (F - M @ rate @ [v1, v2]))
        found = [y["wheels.acceleration"], y["hinge.acceleration"]]
        np.testing.assert_allclose(found, expected, rtol=1e-10, atol=1e-10)

        # from the track on the vehicle, at right angles to it: 2 m q1' q2' + m q1 q2'' against the
        # weight's part
        side = -m * (2 * v1 * v2 + q1 * expected[1]) + m * G * np.cos(q2)
        np.testing.assert_allclose(y["wheels.reaction_force"][:2], [0, side], atol=1e-7)


@all_formulations
def test_pendulum_in_relative_coordinates(formulation):
    """3.4: m l^2 q'' = -m g l sin q; the hinge bears m (g cos q + l q'^2) along the rod.

    The lecture's bob is a particle. Here it is a ball of moment of inertia I, for a body that is
    free but for its constraints needs one: with m l^2 + I for m l^2 the formula holds, and across
    the rod the hinge bears I q'' / l.
    """
    q, v, length, inertia = 0.7, 1.9, 1.3, 1e-3
    body = {"mass": 2.0, "com": [0, -length, 0], "inertia": [inertia] * 3}
    joint = {"revolute": {}, "between": ["ground", "bob"], "start": {"angle": q, "speed": v}}
    joint["output"] = ["acceleration", "reaction_force_body"]
    y = start({"gravity": DOWN, "body": {"bob": body}, "joint": {"hinge": joint}}, formulation)
    acceleration = -2 * G * length * np.sin(q) / (2 * length**2 + inertia)
    along, across = 2 * (G * np.cos(q) + length * v**2), -inertia * acceleration / length

    assert y["hinge.acceleration"] == pytest.approx(acceleration, rel=1e-11)
    np.testing.assert_allclose(y["hinge.reaction_force_body"], [across, along, 0], atol=1e-9)


@all_formulations
def test_pendulum_in_absolute_coordinates(formulation):
    """3.5: M r'' + C_r^T lambda = F, C = x^2 + y^2 - l^2, as a particle on a massless rod; the
    same motion.
    """
    q, v, length = 0.7, 1.9, 1.3
    r = length * np.array([np.sin(q), -np.cos(q), 0])
    u = length * v * np.array([np.cos(q), np.sin(q), 0])
    bob = PARTICLE | {"inertia": [1, 1, 1], "output": ["acceleration"]}
    place = {
        "translation": {},
        "between": ["ground", "bob"],
        "start": {"position": r.tolist(), "velocity": u.tolist()},
    }
    rod = {"distance": {}, "between": ["ground", "bob"], "output": ["reaction_force"]}
    y = start({"gravity": DOWN, "body": {"bob": bob}, "joint": {"place": place, "rod": rod}}, formulation)

    # the lecture's augmented equations of x'', y'', lambda
    x, h = r[:2]
    A = np.array([[2, 0, 2 * x], [0, 2, 2 * h], [2 * x, 2 * h, 0]])
    *expected, multiplier = np.linalg.solve(A, [0, -2 * G, -2 * (u @ u)])
    np.testing.assert_allclose(y["bob.acceleration"], [*expected, 0], atol=1e-12)
    np.testing.assert_allclose(y["rod.reaction_force"], -2 * multiplier * r, atol=1e-11)


# chapter 5: inverse and forward dynamics


def sliders(n):
    """n bodies on prismatic joints in a row, along x."""
    masses = [1.0 + 0.5 * k for k in range(n)]
    body = {f"b{k}": {"mass": m, "inertia": [1, 1, 1]} for k, m in enumerate(masses)}
    joint = {
        f"q{k}": {
            "prismatic": {"axis": "x"},
            "between": [f"b{k - 1}" if k else "ground", f"b{k}"],
            "input": "force",
            "output": ["acceleration"],
        }
        for k in range(n)
    }
    return Scene(name="sliders", gravity=[0, 0, 0], body=body, joint=joint), np.array(masses)


def test_two_prismatic_joints():
    """5.1 to 5.4: F = [[m1 + m2, m2], [m2, m2]] q''."""
    scene, (m1, m2) = sliders(2)
    found = scene.inverse(
        {"q0.position": lambda t: t**2, "q1.position": lambda t: -0.5 * t**2 + t}, np.linspace(0, 1, 11)
    )
    F1, F2 = np.array([[m1 + m2, m2], [m2, m2]]) @ [2.0, -1.0]
    np.testing.assert_allclose(found["q0.force"], F1, rtol=1e-9)
    np.testing.assert_allclose(found["q1.force"], F2, rtol=1e-9)


@pytest.mark.parametrize("n", [2, 3, 20])
@all_formulations
def test_n_prismatic_joints(formulation, n):
    """5.3, 5.4: F_n - F_n+1 = m_n x_n'', q_n'' = x_n'' - x_n-1'': forwards and backwards, with as
    many steps as bodies.
    """
    scene, masses = sliders(n)
    rng = np.random.default_rng(n)
    q = rng.normal(size=n)
    motion = {f"q{k}.position": 0.0 for k in range(n)} | {f"q{k}.acceleration": q[k] for k in range(n)}
    found = scene.inverse(motion | {f"q{k}.speed": 0.0 for k in range(n)}, times=[0.0])
    efforts = np.array([found[f"q{k}.force"][0] for k in range(n)])
    expected = np.cumsum((masses * np.cumsum(q))[::-1])[::-1]
    np.testing.assert_allclose(efforts, expected, atol=1e-11)

    y = start(scene, formulation, {f"q{k}.force": expected[k] for k in range(n)})
    np.testing.assert_allclose([y[f"q{k}.acceleration"] for k in range(n)], q, atol=1e-9)


def newton_euler(links, angles, speeds, accelerations):
    """Torques of a planar arm by the lecture's recursion (5.5): out for the accelerations of G,
    back for

    F_O = F_G + F_O', tau = M_G + r_G/O x F_G + tau' + r_O'/O x F_O', the weight part of F_G here.

    links : (mass, distance of G, moment of inertia about G, length) of each.
    """

    def cross(a, b):
        return a[0] * b[1] - a[1] * b[0]

    w, z, a = np.cumsum(speeds), np.cumsum(accelerations), np.array([0.0, G])
    steps = []

    for k, ((m, c, inertia, length), angle) in enumerate(zip(links, np.cumsum(angles))):
        e = np.array([np.cos(angle), np.sin(angle)])
        swing = z[k] * np.array([-e[1], e[0]]) - w[k] ** 2 * e
        steps.append((c * e, length * e, m * (a + c * swing), inertia * z[k]))
        a = a + length * swing

    torques, force, torque = [], np.zeros(2), 0.0

    for r_G, r_O, F_G, M_G in reversed(steps):
        torque = M_G + cross(r_G, F_G) + torque + cross(r_O, force)
        force = force + F_G
        torques.insert(0, torque)

    return torques


def waves(t, n):
    """(n,) angles, speeds, accelerations at time t."""
    k = np.arange(1, n + 1)
    return np.sin(k * t + k), k * np.cos(k * t + k), -(k**2) * np.sin(k * t + k)


ARMS = {
    "two_link_arm": ([(2.0, 0.4, 0.12, 0.8), (1.5, 0.3, 0.05, 0.6)], ["shoulder", "elbow"]),
    "three_link_arm": (
        [(3.0, 0.25, 0.07, 0.5), (2.0, 0.2, 0.03, 0.4), (0.8, 0.08, 0.002, 0.16)],
        ["shoulder", "elbow", "wrist"],
    ),
}


@pytest.mark.parametrize("name", ARMS)
def test_robot_arms_by_the_recursion_of_the_lecture(name):
    """5.5 (two links) and 5.8 (three): the motion given, the torques found."""
    links, joints = ARMS[name]
    scene = without_dampers(mbdfmi.load(MODELS / f"{name}.toml"))
    times = np.linspace(0, 2, 21)
    motion = {
        f"{joint}.{quantity}": (lambda t, k=k, order=order: waves(t, len(links))[order][k])
        for k, joint in enumerate(joints)
        for order, quantity in enumerate(("angle", "speed", "acceleration"))
    }
    found = scene.inverse(motion, times)
    expected = np.array([newton_euler(links, *waves(t, len(links))) for t in times])
    np.testing.assert_allclose(
        np.column_stack([found[f"{j}.torque"] for j in joints]), expected, rtol=1e-11, atol=1e-11
    )


@pytest.mark.parametrize("name", ARMS)
@all_formulations
def test_robot_arms_forward(name, formulation):
    """5.7, 5.8: these torques give these accelerations."""
    links, joints = ARMS[name]
    angles, speeds, accelerations = waves(0.3, len(links))
    torques = newton_euler(links, angles, speeds, accelerations)
    scene = without_dampers(mbdfmi.load(MODELS / f"{name}.toml")).model_dump(exclude_unset=True)

    for joint, angle, speed in zip(joints, angles, speeds):
        scene["joint"][joint]["start"] = {"angle": float(angle), "speed": float(speed)}

    y = start(scene, formulation, {f"{joint}.torque": torque for joint, torque in zip(joints, torques)})
    np.testing.assert_allclose(
        [y[f"{joint}.acceleration"] for joint in joints], accelerations, rtol=1e-10, atol=1e-10
    )


def test_two_link_arm_by_its_mass_matrix():
    """5.5 worked out: tau = M(q) q'' + Coriolis and centrifugal torques + weight."""
    (m1, c1, I1, l1), (m2, c2, I2, _) = ARMS["two_link_arm"][0]
    (q1, q2), (v1, v2), (a1, a2) = waves(0.8, 2)
    h = m2 * l1 * c2
    M12 = I2 + m2 * c2**2 + h * np.cos(q2)
    M = np.array([[I1 + m1 * c1**2 + m2 * l1**2 + h * np.cos(q2) + M12, M12], [M12, I2 + m2 * c2**2]])
    bias = h * np.sin(q2) * np.array([-(2 * v1 * v2 + v2**2), v1**2])
    lower = m2 * c2 * G * np.cos(q1 + q2)
    weight = np.array([(m1 * c1 + m2 * l1) * G * np.cos(q1) + lower, lower])
    expected = M @ [a1, a2] + bias + weight
    np.testing.assert_allclose(newton_euler(ARMS["two_link_arm"][0], *waves(0.8, 2)), expected, rtol=1e-13)


def without_dampers(scene):
    joint = {name: joint.model_copy(update={"damper": 0.0}) for name, joint in scene.joint.items()}
    return scene.model_copy(update={"joint": joint})


# chapter 6: the floating wind turbine


def test_floating_wind_turbine_in_all_three_formulations():
    """6.2 embedding, 6.3 augmented, 6.4 recursive: the same accelerations, in any position under
    any loads.
    """
    path = MODELS / "floating_wind_turbine" / "floating_wind_turbine.toml"
    scene = mbdfmi.load(path).model_dump(exclude_unset=True)
    scene["body"]["platform"]["output"] = ["acceleration", "alpha"]
    scene["body"]["hub"]["output"] = ["acceleration", "alpha"]
    scene["joint"]["shaft"]["output"] = ["acceleration", "reaction_force", "reaction_moment"]
    names = (
        "platform.acceleration",
        "platform.alpha",
        "hub.acceleration",
        "hub.alpha",
        "shaft.reaction_force",
    )
    rng = np.random.default_rng(6)
    weight = 6.2e6 * G

    for _ in range(5):
        scene["joint"]["float"]["start"] = {
            "position": rng.normal(size=3).tolist(),
            "zyx_deg": rng.uniform(-20, 20, 3).tolist(),
            "velocity": rng.normal(size=3).tolist(),
            "omega": (0.2 * rng.normal(size=3)).tolist(),
        }
        scene["joint"]["shaft"]["start"] = {"angle": float(rng.uniform(0, 6)), "speed": float(rng.normal())}
        inputs = {
            v.name: float(rng.normal()) * 0.05 * weight
            for v in Scene(**scene).compile().of_causality("input")
        }
        found = {formulation: start(scene, formulation, inputs) for formulation in FORMULATIONS}

        for name in (*names, "shaft.acceleration", "shaft.reaction_moment"):
            expected = np.array(found["recursive"][name])
            scale = np.abs(expected).max()

            for formulation in FORMULATIONS[1:]:
                np.testing.assert_allclose(
                    found[formulation][name], expected, atol=1e-10 * scale, err_msg=name
                )
