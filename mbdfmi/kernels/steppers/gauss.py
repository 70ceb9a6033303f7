"""Gauss collocation with a fixed step: for the long run.

It is symmetric, so that what it does to the energy of a reversible motion is bounded and does not add up, and keeps quadratic
invariants (the length of E) to rounding (docs/theory.md 18.9). The stages are found by fixed-point iteration to rounding: it is not for stiff motions.
"""

import math

import numpy as np

from ...steppers import STEPPERS
from ..dynamics.rates import evaluate
from ..language import inlined, kernel
from ..status import NO_STAGES, OK, status

COUNT = STEPPERS["gauss"].stage_rows
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


@kernel
def step(m, d, s, h):
    """d.x a step of h (s) after x_before, at s (s) of the communication step. Returns a status."""
    n = m.n_x
    failure = OK

    if abs(d.span[0] - h) > 1e-9 * h:
        failure = evaluate(m, d, s)

    if failure == OK:
        guess_rates(m, d, h)
        failure = find_rates(m, d, s, h)

    if failure != OK:
        d.span[0] = 0.0
        return failure

    for k in range(n):
        slope = 0.0

        for j in range(COUNT):
            slope += WEIGHTS[j] * d.dense[j * n + k]

        d.x[k] = d.x_before[k] + h * slope

    d.span[0] = h
    return OK
