"""Parameters that are made constants of a model: an FMU shows them, nobody sets them, and code made for the
model has their values in it.
"""

from collections.abc import Sequence
from dataclasses import replace

from ..run.inputs import known
from ..scene import variable_name
from ..scene.code import ALL


def bound(model, names: Sequence[str]):
    """The model with some parameters as constants. names : of parameters, or of arrays of them; `ALL` stands
    for all but start values and those of the solver. Raises KeyError for what is no parameter, ValueError for
    what a run must be able to change.
    """
    parameters = [v.name for v in model.of_causality("parameter")]
    chosen = set()

    for name in names:
        if name == ALL:
            chosen |= {each for each in parameters if not (_is_of_solver(each) or _is_start(each))}
        else:
            chosen |= set(known(variable_name(name), parameters, "parameter"))

    if found := sorted(filter(_is_of_solver, chosen)):
        raise ValueError(
            f"{found[0]!r} cannot be bound: a master's tolerance may change what the solver keeps to"
        )

    variables = [
        replace(v, causality="constant", variability="constant") if v.name in chosen else v
        for v in model.variables
    ]
    return replace(model, variables=variables) if chosen else model


def _is_of_solver(name):
    return name.startswith("solver.")


def _is_start(name):
    return name.partition("[")[0].endswith("_start")
