"""mbdfmi gz: the righting arm of what floats."""

from ..arguments import add_command, add_scene, add_settings
from ..paths import load_scene, result_files
from ..settings import settings_of
from ..show_results import beside, write
from ..tables import print_table, table_of
from ..terminal import doing_here, note, out

# rows of the table on the terminal
MOST = 24


def add(commands):
    """The command and its arguments."""
    command = add_command(
        commands,
        run,
        "gz",
        "find the righting arm of a hull at all angles of heel",
        """The hull, a body with hydrostatics on a free joint to the ground, is held at one heel after the
other; sinkage, trim and all that hangs or swings come to rest there. The arm GZ is the moment that
holds it over the weight of what it displaces, positive where it rights. It tells where the hull
rests by itself, where it capsizes, the largest arm, and GM, the slope at no heel.""",
        """examples:
  mbdfmi gz barge.toml --plot gz.png
  mbdfmi gz crane.toml --time 960 --from -10 --to 60 --plot gz.png
  mbdfmi gz barge.toml --axis y --to 30                       about the axis across: trim
  mbdfmi gz boat.toml --hull boat --set keel.mass=800 --csv gz.csv""",
    )
    add_scene(command)
    command.add_argument("--hull", metavar="BODY", help="which body heels, where several float")
    command.add_argument(
        "--axis",
        default="x",
        metavar="AXIS",
        help="of the hull, that it heels about: x, y, or an angle from x to y, deg",
    )
    command.add_argument("--from", dest="first", type=float, default=0.0, metavar="DEG", help="(default: 0)")
    command.add_argument("--to", dest="last", type=float, default=90.0, metavar="DEG", help="(default: 90)")
    command.add_argument("--step", type=float, default=2.0, metavar="DEG", help="(default: 2)")
    command.add_argument(
        "--time", type=float, default=0.0, metavar="T", help="time of drives and loads, s (default: 0)"
    )
    command.add_argument("--csv", metavar="FILE", help="write the curve as a table")
    command.add_argument("--plot", metavar="FILE", help="draw it: png, svg or pdf")
    add_settings(command)


def run(options):
    """Finds the curve, tells and draws it."""
    import numpy as np

    csv, plot = result_files(options, options.scene)

    if not (options.first < options.last and 0.0 < options.step <= options.last - options.first):
        raise ValueError(
            f"--from {options.first:g} --to {options.last:g} --step {options.step:g}: angles must ascend"
        )

    axis = _axis(options.axis)
    n = int(np.floor((options.last - options.first) / options.step + 1e-9))
    heel = options.first + options.step * np.arange(n + 1)
    scene = load_scene(options.scene, options)
    hold, parameters = settings_of(scene.compile(as_given=True), options.set)

    with doing_here("finding the righting arm") as tell:
        found = scene.righting(
            options.hull, axis, heel=heel, hold=hold, parameters=parameters, time=options.time, progress=tell
        )

    note(found.notices)

    if not (csv or plot):
        numbers = ("heel, deg", "GZ, m", "trim, deg", "draught, m")
        table = table_of(*numbers, numbers=numbers)
        rows = np.unique(np.linspace(0, n, min(n + 1, MOST)).round().astype(int))

        for k in rows:
            values = (found.heel[k], found.arm[k], found.trim[k], found.draught[k])
            table.add_row(*(f"{value + 0.0:.5g}" if abs(value) > 1e-9 else "0" for value in values))

        print_table(table)
        out.print()

    say = beside(csv)

    if np.isfinite(found.arm).any():
        heel_, arm = found.largest()
        say.print(f"largest arm {arm:.6g} m at {heel_:.5g} deg, GM {found.metacentric:.6g} m")

        if arm <= 0.0:
            say.print("it rights nowhere: it capsizes")

    for angle, stable in found.rests():
        say.print(f"{'rests' if stable else 'capsizes beyond'}: {angle + 0.0:.6g} deg")

    write([(csv, found.results().to_csv), (plot, found.plot)])


def _axis(text):
    try:
        return text if text in ("x", "y") else float(text)
    except ValueError:
        raise ValueError(f"--axis {text}: write x, y, or an angle from x to y in deg") from None
