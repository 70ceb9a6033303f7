"""How even single communication steps are: histograms of what each takes.

    python -m benchmarks.single_steps [INTEGRATOR ...]

Bricard's mechanism and a chain of 32 bars, 2,000 communication steps of 1 ms. A run is the same each time, so
of each step the least of five runs counts, which leaves out what else the machine does. A call from Python
counts, some 2 us.
"""

import sys
import time

import numpy as np

from mbdfmi.compiler.model import compile_scene
from mbdfmi.kernels import entry
from mbdfmi.kernels.status import OK
from mbdfmi.run.instance import Instance
from mbdfmi.scene import SceneData

from . import choice
from .problems import PROBLEMS

INTEGRATORS = ("auto", "rk54", "rk853", "radau", "rk4", "ros2", "gauss")
FIXED = ("rk4", "ros2", "gauss")

# s
H = 1e-3
N_STEP = 2000
N_RUN = 5

# upper ends of the histogram's bins, in medians
BINS = (1.5, 2, 4, 8, 16, 32, 64, np.inf)


def scenes():
    """Name -> tables of a scene but its solver."""
    (bricard,) = (problem for problem in PROBLEMS if problem.name == "A04_bricard_square")
    return {
        "Bricard's mechanism": bricard.scene_tables({}),
        "chain of 32": {"name": "chain"} | choice.chain(32, 0.0),
    }


def measure(scene, integrator):
    """(s (N_STEP,), evaluations (N_STEP,)) of each communication step."""
    solver = {"integrator": integrator} | ({"step": H} if integrator in FIXED else {"tolerance": 1e-6})
    model = compile_scene(SceneData.model_validate(scene | {"solver": solver}))
    least = np.full(N_STEP, np.inf)

    for _ in range(N_RUN):
        instance = Instance(model)
        seconds, evaluations = np.empty(N_STEP), np.empty(N_STEP)
        m, d = instance.m, instance.d

        for k in range(N_STEP):
            before = d.evaluations[0]
            start = time.perf_counter()
            status = entry.step(m, d, H)
            seconds[k] = time.perf_counter() - start
            evaluations[k] = d.evaluations[0] - before
            assert status == OK

        least = np.minimum(least, seconds)

    return least, evaluations


def main(chosen):
    """The tables, in Markdown."""
    for name, scene in scenes().items():
        bins = " | ".join(f"to {b:g}" if b < np.inf else "more" for b in BINS)
        print(f"\n{name}\n")
        print(f"| | median, us | first | longest later | evaluations: first, most later | {bins} |")
        print("|---" * (5 + len(BINS)) + "|")

        for integrator in chosen or INTEGRATORS:
            seconds, evaluations = measure(scene, integrator)
            median = np.median(seconds)
            parts = seconds / median
            counts = np.histogram(parts, (0, *BINS))[0]
            told = f"{1e6 * median:.1f} | {parts[0]:.0f} | {parts[1:].max():.1f}"
            told += f" | {evaluations[0]:.0f}, {evaluations[1:].max():.0f}"
            print(f"| {integrator} | {told} | {' | '.join(map(str, counts))} |", flush=True)


if __name__ == "__main__":
    main(sys.argv[1:])
