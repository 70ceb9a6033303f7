"""URDF files (robots of ROS) as scenes.

An own reader on lxml and not a package's: it knows the line of every mistake, it sees what it does not take over, and it needs
nothing that the package does not need anyway.
"""

import os
from pathlib import Path

from ..errors import Problem, SceneError, listed, quoted
from .frames import Parts, Pose, parts_of
from .imported import Imported
from .inertia import mass_keys
from .joints import Joints
from .names import Names
from .options import UrdfOptions
from .robot import Robot, read_robot
from .visuals import Looks

GRAVITY = [0.0, 0.0, -9.81]

AT_REST = {
    "position": [0.0] * 3,
    "euler_parameters": [0.0, 0.0, 0.0, 1.0],
    "velocity": [0.0] * 3,
    "omega": [0.0] * 3,
}
"""A start that is given, and gives way to nothing."""


def read_urdf(path, options=None, data=None):
    """A robot as an `Imported`.

    path : of the URDF file; data : its bytes, where they are read already. Raises SceneError, with the file's name and all that is
    wrong in it.
    """
    path = os.fspath(path)
    data = Path(path).read_bytes() if data is None else data
    robot = read_robot(data, path)

    if all(link.massless for link in robot.links.values()):
        text = "no link has a mass: <inertial> is missing in all of them, so that nothing could move"
        raise SceneError([Problem((), text)], file=path)

    return _Making(robot, options or UrdfOptions(), path).whole()


class _Making:
    """A scene in the making.

    markers : {body's link, or None for the ground: {marker's name: its keys}}. ends : {link: what a joint's `between` calls it}.
    """

    def __init__(self, robot: Robot, options: UrdfOptions, path):
        self.robot, self.options = robot, options
        self.looks = Looks(robot.colours, options, path)
        self.parts: Parts = parts_of(robot, options.base)
        source = f"{Path(path).name} (URDF, robot {quoted(robot.name)})"
        self.out = Imported({}, source, left_out=list(robot.left_out))
        self.markers = {link: {} for link in [None, *robot.links] if link is None or self.parts.is_body(link)}
        self.ends = {}

    def whole(self):
        """The `Imported`."""
        links, joint_names = Names("link"), Names("joint")
        self.names = links.all_of(self.robot.links)
        self.body_names = {name: self.names[name] for name in self.robot.links if self.parts.is_body(name)}
        joints = Joints(self.robot, self.options, self.parts, joint_names, self.out)
        self.joint_names = joints.names
        self.out.decided += links.told() + joint_names.told()
        self._place_markers()
        base = self._base(joint_names.new("base"))
        joint_tables = joints.tables(self._between)
        bodies = {self.body_names[name]: self._body(name) for name in self.body_names}
        ground = {"marker": self.markers[None]} if self.markers[None] else {}

        self.out.tables |= {
            "name": self.robot.name,
            "gravity": GRAVITY,
            **({"ground": ground} if ground else {}),
            "body": bodies,
            "joint": base | joint_tables,
            **({"coupling": joints.couplings} if joints.couplings else {}),
        }
        self._tell_frames()
        self._tell_looks()
        return self.out

    def _owner(self, link):
        """What `between` calls the body that a link lies on."""
        return "ground" if link is None else self.body_names[link]

    def _place_markers(self):
        """A marker for each link that is a frame of a body, or of the ground."""
        for link, (owner, pose) in self.parts.home.items():
            if owner == link:
                self.ends[link] = self._owner(link)
            else:
                self.markers[owner][self.names[link]] = pose.keys() | self._shape(link)
                self.ends[link] = f"{self._owner(owner)}.{self.names[link]}"

    def _between(self, joint):
        """The two ends of a joint; where its origin is not that of its parent, a marker of its name is there."""
        owner, pose = self.parts.home[joint.parent]
        first = self.ends[joint.parent]

        if (joint.origin[0], joint.origin[1]) != (Pose().xyz, Pose().rpy):
            name = Names("joint", self.markers[owner]).new(self.joint_names[joint.name], "_joint")
            self.markers[owner][name] = pose.then(Pose(*joint.origin)).keys()
            first = f"{self._owner(owner)}.{name}"

        return [first, self.ends[joint.child]]

    def _base(self, name):
        """{name: table} of the joint between ground and root, {} where the root is a marker of the ground."""
        root, free = self.robot.root, self.options.base == "free"
        what = (
            "moves freely; --base fixed holds it"
            if free
            else "is fixed to the ground; --base free lets it go"
        )
        self.out.decided.append(f"the base, {quoted(self.names[root])}, {what}")

        if not self.parts.is_body(root):
            return {}

        table = {self.options.base: {}, "between": ["ground", self.body_names[root]]}

        if free and any(joint.mimic for joint in self.robot.joints.values()):
            table["start"] = AT_REST
        if free:
            table["output"] = ["position", "euler_parameters", "velocity", "omega"]

        return {name: table}

    def _body(self, link):
        """The table of a body."""
        keys, changed, odd = mass_keys(self.robot.links[link])

        if changed:
            self.out.decided.append(changed)
        if changed or odd:
            self.out.comments["body", self.body_names[link]] = [odd or "its inertia was changed, see above"]
        if self.markers[link]:
            keys["marker"] = self.markers[link]

        return keys | self._shape(link)

    def _shape(self, link):
        """{"shape": looks of a link}, or nothing."""
        visuals = self.robot.links[link].visuals if self.options.looks else []
        shapes = self.looks.shapes(visuals, lambda origin: Pose(*origin).keys())
        return {"shape": shapes} if shapes else {}

    def _tell_frames(self):
        """What became of links without mass."""
        frames = [
            self.names[link]
            for link in self.robot.links
            if not self.parts.is_body(link) and link != self.robot.root
        ]
        light = [name for link, name in self.body_names.items() if self.robot.links[link].massless]

        if frames:
            self.out.decided.append(f"links without mass on fixed joints are markers: {listed(frames)}")
        if light:
            self.out.decided.append(
                f"bodies without mass, which something else moves or holds: {listed(light)}"
            )

    def _tell_looks(self):
        """Looks that are not taken over."""
        if not self.options.looks and (count := sum(len(link.visuals) for link in self.robot.links.values())):
            self.out.left_out.append(f"{count} <visual> of links, as was asked for")

        reasons = {}
        for name, why in self.looks.lost.items():
            reasons.setdefault(why, []).append(name)
        for why, names in reasons.items():
            self.out.left_out.append(f"looks of {listed(names, limit=3)}: {why}")
