"""Where things are at the start, as far as start values alone tell."""

import numpy as np

from ..lazily import scipy
from ..rotations import Rotation
from ..vectors import dot, norm
from .frames import IDENTITY, compose, inverse
from .interpolation import curve
from .joint_kinds import kind_of


def start_pose(builder, end):
    """Pose (r (3,) m, A (3, 3)) of a marker of the scene in the inertial frame, before loops are closed."""
    if end == "inertial":
        return np.zeros(3), np.eye(3)

    node, pose = builder.tree.marker(builder.scene, end)

    while node > 0:
        at = builder.nodes[node]
        pose = compose(compose(at.joint_frame, _joint_pose(builder, node)), pose)
        node = at.parent

    return pose


def start_position(joint):
    """The first scalar coordinate of a joint (rad or m): what its driver asks for at time 0, or its start value."""
    return position_at_start(joint.driver, float(joint.start_position()[0]))


def position_at_start(driver, start):
    """What a driver asks for at time 0 (rad or m), or the start value where it goes on from there."""
    if driver and driver.kind == "table":
        time, position = driver.table.points()
        return float(curve(driver.table.interpolation, time, position)(np.clip(0.0, time[0], time[-1])))

    if driver and driver.kind in ("harmonic", "harmonics", "polynomial", "ramp"):
        return getattr(driver, driver.kind).at(0.0)

    return start


def coupled_angles(scene):
    """Angles (rad) at the start of revolute joints that their drivers tell, or, without a start of their own, couplings:
    (joint, 0) -> rad.
    """
    held = {
        name: joint for name, joint in scene.joint.items() if kind_of(joint).is_one_axis and _tells(joint)
    }
    known = {name: start_position(joint) for name, joint in held.items()}
    links = [(dict(c.terms), c.offset) for c in scene.coupling.values() if c.offset is not None]

    for _ in links:
        for factors, offset in links:
            unknown = [name for name in factors if name not in known]

            if len(unknown) == 1:
                total = offset + sum(
                    factor * known[name] for name, factor in factors.items() if name in known
                )
                known[unknown[0]] = -total / factors[unknown[0]]

    told = (name for name in known if name not in held or scene.joint[name].driver)
    return {(name, 0): known[name] for name in told if kind_of(scene.joint[name]).motions == ("revolute",)}


def _tells(joint):
    """Whether a joint's driver or start says where it is."""
    return joint.holds_position or joint.driver is not None


def _joint_pose(builder, i):
    """Pose of a node in its joint frame at its start values."""
    node = builder.nodes[i]
    q = builder.single["q_start"][builder.q[i] :]

    if not node.joint and builder.scene.ground.motion and i == builder.tree.home["ground"][0]:
        return _ground_pose(builder.scene.ground.motion)

    if node.kind == "revolute":
        return np.zeros(3), Rotation.from_rotvec([0, 0, q[0]]).as_matrix()

    if node.kind == "prismatic":
        return np.array([0, 0, q[0]]), np.eye(3)

    if node.kind == "fixed":
        return IDENTITY

    r, E = (q[:3], q[3:7]) if node.kind == "free" else (np.zeros(3), q[:4])
    pose = (r, Rotation.from_quat(E).as_matrix())
    return inverse(pose) if node.reversed else pose


def _ground_pose(motion):
    """Pose of a moving ground in the inertial frame at time 0."""
    if motion.kind == "acceleration":
        return np.array(motion.position), np.eye(3)

    if motion.kind == "rotation":
        turn = motion.rotation
        A = Rotation.from_rotvec(turn.angle_value() * turn.direction()).as_matrix()
        return turn.point - dot(A, turn.point), A

    if motion.kind == "orbit":
        A = dot(motion.orbit.axes(), Rotation.from_rotvec([0, 0, motion.orbit.phase_value()]).as_matrix())
        return motion.orbit.radius * A[:, 0], A if motion.orbit.pointing else np.eye(3)

    if motion.kind == "elliptic_orbit":
        return _pose_on_ellipse(motion.elliptic_orbit)

    if motion.kind == "table":
        time, position, E = motion.table.points()
        now = np.clip(0.0, time[0], time[-1])
        r, E = np.split(
            [curve(motion.table.interpolation, time, y)(now) for y in np.hstack([position, E]).T], [3]
        )
        return r, Rotation.from_quat(E).as_matrix()

    return IDENTITY


def _pose_on_ellipse(orbit):
    """Pose at time 0 of a ground on an elliptic orbit."""
    M, e = orbit.mean_anomaly_value(), orbit.eccentricity
    E = scipy.optimize.brentq(lambda E: E - e * np.sin(E) - M, M - 1.0, M + 1.0, xtol=1e-15)
    r = dot(orbit.axes(), np.array([np.cos(E) - e, np.sqrt(1 - e * e) * np.sin(E), 0.0]))
    radial, normal = r / norm(r), orbit.axes()[:, 2]
    A = np.column_stack([radial, np.cross(normal, radial), normal]) if orbit.pointing else np.eye(3)
    return orbit.semi_major_axis * r, A
