"""NEMOH's results: RadiationCoefficients.tec, and ExcitationForce.tec beside it."""

import re
from pathlib import Path

import numpy as np

from .database import Coefficients
from .gaps import check_whole


def read_nemoh(path) -> Coefficients:
    """Coefficients in SI as they are written. Raises ValueError that names the file."""
    path = Path(path)
    zones = list(_zones(path))

    if not zones or len(zones) % 6:
        raise ValueError(f"{path}: has {len(zones)} zones, one for each motion are 6 for a body")

    omega = _frequencies(path, zones)
    _check_width(path, zones, len(zones))
    values = np.array([rows[:, 1:] for _, rows in zones])
    added, damping = values[:, :, ::2].transpose(1, 0, 2), values[:, :, 1::2].transpose(1, 0, 2)
    beside = path.with_name("ExcitationForce.tec")
    rest = _excitation(beside, len(zones)) if beside.is_file() else (None, None, None)
    return Coefficients(omega, added, damping, None, *rest)


def _frequencies(path, zones):
    """(n,) rad/s, those of every zone. Raises ValueError that names the zone which has not all of them."""
    omega = np.unique(np.concatenate([rows[:, 0] for _, rows in zones]))
    known = np.array([np.isin(omega, rows[:, 0]) for _, rows in zones]).T
    check_whole(path, omega, known, lambda k: f"zone {zones[k][0].strip()[:60]!r}")

    if any(len(rows) != len(omega) or (rows[:, 0] != omega).any() for _, rows in zones):
        raise ValueError(f"{path}: has zones whose frequencies do not ascend")

    return omega


def _check_width(path, zones, motions):
    """Raises ValueError where rows are not a frequency and two numbers for each motion."""
    for title, rows in zones:
        if rows.shape[1] != 1 + 2 * motions:
            raise ValueError(
                f"{path}: zone {title.strip()[:60]!r} has rows of {rows.shape[1]} numbers, not "
                f"{1 + 2 * motions} as of {motions} motions"
            )


def _zones(path):
    """(title, rows (n, width)) of each zone."""
    try:
        lines = path.read_text(encoding="utf-8", errors="replace").splitlines()
    except OSError as error:
        raise ValueError(f"{path}: {error.strerror}") from None

    title, rows = None, []

    for number, line in enumerate(lines, 1):
        if line.strip().lower().startswith("zone"):
            if rows:
                yield title, np.array(rows)
            title, rows = line, []
        elif title is not None and line.strip():
            try:
                row = [float(word) for word in line.split()]
            except ValueError:
                raise ValueError(
                    f"{path}: line {number} is no row of numbers: {line.strip()[:60]!r}"
                ) from None
            if rows and len(row) != len(rows[0]):
                raise ValueError(
                    f"{path}: line {number} has {len(row)} numbers, the line before {len(rows[0])}"
                )
            if not np.isfinite(row).all():
                raise ValueError(f"{path}: line {number} has what is no finite number: {line.strip()[:60]!r}")
            rows.append(row)

    if rows:
        yield title, np.array(rows)


def _excitation(path, motions):
    """(omega, headings, excitation): amplitudes and phases of exp(-i omega t), in rad or in degrees."""
    headings, forces = [], []
    zones = list(_zones(path))

    if not zones:
        raise ValueError(f"{path}: has no zones")

    _check_width(path, zones, motions)

    omega = _frequencies(path, zones)

    for title, rows in zones:
        found = re.search(r"beta\s*=\s*([-+.\deE]+)", title)
        if not found:
            raise ValueError(f"{path}: a zone names no heading beta: {title[:60]!r}")
        headings.append(np.radians(float(found[1])))
        forces.append((rows[:, 1::2], rows[:, 2::2]))

    phases = np.array([phase for _, phase in forces])
    phases = np.radians(phases) if np.abs(phases).max() > 2 * np.pi + 0.1 else phases
    values = np.array([size for size, _ in forces]) * np.exp(-1j * phases)
    order = np.argsort(headings)
    return omega, np.array(headings)[order], values[order].transpose(1, 0, 2)
