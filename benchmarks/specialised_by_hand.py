"""An evaluation of x' = f, traced for a scene, against equations derived by hand (by_hand.c).

    python -m benchmarks.specialised_by_hand

ns of an evaluation (CPU time, the least of some rounds, contestants in turn), both compiled so that bits are
kept, and both with -ffast-math -march=native; with parameters that stay tunable, and with all bound. What is
traced is compiled as a scene's own library is, what is by hand so and with scalars packed into vectors: the
faster counts.
"""

import ctypes
import subprocess
import sys
import tempfile
import time
from pathlib import Path

import numpy as np

import mbdfmi
from mbdfmi.export.core import PREAMBLE
from mbdfmi.export.specialise import SCALARS
from mbdfmi.run.instance import Instance
from mbdfmi.trace import searches
from mbdfmi.trace.binding import bound
from mbdfmi.trace.places import places
from mbdfmi.trace.program.functions import Program
from mbdfmi.trace.specialise import trace_rates

from .peers_by_hand import SYSTEMS, ByHandRun
from .problems import PROBLEMS

WAYS = {
    "bits kept": ("-O3", "-ffp-contract=off", "-fno-math-errno"),
    "fast": ("-O3", "-ffast-math", "-march=native"),
}
EVALUATIONS = 20_000
ROUNDS = 15

_MANY = """
static int32_t kernel(const Run *run)
{{
    (void)run;
    return 1;
}}

{text}

int many(double *reals, double *state, double *work, double *u, long times)
{{
    double once[1 + {once}] = {{0.0}};
    const Run run = {{reals, state, work, u, once}};
    int failed = {unused};

    for (; times > 0; times--) {{
        failed |= traced_rates(&run);
        for (int k = 0; k < {n}; k++) state[{x} + k] += 1e-12 * work[{rate} + k];
    }}
    return failed;
}}
"""


def compiled(text, flags, folder):
    """A library of some C."""
    source = Path(tempfile.mkstemp(".c", dir=folder)[1])
    source.write_text(text)
    library = source.with_suffix(".so")
    headers = [f"-I{Path(__file__).parent}", f"-I{folder}"]
    command = [sys.executable, "-m", "ziglang", "cc", "-std=c99", "-w", "-fPIC", "-shared", *flags, *headers]
    subprocess.run([*command, str(source), "-lm", "-o", str(library)], check=True)
    return ctypes.CDLL(str(library))


class Traced:
    """A scene's own evaluation. operations : how many it does."""

    def __init__(self, model, flags, folder):
        self.run = Instance(model)
        made = trace_rates(self.run)
        self.operations = made.operations
        x, rate = places(model, "x"), places(model, "x_rate")
        unused = "0" if made.guards else "0 * kernel(&run)"
        text = _MANY.format(
            text=made.text("kernel"),
            n=len(x),
            x=x.start,
            rate=rate.start,
            unused=unused,
            once=made.once[1],
        )
        program = Program()
        parts = [PREAMBLE, *program.text(searches.called(program, made.calls), text), text]
        self.many = compiled("\n\n".join(parts), flags, folder).many
        self.many.argtypes = [ctypes.c_void_p] * 4 + [ctypes.c_long]

    def __call__(self):
        m, d = self.run.m, self.run.d
        buffers = (m.reals_buffer, d.state_buffer, d.work_buffer, d.u_buffer)
        assert self.many(*(buffer.ctypes.data for buffer in buffers), EVALUATIONS) == 0, "a guard fails"


class Hand:
    """The same by hand."""

    def __init__(self, problem, flags, folder):
        source = Path(__file__).with_name("by_hand.c").read_text()
        self.many = compiled(source, flags, folder).by_hand_many
        self.many.argtypes = [ctypes.c_int, ctypes.c_int, ctypes.c_long, ctypes.c_void_p]
        self.system, self.n = SYSTEMS[problem.name]
        self.x = np.zeros(8)
        self.x[: self.n] = ByHandRun(problem, 1e-8)._start()

    def __call__(self):
        self.many(self.system, self.n, EVALUATIONS, self.x.ctypes.data)


def nanoseconds(contestants):
    """The least time of an evaluation of each, in turn."""
    least = dict.fromkeys(contestants, np.inf)

    for _ in range(ROUNDS):
        for name, run in contestants.items():
            began = time.process_time()
            run()
            least[name] = min(least[name], 1e9 * (time.process_time() - began) / EVALUATIONS)

    return least


def compare(problem, folder):
    """Rows of the table: (problem, way, ns by hand, ns with parameters tunable, ns with all bound, operations
    of these)."""
    model = mbdfmi.Scene(**problem.scene_tables({"integrator": "rk4", "step": 1e-3})).compile()

    for way, flags in WAYS.items():
        contestants = {
            "by hand": Hand(problem, (*flags, *SCALARS), folder),
            "by hand, packed": Hand(problem, flags, folder),
            "tunable": Traced(model, (*flags, *SCALARS), folder),
            "bound": Traced(bound(model, ["all"]), (*flags, *SCALARS), folder),
        }
        found = nanoseconds(contestants)
        traced = ("tunable", "bound")
        by_hand = min(time for name, time in found.items() if name not in traced)
        operations = [contestants[name].operations for name in traced]
        yield problem.name, way, by_hand, *(found[name] for name in traced), *operations


def main():
    """Prints the table."""
    from .native import _tableau

    print("| problem | compiled | by hand, ns | tunable, ns | times | bound, ns | times | operations |")
    print("|---|---|---|---|---|---|---|---|")

    with tempfile.TemporaryDirectory() as folder:
        (Path(folder) / "tableau.h").write_text(_tableau())

        for problem in PROBLEMS:
            if problem.name in SYSTEMS:
                for name, way, hand, free, fixed, many, few in compare(problem, folder):
                    print(
                        f"| {name} | {way} | {hand:.1f} | {free:.1f} | {free / hand:.2f} "
                        f"| {fixed:.1f} | {fixed / hand:.2f} | {many}, {few} |",
                        flush=True,
                    )


if __name__ == "__main__":
    main()
