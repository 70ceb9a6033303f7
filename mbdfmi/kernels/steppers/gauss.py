"""Gauss collocation with a fixed step: for the long run.

It is symmetric, so that what it does to the energy of a reversible motion is bounded and does not add up, and keeps quadratic
invariants (the length of E) to rounding (docs/theory.md 18.9). The stages are found by fixed-point iteration to rounding: it is not for stiff motions.
"""

import math

import numpy as np
from numba.types import Tuple, float64, int64

from ..dynamics.projection import keep_x, restore_x
from ..dynamics.rates import evaluate
from ..language import apart, inlined, kernel
from ..status import NO_STAGES, OK, TOO_MUCH_WORK, status
from ..views import DATA, MODEL
from . import control

COUNT = 4
MAX_ITERATIONS = 60

# the iteration has done what it can when changes (of states of size 1) are at rounding or, near it, no longer shrink;
# after some that did not shrink, what is left is the noise of the accelerations themselves
ROUNDING = 1e-16
STALLED = 1e-11
NOISE = 1e-6
STALLS = 3

# nodes c, matrix A, weights b of COUNT Gauss points, and the matrix that extrapolates the rates of a step to the next; to 17
# digits, for every machine must have the same bits
NODES = np.array([0.06943184420297371, 0.33000947820757187, 0.6699905217924281, 0.9305681557970263])
WEIGHTS = np.array([0.17392742256872692, 0.32607257743127305, 0.32607257743127305, 0.17392742256872692])
STAGES = np.array(
    [
        [0.08696371128436346, -0.026604180084998794, 0.012627462689404725, -0.0035551496857956833],
        [0.18811811749986806, 0.16303628871563652, -0.027880428602470895, 0.006735500594538156],
        [0.16719192197418878, 0.35395300603374397, 0.16303628871563652, -0.014190694931141144],
        [0.1774825722545226, 0.31344511474186837, 0.35267675751627187, 0.08696371128436346],
    ]
)
ONWARD = np.array(
    [
        [-0.3043475322896335, 1.0425440204501055, -1.929896390297009, 2.191699902136537],
        [-1.956342611081263, 6.246427614654768, -9.46401244076669, 6.173927437193185],
        [-7.352359801851611, 22.244205449220566, -29.80681363156252, 15.914967984193565],
        [-14.971892910590412, 44.09613181879383, -55.9889724574008, 27.864733549197386],
    ]
)


@inlined
def guess_rates(m, d, h):
    """Rates of the stages from those of the step before when it was as long, else from d.x_rate."""
    n = m.n_x
    same = abs(d.span[0] - h) <= 1e-9 * h

    for k in range(n):
        for i in range(COUNT):
            value = d.x_rate[k]

            if same:
                value = 0.0

                for j in range(COUNT):
                    value += ONWARD[i, j] * d.dense[j * n + k]

            d.stage[i * n + k] = value

    for k in range(COUNT * n):
        d.dense[k] = d.stage[k]


@kernel
def find_rates(m, d, s, h):
    """Rates of the stages of a step of h from s (s) on, into d.dense, by fixed-point iteration. Returns a status."""
    n = m.n_x
    before = math.inf
    stalls = 0

    for iteration in range(MAX_ITERATIONS):
        change = 0.0

        for i in range(COUNT):
            for k in range(n):
                slope = 0.0

                for j in range(COUNT):
                    slope += STAGES[i, j] * d.dense[j * n + k]

                d.x[k] = d.x_before[k] + h * slope

            failure = evaluate(m, d, s + NODES[i] * h)

            # an iteration that diverges ends so
            if failure != OK:
                return failure if iteration == 0 else status(NO_STAGES, 0)

            for k in range(n):
                moved = abs(h * (d.x_rate[k] - d.dense[i * n + k])) / (1.0 + abs(d.x_before[k]))
                change = max(change, moved if moved < math.inf else math.inf)
                d.dense[i * n + k] = d.x_rate[k]

        if not change < math.inf:
            break

        stalls += 1 if change >= before else 0

        if change <= ROUNDING or (stalls > 0 and change < STALLED) or (stalls >= STALLS and change < NOISE):
            return OK

        before = change

    return status(NO_STAGES, 0)


@apart(Tuple((int64, float64))(MODEL, DATA, float64))
def gauss(m, d, H):
    """Gauss collocation of order 2 COUNT: equal inner steps of at most m.step over H (s).

    Returns (status, time reached within H).
    """
    n = m.n_x
    n_step, h = control.equal_steps(H, m.step[0])
    step = 0

    while step < n_step:
        s = step * h

        if control.is_spent(d):
            return status(TOO_MUCH_WORK, 0), s

        keep_x(m, d)
        failure = OK

        if abs(d.span[0] - h) > 1e-9 * h:
            failure = evaluate(m, d, s)

        if failure == OK:
            guess_rates(m, d, h)
            failure = find_rates(m, d, s, h)

        if failure != OK:
            restore_x(m, d)
            d.span[0] = 0.0
            return failure, s

        for k in range(n):
            slope = 0.0

            for j in range(COUNT):
                slope += WEIGHTS[j] * d.dense[j * n + k]

            d.x[k] = d.x_before[k] + h * slope

        d.span[0] = h
        failure = control.accept(m, d, s + h)

        if failure != OK:
            return failure, s

        step += 1

    return OK, H
