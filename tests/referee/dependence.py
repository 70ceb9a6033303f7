"""What a model says of itself: which outputs feel which inputs, names and units,
in process and in the FMU."""

import numpy as np
from lxml import etree

from mbdfmi.export.description import description
from mbdfmi.run.instance import SimulationError

from .findings import Finding
from .plan import dice

FELT = 1e-9


def observed(model, instance, way):
    """Findings where an input changes an output at the same instant that does not list it.

    instance : a run in process; it is left as it was.
    """
    outputs, found = model.of_causality("output"), []
    before = instance.outputs().copy()
    allowed = FELT * (1.0 + np.abs(before).max())

    for v in model.of_causality("input"):
        kept = instance.u[v.index]
        instance.u[v.index] = kept + 0.1 * (1.0 + abs(kept)) * (1 + dice(0, v.name).random())

        try:
            changed = np.flatnonzero(np.abs(instance.outputs() - before) > allowed)
        except SimulationError:
            changed = []
        finally:
            instance.u[v.index] = kept

        silent = [
            outputs[k].name
            for k in changed
            if v.index not in outputs[k].depends and not apart(outputs[k].name)
        ]

        if silent:
            text = f"depends on {v.name}, and does not say so" + (
                f"; {len(silent) - 1} more" if silent[1:] else ""
            )
            found.append(Finding("dependence", way, silent[0], instance.time, text=text))

    return found


def apart(name):
    """Outputs about the solver feel all and depend on nothing at once."""
    return name.startswith("solver.")


def told(model):
    """Findings where modelDescription.xml does not tell names, units,
    causality or dependencies of the model."""
    root = etree.fromstring(
        description(model).encode() if isinstance(description(model), str) else description(model)
    )
    variables = root.findall("ModelVariables/ScalarVariable")
    found = []

    def wrong(name, text):
        found.append(Finding("description", "modelDescription.xml", name, text=text))

    if [v.get("name") for v in variables] != [v.name for v in model.listed]:
        wrong("", "other variables than the model's")
        return found

    for xml, v in zip(variables, model.listed):
        real = xml.find("Real")
        causality = "local" if v.causality in ("state", "rate", "indicator") else v.causality

        if xml.get("causality", "local") != causality or real is None or real.get("unit") != v.unit:
            wrong(
                v.name, f"{xml.get('causality')} in {real.get('unit')}; the model: {v.causality} in {v.unit}"
            )

    n_u = len(model.of_causality("input"))
    states = {k for k, v in enumerate(model.listed) if v.causality == "state"}
    parameters = set(range(n_u + len(model.of_causality("output")), len(model.variables)))

    for section, more in (("Outputs", set()), ("InitialUnknowns", parameters)):
        unknowns = {
            int(u.get("index")) - 1: u.get("dependencies")
            for u in root.findall(f"ModelStructure/{section}/Unknown")
        }

        for k, v in enumerate(model.of_causality("output"), n_u):
            if k not in unknowns:
                wrong(v.name, f"not among the {section} of ModelStructure")
                continue

            expected = {*v.depends, *more, *(v.led_by if section == "Outputs" else ())}
            text = unknowns[k]

            # all that is known; at the start that may stand for a list that is too long
            if text is None and section == "InitialUnknowns":
                continue

            found_here = {*range(n_u), *states} if text is None else {int(i) - 1 for i in text.split()}

            if found_here != expected:
                wrong(v.name, f"{section}: depends on {text!r}; the model: {sorted(expected)}")

    return found
