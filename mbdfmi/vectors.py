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
