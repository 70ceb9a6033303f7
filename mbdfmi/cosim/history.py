"""What a run has seen: outputs and inputs at all macro steps, in arrays that grow."""

from __future__ import annotations

import numpy as np

FIRST = 1024


class History:
    """Rows of a run: time (n,), y (n, n_y) at communication points; end (n, n_u), inputs at the end of the step that leads
    to a row as they were given; now (n, n_u), what the links make of the outputs there.
    """

    def __init__(self, n_y: int, n_u: int, rows: int = FIRST):
        self.n = 0
        self._time = np.empty(rows)
        self._y, self._now, self._end = np.empty((rows, n_y)), np.empty((rows, n_u)), np.empty((rows, n_u))

    def add(self, time: float, y: np.ndarray, now: np.ndarray, end: np.ndarray):
        """A row."""
        n = self.n
        if n == len(self._time):
            self._grow()
        self._time[n] = time
        self._y[n] = y
        self._now[n] = now
        self._end[n] = end
        self.n = n + 1

    def _grow(self):
        for name in ("_time", "_y", "_now", "_end"):
            old = getattr(self, name)
            new = np.empty((2 * len(old), *old.shape[1:]))
            new[: self.n] = old[: self.n]
            setattr(self, name, new)

    @property
    def time(self) -> np.ndarray:
        """s."""
        return self._time[: self.n]

    @property
    def y(self) -> np.ndarray:
        """Values read."""
        return self._y[: self.n]

    @property
    def now(self) -> np.ndarray:
        """Inputs, of the outputs at each row."""
        return self._now[: self.n]

    @property
    def end(self) -> np.ndarray:
        """Inputs that the step before each row ended with."""
        return self._end[: self.n]
