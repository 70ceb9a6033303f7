"""Forward dynamics by the formulation of the model, constraints included."""

import math


from ..joints import virtual
from ..language import apart, inlined, kernel
from ..status import OK
from ..signatures import DATA, MODEL, boolean, int64, void
from . import articulated, embedding, inertia, massless, multipliers, rows

# of what parts are lent, to see what they have
LESS = 1e-3

REFINEMENTS = 3
"""Corrections of the accelerations at most; each gains the digits that the factor has left."""


@inlined
def respond_and_factor(m, d, positional):
    """Responses of the rows and the factor of C M^-1 C^T."""
    respond_to_rows(m, d, multipliers.needs_redundant(m, positional))
    multipliers.factor_rows(m, d, positional)


@inlined
def respond_to_rows(m, d, everything):
    """Responses of the rows, the redundant ones only with `everything`."""
    if m.embeds == 1:
        embedding.respond_to_rows(m, d, everything)
    else:
        articulated.respond_to_rows(m, d, everything)


@kernel
def exchange_rows(m, d):
    """Redundant rows take the place of weak ones; needs factor_rows_here at the same positions."""
    if multipliers.has_weak_row(m, d):
        respond_to_rows(m, d, True)
        multipliers.exchange_rows(m, d)


@apart(void(MODEL, DATA))
def correct(m, d):
    """The smallest change (in the metric of the inertia) whose row values are d.row_rhs, into d.change."""
    multipliers.solve_rows(m, d)
    multipliers.gather_white(m, d)

    if m.embeds == 1:
        embedding.respond(m, d)
    else:
        articulated.respond(m, d)


@apart(int64(MODEL, DATA, boolean))
def factor_rows_here(m, d, positional):
    """Factor of C M^-1 C^T at the positions that kinematics and write_rows have seen. Returns a status.

    positional : without rows that are about velocities alone.
    """
    inertia.inertias(m, d)
    failure = embedding.factor(m, d) if m.embeds == 1 else articulated.aba(m, d)

    if failure == OK:
        respond_and_factor(m, d, positional)

    return failure


@kernel
def lend_inertia(m, d):
    """Parts without inertia of their own are lent some, all of them, if a joint has none to move but theirs; needs kinematics.

    Which have is seen from what becomes of it when less is lent.
    """
    if not virtual.lend_to_all(m, d, 1.0):
        return

    inertia.inertias(m, d)
    failure = articulated.aba(m, d)
    articulated.read_pivots(m, d, d.white)
    virtual.lend_to_all(m, d, LESS)
    inertia.inertias(m, d)
    failure = max(failure, articulated.aba(m, d))
    articulated.read_pivots(m, d, d.change)
    lacking = False

    for v in range(m.n_v):
        lacking = lacking or d.change[v] < 30.0 * LESS * d.white[v]

    virtual.lend_to_all(m, d, 1.0)

    if failure != OK or not lacking:
        virtual.forget(m, d)


@kernel
def refine(m, d):
    """Accelerations that miss the rows by rounding alone, where light parts are between heavy ones.

    A light part's acceleration is the small difference of large forces over a small mass, and the factor has lost as many
    digits as the masses differ by. Corrections are small, so that they have all digits that count (iterative refinement).
    """
    size_before = math.inf

    for attempt in range(REFINEMENTS):
        size = 0.0

        for row in range(m.n_row):
            d.multiplier_kept[row] = d.multiplier[row]
            d.row_rhs[row] = -multipliers.row_acceleration(m, d, row)
            size = max(size, abs(d.row_rhs[row]) if d.pivot[row] > 0.0 else 0.0)

        if not size < 0.1 * size_before:
            return

        correct(m, d)
        multipliers.add_changes(m, d)
        size_before = size

        for row in range(m.n_row):
            d.multiplier[row] += d.multiplier_kept[row]


@apart(int64(MODEL, DATA))
def accelerate(m, d):
    """v' into d.v_rate and accelerations of all bodies, multipliers of all rows. Returns a status.

    Needs kinematics, inertias, applied wrenches and efforts.
    """
    failure = embedding.forward(m, d) if m.embeds == 1 else articulated.aba(m, d)

    if failure != OK:
        return failure

    if m.n_row > 0:
        rows.write_rows(m, d)
        respond_and_factor(m, d, False)

        # lambda = -(C M^-1 C^T)^+ (C v' + g'' bias)
        for row in range(m.n_row):
            d.row_rhs[row] = -multipliers.row_acceleration(m, d, row)

        correct(m, d)
        multipliers.add_changes(m, d)

        if d.lightness[0] < multipliers.UNEVEN:
            refine(m, d)

    return massless.give_back(m, d) if d.lends[0] > 0.0 else OK
