"""Joints: start values, springs, inputs, outputs."""

import numpy as np

from ..kernels import notes, outputs
from ..scene.starts import ENDINGS
from .contacts import add_contact_outputs
from .elastic import elastic_table
from .start import start_position
from .variables import dotted

# what the scalar coordinates of a joint are: names of a coordinate and its rate, its unit; several of one name are an array
COORDINATES = {
    "fixed": [],
    "revolute": [("angle", "speed", "rad")],
    "prismatic": [("position", "speed", "m")],
    "screw": [("position", "speed", "m"), ("angle", "angular_speed", "rad")],
    "cylindrical": [("position", "speed", "m"), ("angle", "angular_speed", "rad")],
    "universal": [("angles", "speeds", "rad")] * 2,
    "planar": [("position", "velocity", "m")] * 2 + [("angle", "angular_speed", "rad")],
    "translation": [("position", "velocity", "m")] * 3,
}

# joints whose position is more than a list of numbers: (name, unit, size) of what starts q and v, and outputs between the markers
POSES = {
    "spherical": ([("euler_parameters", None, 4)], [("omega", "rad/s", 3)]),
    "free": (
        [("position", "m", 3), ("euler_parameters", None, 4)],
        [("velocity", "m/s", 3), ("omega", "rad/s", 3)],
    ),
}
REACTIONS = {
    "reaction_force": (outputs.REACTION_FORCE, "N", "force"),
    "reaction_moment": (outputs.REACTION_MOMENT, "N.m", "moment about the second marker's origin"),
}
POSE_OUTPUTS = {
    "position": (outputs.POSITION, "m", "position"),
    "velocity": (outputs.VELOCITY, "m/s", "velocity"),
    "euler_parameters": (outputs.EULER_PARAMETERS, None, "Euler parameters, scalar last,"),
    "zyx": (outputs.ZYX, "rad", "yaw, pitch, roll"),
    "zyx_rate": (outputs.ZYX_RATE, "rad/s", "rates of yaw, pitch, roll"),
    "omega": (outputs.OMEGA, "rad/s", "angular velocity"),
    "alpha": (outputs.ALPHA, "rad/s2", "angular acceleration"),
}
EFFORTS = {
    # name: (kind, what it is of)
    "spring_effort": (outputs.SPRING_EFFORT, "spring"),
    "damper_effort": (outputs.DAMPER_EFFORT, "damper"),
    "friction_effort": (outputs.FRICTION_EFFORT, "friction"),
    "stop_effort": (outputs.STOP_EFFORT, "stop"),
    "input_effort": (outputs.INPUT_EFFORT, "input"),
}


def add_joints(builder):
    """Everything about joints but the constraints of those that close loops."""
    builder.single |= {"q_start": np.zeros(builder.n_q), "v_start": np.zeros(builder.n_v)}

    for name, joint in builder.scene.joint.items():
        if name in builder.joint_nodes:
            _add_start(builder, name, joint)

        if not joint.driver:
            _tell_start(builder, name, joint)

        parts = {}

        if joint.spring or joint.damper:
            parts["spring"] = parts["damper"] = _add_spring(builder, name, joint)

        if joint.friction:
            parts["friction"] = _add_friction(builder, name, joint)

        if joint.stop:
            parts["stop"] = _add_stop(builder, name, joint)

        fed_by = _add_inputs(builder, name, joint, parts)
        _add_outputs(builder, name, joint, parts, fed_by)


def _add_start(builder, name, joint):
    """Start values as parameters; a screw's position follows from its angle."""
    q, v = joint.start_position(), joint.start_velocity()
    q = np.array([start_position(joint)]) if joint.driver else q
    nodes = builder.joint_nodes[name]

    if joint.kind in POSES:
        _add_pose_start(builder, name, joint, nodes[0], q, v)
        return

    names = COORDINATES[joint.kind]

    if joint.kind == "screw":
        pitch = joint.pitch / (2 * np.pi)
        q, v = np.array([pitch * q[0], q[0]]), np.array([pitch * v[0], v[0]])

    for k, (i, (position, speed, unit)) in enumerate(zip(nodes, names)):
        builder.single["q_start"][builder.q[i]] = q[k]
        builder.single["v_start"][builder.v[i]] = v[k]
        same = [j for j, (other, _, _) in enumerate(names) if other == position]
        ending = f"[{same.index(k) + 1}]" if len(same) > 1 else ""

        if joint.driver or (joint.kind == "screw" and k == 0):
            continue

        for quantity, array, at, value, of_unit in (
            (position, "q_start", builder.q[i], q[k], unit),
            (speed, "v_start", builder.v[i], v[k], f"{unit}/s"),
        ):
            variable = dotted(name, f"{quantity}_start") + ending
            about = f"{quantity.replace('_', ' ')} of {name} at the start"
            builder.add_start(variable, array, at, value, of_unit, about, i)


def _add_pose_start(builder, name, joint, i, q, v):
    builder.single["q_start"][builder.q[i] : builder.q[i] + len(q)] = q
    builder.single["v_start"][builder.v[i] : builder.v[i] + len(v)] = v

    for array, at, values, quantities in zip(("q_start", "v_start"), (builder.q[i], builder.v[i]), (q, v), POSES[joint.kind]):
        for quantity, unit, size in quantities:
            about = f"{POSE_OUTPUTS[quantity][2].rstrip(',')} of {name} at the start"
            variable = dotted(name, f"{quantity}_start")
            builder.add_start(variable, array, at, values[:size], unit, about, i)

            if quantity == "euler_parameters":
                builder.add_zyx(dotted(name, "zyx_start"), name, i, values[:size])

            values = values[size:]
            at += size


TOLD = {
    "position": (notes.PLACE, notes.MARKER_PLACE),
    "orientation": (notes.ORIENTATION, notes.MARKER_ORIENTATION),
    "velocity": (notes.VELOCITY, notes.MARKER_VELOCITY),
    "omega": (notes.OMEGA, notes.MARKER_OMEGA),
}


def _tell_start(builder, name, joint):
    """What was given of the start, so that it can be told where it is not kept."""
    if joint.kind in POSES:
        _tell_pose(builder, name, joint)
        return

    names = COORDINATES.get(joint.kind, [])
    groups = ((0, joint.given_position(), joint.start_position()), (1, joint.given_velocity(), joint.start_velocity()))

    for which, written, values in groups:
        for k, ending in enumerate(written):
            if ending is None or (joint.kind == "screw" and k == 0):
                continue

            value = values[0 if joint.kind == "screw" else k]
            same = [j for j, other in enumerate(names) if other[which] == names[k][which]]
            quantity = names[k][which] + (f"[{same.index(k) + 1}]" if len(same) > 1 else "")
            place = _told_name(builder, quantity, name, ending)

            if name in builder.joint_nodes:
                kind, at = (notes.POSITION, notes.SPEED)[which], builder.joint_nodes[name][k]
            else:
                kind, at = (notes.COORDINATE, notes.RATE)[which], builder.coordinate(name, k)

            _add_told(builder, kind, at, 0, place, ENDINGS[ending], value)


def _tell_pose(builder, name, joint):
    """The same of a spherical or free joint."""
    in_tree = name in builder.joint_nodes
    ends = [builder.marker(end) for end in joint.between]
    q, v = joint.start_position(), joint.start_velocity()
    A = joint.start.rotation()

    for quantities, written, values in zip(POSES[joint.kind], (joint.given_position(), joint.given_velocity()), (q, v)):
        for k, ending in enumerate(written):
            turns = k >= len(written) - 3
            quantity = quantities[-1 if turns else 0][0].replace("euler_parameters", "orientation")

            # an orientation is told as a whole
            if ending is None or (quantity == "orientation" and k > len(written) - 3):
                continue

            kind = TOLD[quantity][not in_tree]
            value = values[-4:] if quantity == "orientation" else values[k]
            unit = ENDINGS["_deg"] if quantity == "orientation" else 1.0

            if quantity == "omega" and ending == "_body":
                value = A.inv().apply(v[-3:])[k % 3]
                kind = kind if in_tree else notes.MARKER_OMEGA_BODY

            text = quantity if quantity == "orientation" else f"{quantity}[{k % 3 + 1}]"
            place = _told_name(builder, text, name, "")
            at = builder.joint_nodes[name][0] if in_tree else ends[0]
            _add_told(builder, kind, at, k % 3, place, unit, value, -1 if in_tree else ends[1])


def _told_name(builder, quantity, joint, ending):
    """Index of what a message calls a start value."""
    unit = {"_deg": " in deg", "_rpm": " in rpm"}.get(ending, "")
    unit = " in deg/s" if ending == "_deg" and "speed" in quantity else unit
    return builder.name(f"the {quantity.replace('_', ' ')} of {joint}{unit}")


def _add_told(builder, kind, at, component, place, unit, value, to=-1):
    """One row of the start values that are told when they cannot be kept; `value`: SI, of an orientation E."""
    values = np.zeros(4)
    values[: np.size(value)] = value
    builder.tables["n_told"].add(
        told_kind=kind, told_at=at, told_to=to, told_component=component, told_place=place, told_unit=unit, told_value=values
    )


def _add_spring(builder, name, joint):
    """Spring and damper in a joint of one degree of freedom; returns their row."""
    unit = COORDINATES[joint.kind][0][2]
    effort = "N.m" if unit == "rad" else "N"
    linear = joint.spring and joint.spring.table is None
    stiffness = joint.spring.stiffness if linear else 0.0
    rest = joint.spring.rest_value() if linear else 0.0
    damping = joint.damper if isinstance(joint.damper, float) else 0.0
    table = damper_table = -1

    if joint.spring and not linear:
        table, rest = elastic_table(builder, joint.spring.table)

    if not isinstance(joint.damper, float):
        damper_table, _ = elastic_table(builder, joint.damper.table)

    row = builder.tables["n_joint_spring"].add(
        joint_spring_coordinate=builder.coordinate(name),
        joint_spring_table=table,
        joint_damper_table=damper_table,
        joint_stiffness=stiffness,
        joint_rest=rest,
        joint_damping=damping,
    )

    if linear:
        about = f"stiffness of {name}"
        builder.add_parameters(dotted(name, "stiffness"), "joint_stiffness", row, stiffness, f"{effort}/{unit}", about)
        about = f"position of {name} at which its spring is slack"
        builder.add_parameters(dotted(name, "rest"), "joint_rest", row, rest, unit, about)

    if damping:
        about = f"damping of {name}"
        builder.add_parameters(dotted(name, "damper"), "joint_damping", row, damping, f"{effort}.s/{unit}", about)

    return row


def _add_friction(builder, name, joint):
    """Dry friction in a joint of one degree of freedom; returns its row."""
    unit = COORDINATES[joint.kind][0][2]
    effort = "N.m" if unit == "rad" else "N"
    friction = joint.friction
    values = {
        "coulomb": (friction.coulomb, effort, "effort of sliding"),
        "static": (friction.static, effort, "effort of breaking loose"),
        "stribeck_speed": (friction.stribeck_speed, f"{unit}/s", "speed at which the one has become the other"),
        "viscous": (friction.viscous, f"{effort}.s/{unit}", "viscous part"),
        "smoothing_speed": (friction.smoothing_speed, f"{unit}/s", "speed below which it is smooth"),
    }
    row = builder.tables["n_friction"].add(
        friction_coordinate=builder.coordinate(name),
        **{f"friction_{key.removesuffix('_speed')}": value for key, (value, _, _) in values.items()},
    )

    for key, (value, unit, about) in values.items():
        array = f"friction_{key.removesuffix('_speed')}"
        builder.add_parameters(dotted(name, "friction", key), array, row, value, unit, f"friction of {name}: {about}")

    return row


def _add_stop(builder, name, joint):
    """Bump stops of a joint of one degree of freedom; returns their row."""
    unit = COORDINATES[joint.kind][0][2]
    effort = "N.m" if unit == "rad" else "N"
    stop = joint.stop
    in_degrees = any(key.endswith("_deg") for key in stop.model_fields_set)
    values = {
        "lower": (stop.lower_value(), unit, "lower end"),
        "upper": (stop.upper_value(), unit, "upper end"),
        "stiffness": (stop.stiffness, f"{effort}/{unit}", "stiffness"),
        "damping": (stop.damping, f"{effort}.s/{unit}", "damping while in touch"),
    }
    row = builder.tables["n_stop"].add(
        stop_coordinate=builder.coordinate(name),
        stop_place=builder.name(f"{name}{' (in deg)' if in_degrees else ''}"),
        stop_unit=ENDINGS["_deg"] if in_degrees else 1.0,
        **{f"stop_{key}": value for key, (value, _, _) in values.items()},
    )

    for key, (value, unit, about) in values.items():
        if np.isfinite(value):
            builder.add_parameters(dotted(name, "stop", key), f"stop_{key}", row, value, unit, f"stop of {name}: {about}")

    return row


def _add_inputs(builder, name, joint, parts):
    """Efforts that come from outside; the last one's row into `parts`. Returns the inputs' positions in u."""
    fed_by = []

    for quantity in [joint.input] if isinstance(joint.input, str) else joint.input or []:
        unit = "N.m" if quantity == "torque" else "N"
        about = f"{quantity} of {name} on its second marker"
        variable = dotted(name, quantity)

        if joint.kind == "spherical":
            first, second = map(builder.marker, joint.between)
            u = builder.add_inputs(variable, (3,), unit, f"{about}, in its first marker's axes", builder.nodes_of(name))
            builder.torque_inputs[name] = builder.tables["n_wrench_input"].add(
                wrench_marker=second, wrench_reaction=first, wrench_axes=first, wrench_force=-1, wrench_moment=u
            )
            continue

        u = builder.add_inputs(variable, (), unit, about, builder.nodes_of(name))
        along = "rad" if quantity == "torque" else "m"
        k = [coordinate[2] for coordinate in COORDINATES[joint.kind]].index(along)
        parts["input"] = builder.tables["n_effort_input"].add(effort_coordinate=builder.coordinate(name, k), effort_u=u)
        fed_by.append(u)

    return fed_by


def _add_outputs(builder, name, joint, parts, fed_by):
    nodes = builder.nodes_of(name)

    for output in joint.output:
        if output in ("s", "s_rate"):
            add_contact_outputs(builder, name, joint, output)
            continue

        if output.startswith("reaction"):
            kind, unit, about = REACTIONS[output.removesuffix("_body")]
            side = int(output.endswith("_body"))
            axes = ("its first marker's axes", "that marker's axes")[side]
            about = f"{about} that {name} passes on to its second marker, in {axes}"
            builder.add_outputs(dotted(name, output), kind, unit, about, nodes, builder.reaction(name), side)
            continue

        if output in EFFORTS:
            kind, part = EFFORTS[output]
            unit = "N.m" if joint.kind == "revolute" else "N"
            about = f"effort of the {part} of {name}, on its second marker"
            builder.add_outputs(
                dotted(name, output), kind, unit, about, nodes, parts[part], fed_by=fed_by if part == "input" else ()
            )
            continue

        if output == "power":
            kind = outputs.DRIVEN_JOINT_POWER if joint.driver else outputs.JOINT_POWER
            about = f"power with which all that acts in {name} works on the bodies"
            builder.add_outputs(dotted(name, output), kind, "W", about, nodes, builder.coordinate(name), fed_by=fed_by)
            continue

        if joint.kind in POSES:
            kind, unit, about = POSE_OUTPUTS[output]
            a, b = map(builder.marker, joint.between)
            about = f"{about} of {name}: second marker in the first"
            builder.add_outputs(dotted(name, output), kind, unit, about, nodes, a, b)
            continue

        _add_coordinate_outputs(builder, name, output, COORDINATES[joint.kind], nodes)


def _add_coordinate_outputs(builder, name, output, names, nodes):
    """One output of a joint of scalar coordinates."""
    found = []

    for k, (position, speed, unit) in enumerate(names):
        kinds = {
            position: (outputs.COORDINATE, unit),
            speed: (outputs.RATE, f"{unit}/s"),
            "acceleration": (outputs.ACCELERATION, f"{unit}/s2"),
            "effort": (outputs.DRIVE_EFFORT, "N.m" if unit == "rad" else "N"),
            "driver_effort": (outputs.DRIVE_EFFORT, "N.m" if unit == "rad" else "N"),
        }

        if output in kinds:
            found.append((k, *kinds[output]))

    for n, (k, kind, unit) in enumerate(found):
        ending = f"[{n + 1}]" if len(found) > 1 else ""
        about = f"{output.replace('_', ' ')} of {name}"
        builder.add_outputs(dotted(name, output) + ending, kind, unit, about, nodes, builder.coordinate(name, k))
