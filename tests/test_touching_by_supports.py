"""Surfaces that touch, beside equations that know nothing of their parameters: accelerations and forces at random states.

A convex surface is known here by where it goes farthest along a direction n, at s(n). Two of them, from a to b, are apart by
n . (s_b(-n) - s_a(n)) with that n along which their two points lie; how this changes, and how they slip, is found by differences.
"""

import numpy as np
import pytest
from scipy.optimize import root
from scipy.spatial.transform import Rotation

from mbdfmi import Scene

GRAVITY = np.array([1.0, -2.0, -9.0])
SECONDS = 4e-3

FIRST = {
    "plane": {"plane": {}},
    "sphere": {"sphere": {"radius": 0.7}},
    "ellipsoid": {"ellipsoid": {"semi_axes": [0.9, 0.6, 0.75]}},
    "cylinder": {"cylinder": {"radius": 0.5}},
    "torus": {"torus": {"radius": 0.8, "tube": 0.3}},
}
SECOND = {
    "sphere": {"sphere": {"radius": 0.3}},
    "ellipsoid": {"ellipsoid": {"semi_axes": [0.4, 0.2, 0.3]}},
    "torus": {"torus": {"radius": 0.3, "tube": 0.1}},
    "disk": {"disk": {"radius": 0.35}},
}


def support(surface, n):
    """The point (3,) of a surface where its outward unit normal is n, in its axes."""
    kind, size = next(iter(surface.items()))
    flat = np.array([n[0], n[1], 0.0])

    if kind == "plane":
        return np.zeros(3)
    if kind == "sphere":
        return size["radius"] * n
    if kind == "ellipsoid":
        squares = np.square(size["semi_axes"])
        return squares * n / np.sqrt(squares @ n**2)

    return size["radius"] * flat / np.linalg.norm(flat) + size.get("tube", 0.0) * n


class Body:
    """A rigid body at a random state, by its centre of mass; its surface has an origin and axes of its own."""

    def __init__(self, rng, surface):
        self.surface = surface
        self.mass = rng.uniform(1.0, 3.0)
        self.inertia = rng.uniform(0.3, 0.5, 3)
        self.com, self.place = rng.uniform(-0.2, 0.2, (2, 3))
        self.axes, self.turned = Rotation.random(2, random_state=rng)
        self.r, self.v, self.w = rng.uniform(-0.7, 0.7, (3, 3))

    def skin(self, t=0.0):
        """(origin, axes) of the surface after t (s) without accelerations."""
        turned = Rotation.from_rotvec(self.w * t) * self.turned
        return self.r + self.v * t + turned.apply(self.place - self.com), turned * self.axes

    def point(self, n, t=0.0):
        """The point of the surface of the outward normal n, after t (s)."""
        origin, axes = self.skin(t)
        return origin + axes.apply(support(self.surface, axes.inv().apply(n)))

    def velocity(self, p, t=0.0):
        """Of the material point that is at p after t (s)."""
        return self.v + np.cross(self.w, p - self.r - self.v * t)

    def mobility(self):
        """(6, 6): accelerations by a force at the centre of mass and a moment."""
        R = self.turned.as_matrix()
        found = np.eye(6) / self.mass
        found[3:, 3:] = R / self.inertia @ R.T
        return found

    def falling(self):
        """(6,): accelerations without contact, of the centre of mass and of turning."""
        R = self.turned.as_matrix()
        turning = np.cross(R * self.inertia @ R.T @ self.w, self.w)
        return np.concatenate([GRAVITY, self.mobility()[3:, 3:] @ turning])

    def told(self, accelerations):
        """(6,): these as the scene tells them: of the body's origin, and of turning."""
        arm, alpha = -self.turned.apply(self.com), accelerations[3:]
        swung = np.cross(alpha, arm) + np.cross(self.w, np.cross(self.w, arm))
        return np.concatenate([accelerations[:3] + swung, alpha])

    def tables(self):
        """The body, and the start of the joint that leaves it free."""
        origin = self.r - self.turned.apply(self.com)
        skin = {"position": self.place, "euler_parameters": self.axes.as_quat(), "surface": self.surface}
        start = {"position": origin, "euler_parameters": self.turned.as_quat(), "omega": self.w}
        return {
            "mass": self.mass,
            "com": self.com.tolist(),
            "inertia": self.inertia.tolist(),
            "marker": {"skin": plain(skin)},
            "output": ["acceleration", "alpha"],
        }, plain(start | {"velocity": self.velocity(origin)})


def plain(table):
    """With lists in place of arrays."""
    return {key: value.tolist() if isinstance(value, np.ndarray) else value for key, value in table.items()}


def basis(n):
    """(2, 3): directions normal to n."""
    return np.linalg.svd(n[None])[2][1:]


def between(a, b, near, t):
    """(distance along the normal from a to b, slip there) after t (s) without accelerations; near : a normal close to it."""
    axis = a.skin(t)[1].as_matrix()[:, 2]
    ways = basis(near)

    if "plane" in a.surface:
        near, ways = axis, np.zeros((0, 3))
    elif "cylinder" in a.surface:
        near = near - axis * (axis @ near)
        ways = np.cross(axis, near)[None]

    def normal(x):
        n = near + x @ ways
        return n / np.linalg.norm(n)

    def span(n):
        return b.point(-n, t) - a.point(n, t)

    def aside(x):
        n, apart = normal(x), span(normal(x))
        return ways @ (apart - n * (n @ apart))

    n = normal(root(aside, np.zeros(len(ways)), tol=1e-14).x) if len(ways) else near
    p = b.point(-n, t)
    return n @ span(n), b.velocity(p, t) - a.velocity(p, t)


def slopes(f):
    """(first, second) derivative at 0 by differences of order 6."""
    values = [f(k * SECONDS) for k in range(-3, 4)]
    first = np.tensordot([-1 / 60, 3 / 20, -3 / 4, 0, 3 / 4, -3 / 20, 1 / 60], values, 1) / SECONDS
    second = np.tensordot([1 / 90, -3 / 20, 3 / 2, -49 / 18, 3 / 2, -3 / 20, 1 / 90], values, 1)
    return first, second / SECONDS**2


def placed(rng, first, second, rolls):
    """(a, b, normal, point): bodies that touch, and go neither apart nor, where they roll, along each other."""
    a, b = Body(rng, FIRST[first]), Body(rng, SECOND[second])
    origin, axes = a.skin()
    n = rng.normal(size=3) * {"plane": [0, 0, 0], "cylinder": [1, 1, 0]}.get(first, [1, 1, 0.5])
    n = n + [0, 0, 1] if first == "plane" else n / np.linalg.norm(n)
    along = rng.normal(size=3) * {"plane": [1, 1, 0], "cylinder": [0, 0, 1]}.get(first, [0, 0, 0])
    n, along = axes.apply(n), axes.apply(along)
    p = a.point(n) + along
    b.r = b.r + p - b.point(-n)
    slip = b.velocity(p) - a.velocity(p)
    b.v = b.v - (slip if rolls else n * (n @ slip))
    return a, b, n, p


@pytest.mark.parametrize("rolls", [False, True], ids=["slides", "rolls"])
@pytest.mark.parametrize("second", SECOND)
@pytest.mark.parametrize("first", FIRST)
def test_accelerations_and_forces(first, second, rolls):
    seeds = [*FIRST].index(first), [*SECOND].index(second), rolls
    a, b, n, p = placed(np.random.default_rng(seeds), first, second, rolls)
    speed, bend = slopes(lambda t: between(a, b, n, t)[0])
    faster, _ = slopes(lambda t: between(a, b, n, t)[1])
    assert abs(between(a, b, n, 0.0)[0]) < 1e-14 and abs(speed) < 1e-9

    # unit forces on b at the point of contact, their contrary on a
    ways = [n, *basis(n)] if rolls else [n]
    C = np.array([[*-u, *-np.cross(p - a.r, u), *u, *np.cross(p - b.r, u)] for u in ways])
    mobility = np.zeros((12, 12))
    mobility[:6, :6], mobility[6:, 6:] = a.mobility(), b.mobility()
    falling = np.concatenate([a.falling(), b.falling()])
    bias = np.array([bend, *(u @ faster for u in ways[1:])])
    force = np.linalg.solve(C @ mobility @ C.T, -(C @ falling + bias))
    wanted = falling + mobility @ C.T @ force

    (body_a, start_a), (body_b, start_b) = a.tables(), b.tables()
    kind = "rolling_surface" if rolls else "surface_on_surface"
    results = Scene.model_validate(
        {
            "name": "touching",
            "gravity": GRAVITY.tolist(),
            "solver": {"formulation": ["recursive", "embedding", "augmented"][sum(seeds) % 3]},
            "body": {"a": body_a, "b": body_b},
            "joint": {
                "one": {"free": {}, "between": ["ground", "a"], "start": start_a},
                "other": {"free": {}, "between": ["ground", "b"], "start": start_b},
                "touch": {
                    kind: {},
                    "between": ["a.skin", "b.skin"],
                    "output": ["contact_point", "normal_force"],
                },
            },
        }
    ).simulate(1e-6, 1e-6)

    for name, body, found in (("a", a, wanted[:6]), ("b", b, wanted[6:])):
        told = np.concatenate([results[f"{name}.acceleration"][0], results[f"{name}.alpha"][0]])
        np.testing.assert_allclose(told, body.told(found), atol=1e-6 * np.abs(wanted).max())

    origin, axes = a.skin()
    np.testing.assert_allclose(results["touch.contact_point"][0], axes.inv().apply(p - origin), atol=1e-12)
    assert results["touch.normal_force"][0] == pytest.approx(force[0], rel=1e-6, abs=1e-6)
