"""Redundant constraints: Bricard's mechanism moves although its joints leave it no freedom by count.

Criterion: the end of the third rod, known digits; the published one is an energy drift of 1e-3 J in 10 s.
"""

import numpy as np
from hard import FORMULATIONS, adaptive, against, fixed, problem, run, scene_of, solvers
from pytest import mark


@mark.parametrize("formulation", FORMULATIONS)
@solvers(
    adaptive(1e-10, 1e-6),
    fixed("rk4", 1e-3, 1e-6),
    fixed("gauss", 1e-2, 1e-8),
    fixed("ros2", 2e-3, 1e-2),
)
def test_bricard(check, formulation, solver, allowed):
    data = problem("A04_bricard_square")
    outputs = ["total_energy", "constraint_gap", "constraint_rate"]
    scene = scene_of(data, solver={"formulation": formulation}, output=outputs)
    scene["body"]["rod3"]["marker"]["j4"]["output"] = ["position", "velocity"]
    y = run(scene, data["t"], solver)
    assert np.ptp(y["total_energy"]) < 1e-3
    assert y["constraint_gap"].max() < 1e-11
    r = np.column_stack([data["column"][f"P3_{c}"] for c in "xyz"])
    v = np.column_stack([data["column"][f"P3_v{c}"] for c in "xyz"])
    error = max(against(y["rod3.j4.position"], r), against(y["rod3.j4.velocity"], v))
    check(error, allowed)
