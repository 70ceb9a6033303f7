"""Splines without scipy, which takes a second to import: beside scipy's."""

import numpy as np
import pytest
from scenes import assert_near
from scipy.interpolate import CubicSpline, RectBivariateSpline

from mbdfmi.vectors import spline_at, spline_slopes

RNG = np.random.default_rng(2)


def spread(n):
    """(n,) ascending, unevenly."""
    return np.cumsum(RNG.uniform(0.2, 1.5, n))


@pytest.mark.parametrize("n", [2, 3, 4, 5, 40])
@pytest.mark.parametrize("axis", [0, 1])
def test_slopes_are_those_of_a_cubic_spline(n, axis):
    x = spread(n)
    values = RNG.normal(size=(n, 3) if axis == 0 else (3, n)) + 1j * RNG.normal(
        size=(n, 3) if axis == 0 else (3, n)
    )
    assert_near(spline_slopes(x, values, axis), CubicSpline(x, values, axis=axis)(x, 1), 1e-12)


def test_one_point_has_no_slope():
    assert np.array_equal(spline_slopes([1.0], np.ones((1, 2))), np.zeros((1, 2)))


def test_a_table_is_that_of_a_bicubic_spline():
    x, y = spread(9), spread(7)
    table = RNG.normal(size=(9, 7))
    wanted = RectBivariateSpline(x, y, table, kx=3, ky=3, s=0)
    at = np.linspace(x[0], x[-1], 23), np.linspace(y[0], y[-1], 31)
    along = spline_at(x, table, at[0])

    for i in (0, 1):
        for j in (0, 1):
            assert_near(spline_at(y, along[i], at[1], axis=1)[j], wanted(*at, dx=i, dy=j), 1e-11)
