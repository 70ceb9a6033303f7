"""Which rows follow from others in every position, and which bodies cannot move (docs/theory.md 11.4)."""

import math


from .. import joints
from ..language import apart, inlined, kernel
from ..math import algebra as al
from ..motion import drives, kinematics
from ..status import OK
from ..signatures import DATA, MODEL, void
from . import forward, given, holding, multipliers, projection, rows, start_positions
from .projection import (
    close_gaps,
    factor_for_velocities,
    move_by_change,
    project_velocities,
    see_rows,
)

# a body is stuck that moves this little beside the others
STUCK = 1e-10


@inlined
def stir(m, d):
    """Velocities in which every joint without a drive takes part."""
    for i in range(1, m.n_body):
        for v in range(m.body_v[i], m.body_v[i] + joints.n_v(m.body_joint[i])):
            d.v[v] = math.cos(1.7 * v * v + 0.3) if d.held[i] == 0.0 else 0.0

    kinematics.kinematics(m, d)
    rows.write_rows(m, d)
    failure = forward.factor_rows_here(m, d, False)

    if failure == OK:
        project_velocities(m, d)

    return failure


@kernel
def see_stuck(m, d, seen):
    """Bodies that do not move in the velocities d.v: d.stuck is `seen` + 1 for those that were stuck before."""
    kinematics.kinematics(m, d)
    size = 0.0

    for v in range(m.n_v):
        size = max(size, STUCK * abs(d.v[v]))

    # what is held, as a ground that moves, is not stuck
    for i in range(1, m.n_body):
        moves = (
            d.held[i] > 0.0
            or al.norm(al.vec3(d.w, i)) > size
            or al.norm(al.vec3(d.rd, i)) > size * m.scene_length[0]
        )
        d.stuck[i] = seen + 1.0 if not moves and d.stuck[i] == seen else 0.0


@apart(void(MODEL, DATA))
def find_redundant(m, d):
    """Mark rows that follow from others not just here but in every position: they are dropped at a position nearby too.

    Keeps d.x. Nearby: a little way along an allowed motion in which every joint takes part. Bodies that move neither here
    nor there are stuck, where no joint is driven.
    """
    allowed = m.closing_tolerance[0]
    undriven = not drives.moves_joints(m)
    given.store(m, d, given.BEST)
    holding.keep_none(m, d)
    holding.hold(m, d)

    if stir(m, d) == OK:
        if undriven:
            see_stuck(m, d, 0.0)

        size = al.largest(d.x, m.n_x)

        for v in range(m.n_v):
            d.change[v] = d.v[v]

        move_by_change(m, d, 0.1 / (1.0 + size))
        given.store(m, d, given.OTHER)
        failure = close_gaps(m, d, allowed, start_positions.STRIDE)

        # a loop that is not quite exact may close exactly where it starts
        if failure != OK and d.loose[0] == 0.0:
            given.recall(m, d, given.OTHER)
            d.loose[0] = 1.0
            failure = close_gaps(m, d, allowed, start_positions.STRIDE)
            d.loose[0] = (
                1.0 if failure == OK and al.largest(d.row_gap, m.n_row) <= start_positions.GAP_TAKEN else 0.0
            )

        if failure == OK:
            projection.see_gaps(m, d)
            factor_for_velocities(m, d)

            for row in range(m.n_row):
                d.row_redundant[row] = multipliers.REDUNDANT if d.pivot[row] == 0.0 else 0.0

            forward.exchange_rows(m, d)

            if undriven and stir(m, d) == OK:
                see_stuck(m, d, 1.0)

    given.recall(m, d, given.BEST)
    see_rows(m, d)
    projection.rest_here(m, d)
