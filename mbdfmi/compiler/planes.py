"""Mechanisms that move in a plane: all their joints keep every body in a plane parallel to one of the ground."""

from typing import NamedTuple

import numpy as np

from ..rotations import Rotation
from ..vectors import cross, dot, norm
from .frames import IDENTITY, axes_with_z, compose
from .topology import Node

# rad, and of the size of its parts: what is further from the plane is not in it
EXACT = 1e-12


class Plane(NamedTuple):
    """Of a node: the normal (3,) in its axes, and how high above the ground's plane through its origin the node's is (m)."""

    normal: np.ndarray
    height: float


def find_planes(scene, tree, cuts) -> list[Plane] | None:
    """The planes of all nodes, that node 0 has too; None where something may leave them, or reactions out of them are asked for.

    cuts : names of the joints that are to close loops; all must be revolute.
    """
    reactions = any(name.startswith("reaction") for joint in scene.joint.values() for name in joint.output)

    if reactions or any(scene.joint[name].kind != "revolute" for name in cuts):
        return None

    planes = _planes_of_tree(tree)
    return planes if planes and all(_stays(scene, tree, name, planes) for name in cuts) else None


def _planes_of_tree(tree):
    """The planes that the joints of the tree keep, or None."""
    normal = _first_axis(tree)
    ground = tree.home["ground"][0]
    planes = [Plane(np.zeros(3), 0.0)] * ground + [Plane(normal, 0.0)]

    for node in tree.nodes[ground + 1 :]:
        r, A = node.joint_frame
        n, height = planes[node.parent]
        across = norm(cross(A[:, 2], n))
        keeps = {"revolute": across < EXACT, "prismatic": abs(A[:, 2] @ n) < EXACT, "fixed": True}

        if normal is None or not keeps.get(node.kind, False):
            return None

        planes.append(Plane(A.T @ n, height + n @ r))

    return planes


def _first_axis(tree):
    """The axis of the first revolute joint of the tree, in the ground's axes: those before it do not turn."""
    ground = tree.home["ground"][0]
    axes = [np.eye(3)] * (ground + 1)

    for node in tree.nodes[ground + 1 :]:
        axes.append(axes[node.parent] @ node.joint_frame[1])

        if node.kind == "revolute":
            return axes[-1][:, 2]

    return None


def _stays(scene, tree, name, planes):
    """Whether a revolute joint that closes a loop has its axis along the normals, and its ends at one height."""
    joint, ends = scene.joint[name], []
    axis = joint.axis

    for end in joint.between:
        i, (r, A) = tree.marker(scene, end)
        n, height = planes[i]
        z = dot(A, axis)
        across = norm(cross(z, n))
        ends.append((z @ n, across, height + n @ r, np.abs(r).max()))

    (along, across, height, size), (other, more, opposite, reach) = ends
    straight = along * other > 0 and max(across, more) < EXACT
    return straight and abs(height - opposite) <= EXACT * max(size, reach, abs(height))


def planar_nodes(ground: int, first: int, of_ground: Plane, plane: Plane, bodies: list[str]):
    """(nodes that move bodies along two axes of the ground's plane and about its normal, pose of the old node in the last one).

    first : the place that the first of them will have among the nodes.
    """
    side = (plane.height * of_ground.normal, axes_with_z(of_ground.normal))
    nodes = []

    for k, (kind, axis) in enumerate(zip(("prismatic", "prismatic", "revolute"), np.eye(3))):
        turn = axes_with_z(axis)
        parent = first + k - 1 if k else ground
        nodes.append(Node(parent, "", kind, k, False, (side[0], side[1] @ turn), [], bodies[0]))
        side = (np.zeros(3), turn.T)

    nodes[-1].bodies = bodies
    return nodes, (IDENTITY[0], axes_with_z(plane.normal).T)


def planar_starts(tree, whole, motion):
    """Start values of a tree whose bodies stand in `planar_nodes`, from those in absolute coordinates.

    whole : the tree that `motion` was found by (see `absolute.start_motion`), whose values for bodies on three nodes become
        (x, y in m and the angle in rad, their rates).
    """
    found = dict(motion)

    for i, node in enumerate(tree.nodes):
        if node.part and node.coordinate == 2:
            q, v = motion[node.part]
            frames = [tree.nodes[i - 2].joint_frame]
            frames += [compose(frames[-1], tree.nodes[i - 1].joint_frame)]
            frames += [compose(frames[-1], node.joint_frame)]
            axes = np.column_stack([A[:, 2] for _, A in frames])
            # from the node's axes to those of the node that `motion` is of
            turn = dot(tree.home[node.part][1][1], whole.home[node.part][1][1].T)
            turned = frames[-1][1].T @ Rotation.from_quat(q[3:]).as_matrix() @ turn.T
            angle = np.arctan2(turned[1, 0], turned[0, 0])
            place = axes.T @ (q[:3] - frames[0][0])
            rates = [*(axes[:, :2].T @ v[:3]), axes[:, 2] @ v[3:]]
            found[node.part] = (np.array([*place[:2], angle]), np.array(rates))

    return found
