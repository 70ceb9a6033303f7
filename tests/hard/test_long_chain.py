"""Long chains: 200 bars let go from horizontal.

Criteria: at first the accelerations from a dense mass matrix in absolute angles; then the motion of the same
equations integrated by another program; then energy.
"""

from functools import cache

import numpy as np
import pytest
from hard import adaptive, bars, fixed, run, solvers
from scipy.integrate import solve_ivp
from scipy.linalg import cho_factor, cho_solve

G = 9.81


@cache
def chain_mass(n):
    """(mass factors (n, n), moments of the weights (n,)): T = sum C_ij cos(a_i - a_j) a_i' a_j' / 2, bars of
    1 m, 1 kg.
    """
    k = np.arange(n)
    C = n - np.maximum.outer(k, k) - 0.5
    C[k, k] = n - k - 2 / 3
    return C, (n - k - 0.5) * G


def chain_accelerations(a, rate):
    """Of the angles to the horizontal (n,)."""
    C, moments = chain_mass(len(a))
    c, s = np.cos(a), np.sin(a)
    cosines = np.outer(c, c) + np.outer(s, s)
    sines = np.outer(s, c) - np.outer(c, s)
    return cho_solve(cho_factor(C * cosines), -(C * sines) @ rate**2 - moments * c)


# tip of 200 bars, x and y in m each 0.1 s, by `chain_motion`
TIP_200 = [
    [200.0, 0.0],
    [199.998648008727, -0.04905],
    [199.9901722600364, -0.1962],
    [199.970396935351, -0.44145],
    [199.9357523321237, -0.7848],
    [199.8829954417348, -1.22625],
]


def chain_motion(n, t):
    """Tip (len(t), 2) by DOP853."""

    def rates(t, x):
        return np.append(x[n:], chain_accelerations(x[:n], x[n:]))

    found = solve_ivp(rates, (0, t[-1]), np.zeros(2 * n), t_eval=t, method="DOP853", rtol=1e-11, atol=1e-12)
    a = found.y[:n]
    return np.column_stack([np.cos(a).sum(axis=0), np.sin(a).sum(axis=0)])


def chain(n, formulation):
    """Bars, with their accelerations as outputs."""
    scene = bars(n, solver={"formulation": formulation})

    for joint in scene["joint"].values():
        joint["output"] = ["acceleration"]

    return scene


@pytest.mark.parametrize("formulation", ["recursive", "embedding", "augmented"])
@pytest.mark.parametrize("n", [10, 200])
def test_a_chain_is_let_go(check, n, formulation):
    """Angles of joints are differences; only the ends feel it at first, so differences of hundreds to 1e-60
    or so.
    """
    y = run(chain(n, formulation), [0.0])
    found = np.array([y[f"j{k}.acceleration"][0] for k in range(1, n + 1)])
    wanted = np.diff(chain_accelerations(np.zeros(n), np.zeros(n)), prepend=0)

    # in joint coordinates the mass matrix of n bars has a condition of the order of n^4
    check(np.abs(found - wanted).max() / np.abs(wanted).max(), 1e-7 if formulation == "embedding" else 1e-11)


CHOICE = [adaptive(1e-9, 1e-6), fixed("rk4", 1e-3, 1e-6), fixed("gauss", 5e-3, 1e-6)]
MANY = solvers(*CHOICE)

# a step of ros2 differentiates all of 400 rates by as many states
EACH = solvers(*CHOICE, fixed("ros2", 1e-3, 1e-2))


@MANY
def test_a_chain_of_200_bars_falls(check, solver, allowed):
    """Its free end: straight down like a stone, and drawn inwards."""
    t = np.linspace(0, 0.5, 6)
    y = run(bars(200), t, solver)
    assert np.abs(y["total_energy"]).max() < 1e4 * allowed
    check(np.abs(y["bar200.end.position"][:, :2] - TIP_200).max(), allowed)


@EACH
def test_a_chain_of_20_bars_falls(check, solver, allowed):
    """For a second."""
    t = np.linspace(0, 1, 11)
    check(np.abs(run(bars(20), t, solver)["bar20.end.position"][:, :2] - chain_motion(20, t)).max(), allowed)


@pytest.mark.long
def test_the_digits_of_200_bars():
    """Half a minute, most of it in threads of the linear algebra."""
    assert np.abs(chain_motion(200, np.linspace(0, 0.5, 6)) - TIP_200).max() < 1e-9


@MANY
def test_energy_of_a_chain_of_200_bars(check, solver, allowed):
    """By the 200 kN m that there are to fall. An implicit step costs most here: less time for these."""
    t = np.linspace(0, 0.5 if solver["integrator"] in ("radau", "gauss") else 2, 11)
    y = run(bars(200), t, solver)
    check(np.abs(y["total_energy"]).max() / (200 * G * 100), allowed)


@pytest.mark.long
@solvers(adaptive(1e-8, 1e-5))
@pytest.mark.parametrize("n", [200, 400])
def test_energy_of_a_long_chain_for_10_s(check, n, solver, allowed):
    y = run(bars(n), np.linspace(0, 10, 101), solver)
    check(np.abs(y["total_energy"]).max() / (n * G * n / 2), allowed)
