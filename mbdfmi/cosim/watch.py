"""A watch over a coupled run: whether it diverges, and whether the coupling makes energy."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from .errors import CouplingError
from .history import History
from .members import Member
from .network import Feed, Network, find
from .rig import Rig
from .schema import Bond

CHUNK = 16
"""Macro steps after which growth is looked at."""

GROWTH = 10.0
"""Of the largest value of a link from chunk to chunk, three in a row, that is divergence where the link also jumps."""

JUMP = 0.3
"""Median of a link's jumps in a chunk, relative to its largest value there, of a run that diverges."""

WATT = (1, 2, -3, 0, 0, 0, 0)
MUCH = 0.01
"""Of the energy that a bond exchanged: what the coupling made of it that is told."""


class Watch:
    """Stops a run that diverges. Raises CouplingError with time and link."""

    def __init__(self, rig: Rig, history: History, limit: float):
        self.rig, self.history, self.limit = rig, history, limit
        self._square = limit * limit
        self._peaks: list[np.ndarray] = []
        self._next = CHUNK

    def look(self, time: float):
        """After a macro step."""
        now = self.rig.now
        if not now @ now < self._square:
            self._out_of_bounds(time)
        if self.history.n > self._next:
            self._next += CHUNK
            self._growth(time)

    def _out_of_bounds(self, time):
        now = self.rig.now
        wrong = ~(np.abs(now) < self.limit)
        if not np.any(wrong):
            return
        row = int(np.argmax(wrong))
        feed = self.rig.net.feeds[row]
        what = f"is {now[row]:.3g}" if np.isfinite(now[row]) else "is no number"
        raise CouplingError(f"the run diverges: {feed.text if feed else row} {what} at {time:.9g} s{ADVICE}")

    def _growth(self, time):
        first_row = self.history.n - CHUNK
        now = self.history.now(first_row)
        peak = np.abs(now).max(axis=0)
        self._peaks = [*self._peaks[-2:], peak]
        if len(self._peaks) < 3:
            return

        first, second, third = self._peaks
        grows = (third > GROWTH * second) & (second > GROWTH * first) & (first > 0)
        if not grows.any():
            return

        jumps = np.median(np.abs(now - self.history.end(first_row)), axis=0)
        grows &= jumps > JUMP * third
        if grows.any():
            row = int(np.argmax(grows))
            feed = self.rig.net.feeds[row]
            raise CouplingError(
                f"the run diverges: {feed.text if feed else row} grows from {first[row]:.3g} to {third[row]:.3g} in "
                f"{2 * CHUNK} steps, up to {time:.9g} s{ADVICE}"
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
    """What was found of a bond. residual : W at each communication point, what the coupling makes; made, exchanged : J."""

    name: str
    residual: np.ndarray
    made: float
    exchanged: float

    @property
    def part(self) -> float:
        """What was made, of what was exchanged."""
        return abs(self.made) / self.exchanged if self.exchanged > 0 else 0.0


def bonds(net: Network, given: dict[str, Bond]) -> list[PowerBond]:
    """The bonds of a system: those that are given, and those that units and names tell. Raises CouplingError."""
    single = [
        f for f in net.feeds if f and len(f.terms) == 1 and f.offset == 0.0 and f.terms[0].factor != 0.0
    ]
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
            raise CouplingError(f"[bond.{name}] {key}: {text} is the one source of no link without an offset")
        feeds.append(fits)

    for effort in feeds[0]:
        for flow in feeds[1]:
            if effort.taker == flow.terms[0].giver and flow.taker == effort.terms[0].giver:
                return PowerBond(name, effort, flow)
    raise CouplingError(f"[bond.{name}] effort and flow are no links between the same two FMUs, one each way")


def _is_effort(feed):
    unit = feed.terms[0].output.unit
    return unit is not None and unit.exponents[0] == 1


def _carry_power(effort, flow):
    one, other = effort.terms[0], flow.terms[0]
    if effort.taker != other.giver or flow.taker != one.giver or effort.taker == flow.taker:
        return False
    if other.output.unit is None:
        return False
    exponents = tuple(a + b for a, b in zip(one.output.unit.exponents, other.output.unit.exponents))
    return exponents[: len(WATT)] == WATT


def _one_place(effort, flow):
    """Whether the variables belong to one joint or marker, on either side; of arrays to one component."""
    pairs = (effort.entry.name, flow.terms[0].output.name), (effort.terms[0].output.name, flow.entry.name)
    return any(_place(a) == _place(b) and "." in a for a, b in pairs)


def _place(name):
    stem, bracket, index = name.partition("[")
    return stem.rpartition(".")[0], bracket + index


def reports(net: Network, found: list[PowerBond], history: History) -> list[BondReport]:
    """What the bonds did in a run: over each step inputs as they were given and outputs in between are straight lines."""
    return [_report(net, bond, history) for bond in found] if history.n > 1 else []


def _report(net, bond, history):
    effort, flow = (_sides(net, feed, history) for feed in (bond.effort, bond.flow))
    ratio = effort[3] / flow[3]

    def residual(part):
        """W, at a part of each step."""
        u_e, u_f = ((1 - part) * now[:-1] + part * end[1:] for now, end, _, _ in (effort, flow))
        y_e, y_f = ((1 - part) * y[:-1] + part * y[1:] for _, _, y, _ in (effort, flow))
        return u_e * y_f - ratio * y_e * u_f

    H = np.diff(history.time)
    made = H / 6 * (residual(0.0) + 4 * residual(0.5) + residual(1.0))
    power = np.abs(effort[0] * flow[2])
    exchanged = np.sum(H / 2 * (power[1:] + power[:-1]))
    return BondReport(bond.name, np.append(0.0, residual(1.0)), float(np.sum(made)), float(exchanged))


def _sides(net, feed, history):
    """(input by its links, input as it was given at the end of steps, source, factor) of a feed, in SI units."""
    term = feed.terms[0]
    row, column = net.fed[feed.taker].places[feed.entry], net.place(term.giver, term.output)
    into = feed.entry.unit.factor if feed.entry.unit else 1.0
    out = term.output.unit.factor if term.output.unit else 1.0
    factor = term.factor * into / out
    return into * history.now()[:, row], into * history.end()[:, row], out * history.y[:, column], factor


def jumps(net: Network, history: History) -> dict[str, float]:
    """Largest jump of each input at a communication point, relative to the range of its values: what a step did not know."""
    if history.n < 2:
        return {}
    now = history.now()
    missed = np.max(np.abs(now - history.end())[1:], axis=0)
    spread = np.ptp(now, axis=0)
    return {
        feed.text: float(missed[row] / spread[row]) if spread[row] > 0 else 0.0
        for row, feed in enumerate(net.feeds)
        if feed
    }
