"""The page: one file of HTML that holds the viewer, the GLB and what is told of it, and asks nothing of
the net.
"""

import base64
import gzip
import html
import json
from pathlib import Path

from . import glb
from .arrows import arrows
from .lines import told_lines, turns
from .motion import picked
from .told import told

FOLDER = Path(__file__).parent

# bytes of poses in a page: of longer runs not every row is kept
POSES = 1_100_000

NOT_EVERY = "the picture shows {shown} of the {all} rows of the run"
NO_LINES = 'mooring lines are not drawn in a frame that turns: frame = "inertial" shows them'
SPINS = "{bodies} may turn further between two rows than the picture can tell: a smaller step shows how"


def rows_of(states):
    """The rows of a run that a page can hold: all of one that is not very long."""
    moving = max(1, len(states.model.tree.nodes) - 1)
    return picked(len(states), max(50, POSES // (28 * moving)))


def page(picture, results=None, notes=()) -> str:
    """The page of a picture; results: of its run; notes: what a user is told of it."""
    notes = list(notes)

    if picture.moves.far_turns():
        notes.append(SPINS.format(bodies=", ".join(picture.moves.far_turns())))

    if picture.lines and turns(picture):
        notes.append(NO_LINES)

    if len(picture.moves.times) < len(picture.states):
        notes.append(NOT_EVERY.format(shown=len(picture.moves.times), all=len(picture.states)))

    binary = glb.write(picture.tree(full=False), picture.moves.times, picture.title)
    info = told(picture, results, notes) | {
        "arrows": arrows(picture),
        "lines": told_lines(picture),
    }
    data = json.dumps(info, separators=(",", ":"), ensure_ascii=False, allow_nan=False)
    parts = {
        "title": html.escape(picture.title),
        "style": (FOLDER / "page.css").read_text(encoding="utf-8"),
        "licence": (FOLDER / "LICENSE.three.js").read_text(encoding="utf-8"),
        "viewer": _packed((FOLDER / "viewer.js").read_bytes()),
        "glb": _packed(binary),
        "info": _packed(data.encode()),
    }
    text = (FOLDER / "page.html").read_text(encoding="utf-8")

    for name, part in parts.items():
        text = text.replace(f"%{name}%", part, 1)

    return text


def _packed(data):
    """Bytes as text for a page: gzip, base64."""
    return base64.b64encode(gzip.compress(data, 9, mtime=0)).decode()
