"""Forward dynamics by the formulation of the model, constraints included."""

from numba.types import boolean, int64, void

from . import constraints, embedding, rows, tree
from .language import apart, inlined, kernel
from .status import OK
from .views import DATA, MODEL


@inlined
def reach_and_factor(m, d, positional):
    """Responses of the rows and the factor of C M^-1 C^T."""
    reach(m, d, constraints.all_matter(m, positional))
    constraints.factor_rows(m, d, positional)


@inlined
def reach(m, d, everything):
    """Responses of the rows, the redundant ones only with `everything`."""
    if m.embeds == 1:
        embedding.reach_rows(m, d, everything)
    else:
        constraints.reach_rows(m, d, everything)


@kernel
def exchange_rows(m, d):
    """Redundant rows take the place of weak ones; needs factor_rows_here at the same positions."""
    if constraints.has_weak_row(m, d):
        reach(m, d, True)
        constraints.exchange_rows(m, d)


@apart(void(MODEL, DATA))
def correct(m, d):
    """The smallest change (in the metric of the inertia) whose row values are d.row_left, into d.change."""
    constraints.solve_rows(m, d)
    constraints.gather_white(m, d)

    if m.embeds == 1:
        embedding.respond(m, d)
    else:
        constraints.respond(m, d)


@apart(int64(MODEL, DATA, boolean))
def factor_rows_here(m, d, positional):
    """Factor of C M^-1 C^T at the positions that kinematics and write_rows have seen. Returns a status.

    positional : without rows that are about velocities alone.
    """
    tree.inertias(m, d)
    failure = embedding.factor(m, d) if m.embeds == 1 else tree.aba(m, d)

    if failure == OK:
        reach_and_factor(m, d, positional)

    return failure


@apart(int64(MODEL, DATA))
def accelerate(m, d):
    """v' into d.x_rate and accelerations of all bodies, multipliers of all rows. Returns a status.

    Needs kinematics, inertias, applied wrenches and efforts.
    """
    failure = embedding.forward(m, d) if m.embeds == 1 else tree.aba(m, d)

    if failure != OK or m.n_row == 0:
        return failure

    rows.write_rows(m, d)
    reach_and_factor(m, d, False)

    # lambda = -(C M^-1 C^T)^+ (C v' + g'' bias)
    for row in range(m.n_row):
        d.row_left[row] = -constraints.row_acceleration(m, d, row)

    correct(m, d)
    constraints.add_changes(m, d)
    return OK
