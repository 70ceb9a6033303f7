"""The equations of each kind of joint between two frames, and its coordinates.

Of positions: 0 where the joint holds. Of velocities: 0 where rolling does not slip. All as functions of a `Pair` over tau.
"""

import casadi as ca
import numpy as np

from .reading import axis, plane_axes
from .taylor import vee

KINDS = (
    "fixed", "revolute", "prismatic", "cylindrical", "universal", "spherical", "planar", "translation", "screw", "free",
    "point_on_plane", "point_on_line", "distance", "rolling_sphere", "rolling_disk", "knife_edge",
    "point_on_curve", "curve_on_curve", "point_on_surface",
)  # fmt: skip

# joints of one freedom: their coordinate and its rate
SINGLE = {"revolute": "angle", "prismatic": "position"}

# coordinates in the order of the start values: (name, name of the rate, whether an angle); several of one name are an array
COORDINATES = {
    "revolute": [("angle", "speed", True)],
    "prismatic": [("position", "speed", False)],
    "screw": [("position", "speed", False), ("angle", "angular_speed", True)],
    "cylindrical": [("position", "speed", False), ("angle", "angular_speed", True)],
    "universal": [("angles", "speeds", True)] * 2,
    "planar": [("position", "velocity", False)] * 2 + [("angle", "angular_speed", True)],
    "translation": [("position", "velocity", False)] * 3,
}


def joint_axis(kind, options):
    """The unit vector (3,) that a joint's equations are about."""
    return axis(options.get("normal" if kind in ("planar", "point_on_plane") else "axis", "z"))


def universal_axes(options):
    """The axes of the cross (2, 3): of the first marker, of the second."""
    return np.array([axis(item) for item in options.get("axes", ("x", "y"))])


def along(u, vector):
    """Component of a vector along a constant one."""
    return ca.dot(ca.DM(u), vector)


def angle_about(u, start, vector):
    """Angle (rad) of a vector about u, from where `start` is."""
    return ca.atan2(along(np.cross(u, start), vector), along(start, vector))


def aligned(u, R):
    """Two equations: u is the same axis in both frames."""
    turned = R @ ca.DM(u)
    return [along(side, turned) for side in plane_axes(u)[:, :2].T]


def coordinates(kind, options, pair):
    """The coordinates of a joint over tau, angles but for full turns."""
    if kind == "universal":
        first, second = universal_axes(options)
        forward, back = pair.R @ ca.DM(second), pair.R.T @ ca.DM(first)
        return [angle_about(first, second, forward), -angle_about(second, first, back)]

    if kind == "translation":
        return [pair.d[k] for k in range(3)]

    u = joint_axis(kind, options)
    x, y = plane_axes(u)[:, :2].T
    angle = angle_about(u, x, pair.R @ ca.DM(x))
    slide = along(u, pair.d)
    return {
        "revolute": [angle], "prismatic": [slide], "screw": [slide, angle], "cylindrical": [slide, angle],
        "planar": [along(x, pair.d), along(y, pair.d), angle],
    }.get(kind, [])  # fmt: skip


def positions(kind, options, pair):
    """What is 0 of positions where a joint holds; of a distance, and of the height of what rolls, what stays as it is told."""
    d, R = pair.d, pair.R
    u = joint_axis(kind, options)
    across = [along(side, d) for side in plane_axes(u)[:, :2].T]
    together = [d[k] for k in range(3)]
    locked = [vee(R)[k] for k in range(3)]

    if kind == "universal":
        first, second = universal_axes(options)
        return [*together, along(first, R @ ca.DM(second)) - first @ second]

    return {
        "fixed": together + locked,
        "revolute": together + aligned(u, R),
        "prismatic": across + locked,
        "cylindrical": across + aligned(u, R),
        "screw": across + aligned(u, R),
        "spherical": together,
        "planar": [along(u, d), *aligned(u, R)],
        "translation": locked,
        "point_on_plane": [along(u, d)],
        "point_on_line": across,
        "distance": [ca.norm_2(d)] if kind == "distance" else [],
    }.get(kind, [])


def is_turned_over(kind, options, R):
    """Whether R (3, 3), of the second frame in the first, is where the equations are 0 but the frames do not fit: axes the wrong
    way round, or frames that should be parallel turned by 120 or 180 degrees."""
    if kind in ("fixed", "prismatic", "translation"):
        return np.trace(R) < 2.0

    u = joint_axis(kind, options)
    return kind in ("revolute", "cylindrical", "screw", "planar") and u @ R @ u < 0.0


def rolling(kind, options, pair, side):
    """(height of the lowest point over the plane, its slip along x and y) of what rolls on z = 0 of the first frame.

    side : 1 above the plane, -1 below.
    """
    first, second = pair.first, pair.second
    normal = first.A[:, 2]
    out = normal

    if kind == "rolling_disk":
        u = second.A @ ca.DM(axis(options.get("axis", "z")))
        out = normal - ca.dot(normal, u) * u
        out = out / ca.norm_2(out)

    lever = -side * options["radius"] * out
    point = second.r + lever
    slip = second.v + ca.cross(second.w, lever) - first.v - ca.cross(first.w, point - first.r)
    return ca.dot(normal, point - first.r), [ca.dot(first.A[:, 0], slip), ca.dot(first.A[:, 1], slip)]


def knife_edge(options, pair):
    """Velocity of the second frame's origin across the edge, as seen from the first."""
    lateral = pair.R @ ca.DM(axis(options.get("lateral", "y")))
    return ca.dot(lateral, pair.v)


def touching(kind, pair, curves):
    """What is 0 of positions where end frames touch. curves : points of the shapes over tau, in their own frames, with the
    curves' tangents."""
    if kind != "curve_on_curve":
        return pair.d - curves[0][0]

    # what separates the two planes does not count
    (here, tangent), (there, other) = curves
    apart = pair.d + pair.R @ there - here
    turned = pair.R @ other
    return [apart[0], apart[1], tangent[0] * turned[1] - tangent[1] * turned[0]]
