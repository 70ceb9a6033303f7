"""Pictures drawn by numpy alone: of an FMU, and where there is no browser. The same everywhere; no names.

Triangles become fragments (one for each pixel that each covers), which are sorted by pixel and depth.
"""

import struct
import zlib

import numpy as np

from ..scene.looks import red_green_blue
from .lines import BED_OPACITY, SAND, beds
from .told import eye, grid_cell, unseen_ground

BACKGROUND = np.array([0xF4, 0xF6, 0xF8]) / 255
GRID, WATER = (0.79, 0.83, 0.87), (0.24, 0.56, 0.77)

# degrees from the bottom of the picture to its top; samples along each side of a pixel
FIELD = 35.0
FINE = 2

# how often, and down to how many pixels, long slanting triangles are cut
CUTS, SHORT = 6, 16

# layers of what is seen through
LAYERS = 6


def draw(picture, row=0, width=640, height=400, grid=True):
    """(height, width, 3) bytes: a picture at a row of its motion, with or without the grid."""
    camera = _Camera(picture, width * FINE, height * FINE)
    points, normals, colours, opacities = camera.bisected(*_triangles(picture, row, grid))
    fragments = camera.fragments(points)
    light = _light(camera.facing(points, normals))
    fine = _blend(fragments, colours[:, None] * light, opacities, width * FINE * height * FINE)
    fine = fine.reshape(height, FINE, width, FINE, 3)
    image = sum(fine[:, i, :, j] for i in range(FINE) for j in range(FINE)) / FINE**2
    return np.round(255 * np.clip(image, 0, 1)).astype(np.uint8)


def png(image) -> bytes:
    """A picture (height, width, 3) of bytes as a PNG file (https://www.w3.org/TR/png)."""
    height, width, _ = image.shape
    lines = np.zeros((height, 1 + 3 * width), np.uint8)
    lines[:, 1:] = image.reshape(height, -1)

    def chunk(kind, data):
        return struct.pack(">I", len(data)) + kind + data + struct.pack(">I", zlib.crc32(kind + data))

    head = struct.pack(">IIBBBBB", width, height, 8, 2, 0, 0, 0)
    parts = (b"IHDR", head), (b"IDAT", zlib.compress(lines.tobytes(), 9)), (b"IEND", b"")
    return b"\x89PNG\r\n\x1a\n" + b"".join(chunk(*part) for part in parts)


class _Camera:
    """Looks at all of a picture from its eye; x to the right, y up, z towards the eye."""

    def __init__(self, picture, width, height):
        centre, radius = picture.reach
        back = picture.root @ eye(picture)
        back = back / np.linalg.norm(back)
        right = np.cross([0.0, 1.0, 0.0], back)
        right = right / np.linalg.norm(right) if np.linalg.norm(right) > 1e-9 else np.array([1.0, 0.0, 0.0])
        self.axes = np.array([right, np.cross(back, right), back])
        half = np.radians(FIELD) / 2
        narrow = min(half, np.arctan(np.tan(half) * width / height))
        self.at = picture.root @ centre + back * 0.95 * radius / np.sin(narrow)
        self.near = radius / 500
        self.width, self.height = width, height
        self.scale = height / 2 / np.tan(half)

    def facing(self, points, normals):
        """Normals (n, 3, 3) turned to the eye, in the camera's axes."""
        towards = self.at - points
        flip = np.where(_of_three(np.add, np.moveaxis(normals * towards, 2, 0)) < 0, -1.0, 1.0)
        return (normals * flip[:, :, None]) @ self.axes.T

    def _seen(self, points):
        """(x, y in pixels, depth, whether before the eye) of the corners of triangles (n, 3, 3)."""
        seen = (points - self.at) @ self.axes.T
        ahead = _of_three(np.logical_and, (seen[:, :, 2] < -self.near).T)
        depth = np.where(ahead[:, None], -seen[:, :, 2], 1.0)
        x = self.width / 2 + self.scale * seen[:, :, 0] / depth
        return x, self.height / 2 - self.scale * seen[:, :, 1] / depth, depth, ahead

    def bisected(self, points, normals, colours, opacities):
        """The same triangles, long slanting ones cut, so that the squares that hold them are small."""
        for _ in range(CUTS):
            x, y, _, ahead = self._seen(points)
            wide, high = (_of_three(np.maximum, v.T) - _of_three(np.minimum, v.T) for v in (x, y))
            (ux, uy), (vx, vy) = ((x[:, k] - x[:, 0], y[:, k] - y[:, 0]) for k in (1, 2))
            area = np.abs(ux * vy - uy * vx) / 2
            long = ahead & (np.minimum(wide, high) > SHORT) & (wide * high > 6 * area)

            if not long.any():
                break

            # corners in an order that puts the longest side first
            sides = np.linalg.norm(points[long] - np.roll(points[long], -1, axis=1), axis=2)
            order = (np.argmax(sides, axis=1)[:, None] + np.arange(3)) % 3
            halves = []

            for corners in (points, normals):
                a, b, c = np.take_along_axis(corners[long], order[:, :, None], axis=1).transpose(1, 0, 2)
                middle = (a + b) / 2
                pieces = np.concatenate([np.stack([a, middle, c], axis=1), np.stack([middle, b, c], axis=1)])
                halves.append(np.concatenate([corners[~long], pieces]))

            points, normals = halves
            colours, opacities = (np.concatenate([v[~long], v[long], v[long]]) for v in (colours, opacities))

        return points, normals, colours, opacities

    def fragments(self, points):
        """(pixel, depth, triangle, weights (n, 3) of its corners) of triangles (n, 3, 3)."""
        x, y, depth, ahead = self._seen(points)
        left, right = (np.clip(_of_three(least, x.T), 0, self.width) for least in (np.minimum, np.maximum))
        top, bottom = (np.clip(_of_three(least, y.T), 0, self.height) for least in (np.minimum, np.maximum))
        (ax, bx, cx), (ay, by, cy) = x.T, y.T
        area = (bx - ax) * (cy - ay) - (cx - ax) * (by - ay)
        shown = np.flatnonzero(ahead & (right > left) & (bottom > top) & (np.abs(area) > 1e-9))

        if not len(shown):
            return None

        # shares of the corners are linear over the picture: at its own corner, by column, by row
        def share(bx, by, cx, cy):
            return np.column_stack([bx * cy - cx * by, by - cy, cx - bx])[shown] / area[shown, None]

        shares = np.stack([share(bx, by, cx, cy), share(cx, cy, ax, ay)], axis=1)
        shares = np.concatenate([shares, [[[1.0, 0.0, 0.0]]] - shares.sum(axis=1, keepdims=True)], axis=1)

        # each row of each triangle, and its columns on which no share is negative
        first = np.floor(top[shown]).astype(int)
        which, row = _counted(np.ceil(bottom[shown]).astype(int) - first)
        row = row + first[which]
        at_left = shares[which, :, 0] + shares[which, :, 2] * (row[:, None] + 0.5)
        slope = shares[which, :, 1]

        with np.errstate(divide="ignore", invalid="ignore"):
            border = -at_left / slope

        least = _of_three(np.maximum, np.where(slope > 0, border, -np.inf).T).clip(0, self.width)
        most = _of_three(np.minimum, np.where(slope < 0, border, np.inf).T).clip(0, self.width)
        begin = np.ceil(least - 0.5).astype(int)
        end = np.floor(most - 0.5).astype(int) + 1
        end[_of_three(np.logical_or, ((slope == 0) & (at_left < 0)).T)] = 0
        span, column = _counted(np.maximum(np.minimum(end, self.width) - begin, 0))
        column = column + begin[span]

        weights = at_left[span] + slope[span] * (column[:, None] + 0.5)
        triangle = shown[which[span]]
        # as distances appear: their reciprocals are linear on the screen
        weights /= depth[triangle]
        distance = 1 / _of_three(np.add, weights.T)
        return row[span] * self.width + column, distance, triangle, weights * distance[:, None]


def _of_three(function, values):
    """A function of two arrays, as np.maximum, of three; along an axis of three numpy takes far longer."""
    first, second, third = values
    return function(function(first, second), third)


def _counted(counts):
    """(k, 0 to counts[k] - 1) of all k one after another."""
    k = np.repeat(np.arange(len(counts)), counts)
    return k, np.arange(len(k)) - np.repeat(np.cumsum(counts) - counts, counts)


def _blend(fragments, colours, opacities, n):
    """(n, 3): what is seen at each pixel. colours (triangles, 3 corners, 3), opacities (triangles,)."""
    image = np.empty((n, 3))
    image[:] = BACKGROUND

    if fragments is None:
        return image

    pixel, depth, triangle, weights = fragments
    order = np.lexsort((depth, pixel))
    pixel, triangle, weights = pixel[order], triangle[order], weights[order]
    colour = _of_three(np.add, (weights[:, :, None] * colours[triangle]).transpose(1, 0, 2))
    opacity = opacities[triangle]
    # which fragment of its pixel, from the front, and how much is seen through those before it
    start = np.flatnonzero(np.concatenate([[True], pixel[1:] != pixel[:-1]]))
    count = np.diff(start, append=len(pixel))
    through, seen = np.ones(len(start)), np.zeros((len(start), 3))

    for layer in range(LAYERS):
        at = np.flatnonzero(count > layer)
        k = start[at] + layer
        seen[at] += (through[at] * opacity[k])[:, None] * colour[k]
        through[at] *= 1 - opacity[k]

    image[pixel[start]] = seen + through[:, None] * BACKGROUND
    return image


def _light(normals):
    """(n, 3, 1): how bright surfaces are, by their normals (n, 3 corners, 3) in the camera's axes."""
    sun = np.array([0.35, 0.75, 0.6]) / np.linalg.norm([0.35, 0.75, 0.6])
    return (0.58 + 0.12 * normals[..., 1:2] + 0.4 * np.maximum(normals @ sun, 0.0)[..., None]).clip(0, 1.05)


def _triangles(picture, row, grid):
    """Points and normals (n, 3, 3) with y up, colours (n, 3), opacities (n,) of all there is."""
    found = []

    for surface, colour, opacity in picture.drawn(picture.moves.row(row)):
        points, normals = surface.points @ picture.root.T, surface.normals @ picture.root.T
        found.append((points[surface.faces], normals[surface.faces], colour, opacity))

    found += _scenery(picture, grid)
    count = [len(points) for points, *_ in found]
    return (
        np.concatenate([points for points, *_ in found]),
        np.concatenate([normals for _, normals, *_ in found]),
        np.repeat([colour for *_, colour, _ in found], count, axis=0),
        np.repeat([opacity for *_, opacity in found], count),
    )


def _scenery(picture, grid):
    """The grid and the water, in pieces, so that those behind the eye are left out alone."""
    view, (centre, radius) = picture.scene.view, picture.reach
    middle = (picture.root @ centre)[[0, 2]]
    found = []

    if grid and view.ground == "grid":
        cell = grid_cell(radius)
        n = int(np.ceil(2.2 * radius / cell))
        k = cell * np.arange(-n, n + 1)
        along, at = (v.reshape(-1, 1) for v in np.meshgrid(k[:-1], k))
        thin = 0.0035 * radius
        lines = np.stack(
            [along + cell * np.array([0, 1, 1, 0]), at + thin * np.array([-1, -1, 1, 1])], axis=2
        )
        lines = np.concatenate([lines, lines[:, :, ::-1]]) + np.round(middle / cell) * cell
        found.append((*_flat(lines, unseen_ground(picture)), GRID, 1.0))

    if view.water is not None:
        found.append((*_flat(_squares(middle, 3 * radius), view.water), WATER, 0.42))

    for (x, height, y), reach in beds(picture):
        found.append((*_flat(_squares(np.array([x, y]), reach), height), red_green_blue(SAND), BED_OPACITY))

    return found


def _squares(middle, half, n=12):
    """(n * n, 4, 2): a square about its middle in small ones."""
    k = np.linspace(-half, half, n + 1)
    u, v = (w.reshape(-1, 1) for w in np.meshgrid(k[:-1], k[:-1]))
    step = k[1] - k[0]
    return np.stack([u + step * np.array([0, 1, 1, 0]), v + step * np.array([0, 0, 1, 1])], axis=2) + middle


def _flat(corners, height):
    """(points, normals) of the triangles of quadrangles (n, 4, 2) that lie at a height."""
    points = np.insert(corners, 1, height, axis=2)[:, [[0, 1, 2], [0, 2, 3]]].reshape(-1, 3, 3)
    return points, np.broadcast_to([0.0, 1.0, 0.0], points.shape)
