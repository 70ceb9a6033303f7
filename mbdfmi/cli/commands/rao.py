"""mbdfmi rao: answers to small regular waves."""

from ..arguments import add_command, add_scene
from ..paths import load_scene, result_files
from ..tables import print_table, table_of
from ..terminal import doing_here, note, out

# outputs in the table
SHOWN = 30


def add(commands):
    """The command and its arguments."""
    command = add_command(
        commands,
        run,
        "rao",
        "find response amplitude operators: amplitude and phase in waves",
        """The scene is linearised about its equilibrium (or its start, where that moves), and answers to
regular waves of amplitude 1 m with their crest at the origin at time 0: amplitude and phase of
outputs over the period of the waves. Drag of waves at members is no part: it is not linear.""",
        """examples:
  mbdfmi rao barge.toml --plot rao.png
  mbdfmi rao barge.toml --period 4:25:85 --direction 30 --csv rao.csv
  mbdfmi rao barge.toml --variable crane.position""",
    )
    add_scene(command)
    command.add_argument(
        "--period",
        metavar="A:B:N",
        help="N periods from A to B, s (default: those that files of coefficients know, 4 to 30 s)",
    )
    command.add_argument(
        "--direction", type=float, default=0.0, metavar="DEG", help="the way waves travel (default: 0)"
    )
    command.add_argument(
        "--variable",
        action="append",
        metavar="NAME",
        help="an output (default: positions and angles that the scene puts out); may be repeated",
    )
    command.add_argument("--at", metavar="WHERE", help="equilibrium, start, or a time of the run, s")
    command.add_argument("--plot", metavar="FILE", help="draw amplitudes and phases: png, svg or pdf")
    command.add_argument("--csv", metavar="FILE", help="write omega, amplitudes, phases (deg)")


def run(options):
    """Finds, tells, writes and draws."""
    import numpy as np

    from ...analysis.rao import rao
    from ...analysis.rao_plot import draw_rao
    from ...files import save_table

    csv, plot = result_files(options, options.scene)

    if not np.isfinite(options.direction):
        raise ValueError(f"--direction {options.direction:g}: needs an angle, deg")

    omega = 2 * np.pi / _periods(options.period)[::-1] if options.period else None
    scene = load_scene(options.scene)

    with doing_here("linearising"):
        found = rao(scene, omega, np.radians(options.direction), options.variable, options.at)

    note(found.notices)
    out.print(f"about {found.where}, waves towards {options.direction:g} deg, for an amplitude of 1 m")
    _tell(found)

    if csv:
        columns, names = [found.omega], ["omega"]

        for name, answer in zip(found.outputs, found.answers.T):
            columns += [np.abs(answer), np.degrees(np.angle(answer))]
            names += [name, f"{name} phase_deg"]

        save_table(csv, names, columns)
        out.print(str(csv), soft_wrap=True)

    if plot:
        title = f"{scene.title or scene.name}: waves towards {options.direction:g} deg"
        out.print(str(draw_rao(plot, found, title)), soft_wrap=True)


def _periods(text):
    """(n,) s, ascending. Raises ValueError."""
    import numpy as np

    try:
        first, last, count = text.split(":")
        found = np.linspace(float(first), float(last), int(count))
    except ValueError:
        raise ValueError(f"--period {text}: write FIRST:LAST:NUMBER, in s") from None

    if not (len(found) and found[0] > 0.0 and (np.diff(found) > 0.0).all() and np.isfinite(found).all()):
        raise ValueError(f"--period {text}: needs periods above 0 that ascend")

    return found


def _tell(found):
    import numpy as np

    names = ("largest", "at period, s", "phase, deg", "longest waves", "phase, deg there")
    table = table_of("output", "unit", *names, numbers=names)

    for name, unit, answer in list(zip(found.outputs, found.units, found.answers.T))[:SHOWN]:
        scale, told = (np.degrees(1.0), "deg") if unit == "rad" else (1.0, unit or "1")
        k = int(np.abs(answer).argmax())
        numbers = [scale * abs(answer[k]), 2 * np.pi / found.omega[k], np.degrees(np.angle(answer[k]))]
        numbers += [scale * abs(answer[0]), np.degrees(np.angle(answer[0]))]
        table.add_row(name, told, *(f"{x:.4g}" for x in numbers))

    print_table(table)

    if len(found.outputs) > SHOWN:
        out.print(f"and {len(found.outputs) - SHOWN} more; --csv writes all, --variable chooses")
