"""Settings, nodes, solids, and what goes in and out at markers."""

import numpy as np

from ..kernels import outputs
from ..kernels.dynamics import rows
from ..kernels.joints import KINDS, N_V
from ..vocabulary import (
    GROUND_OUTPUTS,
    MARKER_INPUTS,
    MARKER_OUTPUTS,
    MEASURES,
    SCENE_OUTPUTS,
    SOLVER_OUTPUTS,
)
from .builder import Place, Source
from .variables import dotted

# words of the scene -> kinds of kernels/outputs.py
MARKER_KINDS = {
    "position": outputs.POSITION,
    "velocity": outputs.VELOCITY,
    "euler_parameters": outputs.EULER_PARAMETERS,
    "zyx": outputs.ZYX,
    "zyx_rate": outputs.ZYX_RATE,
    "omega": outputs.OMEGA,
    "acceleration": outputs.LINEAR_ACCELERATION,
    "alpha": outputs.ALPHA,
    "velocity_body": outputs.VELOCITY_BODY,
    "omega_body": outputs.OMEGA_BODY,
    "acceleration_body": outputs.LINEAR_ACCELERATION_BODY,
    "alpha_body": outputs.ALPHA_BODY,
    "elevation": outputs.ELEVATION,
}
MEASURE_KINDS = {
    "distance": outputs.DISTANCE,
    "distance_rate": outputs.DISTANCE_RATE,
    "angle": outputs.Z_ANGLE,
    "position": outputs.POSITION,
    "velocity": outputs.VELOCITY,
    "acceleration": outputs.LINEAR_ACCELERATION,
    "euler_parameters": outputs.EULER_PARAMETERS,
    "zyx": outputs.ZYX,
    "zyx_rate": outputs.ZYX_RATE,
    "omega": outputs.OMEGA,
}
GROUND_KINDS = {
    "reaction_force": outputs.GROUND_FORCE,
    "reaction_moment": outputs.GROUND_MOMENT,
}
SCENE_KINDS = {
    "kinetic_energy": outputs.KINETIC_ENERGY,
    "potential_energy": outputs.POTENTIAL_ENERGY,
    "total_energy": outputs.TOTAL_ENERGY,
    "gravity_energy": outputs.GRAVITY_ENERGY,
    "spring_energy": outputs.SPRING_ENERGY,
    "linear_momentum": outputs.LINEAR_MOMENTUM,
    "angular_momentum": outputs.ANGULAR_MOMENTUM,
    "center_of_mass": outputs.CENTER_OF_MASS,
    "input_power": outputs.INPUTS_POWER,
    "load_power": outputs.LOADS_POWER,
    "driver_power": outputs.DRIVES_POWER,
    "dissipated_power": outputs.DISSIPATED_POWER,
    "constraint_gap": outputs.CONSTRAINT_GAP,
    "constraint_rate": outputs.CONSTRAINT_RATE,
}
SOLVER_KINDS = {
    "steps": outputs.STEPS,
    "rejected_steps": outputs.REJECTED_STEPS,
    "evaluations": outputs.EVALUATIONS,
    "estimated_error": outputs.ESTIMATED_ERROR,
}


def add_settings(builder):
    """Gravity, the solver's settings and outputs."""
    solver = builder.scene.solver
    builder.single |= {
        "gravity": builder.scene.gravity,
        "step": solver.step if solver.fixed_step else 1.0,
        "tolerance": solver.tolerance,
        "absolute_tolerance": solver.absolute_tolerance,
        "max_step": solver.max_step or 1e30,
        "closing_tolerance": solver.closing_tolerance,
    }

    if central := builder.scene.central_gravity:
        builder.tables["n_central"].add(central_mu=central.mu, central_gradient=central.gradient)
        about = "weight -mu r / |r|^3 per mass, r from the inertial origin"
        builder.add_parameters("central_gravity.mu", Place("central_mu"), central.mu, "m3/s2", about)
    else:
        builder.add_parameters(
            "gravity", Place("gravity"), builder.scene.gravity, "m/s2", "gravity in the inertial frame"
        )

    for name in solver.output:
        quantity = SOLVER_OUTPUTS[name]
        builder.add_outputs(f"solver.{name}", Source(SOLVER_KINDS[name]), quantity.unit, quantity.text, ())

    if solver.fixed_step:
        builder.add_parameters("solver.step", Place("step"), solver.step, "s", "largest inner step")
        return

    for name in ("tolerance", "absolute_tolerance"):
        about = f"adaptive step: largest local error, {'absolute' if name.startswith('abs') else 'relative'}"
        builder.add_parameters(f"solver.{name}", Place(name), getattr(solver, name), None, about)


# s, that a communication step should cost at most, estimated generously
LONGEST_STEP = 6.0


def evaluation_cost(builder, counts):
    """About what an evaluation costs (s), generously."""
    rows = counts.get("n_row", 0)
    cost = 3e-7 + 2e-7 * counts["n_body"] + 3e-7 * rows + 1e-6 * counts.get("n_end_frame", 0)
    cost += 1e-9 * counts.get("n_factor", 0) ** 2 / max(1, rows)
    return cost + (2e-10 * counts["n_v"] ** 3 if builder.embeds else 0.0)


def add_work_limit(builder, counts):
    """How many evaluations a communication step may cost: the user's number, else from about what one costs."""
    cost = evaluation_cost(builder, counts)
    most = builder.scene.solver.max_evaluations or float(f"{LONGEST_STEP / cost:.1e}")
    builder.single["max_evaluations"] = most
    about = "largest work of a communication step, in evaluations of the accelerations"
    builder.add_parameters("solver.max_evaluations", Place("max_evaluations"), most, None, about)


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
            body_spins=_spins(builder, node),
            body_drive=builder.drive_of.get(i, -1),
            body_rotor=-1,
            body_r=r,
            body_A=A,
            zyx_start=np.zeros(3),
            zyx_told=np.zeros(3),
        )

    builder.single["v_given"] = given_coordinates(builder)

    for name, body in builder.scene.body.items():
        mass, com, inertia = body.mass_properties()
        inertia = inertia[[0, 1, 2, 0, 0, 1], [0, 1, 2, 1, 2, 2]]
        node, (r, A) = builder.tree.home[name]
        row = builder.tables["n_solid"].add(
            solid_body=node, solid_mass=mass, solid_com=com, solid_inertia=inertia, solid_r=r, solid_A=A
        )
        builder.add_parameters(dotted(name, "mass"), Place("solid_mass", row), mass, "kg", f"mass of {name}")
        about = f"centre of mass of {name}, in its own frame"
        builder.add_parameters(dotted(name, "com"), Place("solid_com", row), com, "m", about)
        about = f"inertia of {name} about its centre of mass, in its own axes: xx, yy, zz, xy, xz, yz"
        builder.add_parameters(dotted(name, "inertia"), Place("solid_inertia", row), inertia, "kg.m2", about)


def _spins(builder, node):
    """Whether the start of the node's joint tells its angular velocity in the second marker's axes."""
    return int(bool(node.joint) and "_body" in builder.scene.joint[node.joint].given_velocity())


def given_coordinates(builder):
    """For each velocity coordinate 1 where the user gave its start position, 2 its start velocity, 3 both, else 0."""
    given = np.zeros(builder.n_v)

    for i, node in enumerate(builder.nodes):
        if not node.joint or i in builder.drive_of:
            continue

        joint = builder.scene.joint[node.joint]
        n = N_V[KINDS[node.kind]]

        for weight, written in ((1, joint.given_position()), (2, joint.given_velocity())):
            for k in range(n):
                given[builder.v[i] + k] += weight * (written[node.coordinate + k] is not None)

    return given


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

    for quantity in (MARKER_INPUTS[given] for given in spec.input):
        axes = "its own" if spec.input_axes == "body" else "inertial"
        about = f"{quantity.text} on {name}, in {axes} axes"
        variable = dotted(*path, quantity.name)
        first[quantity.name] = builder.add_inputs(variable, quantity, about, [node])

    if spec.input:
        builder.tables["n_wrench_input"].add(
            wrench_marker=index,
            wrench_reaction=-1,
            wrench_axes=index if spec.input_axes == "body" else -1,
            wrench_force=first["force"],
            wrench_moment=first["moment"],
        )

    for output in spec.output:
        quantity = MARKER_OUTPUTS[output]
        source = Source(MARKER_KINDS[output], 0, index)

        if output == "elevation":
            from .seas import add_waves

            add_waves(builder)

        builder.add_outputs(
            dotted(*path, output), source, quantity.unit, f"{quantity.text} of {name}", [node]
        )


def add_measures(builder):
    """What is seen of one marker from another."""
    for name, measure in builder.scene.measure.items():
        a, b = map(builder.marker, measure.between)
        nodes = [builder.node_of(end) for end in measure.between]

        for output in measure.output:
            quantity = MEASURES[output]
            about = f"{quantity.text} of {name}: {measure.between[1]} in {measure.between[0]}"
            builder.add_outputs(
                dotted(name, output), Source(MEASURE_KINDS[output], a, b), quantity.unit, about, nodes
            )


# sums that buoyancy is part of where there is any
OF_WATER = ("potential_energy", "spring_energy")


def add_scene_outputs(builder):
    """Outputs of the whole scene."""
    for output in builder.scene.output:
        if output == "multipliers":
            _add_multipliers(builder)
            continue

        quantity = SCENE_OUTPUTS[output]
        nodes = range(len(builder.nodes))
        fed_by = ()

        if output == "driver_power":
            nodes = [
                *builder.drive_of,
                *(i for joint in builder.driven_cuts for i in builder.nodes_of(joint)),
            ]

            if builder.tree.home["ground"][0] in builder.drive_of:
                felt, fed_by = _on_ground(builder)
                nodes += felt
        elif output == "input_power":
            blown = _blown(builder)
            fed_by = [k for k, given in enumerate(builder.inputs) if not given.moves and k not in blown]
        elif output == "load_power":
            fed_by = sorted(_blown(builder))

        text = quantity.text

        if output in OF_WATER:
            parts = {"buoyancy": "n_hull", "lines": "n_line"}
            text += "".join(f" and {part}" for part, count in parts.items() if builder.tables[count].length)

        builder.add_outputs(output, Source(SCENE_KINDS[output]), quantity.unit, text, nodes, fed_by)


def add_ground_outputs(builder):
    """What the ground bears."""
    for output in builder.scene.ground.output:
        quantity = GROUND_OUTPUTS[output]
        about = f"{quantity.text} with which all joints and forces act on the ground, in its axes"
        nodes, fed_by = _on_ground(builder)
        source = Source(GROUND_KINDS[output], builder.tree.home["ground"][0])
        pull = [i for group in builder.force_nodes if 0 in group for i in group]
        builder.add_outputs(dotted("ground", output), source, quantity.unit, about, nodes, fed_by, pull)


def _on_ground(builder):
    """Nodes whose accelerations the ground feels, and positions in u of inputs that it feels itself."""
    ground = builder.tree.home["ground"][0]
    fed_by = []

    if ground > 0:
        nodes = [ground]
    else:
        nodes = [i for i, node in enumerate(builder.nodes) if node.parent == 0 and node.kind != "free"]
        nodes += [i for group in builder.constraint_nodes if 0 in group for i in group]

        for u, *pair in _columns(builder, "n_strut", "strut_u", "strut_from", "strut_to"):
            if u >= 0 and 0 in map(builder.marker_node, pair):
                fed_by.append(u)

    fed_by += sorted(_blown(builder, ground))

    # the water of added mass is part of the ground
    for adds, first, second in _columns(
        builder, "n_six_by_six", "six_by_six_adds", "six_by_six_from", "six_by_six_to"
    ):
        if adds and builder.marker_node(first) == ground:
            nodes.append(builder.marker_node(second))

    return nodes, fed_by


def _blown(builder, node=None):
    """Positions in u of the inputs that tell wind and blades of rotors: of all, or of those on a node."""
    found = set()

    for u, marker in _columns(builder, "n_wind_rotor", "wind_rotor_u", "wind_rotor_marker"):
        if node is None or builder.marker_node(marker) == node:
            found.add(u)
            found.update(
                first + k
                for (first,) in _columns(builder, "n_wind", "wind_u")
                if first >= 0
                for k in range(3)
            )

    return found - {-1}


def _columns(builder, count, *names):
    """Rows of some columns of whole numbers of a table."""
    columns = builder.tables[count].columns
    return zip(*([int(value[0]) for value in columns.get(name, ())] for name in names))


def _add_multipliers(builder):
    """The multiplier of every row."""
    columns = builder.tables["n_row"].columns

    for row in range(builder.tables["n_row"].length):
        c, kind = int(columns["row_constraint"][row][0]), int(columns["row_kind"][row][0])
        unit = {rows.DOT: "N.m", rows.TWIST: "N.m", rows.FRAME: "N.m", rows.COUPLING: None}.get(kind, "N")
        about = f"{SCENE_OUTPUTS['multipliers'].text} of {builder.constraint_names[c]}"
        source = Source(outputs.MULTIPLIER, row)
        builder.add_outputs(f"multipliers[{row + 1}]", source, unit, about, builder.constraint_nodes[c])
