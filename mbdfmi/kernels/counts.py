"""What a model has how many of, in the order of the head of its `ints` (layout.py)."""

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
    "n_low",  # lines that may come under the sea's bed
    "n_composite",  # those of several sections, or with friction of the bed
    "n_section",  # their sections
    "n_radiation",  # memories of the waves that bodies make
    "n_memory",  # their states
    "n_memory_row",  # of these, one for each body whose waves they are
    "n_shared_water",  # pairs of bodies that move each other's water
    "n_resistance",  # dampings of these bodies beside waves, linear and quadratic
    "n_sea",  # 1: waves that act or are told
    "n_sea_wave",  # components of the sea
    "n_excitation",  # what waves do to bodies
    "n_follow",  # these, where one of them or more are met by the waves where it is, else 0
    "n_part",  # components of that
    "n_heading_part",  # these at headings of the file, of bodies whose loads turn with them
    "n_grid",  # frequencies and headings at which it is known
    "n_response_point",  # pairs of these
    "n_station",  # points of members at which waves move the water
    "n_current",  # 1: the sea has a current
    "n_member_drag",  # members that water drags at
    "n_wind",  # 1: wind
    "n_gust",  # 1: it has a gust
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
