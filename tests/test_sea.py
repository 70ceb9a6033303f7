"""The waves of a sea: moments, directions, files, dispersion; what `mbdfmi sea` writes."""

import numpy as np
import pytest
from scenes import assert_near
from scipy.integrate import trapezoid

import mbdfmi
from mbdfmi import Scene, SceneError
from mbdfmi.cli import main
from mbdfmi.compiler.model import compile_scene, with_values
from mbdfmi.compiler.seas import sea_components
from mbdfmi.hydro import spectra
from mbdfmi.run.simulate import simulate
from mbdfmi.view.told import waves

G = 9.80665


def moments(waves):
    """m0, m1, m2."""
    return [waves.amplitude**2 / 2 @ waves.omega**k for k in range(3)]


@pytest.mark.parametrize("spacing", ["energy", "frequency"])
@pytest.mark.parametrize("gamma", [1.0, 3.3])
def test_a_drawn_sea_has_the_moments_of_its_spectrum(spacing, gamma):
    """m0 is hs^2 / 16; m1 is kept by centroids; Pierson and Moskowitz: T1 = 0.7718 Tp, T2 = 0.7104 Tp with all of the tail."""
    waves = spectra.drawn(3.0, 9.0, gamma, 400, spacing, 1, 0.3)
    m0, m1, m2 = moments(waves)
    assert_near(m0, 9 / 16, 1e-14)
    grid = 2 * np.pi / 9 * np.linspace(*spectra.BAND, 400_001)
    density = spectra.shape(grid, 2 * np.pi / 9, gamma)
    assert_near(m1 / m0, trapezoid(density * grid, grid) / trapezoid(density, grid), 1e-6)

    if gamma == 1.0:
        assert_near(2 * np.pi * m0 / m1 / 9.0, 0.7718, 5e-3)
        assert_near(2 * np.pi * np.sqrt(m0 / m2) / 9.0, 0.7104, 2e-2)

    assert_near(waves.heading, 0.3)


def test_equal_seeds_draw_equal_seas():
    first, again, other = (spectra.drawn(2, 8, 3.3, 50, "energy", seed, 0.0) for seed in (4, 4, 5))
    assert np.array_equal(first.phase, again.phase) and not np.array_equal(first.phase, other.phase)
    assert np.array_equal(first.amplitude, other.amplitude)


def test_a_spread_sea_has_its_directions():
    """cos^(2 s) of half the angle: the mean of cos(theta) is s / (s + 1); no two directions at one frequency."""
    waves = spectra.drawn(2, 8, 3.3, 990, "energy", 1, 0.5, spread=10, directions=33)
    assert_near(np.mean(np.cos(waves.heading - 0.5)), 10 / 11, 0.003)
    assert_near(np.mean(np.sin(waves.heading - 0.5)), 0.0, 1e-6)
    assert len(np.unique(waves.heading)) == 33 and len(np.unique(waves.omega)) == 990


@pytest.mark.parametrize("n", [64, 65])
def test_a_series_comes_back(n):
    rng = np.random.default_rng(1)
    time = 5.0 + 0.25 * np.arange(n)
    elevation = rng.normal(size=n)
    waves = spectra.of_series(time, elevation, 0.0)
    again = sum(a * np.cos(w * time + e) for w, a, e in zip(waves.omega, waves.amplitude, waves.phase))
    assert_near(again, elevation - elevation.mean(), 1e-12)


def test_dispersion():
    omega = np.geomspace(0.01, 20, 50)

    for depth in (0.5, 20.0, 4000.0):
        k = spectra.wave_number(omega, depth, G)
        assert_near(G * k * np.tanh(k * depth) / omega**2, 1.0, 1e-12)

    assert_near(spectra.wave_number(omega, None, G), omega**2 / G, 1e-15)


def scene(folder, waves):
    (folder / "scene.toml").write_text(
        f"""name = "sea"
body.a = {{ mass = 1, inertia = [1, 1, 1] }}
joint.f = {{ free = {{}}, between = ["ground", "a"] }}
sea = {{ waves = {waves}, output = ["elevation"] }}
"""
    )
    return str(folder / "scene.toml")


def test_another_scene_sails_the_same_sea(tmp_path, capsys):
    """By its components, and, where it is periodic, by its series."""
    first = scene(tmp_path, "{ jonswap = { hs = 2, tp = 8, components = 30 }, direction_deg = 40 }")
    assert (
        main(["sea", first, "--components", str(tmp_path / "c.csv"), "--series", str(tmp_path / "s.csv")])
        == 0
    )
    told = capsys.readouterr().out
    assert "significant height, m" in told and " 2\n" in told.replace(" \n", "\n") and "40" in told
    drawn = sea_components(mbdfmi.load(first))
    again = sea_components(mbdfmi.load(scene(tmp_path, '{ components = { file = "c.csv" } }')))
    assert all(np.array_equal(a, b) for a, b in zip(drawn, again))
    read = sea_components(mbdfmi.load(scene(tmp_path, '{ series = { file = "s.csv" }, direction_deg = 40 }')))
    time = np.arange(50) * 0.1
    elevation = lambda w: sum(a * np.cos(o * time + e) for o, a, e in zip(w.omega, w.amplitude, w.phase))
    mean = np.loadtxt(tmp_path / "s.csv", delimiter=",", skiprows=1)[:, 1].mean()
    assert_near(elevation(read), elevation(drawn) - mean, 1e-9)


def test_files_that_are_no_sea_are_told(tmp_path, capsys):
    (tmp_path / "c.csv").write_text("a,b,c,d\n0.5,1,0,0\n0.6,1,x,0\n")
    assert main(["sea", scene(tmp_path, '{ components = { file = "c.csv" } }')]) == 1
    assert "line 3 is no row of numbers" in capsys.readouterr().err
    (tmp_path / "c.csv").write_text("1,1,0,0\n0.8,1,0,0\n")
    assert main(["sea", scene(tmp_path, '{ components = { file = "c.csv" } }')]) == 1
    assert "line 1 is of numbers, '1,1,0,0'" in capsys.readouterr().err.replace("\n", " ")
    (tmp_path / "s.csv").write_text("t,e\n0,1\n1,2\n3,1\n")
    assert main(["sea", scene(tmp_path, '{ series = { file = "s.csv" } }')]) == 1
    assert "evenly spaced" in capsys.readouterr().err


def test_a_page_is_told_the_waves(tmp_path):
    """Its rows make the elevation of the components anywhere; no waves, none."""
    made = mbdfmi.load(
        scene(tmp_path, "{ jonswap = { hs = 2, tp = 8, components = 30 }, direction_deg = 40 }")
    )
    a, omega, phase, kx, ky = np.array(waves(made)).T
    drawn, x, y, t = sea_components(made), 30.0, -12.0, 7.0
    k = spectra.wave_number(drawn.omega, None, 9.81)
    way = k * (np.cos(drawn.heading) * x + np.sin(drawn.heading) * y)
    wanted = drawn.amplitude @ np.cos(drawn.omega * t + drawn.phase - way)
    assert_near(a @ np.cos(omega * t + phase - kx * x - ky * y), wanted, 1e-4)
    made.sea.output = []
    made.sea.waves = None
    assert waves(made) is None


def test_a_page_of_a_run_shows_the_sea_that_it_had(tmp_path):
    """Parameters of the sea set for a run: the components of a scene of these values."""
    made = mbdfmi.load(
        scene(tmp_path, "{ jonswap = { hs = 2, tp = 8, components = 9 }, direction_deg = 40 }")
    )
    other = mbdfmi.load(
        scene(tmp_path, "{ jonswap = { hs = 3, tp = 6, components = 9, seed = 7 }, direction_deg = 30 }")
    )
    sea = {"sea.hs": 3.0, "sea.tp": 6.0, "sea.seed": 7.0, "sea.direction": np.radians(30.0)}
    run = made.simulate(0.2, 0.1, parameters=sea)
    assert waves(made, run.states) == waves(other) != waves(made)


def noted(folder, waves, sea=""):
    """What is told of a scene with these waves."""
    path = scene(folder, waves)
    text = (folder / "scene.toml").read_text().replace("sea = {", f"sea = {{ {sea}")
    (folder / "scene.toml").write_text(text)
    return " ".join(compile_scene(mbdfmi.load(path)).notices)


def test_waves_that_break_are_told(tmp_path):
    """Miche's limit, deep and shallow; a sea by DNV's; what is no steeper is not."""
    limit = 0.142 * 2 * np.pi * 9.81 / (2 * np.pi / 8) ** 2
    for factor in (0.98, 1.02):
        told = noted(tmp_path, f"{{ regular = {{ height = {limit * factor}, period = 8 }} }}")
        assert ("Miche" in told) == (factor > 1)

    # in 3 m of water 8 s waves are 42.5 m long
    k = float(spectra.wave_number(np.array([2 * np.pi / 8]), 3.0, 9.81)[0])
    limit = 0.142 * 2 * np.pi / k * np.tanh(3 * k)
    for factor in (0.98, 1.02):
        told = noted(tmp_path, f"{{ regular = {{ height = {limit * factor}, period = 8 }} }}", "depth = 3, ")
        assert ("Miche" in told) == (factor > 1)

    assert noted(tmp_path, "{ jonswap = { hs = 6, tp = 8 } }") == ""
    assert "steeper than seas get" in noted(tmp_path, "{ jonswap = { hs = 7, tp = 8 } }")
    (tmp_path / "c.csv").write_text("omega,amplitude,phase,direction\n0.785,15,0,0\n")
    assert "Miche" in noted(tmp_path, '{ components = { file = "c.csv" } }')


@pytest.mark.parametrize("depth", [3, 5])
def test_a_hull_that_starts_under_the_bed_is_told(depth):
    box = {
        "name": "box",
        "sea": {"depth": depth},
        "body": {"hull": {"mass": 8e5, "inertia": [1e7, 3e7, 3e7]}},
        "joint": {"float": {"free": {}, "between": ["ground", "hull"]}},
        "force": {"lift": {"hydrostatics": {"box": {"size": [20, 10, 8]}}, "on": "hull"}},
        "gravity": [0, 0, -9.81],
    }
    told = " ".join(compile_scene(mbdfmi.Scene.model_validate(box)).notices)
    assert ("reaches 4 m down where it starts; the water is 3 m deep" in told) == (depth == 3)


# any spectrum


TABLE = [(0.4, 0.0), (0.6, 1.5), (0.75, 4.0), (0.9, 1.0), (1.3, 1.6), (2.2, 0.0)]


def of_file(folder, **options):
    (folder / "spectrum.csv").write_text("\n".join(["omega,energy", *(f"{w},{e}" for w, e in TABLE)]))
    waves = {"spectrum": {"file": str(folder / "spectrum.csv")} | options}
    body = {"buoy": {"mass": 1.0, "inertia": [1, 1, 1]}}
    joint = {"free": {"free": {}, "between": ["ground", "buoy"]}}
    return Scene.model_validate(
        {
            "name": "sea",
            "gravity": [0, 0, -9.81],
            "sea": {"waves": waves, "output": ["elevation"]},
            "body": body,
            "joint": joint,
        }
    )


@pytest.mark.parametrize("spacing", ["energy", "frequency"])
def test_a_sea_of_any_spectrum_has_its_moments(tmp_path, spacing):
    """m0 to rounding, m1 too, as each component is at the centroid of its band; no energy outside the table."""
    waves = sea_components(of_file(tmp_path, spacing=spacing, components=150))
    w, e = np.array(TABLE).T
    fine = np.linspace(w[0], w[-1], 400_001)
    density = np.interp(fine, w, e)
    energy = waves.amplitude**2 / 2
    assert_near(energy.sum(), np.trapezoid(e, w), 1e-14)
    assert_near(energy @ waves.omega, np.trapezoid(density * fine, fine), 1e-8)
    assert waves.omega.min() > 0.4 and waves.omega.max() < 2.2

    if spacing == "energy":
        assert np.ptp(energy) < 1e-6 * energy.max()
    else:
        # in bands of equal width it is the table again
        width = 1.8 / 150
        assert np.abs(energy / width - np.interp(waves.omega, w, e)).max() < 0.05


def test_its_height_period_and_seed_are_parameters(tmp_path):
    """Twice as high and half as long again, with other phases: as if the table had been written so."""
    scene = of_file(tmp_path, components=60, spread=3.0)
    model = compile_scene(scene)
    starts = {v.name: v.start for v in model.of_causality("parameter") if v.name.startswith("sea.")}
    w, e = np.array(TABLE).T
    assert_near(starts["sea.hs"], 4 * np.sqrt(np.trapezoid(e, w)), 1e-12)
    assert_near(starts["sea.tp"], 2 * np.pi / 0.75, 1e-12)
    given = {"sea.hs": 2 * starts["sea.hs"], "sea.tp": 1.5 * starts["sea.tp"], "sea.seed": 9}
    run = simulate(with_values(model, given), 20.0, 0.5)
    waves = sea_components(scene, given)
    plain = sea_components(scene)
    assert_near(waves.omega, plain.omega / 1.5, 1e-12)
    assert_near(np.sum(waves.amplitude**2), 4 * np.sum(plain.amplitude**2), 1e-12)
    wanted = np.cos(np.outer(run["time"], waves.omega) + waves.phase) @ waves.amplitude
    assert_near(run["sea.elevation"], wanted, 1e-9)


@pytest.mark.parametrize(
    "rows, told",
    [
        (["0.0,1.0", "1.0,1.0"], "needs frequencies (rad/s) above 0, ascending"),
        (["1.0,1.0", "0.5,1.0"], "above 0, ascending"),
        (["0.5,1.0", "1.0,-1.0"], "not negative, and not all 0"),
        (["0.5,0.0", "1.0,0.0"], "not all 0"),
        (["0.5,1.0,3.0", "1.0,0.0,3.0"], "needs 2 finite numbers"),
    ],
)
def test_a_spectrum_that_is_none_is_refused(tmp_path, rows, told):
    scene = of_file(tmp_path)
    (tmp_path / "spectrum.csv").write_text("\n".join(["omega,energy", *rows]))

    with pytest.raises(SceneError) as caught:
        compile_scene(scene)

    assert told in str(caught.value) and "[sea] waves.spectrum.file" in str(caught.value)
