"""The picture of a sea: its spectrum and that which it was drawn from, directions, elevation over time."""

from pathlib import Path

import numpy as np

from ..files import save_figure
from .spectra import Components, shape

# rad/s and m: components nearer, and their heights, are one
TOGETHER = 1e-9

# of the strongest period: how long the elevation is drawn
SHOWN = 25
POINTS = 1500


def density(waves: Components):
    """(edges (n + 1,) rad/s, density (n,) m2 s/rad) of the energy of components, each over the band half way
    to its neighbours.
    """
    omega, at = np.unique(np.round(waves.omega / TOGETHER) * TOGETHER, return_inverse=True)
    energy = np.bincount(at, waves.amplitude**2 / 2)
    middles = (omega[1:] + omega[:-1]) / 2
    edges = np.concatenate([[2 * omega[0] - middles[0]], middles, [2 * omega[-1] - middles[-1]]])
    return edges, energy / np.diff(edges)


def draw_sea(path, waves: Components, spectrum=None, title="") -> Path:
    """Spectrum, directions where there are several, elevation at the origin. path : png, svg or pdf.

    spectrum : (hs m, tp s, gamma) that it was drawn from, None of others.
    """
    from matplotlib.figure import Figure

    figure = Figure(figsize=(11, 6.5), layout="constrained")
    figure.suptitle(title, fontsize="medium")
    above, below = np.ravel(np.asarray(figure.subfigures(2, 1)))

    if np.ptp(waves.heading) > TOGETHER:
        axes = above.add_subplot(1, 3, (1, 2))
        _draw_directions(above.add_subplot(1, 3, 3, projection="polar"), waves)
    else:
        axes = above.add_subplot(1, 1, 1)

    _draw_spectrum(axes, waves, spectrum)
    _draw_elevation(below.subplots(1, 1), waves)
    save_figure(figure, path)
    return Path(path)


def _draw_spectrum(axes, waves, spectrum):
    axes.set_xlabel("rad/s")
    axes.grid(alpha=0.3)

    if len(np.unique(waves.omega)) < 3:
        axes.stem(waves.omega, waves.amplitude, basefmt=" ")
        axes.set_ylabel("amplitude, m")
        axes.set_xlim(0, 2 * waves.omega.max())
        axes.set_title("amplitudes", loc="left", fontsize="medium")
        return

    edges, values = density(waves)
    axes.stairs(values, edges, fill=True, alpha=0.4, label=f"{len(waves.omega)} components")
    axes.set_ylabel("energy, m² s/rad")
    axes.set_title("spectrum", loc="left", fontsize="medium")

    if spectrum:
        hs, tp, gamma = spectrum
        fine = np.linspace(edges[0], edges[-1], POINTS)
        curve = shape(fine, 2 * np.pi / tp, gamma)
        curve *= (hs / 4) ** 2 / (curve.sum() * (fine[1] - fine[0]))
        axes.plot(
            fine,
            curve,
            "k",
            linewidth=1,
            label=f"JONSWAP, gamma {gamma:g}" if gamma != 1 else "Pierson-Moskowitz",
        )
        axes.axvline(2 * np.pi / tp, color="k", linewidth=0.6, linestyle=":")

    axes.legend(fontsize="small")


def _draw_directions(axes, waves):
    """Energy by direction."""
    energy = waves.amplitude**2 / 2
    headings, at = np.unique(np.round(waves.heading / TOGETHER) * TOGETHER, return_inverse=True)
    width = np.diff(np.concatenate([headings, headings[:1] + 2 * np.pi])).clip(max=np.radians(15))
    axes.bar(headings, np.bincount(at, energy), width=width, alpha=0.6)
    axes.set_yticklabels([])
    axes.set_title("where they travel, energy", fontsize="medium")


def _draw_elevation(axes, waves):
    period = 2 * np.pi / waves.omega[np.argmax(waves.amplitude)]
    time = np.linspace(0.0, SHOWN * period, POINTS)
    axes.plot(time, waves.amplitude @ np.cos(np.outer(waves.omega, time) + waves.phase[:, None]), linewidth=1)
    height = 4 * np.sqrt((waves.amplitude**2 / 2).sum())

    for level in (-height / 2, height / 2):
        axes.axhline(level, color="k", linewidth=0.6, linestyle=":")

    axes.set_title(
        f"elevation at the origin, m; dots: half of the significant height, {height:.3g} m",
        loc="left",
        fontsize="medium",
    )
    axes.set_xlabel("time, s")
    axes.set_xlim(time[0], time[-1])
    axes.grid(alpha=0.3)
