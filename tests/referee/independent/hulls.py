"""Hulls in water by convex bodies: what is under z = 0 is the convex hull of the wet corners and of where lines between corners
cut the plane.
"""

from pathlib import Path

import numpy as np
import trimesh
from scipy.spatial import ConvexHull, QhullError

from .reading import orientation


def corners(options):
    """(n, 3) of a hull's options; a mesh must be convex."""
    if "box" in options:
        signs = np.array(np.meshgrid(*[[-1, 1]] * 3)).reshape(3, -1).T
        return signs / 2 * np.array(options["box"]["size"])

    if "cylinder" in options:
        n = int(options["cylinder"].get("sides", 64))
        turns = 2 * np.pi * (np.arange(n) + 0.5) / n
        area = np.pi * options["cylinder"]["radius"] ** 2
        reach = np.sqrt(area / (n / 2 * np.sin(2 * np.pi / n)))
        ring = reach * np.exp(1j * turns)
        half = options["cylinder"]["length"] / 2
        return np.array([[p.real, p.imag, z] for p in ring for z in (-half, half)])

    mesh = trimesh.load_mesh(Path(options["mesh"]["file"]))
    return np.array(mesh.vertices) * options["mesh"].get("scale", 1.0)


class Hull:
    """A closed convex hull on a frame."""

    kind = "hydrostatics"

    def __init__(self, given, name, force, sea):
        self.name, self.ends = name, [force["on"]]
        spec = force["hydrostatics"]
        r = np.array(spec.get("position", [0.0, 0.0, 0.0]))
        self.corners = r + corners(spec) @ orientation(spec).T
        self.density = given(sea.get("density", 1025.0), name, "density")

    def displaced(self, r, A, g):
        """All that water does to it at a pose, by the names of outputs; and its energy. g : m/s2."""
        at = r + self.corners @ A.T
        wet, dry = at[at[:, 2] <= 0], at[at[:, 2] > 0]
        t = wet[:, None, 2] / (wet[:, None, 2] - dry[None, :, 2])
        cuts = (wet[:, None] + t[..., None] * (dry[None] - wet[:, None])).reshape(-1, 3)
        volume, first = self._solid(np.vstack([wet, cuts]))
        area, centre, moments = self._plane(cuts[:, :2])
        centre_of_plane = np.append(centre, 0.0) if area > 0 else np.append(r[:2], 0.0)
        centre = first / volume if volume > 0 else np.append(r[:2], 0.0)
        force = np.array([0.0, 0.0, self.density * g * volume])
        return {
            "volume": volume, "center_of_buoyancy": centre, "draught": -at[:, 2].min(), "waterplane_area": area,
            "waterplane_center": centre_of_plane, "waterplane_moments": moments, "force": force,
            "moment": np.cross(centre - r, force), "energy": -self.density * g * first[2],
        }  # fmt: skip

    def _solid(self, points):
        """(volume, its first moments) of a convex hull of points."""
        try:
            hull = ConvexHull(points)
        except (QhullError, ValueError):
            return 0.0, np.zeros(3)

        inside = points.mean(axis=0)
        cells = points[hull.simplices] - inside
        volumes = np.abs(np.linalg.det(cells)) / 6
        centres = inside + cells.sum(axis=1) / 4
        return volumes.sum(), volumes @ centres

    def _plane(self, points):
        """(area, centre, second moments about it: y^2, x^2, x y) of a convex hull of points in the plane."""
        try:
            outline = points[ConvexHull(points).vertices]
        except (QhullError, ValueError):
            return 0.0, np.zeros(2), np.zeros(3)

        middle = outline.mean(axis=0)
        p = outline - middle
        q = np.roll(p, -1, axis=0)
        areas = (p[:, 0] * q[:, 1] - q[:, 0] * p[:, 1]) / 2
        area = areas.sum()
        centre = areas @ (p + q) / 3 / area
        second = np.einsum("n,ni,nj->ij", areas / 12, p, p) + np.einsum("n,ni,nj->ij", areas / 12, q, q)
        second += np.einsum("n,ni,nj->ij", areas / 12, p + q, p + q)
        second -= area * np.outer(centre, centre)
        return area, middle + centre, np.array([second[1, 1], second[0, 0], second[0, 1]])

    def act(self, now):
        """At an instant."""
        r, A, _, _ = now.frame(self.ends[0])
        told = self.displaced(r, A, -now.system.gravity[2])
        power = now.push(self.ends[0], told["force"], told["moment"])
        self.energy, self.now = told.pop("energy"), told | {"power": power}
