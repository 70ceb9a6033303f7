"""Loss of rank in mid-run: mechanisms that pass a dead centre at which they could change branch.

Without weight their energy is M(phi) phi'^2 / 2, so a crank angle is reached at a time that is an integral;
driven at an even speed, the joint angles have a closed form. Criterion: these, all through, without a change
of branch.
"""

import numpy as np
import pytest
from hard import adaptive, drift, fixed, formulations, run, solvers, try_run
from numpy.polynomial.legendre import leggauss

KITE, LONG = 1.0, 1.7
BAR = {"inertia": [1 / 12, 1 / 12, 1 / 12]}


def slider_crank(phi):
    """Crank and rod of equal length, 1 m: at a right angle the slider stands on the crank's axis and all rank
    is lost.

    The slider is at 2 cos phi, the rod turned by -phi.
    """
    bar = BAR | {"mass": 1.0, "com": [0.5, 0, 0], "marker": {"end": {"position": [1, 0, 0]}}}
    return {
        "name": "slider crank",
        "gravity": [0, 0, 0],
        "body": {"crank": bar, "rod": bar, "slider": {"mass": 2.0, "inertia": [1, 1, 1]}},
        "joint": {
            "crank": {"revolute": {}, "between": ["ground", "crank"], "start": {"angle": phi, "speed": 1.0}},
            "rod": {
                "revolute": {},
                "between": ["crank.end", "rod"],
                "start": {"angle": -2 * phi, "speed": -2.0},
                "output": ["angle", "speed"],
            },
            "guide": {
                "prismatic": {"axis": "x"},
                "between": ["ground", "slider"],
                "start": {"position": 2 * np.cos(phi), "speed": -2 * np.sin(phi)},
                "output": ["position", "speed"],
            },
            "pin": {"revolute": {}, "between": ["slider", "rod.end"]},
        },
    }


def slider_crank_motion(phi):
    """(angle of the rod joint by phi, its derivative, M) by phi."""
    s, c = np.sin(phi), np.cos(phi)
    return -2 * phi, -2 + 0 * phi, 1 / 3 + 1 / 12 + (1.5 * s) ** 2 + (0.5 * c) ** 2 + 2.0 * (2 * s) ** 2


def kite(phi):
    """A four-bar of two equal short sides, ground and crank, and two equal long ones, coupler and rocker.

    At phi = 0 the crank's end lies on the rocker's axis, and both long sides could turn about it alone.
    """
    psi = rocker_angle(phi)[0]
    short = BAR | {"mass": 1.0, "com": [KITE / 2, 0, 0], "marker": {"end": {"position": [KITE, 0, 0]}}}
    long = BAR | {"mass": 1.0, "com": [LONG / 2, 0, 0], "marker": {"end": {"position": [LONG, 0, 0]}}}
    coupler = coupler_angle(phi)[0]
    rates = [1.0, coupler_angle(phi)[1] - 1, rocker_angle(phi)[1]]
    return {
        "name": "kite",
        "gravity": [0, 0, 0],
        "ground": {"marker": {"foot": {"position": [KITE, 0, 0]}}},
        "body": {"crank": short, "coupler": long, "rocker": long},
        "joint": {
            "crank": {
                "revolute": {},
                "between": ["ground", "crank"],
                "start": {"angle": phi, "speed": rates[0]},
            },
            "coupler": {
                "revolute": {},
                "between": ["crank.end", "coupler"],
                "start": {"angle": coupler - phi, "speed": rates[1]},
            },
            "rocker": {
                "revolute": {},
                "between": ["ground.foot", "rocker"],
                "start": {"angle": psi, "speed": rates[2]},
                "output": ["angle", "speed"],
            },
            "pin": {"revolute": {}, "between": ["coupler.end", "rocker.end"]},
        },
    }


def rocker_angle(phi):
    """Rocker angle psi and its derivative by phi.

    The tip lies on the axis of the kite, at phi / 2: that side makes phi / 2 + beta with the ground's
    direction, by the triangle of KITE and LONG.
    """
    half = phi / 2
    beta = np.arcsin(KITE / LONG * np.sin(half))
    rate = KITE / LONG * np.cos(half) / 2 / np.cos(beta)
    return half + beta, 0.5 + rate


def coupler_angle(phi):
    """Coupler angle and its derivative by phi: the rocker's, mirrored at the axis of the kite."""
    psi, rate = rocker_angle(phi)
    return phi - psi, 1 - rate


def kite_motion(phi):
    """(rocker angle, its derivative, M) by phi."""
    psi, psi_rate = rocker_angle(phi)
    gamma, gamma_rate = coupler_angle(phi)

    # velocity of the coupler's middle
    vx = -KITE * np.sin(phi) - LONG / 2 * np.sin(gamma) * gamma_rate
    vy = KITE * np.cos(phi) + LONG / 2 * np.cos(gamma) * gamma_rate
    M = KITE**2 / 4 + 1 / 12 + gamma_rate**2 / 12 + vx**2 + vy**2 + psi_rate**2 * (LONG**2 / 4 + 1 / 12)
    return psi, psi_rate, M


MECHANISMS = {
    "slider crank": (slider_crank, slider_crank_motion, "rod", np.pi / 2),
    "kite": (kite, kite_motion, "rocker", 2 * np.pi),
}


def scene_of(name, phi, formulation="auto", **crank):
    """The scene at a crank angle, with these keys of the crank's joint."""
    scene = MECHANISMS[name][0](phi)
    scene["joint"]["crank"] |= crank
    scene["joint"]["crank"]["output"] = ["angle", "speed"]
    outputs = ["kinetic_energy", "constraint_gap", "constraint_rate"]
    return scene | {"solver": {"formulation": formulation}, "output": outputs}


def duration(motion, start, angles):
    """s, from the start to each of the angles, at first at 1 rad/s, by Gauss' quadrature of small pieces."""
    nodes, weights = leggauss(12)
    M0 = motion(np.array([start]))[2]
    times = []

    for angle in angles:
        ends = np.linspace(start, angle, 400)
        middle, half = 0.5 * (ends[1:] + ends[:-1]), 0.5 * (ends[1:] - ends[:-1])
        phi = middle[:, None] + half[:, None] * nodes
        times.append(np.sum(half[:, None] * weights * np.sqrt(motion(phi)[2] / M0)))

    return np.array(times)


def motion_error(name, y, phi):
    """Largest error of the crank's angle and the follower's angle and speed."""
    _, motion, follower, _ = MECHANISMS[name]
    assert y["constraint_gap"].max() < 1e-10
    assert y["constraint_rate"].max() < 1e-8
    angle, rate, _ = motion(phi)
    speed = y["crank.speed"]
    return max(
        np.abs(y["crank.angle"] - phi).max(),
        np.abs(y[f"{follower}.angle"] - angle).max(),
        np.abs(y[f"{follower}.speed"] - rate * speed).max(),
    )


@solvers(
    adaptive(1e-10, 1e-6),
    fixed("rk4", 1e-3, 1e-6),
    fixed("ros2", 1e-3, 1e-2),
)
@pytest.mark.parametrize("name", MECHANISMS)
def test_free_mechanisms_pass_their_dead_centres(check, name, solver, allowed):
    """Five turns: ten passages of the slider crank, five of the kite."""
    motion = MECHANISMS[name][1]
    phi = np.linspace(0.3, 0.3 + 10 * np.pi, 41)
    y = run(scene_of(name, 0.3), duration(motion, 0.3, phi), solver)
    assert drift(y["kinetic_energy"]) < max(1e-6, allowed)
    check(motion_error(name, y, phi), allowed)


@solvers(fixed("gauss", 5e-3, 1e-6))
@pytest.mark.parametrize("name", MECHANISMS)
def test_free_mechanisms_pass_their_dead_centres_or_stop_there(name, solver, allowed):
    """Stages across a change of rank may not be found."""
    _, motion, _, dead = MECHANISMS[name]
    phi = np.linspace(0.3, 0.3 + 10 * np.pi, 201)
    times = duration(motion, 0.3, phi)
    found = try_run(scene_of(name, 0.3), times, solver)

    if found.stop is not None:
        assert "stages of a step were not found" in str(found.stop)
        reached = np.interp(found.stop.time, times, phi)
        assert abs((reached - dead + np.pi / 2) % np.pi - np.pi / 2) < 0.1

    assert motion_error(name, found, phi[: len(found.t)]) < allowed


@formulations
@pytest.mark.parametrize("driven", [False, True])
@pytest.mark.parametrize("name", MECHANISMS)
def test_mechanisms_are_asked_at_their_dead_centres(check, name, driven, formulation):
    """Communication points on the dead centres themselves, by rounding, and close to them, where steps
    restart.

    What rounding leaves of the direction that has no rank left is amplified: about a thousand times the
    tolerance.
    """
    motion, dead = MECHANISMS[name][1], MECHANISMS[name][3]
    near = dead + np.array([-1e-4, -1e-8, -1e-12, 0, 1e-12, 1e-8, 1e-4])
    phi = np.concatenate([[0.3], near, near + 2 * np.pi, [dead + 8.0]])
    crank = {"driver": {"constant_speed": 1.0}, "start": {"angle": 0.3}} if driven else {}
    scene = scene_of(name, 0.3, formulation, **crank)
    times = phi - 0.3 if driven else duration(motion, 0.3, phi)
    check(motion_error(name, run(scene, times, {"integrator": "rk853", "tolerance": 1e-11}), phi), 1e-5)


@formulations
@pytest.mark.parametrize("name", MECHANISMS)
def test_mechanisms_start_at_their_dead_centres(check, name, formulation):
    """The start velocities say which branch is meant."""
    motion, dead = MECHANISMS[name][1], MECHANISMS[name][3] % (2 * np.pi)
    phi = dead + np.linspace(0, 7, 8)
    scene = scene_of(name, dead, formulation)
    times = duration(motion, dead, phi)
    check(motion_error(name, run(scene, times, {"integrator": "rk853", "tolerance": 1e-11}), phi), 1e-8)
