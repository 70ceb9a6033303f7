"""mbdfmi inverse: the efforts that a motion needs."""

from ..arguments import add_command, add_result_files, add_scene, add_settings
from ..paths import load_scene, result_files
from ..settings import settings_of
from ..show_results import show
from ..terminal import time_bar


def add(commands):
    """The command and its arguments."""
    command = add_command(
        commands,
        run,
        "inverse",
        "find the efforts that a motion needs",
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
    )
    add_scene(command)
    command.add_argument(
        "--motion", required=True, metavar="FILE", help="table of joint coordinates over time (CSV)"
    )
    command.add_argument(
        "--drive",
        action="append",
        metavar="JOINT",
        help="drive this joint of those in the table (default: all); may be repeated",
    )
    command.add_argument(
        "--hybrid",
        action="store_true",
        help="joints that the table does not tell go on freely from the scene's start",
    )
    add_result_files(command, "efforts, motion and outputs")
    add_settings(command)


def run(options):
    """Runs, and shows or writes what came of it."""
    from ...run.results import Results

    csv, plot = result_files(options, options.scene, options.motion)
    scene = load_scene(options.scene, options)
    motion = Results.from_csv(options.motion)
    inputs, parameters = settings_of(scene.compile(), options.set)

    with time_bar(motion["time"][-1]) as progress:
        results = scene.inverse(
            motion,
            drive=options.drive,
            inputs=inputs,
            parameters=parameters,
            progress=progress,
            hybrid=options.hybrid,
        )

    show(results, csv, plot)
