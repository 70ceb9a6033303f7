"""WAMIT's files: NAME.1 (added mass and damping), NAME.3 (excitation); either may be gzipped."""

import gzip
import zlib
from pathlib import Path

import numpy as np

from ..files import replacing
from .database import Coefficients
from .gaps import check_headings, check_whole, pair

# more degrees of freedom than these have are no file of WAMIT's
MOST_BODIES = 20


def read_wamit(path, density, gravity, scale=1.0) -> Coefficients:
    """Coefficients of NAME.1 and, where it is there, NAME.3 beside it.

    scale : m, the length that they are non-dimensional by (ULEN). Raises ValueError that names file and line.
    """
    path = Path(path)
    rows = list(_rows(path, (4, 5)))
    motions = _motions(path, rows)
    omega, added, damping, infinite = _radiation(path, rows, motions, density, scale)
    waves = next((p for p in (path.with_suffix(".3"), path.with_suffix(".3.gz")) if p.is_file()), None)
    rest = _excitation(waves, motions, density, gravity, scale) if waves else (None, None, None)
    return Coefficients(omega, added, damping, infinite, *rest)


def _rows(path, widths):
    """(number, [numbers]) of the lines of a file that have one of these numbers of columns; not of heads."""
    for number, line in _lines(path):
        if line.strip():
            try:
                row = [float(word) for word in line.split()]
            except ValueError:
                if number == 1:
                    continue
                raise ValueError(
                    f"{path}: line {number} is no row of numbers: {line.strip()[:60]!r}"
                ) from None

            if len(row) not in widths:
                raise ValueError(
                    f"{path}: line {number} has {len(row)} numbers; needs {' or '.join(map(str, widths))}"
                )
            if not np.isfinite(row).all():
                raise ValueError(f"{path}: line {number} has what is no finite number: {line.strip()[:60]!r}")

            yield number, row


def _lines(path):
    """(number, line) of a file, of a gzipped one what is in it. Raises ValueError where that is cut short."""
    opened = gzip.open if path.suffix == ".gz" else open

    try:
        with opened(path, "rt", encoding="utf-8", errors="replace") as file:
            yield from enumerate(file, 1)
    except (EOFError, zlib.error) as error:
        raise ValueError(f"{path}: cannot be unpacked: {error}") from None


def _motions(path, rows):
    """6 for each body that the rows tell of."""
    highest = max((_dof(path, number, k) for number, row in rows for k in row[1:3]), default=0)
    return 6 * (highest // 6 + 1)


def _dof(path, number, value, motions=6 * MOST_BODIES):
    """Index from 0 of a degree of freedom."""
    if value != int(value) or not 1 <= value <= motions:
        raise ValueError(f"{path}: line {number} is about degree of freedom {value:g}, of 1 to {motions}")
    return int(value) - 1


def _radiation(path, rows, motions, density, scale):
    """(omega, added, damping, infinite) in SI."""
    nothing = np.full((motions, motions), np.nan)
    found, infinite = {}, nothing.copy()

    for number, (period, i, j, *values) in rows:
        i, j = _dof(path, number, i), _dof(path, number, j)
        length = density * scale ** (3 + (i % 6 > 2) + (j % 6 > 2))

        # period 0 stands for omega = inf, -1 for omega = 0
        if period == 0.0:
            infinite[i, j] = length * values[0]
        elif period > 0.0:
            omega = 2 * np.pi / period
            A, B = found.setdefault(omega, (nothing.copy(), nothing.copy()))
            if len(values) < 2:
                raise ValueError(f"{path}: line {number} has no damping, at a period of {period:g} s")
            A[i, j], B[i, j] = length * values[0], length * omega * values[1]

    omega = np.array(sorted(found))
    added, damping = (np.array([found[w][k] for w in omega]).reshape(-1, motions, motions) for k in (0, 1))
    given, at_infinity = np.isfinite(added), np.isfinite(infinite)

    if not at_infinity.any():
        check_whole(path, omega, given, pair)
        return omega, np.nan_to_num(added), np.nan_to_num(damping), None

    # zeros at infinity may be of pairs that stand nowhere else
    at_infinity &= (infinite != 0.0) | given.any(axis=0)
    check_whole(path, np.append(omega, np.inf), np.concatenate([given, at_infinity[None]]), pair)
    return omega, np.nan_to_num(added), np.nan_to_num(damping), np.nan_to_num(infinite)


def _excitation(path, motions, density, gravity, scale):
    """(omega, headings, excitation) in SI."""
    found = {}

    for number, (period, heading, i, _, _, re, im) in _rows(path, (7,)):
        i = _dof(path, number, i, motions)
        if period > 0.0:
            value = density * gravity * scale ** (2 + (i % 6 > 2)) * complex(re, im)
            found[2 * np.pi / period, heading, i] = value

    omega = np.array(sorted({key[0] for key in found}))

    if not found:
        raise ValueError(f"{path}: has no frequencies")

    degrees = sorted({key[1] for key in found})
    excitation = np.zeros((len(omega), len(degrees), motions), complex)
    known = np.zeros(excitation.shape, bool)

    for (w, heading, i), value in found.items():
        at = np.searchsorted(omega, w), degrees.index(heading), i
        excitation[at], known[at] = value, True

    check_headings(path, omega, degrees, known)

    # -180 and 180 are one
    if degrees[-1] - degrees[0] == 360.0:
        degrees, excitation = degrees[:-1], excitation[:, :-1]

    return omega, np.radians(degrees), excitation


def write_wamit(path, coefficients, density, gravity):
    """NAME.1, and NAME.3 beside it where there is excitation, with 8 digits; lengths by 1 m."""
    path = Path(path)
    lines = []
    given = (coefficients.added != 0.0).any(axis=0) | (coefficients.damping != 0.0).any(axis=0)

    if coefficients.infinite is not None:
        given |= coefficients.infinite != 0.0
        lines += [
            f"{0.0:15.8E} {i + 1} {j + 1} {coefficients.infinite[i, j] / density:15.8E}"
            for i, j in np.ndindex(given.shape)
            if given[i, j]
        ]

    for omega, A, B in zip(coefficients.omega, coefficients.added / density, coefficients.damping / density):
        lines += [
            f"{2 * np.pi / omega:15.8E} {i + 1} {j + 1} {A[i, j]:15.8E} {B[i, j] / omega:15.8E}"
            for i, j in np.ndindex(given.shape)
            if given[i, j]
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
