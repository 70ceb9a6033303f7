"""Tables between their points, by their key `interpolation`."""

import numpy as np
from scipy.interpolate import CubicSpline, PchipInterpolator, PPoly

from .splines import quintic, smooth


def linear(x, y):
    """Straight lines."""
    return PPoly(np.array([np.diff(y) / np.diff(x), y[:-1]]), x)


def steps(x, y):
    """Each value holds until the time of the next."""
    return PPoly(np.array([np.append(y[:-1], y[-1])]), np.append(x, x[-1] + 1.0))


def cubic(x, y):
    """The spline with its third derivative continuous next to the ends;
    of few points the polynomial through them."""
    if len(x) < 4:
        c = np.polynomial.Polynomial.fit(x, y, len(x) - 1, domain=[0, 1], window=[0, 1])
        pieces = [c.deriv(k) if k else c for k in range(4)]
        factorial = (1, 1, 2, 6)
        return PPoly(np.array([pieces[k](x[:-1]) / factorial[k] for k in (3, 2, 1, 0)]), x)

    return CubicSpline(x, y, bc_type="not-a-knot")


READINGS = {
    "linear": linear, "steps": steps, "monotone": PchipInterpolator, "cubic": cubic, "quintic": quintic,
    "smooth": smooth,
}  # fmt: skip


class Table:
    """A quantity over an argument. beyond : what it does beyond its ends,
    go on "straight" or "hold" its end values."""

    def __init__(self, interpolation, x, y, beyond):
        self.x, self.y = np.asarray(x, float), np.asarray(y, float)
        self.pieces = READINGS[interpolation](self.x, self.y)
        self.straight = beyond == "straight"

    def __call__(self, x):
        """(value, slope, second slope) at x."""
        inside = np.clip(x, self.x[0], self.x[-1])
        value, slope, second = (float(self.pieces(inside, k)) for k in range(3))

        if inside == x:
            return value, slope, second

        return (value + slope * (x - inside), slope, 0.0) if self.straight else (value, 0.0, 0.0)

    def integral(self, a, b):
        """From a to b, beyond the ends too."""
        return self._area(b) - self._area(a)

    def _area(self, x):
        inside = np.clip(x, self.x[0], self.x[-1])
        area = float(self.pieces.integrate(self.x[0], inside))
        value, slope, _ = self(inside)
        return area + value * (x - inside) + (slope * (x - inside) ** 2 / 2 if self.straight else 0.0)

    def first_zero(self):
        """The first argument within the table where it is 0; its first one where there is none."""
        roots = self.pieces.solve(0.0, extrapolate=False)
        return float(min((root for root in roots if np.isfinite(root)), default=self.x[0]))
