"""Outputs: blocks of scalars, each of a kind of outputs.py."""

import math

from . import forces, outputs
from .dynamics import inertia, reactions
from .end_frames import frames, on_surfaces, touching
from .forces import (
    catenaries,
    central_gravity,
    composite_lines,
    friction,
    gravity_gradient,
    hydrostatics,
    joint_springs,
    loads,
    members,
    radiation,
    resistance,
    six_by_six,
    stops,
    struts,
    waves,
    wind_rotors,
)
from .language import inlined, kernel
from .math import algebra as al
from .motion import coordinates, markers


@inlined
def in_own_axes(m, d, a, b, v):
    """A vector in a's axes, in b's."""
    return al.matT_vec(markers.relative_axes(m, d, a, b), v)


@inlined
def distance_rate(m, d, a, b):
    """Rate of the distance between two markers' origins (m/s), 0 at zero distance."""
    span = markers.relative_position(m, d, a, b)
    length = al.norm(span)
    return al.dot(span, markers.relative_velocity(m, d, a, b)) / length if length > 0.0 else 0.0


@inlined
def z_angle(m, d, a, b):
    """Angle between two markers' z axes (rad), 0 to pi."""
    A = markers.relative_axes(m, d, a, b)
    return math.atan2(math.sqrt(A[0][2] * A[0][2] + A[1][2] * A[1][2]), A[2][2])


@kernel
def write_contact(m, d, kind, a, b, at, y):
    """Where the surfaces of contact a touch (m), or the forces there on the second body (N), in the first marker's axes."""
    on = on_surfaces.on_surface(m, d, a)

    if kind == outputs.CONTACT_POINT:
        al.set_vec_at(y, at, on_surfaces.point_of(m, d, a, on))
        return

    _, force = reactions.reaction(m, d, b)
    pressing = al.dot(on.n, force)

    if kind == outputs.NORMAL_FORCE:
        y[at] = pressing
    else:
        al.set_vec_at(y, at, al.axpy(-pressing, on.n, force))


@inlined
def zyx_rate(m, d, a, b):
    """(yaw', pitch', roll') of marker b relative to a (rad/s); at pitch = +-90 degrees, where there are none, with roll' = 0."""
    A = markers.relative_axes(m, d, a, b)
    w = markers.relative_angular_velocity(m, d, a, b)
    yaw, pitch, roll = al.matrix_zyx(A)
    c = math.cos(yaw)
    s = math.sin(yaw)
    along = c * w[0] + s * w[1]
    cos_pitch = math.sqrt(A[0][0] * A[0][0] + A[1][0] * A[1][0])
    rolling = along / cos_pitch if cos_pitch > 1e-12 else 0.0
    return w[2] - rolling * A[2][0], c * w[1] - s * w[0], rolling


@inlined
def effort_in_joint(m, d, kind, a):
    """Effort of spring, damper, friction, stop or input a along the coordinate that it acts on."""
    if kind == outputs.SPRING_EFFORT or kind == outputs.DAMPER_EFFORT:
        spring, damper = joint_springs.efforts(m, d, a)
        return spring if kind == outputs.SPRING_EFFORT else damper

    if kind == outputs.FRICTION_EFFORT:
        return -friction.resistance(m, a, coordinates.rate(m, d, m.friction_coordinate[a]))

    if kind == outputs.STOP_EFFORT:
        return -stops.resisted(m, d, a)

    return d.input[m.effort_u[a]]


@inlined
def tension_in_strut(m, d, kind, a):
    """Tension of the spring, the damper or the input of strut a."""
    length, rate, direction = struts.motion(m, d, a)
    spring, damper, pulled = struts.tensions(m, d, a, length, rate)
    return spring if kind == outputs.STRUT_SPRING else (damper if kind == outputs.STRUT_DAMPER else pulled)


@kernel
def write_linear_output(m, d, kind, a, at, y):
    """An output of linear force a into y from `at` on."""
    if kind == outputs.LINEAR_POWER:
        y[at] = six_by_six.power_of(m, d, a)

    elif kind == outputs.LINEAR_ROTATION:
        moved, turned, columns = six_by_six.displacement(m, d, a)
        al.set_vec_at(y, at, turned)

    else:
        moment, force = six_by_six.wrench(m, d, a)
        al.set_vec_at(y, at, force if kind == outputs.LINEAR_FORCE else moment)


@kernel
def write_hull_output(m, d, kind, a, at, y):
    """An output of hull a into y from `at` on."""
    if kind == outputs.HULL_POWER:
        y[at] = hydrostatics.power_of(m, d, a)

    elif kind == outputs.HULL_DRAUGHT:
        y[at] = hydrostatics.draught(m, d, a)

    elif kind == outputs.HULL_FORCE or kind == outputs.HULL_MOMENT:
        moment, force = hydrostatics.wrench(m, d, a)
        al.set_vec_at(y, at, force if kind == outputs.HULL_FORCE else moment)

    elif kind == outputs.HULL_VOLUME:
        y[at] = hydrostatics.displaced(m, d, a)[0]

    elif kind == outputs.HULL_CENTER:
        al.set_vec_at(y, at, hydrostatics.center(m, d, a, hydrostatics.displaced(m, d, a)))

    else:
        area, center, moments = hydrostatics.waterplane(m, d, a)

        if kind == outputs.WATERPLANE_AREA:
            y[at] = area
        else:
            al.set_vec_at(y, at, center if kind == outputs.WATERPLANE_CENTER else moments)


@kernel
def write_line_output(m, d, kind, a, composite, at, y):
    """An output of line a, of several sections or not (1, 0), into y from `at` on."""
    if kind == outputs.LINE_POWER:
        y[at] = composite_lines.power_of(m, d, a) if composite else catenaries.power_of(m, d, a)
    elif kind == outputs.LINE_GROUNDED:
        y[at] = composite_lines.grounded(m, d, a) if composite else catenaries.grounded(m, d, a)
    else:
        end = 0 if kind == outputs.LINE_ANCHOR_TENSION else 1
        force = composite_lines.force_on(m, d, a, end) if composite else catenaries.force_on(m, d, a, end)
        if kind == outputs.LINE_FORCE:
            al.set_vec_at(y, at, force)
        else:
            y[at] = al.norm(force)


@kernel
def write_wave_output(m, d, kind, a, at, y):
    """An output of radiation, excitation or resistance a, or of the sea at marker a into y from `at` on."""
    if kind == outputs.ELEVATION:
        r = markers.position(m, d, a)
        y[at] = waves.elevation(m, d, d.now[0], r[0], r[1])

    elif kind == outputs.RADIATION_POWER or kind == outputs.EXCITATION_POWER:
        y[at] = radiation.power_of(m, d, a) if kind == outputs.RADIATION_POWER else waves.power_of(m, d, a)

    elif kind == outputs.RESISTANCE_POWER:
        y[at] = resistance.power_of(m, d, a)

    else:
        if kind >= outputs.RESISTANCE_FORCE:
            moment, force = resistance.wrench(m, d, a)
        else:
            of_radiation = kind == outputs.RADIATION_FORCE or kind == outputs.RADIATION_MOMENT
            moment, force = radiation.wrench(m, d, a) if of_radiation else waves.wrench(m, d, a)

        pulls = (
            kind == outputs.RADIATION_FORCE
            or kind == outputs.EXCITATION_FORCE
            or kind == outputs.RESISTANCE_FORCE
        )
        al.set_vec_at(y, at, force if pulls else moment)


@kernel
def write_rotor_output(m, d, kind, a, at, y):
    """An output of the wind's rotor a into y from `at` on."""
    if kind == outputs.ROTOR_POWER:
        y[at] = wind_rotors.power_of(m, d, a)
    else:
        U, thrust, torque, axis = wind_rotors.loads_on(m, d, a)
        y[at] = thrust if kind == outputs.ROTOR_THRUST else (torque if kind == outputs.ROTOR_TORQUE else U)


@kernel
def write_scene_output(m, d, kind, at, y):
    """An output of the whole scene into y from `at` on."""
    if kind == outputs.CONSTRAINT_GAP:
        y[at] = al.largest(d.row_gap, m.n_row)

    elif kind == outputs.CONSTRAINT_RATE:
        y[at] = al.largest(d.row_rate, m.n_row)

    elif kind == outputs.STEPS:
        y[at] = d.steps[0]

    elif kind == outputs.REJECTED_STEPS:
        y[at] = d.rejected[0]

    elif kind == outputs.EVALUATIONS:
        y[at] = d.evaluations[0]

    elif kind == outputs.ESTIMATED_ERROR:
        y[at] = m.tolerance[0] * d.error_sum[0]

    elif kind == outputs.LINEAR_MOMENTUM:
        _, linear = inertia.total_momentum(m, d)
        al.set_vec_at(y, at, linear)

    elif kind == outputs.ANGULAR_MOMENTUM:
        angular, _ = inertia.total_momentum(m, d)
        al.set_vec_at(y, at, angular)

    elif kind == outputs.INPUTS_POWER:
        y[at] = forces.supplied_by_inputs(m, d)

    elif kind == outputs.LOADS_POWER:
        y[at] = loads.power(m, d) + waves.power(m, d) + wind_rotors.power(m, d)

    elif kind == outputs.DRIVES_POWER:
        y[at] = reactions.power_of_drives(m, d)

    elif kind == outputs.DISSIPATED_POWER:
        y[at] = forces.dissipated(m, d)

    elif kind == outputs.CENTER_OF_MASS:
        al.set_vec_at(y, at, inertia.center_of_mass(m, d))

    else:
        energy = 0.0

        if kind == outputs.KINETIC_ENERGY or kind == outputs.TOTAL_ENERGY:
            energy += inertia.kinetic_energy(m, d)

        if kind != outputs.KINETIC_ENERGY and kind != outputs.SPRING_ENERGY:
            energy += (
                inertia.gravity_energy(m, d) + central_gravity.energy(m, d) + gravity_gradient.energy(m, d)
            )

        if kind != outputs.KINETIC_ENERGY and kind != outputs.GRAVITY_ENERGY:
            energy += forces.stored_energy(m, d)

        y[at] = energy


@kernel
def write_outputs(m, d, y):
    """All outputs into y[n_y]. Needs kinematics, and what `output_needs` says."""
    if m.n_turned > 0:
        markers.turn_bodies(m, d)

    for k in range(m.n_output):
        kind = m.output_kind[k]
        a = m.output_a[k]
        b = m.output_b[k]
        at = m.output_y[k]

        if kind == outputs.COORDINATE:
            y[at] = coordinates.value(m, d, a)

        elif kind == outputs.RATE:
            y[at] = coordinates.rate(m, d, a)

        elif kind == outputs.ACCELERATION:
            y[at] = coordinates.acceleration(m, d, a)

        elif kind == outputs.POSITION:
            al.set_vec_at(y, at, markers.relative_position(m, d, a, b))

        elif kind == outputs.VELOCITY:
            al.set_vec_at(y, at, markers.relative_velocity(m, d, a, b))

        elif kind == outputs.EULER_PARAMETERS:
            relative = al.E_product(al.E_conjugate(markers.E(m, d, a)), markers.E(m, d, b))
            al.set_E_at(y, at, relative)

        elif kind == outputs.ZYX:
            al.set_vec_at(y, at, al.matrix_zyx(markers.relative_axes(m, d, a, b)))

        elif kind == outputs.OMEGA:
            al.set_vec_at(y, at, markers.relative_angular_velocity(m, d, a, b))

        elif kind == outputs.ALPHA:
            al.set_vec_at(y, at, markers.relative_angular_acceleration(m, d, a, b))

        elif kind == outputs.LINEAR_ACCELERATION:
            al.set_vec_at(y, at, markers.relative_acceleration(m, d, a, b))

        elif kind == outputs.VELOCITY_BODY:
            al.set_vec_at(y, at, in_own_axes(m, d, a, b, markers.relative_velocity(m, d, a, b)))

        elif kind == outputs.OMEGA_BODY:
            al.set_vec_at(y, at, in_own_axes(m, d, a, b, markers.relative_angular_velocity(m, d, a, b)))

        elif kind == outputs.ALPHA_BODY:
            al.set_vec_at(y, at, in_own_axes(m, d, a, b, markers.relative_angular_acceleration(m, d, a, b)))

        elif kind == outputs.LINEAR_ACCELERATION_BODY:
            al.set_vec_at(y, at, in_own_axes(m, d, a, b, markers.relative_acceleration(m, d, a, b)))

        elif kind == outputs.DISTANCE:
            y[at] = al.norm(markers.relative_position(m, d, a, b))

        elif kind == outputs.DISTANCE_RATE:
            y[at] = distance_rate(m, d, a, b)

        elif kind == outputs.Z_ANGLE:
            y[at] = z_angle(m, d, a, b)

        elif kind == outputs.STRUT_LENGTH or kind == outputs.STRUT_RATE or kind == outputs.STRUT_FORCE:
            length, rate, direction, tension = struts.pull(m, d, a)
            y[at] = (
                length if kind == outputs.STRUT_LENGTH else (rate if kind == outputs.STRUT_RATE else tension)
            )

        elif kind == outputs.REACTION_FORCE or kind == outputs.REACTION_MOMENT:
            moment, force = reactions.reaction(m, d, a)
            seen = force if kind == outputs.REACTION_FORCE else moment

            if b == 1:
                seen = al.matT_vec(markers.relative_axes(m, d, m.reaction_from[a], m.reaction_to[a]), seen)

            al.set_vec_at(y, at, seen)

        elif kind == outputs.CONTACT_S:
            y[at] = d.z[m.end_frame_z[a] + b]

        elif kind == outputs.CONTACT_RATE:
            y[at] = touching.rates(m, d, a)[b]

        elif outputs.CONTACT_POINT <= kind <= outputs.FRICTION_FORCE:
            write_contact(m, d, kind, a, b, at, y)

        elif kind == outputs.END_FRAME_AXIS:
            tangent, binormal, normal = frames.axes_of(m, d, a)
            al.set_vec_at(y, at, tangent if b == 0 else (binormal if b == 1 else normal))

        elif kind == outputs.DRIVE_EFFORT:
            y[at] = reactions.drive_effort(m, d, a)

        elif kind == outputs.MULTIPLIER:
            y[at] = d.multiplier[a]

        elif outputs.SPRING_EFFORT <= kind <= outputs.INPUT_EFFORT:
            y[at] = effort_in_joint(m, d, kind, a)

        elif kind == outputs.COUPLING_EFFORT:
            y[at] = m.term_factor[m.row_term[a] + b] * d.multiplier[a]

        elif kind == outputs.ZYX_RATE:
            al.set_vec_at(y, at, zyx_rate(m, d, a, b))

        elif outputs.STRUT_SPRING <= kind <= outputs.STRUT_INPUT:
            y[at] = tension_in_strut(m, d, kind, a)

        elif kind == outputs.STRUT_POWER:
            y[at] = struts.power_of(m, d, a)

        elif outputs.LINEAR_FORCE <= kind <= outputs.LINEAR_POWER:
            write_linear_output(m, d, kind, a, at, y)

        elif outputs.HULL_VOLUME <= kind <= outputs.HULL_POWER:
            write_hull_output(m, d, kind, a, at, y)

        elif outputs.LINE_TENSION <= kind <= outputs.LINE_POWER:
            write_line_output(m, d, kind, a, b, at, y)

        elif (
            outputs.RADIATION_FORCE <= kind <= outputs.ELEVATION
            or outputs.RESISTANCE_FORCE <= kind <= outputs.RESISTANCE_POWER
        ):
            write_wave_output(m, d, kind, b if kind == outputs.ELEVATION else a, at, y)

        elif outputs.ROTOR_THRUST <= kind <= outputs.ROTOR_POWER:
            write_rotor_output(m, d, kind, a, at, y)

        elif kind == outputs.MEMBER_POWER or kind == outputs.LOAD_POWER:
            y[at] = members.power_of(m, d, a) if kind == outputs.MEMBER_POWER else loads.power_of(m, d, a)

        elif kind == outputs.MEMBER_FORCE:
            f = members.drag(m, d, a)
            al.set_vec_at(y, at, (f[3], f[4], f[5]))

        elif kind == outputs.JOINT_POWER or kind == outputs.DRIVEN_JOINT_POWER:
            y[at] = forces.power_along(m, d, a)

            if kind == outputs.DRIVEN_JOINT_POWER:
                y[at] += reactions.drive_effort(m, d, a) * coordinates.rate(m, d, a)

        elif kind == outputs.EFFORT:
            y[at] = forces.effort_along(m, d, a)

        elif kind == outputs.GROUND_FORCE or kind == outputs.GROUND_MOMENT:
            moment, force = reactions.on_ground(m, d, a)
            al.set_vec_at(y, at, force if kind == outputs.GROUND_FORCE else moment)

        else:
            write_scene_output(m, d, kind, at, y)
