"""Bodies apart, where loops stand in a row: joints of the tree are cut too, and what hung on them moves freely.

By joint coordinates each loop feels all joints to the ground, so that n loops in a row cost n^3; apart, they feel their
neighbours alone. More rows and coordinates are the price, so this is chosen by predicted cost.
"""

from dataclasses import replace

import numpy as np

from ..kernels.joints import KINDS, N_V
from ..scene.rare import CONSTRAINTS, END_FRAMES
from .elimination import elimination, neighbours
from .frames import compose
from .planes import find_planes, planar_nodes
from .topology import Node, Tree, free_node

# loops below which joint coordinates are kept whatever is predicted, and how many times cheaper it must be predicted to be: in a
# row of 12 loops an evaluation costs as much either way (2.05 predicted), of 15 a sixth less apart (2.6), of 20 half (3.6)
FEW_LOOPS = 15
GAIN = 2.4

# what a row takes besides, and each joint on its way to the ground, in multiplications
OF_ROW = 150
OF_STEP = 40

# multiplications for which the start is still found by joint coordinates, where the given one does not close the loops
MOST_AT_START = 1e9


def parted_tree(scene, tree) -> Tree | None:
    """The tree with its bodies apart if that is predicted to be much cheaper, else None."""
    if len(tree.cuts) < FEW_LOOPS or not _can_be_parted(scene):
        return None

    parted = _parted(scene, tree)
    return parted if GAIN * predicted_cost(scene, parted) < predicted_cost(scene, tree) else None


def _can_be_parted(scene):
    """Whether all bodies can move by themselves, and nothing but joints between bodies closes loops."""
    special = {rare.kind for rare in (*CONSTRAINTS, *END_FRAMES)}

    if scene.coupling or any(joint.kind in special or joint.stays_in_tree for joint in scene.joint.values()):
        return False

    for body in scene.body.values():
        mass, _, inertia = body.mass_properties()
        moments = np.linalg.eigvalsh(inertia)

        if not (mass > 0.0 and moments[0] > 1e-9 * moments[-1] > 0.0):
            return False

    return True


def _parted(scene, tree):
    """The tree without its joints between bodies; those on the ground and driven ones stay."""
    ground = tree.home["ground"][0]
    cut = set(tree.cuts)

    for node in tree.nodes[ground + 1 :]:
        # a joint of several motions is a chain of nodes, of which the first tells
        first = tree.nodes[node.parent].joint != node.joint

        if first and node.parent > ground and not scene.joint[node.joint].driver:
            cut.add(node.joint)

    cuts = [name for name in scene.joint if name in cut]
    planes = find_planes(scene, tree, cuts)
    nodes: list[Node] = []
    new, turned = {-1: -1}, {}

    for i, node in enumerate(tree.nodes):
        if node.joint not in cut or i <= ground:
            nodes.append(replace(node, parent=new[node.parent]))
        elif node.bodies and planes:
            chain, turned[i] = planar_nodes(ground, len(nodes), planes[ground], planes[i], node.bodies)
            nodes += chain
        elif node.bodies:
            nodes.append(free_node(ground, node.bodies))

        new[i] = len(nodes) - 1

    home = {
        body: (new[i], compose(turned[i], pose) if i in turned else pose)
        for body, (i, pose) in tree.home.items()
    }
    return Tree(nodes, home, cuts, bool(planes))


def predicted_cost(scene, tree) -> float:
    """Multiplications for the rows in an evaluation, redundant ones counted; of the factor's fill only where it is moderate."""
    size = [len(tree.rows_of(scene.joint[name])) for name in tree.cuts]
    paths = [_path(scene, tree, name) for name in tree.cuts]
    through = np.zeros(len(tree.nodes))

    for path, rows in zip(paths, size):
        through[list(path)] += rows

    width = np.array([N_V[KINDS[node.kind]] if i else 0 for i, node in enumerate(tree.nodes)])
    products = float(width @ through**2) / 2
    products += sum(rows * (OF_ROW + OF_STEP * len(path)) for rows, path in zip(size, paths))

    if through.max() > sum(size) / 2:  # all but full: the products alone tell
        return products

    _, earlier = elimination(neighbours(paths))
    beside = [sum(size[e] for e in some) for some in earlier]
    return products + sum(rows * before * (before + rows) / 2 for rows, before in zip(size, beside))


def _path(scene, tree, name):
    """Nodes between the ends of a joint and the ground."""
    path = set()

    for end in scene.joint[name].between:
        i = tree.home[end.split(".")[0]][0]

        while i > 0 and i not in path:
            path.add(i)
            i = tree.nodes[i].parent

    return path
