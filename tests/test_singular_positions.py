"""Singular positions at tight tolerances: what cannot be attained is not chased, and told."""

import numpy as np
import pytest
from scipy.integrate import solve_ivp

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


def cells(n, tolerance):
    """n parallelogram four-bars in a row, upright, their uprights turning at -1 rad/s: every bar is 1 m and 1 kg."""
    bar = {
        "mass": 1.0,
        "com": [0.5, 0, 0],
        "inertia": [0.001, 1 / 12, 1 / 12],
        "marker": {"e": {"position": [1, 0, 0]}},
    }
    body, joint, ground = {}, {}, {}

    for k in range(n + 1):
        body[f"v{k}"] = bar
        ground[f"g{k}"] = {"position": [k, 0, 0]}
        start = {"angle_deg": 90, "speed": -1.0}
        joint[f"g{k}"] = {"revolute": {}, "between": [f"ground.g{k}", f"v{k}"], "start": start}

    for k in range(n):
        body[f"h{k}"] = bar
        start = {"angle_deg": -90, "speed": 1.0}
        joint[f"a{k}"] = {"revolute": {}, "between": [f"v{k}.e", f"h{k}"], "start": start}
        joint[f"b{k}"] = {"revolute": {}, "between": [f"h{k}.e", f"v{k + 1}.e"]}

    solver = {"tolerance": tolerance, "absolute_tolerance": tolerance}
    scene = {"name": "cells", "gravity": [0, -9.81, 0], "solver": solver, "body": body, "joint": joint}
    return Instance(compile_scene(SceneData.model_validate(scene | {"ground": {"marker": ground}})))


def test_many_cells_cost_and_err_no_more():
    """They have one freedom, the uprights' angle, whose equation is known; couplers go round without turning."""
    n = 10
    inertia, moment = (n + 1) / 3 + n, 9.81 * ((n + 1) / 2 + n)
    exact = solve_ivp(
        lambda t, y: [y[1], -moment / inertia * np.cos(y[0])],
        (0, 10),
        [np.pi / 2, -1],
        method="DOP853",
        rtol=1e-13,
        atol=1e-13,
    ).y[0, -1]
    works = {}

    for tolerance in (1e-9, 1e-12):
        instance = cells(n, tolerance)

        for _ in range(20):
            instance.step(0.5)

        error = (instance.d.q[0] - exact + np.pi) % (2 * np.pi) - np.pi
        assert abs(error) < (2e-7 if tolerance == 1e-9 else 3e-8)
        works[tolerance] = instance.d.evaluations[0]

    assert works[1e-12] < 4.0 * works[1e-9]
    assert len(instance.notices) == 1
