"""Names of variables, wherever they are given: an array's without index means all of it, a wrong one says which is meant."""

from pathlib import Path

import pytest

from mbdfmi import load
from mbdfmi.compiler.variables import array_of, hint, meant

NAMES = ["arm.angle", "tip.position[1]", "tip.position[2]", "inertia[1,1]", "inertia[1,2]", "positions[1]"]


def test_an_array_without_index_means_its_elements():
    assert meant("arm.angle", NAMES) == ["arm.angle"]
    assert meant("tip.position[2]", NAMES) == ["tip.position[2]"]
    assert meant("tip.position", NAMES) == ["tip.position[1]", "tip.position[2]"]
    assert meant("inertia", NAMES) == ["inertia[1,1]", "inertia[1,2]"]
    assert meant("position", NAMES) == meant("tip", NAMES) == []
    assert array_of("a.b[10]") == "a.b" and array_of("a[1].b") == "a[1].b"


def test_a_wrong_name_says_which_is_meant():
    assert hint("arm.angel", NAMES) == "did you mean 'arm.angle'?"
    assert hint("tip.positon", NAMES) == "did you mean 'tip.position'?"
    assert hint("zzz", NAMES[:1]) == "there are arm.angle"
    assert hint("zzz", []) == "there are none"
    assert hint("zzz", [f"x{k}" for k in range(20)]).endswith("x11 and 8 more")


@pytest.fixture(scope="module")
def arm():
    return load(Path(__file__).parents[1] / "models" / "two_link_arm.toml")


def test_parameters_by_array_or_element(arm):
    speeds = [
        arm.simulate(0.05, 0.01, parameters=given)["shoulder.speed"]
        for given in ({}, {"gravity": [0, 0, 0]}, {"gravity[2]": 0.0}, {"gravity": [0, -9.81, 0]})
    ]
    assert (speeds[1] == speeds[2]).all() and (speeds[0] == speeds[3]).all()
    assert abs(speeds[0] - speeds[1])[-1] > 0.01


@pytest.mark.parametrize(
    "parameters, error, says",
    [
        ({"gravity": [0, 0]}, ValueError, "'gravity' needs 3 numbers"),
        ({"gravity": 0.0}, ValueError, "'gravity' needs 3 numbers"),
        ({"gravity[2]": [0, 0, 0]}, ValueError, "needs a number"),
        ({"gravty": 0.0}, KeyError, "did you mean 'gravity'"),
    ],
)
def test_parameters_that_do_not_fit(arm, parameters, error, says):
    with pytest.raises(error, match=says):
        arm.simulate(0.01, parameters=parameters)


def test_the_same_hint_everywhere(arm):
    """Of inputs, columns and a motion."""
    with pytest.raises(KeyError, match="no input 'shoulder.torqe'; did you mean 'shoulder.torque'"):
        arm.simulate(0.01, inputs={"shoulder.torqe": 1.0})

    with pytest.raises(KeyError, match="no column 'lower.hand.positon'; did you mean 'lower.hand.position'"):
        arm.simulate(0.01)["lower.hand.positon"]

    with pytest.raises(ValueError, match="did you mean 'shoulder.angle'"):
        arm.inverse({"shoulder.angel": 0.0}, [0.0, 0.1])
