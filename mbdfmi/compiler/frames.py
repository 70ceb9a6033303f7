"""Poses of frames: pairs (r, A) of origin (3,) in m and rotation matrix (3, 3), in the frame named."""

from functools import lru_cache

import numpy as np

from ..vectors import cross, dot, norm

IDENTITY = (np.zeros(3), np.eye(3))


def compose(outer, inner):
    """Pose of a frame given in a frame that is itself at `outer`."""
    return outer[0] + dot(outer[1], inner[0]), dot(outer[1], inner[1])


def inverse(pose):
    """The pose the other way round."""
    return -dot(pose[1].T, pose[0]), pose[1].T


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
