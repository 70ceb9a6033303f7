"""Motion on a Kepler ellipse (docs/theory.md 15.3): how it follows from the mean anomaly."""

import math

import numpy as np

from ..language import inlined, kernel

MOST = 100
"""Iterations of Newton's method at most."""

LAST = 1e-9
"""A change of the eccentric anomaly, as a part of it, after which the next one would be its square: nothing."""


@kernel
def eccentric_anomaly(M, e):
    """E (rad) of Kepler's equation E - e sin E = M, on the same turn as M (rad).

    In half a turn the left side is convex: from above its root Newton's method descends to it.
    """
    turns = 2.0 * math.pi * np.floor(M / (2.0 * math.pi) + 0.5)
    half = abs(M - turns)
    E = min(math.pi, min(half + e, half / (1.0 - e)))

    for _ in range(MOST):
        change = (E - e * math.sin(E) - half) / (1.0 - e * math.cos(E))
        E -= change

        if change <= LAST * E:
            break

    return turns + (E if M >= turns else -E)


@inlined
def place(E, e):
    """Where eccentric anomaly E (rad) is in the plane, for a semi-major axis of 1: (along the periapsis, along the track there)."""
    return math.cos(E) - e, math.sqrt(1.0 - e * e) * math.sin(E)


@inlined
def velocity(E, e):
    """Its derivative by the mean anomaly."""
    stretch = 1.0 - e * math.cos(E)
    return -math.sin(E) / stretch, math.sqrt(1.0 - e * e) * math.cos(E) / stretch


@inlined
def true_anomaly(E, e):
    """(nu, dnu/dM, d2nu/dM2) : rad, on the same turn as E."""
    root = math.sqrt(1.0 - e * e)
    s = math.sin(E)
    c = math.cos(E)
    stretch = 1.0 - e * c
    nu = E + 2.0 * math.atan2(e * s, 1.0 + root - e * c)
    rate = root / (stretch * stretch)
    return nu, rate, -2.0 * rate * e * s / (stretch * stretch)
