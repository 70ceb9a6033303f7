"""Powers (W) with which efforts, forces, inputs and prescribed motion work on the bodies.

The rate of the kinetic energy and that of weight is the sum of the powers of all joints, forces and inputs, and of the moving ground;
the rate of the total energy is that of what comes from outside (inputs, loads, drives) less what is dissipated.
"""

from . import algebra as al
from . import coordinates, drives, forces, markers, reactions, rows
from .language import inlined, kernel


@inlined
def of_wrench(m, d, b, moment, force):
    """Power of a wrench (inertial axes) on marker b's body at the marker's origin."""
    return al.dot(moment, markers.angular_velocity(m, d, b)) + al.dot(force, markers.velocity(m, d, b))


@inlined
def of_pair(m, d, a, b, moment, force):
    """Power of a wrench (a's axes) on marker b, its reaction on the point of a's body that is there."""
    turning = al.dot(moment, markers.relative_angular_velocity(m, d, a, b))
    return turning + al.dot(force, markers.relative_velocity(m, d, a, b))


@kernel
def of_joint(m, d, c):
    """Power of what acts along coordinate c but the drive: springs, dampers, friction, stops, inputs."""
    effort = 0.0
    rate = coordinates.rate(m, d, c)

    for k in range(m.n_joint_spring):
        if m.joint_spring_coordinate[k] == c:
            spring, damper = forces.joint_spring_efforts(m, d, k)
            effort += spring + damper

    for k in range(m.n_friction):
        if m.friction_coordinate[k] == c:
            effort -= forces.friction_effort(m, k, rate)

    for k in range(m.n_stop):
        if m.stop_coordinate[k] == c:
            effort -= forces.stop_effort(m, k, coordinates.value(m, d, c), rate)

    for k in range(m.n_effort_input):
        if m.effort_coordinate[k] == c:
            effort += d.input[m.effort_u[k]]

    return effort * rate


@inlined
def of_strut(m, d, k):
    """Power of spring-damper k between two markers."""
    length, rate, direction, tension = forces.strut(m, d, k)
    return -tension * rate


@inlined
def of_linear(m, d, k):
    """Power of linear force k, without its added mass, whose energy is part of the bodies'."""
    moment, force = forces.linear_wrench(m, d, k)
    return of_pair(m, d, m.linear_from[k], m.linear_to[k], moment, force)


@inlined
def of_load(m, d, k):
    """Power of load k."""
    moment, force = forces.load_wrench(m, d, k)
    return of_wrench(m, d, m.load_marker[k], moment, force)


@kernel
def of_loads(m, d):
    """Power of all loads."""
    power = 0.0

    for k in range(m.n_load):
        power += of_load(m, d, k)

    return power


@kernel
def of_inputs(m, d):
    """Power of all efforts, forces and moments that are inputs."""
    power = 0.0

    for k in range(m.n_effort_input):
        power += d.input[m.effort_u[k]] * coordinates.rate(m, d, m.effort_coordinate[k])

    for k in range(m.n_strut):
        if m.strut_u[k] >= 0:
            length, rate, direction = forces.strut_motion(m, d, k)
            power -= d.input[m.strut_u[k]] * rate

    for k in range(m.n_wrench_input):
        b = m.wrench_marker[k]
        moment, force = forces.input_wrench(m, d, k)
        power += of_wrench(m, d, b, moment, force)

        if m.wrench_reaction[k] >= 0:
            i = m.marker_body[m.wrench_reaction[k]]
            power -= al.dot(moment, al.vec3(d.w, i))
            power -= al.dot(force, markers.point_velocity(m, d, i, markers.position(m, d, b)))

    return power


@kernel
def of_drives(m, d):
    """Power of all drives of joints and of what moves the ground; needs find_joint_wrenches."""
    power = 0.0

    for k in range(m.n_drive):
        i = m.drive_body[k]

        if i >= 0 and m.drive_kind[k] < drives.GROUND_ACCELERATION:
            power += reactions.held_effort(m, d, i) * d.x[m.n_q + m.body_v[i]]
        elif i >= 0:
            power += al.dot(al.vec3(d.bias_moment, i), al.vec3(d.w, i))
            power += al.dot(al.vec3(d.bias_force, i), al.vec3(d.rd, i))

    for row in range(m.n_row):
        if m.row_kind[row] == rows.COUPLING and m.row_drive[row] >= 0:
            power += m.row_value[2 * row] * d.multiplier[row] * coordinates.rate(m, d, m.row_i[row])

    return power


@inlined
def swing_twist_rates(columns, w):
    """(rx', ry', rz') for an angular velocity: G^-1 w (see forces.swing_twist)."""
    g0, g1, g2 = columns
    c0 = al.cross(g1, g2)
    s = 1.0 / al.dot(g0, c0)
    return s * al.dot(c0, w), s * al.dot(al.cross(g2, g0), w), s * al.dot(al.cross(g0, g1), w)


@inlined
def dissipated_by_linear(m, d, k):
    """What linear force k takes by its damping, and by what is not symmetric in its stiffness K: x'.(K - K^T) x / 2."""
    a = m.linear_from[k]
    b = m.linear_to[k]
    v = markers.relative_velocity(m, d, a, b)
    w = markers.relative_angular_velocity(m, d, a, b)
    moved, turned, columns = forces.linear_displacement(m, d, k)
    drag, drag_moment = forces.linear_drag(m, d, k, turned[2])
    turning = swing_twist_rates(columns, w)
    force, Q = forces.six_times(m.linear_stiffness, k, moved, turned)
    force_rate, Q_rate = forces.six_times(m.linear_stiffness, k, v, turning)
    lost = al.dot(v, force) + al.dot(turning, Q) - al.dot(moved, force_rate) - al.dot(turned, Q_rate)
    return al.dot(drag, v) + al.dot(drag_moment, w) + 0.5 * lost


@kernel
def dissipated(m, d):
    """Power that is lost in dampers, friction, stops and damping."""
    power = 0.0

    for k in range(m.n_joint_spring):
        spring, damper = forces.joint_spring_efforts(m, d, k)
        power -= damper * coordinates.rate(m, d, m.joint_spring_coordinate[k])

    for k in range(m.n_friction):
        rate = coordinates.rate(m, d, m.friction_coordinate[k])
        power += forces.friction_effort(m, k, rate) * rate

    for k in range(m.n_stop):
        x = coordinates.value(m, d, m.stop_coordinate[k])
        rate = coordinates.rate(m, d, m.stop_coordinate[k])
        elastic = m.stop_stiffness[k] * forces.stop_penetration(m, k, x)
        power += (forces.stop_effort(m, k, x, rate) - elastic) * rate

    for k in range(m.n_strut):
        length, rate, direction = forces.strut_motion(m, d, k)
        spring, damper, pulled = forces.strut_tensions(m, d, k, length, rate)
        power += damper * rate

    for k in range(m.n_linear):
        power += dissipated_by_linear(m, d, k)

    return power
