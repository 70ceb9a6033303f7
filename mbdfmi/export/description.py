"""modelDescription.xml of FMI 2.0: what a tool reads about an FMU; and what FMI 3.0 has in common with it."""

import os
from datetime import UTC, datetime
from functools import cache
from importlib.metadata import PackageNotFoundError, version

from lxml import etree

from ..units import UNITS
from . import standard

LOG_CATEGORIES = {
    "logEvents": "Life of the instance: initialisation, reset, termination",
    "logStatusWarning": "What to know of the model and its start (always sent)",
    "logStatusDiscard": "Messages of calls that return Discard",
    "logStatusError": "Messages of calls that return Error (always sent)",
    "logStatusFatal": "Messages of calls that return Fatal (always sent)",
    "logAll": "All messages",
}

STOP_TIME = 10.0  # s, only a proposal to the tool
STEP_SIZE = 0.01  # s, likewise

# dependencies at the start that are written in all, about 0.5 MB
MOST_LISTED = 100_000


class DescriptionError(Exception):
    """The description does not keep to the FMI schema; the text lists where."""


def description(model) -> bytes:
    """modelDescription.xml of a model, UTF-8, checked against the FMI 2.0 schema.

    Raises DescriptionError when it is not valid.
    """
    root = etree.Element(
        "fmiModelDescription",
        fmiVersion="2.0",
        guid=model.guid,
        numberOfEventIndicators="0",
        **texts_of(model),
    )

    _co_simulation(root, model)
    add_units(root, {v.unit for v in model.variables})
    add_log_categories(root)
    add_experiment(root)
    _variables(root, model)
    _structure(root, model)

    return checked(root, model, 2)


def checked(root, model, fmi: int) -> bytes:
    """The XML as UTF-8. Raises DescriptionError where it does not keep to the schema of this version of FMI."""
    schema = _schema(fmi)
    if not schema.validate(root):
        faults = "\n".join(f"  line {error.line}: {error.message}" for error in schema.error_log)
        raise DescriptionError(f"modelDescription.xml of '{model.name}' is not valid:\n{faults}")

    return etree.tostring(root, xml_declaration=True, encoding="UTF-8", pretty_print=True)


def texts_of(model) -> dict[str, str]:
    """Attributes of the root that both versions have."""
    return {
        "modelName": model.name,
        "description": model.description or model.title or model.name,
        "generationTool": f"mbdfmi {tool_version()}",
        "generationDateAndTime": generation_time().strftime("%Y-%m-%dT%H:%M:%SZ"),
        "variableNamingConvention": "structured",
    }


def tool_version() -> str:
    """Version of mbdfmi."""
    try:
        return version("mbdfmi")
    except PackageNotFoundError:
        return "(not installed)"


def generation_time() -> datetime:
    """Now, or the time (s since 1970) that the environment variable SOURCE_DATE_EPOCH fixes."""
    fixed = os.environ.get("SOURCE_DATE_EPOCH")

    return datetime.fromtimestamp(int(fixed), UTC) if fixed else datetime.now(UTC)


@cache
def _schema(fmi: int) -> etree.XMLSchema:
    """The schema of a version of FMI, which fmpy carries."""
    folder = standard.folder() / "schema" / f"fmi{fmi}"

    return etree.XMLSchema(file=str(folder / f"fmi{fmi}ModelDescription.xsd"))


def _co_simulation(root, model) -> None:
    etree.SubElement(
        root,
        "CoSimulation",
        modelIdentifier=model.identifier,
        needsExecutionTool="false",
        canHandleVariableCommunicationStepSize="true",
        canInterpolateInputs="true",
        maxOutputDerivativeOrder="0",
        canRunAsynchronuously="false",
        canBeInstantiatedOnlyOncePerProcess="false",
        canNotUseMemoryManagementFunctions="true",
        canGetAndSetFMUstate="true",
        canSerializeFMUstate="true",
        providesDirectionalDerivative="false",
    )


def add_units(root, used: set[str | None]) -> None:
    """Definitions of the units that occur."""
    names = sorted(name for name in used if name)
    if not names:
        return

    definitions = etree.SubElement(root, "UnitDefinitions")
    for name in names:
        unit = UNITS[name]
        exponents = {"kg": unit.kg, "m": unit.m, "s": unit.s, "rad": unit.rad}
        element = etree.SubElement(definitions, "Unit", name=name)

        etree.SubElement(element, "BaseUnit", {k: str(n) for k, n in exponents.items() if n})
        for display, factor in unit.display:
            etree.SubElement(element, "DisplayUnit", name=display, factor=repr(factor))


def add_log_categories(root) -> None:
    """What the log may tell of."""
    categories = etree.SubElement(root, "LogCategories")

    for name, text in LOG_CATEGORIES.items():
        etree.SubElement(categories, "Category", name=name, description=text)


def add_experiment(root) -> None:
    """What a tool may propose for a run."""
    etree.SubElement(
        root, "DefaultExperiment", startTime="0", stopTime=repr(STOP_TIME), stepSize=repr(STEP_SIZE)
    )


INITIAL = {"output": "calculated", "parameter": "exact"}  # an input has none


def _variables(root, model) -> None:
    """The variables; a value reference is the position in the model's list."""
    variables = etree.SubElement(root, "ModelVariables")

    for reference, variable in enumerate(model.variables):
        element = etree.SubElement(
            variables,
            "ScalarVariable",
            name=variable.name,
            valueReference=str(reference),
            description=variable.description,
            causality=variable.causality,
            variability=variable.variability,
        )
        if variable.causality in INITIAL:
            element.set("initial", INITIAL[variable.causality])

        real = etree.SubElement(element, "Real")
        if variable.unit:
            real.set("unit", variable.unit)
        if variable.start is not None:
            real.set("start", repr(float(variable.start)))


def _structure(root, model) -> None:
    """Which outputs there are and what they depend on; indices count from 1.

    At the start that is the same inputs and all parameters. An Unknown without `dependencies` depends on all that is known
    (FMI 2.0.4, 2.2.8), so this is not written where it is so, nor where it would take more than MOST_LISTED.
    """
    structure = etree.SubElement(root, "ModelStructure")
    outputs = [(i, v) for i, v in enumerate(model.variables, 1) if v.causality == "output"]

    if not outputs:
        return

    inputs = len(model.of_causality("input"))
    parameters = range(inputs + len(outputs), len(model.variables))
    partial = [v for _, v in outputs if len(v.depends) < inputs]
    lists = sum(len(v.depends) + len(parameters) for v in partial) <= MOST_LISTED
    all_parameters = " ".join(str(k + 1) for k in parameters)
    now, start = (etree.SubElement(structure, section) for section in ("Outputs", "InitialUnknowns"))

    for index, variable in outputs:
        known = " ".join(str(k + 1) for k in variable.depends)
        etree.SubElement(now, "Unknown", index=str(index), dependencies=known)
        unknown = etree.SubElement(start, "Unknown", index=str(index))

        if lists and len(variable.depends) < inputs:
            unknown.set("dependencies", f"{known} {all_parameters}".strip())
