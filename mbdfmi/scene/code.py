"""How an FMU's library is made, and what of the scene's own code goes with it. No number of the simulation depends on it."""

from .fields import Boolean, Part
from .names import Text

ALL = "all"
"""What `bind` lists for all parameters but start values and those of the solver."""


class Code(Part):
    """A scene's own code.

    specialise : whether `export` and `simulate` compile it for this scene: smaller and faster, the same numbers.
    sources : whether FMUs carry it as C99 too, in sources/.
    bind : names of parameters that are constants of it, which nobody can change any more: faster still; an array without index
        stands for its elements, "all" for all parameters but start values and those of the solver.
    """

    specialise: Boolean = False
    sources: Boolean = False
    bind: list[Text] = []
