"""Coupled systems from packages of SSP 1.0: systems within systems, signal dictionaries, parameter sets and mappings."""

from __future__ import annotations

import posixpath
import tomllib
import zipfile
from collections.abc import Callable
from dataclasses import dataclass
from pathlib import Path
from typing import Any
from urllib.parse import unquote

import fmpy
from lxml import etree

from .errors import CouplingError
from .measures import BASES, Measure, conversion, known
from .signals import Signal, signals_of
from .ssp import ANNOTATION, DESCRIPTION, NAMESPACES, validate

FMU = "application/x-fmu-sharedlibrary"

Key = tuple[tuple[str, ...], str]
"""A connector: the path of its element, and its name."""


@dataclass(frozen=True)
class Edge:
    """A connection: from where, with what transformation."""

    start: Key
    factor: float = 1.0
    offset: float = 0.0
    units: bool = True


def read_ssp(path: Path, folder: Path) -> dict[str, Any]:
    """The tables of the system in a package, whose FMUs are unpacked into the folder. Raises CouplingError."""
    try:
        with zipfile.ZipFile(path) as package:
            return _Reader(path, package, folder).tables()
    except (OSError, zipfile.BadZipFile) as error:
        raise CouplingError(f"{path}: cannot be read: {getattr(error, 'strerror', None) or error}") from error
    except etree.XMLSyntaxError as error:
        raise CouplingError(f"{path}: not valid XML: {error}") from error


class _Reader:
    """One package."""

    def __init__(self, path, package, folder):
        self.path, self.package, self.folder = path, package, folder
        self.components: dict[tuple[str, ...], Any] = {}
        self.edges: dict[Key, Edge] = {}
        self.bindings: list[tuple[tuple[str, ...], Any]] = []
        self.units: dict[str, Measure] = {}
        self.signals: dict[tuple[str, ...], dict[str, Signal]] = {}

    def tables(self):
        """All of it."""
        root = self._xml(DESCRIPTION)
        validate(root, "ssd", f"{self.path}: {DESCRIPTION}")
        self.units = _units(root, "ssd:Units/ssc:Unit")
        system = root.find("ssd:System", NAMESPACES)
        self._system(system, ())
        names = self._names()
        fmus = {names[key]: {"file": str(self._unpacked(key))} for key in self.components}
        self._set_parameters(names, fmus)
        tables: dict[str, Any] = {
            "name": root.get("name") or "system",
            "fmu": fmus,
            "link": list(self._links(names)),
        }
        experiment = root.find("ssd:DefaultExperiment", NAMESPACES)
        if experiment is not None:
            run = {"start": experiment.get("startTime"), "stop": experiment.get("stopTime")}
            tables["run"] = {key: float(value) for key, value in run.items() if value is not None}
            if "stop" in tables["run"]:
                start = tables["run"].get("start", 0.0)
                tables["run"]["step"] = (tables["run"]["stop"] - start) / 1000
        self._annotations(root, tables)
        return tables

    def _error(self, text):
        return CouplingError(f"{self.path}: {text}")

    def _xml(self, name):
        try:
            data = self.package.read(name)
        except KeyError:
            raise self._error(f"has no {name}") from None
        return etree.fromstring(data, etree.XMLParser(resolve_entities=False, no_network=True))

    # structure

    def _system(self, system, path):
        """Components, connections and parameters of a system and of those within it."""
        self._bindings_of(system, path)
        dictionaries = {}

        for element in system.iterfind("ssd:Elements/*", NAMESPACES):
            kind, name = etree.QName(element).localname, element.get("name")
            own = (*path, name)
            if kind == "Component":
                self.components[own] = element
                self._bindings_of(element, own)
            elif kind == "System":
                self._system(element, own)
            else:
                dictionaries[name] = ("", element.get("dictionary"))

        for connection in system.iterfind("ssd:Connections/ssd:Connection", NAMESPACES):
            start, end = (
                self._key(
                    path, connection.get(f"{side}Element"), connection.get(f"{side}Connector"), dictionaries
                )
                for side in ("start", "end")
            )
            self._connect(connection, start, end)

    @staticmethod
    def _key(path, element, connector, dictionaries) -> Key:
        if element is None:
            return path, connector
        return dictionaries.get(element, (*path, element)), connector

    def _connect(self, connection, start, end):
        factor, offset = 1.0, 0.0
        for child in connection:
            kind = etree.QName(child).localname
            if kind == "LinearTransformation":
                factor, offset = float(child.get("factor", 1)), float(child.get("offset", 0))
            elif kind.endswith("MappingTransformation"):
                raise self._error(f"{_text(end)}: a {kind} is not known here; only linear ones are")

        units = connection.get("suppressUnitConversion", "false") not in ("true", "1")
        if end in self.edges and end[0] in self.components:
            raise self._error(f"{_text(end)} is connected twice")
        self.edges[end] = Edge(start, factor, offset, units)

    def _names(self):
        """Names of components: their own where they are alone, else with those of their systems."""
        last = [key[-1] for key in self.components]
        return {
            key: (key[-1] if last.count(key[-1]) == 1 else "_".join(key)).replace(".", "_")
            for key in self.components
        }

    def _unpacked(self, key) -> Path:
        """The FMU of a component."""
        element = self.components[key]
        kind, source = element.get("type", FMU), unquote(element.get("source"))
        name = posixpath.normpath(source)
        if kind != FMU or ":" in source or name.startswith(("..", "/")):
            raise self._error(f"{'.'.join(key)}: {source} ({kind}) is no FMU in the package")
        target = self.folder / name.replace("/", "_")
        if not target.exists():
            try:
                target.write_bytes(self.package.read(name))
            except KeyError:
                raise self._error(f"{'.'.join(key)}: the package has no {name}") from None
        return target

    def _links(self, names):
        """Connections from FMU to FMU, whatever they go through."""
        for key, element in self.components.items():
            for connector in element.iterfind("ssd:Connectors/ssd:Connector", NAMESPACES):
                end = key, connector.get("name")
                if connector.get("kind") not in ("input", "inout", "parameter") or end not in self.edges:
                    continue
                start, factor, offset, units = self._traced(end)
                if start is None:
                    continue
                link: dict[str, Any] = {
                    "source": f"{names[start[0]]}.{start[1]}",
                    "target": f"{names[key]}.{end[1]}",
                }
                if factor != 1.0:
                    link["factor"] = factor
                if offset != 0.0:
                    link["offset"] = offset
                if not units:
                    link["units"] = False
                yield link

    def _traced(self, end):
        """(connector of an FMU or None, factor, offset, whether units count) of what a connector gets."""
        factor, offset, units, seen = 1.0, 0.0, True, {end}
        while True:
            edge = self.edges.get(end)
            if edge is None:
                # an input of the system itself
                return None, factor, offset, units
            offset += factor * edge.offset
            factor *= edge.factor
            units &= edge.units
            end = edge.start
            if end[0] in self.components:
                return end, factor, offset, units
            if end in seen:
                raise self._error(f"{_text(end)}: its connections go in a circle")
            seen.add(end)

    # parameters

    def _bindings_of(self, element, path):
        self.bindings += [
            (path, binding)
            for binding in element.iterfind("ssd:ParameterBindings/ssd:ParameterBinding", NAMESPACES)
        ]

    def _set_parameters(self, names, fmus):
        """Values of all bindings; those of inner elements first, so that outer ones count."""
        for path, binding in sorted(self.bindings, key=lambda pair: -len(pair[0])):
            prefix = binding.get("prefix", "")
            for name, value, unit in self._values(binding):
                key, variable = self._found(path, f"{prefix}{name}")
                if key is None:
                    raise self._error(
                        f"parameter {prefix}{name} of {'.'.join(path) or 'the system'}: no such component"
                    )
                signal = self._signals(key).get(variable)
                if signal is not None and signal.unit is not None and unit is not None:
                    value = self._converted(value, unit, signal, variable)
                fmus[names[key]].setdefault("parameters", {})[variable] = value

    def _found(self, path, name):
        """(component, variable) of a parameter's name below an element."""
        if path in self.components:
            return path, name
        for key in sorted(self.components, key=len, reverse=True):
            inner = ".".join(key[len(path) :]) + "."
            if key[: len(path)] == path and name.startswith(inner):
                return key, name[len(inner) :]
        return None, name

    def _values(self, binding):
        """(name, value, unit or None) of a binding, its mapping done."""
        root = None
        if binding.get("source"):
            root = self._xml(posixpath.normpath(unquote(binding.get("source"))))
            validate(root, "ssv", f"{self.path}: {binding.get('source')}")
        else:
            root = binding.find("ssd:ParameterValues/ssv:ParameterSet", NAMESPACES)
        if root is None:
            return []

        units = self.units | _units(root, "ssv:Units/ssc:Unit")
        values = {}
        for parameter in root.iterfind("ssv:Parameters/ssv:Parameter", NAMESPACES):
            for child in parameter:
                kind = etree.QName(child).localname
                if kind in READ:
                    unit = child.get("unit")
                    measure = (units.get(unit) or known(unit)) if unit else None
                    values[parameter.get("name")] = READ[kind](child.get("value")), measure
        return self._mapped(binding, values)

    def _mapped(self, binding, values):
        element = binding.find("ssd:ParameterMapping", NAMESPACES)
        if element is None:
            return [(name, *pair) for name, pair in values.items()]
        if element.get("source"):
            mapping = self._xml(posixpath.normpath(unquote(element.get("source"))))
        else:
            mapping = element.find("ssm:ParameterMapping", NAMESPACES)

        found = []
        for entry in mapping.iterfind("ssm:MappingEntry", NAMESPACES):
            if entry.get("source") not in values:
                continue
            value, unit = values[entry.get("source")]
            linear = entry.find("ssc:LinearTransformation", NAMESPACES)
            if linear is not None:
                value = float(linear.get("factor", 1)) * value + float(linear.get("offset", 0))
            suppressed = entry.get("suppressUnitConversion", "false") in ("true", "1")
            found.append((entry.get("target"), value, None if suppressed else unit))
        return found

    def _signals(self, key):
        if key not in self.signals:
            try:
                description = fmpy.read_model_description(str(self._unpacked(key)), validate=False)
            except Exception as error:
                raise self._error(f"{'.'.join(key)}: no FMU: {error}") from error
            self.signals[key] = signals_of(description)
        return self.signals[key]

    def _converted(self, value, unit, signal, variable):
        if not unit.fits(signal.unit):
            raise self._error(
                f"parameter {variable}: is given in {unit.name}, the FMU has it in {signal.unit_name}"
            )
        factor, offset = conversion(unit, signal.unit)
        return factor * value + offset

    def _annotations(self, root, tables):
        """What this package's own writer added."""
        for annotation in root.iterfind("ssd:Annotations/ssc:Annotation", NAMESPACES):
            if annotation.get("type") != ANNOTATION:
                continue
            more = tomllib.loads("".join(annotation.itertext()))
            for name, switches in more.pop("fmu", {}).items():
                tables["fmu"].get(name, {}).update(switches)
            tables.update(more)


READ: dict[str, Callable[[str], Any]] = {
    "Real": float,
    "Integer": int,
    "Boolean": lambda text: text in ("true", "1"),
    "String": str,
    "Enumeration": str,
}


def _units(root, place):
    found = {}
    for unit in root.iterfind(place, NAMESPACES):
        base = unit.find("ssc:BaseUnit", NAMESPACES)
        exponents = tuple(int(base.get(name, 0)) for name in BASES)
        numbers = float(base.get("factor", 1)), float(base.get("offset", 0))
        found[unit.get("name")] = Measure(unit.get("name"), exponents, *numbers)
    return found


def _text(key):
    path, name = key
    return ".".join([*filter(None, path), name])
