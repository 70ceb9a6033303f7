"""How FMUs advance together over one macro step (docs/coupling.md)."""

from __future__ import annotations

import itertools
from collections.abc import Sequence

import numpy as np

from .errors import Discarded
from .rig import Port, Rig


class Stage:
    """FMUs that advance together; others before and after them know only the outcome.

    holds : whether inputs stay over the step what they are at its start. phases : where steps are not repeated, the FMUs by when they
    are told what those before them have reached.
    """

    holds = False
    phases: list[list[Port]] | None = None

    def __init__(self, rig: Rig, ports: Sequence[Port]):
        self.rig, self.ports = rig, list(ports)

    def advance(self, time: float, H: float, square):
        """From a time over a step of H (s); inputs at its end are in `rig.end` then, outputs in `rig.y`.

        square : function of (H) that gives the coefficients of time squared, or None.
        """
        raise NotImplementedError


class Jacobi(Stage):
    """All at once: none knows what others have reached at the end."""

    def __init__(self, rig, ports):
        super().__init__(rig, ports)
        self.phases = [self.ports]

    def advance(self, time, H, square):
        rig = self.rig
        for port in self.ports:
            if port.n_u:
                rig.ends(port)

        # FMUs without anything to follow need no derivatives
        quadratic = square(H) if square else None
        for port in self.ports:
            if status := port.feed(H, quadratic):
                port.check(status, "setting its inputs")
        for port in self.ports:
            port.advance(time, H)
            if status := port.get_all():
                port.check(status, "reading its outputs")


class Held(Stage):
    """All at once, with what they have at the start of the step."""

    holds = True

    def __init__(self, rig, ports):
        super().__init__(rig, ports)
        self._sets = [(port, port.set_now) for port in self.ports if port.n_u]
        self._steps = [(port, port.step, port.get_all) for port in self.ports]

    def march(self, H, times, history):
        """Steps of H (s) from each of the times (s) to the next: as `advance`, one after another, with no more between the
        calls than what goes from FMU to FMU and into the history.
        """
        rig, sets = self.rig, self._sets
        calls = rig.stepping(self.ports, H)
        renew, reached, rows, row = rig.renewing(), history.reached, history.rows, history.row
        done = 0

        try:
            for time, end in itertools.pairwise(times):
                for port, set_now in sets:
                    if status := set_now():
                        rig.time = time
                        port.check(status, "setting its inputs")
                rig.do(calls, time, H)
                renew()
                reached.append(end)
                rows += row
                done += 1
        finally:
            rig.time = times[done]
            history.n += done
            for port in self.ports:
                port.slave.work += done

    def advance(self, time, H, square):
        for port, set_now in self._sets:
            if status := set_now():
                port.check(status, "setting its inputs")
        for port, step, get in self._steps:
            try:
                step(time, H)
            except Discarded as part:
                port.partly(part, time + H)
            if status := get():
                port.check(status, "reading its outputs")


class GaussSeidel(Stage):
    """One after another: each knows what those before it have reached at the end."""

    def __init__(self, rig, ports):
        super().__init__(rig, ports)
        self.phases = [[port] for port in self.ports]

    def advance(self, time, H, square):
        for port in self.ports:
            if port.n_u:
                self.rig.ends(port)
            if status := port.feed(H, square(H) if square else None):
                port.check(status, "setting its inputs")
            port.advance(time, H)
            if status := port.get_all():
                port.check(status, "reading its outputs")


class Repeated(Stage):
    """Steps repeated until the inputs at the end are those that the outputs at the end make.

    missed : by how much steps missed that did not converge. passes : of all steps. easy : whether the last step took one.
    """

    def __init__(self, rig, ports, tolerance, iterations):
        super().__init__(rig, ports)
        self.tolerance, self.iterations = tolerance, iterations
        net, names = rig.net, {port.name for port in ports}
        self.rows = np.array(
            [
                row
                for row, feed in enumerate(net.feeds)
                if feed and feed.taker in names and any(term.giver in names for term in feed.terms)
            ],
            int,
        )
        self.others = [
            row
            for port in ports
            for row in range(port.rows.start, port.rows.stop)
            if row not in set(self.rows.tolist())
        ]
        self.G, self.b = net.G[self.rows], net.b[self.rows]
        self.peak = np.maximum([net.feeds[row].entry.nominal for row in self.rows], 1e-300)
        self.missed: list[float] = []
        self.passes = 0
        self.easy = False
        self._points: list[np.ndarray] = []
        self._guesses: list[np.ndarray] = []

    def wanted(self):
        """What the outputs make of the inputs in question."""
        return self.G @ self.rig.y + self.b

    def scale(self, f):
        """The miss of each link that is allowed (n,): a part of the largest value that it had."""
        np.maximum(self.peak, np.abs(f), out=self.peak)
        return self.tolerance * self.peak

    def predict(self):
        """Inputs at the end from what is known before the step: by the polynomial through the last points, or by the
        recurrence that the last changes keep to, which foresees decay and ringing; by what was nearer last time.
        """
        rig, rows = self.rig, self.rows
        for port in self.ports:
            if port.n_u:
                rig.ends(port)

        now = rig.now[rows]
        self._points = [now, *self._points[:4]]
        if self.easy and not self._guesses:
            return

        guesses = [rig.end[rows].copy()]
        changes = [a - b for a, b in itertools.pairwise(self._points)]
        guesses += [now + change for change in _continued(changes, self.peak)]
        missed = [float(np.sum(((guess - now) / self.peak) ** 2)) for guess in self._guesses]
        best = int(np.argmin(missed)) if len(missed) == len(guesses) else 0
        rig.end[rows] = guesses[best]
        # where the polynomial will do, the rest is not asked for
        self._guesses = [] if self.easy and best == 0 else guesses

    def sweep(self, time, H, square, first):
        """All FMUs over the step with the inputs in `rig.end`."""
        rig = self.rig
        quadratic = square(H) if square else None
        if not first:
            rig.back(self.ports)
        for port in self.ports:
            if status := port.feed(H, quadratic):
                port.check(status, "setting its inputs")
            port.advance(time, H)
            if status := port.get():
                port.check(status, "reading its outputs")
        self.passes += 1

    def miss(self, worst):
        """Remembers a step that did not converge."""
        self.easy = False
        self.missed.append(worst * self.tolerance)


def _continued(changes, scale):
    """The next change of a series, newest first, by recurrences d[k] = a d[k-1] and d[k] = a d[k-1] + b d[k-2] that fit the
    last ones best.
    """
    if len(changes) < 2:
        return
    D = np.array(changes) / scale
    square = D[1] @ D[1]
    yield np.clip(D[0] @ D[1] / square if square > 0.0 else 0.0, -1.0, 1.0) * changes[0]

    if len(changes) < 4:
        return
    A = np.array([[D[1] @ D[1] + D[2] @ D[2], D[1] @ D[2] + D[2] @ D[3]], [0.0, D[2] @ D[2] + D[3] @ D[3]]])
    A[1, 0] = A[0, 1]
    right = np.array([D[0] @ D[1] + D[1] @ D[2], D[0] @ D[2] + D[1] @ D[3]])
    determinant = A[0, 0] * A[1, 1] - A[0, 1] ** 2
    if determinant > 1e-12 * A[0, 0] * A[1, 1]:
        a = (right[0] * A[1, 1] - right[1] * A[0, 1]) / determinant
        b = (right[1] * A[0, 0] - right[0] * A[0, 1]) / determinant
        yield np.clip(a, -2.0, 2.0) * changes[0] + np.clip(b, -1.0, 1.0) * changes[1]


class Iterated(Repeated):
    """Fixed-point passes, one FMU after another, relaxed by Aitken's method."""

    def __init__(self, rig, ports, tolerance, iterations):
        super().__init__(rig, ports, tolerance, iterations)
        place = {port.name: k for k, port in enumerate(ports)}
        feeds = rig.net.feeds
        # inputs whose sources all come earlier in a pass are known when it is their turn
        self.back_rows = [
            k
            for k, row in enumerate(self.rows)
            if any(place.get(t.giver, -1) >= place[feeds[row].taker] for t in feeds[row].terms)
        ]
        forward = set(range(len(self.rows))) - set(self.back_rows)
        self.forward = {
            port.name: np.array(
                [self.rows[k] for k in sorted(forward) if feeds[self.rows[k]].taker == port.name], int
            )
            for port in ports
        }

    def sweep(self, time, H, square, first):
        rig = self.rig
        if not first:
            rig.back(self.ports)
        for port in self.ports:
            rows = self.forward[port.name]
            if len(rows):
                rig.end[rows] = rig.net.G[rows] @ rig.y + rig.net.b[rows]
            if status := port.feed(H, square(H) if square else None):
                port.check(status, "setting its inputs")
            port.advance(time, H)
            if status := port.get():
                port.check(status, "reading its outputs")
        self.passes += 1

    def advance(self, time, H, square):
        rig, back = self.rig, self.back_rows
        self.predict()
        relax, before, worst = 1.0, None, 0.0

        for k in range(self.iterations):
            self.sweep(time, H, square, k == 0)
            f = self.wanted()
            r = (f - rig.end[self.rows])[back]
            worst = float(np.max(np.abs(r) / self.scale(f)[back], initial=0.0))
            if not worst > 1.0:
                self.easy = k == 0
                return
            if k == self.iterations - 1:
                break

            if before is not None:
                change = r - before
                square_sum = float(change @ change)
                if square_sum > 0.0:
                    relax = float(np.clip(-relax * (before @ change) / square_sum, -2.0, 2.0)) or 0.1
            before = r
            rig.end[self.rows[back]] += relax * r

        self.miss(worst)


class Newton(Repeated):
    """Newton's method on the inputs at the end, by the interface Jacobian: what the outputs at the end of a step change with
    the inputs at its end. It is found by differences when a step first needs it, and kept up to date by Broyden's formula,
    FMU by FMU (Sicklinger et al., Int. J. Numer. Meth. Engng 98, 2014).
    """

    MOST = 40
    """Inputs up to which differences are taken; with more, Broyden's formula begins with the instant's derivatives."""

    def __init__(self, rig, ports, tolerance, iterations):
        super().__init__(rig, ports, tolerance, iterations)
        self.S: dict[str, np.ndarray] = {}
        self.fresh = False
        self.length = 0.0
        self.inside = {
            p.name: self.rows[(self.rows >= p.rows.start) & (self.rows < p.rows.stop)] for p in ports
        }

    def advance(self, time, H, square):
        rig = self.rig
        self.predict()
        self.fresh = False
        # another length of step is another Jacobian, but for small changes
        if self.S and not 0.5 < H / self.length < 2.0:
            self.S = {}
        worst, least = 0.0, np.inf
        last: dict = {}

        for k in range(self.iterations):
            self.sweep(time, H, square, k == 0)
            if last and self.S:
                self._learn(last)
            u, f = rig.end[self.rows], self.wanted()
            r = f - u
            worst = float((np.abs(r) / self.scale(f)).max())
            if not worst > 1.0:
                self.easy = k == 0
                return
            if not np.all(np.isfinite(r)) or k == self.iterations - 1:
                break
            # what no longer gains is begun anew, once
            if not self.S or (worst > 0.5 * least and not self.fresh and k > 1):
                self._differences(time, H, square)
            least = min(least, worst)
            last = {p.name: (p.end.copy(), rig.y[p.columns].copy()) for p in self.ports}
            rig.end[self.rows] = u + self._step(r)

        self.miss(worst)

    def _step(self, r):
        """The Newton step."""
        J = np.zeros((len(self.rows), len(self.rows)))
        position = {int(row): k for k, row in enumerate(self.rows)}

        for port in self.ports:
            rows = self.inside[port.name]
            if len(rows):
                columns = [position[int(row)] for row in rows]
                J[:, columns] = self.G[:, port.columns] @ self.S[port.name]

        try:
            step = np.linalg.solve(np.eye(len(r)) - J, r)
        except np.linalg.LinAlgError:
            return r
        return step if np.all(np.isfinite(step)) else r

    def _differences(self, time, H, square):
        """The Jacobian by differences: a step of one FMU for each of its inputs."""
        rig = self.rig
        self.fresh, self.length = True, H
        self.S = {}

        for port in self.ports:
            rows = self.inside[port.name]
            y = rig.y[port.columns].copy()
            S = np.zeros((len(y), len(rows)))

            for k, row in enumerate(rows if len(self.rows) <= self.MOST else ()):
                there = rig.end[row]
                scale = self.peak[np.searchsorted(self.rows, row)]
                d = 1e-4 * max(scale, abs(there - rig.now[row])) or 1e-4
                rig.end[row] = there + d
                rig.back([port])
                port.check(port.feed(H, square(H) if square else None), "setting its inputs")
                port.advance(time, H)
                port.check(port.get(), "reading its outputs")
                S[:, k] = (rig.y[port.columns] - y) / d
                rig.end[row] = there

            rig.y[port.columns] = y
            self.S[port.name] = S

    def _learn(self, before):
        """Broyden's formula, of what the last change of inputs did."""
        rig = self.rig
        for port in self.ports:
            rows = self.inside[port.name]
            if not len(rows):
                continue
            end, y = before[port.name]
            change = (port.end - end)[rows - port.rows.start]
            length = float(change @ change)
            if length > 0.0:
                S = self.S[port.name]
                S += np.outer(rig.y[port.columns] - y - S @ change, change) / length
