"""The course of what is commanded over the communication step: channels, and orientations made of them."""

from ..language import inlined
from ..math import algebra as al
from . import rotations

# coefficients of a channel's course over time; rows of the inputs' buffer: their value and derivatives
N_COURSE = 8

# what commands the orientation of the ground
TURN_NONE = 0
TURN_E = 1
TURN_ZYX = 2
TURN_E_OMEGA = 3
TURN_ZYX_OMEGA = 4


@inlined
def has_omega(m, k):
    """Whether the angular velocity of the ground is commanded beside its orientation."""
    return m.drive_turn[2 * k] >= TURN_E_OMEGA


@inlined
def coefficient(d, c, i):
    """Coefficients of order i of the courses of three channels."""
    k = N_COURSE * c + i
    return (d.command_course[k], d.command_course[k + N_COURSE], d.command_course[k + 2 * N_COURSE])


@inlined
def course(d, c, s):
    """(position, speed, acceleration) of a channel by its commands alone at s (s) of the communication step."""
    p = 0.0
    v = 0.0
    a = 0.0

    for i in range(N_COURSE - 1, -1, -1):
        a = a * s + v
        v = v * s + p
        p = p * s + d.command_course[N_COURSE * c + i]

    return p, v, 2.0 * a


@inlined
def motion(d, c, s):
    """The same with what is led back: the motion that bodies feel."""
    p, v, a = course(d, c, s)
    k = 4 * c
    c1 = d.command_settling[k + 1]
    c2 = d.command_settling[k + 2]
    c3 = d.command_settling[k + 3]
    p += d.command_settling[k] + s * (c1 + s * (c2 + s * c3))
    return p, v + c1 + s * (2.0 * c2 + 3.0 * s * c3), a + 2.0 * c2 + 6.0 * s * c3


@inlined
def vector_course(d, c, s, felt):
    """The same of three channels as vectors; `felt`: with what is led back."""
    x = motion(d, c, s) if felt else course(d, c, s)
    y = motion(d, c + 1, s) if felt else course(d, c + 1, s)
    z = motion(d, c + 2, s) if felt else course(d, c + 2, s)
    return (x[0], y[0], z[0]), (x[1], y[1], z[1]), (x[2], y[2], z[2])


@inlined
def orientation(m, d, k, s, felt):
    """(E, w, w') of the ground that drive k turns at s (s) of the communication step; `felt`: with what is led back."""
    kind = m.drive_turn[2 * k]
    c = m.drive_command[k] + 3
    unit = (0.0, 0.0, 0.0, 1.0)

    if kind == TURN_NONE:
        return unit, al.ZERO3, al.ZERO3

    x, x1, x2 = vector_course(d, c, s, felt)

    if kind == TURN_E:
        last = motion(d, c + 3, s) if felt else course(d, c + 3, s)
        E = (x[0], x[1], x[2], last[0])

        if not al.E_dot(E, E) > 0.0:
            return unit, al.ZERO3, al.ZERO3

        return rotations.rotation_of_E(E, (x1[0], x1[1], x1[2], last[1]), (x2[0], x2[1], x2[2], last[2]))

    if kind == TURN_ZYX:
        return rotations.rotation_of_zyx(x, x1, x2)

    E, w, alpha = rotations.rotation_of_vector(x, x1, x2)
    return al.E_product(E, al.E_at(d.attitude_base, 0)), w, alpha
