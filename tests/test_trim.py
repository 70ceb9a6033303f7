"""Trim against closed forms of steady motions."""

import numpy as np
import pytest

import mbdfmi
from mbdfmi import Scene

G = 9.81


def test_a_conical_pendulum_turns_at_the_speed_of_its_cone():
    """Two hinges, about z and y, a bob: the speed about z that keeps a cone of 40 deg, and the other way round."""
    length, cone = 0.8, np.radians(40)
    scene = Scene(
        name="cone",
        gravity=[0, 0, -G],
        body={"yoke": {"mass": 0.0}, "bob": {"mass": 1.5, "com": [0, 0, -length], "inertia": [0, 0, 0]}},
        joint={
            "spin": {"revolute": {"axis": "z"}, "between": ["ground", "yoke"], "start": {"speed": 3.0}},
            "cone": {"revolute": {"axis": "y"}, "between": ["yoke", "bob"], "start": {"angle": 0.5}},
        },
    )
    speed = np.sqrt(G / (length * np.cos(cone)))
    found = scene.trim(["spin.speed"], {"cone.acceleration": 0.0}, parameters={"cone.angle_start": cone})
    assert abs(found.values["spin.speed_start"] - speed) < 1e-10

    found = scene.trim(["cone.angle"], steady=True, parameters={"spin.speed_start": speed})
    assert abs(abs(found.values["cone.angle_start"]) - cone) < 1e-10
    assert found.unsteady == {}
    run = found.scene.simulate(5.0).poses("bob")
    assert np.ptp(run[0][:, 2]) < 1e-6

    # it swings about its cone with the speed that books have: w^2 (1 + 3 cos^2)
    (mode,) = [mode for mode in found.linearise([], []).modes() if mode.oscillates]
    assert abs(mode.eigenvalue.imag - speed * np.sqrt(1 + 3 * np.cos(cone) ** 2)) < 1e-8


def test_the_torque_that_keeps_a_turbine_at_12_rpm():
    scene = mbdfmi.load(mbdfmi.__path__[0] + "/../models/floating_wind_turbine/floating_wind_turbine.toml")
    scene.joint["shaft"].damper = 2.0e5
    scene.joint["float"] = {"fixed": {}, "between": ["ground", "platform"]}
    found = scene.trim(["shaft.torque"], {"shaft.acceleration": 0.0}, hold={"hub.moment[1]": 1e6})
    speed = 12.1 * np.pi / 30
    assert abs(found.inputs["shaft.torque"] - (2.0e5 * speed - 1e6)) < 1e-6 * 1e6


def test_a_load_that_brings_a_beam_to_an_angle_at_rest():
    bar = {"mass": 2.0, "com": [0.5, 0, 0], "inertia": [0, 0.1, 0.1]}
    joint = {"revolute": {"axis": "y"}, "between": ["ground", "bar"], "spring": {"stiffness": 30.0}}
    scene = Scene(name="bar", gravity=[0, 0, -G], body={"bar": bar}, joint={"hinge": joint})
    found = scene.trim(["bar.mass"], {"hinge.angle": 0.2}, rest=True)
    assert abs(found.parameters["bar.mass"] - 30 * 0.2 / (G * 0.5 * np.cos(0.2))) < 1e-9


def test_what_cannot_be_trimmed_is_told():
    bar = {"mass": 2.0, "com": [0.5, 0, 0], "inertia": [0, 0.1, 0.1]}
    joint = {"revolute": {"axis": "y"}, "between": ["ground", "bar"], "input": "torque"}
    scene = Scene(name="bar", gravity=[0, 0, -G], body={"bar": bar}, joint={"hinge": joint})

    with pytest.raises(
        ValueError, match="hinge.angle comes to 0, not 0.2; .hinge.torque. does nothing for it"
    ):
        scene.trim(["hinge.torque"], {"hinge.angle": 0.2})
    with pytest.raises(KeyError, match="did you mean 'hinge.torque'"):
        scene.trim(["hinge.torqe"], {"hinge.angle": 0.2})
    with pytest.raises(KeyError, match="no output"):
        scene.trim(["hinge.torque"], {"hinge.angel": 0.2})
    with pytest.raises(ValueError, match="no condition"):
        scene.trim(["hinge.torque"])


def test_drives_are_where_they_are_at_each_try():
    """A driven hinge holds at 0.4 rad at 1 s, whatever was looked for before."""
    bar = {
        "mass": 1.0,
        "com": [0, 0, -0.5],
        "inertia": [0, 0.1, 0.1],
        "marker": {"end": {"position": [0, 0, -1]}},
    }
    scene = Scene(
        name="two",
        gravity=[0, 0, -G],
        body={"a": bar, "b": bar},
        joint={
            "motor": {
                "revolute": {"axis": "y"},
                "between": ["ground", "a"],
                "driver": {"polynomial": {"coefficients": [0, 0.4]}},
            },
            "free": {"revolute": {"axis": "y"}, "between": ["a.end", "b"], "input": "torque"},
        },
    )
    found = scene.trim(["free.torque"], {"free.angle": -0.1}, rest=True, time=1.0)
    assert abs(found.inputs["free.torque"] - G * 0.5 * np.sin(0.3)) < 1e-9
