"""mbdfmi bench: which stepper is best for a scene."""

from contextlib import contextmanager

from ..arguments import add_command, add_scene, add_settings
from ..paths import load_scene, result_files
from ..settings import settings_of
from ..show_results import beside, write
from ..tables import table_of
from ..terminal import err

DOUBTFUL = 1e-6
"""Doubt of the reference run from which on it is told."""

WORTH_IT = 0.7
"""Part of the CPU time of the scene's own solver below which another is recommended."""


def add(commands):
    """The command and its arguments."""
    command = add_command(
        commands,
        run,
        "bench",
        "find the best stepper for a scene",
        """Your scene is run with every stepper: those that choose their step with tolerances from
1e-4 to 1e-11, those of fixed step with 1, 1/4, 1/16 ... 1/1024 of the communication step. The
error of a run is the largest difference of any output at any communication point from a reference
run of the tightest tolerance, by the largest value of that output; the reference is checked by a
second one. So ask in the scene for the outputs that matter to you, and choose --until so that the
motion is typical.

CPU time is that of this machine, of steps and outputs alone. A run with ">" is not beaten by any
other in both error and time: choose among those. Then write into the scene what suits you:

  [solver]
  integrator = "rk853"
  tolerance  = 1e-7

A fixed step does the same work in every communication step, as real time asks for. For what
100 and more periods do to energy, look at the outputs total_energy and at a long --until.""",
        """examples:
  mbdfmi bench crane.toml --until 10                      the table, and the best choices in words
  mbdfmi bench crane.toml --until 10 --plot bench.png     error against CPU time, as a picture
  mbdfmi bench crane.toml --until 10 --step 0.01          as of a master that calls every 10 ms
  mbdfmi bench crane.toml --until 10 --stepper rk54 --stepper radau --csv bench.csv""",
    )
    add_scene(command)
    command.add_argument("--until", type=float, required=True, metavar="T", help="end of the runs, s")
    command.add_argument(
        "--step",
        type=float,
        metavar="H",
        help="communication step, s (default: T/500); choose that of your master",
    )
    command.add_argument(
        "--stepper", action="append", metavar="NAME", help="try this one (default: all); may be repeated"
    )
    command.add_argument(
        "--longest",
        type=float,
        default=10.0,
        metavar="S",
        help="CPU time, s, that one run may take (default: %(default)g); what would take longer is left out",
    )
    command.add_argument("--csv", metavar="FILE", help="write all runs as a table; - is the standard output")
    command.add_argument("--plot", metavar="FILE", help="write a picture: png, svg or pdf")
    add_settings(command)


def run(options):
    """Runs them all, and shows what came of it."""
    from ...analysis.comparison import compare_steppers

    csv, plot = result_files(options, options.scene)
    scene = load_scene(options.scene, options)
    inputs, parameters = settings_of(scene.compile(), options.set)
    chosen = {"steppers": options.stepper} if options.stepper else {}

    with _bar() as progress:
        found = compare_steppers(
            scene,
            options.until,
            options.step,
            inputs,
            parameters,
            longest=options.longest,
            progress=progress,
            **chosen,
        )

    # what is told stands beside a table on the standard output
    _print(found, beside(csv))
    write([(csv, found.to_csv), (plot, found.plot)])


@contextmanager
def _bar():
    """A bar over the settings; yields a function to call with the part done and what comes next."""
    from rich.progress import BarColumn, Progress, TextColumn, TimeRemainingColumn

    columns = (TextColumn("{task.description}", justify="right"), BarColumn(), TimeRemainingColumn())

    with Progress(*columns, console=err.console, transient=True) as bar:
        task = bar.add_task("preparing", total=1.0)
        yield lambda part, text: bar.update(task, completed=part, description=text)


def _print(found, say):
    """The table, what it says, and why some runs are missing."""
    say.print(f"{found.title}: {found.until:g} s, communication step {found.step:g} s", style="bold")
    count = len(found.compared)
    say.print(
        f"{count} outputs compared with {found.reference}, which is good to about {_short(found.doubt)}\n"
    )
    say.print(_table(found))
    say.print()

    for line in (*_choices(found), *_own(found), *_missing(found)):
        say.print(line, soft_wrap=True)


def _table(found):
    """A row for each run with figures, by CPU time."""
    numbers = ("error", "CPU, ms", "evaluations", "steps")
    table = table_of("", "stepper", "tolerance", *numbers, "worst output", numbers=numbers)

    for run in found.done:
        mark = ">" if run in found.front else ""
        table.add_row(
            mark + "*" if run is found.own else mark,
            run.setting.integrator,
            run.setting.short,
            _error(run, found),
            f"{1e3 * run.cpu:.3g}",
            f"{run.evaluations:,}",
            f"{run.steps:,}",
            run.worst,
        )

    return table


def _short(number):
    """The size of an error."""
    from ...analysis.comparison import short

    return short(number, 1)


def _error(run, found):
    """The error of a run, or that it is too small to be told."""
    return f"{run.error:.1e}" if run.error > found.doubt else f"< {_short(found.doubt)}"


def _told(run, found):
    """A run in words."""
    return f"{run.setting} ({1e3 * run.cpu:.3g} ms, error {_error(run, found)})"


def _choices(found):
    """The best choices, in words."""
    from ...analysis.comparison import TARGETS
    from ...steppers import FIXED_STEP

    if not found.done:
        yield "no run succeeded"
        return

    if found.doubt > DOUBTFUL:
        yield (
            f"the reference itself is uncertain by {_short(found.doubt)}: the motion magnifies small errors, "
            "or jumps; a shorter --until tells more"
        )

    for error in TARGETS:
        best, fixed = found.best(error), found.best(error, FIXED_STEP)

        if not best:
            nearest = min(found.done, key=lambda run: run.error)
            yield f"for an error of {_short(error)}: none; the nearest is {_told(nearest, found)}"
            return

        others = f"; of fixed step: {_told(fixed, found)}" if fixed and fixed is not best else ""
        yield f"for an error of {_short(error)}: {_told(best, found)}{others}"


def _own(found):
    """How the scene's own solver compares with the best."""
    own = found.own

    if own.reason:
        yield f"the scene's own solver (*), {own.setting}: {own.reason}"
        return

    best = found.best(max(own.error, found.doubt))
    saves = best.cpu < WORTH_IT * own.cpu
    rest = (
        f": {_told(best, found)} is as exact in {100 * best.cpu / own.cpu:.0f} % of the time" if saves else ""
    )
    yield f"the scene's own solver (*): {_told(own, found)}{rest}"


def _missing(found):
    """Runs without figures, and why; those of one stepper and reason together."""
    together = {}

    for run in found.runs:
        if run.reason and run is not found.own:
            together.setdefault((run.setting.integrator, run.setting.key, run.reason), []).append(
                run.setting.short
            )

    if together:
        yield "\nwithout figures:"

    for (name, key, reason), values in together.items():
        yield f"  {name}, {key} {', '.join(values)}: {reason}"
