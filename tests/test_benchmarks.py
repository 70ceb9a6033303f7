"""The benchmark problems of benchmarks/reference (each with its source) in relative and in absolute coordinates.

Asked for are 8 digits of every quantity, or as many as the file says to be trusted; where a run reaches more, about a tenth of what
it reaches is asked for. An error is the largest difference in the largest value of its quantity.
"""

import numpy as np
import pytest

from benchmarks.problem_files import problem_file as problem
from benchmarks.problem_files import scene_of

SOLVER = {"integrator": "rk853", "tolerance": 1e-12}
FORMULATIONS = ["recursive", "embedding", "augmented"]
formulations = pytest.mark.parametrize("formulation", FORMULATIONS)


def solver(formulation, tolerance=1e-12):
    """Solver settings."""
    return SOLVER | {"formulation": formulation, "tolerance": tolerance}


def error_of(data, found):
    """The largest error of quantities name -> (n,) at the first n times of the reference."""
    wanted = data["column"]
    return max(
        np.abs(x - wanted[name][: len(x)]).max() / np.abs(wanted[name]).max() for name, x in found.items()
    )


def turned(angle, wanted):
    """The angle plus the number of turns that brings it next to the wanted one."""
    return angle + 2 * np.pi * np.round((wanted - angle) / (2 * np.pi))


def columns_of(y, /, **names):
    """Quantities by name from (output, component) pairs."""
    return {name: y[output][:, k] for name, (output, k) in names.items()}


# the IFToMM set


def rod_pendulum(formulation, tolerance):
    """A particle on a massless rod: Cartesian coordinates and one constraint."""
    return {
        "name": "A01",
        "gravity": [0, -9.81, 0],
        "solver": solver(formulation, tolerance),
        "body": {"bob": {"mass": 1.0, "inertia": [0.1] * 3, "output": ["position", "velocity"]}},
        "joint": {
            "hold": {"translation": {}, "between": ["ground", "bob"], "start": {"position": [-1, 0, 0]}},
            "rod": {"distance": {}, "between": ["ground", "bob"]},
        },
        "output": ["total_energy"],
    }


def pendulum_error(y, data):
    found = columns_of(
        y, x=("bob.position", 0), y=("bob.position", 1), vx=("bob.velocity", 0), vy=("bob.velocity", 1)
    )
    return error_of(data, found)


@formulations
def test_A01_simple_pendulum(run, check, formulation):
    data = problem("A01_simple_pendulum")
    y = run(rod_pendulum(formulation, 1e-13), data["t"][data["t"] <= 20])
    assert np.abs(y["total_energy"]).max() < 1e-10
    check(pendulum_error(y, data), 1e-10)


@formulations
def test_A01_simple_pendulum_for_2000_s(run, check, formulation):
    """After 844 periods the energy that rounding has taken is seen in the phase."""
    data = problem("A01_simple_pendulum")
    data["column"] = dict(zip(data["quantities"], np.array(data["values"] + data["later"]).T))
    y = run(rod_pendulum(formulation, 1e-13), data["column"]["t"])
    assert np.abs(y["total_energy"]).max() < 1e-8
    check(pendulum_error(y, data), 1e-7)


def four_bars(n, formulation, tolerance=1e-12):
    """n windows: n + 1 cranks and n couplers of 1 m and 1 kg, as in A02; the axial inertia of a bar plays no part."""
    z = [0, 0, 1]
    cranks = [
        {
            "name": f"V{k}",
            "mass": 1.0,
            "inertia": [1 / 12, 1e-3, 1 / 12, 0, 0, 0],
            "r0": [k, 0.5, 0],
            "v0": [0.5, 0, 0],
            "w0": [0, 0, -1],
        }
        for k in range(n + 1)
    ]
    couplers = [
        {
            "name": f"H{k}",
            "mass": 1.0,
            "inertia": [1e-3, 1 / 12, 1 / 12, 0, 0, 0],
            "r0": [k + 0.5, 1, 0],
            "v0": [1, 0, 0],
        }
        for k in range(n)
    ]
    joints = [
        {"type": "revolute", "body_i": "ground", "body_j": f"V{k}", "point": [k, 0, 0], "axis": z}
        for k in range(n + 1)
    ]

    for k in range(n):
        joints += [
            {
                "type": "revolute",
                "body_i": f"V{k + side}",
                "body_j": f"H{k}",
                "point": [k + side, 1, 0],
                "axis": z,
            }
            for side in (0, 1)
        ]

    data = {
        "id": "A02",
        "gravity": [0, -9.81, 0],
        "bodies": cranks + couplers,
        "joints": joints,
        "forces": [],
    }
    tip = {"tip": {"position": [0, 0.5, 0], "output": ["position", "velocity"]}}
    outputs = ["total_energy", "constraint_gap", "constraint_rate"]
    scene = scene_of(data, ["zyx"], solver=solver(formulation, tolerance), output=outputs)
    scene["body"]["V0"]["marker"] |= tip
    return scene


def four_bars_run(run, check, n, formulation, until, data=None):
    """Energy, parallel couplers and, where there is a reference, the tip's motion."""
    times = np.linspace(0, until, 40 * until + 1)
    y = run(four_bars(n, formulation), times)
    energy = y["total_energy"]
    drift = np.abs(energy / energy[0] - 1).max()
    assert drift < 1e-8
    tilt = max(np.abs(y[f"H{k}.zyx"]).max() for k in range(n))
    assert tilt < 1e-8
    assert y["constraint_gap"].max() < 1e-12
    assert y["constraint_rate"].max() < 1e-10

    if data is None:
        check(drift, 1e-8)
        return

    at = [np.abs(times - t).argmin() for t in data["t"] if t <= until]
    position, velocity = y["V0.tip.position"][at], y["V0.tip.velocity"][at]
    found = {"B0_x": position[:, 0], "B0_y": position[:, 1], "B0_vx": velocity[:, 0], "B0_vy": velocity[:, 1]}
    check(error_of(data, found), 1e-8)


@formulations
@pytest.mark.parametrize("n", [1, 2])
def test_A02_four_bars(run, check, n, formulation):
    four_bars_run(run, check, n, formulation, 10, problem(f"A02_n_four_bar_N{n}"))


@pytest.mark.parametrize(
    "n, formulation, until",
    [(8, "recursive", 10), (8, "embedding", 2), (8, "augmented", 10), (40, "recursive", 2)],
)
def test_A02_many_four_bars(run, check, n, formulation, until):
    four_bars_run(run, check, n, formulation, until)


@pytest.mark.long
@pytest.mark.parametrize("n, formulation", [(8, "embedding"), (40, "recursive"), (40, "augmented")])
def test_A02_many_four_bars_for_10_s(run, check, n, formulation):
    four_bars_run(run, check, n, formulation, 10)


# yaw and rate of Andrews' bodies from the angles of the reference
ANDREWS = {
    "K1_OF": ["beta"],
    "K2_FE": ["beta", "theta"],
    "K3_BDE": ["gamma"],
    "K4_EG": ["phi", "delta"],
    "K5_AG": ["delta"],
    "K6_HE": ["omega", "epsilon"],
    "K7_AH": ["epsilon"],
}


@formulations
@pytest.mark.parametrize("name", ["A03_andrews_iftomm", "ivp_andrews"])
def test_andrews_mechanism(run, check, name, formulation):
    data = problem(name)
    y = run(scene_of(data, ["zyx", "omega"], solver=solver(formulation, 1e-13)), data["t"])
    angle_error = rate_error = 0.0

    for body, parts in ANDREWS.items():
        angle = sum(data["column"][part] for part in parts)
        rate = sum(data["column"][f"{part}_dot"] for part in parts)
        angle_error = max(angle_error, np.abs(turned(y[f"{body}.zyx"][:, 0], angle) - angle).max())
        rate_error = max(rate_error, np.abs(y[f"{body}.omega"][:, 2] - rate).max() / np.abs(rate).max())

    assert rate_error < 1e-8
    check(angle_error, 1e-8)


def bricard(formulation, tolerance=1e-12):
    """The scene with the end of the third rod."""
    data = problem("A04_bricard_square")
    outputs = ["total_energy", "constraint_gap", "constraint_rate"]
    scene = scene_of(data, solver=solver(formulation, tolerance), output=outputs)
    scene["body"]["rod3"]["marker"]["j4"]["output"] = ["position", "velocity"]
    return data, scene


@formulations
def test_A04_bricard_mechanism(run, check, formulation):
    data, scene = bricard(formulation)
    y = run(scene, data["t"])
    drift = np.abs(y["total_energy"] - y["total_energy"][0]).max()
    assert drift < 1e-9
    assert y["constraint_gap"].max() < 1e-13
    r, v = y["rod3.j4.position"].T, y["rod3.j4.velocity"].T
    found = {f"P3_{c}": r[k] for k, c in enumerate("xyz")} | {f"P3_v{c}": v[k] for k, c in enumerate("xyz")}
    check(error_of(data, found), 1e-8)


@formulations
def test_A04_bricard_mechanism_for_100_s(run, check, formulation):
    _, scene = bricard(formulation, 1e-10)
    y = run(scene, np.linspace(0, 100, 1001))
    assert y["constraint_gap"].max() < 1e-12
    assert y["constraint_rate"].max() < 1e-11
    check(np.abs(y["total_energy"] - y["total_energy"][0]).max(), 1e-6)


@formulations
def test_A05_flyball_governor(run, check, formulation):
    """Stiff: explicit steps are shorter than 0.5 ms."""
    data = problem("A05_flyball_governor")
    scene = scene_of(data, solver=solver(formulation, 1e-11), output=["total_energy"])
    shaft, slider, rod, _ = scene["joint"]
    scene["joint"][shaft]["output"] = ["angle", "speed"]
    scene["joint"][rod]["output"] = ["angle", "speed"]
    scene["joint"][slider]["output"] = ["position", "speed"]
    y = run(scene, data["t"])
    found = {
        "beta": np.pi / 6 + y[f"'{rod}'.angle"],
        "s": 0.5 + y[f"'{slider}'.position"],
        "shaft_angle": y[f"'{shaft}'.angle"],
        "beta_dot": y[f"'{rod}'.speed"],
        "s_dot": y[f"'{slider}'.speed"],
        "shaft_rate": y[f"'{shaft}'.speed"],
    }
    check(error_of(data, found), 1e-8)
