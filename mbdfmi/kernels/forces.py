"""Force elements: each adds a wrench on a marker or an effort in a joint, and knows its energy.

All need kinematics; `apply` adds to what `inertias` began with weight.
"""

import math

from numba.types import void

from . import algebra as al
from . import coordinates, gravity, markers, tables
from .language import apart, inlined, kernel
from .views import DATA, MODEL

# axes that damping and added mass of a 6x6 force are given in: the first marker's, those turned about its z axis by the second
# one's yaw, or the second one's own
FIRST = 0
HEADING = 1
BODY = 2


# springs and dampers, linear or by table


@inlined
def spring_effort(m, table, stiffness, rest, x):
    """What a spring bears at x."""
    if table >= 0:
        return tables.evaluate(m, table, x)[0]

    return stiffness * (x - rest)


@inlined
def stored_energy(m, table, stiffness, rest, x):
    """Energy (J) of a spring at x, zero at `rest`."""
    if table >= 0:
        return tables.integral(m, table, x) - tables.integral(m, table, rest)

    return 0.5 * stiffness * (x - rest) * (x - rest)


@inlined
def damper_effort(m, table, damping, rate):
    """What a damper bears at a rate."""
    if table >= 0:
        return tables.evaluate(m, table, rate)[0]

    return damping * rate


# in joints


@inlined
def friction_effort(m, k, rate):
    """Dry friction k against a rate: (coulomb + (static - coulomb) exp(-(rate / stribeck)^2)) sign + viscous rate.

    The sign is smooth, tanh(rate / smoothing): at rest the joint creeps under load at up to a few times that speed.
    """
    fade = rate / m.friction_stribeck[k]
    dry = m.friction_coulomb[k] + (m.friction_static[k] - m.friction_coulomb[k]) * math.exp(-fade * fade)
    return dry * math.tanh(rate / m.friction_smoothing[k]) + m.friction_viscous[k] * rate


@inlined
def stop_penetration(m, k, x):
    """How far x is beyond an end of stop k: positive beyond the upper one, negative beyond the lower one."""
    return max(0.0, x - m.stop_upper[k]) - max(0.0, m.stop_lower[k] - x)


@inlined
def stop_effort(m, k, x, rate):
    """What stop k bears: spring and damper while in touch. It pushes only."""
    beyond = stop_penetration(m, k, x)
    effort = m.stop_stiffness[k] * beyond + m.stop_damping[k] * rate

    if beyond > 0.0:
        return max(0.0, effort)

    if beyond < 0.0:
        return min(0.0, effort)

    return 0.0


@inlined
def joint_spring_efforts(m, d, k):
    """Efforts (N m or N) of joint spring k and of its damper along their coordinate."""
    c = m.joint_spring_coordinate[k]
    x = coordinates.value(m, d, c)
    spring = spring_effort(m, m.joint_spring_table[k], m.joint_stiffness[k], m.joint_rest[k], x)
    damper = damper_effort(m, m.joint_damper_table[k], m.joint_damping[k], coordinates.rate(m, d, c))
    return -spring, -damper


# between markers


@inlined
def strut(m, d, k):
    """Spring-damper k between two markers: (length m, its rate m/s, direction from first to second in O, tension N).

    At zero length it has no direction and pulls nowhere.
    """
    length, rate, direction = strut_motion(m, d, k)
    spring, damper, pulled = strut_tensions(m, d, k, length, rate)
    return length, rate, direction, spring + damper + pulled


@inlined
def strut_motion(m, d, k):
    """(length m, its rate m/s, direction from first to second in O) of strut k."""
    a = m.strut_from[k]
    b = m.strut_to[k]
    span = al.sub(markers.position(m, d, b), markers.position(m, d, a))
    length = al.norm(span)
    direction = al.scale(1.0 / length if length > 0.0 else 0.0, span)
    return length, al.dot(direction, al.sub(markers.velocity(m, d, b), markers.velocity(m, d, a))), direction


@inlined
def keep_start_lengths(m, d):
    """Lengths of all struts at the start; needs kinematics of it."""
    for k in range(m.n_strut):
        d.strut_start[k] = strut_motion(m, d, k)[0]


@inlined
def strut_rest(m, d, k):
    """Rest length (m) of strut k: where the scene leaves it open and nobody has set it, the length at the start."""
    slack = m.strut_slack[k] == 1 and m.strut_rest[k] == m.strut_told[k]
    return d.strut_start[k] if slack else m.strut_rest[k]


@inlined
def strut_tensions(m, d, k, length, rate):
    """Tensions (N) of strut k's spring, damper and input."""
    spring = spring_effort(m, m.strut_spring_table[k], m.strut_stiffness[k], strut_rest(m, d, k), length)
    damper = damper_effort(m, m.strut_damper_table[k], m.strut_damping[k], rate)
    return spring, damper, d.input[m.strut_u[k]] if m.strut_u[k] >= 0 else 0.0


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
def turned_axes(m, d, k, yaw):
    """Rotation to the first marker's axes of those that linear force k has its damping and added mass in. yaw : rz (rad)."""
    if m.linear_axes[k] == BODY:
        return markers.relative_axes(m, d, m.linear_from[k], m.linear_to[k])

    c = math.cos(yaw)
    s = math.sin(yaw)
    return ((c, -s, 0.0), (s, c, 0.0), (0.0, 0.0, 1.0))


@inlined
def linear_drag(m, d, k, yaw):
    """What the damping of linear force k takes off its wrench: (force N, moment N m), in the first marker's axes. yaw : rz (rad)."""
    a = m.linear_from[k]
    b = m.linear_to[k]
    v = markers.relative_velocity(m, d, a, b)
    w = markers.relative_angular_velocity(m, d, a, b)

    if m.linear_axes[k] == FIRST:
        return six_times(m.linear_damping, k, v, w)

    A = turned_axes(m, d, k, yaw)
    force, moment = six_times(m.linear_damping, k, al.matT_vec(A, v), al.matT_vec(A, w))
    return al.mat_vec(A, force), al.mat_vec(A, moment)


@inlined
def linear_wrench(m, d, k):
    """Wrench of linear force k on the second marker: (moment N m, force N), in the first one's axes.

    Stiffness and preload are generalised forces along (d, rx, ry, rz), so a symmetric stiffness keeps
    energy at any angle; damping acts on the relative velocities. Added mass is no part of it.
    """
    moved, turned, columns = linear_displacement(m, d, k)
    force, Q = six_times(m.linear_stiffness, k, moved, turned)
    force = al.sub(al.vec3(m.linear_preload, 2 * k), force)
    Q = al.sub(al.vec3(m.linear_preload, 2 * k + 1), Q)
    drag, drag_moment = linear_drag(m, d, k, turned[2])
    return al.sub(moment_of_swing_twist(columns, Q), drag_moment), al.sub(force, drag)


@inlined
def input_wrench(m, d, k):
    """Wrench input k now: (moment N m, force N), inertial axes."""
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

    return moment, force


@inlined
def table_vector(m, k, x):
    """The vector of the three tables from k on, at x."""
    return (tables.evaluate(m, k, x)[0], tables.evaluate(m, k + 1, x)[0], tables.evaluate(m, k + 2, x)[0])


@inlined
def load_wrench(m, d, k):
    """Load k now: (moment N m, force N), inertial axes."""
    force = al.vec3(m.load_force, k)
    moment = al.vec3(m.load_moment, k)

    if m.load_force_table[k] >= 0:
        force = table_vector(m, m.load_force_table[k], d.now[0])

    if m.load_moment_table[k] >= 0:
        moment = table_vector(m, m.load_moment_table[k], d.now[0])

    A = markers.axes(m, d, m.load_axes[k])
    return al.mat_vec(A, moment), al.mat_vec(A, force)


@apart(void(MODEL, DATA))
def apply(m, d):
    """Add all force elements and inputs to tau, moment and force."""
    for v in range(m.n_v):
        d.tau[v] = 0.0

    for k in range(m.n_coordinate):
        d.coordinate_effort[k] = 0.0

    for k in range(m.n_joint_spring):
        spring, damper = joint_spring_efforts(m, d, k)
        coordinates.add_effort(m, d, m.joint_spring_coordinate[k], spring + damper)

    for k in range(m.n_friction):
        c = m.friction_coordinate[k]
        coordinates.add_effort(m, d, c, -friction_effort(m, k, coordinates.rate(m, d, c)))

    for k in range(m.n_stop):
        c = m.stop_coordinate[k]
        effort = stop_effort(m, k, coordinates.value(m, d, c), coordinates.rate(m, d, c))
        coordinates.add_effort(m, d, c, -effort)

    for k in range(m.n_effort_input):
        coordinates.add_effort(m, d, m.effort_coordinate[k], d.input[m.effort_u[k]])

    for k in range(m.n_strut):
        a = m.strut_from[k]
        b = m.strut_to[k]
        length, rate, direction, tension = strut(m, d, k)
        pull = al.scale(tension, direction)
        markers.add_wrench(m, d, m.marker_body[a], markers.position(m, d, a), al.ZERO3, pull)
        markers.add_wrench(m, d, m.marker_body[b], markers.position(m, d, b), al.ZERO3, al.neg(pull))

    for k in range(m.n_linear):
        b = m.linear_to[k]
        r = markers.position(m, d, b)
        A = markers.axes(m, d, m.linear_from[k])
        moment, force = linear_wrench(m, d, k)
        moment = al.mat_vec(A, moment)
        force = al.mat_vec(A, force)
        markers.add_wrench(m, d, m.marker_body[b], r, moment, force)

        # the reaction acts at the material point that is there now
        markers.add_wrench(m, d, m.marker_body[m.linear_from[k]], r, al.neg(moment), al.neg(force))

    for k in range(m.n_wrench_input):
        b = m.wrench_marker[k]
        moment, force = input_wrench(m, d, k)
        r = markers.position(m, d, b)
        markers.add_wrench(m, d, m.marker_body[b], r, moment, force)

        if m.wrench_reaction[k] >= 0:
            markers.add_wrench(m, d, m.marker_body[m.wrench_reaction[k]], r, al.neg(moment), al.neg(force))

    for k in range(m.n_load):
        moment, force = load_wrench(m, d, k)
        b = m.load_marker[k]
        markers.add_wrench(m, d, m.marker_body[b], markers.position(m, d, b), moment, force)

    gravity.add_central_weight(m, d)


@kernel
def spring_energy(m, d):
    """Energy (J) stored in springs, stops and 6x6 forces; a preload's energy is zero at zero displacement."""
    energy = 0.0

    for k in range(m.n_joint_spring):
        x = coordinates.value(m, d, m.joint_spring_coordinate[k])
        energy += stored_energy(m, m.joint_spring_table[k], m.joint_stiffness[k], m.joint_rest[k], x)

    for k in range(m.n_stop):
        beyond = stop_penetration(m, k, coordinates.value(m, d, m.stop_coordinate[k]))
        energy += 0.5 * m.stop_stiffness[k] * beyond * beyond

    for k in range(m.n_strut):
        span = al.sub(markers.position(m, d, m.strut_to[k]), markers.position(m, d, m.strut_from[k]))
        length = al.norm(span)
        energy += stored_energy(m, m.strut_spring_table[k], m.strut_stiffness[k], strut_rest(m, d, k), length)

    for k in range(m.n_linear):
        moved, turned, columns = linear_displacement(m, d, k)
        force, Q = six_times(m.linear_stiffness, k, moved, turned)
        energy += 0.5 * (al.dot(moved, force) + al.dot(turned, Q))
        energy -= al.dot(al.vec3(m.linear_preload, 2 * k), moved)
        energy -= al.dot(al.vec3(m.linear_preload, 2 * k + 1), turned)

    return energy
