"""Directions that a curve is never parallel to, by which its end frames are made (docs/theory.md 10.1)."""

import math

import numpy as np

from ..lazily import scipy
from ..scene import Problem, SceneError
from ..vectors import dot

# samples of a curve's tangent, of each piece too, and directions that may be the one it is never parallel to
TANGENTS = 400
OF_A_PIECE = 40
SIDES = 200

# deg: a side that comes as near as this to the curve's direction is parallel to it
PARALLEL = 1.0


def spline_of(curve):
    """The cubic spline through the points of a curve."""
    return scipy.interpolate.CubicSpline(
        curve.s, curve.points, bc_type="periodic" if curve.closed else "not-a-knot"
    )


def farthest(tangents):
    """The unit vector (3,) of many that keeps the largest angle to tangents (n, 3)."""
    tangents = tangents / np.linalg.norm(tangents, axis=1)[:, None]

    # directions evenly spread over the upper half of a sphere, by the golden angle
    z = (np.arange(SIDES) + 0.5) / SIDES
    turn = np.pi * (3.0 - np.sqrt(5.0)) * np.arange(SIDES)
    flat = np.sqrt(1.0 - z**2)
    sides = np.column_stack([flat * [math.cos(a) for a in turn], flat * [math.sin(a) for a in turn], z])
    return sides[np.abs(dot(sides, tangents.T)).max(axis=1).argmin()]


def default_side(curve):
    """z of a planar curve, of others the direction that keeps farthest from its tangents: (3,)."""
    if curve.is_planar:
        return np.array([0.0, 0.0, 1.0])

    return farthest(spline_of(curve).derivative()(np.linspace(curve.s[0], curve.s[-1], TANGENTS)))


def _tangents(curve):
    """(s, tangents (n, 3)) of samples close enough to see whether one is parallel to a side; of a curve without end where s says
    much.
    """
    if hasattr(curve, "points"):
        s = np.interp(
            np.linspace(0, len(curve.s) - 1, OF_A_PIECE * len(curve.s)), np.arange(len(curve.s)), curve.s
        )
        return s, spline_of(curve).derivative()(s)

    # by its angle: all the way round, or short of the ends of a parabola and the cusps of a cycloid
    angle = (
        np.linspace(-np.pi, np.pi, TANGENTS)
        if curve.kind == "circle"
        else np.radians(np.linspace(-89, 89, TANGENTS))
    )
    along = np.column_stack([np.cos(angle), np.sin(angle), 0 * angle])

    if curve.kind == "line":
        return np.zeros(1), np.array([[1.0, 0.0, 0.0]])

    if curve.kind == "circle":
        return angle * curve.radius, along[:, [1, 0, 2]] * [-1, 1, 1]

    return (2 * angle if curve.kind == "cycloid" else np.tan(angle) / (2 * curve.coefficient)), along


def side_of(name, joint, curve):
    """The side (3,) by which a joint's end frame is made: as given, else by default.

    Raises SceneError where the curve is parallel to it somewhere: the frame would have no normal there.
    """
    side = default_side(curve) if joint.side is None else joint.side
    s, tangents = _tangents(curve)
    tangents = tangents / np.linalg.norm(tangents, axis=1)[:, None]
    angle = np.degrees(np.arcsin(np.minimum(1.0, np.linalg.norm(np.cross(tangents, side), axis=1))))
    worst = int(angle.argmin())

    if angle[worst] > PARALLEL:
        return side

    where = f"the curve is parallel to {_shown(side)} at s = {s[worst]:.4g}"
    text = f"{where}, to {angle[worst]:.2g} deg, and there the end frame has no normal"
    better = farthest(tangents)

    if np.abs(dot(tangents, better)).max() < np.cos(np.radians(PARALLEL)):
        text += f"; it keeps farthest from {_shown(better)}"

    raise SceneError([Problem(("joint", name, "frame_on_curve", "side"), text)])


def _shown(vector):
    """A direction as a scene writes it."""
    return "[{:.3g}, {:.3g}, {:.3g}]".format(*(np.asarray(vector) + 0.0))
