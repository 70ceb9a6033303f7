"""How long one evaluation of the accelerations takes, beside other libraries, in one run.

Serial chains and binary trees of revolute joints: kinematics, inertias, forces and the
articulated-body algorithm, one thread; and the same by our other formulations. All contestants take turns, round by round, and each keeps
its shortest time: a noisy machine then slows none more than another. The loop around our kernels is
compiled.
"""

import json
import os
import platform
import time
from collections.abc import Callable
from dataclasses import dataclass
from datetime import UTC, datetime
from importlib.metadata import PackageNotFoundError, version
from pathlib import Path

import numpy as np
from rich.console import Group
from rich.table import Table

from ..files import replacing
from ..kernels import forces, rates, tree
from ..kernels.language import kernel, source_hash
from ..model import compile_scene
from ..simulate import Instance
from .mechanisms import chain_parents, links_of, scene_of, tree_parents
from .peers import Missing, MuJoCo, Pinocchio, PinocchioNative

MECHANISMS = {"chain": chain_parents, "tree": tree_parents}
SIZES = (1, 2, 4, 8, 16, 32, 64, 128, 256)
QUICK_SIZES = (1, 8, 32)
PEERS = (Pinocchio, PinocchioNative, MuJoCo)
QUICK_PEERS = (Pinocchio, MuJoCo)
FIT_FROM = 8
SAME_PHYSICS = 1e-6
OURS = "mbdfmi"
UP_TO_ABA = "mbdfmi up to ABA"


@kernel
def evaluate_times(m, d, n):
    """x' n times; a different x each time, so that nothing can be taken out of the loop."""
    for _ in range(n):
        d.x[0] += 1e-15
        rates.evaluate(m, d, 0.0)


@kernel
def evaluate_up_to_aba_times(m, d, n):
    """All that `evaluate` does before its last part, n times."""
    for _ in range(n):
        d.x[0] += 1e-15
        rates.set_time(m, d, 0.0)
        tree.kinematics(m, d)
        tree.inertias(m, d)
        forces.apply(m, d)


class Ours:
    """Our kernels, from the scene on."""

    formulation = "recursive"
    overhead = None

    def __init__(self, links):
        model = compile_scene(scene_of(links, self.formulation))
        self.instance = Instance(model)
        inputs = {v.name: v.index for v in model.of_causality("input")}

        for i, link in enumerate(links):
            self.instance.u[inputs[f"joint{i}.torque"]] = link.torque

    def run(self, n):
        """Evaluate n times."""
        evaluate_times(self.instance.m, self.instance.d, n)

    def run_up_to_aba(self, n):
        """Kinematics, inertias and forces n times."""
        evaluate_up_to_aba_times(self.instance.m, self.instance.d, n)

    def accelerations(self):
        """rad/s2 by link."""
        return self.instance.outputs().copy()


class Embedding(Ours):
    """Our kernels by the joint-space mass matrix."""

    formulation = "embedding"
    name = "embedding"
    how = "mbdfmi, joint-space mass matrix by composite bodies and its Cholesky factor"


class Augmented(Ours):
    """Our kernels in absolute coordinates."""

    formulation = "augmented"
    name = "augmented"
    how = "mbdfmi, absolute coordinates with every joint as constraint, factored in its envelope"


@dataclass(frozen=True)
class BenchReport:
    """What was measured.

    machine, versions : by name.
    contestants : name -> how it was measured.
    missing : name -> why it was not.
    rows : one for each mechanism and number of bodies: `mechanism`, `bodies`, `seconds` of an
        evaluation by contestant, `seconds_aba` of ours in the articulated-body passes,
        `seconds_call_overhead` taken off, `difference` of a peer's accelerations from ours,
        relative to the largest.
    exponents : mechanism -> contestant -> exponent of the growth of time with 8 bodies and more.
    """

    machine: dict[str, str]
    versions: dict[str, str]
    contestants: dict[str, str]
    missing: dict[str, str]
    rows: list[dict]
    exponents: dict[str, dict[str, float]]

    @property
    def largest_difference(self) -> float:
        """Of the accelerations between any other and our recursive formulation, relative."""
        return max(x for row in self.rows for x in row["difference"].values())

    def as_dict(self) -> dict:
        """All figures, for JSON."""
        return {
            "machine": self.machine,
            "versions": self.versions,
            "contestants": self.contestants,
            "missing": self.missing,
            "rows": self.rows,
            "exponents": self.exponents,
            "largest_difference": self.largest_difference,
        }

    def save(self, folder: Path) -> list[Path]:
        """Writes bench.json and, where matplotlib is, bench.png into a folder; returns the paths."""
        written = [Path(folder) / "bench.json"]

        with replacing(written[0]) as path:
            path.write_text(json.dumps(self.as_dict(), indent=2) + "\n", encoding="utf-8")

        try:
            figure = self._figure()
        except ImportError:
            return written

        written.append(Path(folder) / "bench.png")

        with replacing(written[1]) as path:
            figure.savefig(path, format="png", dpi=150)

        return written

    def _figure(self):
        from matplotlib.figure import Figure

        mechanisms = {row["mechanism"]: None for row in self.rows}
        figure = Figure(figsize=(5.5 * len(mechanisms), 4.5), layout="constrained")
        axes = figure.subplots(1, len(mechanisms), sharey=True, squeeze=False)[0]

        for ax, mechanism in zip(axes, mechanisms):
            rows = [row for row in self.rows if row["mechanism"] == mechanism]
            bodies = [row["bodies"] for row in rows]

            for name in self.contestants:
                times = [1e6 * row["seconds"][name] for row in rows]
                ax.loglog(bodies, times, "o-", label=name, markersize=4)

            ax.set(title=f"{mechanism} of revolute joints", xlabel="bodies")
            ax.set_xticks(bodies, bodies, minor=False)
            ax.minorticks_off()
            ax.grid(alpha=0.3)

        axes[0].set_ylabel("µs for the accelerations")
        axes[0].legend()
        return figure

    def __rich__(self):
        tables = [self._table(name) for name in {row["mechanism"]: None for row in self.rows}]
        lines = [f"{name}: {how}" for name, how in self.contestants.items()]
        lines += [f"{name}: left out, {why}" for name, why in self.missing.items()]
        lines.append(", ".join(f"{name} {text}" for name, text in self.versions.items()))
        lines.append(", ".join(self.machine.values()))

        lines.append(f"largest relative difference of the accelerations: {self.largest_difference:.1e}")
        return Group(*tables, *lines)

    def _table(self, mechanism):
        table = Table(title=f"{mechanism}: µs for the accelerations (ratio: peer's time to ours)")
        peers = [name for name in self.contestants if name != OURS]

        for heading in ("bodies", OURS, "of it ABA", "ns/body"):
            table.add_column(heading, justify="right")

        for name in peers:
            table.add_column(name, justify="right")
            table.add_column("ratio", justify="right")

        for row in self.rows:
            if row["mechanism"] == mechanism:
                table.add_row(*_cells(row, peers))

        exponents = self.exponents.get(mechanism)

        if exponents:
            table.add_section()
            cells = (text for name in peers for text in (f"n^{exponents[name]:.2f}", ""))
            table.add_row("growth", f"n^{exponents[OURS]:.2f}", "", "", *cells)

        return table


def _cells(row, peers):
    ours = row["seconds"][OURS]
    aba = row["seconds_aba"]
    cells = [str(row["bodies"]), f"{1e6 * ours:.3f}", f"{1e6 * aba:.3f}"]
    cells.append(f"{1e9 * ours / row['bodies']:.0f}")

    for name in peers:
        peer = row["seconds"][name]
        cells += [f"{1e6 * peer:.3f}", f"{peer / ours:.2f}"]

    return cells


def run_bench(
    quick: bool = False,
    out: Path | None = None,
    progress: Callable[[float, str], None] | None = None,
) -> BenchReport:
    """Measures our kernels and the peers that are installed.

    quick : few sizes and rounds, and no peer that takes minutes to compile: seconds in all.
    out : folder for bench.json and bench.png, or None.
    progress : called with the fraction done and what comes next.

    The report prints itself with rich. Raises RuntimeError when a peer's accelerations differ.
    """
    progress = progress or (lambda fraction, text: None)
    peers, versions, missing = _peers_here(QUICK_PEERS if quick else PEERS, progress)
    rounds, shortest = (3, 2e-4) if quick else (25, 2e-3)
    peers = [Embedding, Augmented, *peers]
    contests = []

    for mechanism in MECHANISMS:
        for n in QUICK_SIZES if quick else SIZES:
            progress(0.1, f"{mechanism} of {n}")
            contests.append(_Contest(mechanism, n, peers, shortest))

    for k in range(rounds):
        progress(0.2 + 0.8 * k / rounds, f"round {k + 1} of {rounds}")

        for contest in contests:
            contest.round()

    rows = [contest.row() for contest in contests]
    report = BenchReport(
        machine=_machine(),
        versions=_versions() | versions,
        contestants={OURS: "a compiled loop"} | {peer.name: peer.how for peer in peers},
        missing=missing,
        rows=rows,
        exponents={mechanism: _exponents(rows, mechanism) for mechanism in MECHANISMS},
    )

    if out:
        report.save(out)

    progress(1.0, "done")
    return report


class _Contest:
    """All contestants on one mechanism.

    shortest : s that one timing takes at least, by repetition.
    """

    def __init__(self, mechanism, n, peers, shortest):
        links = links_of(MECHANISMS[mechanism](n))
        ours = Ours(links)
        self.mechanism = mechanism
        self.n = n
        self.peers = {peer.name: peer(links) for peer in peers}
        self.difference = _differences(ours, self.peers)
        self.runs = {OURS: ours.run, UP_TO_ABA: ours.run_up_to_aba}

        for name, peer in self.peers.items():
            self.runs[name] = peer.run

            if peer.overhead:
                self.runs[f"{name} overhead"] = peer.overhead

        self.repeats = {name: _repeats(run, shortest) for name, run in self.runs.items()}
        self.best = dict.fromkeys(self.runs, np.inf)

    def round(self):
        """Each contestant once more."""
        for name, run in self.runs.items():
            n = self.repeats[name]
            self.best[name] = min(self.best[name], _seconds(run, n) / n)

    def row(self):
        """The figures."""
        contestants = (OURS, *self.peers)
        overhead = {name: self.best.get(f"{name} overhead", 0.0) for name in contestants}
        return {
            "mechanism": self.mechanism,
            "bodies": self.n,
            "seconds": {name: self.best[name] - overhead[name] for name in contestants},
            "seconds_aba": self.best[OURS] - self.best[UP_TO_ABA],
            "seconds_call_overhead": {name: s for name, s in overhead.items() if s},
            "difference": self.difference,
        }


def _seconds(run, n):
    start = time.perf_counter()
    run(n)
    return time.perf_counter() - start


def _repeats(run, shortest):
    """How often to repeat for a timing of at least `shortest` s: then the call around does not count.

    The least of some timings decides, for one interruption would end the search too early.
    """
    run(1)
    n = 1

    while min(_seconds(run, n) for _ in range(5)) < shortest:
        n *= 2

    return n


def _differences(ours, peers):
    """Largest difference of each peer's accelerations from ours, relative to the largest of ours."""
    expected = ours.accelerations()
    size = np.max(np.abs(expected))
    differences = {}

    for name, peer in peers.items():
        difference = float(np.max(np.abs(peer.accelerations() - expected)) / size)

        if not difference < SAME_PHYSICS:
            found = f"accelerations differ by {difference:.1e}"
            raise RuntimeError(f"{name}: {found}, so it is not the same physics")

        differences[name] = difference

    return differences


def _exponents(rows, mechanism):
    """Slope of log time over log bodies by contestant."""
    rows = [row for row in rows if row["mechanism"] == mechanism and row["bodies"] >= FIT_FROM]
    x = np.log([row["bodies"] for row in rows])
    return {
        name: float(np.polyfit(x, np.log([row["seconds"][name] for row in rows]), 1)[0])
        for name in rows[0]["seconds"]
    }


def _peers_here(candidates, progress):
    """Peers that can run here, their versions, and why the others cannot."""
    peers, versions, missing = [], {}, {}

    for peer in candidates:
        progress(0.0, peer.preparing)

        try:
            versions[peer.name] = peer.version()
            peers.append(peer)
        except Missing as why:
            missing[peer.name] = str(why)

    return peers, versions, missing


def _versions():
    found = {}

    for package in ("mbdfmi", "numba", "llvmlite", "numpy"):
        try:
            found[package] = version(package)
        except PackageNotFoundError:
            found[package] = "not installed"

    return found | {"python": platform.python_version(), "kernels": source_hash()}


def _machine():
    return {
        "processor": _processor(),
        "cores": f"{os.cpu_count()} cores",
        "system": platform.platform(),
        "date": datetime.now(UTC).isoformat(timespec="seconds"),
    }


def _processor():
    """The processor's name."""
    try:
        lines = Path("/proc/cpuinfo").read_text().splitlines()
        return next(line.split(": ")[1] for line in lines if line.startswith("model name"))
    except (OSError, StopIteration, IndexError):
        return platform.processor() or platform.machine()
