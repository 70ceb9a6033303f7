"""`python -m tests.mutants`: breaks lines drawn by a seed and lists those that no test notices."""

import argparse
import json
import sys
from collections import Counter
from concurrent.futures import ThreadPoolExecutor, as_completed
from contextlib import ExitStack
from pathlib import Path
from queue import SimpleQueue

from rich.console import Console
from rich.markup import escape
from rich.table import Table

from . import reach
from .draw import draw, name_of
from .equivalent import argument
from .hunt import BY_TIME, CAUGHT, Copy, Verdict, hunt, judge_undone
from .undone import UNDONE

EQUAL = "equivalent"


def main():
    parser = argparse.ArgumentParser(prog="python -m tests.mutants", description=__doc__)
    parser.add_argument("--seed", type=int, default=1)
    parser.add_argument("--kernels", type=int, default=40, metavar="N", help="mutants of mbdfmi/kernels")
    parser.add_argument("--compiler", type=int, default=10, metavar="N")
    parser.add_argument("--scene", type=int, default=10, metavar="N")
    parser.add_argument("--only", metavar="TEXT", help="those that have this in their names")
    parser.add_argument("--list", action="store_true", help="list the mutants, run nothing")
    parser.add_argument(
        "--resume", type=Path, metavar="FILE", help="keep what came of each mutant there, and go on from it"
    )
    parser.add_argument("--again", action="store_true", help="with --resume: try the survivors again")
    parser.add_argument("--jobs", type=int, default=1)
    parser.add_argument("--undone", choices=("referee", "tests"), nargs="?", const="referee",
                        help="undo mendings of the package instead, and run the referee "
                             "(or the tests of each)")  # fmt: skip
    options = parser.parse_args()
    console = Console(soft_wrap=True)

    if options.undone:
        return undo(console, options)

    mutants = draw(options.seed, {part: getattr(options, part) for part in reach.PARTS})
    mutants = [mutant for mutant in mutants if options.only is None or options.only in name_of(mutant)]

    if options.list:
        for mutant in mutants:
            show(console, mutant)
        return 0

    by_line, times = lines(console, options.jobs)

    def judge(mutant, copy):
        return Verdict(EQUAL) if argument(mutant) else hunt(mutant, copy, by_line, times)

    verdicts = judged(console, options, {name_of(mutant): mutant for mutant in mutants}, judge)
    return report(console, mutants, verdicts, times)


def lines(console, jobs):
    """`reach.tests_by_line`, its progress shown."""
    with console.status("") as status:
        return reach.tests_by_line(jobs, lambda name: status.update(f"lines that {name} reaches: known"))


def undo(console, options):
    """Each mending undone by itself; 1 where nothing notices one."""
    by_line, times = lines(console, options.jobs) if options.undone == "tests" else ({}, {})
    chosen = {f"{u.rule}. {u.name}": u for u in UNDONE if options.only is None or options.only in u.name}

    def judge(undone, copy):
        return judge_undone(undone, copy, options.undone == "referee", by_line, times)

    verdicts = judged(console, options, chosen, judge)
    left = [name for name, verdict in verdicts.items() if verdict.outcome not in (CAUGHT, BY_TIME)]
    console.print(f"{len(verdicts) - len(left)} of {len(verdicts)} mendings are noticed when they are undone")
    return int(bool(left))


def judged(console, options, chosen, judge):
    """{name: what came of it} of those chosen, {name: x}; `judge(x, copy)` on `--jobs` copies side by side.

    What the file of `--resume` knows is taken from there, and what comes is kept in it.
    """
    verdicts = known(options.resume, options.again)
    copies = SimpleQueue()

    def judge_one(name):
        copy = copies.get()

        try:
            return judge(chosen[name], copy)
        finally:
            copies.put(copy)

    with ThreadPoolExecutor(options.jobs) as pool, ExitStack() as stack:
        for _ in range(options.jobs):
            copies.put(stack.enter_context(Copy()))

        waiting = {pool.submit(judge_one, name): name for name in chosen if name not in verdicts}

        for done in as_completed(waiting):
            name, verdict = waiting[done], done.result()
            verdicts[name] = verdict
            keep(options.resume, verdicts)
            console.print(f"{name}: {verdict.outcome} {escape(verdict.by)} [dim]{verdict.seconds:.0f} s")

    return {name: verdicts[name] for name in chosen}


def known(file, again):
    """Verdicts by name that a file holds."""
    if file is None or not file.exists():
        return {}

    found = {name: Verdict(**verdict) for name, verdict in json.loads(file.read_text()).items()}
    return {name: v for name, v in found.items() if not again or v.outcome in (CAUGHT, BY_TIME)}


def keep(file, verdicts):
    """Write all verdicts to a file."""
    if file is not None:
        file.write_text(json.dumps({name: vars(verdict) for name, verdict in verdicts.items()}, indent=1))


def show(console, mutant):
    """A mutant in three lines."""
    console.print(
        f"[bold]{name_of(mutant)}[/] mbdfmi/{mutant.file}:{mutant.line} {mutant.kind}", highlight=False
    )
    console.print(f"    - {mutant.before}\n    + {mutant.after}", markup=False, highlight=False)


def report(console, mutants, verdicts, times):
    """Survivors, figures, and whether the tests that caught mutants pass without them;
    1 where less than 95 % are caught."""
    left = [mutant for mutant in mutants if verdicts[name_of(mutant)].outcome not in (CAUGHT, BY_TIME, EQUAL)]
    console.rule("survivors")

    for mutant in left:
        show(console, mutant)
        console.print(f"    {verdicts[name_of(mutant)].outcome}")

    table = Table("part", "drawn", CAUGHT, BY_TIME, EQUAL, "survived")

    for part in reach.PARTS:
        outcomes = Counter(verdicts[name_of(m)].outcome for m in mutants if m.file.startswith(part))
        other = outcomes.total() - outcomes[CAUGHT] - outcomes[BY_TIME] - outcomes[EQUAL]
        figures = outcomes.total(), outcomes[CAUGHT], outcomes[BY_TIME], outcomes[EQUAL], other
        table.add_row(part, *map(str, figures))

    console.print(table)
    killers = {verdicts[name_of(mutant)].by for mutant in mutants}

    with Copy() as copy:
        if wrong := copy.fails_unbroken(killers, times):
            console.print(
                f"[red]{escape(wrong.by)}, on the package as it is: {wrong.outcome}. "
                "What it caught does not count"
            )
            return 1

    counted = [mutant for mutant in mutants if verdicts[name_of(mutant)].outcome != EQUAL]
    console.print(f"{len(counted) - len(left)} of {len(counted)} caught")
    return int(len(left) > 0.05 * len(counted))


if __name__ == "__main__":
    sys.exit(main())
