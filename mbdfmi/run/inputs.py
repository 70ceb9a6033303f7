"""The inputs of an in-process run over time: numbers, arrays of one value a communication point, functions of
time.

Between communication points numbers and arrays are held. Functions are followed: over a communication step,
or over parts of it, by polynomials of degree 5 through their values, as close as the solver's tolerance asks;
jumps and corners are found by bisection, and the parts end there. A function that is not smooth over any part
of a step is held, which is told.
"""

import math

import numpy as np

from ..compiler.variables import hint, meant
from ..kernels.motion.inputs import N_DERIVATIVE
from ..scene import variable_name

# points of a part (0 to 1) that a polynomial is put through, and where it is compared
NODES = 0.5 * (1 - np.cos(np.pi * np.linspace(0, 1, N_DERIVATIVE)))
BETWEEN = np.array([0.043, 0.331, 0.712])
TO_COEFFICIENTS = np.linalg.inv(np.vander(NODES, increasing=True))
AT_BETWEEN = np.vander(BETWEEN, N_DERIVATIVE, increasing=True)
FACTORIALS = np.array([math.factorial(k) for k in range(N_DERIVATIVE)])[:, None]

# allowed misfit, relative to the largest value so far: a part of the solver's tolerance, above rounding
FRACTION = 0.1
ROUNDING = 1e-13

# a misfit up to this that both halves of a part have too is the rounding of the function itself
ROUGHNESS = 1e-6

# how the next part is tried longer than the last; to what part of a communication step a jump is located; how
# many of them there may be, one at the start of a part counting for several
GROWTH = 4.0
SHARP = 1e-9
MOST_JUMPS = 200
AT_ONCE = 20


class Inputs:
    """The inputs of a run over its communication points `times` (s).

    given : by name, as of `simulate`. tolerance : the solver's, relative. notices : what a user should be
        told.
    positions : of the inputs in u that functions give.

    Raises KeyError for unknown names, ValueError for values that do not fit.
    """

    def __init__(self, model, given, times, tolerance):
        self.times = times
        self.notices = []
        self._held = {}
        self._functions = []
        by_name = {v.name: v for v in model.of_causality("input")}

        for name, value in given.items():
            name = variable_name(name)
            parts = [by_name[part].index for part in known(name, by_name, "input")]

            if callable(value):
                self._functions.append(_Function(name, value, parts))
            else:
                self._held |= zip(parts, _held(name, value, len(parts), times).T)

        # of each component, the function that it is of
        self._owner = np.repeat(np.arange(len(self._functions)), [len(f.positions) for f in self._functions])
        self.positions = [position for function in self._functions for position in function.positions]
        self._scale = np.zeros(len(self._functions))
        self._allowed = np.full(len(self._functions), max(FRACTION * tolerance, ROUNDING))
        self._smooth = np.ones(len(self._functions), bool)
        self._last = None
        self._known = {}

    def held(self, k):
        """{position in u: value} of all but functions at communication point k."""
        return {position: values[k] for position, values in self._held.items()}

    def first(self):
        """{position in u: value} of all at the first communication point."""
        return self.held(0) | (dict(zip(self.positions, self._at(self.times[0]))) if self.positions else {})

    def parts(self, k, length):
        """What functions do from communication point k on for `length` (s).

        Returns parts of that as (length (s), values and derivatives of orders 1 to 5 at the start (6, n)), in
        the order of `positions`. From the last point on nothing is known: the last part's polynomial goes on.
        """
        if not self.positions:
            return [(length, np.zeros((N_DERIVATIVE, 0)))]

        a = self.times[k]

        if k + 1 == len(self.times):
            return [(length, _moved(*self._last))] if self._last else [(length, self._constant(a))]

        b = self.times[k + 1]
        self._known = {t: values for t, values in self._known.items() if t == a}
        found = self._split(a, b)

        while found is None:
            found = self._split(a, b)

        self._last = found[-1][1] - found[-1][0], found[-1][2]
        starts = [start - a for start, _, _ in found] + [length]
        return [
            (end - start, derivatives) for start, end, (_, _, derivatives) in zip(starts, starts[1:], found)
        ]

    def _at(self, t):
        """Values (n,) of the functions at t (s), each asked once."""
        if t not in self._known:
            self._known[t] = np.concatenate([function(t) for function in self._functions])

        return self._known[t]

    def _constant(self, t):
        return np.vstack([self._at(t), np.zeros((N_DERIVATIVE - 1, len(self.positions)))])

    def _fit(self, a, b):
        """(derivatives at a (6, n), misfit of each function, relative) of polynomials over a part from a to b
        (s).
        """
        values = np.array([self._at(t) for t in (a, *(a + NODES[1:-1] * (b - a)), b)])
        there = np.array([self._at(t) for t in a + BETWEEN * (b - a)])
        size = np.zeros(len(self._functions))
        np.maximum.at(size, self._owner, abs(values).max(axis=0))
        self._scale = np.maximum(self._scale, size)
        coefficients = TO_COEFFICIENTS @ (values - values[0])
        missed = abs(AT_BETWEEN @ coefficients + values[0] - there).max(axis=0)
        misfit = np.zeros(len(self._functions))
        np.maximum.at(misfit, self._owner, missed)
        misfit = (
            np.divide(misfit, self._scale, out=np.zeros_like(misfit), where=self._scale > 0) * self._smooth
        )
        derivatives = coefficients * FACTORIALS / (b - a) ** np.arange(N_DERIVATIVE)[:, None]
        derivatives[0] = values[0]
        return np.where(self._smooth[self._owner], derivatives, self._constant(self._start)), misfit

    def _fits(self, misfit):
        return np.all(misfit <= self._allowed)

    def _split(self, a, b):
        """Parts (start, end, derivatives at the start) of a to b (s); None when a function turned out not to
        be smooth.
        """
        self._start = a
        sharp = max(SHARP * (b - a), 8 * np.spacing(abs(b)))
        parts, jumps = [], np.zeros(len(self._functions))
        start, reach, longest = a, b - a, b - a

        while start < b:
            end = start + reach if start + reach < b - sharp else b
            derivatives, misfit = self._fit(start, end)

            if self._fits(misfit):
                parts.append((start, end, derivatives))
                start, reach = end, GROWTH * (end - start)
                continue

            low, high, trouble = self._narrow(start, end, misfit, sharp)

            if trouble is None or (low > start and not self._fits(self._fit(start, low)[1])):
                # what is before it first
                reach = low - start if low > start else 0.5 * (high - start)
                continue

            # noise jumps again right behind a jump
            jumps += trouble * (1 if low > start else AT_ONCE)
            derivatives = self._fit(start, low)[0] if low > start else self._constant(start)
            parts.append((start, high, derivatives))
            longest = GROWTH * (low - start) if low > start else longest
            start, reach = high, longest

            if jumps.max() > MOST_JUMPS:
                self._give_up(jumps > MOST_JUMPS / 2)
                return None

        return parts

    def _narrow(self, low, high, misfit, sharp):
        """By bisection: (low, high, functions that jump between them, or None where halves of that will
        do).
        """
        while high - low > sharp:
            middle = 0.5 * (low + high)
            left, right = self._fit(low, middle)[1], self._fit(middle, high)[1]

            if self._fits(left) and self._fits(right):
                return low, high, None

            rough = (misfit > self._allowed) & (misfit < ROUGHNESS) & (np.minimum(left, right) > 0.3 * misfit)

            if rough.any():
                self._allowed = np.where(rough, 3.0 * misfit, self._allowed)
                return low, high, None

            if self._fits(left):
                low, misfit = middle, right
            else:
                high, misfit = middle, left

        return low, high, misfit > self._allowed

    def _give_up(self, which):
        for k in np.flatnonzero(which & self._smooth):
            self._smooth[k] = False
            self.notices.append(
                f"input {self._functions[k].name!r} is not smooth between communication points: it is held "
                f"there from {self._start:.9g} s on"
            )


def _moved(length, derivatives):
    """Derivatives (6, n) of polynomials at the other end of a part."""
    powers = length ** np.arange(N_DERIVATIVE) / FACTORIALS[:, 0]
    rows = [powers[: N_DERIVATIVE - k] @ derivatives[k:] for k in range(N_DERIVATIVE)]
    return np.array(rows)


class _Function:
    """A function of time that gives one or more inputs, checked when it is called."""

    def __init__(self, name, function, positions):
        self.name, self.positions = name, positions
        self._function = function

    def __call__(self, t):
        """(n,) at t (s)."""
        value = self._function(float(t))
        n = len(self.positions)

        try:
            found = np.atleast_1d(numbers(value, ""))
        except ValueError:
            found = np.empty(0)

        if found.shape != (n,):
            what = "a finite number" if n == 1 else f"{n} finite numbers"
            raise ValueError(
                f"input {self.name!r}: its function must return {what}; found {value!r} at {t:.9g} s"
            )

        return found


def _held(name, given, size, times):
    """(n, size): an input's values at the communication points."""
    values = numbers(given, f"input {name!r}")

    if size == 1 and values.shape in ((), times.shape):
        values = values[..., None]
    elif values.shape not in ((size,), (len(times), size)) or size == 1:
        raise ValueError(
            f"input {name!r}: needs {size} number(s), or as many for each of the {len(times)} communication "
            f"points; found shape {values.shape}"
        )

    return np.broadcast_to(values, (len(times), size))


def known(name, names, what):
    """Those of the names that a name means, of an array all elements; KeyError with a hint where there is
    none.
    """
    if found := meant(name, names):
        return found

    raise KeyError(f"no {what} {name!r}; {hint(name, names)}")


def numbers(given, what, shape=None, finite=True):
    """The numbers given, as an array. Raises ValueError; `what` says of what, `shape` is the only one that
    will do.
    """
    try:
        values = np.asarray(given)
    except ValueError:
        values = np.empty(0, object)

    if values.dtype.kind not in "iuf" or shape not in (None, values.shape):
        needs = "numbers" if shape is None else f"{shape[0]} numbers" if shape else "a number"
        raise ValueError(f"{what} needs {needs}, found {given!r}")

    if finite and not np.all(np.isfinite(values)):
        raise ValueError(f"{what} must be finite, found {values[~np.isfinite(values)].flat[0]}")

    return values.astype(float)
