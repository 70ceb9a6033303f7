"""Curves and surfaces of end frames as points to draw, in the axes of their marker."""

import numpy as np

from ..lazily import scipy
from . import forms

# points along a curve, and each way across a surface
FINE = 160
ACROSS = 48


def curve_points(curve, reach):
    """(n, 3) in m along a curve; of one without ends as far as `reach` (m) from the origin, a cycloid one
    arch.
    """
    if curve.kind in ("spline", "table"):
        ends = "periodic" if curve.closed else "not-a-knot"
        return scipy.interpolate.CubicSpline(curve.s, curve.points, bc_type=ends)(
            np.linspace(curve.s[0], curve.s[-1], FINE)
        )

    s = np.linspace(-1.0, 1.0, FINE)
    if curve.kind == "circle":
        x, y = curve.radius * np.cos(np.pi * s), curve.radius * np.sin(np.pi * s)
    elif curve.kind == "cycloid":
        x, y = curve.radius * (np.pi * s + np.sin(np.pi * s)), curve.radius * (1 - np.cos(np.pi * s))
    else:
        c = curve.coefficient if curve.kind == "parabola" else 0.0
        # so far out that it is `reach` away there
        x = s * (np.sqrt((np.sqrt(1 + (2 * c * reach) ** 2) - 1) / 2) / abs(c) if c else reach)
        y = c * x**2
    return np.column_stack([x, y, np.zeros(FINE)])


def surface(shape, reach):
    """The `forms.Triangles` of a surface; of one without an end as far as `reach` (m)."""
    return SURFACES[shape.kind](shape, reach)


def _ball(semi_axes):
    return forms.moved(forms.sphere(), np.zeros(3), np.eye(3), semi_axes)


def _torus(shape, reach):
    a = np.linspace(-np.pi, np.pi, ACROSS + 1)
    u, v = np.meshgrid(a, a, indexing="ij")
    out = shape.radius + shape.tube * np.cos(v)
    return forms.grid(np.stack([out * np.cos(u), out * np.sin(u), shape.tube * np.sin(v)], axis=2))


def _cylinder(shape, reach):
    a = np.linspace(-np.pi, np.pi, ACROSS + 1)
    return _extruded(shape.radius * np.column_stack([np.cos(a), np.sin(a), 0 * a]), reach)


def _table(shape, reach):
    s1, s2, points = np.array(shape.s1), np.array(shape.s2), np.asarray(shape.points)
    fine = np.linspace(s1[0], s1[-1], ACROSS), np.linspace(s2[0], s2[-1], ACROSS)
    return forms.grid(
        np.stack(
            [scipy.interpolate.RectBivariateSpline(s1, s2, points[:, :, k])(*fine) for k in range(3)], axis=2
        )
    )


def _extruded(edge, reach):
    """The surface that an edge (n, 3) makes moved along z, `reach` (m) both ways."""
    return forms.grid(edge[:, None] + np.array([0.0, 0.0, 1.0]) * np.array([-reach, reach])[None, :, None])


def _plane(shape, reach):
    u, v = np.meshgrid([-reach, reach], [-reach, reach], indexing="ij")
    return forms.grid(np.stack([u, v, 0 * u], axis=2))


SURFACES = {
    "plane": _plane,
    "sphere": lambda shape, reach: _ball(3 * [shape.radius]),
    "ellipsoid": lambda shape, reach: _ball(shape.semi_axes),
    "disk": lambda shape, reach: forms.moved(
        forms.cylinder(), np.zeros(3), np.eye(3), [shape.radius, shape.radius, 0.01 * shape.radius]
    ),
    "cylinder": _cylinder,
    "torus": _torus,
    "prism": lambda shape, reach: _extruded(curve_points(shape.profile, reach), reach),
    "table": _table,
}
"""kind -> (surface, reach) -> its triangles."""
