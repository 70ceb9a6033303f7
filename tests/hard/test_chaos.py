"""Chaos: a double pendulum, whose neighbouring motions part as e^(1.4 t).

Criterion: the error against known digits grows no faster than the errors of the steps are amplified by the
motion itself, until nothing is left. The amplification is measured: how far runs from neighbouring starts
part.
"""

import json
from functools import cache
from pathlib import Path

import numpy as np
import pytest
from hard import adaptive, bars, fixed, run, solvers

NUDGE = 1e-8


@cache
def digits():
    """(times, tip (n, 2))."""
    data = json.loads((Path(__file__).parent / "double_pendulum_20_s.json").read_text())
    values = np.array(data["values"])
    return values[:, 0], values[:, 1:]


@cache
def amplification():
    """How much of an error of the steps may be seen at each time at most."""
    t = digits()[0]
    best = {"integrator": "rk853", "tolerance": 1e-13}
    parted = np.zeros(len(t))

    for joint in ("j1", "j2"):
        tips = []

        for nudge in (0.0, NUDGE):
            scene = bars(2)
            scene["joint"][joint]["start"] = {"angle": nudge}
            tips.append(run(scene, t, best)["bar2.end.position"])

        parted = np.maximum(parted, np.abs(tips[1] - tips[0]).max(axis=1) / NUDGE)

    # an error of another direction, or made later, may be amplified by more
    return 10 * np.maximum.accumulate(parted)


def test_the_amplification_is_that_of_a_chaotic_motion():
    """Of the order of e^(1.4 t)."""
    t, growth = digits()[0], amplification()
    at = (t >= 5) & (t <= 12)
    assert 0.8 < np.polyfit(t[at], np.log(growth[at]), 1)[0] < 2.0


@solvers(
    adaptive(1e-5, 1e-5),
    [(table, allowed, f"{name} fine") for table, allowed, name in adaptive(1e-8, 1e-8)],
    [(table, allowed, f"{name} finer") for table, allowed, name in adaptive(1e-12, 1e-12)],
    fixed("rk4", 2e-3, 1e-8),
    fixed("gauss", 5e-3, 1e-8),
    fixed("ros2", 1e-3, 1e-4),
)
def test_error_grows_no_faster_than_the_motion_amplifies_it(check, solver, allowed):
    """allowed: what the steps of a second err by. Energy holds, however far the motions have parted."""
    t, tip = digits()
    found = run(bars(2), t, solver)
    error = np.abs(found["bar2.end.position"][:, :2] - tip).max(axis=1)
    bound = allowed * t * amplification()

    # tips on circles of 2 m cannot part further than 4 m
    assert np.all(error < np.where(bound < 1, bound, 4))
    assert np.abs(found["total_energy"]).max() < 1e4 * allowed
    check((error / bound).max(), 1)


@pytest.mark.long
@solvers(adaptive(1e-9, 1e-4))
def test_energy_of_a_chaotic_motion_for_1000_s(check, solver, allowed):
    y = run(bars(2), np.linspace(0, 1000, 2001), solver)
    check(np.abs(y["total_energy"]).max(), allowed)
