"""The long runs, with few periods: figures, table, picture, and what is to be expected of them."""

import json

import numpy as np
import pytest

from benchmarks.long_run import STEPPERS, run_long
from benchmarks.orbits import ORBITS
from mbdfmi import Scene
from mbdfmi.compiler.model import compile_scene
from mbdfmi.run.instance import Instance

PERIODS = 30


@pytest.fixture(scope="module")
def report(tmp_path_factory):
    told = []
    out = tmp_path_factory.mktemp("long")
    found = run_long(PERIODS, lambda part, text: told.append((part, text)))
    found.save(out)
    return found, out, told


@pytest.mark.parametrize("orbit", ORBITS)
def test_orbits_come_back(orbit):
    """The closed form of the period, the advance and the constants, at a tight tolerance."""
    orbit = orbit()
    solver = {"integrator": "rk853", "tolerance": 1e-13}
    instance = Instance(compile_scene(Scene.model_validate(orbit.scene | {"solver": solver})))
    outputs = [v.name for v in instance.model.of_causality("output")]
    state = [outputs.index(name) for name in orbit.state]
    first = instance.outputs().copy()
    assert orbit.error(0, first[state]) < 1e-15

    for n in (1, 2, 3):
        instance.step(orbit.period)
        y = instance.outputs()

        # the tumbling body passes close to its unstable axis six times
        assert orbit.error(n, y[state]) < 2e-9

    for names, size in orbit.constants.values():
        places = [outputs.index(name) for name in names]
        assert np.abs(y[places] - first[places]).max() < 1e-11 * size

    # and in between it is elsewhere
    instance.step(0.37 * orbit.period)
    assert orbit.error(3, instance.outputs()[state]) > 1e-2


def test_all_steppers_that_there_are_run(report):
    rows = report[0].rows
    steppers = list(STEPPERS)
    assert [row["stepper"] for row in rows] == steppers * len(ORBITS)

    for row in rows:
        assert row["stopped"] is None
        assert row["periods"][0] == 1
        assert row["periods"][-1] == PERIODS
        assert all(len(values) == len(row["periods"]) for values in (*row["drift"].values(), row["error"]))
        assert row["steps"] > 0
        assert row["evaluations"] > row["steps"]
        assert max(row["drift"]["energy"]) < (0.1 if row["integrator"] == "ros2" else 1e-3)
        assert max(row["drift"]["angular momentum"]) < (0.1 if row["integrator"] == "ros2" else 1e-3)


def test_explicit_steppers_drift_in_proportion_to_time(report):
    """An error in one direction at each step; the phase's grows with its square."""
    row = next(
        row for row in report[0].rows if (row["orbit"], row["stepper"]) == ("planets on a spring", "rk54")
    )
    assert 0.7 < row["growth"]["energy"] < 1.3
    assert 0.7 < row["growth"]["angular momentum"] < 1.3
    assert 1.4 < row["growth"]["state"] < 2.5


def test_tighter_tolerances_drift_less(report):
    rows = {(row["orbit"], row["stepper"]): row for row in report[0].rows}

    for orbit in {row["orbit"] for row in report[0].rows}:
        coarse, fine = (rows[orbit, name]["drift"]["energy"][-1] for name in ("rk853", "rk853 fine"))
        assert fine < 0.1 * coarse


def test_report_is_written_and_shown(report):
    rich = pytest.importorskip("rich.console")
    found, out, told = report
    assert json.loads((out / "long_run.json").read_text()) == found.as_dict()
    console = rich.Console(record=True, width=150)
    console.print(found)
    text = console.export_text()

    for orbit in ORBITS:
        assert orbit().title in text

    parts = [part for part, _ in told]
    assert parts == sorted(parts)
    assert told[-1] == (1.0, "done")
    pytest.importorskip("matplotlib")
    assert (out / "long_run.png").stat().st_size > 10_000


def test_a_stepper_that_fails_says_when(monkeypatch):
    """Steps of several radians: what fails is told, in the table too, and the picture is made of the rest."""
    monkeypatch.setitem(STEPPERS, "rk4", ("rk4", {"step": 5.0}))
    found = run_long(1000, steppers=["rk4"])
    failed = [row for row in found.rows if row["stopped"]]
    assert failed

    for row in failed:
        assert "no longer finite (after " in row["stopped"].replace(
            "; check inputs and parameters for huge values", ""
        )
        assert len(row["periods"]) == len(row["error"])

    found.figure()
    found.__rich__()
