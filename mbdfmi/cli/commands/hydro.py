"""mbdfmi hydro: coefficients of a hull in waves, by capytaine, or of a file."""

from pathlib import Path

from ..arguments import add_command
from ..paths import writable
from ..tables import print_table, table_of
from ..terminal import doing, note, out


def add(commands):
    """The command and its arguments."""
    command = add_command(
        commands,
        run,
        "hydro",
        "find added mass, damping and wave loads of a hull",
        """A hull's surface in triangles (STL, OBJ, ...; z up, the water plane at z = 0) is cut there, made
        as fine
as the shortest wave needs, and solved by capytaine: linear potential theory on panels. Written as
NAME.1 with NAME.3 beside it (WAMIT's files) or as NAME.nc (capytaine's), which a scene reads:
hydrodynamics = { file = "barge.1" }. What is solved is kept: a run that was cut off goes on.
The first run makes capytaine's table of Green's function, a minute or so.

Of a file of coefficients (.1, .nc, .h5, .tec) it tells what is in it, checks and draws it.

Needs capytaine: pip install "mbdfmi[hydro]".""",
        """examples:
  mbdfmi hydro barge.stl -o barge.1
  mbdfmi hydro barge.stl -o barge.nc --omega 0.05:3:40 --heading 0:180:15 --depth 150 --lid
  mbdfmi hydro barge.1 --plot barge.png                       look at what was found""",
    )
    command.add_argument("file", metavar="MESH", help="surface of a hull, or a file of coefficients")
    command.add_argument("-o", dest="output", metavar="FILE", help="write NAME.1 and NAME.3, or NAME.nc")
    command.add_argument(
        "--omega",
        default="0.1:2:20",
        metavar="A:B:N",
        help="frequencies, rad/s: N from A to B, or one by one with commas (default: 0.1:2:20)",
    )
    command.add_argument(
        "--heading",
        default="0:180:30",
        metavar="A:B:STEP",
        help="ways that waves travel, deg (default: 0:180:30)",
    )
    command.add_argument("--depth", type=float, metavar="M", help="of the water (default: deep)")
    command.add_argument("--density", type=float, default=1025.0, metavar="KG/M3", help="(default: 1025)")
    command.add_argument("--gravity", type=float, default=9.81, metavar="M/S2", help="(default: 9.81)")
    command.add_argument(
        "--reference",
        default="0,0,0",
        metavar="X,Y,Z",
        help="point that the coefficients are about, m (default: the origin)",
    )
    command.add_argument(
        "--scale",
        type=float,
        default=1.0,
        metavar="M",
        help="unit of the mesh; of WAMIT's files ULEN (default: 1)",
    )
    command.add_argument(
        "--panel",
        type=float,
        metavar="M",
        help="longest edge of a panel (default: an eighth of the shortest wave)",
    )
    command.add_argument(
        "--lid",
        action="store_true",
        help="close the water plane inside, which keeps irregular frequencies away",
    )
    command.add_argument("--plot", metavar="FILE", help="draw them: png, svg or pdf")


def run(options):
    """Solves, or reads; tells, writes and draws."""
    from ...hydro.consistency import disagreements, told_spikes
    from ...hydro.memory import fit
    from ...hydro.picture import draw_coefficients
    from ...hydro.reading import ENDINGS
    from ...hydro.writing import ENDINGS as WRITTEN
    from ...hydro.writing import write_coefficients
    from ...run.results import Results

    plot = (
        writable(options.plot, [options.file, *([options.output] if options.output else [])])
        if options.plot
        else None
    )

    if plot:
        Results.check_plot(plot)
    if not options.density > 0.0 or not options.gravity > 0.0 or not options.scale > 0.0:
        raise ValueError("--density, --gravity and --scale must be positive")

    is_database = Path(options.file).suffix.lower() in ENDINGS

    if is_database and options.output:
        raise ValueError(f"{options.file}: holds coefficients already; -o is for those of a mesh")
    if not is_database and not options.output:
        raise ValueError("-o FILE: name a file for the coefficients, as in -o barge.1")

    target = None if is_database else writable(options.output, [options.file])

    if target and target.suffix.lower() not in WRITTEN:
        raise ValueError(f"{target}: is to end in {' or '.join(WRITTEN)}")

    coefficients = _read(options) if is_database else _solved(options)
    coefficients, notes = coefficients.checked()
    notes += told_spikes(coefficients) + disagreements(
        coefficients, options.density, options.gravity, options.depth
    )
    note(f"{options.file}: {text}" for text in notes)
    _tell(coefficients)

    if target:
        write_coefficients(target, coefficients, options.density, options.gravity)
        out.print(str(target), soft_wrap=True)

    if plot:
        memory = fit(coefficients)
        states = f"memory of {len(memory.pole)} states, within {100 * memory.error:.2g} % of the peaks"
        title = f"{Path(options.file).name}: dots; lines: {states}"
        out.print(str(draw_coefficients(plot, coefficients, memory, title)), soft_wrap=True)


def _read(options):
    from ...hydro.reading import read_coefficients

    return read_coefficients(Path(options.file), options.density, options.gravity, options.scale)


def _solved(options):
    """Coefficients of a mesh."""
    from ...hydro.panels import Problem, hydrostatic_heave, panel_edge, solve, wet_part

    if options.depth is not None and not options.depth > 0.0:
        raise ValueError(f"--depth {options.depth:g}: must be positive")

    omega, headings = frequencies(options.omega), directions(options.heading)
    problem = Problem(
        omega,
        headings,
        options.density,
        options.gravity,
        options.depth,
        point(options.reference),
        options.lid,
    )
    wet = wet_part(options.file, options.scale)
    longest = options.panel or panel_edge(omega, options.depth, options.gravity)

    if not longest > 0.0:
        raise ValueError(f"--panel {longest:g}: must be positive")
    if options.depth is not None and wet.vertices[:, 2].min() <= -options.depth:
        raise ValueError(
            f"--depth {options.depth:g}: the hull reaches down to {-wet.vertices[:, 2].min():g} m"
        )

    wet = wet.finer(longest)
    x, y, z = wet.center
    out.print(
        f"{len(wet.faces)} panels, edges up to {wet.edge:.3g} m; displaces {wet.volume:.6g} m3, centre "
        f"({x + 0.0:.4g}, {y + 0.0:.4g}, {z:.4g}) m, water plane {wet.waterplane:.6g} m2"
    )

    with doing("solving") as tell:
        coefficients = solve(wet, problem, lambda part, words: tell(f"{words}, {100 * part:.0f} % done"))

    # waves that are long beside the hull
    if wet.waterplane > 0.0 and omega[0] ** 2 * wet.waterplane**0.5 < 0.5 * options.gravity:
        off = hydrostatic_heave(coefficients, wet.waterplane, options.density, options.gravity)
        out.print(f"heave by the longest waves: {1 + off:.4f} of rho g times the water plane")

    return coefficients


def frequencies(text):
    """(n,) rad/s, ascending. Raises ValueError."""
    import numpy as np

    try:
        if ":" in text:
            first, last, count = text.split(":")
            found = np.linspace(float(first), float(last), int(count))
        else:
            found = np.array([float(word) for word in text.split(",")])
    except ValueError:
        raise ValueError(f"--omega {text}: write FIRST:LAST:NUMBER, or numbers with commas between") from None

    if (
        len(found) < 4
        or not found.min() > 0.0
        or not (np.diff(found) > 0.0).all()
        or not np.isfinite(found).all()
    ):
        raise ValueError(f"--omega {text}: needs at least 4 frequencies above 0 that ascend")

    return found


def directions(text):
    """(h,) rad. Raises ValueError."""
    import numpy as np

    try:
        if ":" in text:
            first, last, step = (float(word) for word in text.split(":"))
            found = first + step * np.arange(int(np.floor((last - first) / step + 1e-9)) + 1)
        else:
            found = np.array([float(word) for word in text.split(",")])
    except (ValueError, ZeroDivisionError, OverflowError):
        raise ValueError(
            f"--heading {text}: write FIRST:LAST:STEP in deg, or numbers with commas between"
        ) from None

    if (
        not len(found)
        or not (np.diff(found) > 0.0).all()
        or np.ptp(found) >= 360.0
        or not np.isfinite(found).all()
    ):
        raise ValueError(f"--heading {text}: needs directions that ascend, within one turn")

    return np.radians(found)


def point(text):
    """(x, y, z). Raises ValueError."""
    try:
        x, y, z = (float(word) for word in text.split(","))
    except ValueError:
        raise ValueError(f"--reference {text}: write X,Y,Z in m") from None

    return x, y, z


def _tell(coefficients):
    """What of the coefficients fits on a terminal."""
    import numpy as np

    from ...hydro.database import DOFS
    from ...hydro.memory import Kernel
    from ...hydro.picture import scatter

    names = ("motion", "A longest", "A infinite", "its scatter", "B peak", "at, rad/s", "waves, peak")
    table, off, infinite = (
        table_of(*names, numbers=names[1:]),
        scatter(coefficients),
        Kernel(coefficients).infinite,
    )

    for k, motion in enumerate(DOFS):
        damping = coefficients.damping[:, k, k]
        force = np.abs(coefficients.excitation[..., k]).max() if coefficients.excitation is not None else None
        table.add_row(
            motion,
            f"{coefficients.added[0, k, k]:.5g}",
            f"{infinite[k, k]:.5g}",
            f"{100 * off[k]:.2g} %" if np.isfinite(off[k]) else "",
            f"{damping.max():.4g}",
            f"{coefficients.omega[damping.argmax()]:.4g}",
            "" if force is None else f"{force:.4g}",
        )

    print_table(table)
    headings = "" if coefficients.headings is None else f", {len(coefficients.headings)} headings"
    out.print(
        f"{len(coefficients.omega)} frequencies from {coefficients.omega[0]:.4g} to "
        f"{coefficients.omega[-1]:.4g} rad/s{headings}; SI units"
    )
