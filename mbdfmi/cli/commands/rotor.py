"""mbdfmi rotor: the table of a rotor in the wind, by blade elements."""

from pathlib import Path

from ..arguments import add_command
from ..paths import writable
from ..tables import print_table, table_of
from ..terminal import note, out


def add(commands):
    """The command and its arguments."""
    command = add_command(
        commands,
        run,
        "rotor",
        "make the table of thrust and torque of a rotor",
        """The blade's stations and a polar for each section become thrust and torque coefficients over tip
        speed
ratio and pitch, by blade elements and momentum in steady wind along the axis. A scene reads the
table: rotor = { radius = 63, table = "rotor.csv" }.

BLADE is a CSV file with a line of names, then radius (m), chord (m), twist (deg) and the name of a
polar; POLAR one with angle of attack (deg), C_L, C_D, whose name is that of the file without its
ending.""",
        """examples:
  mbdfmi rotor blade.csv cylinder.csv du40.csv naca64.csv --radius 63 --hub 1.5 -o rotor.csv
  mbdfmi rotor blade.csv foil.csv --ratio 1:14:27 --pitch 0:30:16 -o rotor.csv --plot rotor.png""",
    )
    command.add_argument("blade", metavar="BLADE", help="stations of a blade (CSV)")
    command.add_argument("polars", metavar="POLAR", nargs="+", help="polars that it names (CSV)")
    command.add_argument("-o", dest="output", metavar="FILE", required=True, help="write the table (CSV)")
    command.add_argument(
        "--radius", type=float, metavar="M", help="of the tip (default: half a station beyond the last)"
    )
    command.add_argument(
        "--hub", type=float, metavar="M", help="radius of the hub (default: half a station before the first)"
    )
    command.add_argument("--blades", type=int, default=3, metavar="N", help="(default: 3)")
    command.add_argument(
        "--ratio", default="1:14:27", metavar="A:B:N", help="tip speed ratios (default: 1:14:27)"
    )
    command.add_argument(
        "--pitch", default="0:30:16", metavar="A:B:N", help="of the blades, deg (default: 0:30:16)"
    )
    command.add_argument("--plot", metavar="FILE", help="draw power and thrust: png, svg or pdf")


def run(options):
    """Makes the table, tells, writes and draws it."""
    import numpy as np

    from ...aero.blades import read_blade, read_polar
    from ...files import save_table
    from ...run.results import Results

    given = [options.blade, *options.polars]
    target = writable(options.output, given)
    plot = writable(options.plot, [*given, target]) if options.plot else None

    if plot:
        Results.check_plot(plot)
    if options.blades < 1:
        raise ValueError(f"--blades {options.blades}: needs one at least")

    ratio, pitch = _range("--ratio", options.ratio), _range("--pitch", options.pitch)

    if not ratio[0] > 0.0:
        raise ValueError(f"--ratio {options.ratio}: tip speed ratios are positive")

    polars = {Path(name).stem: read_polar(name) for name in options.polars}
    rotor = read_blade(options.blade, polars, options.radius, options.hub, options.blades)
    thrust, torque, reach = rotor.coefficients(ratio, np.radians(pitch))
    _tell_reach(options, rotor, reach)
    power = torque * ratio[:, None]
    j, k = np.unravel_index(np.argmax(power), power.shape)
    table = table_of("the rotor", "", numbers=("",))

    for row in (
        ("radius, m", f"{rotor.tip:.6g}"),
        ("largest C_P", f"{power[j, k]:.4f}"),
        ("at tip speed ratio", f"{ratio[j]:.4g}"),
        ("at pitch, deg", f"{pitch[k] + 0.0:.4g}"),
        ("C_T there", f"{thrust[j, k]:.4f}"),
    ):
        table.add_row(*row)

    print_table(table)
    grid = np.meshgrid(ratio, np.radians(pitch), indexing="ij")

    names = ["tip_speed_ratio", "blade_pitch_rad", "C_T", "C_Q"]
    columns = [column.ravel() for column in (*grid, thrust, torque)]
    save_table(target, names, columns, digits=["%.6g", "%.9f", "%.7f", "%.7f"])
    out.print(str(target), soft_wrap=True)

    if plot:
        out.print(str(_draw(plot, ratio, pitch, power, thrust)), soft_wrap=True)


def _range(option, text):
    """(n,) numbers that ascend. Raises ValueError."""
    import numpy as np

    try:
        first, last, count = text.split(":")
        found = np.linspace(float(first), float(last), int(count))
    except ValueError:
        raise ValueError(f"{option} {text}: write FIRST:LAST:NUMBER") from None

    if len(found) < 4 or not np.isfinite(found).all() or not found[-1] > found[0]:
        raise ValueError(f"{option} {text}: needs at least 4 values that ascend")

    return found


def _tell_reach(options, rotor, reach):
    """A note of polars that end before the blade's angles of attack do."""
    import numpy as np

    low, high = np.degrees(reach)

    for polar in {p.name: p for p in rotor.polars}.values():
        first, last = np.degrees(polar.alpha[[0, -1]])

        if first > max(low, -180.0) + 1e-6 or last < min(high, 180.0) - 1e-6:
            note([
                f"{options.blade}: angles of attack reach from {low:.3g} to {high:.3g} deg; the polar "
                f"{polar.name} ends at {first:.4g} and {last:.4g} deg, and holds there"
            ])  # fmt: skip


def _draw(path, ratio, pitch, power, thrust):
    """C_P and C_T over the tip speed ratio, a curve for some of the pitches."""
    import numpy as np
    from matplotlib.figure import Figure

    from ...files import save_figure

    figure = Figure(figsize=(10, 4.5), layout="constrained")

    for axes, values, name in zip(figure.subplots(1, 2), (power, thrust), ("C_P", "C_T")):
        for k in np.unique(np.linspace(0, len(pitch) - 1, min(len(pitch), 9)).round().astype(int)):
            axes.plot(ratio, values[:, k], linewidth=1.2, label=f"{pitch[k]:.3g} deg")

        axes.set_ylim(min(0.0, max(values.min(), -0.1)), None)
        axes.set_title(name, loc="left", fontsize="medium")
        axes.set_xlabel("tip speed ratio")
        axes.grid(alpha=0.3)

    axes.legend(fontsize="small", title="pitch")
    save_figure(figure, path)
    return path
