"""The independent route against the package: at random states of scenes of every kind, all that both can tell."""

import numpy as np
import pytest
from loop_scenes import random_loops
from scenes import random_scene

from mbdfmi import Scene
from mbdfmi.model import compile_scene
from mbdfmi.simulate import Instance
from .independent import System
from .telling import all_told

# relative to the size of what is told
CLOSE = 1e-9


def inputs_of(instance, seed):
    """Random inputs, as they stand in u, by name."""
    rng = np.random.default_rng(seed)
    instance.u[: instance.model.n_u] = rng.normal(size=instance.model.n_u)
    return named(instance.model.of_causality("input"), instance.u)


def named(variables, values):
    """Values by name, arrays as one."""
    found = {}

    for v, value in zip(variables, values):
        found.setdefault(v.name.partition("[")[0], []).append(float(value))

    return {name: np.array(value) if len(value) > 1 or name.endswith("efforts") else value[0] for name, value in found.items()}


def differences(data, seed=0, steps=(0.05, 0.1), parameters=None):
    """What the two routes tell differently: (time, name, package's, independent's), at the start and after steps."""
    instance = Instance(compile_scene(Scene.model_validate(all_told(data))), parameters)
    system = System(data, parameters)
    found, compared = [], 0

    for step in (0.0, *steps):
        inputs = inputs_of(instance, seed)

        if step:
            instance.step(step)

        told = named(instance.model.of_causality("output"), instance.outputs())
        own = system.evaluate(instance.time, system.motions_of(told), inputs, told)
        worst = np.abs(own["constraint residuals"]).max(initial=0.0)

        if worst > 1e-8:
            found.append((instance.time, "constraints", 0.0, worst))

        size = {name: 1.0 + np.abs(value).max() for name, value in told.items()}
        largest = 1.0 + max(np.abs(value).max() for name, value in told.items() if "acceleration" in name or "reaction" in name)

        for name, value in told.items():
            if name not in own:
                continue

            compared += 1
            scale = largest if any(word in name for word in ("accel", "alpha", "effort", "reaction", "power")) else size[name]

            if not np.abs(np.subtract(value, own[name])).max() <= CLOSE * scale:
                found.append((instance.time, name, value, own[name]))

    assert compared > 10
    return found


@pytest.mark.parametrize("seed", range(4))
def test_random_trees(seed):
    data = random_scene(seed, 5, kinds=("revolute", "prismatic", "spherical", "free")).model_dump(exclude_unset=True)
    assert differences(data, seed) == []


LOOPS = ("revolute", "universal", "spherical", "cylindrical", "screw", "planar", "distance", "point_on_line", "point_on_plane",
         "knife_edge", "rolling_sphere", "rolling_disk")  # fmt: skip


@pytest.mark.parametrize("kind", LOOPS)
def test_random_loops(kind):
    data = random_loops(LOOPS.index(kind), [kind], couplings=1, solver={"tolerance": 1e-11})
    assert differences(data, 1, steps=(0.02,)) == []
