"""`python -m mbdfmi` is the command `mbdfmi`."""

import sys

from .cli import main

sys.exit(main())
