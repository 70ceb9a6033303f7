"""The command `mbdfmi`: a file for each of its commands (commands/), what they share beside them."""

import atexit
import gc
import os
import sys

from .parser import parser
from .terminal import carry_out

# no model here has plugins; to look for them is to read what all installed packages say of themselves
os.environ.setdefault("PYDANTIC_DISABLE_PLUGINS", "__all__")

# modules and their classes stay: looking for garbage as often as Python would is a tenth of a short command
OBJECTS_BEFORE_A_LOOK = 100_000

__all__ = ["carry_out", "main"]


def main(arguments=None) -> int:
    """Run the command line; returns the exit status: 0 done, 1 failed with a message."""
    if arguments is None:
        # the process ends with the command: a last look for garbage, in all modules, is a fifth of its time
        gc.set_threshold(OBJECTS_BEFORE_A_LOOK)
        atexit.register(gc.freeze)

    command = next(iter(sys.argv[1:] if arguments is None else arguments), None)

    if command != "hydro":
        # all but its matrices are small: threads of OpenBLAS wait for each other more than they work
        os.environ.setdefault("OPENBLAS_NUM_THREADS", "1")

    return carry_out(parser(command), arguments)
