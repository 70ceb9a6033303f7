"""A ground on an elliptic orbit: Kepler's equation, what its keys mean, and a satellite that moves with it stays where it is."""

from itertools import pairwise

import numpy as np
import pytest
from fmu_host import OK, Library
from fmu_host import Instance as FmuInstance
from scenes import assert_near
from scipy.spatial.transform import Rotation

from mbdfmi import Scene
from mbdfmi.compiler.model import compile_scene
from mbdfmi.export import export_fmu
from mbdfmi.kernels.motion import ellipses
from mbdfmi.run.simulate import simulate

MU, A = 3.986e14, 1e7
PERIOD = 2 * np.pi * np.sqrt(A**3 / MU)
ELEMENTS = {"inclination_deg": 50, "node_deg": 20, "periapsis_deg": 70}
POINTING = pytest.mark.parametrize("pointing", [True, False])
formulations = pytest.mark.parametrize("formulation", ["recursive", "embedding", "augmented"])


def satellite(formulation="recursive", **orbit):
    """A satellite that starts where the ground is, as fast as it."""
    given = {"semi_major_axis": A, "eccentricity": 0.3, "mu": MU} | ELEMENTS | orbit
    return {
        "name": "satellite",
        "central_gravity": {"mu": MU},
        "solver": {"integrator": "rk853", "tolerance": 1e-12, "formulation": formulation},
        "ground": {"motion": {"elliptic_orbit": given}},
        "body": {"s": {"mass": 10, "inertia": [1, 2, 3], "output": ["position", "velocity"]}},
        "joint": {"j": {"free": {}, "between": ["ground", "s"], "output": ["position", "velocity"]}},
    }


@pytest.mark.parametrize("e", [0.0, 1e-9, 0.3, 0.6, 0.9, 0.99, 0.999999])
def test_keplers_equation(e):
    """To rounding, of whatever turn; near a periapsis of great eccentricity as well as its condition lets it."""
    for M in [0.0, *10.0 ** np.arange(-15, 0.5), *np.linspace(-20, 20, 41), np.pi, -np.pi, 3 * np.pi]:
        E = ellipses.eccentric_anomaly(M, e)
        assert abs(E - e * np.sin(E) - M) < 1e-15 * max(1.0, abs(M))


def test_a_great_eccentricity_near_its_periapsis():
    """To a part of 1e-14, from the series of E in M at e = 0.9 and M = 1e-5: E = x - e x^3 / 6 (1 - e) + ..."""
    e, x = 0.9, 1e-4
    M = (1 - e) * x + e * (x**3 / 6 - x**5 / 120)
    assert abs(ellipses.eccentric_anomaly(M, e) / x - 1) < 1e-14


@formulations
@POINTING
def test_a_satellite_stays_where_the_ground_is(formulation, pointing):
    """One revolution at eccentricity 0.3: 1e-12 of the orbit, beside which its axes, if they point, would turn."""
    scene = Scene.model_validate(satellite(formulation, mean_anomaly_deg=30, pointing=pointing))
    run = simulate(compile_scene(scene), PERIOD, PERIOD / 8)
    assert_near(run["j.position"] / A, 0.0, 1e-12)
    assert_near(run["j.velocity"] / (2 * np.pi * A / PERIOD), 0.0, 1e-12)


def test_a_satellite_stays_where_the_ground_is_in_an_fmu(tmp_path):
    model = compile_scene(Scene.model_validate(satellite()))
    fmu = FmuInstance(Library(export_fmu(model, tmp_path / "satellite.fmu"), tmp_path / "unpacked"))
    fmu.start()
    names = [v.name for v in model.of_causality("output")]
    at = [k for k, name in enumerate(names) if name.startswith("j.position")]

    for begin, end in pairwise(np.linspace(0.0, PERIOD, 9)):
        assert fmu.step(begin, end - begin) == OK
        assert_near(np.array(fmu.outputs())[at] / A, 0.0, 1e-12)

    fmu.free()


def test_it_is_the_orbit_of_a_free_body():
    """In the inertial frame: the conic of its elements, its energy, and the area that it sweeps."""
    e = 0.3
    run = simulate(compile_scene(Scene.model_validate(satellite(true_anomaly_deg=100))), PERIOD, PERIOD / 40)
    axes = Rotation.from_euler("ZXZ", [20, 50, 70], degrees=True).as_matrix()
    r = run["s.position"] @ axes
    v = run["s.velocity"] @ axes
    distance = np.linalg.norm(r, axis=1)
    nu = np.arctan2(r[:, 1], r[:, 0])
    assert_near(np.degrees(nu[0]), 100, 1e-9)
    assert_near(r[:, 2] / A, 0, 1e-12)
    assert_near(distance * (1 + e * np.cos(nu)) / (A * (1 - e * e)), 1, 1e-12)
    assert_near((np.sum(v * v, axis=1) / 2 - MU / distance) / (MU / A), -0.5, 1e-12)
    assert_near((r[:, 0] * v[:, 1] - r[:, 1] * v[:, 0]) / np.sqrt(MU * A * (1 - e * e)), 1, 1e-12)


@POINTING
def test_rates_are_those_of_positions(pointing):
    """Velocities and accelerations of a place on the ground are the differences of its positions and axes."""
    orbit = {
        "semi_major_axis": 2.0,
        "eccentricity": 0.5,
        "period": 7.0,
        "true_anomaly_deg": -70,
        "pointing": pointing,
    }
    scene = {
        "name": "carried", "gravity": [0, 0, 0], "ground": {"motion": {"elliptic_orbit": orbit | ELEMENTS}},
        "body": {"b": {"mass": 1, "inertia": [1, 1, 1],
                       "output": ["position", "velocity", "acceleration", "euler_parameters", "omega", "alpha"]}},
        "joint": {"j": {"revolute": {}, "between": ["ground", "b"], "driver": {"hold": True}}},
        "solver": {"integrator": "rk4", "step": 0.001},
    }  # fmt: skip
    h = 0.001
    run = simulate(compile_scene(Scene.model_validate(scene)), 4 * h, h)

    def slope(y):
        return (8 * (y[3] - y[1]) - (y[4] - y[0])) / (12 * h)

    assert_near(slope(run["b.position"]), run["b.velocity"][2], 1e-9)
    assert_near(slope(run["b.velocity"]), run["b.acceleration"][2], 1e-9)
    assert_near(slope(run["b.omega"]), run["b.alpha"][2], 1e-8)
    turns = Rotation.from_quat(run["b.euler_parameters"])
    turned = np.array([(turn * turns[2].inv()).as_rotvec() for turn in turns])
    assert_near(slope(turned), run["b.omega"][2], 1e-9)


def test_mean_and_true_anomaly_and_mu_and_period_say_the_same():
    """At e = 0.6 the eccentric anomaly 90 deg has cos nu = -e, M = pi / 2 - e."""
    told = (
        {"mean_anomaly_deg": np.degrees(np.pi / 2 - 0.6)},
        {"true_anomaly_deg": np.degrees(np.arccos(-0.6))},
    )
    places = []

    for anomaly in told:
        for rate in ({"mu": MU}, {"period": PERIOD}):
            data = satellite(eccentricity=0.6, **anomaly)
            orbit = data["ground"]["motion"]["elliptic_orbit"]
            del orbit["mu"]
            orbit |= rate
            run = simulate(compile_scene(Scene.model_validate(data)), 100.0, 50.0)
            places.append(run["s.position"] / A)

    for place in places[1:]:
        assert_near(place, places[0], 1e-13)

    assert_near(np.linalg.norm(places[0][0]), 1.0, 1e-13)


@pytest.mark.parametrize(
    "orbit, told",
    [
        ({"semi_major_axis": 7e6, "eccentricity": 0.1, "mu": 3.986e14}, False),
        ({"semi_major_axis": 7e6, "eccentricity": 0.1, "period": 5828.5}, False),
        ({"semi_major_axis": 7000.0, "eccentricity": 0.1, "mu": 398600.0}, True),
        ({"semi_major_axis": 7e6, "eccentricity": 0.1, "mu": 3e14}, True),
    ],
)
def test_an_orbit_about_another_centre_is_noticed(orbit, told):
    """As one in km about a centre in m."""
    ground = {"motion": {"elliptic_orbit": orbit}}
    body = {"b": {"mass": 1.0, "inertia": [1, 1, 1]}}
    joint = {"j": {"free": {}, "between": ["ground", "b"]}}
    scene = Scene(name="s", central_gravity={"mu": 3.986e14}, ground=ground, body=body, joint=joint)
    assert ["goes round as about a centre of mu" in note for note in scene.notices] == [True] * told
