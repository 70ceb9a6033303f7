"""When `auto` leaves an explicit pair for its implicit method, and when it goes back: by what either costs (docs/theory.md 18.10).

Costs are counted in evaluations of x'; the work of linear systems is known from the model, in the same unit. A pair at the border of
its stability costs a number of evaluations a second, in proportion to the spectral radius. What the implicit method costs is seen when it
is tried; trying costs a Jacobian and some factors. So it is tried once the pair has spent a few times as much, and left when it does
not pay; each time it did not, the pair may spend more before the next attempt.
"""

from ...steppers import RKC, STEPPERS
from ..language import inlined
from .tableaux import STABLE

# where a step is beside the border of stability: within, or at it by what oscillates, by what decays
WITHIN, OSCILLATES, DECAYS = 0, 1, 2

# part of the steps at the border that are so by what decays where the stabilised method is tried, and its first step by that of 8(5,3)
MOSTLY = 0.7
MANY = 10.0

# d.border_pair
NONE, LOWER, STABILISED = 0.0, 1.0, 2.0

RK54, RK853 = (STEPPERS[name].number for name in ("rk54", "rk853"))

# steps at the border of stability that make a motion stiff, and steps in a row within it that make it not
STIFF_AFTER = 15.0
STABLE_AFTER = 6.0

# what a pair spends before the implicit method is tried, by the cost of a Jacobian with its factors; where a communication step takes
# very many steps of the pair, it is likely to pay
TRY_AFTER = 4.0
VERY_MANY = 50.0
TRY_SOON_AFTER = 1.5

# the factor on that when it did not pay, and the largest
LESS_OFTEN = 4.0
PATIENCE = 4096.0

# steps of 8(5,3) at the border of stability after which 5(4) is tried there; its steps that let their length settle, and then those
# that tell; what it may cost beside 8(5,3), since there it errs less; its steps in a row within the border that end it
TRIAL_AFTER = 8.0
SETTLING = 3.0
TRIED = 8.0
WORTH = 1.15
CALM = 30.0

# evaluations a second of a pair at the border, by the spectral radius, where it was left for another reason
AT_BORDER = 2.0

# steps of the implicit method that let its length grow; then those that can tell whether it pays
GROWING = 3.0
TELLING = 5.0

# evaluations of an implicit step, at least
LEAST_WORK = 10.0


@inlined
def start(d):
    """Nothing is known of the motion."""
    d.stiff_steps[0] = 0.0
    d.stable_steps[0] = 0.0
    d.pair_rate[0] = 0.0
    d.pair_radius[0] = 0.0
    d.radius[0] = 0.0
    d.implicit_steps[0] = 0.0
    d.patience[0] = 1.0
    d.border_pair[0] = NONE
    d.border_trial[0] = TRIAL_AFTER
    d.border_trial[1] = TRIAL_AFTER


@inlined
def leaves_pair(m, d, step, kind, H):
    """Whether to try the implicit method after a step (s) of a pair. kind : where it was beside the border of its stability."""
    d.border_span[0] += step

    at_border = kind != WITHIN

    if not at_border:
        d.stable_steps[0] += 1.0

        if d.stable_steps[0] >= STABLE_AFTER:
            d.stiff_steps[0] = 0.0

        return False

    d.stable_steps[0] = 0.0
    d.stiff_steps[0] += 1.0

    if d.stiff_steps[0] == 1.0:
        d.border_work[0] = d.evaluations[0]
        d.border_span[0] = 0.0
        d.border_decays[0] = 0.0

    d.border_decays[0] += 1.0 if kind == DECAYS else 0.0
    spent = d.evaluations[0] - d.border_work[0]
    price = m.jacobian_work[0] + m.lu_work[0]
    after = TRY_SOON_AFTER if d.patience[0] == 1.0 and step * VERY_MANY < H else TRY_AFTER * d.patience[0]

    if m.n_jacobian == 0 or d.stiff_steps[0] < STIFF_AFTER or spent < after * price:
        return False

    d.pair_rate[0] = spent / d.border_span[0]
    return True


@inlined
def leaves_decaying(m, d, step):
    """The same after a step of the stabilised method."""
    d.border_span[0] += step
    spent = d.evaluations[0] - d.border_work[0]
    after = TRY_SOON_AFTER if d.patience[0] == 1.0 else TRY_AFTER * d.patience[0]

    if m.n_jacobian == 0 or spent < after * (m.jacobian_work[0] + m.lu_work[0]):
        return False

    d.pair_rate[0] = spent / d.border_span[0]
    return True


@inlined
def see_border(d, radius):
    """A spectral radius (1/s) that the stabilised method has found: what a pair costs goes with it."""
    if d.border_radius[0] > 0.0:
        d.border_cost[0] *= radius / d.border_radius[0]

    d.border_radius[0] = radius


@inlined
def begin_trial(d, kind, number, length):
    """A method goes on in place of 8(5,3), with steps of that length (s)."""
    d.border_cost[0] = (d.evaluations[0] - d.border_work[0]) / d.border_span[0]
    d.border_pair[0] = kind
    d.trial_steps[0] = 0.0
    d.next_step[number] = length


@inlined
def watch_border(d, pair, step, H):
    """After a step (s) that is counted: what goes on at the border of stability, which is what costs less there.

    Returns whether this has changed.
    """
    if d.border_pair[0] == NONE:
        if pair != RK853 or d.stable_steps[0] > 0.0:
            return False

        steps = d.stiff_steps[0]

        # a lasting decay, in communication steps that are long enough for many stages
        if steps >= d.border_trial[1] and d.border_decays[0] > MOSTLY * steps and step * VERY_MANY < H:
            begin_trial(d, STABILISED, RKC.number, MANY * step)
            d.border_work[0] = d.evaluations[0]
            d.border_span[0] = 0.0
            d.border_radius[0] = 0.0
            d.radius_steps[0] = 0.0
        elif steps >= d.border_trial[0]:
            begin_trial(d, LOWER, RK54, step * STABLE[RK54] / STABLE[RK853])

        return d.border_pair[0] != NONE

    if pair != RK54 and pair != RKC.number:
        return False

    d.trial_steps[0] += 1.0
    d.trial_span[0] += step

    if d.trial_steps[0] == SETTLING:
        d.trial_work[0] = d.evaluations[0]
        d.trial_span[0] = 0.0

    calm = pair == RK54 and d.stable_steps[0] >= CALM
    told = d.trial_steps[0] >= SETTLING + TRIED
    spent = d.evaluations[0] - d.trial_work[0]
    which = 0 if pair == RK54 else 1

    if calm or (told and spent > WORTH * d.border_cost[0] * d.trial_span[0]):
        d.border_pair[0] = NONE
        d.border_trial[which] = min(PATIENCE, LESS_OFTEN * d.border_trial[which])
        d.next_step[RK853] = step * STABLE[RK853] / STABLE[RK54]

        if pair != RK54 and d.border_radius[0] > 0.0:
            d.next_step[RK853] = STABLE[RK853] / d.border_radius[0]

    elif told:
        d.border_trial[which] = TRIAL_AFTER
        d.trial_work[0] += 0.5 * spent
        d.trial_span[0] *= 0.5
        d.trial_steps[0] -= 0.5 * TRIED

    return d.border_pair[0] == NONE


@inlined
def change(d):
    """The method was changed: what was seen of the one before counts no more."""
    d.stiff_steps[0] = 0.0
    d.border_pair[0] = NONE
    d.pair_radius[0] = 0.0
    d.implicit_steps[0] = 0.0


@inlined
def see_radius(d, radius):
    """A new Jacobian and its spectral radius (1/s)."""
    d.radius[0] = radius

    if d.pair_radius[0] == 0.0:
        d.pair_radius[0] = radius


@inlined
def rate_of_pair(d):
    """Evaluations a second that a pair would cost now."""
    if d.pair_rate[0] > 0.0 and d.pair_radius[0] > 0.0:
        return d.pair_rate[0] * d.radius[0] / d.pair_radius[0]

    return AT_BORDER * d.radius[0]


@inlined
def leaves_implicit(m, d, step):
    """Whether a pair would cost less, after a step (s) of the implicit method."""
    now = d.evaluations[0] + d.linear_work[0]
    d.implicit_steps[0] += 1.0
    d.implicit_span[0] += step
    steps = d.implicit_steps[0]

    if steps <= 1.0:
        d.implicit_span[0] = 0.0

    worth = rate_of_pair(d) * d.implicit_span[0]

    # not even if it had its Jacobian and factors for nothing
    seen = steps - 1.0 if steps <= GROWING else steps - GROWING
    hopeless = steps >= GROWING and worth < LEAST_WORK * seen

    if steps == GROWING and not hopeless:
        d.implicit_work[0] = now
        d.implicit_span[0] = 0.0

    if steps < GROWING + TELLING and not hopeless:
        return False

    work = now - d.implicit_work[0]
    price = m.jacobian_work[0] + m.lu_work[0]

    if not hopeless and work > worth and work < 2.0 * price:
        return False

    if hopeless or work > worth:
        d.patience[0] = min(PATIENCE, LESS_OFTEN * d.patience[0])
        return True

    d.patience[0] = 1.0
    d.implicit_work[0] = now - 0.5 * work
    d.implicit_span[0] *= 0.5
    d.implicit_steps[0] -= 0.5 * (steps - GROWING)
    return False
