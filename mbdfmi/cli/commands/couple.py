"""mbdfmi couple: FMUs and scenes that run together."""

from ..arguments import add_command, add_result_files
from ..paths import result_files, view_file, writable
from ..show_results import show
from ..terminal import compile_first, note, out, time_bar


def add(commands):
    """The command and its arguments."""
    command = add_command(
        commands,
        run,
        "couple",
        "run FMUs and scenes together",
        """SYSTEM is a file (TOML) that names FMUs of any maker (FMI 2.0 and 3.0,
co-simulation) and scenes, and links outputs to inputs, or a package of SSP 1.0 (.ssp);
docs/coupling.md tells how it is written. Without --csv, --plot and --view a summary is printed.""",
        """examples:
  mbdfmi couple crane.toml --check
  mbdfmi couple crane.toml --until 10 --step 0.01 --csv run.csv --plot run.png
  mbdfmi couple crane.toml --method newton --error 1e-4
  mbdfmi couple crane.toml --view run.html
  mbdfmi couple crane.toml --ssp crane.ssp""",
    )
    command.add_argument("system", metavar="SYSTEM", help="the coupled system (.toml, .ssp)")
    command.add_argument(
        "--until", type=float, metavar="T", help="end of the run, s (default: as the file says)"
    )
    command.add_argument(
        "--step", type=float, metavar="H", help="communication step, s (default: as the file says)"
    )
    command.add_argument(
        "--check", action="store_true", help="tell the graph, loops, order and master, and run nothing"
    )
    command.add_argument("--method", help="auto, jacobi, gauss-seidel, iterate or newton")
    command.add_argument(
        "--order", type=int, help="order of the polynomials that inputs are over a step: 0, 1 or 2"
    )
    command.add_argument(
        "--error", type=float, metavar="E", help="choose macro steps, for this relative error"
    )
    command.add_argument(
        "--ssp", metavar="FILE", help="write the system as a package of SSP, and run nothing"
    )
    add_result_files(command, "what is recorded")
    command.add_argument(
        "--view", metavar="FILE", help="write the motion of its scene to look at: .html, .glb or .png"
    )
    command.add_argument("--scene", metavar="NAME", help="which scene --view shows, if there are several")
    command.add_argument("--at", type=float, metavar="T", help="time of the picture, s (default: the last)")


def run(options):
    """Runs, and shows or writes what came of it."""
    from ...cosim import CouplingError, load_system

    csv, plot = result_files(options, options.system)
    shown = view_file(options.view, options.at, options.system, csv, plot)
    system = load_system(options.system)

    for key in ("method", "order", "error"):
        if (value := getattr(options, key)) is not None:
            setattr(system.master, key, value)

    if any(table.scene for table in system.fmu.values()):
        compile_first()

    if options.check:
        out.print(system.check(), soft_wrap=True)
        return

    if options.ssp:
        out.print(str(system.write_ssp(writable(options.ssp, [options.system]))), soft_wrap=True)
        return

    until = system.run.stop if options.until is None else options.until

    try:
        with time_bar(until) as progress:
            results = system.simulate(
                until, options.step, progress=progress, view=_scene(system, options.scene) if shown else None
            )
    except CouplingError as error:
        if error.results is not None and csv:
            note([f"what was found up to {error.results['time'][-1]:.9g} s: {error.results.to_csv(csv)}"])
        raise

    show(results, csv, plot, shown, options.at)
    if not (csv or plot or shown):
        _tell(results)


def _scene(system, name):
    """The scene that is to be seen. Raises ValueError."""
    scenes = [key for key, table in system.fmu.items() if table.scene]
    if name is None and len(scenes) != 1:
        found = (
            f"there are {', '.join(scenes)}; say which by --scene NAME" if scenes else "the system has none"
        )
        raise ValueError(f"--view shows the motion of a scene; {found}")
    return name or scenes[0]


def _tell(results):
    """What the coupling did, below the summary."""
    steps = ", ".join(f"{name} {n}" for name, n in results.work.items())
    out.print(f"\nsteps of the FMUs: {steps}", soft_wrap=True)
    for reason in results.plan.reasons:
        out.print(reason, soft_wrap=True)
    for bond in results.bonds:
        out.print(
            f"bond {bond.name}: made {bond.made:.3g} J of {bond.exchanged:.3g} J ({100 * bond.part:.2g} %)",
            soft_wrap=True,
        )
    if results.jumps:
        link, jump = max(results.jumps.items(), key=lambda pair: pair[1])
        out.print(f"largest jump of an input: {100 * jump:.2g} % of its range, {link}", soft_wrap=True)
