"""Velocities of the start: what the rows allow, what was given kept wherever it can be (docs/theory.md 13.4)."""

from .. import joints
from ..language import apart, inlined, kernel
from ..math import algebra as al
from ..motion import kinematics
from ..status import OK
from ..signatures import DATA, MODEL, boolean
from . import forward, given, holding, rows, start_positions
from .holding import VELOCITY
from .projection import (
    project_velocities,
)

# given speeds are kept when the rows' rates are this small a part of the largest speed
RATE_ALLOWED = 1e-9


@inlined
def rate_left(m, d):
    """Largest rate among the rows that are asked of."""
    size = 0.0

    for row in range(m.n_row):
        if d.loose[0] == 0.0 or d.row_redundant[row] == 0.0:
            size = max(size, abs(d.row_rate[row]))

    return size


@apart(boolean(MODEL, DATA))
def try_velocities(m, d):
    """Velocities from the start values onto the rows, with what d.kept says. Returns whether they fit."""
    for v in range(m.n_v):
        d.v[v] = d.x_before[m.n_q + v]

    # angular velocities told in the first marker's axes do not turn with the body
    for i in range(1, m.n_body):
        if m.body_drive[i] < 0 and joints.E_offset(m.body_joint[i]) >= 0:
            for k in range(joints.n_v(m.body_joint[i])):
                joints.put_back(m, d, i, k, False)

    speed = 1.0 + al.largest(d.x, m.n_x)
    partly = holding.begin(m, d, VELOCITY)

    for turn in range(start_positions.PUT_BACK):
        kinematics.kinematics(m, d)
        rows.write_rows(m, d)

        if forward.factor_rows_here(m, d, False) != OK:
            return False

        project_velocities(m, d)
        kinematics.kinematics(m, d)
        rows.write_rows(m, d)

        if not rate_left(m, d) <= RATE_ALLOWED * speed:
            return False

        if not partly or holding.put_back(m, d, VELOCITY) <= start_positions.KEPT * speed:
            return True

    return False


@kernel
def find_velocities(m, d):
    """Velocities that the rows allow: the given ones kept, as many of them as can be."""
    holding.keep_none(m, d)
    holding.keep_given(m, d, VELOCITY)

    if try_velocities(m, d):
        return

    holding.keep_none(m, d)

    if given.gives_all(m, VELOCITY):
        try_velocities(m, d)
        return

    holding.weigh_all(m, d, VELOCITY)
    try_velocities(m, d)
    given.store(m, d, given.BEST)
    given.measure(m, d, VELOCITY)

    for turn in range(start_positions.MAX_TRIES):
        v = given.nearest_left(m, d)

        if v < 0:
            break

        d.x_tried[given.DEVIATION * m.n_x + v] = -1.0
        given.mark(m, d, v, VELOCITY, 1.0)

        if try_velocities(m, d):
            given.store(m, d, given.BEST)
        else:
            given.mark(m, d, v, VELOCITY, 0.0)

    given.recall(m, d, given.BEST)
