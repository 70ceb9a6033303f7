"""Fast spin: a top at 1e4 rad/s about its axis, 1600 turns a second.

Criteria: precession without nutation, an exact solution; and the nutation of a top let go, whose period and
advance are elliptic integrals, and whose height is an elliptic function.
"""

import numpy as np
from hard import adaptive, fixed, run, solvers
from mpmath import cos, ellipfun, ellipk, mp, mpf, quad, sin, sqrt

SPIN = 1e4
MASS, LENGTH, G = 1.0, 0.1, 9.81
AXIAL = 5e-3

# about the fixed point
ACROSS = 1.4e-2
WEIGHT = MASS * G * LENGTH
TILT = 1.0


def top(precession):
    """It spins about z, tilted by TILT about x; its axis turns about the vertical at `precession` (rad/s)."""
    spin = SPIN - precession * np.cos(TILT)
    axis = np.array([0, -np.sin(TILT), np.cos(TILT)])
    omega = spin * axis + [0, 0, precession]
    about_com = ACROSS - MASS * LENGTH**2
    tip = {"tip": {"position": [0, 0, 1], "output": ["position"]}}
    return {
        "name": "top",
        "gravity": [0, 0, -G],
        "body": {
            "top": {
                "mass": MASS,
                "com": [0, 0, LENGTH],
                "inertia": [about_com, about_com, AXIAL],
                "marker": tip,
                "output": ["omega_body", "euler_parameters"],
            }
        },
        "joint": {
            "foot": {
                "spherical": {},
                "between": ["ground", "top"],
                "start": {"zyx_rad": [0, 0, TILT], "omega": omega.tolist()},
            }
        },
        "output": ["total_energy", "angular_momentum"],
    }


def axis_at(tilt, turned):
    """Direction of an axis, tilted about x and then turned about the vertical, (n, 3)."""
    return np.column_stack(
        [np.sin(tilt) * np.sin(turned), -np.sin(tilt) * np.cos(turned), np.cos(tilt) + 0 * turned]
    )


SOLVERS = solvers(
    adaptive(1e-11, 1e-6),
    fixed("rk4", 5e-6, 1e-5),
    fixed("gauss", 5e-5, 1e-6),
)


def steady_precession():
    """The slow one of the two speeds with A W^2 cos - C w3 W + m g l = 0."""
    a, b = ACROSS * np.cos(TILT), AXIAL * SPIN
    return 2 * WEIGHT / (b + np.sqrt(b**2 - 4 * a * WEIGHT))


@SOLVERS
def test_steady_precession_of_a_fast_top(check, solver, allowed):
    precession = steady_precession()
    t = np.linspace(0, 1, 11)
    y = run(top(precession), t, solver)
    assert np.abs(y["top.omega_body"][:, 2] / SPIN - 1).max() < allowed
    rolled = (SPIN - precession * np.cos(TILT)) * t
    wanted = euler_parameters(precession * t, rolled)
    found = y["top.euler_parameters"]
    found = found * np.sign(np.sum(found * wanted, axis=1))[:, None]
    orientation = np.abs(found - wanted).max()

    # the phase of the spin is 1e4 rad
    assert orientation < 1e3 * allowed
    check(np.abs(y["top.tip.position"] - axis_at(TILT, precession * t)).max(), allowed)


def euler_parameters(turned, rolled):
    """Of Rz(turned) Rx(TILT) Rz(rolled), (n, 4), scalar last."""
    s, c = np.sin(TILT / 2), np.cos(TILT / 2)
    plus, minus = (turned + rolled) / 2, (turned - rolled) / 2
    return np.column_stack([s * np.cos(minus), s * np.sin(minus), c * np.sin(plus), c * np.cos(plus)])


def nutation():
    """(period s, advance in a period rad, height of the axis by time) of the top let go, in 30 digits.

    With u = cos(tilt): u'^2 = (u0 - u) [p (1 - u^2) - b^2 (u0 - u)], b = C w3 / A, p = 2 m g l / A; its roots
    are u0, where the axis stands still, u1 just below, u2 > 1. The turn is phi' = b (u0 - u) / (1 - u^2).
    """
    mp.dps = 40
    b, p, u0 = mpf(AXIAL) * mpf(SPIN) / mpf(ACROSS), 2 * mpf(WEIGHT) / mpf(ACROSS), cos(mpf(TILT))
    half = b**2 / (2 * p)
    root = sqrt(half**2 - 2 * half * u0 + 1)
    u1, u2 = half - root, half + root
    m = (u0 - u1) / (u2 - u1)
    period = 2 * ellipk(m) * 2 / sqrt(p * (u2 - u1))

    # u = u1 + (u0 - u1) sin^2 a: the end points are no trouble
    def turn(a):
        u = u1 + (u0 - u1) * sin(a) ** 2
        return b * (u0 - u) / (1 - u**2) * 2 / sqrt(p * (u2 - u))

    advance = 2 * quad(turn, [0, mp.pi / 2])

    def height(t):
        sn = ellipfun("sn", sqrt(p * (u2 - u1)) / 2 * mpf(t) + ellipk(m), m=m)
        return float(u1 + (u0 - u1) * sn**2)

    return float(period), float(advance), height


@SOLVERS
def test_nutation_of_a_fast_top(check, solver, allowed):
    """Let go with its axis at rest. The cusps' place counts to 1e-6 of the distance gone."""
    period, advance, height = nutation()
    n = np.arange(0, 601, 50)
    y = run(top(0.0), n * period, solver)
    assert np.abs(y["top.tip.position"] - axis_at(TILT, n * advance)).max() < max(1e-9, allowed)
    assert np.ptp(y["angular_momentum"][:, 2]) < 1e-6 * AXIAL * SPIN

    # the dips are 1e-4 deep: as deep as they should be in between
    t = np.linspace(0, 3, 16)[1:] * period
    y = run(top(0.0), t, solver)
    wanted = np.array([height(s) for s in t])
    check(np.abs(y["top.tip.position"][:, 2] - wanted).max() / (np.cos(TILT) - wanted.min()), 1e2 * allowed)
