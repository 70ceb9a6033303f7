"""Curves through the points of a table, as piecewise polynomials (scipy PPoly) with the points for knots.

Motions are read smoothly: quintic splines have the speeds and accelerations of what was sampled. A spline leaves its points
where these are no samples of anything smooth, so "smooth" stands still between equal neighbours and bends no further out
than a sampled peak does.
"""

import numpy as np

from ..lazily import scipy
from ..vectors import solve_banded

# a spline may leave two neighbours by as much more than the parabola through samples of a peak does
PEAK = 1.5

# equal neighbours are samples on both sides of a peak if at least so many points around them lie on a smooth curve:
# sixth differences that are at most this part of the second ones
PEAK_POINTS = 12
PEAK_REACH = 8
PEAK_ROUGHNESS = 0.05

# by how much a piece may leave its points for rounding, as a part of the table's range
ROUNDING = 1e-11


def curve(interpolation, x, y):
    """The curve through points (x ascending (n,), y (n,)) that a table's key `interpolation` names."""
    return CURVES[interpolation](np.asarray(x, float), np.asarray(y, float))


def linear(x, y):
    """Straight lines."""
    return scipy.interpolate.PPoly([np.diff(y) / np.diff(x), y[:-1]], x)


def steps(x, y):
    """Each value until the next point."""
    end = x[-1] + (x[-1] - x[-2])
    return scipy.interpolate.PPoly([y], np.append(x, end))


def monotone(x, y):
    """Cubic, between its neighbours everywhere (Fritsch and Butland, SIAM J. Sci. Stat. Comput. 5, 1984)."""
    return scipy.interpolate.PchipInterpolator(x, y)


def cubic(x, y):
    """The cubic spline, not-a-knot; of fewer than four points the polynomial through them."""
    return scipy.interpolate.CubicSpline(x, y, bc_type="not-a-knot" if len(x) > 2 else "natural")


def quintic(x, y):
    """The quintic spline; of up to six points the polynomial through them."""
    return quintic_through(x, y, *_spline(x, y, np.zeros(len(x), bool), np.zeros(len(x)), np.zeros(len(x))))


def smooth(x, y):
    """A quintic spline that stands still between equal neighbours and nowhere leaves its points by far.

    Points where the spline would do so are held to a slope and a second slope with which the pieces on both sides rise or
    fall all the way. The spline goes on between points that are held: the curve is C2, and C4 but at those points.
    """
    slope, bend = np.zeros(len(x)), np.zeros(len(x))
    still = _stands_still(x, y)
    held = _ends(still)
    bow = np.where(held[:-1] | held[1:], 0.0, _bow_of_a_peak(x, y))
    limited = _monotone_ends(x, y)

    while True:
        slope, bend = _spline(x, y, held, slope, bend)
        found = _ends(_leaves(x, y, slope, bend, bow)) & ~held

        if not found.any():
            return quintic_through(x, y, slope, bend)

        held |= found
        slope, bend = np.where(found, limited, (slope, bend))


CURVES = {
    "linear": linear,
    "steps": steps,
    "monotone": monotone,
    "cubic": cubic,
    "quintic": quintic,
    "smooth": smooth,
}


def _ends(pieces):
    """Which points are an end of one of these pieces."""
    return np.append(pieces, False) | np.append(False, pieces)


def quintic_through(x, y, slope, bend):
    """The quintic pieces of these values, slopes and second slopes at the points."""
    return scipy.interpolate.PPoly(_coefficients(x, y, slope, bend)[::-1], x)


def _coefficients(x, y, slope, bend):
    """Coefficients (6, n - 1) of the pieces' powers of the distance from their left ends, the constant first."""
    h = np.diff(x)
    rise, m0, m1, a0, a1 = _scaled(h, y, slope, bend)
    return np.array(
        [
            y[:-1],
            slope[:-1],
            0.5 * bend[:-1],
            (10.0 * rise - 6.0 * m0 - 4.0 * m1 - 1.5 * a0 + 0.5 * a1) / h**3,
            (-15.0 * rise + 8.0 * m0 + 7.0 * m1 + 1.5 * a0 - a1) / h**4,
            (6.0 * rise - 3.0 * (m0 + m1) - 0.5 * (a0 - a1)) / h**5,
        ]
    )


def _scaled(h, y, slope, bend):
    """Of each piece the rise, and at its ends h times the slope and h^2 times the second slope."""
    return np.diff(y), h * slope[:-1], h * slope[1:], h**2 * bend[:-1], h**2 * bend[1:]


# derivatives of a piece of length h, the k-th times h^k, by (rise, h m0, h^2 a0, h m1, h^2 a1) with slopes m and second
# slopes a at its left (0) and right (1) end: the third and the fourth at both ends, the fifth
THIRD = ((60.0, -36.0, -9.0, -24.0, 3.0), (60.0, -24.0, -3.0, -36.0, 9.0))
FOURTH = ((-360.0, 192.0, 36.0, 168.0, -24.0), (360.0, -168.0, -24.0, -192.0, 36.0))
FIFTH = (720.0, -360.0, -60.0, -360.0, 60.0)

# diagonals of the spline's equations on each side of the main one; pieces that its conditions at a free end take
BAND = 9
FREE_PIECES = 6


class _Equations:
    """Linear equations for slopes and second slopes at the points of a quintic spline, banded.

    h, rise : (n - 1,) of the pieces. size : (n,) spacing at the points: unknowns are slopes times it and second slopes by its square.
    """

    def __init__(self, x, y):
        n = len(x)
        self.h, self.rise = np.diff(x), np.diff(y)
        self.size = np.minimum(np.append(self.h, self.h[-1]), np.append(self.h[0], self.h))
        self.matrix, self.right = np.zeros((2 * BAND + 1, 2 * n)), np.zeros(2 * n)

    def hold(self, k, slope, bend):
        """Slope and second slope at point k are given."""
        self.matrix[BAND, 2 * k : 2 * k + 2] = 1.0
        self.right[2 * k : 2 * k + 2] = slope * self.size[k], bend * self.size[k] ** 2

    def add(self, row, factor, piece, law):
        """Factor times a derivative of a piece, to an equation."""
        self.right[row] -= factor * law[0] * self.rise[piece]
        long = self.h[piece] / self.size[piece], self.h[piece] / self.size[piece + 1]
        terms = law[1] * long[0], law[2] * long[0] ** 2, law[3] * long[1], law[4] * long[1] ** 2

        for k, term in enumerate(terms):
            column = 2 * piece + k
            self.matrix[BAND + row - column, column] += factor * term

    def add_jump(self, row, point, order, laws, factor=1.0):
        """Factor times the jump of a derivative of some order at a point, times a spacing to that order, to an equation."""
        before, after = self.h[point - 1], self.h[point]
        least = np.minimum(before, after)
        self.add(row, factor * (least / before) ** order, point - 1, laws[1])
        self.add(row, -factor * (least / after) ** order, point, laws[0])

    def solve(self):
        """(slopes, second slopes) (n,)"""
        found = solve_banded(BAND, self.matrix, self.right)
        return found[::2] / self.size, found[1::2] / self.size**2


def _spline(x, y, held, slope, bend):
    """(slopes, second slopes) at the points of the quintic spline that has those given where they are held.

    C4 where they are not.
    """
    n = len(x)

    if n <= FREE_PIECES and not held.any():
        return (
            scipy.interpolate.KroghInterpolator(x, y).derivatives(x, 3)[1:]
            if n > 2
            else (np.full(2, np.diff(y) / np.diff(x)), np.zeros(2))
        )

    equations = _Equations(x, y)
    free = np.flatnonzero(~held[1:-1]) + 1
    equations.add_jump(2 * free, free, 3, THIRD)
    equations.add_jump(2 * free + 1, free, 4, FOURTH)

    for k in np.flatnonzero(held):
        equations.hold(k, slope[k], bend[k])

    for at_end, from_end in ((False, held), (True, held[::-1])):
        pieces = np.argmax(from_end) if held.any() else n - 1

        if pieces >= FREE_PIECES:
            _let_go_on(equations, x, at_end)
        elif pieces > 0:
            _let_straighten(equations, n, at_end)

    return np.where(held, (slope, bend), equations.solve())


def _let_go_on(equations, x, at_end):
    """Towards a free end the fifth derivative jumps on as it does further in (by as much at each point where they are equally
    spaced).
    """
    n = len(x)
    row, end, way = (2 * n - 2, n - 1, -1) if at_end else (0, 0, 1)

    for k in (0, 1):
        points = outer, inner = end + way * (k + 1), end + way * (k + 2)
        spacing = [
            (x[point + 1] - x[point - 1]) * min(equations.h[point - 1 : point + 1]) ** 5 for point in points
        ]
        equations.add_jump(row + k, outer, 5, (FIFTH, FIFTH), min(spacing) / spacing[0])
        equations.add_jump(row + k, inner, 5, (FIFTH, FIFTH), -min(spacing) / spacing[1])


def _let_straighten(equations, n, at_end):
    """The third and fourth derivatives are 0 at an end when a point nearby is held."""
    row, piece = (2 * n - 2, n - 2) if at_end else (0, 0)
    equations.add(row, 1.0, piece, THIRD[at_end])
    equations.add(row + 1, 1.0, piece, FOURTH[at_end])


def _stands_still(x, y):
    """Of each piece, whether its ends are equal, and not just two samples on both sides of a peak."""
    equal = np.abs(np.diff(y)) <= 4 * np.finfo(float).eps * np.abs(y[1:])
    n = len(x)

    if n < PEAK_POINTS:
        return equal

    second = 2 * _divided(x, y, 2)
    rough = 720 * np.abs(_divided(x, y, 6))

    for i in np.flatnonzero(equal):
        first, last = max(0, i - PEAK_REACH), min(n - 1, i + 1 + PEAK_REACH)
        alone = 0 < i < n - 2 and not equal[i - 1] and not equal[i + 1]

        if alone and last - first + 1 >= PEAK_POINTS and second[i - 1] * second[i] > 0:
            least = PEAK_ROUGHNESS * min(abs(second[i - 1 : i + 1]))
            equal[i] = not rough[first : last - 5].max() * (x[i + 1] - x[i]) ** 4 <= least

    return equal


def _divided(x, y, order):
    """Divided differences of some order."""
    for k in range(1, order + 1):
        y = np.diff(y) / (x[k:] - x[:-k])

    return y


def _bow_of_a_peak(x, y):
    """How far a spline through samples of a peak may bend out of each piece: positive downwards, 0 where there is no peak."""
    if len(x) < 4:
        return np.zeros(len(x) - 1)

    second = 2 * _divided(x, y, 2)
    pairs = np.array([second[:-1], second[1:]])
    bow = np.where(np.prod(np.sign(pairs), axis=0) > 0, np.sign(pairs[0]) * np.abs(pairs).min(axis=0), 0.0)
    return PEAK / 8 * np.diff(x) ** 2 * np.concatenate([bow[:1], bow, bow[-1:]])


def _leaves(x, y, slope, bend, bow):
    """Of each piece, whether it leaves the values at its ends by more than is allowed."""
    rise, m0, m1, a0, a1 = _scaled(np.diff(x), y, slope, bend)

    # of the derivative, by Bernstein's polynomials of degree 4
    controls = np.array([m0, m0 + a0 / 4, 5 * rise - 2 * (m0 + m1) + (a1 - a0) / 4, m1 - a1 / 4, m1])
    leaves = ~np.isfinite(controls).all(axis=0)
    some = np.flatnonzero(~leaves & (controls.min(axis=0) < 0) & (controls.max(axis=0) > 0))

    # distances from the left end as a part of the piece: close to the ends, and where parabolas there turn back
    s = np.broadcast_to((1 - np.cos(np.pi * np.arange(1, 64) / 64)) / 2, (len(some), 63))
    with np.errstate(all="ignore"):
        turns = np.stack([-m0[some] / a0[some], 1 - m1[some] / a1[some]], axis=1)

    s = np.concatenate([s, np.where((turns > 0) & (turns < 1), turns, 0.0)], axis=1).T
    c = _coefficients(x, y, slope, bend)[:, some] * np.diff(x)[some] ** np.arange(6)[:, None]
    value = s * (c[1] + s * (c[2] + s * (c[3] + s * (c[4] + s * c[5]))))
    above = value.max(axis=0) - np.maximum(rise[some], 0)
    below = np.minimum(rise[some], 0) - value.min(axis=0)
    slack = ROUNDING * np.ptp(y)
    leaves[some] = (above > slack + np.maximum(-bow[some], 0)) | (below > slack + np.maximum(bow[some], 0))
    return leaves


def _monotone_ends(x, y):
    """Slopes and second slopes at the points with which all pieces rise or fall throughout: of the parabolas through three
    points, limited.

    By Bernstein's coefficients a piece of length h that rises by h d does so throughout if its slopes are at most 5/4 d and
    the second slope beside a slope m is between -4 m / h and (10 d - 8 m) / h at its left end, mirrored at its right end.
    """
    h = np.diff(x)
    chord = np.diff(y) / h
    second = np.pad(2 * _divided(x, y, 2), 1, mode="edge") if len(x) > 2 else np.zeros(2)
    slope = np.append(chord - h * second[:-1] / 2, chord[-1] + h[-1] * second[-1] / 2)
    before, after = np.append(chord[0], chord), np.append(chord, chord[-1])
    h_before, h_after = np.append(np.inf, h), np.append(h, np.inf)
    goes_on = before * after > 0
    steep = np.clip(
        np.sign(after) * slope, 0, np.where(goes_on, 1.25 * np.minimum(abs(before), abs(after)), 0)
    )

    # in the direction of the piece after the point; at a peak the piece before it goes the other way
    least = np.maximum(-4 * steep / h_after, np.where(goes_on, (8 * steep - 10 * abs(before)) / h_before, 0))
    most = np.minimum(
        (10 * abs(after) - 8 * steep) / h_after, np.where(goes_on, 4 * steep, 10 * abs(before)) / h_before
    )
    return np.sign(after) * steep, np.sign(after) * np.clip(np.sign(after) * second, least, most)
