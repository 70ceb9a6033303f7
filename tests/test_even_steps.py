"""Communication steps cost about the same: what the step from the front on needs is found early, a little in each."""

import numpy as np
import pytest
from test_between_steps import parallelogram
from test_closed_forms import bars
from test_integrate import instance_of
from test_steppers import oscillator

SCENES = {
    "tree": lambda **solver: instance_of(bars(3, solver=solver)),
    "loop": parallelogram,
    "driven": lambda **solver: oscillator(solver, 100.0),
}
PAIRS = ["rk54", "rk853", "auto"]


def costs(instance, H, n):
    """Evaluations of each of n communication steps."""
    found = []

    for _ in range(n):
        before = instance.d.evaluations[0]
        instance.step(H)
        found.append(instance.d.evaluations[0] - before)

    return np.array(found)


@pytest.mark.parametrize("integrator", PAIRS)
@pytest.mark.parametrize("name", ["tree", "loop"])
def test_no_step_costs_more_than_a_few_evaluations(integrator, name):
    found = costs(SCENES[name](integrator=integrator, tolerance=1e-6), 1e-3, 300)
    assert found[0] < 25
    assert found[1:].max() <= 6


@pytest.mark.parametrize("integrator", PAIRS)
def test_it_is_the_same_motion_and_no_more_work(integrator):
    """Against a run of few communication steps, in which nothing is found early."""
    runs = {n: SCENES["tree"](integrator=integrator, tolerance=1e-8) for n in (4, 2000)}

    for n, instance in runs.items():
        costs(instance, 1.0 / n, n)

    few, many = (instance.d for instance in runs.values())
    assert many.evaluations[0] < 1.3 * few.evaluations[0]
    assert np.abs(many.x - few.x).max() < 1e-6


@pytest.mark.parametrize("integrator", PAIRS)
@pytest.mark.parametrize("name", SCENES)
def test_a_restored_run_goes_on_to_the_same_bits(integrator, name):
    """At each communication point the state alone goes over to another instance, which has none of the stages."""
    first, second = (SCENES[name](integrator=integrator, tolerance=1e-6) for _ in range(2))
    early = 0

    for _ in range(150):
        second.d.state_buffer[:] = first.d.state_buffer
        second.d.work_buffer[:] = 0.0
        early += first.d.early_stages[0] > 1.0
        first.step(2e-3)
        second.step(2e-3)
        assert np.array_equal(first.d.state_buffer, second.d.state_buffer)

    assert early > 10


@pytest.mark.parametrize("integrator", PAIRS)
def test_nothing_is_found_early_that_a_jump_would_undo(integrator):
    """A force that changes every fifth step costs a step to the next point, and one that leads on."""
    instance = SCENES["driven"](integrator=integrator, tolerance=1e-6)
    total = 0

    for k in range(100):
        instance.u[0] = float(k)
        total += costs(instance, 1e-3, 5).sum()

    assert total <= 100 * (13 if integrator == "rk54" else 28) + 10


def test_a_parameter_that_changes_is_heard_at_once():
    """Stages of the old motion are given up: the state is that of a run that reached this point in one step."""
    instance, other = (SCENES["tree"](integrator="rk853", tolerance=1e-10) for _ in range(2))
    costs(instance, 1e-3, 40)
    costs(other, 4e-2, 1)

    for run in (instance, other):
        run.reals[run.model.of_causality("parameter")[0].index] *= 1.5
        run.prepare()

    costs(instance, 1e-3, 40)
    costs(other, 4e-2, 1)
    assert np.abs(instance.d.x - other.d.x).max() < 1e-8
