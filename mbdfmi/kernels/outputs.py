"""Outputs: blocks of scalars, each of a kind, about a body, a force or a pair of markers.

The pair (a, b) stands for "marker b relative to a, in a's axes"; absolute quantities are relative to marker 0.
"""

import math

from . import forces
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
    sea,
    six_by_six,
    stops,
    struts,
    waves,
    wind_rotors,
)
from .language import inlined, kernel
from .math import algebra as al
from .motion import coordinates, markers

# of joint coordinate a
COORDINATE = 0
RATE = 1
ACCELERATION = 2
# of marker b relative to a, in a's axes
POSITION = 3
VELOCITY = 4
EULER_PARAMETERS = 5
ZYX = 6
OMEGA = 7
ALPHA = 8
LINEAR_ACCELERATION = 9
# of marker b relative to a, in b's own axes
VELOCITY_BODY = 10
OMEGA_BODY = 11
ALPHA_BODY = 12
LINEAR_ACCELERATION_BODY = 13
# of markers a and b
DISTANCE = 14
DISTANCE_RATE = 15
Z_ANGLE = 16
# of strut a
STRUT_LENGTH = 17
STRUT_RATE = 18
STRUT_FORCE = 19
# of reaction a, in the axes of its joint's first marker (b = 0) or second (1)
REACTION_FORCE = 20
REACTION_MOMENT = 21
# of joint coordinate a
DRIVE_EFFORT = 35
# of row a
MULTIPLIER = 22
# of the whole scene
CONSTRAINT_GAP = 23
CONSTRAINT_RATE = 24
KINETIC_ENERGY = 25
POTENTIAL_ENERGY = 26
TOTAL_ENERGY = 27
GRAVITY_ENERGY = 28
SPRING_ENERGY = 29
LINEAR_MOMENTUM = 30
ANGULAR_MOMENTUM = 31
CENTER_OF_MASS = 32
# of contact a: parameter b + 1
CONTACT_S = 33
CONTACT_RATE = 34
# of end frame a: its axis b (0 to 2: i, j, k), in the axes of its marker
END_FRAME_AXIS = 70
# of the stepper, since the start
STEPS = 36
REJECTED_STEPS = 37
EVALUATIONS = 38
ESTIMATED_ERROR = 39

# efforts along a joint's coordinate: of spring, damper, friction, stop, input a of their tables
SPRING_EFFORT = 40
DAMPER_EFFORT = 41
FRICTION_EFFORT = 42
STOP_EFFORT = 43
INPUT_EFFORT = 44
# of coupling row a along coordinate b, from 0
COUPLING_EFFORT = 45
# of marker b relative to a
ZYX_RATE = 46
# of strut a
STRUT_SPRING = 47
STRUT_DAMPER = 48
STRUT_INPUT = 49
STRUT_POWER = 50
# of linear force a
LINEAR_FORCE = 51
LINEAR_MOMENT = 52
LINEAR_ROTATION = 53
LINEAR_POWER = 54
# of load a
LOAD_POWER = 55
# of joint coordinate a, driven or not
JOINT_POWER = 56
DRIVEN_JOINT_POWER = 57
# of coordinate a that no drive moves
EFFORT = 64
# of the ground, node a
GROUND_FORCE = 58
GROUND_MOMENT = 59
# of contact a of surfaces, reaction b
CONTACT_POINT = 65
NORMAL_FORCE = 66
FRICTION_FORCE = 67
# of hull a
HULL_VOLUME = 71
HULL_CENTER = 72
WATERPLANE_AREA = 73
WATERPLANE_CENTER = 74
WATERPLANE_MOMENTS = 75
HULL_DRAUGHT = 76
HULL_FORCE = 77
HULL_MOMENT = 78
HULL_POWER = 79
# of line a, on its second end
LINE_TENSION = 80
LINE_ANCHOR_TENSION = 81
LINE_GROUNDED = 82
LINE_FORCE = 83
LINE_POWER = 84
# of radiation a and of excitation a, at their markers
RADIATION_FORCE = 85
RADIATION_MOMENT = 86
RADIATION_POWER = 87
EXCITATION_FORCE = 88
EXCITATION_MOMENT = 89
EXCITATION_POWER = 90
# of resistance a, at its marker
RESISTANCE_FORCE = 98
RESISTANCE_MOMENT = 99
RESISTANCE_POWER = 100
# of the sea at marker b
ELEVATION = 91
# of the wind's rotor a
ROTOR_THRUST = 92
ROTOR_TORQUE = 93
ROTOR_WIND = 94
ROTOR_POWER = 95
# of member a
MEMBER_FORCE = 96
MEMBER_POWER = 97
# of the whole scene
INPUTS_POWER = 60
LOADS_POWER = 61
DRIVES_POWER = 62
DISSIPATED_POWER = 63

VECTORS = {POSITION, VELOCITY, ZYX, OMEGA, ALPHA, LINEAR_ACCELERATION, VELOCITY_BODY, OMEGA_BODY, ALPHA_BODY}
VECTORS |= {LINEAR_ACCELERATION_BODY, REACTION_FORCE, REACTION_MOMENT, CONTACT_POINT, FRICTION_FORCE}
VECTORS |= {LINEAR_MOMENTUM, ANGULAR_MOMENTUM, CENTER_OF_MASS, ZYX_RATE, RESISTANCE_FORCE, RESISTANCE_MOMENT}
VECTORS |= {LINEAR_FORCE, LINEAR_MOMENT, LINEAR_ROTATION, GROUND_FORCE, GROUND_MOMENT, END_FRAME_AXIS}
VECTORS |= {HULL_CENTER, WATERPLANE_CENTER, WATERPLANE_MOMENTS, HULL_FORCE, HULL_MOMENT}
VECTORS |= {LINE_FORCE, RADIATION_FORCE, RADIATION_MOMENT, EXCITATION_FORCE, EXCITATION_MOMENT, MEMBER_FORCE}
WIDTH = {EULER_PARAMETERS: 4} | {kind: 3 for kind in VECTORS}

# what they need beside kinematics: bits of `output_needs`
NEED_INERTIAS = 1
NEED_ROWS = 2
NEED_ACCELERATIONS = 4
NEED_REACTIONS = 8

REACTS = {
    REACTION_FORCE,
    REACTION_MOMENT,
    DRIVE_EFFORT,
    DRIVEN_JOINT_POWER,
    GROUND_FORCE,
    GROUND_MOMENT,
    DRIVES_POWER,
    NORMAL_FORCE,
    FRICTION_FORCE,
}
ACCELERATES = {
    ACCELERATION,
    ALPHA,
    LINEAR_ACCELERATION,
    ALPHA_BODY,
    LINEAR_ACCELERATION_BODY,
    MULTIPLIER,
} | REACTS
ACCELERATES |= {COUPLING_EFFORT}
NEEDS = {
    NEED_INERTIAS: {
        KINETIC_ENERGY,
        POTENTIAL_ENERGY,
        TOTAL_ENERGY,
        GRAVITY_ENERGY,
        LINEAR_MOMENTUM,
        ANGULAR_MOMENTUM,
        CENTER_OF_MASS,
    },
    NEED_ROWS: {CONSTRAINT_GAP, CONSTRAINT_RATE},
    NEED_ACCELERATIONS: ACCELERATES,
    NEED_REACTIONS: REACTS,
}


def needs(kinds) -> int:
    """`output_needs` of some kinds."""
    return sum(bit for bit, some in NEEDS.items() if not some.isdisjoint(kinds))


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

    if kind == CONTACT_POINT:
        al.set_vec_at(y, at, on_surfaces.point_of(m, d, a, on))
        return

    _, force = reactions.reaction(m, d, b)
    pressing = al.dot(on.n, force)

    if kind == NORMAL_FORCE:
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
    if kind == SPRING_EFFORT or kind == DAMPER_EFFORT:
        spring, damper = joint_springs.efforts(m, d, a)
        return spring if kind == SPRING_EFFORT else damper

    if kind == FRICTION_EFFORT:
        return -friction.resistance(m, a, coordinates.rate(m, d, m.friction_coordinate[a]))

    if kind == STOP_EFFORT:
        return -stops.resisted(m, d, a)

    return d.input[m.effort_u[a]]


@inlined
def tension_in_strut(m, d, kind, a):
    """Tension of the spring, the damper or the input of strut a."""
    length, rate, direction = struts.motion(m, d, a)
    spring, damper, pulled = struts.tensions(m, d, a, length, rate)
    return spring if kind == STRUT_SPRING else (damper if kind == STRUT_DAMPER else pulled)


@kernel
def write_linear_output(m, d, kind, a, at, y):
    """An output of linear force a into y from `at` on."""
    if kind == LINEAR_POWER:
        y[at] = six_by_six.power_of(m, d, a)

    elif kind == LINEAR_ROTATION:
        moved, turned, columns = six_by_six.displacement(m, d, a)
        al.set_vec_at(y, at, turned)

    else:
        moment, force = six_by_six.wrench(m, d, a)
        al.set_vec_at(y, at, force if kind == LINEAR_FORCE else moment)


@kernel
def write_hull_output(m, d, kind, a, at, y):
    """An output of hull a into y from `at` on."""
    if kind == HULL_POWER:
        y[at] = hydrostatics.power_of(m, d, a)

    elif kind == HULL_DRAUGHT:
        y[at] = hydrostatics.draught(m, d, a)

    elif kind == HULL_FORCE or kind == HULL_MOMENT:
        moment, force = hydrostatics.wrench(m, d, a)
        al.set_vec_at(y, at, force if kind == HULL_FORCE else moment)

    elif kind == HULL_VOLUME:
        y[at] = hydrostatics.displaced(m, d, a)[0]

    elif kind == HULL_CENTER:
        al.set_vec_at(y, at, hydrostatics.center(m, d, a, hydrostatics.displaced(m, d, a)))

    else:
        area, center, moments = hydrostatics.waterplane(m, d, a)

        if kind == WATERPLANE_AREA:
            y[at] = area
        else:
            al.set_vec_at(y, at, center if kind == WATERPLANE_CENTER else moments)


@kernel
def write_line_output(m, d, kind, a, composite, at, y):
    """An output of line a, of several sections or not (1, 0), into y from `at` on."""
    if kind == LINE_POWER:
        y[at] = composite_lines.power_of(m, d, a) if composite else catenaries.power_of(m, d, a)
    elif kind == LINE_GROUNDED:
        y[at] = composite_lines.grounded(m, d, a) if composite else catenaries.grounded(m, d, a)
    else:
        end = 0 if kind == LINE_ANCHOR_TENSION else 1
        force = composite_lines.force_on(m, d, a, end) if composite else catenaries.force_on(m, d, a, end)
        if kind == LINE_FORCE:
            al.set_vec_at(y, at, force)
        else:
            y[at] = al.norm(force)


@kernel
def write_wave_output(m, d, kind, a, at, y):
    """An output of radiation, excitation or resistance a, or of the sea at marker a into y from `at` on."""
    if kind == ELEVATION:
        r = markers.position(m, d, a)
        waves.ready(m, d)
        y[at] = sea.elevation(m, d, r[0], r[1])

    elif kind == RADIATION_POWER or kind == EXCITATION_POWER:
        y[at] = radiation.power_of(m, d, a) if kind == RADIATION_POWER else waves.power_of(m, d, a)

    elif kind == RESISTANCE_POWER:
        y[at] = resistance.power_of(m, d, a)

    else:
        if kind >= RESISTANCE_FORCE:
            moment, force = resistance.wrench(m, d, a)
        else:
            of_radiation = kind == RADIATION_FORCE or kind == RADIATION_MOMENT
            moment, force = radiation.wrench(m, d, a) if of_radiation else waves.wrench(m, d, a)

        pulls = kind == RADIATION_FORCE or kind == EXCITATION_FORCE or kind == RESISTANCE_FORCE
        al.set_vec_at(y, at, force if pulls else moment)


@kernel
def write_rotor_output(m, d, kind, a, at, y):
    """An output of the wind's rotor a into y from `at` on."""
    if kind == ROTOR_POWER:
        y[at] = wind_rotors.power_of(m, d, a)
    else:
        U, thrust, torque, axis = wind_rotors.loads_on(m, d, a)
        y[at] = thrust if kind == ROTOR_THRUST else (torque if kind == ROTOR_TORQUE else U)


@kernel
def write_scene_output(m, d, kind, at, y):
    """An output of the whole scene into y from `at` on."""
    if kind == CONSTRAINT_GAP:
        y[at] = al.largest(d.row_gap, m.n_row)

    elif kind == CONSTRAINT_RATE:
        y[at] = al.largest(d.row_rate, m.n_row)

    elif kind == STEPS:
        y[at] = d.steps[0]

    elif kind == REJECTED_STEPS:
        y[at] = d.rejected[0]

    elif kind == EVALUATIONS:
        y[at] = d.evaluations[0]

    elif kind == ESTIMATED_ERROR:
        y[at] = m.tolerance[0] * d.error_sum[0]

    elif kind == LINEAR_MOMENTUM:
        _, linear = inertia.total_momentum(m, d)
        al.set_vec_at(y, at, linear)

    elif kind == ANGULAR_MOMENTUM:
        angular, _ = inertia.total_momentum(m, d)
        al.set_vec_at(y, at, angular)

    elif kind == INPUTS_POWER:
        y[at] = forces.supplied_by_inputs(m, d)

    elif kind == LOADS_POWER:
        y[at] = loads.power(m, d) + waves.power(m, d) + wind_rotors.power(m, d)

    elif kind == DRIVES_POWER:
        y[at] = reactions.power_of_drives(m, d)

    elif kind == DISSIPATED_POWER:
        y[at] = forces.dissipated(m, d)

    elif kind == CENTER_OF_MASS:
        al.set_vec_at(y, at, inertia.center_of_mass(m, d))

    else:
        energy = 0.0

        if kind == KINETIC_ENERGY or kind == TOTAL_ENERGY:
            energy += inertia.kinetic_energy(m, d)

        if kind != KINETIC_ENERGY and kind != SPRING_ENERGY:
            energy += (
                inertia.gravity_energy(m, d) + central_gravity.energy(m, d) + gravity_gradient.energy(m, d)
            )

        if kind != KINETIC_ENERGY and kind != GRAVITY_ENERGY:
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

        if kind == COORDINATE:
            y[at] = coordinates.value(m, d, a)

        elif kind == RATE:
            y[at] = coordinates.rate(m, d, a)

        elif kind == ACCELERATION:
            y[at] = coordinates.acceleration(m, d, a)

        elif kind == POSITION:
            al.set_vec_at(y, at, markers.relative_position(m, d, a, b))

        elif kind == VELOCITY:
            al.set_vec_at(y, at, markers.relative_velocity(m, d, a, b))

        elif kind == EULER_PARAMETERS:
            relative = al.E_product(al.E_conjugate(markers.E(m, d, a)), markers.E(m, d, b))
            al.set_E_at(y, at, relative)

        elif kind == ZYX:
            al.set_vec_at(y, at, al.matrix_zyx(markers.relative_axes(m, d, a, b)))

        elif kind == OMEGA:
            al.set_vec_at(y, at, markers.relative_angular_velocity(m, d, a, b))

        elif kind == ALPHA:
            al.set_vec_at(y, at, markers.relative_angular_acceleration(m, d, a, b))

        elif kind == LINEAR_ACCELERATION:
            al.set_vec_at(y, at, markers.relative_acceleration(m, d, a, b))

        elif kind == VELOCITY_BODY:
            al.set_vec_at(y, at, in_own_axes(m, d, a, b, markers.relative_velocity(m, d, a, b)))

        elif kind == OMEGA_BODY:
            al.set_vec_at(y, at, in_own_axes(m, d, a, b, markers.relative_angular_velocity(m, d, a, b)))

        elif kind == ALPHA_BODY:
            al.set_vec_at(y, at, in_own_axes(m, d, a, b, markers.relative_angular_acceleration(m, d, a, b)))

        elif kind == LINEAR_ACCELERATION_BODY:
            al.set_vec_at(y, at, in_own_axes(m, d, a, b, markers.relative_acceleration(m, d, a, b)))

        elif kind == DISTANCE:
            y[at] = al.norm(markers.relative_position(m, d, a, b))

        elif kind == DISTANCE_RATE:
            y[at] = distance_rate(m, d, a, b)

        elif kind == Z_ANGLE:
            y[at] = z_angle(m, d, a, b)

        elif kind == STRUT_LENGTH or kind == STRUT_RATE or kind == STRUT_FORCE:
            length, rate, direction, tension = struts.pull(m, d, a)
            y[at] = length if kind == STRUT_LENGTH else (rate if kind == STRUT_RATE else tension)

        elif kind == REACTION_FORCE or kind == REACTION_MOMENT:
            moment, force = reactions.reaction(m, d, a)
            seen = force if kind == REACTION_FORCE else moment

            if b == 1:
                seen = al.matT_vec(markers.relative_axes(m, d, m.reaction_from[a], m.reaction_to[a]), seen)

            al.set_vec_at(y, at, seen)

        elif kind == CONTACT_S:
            y[at] = d.z[m.end_frame_z[a] + b]

        elif kind == CONTACT_RATE:
            y[at] = touching.rates(m, d, a)[b]

        elif CONTACT_POINT <= kind <= FRICTION_FORCE:
            write_contact(m, d, kind, a, b, at, y)

        elif kind == END_FRAME_AXIS:
            tangent, binormal, normal = frames.axes_of(m, d, a)
            al.set_vec_at(y, at, tangent if b == 0 else (binormal if b == 1 else normal))

        elif kind == DRIVE_EFFORT:
            y[at] = reactions.drive_effort(m, d, a)

        elif kind == MULTIPLIER:
            y[at] = d.multiplier[a]

        elif SPRING_EFFORT <= kind <= INPUT_EFFORT:
            y[at] = effort_in_joint(m, d, kind, a)

        elif kind == COUPLING_EFFORT:
            y[at] = m.term_factor[m.row_term[a] + b] * d.multiplier[a]

        elif kind == ZYX_RATE:
            al.set_vec_at(y, at, zyx_rate(m, d, a, b))

        elif STRUT_SPRING <= kind <= STRUT_INPUT:
            y[at] = tension_in_strut(m, d, kind, a)

        elif kind == STRUT_POWER:
            y[at] = struts.power_of(m, d, a)

        elif LINEAR_FORCE <= kind <= LINEAR_POWER:
            write_linear_output(m, d, kind, a, at, y)

        elif HULL_VOLUME <= kind <= HULL_POWER:
            write_hull_output(m, d, kind, a, at, y)

        elif LINE_TENSION <= kind <= LINE_POWER:
            write_line_output(m, d, kind, a, b, at, y)

        elif RADIATION_FORCE <= kind <= ELEVATION or RESISTANCE_FORCE <= kind <= RESISTANCE_POWER:
            write_wave_output(m, d, kind, b if kind == ELEVATION else a, at, y)

        elif ROTOR_THRUST <= kind <= ROTOR_POWER:
            write_rotor_output(m, d, kind, a, at, y)

        elif kind == MEMBER_POWER or kind == LOAD_POWER:
            y[at] = members.power_of(m, d, a) if kind == MEMBER_POWER else loads.power_of(m, d, a)

        elif kind == MEMBER_FORCE:
            f = members.drag(m, d, a)
            al.set_vec_at(y, at, (f[3], f[4], f[5]))

        elif kind == JOINT_POWER or kind == DRIVEN_JOINT_POWER:
            y[at] = forces.power_along(m, d, a)

            if kind == DRIVEN_JOINT_POWER:
                y[at] += reactions.drive_effort(m, d, a) * coordinates.rate(m, d, a)

        elif kind == EFFORT:
            y[at] = forces.effort_along(m, d, a)

        elif kind == GROUND_FORCE or kind == GROUND_MOMENT:
            moment, force = reactions.on_ground(m, d, a)
            al.set_vec_at(y, at, force if kind == GROUND_FORCE else moment)

        else:
            write_scene_output(m, d, kind, at, y)
