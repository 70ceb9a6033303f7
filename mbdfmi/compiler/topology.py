"""From a scene's graph of bodies and joints to a tree of nodes.

A node is what fixed joints hold together, those left out whose reactions are asked for. Node 0 is the inertial frame; the
ground is in it unless it moves, then it is node 1. Poses are those of frames.py.
"""

from dataclasses import dataclass, field, replace

import numpy as np

from ..scene import SceneData, SceneError
from ..scene.errors import Problem
from ..vectors import dot
from .frames import IDENTITY, axes_with_z, compose, inverse
from .joint_kinds import IN_X_AND_Y, ONE_AXIS, chain, kind_of


@dataclass
class Node:
    """One node of the tree, and the joint that hangs it on its parent.

    joint : name of the user's joint that it belongs to; one of several axes makes a chain of nodes.
    kind : of the kernels' joint kinds.
    coordinate : where its coordinates stand among those of the user's joint.
    reversed : the user's joint leads from its second marker to its first here.
    joint_frame : pose of the joint frame in the parent's frame (z along the joint's axis). The node's frame coincides
        with it at zero joint coordinates.
    bodies : the user's bodies in it; none inside a chain.
    part : where no joint of the user's hangs it: the body that it moves, with those fixed to it.
    """

    parent: int
    joint: str
    kind: str
    coordinate: int
    reversed: bool
    joint_frame: tuple
    bodies: list[str] = field(default_factory=list)
    part: str = ""

    @property
    def name(self) -> str:
        """What a message calls it: its bodies' names."""
        return " + ".join(self.bodies) or self.joint or self.part


@dataclass
class Tree:
    """Nodes, parents first, and where each of the user's bodies sits: body -> (node, pose in the node).

    cuts : names of the joints that close loops.
    in_plane : whether all that moves does so in parallel planes by the joints of the tree, so that revolute joints that close
        loops need no more than two rows each.
    """

    nodes: list[Node]
    home: dict[str, tuple[int, tuple]]
    cuts: list[str]
    in_plane: bool = False
    _markers: dict[str, tuple[int, tuple]] = field(default_factory=dict, repr=False)

    def rows_of(self, joint):
        """The rows of a joint that closes a loop, as in `JointKind.rows`."""
        kind = kind_of(joint)
        return IN_X_AND_Y if self.in_plane else (*kind.rows, *kind.rows_too(joint))

    def marker(self, scene: SceneData, name: str):
        """(node, pose in the node) of "body", "body.marker", "ground" or "ground.marker"."""
        if name not in self._markers:
            body, position, axes = scene.marker_pose(name)
            node, pose = self.home[body]
            self._markers[name] = node, compose(pose, (position, axes))

        return self._markers[name]

    def joint_side(self, scene: SceneData, name: str, side: int, turn):
        """(node, pose in the node) of a joint's first (0) or second (1) marker with its axes turned by `turn` (3, 3)."""
        node, (r, A) = self.marker(scene, scene.joint[name].between[side])
        return node, (r, dot(A, turn))


def spanning_tree(scene: SceneData, first=()) -> Tree:
    """The spanning tree that leaves the fewest coordinates: joints of few freedoms are in it, those of many close loops.

    Joints that rotors turn with are always in it. Joints with a given start are kept in the tree before others, then those with something of their own (spring, input, output, ...).
    Nodes come depth first, in the order of the file. first : joints that come into it before all others.
    """
    welded = _weld(scene)
    group_of = {body: k for k, group in enumerate(welded) for body in group}
    ends = {
        name: [group_of[end.split(".")[0]] for end in joint.between]
        for name, joint in scene.joint.items()
        if kind_of(joint).in_trees and not is_weld(joint)
    }
    order = sorted(ends, key=lambda name: (name not in first, *_preference(scene.joint[name])))
    order.sort(key=lambda name: not scene.joint[name].turning)
    order.sort(key=lambda name: scene.joint[name].kind != "prescribed")
    chosen = _chosen(order, ends, len(welded), group_of["ground"])
    joints_at = [[] for _ in welded]

    for name in ends:
        if name in chosen:
            for at, other in (ends[name], ends[name][::-1]):
                joints_at[at].append((name, other))

    cuts = [name for name, joint in scene.joint.items() if not is_weld(joint) and name not in chosen]
    _check_rotors(scene, cuts)
    tree = Tree([Node(-1, "", "", 0, False, IDENTITY, list(welded[0]))], {}, cuts)
    tree.home |= {body: (0, pose) for body, pose in welded[0].items()}
    roots = [(0, 0)]

    if group_of["ground"] != 0:
        group = welded[group_of["ground"]]
        tree.nodes.append(Node(0, "", "free", 0, False, IDENTITY, list(group)))
        tree.home |= {body: (1, pose) for body, pose in group.items()}
        roots.append((1, group_of["ground"]))

    stack = [(at, name, group) for at, root in roots for name, group in reversed(joints_at[root])]

    while stack:
        parent, name, group = stack.pop()
        _hang(scene, tree, name, parent, welded[group])
        at = len(tree.nodes) - 1
        stack += [(at, *rest) for rest in reversed(joints_at[group]) if rest[0] != name]

    return tree


def _chosen(order, ends, n_group, ground):
    """Joints of the spanning tree by Kruskal's algorithm on groups of bodies; `order`: those that come first are preferred."""
    leader = list(range(n_group))
    leader[ground] = 0
    chosen = set()

    def find(k):
        while leader[k] != k:
            k = leader[k]

        return k

    for name in order:
        a, b = map(find, ends[name])

        if a != b:
            leader[max(a, b)] = min(a, b)
            chosen.add(name)

    return chosen


def _check_rotors(scene, cuts):
    """Raises SceneError where a joint that a rotor turns with closes a loop: so do all others of the loop have rotors; or one that is
    prescribed, as all others are.
    """
    for name in cuts:
        if scene.joint[name].kind == "prescribed":
            text = "all joints of this loop are prescribed, and what one of them prescribes the others do already; drop one of them"
            raise SceneError([Problem(("joint", name), text)])

        if scene.joint[name].turning:
            text = (
                "all joints of this loop have a rotor, and one of them must close it, which has no coordinate for a rotor to "
                'turn with; leave "turning" out of one of them'
            )
            raise SceneError([Problem(("joint", name, "turning"), text)])


def absolute_tree(tree: Tree, scene: SceneData) -> Tree:
    """The tree of absolute coordinates: every node with bodies hangs on the ground by a free joint, every joint is a constraint.

    But for joints that rotors turn with, and prescribed ones: these need their coordinates. The nodes' frames stay those of `tree`.
    """
    ground = tree.home["ground"][0]
    stays = {name for name, joint in scene.joint.items() if joint.stays_in_tree}
    kept = [i for i, node in enumerate(tree.nodes) if i <= ground or node.bodies or node.joint in stays]
    new = {i: k for k, i in enumerate(kept)}
    nodes = []

    for i in kept:
        node = tree.nodes[i]

        if i > ground:
            free = free_node(ground, node.bodies)
            node = replace(node, parent=new[node.parent]) if node.joint in stays else free

        nodes.append(node)

    home = {body: (new[i], pose) for body, (i, pose) in tree.home.items()}
    cuts = [name for name, joint in scene.joint.items() if not is_weld(joint) and name not in stays]
    return Tree(nodes, home, cuts)


def free_node(ground: int, bodies: list[str]) -> Node:
    """A node of these bodies that moves freely."""
    return Node(ground, "", "free", 0, False, IDENTITY, bodies, bodies[0] if bodies else "")


def is_weld(joint) -> bool:
    """Whether a joint's two sides are one node: a fixed joint, unless its reactions are asked for."""
    return joint.kind == "fixed" and not joint.output


def _preference(joint):
    """Sorts joints for the tree: those with given starts, with something of their own, then few freedoms, then the file's order.

    A start value can be held where it is a coordinate of the tree's.
    """
    freedoms = kind_of(joint).freedoms(joint)
    moves = freedoms > 0
    given = any(written is not None for written in (*joint.given_position(), *joint.given_velocity()))
    own = joint.spring or joint.damper or joint.friction or joint.stop or joint.input
    own = own or any(not name.startswith("reaction") for name in joint.output) or given
    driven = joint.driver is not None
    return (moves and not driven, moves and not given, freedoms == 6 and not own, moves and not own, freedoms)


def _hang(scene, tree, name, parent, group):
    """Hang a group of bodies (body -> pose in the group's frame) on a node by a joint: one node for each of its motions."""
    joint = scene.joint[name]
    reverse = joint.between[0].split(".")[0] in group
    near, far = joint.between[::-1] if reverse else joint.between

    # backwards, a chain runs from its end along the opposite axes
    motions = [(k, kind, -axis if reverse else axis) for k, (kind, axis) in enumerate(chain(joint))]
    motions = motions[::-1] if reverse else motions
    body, *pose = scene.marker_pose(near)
    side = compose(tree.home[body][1], tuple(pose))

    for k, kind, axis in motions:
        # only these have an axis; the others' coordinates are in the markers' own axes
        turn = axes_with_z(axis) if kind in ONE_AXIS else np.eye(3)
        node = Node(parent, name, kind, k, reverse, joint_frame=(side[0], dot(side[1], turn)))
        tree.nodes.append(node)
        parent = len(tree.nodes) - 1
        side = (np.zeros(3), turn.T)

    # the last node's frame in the group's frame is the far side of the joint
    body, *pose = scene.marker_pose(far)
    r, A = compose(group[body], tuple(pose))
    to_node = inverse((r, dot(A, turn)))
    tree.home |= {body: (parent, compose(to_node, pose)) for body, pose in group.items()}
    tree.nodes[parent].bodies = list(group)


def _weld(scene):
    """Groups of bodies that fixed joints hold together: body -> pose in the frame of the group's first."""
    neighbours = {name: [] for name in ("inertial", "ground", *scene.body)}

    if scene.ground.motion is None:
        neighbours["inertial"].append(("", "ground", IDENTITY))
        neighbours["ground"].append(("", "inertial", IDENTITY))

    for name, joint in scene.joint.items():
        if is_weld(joint):
            (body_a, *pose_a), (body_b, *pose_b) = map(scene.marker_pose, joint.between)
            b_in_a = compose(tuple(pose_a), inverse(tuple(pose_b)))
            neighbours[body_a].append((name, body_b, b_in_a))
            neighbours[body_b].append((name, body_a, inverse(b_in_a)))

    groups = []
    placed = {}

    for first in neighbours:
        if first in placed:
            continue

        placed[first] = IDENTITY
        group = {first: IDENTITY}
        stack = [first]

        while stack:
            body = stack.pop()

            for name, other, pose in neighbours[body]:
                pose = compose(placed[body], pose)

                if other not in placed:
                    placed[other] = group[other] = pose
                    stack.append(other)
                elif not all(
                    np.all(np.abs(p - s) <= 1e-9 + 1e-5 * np.abs(s)) for p, s in zip(pose, placed[other])
                ):
                    text = "holds its two ends where other fixed joints do not; correct a marker or remove it"
                    raise SceneError([Problem(("joint", name), text)])

        groups.append(group)

    return groups
