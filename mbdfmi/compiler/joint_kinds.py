"""What each kind of joint is made of: one record a kind.

What its coordinates are called, and their units, is said where users meet the words: `coordinates` of its class in
scene/joints.py.
"""

from collections.abc import Callable
from dataclasses import dataclass
from typing import NamedTuple

import numpy as np

from ..kernels.dynamics import rows
from ..kernels.joints import KINDS, N_V
from ..vocabulary import Coordinate
from .frames import axes_with_z
from .variables import subscripts

ONE_AXIS = ("revolute", "prismatic")
"""Simple motions along or about an axis: one coordinate each."""

POSES = ("spherical", "free")
"""Simple motions whose position is more than numbers each by itself: an orientation is in it."""

Z = np.array([0.0, 0.0, 1.0])


def _along_axis(joint):
    """The joint's axis, for each of its motions."""
    return [joint.axis] * len(kind_of(joint).motions)


def _turned_to_axis(joint):
    """z of both markers along the joint's axis."""
    return [axes_with_z(joint.axis)] * 2


def _as_they_are(joint):
    """Both markers' own axes."""
    return [np.eye(3)] * 2


def _between_markers(joint, k):
    """z of the marker axes along coordinate k's axis, seen from the first marker."""
    return axes_with_z(kind_of(joint).axes(joint)[k]), (0, 1)


@dataclass(frozen=True)
class JointKind:
    """What a kind of joint is made of.

    motions : simple motions one after another, kinds of the kernels' joints; none where it only takes freedoms away.
    axes : joint -> the motions' axes (3,) in the markers' axes.
    led : joint -> {coordinate: (the one that it follows, its ratio to that)}, in SI.
    rows : (kind, axis of the first marker, axis of the second) of each equation when it closes a loop; what is about positions
        comes first: where rows repeat each other, those about velocities alone go.
    rows_too : joint -> those beside them that depend on how it is written.
    turns : joint -> rotation matrices (3, 3) that bring the axes of its two markers to those that the rows are about.
    value : joint -> what the rows keep, m or a cosine; None: the distance of its ends at the start.
    frame : joint, k -> (turn (3, 3) of the markers' axes, (which marker is seen from, which is seen)) by which coordinate k is read
        off between the markers where the joint is not in the tree: along or about their z.
    """

    motions: tuple[str, ...] = ()
    axes: Callable = _along_axis
    led: Callable = lambda joint: {}
    rows: tuple[tuple[int, int, int], ...] = ()
    rows_too: Callable = lambda joint: ()
    turns: Callable = _turned_to_axis
    value: Callable = lambda joint: 0.0
    frame: Callable = _between_markers

    @property
    def in_trees(self) -> bool:
        """Whether a tree can be made of it."""
        return bool(self.motions)

    @property
    def is_one_axis(self) -> bool:
        """Whether it is one motion of a kind of ONE_AXIS: it may be driven and coupled."""
        return len(self.motions) == 1 and self.motions[0] in ONE_AXIS

    @property
    def is_pose(self) -> bool:
        """Whether it is one motion of a kind of POSES."""
        return len(self.motions) == 1 and self.motions[0] in POSES

    def freedoms(self, joint) -> int:
        """Velocities that it leaves free."""
        return sum(N_V[KINDS[motion]] for motion in self.motions) - len(self.led(joint))


def _screw_led(joint):
    """A screw's position follows from its angle."""
    return {0: (1, joint.pitch / (2 * np.pi))}


def _universal_frame(joint, k):
    """A universal joint's angles are those of one side's axis about the other's."""
    axis, other = joint.axes[k], joint.axes[1 - k]
    z = axis if k == 0 else -axis
    return np.column_stack([other, np.cross(z, other), z]), (0, 1) if k == 0 else (1, 0)


ALIGNED = ((rows.DOT, 0, 2), (rows.DOT, 1, 2))  # z of both markers parallel
LOCKED = ((rows.DOT, 0, 1), (rows.DOT, 1, 2), (rows.DOT, 2, 0))  # all axes parallel
TOGETHER = tuple((rows.POINT, axis, 0) for axis in range(3))  # origins together
IN_X_AND_Y = TOGETHER[:2]
IN_Z = TOGETHER[2:]


def _no_axis(joint):
    return [Z]


JOINT_KINDS = {
    "fixed": JointKind(("fixed",), _no_axis, rows=(*TOGETHER, *LOCKED)),
    "revolute": JointKind(("revolute",), rows=(*TOGETHER, *ALIGNED)),
    "prismatic": JointKind(("prismatic",), rows=(*IN_X_AND_Y, *LOCKED)),
    "cylindrical": JointKind(("prismatic", "revolute"), rows=(*IN_X_AND_Y, *ALIGNED)),
    "screw": JointKind(("prismatic", "revolute"), led=_screw_led, rows=(*IN_X_AND_Y, *ALIGNED)),
    "universal": JointKind(
        ("revolute", "revolute"),
        axes=lambda joint: joint.axes,
        rows=(*TOGETHER, (rows.DOT, 2, 2)),
        turns=lambda joint: [axes_with_z(axis) for axis in joint.axes],
        frame=_universal_frame,
    ),
    "planar": JointKind(
        ("prismatic", "prismatic", "revolute"), axes=lambda joint: joint.axes.T, rows=(*IN_Z, *ALIGNED)
    ),
    "translation": JointKind(("prismatic",) * 3, axes=lambda joint: np.eye(3), rows=LOCKED),
    "spherical": JointKind(("spherical",), _no_axis, rows=TOGETHER),
    "free": JointKind(("free",), _no_axis),
    "prescribed": JointKind(
        ("prismatic",) * 3 + ("revolute",) * 3, axes=lambda joint: np.eye(3)[[0, 1, 2, 2, 1, 0]]
    ),
    "point_on_plane": JointKind(rows=IN_Z),
    "point_on_line": JointKind(rows=IN_X_AND_Y),
    "distance": JointKind(rows=((rows.DISTANCE, 0, 0),), value=lambda joint: joint.length),
    "rolling_sphere": JointKind(
        rows=tuple((rows.ROLL_SPHERE, axis, 0) for axis in (2, 0, 1)),
        turns=lambda joint: [np.eye(3), axes_with_z(joint.axis)],
        value=lambda joint: joint.radius,
    ),
    "rolling_disk": JointKind(
        rows=tuple((rows.ROLL_DISK, axis, 0) for axis in (2, 0, 1)),
        turns=lambda joint: [np.eye(3), axes_with_z(joint.axis)],
        value=lambda joint: joint.radius,
    ),
    "knife_edge": JointKind(rows=((rows.KNIFE, 0, 2),)),
    "constant_velocity": JointKind(rows=(*TOGETHER, (rows.TWIST, 2, 2))),
    "angle": JointKind(
        rows=((rows.DOT, 2, 2),),
        turns=lambda joint: [axes_with_z(axis) for axis in joint.axes],
        value=lambda joint: joint.cosine,
    ),
    "point_on_curve": JointKind(rows=((rows.CONTACT, 0, 0), (rows.CONTACT, 1, 0)), turns=_as_they_are),
    "curve_on_curve": JointKind(rows=((rows.CONTACT, 0, 0),), turns=_as_they_are),
    "point_on_surface": JointKind(rows=((rows.CONTACT, 0, 0),), turns=_as_they_are),
    "surface_on_surface": JointKind(rows=((rows.CONTACT, 0, 0),), turns=_as_they_are),
    "rolling_surface": JointKind(
        rows=((rows.CONTACT, 0, 0), (rows.SLIP, 1, 0), (rows.SLIP, 2, 0)), turns=_as_they_are
    ),
}


def _axes_held(joint):
    """Rows that keep axes to those of an end frame: two where a spin is free."""
    return [(rows.FRAME, k, 0) for k in range(2 if joint.options.spin_is_free else 3)]


JOINT_KINDS |= {
    "frame_on_curve": JointKind(
        rows=((rows.CONTACT, 0, 0), (rows.CONTACT, 1, 0)),
        rows_too=_axes_held,
        # x, about which it may spin, as z
        turns=lambda joint: [np.eye(3), np.eye(3)[:, [1, 2, 0]]],
    ),
    "frame_on_surface": JointKind(rows=((rows.CONTACT, 0, 0),), rows_too=_axes_held, turns=_as_they_are),
}


def kind_of(joint) -> JointKind:
    """The record of a joint's kind."""
    return JOINT_KINDS[joint.kind]


def chain(joint):
    """A joint as simple motions one after another: list of (kind of the kernels, axis (3,) in the markers' axes)."""
    return list(zip(kind_of(joint).motions, kind_of(joint).axes(joint)))


class Scalar(NamedTuple):
    """One coordinate of a joint that has its coordinates each by itself: the quantity it is of, and its index in that."""

    coordinate: Coordinate
    ending: str

    @property
    def unit(self) -> str | None:
        """Of its position."""
        return self.coordinate.position.unit


def scalars(joint) -> list[Scalar]:
    """The coordinates of a joint that is no pose, in the order of its motions."""
    return [
        Scalar(coordinate, ending)
        for coordinate in joint.coordinates
        for ending in subscripts(coordinate.position.shape)
    ]


def units_along(joint):
    """Units of a one-axis joint's coordinate, and of efforts along it."""
    (coordinate,) = joint.coordinates
    return coordinate.position.unit, coordinate.effort.unit


def led_too(joint, values):
    """Values of all coordinates of a joint from those that lead, their positions or their rates."""
    led = kind_of(joint).led(joint)
    leading = iter(values)
    found = [None if k in led else next(leading) for k, _ in enumerate(scalars(joint))]

    for k, (other, ratio) in led.items():
        found[k] = ratio * found[other]

    return found
