"""What a run has seen: outputs and inputs at all macro steps."""

from __future__ import annotations

import numpy as np

from .network import Network


class History:
    """Rows of a run: time (n,), y (n, n_y) at communication points; end (n, n_u), inputs at the end of the step that leads
    to a row as they were given; now (n, n_u), what the links make of the outputs there.

    y, u : the arrays that rows are copied from, the values read and the inputs at the end of a step. held : whether inputs stay
    over a step what they were at its start, so that they need not be kept.
    """

    def __init__(self, net: Network, y: np.ndarray, u: np.ndarray):
        self.net, self.n, self.held = net, 0, False
        self._time: list[float] = []
        # bytes are what grows at the least cost
        self._y, self._end = bytearray(), bytearray()
        self._from = y.data.cast("B"), u.data.cast("B")

    @property
    def reached(self) -> list[float]:
        """Times of the rows, to be added to by those who are in a hurry, with `row` to `rows` and 1 to `n`, where inputs are
        held.
        """
        return self._time

    @property
    def rows(self) -> bytearray:
        """Values read, one row after another."""
        return self._y

    @property
    def row(self) -> memoryview:
        """The bytes of the next row."""
        return self._from[0]

    @property
    def inputs(self) -> bytearray:
        """Inputs at the end of steps, likewise, with `input_row`, where they are not held."""
        return self._end

    @property
    def input_row(self) -> memoryview:
        """The bytes of the inputs of the next row."""
        return self._from[1]

    def add(self, time: float):
        """A row."""
        self.n += 1
        self._time.append(time)
        self._y += self._from[0]
        if not self.held:
            self._end += self._from[1]

    def cut(self, n: int):
        """Forgets all rows from the n-th on."""
        self.n = n
        del self._time[n:]
        del self._y[8 * n * self.net.n_y :]
        del self._end[8 * n * self.net.n_u :]

    def _rows(self, kept, width, first):
        # a copy: bytes that are looked at cannot grow
        return np.array(np.frombuffer(kept, dtype=float)[first * width :]).reshape(-1, width)

    @property
    def time(self) -> np.ndarray:
        """s."""
        return np.array(self._time)

    @property
    def y(self) -> np.ndarray:
        """Values read."""
        return self._values(0)

    def _values(self, first):
        width = self.net.n_y
        return self._rows(self._y, width, first) if width else np.zeros((self.n - first, 0))

    def now(self, first: int = 0) -> np.ndarray:
        """Inputs, of the outputs at each row from the first on."""
        return (self.net.G @ self._values(first).T).T + self.net.b

    def end(self, first: int = 0) -> np.ndarray:
        """Inputs that the step before each row ended with; in the first row those of the start."""
        width = self.net.n_u
        if not self.held and width:
            return self._rows(self._end, width, first)
        now = self.now(max(first - 1, 0))
        return now[:-1] if first else np.concatenate([now[:1], now[:-1]])


class Seen:
    """A whole run, made of its history once: time (n,), y, now and end as there."""

    def __init__(self, history: History):
        self.n, self.time, self.y = history.n, history.time, history.y
        self.now, self.end = history.now(), history.end()
