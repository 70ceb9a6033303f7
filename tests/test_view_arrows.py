"""Arrows of forces are the forces of the run: they hold each body in balance, and springs, loads and inputs are what was asked for."""

import base64
from pathlib import Path

import numpy as np
import pytest

import mbdfmi
from mbdfmi.view.arrows import arrows
from mbdfmi.view.picture import picture

MODELS = Path(__file__).parents[1] / "models"

FORCES = {
    "name": "forces",
    "gravity": [0, 0, -9.81],
    "ground": {"marker": {"hook": {"position": [1, 0, 2]}}},
    "body": {
        "a": {
            "solid": {"box": {"size": [0.4, 0.2, 0.2], "mass": 2}},
            "marker": {"corner": {"position": [0.2, 0.1, 0.1], "axes": {"x": "y", "z": "z"}}},
            "input": ["force"],
            "input_axes": "body",
            "output": ["acceleration"],
        }
    },
    "joint": {"f": {"prismatic": {"axis": [0, 1, 1]}, "between": ["ground", "a"], "output": ["position"]}},
    "force": {
        "s": {"spring_damper": {"stiffness": 50, "rest_length": 0.5}, "between": ["ground.hook", "a.corner"]},
        "l": {"on": "a.corner", "load": {"table": {"time": [0, 0.4, 1], "force": [[0, 0, 0], [5, 0, 1], [5, 2, 0]], "interpolation": "cubic"}, "axes": "body"}},
        "m": {"on": "a", "load": {"moment": [0, 3, 0]}},
    },
}  # fmt: skip


def numbers(packed):
    data = base64.b64decode(packed["data"])
    if "scale" not in packed:
        return np.frombuffer(data, "<f4").astype(float)
    return packed["offset"] + packed["scale"] * np.frombuffer(data, "<i2")


def drawn(scene, until=1.0, **options):
    results = scene.simulate(until, **options)
    found = arrows(picture(scene, results.states))
    items = {}
    for item in found["items"]:
        at, values = (numbers(item[key]).reshape(-1, 3) for key in ("at", "values"))
        items.setdefault((item["name"], item["source"], item["what"]), []).append((at, values))
    return results, numbers(found["times"]), items


def test_forces_add_up_to_mass_times_acceleration():
    scene = mbdfmi.Scene(**FORCES)
    results, times, items = drawn(scene, inputs={"a.force": [1.0, 2.0, -3.0]}, step=0.02)
    assert set(items) == {("f", "reaction", "force"), ("f", "reaction", "moment"), ("s", "spring", "force"),
                          ("l", "load", "force"), ("m", "load", "moment"), ("a", "input", "force")}  # fmt: skip
    on_body = sum(
        items[key][0][1]
        for key in (("f", "reaction", "force"), ("l", "load", "force"), ("a", "input", "force"))
    )
    spring = items["s", "spring", "force"]
    np.testing.assert_allclose(spring[0][1], -spring[1][1], atol=1e-2)
    weight = np.array([0, 0, -9.81 * 2])
    rows = np.searchsorted(results["time"], times - 1e-6)
    np.testing.assert_allclose(
        on_body + spring[1][1] + weight, 2 * results["a.acceleration"][rows], atol=0.02
    )
    np.testing.assert_allclose(
        items["m", "load", "moment"][0][1], np.tile([0, 3, 0], (len(times), 1)), atol=1e-3
    )
    # they stand where they act
    np.testing.assert_allclose(
        items["l", "load", "force"][0][0], results.poses("a.corner")[0][rows], atol=1e-4
    )


@pytest.mark.parametrize("name", ["four_bar", "bricard", "slider_crank"])
def test_reactions_are_those_that_outputs_give(name):
    own = mbdfmi.load(MODELS / f"{name}.toml")
    scene = own.model_copy(deep=True)
    joint, first = next((n, j.between[0]) for n, j in scene.joint.items() if j.kind == "revolute")
    results, times, items = drawn(own)
    scene.joint[joint].output = ["reaction_force"]
    asked = scene.simulate(1.0)
    ((_, values),) = items[joint, "reaction", "force"]
    rows = np.searchsorted(asked["time"], times - 1e-6)
    np.testing.assert_allclose(
        np.linalg.norm(values, axis=1),
        np.linalg.norm(asked[f"{joint}.reaction_force"][rows], axis=1),
        rtol=1e-3,
        atol=1e-3 * np.abs(values).max(),
    )
