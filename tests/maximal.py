"""A second route to the motion of a scene, in plain numpy: absolute coordinates, every joint a constraint.

Newton and Euler for each body about its centre of mass, joints as rows of acceleration constraints, one dense
system [M -C^T; C 0] [a; lambda] = [f; gamma] (Haug 1989, section 11.3). It shares nothing with the kernels: no
tree, no joint coordinates, no spatial shifts; fixed joints stay joints.

A motion is (r, A, v, w): origin, axes (3, 3), velocity of the origin and angular velocity, all in inertial axes.
"""

import numpy as np
from numpy import cross
from scipy.spatial.transform import Rotation

from mbdfmi.scene import fmi_name

REST = (np.zeros(3), np.eye(3), np.zeros(3), np.zeros(3))


def skew(a):
    """The matrix of a x."""
    return np.array([[0, -a[2], a[1]], [a[2], 0, -a[0]], [-a[1], a[0], 0]])


def marker_motion(scene, motions, end):
    """(owner, motion) of an end "body", "body.marker", "ground" or "ground.marker"."""
    owner, position, axes = scene.marker_pose(end)
    r, A, v, w = motions[owner]
    arm = A @ position
    return owner, (r + arm, A @ axes, v + cross(w, arm), w)


def start_motions(scene):
    """Motion of every body's own frame at the start, by name; "ground" too."""
    motions = {"ground": REST}
    waiting = list(scene.joint.values())

    while waiting:
        joint = waiting.pop(0)
        first, second = (end.split(".")[0] for end in joint.between)
        q, qd = joint.start_position(), joint.start_velocity()

        # the second marker in the first one's axes: place, orientation, velocity, angular velocity
        d, dd, turned, w_rel = np.zeros(3), np.zeros(3), np.eye(3), np.zeros(3)

        if joint.kind == "revolute":
            turned, w_rel = Rotation.from_rotvec(q * joint.axis).as_matrix(), qd * joint.axis
        elif joint.kind == "prismatic":
            d, dd = q * joint.axis, qd * joint.axis
        elif joint.kind == "spherical":
            turned, w_rel = Rotation.from_quat(q).as_matrix(), qd
        elif joint.kind == "free":
            d, turned = q[:3], Rotation.from_quat(q[3:]).as_matrix()
            dd, w_rel = qd[:3], qd[3:]

        if first in motions:
            _, (r, A, v, w) = marker_motion(scene, motions, joint.between[0])
            arm = A @ d
            new = (r + arm, A @ turned, v + cross(w, arm) + A @ dd, w + A @ w_rel)
            body, position, axes = scene.marker_pose(joint.between[1])
        elif second in motions:
            _, (r, A, v, w) = marker_motion(scene, motions, joint.between[1])
            A = A @ turned.T
            w = w - A @ w_rel
            new = (r - A @ d, A, v - cross(w, A @ d) - A @ dd, w)
            body, position, axes = scene.marker_pose(joint.between[0])
        else:
            waiting.append(joint)
            continue

        # from the marker to its body's own frame
        r, A, v, w = new
        A = A @ axes.T
        arm = A @ position
        motions[body] = (r - arm, A, v - cross(w, arm), w)

    return motions


def swing_and_twist(A):
    """(rx, ry, rz): rotation vector of the swing, then the twist about z, of A = exp(rx, ry, 0) Rz(rz)."""
    E = Rotation.from_matrix(A).as_quat()
    twist = 2 * np.arctan2(E[2], E[3])
    twist = (twist + np.pi) % (2 * np.pi) - np.pi
    swing = (Rotation.from_matrix(A) * Rotation.from_rotvec([0, 0, -twist])).as_rotvec()
    return np.array([swing[0], swing[1], twist])


def swing_and_twist_jacobian(A):
    """d(rx, ry, rz) by a small rotation in the axes that A leads to; differences of order 6."""
    J = np.empty((3, 3))

    # smaller steps near a swing by pi, where rz has no value
    h = 5e-3 * np.hypot(*Rotation.from_matrix(A).as_quat()[2:])

    for k, e in enumerate(np.eye(3)):
        near = [swing_and_twist(Rotation.from_rotvec(j * h * e).as_matrix() @ A) for j in range(-3, 4)]
        differences = [(near[3 + j] - near[3 - j] + np.pi) % (2 * np.pi) - np.pi for j in (1, 2, 3)]
        J[:, k] = np.array([45, -9, 1]) @ differences / (60 * h)

    return J


class Loads:
    """Forces (N) and moments (N m, about the centre of mass) on the bodies, and the power (W) that they bring in
    beside weight and springs: that of the inputs less that of the dampers.
    """

    def __init__(self, scene, motions):
        self.scene = scene
        self.motions = motions
        self.force = {name: np.zeros(3) for name in motions}
        self.moment = {name: np.zeros(3) for name in motions}
        self.power = 0.0

    def com(self, body):
        """Centre of mass of a body (m)."""
        r, A = self.motions[body][:2]
        return r if body == "ground" else r + A @ self.scene.body[body].mass_properties()[1]

    def add(self, body, point, force, moment=0.0):
        """A wrench on a body at a point."""
        self.force[body] = self.force[body] + force
        self.moment[body] = self.moment[body] + moment + cross(point - self.com(body), force)

    def pair(self, first, second, point, force, moment=0.0):
        """A wrench on the second body at a point, the opposite on the first."""
        self.add(second, point, force, moment)
        self.add(first, point, -force, -moment)


def loads(scene, motions, inputs):
    """All applied loads for inputs by name, e.g. {"arm.force": (3,), "elbow.torque": (1,)}."""
    sum_ = Loads(scene, motions)

    for name, body in scene.body.items():
        mass = body.mass_properties()[0]
        sum_.add(name, sum_.com(name), mass * np.array(scene.gravity))

        for path, spec in (((name,), body), *(((name, key), m) for key, m in body.marker.items())):
            _, (r, A, v, w) = marker_motion(scene, motions, ".".join(path))
            A = A if spec.input_axes == "body" else np.eye(3)
            dotted = ".".join(map(fmi_name, path))
            force = A @ inputs.get(f"{dotted}.force", np.zeros(3))
            moment = A @ inputs.get(f"{dotted}.moment", np.zeros(3))
            sum_.add(name, r, force, moment)
            sum_.power += force @ v + moment @ w

    for name, joint in scene.joint.items():
        (first, (r1, A1, v1, w1)), (second, (r2, A2, v2, w2)) = (
            marker_motion(scene, motions, end) for end in joint.between
        )
        effort = "force" if joint.kind == "prismatic" else "torque"
        given = inputs.get(f"{fmi_name(name)}.{effort}", np.zeros(1))

        if joint.kind == "spherical":
            torque = A1 @ np.broadcast_to(given, 3)
            sum_.pair(first, second, r2, np.zeros(3), torque)
            sum_.power += torque @ (w2 - w1)

        elif joint.kind in ("revolute", "prismatic"):
            axis = A1 @ joint.axis
            rotary = joint.kind == "revolute"
            q = joint_position(joint, r1, A1, r2, A2)
            speed = axis @ (w2 - w1 if rotary else v2 - v1 - cross(w1, r2 - r1))
            drive = given[0] - joint.damper * speed
            sum_.power += drive * speed

            if joint.spring:
                drive -= joint.spring.stiffness * (q - joint.spring.rest_value())

            if rotary:
                sum_.pair(first, second, r2, np.zeros(3), drive * axis)
            else:
                sum_.pair(first, second, r2, drive * axis)

    for force in scene.force.values():
        (first, (r1, A1, v1, w1)), (second, (r2, A2, v2, w2)) = (
            marker_motion(scene, motions, end) for end in force.between
        )

        if force.kind == "spring_damper":
            length = np.linalg.norm(r2 - r1)
            direction = (r2 - r1) / length
            rate = direction @ (v2 - v1)
            spec = force.spring_damper
            rest = spec.rest_length

            if rest is None:
                starts = start_motions(scene)
                ends = [marker_motion(scene, starts, end)[1][0] for end in force.between]
                rest = np.linalg.norm(ends[1] - ends[0])

            tension = spec.stiffness * (length - rest) + spec.damping * rate
            sum_.pair(first, second, r2, -tension * direction)
            sum_.power -= spec.damping * rate**2

        else:
            spec = force.linear
            turned = A1.T @ A2
            moved = np.concatenate([A1.T @ (r2 - r1), swing_and_twist(turned)])
            rates = np.concatenate([A1.T @ (v2 - v1 - cross(w1, r2 - r1)), A1.T @ (w2 - w1)])
            elastic = spec.preload_vector() - spec.stiffness_matrix() @ moved
            own = np.kron(np.eye(2), given_axes(spec, turned))
            drag = -own @ spec.damping_matrix() @ own.T @ rates
            moment = swing_and_twist_jacobian(turned).T @ elastic[3:] + drag[3:]
            sum_.pair(first, second, r2, A1 @ (elastic[:3] + drag[:3]), A1 @ moment)
            sum_.power += drag @ rates

    return sum_


def given_axes(spec, turned):
    """Axes (3, 3) in the first marker's of damping and added mass; turned : those of the second marker."""
    if spec.axes == "body":
        return turned

    yaw = swing_and_twist(turned)[2] if spec.axes == "heading" else 0.0
    return Rotation.from_euler("z", yaw).as_matrix()


def added_mass(spec, A1, A2, v, w):
    """(A, X): what its added mass takes is A (a, alpha) + X on the second marker's origin, in inertial axes.

    A1, A2 : axes of the markers. v, w : of the second marker. a : acceleration of the material point.
    """
    turn = np.kron(np.eye(2), A1 @ given_axes(spec, A1.T @ A2))
    A = turn @ spec.added_mass_matrix() @ turn.T
    V = np.concatenate([v, w])
    p = (A @ V)[:3]

    # Kirchhoff's equations, Lamb section 124: rates of the water's momenta about a point that moves
    if spec.axes == "body":
        spin = np.kron(np.eye(2), skew(w))
        return A, (spin @ A - A @ spin) @ V + np.concatenate([0 * v, cross(v, p)])

    # Lagrange's equations of the yaw
    if spec.axes == "heading":
        Z = np.kron(np.eye(2), skew(A1[:, 2]))
        slope = Z @ A - A @ Z
        yaw = A1 @ swing_and_twist_jacobian(A1.T @ A2)[2]
        return A, yaw @ w * slope @ V - np.concatenate([0 * v, V @ slope @ V / 2 * yaw])

    return A, np.zeros(6)


def joint_position(joint, r1, A1, r2, A2):
    """Coordinate of a joint of one degree of freedom; an angle is that at the start when it is there."""
    if joint.kind == "prismatic":
        return joint.axis @ A1.T @ (r2 - r1)

    angle = joint.axis @ Rotation.from_matrix(A1.T @ A2).as_rotvec()
    start = joint.start_position()[0]
    return start + (angle - start + np.pi) % (2 * np.pi) - np.pi


def accelerations(scene, motions, inputs):
    """(angular acceleration, acceleration of the centre of mass) of every body, by name, in inertial axes."""
    names = list(scene.body)
    column = {name: slice(6 * k, 6 * k + 6) for k, name in enumerate(names)}
    n = 6 * len(names)
    M = np.zeros((n, n))
    f = np.zeros(n)
    applied = loads(scene, motions, inputs)

    # unknowns of a body: acceleration of its centre of mass, angular acceleration
    for name in names:
        mass, _, inertia = scene.body[name].mass_properties()
        _, A, _, w = motions[name]
        J = A @ inertia @ A.T
        at = column[name]
        M[at, at] = np.block([[mass * np.eye(3), np.zeros((3, 3))], [np.zeros((3, 3)), J]])
        f[at] = np.concatenate([applied.force[name], applied.moment[name] - cross(w, J @ w)])

    def point(body, r):
        """(B, b): acceleration B a + b of the point of a body that is at r."""
        B, b = np.zeros((3, n)), np.zeros(3)

        if body != "ground":
            arm = r - applied.com(body)
            w = motions[body][3]
            B[:, column[body]] = np.hstack([np.eye(3), -skew(arm)])
            b = cross(w, cross(w, arm))

        return B, b

    def turning(body):
        """B: angular acceleration B a of a body."""
        B = np.zeros((3, n))

        if body != "ground":
            B[:, column[body]] = np.hstack([np.zeros((3, 3)), np.eye(3)])

        return B

    for force in scene.force.values():
        if force.kind == "linear" and np.any(force.linear.added_mass_matrix()):
            _, (_, A1, _, _) = marker_motion(scene, motions, force.between[0])
            body, (r, A2, v, w) = marker_motion(scene, motions, force.between[1])
            B, b = point(body, r)
            T, t = np.vstack([B, turning(body)]), np.concatenate([b, np.zeros(3)])
            added, quadratic = added_mass(force.linear, A1, A2, v, w)
            M += T.T @ added @ T
            f -= T.T @ (added @ t + quadratic)

    # joints: C a = gamma
    C, gamma = [], []

    for joint in scene.joint.values():
        (first, (r1, A1, v1, w1)), (second, (r2, A2, v2, w2)) = (
            marker_motion(scene, motions, end) for end in joint.between
        )
        turn = turning(second) - turning(first)

        # both points at r2, so that a prismatic joint's points are seen from the first body
        (B1, b1), (B2, b2) = point(first, r2), point(second, r2)
        axis = A1 @ joint.axis
        normal = np.linalg.svd(axis[None])[2][1:]

        if joint.kind in ("fixed", "spherical", "revolute"):
            C.append(B2 - B1)
            gamma.append(b1 - b2)

        if joint.kind in ("fixed", "prismatic"):
            C.append(turn)
            gamma.append(np.zeros(3))

        if joint.kind == "revolute":
            C.append(normal @ turn)
            gamma.append(normal @ cross(w1, w2))

        if joint.kind == "prismatic":
            slide = v2 - v1 - cross(w1, r2 - r1)
            C.append(normal @ (B2 - B1))
            gamma.append(normal @ (b1 - b2 + 2 * cross(w1, slide)))

    C = np.vstack(C) if C else np.zeros((0, n))
    gamma = np.concatenate(gamma) if gamma else np.zeros(0)
    system = np.block([[M, C.T], [C, np.zeros((len(C), len(C)))]])
    a = np.linalg.solve(system, np.concatenate([f, gamma]))[:n]
    return {name: (a[column[name]][3:], a[column[name]][:3]) for name in names}
