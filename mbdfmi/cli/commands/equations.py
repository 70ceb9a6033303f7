"""mbdfmi equations: a scene as functions or expressions."""

from ...files import replacing, to_standard_output
from ..arguments import add_command, add_scene
from ..paths import load_scene, writable
from ..terminal import doing_here, err, out

FORMS = {
    "c": "functions in C99",
    "numpy": "functions in Python",
    "sympy": "expressions of sympy",
    "casadi": "functions of casadi",
}


def add(commands):
    """The command and its arguments."""
    command = add_command(
        commands,
        run,
        "equations",
        "write a scene as equations",
        """x' = rates(t, x, u, p) and y = outputs(t, x, u, p) of a scene, written out with its names:
for controllers, optimisers, papers. They are what the kernels do for this scene, traced and folded, and
no longer need them. Loops are closed by multipliers. What the start finds (lengths, which rows
are redundant) stays as it is.""",
        """examples:
  mbdfmi equations arm.toml --numpy                          on the terminal
  mbdfmi equations arm.toml --casadi -o arm_model.py         for optimal control
  mbdfmi equations arm.toml --c --derivatives -o arm.c       with dx'/dx, dx'/du, dy/dx, dy/du
  mbdfmi equations arm.toml --sympy --bind --no-outputs      every parameter a number
  mbdfmi equations arm.toml --numpy --parameter forearm.mass that one free, all others numbers

`mbdfmi info SCENE --parameters` lists the parameters.""",
    )
    add_scene(command)
    form = command.add_mutually_exclusive_group(required=True)

    for name, what in FORMS.items():
        form.add_argument(f"--{name}", dest="form", action="store_const", const=name, help=what)

    command.add_argument("-o", "--output", metavar="FILE", default="-", help="where to (default: shown)")
    command.add_argument("--bind", action="store_true", help="every parameter is a number")
    command.add_argument(
        "--parameter",
        action="append",
        metavar="NAME",
        help="a parameter that stays free, all others are numbers; may be repeated (default: all that are "
        "not zero and that matter stay free)",
    )
    command.add_argument("--no-outputs", action="store_true", help="x' alone")
    command.add_argument(
        "--derivatives",
        action="store_true",
        help="exact dx'/dx, dx'/du, dy/dx, dy/du as functions too (C and numpy; sympy and casadi have their "
        "own)",
    )


def run(options):
    """Writes them."""
    if options.bind and options.parameter:
        raise ValueError("--bind makes every parameter a number; without it --parameter leaves some free")

    if options.derivatives and options.form in ("sympy", "casadi"):
        raise ValueError(f"--derivatives: for --c and --numpy; {options.form} differentiates by itself")

    path = writable(options.output, [options.scene])
    scene = load_scene(options.scene, options)

    with doing_here(f"{options.scene}: tracing"):
        found = scene.equations(
            [] if options.bind else options.parameter, not options.no_outputs, options.derivatives
        )
        text = found.text(options.form)

    if found.moving:
        listed = "; ".join(found.moving)
        err.print(
            f"{options.scene}: these equations hold only as long as, as at the start, {listed}",
            soft_wrap=True,
        )

    if to_standard_output(path):
        out.print(text, markup=False, highlight=False, soft_wrap=True, end="")
        return

    with replacing(path) as file:
        file.write_text(text, encoding="utf-8")

    out.print(f"{path}  ({len(text.splitlines())} lines)", soft_wrap=True)
