"""Products and lengths whose digits do not depend on the processor, as those of BLAS do: a model is the same
everywhere.
"""

import math

import numpy as np


def dot(*factors):
    """The matrix product of arrays (a vector comes last), each sum from the left."""
    *others, product = [np.asarray(factor, float) for factor in factors]

    for factor in reversed(others):
        if factor.shape == (3, 3) and product.shape in ((3,), (3, 3)):
            product = _spatial(factor.tolist(), product)
            continue

        terms = factor * product if product.ndim == 1 else factor[..., None] * product
        product = terms.sum(-1) if product.ndim == 1 else terms.sum(-2)

    return product


def _spatial(rows, product):
    """The same of three rows with a vector or a matrix (3, 3), in half the time; sums begin at 0."""
    x, y, z = product.tolist()

    if product.ndim == 1:
        return np.array([0.0 + a * x + b * y + c * z for a, b, c in rows])

    return np.array([[0.0 + a * p + b * q + c * r for p, q, r in zip(x, y, z)] for a, b, c in rows])


def cross(a, b):
    """The cross product (3,) of two vectors, to the bit that of numpy, which takes ten times as long."""
    (a0, a1, a2), (b0, b1, b2) = (map(float, vector) for vector in (a, b))
    return np.array([a1 * b2 - a2 * b1, a2 * b0 - a0 * b2, a0 * b1 - a1 * b0])


def norm(vector):
    """Length of a vector."""
    return math.sqrt(sum(x * x for x in map(float, vector)))


def solve_banded(band, diagonals, right):
    """x of A x = right, for A with `band` diagonals on each side, given as scipy's solve_banded takes them.

    By elimination with row exchanges.
    """
    n = len(right)
    width = 2 * band + 1
    rows = np.zeros((n + band + 1, width))

    for k in range(width):
        at = np.arange(max(0, band - k), min(n, n + band - k))
        rows[at, k] = diagonals[width - 1 - k, at + k - band]

    # rows j to j + band, their columns from j on; those of the first rows begin to the left of column 0
    window = np.zeros((band + 1, width))
    for i in range(min(band + 1, n)):
        window[i, : band + i + 1] = rows[i, band - i :]

    x = np.append(right, np.zeros(width))
    upper = np.empty((n, width))

    for j in range(n):
        pivot = int(np.abs(window[:, 0]).argmax())
        window[[0, pivot]] = window[[pivot, 0]]
        x[[j, j + pivot]] = x[[j + pivot, j]]
        upper[j] = window[0]
        factors = window[1:, 0] / window[0, 0]
        x[j + 1 : j + band + 1] -= factors * x[j]
        window[:-1, :-1] = window[1:, 1:] - factors[:, None] * window[0, 1:]
        window[:-1, -1] = 0.0
        window[-1] = rows[j + band + 1]

    for j in range(n - 1, -1, -1):
        x[j] = (x[j] - (upper[j, 1:] * x[j + 1 : j + width]).sum()) / upper[j, 0]

    return x[:n]


def spline_slopes(x, values, axis=0):
    """Slopes at the points of the cubic spline through values that is one cubic over the first two pieces,
    and over the last two.

    x : (n,) ascending. values : (..., n, ...), real or complex, along `axis`. 0 where there is but one point.
    """
    y = np.moveaxis(np.asarray(values), axis, 0)
    n = len(x)
    h = np.diff(x).reshape(-1, *[1] * (y.ndim - 1))
    rise = np.diff(y, axis=0) / h

    if n < 3:
        found = np.broadcast_to(rise.sum(axis=0), y.shape) if n == 2 else np.zeros_like(y)
        return np.moveaxis(found, 0, axis)
    if n == 3:
        bend = (rise[1] - rise[0]) / (h[0] + h[1])
        return np.moveaxis(
            np.stack([rise[0] - h[0] * bend, rise[0] + h[0] * bend, rise[1] + h[1] * bend]), 0, axis
        )

    main = np.concatenate([h[1:2], 2 * (h[:-1] + h[1:]), h[-2:-1]])
    above = np.concatenate([h[:1] + h[1:2], h[:-1]])
    below = np.concatenate([h[1:], h[-1:] + h[-2:-1]])
    first, last = h[0] + h[1], h[-1] + h[-2]
    right = np.concatenate(
        [
            [((h[0] + 2 * first) * h[1] * rise[0] + h[0] ** 2 * rise[1]) / first],
            3 * (h[1:] * rise[:-1] + h[:-1] * rise[1:]),
            [((h[-1] + 2 * last) * h[-2] * rise[-1] + h[-1] ** 2 * rise[-2]) / last],
        ]
    )

    for i in range(1, n):
        share = below[i - 1] / main[i - 1]
        main[i] = main[i] - share * above[i - 1]
        right[i] = right[i] - share * right[i - 1]

    for i in range(n - 1, -1, -1):
        right[i] = (right[i] - (above[i] * right[i + 1] if i < n - 1 else 0.0)) / main[i]

    return np.moveaxis(right, 0, axis)


def spline_at(x, values, points, axis=0):
    """Values and slopes at points of the spline of `spline_slopes`, along `axis`."""
    y, m = (np.moveaxis(part, axis, 0) for part in (values, spline_slopes(x, values, axis)))
    k = np.clip(np.searchsorted(x, points, side="right") - 1, 0, len(x) - 2)
    shape = (-1, *[1] * (y.ndim - 1))
    h, s = (x[k + 1] - x[k]).reshape(shape), ((points - x[k]) / (x[k + 1] - x[k])).reshape(shape)
    rise, left, right = y[k + 1] - y[k], h * m[k], h * m[k + 1]
    square, cube = 3 * rise - 2 * left - right, left + right - 2 * rise
    found = y[k] + s * (left + s * (square + s * cube))
    slope = (left + s * (2 * square + 3 * s * cube)) / h
    return np.moveaxis(found, 0, axis), np.moveaxis(slope, 0, axis)
