"""A spanning tree over the bodies of a problem file, for contestants with joint coordinates."""

from dataclasses import dataclass

import numpy as np
from scipy.spatial.transform import Rotation

from mbdfmi.compiler.frames import axes_with_z

from .problem_files import pose_of
from .problems import MOTION_SIZE

# coordinates and velocities of each kind
SIZES = {"revolute": (1, 1), "prismatic": (1, 1), "spherical": (4, 3), "free": (7, 6)}


@dataclass(frozen=True)
class TreeJoint:
    """A joint that hangs a body on one before it in the tree.

    parent, child : bodies, "ground" too.  kind : revolute, prismatic, spherical or free.
    point (3,) m, axes (3, 3) : at t = 0, inertial; z, the last column, along the joint's axis.
    omega (3,) rad/s, velocity (3,) m/s : of the child against the parent at t = 0, inertial axes; the
        velocity is that of a free body's centre of mass.
    """

    parent: str
    child: str
    kind: str
    point: np.ndarray
    axes: np.ndarray
    omega: np.ndarray
    velocity: np.ndarray


def spanning_tree(data: dict) -> tuple[list[TreeJoint], list[dict]]:
    """Joints of the tree, parents first, and the joints of the file that close loops."""
    bodies = {body["name"]: body for body in data["bodies"]}
    left, tree = list(data["joints"]), []
    reached = {"ground"}

    def hang(parent, child, kind, point, axes):
        before, after = bodies.get(parent, {}), bodies[child]
        omega = np.subtract(after.get("w0", [0, 0, 0]), before.get("w0", [0, 0, 0]))
        velocity = np.array(after.get("v0", [0, 0, 0]), float)
        tree.append(TreeJoint(parent, child, kind, np.array(point, float), axes, omega, velocity))
        reached.add(child)

    while True:
        for joint in left:
            ends = joint["body_i"], joint["body_j"]
            known = [end in reached for end in ends]

            if sum(known) == 1:
                parent, child = ends if known[0] else ends[::-1]
                axis = np.array(joint.get("axis", [0, 0, 1]), float)
                hang(parent, child, joint["type"], joint["point"], axes_with_z(axis / np.linalg.norm(axis)))
                left.remove(joint)
                break
        else:
            free = [name for name in bodies if name not in reached]

            if not free:
                return tree, left

            r, A = pose_of(bodies[free[0]])
            hang("ground", free[0], "free", r, A)


def inertia_matrix(body: dict) -> np.ndarray:
    """(3, 3) kg m2, of a body of a problem file, body axes."""
    xx, yy, zz, xy, xz, yz = body["inertia"]
    return np.array([[xx, xy, xz], [xy, yy, yz], [xz, yz, zz]])


def start_of(data: dict, tree: list[TreeJoint]) -> tuple[np.ndarray, np.ndarray]:
    """Joint coordinates and velocities at t = 0, in the tree's order.

    A revolute or prismatic joint has one, 0 at the start. A spherical one has Euler parameters, scalar part
    last, of the child's joint axes in the parent's, and the angular velocity in the child's. A free one has
    position (m) and Euler parameters of the body, and velocity and angular velocity in body axes.
    """
    q, v = [], []

    for joint in tree:
        if joint.kind == "free":
            E = Rotation.from_matrix(joint.axes).as_quat()
            q += [*joint.point, *E]
            v += [*(joint.axes.T @ joint.velocity), *(joint.axes.T @ joint.omega)]
        elif joint.kind == "spherical":
            q += [0.0, 0.0, 0.0, 1.0]
            v += [*(joint.axes.T @ joint.omega)]
        else:
            q += [0.0]
            v += [joint.axes[:, 2] @ joint.omega if joint.kind == "revolute" else 0.0]

    return np.array(q, float), np.array(v, float)


def motion_of(data: dict, tree: list[TreeJoint], q: np.ndarray, v: np.ndarray) -> np.ndarray:
    """Motion (n_body, MOTION_SIZE) of all bodies for joint coordinates and velocities as in `start_of`.

    Each body is told by how it has moved since t = 0, x = R x0 + d, and by its angular velocity w and the
    velocity u of its point at the origin.
    """
    moved = {"ground": (np.eye(3), np.zeros(3), np.zeros(3), np.zeros(3))}
    rows = {body["name"]: k for k, body in enumerate(data["bodies"])}
    table = np.zeros((len(rows), MOTION_SIZE))
    iq = iv = 0

    for joint in tree:
        nq, nv = SIZES[joint.kind]
        a, b = q[iq : iq + nq], v[iv : iv + nv]
        iq, iv = iq + nq, iv + nv
        R0, d0, w0, u0 = moved[joint.parent]
        axes = R0 @ joint.axes
        point = R0 @ joint.point + d0

        if joint.kind == "free":
            A = Rotation.from_quat(a[3:]).as_matrix()
            R, w, point, along = A @ joint.axes.T, A @ b[3:], a[:3], A @ b[:3]
        elif joint.kind == "spherical":
            Q = Rotation.from_quat(a).as_matrix()
            R, w, along = axes @ Q @ joint.axes.T, w0 + axes @ Q @ b, u0 + np.cross(w0, point)
        elif joint.kind == "revolute":
            R = axes @ Rotation.from_rotvec([0, 0, a[0]]).as_matrix() @ joint.axes.T
            w, along = w0 + axes[:, 2] * b[0], u0 + np.cross(w0, point)
        else:
            point = point + axes[:, 2] * a[0]
            R, w, along = R0, w0, u0 + np.cross(w0, point) + axes[:, 2] * b[0]

        d = point - R @ joint.point
        u = along - np.cross(w, point)
        moved[joint.child] = (R, d, w, u)
        k = rows[joint.child]
        r, A = pose_of(data["bodies"][k])
        r = R @ r + d
        table[k] = [*r, *Rotation.from_matrix(R @ A).as_quat(), *(u + np.cross(w, r)), *w]

    return table
