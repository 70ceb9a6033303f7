"""modelDescription.xml of FMI 3.0.

A variable is an array, and its value reference that of its first element among the scalars of FMI 2.0; behind the last of these
stands time.
"""

from collections.abc import Sequence

from lxml import etree

from ..compiler.variables import ArrayVariable, arrays
from . import limits
from .description import (
    INITIAL,
    MOST_LISTED,
    REST,
    add_experiment,
    add_log_categories,
    add_types,
    add_units,
    checked,
    output_order,
    reference_of_rest,
    roles_of,
    set_limits,
    set_type,
    start_of_rest,
    texts_of,
)

CAUSALITIES = ("input", "output", "parameter", "state", "rate", "indicator")

MOST_TOLD = 10_000
"""Dependencies on all that is known that are written in full."""


def description3(model, sources: Sequence[str] = ()) -> bytes:
    """modelDescription.xml of a model, UTF-8, checked against the FMI 3.0 schema.

    sources : files to be compiled, which FMI 3 lists elsewhere. Raises DescriptionError when it is not valid.
    """
    root = etree.Element(
        "fmiModelDescription", fmiVersion="3.0", instantiationToken=model.guid, **texts_of(model)
    )
    found = arrays(model.listed)
    _kinds(root, model)
    units = {"s", *map(_unit, found)}
    add_units(root, units)
    add_types(root, units, 3)
    add_log_categories(root)
    add_experiment(root, model.scene)
    _variables(root, model, found)
    _structure(root, found, [reference_of_rest(model)] if model.rest else [])
    return checked(root, model, 3)


def _kinds(root, model) -> None:
    """Model exchange, where the model can, and co-simulation."""
    common = {
        "modelIdentifier": model.identifier,
        "canGetAndSetFMUState": "true",
        "canSerializeFMUState": "true",
        "providesDirectionalDerivatives": "true",
        "providesAdjointDerivatives": "true",
        "providesPerElementDependencies": "false",
    }

    if model.exchanges:
        etree.SubElement(root, "ModelExchange", needsCompletedIntegratorStep="true", **common)

    etree.SubElement(
        root,
        "CoSimulation",
        canHandleVariableCommunicationStepSize="true",
        maxOutputDerivativeOrder=output_order(model),
        providesIntermediateUpdate="true",
        mightReturnEarlyFromDoStep="true",
        canReturnEarlyAfterIntermediateUpdate="true",
        hasEventMode="true",
        **common,
    )


def _unit(array: ArrayVariable) -> str | None:
    """The unit of all elements; None where they have several."""
    units = {v.unit for v in array.elements}
    return units.pop() if len(units) == 1 else None


def _variables(root, model, found: list[ArrayVariable]) -> None:
    """The variables, time behind them."""
    variables = etree.SubElement(root, "ModelVariables")
    states = {a.elements[0].index: a.first for a in found if a.elements[0].causality == "state"}
    between = limits.limits_of(model)

    for array in found:
        variable = array.elements[0]
        element = etree.SubElement(
            variables,
            "Float64",
            name=array.name,
            valueReference=str(array.first),
            description=variable.description + _units_by_rows(array),
            **roles_of(variable),
        )
        if initial := INITIAL.get(variable.causality, "calculated"):
            element.set("initial", initial)
        set_type(element, _unit(array))
        set_limits(element, limits.widest(between[array.first : array.first + len(array.elements)]))
        if starts := [repr(float(v.start)) for v in array.elements if v.start is not None]:
            element.set("start", " ".join(starts))
        if variable.causality == "state":
            element.set("nominal", repr(max(map(model.nominal_of, array.elements))))
        if variable.causality == "rate":
            element.set("derivative", str(states[variable.index]))
        for size in array.shape:
            etree.SubElement(element, "Dimension", start=str(size))

    etree.SubElement(
        variables,
        "Float64",
        name="time",
        valueReference=str(len(model.listed)),
        description="time",
        causality="independent",
        variability="continuous",
        unit="s",
        declaredType="Time",
    )

    if model.rest:
        reference = str(reference_of_rest(model))
        etree.SubElement(variables, "Boolean", **REST, valueReference=reference, start=start_of_rest(model))


def _units_by_rows(array: ArrayVariable) -> str:
    """What a description says of elements with several units."""
    if len({v.unit for v in array.elements}) == 1:
        return ""

    length = array.shape[-1]
    units = [v.unit or "1" for v in array.elements]
    rows = dict.fromkeys(", ".join(units[k : k + length]) for k in range(0, len(units), length))
    return f" (units by rows: {'; '.join(rows)})"


def _structure(root, found: list[ArrayVariable], booleans: list[int]) -> None:
    """Which outputs there are and what they depend on, by value references, as `description` says it for
    scalars; booleans : those of parameters that are no numbers.

    What depends on all that is known is told so, where that are few: CasADi takes no silence for it.
    """
    structure = etree.SubElement(root, "ModelStructure")
    whole = {array.first + k: array.first for array in found for k in range(len(array.elements))}
    of = {causality: [a for a in found if a.elements[0].causality == causality] for causality in CAUSALITIES}
    inputs, outputs, parameters, states, rates, indicators = of.values()
    known = {a.first: sorted({whole[k] for v in a.elements for k in v.depends}) for a in outputs}
    partial = [given for given in known.values() if len(given) < len(inputs)]
    lists = sum(len(given) + len(parameters) for given in partial) <= MOST_LISTED
    all_parameters = [*(array.first for array in parameters), *booleans]

    everything = [array.first for array in (*inputs, *states)]
    at_start = [*(array.first for array in inputs), *all_parameters]
    told = everything if (len(outputs) + len(rates)) * len(everything) <= MOST_TOLD else None
    told_at_start = at_start if (len(outputs) + 2 * len(rates)) * len(at_start) <= MOST_TOLD else None

    for array in outputs:
        led = sorted({whole[k] for v in array.elements for k in v.led_by})
        given = [*known[array.first], *led]
        _add_unknown(structure, "Output", array.first, told if 0 < len(everything) == len(given) else given)

    for array in rates:
        _add_unknown(structure, "ContinuousStateDerivative", array.first, told)

    for first, given in known.items():
        listed = lists and len(given) < len(inputs)
        _add_unknown(
            structure, "InitialUnknown", first, [*given, *all_parameters] if listed else told_at_start
        )

    for array in [*states, *rates]:
        _add_unknown(structure, "InitialUnknown", array.first, told_at_start)

    for array in indicators:
        _add_unknown(structure, "EventIndicator", array.first, told)


def _add_unknown(structure, section: str, reference: int, known: list[int] | None) -> None:
    """An unknown that depends on some references; None: on all that is known."""
    element = etree.SubElement(structure, section, valueReference=str(reference))

    if known is not None:
        element.set("dependencies", " ".join(map(str, known)))
