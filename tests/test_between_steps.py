"""What is read off between inner steps is as good as what stands at their ends, also where a motion has kinks or is stiff."""

from functools import cache

import numpy as np
import pytest
from test_closed_forms import bars
from test_integrate import instance_of
from test_steppers import oscillator

from mbdfmi.kernels.steppers import gauss, radau, tableaux

EXPLICIT = ["rk853", "rk54", "auto"]


# coefficients


def rooted_trees(order):
    """All rooted trees of `order` nodes, each a sorted tuple of the trees on its root."""
    if order == 1:
        return [()]

    found = set()

    def grow(left, branches):
        if left == 0:
            found.add(tuple(sorted(branches)))

        for size in range(1, left + 1):
            for tree in rooted_trees(size):
                grow(left - size, [*branches, tree])

    grow(order - 1, [])
    return sorted(found)


def size(tree):
    return 1 + sum(size(branch) for branch in tree)


def density(tree):
    return size(tree) * np.prod([density(branch) for branch in tree])


def elementary_weights(tree):
    """Of each stage of the 8(5,3) pair, those of its extension included."""
    value = np.ones(tableaux.N_STAGE)

    for branch in tree:
        value = value * (tableaux.STAGES[1] @ elementary_weights(branch))

    return value


def test_the_gaps_of_an_extension_vanish_to_order_6_and_no_further():
    gaps = tableaux.GAPS / [[47.0], [0.2]]
    misses = [
        max(np.abs(density(tree) * gaps @ elementary_weights(tree)).max() for tree in rooted_trees(order))
        for order in range(1, 8)
    ]
    assert max(misses[:6]) < 1e-12
    assert misses[6] > 1e-4


def test_radau_constants_are_those_of_collocation():
    """A c^k = c^(k+1) / (k + 1) for k < 3, the last node's row integrates t^k to k = 4; A^-1 T = T times the eigenvalues."""
    c = radau.NODES
    k = np.arange(3)
    A = (c[:, None] ** (k + 1) / (k + 1)) @ np.linalg.inv(c[:, None] ** k)
    eigenvalues = np.zeros((3, 3))
    eigenvalues[0, 0] = radau.MU
    eigenvalues[1:, 1:] = [[radau.MU_RE, -radau.MU_IM], [radau.MU_IM, radau.MU_RE]]
    assert [A[2] @ c**j for j in range(5)] == pytest.approx([1 / (j + 1) for j in range(5)], abs=1e-15)
    assert A @ radau.T @ eigenvalues == pytest.approx(radau.T, abs=2e-15)
    assert pytest.approx(np.eye(3), abs=2e-15) == radau.T @ radau.T_INVERSE

    # the estimate vanishes for x' = 1, t: gamma (x' + sum of e_i Z_i / h), Z = c and c^2 / 2
    assert radau.ERROR @ c == pytest.approx(-1, abs=4e-15)
    assert radau.ERROR @ c**2 == pytest.approx(0, abs=4e-15)


def test_gauss_constants_are_those_of_collocation():
    c = gauss.NODES
    assert [gauss.WEIGHTS @ c**k for k in range(8)] == pytest.approx(
        [1 / (k + 1) for k in range(8)], abs=1e-15
    )

    for k in range(4):
        assert gauss.STAGES @ c**k == pytest.approx(c ** (k + 1) / (k + 1), abs=1e-15)
        assert gauss.ONWARD @ c**k == pytest.approx((1 + c) ** k, rel=1e-13)


# kinks


def worst_errors(instance, H, until, error):
    """Largest `error(*x)` at the communication points between inner steps, and at the ends of the inner steps of the same run."""
    between = ends = 0.0

    while instance.time < until:
        instance.step(H)
        ahead = instance.d.ahead[0] > 0.0
        ends = max(ends, error(*(instance.d.front if ahead else instance.d.x)))
        between = max(between, error(*instance.d.x) if ahead else 0.0)

    return between, ends


def clutch(amplitude, **solver):
    """A damper that acts one way, between a shaft that swings and a free one, which keeps the swing's peak speed."""
    axes = [0.01] * 3
    swing = {"harmonic": {"amplitude": amplitude, "frequency": 1}}
    one_way = {"speed": [-10, -0.01, 0, 0.01, 10], "effort": [-1000, -1, 0, 0, 0]}
    peak = 2 * np.pi * amplitude
    return peak, instance_of(
        {
            "name": "clutch",
            "gravity": [0, 0, 0],
            "solver": solver,
            "body": {
                "a": {"mass": 1, "inertia": axes},
                "b": {"mass": 1, "inertia": axes, "output": ["omega"]},
            },
            "joint": {
                "a": {"revolute": {}, "between": ["ground", "a"], "driver": swing},
                "clutch": {
                    "revolute": {},
                    "between": ["a", "b"],
                    "start": {"speed": -peak},
                    "damper": {"table": one_way},
                },
            },
        }
    )


@pytest.mark.parametrize("integrator", EXPLICIT)
@pytest.mark.parametrize("amplitude, tolerance", [(2.0, 1e-8), (1.5, 1e-9), (2.0, 3e-9), (1.0, 1e-6)])
@pytest.mark.parametrize("H", [0.005, 0.0031])
def test_a_one_way_damper_never_gives_more_than_the_peak_speed(integrator, amplitude, tolerance, H):
    """A kink that the extra stages of the 8(5,3) extension met alone came out as eight times the speed."""
    peak, instance = clutch(amplitude, integrator=integrator, tolerance=tolerance)
    speeds = []

    while instance.time < 3.5:
        instance.step(H)
        speeds.append(instance.outputs()[2])

    later = np.array(speeds)[int(0.4 / H) :]
    assert np.abs(later - peak).max() < 2e-4 * peak


def bouncing(**solver):
    """1 kg that flies free between two springy stops 1 m apart; energy is kept but for the force, an input."""
    stop = {"lower": 0.0, "upper": 1.0, "stiffness": 1e5}
    return instance_of(
        {
            "name": "b",
            "gravity": [0, 0, 0],
            "solver": solver,
            "output": ["total_energy"],
            "body": {"a": {"mass": 1, "inertia": [0, 0, 0]}},
            "joint": {
                "j": {
                    "prismatic": {"axis": "x"},
                    "between": ["ground", "a"],
                    "stop": stop,
                    "input": "force",
                    "start": {"position": 0.5, "speed": 2.0},
                }
            },
        }
    )


@pytest.mark.parametrize("integrator", EXPLICIT)
@pytest.mark.parametrize("H", [0.0037, 0.013])
def test_free_flight_between_stops_has_the_speed_it_began_with(integrator, H):
    instance = bouncing(integrator=integrator, tolerance=1e-7)

    def error(x, v):
        return abs(abs(v) - 2.0) if 0.0 < x < 1.0 else 0.0

    between, ends = worst_errors(instance, H, 2.0, error)
    assert between < 10 * max(ends, 1e-6)


@pytest.mark.parametrize("integrator", EXPLICIT)
def test_an_input_that_changes_at_such_a_point_goes_on_from_a_right_state(integrator):
    """A force that is switched now and then: energy changes by its work, force times way, over every communication step."""
    instance = bouncing(integrator=integrator, tolerance=1e-8)
    energy = instance.outputs()[0]

    for k in range(200):
        instance.u[0] = 0.4 * (k // 5 % 3 - 1)
        x = instance.d.x[0]
        instance.step(0.01)
        wanted = energy + instance.u[0] * (instance.d.x[0] - x)
        energy = instance.outputs()[0]
        assert energy == pytest.approx(wanted, abs=1e-5)


def parallelogram(**solver):
    """A parallelogram four-bar that passes its dead points: bars of 1 m, the coupler of 1 m stays parallel to the ground."""
    bar = {
        "mass": 1.0,
        "com": [0.5, 0, 0],
        "inertia": [0.001, 1 / 12, 1 / 12],
        "marker": {"e": {"position": [1, 0, 0]}},
    }
    return instance_of(
        {
            "name": "p",
            "gravity": [0, -9.81, 0],
            "solver": solver,
            "output": ["total_energy"],
            "ground": {"marker": {"r": {"position": [1, 0, 0]}}},
            "body": {"a": bar, "b": bar, "c": bar},
            "joint": {
                "a": {"revolute": {}, "between": ["ground", "a"], "start": {"angle": 1.9, "speed": -9.0}},
                "ab": {"revolute": {}, "between": ["a.e", "b"], "start": {"angle": -1.9}},
                "c": {"revolute": {}, "between": ["ground.r", "c"], "start": {"angle": 1.9}},
                "bc": {"revolute": {}, "between": ["b.e", "c.e"]},
            },
        }
    )


@pytest.mark.parametrize("integrator", EXPLICIT)
@pytest.mark.parametrize("H", [0.003, 0.011])
def test_a_parallelogram_keeps_its_energy_over_its_dead_points(integrator, H):
    instance = parallelogram(integrator=integrator, tolerance=1e-6)
    first = instance.outputs()[0]
    energies = []

    while instance.time < 1.0:
        instance.step(H)
        energies.append(instance.outputs()[0])

    # its kinetic energy goes through some 60 J
    assert np.abs(np.array(energies) - first).max() < 2e-3


# stiffness


@pytest.mark.parametrize("damper", [50.0, 1e3])
@pytest.mark.parametrize("integrator", ["rk853", "rk54"])
def test_at_the_border_of_stability_the_tolerance_is_kept_between_steps(integrator, damper):
    """x'' = -c x' - k x, whose fast root sets the steps: against the exact sum of two exponentials."""
    tolerance = 1e-6
    instance = oscillator({"integrator": integrator, "tolerance": tolerance}, 4.0 * damper, damper)
    root = np.sqrt(damper**2 - 16 * damper)
    fast, slow = -(damper + root) / 2, -8 * damper / (damper + root)
    errors = []

    while instance.time < 60 / damper + 0.3:
        instance.step(0.7 / damper)
        t = instance.time
        x = (slow * np.exp(fast * t) - fast * np.exp(slow * t)) / (slow - fast)
        v = slow * fast * (np.exp(fast * t) - np.exp(slow * t)) / (slow - fast)
        errors.append(np.abs(instance.d.x - [x, v]).max())

    assert max(errors) < 20 * tolerance


@cache
def stiff_chain(integrator, tolerance, n_steps):
    """(states at the ends of equal communication steps over 0.4 s, their number, evaluations) of 6 links with heavy dampers."""
    scene = bars(6, solver={"integrator": integrator, "tolerance": tolerance})

    for joint in scene["joint"].values():
        joint["damper"] = 20.0

    instance = instance_of(scene)
    states = []

    for _ in range(n_steps):
        instance.step(0.4 / n_steps)
        states.append(instance.d.x.copy())

    return np.array(states), instance.d.evaluations[0]


def test_a_damped_chain_is_as_good_between_steps_as_at_their_ends():
    """Its fastest mode sets the steps; both pairs stay within a like part of their tolerance at every point."""
    exact, _ = stiff_chain("radau", 1e-10, 40)
    errors = {name: np.abs(stiff_chain(name, 1e-6, 40)[0] - exact).max() for name in ("rk54", "rk853")}
    assert errors["rk853"] < 10 * max(errors["rk54"], 1e-6)


# cost, and what is told


@pytest.mark.parametrize("tolerance", [1e-5, 1e-8, 1e-11])
def test_reading_off_costs_the_stages_of_the_extension_and_hardly_a_step(tolerance):
    """Three evaluations more than the twelve of a step: 25 %. Steps that the extension alone rejects are few."""
    work = []

    for n in (1, 300):
        instance = instance_of(bars(3, solver={"integrator": "rk853", "tolerance": tolerance}))

        for _ in range(n):
            instance.step(1.0 / n)

        work.append(instance.d.evaluations[0])

    assert work[1] < 1.05 * 1.25 * work[0] + 30


def test_the_estimated_error_counts_what_is_read_off():
    """On an oscillation the extension errs about three times as much as the end of a step is estimated to."""
    told = []

    for n in (1, 1000):
        instance = oscillator({"integrator": "rk853", "tolerance": 1e-8, "output": ["estimated_error"]})

        for _ in range(n):
            instance.step(10.0 / n)

        told.append(instance.outputs()[0] / instance.d.steps[0])

    assert 1.5 * told[0] < told[1] < 10 * told[0]
