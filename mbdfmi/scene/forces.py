"""Forces between two markers."""

from typing import Annotated, ClassVar

import numpy as np
from pydantic import AfterValidator, Field, model_validator

from .ends import BETWEEN, Between, stands_still
from .errors import show
from .fields import Matrix6, NotNegative, Part, SomeOf, Vector6, by_key


class SpringDamperOptions(Part):
    """A force along the line between two markers.

    stiffness : N/m. damping : N s/m.
    rest_length : m; None stands for the length at the start.
    """

    stiffness: NotNegative = Field(description="stiffness in N/m")
    damping: NotNegative = 0.0
    rest_length: NotNegative | None = None


def _added_mass(rows):
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


class LinearOptions(Part):
    """A linear wrench on the second marker, in the first one's axes, order (x, y, z, rx, ry, rz).

    stiffness : (6, 6) in N/m, N, N m/rad; on the displacement from the first marker.
    damping : (6, 6) in N s/m, N s, N m s/rad; on the velocity relative to the first marker.
    added_mass : (6, 6) in kg, kg m, kg m2, in the second marker's axes about its origin.
    preload : (6,) in N, N m; constant.
    """

    stiffness: Matrix6 | None = None
    damping: Matrix6 | None = None
    added_mass: Annotated[
        Matrix6 | None, AfterValidator(lambda rows: rows if rows is None else _added_mass(rows))
    ] = None
    preload: Vector6 | None = None

    @model_validator(mode="after")
    def _check_not_empty(self):
        if not self.model_fields_set:
            raise ValueError('needs one of "stiffness", "damping", "added_mass" or "preload"')
        return self

    def stiffness_matrix(self):
        """(6, 6), zeros when left out."""
        return _matrix(self.stiffness)

    def damping_matrix(self):
        """(6, 6), zeros when left out."""
        return _matrix(self.damping)

    def added_mass_matrix(self):
        """(6, 6), symmetric, zeros when left out."""
        matrix = _matrix(self.added_mass)
        return (matrix + matrix.T) / 2

    def preload_vector(self):
        """(6,), zeros when left out."""
        return np.zeros(6) if self.preload is None else np.array(self.preload)


def _matrix(rows):
    return np.zeros((6, 6)) if rows is None else np.array(rows)


class ForceBase(Part):
    """A force between two markers.

    between : the two ends.
    output : names of what goes out.
    """

    between: Between = Field(description=BETWEEN)


class SpringDamper(ForceBase):
    """spring_damper = { stiffness, damping, rest_length }. Outputs: length m, force N (tension)."""

    kind: ClassVar[str] = "spring_damper"

    spring_damper: SpringDamperOptions
    output: SomeOf("length", "force") = []


class Linear(ForceBase):
    """linear = { stiffness, damping, added_mass, preload }"""

    kind: ClassVar[str] = "linear"
    output: ClassVar[tuple] = ()

    linear: LinearOptions

    @model_validator(mode="after")
    def _check_added_mass(self):
        # the inertia of the second body alone takes it up
        if self.linear.added_mass is not None and not stands_still(self.between[0]):
            raise ValueError(
                'with added_mass the first end must be "ground" or a marker of it, '
                f"found {show(self.between)}"
            )
        return self


Force = by_key("a force", SpringDamper, Linear)
