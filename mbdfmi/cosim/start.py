"""Consistent values of all links before the first step: in the order of what depends on what, circles by Newton's method."""

from __future__ import annotations

from collections.abc import Collection

import numpy as np

from .errors import CouplingError
from .graph import circle_text, components, feed_edges
from .network import Feed, Network
from .rig import Rig

ITERATIONS = 50
TOLERANCE = 1e-9
"""Of a circle of links, relative to the values, or to the largest change of it that a pass makes."""

SINGULAR = 1e-9
"""Singular value, relative to the gain, below which a circle has no solution, or none of its own: differences have no more
digits.
"""

GAIN = 1e-3
"""Of a circle, above 1: amplification that is told."""

SMALLEST = 2.0**-10
"""Part of a Newton step that is tried at the least."""


def circles_at_start(net: Network) -> list[list[Feed]]:
    """Links in the order in which their values are found at the start, those of a circle together."""
    feeds = [feed for feed in net.feeds if feed] + net.discrete
    return components(feeds, feed_edges(net, at_start=True))


def loops(net: Network, at_start: bool) -> list[list[Feed]]:
    """Circles of links, each of whose sources depends at once on the link before."""
    feeds = [feed for feed in net.feeds if feed] + net.discrete
    edges = feed_edges(net, at_start)
    alone = {a for a, b in edges if a is b}
    return [group for group in components(feeds, edges) if len(group) > 1 or group[0] in alone]


def initialise(rig: Rig, rolling: Collection[str] = ()) -> list[str]:
    """Makes all links consistent in initialisation mode. Raises CouplingError, with the circle that does not converge.

    rolling : FMUs whose steps are repeated. Returns what is to be told: circles that amplify changes, where steps are not.
    """
    net = rig.net
    in_the_run = [set(group) for group in loops(net, False)]
    told = []
    edges = feed_edges(net, at_start=True)
    following: dict[Feed, list[Feed]] = {}
    for a, b in edges:
        following.setdefault(a, []).append(b)

    feeds = [feed for feed in net.feeds if feed] + net.discrete
    waiting: list[Feed] = []

    for group in components(feeds, edges):
        if len(group) == 1 and group[0] not in following.get(group[0], ()):
            # those that do not wait for each other are done together
            if any(feed in following.get(earlier, ()) for earlier in waiting for feed in group):
                _pass_on(rig, waiting)
                waiting = []
            waiting += group
        else:
            _pass_on(rig, waiting)
            waiting = []
            loop = _Loop(rig, group, following)
            loop.solve()
            if set(group) in in_the_run and not {feed.taker for feed in group} <= set(rolling):
                told += loop.unstable()

    _pass_on(rig, waiting)
    return told


def _pass_on(rig, feeds):
    """Hands values on that wait for nothing."""
    if not feeds:
        return

    rig.fetch()
    values = rig.wanted()
    rows = {feed: row for row, feed in enumerate(rig.net.feeds) if feed}

    for port in rig.ports:
        own = [rows[f] for f in feeds if f.taker == port.name and f in rows]
        if own:
            rig.now[own] = values[own]
            port.check(port.set_now(), "setting its inputs")

    takers = {feed.taker for feed in feeds if feed not in rows}
    for key, transfer in rig.transfers.items():
        if key.split(" ")[0] in takers:
            transfer.do()


class _Loop:
    """Links in a circle: u = f(u)."""

    def __init__(self, rig: Rig, group: list[Feed], following):
        self.rig, self.group, self.following = rig, group, following
        places = {feed: row for row, feed in enumerate(rig.net.feeds) if feed}
        self.rows = np.array([places[f] for f in group if f in places], int)
        self.discrete = [f for f in group if f not in places]
        takers = {f.taker for f in group}
        self.ports = [port for port in rig.ports if port.name in takers]
        self.nominal = np.array([rig.net.feeds[row].entry.nominal for row in self.rows])

    def outcome(self, u):
        """f(u). Raises CouplingError."""
        self.rig.now[self.rows] = u
        for port in self.ports:
            port.check(port.set_now(), "setting its inputs")
        if self.discrete:
            self.rig.exchange()
        self.rig.fetch()
        return self.rig.wanted()[self.rows]

    def solve(self):
        """Newton's method from the values that are there. Raises CouplingError."""
        u = self.rig.now[self.rows].copy()
        f = self.outcome(u)
        scale = np.maximum.reduce([np.abs(u), np.abs(f), self.nominal, np.full(len(u), 1e-300)])
        worst = np.inf

        for _ in range(ITERATIONS):
            r = f - u
            scale = np.maximum(scale, np.abs(f) * np.isfinite(f))
            worst = float(np.max(np.abs(r) / scale, initial=0.0))

            if worst <= TOLERANCE:
                self.outcome(f)
                return

            step = self._newton_step(u, f, r)
            if step is None:
                break
            u, f, better = self._damped(u, f, r, step)
            if not better:
                break

        raise CouplingError(
            "the start is not consistent: the links in a circle, "
            f"{circle_text(self.group, self.following)}, do not converge (they miss each other by {worst:.3g} of their "
            "values); other start values of these inputs may help, or a circle with a delay in it"
        )

    def unstable(self):
        """What is told of a circle that answers to a change by a larger one: a notice, or nothing."""
        u = self.rig.now[self.rows].copy()
        J = self._jacobian(u, self.outcome(u))
        gain = float(np.abs(np.linalg.eigvals(J)).max()) if len(u) and np.all(np.isfinite(J)) else 0.0
        if gain <= 1.0 + GAIN:
            return []
        return [
            f"the links in a circle, {circle_text(self.group, self.following)}, answer to a change by {gain:.3g} times that "
            "change, link by link, and the steps of their FMUs are not repeated: what is missed grows from step to step, and the "
            "run will diverge; let the FMUs go back (rollback), or put a delay into the circle"
        ]

    def _newton_step(self, u, f, r):
        J = self._jacobian(u, f)
        A = np.eye(len(u)) - J
        if not np.all(np.isfinite(A)):
            return None
        least = np.linalg.svd(A, compute_uv=False)[-1]
        return np.linalg.solve(A, r) if least > SINGULAR * (1.0 + np.abs(J).max()) else None

    def _damped(self, u, f, r, step):
        """(u, f, whether it is better) after as much of a step as makes the links miss each other by less."""
        weight = np.maximum(np.maximum(np.abs(u), np.abs(f)), self.nominal + 1e-300)
        before = np.max(np.abs(r) / weight)
        part = 1.0

        while part >= SMALLEST:
            trial = u + part * step
            value = self.outcome(trial)
            missed = np.abs(value - trial)
            fine = np.all(np.isfinite(value))

            if fine and (
                np.max(missed / weight) < before * (1 - 0.1 * part) or np.all(missed <= TOLERANCE * weight)
            ):
                return trial, value, True
            part /= 2

        return u, f, False

    def _jacobian(self, u, f):
        """df/du: of directional derivatives where all FMUs of the circle have them, else of differences."""
        J = self._told_jacobian()
        if J is not None:
            return J

        J = np.zeros((len(u), len(u)))
        for k in range(len(u)):
            d = 1e-6 * max(abs(u[k]), self.nominal[k], 1.0)
            other = u.copy()
            other[k] += d
            J[:, k] = (self.outcome(other) - f) / d
        self.outcome(u)
        return J

    def _told_jacobian(self):
        net = self.rig.net
        D = np.zeros((net.n_y, net.n_u))

        for port in self.ports:
            entries = [(row, net.feeds[row].entry) for row in self.rows if net.feeds[row].taker == port.name]
            outputs = net.read[port.name].signals
            if not entries or not outputs:
                continue
            if net.read[port.name].made:
                return None
            part = port.slave.derivatives(outputs, [entry for _, entry in entries])
            if part is None:
                return None
            places = [net.read[port.name].places[s] for s in outputs]
            D[np.ix_(places, [row for row, _ in entries])] = part

        return (net.G @ D)[np.ix_(self.rows, self.rows)]
