"""Joints: springs, friction, stops, inputs, outputs."""

import numpy as np

from ..kernels import outputs
from ..scene.starts import ENDINGS
from ..vocabulary import (
    CONTACT_OUTPUTS,
    EFFORT_OUTPUTS,
    END_FRAME_AXES,
    PARAMETER_EFFORTS,
    PARAMETERS,
    POSE_EFFORTS,
    POSE_OUTPUTS,
    REACTIONS,
    ROTATION_OUTPUTS,
)
from .bodies import MARKER_KINDS
from .builder import Place, Source
from .elastic import add_along, damper_of, spring_of
from .end_frames import add_axis_output, add_contact_output, add_parameter_effort, add_parameter_outputs
from .joint_kinds import kind_of, scalars, units_along
from .joint_starts import add_start, tell_start
from .variables import dotted, subscripts

# a joint is seen as its second marker from its first
POSE_KINDS = {word: MARKER_KINDS[word] for word in POSE_OUTPUTS | ROTATION_OUTPUTS}
REACTION_KINDS = {"reaction_force": outputs.REACTION_FORCE, "reaction_moment": outputs.REACTION_MOMENT}
EFFORT_KINDS = {
    "spring": outputs.SPRING_EFFORT,
    "damper": outputs.DAMPER_EFFORT,
    "friction": outputs.FRICTION_EFFORT,
    "stop": outputs.STOP_EFFORT,
    "input": outputs.INPUT_EFFORT,
}


def add_joints(builder):
    """Everything about joints but the constraints of those that close loops."""
    builder.single |= {"q_start": np.zeros(builder.n_q), "v_start": np.zeros(builder.n_v)}

    for name, joint in builder.scene.joint.items():
        if name in builder.joint_nodes:
            add_start(builder, name, joint)

        if not joint.driver:
            tell_start(builder, name, joint)

        if joint.turning:
            _add_rotor(builder, name, joint)

        parts = {}

        if joint.spring or joint.damper:
            parts["spring"] = parts["damper"] = _add_spring(builder, name, joint)

        if joint.friction:
            parts["friction"] = _add_friction(builder, name, joint)

        if joint.stop:
            parts["stop"] = _add_stop(builder, name, joint)

        fed_by = _add_inputs(builder, name, joint, parts)
        _add_outputs(builder, name, joint, parts, fed_by)


def _add_rotor(builder, name, joint):
    """A rotor that turns with a joint of one degree of freedom, which is in the tree (topology.spanning_tree)."""
    (node,) = builder.joint_nodes[name]
    inertia, ratio = joint.turning.inertia, joint.turning.ratio
    row = builder.tables["n_rotor"].add(rotor_body=node, rotor_inertia=inertia, rotor_ratio=ratio)
    builder.tables["n_body"].columns["body_rotor"][node][0] = row
    unit = None if units_along(joint)[0] == "rad" else "rad/m"
    about = f"inertia of the rotor that turns with {name}"
    builder.add_parameters(
        dotted(name, "turning", "inertia"), Place("rotor_inertia", row), inertia, "kg.m2", about
    )
    about = f"speed of the rotor that turns with {name}, by the joint's"
    builder.add_parameters(dotted(name, "turning", "ratio"), Place("rotor_ratio", row), ratio, unit, about)


def _add_spring(builder, name, joint):
    """Spring and damper in a joint of one degree of freedom; returns their row."""
    spring = None

    if joint.spring:
        spring = spring_of(builder, joint.spring.table, joint.spring.stiffness, joint.spring.rest_value())

    damper = damper_of(builder, joint.damper)
    return add_along(builder, name, builder.coordinate(name), spring, damper, units_along(joint), "damper")


def _add_friction(builder, name, joint):
    """Dry friction in a joint of one degree of freedom; returns its row."""
    unit, effort = units_along(joint)
    friction = joint.friction
    values = {
        "coulomb": (friction.coulomb, effort, "effort of sliding"),
        "static": (friction.static, effort, "effort of breaking loose"),
        "stribeck_speed": (
            friction.stribeck_speed,
            f"{unit}/s",
            "speed at which the one has become the other",
        ),
        "viscous": (friction.viscous, f"{effort}.s/{unit}", "viscous part"),
        "smoothing_speed": (friction.smoothing_speed, f"{unit}/s", "speed below which it is smooth"),
    }
    row = builder.tables["n_friction"].add(
        friction_coordinate=builder.coordinate(name),
        **{f"friction_{key.removesuffix('_speed')}": value for key, (value, _, _) in values.items()},
    )

    for key, (value, unit, about) in values.items():
        array = f"friction_{key.removesuffix('_speed')}"
        builder.add_parameters(
            dotted(name, "friction", key), Place(array, row), value, unit, f"friction of {name}: {about}"
        )

    return row


def _add_stop(builder, name, joint):
    """Bump stops of a joint of one degree of freedom; returns their row."""
    unit, effort = units_along(joint)
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
        stop_place=builder.add_name(f"{name}{' (in deg)' if in_degrees else ''}"),
        stop_unit=ENDINGS["_deg"] if in_degrees else 1.0,
        **{f"stop_{key}": value for key, (value, _, _) in values.items()},
    )

    for key, (value, unit, about) in values.items():
        if np.isfinite(value):
            builder.add_parameters(
                dotted(name, "stop", key), Place(f"stop_{key}", row), value, unit, f"stop of {name}: {about}"
            )

    return row


def _add_inputs(builder, name, joint, parts):
    """Efforts that come from outside; the last one's row into `parts`. Returns the inputs' positions in u."""
    fed_by = []

    efforts = {coordinate.effort.name: coordinate.effort for coordinate in joint.coordinates}

    for effort in (efforts[quantity] for quantity in joint.input):
        about = f"{effort.name} of {name} on its second marker"
        variable = dotted(name, effort.name)
        nodes = builder.nodes_of(name)

        if kind_of(joint).is_pose:
            first, second = map(builder.marker, joint.between)
            u = builder.add_inputs(variable, effort, f"{about}, in its first marker's axes", nodes)
            builder.torque_inputs[name] = builder.tables["n_wrench_input"].add(
                wrench_marker=second,
                wrench_reaction=first,
                wrench_axes=first,
                wrench_force=-1,
                wrench_moment=u,
            )
            continue

        u = builder.add_inputs(variable, effort, about, nodes)
        along = [k for k, scalar in enumerate(scalars(joint)) if scalar.coordinate.effort == effort]

        for i, k in enumerate(along):
            parts["input"] = builder.tables["n_effort_input"].add(
                effort_coordinate=builder.coordinate(name, k), effort_u=u + i
            )
            fed_by.append(u + i)

    return fed_by


def _add_outputs(builder, name, joint, parts, fed_by):
    """All that goes out of a joint; `parts`: rows of what acts in it, `fed_by`: positions in u of its inputs."""
    for output in joint.output:
        if output in PARAMETERS:
            add_parameter_outputs(builder, name, joint, output)
        elif name in builder.end_frames and output in PARAMETER_EFFORTS:
            add_parameter_effort(builder, name, joint, output)
        elif output in END_FRAME_AXES:
            add_axis_output(builder, name, output)
        elif output in CONTACT_OUTPUTS:
            add_contact_output(builder, name, output)
        elif output in REACTIONS:
            add_reaction(builder, name, REACTIONS[output])
        elif EFFORT_OUTPUTS.get(output) in EFFORT_KINDS:
            _add_effort(builder, name, joint, output, parts, fed_by)
        elif output == "power":
            kind = outputs.DRIVEN_JOINT_POWER if joint.driver else outputs.JOINT_POWER
            about = f"power with which all that acts in {name} works on the bodies"
            source = Source(kind, builder.coordinate(name))
            builder.add_outputs(dotted(name, output), source, "W", about, builder.nodes_of(name), fed_by)
        elif output in POSE_EFFORTS:
            add_pose_efforts(builder, name, output)
        elif kind_of(joint).is_pose or joint.kind == "prescribed":
            add_pose_output(builder, name, joint, output)
        else:
            add_coordinate_outputs(builder, name, joint, output)


def add_reaction(builder, name, reaction):
    """What a joint passes on to its second marker."""
    side = int(reaction.name.endswith("_body"))
    axes = ("its first marker's axes", "that marker's axes")[side]
    about = f"{reaction.text} that {name} passes on to its second marker, in {axes}"
    source = Source(REACTION_KINDS[reaction.name.removesuffix("_body")], builder.reaction(name), side)
    builder.add_outputs(dotted(name, reaction.name), source, reaction.unit, about, builder.nodes_of(name))


def _add_effort(builder, name, joint, output, parts, fed_by):
    """What a spring, a damper, friction, a stop or an input exerts along the joint."""
    part = EFFORT_OUTPUTS[output]
    _, unit = units_along(joint)
    about = f"effort of the {part} of {name}, on its second marker"
    fed_by = fed_by if part == "input" else ()
    source = Source(EFFORT_KINDS[part], parts[part])
    builder.add_outputs(dotted(name, output), source, unit, about, builder.nodes_of(name), fed_by)


def add_pose_output(builder, name, joint, output):
    """How the second marker of a joint is, or moves, in the first."""
    quantity = (POSE_OUTPUTS | ROTATION_OUTPUTS)[output]
    source = Source(POSE_KINDS[output], *map(builder.marker, joint.between))
    about = f"{quantity.text} of {name}: second marker in the first"
    builder.add_outputs(dotted(name, output), source, quantity.unit, about, builder.nodes_of(name))


def add_pose_efforts(builder, name, output):
    """What drives a prescribed joint, along its coordinates."""
    quantity = POSE_EFFORTS[output]
    first = 3 * list(POSE_EFFORTS).index(output)

    for k, ending in enumerate(subscripts(quantity.shape)):
        source = Source(outputs.DRIVE_EFFORT, builder.coordinate(name, first + k))
        about = f"{quantity.text} of {name}"
        builder.add_outputs(
            dotted(name, output) + ending, source, quantity.unit, about, builder.nodes_of(name)
        )


def add_coordinate_outputs(builder, name, joint, output):
    """One output of a joint of scalar coordinates."""
    for k, (coordinate, ending) in enumerate(scalars(joint)):
        position, rate, effort = coordinate
        kinds = {
            position.name: (outputs.COORDINATE, position.unit),
            rate.name: (outputs.RATE, rate.unit),
            "acceleration": (outputs.ACCELERATION, f"{position.unit}/s2"),
            "effort": (outputs.DRIVE_EFFORT, effort.unit),
            "driver_effort": (outputs.DRIVE_EFFORT, effort.unit),
        }

        if output in kinds:
            kind, unit = kinds[output]
            about = f"{output.replace('_', ' ')} of {name}"
            source = Source(kind, builder.coordinate(name, k))
            builder.add_outputs(dotted(name, output) + ending, source, unit, about, builder.nodes_of(name))
