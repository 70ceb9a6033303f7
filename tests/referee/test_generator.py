"""The generator of random scenes, its coverage of the schema, and the shrinker."""

import math
import re
import tomllib

import pytest

from mbdfmi import Scene
from mbdfmi.compiler.model import compile_scene
from mbdfmi.run.instance import Instance, SimulationError

from . import coverage, generator, shrink

MOVED = re.compile("at the start is (given as|turned)")


@pytest.fixture(scope="module")
def scenes():
    """A run of scenes."""
    return [generator.draw(seed) for seed in range(60)]


def test_the_same_seed_gives_the_same_scene(scenes):
    assert [generator.draw(seed) for seed in range(20)] == scenes[:20]


def test_scenes_are_what_tomllib_gives(scenes):
    for data in scenes:
        assert tomllib.loads(shrink.toml(data)) == data
        scene = Scene.model_validate(data)
        assert Scene.model_validate(tomllib.loads(scene.to_toml())) == scene


@pytest.mark.parametrize("focus", generator.FOCUS)
def test_each_focus_gives_small_scenes(focus):
    for seed in range(3):
        assert 1 <= len(generator.draw(seed, focus=focus)["body"]) <= 6


def test_keys_are_those_of_the_schema(scenes):
    assert set().union(*map(coverage.keys_of, scenes)) <= coverage.all_keys()


def test_a_short_run_uses_nearly_all_keys(scenes):
    counts = coverage.count(scenes)
    used = sum(n > 0 for n in counts.values())
    assert used > 0.75 * len(counts)


@pytest.mark.long
def test_every_key_is_in_at_least_twenty_scenes_of_a_long_run():
    counts = coverage.count(
        generator.draw(seed, focus=focus) for focus, seeds in generator.LONG_RUN.items() for seed in seeds
    )
    print(coverage.table(counts))
    assert min(counts.values()) >= coverage.LEAST


def test_keys_of_a_scene():
    data = {
        "name": "keys",
        "body": {"b": {"mass": 1.0, "inertia": [1.0, 1.0, 1.0, 0.0, 0.0, 0.0],
                       "marker": {"m": {"output": ["zyx"]}}}},
        "joint": {"j": {
            "revolute": {"axis": [0, 1, 0]}, "between": ["ground", "b.m"],
            "damper": {"table": {"speed": [0, 1], "effort": [0, 1]}},
            "driver": {"table": {"time": [0, 1], "position_deg": [0, 1], "interpolation": "quintic"}},
        }},
    }  # fmt: skip
    Scene.model_validate(data)
    assert coverage.keys_of(data) == {
        "name", "body", "body.mass", "body.inertia", "body.inertia=6", "body.marker", "body.marker.output",
        "body.marker.output=zyx", "joint", "joint.revolute", "joint.revolute.axis",
        "joint.revolute.axis=vector", "joint.revolute.between", "joint.revolute.damper",
        "joint.revolute.damper.table", "joint.revolute.damper.table.speed",
        "joint.revolute.damper.table.effort", "joint.revolute.driver", "joint.revolute.driver.table",
        "joint.revolute.driver.table.time", "joint.revolute.driver.table.position_deg",
        "joint.revolute.driver.table.interpolation",
        "joint.revolute.driver.table.interpolation=quintic",
    }  # fmt: skip


def test_rare_keys_are_marked():
    text = coverage.table(coverage.count([{"name": "a", "body": {}}] * 20))
    rare = text.partition("in fewer than")[2].split()
    assert "title" in rare and "name" not in rare


def test_small_scenes_start():
    """All but a few whose joints start so far off that nothing closes; those say so."""
    refused = []

    for seed in range(60):
        data = generator.draw(seed, size=1 + seed % 3)
        try:
            assert all(map(math.isfinite, Instance(compile_scene(Scene.model_validate(data))).outputs()))
        except SimulationError as error:
            refused.append(str(error))

    assert len(refused) <= 2 and all("cannot be closed" in text for text in refused), refused


def test_a_start_that_is_drawn_to_fit_is_kept():
    """Loops, contacts, couplings and drivers of a start written in full fit it:
    positions and speeds are not moved."""
    told = []

    for seed in range(40):
        data = generator.draw(seed, size=2, start="fit")
        told += [
            (seed, text)
            for text in Instance(compile_scene(Scene.model_validate(data))).notices
            if MOVED.search(text)
        ]

    assert not told


def test_a_scene_shrinks_to_what_fails():
    def has_a_spring(data):
        return any("spring" in joint for joint in data["joint"].values())

    data = next(data for seed in range(100) if has_a_spring(data := generator.draw(seed)))
    small = shrink.shrink(data, has_a_spring)
    assert has_a_spring(small) and len(small["body"]) == 1 and len(small["joint"]) == 1
    assert len(shrink.toml(small).splitlines()) < 12


def test_what_belongs_together_stays_and_numbers_become_plain():
    """A gear is left with its two joints, a number above a bound as the plainest there is."""

    def fails(data):
        gears = [c for c in data.get("coupling", {}).values() if "gear" in c]
        masses = [body.get("mass", 0.0) for body in data["body"].values()]
        return bool(gears) and max(masses) > 0.55

    data = next(data for seed in range(300) if fails(data := generator.draw(seed, size=4)))
    small = shrink.shrink(data, fails)
    assert (
        {*small} == {"name", "body", "joint", "coupling"}
        and len(small["coupling"]) == 1
        and len(small["joint"]) == 2
    )
    assert max(body.get("mass", 0.0) for body in small["body"].values()) == 1.0
    assert shrink.shrink(data, fails) == small


def test_shrinking_stops_after_its_tries():
    data, asked = generator.draw(1, size=5), []
    shrink.shrink(data, lambda smaller: asked.append(smaller) or True, tries=7)
    assert len(asked) == 7 and all(Scene.model_validate(smaller) for smaller in asked)


def test_what_never_fails_again_is_given_back():
    data = generator.draw(2, size=2)
    assert shrink.shrink(data, lambda smaller: False, tries=50) == data
