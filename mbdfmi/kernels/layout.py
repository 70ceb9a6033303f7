"""The one table that names every array of a model: its buffer, its shape and what it holds.

A model is flat buffers: `ints` (structure) and `reals` (parameters and constants), an instance adds
`state`, `work` (scratch) and the inputs `u`. The head of `ints` holds the counts below, then the offset of
every array in its buffer. To add a quantity is to add one row; kernels then read `m.name` or `d.name`.

Frames: O is the inertial frame. "Body" below is a node of the spanning tree: the user's bodies that fixed
joints hold together. Body 0 is the ground. The origin of a body's frame lies on the joint to its parent and
its z axis is the joint's axis (revolute, prismatic). All spatial quantities of `d` are expressed in inertial
axes and taken about the origin of their body.
"""

from typing import NamedTuple

from .status import MOST_NOTICES

COUNTS = (
    "n_body",  # nodes of the tree, the ground included
    "n_q",  # position coordinates
    "n_v",  # velocity coordinates
    "n_z",  # other states: parameters of end frames, angles of joints outside the tree, memories of waves made
    "n_x",  # integrated states: n_q + n_v + n_z
    "n_solid",  # the user's bodies, each fixed in a node
    "n_marker",
    "n_coordinate",  # joint coordinates that something refers to
    "n_turn",  # those that are angles of joints outside the tree
    "n_rotor",  # rotors that turn with joints of one freedom
    "n_joint_spring",
    "n_friction",  # joint coordinates with dry friction
    "n_stop",  # joint coordinates with bump stops
    "n_strut",  # spring-dampers between two markers
    "n_six_by_six",  # 6x6 forces between two markers
    "n_wrench_input",
    "n_effort_input",
    "n_load",  # wrenches on a marker, constant or over time
    "n_central",  # 1: central gravity
    "n_hull",  # closed hulls that water carries
    "n_hull_vertex",
    "n_polygon",  # their faces
    "n_corner",  # corners of these
    "n_line",  # catenaries between two markers
    "n_radiation",  # memories of the waves that bodies make
    "n_memory",  # their states
    "n_excitation",  # what waves do to bodies
    "n_part",  # components of that
    "n_sea_wave",  # components of the sea
    "n_current",  # 1: the sea has a current
    "n_member_drag",  # members that water drags at
    "n_wind",  # 1: wind
    "n_wind_rotor",  # rotors in it
    "n_cell",  # pieces of their tables
    "n_constraint",  # joints that close loops, rolling, couplings
    "n_row",  # their scalar equations
    "n_term",  # joint coordinates in couplings and in drives of joints that close loops
    "n_path",  # nodes between the constraints and the ground, summed
    "n_response",  # values of all rows' responses in the joints between
    "n_neighbour",  # pairs of neighbours: constraints that share joints, or come to in the factor by fill
    "n_factor",  # values of the factor of the rows' inverse inertia
    "n_table",  # piecewise polynomials
    "n_knot",  # their knots
    "n_drive",  # joints whose motion is prescribed, the ground's too
    "n_wave",  # harmonics of their motions
    "n_command",  # numbers of their motion that inputs tell (motion/commands.py)
    "n_attitude",  # 1: inputs tell orientation and angular velocity of the ground
    "n_curve",
    "n_surface",
    "n_patch",  # bicubic pieces of surfaces
    "n_end_frame",  # joints of end frames on curves and surfaces
    "n_s",  # their parameters
    "n_told",  # start values that the user gave
    "n_reaction",  # joints whose reactions go out
    "n_output",  # blocks of outputs
    "n_turned",  # bodies, where Euler parameters are among the outputs, else 0
    "n_u",  # scalar inputs
    "n_y",  # scalar outputs
    "output_needs",  # see outputs.py
    "integrator",  # see steppers/integrate.py
    "embeds",  # 1: dynamics by the joint-space mass matrix (dynamics/embedding.py), 0: by articulated bodies
    "n_mass",  # elements of that matrix
    "n_stage",  # values of the stages of a step (mbdfmi/steppers.py)
    "n_dense",  # values of a continuous extension, or of the stages of the step before
    "n_jacobian",  # values of dx'/dx, with room for what fills in, where an implicit stepper may need it
    "n_swap",  # rows of that
    "n_block",  # blocks of these rows (compiler/jacobian.py)
    "n_element",  # parts of rows of blocks, each in one column of blocks
    "n_column",  # those that are there before fill, by columns
    "n_colour",  # groups of columns that no row has two of
    "n_member",  # blocks in these
)


class Array(NamedTuple):
    """One array: `width` numbers for each of `count`; `over`: it lies over that array and those that follow."""

    name: str
    buffer: str
    width: int
    count: str | int
    what: str
    over: str = ""


# one array a line, however long
# fmt: off
ARRAYS = (
    # structure
    Array("body_parent", "ints", 1, "n_body", "parent node; parents come first"),
    Array("body_joint", "ints", 1, "n_body", "kind of the joint to the parent (joints/kinds.py)"),
    Array("body_q", "ints", 1, "n_body", "first position coordinate"),
    Array("body_v", "ints", 1, "n_body", "first velocity coordinate"),
    Array("body_added", "ints", 1, "n_body", "1: carries added mass"),
    Array("body_reversed", "ints", 1, "n_body", "1: the joint's first marker is on this body, not the parent"),
    Array("body_spins", "ints", 1, "n_body", "1: the start's angular velocity is kept in the second marker's axes, not the first's"),
    Array("v_given", "ints", 1, "n_v", "1: start position given, 2: start velocity given, 3: both"),
    Array("body_drive", "ints", 1, "n_body", "drive of its joint, -1: none"),
    Array("body_rotor", "ints", 1, "n_body", "rotor that turns with its joint, -1: none"),
    Array("rotor_body", "ints", 1, "n_rotor", "node whose joint it turns with"),
    Array("solid_body", "ints", 1, "n_solid", "node"),
    Array("marker_body", "ints", 1, "n_marker", "node"),
    Array("coordinate_kind", "ints", 1, "n_coordinate", "see motion/coordinates.py"),
    Array("coordinate_body", "ints", 1, "n_coordinate", "node, of a joint in the tree"),
    Array("coordinate_from", "ints", 1, "n_coordinate", "first marker, of a joint that closes a loop"),
    Array("coordinate_to", "ints", 1, "n_coordinate", "second marker"),
    Array("coordinate_turn", "ints", 1, "n_coordinate", "where an angle outside the tree stands among these, -1: it is none"),
    Array("coordinate_end_frame", "ints", 1, "n_coordinate", "end frame whose parameter it is, -1: it is none"),
    Array("turn_coordinate", "ints", 1, "n_turn", "coordinate"),
    Array("joint_spring_coordinate", "ints", 1, "n_joint_spring", "coordinate it acts along"),
    Array("joint_spring_table", "ints", 1, "n_joint_spring", "table of its effort over the coordinate, -1: linear"),
    Array("joint_damper_table", "ints", 1, "n_joint_spring", "table of its effort over the rate, -1: linear"),
    Array("friction_coordinate", "ints", 1, "n_friction", "coordinate it acts along"),
    Array("stop_coordinate", "ints", 1, "n_stop", "coordinate it acts along"),
    Array("strut_from", "ints", 1, "n_strut", "first marker"),
    Array("strut_to", "ints", 1, "n_strut", "second marker"),
    Array("strut_spring_table", "ints", 1, "n_strut", "table of its tension over length, -1: linear"),
    Array("strut_damper_table", "ints", 1, "n_strut", "table of its tension over the rate of length, -1: linear"),
    Array("strut_u", "ints", 1, "n_strut", "input that adds to its tension, -1: none"),
    Array("strut_slack", "ints", 1, "n_strut", "1: its rest length is its length at the start, unless another is set"),
    Array("six_by_six_from", "ints", 1, "n_six_by_six", "first marker, whose axes the force is given in"),
    Array("six_by_six_to", "ints", 1, "n_six_by_six", "second marker, which the force acts on"),
    Array("six_by_six_adds", "ints", 1, "n_six_by_six", "1: has added mass, and its second marker is on a body that moves"),
    Array("six_by_six_axes", "ints", 1, "n_six_by_six", "axes of damping and added mass: of the first marker, heading, second (forces/six_by_six.py)"),
    Array("wrench_marker", "ints", 1, "n_wrench_input", "marker it acts on"),
    Array("wrench_reaction", "ints", 1, "n_wrench_input", "marker whose body takes the reaction, -1: none"),
    Array("wrench_axes", "ints", 1, "n_wrench_input", "marker in whose axes it is given, -1: inertial"),
    Array("wrench_force", "ints", 1, "n_wrench_input", "first of the force's 3 inputs, -1: none"),
    Array("wrench_moment", "ints", 1, "n_wrench_input", "first of the moment's 3 inputs, -1: none"),
    Array("effort_coordinate", "ints", 1, "n_effort_input", "coordinate it acts along"),
    Array("effort_u", "ints", 1, "n_effort_input", "input"),
    Array("load_marker", "ints", 1, "n_load", "marker it acts on"),
    Array("central_gradient", "ints", 1, "n_central", "1: its gradient acts on bodies by their inertia"),
    Array("load_axes", "ints", 1, "n_load", "marker in whose axes it is given, 0: inertial"),
    Array("load_force_table", "ints", 1, "n_load", "first of 3 tables over time, -1: none"),
    Array("load_moment_table", "ints", 1, "n_load", "first of 3 tables over time, -1: none"),
    Array("hull_marker", "ints", 1, "n_hull", "marker that it is fixed to"),
    Array("hull_vertex", "ints", 1, "n_hull", "first vertex"),
    Array("hull_vertices", "ints", 1, "n_hull", "number of these"),
    Array("hull_polygon", "ints", 1, "n_hull", "first polygon"),
    Array("hull_polygons", "ints", 1, "n_hull", "number of these"),
    Array("polygon_corner", "ints", 1, "n_polygon", "first corner"),
    Array("polygon_corners", "ints", 1, "n_polygon", "number of these"),
    Array("corner_vertex", "ints", 1, "n_corner", "vertex, turning left seen from outside"),
    Array("line_from", "ints", 1, "n_line", "first marker, the anchor of one with a bed"),
    Array("line_to", "ints", 1, "n_line", "second marker"),
    Array("line_bed", "ints", 1, "n_line", "1: it may lie on a bed as high as its first marker"),
    Array("radiation_marker", "ints", 1, "n_radiation", "marker whose velocities make waves"),
    Array("radiation_memory", "ints", 1, "n_radiation", "first of its states"),
    Array("radiation_memories", "ints", 1, "n_radiation", "number of these"),
    Array("memory_mate", "ints", 1, "n_memory", "the other state of its pair, itself where it has none"),
    Array("excitation_marker", "ints", 1, "n_excitation", "marker at which waves act"),
    Array("excitation_part", "ints", 1, "n_excitation", "first of its components"),
    Array("excitation_parts", "ints", 1, "n_excitation", "number of these"),
    Array("member_from", "ints", 1, "n_member_drag", "first marker"),
    Array("member_to", "ints", 1, "n_member_drag", "second marker, on the same node"),
    Array("member_sections", "ints", 1, "n_member_drag", "sections with two points each"),
    Array("wind_u", "ints", 1, "n_wind", "first of the 3 inputs that tell its velocity, -1: none"),
    Array("wind_rotor_marker", "ints", 1, "n_wind_rotor", "marker about whose x axis it turns"),
    Array("wind_rotor_u", "ints", 1, "n_wind_rotor", "input that tells the blades' pitch, -1: none"),
    Array("rotor_cell", "ints", 1, "n_wind_rotor", "first piece of its tables, pitch runs fastest"),
    Array("rotor_cells", "ints", 2, "n_wind_rotor", "numbers of pieces along tip speed ratio and pitch"),
    Array("constraint_from", "ints", 1, "n_constraint", "first marker"),
    Array("constraint_to", "ints", 1, "n_constraint", "second marker"),
    Array("constraint_row", "ints", 1, "n_constraint", "first row"),
    Array("constraint_rows", "ints", 1, "n_constraint", "number of rows"),
    Array("constraint_path", "ints", 1, "n_constraint", "first of the nodes between it and the ground"),
    Array("constraint_paths", "ints", 1, "n_constraint", "number of these nodes"),
    Array("constraint_response", "ints", 1, "n_constraint", "first value of its first row's response"),
    Array("constraint_width", "ints", 1, "n_constraint", "values in a row's response"),
    Array("path_node", "ints", 1, "n_path", "node, ascending within a constraint"),
    Array("path_at", "ints", 1, "n_path", "where the node's joint stands in a row's response"),
    Array("row_constraint", "ints", 1, "n_row", "constraint"),
    Array("row_kind", "ints", 1, "n_row", "see dynamics/rows.py"),
    Array("row_i", "ints", 1, "n_row", "axis of the first marker, or component"),
    Array("row_j", "ints", 1, "n_row", "axis of the second marker, or end frame"),
    Array("row_term", "ints", 1, "n_row", "first of a coupling's terms"),
    Array("row_terms", "ints", 1, "n_row", "number of these, 0: no coupling"),
    Array("term_coordinate", "ints", 1, "n_term", "coordinate"),
    Array("row_drive", "ints", 1, "n_row", "drive of a coupling, -1: none"),
    Array("row_at_start", "ints", 1, "n_row", "1: a coupling's offset, or a distance, is that of the start"),
    Array("row_parallel", "ints", 1, "n_row", "part of what keeps markers' z axes (1) or all their axes (2) parallel; else 0"),
    Array("constraint_neighbour", "ints", 1, "n_constraint", "first of its neighbours before it"),
    Array("constraint_neighbours", "ints", 1, "n_constraint", "number of these"),
    Array("constraint_block", "ints", 1, "n_constraint", "its diagonal block in the factor, by rows"),
    Array("neighbour_constraint", "ints", 1, "n_neighbour", "neighbour, ascending"),
    Array("neighbour_block", "ints", 1, "n_neighbour", "block in the factor, by rows"),
    Array("table_knot", "ints", 1, "n_table", "first knot"),
    Array("table_knots", "ints", 1, "n_table", "number of knots"),
    Array("table_beyond", "ints", 1, "n_table", "beyond the ends, see math/tables.py"),
    Array("drive_kind", "ints", 1, "n_drive", "see motion/drives.py"),
    Array("drive_body", "ints", 1, "n_drive", "node"),
    Array("drive_at", "ints", 1, "n_drive", "first of its tables or waves"),
    Array("drive_terms", "ints", 1, "n_drive", "number of its waves or coefficients"),
    Array("drive_command", "ints", 1, "n_drive", "first of its channels of commands, -1: none"),
    Array("drive_commands", "ints", 1, "n_drive", "number of these; of the ground x, y, z, then those of its orientation"),
    Array("drive_turn", "ints", 2, "n_drive", "what commands the ground's orientation (motion/commands.py), first input of that"),
    Array("command_u", "ints", 3, "n_command", "inputs that tell position, speed, acceleration, -1: not told"),
    Array("command_angular", "ints", 1, "n_command", "1: an angle"),
    Array("curve_kind", "ints", 1, "n_curve", "see end_frames/curves.py"),
    Array("curve_table", "ints", 1, "n_curve", "first of a spline's three tables"),
    Array("surface_kind", "ints", 1, "n_surface", "see end_frames/surfaces.py"),
    Array("surface_curve", "ints", 1, "n_surface", "profile of a prism"),
    Array("surface_table", "ints", 2, "n_surface", "tables whose knots are the patches' edges"),
    Array("surface_patch", "ints", 1, "n_surface", "first patch, s2 runs fastest"),
    Array("end_frame_kind", "ints", 1, "n_end_frame", "see end_frames/touching.py"),
    Array("end_frame_a", "ints", 1, "n_end_frame", "first marker"),
    Array("end_frame_b", "ints", 1, "n_end_frame", "second marker"),
    Array("end_frame_from", "ints", 1, "n_end_frame", "curve or surface of the first marker"),
    Array("end_frame_to", "ints", 1, "n_end_frame", "curve or surface of the second marker, -1: a point"),
    Array("end_frame_z", "ints", 1, "n_end_frame", "first parameter, of z"),
    Array("end_frame_given", "ints", 1, "n_end_frame", "1: start values of the parameters are given"),
    Array("told_kind", "ints", 1, "n_told", "see notes.py"),
    Array("told_at", "ints", 1, "n_told", "node, coordinate or parameter that it is about"),
    Array("told_to", "ints", 1, "n_told", "second marker, of a joint that closes a loop"),
    Array("told_component", "ints", 1, "n_told", "which of the joint's coordinates"),
    Array("told_place", "ints", 1, "n_told", "what a message calls it"),
    Array("stop_place", "ints", 1, "n_stop", "what a message calls its joint"),
    Array("reaction_from", "ints", 1, "n_reaction", "first marker, whose axes it is told in"),
    Array("reaction_to", "ints", 1, "n_reaction", "second marker, which it acts on"),
    Array("reaction_body", "ints", 1, "n_reaction", "node on the joint's far side, -1: it closes a loop"),
    Array("reaction_constraint", "ints", 1, "n_reaction", "constraint, where it closes a loop"),
    Array("reaction_input", "ints", 1, "n_reaction", "wrench input that the joint bears itself, -1: none"),
    Array("output_kind", "ints", 1, "n_output", "see outputs.py"),
    Array("output_a", "ints", 1, "n_output", "what it is about: node, marker or force"),
    Array("output_b", "ints", 1, "n_output", "second marker, where there is one"),
    Array("output_y", "ints", 1, "n_output", "first scalar output"),
    Array("place_x", "ints", 1, "n_swap", "where the unknowns stand in x, in the order of elimination"),
    Array("block_place", "ints", 1, "n_block", "first unknown in that order"),
    Array("block_size", "ints", 1, "n_block", "number of unknowns"),
    Array("block_element", "ints", 1, "n_block", "first element of its row, ascending"),
    Array("block_elements", "ints", 1, "n_block", "number of these"),
    Array("block_own", "ints", 1, "n_block", "that on the diagonal"),
    Array("block_column", "ints", 1, "n_block", "first of the elements in its column"),
    Array("block_columns", "ints", 1, "n_block", "number of these"),
    Array("element_block", "ints", 1, "n_element", "block in whose columns it is"),
    Array("element_first", "ints", 1, "n_element", "first of these columns"),
    Array("element_width", "ints", 1, "n_element", "number of these"),
    Array("element_value", "ints", 1, "n_element", "its values in J and in the factors, by rows"),
    Array("column_row", "ints", 1, "n_column", "block in whose rows it is"),
    Array("column_element", "ints", 1, "n_column", "element"),
    Array("colour_member", "ints", 1, "n_colour", "first of its blocks"),
    Array("colour_members", "ints", 1, "n_colour", "number of these"),
    Array("colour_width", "ints", 1, "n_colour", "columns of the widest"),
    Array("member_block", "ints", 1, "n_member", "block"),
    # parameters
    Array("gravity", "reals", 3, 1, "m/s2, in O"),
    Array("step", "reals", 1, 1, "s, fixed step"),
    Array("tolerance", "reals", 1, 1, "relative, adaptive step"),
    Array("absolute_tolerance", "reals", 1, 1, "m, rad, m/s, rad/s"),
    Array("max_step", "reals", 1, 1, "s"),
    Array("max_evaluations", "reals", 1, 1, "that a communication step may cost"),
    Array("solid_mass", "reals", 1, "n_solid", "kg"),
    Array("solid_com", "reals", 3, "n_solid", "m, centre of mass in the user's body frame"),
    Array("solid_inertia", "reals", 6, "n_solid", "kg m2 about the centre of mass, user's body axes (symmetric)"),
    Array("q_start", "reals", 1, "n_q", "position coordinates as the user gave them"),
    Array("v_start", "reals", 1, "n_v", "velocity coordinates as the user gave them"),
    Array("zyx_start", "reals", 3, "n_body", "rad, yaw, pitch, roll of an orientation: it counts where it is not zyx_told"),
    Array("closing_tolerance", "reals", 1, 1, "m, rad, largest gap of a closed loop"),
    Array("rotor_inertia", "reals", 1, "n_rotor", "kg m2, about its axis"),
    Array("rotor_ratio", "reals", 1, "n_rotor", "its speed by the joint's (rad/m on a prismatic joint)"),
    Array("joint_stiffness", "reals", 1, "n_joint_spring", "N m/rad or N/m"),
    Array("joint_rest", "reals", 1, "n_joint_spring", "rad or m, where its energy is zero"),
    Array("joint_damping", "reals", 1, "n_joint_spring", "N m s/rad or N s/m"),
    Array("friction_coulomb", "reals", 1, "n_friction", "N m or N, effort of sliding"),
    Array("friction_static", "reals", 1, "n_friction", "N m or N, effort of breaking loose"),
    Array("friction_stribeck", "reals", 1, "n_friction", "rad/s or m/s, speed of the fall from one to the other"),
    Array("friction_viscous", "reals", 1, "n_friction", "N m s/rad or N s/m"),
    Array("friction_smoothing", "reals", 1, "n_friction", "rad/s or m/s, speed below which the sign of the rate is smooth"),
    Array("stop_lower", "reals", 1, "n_stop", "rad or m, -inf: none"),
    Array("stop_upper", "reals", 1, "n_stop", "rad or m, inf: none"),
    Array("stop_stiffness", "reals", 1, "n_stop", "N m/rad or N/m"),
    Array("stop_damping", "reals", 1, "n_stop", "N m s/rad or N s/m, while in touch"),
    Array("strut_stiffness", "reals", 1, "n_strut", "N/m"),
    Array("strut_damping", "reals", 1, "n_strut", "N s/m"),
    Array("strut_rest", "reals", 1, "n_strut", "m, length at which its energy is zero; without force where it is linear"),
    Array("strut_told", "reals", 1, "n_strut", "m, the same as the scene tells it"),
    Array("six_by_six_stiffness", "reals", 36, "n_six_by_six", "6x6 by rows (x, y, z, rx, ry, rz)"),
    Array("six_by_six_damping", "reals", 36, "n_six_by_six", "6x6 by rows"),
    Array("six_by_six_added", "reals", 36, "n_six_by_six", "6x6 by rows, about the second marker"),
    Array("six_by_six_preload", "reals", 6, "n_six_by_six", "N, N m"),
    Array("load_force", "reals", 3, "n_load", "N"),
    Array("load_moment", "reals", 3, "n_load", "N m"),
    Array("central_mu", "reals", 1, "n_central", "m3/s2, weight -mu r / |r|^3 per mass"),
    Array("hull_density", "reals", 1, "n_hull", "kg/m3, of the water"),
    Array("line_length", "reals", 1, "n_line", "m, unstretched"),
    Array("line_mass", "reals", 1, "n_line", "kg/m, less that of the water displaced"),
    Array("line_stiffness", "reals", 1, "n_line", "N, tension by strain"),
    Array("current_velocity", "reals", 3, "n_current", "m/s, in O, at the surface"),
    Array("current_profile", "reals", 2, "n_current", "exponent of the height over the bed, depth (m)"),
    Array("member_value", "reals", 3, "n_member_drag", "diameter (m), drag coefficients across and along"),
    Array("member_density", "reals", 1, "n_member_drag", "kg/m3, of the water"),
    Array("wind_velocity", "reals", 3, "n_wind", "m/s, in O, at the height of reference"),
    Array("wind_profile", "reals", 2, "n_wind", "exponent of height, height of reference (m)"),
    Array("wind_rotor_value", "reals", 3, "n_wind_rotor", "radius (m), density of air (kg/m3), blades' pitch (rad)"),
    Array("row_value", "reals", 1, "n_row", "m: length, radius; or cosine of an angle"),
    Array("row_offset", "reals", 1, "n_row", "constant of a coupling"),
    Array("term_factor", "reals", 1, "n_term", "of the coordinate"),
    Array("drive_value", "reals", 16, "n_drive", "see motion/drives.py"),
    Array("wave_value", "reals", 3, "n_wave", "amplitude (m, rad), frequency (Hz), phase (rad)"),
    Array("s_start", "reals", 1, "n_s", "parameters of contacts as the user gave them"),
    Array("turn_start", "reals", 1, "n_turn", "rad, near which the angle starts"),
    # constants
    Array("zyx_told", "reals", 3, "n_body", "rad, yaw, pitch, roll of the start as the scene has it"),
    Array("told_value", "reals", 4, "n_told", "what was given where the joint closes a loop; of an orientation E"),
    Array("told_unit", "reals", 1, "n_told", "factor from SI units to those that it is told in"),
    Array("stop_unit", "reals", 1, "n_stop", "likewise"),
    Array("scene_length", "reals", 1, 1, "m, size of the parts"),
    Array("knot_x", "reals", 1, "n_knot", "argument of a table"),
    Array("knot_c", "reals", 6, "n_knot", "polynomial to the next knot, from here: 1, s, ..., s^5"),
    Array("knot_area", "reals", 1, "n_knot", "integral of the table from its first knot to here"),
    Array("curve_value", "reals", 1, "n_curve", "radius, coefficient, or period of a closed spline, 0: open"),
    Array("curve_side", "reals", 3, "n_curve", "a direction that the curve is never parallel to"),
    Array("curve_size", "reals", 1, "n_curve", "m, reach from its marker's origin, 0: without end"),
    Array("surface_value", "reals", 3, "n_surface", "radius, radius of the tube; semi-axes of what is round"),
    Array("patch_c", "reals", 48, "n_patch", "for x, y, z: coefficients of s1^i s2^j, j runs fastest"),
    Array("jacobian_work", "reals", 1, 1, "work of finding J, in evaluations"),
    Array("lu_work", "reals", 1, 1, "of the factors of both Newton matrices"),
    Array("solve_work", "reals", 1, 1, "of solving with both"),
    Array("body_r", "reals", 3, "n_body", "m, joint frame in the parent's frame"),
    Array("body_A", "reals", 9, "n_body", "joint axes to the parent's axes"),
    Array("solid_r", "reals", 3, "n_solid", "m, user's body frame in the node"),
    Array("solid_A", "reals", 9, "n_solid", "user's body axes to the node's"),
    Array("marker_r", "reals", 3, "n_marker", "m, in the node"),
    Array("marker_A", "reals", 9, "n_marker", "marker axes to the node's"),
    Array("memory_pole", "reals", 2, "n_memory", "1/s: rate by the state itself and by its mate"),
    Array("memory_from", "reals", 6, "n_memory", "rate by velocity and angular velocity of the marker, in inertial axes"),
    Array("memory_to", "reals", 6, "n_memory", "N, N m: the state times this is taken off force and moment"),
    Array("excitation_step", "reals", 1, "n_excitation", "s, from knot to knot"),
    Array("part_omega", "reals", 1, "n_part", "rad/s"),
    Array("part_force", "reals", 12, "n_part", "N, N m: real parts, then imaginary ones, of force and moment"),
    Array("sea_wave", "reals", 5, "n_sea_wave", "amplitude (m), frequency (rad/s), phase (rad), wave numbers along x and y (rad/m)"),
    Array("rotor_grid", "reals", 4, "n_wind_rotor", "first tip speed ratio and step, first pitch and step (rad)"),
    Array("cell_c", "reals", 32, "n_cell", "of C_T, then of C_Q: coefficients of s1^i s2^j, j runs fastest"),
    Array("vertex_r", "reals", 3, "n_hull_vertex", "m, in the axes of the hull's marker"),
    Array("x_nominal", "reals", 1, "n_x", "size that the states have, for integrators outside"),
    # state
    Array("time", "state", 2, 1, "s, time reached and the rounding left over from summing it"),
    Array("notices", "state", 1, 1, "notices not told yet (status.py)"),
    Array("notice", "state", 3, MOST_NOTICES, "status and two numbers of each"),
    Array("start_time", "state", 1, 1, "s"),
    Array("next_step", "state", 5, 1, "s, the step that rk54, rk853, rk32, radau, rkc try next, 0: none yet"),
    Array("method", "state", 1, 1, "stepper in use (steppers/integrate.py)"),
    Array("steps", "state", 1, 1, "accepted inner steps since the start"),
    Array("rejected", "state", 1, 1, "rejected inner steps since the start"),
    Array("evaluations", "state", 1, 1, "evaluations of the accelerations since the start"),
    Array("error_sum", "state", 1, 1, "estimated local errors since the start, summed; 1 each: just allowed"),
    Array("error_before", "state", 1, 1, "estimated error of the step before"),
    Array("step_before", "state", 1, 1, "s, length of the step before, 0: none"),
    Array("stiff_steps", "state", 1, 1, "steps at the border of stability"),
    Array("stable_steps", "state", 1, 1, "steps within it since"),
    Array("singular_told", "state", 1, 1, "1: told that the tolerance is not attained"),
    Array("rate_noise", "state", 1, 1, "1/s, what rounding makes of the rates, by what errors are weighed by; 0: not known, or nothing"),
    Array("noise_steps", "state", 1, 1, "accepted steps for which that holds yet"),
    Array("noise_due", "state", 1, 1, "rejected steps after which it is found again"),
    Array("noise_patience", "state", 1, 1, "how many these were"),
    Array("radius", "state", 1, 1, "1/s, spectral radius of J"),
    Array("linear_work", "state", 1, 1, "work of linear systems since the start, in evaluations"),
    Array("border_work", "state", 1, 1, "evaluations when the steps at the border of stability began"),
    Array("border_span", "state", 1, 1, "s, that they have led since"),
    Array("pair_rate", "state", 1, 1, "evaluations a second of the pair that was left, 0: not known"),
    Array("pair_radius", "state", 1, 1, "1/s, spectral radius of J then"),
    Array("implicit_work", "state", 1, 1, "work since the start when the implicit method began to be watched"),
    Array("implicit_span", "state", 1, 1, "s, that it has led since"),
    Array("implicit_steps", "state", 1, 1, "in so many steps"),
    Array("patience", "state", 1, 1, "factor on what a pair spends at the border before the implicit method is tried"),
    Array("border_pair", "state", 1, 1, "at the border of stability, 1: rk54, 2: rkc goes on in place of rk853"),
    Array("border_trial", "state", 2, 1, "steps of rk853 there before rk54 or rkc is tried"),
    Array("border_decays", "state", 1, 1, "steps there that were so by what decays"),
    Array("border_radius", "state", 1, 1, "1/s, spectral radius that rkc has found, 0: none"),
    Array("radius_steps", "state", 1, 1, "steps of rkc for which that holds yet"),
    Array("border_cost", "state", 1, 1, "evaluations a second of rk853 there"),
    Array("trial_steps", "state", 1, 1, "steps of what goes on in its place, since that was tried"),
    Array("trial_work", "state", 1, 1, "evaluations when it began to be watched"),
    Array("trial_span", "state", 1, 1, "s, that it has led since"),
    Array("u_known", "state", 1, 1, "1: u_course holds"),
    Array("u_course", "state", 6, "n_u", "inputs and their derivatives if they go on as in the communication step before"),
    Array("jump_steps", "state", 1, 1, "inner steps when inputs last jumped"),
    Array("command_known", "state", 1, 1, "how many commands before the present one are remembered, at most 4"),
    Array("command_steps", "state", 4, 1, "s, lengths of the last communication steps, the latest first"),
    Array("command_past", "state", 4, "n_command", "what was commanded last, of the highest derivative told"),
    Array("command_error", "state", 4, "n_command", "by how much polynomials of order 0 to 3 missed the last command"),
    Array("command_before", "state", 2, "n_command", "position and speed commanded last"),
    Array("command_reached", "state", 2, "n_command", "position and speed at the end of the last step"),
    Array("command_aim", "state", 2, "n_command", "where the input's own derivative led then, and by how much"),
    Array("command_blind", "state", 1, "n_command", "steps since the first, when the speed was not known in that; 0: it was, or long ago"),
    Array("command_carried", "state", 3, "n_command", "position, speed, acceleration that the commands led to at the end of the last step"),
    Array("drive_doubt", "state", 2, "n_drive", "steps in a row whose commands contradict each other; 1: told"),
    Array("attitude_past", "state", 4, "n_attitude", "orientation commanded last"),
    Array("attitude_reached", "state", 7, "n_attitude", "orientation and angular velocity at the end of the last step"),
    Array("ahead", "state", 1, 1, "s, how far the integrator's front is ahead of the time reached"),
    Array("front", "state", 1, "n_x", "x there"),
    Array("front_time", "state", 1, 1, "s, the time there"),
    Array("early_stages", "state", 1, 1, "stages of the step from the front that are found, -1: none will be"),
    Array("early_step", "state", 1, 1, "s, length of that step"),
    Array("early_tries", "state", 1, 1, "attempts of it that were rejected"),
    Array("early_share", "state", 3, 1, "least_share at the front (-1: not known), the least and the most of its stages"),
    Array("rate_known", "state", 1, 1, "1: front_rate holds"),
    Array("front_rate", "state", 1, "n_x", "x' at the front, or at x when that is not ahead"),
    Array("span", "state", 1, 1, "s, length of the step that `dense` is about, 0: none"),
    Array("dense", "state", 1, "n_dense", "continuous extension of the last step, or its stages"),
    Array("jacobian_known", "state", 1, 1, "1: there is a J, found at jacobian_x, 2: which was factored, 0: none"),
    Array("jacobian_x", "state", 1, "n_swap", "x at which J was found"),
    Array("jacobian_time", "state", 1, 1, "s, likewise"),
    Array("jacobian_input", "state", 1, "n_u", "inputs, likewise"),
    Array("lu_step", "state", 1, 1, "s, step that the Newton matrices are of"),
    Array("q", "state", 1, "n_q", "position coordinates"),
    Array("v", "state", 1, "n_v", "velocity coordinates"),
    Array("z", "state", 1, "n_z", "parameters of end frames, angles outside the tree, memories of waves made"),
    Array("x", "state", 1, "n_x", "q, v, z in a row", over="q"),
    Array("body_m", "state", 1, "n_body", "kg, mass (prepared from the solids)"),
    Array("body_h", "state", 3, "n_body", "kg m, mass times centre of mass, in the node"),
    Array("body_I", "state", 6, "n_body", "kg m2 about the node's origin, in the node"),
    Array("lightness", "state", 1, 1, "mass of the lightest node that has any beside the heaviest"),
    Array("added_I", "state", 6, "n_six_by_six", "added inertia about the second marker, moment from angular acceleration (added_mass.py)"),
    Array("added_H", "state", 9, "n_six_by_six", "added inertia, moment from acceleration"),
    Array("added_M", "state", 6, "n_six_by_six", "added mass, force from acceleration"),
    Array("row_redundant", "state", 1, "n_row", "1: follows from other rows in every position (multipliers.py)"),
    Array("lends", "state", 1, 1, "1: there are bodies that are lent virtual inertia (virtual.py)"),
    Array("lent_mass", "state", 1, "n_body", "kg"),
    Array("lent_inertia", "state", 1, "n_body", "kg m2, about the origin"),
    Array("lent_known", "state", 1, "n_body", "1: known that what else there is determines how it moves"),
    Array("row_taken", "state", 1, "n_row", "gap that a loop not quite exact was found to have"),
    Array("row_rest", "state", 1, "n_row", "position residual that is none: a coupling's offset, a gap left at the start"),
    Array("end_frame_side", "state", 1, "n_end_frame", "1 or -1: side of the first surface on which the second touches; 0: a point"),
    Array("row_side", "state", 1, "n_row", "1 or -1: side of its plane on which something rolls"),
    Array("strut_start", "state", 1, "n_strut", "m, length at the start"),
    Array("loose", "state", 1, 1, "1: redundant rows may have gaps, loops repeat themselves not quite exactly"),
    # work: time, inputs and rates
    Array("generic_evaluations", "work", 1, 1, "evaluations that a kernel traced for the scene has left to the generic one"),
    Array("lu_known", "work", 1, 1, "1: jacobian is that of jacobian_x, 2: lu_real and lu_complex are of it and lu_step; to be cleared when the state is not that of the last call"),
    Array("stages_here", "work", 1, 1, "1: stage holds early_stages; to be cleared likewise"),
    Array("now", "work", 1, 1, "s, time of the evaluation"),
    Array("input", "work", 1, "n_u", "inputs now"),
    Array("command_fresh", "work", 1, 1, "1: the commands of this communication step are new, not left to go on"),
    Array("u_varies", "work", 1, 1, "1: inputs vary within the communication step"),
    Array("u_joins", "work", 1, 1, "1: their values go on from those at the end of the step before"),
    Array("command_course", "work", 8, "n_command", "commanded motion over the communication step: coefficients of s^0 to s^7"),
    Array("command_settling", "work", 4, "n_command", "added to it: coefficients of s^0 to s^3"),
    Array("attitude_base", "work", 4, "n_attitude", "orientation commanded at the start of the communication step"),
    Array("tau", "work", 1, "n_v", "efforts in the joints"),
    Array("coordinate_effort", "work", 1, "n_coordinate", "effort along a coordinate that closes a loop"),
    Array("q_rate", "work", 1, "n_q", "q'"),
    Array("v_rate", "work", 1, "n_v", "v'"),
    Array("z_rate", "work", 1, "n_z", "z'"),
    Array("x_rate", "work", 1, "n_x", "x': these in a row", over="q_rate"),
    # work: kinematics of the nodes
    Array("r", "work", 3, "n_body", "m, origin from O"),
    Array("A", "work", 9, "n_body", "body axes to O"),
    Array("w", "work", 3, "n_body", "rad/s, angular velocity"),
    Array("E", "work", 4, "n_turned", "Euler parameters in O, continuous in time (for outputs alone)"),
    Array("rd", "work", 3, "n_body", "m/s, velocity of the origin"),
    Array("arm", "work", 3, "n_body", "m, from the parent's origin"),
    Array("axis", "work", 3, "n_body", "the joint's axis"),
    Array("joint_axes", "work", 9, "n_body", "joint axes on the parent to O (free)"),
    Array("bias_w", "work", 3, "n_body", "rad/s2, angular acceleration relative to the parent's at v' = 0"),
    Array("bias_r", "work", 3, "n_body", "m/s2, likewise of the origin, beyond a_parent + alpha_parent x arm"),
    Array("held", "work", 1, "n_body", "1: the joint's acceleration is given, not found"),
    Array("kept", "work", 1, "n_v", "1: assembly keeps the start value"),
    Array("weighs", "work", 1, 1, "1: weights count"),
    Array("weight", "work", 1, "n_v", "kg, kg m2, added to the inertia in a joint by assembly"),
    Array("in_loop", "work", 1, "n_body", "1: the joint is part of a loop that is not just couplings"),
    Array("damping", "work", 1, 1, "part by which the diagonal of C M^-1 C^T is raised by assembly"),
    Array("weakest", "work", 1, 1, "what a redundant row must add to take the place of another (multipliers.exchange_rows)"),
    Array("least_gap", "work", 1, 1, "m, rad, of the attempts to assemble"),
    Array("assembling", "work", 1, 1, "1: positions at the start are being found, which may be far off"),
    Array("stuck", "work", 1, "n_body", "1: cannot move at the start, 2: nor nearby"),
    # work: inertia and forces of the nodes
    Array("h", "work", 3, "n_body", "kg m, mass times centre of mass from the origin"),
    Array("I", "work", 6, "n_body", "inertia of the node: rotational block"),
    Array("H", "work", 9, "n_body", "coupling block: moment from acceleration of the origin"),
    Array("M", "work", 6, "n_body", "translational block"),
    Array("moment", "work", 3, "n_body", "N m, applied, about the origin"),
    Array("force", "work", 3, "n_body", "N, applied"),
    Array("excitation_key", "work", 8, "n_excitation", "which knots stand in the ring (forces/waves.py)"),
    Array("excitation_knot", "work", 144, "n_excitation", "values and derivatives at them"),
    Array("hull_point", "work", 3, "n_hull_vertex", "m, in inertial axes, x and y from the marker, z from the water plane"),
    Array("alpha", "work", 3, "n_body", "rad/s2, angular acceleration"),
    Array("rdd", "work", 3, "n_body", "m/s2, acceleration of the origin"),
    # work: articulated bodies (ABA) and composite bodies (CRBA)
    Array("I_a", "work", 6, "n_body", "articulated or composite inertia: rotational block"),
    Array("H_a", "work", 9, "n_body", "coupling block"),
    Array("M_a", "work", 6, "n_body", "translational block"),
    Array("bias_moment", "work", 3, "n_body", "articulated bias wrench; once reactions are found, what the joint passes"),
    Array("bias_force", "work", 3, "n_body", "likewise"),
    Array("U_w", "work", 3, "n_body", "I_a S, moment; of free joints the moment left for the joint's acceleration"),
    Array("U_r", "work", 3, "n_body", "I_a S, force; of free joints the force left"),
    Array("D", "work", 6, "n_body", "factor of S^T I_a S (one axis: its first number alone); free joints: of I_a - H_a M_a^-1 H_a^T"),
    Array("D_M", "work", 6, "n_body", "factor of M_a (free joints)"),
    Array("N", "work", 9, "n_body", "H_a M_a^-1 (free joints)"),
    Array("effort", "work", 3, "n_body", "S-projected effort left for acceleration"),
    Array("mass_matrix", "work", 1, "n_mass", "joint-space mass matrix by rows, then its Cholesky factor"),
    # work: constraint rows, as wrenches about the origins of their two bodies, inertial axes
    Array("row_moment_from", "work", 3, "n_row", "on the first marker's body"),
    Array("row_force_from", "work", 3, "n_row", ""),
    Array("row_moment_to", "work", 3, "n_row", "on the second marker's body"),
    Array("row_force_to", "work", 3, "n_row", ""),
    Array("term_moment_from", "work", 3, "n_term", "of a coupling's further coordinates that close loops: on the first marker's body"),
    Array("term_force_from", "work", 3, "n_term", ""),
    Array("term_moment_to", "work", 3, "n_term", "on the second marker's body"),
    Array("term_force_to", "work", 3, "n_term", ""),
    Array("row_gap", "work", 1, "n_row", "position residual g"),
    Array("row_rate", "work", 1, "n_row", "velocity residual g'"),
    Array("row_bias", "work", 1, "n_row", "g'' at zero accelerations of the bodies"),
    Array("row_settles", "work", 1, "n_row", "1: a coupling whose offset is still to be found"),
    Array("constraint_noise", "work", 1, "n_constraint", "what its rows' wrenches could move if those of its two sides did not cancel"),
    Array("row_size", "work", 1, "n_row", "what its wrenches could move if they met the axes of the joints"),
    Array("row_diagonal", "work", 1, "n_row", "diagonal of C M^-1 C^T"),
    Array("multiplier", "work", 1, "n_row", "lambda: the row's wrenches times it act on the bodies"),
    Array("multiplier_kept", "work", 1, "n_row", "multipliers found so far, while a change of them is sought"),
    Array("row_rhs", "work", 1, "n_row", "right-hand side of the rows"),
    Array("response", "work", 1, "n_response", "response of the joints to each row, whitened"),
    Array("factor", "work", 1, "n_factor", "C M^-1 C^T = L D L^T: L in blocks"),
    Array("pivot", "work", 1, "n_row", "1 / D of the factor, 0: row dropped"),
    Array("least_share", "work", 1, 1, "of the rows of the factor: the least that one adds to those before it (see row_reference), 0: dropped"),
    Array("parameter_along", "work", 3, "n_end_frame", "s' of a driven parameter by the velocity of its point, in O"),
    Array("parameter_bend", "work", 1, "n_end_frame", "the part of s'' that is no acceleration of the point"),
    Array("aim", "work", 1, "n_end_frame", "1: assembly takes the contact to given parameters"),
    Array("passed_moment", "work", 3, "n_body", "wrench on its way to the ground"),
    Array("passed_force", "work", 3, "n_body", ""),
    Array("white", "work", 1, "n_v", "whitened effort"),
    Array("change", "work", 1, "n_v", "response in velocity coordinates"),
    Array("change_alpha", "work", 3, "n_body", "response of the nodes"),
    Array("change_rdd", "work", 3, "n_body", ""),
    # work: wrenches about the origins of bodies that are lent inertia, and accelerations (massless.py)
    Array("left_moment", "work", 3, "n_body", "what is left of the wrench that the lent inertia must not take"),
    Array("left_force", "work", 3, "n_body", ""),
    Array("push_moment", "work", 3, "n_body", "wrench of the search direction"),
    Array("push_force", "work", 3, "n_body", ""),
    Array("push_alpha", "work", 3, "n_body", "what it makes of the accelerations"),
    Array("push_rdd", "work", 3, "n_body", ""),
    Array("given_moment", "work", 3, "n_body", "wrench given back so far"),
    Array("given_force", "work", 3, "n_body", ""),
    # work: steppers
    Array("evaluation_limit", "work", 1, 1, "evaluations since the start at which the communication step has cost too much"),
    Array("x_before", "work", 1, "n_x", "x at the start of an inner step"),
    Array("x_own", "work", 1, "n_x", "x of the run, while outputs see loops where commands put them"),
    Array("x_tried", "work", 7, "n_x", "states of attempts to find the start (dynamics/given.py)"),
    Array("x_scale", "work", 1, "n_x", "error weights"),
    Array("stage", "work", 1, "n_stage", "rates of the stages, right-hand sides of the implicit methods, n_x each"),
    Array("jacobian", "work", 1, "n_jacobian", "J = dx'/dx, by its elements"),
    Array("right", "work", 2, "n_swap", "right-hand sides in the order of elimination"),
    Array("lu_real", "work", 1, "n_jacobian", "factors of the real Newton matrix (linear.py)"),
    Array("lu_complex", "work", 2, "n_jacobian", "of the complex one"),
    Array("swaps_real", "work", 1, "n_swap", "their exchanges of rows"),
    Array("swaps_complex", "work", 1, "n_swap", ""),
)
# fmt: on

SLOT = {array.name: len(COUNTS) + k for k, array in enumerate(ARRAYS)}
ARRAY = {array.name: array for array in ARRAYS}
HEADER_LENGTH = len(COUNTS) + len(ARRAYS)


def array_length(array: Array, counts: dict[str, int]) -> int:
    """How many numbers an array holds in a model of these counts."""
    return array.width * (array.count if isinstance(array.count, int) else counts[array.count])


def arrange(counts: dict[str, int]) -> tuple[list[int], dict[str, int]]:
    """The header of `ints` for a model of these counts, and the length of each buffer."""
    length = {"ints": HEADER_LENGTH, "reals": 0, "state": 0, "work": 0}
    offsets = []

    for array in ARRAYS:
        if array.over:
            offsets.append(offsets[SLOT[array.over] - len(COUNTS)])
        else:
            offsets.append(length[array.buffer])
            length[array.buffer] += array_length(array, counts)

    return [counts[name] for name in COUNTS] + offsets, length
