"""Files of coefficients by their endings; state-space models of radiation as fitters write them."""

from pathlib import Path

import numpy as np

from .database import Coefficients
from .hdf import read_hdf
from .memory import Memory
from .nemoh import read_nemoh
from .wamit import read_wamit

ENDINGS = {".1": "WAMIT", ".nc": "capytaine", ".h5": "BEMIO", ".tec": "NEMOH"}

# frequencies of a body
LEAST = 4


def read_coefficients(path, density, gravity, scale=1.0) -> Coefficients:
    """Of a file of any of ENDINGS. Raises ValueError that names it."""
    if not Path(path).is_file():
        raise ValueError(f"{path}: No such file")

    found = _read(path, density, gravity, scale)

    if len(found.omega) < LEAST:
        raise ValueError(
            f"{path}: has {len(found.omega)} frequencies; a memory of waves needs {LEAST} or more"
        )
    if found.wave_omega is not None and len(found.wave_omega) < 2:
        raise ValueError(f"{path}: has excitation at {len(found.wave_omega)} frequency; it needs 2 or more")
    if not (np.diff(found.omega) > 0).all():
        raise ValueError(f"{path}: has a frequency twice")

    return found


def _read(path, density, gravity, scale):
    """Coefficients, by the file's ending."""
    ending = Path(path).suffix.lower()

    if ending == ".1":
        return read_wamit(path, density, gravity, scale)
    if ending in (".nc", ".h5", ".hdf5"):
        return read_hdf(path, density, gravity)
    if ending == ".tec":
        return read_nemoh(path)

    known = ", ".join(f"{ending} ({maker})" for ending, maker in ENDINGS.items())
    raise ValueError(f"{path}: of unknown format; read are {known}")


def read_states(path, infinite) -> Memory:
    """A radiation model in states (.ss, as SS_Fitting writes it): x' = A x + B V, force -C x, in SI.

    infinite : (6, 6) added mass of the database. Raises ValueError that names the file.
    """
    try:
        lines = Path(path).read_text(encoding="utf-8", errors="replace").splitlines()
    except OSError as error:
        raise ValueError(f"{path}: {error.strerror}") from None

    try:
        active = [int(word) for word in lines[1].split()[:6]]
        n = int(lines[2].split()[0])
        rows = [[float(word) for word in line.split()] for line in lines[4:] if line.strip()]
        A, B, C = np.array(rows[:n]), np.array(rows[n : 2 * n]), np.array(rows[2 * n : 2 * n + 6])
    except (ValueError, IndexError):
        raise ValueError(f"{path}: is no state-space model of radiation") from None

    if A.shape != (n, n) or B.shape != (n, 6) or C.shape != (6, n) or len(active) != 6:
        raise ValueError(f"{path}: needs A ({n}, {n}), B ({n}, 6) and C (6, {n})")

    values, vectors = np.linalg.eig(A)

    if values.real.max() >= 0:
        raise ValueError(f"{path}: has a pole at {values.real.max():.3g} 1/s, which grows")

    source, sink = np.linalg.solve(vectors, B.astype(complex)), C @ vectors
    pole, mate, into, out = [], [], [], []

    for k, p in enumerate(values):
        at = len(pole)
        if p.imag == 0.0:
            pole.append((p.real, 0.0))
            mate.append(at)
            into.append(source[k].real)
            out.append(sink[:, k].real)
        elif p.imag > 0.0:
            # z = a + i b: a' = sigma a - omega b, b' = omega a + sigma b, force 2 Re(sink z)
            pole += [(p.real, -p.imag), (p.real, p.imag)]
            mate += [at + 1, at]
            into += [source[k].real, source[k].imag]
            out += [2 * sink[:, k].real, -2 * sink[:, k].imag]

    return Memory(
        np.array(pole), np.array(mate), np.array(into), np.array(out), infinite, np.nan, [(list(range(6)), n)]
    )
