"""mbdfmi sea: the waves of a scene."""

from ..arguments import add_command, add_scene
from ..paths import load_scene, writable
from ..tables import print_table, table_of
from ..terminal import out


def add(commands):
    """The command and its arguments."""
    command = add_command(
        commands,
        run,
        "sea",
        "tell, draw and write the waves of a scene",
        """The components that the scene's [sea] is made of, drawn or read: significant height and periods by
the moments of their spectrum. Written as components, another tool can sail the same sea, and so can
another scene: waves = { components = { file = "sea.csv" } }.""",
        """examples:
  mbdfmi sea turbine.toml
  mbdfmi sea turbine.toml --plot sea.png
  mbdfmi sea turbine.toml --components sea.csv
  mbdfmi sea turbine.toml --series elevation.csv --until 3600 --step 0.25""",
    )
    add_scene(command)
    command.add_argument(
        "--components", metavar="FILE", help="write omega, amplitude, phase, direction of each as CSV"
    )
    command.add_argument(
        "--series", metavar="FILE", help="write the elevation at the origin over time as CSV"
    )
    command.add_argument(
        "--plot", metavar="FILE", help="draw spectrum, directions and elevation: png, svg or pdf"
    )
    command.add_argument("--until", type=float, default=600.0, metavar="S", help="(default: 600)")
    command.add_argument("--step", type=float, default=0.1, metavar="S", help="(default: 0.1)")


def run(options):
    """Tells the sea, writes what was asked for."""
    import numpy as np

    from ...compiler.seas import sea_components
    from ...hydro.sea_picture import draw_sea
    from ...run.results import Results

    names = {key: getattr(options, key) for key in ("components", "series", "plot")}
    files = {key: writable(name, [options.scene]) for key, name in names.items() if name}

    if not 0.0 < options.step <= options.until:
        raise ValueError(
            f"--until {options.until:g} --step {options.step:g}: needs a step of at most the time"
        )

    if "plot" in files:
        Results.check_plot(files["plot"])

    scene = load_scene(options.scene)

    if not (scene.sea and scene.sea.waves):
        raise ValueError(
            f"{options.scene}: has no waves; write [sea] waves = {{ jonswap = {{ hs = 2, tp = 8 }} }}"
        )

    waves = sea_components(scene)
    _tell(waves)

    if "components" in files:
        _write(files["components"], ["omega", "amplitude", "phase", "direction"], waves)

    if "series" in files:
        time = options.step * np.arange(int(options.until / options.step + 1e-9) + 1)
        elevation = sum(a * np.cos(w * time + e) for w, a, e, _ in zip(*waves))
        _write(files["series"], ["time", "elevation"], [time, elevation])

    if "plot" in files:
        drawn = scene.sea.waves.jonswap or scene.sea.waves.pierson_moskowitz
        spectrum = (drawn.hs, drawn.tp, getattr(drawn, "gamma", 1.0)) if drawn else None
        title = f"the sea of {scene.title or scene.name}"
        out.print(str(draw_sea(files["plot"], waves, spectrum, title)), soft_wrap=True)


def _tell(waves):
    import numpy as np

    energy = waves.amplitude**2 / 2
    moments = [energy @ waves.omega**k for k in range(3)]
    mean = np.angle(energy @ np.exp(1j * waves.heading))
    strongest = waves.omega[np.argmax(energy)]
    periods = 2 * np.pi / waves.omega
    table = table_of("the sea", "", numbers=("",))
    rows = [
        ("components", f"{len(waves.omega)}"),
        ("significant height, m", f"{4 * np.sqrt(moments[0]):.6g}"),
        ("mean period by m0 and m1, s", f"{2 * np.pi * moments[0] / moments[1]:.6g}"),
        ("zero-crossing period by m0 and m2, s", f"{2 * np.pi * np.sqrt(moments[0] / moments[2]):.6g}"),
        ("periods from, s", f"{periods.min():.6g}"),
        ("to, s", f"{periods.max():.6g}"),
        ("mean direction, deg", f"{np.degrees(mean) + 0.0:.6g}"),
    ]

    if np.ptp(energy) > 1e-9 * energy.max():
        rows.insert(4, ("period of the strongest component, s", f"{2 * np.pi / strongest:.6g}"))

    for row in rows:
        table.add_row(*row)

    print_table(table)
    out.print()


def _write(path, names, columns):
    from ...files import save_table

    save_table(path, names, columns, digits="%.17g")
    out.print(str(path), soft_wrap=True)
