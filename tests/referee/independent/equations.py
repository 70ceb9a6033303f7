"""The equations of each kind of joint, and of a 6x6 element, compiled once:
functions of two owners and of numbers."""

from functools import cache

import casadi as ca
import numpy as np

from . import contacts, joints
from .taylor import STATE, Frame, Pair, Signals, moving, swing_and_twist

SIX = "6x6 element"

# of the inertial frame, which nothing moves
STILL = np.concatenate([np.zeros(3), np.eye(3).ravel(), np.zeros(6)])


@cache
def of_kind(kind):
    """Signals of two frames at poses in their owners; the accelerations are the two owners', then those of s.

    Joints: "coordinates", "joint" (what is 0 of positions), "slip" (of velocities). 6x6 elements: "moved",
    "seen".
    """
    tau = ca.SX.sym("tau")
    n_s = contacts.COUNT.get(kind, 0)
    states, poses = ca.SX.sym("states", 2 * STATE), ca.SX.sym("poses", 24)
    accelerations = ca.SX.sym("accelerations", 12 + n_s)
    frames = []

    for k in range(2):
        owner = moving(states[STATE * k : STATE * (k + 1)], accelerations[6 * k : 6 * k + 6], tau)
        place, axes = poses[12 * k : 12 * k + 3], ca.reshape(poses[12 * k + 3 : 12 * k + 12], 3, 3).T
        arm = owner.A @ place
        frames.append(Frame(owner.r + arm, owner.A @ axes, owner.v + ca.cross(owner.w, arm), owner.w))

    pair, signals = Pair(*frames), Signals()

    if kind == SIX:
        numbers = ca.SX.sym("R and E", 13)
        turns = swing_and_twist(pair.R, ca.reshape(numbers[:9], 3, 3).T, numbers[9:])
        signals.add("moved", ca.vertcat(pair.d, turns))
        signals.add("seen", ca.vertcat(pair.v, pair.w), "velocity")
    else:
        geometry = ca.SX.sym("geometry", joints.GEOMETRY)
        holds, slips = joints.constraints(kind, geometry, pair)
        numbers = geometry

        if n_s:
            holds, symbols = contacts.equations(kind, pair, accelerations[12:], tau)
            numbers = ca.vertcat(geometry, symbols)

        signals.add("coordinates", joints.coordinates(kind, geometry, pair))
        signals.add("joint", holds)
        signals.add("slip", slips, "velocity")

    signals.compile(tau, accelerations, ca.vertcat(states, poses, numbers))
    return signals
