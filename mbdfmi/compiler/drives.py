"""Prescribed motion of joints and of the ground."""

from dataclasses import dataclass
from typing import NamedTuple

import numpy as np

from ..kernels.motion import courses, drives
from ..vocabulary import ANGLE, GROUND_INPUTS, SLIDE, Coordinate, acceleration_of, parameter_of
from .builder import Place
from .end_frames import parameter_units
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

        for moved, node in zip(driven_coordinates(builder, name, joint), builder.joint_nodes.get(name, [-1])):
            drive = JOINT_DRIVES[moved.driver.kind](builder, moved, node)

            if node >= 0:
                builder.drive_of[node] = drive
            else:
                builder.driven_cuts[name] = drive


@dataclass(frozen=True)
class Drive:
    """A row of the table of drives.

    kind : of kernels/motion/drives.py. node : that it holds, -1 where its joint closes a loop.
    value, at, terms : numbers, the first of its tables or waves, and how many terms there are, by kind.
    channels : of each command the inputs that tell its position, speed and acceleration (-1: none), and whether it is an angle.
    turn : how an orientation is commanded (kernels/motion/courses.py), and by which input on.
    """

    kind: int
    node: int
    value: tuple = ()
    at: int = 0
    terms: int = 0
    channels: tuple = ()
    turn: tuple[int, int] = (courses.TURN_NONE, 0)


def _add(builder, drive):
    """Index of a drive in the table."""
    values = np.zeros(16)
    values[: len(drive.value)] = drive.value
    rows = [
        builder.tables["n_command"].add(command_u=u, command_angular=int(angular))
        for u, angular in drive.channels
    ]
    return builder.tables["n_drive"].add(
        drive_kind=drive.kind, drive_body=drive.node, drive_at=drive.at, drive_terms=drive.terms, drive_value=values,
        drive_turn=drive.turn, drive_command=rows[0] if rows else -1, drive_commands=len(rows),
    )  # fmt: skip


def _belonging(names, quantity, missing):
    """Which inputs are set together with one of them, for its description."""
    others = " and ".join(name for name in names if name != quantity)
    text = f"; to be set together with {others}" if others else ""
    return text + (f"; {' and '.join(missing)} found from the last commands" if missing else "")


class Driven(NamedTuple):
    """A coordinate whose motion a driver prescribes. path : what variables call it. start : position, speed and acceleration."""

    joint: str
    path: tuple[str, ...]
    driver: object
    coordinate: Coordinate
    start: tuple[float, float, float]

    @property
    def text(self) -> str:
        """What descriptions call it."""
        return " of ".join(reversed(self.path))


def driven_coordinates(builder, name, joint) -> list[Driven]:
    """What a joint's driver moves: its one coordinate, the parameter of its curve, or each of six."""
    if joint.kind == "prescribed":
        return [
            Driven(name, (name, key), driver, SLIDE if k < 3 else ANGLE, (start, 0.0, 0.0))
            for k, (key, driver, start) in enumerate(joint.driven())
        ]

    coordinate = (
        joint.coordinates[0] if joint.coordinates else parameter_of(parameter_units(builder, joint)[0])
    )
    start = float(joint.start_position()[0]), float(joint.start_velocity()[0]), 0.0
    return [Driven(name, (name,), joint.driver, coordinate, start)]


# of joints: a coordinate, node that it holds (-1: it closes a loop) -> index of the drive


def _constant_speed(builder, moved, node):
    speed = moved.driver.speed()
    drive = _add(builder, Drive(drives.CONSTANT_SPEED, node, (moved.start[0], speed)))
    place = Place("drive_value", drive, 1)
    about = f"prescribed speed of {moved.text}"
    builder.add_parameters(
        dotted(*moved.path, "speed_driven"), place, speed, moved.coordinate.rate.unit, about
    )
    return drive


def _hold(builder, moved, node):
    return _add(builder, Drive(drives.CONSTANT_SPEED, node, (moved.start[0], 0.0)))


def _waves(builder, moved, node):
    """One harmonic or the sum of several."""
    harmonics = getattr(moved.driver, moved.driver.kind)
    unit = moved.coordinate.position.unit
    waves, mean = harmonics.waves(), harmonics.mean_value()
    first = [builder.tables["n_wave"].add(wave_value=wave) for wave in waves][0]
    drive = _add(builder, Drive(drives.HARMONIC, node, (mean,), at=first, terms=len(waves)))
    about = f"mean of the motion of {moved.text}"
    builder.add_parameters(
        dotted(*moved.path, "driver", "mean"), Place("drive_value", drive), mean, unit, about, "fixed"
    )

    for k, wave in enumerate(waves):
        ending = f"[{k + 1}]" if np.ndim(harmonics.frequency) else ""

        for offset, (quantity, of) in enumerate((("amplitude", unit), ("frequency", "Hz"), ("phase", "rad"))):
            about = f"{quantity} of the motion of {moved.text}"
            variable = dotted(*moved.path, "driver", quantity) + ending
            place = Place("wave_value", first + k, offset)
            builder.add_parameters(variable, place, wave[offset], of, about, "fixed")

    return drive


def _polynomial(builder, moved, node):
    value = moved.driver.polynomial.values()
    drive = _add(builder, Drive(drives.POLYNOMIAL, node, value, terms=len(value)))
    units = [
        moved.coordinate.position.unit,
        moved.coordinate.rate.unit,
        acceleration_of(moved.coordinate).unit,
    ]
    units = (units + [None] * 16)[: len(value)]
    about = f"coefficients of the powers of time of {moved.text}, SI"
    variable = dotted(*moved.path, "driver", "coefficients")
    builder.add_parameters(variable, Place("drive_value", drive), value, units, about, "fixed")
    return drive


def _ramp(builder, moved, node):
    """A smooth way from one position to another."""
    value = moved.driver.ramp.values()
    drive = _add(builder, Drive(drives.RAMP, node, value))
    position = moved.coordinate.position

    for k, end in enumerate(("begin", "end")):
        for offset, quantity, of in ((2 * k, "time", "s"), (2 * k + 1, position.name, position.unit)):
            about = f"{quantity} of {moved.text} at the {'beginning' if k == 0 else 'end'} of its ramp"
            variable = dotted(*moved.path, "driver", f"{quantity}_{end}")
            builder.add_parameters(
                variable, Place("drive_value", drive, offset), value[offset], of, about, "fixed"
            )

    return drive


def _table(builder, moved, node):
    table = moved.driver.table
    return _add(
        builder, Drive(drives.TABLE, node, at=builder.tables_over_time(table.interpolation, *table.points()))
    )


def _speed_table(builder, moved, node):
    table = moved.driver.speed_table
    at = builder.tables_over_time(table.interpolation, *table.points())
    return _add(builder, Drive(drives.SPEED_TABLE, node, (moved.start[0],), at=at))


def _commands(builder, moved, node):
    """What inputs tell of the motion."""
    quantities = (moved.coordinate.position, moved.coordinate.rate, acceleration_of(moved.coordinate))
    told = len(moved.driver.commands())
    names = [dotted(*moved.path, f"{quantity.name}_command") for quantity in quantities[:told]]
    missing = [quantity.name for quantity in quantities[told:]]
    nodes = builder.nodes_of(moved.joint)
    inputs = [-1, -1, -1]

    for k, (quantity, variable, start) in enumerate(zip(quantities, names, moved.start)):
        about = f"{quantity.name} that {moved.text} is driven to" + _belonging(names, variable, missing)
        inputs[k] = builder.add_inputs(variable, quantity, about, nodes, moves=True, start=float(start))

    return _add(
        builder, Drive(drives.INPUT, node, channels=((inputs, moved.coordinate.position.unit == "rad"),))
    )


JOINT_DRIVES = {
    "constant_speed": _constant_speed,
    "hold": _hold,
    "harmonic": _waves,
    "harmonics": _waves,
    "polynomial": _polynomial,
    "ramp": _ramp,
    "table": _table,
    "speed_table": _speed_table,
    "input": _commands,
}


# of the ground


def _add_ground(builder, motion, node):
    """Index of the drive of the ground."""
    if motion.kind == "acceleration":
        value = [*motion.position, *motion.velocity, *motion.acceleration]
        return _add(builder, Drive(drives.GROUND_ACCELERATION, node, value))

    if motion.kind == "rotation":
        turn = motion.rotation
        value = [*turn.direction(), *turn.point, turn.speed_value(), turn.angle_value()]
        return _add(builder, Drive(drives.GROUND_ROTATION, node, value))

    if motion.kind == "orbit":
        orbit = motion.orbit
        value = [*orbit.axes().ravel(), orbit.radius, orbit.rate, orbit.phase_value(), float(orbit.pointing)]
        return _add(builder, Drive(drives.GROUND_ORBIT, node, value))

    if motion.kind == "elliptic_orbit":
        orbit = motion.elliptic_orbit
        shape = [orbit.semi_major_axis, orbit.eccentricity, orbit.mean_motion(), orbit.mean_anomaly_value()]
        value = [*orbit.axes().ravel(), *shape, float(orbit.pointing)]
        return _add(builder, Drive(drives.GROUND_ELLIPSE, node, value))

    if motion.kind == "table":
        time, position, E = motion.table.points()
        table = builder.tables_over_time(motion.table.interpolation, time, np.hstack([position, E]))
        return _add(builder, Drive(drives.GROUND_TABLE, node, at=table))

    return _add_ground_inputs(builder, motion.commands(), node)


def _add_ground_inputs(builder, told, node):
    """The drive of a ground that inputs command; `told`: what they tell of its motion."""
    of_place, of_turn = (
        [quantity for quantity in GROUND_INPUTS if (quantity in GROUND_PLACE) == place]
        for place in (True, False)
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
        first[quantity] = builder.add_inputs(variable, told_of, about, [node], moves=True, start=start)

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

    return _add(builder, Drive(drives.GROUND_INPUT, node, channels=tuple(found), turn=turn))
