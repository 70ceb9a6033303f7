"""The command `mbdfmi`."""

import argparse
import sys
from contextlib import contextmanager
from pathlib import Path

from rich.console import Console
from rich.progress import BarColumn, Progress, TextColumn, TimeRemainingColumn
from rich.table import Table

from . import __version__

out = Console()
err = Console(stderr=True)


def main(arguments=None) -> int:
    """Run the command line; returns the exit status: 0 done, 1 failed with a message."""
    options = _parser().parse_args(arguments)

    try:
        options.run(options)
    except Exception as error:
        if not _is_told(error):
            raise

        err.print(f"[bold red]error:[/] ", end="")
        err.print(_text(error), markup=False, highlight=False, soft_wrap=True)
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
    from .simulate import SimulationError

    return isinstance(error, (CompileError, LinkError, SimulationError))


def _text(error):
    return str(error.args[0]) if isinstance(error, KeyError) else str(error)


def _parser():
    parser = argparse.ArgumentParser(
        prog="mbdfmi",
        description="A multibody scene in, a native FMI 2.0 co-simulation FMU out.",
        epilog="A first try:  mbdfmi info models/pendulum.toml;  mbdfmi simulate models/pendulum.toml --until 10 "
        "--plot pendulum.png;  mbdfmi export models/pendulum.toml",
    )
    parser.add_argument("--version", action="version", version=f"mbdfmi {__version__}")
    commands = parser.add_subparsers(required=True, metavar="COMMAND")

    command = _command(commands, _export, "export", "write scenes as FMUs")
    command.add_argument("scenes", nargs="+", metavar="SCENE", help="scene file (TOML)")
    command.add_argument(
        "-o", "--output", metavar="FILE", help="the FMU, or a folder for it (default: <scene's name>.fmu here)"
    )
    command.add_argument(
        "--platform",
        action="append",
        metavar="NAME",
        help="x86_64-linux, aarch64-linux, x86_64-windows, x86_64-macos, aarch64-macos or all; may be repeated "
        "(default: this machine's)",
    )

    command = _command(commands, _simulate, "simulate", "run a scene in process")
    command.add_argument("scene", metavar="SCENE", help="scene file (TOML)")
    command.add_argument("--until", type=float, required=True, metavar="T", help="end of the run, s")
    command.add_argument("--step", type=float, metavar="H", help="communication step, s (default: T/500)")
    command.add_argument("--csv", metavar="FILE", help="write all inputs and outputs as a table")
    command.add_argument("--plot", metavar="FILE", help="write them as a picture (png, svg, pdf)")
    command.add_argument(
        "--set",
        action="append",
        default=[],
        metavar="NAME=VALUE",
        help="an input held at a value, or a parameter's value, e.g. --set shoulder.torque=5",
    )

    command = _command(commands, _info, "info", "show what a scene holds")
    command.add_argument("scene", metavar="SCENE", help="scene file (TOML)")
    command.add_argument("--parameters", action="store_true", help="list the parameters too")

    command = _command(commands, _check, "check", "look for mistakes in a scene or an FMU")
    command.add_argument("file", metavar="SCENE|FMU", help="scene file (TOML), or any FMU")

    command = _command(commands, _bench, "bench", "measure the cost of forward dynamics")
    command.add_argument("--quick", action="store_true", help="fewer sizes and repeats")
    command.add_argument("-o", "--output", metavar="DIR", help="write raw figures (JSON) and a plot there")

    return parser


def _command(commands, run, name, text):
    command = commands.add_parser(name, help=text, description=text[0].upper() + text[1:] + ".")
    command.set_defaults(run=run)
    return command


# commands


def _export(options):
    from .api import load
    from .model import c_identifier
    from .export.link import PLATFORMS

    platforms = list(PLATFORMS) if "all" in (options.platform or []) else options.platform
    target = Path(options.output) if options.output else Path()
    into_folder = target.is_dir() or len(options.scenes) > 1 or (options.output or "").endswith(("/", "\\"))
    failures = []

    # one broken scene must not keep the others from being built
    for file in options.scenes:
        try:
            scene = load(file)
            path = target / f"{c_identifier(scene.name)}.fmu" if into_folder else target

            with err.status(f"exporting {file}") as status:
                scene.export(path, platforms, progress=lambda text: status.update(f"{file}: {text}"))

            out.print(f"{path}  ({path.stat().st_size / 1024:.0f} KB)", highlight=False, soft_wrap=True)
        except Exception as error:
            if not _is_told(error):
                raise

            failures.append(_text(error))

    if failures:
        raise ValueError("\n".join(failures))


@contextmanager
def time_bar(text, until):
    """A progress bar over the simulated time; yields a function to call with the time reached (s)."""
    columns = (
        TextColumn("{task.description}"),
        BarColumn(),
        TextColumn("{task.completed:.4g} of {task.total:.4g} s"),
        TimeRemainingColumn(),
    )

    with Progress(*columns, console=err, transient=True) as bar:
        task = bar.add_task(text, total=until)
        yield lambda time: bar.update(task, completed=time)


def _simulate(options):
    from .api import load

    scene = load(options.scene)
    model = scene.compile()
    inputs, parameters = _split_settings(model, options.set)

    with time_bar("simulating", options.until) as progress:
        results = scene.simulate(options.until, options.step, inputs, parameters, progress=progress)

    for path, write in ((options.csv, results.to_csv), (options.plot, results.plot)):
        if path:
            out.print(str(write(path)), highlight=False, soft_wrap=True)

    if not (options.csv or options.plot):
        _print_summary(results)


def _split_settings(model, settings):
    """NAME=VALUE texts as inputs and parameters. Raises ValueError for what is neither."""
    inputs, parameters = {}, {}
    names = {v.name for v in model.of_causality("input")}
    names |= {name.partition("[")[0] for name in names}

    for setting in settings:
        name, sign, value = setting.rpartition("=")

        try:
            (inputs if name in names else parameters)[name] = float(value)
        except ValueError:
            sign = ""

        if not sign:
            raise ValueError(f"--set {setting}: write NAME=VALUE with a number, e.g. --set shoulder.torque=5")

    return inputs, parameters


def _print_summary(results):
    table = Table("variable", "unit", "start", "end", "least", "greatest")

    for name, column in results.items():
        figures = (column[0], column[-1], column.min(), column.max())
        table.add_row(name, results.units.get(name) or "", *(f"{figure:.6g}" for figure in figures))

    out.print(table)


def _info(options):
    from .api import load

    scene = load(options.scene)
    model = scene.compile()
    moving = model.places[1:]
    out.print(f"[bold]{model.title}[/]", highlight=False)

    if model.description:
        out.print(model.description.strip(), markup=False, highlight=False)

    welded = len(scene.body) - len(moving)
    together = f" in {len(moving)} rigid parts" if welded else ""
    out.print(f"{len(scene.body)} bodies{together}, {model.n_v} degrees of freedom, {len(model.variables)} variables")

    table = Table("body", "mass [kg]", "centre of mass [m]", "markers")

    for name, body in scene.body.items():
        mass, com, _ = body.mass_properties()
        table.add_row(name, f"{mass:.6g}", _vector(com), ", ".join(body.marker))

    out.print(table)

    table = Table("joint", "kind", "between", "freedoms")
    freedoms = {"fixed": 0, "revolute": 1, "prismatic": 1, "spherical": 3, "free": 6}

    for name, joint in scene.joint.items():
        table.add_row(name, joint.kind, " and ".join(joint.between), str(freedoms[joint.kind]))

    out.print(table)

    if scene.force:
        table = Table("force", "kind", "between")

        for name, force in scene.force.items():
            table.add_row(name, force.kind.replace("_", "-"), " and ".join(force.between))

        out.print(table)

    for causality in ("input", "output", "parameter")[: 3 if options.parameters else 2]:
        _print_variables(causality, model.of_causality(causality))


def _print_variables(causality, variables):
    if not variables:
        out.print(f"no {causality}s")
        return

    columns = [causality, "unit", "meaning"] + (["value"] if causality == "parameter" else [])
    table = Table(*columns)

    for v in variables:
        row = [v.name, v.unit or "", v.description]
        table.add_row(*row, *([f"{v.start:.6g}"] if causality == "parameter" else []))

    out.print(table)


def _vector(values):
    return ", ".join(f"{value:.6g}" for value in values)


def _check(options):
    path = Path(options.file)

    if path.suffix.lower() == ".fmu":
        _check_fmu(path)
    else:
        from .api import load

        load(path).compile()

    out.print(f"{path}: no mistakes found", highlight=False, soft_wrap=True)


def _check_fmu(path):
    """Raises ValueError with all that fmpy's validation finds, or with why a first run fails."""
    import zipfile

    import fmpy
    from fmpy.validation import validate_fmu

    if not path.is_file():
        raise FileNotFoundError(f"{path}: there is no such file")

    if not zipfile.is_zipfile(path):
        raise ValueError(f"{path}: not an FMU (an FMU is a zip archive)")

    problems = validate_fmu(str(path))

    if problems:
        raise ValueError("\n".join(f"{path}: {problem}" for problem in problems))

    try:
        fmpy.simulate_fmu(str(path), stop_time=0.1, output_interval=0.01)
    except Exception as error:
        raise ValueError(f"{path}: valid by its description, but a first run fails: {error}") from error


def _bench(options):
    from .report.bench import run_bench

    report = run_bench(options.quick, Path(options.output) if options.output else None, err)
    out.print(report.table())


if __name__ == "__main__":
    sys.exit(main())
