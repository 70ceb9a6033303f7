"""The independent route by itself against closed forms: what a key means,
where both routes could have read it wrongly."""

import numpy as np
import pytest

from .independent import System

I3 = np.eye(3)
REST = (np.zeros(3), I3, np.zeros(3), np.zeros(3))
BALL = {"mass": 2.0, "inertia": [0.4, 0.5, 0.6]}


def told(motions, inputs=None, t=0.0, hints=None, **tables):
    """What the independent route tells of a scene of these tables."""
    return System({"name": "law", "gravity": [0, 0, 0]} | tables).evaluate(t, motions, inputs, hints)


def close(found, expected):
    np.testing.assert_allclose(found, expected, rtol=1e-12, atol=1e-12)


def about(axis, angle):
    """A rotation matrix about a coordinate axis, written out."""
    c, s = np.cos(angle), np.sin(angle)
    return {
        "x": np.array([[1, 0, 0], [0, c, -s], [0, s, c]]),
        "y": np.array([[c, 0, s], [0, 1, 0], [-s, 0, c]]),
        "z": np.array([[c, -s, 0], [s, c, 0], [0, 0, 1]]),
    }[axis]


def free(body="a"):
    return {f"free {body}": {"free": {}, "between": ["ground", body]}}


@pytest.mark.parametrize(
    "written, A",
    [
        ({"zyx_deg": [90, 0, 90]}, [[0, 0, 1], [1, 0, 0], [0, 1, 0]]),
        ({"zyx_rad": [0.3, -0.4, 0.5]}, about("z", 0.3) @ about("y", -0.4) @ about("x", 0.5)),
        ({"euler_parameters": [np.sin(0.35), 0, 0, np.cos(0.35)]}, about("x", 0.7)),
        ({"axis_angle": {"axis": "-y", "angle_deg": 30}}, about("y", -np.pi / 6)),
        ({"axes": {"z": [0, 1, 0], "x": [1, 1, 0]}}, [[1, 0, 0], [0, 0, 1], [0, -1, 0]]),
    ],
)
def test_orientations(written, A):
    """Columns are the frame's axes; the place is in the base."""
    body = BALL | {"marker": {"m": written | {"position": [1, 2, 3]}}}
    turned = about("z", 0.2)
    found = told({"a": (np.ones(3), turned, np.zeros(3), np.zeros(3))}, body={"a": body}, joint=free())
    E = found["a.m.euler_parameters"]
    v, s = E[:3], E[3]
    cross = np.array([[0, -v[2], v[1]], [v[2], 0, -v[0]], [-v[1], v[0], 0]])
    close((s * s - v @ v) * I3 + 2 * np.outer(v, v) + 2 * s * cross, turned @ A)
    close(found["a.m.position"], np.ones(3) + turned @ [1, 2, 3])


@pytest.mark.parametrize(
    "solid, mass, moments",
    [
        ({"sphere": {"radius": 0.5, "density": 6.0}}, np.pi, np.pi * 0.1 * np.ones(3)),
        ({"box": {"size": [1, 2, 3], "density": 2}}, 12, [13, 10, 5]),
        ({"cylinder": {"radius": 2, "length": 3, "mass": 12}}, 12, [21, 21, 24]),
        ({"cylinder": {"radius": 2, "length": 3, "mass": 12}, "axis": "x"}, 12, [24, 21, 21]),
        ({"tube": {"radius": 2, "inner_radius": 1, "length": 3, "mass": 12}}, 12, [24, 24, 30]),
        ({"tube": {"radius": 2, "inner_radius": 1, "length": 4, "density": 1}}, 12 * np.pi,
         np.pi * np.array([31, 31, 30])),
    ],
)  # fmt: skip
def test_solids(solid, mass, moments):
    """A torque turns by it, a force moves it, about its place."""
    bodies = {
        "a": {"solid": solid | {"position": [0.3, 0.4, 0.5]}, "marker": {"c": {"position": [0.3, 0.4, 0.5]}}}
    }
    load = {"push": {"load": {"force": [1, 2, 3], "moment": [4, 5, 6]}, "on": "a.c"}}
    found = told({"a": REST}, body=bodies, joint=free(), force=load)
    close(found["a.alpha"], np.array([4, 5, 6]) / moments)
    close(found["a.c.acceleration"], np.array([1, 2, 3]) / mass)


def test_solids_together():
    """Two points: mass, centre, and the inertia about it of a dumbbell; gravity on it."""
    points = [{"point": {"mass": m}, "position": [x, 0, 0]} for m, x in ((1.0, 3.0), (2.0, 0.0))]
    found = told(
        {"a": (*REST[:3], np.array([0, 0, 2.0]))},
        body={"a": {"solid": points}},
        joint=free(),
        gravity=[0, 0, -10],
    )
    close(found["center_of_mass"], [1, 0, 0])
    close(found["kinetic_energy"], 0.5 * (1 * 9 * 4))
    close(found["angular_momentum"], [0, 0, 18])
    close(found["gravity_energy"], 0)


def test_products_of_inertia_are_entries_of_the_tensor():
    """A point at (1, 1, 0): Ixy = -m x y."""
    spin = np.array([0, 3.0, 0])
    body = {"mass": 1, "com": [0, 0, 0], "inertia": [1, 1, 2, -1, 0, 0]}
    found = told({"a": (*REST[:3], spin)}, body={"a": body}, joint=free())
    close(found["angular_momentum"], np.cross([1, 1, 0], np.cross(spin, [1, 1, 0])))


def hinge(**more):
    return {"j": {"revolute": {"axis": "z"}, "between": ["ground", "a"]} | more}


def turned(angle, speed):
    """A body on the hinge."""
    return {"a": (np.zeros(3), about("z", angle), np.zeros(3), np.array([0, 0, speed]))}


def test_efforts_of_a_hinge():
    """On the second marker: spring from its rest in degrees, damper, friction, stop, input."""
    joint = hinge(
        spring={"stiffness": 3, "rest_deg": 90}, damper=0.5,
        stop={"upper_deg": 45, "stiffness": 10, "damping": 2},
        friction={"coulomb": 1, "static": 2, "stribeck_speed": 0.5, "viscous": 0.1, "smoothing_speed": 0.4},
        input="torque",
    )  # fmt: skip
    found = told(turned(1.0, 0.5), {"j.torque": 7.0}, body={"a": BALL}, joint=joint)
    parts = {
        "spring": -3 * (1 - np.pi / 2), "damper": -0.25, "stop": -(10 * (1 - np.pi / 4) + 1), "input": 7,
        "friction": -((1 + np.exp(-1)) * np.tanh(1.25) + 0.05),
    }  # fmt: skip
    close([found[f"j.{part}_effort"] for part in parts], list(parts.values()))
    total = sum(parts.values())
    close(found["j.acceleration"], total / 0.6)
    close(found["j.power"], total * 0.5)
    close(found["input_power"], 3.5)
    close(found["dissipated_power"], -0.5 * (parts["damper"] + parts["friction"] - 1))


def test_a_stop_does_not_pull():
    stop = {"lower": -1.0, "stiffness": 10, "damping": 5}
    for angle, speed, effort in ((-1.1, 1.0, 0.0), (-1.1, 0.1, 0.5), (-1.1, -1.0, 6.0), (-0.9, -1.0, 0.0)):
        close(told(turned(angle, speed), body={"a": BALL}, joint=hinge(stop=stop))["j.stop_effort"], effort)


def test_reversed_ends():
    """What is told of a joint is of its second end seen from the first: here the ground from the body."""
    joint = {"j": {"revolute": {"axis": "z"}, "between": ["a", "ground"], "input": "torque"}}
    found = told(turned(0.7, 2.0), {"j.torque": 3.0}, body={"a": BALL}, joint=joint)
    close([found["j.angle"], found["j.speed"], found["j.acceleration"]], [-0.7, -2.0, 5.0])
    close(found["a.alpha"], [0, 0, -5])


def test_whole_turns():
    start = {"angle_deg": 800, "speed_rpm": 30}
    found = told(turned(np.radians(80), np.pi), body={"a": BALL}, joint=hinge(start=start))
    close([found["j.angle"], found["j.speed"]], [np.radians(800), np.pi])
    close(
        told(turned(0.1, 0), body={"a": BALL}, joint=hinge(), hints={"j.angle": -12.4})["j.angle"],
        0.1 - 4 * np.pi,
    )


def test_a_pendulum_and_its_reaction():
    """A point of mass m at distance l, swinging at angle q from the vertical with speed w:
    what the pivot bears."""
    m, length, q, w, g = 2.0, 0.7, 0.4, 3.0, 9.0
    body = {"mass": m, "com": [0, 0, -length], "inertia": [0, 0, 0]}
    joint = {"j": {"revolute": {"axis": "x"}, "between": ["ground", "a"]}}
    motions = {"a": (np.zeros(3), about("x", q), np.zeros(3), np.array([w, 0, 0]))}
    found = told(motions, body={"a": body}, joint=joint, gravity=[0, 0, -g])
    close(found["j.acceleration"], -g / length * np.sin(q))
    along = about("x", q) @ [0, 0, 1]
    close(found["j.reaction_force"], (m * length * w**2 + m * g * np.cos(q)) * along)
    close(found["j.reaction_force_body"], [0, 0, m * length * w**2 + m * g * np.cos(q)])
    close(found["ground.reaction_force"], -found["j.reaction_force"])


def test_a_slide_bears_a_moment_about_its_second_marker():
    """A cart whose weight is beside its rail."""
    body = {"mass": 2, "com": [0, 0.5, 0], "inertia": [0, 0, 0]}
    joint = {"j": {"prismatic": {"axis": "x"}, "between": ["ground", "a"]}}
    found = told(
        {"a": (np.array([3.0, 0, 0]), *REST[1:])}, body={"a": body}, joint=joint, gravity=[0, 0, -10]
    )
    close(found["j.reaction_force"], [0, 0, 20])
    close(found["j.reaction_moment"], [10, 0, 0])
    close(found["ground.reaction_moment"], [-10, 60, 0])


def driven(**driver):
    return told(turned(0.3, 0.0), t=0.25, body={"a": BALL}, joint=hinge(driver=driver))


@pytest.mark.parametrize(
    "driver, position, speed, acceleration",
    [
        ({"harmonic": {"amplitude_deg": 90, "frequency": 1, "phase_deg": 30, "mean_deg": 10}},
         np.pi / 18 + np.pi / 2 * np.sin(2 * np.pi / 3), np.pi**2 * np.cos(2 * np.pi / 3),
         -2 * np.pi**3 * np.sin(2 * np.pi / 3)),
        ({"polynomial": {"coefficients": [1, 2, 3]}}, 1.6875, 3.5, 6),
        ({"ramp": {"time": [0, 0.5], "position_deg": [0, 180]}}, np.pi / 2, 1.875 * np.pi / 0.5, 0),
        ({"table": {"time": [0, 1], "position_deg": [0, 180], "interpolation": "linear"}}, np.pi / 4, np.pi,
         0),
    ],
)  # fmt: skip
def test_drivers(driver, position, speed, acceleration):
    """Torque: inertia times the acceleration that is asked for; the residual is what the body is off."""
    found = driven(**driver)
    close(found["j.driver_effort"], 0.6 * acceleration)
    close(
        found["constraint residuals"][-1],
        0.3 - position + 2 * np.pi * np.round((position - 0.3) / (2 * np.pi)),
    )
    close(found["constraint rates"][-1], -speed)


def test_a_speed_table_is_integrated():
    """From the joint's start position on: t^2 / 2 of a speed t."""
    system = System({"name": "s", "body": {"a": BALL}, "joint": hinge(
        start={"angle": 0.2},
        driver={"speed_table": {"time": [0, 1], "speed": [0, 1], "interpolation": "linear"}})})  # fmt: skip
    system.evaluate(0.0, turned(0.2, 0.0))
    close(system.evaluate(0.5, turned(0.325, 0.5))["constraint residuals"], np.zeros(6))
    close(system.evaluate(3.0, turned(0.7 + 2, 1.0))["constraint residuals"], np.zeros(6))


@pytest.mark.parametrize(
    "coupling, second, ratio",
    [
        ({"gear": {"ratio": -2.0}}, {"revolute": {"axis": "z"}}, -2.0),
        ({"rack": {"radius": 0.5}}, {"prismatic": {"axis": "x"}}, 0.5),
        ({"screw": {"pitch": np.pi}}, {"prismatic": {"axis": "x"}}, 0.5),
        ({"linear": {"ratio": 3.0}}, {"prismatic": {"axis": "x"}}, 3.0),
    ],
)
def test_couplings(coupling, second, ratio):
    """The second coordinate is ratio times the first: a torque on the first moves I + ratio^2 m."""
    joint = hinge(input="torque") | {"k": second | {"between": ["ground", "b"]}}
    motions = {"a": REST, "b": REST}
    links = {"c": coupling | {"between": ["j", "k"]}}
    found = told(motions, {"j.torque": 6.0}, body={"a": BALL, "b": BALL}, joint=joint, coupling=links)
    inertia = 0.6 if "revolute" in second else 2.0
    alpha = 6 / (0.6 + ratio**2 * inertia)
    close(found["j.acceleration"], alpha)
    close(found["k.acceleration"], ratio * alpha)
    close(found["c.efforts"], [0.6 * alpha - 6, inertia * ratio * alpha])


def test_a_strut_pulls_where_it_is_long():
    spec = {"stiffness": 10, "rest_length": 1.5, "damping": 2}
    force = {"s": {"spring_damper": spec, "between": ["ground", "a"], "input": "force"}}
    motions = {"a": (np.array([0, 2.0, 0]), I3, np.array([5.0, 0.5, 0]), np.zeros(3))}
    found = told(motions, {"s.force": 4.0}, body={"a": BALL}, joint=free(), force=force)
    keys = ("length", "rate", "spring_force", "damper_force", "input_force", "tension")
    close([found[f"s.{key}"] for key in keys], [2, 0.5, 5, 1, 4, 10])
    close(found["a.acceleration"], [0, -5, 0])
    close(found["spring_energy"], 1.25)
    close(found["input_power"], -2)


def test_a_bushing_at_small_and_large_angles():
    """Against the displacement; by a turn about z alone moment and angle are those of a torsion spring,
    at any angle."""
    spec = {"stiffness": [1, 2, 3, 4, 5, 6], "damping": [0, 0, 0, 0, 0, 0.5]}
    motions = {"a": (np.array([0.1, 0.2, 0.3]), about("z", 2.5), np.zeros(3), np.array([0, 0, 2.0]))}
    found = told(
        motions, body={"a": BALL}, joint=free(), force={"m": {"bushing": spec, "between": ["ground", "a"]}}
    )
    close(found["m.force"], [-0.1, -0.4, -0.9])
    close(found["m.moment"], [0, 0, -15 - 1])
    swung = {"a": (np.zeros(3), about("x", 1.2), np.zeros(3), np.zeros(3))}
    found = told(
        swung, body={"a": BALL}, joint=free(), force={"m": {"bushing": spec, "between": ["ground", "a"]}}
    )
    close(found["m.rotation"], [1.2, 0, 0])
    close(found["m.moment"], [-4.8, 0, 0])


@pytest.mark.parametrize("axes", ["first", "heading", "body"])
def test_added_mass(axes):
    """A hull of added masses (3, 5) that moves with (u, v) in its axes feels Munk's moment,
    but not where the mass keeps its axes."""
    q, u, v = 0.6, 2.0, 0.7
    A = about("z", q)
    motions = {"a": (np.zeros(3), A, A @ [u, v, 0], np.zeros(3))}
    water = {"added_mass": np.diag([3.0, 5, 0, 0, 0, 0]).tolist(), "axes": axes}
    found = told(
        motions, body={"a": BALL}, joint=free(), force={"w": {"linear": water, "between": ["ground", "a"]}}
    )
    close(found["a.alpha"], [0, 0, (0 if axes == "first" else (3 - 5) * u * v / 0.6)])
    momentum = np.array([3, 5, 0]) * (A @ [u, v, 0]) if axes == "first" else A @ [3 * u, 5 * v, 0]
    close(found["linear_momentum"], 2 * A @ [u, v, 0] + momentum)


def test_loads_follow_their_frame_or_not():
    body = BALL | {"marker": {"m": {"zyx_deg": [90, 0, 0]}}}
    for axes, expected in (("inertial", [4, 0, 0]), ("body", [0, 4, 0])):
        load = {"l": {"load": {"force": [8, 0, 0], "axes": axes}, "on": "a.m"}}
        close(told({"a": REST}, body={"a": body}, joint=free(), force=load)["a.acceleration"], expected)


def test_central_gravity():
    found = told(
        {"a": (np.array([3.0, 4, 0]), *REST[1:])},
        body={"a": BALL},
        joint=free(),
        central_gravity={"mu": 50.0},
    )
    close(found["a.acceleration"], -np.array([3, 4, 0]) * 50 / 125)
    close(found["gravity_energy"], -50 * 2 / 5)


@pytest.mark.parametrize(
    "motion, t, r, A, v, w",
    [
        ({"acceleration": [0, 0, 2], "velocity": [1, 0, 0], "position": [5, 0, 0]}, 3.0, [8, 0, 9], I3,
         [1, 0, 6], [0, 0, 0]),
        ({"rotation": {"axis": "z", "speed_deg": 90, "point": [1, 0, 0]}}, 1.0, [1, -1, 0],
         about("z", np.pi / 2),
         [np.pi / 2, 0, 0], [0, 0, np.pi / 2]),
        ({"orbit": {"radius": 2, "rate": 0.5, "phase_deg": 90}}, 0.0, [0, 2, 0], about("z", np.pi / 2),
         [-1, 0, 0], [0, 0, 0.5]),
        ({"orbit": {"radius": 2, "rate": 0.5, "normal": "y", "pointing": False}}, 0.0, [2, 0, 0], I3,
         [0, 0, -1], [0, 0, 0]),
        ({"orbit": {"radius": 2, "rate": 0.5, "normal": "x", "pointing": False}}, 0.0, [0, 2, 0], I3,
         [0, 0, 1], [0, 0, 0]),
    ],
)  # fmt: skip
def test_grounds_that_move(motion, t, r, A, v, w):
    measure = {"m": {"between": ["inertial", "ground"], "output": ["position"]}}
    found = told({"a": REST}, t=t, body={"a": BALL}, joint=free(), ground={"motion": motion}, measure=measure)
    close(found["m.position"], r)
    close(found["m.velocity"], v)
    close(found["m.omega"], w)
    ground = {"m": {"between": ["ground", "inertial"], "output": ["position"]}}
    found = told({"a": REST}, t=t, body={"a": BALL}, joint=free(), ground={"motion": motion}, measure=ground)
    close(found["m.position"], -np.transpose(A) @ r)


def test_a_planar_joint_counts_along_the_projected_x_axis():
    """Normal x: then along y. Normal (1, 0, 1): along (1, 0, -1)."""
    for normal, first in (("x", [0, 1, 0]), ([1, 0, 1], [np.sqrt(0.5), 0, -np.sqrt(0.5)]), ("-z", [1, 0, 0])):
        joint = {"p": {"planar": {"normal": normal}, "between": ["ground", "a"]}}
        found = told({"a": (0.3 * np.array(first), *REST[1:])}, body={"a": BALL}, joint=joint)
        close(found["p.position"], [0.3, 0])


def test_a_universal_joint_turns_about_the_first_axis_then_the_second():
    joint = {"u": {"universal": {}, "between": ["ground", "a"]}}
    A = about("x", 0.4) @ about("y", -0.9)
    w = np.array([2.0, 0, 0]) + 3 * A[:, 1]
    found = told({"a": (np.zeros(3), A, np.zeros(3), w)}, body={"a": BALL}, joint=joint)
    close(found["u.angles"], [0.4, -0.9])
    close(found["u.speeds"], [2, 3])


def test_a_screw_advances_by_its_pitch_in_a_turn():
    joint = {"s": {"screw": {"axis": "y", "pitch": 0.5}, "between": ["ground", "a"], "input": "torque"}}
    found = told({"a": (np.array([0, 0.6, 0]), about("y", 2.4 * np.pi), np.zeros(3), np.zeros(3))},
                 {"s.torque": 2.0},
                 body={"a": BALL}, joint=joint)  # fmt: skip
    close([found["s.angle"], found["s.position"]], [2.4 * np.pi, 0.6])
    close(found["constraint residuals"], np.zeros(5))
    h = 0.5 / (2 * np.pi)
    close(found["a.alpha"], [0, 2 / (0.5 + 2 * h**2), 0])


def test_torque_of_a_ball_joint_is_in_the_first_marker_s_axes():
    joint = {"b": {"spherical": {}, "between": ["ground.m", "a"], "input": "torque"}}
    ground = {"marker": {"m": {"zyx_deg": [90, 0, 0]}}}
    found = told({"a": REST}, {"b.torque": [1, 2, 3]}, body={"a": BALL}, joint=joint, ground=ground)
    close(found["a.alpha"], [-2 / 0.4, 1 / 0.5, 3 / 0.6])


def test_a_rolling_sphere_on_a_slope():
    """g sin / (1 + 2/5) down the slope; the ball's weight across it."""
    ball = {"solid": {"sphere": {"radius": 0.3, "mass": 2}}}
    joint = {"r": {"rolling_sphere": {"radius": 0.3}, "between": ["ground", "a"]}} | free()
    found = told({"a": (np.array([0, 0, 0.3]), *REST[1:])}, body={"a": ball}, joint=joint, gravity=[7, 0, -5])
    close(found["a.acceleration"], [5, 0, 0])
    close(found["r.reaction_force"], [-4, 0, 10])
    close(found["a.alpha"], [0, 5 / 0.3, 0])


def test_a_bead_on_a_circle():
    """Parameter: arc length from the x axis; at speed v it needs v^2 / R towards the centre."""
    ground = {"marker": {"m": {"curve": {"circle": {"radius": 2.0}}}}}
    joint = {"c": {"point_on_curve": {}, "between": ["ground.m", "a"]}} | free()
    motions = {"a": (np.array([0, 2.0, 0]), I3, np.array([-3.0, 0, 0]), np.zeros(3))}
    found = told(motions, body={"a": BALL}, joint=joint, ground=ground, hints={"c.s": 3.1})
    close([found["c.s"], found["c.s_rate"]], [np.pi, 3])
    close(found["c.reaction_force"], [0, -9, 0])


def test_a_knife_edge_and_a_distance():
    """The edge's lateral direction is the second marker's; a circling edge needs m v w across it."""
    joint = {"k": {"knife_edge": {"lateral": "y"}, "between": ["ground", "a"]}} | free()
    motions = {"a": (np.zeros(3), I3, np.array([3.0, 0, 0]), np.array([0, 0, 2.0]))}
    found = told(motions, body={"a": BALL}, joint=joint)
    close(found["k.reaction_force"], [0, 12, 0])
    joint = {"d": {"distance": {"length": 2.0}, "between": ["ground", "a"]}} | free()
    motions = {"a": (np.array([0, 2.0, 0]), I3, np.array([3.0, 0, 0]), np.zeros(3))}
    close(told(motions, body={"a": BALL}, joint=joint)["d.reaction_force"], [0, -9, 0])


def test_what_redundant_joints_bear_is_not_told():
    """A door on two hinges: along the axis they share its weight as they like."""
    body = BALL | {"marker": {"top": {"position": [0, 0, 2]}}}
    ground = {"marker": {"top": {"position": [0, 0, 2]}}}
    joint = hinge() | {"upper": {"revolute": {"axis": "z"}, "between": ["ground.top", "a.top"]}}
    found = told({"a": REST}, body={"a": body}, joint=joint, ground=ground, gravity=[0, 0, -10])
    assert "j.reaction_force" not in found
    close(found["ground.reaction_force"], [0, 0, -20])
    close(found["j.acceleration"], 0)


def test_parameters_count_instead_of_the_scene():
    data = {"name": "p", "gravity": [0, 0, 0], "body": {"blade 1": BALL}, "joint": free("blade 1")}
    system = System(data, {"blade 1.mass": 5.0, "gravity[3]": -2.0})
    close(system.evaluate(0.0, {"blade 1": REST})["'blade 1'.acceleration"], [0, 0, -2])
    close(system.mass["blade 1"][0], 5)

    with pytest.raises(KeyError, match="no parameter a.weight"):
        System({"name": "p", "body": {"a": BALL}}, {"a.weight": 1.0})
