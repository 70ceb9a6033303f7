"""End frames on curves and surfaces: where they touch, and their equations over tau."""

import casadi as ca
import numpy as np
from scipy.optimize import least_squares

from .curves import Curve, Surface
from .joints import touching


class Contact:
    """Of a joint of end frames: its shapes, its parameters s (count of them)."""

    def __init__(self, joint, tables):
        self.joint = joint
        self.on_surface = joint.kind == "point_on_surface"
        shape = Surface if self.on_surface else Curve
        which = tables if joint.kind == "curve_on_curve" else tables[:1]
        self.shapes = [shape(table["surface" if self.on_surface else "curve"]) for table in which]
        self.count = 1 if joint.kind == "point_on_curve" else 2

    def equations(self, pair, acceleration, tau):
        """(what is 0 over tau, the symbols of rates of s and of derivatives of the shapes). acceleration : second rates of s."""
        rate = ca.SX.sym("s_rate", self.count)
        step = rate * tau + acceleration * tau**2 / 2
        symbols, points = [rate], []

        for k, _ in enumerate(self.shapes):
            D = ca.SX.sym("shape", 3, 6 if self.on_surface else 4)
            symbols.append(ca.vec(D))

            if self.on_surface:
                u, v = step[0], step[1]
                point = D[:, 0] + u * D[:, 1] + v * D[:, 2] + u**2 / 2 * D[:, 3] + u * v * D[:, 4] + v**2 / 2 * D[:, 5]
                points.append((point, None))
            else:
                u = step[k]
                point = D[:, 0] + u * D[:, 1] + u**2 / 2 * D[:, 2] + u**3 / 6 * D[:, 3]
                points.append((point, D[:, 1] + u * D[:, 2] + u**2 / 2 * D[:, 3]))

        return touching(self.joint.kind, pair, points), ca.vertcat(*symbols)

    def numbers(self, s, rate):
        """What these symbols are."""
        if self.on_surface:
            return np.concatenate([rate, self.shapes[0].derivatives(*s).ravel()])

        return np.concatenate([rate, *(shape.derivatives(s[k]).ravel() for k, shape in enumerate(self.shapes))])

    # where they touch

    def find(self, pair, near):
        """Parameters s (count,) of the closest point, or of the common tangent, from `near` on; searched for where that is None."""
        (r1, A1, _, _), (r2, A2, _, _) = pair
        d, R = A1.T @ (r2 - r1), A1.T @ A2
        near = self._search(d, R) if near is None else np.ravel(near)
        return least_squares(lambda s: self._apart(s, d, R), near, xtol=1e-15, ftol=1e-15, gtol=1e-15).x

    def _apart(self, s, d, R):
        """What is 0 at the parameters."""
        if self.joint.kind == "curve_on_curve":
            here, there = (shape.derivatives(s[k]) for k, shape in enumerate(self.shapes))
            apart = d + R @ there[0] - here[0]
            t, o = here[1] / np.linalg.norm(here[1]), R @ there[1] / np.linalg.norm(there[1])
            return np.array([t @ apart, t[0] * o[1] - t[1] * o[0]])

        D = self.shapes[0].derivatives(*s)
        tangents = D[1:3] if self.on_surface else D[1:2]
        return tangents @ (d - D[0]) / np.maximum(np.linalg.norm(tangents, axis=1), 1e-12)

    def _search(self, d, R):
        """The best of many parameters."""
        if self.joint.kind == "curve_on_curve":
            grids = np.array([[a, b] for a in self.shapes[0].samples(d, 60) for b in self.shapes[1].samples(R.T @ d, 60)])
            here, there = ([shape.derivatives(s) for s in column] for shape, column in zip(self.shapes, grids.T))
            gaps = [np.linalg.norm((d + R @ b[0] - a[0])[:2]) for a, b in zip(here, there)]
        elif self.on_surface:
            grids = self.shapes[0].samples(d)
            gaps = [np.linalg.norm(d - self.shapes[0].derivatives(*s)[0]) for s in grids]
        else:
            grids = self.shapes[0].samples(d)[:, None]
            gaps = [np.linalg.norm(d - self.shapes[0].derivatives(s[0])[0]) for s in grids]

        return grids[int(np.argmin(gaps))]
