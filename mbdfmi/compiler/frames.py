"""Poses of frames: pairs (r, A) of origin (3,) in m and rotation matrix (3, 3), in the frame named."""

from functools import lru_cache

import numpy as np

from ..vectors import cross, dot, norm

IDENTITY = (np.zeros(3), np.eye(3))

ROUNDING = 4 * np.finfo(float).eps
"""Of what products of rotations, and sums of positions, may be off by rounding."""


def compose(outer, inner):
    """Pose of a frame given in a frame that is itself at `outer`; what rounding leaves of nothing is nothing."""
    r, turned = map(float, outer[0]), dot(outer[1], inner[0]).tolist()
    ends = list(zip(r, turned))
    least = ROUNDING * (max(abs(a) for a, _ in ends) + max(abs(b) for _, b in ends))
    position = [a + b if abs(a + b) > least else 0.0 for a, b in ends]
    return np.array(position), exact(dot(outer[1], inner[1]))


def inverse(pose):
    """The pose the other way round."""
    return -dot(pose[1].T, pose[0]), pose[1].T


def exact(A):
    """A rotation matrix whose elements are -1, 0, 1 where they are that but for rounding.

    Most joints of a scene turn about axes of its frames: code of its own is without them then (docs/specialise.md).
    """
    return np.array([[_exact(x) for x in row] for row in A.tolist()])


def _exact(x):
    nearest = float(round(x))
    return nearest if abs(x - nearest) <= ROUNDING else x


def axes_with_z(axis):
    """A rotation matrix whose third column is the unit vector `axis` (3,); exact for coordinate axes. Not to be written to."""
    return _axes_with_z(np.asarray(axis, float).tobytes())


@lru_cache(1024)
def _axes_with_z(axis):
    """The same of the numbers' bytes: many joints have the same axes."""
    axis = np.frombuffer(axis)
    helper = np.eye(3)[np.argmin(np.abs(axis))]
    x = cross(helper, axis)
    x /= norm(x)
    axes = np.column_stack([x, cross(axis, x), axis])
    axes.flags.writeable = False
    return axes
