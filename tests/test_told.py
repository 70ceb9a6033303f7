"""What is odd in a scene is told, what is meant is understood, and what is no scene says what it is."""

import numpy as np
import pytest

from mbdfmi import Scene, SceneError, cli, load
from mbdfmi.compiler.model import compile_scene
from mbdfmi.run.instance import Instance
from mbdfmi.run.results import Results
from mbdfmi.scene import parse_scene, variable_name
from tests.model_files import SCENES

AXES = [0.01] * 3


def pendulum(joint=None, body=None, **scene):
    return Scene(
        name="p",
        body={"a": {"mass": 1, "inertia": AXES, "com": [0, 0, -0.5]} | (body or {})},
        joint={"j": {"revolute": {"axis": "y"}, "between": ["ground", "a"]} | (joint or {})},
        **scene,
    )


@pytest.mark.parametrize("path", SCENES, ids=lambda path: path.stem)
def test_models_have_nothing_odd(path):
    assert load(path).notices == []


# angles


@pytest.mark.parametrize("value", [30, 90, -45, 22.5, 360, 7])
@pytest.mark.parametrize(
    "key, joint",
    [
        ("start.angle", lambda v: {"start": {"angle": v}}),
        ("spring.rest", lambda v: {"spring": {"stiffness": 1, "rest": v}}),
        ("stop.upper", lambda v: {"stop": {"lower": -1000.25, "upper": v, "stiffness": 1}}),
        ("driver.harmonic.amplitude", lambda v: {"driver": {"harmonic": {"amplitude": v, "frequency": 1}}}),
    ],
)
def test_degrees_written_as_radians_are_noticed(key, joint, value):
    (notice,) = pendulum(joint(value)).notices
    name = key.rpartition(".")[2]
    assert notice.startswith(f"[joint.j] {key}: ") and f"{name}_deg = {value}" in notice


@pytest.mark.parametrize(
    "joint",
    [
        {"start": {"angle": 6.25}}, {"start": {"angle_deg": 720}}, {"start": {"angle": 20 * np.pi}}, {"start": {"speed": 300}},
        {"driver": {"constant_speed": 100}}, {"driver": {"table": {"time": [0, 1, 2, 3], "position": [0, 10, 20, 30]}}},
    ],
)  # fmt: skip
def test_angles_that_are_meant(joint):
    assert pendulum(joint).notices == []


def test_prismatic_positions_are_no_angles():
    joint = {"prismatic": {}, "between": ["ground", "a"], "start": {"position": 30}}
    assert Scene(name="p", body={"a": {"mass": 1, "inertia": AXES}}, joint={"j": joint}).notices == []


def test_two_angles_of_a_universal_joint():
    joint = {"universal": {}, "between": ["ground", "a"], "start": {"angles": [45, 0.5]}}
    (notice,) = Scene(name="p", body={"a": {"mass": 1, "inertia": AXES}}, joint={"j": joint}).notices
    assert "angles_deg = [45, 0.5]" in notice or "angles_deg = [45.0, 0.5]" in notice


# sizes


def chain(sizes, **more):
    body = {
        f"b{k}": {"mass": 1, "inertia": AXES, "marker": {"e": {"position": [size, 0, 0]}}}
        for k, size in enumerate(sizes)
    }
    joint = {
        f"j{k}": {"revolute": {}, "between": [f"b{k - 1}.e" if k else "ground", f"b{k}"]}
        for k in range(len(sizes))
    }
    return Scene(name="c", body=body, joint=joint, **more)


@pytest.mark.parametrize(
    "sizes, odd",
    [
        ([0.5, 500, 0.3], ["b1"]), ([0.5, 0.4, 450, 500], ["b2", "b3"]), ([0.5, 0.4, 0.3], []), ([500, 300, 200], []),
        ([0.05, 1, 10], []), ([0, 500], []), ([2e-5, 0.02, 0.3, 0.4], []), ([6e-34, 0.1, 0.2], []),
    ],
)  # fmt: skip
def test_a_body_far_longer_than_others_is_noticed(sizes, odd):
    notices = chain(sizes).notices
    assert sorted(notice.split("]")[0] for notice in notices) == [f"[body.{name}" for name in odd]
    assert all("in m, not mm" in notice for notice in notices)


@pytest.mark.parametrize(
    "solid, reach",
    [
        ({"box": {"size": [20, 500, 20]}}, 500), ({"cylinder": {"radius": 20, "length": 500}}, 500),
        ({"cylinder": {"radius": 500, "length": 20}}, 1000), ({"sphere": {"radius": 500}}, 1000),
    ],
)  # fmt: skip
def test_solids_in_other_units_are_noticed(solid, reach):
    """By the longest of length, sizes and diameter."""
    ((shape, sizes),) = solid.items()
    solids = [{shape: sizes | {"mass": 1}}, {"cylinder": {"radius": 0.01, "length": 0.5, "mass": 1}}]
    body = {name: {"solid": solid} for name, solid in zip("ab", solids)}
    joint = {name: {"revolute": {}, "between": ["ground", name]} for name in "ab"}
    (notice,) = Scene(name="c", body=body, joint=joint).notices
    assert notice.startswith(f"[body.a] reaches {reach} m, other bodies 0.5 m at most")


# tolerance


@pytest.mark.parametrize(
    "size, solver, odd",
    [
        (1.0, {}, False), (1e-3, {}, False), (1e-5, {}, True), (1e-5, {"absolute_tolerance": 1e-13}, False),
        (1.0, {"tolerance": 1e-3}, False), (1.0, {"tolerance": 1e-8, "absolute_tolerance": 1e-3}, True),
        (1e-5, {"integrator": "rk4", "step": 1e-3}, False),
    ],
)  # fmt: skip
def test_a_coarse_absolute_tolerance_is_noticed(size, solver, odd):
    notices = chain([size, size], solver=solver).notices
    assert [notice.startswith("[solver] absolute_tolerance: ") for notice in notices] == [True] * odd


@pytest.mark.parametrize(
    "solver, friction, odd",
    [
        ({"integrator": "rk54"}, {"coulomb": 1.0}, True), ({"integrator": "rk4", "step": 1e-3}, {"coulomb": 1.0}, True),
        ({"integrator": "rk853"}, {"coulomb": 1.0, "smoothing_speed": 1e-3}, False),
        ({"integrator": "rk54"}, {"coulomb": 0.0, "viscous": 1.0}, False), ({}, {"coulomb": 1.0}, False),
        ({"integrator": "radau"}, {"coulomb": 1.0}, False),
    ],
)  # fmt: skip
def test_friction_that_is_too_stiff_for_a_stepper_is_noticed(solver, friction, odd):
    scene = Scene(
        name="block",
        solver=solver,
        body={"block": {"mass": 1.0, "inertia": [1, 1, 1]}},
        joint={"slide": {"prismatic": {}, "between": ["ground", "block"], "friction": friction}},
    )
    assert ["(slide) is stiff" in notice for notice in scene.notices] == [True] * odd


# where notices come out


def test_notices_come_out_everywhere(tmp_path, capsys):
    scene = pendulum({"start": {"angle": 30}, "output": ["angle"]}, {"output": ["position"]})
    path = tmp_path / "p.toml"
    path.write_text(scene.to_toml())
    (notice,) = scene.notices
    assert scene.compile().notices == scene.simulate(0.1).notices == [notice]
    runs = [
        ["check", path],
        ["info", path],
        ["simulate", path, "--until", 0.1],
        ["simulate", path, "--until", 0.1, "--csv", tmp_path / "a.csv"],
    ]

    for arguments in runs:
        assert cli.main([str(argument) for argument in arguments]) == 0
        assert f"note: {notice}" in capsys.readouterr().err


# names


NAMES = {
    "Flügel": "Flugel",
    "blade 1": "'blade 1'",
    "α": "'(U+03B1)'",
    "рычаг": None,
    "it's": None,
    "a-b": "'a-b'",
    "x": "x",
}


@pytest.mark.parametrize("name", NAMES)
def test_names_as_written(name):
    """Parameters, inputs and results are found by the names that the scene has, and by those of an FMU."""
    body = {"mass": 1, "inertia": AXES, "output": ["position"], "input": ["force"]}
    joint = {"prismatic": {"axis": "x"}, "between": ["ground", name], "input": "force", "output": ["speed"]}
    scene = Scene(name="n", gravity=[0, 0, 0], body={name: body}, joint={f"{name} j": joint})
    variables = {v.name for v in scene.compile().variables}
    assert variable_name(f"{name}.mass") in variables
    assert NAMES[name] in (None, variable_name(name))
    written = scene.simulate(
        1.0, 0.5, {f"{name} j.force": 2.0, f"{name}.force": [1.0, 0.0, 0.0]}, {f"{name}.mass": 6.0}
    )  # fmt: skip
    fmi = {variable_name(f"{name} j.force"): 2.0, variable_name(f"{name}.force"): [1.0, 0.0, 0.0]}
    quoted = scene.simulate(1.0, 0.5, fmi, {variable_name(f"{name}.mass"): 6.0})
    assert written[f"{name} j.speed"][-1] == pytest.approx(0.5, abs=1e-12)
    np.testing.assert_array_equal(written[f"{name}.position"], quoted[variable_name(f"{name}.position")])
    assert written[f"{name}.position"].shape == (3, 3)
    np.testing.assert_array_equal(written[f"{name}.position[1]"], written[f"{name}.position"][:, 0])
    assert f"{name} j.speed" in written and f"{name} k.speed" not in written
    assert (
        set(written)
        == set(quoted)
        == {"time"} | {v.name for v in scene.compile().variables if v.causality != "parameter"}
    )


def test_a_joint_and_a_body_of_one_name():
    """Nothing of theirs is called the same unless both say so."""
    body = {"mass": 1, "inertia": AXES, "output": ["omega", "zyx"], "input": ["moment"]}
    joint = {
        "between": ["ground", "a"],
        "spring": {"stiffness": 1},
        "damper": 0.1,
        "start": {"angle": 0.1},
        "input": "torque",
        "output": ["angle", "speed"],
    }
    scene = Scene(name="one", body={"a": body}, joint={"a": {"revolute": {}} | joint})
    names = [v.name for v in scene.compile().variables]
    assert len(set(names)) == len(names)
    assert scene.simulate(0.1)["a.omega"][-1, 2] == pytest.approx(
        scene.simulate(0.1)["a.speed"][-1], abs=1e-12
    )


def test_a_joint_and_a_body_with_one_variable():
    body = {"mass": 1, "inertia": AXES, "output": ["position"]}
    joint = {"prismatic": {}, "between": ["ground", "a"], "output": ["position"]}

    with pytest.raises(SceneError, match="a.position exists already, from .body.a."):
        Scene(name="one", body={"a": body}, joint={"a": joint})


# numbers given from Python


@pytest.mark.parametrize(
    "options, message",
    [
        ({"until": "1"}, "until needs a number, found '1'"), ({"until": 1, "step": "0.1"}, "step needs a number"),
        ({"until": None}, "until needs a number"), ({"until": 1, "inputs": {"j.torque": "5"}}, "input 'j.torque' needs numbers, found '5'"),
        ({"until": 1, "inputs": {"j.torque": ["5", "6"]}}, "input 'j.torque' needs numbers"),
        ({"until": 1, "inputs": {"j.torque": np.nan}}, "input 'j.torque' must be finite"),
        ({"until": 1, "parameters": {"a.mass": "5"}}, "parameter 'a.mass' needs a number, found '5'"),
        ({"until": 1, "parameters": {"a.mass": np.inf}}, "parameter 'a.mass' must be finite"),
        ({"until": 1, "parameters": {"a.mass": [1, 2]}}, "parameter 'a.mass' needs a number"),
    ],
)  # fmt: skip
def test_what_is_no_number(options, message):
    with pytest.raises(ValueError, match=message):
        pendulum({"input": "torque"}).simulate(**options)


# stops


@pytest.mark.parametrize(
    "stop, said",
    [
        ({"lower_deg": 60, "upper_deg": 30}, "found 60 deg and 30 deg"),
        ({"lower": 1.5, "upper_deg": 30}, "found 1.5 and 30 deg"), ({"lower": 2, "upper": 1}, "found 2 and 1"),
    ],
)  # fmt: skip
def test_a_stop_is_talked_about_as_it_was_written(stop, said):
    with pytest.raises(SceneError) as error:
        pendulum({"stop": stop | {"stiffness": 1}})

    assert said in str(error.value)


# files of other kinds


@pytest.mark.parametrize(
    "text, kind",
    [
        ('<?xml version="1.0"?>\n<!-- a model -->\n<mujoco model="r">', "MJCF"), ('<mujoco model="r"/>', "MJCF"),
        ("\ufeff<?xml version='1.0'?><mujoco>", "MJCF"), ("ISO-10303-21;\nHEADER;", "STEP"), ("<mujoco>", "MJCF"),
        ("<?xml version='1.0'?><sdf version='1.6'>", "SDF"), ("<?xml version='1.0'?><fmiModelDescription ", "modelDescription.xml"),
        ("<?xml version='1.0'?><x>", "XML"), ('{"body": {}}', "JSON"), ('[{"a": 1}]', "JSON"), ("PK\x03\x04abc", "zip"),
        ("model Pendulum\n Real x;", "Modelica"), ("within A.B;\nmodel P", "Modelica"), ("OndselSolver\nAssembly", "OndselSolver"),
        ("solid part\n facet normal 0 0 1", "STL"), ("%PDF-1.4", "PDF"), ("%YAML 1.2\n---", "YAML"), ("---\na: 1", "YAML"),
        ("import mbdfmi\n", "Python"), ("<!DOCTYPE html><html>", "HTML"),
    ],
)  # fmt: skip
def test_files_of_other_kinds_say_what_they_are(tmp_path, text, kind):
    path = tmp_path / "arm.toml"
    path.write_text(text, encoding="utf-8")

    with pytest.raises(SceneError) as error:
        load(path)

    (message,) = error.value.errors
    assert str(path) in message and kind in message and "not a scene file (TOML)" in message


@pytest.mark.parametrize(
    "start", ["", "# solid facet\n", "model = 1\n", "[model.x]\n", '["a b"]\n', "import = 2\n", "MZ = 1\n"]
)
def test_toml_is_no_file_of_another_kind(start):
    with pytest.raises(SceneError) as error:
        parse_scene((start + "name = 3").encode())

    assert "not a scene file" not in str(error.value)


# masses


def test_point_masses():
    """A point among the solids is what a mass with inertia [0, 0, 0] is; with a rod it makes the sum."""
    written = {"mass": 2, "com": [0, 0, -1], "inertia": [0, 0, 0]}
    solid = {"solid": {"point": {"mass": 2}, "position": [0, 0, -1]}}
    ends = [
        pendulum({"start": {"angle": 1}, "output": ["angle"]}, body).simulate(2.0)["j.angle"]
        for body in (written,)
    ]
    scene = Scene(
        name="p",
        body={"a": solid},
        joint={
            "j": {
                "revolute": {"axis": "y"},
                "between": ["ground", "a"],
                "start": {"angle": 1},
                "output": ["angle"],
            }
        },
    )
    np.testing.assert_array_equal(scene.simulate(2.0)["j.angle"], ends[0])

    rod = {"cylinder": {"radius": 0.01, "length": 1, "mass": 3}, "position": [0, 0, -0.5]}
    both = Scene(
        name="p",
        body={"a": {"solid": [rod, solid["solid"]]}},
        joint=scene.model_dump(include={"joint"}, exclude_none=True)["joint"],
    )
    mass, com, inertia = both.body["a"].mass_properties()
    np.testing.assert_allclose(com, [0, 0, -(3 * 0.5 + 2 * 1) / 5], atol=1e-15)
    about_origin = inertia[1, 1] + mass * com @ com
    np.testing.assert_allclose(about_origin, 3 * (0.01**2 / 4 + 1 / 12 + 0.25) + 2, rtol=1e-14)


def test_results_keep_to_mapping():
    results = Results({"time": np.zeros(1), "'a b'.x": np.ones(1)}, {})
    assert results["a b.x"][0] == 1 and "nothing" not in results and 3 not in results


@pytest.mark.parametrize(
    "kind, start, notice",
    [
        ("universal", {"angles": {"first": 90.0}}, "[joint.j] start.angles.first: 90.0 is in rad"),
        ("translation", {"position": {"x": 30.0}}, None),
        ("free", {"position": {"z": 90.0}, "omega_body": {"x": 90.0}}, None),
    ],
)
def test_vectors_written_in_part_are_looked_at(kind, start, notice):
    options = {"axes": ["x", "y"]} if kind == "universal" else {}
    joint = {kind: options, "between": ["ground", "b"], "start": start}
    scene = Scene(
        name="part",
        solver={"absolute_tolerance": 0.01},
        body={"b": {"mass": 1, "inertia": AXES}},
        joint={"j": joint},
    )
    found = [text for text in scene.notices if text.startswith("[joint.j]")]
    assert len(found) == (notice is not None) and all(text.startswith(notice) for text in found)
    assert Instance(compile_scene(scene)).notices[: len(scene.notices)] == scene.notices


@pytest.mark.parametrize(
    "time, position, told",
    [
        ([0, 1, 2], [0, 1, 0], False),
        ([0.5, 1, 2], [0, 1, 0], True),
        ([0.5, 1, 2], [0.2, 0.2, 0], False),
        ([-1, 1, 2], [0, 1, 0], False),
    ],
)
@pytest.mark.parametrize("interpolation", ["smooth", "cubic", "quintic"])
def test_a_table_that_begins_to_move_at_once_is_noticed(time, position, told, interpolation):
    """Of a joint, and of the ground; splines make no stand between two equal points."""
    told = told or (interpolation != "smooth" and time[0] > 0)
    table = {"time": time, "interpolation": interpolation}
    scenes = [pendulum(joint={"driver": {"table": table | {"position": position}}})]
    rows = [[x, 0, 0] for x in position]
    scenes.append(pendulum(ground={"motion": {"table": table | {"position": rows}}}))

    for scene, place in zip(scenes, ("[joint.j] driver", "[ground] motion")):
        found = [text for text in scene.notices if "the speed jumps" in text]
        assert len(found) == told and all(
            text.startswith(f"{place}.table.time: stands still until its first point, 0.5 s")
            for text in found
        )
