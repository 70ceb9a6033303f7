"""A run from its start to its end: macro steps, their length, what stops them."""

from __future__ import annotations

import contextlib
from collections.abc import Callable
from functools import partial

import numpy as np

from .errors import CouplingError, Discarded, Ended
from .history import History
from .masters import GaussSeidel, Held, Iterated, Jacobi, Newton, Repeated, Stage
from .misses import WITHIN
from .plain import Plain
from .plan import Plan
from .rig import Rig
from .schema import Master
from .watch import Watch

FIRST = 1e-2
"""Part of the communication step that the first macro step of chosen length takes."""

SHORTEST = 1e-9
"""Macro steps, relative to the first, below which a run stops."""

CAREFUL = (1 / 8, 1 / 4, 1 / 2, 1.0)
"""Ends of the parts that the first step is done in where steps are repeated, as parts of it."""

SHOWN = 20
"""Steps between two looks at how far a run is, where these take next to no time."""

EXACT = 1e-6
"""Relative difference up to which two runs of one step count as equal."""


class March:
    """The macro steps of a run. after : called after each, if not None. rejected : steps that were done again."""

    def __init__(self, rig: Rig, plan: Plan, master: Master, watch: Watch, history: History):
        self.rig, self.plan, self.master, self.watch, self.history = rig, plan, master, watch, history
        self.stages = [self._stage(group) for group in plan.groups]
        self.control = master.error
        self.order = plan.order
        self.rejected = 0
        self.after: Callable[[], None] | None = None
        self._past: list[tuple[float, np.ndarray]] = []
        smooth = np.zeros(rig.net.n_y, bool)
        for name in plan.predicts:
            smooth[rig.net.read[name].slice] = True
        self._smooth = smooth.astype(float)
        self._predicts = bool(plan.predicts) and self.order > 0
        self._ports = rig.ports if self._needs_all() else [rig.by_name[n] for n in plan.rolling]
        rig.keeps_all = self._needs_all()
        # what is recorded besides is read when the step is accepted; stages that do not repeat it read it at once
        history.held = len(self.stages) == 1 and self.stages[0].holds
        self._remembers = self.order > 0 or self.control is not None
        self._looks_back = bool(self._ports) or self._remembers
        # a parabola needs two points before: until they are there steps are repeated, where all FMUs can
        explicit = self.order == 2 and not plan.rolling and all(port.rolls for port in rig.ports)
        self._starter = Iterated(rig, rig.ports, min(master.tolerance, 1e-6), 20) if explicit else None
        repeated = [*self.stages, *([self._starter] if self._starter else [])]
        self._more = [(p, p.get_all) for s in repeated if isinstance(s, Repeated) for p in s.ports if p.keeps]
        self._keeps = True
        variable = all(member.can.variable_steps for member in rig.net.members.values())
        self._starts_careful = master.start_in_parts and variable and self._needs_all()
        self._others = [(port, port.others) for port in rig.ports if port.others]
        plain = history.held or (rig.net.is_dense and all(stage.phases for stage in self.stages))
        unseen = not (self._others or self._ports or self.control is not None)
        self._is_plain = plain and unseen

    def _needs_all(self):
        """Whether all states are saved before each step, so that a step can be done again."""
        return all(port.rolls for port in self.rig.ports) and (
            self.control is not None or len(self.plan.rolling) == len(self.rig.ports)
        )

    def _stage(self, group) -> Stage:
        ports = [self.rig.by_name[name] for name in group.names]
        if group.method == "iterate":
            return Iterated(self.rig, ports, self.master.tolerance, self.master.max_iterations)
        if group.method == "newton":
            return Newton(self.rig, ports, self.master.tolerance, self.master.max_iterations)
        if group.method == "gauss-seidel":
            return GaussSeidel(self.rig, ports)
        return (Jacobi if self.plan.order else Held)(self.rig, ports)

    # runs

    def fixed(self, times: np.ndarray, H: float, progress: Callable[[float], None] | None):
        """Macro steps from point to point, all but the last of H (s)."""
        grid = times.tolist()
        n = len(grid) - 1
        steps = [H] * (n - 1) + [grid[n] - grid[n - 1]]

        k = self._plainly(grid[:-1], H, progress) if self._goes_plainly and self.history.held else 0

        while k < n:
            evenly = len(self._past) >= self.order and all(length == H for length, _ in self._past)
            if evenly and self._goes_plainly and not self.history.held:
                k += self._plainly(grid[k:-1], H, progress)
                if k == n:
                    break
            if k == 0 and self._starts_careful:
                self._begin(grid[0], grid[1], steps[0])
            else:
                self._to(grid[k], grid[k + 1], steps[k])
            k += 1
            if progress:
                progress(grid[k])

    @property
    def _goes_plainly(self):
        """Whether steps of one length need no more than products between the FMUs' calls."""
        return self._is_plain and not (self.rig.transfers or self.after)

    def _begin(self, start, end, H):
        """The first step, in parts, of which nothing is kept but the last: what is switched on at the start is quick
        then, and nothing is known of the past.
        """
        time = start

        for part in CAREFUL:
            last = start + part * H if part < 1.0 else end
            self._keeps = part == 1.0
            self._to(time, last, last - time)
            time = last

    def _plainly(self, times, H, progress) -> int:
        """Steps of H (s) between times (s), after as many as polynomials look back: as `_to`, without what is not needed where
        none is repeated. Returns how many.
        """
        k, n, history, watch = 0, len(times) - 1, self.history, self.watch
        march = self._marching(H)

        while k < n:
            last = min(n, k + (SHOWN if progress else watch.next - history.n))
            try:
                march(times[k : last + 1], history)
            except Ended as who:
                raise self._end(who, self.rig.time) from None
            k = last
            if history.n >= watch.next:
                watch.look()
            if progress:
                progress(times[k])

        if n > 0 and not history.held:
            rig = self.rig
            self._past = [(H, rig.old.copy()), (H, rig.older.copy())][: self.order]
            rig.prev[:] = rig.net.G @ rig.old + rig.net.b
            rig.renew()
        return max(n, 0)

    def _marching(self, H) -> Callable[[list[float], History], None]:
        """What does plain steps of H (s) between times."""
        held = self.stages[0]
        if isinstance(held, Held):
            return partial(held.march, H)
        if len(self._past) > 1:
            self.rig.older[:] = self._past[1][1]
        phases = [phase for stage in self.stages for phase in stage.phases or ()]
        return Plain(self.rig, phases, H, self.order, self._smooth).march

    def _to(self, time, end, H):
        """From a time to an end a step of H away, in parts where an FMU stops on the way."""
        whole = True
        for _ in range(1000):
            try:
                self._step(time, H)
            except Discarded as part:
                self.rig.back(self.rig.ports)
                self.rig.y[:] = self.rig.old
                H, whole = part.time - time, False
                continue
            except Ended as who:
                raise self._end(who, time) from None

            time = end if whole else time + H
            self._accept(time, H)
            if end - time <= 1e-12 * max(1.0, abs(end)):
                return
            H, whole = end - time, True

        raise CouplingError(f"a step was done in more than 1000 parts up to {end:.9g} s")

    def chosen(self, start: float, stop: float, H: float, progress: Callable[[float], None] | None):
        """Macro steps chosen by the error that inputs have within them."""
        master = self.master
        least = master.min_step or SHORTEST * H
        most = master.max_step or np.inf
        # nothing is known of the past yet, so the first steps are careful
        H, time = min(FIRST * H, most), start
        scale = np.maximum([f.entry.nominal if f else 0.0 for f in self.rig.net.feeds], 0.0)

        while stop - time > 1e-12 * max(1.0, abs(stop)):
            H = min(H, most)
            left = stop - time
            # no crumb is left at the end
            length = left if left <= H else (left / 2 if 0.6 * left < H else H)
            try:
                self._step(time, length)
                error = self._error(scale, length)
            except Discarded as part:
                self._undo()
                H = part.time - time
                continue
            except Ended as who:
                raise self._end(who, time) from None

            factor = 0.9 * max(error, 1e-10) ** (-1.0 / (self.order + 1))

            if error > 1.0:
                self._undo()
                self.rejected += 1
                H = length * max(0.2, min(factor, 0.8))
                if least > H:
                    raise CouplingError(
                        f"macro steps below {least:.3g} s at {time:.9g} s do not keep the error of {self._worst}; write a "
                        "larger [master] error, or a smaller min_step"
                    )
                continue

            time = stop if length == left else time + length
            self._accept(time, length)
            np.maximum(scale, np.abs(self.rig.now), out=scale)
            H = length * min(2.0, max(0.3, factor))
            if progress:
                progress(time)

    def _undo(self):
        rig = self.rig
        rig.back(rig.ports)
        rig.y[:] = rig.old

    def _error(self, scale, H):
        """What inputs miss of the truth within the step, 1 for what is allowed."""
        rig = self.rig
        truth = rig.wanted()
        weight = self.control * np.maximum(scale, np.abs(truth)) + 1e-300
        inner = WITHIN[self.order] if self.plan.rolling else 1.0

        if not self._past:
            return 0.0 if np.all(np.isfinite(truth)) else np.inf
        if self.order:
            predicted = rig.net.G @ self._predicted + rig.net.b
            missed = inner * np.abs(truth - predicted)
        else:
            missed = inner * np.abs(truth - rig.now)

        ratio = np.where(np.isfinite(missed), missed / weight, np.inf)
        if not len(ratio):
            return 0.0
        worst = int(np.argmax(ratio))
        feed = rig.net.feeds[worst]
        self._worst = feed.text if feed else ""
        return float(ratio[worst])

    # one step

    def _step(self, time, H):
        rig = self.rig
        rig.time = time
        if self._ports:
            rig.keep(self._ports)
        if self._looks_back:
            rig.old[:] = rig.y
        if self._predicts and self._past:
            self._predict(H)
        square = self._square if self.order == 2 and self._past else None
        if rig.transfers:
            rig.exchange()
        if self._starter and len(self._past) < 2:
            rig.keep(rig.ports)
            self._starter.advance(time, H, square)
            return
        for stage in self.stages:
            stage.advance(time, H, square)

    def _predict(self, H):
        """Outputs at the end of the step, by the polynomial through the last points."""
        y = self.rig.y
        H1, y1 = self._past[0]
        slope = (y - y1) / H1
        change = slope * H

        if self.order == 2 and len(self._past) > 1:
            H2, y2 = self._past[1]
            change += (slope - (y1 - y2) / H2) / (H1 + H2) * (H * (H + H1))

        if self.control is not None:
            self._predicted = y + change
        change *= self._smooth
        y += change

    def _square(self, H):
        """Coefficients of time squared of the parabolas through the inputs at the last point, the one before, the end."""
        rig = self.rig
        H1 = self._past[0][0]
        return ((rig.end - rig.now) / H - (rig.now - rig.prev) / H1) / (H + H1)

    def _accept(self, time, H):
        rig = self.rig
        rig.time = time
        for port, get in self._more:
            if status := get():
                port.check(status, "reading its outputs")
        for port, others in self._others:
            port.check(others.get(), "reading its outputs")

        if self._remembers:
            self._past = [(H, rig.old.copy()), *self._past[:1]]
            rig.prev[:] = rig.now
        rig.renew()
        if not self._keeps:
            return
        self.history.add(time)
        if self.after:
            self.after()
        if self.history.n >= self.watch.next:
            self.watch.look()

    def _end(self, who, time) -> CouplingError:
        slave = self.rig.by_name[str(who)].slave
        return CouplingError(
            f"{who}: asks for the end of the run in the step at {time:.9g} s" + slave.last_words()
        )

    # rollback

    def untrue(self, H: float) -> dict[str, str]:
        """Of FMUs whose steps are to be repeated, those that do not repeat a step: what was found."""
        rig, found = self.rig, {}

        for name in sorted(self.plan.rolling):
            port = rig.by_name[name]
            try:
                found[name] = self._repeats(port, H)
            except CouplingError as error:
                found[name] = str(error)

        return {name: text for name, text in found.items() if text}

    def _repeats(self, port, H) -> str:
        rig = self.rig
        before = rig.y.copy()
        rig.keep([port])
        outcomes = []

        for _ in range(2):
            port.check(port.set_now(), "setting its inputs")
            with contextlib.suppress(Discarded, Ended):
                port.advance(rig.time, H)
            port.check(port.get(), "reading its outputs")
            outcomes.append(rig.y[port.columns].copy())
            rig.back([port])

        rig.y[:] = before
        port.slave.work -= 2
        one, other = outcomes
        apart = np.max(np.abs(one - other) / np.maximum(np.abs(one), 1e-12), initial=0.0)
        return f"a repeated step differs by {apart:.2g}" if apart > EXACT else ""

    @property
    def notices(self) -> list[str]:
        """What a user should know of the run."""
        found = []
        for stage in self.stages:
            if isinstance(stage, Repeated) and stage.missed:
                names = ", ".join(port.name for port in stage.ports)
                found.append(
                    f"{names}: {len(stage.missed)} steps did not converge in {stage.iterations} passes; they missed by "
                    f"{max(stage.missed):.2g} of the values at the worst"
                )
        return found
