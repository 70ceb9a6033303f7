"""The picture of a body's coefficients over frequency, and of the memory fitted to them."""

from pathlib import Path

import numpy as np

from ..files import save_figure
from .database import DOFS, Coefficients
from .memory import Kernel, Memory

# parts of the largest of a kind below which a curve is not drawn
SMALL = 1e-3

FINE = 400


def draw_coefficients(path, coefficients: Coefficients, memory: Memory | None = None, title="") -> Path:
    """Added mass, damping and forces of waves, translations on the left, rotations on the right; dots are
    the file, lines the memory.

    path : png, svg or pdf.
    """
    from matplotlib.figure import Figure

    excited = coefficients.excitation is not None
    figure = Figure(figsize=(11, 12 if excited else 6.5), layout="constrained")
    rows = figure.subplots(4 if excited else 2, 2, sharex=True)
    figure.suptitle(title, fontsize="medium")

    for column, (motions, force, turn) in enumerate(((range(3), "N", "kg"), (range(3, 6), "N m", "kg m²"))):
        _draw_radiation(rows[0][column], rows[1][column], coefficients, memory, motions)
        rows[0][column].set_ylabel(f"added mass, {turn}")
        rows[1][column].set_ylabel(f"damping, {force} s{'/m' if column == 0 else ''}")

        if excited:
            _draw_excitation(rows[2][column], rows[3][column], coefficients, motions)
            rows[2][column].set_ylabel(f"waves, {force}/m")
            rows[3][column].set_ylabel("phase before the crest, deg")
            rows[3][column].set_yticks(range(-180, 181, 90))

        rows[-1][column].set_xlabel("rad/s")

    for axes in rows.flat:
        axes.grid(alpha=0.3)

        if axes.get_legend_handles_labels()[0]:
            axes.legend(fontsize="small")

    save_figure(figure, path)
    return Path(path)


def _draw_radiation(above, below, coefficients, memory, motions):
    """Diagonals of A and B; what the memory makes of them as lines."""
    omega = coefficients.omega
    fine = np.linspace(omega[0], omega[-1], FINE)
    H = memory.response(fine) if memory and len(memory.pole) else None

    for values, axes in ((coefficients.added, above), (coefficients.damping, below)):
        largest = max(np.abs(values[:, k, k]).max() for k in motions)

        for k in motions:
            if np.abs(values[:, k, k]).max() > SMALL * largest:
                axes.plot(omega, values[:, k, k], ".", color=f"C{k % 3}", label=DOFS[k])

                if H is not None and memory is not None:
                    line = (
                        memory.infinite[k, k] + H[:, k, k].imag / fine if axes is above else H[:, k, k].real
                    )
                    axes.plot(fine, line, linewidth=1, color=f"C{k % 3}")


def _draw_excitation(size, phase, coefficients, motions):
    """Amplitudes and phases of the forces of waves of the first heading."""
    values = coefficients.excitation[:, 0]
    largest = max(np.abs(values[:, k]).max() for k in motions)
    heading = np.degrees(coefficients.headings[0])
    size.set_title(f"waves that travel at {heading:.4g} deg", loc="left", fontsize="small")

    for k in motions:
        if np.abs(values[:, k]).max() > SMALL * largest:
            size.plot(
                coefficients.wave_omega,
                np.abs(values[:, k]),
                ".-",
                linewidth=0.8,
                color=f"C{k % 3}",
                label=DOFS[k],
            )
            phase.plot(coefficients.wave_omega, np.degrees(np.angle(values[:, k])), ".", color=f"C{k % 3}")


def scatter(coefficients: Coefficients) -> np.ndarray:
    """(6,) how far the added mass at infinite frequency that single frequencies ask for lies from their
    median, by it: the middle one of these (Ogilvie's relation); not finite where there is none.
    """
    kernel = Kernel(coefficients)
    inside = slice(len(coefficients.omega) // 5, -len(coefficients.omega) // 5 or None)
    asked = coefficients.added[inside] - kernel.added(coefficients.omega[inside])
    off = np.median(np.abs(asked - kernel.infinite), axis=0).diagonal()
    with np.errstate(divide="ignore", invalid="ignore"):
        return off / np.abs(kernel.infinite.diagonal())
