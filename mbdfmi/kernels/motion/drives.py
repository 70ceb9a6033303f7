"""Prescribed motion: of a joint's coordinate, or of the ground in the inertial frame.

A drive gives a motion as a function of time, or of inputs (docs/theory.md 15). A driven joint of the tree is
held (its acceleration is given, hybrid dynamics); one that closes a loop is driven by a row of `rows`.
"""

import math


from ..language import apart, inlined, kernel
from ..math import algebra as al
from ..math import tables
from ..signatures import DATA, MODEL, void
from . import courses, ellipses, rotations

# of one coordinate; drive_value:
CONSTANT_SPEED = 0  # position at the start, speed
HARMONIC = 1  # mean; drive_at, drive_terms: its waves
TABLE = 2  # drive_at: table over time
INPUT = 3  # drive_command: a channel (commands.py)
SPEED_TABLE = 4  # position at the start; drive_at: table of the speed over time
POLYNOMIAL = 5  # drive_terms coefficients of the powers of time, the constant first
RAMP = 6  # time and position at the beginning, time and position at the end

# of the ground; drive_value:
GROUND_ACCELERATION = 7  # position, velocity at time 0, acceleration (3 each)
GROUND_ROTATION = 8  # axis (3), point (3), speed, angle at time 0
GROUND_ORBIT = (
    9  # axes by rows (9): columns radial at angle 0, along the track, normal; radius, rate, phase, 1: points
)
GROUND_TABLE = 10  # drive_at: 7 tables over time, position and E
GROUND_INPUT = 11  # drive_command: channels of position and orientation
GROUND_ELLIPSE = 12  # axes by rows (9): columns to the periapsis, along the track there, normal; semi-major axis, eccentricity,
# mean motion, mean anomaly at time 0, 1: points


@inlined
def waves(m, k, t):
    """(position, rate, acceleration) of the sum of harmonics of drive k at time t."""
    x = m.drive_value[16 * k]
    v = 0.0
    a = 0.0

    for i in range(m.drive_at[k], m.drive_at[k] + m.drive_terms[k]):
        w = 2.0 * math.pi * m.wave_value[3 * i + 1]
        angle = w * t + m.wave_value[3 * i + 2]
        wave = m.wave_value[3 * i] * math.sin(angle)
        x += wave
        v += w * m.wave_value[3 * i] * math.cos(angle)
        a -= w * w * wave

    return x, v, a


@inlined
def power_series(m, k, t):
    """(position, rate, acceleration) of the polynomial of drive k at time t."""
    x = 0.0
    v = 0.0
    half = 0.0

    for i in range(16 * k + m.drive_terms[k] - 1, 16 * k - 1, -1):
        half = v + t * half
        v = x + t * v
        x = m.drive_value[i] + t * x

    return x, v, 2.0 * half


@inlined
def ramp(m, k, t):
    """(position, rate, acceleration) of ramp k at time t: 10 s^3 - 15 s^4 + 6 s^5 of the way, s the part of its time."""
    at = 16 * k
    span = max(1e-12, m.drive_value[at + 2] - m.drive_value[at])
    rise = m.drive_value[at + 3] - m.drive_value[at + 1]
    s = min(1.0, max(0.0, (t - m.drive_value[at]) / span))
    u = 1.0 - s
    speed = rise / span
    x = m.drive_value[at + 1] + rise * (s * s * s * (10.0 - s * (15.0 - 6.0 * s)))

    # at the end exactly there
    return (
        m.drive_value[at + 3] if s == 1.0 else x,
        30.0 * speed * s * s * u * u,
        60.0 * speed / span * s * u * (u - s),
    )


@kernel
def target(m, d, k):
    """(position, rate, acceleration) that drive k of one coordinate asks for now."""
    kind = m.drive_kind[k]
    at = 16 * k
    t = d.now[0]

    if kind == CONSTANT_SPEED:
        speed = m.drive_value[at + 1]
        return m.drive_value[at] + speed * (t - d.start_time[0]), speed, 0.0

    if kind == HARMONIC:
        return waves(m, k, t)

    if kind == POLYNOMIAL:
        return power_series(m, k, t)

    if kind == RAMP:
        return ramp(m, k, t)

    if kind == SPEED_TABLE:
        table = m.drive_at[k]
        speed, acceleration, _ = tables.evaluate(m, table, t)
        way = tables.integral(m, table, t) - tables.integral(m, table, d.start_time[0])
        return m.drive_value[at] + way, speed, acceleration

    if kind == TABLE:
        return tables.evaluate(m, m.drive_at[k], d.now[0])

    return courses.motion(d, m.drive_command[k], d.now[0] - d.time[0])


@inlined
def moves_joints(m):
    """Whether a joint's motion is prescribed."""
    for k in range(m.n_drive):
        if m.drive_kind[k] < GROUND_ACCELERATION:
            return True

    return False


@inlined
def table_vector(m, k, t):
    """Value, slope and second slope of the three tables from k on."""
    x = tables.evaluate(m, k, t)
    y = tables.evaluate(m, k + 1, t)
    z = tables.evaluate(m, k + 2, t)
    return (x[0], y[0], z[0]), (x[1], y[1], z[1]), (x[2], y[2], z[2])


@inlined
def rotation_of_table(m, k, t):
    """(E of unit length, w, w') of the four tables of E from k on; the splines need not keep unit length."""
    a, a1, a2 = table_vector(m, k, t)
    b, b1, b2 = tables.evaluate(m, k + 3, t)
    return rotations.rotation_of_E(
        (a[0], a[1], a[2], b), (a1[0], a1[1], a1[2], b1), (a2[0], a2[1], a2[2], b2)
    )


@inlined
def turned(axes, angle):
    """E of axes (columns) that turned by an angle (rad) about their third."""
    return al.E_product(al.matrix_E(axes), (0.0, 0.0, math.sin(0.5 * angle), math.cos(0.5 * angle)))


@inlined
def ellipse(m, k, t):
    """(r, r', r'', E, w, w') of the ground on the Kepler ellipse of drive k at time t."""
    at = 16 * k
    axes = (al.vec_at(m.drive_value, at), al.vec_at(m.drive_value, at + 3), al.vec_at(m.drive_value, at + 6))
    a = m.drive_value[at + 9]
    e = m.drive_value[at + 10]
    n = m.drive_value[at + 11]
    anomaly = ellipses.eccentric_anomaly(m.drive_value[at + 12] + n * t, e)
    x, y = ellipses.place(anomaly, e)
    x1, y1 = ellipses.velocity(anomaly, e)
    distance = math.sqrt(x * x + y * y)
    r = al.mat_vec(axes, (a * x, a * y, 0.0))
    rd = al.mat_vec(axes, (n * a * x1, n * a * y1, 0.0))
    rdd = al.scale(-n * n / (distance * distance * distance), r)

    if m.drive_value[at + 13] == 0.0:
        return r, rd, rdd, (0.0, 0.0, 0.0, 1.0), al.ZERO3, al.ZERO3

    angle, rate, second = ellipses.true_anomaly(anomaly, e)
    w = al.mat_vec(axes, (0.0, 0.0, n * rate))
    return r, rd, rdd, turned(axes, angle), w, al.mat_vec(axes, (0.0, 0.0, n * n * second))


@kernel
def ground_motion(m, d, k):
    """(r, r', r'', E, w, w') of the ground in the inertial frame by drive k now."""
    kind = m.drive_kind[k]
    at = 16 * k
    t = d.now[0]
    unit = (0.0, 0.0, 0.0, 1.0)

    if kind == GROUND_ACCELERATION:
        a = al.vec_at(m.drive_value, at + 6)
        rd = al.axpy(t, a, al.vec_at(m.drive_value, at + 3))
        r = al.axpy(t, al.axpy(0.5 * t, a, al.vec_at(m.drive_value, at + 3)), al.vec_at(m.drive_value, at))
        return r, rd, a, unit, al.ZERO3, al.ZERO3

    if kind == GROUND_ROTATION:
        axis = al.vec_at(m.drive_value, at)
        point = al.vec_at(m.drive_value, at + 3)
        speed = m.drive_value[at + 6]
        angle = m.drive_value[at + 7] + speed * t
        vector = al.scale(math.sin(0.5 * angle), axis)
        E = (vector[0], vector[1], vector[2], math.cos(0.5 * angle))
        w = al.scale(speed, axis)
        arm = al.mat_vec(al.E_matrix(E), point)
        swing = al.cross(w, arm)
        return al.sub(point, arm), al.neg(swing), al.neg(al.cross(w, swing)), E, w, al.ZERO3

    if kind == GROUND_ORBIT:
        axes = (
            al.vec_at(m.drive_value, at),
            al.vec_at(m.drive_value, at + 3),
            al.vec_at(m.drive_value, at + 6),
        )
        radius = m.drive_value[at + 9]
        rate = m.drive_value[at + 10]
        angle = m.drive_value[at + 11] + rate * t
        c = math.cos(angle)
        s = math.sin(angle)
        r = al.mat_vec(axes, (radius * c, radius * s, 0.0))
        rd = al.mat_vec(axes, (-radius * rate * s, radius * rate * c, 0.0))
        rdd = al.scale(-rate * rate, r)

        if m.drive_value[at + 12] == 0.0:
            return r, rd, rdd, unit, al.ZERO3, al.ZERO3

        return r, rd, rdd, turned(axes, angle), al.mat_vec(axes, (0.0, 0.0, rate)), al.ZERO3

    if kind == GROUND_ELLIPSE:
        return ellipse(m, k, t)

    u = m.drive_at[k]

    if kind == GROUND_TABLE:
        r, rd, rdd = table_vector(m, u, t)
        E, w, alpha = rotation_of_table(m, u + 3, t)
        return r, rd, rdd, E, w, alpha

    s = t - d.time[0]
    r, rd, rdd = courses.vector_course(d, m.drive_command[k], s, True)
    E, w, alpha = courses.orientation(m, d, k, s, True)
    return r, rd, rdd, E, w, alpha


@apart(void(MODEL, DATA))
def prescribe(m, d):
    """Write what drives ask for now into the positions, velocities and accelerations of their joints, which are held."""
    for k in range(m.n_drive):
        i = m.drive_body[k]

        if i < 0:
            continue

        q = m.body_q[i]
        v = m.body_v[i]
        d.held[i] = 1.0

        if m.drive_kind[k] < GROUND_ACCELERATION:
            position, rate, acceleration = target(m, d, k)
            d.q[q] = position
            d.v[v] = rate
            d.v_rate[v] = acceleration
        else:
            r, rd, rdd, E, w, alpha = ground_motion(m, d, k)
            al.set_vec_at(d.q, q, r)
            al.set_E_at(d.q, q + 3, E)
            al.set_vec_at(d.v, v, rd)
            A = al.E_matrix(E)
            al.set_vec_at(d.v, v + 3, al.matT_vec(A, w))
            al.set_vec_at(d.v_rate, v, rdd)
            al.set_vec_at(d.v_rate, v + 3, al.matT_vec(A, alpha))
