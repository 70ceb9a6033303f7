"""Parts of a scene can be changed: what is assigned is checked at once, the whole when it is used next."""

import tomllib
from pathlib import Path

import numpy as np
import pytest

from mbdfmi import Scene, SceneError, load

ARM = Path(__file__).parents[1] / "models" / "two_link_arm.toml"


@pytest.fixture
def arm():
    return load(ARM)


def parameter(scene, name):
    """A parameter's value in the model of a scene."""
    return next(v.start for v in scene.compile().variables if v.name == name)


def rebuilt(scene):
    """The same scene from its text."""
    return Scene(**tomllib.loads(scene.to_toml()))


def test_what_is_assigned_reaches_the_model_and_the_file(arm):
    before = arm.compile().guid
    arm.joint["elbow"].damper = 0.25
    arm.body["upper"].mass = 3
    arm.body["upper"].com = np.array([0.1, 0.2, 0.3])
    arm.solver.step = 5e-4
    arm.gravity = [0, 0, -1.62]
    arm.output = ["total_energy"]

    assert parameter(arm, "elbow.damper") == 0.25
    assert parameter(arm, "upper.mass") == 3.0
    assert parameter(arm, "upper.com[2]") == 0.2
    assert parameter(arm, "solver.step") == 5e-4
    assert parameter(arm, "gravity[3]") == -1.62
    assert "total_energy" in arm.simulate(0.01)
    assert arm.compile().guid == rebuilt(arm).compile().guid != before


def test_units_and_tables_are_read_as_in_a_file(arm):
    arm.joint["elbow"].start = {"angle_deg": 90}
    assert parameter(arm, "elbow.angle_start") == pytest.approx(np.pi / 2)
    arm.solver = {"integrator": "rk54", "tolerance": 1e-6}
    assert parameter(arm, "solver.tolerance") == 1e-6


def test_parts_are_added_and_taken_out(arm):
    arm.body["lower"].marker["middle"] = {"position": [0.3, 0, 0], "output": ["position"]}
    arm.force["rope"] = {"spring_damper": {"stiffness": 10.0}, "between": ["ground", "lower.middle"]}
    assert parameter(arm, "rope.stiffness") == 10.0
    assert arm.force["rope"].spring_damper.stiffness == 10.0
    assert arm.body["lower"].marker["middle"].position == (0.3, 0, 0)

    arm.force["rope"].spring_damper.stiffness = 20
    assert parameter(arm, "rope.stiffness") == 20.0
    del arm.force["rope"]
    assert not any(v.name.startswith("rope") for v in arm.compile().variables)


def test_none_takes_a_key_out(arm):
    arm.joint["elbow"].damper = 0.25
    arm.joint["elbow"].damper = None
    assert arm.compile().guid == load(ARM).compile().guid
    assert "damper" not in arm.to_toml()


def test_parts_stay_the_objects_that_they_are(arm):
    upper, elbow = arm.body["upper"], arm.joint["elbow"]
    arm.force["rope"] = {"spring_damper": {"stiffness": 10.0}, "between": ["ground", "lower"]}
    arm.gravity = [0, 0, 0]
    arm.compile()
    assert arm.body["upper"] is upper and arm.joint["elbow"] is elbow
    upper.mass = 7
    assert parameter(arm, "upper.mass") == 7.0


def test_a_part_that_is_there_by_default_is_each_scenes_own():
    def hanging():
        joint = {"j": {"revolute": {"axis": "y"}, "between": ["ground", "a"]}}
        return Scene(name="a", body={"a": {"mass": 1, "inertia": [1, 1, 1]}}, joint=joint)

    first, second = hanging(), hanging()
    first.solver.tolerance = 1e-3
    first.output.append("total_energy")
    assert parameter(first, "solver.tolerance") == 1e-3 and parameter(second, "solver.tolerance") == 1e-8
    assert len(first.compile().of_causality("output")) == 1 and second.output == []
    assert rebuilt(first).compile().guid == first.compile().guid


@pytest.mark.parametrize(
    "change, says",
    [
        (lambda arm: setattr(arm.body["upper"], "mass", -1), "mass: must not be negative, found -1"),
        (lambda arm: setattr(arm.body["upper"], "mas", 1), 'mas: unknown key.*Did you mean "mass"'),
        (lambda arm: setattr(arm, "gravity", [1, 2]), "gravity: needs 3 numbers"),
        (lambda arm: setattr(arm, "solver", {"integrator": "rk5"}), r'\[solver\] integrator: no "rk5" here'),
        (lambda arm: setattr(arm.solver, "tolerance", 1e-6), "rk4 has no tolerance"),
        (lambda arm: setattr(arm, "name", None), "name: "),
    ],
)
def test_what_is_wrong_is_told_at_once_and_changes_nothing(arm, change, says):
    with pytest.raises(SceneError, match=says):
        change(arm)

    assert arm.compile().guid == load(ARM).compile().guid


@pytest.mark.parametrize(
    "change, says",
    [
        (
            lambda arm: setattr(arm.joint["elbow"], "between", ["upper.x", "lower"]),
            'joint.elbow.*no marker "x" on body "upper"',
        ),
        (lambda arm: arm.joint.pop("elbow"), "body.lower.*no chain of joints connects it to ground"),
        (lambda arm: arm.force.update(rope={"spring": {}}), 'force.rope.*Did you mean "spring_damper"'),
        (lambda arm: arm.output.append("energy"), 'output: no "energy" here'),
    ],
)
@pytest.mark.parametrize("use", [Scene.compile, Scene.structure, lambda arm: arm.simulate(0.1)])
def test_how_parts_go_together_is_told_when_the_scene_is_used(arm, change, says, use):
    change(arm)

    with pytest.raises(SceneError, match=says) as error:
        use(arm)

    assert str(ARM) in str(error.value)


def test_what_a_user_sees_of_a_part(arm):
    """No names of the library that checks it."""
    for part in (arm, arm.joint["elbow"], arm.body["upper"], arm.solver):
        seen = [name for name in dir(part) if not name.startswith("_")]
        assert not {"copy", "json", "dict", "schema", "construct", "parse_obj"} & set(seen)
        assert not [name for name in seen if name.startswith("model_")]

    assert {"joint", "simulate", "export", "to_toml"} <= set(dir(arm))
    assert {"damper", "start", "between"} <= set(dir(arm.joint["elbow"]))
