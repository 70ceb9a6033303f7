"""The start (docs/theory.md 13): loops closed near the start values, velocities made to fit.

What was given is kept wherever the equations allow it.

First everything given is held. Where the loops cannot close so, the least is given up: the given coordinates are tried again
one by one, those first that stay nearest to their values when all of them may move, but unwillingly.
"""

from .. import joints
from ..end_frames import touching
from ..language import apart, inlined, kernel
from ..motion import coordinates, drives, kinematics, markers
from ..status import OK
from ..signatures import DATA, MODEL, int64
from . import forward, holding, projection, redundancy, rows, start_positions, start_velocities
from .projection import (
    keep_x,
    see_rows,
    unit_E,
)


@inlined
def is_linear(m, row):
    """Whether a row couples joints of the tree alone."""
    for t in range(m.row_term[row], rows.last_term(m, row)):
        if rows.body_of_term(m, t) == 0:
            return False

    return m.row_terms[row] > 0


@kernel
def begin_rows(m, d):
    """Couplings whose offset is to be found, which joints are in loops; nothing rests anywhere yet."""
    d.loose[0] = 0.0

    for i in range(m.n_body):
        d.in_loop[i] = 0.0
        d.stuck[i] = 0.0

    for row in range(m.n_row):
        c = m.row_constraint[row]
        d.row_rest[row] = 0.0
        d.row_taken[row] = 0.0
        d.row_redundant[row] = 0.0
        d.row_side[row] = 1.0
        d.row_settles[row] = float(m.row_at_start[row])

        if not is_linear(m, row):
            for step in range(m.constraint_path[c], m.constraint_path[c] + m.constraint_paths[c]):
                d.in_loop[m.path_node[step]] = 1.0


@kernel
def choose_sides(m, d):
    """What rolls stays on the side of its plane where the start puts its centre. Needs kinematics."""
    for row in range(m.n_row):
        if m.row_kind[row] == rows.ROLL_SPHERE or m.row_kind[row] == rows.ROLL_DISK:
            c = m.row_constraint[row]
            height = markers.relative_position(m, d, m.constraint_from[c], m.constraint_to[c])[2]
            d.row_side[row] = -1.0 if height < 0.0 else 1.0


@inlined
def follows(m, d, row):
    """The one term of a coupling of the tree whose joint is not known yet; -1: there is none or more than one."""
    found = -1

    for t in range(m.row_term[row], rows.last_term(m, row)):
        if d.white[m.body_v[rows.body_of_term(m, t)]] == 0.0:
            if found >= 0:
                return -1

            found = t

    return found


@kernel
def spread_couplings(m, d):
    """Joints of the tree that follow from given or driven ones by couplings alone, exactly: these are linear."""
    for v in range(m.n_v):
        d.white[v] = float(m.v_given[v] % 2)

    for i in range(1, m.n_body):
        if m.body_drive[i] >= 0 and joints.n_v(m.body_joint[i]) == 1:
            d.white[m.body_v[i]] = 1.0

    for sweep in range(m.n_row):
        spread = False

        for row in range(m.n_row):
            if not is_linear(m, row) or d.row_settles[row] > 0.0:
                continue

            last = follows(m, d, row)

            if last < 0:
                continue

            i = rows.body_of_term(m, last)
            total = m.row_offset[row]

            for t in range(m.row_term[row], rows.last_term(m, row)):
                if t != last:
                    total += m.term_factor[t] * d.q[m.body_q[rows.body_of_term(m, t)]]

            d.q[m.body_q[i]] = -total / m.term_factor[last]
            d.white[m.body_v[i]] = 1.0
            spread = True

        if not spread:
            return


@kernel
def settle(m, d):
    """Gaps that stay are where rows rest: of couplings whose offset is that of the start, of loops not quite exact."""
    see_rows(m, d)
    projection.see_gaps(m, d)
    projection.rest_here(m, d)

    for row in range(m.n_row):
        d.row_settles[row] = 0.0

    rows.write_rows(m, d)

    for row in range(m.n_row):
        if m.row_at_start[row] == 1:
            d.row_rest[row] += d.row_gap[row]

    rows.write_rows(m, d)


@apart(int64(MODEL, DATA))
def assemble(m, d):
    """Close the loops from approximate start values in d.x, then make the velocities fit. Returns a status."""
    drives.prescribe(m, d)
    unit_E(m, d)
    begin_rows(m, d)
    holding.keep_none(m, d)
    holding.hold(m, d)
    kinematics.kinematics(m, d)
    forward.lend_inertia(m, d)
    rows.start_turns(m, d)

    if m.n_row == 0:
        coordinates.start_twists(m, d)
        return OK

    choose_sides(m, d)
    spread_couplings(m, d)
    kinematics.kinematics(m, d)
    touching.start(m, d)
    rows.start_parameters(m, d)
    keep_x(m, d)
    d.assembling[0] = 1.0
    failure = start_positions.find_positions(m, d)
    d.assembling[0] = 0.0

    if failure == OK:
        settle(m, d)
        failure = projection.see_contacts(m, d)

    if failure == OK:
        redundancy.find_redundant(m, d)
        start_velocities.find_velocities(m, d)

    for row in range(m.n_row):
        d.row_settles[row] = 0.0

    holding.keep_none(m, d)
    holding.hold(m, d)
    return failure
