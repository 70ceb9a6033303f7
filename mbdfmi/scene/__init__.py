"""What a user writes: the data of a scene, its schema, reader, checks, and messages that name the place.

A user meets them as `mbdfmi.Scene`, which can also be run and exported.
"""

from importlib import import_module
from typing import TYPE_CHECKING

from .bodies import Body, Ground, GroundMarker, Marker
from .errors import Problem, SceneError
from .joints import (
    Cylindrical,
    Fixed,
    Free,
    Joint,
    Planar,
    Prismatic,
    Revolute,
    Screw,
    Spherical,
    Translation,
    Universal,
)
from .names import fmi_name, variable_name
from .reader import parse_scene, read_scene
from .schema import SceneData, Solver
from .writer import write_scene

if TYPE_CHECKING:
    from .constraints import (
        Angle,
        ConstantVelocity,
        Distance,
        KnifeEdge,
        PointOnLine,
        PointOnPlane,
        RollingDisk,
        RollingSphere,
    )
    from .couplings import Coupling, Gear, LinearCoupling, Rack, ScrewCoupling
    from .end_frames import (
        CurveOnCurve,
        FrameOnCurve,
        FrameOnSurface,
        PointOnCurve,
        PointOnSurface,
        RollingSurface,
        SurfaceOnSurface,
    )
    from .forces import Bushing, Force, Linear, Load, SpringDamper
    from .lines import Catenary
    from .measures import Measure
    from .prescribed import Prescribed
    from .sea import Hydrodynamics, Member, Sea
    from .water import Hydrostatics
    from .wind import Wind, WindRotor

__all__ = [
    "Angle",
    "Body",
    "Bushing",
    "Catenary",
    "ConstantVelocity",
    "Coupling",
    "CurveOnCurve",
    "Cylindrical",
    "Distance",
    "Fixed",
    "Force",
    "FrameOnCurve",
    "FrameOnSurface",
    "Free",
    "Gear",
    "Ground",
    "GroundMarker",
    "Hydrodynamics",
    "Hydrostatics",
    "Joint",
    "KnifeEdge",
    "Linear",
    "LinearCoupling",
    "Load",
    "Marker",
    "Measure",
    "Member",
    "Planar",
    "PointOnCurve",
    "PointOnLine",
    "PointOnPlane",
    "PointOnSurface",
    "Prescribed",
    "Prismatic",
    "Problem",
    "Rack",
    "Revolute",
    "RollingDisk",
    "RollingSphere",
    "RollingSurface",
    "SceneData",
    "SceneError",
    "Screw",
    "ScrewCoupling",
    "Sea",
    "Solver",
    "Spherical",
    "SpringDamper",
    "SurfaceOnSurface",
    "Translation",
    "Universal",
    "Wind",
    "WindRotor",
    "fmi_name",
    "parse_scene",
    "read_scene",
    "variable_name",
    "write_scene",
]

_RARE = {
    "constraints": (
        "Angle",
        "ConstantVelocity",
        "Distance",
        "KnifeEdge",
        "PointOnLine",
        "PointOnPlane",
        "RollingDisk",
        "RollingSphere",
    ),
    "couplings": (
        "Coupling",
        "Gear",
        "LinearCoupling",
        "Rack",
        "ScrewCoupling",
    ),
    "end_frames": (
        "CurveOnCurve",
        "FrameOnCurve",
        "FrameOnSurface",
        "PointOnCurve",
        "PointOnSurface",
        "RollingSurface",
        "SurfaceOnSurface",
    ),
    "forces": (
        "Bushing",
        "Force",
        "Linear",
        "Load",
        "SpringDamper",
    ),
    "lines": ("Catenary",),
    "measures": ("Measure",),
    "prescribed": ("Prescribed",),
    "sea": (
        "Hydrodynamics",
        "Member",
        "Sea",
    ),
    "water": ("Hydrostatics",),
    "wind": (
        "Wind",
        "WindRotor",
    ),
}
"""Names of those that are imported when they are asked for, by modules (rare.py)."""


def __getattr__(name):
    module = next((module for module, names in _RARE.items() if name in (module, *names)), None)

    if module is None:
        raise AttributeError(f"module {__name__!r} has no attribute {name!r}")

    found = import_module(f".{module}", __name__)
    return found if name == module else getattr(found, name)


def __dir__():
    return sorted({*globals(), *_RARE, *__all__})
