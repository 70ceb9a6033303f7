"""What a step of an explicit pair is made of: its stages, the estimates of its error, what is made of these (docs/theory.md 18.4, 18.5)."""

import math

from ..dynamics.rates import is_finite
from ..language import inlined
from . import control, noise
from .tableaux import ERRORS, GAP_COUNT, GAPS, NOISE, ORDER, STAGE_COUNT, STAGE_TOTAL, STAGES

# the tolerance of a step past a singular position, where what rounding and the stages' errors make of the rows is large: nothing is
# gained by less; by how much it is looser each time that the step was rejected, and at most. What a row adds to the others there, and beside what it adds elsewhere in the step; or alone (docs/theory.md 18.4)
ATTAINABLE = 2e-10
LOOSER = 3.0
MOST_TRIES = 8.0
MOST_ATTAINABLE = 1e-8
SINGULAR = 1e-4
PASSING = 0.1
NOTHING = 1e-7

# by what a step is changed that meets a place where a row adds nothing, for there accelerations may be quite wrong, and shortening it by
# its error would lead right into it
ASIDE = 0.75

# how many times the step's own estimate that of an extension must be to have seen what the step's has not
UNSEEN = 3.0


@inlined
def advance(m, d, pair, stage, step):
    """d.x for a stage of a pair, from x_before and the rates of the stages before."""
    n = m.n_x

    for k in range(n):
        slope = 0.0

        for j in range(stage):
            slope += STAGES[pair, stage, j] * d.stage[j * n + k]

        d.x[k] = d.x_before[k] + step * slope


@inlined
def local_error(m, d, pair, step):
    """(estimated error of a step, its estimate of order 5 alone). 1: just allowed. Root mean square over the weighed states.

    The 8(5,3) pair damps its estimate of order 5 by that of order 3 (docs/theory.md 18.4).
    """
    n = m.n_x
    squares = 0.0
    rough = 0.0

    for k in range(n):
        fine = 0.0
        coarse = 0.0

        for j in range(STAGE_COUNT[pair]):
            fine += ERRORS[pair, 0, j] * d.stage[j * n + k]
            coarse += ERRORS[pair, 1, j] * d.stage[j * n + k]

        fine /= d.x_scale[k]
        coarse /= d.x_scale[k]
        squares += fine * fine
        rough += coarse * coarse

    if squares == 0.0:
        return 0.0, 0.0

    return step * squares / math.sqrt((squares + 0.01 * rough) * n), step * math.sqrt(squares / n)


@inlined
def extension_error(m, d, pair, step, fine):
    """(estimated error of a continuous extension with stages of its own, whether the step's own estimate sees hardly any of it).

    1: just allowed at the end of a step (docs/theory.md 18.5).

    Those stages tell what the others have not seen, a kink, and magnify what a stiff motion leaves of it. The extension misses
    the states at which their rates were found by O(h^7) where the motion is smooth; that, weighed so that an error in one of
    these rates counts as much as in the extension, is damped to O(h^8) by the step's estimate of order 5, `fine`.
    """
    n = m.n_x
    squares = 0.0

    for k in range(n):
        for i in range(GAP_COUNT[pair]):
            gap = 0.0

            for j in range(STAGE_TOTAL[pair]):
                gap += GAPS[i, j] * d.stage[j * n + k]

            gap *= step / d.x_scale[k]
            squares += gap * gap

    if squares == 0.0:
        return 0.0, False

    squares /= n
    return squares / math.sqrt(squares + fine * fine / 16.0), squares > UNSEEN * UNSEEN * fine * fine


@inlined
def allowance(m, tries):
    """How many times the allowed error is allowed in a step past a singular position: the more attempts failed, the more."""
    tolerance = max(m.tolerance[0], m.absolute_tolerance[0])

    if tolerance >= ATTAINABLE:
        return 1.0

    return min(MOST_ATTAINABLE, ATTAINABLE * LOOSER ** min(tries, MOST_TRIES)) / tolerance


@inlined
def judge(m, d, pair, step, least, most, tries):
    """(error that decides about a step, its estimate of order 5, the error told, whether the step is past a singular position).

    least, most : of d.least_share in its stages. Errors: 1: just allowed, inf: not a number. d.x is the state it leads to.
    """
    singular = m.n_row > 0 and (least < NOTHING or (least < SINGULAR and least < PASSING * most))
    error, fine = local_error(m, d, pair, step)
    told = error

    if not (error < math.inf and is_finite(d, m.n_x)):
        return math.inf, math.inf, math.inf, singular

    rounding = noise.floor(m, d, NOISE[pair], step)
    error /= rounding
    fine /= rounding

    if singular and error > 1.0:
        error /= allowance(m, tries)
        fine /= allowance(m, tries)

    return error, fine, told, singular


@inlined
def length_again(d, pair, step, error, near):
    """Length (s) of the step in place of one that is rejected, where a singular position is too `near`, or else; counts it."""
    d.rejected[0] += 1.0

    if near:
        return ASIDE * step

    if not error < math.inf:
        return 0.1 * step

    return step * max(control.SHRINK, control.SAFETY * error ** -(1.0 / ORDER[pair]))
