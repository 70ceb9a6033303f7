"""Self-stress of loops: reactions that add up to nothing, so that rigid bodies leave them undetermined.

Multipliers of what closes loops that do nothing along any free coordinate put wrenches on the nodes; what a
joint of the tree passes on then follows by equilibrium of all that hangs on it. So no other reactions are
undetermined than these.
"""

from dataclasses import dataclass

import numpy as np


@dataclass(frozen=True)
class Stress:
    """What the self-stresses are at one joint or coupling, a column each.

    moment, force : (3, k) constraint reaction about the second marker's origin, in N m and N, inertial axes.
    driving, coupling : (k,) efforts along coordinates, without units.
    """

    moment: np.ndarray
    force: np.ndarray
    driving: np.ndarray
    coupling: np.ndarray


def stresses(mechanism, place) -> dict[str, Stress]:
    """Joint or coupling -> its self-stress, of all that have any; in the scene's order."""
    found = {}

    for rows, stress in place.self_stress:
        _add_of_rows(found, mechanism, place, rows, stress)
        _add_of_tree(found, mechanism, place, rows, stress)

    scene = mechanism.scene
    return {
        name: Stress(*(np.concatenate(parts, axis=-1) for parts in zip(*found[name])))
        for name in (*scene.joint, *scene.coupling)
        if name in found
    }


def _add_of_rows(found, mechanism, place, rows, stress):
    """Of what closes loops: its own rows."""
    owners: dict[str, list[int]] = {}

    for k, row in enumerate(rows):
        owners.setdefault(mechanism.owner(row), []).append(k)

    is_coupling, driven = mechanism.is_coupling(), mechanism.m.row_drive >= 0

    for owner, mine in owners.items():
        row, part = rows[mine], stress[mine]
        wrench = ~is_coupling[row]
        efforts = part / place.scale[row, None]
        moment = place.loads.moment[row[wrench]].T @ part[wrench]
        force = place.loads.force[row[wrench]].T @ part[wrench]
        drives = is_coupling[row] & driven[row]
        couples = is_coupling[row] & ~driven[row]
        found.setdefault(owner, []).append((moment, force, efforts[drives].ravel(), efforts[couples].ravel()))


def _add_of_tree(found, mechanism, place, rows, stress):
    """Of joints of the tree: what balances the rows' wrenches on all nodes beyond."""
    m, loads, tree = mechanism.m, place.loads, mechanism.model.tree
    multiplier = np.zeros((m.n_row, stress.shape[1]))
    multiplier[rows] = stress
    mine = np.isin(loads.row, rows)
    wrench = np.zeros((m.n_body, 6, stress.shape[1]))
    np.add.at(wrench, loads.node[mine], -loads.wrench[mine, :, None] * multiplier[loads.row[mine], None, :])
    effort = np.zeros((m.n_body, stress.shape[1]))
    np.add.at(effort, loads.effort_node, loads.effort[:, None] * multiplier[loads.effort_row])

    for i in range(m.n_body - 1, 0, -1):
        wrench[tree.nodes[i].parent] += wrench[i]

    size = np.abs(wrench).max(axis=(1, 2)) + np.abs(effort).max(axis=1)

    for name, nodes in mechanism.joint_nodes.items():
        if size[nodes].any():
            found.setdefault(name, []).append(_of_joint(mechanism, place, name, wrench, effort))


def _of_joint(mechanism, place, name, wrench, effort):
    """Of a joint of the tree: what it passes on (about the inertial origin), less efforts along it."""
    nodes = mechanism.joint_nodes[name]
    node, (r, _) = mechanism.model.tree.joint_side(mechanism.scene, name, 1, np.eye(3))
    point = place.r[node] + place.A[node] @ r
    moment, force = wrench[nodes[-1], :3].copy(), wrench[nodes[-1], 3:].copy()
    driving = []

    # nodes of one axis alone have efforts; of a slide it acts at the second marker
    for i in nodes:
        z = place.A[i, :, 2]
        along = effort[i]

        if mechanism.m.body_drive[i] >= 0:
            at_node = wrench[i, :3].T - np.cross(place.r[i], wrench[i, 3:].T)
            slides = mechanism.model.tree.nodes[i].kind == "prismatic"
            along = wrench[i, 3:].T @ z if slides else at_node @ z
            driving.append((along - effort[i]) * (mechanism.length if slides else 1.0))

        if mechanism.model.tree.nodes[i].kind == "prismatic":
            force -= np.outer(z, along)
            moment -= np.outer(np.cross(point, z), along)
        elif along.any():
            moment -= np.outer(z, along)

    moment -= np.cross(point, force.T).T
    return moment, force, np.concatenate(driving) if driving else np.zeros(0), np.zeros(0)
