"""mbdfmi equilibrium: where a scene comes to rest."""

import math

from ..arguments import add_command, add_scene, add_settings
from ..paths import check_looks, load_scene, view_file, writable
from ..settings import settings_of
from ..tables import print_table, table_of, vector
from ..terminal import doing_here, note, out

STABLE = {True: "stable", False: "not stable", None: "stable, but for motions without stiffness"}


def add(commands):
    """The command and its arguments."""
    command = add_command(
        commands,
        run,
        "equilibrium",
        "find where a scene comes to rest",
        """From its start downhill, as if all of it moved in thick oil: with all speeds 0, drives held where
they are, inputs at their start values (or as --set says), loads as they are at --time. Loops, stops,
ropes and contacts are kept to. It tells whether the equilibrium is stable, else by which motion it
is lost, and what joints bear there. Where there is none, it tells what moves away.""",
        """examples:
  mbdfmi equilibrium crane.toml
  mbdfmi equilibrium crane.toml --set hook.force=0,0,-2e5 --view rest.html
  mbdfmi equilibrium crane.toml --write rest.toml          the scene, starting there
  mbdfmi equilibrium crane.toml --write crane.toml         into the file itself
  mbdfmi equilibrium arch.toml --all                       all that are found, unstable ones too""",
    )
    add_scene(command)
    command.add_argument(
        "--time", type=float, default=0.0, metavar="T", help="time of drives and loads, s (default: 0)"
    )
    command.add_argument(
        "--weather",
        action="store_true",
        help="with the waves of that time and the steady wind, which are left out otherwise",
    )
    command.add_argument(
        "--nearest", action="store_true", help="take the first that is found, also where it is not stable"
    )
    command.add_argument(
        "--all", action="store_true", help="look for all from drawn starts; there may be others yet"
    )
    command.add_argument("--starts", type=int, metavar="N", help="how many starts --all draws (default: 40)")
    command.add_argument(
        "--write",
        metavar="FILE",
        help="write the scene with the equilibrium as its start; may be its own file",
    )
    command.add_argument("--view", metavar="FILE", help="write it to look at: .html, .glb or .png")
    add_settings(command)


def run(options):
    """Finds it, tells and writes it."""
    own = options.write == options.scene
    write = options.write and (options.write if own else writable(options.write, []))
    shown = view_file(options.view, None, options.scene, *([write] if write else []))
    scene = load_scene(options.scene, options)

    if options.all and (write or shown or options.nearest):
        raise ValueError("--all: lists equilibria; --write, --view and --nearest are for one")
    if options.starts is not None and (not options.all or options.starts < 1):
        raise ValueError(f"--starts {options.starts}: is how many starts --all draws, 1 or more")
    if write and scene.imported:
        raise ValueError(f"--write: {options.scene} is a robot; write it as a scene first (mbdfmi import)")
    if shown:
        check_looks(options.scene, scene)

    hold, parameters = settings_of(scene.compile(as_given=True), options.set)
    asked = {"hold": hold, "parameters": parameters, "time": options.time, "weather": options.weather}

    with doing_here("looking for the equilibrium") as tell:
        if options.all:
            n = {"n": options.starts} if options.starts else {}
            found = scene.equilibria(progress=tell, **n, **asked)
        else:
            found = [scene.equilibrium(nearest=options.nearest, progress=tell, **asked)]

    for k, one in enumerate(found, 1):
        if options.all:
            out.print(f"{k} of {len(found)}: ", end="", style="bold")

        _print(one, scene, not options.all)
        note(one.notices)

    if write:
        from ...scene.rewriter import rewritten

        out.print(str(rewritten(options.scene, scene, found[0].scene, write)), soft_wrap=True)

    if shown:
        from ...view.runs import at_start
        from ...view.show import show

        run_ = at_start(found[0].scene.compile(), parameters, hold)
        out.print(str(show(run_, shown, tell=lambda text: note([text]))), soft_wrap=True)


def _print(found, scene, whole):
    """One equilibrium."""
    out.print(STABLE[found.stable])

    for motion in found.motions:
        out.print(f"  {motion}")

    table = table_of("joint", "value", "unit", "in deg", numbers=("value", "in deg"))

    for name, value in found.coordinates.items():
        unit = found.units.get(name) or ""
        table.add_row(
            name, f"{value + 0.0:.9g}", unit, f"{math.degrees(value) + 0.0:.6g}" if unit == "rad" else ""
        )

    print_table(table)

    if not whole:
        out.print()
        return

    if found.efforts:
        table = table_of("effort", "value", "unit", numbers=("value",))

        for name, value in found.efforts.items():
            table.add_row(name, f"{value:.6g}", found.units.get(name) or "")

        print_table(table)

    if found.reactions:
        table = table_of("reaction of", "force, N", "moment, N m")
        size = max(abs(value) for force, *_ in found.reactions.values() for value in force)

        for name, (force, *rest) in found.reactions.items():
            moment = _rounded(rest[0], size) if rest else ""
            table.add_row(name, _rounded(force, size), moment)

        print_table(table)

    if found.outputs:
        table = table_of("output", "value", "unit", numbers=("value",))

        for name, value in found.outputs.items():
            table.add_row(name, f"{value + 0.0:.6g}", found.units.get(name) or "")

        print_table(table)

    out.print()
    out.print(f"found in {found.iterations} steps, known to {found.error:.1g} rad or lengths of the scene")


def _rounded(values, size):
    """A vector whose rounding is 0."""
    return vector([0.0 if abs(value) < 1e-12 * size else value for value in values])
