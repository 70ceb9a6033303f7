"""The generator of random scenes, its coverage of the schema, and the shrinker."""

import tomllib

import pytest

from mbdfmi import Scene

from . import coverage, generator, shrink


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
        assert 1 <= len(generator.draw(seed, focus=focus)["body"]) <= 4


def test_keys_are_those_of_the_schema(scenes):
    assert set().union(*map(coverage.keys_of, scenes)) <= coverage.all_keys()


def test_a_scene_shrinks_to_what_fails():
    def has_a_spring(data):
        return any("spring" in joint for joint in data["joint"].values())

    data = next(data for seed in range(100) if has_a_spring(data := generator.draw(seed)))
    small = shrink.shrink(data, has_a_spring)
    assert has_a_spring(small) and len(small["body"]) == 1 and len(small["joint"]) == 1
    assert len(shrink.toml(small).splitlines()) < 12
