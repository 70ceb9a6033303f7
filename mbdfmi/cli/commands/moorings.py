"""mbdfmi moorings: lines where a scene starts."""

from ..arguments import add_command, add_scene
from ..paths import load_scene, result_files
from ..tables import print_table, table_of
from ..terminal import note, out


def add(commands):
    """The command and its arguments."""
    command = add_command(
        commands,
        run,
        "moorings",
        "tell and draw the mooring lines of a scene",
        """Tension, angle, and what lies on the bed of each catenary where the scene starts; and how tension
and the force of all lines change as what they hold is moved aside, without turning. A scene that
does not start at rest is brought there by `mbdfmi equilibrium SCENE --write`.""",
        """examples:
  mbdfmi moorings buoy.toml
  mbdfmi moorings buoy.toml --plot moorings.png
  mbdfmi moorings buoy.toml --offset 30 --direction 45 --csv offsets.csv""",
    )
    add_scene(command)
    command.add_argument(
        "--offset", type=float, metavar="M", help="so far both ways (default: a tenth of the longest line)"
    )
    command.add_argument(
        "--direction", type=float, default=0.0, metavar="DEG", help="of the offset, from x to y (default: 0)"
    )
    command.add_argument("--plot", metavar="FILE", help="draw footprint, sides, tensions: png, svg or pdf")
    command.add_argument("--csv", metavar="FILE", help="write force and tensions over the offset")


def run(options):
    """Tells the lines, writes and draws what was asked for."""
    import numpy as np

    from ...analysis.mooring_plot import draw_moorings
    from ...analysis.moorings import moorings
    from ...files import save_table

    csv, plot = result_files(options, options.scene)
    scene = load_scene(options.scene)
    lengths = [force.catenary.total_length for force in scene.force.values() if force.kind == "catenary"]
    offset = options.offset if options.offset is not None else 0.1 * max(lengths, default=1.0)

    if not 0.0 < offset < np.inf:
        raise ValueError(f"--offset {offset:g}: needs a length above 0 m")
    if not np.isfinite(options.direction):
        raise ValueError(f"--direction {options.direction:g}: needs an angle, deg")

    direction = np.radians(options.direction)
    found = moorings(scene, offset, direction)
    note(found.notices)
    _tell(found)

    if csv:
        names = ["offset", "force", *(line.name for line in found.lines)]
        save_table(csv, names, [found.offsets, found.force, found.tension])
        out.print(str(csv), soft_wrap=True)

    if plot:
        title = f"moorings of {scene.title or scene.name}"
        out.print(str(draw_moorings(plot, found, title, direction)), soft_wrap=True)


def _tell(found):
    import numpy as np

    names = (
        "length, m",
        "across, m",
        "up, m",
        "tension, kN",
        "at lower end",
        "from the vertical, deg",
        "on the bed, m",
    )
    table = table_of("line", "holds", *names, numbers=names)

    for line in found.lines:
        span = line.upper - line.lower
        steep = np.degrees(np.arctan2(*np.abs([np.hypot(*line.upper_force[:2]), line.upper_force[2]])))
        numbers = (
            line.length,
            np.hypot(*span[:2]),
            span[2],
            line.tension / 1e3,
            line.lower_tension / 1e3,
            steep,
        )
        table.add_row(line.name, line.body, *(f"{x:.5g}" for x in numbers), f"{line.grounded:.5g}")

    print_table(table)
    out.print(f"stiffness against the offset, at the start: {found.stiffness:.5g} N/m")
