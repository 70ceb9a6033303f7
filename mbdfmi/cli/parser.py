"""The command line's parser, of the commands' parts."""

import argparse
from importlib import import_module

from .. import __version__

COMMANDS = (
    "export",
    "simulate",
    "view",
    "inverse",
    "equilibrium",
    "gz",
    "trim",
    "modes",
    "sea",
    "hydro",
    "rao",
    "moorings",
    "rotor",
    "equations",
    "couple",
    "info",
    "check",
    "bench",
    "import",
)
"""Each is a module of commands/, in the order of the help; a word of Python's has a _ behind it there."""


def parser(command: str | None = None) -> argparse.ArgumentParser:
    """The parser of the whole command line, or, where its first word is a command, of that command alone."""
    whole = argparse.ArgumentParser(
        prog="mbdfmi",
        description="A multibody scene in, a native FMU out: FMI 2.0 or 3.0, co-simulation, model exchange.",
        epilog="""a first try:
  mbdfmi info models/pendulum.toml                       what is in it
  mbdfmi view models/pendulum.toml                       what it looks like, in the browser
  mbdfmi simulate models/pendulum.toml --until 10        how it moves
  mbdfmi export models/pendulum.toml                     pendulum.fmu, for any FMI tool

`mbdfmi COMMAND --help` says more about each command.""",
        formatter_class=argparse.RawDescriptionHelpFormatter,
    )
    whole.add_argument("--version", action="version", version=f"mbdfmi {__version__}")
    commands = whole.add_subparsers(required=True, metavar="COMMAND")

    for name in [command] if command in COMMANDS else COMMANDS:
        module = "import_" if name == "import" else name
        import_module(f".commands.{module}", __package__).add(commands)

    return whole
