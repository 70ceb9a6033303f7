"""The Jacobian J = dx'/dx by differences, and how stiff it says that the motion is."""

import math


from ..dynamics.rates import evaluate
from ..language import apart, kernel
from ..status import OK
from ..signatures import DATA, MODEL, float64, int64
from . import control

# of the states
INCREMENT = 1e-7

# work of the factors of a matrix of its size over the square of the number of states, in evaluations
LU_WORK = 0.02


@apart(int64(MODEL, DATA, float64))
def find_jacobian(m, d, s):
    """J = df/dx by forward differences at x and s (s), by rows; needs f there in stage 0. Returns a status.

    Increments are in proportion to the error weights, which know the sizes of the states, and large enough for the rounding
    of accelerations of parts of next to no inertia. Leaves unwidened weights.
    """
    n = m.n_x
    failure = OK
    control.weigh(m, d)

    # nothing depends on angles outside the tree but through their turns
    for k in range(n):
        for column in range(n - m.n_turn, n):
            d.jacobian[n * k + column] = 0.0

    for column in range(n - m.n_turn):
        x = d.x[column]
        d.x[column] = x + INCREMENT / m.tolerance[0] * d.x_scale[column]
        change = d.x[column] - x
        failure = evaluate(m, d, s)
        d.x[column] = x

        if failure != OK:
            break

        for k in range(n):
            d.jacobian[n * k + column] = (d.x_rate[k] - d.stage[k]) / change

    return failure


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

    for k in range(n):
        d.stage[x + k] = math.cos(1.7 * k * k + 0.3)

    for turn in range(12):
        size = 0.0

        for i in range(n):
            value = 0.0

            for j in range(n):
                value += d.jacobian[n * i + j] * d.stage[x + j]

            d.stage[y + i] = value
            size += value * value

        if not 0.0 < size < math.inf:
            return 0.0

        if turn >= 6:
            growth += 0.5 * math.log(size)

        for k in range(n):
            d.stage[x + k] = d.stage[y + k] / math.sqrt(size)

    return math.exp(growth / 6.0)
