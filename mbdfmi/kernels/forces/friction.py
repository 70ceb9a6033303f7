"""Dry friction along joint coordinates, smooth where it changes its sign (docs/theory.md 16.5)."""

import math

from ..language import inlined
from ..motion import coordinates


@inlined
def resistance(m, k, rate):
    """Dry friction k against a rate: (coulomb + (static - coulomb) exp(-(rate / stribeck)^2)) sign + viscous rate.

    The sign is smooth, tanh(rate / smoothing): at rest the joint creeps under load at up to a few times that speed.
    """
    fade = rate / m.friction_stribeck[k]
    dry = m.friction_coulomb[k] + (m.friction_static[k] - m.friction_coulomb[k]) * math.exp(-fade * fade)
    return dry * math.tanh(rate / m.friction_smoothing[k]) + m.friction_viscous[k] * rate


@inlined
def add(m, d):
    """Their efforts onto the coordinates."""
    for k in range(m.n_friction):
        c = m.friction_coordinate[k]
        coordinates.add_effort(m, d, c, -resistance(m, k, coordinates.rate(m, d, c)))


@inlined
def effort_along(m, d, c):
    """Effort (N m or N) of all of them along coordinate c."""
    effort = 0.0

    for k in range(m.n_friction):
        if m.friction_coordinate[k] == c:
            effort -= resistance(m, k, coordinates.rate(m, d, c))

    return effort


@inlined
def dissipated(m, d):
    """W, lost: all the power that it takes from the bodies."""
    total = 0.0

    for k in range(m.n_friction):
        rate = coordinates.rate(m, d, m.friction_coordinate[k])
        total += resistance(m, k, rate) * rate

    return total


@inlined
def power(m, d):
    """W, on the bodies."""
    return -dissipated(m, d)
