"""Motion commanded by inputs: what a drive does between the communication points at which it is told.

The rules are in docs/theory.md 15.4. A *channel* is one number that inputs command: the coordinate of a joint; of the ground x, y, z and its orientation. Inputs tell
its position and may tell its speed and acceleration. Of these the highest is continued over the communication step ahead, the
lower ones follow by integration from their own values, which thus are met exactly at its start:

- by the input's own derivatives, where the master gives them. With the first alone it depends: if the last step's led to the
  next command, they tell the end of the step (the master interpolates), else the slope at its start;
- else by the polynomial through the last commands, of the order (0 to 3) that would best have told the last two of them: a
  course that jumps or has corners is not carried on beyond them.

The motion is C1 for the bodies on it: what it was off when the commands came (of position and speed) is led back to zero over
the step by a cubic. Nothing is applied at once, and a free body stays where it is whatever the commands do. At the start, and
until a speed is known, there is nothing to lead back. Outputs at a communication point are those of the commands alone.

The orientation of the ground is commanded by Euler parameters or by ZYX angles, whose numbers are the channels; with an angular
velocity the channels are the components of a rotation vector from the commanded orientation on, E(s) = exp(phi(s)) E(0).
"""

import math

import numpy as np
from ..language import inlined, kernel
from ..math import algebra as al
from . import courses, extrapolation, rotations
from .doubts import doubt
from .inputs import N_DERIVATIVE, derivative, highest, polynomial, told

# rad, how near a command that jumped by whole turns must be to where the last ones led
SAME_ANGLE = 1.0


@kernel
def forget(m, d):
    """No commands were given before."""
    d.command_known[0] = 0.0

    for k in range(4):
        d.command_steps[k] = 1.0

    for k in range(4 * m.n_command):
        d.command_past[k] = 0.0
        d.command_error[k] = 0.0

    for c in range(m.n_command):
        d.command_aim[2 * c] = 0.0
        d.command_aim[2 * c + 1] = 0.0
        d.command_blind[c] = 1.0

    for k in range(2 * m.n_drive):
        d.drive_doubt[k] = 0.0


@inlined
def plan_channel(m, d, c, p, v, x, H):
    """The course of a channel from its position p and speed v on, x being the highest of what is told, into d.command_course."""
    k = courses.N_COURSE * c
    what = highest(m, c)
    u = m.command_u[3 * c + what]
    n = m.n_u
    slope = 0.0
    c2 = 0.0
    c3 = 0.0
    c4 = 0.0
    c5 = 0.0
    told_on = False

    if u >= 0:
        slope = d.u_buffer[n + u]
        c2 = d.u_buffer[2 * n + u] / 2.0
        c3 = d.u_buffer[3 * n + u] / 6.0
        c4 = d.u_buffer[4 * n + u] / 24.0
        c5 = d.u_buffer[5 * n + u] / 120.0

        told_on = slope != 0.0 or c2 != 0.0 or c3 != 0.0 or c4 != 0.0 or c5 != 0.0

        if c2 == 0.0 and c3 == 0.0 and c4 == 0.0 and c5 == 0.0:
            found, rounding = extrapolation.differences(m, d, c, x)

            if told_on:
                slope, c2, c3 = extrapolation.by_slope(m, d, c, x, slope, H, found, rounding)
            else:
                slope, c2, c3 = extrapolation.by_history(d, c, found)

    for i in range(courses.N_COURSE):
        d.command_course[k + i] = 0.0

    d.command_course[k] = p

    if what > 0:
        d.command_course[k + 1] = v

    if what == 0:
        d.command_course[k + 1] = slope
        d.command_course[k + 2] = c2
        d.command_course[k + 3] = c3
        d.command_course[k + 4] = c4
        d.command_course[k + 5] = c5
    elif what == 1:
        d.command_course[k + 2] = slope / 2.0
        d.command_course[k + 3] = c2 / 3.0
        d.command_course[k + 4] = c3 / 4.0
        d.command_course[k + 5] = c4 / 5.0
        d.command_course[k + 6] = c5 / 6.0
    else:
        d.command_course[k + 2] = x / 2.0
        d.command_course[k + 3] = slope / 6.0
        d.command_course[k + 4] = c2 / 12.0
        d.command_course[k + 5] = c3 / 20.0
        d.command_course[k + 6] = c4 / 30.0
        d.command_course[k + 7] = c5 / 42.0

    for i in range(4):
        d.command_settling[4 * c + i] = 0.0

    # nothing new was told since the last step: what is not told is what it led to
    if (
        H == 0.0
        and what < 2
        and not told_on
        and d.command_known[0] > 0.0
        and x == d.command_carried[3 * c + what]
    ):
        d.command_course[k + 1] = d.command_carried[3 * c + 1]
        d.command_course[k + 2] = 0.5 * d.command_carried[3 * c + 2]


@inlined
def unwrap(m, d, c, p):
    """What is remembered of an angle moved by whole turns to where the command p is, which may have jumped by them.

    A command is taken for such a jump against where the last ones led, not against the last one: a fast motion turns far.
    """
    if d.command_known[0] == 0.0 or d.command_blind[c] == 1.0:
        return

    shift = 2.0 * math.pi * np.floor((p - d.command_reached[2 * c]) / (2.0 * math.pi) + 0.5)

    # what ends elsewhere in the turn is a motion
    if shift == 0.0 or not abs(p - d.command_reached[2 * c] - shift) < SAME_ANGLE:
        return

    d.command_reached[2 * c] += shift
    d.command_before[2 * c] += shift

    if highest(m, c) == 0:
        d.command_aim[2 * c] += shift

        for i in range(4):
            d.command_past[4 * c + i] += shift


@inlined
def orientation_told(m, d, k):
    """Euler parameters (unit length) that inputs command the ground of drive k; none: those of the inertial frame."""
    kind = m.drive_turn[2 * k]
    u = m.drive_turn[2 * k + 1]

    if kind == courses.TURN_ZYX or kind == courses.TURN_ZYX_OMEGA:
        return al.zyx_E(al.vec_at(d.u_buffer, u))

    E = (0.0, 0.0, 0.0, 1.0)

    if kind != courses.TURN_NONE:
        E = al.E_at(d.u_buffer, u)

    length = math.sqrt(al.E_dot(E, E))
    return al.E_scale(1.0 / length, E) if length > 0.0 else (0.0, 0.0, 0.0, 1.0)


@inlined
def plan_turn(m, d, k, c, H):
    """The course of the ground's orientation, of drive k, whose channels begin at c."""
    kind = m.drive_turn[2 * k]
    u = m.drive_turn[2 * k + 1]

    if kind == courses.TURN_ZYX:
        for i in range(3):
            unwrap(m, d, c + i, d.u_buffer[u + i])
            plan_channel(m, d, c + i, d.u_buffer[u + i], 0.0, d.u_buffer[u + i], H)

    elif kind == courses.TURN_E:
        E = al.E_at(d.u_buffer, u)
        last = (
            d.command_past[4 * c],
            d.command_past[4 * c + 4],
            d.command_past[4 * c + 8],
            d.command_past[4 * c + 12],
        )

        # E and -E are one orientation
        if d.command_known[0] > 0.0 and al.E_dot(E, last) < 0.0:
            for i in range(4 * c, 4 * c + 16):
                d.command_past[i] = -d.command_past[i]

            for i in range(2 * c, 2 * c + 8):
                d.command_reached[i] = -d.command_reached[i]
                d.command_aim[i] = -d.command_aim[i]

        for i in range(4):
            plan_channel(m, d, c + i, d.u_buffer[u + i], 0.0, d.u_buffer[u + i], H)

    elif courses.has_omega(m, k):
        al.set_E_at(d.attitude_base, 0, orientation_told(m, d, k))

        for i in range(3):
            x = told(m, d, c + i, highest(m, c + i))
            plan_channel(m, d, c + i, 0.0, told(m, d, c + i, 1), x, H)

        # from w(s) = w0 + w1 s + w2 s^2 + ... to phi': less (w0 x w1) s^2 / 4 + (w0 x w2) s^3 / 3 + O(s^4)
        w0 = courses.coefficient(d, c, 1)
        w1 = al.scale(2.0, courses.coefficient(d, c, 2))
        w2 = al.scale(3.0, courses.coefficient(d, c, 3))
        third = al.scale(1.0 / 12.0, al.cross(w0, w1))
        fourth = al.scale(1.0 / 12.0, al.cross(w0, w2))

        for i in range(3):
            d.command_course[courses.N_COURSE * (c + i) + 3] -= third[i]
            d.command_course[courses.N_COURSE * (c + i) + 4] -= fourth[i]


@kernel
def plan(m, d, H):
    """The courses of all channels from the commands of now on over a step of H (s), 0: at a point alone."""
    for k in range(m.n_drive):
        c = m.drive_command[k]

        if c < 0:
            continue

        for i in range(min(3, m.drive_commands[k])):
            p = told(m, d, c + i, 0)

            if m.command_angular[c + i] == 1:
                unwrap(m, d, c + i, p)

            plan_channel(m, d, c + i, p, told(m, d, c + i, 1), told(m, d, c + i, highest(m, c + i)), H)

        if m.drive_commands[k] > 3:
            plan_turn(m, d, k, c + 3, H)


@inlined
def settle(m, d, c, position, speed, T):
    """A cubic that leads deviations of position and speed back to zero in T (s), added to a channel's course."""
    d.command_settling[4 * c] = position
    d.command_settling[4 * c + 1] = speed
    d.command_settling[4 * c + 2] = -(3.0 * position / T + 2.0 * speed) / T
    d.command_settling[4 * c + 3] = (2.0 * position / T + speed) / (T * T)


@kernel
def begin(m, d, H):
    """At the start of a communication step of H (s): the courses over it, and what is to be led back.

    Returns whether what is driven may jump to them.
    """
    plan(m, d, H)
    known = d.command_known[0]
    d.command_fresh[0] = 1.0 if known == 0.0 or is_at_rest(m, d) or anything_new(m, d) else 0.0

    if known == 0.0:
        return m.n_command > 0

    jumps = False

    # a short step after a long one does not lead back in a hurry
    T = max(H, d.command_steps[0])

    for k in range(m.n_drive):
        c = m.drive_command[k]

        if c < 0:
            continue

        doubt(m, d, k)
        turns = m.drive_commands[k] > 3 and courses.has_omega(m, k)
        plain = 3 if turns else m.drive_commands[k]

        for i in range(c, c + plain):
            jumps = jumps or d.command_blind[i] > 0.0

            if d.command_blind[i] > 1.0:
                see_start(m, d, i)

            if d.command_blind[i] != 1.0:
                position = d.command_reached[2 * i] - d.command_course[courses.N_COURSE * i]
                settle(
                    m,
                    d,
                    i,
                    position,
                    d.command_reached[2 * i + 1] - d.command_course[courses.N_COURSE * i + 1],
                    T,
                )

        if turns:
            base = al.E_at(d.attitude_base, 0)
            phi = rotations.rotation_vector(
                al.E_product(al.E_at(d.attitude_reached, 0), al.E_conjugate(base))
            )
            rate = rotations.rate_of_rotation(phi, al.vec_at(d.attitude_reached, 4))

            for i in range(3):
                settle(
                    m, d, c + 3 + i, phi[i], rate[i] - d.command_course[courses.N_COURSE * (c + 3 + i) + 1], T
                )

    return jumps and not is_at_rest(m, d)


@inlined
def see_start(m, d, c):
    """With the third and fourth position told, the speed at the start, which the second told roughly, is known better.

    What bodies feel is what it changed since.
    """
    found, _ = extrapolation.differences(m, d, c, told(m, d, c, 0))
    order = extrapolation.best_order(d, c, extrapolation.errors_told(d, found))

    if d.command_blind[c] == 2.0 and order > 0:
        d.command_reached[2 * c + 1] -= found[1] * d.command_steps[1]

    if d.command_blind[c] == 3.0 and order > 1:
        d.command_reached[2 * c + 1] += (
            found[2] * d.command_steps[2] * (d.command_steps[1] + d.command_steps[2])
        )


@inlined
def is_at_rest(m, d):
    """Whether no commanded motion moves in this step."""
    rest = True

    for c in range(m.n_command):
        for i in range(1, courses.N_COURSE):
            rest = rest and d.command_course[courses.N_COURSE * c + i] == 0.0

        for i in range(4):
            rest = rest and d.command_settling[4 * c + i] == 0.0

    return rest


@inlined
def anything_new(m, d):
    """Whether something was commanded since the last step, rather than left to go on as it did."""
    new = False

    for c in range(m.n_command):
        what = highest(m, c)
        u = m.command_u[3 * c + what]
        new = new or told(m, d, c, what) != d.command_carried[3 * c + what]

        for row in range(1, N_DERIVATIVE if u >= 0 else 0):
            new = new or d.u_buffer[row * m.n_u + u] != 0.0

    return new


@inlined
def remember(m, d, c, x, H):
    """The present value x of the highest that a channel is told, for the steps to come after this one of H (s)."""
    k = 4 * c
    u = m.command_u[3 * c + highest(m, c)]
    d.command_before[2 * c] = told(m, d, c, 0)
    d.command_before[2 * c + 1] = told(m, d, c, 1)

    if d.command_known[0] > 0.0:
        found, _ = extrapolation.differences(m, d, c, x)
        missed = extrapolation.errors_told(d, found)

        for i in range(4):
            d.command_error[k + i] = missed[i] if d.command_known[0] > i else 0.0

    for i in range(3, 0, -1):
        d.command_past[k + i] = d.command_past[k + i - 1]

    d.command_past[k] = x
    slope = d.u_buffer[m.n_u + u] if u >= 0 else 0.0

    if d.command_known[0] == 0.0:
        d.command_blind[c] = 1.0 if highest(m, c) == 0 and slope == 0.0 else 0.0
    elif d.command_blind[c] > 0.0:
        d.command_blind[c] = d.command_blind[c] + 1.0 if d.command_blind[c] < 3.0 else 0.0

    d.command_aim[2 * c] = x + slope * H
    d.command_aim[2 * c + 1] = slope * H


@kernel
def end(m, d, H):
    """At the end of a communication step, after H (s): what was commanded is remembered, commands go to where they led."""
    if not H > 0.0:
        return

    fresh = d.command_fresh[0] != 0.0
    settled = d.command_known[0] == 0.0 or H >= d.command_steps[0]

    for k in range(m.n_drive):
        c = m.drive_command[k]

        if c < 0:
            continue

        for i in range(c, c + m.drive_commands[k]):
            if fresh:
                remember(m, d, i, told(m, d, i, highest(m, i)), H)

            reached = courses.course(d, i, H) if settled else courses.motion(d, i, H)
            d.command_reached[2 * i] = reached[0]
            d.command_reached[2 * i + 1] = reached[1]

        if m.drive_commands[k] > 3 and courses.has_omega(m, k):
            E, w, _ = courses.orientation(m, d, k, H, not settled)

            if fresh:
                al.set_E_at(d.attitude_past, 0, al.E_at(d.attitude_base, 0))

            al.set_E_at(d.attitude_reached, 0, E)
            al.set_vec_at(d.attitude_reached, 4, w)

    if not fresh:
        d.command_steps[0] += H
    elif m.n_command > 0:
        for i in range(3, 0, -1):
            d.command_steps[i] = d.command_steps[i - 1]

        d.command_steps[0] = H
        d.command_known[0] = min(4.0, d.command_known[0] + 1.0)

    carry(m, d, H)


@inlined
def carry(m, d, H):
    """Inputs to where the courses of commands, and their own derivatives, led after H (s); derivatives last one step."""
    n = m.n_u

    for k in range(n):
        d.u_course[k] = d.u_buffer[k]
        for row in range(1, N_DERIVATIVE):
            d.u_course[row * n + k] = 0.0

    for k in range(n if d.u_varies[0] != 0.0 else 0):
        d.u_course[k] = polynomial(m, d, k, H)

        for row in range(1, N_DERIVATIVE):
            d.u_course[row * n + k] = derivative(m, d, k, row, H)

        d.u_buffer[k] = d.u_course[k]

        for row in range(1, N_DERIVATIVE):
            d.u_buffer[row * n + k] = 0.0

    for k in range(m.n_drive):
        c = m.drive_command[k]

        if c < 0:
            continue

        for i in range(c, c + m.drive_commands[k]):
            values = courses.course(d, i, H)

            for what in range(3):
                u = m.command_u[3 * i + what]
                d.command_carried[3 * i + what] = values[what]

                if u >= 0:
                    d.u_buffer[u] = values[what]

        if m.drive_commands[k] > 3 and courses.has_omega(m, k):
            carry_turn(m, d, k, H)


@inlined
def carry_turn(m, d, k, H):
    """The same of an orientation that is commanded with its angular velocity."""
    c = m.drive_command[k] + 3
    u = m.drive_turn[2 * k + 1]
    E, w, alpha = courses.orientation(m, d, k, H, False)

    if m.drive_turn[2 * k] == courses.TURN_ZYX_OMEGA:
        al.set_vec_at(d.u_buffer, u, al.matrix_zyx(al.E_matrix(E)))
    else:
        al.set_E_at(d.u_buffer, u, E)

    for i in range(3):
        d.u_buffer[m.command_u[3 * (c + i) + 1]] = w[i]
        d.command_carried[3 * (c + i) + 1] = w[i]
        d.command_carried[3 * (c + i) + 2] = alpha[i]

        if m.command_u[3 * (c + i) + 2] >= 0:
            d.u_buffer[m.command_u[3 * (c + i) + 2]] = alpha[i]
