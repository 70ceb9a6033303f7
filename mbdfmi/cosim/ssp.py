"""What reading and writing of SSP 1.0 (System Structure and Parameterization) share."""

from __future__ import annotations

import os
from functools import cache

from lxml import etree

from .errors import CouplingError

NAMESPACES = {
    "ssc": "http://ssp-standard.org/SSP1/SystemStructureCommon",
    "ssd": "http://ssp-standard.org/SSP1/SystemStructureDescription",
    "ssv": "http://ssp-standard.org/SSP1/SystemStructureParameterValues",
    "ssm": "http://ssp-standard.org/SSP1/SystemStructureParameterMapping",
}

DESCRIPTION = "SystemStructure.ssd"
"""The file in a package that says what is in it."""

ANNOTATION = "io.github.mbdfmi.system"
"""Type of the annotation that carries what SSP has no place for: master, step, record, switches, as TOML."""

SCHEMAS = {
    "ssd": "SystemStructureDescription.xsd",
    "ssv": "SystemStructureParameterValues.xsd",
    "ssm": "SystemStructureParameterMapping.xsd",
}


def tag(space: str, name: str) -> str:
    """The name of an element of a namespace, as lxml has it."""
    return f"{{{NAMESPACES[space]}}}{name}"


@cache
def _schema(space):
    from fmpy.ssp import ssd

    folder = os.path.join(os.path.dirname(ssd.__file__), "schema")
    return etree.XMLSchema(file=os.path.join(folder, SCHEMAS[space]))


def validate(root, space: str, file):
    """Raises CouplingError for what is not as the schema of SSP 1.0 wants it."""
    schema = _schema(space)
    if not schema.validate(root):
        raise CouplingError([f"{file}: line {entry.line}: {entry.message}" for entry in schema.error_log])
