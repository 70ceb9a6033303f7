"""Prescribed motions: drivers of joints, the motion of the ground, loads over time."""

import numpy as np

from . import frames
from .inside import degrees

READING = ("smooth", "quintic", "cubic", "linear")
WAYS = {
    "constant_speed": 1.2, "hold": 0.8, "harmonic": 1.5, "harmonics": 1.8, "polynomial": 1.1, "ramp": 1.1,
    "table": 3.3, "speed_table": 3.5, "input": 2,
}  # fmt: skip


def _reading(dice, ways=READING):
    return {"interpolation": dice.pick(ways)} if dice.chance(0.95) else {}


def _times(dice, least=4):
    n = dice.whole(least, 9)
    return dice.ascending(n, 0.0 if dice.chance(0.5) else dice.number(0.05, 0.3), dice.number(0.8, 2.5))


def _wandering(dice, n, size, start):
    """n values that go up and down, some standing still, some kinked."""
    values = [start]

    for _ in range(n - 1):
        values.append(round(values[-1] + (0.0 if dice.chance(0.2) else dice.number(-size, size)), 4))

    return values


def driver(dice, kind, q, ways=WAYS):
    """A driver of a revolute or prismatic joint that may start at q.

    Returns (its table, where it starts, its speed there or None where that is not simple, what its start may
    say of it).
    """
    way = dice.weighted(ways)
    angular = kind == "revolute"
    size = 1.0 if angular else 0.3

    if way == "hold":
        return {"hold": True}, q, 0.0, "place"

    if way == "constant_speed":
        speed = dice.signed(0.1, 2.0) * size if dice.chance(0.85) else dice.signed(5.0, 30.0) * size
        unit = dice.pick(["", "_deg", "_rpm"]) if angular else ""
        value = round(speed * {"": 1, "_deg": 57.3, "_rpm": 9.55}[unit], 3)
        return {way + unit: value}, q, value * RATES[unit], "place"

    if way == "speed_table":
        times = _times(dice)
        speeds = _wandering(dice, len(times), size, dice.number(-size, size))
        unit = dice.pick(["", "_deg", "_rpm"]) if angular else ""
        speeds = [round(s / RATES[unit], 4) for s in speeds]
        rate = speeds[0] * RATES[unit]
        return {way: {"time": times, f"speed{unit}": speeds} | _reading(dice)}, q, rate, "place"

    if way == "input":
        told = dice.pick(
            [True, True, ["position"], ["position", "speed"], ["position", "speed", "acceleration"]]
        )
        if told is not True and angular and dice.chance(0.5):
            told = ["angle" if what == "position" else what for what in told]
        if told is not True and dice.chance(0.3):
            told = told[::-1]
        with_speed = told is True or len(told) > 1
        rate = dice.number(-0.5, 0.5) * size if with_speed and dice.chance(0.6) else 0.0
        return {way: told}, q, rate, "all" if with_speed else "place"

    table, start, rate = PRESCRIBED[way](dice, angular, size, q)
    return {way: table}, start, rate, ""


RATES = {"": 1.0, "_deg": np.pi / 180, "_rpm": np.pi / 30}


def _in(unit, values):
    """Values (SI) in a unit, in round numbers, and SI again."""
    given = np.round(np.asarray(values) / RATES[unit], 4 if unit == "" else 2)
    return given.tolist(), given * RATES[unit]


def _mean(dice, angular, mean):
    """(keys, SI)"""
    if mean is None:
        return {}, 0.0

    unit = dice.pick(["", "_deg"]) if angular else ""
    given, value = _in(unit, mean)
    return {f"mean{unit}": given}, float(value)


def _harmonic(dice, angular, size, q):
    unit = dice.pick(["", "_deg"]) if angular else ""
    given, amplitude = _in(unit, dice.number(0.1, 0.7) * size)
    frequency, phase = (
        dice.number(0.2, 1.5),
        float(dice.pick(range(-180, 181, 15))) if dice.chance(0.7) else 0.0,
    )
    keys, mean = _mean(dice, angular, q if dice.chance(0.7 if angular else 0.9) else None)
    w, p = 2 * np.pi * frequency, np.radians(phase)
    table = (
        {f"amplitude{unit}": given, "frequency": frequency} | ({"phase_deg": phase} if phase else {}) | keys
    )
    return table, mean + float(amplitude) * np.sin(p), float(amplitude) * w * np.cos(p)


def _harmonics(dice, angular, size, q):
    n = dice.whole(1, 4)
    unit = dice.pick(["", "_deg"]) if angular else ""
    given, amplitude = _in(unit, dice.rng.uniform(0.05, 0.4, n) * size)
    frequency = dice.numbers(n, 0.2, 2.0)
    phase = [float(dice.pick(range(-180, 181, 15))) for _ in range(n)] if dice.chance(0.7) else None
    keys, mean = _mean(dice, angular, q if dice.chance(0.7) else None)
    w, p = 2 * np.pi * np.array(frequency), np.radians(phase or np.zeros(n))
    table = (
        {f"amplitude{unit}": given, "frequency": frequency} | ({"phase_deg": phase} if phase else {}) | keys
    )
    return table, mean + float(amplitude @ np.sin(p)), float((amplitude * w) @ np.cos(p))


def _polynomial(dice, angular, size, q):
    unit = dice.pick(["", "_deg"]) if angular else ""
    given, c = _in(unit, [q, *(dice.signed(0.05, 0.6) * size for _ in range(dice.whole(0, 4)))])
    return {f"coefficients{unit}": given}, float(c[0]), float(c[1]) if len(c) > 1 else 0.0


def _ramp(dice, angular, size, q):
    unit = dice.pick(["", "_deg"]) if angular else ""
    begin = dice.number(0.0, 0.4)
    given, ends = _in(unit, [q, q + dice.signed(0.1, 1.0) * size])
    return (
        {"time": [begin, round(begin + dice.number(0.4, 1.5), 3)], f"position{unit}": given},
        float(ends[0]),
        0.0,
    )


def _table(dice, angular, size, q):
    times = _times(dice)
    unit = dice.pick(["", "_deg"]) if angular else ""
    given, values = _in(unit, _wandering(dice, len(times), 0.3 * size, q))
    reading = _reading(dice)
    rate = 0.0 if times[0] > 0.0 else None
    return {"time": times, f"position{unit}": given} | reading, float(values[0]), rate


PRESCRIBED = {
    "harmonic": _harmonic, "harmonics": _harmonics, "polynomial": _polynomial, "ramp": _ramp, "table": _table,
}  # fmt: skip


# the ground

GROUND = {"acceleration": 1, "rotation": 1.6, "orbit": 1.2, "table": 2.2, "input": 2.2}


def ground(dice, kinds=GROUND, site=0.0):
    """A motion of the ground as (its table, pose (r, A) at time 0). site : m,
    how far from the inertial origin it is, if at all."""
    kind = dice.weighted(kinds)

    if kind == "acceleration":
        table = {"acceleration": dice.vector(1.5)}
        if dice.chance(0.6):
            table["velocity"] = dice.vector(0.5)
        if dice.chance(0.6) or site:
            table["position"] = dice.vector(0.5) if not site else [site, 0.0, dice.number(-1, 1)]
        return table, (np.array(table.get("position", [0.0, 0.0, 0.0])), np.eye(3))

    if kind == "rotation":
        return _rotation(dice)

    if kind == "orbit":
        return _orbit(dice, site)

    if kind == "table":
        return _pose_table(dice, site)

    told = True if dice.chance(0.15) else dice.pick(INPUTS)
    return {"input": told if told is True else list(told)}, frames.HERE


INPUTS = (
    ["position"],
    ["position", "velocity"],
    ["position", "speed"],
    ["position", "velocity", "acceleration"],
    ["zyx"],
    ["position", "zyx"],
    ["euler_parameters"],
    ["euler_parameters", "omega"],
    ["zyx", "omega", "alpha"],
    ["position", "velocity", "euler_parameters", "omega"],
    ["position", "speed", "acceleration", "zyx", "omega", "alpha"],
    ["position", "euler_parameters", "omega", "alpha"],
)


def _rotation(dice):
    written, axis = frames.axis(dice)
    options = {} if written == "z" and dice.chance(0.5) else {"axis": written}
    unit = dice.pick(["", "_deg", "_rpm"])
    options[f"speed{unit}"] = round(dice.signed(0.2, 2.5) / RATES[unit], 3)
    point, angle = np.zeros(3), 0.0

    if dice.chance(0.5):
        options["point"] = dice.vector(0.5)
        point = np.array(options["point"])
    if dice.chance(0.6):
        given = degrees(dice, "angle", dice.number(-2, 2))
        options |= given
        angle = given.get("angle", np.radians(given.get("angle_deg", 0.0)))

    A = frames.about(axis, angle)
    return {"rotation": options}, (point - A @ point, A)


def _orbit(dice, site):
    if dice.chance(0.5):
        return _ellipse(dice, site)

    written, normal = frames.axis(dice)
    radius = dice.number(0.5, 3.0) if not site else site
    options = {"radius": radius, "rate": dice.signed(0.2, 1.5)}
    phase = 0.0
    if not (written == "z" and dice.chance(0.5)):
        options["normal"] = written
    if dice.chance(0.6):
        phase = options["phase_deg"] = float(dice.pick(range(-180, 181, 15)))
    if dice.chance(0.8):
        options["pointing"] = dice.chance(0.5)

    axes = frames.plane_axes(normal)
    turned = axes @ frames.about([0, 0, 1.0], np.radians(phase))
    return {"orbit": options}, (radius * turned[:, 0], turned if options.get("pointing", True) else np.eye(3))


def _ellipse(dice, site):
    e = dice.number(0.0, 0.6)
    a = dice.number(0.5, 3.0) if not site else site / (1 - e)
    options = {"semi_major_axis": a, "eccentricity": e}
    period = dice.number(10.0, 40.0)
    options |= {"period": period} if dice.chance(0.5) else {"mu": (2 * np.pi / period) ** 2 * a**3}
    A = np.eye(3)

    for key, about in (
        ("node_deg", [0, 0, 1.0]),
        ("inclination_deg", [1.0, 0, 0]),
        ("periapsis_deg", [0, 0, 1.0]),
    ):
        if dice.chance(0.6):
            options[key] = float(dice.pick(range(-180, 181, 15)))
            A = A @ frames.about(about, np.radians(options[key]))

    E, told = 0.0, dice.pick(["", "mean", "mean", "true", "true"])
    if told:
        E = dice.number(-3.0, 3.0)
        nu = 2 * np.arctan(np.sqrt((1 + e) / (1 - e)) * np.tan(E / 2))
        options[f"{told}_anomaly_deg"] = float(np.degrees(nu if told == "true" else E - e * np.sin(E)))
    if dice.chance(0.8):
        options["pointing"] = dice.chance(0.5)

    r = a * np.array([np.cos(E) - e, np.sqrt(1 - e * e) * np.sin(E), 0.0])
    axes = A @ frames.about([0, 0, 1.0], np.arctan2(r[1], r[0]))
    return {"elliptic_orbit": options}, (A @ r, axes if options.get("pointing", True) else np.eye(3))


def _pose_table(dice, site):
    times = _times(dice)
    n = len(times)
    table, r, A = {"time": times}, np.zeros(3), np.eye(3)
    what = dice.pick(["position", "turn", "both"]) if not site else "both"

    if what != "turn":
        columns = [_wandering(dice, n, 0.2, dice.number(-0.3, 0.3) + site * (k == 0)) for k in range(3)]
        table["position"] = np.column_stack(columns).tolist()
        r = np.array(table["position"][0])

    if what != "position":
        angles = np.column_stack([_wandering(dice, n, 0.25, dice.number(-0.5, 0.5)) for _ in range(3)])
        turns = [frames.Rotation.from_euler("ZYX", row) for row in angles]
        way = dice.pick(["zyx_deg", "zyx_rad", "euler_parameters"])
        A = turns[0].as_matrix()
        if way == "euler_parameters":
            table[way] = [turn.as_quat().tolist() for turn in turns]
        elif way == "zyx_rad":
            table[way] = angles.tolist()
        else:
            table[way] = np.degrees(angles).tolist()

    return {"table": table | _reading(dice)}, (r, A)


def load_over_time(dice) -> dict:
    """A force and a moment over time."""
    times = dice.ascending(dice.whole(3, 7), 0.0 if dice.chance(0.5) else 0.1, dice.number(0.8, 2.0))
    what = dice.some(("force", "moment"), 1)
    table = {"time": times} | {
        key: [dice.vector(3.0 if key == "force" else 0.5) for _ in times] for key in what
    }
    return table | (
        {"interpolation": dice.pick(["linear", "steps", "monotone", "cubic"])} if dice.chance(0.85) else {}
    )
