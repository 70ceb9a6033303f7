"""Joints that are led: six coordinates prescribed, a driver along a curve. And surfaces that touch or roll."""

import numpy as np

from ..independent.curves import Curve
from ..independent.reading import orientation
from . import frames, kinds, motions, shapes

CLOSING = {
    "surface_on_surface": 1,
    "rolling_surface": 1,
    "driven point_on_curve": 1.1,
    "driven frame_on_curve": 2.2,
}
FROM_START = ("constant_speed", "hold", "speed_table", "input")
COORDINATES = ("x", "y", "z", "yaw", "pitch", "roll")


def draw(dice, kind, size=1.0):
    """A joint of one of CLOSING."""
    if kind.startswith("driven"):
        return _along(dice, kind.split()[1], size)

    first, second, pose, arm = shapes.touching_surfaces(dice)
    rows = kinds.rolls(arm) if kind == "rolling_surface" else kinds.sliding(frames.unit(first.n))
    if kind == "surface_on_surface":
        n = rows[:, 3:]
        rows = np.hstack([np.cross(arm, n), n])
    return kinds.Drawn(
        kind, {kind: {}}, {"s": first.s}, pose, rows=rows, shapes=({"surface": first.table}, {"surface": second})
    )  # fmt: skip


def _along(dice, kind, size):
    """A joint on a curve with a driver of its parameter, where that starts."""
    while True:
        curve = shapes.curve(dice)
        table, s, _, _ = motions.driver(dice, "prismatic", curve.s)

        # not far from where the curve is drawn, which may end
        if abs(s - curve.s) < 0.01:
            break

    curve = shapes.Curve(curve.table, s, *Curve(curve.table).derivatives(s)[:3])
    joint = kinds.MAKERS[kind](dice, size, curve)
    joint.rows = np.eye(6)[3:] if kind == "point_on_curve" else kinds.with_driver(joint)
    joint.table["driver"], joint.q = table, {"s": s} if _goes_on(table) else {}
    return joint


def _goes_on(driver):
    """Whether a driver goes on from the start."""
    return any(key.startswith(FROM_START) for key in driver)


def prescribed(dice):
    """A joint whose six coordinates are prescribed, some of them held."""
    driven = dice.some(COORDINATES, 1)
    start, told, table = np.zeros(6), np.zeros(6), {}

    for k, key in enumerate(COORDINATES):
        q, kind = (dice.number(-0.5, 0.5), "prismatic") if k < 3 else (dice.number(-1.2, 1.2), "revolute")

        if key in driven:
            table[key], q, _, _ = motions.driver(dice, kind, q)

        start[k] = q
        told[k] = q if _goes_on(table.get(key, {"hold": True})) else 0.0

    angles = (
        {"zyx_rad": told[3:].tolist()} if dice.chance(0.4) else {"zyx_deg": np.degrees(told[3:]).tolist()}
    )
    q = ({"position": told[:3].tolist()} if told[:3].any() else {}) | (angles if told[3:].any() else {})
    pose = start[:3], orientation({"zyx_rad": start[3:]})
    return kinds.Drawn("prescribed", {"prescribed": {}, "driver": table}, q, pose)
