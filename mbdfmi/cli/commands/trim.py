"""mbdfmi trim: what makes a scene do as asked."""

from ..arguments import add_command, add_scene, add_settings
from ..paths import load_scene, writable
from ..settings import settings_of
from ..tables import print_table, table_of
from ..terminal import doing_here, note, out


def add(commands):
    """The command and its arguments."""
    command = add_command(
        commands,
        run,
        "trim",
        "find inputs, start values and parameters for which conditions hold",
        """Unknowns are inputs, parameters, or coordinates and speeds of joints at the start; conditions are
values of outputs, of joints and bodies also of those that the scene does not ask for
(shaft.acceleration, hull.zyx[1]), and joints whose speeds shall not change. They hold at the start, or
with --rest in the static equilibrium that the scene comes to. Newton's method, from the present
values or those given; SI units. Without all these it is as the scene's [solver.trim] asks.""",
        """examples:
  mbdfmi trim turbine.toml --find shaft.torque --keep shaft.acceleration=0
  mbdfmi trim bike.toml --find lean.angle --find steer.angle=0.1 --steady lean --steady steer
  mbdfmi trim crane.toml --rest --find ballast.mass --keep hull.zyx[3]=0
  mbdfmi trim top.toml --find spin.speed --keep cone.acceleration=0 --write steady.toml""",
    )
    add_scene(command)
    command.add_argument(
        "--find",
        action="append",
        default=[],
        metavar="NAME[=GUESS]",
        help="an unknown: an input, a parameter, a joint's coordinate or speed at the start; may be repeated",
    )
    command.add_argument(
        "--keep",
        action="append",
        default=[],
        metavar="NAME=VALUE",
        help="an output and its value; may be repeated",
    )
    command.add_argument(
        "--steady",
        action="append",
        default=[],
        metavar="JOINT",
        help="a joint whose speeds shall not change, or all; may be repeated",
    )
    command.add_argument("--rest", action="store_true", help="the conditions hold in the static equilibrium")
    command.add_argument(
        "--time", type=float, default=0.0, metavar="T", help="time of drives and loads, s (default: 0)"
    )
    command.add_argument("--write", metavar="FILE", help="write the scene with the start that was found")
    add_settings(command)


def run(options):
    """Finds them, tells them."""
    find = dict(_pair("--find", text, needs=False) for text in options.find) or None
    keep = dict(_pair("--keep", text) for text in options.keep)
    own = options.write == options.scene
    write = options.write and (options.write if own else writable(options.write, []))
    scene = load_scene(options.scene, options)

    if write and scene.imported:
        raise ValueError(f"--write: {options.scene} is a robot; write it as a scene first (mbdfmi import)")

    hold, parameters = settings_of(scene.compile(as_given=True), options.set)
    steady = True if options.steady == ["all"] else options.steady

    if find is None and (keep or steady or options.rest or not scene.solver.trim):
        raise ValueError(
            f"{options.scene}: --find NAME: says what is to be found; or a table [solver.trim] in the scene"
        )

    with doing_here("trimming") as tell:
        found = scene.trim(
            find,
            keep,
            steady=steady,
            rest=options.rest,
            hold=hold,
            parameters=parameters,
            time=options.time,
            progress=tell,
        )

    table = table_of("found", "value", "unit", numbers=("value",))

    for name, value in found.values.items():
        table.add_row(name, f"{value:.12g}", found.units.get(name) or "")

    print_table(table)

    if found.conditions:
        table = table_of("kept", "asked for", "found", "unit", numbers=("asked for", "found"))

        for name, (wanted, value) in found.conditions.items():
            table.add_row(name, f"{wanted:.9g}", f"{value:.9g}", found.units.get(name) or "")

        print_table(table)

    out.print()
    out.print(f"found in {found.iterations} steps, off by at most {found.error:.1g}")

    if found.unsteady:
        rates = ", ".join(f"{name} by {rate:.3g}" for name, rate in list(found.unsteady.items())[:4])
        out.print(f"not steady: a second changes {rates}")

    note(found.notices)

    if write:
        from ...scene.rewriter import rewritten

        out.print(str(rewritten(options.scene, scene, found.scene, write)), soft_wrap=True)
        left = [f"--set {name}={found.values[name]!r}" for name in found.values if not _starts(name)]

        if left:
            note([f"a start holds no inputs and parameters; run it with {' '.join(left)}"])


def _starts(name):
    return name.split("[")[0].endswith("_start")


def _pair(option, text, needs=True):
    """(name, number or None) of NAME=NUMBER."""
    name, equals, number = text.rpartition("=")

    if not equals and not needs:
        return text, None

    try:
        value = float(number)
    except ValueError:
        name = ""

    if not name:
        raise ValueError(f"{option} {text}: write NAME=NUMBER, as in {option} shaft.speed=1.2")

    return name, value
