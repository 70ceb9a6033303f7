"""mbdfmi modes: frequencies, damping, shapes of small motions."""

import math

from ..arguments import add_command, add_scene, add_settings
from ..paths import check_looks, load_scene, view_file, writable
from ..settings import settings_of
from ..show_results import beside, write
from ..tables import print_table, table_of
from ..terminal import doing_here, note, out

MOST_ROWS = 60

# shares below this part are not shown, and how many at most
SHARE = 0.02
SHARES = 2

# modes in the table of sensitivities
SHOWN = 8


def add(commands):
    """The command and its arguments."""
    command = add_command(
        commands,
        run,
        "modes",
        "find frequencies, damping and shapes of small motions",
        """The scene is linearised about a state, on its constraints, in as many coordinates as it has
freedoms: x' = A x + B u, y = C x + D u. The state is the equilibrium near the start where the
scene starts at rest, else the start itself: a vehicle at its speed, a rotor that spins. --at says
otherwise. A mode that grows has negative damping. What nothing calls back (a wheel's angle,
the place of a vehicle) is no mode; it is told.""",
        """examples:
  mbdfmi modes turbine.toml
  mbdfmi modes arm.toml --at 2.5                                       2.5 s into its run
  mbdfmi modes car.toml --view modes.html                              the shapes, swinging
  mbdfmi modes bike.toml --over forward.speed_start=0:10:41 --plot locus.png
  mbdfmi modes car.toml --by strut.stiffness --by body.mass            what its frequencies depend on
  mbdfmi modes arm.toml -o arm.mat                                     A, B, C, D for MATLAB

`mbdfmi info SCENE --parameters` lists what --set and --over can change.""",
    )
    add_scene(command)
    command.add_argument(
        "--at", metavar="WHERE", help="equilibrium, start, or a time of the run from the start, s"
    )
    command.add_argument(
        "--axes",
        choices=("auto", "body", "inertial"),
        default="auto",
        help="axes of deviations of spherical and free joints: the body's, those of the joint's first side, "
        "or those in which the motion is steady (default: auto)",
    )
    command.add_argument(
        "--over",
        metavar="NAME=A:B:N",
        help="eigenvalues over N values from A to B of a parameter or an input: the root locus (--plot)",
    )
    command.add_argument(
        "--by",
        action="append",
        default=[],
        metavar="NAME",
        help="tell how frequencies change with a parameter, in %% by %%; may be repeated",
    )
    command.add_argument("--plot", metavar="FILE", help="draw the eigenvalues: png, svg or pdf")
    command.add_argument("--csv", metavar="FILE", help="write the root locus as a table")
    command.add_argument(
        "-o", "--output", metavar="FILE", help="write A, B, C, D and names: .npz (numpy) or .mat (MATLAB)"
    )
    command.add_argument("--view", metavar="FILE", help="write the shapes to look at: .html, .glb or .png")
    command.add_argument(
        "--mode",
        type=int,
        action="append",
        metavar="K",
        help="show mode K there (default: all); may be repeated",
    )
    add_settings(command)


def run(options):
    """Finds and shows them."""
    plot = options.plot and writable(options.plot, [options.scene])
    csv = options.csv and writable(options.csv, [options.scene])
    output = options.output and writable(options.output, [options.scene])
    shown = view_file(options.view, None, options.scene)

    if output:
        from ...analysis.linear import check_matrices

        check_matrices(output)

    if csv and not options.over:
        raise ValueError("--csv: is the table of a root locus; add --over NAME=A:B:N")
    if options.mode and not shown:
        raise ValueError("--mode: says which shapes to show; add --view FILE.html")

    over = options.over and _range(options.over)
    scene = load_scene(options.scene, options)

    if shown:
        check_looks(options.scene, scene)

    hold, parameters = settings_of(scene.compile(as_given=True), options.set)
    asked = {"axes": options.axes, "hold": hold, "parameters": parameters}

    if over:
        if output or shown:
            raise ValueError(
                "--over: draws (--plot) or tabulates (--csv) eigenvalues; -o and --view are for one state"
            )

        _over(scene, over, options.at, asked, plot, csv)
        return

    with doing_here("linearising") as tell:
        wanted = None if output else []
        linear = scene.linearise(wanted, wanted, options.at, by=options.by, progress=tell, **asked)
        modes = linear.modes()

    out.print(f"about {linear.where}")
    _print(modes)

    if options.by:
        _print_sensitivities(modes)

    note(modes.notices)

    if output:
        out.print(str(linear.save(output)), soft_wrap=True)

    if plot:
        import numpy as np

        from ...analysis.locus import Locus

        values = modes.eigenvalues[len(modes.free) :]
        out.print(str(Locus("", None, np.zeros(1), values[None, :], linear.title).plot(plot)), soft_wrap=True)

    if shown:
        from ...analysis.shapes import shapes
        from ...view.runs import Run
        from ...view.show import show

        found = Run.of(shapes(modes, options.mode))
        out.print(str(show(found, shown, tell=lambda text: note([text]))), soft_wrap=True)


def _range(text):
    """(name, values) of NAME=A:B:N."""
    import numpy as np

    name, _, numbers = text.rpartition("=")

    try:
        first, last, n = numbers.split(":")
        values = np.linspace(float(first), float(last), int(n))
    except ValueError:
        values = np.zeros(0)

    if not name or not len(values) or not np.isfinite(values).all():
        raise ValueError(f"--over {text}: write NAME=A:B:N, as in --over forward.speed_start=0:10:41")

    return name, values


def _over(scene, over, at, asked, plot, csv):
    """The root locus, to files or as a table."""
    from ...analysis.locus import locus

    name, values = over

    with doing_here("linearising") as tell:
        found = locus(scene, name, values, at, progress=tell, **asked)

    note(found.notices)
    if not (plot or csv):
        table = table_of(name, "eigenvalues, 1/s", numbers=(name,))

        for value, roots in zip(values, found.eigenvalues):
            table.add_row(f"{value:g}", ", ".join(_complex(root) for root in roots if root.imag >= 0.0))

        print_table(table)

    for value, root in found.crossings():
        beside(csv).print(f"{name} = {value:.6g}: stability changes, at {root.imag / (2 * math.pi):.4g} Hz")

    write([(csv, found.to_csv), (plot, found.plot)])


def _complex(value):
    return f"{value.real:.5g}" if value.imag == 0.0 else f"{value.real:.5g} ± {value.imag:.5g}i"


def _print(modes):
    """The table of the modes."""
    numbers = ("mode", "frequency, Hz", "damping, %", "growth, 1/s")
    table = table_of(*numbers, "motion", "joints", "bodies", numbers=numbers)
    table.columns[len(numbers)].overflow = "fold"

    for k, mode in enumerate(modes.modes[:MOST_ROWS], 1):
        table.add_row(
            str(k),
            f"{mode.damped_frequency:.6g}" if mode.oscillates else "",
            f"{100 * mode.damping:.4g}" if mode.oscillates else "",
            f"{mode.eigenvalue.real + 0.0:.4g}",
            _motion(modes, mode),
            _shares(mode.joints),
            _shares(mode.bodies),
        )

    if not len(modes):
        out.print("no modes: nothing swings, grows or dies away")
        return

    print_table(table)

    if len(modes) > MOST_ROWS:
        out.print(f"and {len(modes) - MOST_ROWS} more")

    grow = [str(k) for k, mode in enumerate(modes, 1) if not mode.stable]

    if grow:
        several = len(grow) > 1
        out.print(f"not stable: mode{'s' * several} {', '.join(grow)} grow{'s' * (not several)}")


def _print_sensitivities(modes):
    """How frequencies change with parameters."""
    found = modes.linear.sensitivities
    which = [k for k, mode in enumerate(modes) if mode.oscillates][:SHOWN]
    headings = [f"mode {k + 1}" for k in which]
    table = table_of("frequency, % by % of", "value", *headings, numbers=("value", *headings))

    for name, value, parts in zip(found.names, found.values, found.relative(modes).T):
        table.add_row(name, f"{value:.6g}", *(f"{parts[k] + 0.0:.4g}" for k in which))

    print_table(table)


def _motion(modes, mode):
    """The coordinates that move most, those apart that are only led along."""
    manifold, led = modes.linear.manifold, set(modes.free)
    own = [k for k, named in enumerate(manifold.named) if named.position not in led]
    sizes = abs(mode.shape) / manifold.unit
    most = sizes[own].max(initial=0.0)
    order = [k for k in sorted(own, key=lambda k: -sizes[k]) if sizes[k] >= 0.3 * most][:SHARES]
    return ", ".join(manifold.named[k].position for k in order)


def _shares(shares):
    told = [(name, share) for name, share in shares.items() if share >= SHARE][:SHARES]
    return ", ".join(f"{name} {100 * share:.0f} %" for name, share in told)
