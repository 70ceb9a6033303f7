"""Lines that come under the sea's bed where it does not carry them: told once, with how deep they come."""

import re

import numpy as np
import pytest
from fmu_host import Instance as Hosted
from fmu_host import Library, warnings_of_runs
from scenes import assert_near

from mbdfmi import Scene
from mbdfmi.compiler.model import compile_scene
from mbdfmi.run.instance import Instance

G = 9.80665
LINE = {"length": 120.0, "mass": 40.0, "diameter": 0.0, "stiffness": 5e6}
HALVES = {"sections": [LINE | {"length": 50.0}, LINE | {"length": 70.0}]}


def between(line, depth=42.0, speed=1.0, **solver):
    """A line from a body that stands to one that comes nearer, both near the surface: it sags as they meet."""
    rail = {"prismatic": {"axis": "x"}, "between": ["ground", "boat"]}
    return Scene.model_validate(
        {
            "name": "towed",
            "gravity": [0, 0, -G],
            "solver": solver,
            "sea": {"depth": depth} if depth else {},
            "body": {
                "barge": {"mass": 1e5, "inertia": [1e5] * 3},
                "boat": {"mass": 1e4, "inertia": [1e4] * 3, "output": ["position"]},
            },
            "joint": {
                "moored": {"fixed": {}, "between": ["ground", "barge"]},
                "sails": rail | {"driver": {"constant_speed": -speed}, "start": {"position": 115.0}},
            },
            "force": {
                "tow": {"catenary": line, "between": ["barge", "boat"], "output": ["force", "tension"]},
            },
        }
    )


def under(texts):
    return [text for text in texts if "the sea's bed is at" in text]


def deepest(run_force, w, EA):
    """z (m) of the middle of a line of even ends, by the pull (N) at one: (s - H) / w of the catenary, and what it stretches."""
    H, V = abs(run_force[0]), abs(run_force[2])
    return -(np.hypot(H, V) - H) / w - V * V / (2 * EA * w)


@pytest.mark.parametrize("line", [LINE, HALVES], ids=["one", "two sections"])
def test_a_line_under_the_bed_is_told_once(line):
    """As soon as it is there, with the depth of its middle."""
    instance = Instance(compile_scene(between(line, integrator="rk4", step=0.5)))
    names = [v.name for v in instance.model.of_causality("output")]
    first = names.index("tow.force[1]")
    depths = []

    for _ in range(140):
        told = len(under(instance.notices))
        instance.step(0.5)
        z = deepest(instance.outputs()[first : first + 3], LINE["mass"] * G, LINE["stiffness"])
        depths.append(z)
        assert len(under(instance.notices)) == (z < -1.01 * 42.0 or told)

        if len(under(instance.notices)) > told:
            at = float(re.search(r"comes down to z = (\S+) m", under(instance.notices)[0]).group(1))
            assert_near(at, z, 1e-5 * abs(z))

    (text,) = under(instance.notices)
    assert text.startswith("tow comes down to") and "bed is at -42 m" in text
    assert min(depths) < -50.0 < -42.0 < max(depths)


@pytest.mark.parametrize("integrator", ["auto", "rk54", "rk853", "radau", "rk4", "ros2", "gauss"])
def test_every_stepper_tells_it_and_goes_on_as_without(integrator):
    """What is looked at to tell it changes no number."""
    step = {"step": 0.25} if integrator in ("rk4", "ros2", "gauss") else {}
    runs = [between(LINE, depth, integrator=integrator, **step).simulate(40.0, 2.0) for depth in (42.0, None)]
    assert len(under(runs[0].notices)) == 1 and not under(runs[1].notices)
    assert np.array_equal(runs[0]["tow.force"], runs[1]["tow.force"])
    assert not under(between(LINE, 80.0, integrator=integrator, **step).simulate(40.0, 2.0).notices)


def test_a_line_on_the_bed_is_not_told_but_an_end_under_it_is():
    """What lies there lies there; a fairlead that is drawn down through the bed does not."""
    for speed, told in ((-0.2, 0), (-2.0, 1)):
        scene = Scene.model_validate(
            {
                "name": "anchored",
                "gravity": [0, 0, -G],
                "sea": {"depth": 50.0},
                "ground": {"marker": {"anchor": {"position": [0, 0, -50.2]}}},
                "body": {"buoy": {"mass": 1e4, "inertia": [1e4] * 3}},
                "joint": {
                    "sinks": {
                        "prismatic": {"axis": "z"}, "between": ["ground", "buoy"], "start": {"position": -20.0},
                        "driver": {"constant_speed": speed},
                    }
                },
                "force": {"line": {"catenary": LINE, "between": ["ground.anchor", "buoy"]}},
            }
        )  # fmt: skip
        assert len(under(scene.simulate(20.0, 0.5).notices)) == told


def test_in_the_log_of_an_fmu(tmp_path):
    """Once; a snapshot remembers whether it was said, a reset begins anew."""
    scene = between(LINE)
    fmu = Hosted(Library(scene.export(tmp_path / "low.fmu"), tmp_path / "low")).start()
    texts, restored, anew = warnings_of_runs(fmu, 2.0, 20, under)
    assert len(texts) == 1 and "tow comes down to z" in texts[0]
    assert restored == texts
    assert anew == texts
    fmu.free()
