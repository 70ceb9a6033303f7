"""Joints of a robot as joints and couplings of a scene."""

from ..errors import did_you_mean, listed, quoted
from .robot import ONE_FREEDOM

AXES = {
    tuple(sign * float(k == j) for j in range(3)): name + "xyz"[k]
    for name, sign in (("", 1.0), ("-", -1.0))
    for k in range(3)
}
"""Axes that have names."""

SCENE_KINDS = {"continuous": "revolute", "floating": "free"}
"""Types of URDF that a scene calls otherwise."""

UNITS = {"revolute": ("rad", "N m", "rad/s"), "prismatic": ("m", "N", "m/s")}
"""Of position, effort and speed."""


class Joints:
    """The joints and couplings of a scene that is made of a robot; what is decided of them is told in `out`, an `Imported`.

    names : `Names` of joints, and of couplings, which must differ from these. couplings : their tables by name, once `tables` was
    called.
    """

    def __init__(self, robot, options, parts, names, out):
        self.robot, self.options, self.parts, self.out = robot, options, parts, out
        self.names = names.all_of(robot.joints)
        self.coupling_name = lambda joint: names.new(f"{joint}_mimic")
        self.couplings = {}

    def tables(self, between):
        """{name: table} of all joints; `between` gives a joint's ends."""
        found = {}

        for joint in self.robot.joints.values():
            if self.parts.is_body(joint.child):
                found[self.names[joint.name]] = self._table(joint, between(joint))

        self._tell_limits()
        self._tell_idle()
        return found

    def _table(self, joint, ends):
        kind = SCENE_KINDS.get(joint.kind, joint.kind)
        axis = AXES.get(tuple(c + 0.0 for c in joint.axis), list(joint.axis))
        options = {"planar": {"normal": axis}, "fixed": {}, "free": {}}.get(kind, {"axis": axis})
        table = {kind: options, "between": ends}

        if kind in UNITS:
            table |= self._acting(joint, kind) | self._moving(joint, kind)
            self._comment(joint, kind)
        elif kind != "fixed":
            table["output"] = {"free": ["position", "euler_parameters", "velocity", "omega"]}.get(
                kind, ["position", "angle"]
            )

        return table

    def _acting(self, joint, kind):
        """Damper, friction, stop."""
        keys = {}
        stiffness, damping = self.options.stop(kind)
        limits = self._limits(joint)

        if joint.damping:
            keys["damper"] = joint.damping
        if joint.friction:
            keys["friction"] = {"coulomb": joint.friction}
        if limits and stiffness is not None:
            lower, upper = limits
            keys["stop"] = {"lower": lower, "upper": upper, "stiffness": stiffness}
            keys["stop"] |= {"damping": damping} if damping else {}

        return keys

    def _limits(self, joint):
        """(lower, upper) of a joint of one freedom that has a range, else None."""
        lower, upper = joint.lower, joint.upper
        has_range = joint.kind != "continuous" and lower is not None and upper is not None and lower < upper
        return (lower, upper) if has_range else None

    def _moving(self, joint, kind):
        """Start, driver, input and output; a coupling where it mimics another joint."""
        position = "angle" if kind == "revolute" else "position"
        outputs = {"output": [position, "speed"]}
        followed = self._followed(joint)

        if followed is not None and self._stands(joint):
            self.out.decided.append(
                f"{quoted(joint.name)} mimics what does not move: it is held at {joint.mimic.offset:g} {UNITS[kind][0]}"
            )
            return {"start": {position: joint.mimic.offset}, "driver": {"hold": True}} | outputs

        if followed is not None:
            linear = {"ratio": joint.mimic.multiplier, "offset": joint.mimic.offset}
            self.couplings[self.coupling_name(self.names[joint.name])] = {
                "linear": linear,
                "between": [self.names[followed.name], self.names[joint.name]],
            }
            return outputs

        start = self._start_within(joint)
        inputs = {"input": "torque" if kind == "revolute" else "force"}

        # where some follow others all of the rest is given, so that nothing of it gives way to these
        if any(other.mimic for other in self.robot.joints.values()):
            return {"start": {position: start, "speed": 0.0}} | inputs | outputs

        return ({"start": {position: start}} if start else {}) | inputs | outputs

    def _followed(self, joint):
        """The joint of one freedom that a joint mimics, or None."""
        if not joint.mimic:
            return None

        followed = self.robot.joints.get(joint.mimic.joint)

        if followed is None:
            text = f"{quoted(joint.name)} mimics {quoted(joint.mimic.joint)}, which there is not: it moves by itself."
            text += did_you_mean(joint.mimic.joint, self.robot.joints)
        elif followed.kind in ("floating", "planar"):
            text = f"{quoted(joint.name)} mimics {quoted(followed.name)}, which has more than one freedom: it moves by itself"
        else:
            return followed

        if text not in self.out.decided:
            self.out.decided.append(text)
        return None

    def _stands(self, joint):
        """Whether what a joint mimics does not move."""
        followed = self.robot.joints[joint.mimic.joint]
        return followed.kind == "fixed" or followed in self.parts.held or joint.mimic.multiplier == 0.0

    def _start_within(self, joint):
        """Where a joint starts: 0, or, with stops, the end of its range nearest to it."""
        limits = self._limits(joint)
        if not limits or self.options.stop_stiffness is None:
            return 0.0
        return min(max(0.0, limits[0]), limits[1])

    def _comment(self, joint, kind):
        """Limits of the file, above the joint."""
        unit, of_effort, of_speed = UNITS[kind]
        words = []

        if joint.effort is not None:
            words.append(f"effort {joint.effort:g} {of_effort}")
        if joint.velocity is not None:
            words.append(f"speed {joint.velocity:g} {of_speed}")
        if limits := self._limits(joint):
            words.append(f"{limits[0]:g} to {limits[1]:g} {unit}")
        if words:
            self.out.comments["joint", self.names[joint.name]] = [f"limits: {', '.join(words)}"]

    def _tell_limits(self):
        """What became of limits."""
        moving = [
            joint
            for joint in self.robot.joints.values()
            if joint.kind in ONE_FREEDOM and self.parts.is_body(joint.child)
        ]
        ranged = [joint for joint in moving if self._limits(joint)]
        empty = [
            joint.name
            for joint in moving
            if joint.lower is not None and joint.kind != "continuous" and joint.lower >= joint.upper
        ]
        outside = [
            joint.name for joint in ranged if not joint.mimic and not joint.lower <= 0.0 <= joint.upper
        ]
        stops = self.options.stop_stiffness is not None
        told = self.out.decided

        if ranged and stops:
            told.append(f"limits of position of {_joints(ranged)} are stops")
        elif ranged:
            self.out.left_out.append(
                f"limits of position of {_joints(ranged)} (comments say them): URDF does not say how stiff they are, "
                "--stop-stiffness makes stops of them"
            )
        if outside:
            where = "start at the nearer end" if stops else "start at 0 all the same"
            told.append(f"joints whose limits 0 is beyond {where}: {listed(outside)}")
        if empty:
            told.append(f"limits whose lower end is not below the upper one are none: {listed(empty)}")
        if any(joint.effort is not None or joint.velocity is not None for joint in moving):
            self.out.left_out.append(
                "limits of effort and speed (comments say them): nothing in a scene holds inputs to them"
            )

    def _tell_idle(self):
        """Joints that are held, and what fixed ones have that they cannot use."""
        if self.parts.held:
            names = listed([joint.name for joint in self.parts.held])
            self.out.decided.append(f"joints that move nothing that has mass are held at 0: {names}")

        for tag in ("limit", "dynamics", "mimic"):
            idle = [
                j for j in self.robot.joints.values() if j.kind == "fixed" and j.element.find(tag) is not None
            ]
            if idle:
                self.out.left_out.append(f"{len(idle)} <{tag}> of fixed joints, which do not move")


def _joints(joints):
    """How many there are, in words."""
    return f"{len(joints)} joint{'s' * (len(joints) > 1)}"
