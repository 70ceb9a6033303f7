"""Surfaces that touch and roll: closed forms, a rattleback and a wheel against equations of their own, starts, mistakes.

Rows and rates against differences, energy and momentum: tests/test_contacts.py.
"""

from pathlib import Path

import numpy as np
import pytest
from scipy.integrate import solve_ivp

import mbdfmi
from mbdfmi import Scene, SceneError
from mbdfmi.run.instance import SimulationError

FORMULATIONS = ["recursive", "embedding", "augmented"]
SOLVER = {"integrator": "rk853", "tolerance": 1e-12}
G = 9.81


def columns(results, name, size):
    """An array variable (times, size)."""
    return np.column_stack([results[f"{name}[{k + 1}]"] for k in range(size)])


def scene(ground, shape, start, kind="rolling_surface", contact=None, solver=SOLVER, **body):
    """A free body whose surface touches one of the ground."""
    return Scene.model_validate(
        {
            "name": "touching",
            "gravity": [0, 0, -G],
            "output": ["total_energy"],
            "ground": {"marker": {"m": ground}},
            "body": {
                "b": {
                    "mass": 1.0,
                    "inertia": [0.1, 0.1, 0.1],
                    "output": ["position", "velocity", "omega_body"],
                }
                | {"marker": {"skin": {"surface": shape}}}
                | body
            },
            "joint": {
                "free": {
                    "free": {},
                    "between": ["ground", "b"],
                    "start": start,
                    "output": ["omega", "euler_parameters"],
                },
                "touch": {
                    kind: {},
                    "between": ["ground.m", "b.skin"],
                    "output": ["s", "s_rate", "contact_point", "normal_force"],
                }
                | ({"start": contact} if contact else {}),
            },
            "solver": solver,
        }
    )


def ball(radius, mass=1.0):
    """Shape and inertia of a solid ball."""
    return {"sphere": {"radius": radius}}, {"mass": mass, "inertia": [0.4 * mass * radius**2] * 3}


# closed forms


@pytest.mark.parametrize("formulation", FORMULATIONS)
@pytest.mark.parametrize("inside", [False, True])
def test_a_ball_rolls_in_a_vertical_plane_over_a_sphere_and_in_it(formulation, inside):
    # theta from where it lies highest or lowest; of a solid ball two sevenths of the energy are in its turning
    R, r = 1.0, 0.2
    sign = -1.0 if inside else 1.0
    way = R + sign * r
    start, speed = (1.2, 0.0) if inside else (0.0, 0.5)
    shape, body = ball(r)
    results = scene(
        {"surface": {"sphere": {"radius": R}}},
        shape,
        {
            "position": [way * np.sin(start), 0, sign * way * np.cos(start)],
            "velocity": [way * speed, 0, 0],
            "omega": [0, way * speed / r, 0],
        },
        solver=SOLVER | {"formulation": formulation},
        **body,
    ).simulate(1.0, 0.05)
    x, z = results["b.position[1]"], sign * results["b.position[3]"]
    theta = np.arctan2(x, z)
    np.testing.assert_allclose(np.hypot(x, z), way, atol=1e-12)
    assert np.ptp(theta) > 0.7

    rate = (z * results["b.velocity[1]"] - x * sign * results["b.velocity[3]"]) / way**2
    square = speed**2 + 10 / 7 * sign * G / way * (np.cos(start) - np.cos(theta))
    np.testing.assert_allclose(rate**2, square, atol=1e-9)

    # it presses with its weight's part less, in a bowl more, what the way's curvature needs
    press = G * np.cos(theta) - sign * way * square
    np.testing.assert_allclose(results["touch.normal_force"], press, atol=1e-8)
    point = R * np.column_stack([np.sin(theta), 0 * theta, sign * np.cos(theta)])
    np.testing.assert_allclose(columns(results, "touch.contact_point", 3), point, atol=1e-10)


def test_a_ball_that_rolls_in_an_upright_pipe_comes_up_again():
    # golfers know it: it sinks and rises sqrt(2/7) times for each turn in the pipe
    R, r, turning = 0.5, 0.1, 4.0
    shape, body = ball(r)
    results = scene(
        {"surface": {"cylinder": {"radius": R}}},
        shape,
        {
            "position": [R - r, 0, 0],
            "velocity": [0, turning * (R - r), 0],
            "omega": [0, 0, -turning * (R - r) / r],
        },
        **body,
    ).simulate(3.0, 0.1)
    t = results["time"]
    often = turning * np.sqrt(2 / 7)
    np.testing.assert_allclose(results["touch.s[1]"], turning * t, atol=1e-9)
    depth = 5 / 7 * G / often**2 * (1 - np.cos(often * t))
    np.testing.assert_allclose(results["b.position[3]"], -depth, atol=1e-8)
    np.testing.assert_allclose(results["touch.normal_force"], turning**2 * (R - r), atol=1e-8)


def test_friction_of_a_ball_on_a_slope():
    # two sevenths of what pulls it down
    slope = 0.3
    shape, body = ball(0.1, mass=2.0)
    lying = {"axis_angle": {"axis": "y", "angle_rad": slope}, "surface": {"plane": {}}}
    down = np.array([np.cos(slope), 0, -np.sin(slope)])
    start = {"position": [0.1 * np.sin(slope), 0, 0.1 * np.cos(slope)]}
    made = scene(lying, shape, start, **body)
    made.joint["touch"].output = ["normal_force", "friction_force"]
    results = made.simulate(1.0, 0.25)
    t = results["time"]
    way = 5 / 14 * G * np.sin(slope) * t**2
    moved = columns(results, "b.position", 3) - start["position"]
    np.testing.assert_allclose(moved, way[:, None] * down, atol=1e-10)
    np.testing.assert_allclose(results["touch.normal_force"], 2 * G * np.cos(slope), rtol=1e-10)
    held = [[-2 / 7 * 2 * G * np.sin(slope), 0, 0]] * len(t)
    np.testing.assert_allclose(columns(results, "touch.friction_force", 3), held, atol=1e-9)


def test_what_slides_keeps_its_spin_and_its_way():
    # a ball on a plane without friction: nothing turns it, nothing brakes it
    shape, body = ball(0.1)
    start = {"position": [0, 0, 0.1], "velocity": [1, 2, 0], "omega": [3, 4, 5]}
    made = scene({"surface": {"plane": {}}}, shape, start, "surface_on_surface", **body)
    results = made.simulate(1.0, 0.25)
    t = results["time"]
    way = np.column_stack([t, 2 * t, 0 * t + 0.1])
    np.testing.assert_allclose(columns(results, "b.position", 3), way, atol=1e-12)
    np.testing.assert_allclose(columns(results, "free.omega", 3), [[3, 4, 5]] * len(t), atol=1e-11)


def test_over_the_poles():
    # nothing depends on longitudes: a ball goes over both surfaces' poles as if they were turned
    shape, body = ball(0.2)
    runs = []

    for axis in ("z", "y"):
        turn = {"axes": {"z": axis, "x": "x"}}
        start = {
            "position": [0, 0, 1.2],
            "velocity": [0.9, 0, 0],
            "omega": [0, 4.5, 0],
        }
        made = scene(turn | {"surface": {"sphere": {"radius": 1.0}}}, shape, start, **body)
        runs.append(made.simulate(1.0, 0.1))

    for name in ("b.position", "b.omega_body"):
        np.testing.assert_allclose(columns(runs[0], name, 3), columns(runs[1], name, 3), atol=1e-10)


# two ways to write it


def test_it_does_not_matter_which_is_first():
    # an ellipsoid rolls on a ball that turns on a bearing, or the ball on it
    def run(*between):
        made = scene(
            {"surface": {"plane": {}}},
            {"ellipsoid": {"semi_axes": [0.3, 0.2, 0.25]}},
            {"position": [0, 0, 1.25], "omega": [1.0, 0.5, 2.0]},
            inertia=[0.02, 0.03, 0.025],
        )
        made.body["ball"] = {
            "mass": 2.0,
            "inertia": [0.8, 0.8, 0.8],
            "marker": {"skin": {"surface": ball(1.0)[0]}},
        }
        made.joint["bearing"] = {"spherical": {}, "between": ["ground", "ball"], "output": ["omega"]}
        made.joint["touch"].between = between
        made.joint["touch"].output = ["s", "normal_force"]
        return made.simulate(0.3, 0.05)

    one, two = run("ball.skin", "b.skin"), run("b.skin", "ball.skin")

    for name in ("b.position", "b.omega_body", "bearing.omega"):
        np.testing.assert_allclose(columns(one, name, 3), columns(two, name, 3), atol=1e-9)

    np.testing.assert_allclose(one["touch.normal_force"], two["touch.normal_force"], atol=1e-7)

    # it starts at poles, where longitudes may be any
    one_s, two_s = columns(one, "touch.s", 4)[1:, [2, 3, 0, 1]], columns(two, "touch.s", 4)[1:]
    np.testing.assert_allclose(np.exp(1j * one_s), np.exp(1j * two_s), atol=1e-8)
    np.testing.assert_allclose(one["total_energy"], one["total_energy"][0], rtol=1e-9)


@pytest.mark.parametrize("formulation", FORMULATIONS)
def test_a_disk_that_touches_is_a_rolling_disk(formulation):
    upright = {"zyx_deg": [0, 0, -80], "position": [0, 0, 0.984807753012]}
    start = upright | {"velocity": [3.08682408883, 0, 0], "omega_body": [0, -0.492403876506, 3.08682408883]}
    body = {"mass": 1.0, "inertia": [0.25, 0.25, 0.5]}
    solver = SOLVER | {"formulation": formulation}
    made = scene({"surface": {"plane": {}}}, {"disk": {"radius": 1.0}}, start, solver=solver, **body)
    one = made.simulate(1.0, 0.1)
    made.joint["touch"] = {
        "rolling_disk": {"radius": 1.0},
        "between": ["ground", "b"],
        "output": ["reaction_force"],
    }
    two = made.simulate(1.0, 0.1)

    for name in ("b.position", "b.velocity", "b.omega_body"):
        np.testing.assert_allclose(columns(one, name, 3), columns(two, name, 3), atol=1e-10)

    np.testing.assert_allclose(one["touch.normal_force"], two["touch.reaction_force[3]"], atol=1e-8)


# against equations of their own


def rolling_on_plane(support, mass, com, inertia, up, omega, times):
    """A body that rolls on a horizontal plane, by its angular momentum L about the point of contact, all in its own axes.

    support : unit normal -> (the point of the surface where that is its outward normal, the derivative of the point by it).
    up : the vertical. Returns up and omega (times, 3).

    With r from the centre of mass to the point of contact, v = -omega x r, so L = I omega + m r x (omega x r), and
    L' = L x omega + m r' x (omega x r) + m g r x up, up' = up x omega.
    """

    def about_contact(up):
        point, slope = support(-up)
        r = point - com
        return inertia + mass * (r @ r * np.eye(3) - np.outer(r, r)), r, slope

    def rate(_, x):
        up, L = x[:3], x[3:]
        whole, r, slope = about_contact(up)
        w = np.linalg.solve(whole, L)
        up_rate = np.cross(up, w)
        swept = mass * np.cross(-slope @ up_rate, np.cross(w, r))
        return np.concatenate([up_rate, np.cross(L, w) + swept + mass * G * np.cross(r, up)])

    start = np.concatenate([up, about_contact(up)[0] @ omega])
    x = solve_ivp(rate, (0, times[-1]), start, "DOP853", times, rtol=3e-13, atol=1e-15).y.T
    return x[:, :3], np.array([np.linalg.solve(about_contact(u)[0], L) for u, L in zip(x[:, :3], x[:, 3:])])


def ellipsoid(semi_axes):
    """`support` of an ellipsoid."""
    D = np.diag(np.square(semi_axes))

    def support(normal):
        h = np.sqrt(normal @ D @ normal)
        point = D @ normal / h
        return point, (D - np.outer(point, point)) / h

    return support


def rim(radius, tube):
    """`support` of a torus."""

    def support(normal):
        flat = np.hypot(normal[0], normal[1])
        out = np.array([normal[0], normal[1], 0]) / flat
        along = np.array([-out[1], out[0], 0])
        slope = radius / flat * np.outer(along, along) + tube * (np.eye(3) - np.outer(normal, normal))
        return radius * out + tube * normal, slope

    return support


def vertical(E):
    """The vertical in a body's axes by its Euler parameters (times, 4)."""
    E1, E2, E3, E4 = E.T
    return np.column_stack([2 * (E1 * E3 - E2 * E4), 2 * (E2 * E3 + E1 * E4), 1 - 2 * (E1**2 + E2**2)])


def agrees(results, support, mass, com, inertia, atol):
    """That a run of a body "b" is one of `rolling_on_plane`; returns omega (times, 3) in its axes."""
    up = vertical(columns(results, "free.euler_parameters", 4))
    omega = columns(results, "b.omega_body", 3)
    expected = rolling_on_plane(
        support, mass, np.array(com), np.array(inertia), up[0], omega[0], results["time"]
    )
    np.testing.assert_allclose(up, expected[0], atol=atol)
    np.testing.assert_allclose(omega, expected[1], atol=atol)
    np.testing.assert_allclose(results["total_energy"], results["total_energy"][0], rtol=1e-9)
    return omega


def test_a_wheel_with_a_round_rim():
    # tilted by 25 deg, rolling and turning, so that it nods
    body = {"mass": 3.0, "inertia": [0.06, 0.06, 0.1]}
    start = {"zyx_deg": [10, 0, 65], "position": [0, 0, 0.3], "omega_body": [0.2, 0.8, 4.0]}
    results = scene(
        {"surface": {"plane": {}}}, {"torus": {"radius": 0.27, "tube": 0.05}}, start, **body
    ).simulate(2.0, 0.1)
    agrees(results, rim(0.27, 0.05), 3.0, [0, 0, 0], np.diag([0.06, 0.06, 0.1]), 1e-9)
    assert np.ptp(vertical(columns(results, "free.euler_parameters", 4))[:, 2]) > 0.1


def rattleback():
    """The scene of models/, its stone called b, more exact."""
    made = mbdfmi.load(Path(__file__).parents[1] / "models" / "rattleback.toml")
    stone = made.body["stone"]
    return scene(
        {"surface": {"plane": {}}},
        {"ellipsoid": {"semi_axes": [0.2, 0.03, 0.02]}},
        made.joint["free"].start,
        mass=stone.mass,
        com=stone.com,
        inertia=stone.inertia,
    )


def test_a_rattleback_over_one_reversal_of_its_spin():
    made = rattleback()
    stone = made.body["b"]
    results = made.simulate(3.6, 0.1)
    omega = agrees(results, ellipsoid([0.2, 0.03, 0.02]), stone.mass, stone.com, stone.inertia, 1e-7)
    assert omega[0, 2] == pytest.approx(-5, abs=1e-12)
    assert omega[-1, 2] > 0.5


@pytest.mark.parametrize("formulation", FORMULATIONS)
def test_formulations_of_a_rattleback(formulation):
    made = rattleback()
    expected = made.simulate(0.1, 0.05)
    made.solver.formulation = formulation
    found = made.simulate(0.1, 0.05)
    np.testing.assert_allclose(
        columns(found, "b.omega_body", 3), columns(expected, "b.omega_body", 3), atol=1e-8
    )


# starts


def test_the_nearest_touch_is_found():
    # far above the plane, tilted: it goes down to it
    start = {"position": [0.3, -0.2, 2.0], "zyx_deg": [20, 30, 40]}
    made = scene({"surface": {"plane": {}}}, {"ellipsoid": {"semi_axes": [0.3, 0.2, 0.1]}}, start)
    results = made.simulate(1e-3, 1e-3)
    up = vertical(columns(results, "free.euler_parameters", 4))[0]
    height = np.sqrt(np.square([0.3, 0.2, 0.1]) @ np.square(up))
    np.testing.assert_allclose(results["b.position[3]"][0], height, atol=1e-12)


def test_given_parameters_are_kept():
    start = {"zyx_deg": [20, 30, 40]}
    ground = {"surface": {"ellipsoid": {"semi_axes": [1.0, 2.0, 1.5]}}}
    made = scene(ground, {"ellipsoid": {"semi_axes": [0.3, 0.2, 0.1]}}, start, contact={"s": [0.4, 0.7]})
    results = made.simulate(1e-3, 1e-3)
    np.testing.assert_allclose(columns(results, "touch.s", 4)[0, :2], [0.4, 0.7], atol=1e-9)
    point = [np.cos(0.7) * np.cos(0.4), 2 * np.cos(0.7) * np.sin(0.4), 1.5 * np.sin(0.7)]
    np.testing.assert_allclose(columns(results, "touch.contact_point", 3)[0], point, atol=1e-9)


# mistakes


def test_a_ball_does_not_fit_into_a_pipe_narrower_than_itself():
    start = {"position": [0.1, 0, 0]}
    made = scene({"surface": {"cylinder": {"radius": 0.5}}}, ball(0.6)[0], start)

    with pytest.raises(SimulationError, match="the surfaces of touch touch in more than a point"):
        made.simulate(1.0, 0.1)


def test_a_wheel_that_lies_flat_is_told():
    made = scene(
        {"surface": {"plane": {}}}, {"torus": {"radius": 0.27, "tube": 0.05}}, {"position": [0, 0, 0.05]}
    )

    with pytest.raises(SimulationError, match="a wheel that lies flat"):
        made.simulate(1.0, 0.1)


@pytest.mark.parametrize(
    "first, second, text",
    [
        ({"disk": {"radius": 1}}, {"sphere": {"radius": 1}}, 'the first surface, of "ground.m", is a disk'),
        ({"sphere": {"radius": 1}}, {"plane": {}}, 'the second surface, of "b.skin", must be one of "sphere", "ellipsoid", "disk" '),
        ({"sphere": {"radius": 1}}, {"prism": {"profile": {"circle": {"radius": 1}}}}, "found a prism"),
        ({"sphere": {"radius": 0}}, {"sphere": {"radius": 1}}, r"sphere.radius: must be greater than 0"),
        ({"ellipsoid": {"semi_axes": [1, 0, 2]}}, {"sphere": {"radius": 1}}, r"semi_axes: \[2\] must be greater than 0"),
        ({"ellipsoid": {"semi_axes": [1, 2]}}, {"sphere": {"radius": 1}}, r"needs 3 semi-axes \[a, b, c\] in m"),
    ],
)  # fmt: skip
def test_mistakes_are_told(first, second, text):
    with pytest.raises(SceneError, match=text):
        scene({"surface": first}, second, {}).compile()
