"""Forces between two markers by 6x6 matrices: linear, bushing; arrays six_by_six_* (docs/theory.md 16.7)."""

import math

from ..language import inlined
from ..math import algebra as al
from ..motion import markers

# axes that damping and added mass are given in: the first marker's, those turned about its z axis by the second one's yaw, or
# the second one's own
FIRST = 0
HEADING = 1
BODY = 2


@inlined
def swing_twist(A):
    """A rotation as a swing after a twist about z (docs/theory.md 2.6): ((rx, ry, rz) rad, G).

    A = exp(skew(rx, ry, 0)) Rz(rz); G maps the rates (rx', ry', rz') to the angular velocity, in the axes
    that A leads to: columns 1 and 2 of the left Jacobian of the exponential, and the swung z axis.
    """
    E = al.matrix_E(A)
    E = al.E_scale(-1.0 if E[3] < 0.0 else 1.0, E)
    n = math.sqrt(E[2] * E[2] + E[3] * E[3])
    twist = (0.0, 0.0, E[2] / n, E[3] / n) if n > 0.0 else (0.0, 0.0, 0.0, 1.0)
    S = al.E_product(E, al.E_conjugate(twist))
    s = math.sqrt(S[0] * S[0] + S[1] * S[1])
    angle = 2.0 * math.atan2(s, n)
    stretch = angle / s if s > 1e-9 else 2.0
    x = stretch * S[0]
    y = stretch * S[1]

    # J = 1 + b phi~ + c phi~^2 for phi = (x, y, 0)
    if angle > 1e-3:
        b = (1.0 - math.cos(angle)) / (angle * angle)
        c = (angle - math.sin(angle)) / (angle * angle * angle)
    else:
        b = 0.5 - angle * angle / 24.0
        c = 1.0 / 6.0 - angle * angle / 120.0

    columns = (
        (1.0 - c * y * y, c * x * y, -b * y),
        (c * x * y, 1.0 - c * x * x, b * x),
        (2.0 * S[1] * S[3], -2.0 * S[0] * S[3], 1.0 - 2.0 * (S[0] * S[0] + S[1] * S[1])),
    )
    return (x, y, 2.0 * math.atan2(twist[2], twist[3])), columns


@inlined
def moment_of_swing_twist(columns, Q):
    """The moment whose power on G (rx', ry', rz') is Q . (rx', ry', rz'): G^T moment = Q. Not finite at a swing by 180 degrees, but of
    no Q there is none there either."""
    g0, g1, g2 = columns
    c0 = al.cross(g1, g2)
    c1 = al.cross(g2, g0)
    c2 = al.cross(g0, g1)
    sum_ = al.axpy(Q[0], c0, al.axpy(Q[1], c1, al.scale(Q[2], c2)))
    det = al.dot(g0, c0)
    nothing = det == 0.0 and abs(Q[0]) + abs(Q[1]) + abs(Q[2]) == 0.0
    return al.scale(0.0 if nothing else 1.0 / det, sum_)


@inlined
def swing_twist_rates(columns, w):
    """(rx', ry', rz') for an angular velocity: G^-1 w (see swing_twist); 0 at a swing by 180 degrees, where nobody knows them."""
    g0, g1, g2 = columns
    c0 = al.cross(g1, g2)
    det = al.dot(g0, c0)
    s = 1.0 / det if det != 0.0 else 0.0
    return s * al.dot(c0, w), s * al.dot(al.cross(g2, g0), w), s * al.dot(al.cross(g0, g1), w)


@inlined
def six_rows(p, k, row, a, b):
    """Element `row` of the 6x6 matrix k of p times (a, b)."""
    j = 36 * k + 6 * row
    return (
        p[j] * a[0] + p[j + 1] * a[1] + p[j + 2] * a[2] + p[j + 3] * b[0] + p[j + 4] * b[1] + p[j + 5] * b[2]
    )


@inlined
def six_times(p, k, a, b):
    """The 6x6 matrix k of p times (a, b), as two vectors."""
    return (
        (six_rows(p, k, 0, a, b), six_rows(p, k, 1, a, b), six_rows(p, k, 2, a, b)),
        (six_rows(p, k, 3, a, b), six_rows(p, k, 4, a, b), six_rows(p, k, 5, a, b)),
    )


@inlined
def displacement(m, d, k):
    """Displacement of linear force k: (d m, (rx, ry, rz) rad, G) in the first marker's axes."""
    a = m.six_by_six_from[k]
    b = m.six_by_six_to[k]
    turned, columns = swing_twist(markers.relative_axes(m, d, a, b))
    return markers.relative_position(m, d, a, b), turned, columns


@inlined
def turned_axes(m, d, k, yaw):
    """Rotation to the first marker's axes of those that linear force k has its damping and added mass in. yaw : rz (rad)."""
    if m.six_by_six_axes[k] == BODY:
        return markers.relative_axes(m, d, m.six_by_six_from[k], m.six_by_six_to[k])

    c = math.cos(yaw)
    s = math.sin(yaw)
    return ((c, -s, 0.0), (s, c, 0.0), (0.0, 0.0, 1.0))


@inlined
def drag(m, d, k, yaw):
    """What the damping of linear force k takes off its wrench: (force N, moment N m), in the first marker's axes. yaw : rz (rad)."""
    a = m.six_by_six_from[k]
    b = m.six_by_six_to[k]
    v = markers.relative_velocity(m, d, a, b)
    w = markers.relative_angular_velocity(m, d, a, b)

    if m.six_by_six_axes[k] == FIRST:
        return six_times(m.six_by_six_damping, k, v, w)

    A = turned_axes(m, d, k, yaw)
    force, moment = six_times(m.six_by_six_damping, k, al.matT_vec(A, v), al.matT_vec(A, w))
    return al.mat_vec(A, force), al.mat_vec(A, moment)


@inlined
def wrench(m, d, k):
    """Wrench of linear force k on the second marker: (moment N m, force N), in the first one's axes.

    Stiffness and preload are generalised forces along (d, rx, ry, rz), so a symmetric stiffness keeps
    energy at any angle; damping acts on the relative velocities. Added mass is no part (docs/theory.md 16.7).
    """
    moved, turned, columns = displacement(m, d, k)
    force, Q = six_times(m.six_by_six_stiffness, k, moved, turned)
    force = al.sub(al.vec3(m.six_by_six_preload, 2 * k), force)
    Q = al.sub(al.vec3(m.six_by_six_preload, 2 * k + 1), Q)
    resisting, resisting_moment = drag(m, d, k, turned[2])
    return al.sub(moment_of_swing_twist(columns, Q), resisting_moment), al.sub(force, resisting)


@inlined
def add(m, d):
    """Their wrenches onto the bodies."""
    for k in range(m.n_six_by_six):
        b = m.six_by_six_to[k]
        r = markers.position(m, d, b)
        A = markers.axes(m, d, m.six_by_six_from[k])
        moment, force = wrench(m, d, k)
        moment = al.mat_vec(A, moment)
        force = al.mat_vec(A, force)
        markers.add_wrench(m, d, m.marker_body[b], r, moment, force)

        # the reaction acts at the material point that is there now
        markers.add_wrench(m, d, m.marker_body[m.six_by_six_from[k]], r, al.neg(moment), al.neg(force))


@inlined
def energy(m, d):
    """J, stored; a preload's is zero at zero displacement."""
    total = 0.0

    for k in range(m.n_six_by_six):
        moved, turned, columns = displacement(m, d, k)
        force, Q = six_times(m.six_by_six_stiffness, k, moved, turned)
        total += 0.5 * (al.dot(moved, force) + al.dot(turned, Q))
        total -= al.dot(al.vec3(m.six_by_six_preload, 2 * k), moved)
        total -= al.dot(al.vec3(m.six_by_six_preload, 2 * k + 1), turned)

    return total


@inlined
def power_of(m, d, k):
    """W, of force k on the bodies, without its added mass, whose energy is part of the bodies'."""
    moment, force = wrench(m, d, k)
    return markers.power_between(m, d, m.six_by_six_from[k], m.six_by_six_to[k], moment, force)


@inlined
def power(m, d):
    """W, on the bodies."""
    total = 0.0

    for k in range(m.n_six_by_six):
        total += power_of(m, d, k)

    return total


@inlined
def dissipated_by(m, d, k):
    """What linear force k takes by its damping, and by what is not symmetric in its stiffness K: x'.(K - K^T) x / 2."""
    a = m.six_by_six_from[k]
    b = m.six_by_six_to[k]
    v = markers.relative_velocity(m, d, a, b)
    w = markers.relative_angular_velocity(m, d, a, b)
    moved, turned, columns = displacement(m, d, k)
    resisting, resisting_moment = drag(m, d, k, turned[2])
    turning = swing_twist_rates(columns, w)
    force, Q = six_times(m.six_by_six_stiffness, k, moved, turned)
    force_rate, Q_rate = six_times(m.six_by_six_stiffness, k, v, turning)
    lost = al.dot(v, force) + al.dot(turning, Q) - al.dot(moved, force_rate) - al.dot(turned, Q_rate)
    return al.dot(resisting, v) + al.dot(resisting_moment, w) + 0.5 * lost


@inlined
def dissipated(m, d):
    """W, lost in damping."""
    total = 0.0

    for k in range(m.n_six_by_six):
        total += dissipated_by(m, d, k)

    return total
