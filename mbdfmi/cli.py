"""The command `mbdfmi`."""

import argparse
import glob
import os
import re
import subprocess
import sys
import tempfile
from contextlib import contextmanager
from difflib import get_close_matches
from itertools import groupby
from pathlib import Path

import numpy as np
from rich import box
from rich.console import Console
from rich.progress import BarColumn, Progress, TextColumn, TimeRemainingColumn
from rich.table import Table

from . import __version__
from .files import check_ending, same, to_standard_output

# names and titles are free text: nothing in them is markup, an emoji or to be coloured
out = Console(markup=False, highlight=False, emoji=False)
err = Console(markup=False, highlight=False, emoji=False, stderr=True)

COMPILING = "compiling the kernels, once per version (some minutes)"
MOST_POINTS = 10_000_000  # communication points of a run: some GB of results


def main(arguments=None) -> int:
    """Run the command line; returns the exit status: 0 done, 1 failed with a message."""
    return carry_out(_parser(), arguments)


def carry_out(parser, arguments=None) -> int:
    """Parse arguments and call their `run`; what a user can mend is told without a traceback. Returns the exit status."""
    for stream in (sys.stdout, sys.stderr):
        if hasattr(stream, "reconfigure"):
            stream.reconfigure(errors="replace")

    options = parser.parse_args(arguments)

    try:
        options.run(options)
    except Exception as error:
        if not _is_told(error):
            raise

        err.print("error: ", style="bold red", end="")
        err.print(_text(error), soft_wrap=True)
        return 1
    except KeyboardInterrupt:
        err.print("stopped")
        return 130

    return 0


def _is_told(error):
    """Whether an error is a user's to read; others are ours and keep their traceback."""
    from .scene import SceneError

    if isinstance(error, (SceneError, OSError, ImportError, ValueError, KeyError)):
        return True

    from .export.aot import CompileError
    from .export.link import LinkError
    from .run.instance import SimulationError

    return isinstance(error, (CompileError, LinkError, SimulationError))


def _text(error):
    if isinstance(error, OSError) and error.filename and error.strerror:
        return f"{error.filename}: {error.strerror}"

    return str(error.args[0]) if isinstance(error, KeyError) and error.args else str(error)


# the command line


def _parser():
    parser = argparse.ArgumentParser(
        prog="mbdfmi",
        description="A multibody scene in, a native FMI 2.0 co-simulation FMU out.",
        epilog="""a first try:
  mbdfmi info models/pendulum.toml                       what is in it
  mbdfmi simulate models/pendulum.toml --until 10        how it moves
  mbdfmi export models/pendulum.toml                     pendulum.fmu, for any FMI tool

`mbdfmi COMMAND --help` says more about each command.""",
        formatter_class=argparse.RawDescriptionHelpFormatter,
    )
    parser.add_argument("--version", action="version", version=f"mbdfmi {__version__}")
    commands = parser.add_subparsers(required=True, metavar="COMMAND")
    scene = {"metavar": "SCENE", "help": "scene file (TOML)"}

    command = _command(
        commands, _export, "export", "write scenes as FMUs",
        """An FMU (FMI 2.0, co-simulation) holds all it needs: no Python and no compiler
where it runs. The first export of a version compiles the kernels, which takes
some minutes; later ones take a second.""",
        """examples:
  mbdfmi export crane.toml                      writes crane.fmu
  mbdfmi export crane.toml -o out/tower.fmu     under another name
  mbdfmi export models/*.toml -o fmus           one FMU for each, in a folder
  mbdfmi export crane.toml --platform x86_64-linux --platform x86_64-windows""",
    )  # fmt: skip
    command.add_argument("scenes", nargs="+", **scene)
    command.add_argument(
        "-o", "--output", metavar="PATH",
        help="the FMU when it ends in .fmu, - for the standard output, else a folder (default: <scene's name>.fmu here)",
    )  # fmt: skip
    command.add_argument(
        "--platform", action="append", metavar="NAME",
        help="x86_64-linux, aarch64-linux, x86_64-windows, x86_64-macos, aarch64-macos or all; "
        "may be repeated (default: this machine's)",
    )  # fmt: skip

    command = _command(
        commands, _simulate, "simulate", "run a scene in process",
        """The run uses the same kernels as an FMU and gives the same numbers. Without
--csv and --plot it prints a summary. Inputs are 0 unless --set holds them at
another value; inputs that change in time need Python: mbdfmi.load(...).simulate.""",
        """examples:
  mbdfmi simulate pendulum.toml --until 10
  mbdfmi simulate pendulum.toml --until 10 --step 0.01 --csv a.csv --plot a.png
  mbdfmi simulate arm.toml --until 2 --set elbow.torque=5 --set gravity=0,0,-1.62

`mbdfmi info SCENE --parameters` lists what --set can set.""",
    )  # fmt: skip
    command.add_argument("scene", **scene)
    command.add_argument("--until", type=float, required=True, metavar="T", help="end of the run, s")
    command.add_argument(
        "--step", type=float, metavar="H",
        help="communication step, s (default: T/500): how often results are kept; the solver's own steps are finer "
        "where they need to be",
    )  # fmt: skip
    command.add_argument("--csv", metavar="FILE", help="write all inputs and outputs as a table; - is the standard output")
    command.add_argument("--plot", metavar="FILE", help="write them as a picture: png, svg or pdf")
    command.add_argument(
        "--set", action="append", default=[], metavar="NAME=VALUE",
        help="hold an input at a value, or change a parameter; an array takes its name and numbers with commas",
    )  # fmt: skip

    command = _command(
        commands, _inverse, "inverse", "find the efforts that a motion needs",
        """The motion is a table (CSV) of joint coordinates by name over time: a row of names, as in
"time,shoulder.angle [deg],boom.position", then numbers; of a floating body float.position[1]
to [3] and float.zyx[1] to [3] or float.euler_parameters[1] to [4]. Speeds and accelerations
(shoulder.speed, shoulder.acceleration) are taken from there too, else from a spline through
the positions. A table that `mbdfmi simulate --csv` wrote will do. Where loops close, as many
joints are driven as there are degrees of freedom. What no motor could move (a floating base, a
rod that may spin between two balls) goes on freely; so does the rest with --hybrid.""",
        """examples:
  mbdfmi inverse arm.toml --motion reach.csv
  mbdfmi inverse four_bar.toml --motion run.csv --drive crank --csv torque.csv --plot torque.png""",
    )  # fmt: skip
    command.add_argument("scene", **scene)
    command.add_argument("--motion", required=True, metavar="FILE", help="table of joint coordinates over time (CSV)")
    command.add_argument(
        "--drive", action="append", metavar="JOINT",
        help="drive this joint of those in the table (default: all); may be repeated",
    )  # fmt: skip
    command.add_argument(
        "--hybrid", action="store_true", help="joints that the table does not tell go on freely from the scene's start"
    )
    command.add_argument("--csv", metavar="FILE", help="write efforts, motion and outputs as a table; - is the standard output")
    command.add_argument("--plot", metavar="FILE", help="write them as a picture: png, svg or pdf")
    command.add_argument("--set", action="append", default=[], metavar="NAME=VALUE", help="as in mbdfmi simulate")

    command = _command(
        commands, _info, "info", "show what a scene holds",
        "Bodies, joints, degrees of freedom, solver, and the variables that its FMU will have.",
    )  # fmt: skip
    command.add_argument("scene", **scene)
    command.add_argument("--parameters", action="store_true", help="list the parameters and their values too")

    command = _command(
        commands, _check, "check", "look for mistakes in a scene or an FMU",
        """A scene is read and its motion started. An FMU, of any maker, is validated and
run for a few steps. All mistakes found are printed; the exit status is 1 then.""",
    )  # fmt: skip
    command.add_argument("file", metavar="SCENE|FMU", help="scene file (TOML), or any FMU")

    return parser


def _command(commands, run, name, text, more, examples=None):
    command = commands.add_parser(
        name,
        help=text,
        description=f"{text[0].upper()}{text[1:]}.\n\n{more}",
        epilog=examples,
        formatter_class=argparse.RawDescriptionHelpFormatter,
    )
    command.set_defaults(run=run)
    return command


# what all commands need


def _load(file):
    from .api import load

    if Path(file).suffix.lower() == ".fmu":
        raise ValueError(f"{file}: is an FMU; this command wants a scene file (TOML). For an FMU: mbdfmi check")

    return load(file)


def writable(text, inputs):
    """The path of a file to be written, looked at before work starts; `inputs` are files that stay as they are.

    Raises ValueError that says what hinders.
    """
    path = Path(text)

    for given in inputs:
        if same(path, given):
            raise ValueError(f"{path}: is read by this command or written twice; write to another file")

    if to_standard_output(path):
        return path

    if path.is_dir():
        raise ValueError(f"{path}: is a folder; name a file in it")

    if path.exists():
        if not os.access(path, os.W_OK):
            raise ValueError(f"{path}: cannot be written, it is not yours to write")
        if not path.is_file():
            return path

    path = Path(os.path.realpath(path)) if path.is_symlink() else path

    # folders that are missing will be made
    parent = next(folder for folder in path.absolute().parents if folder.exists())

    if not parent.is_dir():
        raise ValueError(f"{path}: cannot be written, {parent} is a file and not a folder")

    if not os.access(parent, os.W_OK):
        raise ValueError(f"{path}: cannot be written, the folder {parent} is not yours to write in")

    return path


@contextmanager
def _doing(text):
    """Shows what takes time; yields a function to call with what comes next."""
    if not err.is_terminal:
        yield lambda text: err.print(text, soft_wrap=True)
        return

    with err.status(text) as status:
        yield status.update


def _kernels_are_compiled():
    """Whether an in-process run can start at once."""
    from .kernels.language import cache_directory, source_hash

    return any((cache_directory() / "jit" / source_hash()).rglob("*.nbc"))


def _table(*headings, numbers=()):
    """A table with plain rules; `numbers` are the headings of columns set flush right.

    The first column holds names, which stay whole; others wrap where the terminal is narrow.
    """
    table = Table(box=box.SIMPLE_HEAD, pad_edge=False, padding=(0, 1, 0, 0), show_edge=False)

    for k, heading in enumerate(headings):
        table.add_column(heading, justify="right" if heading in numbers else "left", no_wrap=k == 0)

    return table


def _print_table(table):
    out.print()
    out.print(table)


def _count(n, one, many=None):
    return f"{n} {one if n == 1 else many or one + 's'}"


def _vector(values):
    return ", ".join(f"{value:.6g}" for value in values)


# commands


def _export(options):
    from .compiler.model import c_identifier
    from .export.link import PLATFORMS

    platforms = list(PLATFORMS) if "all" in (options.platform or []) else options.platform

    for name in platforms or []:
        if name not in PLATFORMS:
            raise ValueError(f"--platform {name}: unknown; there are {', '.join(PLATFORMS)} and all")

    files = [file for given in options.scenes for file in _matching(given)]
    target = Path(options.output or "")
    written_to = to_standard_output(target) or (target.exists() and not target.is_file())
    one_file = (target.suffix.lower() == ".fmu" or written_to) and not target.is_dir()
    say = err if to_standard_output(target) else out

    if not (one_file or target.exists()):
        check_ending(target, "FMUs are to be written", ".fmu")

    if one_file and len(files) > 1:
        raise ValueError(f"--output {target}: one file cannot hold {len(files)} scenes; name a folder")

    written, failures = {}, []

    # one broken scene must not keep the others from being built
    for file in files:
        try:
            scene = _load(file)
            path = writable(target if one_file else target / f"{c_identifier(scene.name)}.fmu", files)

            if path in written:
                raise ValueError(f"{file}: has the same name as {written[path]}, so their FMUs would have too")

            with _doing(f"{file}: exporting") as tell:
                scene.export(path, platforms, progress=lambda text: tell(f"{file}: {text}"))

            written[path] = file
            size = f"  ({path.stat().st_size / 1024:.0f} KB)" if path.is_file() else ""
            say.print(f"{path}{size}", soft_wrap=True)
        except Exception as error:
            if not _is_told(error):
                raise

            failures.append(_text(error))

    if failures:
        raise ValueError("\n".join(failures))


def _outputs(options, *inputs):
    """The files of --csv and --plot, or None, looked at before work starts."""
    from .run.results import Results

    csv = options.csv and writable(options.csv, inputs)
    plot = options.plot and writable(options.plot, [*inputs, *([csv] if csv else [])])

    if csv:
        Results.check_csv(csv)

    if plot:
        Results.check_plot(plot)

    return csv, plot


def _matching(file):
    """A file, or those that a pattern with * stands for: Windows' shells leave patterns to the program."""
    return sorted(glob.glob(file)) if "*" in file and not Path(file).exists() else [file]


def _inverse(options):
    from .analysis.inverse import read_motion

    csv, plot = _outputs(options, options.scene, options.motion)
    scene = _load(options.scene)
    motion = read_motion(options.motion)
    inputs, parameters = _settings(scene.compile(), options.set)

    with _time_bar(motion["time"][-1]) as progress:
        results = scene.inverse(
            motion, drive=options.drive, inputs=inputs, parameters=parameters, progress=progress, hybrid=options.hybrid
        )

    _show(results, csv, plot)


def _simulate(options):
    csv, plot = _outputs(options, options.scene)
    scene = _load(options.scene)
    model = scene.compile()
    inputs, parameters = _settings(model, options.set)

    if options.step and abs(options.until / options.step) > MOST_POINTS:
        raise ValueError(f"--step {options.step:g}: more than {MOST_POINTS:,} communication points up to {options.until:g} s")

    with _time_bar(options.until) as progress:
        results = scene.simulate(options.until, options.step, inputs, parameters, progress=progress)

    _show(results, csv, plot)


def _show(results, csv, plot):
    """Results to files, or a summary to the screen; what the solver had to say of them."""
    _note(results.notices)

    # what was written where, unless it came out of the standard output itself
    say = err if csv and to_standard_output(csv) else out

    if csv:
        say.print(str(results.to_csv(csv)), soft_wrap=True)

    if plot:
        say.print(str(results.plot(plot)), soft_wrap=True)

    if not (csv or plot):
        _print_summary(results)


def _note(notices):
    for notice in notices:
        err.print(f"note: {notice}", soft_wrap=True)


@contextmanager
def _time_bar(until):
    """A bar over the simulated time; yields a function to call with the time reached (s)."""
    text = "simulating" if _kernels_are_compiled() else COMPILING

    if not err.is_terminal:
        if text == COMPILING:
            err.print(text)

        yield None
        return

    columns = (
        TextColumn("{task.description}"),
        BarColumn(bar_width=None),
        TextColumn("{task.completed:.4g} of {task.total:.4g} s"),
        TimeRemainingColumn(),
    )

    with Progress(*columns, console=err, transient=True) as bar:
        task = bar.add_task(text, total=until)
        yield lambda time: bar.update(task, completed=time, description="simulating")


def _settings(model, settings):
    """NAME=VALUE texts as inputs and parameters, arrays by component. Raises ValueError for what is neither."""
    from .scene import variable_name

    values = {"input": {}, "parameter": {}}
    variables = {v.name: v for v in model.variables if v.causality in values}
    arrays = {base: list(members) for base, members in groupby(variables.values(), lambda v: _base(v.name))}

    for setting in settings:
        name, _, text = setting.rpartition("=")

        try:
            numbers = [float(number) for number in text.split(",")]
        except ValueError:
            numbers = []

        if not (name and numbers and np.all(np.isfinite(numbers))):
            raise ValueError(f"--set {setting}: write NAME=VALUE with a number, as in --set shoulder.torque=5")

        name = variable_name(name)
        members = [variables[name]] if name in variables else arrays.get(name)

        if not members:
            near = get_close_matches(name, [*arrays, *variables], n=1)
            hint = f"did you mean {near[0]}?" if near else "mbdfmi info SCENE --parameters lists those there are"
            raise ValueError(f"--set {setting}: there is no input or parameter {name}; {hint}")

        if len(numbers) != len(members):
            needs = _count(len(members), "number")
            raise ValueError(f"--set {setting}: {name} takes {needs} with commas between, found {len(numbers)}")

        for variable, number in zip(members, numbers):
            values[variable.causality][variable.name] = number

    return values["input"], values["parameter"]


def _base(name):
    """The name of the array that a variable belongs to, or its own."""
    return re.sub(r"\[\d+(,\d+)*\]$", "", name)


def _print_summary(results):
    numbers = ("start", "end", "least", "greatest")
    table = _table("variable", "unit", *numbers, numbers=numbers)

    for name, column in results.items():
        figures = (column[0], column[-1], column.min(), column.max())
        table.add_row(name, results.units.get(name) or "", *(f"{figure:.6g}" for figure in figures))

    out.print(table)


def _info(options):
    scene = _load(options.scene)
    model = scene.compile()
    of = {causality: model.of_causality(causality) for causality in ("input", "output", "parameter")}
    out.print(model.title, style="bold")

    if model.description:
        out.print(model.description.strip())

    n_parts = len({node for node, _ in model.tree.home.values() if node})
    bodies = _count(len(scene.body), "body", "bodies")
    bodies += f" in {_count(n_parts, 'rigid part')}" if n_parts < len(scene.body) else ""
    found, notices = _structure(options.scene, scene, model)
    out.print(f"{bodies}, {_count(found.freedom, 'degree')} of freedom" if found else bodies)
    out.print(", ".join(_count(len(variables), causality) for causality, variables in of.items()))
    central = scene.central_gravity
    out.print(f"gravity {f'central, mu {central.mu:g} m3/s2' if central else f'{_vector(scene.gravity)} m/s2'}")
    out.print(f"solver {_solver(scene.solver)}")

    table = _table("body", "mass, kg", "centre of mass, m", "markers", numbers=("mass, kg",))

    for name, body in scene.body.items():
        mass, com, _ = body.mass_properties()
        table.add_row(name, f"{mass:.6g}", _vector(com), ", ".join(body.marker))

    _print_table(table)
    table = _table("joint", "kind", "from", "to", "freedoms", numbers=("freedoms",))

    for name, joint in scene.joint.items():
        table.add_row(name, joint.kind, *joint.between, str(len(joint.start_velocity())))

    _print_table(table)

    if scene.force:
        table = _table("force", "kind", "from", "to")

        for name, force in scene.force.items():
            table.add_row(name, force.kind.replace("_", "-"), *force.between)

        _print_table(table)

    if found:
        _print_structure(found)

    for causality in ("input", "output", "parameter")[: 3 if options.parameters else 2]:
        _print_variables(causality, of[causality])

    _note(notices)


def _structure(path, scene, model):
    """The scene's Structure, and notices of its start; None, and why, where its loops cannot be closed."""
    from .run.instance import Instance, SimulationError

    with _doing_first(f"{path}: looking at its freedoms"):
        try:
            return scene.structure(), Instance(model).notices
        except SimulationError as error:
            err.print(f"{path}: its freedoms cannot be counted: {error}", soft_wrap=True)
            return None, model.notices


@contextmanager
def _doing_first(text):
    """Shows what may have to wait for the kernels."""
    if err.is_terminal or not _kernels_are_compiled():
        with _doing(text if _kernels_are_compiled() else COMPILING):
            yield
    else:
        yield


def _print_structure(found):
    """Where the degrees of freedom come from, and what is not determined."""
    if found.equations or found.driven:
        out.print(
            f"\n{_count(found.coordinates, 'joint coordinate')} less {_count(found.rank, 'independent equation')} "
            f"(of {found.equations}): {_count(found.freedom, 'degree')} of freedom"
        )

    if found.freedom_at_start > found.freedom:
        out.print(f"the start is singular: {_count(found.freedom_at_start, 'degree')} of freedom there")

    for text, names in (("driven", found.driven), ("closing loops", found.closing)):
        if names:
            out.print(f"{text}: {', '.join(names)}")

    for heading, rows in (
        ("equation that follows from others", [(row.owner, row.keeps) for row in found.redundant]),
        ("reaction not determined", [(row.owner, row.what) for row in found.undetermined]),
    ):
        if rows:
            table = _table("joint", heading)

            for row in rows:
                table.add_row(*row)

            _print_table(table)


def _solver(solver):
    if solver.step:
        return f"{solver.integrator}, fixed step of at most {solver.step:g} s"

    limit = f", steps of at most {solver.max_step:g} s" if solver.max_step else ""
    tolerances = f"tolerance {solver.tolerance:g} relative, {solver.absolute_tolerance:g} absolute"
    return f"{solver.integrator}, adaptive step, {tolerances}{limit}"


def _print_variables(causality, variables):
    """A table of variables, an array in one row."""
    if not variables:
        out.print(f"\nno {causality}s")
        return

    values = ("value",) if causality == "parameter" else ()
    meanings = ("meaning",) if not values or out.width >= 110 else ()  # a narrow terminal shows values instead
    table = _table(causality, *values, "unit", *meanings)

    for base, members in groupby(variables, lambda v: _base(v.name)):
        members = list(members)
        name = base + re.sub(r"\d+", r"1..\g<0>", members[-1].name.removeprefix(base))
        units = list(dict.fromkeys(v.unit for v in members if v.unit))
        unit = units[0] + ", ..." * (len(units) > 1) if units else ""
        cells = [_values([v.start for v in members])] if values else []
        table.add_row(name, *cells, unit, *([members[0].description] if meanings else []))

    _print_table(table)


def _values(numbers):
    if len(numbers) <= 6:
        return _vector(numbers)

    return f"{len(numbers)} numbers, {np.count_nonzero(numbers)} not zero"


def _check(options):
    path = Path(options.file)
    notes = _check_fmu(path) if path.suffix.lower() == ".fmu" else _check_scene(path)
    out.print(f"{path}: no mistakes found{notes}", soft_wrap=True)


def _check_scene(path):
    """Reads a scene and starts its motion. Raises SceneError, SimulationError."""
    model = _load(path).compile()

    from .run.instance import Instance

    with _doing(f"{path}: starting its motion") as tell:
        if not _kernels_are_compiled():
            tell(COMPILING)

        instance = Instance(model)
        instance.outputs()
        instance.step(1e-3)

    _note(instance.notices)
    return ""


# runs ten steps of an FMU
_TRIAL = """
import sys, fmpy
experiment = fmpy.read_model_description(sys.argv[1]).defaultExperiment
start = float(getattr(experiment, "startTime", None) or 0)
step = float(getattr(experiment, "stepSize", None) or 0.01)
fmpy.simulate_fmu(sys.argv[1], start_time=start, stop_time=start + 10 * step, output_interval=step)
"""


def _check_fmu(path):
    """Raises ValueError with all that fmpy's validation finds, or with why a first run fails.

    Returns what there is to add when nothing was found.
    """
    import zipfile

    import fmpy
    from fmpy.validation import validate_fmu

    if not path.is_file():
        raise ValueError(f"{path}: there is no such file")

    try:
        with zipfile.ZipFile(path) as archive:
            damaged = archive.testzip()

        if damaged:
            raise ValueError(f"{path}: damaged, {damaged} in it cannot be read")
    except (zipfile.BadZipFile, EOFError) as error:
        raise ValueError(f"{path}: not an FMU, or damaged: an FMU is a zip archive ({error})") from error

    try:
        problems = validate_fmu(str(path))
    except Exception as error:  # fmpy has no class of its own for what it finds
        raise ValueError(f"{path}: its description cannot be read: {_text(error)}") from error

    if problems:
        raise ValueError("\n".join(f"{path}: {problem}" for problem in problems))

    if fmpy.platform not in fmpy.supported_platforms(str(path)):
        return f" (not run: it holds no library for {fmpy.platform})"

    # in a process of its own, with a folder of its own: a bad library may bring its process down
    with tempfile.TemporaryDirectory(ignore_cleanup_errors=True) as folder, _doing(f"{path}: a first run"):
        environment = os.environ | dict.fromkeys(("TMPDIR", "TEMP", "TMP"), folder)
        command = [sys.executable, "-c", _TRIAL, str(path)]
        done = subprocess.run(command, env=environment, capture_output=True, text=True, errors="replace")

    if done.returncode:
        said = [line for line in (done.stdout + done.stderr).splitlines() if line.strip()]
        reason = "it brings its process down" if done.returncode < 0 or not said else said[-1]
        raise ValueError(f"{path}: valid by its description, but a first run fails: {reason}")

    return ""


if __name__ == "__main__":
    sys.exit(main())
