"""The equations of each kind of joint between two frames, and its coordinates.

Of positions: 0 where the joint holds. Of velocities: 0 where rolling does not slip.
All as functions of a `Pair` over tau.
"""

import casadi as ca
import numpy as np

from .reading import axis, plane_axes
from .taylor import vee

KINDS = (
    "fixed", "revolute", "prismatic", "cylindrical", "universal", "spherical", "planar", "translation",
    "screw", "free", "point_on_plane", "point_on_line", "distance", "rolling_sphere", "rolling_disk",
    "knife_edge", "constant_velocity", "angle", "point_on_curve", "curve_on_curve", "point_on_surface",
    "frame_on_curve", "frame_on_surface", "prescribed",
)  # fmt: skip

# whose parameter may be driven
LED_ALONG = ("point_on_curve", "frame_on_curve")

# joints of one freedom: their coordinate and its rate
SINGLE = {"revolute": "angle", "prismatic": "position"}

# coordinates in the order of the start values: (name, name of the rate, whether an angle); several of one
# name are an array
COORDINATES = {
    "revolute": [("angle", "speed", True)],
    "prismatic": [("position", "speed", False)],
    "screw": [("position", "speed", False), ("angle", "angular_speed", True)],
    "cylindrical": [("position", "speed", False), ("angle", "angular_speed", True)],
    "universal": [("angles", "speeds", True)] * 2,
    "planar": [("position", "velocity", False)] * 2 + [("angle", "angular_speed", True)],
    "translation": [("position", "velocity", False)] * 3,
}


# numbers of a joint: axes u, x, y (3 each), radius or cosine, the side on which it rolls
GEOMETRY = 11


def joint_axis(kind, options):
    """The unit vector (3,) that a joint's equations are about: of a universal joint the first,
    of an edge the lateral one."""
    if kind in ("universal", "angle"):
        return two_axes(kind, options)[0]

    key = {"planar": "normal", "point_on_plane": "normal", "knife_edge": "lateral"}.get(kind, "axis")
    return axis(options.get(key, "y" if key == "lateral" else "z"))


def two_axes(kind, options):
    """The axes (2, 3) of a cross, or those that keep their angle: of the first marker, of the second."""
    return np.array(
        [axis(item) for item in options.get("axes", ("x", "y") if kind == "universal" else ("z", "z"))]
    )


def geometry(kind, options):
    """(10,): the axis u, axes x and y across it (of a universal joint or an angle x is the second axis),
    radius or cosine; the side comes behind."""
    u = joint_axis(kind, options)
    x, y = plane_axes(u)[:, :2].T

    if kind in ("universal", "angle"):
        x = two_axes(kind, options)[1]
        y = np.cross(u, x)

    size = np.cos(np.radians(options["angle_deg"])) if kind == "angle" else options.get("radius", 0.0)
    return np.concatenate([u, x, y, [size]])


def axes_of(geometry):
    """u, x, y of the numbers of a joint."""
    return geometry[:3], geometry[3:6], geometry[6:9]


def coordinates(kind, geometry, pair):
    """The coordinates of a joint over tau, angles but for full turns."""
    u, x, y = axes_of(geometry)
    d, R = pair.d, pair.R
    slide = ca.dot(u, d)
    forward = R @ x
    angle = ca.atan2(ca.dot(y, forward), ca.dot(x, forward))
    back = R.T @ u
    return {
        "revolute": [angle], "prismatic": [slide], "screw": [slide, angle], "cylindrical": [slide, angle],
        "planar": [ca.dot(x, d), ca.dot(y, d), angle], "translation": [d[k] for k in range(3)],
        "universal": [angle, ca.atan2(ca.dot(y, back), ca.dot(u, back))],
    }.get(kind, [])  # fmt: skip


def constraints(kind, geometry, pair):
    """(what is 0 of positions, of velocities) where a joint holds; of a distance the length."""
    u, x, y = axes_of(geometry)
    d, R = pair.d, pair.R
    across = [ca.dot(x, d), ca.dot(y, d)]
    together = [d[k] for k in range(3)]
    locked = [vee(R)[k] for k in range(3)]

    # u is the same axis in both frames
    aligned = [ca.dot(x, R @ u), ca.dot(y, R @ u)]

    if kind.startswith("rolling"):
        height, slip = rolling(kind, geometry, pair)
        return [height], slip

    if kind == "knife_edge":
        return [], [ca.dot(R @ u, pair.v)]

    # not 0, but what drivers ask for
    if kind == "prescribed":
        return [], [*(pair.v[k] for k in range(3)), *(pair.w[k] for k in range(3))]

    holds = {
        "fixed": together + locked,
        "revolute": together + aligned,
        "prismatic": across + locked,
        "cylindrical": across + aligned,
        "screw": across + aligned,
        "universal": [*together, ca.dot(u, R @ x) - ca.dot(u, x)],
        "spherical": together,
        "planar": [ca.dot(u, d), *aligned],
        "translation": locked,
        "point_on_plane": [ca.dot(u, d)],
        "point_on_line": across,
        "distance": [ca.norm_2(d)],
        "constant_velocity": [*together, ca.dot(u, vee(R))],
        "angle": [ca.dot(u, R @ x) - geometry[9]],
    }.get(kind, [])
    return holds, []


def is_turned_over(kind, options, R):
    """Whether R (3, 3), of the second frame in the first, is where the equations are 0 but the frames do not
    fit: axes the wrong way round, or frames that should be parallel turned by 120 or 180 degrees."""
    if kind in ("fixed", "prismatic", "translation"):
        return np.trace(R) < 2.0

    u = joint_axis(kind, options)

    if kind == "constant_velocity":
        return np.trace(R) < u @ R @ u

    return kind in ("revolute", "cylindrical", "screw", "planar") and u @ R @ u < 0.0


def rolling(kind, geometry, pair):
    """(height of the lowest point over the plane z = 0 of the first frame, its slip along x and y) of what
    rolls there."""
    first, second = pair.first, pair.second
    out = normal = first.A[:, 2]

    if kind == "rolling_disk":
        u = second.A @ geometry[:3]
        out = normal - ca.dot(normal, u) * u
        out = out / ca.norm_2(out)

    radius, side = geometry[9], geometry[10]
    lever = -side * radius * out
    point = second.r + lever
    slip = second.v + ca.cross(second.w, lever) - first.v - ca.cross(first.w, point - first.r)
    return ca.dot(normal, point - first.r), [ca.dot(first.A[:, 0], slip), ca.dot(first.A[:, 1], slip)]


def touching(kind, pair, curves):
    """What is 0 of positions where end frames touch. curves : points of the shapes over tau,
    in their own frames, with the curves' tangents."""
    if kind != "curve_on_curve":
        return pair.d - curves[0][0]

    # what separates the two planes does not count
    (here, tangent), (there, other) = curves
    apart = pair.d + pair.R @ there - here
    turned = pair.R @ other
    return [apart[0], apart[1], tangent[0] * turned[1] - tangent[1] * turned[0]]
