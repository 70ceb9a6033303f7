"""Where a scene starts, as far as start values alone tell: joint by joint outwards from the ground,
without closing loops."""

import numpy as np
from scipy.spatial.transform import Rotation

from .joints import joint_axis, two_axes
from .motion import Inputs, rotation_of_zyx
from .reading import cross, orientation, plane_axes, si


def motions_at_start(system, t=0.0):
    """Body -> (r, A, v, w) by the start values of the joints that lead to it,
    each body by the first that does."""
    ground = system.ground.at(t, Inputs({}))[:4]
    motions, waiting = {"ground": ground}, list(system.joints.values())

    while waiting:
        ready = [j for j in waiting if any(system.end(end)[0] in (*motions, "inertial") for end in j.ends)]

        if not ready:
            raise ValueError(f"nothing leads to the bodies of {', '.join(joint.name for joint in waiting)}")

        for joint in ready:
            waiting.remove(joint)
            here, there = (system.end(end)[0] for end in joint.ends)

            if there not in motions:
                motions[there] = _carried(system, motions, joint.ends, *_relative(joint, t))
            elif here not in motions:
                motions[here] = _carried(system, motions, joint.ends[::-1], *_reversed(*_relative(joint, t)))

    return {body: motions[body] for body in system.bodies}


def _carried(system, motions, ends, d, R, v, w):
    """Motion of the second end's body, whose marker moves so as seen from the first one, in its axes."""
    r, A, v1, w1 = system.frame(motions, ends[0])
    _, position, axes = system.end(ends[1])
    turned = A @ R @ axes.T
    spin = w1 + A @ w
    place = r + A @ d
    arm = turned @ position
    return place - arm, turned, v1 + cross(w1, A @ d) + A @ v - cross(spin, arm), spin


def _reversed(d, R, v, w):
    """The first frame as seen from the second, in that one's axes."""
    return -R.T @ d, R.T, R.T @ (cross(w, d) - v), -R.T @ w


def _relative(joint, t):
    """(d, R, v, w) of the second marker in the first by the joint's start."""
    kind, start, options = joint.kind, joint.start, joint.options
    still, zero = np.eye(3), np.zeros(3)

    def turn(u, angle):
        return Rotation.from_rotvec(angle * u).as_matrix()

    if kind in ("spherical", "free"):
        R = orientation(start)
        spin = _filled(start.get("omega"), "xyz")
        spin = R @ _filled(start["omega_body"], "xyz") if start.get("omega_body") is not None else spin
        place, speed = (_filled(start.get(key), "xyz") for key in ("position", "velocity"))
        return place, R, speed, spin

    if kind == "prescribed":
        x, speed, _ = np.nan_to_num(joint.asked(t, t, Inputs({}), np.zeros((3, 6))))
        R, spin, _ = rotation_of_zyx(x[3:], speed[3:], zero)
        return x[:3], R, speed[:3], spin

    if kind == "translation":
        return _filled(start.get("position"), "xyz"), still, _filled(start.get("velocity"), "xyz"), zero

    if kind == "universal":
        first, second = two_axes("universal", options)
        (a, b), (a1, b1) = (_two(start, key) for key in ("angles", "speeds"))
        R = turn(first, a)
        return zero, R @ turn(second, b), zero, a1 * first + b1 * R @ second

    u = joint_axis(kind, options)

    if kind == "planar":
        x, y, _ = plane_axes(u).T
        (a, b), (a1, b1) = (_filled(start.get(key), "xy") for key in ("position", "velocity"))
        return (
            a * x + b * y,
            turn(u, si(start, "angle", 0.0)),
            a1 * x + b1 * y,
            si(start, "angular_speed", 0.0) * u,
        )

    angle, place = si(start, "angle", 0.0), start.get("position", 0.0)
    spin, speed = si(start, "angular_speed", 0.0), start.get("speed", 0.0)

    if kind == "screw":
        place, speed = (joint.options["pitch"] / (2 * np.pi) * x for x in (angle, spin))
    elif kind == "revolute":
        spin, speed = si(start, "speed", 0.0), 0.0

    if joint.driver:
        at, rate, _ = joint.driver.target(
            t, (angle + place, t), Inputs({}), (angle + place, spin + speed, 0.0)
        )
        angle, spin, place, speed = (at, rate, 0.0, 0.0) if kind == "revolute" else (0.0, 0.0, at, rate)

    if kind not in ("revolute", "prismatic", "screw", "cylindrical"):
        return zero, still, zero, zero

    return place * u, turn(u, angle), speed * u, spin * u


def _filled(value, names):
    """An array of which a table may give some components; the others are 0."""
    if isinstance(value, dict):
        return np.array([value.get(name, 0.0) for name in names], float)

    return np.zeros(len(names)) if value is None else np.array(value, float)


def _two(start, key):
    """Angles or speeds of a universal joint, SI."""
    factor = np.pi / 180 if start.get(f"{key}_deg") is not None else 1.0
    return factor * _filled(start.get(f"{key}_deg", start.get(key)), ("first", "second"))
