"""What a URDF file holds and a scene cannot say: counted, so that it can be told."""

from collections import Counter

from .elements import Reading

KNOWN = {
    "robot": ({"name", "version"}, {"link", "joint", "material"}),
    "link": ({"name"}, {"inertial", "visual"}),
    "visual": ({"name"}, {"origin", "geometry", "material"}),
    "geometry": ({"name"}, {"box", "cylinder", "sphere", "capsule", "mesh"}),
    "box": ({"size"}, set()),
    "cylinder": ({"radius", "length"}, set()),
    "sphere": ({"radius"}, set()),
    "capsule": ({"radius", "length"}, set()),
    "mesh": ({"filename", "scale"}, set()),
    "material": ({"name"}, {"color"}),
    "color": ({"rgba"}, set()),
    "inertial": (set(), {"origin", "mass", "inertia"}),
    "mass": ({"value"}, set()),
    "inertia": ({"ixx", "iyy", "izz", "ixy", "ixz", "iyz"}, set()),
    "origin": ({"xyz", "rpy"}, set()),
    "joint": ({"name", "type"}, {"origin", "parent", "child", "axis", "limit", "dynamics", "mimic"}),
    "parent": ({"link"}, set()),
    "child": ({"link"}, set()),
    "axis": ({"xyz"}, set()),
    "limit": ({"lower", "upper", "effort", "velocity"}, set()),
    "dynamics": ({"damping", "friction"}, set()),
    "mimic": ({"joint", "multiplier", "offset"}, set()),
}
"""Elements that are read, each with the attributes and the children that are read of it."""

WHY = {
    "link/collision": "bodies do not touch",
    "link/contact": "bodies do not touch",
    "link/surface": "bodies do not touch",
    "link/collision_checking": "bodies do not touch",
    "link/self_filter": "bodies do not touch",
    "joint/safety_controller": "a scene holds no controllers",
    "joint/calibration": "positions of switches, no mechanics",
    "link/texture": "looks have colours",
    "material/texture": "looks have colours",
    "transmission": "efforts of inputs act on the joint, behind the gear; its rotor is `turning` in a scene",
    "gazebo": "for the simulator Gazebo",
    "ros2_control": "for controllers",
    "sensor": "ask for outputs of markers",
    "joint/dynamics K": "not of URDF; a stiffness is `spring` in a scene",
    "joint/dynamics D": "not of URDF; a damping is `damper` in a scene",
    "joint/dynamics mu_coulomb": "not of URDF; dry friction is `friction` in a scene",
    "joint/dynamics mu_viscous": "not of URDF; viscous friction is `damper` in a scene",
}
"""Why it stays out."""


def note_leftovers(reading: Reading, root):
    """Adds to `reading.left_out` what is in the file and was not read."""
    found = Counter()
    _count(root, "", found)

    for (owner, what), count in found.items():
        why = WHY.get(f"{owner}/{what}".lstrip("/"), "no such thing in URDF, or none that is known here")
        words = what.replace(" ", "> ", 1) if " " in what else f"{what}>"
        reading.left_out[f"<{words}{f' of a {owner}' if owner else ''}: {why}"] += count


def _count(element, owner, found):
    """Counts what is not read of an element that is, the outermost of it alone, by owner ("link", "joint", ...; "" the robot) and
    words.
    """
    keys, tags = KNOWN[element.tag]

    for key in element.attrib:
        if key not in keys:
            found[owner, f"{element.tag} {_plain(key)}"] += 1

    inside = "" if element.tag == "robot" else owner or element.tag

    for child in element:
        if not isinstance(child.tag, str):
            continue
        if child.tag in tags:
            _count(child, inside, found)
        else:
            found[inside, _plain(child.tag)] += 1


def _plain(tag):
    """A tag or an attribute without its namespace."""
    return tag.rpartition("}")[2]
