"""A scene whose joints are held to a given motion: the scene without their drivers, its joints in the state,
and whether the motion leaves just the freedoms that it may.
"""

import numpy as np

from ..compiler.joint_kinds import POSES, kind_of
from ..compiler.topology import spanning_tree
from ..kernels import joints
from ..kernels.joints import rotors
from ..kernels.math import algebra
from ..scene.errors import listed
from ..vocabulary import coordinate_names
from .mechanism import ZERO, Mechanism
from .motion import product_of

# outputs of a driver or an input, which a joint told has no longer
DROPPED = ("effort", "driver_effort", "input_effort")


def undriven(scene, names):
    """The scene without drivers and inputs in these joints, whose motion goes out with what else did."""
    changed = {}

    for name in names:
        joint = scene.joint[name]
        wanted = _motion_outputs(joint)
        rest = [output for output in joint.output if output not in (*DROPPED, *wanted)]
        own = {"driver": None, "input": [], "output": [*wanted, *rest]}
        own = {key: value for key, value in own.items() if key in type(joint).model_fields}
        changed[name] = joint.model_copy(update=own)

    formulation = scene.solver.formulation
    solver = scene.solver.model_copy(
        update={"formulation": "auto" if formulation == "augmented" else formulation}
    )
    return scene.model_copy(update={"joint": scene.joint | changed, "solver": solver})


def _motion_outputs(joint):
    """Names of outputs that tell a joint's motion."""
    names = coordinate_names(joint.coordinates)

    if kind_of(joint).is_one_axis:
        names.append("acceleration")
    elif joint.kind == "spherical":
        names.append("alpha")

    return names


def started(scene, names):
    """The scene with those joints that close its loops started where they are found when it is
    assembled: they will be in the tree, and others close the loops.
    """
    cuts = set(spanning_tree(scene).cuts) & {name for name in names if kind_of(scene.joint[name]).is_one_axis}

    if not cuts:
        return scene

    mechanism = Mechanism(scene)
    changed = {}

    for name in cuts:
        value = mechanism.position(name)
        joint = scene.joint[name]
        (coordinate,) = joint.coordinates
        start = type(joint.start)(**{coordinate.position.name: value})
        changed[name] = joint.model_copy(update={"start": start})

    return scene.model_copy(update={"joint": scene.joint | changed})


class DrivenPart:
    """A joint of the tree, or some coordinates of it, and their motion.

    nodes : one for each coordinate, in the joint's order; of a spherical or free joint its one.
    first : which of the joint's coordinates the first of these is.
    course : (n, size, 3) values, rates, second rates.
    """

    def __init__(self, model, nodes, course):
        tree, self.kind = model.tree, model.tree.nodes[nodes[0]].kind
        self.nodes = nodes
        self.first = tree.nodes[nodes[0]].coordinate
        self.reversed = tree.nodes[nodes[0]].reversed
        self.course = course

    @property
    def is_pose(self):
        return self.kind in POSES

    def velocities(self, m):
        """Places of its velocity coordinates in v."""
        return [m.body_v[i] + k for i in self.nodes for k in range(joints.N_V[m.body_joint[i]])]

    def positions(self, m):
        """Places of its position coordinates in q."""
        return [m.body_q[i] + k for i in self.nodes for k in range(joints.N_Q[m.body_joint[i]])]

    def put(self, m, d, values):
        """Positions and speeds of values, rates, second rates (size, 3) into the state, accelerations into
        x'; it is held.
        """
        d.held[self.nodes] = 1.0
        v = self.velocities(m)

        if not self.is_pose:
            d.q[self.positions(m)], d.v[v], d.v_rate[v] = values.T
            return

        r, E = (values[:3].T, values[3:].T) if self.kind == "free" else (np.zeros((3, 3)), values.T)
        E, w, alpha = _rotation(E)
        A = np.array(algebra.E_matrix(tuple(E)))

        # the tree needs the inverse motion where the joint's first marker is on its body
        if self.reversed:
            u = r[1] - np.cross(w, r[0])
            u_rate = r[2] - np.cross(alpha, r[0]) - np.cross(w, r[1])
            r = -np.array([A.T @ r[0], A.T @ u, A.T @ (u_rate - np.cross(w, u))])
            E, w, alpha, A = E * [-1, -1, -1, 1], -A.T @ w, -A.T @ alpha, A.T

        n = len(values) - 4
        q = self.positions(m)
        d.q[q[:n]], d.v[v[:n]], d.v_rate[v[:n]] = r[:, :n]
        d.q[q[n:]], d.v[v[n:]], d.v_rate[v[n:]] = E, A.T @ w, A.T @ alpha

    def where(self, m, d):
        """Its positions (size,) in the state."""
        q = d.q[self.positions(m)].copy()

        if not (self.is_pose and self.reversed):
            return q

        E = q[-4:] * [-1, -1, -1, 1]
        return np.append(-np.array(algebra.E_matrix(tuple(E))) @ q[:-4], E) if self.kind == "free" else E

    def effort(self, m, d):
        """What holds it, once all reactions are found: along its coordinates, or (force and) moment."""
        moment, force = d.bias_moment.reshape(-1, 3), d.bias_force.reshape(-1, 3)

        if not self.is_pose:
            borne = [(moment if m.body_joint[i] == joints.REVOLUTE else force)[i] for i in self.nodes]
            turned = [rotors.effort(m, d, i) if rotors.has(m, i) else 0.0 for i in self.nodes]
            return (
                np.sum(d.axis.reshape(-1, 3)[self.nodes] * borne, axis=1) + turned - d.tau[self.velocities(m)]
            )

        i = self.nodes[0]
        moment, force = moment[i], force[i]
        A = d.A.reshape(-1, 3, 3)

        if self.reversed:
            moment, force = -moment - np.cross(d.arm.reshape(-1, 3)[i] - self.root_arm(m, A), force), -force
            A = A[i]
        else:
            A = A[m.body_parent[i]] @ m.body_A.reshape(-1, 3, 3)[i]

        return np.append(A.T @ force, A.T @ moment) if self.kind == "free" else A.T @ moment

    def root_arm(self, m, A):
        """From the origin of the parent to that of the joint's frame on it (m, inertial axes)."""
        i = self.nodes[0]
        return A[m.body_parent[i]] @ m.body_r.reshape(-1, 3)[i]


def _rotation(E):
    """(unit E, w, w') of Euler parameters and their first two rates (3, 4); see drives.rotation_of_table."""
    s = 1.0 / (E[0] @ E[0])
    back = E[0] * [-1, -1, -1, 1]
    w = 2.0 * s * product_of(E[1], back)[:3]
    alpha = 2.0 * s * product_of(E[2], back)[:3] - 2.0 * s * (E[0] @ E[1]) * w
    return np.sqrt(s) * E[0], w, alpha


def driven_parts(model, courses):
    """joint -> its DrivenPart parts."""
    told = {}

    for name, parts in courses.items():
        nodes = [i for i, node in enumerate(model.tree.nodes) if i and node.joint == name]
        nodes.sort(key=lambda i: model.tree.nodes[i].coordinate)

        if not nodes:
            text = "it follows from the others; drive fewer of them"
            raise ValueError(f"the joints told close a loop at {name!r}: {text}")

        told[name] = [
            DrivenPart(model, [nodes[k] for k in of] if of else nodes, course) for of, course in parts
        ]

    return told


def check_freedoms(mechanism, told, choose, hybrid):
    """(joints told that are needed, joints that move freely). Raises ValueError unless each takes
    freedoms of its own away and, if not `hybrid`, leaves none that a motor could move.

    choose : joints that no motor moves are left out where they follow from others.
    """
    place = mechanism.generic()
    m, kinds = mechanism.m, mechanism.scene.joint
    freedoms = place.motions.shape[1]

    def rows(names):
        parts = [part for name in names for part in told[name]]
        return [mechanism.free.index(v) for part in parts for v in part.velocities(m)]

    def taken(names, more=()):
        some = np.vstack([place.motions[rows(names)], *(row[None] for row in more)])
        return int(np.sum(np.linalg.svd(some, compute_uv=False) > 10 * ZERO)) if some.size else 0

    names = [name for name in told if kind_of(kinds[name]).is_one_axis or not choose]

    for name in told:
        if name not in names and taken([*names, name]) == taken(names) + len(rows([name])):
            names.append(name)

    found = taken(names)

    if found < len(rows(names)):
        raise ValueError(
            f"the motion gives {listed(names)}, but some of these follow from the others: the scene "
            f"has {_degrees(freedoms)} of freedom; drive fewer of them (drive=[...], or --drive JOINT)"
        )

    left = freedoms - found
    could = [
        name
        for name in (mechanism.driveable(place) if left else ())
        if taken(names, [mechanism.rates(name, place) @ place.motions]) > found
    ]

    if left and not hybrid and (could or not names):
        hint = f"of these could be driven too: {listed(could)}"
        raise ValueError(
            f"the motion of {listed(names) or 'no joint'} leaves {_degrees(left)} of "
            f"freedom undetermined; {hint if could else 'no revolute or prismatic joint moves in them'} "
            "(hybrid=True, or --hybrid, lets them go on freely from the scene's start)"
        )

    told = {name: told[name] for name in names}
    return told, _moving(mechanism, place, rows(names)) if left else []


def _moving(mechanism, place, rows):
    """Joints of the tree that can move while the coordinates told do not."""
    _, s, V = np.linalg.svd(place.motions[rows]) if rows else (0, [], np.eye(place.motions.shape[1]))
    left = place.motions @ V[int(np.sum(np.array(s) > 10 * ZERO)) :].T
    moving = {mechanism.free[k] for k in np.flatnonzero(np.linalg.norm(left, axis=1) > 1e-6)}
    m, nodes = mechanism.m, mechanism.model.tree.nodes
    owners = [(nodes[i].joint, m.body_v[i], joints.N_V[m.body_joint[i]]) for i in range(1, m.n_body)]
    return list(dict.fromkeys(name for name, v, n in owners if moving & set(range(v, v + n))))


def _degrees(n):
    return f"{n} degree{'s' * (n != 1)}"
