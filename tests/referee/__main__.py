"""Random scenes before the referee: `python -m tests.referee --seed 1 --scenes 100`."""

import argparse
import json
import shlex
import sys
from collections import Counter
from functools import partial
from multiprocessing import get_context
from pathlib import Path

from rich.console import Console
from rich.progress import (
    BarColumn,
    MofNCompleteColumn,
    Progress,
    TextColumn,
    TimeRemainingColumn,
)

from . import coverage
from .generator import FOCUS
from .interpreter import Interpreter
from .work import one

HELP = """Draws random scenes over the whole schema, runs each in several ways (formulations, steppers,
tolerances, communication steps, in process and as FMU, compiled and interpreted, from snapshots, after a
reset), and compares them with each other, with an independent route and with the laws of mechanics. Ends with
1 when something is found.

examples:
  python -m tests.referee --seed 1 --scenes 20          scenes of the seeds 1 to 20
  python -m tests.referee --seed 7 --scenes 1           one scene again
  python -m tests.referee --scenes 200 --focus turns    small scenes rich in one feature
  python -m tests.referee --scene odd.toml --seed 7     a scene file, under what seed 7 does to it
  python -m tests.referee --scenes 2000 --jobs 2 --resume referee.jsonl
                                                        goes on where it was stopped
"""

console = Console(soft_wrap=True)


def main(arguments=None):
    """Exit status: 0 nothing found, 1 findings, 2 wrong arguments."""
    options = _parser().parse_args(arguments)
    seeds = range(options.seed, options.seed + (1 if options.scene else options.scenes))
    lines = _done(options.resume, options)
    waiting = [seed for seed in seeds if seed not in lines]
    columns = (TextColumn("{task.description}"), BarColumn(), MofNCompleteColumn(), TimeRemainingColumn())

    with Progress(*columns, console=console, transient=True) as progress:
        task = progress.add_task("scenes", total=len(seeds), completed=len(seeds) - len(waiting))

        for line in _judged(waiting, options):
            lines[line["seed"]] = line
            _keep(options.resume, line)
            _tell(line, options)
            progress.advance(task)

    return _end([lines[seed] for seed in seeds if seed in lines])


def _parser():
    parser = argparse.ArgumentParser(
        prog="python -m tests.referee", description=HELP, formatter_class=argparse.RawDescriptionHelpFormatter
    )
    parser.add_argument("--seed", type=int, default=1, help="of the first scene (1)")
    parser.add_argument("--scenes", type=int, default=20, help="how many, each of the next seed (20)")
    parser.add_argument("--size", type=int, help="number of bodies; by default drawn, 1 to 30")
    parser.add_argument("--focus", choices=sorted(FOCUS), help="small scenes rich in one feature")
    parser.add_argument("--scene", type=Path, help="a scene file in place of drawn ones")
    parser.add_argument("--ways", type=int, default=3, help="ways compared within tolerances (3)")
    parser.add_argument("--no-fmu", action="store_true", help="nothing as FMU")
    parser.add_argument("--no-interpreted", action="store_true", help="nothing with kernels as plain Python")
    parser.add_argument("--no-shrink", action="store_true", help="leave failing scenes as they are")
    parser.add_argument("--jobs", type=int, default=1, help="processes (1)")
    parser.add_argument(
        "--out", type=Path, default=Path("referee"), help="folder for failing scenes, made smaller (referee)"
    )
    parser.add_argument(
        "--resume",
        type=Path,
        help="file of lines of JSON, one for each scene that was judged; those there are not done again",
    )
    return parser


def _judged(seeds, options):
    """Lines of verdicts as they come."""
    if options.jobs == 1:
        with Interpreter() as interpreter:
            yield from (one(seed, options, interpreter) for seed in seeds)
        return

    # not concurrent.futures: before Python 3.12 its workers may not come back after max_tasks_per_child
    with get_context("spawn").Pool(options.jobs, maxtasksperchild=100) as pool:
        yield from pool.imap_unordered(partial(one, options=options), seeds)


def _tell(line, options):
    if not line["findings"]:
        return

    again = ["python", "-m", "tests.referee", "--seed", str(line["seed"]), "--scenes", "1"]

    for name in ("size", "focus", "scene"):
        value = getattr(options, name)
        again += [f"--{name}", str(value)] if value is not None else []

    console.print(
        f"[bold]seed {line['seed']}[/]: {shlex.join(again)}\n  smaller: {line.get('file')}", highlight=False
    )

    for finding in line["findings"]:
        console.print(f"  {finding}", markup=False, highlight=False)


def _done(path, options):
    """Lines of a file to go on with, by seed."""
    if path is None or not path.exists():
        return {}

    lines = [json.loads(text) for text in path.read_text(encoding="utf-8").splitlines() if text.strip()]
    return {line["seed"]: line for line in lines if line["focus"] == options.focus}


def _keep(path, line):
    if path:
        with path.open("a", encoding="utf-8") as file:
            file.write(json.dumps(line) + "\n")


def _end(lines):
    """Coverage, figures; the exit status."""
    counts = Counter(key for line in lines for key in line["keys"])
    console.print(coverage.table(counts), markup=False, highlight=False)
    other = Counter()

    for line in lines:
        other.update(line["other"])

    found = [line for line in lines if line["findings"]]
    seconds = sum(line["seconds"] for line in lines)
    made, loose = sum(line["made"] for line in lines), sum(line["loose"] for line in lines)
    refused = sum(line["refused"] is not None for line in lines)
    console.print(
        f"{len(lines)} scenes in {seconds:.0f} s, {refused} refused; {made} comparisons, {loose} of them "
        "of motions too wild to compare; "
        + "; ".join(f"{name}: {n}" for name, n in sorted(other.items()) if n)
    )
    console.print(
        f"{len(found)} scenes with findings"
        + (": seeds " + ", ".join(str(line["seed"]) for line in found) if found else "")
    )
    return 1 if found else 0


if __name__ == "__main__":
    sys.exit(main())
