"""Waves at members beside sums written anew with numpy: inertia, drag, pressure, stretching, current; added mass; a body that sways."""

import tomllib
from functools import cache

import numpy as np
import pytest
from scenes import assert_near
from scipy.integrate import solve_ivp

from mbdfmi import Scene, SceneError
from mbdfmi.compiler.model import compile_scene
from mbdfmi.compiler.seas import sea_components
from mbdfmi.hydro.spectra import wave_number
from mbdfmi.run.instance import Instance
from mbdfmi.run.simulate import simulate

RHO, G, D = 1025.0, 9.81, 2.0
REGULAR = {"regular": {"height": 1.5, "period": 7.0, "phase_deg": 20}, "direction_deg": 30}
DRAWN = {"jonswap": {"hs": 1.5, "tp": 7.0, "components": 12, "seed": 3}, "direction_deg": -20}


def pile(sea, member, ends=((3.0, -2.0, -12.0), (3.0, -2.0, 4.0)), joint=None, **body):
    """A member between two places of a body that stands, or moves along a joint."""
    keel, deck = ({"position": list(end)} for end in ends)
    return Scene.model_validate(
        {
            "name": "pile",
            "gravity": [0, 0, -G],
            "sea": sea,
            "solver": {"tolerance": 1e-9},
            "body": {
                "pile": {"mass": 4e4, "inertia": [1e6, 1e6, 1e5], "marker": {"keel": keel, "deck": deck}}
                | body
            },
            "joint": {"held": (joint or {"fixed": {}}) | {"between": ["ground", "pile"]}},
            "force": {
                "water": {
                    "member": {"diameter": D, "sections": 60} | member,
                    "between": ["pile.keel", "pile.deck"],
                    "output": ["force", "power"],
                }
            },
        }
    )


@cache
def components(text):
    """(components of the sea of a scene, their wave numbers)."""
    scene = Scene.model_validate(tomllib.loads(text))
    waves = sea_components(scene)
    return waves, wave_number(waves.omega, scene.sea.depth, G)


def water(scene, r, t, stretched=False):
    """(velocity, acceleration, pressure by density, elevation) of the water at r (3,), t: linear waves, term by term."""
    sea = scene.sea
    waves, k = components(scene.to_toml())
    theta = waves.omega * t + waves.phase - k * (np.cos(waves.heading) * r[0] + np.sin(waves.heading) * r[1])
    eta = waves.amplitude @ np.cos(theta)
    eta_rate = -(waves.amplitude * waves.omega) @ np.sin(theta)
    z, sinks = min(r[2], 0.0), 0.0

    if stretched:
        d = sea.depth or 1e9
        z = d * (r[2] - eta) / (d + eta)
        sinks = -d * (d + r[2]) / (d + eta) ** 2 * eta_rate

    if sea.depth:
        C, S = (f(k * (z + sea.depth)) / np.cosh(k * sea.depth) for f in (np.cosh, np.sinh))
    else:
        C = S = np.exp(k * z)

    a, w = G * waves.amplitude * k / waves.omega, waves.omega
    along = a * C * np.cos(theta)
    along_rate = -a * w * C * np.sin(theta) + a * k * S * sinks * np.cos(theta)
    up = -(a * S) @ np.sin(theta)
    up_rate = -(a * w * S) @ np.cos(theta) - (a * k * C * sinks) @ np.sin(theta)
    way = np.array([np.cos(waves.heading), np.sin(waves.heading)])
    pressure = G * (waves.amplitude * C) @ np.cos(theta)
    return np.array([*(way @ along), up]), np.array([*(way @ along_rate), up_rate]), pressure, eta


def told(scene, until):
    """(time, force) of a scene at some times."""
    run = simulate(compile_scene(scene), until, 0.37)
    return run["time"], run["water.force"]


def integral(scene, ends, t, load, top=None, n=4000):
    """Of load(r) (N/m) over the wet part of the way between two ends."""
    start, way = np.array(ends[0]), np.subtract(ends[1], ends[0])
    parts = (np.arange(n) + 0.5) / n
    places = start + parts[:, None] * way
    wet = places[:, 2] <= (0.0 if top is None else top)
    return np.sum([load(r) for r in places[wet]], axis=0) * np.linalg.norm(way) / n


@pytest.mark.parametrize("depth", [None, 25.0])
def test_water_that_accelerates_pushes(depth):
    """rho pi D^2 / 4 (1 + C_A) a across the axis along the wet part; the pressure on the keel; from 0 to the mean surface."""
    sea = {"waves": REGULAR} | ({"depth": depth} if depth else {})
    scene = pile(sea, {"drag": 0.0, "added_mass": 0.8, "axial_added_mass": 0.3})
    time, found = told(scene, 8.0)
    k = float(wave_number(2 * np.pi / 7, depth, G)[()]) if depth else (2 * np.pi / 7) ** 2 / G
    whole = np.tanh(k * depth) if depth else 1.0
    below = np.sinh(k * (depth - 12)) / np.cosh(k * depth) if depth else np.exp(-12 * k)
    theta = 2 * np.pi / 7 * time + np.radians(20) - k * (3 * np.cos(np.pi / 6) - 2 * np.sin(np.pi / 6))
    along = -RHO * np.pi * D**2 / 4 * 1.8 * G * 0.75 * (whole - below) * np.sin(theta)
    size = np.abs(along).max()
    assert_near(found[:, 0], along * np.cos(np.pi / 6), 2e-4 * size)
    assert_near(found[:, 1], along * np.sin(np.pi / 6), 2e-4 * size)

    for t, f in zip(time, found):
        _, a, pressure, _ = water(scene, np.array([3.0, -2.0, -12.0]), t)
        up = RHO * np.pi * D**2 / 4 * pressure + RHO * np.pi * D**3 / 12 * 0.3 * a[2]
        assert_near(f[2], up, 2e-5 * RHO * np.pi * D**2 / 4 * G * 0.75)


@pytest.mark.parametrize("stretching", ["none", "wheeler"])
@pytest.mark.parametrize("waves", [REGULAR, DRAWN], ids=["regular", "drawn"])
def test_a_leaning_member_in_waves_and_current(stretching, waves):
    """Drag and inertia by the midpoints of 4,000 pieces of its length, waves by their sums."""
    ends = ((-4.0, 1.0, -9.0), (2.0, 4.0, 3.0))
    sea = {"depth": 40.0, "waves": waves, "stretching": stretching, "current": {"velocity": [0.4, -0.3, 0]}}
    scene = pile(sea, {"drag": 1.1, "added_mass": 0.9}, ends)
    time, found = told(scene, 4.0)
    axis = np.subtract(ends[1], ends[0]) / np.linalg.norm(np.subtract(ends[1], ends[0]))
    stretched = stretching == "wheeler"
    across = lambda x: x - (x @ axis) * axis

    def load(t):
        def at(r):
            v, a, _, eta = water(scene, r, t, stretched)
            if r[2] > (eta if stretched else 0.0):
                return np.zeros(3)
            u = across(v + [0.4, -0.3, 0.0])
            drag = 0.5 * RHO * D * 1.1 * np.linalg.norm(u) * u
            return drag + RHO * np.pi * D**2 / 4 * 1.9 * across(a)

        return at

    for t, f in list(zip(time, found))[::5]:
        wanted = integral(scene, ends, t, load(t), 3.0, 300)
        wanted += RHO * np.pi * D**2 / 4 * water(scene, np.array(ends[0]), t, stretched)[2] * axis
        assert_near(f, wanted, 0.02 * np.linalg.norm(wanted) if stretched else 0.004 * np.linalg.norm(wanted))


def test_a_pile_sways_as_its_equation_says():
    """(m + rho V C_A) x'' = drag of u - x' + rho V (1 + C_A) a - k x, by scipy."""
    rail = {"prismatic": {"axis": "x"}, "spring": {"stiffness": 3e4}, "output": ["position"]}
    sea = {"depth": 30.0, "waves": REGULAR | {"direction_deg": 0}}
    ends = ((0.0, 0.0, -10.0), (0.0, 0.0, 5.0))
    scene = pile(sea, {"drag": 1.0, "added_mass": 1.0, "sections": 30}, ends, rail)
    run = simulate(compile_scene(scene), 20.0, 0.25)
    z = np.concatenate(
        [[-10 + 0.5 * (j + g) for g in (0.2113248654051871, 0.7886751345948129)] for j in range(20)]
    )
    waves = sea_components(scene)
    k = float(wave_number(waves.omega, 30.0, G)[0])
    C = np.cosh(k * (z + 30)) / np.cosh(30 * k) * G * 0.75 * k / waves.omega[0]

    def rates(t, y):
        theta = waves.omega[0] * t + waves.phase[0]
        u = C * np.cos(theta) - y[1]
        a = -C * waves.omega[0] * np.sin(theta)
        force = np.sum(0.5 * RHO * D * np.abs(u) * u + RHO * np.pi * D**2 / 4 * 2 * a) * 0.25 - 3e4 * y[0]
        return [y[1], force / (4e4 + RHO * np.pi * D**2 / 4 * 10)]

    wanted = solve_ivp(rates, (0, 20), [0, 0], method="DOP853", rtol=1e-11, atol=1e-12, t_eval=run["time"])
    assert_near(run["held.position"], wanted.y[0], 3e-5 * np.abs(wanted.y[0]).max())


def test_what_a_member_takes_along_is_the_mass_of_its_water():
    """Of a leaning pile that starts half wet: across its axis all of it, along it that of the wet disc."""
    ends = ((0.0, 0.0, -6.0), (3.0, 0.0, 2.0))
    axis = np.array([3.0, 0.0, 8.0]) / np.sqrt(73)
    wet = np.sqrt(73) * 6 / 8
    across = RHO * np.pi * D**2 / 4 * 0.7 * wet
    along = RHO * np.pi * D**3 / 12 * 0.4

    for direction in (axis, np.array([axis[2], 0, -axis[0]]), np.array([0.0, 1.0, 0.0])):
        rail = {"prismatic": {"axis": direction.tolist()}, "output": ["acceleration"], "input": "force"}
        member = {"drag": 0.0, "added_mass": 0.7, "axial_added_mass": 0.4}
        instance = Instance(compile_scene(pile({}, member, ends, rail)))
        instance.u[0] = 1000.0
        a = instance.outputs()[0]
        inertia = 4e4 + (along if direction is axis else across)
        weight = -4e4 * G * direction[2]
        assert_near(a, (1000.0 + weight) / inertia, 1e-9)


def test_what_a_member_takes_along_is_that_where_closed_loops_put_it():
    """A pile on a rail that another joint draws 5 m further down: its water is that of one which starts there."""
    rail = {"prismatic": {"axis": "z"}}
    member = {"drag": 0.0, "added_mass": 0.7, "axial_added_mass": 0.4}
    ends = ((0.0, 0.0, -6.0), (3.0, 0.0, 2.0))
    there = pile({}, member, ends, rail | {"start": {"position": -5.0}})
    loop = pile({}, member, ends, rail).model_dump(exclude_unset=True)
    loop["body"]["cart"] = {"mass": 1.0, "inertia": [1, 1, 1]}
    loop["joint"] |= {
        "slide": rail | {"between": ["ground", "cart"], "start": {"position": -5.0}},
        "tow": {"prismatic": {"axis": "x"}, "between": ["cart", "pile"]},
    }
    found, wanted, written = (
        compile_scene(scene).views()[0].six_by_six_added
        for scene in (Scene.model_validate(loop), there, pile({}, member, ends, rail))
    )
    assert_near(found / np.abs(wanted).max(), wanted / np.abs(wanted).max(), 1e-9)
    assert np.abs(written - wanted).max() > 0.1 * np.abs(wanted).max()


def test_power_and_energy_in_waves():
    """The rate of the total energy is what the water takes or gives."""
    rail = {"prismatic": {"axis": "x"}, "spring": {"stiffness": 3e4}, "start": {"speed": 0.5}}
    sea = {"depth": 30.0, "waves": REGULAR}
    data = pile(sea, {"drag": 1.0, "added_mass": 1.0, "sections": 4}, joint=rail).model_dump(
        exclude_unset=True
    )
    data["output"] = ["total_energy", "dissipated_power"]
    run = simulate(compile_scene(Scene.model_validate(data)), 4.0, 0.02)
    weights = np.ones(len(run["time"]))
    weights[1:-1:2], weights[2:-1:2] = 4, 2
    gained = run["total_energy"][-1] - run["total_energy"][0]
    assert_near(weights @ run["dissipated_power"] * 0.02 / 3, -gained, 1e-5 * abs(gained))


def test_a_member_that_waves_pass_by():
    scene = pile({"waves": REGULAR}, {"drag": 1.0, "added_mass": 1.0, "waves": False})
    assert np.all(told(scene, 2.0)[1] == 0.0)


# a member that waves meet where it is


@pytest.mark.parametrize("stretching", ["none", "wheeler"])
def test_waves_meet_a_member_where_it_is(stretching):
    """Towed along, it feels the water of where it has come to: midpoints of 300 pieces, waves by their sums."""
    ends = ((-4.0, 1.0, -9.0), (2.0, 4.0, 3.0))
    sea = {"depth": 40.0, "waves": DRAWN, "stretching": stretching, "current": {"velocity": [0.4, -0.3, 0]}}
    rail = {"prismatic": {"axis": "x"}, "driver": {"constant_speed": 6.0}}
    scene = pile(sea, {"drag": 1.1, "added_mass": 0.9, "position": "now"}, ends, rail)
    time, found = told(scene, 4.0)
    axis = np.subtract(ends[1], ends[0]) / np.linalg.norm(np.subtract(ends[1], ends[0]))
    stretched = stretching == "wheeler"
    across = lambda x: x - (x @ axis) * axis

    for t, f in list(zip(time, found))[::5]:
        moved = tuple(np.add(end, [6.0 * t, 0, 0]) for end in ends)

        def load(r, t=t):
            v, a, _, eta = water(scene, r, t, stretched)
            if r[2] > (eta if stretched else 0.0):
                return np.zeros(3)
            u = across(v + [0.4 - 6.0, -0.3, 0.0])
            return 0.5 * RHO * D * 1.1 * np.linalg.norm(u) * u + RHO * np.pi * D**2 / 4 * 1.9 * across(a)

        wanted = integral(scene, moved, t, load, 3.0, 300)
        wanted += RHO * np.pi * D**2 / 4 * water(scene, moved[0], t, stretched)[2] * axis
        assert_near(f, wanted, 0.02 * np.linalg.norm(wanted) if stretched else 0.004 * np.linalg.norm(wanted))


@pytest.mark.parametrize("stretching", ["none", "wheeler"])
def test_one_that_stands_feels_the_same_either_way(stretching):
    """To the error of the knots, of one that is wet all the time."""
    sea = {"depth": 40.0, "waves": DRAWN, "stretching": stretching}
    member = {"drag": 1.1, "added_mass": 0.9, "axial_added_mass": 0.5, "sections": 6}
    ends = ((3.0, -2.0, -12.0), (3.0, -2.0, -3.0))
    still, here = (told(pile(sea, member | {"position": key}, ends), 6.0)[1] for key in ("mean", "now"))
    assert_near(here, still, 2e-4 * np.abs(still).max())


def test_a_member_towed_against_waves_meets_them_more_often():
    """At omega + k U, in deep water: the load repeats after that period, which is not so where it feels those of its start."""
    omega, U = 0.9, 5.0
    sea = {"waves": {"regular": {"height": 1.0, "period": 2 * np.pi / omega}}}
    rail = {"prismatic": {"axis": "x"}, "driver": {"constant_speed": -U}}
    period = 2 * np.pi / (omega + omega**2 / G * U)

    for position, same in (("now", True), ("mean", False)):
        scene = pile(sea, {"drag": 1.0, "added_mass": 1.0, "position": position}, joint=rail)
        force = simulate(compile_scene(scene), 3 * period, period / 12)["water.force"][:, 0]
        off = np.abs(force[12:25] - force[24:37]).max() / np.ptp(force)
        assert (off < 1e-9) if same else (off > 0.1)


def test_position_is_about_waves():
    with pytest.raises(SceneError, match="position is about waves"):
        pile({"waves": REGULAR}, {"waves": False, "position": "now"})
