"""Mass, centre of mass and inertia of bodies: given, or of solids of uniform density."""

import re
from pathlib import Path

import numpy as np

from .reading import axis, orientation, pose

KINDS = ("sphere", "box", "cylinder", "tube", "point", "mesh")


def volume(kind, shape):
    """m3."""
    if kind == "sphere":
        return 4 / 3 * np.pi * shape["radius"] ** 3

    if kind == "box":
        return np.prod(shape["size"])

    return np.pi * (shape["radius"] ** 2 - shape.get("inner_radius", 0.0) ** 2) * shape["length"]


def own_inertia(kind, shape):
    """Tensor (3, 3) per unit of mass about the centre, m2; round ones along z."""
    if kind == "point":
        return np.zeros((3, 3))

    if kind == "sphere":
        return 0.4 * shape["radius"] ** 2 * np.eye(3)

    # integral of (r.r 1 - r r^T) from the second moments along the axes
    if kind == "box":
        second = np.square(shape["size"]) / 12
    else:
        radii = shape["radius"] ** 2 + shape.get("inner_radius", 0.0) ** 2
        second = np.array([radii / 4, radii / 4, shape["length"] ** 2 / 12])

    return np.diag(second.sum() - second)


def of_solid(solid):
    """(mass kg, centre (3,) m, inertia (3, 3) kg m2 about it) of a solid, in the body's axes."""
    kind = next(kind for kind in KINDS if kind in solid)
    shape = solid[kind]

    if kind == "mesh":
        return of_mesh(solid, shape)

    mass = shape["mass"] if shape.get("mass") is not None else shape["density"] * volume(kind, shape)
    centre, A = pose(solid)
    inertia = own_inertia(kind, shape)

    if kind in ("cylinder", "tube"):
        along = axis(solid.get("axis", "z"))
        inertia = inertia[0, 0] * np.eye(3) + (inertia[2, 2] - inertia[0, 0]) * np.outer(along, along)

    return mass, centre, mass * A @ inertia @ A.T


def of_mesh(solid, shape):
    """The same of what a closed surface of triangles (an STL file of text) encloses: tetrahedra on the origin."""
    numbers = re.findall(r"vertex\s+(\S+)\s+(\S+)\s+(\S+)", Path(shape["file"]).read_text())
    corners = np.array(numbers, float).reshape(-1, 3, 3) * shape.get("scale", 1.0)
    volumes = np.linalg.det(corners) / 6
    sums = corners.sum(axis=1)
    volume = volumes.sum()
    centre = (volumes[:, None] * sums).sum(axis=0) / (4 * volume)
    # integral of r r^T over a tetrahedron with a corner at the origin
    squares = np.einsum("fki,fkj->fij", corners, corners) + np.einsum("fi,fj->fij", sums, sums)
    second = (volumes[:, None, None] * squares).sum(axis=0) / 20 - volume * np.outer(centre, centre)
    density = shape["mass"] / volume if shape.get("mass") is not None else shape["density"]
    origin, A = pose(solid)
    inertia = density * (np.trace(second) * np.eye(3) - second)
    return density * volume, origin + A @ centre, A @ inertia @ A.T


def tensor(values):
    """(3, 3) of [ixx, iyy, izz], of [ixx, iyy, izz, ixy, ixz, iyz], or of a matrix; ixy = I[0][1]."""
    values = np.asarray(values, float)

    if values.shape == (3, 3):
        return (values + values.T) / 2

    full = np.diag(values[:3])

    if len(values) == 6:
        full[[0, 0, 1], [1, 2, 2]] = full[[1, 2, 2], [0, 0, 1]] = values[3:]

    return full


def mass_properties(body):
    """(mass kg, centre of mass (3,) m, inertia (3, 3) kg m2 about it), in the body's own axes."""
    if body.get("solid") is not None:
        solids = body["solid"] if isinstance(body["solid"], (list, tuple)) else [body["solid"]]
        parts = [of_solid(solid) for solid in solids]
        mass = sum(m for m, _, _ in parts)
        com = sum(m * c for m, c, _ in parts) / mass
        steiner = (m * ((c - com) @ (c - com) * np.eye(3) - np.outer(c - com, c - com)) for m, c, _ in parts)
        return mass, com, sum(I for _, _, I in parts) + sum(steiner)

    A = orientation(body.get("inertia_axes") or {})
    inertia = tensor(body.get("inertia") or [0.0, 0.0, 0.0])
    return body["mass"], np.asarray(body.get("com", (0.0, 0.0, 0.0)), float), A @ inertia @ A.T
