"""Curves and surfaces by their parameters, in their markers' axes, with their derivatives there."""

import numpy as np
from scipy.interpolate import CubicSpline

CURVES = ("line", "circle", "parabola", "cycloid", "spline", "table")
SURFACES = ("plane", "sphere", "ellipsoid", "cylinder", "torus", "prism", "table")


class Curve:
    """A curve by s: `derivatives(s)` -> r, r', r'', r''' (4, 3)."""

    def __init__(self, table):
        self.kind = next(kind for kind in CURVES if kind in table)
        self.options = table[self.kind]

        if self.kind in ("spline", "table"):
            self._through(self.options)

    def _through(self, options):
        points = np.array([[*point, 0.0][:3] for point in options["points"]], float)
        self.closed = options.get("closed", False)
        points = np.vstack([points, points[:1]]) if self.closed else points
        s = options.get("s")
        self.s = (
            np.append(0.0, np.cumsum(np.linalg.norm(np.diff(points, axis=0), axis=1)))
            if s is None
            else np.array(s, float)
        )
        self.spline = CubicSpline(self.s, points, bc_type="periodic" if self.closed else "not-a-knot")

    def derivatives(self, s):
        """(4, 3): r and its first three derivatives at s."""
        R = self.options.get("radius", 0.0)

        if self.kind == "line":
            return np.array([[s, 0, 0], [1, 0, 0], [0, 0, 0], [0, 0, 0]], float)

        if self.kind == "circle":
            a = s / R
            turns = a + np.pi / 2 * np.arange(4)
            scale = R ** (1.0 - np.arange(4))
            return np.column_stack([scale * np.cos(turns), scale * np.sin(turns), np.zeros(4)])

        if self.kind == "parabola":
            c = self.options["coefficient"]
            return np.array([[s, c * s * s, 0], [1, 2 * c * s, 0], [0, 2 * c, 0], [0, 0, 0]], float)

        if self.kind == "cycloid":
            c, n = np.cos(s), np.sin(s)
            return R * np.array([[s + n, 1 - c, 0], [1 + c, n, 0], [-n, c, 0], [-c, -n, 0]])

        return self._of_spline(s)

    def _of_spline(self, s):
        """A closed one runs on, an open one goes on straight beyond its ends."""
        if self.closed:
            s = self.s[0] + (s - self.s[0]) % (self.s[-1] - self.s[0])

        inside = np.clip(s, self.s[0], self.s[-1])
        found = np.array([self.spline(inside, k) for k in range(4)])

        if inside != s:
            found = np.array([found[0] + (s - inside) * found[1], found[1], 0 * found[0], 0 * found[0]])

        return found

    def samples(self, near, count=400):
        """Parameters among which the closest point to a place (3,) is looked for."""
        R = self.options.get("radius", 0.0)
        reach = 2.0 + 2.0 * np.linalg.norm(near)
        ends = {
            "line": (-reach, reach), "circle": (-np.pi * R, np.pi * R), "parabola": (-reach, reach),
            "cycloid": (-reach / max(R, 1e-9) - 2.0, reach / max(R, 1e-9) + 2.0),
        }.get(self.kind)  # fmt: skip
        return np.linspace(*(ends or (self.s[0], self.s[-1])), count)


class Surface:
    """A surface by s1, s2: `derivatives(s1, s2)` -> r, r_1, r_2, r_11, r_12, r_22 (6, 3)."""

    def __init__(self, table):
        self.kind = next(kind for kind in SURFACES if kind in table)
        self.options = table[self.kind]

        # an ellipsoid is a unit sphere, stretched
        self.stretch = np.array(self.options.get("semi_axes", [1.0, 1.0, 1.0]), float)

        if self.kind == "prism":
            self.profile = Curve(self.options["profile"])

        if self.kind == "table":
            self.s1, self.s2 = (np.array(self.options[key], float) for key in ("s1", "s2"))
            self.first = CubicSpline(self.s1, np.array(self.options["points"], float))

    def derivatives(self, s1, s2):
        """(6, 3): r, its slopes and second slopes at (s1, s2)."""
        if self.kind == "plane":
            return np.array([[s1, s2, 0], [1, 0, 0], [0, 1, 0], [0, 0, 0], [0, 0, 0], [0, 0, 0]], float)

        if self.kind == "prism":
            r, t, tt, _ = self.profile.derivatives(s1)
            zero = np.zeros(3)
            return np.array([r + [0, 0, s2], t, [0, 0, 1], tt, zero, zero])

        if self.kind == "table":
            return self._of_grid(s1, s2)

        # points R(s1) + t(s2) around the z axis: radius and height by s2 with two derivatives
        radius, height = self._profile(s2)
        out, side = np.array([np.cos(s1), np.sin(s1), 0]), np.array([-np.sin(s1), np.cos(s1), 0])
        z = np.array([0.0, 0, 1])
        return self.stretch * np.array([
            radius[0] * out + height[0] * z, radius[0] * side, radius[1] * out + height[1] * z,
            -radius[0] * out, radius[1] * side, radius[2] * out + height[2] * z,
        ])  # fmt: skip

    def thirds(self, s1, s2):
        """(4, 3): r_111, r_112, r_122, r_222 at (s1, s2)."""
        found = np.zeros((4, 3))

        if self.kind == "prism":
            found[0] = self.profile.derivatives(s1)[3]
        elif self.kind == "table":
            D = self._derivatives_of_grid(s1, s2)
            found = np.array([D[3, 0], D[2, 1], D[1, 2], D[0, 3]])
        elif self.kind != "plane":
            radius, height = self._profile(s2)
            out, side = np.array([np.cos(s1), np.sin(s1), 0]), np.array([-np.sin(s1), np.cos(s1), 0])
            found = np.array([-radius[0] * side, -radius[1] * out, radius[2] * side, 0 * out])

            # a circle by its angle: its third derivative is the first one back
            if self.kind != "cylinder":
                found[3] = -radius[1] * out - height[1] * np.array([0, 0, 1.0])

        return self.stretch * found

    def _profile(self, s2):
        """(radius, height) of what turns about z, each with two derivatives by s2."""
        R = self.options.get("radius", 1.0)

        if self.kind == "cylinder":
            return (R, 0.0, 0.0), (s2, 1.0, 0.0)

        t, middle = (R, 0.0) if self.kind in ("sphere", "ellipsoid") else (self.options["tube"], R)
        c, s = t * np.cos(s2), t * np.sin(s2)
        return (middle + c, -s, -c), (s, c, -s)

    def _derivatives_of_grid(self, s1, s2):
        """Derivatives by (order of s1, order of s2) up to 3 of the spline of splines; beyond the edges straight on."""
        a, b = np.clip(s1, self.s1[0], self.s1[-1]), np.clip(s2, self.s2[0], self.s2[-1])
        rows = [CubicSpline(self.s2, self.first(a, k)) for k in range(4)]
        D = {(i, j): rows[i](b, j) for i in range(4) for j in range(4)}
        u, v = s1 - a, s2 - b

        # straight on along s1, then along s2
        if u:
            D = {(i, j): (D[0, j] + u * D[1, j], D[1, j], 0 * D[0, j], 0 * D[0, j])[i] for i, j in D}

        if v:
            D = {(i, j): (D[i, 0] + v * D[i, 1], D[i, 1], 0 * D[i, 0], 0 * D[i, 0])[j] for i, j in D}

        return D

    def _of_grid(self, s1, s2):
        """As `derivatives`."""
        D = self._derivatives_of_grid(s1, s2)
        return np.array([D[0, 0], D[1, 0], D[0, 1], D[2, 0], D[1, 1], D[0, 2]])

    def samples(self, near, count=60):
        """Pairs of parameters among which the closest point to a place (3,) is looked for."""
        reach = 2.0 + 2.0 * np.linalg.norm(near)
        turn = (-np.pi, np.pi)
        ends = {
            "plane": ((-reach, reach),) * 2, "sphere": (turn, (-np.pi / 2, np.pi / 2)),
            "ellipsoid": (turn, (-np.pi / 2, np.pi / 2)),
            "cylinder": (turn, (-reach, reach)),
            "torus": (turn, turn),
        }.get(self.kind)  # fmt: skip

        if self.kind == "prism":
            first, second = self.profile.samples(near, count), np.linspace(-reach, reach, count)
        elif self.kind == "table":
            first, second = (np.linspace(s[0], s[-1], count) for s in (self.s1, self.s2))
        else:
            first, second = (np.linspace(*end, count) for end in ends)

        return np.array([[a, b] for a in first for b in second])
