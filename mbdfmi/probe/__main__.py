"""python -m mbdfmi.probe FOLDER QUESTION FILE: asks an unpacked FMU; the answer goes to the file."""

import json
import os
import sys
from pathlib import Path

from .fmu import Fmu, Refused
from .questions import CONTINUE, QUESTIONS, go_on

folder, name, file = sys.argv[1:4]

if name == CONTINUE:
    go_on(folder, Path(file))
else:
    from .answers import FAULT

    try:
        answer = QUESTIONS[name](Fmu(folder))
    except Refused as refused:
        answer = FAULT, str(refused)

    Path(file).write_text(json.dumps(answer))

# instances that are still there are not freed: whether that works is a question of its own
sys.stdout.flush()
os._exit(0)
