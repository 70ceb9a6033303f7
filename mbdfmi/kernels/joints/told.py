"""Starts of joints with an orientation, as told, of the second marker in the first (docs/theory.md 3.6)."""

import math

from ..language import inlined, kernel
from ..math import algebra as al
from .kinds import FREE, E_offset, slides


@inlined
def told_start(m, i):
    """A spherical or free joint's start values as told of its second marker in its first.

    (r, E of unit length, r', w); w in the second marker's axes where body_spins is 1, else in the first's like the rest.
    """
    kind = m.body_joint[i]
    q = m.body_q[i]
    v = m.body_v[i]
    k = E_offset(kind)
    E = al.E_at(m.q_start, q + k)
    E = al.E_scale(1.0 / math.sqrt(al.E_dot(E, E)), E)
    turned = al.vec3(m.zyx_start, i)
    told = al.vec3(m.zyx_told, i)

    if turned[0] != told[0] or turned[1] != told[1] or turned[2] != told[2]:
        E = al.zyx_E(turned)

    w = al.vec_at(m.v_start, v + k)

    if m.body_spins[i] == 1:
        w = al.matT_vec(al.E_matrix(E), w)

    if kind == FREE:
        return al.vec_at(m.q_start, q), E, al.vec_at(m.v_start, v), w

    return al.ZERO3, E, al.ZERO3, w


@inlined
def told_motion(m, d, i):
    """The same of the motion in d.q and d.v."""
    kind = m.body_joint[i]
    q = m.body_q[i]
    v = m.body_v[i]
    k = E_offset(kind)
    E = al.E_at(d.q, q + k)
    A = al.E_matrix(E)
    w_own = al.vec_at(d.v, v + k)
    r = al.ZERO3
    rd = al.ZERO3

    if kind == FREE:
        r = al.vec_at(d.q, q)
        rd = al.vec_at(d.v, v)

    if m.body_reversed[i] == 0:
        return r, E, rd, w_own if m.body_spins[i] == 1 else al.mat_vec(A, w_own)

    r = al.neg(al.matT_vec(A, r))
    w = al.neg(w_own)
    rd = al.sub(al.cross(w, r), al.matT_vec(A, rd))
    return r, al.E_conjugate(E), rd, al.mat_vec(A, w) if m.body_spins[i] == 1 else w


@inlined
def take_motion(m, d, i, r, E, rd, w):
    """A spherical or free joint's motion as told (see told_start) into d.q and d.v.

    Where the first marker is on the body, not on the parent, the tree needs the inverse motion:
    r -> -A^T r, r' -> A^T (w x r - r'), w -> -A^T w.
    """
    kind = m.body_joint[i]
    q = m.body_q[i]
    v = m.body_v[i]
    k = E_offset(kind)
    A = al.E_matrix(E)
    spins = m.body_spins[i] == 1

    if m.body_reversed[i] == 0:
        w_own = w if spins else al.matT_vec(A, w)
    else:
        first = al.mat_vec(A, w) if spins else w
        w_own = al.neg(first)
        rd = al.matT_vec(A, al.sub(al.cross(first, r), rd))
        r = al.neg(al.matT_vec(A, r))
        E = al.E_conjugate(E)

    if kind == FREE:
        al.set_vec_at(d.q, q, r)
        al.set_vec_at(d.v, v, rd)

    al.set_E_at(d.q, q + k, E)
    al.set_vec_at(d.v, v + k, w_own)


@inlined
def start(m, d, i):
    """Start values of body i's joint into d.q and d.v, from q_start and v_start. False: E has no length."""
    E = al.E_at(m.q_start, m.body_q[i] + E_offset(m.body_joint[i]))

    if not al.E_dot(E, E) > 0.0:
        return False

    r, E, rd, w = told_start(m, i)
    take_motion(m, d, i, r, E, rd, w)
    return True


@inlined
def turn_between(E, F):
    """Angle (rad) of the rotation from E to F, both of unit length."""
    turn = al.E_product(al.E_conjugate(E), F)
    return 2.0 * math.asin(min(1.0, al.norm((turn[0], turn[1], turn[2]))))


@inlined
def off_start(m, d, i, k, positions):
    """How far coordinate k of a spherical or free joint, as told, is from its start value: m, rad, or m/s, rad/s."""
    r, E, rd, w = told_start(m, i)
    r_now, E_now, rd_now, w_now = told_motion(m, d, i)
    moves = slides(m.body_joint[i], k)

    if positions:
        return r_now[k] - r[k] if moves else turn_between(E, E_now)

    return rd_now[k] - rd[k] if moves else w_now[k % 3] - w[k % 3]


@inlined
def with_component(u, k, value):
    """The vector u with component k replaced."""
    return (value if k == 0 else u[0], value if k == 1 else u[1], value if k == 2 else u[2])


@kernel
def put_back(m, d, i, k, positions):
    """Coordinate k of a spherical or free joint, as told, to its start value; an orientation as a whole. Returns how far it was off."""
    off = abs(off_start(m, d, i, k, positions))
    r, E, rd, w = told_start(m, i)
    r_now, E_now, rd_now, w_now = told_motion(m, d, i)
    moves = slides(m.body_joint[i], k)

    if positions and moves:
        r_now = with_component(r_now, k, r[k])
    elif positions:
        E_now = E
    elif moves:
        rd_now = with_component(rd_now, k, rd[k])
    else:
        w_now = with_component(w_now, k % 3, w[k % 3])

    take_motion(m, d, i, r_now, E_now, rd_now, w_now)
    return off
