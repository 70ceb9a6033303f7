"""A coupled system as a package of SSP 1.0: FMUs, connectors, connections, units, parameters."""

from __future__ import annotations

import zipfile
from datetime import UTC, datetime
from pathlib import Path
from typing import Any

from lxml import etree

from ..files import check_ending, replacing
from ..scene.writer import toml_text
from .errors import CouplingError
from .measures import BASES, Measure
from .members import Member
from .network import Feed, Network, start_values
from .schema import SystemData
from .signals import Signal
from .ssp import ANNOTATION, DESCRIPTION, NAMESPACES, tag, validate

TYPES = {
    "real": "Real",
    "integer": "Integer",
    "boolean": "Boolean",
    "string": "String",
    "enumeration": "Enumeration",
}
TOGETHER = ("fmu", "link", "name")
"""What the structure of SSP says; all else of a system goes into an annotation."""


def write_ssp(data: SystemData, members: dict[str, Member], net: Network, path: Path) -> Path:
    """Writes the package, whole or not at all. Raises CouplingError for what SSP 1.0 cannot say, OSError."""
    check_ending(path, "a package of SSP is to be written", ".ssp")
    _check(net)
    names = _file_names(members)
    root = _Structure(data, members, net, names).root
    validate(root, "ssd", path)

    with replacing(path) as temporary, zipfile.ZipFile(temporary, "w", zipfile.ZIP_DEFLATED) as package:
        text = etree.tostring(root, xml_declaration=True, encoding="UTF-8", pretty_print=True)
        package.writestr(DESCRIPTION, text)
        for source, name in {names[m.name]: m.path for m in members.values()}.items():
            package.write(name, f"resources/{source}")
    return Path(path)


def _check(net):
    """Raises CouplingError, with all that cannot be said."""
    errors = []
    for feed in [*net.feeds, *net.discrete]:
        if feed is None:
            continue
        if feed.table.convert:
            errors.append(f"{feed.text}: converts an orientation, which SSP 1.0 has no words for")
            continue
        if len(feed.terms) > 1:
            errors.append(f"{feed.text}: adds up sources, and SSP 1.0 connects an input to one output")
        errors += [
            f"{feed.text}: {name} is an element of an array of FMI 3.0, and SSP 1.0 has no arrays"
            for name, signal in ((feed.taker, feed.entry), *((t.giver, t.output) for t in feed.terms))
            if signal.variable != signal.name
        ]
    if errors:
        raise CouplingError(errors)


def _file_names(members):
    """Names of the FMUs in the package, by member: those of one file are one."""
    names: dict[str, str] = {}
    files: dict[Path, str] = {}
    for member in members.values():
        path = member.path.resolve()
        if path not in files:
            name = f"{path.stem}.fmu"
            files[path] = f"{member.name}.fmu" if name in files.values() else name
        names[member.name] = files[path]
    return names


class _Structure:
    """SystemStructure.ssd."""

    def __init__(self, data: SystemData, members: dict[str, Member], net: Network, files: dict[str, str]):
        self.data, self.members, self.net = data, members, net
        self.units: dict[str, Measure] = {}
        self.root = etree.Element(tag("ssd", "SystemStructureDescription"), nsmap=NAMESPACES)
        attributes = {
            "version": "1.0",
            "name": data.name,
            "generationTool": "mbdfmi",
            "generationDateAndTime": datetime.now(UTC).strftime("%Y-%m-%dT%H:%M:%SZ"),
        }
        self.root.attrib.update(attributes)
        system = self._add(self.root, "System", name=data.name)
        elements = self._add(system, "Elements")
        for member in members.values():
            self._component(elements, member, files[member.name])
        feeds = [feed for feed in [*net.feeds, *net.discrete] if feed]
        if feeds:
            connections = self._add(system, "Connections")
            for feed in feeds:
                self._connection(connections, feed)
        self._units()
        self._add(
            self.root, "DefaultExperiment", startTime=repr(data.run.start), stopTime=repr(data.run.stop)
        )
        self._annotation()

    @staticmethod
    def _add(parent, word, space="ssd", **attributes):
        return etree.SubElement(parent, tag(space, word), **attributes)

    def _component(self, elements, member: Member, file):
        component = self._add(
            elements,
            "Component",
            name=member.name,
            source=f"resources/{file}",
            type="application/x-fmu-sharedlibrary",
            implementation="CoSimulation",
        )
        connectors = {
            feed.entry: "input"
            for feed in [*self.net.feeds, *self.net.discrete]
            if feed and feed.taker == member.name
        }
        given = [
            t for f in [*self.net.feeds, *self.net.discrete] if f for t in f.terms if t.giver == member.name
        ]
        connectors |= {term.output: "output" for term in given}
        connectors |= {
            s: "output" for name, s in self.net.record if name == member.name and s.causality == "output"
        }
        plain = {s: kind for s, kind in connectors.items() if s.variable == s.name}
        if plain:
            parent = self._add(component, "Connectors")
            for signal, kind in plain.items():
                self._typed(self._add(parent, "Connector", name=signal.name, kind=kind), signal)
        self._parameters(component, member)

    def _typed(self, parent, signal: Signal):
        """The type of a connector, with its unit."""
        attributes = {}
        unit = signal.unit
        if unit is not None and self.units.setdefault(unit.name, unit) == unit:
            attributes["unit"] = unit.name
        if signal.kind == "enumeration":
            # its items would have to be told in the description of the system; an Integer says as much
            self._add(parent, "Integer", "ssc")
        else:
            self._add(parent, TYPES[signal.kind], "ssc", **attributes)

    def _parameters(self, component, member: Member):
        values = start_values(member)
        if not values:
            return
        bindings = self._add(component, "ParameterBindings")
        binding = self._add(bindings, "ParameterBinding")
        sets = self._add(
            self._add(binding, "ParameterValues"), "ParameterSet", "ssv", version="1.0", name="start values"
        )
        parameters = self._add(sets, "Parameters", "ssv")
        for signal, value in values:
            parameter = self._add(parameters, "Parameter", "ssv", name=signal.name)
            kind = "Integer" if signal.kind == "enumeration" else TYPES[signal.kind]
            self._add(parameter, kind, "ssv", value=_text(value))
        validate(etree.fromstring(etree.tostring(sets)), "ssv", f"parameters of {member.name}")

    def _connection(self, connections, feed: Feed):
        (term,) = feed.terms
        connection = self._add(
            connections,
            "Connection",
            startElement=term.giver,
            startConnector=term.output.name,
            endElement=feed.taker,
            endConnector=feed.entry.name,
        )
        if not feed.table.units:
            connection.set("suppressUnitConversion", "true")
        # the conversion of units comes from the units themselves
        factor = feed.table.factors[0]
        offset = feed.own_offset
        if factor != 1.0 or offset != 0.0:
            self._add(
                connection,
                "LinearTransformation",
                "ssc",
                factor=repr(float(factor)),
                offset=repr(float(offset)),
            )

    def _units(self):
        if not self.units:
            return
        units = self._add(self.root, "Units")
        for name, unit in sorted(self.units.items()):
            exponents: dict[str, Any] = {base: str(n) for base, n in zip(BASES, unit.exponents) if n}
            if unit.factor != 1.0:
                exponents["factor"] = repr(unit.factor)
            if unit.offset:
                exponents["offset"] = repr(unit.offset)
            self._add(self._add(units, "Unit", "ssc", name=name), "BaseUnit", "ssc", **exponents)

    def _annotation(self):
        """What SSP has no place for."""
        more = {key: value for key, value in self.data.tables().items() if key not in TOGETHER}
        switches = {
            name: {key: value for key, value in table.items() if key not in ("file", "scene", "parameters")}
            for name, table in self.data.tables()["fmu"].items()
        }
        if switches := {name: table for name, table in switches.items() if table}:
            more["fmu"] = switches
        if more:
            annotation = self._add(self._add(self.root, "Annotations"), "Annotation", "ssc", type=ANNOTATION)
            text = etree.SubElement(annotation, "{urn:mbdfmi}toml", nsmap={None: "urn:mbdfmi"})
            text.text = toml_text(more)


def _text(value):
    """A value as XML Schema writes it."""
    if isinstance(value, bool):
        return str(value).lower()
    if isinstance(value, bytes):
        return value.decode()
    return repr(value)
