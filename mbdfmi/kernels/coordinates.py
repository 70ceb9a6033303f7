"""Scalar coordinates of joints: what springs, dampers, friction, stops, drives and outputs of one freedom refer to.

A joint of the tree has its coordinate in the state. One that closes a loop has it between its two markers (a, b): the
angle of b's x axis about a's z axis, or the displacement of b along it. Angles there are followed through full turns: the last accepted value
tells which turn it is.
"""

import math

from . import algebra as al
from . import markers
from .language import inlined

IN_TREE = 0
ANGLE = 1
SLIDE = 2


@inlined
def unwrapped(angle, near):
    """The angle (rad) plus the number of turns that brings it closest to `near`."""
    return angle + 2.0 * math.pi * math.floor((near - angle) / (2.0 * math.pi) + 0.5)


@inlined
def value(m, d, k):
    """Coordinate k (rad or m)."""
    if m.coordinate_kind[k] == IN_TREE:
        return d.x[m.body_q[m.coordinate_body[k]]]

    a = m.coordinate_from[k]
    b = m.coordinate_to[k]

    if m.coordinate_kind[k] == SLIDE:
        return markers.relative_position(m, d, a, b)[2]

    A = markers.relative_axes(m, d, a, b)
    return unwrapped(math.atan2(A[1][0], A[0][0]), d.coordinate_last[k])


@inlined
def rate(m, d, k):
    """Rate of coordinate k (rad/s or m/s)."""
    if m.coordinate_kind[k] == IN_TREE:
        return d.x[m.n_q + m.body_v[m.coordinate_body[k]]]

    a = m.coordinate_from[k]
    b = m.coordinate_to[k]

    if m.coordinate_kind[k] == SLIDE:
        return markers.relative_velocity(m, d, a, b)[2]

    return markers.relative_angular_velocity(m, d, a, b)[2]


@inlined
def acceleration(m, d, k):
    """Second rate of coordinate k (rad/s2 or m/s2); needs the accelerations."""
    if m.coordinate_kind[k] == IN_TREE:
        return d.x_rate[m.n_q + m.body_v[m.coordinate_body[k]]]

    a = m.coordinate_from[k]
    b = m.coordinate_to[k]

    if m.coordinate_kind[k] == SLIDE:
        return markers.relative_acceleration(m, d, a, b)[2]

    return markers.relative_angular_acceleration(m, d, a, b)[2]


@inlined
def add_effort(m, d, k, effort):
    """An effort (N m or N) along coordinate k, on its second side; its reaction on the first."""
    if m.coordinate_kind[k] == IN_TREE:
        d.tau[m.body_v[m.coordinate_body[k]]] += effort
        return

    d.coordinate_effort[k] += effort
    a = m.coordinate_from[k]
    b = m.coordinate_to[k]
    A = markers.axes(m, d, a)
    along = al.scale(effort, (A[0][2], A[1][2], A[2][2]))
    r = markers.position(m, d, b)

    if m.coordinate_kind[k] == SLIDE:
        markers.add_wrench(m, d, m.marker_body[b], r, al.ZERO3, along)
        markers.add_wrench(m, d, m.marker_body[a], r, al.ZERO3, al.neg(along))
    else:
        markers.add_wrench(m, d, m.marker_body[b], r, along, al.ZERO3)
        markers.add_wrench(m, d, m.marker_body[a], r, al.neg(along), al.ZERO3)


@inlined
def follow_turns(m, d):
    """Remember the coordinates' values, so that the next ones are found on the same turn."""
    for k in range(m.n_coordinate):
        d.coordinate_last[k] = value(m, d, k)
