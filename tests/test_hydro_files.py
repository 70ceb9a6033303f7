"""Files of coefficients: one body as WAMIT, capytaine, BEMIO and NEMOH write it; models of radiation in states."""

import numpy as np
import pytest
from scenes import assert_near
from test_hydrodynamics import INFINITE, RHO, G, exciting, files, response

from mbdfmi.hydro.memory import Kernel, fit
from mbdfmi.hydro.reading import read_coefficients, read_states

h5py = pytest.importorskip("h5py")

OMEGA = np.linspace(0.1, 4.0, 40)
HEADINGS = np.radians([0.0, 30.0, 60.0, 90.0])


def values():
    """(added, damping, excitation) at OMEGA and HEADINGS."""
    H = response(OMEGA)
    force = np.array([[exciting(w, b) for b in HEADINGS] for w in OMEGA])
    return INFINITE + H.imag / OMEGA[:, None, None], H.real, force


@pytest.fixture(scope="module")
def written(tmp_path_factory):
    """Format -> its file."""
    folder = tmp_path_factory.mktemp("formats")
    added, damping, force = values()

    with h5py.File(folder / "body.nc", "w") as file:
        # frequencies 0 and inf, and one that failed, are there too
        omega = np.concatenate([[0.0], OMEGA, [np.inf, 5.0]])
        grown = lambda x: np.concatenate([x[:1], x, x[:1], np.full_like(x[:1], np.nan)])
        names = np.array([f"hull__{dof}" for dof in ("Surge", "Sway", "Heave", "Roll", "Pitch", "Yaw")], "S")
        axes = {"omega": omega, "radiating_dof": names, "influenced_dof": names, "wave_direction": HEADINGS}
        axes["complex"] = np.array(["re", "im"], "S")

        for name, data in axes.items():
            file[name] = data
            file[name].make_scale(name)

        for name, data, order in (
            ("added_mass", grown(added).transpose(0, 2, 1), ("omega", "radiating_dof", "influenced_dof")),
            (
                "radiation_damping",
                grown(damping).transpose(0, 2, 1),
                ("omega", "radiating_dof", "influenced_dof"),
            ),
            (
                "Froude_Krylov_force",
                np.array([grown(0.25 * force).real, -grown(0.25 * force).imag]),
                ("complex", "omega", "wave_direction", "influenced_dof"),
            ),
            (
                "diffraction_force",
                np.array([grown(0.75 * force).real, -grown(0.75 * force).imag]),
                ("complex", "omega", "wave_direction", "influenced_dof"),
            ),
        ):
            file[name] = data
            for k, axis in enumerate(order):
                file[name].dims[k].attach_scale(file[axis])

    with h5py.File(folder / "body.h5", "w") as file:
        file["simulation_parameters/w"] = OMEGA[None, ::-1]
        file["simulation_parameters/wave_dir"] = np.degrees(HEADINGS)[:, None]
        body = file.create_group("body1/hydro_coeffs")
        body["added_mass/all"] = np.moveaxis(added[::-1] / RHO, 0, -1)
        body["added_mass/inf_freq"] = INFINITE / RHO
        body["radiation_damping/all"] = np.moveaxis(damping[::-1] / RHO / OMEGA[::-1, None, None], 0, -1)

        for part, x in (("re", force.real), ("im", force.imag)):
            body[f"excitation/{part}"] = np.moveaxis(x[::-1] / (RHO * G), (0, 1, 2), (2, 1, 0))

    lines = ['VARIABLES="w (rad/s)"'] + [f'"A 1 {i}" "B 1 {i}"' for i in range(1, 7)]

    for j in range(6):
        lines.append(f'Zone t="Motion of body 1 in DoF {j + 1}",I= {len(OMEGA)},F=POINT')
        pairs = [np.column_stack([a[:, j], b[:, j]]).ravel() for a, b in zip(added, damping)]
        lines += [" ".join(f"{x:.16E}" for x in (w, *pair)) for w, pair in zip(OMEGA, pairs)]

    (folder / "RadiationCoefficients.tec").write_text("\n".join(lines))
    lines = ['VARIABLES="w (rad/s)"', '"abs(F1)" "angle(F1)"']

    for k, b in enumerate(HEADINGS):
        lines.append(f'Zone t="Diffraction force - beta = {np.degrees(b):8.3f} deg",I= {len(OMEGA)},F=POINT')
        for w, x in zip(OMEGA, force[:, k]):
            pairs = np.column_stack([np.abs(x), -np.degrees(np.angle(x))]).ravel()
            lines.append(" ".join(f"{value:.16E}" for value in (w, *pairs)))

    (folder / "ExcitationForce.tec").write_text("\n".join(lines))
    return {path.suffix: path for path in folder.iterdir() if path.name != "ExcitationForce.tec"}


@pytest.mark.parametrize("ending", [".nc", ".h5", ".tec"])
def test_a_body_is_the_same_from_every_file(written, ending):
    found, notes = read_coefficients(written[ending], RHO, G).checked()
    added, damping, force = values()
    assert notes == []
    assert_near(found.omega, OMEGA, 1e-12)
    assert_near(found.added, added, 1e-9 * np.abs(added).max())
    assert_near(found.damping, damping, 1e-9 * np.abs(damping).max())
    assert_near(found.wave_omega, OMEGA, 1e-12)
    assert_near(found.headings, HEADINGS, 1e-9)
    assert_near(found.excitation, force, 1e-9 * np.abs(force).max())
    assert (found.infinite is not None) == (ending == ".h5")


def test_wamits_files_are_the_same_body(tmp_path):
    found = read_coefficients(files(tmp_path), RHO, G)
    H = response(found.omega)
    assert_near(found.added, INFINITE + H.imag / found.omega[:, None, None], 1e-8 * INFINITE.max())
    assert_near(found.damping, H.real, 1e-8 * np.abs(H.real).max())
    assert_near(found.exciting([0.7], [np.radians(-30)])[0], exciting(0.7, np.radians(-30)), 1.0)
    assert_near(found.infinite, INFINITE, 1e-6)


def test_added_mass_at_infinity_follows_from_the_rest(tmp_path):
    """Where a file has none: Ogilvie's relation."""
    from dataclasses import replace

    found = read_coefficients(files(tmp_path), RHO, G)
    kernel = Kernel(replace(found, infinite=None))
    assert_near(kernel.infinite / np.abs(INFINITE).max(), INFINITE / np.abs(INFINITE).max(), 2e-3)


def test_a_ready_model_in_states(tmp_path):
    """x' = A x + B V of two modes, as a fitter writes it: the same response."""
    A = np.array([[-1.2, -0.8, 0], [1, 0, 0], [0, 0, -0.5]])
    B, C = np.zeros((3, 6)), np.zeros((6, 3))
    B[0, 2], B[2, 4], C[2, 0], C[4, 2] = 1.0, 2.0, 3e5, 4e6
    rows = "\n".join(" ".join(f"{x:.17g}" for x in row) for row in [*A, *B, *C])
    head = "fitted by hand\n1 1 1 1 1 1 %enabled\n3 %states\n0 0 2 0 1 0 %by motion\n"
    (tmp_path / "a.ss").write_text(head + rows)
    memory = read_states(tmp_path / "a.ss", INFINITE)
    omega = np.linspace(0.1, 5, 20)
    wanted = [C @ np.linalg.solve(1j * w * np.eye(3) - A, B) for w in omega]
    assert_near(memory.response(omega), np.array(wanted), 1e-6)

    (tmp_path / "b.ss").write_text(head + rows.replace("-0.5", "0.5"))
    with pytest.raises(ValueError, match="a pole at 0.5 1/s, which grows"):
        read_states(tmp_path / "b.ss", INFINITE)


def test_files_that_are_none(tmp_path):
    (tmp_path / "a.nc").write_text("no HDF5")
    (tmp_path / "a.txt").write_text("1")

    for name, words in (
        ("a.nc", "is no HDF5 file|unable"),
        ("a.txt", "of unknown format"),
        ("b.1", "No such file"),
    ):
        with pytest.raises(ValueError, match=words):
            read_coefficients(tmp_path / name, RHO, G)


def test_irregular_frequencies_do_not_stop_a_fit(tmp_path):
    """A spike of B between two frequencies: the memory meets it, passive and stable."""
    from dataclasses import replace

    found = read_coefficients(files(tmp_path), RHO, G)
    damping = found.damping.copy()
    damping[60, 2, 2] *= 1.5
    memory = fit(replace(found, damping=damping), 0.01)
    assert memory.pole[:, 0].max() < 0
    assert memory.error < 0.02
    H = memory.response(np.linspace(0.01, 20, 400))[:, 2, 2]
    assert H.real.min() > -1e-5 * H.real.max()
