"""NAME=VALUE on the command line: inputs and parameters of a model."""

import math

from .tables import count


def settings_of(model, settings):
    """NAME=VALUE texts as inputs and parameters, arrays by component. Raises ValueError for what is
    neither.
    """
    from ..compiler.variables import hint, meant
    from ..scene import variable_name

    values = {"input": {}, "parameter": {}}
    variables = {v.name: v for v in model.variables if v.causality in values}

    for setting in settings:
        name, _, text = setting.rpartition("=")

        try:
            numbers = [float(number) for number in text.split(",")]
        except ValueError:
            numbers = []

        if not (name and numbers and all(map(math.isfinite, numbers))):
            raise ValueError(
                f"--set {setting}: write NAME=VALUE with a number, as in --set shoulder.torque=5"
            )

        name = variable_name(name)
        members = meant(name, variables)

        if not members:
            raise ValueError(
                f"--set {setting}: there is no input or parameter {name}; {hint(name, variables)} "
                "(mbdfmi info SCENE --parameters lists them all)"
            )

        if len(numbers) != len(members):
            needs = count(len(members), "number")
            raise ValueError(
                f"--set {setting}: {name} takes {needs} with commas between, found {len(numbers)}"
            )

        for member, number in zip(members, numbers):
            values[variables[member].causality][member] = number

    return values["input"], values["parameter"]
