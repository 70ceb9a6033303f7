"""What a scene is trimmed to: which of its values are to be found, and what they are found for."""

from typing import Annotated

from pydantic import BeforeValidator, Field, model_validator

from .errors import quoted, show
from .fields import Boolean, Part, number


def _name(value):
    """The name of a variable, or ValueError."""
    if not isinstance(value, str) or not value.strip():
        raise ValueError(f'needs names of variables, as "boom.angle"; found {show(value)}')
    return value.strip()


def _names(value):
    """A list of names, each once, or ValueError."""
    if not isinstance(value, (list, tuple)) or not value:
        raise ValueError(f"needs a list of names; found {show(value)}")

    names = [_name(item) for item in value]
    twice = next((name for name in names if names.count(name) > 1), None)
    if twice:
        raise ValueError(f"{quoted(twice)} is listed twice")
    return names


def _values(value):
    """A table of numbers by names, or ValueError."""
    if not isinstance(value, dict):
        raise ValueError(f'needs a table, as in {{ "shaft.speed" = 1.2 }}; found {show(value)}')

    return {_name(name): _number(name, item) for name, item in value.items()}


def _number(name, value):
    try:
        return number(value)
    except ValueError as error:
        raise ValueError(f"{quoted(name)} {error}") from None


def _found(value):
    if isinstance(value, dict) and not value:
        raise ValueError("needs names of what is to be found; found an empty table")
    return _values(value) if isinstance(value, dict) else _names(value)


def _steady(value):
    if isinstance(value, bool):
        if not value:
            raise ValueError("can only be true or a list of joints; leave it out if it is not wanted")
        return True
    return _names(value)


class Trimming(Part):
    """What makes the scene do as asked (`mbdfmi trim`): values of inputs, of parameters, and of coordinates and speeds of joints at
    the start, for which conditions hold. With `start = "trim"` runs and FMUs start so.

    find : names of the unknowns, or a table of these and of first guesses (SI); without, the search begins at the values that the
        scene has. An input that is found holds that value in a run that gives no other.
    keep : outputs and their values (SI), as { "shaft.acceleration" = 0 }; of joints and bodies also of those that the scene does
        not ask for.
    steady : joints whose speeds shall not change, or true for all.
    rest : whether the conditions hold in the static equilibrium that the scene comes to from its start, instead of at the start.
    """

    find: Annotated[list[str] | dict[str, float], BeforeValidator(_found)] = Field(
        description='what is to be found, as in find = ["lean.angle", "shaft.torque"]'
    )
    keep: Annotated[dict[str, float], BeforeValidator(_values)] = {}
    steady: Annotated[bool | list[str], BeforeValidator(_steady)] = []
    rest: Boolean = False

    @model_validator(mode="after")
    def _check_conditions(self):
        if not self.keep and not self.steady:
            raise ValueError(
                'needs a condition: keep = { "shaft.acceleration" = 0 }, or steady = ["shaft"], joints whose speeds do not change'
            )
        if self.rest and self.steady:
            raise ValueError(
                '"rest" and "steady" exclude each other: at rest nothing moves; keep one of them'
            )
        return self
