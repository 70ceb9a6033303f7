"""What a user writes: the data of a scene, its schema, reader, checks, and messages that name the place.

A user meets them as `mbdfmi.Scene`, which can also be run and exported.
"""

from .bodies import Body, Ground, GroundMarker, Marker
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
from .errors import Problem, SceneError
from .forces import Bushing, Force, Linear, Load, SpringDamper
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
from .lines import Catenary
from .measures import Measure
from .names import fmi_name, variable_name
from .prescribed import Prescribed
from .reader import parse_scene, read_scene
from .schema import SceneData, Solver
from .sea import Hydrodynamics, Member, Sea
from .water import Hydrostatics
from .wind import Wind, WindRotor
from .writer import write_scene

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
