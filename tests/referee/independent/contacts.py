"""End frames on curves and surfaces: where they touch, and their equations over tau."""

import casadi as ca
import numpy as np
from scipy.optimize import least_squares

from .curves import Curve, Surface
from .joints import touching

# parameters s of a joint of end frames
COUNT = {"point_on_curve": 1, "curve_on_curve": 2, "point_on_surface": 2}


def equations(kind, pair, acceleration, tau):
    """(what is 0 over tau, the symbols of rates of s and of derivatives of the shapes). acceleration :
    second rates of s."""
    rate = ca.SX.sym("s_rate", COUNT[kind])
    step = rate * tau + acceleration * tau**2 / 2
    symbols, points = [rate], []

    if kind == "point_on_surface":
        D = ca.SX.sym("surface", 3, 6)
        u, v = step[0], step[1]
        point = (
            D[:, 0] + u * D[:, 1] + v * D[:, 2] + u**2 / 2 * D[:, 3] + u * v * D[:, 4] + v**2 / 2 * D[:, 5]
        )
        return touching(kind, pair, [(point, None)]), ca.vertcat(rate, ca.vec(D))

    for k in range(COUNT[kind]):
        D, u = ca.SX.sym("curve", 3, 4), step[k]
        symbols.append(ca.vec(D))
        point = D[:, 0] + u * D[:, 1] + u**2 / 2 * D[:, 2] + u**3 / 6 * D[:, 3]
        points.append((point, D[:, 1] + u * D[:, 2] + u**2 / 2 * D[:, 3]))

    return touching(kind, pair, points), ca.vertcat(*symbols)


class Contact:
    """Of a joint of end frames: its shapes, its parameters s (count of them)."""

    def __init__(self, joint, tables):
        self.joint = joint
        self.on_surface = joint.kind == "point_on_surface"
        shape = Surface if self.on_surface else Curve
        which = tables if joint.kind == "curve_on_curve" else tables[:1]
        self.shapes = [shape(table["surface" if self.on_surface else "curve"]) for table in which]
        self.count = COUNT[joint.kind]

    def numbers(self, s, rate):
        """What these symbols are."""
        if self.on_surface:
            return np.concatenate([rate, self.shapes[0].derivatives(*s).ravel()])

        return np.concatenate(
            [rate, *(shape.derivatives(s[k]).ravel() for k, shape in enumerate(self.shapes))]
        )

    # where they touch

    def find(self, pair, near):
        """Parameters s (count,) of the closest point, or of the common tangent; near : where to begin, None:
        searched for."""
        (r1, A1, _, _), (r2, A2, _, _) = pair
        d, R = A1.T @ (r2 - r1), A1.T @ A2
        if near is not None and (s := self._newton(np.ravel(near), d, R)) is not None:
            return s

        near = self._search(d, R) if near is None else np.ravel(near)
        found = least_squares(
            lambda s: self._apart(s, d, R)[0], near, lambda s: self._apart(s, d, R)[1], xtol=1e-15, gtol=1e-15
        )
        s = self._newton(found.x, d, R)
        return found.x if s is None else s

    def _newton(self, s, d, R):
        """The parameters near s where `_apart` is 0, to rounding;
        None where that does not lead anywhere near."""
        for _ in range(12):
            value, slope = self._apart(s, d, R)
            step = -np.linalg.lstsq(slope, value, rcond=1e-13)[0]
            s = s + step

            if np.abs(step).max() <= 1e-14 * (1.0 + np.abs(s).max()):
                break

        return s if np.abs(step).max() <= 1e-9 * (1.0 + np.abs(s).max()) else None

    def _apart(self, s, d, R):
        """(what is 0 at the parameters, its Jacobian): distances along the tangents,
        and the angle between two curves."""
        if self.joint.kind == "curve_on_curve":
            here, there = self.shapes[0].derivatives(s[0]), self.shapes[1].derivatives(s[1]) @ R.T
            apart = d + there[0] - here[0]
            value = [here[1] @ apart, np.cross(here[1], there[1])[2]]
            slope = [
                [here[2] @ apart - here[1] @ here[1], here[1] @ there[1]],
                [np.cross(here[2], there[1])[2], np.cross(here[1], there[2])[2]],
            ]
            return np.array(value), np.array(slope)

        D = self.shapes[0].derivatives(*s)
        e = d - D[0]

        if self.on_surface:
            second = np.array([[D[3] @ e, D[4] @ e], [D[4] @ e, D[5] @ e]])
            return D[1:3] @ e, second - D[1:3] @ D[1:3].T

        return np.array([D[1] @ e]), np.array([[D[2] @ e - D[1] @ D[1]]])

    def _search(self, d, R):
        """The best of many parameters."""
        if self.joint.kind == "curve_on_curve":
            grids = np.array(
                [[a, b] for a in self.shapes[0].samples(d, 60) for b in self.shapes[1].samples(R.T @ d, 60)]
            )
            here, there = (
                [shape.derivatives(s) for s in column] for shape, column in zip(self.shapes, grids.T)
            )
            gaps = [np.linalg.norm((d + R @ b[0] - a[0])[:2]) for a, b in zip(here, there)]
        elif self.on_surface:
            grids = self.shapes[0].samples(d)
            gaps = [np.linalg.norm(d - self.shapes[0].derivatives(*s)[0]) for s in grids]
        else:
            grids = self.shapes[0].samples(d)[:, None]
            gaps = [np.linalg.norm(d - self.shapes[0].derivatives(s[0])[0]) for s in grids]

        return grids[int(np.argmin(gaps))]
