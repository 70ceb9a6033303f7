"""The independent route against the package: at random states of scenes of every kind,
all that both can tell."""

import tomllib
from pathlib import Path

import numpy as np
import pytest
from loop_scenes import random_loops
from scenes import random_scene

from mbdfmi import Scene
from mbdfmi.compiler.model import compile_scene
from mbdfmi.run.instance import Instance

from .independent import System, unknown
from .kinds import FAMILIES, arm
from .telling import all_told

# relative to the largest of what is told
CLOSE = 1e-9


def inputs_of(instance, seed, jumps=False):
    """Random inputs, as they stand in u, by name. jumps : commanded motions too."""
    rng = np.random.default_rng(seed)

    for v in instance.model.of_causality("input"):
        if jumps or (not v.name.startswith("ground.") and not v.name.endswith("_command")):
            instance.u[v.index] = rng.normal()

    return named(instance.model.of_causality("input"), instance.u)


def named(variables, values):
    """Values by name, arrays as one."""
    found = {}

    for v, value in zip(variables, values):
        found.setdefault(v.name.partition("[")[0], []).append(float(value))

    return {
        name: np.array(value) if len(value) > 1 or name.endswith("efforts") else value[0]
        for name, value in found.items()
    }


def differences(data, seed=0, steps=(0.1,), parameters=None, redundant=False, jumps=False):
    """What the two routes tell differently: (time, name, package's, independent's),
    at the start and after steps.

    redundant : whether some of it, as reactions, is not determined, so that it need not be told.
    """
    data = all_told(data)
    instance = Instance(compile_scene(Scene.model_validate(data)), parameters)
    system = System(data, parameters)
    found = []

    for step in (0.0, *steps):
        if step:
            instance.step(step)

        # what is commanded holds where it is told
        inputs = inputs_of(instance, seed + int(1e3 * step), jumps)
        told = named(instance.model.of_causality("output"), instance.outputs())
        own = system.evaluate(instance.time, system.motions_of(told), inputs, told)
        gap = np.abs(own["constraint residuals"]).max(initial=0.0)
        found += [(instance.time, "constraints", 0.0, gap)] if gap > 1e-8 else []
        size = 1.0 + max(np.abs(value).max() for value in told.values())

        for name, value in told.items():
            if name not in own:
                expected = redundant or name.startswith(("constraint_", "solver.")) or "zyx" in name
                found += [] if expected else [(instance.time, name, value, None)]
            elif not np.abs(np.subtract(value, own[name])).max() <= CLOSE * size:
                found.append((instance.time, name, value, own[name]))

    return found


@pytest.mark.parametrize("seed", range(4))
def test_random_trees(seed):
    data = random_scene(seed, 5, kinds=("revolute", "prismatic", "spherical", "free")).model_dump(
        exclude_unset=True
    )
    assert differences(data, seed) == []


LOOPS = ("revolute", "universal", "spherical", "cylindrical", "screw", "planar", "distance", "point_on_line",
         "point_on_plane",
         "knife_edge", "constant_velocity", "angle", "rolling_sphere", "rolling_disk")  # fmt: skip


@pytest.mark.parametrize("kind", LOOPS)
def test_random_loops(kind):
    data = random_loops(LOOPS.index(kind), [kind], couplings=1, solver={"tolerance": 1e-11})
    assert differences(data, 1, steps=(0.02,), redundant=True) == []


@pytest.mark.parametrize("family", FAMILIES)
def test_every_kind(family):
    for name, data in FAMILIES[family]().items():
        assert differences(data, 1, steps=(0.03,), jumps=family == "commands") == [], name


RUNS = {
    "four bar": "four_bar", "disk": "rolling_disk", "cam": ("contacts", "cam ring"),
    "moving ground": ("grounds", "smooth"), "screw": ("couplings", "screw joint"),
    "track": ("contacts", "point on curve ring"),
}  # fmt: skip


@pytest.mark.parametrize("which", RUNS)
def test_runs(which):
    """Both integrate to the same motion."""
    of = RUNS[which]
    data = (
        tomllib.loads((FOLDER / f"{of}.toml").read_text())
        if isinstance(of, str)
        else FAMILIES[of[0]]()[of[1]]
    )
    data = data | {"solver": {"tolerance": 1e-11}}
    instance = Instance(compile_scene(Scene.model_validate(all_told(data))))
    system, inputs = System(data), inputs_of(instance, 1)
    outputs = instance.model.of_causality("output")
    told = named(outputs, instance.outputs())
    times = [0.0, 0.02, 0.05]
    own = system.simulate(times, system.motions_of(told), inputs, told)

    for begin, end, motions in zip(times, times[1:], own[1:]):
        instance.step(end - begin)
        other = system.motions_of(named(outputs, instance.outputs()))

        for body in system.bodies:
            for mine, theirs in zip(motions[body], other[body]):
                assert np.abs(mine - theirs).max() < 1e-9 * (1.0 + np.abs(theirs).max())


def test_a_run_keeps_energy_and_momentum():
    """Three bodies on ball joints and a strut, free in space."""
    joints = {
        "f": {
            "free": {},
            "between": ["ground", "a"],
            "start": {"omega": [1, 2, -1], "velocity": [0.3, 0.1, 0]},
        },
        "g": {"spherical": {}, "between": ["a.end", "b.side"], "start": {"omega": [-1, 0.5, 3]}},
        "h": {"universal": {}, "between": ["b.end", "c.side"], "start": {"speeds": [2, -3]}},
    }
    strut = {"spring_damper": {"stiffness": 20, "rest_length": 0.3}, "between": ["a.side", "c.end"]}
    data = {
        "name": "e",
        "gravity": [0, 0, 0],
        "body": dict.fromkeys("abc", arm()),
        "joint": joints,
        "force": {"s": strut},
    }
    instance = Instance(compile_scene(Scene.model_validate(all_told(data))))
    told = named(instance.model.of_causality("output"), instance.outputs())
    system, times = System(data), [0.0, 0.3, 0.6]
    states = system.simulate(times, system.motions_of(told), {}, told)
    kept = [system.evaluate(t, state) for t, state in zip(times, states)]

    for name in ("total_energy", "linear_momentum", "angular_momentum"):
        for later in kept[1:]:
            assert np.abs(later[name] - kept[0][name]).max() < 1e-9


FOLDER = Path(__file__).parents[2] / "models"
MODELS = sorted(FOLDER.glob("*.toml"))


@pytest.mark.parametrize("path", MODELS, ids=lambda path: path.stem)
def test_models(path):
    data = tomllib.loads(path.read_text())

    if unknown(data):
        pytest.skip(f"no equations for {unknown(data)}")

    assert differences(data, 1, steps=(0.05,), redundant=True) == []


@pytest.mark.parametrize("family", ["efforts", "forces", "bodies", "drivers"])
def test_parameters(family):
    """All that are not of the start, each changed by some percent."""
    rng = np.random.default_rng(1)
    scenes = FAMILIES[family]()

    for data in [scenes[name] for name in list(scenes)[::4]]:
        known = compile_scene(Scene.model_validate(all_told(data))).of_causality("parameter")
        values = {
            v.name: v.start * rng.uniform(1.0, 1.05) for v in known
            if not v.name.startswith("solver.") and not v.name.partition("[")[0].endswith("_start")
        }  # fmt: skip
        assert differences(data, 1, parameters=values) == []
