"""Damping of floating bodies beside the waves that they make."""

import numpy as np

from .builder import Place
from .variables import dotted

# elements of a matrix: by velocity and angular velocity, of force and moment
UNITS = {
    "damping": ("N.s/m", "N.s/rad", "N.s", "N.m.s/rad"),
    "quadratic": ("N.s2/m2", "N.s2/rad2", "N.s2/m", "N.m.s2/rad2"),
}
ARRAYS = {"damping": "resistance_linear", "quadratic": "resistance_quadratic"}
WORDS = {"damping": "linear damping", "quadratic": "quadratic damping"}


def add_resistance(builder, name, force, ends, axes):
    """Rows of the damping that a scene adds to what waves made take, -1 without."""
    spec = force.hydrodynamics
    given = {key: spec.matrices(key) for key in ARRAYS}

    if not any(given.values()):
        return [-1] * len(ends)

    rows = []

    for k, (marker, end) in enumerate(zip(ends, force.between)):
        own = {key: found[k] if found else np.zeros((6, 6)) for key, found in given.items()}
        row = builder.tables["n_resistance"].add(
            resistance_marker=marker,
            resistance_axes=axes,
            **{ARRAYS[key]: matrix for key, matrix in own.items()},
        )
        rows.append(row)
        parts = (name,) if len(ends) == 1 else (name, end.split(".")[0])

        for key, found in given.items():
            if found:
                units = UNITS[key]
                unit = [units[2 * (i > 2) + (j > 2)] for i in range(6) for j in range(6)]
                about = f"{WORDS[key]} of {', '.join(parts)} (x, y, z, rx, ry, rz)"
                builder.add_parameters(dotted(*parts, key), Place(ARRAYS[key], row), own[key], unit, about)

    return rows
