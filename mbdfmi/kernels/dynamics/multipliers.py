"""Multipliers of the constraint rows: the factor of C M^-1 C^T = R R^T, with R the rows' whitened responses (articulated.py).

It is factored in blocks: those of constraints that share joints, in an order that makes few others. Rows are dropped
whose pivot is a small part of their diagonal: they follow from rows before them (docs/theory.md 11).
"""

import math


from .. import joints
from ..language import apart, inlined, kernel
from ..math import algebra as al
from ..signatures import DATA, MODEL, boolean, void
from . import rows

# a row is dropped when what it adds to the rows before it is this small beside its reference (see row_reference): squared
# sine of an angle. Where a four-bar is singular, 1e-8 costs ten times the energy that this does, and below 1e-10 it is felt
# by how much the stages of a step are off the constraints
DROP = 1e-9

# likewise in loops that repeat themselves not quite exactly, as with axes 1e-5 rad off
LOOSE_DROP = 1e-7

# likewise where masses are very different: a row that moves a heavy part between light ones adds as little to the rows before
# it as the light part is lighter. Below this ratio of masses DROP is taken smaller, down to what rounding leaves of a pivot
LIGHT = 1e-5
DROP_OF_LIGHT = 1e-13

# below this ratio of masses the multipliers' rounding is felt: changes are found again for what the first ones left
UNEVEN = 1e-3

# ... or beside what its wrenches could do if they met the joints' axes: then it is hardly more than rounding
NOISE = 1e-14

# ... or beside what its wrench could do if its two sides did not cancel below a loop: then it is the square of rounding
CANCELLED = 1e-24

# a row that adds less than this to the rows before it gives its place to a redundant one that adds more
WEAK = 1e-3

# likewise in loops that repeat themselves not quite exactly, once their gaps are so many times those at the start
LOOSE_WEAK = 0.1
GROWN = 2.0

# of row_redundant: a row that follows from others, and one that may take another's place; 0: neither
REDUNDANT = 1.0
CANDIDATE = 2.0


@inlined
def arm_square(d, i, r):
    """Square (m2) of the arm from body i's origin to r."""
    arm = al.sub(r, al.vec3(d.r, i))
    return al.dot(arm, arm)


@inlined
def needs_redundant(m, positional):
    """Whether redundant rows are needed too: where rows about velocities alone are left out they may not be redundant."""
    if positional:
        for row in range(m.n_row):
            if rows.is_of_velocity(m, row):
                return True

    return False


@inlined
def is_idle(d, row, everything):
    """Whether a row follows from others and is not asked for: it costs nothing then."""
    return d.row_redundant[row] == REDUNDANT and not everything


@inlined
def row_of_white(m, d, row):
    """What whitened efforts d.white change in g''."""
    c = m.row_constraint[row]
    at = m.constraint_response[c] + (row - m.constraint_row[c]) * m.constraint_width[c]
    total = 0.0

    for step in range(m.constraint_path[c], m.constraint_path[c] + m.constraint_paths[c]):
        i = m.path_node[step]

        for k in range(joints.n_v(m.body_joint[i])):
            total += d.response[at + m.path_at[step] + k] * d.white[m.body_v[i] + k]

    return total


@inlined
def product(m, d, row, other):
    """Element (row, other) of R R^T: over the joints that both rows reach."""
    c = m.row_constraint[row]
    e = m.row_constraint[other]
    at = m.constraint_response[c] + (row - m.constraint_row[c]) * m.constraint_width[c]
    to = m.constraint_response[e] + (other - m.constraint_row[e]) * m.constraint_width[e]
    total = 0.0

    if c == e:
        for k in range(m.constraint_width[c]):
            total += d.response[at + k] * d.response[to + k]

        return total

    step = m.constraint_path[c]
    end = step + m.constraint_paths[c]
    turn = m.constraint_path[e]
    last = turn + m.constraint_paths[e]

    while step < end and turn < last:
        i = m.path_node[step]
        j = m.path_node[turn]

        if i == j:
            x = at + m.path_at[step]
            y = to + m.path_at[turn]

            for k in range(joints.n_v(m.body_joint[i])):
                total += d.response[x + k] * d.response[y + k]

            step += 1
            turn += 1
        elif i < j:
            step += 1
        else:
            turn += 1

    return total


@inlined
def drop_share(d):
    """What a row must add to the rows before it beside its reference (see DROP)."""
    return max(DROP_OF_LIGHT, min(DROP, DROP / LIGHT * d.lightness[0]))


@inlined
def row_reference(m, d, row):
    """What a row's pivot is to be judged by."""
    return reference(d, row, largest_of_kind(m, d, row))


@inlined
def reference(d, row, largest):
    """`row_reference` by the `largest_of_kind`.

    Its own diagonal element, unless its wrenches miss the axes of joints that they could meet: then what they could do there, but
    not more than the largest of its kind in the same constraint does; that too where loops repeat themselves not quite exactly.
    """
    if d.loose[0] > 0.0:
        return max(d.row_diagonal[row], d.row_size[row])

    return min(largest, max(d.row_diagonal[row], d.row_size[row]))


@inlined
def largest_of_kind(m, d, row):
    """Largest diagonal element among the rows of the same kind in the same constraint, redundant ones left out."""
    c = m.row_constraint[row]
    size = 0.0

    for other in range(m.constraint_row[c], m.constraint_row[c] + m.constraint_rows[c]):
        if m.row_kind[other] == m.row_kind[row] and d.row_redundant[other] != REDUNDANT:
            size = max(size, d.row_diagonal[other])

    return size


@inlined
def product_before(m, d, c, end, row, e, other):
    """Sum over the constraints before e that are neighbours of both c and e of (unscaled L of row) (L of other)^T.

    row, other : rows of c and e, counted from their first; `end` : where e stands among c's neighbours.
    """
    total = 0.0
    t = m.constraint_neighbour[c]
    u = m.constraint_neighbour[e]
    last = u + m.constraint_neighbours[e]

    while t < end and u < last:
        k = m.neighbour_constraint[t]
        l = m.neighbour_constraint[u]

        if k == l:
            n = m.constraint_rows[k]
            x = m.neighbour_block[t] + row * n
            y = m.neighbour_block[u] + other * n

            for s in range(n):
                total += d.factor[x + s] * d.factor[y + s]

        if k <= l:
            t += 1

        if l <= k:
            u += 1

    return total


@inlined
def factor_row(m, d, c, i):
    """Row i (counted from its first) of constraint c in the factor; returns its pivot before any dropping."""
    row = m.constraint_row[c] + i
    first = m.constraint_neighbour[c]
    end = first + m.constraint_neighbours[c]

    # unscaled: columns of constraints met before, then of its own rows before
    for t in range(first, end + 1):
        e = m.neighbour_constraint[t] if t < end else c
        n = m.constraint_rows[e]
        at = (m.neighbour_block[t] if t < end else m.constraint_block[c]) + i * n
        to = m.constraint_block[e]

        for j in range(n if t < end else i):
            # a column of a dropped row counts for nothing
            if d.pivot[m.constraint_row[e] + j] == 0.0:
                d.factor[at + j] = 0.0
                continue

            value = product(m, d, row, m.constraint_row[e] + j) - product_before(m, d, c, t, i, e, j)

            for s in range(j):
                value -= d.factor[at + s] * d.factor[to + j * n + s]

            d.factor[at + j] = value

    # scaled by the pivots
    pivot = d.row_diagonal[row]

    for t in range(first, end + 1):
        e = m.neighbour_constraint[t] if t < end else c
        n = m.constraint_rows[e]
        at = (m.neighbour_block[t] if t < end else m.constraint_block[c]) + i * n

        for j in range(n if t < end else i):
            value = d.factor[at + j]
            d.factor[at + j] = value * d.pivot[m.constraint_row[e] + j]
            pivot -= value * d.factor[at + j]

    return pivot


@kernel
def raise_diagonal(m, d):
    """Levenberg's damping: a part of the largest diagonal element among rows of a kind to those of all."""
    for row in range(m.n_row):
        d.pivot[row] = d.row_diagonal[row]

    for row in range(m.n_row):
        size = 0.0

        for other in range(m.n_row):
            if m.row_kind[other] == m.row_kind[row]:
                size = max(size, d.pivot[other])

        d.row_diagonal[row] += d.damping[0] * size


@apart(void(MODEL, DATA, boolean))
def factor_rows(m, d, positional):
    """L D L^T of R R^T, in blocks of neighbours (constraints that share joints, or come to by fill).

    The factor's rows have a unit diagonal; pivot holds 1 / D, 0 where a row was dropped, and when `positional` also of
    rows that are about velocities alone. A row that follows only from such rows is then not redundant.
    """
    everything = needs_redundant(m, positional)
    least = LOOSE_DROP if d.loose[0] > 0.0 else drop_share(d)

    for row in range(m.n_row):
        d.row_diagonal[row] = 0.0 if is_idle(d, row, everything) else product(m, d, row, row)

    if d.damping[0] > 0.0:
        raise_diagonal(m, d)

    least_share = 1.0

    for c in range(m.n_constraint):
        kind = -1
        largest = 0.0

        for i in range(m.constraint_rows[c]):
            row = m.constraint_row[c] + i
            d.pivot[row] = 0.0

            silent = rows.is_of_velocity(m, row) or d.row_settles[row] > 0.0

            if is_idle(d, row, everything) or (positional and silent):
                continue

            pivot = factor_row(m, d, c, i)
            adds = max(least, d.weakest[0]) if d.row_redundant[row] == CANDIDATE else least

            least_felt = max(NOISE * d.row_size[row], CANCELLED * d.constraint_noise[c])

            # of rows of one kind, which stand side by side, it is the same
            if m.row_kind[row] != kind:
                kind = m.row_kind[row]
                largest = largest_of_kind(m, d, row)

            size = reference(d, row, largest)

            if pivot > adds * size and pivot > least_felt:
                d.pivot[row] = 1.0 / pivot
                least_share = min(least_share, pivot / size)
            else:
                least_share = 0.0

    d.least_share[0] = least_share


@inlined
def weakest_row(m, d):
    """(row, share): of those not redundant the row that adds least to the rows before it, 0 where it was dropped."""
    weakest = 0
    least = math.inf

    for row in range(m.n_row):
        if d.row_redundant[row] != REDUNDANT:
            share = 0.0 if d.pivot[row] == 0.0 else 1.0 / (d.pivot[row] * row_reference(m, d, row))

            # of candidates some are dropped in any case
            if share < least and (share > 0.0 or d.row_redundant[row] == 0.0):
                weakest = row
                least = share

    return weakest, least


@inlined
def weak_share(m, d):
    """What a row must add to the rows before it to keep its place.

    More where a loop that does not quite close is left larger gaps than at the start: a weak row enlarges them.
    """
    taken = 0.0
    left = 0.0

    for row in range(m.n_row if d.loose[0] > 0.0 else 0):
        taken = max(taken, abs(d.row_taken[row]))
        left = max(left, abs(d.row_gap[row]))

    return LOOSE_WEAK if left > GROWN * taken else WEAK


@inlined
def has_weak_row(m, d):
    """Whether redundant rows might do better than one of the others."""
    redundant = False

    for row in range(m.n_row):
        redundant = redundant or d.row_redundant[row] > 0.0

    return redundant and weakest_row(m, d)[1] <= weak_share(m, d)


@kernel
def exchange_rows(m, d):
    """Redundant rows take the place of weak ones, when they add more.

    How many rows follow from others is a matter of structure, which of them can stand for the others is one of position.
    Needs respond_to_rows of everything and factor_rows at the same positions; leaves a factor without the rows that are
    redundant then.
    """
    redundant = 0

    for row in range(m.n_row):
        redundant += 1 if d.row_redundant[row] > 0.0 else 0

    for attempt in range(redundant):
        weak, share = weakest_row(m, d)

        if share > weak_share(m, d):
            return

        for row in range(m.n_row):
            if d.row_redundant[row] == REDUNDANT:
                d.row_redundant[row] = CANDIDATE

        # one that adds less than the weak row does not do better
        d.weakest[0] = share
        d.row_redundant[weak] = REDUNDANT
        factor_rows(m, d, False)
        dropped = 0

        for row in range(m.n_row):
            dropped += 1 if d.pivot[row] == 0.0 else 0

        better = dropped == redundant and weakest_row(m, d)[1] > share
        d.row_redundant[weak] = 0.0

        # a Jacobian can only be found again with the same rows (steppers/radau.py)
        if better:
            d.jacobian_known[0] = 0.0

        for row in range(m.n_row):
            if better:
                d.row_redundant[row] = REDUNDANT if d.pivot[row] == 0.0 else 0.0
            elif d.row_redundant[row] == CANDIDATE:
                d.row_redundant[row] = REDUNDANT

        # at a singular position there is nothing better
        if not better:
            factor_rows(m, d, False)
            return


@inlined
def solve_rows(m, d):
    """Multipliers of the right-hand side d.row_rhs: least changes in the metric of the inertia."""
    for c in range(m.n_constraint):
        first = m.constraint_neighbour[c]
        end = first + m.constraint_neighbours[c]

        for i in range(m.constraint_rows[c]):
            if d.pivot[m.constraint_row[c] + i] == 0.0:
                d.multiplier[m.constraint_row[c] + i] = 0.0
                continue

            value = d.row_rhs[m.constraint_row[c] + i]

            for t in range(first, end + 1):
                e = m.neighbour_constraint[t] if t < end else c
                n = m.constraint_rows[e]
                at = (m.neighbour_block[t] if t < end else m.constraint_block[c]) + i * n

                for j in range(n if t < end else i):
                    value -= d.factor[at + j] * d.multiplier[m.constraint_row[e] + j]

            d.multiplier[m.constraint_row[c] + i] = value

    for row in range(m.n_row):
        d.multiplier[row] *= d.pivot[row]

    for c in range(m.n_constraint - 1, -1, -1):
        first = m.constraint_neighbour[c]
        end = first + m.constraint_neighbours[c]

        for i in range(m.constraint_rows[c] - 1, -1, -1):
            value = d.multiplier[m.constraint_row[c] + i]

            # of dropped rows it is zero
            if d.pivot[m.constraint_row[c] + i] == 0.0:
                continue

            for t in range(first, end + 1):
                e = m.neighbour_constraint[t] if t < end else c
                n = m.constraint_rows[e]
                at = (m.neighbour_block[t] if t < end else m.constraint_block[c]) + i * n

                for j in range(n if t < end else i):
                    d.multiplier[m.constraint_row[e] + j] -= d.factor[at + j] * value


@inlined
def gather_white(m, d):
    """R^T lambda."""
    for v in range(m.n_v):
        d.white[v] = 0.0

    add_white(m, d)


@inlined
def add_white(m, d):
    """R^T lambda to d.white."""
    for row in range(m.n_row):
        c = m.row_constraint[row]
        at = m.constraint_response[c] + (row - m.constraint_row[c]) * m.constraint_width[c]
        factor = d.multiplier[row]

        if d.pivot[row] == 0.0:
            continue

        for step in range(m.constraint_path[c], m.constraint_path[c] + m.constraint_paths[c]):
            i = m.path_node[step]

            for k in range(joints.n_v(m.body_joint[i])):
                d.white[m.body_v[i] + k] += factor * d.response[at + m.path_at[step] + k]


@inlined
def row_acceleration(m, d, row):
    """g'' of a row by the bodies' accelerations and its bias."""
    c = m.row_constraint[row]
    a = m.marker_body[m.constraint_from[c]]
    b = m.marker_body[m.constraint_to[c]]
    total = d.row_bias[row]
    total += al.dot(al.vec3(d.row_moment_from, row), al.vec3(d.alpha, a))
    total += al.dot(al.vec3(d.row_force_from, row), al.vec3(d.rdd, a))
    total += al.dot(al.vec3(d.row_moment_to, row), al.vec3(d.alpha, b))
    total += al.dot(al.vec3(d.row_force_to, row), al.vec3(d.rdd, b))

    if m.row_kind[row] == rows.COUPLING:
        total += coupling_acceleration(m, d, row)

    return total


@inlined
def coupling_acceleration(m, d, row):
    """What a coupling's coordinates in the tree, and the bodies of all but its first coordinate, add to g''."""
    total = 0.0

    for t in range(m.row_term[row], rows.last_term(m, row)):
        i = rows.body_of_term(m, t)

        if i > 0:
            total += m.term_factor[t] * d.v_rate[m.body_v[i]]
        elif t > m.row_term[row]:
            a, b = rows.bodies_of_term(m, t)
            total += al.dot(al.vec3(d.term_moment_from, t), al.vec3(d.alpha, a))
            total += al.dot(al.vec3(d.term_force_from, t), al.vec3(d.rdd, a))
            total += al.dot(al.vec3(d.term_moment_to, t), al.vec3(d.alpha, b))
            total += al.dot(al.vec3(d.term_force_to, t), al.vec3(d.rdd, b))

    return total


@inlined
def add_changes(m, d):
    """Add the response to v' and to the bodies' accelerations."""
    for v in range(m.n_v):
        d.v_rate[v] += d.change[v]

    for i in range(1, m.n_body):
        al.add_vec3(d.alpha, i, al.vec3(d.change_alpha, i))
        al.add_vec3(d.rdd, i, al.vec3(d.change_rdd, i))
