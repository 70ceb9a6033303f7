"""Triangles of geometric forms, each in its own axes about its centre, round ones along z."""

import itertools
from functools import cache
from typing import NamedTuple

import numpy as np

from ..compiler.frames import axes_with_z

AROUND = 32
"""Corners of a circle."""


class Triangles(NamedTuple):
    """A surface: points (n, 3) in m, unit normals (n, 3) there, faces (m, 3) of points, outward
    anticlockwise.
    """

    points: np.ndarray
    normals: np.ndarray
    faces: np.ndarray


def join(parts) -> Triangles:
    """Several surfaces as one."""
    at = np.cumsum([0, *(len(part.points) for part in parts)])
    faces = [part.faces + start for part, start in zip(parts, at)]
    return Triangles(
        np.concatenate([p.points for p in parts]),
        np.concatenate([p.normals for p in parts]),
        np.concatenate(faces),
    )


def moved(surface: Triangles, r, A, size=(1.0, 1.0, 1.0)) -> Triangles:
    """A surface stretched along its axes by `size`, then turned by A (3, 3), then moved by r (3,)."""
    normals = surface.normals / np.asarray(size)
    normals = normals / np.maximum(np.linalg.norm(normals, axis=1), 1e-30)[:, None]
    return Triangles(surface.points * size @ np.transpose(A) + r, normals @ np.transpose(A), surface.faces)


@cache
def box() -> Triangles:
    """A cube of edge 1."""
    square = np.array([[-1, -1, 1], [1, -1, 1], [1, 1, 1], [-1, 1, 1]]) / 2
    faces = np.array([[0, 1, 2], [0, 2, 3]])
    sides = [
        Triangles(np.roll(square @ turn, shift, 1), np.roll(np.tile(turn[2], (4, 1)), shift, 1), faces)
        for turn in (np.eye(3), np.diag([1, -1, -1]))
        for shift in range(3)
    ]
    return join(sides)


def revolved(profile, around=AROUND) -> Triangles:
    """The surface that pieces of a profile sweep about z.

    profile : pieces, each (radii and heights (n, 2), their normals (n, 2)), in the direction that has the
        outside on its right.
    """
    angle = np.linspace(0, 2 * np.pi, around + 1)
    turn = np.column_stack([np.cos(angle), np.sin(angle)])
    parts = []

    for points, normals in profile:
        places, outward = (
            np.concatenate(
                [turn[:, None] * v[None, :, :1], np.broadcast_to(v[:, 1:], (around + 1, len(v), 1))], axis=2
            )
            for v in (np.asarray(points, float), np.asarray(normals, float))
        )
        n = len(points)
        k = (n * np.arange(around)[:, None] + np.arange(n - 1)).ravel()
        faces = np.concatenate(
            [np.column_stack([k, k + n, k + n + 1]), np.column_stack([k, k + n + 1, k + 1])]
        )
        surface = Triangles(places.reshape(-1, 3), outward.reshape(-1, 3), faces)
        parts.append(surface._replace(faces=faces[_areas(surface) > 0]))

    return join(parts)


def _areas(surface):
    a, b, c = (surface.points[surface.faces[:, k]] for k in range(3))
    areas = np.linalg.norm(np.cross(b - a, c - a), axis=1)
    return np.where(areas > 1e-12 * areas.max(initial=0.0), areas, 0.0)


def _straight(start, end):
    """A piece of a profile, straight."""
    (r0, z0), (r1, z1) = start, end
    normal = np.array([z1 - z0, r0 - r1]) / np.hypot(z1 - z0, r1 - r0)
    return np.array([start, end], float), np.array([normal, normal])


def _arc(radius, first, last, height=0.0, n=AROUND // 2):
    """A piece of a profile: a circle about (0, height) from one latitude (rad) to another."""
    angle = np.linspace(first, last, n + 1)
    normals = np.column_stack([np.cos(angle), np.sin(angle)])
    return radius * normals + [0.0, height], normals


@cache
def sphere() -> Triangles:
    """Of radius 1."""
    return revolved([_arc(1.0, -np.pi / 2, np.pi / 2)])


def cone(radius, top_radius, length) -> Triangles:
    """A cone, cut off where top_radius > 0; a cylinder where the two are equal."""
    h = length / 2
    corners = [(0, -h), (radius, -h), (top_radius, h), (0, h)]
    return revolved([_straight(a, b) for a, b in itertools.pairwise(corners) if a != b])


@cache
def cylinder() -> Triangles:
    """Of radius 1 and length 1."""
    return cone(1.0, 1.0, 1.0)


def tube(radius, inner_radius, length) -> Triangles:
    """A hollow cylinder, open at its ends."""
    h = length / 2
    corners = [(inner_radius, -h), (radius, -h), (radius, h), (inner_radius, h), (inner_radius, -h)]
    return revolved([_straight(a, b) for a, b in itertools.pairwise(corners)])


def capsule(radius, length) -> Triangles:
    """A cylinder with half a sphere at each end."""
    h, n = length / 2, AROUND // 4
    lower, upper = _arc(radius, -np.pi / 2, 0, -h, n), _arc(radius, 0, np.pi / 2, h, n)
    return revolved([tuple(np.concatenate(pair) for pair in zip(lower, upper))])


def grid(points) -> Triangles:
    """A surface through points (n, m, 3), with normals by differences."""
    n, m = points.shape[:2]
    normals = np.cross(np.gradient(points, axis=0), np.gradient(points, axis=1)).reshape(-1, 3)
    normals /= np.maximum(np.linalg.norm(normals, axis=1), 1e-30)[:, None]
    k = (m * np.arange(n - 1)[:, None] + np.arange(m - 1)).ravel()
    faces = np.concatenate([np.column_stack([k, k + m, k + m + 1]), np.column_stack([k, k + m + 1, k + 1])])
    return Triangles(points.reshape(-1, 3), normals, faces)


def rod(a, b, radius, around=10) -> Triangles:
    """A round rod from a to b (3,), with round ends: a ball where they are one."""
    a, b = np.asarray(a, float), np.asarray(b, float)
    length = np.linalg.norm(b - a)
    lower, upper = _arc(radius, -np.pi / 2, 0, -length / 2, 3), _arc(radius, 0, np.pi / 2, length / 2, 3)
    surface = revolved([tuple(np.concatenate(pair) for pair in zip(lower, upper))], around)
    axes = axes_with_z((b - a) / length) if length > 0.0 else np.eye(3)
    return moved(surface, (a + b) / 2, axes)


def polyline(points, radius, around=6) -> Triangles:
    """A thin tube along points (n, 3)."""
    along = np.gradient(points, axis=0)
    along /= np.maximum(np.linalg.norm(along, axis=1), 1e-30)[:, None]
    angle = np.linspace(0, 2 * np.pi, around + 1)
    x = np.cross(along, np.eye(3)[np.argmin(np.abs(along).max(axis=0))])
    x /= np.maximum(np.linalg.norm(x, axis=1), 1e-30)[:, None]
    y = np.cross(along, x)
    ring = x[:, None] * np.cos(angle)[None, :, None] + y[:, None] * np.sin(angle)[None, :, None]
    surface = grid(points[:, None] + radius * ring)
    return surface._replace(normals=ring.reshape(-1, 3))


def sharp(points, faces) -> Triangles:
    """A mesh with normals that keep edges of more than 40 degrees sharp: corners are parted there."""
    a, b, c = (points[faces[:, k]] for k in range(3))
    flat = np.cross(b - a, c - a)
    unit = flat / np.maximum(np.linalg.norm(flat, axis=1), 1e-30)[:, None]
    corner = faces.ravel()
    own = np.repeat(unit, 3, axis=0)
    # normals of a corner, by the area of the faces around it that turn little from this one
    mean = np.zeros_like(points)
    np.add.at(mean, corner, np.repeat(flat, 3, axis=0))
    mean = (mean / np.maximum(np.linalg.norm(mean, axis=1), 1e-30)[:, None])[corner]
    normals = np.where((mean * own).sum(axis=1)[:, None] > np.cos(np.radians(40)), mean, own)
    key = np.column_stack([corner, np.round(normals * 500)]).astype(np.int64)
    _, first, where = np.unique(key, axis=0, return_index=True, return_inverse=True)
    return Triangles(points[corner[first]], normals[first], where.reshape(-1, 3))
