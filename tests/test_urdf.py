"""Robots from URDF files: each thing that such a file says, closed forms, and what is told of the rest."""

import re

import numpy as np
import pytest
import trimesh
from numpy.testing import assert_allclose

import mbdfmi
from mbdfmi import cli
from mbdfmi.run.instance import Instance
from mbdfmi.scene import SceneError
from mbdfmi.scene.meshes import load_mesh

G = 9.81
SOLID = '<inertial><mass value="2"/><inertia ixx="0.1" iyy="0.2" izz="0.25"/></inertial>'


def link(name, inside=""):
    return f'<link name="{name}">{inside}</link>'


def joint(name, kind, parent, child, inside=""):
    return (
        f'<joint name="{name}" type="{kind}"><parent link="{parent}"/><child link="{child}"/>{inside}</joint>'
    )


def robot(*parts, name="robot"):
    return "\n".join([f'<robot name="{name}">', *parts, "</robot>"])


@pytest.fixture
def load(tmp_path):
    """Reads the text of a URDF file."""

    def load(*parts, name="robot.urdf", **options):
        path = tmp_path / name
        path.write_text(parts[0] if parts[0].startswith("<robot") else robot(*parts), encoding="utf-8")
        return mbdfmi.load(path, **options)

    return load


def outputs(scene, parameters=None, inputs=None):
    """Outputs of a scene at its start, by name."""
    model = scene.compile()
    places = {v.name: v.index for v in model.of_causality("input")}
    instance = Instance(
        model, parameters, inputs={places[name]: value for name, value in (inputs or {}).items()}
    )
    return dict(zip((v.name for v in model.of_causality("output")), instance.outputs().tolist()))


def told(scene, text):
    """The one note that says it."""
    (note,) = [note for note in scene.import_notes if text in note]
    return note


# mechanics


def test_a_pendulum_of_a_turned_inertia(load):
    """xyz and rpy of the inertia, of the joint, an axis of any direction, damping and friction, in closed form."""
    roll, pitch, yaw = 0.3, -0.4, 0.7
    inertia = f"""<inertial><origin xyz="0.1 -0.2 0.4" rpy="{roll} {pitch} {yaw}"/><mass value="3"/>
        <inertia ixx="0.3" iyy="0.2" izz="0.25" ixy="0.01" ixz="-0.02" iyz="0.03"/></inertial>"""
    dynamics = (
        '<origin xyz="1 2 3" rpy="0.2 0.1 -0.5"/><axis xyz="1 2 -2"/><dynamics damping="0.7" friction="0.4"/>'
    )
    scene = load(link("a", SOLID), link("b", inertia), joint("j", "continuous", "a", "b", dynamics))
    scene.joint["j"].output = ["acceleration"]
    angle, speed, torque = 0.8, 1.5, 2.5
    found = outputs(scene, {"j.angle_start": angle, "j.speed_start": speed}, {"j.torque": torque})

    def turn(axis, angle):
        x, y, z = axis
        K = np.array([[0, -z, y], [z, 0, -x], [-y, x, 0]])
        return np.eye(3) + np.sin(angle) * K + (1 - np.cos(angle)) * K @ K

    def rpy(roll, pitch, yaw):
        return turn([0, 0, 1], yaw) @ turn([0, 1, 0], pitch) @ turn([1, 0, 0], roll)

    axis, com = np.array([1, 2, -2]) / 3, np.array([0.1, -0.2, 0.4])
    A = rpy(roll, pitch, yaw)
    I = A @ np.array([[0.3, 0.01, -0.02], [0.01, 0.2, 0.03], [-0.02, 0.03, 0.25]]) @ A.T
    J = axis @ I @ axis + 3 * np.sum(np.cross(axis, com) ** 2)
    weight = (rpy(0.2, 0.1, -0.5) @ turn(axis, angle)).T @ [0, 0, -3 * G]
    effort = torque - 0.7 * speed - 0.4 + axis @ np.cross(com, weight)
    assert_allclose(found["j.acceleration"], effort / J, rtol=1e-13)


def test_a_slide_falls_and_fixed_links_are_one(load):
    """Two links of 2 kg, one fixed to the other, on a slide that leans by 0.5 rad."""
    scene = load(
        link("base"), link("a", SOLID), link("b", SOLID),
        joint("slide", "prismatic", "base", "a", '<origin rpy="0 0.5 0"/><axis xyz="0 0 1"/>'),
        joint("weld", "fixed", "a", "b", '<origin xyz="0 0 1"/>'),
    )  # fmt: skip
    scene.joint["slide"].output = ["acceleration"]
    assert scene.joint["weld"].kind == "fixed"
    assert_allclose(outputs(scene)["slide.acceleration"], -G * np.cos(0.5), rtol=1e-14)
    assert_allclose(
        outputs(scene, inputs={"slide.force": 40.0})["slide.acceleration"], 10 - G * np.cos(0.5), rtol=1e-14
    )


def test_mimic_is_a_coupling(load):
    """b = -3 a + 0.2: a and b slide up and down, m a'' = (F + G^T f) with both masses; c follows b, so c = 2 b - 1."""
    up = '<axis xyz="0 0 1"/>'
    scene = load(
        link("base", SOLID), *(link(name, SOLID) for name in "abc"),
        joint("a", "prismatic", "base", "a", up),
        joint("b", "prismatic", "base", "b", up + '<mimic joint="a" multiplier="-3" offset="0.2"/>'),
        joint("c", "prismatic", "base", "c", up + '<mimic joint="b" multiplier="2" offset="-1"/>'),
    )  # fmt: skip
    assert not scene.joint["b"].input and scene.joint["a"].input == ["force"]
    assert scene.structure().freedom == 1
    for name in "abc":
        scene.joint[name].output = ["position", "speed", "acceleration"]

    found = outputs(scene, {"a.position_start": 0.3, "a.speed_start": 0.5}, {"a.force": 5.0})
    ratio = {"a": 1, "b": -3, "c": -6}
    acceleration = (5 - 2 * G * sum(ratio.values())) / (2 * sum(r * r for r in ratio.values()))
    position = {"a": 0.3, "b": -3 * 0.3 + 0.2, "c": 2 * (-3 * 0.3 + 0.2) - 1}

    for name in "abc":
        assert_allclose(found[f"{name}.position"], position[name], rtol=1e-14)
        assert_allclose(found[f"{name}.speed"], 0.5 * ratio[name], rtol=1e-14)
        assert_allclose(found[f"{name}.acceleration"], ratio[name] * acceleration, rtol=1e-13)


def test_a_mimic_of_what_stands_holds(load):
    scene = load(
        link("a", SOLID), link("b", SOLID), link("c", SOLID), joint("f", "fixed", "a", "b"),
        joint("j", "revolute", "b", "c", '<mimic joint="f" offset="0.4"/>'),
    )  # fmt: skip
    assert "is held at 0.4 rad" in told(scene, '"j" mimics what does not move')
    assert_allclose(outputs(scene)["j.angle"], 0.4)
    assert scene.structure().freedom == 0


def test_a_mimic_of_nothing_is_told(load):
    scene = load(
        link("a", SOLID), link("b", SOLID), joint("left_q2", "revolute", "a", "b", '<mimic joint="left_q1"/>')
    )
    assert "which there is not: it moves by itself" in told(scene, '"left_q2" mimics "left_q1"')
    assert scene.joint["left_q2"].input == ["torque"] and not scene.coupling


def test_a_free_base_falls(load):
    scene = load(link("a", SOLID), link("b", SOLID), joint("j", "continuous", "a", "b"), base="free")
    scene.body["a"].output = ["acceleration", "alpha"]
    found = outputs(scene)
    assert_allclose([found[f"a.acceleration[{k}]"] for k in (1, 2, 3)], [0, 0, -G], atol=1e-14)
    assert_allclose([found[f"a.alpha[{k}]"] for k in (1, 2, 3)], 0, atol=1e-13)
    assert "moves freely; --base fixed holds it" in told(scene, "the base")


def test_floating_and_planar(load):
    scene = load(
        link("a", SOLID), link("b", SOLID), link("c", SOLID),
        joint("f", "floating", "a", "b", '<origin xyz="1 2 3"/>'),
        joint("p", "planar", "a", "c", '<axis xyz="0 1 0"/>'),
    )  # fmt: skip
    assert scene.structure().freedom == 9
    assert scene.joint["p"].options.normal == "y"
    scene.body["b"].output = ["acceleration", "position"]
    found = outputs(scene)
    assert_allclose([found[f"b.position[{k}]"] for k in (1, 2, 3)], [1, 2, 3])
    assert_allclose(found["b.acceleration[3]"], -G)


STOPPED = (
    link("a", SOLID), link("b", SOLID), link("c", SOLID),
    joint("r", "revolute", "a", "b", '<limit lower="0.1" upper="2" effort="5" velocity="7"/>'),
    joint("s", "prismatic", "a", "c", '<limit lower="-1" upper="0.5"/>'),
)  # fmt: skip


def test_limits_are_told_or_stops(load):
    scene = load(*STOPPED)
    assert "--stop-stiffness" in told(scene, "limits of position of 2 joints (comments")
    assert "start at 0 all the same" in told(scene, '"r"')
    assert scene.joint["r"].stop is None
    assert scene.imported.comments["joint", "r"] == ["limits: effort 5 N m, speed 7 rad/s, 0.1 to 2 rad"]

    scene = load(*STOPPED, stop_stiffness=(100, 2000), stop_damping=3)
    stop, other = scene.joint["r"].stop, scene.joint["s"].stop
    assert (stop.lower, stop.upper, stop.stiffness, stop.damping) == (0.1, 2.0, 100.0, 3.0)
    assert (other.lower, other.upper, other.stiffness, other.damping) == (-1.0, 0.5, 2000.0, 3.0)
    assert "start at the nearer end" in told(scene, '"r"')
    assert_allclose(outputs(scene)["r.angle"], 0.1)


@pytest.mark.parametrize(
    "limit", ['lower="0" upper="0"', 'lower="1" upper="-1"', "", 'lower="-inf" upper="inf"']
)
def test_limits_that_are_none(load, limit):
    scene = load(
        link("a", SOLID),
        link("b", SOLID),
        joint("j", "revolute", "a", "b", f"<limit {limit}/>"),
        stop_stiffness=1,
    )
    assert scene.joint["j"].stop is None


# links without mass, odd inertias, names


def test_links_without_mass_are_markers_where_they_are_fixed(load):
    """Of the ground, of a body, of one another; what hangs on them is where it should be."""
    quarter = '<origin xyz="1 0 0" rpy="0 0 1.5707963267948966"/>'
    scene = load(
        link("world"), link("a", SOLID), link("f"), link("g"), link("b", SOLID),
        joint("w", "fixed", "world", "a", '<origin xyz="0 0 1"/>'),
        joint("f", "fixed", "a", "f", quarter),
        joint("g", "fixed", "f", "g", quarter),
        joint("j", "prismatic", "g", "b", quarter),
    )  # fmt: skip
    assert list(scene.body) == ["a", "b"] and list(scene.ground.marker) == ["world", "w"]
    assert list(scene.body["a"].marker) == ["f", "g", "j"]
    assert told(scene, "are markers").endswith('"f" and "g"')
    scene.body["b"].output = ["position", "euler_parameters"]
    found = outputs(scene, {"j.position_start": 0.5})
    assert_allclose([found[f"b.position[{k}]"] for k in (1, 2, 3)], [0, 1 - 0.5, 1], atol=1e-15)
    euler = [found[f"b.euler_parameters[{k}]"] for k in (1, 2, 3, 4)]
    assert_allclose(np.abs(euler), np.abs([0, 0, np.sin(0.75 * np.pi), np.cos(0.75 * np.pi)]), atol=1e-15)


def test_a_body_without_mass_carries_another(load):
    """A cross of two hinges: its middle has no mass."""
    scene = load(
        link("a", SOLID), link("cross"), link("b", SOLID),
        joint("x", "continuous", "a", "cross", '<axis xyz="1 0 0"/>'),
        joint("y", "continuous", "cross", "b", '<axis xyz="0 1 0"/>'),
    )  # fmt: skip
    assert scene.body["cross"].mass == 0.0 and told(scene, "bodies without mass").endswith('"cross"')
    scene.joint["x"].output = ["acceleration"]
    assert_allclose(outputs(scene, inputs={"x.torque": 0.3})["x.acceleration"], 0.3 / 0.1, rtol=1e-13)


def test_joints_that_move_nothing_are_held(load):
    """Pads without mass, each following the other or not; one that follows a joint with mass moves on."""
    parts = (
        link("a", SOLID), link("b", SOLID), link("pad"), link("tip"), link("shadow"),
        joint("j", "continuous", "a", "b"),
        joint("idle", "continuous", "b", "pad"),
        joint("idle2", "continuous", "pad", "tip", '<mimic joint="idle"/>'),
        joint("led", "continuous", "b", "shadow", '<mimic joint="j" multiplier="2"/>'),
    )  # fmt: skip
    scene = load(*parts)
    assert told(scene, "are held at 0").endswith('"idle" and "idle2"')
    assert list(scene.body) == ["a", "b", "shadow"]
    found = outputs(scene, {"j.angle_start": 0.3})
    assert_allclose(found["led.angle"], 0.6)


def test_inertias_of_no_body_are_kept_and_told(load):
    odd = '<inertial><mass value="1"/><inertia ixx="1" iyy="1" izz="3"/></inertial>'
    scene = load(link("a", odd), link("b", SOLID), joint("j", "fixed", "a", "b"))
    assert scene.body["a"].inertia == (1, 1, 3)
    assert "exceeds the sum" in scene.imported.comments["body", "a"][0]
    assert any("[body.a] inertia" in notice for notice in scene.notices)


def test_negative_moments_are_raised_and_told(load):
    """The nearest inertia (by its entries) without a negative moment, in the same principal axes."""
    odd = '<inertial><mass value="1"/><inertia ixx="1" iyy="1" izz="1" ixy="2"/></inertial>'
    scene = load(link("a", odd), link("b", SOLID), joint("j", "fixed", "a", "b"))
    assert "raised to 0; the principal moments are [-1, 1, 3]" in told(
        scene, '"a" has a negative principal moment'
    )
    _, _, I = scene.body["a"].mass_properties()
    assert_allclose(I, [[1.5, 1.5, 0], [1.5, 1.5, 0], [0, 0, 1]], atol=1e-15)


def test_names_that_a_scene_does_not_have(load):
    scene = load(
        link("ground", SOLID), link("link.1", SOLID), link("link_1", SOLID),
        joint("j.1", "continuous", "ground", "link.1", '<origin xyz="1 0 0"/>'),
        joint("base", "continuous", "ground", "link_1", '<origin xyz="2 0 0"/>'),
    )  # fmt: skip
    assert list(scene.body) == ["ground_link", "link_1_2", "link_1"]
    assert list(scene.joint) == ["base_2", "j_1", "base"]
    note = told(scene, "names of links")
    assert '"ground" is "ground_link"' in note and '"link.1" is "link_1_2"' in note
    assert '"j.1" is "j_1"' in told(scene, "names of joints")


# what is left out


def test_what_a_scene_cannot_say_is_listed(load):
    shape = '<geometry><sphere radius="1"/></geometry>'
    scene = load(
        link("a", SOLID + f"<collision>{shape}</collision>" * 2),
        '<link name="b" type="x"><origin xyz="0 0 0"/></link>',
        joint("j", "fixed", "a", "b", '<limit upper="1"/><safety_controller k_velocity="1"/>'),
        "<transmission name='t'><joint name='j'/></transmission>", "<gazebo/>", "<gazebo/>", "<what/>",
        link("c", SOLID), joint("k", "revolute", "a", "c", '<dynamics damping="1" K="7"/>'),
    )  # fmt: skip
    left = scene.imported.left_out
    assert [line.partition(":")[0] for line in left] == [
        "2 <collision> of a link", "1 <link> type", "1 <origin> of a link", "1 <safety_controller> of a joint",
        "1 <transmission>", "2 <gazebo>", "1 <what>", "1 <dynamics> K of a joint",
        "1 <limit> of fixed joints, which do not move",
    ]  # fmt: skip


def test_a_file_that_says_only_what_a_scene_says_leaves_nothing_out(load):
    scene = load(
        link("a", SOLID), link("b", SOLID), joint("j", "continuous", "a", "b", '<dynamics friction="1"/>')
    )
    assert scene.imported.left_out == [] and len(scene.import_notes) == 1


# looks

MESH = "solid t\nfacet normal 0 0 1\nouter loop\nvertex 0 0 0\nvertex 1 0 0\nvertex 0 1 0\nendloop\nendfacet\nendsolid t\n"


def visual(geometry, more=""):
    return f"<visual>{more}<geometry>{geometry}</geometry></visual>"


def test_forms_and_colours(load):
    red = '<material name="red"><color rgba="1 0 0 0.5"/></material>'
    scene = load(
        red,
        link("a", SOLID + visual('<box size="1 2 3"/>', '<origin xyz="0 0 1" rpy="0 0 0.5"/><material name="red"/>')),
        link("f", visual('<sphere radius="0.1"/>') + visual('<cylinder radius="0.2" length="3"/>')
             + visual('<sphere radius="0"/>')),
        joint("j", "fixed", "a", "f"),
    )  # fmt: skip
    (box,) = scene.body["a"].shape
    assert (box.kind, box.box.size, box.position, box.zyx_rad) == ("box", (1, 2, 3), (0, 0, 1), (0.5, 0, 0))
    assert (box.colour, box.opacity) == ("#ff0000", 0.5)
    assert [shape.kind for shape in scene.body["a"].marker["f"].shape] == ["sphere", "cylinder"]
    assert "without an extent" in told(scene, "<sphere> of a link")


@pytest.mark.parametrize(
    "name, place", [
        ("package://bot/meshes/t.stl", "bot/meshes/t.stl"), ("meshes/t.stl", "bot/urdf/meshes/t.stl"),
        ("package://named/meshes/t.stl", "bot/meshes/t.stl"), ("package://other/t.stl", "other/t.stl"),
    ],
)  # fmt: skip
def test_meshes_are_found(load, tmp_path, name, place):
    """In the package above the file, by its folder's or its package.xml's name, beside it, or where the file is."""
    path = tmp_path / place
    path.parent.mkdir(parents=True)
    path.write_text(MESH)
    (tmp_path / "bot" / "urdf").mkdir(parents=True, exist_ok=True)
    (tmp_path / "bot" / "package.xml").write_text("<package><name>named</name></package>")
    mesh = visual(f'<mesh filename="{name}" scale="2 2 2"/>')
    scene = load(link("a", SOLID + mesh), name="bot/urdf/robot.urdf")
    (shape,) = scene.body["a"].shape
    assert shape.mesh.file.path == path and shape.mesh.scale == 2.0


def test_meshes_that_are_not_found(load, tmp_path):
    looks = [visual(f'<mesh filename="package://bot/{name}.stl"/>') for name in "ab"]
    scene = load(link("a", SOLID + "".join(looks)), base="free")
    assert scene.body["a"].shape is None
    assert told(scene, "looks of").endswith(
        'no folder of the package "bot" found; --package bot=DIR names it'
    )

    (tmp_path / "folder").mkdir()
    (tmp_path / "folder" / "a.stl").write_text(MESH)
    scene = load(link("a", SOLID + "".join(looks)), base="free", packages={"bot": tmp_path / "folder"})
    assert scene.body["a"].shape[0].mesh.file.path == tmp_path / "folder" / "a.stl"
    assert '"package://bot/b.stl": not there' in told(scene, "looks of")

    scene = load(link("a", SOLID + "".join(looks)), base="free", looks=False)
    assert scene.import_notes[-1] == "left out: 2 <visual> of links, as was asked for"


# what is wrong

A, B = link("a", SOLID), link("b", SOLID)
WRONG = [
    ("", "line 1: not valid XML: Document is empty"),
    ('<robot>\n<link name="a" x=3/></robot>', 'line 2: not valid XML: AttValue: " or \' expected in "<link name=\\"a\\" x=3/></robot>"'),
    ("<model/>", "line 1: the first element is <model>; a URDF file begins with <robot>"),
    ('<robot xmlns:xacro="http://ros.org/wiki/xacro">\n<xacro:include filename="a"/></robot>',
     "line 2: <xacro:include> is of xacro, the macro language of URDF; expand it first: xacro {path} > robot.urdf (pip install xacro, or "
     "ROS's own)"),
    ('<robot>\n<link name="${prefix}a"/></robot>',
     "line 2: ${{...}} is of xacro, the macro language of URDF; expand it first: xacro {path} > robot.urdf (pip install xacro, or ROS's own)"),
    ('<robot name="r"/>', 'line 1: <robot name="r">: it holds nothing; a robot has links and joints'),
    (robot(link("a")), "no link has a mass: <inertial> is missing in all of them, so that nothing could move"),
    (robot(A, "<link/>"), 'line 3: <link>: "name" is missing; it needs name="...".'),
    (robot(A, A), 'line 3: <link name="a">: there is a link of that name already, in line 2'),
    (robot(A, B, joint("j", "revolut", "a", "b")),
     'line 4: <joint name="j"> type: no type "revolut" of joints in URDF; there is "revolute", "continuous", "prismatic", "fixed", '
     '"floating" and "planar". Did you mean "revolute"?'),
    (robot(A, B, joint("j", "fixed", "a", "bb")), 'line 4: <joint name="j"> <child> link: there is no link "bb"; there is "a" and "b". '
     'Did you mean "b"?'),
    (robot(A, B, '<joint name="j" type="fixed"><parent link="a"/></joint>'), 'line 4: <joint name="j">: <child> is missing.'),
    (robot(A, B, joint("j", "fixed", "a", "b"), joint("k", "fixed", "a", "b")),
     'line 5: <joint name="k">: leads to "b", and so does "j" in line 4: a URDF is a tree, each link has one parent. Close loops in the '
     "scene that is made of it, by a joint more"),
    (robot(A, B), 'line 3: <link name="b">: "a" and "b" have no parent: one link alone, the root, has none; a joint to each of the others is '
     "missing"),
    (robot(A, B, joint("j", "fixed", "a", "b"), joint("k", "fixed", "b", "a")),
     'line 5: <joint name="k">: a ring of joints: "a" -> "b" -> "a"; a URDF is a tree, it begins with a link that has no parent'),
    (robot(A, joint("j", "fixed", "a", "a")), 'line 3: <joint name="j">: parent and child are both "a"'),
    (robot(A, B, joint("j", "revolute", "a", "b", '<axis xyz="0 0 0"/>')),
     'line 4: <joint name="j"> <axis> xyz: an axis needs a direction, found "0 0 0"'),
    (robot(A, B, joint("j", "revolute", "a", "b", '<axis xyz="0 1"/>')),
     'line 4: <joint name="j"> <axis> xyz: needs 3 numbers with blanks between, found "0 1"'),
    (robot(A, B, joint("j", "revolute", "a", "b", '<origin xyz="0 1,5 0"/>')),
     'line 4: <joint name="j"> <origin> xyz: needs a number, found "1,5"; decimals stand after a point'),
    (robot(A, B, joint("j", "revolute", "a", "b", '<dynamics damping="-1"/>')),
     'line 4: <joint name="j"> <dynamics> damping: must not be negative, found "-1"'),
    (robot(A, B, joint("j", "revolute", "a", "b", '<mimic joint="j"/>')), 'line 4: <joint name="j"> <mimic> joint: mimics itself: "j" -> "j"'),
    (robot(link("a", SOLID.replace('"2"', '"nan"'))),
     'line 2: <link name="a"> <inertial> <mass> value: needs a finite number, at most 1e30; found "nan"'),
    (robot(link("a", SOLID.replace('"2"', '"-2"'))), 'line 2: <link name="a"> <inertial> <mass> value: must not be negative, found "-2"'),
    (robot(link("a", SOLID.replace("ixx", "Ixx"))),
     'line 2: <link name="a"> <inertial> <inertia>: "ixx" is missing; it needs ixx="...". Did you mean "Ixx"?'),
    (robot(link("a", "<inertial/>")), 'line 2: <link name="a"> <inertial>: <mass> is missing.'),
]  # fmt: skip


@pytest.mark.parametrize("text, message", WRONG)
def test_mistakes_are_told_by_line(tmp_path, text, message):
    path = tmp_path / "robot.urdf"
    path.write_text(text)

    with pytest.raises(SceneError) as error:
        mbdfmi.load(path)

    assert error.value.errors[0] == f"{path}: " + message.replace("{path}", str(path)).replace(
        "{{...}}", "{...}"
    )


def test_all_mistakes_are_told_at_once(load):
    with pytest.raises(SceneError) as error:
        load(link("a", "<inertial/>"), link("a"), joint("j", "fix", "a", "c"))

    assert len(error.value.errors) == 5


@pytest.mark.parametrize(
    "options, message", [
        ({"base": "loose"}, "base"), ({"stop_stiffness": -1}, "stop_stiffness"), ({"stop_stiffness": "a"}, "stop_stiffness"),
        ({"stop_stiffness": (1, 2, 3)}, "stop_stiffness"), ({"stop_damping": 1}, "goes with a stop_stiffness"),
    ],
)  # fmt: skip
def test_options_that_make_no_sense(load, options, message):
    with pytest.raises(ValueError, match=message):
        load(A, base="free") if not options else load(A, **options)


def test_options_are_for_urdf_files_alone(tmp_path):
    (tmp_path / "scene.toml").write_text('name = "a"\n')
    with pytest.raises(ValueError, match="is a scene file; base: for URDF files alone"):
        mbdfmi.load(tmp_path / "scene.toml", base="free")


# the command line


@pytest.fixture
def command(capfd):
    """Runs the command line; returns its status, output and errors."""

    def run(*arguments):
        status = cli.main([str(argument) for argument in arguments])
        return status, *capfd.readouterr()

    return run


@pytest.fixture
def arm(tmp_path, monkeypatch):
    """A folder with a robot, arm.urdf, and its mesh, in which commands run."""
    monkeypatch.chdir(tmp_path)
    mesh = visual('<mesh filename="t.stl"/>')
    text = robot(
        link("a", SOLID + mesh), link("b", SOLID.replace("0.25", "0.9")),
        joint("j", "revolute", "a", "b", '<limit lower="-1" upper="1" effort="3" velocity="2"/>'), name="arm",
    )  # fmt: skip
    (tmp_path / "arm.urdf").write_text(text)
    (tmp_path / "t.stl").write_text(MESH)
    return tmp_path


def test_import_writes_a_scene_that_is_the_same(arm, command):
    status, out, said = command("import", "arm.urdf", "-o", "out/arm.toml", "--stop-stiffness", "100,5")
    assert status == 0 and out.startswith("out/arm.toml"), said
    text = (arm / "out" / "arm.toml").read_text()
    assert text.startswith(
        '# Made from arm.urdf (URDF, robot "arm").\n# Decided:\n# - the base, "a", is fixed to the ground'
    )
    assert "# limits: effort 3 N m, speed 2 rad/s, -1 to 1 rad\n[joint.j]\n" in text
    assert re.search(r"# no body has such moments.*\n\[body.b\]", text)
    assert "note: arm.urdf: [body.b] inertia: no principal moment" in said
    scene, direct = (
        mbdfmi.load(arm / "out" / "arm.toml"),
        mbdfmi.load(arm / "arm.urdf", stop_stiffness=(100, 5)),
    )
    assert scene.body["a"].shape[0].mesh.file == "../t.stl"
    assert scene.body["a"].shape[0].mesh.file.path == direct.body["a"].shape[0].mesh.file.path
    scene.body["a"].shape = direct.body["a"].shape = None
    assert scene == direct


def test_import_to_the_standard_output_and_not_over_its_own_file(arm, command):
    status, out, said = command("import", "arm.urdf", "-o", "-")
    assert status == 0 and out.startswith("# Made from") and "[joint.j]" in out
    status, _, said = command("import", "arm.urdf", "-o", "arm.urdf")
    assert status == 1 and "is read by this command" in said
    status, _, said = command("import", "arm.urdf", "-o", "arm.json")
    assert status == 1 and "let its name end in .toml" in said
    (arm / "scene.toml").write_text(
        'name = "x"\n[body.a]\nmass = 1\ninertia = [1, 1, 1]\n[joint.j]\nfree = {}\nbetween = ["ground", "a"]\n'
    )
    status, _, said = command("import", "scene.toml", "-o", "b.toml")
    assert status == 1 and "is a scene file already" in said and not (arm / "b.toml").exists()


def test_other_commands_take_a_robot(arm, command):
    status, out, said = command("info", "arm.urdf", "--base", "free")
    assert status == 0 and "7 degrees of freedom" in out and "note: arm.urdf: the base" in said
    status, _, said = command("info", "arm.urdf", "--package", "a")
    assert status == 1 and "write NAME=DIR" in said
    status, _, said = command("info", "arm.urdf", "--stop-stiffness", "1,2,3")
    assert status == 1 and "--stop-stiffness 1,2,3: write a number, or two" in said


def test_a_robot_is_known_by_what_it_says(load):
    assert load(A, B, joint("j", "continuous", "a", "b"), name="robot.xml").structure().freedom == 1


def colour_of(mesh):
    return (mesh.visual.to_color() if hasattr(mesh.visual, "to_color") else mesh.visual).main_color


def test_meshes_are_thinned(arm, command):
    """A ball of 1280 triangles to 200, in its place and size, in its colour; of other meshes there is no copy."""
    ball = trimesh.creation.icosphere(3, radius=0.5)
    ball.apply_translation([1, 2, 3])
    ball.visual.face_colors = [255, 0, 0, 255]
    ball.export(arm / "ball.ply")
    text = (
        (arm / "arm.urdf")
        .read_text()
        .replace("</visual>", "</visual>" + visual('<mesh filename="ball.ply"/>') * 2, 1)
    )
    (arm / "arm.urdf").write_text(text)
    status, _, said = command("import", "arm.urdf", "-o", "out/arm.toml", "--faces", "200")
    assert status == 0 and [path.name for path in (arm / "out" / "arm_meshes").iterdir()] == ["ball.glb"], (
        said
    )
    assert "1 mesh is thinned to 200 triangles, in arm_meshes/" in (arm / "out" / "arm.toml").read_text()
    shapes = mbdfmi.load(arm / "out" / "arm.toml").body["a"].shape
    assert [shape.mesh.file for shape in shapes] == ["../t.stl", "arm_meshes/ball.glb", "arm_meshes/ball.glb"]
    thin = load_mesh(shapes[1].mesh.file)
    assert 150 < len(thin.faces) <= 200
    assert_allclose(thin.bounds, [[0.5, 1.5, 2.5], [1.5, 2.5, 3.5]], atol=0.03)
    assert_allclose(colour_of(thin), [255, 0, 0, 255])

    status, _, said = command("import", "arm.urdf", "-o", "-", "--faces", "200")
    assert status == 1 and "--faces 200: is for scenes in files" in said
