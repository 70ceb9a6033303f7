"""Libraries of one scene against the library of all: time of whole runs, size, what it takes to make one.

    python -m benchmarks.specialised [--quick] [--steppers NAME ...] [--] [WORD ...]

For each scene of models/ with WORD in its name (by default all but what is coupled) and each stepper: CPU
times of the same communication steps, the least of some rounds, contestants in turn; kB of the library in an
FMU; seconds (wall) of making it; what part of evaluations and projections, and how many Jacobians, were left
to the generic kernels; whether all states are the same to the bit, or how far they are apart. --quick: fewer
rounds.
"""

import argparse
import contextlib
import ctypes
import io
import statistics
import tempfile
import time
import zipfile
from pathlib import Path

import numpy as np

import mbdfmi
from mbdfmi.export.specialise import own, scene_library
from mbdfmi.native.library import addresses
from mbdfmi.run.instance import Entries, Instance, SimulationError, explain
from mbdfmi.steppers import FIXED_STEP, STEPPERS

from .specialised_by_hand import compiled

MODELS = Path(__file__).parents[1] / "models"
STEP = 0.01  # s, of communication
STEPS = 100
MOST = 0.3  # s, of the rounds of one contestant
ROUNDS = 15
HEAD = (
    "scene",
    "stepper",
    "generic, ms",
    "own, ms",
    "times",
    "kB",
    "made in, s",
    "left to the generic",
    "states",
)


def scenes(words):
    """Files of scenes of models/, in folders too, with one of the words in their names."""
    found = [*MODELS.glob("*.toml"), *MODELS.glob("*/*.toml")]
    alone = sorted(path for path in found if path.parent.name != "coupled")
    return [path for path in alone if not words or any(word in path.stem for word in words)]


def kilobytes(path):
    """Of a file in an archive."""
    archive = io.BytesIO()

    with zipfile.ZipFile(archive, "w", zipfile.ZIP_DEFLATED) as file:
        file.write(path)

    return len(archive.getvalue()) / 1024


MASTER = """#include <stdint.h>

typedef int32_t Step(int64_t *, void **, void *, void *, void *, void *, void *, void *, double);

int64_t steps(Step *step, void **buffers, double H, int n)
{
    int64_t status = 0;
    void *unused = 0, **b = buffers;

    for (int k = 0; k < n && status == 0; k++) step(&status, &unused, b[0], b[1], b[2], b[3], b[4], b[5], H);
    return status;
}
"""


class Contestant:
    """A run by one library. path : of it, None: that of all scenes.

    A call from Python takes longer than a small scene's step, so it is called from C, as by a master.
    """

    def __init__(self, model, master, path=None):
        self.run = Instance(model, kernels=Entries.of(path)) if path else Instance(model)
        self.place = addresses(path)["mbdfmi_step"]
        addressed = [*self.run.m.model_addresses, *self.run.d.data_addresses]
        self.buffers = (ctypes.c_void_p * len(addressed))(*addressed)
        self.steps = master.steps
        self.steps.argtypes = [ctypes.c_void_p, ctypes.c_void_p, ctypes.c_double, ctypes.c_int]
        self.steps.restype = ctypes.c_int64

    def follow(self):
        """CPU time (s) of some communication steps. Raises SimulationError."""
        start = time.process_time()
        status = self.steps(self.place, self.buffers, STEP, STEPS)
        took = time.process_time() - start

        if status:
            raise SimulationError(explain(self.run.model, status), self.run.time)

        self.run.d.notices[0] = 0.0
        return took


def rounds(runs, most):
    """Least CPU times (s) of some rounds, in turn."""
    times = [[run.follow() for run in runs]]

    while len(times) < most and sum(map(sum, times)) < MOST * len(runs):
        times.append([run.follow() for run in runs])

    return [min(each) for each in zip(*times)]


def left(run, traced):
    """The part of evaluations, of projections and of Jacobians that was left to the generic kernels."""
    d = run.d
    evaluations = d.generic_evaluations[0] / max(1.0, d.evaluations[0]) if traced else 1.0
    steps = max(1.0, d.steps[0] + d.rejected[0])
    return f"{evaluations:.1%}, {d.generic_calls[0] / steps:.1%}, {d.generic_calls[1]:.0f}"


def apart(first, second):
    """Whether states are the same to the bit, or how far they are apart beside their size."""
    if first.d.x.tobytes() == second.d.x.tobytes():
        return "the same"

    size = np.abs(first.d.x).max()
    return f"{np.abs(first.d.x - second.d.x).max() / size:.0e}"


def compare(model, most, master):
    """A row of the table behind scene and stepper, and how many times faster the scene's own library is."""
    found = own(model)
    start = time.perf_counter()
    library = scene_library(model, found=found)
    made = time.perf_counter() - start
    contestants = [Contestant(model, master), Contestant(model, master, library)]
    one, other = rounds(contestants, most)
    runs = [contestant.run for contestant in contestants]
    row = [f"{1e3 * one:.2f}", f"{1e3 * other:.2f}", f"{one / other:.2f}", f"{kilobytes(library):.0f}"]
    return [*row, f"{made:.1f}", left(runs[1], found.traced), apart(*runs)], one / other


def main():
    """Prints the table, and medians."""
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawTextHelpFormatter)
    parser.add_argument("words", nargs="*")
    parser.add_argument("--quick", action="store_true")
    parser.add_argument("--steppers", nargs="+", choices=tuple(STEPPERS), default=tuple(STEPPERS))
    options = parser.parse_args()
    names = options.steppers
    gains = {name: [] for name in names}
    master = compiled(MASTER, ("-O2",), tempfile.mkdtemp())
    print(f"| {' | '.join(HEAD)} |")
    print("|---" * len(HEAD) + "|")

    for path in scenes(options.words):
        for name in names:
            scene = mbdfmi.load(path)
            scene.solver = {"integrator": name} | (
                {"step": 1e-3} if name in FIXED_STEP else {"tolerance": 1e-8}
            )
            row = None

            with contextlib.suppress(SimulationError):
                row, gain = compare(scene.compile(), 3 if options.quick else ROUNDS, master)
                gains[name].append(gain)

            told = " | ".join(row) if row else "no run by this stepper" + " | " * (len(HEAD) - 3)
            print(f"| {path.stem} | {name} | {told} |", flush=True)

    for name, found in gains.items():
        if found:
            print(f"\n{name}: median {statistics.median(found):.2f}, least {min(found):.2f}", flush=True)


if __name__ == "__main__":
    main()
