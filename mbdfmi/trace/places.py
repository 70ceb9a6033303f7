"""Which places of a model's buffers are given to a trace, and what they are called."""

from ..kernels.layout import ARRAY, SLOT, array_length

COMMANDED = ("command_course", "command_settling", "attitude_base")
"""Work arrays that say how commanded motions go on over a communication step."""

TIME_WORK = ("now", "input")
"""Work arrays of the time, and the inputs at it."""

GIVEN_WORK = (*TIME_WORK, *COMMANDED)
"""Work arrays that a run leaves for `rates.evaluate_now` to read: time, inputs and commands."""

KEPT_WORK = ("x_rate", "held", "least_share")
"""Work arrays that steppers read after it, or that say what stands in the state. What else it leaves is read
by no one.
"""

STILL_WORK = ("held", "weight", "weighs", "aim", "damping", "assembling", "row_settles")
"""Work arrays that the start leaves as they are in all of a run."""

LOOKED_UP = ("knot_x", "knot_c", "knot_area", "patch_c", "cell_c")
"""Arrays of tables, in which numbers are looked up."""

PREPARED = ("body_m", "body_h", "body_I", "added_I", "added_H", "added_M", "lightness")
"""What stands in the state but follows from parameters (`prepare`)."""


def places(model, name: str) -> range:
    """Where an array stands in its buffer."""
    array = ARRAY[name]
    counts = {array.count: getattr(model, array.count)} if isinstance(array.count, str) else {}
    first = int(model.ints[SLOT[name]])
    return range(first, first + array_length(array, counts))


def places_of(model, names) -> set[int]:
    """Where some arrays of one buffer stand in it."""
    return {j for name in names for j in places(model, name)}


def tunable(model) -> set[int]:
    """Places of `reals` that are parameters: all others never change."""
    return {v.index for v in model.of_causality("parameter")}


SELDOM = ("row_redundant", "lends", "loose")
"""What stands in the state and changes in a run, but not in an evaluation: which rows follow from others, and
whether inertia is lent. A scene's own code forgets what it has computed once where a kernel writes to it.
"""


class Everywhere:
    """All places of a buffer."""

    def __contains__(self, place):
        return True
