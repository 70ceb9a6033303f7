"""Forces between two frames, and on one: struts, 6x6 elements, loads."""

import numpy as np

from .efforts import Elastic
from .interpolation import Table
from .reading import cross, dotted, listed, si


def matrix6(values):
    """(6, 6) of a matrix or of its diagonal; zeros of none."""
    values = np.zeros((6, 6)) if values is None else np.array(values, float)
    return np.diag(values) if values.ndim == 1 else values


class Strut:
    """A force along the line between two frames. rest_length None: that at the start."""

    kind = "spring_damper"

    def __init__(self, given, name, force):
        spec = force["spring_damper"]
        self.name, self.ends = name, force["between"]
        self.has_input = "force" in listed(force.get("input"))
        table, damping = spec.get("table"), spec.get("damping", 0.0)
        rest = spec.get("rest_length")
        self.rest_is_of_start = (
            table is None and rest is None and dotted(name, "rest_length") not in given.values
        )

        if table is not None:
            self.spring = Elastic(table=table, keys=("length", "force"))
        else:
            rest = given(0.0 if rest is None else rest, name, "rest_length")
            self.spring = Elastic(given(spec["stiffness"], name, "stiffness"), rest)

        if isinstance(damping, dict):
            self.damper = Elastic(table=damping["table"], keys=("speed", "force"))
        else:
            self.damper = Elastic(given(damping, name, "damping"))

    def tensions(self, length, rate, pulled):
        """Tensions (N) of spring, damper and input."""
        return self.spring(length), self.damper(rate), pulled


class Torsion:
    """A spring and a damper along the twist of the second frame in the first."""

    kind = "torsion"

    def __init__(self, given, name, force):
        spec = force["torsion"]
        self.name, self.ends = name, force["between"]
        damping = spec.get("damping", 0.0)

        if spec.get("table") is not None:
            self.spring = Elastic(table=spec["table"])
        else:
            rest = given(si(spec, "rest", 0.0), name, "rest")
            self.spring = Elastic(given(spec["stiffness"], name, "stiffness"), rest)

        if isinstance(damping, dict):
            self.damper = Elastic(table=damping["table"], keys=("speed", "effort"))
        else:
            self.damper = Elastic(given(damping, name, "damping"))


class Six:
    """A linear element or a bushing: stiffness, damping, added mass, preload."""

    def __init__(self, given, name, force):
        self.kind = "linear" if "linear" in force else "bushing"
        spec = force[self.kind]
        self.name, self.ends = name, force["between"]
        self.K = given(matrix6(spec.get("stiffness")), name, "stiffness")
        self.D = given(matrix6(spec.get("damping")), name, "damping")
        added = matrix6(spec.get("added_mass"))
        self.added = given((added + added.T) / 2, name, "added_mass")
        self.preload = given(np.array(spec.get("preload") or np.zeros(6), float), name, "preload")
        self.axes = spec.get("axes", "first")
        self.adds = bool(np.any(self.added))

    def own_axes(self, turned, yaw):
        """Rotation to the first frame's axes of those that damping and added mass are given in. turned :
        of the second frame."""
        c, s = np.cos(yaw), np.sin(yaw)
        return {"first": np.eye(3), "body": turned, "heading": np.array([[c, -s, 0], [s, c, 0], [0, 0, 1]])}[
            self.axes
        ]

    def elastic(self, moved):
        """Generalised forces along (d, rx, ry, rz) of stiffness and preload."""
        return self.preload - self.K @ moved

    def drag(self, seen, turned, yaw):
        """Force and moment of damping, in the first frame's axes."""
        B = np.kron(np.eye(2), self.own_axes(turned, yaw))
        return -B @ self.D @ B.T @ seen

    def energy(self, moved):
        """J, of stiffness and preload, 0 at zero displacement."""
        return moved @ self.K @ moved / 2 - self.preload @ moved

    def dissipated(self, seen, moved, moving, turned, yaw):
        """W, by damping, and by what is not symmetric in the stiffness."""
        return -self.drag(seen, turned, yaw) @ seen + (moving @ self.K @ moved - moved @ self.K @ moving) / 2

    def water(self, seen, turned, yaw, yaw_slope):
        """(A, h): the added mass resists with A V' + h to (force, moment), in the first frame's axes;
        V = seen velocities.

        yaw_slope : the rate of the yaw is yaw_slope . w.
        """
        B = np.kron(np.eye(2), self.own_axes(turned, yaw))
        A = B @ self.added @ B.T

        if self.axes == "first":
            return A, np.zeros(6)

        v, w = seen[:3], seen[3:]

        # Kirchhoff: momenta p, L in axes that turn with w about a point that moves with v
        if self.axes == "body":
            p, L = np.split(A @ seen, 2)
            turning = np.concatenate([cross(w, v), cross(w, w)])
            return A, np.concatenate([cross(w, p), cross(w, L) + cross(v, p)]) - A @ turning

        # the Lagrangian of the yaw: d/dt (A V) less the slope of V.A V / 2
        Z = np.kron(np.eye(2), np.array([[0.0, -1, 0], [1, 0, 0], [0, 0, 0]]))
        slope = Z @ A - A @ Z
        return A, (yaw_slope @ w) * slope @ seen - np.concatenate(
            [np.zeros(3), seen @ slope @ seen / 2 * yaw_slope]
        )


class Load:
    """A force and a moment at a frame's origin, constant or over time."""

    kind = "load"

    def __init__(self, given, name, force):
        spec = force["load"]
        self.name, self.ends = name, [force["on"]]
        self.follows = spec.get("axes", "inertial") == "body"
        self.parts = []

        for key in ("force", "moment"):
            table = (spec.get("table") or {}).get(key)

            if table is not None:
                read = spec["table"].get("interpolation", "linear")
                columns = [
                    Table(read, spec["table"]["time"], column, beyond="hold")
                    for column in np.array(table, float).T
                ]
                self.parts.append(lambda t, columns=columns: np.array([column(t)[0] for column in columns]))
            else:
                value = given(np.array(spec.get(key) or np.zeros(3), float), name, key)
                self.parts.append(lambda t, value=value: value)

    def wrench(self, t):
        """(force, moment) at t, in its axes."""
        return self.parts[0](t), self.parts[1](t)
