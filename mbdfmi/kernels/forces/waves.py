"""What the waves of the sea do to bodies: sums of components over time (docs/theory.md 16.17).

F(t) = sum over k of Re(F_k e^(i omega_k t)) of six numbers, force and moment at a marker in inertial axes. A sum of hundreds of
components is dear, so its value and two derivatives are kept at knots j D of time, a ring of them, and between two knots there is a
quintic. What a knot holds depends on its time alone: what is kept in scratch changes no result.
"""

import math

from ..language import apart, inlined
from ..motion import markers
from ..signatures import DATA, MODEL, int64, void

RING = 8
PER_KNOT = 18


@apart(void(MODEL, DATA, int64, int64, int64))
def fill_knot(m, d, k, j, slot):
    """Knot j of element k into its ring: values, derivatives, second derivatives of 6 components each, by D."""
    at = PER_KNOT * (RING * k + slot)
    D = m.excitation_step[k]
    t = j * D

    for i in range(PER_KNOT):
        d.excitation_knot[at + i] = 0.0

    begin = m.excitation_part[k]

    for p in range(begin, begin + m.excitation_parts[k]):
        omega = m.part_omega[p]
        c = math.cos(omega * t)
        s = math.sin(omega * t)
        turn = omega * D

        for i in range(6):
            re = m.part_force[12 * p + i]
            im = m.part_force[12 * p + 6 + i]
            value = re * c - im * s
            d.excitation_knot[at + i] += value
            d.excitation_knot[at + 6 + i] -= turn * (re * s + im * c)
            d.excitation_knot[at + 12 + i] -= turn * turn * value

    d.excitation_key[RING * k + slot] = 2.0 * j + 1.0


@inlined
def knot(m, d, k, j):
    """Where knot j of element k stands in the ring."""
    slot = j % RING

    # an odd number, since scratch is zero at first
    if d.excitation_key[RING * k + slot] != 2.0 * j + 1.0:
        fill_knot(m, d, k, j, slot)

    return PER_KNOT * (RING * k + slot)


@inlined
def between(p, a, b, i, s):
    """Component i of the quintic from knot a to knot b at s from 0 to 1."""
    y = p[a + i]
    v = p[a + 6 + i]
    c = 0.5 * p[a + 12 + i]
    y1 = p[b + i] - (y + v + c)
    v1 = p[b + 6 + i] - (v + 2.0 * c)
    c1 = 0.5 * p[b + 12 + i] - c
    c3 = 10.0 * y1 - 4.0 * v1 + c1
    c4 = -15.0 * y1 + 7.0 * v1 - 2.0 * c1
    c5 = 6.0 * y1 - 3.0 * v1 + c1
    return y + s * (v + s * (c + s * (c3 + s * (c4 + s * c5))))


@inlined
def wrench(m, d, k):
    """Of element k on its body at its marker now: (moment N m, force N), inertial axes."""
    D = m.excitation_step[k]
    j = math.floor(d.now[0] / D)
    s = d.now[0] / D - j
    a = knot(m, d, k, j)
    b = knot(m, d, k, j + 1)
    p = d.excitation_knot
    force = (between(p, a, b, 0, s), between(p, a, b, 1, s), between(p, a, b, 2, s))
    return (between(p, a, b, 3, s), between(p, a, b, 4, s), between(p, a, b, 5, s)), force


@inlined
def add(m, d):
    """Their wrenches onto the bodies."""
    for k in range(m.n_excitation):
        moment, force = wrench(m, d, k)
        b = m.excitation_marker[k]
        markers.add_wrench(m, d, m.marker_body[b], markers.position(m, d, b), moment, force)


@inlined
def power_of(m, d, k):
    """W, of element k on its body."""
    moment, force = wrench(m, d, k)
    return markers.power(m, d, m.excitation_marker[k], moment, force)


@inlined
def power(m, d):
    """W, on the bodies."""
    total = 0.0

    for k in range(m.n_excitation):
        total += power_of(m, d, k)

    return total


@inlined
def supplied(m, d):
    """W, all of it from the sea."""
    return power(m, d)


@inlined
def elevation(m, d, x, y):
    """Of the undisturbed sea at (x, y) now (m)."""
    total = 0.0

    for p in range(m.n_sea_wave):
        a = 5 * p
        phase = m.sea_wave[a + 1] * d.now[0] + m.sea_wave[a + 2]
        total += m.sea_wave[a] * math.cos(phase - m.sea_wave[a + 3] * x - m.sea_wave[a + 4] * y)

    return total
