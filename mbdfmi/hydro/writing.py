"""Coefficients into files that the readers read."""

from pathlib import Path

import numpy as np

from ..files import replacing
from .database import DOFS, Coefficients
from .wamit import write_wamit

ENDINGS = (".1", ".nc")


def write_coefficients(path, coefficients: Coefficients, density, gravity):
    """As NAME.1, with NAME.3 beside it, or as NAME.nc."""
    if Path(path).suffix.lower() == ".1":
        write_wamit(path, coefficients, density, gravity)
    else:
        _write_dataset(path, coefficients, density, gravity)


def _write_dataset(path, coefficients, density, gravity):
    """A dataset as capytaine's, in NetCDF 3: time is exp(-i omega t) there."""
    from scipy.io import netcdf_file

    force = coefficients.excitation
    parts = None if force is None else np.stack([force.real, -force.imag])

    with replacing(path) as temporary, netcdf_file(temporary, "w") as file:
        axes = {"omega": coefficients.omega, "radiating_dof": DOFS, "influenced_dof": DOFS}

        if parts is not None:
            axes |= {"complex": ("re", "im"), "wave_direction": coefficients.headings}

        file.createDimension("letters", max(map(len, DOFS)))

        for name, values in axes.items():
            file.createDimension(name, len(values))

            if isinstance(values[0], str):
                texts = np.array([word.capitalize() if word in DOFS else word for word in values], "S8")
                file.createVariable(name, "c", (name, "letters"))[:] = texts.view("S1").reshape(
                    len(values), 8
                )[:, :5]
            else:
                file.createVariable(name, "d", (name,))[:] = values

        by = ("omega", "radiating_dof", "influenced_dof")
        file.createVariable("added_mass", "d", by)[:] = coefficients.added.transpose(0, 2, 1)
        file.createVariable("radiation_damping", "d", by)[:] = coefficients.damping.transpose(0, 2, 1)

        if parts is not None:
            order = ("complex", "omega", "wave_direction", "influenced_dof")
            file.createVariable("excitation_force", "d", order)[:] = parts

        for name, value in (("rho", density), ("g", gravity)):
            file.createVariable(name, "d", ())[...] = value
