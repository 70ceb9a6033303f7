"""What a user writes: the scene, its schema, reader, checks, and messages that name the place."""

from .bodies import Body, Ground, GroundMarker, Marker
from .errors import Problem, SceneError
from .forces import Force, Linear, SpringDamper
from .joints import Fixed, Free, Joint, Prismatic, Revolute, Spherical
from .names import fmi_name
from .reader import parse_scene, read_scene
from .schema import Scene, Solver
from .writer import write_scene

__all__ = [
    "Body", "Fixed", "Force", "Free", "Ground", "GroundMarker", "Joint", "Linear", "Marker",
    "Prismatic", "Problem", "Revolute", "Scene", "SceneError", "Solver", "Spherical",
    "SpringDamper", "fmi_name", "parse_scene", "read_scene", "write_scene",
]
