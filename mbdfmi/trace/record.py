"""A run of a kernel on symbols: what it reads and writes, and on what the branches that it took depend."""

import math
import sys
from collections.abc import Callable, Container, Mapping
from dataclasses import dataclass
from functools import cache
from types import FrameType

from ..kernels.layout import ARRAY, COUNTS, SLOT, array_length
from . import searches, solutions
from .graph import REAL, Graph, Untraceable
from .plain import ROOM, Kernels
from .symbols import MATH, Symbol, maximum, minimum, node_of, symbol_of

MOST_PATHS = 64
"""Ways through one kernel that are followed side by side at most."""

BOTH_SIDES = (
    "math.algebra.matrix_E",
    "math.tables.evaluate",
    "math.tables.third",
    "math.tables.integral",
    "motion.drives.ramp",
    "forces.six_by_six.swing_twist",
    "forces.stops.resistance",
    "forces.struts.motion",
    "end_frames.convex.support",
    "end_frames.frames.sphere_pole",
    "end_frames.on_surfaces.motion",
    "end_frames.on_surfaces.surface_rates",
    "end_frames.surfaces.bearing_rates",
    "end_frames.surfaces.tangents",
)
"""Kernels in which all sides of every branch are followed, and what they leave is selected by its condition.

All other branches on values are taken as they are where the kernel is traced, and leave a guard.
"""


@dataclass(frozen=True)
class Guard:
    """A condition of a branch that was taken: a node, whether it held, where in the kernels that was."""

    node: int
    holds: bool
    place: str


class _Buffer:
    """A buffer of a model: numbers that are given, known, or written.

    given : the places that are symbols when they are read first. zeros : of these, those that are known
    where they are zero, and leave a guard.
    """

    def __init__(self, tracer, name, initial, given, zeros):
        self.tracer = tracer
        self.name = name
        self.initial = initial.tolist()
        self.given = given
        self.zeros = zeros
        self.zero: set[int] = set()
        self.now: dict[int, object] = {}

    def read(self, j):
        if j not in self.now:
            self.now[j] = self._first(j)

        return self.now[j]

    def _first(self, j):
        """What a place holds when it is read before it is written."""
        value = self.initial[j]

        if j in self.given:
            leaf = symbol_of(self.tracer, self.tracer.graph.leaf((self.name, j), value))

            if value == 0.0 and j in self.zeros and self.tracer.guard((leaf == 0.0).k):
                self.zero.add(j)
                return 0.0

            return leaf

        # what must not survive a call is nothing, or it would be given
        if self.name == "work" and value != 0.0:
            name = self.tracer.array_at(self.name, j)
            raise Untraceable(
                f"{_place()}: `{name}` of the work arrays is read, which holds {value} from before"
            )

        return value


class _Cells:
    """An array of a buffer, as kernels see it."""

    __slots__ = ("buffer", "first", "length")

    def __init__(self, buffer, first, length):
        self.buffer = buffer
        self.first = first
        self.length = length

    def __getitem__(self, k):
        if isinstance(k, Symbol):
            return self._looked_up(k)

        return self.buffer.read(self.first + k)

    def __setitem__(self, k, value):
        if isinstance(k, Symbol):
            raise Untraceable("a place that depends on values is written to")

        if self.buffer.tracer.is_following:
            raise Untraceable("something is written in one way through a branch, and not in the other")

        self.buffer.now[self.first + k] = value

    def _looked_up(self, k):
        """The number at a place that is searched for: of a table, which no one changes."""
        graph = k.graph
        place = graph.values[k.k]
        about = (self.buffer.name, self.first, self.length)
        return symbol_of(
            k.tracer, graph.node("load", (k.k,), about, REAL, self.buffer.initial[self.first + place])
        )


class _View:
    """`m` or `d` of a traced run."""

    def __init__(self, tracer, ints, counts, buffers):
        self.tracer = tracer
        self.__dict__.update(counts)

        for name, array in ARRAY.items():
            if array.buffer in buffers:
                cells = _Cells(buffers[array.buffer], ints[SLOT[name]], array_length(array, counts))
                setattr(self, name, cells)

        if "u" in buffers:
            self.u_buffer = _Cells(buffers["u"], 0, len(buffers["u"].initial))


class _Path:
    """A way through a kernel: the decisions that it begins with, and those that it came to."""

    def __init__(self, prefix):
        self.prefix = prefix
        self.taken = []

    def decide(self, k):
        n = len(self.taken)
        outcome = self.prefix[n][1] if n < len(self.prefix) else True
        self.taken.append((k, outcome))
        return outcome

    def outcome(self, k):
        return next((outcome for node, outcome in self.taken if node == k), None)


class Tracer:
    """Runs kernels on the buffers of an instance, which it leaves as they are.

    given : buffer ("reals", "state", "work", "u") -> places that are symbols; all others are numbers.
    zeros : likewise those that are taken for zero where they are, under a guard. exact : whether the graph
    keeps bits. solves : whether what is summed or solved for is one operation. slopes : whether such have
    derivatives, by_time : by the time too; opaque : leaves by which they have none. told : of a node that a
    branch asks for, and where that is, which way it goes without a guard, or None. after : kernel of `TOLD`
    -> what is called when it has been run.
    """

    def __init__(
        self,
        m,
        d,
        given: Mapping[str, Container[int]],
        zeros: Mapping[str, Container[int]] | None = None,
        exact: bool = True,
        solves: bool = True,
    ):
        self.graph = Graph(exact)
        self.model, self.data = m, d
        self.solves = solves
        self.slopes = not exact
        self.by_time = True
        self.opaque: set[int] = set()
        self.guards: dict[int, Guard] = {}
        self.told: Callable[[int, str], bool | None] | None = None
        self.after: dict[str, Callable[[], None]] = {}
        self._paths: list[_Path] = []
        ints = m.ints_buffer.tolist()
        counts = dict(zip(COUNTS, ints))
        arrays = {"ints": m.ints_buffer, "reals": m.reals_buffer, "state": d.state_buffer}
        arrays |= {"work": d.work_buffer, "u": d.u_buffer}
        self.buffers = {
            name: _Buffer(self, name, array, given.get(name, ()), (zeros or {}).get(name, ()))
            for name, array in arrays.items()
        }
        of = self.buffers
        self.m = _View(self, ints, counts, {name: of[name] for name in ("ints", "reals")})
        self.d = _View(self, ints, counts, {name: of[name] for name in ("ints", "state", "work", "u")})

    def run(self, module: str, kernel: str, *args):
        """A kernel of m and d, and of what else it takes. Returns what it returns."""
        try:
            return getattr(_kernels(self.solves)[module], kernel)(self.m, self.d, *args)
        except ZeroDivisionError:
            # that side of a branch is not gone, or the compiled kernel finds infinity there
            raise Untraceable(
                "something is divided by a number that is 0 at the state of the trace"
            ) from None

    def written(self, buffer: str) -> dict[int, int]:
        """Place -> node of what was written to a buffer and is not what was there."""
        found = {}

        for j, value in sorted(self.buffers[buffer].now.items()):
            k = node_of(self, value)

            # what is zero there by a guard
            if j in self.buffers[buffer].zero and self.graph.known(k) == 0.0:
                continue

            if self.graph.nodes[k].op != "leaf" or self.graph.nodes[k].about != (buffer, j):
                found[j] = k

        return found

    def array_at(self, buffer: str, place: int) -> str:
        """The name of the array that a place of a buffer is in."""
        cells = ((name, getattr(self.d, name)) for name, array in ARRAY.items() if array.buffer == buffer)
        return next(name for name, one in cells if one.first <= place < one.first + one.length)

    def node_of(self, value) -> int:
        """The node of a number, symbolic or not."""
        return node_of(self, value)

    def node_at(self, buffer: str, place: int) -> int:
        """The node of what stands in a buffer."""
        return node_of(self, self.buffers[buffer].read(place))

    @property
    def is_following(self):
        """Whether one of several ways through a kernel is being followed."""
        return bool(self._paths)

    def begin_anew(self):
        """What was written, and what it rested on, is forgotten; the graph stays."""
        self.guards = {}

        for buffer in self.buffers.values():
            buffer.now = {}

    # branches

    def decide(self, k):
        """Which way a branch on a node goes."""
        if self.told and (outcome := self.told(k, _place())) is not None:
            return outcome

        if k in self.guards:
            return self.guards[k].holds

        for path in self._paths:
            outcome = path.outcome(k)

            if outcome is not None:
                return outcome

        return self._paths[-1].decide(k) if self._paths else self.guard(k)

    def guard(self, k):
        """Whether a condition holds here, as must hold wherever the trace is to be used."""
        holds = bool(self.graph.values[k])
        self.guards[k] = Guard(k, holds, _place())
        return holds

    def both_sides(self, function, *args):
        """What a kernel that writes nothing returns, all its branches on values followed, by their
        conditions.
        """
        waiting: list[list] = [[]]
        ends = []

        while waiting and len(ends) < MOST_PATHS:
            prefix = waiting.pop()
            path = _Path(prefix)
            self._paths.append(path)

            try:
                result = function(*args)
            finally:
                self._paths.pop()

            ends.append((path.taken, result))
            waiting += [
                [*path.taken[:n], (path.taken[n][0], False)] for n in range(len(prefix), len(path.taken))
            ]

        return function(*args) if waiting else self._joined(ends, 0)

    def _joined(self, ends, depth):
        """The result of ways that have their first decisions in common."""
        if len(ends) == 1 and len(ends[0][0]) == depth:
            return ends[0][1]

        condition = ends[0][0][depth][0]
        yes, no = ([end for end in ends if end[0][depth][1] is outcome] for outcome in (True, False))
        return self._select(condition, self._joined(yes, depth + 1), self._joined(no, depth + 1))

    def _select(self, condition, a, b):
        """One of two results by a condition."""
        if a is b:
            return a

        if isinstance(a, tuple):
            parts = [self._select(condition, x, y) for x, y in zip(a, b, strict=True)]
            return type(a)(*parts) if hasattr(a, "_fields") else tuple(parts)

        x, y = node_of(self, a), node_of(self, b)
        return symbol_of(self, self.graph.select(condition, x, y))


def _place():
    """Where in the kernels a branch is taken: function, file and line."""
    frame: FrameType | None = sys._getframe(2)

    while frame and not frame.f_globals.get("__name__", "").startswith(ROOM):
        frame = frame.f_back

    if frame is None:
        return "outside the kernels"

    module = frame.f_globals["__name__"].removeprefix(f"{ROOM}.")
    return f"{module}.{frame.f_code.co_name}, line {frame.f_lineno}"


def _tracer_of(value):
    """The tracer of a symbol, of `m` or `d`, or of something in a tuple."""
    if isinstance(value, tuple):
        return next((found for found in map(_tracer_of, value) if found), None)

    return getattr(value, "tracer", None)


def _both_sides(function):
    def call(*args):
        tracer = _tracer_of(args)
        return tracer.both_sides(function, *args) if tracer else function(*args)

    return call


TOLD = ("dynamics.projection.unit_E", "dynamics.projection.move_by_change")
"""Kernels of which a tracer tells when they have been run (`Tracer.after`)."""


def _told(name):
    def replace(function):
        def call(m, d, *args):
            result = function(m, d, *args)

            if name in d.tracer.after:
                d.tracer.after[name]()

            return result

        return call

    return replace


def _is_finite(function):
    """`rates.is_finite`, which sums zeros times numbers: a graph has no such."""
    return lambda d, n: MATH.isfinite(sum((d.x[k] for k in range(n)), 0.0))


def _gap_left(function):
    """`projection.gap_left`: of many numbers, whichever it is."""

    def gap_left(m, d, starting, first):
        if d.loose[0] > 0.0:
            raise Untraceable("loops repeat themselves not quite exactly")

        return _largest(None)(d.row_gap, m.n_row)

    return gap_left


def _weakest_row(function):
    """`multipliers.weakest_row`: how little it adds, whichever it is."""

    def weakest_row(m, d):
        least = math.inf
        redundant = function.__globals__["REDUNDANT"]
        reference = function.__globals__["row_reference"]

        for row in range(m.n_row):
            if d.row_redundant[row] != redundant:
                pivot = d.pivot[row]
                share = 0.0 if pivot == 0.0 else 1.0 / (pivot * reference(m, d, row))
                least = minimum(least, share)

        return None, least

    return weakest_row


def _largest(function):
    """`algebra.largest`: of many numbers, whichever it is."""

    def largest(p, n):
        size = 0.0

        for k in range(n):
            size = maximum(size, abs(p[k]))

        return size

    return largest


@cache
def _kernels(solves):
    replaced: dict[str, Callable] = dict.fromkeys(BOTH_SIDES, _both_sides)
    replaced |= {name: _told(name) for name in TOLD}
    replaced |= {
        "math.algebra.largest": _largest,
        "dynamics.rates.is_finite": _is_finite,
        "dynamics.projection.gap_left": _gap_left,
        "dynamics.multipliers.weakest_row": _weakest_row,
    }
    return Kernels(replaced | searches.REPLACED | (solutions.REPLACED if solves else searches.WRITTEN_OUT))
