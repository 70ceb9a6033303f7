"""Scenes of mechanisms: joints that constrain, drives, contacts, and what they mean in SI."""

import tomllib

import numpy as np
import pytest
from numpy.testing import assert_allclose

from mbdfmi.scene import Scene


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

@pytest.mark.parametrize("kind, options, start, q, v", [
    ("cylindrical", {}, {"position": 1, "speed": 2, "angle_deg": 180, "angular_speed_rpm": 60},
     [1, np.pi], [2, 2 * np.pi]),
    ("universal", {}, {"angles_deg": [90, 180], "speeds": [1, 2]}, [np.pi / 2, np.pi], [1, 2]),
    ("planar", {}, {"position": [1, 2], "angle": 3, "velocity": [4, 5], "angular_speed_deg": 180},
     [1, 2, 3], [4, 5, np.pi]),
    ("translation", {}, {"position": [1, 2, 3], "velocity": [4, 5, 6]}, [1, 2, 3], [4, 5, 6]),
    ("screw", {"pitch": 0.1}, {"angle_deg": 90, "angular_speed_rpm": 30}, [np.pi / 2], [np.pi]),
])
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


@pytest.mark.parametrize("start, position, velocity", [
    ({"angle": 0}, True, False), ({"speed_rpm": 0}, False, True), ({}, False, False),
])
def test_what_a_start_holds(start, position, velocity):
    joint = joint_of(revolute={}, start=start)
    assert (joint.holds_position, joint.holds_velocity) == (position, velocity)


@pytest.mark.parametrize("kind, options", [
    ("point_on_plane", {"normal": [0, 0, 2]}), ("point_on_line", {}), ("distance", {}),
    ("rolling_sphere", {"radius": 1}), ("rolling_disk", {"radius": 1}),
    ("knife_edge", {"lateral": "z"}),
])
def test_joints_that_only_constrain(kind, options):
    joint = joint_of(**{kind: options}, output=["reaction_force", "reaction_moment"])
    assert joint.kind == kind
    assert_allclose(joint.axis, [0, 0, 1])
    assert joint.start_position().shape == joint.start_velocity().shape == (0,)
    assert (joint.spring, joint.damper, joint.driver, joint.input) == (None, 0, None, ())


def test_axes_and_lengths():
    assert_allclose(joint_of(knife_edge={}).axis, [0, 1, 0])
    assert_allclose(joint_of(universal={"axes": ["-z", [1, 1, 0]]}).axes,
                    [[0, 0, -1], [np.sqrt(0.5), np.sqrt(0.5), 0]])
    assert joint_of(distance={}).length is None
    assert joint_of(distance={"length": 2}).length == 2
    assert joint_of(screw={"pitch": -0.1}).pitch == -0.1
    assert joint_of(rolling_sphere={"radius": 3}).radius == 3


@pytest.mark.parametrize("normal, x, y", [
    ("z", [1, 0, 0], [0, 1, 0]), ("y", [1, 0, 0], [0, 0, -1]), ("x", [0, 1, 0], [0, 0, 1]),
    ([1, 0, 1], [np.sqrt(0.5), 0, -np.sqrt(0.5)], [0, 1, 0]),
])
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
