"""python -m mbdfmi.export PLATFORM ...: makes libraries that are not there yet, and says what it does."""

import sys

from .aot import CompileError
from .link import LinkError, library

try:
    for name in sys.argv[1:]:
        library(name, lambda text: print(text, flush=True))
except (CompileError, LinkError, ImportError) as error:
    sys.exit(str(error))
