"""The command line's parser, of the commands' parts."""

import argparse

from .. import __version__
from .commands import (
    bench,
    check,
    couple,
    equations,
    equilibrium,
    export,
    gz,
    hydro,
    import_,
    info,
    inverse,
    modes,
    moorings,
    rao,
    rotor,
    sea,
    simulate,
    trim,
    view,
)

COMMANDS = (
    export,
    simulate,
    view,
    inverse,
    equilibrium,
    gz,
    trim,
    modes,
    sea,
    hydro,
    rao,
    moorings,
    rotor,
    equations,
    couple,
    info,
    check,
    bench,
    import_,
)


def parser() -> argparse.ArgumentParser:
    """The parser of the whole command line."""
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

    for command in COMMANDS:
        command.add(commands)

    return whole
