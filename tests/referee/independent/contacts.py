"""End frames on curves and surfaces: where they touch, and their equations over tau."""

import casadi as ca
import numpy as np
from scipy.optimize import least_squares

from .curves import Curve, Surface
from .joints import touching
from .reading import axis
from .taylor import vee

# parameters s of a joint of end frames; those that leave a spin free have a word more
COUNT = {
    "point_on_curve": 1, "curve_on_curve": 2, "point_on_surface": 2, "frame_on_curve": 1, "frame_on_curve free": 1,
    "frame_on_surface": 2, "frame_on_surface free": 2,
}  # fmt: skip


def along(u, n):
    """Axes (3, 3) with x along u and z along n, which are normal to each other."""
    i, k = u / ca.norm_2(u), n / ca.norm_2(n)
    return ca.horzcat(i, ca.cross(k, i), k)


def held(kind, E, R):
    """What is 0 where axes R are those of the end frame, E, but for a free spin about x or z."""
    seen = E.T @ R

    if not kind.endswith("free"):
        return vee(seen)

    return ca.vertcat(seen[1, 0], seen[2, 0]) if "curve" in kind else ca.vertcat(seen[0, 2], seen[1, 2])


def framed(kind, pair, step, rate):
    """`equations` of a joint that holds a frame to that of its curve or surface, too."""
    if "curve" in kind:
        D, side, u = ca.SX.sym("curve", 3, 4), ca.SX.sym("side", 3), step[0]
        point = D[:, 0] + u * D[:, 1] + u**2 / 2 * D[:, 2] + u**3 / 6 * D[:, 3]
        tangent = D[:, 1] + u * D[:, 2] + u**2 / 2 * D[:, 3]
        E = along(tangent, ca.cross(tangent, side))
        symbols = [rate, ca.vec(D), side]
    else:
        D, u, v = ca.SX.sym("surface", 3, 10), step[0], step[1]
        point = (
            D[:, 0] + u * D[:, 1] + v * D[:, 2] + u**2 / 2 * D[:, 3] + u * v * D[:, 4] + v**2 / 2 * D[:, 5]
        )
        first = (
            D[:, 1] + u * D[:, 3] + v * D[:, 4] + u**2 / 2 * D[:, 6] + u * v * D[:, 7] + v**2 / 2 * D[:, 8]
        )
        second = (
            D[:, 2] + u * D[:, 4] + v * D[:, 5] + u**2 / 2 * D[:, 7] + u * v * D[:, 8] + v**2 / 2 * D[:, 9]
        )
        E = along(first, ca.cross(first, second))
        symbols = [rate, ca.vec(D)]

    return ca.vertcat(pair.d - point, held(kind, E, pair.R)), ca.vertcat(*symbols)


def equations(kind, pair, acceleration, tau):
    """(what is 0 over tau, the symbols of rates of s and of derivatives of the shapes). acceleration :
    second rates of s."""
    rate = ca.SX.sym("s_rate", COUNT[kind])
    step = rate * tau + acceleration * tau**2 / 2
    symbols, points = [rate], []

    if kind.startswith("frame"):
        return framed(kind, pair, step, rate)

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
        self.on_surface = "surface" in joint.kind
        self.framed = joint.kind.startswith("frame")
        self.side = axis(joint.options.get("side") or "z")
        shape = Surface if self.on_surface else Curve
        which = tables if joint.kind == "curve_on_curve" else tables[:1]
        self.shapes = [shape(table["surface" if self.on_surface else "curve"]) for table in which]
        self.count = COUNT[joint.kind]

    def numbers(self, s, rate):
        """What these symbols are."""
        if self.on_surface:
            D = [self.shapes[0].derivatives(*s), *([self.shapes[0].thirds(*s)] if self.framed else [])]
            return np.concatenate([rate, np.ravel(np.vstack(D))])

        if self.framed:
            return np.concatenate([rate, self.shapes[0].derivatives(*s).ravel(), self.side])

        return np.concatenate(
            [rate, *(shape.derivatives(s[k]).ravel() for k, shape in enumerate(self.shapes))]
        )

    def axes(self, s):
        """(3, 3) by row: tangent, binormal, normal at s."""
        D = self.shapes[0].derivatives(*s[: 2 if self.on_surface else 1])
        k = np.cross(D[1], D[2] if self.on_surface else self.side)
        i, k = D[1] / np.linalg.norm(D[1]), k / np.linalg.norm(k)
        return np.array([i, np.cross(k, i), k])

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
