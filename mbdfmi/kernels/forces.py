"""Force elements: each adds a wrench on a marker or an effort in a joint, and knows its energy.

All need kinematics; `apply` adds to what `inertias` began with weight.
"""

import math

from . import algebra as al
from . import coordinates, markers
from .language import inlined, kernel


@inlined
def strut(m, d, k):
    """Spring-damper k between two markers: (length m, direction from first to second in O, tension N).

    At zero length it has no direction and pulls nowhere.
    """
    a = m.strut_from[k]
    b = m.strut_to[k]
    span = al.sub(markers.position(m, d, b), markers.position(m, d, a))
    length = al.norm(span)
    direction = al.scale(1.0 / length if length > 0.0 else 0.0, span)
    rate = al.dot(direction, al.sub(markers.velocity(m, d, b), markers.velocity(m, d, a)))
    tension = m.strut_stiffness[k] * (length - m.strut_rest[k]) + m.strut_damping[k] * rate
    return length, direction, tension


@inlined
def swing_twist(A):
    """A rotation as a swing after a twist about z: ((rx, ry, rz) rad, G).

    A = exp(skew(rx, ry, 0)) Rz(rz); G maps the rates (rx', ry', rz') to the angular velocity, in the axes
    that A leads to: columns 1 and 2 of the left Jacobian of the exponential, and the swung z axis.
    """
    E = al.matrix_E(A)
    E = al.E_scale(-1.0 if E[3] < 0.0 else 1.0, E)
    n = math.sqrt(E[2] * E[2] + E[3] * E[3])
    twist = (0.0, 0.0, E[2] / n, E[3] / n) if n > 0.0 else (0.0, 0.0, 0.0, 1.0)
    S = al.E_product(E, al.E_conjugate(twist))
    s = math.sqrt(S[0] * S[0] + S[1] * S[1])
    angle = 2.0 * math.atan2(s, n)
    stretch = angle / s if s > 1e-9 else 2.0
    x = stretch * S[0]
    y = stretch * S[1]

    # J = 1 + b phi~ + c phi~^2 for phi = (x, y, 0)
    if angle > 1e-3:
        b = (1.0 - math.cos(angle)) / (angle * angle)
        c = (angle - math.sin(angle)) / (angle * angle * angle)
    else:
        b = 0.5 - angle * angle / 24.0
        c = 1.0 / 6.0 - angle * angle / 120.0

    columns = (
        (1.0 - c * y * y, c * x * y, -b * y),
        (c * x * y, 1.0 - c * x * x, b * x),
        (2.0 * S[1] * S[3], -2.0 * S[0] * S[3], 1.0 - 2.0 * (S[0] * S[0] + S[1] * S[1])),
    )
    return (x, y, 2.0 * math.atan2(twist[2], twist[3])), columns


@inlined
def moment_of_swing_twist(columns, Q):
    """The moment whose power on G (rx', ry', rz') is Q . (rx', ry', rz'): G^T moment = Q."""
    g0, g1, g2 = columns
    c0 = al.cross(g1, g2)
    c1 = al.cross(g2, g0)
    c2 = al.cross(g0, g1)
    sum_ = al.axpy(Q[0], c0, al.axpy(Q[1], c1, al.scale(Q[2], c2)))
    return al.scale(1.0 / al.dot(g0, c0), sum_)


@inlined
def six_rows(p, k, row, a, b):
    """Element `row` of the 6x6 matrix k of p times (a, b)."""
    j = 36 * k + 6 * row
    return (
        p[j] * a[0] + p[j + 1] * a[1] + p[j + 2] * a[2] + p[j + 3] * b[0] + p[j + 4] * b[1] + p[j + 5] * b[2]
    )


@inlined
def six_times(p, k, a, b):
    """The 6x6 matrix k of p times (a, b), as two vectors."""
    return (
        (six_rows(p, k, 0, a, b), six_rows(p, k, 1, a, b), six_rows(p, k, 2, a, b)),
        (six_rows(p, k, 3, a, b), six_rows(p, k, 4, a, b), six_rows(p, k, 5, a, b)),
    )


@inlined
def linear_displacement(m, d, k):
    """Displacement of linear force k: (d m, (rx, ry, rz) rad, G) in the first marker's axes."""
    a = m.linear_from[k]
    b = m.linear_to[k]
    turned, columns = swing_twist(markers.relative_axes(m, d, a, b))
    return markers.relative_position(m, d, a, b), turned, columns


@inlined
def linear_wrench(m, d, k):
    """Wrench of linear force k on the second marker: (moment N m, force N), inertial axes.

    Stiffness and preload are generalised forces along (d, rx, ry, rz), so a symmetric stiffness keeps
    energy at any angle; damping acts on the relative velocities.
    """
    a = m.linear_from[k]
    b = m.linear_to[k]
    moved, turned, columns = linear_displacement(m, d, k)
    force, Q = six_times(m.linear_stiffness, k, moved, turned)
    force = al.sub(al.vec3(m.linear_preload, 2 * k), force)
    Q = al.sub(al.vec3(m.linear_preload, 2 * k + 1), Q)
    drag, drag_moment = six_times(
        m.linear_damping, k, markers.relative_velocity(m, d, a, b), markers.relative_angular_velocity(m, d, a, b)
    )
    moment = al.sub(moment_of_swing_twist(columns, Q), drag_moment)
    A = markers.axes(m, d, a)
    return al.mat_vec(A, moment), al.mat_vec(A, al.sub(force, drag))


@kernel
def apply(m, d):
    """Add all force elements and inputs to tau, moment and force."""
    for v in range(m.n_v):
        d.tau[v] = 0.0

    for k in range(m.n_joint_spring):
        c = m.joint_spring_coordinate[k]
        stretch = coordinates.value(m, d, c) - m.joint_rest[k]
        effort = m.joint_stiffness[k] * stretch + m.joint_damping[k] * coordinates.rate(m, d, c)
        coordinates.add_effort(m, d, c, -effort)

    for k in range(m.n_effort_input):
        coordinates.add_effort(m, d, m.effort_coordinate[k], d.input[m.effort_u[k]])

    for k in range(m.n_strut):
        a = m.strut_from[k]
        b = m.strut_to[k]
        length, direction, tension = strut(m, d, k)
        pull = al.scale(tension, direction)
        markers.add_wrench(m, d, m.marker_body[a], markers.position(m, d, a), al.ZERO3, pull)
        markers.add_wrench(m, d, m.marker_body[b], markers.position(m, d, b), al.ZERO3, al.neg(pull))

    for k in range(m.n_linear):
        b = m.linear_to[k]
        r = markers.position(m, d, b)
        moment, force = linear_wrench(m, d, k)
        markers.add_wrench(m, d, m.marker_body[b], r, moment, force)

        # the reaction acts at the material point that is there now
        markers.add_wrench(m, d, m.marker_body[m.linear_from[k]], r, al.neg(moment), al.neg(force))

    for k in range(m.n_wrench_input):
        b = m.wrench_marker[k]
        force = al.ZERO3
        moment = al.ZERO3

        if m.wrench_force[k] >= 0:
            force = al.vec_at(d.input, m.wrench_force[k])

        if m.wrench_moment[k] >= 0:
            moment = al.vec_at(d.input, m.wrench_moment[k])

        if m.wrench_axes[k] >= 0:
            A = markers.axes(m, d, m.wrench_axes[k])
            force = al.mat_vec(A, force)
            moment = al.mat_vec(A, moment)

        r = markers.position(m, d, b)
        markers.add_wrench(m, d, m.marker_body[b], r, moment, force)

        if m.wrench_reaction[k] >= 0:
            markers.add_wrench(m, d, m.marker_body[m.wrench_reaction[k]], r, al.neg(moment), al.neg(force))


@kernel
def spring_energy(m, d):
    """Energy (J) stored in all force elements; a preload's energy is zero at zero displacement."""
    energy = 0.0

    for k in range(m.n_joint_spring):
        stretch = coordinates.value(m, d, m.joint_spring_coordinate[k]) - m.joint_rest[k]
        energy += 0.5 * m.joint_stiffness[k] * stretch * stretch

    for k in range(m.n_strut):
        length, direction, tension = strut(m, d, k)
        stretch = length - m.strut_rest[k]
        energy += 0.5 * m.strut_stiffness[k] * stretch * stretch

    for k in range(m.n_linear):
        moved, turned, columns = linear_displacement(m, d, k)
        force, Q = six_times(m.linear_stiffness, k, moved, turned)
        energy += 0.5 * (al.dot(moved, force) + al.dot(turned, Q))
        energy -= al.dot(al.vec3(m.linear_preload, 2 * k), moved)
        energy -= al.dot(al.vec3(m.linear_preload, 2 * k + 1), turned)

    return energy
