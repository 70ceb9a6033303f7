"""Derivatives that an FMU finds by its tape, on random scenes of the referee, against differences of high order of its values."""

from collections import Counter

import numpy as np
import pytest
from fmu_host import OK
from test_directional_derivatives import columns, library_of
from test_model_exchange import Solver

from mbdfmi import Scene
from mbdfmi.export.tape import NONE, tape
from tests.referee import generator

LARGEST = 60  # states, more of which take long
MOST = 6  # columns of a scene
STRIDES = (0.1, 0.02, 0.004, 8e-4)  # of the size of a state


def slope(function, h):
    """The derivative at 0 by Richardson's extrapolation of central differences, order 8, and what its last order changed."""
    table = []

    for k in range(4):
        row = [(function(h / 2**k) - function(-h / 2**k)) / (2 * h / 2**k)]
        for order in range(1, k + 1):
            row.append(row[-1] + (row[-1] - table[-1][order - 1]) / (4**order - 1))
        table.append(row)

    return table[3][3], np.abs(table[3][3] - table[3][2])


def best(function, size):
    """The derivative at 0 of each of some functions, of those of some strides that which is known best; and how well it is."""
    found = [slope(function, part * size) for part in STRIDES]
    slopes, doubts = (np.array(rows) for rows in zip(*found))
    # strides that agree with no other are in one bad place
    doubts = doubts + np.min(
        [np.abs(slopes - np.roll(slopes, shift, axis=0)) for shift in range(1, len(STRIDES))], axis=0
    )
    chosen = np.argmin(doubts, axis=0)
    rows = np.arange(slopes.shape[1])
    return slopes[chosen, rows], doubts[chosen, rows]


def judge(seed, folder):
    """(entries that are known to 1e-9, those that differ by more than 1e-8, why the scene was passed over)."""
    try:
        model, library = library_of(Scene.model_validate(generator.draw(seed, size=1 + seed % 8)), folder)
    except Exception as error:  # starts that cannot be: other tests' matter
        return 0, [], type(error).__name__
    if not model.exchanges or not 0 < model.n_x <= LARGEST:
        return 0, [], "no model exchange" if not model.exchanges else "too large"
    if tape(model) is NONE:
        return 0, [], "no tape"

    dice = np.random.default_rng(seed)
    solver = Solver(library)
    rates = [u.variable for u in library.description.derivatives]
    nominal = np.array([float(v.derivative.nominal) for v in rates])
    solver.go(0.0, solver.x + 1e-2 * nominal * dice.normal(size=solver.n))
    solver.call("fmi2EnterEventMode")
    solver.update()  # onto the constraints
    x = solver.x
    wanted = [v.name for v in rates] + [v.name for v in model.of_causality("output")]
    known, wrong = 0, []
    chosen = dice.permutation(solver.n)[:MOST]
    J = columns(solver.fmu, wanted, [rates[k].derivative.name for k in chosen])
    largest = np.abs(J).max(1) + 1e-3 * np.abs(J).max()

    for k, found in zip(chosen, J.T):

        def moved(h, k=k):
            y = x.copy()
            y[k] += h
            solver.go(0.0, y)
            status, values = solver.fmu.get(*wanted)
            return np.array(values) if status == OK else np.full(len(wanted), np.nan)

        size = max(nominal[k], abs(x[k]))
        shown, doubt = best(moved, size)
        # below 1e-14 of their units are zeros and their rounding
        scale = largest + 0.1 * np.abs(moved(0.0)) / size + 1e-6
        sure = doubt < 1e-9 * scale
        known += int(sure.sum())
        wrong += [
            (seed, wanted[i], rates[k].derivative.name, found[i], shown[i], doubt[i], scale[i])
            for i in np.flatnonzero(sure & (np.abs(found - shown) > 1e-8 * scale))
        ]

    solver.fmu.free()
    return known, wrong, None


def hold(seeds, folder, least):
    passed_over, known, wrong = Counter(), 0, []

    for seed in seeds:
        (folder / str(seed)).mkdir()
        n, off, why = judge(seed, folder / str(seed))
        known, wrong = known + n, wrong + off
        passed_over.update([why] if why else [])

    print(f"{known} entries of {len(seeds) - passed_over.total()} scenes; passed over: {dict(passed_over)}")
    assert not wrong, wrong[:10]
    assert known > least, (known, passed_over)


def test_a_few_scenes(tmp_path):
    hold([3000, 3002], tmp_path, 1000)


def test_beside_a_singular_position(tmp_path):
    """A point on a prism of a spline, where the tape does not hold and strides of differences must be short."""
    hold([3104], tmp_path, 100)


@pytest.mark.long
def test_a_hundred_scenes(tmp_path):
    hold(range(3100, 3200), tmp_path, 5000)
