"""What can be asked for: kinds of outputs, about a body, a force or a pair of markers, how wide they are, what they need.

Their values are in output_values.py. The pair (a, b) stands for "marker b relative to a, in a's axes"; absolute quantities are relative to marker 0.
"""

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
