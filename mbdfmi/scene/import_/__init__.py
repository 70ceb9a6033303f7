"""Other people's models, read into the tables of a scene.

A reader gives an `Imported`: tables for the schema, and what a user should know of them. None is ever silent about what it decides or
leaves out.
"""

from .imported import Imported
from .meshes import place_meshes
from .options import UrdfOptions
from .urdf import read_urdf

__all__ = ["Imported", "UrdfOptions", "place_meshes", "read_urdf"]
