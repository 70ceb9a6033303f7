"""Libraries of one scene against the library of all: time of whole runs, size, what it takes to make one.

    python -m benchmarks.specialised [WORD ...]

For each scene of models/ with WORD in its name (by default all) and the steppers rk4 (1 ms) and auto (1e-8):
CPU times of the same communication steps, the least of some rounds, contestants in turn; kB of the library
in an FMU; seconds (wall) of making it; how many evaluations were left to the generic kernel; whether all
states are the same to the bit.
"""

import io
import sys
import time
import zipfile
from pathlib import Path

import mbdfmi
from mbdfmi.export.specialise import own, scene_library
from mbdfmi.run.instance import Entries, Instance

MODELS = Path(__file__).parents[1] / "models"
SOLVERS = {"rk4": {"integrator": "rk4", "step": 1e-3}, "auto": {"integrator": "auto", "tolerance": 1e-8}}
STEP = 0.01  # s, of communication
STEPS = 100
ROUNDS = 7


def kilobytes(path):
    """Of a file in an archive."""
    archive = io.BytesIO()

    with zipfile.ZipFile(archive, "w", zipfile.ZIP_DEFLATED) as file:
        file.write(path)

    return len(archive.getvalue()) / 1024


def follow(run):
    """CPU time (s) of some communication steps."""
    start = time.process_time()

    for _ in range(STEPS):
        run.step(STEP)

    return time.process_time() - start


def compare(model):
    """(seconds of the generic library, of the scene's own, kB, seconds to make it, part left to the generic
    kernel, whether bits are the same).
    """
    found = own(model)
    start = time.perf_counter()
    library = scene_library(model, found=found)
    made = time.perf_counter() - start
    runs = [Instance(model), Instance(model, kernels=Entries.of(library))]
    least = [min(times) for times in zip(*([follow(run) for run in runs] for _ in range(ROUNDS)))]
    same = runs[0].d.state_buffer.tobytes() == runs[1].d.state_buffer.tobytes()
    generic = runs[1].d.generic_evaluations[0] / runs[1].d.evaluations[0] if found.traced else 1.0
    return *least, kilobytes(library), made, generic, same


def main(words):
    """Prints the table."""
    print(
        "| scene | stepper | generic, ms | own, ms | times | kB | made in, s | left to the generic | bits |"
    )
    print("|---|---|---|---|---|---|---|---|---|")

    for path in sorted(MODELS.glob("*.toml")):
        if words and not any(word in path.stem for word in words):
            continue

        for name, solver in SOLVERS.items():
            scene = mbdfmi.load(path)
            scene.solver = solver
            one, other, size, made, generic, same = compare(scene.compile())
            print(
                f"| {path.stem} | {name} | {1e3 * one:.2f} | {1e3 * other:.2f} | {one / other:.2f} "
                f"| {size:.0f} | {made:.1f} | {generic:.1%} | {'the same' if same else 'OTHERS'} |",
                flush=True,
            )


if __name__ == "__main__":
    main(sys.argv[1:])
