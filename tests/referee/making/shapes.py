"""Curves and surfaces, and where they are at a parameter."""

from typing import NamedTuple

import numpy as np
from scipy.interpolate import CubicSpline

from ..independent import curves
from .frames import orientation, plane_axes, unit


class Curve(NamedTuple):
    """table: as written; s: a parameter of it; r, t, n (3,): the point there,
    the first and the second derivative by s."""

    table: dict
    s: float
    r: np.ndarray
    t: np.ndarray
    n: np.ndarray

    @property
    def curvature(self):
        """1/m, about z, of a planar curve, positive to the left."""
        return np.cross(self.t, self.n)[2] / np.linalg.norm(self.t) ** 3


CURVES = ("line", "circle", "parabola", "cycloid", "spline", "table")
PROFILES = {"line": 1, "circle": 1, "parabola": 1, "cycloid": 1, "spline": 1.7, "table": 1.9}


def curve(dice, planar=False, kind=None):
    """A random `Curve`."""
    kind = kind or dice.pick(CURVES)

    if kind == "line":
        s = dice.number(-1, 1)
        return Curve({"line": {}}, s, np.array([s, 0, 0]), np.array([1.0, 0, 0]), np.zeros(3))

    if kind == "circle":
        R = dice.number(0.3, 1.5)
        s = dice.number(-3, 3) * R
        c, d = np.cos(s / R), np.sin(s / R)
        return Curve(
            {"circle": {"radius": R}},
            s,
            np.array([R * c, R * d, 0]),
            np.array([-d, c, 0]),
            np.array([-c, -d, 0]) / R,
        )

    if kind == "parabola":
        c, s = dice.signed(0.2, 1.5), dice.number(-0.7, 0.7)
        return Curve(
            {"parabola": {"coefficient": c}},
            s,
            np.array([s, c * s * s, 0]),
            np.array([1, 2 * c * s, 0]),
            np.array([0, 2 * c, 0]),
        )

    if kind == "cycloid":
        R, s = dice.number(0.3, 1.0), dice.number(-1.5, 1.5)
        c, d = np.cos(s), np.sin(s)
        return Curve(
            {"cycloid": {"radius": R}},
            s,
            R * np.array([s + d, 1 - c, 0]),
            R * np.array([1 + c, d, 0]),
            R * np.array([-d, c, 0]),
        )

    return _through_points(dice, planar, kind)


def _through_points(dice, planar, kind):
    closed = dice.chance(0.4)
    n = dice.whole(5, 8)

    if closed:
        angles = 2 * np.pi * (np.arange(n) + dice.rng.uniform(-0.15, 0.15, n)) / n
        radii = dice.number(0.5, 1.2) * dice.rng.uniform(0.9, 1.1, n)
        points = np.column_stack([radii * np.cos(angles), radii * np.sin(angles), np.zeros(n)])
    else:
        x = np.linspace(-1.5, 1.5, n)
        points = np.column_stack(
            [x, dice.number(0.1, 0.4) * x * x + 0.1 * np.sin(3 * x + dice.number(-2, 2)), np.zeros(n)]
        )

    height = 0.0
    if not planar and dice.chance(0.5):
        points[:, 2] = dice.rng.uniform(-0.15, 0.15, n)
    elif dice.chance(0.3):
        height = dice.number(-0.3, 0.3)
        points[:, 2] = height

    points = np.round(points, 3)
    flat = not points[:, 2].any() and dice.chance(0.5)
    options = {"points": (points[:, :2] if flat else points).tolist()}
    if closed or dice.chance(0.6):
        options["closed"] = closed
    nodes = np.vstack([points, points[:1]]) if closed else points
    s = np.concatenate([[0.0], np.cumsum(np.linalg.norm(np.diff(nodes, axis=0), axis=1))])
    if kind == "table" or dice.chance(0.4):
        s = np.round(s * dice.number(0.5, 2.0) + (0.0 if dice.chance(0.5) else dice.number(-1, 1)), 4)
        options["s"] = s.tolist()

    spline = CubicSpline(s, nodes, bc_type="periodic" if closed else "not-a-knot")
    at = s[0] + (s[-1] - s[0]) * dice.number(0.3, 0.7)
    return Curve({kind: options}, float(at), spline(at), spline(at, 1), spline(at, 2))


class Surface(NamedTuple):
    """table: as written; s: parameters of it; r, n (3,): the point there and a normal."""

    table: dict
    s: list
    r: np.ndarray
    n: np.ndarray


def surface(dice, kind=None):
    """A random `Surface`."""
    kind = kind or dice.weighted(
        {"plane": 1, "sphere": 1, "cylinder": 1, "torus": 1, "prism": 6, "table": 1.3}
    )

    if kind == "plane":
        s = dice.vector(0.8, 2)
        return Surface({"plane": {}}, s, np.array([*s, 0.0]), np.array([0, 0, 1.0]))

    if kind == "prism":
        profile = curve(dice, planar=True, kind=dice.weighted(PROFILES))
        z = dice.number(-0.5, 0.5)
        r = profile.r + [0, 0, z]
        return Surface(
            {"prism": {"profile": profile.table}}, [profile.s, z], r, np.cross(profile.t, [0, 0, 1])
        )

    if kind == "table":
        return _through_grid(dice)

    R, (a, b) = dice.number(0.5, 1.5), (dice.number(-3, 3), dice.number(-0.9, 0.9))
    across, up = np.array([np.cos(a), np.sin(a), 0.0]), np.array([0, 0, 1.0])

    if kind == "sphere":
        n = np.cos(b) * across + np.sin(b) * up
        return Surface({"sphere": {"radius": R}}, [a, b], R * n, n)

    if kind == "cylinder":
        return Surface({"cylinder": {"radius": R}}, [a, b], R * across + b * up, across)

    if kind == "ellipsoid":
        return _ellipsoid(dice, a, b)

    tube = round(R * dice.number(0.2, 0.6), 3)
    n = np.cos(b) * across + np.sin(b) * up
    return Surface({"torus": {"radius": R, "tube": tube}}, [a, b], R * across + tube * n, n)


def _ellipsoid(dice, a, b):
    axes = np.array(dice.numbers(3, 0.6, 1.3))
    e = np.array([np.cos(b) * np.cos(a), np.cos(b) * np.sin(a), np.sin(b)])
    return Surface({"ellipsoid": {"semi_axes": axes.tolist()}}, [a, b], axes * e, e / axes)


def _through_grid(dice):
    n1, n2 = dice.whole(4, 6), dice.whole(4, 5)
    s1, s2 = np.linspace(-1.5, 1.5, n1).round(3), np.linspace(-1.5, 1.5, n2).round(3)
    bend, tilt = dice.vector(0.3, 2), dice.vector(0.2, 2)
    points = [
        [
            [x, y, round(float(bend[0] * x * x + bend[1] * y * y + tilt[0] * x + tilt[1] * y * x), 3)]
            for y in s2.tolist()
        ]
        for x in s1.tolist()
    ]
    at = [dice.number(-0.6, 0.6), dice.number(-0.6, 0.6)]
    over1 = CubicSpline(s1, np.array(points))
    across, slope = CubicSpline(s2, over1(at[0])), CubicSpline(s2, over1(at[0], 1))
    options = {"s1": s1.tolist(), "s2": s2.tolist(), "points": points}
    return Surface({"table": options}, at, across(at[1]), np.cross(slope(at[1]), across(at[1], 1)))


def touching(dice):
    """Two planar curves that touch: (first `Curve`, second, pose of the second's frame in the first's)."""
    while True:
        first, second = curve(dice, planar=True), curve(dice, planar=True)

        if {*first.table} == {*second.table} == {"line"}:
            continue

        for turn in (np.pi, 0.0):
            angle = np.arctan2(first.t[1], first.t[0]) - np.arctan2(second.t[1], second.t[0]) + turn
            c, d = np.cos(angle), np.sin(angle)
            A = np.array([[c, -d, 0], [d, c, 0], [0, 0, 1.0]])
            bend = first.curvature - second.curvature * (1 if turn == 0.0 else -1)

            # the point of touch is well defined where the curves bend away from each other
            if abs(bend) > 0.4:
                return first, second, (first.r - A @ second.r, A)


FIRST = {"plane": 2, "sphere": 1.2, "ellipsoid": 2.5, "cylinder": 1, "torus": 1, "prism": 1, "table": 1}
SECOND = {"sphere": 1, "ellipsoid": 1.6, "disk": 2, "torus": 1.4}
# of prisms that bend more than this, 1/m, nothing touches the hollow side
BENT = 0.8


def touching_surfaces(dice):
    """Two surfaces that touch: (first `Surface`, the table of the second, pose of the second's frame in the first's,
    (3,) m from its origin to where they touch, in the first's axes)."""
    first = surface(dice, dice.weighted(FIRST))
    n = _side(dice, first) * unit(first.n)
    table, support = _round(dice)
    A = orientation(dice)[1]

    # not flat on the plane of a disk or of a torus
    while np.linalg.norm((A.T @ n)[:2]) < 0.3:
        A = orientation(dice)[1]

    arm = A @ support(-A.T @ n)
    return first, table, (first.r - arm, A), arm


def _side(dice, first):
    """1 or -1: on which side of a surface, along its normal, another one may touch it."""
    kind, options = next(iter(first.table.items()))

    if kind in ("torus", "ellipsoid"):
        return 1.0

    if kind == "prism":
        d = curves.Curve(options["profile"]).derivatives(first.s[0])
        bend = np.cross(d[1], d[2])[2] / np.linalg.norm(d[1]) ** 3

        # the normal points to the right of the profile
        if abs(bend) > BENT:
            return float(np.sign(bend))

    return 1.0 if dice.chance(0.7) else -1.0


def _round(dice):
    """(table, point (3,) whose outward normal is a direction (3,)) of a surface that is round outwards."""
    kind, R, tube = dice.weighted(SECOND), dice.number(0.1, 0.3), 0.0

    if kind in ("sphere", "ellipsoid"):
        axes = [R] * 3 if kind == "sphere" else dice.numbers(3, 0.12, 0.25)
        squares = np.square(axes)
        options = {"radius": R} if kind == "sphere" else {"semi_axes": axes}
        return {kind: options}, lambda d: squares * d / np.linalg.norm(axes * d)

    if kind == "torus":
        tube = round(0.4 * R, 3)

    options = {"radius": R} | ({"tube": tube} if tube else {})
    return {kind: options}, lambda d: R * unit(d * [1, 1, 0]) + tube * unit(d)


def frame_on(surface_normal):
    """(3, 3): two directions in a surface and its normal, by column."""
    return plane_axes(unit(surface_normal))
