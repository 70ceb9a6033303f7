"""Bodies in potential flow that turn (`axes`): turned scenes, closed forms, sums by numpy, energy; what cannot be told is refused."""

from pathlib import Path

import numpy as np
import pytest
import test_two_bodies as two_bodies
from fmu_host import OK, Library
from fmu_host import Instance as Hosted
from scenes import assert_near, evaluate
from scipy.spatial.transform import Rotation
from test_hydrodynamics import INERTIA, INFINITE, MASS, SEA, G, afloat, database, exciting  # noqa: F401
from test_wave_loads import EXCITED, FULL

from mbdfmi import Scene, SceneError
from mbdfmi.compiler.model import compile_scene
from mbdfmi.hydro import spectra
from mbdfmi.run.instance import Instance
from mbdfmi.run.simulate import simulate

OUTPUTS = [
    "radiation_force", "radiation_moment", "excitation_force", "excitation_moment", "damping_force", "damping_moment",
]  # fmt: skip
WAVES = spectra.drawn(2.0, 8.0, 3.3, 40, "energy", 3, np.radians(30))


def turned_by(degrees, axes, database, position="mean", formulation="auto"):  # noqa: F811
    """A ship on springs, its berth, its start and the waves turned about the vertical by an angle; all of its water acts."""
    R = Rotation.from_euler("z", degrees, degrees=True)
    start = {
        "position": R.apply([3.0, -2.0, 0.4]).tolist(),
        "zyx_deg": [degrees + 12.0, 2.0, -3.0],
        "velocity": R.apply([0.8, -0.6, 0.2]).tolist(),
        "omega": R.apply([0.02, -0.03, 0.05]).tolist(),
    }
    sea = SEA | {"waves": SEA["waves"] | {"direction_deg": 30 + degrees}}
    size = np.array([1.0, 1, 1, 20, 20, 20])
    scene = afloat(
        database, start, sea, {"formulation": formulation}, OUTPUTS, axes=axes, position=position,
        damping=(1e4 * FULL * np.outer(size, size)).tolist(), quadratic=(3e4 * FULL * np.outer(size, size)).tolist(),
        reference=[3.0, -2.0, 1.0], radiation={"error": 0.05},
    )  # fmt: skip
    data = scene.model_dump(exclude_unset=True)
    data["ground"] = {"marker": {"berth": {"zyx_deg": [degrees, 0, 0]}}}
    data["force"]["hold"]["between"] = ["ground.berth", "hull"]
    return Scene.model_validate(data)


@pytest.mark.parametrize("position", ["mean", "now"])
@pytest.mark.parametrize("formulation", ["recursive", "embedding", "augmented"])
def test_a_turned_scene_moves_as_it_did_turned(database, position, formulation):  # noqa: F811
    """Nothing in it knows where north is: added mass, memory, damping, waves. With the first axes it does."""
    told = {}

    for axes in ("heading", "first"):
        for degrees in (0.0, 60.0):
            scene = turned_by(degrees, axes, database, position, formulation)
            run = simulate(compile_scene(scene), 12.0, 0.5)
            back = Rotation.from_euler("z", -degrees, degrees=True)
            vectors = ["hull.position", "hull.velocity", "hull.omega", *(f"water.{name}" for name in OUTPUTS)]
            told[axes, degrees] = {name: back.apply(run[name]) for name in vectors}

    for name, wanted in told["heading", 0.0].items():
        assert_near(told["heading", 60.0][name], wanted, 3e-6 * np.abs(wanted).max())

    off = told["first", 60.0]["hull.position"] - told["first", 0.0]["hull.position"]
    assert np.abs(off).max() > 0.1


def test_a_body_that_keeps_its_heading_is_as_before(database):  # noqa: F811
    """One that only heaves: both ways to sum the waves, to the error of the knots."""
    runs = []

    for axes in ("first", "heading"):
        data = afloat(database, None, SEA, outputs=OUTPUTS[:4], axes=axes).model_dump(exclude_unset=True)
        data["joint"]["free"] = {"prismatic": {"axis": "z"}, "between": ["ground", "hull"]}
        runs.append(simulate(compile_scene(Scene.model_validate(data)), 15.0, 0.5))

    for name in ("hull.position", *(f"water.{name}" for name in OUTPUTS[:4])):
        assert_near(runs[1][name], runs[0][name], 1e-6 * np.abs(runs[0][name]).max())


def on_a_turntable(database, turning, sea=None, **options):  # noqa: F811
    """The body 30 m from a post that it goes round at a constant rate (rad/s), its x axis outwards."""
    data = afloat(database, None, sea, **options).model_dump(exclude_unset=True)
    del data["force"]["hold"], data["force"]["lift"]
    data["body"]["hull"]["marker"] = {"post": {"position": [-30.0, 0, 0]}}
    data["joint"]["free"] = {
        "revolute": {"axis": "z"}, "between": ["ground", "hull.post"],
        "driver": {"constant_speed": turning},
    }  # fmt: skip
    return Scene.model_validate(data)


@pytest.mark.parametrize("position", ["mean", "now"])
def test_waves_meet_a_turning_body_at_their_direction_less_its_yaw(database, position):  # noqa: F811
    """F = R Re sum a X(omega, direction - yaw) e^(i (omega t + phase - k . p)): where the file has the direction, and between."""
    turning = np.radians(30) / 0.8
    scene = on_a_turntable(
        database, turning, SEA, radiation=False, outputs=EXCITED, axes="heading", position=position
    )
    run = simulate(compile_scene(scene), 16.0, 0.2)
    k = spectra.wave_number(WAVES.omega, 60, G)
    found = np.hstack([run["water.excitation_force"], run["water.excitation_moment"]])
    wanted = []

    for t in run["time"]:
        yaw = turning * t
        where = 30.0 * np.array([np.cos(yaw), np.sin(yaw)]) if position == "now" else np.array([30.0, 0.0])
        way = k * (where[0] * np.cos(WAVES.heading) + where[1] * np.sin(WAVES.heading))
        X = np.array([exciting(w, heading - yaw) for w, heading in zip(WAVES.omega, WAVES.heading)])
        F = (np.exp(1j * (WAVES.omega * t + WAVES.phase - way)) * WAVES.amplitude @ X).real
        R = Rotation.from_euler("z", yaw)
        wanted.append([*R.apply(F[:3]), *R.apply(F[3:])])

    off, size = np.abs(found - wanted), np.abs(wanted).max(axis=0)
    assert np.all(off[::4] < 1e-7 * size)
    # what 30 degrees between headings leave of waves once and twice round the circle
    assert np.all(off < np.array([1e-2] * 5 + [5e-2]) * size)


def test_a_sea_of_many_directions(database):  # noqa: F811
    """Each component by its own."""
    sea = {
        "waves": {
            "jonswap": {"hs": 2.0, "tp": 8.0, "components": 12, "seed": 3, "spread": 2, "directions": 5}
        }
    }
    turning = np.radians(30) / 0.8
    scene = on_a_turntable(database, turning, sea, radiation=False, outputs=EXCITED, axes="heading")
    run = simulate(compile_scene(scene), 4.0, 0.2)
    waves = spectra.drawn(2.0, 8.0, 3.3, 12, "energy", 3, 0.0, 2, 5)
    k = waves.omega**2 / G
    wanted = []

    for t in run["time"]:
        yaw = turning * t
        X = np.array([exciting(w, heading - yaw) for w, heading in zip(waves.omega, waves.heading)])
        way = 30.0 * k * np.cos(waves.heading)
        F = (np.exp(1j * (waves.omega * t + waves.phase - way)) * waves.amplitude @ X).real
        wanted.append(Rotation.from_euler("z", yaw).apply(F[:3]))

    assert np.all(np.abs(run["water.excitation_force"] - wanted) < 1e-2 * np.abs(wanted).max(axis=0))


def test_a_steady_turn_makes_no_waves_at_last(database):  # noqa: F811
    """In its own axes it moves as ever, which the memory, of no force at frequency 0, forgets; in those of the ground it swings."""
    last = {}

    for axes in ("first", "heading", "body"):
        scene = on_a_turntable(
            database, 0.5, outputs=["radiation_force"], axes=axes, radiation={"error": 0.02}
        )
        force = simulate(compile_scene(scene), 120.0, 1.0)["water.radiation_force"]
        last[axes] = np.linalg.norm(force[-5:], axis=1).max() / np.linalg.norm(force, axis=1).max()

    assert last["heading"] < 1e-6 and last["body"] < 1e-6
    assert last["first"] > 0.05


@pytest.mark.parametrize("axes", ["heading", "body"])
def test_munks_moment_and_energy(database, axes):  # noqa: F811
    """Yaw' = ((A11 - A22) u v) / (I + A66) at first; then it turns free in still water, and no energy goes."""
    u, v = 3.0, 1.5
    yaw = 40.0
    R = Rotation.from_euler("z", yaw, degrees=True)
    start = {"zyx_deg": [yaw, 0, 0], "velocity": R.apply([u, v, 0]).tolist()}
    scene = afloat(database, start, outputs=[], radiation=False, axes=axes)
    scene.force.pop("hold")
    instance = Instance(compile_scene(scene))
    evaluate(instance)
    A = INFINITE
    assert_near(instance.d.alpha[5], (A[0, 0] - A[1, 1]) * u * v / (INERTIA[2] + A[5, 5]), 1e-12)

    data = scene.model_dump(exclude_unset=True)
    data["joint"]["free"]["start"] |= {"omega": [0, 0, 0.3]}
    run = simulate(compile_scene(Scene.model_validate(data)), 60.0, 1.0)
    energy = run["total_energy"] - MASS * G * run["hull.position"][:, 2]
    assert np.ptp(run["hull.omega"][:, 2]) > 1e-4
    assert np.ptp(energy) < 1e-8 * abs(energy[0])


def test_what_waves_take_from_a_turning_ship(database):  # noqa: F811
    """Energy goes by the memory alone, and never more comes back than went: it is passive in its own axes."""
    start = {"velocity": [2.0, 1.0, 0.5], "omega": [0.02, 0.03, 0.4]}
    scene = afloat(database, start, outputs=["radiation_power"], axes="heading", radiation={"error": 0.02})
    run = simulate(compile_scene(scene), 40.0, 0.02)
    power = run["water.radiation_power"]
    work = np.concatenate([[0.0], np.cumsum((power[1:] + power[:-1]) * 0.01)])
    gained = run["total_energy"] - MASS * G * run["hull.position"][:, 2]
    gained -= gained[0]
    assert_near(work, gained, 1e-3 * np.abs(gained).max())
    assert work.max() <= 1e-6 * np.abs(work).max() and work[-1] < -1e5


def refused(scene):
    with pytest.raises(SceneError) as caught:
        compile_scene(scene)
    return str(caught.value)


def test_what_cannot_turn_is_refused(database, tmp_path):  # noqa: F811
    text = refused(afloat(database, None, SEA, axes="body"))
    assert "water" in text and 'axes = "body"' in text and 'axes = "heading"' in text
    compile_scene(afloat(database, None, SEA, outputs=[], axes="body", excitation=False))
    compile_scene(afloat(database, None, None, outputs=[], axes="body", excitation="input"))

    two = two_bodies.afloat(str(two_bodies.as_wamit(tmp_path)), outputs=[], radiation=False, axes="heading")
    assert "the file holds 2" in refused(two)

    lines = Path(database).with_suffix(".3").read_text().splitlines()
    half = tmp_path / "half.1"
    half.write_text(Path(database).read_text())
    half.with_suffix(".3").write_text("\n".join(line for line in lines if float(line.split()[1]) >= 0.0))
    scene = afloat(str(half), None, SEA, radiation=False, outputs=[], axes="heading")
    text = refused(scene)
    assert "from 0 to 180 degrees" in text and "--heading 0:330:30" in text


def test_fmus_of_ships_that_turn(database, tmp_path):  # noqa: F811
    """As in process, to the last bit; their derivatives, of which no trace is made, by differences."""
    scene = turned_by(10.0, "heading", database)
    fmu = Hosted(Library(scene.export(tmp_path / "ship.fmu"), tmp_path / "ship")).start()
    instance = Instance(compile_scene(scene))

    for k in range(8):
        assert fmu.step(0.25 * k, 0.25) == OK
        instance.step(0.25)
        assert np.array_equal(fmu.outputs(), instance.outputs())

    fmu.free()
