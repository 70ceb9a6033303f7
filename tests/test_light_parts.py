"""Parts of next to no mass among heavy ones: accelerations and reactions keep their digits in all formulations.

`tests/hard/test_small_masses.py` has the motions.
"""

import numpy as np
import pytest
from numpy.testing import assert_allclose

from mbdfmi import Scene
from mbdfmi.compiler.model import compile_scene
from mbdfmi.run.instance import Instance

FORMULATIONS = ("recursive", "embedding", "augmented")
RATIOS = (1.0, 1e-4, 1e-7, 1e-9, 1e-12)
G = 9.81


def bar(mass):
    """A uniform bar of 1 m along x, with a marker at its end."""
    J = mass / 12
    marker = {"end": {"position": [1, 0, 0]}}
    return {
        "mass": mass,
        "com": [0.5, 0, 0],
        "inertia": [J * 1e-2, J, J],
        "marker": marker,
        "output": ["alpha"],
    }


def outputs(data):
    """Outputs at the start by name, and the instance."""
    instance = Instance(compile_scene(Scene.model_validate({"name": "light", "gravity": [0, -G, 0]} | data)))
    found = {}

    for v, value in zip(instance.model.of_causality("output"), instance.outputs()):
        found.setdefault(v.name.partition("[")[0], []).append(value)

    return {name: np.array(value) for name, value in found.items()}, instance


def chain(masses, kind, formulation, seed):
    """Bars on each other in a random position and motion."""
    rng = np.random.default_rng(seed)
    body = {f"b{k}": bar(mass) for k, mass in enumerate(masses)}
    joint = {}

    for k in range(len(masses)):
        first = f"b{k - 1}.end" if k else "ground"
        start = {"angle": rng.uniform(-3, 3), "speed": rng.normal()}
        options = {"axis": rng.normal(size=3).tolist()}

        if kind == "universal":
            start = {"angles": rng.uniform(-1, 1, 2).tolist(), "speeds": rng.normal(size=2).tolist()}
            options = {}

        between = [first, f"b{k}"]
        joint[f"j{k}"] = {
            kind: options,
            "between": between,
            "start": start,
            "output": ["reaction_force", "reaction_moment"],
        }

    return {"body": body, "joint": joint, "solver": {"formulation": formulation}}


@pytest.mark.parametrize("ratio", RATIOS)
@pytest.mark.parametrize("formulation", FORMULATIONS)
def test_double_pendulum_with_a_light_upper_bar(formulation, ratio):
    """Closed form of two bars, also nearly stretched, where the light one bears no bending but all the tension."""
    rng = np.random.default_rng(1)

    for second in (*rng.uniform(-3, 3, 3), 1e-2, 1e-5, 1e-9, 0.0):
        data = chain([ratio, 1.0], "revolute", formulation, 0)

        for joint in data["joint"].values():
            joint["revolute"] = {}

        (a, p), (b, q) = (rng.uniform(-3, 3), rng.normal()), (second, 2.0)
        data["joint"]["j0"]["start"] = {"angle": a, "speed": p}
        data["joint"]["j1"]["start"] = {"angle": b, "speed": q}
        found, _ = outputs(data)
        a, q = a + np.pi / 2, p + q
        b = a + b
        c, s = np.cos(a - b), np.sin(a - b)
        M = [[ratio / 3 + 1.0, c / 2], [c / 2, 1 / 3]]
        f = [-s / 2 * q**2 - G * (ratio / 2 + 1) * np.sin(a), s / 2 * p**2 - G / 2 * np.sin(b)]
        wanted = np.linalg.solve(M, f)
        alpha = [found["b0.alpha"][2], found["b1.alpha"][2]]
        assert_allclose(alpha, wanted, rtol=0, atol=1e-12 * np.abs(wanted).max())


@pytest.mark.parametrize("seed", range(2))
@pytest.mark.parametrize("ratio", RATIOS[:-1])
@pytest.mark.parametrize("kind", ["revolute", "universal"])
def test_chains_of_light_and_heavy_bars(kind, ratio, seed):
    """Accelerations and reactions in absolute coordinates, by multipliers, are those of articulated bodies, which have no rows.

    The light bars' inertia about their own axes is a hundredth of the other: with 1e-12 no digit would be left.
    """
    masses = [1.0, ratio, ratio, 2.0, ratio, 1.5]
    expected, _ = outputs(chain(masses, kind, "recursive", seed))
    found, _ = outputs(chain(masses, kind, "augmented", seed))

    for name in expected:
        size = np.abs(expected[name]).max()
        assert_allclose(found[name], expected[name], rtol=0, atol=1e-9 * max(1.0, size))


def four_bar(ratio, formulation):
    """A parallel crank and rocker on a light coupler, all axes along z: three of the rows that close it are redundant."""
    body = {"crank": bar(1.0), "coupler": bar(ratio), "rocker": bar(2.0)}
    start = {"angle": 1.0, "speed": 2.0}
    joint = {
        "crank": {"revolute": {}, "between": ["ground", "crank"], "start": start},
        "coupler": {
            "revolute": {},
            "between": ["crank.end", "coupler"],
            "start": {"angle": -1.0, "speed": -2.0},
        },
        "rocker": {
            "revolute": {},
            "between": ["ground.far", "rocker"],
            "start": start,
            "output": ["acceleration"],
        },
        "pin": {"revolute": {}, "between": ["coupler.end", "rocker.end"]},
    }
    ground = {"marker": {"far": {"position": [1, 0, 0]}}}
    return {
        "ground": ground,
        "body": body,
        "joint": joint,
        "solver": {"formulation": formulation},
        "output": ["constraint_gap"],
    }


@pytest.mark.parametrize("ratio", RATIOS)
@pytest.mark.parametrize("formulation", FORMULATIONS)
def test_a_redundant_loop_with_a_light_coupler(formulation, ratio):
    """The coupler only moves along: (J + m l^2 of both) phi'' = - g l cos(phi) (m1 / 2 + m2 / 2 + m)."""
    found, instance = outputs(four_bar(ratio, formulation))
    inertia = (1.0 + 2.0) / 3 + ratio
    wanted = -G * np.cos(1.0) * (1.5 + ratio) / inertia
    assert_allclose(found["rocker.acceleration"], wanted, rtol=1e-11)
    assert np.count_nonzero(instance.d.row_redundant) == 3


@pytest.mark.parametrize("ratio, told", [(1e-9, False), (1e-11, False), (1e-14, True)])
@pytest.mark.parametrize("formulation", FORMULATIONS)
def test_parts_too_light_for_constraints_are_named(formulation, ratio, told):
    """The mass here, and no notice where there are no rows."""
    data = four_bar(ratio, formulation)
    data["body"]["coupler"]["inertia"] = [ratio] * 3
    notices = compile_scene(Scene.model_validate({"name": "light"} | data)).notices
    assert any("coupler" in str(notice) and "digit" in str(notice) for notice in notices) == told

    data = chain([ratio, 1.0], "revolute", "recursive", 0)
    assert compile_scene(Scene.model_validate({"name": "light"} | data)).notices == []


def rod_pendulum(ratio, kinds, **solver):
    """1 kg that hangs on a rod with these joints at its ends."""
    joint = {
        "top": {kinds[0]: {}, "between": ["ground", "rod"]},
        "low": {kinds[1]: {}, "between": ["rod.end", "bob"]},
    }
    body = {"rod": bar(ratio), "bob": {"mass": 1.0, "inertia": [0.01] * 3}}
    return Scene.model_validate({"name": "rod", "body": body, "joint": joint, "solver": solver})


def test_a_spin_without_inertia_is_named():
    """Of a light rod between two ball joints: rounding turns it, and steps become small."""
    assert "body.rod" in rod_pendulum(1e-9, ("spherical", "spherical")).notices[0]
    assert "universal" in rod_pendulum(1e-9, ("spherical", "spherical")).notices[0]
    assert rod_pendulum(1e-3, ("spherical", "spherical")).notices == []
    assert rod_pendulum(1e-9, ("universal", "spherical")).notices == []
    assert rod_pendulum(1e-9, ("spherical", "spherical"), integrator="rk4", step=1e-3).notices == []
