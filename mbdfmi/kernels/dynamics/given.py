"""What the start may move: parts of d.x_tried to go back to, and the given coordinates that are not kept yet."""

from .. import joints
from ..language import inlined
from . import holding
from .holding import POSITION

# parts of d.x_tried: the best found, one to go back to, deviations, one with gaps, the
# one of least gaps, the nearest found, where an attempt begins
BEST = 0
OTHER = 1
DEVIATION = 2
LOOSE = 3
LEAST = 4
FOUND = 5
BEGIN = 6
START = -1  # no part: the start values in x_before


@inlined
def store(m, d, part):
    """x to a part of d.x_tried."""
    for k in range(m.n_x):
        d.x_tried[part * m.n_x + k] = d.x[k]


@inlined
def recall(m, d, part):
    """x from a part of d.x_tried."""
    for k in range(m.n_x):
        d.x[k] = d.x_tried[part * m.n_x + k]


@inlined
def gives_all(m, what):
    """Whether the start values of all coordinates without a drive are given."""
    for i in range(1, m.n_body):
        for v in range(m.body_v[i], m.body_v[i] + joints.n_v(m.body_joint[i])):
            if m.body_drive[i] < 0 and (m.v_given[v] // what) % 2 == 0:
                return False

    return True


@inlined
def measure(m, d, what):
    """How far each given coordinate is from its start value, to d.x_tried; -1 where there is nothing to keep.

    An orientation counts as one at its first coordinate.
    """
    for i in range(1, m.n_body):
        kind = m.body_joint[i]

        for k in range(joints.n_v(kind)):
            v = m.body_v[i] + k
            off = -1.0

            if m.body_drive[i] < 0 and (m.v_given[v] // what) % 2 == 1:
                off = holding.deviation(m, d, i, k, what)

                if what == POSITION and not joints.slides(kind, k) and k % 3 > 0:
                    off = -1.0

            d.x_tried[DEVIATION * m.n_x + v] = off


@inlined
def nearest_left(m, d):
    """The given coordinate least off that was not tried, or -1."""
    best = -1

    for v in range(m.n_v):
        off = d.x_tried[DEVIATION * m.n_x + v]

        if off >= 0.0 and (best < 0 or off < d.x_tried[DEVIATION * m.n_x + best]):
            best = v

    return best


@inlined
def mark(m, d, v, what, value):
    """d.kept of a coordinate; of an orientation's three."""
    i = 1

    while i + 1 < m.n_body and m.body_v[i + 1] <= v:
        i += 1

    d.kept[v] = value
    kind = m.body_joint[i]

    if what == POSITION and joints.turns(kind, v - m.body_v[i]):
        d.kept[v + 1] = value
        d.kept[v + 2] = value
