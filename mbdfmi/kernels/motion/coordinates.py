"""Scalar coordinates of joints (docs/theory.md 4.3): what forces, drives and outputs of one freedom refer to.

A joint of the tree has its coordinate in the state. One that closes a loop has it between its two markers (a, b): the
angle of b's x axis about a's z axis, or the displacement of b along it. The markers tell such an angle but for full turns. These are
told by a state of its own, integrated along with the others at the angle's rate: so the angle is right however far a step leads. It is
set to the angle wherever positions are projected.

A twist is an angle between two markers that nothing keeps parallel, as that of a torsion spring: of b about z, once the swing that
brings a's z axis to b's is taken away (docs/theory.md 16.12). Only forces act along it: it has no acceleration here. It starts within
half a turn; half a turn itself is taken as positive, whatever rounding says.

The parameter of a point on a curve is a coordinate, too, where that is driven: it stands in the state, and its rate is the velocity of the
point along a vector that end_frames/touching.py leaves, `parameter_along` (docs/theory.md 10.7).
"""

import math

import numpy as np

from ..language import inlined
from ..math import algebra as al
from . import markers

IN_TREE = 0
ANGLE = 1
SLIDE = 2
TWIST = 3
PARAMETER = 4

# rad, by how little less than half a turn backwards a twist starts as half a turn forwards
HALF_TURN = 1e-9


@inlined
def unwrapped(angle, near):
    """The angle (rad) plus the number of turns that brings it closest to `near`."""
    return angle + 2.0 * math.pi * np.floor((near - angle) / (2.0 * math.pi) + 0.5)


@inlined
def turn(m, t):
    """Where angle t of those outside the tree stands in z."""
    return m.n_s + t


@inlined
def value(m, d, k):
    """Coordinate k (rad or m)."""
    if m.coordinate_kind[k] == IN_TREE:
        return d.q[m.body_q[m.coordinate_body[k]]]

    if m.coordinate_kind[k] == PARAMETER:
        return d.z[m.end_frame_z[m.coordinate_end_frame[k]]]

    a = m.coordinate_from[k]
    b = m.coordinate_to[k]

    if m.coordinate_kind[k] == SLIDE:
        return markers.relative_position(m, d, a, b)[2]

    A = markers.relative_axes(m, d, a, b)
    twist = m.coordinate_kind[k] == TWIST
    angle = math.atan2(A[1][0] - A[0][1], A[0][0] + A[1][1]) if twist else math.atan2(A[1][0], A[0][0])
    return unwrapped(angle, d.z[turn(m, m.coordinate_turn[k])])


@inlined
def rate(m, d, k):
    """Rate of coordinate k (rad/s or m/s)."""
    if m.coordinate_kind[k] == IN_TREE:
        return d.v[m.body_v[m.coordinate_body[k]]]

    a = m.coordinate_from[k]
    b = m.coordinate_to[k]

    if m.coordinate_kind[k] == SLIDE:
        return markers.relative_velocity(m, d, a, b)[2]

    if m.coordinate_kind[k] == PARAMETER:
        return al.dot(in_first(m, d, k), markers.relative_velocity(m, d, a, b))

    if m.coordinate_kind[k] == TWIST:
        return al.dot(
            along(m, d, k), al.sub(markers.angular_velocity(m, d, b), markers.angular_velocity(m, d, a))
        )

    return markers.relative_angular_velocity(m, d, a, b)[2]


@inlined
def acceleration(m, d, k):
    """Second rate of coordinate k (rad/s2 or m/s2); needs the accelerations."""
    if m.coordinate_kind[k] == IN_TREE:
        return d.v_rate[m.body_v[m.coordinate_body[k]]]

    a = m.coordinate_from[k]
    b = m.coordinate_to[k]

    if m.coordinate_kind[k] == SLIDE:
        return markers.relative_acceleration(m, d, a, b)[2]

    if m.coordinate_kind[k] == PARAMETER:
        bend = d.parameter_bend[m.coordinate_end_frame[k]]
        return al.dot(in_first(m, d, k), markers.relative_acceleration(m, d, a, b)) + bend

    return markers.relative_angular_acceleration(m, d, a, b)[2]


@inlined
def bias(m, d, k):
    """Second rate of coordinate k at zero accelerations of the bodies (IN_TREE: of the state)."""
    if m.coordinate_kind[k] == IN_TREE:
        return 0.0

    a = m.coordinate_from[k]
    b = m.coordinate_to[k]
    body_a = m.marker_body[a]
    w_a = al.vec3(d.w, body_a)
    w_b = al.vec3(d.w, m.marker_body[b])
    z = along(m, d, k)

    if m.coordinate_kind[k] == ANGLE:
        return al.dot(al.cross(w_a, z), w_b)

    r = markers.position(m, d, b)
    seen = al.sub(markers.velocity(m, d, b), markers.point_velocity(m, d, body_a, r))
    swing = al.sub(
        al.cross(w_b, al.cross(w_b, markers.arm(m, d, b))),
        al.cross(w_a, al.cross(w_a, al.sub(r, al.vec3(d.r, body_a)))),
    )
    bend = d.parameter_bend[m.coordinate_end_frame[k]] if m.coordinate_kind[k] == PARAMETER else 0.0
    return al.dot(z, al.sub(swing, al.scale(2.0, al.cross(w_a, seen)))) + bend


@inlined
def along(m, d, k):
    """The axis of a coordinate that is not in the tree (inertial axes): its rate is the relative (angular) velocity times that."""
    if m.coordinate_kind[k] == PARAMETER:
        return al.vec3(d.parameter_along, m.coordinate_end_frame[k])

    z = al.column(markers.axes(m, d, m.coordinate_from[k]), 2)

    if m.coordinate_kind[k] == TWIST:
        z_b = al.column(markers.axes(m, d, m.coordinate_to[k]), 2)
        return al.scale(1.0 / (1.0 + al.dot(z, z_b)), al.add(z, z_b))

    return z


@inlined
def in_first(m, d, k):
    """`along` in the axes of the first marker."""
    return al.matT_vec(markers.axes(m, d, m.coordinate_from[k]), along(m, d, k))


@inlined
def wrenches(m, d, k, effort):
    """Wrenches about the bodies' origins of an effort along coordinate k not in the tree.

    (moment, force on the first side's body, moment, force on the second's), inertial axes.
    """
    u = al.scale(effort, along(m, d, k))

    if m.coordinate_kind[k] != SLIDE and m.coordinate_kind[k] != PARAMETER:
        return al.neg(u), al.ZERO3, u, al.ZERO3

    b = m.coordinate_to[k]
    P = al.sub(markers.position(m, d, b), al.vec3(d.r, m.marker_body[m.coordinate_from[k]]))
    return al.cross(u, P), al.neg(u), al.cross(markers.arm(m, d, b), u), u


@inlined
def add_effort(m, d, k, effort):
    """An effort (N m or N) along coordinate k, on its second side; its reaction on the first."""
    if m.coordinate_kind[k] == IN_TREE:
        d.tau[m.body_v[m.coordinate_body[k]]] += effort
        return

    d.coordinate_effort[k] += effort
    moment_a, force_a, moment_b, force_b = wrenches(m, d, k, effort)
    body_a = m.marker_body[m.coordinate_from[k]]
    body_b = m.marker_body[m.coordinate_to[k]]
    al.add_vec3(d.moment, body_a, moment_a)
    al.add_vec3(d.force, body_a, force_a)
    al.add_vec3(d.moment, body_b, moment_b)
    al.add_vec3(d.force, body_b, force_b)


@inlined
def turn_rates(m, d):
    """Rates of the angles outside the tree into d.z_rate; needs kinematics."""
    for t in range(m.n_turn):
        d.z_rate[turn(m, t)] = rate(m, d, m.turn_coordinate[t])


@inlined
def read_turns(m, d):
    """The angles outside the tree as they are, on the turn closest to that in d.z; needs kinematics."""
    for t in range(m.n_turn):
        d.z[turn(m, t)] = value(m, d, m.turn_coordinate[t])


@inlined
def start_twists(m, d):
    """Twists of a tree where it starts; needs kinematics, and d.z near them. No step reads them anew: each comes with its rate.

    Within a quarter turn of nothing they begin to count from nothing, which is near enough for good.
    """
    for t in range(m.n_turn):
        angle = value(m, d, m.turn_coordinate[t])
        d.z[turn(m, t)] = angle if abs(angle) > 0.5 * math.pi else 0.0
