"""The pictures of a scene that its FMU carries."""

import numpy as np

from ..compiler.model import Model
from . import drawing
from .picture import picture
from .runs import at_start

# pixels of the picture
LARGE = 400, 250


def still(model: Model) -> tuple[bytes, bytes]:
    """Pictures (PNG) of a model at its start, for a page and for an icon, the same on all machines.

    Raises SimulationError where it cannot be assembled, ValueError where a mesh cannot be read.
    """
    shown = picture(model.scene, at_start(model).states)
    large = drawing.draw(shown, 0, *LARGE, grid=False)
    small = large.reshape(LARGE[1] // 2, 2, LARGE[0] // 2, 2, 3).mean(axis=(1, 3)).round().astype(np.uint8)
    return drawing.png(large), drawing.png(small)
