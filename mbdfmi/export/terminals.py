"""terminalsAndIcons/terminalsAndIcons.xml: what belongs together at a flange, of FMI 3.0 and, by its own words, of FMI 2.0.4 on.

A terminal is what inputs that are efforts act on, a marker, a joint, a spring: the efforts, which flow in, and the outputs that
tell how it moves. Where its rates are outputs, efforts times rates are the power that it takes in.
"""

import itertools
import re
from collections.abc import Iterator

from lxml import etree

from ..compiler.variables import ArrayVariable, arrays, dotted
from . import standard

NAME = "terminalsAndIcons/terminalsAndIcons.xml"
ICON = "terminalsAndIcons/icon.png"

EFFORTS = ("N", "N.m")
MOTIONS = {"m", "rad", "m/s", "rad/s", "m/s2", "rad/s2"}
ORIENTATIONS = {"euler_parameters", "zyx"}

_IN_OWN_AXES = {"velocity", "acceleration", "omega", "alpha"}
"""Outputs of markers that are there in inertial axes, and with `_body` in their own."""


def terminals(model, fmi: int) -> bytes:
    """The file of a model, UTF-8, checked against the schema of FMI 3.0; fmi: 2 names scalars, 3 arrays."""
    root = etree.Element("fmiTerminalsAndIcons", fmiVersion="3.0")
    graphics = etree.SubElement(root, "GraphicalRepresentation")
    corners = {"x1": "-100", "y1": "-100", "x2": "100", "y2": "100"}
    etree.SubElement(graphics, "CoordinateSystem", corners, suggestedScalingFactorTo_mm="0.1")
    etree.SubElement(graphics, "Icon", corners)

    if found := list(_terminals(model)):
        section = etree.SubElement(root, "Terminals")

        for name, about, members in found:
            element = etree.SubElement(section, "Terminal", name=name, matchingRule="bus", description=about)
            for array, kind in members:
                for variable in [array.name] if fmi == 3 else [v.name for v in array.elements]:
                    etree.SubElement(
                        element,
                        "TerminalMemberVariable",
                        variableName=variable,
                        memberName=_parted(variable)[1],
                        variableKind=kind,
                    )

    standard.schema(3, "fmi3TerminalsAndIcons").assertValid(root)
    return etree.tostring(root, xml_declaration=True, encoding="UTF-8", pretty_print=True)


def _terminals(model) -> Iterator[tuple[str, str, list[tuple[ArrayVariable, str]]]]:
    """Of each terminal its name, what it is, and its members, each with its kind."""
    axes = _axes_of_inputs(model.scene)
    springs = {dotted(name) for name in model.scene.force}
    told = [a for a in arrays(model.listed) if a.elements[0].causality in ("input", "output")]
    told.sort(key=lambda array: _parted(array.name)[0])

    for owner, group in itertools.groupby(told, lambda array: _parted(array.name)[0]):
        members = list(group)
        efforts = [a for a in members if a.elements[0].causality == "input" and a.elements[0].unit in EFFORTS]
        motions = [a for a in members if _tells_motion(a, axes.get(owner))]

        if owner and efforts and motions:
            # tension takes power out where its spring lengthens
            kind, what = ("outflow", "tension") if owner in springs else ("inflow", "efforts")
            about = f"flange {owner}: {what} and how it moves"
            yield owner, about, [*((a, kind) for a in efforts), *((a, "signal") for a in motions)]


def _parted(name: str) -> tuple[str, str]:
    """What a variable is of, and its last word."""
    owner, _, word = name.rpartition(".")
    return owner, word


def _tells_motion(array: ArrayVariable, axes: str | None) -> bool:
    """Whether it is an output that tells how its owner moves, in the axes of its inputs."""
    word = re.sub(r"\[.*", "", _parted(array.name)[1])
    first = array.elements[0]

    if first.causality != "output" or not (first.unit in MOTIONS or word in ORIENTATIONS):
        return False

    if axes == "body":
        return word not in _IN_OWN_AXES

    return not word.endswith("_body")


def _axes_of_inputs(scene) -> dict[str, str]:
    """Axes of inputs by the name of the body or marker that they act on."""
    bodies = {dotted(name): body.input_axes for name, body in scene.body.items()}
    markers = {
        dotted(name, mark): marker.input_axes
        for name, body in scene.body.items()
        for mark, marker in body.marker.items()
    }
    return bodies | markers
