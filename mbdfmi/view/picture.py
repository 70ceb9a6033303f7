"""What is to be shown: a scene, all its surfaces, and its motion, put together as a tree of nodes."""

from dataclasses import dataclass, replace
from functools import cached_property

import numpy as np

from ..rotations import Rotation
from ..run.states import States
from ..scene import SceneData
from . import forms, glb
from .contents import Link, Piece, check_meshes, links, pieces
from .line_nodes import line_nodes
from .lines import lines, surfaces
from .motion import Motion, motion, up_axis, upright

# of the scene's size: motions below are rounding
STILL = 1e-9

# of the radius of what moves: as far as mooring lines are seen when a picture is opened
NEAR = 2.0


@dataclass
class Picture:
    """A scene with its motion, ready to be drawn.

    size : m, of the scene at its first time. pieces, links : what there is to draw.
    """

    scene: SceneData
    states: States
    moves: Motion
    size: float
    pieces: list[Piece]
    links: list[Link]

    @property
    def title(self):
        """What it is of."""
        return self.scene.title or self.scene.name

    @cached_property
    def root(self):
        """(3, 3): from the picture's frame to one with y up."""
        return upright(up_axis(self.scene, self.moves))

    @cached_property
    def reach(self):
        """(centre (3,), radius) of a ball, in the picture's frame, that holds all that is drawn at all
        times, of mooring lines what is near.
        """
        low, high = np.full(3, np.inf), np.full(3, -np.inf)
        hulls = {}

        for piece in self.pieces:
            # endless curves and surfaces are not what it is about
            if piece.layer == "bodies" or piece.body == "ground":
                hulls.setdefault(piece.body, []).append(np.array(piece.surface.points))

        for body in self.moves.bodies:
            points = hulls.get(body, [])
            corners = np.concatenate(points) if points else np.zeros((1, 3))

            if body == "ground" and not points:
                continue

            box = np.array([corners.min(axis=0), corners.max(axis=0)])

            places = self.moves.points(body, np.array(np.meshgrid(*box.T)).reshape(3, -1).T)
            low = np.minimum(low, places.min(axis=(0, 1)))
            high = np.maximum(high, places.max(axis=(0, 1)))

        if not np.isfinite(low).all():
            low, high = np.full(3, -0.5), np.full(3, 0.5)

        centre, radius = (low + high) / 2, max(float(np.linalg.norm(high - low)) / 2, 1e-6)

        for line in self.lines:
            points = line.points([0])[0]
            near = points[np.linalg.norm(points - centre, axis=1) < NEAR * radius]
            low, high = (
                pick(np.concatenate([near, [ends]]), axis=0) for pick, ends in ((np.min, low), (np.max, high))
            )

        return (low + high) / 2, max(float(np.linalg.norm(high - low)) / 2, radius)

    def thinned_to(self, rows):
        """The same with some rows of the states of the run alone."""
        return replace(self, moves=motion(self.scene, self.states, rows=rows))

    def turned(self, vectors):
        """Vectors (n, 3) in inertial axes, one a row, in the picture's."""
        return np.einsum("nji,nj->ni", self.moves.inertial[1], vectors)

    def ends_axis(self, axis):
        """(3,) the direction, at the first time, of an axis (a table with body and axis)."""
        return self.moves.A[0, self.moves.place[axis["body"]]] @ axis["axis"]

    def carriers(self):
        """body -> the body that it is fixed to and moves with; one that carries is its own."""
        home, first, found = self.states.model.tree.home, {}, {}

        for body in self.moves.bodies:
            found[body] = first.setdefault(home[body][0], body)

        return found

    def tree(self, full=True) -> glb.Node:
        """The nodes; full: every digit, else positions rounded to a few millionths of the size, which
        packs smaller.
        """
        rounded = _exact if full else _rounding
        root = glb.Node(self.title, q=Rotation.from_matrix(self.root).as_quat())
        nodes, carriers = {}, self.carriers()

        for k, body in enumerate(self.moves.bodies):
            node = nodes[body] = glb.Node(body, extras={"kind": "body"})
            carrier = carriers[body]

            if carrier == body:
                self._place(node, self.moves.r[:, k], self.moves.q[:, k], rounded)
                root.children.append(node)
            else:
                node.r, node.q = self._fixed(self.moves.place[carrier], k)
                nodes[carrier].children.append(node)

            for layer in ("bodies", "curves", "surfaces"):
                surfaces = [
                    (self._vertices(surface, rounded), colour, opacity)
                    for (colour, opacity), surface in self._surfaces(body, layer).items()
                ]
                if layer == "bodies":
                    node.surfaces = surfaces
                elif surfaces:
                    below = glb.Node(f"{body} {layer}", surfaces=surfaces, extras={"kind": layer})
                    node.children.append(below)

        root.children += [self._link(link, rounded) for link in self.links]
        return root

    def _surfaces(self, body, layer):
        """{(colour, opacity): surface} of a body, those of one look together."""
        found = {}

        for piece in self.pieces:
            if (piece.body, piece.layer) == (body, layer):
                found.setdefault((piece.colour, piece.opacity), []).append(piece.surface)

        return {look: forms.join(surfaces) for look, surfaces in found.items()}

    def _vertices(self, surface, rounded):
        return surface._replace(
            points=rounded(surface.points, self.size),
            normals=np.round(surface.normals, 3 if rounded is _rounding else 7),
        )

    def _place(self, node, r, q, rounded):
        """The pose of a node over time; without channels where it stands still."""
        node.r, node.q = r[0], q[0]

        if np.abs(r - r[0]).max() > STILL * self.size:
            node.moves["translation"] = rounded(r, self.size)

        if np.abs(q - q[0]).max() > STILL:
            node.moves["rotation"] = rounded(q, 1.0)

    def _fixed(self, carrier, k):
        """(r, q) of body k in the one that it is fixed to."""
        A = self.moves.A[0, carrier].T
        r = A @ (self.moves.r[0, k] - self.moves.r[0, carrier])
        return r, Rotation.from_matrix(A @ self.moves.A[0, k]).as_quat()

    def ends(self, end):
        """(n, 3): where an end is, in the picture's frame."""
        body, r, _ = self.scene.marker_pose(end)
        if body == "inertial":
            base, A = self.moves.inertial
            return np.einsum("nji,nj->ni", A, r - base)
        return self.moves.point(body, r)

    def _link(self, link, rounded):
        """A rod between two ends."""
        a, b = (self.ends(end) for end in link.ends)
        length = np.linalg.norm(b - a, axis=1)
        along = (b - a) / np.maximum(length, 1e-30)[:, None]
        q = _turn_z_to(along)
        size = np.column_stack([np.full((len(a), 2), link.radius), np.maximum(length, 1e-6 * self.size)])
        node = glb.Node(link.name, surfaces=[(forms.cylinder(), link.colour, 1.0)], extras={"kind": "link"})
        self._place(node, (a + b) / 2, q, rounded)
        node.scale = size[0]

        if np.ptp(length) > STILL * self.size:
            node.moves["scale"] = rounded(size, self.size)

        return node

    @cached_property
    def lines(self):
        """Its mooring lines."""
        return lines(self)

    def drawn(self, moves: Motion):
        """(surface, colour, opacity) of all pieces and links at the one time of `moves`, in the picture's
        frame.
        """
        for piece in self.pieces:
            k = moves.place[piece.body]
            yield forms.moved(piece.surface, moves.r[0, k], moves.A[0, k]), piece.colour, piece.opacity

        still = replace(self, moves=moves)
        for link in self.links:
            node = still._link(link, _exact)
            A = Rotation(node.q).as_matrix()
            yield forms.moved(forms.cylinder(), node.r, A, node.scale), link.colour, 1.0

        for surface, colour in surfaces(still, 0, self.reach[1]):
            yield surface, colour, 1.0

    def glb(self) -> bytes:
        """The animated GLB."""
        root = self.tree()
        root.children += line_nodes(self)
        return glb.write(root, self.moves.times, self.title)


def picture(scene, states, rows=None) -> Picture:
    """The picture of a scene and the states of a run of it, at all of its rows or at some.

    Raises ValueError where a mesh cannot be read.
    """
    check_meshes(scene)
    moves = motion(scene, states, rows)
    size = _size(scene, moves)
    return Picture(scene, states, moves, size, pieces(scene, size), links(scene, size))


def _size(scene, moves):
    """m: how far joints, centres of mass and what is drawn are apart at the first time."""
    points = []
    first = moves.row(0)

    for name, body in scene.body.items():
        _, com, _ = body.mass_properties()
        ends = [com, *(marker.pose()[0] for marker in body.marker.values()), np.zeros(3)]
        points += first.points(name, ends)[0].tolist()

    for piece in pieces(scene, 1e-6):
        corners = np.array([piece.surface.points.min(axis=0), piece.surface.points.max(axis=0)])
        if piece.layer == "bodies":
            points += first.points(piece.body, corners)[0].tolist()

    for joint in scene.joint.values():
        ends = [end for end in joint.between if end.split(".")[0] in moves.bodies and joint.kind != "free"]
        points += [first.point(end.split(".")[0], scene.marker_pose(end)[1])[0] for end in ends]

    return max(float(np.linalg.norm(np.ptp(points, axis=0))), 1e-6)


def _turn_z_to(along):
    """Euler parameters (n, 4) of turns of z to unit vectors (n, 3), without jumps."""
    q = np.column_stack([-along[:, 1], along[:, 0], np.zeros(len(along)), 1 + along[:, 2]])
    q[np.linalg.norm(q, axis=1) < 1e-6] = [1.0, 0.0, 0.0, 0.0]
    q /= np.linalg.norm(q, axis=1)[:, None]
    signs = np.cumprod(np.concatenate([[1.0], np.where((q[1:] * q[:-1]).sum(axis=1) < 0, -1.0, 1.0)]))
    return q * signs[:, None]


def _exact(values, scale):
    return values


def _rounding(values, scale):
    """Rounded to a power of 2 of about a five-millionth of the scale: packs smaller."""
    unit = 2.0 ** np.round(np.log2(scale * 2e-7))
    return np.round(np.asarray(values) / unit) * unit
