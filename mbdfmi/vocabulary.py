"""Words that a scene may use and an FMU shows: names, units, widths, descriptions.

Below scene and compiler: the one checks by them what may be written, the other makes variables of them.
Tables are by name, in the order in which messages and docs/scene.md list them.
"""

from typing import NamedTuple


class Quantity(NamedTuple):
    """A number or a vector that goes in or out.

    unit : key of `units.UNITS`; None without unit.
    words : what descriptions call it, by default its name.
    """

    name: str
    unit: str | None = None
    width: int = 1
    words: str = ""

    @property
    def shape(self) -> tuple[int, ...]:
        """() of a number, (n,) of a vector."""
        return (self.width,) if self.width > 1 else ()

    @property
    def text(self) -> str:
        """What descriptions call it."""
        return self.words or self.name.replace("_", " ")


def table(*quantities: Quantity) -> dict[str, Quantity]:
    """Quantities by name."""
    return {quantity.name: quantity for quantity in quantities}


# coordinates of joints


class Coordinate(NamedTuple):
    """What users call a coordinate of a joint (several, as a vector), its rate, and an effort along it."""

    position: Quantity
    rate: Quantity
    effort: Quantity


POSITION = Quantity("position", "m", 3)
VELOCITY = Quantity("velocity", "m/s", 3)
EULER_PARAMETERS = Quantity("euler_parameters", None, 4, "Euler parameters, scalar last,")
ZYX = Quantity("zyx", "rad", 3, "yaw, pitch, roll")
ZYX_RATE = Quantity("zyx_rate", "rad/s", 3, "rates of yaw, pitch, roll")
OMEGA = Quantity("omega", "rad/s", 3, "angular velocity")
ALPHA = Quantity("alpha", "rad/s2", 3, "angular acceleration")

ANGLE = Coordinate(Quantity("angle", "rad"), Quantity("speed", "rad/s"), Quantity("torque", "N.m"))
SLIDE = Coordinate(Quantity("position", "m"), Quantity("speed", "m/s"), Quantity("force", "N"))
ANGLE_BESIDE_SLIDE = ANGLE._replace(rate=Quantity("angular_speed", "rad/s"))
TWO_ANGLES = Coordinate(
    Quantity("angles", "rad", 2), Quantity("speeds", "rad/s", 2), Quantity("torques", "N.m", 2)
)
IN_PLANE = Coordinate(Quantity("position", "m", 2), Quantity("velocity", "m/s", 2), Quantity("force", "N", 2))
IN_SPACE = Coordinate(POSITION, VELOCITY, Quantity("force", "N", 3))
ORIENTATION = Coordinate(EULER_PARAMETERS, OMEGA, Quantity("torque", "N.m", 3))
FREE_ORIENTATION = ORIENTATION._replace(effort=Quantity("moment", "N.m", 3))


YAW_PITCH_ROLL = Coordinate(ZYX, ZYX_RATE, Quantity("torque", "N.m", 3))


def parameter_of(unit: str | None) -> Coordinate:
    """The parameter of a curve, whose unit that is."""
    rate, effort = {"m": ("m/s", "N"), "rad": ("rad/s", "N.m")}.get(unit or "", (None, None))
    return Coordinate(Quantity("s", unit), Quantity("s_rate", rate), Quantity("effort", effort))


def acceleration_of(coordinate: Coordinate) -> Quantity:
    """The second rate of a joint's one coordinate."""
    unit = coordinate.position.unit
    name = "s_acceleration" if coordinate.position.name == "s" else "acceleration"
    return Quantity(name, f"{unit}/s2" if unit else None)


def coordinate_names(coordinates: tuple[Coordinate, ...]) -> list[str]:
    """Names of coordinates, each followed by that of its rate."""
    return [
        quantity.name for coordinate in coordinates for quantity in (coordinate.position, coordinate.rate)
    ]


# outputs of joints

ROTATION_OUTPUTS = table(EULER_PARAMETERS, ZYX, ZYX_RATE, OMEGA, ALPHA)
"""Of the second marker's orientation in the first."""

POSE_OUTPUTS = table(POSITION, VELOCITY, EULER_PARAMETERS, ZYX, ZYX_RATE, OMEGA)
"""Of the second marker's pose in the first."""

EFFORT_OUTPUTS = {
    "effort": "driver",
    "spring_effort": "spring",
    "damper_effort": "damper",
    "friction_effort": "friction",
    "stop_effort": "stop",
    "input_effort": "input",
    "driver_effort": "driver",
}
"""Efforts along a joint's coordinate on its second marker, N or N m: each of one of the joint's keys."""

POSE_EFFORTS = table(
    Quantity("driver_force", "N", 3, "force of the driver along x, y, z of the first marker"),
    Quantity("driver_torque", "N.m", 3, "torque of the driver about the axes of yaw, pitch, roll"),
)
"""Of a joint whose six coordinates are driven, on its second marker, each along its coordinate."""

REACTIONS = table(
    Quantity("reaction_force", "N", 3, "force"),
    Quantity("reaction_moment", "N.m", 3, "moment about the second marker's origin"),
    Quantity("reaction_force_body", "N", 3, "force"),
    Quantity("reaction_moment_body", "N.m", 3, "moment about the second marker's origin"),
)
"""What a joint does to its second marker, in the first one's axes, or (_body) in its own."""

PARAMETERS = table(Quantity("s", words="parameter"), Quantity("s_rate", words="rate of the parameter"))
"""Of a curve or a surface, whose units those of its parameters are."""

PARAMETER_EFFORTS = table(
    Quantity("effort", words="effort of the driver"),
    Quantity("driver_power", "W", words="power of the driver"),
)
"""Along the parameter of a curve where that is driven, in its unit: N of a length, N m of an angle."""

END_FRAME_AXES = table(
    Quantity("tangent", None, 3, "unit tangent"),
    Quantity("binormal", None, 3, "unit binormal"),
    Quantity("normal", None, 3, "unit normal"),
)
"""Axes i, j, k of an end frame on a curve or surface."""


CONTACT_OUTPUTS = table(
    Quantity("contact_point", "m", 3, "point of contact, in the first marker's axes from its origin,"),
    Quantity(
        "normal_force",
        "N",
        words="force with which the surfaces press on each other, negative where they would part,",
    ),
    Quantity(
        "friction_force",
        "N",
        3,
        "force on the second body that keeps it from slipping, in the first marker's axes,",
    ),
)
"""Where two surfaces touch, and what one does there to the other."""

# outputs of bodies, markers, measures, the ground

MARKER_OUTPUTS = table(
    Quantity("position", "m", 3, "position in the inertial frame"),
    Quantity("velocity", "m/s", 3, "velocity in the inertial frame"),
    Quantity("acceleration", "m/s2", 3, "acceleration in the inertial frame"),
    Quantity("euler_parameters", None, 4, "Euler parameters in the inertial frame, scalar last"),
    Quantity("zyx", "rad", 3, "yaw, pitch, roll in the inertial frame"),
    Quantity("zyx_rate", "rad/s", 3, "rates of yaw, pitch, roll in the inertial frame"),
    Quantity("omega", "rad/s", 3, "angular velocity in the inertial frame"),
    Quantity("alpha", "rad/s2", 3, "angular acceleration in the inertial frame"),
    Quantity("velocity_body", "m/s", 3, "velocity in its own axes"),
    Quantity("acceleration_body", "m/s2", 3, "acceleration in its own axes"),
    Quantity("omega_body", "rad/s", 3, "angular velocity in its own axes"),
    Quantity("alpha_body", "rad/s2", 3, "angular acceleration in its own axes"),
    Quantity("elevation", "m", words="elevation of the undisturbed sea at the place"),
)

MARKER_INPUTS = table(Quantity("force", "N", 3), Quantity("moment", "N.m", 3))

MEASURES = table(
    Quantity("distance", "m"),
    Quantity("distance_rate", "m/s", words="rate of the distance"),
    Quantity("angle", "rad", words="angle between the z axes"),
    POSITION,
    VELOCITY,
    Quantity("acceleration", "m/s2", 3),
    EULER_PARAMETERS,
    ZYX,
    ZYX_RATE,
    OMEGA,
)
"""Of one marker seen from another."""

GROUND_OUTPUTS = table(
    Quantity("reaction_force", "N", 3, "force"),
    Quantity("reaction_moment", "N.m", 3, "moment about its origin"),
)

GROUND_INPUTS = table(
    POSITION,
    VELOCITY,
    Quantity("acceleration", "m/s2", 3),
    Quantity("euler_parameters", None, 4, "Euler parameters"),
    Quantity("zyx", "rad", 3, "yaw, pitch and roll"),
    OMEGA,
    ALPHA,
)
"""What may be told of the motion of the ground."""

# outputs of forces and couplings

STRUT_INPUT = Quantity("force", "N")

STRUT_OUTPUTS = table(
    Quantity("length", "m"),
    Quantity("rate", "m/s", words="rate of the length"),
    Quantity("force", "N", words="tension"),
    Quantity("tension", "N"),
    Quantity("spring_force", "N", words="tension of the spring"),
    Quantity("damper_force", "N", words="tension of the damper"),
    Quantity("input_force", "N", words="tension that the input gives"),
    Quantity("power", "W", words="power on the bodies"),
)

TORSION_OUTPUTS = table(
    Quantity("angle", "rad", words="angle about the common z axis"),
    Quantity("rate", "rad/s", words="rate of the angle"),
    Quantity("moment", "N.m", words="moment on the second marker about z"),
    Quantity("spring_moment", "N.m", words="moment of the spring"),
    Quantity("damper_moment", "N.m", words="moment of the damper"),
    Quantity("power", "W", words="power on the bodies"),
)

SIX_BY_SIX_OUTPUTS = table(
    Quantity("force", "N", 3, "force on the second marker, in the first one's axes"),
    Quantity("moment", "N.m", 3, "moment on the second marker about its origin, in the first one's axes"),
    Quantity("displacement", "m", 3, "position of the second marker in the first"),
    Quantity("rotation", "rad", 3, "angles rx, ry, rz of the second marker from the first"),
    Quantity("power", "W", words="power on the bodies"),
)
"""Of a linear force and of a bushing."""

LOAD_OUTPUTS = table(Quantity("power", "W"))

HYDROSTATICS_OUTPUTS = table(
    Quantity("volume", "m3", words="displaced volume"),
    Quantity("center_of_buoyancy", "m", 3, "centre of the displaced volume in the inertial frame"),
    Quantity("draught", "m", words="depth of the lowest point"),
    Quantity("waterplane_area", "m2", words="area of the waterplane"),
    Quantity("waterplane_center", "m", 3, "centre of the waterplane in the inertial frame"),
    Quantity(
        "waterplane_moments",
        "m4",
        3,
        "second moments of the waterplane about its centre (of y^2, of x^2, of x y), in inertial axes",
    ),
    Quantity("force", "N", 3, "force of the water in the inertial frame"),
    Quantity("moment", "N.m", 3, "moment of the water about the marker's origin, in the inertial frame"),
    Quantity("power", "W", words="power on the body"),
)

LINE_OUTPUTS = table(
    Quantity("tension", "N", words="tension at the second end"),
    Quantity("anchor_tension", "N", words="tension at the first end"),
    Quantity("grounded_length", "m", words="length on the bed"),
    Quantity("force", "N", 3, "force on the second end in the inertial frame"),
    Quantity("power", "W", words="power on the bodies"),
)

HYDRODYNAMICS_OUTPUTS = table(
    Quantity("radiation_force", "N", 3, "force of the waves that the body makes, in the inertial frame"),
    Quantity(
        "radiation_moment", "N.m", 3, "moment of these about the marker's origin, in the inertial frame"
    ),
    Quantity("radiation_power", "W", words="power of these on the body"),
    Quantity("excitation_force", "N", 3, "force of the sea's waves in the inertial frame"),
    Quantity(
        "excitation_moment", "N.m", 3, "moment of these about the marker's origin, in the inertial frame"
    ),
    Quantity("excitation_power", "W", words="power of these on the body"),
    Quantity(
        "damping_force", "N", 3, "force of linear and quadratic damping beside waves, in the inertial frame"
    ),
    Quantity("damping_moment", "N.m", 3, "moment of these about the marker's origin, in the inertial frame"),
    Quantity("damping_power", "W", words="power of these on the body"),
)

SEA_OUTPUTS = table(Quantity("elevation", "m", words="elevation of the undisturbed sea at the origin"))

EXCITATION_FORCE = Quantity("excitation_force", "N", 3)
EXCITATION_MOMENT = Quantity("excitation_moment", "N.m", 3)

ROTOR_PITCH = Quantity("pitch", "rad")
WIND_VELOCITY = Quantity("velocity", "m/s", 3)

ROTOR_OUTPUTS = table(
    Quantity("thrust", "N", words="thrust along the axis"),
    Quantity("torque", "N.m", words="torque of the wind about the axis"),
    Quantity("wind", "m/s", words="wind along the axis that the moving hub feels"),
    Quantity("power", "W", words="power of the wind on the body"),
)

MEMBER_OUTPUTS = table(
    Quantity("force", "N", 3, "force of the water in the inertial frame"),
    Quantity("power", "W", words="power of the water on the body"),
)

COUPLING_OUTPUTS = table(Quantity("efforts", words="effort"))
"""Along the coordinates of its joints, one each, in their units."""

# outputs of the whole

SCENE_OUTPUTS = table(
    Quantity("kinetic_energy", "J"),
    Quantity("potential_energy", "J", words="potential energy of weight, springs, stops and preloads"),
    Quantity("total_energy", "J", words="kinetic and potential energy"),
    Quantity("gravity_energy", "J", words="potential energy of weight"),
    Quantity("spring_energy", "J", words="potential energy of springs, stops and preloads"),
    Quantity("input_power", "W", words="power of all inputs that are efforts, forces or moments"),
    Quantity("load_power", "W", words="power of all loads"),
    Quantity("driver_power", "W", words="power of all drivers and of what moves the ground"),
    Quantity("dissipated_power", "W", words="power lost in dampers, friction, stops and damping"),
    Quantity("linear_momentum", "kg.m/s", 3, "linear momentum, that of added mass included"),
    Quantity(
        "angular_momentum",
        "kg.m2/s",
        3,
        "angular momentum about the inertial origin, that of added mass included",
    ),
    Quantity("center_of_mass", "m", 3, "centre of mass of all bodies"),
    Quantity("constraint_gap", words="largest error of the constraints' positions (m, rad)"),
    Quantity("constraint_rate", words="largest error of the constraints' velocities (m/s, rad/s)"),
    Quantity("multipliers", words="multiplier of a row"),
)

SOLVER_OUTPUTS = table(
    Quantity("steps", words="accepted inner steps since the start"),
    Quantity("rejected_steps", words="rejected inner steps since the start"),
    Quantity("evaluations", words="evaluations of the accelerations since the start"),
    Quantity(
        "estimated_error", words="estimated local errors of the inner steps since the start, summed; relative"
    ),
)
