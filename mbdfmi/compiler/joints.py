"""Joints: start values, springs, inputs, outputs."""

import numpy as np

from ..kernels import outputs
from ..variables import dotted

# what the scalar coordinates of a joint are: names of a coordinate and its rate, its unit; several of one name are an array
COORDINATES = {
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
POSE_OUTPUTS = {
    "position": (outputs.POSITION, "m", "position"),
    "velocity": (outputs.VELOCITY, "m/s", "velocity"),
    "euler_parameters": (outputs.EULER_PARAMETERS, None, "Euler parameters, scalar last,"),
    "zyx": (outputs.ZYX, "rad", "yaw, pitch, roll"),
    "omega": (outputs.OMEGA, "rad/s", "angular velocity"),
    "alpha": (outputs.ALPHA, "rad/s2", "angular acceleration"),
}


def add_joints(builder):
    """Everything about joints but the constraints of those that close loops."""
    builder.single |= {"q_start": np.zeros(builder.n_q), "v_start": np.zeros(builder.n_v)}

    for name, joint in builder.scene.joint.items():
        if name in builder.joint_nodes:
            _add_start(builder, name, joint)

        if joint.spring or joint.damper:
            _add_spring(builder, name, joint)

        _add_inputs(builder, name, joint)
        _add_outputs(builder, name, joint)


def _add_start(builder, name, joint):
    """Start values as parameters; a screw's position follows from its angle."""
    q, v = joint.start_position(), joint.start_velocity()
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

        if joint.kind == "screw" and k == 0:
            continue

        for quantity, array, at, value, unit in (
            (position, "q_start", builder.q[i], q[k], unit),
            (speed, "v_start", builder.v[i], v[k], f"{unit}/s"),
        ):
            variable = dotted(name, f"{quantity}_start") + ending
            about = f"{quantity.replace('_', ' ')} of {name} at the start"
            builder.add_parameters(variable, array, at, value, unit, about, "fixed")


def _add_pose_start(builder, name, joint, i, q, v):
    builder.single["q_start"][builder.q[i] : builder.q[i] + len(q)] = q
    builder.single["v_start"][builder.v[i] : builder.v[i] + len(v)] = v

    for array, at, values, quantities in zip(("q_start", "v_start"), (builder.q[i], builder.v[i]), (q, v), POSES[joint.kind]):
        for quantity, unit, size in quantities:
            about = f"{POSE_OUTPUTS[quantity][2].rstrip(',')} of {name} at the start"
            variable = dotted(name, f"{quantity}_start")
            builder.add_parameters(variable, array, at, values[:size], unit, about, "fixed")
            values = values[size:]
            at += size


def _add_spring(builder, name, joint):
    """Spring and damper in a joint of one degree of freedom."""
    unit = COORDINATES[joint.kind][0][2]
    effort = "N.m" if unit == "rad" else "N"
    stiffness = joint.spring.stiffness if joint.spring else 0.0
    rest = joint.spring.rest_value() if joint.spring else 0.0
    row = builder.tables["n_joint_spring"].add(
        joint_spring_coordinate=builder.coordinate(name),
        joint_stiffness=stiffness,
        joint_rest=rest,
        joint_damping=joint.damper,
    )

    if joint.spring:
        about = f"stiffness of {name}"
        builder.add_parameters(dotted(name, "stiffness"), "joint_stiffness", row, stiffness, f"{effort}/{unit}", about)
        about = f"position of {name} at which its spring is slack"
        builder.add_parameters(dotted(name, "rest"), "joint_rest", row, rest, unit, about)

    if joint.damper:
        about = f"damping of {name}"
        builder.add_parameters(dotted(name, "damper"), "joint_damping", row, joint.damper, f"{effort}.s/{unit}", about)


def _add_inputs(builder, name, joint):
    """Efforts that come from outside."""
    for quantity in [joint.input] if isinstance(joint.input, str) else joint.input or []:
        unit = "N.m" if quantity == "torque" else "N"
        about = f"{quantity} of {name} on its second marker"
        variable = dotted(name, quantity)

        if joint.kind == "spherical":
            first, second = map(builder.marker, joint.between)
            u = builder.add_inputs(variable, (3,), unit, f"{about}, in its first marker's axes", builder.nodes_of(name))
            builder.tables["n_wrench_input"].add(
                wrench_marker=second, wrench_reaction=first, wrench_axes=first, wrench_force=-1, wrench_moment=u
            )
            continue

        u = builder.add_inputs(variable, (), unit, about, builder.nodes_of(name))
        along = "rad" if quantity == "torque" else "m"
        k = [coordinate[2] for coordinate in COORDINATES[joint.kind]].index(along)
        builder.tables["n_effort_input"].add(effort_coordinate=builder.coordinate(name, k), effort_u=u)


def _add_outputs(builder, name, joint):
    nodes = builder.nodes_of(name)

    for output in joint.output:
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
        }

        if output in kinds:
            found.append((k, *kinds[output]))

    for n, (k, kind, unit) in enumerate(found):
        ending = f"[{n + 1}]" if len(found) > 1 else ""
        about = f"{output.replace('_', ' ')} of {name}"
        builder.add_outputs(dotted(name, output) + ending, kind, unit, about, nodes, builder.coordinate(name, k))
