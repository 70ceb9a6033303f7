"""Closed hulls as polygons whose corners turn left seen from outside."""

import itertools

import numpy as np

from ..vectors import dot

# of a hull's size: corners this near to a plane lie in it
FLAT = 1e-12

BOX = ((0, 2, 3, 1), (4, 5, 7, 6), (0, 1, 5, 4), (2, 6, 7, 3), (0, 4, 6, 2), (1, 3, 7, 5))


def hull_of(options):
    """(points (n, 3) in m, polygons: lists of their indices) of a hull's options, in its own axes."""
    if options.box:
        return _box(np.array(options.box.size))

    if options.cylinder:
        return _cylinder(options.cylinder.radius, options.cylinder.length, int(options.cylinder.sides))

    mesh = options.mesh.closed()
    return np.array(mesh.vertices), _merged(
        np.array(mesh.vertices), np.array(mesh.faces), mesh.face_adjacency
    )


def _box(size):
    """x runs fastest among the corners."""
    corners = [(x, y, z) for z, y, x in itertools.product((-0.5, 0.5), repeat=3)]
    return np.array(corners) * size, [list(polygon) for polygon in BOX]


def _cylinder(radius, length, n):
    """A prism of n sides along z with the volume of a round cylinder."""
    angles = 2 * np.pi * (np.arange(n) + 0.5) / n
    reach = radius * np.sqrt(2 * np.pi / n / np.sin(2 * np.pi / n))
    ring = reach * np.column_stack([np.cos(angles), np.sin(angles)])
    ends = [np.column_stack([ring, np.full(n, z)]) for z in (-length / 2, length / 2)]
    sides = [[k, (k + 1) % n, n + (k + 1) % n, n + k] for k in range(n)]
    return np.vstack(ends), [*sides, list(range(n))[::-1], list(range(n, 2 * n))]


def _merged(points, faces, neighbours):
    """Triangles, those that lie in one plane and share edges as one polygon where that has one outline."""
    normals, size = _normals(points, faces), np.ptp(points, axis=0).max()
    leader = list(range(len(faces)))

    def find(k):
        while leader[k] != k:
            leader[k] = k = leader[leader[k]]
        return k

    def in_plane(k, others):
        return np.abs(dot(points[others] - points[faces[k, 0]], normals[k])).max() <= FLAT * size

    for a, b in neighbours:
        if dot(normals[a], normals[b]) > 0.0 and in_plane(a, faces[b]) and in_plane(b, faces[a]):
            leader[find(a)] = find(b)

    groups = {}
    for k in range(len(faces)):
        groups.setdefault(find(k), []).append(k)

    return [polygon for group in groups.values() for polygon in _outline(faces[group], in_plane, group)]


def _normals(points, faces):
    """Unit normals of triangles, 0 of those without area."""
    a, b, c = (points[faces[:, k]] for k in range(3))
    normals = np.cross(b - a, c - a)
    lengths = np.linalg.norm(normals, axis=1)
    return normals / np.where(lengths > 0.0, lengths, 1.0)[:, None]


def _outline(faces, in_plane, group):
    """[the outline] of triangles in one plane, or these."""
    edges = {(int(f[k]), int(f[(k + 1) % 3])) for f in faces for k in range(3)}
    following = {a: b for a, b in edges if (b, a) not in edges}
    outline = [next(iter(following))] if following else []

    while outline and following[outline[-1]] != outline[0] and len(outline) <= len(following):
        outline.append(following[outline[-1]])

    is_one = len(outline) == len(following) == sum((b, a) not in edges for a, b in edges)
    flat = in_plane(group[0], np.unique(faces))
    return [outline] if is_one and flat and len(outline) > 2 else [[int(k) for k in face] for face in faces]
