"""Which links of a robot become bodies, which markers, and where the frames of all are."""

from dataclasses import dataclass

from ...rotations import Rotation
from ...vectors import dot
from .robot import ONE_FREEDOM, ORIGIN, Robot


@dataclass(frozen=True)
class Pose:
    """Where a frame is in another: xyz (m) and rpy (rad) as the file has them, or, of frames on frames, Euler parameters."""

    xyz: tuple = (0.0, 0.0, 0.0)
    rpy: tuple = (0.0, 0.0, 0.0)
    euler_parameters: tuple | None = None

    @property
    def is_identity(self):
        return (self.xyz, self.rpy) == ORIGIN and self.euler_parameters is None

    def rotation(self):
        if self.euler_parameters is not None:
            return Rotation.from_quat(self.euler_parameters)
        # about fixed axes x, y, z is about moving ones z, y, x
        return Rotation.from_euler("ZYX", self.rpy[::-1])

    def then(self, other):
        """The pose of a frame that `other` says in this one."""
        if self.is_identity or other.is_identity:
            return other if self.is_identity else self

        A = self.rotation().as_matrix()
        xyz = tuple(float(a + b) for a, b in zip(self.xyz, dot(A, other.xyz)))
        turned = Rotation.from_matrix(dot(A, other.rotation().as_matrix()))
        return Pose(_clean(xyz), euler_parameters=_clean(turned.as_quat()))

    def keys(self):
        """Keys of a marker or a look in a scene."""
        keys = {}

        if any(self.xyz):
            keys["position"] = list(self.xyz)
        if self.euler_parameters is not None:
            keys["euler_parameters"] = list(self.euler_parameters)
        elif any(self.rpy):
            keys["zyx_rad"] = list(self.rpy[::-1])

        return keys


def _clean(values):
    """Numbers without the dust of rounding."""
    return tuple(0.0 if abs(value) < 1e-15 else float(value) for value in values)


@dataclass
class Parts:
    """What becomes of the links of a robot.

    home : {link: (the link whose body it lies on, None for the ground; its pose there)}.
    held : joints that could move and carry nothing that has mass or inertia: they are taken for fixed ones.
    """

    home: dict
    held: list

    def is_body(self, link):
        """Whether a link is a body of its own."""
        return self.home[link][0] == link


def parts_of(robot: Robot, base):
    """The `Parts` of a robot whose base is "fixed" or "free".

    A link without mass on a fixed joint is a frame of what it is fixed to, a marker: bodies alone have mass, or move.
    """
    held = _held(robot)
    home = {}
    root_is_frame = base == "fixed" and robot.links[robot.root].massless
    home[robot.root] = (None if root_is_frame else robot.root, Pose())

    for name in [robot.root, *(link for joint in robot.children(robot.root) for link in robot.beyond(joint))]:
        for joint in robot.children(name):
            is_frame = robot.links[joint.child].massless and (joint.kind == "fixed" or joint in held)
            owner, pose = home[name]
            home[joint.child] = (owner, pose.then(Pose(*joint.origin))) if is_frame else (joint.child, Pose())

    return Parts(home, held)


def _held(robot):
    """Joints that could move, and move nothing that has mass, alone or by what follows them."""
    movable = [joint for joint in robot.joints.values() if joint.kind != "fixed"]
    idle = {
        joint.name for joint in movable if all(robot.links[name].massless for name in robot.beyond(joint))
    }
    groups = {joint.name: leader(robot, joint) for joint in movable}
    moved = {groups[name] for name in groups if name not in idle}

    return [joint for joint in movable if joint.name in idle and groups[joint.name] not in moved]


def leader(robot, joint):
    """Name of the joint that a joint follows by mimics in the end, its own where it follows none."""
    while joint.mimic and joint.kind in ONE_FREEDOM and joint.mimic.joint in robot.joints:
        joint = robot.joints[joint.mimic.joint]
    return joint.name
