"""Bodies, their markers, and the ground."""

from typing import TYPE_CHECKING, Annotated

import numpy as np
from pydantic import AfterValidator, BeforeValidator, model_validator

from ..vectors import dot
from ..vocabulary import GROUND_OUTPUTS, MARKER_INPUTS, MARKER_OUTPUTS
from .errors import listed
from .fields import Array, NotNegative, OneOf, Part, SomeOf, Vector
from .looks import Shown
from .names import Name
from .orientation import Oriented, Placed
from .rare import rare
from .solids import Solid, composite

if TYPE_CHECKING:
    from .curves import Curve
    from .motion import Motion
    from .surfaces import Surface
else:
    (Curve,), (Surface,), (Motion,) = (
        rare("curves", "Curve"),
        rare("surfaces", "Surface"),
        rare("motion", "Motion"),
    )

# Published moments are rounded, so a flat plate may miss the triangle inequality by this part.
MOMENTS_ROUNDED = 0.01


def inertia_matrix(inertia):
    """The tensor (3, 3) of [ixx, iyy, izz], of [ixx, iyy, izz, ixy, ixz, iyz], or as it is."""
    values = np.array(inertia)
    if values.shape == (3, 3):
        return (values + values.T) / 2
    if values.shape == (3,):
        return np.diag(values)

    xx, yy, zz, xy, xz, yz = values
    return np.array([[xx, xy, xz], [xy, yy, yz], [xz, yz, zz]])


def _inertia(inertia):
    values = np.array(inertia)
    largest = np.abs(values).max()

    if values.shape == (3, 3) and np.abs(values - values.T).max() > 1e-6 * largest:
        raise ValueError("the matrix is not symmetric")

    moments = np.linalg.eigvalsh(inertia_matrix(inertia))
    if moments[0] < -1e-9 * largest:
        found = principal_moments(moments)
        raise ValueError(f"no principal moment is negative on a real body; {found}")
    return inertia


def principal_moments(moments):
    """Moments (3,) in words."""
    return "the principal moments are [" + ", ".join(f"{m:.6g}" for m in moments) + "]"


Inertia = Annotated[
    Array(
        (3,),
        (6,),
        (3, 3),
        what="[ixx, iyy, izz], [ixx, iyy, izz, ixy, ixz, iyz] or a symmetric 3x3 matrix",
    ),
    AfterValidator(_inertia),
]


class InertiaAxes(Oriented):
    """The axes in which an inertia is given, in the body's axes."""


class Observed(Part):
    """A frame on a body, with what goes in and out there.

    output : names of MARKER_OUTPUTS.
    input : "force" (N) and "moment" (N m) at the frame's origin, in the axes of input_axes.
    input_axes : "inertial" or "body".
    """

    output: SomeOf(*MARKER_OUTPUTS) = []
    input: SomeOf(*MARKER_INPUTS) = []
    input_axes: OneOf("inertial", "body") = "inertial"

    @model_validator(mode="after")
    def _check_input_axes(self):
        if "input_axes" in self.model_fields_set and not self.input:
            raise ValueError('input_axes without an input; add input = ["force", "moment"]')
        return self


class Shaped(Shown, Placed):
    """A frame that may carry a curve, a surface and a look.

    curve, surface : in the frame's axes, or None.
    """

    curve: Curve | None = None
    surface: Surface | None = None


class GroundMarker(Shaped):
    """A frame on the ground, its position and orientation in the ground's."""


class Marker(Observed, Shaped):
    """A frame on a body, its position and orientation in the body's own frame."""


def _as_list(value):
    if isinstance(value, (list, tuple)):
        if not value:
            raise ValueError("is an empty list; a body needs at least one solid")
        return list(value)
    return None if value is None else [value]


class Massive(Part):
    """Mass, centre of mass and inertia, or solids.

    mass : kg. 0, without inertia, makes a mere frame: it must carry other bodies, or the joints, couplings and drivers around
        it must determine how it moves, as those of a pulley, of a rod between two ball joints, or of a driven end frame do.
    com : centre of mass (3,) in m in the body's own frame.
    inertia : kg m2 about the centre of mass; entries of the tensor, so ixy = I[0][1]. Of a point mass [0, 0, 0], or
        solid = { point = { mass = 1 } }.
    inertia_axes : orientation of the axes that the inertia is given in; the body's when left out.
    solid : one solid or a list of them.
    """

    needed = (("mass", "solid"),)

    mass: NotNegative | None = None
    com: Vector = (0.0, 0.0, 0.0)
    inertia: Inertia | None = None
    inertia_axes: InertiaAxes | None = None
    solid: Annotated[list[Solid] | None, BeforeValidator(_as_list)] = None

    @model_validator(mode="after")
    def _check_mass(self):
        own = [key for key in ("com", "inertia", "inertia_axes") if key in self.model_fields_set]
        if self.solid and own:
            raise ValueError(f"the solid gives {listed(own)} already; keep one of them")
        if self.mass and self.inertia is None:
            raise ValueError("inertia is missing; for a point mass write inertia = [0, 0, 0]")
        return self

    def mass_properties(self):
        """(mass kg, com (3,) m, inertia (3, 3) kg m2 about the com), in the body's own axes."""
        if self.solid:
            return composite([solid.mass_properties() for solid in self.solid])

        if self.inertia is None:
            return self.mass, np.array(self.com), np.zeros((3, 3))

        inertia = inertia_matrix(self.inertia)

        if self.inertia_axes:
            A = self.inertia_axes.rotation().as_matrix()
            inertia = dot(A, inertia, A.T)

        return self.mass, np.array(self.com), inertia


class Body(Shown, Observed, Massive):
    """A rigid body with its own frame, its markers by name, and what goes in and out."""

    marker: dict[Name, Marker] = {}


class Ground(Shown):
    """The frame of the assembly, with markers on it by name.

    motion : of it in the inertial frame, or None: it is the inertial frame.
    output : the force (N) and the moment about its origin (N m) with which all joints and forces together act on it (added
        masses too), and the weight of what is fixed to it; in its own axes. One that moves bears the contrary of what moves it.
    """

    motion: Motion | None = None
    output: SomeOf(*GROUND_OUTPUTS) = []
    marker: dict[Name, GroundMarker] = {}
