"""End frames on curves and surfaces: shapes, rows, reference digits, closed forms, reactions."""

import numpy as np
import pytest
from scipy.interpolate import CubicSpline, RectBivariateSpline

from benchmarks.problem_files import problem_file
from mbdfmi import Scene
from mbdfmi.compiler.model import compile_scene
from mbdfmi.kernels import joints
from mbdfmi.kernels.dynamics import multipliers, rows
from mbdfmi.kernels.end_frames import curves, on_surfaces, surfaces, touching
from mbdfmi.kernels.motion import kinematics
from mbdfmi.run.instance import Instance, SimulationError
from mbdfmi.run.simulate import simulate
from mbdfmi.scene import SceneError

SOLVER = {"integrator": "rk853", "tolerance": 1e-12}
SEED = 3
FORMULATIONS = ["recursive", "embedding", "augmented"]

TURN = np.linspace(0, 2 * np.pi, 14)[:-1]
HELIX = [[np.cos(a), np.sin(a), 0.3 * a] for a in TURN]
EGG = [[1.2 * np.cos(a) + 0.2 * np.cos(2 * a), 0.8 * np.sin(a)] for a in TURN]
S1, S2 = np.linspace(-2, 2, 9), np.linspace(-1.5, 1.5, 8)


def hill(x, y):
    """Height of a hill."""
    return 0.3 * np.cos(x) * np.exp(-0.3 * y**2)


CURVES = {
    "line": {"line": {}},
    "circle": {"circle": {"radius": 0.7}},
    "parabola": {"parabola": {"coefficient": 0.5}},
    "cycloid": {"cycloid": {"radius": 0.5}},
    "helix": {"spline": {"points": HELIX}},
    "egg": {"spline": {"points": EGG, "closed": True}},
    "table": {
        "table": {
            "s": [0, 1, 2.5, 3, 5],
            "points": [[0, 0], [1, 0.2], [2, 0.9], [2.2, 1.5], [2, 3]],
        }
    },
}
SURFACES = {
    "plane": {"plane": {}},
    "sphere": {"sphere": {"radius": 0.7}},
    "ellipsoid": {"ellipsoid": {"semi_axes": [0.7, 0.5, 0.9]}},
    "cylinder": {"cylinder": {"radius": 0.7}},
    "torus": {"torus": {"radius": 1.2, "tube": 0.4}},
    "prism": {"prism": {"profile": CURVES["egg"]}},
    "table": {
        "table": {
            "s1": S1.tolist(),
            "s2": S2.tolist(),
            "points": [[[x, y, hill(x, y)] for y in S2] for x in S1],
        }
    },
}
PAIRS = {
    "circles": ("circle", "circle"),
    "circle on line": ("line", "circle"),
    "line on egg": ("egg", "line"),
    "circle on egg": ("egg", "circle"),
    "circle on parabola": ("parabola", "circle"),
}
SHAPES = {
    "ball": {"sphere": {"radius": 0.3}},
    "egg-shaped": {"ellipsoid": {"semi_axes": [0.3, 0.2, 0.25]}},
    "wheel": {"torus": {"radius": 0.25, "tube": 0.05}},
    "coin": {"disk": {"radius": 0.3}},
}
TOUCHING = {
    "egg-shaped on plane": ("rolling_surface", "plane", "egg-shaped"),
    "coin on plane": ("rolling_surface", "plane", "coin"),
    "ball on sphere": ("surface_on_surface", "sphere", "ball"),
    "wheel on ellipsoid": ("rolling_surface", "ellipsoid", "wheel"),
    "wheel on cylinder": ("surface_on_surface", "cylinder", "wheel"),
    "egg-shaped on torus": ("rolling_surface", "torus", "egg-shaped"),
    "ball on table": ("rolling_surface", "table", "ball"),
}


def particle(
    contact,
    marker,
    position=None,
    velocity=(0, 0, 0),
    start=None,
    formulation="auto",
    output=(),
    **tables,
):
    """A scene of a particle of 1 kg that a contact holds on a curve or surface of a ground marker.

    start : of the contact's parameters; output : of the contact beside them.
    """
    hold = {
        "translation": {},
        "between": ["ground", "body"],
        "start": {"velocity": velocity},
        "output": ["velocity"],
    }
    touch = {contact: {}, "between": ["ground.shape", "body"], "output": ["s", "s_rate", *output]}

    if position is not None:
        hold["start"]["position"] = position

    if start is not None:
        touch["start"] = {"s": start}

    # in absolute coordinates even a particle turns
    moment = 0.1 if formulation == "augmented" else 0.0
    return Scene.model_validate(
        {
            "name": "particle",
            "ground": {"marker": {"shape": marker}},
            "body": {"body": {"mass": 1.0, "inertia": [moment] * 3, "output": ["position"]}},
            "joint": {"hold": hold, "contact": touch},
            "output": ["total_energy"],
            "solver": SOLVER | {"formulation": formulation},
        }
        | tables
    )


def columns(results, name, size):
    """An array variable (times, size)."""
    return np.column_stack([results[f"{name}[{k + 1}]"] for k in range(size)])


def reference(name):
    """Columns by name, times from the second communication point on."""
    return problem_file(name)["column"]


# shapes


def difference(f, s, h=1e-5):
    """Derivative of f by central differences."""
    return (np.array(f(s + h)) - np.array(f(s - h))) / (2 * h)


@pytest.mark.parametrize("name", CURVES)
def test_derivatives_of_curves(name):
    m = Instance(compile_scene(particle("point_on_curve", {"curve": CURVES[name]}, (0.5, 0.2, 0)))).m

    for s in np.random.default_rng(SEED).uniform(-2, 7, 40):
        r, t, tt = curves.point(m, 0, s)
        near = 2e-5 if name in ("helix", "egg", "table") else 1e-9
        np.testing.assert_allclose(t, difference(lambda s: curves.point(m, 0, s)[0], s), atol=1e-9)
        np.testing.assert_allclose(tt, difference(lambda s: curves.point(m, 0, s)[1], s), atol=near)

        # but at a knot, where it jumps
        third = difference(lambda s: curves.point(m, 0, s)[2], s)
        assert np.allclose(curves.third(m, 0, s), third, atol=1e-7) or (
            name in ("helix", "egg", "table") and np.abs(third).max() > 100
        )


def test_splines_are_those_of_scipy():
    scene = particle("point_on_curve", {"curve": CURVES["helix"]}, (0.9, 0.1, 0))
    m = Instance(compile_scene(scene)).m
    curve = scene.ground.marker["shape"].curve
    expected = CubicSpline(curve.s, curve.points)

    for s in np.linspace(curve.s[0], curve.s[-1], 50):
        np.testing.assert_allclose(curves.point(m, 0, s), [expected(s, nu) for nu in range(3)], atol=1e-12)

    # beyond its ends it goes on straight
    r, t, tt = curves.point(m, 0, curve.s[-1] + 2.0)
    np.testing.assert_allclose(r, expected(curve.s[-1]) + 2.0 * expected(curve.s[-1], 1), atol=1e-12)
    assert tt == (0, 0, 0)


def test_closed_splines_run_on():
    scene = particle("point_on_curve", {"curve": CURVES["egg"]}, (1.4, 0, 0))
    m = Instance(compile_scene(scene)).m
    period = np.ptp(scene.ground.marker["shape"].curve.s)

    for s in np.random.default_rng(SEED).uniform(0, period, 10):
        np.testing.assert_allclose(curves.point(m, 0, s), curves.point(m, 0, s - 3 * period), atol=1e-12)


@pytest.fixture(params=SURFACES)
def beside(request):
    """(name, model) of a surface, surface 1 of the model beside an ellipsoid."""
    shapes = {"shape": {"surface": {"ellipsoid": {"semi_axes": [1.1, 1.3, 0.8]}}}}
    shapes["beside"] = {"surface": SURFACES[request.param]}
    joint = {}

    for name in shapes:
        joint[f"hold {name}"] = {"translation": {}, "between": ["ground", name]}
        joint[name] = {"point_on_surface": {}, "between": [f"ground.{name}", name]}

    body = {key: {"mass": 1.0, "inertia": [0.0] * 3} for key in shapes}
    scene = Scene(name="beside", ground={"marker": shapes}, body=body, joint=joint)
    return request.param, compile_scene(scene).views()[0]


def test_derivatives_of_surfaces(beside):
    name, m = beside
    near = 2e-5 if name in ("prism", "table") else 1e-9

    for s1, s2 in np.random.default_rng(SEED).uniform(-2.3, 2.3, (40, 2)):
        r, r1, r2, r11, r12, r22 = surfaces.point(m, 1, s1, s2)
        by1 = difference(lambda s: surfaces.point(m, 1, s, s2)[:3], s1)
        by2 = difference(lambda s: surfaces.point(m, 1, s1, s)[:3], s2)
        np.testing.assert_allclose([r1, r11, r12], by1, atol=near)
        np.testing.assert_allclose([r2, r12, r22], by2, atol=near)


def test_how_tangents_bend_along_a_way(beside):
    """Second derivatives of r_1 and r_2 at steady rates of the parameters, by differences."""
    name, m = beside
    rng = np.random.default_rng(SEED)
    # within one piece of what is made of pieces
    low, high = (0.02, 0.08) if name in ("prism", "table") else (-1.4, 1.4)

    for s1, s2, u1, u2 in rng.uniform((low, low, -1, -1), (high, high, 1, 1), (8, 4)):

        def tangents(t):
            return np.array(surfaces.point(m, 1, s1 + u1 * t, s2 + u2 * t)[1:3])

        h = 2e-3
        by_differences = (tangents(h) - 2 * tangents(0.0) + tangents(-h)) / h**2
        found = surfaces.second_changes(m, 1, s1, s2, u1, u2)
        np.testing.assert_allclose(found, by_differences, atol=1e-5)


def test_rates_of_parameters_where_they_are_singular():
    """A point that moves along a surface tells how its parameters change, but where the tangents are parallel."""
    r1, r2, rates = np.array([0.3, -0.2, 0.5]), np.array([0.1, 0.7, 0.2]), np.array([0.4, -1.1])
    found = on_surfaces.surface_rates(tuple(rates @ [r1, r2]), tuple(r1), tuple(r2))
    np.testing.assert_allclose(found, rates, rtol=1e-13)
    assert on_surfaces.surface_rates((1.0, 2.0, 3.0), tuple(r1), tuple(-2.0 * r1)) == (0.0, 0.0)
    assert on_surfaces.surface_rates((1.0, 2.0, 3.0), (0.0, 0.0, 0.0), tuple(r2)) == (0.0, 0.0)


def test_tables_are_bicubic_splines():
    scene = particle("point_on_surface", {"surface": SURFACES["table"]}, (0, 0, 0.3))
    m = Instance(compile_scene(scene)).m
    spline = RectBivariateSpline(S1, S2, hill(S1[:, None], S2), s=0)

    for x, y in np.random.default_rng(SEED).uniform((-2, -1.5), (2, 1.5), (30, 2)):
        r, r1, r2, r11, r12, r22 = surfaces.point(m, 0, x, y)
        np.testing.assert_allclose(r, (x, y, spline.ev(x, y)), atol=1e-12)
        np.testing.assert_allclose(r12[2], spline.ev(x, y, 1, 1), atol=1e-11)

    # beyond its edges it goes on straight
    assert surfaces.point(m, 0, 3.0, 0.5)[3] == pytest.approx((0, 0, 0), abs=1e-13)


# rows against differences, on two moving bodies


def moving_scene(contact, shape, end=None, **tables):
    """Two bodies in free motion, a contact between markers off their centres.

    contact : its kind, and its spin where that is free. Two curves are in parallel planes; of two surfaces the second one touches from
    outside.
    """
    rng = np.random.default_rng(SEED)

    def frame():
        return {"position": rng.uniform(-1, 1, 3).tolist(), "euler_parameters": turn().tolist()}

    def turn():
        E = rng.normal(size=4)
        return E / np.linalg.norm(E)

    def body(marker):
        return {
            "mass": 1.5,
            "com": rng.uniform(-0.3, 0.3, 3).tolist(),
            "inertia": [0.5, 0.6, 0.7],
            "marker": marker,
        }

    planar = contact == "curve_on_curve"
    markers = [frame() | shape, frame() | (end or {})]
    free = {"velocity": rng.normal(size=3).tolist(), "omega": rng.normal(size=3).tolist()}
    held = {"a": {"free": {}, "between": ["ground", "a"], "start": frame() | free}}

    if planar:
        near = {"position": [0.3, 1.4], "angle": 0.4, "velocity": [0.5, -0.8], "angular_speed": 1.1}
        held["b"] = {"planar": {}, "between": ["a.shape", "b.end"], "start": near}
    else:
        near = {
            "position": [1.9, 0.2, 0.5] if end else [0.9, 0.2, 0.1],
            "euler_parameters": turn().tolist(),
        } | free
        held["b"] = {"free": {}, "between": ["a.shape", "b.end"], "start": near}

    kind, _, spin = contact.partition(" ")
    held["contact"] = {kind: {"spin": spin} if spin else {}, "between": ["a.shape", "b.end"]}
    return Scene.model_validate(
        {
            "name": "moving",
            "body": {"a": body({"shape": markers[0]}), "b": body({"end": markers[1]})},
            "joint": held,
            "solver": SOLVER,
        }
        | tables
    )


CONTACTS = [("point_on_curve", {"curve": c}, None) for c in CURVES.values()]
CONTACTS += [("point_on_surface", {"surface": c}, None) for c in SURFACES.values()]
CONTACTS += [("curve_on_curve", {"curve": CURVES[a]}, {"curve": CURVES[b]}) for a, b in PAIRS.values()]
CONTACTS += [("frame_on_curve", {"curve": c}, None) for c in CURVES.values()]
CONTACTS += [("frame_on_surface", {"surface": c}, None) for c in SURFACES.values()]
CONTACTS += [("frame_on_curve free", {"curve": CURVES["helix"]}, None)]
CONTACTS += [("frame_on_surface free", {"surface": SURFACES[name]}, None) for name in ("torus", "sphere")]
CONTACTS += [(kind, {"surface": SURFACES[a]}, {"surface": SHAPES[b]}) for kind, a, b in TOUCHING.values()]
NAMES = [
    *(f"point on {name}" for name in CURVES),
    *(f"point on {name}" for name in SURFACES),
    *PAIRS,
    *(f"frame on {name}" for name in CURVES),
    *(f"frame on {name}" for name in SURFACES),
    *(f"spinning on {name}" for name in ("helix", "torus", "sphere")),
    *TOUCHING,
]


def see(m, d):
    kinematics.kinematics(m, d)
    touching.find_parameters(m, d)
    rows.write_rows(m, d)


def moved(m, d, x, acceleration, t):
    """x after a time t (s) of a motion of constant v': midpoint rule and extrapolation."""

    def run(n):
        y = x.copy()

        for k in range(n):
            start, h = y.copy(), t / n

            for part in (0.5, 1.0):
                d.x[:] = y
                kinematics.kinematics(m, d)

                for i in range(1, m.n_body):
                    joints.position_rates(m, d, i)

                touching.parameter_rates(m, d)
                d.v_rate[:] = acceleration
                y = start + part * h * d.x_rate

        return y

    return (4 * run(8) - run(4)) / 3


@pytest.mark.parametrize("contact, shape, end", CONTACTS, ids=NAMES)
def test_rows_against_differences(contact, shape, end):
    instance = Instance(compile_scene(moving_scene(contact, shape, end)))
    m, d = instance.m, instance.d
    rng = np.random.default_rng(SEED)
    x = d.x.copy()
    see(m, d)
    np.testing.assert_allclose(d.row_gap, 0, atol=1e-13)
    np.testing.assert_allclose(d.row_rate, 0, atol=1e-12)
    np.testing.assert_allclose(d.x, x, atol=1e-12)

    def at(acceleration, t, start=x):
        d.x[:] = moved(m, d, start, acceleration, t)
        see(m, d)
        return d.row_gap.copy(), d.row_rate.copy()

    # g'' of bodies that accelerate as they please
    acceleration = rng.normal(size=m.n_v)
    h = 1e-4
    by_difference = (at(acceleration, h)[1] - at(acceleration, -h)[1]) / (2 * h)
    d.x[:] = x
    see(m, d)
    d.v_rate[:] = acceleration
    kinematics.accelerations(m, d)
    found = [multipliers.row_acceleration(m, d, row) for row in range(m.n_row)]
    np.testing.assert_allclose(found, by_difference, atol=1e-5 * (1 + np.abs(by_difference).max()))

    # g' of any velocities, by differences and by the rows' wrenches
    d.v[:] += rng.normal(size=m.n_v)
    start = d.x.copy()
    zero = np.zeros(m.n_v)
    by_difference = (at(zero, h, start)[0] - at(zero, -h, start)[0]) / (2 * h)
    d.x[:] = start
    see(m, d)
    i, j = (m.marker_body[k[0]] for k in (m.constraint_from, m.constraint_to))
    w, rd = d.w.reshape(-1, 3), d.rd.reshape(-1, 3)
    power = d.row_moment_from.reshape(-1, 3) @ w[i] + d.row_force_from.reshape(-1, 3) @ rd[i]
    power += d.row_moment_to.reshape(-1, 3) @ w[j] + d.row_force_to.reshape(-1, 3) @ rd[j]
    np.testing.assert_allclose(power, d.row_rate, atol=1e-12)
    of_places = [not rows.is_of_velocity(m, row) for row in range(m.n_row)]
    np.testing.assert_allclose(
        d.row_rate[of_places], by_difference[of_places], atol=1e-5 * (1 + np.abs(by_difference).max())
    )


def test_what_keeps_a_ball_from_slipping_turns_with_it():
    """g'' of a ball that rolls on a sphere against g' a moment before and after: what the test above asks of all, in short."""
    free = {"velocity": [0.3, -0.2, 0.5], "omega": [0.7, -1.1, 0.4]}
    place = np.array([0.48, 0.6, 0.64])
    body = {"mass": 1.0, "inertia": [0.1] * 3}
    scene = Scene(
        name="balls",
        body={
            "a": body | {"marker": {"shape": {"surface": {"sphere": {"radius": 0.7}}}}},
            "b": body | {"marker": {"end": {"surface": {"sphere": {"radius": 0.3}}}}},
        },
        joint={
            "a": {"free": {}, "between": ["ground", "a"], "start": free},
            "b": {"free": {}, "between": ["ground", "b"], "start": free | {"omega": [-0.5, 2.0, 1.0]}},
            "rolls": {"rolling_surface": {}, "between": ["a.shape", "b.end"]},
        },
    )
    m, d = compile_scene(scene).views()

    for i in range(1, m.n_body):
        joints.start(m, d, i)

    d.q[m.body_q[2] : m.body_q[2] + 3] = place
    d.end_frame_side[0] = 1.0
    d.z[:] = [*surfaces.bearing(place), 0.0, 0.0, *(place / np.linalg.norm(place))]
    see(m, d)
    slip, columns = d.row_rate.copy(), []

    # the nearest velocities that roll
    for v in range(m.n_v):
        d.v[v] += 1.0
        see(m, d)
        d.v[v] -= 1.0
        columns.append(d.row_rate - slip)

    d.v[:] -= np.linalg.lstsq(np.array(columns).T, slip)[0]
    see(m, d)
    assert np.abs(d.row_rate).max() < 1e-13
    x, h = d.x.copy(), 1e-4
    d.v_rate[:] = 0.0
    kinematics.accelerations(m, d)
    found = [multipliers.row_acceleration(m, d, row) for row in range(m.n_row)]
    rates = []

    for t in (-h, h):
        d.x[:] = moved(m, d, x, np.zeros(m.n_v), t)
        see(m, d)
        rates.append(d.row_rate.copy())

    assert np.abs(d.row_gap[0]) < 1e-3
    np.testing.assert_allclose(found, (rates[1] - rates[0]) / (2 * h), atol=1e-7)


@pytest.mark.parametrize("contact, shape, end", CONTACTS, ids=NAMES)
def test_rates_of_parameters_against_differences(contact, shape, end):
    instance = Instance(compile_scene(moving_scene(contact, shape, end)))
    m, d = instance.m, instance.d
    x = d.x.copy()
    h = 1e-4
    ends = []

    for t in (-h, h):
        d.x[:] = moved(m, d, x, np.zeros(m.n_v), t)
        see(m, d)
        ends.append(d.z.copy())

    d.x[:] = x
    see(m, d)
    touching.parameter_rates(m, d)
    by_difference = (ends[1] - ends[0]) / (2 * h)
    np.testing.assert_allclose(d.z_rate, by_difference, rtol=1e-5, atol=1e-5)


@pytest.mark.parametrize("contact, shape, end", CONTACTS, ids=NAMES)
def test_energy_and_momentum_of_moving_bodies(contact, shape, end):
    output = [
        "kinetic_energy",
        "linear_momentum",
        "angular_momentum",
        "constraint_gap",
        "constraint_rate",
    ]
    scene = moving_scene(contact, shape, end, gravity=[0, 0, 0], output=output)
    # an open spline goes on straight beyond its ends (here after 0.22 s): its curvature jumps there, and with it how fast what is held
    # to its frame turns, which takes energy
    until = 0.2 if contact == "frame_on_curve" and "table" in shape["curve"] else 0.5
    results = simulate(compile_scene(scene), until=until, step=0.05)
    energy = results["kinetic_energy"]
    np.testing.assert_allclose(energy, energy[0], rtol=1e-9)

    for name in ("linear_momentum", "angular_momentum"):
        momentum = columns(results, name, 3)
        np.testing.assert_allclose(momentum, momentum[[0]] + 0 * momentum, atol=1e-8)

    assert np.abs(results["constraint_gap"]).max() < 1e-12
    assert np.abs(results["constraint_rate"]).max() < 1e-11


# particles against reference digits


@pytest.mark.parametrize("formulation", FORMULATIONS)
def test_bead_on_parabola(formulation):
    marker = {"curve": CURVES["parabola"]}
    scene = particle("point_on_curve", marker, (1, 0.5, 0), formulation=formulation, gravity=[0, -9.81, 0])
    results = simulate(compile_scene(scene), until=10.0, step=0.5)
    expected = reference("bead_on_parabola")
    np.testing.assert_allclose(results["body.position[1]"][1:], expected["x"], atol=1e-10)
    np.testing.assert_allclose(results["contact.s"][1:], expected["x"], atol=1e-10)
    np.testing.assert_allclose(results["contact.s_rate"][1:], expected["xd"], atol=1e-10)


@pytest.mark.parametrize("formulation", FORMULATIONS)
def test_cycloid_isochrone(formulation):
    # the particle is put where s says
    R, arc = 0.5, 1.2
    marker = {"position": [0, -2 * R, 0], "curve": {"cycloid": {"radius": R}}}
    start = 2 * np.arcsin(arc / (4 * R))
    scene = particle("point_on_curve", marker, start=start, formulation=formulation, gravity=[0, -9.81, 0])
    results = simulate(compile_scene(scene), until=10.0, step=0.5)
    expected = reference("cycloid_isochrone")
    s = results["contact.s"][1:]
    np.testing.assert_allclose(results["body.position[1]"][1:], expected["x"], atol=1e-10)
    np.testing.assert_allclose(results["body.position[2]"][1:], expected["y"], atol=1e-10)
    np.testing.assert_allclose(4 * R * np.sin(s / 2), expected["s"], atol=1e-10)
    np.testing.assert_allclose(
        2 * R * np.cos(s / 2) * results["contact.s_rate"][1:], expected["sd"], atol=1e-10
    )


@pytest.mark.parametrize("arc", [0.01, 0.5, 1.0, 1.9])
def test_period_on_a_cycloid_does_not_depend_on_the_amplitude(arc):
    R = 0.5
    marker = {"curve": {"cycloid": {"radius": R}}}
    start = 2 * np.arcsin(arc / (4 * R))
    scene = particle("point_on_curve", marker, start=start, gravity=[0, -9.81, 0])
    period = 2 * np.pi / np.sqrt(9.81 / (4 * R))
    results = simulate(compile_scene(scene), until=3 * period, step=period)
    np.testing.assert_allclose(results["contact.s"], start, rtol=1e-8)


@pytest.mark.parametrize("formulation", FORMULATIONS)
def test_particle_on_torus(formulation):
    data = problem_file("particle_on_torus")["bodies"][0]
    marker = {"surface": {"torus": {"radius": 2.0, "tube": 0.5}}}
    scene = particle("point_on_surface", marker, data["r0"], data["v0"], formulation=formulation)
    results = simulate(compile_scene(scene), until=10.0, step=0.5)
    expected = reference("particle_on_torus")
    s, s_rate = columns(results, "contact.s", 2), columns(results, "contact.s_rate", 2)
    np.testing.assert_allclose(s[1:].T, [expected["phi"], expected["theta"]], atol=1e-8)
    np.testing.assert_allclose(s_rate[1:].T, [expected["phid"], expected["thetad"]], atol=1e-7)
    np.testing.assert_allclose(
        columns(results, "body.position", 3)[1:].T, [expected[k] for k in "xyz"], atol=1e-8
    )
    momentum = (2 + 0.5 * np.cos(s[:, 1])) ** 2 * s_rate[:, 0]
    np.testing.assert_allclose(momentum, momentum[0], rtol=1e-9)
    np.testing.assert_allclose(results["total_energy"], results["total_energy"][0], rtol=1e-9)


@pytest.mark.parametrize("formulation", FORMULATIONS)
def test_particle_on_sphere(formulation):
    marker = {"surface": {"sphere": {"radius": 1.0}}}
    scene = particle("point_on_surface", marker, (1, 0, 0), (0, 2, 0), formulation=formulation)
    results = simulate(compile_scene(scene), until=10.0, step=0.5)
    expected = reference("spherical_pendulum")
    r = np.array([expected[k] for k in "xyz"])
    v = np.array([expected[f"v{k}"] for k in "xyz"])
    np.testing.assert_allclose(columns(results, "body.position", 3)[1:].T, r, atol=1e-9)
    np.testing.assert_allclose(columns(results, "hold.velocity", 3)[1:].T, v, atol=1e-8)
    s, s_rate = columns(results, "contact.s", 2)[1:], columns(results, "contact.s_rate", 2)[1:]
    np.testing.assert_allclose(np.cos(s[:, 0]) * np.cos(s[:, 1]), r[0], atol=1e-9)
    np.testing.assert_allclose(s_rate[:, 1] * np.cos(s[:, 1]), v[2], atol=1e-8)
    assert s[-1, 0] > 2 * np.pi


def test_sphere_through_its_pole():
    # a pendulum in a plane passes the pole, where longitudes jump and the motion does not
    marker = {"surface": {"sphere": {"radius": 1.0}}}
    results = simulate(compile_scene(particle("point_on_surface", marker, (1, 0, 0))), until=5.0, step=0.1)
    pendulum = Scene.model_validate(
        {
            "name": "pendulum",
            "body": {"bob": {"mass": 1, "com": [0, 0, -1], "inertia": [0, 0, 0]}},
            "joint": {
                "pin": {
                    "revolute": {"axis": "y"},
                    "between": ["ground", "bob"],
                    "start": {"angle_deg": -90},
                    "output": ["angle"],
                }
            },
            "solver": SOLVER,
        }
    )
    angle = simulate(compile_scene(pendulum), until=5.0, step=0.1)["pin.angle"]
    np.testing.assert_allclose(results["body.position[1]"], -np.sin(angle), atol=1e-10)
    np.testing.assert_allclose(results["body.position[3]"], -np.cos(angle), atol=1e-10)


HOOP = {"axes": {"x": [1, 0, 0], "y": [0, 0, 1]}, "curve": {"circle": {"radius": 1.0}}}


def hoop_start():
    """Position and velocity of the bead at the start in the inertial frame."""
    return {"position": [np.sin(0.1), 0, -np.cos(0.1)], "velocity": [0, 5 * np.sin(0.1), 0]}


@pytest.mark.parametrize("formulation", FORMULATIONS)
def test_bead_on_a_driven_hoop(formulation):
    scene = Scene.model_validate(
        {
            "name": "hoop",
            "body": {
                "bead": {"mass": 1.0, "inertia": [0.1, 0.1, 0.1]},
                "hoop": {"mass": 2.0, "inertia": [1, 1, 1], "marker": {"wire": HOOP}},
            },
            "joint": {
                "shaft": {
                    "revolute": {},
                    "between": ["ground", "hoop"],
                    "driver": {"constant_speed": 5.0},
                },
                "hold": {"translation": {}, "between": ["ground", "bead"], "start": hoop_start()},
                "wire": {
                    "point_on_curve": {},
                    "between": ["hoop.wire", "bead"],
                    "output": ["s", "s_rate"],
                },
            },
            "solver": SOLVER | {"formulation": formulation},
        }
    )
    results = simulate(compile_scene(scene), until=10.0, step=0.5)
    expected = reference("bead_rotating_hoop")
    theta = results["wire.s"][1:] - 1.5 * np.pi
    np.testing.assert_allclose(theta, expected["theta"], atol=1e-8)
    np.testing.assert_allclose(results["wire.s_rate"][1:], expected["thetad"], atol=1e-8)


def test_bead_on_a_hoop_that_turns_with_the_ground():
    scene = Scene.model_validate(
        {
            "name": "hoop",
            "ground": {
                "motion": {"rotation": {"axis": "z", "speed": 5.0}},
                "marker": {"wire": HOOP},
            },
            "body": {"bead": {"mass": 1.0, "inertia": [0, 0, 0]}},
            "joint": {
                "hold": {
                    "translation": {},
                    "between": ["ground", "bead"],
                    "start": {"position": hoop_start()["position"]},
                },
                "wire": {
                    "point_on_curve": {},
                    "between": ["ground.wire", "bead"],
                    "output": ["s", "s_rate"],
                },
            },
            "solver": SOLVER,
        }
    )
    results = simulate(compile_scene(scene), until=10.0, step=0.5)
    expected = reference("bead_rotating_hoop")
    np.testing.assert_allclose(results["wire.s"][1:] - 1.5 * np.pi, expected["theta"], atol=1e-8)
    np.testing.assert_allclose(results["wire.s_rate"][1:], expected["thetad"], atol=1e-8)


# reactions


def test_force_on_a_bead_on_a_parabola():
    # N = m (g cos(slope) + curvature v^2), along the normal
    marker = {"curve": CURVES["parabola"]}
    scene = particle("point_on_curve", marker, (1, 0.5, 0), gravity=[0, -9.81, 0], output=["reaction_force"])
    results = simulate(compile_scene(scene), until=2.0, step=0.1)
    x, xd = results["contact.s"], results["contact.s_rate"]
    length = np.sqrt(1 + x**2)
    speed = xd * length
    normal = np.column_stack([-x, np.ones_like(x), 0 * x]) / length[:, None]
    size = 9.81 / length + speed**2 / length**3
    np.testing.assert_allclose(
        columns(results, "contact.reaction_force", 3), size[:, None] * normal, atol=1e-9
    )


def test_force_on_a_particle_on_a_sphere():
    marker = {"surface": {"sphere": {"radius": 0.8}}}
    scene = particle("point_on_surface", marker, (0.8, 0, 0), (0, 2, 0), output=["reaction_force"])
    results = simulate(compile_scene(scene), until=2.0, step=0.1)
    r, v = columns(results, "body.position", 3), columns(results, "hold.velocity", 3)
    size = (9.81 * r[:, 2] - (v**2).sum(1)) / 0.8
    np.testing.assert_allclose(
        columns(results, "contact.reaction_force", 3), size[:, None] * r / 0.8, atol=1e-9
    )


# cams


def cam_scene(cam, follower, formulation="auto", drive=True, **tables):
    """A cam that turns about the ground's z axis and a follower of 2 kg that moves along y."""
    shaft = {"revolute": {}, "between": ["ground", "cam"], "output": ["angle", "speed"]}
    shaft |= {"driver": {"constant_speed": 3.0}} if drive else {"start": {"speed": 3.0}}
    return Scene.model_validate(
        {
            "name": "cam",
            "gravity": [0, -9.81, 0],
            "body": {
                "cam": {
                    "mass": 1.0,
                    "com": [0.1, 0, 0],
                    "inertia": [0.1, 0.1, 0.2],
                    "marker": {"edge": cam},
                },
                "follower": {"mass": 2.0, "inertia": [0.1, 0.1, 0.1], "marker": {"edge": follower}},
            },
            "joint": {
                "shaft": shaft,
                "guide": {
                    "prismatic": {"axis": "y"},
                    "between": ["ground", "follower"],
                    "start": {"position": 0.6},
                    "output": ["position", "speed", "acceleration"],
                },
                "contact": {
                    "curve_on_curve": {},
                    "between": ["cam.edge", "follower.edge"],
                    "output": ["s", "s_rate", "reaction_force", "reaction_moment"],
                },
            },
            "output": ["total_energy"],
            "solver": SOLVER | {"formulation": formulation},
        }
        | tables
    )


R, ECCENTRICITY = 0.4, 0.15
ECCENTRIC = {"position": [ECCENTRICITY, 0, 0], "curve": {"circle": {"radius": R}}}


@pytest.mark.parametrize("formulation", FORMULATIONS)
def test_eccentric_cam_under_a_flat_follower(formulation):
    scene = cam_scene(ECCENTRIC, {"curve": {"line": {}}}, formulation)
    results = simulate(compile_scene(scene), until=3.0, step=0.05)
    angle = 3.0 * results["time"]
    np.testing.assert_allclose(results["guide.position"], R + ECCENTRICITY * np.sin(angle), atol=1e-11)
    np.testing.assert_allclose(results["guide.speed"], 3.0 * ECCENTRICITY * np.cos(angle), atol=1e-10)
    acceleration = -9.0 * ECCENTRICITY * np.sin(angle)
    np.testing.assert_allclose(results["guide.acceleration"], acceleration, atol=1e-9)

    # it touches above the circle's centre; in the cam's axes the circle is passed backwards
    np.testing.assert_allclose(results["contact.s[2]"], ECCENTRICITY * np.cos(angle), atol=1e-10)
    np.testing.assert_allclose(results["contact.s_rate[1]"], -3.0 * R, atol=1e-9)

    # the force is vertical and bears and accelerates the follower
    force = columns(results, "contact.reaction_force", 3)
    up = np.column_stack([np.sin(angle), np.cos(angle), 0 * angle])
    np.testing.assert_allclose(force, 2.0 * (9.81 + acceleration)[:, None] * up, atol=1e-8)


@pytest.mark.parametrize("formulation", FORMULATIONS)
def test_eccentric_cam_under_a_roller(formulation):
    r = 0.1
    scene = cam_scene(ECCENTRIC, {"curve": {"circle": {"radius": r}}}, formulation)
    results = simulate(compile_scene(scene), until=3.0, step=0.05)
    angle = 3.0 * results["time"]
    x, y = ECCENTRICITY * np.cos(angle), ECCENTRICITY * np.sin(angle)
    np.testing.assert_allclose(results["guide.position"], y + np.sqrt((R + r) ** 2 - x**2), atol=1e-11)


def test_energy_of_a_cam_that_turns_freely():
    egg = {"curve": {"spline": {"points": (0.3 * np.array(EGG)).tolist(), "closed": True}}}
    scene = cam_scene(egg, {"curve": {"circle": {"radius": 0.1}}}, drive=False)
    results = simulate(compile_scene(scene), until=3.0, step=0.05)
    np.testing.assert_allclose(results["total_energy"], results["total_energy"][0], rtol=1e-8)
    assert np.ptp(results["guide.position"]) > 0.05


def test_parabola_rocks_on_a_line():
    # the height of a parabola's vertex above its horizontal tangent
    c = 2.0
    scene = Scene.model_validate(
        {
            "name": "rocker",
            "gravity": [0, -9.81, 0],
            "ground": {"marker": {"floor": {"curve": {"line": {}}}}},
            "body": {
                "rocker": {
                    "mass": 1.5,
                    "com": [0, 0.1, 0],
                    "inertia": [0.02, 0.02, 0.03],
                    "marker": {"edge": {"curve": {"parabola": {"coefficient": c}}}},
                    "output": ["position"],
                }
            },
            "joint": {
                "plane": {
                    "planar": {},
                    "between": ["ground", "rocker"],
                    "start": {"position": [0, 0.1], "angle": 0.5, "velocity": [0.3, 0]},
                    "output": ["angle", "velocity", "angular_speed"],
                },
                "contact": {
                    "curve_on_curve": {},
                    "between": ["ground.floor", "rocker.edge"],
                    "output": ["s"],
                },
            },
            "output": ["total_energy", "linear_momentum"],
            "solver": SOLVER,
        }
    )
    results = simulate(compile_scene(scene), until=4.0, step=0.05)
    angle = results["plane.angle"]
    assert np.ptp(angle) > 0.5
    slope = -np.tan(angle)
    height = np.sin(angle) ** 2 / (4 * c * np.cos(angle))
    np.testing.assert_allclose(results["contact.s[2]"], slope / (2 * c), atol=1e-11)
    np.testing.assert_allclose(results["rocker.position[2]"], height, atol=1e-11)
    np.testing.assert_allclose(results["total_energy"], results["total_energy"][0], rtol=1e-9)
    np.testing.assert_allclose(results["linear_momentum[1]"], results["linear_momentum[1]"][0], atol=1e-9)


# assembly


def test_particle_goes_to_the_given_parameter_on_the_far_side():
    marker = {"curve": CURVES["circle"]}
    scene = particle("point_on_curve", marker, start=0.7 * np.pi)
    x = Instance(compile_scene(scene)).d.x
    np.testing.assert_allclose(x[:3], (-0.7, 0, 0), atol=1e-13)
    np.testing.assert_allclose(x[6], 0.7 * np.pi, rtol=1e-13)


def test_given_position_is_kept_and_the_parameter_found():
    marker = {"curve": CURVES["circle"]}
    scene = particle("point_on_curve", marker, (0, -0.7, 0))
    x = Instance(compile_scene(scene)).d.x
    np.testing.assert_allclose(x[:3], (0, -0.7, 0), atol=1e-13)
    np.testing.assert_allclose(x[6], 1.5 * np.pi * 0.7, rtol=1e-13)


def test_contact_out_of_reach():
    # a bob on a rod of 1 m cannot get to a circle of 3 m
    scene = Scene.model_validate(
        {
            "name": "short",
            "ground": {"marker": {"shape": {"curve": {"circle": {"radius": 3.0}}}}},
            "body": {"bob": {"mass": 1, "inertia": [1, 1, 1], "marker": {"end": {"position": [1, 0, 0]}}}},
            "joint": {
                "pin": {"revolute": {}, "between": ["ground", "bob"]},
                "rim": {"point_on_curve": {}, "between": ["ground.shape", "bob.end"]},
            },
        }
    )

    with pytest.raises(SimulationError, match="cannot be closed at rim"):
        Instance(compile_scene(scene))


def test_two_lines_do_not_roll_on_each_other():
    with pytest.raises(SceneError, match="two straight lines"):
        compile_scene(cam_scene({"curve": {"line": {}}}, {"curve": {"line": {}}}))


def test_contact_given_twice_changes_nothing():
    scene = particle("point_on_curve", {"curve": CURVES["helix"]}, (1, 0, 0))
    twice = scene.model_copy(update={"joint": scene.joint | {"again": scene.joint["contact"]}})
    once, twice = (simulate(compile_scene(s), until=1.0, step=0.1) for s in (scene, twice))
    np.testing.assert_allclose(twice["contact.s"], once["contact.s"], atol=1e-10)
    np.testing.assert_allclose(twice["again.s"], once["contact.s"], atol=1e-10)


def test_units_of_parameters():
    model = compile_scene(
        particle("point_on_surface", {"surface": SURFACES["cylinder"]}, (0.7, 0, 0), start=[0.1, 0.2])
    )
    units = {v.name: v.unit for v in model.variables}
    assert [units[f"contact.s[{k}]"] for k in (1, 2)] == ["rad", "m"]
    assert [units[f"contact.s_rate[{k}]"] for k in (1, 2)] == ["rad/s", "m/s"]
    assert [units[f"contact.s_start[{k}]"] for k in (1, 2)] == ["rad", "m"]
