"""Where all bodies are over time, in the frame of the picture."""

from dataclasses import dataclass
from functools import cached_property

import numpy as np

from ..rotations import Rotation
from ..scene.fields import unit_vector

# a body that turns further than this between two rows is seen to turn another way
FAR_TURN = 0.6 * np.pi


@dataclass
class Motion:
    """Poses of bodies, "ground" first, at n times.

    times : (n,) s. bodies : names. r : (n, n_bodies, 3) m, A : (n, n_bodies, 3, 3), in the frame of the
        picture: the ground's, or the inertial one.
    inertial : (r (n, 3), A (n, 3, 3)) of the picture's frame in the inertial one.
    """

    times: np.ndarray
    bodies: list
    r: np.ndarray
    A: np.ndarray
    inertial: tuple

    @cached_property
    def place(self) -> dict:
        """Body -> its place among the bodies."""
        return {body: k for k, body in enumerate(self.bodies)}

    @cached_property
    def q(self) -> np.ndarray:
        """(n, n_bodies, 4) Euler parameters, scalar last, whose signs go on from row to row."""
        return _without_jumps(Rotation.from_matrix(self.A).as_quat())

    def row(self, k) -> "Motion":
        """The poses at one of the times alone."""
        return Motion(
            self.times[[k]], self.bodies, self.r[[k]], self.A[[k]], tuple(v[[k]] for v in self.inertial)
        )

    def point(self, body, r):
        """(n, 3): where a point (3,) of a body is."""
        return self.points(body, np.reshape(r, (1, 3)))[:, 0]

    def points(self, body, r):
        """(n, m, 3): where points (m, 3) of a body are."""
        k = self.place[body]
        turned = self.A[:, k].reshape(-1, 3) @ np.transpose(r)
        return self.r[:, k, None] + turned.reshape(-1, 3, len(r)).transpose(0, 2, 1)

    def far_turns(self):
        """Bodies that turn so far from row to row that what is between is not seen."""
        if len(self.times) < 2:
            return []

        turned = np.abs((self.q[1:] * self.q[:-1]).sum(axis=2)).min(axis=0)
        return [
            body for body, cosine in zip(self.bodies, turned) if 2 * np.arccos(min(1.0, cosine)) > FAR_TURN
        ]


def picked(n, most):
    """At most so many of the rows 0 … n - 1."""
    return np.unique(np.linspace(0, n - 1, min(n, max(2, most))).round().astype(int))


def motion(scene, states, rows=None) -> Motion:
    """The motion of a run, at all of its rows or at some."""
    rows = np.arange(len(states)) if rows is None else rows
    bodies = ["ground", *scene.body]
    r, A = states.poses(bodies, rows)
    base = (np.zeros((len(rows), 3)), np.tile(np.eye(3), (len(rows), 1, 1)))

    if scene.view.frame != "inertial" and scene.ground.motion:
        base = r[:, 0].copy(), A[:, 0].copy()
        r = np.einsum("nji,nbj->nbi", base[1], r - base[0][:, None])
        A = np.einsum("nji,nbjk->nbik", base[1], A)

    return Motion(states.time[rows], bodies, r, A, base)


def _without_jumps(q):
    """Euler parameters (n, bodies, 4) whose signs go on from row to row."""
    same = np.where((q[1:] * q[:-1]).sum(axis=2) < 0, -1.0, 1.0)
    signs = np.concatenate([np.ones((1, q.shape[1])), np.cumprod(same, axis=0)])
    return q * signs[:, :, None]


def up_axis(scene, moves: Motion):
    """(3,) unit vector that is up in the picture's frame: as told, else against gravity, else z."""
    if scene.view.up is not None:
        up = unit_vector(scene.view.up)
    else:
        gravity = np.array(scene.gravity)
        up = -gravity / np.linalg.norm(gravity) if gravity.any() else np.array([0.0, 0.0, 1.0])

    return moves.inertial[1][0].T @ up


def upright(up):
    """(3, 3): turns `up` into y, as glTF has it; z up leaves x where it is."""
    y = np.array([0.0, 1.0, 0.0])
    if up @ y < -1 + 1e-9:
        return np.diag([1.0, -1.0, -1.0])
    axis = np.cross(up, y)
    K = np.array([[0, -axis[2], axis[1]], [axis[2], 0, -axis[0]], [-axis[1], axis[0], 0]])
    return np.eye(3) + K + K @ K / (1 + up @ y)
