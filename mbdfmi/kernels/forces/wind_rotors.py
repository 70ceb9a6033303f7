"""Wind on rotors whose thrust and torque coefficients are tables (docs/theory.md 16.18).

U is the wind less the velocity of the rotor's marker, along the marker's x axis; Omega the angular velocity of its body about that.
With the tip speed ratio Omega R / U and the blades' pitch: thrust 1/2 rho pi R^2 U^2 C_T along x, torque 1/2 rho pi R^3 U^2 C_Q about x.
Tables are bicubic cells of equal size; beyond their edges they hold. There is nothing without wind from behind the axis (U <= 0).
"""

import math

from ..language import inlined
from ..math import algebra as al
from ..motion import markers
from . import loads

# m, below which the wind falls no further
LOWEST = 0.1


@inlined
def wind_at(m, d, z):
    """Velocity of the wind (m/s, inertial axes) at a height (m)."""
    v = al.vec3(m.wind_velocity, 0)
    u = m.wind_u[0]

    if u >= 0:
        v = al.vec_at(d.input, u)

    # the power law of the boundary layer
    if m.wind_profile[0] != 0.0:
        v = al.scale(math.pow(max(z, LOWEST) / m.wind_profile[1], m.wind_profile[0]), v)

    # the same at all heights
    if m.n_gust > 0 and m.gust_table[0] >= 0:
        v = al.add(v, loads.table_vector(m, m.gust_table[0], d.now[0]))

    return v


@inlined
def cell_value(p, k, s, t):
    """The bicubic of 16 coefficients from element k of p on, at (s, t)."""
    return (
        (p[k] + t * (p[k + 1] + t * (p[k + 2] + t * p[k + 3])))
        + s * (p[k + 4] + t * (p[k + 5] + t * (p[k + 6] + t * p[k + 7])))
        + s * s * (p[k + 8] + t * (p[k + 9] + t * (p[k + 10] + t * p[k + 11])))
        + s * s * s * (p[k + 12] + t * (p[k + 13] + t * (p[k + 14] + t * p[k + 15])))
    )


@inlined
def coefficients(m, k, ratio, pitch):
    """(C_T, C_Q) of rotor k at a tip speed ratio and a pitch (rad)."""
    grid = 4 * k
    n = m.rotor_cells[2 * k]
    l = m.rotor_cells[2 * k + 1]
    x = min(max((ratio - m.rotor_grid[grid]) / m.rotor_grid[grid + 1], 0.0), float(n))
    y = min(max((pitch - m.rotor_grid[grid + 2]) / m.rotor_grid[grid + 3], 0.0), float(l))
    i = min(int(x), n - 1)
    j = min(int(y), l - 1)
    at = 32 * (m.rotor_cell[k] + l * i + j)
    return cell_value(m.cell_c, at, x - i, y - j), cell_value(m.cell_c, at + 16, x - i, y - j)


@inlined
def loads_on(m, d, k):
    """(U m/s, thrust N, torque N m, the marker's x axis) of rotor k."""
    b = m.wind_rotor_marker[k]
    A = markers.axes(m, d, b)
    axis = (A[0][0], A[1][0], A[2][0])
    r = markers.position(m, d, b)
    felt = al.sub(wind_at(m, d, r[2]), markers.velocity(m, d, b))
    U = al.dot(felt, axis)
    R = m.wind_rotor_value[3 * k]
    pitch = m.wind_rotor_value[3 * k + 2]

    if m.wind_rotor_u[k] >= 0:
        pitch = d.input[m.wind_rotor_u[k]]

    if U <= 0.0:
        return U, 0.0, 0.0, axis

    turning = al.dot(markers.angular_velocity(m, d, b), axis)
    thrust, torque = coefficients(m, k, turning * R / U, pitch)
    pressure = 0.5 * m.wind_rotor_value[3 * k + 1] * math.pi * R * R * U * U
    return U, pressure * thrust, pressure * R * torque, axis


@inlined
def add(m, d):
    """Their wrenches onto the bodies."""
    for k in range(m.n_wind_rotor):
        U, thrust, torque, axis = loads_on(m, d, k)
        b = m.wind_rotor_marker[k]
        r = markers.position(m, d, b)
        markers.add_wrench(m, d, m.marker_body[b], r, al.scale(torque, axis), al.scale(thrust, axis))


@inlined
def power_of(m, d, k):
    """W, of the wind on rotor k's body."""
    U, thrust, torque, axis = loads_on(m, d, k)
    return markers.power(m, d, m.wind_rotor_marker[k], al.scale(torque, axis), al.scale(thrust, axis))


@inlined
def power(m, d):
    """W, on the bodies."""
    total = 0.0

    for k in range(m.n_wind_rotor):
        total += power_of(m, d, k)

    return total


@inlined
def supplied(m, d):
    """W, all of it from the wind."""
    return power(m, d)
