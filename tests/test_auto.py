"""What `auto` chooses, and the methods that are its own: 3(2) where inputs jump, the stabilised one where much decays fast."""

import numpy as np
import pytest
from test_integrate import instance_of
from test_steppers import oscillator

from benchmarks import choice
from mbdfmi.kernels.steppers import tableaux
from mbdfmi.steppers import RK32, RKC, STEPPERS

RADAU = STEPPERS["radau"].number


def chain(n, damper, **solver):
    return instance_of({"name": "c", "solver": solver} | choice.chain(n, damper, driven="base"))


def work(instance):
    """Evaluations, with those that linear systems are worth."""
    return instance.d.evaluations[0] + instance.d.linear_work[0]


# 3(2)


def test_coefficients_of_order_3_and_2():
    """Of both solutions the conditions of order, and the rows' sums."""
    a, c = tableaux.STAGES[2, :4, :4], tableaux.NODES[2, :4]
    b = a[3]
    lower = b - tableaux.ERRORS[2, 0, :4]
    assert a.sum(axis=1) == pytest.approx(c)
    assert [b @ c**k for k in range(3)] == pytest.approx([1, 1 / 2, 1 / 3])
    assert b @ a @ c == pytest.approx(1 / 6)
    assert [lower @ c**k for k in range(2)] == pytest.approx([1, 1 / 2])
    assert abs(lower @ c**2 - 1 / 3) > 0.01


def jumping(integrator, H=1e-3, until=1.0):
    """An oscillator whose force is a staircase of the steps H (s): (instance, its largest error).

    Exact: from step to step by the solution for a constant force.
    """
    instance = oscillator({"integrator": integrator, "tolerance": 1e-6}, 9.0)
    exact = np.array([1.0, 0.0])
    worst = 0.0

    for k in range(round(until / H)):
        instance.u[0] = force = 5.0 * np.sin(4.0 * k * H)
        instance.step(H)
        off = exact - [force / 9.0, 0.0]
        cos, sin = np.cos(3.0 * H), np.sin(3.0 * H)
        exact = np.array([force / 9.0 + cos * off[0] + sin / 3.0 * off[1], cos * off[1] - 3.0 * sin * off[0]])
        worst = max(worst, np.abs(instance.d.x - exact).max())

    return instance, worst


def test_an_input_that_jumps_each_step_costs_four_evaluations_a_step():
    instance, error = jumping("auto")
    assert instance.d.method[0] == RK32.number
    assert instance.d.evaluations[0] < 4.2 * 1000
    assert error < 1e-6


def test_where_steps_are_long_the_lower_order_is_given_up():
    instance, error = jumping("auto", H=0.05, until=5.0)
    other, _ = jumping("rk54", H=0.05, until=5.0)
    assert instance.d.method[0] != RK32.number
    assert instance.d.evaluations[0] < 1.1 * other.d.evaluations[0]
    assert error < 1e-5


# the stabilised method


def stabilised(instance, length):
    """The instance, to go on by the stabilised method whatever it costs."""
    d = instance.d
    d.method[0], d.border_pair[0] = RKC.number, 2.0
    d.border_cost[0] = d.border_work[0] = np.inf
    d.border_span[0] = 1.0
    d.next_step[RKC.number] = length
    return instance


def test_it_keeps_a_tolerance_and_is_of_order_2():
    """Three bars whose dampers decay at 3e4 1/s, at 0.1 s: errors as tolerances, evaluations as their cube root at most."""
    exact = chain(3, 1e3, integrator="radau", tolerance=1e-10)
    runs = [stabilised(chain(3, 1e3, tolerance=10.0**-k), 1e-4) for k in (4, 6, 8)]
    errors = []

    for run in (exact, *runs):
        for _ in range(5):
            run.step(0.02)

        errors.append(np.abs(run.d.x - exact.d.x).max())

    assert all(error < 10.0 * 10.0**-k for error, k in zip(errors[1:], (4, 6, 8)))
    assert all(run.d.method[0] == RKC.number for run in runs)
    steps = [run.d.steps[0] for run in runs]
    assert steps[2] < 1.3 * 100 ** (1 / 3) * steps[1]
    assert runs[1].d.evaluations[0] < 700


def test_a_restored_run_of_it_goes_on_to_the_same_bits():
    first, second = (stabilised(chain(4, 100.0, tolerance=1e-5), 1e-4) for _ in range(2))

    for _ in range(40):
        second.d.state_buffer[:] = first.d.state_buffer
        second.d.work_buffer[:] = 0.0
        first.step(0.01)
        second.step(0.01)
        assert np.array_equal(first.d.state_buffer, second.d.state_buffer)

    assert first.d.method[0] == RKC.number


def test_long_chains_that_decay_cost_as_their_bodies():
    """Evaluations of chains, of which either method of others would cost far more, do not grow with their length."""
    works = {}

    for n in (150, 300):
        instance = chain(n, 1e3, tolerance=1e-6)

        for _ in range(10):
            instance.step(0.02)

        works[n] = work(instance)

    assert works[300] < 1.5 * works[150]
    assert works[300] < 6000
