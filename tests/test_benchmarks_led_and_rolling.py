"""Problems with prescribed motion, rolling and knife edges (benchmarks/reference) in relative and in absolute coordinates; digits as in test_benchmarks."""

import numpy as np
import pytest
from scipy.spatial.transform import Rotation
from test_benchmarks import error_of, formulations, solver

from benchmarks.problem_files import problem_file as problem

# prescribed motion


@formulations
@pytest.mark.parametrize("rod_mass", [None, 1e-6])
def test_slider_crank_driven(run, check, formulation, rod_mass):
    """The rod as a constraint, and as a body of next to no mass. The crank turns evenly, so that its inertia plays no part."""
    data = problem("slider_crank_driven")
    inertia = [1e-3] * 3
    end = float(np.sqrt(0.3**2))
    reaction = {"output": ["reaction_force"]}
    scene = {
        "name": "slider crank",
        "gravity": [0, 0, 0],
        "solver": solver(formulation, 1e-13),
        "body": {
            "crank": {"mass": 0.5, "inertia": inertia, "marker": {"pin": {"position": [0.1, 0, 0]}}},
            "slider": {"mass": 1.0, "inertia": inertia},
        },
        "joint": {
            "motor": {
                "revolute": {},
                "between": ["ground", "crank"],
                "driver": {"constant_speed": 10.0},
                "output": ["effort"],
            },
            "guide": {
                "prismatic": {"axis": "x"},
                "between": ["ground", "slider"],
                "start": {"position": 0.1 + end},
                "output": ["position", "speed", "acceleration", "reaction_force"],
            },
        },
    }

    if rod_mass is None:
        scene["joint"]["rod"] = {"distance": {}, "between": ["crank.pin", "slider"]} | reaction
    else:
        marker = {"far": {"position": [0.3, 0, 0]}}
        moment = rod_mass * 0.3**2 / 12
        com = [0.15, 0, 0]
        scene["body"]["rod"] = {"mass": rod_mass, "com": com, "inertia": [moment] * 3, "marker": marker}
        scene["joint"] |= {
            "crank pin": {"revolute": {}, "between": ["crank.pin", "rod"]},
            "slider pin": {"revolute": {}, "between": ["slider", "rod.far"]},
        }

    y = run(scene, data["t"])
    found = {
        "x": y["guide.position"],
        "xd": y["guide.speed"],
        "xdd": y["guide.acceleration"],
        "drive_torque_z": y["motor.effort"],
        "guide_force_on_slider_y": y["guide.reaction_force"][:, 1],
    }
    check(error_of(data, found), 1e-10 if rod_mass is None else 10 * rod_mass)


def bob(formulation, **tables):
    """A pendulum of 1 m, a point mass on a revolute joint, or in absolute coordinates on a rod."""
    outputs = ["position", "velocity"]
    seen = {"bob": {"between": ["ground", "bob"], "output": outputs}}

    if formulation == "augmented":
        body = {"mass": 1.0, "inertia": [0.1] * 3}
        joint = {
            "hold": {"translation": {}, "between": ["ground", "bob"], "start": {"position": [0, -1, 0]}},
            "rod": {"distance": {}, "between": ["ground", "bob"]},
        }
    else:
        body = {"mass": 1.0, "inertia": [0, 0, 0]}
        joint = {"pin": {"revolute": {}, "between": ["ground", "bob.pin"]}}
        body["marker"] = {"pin": {"position": [0, 1, 0]}}

    return {
        "name": "bob",
        "solver": solver(formulation, 1e-13),
        "body": {"bob": body},
        "joint": joint,
        "measure": seen,
    } | tables


def pendulum_angle(y, name):
    """Angle and its rate of a bob at 1 m from the origin, from the lowest point."""
    r, v = y[f"{name}.position"].T, y[f"{name}.velocity"].T
    return np.arctan2(r[0], -r[1]), v[0] * -r[1] + v[1] * r[0]


@formulations
def test_pendulum_on_an_accelerating_pivot(run, check, formulation):
    data = problem("pendulum_accelerating_pivot")
    ground = {"motion": {"acceleration": [3, 0, 0]}}
    y = run(bob(formulation, gravity=[0, -9.81, 0], ground=ground), data["t"])
    angle, rate = pendulum_angle(y, "bob")
    check(error_of(data, {"theta_rel": angle, "thetad_rel": rate}), 1e-9)


@formulations
@pytest.mark.parametrize("drive", ["ground", "shaft", "motor"])
def test_bead_on_a_rotating_hoop(run, check, formulation, drive):
    """A pendulum on a turning ground, and on a shaft that is driven, or geared to one that is.

    A body of moments (0.2, 0.1, 0.1) about its centre of mass, in 1.1 times the weight, moves as the point would.
    """
    data = problem("bead_rotating_hoop")
    carrier = "ground" if drive == "ground" else "shaft"
    scene = {
        "name": "hoop",
        "solver": solver(formulation, 1e-13),
        "gravity": [0, 0, -1.1 * 9.81],
        "body": {"bead": {"mass": 1.0, "com": [0, 0, -1], "inertia": [0.2, 0.1, 0.1]}},
        "joint": {
            "hoop": {
                "revolute": {"axis": "-y"},
                "between": [carrier, "bead"],
                "start": {"angle": 0.1, "speed": 0},
                "output": ["angle", "speed"],
            }
        },
    }
    turn = {"revolute": {}, "between": ["ground", "shaft"]}
    driver = {"driver": {"constant_speed": 5.0}}
    shaft = {"mass": 1.0, "inertia": [1, 1, 1]}

    if drive == "ground":
        scene["ground"] = {"motion": {"rotation": {"speed": 5.0}}}
    elif drive == "shaft":
        scene["body"]["shaft"] = shaft
        scene["joint"]["turn"] = turn | driver
    else:
        scene["body"] |= {"shaft": shaft, "motor": shaft}
        scene["joint"] |= {
            "turn": turn | {"start": {"speed": 5.0}},
            "motor": {"revolute": {}, "between": ["ground", "motor"]} | driver,
        }
        scene["coupling"] = {"belt": {"gear": {"ratio": 1.0}, "between": ["motor", "turn"]}}

    y = run(scene, data["t"])
    check(error_of(data, {"theta": y["hoop.angle"], "thetad": y["hoop.speed"]}), 1e-9)


@formulations
def test_free_body_in_a_moving_frame(run, check, formulation):
    """The frame is driven by a chain of joints: a wave along x, a parabola along z, an even turn about a slanting axis."""
    data = problem("free_body_in_moving_frame")
    part = {"mass": 1.0, "inertia": [1, 1, 1]}
    start = np.array([1, -2, 0.5]), np.array([0.3 - 2.6, 0.1, -0.2])
    w = 0.7 / 3 * np.array([1, 2, 2])
    scene = {
        "name": "moving frame",
        "gravity": [0, 0, 0],
        "solver": solver(formulation, 1e-13),
        "body": {"along": part, "up": part, "frame": part, "body": part | {"mass": 2.0}},
        "joint": {
            "along": {
                "prismatic": {"axis": "x"},
                "between": ["ground", "along"],
                "driver": {"harmonic": {"amplitude": 2.0, "frequency": 1.3 / (2 * np.pi)}},
            },
            "up": {
                "prismatic": {},
                "between": ["along", "up"],
                "driver": {"table": {"time": [0, 2, 5, 11], "position": [0, 0.8, 5, 24.2]}},
            },
            "turn": {
                "revolute": {"axis": [1, 2, 2]},
                "between": ["up", "frame"],
                "driver": {"constant_speed": 0.7},
            },
            "free": {
                "free": {},
                "between": ["frame", "body"],
                "start": {
                    "position": start[0].tolist(),
                    "velocity": (start[1] - np.cross(w, start[0])).tolist(),
                    "omega": ([0.2, -0.4, 0.9] - w).tolist(),
                },
            },
        },
        "measure": {"seen": {"between": ["frame", "body"], "output": ["position", "euler_parameters"]}},
    }
    y = run(scene, data["t"])
    check(relative_pose_error(data, y), 1e-9)


def relative_pose_error(data, y):
    """Error of the position and, either sign, of Euler parameters (scalar first in the file) of the measure "seen"."""
    E = y["seen.euler_parameters"][:, [3, 0, 1, 2]]
    wanted = np.column_stack([data["column"][f"q{k}_rel"] for k in range(4)])
    E *= np.sign(np.sum(E * wanted, axis=1))[:, None]
    found = {f"{c}_rel": y["seen.position"][:, k] for k, c in enumerate("xyz")}
    return max(error_of(data, found), np.abs(E - wanted).max())


@formulations
@pytest.mark.parametrize("onto", ["ground", "inertial"])
def test_free_body_seen_from_a_ground_that_moves_by_table(run, check, formulation, onto):
    """Splines through points of the frame's motion, which are exact at the points."""
    data = problem("free_body_in_moving_frame")
    t = np.linspace(0, 10, 2001)
    angle = 0.35 * t
    E = np.column_stack([*np.outer([1 / 3, 2 / 3, 2 / 3], np.sin(angle)), np.cos(angle)])
    r = np.column_stack([2 * np.sin(1.3 * t), 0 * t, 0.2 * t**2])
    table = {"time": t.tolist(), "position": r.tolist(), "euler_parameters": E.tolist()}
    v, w = np.array([0.3, 0.1, -0.2]), np.array([0.2, -0.4, 0.9])

    if onto == "ground":
        turn = 0.7 / 3 * np.array([1, 2, 2])
        v, w = v - [2.6, 0, 0] - np.cross(turn, [1, -2, 0.5]), w - turn

    scene = {
        "name": "moving ground",
        "gravity": [0, 0, 0],
        "solver": solver(formulation, 1e-12),
        "ground": {"motion": {"table": table}},
        "body": {"body": {"mass": 2.0, "inertia": [1, 1, 1]}},
        "joint": {
            "free": {
                "free": {},
                "between": [onto, "body"],
                "start": {"position": [1, -2, 0.5], "velocity": v.tolist(), "omega": w.tolist()},
            }
        },
        "measure": {"seen": {"between": ["ground", "body"], "output": ["position", "euler_parameters"]}},
    }
    y = run(scene, data["t"])

    # in coordinates on the ground each step across a point of the spline costs a little, and its slope at the start is not exact
    on_ground = onto == "ground" or formulation == "augmented"
    check(relative_pose_error(data, y), 1e-7 if on_ground else 1e-12)


@formulations
def test_hill_clohessy_wiltshire(run, check, formulation):
    """The gravity gradient as a spring that pushes in x and pulls in y and z, on a turning ground."""
    data = problem("hill_clohessy_wiltshire")
    n = 0.0011
    stiffness = np.zeros((6, 6))
    stiffness[:3, :3] = 10 * n**2 * np.diag([-2, 1, 1])
    scene = {
        "name": "Hill",
        "gravity": [0, 0, 0],
        "solver": solver(formulation, 1e-13),
        "ground": {"motion": {"rotation": {"speed": n}}},
        "body": {"sat": {"mass": 10.0, "inertia": [1, 1, 1]}},
        "joint": {
            "free": {
                "free": {},
                "between": ["ground", "sat"],
                "start": {"position": [100, 200, 50], "velocity": [0.1, -0.2, 0.05]},
                "output": ["position", "velocity"],
            }
        },
        "force": {"gradient": {"linear": {"stiffness": stiffness.tolist()}, "between": ["ground", "sat"]}},
    }
    y = run(scene, data["t"])
    r, v = y["free.position"].T, y["free.velocity"].T
    check(error_of(data, dict(zip(["x", "y", "z", "vx", "vy", "vz"], [*r, *v]))), 1e-9)


@formulations
def test_satellites_of_an_orbiting_frame(run, check, formulation):
    """Central gravity: near by, the motion becomes Hill's; ahead on the same orbit a satellite rests in the frame."""
    data = problem("hill_clohessy_wiltshire")
    n, radius = 0.0011, 1e7
    near = 1e-4
    body = {"mass": 10.0, "inertia": [1, 1, 1]}
    ahead = [radius * (np.cos(0.3) - 1), radius * np.sin(0.3), 0]
    start = {
        "position": [100 * near, 200 * near, 50 * near],
        "velocity": [0.1 * near, -0.2 * near, 0.05 * near],
    }
    output = {"output": ["position"]}
    scene = {
        "name": "orbit",
        "central_gravity": {"mu": n**2 * radius**3},
        "solver": solver(formulation, 1e-13) | {"absolute_tolerance": 1e-12},
        "ground": {"motion": {"orbit": {"radius": radius, "rate": n}}},
        "body": {"near": body, "ahead": body},
        "joint": {
            "near": {"free": {}, "between": ["ground", "near"], "start": start} | output,
            "ahead": {"free": {}, "between": ["ground", "ahead"], "start": {"position": ahead}} | output,
        },
    }
    y = run(scene, data["t"][:5])

    # a weight of 10 m/s2 is known to 1e-15 m/s2, for 3,000 s; the stray of Hill's equations is of the order of 3 x 200 / radius
    assert np.abs(y["ahead.position"] - ahead).max() < 1e-3
    check(error_of(data, {c: y["near.position"][:, k] / near for k, c in enumerate("xyz")}), 1e-4)


# rolling and knife edges


def columns(data, *names):
    """Quantities of a reference side by side."""
    return np.column_stack([data["column"][name] for name in names])


@formulations
def test_rolling_disk(run, check, formulation):
    data = problem("rolling_disk_thin")
    body = data["bodies"][0]
    E = np.roll(body["q0"], -1)
    R = Rotation.from_quat(E)
    w = R.apply([0, 0, 3]) + [0, 0, 0.5]
    top = R.apply([0, 0, 1])
    m = np.array([0, 0, 1]) - top[2] * top
    v = np.cross(w, m / np.linalg.norm(m))
    start = {
        "position": body["r0"],
        "euler_parameters": E.tolist(),
        "velocity": v.tolist(),
        "omega": w.tolist(),
    }
    scene = {
        "name": "disk",
        "solver": solver(formulation, 1e-13),
        "body": {
            "disk": {
                "mass": 1.0,
                "inertia": [0.25, 0.25, 0.5],
                "output": ["position", "euler_parameters", "omega_body", "velocity"],
            }
        },
        "joint": {
            "free": {"free": {}, "between": ["ground", "disk"], "start": start},
            "roll": {"rolling_disk": {"radius": 1.0}, "between": ["ground", "disk"]},
        },
        "output": ["total_energy", "constraint_gap", "constraint_rate"],
    }
    y = run(scene, data["t"])
    found = {f"com{c}": y["disk.position"][:, k] for k, c in enumerate("xyz")}
    found |= {f"comv{c}": y["disk.velocity"][:, k] for k, c in enumerate("xyz")}
    found |= {f"w{c}_body": y["disk.omega_body"][:, k] for k, c in enumerate("xyz")}
    E, wanted = y["disk.euler_parameters"][:, [3, 0, 1, 2]], columns(data, "q0", "q1", "q2", "q3")
    E = E * np.sign(np.sum(E * wanted, axis=1))[:, None]
    energy = data["column"]["energy"]
    assert np.abs(y["total_energy"] / energy - 1).max() < 1e-10
    assert y["constraint_gap"].max() < 1e-14
    assert y["constraint_rate"].max() < 1e-13
    check(max(error_of(data, found), np.abs(E - wanted).max()), 1e-8)


@formulations
@pytest.mark.parametrize("onto", ["ground", "inertial"])
def test_sphere_on_a_turntable(run, check, formulation, onto):
    """The ground turns; the ball's own coordinates are in it, or in the inertial frame."""
    data = problem("sphere_on_turntable")
    turn = np.array([0, 0, 3.0 if onto == "ground" else 0.0])
    r = np.array([0.5, 0, 0.1])
    v, w = np.array([0.2, 0, 0]) - np.cross(turn, r), np.array([15.0, 2, 0]) - turn
    start = {"position": r.tolist(), "velocity": v.tolist(), "omega": w.tolist()}
    scene = {
        "name": "turntable",
        "solver": solver(formulation, 1e-13),
        "ground": {"motion": {"rotation": {"speed": 3.0}}},
        "body": {"ball": {"mass": 1.0, "inertia": [0.004] * 3, "output": ["position", "velocity", "omega"]}},
        "joint": {
            "free": {"free": {}, "between": [onto, "ball"], "start": start},
            "roll": {"rolling_sphere": {"radius": 0.1}, "between": ["ground", "ball"]},
        },
        "output": ["constraint_gap", "constraint_rate"],
    }
    period = 2 * np.pi / (2 * 3 / 7)
    times = np.sort(np.append(data["t"], period))
    y = run(scene, times)
    at = times != period
    r, v = y["ball.position"][at], y["ball.velocity"][at]
    assert np.abs(y["ball.position"][~at] - [0.5, 0, 0.1]).max() < 1e-9
    assert np.abs(y["ball.omega"][:, 2]).max() < 1e-9
    assert y["constraint_gap"].max() < 1e-14
    assert y["constraint_rate"].max() < 1e-13
    check(error_of(data, {"x": r[:, 0], "y": r[:, 1], "vx": v[:, 0], "vy": v[:, 1]}), 1e-9)


@formulations
def test_chaplygin_sleigh(run, check, formulation):
    """It turns round, without friction, until it runs with its centre of mass ahead."""
    data = problem("chaplygin_sleigh")
    start = {"velocity": [-1, 0], "angular_speed": 0.8}
    scene = {
        "name": "sleigh",
        "gravity": [0, 0, 0],
        "solver": solver(formulation, 1e-13),
        "body": {
            "sleigh": {"mass": 1.0, "com": [0.3, 0, 0], "inertia": [0.5] * 3, "output": ["velocity_body"]}
        },
        "joint": {
            "plane": {
                "planar": {},
                "between": ["ground", "sleigh"],
                "start": start,
                "output": ["position", "angle", "angular_speed"],
            },
            "blade": {"knife_edge": {"lateral": "y"}, "between": ["ground", "sleigh"]},
        },
        "output": ["total_energy"],
    }
    y = run(scene, data["t"])
    found = {
        "u_blade": y["sleigh.velocity_body"][:, 0],
        "w": y["plane.angular_speed"],
        "heading": y["plane.angle"],
        "x_knife": y["plane.position"][:, 0],
        "y_knife": y["plane.position"][:, 1],
    }
    assert np.abs(y["sleigh.velocity_body"][:, 1]).max() < 1e-13
    assert np.abs(y["total_energy"] / y["total_energy"][0] - 1).max() < 1e-11
    check(error_of(data, found), 1e-9)
