"""mbdfmi simulate: a run in process."""

from ..arguments import add_command, add_result_files, add_scene, add_settings, add_view
from ..paths import check_looks, load_scene, result_files, view_file
from ..settings import settings_of
from ..show_results import show
from ..terminal import time_bar

MOST_POINTS = 10_000_000  # communication points of a run: some GB of results


def add(commands):
    """The command and its arguments."""
    command = add_command(
        commands,
        run,
        "simulate",
        "run a scene in process",
        """The run uses the same kernels as an FMU and gives the same numbers. Without
--csv, --plot and --view it prints a summary. Inputs are 0 unless --set holds them at
another value; inputs that change in time need Python: mbdfmi.load(...).simulate.""",
        """examples:
  mbdfmi simulate pendulum.toml --until 10
  mbdfmi simulate pendulum.toml --until 10 --step 0.01 --csv a.csv --plot a.png
  mbdfmi simulate pendulum.toml --until 10 --view run.html
  mbdfmi simulate pendulum.toml --until 10 --view a.png --at 2.5
  mbdfmi simulate arm.toml --until 2 --set elbow.torque=5 --set gravity=0,0,-1.62

`mbdfmi info SCENE --parameters` lists what --set can set.""",
    )
    add_scene(command)
    command.add_argument("--until", type=float, required=True, metavar="T", help="end of the run, s")
    command.add_argument(
        "--step",
        type=float,
        metavar="H",
        help="communication step, s (default: T/500): how often results are kept; the solver's own steps are "
        "finer where they need to be",
    )
    command.add_argument(
        "--specialise",
        action="store_true",
        default=None,
        help="compile the kernels for this scene first: a faster run, the same numbers (docs/specialise.md)",
    )
    command.add_argument(
        "--bind",
        metavar="NAME,...",
        help="with --specialise, parameters that are constants of the code, all for all but start values",
    )
    add_result_files(command, "all inputs and outputs")
    add_view(command, "the motion")
    add_settings(command)


def run(options):
    """Runs, and shows or writes what came of it."""
    csv, plot = result_files(options, options.scene)
    shown = view_file(options.view, options.at, options.scene, csv, plot)
    scene = load_scene(options.scene, options)

    if shown:
        check_looks(options.scene, scene)

    # the run compiles the scene itself: this one is for the names of its variables alone
    inputs, parameters = settings_of(scene.compile(as_given=True), options.set) if options.set else ({}, {})

    if options.step and abs(options.until / options.step) > MOST_POINTS:
        raise ValueError(
            f"--step {options.step:g}: more than {MOST_POINTS:,} communication points up to "
            f"{options.until:g} s"
        )

    with time_bar(options.until) as progress:
        bind = options.bind and options.bind.split(",")
        results = scene.simulate(
            options.until, options.step, inputs, parameters, options.specialise, bind, progress=progress
        )

    show(results, csv, plot, shown, options.at)
