"""The mechanisms of models/ against closed forms and reference digits: what their comments
promise.
"""

from pathlib import Path

import numpy as np
import pytest
from scipy.spatial.transform import Rotation

import mbdfmi
from benchmarks.problem_files import problem_file

MODELS = Path(__file__).parents[1] / "models"
G = 9.81


def model(name):
    return mbdfmi.load(MODELS / f"{name}.toml")


def test_four_bar_loses_what_its_damper_takes():
    scene = model("four_bar")
    rocker = scene.joint["rocker_pivot"].model_copy(update={"output": ["angle", "speed"]})
    results = scene.model_copy(update={"joint": scene.joint | {"rocker_pivot": rocker}}).simulate(2.0, 1e-3)
    lost = np.trapezoid(0.5 * results["rocker_pivot.speed"] ** 2, results["time"])

    assert results["total_energy"][0] - results["total_energy"][-1] == pytest.approx(lost, rel=1e-5)
    assert results["crank_pivot.angle"][0] == pytest.approx(np.pi / 3, rel=1e-15)
    assert results["crank_pivot.speed"][0] == pytest.approx(2 * np.pi, rel=1e-12)


def test_slider_crank_is_a_slider_crank():
    """The piston's motion in closed form, and the motor's torque by virtual work."""
    results = model("slider_crank").simulate(0.4, 0.005)
    w = 10 * np.pi
    t = results["time"]

    def places(t):
        """Centres of mass of crank, rod and piston as complex numbers, and the rod's angle."""
        pin, tilt = 0.1 * np.exp(1j * w * t), -np.arcsin(0.1 * np.sin(w * t) / 0.3)
        return np.array([pin / 2, pin + 0.12 * np.exp(1j * tilt), pin + 0.3 * np.exp(1j * tilt), tilt])

    def energy(t, h=1e-5):
        here, rate = places(t), (places(t + h) - places(t - h)) / (2 * h)
        return (
            np.array([0.5, 0.3, 1.0, 2.5e-3]) @ np.abs(rate) ** 2 / 2
            + np.array([0.5, 0.3, 1.0, 0]) @ here.imag * G
        )

    power = (energy(t + 1e-4) - energy(t - 1e-4)) / 2e-4

    position = 0.1 * np.cos(w * t) + np.sqrt(0.09 - 0.01 * np.sin(w * t) ** 2)
    np.testing.assert_allclose(results["cylinder.position"], position, atol=1e-8)
    np.testing.assert_allclose(results["main_bearing.effort"] * w, power, atol=2e-2)


def test_slider_crank_driven_by_a_given_motion_instead():
    """The motion of its own driver, given to inverse dynamics, needs the effort of that driver."""
    scene = model("slider_crank")
    results = scene.simulate(0.4, 0.005)
    found = scene.inverse({"main_bearing.angle": lambda t: 10 * np.pi * t}, results["time"])

    np.testing.assert_allclose(found["main_bearing.torque"], results["main_bearing.effort"], atol=1e-9)


def test_bricard_keeps_its_energy_and_turns_inside_out():
    """By symmetry the end of rod 3 swings between heights -1 and -sqrt(3), IFToMM's problem A04."""
    results = model("bricard").simulate(10.0, 0.01)

    assert np.ptp(results["total_energy"]) < 1e-6
    assert results["constraint_gap"].max() < 1e-12
    assert results["rod_3.end.position"][:, 1].min() == pytest.approx(-np.sqrt(3), abs=1e-4)


def test_rolling_disk_does_not_slip_and_keeps_its_energy():
    """Velocity of the rim's lowest point by Euler's formula; energy of the reference run of the
    same start.
    """
    results = model("rolling_disk").simulate(5.0)
    E = results["coin.euler_parameters"]
    A = Rotation.from_quat(E).as_matrix()
    w = np.einsum("kij,kj->ki", A, results["coin.omega_body"])
    rim = np.array([0, 0, 1]) - A[:, 2, 2:] * A[:, :, 2]
    rim /= -np.linalg.norm(rim, axis=1)[:, None]

    np.testing.assert_allclose(results["coin.velocity"] + np.cross(w, rim), 0, atol=1e-8)
    np.testing.assert_allclose((results["coin.position"] + rim)[:, 2], 0, atol=1e-9)
    np.testing.assert_allclose(results["total_energy"], 16.837633970801456, rtol=1e-6)


def test_bead_on_the_spinning_hoop():
    data = problem_file("bead_rotating_hoop")
    expected = np.array(data["values"])
    results = model("spinning_hoop").simulate(5.0, 0.5)

    np.testing.assert_allclose(results["wire.s"][1:], expected[:10, 1], atol=2e-6)
    np.testing.assert_allclose(results["wire.s_rate"][1:], expected[:10, 2], atol=2e-6)


def test_satellite_moves_as_hill_clohessy_and_wiltshire_say():
    """They are linear in distance over radius: 200 m in 6778 km leave 3e-5 of an orbit's 100 m
    unsaid.
    """
    results = model("satellite").simulate(5000.0, 50.0)
    n = model("satellite").ground.motion.orbit.rate
    t = results["time"]
    expected = np.column_stack([100 * np.cos(n * t), -200 * np.sin(n * t), 0.1 / n * np.sin(n * t)])

    np.testing.assert_allclose(results["flight.position"], expected, atol=0.3)
    np.testing.assert_allclose(results["satellite.omega_body"], [[0, 0, n]] * len(t), rtol=1e-9, atol=1e-12)
