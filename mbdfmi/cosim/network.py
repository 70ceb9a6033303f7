"""Links of a system resolved: which value of which FMU goes where, by what factor, in what unit."""

from __future__ import annotations

from collections.abc import Iterable, Sequence
from dataclasses import dataclass, field
from typing import Any

import numpy as np
import scipy

from ..compiler.variables import array_of, hint, meant
from ..scene import variable_name
from ..scene.errors import listed, show
from . import conversions
from .conversions import Conversion, Made, makes, takes
from .errors import CouplingError
from .measures import conversion
from .members import Member
from .schema import Link, SystemData
from .signals import Signal

SOURCES = ("output", "local", "calculatedParameter", "parameter", "independent")

DENSE = 40_000
"""Entries up to which a full matrix is faster than a sparse one."""


@dataclass(frozen=True, eq=False)
class Term:
    """What one scalar input gets of one scalar: factor times it."""

    giver: str
    output: Signal
    factor: float


@dataclass(frozen=True, eq=False)
class Feed:
    """A scalar input and what it is fed with. own_offset : that of the link, without those of units. notes : what was converted
    or not compared.
    """

    taker: str
    entry: Signal
    terms: tuple[Term, ...]
    offset: float
    own_offset: float
    table: Link
    notes: tuple[str, ...] = ()

    @property
    def text(self) -> str:
        """The link, as messages name it."""
        sources = " + ".join(f"{t.giver}.{t.output.name}" for t in self.terms)
        return f"{sources} -> {self.taker}.{self.entry.name}"


@dataclass
class Block:
    """Where the signals of one FMU are in a vector: from `first` on, `n` values; `signals` and their places in all of the
    vector. made : conversions of them, whose results stand behind, and have places too.
    """

    first: int
    n: int
    signals: list[Signal]
    places: dict[Signal, int] = field(default_factory=dict)
    made: list[Conversion] = field(default_factory=list)

    def add(self, conversion: Conversion):
        """Puts the results of a conversion behind all else."""
        first = self.slice.stop
        self.made.append(conversion)
        self.places |= {result: first + k for k, result in enumerate(conversion.results)}

    @property
    def slice(self) -> slice:
        """Of the vector."""
        return slice(self.first, self.first + self.n + sum(len(c.results) for c in self.made))


class Network:
    """The links of a system as matrices.

    y : all values that are read of FMUs, by blocks: doubles that are sources (`read`), doubles that are recorded besides
        (`kept`), then numbers of other types (`others`). u : doubles that are set, by blocks (`fed`).
    G, b : u = G y + b. feeds : of each row of u, None where nothing is linked (elements of arrays between).
    discrete : feeds of other types than doubles.
    """

    def __init__(
        self,
        members: dict[str, Member],
        feeds: list[Feed],
        record: list[tuple[str, Signal]],
        made: Sequence[tuple[str, Conversion]] = (),
    ):
        self.members, self.record = members, record
        self.names = list(members)
        self.discrete = [feed for feed in feeds if not feed.entry.is_real]
        continuous = [feed for feed in feeds if feed.entry.is_real]
        sources = {(t.giver, t.output): None for feed in continuous for t in feed.terms}
        sources = {pair: None for pair in sources if not isinstance(pair[1], Made)}
        sources |= {(giver, source): None for giver, conversion in made for source in conversion.sources}
        self.read, self.kept, self.others = {}, {}, {}
        n = 0

        for name in self.names:
            own = [s for giver, s in sources if giver == name]
            shown = [s for owner, s in record if owner == name]
            self._block(self.read, name, [s for s in own if s.is_real], n)
            for found in (c for giver, c in made if giver == name):
                self.read[name].add(found)
            n = self.read[name].slice.stop
            n = self._block(self.kept, name, [s for s in shown if s.is_real and s not in own], n)
            other = list(dict.fromkeys(s for s in own + shown if not s.is_real))
            n = self._block(self.others, name, other, n)

        self.n_y = n
        self.fed = {}
        n = 0

        for name in self.names:
            n = self._block(self.fed, name, [f.entry for f in continuous if f.taker == name], n)

        self.n_u = n
        self.feeds: list[Feed | None] = [None] * n
        rows, columns, factors = [], [], []
        self.b = np.zeros(n)

        for feed in continuous:
            row = self.fed[feed.taker].places[feed.entry]
            self.feeds[row] = feed
            self.b[row] = feed.offset
            for term in feed.terms:
                rows.append(row)
                columns.append(self.place(term.giver, term.output))
                factors.append(term.factor)

        shape = (self.n_u, self.n_y)
        self.G: Any = scipy.sparse.csr_array((factors, (rows, columns)), shape=shape)
        self.is_dense = self.n_u * self.n_y <= DENSE
        if self.is_dense:
            self.G = self.G.toarray()

        smooth = np.zeros(self.n_y, bool)
        for blocks in (self.read, self.kept):
            for block in blocks.values():
                smooth[block.slice] = True
        self.smooth = smooth

    @staticmethod
    def _block(blocks, name, signals, first):
        """Adds the block of some signals; returns what comes behind. Arrays stand whole."""
        sizes = {s.reference: s.size for s in signals}
        starts = dict(zip(sizes, np.cumsum([0, *sizes.values()]).tolist()))
        block = Block(first, sum(sizes.values()), signals)
        block.places = {s: first + starts[s.reference] + s.element for s in signals}
        blocks[name] = block
        return first + block.n

    def place(self, name: str, signal: Signal) -> int:
        """Of a signal in y."""
        for blocks in (self.read, self.kept, self.others):
            if signal in blocks[name].places:
                return blocks[name].places[signal]
        raise KeyError(signal.name)

    @property
    def feed_rows(self) -> np.ndarray:
        """Rows of u that are linked."""
        return np.array([row for row, feed in enumerate(self.feeds) if feed is not None], int)


# names


def find(
    members: dict[str, Member], text: str, causalities: Sequence[str], what: str
) -> tuple[Member, list[Signal]]:
    """The FMU and the scalars that "fmu.variable" stands for: one, or those of an array in order. Raises CouplingError."""
    name, dot, variable = text.partition(".")

    if name not in members:
        raise CouplingError(f"{text}: no FMU {name!r}; {hint(name, members)}")
    if not dot or not variable:
        raise CouplingError(f'{text}: write "{name}.variable"')

    member = members[name]
    fits = {n: s for n, s in member.signals.items() if s.causality in causalities}
    found = meant(variable, fits) or meant(variable_name(variable), fits)

    if found:
        return member, [fits[n] for n in found]

    for spelt in (variable, variable_name(variable)):
        if others := meant(spelt, member.signals):
            causality = member.signals[others[0]].causality
            near = [array_of(n) for n in fits]
            words = f"it is of causality {causality}; {hint(variable, near) if near else 'there are none'}"
            raise CouplingError(f"{text}: {name} has no {what} {variable!r}: {words}")

    raise CouplingError(f"{text}: {name} has no {what} {variable!r}; {hint(variable, fits)}")


# links


def network(data: SystemData, members: dict[str, Member]) -> Network:
    """The links of a system. Raises CouplingError with all that is wrong."""
    feeds: list[Feed] = []
    made: list[tuple[str, Conversion]] = []
    errors: list[str] = []
    taken: dict[tuple[str, str], str] = {}

    for k, link in enumerate(data.link, 1):
        try:
            found = list(_feeds(link, members, made))
        except CouplingError as error:
            errors += [f"link[{k}]: {text}" for text in error.errors]
            continue

        for feed in found:
            key = feed.taker, feed.entry.name
            if key in taken:
                errors.append(
                    f"link[{k}]: {feed.taker}.{feed.entry.name} is fed twice, by {taken[key]} too; to add sources "
                    'write source = ["a.x", "b.y"]'
                )
            taken[key] = f"link[{k}]"
        feeds += found

    try:
        record = recorded(data.record, members)
    except CouplingError as error:
        errors += error.errors

    if errors:
        raise CouplingError(errors)

    return Network(members, feeds, record, made)


def _feeds(link: Link, members, made) -> Iterable[Feed]:
    """A link by scalars; its conversion is added to `made`, with the FMU. Raises CouplingError."""
    taker, entries = find(members, link.target, ("input",), "input")
    givers = [find(members, text, SOURCES, "output") for text in link.source]

    if link.convert:
        giver = _one_giver(givers)
        sources = [output for _, outputs in givers for output in outputs]
        factors = [factor for factor, (_, outputs) in zip(link.factors, givers) for _ in outputs]
        found, scale, notes = _conversion(link, giver, sources, factors, entries)
        made.append((giver.name, found))
        for result, entry in zip(found.results, entries):
            yield Feed(taker.name, entry, (Term(giver.name, result, scale),), 0.0, 0.0, link, notes)
        return

    for text, (giver, outputs) in zip(link.source, givers):
        if len(outputs) != len(entries):
            raise CouplingError(
                f"{text} has {len(outputs)} component{'s' * (len(outputs) > 1)}, {link.target} has {len(entries)}; an "
                f'element of an array is written "{text.partition("[")[0]}[1]"'
            )

    offsets = link.offset if isinstance(link.offset, list) else [link.offset] * len(entries)
    if len(offsets) != len(entries):
        raise CouplingError(f"offset has {len(offsets)} numbers, {link.target} has {len(entries)} components")

    for k, entry in enumerate(entries):
        pairs = [(giver, outputs[k]) for giver, outputs in givers]
        yield _feed(link, taker, entry, pairs, offsets[k])


def _one_giver(givers):
    """The FMU that all sources are of. Raises CouplingError."""
    names = list(dict.fromkeys(giver.name for giver, _ in givers))
    if len(names) > 1:
        raise CouplingError(f"convert takes sources of one FMU, found those of {listed(names)}")
    return givers[0][0]


def _conversion(link, giver, sources, factors, entries):
    """(conversion, factor of what it makes, notes). Raises CouplingError."""
    units, words = takes(link.convert)
    unit, size, result = makes(link.convert)
    kind = f'convert = "{link.convert}"'
    notes = []

    if len(sources) != len(units):
        raise CouplingError(f"{kind} takes {words}, found {len(sources)} components")
    if len(entries) != size:
        raise CouplingError(
            f"{kind} makes {result}, and {link.target} has {len(entries)} component{'s' * (len(entries) > 1)}"
        )

    for k, (source, wanted) in enumerate(zip(sources, units)):
        if not source.is_real:
            raise CouplingError(
                f"{kind}: {giver.name}.{source.name} is of type {source.kind}, not a real number"
            )
        if not link.units or not source.unit:
            notes += [f"{source.name} taken for {wanted.name}"] * link.units
            continue
        if not source.unit.fits(wanted):
            raise CouplingError(
                f"{kind} takes {words}: {giver.name}.{source.name} is in {source.unit_name}, not in {wanted.name} or the like"
            )
        factors[k] *= conversion(source.unit, wanted)[0]

    scale = 1.0
    for entry in entries:
        if not entry.is_real:
            raise CouplingError(f"{kind}: {link.target} is of type {entry.group}, and must be of doubles")
        if link.units and entry.unit and not unit.fits(entry.unit):
            raise CouplingError(f"{kind} makes {result}, and {link.target} is in {entry.unit_name}")
        scale = conversion(unit, entry.unit)[0] if link.units and entry.unit else 1.0

    return conversions.conversion(link.convert, sources, factors), scale, tuple(notes)


def _feed(link, taker, entry, pairs, offset):
    """What one scalar input gets. Raises CouplingError."""
    terms, notes, own = [], [], offset

    for (giver, output), factor in zip(pairs, link.factors):
        source, target = f"{giver.name}.{output.name}", f"{taker.name}.{entry.name}"
        _check_kinds(link, source, output, target, entry)
        scale, shift = 1.0, 0.0

        if link.units and output.unit and entry.unit:
            scale, shift = _converted(source, output, target, entry)
            if scale != 1.0 or shift != 0.0:
                notes.append(f"{output.unit_name} to {entry.unit_name}")
        elif link.units and output.kind == entry.kind == "real" and (output.unit_name or entry.unit_name):
            notes.append(f"units not compared ({output.unit_name or 'none'}, {entry.unit_name or 'none'})")

        terms.append(Term(giver.name, output, factor * scale))
        offset += factor * shift

    return Feed(taker.name, entry, tuple(terms), offset, own, link, tuple(notes))


def _converted(source, output, target, entry):
    """(factor, offset) between two units. Raises CouplingError where one is no unit of the other's quantity."""
    if not output.unit.fits(entry.unit):
        raise CouplingError(
            f"{source} is in {output.unit_name}, {target} in {entry.unit_name}: these measure different quantities; if the "
            "factor has a unit, write units = false"
        )

    return conversion(output.unit, entry.unit)


COUNTS = ("integer", "enumeration")


def _check_kinds(link, source, output, target, entry):
    """Raises CouplingError for types that do not go together."""
    scaled = link.factors != [1.0] * len(link.factors) or len(link.source) > 1 or link.offset not in (0.0, 0)

    if entry.kind == "real":
        if output.kind in ("real", *COUNTS):
            return
    elif output.kind == entry.kind or (output.kind in COUNTS and entry.kind in COUNTS):
        if scaled:
            raise CouplingError(
                f"{target} is of type {entry.kind}: a link to it has one source and neither factor nor offset"
            )
        if output.kind == entry.kind == "enumeration" and output.items != entry.items:
            raise CouplingError(
                f"{source} and {target} are enumerations of different items: {listed(output.items) or 'none'} and "
                f"{listed(entry.items) or 'none'}"
            )
        return

    raise CouplingError(
        f"{source} is of type {output.kind}, {target} of type {entry.kind}: one cannot feed the other"
    )


# what is recorded


def recorded(names: list[str] | None, members: dict[str, Member]) -> list[tuple[str, Signal]]:
    """(FMU, scalar) of what results hold; None: all outputs that are numbers. Raises CouplingError."""
    errors: list[str] = []
    found: dict[tuple[str, Signal], None] = {}

    for text in list(members) if names is None else names:
        try:
            for member, signal in _recorded(text, members):
                if signal.kind != "string":
                    found[member.name, signal] = None
                elif text not in members:
                    raise CouplingError("is a text, and results hold numbers")
        except CouplingError as error:
            errors += [
                f"record: {text}: {one}" if one.startswith("is ") else f"record: {one}"
                for one in error.errors
            ]

    if errors:
        raise CouplingError(errors)

    return list(found)


def _recorded(text, members):
    if text in members:
        return [(members[text], s) for s in members[text].signals.values() if s.causality == "output"]

    member, signals = find(members, text, (*SOURCES, "input"), "variable")
    return [(member, s) for s in signals]


# parameters


def start_values(member: Member) -> list[tuple[Signal, Any]]:
    """(scalar, value) of the parameters that a table gives. Raises CouplingError with all that is wrong."""
    errors, found = [], []

    for name, value in member.table.parameters.items():
        place = f"[fmu.{member.name}] parameters: {name}"
        try:
            found += _start_value(member, name, value)
        except CouplingError as error:
            errors += [f"{place} {text}" for text in error.errors]

    if errors:
        raise CouplingError(errors)

    return found


def _start_value(member, name, value):
    fits = {n: s for n, s in member.signals.items() if _can_be_set(s)}
    names = meant(name, fits) or meant(variable_name(name), fits)

    if not names:
        if meant(name, member.signals):
            raise CouplingError("cannot be set: its value is found by the FMU")
        raise CouplingError(
            f"is not there: {member.name} has no parameter or input of that name; {hint(name, fits)}"
        )

    values = np.ravel(np.array(value, dtype=object)).tolist() if isinstance(value, list) else [value]
    if len(values) != len(names):
        raise CouplingError(f"takes {len(names)} value{'s' * (len(names) > 1)}, found {len(values)}")

    return [(fits[n], _typed(fits[n], v)) for n, v in zip(names, values)]


def _can_be_set(signal):
    if signal.variability == "constant" or signal.causality == "structuralParameter":
        return False
    return signal.causality in ("parameter", "input") or signal.initial in ("exact", "approx")


def _typed(signal, value):
    """A value as the variable takes it. Raises CouplingError."""
    kind = signal.kind
    number = isinstance(value, (int, float)) and not isinstance(value, bool)

    if kind == "real" and number:
        return float(value)
    if kind == "boolean" and (isinstance(value, bool) or value in (0, 1)):
        return bool(value)
    if kind == "integer" and number and float(value).is_integer():
        return int(value)
    if kind == "string" and isinstance(value, str):
        return value.encode()
    if kind == "enumeration":
        if isinstance(value, str) and value in signal.items:
            return signal.items[value]
        if number and float(value).is_integer():
            return int(value)
        raise CouplingError(f"needs one of {listed(signal.items, 'or')}, found {show(value)}")

    wanted = {
        "real": "a number",
        "integer": "a whole number",
        "boolean": "true or false",
        "string": "a text",
    }[kind]
    raise CouplingError(f"needs {wanted}, found {show(value)}")
