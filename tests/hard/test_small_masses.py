"""Masses and inertias of next to nothing beside others: parts lighter by 1e9, needles.

Criteria: the motion with the light part left out, which a part of 1e-9 disturbs by 1e-9 at most; for needles,
whose inertia about their own axis is 1e-9 of the others, Euler's equations in another program.
"""

import numpy as np
import pytest
from hard import FORMULATIONS, adaptive, drift, fixed, run, solvers
from scipy.integrate import solve_ivp

LIGHT = 1e-9
G = 9.81

EACH = solvers(
    adaptive(1e-11, 1e-6),
    fixed("rk4", 1e-3, 1e-6),
    fixed("gauss", 1e-2, 1e-6),
    fixed("ros2", 1e-3, 1e-2),
)
formulations = pytest.mark.parametrize("formulation", FORMULATIONS)


def integrated(rates, x0, t):
    """Reference motion (n_x, n) of x' = rates(t, x)."""
    return solve_ivp(rates, (0, t[-1]), x0, t_eval=t, method="DOP853", rtol=1e-12, atol=1e-13).y


def bar(mass, length=1.0):
    """A uniform bar along x with a marker at its end."""
    J = mass * length**2 / 12
    marker = {"end": {"position": [length, 0, 0]}}
    return {"mass": mass, "com": [length / 2, 0, 0], "inertia": [J * 1e-2, J, J], "marker": marker}


# a slider crank with a rod of next to no mass


def slider_crank_error(formulation, light, solver):
    """Crank and slider under weight, the rod a mere distance: M(phi) phi'' + M' phi'^2 / 2 = -V'."""
    r, rod = 0.5, 1.3

    def place(phi):
        """x of the slider, and its first two derivatives by phi."""
        s, c = r * np.sin(phi), r * np.cos(phi)
        root = np.sqrt(rod**2 - s**2)
        first = -s - s * c / root
        second = -c - (c**2 - s**2) / root - (s * c) ** 2 / root**3
        return c + root, first, second

    def rates(t, y):
        phi, rate = y
        _, first, second = place(phi)
        M = 1.0 * r**2 / 3 + 2.0 * first**2
        return [rate, -(2.0 * first * second * rate**2 + G * r / 2 * np.cos(phi)) / M]

    phi, rate0 = 0.4, 6.0
    x, first, _ = place(phi)
    tilt = -np.arcsin(r * np.sin(phi) / rod)
    tilt_rate = -r * np.cos(phi) * rate0 / np.sqrt(rod**2 - (r * np.sin(phi)) ** 2)
    scene = {
        "name": "slider crank",
        "gravity": [0, -G, 0],
        "solver": {"formulation": formulation},
        "body": {"crank": bar(1.0, r), "rod": bar(light, rod), "slider": {"mass": 2.0, "inertia": [1, 1, 1]}},
        "joint": {
            "crank": {
                "revolute": {},
                "between": ["ground", "crank"],
                "start": {"angle": phi, "speed": rate0},
                "output": ["angle", "speed"],
            },
            "rod": {
                "revolute": {},
                "between": ["crank.end", "rod"],
                "start": {"angle": tilt - phi, "speed": tilt_rate - rate0},
            },
            "guide": {
                "prismatic": {"axis": "x"},
                "between": ["ground", "slider"],
                "start": {"position": x, "speed": first * rate0},
                "output": ["position"],
            },
            "pin": {"revolute": {}, "between": ["slider", "rod.end"]},
        },
    }
    t = np.linspace(0, 5, 26)
    y = run(scene, t, solver)
    wanted = integrated(rates, [phi, rate0], t)
    errors = [y["crank.angle"] - wanted[0], y["guide.position"] - place(wanted[0])[0]]
    return max(np.abs(error).max() for error in errors)


@EACH
@formulations
def test_slider_crank_with_a_light_rod(check, formulation, solver, allowed):
    """1e-7 of the slider's mass; the motion without any comes as near as that."""
    check(slider_crank_error(formulation, 1e-7, solver), allowed)


@pytest.mark.parametrize("light", [LIGHT, 1e-11])
@formulations
def test_slider_crank_with_a_rod_lighter_still(formulation, light):
    assert slider_crank_error(formulation, light, {"integrator": "rk853", "tolerance": 1e-9}) < 1e-6


# a double pendulum with one bar of next to no mass


def double_pendulum_rates(m1, m2):
    """x' of (angles from the vertical, speeds) of two bars of 1 m; a mass of 0 is allowed."""

    def rates(t, x):
        a, b, p, q = x
        c, s = np.cos(a - b), np.sin(a - b)
        M = np.array([[m1 / 3 + m2, m2 * c / 2], [m2 * c / 2, m2 / 3]])
        f = np.array(
            [-m2 * s / 2 * q**2 - G * (m1 / 2 + m2) * np.sin(a), m2 * s / 2 * p**2 - G * m2 / 2 * np.sin(b)]
        )

        if m2 == 0:
            first = f[0] / M[0, 0]
            return [p, q, first, 1.5 * (s * p**2 - G * np.sin(b) - c * first)]

        return [p, q, *np.linalg.solve(M, f)]

    return rates


def double_pendulum_error(formulation, which, light, solver):
    """Of both angles, against the other bar and a bar without mass."""
    masses = {"upper": (0.0, 1.0), "lower": (1.0, 0.0)}[which]
    scene = {
        "name": "double pendulum",
        "gravity": [0, -G, 0],
        "solver": {"formulation": formulation},
        "body": {"one": bar(masses[0] or light), "two": bar(masses[1] or light)},
        "joint": {
            "one": {
                "revolute": {},
                "between": ["ground", "one"],
                "start": {"angle": -0.6},
                "output": ["angle"],
            },
            "two": {
                "revolute": {},
                "between": ["one.end", "two"],
                "start": {"angle": 0.3},
                "output": ["angle"],
            },
        },
    }
    t = np.linspace(0, 4, 21)
    y = run(scene, t, solver)
    wanted = integrated(double_pendulum_rates(*masses), [np.pi / 2 - 0.6, np.pi / 2 - 0.3, 0, 0], t)
    errors = [y["one.angle"] + np.pi / 2 - wanted[0], y["one.angle"] + y["two.angle"] + np.pi / 2 - wanted[1]]
    return max(np.abs(error).max() for error in errors)


@EACH
@pytest.mark.parametrize("which", ["upper", "lower"])
@formulations
def test_double_pendulum_with_a_light_bar(check, formulation, which, solver, allowed):
    """The lower one is carried, the upper one only leads."""
    check(double_pendulum_error(formulation, which, LIGHT, solver), allowed)


# needles


def needle(kind, inertia, omega, formulation="auto", **tables):
    """A needle along z on a joint to the ground."""
    body = {"mass": 1.0, "inertia": inertia, "output": ["omega_body", "euler_parameters"]}
    joint = {kind: {}, "between": ["ground", "needle"], "start": {"omega": omega}}
    return {
        "name": "needle",
        "gravity": [0, 0, 0],
        "solver": {"formulation": formulation},
        "body": {"needle": body | tables.pop("body", {})},
        "joint": {"joint": joint},
        "output": ["kinetic_energy", "angular_momentum", "total_energy"],
    } | tables


@EACH
@pytest.mark.parametrize("kind", ["free", "spherical"])
@formulations
def test_a_needle_spins_and_turns(check, kind, formulation, solver, allowed):
    """Symmetric: w3 stays, w1 and w2 turn at (J1 - J3) w3 / J1.

    The spin's acceleration is known to 1e-7 rad/s2 or so: at 1e-11 the steps of the pairs no longer chase that through
    millions of evaluations (docs/theory.md 18.4), which is told, and the error is up to 4e-6.
    """
    t = np.linspace(0, 10, 21)
    y = run(needle(kind, [1, 1, LIGHT], [0.5, -0.2, 3.0], formulation), t, solver)
    w = y["needle.omega_body"]
    turned = 3.0 * (1 - LIGHT) * t
    wanted = np.column_stack(
        [
            0.5 * np.cos(turned) - 0.2 * np.sin(turned),
            -0.5 * np.sin(turned) - 0.2 * np.cos(turned),
            3.0 + 0 * t,
        ]
    )
    assert drift(y["kinetic_energy"]) < max(1e-8, allowed)
    assert np.abs(y["angular_momentum"] - y["angular_momentum"][0]).max() < max(1e-8, allowed)
    check(np.abs(w - wanted).max(), max(allowed, 1e-5))


@EACH
@pytest.mark.parametrize("kind", ["free", "spherical"])
@formulations
def test_a_needle_that_is_not_quite_round(check, kind, formulation, solver, allowed):
    """(J1 - J2) / J3 = -0.5: its spin is driven by a difference that rounding knows to 1e-7 or so."""
    J = np.array([1.0, 1.0 + 0.5 * LIGHT, LIGHT])

    def rates(t, w):
        ratio = (J[0] - J[1]) / J[2]
        return [(J[1] - J[2]) / J[0] * w[1] * w[2], (J[2] - J[0]) / J[1] * w[2] * w[0], ratio * w[0] * w[1]]

    t = np.linspace(0, 10, 21)
    y = run(needle(kind, J.tolist(), [0.5, -0.2, 3.0], formulation), t, solver)
    wanted = integrated(rates, [0.5, -0.2, 3.0], t).T
    check(np.abs(y["needle.omega_body"] - wanted).max(), max(allowed, 1e-4))


@solvers(
    adaptive(1e-8, 1e-6),
    fixed("rk4", 1e-3, 1e-6),
    fixed("gauss", 1e-2, 1e-6),
    fixed("ros2", 1e-3, 1e-2),
)
@formulations
def test_a_needle_hangs_and_swings(check, formulation, solver, allowed):
    """A thin rod hung at its end, let go from the side with a push: a spherical pendulum.

    Its weight's moment rounds to 1e-15 N m, 1e-5 rad/s2 about its own axis: tolerances below 1e-9 ask for
    steps so small that this does not count, and get them, by the million.
    """
    J = 1 / 12
    marker = {"tip": {"position": [0, 0, 1], "output": ["position"]}}
    body = {"com": [0, 0, 0.5], "marker": marker}
    scene = needle("spherical", [J, J, LIGHT * J], [0, 0, 2.0], formulation, gravity=[0, 0, -G], body=body)
    scene["joint"]["joint"]["start"] = {"zyx_deg": [0, 90, 0], "omega": [0, 0, 2.0]}

    # direction e of the rod: e'' = -(e' . e') e + 1.5 (g - (g . e) e) / l
    def rates(t, y):
        e, v = y[:3], y[3:]
        g = np.array([0, 0, -1.5 * G])
        return [*v, *(g - (g @ e + v @ v) * e)]

    t = np.linspace(0, 5, 26)
    y = run(scene, t, solver)
    wanted = integrated(rates, [1, 0, 0, 0, 2.0, 0], t)[:3].T
    assert y.evaluations < 500_000
    check(np.abs(y["needle.tip.position"] - wanted).max(), allowed)
