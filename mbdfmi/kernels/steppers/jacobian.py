"""The Jacobian J = dx'/dx by differences, and how stiff it says that the motion is.

Its blocks, and which of their columns are found in one evaluation, are known from the model (compiler/jacobian.py).
"""

import math

from ..dynamics.rates import evaluate_now
from ..language import apart, kernel
from ..status import OK
from ..signatures import DATA, MODEL, int64
from . import control

# of the states
INCREMENT = 1e-7


@kernel
def move_columns(m, d, colour, c):
    """Column c of each block of a colour is moved: x there goes to d.right, the change to d.right beyond n_x."""
    first = m.colour_member[colour]

    for k in range(first, first + m.colour_members[colour]):
        b = m.member_block[k]

        if c < m.block_size[b]:
            p = m.block_place[b] + c
            at = m.place_x[p]
            d.right[p] = d.x[at]
            d.x[at] += INCREMENT / m.tolerance[0] * d.x_scale[at]
            d.right[m.n_x + p] = d.x[at] - d.right[p]


@kernel
def read_columns(m, d, colour, c, row):
    """These columns of J from the rates, and those before at d.stage's `row`; x is moved back."""
    first = m.colour_member[colour]

    for k in range(first, first + m.colour_members[colour]):
        b = m.member_block[k]

        if c >= m.block_size[b]:
            continue

        p = m.block_place[b] + c
        change = d.right[m.n_x + p]
        d.x[m.place_x[p]] = d.right[p]

        for entry in range(m.block_column[b], m.block_column[b] + m.block_columns[b]):
            e = m.column_element[entry]
            at = c - m.element_first[e]
            width = m.element_width[e]

            if 0 <= at < width:
                to = m.column_row[entry]

                for i in range(m.block_size[to]):
                    x = m.place_x[m.block_place[to] + i]
                    d.jacobian[m.element_value[e] + width * i + at] = (
                        d.x_rate[x] - d.stage[row * m.n_x + x]
                    ) / change


@apart(int64(MODEL, DATA, int64))
def find_jacobian(m, d, row):
    """J = df/dx by forward differences at x, the time and the inputs now; needs f there in d.stage's `row`. Returns a status.

    Increments are in proportion to the error weights, which know the sizes of the states, and large enough for the rounding
    of accelerations of parts of next to no inertia. Leaves unwidened weights.
    """
    control.weigh(m, d)

    for k in range(m.n_jacobian):
        d.jacobian[k] = 0.0

    for colour in range(m.n_colour):
        for c in range(m.colour_width[colour]):
            move_columns(m, d, colour, c)
            failure = evaluate_now(m, d)
            read_columns(m, d, colour, c, row)

            if failure != OK:
                return failure

    return OK


@kernel
def multiply(m, d, x, y):
    """d.stage[y:] = J d.stage[x:], both in the order of elimination. Returns the square of its length."""
    size = 0.0

    for b in range(m.n_block):
        for i in range(m.block_size[b]):
            value = 0.0

            for e in range(m.block_element[b], m.block_element[b] + m.block_elements[b]):
                row = m.element_value[e] + m.element_width[e] * i
                at = x + m.block_place[m.element_block[e]] + m.element_first[e]

                for c in range(m.element_width[e]):
                    value += d.jacobian[row + c] * d.stage[at + c]

            d.stage[y + m.block_place[b] + i] = value
            size += value * value

    return size


@kernel
def spectral_radius(m, d, row):
    """About the largest |eigenvalue| (1/s) of J, by the power method: growth over an even number of products.

    Takes two rows of d.stage, from `row` on.

    J^2 is what has a pair of imaginary eigenvalues as one real one.
    """
    n = m.n_x
    x = row * n
    y = (row + 1) * n
    growth = 0.0

    for p in range(n):
        k = m.place_x[p]
        d.stage[x + p] = math.cos(1.7 * k * k + 0.3)

    for turn in range(12):
        size = multiply(m, d, x, y)

        if not 0.0 < size < math.inf:
            return 0.0

        if turn >= 6:
            growth += 0.5 * math.log(size)

        for k in range(n):
            d.stage[x + k] = d.stage[y + k] / math.sqrt(size)

    return math.exp(growth / 6.0)
