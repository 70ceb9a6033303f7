"""What is said of mistakes in a scene file, word for word."""

import pytest
from scene_files import ARM, BARGE, CARRIAGE, DRIVES, LOADS, LOOKS, SHAPES, outcome

from mbdfmi.scene import SceneError, read_scene

# no numpy warning either: NaN and overflow must not get that far
pytestmark = pytest.mark.filterwarnings("error")

ORBIT = 'orbit = { radius = 7e6, rate = 1e-3, normal = "-y", phase_deg = 30, pointing = true }'
MESSAGES = [
    (
        LOOKS,
        "stop = 20",
        "stop = 1",
        [
            "[experiment] stop must be after start (1), found 1",
        ],
    ),
    (
        LOOKS,
        "stop = 20",
        "end = 20",
        [
            '[experiment] end: unknown key; there is "start", "stop", "step" and "tolerance".',
        ],
    ),
    (
        LOOKS,
        'frame = "mast"',
        'frame = "mats"',
        [
            '[view] frame: no body "mats"; there is "mast", "ground" and "inertial". Did you mean "mast"?',
        ],
    ),
    (
        LOOKS,
        'paths = ["mast.top"]',
        'paths = ["mast", "mast.tp"]',
        [
            '[view] paths[2]: no marker "tp" on body "mast"; it has "top". Did you mean "mast.top"?',
        ],
    ),
    (
        LOOKS,
        'plots = ["sway.angle"]',
        "plots = [1]",
        [
            "[view] plots: needs a list of names in quotes, found [1]",
        ],
    ),
    (
        LOOKS,
        "look_from = [1, -1, 0.5]",
        "look_from = [0, 0, 0]",
        [
            "[view] look_from: needs a direction, found [0, 0, 0]",
        ],
    ),
    (
        LOOKS,
        'colour = "grey"',
        'color = "grey"',
        [
            '[ground] color: unknown key; there is "colour", "shape", "motion", "output" and "marker". '
            'Did you mean "colour"?',
        ],
    ),
    (
        LOOKS,
        '"tomato"',
        '"tomatoe"',
        [
            '[body.mast] shape[2].colour: no colour "tomatoe"; there are the names of CSS, as "steelblue", and '
            '"#rrggbb". Did you mean "tomato"?',
        ],
    ),
    (
        LOOKS,
        "opacity = 0.5",
        "opacity = 2",
        [
            "[body.mast] shape[1].opacity: must be above 0 (unseen) and at most 1 (solid), found 2",
        ],
    ),
    (
        LOOKS,
        "capsule = {",
        "capsul = {",
        [
            '[body.mast] shape[1]: a shape needs one of "sphere", "box", "cylinder", "tube", "capsule", "cone", '
            '"mesh" or "line"; found "capsul", "position" and "opacity". Did you mean "capsule"?',
        ],
    ),
    (
        LOOKS,
        '["mast", "mast.top"], radius',
        '["mast", "ground.wall"], radius',
        [
            '[body.mast] shape[5].line[2]: "ground.wall" is not on "mast"; a line joins ends of what it is drawn on',
        ],
    ),
    (
        LOOKS,
        '["mast", "mast.top"], radius',
        '["mast"], radius',
        [
            '[body.mast] shape[5].line: needs a list of two or more ends, as ["arm", "arm.tip"], found ["mast"]',
        ],
    ),
    (
        LOOKS,
        '"hull.obj"',
        '"hull.step"',
        [
            "[body.mast] shape[4].mesh.file: needs a mesh (.stl, .obj, .ply, .off, .glb, .gltf, .dae, .3mf), "
            'found "hull.step"',
        ],
    ),
    (
        LOOKS,
        "scale = [1, 1, -1]",
        "scale = [1, 0, -1]",
        [
            "[body.mast] shape[4].mesh.scale: factors must not be 0, found [1, 0, -1]",
        ],
    ),
    (
        ARM,
        "mass    = 2.0",
        "mas = 2.0",
        [
            '[body.upper] mas: unknown key; there is "mass", "com", "inertia", "inertia_axes", '
            '"solid", "output", "input", "input_axes", "colour", "shape" and "marker". Did you mean "mass"?',
        ],
    ),
    (
        ARM,
        "mass    = 2.0",
        "mass = -2.0",
        [
            "[body.upper] mass: must not be negative, found -2.0",
        ],
    ),
    (
        ARM,
        "mass    = 2.0",
        'mass = "2 kg"',
        [
            '[body.upper] mass: needs a number, without quotes or a unit; found "2 kg"',
        ],
    ),
    (
        ARM,
        "mass    = 2.0",
        "mass = 2 kg",
        [
            "line 12, column 10: not valid TOML: Expected newline or end of document after a "
            'statement in "mass = 2 kg"; a number stands as 0.5 without a unit, a comment after'
            " #",
        ],
    ),
    (
        ARM,
        "com     = [0, 0, -0.25]",
        "com = [0, -0.25]",
        [
            "[body.upper] com: needs 3 numbers [x, y, z], found [0, -0.25]",
        ],
    ),
    (
        ARM,
        "[0.042, 0.042, 0.001]",
        "[0.042, 0.01, -0.001]",
        [
            "[body.upper] inertia: no principal moment is negative on a real body; the principal moments "
            "are [-0.001, 0.01, 0.042]",
        ],
    ),
    (
        ARM,
        "[0.042, 0.042, 0.001]",
        "[[1, 0, 0.1], [0, 1, 0], [0, 0, 1]]",
        [
            "[body.upper] inertia: the matrix is not symmetric",
        ],
    ),
    (
        ARM,
        "inertia = [0.042, 0.042, 0.001]\n",
        "",
        [
            "[body.upper] inertia is missing; for a point mass write inertia = [0, 0, 0]",
        ],
    ),
    (
        ARM,
        '"upper.elbow"',
        '"upper.elbw"',
        [
            '[joint.elbow] between: no marker "elbw" on body "upper"; it has "elbow" and "tip".'
            ' Did you mean "upper.elbow"?',
        ],
    ),
    (
        ARM,
        '"upper.elbow"',
        '"uper.elbow"',
        [
            '[joint.elbow] between: no body "uper"; there is "upper", "lower", "ground" and '
            '"inertial". Did you mean "upper.elbow"?',
        ],
    ),
    (
        ARM,
        '"upper.elbow", "lower"',
        '"elbow", "lower"',
        [
            '[joint.elbow] between: no body "elbow"; there is "upper", "lower", "ground" and '
            '"inertial". "elbow" is a joint. Did you mean "upper.elbow"?',
        ],
    ),
    (
        ARM,
        '"upper.elbow", "lower"',
        '"upper.elbow", "upper"',
        [
            '[joint.elbow] between: both ends are on "upper"; a joint acts between two bodies',
        ],
    ),
    (
        ARM,
        '"upper.elbow", "lower"',
        '"upper.elbow"',
        [
            '[joint.elbow] between: needs two ends, as in ["ground", "body.marker"]; found ["upper.elbow"]',
        ],
    ),
    (
        ARM,
        '"upper.elbow", "lower"',
        '"upper.elbow", "ground"',
        [
            "[body.lower] no chain of joints connects it to ground; to let it move freely, "
            'write a joint with free = {} and between = ["ground", "lower"]',
        ],
    ),
    (
        ARM,
        'revolute = { axis = "y" }',
        'revolut = { axis = "y" }',
        [
            '[joint.shoulder] a joint needs one of "fixed", "revolute", "prismatic", '
            '"cylindrical", "universal", "spherical", "planar", "translation", "screw", "free", "prescribed", '
            '"point_on_plane", "point_on_line", "distance", "rolling_sphere", "rolling_disk", '
            '"knife_edge", "constant_velocity", "angle", "point_on_curve", "curve_on_curve", "point_on_surface", "frame_on_curve", '
            '"frame_on_surface", "surface_on_surface" or "rolling_surface"; found "revolut", '
            '"between", "start", "input" and "output". '
            'Did you mean "revolute"?',
        ],
    ),
    (
        ARM,
        'revolute = { axis = "y" }',
        "revolute = {}\nfixed = {}",
        [
            '[joint.shoulder] a joint is of one kind, found "revolute" and "fixed"; keep one of them',
        ],
    ),
    (
        ARM,
        'axis = "y"',
        'axis = "+y"',
        [
            '[joint.shoulder] revolute.axis: no axis "+y"; there are "x", "y", "z", "-x", "-y" '
            'and "-z", and vectors [x, y, z]. Did you mean "y"?',
        ],
    ),
    (
        ARM,
        "angle_deg = 30",
        "angle_rad = 0.5",
        [
            '[joint.shoulder] start.angle_rad: unknown key; there is "angle", "angle_deg", '
            '"speed", "speed_deg" and "speed_rpm". Did you mean "angle"?',
        ],
    ),
    (
        ARM,
        '["angle", "speed"]',
        '["angel", "speed"]',
        [
            '[joint.shoulder] output: no "angel" here; there is "angle", "speed", '
            '"acceleration", "effort", "spring_effort", "damper_effort", "friction_effort", "stop_effort", "input_effort", '
            '"driver_effort", "power", "reaction_force" and 3 more. Did you mean "angle"?',
        ],
    ),
    (
        ARM,
        '["angle", "speed"]',
        '"angle"',
        [
            '[joint.shoulder] output: needs a list, found "angle"; write ["angle"]',
        ],
    ),
    (
        ARM,
        "zyx_deg = [90, 0, 0]",
        "zyx = [90, 0, 0]",
        [
            '[ground] marker.site.zyx: unknown key; there is "euler_parameters", "zyx_deg", '
            '"zyx_rad", "axis_angle", "axes", "position", "colour", "shape", "curve" and "surface". Did you mean '
            '"zyx_deg" or '
            '"zyx_rad"?',
        ],
    ),
    (
        ARM,
        "[0, 0, 0, 1]",
        "[1, 0, 0, 1]",
        [
            "[body.upper] inertia_axes.euler_parameters: Euler parameters [E1, E2, E3, E4], "
            "scalar last, have unit length; found 1.41421",
        ],
    ),
    (
        ARM,
        "z = [0, 0, 1], x",
        'z = "y", x',
        [
            '[body.upper] marker.tip.axes: "z" and "x" are parallel',
        ],
    ),
    (
        ARM,
        ", density = 2700",
        "",
        [
            '[body.lower] solid.cylinder: needs "density" or "mass"',
        ],
    ),
    (
        ARM,
        "[body.lower]",
        "[body.ground]",
        [
            '[body.ground] "ground" is the name of a frame that is always there; use another',
            '[joint.elbow] between: no body "lower"; there is "upper", "ground" and "inertial".',
        ],
    ),
    (
        ARM,
        "[body.lower]",
        "[body.upper]",
        [
            "line 19, column 12: not valid TOML: Cannot declare [body.upper] twice in "
            '"[body.upper]"; write each table once',
        ],
    ),
    (
        ARM,
        "[body.lower]",
        "[body.lower arm]",
        [
            "line 19, column 13: not valid TOML: Expected ']' at the end of a table declaration"
            ' in "[body.lower arm]"; a name with spaces stands in quotes, as in [body."blade '
            '1"]',
        ],
    ),
    (
        ARM,
        "step = 1e-3\n",
        "",
        [
            "[solver] rk4 needs a step, as in step = 1e-3",
        ],
    ),
    (
        BARGE,
        "inner_radius = 2.9",
        "inner_radius = 3.1",
        [
            "[body.hull] solid[2].tube.inner_radius: must be smaller than the radius 3.0, found 3.1",
        ],
    ),
    (
        BARGE,
        "spherical = {}",
        "spherical = {}\ndamper = 0.1",
        [
            '[joint.ball] damper: unknown key; there is "spherical", "between", "start", '
            '"input" and "output".',
        ],
    ),
    (
        BARGE,
        'input_axes = "body"',
        'input_axes = "global"',
        [
            '[body.hull] input_axes: no "global" here; there is "inertial" and "body".',
        ],
    ),
    (
        BARGE,
        'input = ["force", "moment"]\n',
        "",
        [
            '[body.hull] input_axes without an input; add input = ["force", "moment"]',
        ],
    ),
    (
        BARGE,
        "added_mass = [\n    [1, 0,",
        "added_mass = [\n    [1, 0.5,",
        [
            "[force.water] linear.added_mass: is not symmetric: [1][2] is 0.5, [2][1] is 0.0",
        ],
    ),
    (
        BARGE,
        "preload = [0, 0, 1e6, 0, 0, 0]",
        "preload = [0, 0, 1e6]",
        [
            "[force.water] linear.preload: needs 6 numbers [x, y, z, rx, ry, rz], found [0, 0, 1000000.0]",
        ],
    ),
    (
        BARGE,
        'water]\nbetween = ["ground",',
        'water]\nbetween = ["weight",',
        [
            '[force.water] with added_mass the first end must be "ground" or a marker of it, '
            'found ["weight", "hull"]',
        ],
    ),
    (
        BARGE,
        'between = ["ground", "weight"]\n',
        "",
        [
            '[force.line] between: is missing (the two ends, as in between = ["ground", "body.marker"])',
        ],
    ),
    (
        ARM,
        '"lower"]\n',
        '"lowr"]\nwhat = 1\n',
        [
            '[joint.elbow] between: no body "lowr"; there is "upper", "lower", "ground" and '
            '"inertial". Did you mean "lower"?',
            '[joint.elbow] what: unknown key; there is "revolute", "between", "start", "spring", '
            '"damper", "friction", "turning", "stop", "driver", "input" and "output".',
        ],
    ),
    (
        ARM,
        'integrator = "rk4"',
        'integrator = "rk853"',
        [
            '[solver] rk853 chooses its step itself; write max_step, or integrator = "rk4"',
        ],
    ),
    (
        CARRIAGE,
        '"embedding"',
        '"recursiv"',
        [
            '[solver] formulation: no "recursiv" here; there is "auto", "recursive", "embedding" '
            'and "augmented". Did you mean "recursive"?',
        ],
    ),
    (
        CARRIAGE,
        '["x", [0, 1, 1]]',
        '["x", [1, 1, 0]]',
        [
            '[joint.cross] universal.axes: "x" and [1.0, 1.0, 0.0] are not perpendicular',
        ],
    ),
    (
        CARRIAGE,
        '["x", [0, 1, 1]]',
        '"x"',
        [
            '[joint.cross] universal.axes: needs two axes, as in ["x", "y"]; found "x"',
        ],
    ),
    (
        CARRIAGE,
        "pitch = 0.01",
        "pitch = 0",
        [
            "[joint.thread] screw.pitch: must not be 0, nor below 1e-30; found 0",
        ],
    ),
    (
        CARRIAGE,
        ", pitch = 0.01",
        "",
        [
            "[joint.thread] screw.pitch: is missing (advance in m per turn)",
        ],
    ),
    (
        CARRIAGE,
        "angles_deg",
        "angle_deg",
        [
            '[joint.cross] start.angle_deg: unknown key; there is "angles", "angles_deg", "speeds" '
            'and "speeds_deg". Did you mean "angles_deg"?',
        ],
    ),
    (
        CARRIAGE,
        "angle_deg = 10",
        "angle_deg = 10, angle = 1",
        [
            '[joint.slide] start: "angle" and "angle_deg" exclude each other; keep one of them',
        ],
    ),
    (
        CARRIAGE,
        "position = [0, 1]",
        "position = [0, 1, 0]",
        [
            "[joint.slide] start.position: needs 2 numbers [x, y], or a table of some of them as in { x = 1.0 }, "
            "found [0, 1, 0]",
        ],
    ),
    (
        CARRIAGE,
        'input = "torque"',
        'input = "force"',
        [
            '[joint.thread] input: no "force" here; there is "torque".',
        ],
    ),
    (
        CARRIAGE,
        "distance = { length = 2 }",
        "distance = { length = 2 }\nstart = {}",
        [
            '[joint.rod] start: unknown key; there is "distance", "between" and "output".',
        ],
    ),
    (
        CARRIAGE,
        "rolling_disk = { radius = 0.5",
        "rolling_disk = { diameter = 1",
        [
            "[joint.roll] rolling_disk.radius: is missing (radius in m)",
            '[joint.roll] rolling_disk.diameter: unknown key; there is "radius" and "axis".',
        ],
    ),
    (
        CARRIAGE,
        '["inertial", "bead"]',
        '["inertial", "ground"]',
        [
            "[joint.shift] between: neither end is on a body; a joint acts on one at least",
        ],
    ),
    (
        CARRIAGE,
        '["inertial", "bead"]',
        '["inertial.site", "bead"]',
        [
            '[joint.shift] between: no marker "site" on the inertial frame; it has none.',
        ],
    ),
    (
        CARRIAGE,
        """[joint.shift]
translation = {}
between = ["inertial", "bead"]
start = { position = [1, 2, 3], velocity = [4, 5, 6] }
output = ["position", "velocity"]
""",
        "",
        [
            '[body.bead] no chain of joints connects it to ground ("rod" is distance, which only '
            "takes freedoms away); to let it move freely, write a joint with free = {} and "
            'between = ["ground", "bead"]',
        ],
    ),
    (
        DRIVES,
        "[central_gravity]",
        "gravity = [0, 0, 0]\n[central_gravity]",
        [
            '"gravity" and "central_gravity" exclude each other; keep one of them',
        ],
    ),
    (
        DRIVES,
        "mu = 3.986e14",
        "mu = -3.986e14",
        [
            "[central_gravity] mu: must be greater than 0, at least 1e-30; found -398600000000000.0",
        ],
    ),
    (
        DRIVES,
        "pointing = true",
        'pointing = "yes"',
        [
            '[ground] motion.orbit.pointing: needs true or false, found "yes"',
        ],
    ),
    (
        DRIVES,
        ORBIT,
        'rotation = { axis = "z" }',
        [
            '[ground] motion.rotation: needs "speed", "speed_deg" or "speed_rpm"',
        ],
    ),
    (
        DRIVES,
        "orbit = { radius",
        "orbits = { radius",
        [
            '[ground] motion: a motion needs one of "acceleration", "rotation", "orbit", "elliptic_orbit", '
            '"table" or "input"; found "orbits". Did you mean "orbit"?',
        ],
    ),
    (
        DRIVES,
        ORBIT,
        "elliptic_orbit = { semi_major_axis = 7e6, eccentricity = 0.1 }",
        [
            '[ground] motion.elliptic_orbit: needs "mu" or "period"',
        ],
    ),
    (
        DRIVES,
        ORBIT,
        "elliptic_orbit = { semi_major_axis = 7e6, eccentricity = 1.0, period = 5400 }",
        [
            "[ground] motion.elliptic_orbit.eccentricity: must be below 1, that of a closed orbit; found 1.0",
        ],
    ),
    (
        DRIVES,
        ORBIT,
        "elliptic_orbit = { semi_major_axis = 7e6, eccentricity = 0.1, mu = 4e14, period = 5400 }",
        [
            '[ground] motion.elliptic_orbit: "mu" and "period" exclude each other; keep one of them',
        ],
    ),
    (
        DRIVES,
        ORBIT,
        "table = { time = [0, 1], position = [[0, 0, 0], [1, 0]] }",
        [
            "[ground] motion.table.position: needs vectors [x, y, z], found 2 rows of 2 to 3",
        ],
    ),
    (
        DRIVES,
        ORBIT,
        "table = { time = [0, 1], euler_parameters = [[0, 0, 0, 1], [0, 0, 0, 2]] }",
        [
            "[ground] motion.table.euler_parameters: [2]: Euler parameters [E1, E2, E3, E4], scalar "
            "last, have unit length; found 2",
        ],
    ),
    (
        DRIVES,
        ORBIT,
        "table = { time = [0, 1] }",
        [
            '[ground] motion.table: needs "position" or an orientation: "zyx_deg", "zyx_rad" or '
            '"euler_parameters"',
        ],
    ),
    (
        DRIVES,
        "position = [-1, 0, 2], effort = [-5, 0, 7]",
        "position = [-1, 0, 0], effort = [1]",
        [
            "[joint.rail] spring.table.position: must ascend, but [3] is 0.0 after 0.0",
            "[joint.rail] spring.table.effort: needs at least 2 numbers, found 1",
        ],
    ),
    (
        DRIVES,
        "effort = [-5, 0, 7]",
        "effort = [-5, 7]",
        [
            '[joint.rail] spring.table: "position" has 3 values and "effort" 2; each needs one of the other',
        ],
    ),
    (
        DRIVES,
        "effort = [-5, 0, 7] }",
        "effort = [-5, 0, 7] }, stiffness = 2, rest = 1",
        [
            '[joint.rail] spring: "rest" and "table" exclude each other; keep one of them',
        ],
    ),
    (
        DRIVES,
        "spring = { table = { position = [-1, 0, 2], effort = [-5, 0, 7] } }",
        "spring = { rest = 1 }",
        [
            '[joint.rail] spring: needs "stiffness" or "table"',
        ],
    ),
    (
        DRIVES,
        "damper = { table = { speed = [-1, 1], effort = [-2, 2] } }",
        'damper = "0.1"',
        [
            '[joint.rail] damper: needs a number, without quotes or a unit; found "0.1"',
        ],
    ),
    (
        DRIVES,
        "damper = { table = { speed",
        "damper = { tabl = { speed",
        [
            "[joint.rail] damper.table: is missing (as in table = { speed = [...], effort = [...] })",
            '[joint.rail] damper.tabl: unknown key; there is "table". Did you mean "table"?',
        ],
    ),
    (
        DRIVES,
        "coulomb = 1, static = 2",
        "coulomb = 3, static = 2",
        [
            "[joint.rail] friction.static: must be at least coulomb, 3.0; found 2.0",
        ],
    ),
    (
        DRIVES,
        "lower = -1, upper = 2",
        "lower = 2, upper = -1",
        [
            "[joint.rail] stop: lower must be below upper; found 2 and -1",
        ],
    ),
    (
        DRIVES,
        "upper_deg = 90, ",
        "",
        [
            '[joint.hinge] stop: needs "lower" or "upper", or both',
        ],
    ),
    (
        DRIVES,
        "constant_speed_rpm = 300",
        "speed_rpm = 300",
        [
            '[joint.motor] driver.speed_rpm: unknown key; there is "constant_speed", '
            '"constant_speed_deg", "constant_speed_rpm", "hold", "harmonic", "harmonics", "polynomial", '
            '"ramp", "table", "speed_table" and "input". Did you mean "constant_speed_rpm"?',
        ],
    ),
    (
        DRIVES,
        "constant_speed_rpm = 300",
        "constant_speed_rpm = 300, input = true",
        [
            '[joint.motor] driver: "constant_speed_rpm" and "input" exclude each other; keep one of them',
        ],
    ),
    (
        DRIVES,
        "constant_speed_rpm = 300",
        "input = false",
        [
            "[joint.motor] driver.input: can only be true, found false; leave it out if it is not wanted",
        ],
    ),
    (
        DRIVES,
        "start = { angle_deg = 20 }",
        "start = { speed = 20 }",
        [
            "[joint.motor] the driver says how fast the joint starts; drop that of the start",
        ],
    ),
    (
        DRIVES,
        "start = { angle_deg = 20 }",
        'input = "torque"',
        [
            '[joint.motor] "torque" cannot act on a driven joint; drop the input',
        ],
    ),
    (
        DRIVES,
        "driver = { constant_speed_rpm = 300 }\n",
        "",
        [
            '[joint.motor] output "effort" is that of a driver, and there is none',
        ],
    ),
    (
        DRIVES,
        "upper_deg = 90, stiffness = 1e3 }",
        "upper_deg = 90, stiffness = 1e3 }\nstart = { angle = 1 }",
        [
            "[joint.hinge] the driver says where the joint starts and how fast; drop the start",
        ],
    ),
    (
        DRIVES,
        "frequency = 2, ",
        "",
        [
            "[joint.hinge] driver.harmonic.frequency: is missing (frequency in Hz)",
        ],
    ),
    (
        DRIVES,
        'between = ["motor", "rail"]',
        'between = ["rail", "motor"]',
        [
            '[coupling.pinion] between: "rail" is not "revolute", as the first joint of rack must be',
        ],
    ),
    (
        DRIVES,
        'between = ["motor", "rail"]',
        'between = ["motor", "rael"]',
        [
            '[coupling.pinion] between: no joint "rael"; there is "motor", "rail", "hinge", "wrist" '
            'and "wheel". Did you mean "rail"?',
        ],
    ),
    (
        DRIVES,
        'between = ["motor", "rail"]',
        'between = ["motor", "motor"]',
        [
            '[coupling.pinion] between: both are "motor"; a coupling is between two joints',
        ],
    ),
    (
        DRIVES,
        'between = ["motor", "wheel"]',
        'between = ["motor", "wrist"]',
        [
            "[coupling.sync] between: both joints are driven; one of them follows the other, so drop "
            "a driver",
        ],
    ),
    (
        DRIVES,
        "ratio = -2",
        "ratio = 0",
        [
            "[coupling.sync] gear.ratio: must not be 0, nor below 1e-30; found 0",
        ],
    ),
    (
        DRIVES,
        "[coupling.sync]",
        "[coupling.rail]",
        [
            "[coupling.rail] a joint has this name too; choose another",
        ],
    ),
    (
        LOADS,
        '"constraint_gap"',
        '"constraint_gaps"',
        [
            'output: no "constraint_gaps" here; there is "kinetic_energy", "potential_energy", '
            '"total_energy", "gravity_energy", "spring_energy", "input_power", "load_power", '
            '"driver_power", "dissipated_power", "linear_momentum", "angular_momentum", '
            '"center_of_mass" and 3 more. Did you mean "constraint_gap"?',
        ],
    ),
    (
        LOADS,
        '"acceleration", "alpha_body"',
        '"acceleraton"',
        [
            '[body.a] output: no "acceleraton" here; there is "position", "velocity", "acceleration", '
            '"euler_parameters", "zyx", "zyx_rate", "omega", "alpha", "velocity_body", '
            '"acceleration_body", "omega_body", "alpha_body" and 1 more. Did you mean "acceleration"?',
        ],
    ),
    (
        LOADS,
        "damping = 2 }",
        "damping = 2, rest_length = 1 }",
        [
            '[force.actuator] spring_damper: "rest_length" and "table" exclude each other; keep one of them',
        ],
    ),
    (
        LOADS,
        "stiffness = 0, ",
        "",
        [
            '[force.damper] spring_damper: needs "stiffness" or "table"',
        ],
    ),
    (
        LOADS,
        '["length", "rate"]',
        '["force"]',
        [
            "[force.actuator] output: the variable actuator.force cannot be both input and output; "
            "drop one of them",
        ],
    ),
    (
        LOADS,
        "[1, 2, 3, 4, 5, 6]",
        "[1, 2, 3]",
        [
            "[force.mount] bushing.stiffness: needs 6 numbers, the diagonal [x, y, z, rx, ry, rz], or "
            "a 6x6 matrix, found [1, 2, 3]",
        ],
    ),
    (
        LOADS,
        'on = "a.m"',
        'between = ["ground", "a.m"]',
        [
            '[force.push] on: is missing (the end it acts on, as in on = "body.marker")',
            '[force.push] between: unknown key; there is "load", "on" and "output".',
        ],
    ),
    (
        LOADS,
        'on = "a.m"',
        'on = "a.tip"',
        [
            '[force.push] on: no marker "tip" on body "a"; it has "m".',
        ],
    ),
    (
        LOADS,
        'on = "b"',
        'on = "ground"',
        [
            '[force.gust] on: "ground" does not move by a load; name a body',
        ],
    ),
    (
        LOADS,
        "force = [1, 0, 0], axes",
        "axes",
        [
            '[force.push] load: needs "force", "moment" or "table"',
        ],
    ),
    (
        LOADS,
        'force = [1, 0, 0], axes = "body"',
        "forces = [1, 0, 0]",
        [
            '[force.push] load.forces: unknown key; there is "force", "moment", "table" and "axes". '
            'Did you mean "force"?',
        ],
    ),
    (
        LOADS,
        "time = [0, 1]",
        "time = [0, 1, 2]",
        [
            '[force.gust] load.table: "time" has 3 values and "force" 2; each needs one of the other',
        ],
    ),
    (
        LOADS,
        '["a.m", "b"]',
        '["a.m", "b.m"]',
        [
            '[measure.gap] between: no marker "m" on body "b"; it has none.',
        ],
    ),
    (
        LOADS,
        'output = ["distance", "distance_rate", "angle", "acceleration"]',
        "",
        [
            '[measure.gap] output: is missing (what goes out, as in output = ["distance"])',
        ],
    ),
    (
        SHAPES,
        "cycloid = { radius = 1 }",
        "cyclod = { radius = 1 }",
        [
            '[ground] marker.wire.curve: a curve needs one of "line", "circle", "parabola", '
            '"cycloid", "spline" or "table"; found "cyclod". Did you mean "cycloid"?',
        ],
    ),
    (
        SHAPES,
        "curve = { cycloid = { radius = 1 } }",
        'curve = "cycloid"',
        [
            '[ground] marker.wire.curve: a curve needs a table, found "cycloid"',
        ],
    ),
    (
        SHAPES,
        "marker.wire = { curve = { cycloid = { radius = 1 } } }",
        "marker.wire = {}",
        [
            '[joint.thread] between: point_on_curve needs a curve on its first end, "ground.wire"; '
            "write marker.wire = { curve = { circle = { radius = 1 } } } and name that marker",
        ],
    ),
    (
        SHAPES,
        '["ground.ring", "follower"]',
        '["ground", "follower"]',
        [
            '[joint.skin] between: point_on_surface needs a surface on its first end, "ground"; '
            "write marker.NAME = { surface = { sphere = { radius = 1 } } } and name that marker",
        ],
    ),
    (
        SHAPES,
        '"follower.roller"',
        '"follower.rail"',
        [
            '[joint.lift] between: the curve on "follower.rail" must lie in a plane z = constant',
        ],
    ),
    (
        SHAPES,
        "tube = 0.5",
        "tube = 2",
        [
            "[ground] marker.ring.surface.torus.tube: must be smaller than the radius 2.0, found 2.0",
        ],
    ),
    (
        SHAPES,
        "coefficient = 0.1",
        "coeff = 0.1",
        [
            "[ground] marker.hill.surface.prism.profile.parabola.coefficient: is missing "
            "(coefficient c of y = c x^2, in 1/m)",
            "[ground] marker.hill.surface.prism.profile.parabola.coeff: unknown key; there is "
            '"coefficient". Did you mean "coefficient"?',
        ],
    ),
    (
        SHAPES,
        "profile = { parabola = { coefficient = 0.1 } }",
        "profile = { spline = { points = [[0, 0, 0], [1, 0, 1]] } }",
        [
            "[ground] marker.hill.surface.prism.profile: must lie in the xy plane; its points differ in z",
        ],
    ),
    (
        SHAPES,
        "[0, -1]]",
        "[0, -1], [1, 0]]",
        [
            "[body.cam] marker.edge.curve.spline: the last point is the first again; leave it out of "
            "a closed curve",
        ],
    ),
    (
        SHAPES,
        "[0, -1]]",
        "[-1, 0]]",
        [
            "[body.cam] marker.edge.curve.spline.points: [4] is the same point as [3], [-1.0, 0.0]",
        ],
    ),
    (
        SHAPES,
        "closed = true",
        "closed = true, s = [0, 1, 2, 3]",
        [
            "[body.cam] marker.edge.curve.spline: s needs 5 values, one for each point and one back "
            "at the first; found 4",
        ],
    ),
    (
        SHAPES,
        "[[1, 0], [0, 1], [-1, 0], [0, -1]]",
        "[[1, 0], [0, 1, 0]]",
        [
            "[body.cam] marker.edge.curve.spline.points: needs a list of points [x, y, z] or [x, y], "
            "found 2 rows of 2 to 3",
        ],
    ),
    (
        SHAPES,
        "s = [0, 2, 3], ",
        "",
        [
            "[body.follower] marker.rail.curve.table.s: is missing (the parameter at each point)",
        ],
    ),
    (
        SHAPES,
        "s1 = [0, 1, 2, 3]",
        "s1 = [0, 1, 2]",
        [
            "[ground] marker.net.surface.table: s1 needs at least 4 values, found 3",
        ],
    ),
    (
        SHAPES,
        "s1 = [0, 1, 2, 3]",
        "s1 = [0, 1, 2, 3, 4]",
        [
            "[ground] marker.net.surface.table: points needs 5 rows of 4 points, as many as there "
            "are values of s1 and s2; found 4 of 4",
        ],
    ),
    (
        SHAPES,
        "s = [0, 3.14]",
        "s = 3.14",
        [
            "[joint.lift] start.s: needs 2 numbers [s1, s2], found 3.14",
        ],
    ),
    (
        SHAPES,
        "start = { s = 0.5 }",
        'start = { s = "0.5" }',
        [
            '[joint.thread] start.s: needs a number, without quotes or a unit; found "0.5"',
        ],
    ),
]


@pytest.mark.parametrize("text, old, new, messages", MESSAGES)
def test_messages(text, old, new, messages):
    assert old in text
    error = outcome(text.replace(old, new, 1))
    assert error.errors == [f"a.toml: {message}" for message in messages]


def test_messages_about_files(tmp_path):
    (tmp_path / "folder").mkdir()
    texts = {"folder": "is a folder", "none.toml": "there is no such file", "a\0b": "null"}
    for name, text in texts.items():
        with pytest.raises(SceneError) as info:
            read_scene(tmp_path / name)
        assert str(info.value).startswith(f"{tmp_path / name}: ")
        assert text in str(info.value)

    error = outcome(b'name = "ok"\ntitle = "\xe4"\n')
    assert "line 2: not UTF-8 text (byte 0xe4); save it as UTF-8" in str(error)


def test_all_errors_of_a_file_at_once_and_in_its_order():
    text = ARM.replace("mass    =", "mas =").replace("radius = 0.02", "radius = -1")
    text = text.replace('"torque"', '"torqe"').replace('"lower"]', '"lowr"]')
    text = text.replace("1e-3", '"fast"')
    error = outcome(text)
    tables = [str(problem).split("] ")[0] for problem in error.problems]
    assert tables == ["[solver", "[body.upper", "[body.lower", "[joint.shoulder", "[joint.elbow"]


def test_clashing_names():
    extra = """
[body." lower "]
mass = 1
inertia = [0, 0, 0]
"""
    error = outcome(ARM + extra)
    assert '[body." lower "] the name is the same as "lower" in an FMU' in str(error)

    # a free joint and its body may have one name, but not variables of one name
    text = BARGE.replace("sea", "hull").replace("input_axes", 'output = ["zyx"]\ninput_axes')
    error = outcome(text)
    said = "[joint.hull] output: the variable hull.zyx exists already, from [body.hull]"
    assert said in str(error)
    assert outcome(BARGE.replace("sea", "hull")) is None
