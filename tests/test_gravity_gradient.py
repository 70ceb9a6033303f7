"""The gradient of central gravity on bodies by their inertia: librations of satellites, energy, two points on a rod."""

import numpy as np
import pytest
from scenes import assert_near, evaluate
from scipy.special import ellipj, ellipk
from test_powers import named_outputs, rates

from mbdfmi import Scene, SceneError
from mbdfmi.compiler.model import compile_scene
from mbdfmi.kernels.forces import central_gravity, gravity_gradient
from mbdfmi.kernels.language import INTERPRETED
from mbdfmi.kernels.motion import kinematics
from mbdfmi.run.instance import Instance

FORMULATIONS = ("recursive", "embedding", "augmented")


def satellite(body, radius, rate, pitch=0.0, formulation="recursive", **start):
    """A body on a circular orbit in the plane z = 0, now at (radius, 0, 0), turned by `pitch` (rad) from the radius, turning along."""
    start = {
        "position": [radius, 0, 0],
        "velocity": [0, radius * rate, 0],
        "zyx_rad": [pitch, 0, 0],
        "omega": [0, 0, rate],
    } | start
    return {
        "name": "satellite",
        "central_gravity": {"mu": 1.0, "gradient": True},
        "body": {"sat": {"mass": 2.0, "output": ["position", "zyx", "omega", "alpha"]} | body},
        "joint": {"free": {"free": {}, "between": ["ground", "sat"], "start": start}},
        "output": ["kinetic_energy", "gravity_energy", "total_energy", "angular_momentum"],
        "solver": {"tolerance": 1e-13, "absolute_tolerance": 1e-14, "formulation": formulation},
    }


def outputs_at(data, time):
    """Outputs by name, arrays as one."""
    instance = Instance(compile_scene(Scene.model_validate(data)))
    instance.step(time)
    return named_outputs(instance)


@pytest.mark.parametrize("formulation", FORMULATIONS)
def test_the_pitch_of_a_satellite_librates(formulation):
    """sin(pitch) = sin(p0) sn(K - w t; sin(p0)^2), w^2 = 3 n^2 (Ib - Ia) / Ic; Ia about the radius, Ib along the track, Ic about
    the orbit's normal: of small pitches w is the frequency."""
    small, p0, t = 1e-10, 0.4, 1.7
    Ia, Ib, Ic = 0.3, 0.9, 1.0
    y = outputs_at(satellite({"inertia": [small * Ia, small * Ib, small * Ic]}, 1.0, 1.0, p0, formulation), t)
    k2 = np.sin(p0) ** 2
    sn, *_ = ellipj(ellipk(k2) - np.sqrt(3 * (Ib - Ia) / Ic) * t, k2)

    # the orbit feels it too, by small
    assert_near(np.sin(y["sat.zyx"][0] - t), np.sin(p0) * sn, 1e-10)


def test_a_satellite_on_end_keeps_its_orbit():
    """With Ia about the radius: rate^2 = mu / r^3 (1 + 3 (tr I - 3 Ia) / (2 m r^2)), for large bodies too."""
    inertia, mass, radius, t = np.array([0.02, 0.05, 0.06]), 2.0, 1.3, 2.0
    rate = np.sqrt((1 + 1.5 * (inertia.sum() - 3 * inertia[0]) / (mass * radius**2)) / radius**3)
    y = outputs_at(satellite({"inertia": inertia.tolist()}, radius, rate), t)
    assert_near(y["sat.position"], radius * np.array([np.cos(rate * t), np.sin(rate * t), 0]), 1e-10)
    assert_near(y["sat.zyx"], [rate * t, 0, 0], 1e-10)


def tumbling(formulation="recursive"):
    """A satellite with an arm, off its frame's origin, that tumbles on an ellipse."""
    body = {"inertia": [0.02, 0.05, 0.06, 0.004, -0.003, 0.002], "com": [0.02, -0.03, 0.05]}
    data = satellite(body, 1.2, 0.7, 0.3, formulation, omega=[0.5, -0.4, 0.9])
    data["body"]["arm"] = {"mass": 0.5, "inertia": [0.01, 0.04, 0.04], "com": [0.1, 0, 0]}
    data["joint"]["hinge"] = {
        "revolute": {"axis": [0, 1, 1]},
        "between": ["sat", "arm"],
        "start": {"angle": 0.4, "speed": -0.6},
    }
    return data


@pytest.mark.parametrize("formulation", FORMULATIONS)
def test_energy_and_momentum_about_the_centre_are_kept(formulation):
    data = tumbling(formulation)
    first, last = outputs_at(data, 1e-9), outputs_at(data, 1.0)
    assert abs(last["kinetic_energy"] - first["kinetic_energy"]) > 1e-3
    assert_near(last["total_energy"], first["total_energy"], 1e-11)
    assert_near(last["angular_momentum"], first["angular_momentum"], 1e-11)


@pytest.mark.skipif(not INTERPRETED, reason="calls functions that are compiled as parts of others alone")
def test_power_is_the_rate_of_the_energy():
    """Of the field and of its gradient, each by itself."""
    instance = Instance(compile_scene(Scene.model_validate(tumbling())))
    instance.step(0.3)
    m, d = instance.m, instance.d
    elements = {"field": central_gravity, "gradient": gravity_gradient}

    def energies(_):
        kinematics.kinematics(m, d)
        return {name: element.energy(m, d) for name, element in elements.items()}

    change = rates(instance, list(elements), values_of=energies)
    evaluate(instance)

    for name, element in elements.items():
        assert abs(element.power(m, d)) > 1e-4
        assert_near(element.power(m, d), -change[name], 1e-10)


def test_two_points_on_a_rod_feel_it_without():
    """A body of two point masses has a gradient of its own: to the fourth order of its size the same."""
    half, tilt, mass = 1e-3, 0.7, 2.0
    across = mass * half**2
    y = outputs_at(satellite({"inertia": [1e-12, across, across]}, 1.0, 1.0, tilt), 0.0)
    arm = half * np.array([np.cos(tilt), np.sin(tilt), 0])
    ends = [np.array([1.0, 0, 0]) + side * arm for side in (1, -1)]
    pulls = [-0.5 * mass * r / np.linalg.norm(r) ** 3 for r in ends]
    moment = np.cross(arm, pulls[0] - pulls[1])[2]
    assert_near(y["sat.alpha"][2] * across, moment, 1e-5 * abs(moment))


def test_without_it_all_weight_acts_at_the_centre_of_mass():
    data = tumbling()
    data["central_gravity"]["gradient"] = False
    plain = outputs_at(data, 0.2)
    data["central_gravity"].pop("gradient")
    assert outputs_at(data, 0.2)["total_energy"] == plain["total_energy"]
    assert abs(outputs_at(tumbling(), 0.2)["total_energy"] - plain["total_energy"]) > 1e-3


def test_a_gradient_that_is_no_yes_or_no_is_told():
    data = tumbling()
    data["central_gravity"]["gradient"] = 1.5

    with pytest.raises(SceneError, match=r"central_gravity.*gradient"):
        Scene.model_validate(data)
