"""`mbdfmi hydro`: meshes made ready, a hemisphere beside Hulme's series, what is kept, written, read, refused."""

import numpy as np
import pytest
import trimesh
from scenes import assert_near

from mbdfmi.cli import main
from mbdfmi.hydro import panels
from mbdfmi.hydro.panels import Problem, panel_edge, solve, wet_part
from mbdfmi.hydro.reading import read_coefficients
from mbdfmi.hydro.writing import write_coefficients

RHO, G = 1000.0, 9.81


def box(path, holes=(), inside_out=False):
    """4 x 4 x 2 m, 1 m under water."""
    mesh = trimesh.creation.box([4, 4, 2])
    mesh.update_faces(~np.isin(np.arange(len(mesh.faces)), holes))
    if inside_out:
        mesh.invert()
    mesh.export(path)
    return path


@pytest.mark.parametrize("inside_out", [False, True])
def test_what_is_under_water_of_a_box(tmp_path, inside_out):
    wet = wet_part(box(tmp_path / "box.stl", inside_out=inside_out))
    assert_near([wet.volume, wet.waterplane], [16.0, 16.0], 1e-12)
    assert_near(wet.center, [0, 0, -0.5], 1e-12)
    assert wet.vertices[:, 2].max() == 0.0
    fine = wet.finer(0.7)
    assert fine.edge <= 0.7 and len(fine.faces) > 100


def test_meshes_that_are_no_hulls_are_told(tmp_path):
    normals = trimesh.creation.box([4, 4, 2]).face_normals
    bottom = int(np.flatnonzero(normals[:, 2] < -0.5)[0])
    with pytest.raises(ValueError, match=r"box.stl: has a hole under water, 3 edges"):
        wet_part(box(tmp_path / "box.stl", [bottom]))
    # without its deck it is a hull still
    deck = np.flatnonzero(normals[:, 2] > 0.5)
    assert_near(wet_part(box(tmp_path / "open.stl", deck)).volume, 16.0, 1e-12)
    high = trimesh.creation.box([1, 1, 1])
    high.apply_translation([0, 0, 3])
    high.export(tmp_path / "high.stl")
    with pytest.raises(ValueError, match=r"high.stl: is all above z = 0"):
        wet_part(tmp_path / "high.stl")
    (tmp_path / "odd.stl").write_text("nothing")
    with pytest.raises(ValueError, match=r"odd.stl"):
        wet_part(tmp_path / "odd.stl")


def test_panels_are_an_eighth_of_the_shortest_wave():
    assert_near(panel_edge(np.array([1.0, 2.0]), None, G), 2 * np.pi * G / 4 / 8, 1e-12)


@pytest.fixture(scope="module")
def hemisphere(tmp_path_factory):
    """(omega, coefficients) of a ball of 1 m, half in water."""
    pytest.importorskip("capytaine")
    path = tmp_path_factory.mktemp("hemisphere") / "ball.stl"
    trimesh.creation.icosphere(subdivisions=3, radius=1.0).export(path)
    omega = np.sqrt(G * np.array([0.3, 0.5, 1.0, 2.0]))
    wet = wet_part(path)
    return wet, solve(wet, Problem(omega, np.array([0.0, np.pi / 2]), RHO, G))


def test_a_hemisphere_heaves_as_hulme_says(hemisphere):
    """A. Hulme (1982): added mass and damping by 2/3 pi rho a^3 (omega) at k a = 0.3, 0.5, 1, 2; by the volume of the 656 panels."""
    wet, found = hemisphere
    displaced = RHO * wet.volume
    assert_near(found.added[:, 2, 2] / displaced, [0.7157, 0.5861, 0.4284, 0.3884], 0.03)
    assert_near(found.damping[:, 2, 2] / displaced / found.omega, [0.3254, 0.3391, 0.2484, 0.1031], 0.01)


def test_haskind_ties_damping_to_the_loads_of_waves(hemisphere):
    """B = omega^3 / (2 rho g^3) |X|^2 for a body of revolution in heave, k / (4 rho g c) in all."""
    _, found = hemisphere
    X = np.abs(found.excitation[:, 0, 2])
    assert_near(found.omega**3 / (2 * RHO * G**3) * X**2 / found.damping[:, 2, 2], 1.0, 0.03)
    checked, notes = found.checked()
    # four frequencies end before damping dies out
    assert all("at the last frequency" in note for note in notes)
    assert checked.excitation.shape == (4, 2, 6)


def test_what_was_solved_is_kept(hemisphere, monkeypatch):
    wet, found = hemisphere
    monkeypatch.setattr(panels, "_solved", lambda *arguments: pytest.fail("solved again"))
    again = solve(wet, Problem(found.omega[1:3], found.headings, RHO, G))
    assert np.array_equal(again.added, found.added[1:3])


@pytest.mark.parametrize("ending", [".1", ".nc"])
def test_files_are_read_as_they_were(hemisphere, tmp_path, ending):
    _, found = hemisphere
    write_coefficients(tmp_path / f"ball{ending}", found, RHO, G)
    again = read_coefficients(tmp_path / f"ball{ending}", RHO, G)

    for name in ("omega", "added", "damping", "wave_omega", "headings", "excitation"):
        ours, theirs = getattr(found, name), getattr(again, name)
        assert np.abs(ours - theirs).max() < 1e-6 * np.abs(ours).max(), name


def test_the_command_tells_and_draws_what_a_file_holds(hemisphere, tmp_path, capsys):
    pytest.importorskip("matplotlib")
    _, found = hemisphere
    write_coefficients(tmp_path / "ball.1", found, RHO, G)
    assert (
        main(["hydro", str(tmp_path / "ball.1"), "--density", "1000", "--plot", str(tmp_path / "ball.png")])
        == 0
    )
    told = capsys.readouterr().out
    assert "heave" in told and "4 frequencies" in told and (tmp_path / "ball.png").stat().st_size > 20_000


@pytest.mark.parametrize(
    "more, words",
    [
        (["-o", "ball.dat"], "is to end in .1 or .nc"),
        ([], "name a file for the coefficients"),
        (["-o", "ball.1", "--omega", "1:2"], "write FIRST:LAST:NUMBER"),
        (["-o", "ball.1", "--omega", "0,1,2,3"], "at least 4 frequencies above 0"),
        (["-o", "ball.1", "--heading", "0:10:0"], "write FIRST:LAST:STEP"),
        (["-o", "ball.1", "--depth", "0.5"], "reaches down to 1 m"),
        (["-o", "ball.1", "--reference", "1,2"], "write X,Y,Z"),
    ],
)
def test_what_is_asked_wrongly_is_told(tmp_path, capsys, monkeypatch, more, words):
    monkeypatch.chdir(tmp_path)
    trimesh.creation.icosphere(subdivisions=1, radius=1.0).export("ball.stl")
    assert main(["hydro", "ball.stl", *more]) == 1
    assert words in " ".join(capsys.readouterr().err.split())
