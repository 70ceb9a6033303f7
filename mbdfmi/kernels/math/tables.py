"""Piecewise polynomials of degree 5 at most: value, slopes and integral (docs/theory.md 16.11).

Table k has knots x_0 < ... < x_n; between two of them it is c0 + c1 s + ... + c5 s^5 with s from the left one. Beyond the
ends it goes on straight (LINEAR) or keeps its end value (HOLD).
"""

from ..language import inlined

HOLD = 0
LINEAR = 1


@inlined
def left_knot(knot_x, first, knots, x):
    """Of `knots` ascending numbers, from knot_x[first] on, the one left of x, by bisection; the first or last but one beyond the ends."""
    low = first
    high = first + knots - 1

    while high - low > 1:
        middle = (low + high) // 2

        if x < knot_x[middle]:
            high = middle
        else:
            low = middle

    return low


@inlined
def interval(m, k, x):
    """The knot of table k left of x; the first or last interval beyond the ends."""
    return left_knot(m.knot_x, m.table_knot[k], m.table_knots[k], x)


@inlined
def first(m, k):
    """Where table k begins."""
    return m.knot_x[m.table_knot[k]]


@inlined
def last(m, k):
    """Where table k ends."""
    return m.knot_x[m.table_knot[k] + m.table_knots[k] - 1]


@inlined
def clamped(m, k, x):
    """x moved to the nearest end of table k where it lies beyond."""
    return min(max(x, first(m, k)), last(m, k))


@inlined
def polynomial(m, k, x):
    """(value, slope, second slope) of table k at x between its ends."""
    i = interval(m, k, x)
    s = x - m.knot_x[i]
    c1 = m.knot_c[6 * i + 1]
    c2 = m.knot_c[6 * i + 2]
    c3 = m.knot_c[6 * i + 3]
    c4 = m.knot_c[6 * i + 4]
    c5 = m.knot_c[6 * i + 5]
    value = m.knot_c[6 * i] + s * (c1 + s * (c2 + s * (c3 + s * (c4 + s * c5))))
    slope = c1 + s * (2.0 * c2 + 3.0 * s * c3 + s * s * (4.0 * c4 + 5.0 * s * c5))
    return value, slope, 2.0 * c2 + 6.0 * s * c3 + s * s * (12.0 * c4 + 20.0 * s * c5)


@inlined
def evaluate(m, k, x):
    """(value, slope, second slope) of table k at x."""
    inside = clamped(m, k, x)
    value, slope, second = polynomial(m, k, inside)

    if inside == x:
        return value, slope, second

    if m.table_beyond[k] == LINEAR:
        return value + slope * (x - inside), slope, 0.0

    return value, 0.0, 0.0


@inlined
def third(m, k, x):
    """Third slope of table k at x."""
    if clamped(m, k, x) != x:
        return 0.0

    i = interval(m, k, x)
    s = x - m.knot_x[i]
    return 6.0 * m.knot_c[6 * i + 3] + s * (24.0 * m.knot_c[6 * i + 4] + 60.0 * s * m.knot_c[6 * i + 5])


@inlined
def integral(m, k, x):
    """Integral of table k from its first knot to x."""
    inside = clamped(m, k, x)
    i = interval(m, k, inside)
    s = inside - m.knot_x[i]
    c = 6 * i
    total = m.knot_c[c + 3] / 4.0 + s * (m.knot_c[c + 4] / 5.0 + s * m.knot_c[c + 5] / 6.0)
    total = m.knot_c[c] + s * (m.knot_c[c + 1] / 2.0 + s * (m.knot_c[c + 2] / 3.0 + s * total))
    total = m.knot_area[i] + s * total
    value, slope, _ = polynomial(m, k, inside)
    beyond = x - inside
    return total + value * beyond + (0.5 * slope * beyond * beyond if m.table_beyond[k] == LINEAR else 0.0)
