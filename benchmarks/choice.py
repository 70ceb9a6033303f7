"""`auto` against the best of the steppers that it chooses from, at equal error: 40 scenes, stiff and not.

    python -m benchmarks.choice [SCENE ...]

Each scene is run by rk54, rk853 and radau at some tolerances; what either costs at the error of `auto` is
interpolated on a logarithmic scale. The error is that of all states at the end, beside their size, against
the same run at a far smaller tolerance. Costs are CPU times of the steps alone, for `auto` the least of two.
"""

import itertools
import sys
import time

import numpy as np

from mbdfmi.compiler.model import compile_scene
from mbdfmi.run.instance import Instance
from mbdfmi.scene import SceneData

TOLERANCE = 1e-6
TOLERANCES = (1e-4, 1e-6, 1e-8)
REFERENCE = 1e-9
STEPPERS = ("rk54", "rk853", "radau")


def net(rows, columns, stiffness, damping):
    """Free bodies of 0.1 kg hung from the ground, each tied to its neighbours by damped springs."""
    element = {"spring_damper": {"stiffness": stiffness, "damping": damping, "rest_length": 0.095}}
    body, joint, force, ground = {}, {}, {}, {}

    for i, j in itertools.product(range(rows), range(columns)):
        name = f"b{i}_{j}"
        body[name] = {"mass": 0.1, "inertia": [1e-4] * 3}
        start = {"position": [0.1 * j, 0, -0.1 * (i + 1)]}
        joint[f"f{i}_{j}"] = {"free": {}, "between": ["ground", name], "start": start}

        if i == 0:
            ground[f"a{j}"] = {"position": [0.1 * j, 0, 0]}

        force[f"up{i}_{j}"] = element | {"between": [f"b{i - 1}_{j}" if i else f"ground.a{j}", name]}

        if j:
            force[f"side{i}_{j}"] = element | {"between": [f"b{i}_{j - 1}", name]}

    scene = {"gravity": [0, 1, -9.81], "body": body, "joint": joint, "force": force}
    return scene | {"ground": {"marker": ground}}


def chain(n, damper, closed=False, driven=False):
    """Bars of 1 m on hinges; `closed`: the last pinned to the ground; `driven`: an input on the first."""
    bar = {
        "mass": 1.0,
        "com": [0.5, 0, 0],
        "inertia": [0.001, 1 / 12, 1 / 12],
        "marker": {"e": {"position": [1, 0, 0]}},
    }
    body = {f"b{k}": bar for k in range(n)}
    joint = {
        f"j{k}": {"revolute": {}, "between": [f"b{k - 1}.e" if k else "ground", f"b{k}"], "damper": damper}
        for k in range(n)
    }
    scene = {"gravity": [0, -9.81, 0], "body": body, "joint": joint}

    if closed:
        scene["ground"] = {"marker": {"far": {"position": [0.8 * n, 0, 0]}}}
        joint["pin"] = {"revolute": {}, "between": [f"b{n - 1}.e", "ground.far"]}

    if driven:
        joint["j0"]["input"] = "torque"

    return scene


def scenes():
    """Name -> (scene, s of the run, s of a communication step, whether the input jumps at each)."""
    found = {}

    for (rows, columns), (stiffness, damping) in itertools.product(
        ((2, 2), (4, 4), (8, 5)), ((2e3, 0.5), (2e4, 5.0), (2e4, 50.0), (2e5, 50.0), (2e5, 5e3))
    ):
        found[f"net {rows} x {columns}, {stiffness:g} N/m, {damping:g} N s/m"] = (
            net(rows, columns, stiffness, damping), 0.4, 0.02, False
        )  # fmt: skip

    found["net 46 x 5, 20000 N/m, 500 N s/m"] = (net(46, 5, 2e4, 500.0), 0.05, 0.01, False)

    for n, damper in itertools.product((2, 8, 32), (0.0, 1.0, 100.0, 1e4)):
        found[f"chain of {n}, {damper:g} N m s"] = (chain(n, damper), 2.0, 0.02, False)

    found["chain of 100, 1 N m s"] = (chain(100, 1.0), 0.5, 0.02, False)
    found["chain of 100, 1000 N m s"] = (chain(100, 1e3), 0.5, 0.02, False)

    for n, damper in itertools.product((3, 8), (0.0, 1.0, 1e3)):
        found[f"closed chain of {n}, {damper:g} N m s"] = (chain(n, damper, closed=True), 2.0, 0.02, False)

    for n, damper in itertools.product((2, 16), (0.1, 1e3)):
        found[f"chain of {n}, {damper:g} N m s, jumping torque"] = (
            chain(n, damper, driven=True),
            2.0,
            0.02,
            True,
        )

    return found


def run(scene, until, H, jumps, integrator, tolerance):
    """(states at the end, s of CPU)."""
    data = {
        "name": "x",
        "solver": {"integrator": integrator, "tolerance": tolerance, "absolute_tolerance": tolerance},
    }
    instance = Instance(compile_scene(SceneData.model_validate(scene | data)))
    start = time.process_time()

    for k in range(round(until / H)):
        if jumps:
            instance.u[0] = 10.0 * np.sin(3.0 * k * H)

        instance.step(H)

    return instance.d.x[: instance.m.n_x].copy(), time.process_time() - start


def cost_at(error, points):
    """Cost (s) at an error between (error, cost) points, beyond them that of the last one that is as good."""
    points = sorted(points)
    errors = np.log([max(e, 1e-16) for e, _ in points])
    costs = np.log([c for _, c in points])
    return float(np.exp(np.interp(np.log(max(error, 1e-16)), errors, costs)))


def row(scene, until, H, jumps):
    """(states, error of auto, its cost (s), cost of each stepper at that error, inf where far more)."""
    exact, _ = run(scene, until, H, jumps, "radau" if len(scene["body"]) < 20 else "auto", REFERENCE)

    def measured(integrator, tolerance):
        x, cost = run(scene, until, H, jumps, integrator, tolerance)
        return np.abs(x - exact).max() / (1.0 + np.abs(exact).max()), cost

    error, cost = measured("auto", TOLERANCE)
    cost = min(cost, measured("auto", TOLERANCE)[1])
    costs = {}

    for name in STEPPERS:
        first = measured(name, TOLERANCE)
        costs[name] = np.inf

        if first[1] < 4.0 * cost:
            others = [measured(name, tolerance) for tolerance in TOLERANCES if tolerance != TOLERANCE]
            costs[name] = cost_at(error, [first, *others])

    return len(exact), error, cost, costs


def main(chosen):
    """The table, in Markdown."""
    print(
        "| | states | error | auto, ms | "
        + " | ".join(STEPPERS)
        + " | by the best |\n|---|---|---|---|---|---|---|---|"
    )
    ratios = []

    for name, scene in scenes().items():
        if chosen and not any(word in name for word in chosen):
            continue

        states, error, cost, costs = row(*scene)
        ratios.append(cost / min(costs.values()))
        numbers = " | ".join(f"{1e3 * costs[s]:.1f}" for s in STEPPERS)
        print(
            f"| {name} | {states} | {error:.0e} | {1e3 * cost:.1f} | {numbers} | {ratios[-1]:.2f} |",
            flush=True,
        )

    print(f"\n{len(ratios)} scenes: median {np.median(ratios):.2f}, worst {max(ratios):.2f}")


if __name__ == "__main__":
    main(sys.argv[1:])
