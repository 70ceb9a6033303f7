"""The floating wind turbine: its figures, its motion and its voyage with three foreign FMUs.

References are OpenFAST v5.0.0 with all flexible degrees of freedom off, g = 9.80665 m/s2 and
rho = 1025 kg/m3, unless said otherwise.
"""

import csv
import subprocess
import sys
from math import pi
from pathlib import Path

import numpy as np
import pytest

import mbdfmi

FOLDER = Path(__file__).parents[1] / "models" / "floating_wind_turbine"
SCENE = FOLDER / "floating_wind_turbine.toml"


@pytest.fixture
def parts(monkeypatch):
    """Lets a test import the modules beside the scene."""
    monkeypatch.syspath_prepend(FOLDER)


def changed(change):
    """The scene after change(data) on the contents of its file."""
    data = mbdfmi.load(SCENE).model_dump(exclude_unset=True)
    change(data)
    return mbdfmi.Scene.model_validate(data)


def adrift(pitch_deg=0.0, heave=0.0, speed_rpm=0.0, damper=0.0):
    """The scene without mooring and damping, in a vacuum, released from a displaced position."""

    def change(data):
        del data["force"]["mooring"]
        del data["force"]["radiation"]["linear"]["damping"]
        data["joint"]["float"]["start"] = {"position": [0, 0, heave], "zyx_deg": [0, pitch_deg, 0]}
        data["joint"]["shaft"]["start"] = {"speed_rpm": speed_rpm}
        data["joint"]["shaft"]["damper"] = damper

    return changed(change)


# ---- figures


def cross(r):
    return np.array([[0, -r[2], r[1]], [r[2], 0, -r[0]], [-r[1], r[0], 0]])


def mass_matrix(scene):
    """6x6 mass matrix of all bodies about the origin, every joint at zero: straight from the definitions."""
    poses = {"ground": (np.zeros(3), np.eye(3))}
    total = np.zeros((6, 6))

    for joint in scene.joint.values():
        (parent, p_parent, A_parent), (child, p_child, A_child) = map(scene.marker_pose, joint.between)
        position, axes = poses[parent]
        turned = axes @ A_parent @ A_child.T
        poses[child] = position + axes @ p_parent - turned @ p_child, turned

    for name, body in scene.body.items():
        mass, com, inertia = body.mass_properties()
        position, axes = poses[name]
        S = cross(position + axes @ com)
        total += np.block([[mass * np.eye(3), -mass * S], [mass * S, axes @ inertia @ axes.T - mass * S @ S]])

    return total


def test_mass_properties():
    M = mass_matrix(mbdfmi.load(SCENE))
    mass = M[0, 0]
    com = np.array([M[1, 5], M[2, 3], M[0, 4]]) / mass

    # the published 6,149,460 kg rounds the masses of blades and tower
    assert mass == pytest.approx(6_149_453.193, abs=0.01)
    assert com == pytest.approx([-0.0236090, 0, 7.0058159], abs=1e-6)

    # the reference gives the nacelle yaw inertia alone and the hub none across the shaft: no body can
    # be so; the least that ours need adds 0.93e6 kg m2, 0.02 % of the whole
    reference = np.diag([mass, mass, mass, 4293780035.57, 4278513191.25, 1479494284.77])
    reference[0, 4], reference[1, 3], reference[1, 5], reference[2, 4] = (
        43081936.9,
        -43081936.9,
        -145182.2,
        145182.2,
    )
    reference[3, 5] = 11688340.7
    reference += np.triu(reference, 1).T
    scale = np.sqrt(np.outer(np.diag(reference), np.diag(reference)))

    assert np.abs(M - reference)[:3].max() < 1.0
    assert (np.abs(M - reference) / scale).max() < 2.5e-4


def test_wave_loads(parts):
    from excitation import GRAVITY, WATER, cylinder_excitation

    radius = np.sqrt(1600 / pi)

    # a wave much longer than the barge lifts it as still water would
    surge, heave, pitch = cylinder_excitation(0.02, radius, 4.0, 4000.0)
    assert heave == pytest.approx(WATER * GRAVITY * 1600, rel=0.01)

    # Haskind's relation for a round body in deep water gives the damping of its heave; WAMIT's of the
    # square barge peaks at 6.424e6 N s/m at 0.7 rad/s
    omega = 0.7
    surge, heave, pitch = cylinder_excitation(omega, radius, 4.0, 150.0)
    assert omega**3 * abs(heave) ** 2 / (2 * WATER * GRAVITY**3) == pytest.approx(6.424e6, rel=0.04)


def test_sea_state(parts):
    from sea import Sea

    def elevation(**parameters):
        sea = Sea(instance_name="sea")
        vars(sea).update(parameters)
        values = []
        for k in range(3600):
            sea.do_step(k, 1.0)
            values.append(sea.get_real([4])[0])
        return np.array(values)

    calm = elevation(hs=2.0, tp=8.0)
    assert 4 * calm.std() == pytest.approx(2.0, rel=0.05)

    # the spectrum peaks where it should
    power = np.abs(np.fft.rfft(calm)) ** 2
    smooth = np.convolve(power, np.ones(25), "same")
    assert 3600 / smooth.argmax() == pytest.approx(8.0, rel=0.1)

    assert np.array_equal(calm, elevation(seed=1))
    assert np.abs(np.corrcoef(calm, elevation(seed=2))[0, 1]) < 0.2


def test_rotor_loads(parts):
    from blade_element import RADIUS, rotor_coefficients

    # the reference's 705.7 kN less the rotor's weight along the shaft, and its torque
    force = 1.225 / 2 * 12.0**2 * pi * RADIUS**2
    thrust, torque = rotor_coefficients(12.1 * pi / 30 * RADIUS / 12.0, np.radians(3.83))
    assert force * thrust == pytest.approx(582.8e3, rel=0.03)
    assert force * RADIUS * torque == pytest.approx(4138e3, rel=0.01)

    # NREL/TP-500-38060: the power coefficient peaks with 0.482 at a tip speed ratio of 7.55
    ratio = np.linspace(5, 10, 101)
    power = ratio * rotor_coefficients(ratio, 0.0)[1]
    assert power.max() == pytest.approx(0.482, rel=0.03)
    assert ratio[power.argmax()] == pytest.approx(7.55, abs=0.2)


def test_controller_regions(parts):
    from controller import CUT_IN, OPTIMAL, OPTIMAL_FROM, RATED, REFERENCE, generator_torque

    # NREL/TP-500-38060, table 7-2: 43,093.55 N m at rated speed
    assert generator_torque(REFERENCE, 0.0) == pytest.approx(43_093.55, rel=1e-5)
    assert generator_torque(CUT_IN - 1, 0.0) == 0.0
    assert generator_torque(100.0, 0.0) == OPTIMAL * 100.0**2
    assert generator_torque(150.0, 0.2) * 150.0 == pytest.approx(5_296_610)

    for edge in (CUT_IN, OPTIMAL_FROM, RATED):
        assert generator_torque(edge - 1e-6, 0.0) == pytest.approx(
            generator_torque(edge + 1e-6, 0.0), abs=0.1
        )


# ---- motion in process


def period(time, signal):
    """Mean time between upward passages through the mean."""
    x = signal - signal.mean()
    k = np.flatnonzero((x[:-1] < 0) & (x[1:] >= 0))
    return np.diff(time[k] - x[k] * np.diff(time)[k] / np.diff(x)[k]).mean()


@pytest.mark.parametrize("pitch_deg", [2.0, 5.0])
def test_pitch_period(pitch_deg):
    run = adrift(pitch_deg=pitch_deg).simulate(114, step=0.05)
    assert period(run["time"], run["platform.zyx"][:, 1]) == pytest.approx(11.3744, rel=3e-4)


def test_heave_that_goes_with_pitch():
    """Weight and buoyancy change with the square of the pitch, half of 0.031 m; were the added mass to turn along, half of 0.11 m."""
    heave = adrift(pitch_deg=5.0).simulate(114, step=0.05)["platform.position"][:, 2]
    assert np.ptp(heave) / 2 == pytest.approx(0.0155, abs=2e-4)


def test_heave_period():
    run = adrift(heave=1.0).simulate(78, step=0.05)
    assert period(run["time"], run["platform.position"][:, 2]) == pytest.approx(7.7991, rel=1e-3)


def test_energy_is_kept():
    run = adrift(pitch_deg=5.0, speed_rpm=12.1).simulate(100, step=0.5)
    swing = np.ptp(run["potential_energy"])
    assert np.ptp(run["total_energy"]) < 1e-5 * swing


def test_gyroscopic_yaw():
    # a stiff governor holds the speed of the rotor
    governor, speed = 1e9, 12.1 * pi / 30
    scene = adrift(pitch_deg=5.0, speed_rpm=12.1, damper=governor)
    run = scene.simulate(100, step=0.1, inputs={"shaft.torque": governor * speed})
    yaw, _, roll = np.degrees(run["platform.zyx"]).T

    assert yaw[-1] == pytest.approx(-16.04, rel=0.005)
    assert np.abs(roll).max() == pytest.approx(0.8, abs=0.05)
    assert run["shaft.speed"] == pytest.approx(speed, rel=1e-3)


def test_gyroscopic_yaw_with_a_free_rotor():
    run = adrift(pitch_deg=5.0, speed_rpm=12.1).simulate(100, step=0.1)
    assert np.degrees(run["platform.zyx"][-1, 0]) == pytest.approx(-15.78, rel=0.004)


def test_rest_on_the_moorings():
    run = mbdfmi.load(SCENE).simulate(60, step=0.5)
    assert run["platform.position"][:, 2] == pytest.approx(-0.1275, abs=2e-4)
    assert np.ptp(run["platform.position"], axis=0).max() < 1e-3
    assert np.ptp(run["platform.zyx"], axis=0).max() < 1e-5


def test_pitch_under_thrust(parts):
    from derive import rest

    # the reference's aerodynamic thrust and its platform pitch at 12 m/s
    surge, heave, pitch = rest(582.8e3)
    assert np.degrees(pitch) == pytest.approx(1.540, rel=0.02)

    # rest() agrees with the model: it stays where rest() puts it
    start = {
        "float.position_start[1]": surge,
        "float.position_start[3]": heave,
        "float.euler_parameters_start[2]": np.sin(pitch / 2),
        "float.euler_parameters_start[4]": np.cos(pitch / 2),
        "shaft.speed_start": 0.0,
    }
    thrust = {"hub.force[1]": 582.8e3}
    run = mbdfmi.load(SCENE).simulate(60, step=0.5, inputs=thrust, parameters=start)
    assert run["platform.zyx"][:, 1] == pytest.approx(pitch, rel=0.01)


def test_blades_can_pitch():
    def change(data):
        data["joint"]["shaft"]["start"] = {}
        for k in (1, 2, 3):
            joint = data["joint"][f"pitch_{k}"]
            del joint["fixed"]
            joint |= {"revolute": {"axis": "z"}, "input": "torque", "output": ["angle", "speed"]}

    run = changed(change).simulate(2, step=0.1, inputs={"pitch_2.torque": 1000.0})
    assert run["pitch_2.angle"][-1] == pytest.approx(1000 / 28_578 * 2**2 / 2, rel=1e-3)
    assert np.abs(run["pitch_1.angle"]).max() < 1e-4


# ---- the voyage


def voyage(folder, *options):
    """Columns of run.py's CSV file by name, units cut off."""
    out = folder / "run"
    command = [sys.executable, str(FOLDER / "run.py"), "--out", str(out), *options]
    subprocess.run(command, check=True, capture_output=True, text=True, timeout=600)
    assert out.with_suffix(".png").stat().st_size > 10_000

    with open(out.with_suffix(".csv"), newline="") as file:
        names, *rows = csv.reader(file)
    return dict(zip((name.split(" [")[0] for name in names), np.array(rows, float).T))


def test_voyage(tmp_path):
    run = voyage(tmp_path, "--until", "20")
    time, speed = run["time"], run["turbine.shaft.speed"]
    assert time[-1] == 20 and len(time) == 401

    # the rotor gathers speed as wind and generator tell it, whichever FMU they live in; its inertia
    # about the shaft: three blades, the hub, the generator behind its gear
    torque = run["rotor.torque"] + run["controller.shaft_torque"]
    gained = (39.12e6 + 534.116 * 97**2) * (speed - speed[0])
    given = np.append(0, np.cumsum(np.diff(time) * (torque[1:] + torque[:-1]) / 2))
    assert np.abs(gained - given).max() < 0.05 * np.ptp(given)

    # above rated wind the controller holds the power; the waves are felt
    assert run["controller.power"] == pytest.approx(5e6, rel=0.05)
    assert np.degrees(np.ptp(run["turbine.platform.zyx[2]"])) > 0.3

    # a calm day at the same place: all stays as run.py's steady state says
    run = voyage(tmp_path, "--until", "20", "--hs", "1e-6", "--step", "0.1")
    assert run["turbine.shaft.speed"] == pytest.approx(122.9096 / 97, rel=2e-3)
    assert np.ptp(run["rotor.thrust"]) < 0.02 * run["rotor.thrust"][0]
    assert np.ptp(run["turbine.platform.position[3]"]) < 0.02


@pytest.mark.parametrize("option", [["--step", "0"], ["--hs", "-1"], ["--wind", "80"], ["--gamma", "nan"]])
def test_senseless_options_are_refused(option):
    command = [sys.executable, str(FOLDER / "run.py"), *option]
    done = subprocess.run(command, capture_output=True, text=True, timeout=60)
    assert done.returncode == 2 and option[0] in done.stderr and "Traceback" not in done.stderr
