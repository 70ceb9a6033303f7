"""Hulls that water carries."""

from typing import Annotated, ClassVar

from pydantic import BeforeValidator, Field, model_validator

from ..vocabulary import HYDROSTATICS_OUTPUTS
from .ends import End
from .errors import show
from .fields import Part, SomeOf, number
from .geometry import BoxGeometry, CylinderGeometry, MeshGeometry
from .meshes import closed_mesh
from .orientation import Placed


def _sides(value):
    if number(value) != int(value) or not 3 <= value <= 1000:
        raise ValueError(f"must be a whole number from 3 to 1000, found {show(value)}")
    return number(value)


Sides = Annotated[float, BeforeValidator(_sides)]


class HullCylinder(CylinderGeometry):
    """A cylinder along z as a prism of `sides` equal sides and of the same volume.

    sides : the second moments of its cross-section are 5e-7 too large with 64 sides, by 1 / sides^4 less with more; lying down it
        displaces up to 5e-6 of the whole too little or too much, by 1 / sides^3 less with more.
    """

    sides: Sides = 64.0


class HullMesh(MeshGeometry):
    """A closed surface of triangles. One that is not closed is refused, its largest hole named."""

    @model_validator(mode="after")
    def _check_closed(self):
        self.closed()
        return self

    def closed(self):
        """The `trimesh.Trimesh`, its triangles turning left seen from outside. Raises ValueError."""
        return closed_mesh(self.file, self.scale, "a hull")


class HydrostaticsOptions(Placed):
    """The hull that water acts on, in the axes of the end it is on.

    box, cylinder, mesh : its outside, all of it: what is inside is dry. Its place is that of its centre, of a mesh that of the
        file's origin.
    """

    needed: ClassVar[tuple] = (("box", "cylinder", "mesh"),)

    box: BoxGeometry | None = None
    cylinder: HullCylinder | None = None
    mesh: HullMesh | None = None


class Hydrostatics(Part):
    """hydrostatics = { box | cylinder | mesh, position, zyx_deg, ... }, on : the end that the hull is fixed to.

    Buoyancy at any angle, of what is under the plane z = 0 of the inertial frame: weight of what is displaced, through its
    centre. Gravity must point along -z. The energy that it takes to press the hull down is part of the potential energy.
    Waves do not change it; the water that moves along, and what damps, are for linear forces beside it.

    output : displaced volume (m3) and its centre (m); draught, the depth of the lowest point (m, negative in the air); area (m2),
        centre (m) and second moments (m4) of the waterplane about its centre; force (N) and moment (N m) about the end's
        origin; all in the inertial frame; the power on the body, W.
    """

    kind: ClassVar[str] = "hydrostatics"
    input: ClassVar[tuple] = ()

    hydrostatics: HydrostaticsOptions
    on: End = Field(description='the end that the hull is fixed to, as in on = "body.marker"')
    output: SomeOf(*HYDROSTATICS_OUTPUTS) = ()

    @property
    def between(self):
        """The one end."""
        return (self.on,)
