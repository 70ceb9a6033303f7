"""End frames on curves and surfaces: shapes and rows, each against differences."""

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
from mbdfmi.run.instance import Instance
from mbdfmi.run.simulate import simulate

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
