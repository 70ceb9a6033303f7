"""Whether coefficients go together: Haskind's relation, phases of long waves, spikes."""

from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest
import test_two_bodies as two_bodies
from scenes import assert_near
from test_hydrodynamics import afloat, files

from mbdfmi.compiler.model import compile_scene
from mbdfmi.hydro import consistency
from mbdfmi.hydro.consistency import disagreements, spikes, told_spikes, without_spikes
from mbdfmi.hydro.reading import read_coefficients

MODELS = Path(__file__).parents[1] / "models"
FILES = {
    "barge": (MODELS / "floating_wind_turbine" / "barge.1", 150.0),
    "crane": (MODELS / "offshore_crane" / "barge.1", None),
    "ship": (MODELS / "ship_crane" / "ship.1", None),
}
WATER = 1025.0, 9.80665


def coefficients(name, scale=1.0):
    return read_coefficients(FILES[name][0], *WATER, scale).checked()[0]


@pytest.mark.parametrize("name", FILES)
def test_waves_made_and_waves_felt_are_of_one_potential(name, monkeypatch):
    """Newman's 6.173 on what capytaine found by radiation and by diffraction: nothing is told, and but for heave 5 % are kept."""
    data = coefficients(name)
    assert disagreements(data, *WATER, FILES[name][1]) == []
    monkeypatch.setattr(consistency, "HASKIND", 0.05)
    assert all("heave" in note for note in disagreements(data, *WATER, FILES[name][1]))


def test_other_units_and_phases_are_told():
    """WAMIT's numbers by another length: damping grows by its third power, loads by their square. Conjugate ones are of exp(-i omega t)."""
    told = disagreements(coefficients("ship", 1.3), *WATER, None)
    assert told and "damping in heave and the loads of waves disagree by" in told[0]
    assert "Haskind's relation, in deep water" in told[0]

    data = coefficients("ship")
    (late,) = disagreements(replace(data, excitation=data.excitation.conj()), *WATER, None)
    assert "a quarter of a period after the crest" in late


def test_files_that_do_not_tell_enough_are_not_judged():
    data = coefficients("ship", 1.3)
    half = data.headings < np.pi - 0.1
    assert (
        disagreements(
            replace(data, headings=data.headings[half], excitation=data.excitation[:, half]), *WATER, None
        )
        == []
    )
    assert disagreements(replace(data, excitation=None), *WATER, None) == []


def spoiled(data, k, i=2, size=0.6):
    """One frequency at which added mass falls and damping rises."""
    added, damping = data.added.copy(), data.damping.copy()
    added[k, i, i] -= size * np.ptp(added[:, i, i])
    damping[k, i, i] += size * np.ptp(damping[:, i, i])
    return replace(data, added=added, damping=damping)


@pytest.mark.parametrize("name", FILES)
def test_a_spike_is_found_and_cut_out(name):
    data = coefficients(name)
    assert spikes(data) == [] and told_spikes(data) == []
    k = len(data.omega) // 2
    bad = spoiled(data, k)
    assert (k, 2) in spikes(bad)
    assert any(f"heave jumps at {data.omega[k]:.4g} rad/s" in note for note in told_spikes(bad))
    cut, notes = without_spikes(bad)
    assert_near(cut.omega, np.delete(data.omega, k))
    assert_near(cut.damping, np.delete(data.damping, k, axis=0))
    assert len(cut.wave_omega) == len(data.wave_omega) - 1 and notes == [
        f"cut out at {data.omega[k]:.4g} rad/s: heave"
    ]
    assert without_spikes(data) == (data, [])


def test_two_frequencies_wide_is_found_too():
    data = coefficients("barge")
    k = len(data.omega) // 2
    bad = spoiled(spoiled(data, k), k + 1)
    cut, _ = without_spikes(bad)
    assert set(data.omega[[k, k + 1]]).isdisjoint(cut.omega) and len(cut.omega) >= len(data.omega) - 4


def test_a_scene_tells_them_or_leaves_them_out(tmp_path):
    file = files(tmp_path)
    lines = Path(file).read_text().splitlines()
    periods = sorted({float(line.split()[0]) for line in lines})
    bad = periods[len(periods) // 2]

    for n, line in enumerate(lines):
        period, i, j, added, *damping = line.split()
        if float(period) == bad and i == j == "3":
            lines[n] = f"{period} 3 3 {float(added) - 2e3} {float(damping[0]) + 2e3}"

    Path(file).write_text("\n".join(lines))
    kept = " ".join(compile_scene(afloat(file, outputs=[], radiation={"states": 8})).notices)
    assert "heave jumps at" in kept and 'spikes = "cut" leaves it out' in kept
    cut = " ".join(compile_scene(afloat(file, outputs=[], radiation={"states": 8}, spikes="cut")).notices)
    assert "cut out at" in cut and "jumps" not in cut


def late(notes):
    return [note for note in notes if "a quarter of a period after the crest" in note]


def test_loads_of_several_bodies_that_come_too_late_are_told(tmp_path):
    """Each by the phase at its own place: half a wave further the crest comes half a period later, which is no fault."""
    file = two_bodies.as_wamit(tmp_path)
    data = read_coefficients(file, 1025.0, 9.80665, 1.0).checked()[0]
    places = [place[:2] for place in two_bodies.PLACES]
    assert not late(disagreements(data, *WATER, None, places))
    conjugate = data.excitation.conj()
    (text,) = late(disagreements(replace(data, excitation=conjugate), *WATER, None, places))
    assert "surge of body 1, surge of body 2" in text
    conjugate[:, :, :6] = data.excitation[:, :, :6]
    (text,) = late(disagreements(replace(data, excitation=conjugate), *WATER, None, places))
    assert "in surge of body 2 comes" in text
    short = data.wave_omega > 0.9
    begins = replace(data, wave_omega=data.wave_omega[short], excitation=data.excitation[short])
    assert not late(disagreements(begins, *WATER, None, places))
    assert late(disagreements(begins, *WATER, None, [(place[0] + 38.0, 0.0) for place in places]))

    # in a scene, of both and of one that is taken out
    lines = [line.split() for line in file.with_suffix(".3").read_text().splitlines()]
    turned = "\n".join(" ".join([*line[:6], f"{-float(line[6])!r}"]) for line in lines)
    file.with_suffix(".3").write_text(turned)
    assert late(compile_scene(two_bodies.afloat(str(file), outputs=[], radiation=False)).notices)
