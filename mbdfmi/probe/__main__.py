"""python -m mbdfmi.probe FOLDER KIND QUESTION FILE: asks an unpacked FMU; the answer goes to the file."""

import json
import os
import sys
from pathlib import Path

from .fmu import Refused
from .kinds import KINDS
from .questions import CONTINUE, go_on

folder, kind, name, file = sys.argv[1:5]
asked, questions = KINDS[kind]

if name == CONTINUE:
    go_on(asked(folder), Path(file))
else:
    from .answers import FAULT

    try:
        answer = questions[name](asked(folder))
    except Refused as refused:
        answer = FAULT, str(refused)

    Path(file).write_text(json.dumps(answer))

# instances that are still there are not freed: whether that works is a question of its own
sys.stdout.flush()
os._exit(0)
