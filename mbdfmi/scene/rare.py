"""Types of tables that few scenes have: their modules are imported when a scene first has such a table.

A class takes pydantic half a millisecond to make, there are 240 of them, and every command would wait for them all.
"""

import operator
import sys
from functools import cached_property, reduce
from importlib import import_module
from typing import Annotated, Union, get_args, get_origin

from pydantic import TypeAdapter
from pydantic_core import core_schema


class Rare:
    """Stands in annotations for a type of a module of this package.

    kind : of one of the classes that share a place, its `kind` (fields.by_key).
    """

    def __init__(self, module, name, kind=None):
        self._module, self._name, self.kind = f"{__package__}.{module}", name, kind

    @cached_property
    def type(self):
        """The type itself, imported now."""
        found = getattr(import_module(self._module), self._name)
        assert self.kind is None or self.kind == found.kind
        return found

    def __instancecheck__(self, value):
        # before the import nothing is of the type
        return self._module in sys.modules and isinstance(value, self.type)

    def __or__(self, other):
        return Union[self, other]  # noqa: UP007, it is no type

    def __repr__(self):
        return f"{self._module}.{self._name}"

    @cached_property
    def _union(self):
        return TypeAdapter(self.type)

    def __get_pydantic_core_schema__(self, source, handler):
        def check(value, info):
            # that of a class is another one as soon as it is built
            validator = (
                self.type.__pydantic_validator__ if isinstance(self.type, type) else self._union.validator
            )
            return validator.validate_python(value, context=info.context)

        return core_schema.with_info_plain_validator_function(check)

    def __get_pydantic_json_schema__(self, schema, handler):
        if isinstance(self.type, type):
            return self.type.__get_pydantic_json_schema__(schema, handler)
        return handler(self._union.core_schema)


def rare(module, *names):
    """What stands for types of a module (list)."""
    return [Rare(module, name) for name in names]


def rare_kinds(module, **names):
    """What stands for the classes of some kinds (tuple), kind="name of the class"."""
    return tuple(Rare(module, name, kind) for kind, name in names.items())


def whole(annotation):
    """The annotation with the types themselves, imported now."""
    if isinstance(annotation, Rare):
        return whole(annotation.type)

    arguments, origin = get_args(annotation), get_origin(annotation)
    found = tuple(map(whole, arguments[:1] if origin is Annotated else arguments))

    if all(new is old for new, old in zip(found, arguments)):
        return annotation
    if origin is Annotated:
        return Annotated[(*found, *arguments[1:])]

    return (
        origin[found]
        if isinstance(origin, type) and issubclass(origin, (dict, list))
        else reduce(operator.or_, found)
    )


CONSTRAINTS = rare_kinds(
    "constraints",
    point_on_plane="PointOnPlane",
    point_on_line="PointOnLine",
    distance="Distance",
    rolling_sphere="RollingSphere",
    rolling_disk="RollingDisk",
    knife_edge="KnifeEdge",
    constant_velocity="ConstantVelocity",
    angle="Angle",
)
"""Joints that only constrain."""


END_FRAMES = rare_kinds(
    "end_frames",
    point_on_curve="PointOnCurve",
    curve_on_curve="CurveOnCurve",
    point_on_surface="PointOnSurface",
    frame_on_curve="FrameOnCurve",
    frame_on_surface="FrameOnSurface",
    surface_on_surface="SurfaceOnSurface",
    rolling_surface="RollingSurface",
)
"""Joints with an end on a curve or a surface."""
