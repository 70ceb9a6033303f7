"""Orientations, written in any of five ways, and places."""

from typing import Annotated, ClassVar

import numpy as np
from pydantic import AfterValidator, Field

from ..rotations import Rotation
from ..vectors import dot, norm
from .errors import listed
from .fields import Array, Axis, Number, OneOf, Part, Vector, unit_vector

ANGLES = "3 angles [yaw, pitch, roll]"


def unit_euler_parameters(values):
    """The values (4,) if their length is near 1, or ValueError."""
    length = np.linalg.norm(values)
    if abs(length - 1) > 1e-3:
        raise ValueError(
            f"Euler parameters [E1, E2, E3, E4], scalar last, have unit length; found {length:.6g}"
        )
    return values


def _axes(axes):
    if len(axes) != 2:
        raise ValueError(f'needs two of "x", "y" and "z", found {listed(axes) or "none"}')

    first, second = (unit_vector(axis) for axis in axes.values())
    if np.linalg.norm(np.cross(first, second)) < 1e-6:
        raise ValueError(f"{listed(axes)} are parallel")
    return axes


class AxisAngle(Part):
    """A rotation by an angle about an axis."""

    needed = (("angle_deg", "angle_rad"),)

    axis: Axis = Field(description='the axis, as in axis = "y"')
    angle_deg: Number | None = Field(None, description="degrees")
    angle_rad: Number | None = Field(None, description="rad")

    def rotation(self):
        angle = np.radians(self.angle_deg) if self.angle_rad is None else self.angle_rad
        return Rotation.from_rotvec(angle * unit_vector(self.axis))


class Oriented(Part):
    """The orientation of a frame in another, the base: none, or one of five ways to write it.

    euler_parameters : E1, E2, E3, E4, scalar last; normalised when within 1e-3 of unit length.
    zyx_deg, zyx_rad : yaw, pitch, roll; A = Rz(yaw) Ry(pitch) Rx(roll).
    axis_angle : rotation from the base about an axis.
    axes : two of the frame's axes in the base. The first is kept, the second made normal to it.
    """

    exclusive: ClassVar[tuple] = (("euler_parameters", "zyx_deg", "zyx_rad", "axis_angle", "axes"),)

    euler_parameters: Annotated[
        Array((4,), what="4 numbers [E1, E2, E3, E4], scalar last") | None,
        AfterValidator(lambda values: values if values is None else unit_euler_parameters(values)),
    ] = None
    zyx_deg: Array((3,), what=ANGLES + " in degrees") | None = None
    zyx_rad: Array((3,), what=ANGLES + " in rad") | None = None
    axis_angle: AxisAngle | None = None
    axes: Annotated[dict[OneOf("x", "y", "z"), Axis], AfterValidator(_axes)] | None = None

    def rotation(self):
        """The Rotation A: components in the frame to components in the base."""
        if self.euler_parameters is not None:
            return Rotation.from_quat(self.euler_parameters)
        if self.zyx_deg is not None:
            return Rotation.from_euler("ZYX", self.zyx_deg, degrees=True)
        if self.zyx_rad is not None:
            return Rotation.from_euler("ZYX", self.zyx_rad)
        if self.axis_angle is not None:
            return self.axis_angle.rotation()
        if self.axes is not None:
            return Rotation.from_matrix(_matrix_of_axes(self.axes))
        return Rotation.identity()


def _matrix_of_axes(axes):
    """A (3, 3) from two named axes of it, the first of which is kept."""
    (name, first), (second_name, second) = (
        ("xyz".index(key), unit_vector(axis)) for key, axis in axes.items()
    )
    second = second - first * dot(first, second)

    columns = np.empty((3, 3))
    columns[name] = first
    columns[second_name] = second / norm(second)

    # the third completes a right-handed frame
    third = 3 - name - second_name
    columns[third] = np.cross(columns[(third + 1) % 3], columns[(third + 2) % 3])
    return columns.T


class Placed(Oriented):
    """A frame: its origin and orientation in another, the base.

    position : m, in the base.
    """

    position: Vector = (0.0, 0.0, 0.0)

    def pose(self):
        """(position (3,) in m in the base, A (3, 3): frame axes to base axes)."""
        return np.array(self.position), self.rotation().as_matrix()
