"""Small times and large forces: Andrews' squeezer, 30 ms, from a dead point, speeds of 1e3 rad/s.

Criterion: the angles and rates of its seven bodies, known digits (test set for IVP solvers, IFToMM A03).
"""

import numpy as np
import pytest
from hard import adaptive, fixed, problem, run, scene_of, solvers
from test_benchmarks import ANDREWS


@solvers(
    adaptive(1e-10, 1e-6),
    fixed("rk4", 1e-5, 1e-5),
    fixed("gauss", 5e-5, 1e-5),
    fixed("ros2", 1e-5, 1e-1),
)
@pytest.mark.parametrize("name", ["ivp_andrews", "A03_andrews_iftomm"])
def test_squeezer(check, name, solver, allowed):
    data = problem(name)
    y = run(scene_of(data, ["zyx", "omega"]), data["t"], solver)
    errors = []

    for body, parts in ANDREWS.items():
        yaw = sum(data["column"][part] for part in parts)
        rate = sum(data["column"][f"{part}_dot"] for part in parts)
        wrong = (y[f"{body}.zyx"][:, 0] - yaw + np.pi) % (2 * np.pi) - np.pi
        errors += [np.abs(wrong).max(), np.abs(y[f"{body}.omega"][:, 2] - rate).max() / np.abs(rate).max()]

    check(max(errors), allowed)
