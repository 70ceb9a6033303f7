"""modelDescription.xml of FMI 2.0: what a tool reads about an FMU; and what FMI 3.0 has in common with it."""

import os
from collections.abc import Sequence
from datetime import UTC, datetime
from functools import cache
from importlib.metadata import PackageNotFoundError, version

from lxml import etree

from ..units import UNITS
from . import limits, standard

LOG_CATEGORIES = {
    "logEvents": "Life of the instance: initialisation, reset, termination",
    "logStatusWarning": "What to know of the model and its start (always sent)",
    "logStatusDiscard": "Messages of calls that return Discard",
    "logStatusError": "Messages of calls that return Error (always sent)",
    "logStatusFatal": "Messages of calls that return Fatal (always sent)",
    "logAll": "All messages",
}

# dependencies at the start that are written in all, about 0.5 MB
MOST_LISTED = 100_000


class DescriptionError(Exception):
    """The description does not keep to the FMI schema; the text lists where."""


def description(model, sources: Sequence[str] = ()) -> bytes:
    """modelDescription.xml of a model, UTF-8, checked against the FMI 2.0 schema.

    sources : names of the files in sources/ that are compiled. Raises DescriptionError when it is not valid.
    """
    root = etree.Element(
        "fmiModelDescription",
        fmiVersion="2.0",
        guid=model.guid,
        numberOfEventIndicators=str(len(model.of_causality("indicator"))),
        **texts_of(model),
    )

    _kinds(root, model, sources)
    units = {v.unit for v in model.listed}
    add_units(root, units)
    add_types(root, units, 2)
    add_log_categories(root)
    add_experiment(root, model.scene)
    _variables(root, model)
    _structure(root, model)

    return checked(root, model, 2)


def checked(root, model, fmi: int) -> bytes:
    """The XML as UTF-8. Raises DescriptionError where it does not keep to the schema of this version of FMI."""
    schema = standard.schema(fmi, f"fmi{fmi}ModelDescription")
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


@cache
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


def _kinds(root, model, sources) -> None:
    """Model exchange, where the model can, and co-simulation."""
    common = {
        "modelIdentifier": model.identifier,
        "needsExecutionTool": "false",
        "canBeInstantiatedOnlyOncePerProcess": "false",
        "canNotUseMemoryManagementFunctions": "true",
        "canGetAndSetFMUstate": "true",
        "canSerializeFMUstate": "true",
        "providesDirectionalDerivative": "true",
    }

    if model.exchanges:
        etree.SubElement(root, "ModelExchange", completedIntegratorStepNotNeeded="false", **common)

    etree.SubElement(
        root,
        "CoSimulation",
        canHandleVariableCommunicationStepSize="true",
        canInterpolateInputs="true",
        maxOutputDerivativeOrder=output_order(model),
        canRunAsynchronuously="false",
        **common,
    )

    for kind in root if sources else ():
        files = etree.SubElement(kind, "SourceFiles")

        for name in sources:
            etree.SubElement(files, "File", name=name)


def output_order(model) -> str:
    """The highest derivative of outputs by time: none where inputs command motions, whose course is not known."""
    return "0" if model.n_command else "2"


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


def add_types(root, used: set[str | None], fmi: int) -> None:
    """Definitions of the quantities that occur, each by its unit: a type that its variables declare."""
    quantities = {UNITS[name].quantity: name for name in sorted(name for name in used if name)}
    quantities.pop("", None)
    if not quantities:
        return

    definitions = etree.SubElement(root, "TypeDefinitions")
    for quantity, unit in sorted(quantities.items()):
        if fmi == 2:
            kind = etree.SubElement(etree.SubElement(definitions, "SimpleType", name=quantity), "Real")
        else:
            kind = etree.SubElement(definitions, "Float64Type", name=quantity)

        kind.set("quantity", quantity)
        set_unit(kind, unit)


def set_type(element, unit: str | None) -> None:
    """The quantity of a variable, and its unit once more for those who do not look up types."""
    if unit and UNITS[unit].quantity:
        element.set("declaredType", UNITS[unit].quantity)

    set_unit(element, unit)


def set_unit(element, unit: str | None) -> None:
    """The unit of a variable, and the one to show it in: angles are shown in degrees."""
    if unit:
        element.set("unit", unit)

        if UNITS[unit].rad and UNITS[unit].display:
            element.set("displayUnit", UNITS[unit].display[0][0])


def set_limits(element, found: limits.Limits) -> None:
    """The least and the largest value of a variable."""
    for name, value in zip(("min", "max"), found):
        if value is not None:
            element.set(name, repr(value))


def add_log_categories(root) -> None:
    """What the log may tell of."""
    categories = etree.SubElement(root, "LogCategories")

    for name, text in LOG_CATEGORIES.items():
        etree.SubElement(categories, "Category", name=name, description=text)


def add_experiment(root, scene) -> None:
    """What a tool may propose for a run of a scene; the tolerance is the solver's where nothing else is said."""
    experiment, solver = scene.experiment, scene.solver
    tolerance = experiment.tolerance or (None if solver.fixed_step else solver.tolerance)
    element = etree.SubElement(
        root, "DefaultExperiment", startTime=repr(experiment.start), stopTime=repr(experiment.stop)
    )

    if tolerance:
        element.set("tolerance", repr(tolerance))

    element.set("stepSize", repr(experiment.step))


INITIAL = {"input": None, "local": None, "parameter": "exact", "constant": "exact"}
"""`initial` of a variable by its causality in the model; of all others "calculated", which is so of locals without a word."""


def roles_of(variable) -> dict[str, str]:
    """Causality and variability as FMI knows them; nothing of the many local variables, which have those by default."""
    if variable.causality == "local":
        return {}

    known = variable.causality in ("input", "output", "parameter")
    causality = variable.causality if known else "local"
    return {"causality": causality, "variability": variable.variability}


def _variables(root, model) -> None:
    """The variables; a value reference is the position in the model's list."""
    variables = etree.SubElement(root, "ModelVariables")
    states = {v.index: k for k, v in enumerate(model.listed, 1) if v.causality == "state"}

    for reference, (variable, between) in enumerate(zip(model.listed, limits.limits_of(model))):
        element = etree.SubElement(
            variables,
            "ScalarVariable",
            name=variable.name,
            valueReference=str(reference),
            description=variable.description,
            **roles_of(variable),
        )
        if initial := INITIAL.get(variable.causality, "calculated"):
            element.set("initial", initial)

        real = etree.SubElement(element, "Real")
        set_type(real, variable.unit)
        set_limits(real, between)
        if variable.start is not None:
            real.set("start", repr(float(variable.start)))
        if variable.causality == "state":
            real.set("nominal", repr(model.nominal_of(variable)))
        if variable.causality == "rate":
            real.set("derivative", str(states[variable.index]))

    if model.rest:
        element = etree.SubElement(
            variables, "ScalarVariable", **REST, valueReference=str(reference_of_rest(model))
        )
        etree.SubElement(element, "Boolean", start=start_of_rest(model))


REST = {
    "name": "solver.start_at_equilibrium",
    "description": "Whether it starts at the static equilibrium of the scene; start values of joints do not "
    "act then",
    "causality": "parameter",
    "variability": "fixed",
    "initial": "exact",
}
"""The Boolean parameter of a model that offers a start at rest."""


def reference_of_rest(model) -> int:
    """Its value reference: behind the numbers, and the time of FMI 3.0 (fmu_src/rest.c)."""
    return len(model.listed) + 1


def start_of_rest(model) -> str:
    """Its start value."""
    return "true" if model.rest.asked else "false"


def _structure(root, model) -> None:
    """Which outputs there are and what they depend on; indices count from 1.

    At the start that is the same inputs and all parameters. An Unknown without `dependencies` depends on all that is known
    (FMI 2.0.4, 2.2.8), as rates do, so this is not written where it is so: lists of all states for all outputs of a long chain
    would grow as its square. Nor is it written at the start where it would take more than MOST_LISTED.
    """
    structure = etree.SubElement(root, "ModelStructure")
    numbered = list(enumerate(model.listed, 1))
    outputs = [(k, v) for k, v in numbered if v.causality == "output"]
    rates = [k for k, v in numbered if v.causality == "rate"]
    states = [k for k, v in numbered if v.causality == "state"]
    inputs = len(model.of_causality("input"))
    parameters = [k for k, v in numbered if v.causality == "parameter"]
    parameters += [len(numbered) + 1] if model.rest else []
    partial = [v for _, v in outputs if len(v.depends) < inputs]
    lists = sum(len(v.depends) + len(parameters) for v in partial) <= MOST_LISTED
    all_parameters = " ".join(map(str, parameters))
    sections = {name: etree.Element(name) for name in ("Outputs", "Derivatives", "InitialUnknowns")}

    for index, variable in outputs:
        unknown = etree.SubElement(sections["Outputs"], "Unknown", index=str(index))

        if not 0 < inputs + len(states) == len(variable.depends) + len(variable.led_by):
            unknown.set("dependencies", " ".join(str(k + 1) for k in variable.depends + variable.led_by))

        unknown = etree.SubElement(sections["InitialUnknowns"], "Unknown", index=str(index))

        if lists and len(variable.depends) < inputs:
            known = " ".join(str(k + 1) for k in variable.depends)
            unknown.set("dependencies", f"{known} {all_parameters}".strip())

    for index in rates:
        etree.SubElement(sections["Derivatives"], "Unknown", index=str(index))

    for index in [*states, *rates]:
        etree.SubElement(sections["InitialUnknowns"], "Unknown", index=str(index))

    for section in sections.values():
        if len(section):
            structure.append(section)
