"""Convex surfaces by their outward normal: the point that lies farthest along it (docs/theory.md 10.5)."""

from ..language import inlined, kernel
from ..math import algebra as al
from . import surfaces


# rad: a wheel that lies flatter touches all around
FLAT = 1e-6


@inlined
def lies_flat(m, k, normal):
    """Whether surface k touches all around where its outward unit normal is `normal`."""
    return m.surface_kind[k] == surfaces.TORUS and abs(normal[0]) + abs(normal[1]) < FLAT


@kernel
def support(m, k, normal):
    """(c, C) of surface k where its outward unit normal is `normal`: the point (m) and dc/dnormal, symmetric, in its axes.

    A sphere, an ellipsoid, or of a torus, or a disk with an edge, the outer half: none other has it.
    """
    if m.surface_kind[k] == surfaces.TORUS:
        radius = m.surface_value[3 * k]
        tube = m.surface_value[3 * k + 1]
        length = al.norm((normal[0], normal[1], 0.0))
        out = (normal[0] / length, normal[1] / length, 0.0) if length > 0.0 else surfaces.X
        length = max(length, FLAT)
        along = (-out[1], out[0], 0.0)
        C = al.outer(al.scale(radius / length, along), along)
        across = al.mat_sub(((1.0, 0.0, 0.0), (0.0, 1.0, 0.0), (0.0, 0.0, 1.0)), al.outer(normal, normal))
        C = al.mat_add(C, (al.scale(tube, across[0]), al.scale(tube, across[1]), al.scale(tube, across[2])))
        return al.axpy(radius, out, al.scale(tube, normal)), C

    y = surfaces.stretched(m, k, normal)
    h = al.norm(y)
    c = al.scale(1.0 / h, surfaces.stretched(m, k, y))
    a = m.surface_value[3 * k]
    b = m.surface_value[3 * k + 1]
    d = m.surface_value[3 * k + 2]
    C = al.mat_sub(((a * a, 0.0, 0.0), (0.0, b * b, 0.0), (0.0, 0.0, d * d)), al.outer(c, c))
    return c, (al.scale(1.0 / h, C[0]), al.scale(1.0 / h, C[1]), al.scale(1.0 / h, C[2]))


@inlined
def bearer(m, k, x):
    """Of a normal x of surface k, or the rate of one: the vector whose longitude and latitude are its parameters there."""
    return x if m.surface_kind[k] == surfaces.TORUS else surfaces.stretched(m, k, x)


@inlined
def size(m, k):
    """The farthest that surface k goes from its origin (m)."""
    one = m.surface_value[3 * k]
    two = m.surface_value[3 * k + 1]
    return one + two if m.surface_kind[k] == surfaces.TORUS else max(one, two, m.surface_value[3 * k + 2])
