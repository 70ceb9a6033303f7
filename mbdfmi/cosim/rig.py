"""The FMUs of a system at work on one vector of outputs and one of inputs."""

from __future__ import annotations

from collections.abc import Callable, Iterable
from functools import partial
from typing import Any

import numpy as np

from .errors import CouplingError, Discarded
from .fmi2 import Slave2
from .fmi3 import Slave3
from .members import Member
from .network import Feed, Network, start_values
from .slave import WARNING, Channel, Slave

SUBSTEPS = 1000
"""Parts that an FMU may take a step in."""

# weights of the value at the start, at the end, and of the square's coefficient times H2, of what is held
HOLDS = {"start": (1.0, 0.0, 0.0), "mean": (0.5, 0.5, -1 / 6), "end": (0.0, 1.0, 0.0)}


class Port:
    """An FMU and its parts of the vectors.

    now, end : views of the inputs at the start and at the end of a step; follows : whether it takes them as polynomials.
    """

    def __init__(self, rig: Rig, member: Member, slave: Slave):
        self.rig, self.member, self.slave, self.name = rig, member, slave, member.name
        self.rows = rig.net.fed[member.name].slice
        self.n_u = rig.net.fed[member.name].n
        self.follows = member.can.input_derivatives and isinstance(slave, Slave2) and self.n_u > 0
        self.rolls = member.can.rollback
        self.weights = (
            np.array([self._hold(feed) for feed in rig.net.feeds[self.rows]]).reshape(-1, 3).T.copy()
        )
        self.now, self.end, self.prev = (v[self.rows] for v in (rig.now, rig.end, rig.prev))

    def _hold(self, feed: Feed | None):
        if feed is None:
            return HOLDS["start"]
        chosen = feed.table.hold or self.member.table.hold
        if not chosen:
            at_once = any(entry == feed.entry.name for entry, _ in self.rig.through[self.name])
            chosen = "end" if at_once else "mean"
        return HOLDS[chosen]

    step: Callable[[float, float], None]
    """Advances from a time by a step (s), once the run has begun."""

    def connect(self):
        """Makes the calls, once there is an instance."""
        net, name, slave, rig = self.rig.net, self.name, self.slave, self.rig
        read, kept, fed = net.read[name], net.kept[name], net.fed[name]
        base = rig.y.ctypes.data
        self.columns = read.slice
        signals = [*read.signals, *kept.signals]
        self.get = Channel(slave, "Get", read.signals, base + 8 * read.first).move if read.n else _nothing
        if read.made:
            self.get = self._converting(self.get)
        shared = {s.reference for s in read.signals} & {s.reference for s in kept.signals}

        if not kept.n:
            self.get_all = self.get
        elif shared or read.made or not read.n:
            more = Channel(slave, "Get", kept.signals, base + 8 * kept.first).move
            self.get_all = more if not read.n else lambda: max(self.get(), more())
        else:
            self.get_all = Channel(slave, "Get", signals, base + 8 * read.first).move

        self.keeps = kept.n > 0
        self.held = np.zeros(fed.n)
        self.set: Callable[[], int] = _nothing
        self.set_now = self.set_derivatives = self.set

        if fed.n:
            entries = fed.signals
            self.set_now = Channel(slave, "Set", entries, rig.now.ctypes.data + 8 * fed.first).move
            self.set_held = Channel(slave, "Set", entries, self.held.ctypes.data).move
            self.set = self.set_now if self.follows else self.set_held

        self.derivative = np.zeros((2, fed.n))
        if self.follows:
            assert isinstance(slave, Slave2)
            address = self.derivative.ctypes.data
            self._set_derivatives = [slave.derivative_feed(fed.signals, order, address) for order in (1, 2)]

        self.others = _Others(self) if net.others[name].n else None

    def setting(self, address: int, order: int) -> list[Callable[[], int]]:
        """Calls that set the inputs to what stands at an address: values, then derivatives up to an order where they are taken."""
        entries = self.rig.net.fed[self.name].signals
        calls: list[Callable[[], int]] = [Channel(self.slave, "Set", entries, address).move]
        if self.follows:
            assert isinstance(self.slave, Slave2)
            calls.append(self.slave.derivative_feed(entries, order, address + 8 * self.n_u))
        return calls

    def _converting(self, get):
        """A call that reads, and what is made of what it reads."""
        block, y = self.rig.net.read[self.name], self.rig.y
        parts = []

        for conversion in block.made:
            first = block.places[conversion.results[0]]
            result = y[first : first + len(conversion.results)]
            parts.append((conversion, [block.places[s] for s in conversion.sources], result))

        def get_and_convert():
            status = get()
            for conversion, places, result in parts:
                result[:] = conversion.of(y[places], result)
            return status

        return get_and_convert

    def feed(self, H: float, square: np.ndarray | None = None) -> int:
        """Sets the inputs over a step of H (s): from `now` to `end`, with `square` times time squared; returns the status."""
        if not self.n_u:
            return 0
        if self.follows:
            slope = self.derivative[0]
            np.subtract(self.end, self.now, out=slope)
            slope *= 1.0 / H
            if square is None:
                return self.set() or self._set_derivatives[0]()
            slope -= square[self.rows] * H
            np.multiply(square[self.rows], 2.0, out=self.derivative[1])
            return self.set() or self._set_derivatives[1]()

        weights = self.weights
        np.multiply(weights[0], self.now, out=self.held)
        self.held += weights[1] * self.end
        if square is not None:
            self.held += weights[2] * square[self.rows] * (H * H)
        return self.set()

    def advance(self, time: float, H: float):
        """A step of H (s), in parts where the FMU stops on the way. Raises CouplingError, Ended; Discarded where all can go
        back.
        """
        try:
            self.step(time, H)
        except Discarded as part:
            self.partly(part, time + H)

    def partly(self, part: Discarded, end: float):
        """The rest of a step that was done in part; raises Discarded where all can go back."""
        if self.rig.keeps_all:
            raise part

        time = part.time
        for _ in range(SUBSTEPS):
            try:
                with self.slave.going_back(self.rolls):
                    self.step(time, end - time)
                return
            except Discarded as part:
                time = part.time
        raise CouplingError(f"{self.name}: did a step in more than {SUBSTEPS} parts up to {end:.9g} s")

    def check(self, status: int, what: str):
        """Raises CouplingError for the status of a call that moved values."""
        self.slave.check(status, what, f" at {self.rig.time:.9g} s")


def _slave(member: Member) -> Slave:
    """The instance to be, of its version of FMI."""
    return (Slave2 if member.version == 2 else Slave3)(member.name, member.path, member.description)


def _nothing() -> int:
    return 0


class _Others:
    """Numbers of other types than doubles, as doubles in y."""

    def __init__(self, port: Port):
        block = port.rig.net.others[port.name]
        groups = dict.fromkeys(s.group for s in block.signals)
        self.port, self.y = port, port.rig.y
        self.parts: list[tuple[Channel, list[tuple[int, int]]]] = []

        for group in groups:
            signals = [s for s in block.signals if s.group == group and s.kind != "string"]
            if signals:
                channel = Channel(port.slave, "Get", signals)
                pairs = list(zip((block.places[s] for s in signals), channel.places))
                self.parts.append((channel, pairs))

    def get(self) -> int:
        """Reads them; returns the status."""
        for channel, pairs in self.parts:
            if status := channel.move():
                return status
            for place, k in pairs:
                self.y[place] = channel.values[k]
        return 0


class _Transfer:
    """Discrete values that one FMU hands to another, and doubles that go into floats of 32 bits."""

    def __init__(self, rig: Rig, taker: Port, feeds: list[Feed]):
        self.rig, self.taker = rig, taker
        self.channel = Channel(taker.slave, "Set", [f.entry for f in feeds])
        self.gets: list[tuple[Port, Channel]] = []
        self.moves: list[tuple[Any, int, int, Feed]] = []

        for feed, place in zip(feeds, self.channel.places):
            if len(feed.terms) == 1 and feed.entry.kind != "real":
                port = rig.by_name[feed.terms[0].giver]
                channel = Channel(port.slave, "Get", [feed.terms[0].output])
                self.gets.append((port, channel))
                self.moves.append((channel.values, channel.places[0], place, feed))
            else:
                self.moves.append((None, 0, place, feed))

    def do(self):
        """Reads and writes them. Raises CouplingError."""
        for port, channel in self.gets:
            port.check(channel.move(), channel.call)

        for values, k, place, feed in self.moves:
            self.channel.values[place] = values[k] if values is not None else self._sum(feed)

        self.taker.check(self.channel.move(), self.channel.call)

    def _sum(self, feed):
        total = feed.offset
        for term in feed.terms:
            port = self.rig.by_name[term.giver]
            total += term.factor * port.slave.read_all([term.output])[0]
        return total


class Rig:
    """All FMUs at work.

    y : values read; old : those at the start of the step; older, oldest : at the two points before; known : all of them, with
    a 1 behind y. now, end, prev : inputs (n_u,) at the start of the step, at its
    end, and a step before. time : s, reached. keeps_all : whether the state of every FMU is saved at the start of a step.
    """

    def __init__(self, net: Network, through: dict[str, list[tuple[str, str]]]):
        self.net, self.through = net, through
        # in one vector, with a 1 behind the first, which takes what links add
        n = net.n_y
        self.known = np.zeros(4 * n + 1)
        self.known[n] = 1.0
        self._with_one, self.y = self.known[: n + 1], self.known[:n]
        self.old, self.older, self.oldest = self.known[n + 1 :].reshape(3, n)
        self.now, self.end, self.prev = (np.zeros(net.n_u) for _ in range(3))
        self.time = 0.0
        self.keeps_all = False
        self._shifted = True
        self.by_name = {name: Port(self, m, _slave(m)) for name, m in net.members.items()}
        self.ports = list(self.by_name.values())
        self.transfers: dict[str, _Transfer] = {}
        self._G = {port: net.G[port.rows] for port in self.ports if port.n_u}

    # life

    def open(self, start: float, stop: float):
        """Instantiates all FMUs, sets their parameters, goes into initialisation mode. Raises CouplingError."""
        self.time = start
        values = {}
        errors: list[str] = []

        for port in self.ports:
            try:
                values[port.name] = start_values(port.member)
            except CouplingError as error:
                errors += error.errors
        if errors:
            raise CouplingError(errors)

        for port in self.ports:
            table, slave = port.member.table, port.slave
            slave.open(table.log)
            slave.setup(start, stop if table.stop_time else None)
            if values[port.name]:
                slave.write_all(*zip(*values[port.name]))

        for port in self.ports:
            port.slave.initialise()
            port.connect()

        by_taker: dict[str, list[Feed]] = {}
        for feed in self.net.discrete:
            by_taker.setdefault(feed.taker, []).append(feed)
        for name, feeds in by_taker.items():
            groups = dict.fromkeys(f.entry.group for f in feeds)
            for group in groups:
                some = [f for f in feeds if f.entry.group == group]
                self.transfers[f"{name} {group}"] = _Transfer(self, self.by_name[name], some)

        for port in self.ports:
            block = self.net.fed[port.name]
            if block.n:
                # elements of an array that are not linked stay as they are
                there = Channel(port.slave, "Get", block.signals)
                port.check(there.move(), there.call)
                self.now[port.rows] = there.values[:]
                for k in range(port.rows.start, port.rows.stop):
                    if self.net.feeds[k] is None:
                        self.net.b[k] = self.now[k]

    def begin(self):
        """From initialisation mode to steps. Raises CouplingError."""
        for port in self.ports:
            port.slave.begin()
            port.step = port.slave.stepper
        self.fetch()
        self.exchange()
        self._shifted = bool(np.any(self.net.b))
        self.renew()

    def stepping(self, ports: Iterable[Port], H: float) -> list[tuple]:
        """Calls of FMUs for steps of H (s), for `do`."""
        return [(port, *port.slave.stepping(H), port.get_all) for port in ports]

    def do(self, calls: list[tuple], time: float, H: float):
        """Steps of H (s) from a time (s) with their outputs read, by no more than the calls. Raises CouplingError, Ended."""
        for port, start, do, refused, get in calls:
            start.value = time
            if (status := do()) > WARNING:
                self.time = time
                try:
                    refused(status, time, H)
                except Discarded as part:
                    port.partly(part, time + H)
            if status := get():
                self.time = time
                port.check(status, "reading its outputs")

    def close(self, well: bool):
        """Ends all instances."""
        for port in self.ports:
            port.slave.close(well)

    # values

    def ends(self, port: Port):
        """Inputs of an FMU at the end of the step, of the outputs as they are known."""
        if self.net.is_dense:
            np.dot(self._G[port], self.y, out=port.end)
        else:
            port.end[:] = self._G[port] @ self.y
        if self._shifted:
            port.end += self.net.b[port.rows]

    def wanted(self) -> np.ndarray:
        """What the links make of the outputs that are known: u (n_u,)."""
        return self.net.G @ self.y + self.net.b

    def renewing(self) -> Callable[[], Any]:
        """`renew`, as one call where matrices are small."""
        if not self.net.is_dense:
            return self.renew
        whole = np.column_stack([self.net.G, self.net.b]) if self._shifted else self.net.G
        return partial(np.dot, whole, self._with_one if self._shifted else self.y, self.now)

    def renew(self):
        """Inputs at the start of the next step, of the outputs that are known."""
        net = self.net
        if net.is_dense:
            net.G.dot(self.y, out=self.now)
        else:
            self.now[:] = net.G @ self.y
        if self._shifted:
            self.now += net.b

    def fetch(self):
        """Reads all outputs. Raises CouplingError."""
        for port in self.ports:
            port.check(port.get_all(), "reading its outputs")
            if port.others:
                port.check(port.others.get(), "reading its outputs")

    def exchange(self):
        """Hands discrete values on. Raises CouplingError."""
        for transfer in self.transfers.values():
            transfer.do()

    # states

    def keep(self, ports):
        """Saves states. Raises CouplingError."""
        for port in ports:
            if status := port.slave.keep():
                port.check(status, "saving its state")

    def back(self, ports):
        """Goes back to the saved states. Raises CouplingError."""
        for port in ports:
            if status := port.slave.back():
                port.check(status, "restoring its state")

    @property
    def work(self) -> dict[str, int]:
        """Calls of doStep by FMU."""
        return {port.name: port.slave.work for port in self.ports}
