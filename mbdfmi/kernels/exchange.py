"""What an integrator outside asks for: rates of the state that it gives, and what it should stop at (docs/theory.md 18.13).

Its state need not keep to the constraints: all is evaluated at the nearest one that does, so what leads off the constraints
changes neither rates nor outputs, and nothing of it feeds back.
"""

import math

from .dynamics import projection, rates
from .language import apart, inlined, kernel
from .math import tables
from .motion import coordinates, drives, kinematics
from .signatures import DATA, MODEL, REALS, float64, int64
from .status import NOT_FINITE, OK, status

# a knot is a kink where value, slope or second slope jump by more than this part of their size
KINK = 1e-9

# an indicator of an end that is not there
FAR = 1e30


@apart(int64(MODEL, DATA), "mbdfmi_lead")
def lead(m, d):
    """d.x, given from outside, to the nearest state that keeps to drives and constraints now. Returns a status."""
    rates.set_time(m, d, 0.0)

    if not rates.is_finite(d, m.n_x):
        return status(NOT_FINITE, 0)

    return projection.project(m, d)


@apart(int64(MODEL, DATA), "mbdfmi_rates")
def rates_now(m, d):
    """x' into d.x_rate for d.x, the time and the inputs now. Returns a status."""
    counted = d.evaluations[0]
    failure = rates.evaluate(m, d, 0.0)
    d.evaluations[0] = counted
    total = 0.0

    for k in range(m.n_x):
        total += 0.0 * d.x_rate[k]

    if failure == OK and total != 0.0:
        failure = status(NOT_FINITE, 0)

    return failure


@apart(int64(MODEL, DATA, REALS), "mbdfmi_indicators")
def indicators(m, d, z):
    """How far each stop's coordinate is below its upper end, and above its lower one: z[2 n_stop]. Returns a status."""
    rates.set_time(m, d, 0.0)
    drives.prescribe(m, d)
    kinematics.kinematics(m, d)

    for k in range(m.n_stop):
        x = coordinates.value(m, d, m.stop_coordinate[k])
        z[2 * k] = min(m.stop_upper[k] - x, FAR)
        z[2 * k + 1] = min(x - m.stop_lower[k], FAR)

    return OK


@inlined
def differ(a, b):
    """Whether two numbers are apart by more than rounding."""
    return abs(a - b) > KINK * (abs(a) + abs(b))


@inlined
def before_knot(m, k, i):
    """(value, slope, second slope) of table k left of its knot i."""
    if i == m.table_knot[k]:
        return tables.evaluate(m, k, m.knot_x[i] - 1.0)

    c = 6 * (i - 1)
    s = m.knot_x[i] - m.knot_x[i - 1]
    c1 = m.knot_c[c + 1]
    c2 = m.knot_c[c + 2]
    c3 = m.knot_c[c + 3]
    c4 = m.knot_c[c + 4]
    c5 = m.knot_c[c + 5]
    value = m.knot_c[c] + s * (c1 + s * (c2 + s * (c3 + s * (c4 + s * c5))))
    slope = c1 + s * (2.0 * c2 + s * (3.0 * c3 + s * (4.0 * c4 + s * 5.0 * c5)))
    return value, slope, 2.0 * c2 + s * (6.0 * c3 + s * (12.0 * c4 + s * 20.0 * c5))


@inlined
def after_knot(m, k, i):
    """(value, slope, second slope) of table k right of its knot i."""
    if i == m.table_knot[k] + m.table_knots[k] - 1:
        return tables.evaluate(m, k, m.knot_x[i] + 1.0)

    return m.knot_c[6 * i], m.knot_c[6 * i + 1], 2.0 * m.knot_c[6 * i + 2]


@kernel
def next_of_table(m, k, t):
    """The first kink of table k after t; infinite when there is none."""
    for i in range(m.table_knot[k], m.table_knot[k] + m.table_knots[k]):
        if m.knot_x[i] > t:
            a0, a1, a2 = before_knot(m, k, i)
            b0, b1, b2 = after_knot(m, k, i)

            if i == m.table_knot[k] or i == m.table_knot[k] + m.table_knots[k] - 1:
                # beyond its ends a table goes on straight, from another value of x: the slopes tell
                a0 = b0

            if differ(a0, b0) or differ(a1, b1) or differ(a2, b2):
                return m.knot_x[i]

    return math.inf


@inlined
def next_of_tables(m, k, n, t):
    """The first kink of n tables from k on after t; k < 0: none."""
    found = math.inf

    if k >= 0:
        for i in range(k, k + n):
            found = min(found, next_of_table(m, i, t))

    return found


@apart(float64(MODEL, DATA), "mbdfmi_next_kink")
def next_kink(m, d):
    """s, the first time after now at which a load, a gust or a drive over time has a kink; infinite when there is none."""
    t = d.time[0]
    found = math.inf

    for k in range(m.n_load):
        found = min(found, next_of_tables(m, m.load_force_table[k], 3, t))
        found = min(found, next_of_tables(m, m.load_moment_table[k], 3, t))

    for k in range(m.n_gust):
        found = min(found, next_of_tables(m, m.gust_table[k], 3, t))

    for k in range(m.n_drive):
        kind = m.drive_kind[k]

        if kind == drives.TABLE or kind == drives.SPEED_TABLE:
            found = min(found, next_of_table(m, m.drive_at[k], t))
        elif kind == drives.GROUND_TABLE:
            found = min(found, next_of_tables(m, m.drive_at[k], 7, t))
        elif kind == drives.RAMP:
            for at in (16 * k, 16 * k + 2):
                if m.drive_value[at] > t:
                    found = min(found, m.drive_value[at])

    return found
