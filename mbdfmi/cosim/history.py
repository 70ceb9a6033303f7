"""What a run has seen: outputs and inputs at all macro steps, in arrays that grow."""

from __future__ import annotations

import numpy as np

from .network import Network

FIRST = 1024


class History:
    """Rows of a run: time (n,), y (n, n_y) at communication points; end (n, n_u), inputs at the end of the step that leads
    to a row as they were given; now (n, n_u), what the links make of the outputs there.
    """

    def __init__(self, net: Network, rows: int = FIRST):
        self.net, self.n = net, 0
        self._time: list[float] = []
        self._y, self._end = np.empty((rows, net.n_y)), np.empty((0, net.n_u))

    def add(self, time: float, y: np.ndarray, end: np.ndarray | None):
        """A row; end : None where inputs were held since the row before."""
        n = self.n
        if n == len(self._y):
            self._y = _larger(self._y, n)
        self._y[n] = y
        if end is not None:
            if n >= len(self._end):
                self._end = _larger(self._end, len(self._y) - len(self._end))
            self._end[n] = end
        self._time.append(time)
        self.n = n + 1

    @property
    def time(self) -> np.ndarray:
        """s."""
        return np.array(self._time)

    @property
    def y(self) -> np.ndarray:
        """Values read."""
        return self._y[: self.n]

    def now(self, first: int = 0) -> np.ndarray:
        """Inputs, of the outputs at each row from the first on."""
        return (self.net.G @ self.y[first:].T).T + self.net.b

    def end(self, first: int = 0) -> np.ndarray:
        """Inputs that the step before each row ended with; in the first row those of the start."""
        if len(self._end):
            return self._end[first : self.n]
        now = self.now(max(first - 1, 0))
        return now[:-1] if first else np.concatenate([now[:1], now[:-1]])


def _larger(rows, more):
    """The same rows with more behind them."""
    return np.concatenate([rows, np.empty((max(more, 1), rows.shape[1]))])
