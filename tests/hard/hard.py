"""What the hard cases share: the integrators they are tried with, and a run that passes or stops in good
order.

Each case states its class of difficulty and a criterion: a closed form, something conserved, known digits, or
a second route to the same motion. It meets the criterion, or the run stops with a reason and the time it
reached. What is never allowed is a NaN, a hang or a crash.
"""

from dataclasses import dataclass
from multiprocessing import get_context

import numpy as np
import pytest

from benchmarks.problem_files import problem_file as problem  # noqa: F401
from benchmarks.problem_files import scene_of  # noqa: F401
from mbdfmi import Scene
from mbdfmi.compiler.model import compile_scene
from mbdfmi.run.instance import Instance, SimulationError
from mbdfmi.steppers import STEPPERS

# integrators by what they are for; those that this version does not know are left out of every case
EXPLICIT = ("rk54", "rk853")
STIFF = ("radau", "auto")
ADAPTIVE = EXPLICIT + STIFF
FIXED = ("rk4", "gauss", "ros2")

FORMULATIONS = ("recursive", "embedding", "augmented")


def adaptive(tolerance, allowed, among=ADAPTIVE, **more):
    """(solver table, allowed error, id) of each adaptive integrator at a tolerance.

    The estimate that radau makes is of order 3 where its error is of order 5: it keeps a tolerance less
    sharply.
    """
    return [
        ({"integrator": name, "tolerance": tolerance} | more, allowed * (10 if name == "radau" else 1), name)
        for name in among
    ]


def fixed(name, step, allowed):
    """(solver table, allowed error, id) of an integrator of fixed step (s)."""
    return [({"integrator": name, "step": step}, allowed, name)]


def solvers(*choices):
    """Parametrises a test over `solver` and `allowed` by such lists."""
    known = [choice for some in choices for choice in some if choice[0]["integrator"] in STEPPERS]
    ids = [name for _, _, name in known]
    return pytest.mark.parametrize("solver, allowed", [choice[:2] for choice in known], ids=ids)


formulations = pytest.mark.parametrize("formulation", FORMULATIONS)


@dataclass
class Run:
    """Outputs at times, as far as the run came.

    t (n,) : s.  y : name -> (n,), or (n, components) of an array.  stop : why it ended early, or None.
    """

    instance: Instance
    t: np.ndarray
    y: dict
    stop: SimulationError | None

    def __getitem__(self, name):
        return self.y[name]

    @property
    def steps(self):
        return int(self.instance.d.steps[0])

    @property
    def evaluations(self):
        return int(self.instance.d.evaluations[0])


def start(scene, solver=None, **arguments):
    """An instance of a scene written as a dict."""
    table = scene.get("solver", {}) | (solver or {})
    return Instance(compile_scene(Scene.model_validate(scene | {"solver": table})), **arguments)


def try_run(scene, times, solver=None):
    """A run through the times; it may stop early, but in good order: finite, with a reason and the time."""
    instance = start(scene, solver)
    rows, stop = [], None

    for t in times:
        try:
            if t > instance.time:
                instance.step(t - instance.time)

            y = instance.outputs().copy()
        except SimulationError as why:
            stop = why
            stopped_in_good_order(instance, why)
            break

        assert np.all(np.isfinite(y)), f"an output is not finite at {t} s, and nobody said so"
        assert np.all(np.isfinite(instance.d.x))
        rows.append(y)

    names = [v.name.partition("[")[0] for v in instance.model.of_causality("output")]
    rows = np.array(rows).reshape(len(rows), len(names))
    columns = {name: [k for k, other in enumerate(names) if other == name] for name in dict.fromkeys(names)}
    y = {name: rows[:, k[0]] if len(k) == 1 else rows[:, k] for name, k in columns.items()}
    return Run(instance, np.asarray(times, float)[: len(rows)], y, stop)


def run(scene, times, solver=None):
    """A run that must come to its end."""
    found = try_run(scene, times, solver)
    assert found.stop is None, found.stop
    return found


def stopped_in_good_order(instance, why):
    """Why a run stopped is said, and when; the state is the last good one."""
    assert len(str(why)) > 20
    assert "(time " in str(why)
    assert np.isfinite(why.time)
    assert why.time == instance.time
    assert np.all(np.isfinite(instance.d.x))


def against(found, wanted):
    """Largest difference of (n,) or (n, k), by the largest value wanted."""
    return np.abs(np.asarray(found) - wanted).max() / np.abs(wanted).max()


def drift(values):
    """Largest change of what ought to be constant, (n,), by its value at first."""
    return np.abs(values / values[0] - 1).max()


def bars(n, **tables):
    """n uniform bars of 1 m, 1 kg on revolute joints about z, all along x from rest, weight along -y."""
    marker = {"end": {"position": [1, 0, 0]}}
    bar = {"mass": 1.0, "com": [0.5, 0, 0], "inertia": [0.001, 1 / 12, 1 / 12], "marker": marker}
    body = {f"bar{k}": bar for k in range(1, n + 1)}
    body[f"bar{n}"] = bar | {"marker": {"end": marker["end"] | {"output": ["position", "velocity"]}}}
    joint = {
        f"j{k}": {"revolute": {}, "between": [f"bar{k - 1}.end" if k > 1 else "ground", f"bar{k}"]}
        for k in range(1, n + 1)
    }
    scene = {
        "name": "bars",
        "gravity": [0, -9.81, 0],
        "body": body,
        "joint": joint,
        "output": ["total_energy"],
    }
    return scene | tables


def ends(function, seconds):
    """Whether a call ends in this time, in a process of its own that can be stopped."""
    process = get_context("fork").Process(target=function)
    process.start()
    process.join(seconds)
    alive = process.is_alive()
    process.kill()
    process.join()
    return not alive
