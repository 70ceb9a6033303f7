"""`auto` against the best of the steppers that it chooses from, at equal error: 46 scenes, stiff and not.

    python -m benchmarks.choice [WORD ...]

Each scene is run for as long as costs `auto` 50 ms at least, and by rk54, rk853 and radau over the same time
at some tolerances; what either costs at the error of `auto` is interpolated on a logarithmic scale. The error
is that of all states at some times, the largest, beside their size, against the same run at a far smaller
tolerance. Costs are evaluations of the accelerations, with those that linear systems are worth, which the
steppers count: the same on every machine, however busy. WORD: only scenes with one of these in their names.
"""

import itertools
import sys
import time

import numpy as np

from mbdfmi.compiler.model import compile_scene
from mbdfmi.run.instance import Instance, SimulationError
from mbdfmi.scene import SceneData

TOLERANCE = 1e-6
TOLERANCES = (1e-5, 1e-6, 1e-7)
REFERENCE = 1e-9
STEPPERS = ("rk54", "rk853", "radau")

# s, what a run costs at least
LEAST = 0.05

# how many times the work of `auto` is far more
FAR = 3.0

# an error of `auto` that says that the motion magnifies errors too much to compare them: runs are shortened
MAGNIFIED = 1e-2

# times at which states are compared
N_COMPARED = 20


def net(rows, columns, stiffness, damping, driven=False):
    """Free bodies of 0.1 kg hung from the ground, each tied to its neighbours by damped springs.

    driven : hung from a frame that is moved to and fro.
    """
    element = {"spring_damper": {"stiffness": stiffness, "damping": damping, "rest_length": 0.095}}
    body, joint, force, anchors = {}, {}, {}, {}

    for i, j in itertools.product(range(rows), range(columns)):
        name = f"b{i}_{j}"
        body[name] = {"mass": 0.1, "inertia": [1e-4] * 3}
        start = {"position": [0.1 * j, 0, -0.1 * (i + 1)]}
        joint[f"f{i}_{j}"] = {"free": {}, "between": ["ground", name], "start": start}

        if i == 0:
            anchors[f"a{j}"] = {"position": [0.1 * j, 0, 0]}

        above = f"b{i - 1}_{j}" if i else f"{'frame' if driven else 'ground'}.a{j}"
        force[f"up{i}_{j}"] = element | {"between": [above, name]}

        if j:
            force[f"side{i}_{j}"] = element | {"between": [f"b{i}_{j - 1}", name]}

    scene = {"gravity": [0, 1, -9.81], "body": body, "joint": joint, "force": force}

    if driven:
        body["frame"] = {"mass": 1.0, "inertia": [0.1] * 3, "marker": anchors}
        joint["frame"] = _to_and_fro("frame", 0.02, 1.0)
        return scene

    return scene | {"ground": {"marker": anchors}}


def _to_and_fro(body, amplitude, frequency):
    """A joint that moves a body along x (m, 1/s)."""
    motion = {"harmonic": {"amplitude": amplitude, "frequency": frequency}}
    return {"prismatic": {"axis": "x"}, "between": ["ground", body], "driver": motion}


def chain(n, damper, closed=False, driven=None):
    """Bars of 1 m on hinges, as a scene.

    closed : the last pinned to the ground. driven : "torque", an input on the first, or "base", its hinge
    moved to and fro, bars hanging.
    """
    bar = {
        "mass": 1.0,
        "com": [0.5, 0, 0],
        "inertia": [0.001, 1 / 12, 1 / 12],
        "marker": {"e": {"position": [1, 0, 0]}},
    }
    base = "cart" if driven == "base" else "ground"
    body = {f"b{k}": bar for k in range(n)}
    joint = {
        f"j{k}": {"revolute": {}, "between": [f"b{k - 1}.e" if k else base, f"b{k}"], "damper": damper}
        for k in range(n)
    }
    scene = {"gravity": [0, -9.81, 0], "body": body, "joint": joint}

    if closed:
        scene["ground"] = {"marker": {"far": {"position": [0.8 * n, 0, 0]}}}
        joint["pin"] = {"revolute": {}, "between": [f"b{n - 1}.e", "ground.far"]}

    if driven == "torque":
        joint["j0"]["input"] = "torque"

    if driven == "base":
        body["cart"] = {"mass": 1.0, "inertia": [0.1] * 3}
        joint["cart"] = _to_and_fro("cart", 0.2, 0.5)

    if not closed and driven != "torque":
        joint["j0"]["start"] = {"angle_deg": -70}

    return scene


def scenes():
    """Name -> (scene, s of a communication step, amplitude (N m) of an input that jumps at each or 0)."""
    found = {}

    for (rows, columns), (stiffness, damping) in itertools.product(
        ((2, 2), (4, 4), (8, 5)), ((2e3, 0.5), (2e4, 5.0), (2e4, 50.0), (2e5, 50.0), (2e5, 5e3))
    ):
        found[f"net {rows} x {columns}, {stiffness:g} N/m, {damping:g} N s/m"] = (
            net(rows, columns, stiffness, damping, driven=True), 0.02, 0.0
        )  # fmt: skip

    found["net 46 x 5, 20000 N/m, 500 N s/m"] = net(46, 5, 2e4, 500.0, driven=True), 0.01, 0.0

    for n, damper in itertools.product((2, 8, 32), (0.0, 1.0, 100.0, 1e4)):
        found[f"chain of {n}, {damper:g} N m s"] = (
            chain(n, damper, driven="base" if damper else None),
            0.02,
            0.0,
        )

    for n, damper in itertools.product((100, 250), (1.0, 1e3)):
        found[f"chain of {n}, {damper:g} N m s"] = chain(n, damper, driven="base"), 0.02, 0.0

    for n, damper in itertools.product((3, 8), (0.0, 1.0, 1e3)):
        found[f"closed chain of {n}, {damper:g} N m s"] = chain(n, damper, closed=True), 0.02, 0.0

    for n, damper in itertools.product((2, 16), (0.1, 1e3)):
        for H in (0.02, 0.002):
            name = f"chain of {n}, {damper:g} N m s, torque that jumps each {1e3 * H:g} ms"
            found[name] = chain(n, damper, driven="torque"), H, 10.0

    return found


def run(scene, until, H, torque, integrator, tolerance, most=np.inf):
    """(states at N_COMPARED times, s of CPU, work in evaluations).

    most : work that is far too much. Raises SimulationError where a single step takes more.
    """
    solver = {"integrator": integrator, "tolerance": tolerance, "absolute_tolerance": tolerance}
    data = {"name": "x", "solver": solver | ({"max_evaluations": most} if most < np.inf else {})}
    instance = Instance(compile_scene(SceneData.model_validate(scene | data)))
    n = round(until / H)
    compared = {round(n * (k + 1) / N_COMPARED) for k in range(N_COMPARED)}
    states = []
    start = time.process_time()

    for k in range(n):
        if torque:
            instance.u[0] = torque * np.sin(3.0 * k * H)

        instance.step(H)

        if instance.d.evaluations[0] > most:
            raise SimulationError("far more", instance.time)

        if k + 1 in compared:
            states.append(instance.d.x[: instance.m.n_x].copy())

    seconds = time.process_time() - start
    d = instance.d
    return np.array(states), seconds, d.evaluations[0] + d.linear_work[0]


def long_enough(scene, H, torque):
    """(s of a run of `auto` that costs LEAST or more, s of CPU)."""
    until = N_COMPARED * H

    while (cost := run(scene, until, H, torque, "auto", TOLERANCE)[1]) < LEAST:
        until = H * np.ceil(until / H * min(10.0, max(1.2, 1.2 * LEAST / cost)))

    return until, cost


def cost_at(error, points):
    """Cost at an error between (error, cost) points, beyond them that of the last one that is as good."""
    points = sorted(points)
    errors = np.log([max(e, 1e-16) for e, _ in points])
    costs = np.log([c for _, c in points])
    return float(np.exp(np.interp(np.log(max(error, 1e-16)), errors, costs)))


def row(scene, H, torque):
    """(states, s of the run, s of CPU and error of auto, its cost, that of each stepper at that error).

    inf : far more.
    """
    until, seconds = long_enough(scene, H, torque)

    def reference():
        return run(scene, until, H, torque, "radau" if len(scene["body"]) < 20 else "auto", REFERENCE)[0]

    def measured(integrator, tolerance, most=np.inf):
        states, _, work = run(scene, until, H, torque, integrator, tolerance, most)
        return np.abs(states - exact).max() / (1.0 + np.abs(exact).max()), work

    exact = reference()
    error, cost = measured("auto", TOLERANCE)

    while error > MAGNIFIED:
        until, seconds = H * np.ceil(until / H / 2), seconds / 2
        exact = reference()
        error, cost = measured("auto", TOLERANCE)

    costs = {}

    for name in STEPPERS:
        try:
            first = measured(name, TOLERANCE, FAR * cost)
        except SimulationError:
            costs[name] = np.inf
        else:
            others = [measured(name, tolerance) for tolerance in TOLERANCES if tolerance != TOLERANCE]
            costs[name] = cost_at(error, [first, *others])

    return exact.shape[1], until, seconds, error, cost, costs


def main(chosen):
    """The table, in Markdown."""
    print(
        "| | states | run, s | CPU, ms | error | auto | "
        + " | ".join(STEPPERS)
        + " | by the best |\n|---|---|---|---|---|---|---|---|---|---|"
    )
    ratios = []

    for name, scene in scenes().items():
        if chosen and not any(word in name for word in chosen):
            continue

        states, until, seconds, error, cost, costs = row(*scene)
        ratios.append(cost / min(costs.values()))
        numbers = " | ".join(f"{costs[s]:.0f}" for s in STEPPERS)
        found = f"{states} | {until:.3g} | {1e3 * seconds:.0f} | {error:.0e} | {cost:.0f} | {numbers}"
        print(f"| {name} | {found} | {ratios[-1]:.2f} |", flush=True)

    print(f"\n{len(ratios)} scenes: median {np.median(ratios):.2f}, worst {max(ratios):.2f}")


if __name__ == "__main__":
    main(sys.argv[1:])
