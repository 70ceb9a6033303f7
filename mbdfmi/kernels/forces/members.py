"""Drag on round members in still water and current (docs/theory.md 16.19): Morison's term in the velocity.

Along the wet part of a member, in equal sections with two Gauss points each, 1/2 rho D C_D |u_n| u_n for each length, u the velocity of the
water less that of the point, u_n its part across the axis; on the discs at wet ends 1/2 rho pi D^2 / 4 C_A |u_a| u_a along it.
"""

import math

from ..language import apart, inlined
from ..math import algebra as al
from ..motion import markers
from ..signatures import DATA, MODEL, Tuple, float64, int64

# Gauss points of a unit interval
GAUSS = 0.21132486540518712

FORCES = Tuple((float64,) * 7)


@inlined
def current_at(m, z):
    """Velocity of the water (m/s) at z (m): a power law of the height over the bed."""
    if m.n_current == 0:
        return al.ZERO3

    v = al.vec3(m.current_velocity, 0)

    if m.current_profile[0] != 0.0:
        v = al.scale(math.pow(max(1.0 + min(z, 0.0) / m.current_profile[1], 0.0), m.current_profile[0]), v)

    return v


@inlined
def wet_part(lower, upper):
    """The part (first, last) from 0 to 1 of the way from one z to another that is under water; first >= last: none."""
    if lower <= 0.0:
        return 0.0, (1.0 if upper <= 0.0 else lower / (lower - upper))

    return (lower / (lower - upper) if upper < 0.0 else 1.0), 1.0


@inlined
def felt(m, d, i, r):
    """Velocity (m/s) of the water at r (m, in O) as body i's point there feels it."""
    return al.sub(current_at(m, r[2]), markers.point_velocity(m, d, i, r))


@apart(FORCES(MODEL, DATA, int64))
def drag(m, d, k):
    """Of the water on member k about its body's origin: moment N m, force N, inertial axes, and the power on it W."""
    i = m.marker_body[m.member_from[k]]
    origin = al.vec3(d.r, i)
    start = markers.position(m, d, m.member_from[k])
    end = markers.position(m, d, m.member_to[k])
    way = al.sub(end, start)
    length = al.norm(way)
    axis = al.scale(1.0 / length, way)
    first, last = wet_part(start[2], end[2])
    n = m.member_sections[k]
    D = m.member_value[3 * k]
    across = 0.25 * m.member_density[k] * D * m.member_value[3 * k + 1] * (last - first) * length / n
    along = 0.125 * m.member_density[k] * math.pi * D * D * m.member_value[3 * k + 2]
    force = al.ZERO3
    moment = al.ZERO3
    power = 0.0

    if first >= last:
        return 0.0, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0

    for j in range(2 * n):
        part = (j // 2 + (GAUSS if j % 2 == 0 else 1.0 - GAUSS)) / n
        r = al.axpy(first + (last - first) * part, way, start)
        u = felt(m, d, i, r)
        u_n = al.axpy(-al.dot(u, axis), axis, u)
        f = al.scale(across * al.norm(u_n), u_n)
        force = al.add(force, f)
        moment = al.add(moment, al.cross(al.sub(r, origin), f))
        power += al.dot(f, markers.point_velocity(m, d, i, r))

    for j in range(2):
        r = start if j == 0 else end

        if r[2] <= 0.0:
            u_a = al.dot(felt(m, d, i, r), axis)
            f = al.scale(along * abs(u_a) * u_a, axis)
            force = al.add(force, f)
            moment = al.add(moment, al.cross(al.sub(r, origin), f))
            power += al.dot(f, markers.point_velocity(m, d, i, r))

    return moment[0], moment[1], moment[2], force[0], force[1], force[2], power


@inlined
def add(m, d):
    """Their wrenches onto the bodies."""
    for k in range(m.n_member_drag):
        f = drag(m, d, k)
        i = m.marker_body[m.member_from[k]]
        al.add_vec3(d.moment, i, (f[0], f[1], f[2]))
        al.add_vec3(d.force, i, (f[3], f[4], f[5]))


@inlined
def power_of(m, d, k):
    """W, of the water on member k."""
    return drag(m, d, k)[6]


@inlined
def power(m, d):
    """W, on the bodies."""
    total = 0.0

    for k in range(m.n_member_drag):
        total += power_of(m, d, k)

    return total


@inlined
def dissipated(m, d):
    """W, that water takes; a current may give some."""
    return -power(m, d)
