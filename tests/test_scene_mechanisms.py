"""Scenes of mechanisms: joints that constrain, drives, contacts, and what they mean in SI."""

import tomllib

import numpy as np
import pytest
from numpy.testing import assert_allclose

from mbdfmi import Scene


def scene_of(**tables):
    """A scene of two bodies, each on a joint, with some tables added or changed."""
    bodies = {name: {"mass": 1, "inertia": [1, 1, 1]} for name in "ab"}
    joints = {name: {"free": {}, "between": ["ground", name]} for name in "ab"}
    tables = {"name": "test", "body": bodies, **tables}
    tables["joint"] = joints | tables.get("joint", {})

    scene = Scene.model_validate(tables)
    assert Scene.model_validate(tomllib.loads(scene.to_toml())) == scene
    return scene


def joint_of(**keys):
    return scene_of(joint={"j": {"between": ["a", "b"], **keys}}).joint["j"]


# joints


@pytest.mark.parametrize(
    "kind, options, start, q, v",
    [
        (
            "cylindrical",
            {},
            {"position": 1, "speed": 2, "angle_deg": 180, "angular_speed_rpm": 60},
            [1, np.pi],
            [2, 2 * np.pi],
        ),
        ("universal", {}, {"angles_deg": [90, 180], "speeds": [1, 2]}, [np.pi / 2, np.pi], [1, 2]),
        (
            "planar",
            {},
            {"position": [1, 2], "angle": 3, "velocity": [4, 5], "angular_speed_deg": 180},
            [1, 2, 3],
            [4, 5, np.pi],
        ),
        ("translation", {}, {"position": [1, 2, 3], "velocity": [4, 5, 6]}, [1, 2, 3], [4, 5, 6]),
        ("screw", {"pitch": 0.1}, {"angle_deg": 90, "angular_speed_rpm": 30}, [np.pi / 2], [np.pi]),
    ],
)
def test_starts(kind, options, start, q, v):
    joint = joint_of(**{kind: options}, start=start)
    assert joint.kind == kind
    assert_allclose(joint.start_position(), q)
    assert_allclose(joint.start_velocity(), v)
    assert joint.start_given == set(start)
    assert joint.holds_position and joint.holds_velocity

    # without a start, nothing is held and all is zero
    joint = joint_of(**{kind: options})
    assert_allclose(joint.start_position(), np.zeros(len(q)))
    assert_allclose(joint.start_velocity(), np.zeros(len(v)))
    assert not (joint.start_given or joint.holds_position or joint.holds_velocity)


@pytest.mark.parametrize(
    "start, position, velocity",
    [
        ({"angle": 0}, True, False),
        ({"speed_rpm": 0}, False, True),
        ({}, False, False),
    ],
)
def test_what_a_start_holds(start, position, velocity):
    joint = joint_of(revolute={}, start=start)
    assert (joint.holds_position, joint.holds_velocity) == (position, velocity)


@pytest.mark.parametrize(
    "kind, options",
    [
        ("point_on_plane", {"normal": [0, 0, 2]}),
        ("point_on_line", {}),
        ("distance", {}),
        ("rolling_sphere", {"radius": 1}),
        ("rolling_disk", {"radius": 1}),
        ("knife_edge", {"lateral": "z"}),
    ],
)
def test_joints_that_only_constrain(kind, options):
    joint = joint_of(**{kind: options}, output=["reaction_force", "reaction_moment"])
    assert joint.kind == kind
    assert_allclose(joint.axis, [0, 0, 1])
    assert joint.start_position().shape == joint.start_velocity().shape == (0,)
    assert (joint.spring, joint.damper, joint.driver, joint.input) == (None, 0, None, ())


def test_axes_and_lengths():
    assert_allclose(joint_of(knife_edge={}).axis, [0, 1, 0])
    assert_allclose(
        joint_of(universal={"axes": ["-z", [1, 1, 0]]}).axes, [[0, 0, -1], [np.sqrt(0.5), np.sqrt(0.5), 0]]
    )
    assert joint_of(distance={}).length is None
    assert joint_of(distance={"length": 2}).length == 2
    assert joint_of(screw={"pitch": -0.1}).pitch == -0.1
    assert joint_of(rolling_sphere={"radius": 3}).radius == 3


@pytest.mark.parametrize(
    "normal, x, y",
    [
        ("z", [1, 0, 0], [0, 1, 0]),
        ("y", [1, 0, 0], [0, 0, -1]),
        ("x", [0, 1, 0], [0, 0, 1]),
        ([1, 0, 1], [np.sqrt(0.5), 0, -np.sqrt(0.5)], [0, 1, 0]),
    ],
)
def test_axes_of_a_plane(normal, x, y):
    A = joint_of(planar={"normal": normal}).axes
    assert_allclose(A[:, 0], x, atol=1e-15)
    assert_allclose(A[:, 1], y, atol=1e-15)
    assert_allclose(np.linalg.det(A), 1)


def test_one_input_needs_no_list():
    assert joint_of(cylindrical={}, input="force").input == ["force"]
    assert joint_of(cylindrical={}, input=["torque", "force"]).input == ["torque", "force"]
    assert joint_of(cylindrical={}).input == []


def test_inertial_frame_is_an_end():
    scene = scene_of(joint={"b": {"translation": {}, "between": ["inertial", "b"]}})
    owner, position, A = scene.marker_pose("inertial")
    assert owner == "inertial"
    assert_allclose(position, np.zeros(3))
    assert_allclose(A, np.eye(3))


# what acts in joints


def test_tables_in_si():
    joint = joint_of(
        revolute={},
        spring={"table": {"position_deg": [-180, 90], "effort": [-1, 2]}},
        damper={"table": {"speed": [0, 1], "effort": [0, 3]}},
    )
    angle, effort = joint.spring.table.points()
    assert_allclose(angle, [-np.pi, np.pi / 2])
    assert_allclose(effort, [-1, 2])
    assert joint.spring.stiffness is None
    assert_allclose(joint.damper.table.points(), [[0, 1], [0, 3]])


def test_friction_and_stops():
    joint = joint_of(
        revolute={}, friction={"coulomb": 2}, stop={"upper_deg": 90, "stiffness": 5, "damping": 1}
    )
    friction, stop = joint.friction, joint.stop
    assert (friction.coulomb, friction.static, friction.viscous) == (2, 2, 0)
    assert (friction.stribeck_speed, friction.smoothing_speed) == (0.1, 3.7e-7)
    assert (stop.lower_value(), stop.stiffness, stop.damping) == (-np.inf, 5, 1)
    assert_allclose(stop.upper_value(), np.pi / 2)


def test_drivers_in_si():
    driver = joint_of(revolute={}, driver={"constant_speed_rpm": 60}, output=["effort"]).driver
    assert driver.kind == "constant_speed"
    assert_allclose(driver.speed(), 2 * np.pi)

    harmonic = {"amplitude_deg": 90, "frequency": 3, "phase_deg": 180, "mean": 1}
    driver = joint_of(revolute={}, driver={"harmonic": harmonic}).driver
    assert driver.kind == "harmonic"
    assert_allclose(driver.harmonic.amplitude_value(), np.pi / 2)
    assert_allclose(driver.harmonic.phase_value(), np.pi)
    assert (driver.harmonic.mean_value(), driver.harmonic.frequency) == (1, 3)

    driver = joint_of(prismatic={}, driver={"table": {"time": [0, 2], "position": [1, 5]}}).driver
    assert driver.kind == "table"
    assert_allclose(driver.table.points(), [[0, 2], [1, 5]])

    # the commands may have start values
    joint = joint_of(revolute={}, driver={"input": True}, start={"angle": 1})
    assert joint.driver.kind == "input"
    assert_allclose(joint.start_position(), [1])


@pytest.mark.parametrize(
    "kind, options, ratio, offset",
    [
        ("gear", {"ratio": -2, "offset_deg": 180}, -2, np.pi),
        ("rack", {"radius": 0.3}, 0.3, None),
        ("screw", {"pitch": np.pi, "offset": 0.1}, 0.5, 0.1),
        ("linear", {"ratio": 7}, 7, None),
    ],
)
def test_couplings(kind, options, ratio, offset):
    slide = "revolute" if kind == "gear" else "prismatic"
    scene = scene_of(
        joint={
            "p": {"revolute": {}, "between": ["ground", "a"]},
            "q": {slide: {}, "between": ["ground", "b"]},
        },
        coupling={"c": {kind: options, "between": ["p", "q"]}},
    )
    coupling = scene.coupling["c"]
    assert (coupling.kind, coupling.between) == (kind, ("p", "q"))
    assert_allclose(coupling.ratio, ratio)
    if offset is None:
        assert coupling.offset is None
    else:
        assert_allclose(coupling.offset, offset)


# motion of the ground, gravity


def motion_of(**motion):
    return scene_of(ground={"motion": motion}).ground.motion


def test_motions_of_the_ground():
    assert scene_of().ground.motion is None

    motion = motion_of(acceleration=[1, 2, 3], velocity=[4, 5, 6])
    assert (motion.kind, motion.acceleration, motion.velocity) == ("acceleration", (1, 2, 3), (4, 5, 6))
    assert motion.position == (0, 0, 0)

    motion = motion_of(rotation={"axis": [0, 3, 4], "speed_rpm": 30, "angle_deg": 90})
    assert motion.kind == "rotation"
    assert_allclose(motion.rotation.direction(), [0, 0.6, 0.8])
    assert_allclose(motion.rotation.speed_value(), np.pi)
    assert_allclose(motion.rotation.angle_value(), np.pi / 2)

    motion = motion_of(orbit={"radius": 7e6, "rate": 1e-3, "phase_deg": 180, "pointing": False})
    assert (motion.kind, motion.orbit.pointing) == ("orbit", False)
    assert_allclose(motion.orbit.axes(), np.eye(3))
    assert_allclose(motion.orbit.phase_value(), np.pi)

    assert motion_of(input=True).kind == "input"


def test_motion_by_table():
    turn = [[0, 0, 0], [170, 0, 0], [340, 0, 0]]
    motion = motion_of(table={"time": [0, 1, 2], "zyx_deg": turn})
    time, position, E = motion.table.points()

    assert motion.kind == "table"
    assert_allclose(time, [0, 1, 2])
    assert_allclose(position, np.zeros((3, 3)))
    # the short way round, without a jump in sign
    half = np.radians([0, 85, 170])
    zero = np.zeros(3)
    assert_allclose(E, np.column_stack([zero, zero, np.sin(half), np.cos(half)]), atol=1e-15)

    quarter = [[0, 0, 0, 1], [0, 0, -np.sqrt(0.5), -np.sqrt(0.5)]]
    motion = motion_of(
        table={"time": [0, 1], "euler_parameters": quarter, "position": [[1, 2, 3], [4, 5, 6]]}
    )
    _, position, E = motion.table.points()
    assert_allclose(position, [[1, 2, 3], [4, 5, 6]])
    assert_allclose(E[1], [0, 0, np.sqrt(0.5), np.sqrt(0.5)])


def test_central_gravity_replaces_the_uniform_one():
    scene = scene_of(central_gravity={"mu": 4e14})
    assert scene.central_gravity.mu == 4e14
    assert scene.gravity == (0, 0, 0)
    assert scene_of().central_gravity is None
    assert scene_of().gravity == (0, 0, -9.81)


# forces, loads, measures


def force_of(**keys):
    return scene_of(force={"f": keys}).force["f"]


def test_strut_with_tables_and_actuator():
    force = force_of(
        spring_damper={
            "table": {"length": [1, 2], "force": [0, 3]},
            "damping": {"table": {"speed": [-1, 1], "force": [-5, 4]}},
        },
        between=["a", "b"],
        input="force",
        output=["rate"],
    )
    assert (force.kind, force.input, force.output) == ("spring_damper", ["force"], ["rate"])
    assert force.spring_damper.stiffness is None
    assert_allclose(force.spring_damper.table.points(), [[1, 2], [0, 3]])
    assert_allclose(force.spring_damper.damping.table.points(), [[-1, 1], [-5, 4]])


def test_bushing_by_diagonal_or_matrix():
    stiffness = np.arange(36.0).reshape(6, 6)
    force = force_of(bushing={"stiffness": stiffness, "damping": [1, 2, 3, 4, 5, 6]}, between=["a", "b"])
    assert (force.kind, force.input, force.output) == ("bushing", (), ())
    assert_allclose(force.bushing.stiffness_matrix(), stiffness)
    assert_allclose(force.bushing.damping_matrix(), np.diag([1, 2, 3, 4, 5, 6]))
    force = force_of(bushing={"stiffness": [1] * 6}, between=["a", "b"])
    assert_allclose(force.bushing.damping_matrix(), np.zeros((6, 6)))


def test_loads():
    force = force_of(load={"moment": [1, 2, 3], "axes": "body"}, on="b")
    assert (force.kind, force.on, force.between) == ("load", "b", ("b",))
    assert (force.load.axes, force.load.table) == ("body", None)
    assert_allclose(force.load.force_vector(), np.zeros(3))
    assert_allclose(force.load.moment_vector(), [1, 2, 3])

    force = force_of(load={"table": {"time": [0, 1], "force": [[0, 0, 0], [1, 2, 3]]}}, on="a")
    time, push, moment = force.load.table.points()
    assert_allclose(time, [0, 1])
    assert_allclose(push, [[0, 0, 0], [1, 2, 3]])
    assert_allclose(moment, np.zeros((2, 3)))


def test_measures_may_be_between_the_frames():
    scene = scene_of(
        ground={"motion": {"acceleration": [1, 0, 0]}},
        measure={"way": {"between": ["inertial", "ground"], "output": ["position", "angle"]}},
    )
    assert scene.measure["way"].between == ("inertial", "ground")
    assert scene.measure["way"].output == ["position", "angle"]


# curves, surfaces, contacts


def marker_of(**keys):
    scene = scene_of(ground={"marker": {"m": keys}})
    return scene.marker("ground.m")


@pytest.mark.parametrize(
    "curve, parameters",
    [
        ({"line": {}}, {}),
        ({"circle": {"radius": 2}}, {"radius": 2}),
        ({"parabola": {"coefficient": -3}}, {"coefficient": -3}),
        ({"cycloid": {"radius": 4}}, {"radius": 4}),
    ],
)
def test_curves(curve, parameters):
    found = marker_of(curve=curve).curve
    assert [found.kind] == list(curve)
    assert found.is_planar
    for name, value in parameters.items():
        assert getattr(found, name) == value


def test_curves_through_points():
    curve = marker_of(curve={"spline": {"points": [[0, 0], [3, 4], [3, 5]]}}).curve
    assert curve.is_planar and not curve.closed
    assert_allclose(curve.points, [[0, 0, 0], [3, 4, 0], [3, 5, 0]])
    assert_allclose(curve.s, [0, 5, 6])

    square = [[0, 0, 1], [1, 0, 1], [1, 1, 1], [0, 1, 1]]
    curve = marker_of(curve={"spline": {"points": square, "closed": True}}).curve
    assert curve.is_planar and curve.closed
    assert_allclose(curve.points, [*square, square[0]])
    assert_allclose(curve.s, [0, 1, 2, 3, 4])

    table = {"s": [1, 2], "points": [[0, 0, 0], [0, 0, 1]]}
    curve = marker_of(curve={"table": table}).curve
    assert (curve.kind, curve.is_planar) == ("table", False)
    assert_allclose(curve.s, [1, 2])


@pytest.mark.parametrize(
    "surface, parameters",
    [
        ({"plane": {}}, {}),
        ({"sphere": {"radius": 2}}, {"radius": 2}),
        ({"cylinder": {"radius": 3}}, {"radius": 3}),
        ({"torus": {"radius": 4, "tube": 1}}, {"radius": 4, "tube": 1}),
    ],
)
def test_surfaces(surface, parameters):
    found = marker_of(surface=surface).surface
    assert [found.kind] == list(surface)
    for name, value in parameters.items():
        assert getattr(found, name) == value


def test_prisms_and_tables():
    surface = marker_of(surface={"prism": {"profile": {"circle": {"radius": 2}}}}).surface
    assert (surface.kind, surface.profile.kind, surface.profile.radius) == ("prism", "circle", 2)

    points = np.random.default_rng(0).normal(size=(4, 5, 3))
    table = {"s1": [0, 1, 2, 3], "s2": [0, 1, 2, 3, 4], "points": points.tolist()}
    surface = marker_of(surface={"table": table}).surface
    assert surface.kind == "table"
    assert_allclose(surface.points, points)
    assert_allclose(surface.s1, [0, 1, 2, 3])
    assert_allclose(surface.s2, [0, 1, 2, 3, 4])


@pytest.mark.parametrize(
    "kind, start_s",
    [
        ("point_on_curve", [0.5]),
        ("curve_on_curve", [0.5, 1]),
        ("point_on_surface", [0.5, 1]),
    ],
)
def test_contacts(kind, start_s):
    shape = {"curve": {"circle": {"radius": 1}}, "surface": {"plane": {}}}
    bodies = {name: {"mass": 1, "inertia": [1, 1, 1], "marker": {"m": shape}} for name in "ab"}

    def contact(**keys):
        joint = {kind: {}, "between": ["a.m", "b.m"], **keys}
        return scene_of(body=bodies, joint={"j": joint}).joint["j"]

    s = start_s if len(start_s) > 1 else start_s[0]
    joint = contact(start={"s": s}, output=["s", "s_rate", "reaction_force"])
    assert_allclose(joint.start_s, start_s)
    assert joint.start_given == {"s"}
    assert joint.start_position().shape == (0,)
    assert contact().start_s is None
