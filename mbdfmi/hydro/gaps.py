"""Files with holes: what is given at some frequencies and missing at others is not zero there."""

import numpy as np

from .database import motion

# frequencies that a message names
NAMED = 3


def pair(i, j):
    """Words for an element of added mass and damping, of motions from 0."""
    bodies = max(i, j) // 6 + 1
    return f"added mass and damping of modes {i + 1}, {j + 1} ({motion(i, bodies)}, {motion(j, bodies)})"


def mode(i):
    """Words for a motion from 0."""
    return f"mode {i + 1} ({motion(i, i // 6 + 1)})"


def check_whole(path, omega, known, name):
    """Each element is given at all frequencies, or at none. Raises ValueError that names what is missing.

    omega : (n,) rad/s. known : (n, ...) bool, what is given. name : words for the index of an element.
    """
    ragged = np.argwhere(known.any(axis=0) & ~known.all(axis=0))

    if len(ragged):
        index = tuple(int(k) for k in ragged[0])
        missing = omega[~known[(slice(None), *index)]]
        words = ", ".join(f"{w:.6g}" for w in missing[:NAMED]) + (", ..." if len(missing) > NAMED else "")
        rest = f" (and {len(ragged) - 1} more like it)" if len(ragged) > 1 else ""
        raise ValueError(
            f"{path}: {name(*index)}{rest}: given at {len(omega) - len(missing)} of {len(omega)} "
            f"frequencies, missing at {words} rad/s; is the file cut short? "
            "Each is needed at all frequencies, or, as zero, at none"
        )


def check_headings(path, omega, degrees, known):
    """The same of excitation: known (n, headings, 6). A motion is given at all headings, or at none."""
    check_whole(path, omega, known, lambda h, i: f"excitation of {mode(i)} at heading {degrees[h]:g} degrees")
    given = known.any(axis=0)
    missing = np.argwhere(given.any(axis=0) & ~given)

    if len(missing):
        h, i = missing[0]
        raise ValueError(
            f"{path}: excitation of {mode(i)}: given at {given[:, i].sum()} of {len(degrees)} headings, "
            f"missing at {degrees[h]:g} degrees"
        )


def alive(omega, known):
    """Indices of frequencies above 0 and finite at which anything is given, ascending: others failed."""
    found = np.flatnonzero(np.isfinite(omega) & (omega > 0) & known.reshape(len(omega), -1).any(axis=1))
    return found[np.argsort(omega[found])]
