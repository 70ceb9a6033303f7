"""When `auto` leaves an explicit pair for its implicit method, and when it goes back: by what either costs (docs/theory.md 18.10).

Costs are counted in evaluations of x'; the work of linear systems is known from the model, in the same unit. A pair at the border of
its stability costs a number of evaluations a second, in proportion to the spectral radius. What the implicit method costs is seen when it
is tried; trying costs a Jacobian and some factors. So it is tried once the pair has spent a few times as much, and left when it does
not pay; each time it did not, the pair may spend more before the next attempt.
"""

from ..language import inlined

# steps at the border of stability that make a motion stiff, and steps in a row within it that make it not
STIFF_AFTER = 15.0
STABLE_AFTER = 6.0

# what a pair spends before the implicit method is tried, by the cost of a Jacobian with its factors
TRY_AFTER = 4.0

# the factor on that when it did not pay, and the largest
LESS_OFTEN = 4.0
PATIENCE = 4096.0

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


@inlined
def leaves_pair(m, d, step, at_border):
    """Whether to try the implicit method after a step (s) of a pair, which may be at the border of its stability."""
    d.border_span[0] += step

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

    spent = d.evaluations[0] - d.border_work[0]
    price = m.jacobian_work[0] + m.lu_work[0]

    if d.stiff_steps[0] < STIFF_AFTER or spent < d.patience[0] * TRY_AFTER * price:
        return False

    d.pair_rate[0] = spent / d.border_span[0]
    return True


@inlined
def change(d):
    """The method was changed: what was seen of the one before counts no more."""
    d.stiff_steps[0] = 0.0
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
