"""The waves of the sea as components, from parameters that may have changed (docs/theory.md 16.17).

Elevation = sum a cos(omega t + phase - k . (x, y)). `sea_unit` holds them for a height, a period and a mean direction of 1, 1 and 0;
phases are drawn anew where another seed is asked for. What is made of them stands in scratch, with the parameters that it was
made of: it is a function of these alone.
"""

import math

from ..language import apart, inlined
from ..math import dice
from ..signatures import DATA, MODEL, void

LARGEST_SEED = 4294967295.0


@inlined
def is_one(m):
    """Whether the parameters are those of a sea."""
    seed = m.sea_value[3]
    finite = math.isfinite(m.sea_value[0] + m.sea_value[1] + m.sea_value[2])
    drawn = seed == m.sea_water[2] or (0.0 <= seed <= LARGEST_SEED and seed == math.floor(seed))
    return finite and m.sea_value[0] >= 0.0 and m.sea_value[1] > 0.0 and drawn


@inlined
def wave_number(omega, depth, gravity):
    """k (rad/m) of omega^2 = g k tanh(k depth), by Newton's method to rounding; depth 0: deep."""
    deep = omega * omega / gravity

    if depth == 0.0:
        return deep

    k = max(deep, omega / math.sqrt(gravity * depth))

    for _ in range(50):
        t = math.tanh(k * depth)
        change = (k * t - deep) / (t + k * depth * (1.0 - t * t))
        k -= change

        if abs(change) <= 1e-15 * k:
            break

    return k


@apart(void(MODEL, DATA))
def make(m, d):
    """The components into d.sea_wave; all that was made of others is gone."""
    height = m.sea_value[0]
    period = m.sea_value[1]
    direction = m.sea_value[2]
    seed = m.sea_value[3]
    highest = 0.0

    if seed != m.sea_water[2]:
        dice.begin(d.sea_dice, int(seed))

    for p in range(m.n_sea_wave):
        omega = m.sea_unit[4 * p + 1] / period
        phase = m.sea_unit[4 * p + 2]
        heading = direction + m.sea_unit[4 * p + 3]

        if seed != m.sea_water[2]:
            phase = 2.0 * math.pi * dice.draw(d.sea_dice)

        k = wave_number(omega, m.sea_water[0], m.sea_water[1])
        d.sea_wave[7 * p] = height * m.sea_unit[4 * p]
        d.sea_wave[7 * p + 1] = omega
        d.sea_wave[7 * p + 2] = phase
        d.sea_wave[7 * p + 3] = k * math.cos(heading)
        d.sea_wave[7 * p + 4] = k * math.sin(heading)
        d.sea_wave[7 * p + 5] = k
        d.sea_wave[7 * p + 6] = math.exp(-2.0 * k * m.sea_water[0]) if m.sea_water[0] > 0.0 else 0.0
        highest = max(highest, omega)

    d.sea_known[0] = 1.0

    for j in range(4):
        d.sea_known[1 + j] = m.sea_value[j]

    d.sea_known[5] = highest

    for j in range(8):
        d.sea_known[6 + j] = 0.0

    for k in range(m.n_excitation):
        for j in range(8):
            d.excitation_key[8 * k + j] = 0.0


@inlined
def is_made(m, d):
    """Whether the components are those of the parameters."""
    same = d.sea_known[0] == 1.0

    for j in range(4):
        same = same and d.sea_known[1 + j] == m.sea_value[j]

    return same


@inlined
def elevation(m, d, t, x, y):
    """Of the undisturbed sea at (x, y) at time t (m), its components made."""
    total = 0.0

    for p in range(m.n_sea_wave):
        a = 7 * p
        phase = d.sea_wave[a + 1] * t + d.sea_wave[a + 2]
        total += d.sea_wave[a] * math.cos(phase - d.sea_wave[a + 3] * x - d.sea_wave[a + 4] * y)

    return total
