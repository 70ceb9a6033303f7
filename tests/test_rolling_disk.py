"""A disk that rolls: stable when it is fast, and what it keeps."""

import numpy as np
import pytest
from scenes import assert_near
from scipy.integrate import solve_ivp
from scipy.spatial.transform import Rotation
from test_loops import formulations

from mbdfmi import Scene
from mbdfmi.compiler.model import compile_scene
from mbdfmi.run.instance import Instance


def disk(speed, lean, formulation="recursive"):
    """An upright thin disk of 1 m and 1 kg that rolls along x and leans by a little."""
    return {
        "name": "disk",
        "solver": {"integrator": "rk853", "tolerance": 1e-13, "formulation": formulation},
        "body": {"disk": {"mass": 1.0, "inertia": [0.25, 0.25, 0.5], "output": ["position", "omega"]}},
        "joint": {
            "free": {
                "free": {},
                "between": ["ground", "disk"],
                "start": {
                    "position": [0, 0, float(np.cos(lean))],
                    "axis_angle": {"axis": "x", "angle_rad": np.pi / 2 + lean},
                    "velocity": [speed, 0, 0],
                    "omega": (speed * np.array([0, np.cos(lean), np.sin(lean)])).tolist(),
                },
            },
            "roll": {"rolling_disk": {"radius": 1.0}, "between": ["ground", "disk"]},
        },
        "measure": {"axis": {"between": ["ground", "disk"], "output": ["angle"]}},
    }


@formulations
@pytest.mark.parametrize("part", [0.5, 0.9, 1.1, 2.0])
def test_upright_rolling_is_stable_when_it_is_fast(part, formulation):
    """Stable iff v^2 > g r / 3: the lean x obeys 5/4 x'' = g x - 3 v^2 (x - x0) with m = r = 1, from x0 without yaw."""
    speed = np.sqrt(part * 9.81 / 3)
    lean = 1e-6
    instance = Instance(compile_scene(Scene.model_validate(disk(speed, lean, formulation))))
    rate = np.sqrt(abs(3 * speed**2 - 9.81) / 1.25)
    found = []
    times = np.linspace(0, 4, 41)

    for t in times:
        if t > 0:
            instance.step(t - instance.time)

        found.append(instance.outputs()[-1] - np.pi / 2)

    middle = 3 * speed**2 / (3 * speed**2 - 9.81) * lean
    expected = middle + (lean - middle) * (np.cos(rate * times) if part > 1 else np.cosh(rate * times))
    assert_near(np.abs(found), np.abs(expected), 2e-5 * np.abs(expected).max())


@formulations
def test_what_a_rolling_disk_keeps(formulation):
    """Energy, and two integrals linear in the velocity: along any motion the spin s about the disk's axis and the rate q about its
    steepest line are functions of the angle x from the vertical to the axis, ds/dx = 2/3 q, dq/dx = 2 s - q cot x (m = r = 1).
    """
    scene = disk(2.0, 0.4, formulation)
    start = scene["joint"]["free"]["start"]
    axis = Rotation.from_rotvec([np.pi / 2 + 0.4, 0, 0]).apply([0, 0, 1])
    w = 2.5 * axis + np.array([0.7, 0, 0.6])
    up = np.array([0, 0, 1]) - axis[2] * axis
    start |= {"omega": w.tolist(), "velocity": np.cross(w, up / np.linalg.norm(up)).tolist()}
    scene["output"] = ["total_energy", "constraint_gap", "constraint_rate"]
    scene["body"]["disk"]["output"] = ["euler_parameters", "omega"]
    instance = Instance(compile_scene(Scene.model_validate(scene)))
    rows_ = [instance.outputs().copy()]

    for _ in range(50):
        instance.step(0.1)
        rows_.append(instance.outputs().copy())

    rows_ = np.array(rows_)
    names = [v.name for v in instance.model.of_causality("output")]
    column = dict(zip(names, rows_.T))
    axes = Rotation.from_quat(rows_[:, :4]).apply([0, 0, 1])
    x = np.arccos(axes[:, 2])
    up = ([0, 0, 1] - axes[:, 2:] * axes) / np.sin(x)[:, None]
    s, q = np.sum(rows_[:, 4:7] * axes, axis=1), np.sum(rows_[:, 4:7] * up, axis=1)
    assert np.ptp(column["total_energy"]) < 1e-10 * column["total_energy"][0]
    assert column["constraint_gap"].max() < 1e-13
    assert column["constraint_rate"].max() < 1e-12
    assert np.ptp(x) > 0.3

    def slope(x, y):
        return [2 / 3 * y[1], 2 * y[0] - y[1] / np.tan(x)]

    for end in (x.min(), x.max()):
        line = solve_ivp(slope, (x[0], end), [s[0], q[0]], rtol=1e-12, atol=1e-13, dense_output=True).sol
        here = (x - x[0]) * (end - x[0]) >= 0
        assert_near(np.array([s, q])[:, here], line(x[here]), 1e-9)
