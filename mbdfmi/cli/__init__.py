"""The command `mbdfmi`: a file for each of its commands (commands/), what they share beside them."""

import os

from .parser import parser
from .terminal import carry_out

# no model here has plugins; to look for them is to read what all installed packages say of themselves
os.environ.setdefault("PYDANTIC_DISABLE_PLUGINS", "__all__")

__all__ = ["carry_out", "main"]


def main(arguments=None) -> int:
    """Run the command line; returns the exit status: 0 done, 1 failed with a message."""
    return carry_out(parser(), arguments)
