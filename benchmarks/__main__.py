"""The benchmarks' command line: `python -m benchmarks`."""

import argparse
import sys
from pathlib import Path

from rich.progress import BarColumn, Progress, TextColumn, TimeRemainingColumn

from mbdfmi.cli import carry_out
from mbdfmi.cli.paths import writable
from mbdfmi.cli.terminal import err, out

from .long_run import PERIODS, QUICK_PERIODS, run_long
from .speed_against_error import run_report

DESCRIPTION = """Measure speed against error, beside other libraries.

Benchmark problems with reference digits: the error of the state against CPU time, of every
stepper and, where installed (pip install -e '.[bench]'), of Pinocchio, MuJoCo and Exudyn,
all in one run. Then what an evaluation of the accelerations costs by number of bodies, what
an FMU adds to a step, and how long an export takes. Everything takes about a quarter of an
hour of one core, --quick less than a minute once the kernels are compiled. --long-run looks at
something else: what 100,000 periods do to energy, momentum and phase (a quarter of an hour too).

It prints tables, and writes speed_against_error.md with its pictures and all raw figures (JSON)."""

EXAMPLES = """examples:
  python -m benchmarks --quick                       a first look, into the folder bench
  python -m benchmarks -o docs                       the whole report
  python -m benchmarks --problem heavy_top_bruls     one problem; a wrong name lists them all
  python -m benchmarks --long-run -o docs            100,000 periods (--quick: 100), into long_run.md"""


def main(arguments=None) -> int:
    """Run the command line; returns the exit status: 0 done, 1 failed with a message."""
    return carry_out(_parser(), arguments)


def _parser():
    parser = argparse.ArgumentParser(
        prog="python -m benchmarks",
        description=DESCRIPTION,
        epilog=EXAMPLES,
        formatter_class=argparse.RawDescriptionHelpFormatter,
    )
    parser.set_defaults(run=_run)
    parser.add_argument("--quick", action="store_true", help="few problems, settings, sizes and repeats")
    parser.add_argument(
        "--problem",
        action="append",
        default=[],
        metavar="NAME",
        help="run this problem only; may be repeated",
    )
    parser.add_argument(
        "--long-run", action="store_true", help="drift over 100,000 periods, instead of all else"
    )
    parser.add_argument(
        "-o", "--output", default="bench", metavar="DIR", help="folder of the report (default: %(default)s)"
    )
    return parser


def _run(options):
    if options.long_run and options.problem:
        raise ValueError(
            "--problem names problems of the report; --long-run has orbits of its own: leave out one of them"
        )

    # before a quarter of an hour of work
    writable(Path(options.output) / "report.md", [])
    columns = (TextColumn("{task.description}", justify="right"), BarColumn(), TimeRemainingColumn())

    with Progress(*columns, console=err, transient=True) as bar:
        task = bar.add_task("preparing", total=1.0)

        def tell(fraction, text):
            bar.update(task, completed=fraction, description=text)

        if options.long_run:
            report = run_long(QUICK_PERIODS if options.quick else PERIODS, tell)
        else:
            report = run_report(options.quick, options.problem, tell)

    out.print(report)

    for path in report.save(options.output):
        out.print(str(path), soft_wrap=True)


if __name__ == "__main__":
    sys.exit(main())
