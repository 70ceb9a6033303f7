"""Quintic splines through the points of a motion,
and those that are held where they would leave the points by far.

docs/scene.md tells what "quintic" and "smooth" are for; how their ends and held points are chosen is that of
the package's own description, worked out anew: dense equations for the slopes and second slopes at the
points, in place of banded ones.
"""

import itertools

import numpy as np
from scipy.interpolate import PPoly

# a piece's polynomial in t from 0 to 1 by value, slope and second slope at its ends
ENDS = np.array([
    [1, 0, 0, 0, 0, 0], [0, 1, 0, 0, 0, 0], [0, 0, 2, 0, 0, 0], [1, 1, 1, 1, 1, 1], [0, 1, 2, 3, 4, 5],
    [0, 0, 2, 6, 12, 20],
])  # fmt: skip
COEFFICIENTS = np.linalg.inv(ENDS)

# pieces that a free end's conditions are about
FREE = 6

# a spline may bow out of a piece by so many times what a parabola through samples of a peak does
PEAK = 1.5

# equal neighbours are two samples about a peak where so many points around them are this smooth
PEAK_POINTS, PEAK_REACH, PEAK_ROUGHNESS = 12, 8, 0.05


def derivative_row(order, t):
    """(6,): the order-th derivative at t of a piece, by value, slope and second slope at its ends,
    all for length 1."""
    powers = np.array(
        [np.prod(np.arange(k, k - order, -1)) * t ** (k - order) if k >= order else 0.0 for k in range(6)]
    )
    return powers @ COEFFICIENTS


def spline(x, y, held, slope, bend):
    """(slopes, second slopes) at the points: those given where held, else so that the curve is C4."""
    n = len(x)

    if n <= FREE and not held.any():
        p = np.polynomial.Polynomial.fit(x, y, n - 1)
        return p.deriv()(x), p.deriv(2)(x)

    h = np.diff(x)
    size = np.array([min(h[max(0, k - 1) : k + 1]) for k in range(n)])
    rows, right = [], []

    def functional(order, piece, t):
        """(row over (size m, size^2 a), constant) of a derivative of a piece."""
        weights = derivative_row(order, t) / h[piece] ** order
        row, constant = np.zeros(2 * n), 0.0

        for side, point in enumerate((piece, piece + 1)):
            value, m, a = weights[3 * side : 3 * side + 3]
            constant += value * y[point]
            row[2 * point] = m * h[piece] / size[point]
            row[2 * point + 1] = a * (h[piece] / size[point]) ** 2

        return row, constant

    def jump(order, point):
        (a, c), (b, d) = functional(order, point - 1, 1.0), functional(order, point, 0.0)
        return a - b, c - d

    def equation(row, constant):
        scale = np.abs(row).max()
        rows.append(row / scale)
        right.append(-constant / scale)

    for k in range(n):
        if held[k]:
            equation(np.eye(2 * n)[2 * k], -slope[k] * size[k])
            equation(np.eye(2 * n)[2 * k + 1], -bend[k] * size[k] ** 2)
        elif 0 < k < n - 1:
            equation(*jump(3, k))
            equation(*jump(4, k))

    for end, way, from_end in ((0, 1, held), (n - 1, -1, held[::-1])):
        pieces = int(np.argmax(from_end)) if held.any() else n - 1

        # the fifth derivative jumps by as much for the spacing at the next two points
        if pieces >= FREE:
            for k in (1, 2):
                (a, c), (b, d) = (
                    [part / (x[p + 1] - x[p - 1]) for part in jump(5, p)]
                    for p in (end + way * k, end + way * (k + 1))
                )
                equation(a - b, c - d)
        elif pieces > 0:
            for order in (3, 4):
                equation(*functional(order, 0 if end == 0 else n - 2, 0.0 if end == 0 else 1.0))

    found = np.linalg.solve(np.array(rows), np.array(right))
    return np.where(held, slope, found[::2] / size), np.where(held, bend, found[1::2] / size**2)


def pieces_of(x, y, slope, bend):
    """The curve of these slopes and second slopes at the points."""
    h = np.diff(x)
    ends = np.array([y[:-1], h * slope[:-1], h**2 * bend[:-1], y[1:], h * slope[1:], h**2 * bend[1:]])
    return PPoly((COEFFICIENTS @ ends / h ** np.arange(6)[:, None])[::-1], x)


def quintic(x, y):
    """The quintic spline."""
    free = np.zeros(len(x), bool)
    return pieces_of(x, y, *spline(x, y, free, np.zeros(len(x)), np.zeros(len(x))))


def smooth(x, y):
    """The quintic spline that stands still between equal values,
    and is held where it leaves a piece's values by far."""
    n = len(x)
    slope, bend = np.zeros(n), np.zeros(n)
    held = ends_of(still(x, y))
    bow = np.where(held[:-1] | held[1:], 0.0, peaks(x, y))
    limited = np.array([monotone_end(x, y, k) for k in range(n)]).T

    while True:
        slope, bend = spline(x, y, held, slope, bend)
        found = ends_of(leaving(x, y, slope, bend, bow)) & ~held

        if not found.any():
            return pieces_of(x, y, slope, bend)

        held = held | found
        slope, bend = np.where(found, limited, (slope, bend))


def ends_of(pieces):
    """Which points are an end of one of these pieces."""
    return np.append(pieces, False) | np.append(False, pieces)


def divided(x, y, order):
    """Divided differences."""
    for k in range(1, order + 1):
        y = np.diff(y) / (x[k:] - x[:-k])

    return y


def still(x, y):
    """Of each piece, whether its ends are equal and not just two samples about a peak."""
    equal = np.abs(np.diff(y)) <= 4 * np.finfo(float).eps * np.abs(y[1:])
    n = len(x)

    if n < PEAK_POINTS:
        return equal

    second, sixth = 2 * divided(x, y, 2), 720 * np.abs(divided(x, y, 6))
    found = equal.copy()

    # in order: a piece that was found to be a peak's no longer counts as equal beside the next
    for i in np.flatnonzero(equal):
        first, last = max(0, i - PEAK_REACH), min(n - 1, i + 1 + PEAK_REACH)
        alone = 0 < i < n - 2 and not found[i - 1] and not found[i + 1]

        if alone and last - first + 1 >= PEAK_POINTS and second[i - 1] * second[i] > 0:
            rough = sixth[first : last - 5].max() * (x[i + 1] - x[i]) ** 4
            found[i] = not rough <= PEAK_ROUGHNESS * min(abs(second[i - 1]), abs(second[i]))

    return found


def peaks(x, y):
    """By how much the curve may bow out of each piece where its points are samples of a peak:
    downwards positive."""
    if len(x) < 4:
        return np.zeros(len(x) - 1)

    second = 2 * divided(x, y, 2)
    alike = [np.sign(a) * min(abs(a), abs(b)) if a * b > 0 else 0.0 for a, b in itertools.pairwise(second)]
    return PEAK * np.array([alike[0], *alike, alike[-1]]) * np.diff(x) ** 2 / 8


def leaving(x, y, slope, bend, bow):
    """Of each piece, whether it leaves the values at its ends by more than it may."""
    curve = pieces_of(x, y, slope, bend)
    slack = 1e-11 * np.ptp(y)
    found = []

    for k in range(len(x) - 1):
        c = np.polynomial.Polynomial(curve.c[::-1, k])
        turns = c.deriv().roots()
        turns = turns[np.isreal(turns)].real
        values = c(np.array([0.0, *turns[(turns > 0) & (turns < x[k + 1] - x[k])]]))
        above = values.max() - max(y[k], y[k + 1])
        below = min(y[k], y[k + 1]) - values.min()
        found.append(above > slack + max(-bow[k], 0.0) or below > slack + max(bow[k], 0.0))

    return np.array(found)


def monotone_end(x, y, k):
    """(slope, second slope) at a point with which the pieces on both sides rise or fall throughout:
    those of the parabola through it and its neighbours, limited."""
    n = len(x)
    chord = np.diff(y) / np.diff(x)

    if n > 2:
        i = min(max(k, 1), n - 2)
        parabola = np.polynomial.Polynomial.fit(x[i - 1 : i + 2] - x[k], y[i - 1 : i + 2], 2).convert()
        _, m, a = np.append(parabola.coef, np.zeros(3))[:3]
    else:
        m, a = chord[0], 0.0

    before, after = chord[max(k - 1, 0)], chord[min(k, n - 2)]
    h_before = x[k] - x[k - 1] if k > 0 else np.inf
    h_after = x[k + 1] - x[k] if k < n - 1 else np.inf
    way = np.sign(after)
    goes_on = before * after > 0
    steep = min(max(way * m, 0.0), 1.25 * min(abs(before), abs(after))) if goes_on else 0.0

    # Bernstein's coefficients of the derivative: a quintic piece rises throughout if they all do
    least = max(-4 * steep / h_after, (8 * steep - 10 * abs(before)) / h_before if goes_on else 0.0)
    most = min(
        (10 * abs(after) - 8 * steep) / h_after, (4 * steep if goes_on else 10 * abs(before)) / h_before
    )
    return way * steep, way * min(max(way * 2 * a, least), most)
