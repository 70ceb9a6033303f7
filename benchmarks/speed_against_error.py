"""The report: error against CPU time, of our steppers and of peers, and what evaluations and FMUs cost."""

import json
import os
from collections.abc import Callable, Iterable
from dataclasses import dataclass, fields
from pathlib import Path

from rich.console import Group
from rich.table import Table

from mbdfmi.files import replacing
from mbdfmi.scene import SceneError
from mbdfmi.scene.schema import Solver

from .contests import AIMS, QUICK, Limits, contest, cpu_at
from .evaluation import EvaluationCosts, evaluation_costs
from .fmu_costs import export_costs, fmu_costs
from .machine import machine, own_versions
from .markdown import figures, markdown, milliseconds, power
from .peers import peers_here
from .peers_by_hand import ByHand
from .peers_exudyn import ExudynMotion
from .peers_mujoco import MuJoCoMotion
from .peers_pinocchio import PinocchioMotion
from .problems import PROBLEMS, Problem
from .steppers import STEPPERS

PEERS = (PinocchioMotion, MuJoCoMotion, ExudynMotion, ByHand)
QUICK_PEERS = (MuJoCoMotion, ExudynMotion, ByHand)
NAME = "speed_against_error"


@dataclass(frozen=True)
class SpeedReport:
    """What was measured.

    machine, versions, missing : by name.
    contestants : name -> `how` it was used, and its `kind` (see contests.KINDS).
    problems : of each: `name`, `title`, `source`, `how_obtained`, `digits`, `results`: contestant -> points
        (see contests.Point).
    at : error -> problem -> contestant -> CPU seconds, or None where it was not reached.
    evaluation : cost of the accelerations. fmu, export : see fmu_costs. None beside single problems.
    """

    machine: dict[str, str]
    versions: dict[str, str]
    missing: dict[str, str]
    contestants: dict[str, dict]
    problems: list[dict]
    at: dict[str, dict]
    evaluation: EvaluationCosts | None
    fmu: dict | None
    export: dict | None

    def as_dict(self) -> dict:
        """All figures, for JSON."""
        found = {field.name: getattr(self, field.name) for field in fields(self)}
        return found | {"evaluation": self.evaluation and self.evaluation.as_dict()}

    def save(self, folder: str | os.PathLike) -> list[Path]:
        """Writes the figures (JSON), the report (Markdown) and, where matplotlib is, its pictures (PNG) into
        a folder.

        Returns the paths.
        """
        texts = {f"{NAME}.json": json.dumps(self.as_dict()) + "\n"}
        pictures = self._pictures()
        texts[f"{NAME}.md"] = markdown(self, list(pictures))
        written = []

        for name, text in texts.items():
            with replacing(Path(folder) / name) as path:
                path.write_text(text, encoding="utf-8")

            written.append(Path(folder) / name)

        for name, figure in pictures.items():
            with replacing(Path(folder) / name) as path:
                figure.savefig(path, format="png", dpi=95)

            written.append(Path(folder) / name)

        return written

    def _pictures(self):
        try:
            from .plots import error_figure, evaluation_figure

            found = {f"{NAME}.png": error_figure(self)}
            return found | (
                {"evaluation_cost.png": evaluation_figure(self.evaluation)} if self.evaluation else {}
            )
        except ImportError:
            return {}

    def standing(self, aim: float, problem: str) -> dict:
        """Who needs how much CPU time for an error: the best (name, s) of `ours`, of the packaged peers
        (`package`), of all peers (`peer`) and of what was written for that mechanism alone (`limit`), or
        None; the ratios `package_ratio`, `peer_ratio` and `limit_ratio` of these to ours, or None; and `all`.
        """
        times = {name: s for name, s in self.at[f"{aim:g}"][problem].items() if s}
        groups = {
            "ours": ("ours",),
            "package": ("package",),
            "peer": ("package", "loop"),
            "limit": ("limit",),
        }
        found = {"all": times}

        for group, kinds in groups.items():
            members = [(name, s) for name, s in times.items() if self.contestants[name]["kind"] in kinds]
            found[group] = min(members, key=lambda pair: pair[1], default=None)

        for group in ("package", "peer", "limit"):
            both = found["ours"] and found[group]
            found[f"{group}_ratio"] = found[group][1] / found["ours"][1] if both else None

        return found

    def __rich__(self):
        tables = [self._aim_table(aim) for aim in AIMS]
        lines = [f"{name}: left out, {why}" for name, why in self.missing.items()]
        lines.append(", ".join(f"{name} {text}" for name, text in self.versions.items()))
        lines.append(", ".join(self.machine.values()))
        beside = [self.evaluation, self._fmu_table()] if self.evaluation else []
        return Group(*beside, *tables, *lines)

    def _aim_table(self, aim):
        peers = [name for name, contestant in self.contestants.items() if contestant["kind"] != "ours"]
        title = f"CPU time (ms) for an error of {power(aim)}; ratios to ours: package, all, limit"
        table = Table(title=title)
        table.add_column("problem")

        for heading in ("ours", *peers, "package", "all", "limit"):
            table.add_column(heading, justify="right")

        for problem in self.problems:
            standing = self.standing(aim, problem["name"])
            ours = standing["ours"]
            ratios = [standing[f"{group}_ratio"] for group in ("package", "peer", "limit")]
            table.add_row(
                problem["title"],
                f"{figures(1e3 * ours[1])} ({ours[0]})" if ours else "-",
                *(milliseconds(problem, name, standing["all"].get(name)) for name in peers),
                *(figures(ratio, 2) if ratio else "-" for ratio in ratios),
            )

        return table

    def _fmu_table(self):
        table = Table(title="µs of CPU for a communication step of 1 ms")
        table.add_column("scene")

        for heading in ("in process", "fmi2DoStep", "added", "through fmpy", "FMU, KB"):
            table.add_column(heading, justify="right")

        for name, row in self.fmu.items():
            times = (1e6 * row[key] for key in ("in_process", "fmu", "added", "fmpy"))
            table.add_row(name, *(f"{time:.2f}" for time in times), f"{row['size'] / 1024:.0f}")

        return table


def run_report(
    quick: bool = False,
    names: Iterable[str] = (),
    progress: Callable[[float, str], None] | None = None,
) -> SpeedReport:
    """Measures our steppers and the peers that are installed, in one run.

    quick : few problems, settings and sizes, and no peer that takes minutes to compile.
    names : of problems, instead of all (or of the quick ones), and of nothing beside them.
    progress : called with the fraction done and what comes next.

    The report prints itself with rich. Raises ValueError for an unknown problem.
    """
    progress = progress or (lambda fraction, text: None)
    names = list(names)
    problems = chosen_problems(names, quick)
    evaluation = None if names else evaluation_costs(quick, lambda k, text: progress(0.25 * k, text))
    steppers, missing = known_steppers()
    peers, versions, without = peers_here(QUICK_PEERS if quick else PEERS, lambda text: progress(0.25, text))
    contestants = [*steppers, *(peer() for peer in peers)]
    rows = []

    for k, problem in enumerate(problems):
        fraction = 0.25 + 0.65 * k / len(problems)

        def tell(text, fraction=fraction):
            progress(fraction, text)

        results = contest(problem, contestants, QUICK if quick else Limits(), tell)
        rows.append(
            {
                "name": problem.name,
                "title": problem.title,
                "source": problem.data["source"],
                "how_obtained": problem.data["how_obtained"],
                "digits": problem.data["digits"],
                "results": results,
            }
        )

    report = SpeedReport(
        machine=machine(),
        versions=own_versions() | versions,
        missing=missing | without,
        contestants={it.name: {"how": it.how, "kind": it.kind} for it in contestants},
        problems=rows,
        at={f"{aim:g}": {row["name"]: _times_at(row, aim) for row in rows} for aim in AIMS},
        evaluation=evaluation,
        fmu=None if names else fmu_costs(quick, lambda text: progress(0.9, text)),
        export=None if names else export_costs(quick, lambda text: progress(0.95, text)),
    )

    progress(1.0, "done")
    return report


def chosen_problems(names: Iterable[str], quick: bool) -> list[Problem]:
    """Problems of these names; all, or all quick ones, for none. Raises ValueError."""
    by_name = {problem.name: problem for problem in PROBLEMS}

    for name in names:
        if name not in by_name:
            raise ValueError(f"no problem {name}; there are {', '.join(by_name)}")

    if names:
        return [by_name[name] for name in names]

    return [problem for problem in PROBLEMS if problem.quick or not quick]


def known_steppers() -> tuple[list, dict[str, str]]:
    """Those of STEPPERS that a scene can name, and of the others why not."""
    known, missing = [], {}

    for stepper in STEPPERS:
        try:
            Solver.model_validate({"integrator": stepper.name} | ({"step": 0.01} if stepper.fixed else {}))
            known.append(stepper)
        except (SceneError, ValueError):
            missing[stepper.name] = "this version has no such integrator"

    return known, missing


def _times_at(row, aim):
    return {name: cpu_at(points, aim) for name, points in row["results"].items()}
