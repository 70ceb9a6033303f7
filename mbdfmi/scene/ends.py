"""The ends of joints, forces and measures: frames named by text."""

from typing import Annotated

from pydantic import BeforeValidator

from .errors import quoted, show
from .names import FRAMES


def _between(value):
    if not isinstance(value, (list, tuple)) or len(value) != 2:
        raise ValueError(f'needs two ends, as in ["ground", "body.marker"]; found {show(value)}')
    return tuple(_end(end) for end in value)


def _end(value):
    if not isinstance(value, str):
        raise ValueError(f'an end is a text, "body" or "body.marker"; found {show(value)}')

    names = [name.strip() for name in value.split(".")]
    if len(names) > 2 or not all(names):
        raise ValueError(f'an end is "body" or "body.marker", found {quoted(value)}')
    return ".".join(names)


def _some(value):
    """The ends of a value of `on`, each on a body of its own."""
    if not isinstance(value, (list, tuple)):
        return _end(value)

    ends = tuple(_end(end) for end in value)
    if not ends:
        raise ValueError('needs an end, or a list of them, as in on = ["ship.waterline", "barge.waterline"]')
    return ends if len(ends) > 1 else ends[0]


def stands_still(end):
    """Whether an end is on no body: what acts there moves nothing."""
    return end.split(".")[0] in FRAMES


# One end, "body", "body.marker", "ground", "ground.marker", or "inertial"; two of them.
End = Annotated[str, BeforeValidator(_end)]
Between = Annotated[tuple[str, str], BeforeValidator(_between)]
# one end, or, of several bodies, the list of theirs
Ends = Annotated[str | tuple[str, ...], BeforeValidator(_some)]
BETWEEN = 'the two ends, as in between = ["ground", "body.marker"]'
