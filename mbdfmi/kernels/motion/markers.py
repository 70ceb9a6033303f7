"""Where markers are and how they move, absolutely and relative to each other (docs/theory.md 4).

A marker is a frame fixed in a body; marker 0 is the inertial frame O.
"""

import math

from .. import joints
from ..language import inlined
from ..math import algebra as al


@inlined
def arm(m, d, k):
    """Marker k's origin from its body's origin (m, inertial axes)."""
    return al.mat_vec(al.mat3(d.A, m.marker_body[k]), al.vec3(m.marker_r, k))


@inlined
def axes(m, d, k):
    """Rotation matrix from marker k's axes to O."""
    return al.mat_mat(al.mat3(d.A, m.marker_body[k]), al.mat3(m.marker_A, k))


@inlined
def position(m, d, k):
    """Marker k's origin (m, in O)."""
    return al.add(al.vec3(d.r, m.marker_body[k]), arm(m, d, k))


@inlined
def point_velocity(m, d, i, r):
    """Velocity (m/s, in O) of the point of body i that is now at r (m, in O)."""
    lever = al.sub(r, al.vec3(d.r, i))
    return al.add(al.vec3(d.rd, i), al.cross(al.vec3(d.w, i), lever))


@inlined
def point_acceleration(m, d, i, r):
    """Acceleration (m/s2, in O) of the point of body i that is now at r (m, in O); needs the bodies' accelerations."""
    lever = al.sub(r, al.vec3(d.r, i))
    w = al.vec3(d.w, i)
    turned = al.add(al.cross(al.vec3(d.alpha, i), lever), al.cross(w, al.cross(w, lever)))
    return al.add(al.vec3(d.rdd, i), turned)


@inlined
def add_wrench(m, d, i, r, moment, force):
    """A wrench on body i at the point r (m, in O): moment (N m) and force (N) in inertial axes."""
    lever = al.sub(r, al.vec3(d.r, i))
    al.add_vec3(d.moment, i, al.add(moment, al.cross(lever, force)))
    al.add_vec3(d.force, i, force)


@inlined
def velocity(m, d, k):
    """Velocity of marker k's origin (m/s, in O)."""
    i = m.marker_body[k]
    return al.add(al.vec3(d.rd, i), al.cross(al.vec3(d.w, i), arm(m, d, k)))


@inlined
def angular_velocity(m, d, k):
    """Angular velocity of marker k's body (rad/s, inertial axes)."""
    return al.vec3(d.w, m.marker_body[k])


@inlined
def turn_bodies(m, d):
    """Euler parameters of all bodies in O, by the chain of joints: continuous in time, of unit length but for rounding."""
    al.set_E_at(d.E, 0, al.E_IDENTITY)

    for i in range(1, m.n_body):
        base = al.E_product(al.E_at(d.E, 4 * m.body_parent[i]), al.matrix_E(al.mat3(m.body_A, i)))
        al.set_E_at(d.E, 4 * i, al.E_product(base, joints.relative_E(m, d, i)))


@inlined
def E(m, d, k):
    """Euler parameters of marker k in O, unit length, after `turn_bodies`."""
    turned = al.E_product(al.E_at(d.E, 4 * m.marker_body[k]), al.matrix_E(al.mat3(m.marker_A, k)))
    return al.E_scale(1.0 / math.sqrt(al.E_dot(turned, turned)), turned)


@inlined
def relative_position(m, d, a, b):
    """Origin of marker b from that of a, in a's axes (m)."""
    return al.matT_vec(axes(m, d, a), al.sub(position(m, d, b), position(m, d, a)))


@inlined
def relative_axes(m, d, a, b):
    """Rotation matrix from marker b's axes to a's."""
    return al.mat_mat(al.transpose(axes(m, d, a)), axes(m, d, b))


@inlined
def relative_velocity(m, d, a, b):
    """Velocity of marker b's origin as seen from a, in a's axes (m/s): d/dt of relative_position."""
    swept = point_velocity(m, d, m.marker_body[a], position(m, d, b))
    return al.matT_vec(axes(m, d, a), al.sub(velocity(m, d, b), swept))


@inlined
def relative_angular_velocity(m, d, a, b):
    """Angular velocity of marker b relative to a, in a's axes (rad/s)."""
    return al.matT_vec(axes(m, d, a), al.sub(angular_velocity(m, d, b), angular_velocity(m, d, a)))


@inlined
def relative_angular_acceleration(m, d, a, b):
    """d/dt of relative_angular_velocity (rad/s2, in a's axes); needs alpha of the bodies."""
    w_a = angular_velocity(m, d, a)
    turned = al.sub(al.vec3(d.alpha, m.marker_body[b]), al.vec3(d.alpha, m.marker_body[a]))
    return al.matT_vec(axes(m, d, a), al.sub(turned, al.cross(w_a, angular_velocity(m, d, b))))


@inlined
def relative_acceleration(m, d, a, b):
    """Acceleration of marker b's origin as seen from a, in a's axes (m/s2): second derivative of relative_position."""
    body_a = m.marker_body[a]
    r = position(m, d, b)
    w_a = al.vec3(d.w, body_a)
    seen = al.sub(velocity(m, d, b), point_velocity(m, d, body_a, r))
    total = al.sub(point_acceleration(m, d, m.marker_body[b], r), point_acceleration(m, d, body_a, r))
    return al.matT_vec(axes(m, d, a), al.sub(total, al.scale(2.0, al.cross(w_a, seen))))


@inlined
def power(m, d, k, moment, force):
    """Power (W) of a wrench (inertial axes) on marker k's body at the marker's origin."""
    return al.dot(moment, angular_velocity(m, d, k)) + al.dot(force, velocity(m, d, k))


@inlined
def power_between(m, d, a, b, moment, force):
    """Power (W) of a wrench (a's axes) on marker b, its reaction on the point of a's body that is there."""
    turning = al.dot(moment, relative_angular_velocity(m, d, a, b))
    return turning + al.dot(force, relative_velocity(m, d, a, b))
