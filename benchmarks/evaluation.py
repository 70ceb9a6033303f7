"""How long one evaluation of the accelerations takes, beside other libraries, in one run.

Serial chains and binary trees of revolute joints: kinematics, inertias, forces and the
articulated-body algorithm, one thread, in CPU time; and the same by our other formulations. All contestants
take turns, round by round, and each keeps its shortest time: a noisy machine then slows none more
than another. The loop around our kernels is compiled.
"""

import time
from collections.abc import Callable
from dataclasses import dataclass

import numpy as np
from rich.console import Group
from rich.table import Table

from mbdfmi.compiler.model import compile_scene
from mbdfmi.kernels import loops
from mbdfmi.run.instance import Instance

from .machine import machine, own_versions
from .mechanisms import chain_parents, links_of, scene_of, tree_parents
from .peers import MuJoCo, Pinocchio, PinocchioNative, peers_here

MECHANISMS = {"chain": chain_parents, "tree": tree_parents}
SIZES = (1, 2, 4, 8, 16, 32, 64, 128, 256, 512, 1024)
QUICK_SIZES = (1, 8, 32)
PEERS = (Pinocchio, PinocchioNative, MuJoCo)
QUICK_PEERS = (Pinocchio, MuJoCo)
FIT_FROM = 8
SAME_PHYSICS = 1e-6
OURS = "mbdfmi"
UP_TO_ABA = "mbdfmi up to ABA"


class Ours:
    """Our kernels, from the scene on."""

    formulation = "recursive"
    overhead = None
    largest = np.inf

    def __init__(self, links):
        model = compile_scene(scene_of(links, self.formulation))
        self.instance = Instance(model)
        inputs = {v.name: v.index for v in model.of_causality("input")}

        for i, link in enumerate(links):
            self.instance.u[inputs[f"joint{i}.torque"]] = link.torque

    def run(self, n):
        """Evaluate n times."""
        loops.evaluations(self.instance.m, self.instance.d, n)

    def run_up_to_aba(self, n):
        """Kinematics, inertias and forces n times."""
        loops.preparations(self.instance.m, self.instance.d, n)

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
class EvaluationCosts:
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

    def __rich__(self):
        tables = [self._table(name) for name in {row["mechanism"]: None for row in self.rows}]
        lines = [f"{name}: {how}" for name, how in self.contestants.items()]
        lines += [f"{name}: left out, {why}" for name, why in self.missing.items()]
        lines.append(f"largest relative difference of the accelerations: {self.largest_difference:.1e}")
        return Group(*tables, *lines)

    def _table(self, mechanism):
        table = Table(title=f"{mechanism}: µs for the accelerations")
        names = list(self.contestants)

        for heading in ("bodies", *names, "of ours ABA"):
            table.add_column(heading, justify="right")

        for row in self.rows:
            if row["mechanism"] == mechanism:
                times = [*(row["seconds"].get(name) for name in names), row["seconds_aba"]]
                table.add_row(str(row["bodies"]), *(f"{1e6 * time:.3g}" if time else "-" for time in times))

        exponents = self.exponents[mechanism]
        table.add_section()
        table.add_row("growth", *(f"n^{exponents[name]:.2f}" for name in names), "")
        return table


def evaluation_costs(
    quick: bool = False,
    progress: Callable[[float, str], None] | None = None,
) -> EvaluationCosts:
    """Measures our kernels and the peers that are installed.

    quick : few sizes and rounds, and no peer that takes minutes to compile: seconds in all.
    progress : called with the fraction done and what comes next.

    The report prints itself with rich. Raises RuntimeError when a peer's accelerations differ.
    """
    progress = progress or (lambda fraction, text: None)
    peers, versions, missing = peers_here(QUICK_PEERS if quick else PEERS, lambda text: progress(0.0, text))
    rounds, shortest = (3, 2e-4) if quick else (15, 1e-3)
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
    report = EvaluationCosts(
        machine=machine(),
        versions=own_versions() | versions,
        contestants={OURS: "a compiled loop"} | {peer.name: peer.how for peer in peers},
        missing=missing,
        rows=rows,
        exponents={mechanism: _exponents(rows, mechanism) for mechanism in MECHANISMS},
    )

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
        self.peers = {peer.name: peer(links) for peer in peers if n <= peer.largest}
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
    start = time.process_time()
    run(n)
    return time.process_time() - start


def _repeats(run, shortest):
    """How often to repeat for a timing of at least `shortest` s: then the call around does not count."""
    run(1)
    n = 1

    while _seconds(run, n) < shortest:
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
    exponents = {}

    for name in rows[0]["seconds"]:
        measured = [(row["bodies"], row["seconds"][name]) for row in rows if name in row["seconds"]]
        exponents[name] = float(np.polyfit(*np.log(measured).T, 1)[0])

    return exponents
