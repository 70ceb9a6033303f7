"""Round members in water that a current and waves move (docs/theory.md 16.19): Morison's formula.

A member has equal sections, with two Gauss points each on what of them is under water. For each length 1/2 rho D C_D |u_n| u_n, u the
velocity of the water less that of the point, u_n its part across the axis, and of waves rho pi D^2 / 4 (1 + C_A) a_n, a the water's
acceleration; on the discs at wet ends 1/2 rho pi D^2 / 4 C_A |u_a| u_a along the axis, the pressure of waves, and rho pi D^3 / 12 of the
water's acceleration along it. What follows the member's own acceleration is added mass, a row of the six by six.
"""

import math

from ..language import apart, inlined
from ..math import algebra as al
from ..motion import markers
from ..signatures import DATA, MODEL, Tuple, float64, int64
from . import stations, waves
from .stations import HERE

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
def water(m, d, when, n, r):
    """(velocity m/s, acceleration m/s2, pressure of waves by density m2/s2) of the water at r (m, in O).

    n : station whose waves are felt there, HERE: those of r, else below 0: none.
    """
    if n == HERE:
        p = stations.here(m, d, r[0], r[1], r[2])
        return al.add(current_at(m, r[2]), (p[0], p[1], p[2])), (p[4], p[5], p[6]), p[3]

    if n < 0:
        return current_at(m, r[2]), al.ZERO3, 0.0

    v, a = stations.moves(m, d, when, n)
    return al.add(current_at(m, r[2]), v), a, stations.value(m, d, when, n, stations.PRESSURE)[0]


@inlined
def station(first, j):
    """Station j of a member whose first is that, or what stands in its place."""
    return first + j if first >= 0 else first


@inlined
def level(m, d, when, n, r):
    """z of the surface (m) at r: that of the waves at its station n where the water's motion reaches up to them, else 0."""
    if n == HERE and m.sea_water[3] != 0.0:
        return waves.elevation(m, d, d.now[0], r[0], r[1])

    if n < 0 or m.sea_water[3] == 0.0:
        return 0.0

    return stations.value(m, d, when, n, stations.ELEVATION)[0]


@inlined
def act(m, d, i, r, f, load):
    """A load (moment, force, power), and that of the force f (N) at r on body i."""
    moment, force, power = load
    arm = al.sub(r, al.vec3(d.r, i))
    power += al.dot(f, markers.point_velocity(m, d, i, r))
    return al.add(moment, al.cross(arm, f)), al.add(force, f), power


@inlined
def along_length(m, d, k, when, n, i, r, axis):
    """Force by length (N/m) of the water at the point r of member k on body i; n : its station."""
    D = m.member_value[5 * k]
    v, a, pressure = water(m, d, when, n, r)
    u = al.sub(v, markers.point_velocity(m, d, i, r))
    u_n = al.axpy(-al.dot(u, axis), axis, u)
    f = al.scale(0.5 * m.member_density[k] * D * m.member_value[5 * k + 1] * al.norm(u_n), u_n)
    added = m.member_value[5 * k + 3]

    if n != -1 and added >= 0.0:
        a_n = al.axpy(-al.dot(a, axis), axis, a)
        f = al.axpy(0.25 * m.member_density[k] * math.pi * D * D * (1.0 + added), a_n, f)

    return f


@inlined
def on_end(m, d, k, when, n, i, r, axis, side):
    """Force (N) on the disc at the wet end r of member k; side : 1 at the first end, -1 at the second."""
    D = m.member_value[5 * k]
    v, a, pressure = water(m, d, when, n, r)
    disc = 0.25 * m.member_density[k] * math.pi * D * D
    u_a = al.dot(al.sub(v, markers.point_velocity(m, d, i, r)), axis)
    f = 0.5 * disc * m.member_value[5 * k + 2] * abs(u_a) * u_a

    if n != -1 and m.member_value[5 * k + 3] >= 0.0:
        f += side * disc * pressure
        f += disc * D / 3.0 * m.member_value[5 * k + 4] * al.dot(a, axis)

    return al.scale(f, axis)


@apart(FORCES(MODEL, DATA, int64))
def drag(m, d, k):
    """Of the water on member k about its body's origin: moment N m, force N, inertial axes, and the power on it W."""
    i = m.marker_body[m.member_from[k]]
    start = markers.position(m, d, m.member_from[k])
    end = markers.position(m, d, m.member_to[k])
    way = al.sub(end, start)
    length = al.norm(way)
    axis = al.scale(1.0 / length, way)
    sections = m.member_sections[k]
    first = m.member_station[k]
    when = ((0, 0, 0, 0), 0.0)
    load = (al.ZERO3, al.ZERO3, 0.0)

    if first >= 0:
        when = stations.at_time(m, d, d.now[0])
    elif first == HERE:
        waves.ready(m, d)

    for j in range(sections):
        n = station(first, 2 * j)
        low = start[2] + way[2] * j / sections
        high = start[2] + way[2] * (j + 1) / sections
        surface = 0.0

        if first != -1:
            r = al.axpy((j + GAUSS) / sections, way, start)
            surface = level(m, d, when, n, r)
            r = al.axpy((j + 1.0 - GAUSS) / sections, way, start)
            surface = 0.5 * (surface + level(m, d, when, station(first, 2 * j + 1), r))

        begin, last = wet_part(low - surface, high - surface)

        for g in range(2 if begin < last else 0):
            part = begin + (last - begin) * (GAUSS if g == 0 else 1.0 - GAUSS)
            r = al.axpy((j + part) / sections, way, start)
            f = along_length(m, d, k, when, station(first, 2 * j + g), i, r, axis)
            load = act(m, d, i, r, al.scale(0.5 * (last - begin) * length / sections, f), load)

    for j in range(2):
        n = station(first, 2 * sections + j)
        r = start if j == 0 else end

        if r[2] <= level(m, d, when, n, r):
            load = act(m, d, i, r, on_end(m, d, k, when, n, i, r, axis, 1.0 - 2.0 * j), load)

    moment, force, power = load
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
    """W, that water takes; a current and waves may give some."""
    return -power(m, d)
