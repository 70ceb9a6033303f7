"""What a scene's tables are made of: numbers, arrays, axes, choices, and the tables themselves."""

import math
import weakref
from contextvars import ContextVar
from functools import cache
from typing import Annotated, ClassVar, Union, get_args

import numpy as np
from pydantic import (
    BaseModel,
    BeforeValidator,
    ConfigDict,
    Discriminator,
    Tag,
    ValidationError,
    model_validator,
)
from pydantic_core import core_schema

from ..vectors import dot, norm
from .errors import SceneError, did_you_mean, listed, show
from .messages import TAG, problems_of
from .rare import whole

# Magnitudes beyond are mistakes, and their products would overflow or vanish.
LARGEST = 1e30
SMALLEST = 1 / LARGEST

# Below, rounding is all there is; above, errors are no longer small against the motion.
LEAST_TOLERANCE = 1e-14
LARGEST_TOLERANCE = 0.1

AXES = {"x": (1.0, 0.0, 0.0), "y": (0.0, 1.0, 0.0), "z": (0.0, 0.0, 1.0)}
AXES |= {"-" + name: tuple(-c for c in axis) for name, axis in AXES.items()}


# numbers


def number(value):
    """A finite float of a sane size, or ValueError."""
    if isinstance(value, np.generic):
        value = value.item()
    if isinstance(value, str):
        raise ValueError(f"needs a number, without quotes or a unit; found {show(value)}")
    if isinstance(value, bool) or not isinstance(value, (int, float)):
        raise ValueError(f"needs a number, found {show(value)}")
    if not abs(value) <= LARGEST:
        raise ValueError(f"needs a finite number, at most 1e30; found {show(value)}")
    return float(value)


def _positive(value):
    if number(value) < SMALLEST:
        raise ValueError(f"must be greater than 0, at least 1e-30; found {show(value)}")
    return number(value)


def not_zero(value):
    """Such a number, not 0, or ValueError."""
    if abs(number(value)) < SMALLEST:
        raise ValueError(f"must not be 0, nor below 1e-30; found {show(value)}")
    return number(value)


def _not_negative(value):
    if number(value) < 0:
        raise ValueError(f"must not be negative, found {show(value)}")
    return number(value)


def _tolerance(value):
    if not LEAST_TOLERANCE <= number(value) <= LARGEST_TOLERANCE:
        raise ValueError(f"must be from 1e-14 to 0.1, found {show(value)}")
    return number(value)


Number = Annotated[float, BeforeValidator(number)]
Positive = Annotated[float, BeforeValidator(_positive)]
NotNegative = Annotated[float, BeforeValidator(_not_negative)]
NotZero = Annotated[float, BeforeValidator(not_zero)]
Tolerance = Annotated[float, BeforeValidator(_tolerance)]


# yes and no


def _boolean(value):
    if not isinstance(value, bool):
        raise ValueError(f"needs true or false, found {show(value)}")
    return value


def _flag(value):
    if value is not True:
        raise ValueError(f"can only be true, found {show(value)}; leave it out if it is not wanted")
    return value


Boolean = Annotated[bool, BeforeValidator(_boolean)]
Flag = Annotated[bool, BeforeValidator(_flag)]


# arrays


def array(value, *shapes, what):
    """A nested tuple of floats in one of the shapes, or ValueError; `what` says them in words."""
    if isinstance(value, np.ndarray):
        value = value.tolist()

    for shape in shapes:
        if _has_shape(value, shape):
            return _floats(value, "")

    raise ValueError(f"needs {what}, found {show(value)}")


def _has_shape(value, shape):
    if not shape:
        return not isinstance(value, (list, tuple))
    if not isinstance(value, (list, tuple)) or len(value) != shape[0]:
        return False
    return all(_has_shape(item, shape[1:]) for item in value)


def _floats(value, place):
    if isinstance(value, (list, tuple)):
        return tuple(_floats(item, f"{place}[{i}]") for i, item in enumerate(value, 1))
    try:
        return number(value)
    except ValueError as error:
        raise ValueError(f"{place} {error}") from None


def Array(*shapes, what):
    """The pydantic type of such an array."""
    return Annotated[tuple, BeforeValidator(lambda value: array(value, *shapes, what=what))]


Vector2 = Array((2,), what="2 numbers [x, y]")
Vector = Array((3,), what="3 numbers [x, y, z]")
Matrix6 = Array((6, 6), what="a 6x6 matrix, 6 rows of 6 numbers")
Vector6 = Array((6,), what="6 numbers [x, y, z, rx, ry, rz]")


def _components(value, names, what):
    """An array, or a table of some of its components by name, or ValueError."""
    if not isinstance(value, dict):
        return array(value, (len(names),), what=what)
    if not value:
        raise ValueError(f"needs one of {listed(names, 'or')}; found an empty table")

    return {_choice(name, names): _floats(item, name) for name, item in value.items()}


def Components(names, what):
    """The type of an array that may be given in part, as a table of its components."""
    what = f"{what}, or a table of some of them as in {{ {names[0]} = 1.0 }}"
    check = BeforeValidator(lambda value: _components(value, names, what))
    return Annotated[tuple | dict[str, float], check]


def filled(value, names, default=0.0):
    """The array (n,) of one that may be given in part; what is left out is `default`."""
    if isinstance(value, dict):
        return np.array([value.get(name, default) for name in names])
    return np.array(value)


# axes


def axis(value):
    """An axis as a name or as a vector with a direction, or ValueError."""
    if isinstance(value, str):
        if value not in AXES:
            raise ValueError(
                f"no axis {show(value)}; there are {listed(AXES)}, and vectors [x, y, z]."
                + did_you_mean(value, AXES)
            )
        return value

    vector = array(value, (3,), what='an axis such as "y" or "-z", or a vector [x, y, z]')
    if math.hypot(*vector) < 1e-9:
        raise ValueError(f"an axis needs a direction, found {show(vector)}")
    return vector


Axis = Annotated[str | tuple, BeforeValidator(axis)]


def unit_vector(axis):
    """The unit vector (3,) of an axis written as a name or as a vector."""
    if isinstance(axis, str):
        return np.array(AXES[axis], float)

    return np.array(axis) / norm(axis)


def plane_axes(normal):
    """(3, 3): x in the plane, y in the plane and the unit vector `normal`, by column."""
    helper = np.eye(3)[0 if norm(normal[1:]) > 1e-6 else 1]
    x = helper - normal * dot(normal, helper)
    x /= norm(x)
    return np.column_stack([x, np.cross(normal, x), normal])


# choices


def _choice(value, options):
    if not isinstance(value, str):
        raise ValueError(f"needs {listed(options, 'or')}, found {show(value)}")
    if value not in options:
        raise ValueError(f"no {show(value)} here; there is {listed(options)}." + did_you_mean(value, options))
    return value


def OneOf(*options):
    """The type of a text that is one of the options."""
    return Annotated[str, BeforeValidator(lambda value: _choice(value, options))]


def SomeOf(*options, bare=False):
    """The type of a list of options, each at most once; `bare`: one may stand without the list."""

    def validate(value):
        if isinstance(value, str) and bare:
            value = [value]
        if isinstance(value, str):
            raise ValueError(f"needs a list, found {show(value)}; write [{show(value)}]")
        if not isinstance(value, (list, tuple)):
            raise ValueError(f"needs a list of {listed(options)}, found {show(value)}")

        chosen = []
        for item in value:
            if _choice(item, options) in chosen:
                raise ValueError(f"{show(item)} is listed twice")
            chosen.append(item)
        return chosen

    return Annotated[list[str], BeforeValidator(validate)]


def AllOrSome(*options):
    """The type of true, which stands for all of the options, or of a list of some of them, each at most once."""
    check_list = get_args(SomeOf(*options))[1].func

    def true_or_some(value):
        if isinstance(value, bool):
            return _flag(value)
        if isinstance(value, str) or not isinstance(value, (list, tuple)):
            raise ValueError(f"needs true or a list of {listed(options)}, found {show(value)}")
        if not value:
            raise ValueError(f"needs at least one of {listed(options)}; leave it out if none is wanted")
        return check_list([item for item in value if _choice(item, options)])

    return Annotated[bool | list[str], BeforeValidator(true_or_some)]


# values in one of several units

UNITS = {"": 1.0, "_rad": 1.0, "_deg": np.pi / 180, "_rpm": np.pi / 30}


def in_si(part, key, default=0.0, names=()):
    """The value of a part's key in SI units, by whichever of key, key_deg, ... it is given; `names`: of its components."""
    for unit, factor in UNITS.items():
        value = getattr(part, key + unit, None)
        if value is not None:
            return factor * filled(value, names)
    return default


def as_given(part, key):
    """The value of a part's key as it was written, with its unit where the key names one."""
    for unit in UNITS:
        value = getattr(part, key + unit, None)
        if value is not None:
            return f"{value:g} {unit[1:]}".strip()

    return None


# tables


# the class whose validator is being built
_building: ContextVar[type | None] = ContextVar("_building", default=None)

# classes whose fields name no rare types any more
_whole: weakref.WeakSet = weakref.WeakSet()


class _PartType(type(BaseModel)):
    def __call__(cls, *args, **kwargs):
        # only parts made by hand come here, not those pydantic makes inside another
        try:
            return super().__call__(*args, **kwargs)
        except ValidationError as error:
            raise SceneError(problems_of(error, cls, kwargs)) from None

    def __getattr__(cls, name):
        # what help() and notebooks show of it, also before a scene has such a table
        if name == "__signature__" and cls.model_fields and cls.model_rebuild():
            return cls.__signature__
        return super().__getattr__(name)

    @property
    def model_fields(cls):
        """The fields by name, with the types themselves: what is rare in them is imported."""
        cls.be_whole()
        return cls.__pydantic_fields__

    def be_whole(cls):
        """Imports what is rare in its fields; returns whether there was any."""
        fields = [] if cls in _whole else cls.__pydantic_fields__.values()
        found = [(field, whole(field.annotation)) for field in fields]
        rare = [(field, annotation) for field, annotation in found if annotation is not field.annotation]
        _whole.add(cls)

        for field, annotation in rare:
            field.annotation = annotation
        for base in cls.__mro__ if rare else ():
            hints = vars(base).get("__annotations__", {})
            hints.update({key: whole(hint) for key, hint in hints.items()})
        if rare and cls.__pydantic_complete__:
            cls.model_rebuild(force=True)
        return bool(rare)


class Part(BaseModel, metaclass=_PartType):
    """A table of a scene. What is assigned is checked at once, as if the part were made anew with it; None takes a key out.

    kind : of the classes that share a place, the key that tells which is meant; else None.
    exclusive : groups of keys of which at most one may be given.
    needed : groups of keys of which exactly one must be given.

    Raises SceneError with all that is wrong when it is made.
    """

    model_config = ConfigDict(extra="forbid", defer_build=True)

    kind: ClassVar[str | None] = None
    exclusive: ClassVar[tuple] = ()
    needed: ClassVar[tuple] = ()

    @classmethod
    def model_rebuild(cls, **options):
        """Builds the validator of this class alone."""
        before = _building.set(cls)

        try:
            return super().model_rebuild(**options)
        finally:
            _building.reset(before)

    @classmethod
    def __get_pydantic_core_schema__(cls, source, handler):
        """Inside another part it is checked by a validator of its own, which is built when a scene first has such a table: those
        of all kinds together take longer than a scene.
        """
        if _building.get() is cls:
            return handler(source)

        return core_schema.with_info_plain_validator_function(
            lambda value, info: cls.__pydantic_validator__.validate_python(value, context=info.context),
            ref=f"{cls.__module__}.{cls.__qualname__}:{id(cls)}",
        )

    @classmethod
    def __get_pydantic_json_schema__(cls, schema, handler):
        """That of the class, also where it stands inside another part."""
        if cls.be_whole() or schema["type"] == "function-plain":
            cls.model_rebuild()
            schema = cls.__pydantic_core_schema__

        return handler(schema)

    def __setattr__(self, name, value):
        if name.startswith("_"):
            super().__setattr__(name, value)
            return

        tables = given(self) | {name: given(value)}

        if value is None and name in self.known_keys():
            del tables[name]

        # all other parts stay the objects that they are
        checked = type(self)(**tables)
        self.__dict__[name] = checked.__dict__[name]
        (self.model_fields_set.discard if value is None else self.model_fields_set.add)(name)

    def __dir__(self):
        return [name for name in super().__dir__() if name not in OF_PYDANTIC]

    @classmethod
    @cache
    def known_keys(cls):
        """The keys that the table may have (tuple), the one that tells its kind first."""
        return tuple(sorted(cls.__pydantic_fields__, key=lambda key: key != cls.kind))

    @model_validator(mode="after")
    def _check_alternatives(self):
        for keys in self.exclusive + self.needed:
            given = [key for key in keys if getattr(self, key) is not None]
            if len(given) > 1:
                raise ValueError(f"{listed(given)} exclude each other; keep one of them")
            if not given and keys in self.needed:
                raise ValueError(f"needs {listed(keys, 'or')}")
        return self


OF_PYDANTIC = frozenset(dir(BaseModel)) - frozenset(dir(object))
"""What a part is made with, and users need not see."""


def given(value):
    """What was given of a part, as plain dicts and lists: what was written, assigned or added, not what follows from it."""
    if isinstance(value, Part):
        return {key: given(getattr(value, key)) for key in value.known_keys() if _is_given(value, key)}
    if isinstance(value, dict):
        return {key: given(item) for key, item in value.items()}
    if isinstance(value, (list, tuple)):
        return [given(item) for item in value]
    return value


def adopted(value, checked):
    """A value whose plain tables and lists, as users add them, are those of one that was checked; parts stay the objects that
    they are.
    """
    if isinstance(value, Part):
        for key in value.known_keys():
            value.__dict__[key] = adopted(value.__dict__[key], checked.__dict__[key])
        return value
    if isinstance(value, dict) and isinstance(checked, dict):
        for key in value:
            value[key] = adopted(value[key], checked[key])
        return value
    return checked


def _is_given(part, key):
    value = getattr(part, key)
    if value is None:
        return False
    if key in part.model_fields_set:
        return True
    # a list, a table or a part that was there by default may have got something
    if not (isinstance(value, (list, dict, Part)) and given(value)):
        return False
    return value != type(part).__pydantic_fields__[key].default


def left_out(cls):
    """The part that is there by default, with nothing given. No validator is built for it: every command would wait."""
    return cls.model_construct()


class Empty(Part):
    """A table with no keys, `{}`."""


def by_key(what, *classes):
    """The union of the classes; a table is of the class whose `kind` is one of its keys."""
    kinds = {cls.kind: cls for cls in classes}

    def check(value):
        if isinstance(value, classes):
            return value
        if not isinstance(value, dict):
            raise ValueError(f"{what} needs a table, found {show(value)}")

        given = [key for key in value if key in kinds]
        if len(given) > 1:
            raise ValueError(f"{what} is of one kind, found {listed(given)}; keep one of them")
        if not given:
            near = next(filter(None, (did_you_mean(key, kinds) for key in value)), "")
            found = f"found {listed(value)}" if value else "found an empty table"
            options = listed(kinds, "or", limit=len(kinds))
            raise ValueError(f"{what} needs one of {options}; {found}.{near}")
        return value

    def tag(value):
        if isinstance(value, classes):
            return TAG + value.kind
        return TAG + next(key for key in value if key in kinds)

    union = Union[tuple(Annotated[cls, Tag(TAG + cls.kind)] for cls in classes)]  # noqa: UP007, of as many as there are
    return Annotated[union, Discriminator(tag), BeforeValidator(check)]


def number_or(number_type, cls):
    """The union of a type of number and a class of tables."""
    union = Annotated[number_type, Tag(TAG + "number")] | Annotated[cls, Tag(TAG + "table")]

    def tag(value):
        return TAG + ("table" if isinstance(value, (dict, cls)) else "number")

    return Annotated[union, Discriminator(tag)]
