"""What FMUs did not know of their inputs: jumps at communication points, and what polynomials miss between these."""

from __future__ import annotations

import numpy as np

from .history import Seen
from .network import Network

WINDOW = 32
"""Macro steps that are looked at together."""

ROUGH = 0.3
"""Median of a link's jumps in a window, relative to its range there, that is told."""

COARSE = 0.08
"""Median of what a link's polynomials miss within the steps of a window, relative to its usual swing there, that is told: a
sine in fewer than about 40 steps with held inputs, 8 with straight lines, 6 with parabolas.
"""

LEAST = 0.05
"""Usual swing of a link that is counted at the least, relative to its range in the window."""

SHAKES = 1e-3
"""Range of a link, relative to the largest value that it had, from which on it is looked at."""

ROUNDING = 1e-6
"""Range of a link, relative to its largest value, below which it counts as constant."""

WITHIN = {0: 1 / 2, 1: 1 / 8, 2: 1 / 16}
"""What a polynomial of an order through the ends of a step misses in its middle, of the difference of the next order."""


def rough(net: Network, seen: Seen) -> list[str]:
    """What is told of inputs that jump from step to step as far as they go at all, in some window of the run: there their
    FMUs know too little of each other.
    """
    n = (seen.n - 1) // WINDOW
    if n == 0 or not net.n_u:
        return []

    rows = slice(1, 1 + n * WINDOW)
    now, end = (values[rows].reshape(n, WINDOW, -1) for values in (seen.now, seen.end))
    spread, peak = np.ptp(now, axis=1), np.maximum.accumulate(np.abs(now).max(axis=1))
    usual = np.median(np.abs(now - end), axis=1)
    # what a link shakes by less than it matters is no concern
    bad = (usual > ROUGH * spread) & (spread > SHAKES * peak)
    if not bad.any():
        return []

    window, row = (int(k[0]) for k in np.nonzero(bad))
    feed = net.feeds[row]
    share = 100 * usual[window, row] / spread[window, row]
    return [
        f"{feed.text if feed else row} jumps by {share:.2g} % of its range from step to step at {seen.time[1 + window * WINDOW]:.6g} s: "
        "the step is too long for the master, or the coupling is unstable; look at the results with doubt"
    ]


def coarse(net: Network, seen: Seen, order: int) -> list[str]:
    """What is told of steps that are long for what links carry: between communication points FMUs know their inputs as
    polynomials of `order`, also where these agree with all outputs at both ends of every step.
    """
    if not net.n_u or order == 0:
        # held inputs jump by all that they miss, which `rough` and `jumps` tell
        return []

    steps = np.diff(seen.time)
    # the differences are those of equal steps; the last one may be shorter
    n = seen.n - (len(steps) > 0 and steps[-1] < (1 - 1e-6) * steps[0])
    if n < order + 2:
        return [
            f"a run of {len(steps)} step{'s' * (len(steps) != 1)}: too few to tell what inputs miss within them"
        ]

    now = seen.now[:n]
    missed = WITHIN[order] * np.abs(np.diff(now, order + 1, axis=0))
    starts = np.arange(0, max(len(missed) - WINDOW // 2, 1), WINDOW)
    peak = np.abs(now).max(axis=0)
    # medians: a jump by itself, as of what is switched on, is none of the step's business
    share = np.array(
        [
            np.where(np.ptp(values, axis=0) > SHAKES * peak, np.median(part, axis=0), 0.0)
            / (_swing(values) + 1e-300)
            for part, values in zip(np.split(missed, starts[1:]), np.split(now, starts[1:]))
        ]
    )
    if share.max() <= COARSE:
        return []

    window, row = np.unravel_index(int(np.argmax(share)), share.shape)
    feed = net.feeds[row]
    return [
        f"{feed.text if feed else row}: within a step this input misses about {100 * share[window, row]:.2g} % of its swing around "
        f"{seen.time[starts[window]]:.6g} s; the step is too long for what it carries: a smaller one, or [master] error = 1e-3 "
        "where all FMUs can go back, will tell by how much results change"
    ]


def _swing(values):
    """How far inputs (n, n_u) usually are from their middle."""
    middle = np.median(values, axis=0)
    return np.maximum(np.median(np.abs(values - middle), axis=0), LEAST * np.ptp(values, axis=0))


def jumps(net: Network, seen: Seen) -> dict[str, float]:
    """Largest jump of each input at a communication point, relative to the range of its values: what a step did not know."""
    if seen.n < 2:
        return {}
    now = seen.now
    missed = np.max(np.abs(now - seen.end)[1:], axis=0)
    # of a value that does not change rounding is the range
    spread = np.maximum(np.ptp(now, axis=0), ROUNDING * np.abs(now).max(axis=0))
    return {
        feed.text: float(missed[row] / spread[row]) if spread[row] > 0 else 0.0
        for row, feed in enumerate(net.feeds)
        if feed
    }
