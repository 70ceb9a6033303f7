"""The floating wind turbine with its sea, moorings and rotor inside, beside OpenFAST v5.0.0 with all flexible degrees of freedom off,
g = 9.80665 m/s2 and rho = 1025 kg/m3: free decays, moored, in regular waves, in steady wind.
"""

from pathlib import Path

import numpy as np
import pytest
from scenes import assert_near
from scipy.interpolate import CubicSpline

import mbdfmi

SCENE = Path(__file__).parents[1] / "models" / "floating_wind_turbine" / "turbine_at_sea.toml"
LINES = [f"line_{k}" for k in range(1, 9)]


def turbine(start, waves=None, moored=True, wind=None, drag=False):
    """The scene as the reference runs it: the rotor parked, or held at 12.1 rpm in a wind (m/s)."""
    scene = mbdfmi.load(SCENE)
    data = scene.model_dump(exclude_unset=True)
    data["sea"] = {"density": 1025} | ({"waves": waves} if waves else {})
    data["solver"] = {"tolerance": 1e-8}
    data["joint"]["float"]["start"] = start
    data["force"]["water"]["output"] = []
    shaft = data["joint"]["shaft"]
    shaft.pop("input"), shaft.pop("start", None)
    shaft["driver"] = {"constant_speed_rpm": 12.1 if wind else 0.0}

    for name in LINES if not moored else ():
        del data["force"][name]

    if not drag:
        del data["force"]["drag"]

    if wind:
        data["wind"] = {"steady": {"velocity": [wind, 0, 0]}}
        data["force"]["rotor"] |= {"input": []}
        data["force"]["rotor"]["rotor"]["pitch"] = np.radians(3.83)
    else:
        del data["force"]["rotor"], data["wind"]

    return mbdfmi.Scene.model_validate(data)


def peaks(time, x):
    """[(time, height)] of the maxima of a curve, after its start."""
    curve = CubicSpline(time, x)
    return [(t, float(curve(t))) for t in curve.derivative().roots() if t > time[1] and curve(t, 2) < 0]


def test_pitch_decays_as_the_reference_does():
    """From 5 deg, unmoored: 11.5166 s, zeta 0.00645, peaks 4.813, 4.624, 4.442 deg."""
    run = turbine({"zyx_deg": [0, 5, 0]}, moored=False).simulate(50, 0.05)
    found = peaks(run["time"], np.degrees(run["platform.zyx"][:, 1]))
    assert_near([height for _, height in found[:3]], [4.813, 4.624, 4.442], 0.05)
    assert_near((found[2][0] - found[0][0]) / 2, 11.5166, 0.001 * 11.5166)
    assert_near(np.log(found[0][1] / found[2][1]) / (4 * np.pi), 0.00645, 0.08 * 0.00645)


def test_heave_decays_as_the_reference_does():
    """From 2 m, unmoored: 0.743, 0.182, 0.048 m, 7.345 s; the period is 0.6 % short, as capytaine's added mass is."""
    run = turbine({"position": [0, 0, 2]}, moored=False).simulate(30, 0.05)
    found = peaks(run["time"], run["platform.position"][:, 2])
    assert_near([height for _, height in found[:3]], [0.743, 0.182, 0.048], 0.01)
    assert_near(found[1][0] - found[0][0], 7.345, 0.007 * 7.345)


def test_moored_it_lies_and_swings_as_the_reference_does():
    """On eight catenaries: heave -0.1275 m, pitch period 11.4296 s."""
    run = turbine({"zyx_deg": [0, 5, 0]}).simulate(150, 0.1)
    found = peaks(run["time"], np.degrees(run["platform.zyx"][:, 1]))
    assert_near(run["platform.position"][run["time"] > 60, 2].mean(), -0.1275, 0.0005)
    assert_near((found[3][0] - found[0][0]) / 3, 11.4296, 0.001 * 11.4296)


def test_in_regular_waves_it_answers_as_the_reference_does():
    """T = 10 s, per metre: surge 0.190 m, heave 0.979 m, pitch 3.736 deg. Surge, which nothing damps, swings slowly beside."""
    scene = turbine({"position": [0, 0, -0.1274]}, {"regular": {"height": 2.0, "period": 10.0}})
    run = scene.simulate(1300, 0.2)
    late = run["time"] > 400
    time = run["time"][late]
    window = np.blackman(len(time)) / np.blackman(len(time)).sum()
    angle = np.degrees(run["platform.zyx"][late, 1])
    curves = [run["platform.position"][late, 0], run["platform.position"][late, 2], angle]
    found = [2 * abs((window * (x - x.mean())) @ np.exp(-0.2j * np.pi * time)) for x in curves]
    assert_near(np.array(found) / [0.190, 0.979, 3.736], 1.0, 0.02)


@pytest.mark.long
def test_in_steady_wind_it_leans_as_the_reference_does():
    """12 m/s, 12.1 rpm, blades at 3.83 deg: 582.8 kN, 4138 kN m, 1.540 deg."""
    scene = turbine({"position": [29, 0, -0.25], "zyx_deg": [0, 1.55, 0]}, wind=12.0, drag=True)
    run = scene.simulate(700, 0.2)
    late = run["time"] > 300
    found = [run["rotor.thrust"][late].mean(), run["rotor.torque"][late].mean()]
    found.append(np.degrees(run["platform.zyx"][late, 1].mean()))
    assert_near(np.array(found) / [582.8e3, 4138e3, 1.540], 1.0, 0.03)
