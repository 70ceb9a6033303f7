"""Geometric forms, each in its own axes about its centre: of solids and of looks."""

from math import inf
from typing import Annotated

from pydantic import AfterValidator, Field, PlainValidator, field_validator

from .errors import show
from .fields import SMALLEST, Array, NotNegative, Part, Positive, array, not_zero
from .meshes import MeshFile, mesh_file


class SphereGeometry(Part):
    """radius : m."""

    radius: Positive = Field(description="radius in m")


def _lengths(size):
    if min(size) < SMALLEST:
        raise ValueError(f"lengths must be greater than 0, at least 1e-30; found {show(size)}")
    return size


class BoxGeometry(Part):
    """size : lengths of the edges along x, y, z, m."""

    size: Annotated[Array((3,), what="3 lengths [x, y, z]"), AfterValidator(_lengths)] = Field(
        description="lengths of the edges [x, y, z] in m"
    )


class CylinderGeometry(Part):
    """radius, length : m, along z."""

    radius: Positive = Field(description="radius in m")
    length: Positive = Field(description="length along the axis in m")


class TubeGeometry(Part):
    """radius, inner_radius, length : m, along z, open at its ends."""

    radius: Positive = Field(description="outer radius in m")
    inner_radius: NotNegative = Field(description="inner radius in m")
    length: Positive = Field(description="length along the axis in m")

    @field_validator("inner_radius")
    @classmethod
    def _check_wall(cls, inner, info):
        if inner >= info.data.get("radius", inf):
            raise ValueError(
                f"must be smaller than the radius {show(info.data['radius'])}, found {show(inner)}"
            )
        return inner


class CapsuleGeometry(Part):
    """A cylinder along z with half a sphere at each end.

    length : m, of the cylinder between the half spheres.
    """

    radius: Positive = Field(description="radius in m")
    length: Positive = Field(description="length of the cylinder between the half spheres in m")


class ConeGeometry(Part):
    """A cone along z; its centre is half way up.

    radius, top_radius : m, at -length / 2 and at length / 2.
    """

    radius: Positive = Field(description="radius at the bottom in m")
    top_radius: NotNegative = 0.0
    length: Positive = Field(description="length along the axis in m")


MeshName = Annotated[MeshFile, PlainValidator(mesh_file)]


def _scale(value):
    """A factor, or three, none of which is 0; or ValueError."""
    if not isinstance(value, (list, tuple)):
        return not_zero(value)
    factors = array(value, (3,), what="a factor, or 3 of them [x, y, z]")
    if min(map(abs, factors)) < SMALLEST:
        raise ValueError(f"factors must not be 0, found {show(value)}")
    return factors


Scale = Annotated[float | tuple, PlainValidator(_scale)]


class MeshGeometry(Part):
    """Triangles from a file, placed by its own origin.

    file : .stl, .obj, .ply, .off, .glb, .gltf, .3mf, or .dae (which wants pip install pycollada); a relative name starts at the
        folder of the scene file.
    scale : factor from the file's lengths to m, as 0.001 for one in mm; or 3 factors along its axes.
    """

    file: MeshName = Field(description='as in file = "hull.stl"')
    scale: Scale = 1.0
