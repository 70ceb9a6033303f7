"""Singular positions at tight tolerances: what cannot be attained is not chased, and told."""

import numpy as np
import pytest

from benchmarks.problems import PROBLEMS
from mbdfmi.compiler.model import compile_scene
from mbdfmi.run.instance import Instance
from mbdfmi.scene import SceneData

(FOUR_BARS,) = (problem for problem in PROBLEMS if problem.name == "A02_n_four_bar_N2")


def run(tolerance):
    """(evaluations, error of a pin's place (m), notices) of four-bars in a row that pass singular positions, after 10 s."""
    solver = {"tolerance": tolerance, "absolute_tolerance": tolerance}
    instance = Instance(compile_scene(SceneData.model_validate(FOUR_BARS.scene_tables(solver))))

    for _ in range(20):
        instance.step(0.5)

    values = dict(zip((v.name for v in instance.model.of_causality("output")), instance.outputs()))
    place = [values[f"V0.position[{k}]"] for k in (1, 2)]
    column = FOUR_BARS.data["column"]
    (at,) = np.flatnonzero(np.abs(column["t"] - 10.0) < 1e-9)

    # the bar's middle is half as far from its pin on the ground as the point that was published
    error = np.hypot(*(2.0 * np.array(place) - [column["B0_x"][at], column["B0_y"][at]]))
    return instance.d.evaluations[0], error, instance.notices


@pytest.mark.parametrize("tolerance", [1e-11, 1e-12])
def test_a_tighter_tolerance_than_is_attained_costs_little_and_harms_nothing(tolerance):
    evaluations, error, notices = run(1e-9)
    assert error < 1e-7 and not notices
    tight, error, notices = run(tolerance)
    assert error < 3e-8
    assert tight < 4.0 * evaluations
    assert len(notices) == 1 and "singular position" in notices[0]
