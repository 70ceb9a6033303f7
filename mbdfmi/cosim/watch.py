"""A watch over a coupled run: whether it diverges, and whether the coupling makes energy."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from .errors import CouplingError
from .history import History, Seen
from .members import Member
from .misses import WINDOW
from .network import Feed, Network, find
from .schema import Bond

CHUNK = 16
"""Macro steps after which growth is looked at."""

PACE, GROWTH = 1.5, 1000.0
"""Growth of the largest value of a link from chunk to chunk, and in all while it keeps that pace, that is divergence where the
link also jumps.
"""

JUMP = 0.3
"""Median of a link's jumps in a chunk, relative to its largest value there, of a run that diverges."""

WATT = (1, 2, -3, 0, 0, 0, 0)
MUCH = 0.01
"""Of the energy that a bond exchanged: what the coupling made of it that is told."""

MUCH_AT_ONCE = 0.25
"""The same within a window of the run."""


class Watch:
    """Stops a run that diverges. Raises CouplingError with time and link."""

    def __init__(self, history: History, limit: float):
        self.net, self.history, self.limit = history.net, history, limit
        self._peak: np.ndarray | None = None
        self._begin = np.zeros(0)
        self._seen = 0
        self.next = CHUNK

    def look(self):
        """At what came since the last look; to be called once history has `next` rows, and at the end."""
        history, first = self.history, self._seen
        self._seen, self.next = history.n, history.n + CHUNK
        if history.n > first and self.net.n_u:
            now = history.now(first)
            self._bounds(now, first)
            self._growth(now, first)

    def _bounds(self, now, first):
        fine = np.abs(now) < self.limit
        if fine.all():
            return
        k = int(np.argmin(fine.all(axis=1)))
        row = int(np.argmin(fine[k]))
        time = self.history.time[first + k]
        y = self.history.y[first + k]
        # what is beyond is no result
        self.history.cut(first + k)
        self._no_number(row, y, time)
        raise CouplingError(
            f"the run diverges: {self._link(row)} is {now[k, row]:.3g} at {time:.9g} s, beyond [master] limit = "
            f"{self.limit:g}{ADVICE}"
        )

    def _no_number(self, row, y, time):
        """Raises CouplingError where what feeds an input is no number, which no other step would mend."""
        feed = self.net.feeds[row]
        for term in feed.terms if feed else ():
            value = y[self.net.place(term.giver, term.output)]
            if not np.isfinite(value):
                raise CouplingError(
                    f"{term.giver}: handed out {term.output.name} = {value} at {time:.9g} s, which {self._link(row)} passes on"
                )

    def _link(self, row):
        feed = self.net.feeds[row]
        return feed.text if feed else f"input {row}"

    def _growth(self, now, first):
        peak = np.abs(now).max(axis=0)
        if self._peak is None:
            self._peak = self._begin = peak
            return

        # where growth pauses it begins anew
        self._begin = np.where(peak > PACE * self._peak, self._begin, peak)
        self._peak = peak
        grows = (peak > GROWTH * self._begin) & (self._begin > 0)
        if not grows.any():
            return

        jumps = np.median(np.abs(now - self.history.end(first)), axis=0)
        grows &= jumps > JUMP * peak
        if grows.any():
            row = int(np.argmax(grows))
            raise CouplingError(
                f"the run diverges: {self._link(row)} grows from {self._begin[row]:.3g} to {peak[row]:.3g} while it jumps from "
                f"step to step, up to {self.history.time[-1]:.9g} s{ADVICE}"
            )


ADVICE = '; a smaller step, or [master] method = "newton" where all FMUs can go back, may help'


@dataclass(frozen=True)
class PowerBond:
    """Two links between two FMUs that carry power. effort, flow : the links of the force and of the velocity."""

    name: str
    effort: Feed
    flow: Feed


@dataclass(frozen=True)
class BondReport:
    """What was found of a bond. residual : W at each communication point, what the coupling makes; made, exchanged : J;
    worst : the largest part of what was exchanged in a window that was made there; when : s, its start."""

    name: str
    residual: np.ndarray
    made: float
    exchanged: float
    worst: float = 0.0
    when: float = 0.0

    @property
    def part(self) -> float:
        """What was made, of what was exchanged."""
        return abs(self.made) / self.exchanged if self.exchanged > 0 else 0.0

    @property
    def told(self) -> str:
        """What a user should know of it, or nothing."""
        if self.part > MUCH:
            part = f"{100 * self.part:.2g} %"
            return f"bond {self.name}: the coupling made {self.made:.3g} J of {self.exchanged:.3g} J that went through it ({part})"
        if self.worst > MUCH_AT_ONCE:
            return (
                f"bond {self.name}: around {self.when:.6g} s the coupling made or lost {100 * self.worst:.2g} % of the energy "
                "that went through it; the step is too long for the master, or the coupling is unstable"
            )
        return ""


def bonds(net: Network, given: dict[str, Bond]) -> list[PowerBond]:
    """The bonds of a system: those that are given, and those that units and names tell. Raises CouplingError."""
    single = [f for f in net.feeds if f and len(f.terms) == 1 and f.terms[0].factor != 0.0]
    found = [_given(name, bond, net.members, single) for name, bond in given.items()]
    used = {feed for bond in found for feed in (bond.effort, bond.flow)}

    for effort in single:
        if effort in used or not _is_effort(effort):
            continue
        fits = [f for f in single if f not in used and _carry_power(effort, f)]
        close = [f for f in fits if _one_place(effort, f)]
        chosen = close if len(close) == 1 else fits
        if len(chosen) == 1:
            flow = chosen[0]
            found.append(PowerBond(f"{effort.terms[0].output.name} ({effort.text})", effort, flow))
            used |= {effort, flow}
    return found


def _given(name, bond, members: dict[str, Member], single):
    feeds = []
    for key, text in (("effort", bond.effort), ("flow", bond.flow)):
        try:
            member, signals = find(members, text, ("output", "local"), "output")
        except CouplingError as error:
            raise CouplingError(f"[bond.{name}] {key}: {error}") from error
        fits = [f for f in single if f.terms[0].giver == member.name and f.terms[0].output is signals[0]]
        if not fits:
            raise CouplingError(
                f"[bond.{name}] {key}: a bond is watched where a link has one source, and no link has {text} alone"
            )
        feeds.append(fits)

    for effort in feeds[0]:
        for flow in feeds[1]:
            if effort.taker == flow.terms[0].giver and flow.taker == effort.terms[0].giver:
                return PowerBond(name, effort, flow)
    raise CouplingError(f"[bond.{name}] effort and flow are no links between the same two FMUs, one each way")


def _unit(feed):
    """Of what a link carries: of its source, or of its target where the source has none."""
    return feed.terms[0].output.unit or feed.entry.unit


def _is_effort(feed):
    unit = _unit(feed)
    return unit is not None and unit.exponents[0] == 1


def _carry_power(effort, flow):
    one, other = effort.terms[0], flow.terms[0]
    if effort.taker != other.giver or flow.taker != one.giver or effort.taker == flow.taker:
        return False
    units = _unit(effort), _unit(flow)
    if None in units:
        return False
    exponents = tuple(a + b for a, b in zip(units[0].exponents, units[1].exponents))
    return exponents[: len(WATT)] == WATT


def _one_place(effort, flow):
    """Whether the variables belong to one joint or marker, on either side; of arrays to one component."""
    pairs = (effort.entry.name, flow.terms[0].output.name), (effort.terms[0].output.name, flow.entry.name)
    return any(_place(a) == _place(b) and "." in a for a, b in pairs)


def _place(name):
    stem, bracket, index = name.partition("[")
    return stem.rpartition(".")[0], bracket + index


def reports(net: Network, found: list[PowerBond], seen: Seen) -> list[BondReport]:
    """What the bonds did in a run: over each step inputs as they were given and outputs in between are straight lines."""
    return [_report(net, bond, seen) for bond in found] if seen.n > 1 else []


def _report(net, bond, seen):
    effort, flow = (_sides(net, feed, seen) for feed in (bond.effort, bond.flow))
    ratio = effort[3] / flow[3]

    def residual(part):
        """W, at a part of each step."""
        u_e, u_f = ((1 - part) * now[:-1] + part * end[1:] for now, end, _, _ in (effort, flow))
        y_e, y_f = ((1 - part) * y[:-1] + part * y[1:] for _, _, y, _ in (effort, flow))
        return u_e * y_f - ratio * y_e * u_f

    H = np.diff(seen.time)
    made = H / 6 * (residual(0.0) + 4 * residual(0.5) + residual(1.0))
    power = np.abs(effort[0] * flow[2])
    exchanged = np.sum(H / 2 * (power[1:] + power[:-1]))
    worst, when = _worst_window(seen.time, made, H / 2 * (power[1:] + power[:-1]))
    return BondReport(
        bond.name, np.append(0.0, residual(1.0)), float(np.sum(made)), float(exchanged), worst, when
    )


def _worst_window(time, made, exchanged):
    """(part, s): the largest part of the energy exchanged in a window that was made there, and its start; windows in which
    next to nothing was exchanged do not count.
    """
    starts = np.arange(0, len(made), WINDOW)
    sums = np.abs(np.add.reduceat(made, starts)), np.add.reduceat(exchanged, starts)
    part = sums[0] / np.maximum(sums[1], MUCH * max(sums[1].max(), 1e-300))
    k = int(np.argmax(part))
    return float(part[k]), float(time[starts[k]])


def _sides(net, feed, seen):
    """(input by its links, input as it was given at the end of steps, source, factor) of a feed, in SI units."""
    term = feed.terms[0]
    row, column = net.fed[feed.taker].places[feed.entry], net.place(term.giver, term.output)
    # a side without a unit has that of the other
    into = (feed.entry.unit or _unit(feed)).factor if _unit(feed) else 1.0
    out = _unit(feed).factor if _unit(feed) else 1.0
    factor = term.factor * into / out
    # what comes on top is no part of the bond
    now, end = seen.now[:, row] - feed.offset, seen.end[:, row] - feed.offset
    return into * now, into * end, out * seen.y[:, column], factor
