"""Prescribed motion of joints and of the ground; couplings between joints."""

import numpy as np

from ..kernels import outputs
from ..kernels.dynamics import rows
from ..kernels.motion import courses, drives
from ..vocabulary import COUPLING_OUTPUTS, GROUND_INPUTS
from .builder import Constraint, Source
from .joint_kinds import kind_of, units_along
from .variables import dotted

GROUND_PLACE = ("position", "velocity", "acceleration")
GROUND_TURN = ("omega", "alpha")

# by what tells the orientation, and whether the angular velocity is told
TURNS = {
    ("euler_parameters", False): courses.TURN_E,
    ("zyx", False): courses.TURN_ZYX,
    ("euler_parameters", True): courses.TURN_E_OMEGA,
    ("zyx", True): courses.TURN_ZYX_OMEGA,
}


def add_drives(builder):
    """Drives of the ground and of joints. Those of joints in the tree hold their nodes; the others wait in
    builder.driven_cuts: joint -> drive, to become constraints."""
    motion = builder.scene.ground.motion

    if motion is not None:
        node = builder.tree.home["ground"][0]
        builder.drive_of[node] = _add_ground(builder, motion, node)

    for name, joint in builder.scene.joint.items():
        if joint.driver is None:
            continue

        in_tree = name in builder.joint_nodes
        node = builder.joint_nodes[name][0] if in_tree else -1
        drive = _add_joint_drive(builder, name, joint, node)

        if in_tree:
            builder.drive_of[node] = drive
        else:
            builder.driven_cuts[name] = drive


def _add(builder, kind, node, value=(), at=0, terms=0, channels=(), turn=(courses.TURN_NONE, 0)):
    """A row of the table of drives; `channels`: inputs that tell position, speed, acceleration of each, and whether an angle."""
    values = np.zeros(16)
    values[: len(value)] = value
    rows = [builder.tables["n_command"].add(command_u=u, command_angular=int(angular)) for u, angular in channels]
    return builder.tables["n_drive"].add(
        drive_kind=kind, drive_body=node, drive_at=at, drive_terms=terms, drive_value=values, drive_turn=turn,
        drive_command=rows[0] if rows else -1, drive_commands=len(rows),
    )


def _belonging(names, quantity, missing):
    """Which inputs are set together with one of them, for its description."""
    others = " and ".join(name for name in names if name != quantity)
    text = f"; to be set together with {others}" if others else ""
    return text + (f"; {' and '.join(missing)} found from the last commands" if missing else "")


def _add_joint_drive(builder, name, joint, node):
    driver = joint.driver
    ((position, rate, _),) = joint.coordinates
    unit = position.unit

    if driver.kind == "constant_speed":
        start = joint.start_position()[0]
        drive = _add(builder, drives.CONSTANT_SPEED, node, (start, driver.speed()))
        about = f"prescribed speed of {name}"
        builder.add_parameters(
            dotted(name, "speed_driven"), "drive_value", drive, driver.speed(), f"{unit}/s", about, offset=1
        )
        return drive

    if driver.kind == "hold":
        return _add(builder, drives.CONSTANT_SPEED, node, (joint.start_position()[0], 0.0))

    if driver.kind in ("harmonic", "harmonics"):
        return _add_waves(builder, name, getattr(driver, driver.kind), node, unit)

    if driver.kind == "polynomial":
        value = driver.polynomial.values()
        drive = _add(builder, drives.POLYNOMIAL, node, value, terms=len(value))
        units = ([unit, f"{unit}/s", f"{unit}/s2"] + [None] * 16)[: len(value)]
        about = f"coefficients of the powers of time of {name}, SI"
        builder.add_parameters(dotted(name, "driver", "coefficients"), "drive_value", drive, value, units, about, "fixed")
        return drive

    if driver.kind == "ramp":
        value = driver.ramp.values()
        drive = _add(builder, drives.RAMP, node, value)

        for k, end in enumerate(("begin", "end")):
            for offset, quantity, of in ((2 * k, "time", "s"), (2 * k + 1, position.name, unit)):
                about = f"{quantity} of {name} at the {'beginning' if k == 0 else 'end'} of its ramp"
                variable = dotted(name, "driver", f"{quantity}_{end}")
                builder.add_parameters(variable, "drive_value", drive, value[offset], of, about, "fixed", offset)

        return drive

    if driver.kind == "table":
        table = builder.tables_over_time(driver.table.interpolation, *driver.table.points())
        return _add(builder, drives.TABLE, node, at=table)

    if driver.kind == "speed_table":
        table = builder.tables_over_time(driver.speed_table.interpolation, *driver.speed_table.points())
        return _add(builder, drives.SPEED_TABLE, node, (joint.start_position()[0],), at=table)

    told = len(driver.commands())
    quantities = (position.name, rate.name, "acceleration")
    names = {quantity: dotted(name, f"{quantity}_command") for quantity in quantities[:told]}
    starts = (joint.start_position, joint.start_velocity, lambda: [0.0])
    inputs = [-1, -1, -1]

    for k, (quantity, variable) in enumerate(names.items()):
        about = f"{quantity} that {name} is driven to" + _belonging(names.values(), variable, quantities[told:])
        value = float(starts[k]()[0])
        inputs[k] = builder.add_inputs(
            variable, (), unit + ("", "/s", "/s2")[k], about, builder.nodes_of(name), moves=True, start=value
        )

    return _add(builder, drives.INPUT, node, channels=[(inputs, unit == "rad")])


def _add_waves(builder, name, harmonics, node, unit):
    """The drive of a joint by one harmonic or by their sum."""
    waves, mean = harmonics.waves(), harmonics.mean_value()
    first = [builder.tables["n_wave"].add(wave_value=wave) for wave in waves][0]
    drive = _add(builder, drives.HARMONIC, node, (mean,), at=first, terms=len(waves))
    about = f"mean of the motion of {name}"
    builder.add_parameters(dotted(name, "driver", "mean"), "drive_value", drive, mean, unit, about, "fixed")

    for k, wave in enumerate(waves):
        ending = f"[{k + 1}]" if np.ndim(harmonics.frequency) else ""

        for offset, (quantity, of) in enumerate((("amplitude", unit), ("frequency", "Hz"), ("phase", "rad"))):
            about = f"{quantity} of the motion of {name}"
            variable = dotted(name, "driver", quantity) + ending
            builder.add_parameters(variable, "wave_value", first + k, wave[offset], of, about, "fixed", offset)

    return drive


def _add_ground(builder, motion, node):
    if motion.kind == "acceleration":
        value = [*motion.position, *motion.velocity, *motion.acceleration]
        return _add(builder, drives.GROUND_ACCELERATION, node, value)

    if motion.kind == "rotation":
        turn = motion.rotation
        value = [*turn.direction(), *turn.point, turn.speed_value(), turn.angle_value()]
        return _add(builder, drives.GROUND_ROTATION, node, value)

    if motion.kind == "orbit":
        orbit = motion.orbit
        value = [*orbit.axes().ravel(), orbit.radius, orbit.rate, orbit.phase_value(), float(orbit.pointing)]
        return _add(builder, drives.GROUND_ORBIT, node, value)

    if motion.kind == "table":
        time, position, E = motion.table.points()
        table = builder.tables_over_time(motion.table.interpolation, time, np.hstack([position, E]))
        return _add(builder, drives.GROUND_TABLE, node, at=table)

    return _add_ground_inputs(builder, motion.commands(), node)


def _add_ground_inputs(builder, told, node):
    """The drive of a ground that inputs command; `told`: what they tell of its motion."""
    of_place, of_turn = (
        [quantity for quantity in GROUND_INPUTS if (quantity in GROUND_PLACE) == place] for place in (True, False)
    )
    first = {}

    for quantity in told:
        told_of = GROUND_INPUTS[quantity]
        group = [q for q in (of_place if quantity in of_place else of_turn) if q in told]
        chain = GROUND_PLACE if quantity in of_place else GROUND_TURN
        missing = [GROUND_INPUTS[q].text for q in chain if q not in told]
        names = [dotted("ground", q) for q in group]
        variable = dotted("ground", quantity)
        about = f"{told_of.text} of the ground in the inertial frame" + _belonging(names, variable, missing)
        start = (0.0, 0.0, 0.0, 1.0) if quantity == "euler_parameters" else 0.0
        first[quantity] = builder.add_inputs(variable, told_of.shape, told_of.unit, about, [node], moves=True, start=start)

    def channels(quantities, n):
        return [[first[q] + k if q in first else -1 for q in quantities] for k in range(n)]

    found = [(u, False) for u in channels(GROUND_PLACE, 3)]
    orientation = next((q for q in ("zyx", "euler_parameters") if q in first), None)
    turn = (courses.TURN_NONE, 0)

    if orientation:
        turn = (TURNS[orientation, "omega" in first], first[orientation])
        lone = channels((orientation, None, None), GROUND_INPUTS[orientation].width)
        with_omega = channels((None, *GROUND_TURN), 3)
        found += [(u, False) for u in (with_omega if "omega" in first else lone)]
        builder.counts["n_attitude"] = int("omega" in first)

    return _add(builder, drives.GROUND_INPUT, node, channels=found, turn=turn)


def drive_constraints(builder):
    """Constraints of driven joints that close loops: one row on the joint's coordinate each."""
    return [
        _coordinate_constraint(builder, name, [builder.coordinate(name), -1], (1.0, 0.0), drive=drive)
        for name, drive in builder.driven_cuts.items()
    ]


def coupling_constraints(builder):
    """Couplings, and coordinates that follow others in their own joint, as those of screws."""
    constraints = []

    for name, coupling in builder.scene.coupling.items():
        first, second = coupling.between
        pair = [builder.coordinate(first), builder.coordinate(second)]
        at_start = coupling.offset is None
        constraints.append(
            _coordinate_constraint(builder, name, pair, (coupling.ratio, -1.0), coupling.offset or 0.0, at_start=at_start)
        )

    for name, joint in builder.scene.joint.items():
        for k, (other, ratio) in kind_of(joint).led(joint).items():
            pair = [builder.coordinate(name, k), builder.coordinate(name, other)]
            constraints.append(_coordinate_constraint(builder, name, pair, (1.0, -ratio)))

    return constraints


def add_coupling_outputs(builder):
    """Efforts of couplings in their two joints, once the rows are known."""
    columns = builder.tables["n_constraint"].columns

    for name, coupling in builder.scene.coupling.items():
        for output in coupling.output:
            c = next(c for c, owner in enumerate(builder.constraint_names) if owner == name)
            row = int(columns["constraint_row"][c][0])

            for side, joint in enumerate(coupling.between):
                _, unit = units_along(builder.scene.joint[joint])
                about = f"{COUPLING_OUTPUTS[output].text} of {name} on the second marker of {joint}"
                variable = f"{dotted(name, output)}[{side + 1}]"
                source = Source(outputs.COUPLING_EFFORT, row, side)
                builder.add_outputs(variable, source, unit, about, builder.constraint_nodes[c])


def _coordinate_constraint(builder, name, pair, factors, offset=0.0, **more):
    """A constraint of one row on one or two joint coordinates; `more` of it."""
    markers, nodes = [], []
    columns = builder.tables["n_coordinate"].columns

    for k in pair:
        here = [0, 0] if k >= 0 else [-1, -1]

        if k >= 0:
            body = int(columns["coordinate_body"][k][0])

            if body > 0:
                nodes.append(body)
            else:
                here = [int(columns[name][k][0]) for name in ("coordinate_from", "coordinate_to")]
                nodes += [builder.marker_node(marker) for marker in here]

        markers += here

    # a second coordinate in the tree has no markers
    if markers[2:] == [0, 0]:
        markers[2:] = [-1, -1]

    return Constraint(name, tuple(markers), nodes, [(rows.COUPLING, *pair)], factors, offset, **more)
