"""A course over the step to come: by history, or by the slope that the master gives (docs/theory.md 15.4)."""

import math

from ..language import inlined

# a higher order must tell the last commands by so much better
BETTER = 0.9

# a command that its derivative led to, relative to the change
LED = 1e-6

# ratio of two guesses of a curvature where a course is smooth
ALIKE = 3.0

# part of a command that may be rounding
ROUNDED = 2e-15


@inlined
def felt(difference, rounding):
    """A difference of commands, 0 where it is no more than what rounding makes of them."""
    return difference if abs(difference) > rounding else 0.0


@inlined
def differences(m, d, c, x):
    """(divided differences of orders 1 to 4 at the present value x and the last ones, by time, what rounding may make of the
    first two).

    After steps much shorter than others the higher ones are rounding over a power of the step: those count as 0.
    """
    h1 = d.command_steps[0]
    h2 = d.command_steps[1]
    h3 = d.command_steps[2]
    h4 = d.command_steps[3]
    x1 = d.command_past[4 * c]
    x2 = d.command_past[4 * c + 1]
    x3 = d.command_past[4 * c + 2]
    x4 = d.command_past[4 * c + 3]
    eps = ROUNDED * max(max(abs(x), abs(x1)), max(abs(x2), max(abs(x3), abs(x4))))
    a1 = (x - x1) / h1
    a2 = (x1 - x2) / h2
    a3 = (x2 - x3) / h3
    of_b1 = (eps / h1 + eps / h2) / (h1 + h2)
    of_b2 = (eps / h2 + eps / h3) / (h2 + h3)
    of_b3 = (eps / h3 + eps / h4) / (h3 + h4)
    b1 = (a1 - a2) / (h1 + h2)
    b2 = (a2 - a3) / (h2 + h3)
    b3 = (a3 - (x3 - x4) / h4) / (h3 + h4)
    of_c1 = (of_b1 + of_b2) / (h1 + h2 + h3)
    of_c2 = (of_b2 + of_b3) / (h2 + h3 + h4)
    c1 = (b1 - b2) / (h1 + h2 + h3)
    fourth = (c1 - (b2 - b3) / (h2 + h3 + h4)) / (h1 + h2 + h3 + h4)
    fourth = felt(fourth, (of_c1 + of_c2) / (h1 + h2 + h3 + h4))
    return (a1, felt(b1, of_b1), felt(c1, of_c1), fourth), (eps / h1, of_b1)


@inlined
def errors_told(d, differences):
    """By how much polynomials of order 0 to 3 through the commands before miss the present one."""
    t1 = d.command_steps[0]
    t2 = t1 + d.command_steps[1]
    t3 = t2 + d.command_steps[2]
    t4 = t3 + d.command_steps[3]
    e0 = abs(differences[0]) * t1
    e1 = abs(differences[1]) * t1 * t2
    e2 = abs(differences[2]) * t1 * t2 * t3
    return e0, e1, e2, abs(differences[3]) * t1 * t2 * t3 * t4


@inlined
def best_order(d, c, errors):
    """Order of the polynomial that would best have told the last two commands; 1 where only one was there before."""
    known = d.command_known[0]

    if known < 2.0:
        return int(known)

    order = 0
    least = errors[0] + d.command_error[4 * c]
    missed = errors[1] + d.command_error[4 * c + 1]

    if missed < BETTER * least:
        order = 1
        least = missed

    missed = errors[2] + d.command_error[4 * c + 2]

    if known > 2.0 and missed < BETTER * least:
        order = 2
        least = missed

    missed = errors[3] + d.command_error[4 * c + 3]

    if known > 3.0 and missed < BETTER * least:
        order = 3

    return order


@inlined
def by_history(d, c, x):
    """Coefficients (4) of the polynomial over time through x and the last commands."""
    order = best_order(d, c, errors_told(d, x))
    h1 = d.command_steps[0]
    h2 = h1 + d.command_steps[1]
    slope = x[0] if order > 0 else 0.0
    second = x[1] if order > 1 else 0.0
    third = x[2] if order > 2 else 0.0
    return slope + second * h1 + third * h1 * h2, second + third * (h1 + h2), third


@inlined
def by_slope(m, d, c, x, slope, H, differences, rounding):
    """The same where the master gives the slope alone over a step of H (s), 0: at a point.

    rounding : what it may make of the first two differences.
    """
    known = d.command_known[0]
    h1 = d.command_steps[0]
    aim = d.command_aim[2 * c]
    change = d.command_aim[2 * c + 1]

    if known < 1.0:
        return slope, 0.0, 0.0

    missed = x - aim

    if H > 0.0 and change != 0.0 and abs(missed) <= LED * abs(change) + 1e-13 * abs(x):
        second = felt(slope - differences[0], rounding[0]) / (H + h1)
        third = felt(second - differences[1], rounding[0] / (H + h1) + rounding[1]) / (
            H + h1 + d.command_steps[1]
        )
        third = third if known > 1.0 else 0.0
        return slope - second * H - third * H * h1, second - third * (H - h1), third

    # two guesses, which hardly differ unless there was a jump or a corner: those are not carried on
    second = felt(slope - differences[0], rounding[0]) / h1
    other = missed / (h1 * h1)
    least = min(abs(second), abs(other))

    if second * other <= 0.0:
        return slope, 0.0, 0.0

    if max(abs(second), abs(other)) > ALIKE * least:
        return slope, math.copysign(least, second), 0.0

    # the cubic through both commands and slopes
    third = (slope + change / h1 - 2.0 * differences[0]) / (h1 * h1)
    return slope, second + third * h1, third
