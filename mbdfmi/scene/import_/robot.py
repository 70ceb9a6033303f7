"""A URDF file as it stands: links and joints, checked one by one and as a tree.

The format: https://docs.ros.org/en/rolling/p/urdfdom/ and http://wiki.ros.org/urdf/XML.
"""

import math
import re
from dataclasses import dataclass, field

from ..errors import Problem, SceneError, did_you_mean, listed, quoted, show
from .elements import Reading, parsed
from .leftovers import note_leftovers
from .visuals import Visual, read_colours, read_visuals

KINDS = ("revolute", "continuous", "prismatic", "fixed", "floating", "planar")
"""Types of joints."""

ONE_FREEDOM = ("revolute", "continuous", "prismatic")

ORIGIN = ((0.0, 0.0, 0.0), (0.0, 0.0, 0.0))
"""xyz and rpy where nothing else is said."""


@dataclass
class Link:
    """A link: its mass (kg), its centre of mass and inertia axes (xyz in m, rpy in rad, in its own frame), its inertia about these
    (xx, yy, zz, xy, xz, yz in kg m2), what it looks like.
    """

    name: str
    element: object
    mass: float = 0.0
    origin: tuple = ORIGIN
    inertia: tuple = (0.0,) * 6
    visuals: list[Visual] = field(default_factory=list)

    @property
    def massless(self):
        """Whether it has neither mass nor inertia."""
        return self.mass == 0.0 and not any(self.inertia)


@dataclass
class Mimic:
    """A joint's coordinate is multiplier times another one's, plus offset (SI)."""

    joint: str
    multiplier: float
    offset: float


@dataclass
class RobotJoint:
    """A joint from link to link, as the file has it. Limits are None where none is said, efforts and speeds SI."""

    name: str
    element: object
    kind: str
    parent: str
    child: str
    origin: tuple = ORIGIN
    axis: tuple = (1.0, 0.0, 0.0)
    lower: float | None = None
    upper: float | None = None
    effort: float | None = None
    velocity: float | None = None
    damping: float = 0.0
    friction: float = 0.0
    mimic: Mimic | None = None


@dataclass
class Robot:
    """All of a file. colours : of materials, (red, green, blue, alpha). parent : {link: the joint that leads to it}; root : the link that none leads to; left_out : what was not read,
    in words.
    """

    name: str
    links: dict[str, Link]
    joints: dict[str, RobotJoint]
    root: str = ""
    colours: dict[str, tuple] = field(default_factory=dict)
    parent: dict[str, RobotJoint] = field(default_factory=dict)
    left_out: list[str] = field(default_factory=list)

    def children(self, link):
        """The joints that lead on from a link."""
        return [joint for joint in self.joints.values() if joint.parent == link]

    def beyond(self, joint):
        """Names of the links that a joint carries."""
        names = [joint.child]
        for name in names:
            names += [further.child for further in self.children(name)]
        return names


def read_robot(data, file):
    """The `Robot` of the bytes of a URDF file. Raises SceneError with all that is wrong in it, by line."""
    root = parsed(data, file)
    reading = Reading()
    _refuse_others(root, file)

    with reading.finished(file):
        links = _named(reading, root, "link", _link)
        joints = _named(reading, root, "joint", _joint)
        name = (root.get("name") or "").strip() or "robot"
        robot = Robot(name, links, joints, colours=read_colours(reading, root))

        if not links:
            what = "it holds nothing" if len(root) == 0 else "there is no <link> in it"
            reading.wrong(root, f"{what}; a robot has links and joints")

        _check_references(reading, robot)

    with reading.finished(file):
        _make_tree(reading, robot)

    note_leftovers(reading, root)
    robot.left_out = [f"{count} {what}" for what, count in reading.left_out.items()]
    return robot


def _refuse_others(root, file):
    """Raises SceneError for what is not URDF, or not yet."""
    if root.tag != "robot":
        text = f"line {root.sourceline}: the first element is <{root.tag}>; a URDF file begins with <robot>"
        raise SceneError([Problem((), text)], file=file)

    for element in root.iter():
        if not isinstance(element.tag, str):
            continue

        is_macro = re.match(r"\{[^}]*xacro[^}]*\}", element.tag)

        if is_macro or any(re.search(r"\$[{(]", value) for value in element.attrib.values()):
            what = f"<xacro:{element.tag.partition('}')[2]}>" if is_macro else "${...}"
            text = (
                f"line {element.sourceline}: {what} is of xacro, the macro language of URDF; expand it first: "
                f"xacro {file} > robot.urdf (pip install xacro, or ROS's own)"
            )
            raise SceneError([Problem((), text)], file=file)


def _named(reading, root, tag, read):
    """{name: what `read` makes of the element} of the elements of a tag."""
    found = {}

    for element in root.findall(tag):
        name = reading.text(element, "name")

        if name in found:
            first = found[name].element.sourceline
            reading.wrong(element, f"there is a {tag} of that name already, in line {first}")
        elif name:
            found[name] = read(reading, element, name)

    return found


def _origin(reading, element):
    """(xyz, rpy) of an element's <origin>."""
    origin = reading.child(element, "origin")
    if origin is None:
        return ORIGIN
    return tuple(reading.numbers(origin, key, 3, (0.0,) * 3) for key in ("xyz", "rpy"))


def _link(reading, element, name):
    link = Link(name, element, visuals=read_visuals(reading, element, _origin))
    inertial = reading.child(element, "inertial")

    if inertial is None:
        return link

    mass, inertia = (reading.child(inertial, tag, needed=True) for tag in ("mass", "inertia"))
    link.origin = _origin(reading, inertial)

    if mass is not None:
        link.mass = reading.number(mass, "value")

        if link.mass < 0.0:
            reading.wrong(mass, f"must not be negative, found {show(mass.get('value'))}", "value")
    if inertia is not None:
        keys = ("ixx", "iyy", "izz", "ixy", "ixz", "iyz")
        link.inertia = tuple(
            reading.number(inertia, key, None if k < 3 else 0.0) for k, key in enumerate(keys)
        )

    return link


def _joint(reading, element, name):
    kind = reading.text(element, "type")

    if kind is not None and kind not in KINDS:
        text = f"no type {show(kind)} of joints in URDF; there is {listed(KINDS)}.{did_you_mean(kind, KINDS)}"
        reading.wrong(element, text, "type")

    ends = []
    for tag in ("parent", "child"):
        end = reading.child(element, tag, needed=True)
        ends.append(reading.text(end, "link") if end is not None else None)

    joint = RobotJoint(name, element, kind, *ends, origin=_origin(reading, element))
    axis = reading.child(element, "axis")

    if axis is not None and kind != "fixed":
        wrong = len(reading.problems)
        joint.axis = reading.numbers(axis, "xyz", 3)
        if math.hypot(*joint.axis) < 1e-9 and len(reading.problems) == wrong:
            reading.wrong(axis, f"an axis needs a direction, found {show(axis.get('xyz'))}", "xyz")

    if (dynamics := reading.child(element, "dynamics")) is not None:
        joint.damping, joint.friction = (
            _not_negative(reading, dynamics, key) for key in ("damping", "friction")
        )
    if (limit := reading.child(element, "limit")) is not None:
        _read_limits(reading, limit, joint)
    if (mimic := reading.child(element, "mimic")) is not None:
        numbers = (
            reading.number(mimic, key, default) for key, default in (("multiplier", 1.0), ("offset", 0.0))
        )
        joint.mimic = Mimic(reading.text(mimic, "joint"), *numbers)

    return joint


def _not_negative(reading, element, key):
    value = reading.number(element, key, 0.0)
    if value < 0.0:
        reading.wrong(element, f"must not be negative, found {show(element.get(key))}", key)
    return value


def _read_limits(reading, limit, joint):
    """Limits are infinite in files that mean none."""
    values = {
        key: reading.number(limit, key, infinite=True) if key in limit.attrib else None
        for key in ("lower", "upper", "effort", "velocity")
    }

    # URDF takes 0 for an end that is not told, where the other one is
    if joint.kind in ("revolute", "prismatic") and (values["lower"] is None) != (values["upper"] is None):
        values |= {key: 0.0 for key in ("lower", "upper") if values[key] is None}

    for key, value in values.items():
        setattr(joint, key, None if value is None or math.isinf(value) else value)


def _check_references(reading, robot):
    """Links that joints name, and joints that follow each other."""
    for joint in robot.joints.values():
        for tag, name in (("parent", joint.parent), ("child", joint.child)):
            if name is not None and name not in robot.links:
                near = did_you_mean(name, robot.links)
                text = f"there is no link {quoted(name)}; there is {listed(robot.links) or 'none'}.{near}"
                reading.wrong(joint.element.find(tag), text, "link")

        if joint.parent is not None and joint.parent == joint.child:
            reading.wrong(joint.element, f"parent and child are both {quoted(joint.parent)}")

        leader, seen = joint, [joint.name]

        while leader and leader.mimic:
            leader = robot.joints.get(leader.mimic.joint)
            if leader and leader.name in seen:
                if leader is joint:
                    ring = " -> ".join(map(quoted, [*seen, leader.name]))
                    reading.wrong(joint.element.find("mimic"), f"mimics itself: {ring}", "joint")
                break
            seen.append(leader.name if leader else "")


def _make_tree(reading, robot):
    """Every link but one has one joint that leads to it, and none leads round."""
    for joint in robot.joints.values():
        if joint.child in robot.parent:
            first = robot.parent[joint.child]
            text = (
                f"leads to {quoted(joint.child)}, and so does {quoted(first.name)} in line {first.element.sourceline}: a URDF is a tree, "
                "each link has one parent. Close loops in the scene that is made of it, by a joint more"
            )
            reading.wrong(joint.element, text)
        else:
            robot.parent[joint.child] = joint

    roots = [name for name in robot.links if name not in robot.parent]

    if len(roots) > 1:
        text = f"{listed(roots)} have no parent: one link alone, the root, has none; a joint to each of the others is missing"
        reading.wrong(robot.links[roots[1]].element, text)
    elif roots:
        robot.root = roots[0]

    lost = {name for name in robot.links if name not in roots} - {
        name for root in roots for joint in robot.children(root) for name in robot.beyond(joint)
    }
    if lost and not reading.problems:
        first = next(name for name in robot.links if name in lost)
        ring = [first]
        while (parent := robot.parent[ring[-1]].parent) not in ring:
            ring.append(parent)
        ring = ring[ring.index(parent) :]
        text = f"a ring of joints: {' -> '.join(map(quoted, [ring[0], *reversed(ring)]))}; a URDF is a tree, it begins with a link that has no parent"
        reading.wrong(robot.parent[ring[0]].element, text)
