"""Files of coefficients: one body as WAMIT, capytaine, BEMIO and NEMOH write it; models of radiation in states."""

from pathlib import Path

import numpy as np
import pytest
from scenes import assert_near
from test_hydrodynamics import INFINITE, RHO, G, exciting, files, response

from mbdfmi.hydro import memory as memories
from mbdfmi.hydro.memory import Kernel, fit
from mbdfmi.hydro.reading import read_coefficients, read_states

h5py = pytest.importorskip("h5py")

WATER = Path(__file__).parent / "referee" / "water"

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
    wanted = [[exciting(w, b) for b in found.headings] for w in found.wave_omega]
    assert_near(found.excitation, np.array(wanted), 1e-8 * np.abs(wanted).max())
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


def dropped(name, wanted):
    """Rewrites a file without the lines whose words `wanted` refuses."""
    lines = [line for line in name.read_text().splitlines() if wanted(line.split())]
    name.write_text("\n".join(lines) + "\n")


def test_a_gap_in_wamits_files_is_refused_and_a_mode_that_is_nowhere_is_not(tmp_path):
    """A mode without some frequencies was zero there: heave of 0.995 m for 0.754 m. File, mode, frequencies are told."""
    path = tmp_path / "body.1"
    near = lambda words: 0.6 < 2 * np.pi / float(words[0]) < 0.79
    whole = read_coefficients(files(tmp_path), RHO, G)

    dropped(path, lambda words: not (float(words[0]) and words[1:3] == ["3", "3"] and near(words)))
    with pytest.raises(
        ValueError, match=r"body\.1: .*modes 3, 3 \(heave, heave\).*missing at 0.6, 0.64, 0.68, \.\.\."
    ):
        read_coefficients(path, RHO, G)

    files(tmp_path)
    dropped(path, lambda words: not (float(words[0]) == 0.0 and words[1:3] == ["5", "1"]))
    with pytest.raises(ValueError, match=r"modes 5, 1 \(pitch, surge\).*missing at inf rad/s"):
        read_coefficients(path, RHO, G)

    files(tmp_path)
    dropped(path, lambda words: "6" not in words[1:3])
    dropped(tmp_path / "body.3", lambda words: words[2] != "6")
    found = read_coefficients(path, RHO, G)
    assert_near(found.damping[:, :5, :5], whole.damping[:, :5, :5])
    assert not found.added[:, 5].any() and not found.excitation[:, :, 5].any()

    dropped(tmp_path / "body.3", lambda words: words[1:3] != ["30", "3"] or not near(words))
    with pytest.raises(
        ValueError, match=r"body\.3: excitation of mode 3 \(heave\) at heading 30 degrees.*missing at 0.6"
    ):
        read_coefficients(path, RHO, G)

    dropped(tmp_path / "body.3", lambda words: words[1:3] != ["30", "3"])
    with pytest.raises(
        ValueError, match=r"body\.3: excitation of mode 3 \(heave\).*12 of 13 headings, missing at 30 degrees"
    ):
        read_coefficients(path, RHO, G)


@pytest.mark.parametrize(
    ("line", "words"),
    [
        ("2.0 3 3 1.0", "line 2 has no damping, at a period of 2 s"),
        ("2.0 3 3 1.0 nan", "line 2 has what is no finite number"),
    ],
)
def test_lines_of_wamits_files_that_cannot_be_kept_are_told(tmp_path, line, words):
    (tmp_path / "a.1").write_text(f"1.0 3 3 1.0 2.0\n{line}\n")
    with pytest.raises(ValueError, match=words):
        read_coefficients(tmp_path / "a.1", RHO, G)


def test_a_gzipped_file_that_is_cut_short_is_told(tmp_path):
    import gzip

    files(tmp_path)
    packed = gzip.compress((tmp_path / "body.3").read_bytes())
    (tmp_path / "body.3").unlink()
    (tmp_path / "body.3.gz").write_bytes(packed[: len(packed) // 2])
    with pytest.raises(ValueError, match=r"body\.3\.gz: cannot be unpacked"):
        read_coefficients(tmp_path / "body.1", RHO, G)


@pytest.mark.parametrize("ending", [".nc", ".h5"])
def test_a_gap_in_hdf_is_refused(written, tmp_path, ending):
    """A frequency that failed is left out; an element that failed at one frequency alone is told."""
    import shutil

    path = shutil.copy(written[ending], tmp_path)
    name = "radiation_damping" if ending == ".nc" else "body1/hydro_coeffs/radiation_damping/all"

    with h5py.File(path, "r+") as file:
        file[name][(5, 2, 2) if ending == ".nc" else (2, 2, 5)] = np.nan

    with pytest.raises(ValueError, match=r"modes 3, 3 \(heave, heave\): given at 39 of 40 frequencies"):
        read_coefficients(path, RHO, G)


@pytest.mark.parametrize("name", ["RadiationCoefficients.tec", "ExcitationForce.tec"])
def test_a_zone_of_nemoh_that_is_cut_short_is_told(written, tmp_path, name):
    import shutil

    for file in written[".tec"].parent.glob("*.tec"):
        shutil.copy(file, tmp_path)

    lines = (tmp_path / name).read_text().splitlines()
    (tmp_path / name).write_text("\n".join(lines[:-2]))
    with pytest.raises(ValueError, match=rf"{name}: zone .*given at 38 of 40 frequencies, missing at 3.9, 4"):
        read_coefficients(tmp_path / "RadiationCoefficients.tec", RHO, G)


def test_what_is_written_has_no_gaps(tmp_path):
    """An element that is zero at one frequency is written there, too."""
    from dataclasses import replace

    from mbdfmi.hydro.wamit import write_wamit

    found = read_coefficients(files(tmp_path), RHO, G)
    added, damping = found.added.copy(), found.damping.copy()
    added[7, 2, 2] = damping[7, 2, 2] = 0.0
    write_wamit(tmp_path / "again.1", replace(found, added=added, damping=damping), RHO, G)
    again = read_coefficients(tmp_path / "again.1", RHO, G)
    assert_near(again.damping, damping, 1e-7 * damping.max())


def test_damping_that_has_not_died_out_where_the_frequencies_end_is_told(tmp_path):
    path = tmp_path / "body.1"
    files(tmp_path)
    dropped(path, lambda words: float(words[0]) == 0.0 or 2 * np.pi / float(words[0]) < 0.5)
    _, notes = read_coefficients(path, RHO, G).checked()
    assert any(
        "the damping in heave is 100 % of its peak at the last frequency, 0.48 rad/s" in n for n in notes
    )


@pytest.mark.parametrize("off", [0.0, 1e-13, 1e-9, 1e-6, 1e-4])
def test_added_mass_at_a_frequency_of_the_integrals(tmp_path, off):
    """Those of evenly spaced files are among them: the integrand has a limit there, and the result is that of the modes."""
    kernel = Kernel(read_coefficients(files(tmp_path, waves=False), RHO, G))
    omega = np.array([(kernel.omega[k] + kernel.omega[k + 1]) / 2 * (1 + off) for k in (100, 350, 800)])
    wanted = response(omega).imag / omega[:, None, None]
    size = np.abs(wanted).max(axis=0)
    assert (np.abs(kernel.added(omega) - wanted) <= 5e-3 * size.max()).all()


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


def test_few_states_are_for_the_strongest_ways(monkeypatch):
    """Of a body whose waves couple sway, roll and yaw: passive, and better the more states, where Kung's poles of all
    three would leave nothing. What is missed is the largest error of H, the ways that are left out too.
    """
    coefficients, _ = read_coefficients(WATER / "body.1", 5.0, G).checked()
    samples = memories._sampled(Kernel(coefficients), coefficients.omega)
    monkeypatch.setattr(memories, "_sampled", lambda *_: samples)
    omega, H = samples[2:]
    scale = np.sqrt(coefficients.damping.diagonal(axis1=1, axis2=2).max(axis=0))
    missed = []

    for states in (2, 4, 6):
        memory = fit(coefficients, states=states)
        assert [n for _, n in memory.orders] == 3 * [states]
        found = memory.response(np.geomspace(1e-2, 100, 500)) / np.outer(scale, scale)
        assert np.linalg.eigvalsh(found + found.conj().transpose(0, 2, 1)).min() > -1e-5
        off = np.abs(memory.response(omega) - H) / np.outer(scale, scale)
        assert off.max() == pytest.approx(memory.error, rel=0.1)
        missed.append(memory.error)

    assert missed[0] < 0.7 and missed[1] < 0.4 and missed[2] < 0.03
