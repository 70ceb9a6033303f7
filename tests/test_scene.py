"""Scenes: what is read from them, and what they mean."""

import re
import tomllib

import numpy as np
import pytest
from numpy.testing import assert_allclose
from scipy.spatial.transform import Rotation

from mbdfmi import Scene
from mbdfmi.scene import Body, Ground, Marker, Revolute, SceneError, fmi_name, read_scene, write_scene

ARM = """
name    = "two_link_arm"
gravity = [0, 0, -9.81]
output  = ["total_energy"]

[solver]
tolerance = 1e-6

[ground]
marker.site = { position = [0, 0, 1], zyx_deg = [90, 0, 0] }

[body.upper]
mass    = 2.0
com     = [0, 0, -0.25]
inertia = [0.042, 0.042, 0.001]
input   = ["force", "moment"]
input_axes = "body"
marker.elbow = { position = [0, 0, -0.5], output = ["position", "zyx"] }

[body.lower]
solid = { cylinder = { radius = 0.02, length = 0.4, density = 2700 }, position = [0, 0, -0.2] }
marker.tip = { position = [0, 0, -0.4] }

[joint.shoulder]
revolute = { axis = "-y" }
between  = ["ground.site", "upper"]
start    = { angle_deg = 30, speed_rpm = 60 }
spring   = { stiffness = 10, rest_deg = 180 }
damper   = 0.1
input    = "torque"
output   = ["angle", "speed"]

[joint.elbow]
prismatic = { axis = [0, 3, 4] }
between   = ["upper.elbow", "lower"]
start     = { position = 0.1, speed = -2 }
spring    = { stiffness = 5, rest = 0.3 }

[force.strut]
spring_damper = { stiffness = 100, damping = 1 }
between = ["ground", "lower.tip"]
output  = ["length"]
"""


def scene_of(**tables):
    """A scene of one body on one joint, with some tables changed."""
    tables = {
        "name": "test",
        "body": {"a": {"mass": 1, "inertia": [1, 1, 1]}},
        "joint": {"j": {"free": {}, "between": ["ground", "a"]}},
    } | tables
    return Scene.model_validate(tables)


@pytest.fixture
def arm(tmp_path):
    path = tmp_path / "arm.toml"
    path.write_text(ARM)
    return read_scene(path)


# reading


def test_scene_is_read_in_file_order(arm):
    assert arm.name == "two_link_arm"
    assert list(arm.body) == ["upper", "lower"]
    assert list(arm.joint) == ["shoulder", "elbow"]
    assert arm.output == ["total_energy"]
    assert arm.gravity == (0, 0, -9.81)
    assert arm.solver.integrator == "auto"
    assert arm.solver.tolerance == arm.solver.absolute_tolerance == 1e-6


def test_joints_in_si(arm):
    shoulder, elbow = arm.joint.values()

    assert (shoulder.kind, elbow.kind) == ("revolute", "prismatic")
    assert shoulder.between == ("ground.site", "upper")
    assert_allclose(shoulder.axis, [0, -1, 0])
    assert_allclose(shoulder.start_position(), [np.pi / 6])
    assert_allclose(shoulder.start_velocity(), [2 * np.pi])
    assert_allclose(shoulder.spring.rest_value(), np.pi)
    assert (shoulder.damper, shoulder.input) == (0.1, ["torque"])
    assert shoulder.output == ["angle", "speed"]

    assert_allclose(elbow.axis, [0, 0.6, 0.8])
    assert_allclose(elbow.start_position(), [0.1])
    assert_allclose(elbow.start_velocity(), [-2])
    assert elbow.spring.rest_value() == 0.3
    assert (elbow.damper, elbow.input, elbow.output) == (0.0, [], [])


def test_joints_without_coordinates_or_springs():
    scene = scene_of(
        body={name: {"mass": 1, "inertia": [1, 1, 1]} for name in "abc"},
        joint={
            "f": {"fixed": {}, "between": ["ground", "a"]},
            "s": {"spherical": {}, "between": ["a", "b"], "start": {"omega": [1, 2, 3]}},
            "g": {"free": {}, "between": ["ground", "c"]},
        },
    )
    fixed, spherical, free = scene.joint.values()

    assert fixed.start_position().shape == fixed.start_velocity().shape == (0,)
    assert_allclose(spherical.start_position(), [0, 0, 0, 1])
    assert_allclose(spherical.start_velocity(), [1, 2, 3])
    assert_allclose(free.start_position(), [0, 0, 0, 0, 0, 0, 1])
    assert_allclose(free.start_velocity(), np.zeros(6))
    for joint in scene.joint.values():
        assert (joint.spring, joint.damper, list(joint.input), joint.output) == (None, 0, [], [])


def test_body_rates_are_turned_into_the_first_markers_axes():
    start = {"position": [1, 2, 3], "velocity": [4, 5, 6], "zyx_deg": [90, 0, 0], "omega_body": [1, 0, 0]}
    joint = {"free": {}, "between": ["ground", "a"], "start": start}
    joint = scene_of(joint={"j": joint}).joint["j"]

    half = np.sqrt(0.5)
    assert_allclose(joint.start_position(), [1, 2, 3, 0, 0, half, half])
    assert_allclose(joint.start_velocity(), [4, 5, 6, 0, 1, 0], atol=1e-15)


def test_marker_poses(arm):
    owner, position, A = arm.marker_pose("ground.site")
    assert owner == "ground"
    assert_allclose(position, [0, 0, 1])
    assert_allclose(A, [[0, -1, 0], [1, 0, 0], [0, 0, 1]], atol=1e-15)

    assert arm.marker_pose("upper.elbow")[0] == "upper"
    for end in ("ground", "upper"):
        owner, position, A = arm.marker_pose(end)
        assert owner == end
        assert_allclose(position, np.zeros(3))
        assert_allclose(A, np.eye(3))


def test_inputs_and_outputs(arm):
    upper = arm.body["upper"]
    assert (upper.input, upper.input_axes, upper.output) == (["force", "moment"], "body", [])
    assert upper.marker["elbow"].output == ["position", "zyx"]
    assert arm.body["lower"].input_axes == "inertial"
    assert arm.force["strut"].output == ["length"]


def test_linear_force_matrices():
    mass = np.diag([1.0, 2, 3, 4, 5, 6])
    mass[0, 4], mass[4, 0] = 1.0, 1.001
    force = {
        "linear": {"added_mass": mass.tolist(), "preload": [1, 2, 3, 4, 5, 6]},
        "between": ["ground", "a"],
    }
    force = scene_of(force={"f": force}).force["f"]

    assert force.kind == "linear"
    assert_allclose(force.linear.added_mass_matrix(), (mass + mass.T) / 2)
    assert_allclose(force.linear.preload_vector(), [1, 2, 3, 4, 5, 6])
    assert_allclose(force.linear.stiffness_matrix(), np.zeros((6, 6)))
    assert_allclose(force.linear.damping_matrix(), np.zeros((6, 6)))


@pytest.mark.parametrize("first, second", [(0.9945, 1.004), (1.004, 0.9945)])
def test_an_added_mass_is_judged_by_its_mean_with_its_transpose(first, second):
    """As it is used: which of two values measured a little differently stands where makes nothing of it."""
    mass = np.eye(6)
    mass[0, 1], mass[1, 0] = first, second
    force = {"linear": {"added_mass": mass.tolist()}, "between": ["ground", "a"]}
    assert scene_of(force={"f": force}).force["f"].linear.added_mass_matrix()[0, 1] == (first + second) / 2

    mass[:2, :2] += [[0, 0.002], [0.002, 0]]
    force["linear"]["added_mass"] = mass.tolist()

    with pytest.raises(SceneError, match="is not positive semidefinite"):
        scene_of(force={"f": force})


def test_spring_damper_defaults(arm):
    options = arm.force["strut"].spring_damper
    assert (options.stiffness, options.damping, options.rest_length) == (100, 1, None)


# orientations

TURN = Rotation.from_euler("ZYX", [0.3, -0.4, 0.5])
COLUMNS = dict(zip("xyz", TURN.as_matrix().T.tolist()))


@pytest.mark.parametrize(
    "written",
    [
        {"euler_parameters": TURN.as_quat().tolist()},
        {"euler_parameters": (1.0005 * TURN.as_quat()).tolist()},
        {"zyx_rad": [0.3, -0.4, 0.5]},
        {"zyx_deg": np.degrees([0.3, -0.4, 0.5]).tolist()},
        {"axis_angle": {"axis": TURN.as_rotvec().tolist(), "angle_rad": TURN.magnitude()}},
        {"axis_angle": {"axis": TURN.as_rotvec().tolist(), "angle_deg": np.degrees(TURN.magnitude())}},
        {"axes": {"x": COLUMNS["x"], "z": COLUMNS["z"]}},
        {"axes": {"z": COLUMNS["z"], "y": COLUMNS["y"]}},
        {"axes": {"y": COLUMNS["y"], "x": COLUMNS["x"]}},
        {"axes": {"x": COLUMNS["x"], "y": np.add(COLUMNS["y"], 3 * np.array(COLUMNS["x"])).tolist()}},
    ],
)
def test_five_ways_to_write_an_orientation(written):
    _, A = Marker(**written).pose()
    assert_allclose(A, TURN.as_matrix(), atol=1e-12)


def test_zyx_is_yaw_pitch_roll():
    def elementary(axis, angle):
        return Rotation.from_rotvec(angle * np.eye(3)["xyz".index(axis)]).as_matrix()

    _, A = Marker(zyx_rad=[0.3, -0.4, 0.5]).pose()
    assert_allclose(A, elementary("z", 0.3) @ elementary("y", -0.4) @ elementary("x", 0.5))


def test_the_first_named_axis_is_kept():
    _, A = Marker(axes={"z": [1, 0, 1], "x": [1, 0, 0]}).pose()
    assert_allclose(A[:, 2], np.array([1, 0, 1]) / np.sqrt(2))
    assert_allclose(A[:, 0], np.array([1, 0, -1]) / np.sqrt(2))


# mass properties


def quadrature(inside, half, n=120):
    """Mass, centre and inertia about it of a shape of unit density within a box, by midpoints."""
    ticks = [(np.arange(n) + 0.5) / n * 2 * h - h for h in half]
    points = np.stack(np.meshgrid(*ticks, indexing="ij"), axis=-1).reshape(-1, 3)
    points = points[inside(points)]

    cell = np.prod(2 * np.array(half) / n)
    com = points.mean(axis=0)
    r = points - com
    inertia = np.einsum("ij,ij->", r, r) * np.eye(3) - r.T @ r
    return len(points) * cell, com, inertia * cell


def test_sphere_in_closed_form():
    body = Body(solid={"sphere": {"radius": 0.3, "mass": 5}, "position": [1, 2, 3]})
    mass, com, inertia = body.mass_properties()
    assert mass == 5
    assert_allclose(com, [1, 2, 3])
    assert_allclose(inertia, 2 / 5 * 5 * 0.3**2 * np.eye(3), atol=1e-15)


def test_box_in_closed_form():
    mass, _, inertia = Body(solid={"box": {"size": [1, 2, 3], "density": 2}}).mass_properties()
    assert mass == 12
    assert_allclose(inertia, np.diag([4 + 9, 1 + 9, 1 + 4]))


@pytest.mark.parametrize("axis, order", [("z", [0, 1, 2]), ("-x", [1, 2, 0]), ("y", [2, 0, 1])])
def test_tube_and_cylinder_in_closed_form(axis, order):
    R, r, L = 0.5, 0.4, 2.0
    outer = {"cylinder": {"radius": R, "length": L, "density": 10}, "axis": axis}
    inner = {"cylinder": {"radius": r, "length": L, "density": 10}, "axis": axis}
    tube = {"tube": {"radius": R, "inner_radius": r, "length": L, "density": 10}, "axis": axis}
    m_outer, _, I_outer = Body(solid=outer).mass_properties()
    m_inner, _, I_inner = Body(solid=inner).mass_properties()
    m, _, inertia = Body(solid=tube).mass_properties()

    across = m_outer * (3 * R**2 + L**2) / 12
    assert_allclose(np.diag(I_outer)[order], [across, across, m_outer * R**2 / 2])
    assert_allclose(m, m_outer - m_inner)
    assert_allclose(inertia, I_outer - I_inner, atol=1e-12)


def test_orientation_and_axis_of_a_solid_agree():
    cylinder = {"radius": 0.1, "length": 1, "mass": 2}
    turned = Body(solid={"cylinder": cylinder, "zyx_deg": [30, 90, 0]}).mass_properties()[2]
    along = Body(solid={"cylinder": cylinder, "axis": [np.sqrt(3), 1, 0]}).mass_properties()[2]
    assert_allclose(turned, along, atol=1e-12)


def test_composite_against_quadrature():
    # a sphere beside a tilted box, not overlapping
    turn = Rotation.from_euler("ZYX", [0.4, 0.3, -0.2])
    size, place = np.array([0.6, 0.4, 0.8]), np.array([0.5, 0.1, -0.2])
    centre, radius = np.array([-0.5, 0.2, 0.3]), 0.4

    def inside(points):
        local = turn.inv().apply(points - place)
        in_box = np.all(np.abs(local) < size / 2, axis=1)
        return in_box | (np.linalg.norm(points - centre, axis=1) < radius)

    body = Body(
        solid=[
            {"sphere": {"radius": radius, "density": 1}, "position": centre},
            {"box": {"size": size, "density": 1}, "position": place, "zyx_rad": [0.4, 0.3, -0.2]},
        ]
    )
    for found, expected in zip(body.mass_properties(), quadrature(inside, [1.1, 0.8, 0.9])):
        assert_allclose(found, expected, rtol=5e-3, atol=5e-4)


def test_inertia_written_in_three_ways():
    six = [3, 4, 5, 0.1, 0.2, 0.3]
    matrix = [[3, 0.1, 0.2], [0.1, 4, 0.3], [0.2, 0.3, 5]]
    assert_allclose(Body(mass=1, inertia=six).mass_properties()[2], matrix)
    assert_allclose(Body(mass=1, inertia=np.array(matrix)).mass_properties()[2], matrix)
    assert_allclose(Body(mass=1, inertia=[3, 4, 5]).mass_properties()[2], np.diag([3, 4, 5]))


def test_inertia_axes():
    body = Body(mass=1, com=[1, 0, 0], inertia=[3, 4, 5], inertia_axes={"zyx_deg": [90, 0, 0]})
    _, com, inertia = body.mass_properties()
    assert_allclose(inertia, np.diag([4, 3, 5]), atol=1e-15)
    assert_allclose(com, [1, 0, 0])


@pytest.mark.parametrize("inertia", [[0, 0, 0], [0, 2, 2], [1, 1, 2], [0.0333, 0.0333, 0.0667]])
def test_points_lines_and_rounded_plates_are_bodies(inertia):
    assert_allclose(Body(mass=1, inertia=inertia).mass_properties()[2], np.diag(inertia))


# names


@pytest.mark.parametrize(
    "text, name",
    [
        ("blade_1", "blade_1"),
        ("blade 1", "'blade 1'"),
        ("1st", "'1st'"),
        ('crane\'s "hook"', r"'crane\'s \"hook\"'"),
        ("a\\b", r"'a\\b'"),
        ("Flügel", "Flugel"),
        ("α-arm", "'(U+03B1)-arm'"),
    ],
)
def test_fmi_names(text, name):
    # the grammar of the structured naming convention, one part of a name
    grammar = (
        r"[A-Za-z_][A-Za-z_0-9]*|"
        r"'([A-Za-z_0-9!#$%&()*+,\-./:;<>=?@\[\]^{}|~ ]|\\['\"?\\abfnrtv])+'"
    )
    assert fmi_name(text) == name
    assert re.fullmatch(grammar, name)


def test_names_are_free_text_and_stripped():
    scene = scene_of(
        body={" blade 1 ": {"mass": 1, "inertia": [0, 0, 0], "marker": {"the tip": {}}}},
        joint={"j": {"free": {}, "between": ["ground", "blade 1 . the tip"]}},
    )
    assert list(scene.body) == ["blade 1"]
    assert scene.joint["j"].between == ("ground", "blade 1.the tip")
    assert scene.marker_pose("blade 1.the tip")[0] == "blade 1"


# writing, and scenes made in Python


def test_written_scene_reads_as_the_same(arm, tmp_path):
    path = tmp_path / "copy.toml"
    write_scene(arm, path)
    assert read_scene(path) == arm
    assert [file.name for file in tmp_path.glob("copy*")] == ["copy.toml"]


def test_written_scene_keeps_odd_texts_and_long_matrices():
    rows = (1e5 * np.eye(6) + 1.23456789e-300).tolist()
    scene = scene_of(
        description='two lines,\n"quoted" \\ é',
        body={'a "b" é': {"mass": 1, "inertia": [0, 0, 0], "marker": {"x y": {}}}},
        joint={"j": {"free": {}, "between": ["ground", 'a "b" é.x y']}},
        force={"f": {"linear": {"stiffness": rows}, "between": ["ground", 'a "b" é']}},
    )
    text = scene.to_toml()
    assert Scene.model_validate(tomllib.loads(text)) == scene
    assert max(map(len, text.splitlines())) <= 160


def test_scene_from_parts(arm):
    joint = Revolute(revolute={"axis": np.array([0, 1, 0])}, between=("ground", "link"))
    link = Body(mass=np.float32(2), inertia=np.eye(3))
    scene = Scene(name="link", body={"link": link}, joint={"pin": joint})

    assert_allclose(scene.joint["pin"].axis, [0, 1, 0])
    assert scene.body["link"].mass == 2
    assert Scene.model_validate(scene.model_dump(exclude_unset=True)) == scene


def test_parts_made_in_python_raise_scene_errors():
    with pytest.raises(SceneError, match="mass: must not be negative"):
        Body(mass=-1, inertia=[0, 0, 0])
    with pytest.raises(SceneError, match=r'\[joint.j\] between: no body "b"'):
        Scene(
            name="x",
            body={"a": Body(mass=1, inertia=[0, 0, 0])},
            joint={"j": Revolute(revolute={}, between=["ground", "b"])},
        )


def test_loops_are_allowed():
    bodies = {name: {"mass": 1, "inertia": [1, 1, 1]} for name in "ab"}
    ends = [("ground", "a"), ("a", "b"), ("b", "ground")]
    joints = {f"j{i}": {"revolute": {}, "between": list(e)} for i, e in enumerate(ends)}
    assert len(scene_of(body=bodies, joint=joints).joint) == 3


def test_written_scenes_keep_the_order_of_markers():
    """One that is too long for a line comes as a table, and those after it too: variables are in the order of the file."""
    long = {
        "position": [1 / 3, 2 / 3, 1 / 7],
        "euler_parameters": [0.5, 0.5, 0.5, 0.5],
        "output": ["position", "velocity", "omega"],
    }
    markers = {"c": {"output": ["position"]}, "b": long, "a": {"output": ["omega"]}, "e": {}, "d": long}
    scene = scene_of(
        body={"body": {"mass": 1, "inertia": [1, 1, 1], "marker": markers}},
        joint={"j": {"free": {}, "between": ["ground", "body"]}},
    )
    again = Scene.model_validate(tomllib.loads(scene.to_toml()))
    assert again == scene and list(again.body["body"].marker) == list("cbaed")


@pytest.mark.parametrize("cls", [Scene, Body, Ground])
def test_a_validator_is_of_its_class_alone(cls):
    """Those of all kinds of tables together take ten times as long to build as those that a scene has."""
    cls.model_rebuild()
    assert repr(cls.__pydantic_core_schema__).count("'type': 'model'") == 1
    assert cls.model_json_schema()["$defs"]["Marker" if cls is Body else "GroundMarker"]["properties"][
        "curve"
    ]
