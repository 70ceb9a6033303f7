"""From a scene's graph of bodies and joints to a spanning tree of nodes.

A node is what fixed joints hold together; node 0 is the ground. Poses are pairs (r, A): origin (3,) in m and
rotation matrix (3, 3) of a frame, in the frame named.
"""

from dataclasses import dataclass, field

import numpy as np

from .scene import Scene, SceneError
from .scene.errors import Problem

IDENTITY = (np.zeros(3), np.eye(3))


def compose(outer, inner):
    """Pose of a frame given in a frame that is itself at `outer`."""
    return outer[0] + outer[1] @ inner[0], outer[1] @ inner[1]


def inverse(pose):
    """The pose the other way round."""
    return -pose[1].T @ pose[0], pose[1].T


def axes_with_z(axis):
    """A rotation matrix whose third column is the unit vector `axis` (3,); exact for coordinate axes."""
    helper = np.eye(3)[np.argmin(np.abs(axis))]
    x = np.cross(helper, axis)
    x /= np.linalg.norm(x)
    return np.column_stack([x, np.cross(axis, x), axis])


@dataclass
class Node:
    """One node of the tree, and the joint that hangs it on its parent.

    joint_frame : pose of the joint frame in the parent's frame (z along the joint's axis). The node's frame coincides
        with it at zero joint coordinates.
    reversed : the joint's first marker is on this node.
    bodies : the user's bodies in it.
    """

    parent: int
    joint: str
    kind: str
    reversed: bool
    joint_frame: tuple
    bodies: list[str] = field(default_factory=list)

    @property
    def name(self) -> str:
        """What a message calls it: its bodies' names."""
        return " + ".join(self.bodies)


@dataclass
class Tree:
    """Nodes, parents first, and where each of the user's bodies sits: body -> (node, pose in the node)."""

    nodes: list[Node]
    home: dict[str, tuple[int, tuple]]

    def marker(self, scene: Scene, name: str):
        """(node, pose in the node) of "body", "body.marker", "ground" or "ground.marker"."""
        body, position, axes = scene.marker_pose(name)
        node, pose = self.home[body]
        return node, compose(pose, (position, axes))


def spanning_tree(scene: Scene) -> Tree:
    """The tree of a scene whose joints form one.

    Bodies come in the order in which joints of the file lead to them from the ground, depth first.

    Raises SceneError where a joint closes a loop.
    """
    welded = _weld(scene)
    group_of = {body: k for k, group in enumerate(welded) for body in group}
    joints_at = [[] for _ in welded]

    for name, joint in scene.joint.items():
        if joint.kind == "fixed":
            continue

        ends = [group_of[end.split(".")[0]] for end in joint.between]

        if ends[0] == ends[1]:
            raise _loop_error(name, joint, "holds together what fixed joints already hold")

        for at, other in (ends, ends[::-1]):
            joints_at[at].append((name, joint, other))

    nodes = [Node(parent=-1, joint="", kind="", reversed=False, joint_frame=IDENTITY, bodies=["ground"])]
    home = {body: (0, pose) for body, pose in welded[0].items()}
    used = set()
    reached = {0}
    stack = [(0, name, joint, other) for name, joint, other in reversed(joints_at[0])]

    while stack:
        parent_group, name, joint, group = stack.pop()

        if name in used:
            continue

        used.add(name)

        if group in reached:
            raise _loop_error(name, joint, "closes a loop of joints")

        reached.add(group)
        nodes.append(_hang(scene, name, joint, welded[group], home))
        node = len(nodes) - 1

        # the node's frame in the group's frame is the child side of the joint
        to_node = inverse(_child_frame(scene, joint, nodes[node].reversed, welded[group]))
        home |= {body: (node, compose(to_node, pose)) for body, pose in welded[group].items()}
        nodes[node].bodies = list(welded[group])
        stack += [(group, *rest) for rest in reversed(joints_at[group]) if rest[0] not in used]

    return Tree(nodes, home)


def _weld(scene):
    """Groups of bodies that fixed joints hold together: body -> pose in the frame of the group's first."""
    neighbours = {name: [] for name in ("ground", *scene.body)}

    for name, joint in scene.joint.items():
        if joint.kind == "fixed":
            (body_a, *pose_a), (body_b, *pose_b) = map(scene.marker_pose, joint.between)
            b_in_a = compose(tuple(pose_a), inverse(tuple(pose_b)))
            neighbours[body_a].append((name, joint, body_b, b_in_a))
            neighbours[body_b].append((name, joint, body_a, inverse(b_in_a)))

    groups = []
    seen = {}

    for first in neighbours:
        if first in seen:
            continue

        seen[first] = IDENTITY
        group = {first: IDENTITY}
        stack = [first]

        while stack:
            body = stack.pop()

            for name, joint, other, pose in neighbours[body]:
                pose = compose(seen[body], pose)

                if other not in seen:
                    seen[other] = group[other] = pose
                    stack.append(other)
                elif not all(np.allclose(p, s, atol=1e-9) for p, s in zip(pose, seen[other])):
                    raise _loop_error(name, joint, "closes a loop of fixed joints that does not fit")

        groups.append(group)

    return groups


def _joint_side(scene, end, joint, reverse, poses):
    """Pose of one side of a joint, z along its axis, in the frame that `poses` (body -> pose) are in."""
    body, position, axes = scene.marker_pose(end)
    axis = -joint.axis if reverse else joint.axis
    aligned = axes_with_z(axis) if joint.kind in ("revolute", "prismatic") else np.eye(3)
    return compose(poses[body], (position, axes @ aligned))


def _child_frame(scene, joint, reverse, poses):
    return _joint_side(scene, joint.between[0 if reverse else 1], joint, reverse, poses)


def _hang(scene, name, joint, group, home):
    """The node of a group of bodies, hung by a joint on a body that has its home already."""
    reverse = joint.between[0].split(".")[0] in group
    end = joint.between[1 if reverse else 0]
    parent = home[end.split(".")[0]][0]
    poses = {body: pose for body, (node, pose) in home.items() if node == parent}
    frame = _joint_side(scene, end, joint, reverse, poses)
    return Node(parent=parent, joint=name, kind=joint.kind, reversed=reverse, joint_frame=frame)


def _loop_error(name, joint, what):
    first, second = joint.between
    text = f'"{first}" and "{second}": {what}; closed loops are not supported yet, so remove this joint'
    return SceneError([Problem(("joint", name, "between"), text)])
