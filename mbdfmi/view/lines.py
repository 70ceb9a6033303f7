"""Mooring lines in pictures: their true shape at any instant.

A line's shape in its vertical plane is a function of how far apart and how high its ends are: the kernels
give it at the nodes of a grid over the distances that a run has, few modes of it tell the points in between.
So a page follows the bodies at any time, between the rows of a run too, and does not grow with the run.
"""

from dataclasses import dataclass

import numpy as np

from ..run import line_shapes
from ..scene.looks import red_green_blue
from ..threads import one_thread
from . import forms
from .numbers import exact, packed

# points along a line, at least, and of a section
POINTS, LEAST_POINTS = 32, 6

# m, and of a line's length: how far a point of the page may be off
OFF, OFF_BY_LENGTH = 1e-2, 2e-5

# nodes of the table of one line
MOST_NODES = 500

# of the radius of the picture: radius of lines. of that: the least radius of weights and buoys
THIN, LEAST_BALL = 0.003, 3.0

# kg/m3, of weights where a scene does not tell their volume
STEEL = 7850.0

# of the farthest end from their middle
BED = 1.15

LINE, LYING, WEIGHT, BUOY, SAND = "#2b2f36", "#c0702a", "#5a5f66", "#e0a100", "#b9a27a"
BED_OPACITY = 0.3


@dataclass
class Drawn:
    """A line of a picture with n rows.

    ends : of its scene. a, b : (n, 3) m, where they are, up : (n, 3), all in the picture's axes. x, z :
        (n,) m, across and up from a to b. s : (p,) m, unstretched, of its points; of one section on a bed
        by shares of what hangs, after a point more at its first end. bed : whether it has one. balls :
        (point, radius (m), whether it floats) of weights and buoys.
    """

    name: str
    ends: tuple
    a: np.ndarray
    b: np.ndarray
    up: np.ndarray
    x: np.ndarray
    z: np.ndarray
    s: np.ndarray
    bed: bool
    balls: list
    line: line_shapes.Line
    m: object
    d: object

    @property
    def off(self):
        """m, by which a point may be off in a page."""
        return min(OFF, OFF_BY_LENGTH * self.s[-1])

    def shape(self, x, z):
        """(n, p, 2) m: the points across and up from its first end, by the kernels."""
        of = line_shapes.hang(self.m, self.d, self.line, x, z)
        s = self.s

        if self.bed and not self.line.composite:
            # points that go with where it leaves the bed: the shape is smooth by the distances then
            flat = of.length[:, :1]
            s = np.column_stack([np.zeros(len(flat)), flat + (s[-1] - flat) * s / s[-1]])

        found = line_shapes.points(of, s)

        # rounding takes nothing below the bed, but where the second end is
        if self.bed:
            found[:, :-1, 1] = np.maximum(found[:, :-1, 1], 0.0)

        return found

    def points(self, rows):
        """(len(rows), p, 3) m, in the picture's frame."""
        span = self.b[rows] - self.a[rows]
        up = self.up[rows]
        away = span - self.z[rows, None] * up
        away /= np.maximum(np.linalg.norm(away, axis=1), 1e-30)[:, None]
        flat = self.shape(self.x[rows], self.z[rows])
        return self.a[rows, None] + flat[:, :, :1] * away[:, None] + flat[:, :, 1:] * up[:, None]


def lines(picture) -> list[Drawn]:
    """The mooring lines of a picture."""
    scene, states, moves = picture.scene, picture.states, picture.moves
    rows = line_shapes.lines_of(scene)

    if not rows:
        return []

    m, d = states.at(0)
    up = moves.inertial[1][:, 2]
    found = []

    for name, line in rows.items():
        ends = tuple(scene.force[name].between)
        a, b = (picture.ends(end) for end in ends)
        z = np.einsum("ni,ni->n", b - a, up)
        x = np.linalg.norm(b - a - z[:, None] * up, axis=1)
        lengths, _, _, hung = line.sections(m)
        s, meets = _places(lengths)
        balls = _balls(scene.force[name].catenary, hung, meets)
        found.append(Drawn(name, ends, a, b, up, x, z, s, line.has_bed(m), balls, line, m, d))

    return found


def _places(lengths):
    """(m along a line, unstretched, of its points; at which of them its sections end)."""
    s, meets = [0.0], []

    for length in lengths:
        n = max(LEAST_POINTS, round(POINTS * length / lengths.sum()))
        s += (s[-1] + length * np.arange(1, n + 1) / n).tolist()
        meets.append(len(s) - 1)

    return np.array(s), meets


def _balls(spec, hung, meets):
    """Weights and buoys, of their own size; hung : N, in water."""
    found = []

    for section, weight, point in zip(spec.parts, hung, meets):
        if section.clump is not None:
            volume = section.clump.volume or section.clump.mass / STEEL
            found.append((point, (3 * volume / (4 * np.pi)) ** (1 / 3), bool(weight < 0.0)))

    return found


def surfaces(picture, row, reach):
    """(surface, colour) of all lines at a row of the picture, in its frame; reach : its radius, m."""
    radius = THIN * reach

    for line in picture.lines:
        points = line.points([row])[0]
        flat = line.shape(line.x[[row]], line.z[[row]])[0, :, 1]
        lies = (np.maximum(flat[1:], flat[:-1]) < line.off) & line.bed

        # stretches that hang and that lie, one after another
        for part in np.split(np.arange(len(lies)), np.flatnonzero(np.diff(lies)) + 1):
            colour = LYING if lies[part[0]] else LINE
            yield forms.polyline(points[part[0] : part[-1] + 2], radius), red_green_blue(colour)

        for point, size, floats in line.balls:
            ball = 3 * [max(size, LEAST_BALL * radius)]
            colour = red_green_blue(BUOY if floats else WEIGHT)
            yield forms.moved(forms.sphere(), points[point], np.eye(3), ball), colour


def beds(picture):
    """[(centre (3,) with y up, radius)] of the bed where lines may lie on it, one of each height."""
    levels = {}

    for line in picture.lines:
        if line.bed:
            a, b = line.a[0] @ picture.root.T, line.b[0] @ picture.root.T
            levels.setdefault(float(f"{a[1]:.6g}"), []).extend([a, b])

    return [_disk(height, np.array(ends)[:, [0, 2]]) for height, ends in sorted(levels.items())]


def _disk(height, ends):
    middle = (ends.min(axis=0) + ends.max(axis=0)) / 2
    radius = BED * float(np.linalg.norm(ends - middle, axis=1).max())
    return [float(middle[0]), height, float(middle[1])], max(radius, 1e-9)


@one_thread()
def told_lines(picture):
    """The page's data of its lines, None without."""
    if not picture.lines or turns(picture):
        return None

    items, radius = [], THIN * picture.reach[1]

    for line in picture.lines:
        ends = []

        for end, at in zip(line.ends, (line.a, line.b)):
            body, r, _ = picture.scene.marker_pose(end)
            fixed = body == "inertial"
            ends.append({"body": None if fixed else body, "r": (at[0] if fixed else r).tolist()})

        balls = [
            {"at": point, "radius": max(size, LEAST_BALL * radius), "floats": floats}
            for point, size, floats in line.balls
        ]
        items.append(
            {
                "name": line.name,
                "ends": ends,
                "bed": line.bed,
                "off": line.off,
                "balls": balls,
                "table": table(line).packed(),
            }
        )

    return {
        "radius": radius,
        "up": picture.moves.inertial[1][0, 2].tolist(),
        "colours": {"line": LINE, "lying": LYING, "weight": WEIGHT, "buoy": BUOY},
        "bed": {"colour": SAND, "opacity": BED_OPACITY},
        "beds": beds(picture),
        "items": items,
    }


def turns(picture):
    """Whether what is up turns in the picture's frame: its page has no lines then."""
    up = picture.moves.inertial[1][:, 2]
    return bool(np.ptp(up, axis=0).max() > 1e-9)


@dataclass
class Table:
    """Shapes of a line by (x, z): at each node of a grid the shares of some modes of its points.

    first, step : (2,) m, of x and z at the nodes. shares : (n_x, n_z, modes) m. mean : (p, 2) m. modes :
        (modes, p, 2).
    """

    first: np.ndarray
    step: np.ndarray
    shares: np.ndarray
    mean: np.ndarray
    modes: np.ndarray

    def packed(self):
        """Ready for JSON."""
        n_x, n_z, rank = self.shares.shape
        return {
            "first": self.first.tolist(),
            "step": self.step.tolist(),
            "nodes": [n_x, n_z],
            "shares": [packed(self.shares[:, :, k].ravel()) for k in range(rank)],
            "mean": exact(self.mean.ravel()),
            "modes": packed(self.modes.ravel()) if len(self.modes) else exact(self.modes.ravel()),
        }

    def at(self, x, z):
        """(p, 2) m: the points at distances of the ends, as the page finds them."""
        at, part = [], []

        for value, first, step, n in zip((x, z), self.first, self.step, self.shares.shape):
            place = np.clip((value - first) / step, 0.0, n - 1.0)
            at.append(min(int(place), max(n - 2, 0)))
            part.append(place - at[-1])

        ends = [[k, min(k + 1, n - 1)] for k, n in zip(at, self.shares.shape)]
        corners = self.shares[np.ix_(*ends)]
        weight = np.outer([1 - part[0], part[0]], [1 - part[1], part[1]])
        return self.mean + np.tensordot(np.tensordot(weight, corners, 2), self.modes, 1)


def table(line) -> Table:
    """A table of the distances that a run has, so fine that points in between are right."""
    low = np.array([line.x.min(), line.z.min()])
    reach = np.array([line.x.max(), line.z.max()]) - low
    nodes = np.where(reach > line.off, 3, 1)

    while True:
        step = np.where(nodes > 1, reach / np.maximum(nodes - 1, 1), 1.0)
        grid = np.meshgrid(*(f + h * np.arange(n) for f, h, n in zip(low, step, nodes)), indexing="ij")
        shapes = line.shape(grid[0].ravel(), grid[1].ravel()).reshape(*nodes, -1, 2)
        off = np.array([_between(shapes, axis) for axis in (0, 1)])
        finer = np.where(off > line.off / 2, np.ceil((nodes - 1) * np.sqrt(off / (line.off / 3))) + 1, nodes)

        if (finer <= nodes).all() or nodes.prod() >= MOST_NODES:
            break

        # of what is not affordable, both are less fine
        share = min(1.0, np.sqrt(MOST_NODES / finer.prod()))
        nodes = np.maximum(nodes, np.minimum(finer, np.ceil(share * finer))).astype(int)

    flat = shapes.reshape(nodes.prod(), -1)
    mean, modes, shares = principal(flat, line.off)
    return Table(
        low,
        step,
        shares.reshape(*nodes, len(modes)),
        mean.reshape(-1, 2),
        modes.reshape(len(modes), len(mean) // 2, 2),
    )


def principal(flat, off):
    """(mean (m,), modes (k, m), shares (n, k)) of rows (n, m), none of which is off by a quarter of `off`."""
    mean = flat.mean(axis=0)
    left, chosen = flat - mean, []
    strength, directions = np.linalg.eigh(left.T @ left)

    # the strongest first
    for k in np.argsort(-strength):
        if np.abs(left).max() <= off / 4:
            break

        chosen.append(directions[:, k])
        left = left - np.outer(left @ chosen[-1], chosen[-1])

    modes = np.array(chosen).reshape(len(chosen), flat.shape[1])
    return mean, modes, (flat - mean) @ modes.T


def _between(shapes, axis):
    """m: how far points between nodes are off at most, as second differences along an axis tell."""
    if shapes.shape[axis] < 3:
        return 0.0

    return float(np.abs(np.diff(shapes, 2, axis=axis)).max()) / 8
