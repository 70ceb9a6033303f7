"""How commands make their parts of the parser."""

import argparse

SCENE = {"metavar": "SCENE", "help": "scene file (TOML), or a robot (URDF)"}
"""What commands call a scene file."""

URDF = "of a robot (URDF), see docs/urdf.md"


def add_scene(command, name="scene", **more):
    """The scene that a command reads, and how it reads that of a robot."""
    command.add_argument(name, **SCENE, **more)
    add_urdf(command.add_argument_group(URDF))


def add_urdf(group):
    """Options of URDF files; `paths.load_scene` takes them."""
    group.add_argument(
        "--base", choices=("fixed", "free"), help="whether the ground holds its root link (default: fixed)"
    )
    group.add_argument(
        "--stop-stiffness",
        metavar="K[,K]",
        help="makes stops of its limits of position: N m/rad of revolute joints, N/m of prismatic ones, one "
        "number or one for each (default: no stops, a URDF file does not say how stiff they are)",
    )
    group.add_argument(
        "--stop-damping", metavar="D[,D]", help="of these stops: N m s/rad, N s/m (default: 0)"
    )
    group.add_argument(
        "--package",
        action="append",
        metavar="NAME=DIR",
        help="the folder that package://NAME/... means; may be repeated (default: the folder of that name "
        "above the file, or in ROS_PACKAGE_PATH)",
    )
    group.add_argument("--no-looks", action="store_true", help="leave out what it looks like")


def urdf_options(options):
    """What was said of URDF files, as `mbdfmi.load` takes it. Raises ValueError."""
    found = {key: getattr(options, key, None) for key in ("base", "stop_stiffness", "stop_damping")}
    found = {key: value for key, value in found.items() if value is not None}

    for key in ("stop_stiffness", "stop_damping"):
        if key in found:
            found[key] = _one_or_two(key, found[key])
    if getattr(options, "no_looks", False):
        found["looks"] = False
    if given := getattr(options, "package", None):
        found["packages"] = dict(map(_package, given))

    return found


def _one_or_two(key, text):
    try:
        numbers = tuple(float(number) for number in text.split(","))
    except ValueError:
        numbers = ()

    if len(numbers) not in (1, 2):
        option = f"--{key.replace('_', '-')}"
        raise ValueError(
            f"{option} {text}: write a number, or two with a comma between: of revolute, of prismatic joints"
        )

    return numbers if len(numbers) == 2 else numbers[0]


def _package(text):
    name, _, folder = text.partition("=")
    if not (name and folder):
        raise ValueError(f"--package {text}: write NAME=DIR, as in --package panda_description=robots/panda")
    return name, folder


def add_result_files(command, what):
    """--csv and --plot, which write `what`."""
    command.add_argument("--csv", metavar="FILE", help=f"write {what} as a table; - is the standard output")
    command.add_argument("--plot", metavar="FILE", help="write them as a picture: png, svg or pdf")


def add_view(command, what):
    """--view, which writes `what` in three dimensions."""
    command.add_argument(
        "--view",
        metavar="FILE",
        help=f"write {what} to look at: .html, a page that works offline in any browser, .glb, for "
        "Blender and others, or .png, a picture",
    )
    command.add_argument("--at", type=float, metavar="T", help="time of the picture, s (default: the last)")


def add_settings(command):
    """--set NAME=VALUE."""
    command.add_argument(
        "--set",
        action="append",
        default=[],
        metavar="NAME=VALUE",
        help="hold an input at a value, or change a parameter; an array takes its name and numbers with "
        "commas",
    )


def add_command(commands, run, name, text, more, examples=None):
    """The parser of a command that calls `run`: `text` says what it does, `more` how, examples follow."""
    command = commands.add_parser(
        name,
        help=text,
        description=f"{text[0].upper()}{text[1:]}.\n\n{more}",
        epilog=examples,
        formatter_class=argparse.RawDescriptionHelpFormatter,
    )
    command.set_defaults(run=run)
    return command
