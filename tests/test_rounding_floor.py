"""Tolerances that rounding does not attain: steps do not shrink without use, and it is told once."""

import pytest

from tests.test_loops_in_a_row import scissor_lift

LOOK = ["evaluations", "steps", "estimated_error"]


def run(cells, tolerance, integrator, step, until=2e-3):
    """(evaluations, place of the shoe (m), notices) of a scissor lift's start."""
    lift = scissor_lift(
        cells, tolerance=tolerance, absolute_tolerance=tolerance, integrator=integrator, output=LOOK
    )
    found = lift.simulate(until=until, step=step)
    return found["solver.evaluations"][-1], found["slide.position"][-1], found.notices


@pytest.mark.parametrize("step", [2e-3, 4e-4, 2e-5])
@pytest.mark.parametrize("integrator", ["rk853", "auto"])
def test_steps_do_not_chase_what_rounding_makes_of_the_estimate(integrator, step):
    """A pair of order 5, whose estimate makes little of rounding, tells the place; whole steps, and stages found early."""
    evaluations, place, notices = run(40, 1e-13, integrator, step)
    _, right, _ = run(40, 1e-12, "rk54", 2e-3)
    assert place == pytest.approx(right, abs=2e-13)
    assert evaluations < 400
    assert len(notices) == 1 and "solver.tolerance = 1e-13" in notices[0] and "rounding" in notices[0]


@pytest.mark.parametrize("tolerance", [1e-6, 1e-9])
def test_a_tolerance_that_is_attained_is_not_told_of(tolerance):
    evaluations, place, notices = run(8, tolerance, "rk853", 1e-3)
    _, right, _ = run(8, 1e-13, "rk54", 1e-3)
    assert place == pytest.approx(right, abs=10 * tolerance)
    assert not notices
