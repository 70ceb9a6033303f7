"""Forces between two markers, or on one."""

from typing import Annotated, ClassVar

import numpy as np
from pydantic import AfterValidator, Field, model_validator

from ..vocabulary import LOAD_OUTPUTS, SIX_BY_SIX_OUTPUTS, STRUT_OUTPUTS, TORSION_OUTPUTS
from .efforts import AngularSpring
from .ends import BETWEEN, Between, End, stands_still
from .errors import show
from .fields import (
    Array,
    Matrix6,
    NotNegative,
    OneOf,
    Part,
    SomeOf,
    Vector,
    Vector6,
    by_key,
    number_or,
)
from .rare import rare_kinds
from .tables import Ascending, EffortDamper, ForceDamper, ForceOverLength, LoadReading, Table, Vectors


class SpringDamperOptions(Part):
    """A force along the line between two markers.

    stiffness : N/m.
    rest_length : m; None stands for the length at the start.
    table : tension over length, instead of them, or None.
    damping : N s/m; or a table of tension over the speed at which it lengthens.
    """

    exclusive = (("rest_length", "table"),)
    needed = (("stiffness", "table"),)

    stiffness: NotNegative | None = None
    rest_length: NotNegative | None = None
    table: ForceOverLength | None = None
    damping: number_or(NotNegative, ForceDamper) = 0.0


class TorsionOptions(AngularSpring):
    """A moment about the z axis that two markers have in common.

    damping : N m s/rad; or a table of moment over speed.
    """

    damping: number_or(NotNegative, EffortDamper) = 0.0


def _added_mass(rows):
    """The rows of a matrix that may be an added mass, or ValueError."""
    matrix = np.array(rows)
    if matrix.diagonal().min() < 0:
        raise ValueError("has a negative value on its diagonal")

    # compared in units in which the diagonal is 1, since kg, kg m and kg m2 do not compare
    scale = np.sqrt(matrix.diagonal())
    scale[scale == 0] = 1.0
    scaled = matrix / np.outer(scale, scale)

    worst = np.unravel_index(np.abs(scaled - scaled.T).argmax(), (6, 6))
    if abs(scaled - scaled.T)[worst] > 0.01:
        i, j = worst
        raise ValueError(
            f"is not symmetric: [{i + 1}][{j + 1}] is {show(rows[i][j])}, "
            f"[{j + 1}][{i + 1}] is {show(rows[j][i])}"
        )
    if np.linalg.eigvalsh((scaled + scaled.T) / 2)[0] < -1e-6:
        raise ValueError("is not positive semidefinite: some motion would have negative energy")
    return rows


class SixBySix(Part):
    """A wrench on the second marker by (6, 6) matrices, in the first one's axes, order (x, y, z, rx, ry, rz)."""

    def stiffness_matrix(self):
        """(6, 6), zeros when left out."""
        return _matrix(self.stiffness)

    def damping_matrix(self):
        """(6, 6), zeros when left out."""
        return _matrix(self.damping)

    def added_mass_matrix(self):
        """(6, 6), symmetric, zeros without."""
        return np.zeros((6, 6))

    def preload_vector(self):
        """(6,), zeros without."""
        return np.zeros(6)


class LinearOptions(SixBySix):
    """A linear wrench on the second marker, in the first one's axes, order (x, y, z, rx, ry, rz).

    stiffness : (6, 6) in N/m, N, N m/rad; on the displacement from the first marker.
    damping : (6, 6) in N s/m, N s, N m s/rad; on the velocity relative to the first marker.
    added_mass : (6, 6) in kg, kg m, kg m2, about the second marker's origin: water that moves along and has no weight.
        It rests in the frame of the first end: the ground, also one that moves, or "inertial". Its kinetic energy counts as the body's.
    preload : (6,) in N, N m; constant.
    axes : of damping and added mass. "first", the first marker's: as in linear theory of bodies at the surface, the added mass
        exerts -A (acceleration, angular acceleration) and no products of velocities, whatever way the body has turned.
        "heading", those turned about the first marker's z axis by the body's yaw rz: in plane motion as "body". Upside down there is
        no yaw: a run through exactly that ends.
        "body", the second marker's: for a body deep in water (Kirchhoff's equations; moving along with u and w it feels
        Munk's moment).
    """

    stiffness: Matrix6 | None = None
    damping: Matrix6 | None = None
    added_mass: Annotated[
        Matrix6 | None, AfterValidator(lambda rows: rows if rows is None else _added_mass(rows))
    ] = None
    preload: Vector6 | None = None
    axes: OneOf("first", "heading", "body") = "first"

    @model_validator(mode="after")
    def _check_not_empty(self):
        if not self.model_fields_set - {"axes"}:
            raise ValueError('needs one of "stiffness", "damping", "added_mass" or "preload"')
        return self

    def added_mass_matrix(self):
        """(6, 6), symmetric, zeros when left out."""
        matrix = _matrix(self.added_mass)
        return (matrix + matrix.T) / 2

    def preload_vector(self):
        """(6,), zeros when left out."""
        return np.zeros(6) if self.preload is None else np.array(self.preload)


def _matrix(rows):
    """(6, 6) of its rows, of its diagonal, or of None, which is 0."""
    matrix = np.zeros((6, 6)) if rows is None else np.array(rows)
    return np.diag(matrix) if matrix.ndim == 1 else matrix


Block = Array((6,), (6, 6), what="6 numbers, the diagonal [x, y, z, rx, ry, rz], or a 6x6 matrix")


class BushingOptions(SixBySix):
    """An elastic wrench on the second marker, in the first one's axes, (x, y, z, rx, ry, rz).

    stiffness : (6, 6), or its diagonal (6,), in N/m, N, N m/rad.
    damping : (6, 6), or its diagonal (6,), in N s/m, N s, N m s/rad.
    """

    axes: ClassVar[str] = "first"

    stiffness: Block | None = None
    damping: Block | None = None

    @model_validator(mode="after")
    def _check_not_empty(self):
        if not self.model_fields_set:
            raise ValueError('needs "stiffness" or "damping"')
        return self


class LoadOverTime(Table):
    """time : s, and either or both of force : (n, 3) in N, moment : (n, 3) in N m.

    interpolation : between the points, as told above under Tables; before the first and after the last the load is theirs.
    """

    time: Ascending
    force: Vectors | None = None
    moment: Vectors | None = None
    interpolation: LoadReading = "linear"

    @model_validator(mode="after")
    def _check_not_empty(self):
        if self.force is None and self.moment is None:
            raise ValueError('needs "force" or "moment"')
        return self

    def points(self):
        """(time (n,), force (n, 3), moment (n, 3))."""
        zeros = np.zeros((len(self.time), 3))
        force, moment = (zeros if part is None else np.array(part) for part in (self.force, self.moment))
        return np.array(self.time), force, moment


class LoadOptions(Part):
    """A force and a moment at a marker's origin, constant or over time.

    force, moment : (3,) in N and N m.
    axes : "inertial", or "body", which follow the marker.
    table : over time, instead of them, or None.
    """

    exclusive = (("force", "table"), ("moment", "table"))

    force: Vector | None = None
    moment: Vector | None = None
    table: LoadOverTime | None = None
    axes: OneOf("inertial", "body") = "inertial"

    @model_validator(mode="after")
    def _check_not_empty(self):
        if self.force is None and self.moment is None and self.table is None:
            raise ValueError('needs "force", "moment" or "table"')
        return self

    def force_vector(self):
        """(3,) in N, zeros when left out."""
        return np.array(self.force or (0.0, 0.0, 0.0))

    def moment_vector(self):
        """(3,) in N m, zeros when left out."""
        return np.array(self.moment or (0.0, 0.0, 0.0))


class SpringDamper(Part):
    """spring_damper = { stiffness, rest_length, table, damping }

    input : a force (N, tension positive) that acts beside the spring, as of a hydraulic cylinder; stiffness = 0 for one
        without a spring.
    output : length m; rate m/s; tension N, called force too where that is no input; the parts of it that spring, damper and
        input make, N; the power on the bodies, W.
    """

    kind: ClassVar[str] = "spring_damper"

    spring_damper: SpringDamperOptions
    between: Between = Field(description=BETWEEN)
    input: SomeOf("force", bare=True) = []
    output: SomeOf(*STRUT_OUTPUTS) = []

    @model_validator(mode="after")
    def _check_output(self):
        if "input_force" in self.output and not self.input:
            raise ValueError('output "input_force" is that of an input, and there is none')
        return self


class Torsion(Part):
    """torsion = { stiffness, rest, table, damping }

    It resists the angle of the second marker from the first about z, at the start within half a turn (half a turn itself counts as
    180 deg, not -180), then counted over as many
    turns as there come; what it rests at may be turns away. Where the two z axes are not quite parallel, as when a bushing or nothing keeps them so, the angle is what is
    left once the swing from the one to the other is taken away, and the moment acts along z between the two: it stores what it takes.
    They must not become opposite, where no twist is: a run that comes to that place ends there ("no longer finite"), and one that
    passes close by may see the angle jump.

    output : angle (rad), its rate (rad/s), the moment on the second marker about z and the parts of it that spring and damper
        make (N m), the power on the bodies, W.
    """

    kind: ClassVar[str] = "torsion"
    input: ClassVar[tuple] = ()

    torsion: TorsionOptions
    between: Between = Field(description=BETWEEN)
    output: SomeOf(*TORSION_OUTPUTS) = ()


class Bushing(Part):
    """bushing = { stiffness, damping }

    output : force (N) and moment (N m) on the second marker about its origin, its displacement (m) and rotation (rx, ry,
        rz in rad) from the first, all in the first one's axes; the power on the bodies, W.
    """

    kind: ClassVar[str] = "bushing"
    input: ClassVar[tuple] = ()

    bushing: BushingOptions
    between: Between = Field(description=BETWEEN)
    output: SomeOf(*SIX_BY_SIX_OUTPUTS) = ()


class Load(Part):
    """load = { force, moment, axes, table }, on : the end it acts on.

    output : its power, W.
    """

    kind: ClassVar[str] = "load"
    input: ClassVar[tuple] = ()

    load: LoadOptions
    on: End = Field(description='the end it acts on, as in on = "body.marker"')
    output: SomeOf(*LOAD_OUTPUTS) = ()

    @property
    def between(self):
        """The one end."""
        return (self.on,)


class Linear(Part):
    """linear = { stiffness, damping, added_mass, preload, axes }

    output : force (N) and moment (N m) on the second marker about its origin, its displacement (m) and rotation (rx, ry,
        rz in rad) from the first, all in the first one's axes; the power on the bodies, W. What added mass resists
        with is part of the bodies' inertia and not of these.
    """

    kind: ClassVar[str] = "linear"
    input: ClassVar[tuple] = ()

    linear: LinearOptions
    between: Between = Field(description=BETWEEN)
    output: SomeOf(*SIX_BY_SIX_OUTPUTS) = ()

    @model_validator(mode="after")
    def _check_added_mass(self):
        # the inertia of the second body alone takes it up
        if self.linear.added_mass is not None and not stands_still(self.between[0]):
            raise ValueError(
                'with added_mass the first end must be "ground" or a marker of it, '
                f"found {show(self.between)}"
            )
        return self


Force = by_key(
    "a force",
    SpringDamper,
    Torsion,
    Linear,
    Bushing,
    Load,
    *rare_kinds("water", hydrostatics="Hydrostatics"),
    *rare_kinds("sea", hydrodynamics="Hydrodynamics"),
    *rare_kinds("lines", catenary="Catenary"),
    *rare_kinds("sea", member="Member"),
    *rare_kinds("wind", rotor="WindRotor"),
)
