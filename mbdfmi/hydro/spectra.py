"""The sea as components: frequencies, amplitudes, phases, directions (docs/theory.md 16.17)."""

from functools import lru_cache
from typing import NamedTuple

import numpy as np

# of a spectrum: frequencies by that of its peak, and on how fine a grid it is integrated
BAND = (0.3, 8.0)
FINE = 200_001


class Components(NamedTuple):
    """Elevation at the origin is the sum of amplitude cos(omega t + phase).

    omega : rad/s. amplitude : m. phase : rad. heading : rad, the way they travel. Each (n,).
    """

    omega: np.ndarray
    amplitude: np.ndarray
    phase: np.ndarray
    heading: np.ndarray


def regular(height, period, phase, heading) -> Components:
    """One component of a height from trough to crest (m)."""
    return Components(*(np.array([x]) for x in (2 * np.pi / period, height / 2, phase, heading)))


def shape(omega, peak, gamma):
    """A JONSWAP spectrum of any height, gamma = 1: Pierson and Moskowitz."""
    width = np.where(omega <= peak, 0.07, 0.09)
    rise = np.exp(-(((omega / peak - 1) / width) ** 2) / 2)
    return omega**-5.0 * np.exp(-1.25 * (peak / omega) ** 4) * gamma**rise


@lru_cache(maxsize=16)
def drawn(hs, tp, gamma, count, spacing, seed, heading, spread=None, directions=1) -> Components:
    """A sea of significant height hs (m), peak period tp (s) by `count` components: m0 is hs^2 / 16.

    spacing : "energy", of equal energy, each at the centroid of its band; "frequency", bands of equal width.
    spread : s of cos^(2 s)((theta - heading) / 2) over `directions` of equal energy, dealt to the components
        in an order that is drawn once and for all, so that no two directions share a frequency.
    seed : of numpy's `default_rng`, which draws the phases.

    Kept, and so not to be written to: a run with its page asks a dozen times for the same sea.
    """
    peak = 2 * np.pi / tp
    grid = peak * np.linspace(*BAND, FINE)
    return _of_density(grid, shape(grid, peak, gamma), hs, count, spacing, seed, heading, spread, directions)


def of_spectrum(
    omega, energy, hs, slower, count, spacing, seed, heading, spread=None, directions=1
) -> Components:
    """The same of a table of any spectrum (rad/s, m2 s/rad), straight between its points.

    hs : m, the height that it gets. slower : how many times as long its periods become.
    """
    grid = np.linspace(omega[0], omega[-1], FINE)
    density = np.interp(grid, omega, energy)
    return _of_density(grid / slower, density, hs, count, spacing, seed, heading, spread, directions)


def _of_density(grid, density, hs, count, spacing, seed, heading, spread, directions):
    """Components of a spectrum over a fine grid of frequencies, of any height."""
    whole = _running(density, grid)
    first = _running(density * grid, grid)
    total = whole[-1]

    if spacing == "energy":
        edges = np.interp(np.linspace(0.0, total, count + 1), whole, grid)
    else:
        edges = np.linspace(grid[0], grid[-1], count + 1)

    energy = np.diff(np.interp(edges, grid, whole))
    omega = np.diff(np.interp(edges, grid, first)) / energy
    energy *= (hs / 4) ** 2 / energy.sum()
    dice = np.random.default_rng(seed)
    phase = dice.uniform(0.0, 2 * np.pi, count)
    found = Components(omega, np.sqrt(2 * energy), phase, heading + _offsets(count, spread, directions))

    for array in found:
        array.flags.writeable = False

    return found


def _running(density, grid):
    """Integral from the first grid point to each."""
    return np.concatenate([[0.0], np.cumsum((density[1:] + density[:-1]) / 2 * np.diff(grid))])


def _offsets(count, spread, directions):
    """(n,) rad, of components from the mean direction, whatever the seed."""
    if spread is None or directions == 1:
        return np.zeros(count)

    grid = np.linspace(-np.pi, np.pi, 20_001)
    whole = _running(np.cos(grid / 2) ** (2 * spread), grid)
    middles = np.interp((np.arange(directions) + 0.5) / directions * whole[-1], whole, grid)
    return np.random.default_rng(0).permutation(np.resize(middles, count))


def of_series(time, elevation, heading) -> Components:
    """What makes the same elevation at the origin, over and over, by FFT, without its mean. time : s."""
    n = len(time)
    step = (time[-1] - time[0]) / (n - 1)
    values = np.fft.rfft(elevation)[1:] / n
    values[: (n - 1) // 2] *= 2
    omega = 2 * np.pi * np.arange(1, len(values) + 1) / (n * step)
    amplitude, phase = np.abs(values), np.angle(values) - omega * time[0]
    kept = amplitude > 1e-9 * amplitude.max(initial=0.0)
    return Components(omega[kept], amplitude[kept], phase[kept], np.full(kept.sum(), heading))


def wave_number(omega, depth, gravity):
    """k (rad/m) of omega^2 = g k tanh(k depth), by Newton to rounding; depth None: deep."""
    deep = np.asarray(omega, float) ** 2 / gravity

    if depth is None:
        return deep

    k = np.maximum(deep, np.asarray(omega) / np.sqrt(gravity * depth))

    for _ in range(50):
        t = np.tanh(k * depth)
        change = (k * t - deep) / (t + k * depth * (1 - t * t))
        k = k - change

        if np.all(np.abs(change) <= 1e-15 * k):
            break

    return k
