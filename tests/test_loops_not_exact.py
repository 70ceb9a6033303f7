"""Loops as CAD writes them, which repeat themselves not quite exactly: they run, or are told how far apart they stay."""

import re
from math import pi

import numpy as np
import pytest
from test_starts import bar, formulations, four_bar, scene_of, start

from mbdfmi.run.instance import SimulationError


@formulations
@pytest.mark.parametrize(
    "tilt, axis, shift", [(7e-6, "x", 0.0), (1e-5, "y", 0.0), (0.0, "x", 1e-5), (5e-5, "x", -2e-5)]
)
def test_a_loop_that_repeats_itself_not_quite_exactly_runs(tilt, axis, shift, formulation):
    """It starts where it was told, moves as the exact one but for the order of what it is off, keeps its energy, and tells."""
    right = scene_of(four_bar(0.0, tolerance=1e-10)).simulate(until=2, step=0.25)
    found = scene_of(four_bar(tilt, shift=shift, axis=axis, tolerance=1e-10), formulation).simulate(
        until=2, step=0.25
    )
    assert found["crank.angle"][0] == pytest.approx(pi / 3, abs=1e-12)
    assert found["crank.angle"] == pytest.approx(right["crank.angle"], abs=10 * (tilt + abs(shift)))
    assert found["total_energy"] == pytest.approx(found["total_energy"][0], abs=1e-7)
    assert not right.notices

    # the rocker's end goes off the plane with the tilt
    told = re.match(
        r"(\w+) does not quite close: its ends stay (\S+) m apart and turned by (\S+) rad", found.notices[0]
    )
    assert told[1] in ("crank", "ab", "c", "bc")
    assert float(told[2]) <= 2 * (1.5 * tilt + abs(shift))
    assert float(told[3]) <= 1.01 * tilt + 1e-12
    assert max(float(told[2]), float(told[3])) > 0.3 * (tilt + abs(shift))


@pytest.mark.long
def test_a_loop_not_quite_exact_keeps_its_energy():
    found = scene_of(four_bar(2e-5, shift=1e-5, tolerance=1e-11)).simulate(until=10, step=0.05)
    assert found["total_energy"] == pytest.approx(found["total_energy"][0], abs=1e-7)


def three_cranks(longer, angle, speed, **solver):
    """Equal cranks of 1 m under a level beam, but for the middle one: where they stand upright other rows are redundant."""
    beam = {"mass": 1, "com": [1, 0, 0], "inertia": [0.01, 0.333, 0.333]}
    ends = [
        ["ground", "a"],
        ["a.end", "beam"],
        ["ground.far", "c"],
        ["ground.mid", "e"],
        ["beam.end", "c.end"],
        ["beam.mid", "e.end"],
    ]
    joints = {f"p{k}": {"revolute": {}, "between": pair} for k, pair in enumerate(ends)}
    joints["p0"] |= {"start": {"angle": angle, "speed": speed}, "output": ["angle"]}
    return {
        "gravity": [0, -9.81, 0],
        "ground": {"marker": {"mid": {"position": [1, 0, 0]}, "far": {"position": [2, 0, 0]}}},
        "body": {
            "a": bar(1.0),
            "c": bar(1.0),
            "e": bar(1.0 + longer),
            "beam": beam | {"marker": {"mid": {"position": [1, 0, 0]}, "end": {"position": [2, 0, 0]}}},
        },
        "joint": joints,
        "output": ["constraint_gap", "total_energy"],
        "solver": solver,
    }


@formulations
@pytest.mark.parametrize("angle, speed, until", [(-0.6, -6.0, 0.32), (-0.3, 0.0, 0.9)])
def test_gaps_of_a_loop_stay_where_other_rows_become_redundant(angle, speed, until, formulation):
    """No row takes the gap that a weak one has made large for its own: all stays within some misfits, at every point."""
    misfit = 1e-5
    right, found = (
        scene_of(three_cranks(longer, angle, speed, tolerance=1e-10), formulation).simulate(
            until=until, step=0.02
        )
        for longer in (0.0, misfit)
    )
    assert np.max(found["constraint_gap"]) < 10 * misfit
    assert found["p0.angle"] == pytest.approx(right["p0.angle"], abs=5 * misfit)
    assert found["total_energy"] == pytest.approx(found["total_energy"][0], abs=2 * misfit)


@pytest.mark.parametrize("tilt", [3e-4, 1e-2])
def test_a_loop_far_from_exact_is_refused(tilt):
    with pytest.raises(
        SimulationError,
        match=r"cannot be closed at (bc|c|ab); the ends at \w+ stay \S+ m apart and turned by",
    ):
        start(four_bar(tilt))


@formulations
def test_a_larger_closing_tolerance_takes_the_gap_as_none(formulation):
    instance, y = start(four_bar(0.0, shift=1e-6, closing_tolerance=1e-5), formulation)
    assert not instance.notices
    assert 1e-7 < y["constraint_gap"] <= 1e-5
    parameters = {"solver.closing_tolerance": 1e-9}
    assert start(four_bar(0.0, shift=1e-6, closing_tolerance=1e-5), formulation, parameters)[0].notices


@pytest.mark.parametrize("length", [0.3, 0.8])
def test_how_far_apart_a_loop_stays_is_told(length):
    """Two bars that are too short for their feet, held at one end: the gap is what is missing, along the line of the feet."""
    scene = {
        "ground": {"marker": {"far": {"position": [2.0, 0, 0]}}},
        "body": {"a": bar(length), "b": bar(0.5)},
        "joint": {
            "a": {"revolute": {}, "between": ["ground", "a"], "start": {"angle": 0.4}},
            "b": {"revolute": {}, "between": ["ground.far", "b"], "start": {"angle": 2.9}},
            "pin": {"revolute": {}, "between": ["a.end", "b.end"]},
        },
    }

    with pytest.raises(SimulationError) as caught:
        start(scene)

    told = re.search(r"stay (\S+) m apart .*off by (\S+) m along x, (\S+) m along y", str(caught.value))
    size, x, y = map(float, told.groups())
    assert "cannot be closed at pin" in str(caught.value)
    assert 1.5 - length - 1e-9 <= size < 3.0
    assert np.hypot(x, y) == pytest.approx(size, rel=1e-4)
    assert re.search(r"a start nearer to where it closes may help: of a, b", str(caught.value))
