"""Good scene files that together have all there is, and what must be of any file: a sound scene, or messages."""

import tomllib

import numpy as np

from mbdfmi import Scene
from mbdfmi.scene import SceneError, parse_scene

ARM = """\
name    = "arm"
output  = ["total_energy"]

[solver]
integrator = "rk4"
step = 1e-3

[ground]
marker.site = { position = [0, 0, 1], zyx_deg = [90, 0, 0] }

[body.upper]
mass    = 2.0
com     = [0, 0, -0.25]
inertia = [0.042, 0.042, 0.001]
inertia_axes = { euler_parameters = [0, 0, 0, 1] }
marker.elbow = { position = [0, 0, -0.5], output = ["position"] }
marker.tip = { axes = { z = [0, 0, 1], x = "y" } }

[body.lower]
solid = { cylinder = { radius = 0.02, length = 0.4, density = 2700 }, axis = "z" }

[joint.shoulder]
revolute = { axis = "y" }
between  = ["ground.site", "upper"]
start    = { angle_deg = 30, speed = 1 }
input    = "torque"
output   = ["angle", "speed"]

[joint.elbow]
revolute = { axis = [0, 1, 0] }
between  = ["upper.elbow", "lower"]
spring   = { stiffness = 10, rest_deg = 5 }
damper   = 0.1
"""

BARGE = """\
name = "barge"
gravity = [0, 0, -9.81]

[solver]
tolerance = 1e-6
max_step = 0.1

[body.hull]
solid = [
    { box = { size = [40, 40, 10], mass = 5e6 }, position = [0, 0, 1] },
    { tube = { radius = 3, inner_radius = 2.9, length = 80, density = 7850 }, axis = "z" },
    { sphere = { radius = 1, density = 1000 }, zyx_rad = [0, 0, 1] },
]
input = ["force", "moment"]
input_axes = "body"

[body.weight]
mass = 10
inertia = [1, 1, 1, 0, 0, 0]

[joint.sea]
free = {}
between = ["ground", "hull"]
start = { position = [0, 0, 1], axis_angle = { axis = "x", angle_deg = 5 }, omega = [0, 0, 1] }
output = ["position", "zyx"]

[joint.ball]
spherical = {}
between = ["hull", "weight"]
output = ["omega"]

[force.line]
spring_damper = { stiffness = 1e4, damping = 10, rest_length = 1 }
between = ["ground", "weight"]
output = ["length"]

[force.water]
between = ["ground", "hull"]

[force.water.linear]
preload = [0, 0, 1e6, 0, 0, 0]
stiffness = [
    [1, 0, 0, 0, 0, 0], [0, 1, 0, 0, 0, 0], [0, 0, 1, 0, 0, 0],
    [0, 0, 0, 1, 0, 0], [0, 0, 0, 0, 1, 0], [0, 0, 0, 0, 0, 1],
]
added_mass = [
    [1, 0, 0, 0, 0, 0], [0, 1, 0, 0, 0, 0], [0, 0, 1, 0, 0, 0],
    [0, 0, 0, 1, 0, 0], [0, 0, 0, 0, 1, 0], [0, 0, 0, 0, 0, 1],
]
"""

CARRIAGE = """\
name = "carriage"

[solver]
integrator = "rk853"
formulation = "embedding"
start = "given"

[ground]
marker.road = { zyx_deg = [0, 0, 5] }

[body.frame]
mass = 10
inertia = [1, 1, 1]

[body.wheel]
mass = 1
inertia = [0.1, 0.1, 0.2]

[body.ball]
mass = 1
inertia = [0.1, 0.1, 0.1]

[body.bead]
mass = 0.1
inertia = [0, 0, 0]

[joint.slide]
planar = { normal = "z" }
between = ["ground.road", "frame"]
start = { position = [0, 1], angle_deg = 10, velocity = [1, 0], angular_speed_rpm = 2 }
output = ["position", "angle", "velocity", "angular_speed", "reaction_force"]

[joint.axle]
cylindrical = { axis = "y" }
between = ["frame", "wheel"]
start = { position = 0.1, speed = 0.2, angle = 0.3, angular_speed = 0.4 }
input = ["force", "torque"]
output = ["position", "speed", "angle", "angular_speed"]

[joint.cross]
universal = { axes = ["x", [0, 1, 1]] }
between = ["frame", "ball"]
start = { angles_deg = [1, 2], speeds = [3, 4] }
output = ["angles", "speeds"]

[joint.shift]
translation = {}
between = ["inertial", "bead"]
start = { position = [1, 2, 3], velocity = [4, 5, 6] }
output = ["position", "velocity"]

[joint.thread]
screw = { axis = "x", pitch = 0.01 }
between = ["ground", "ball"]
start = { angle_deg = 5, angular_speed_deg = 6 }
input = "torque"
output = ["position"]

[joint.touch]
point_on_plane = { normal = [0, 0, 2] }
between = ["ground", "ball"]
output = ["reaction_moment"]

[joint.rail]
point_on_line = {}
between = ["ground", "bead"]

[joint.rod]
distance = { length = 2 }
between = ["ball", "bead"]

[joint.roll]
rolling_disk = { radius = 0.5, axis = "y" }
between = ["ground.road", "wheel"]

[joint.marble]
rolling_sphere = { radius = 0.1 }
between = ["ground.road", "ball"]

[joint.edge]
knife_edge = { lateral = "y" }
between = ["ground.road", "frame"]
"""

DRIVES = """\
name = "drives"

[central_gravity]
mu = 3.986e14

[ground.motion]
orbit = { radius = 7e6, rate = 1e-3, normal = "-y", phase_deg = 30, pointing = true }

[body.rotor]
mass = 1
inertia = [1, 1, 1]

[body.slide]
mass = 1
inertia = [0, 0, 0]

[body.arm]
mass = 1
inertia = [1, 1, 1]

[body.tool]
mass = 1
inertia = [1, 1, 1]

[joint.motor]
revolute = { axis = "x" }
between = ["ground", "rotor"]
start = { angle_deg = 20 }
driver = { constant_speed_rpm = 300 }
output = ["effort"]

[joint.rail]
prismatic = {}
between = ["ground", "slide"]
spring = { table = { position = [-1, 0, 2], effort = [-5, 0, 7] } }
damper = { table = { speed = [-1, 1], effort = [-2, 2] } }
friction = { coulomb = 1, static = 2, stribeck_speed = 0.2, viscous = 1, smoothing_speed = 1e-4 }
stop = { lower = -1, upper = 2, stiffness = 1e5, damping = 10 }

[joint.hinge]
revolute = {}
between = ["slide", "arm"]
stop = { upper_deg = 90, stiffness = 1e3 }
driver = { harmonic = { amplitude_deg = 10, frequency = 2, phase_deg = 90, mean = 0.1 } }

[joint.wrist]
revolute = {}
between = ["arm", "tool"]
driver = { table = { time = [0, 1, 2], position_deg = [0, 90, 0] } }

[joint.wheel]
revolute = {}
between = ["ground", "tool"]

[coupling.pinion]
rack = { radius = 0.1, offset = 1 }
between = ["motor", "rail"]

[coupling.sync]
gear = { ratio = -2, offset_deg = 5 }
between = ["motor", "wheel"]
"""

LOADS = """\
name = "loads"
output = ["linear_momentum", "center_of_mass", "constraint_gap", "multipliers"]

[body.a]
mass = 1
inertia = [1, 1, 1]
output = ["acceleration", "alpha_body"]
marker.m = { position = [1, 0, 0] }

[body.b]
mass = 1
inertia = [1, 1, 1]

[joint.a]
free = {}
between = ["ground", "a"]

[joint.b]
free = {}
between = ["ground", "b"]

[force.actuator]
spring_damper = { table = { length = [0, 1], force = [0, 5] }, damping = 2 }
between = ["ground", "a.m"]
input = "force"
output = ["length", "rate"]

[force.damper]
spring_damper = { stiffness = 0, damping = { table = { speed = [-1, 1], force = [-2, 1] } } }
between = ["a", "b"]
output = ["force"]

[force.mount]
bushing = { stiffness = [1, 2, 3, 4, 5, 6], damping = [1, 1, 1, 0, 0, 0] }
between = ["a", "b"]

[force.push]
load = { force = [1, 0, 0], axes = "body" }
on = "a.m"

[force.gust]
on = "b"

[force.gust.load.table]
time = [0, 1]
force = [[0, 0, 0], [1, 0, 0]]
moment = [[0, 0, 0], [0, 0, 1]]

[measure.gap]
between = ["a.m", "b"]
output = ["distance", "distance_rate", "angle", "acceleration"]
"""

SHAPES = """\
name = "shapes"

[ground]
marker.wire = { curve = { cycloid = { radius = 1 } } }
marker.hill = { surface = { prism = { profile = { parabola = { coefficient = 0.1 } } } } }
marker.ring = { surface = { torus = { radius = 2, tube = 0.5 } } }

[ground.marker.net.surface.table]
s1 = [0, 1, 2, 3]
s2 = [0, 1, 2, 3]
points = [
    [[0, 0, 0], [0, 1, 0], [0, 2, 0], [0, 3, 0]],
    [[1, 0, 0], [1, 1, 0], [1, 2, 0], [1, 3, 0]],
    [[2, 0, 0], [2, 1, 0], [2, 2, 0], [2, 3, 0]],
    [[3, 0, 0], [3, 1, 0], [3, 2, 0], [3, 3, 0]],
]

[body.cam]
mass = 1
inertia = [1, 1, 1]

[body.cam.marker.edge.curve]
spline = { points = [[1, 0], [0, 1], [-1, 0], [0, -1]], closed = true }

[body.follower]
mass = 1
inertia = [1, 1, 1]
marker.roller = { position = [2, 0, 0], curve = { circle = { radius = 0.1 } } }
marker.rail = { curve = { table = { s = [0, 2, 3], points = [[0, 0, 0], [1, 0, 1], [2, 0, 0]] } } }
marker.ball = { surface = { sphere = { radius = 1 } } }

[joint.shaft]
revolute = {}
between = ["ground", "cam"]

[joint.guide]
prismatic = { axis = "x" }
between = ["ground", "follower"]

[joint.lift]
curve_on_curve = {}
between = ["cam.edge", "follower.roller"]
start = { s = [0, 3.14] }
output = ["s", "s_rate"]

[joint.thread]
point_on_curve = {}
between = ["ground.wire", "cam"]
start = { s = 0.5 }

[joint.skin]
point_on_surface = {}
between = ["ground.ring", "follower"]
"""

LED = """\
name = "led"

[ground]
marker.bowl = { surface = { ellipsoid = { semi_axes = [2, 1.5, 1] } } }
marker.track = { curve = { circle = { radius = 1 } } }
marker.road = { surface = { plane = {} } }

[body.platform]
mass = 1
inertia = [1, 1, 1]

[body.car]
mass = 1
inertia = [1, 1, 1]
marker.skin = { surface = { ellipsoid = { semi_axes = [0.1, 0.2, 0.1] } } }

[body.wheel]
mass = 1
inertia = [1, 1, 1]
marker.edge = { surface = { disk = { radius = 0.5 } } }

[joint.move]
prescribed = {}
between = ["ground", "platform"]
start = { position = [0, 0, 1], zyx_deg = [0, 20, 0] }
output = ["position", "zyx", "driver_force", "driver_torque"]

[joint.move.driver]
x = { harmonic = { amplitude = 0.1, frequency = 1 } }
y = { ramp = { time = [0, 1], position = [0, 1] } }
z = { input = ["position"] }
yaw = { table = { time = [0, 1, 2], position_deg = [0, 10, 0] } }
pitch = { hold = true }
roll = { constant_speed_deg = 5 }

[joint.drive]
frame_on_curve = { side = "z", spin = "free" }
between = ["ground.track", "car"]
driver = { speed_table = { time = [0, 1], speed = [0, 1] } }
start = { s = 0.5 }
output = ["s", "effort", "driver_power"]

[joint.float]
free = {}
between = ["platform", "wheel"]

[joint.car]
free = {}
between = ["ground", "car"]

[joint.slide]
surface_on_surface = {}
between = ["ground.bowl", "car.skin"]
start = { s = [0, 0.5] }
output = ["s", "contact_point", "normal_force"]

[joint.roll]
rolling_surface = {}
between = ["ground.road", "wheel.edge"]
output = ["s_rate", "friction_force"]
"""

LOOKS = """\
name = "looks"

[experiment]
start = 1
stop = 20
step = 0.1
tolerance = 1e-5

[view]
up = "z"
water = 0.5
ground = "none"
frame = "mast"
look_from = [1, -1, 0.5]
paths = ["mast.top"]
plots = ["sway.angle"]

[ground]
colour = "grey"
shape = { box = { size = [2, 2, 0.1] }, position = [0, 0, -0.05] }
marker.wall = { position = [1, 0, 0], shape = { tube = { radius = 0.2, inner_radius = 0.1, length = 1 }, axis = "x" } }

[body.mast]
mass = 1
inertia = [1, 1, 1]
colour = "#4682b4"
shape = [
    { capsule = { radius = 0.1, length = 1 }, position = [0, 0, 0.5], opacity = 0.5 },
    { cone = { radius = 0.1, top_radius = 0.05, length = 1 }, zyx_deg = [0, 90, 0], colour = "tomato" },
    { mesh = { file = "parts/hook.stl", scale = 0.001 } },
    { mesh = { file = "hull.obj", scale = [1, 1, -1] }, position = [0, 0, 1] },
    { line = ["mast", "mast.top"], radius = 0.01 },
    { sphere = { radius = 1 } },
    { cylinder = { radius = 1, length = 1 } },
]
marker.top = { position = [0, 0, 1], colour = "red" }

[joint.sway]
revolute = { axis = "y" }
between = ["ground.wall", "mast"]
output = ["angle"]
"""

GOOD = {
    "arm": ARM,
    "barge": BARGE,
    "carriage": CARRIAGE,
    "drives": DRIVES,
    "loads": LOADS,
    "shapes": SHAPES,
    "led": LED,
    "looks": LOOKS,
}


def outcome(content):
    """The SceneError that a file of this content ends in, or None for a sound scene."""
    try:
        scene = parse_scene(content if isinstance(content, bytes) else content.encode(), "a.toml")
    except SceneError as error:
        assert error.errors
        for message in error.errors:
            assert message.startswith("a.toml: ")
            assert len(message) > len("a.toml: ") + 10
            assert "\n" not in message
            # words of the machinery have no place in a message
            assert not any(word in message for word in ("pydantic", "Traceback", "Input should"))
        return error

    check_sound(scene)
    return None


def check_sound(scene):
    for body in scene.body.values():
        mass, com, inertia = body.mass_properties()
        assert mass >= 0 and np.isfinite(com).all() and np.isfinite(inertia).all()
        for end in (marker.pose() for marker in body.marker.values()):
            assert all(np.isfinite(part).all() for part in end)
    for holder in (scene.ground, *scene.body.values()):
        for marker in holder.marker.values():
            if marker.curve and marker.curve.kind in ("spline", "table"):
                assert (np.diff(marker.curve.s) > 0).all()
                assert marker.curve.points.shape == (len(marker.curve.s), 3)
    for joint in scene.joint.values():
        assert np.isclose(np.linalg.norm(joint.axis), 1)
        assert np.isfinite(joint.start_position()).all()
        assert np.isfinite(joint.start_velocity()).all()
        for end in joint.between:
            scene.marker_pose(end)
    for coupling in scene.coupling.values():
        assert np.isfinite(coupling.ratio) and set(coupling.between) <= set(scene.joint)
    assert Scene.model_validate(tomllib.loads(scene.to_toml())) == scene
