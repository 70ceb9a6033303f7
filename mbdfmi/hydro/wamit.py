"""WAMIT's files: NAME.1 (added mass and damping), NAME.3 (excitation); either may be gzipped."""

import gzip
from pathlib import Path

import numpy as np

from ..files import replacing
from .database import Coefficients


def read_wamit(path, density, gravity, scale=1.0) -> Coefficients:
    """Coefficients of NAME.1 and, where it is there, NAME.3 beside it.

    scale : m, the length that they are non-dimensional by (ULEN). Raises ValueError that names file and line.
    """
    path = Path(path)
    omega, added, damping, infinite = _radiation(path, density, scale)
    waves = next((p for p in (path.with_suffix(".3"), path.with_suffix(".3.gz")) if p.is_file()), None)
    rest = _excitation(waves, density, gravity, scale) if waves else (None, None, None)
    return Coefficients(omega, added, damping, infinite, *rest)


def _rows(path, widths):
    """[numbers] of the lines of a file that have one of these numbers of columns; heads are passed over."""
    opened = gzip.open if path.suffix == ".gz" else open

    with opened(path, "rt", encoding="utf-8", errors="replace") as file:
        for number, line in enumerate(file, 1):
            try:
                row = [float(word) for word in line.split()]
            except ValueError:
                if number == 1:
                    continue
                raise ValueError(
                    f"{path}: line {number} is no row of numbers: {line.strip()[:60]!r}"
                ) from None

            if row and len(row) not in widths:
                raise ValueError(
                    f"{path}: line {number} has {len(row)} numbers; needs {' or '.join(map(str, widths))}"
                )
            if row:
                yield number, row


def _dof(path, number, value):
    """Index from 0 of a degree of freedom."""
    if value != int(value) or not 1 <= value <= 6:
        raise ValueError(
            f"{path}: line {number} is about degree of freedom {value:g}; only 1 to 6, of one body, are read"
        )
    return int(value) - 1


def _radiation(path, density, scale):
    """(omega, added, damping, infinite) in SI."""
    found, infinite = {}, np.full((6, 6), np.nan)

    for number, (period, i, j, *values) in _rows(path, (4, 5)):
        i, j = _dof(path, number, i), _dof(path, number, j)
        length = density * scale ** (3 + (i > 2) + (j > 2))

        # period 0 stands for omega = inf, -1 for omega = 0
        if period == 0.0:
            infinite[i, j] = length * values[0]
        elif period > 0.0:
            omega = 2 * np.pi / period
            A, B = found.setdefault(omega, (np.zeros((6, 6)), np.zeros((6, 6))))
            A[i, j] = length * values[0]
            B[i, j] = length * omega * values[1] if len(values) > 1 else 0.0

    if len(found) < 4:
        raise ValueError(f"{path}: has {len(found)} frequencies; a memory of waves needs more")

    omega = np.array(sorted(found))
    added, damping = (np.array([found[w][k] for w in omega]) for k in (0, 1))
    known = np.isfinite(infinite).any()
    return omega, added, damping, np.nan_to_num(infinite) if known else None


def _excitation(path, density, gravity, scale):
    """(omega, headings, excitation) in SI."""
    found = {}

    for number, (period, heading, i, _, _, re, im) in _rows(path, (7,)):
        i = _dof(path, number, i)
        if period > 0.0:
            value = density * gravity * scale ** (2 + (i > 2)) * complex(re, im)
            found[2 * np.pi / period, heading, i] = value

    omega = np.array(sorted({key[0] for key in found}))
    degrees = sorted({key[1] for key in found})
    excitation = np.zeros((len(omega), len(degrees), 6), complex)

    for (w, heading, i), value in found.items():
        excitation[np.searchsorted(omega, w), degrees.index(heading), i] = value

    # -180 and 180 are one
    if degrees[-1] - degrees[0] == 360.0:
        degrees, excitation = degrees[:-1], excitation[:, :-1]

    return omega, np.radians(degrees), excitation


def write_wamit(path, coefficients, density, gravity):
    """NAME.1, and NAME.3 beside it where there is excitation, with 8 digits; lengths by 1 m."""
    path = Path(path)
    lines = []

    if coefficients.infinite is not None:
        lines += [
            f"{0.0:15.8E} {i + 1} {j + 1} {coefficients.infinite[i, j] / density:15.8E}"
            for i, j in np.ndindex(6, 6)
        ]

    for omega, A, B in zip(coefficients.omega, coefficients.added / density, coefficients.damping / density):
        lines += [
            f"{2 * np.pi / omega:15.8E} {i + 1} {j + 1} {A[i, j]:15.8E} {B[i, j] / omega:15.8E}"
            for i, j in np.ndindex(6, 6)
            if A[i, j] or B[i, j]
        ]

    _write(path, lines)

    if coefficients.excitation is None:
        return

    lines = []

    for omega, of_heading in zip(coefficients.wave_omega, coefficients.excitation / (density * gravity)):
        for heading, force in zip(np.degrees(coefficients.headings), of_heading):
            lines += [
                f"{2 * np.pi / omega:15.8E} {heading:10.4f} {i + 1} {abs(x):15.8E} "
                f"{np.degrees(np.angle(x)):10.4f} {x.real:15.8E} {x.imag:15.8E}"
                for i, x in enumerate(force)
            ]

    _write(path.with_suffix(".3"), lines)


def _write(path, lines):
    with replacing(path) as temporary:
        Path(temporary).write_text("\n".join(lines) + "\n", encoding="utf-8")
