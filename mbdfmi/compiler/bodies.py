"""Settings, nodes, solids, and what goes in and out at markers."""

import numpy as np

from ..kernels import outputs
from ..kernels.joints import KINDS
from ..variables import dotted

MARKER_OUTPUTS = {
    # name: (kind, unit, what a description calls it)
    "position": (outputs.POSITION, "m", "position in the inertial frame"),
    "velocity": (outputs.VELOCITY, "m/s", "velocity in the inertial frame"),
    "euler_parameters": (outputs.EULER_PARAMETERS, None, "Euler parameters in the inertial frame, scalar last"),
    "zyx": (outputs.ZYX, "rad", "yaw, pitch, roll in the inertial frame"),
    "omega": (outputs.OMEGA, "rad/s", "angular velocity in the inertial frame"),
    "velocity_body": (outputs.VELOCITY_BODY, "m/s", "velocity in its own axes"),
    "omega_body": (outputs.OMEGA_BODY, "rad/s", "angular velocity in its own axes"),
}
SCENE_OUTPUTS = {
    "kinetic_energy": (outputs.KINETIC_ENERGY, "J", "kinetic energy"),
    "potential_energy": (outputs.POTENTIAL_ENERGY, "J", "potential energy of weight, springs and preloads"),
    "total_energy": (outputs.TOTAL_ENERGY, "J", "kinetic and potential energy"),
}


def add_settings(builder):
    """Gravity and the solver's settings."""
    solver = builder.scene.solver
    fixed_step = solver.integrator == "rk4"
    builder.single |= {
        "gravity": builder.scene.gravity,
        "step": solver.step if fixed_step else 1.0,
        "tolerance": solver.tolerance,
        "absolute_tolerance": solver.absolute_tolerance,
        "max_step": solver.max_step or 1e30,
    }
    builder.add_parameters("gravity", "gravity", 0, builder.scene.gravity, "m/s2", "gravity in the inertial frame")

    if fixed_step:
        builder.add_parameters("solver.step", "step", 0, solver.step, "s", "largest inner step")
        return

    for name in ("tolerance", "absolute_tolerance"):
        about = f"adaptive step: largest local error, {'absolute' if name.startswith('abs') else 'relative'}"
        builder.add_parameters(f"solver.{name}", name, 0, getattr(solver, name), None, about)


def add_bodies(builder):
    """Nodes and the solids in them."""
    for i, node in enumerate(builder.nodes):
        r, A = node.joint_frame
        builder.tables["n_body"].add(
            body_parent=node.parent,
            body_joint=KINDS[node.kind] if i else -1,
            body_q=builder.q[i],
            body_v=builder.v[i],
            body_reversed=node.reversed,
            body_given=_given(builder, node),
            body_drive=-1,
            body_r=r,
            body_A=A,
        )

    for name, body in builder.scene.body.items():
        mass, com, inertia = body.mass_properties()
        inertia = inertia[[0, 1, 2, 0, 0, 1], [0, 1, 2, 1, 2, 2]]
        node, (r, A) = builder.tree.home[name]
        row = builder.tables["n_solid"].add(
            solid_body=node, solid_mass=mass, solid_com=com, solid_inertia=inertia, solid_r=r, solid_A=A
        )
        builder.add_parameters(dotted(name, "mass"), "solid_mass", row, mass, "kg", f"mass of {name}")
        about = f"centre of mass of {name}, in its own frame"
        builder.add_parameters(dotted(name, "com"), "solid_com", row, com, "m", about)
        about = f"inertia of {name} about its centre of mass, in its own axes: xx, yy, zz, xy, xz, yz"
        builder.add_parameters(dotted(name, "inertia"), "solid_inertia", row, inertia, "kg.m2", about)


def _given(builder, node):
    """1 where the user gave a start position of the node's joint, 2 a velocity, 3 both."""
    if not node.joint:
        return 0

    joint = builder.scene.joint[node.joint]
    return int(joint.holds_position) + 2 * int(joint.holds_velocity)


def add_markers(builder):
    """Inputs and outputs of bodies and their markers."""
    for body_name, body in builder.scene.body.items():
        _add_marker(builder, (body_name,), body)

        for marker_name, marker in body.marker.items():
            _add_marker(builder, (body_name, marker_name), marker)


def _add_marker(builder, path, spec):
    """Inputs and outputs of one marker; a body's own frame is one too."""
    if not (spec.input or spec.output):
        return

    name = ".".join(path)
    index = builder.marker(name)
    node = builder.node_of(name)
    first = {"force": -1, "moment": -1}

    for quantity in spec.input:
        unit = "N" if quantity == "force" else "N.m"
        axes = "its own" if spec.input_axes == "body" else "inertial"
        about = f"{quantity} on {name}, in {axes} axes"
        first[quantity] = builder.add_inputs(dotted(*path, quantity), (3,), unit, about, [node])

    if spec.input:
        builder.tables["n_wrench_input"].add(
            wrench_marker=index,
            wrench_reaction=-1,
            wrench_axes=index if spec.input_axes == "body" else -1,
            wrench_force=first["force"],
            wrench_moment=first["moment"],
        )

    for output in spec.output:
        kind, unit, about = MARKER_OUTPUTS[output]
        builder.add_outputs(dotted(*path, output), kind, unit, f"{about} of {name}", [node], 0, index)


def add_scene_outputs(builder):
    """Outputs of the whole scene."""
    for output in builder.scene.output:
        kind, unit, about = SCENE_OUTPUTS[output]
        builder.add_outputs(output, kind, unit, about, np.arange(len(builder.nodes)).tolist())
