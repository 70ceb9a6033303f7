"""How commands make their parts of the parser."""

import argparse

SCENE = {"metavar": "SCENE", "help": "scene file (TOML)"}
"""What commands call a scene file."""


def add_result_files(command, what):
    """--csv and --plot, which write `what`."""
    command.add_argument("--csv", metavar="FILE", help=f"write {what} as a table; - is the standard output")
    command.add_argument("--plot", metavar="FILE", help="write them as a picture: png, svg or pdf")


def add_view(command, what):
    """--view, which writes `what` in three dimensions."""
    command.add_argument(
        "--view",
        metavar="FILE",
        help=f"write {what} to look at: .html, a page that works offline in any browser, or .glb, for "
        "Blender and others",
    )


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
