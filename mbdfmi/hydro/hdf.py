"""Databases in NetCDF, as capytaine writes them, and HDF5, as BEMIO (WEC-Sim)."""

import re
from pathlib import Path

import numpy as np

from .database import DOFS, Coefficients
from .gaps import alive, check_headings, check_whole, pair


def read_hdf(path, density, gravity) -> Coefficients:
    """Coefficients of a dataset of capytaine or a file of BEMIO. Raises ValueError that names the file."""
    with open(path, "rb") as file:
        classic = file.read(3) == b"CDF"

    if classic:
        return _capytaine(path, _classic(path))

    try:
        import h5py
    except ImportError:
        raise ValueError(f'{path}: needs h5py to be read: pip install "mbdfmi[hydro]"') from None

    try:
        with h5py.File(path) as file:
            if "added_mass" in file and "radiation_damping" in file:
                return _capytaine(path, {name: _variable(file[name]) for name in file})
            if any(re.fullmatch(r"body\d+", name) for name in file):
                return _bemio(path, file, density, gravity)
            found = ", ".join(file)
    except OSError as error:
        raise ValueError(f"{path}: {error.strerror or 'is no HDF5 file'}") from None
    except KeyError as error:
        raise ValueError(f"{path}: {error.args[0]}") from None

    raise ValueError(f"{path}: is neither a dataset of capytaine nor a file of BEMIO; holds {found}")


def _classic(path):
    """{name: (names of its axes, values)} of NetCDF 3; texts are bytes there, one axis more."""
    from scipy.io import netcdf_file

    with netcdf_file(path, mmap=False) as file:
        found = {name: (list(v.dimensions), np.array(v.data)) for name, v in file.variables.items()}

    return {
        name: (axes[:-1], np.array([b"".join(row).rstrip(b"\0 ") for row in values]))
        if values.dtype.kind == "S" and len(axes) == 2
        else (axes, values)
        for name, (axes, values) in found.items()
    }


def _variable(dataset):
    """(names of its axes, values) of a variable of NetCDF 4."""
    axes = [Path(scale[0].name).name if len(scale) else "" for scale in dataset.dims]
    return axes, np.array(dataset)


# capytaine


def coefficients_of(dataset) -> Coefficients:
    """Of a dataset of capytaine in memory (xarray)."""
    found = {}

    for name in (*dataset.coords, *dataset.data_vars):
        axes, values = list(dataset[name].dims), dataset[name].values

        if np.iscomplexobj(values):
            axes, values = ["complex", *axes], np.array([values.real, values.imag])

        found[name] = (axes, values)

    return _capytaine("dataset", found)


def _dofs(path, names):
    """Indices of motions by their names, as "Heave" or "buoy__Heave"; bodies in the order of their first
    motions.
    """
    texts = [name.decode() if isinstance(name, bytes) else str(name) for name in names]
    bodies = list(dict.fromkeys(text.rpartition("__")[0] for text in texts))
    found = []

    for text in texts:
        body, _, word = text.rpartition("__")

        if word.lower() not in DOFS:
            raise ValueError(f"{path}: motion {text!r} is none of {', '.join(DOFS)} of a rigid body")

        found.append(6 * bodies.index(body) + DOFS.index(word.lower()))

    if len(set(found)) != len(found):
        raise ValueError(
            f"{path}: has motion {texts[[k in found[:i] for i, k in enumerate(found)].index(True)]!r} twice"
        )

    return found


def _capytaine(path, file):
    """Time is exp(-i omega t) there: forces are the conjugate of ours. omega = 0 and inf may be there."""
    omega = np.array(file["omega"][1], float)
    radiating, influenced = (_dofs(path, file[f"{name}_dof"][1]) for name in ("radiating", "influenced"))
    motions = 6 * (max(radiating + influenced) // 6 + 1)

    def matrices(name):
        order, values = file[name]
        wanted = [order.index(axis) for axis in ("omega", "influenced_dof", "radiating_dof")]

        # other axes have one value, as water depth
        others = [k for k in range(values.ndim) if k not in wanted]
        values = np.transpose(values, wanted + others).reshape(*(values.shape[k] for k in wanted))
        full = np.full((len(omega), motions, motions), np.nan)
        full[np.ix_(range(len(omega)), influenced, radiating)] = values
        return full

    good, added, damping = _radiating(path, omega, matrices("added_mass"), matrices("radiation_damping"))

    # never A at omega = inf, which depends on the mesh: the memory finds it
    rest = _capytaine_forces(path, file, omega, influenced, motions)
    return Coefficients(omega[good], added, damping, None, *rest)


def _radiating(path, omega, added, damping):
    """(indices of the frequencies that are there, added mass, damping at these): what is nowhere is zero."""
    known = np.isfinite(added) & np.isfinite(damping)
    good = alive(omega, known)
    known = known[good]
    check_whole(path, omega[good], known, pair)
    return good, np.where(known, added[good], 0.0), np.where(known, damping[good], 0.0)


def _exciting(path, omega, headings, force):
    """(omega, headings in rad, excitation), ascending, as `_radiating`; None each where all failed."""
    turn, known = np.argsort(headings), np.isfinite(force)
    good = alive(omega, known)

    if not len(good):
        return None, None, None

    known, force = known[good][:, turn], force[good][:, turn]
    check_headings(path, omega[good], np.degrees(headings[turn]), known)
    return omega[good], headings[turn], np.where(known, force, 0.0)


def _capytaine_forces(path, file, omega, influenced, motions):
    """(omega, headings, excitation), None each without."""
    names = (
        ["excitation_force"] if "excitation_force" in file else ["Froude_Krylov_force", "diffraction_force"]
    )

    if not all(name in file for name in names):
        return None, None, None

    headings = np.array(file["wave_direction"][1], float)
    total = np.full((len(omega), len(headings), motions), np.nan, complex)
    total[:, :, influenced] = 0.0

    for name in names:
        order, values = file[name]
        wanted = [order.index(axis) for axis in ("complex", "omega", "wave_direction", "influenced_dof")]
        others = [k for k in range(values.ndim) if k not in wanted]
        values = np.transpose(values, wanted + others).reshape(*(values.shape[k] for k in wanted))
        total[:, :, influenced] += values[0] - 1j * values[1]

    return _exciting(path, omega, headings, total)


# BEMIO


def _bemio(path, file, density, gravity):
    """A by rho, B by rho omega, X by rho g; of each body its rows."""
    bodies = sorted((name for name in file if re.fullmatch(r"body\d+", name)), key=lambda name: int(name[4:]))
    settings, found = file["simulation_parameters"], [file[name]["hydro_coeffs"] for name in bodies]
    omega = np.ravel(settings["w"])
    motions = 6 * len(bodies)

    def rows(name):
        return [np.array(part[name], float) for part in found]

    added, damping = (
        density * np.moveaxis(np.concatenate(rows(f"{name}/all")), -1, 0)
        for name in ("added_mass", "radiation_damping")
    )

    if not added.shape == damping.shape == (len(omega), motions, motions):
        raise ValueError(
            f"{path}: has {len(omega)} frequencies and {motions} motions; added mass and damping are "
            f"{added.shape}, {damping.shape}"
        )

    good, added, damping = _radiating(path, omega, added, damping * omega[:, None, None])
    infinite = None

    if all("inf_freq" in part["added_mass"] for part in found):
        infinite = density * np.concatenate(rows("added_mass/inf_freq"))

    force = np.concatenate(rows("excitation/re")) + 1j * np.concatenate(rows("excitation/im"))
    headings = np.radians(np.ravel(settings["wave_dir"]))
    force = density * gravity * np.moveaxis(force, (2, 1, 0), (0, 1, 2))
    return Coefficients(omega[good], added, damping, infinite, *_exciting(path, omega, headings, force))
