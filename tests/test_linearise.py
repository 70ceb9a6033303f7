"""Linear models and modes against closed forms, published digits and runs."""

import importlib.util

import numpy as np
import pytest
import scipy
from test_floating_wind_turbine import adrift

import mbdfmi
from mbdfmi import Scene
from mbdfmi.analysis.linear import about
from mbdfmi.analysis.locus import locus
from mbdfmi.analysis.manifold import Manifold
from mbdfmi.analysis.places import state_at

# Meijaard, Papadopoulos, Ruina, Schwab, Proc. R. Soc. A 463 (2007), table 2 of the benchmark bicycle: forward speed (m/s) and
# eigenvalues (1/s)
BICYCLE = {
    0: [-5.53094371765393, -3.13164324790656, 3.13164324790656, 5.53094371765393],
    1: [3.52696170990070 + 0.80774027519930j, -3.13423125066578, -7.11008014637442],
    2: [2.68234517512745 + 1.68066296590675j, -3.07158645641514, -8.67387984831735],
    3: [1.70675605663975 + 2.31582447384325j, -2.63366137253667, -10.35101467245920],
    4: [0.41325331521125 + 3.07910818603206j, -1.42944427361326, -12.15861426576447],
    5: [-0.77534188219585 + 4.46486771378823j, -0.32286642900409, -14.07838969279822],
    6: [-1.52644486584142 + 5.87673060598709j, -0.00406690076970, -16.08537123098026],
    7: [-2.13875644258362 + 7.19525913329805j, 0.10268170574766, -18.15788466125262],
    8: [-2.69348683581097 + 8.46037971396931j, 0.14327879765713, -20.27940894394569],
    9: [-3.21675402252485 + 9.69377351531791j, 0.15790184030917, -22.43788559040858],
    10: [-3.72016840437287 + 10.90681139476287j, 0.16105338653172, -24.62459635017404],
}


def bicycle(speed):
    """The benchmark bicycle, straight ahead at a speed (m/s)."""
    scene = mbdfmi.load(mbdfmi.__path__[0] + "/../models/bicycle.toml")
    scene.joint["frame"].start = {"velocity": [speed, 0, 0]}
    return scene


def own_values(scene, **options):
    """Eigenvalues of the modes, one of each pair."""
    return np.array([mode.eigenvalue for mode in scene.linearise([], [], **options).modes()])


@pytest.mark.parametrize("speed", BICYCLE)
def test_a_bicycle_has_the_published_eigenvalues(speed):
    found = np.sort_complex(own_values(bicycle(speed), at="start"))
    assert np.abs(found - np.sort_complex(BICYCLE[speed])).max() < 1e-9


def real_at(eigenvalue, low, high):
    """The speed at which the real part of an eigenvalue of the bicycle is zero."""
    return scipy.optimize.brentq(
        lambda v: eigenvalue(own_values(bicycle(v), at="start")), low, high, xtol=1e-11
    )


def test_a_bicycle_is_stable_from_the_weave_to_the_capsize_speed():
    assert abs(real_at(lambda all_: max(all_, key=lambda v: v.imag).real, 4.2, 4.4) - 4.29238253634111) < 1e-8
    assert abs(real_at(lambda all_: max(v.real for v in all_), 6.0, 6.1) - 6.02426201538837) < 1e-8


QUARTER_CARS = [
    (400.0, 50.0, 25e3, 250e3, ["1.1990", "11.81"]),
    (320.0, 40.0, 20e3, 200e3, ["1.1990", "11.81"]),
    (290.0, 59.0, 16812.0, 190e3, None),
]


@pytest.mark.parametrize("body, wheel, soft, hard, told", QUARTER_CARS)
def test_modes_of_a_quarter_car(body, wheel, soft, hard, told):
    """Body and wheel (kg) on strut and tyre (N/m). told : Hz to their digits: those of every car with wheel : body = 1 : 8,
    strut : tyre = 1 : 10 and 62.5 N/m of strut for a kilogram of body.
    """
    rail = {"prismatic": {"axis": "z"}}
    scene = Scene(
        name="quarter_car",
        body={"wheel": {"mass": wheel, "inertia": [0, 0, 0]}, "car": {"mass": body, "inertia": [0, 0, 0]}},
        joint={
            "tyre": rail | {"between": ["ground", "wheel"], "spring": {"stiffness": hard}},
            "strut": rail | {"between": ["wheel", "car"], "spring": {"stiffness": soft}},
        },
    )
    M = np.diag([wheel, body])
    K = np.array([[hard + soft, -soft], [-soft, soft]])
    right = np.sqrt(scipy.linalg.eigvalsh(K, M)) / (2 * np.pi)
    modes = scene.linearise().modes()
    assert np.abs(modes.frequencies / right - 1).max() < 1e-12
    assert modes[0].bodies["car"] > 0.99 and modes[1].bodies["wheel"] > 0.99

    if told:
        assert [f"{modes.frequencies[0]:.4f}", f"{modes.frequencies[1]:.2f}"] == told


def test_a_rotor_whirls_as_gyroscopic_moments_have_it():
    polar, across, stiffness, spin = 0.5, 0.3, 700.0, 120.0
    hinge = {"spring": {"stiffness": stiffness}}
    scene = Scene(
        name="rotor",
        gravity=[0, 0, 0],
        body={
            "outer": {"mass": 0.0},
            "inner": {"mass": 0.0},
            "disk": {"mass": 1.0, "inertia": [across, across, polar]},
        },
        joint={
            "x": hinge | {"revolute": {"axis": "x"}, "between": ["ground", "outer"]},
            "y": hinge | {"revolute": {"axis": "y"}, "between": ["outer", "inner"]},
            "spin": {"revolute": {"axis": "z"}, "between": ["inner", "disk"], "start": {"speed": spin}},
        },
    )
    half = polar * spin / (2 * across)
    right = np.sqrt(half**2 + stiffness / across) + np.array([-half, half])
    assert np.abs(own_values(scene).imag / right - 1).max() < 1e-11
    assert np.abs(own_values(scene).real).max() < 1e-9


def test_a_sleeping_top_precesses_and_nutates_as_seen_from_the_ground():
    polar, across, mass, arm, spin = 0.02, 0.05, 2.0, 0.15, 60.0
    scene = Scene(
        name="top",
        gravity=[0, 0, -9.81],
        body={"top": {"mass": mass, "com": [0, 0, arm], "inertia": [across, across, polar]}},
        joint={"tip": {"spherical": {}, "between": ["ground", "top"], "start": {"omega": [0, 0, spin]}}},
    )
    inertia = across + mass * arm**2
    right = np.sort(np.roots([inertia, -polar * spin, mass * 9.81 * arm]))
    found = own_values(scene, axes="inertial")
    assert np.abs(np.sort(found[found.imag > 0].imag) - right).max() < 1e-9
    # the body sees both go round against its spin
    seen = own_values(scene)
    assert np.abs(np.sort(seen[seen.imag > 0].imag) - np.sort(spin - right)).max() < 1e-9


def test_a_disk_rolls_upright_from_a_speed_on():
    def squares(spin):
        values = own_values(disk(spin), at="start")
        return (values[np.abs(values) > 1e-3] ** 2).real

    def disk(spin):
        return Scene(
            name="disk",
            gravity=[0, 0, -9.81],
            body={"coin": {"mass": 1.0, "inertia": [0.25, 0.5, 0.25]}},
            joint={
                "free": {
                    "free": {},
                    "between": ["ground", "coin"],
                    "start": {"position": [0, 0, 1], "velocity": [spin, 0, 0], "omega": [0, spin, 0]},
                },
                "rim": {"rolling_disk": {"radius": 1.0, "axis": "y"}, "between": ["ground", "coin"]},
            },
        )

    for spin in (1.0, 1.7, 1.9, 5.0):
        assert np.abs(squares(spin) - (9.81 - 3 * spin**2) / 1.25).max() < 1e-9


def cantilever(n, length=2.0, bending=50.0, per_length=0.7):
    """A clamped beam as n rigid pieces with hinges half way between their ends; the first is half a piece."""
    h = length / n
    k, m = bending / h, per_length * h
    piece = {
        "mass": m,
        "inertia": [0, m * h * h / 12, m * h * h / 12],
        "marker": {"end": {"position": [h / 2, 0, 0]}},
    }
    bodies = {f"b{i}": piece | {"com": [0, 0, 0]} for i in range(n)}
    joints = {}

    for i in range(n):
        before = "ground" if i == 0 else f"b{i - 1}.end"
        bodies[f"b{i}"]["marker"] = piece["marker"] | {"root": {"position": [-h / 2, 0, 0]}}
        stiffness = 2 * k if i == 0 else k
        joints[f"j{i}"] = {
            "revolute": {"axis": "y"},
            "between": [before, f"b{i}.root"],
            "spring": {"stiffness": stiffness},
        }

    return Scene(name="beam", gravity=[0, 0, 0], body=bodies, joint=joints)


def test_a_beam_of_pieces_comes_to_euler_and_bernoullis():
    roots = np.array([1.875104068711961, 4.694091132974175, 7.854757438237613])
    right = roots**2 * np.sqrt(50.0 / 0.7) / 2.0**2
    errors = []

    for n in (20, 40):
        errors.append(2 * np.pi * cantilever(n).linearise([], []).modes().frequencies[:3] / right - 1)

    assert np.abs(errors[1]).max() < 4e-3
    assert np.abs(errors[0] / errors[1] - 4).max() < 0.2


def beads(n, length=1.0):
    """Equal beads on a hanging thread, at equal distances."""
    bead = {
        "mass": 0.3,
        "com": [0, 0, -length],
        "inertia": [0, 0, 0],
        "marker": {"end": {"position": [0, 0, -length]}},
    }
    links = {
        f"j{i}": {"revolute": {"axis": "y"}, "between": ["ground" if i == 0 else f"b{i - 1}.end", f"b{i}"]}
        for i in range(n)
    }
    return Scene(name="beads", gravity=[0, 0, -9.81], body={f"b{i}": bead for i in range(n)}, joint=links)


def test_beads_on_a_thread_swing_as_laguerres_polynomials_have_it():
    """Squares of the frequencies are g / l times the roots of the Laguerre polynomial of that degree."""
    right = np.sqrt(9.81 * scipy.special.roots_laguerre(12)[0])
    assert np.abs(2 * np.pi * beads(12).linearise([], []).modes().frequencies / right - 1).max() < 1e-11


def test_modes_of_a_chain_of_256_take_few_evaluations(monkeypatch):
    manifold = beads(256).linearise([], []).manifold
    evaluate, done = manifold.accelerations, []
    monkeypatch.setattr(manifold, "accelerations", lambda: done.append(1) or evaluate())
    modes = about(manifold, [], []).modes()
    right = np.sqrt(9.81 * scipy.special.roots_laguerre(256)[0])
    assert np.abs(2 * np.pi * modes.frequencies / right - 1).max() < 1e-7
    # by places at order 8, by speeds two looks whether that is even
    assert len(done) <= 8 * 256 + 10


def test_matrices_of_a_pendulum_are_the_closed_form(tmp_path):
    """About 30 deg, held by a torque: all of A, B, C, D, and what is read back from files."""
    mass, arm, inertia, damping, angle = 2.0, 0.7, 0.3, 0.4, np.pi / 6
    scene = Scene(
        name="pendulum",
        gravity=[0, 0, -9.81],
        body={
            "rod": {
                "mass": mass,
                "com": [0, 0, -arm],
                "inertia": [0, inertia, inertia],
                "marker": {"tip": {"position": [0, 0, -1], "output": ["position"]}},
            }
        },
        joint={
            "pivot": {
                "revolute": {"axis": "y"},
                "between": ["ground", "rod"],
                "start": {"angle": angle},
                "damper": damping,
                "input": "torque",
                "output": ["angle", "speed", "acceleration"],
            }
        },
    )
    whole = inertia + mass * arm**2
    linear = scene.linearise(at="start", hold={"pivot.torque": mass * 9.81 * arm * np.sin(angle)})
    k = mass * 9.81 * arm * np.cos(angle)
    row = [-k / whole, -damping / whole]
    assert linear.notices == []
    assert np.abs(linear.A - [[0, 1], row]).max() < 1e-11
    assert np.abs(linear.B - [[0], [1 / whole]]).max() < 1e-12
    outputs = [
        "rod.tip.position[1]",
        "rod.tip.position[3]",
        "pivot.angle",
        "pivot.speed",
        "pivot.acceleration",
    ]
    C = np.array([[-np.cos(angle), 0], [np.sin(angle), 0], [1, 0], [0, 1], row])
    rows = [linear.outputs.index(name) for name in outputs]
    assert np.abs(linear.C[rows] - C).max() < 1e-11
    assert np.abs(linear.D[rows, 0] - [0, 0, 0, 0, 1 / whole]).max() < 1e-12
    assert abs(linear.stiffness[0, 0] - k) < 1e-10 and abs(linear.damping[0, 0] - damping) < 1e-11
    assert abs(linear.modes()[0].damping - damping / (2 * np.sqrt(k * whole))) < 1e-11

    assert np.array_equal(linear.state_space().A, linear.A)
    table = np.load(linear.save(tmp_path / "a.npz"))
    assert np.array_equal(table["C"], linear.C) and list(table["outputs"]) == linear.outputs
    table = scipy.io.loadmat(linear.save(tmp_path / "a.mat"))
    assert np.array_equal(table["A"], linear.A) and table["states"][1, 0][0] == "pivot.speed"

    with pytest.raises(ValueError, match="npz"):
        linear.save(tmp_path / "a.csv")

    if importlib.util.find_spec("control"):
        system = linear.control()
        assert np.array_equal(system.B, linear.B) and system.input_labels == ["pivot_torque"]
    else:
        with pytest.raises(ImportError, match="pip install control"):
            linear.control()


def test_a_loop_of_a_moving_run_is_that_of_its_state():
    """A parallelogram four-bar, rows redundant in space: it swings as a pendulum, also while it moves."""
    bar = {
        "mass": 1.0,
        "com": [0, 0, -0.5],
        "inertia": [0.1, 0.1, 0.1],
        "marker": {"end": {"position": [0, 0, -1]}},
    }
    scene = Scene(
        name="swing",
        gravity=[0, 0, -9.81],
        body={
            "left": bar,
            "right": bar,
            "board": {
                "mass": 3.0,
                "inertia": [0.1, 0.2, 0.1],
                "marker": {"a": {"position": [-1, 0, 0]}, "b": {"position": [1, 0, 0]}},
            },
        },
        joint={
            "l": {"revolute": {"axis": "y"}, "between": ["ground", "left"], "start": {"angle": 0.9}},
            "r": {"revolute": {"axis": "y"}, "between": ["ground.r", "right"]},
            "la": {"revolute": {"axis": "y"}, "between": ["left.end", "board.a"]},
            "rb": {"revolute": {"axis": "y"}, "between": ["right.end", "board.b"]},
        },
        ground={"marker": {"r": {"position": [2, 0, 0]}}},
        solver={"tolerance": 1e-12},
    )
    inertia, moment = 2 * (0.1 + 0.25) + 3.0, 9.81 * (2 * 0.5 + 3.0)
    rest = scene.linearise()
    assert rest.A.shape == (2, 2)
    assert abs(rest.modes()[0].eigenvalue - 1j * np.sqrt(moment / inertia)) < 1e-10

    # angle'' = -moment / inertia sin(angle), whichever coordinate tells it
    moving = scene.linearise(at=0.4)
    E = scene.simulate(0.4, 0.4).poses("left")[1][-1]
    assert np.abs(moving.A - [[0, 1], [-moment / inertia * (1 - 2 * E[1] ** 2), 0]]).max() < 1e-9
    assert any("not steady" in notice for notice in moving.notices)


def test_rest_and_frequencies_change_with_parameters_as_closed_forms_do():
    """A bar on a spring in the hinge: k a = m g l cos a; w^2 = (k - m g l sin(a) ...) / J."""
    mass, arm, stiffness, inertia = 2.0, 0.5, 30.0, 0.1
    scene = Scene(
        name="bar",
        gravity=[0, 0, -9.81],
        body={
            "bar": {
                "mass": mass,
                "com": [arm, 0, 0],
                "inertia": [0, inertia, inertia],
                "output": ["position"],
            }
        },
        joint={
            "hinge": {
                "revolute": {"axis": "y"},
                "between": ["ground", "bar"],
                "spring": {"stiffness": stiffness},
                "output": ["angle"],
            }
        },
    )

    def rest(k, m):
        angle = scipy.optimize.brentq(lambda a: k * a - m * 9.81 * arm * np.cos(a), 0, 1.5, xtol=1e-16)
        return angle, np.sqrt((k + m * 9.81 * arm * np.sin(angle)) / (inertia + m * arm**2)) / (2 * np.pi)

    def slope(of, at):
        h = 1e-3 * at
        f = [np.array(of(at + j * h)) - np.array(of(at - j * h)) for j in (1, 2, 3)]
        return (0.75 * f[0] - 0.15 * f[1] + f[2] / 60) / h

    linear = scene.linearise(parameters=["hinge.stiffness", "bar.mass"])
    found = linear.sensitivities
    right = np.array([slope(lambda k: rest(k, mass), stiffness), slope(lambda m: rest(stiffness, m), mass)]).T
    assert np.abs(found.places["hinge.angle"] / right[0] - 1).max() < 1e-8
    assert np.abs(found.outputs["hinge.angle"] / right[0] - 1).max() < 1e-8
    assert np.abs(found.frequencies[0] / right[1] - 1).max() < 1e-8
    assert np.abs(found.damping).max() < 1e-10


def test_the_barge_of_a_turbine_swings_at_the_reference_periods():
    """Added mass alone: OpenFAST has 7.7991 s in heave, 11.3744 s in pitch at 5 deg (11.3765 s of small swings)."""
    periods = np.array([mode.period for mode in adrift().linearise([], []).modes() if mode.oscillates])
    assert np.abs(periods - 7.7991).min() < 1e-4
    assert np.abs(periods - 11.3765).min() < 1e-4


def test_a_locus_from_standstill_on_is_about_the_start_throughout():
    """A bicycle that stands would fall and rest on its side: its locus over speed begins with it upright, too."""
    found = locus(bicycle(0.0), "frame.velocity_start[1]", [0.0, 3.0, 5.0])
    assert not any("left out" in text for text in found.notices)

    for speed, roots in zip((0, 3, 5), found.eigenvalues):
        right = np.array(BICYCLE[speed])
        assert min(np.abs(roots[np.isfinite(roots)] - right[0])) < 1e-8


def test_a_locus_is_about_one_kind_of_state():
    """A rod holds torques up to its weight's: beyond, there is no equilibrium, and no root of another kind of state."""
    body = {"rod": {"mass": 1.0, "inertia": [0.01, 1 / 12, 1 / 12], "com": [0.5, 0, 0]}}
    joint = {"pivot": {"revolute": {}, "between": ["ground", "rod"], "input": "torque"}}
    joint["pivot"]["start"] = {"angle": -np.pi / 2}
    scene = Scene(name="rod", gravity=[0, -9.81, 0], body=body, joint=joint)
    found = locus(scene, "pivot.torque", [0.0, 2.0, 4.0, 6.0])
    stiffness = np.sqrt((9.81 / 2) ** 2 - found.values[:3] ** 2)
    np.testing.assert_allclose(np.abs(found.eigenvalues[:3, 0].imag), np.sqrt(3 * stiffness), rtol=1e-8)
    assert np.isnan(found.eigenvalues[3]).all()
    assert found.notices == ["pivot.torque = 6: left out, for there is no equilibrium"]
    assert scene.linearise().where == "the equilibrium"
    assert scene.linearise(at="0.5").where == "0.5 s into a run"

    for at in (-1, "nan", "later"):
        with pytest.raises(ValueError, match="a number of seconds from 0 on"):
            scene.linearise(at=at)


@pytest.mark.parametrize(
    "name, at",
    [
        ("double_pendulum", 0.3),
        ("four_bar", "start"),
        ("bricard", 0.3),
        ("bicycle", "start"),
        ("rolling_disk", 0.3),
        ("turntable", "start"),
        ("floating_crane", None),
    ],
)
def test_exact_derivatives_are_those_of_differences(name, at):
    """Trees, loops that move, rolling, drives, hulls at rest: the scene's equations differentiated, beside differences."""
    mechanism, _, _ = state_at(mbdfmi.load(mbdfmi.__path__[0] + f"/../models/{name}.toml"), at)
    manifold = Manifold(mechanism)
    exact, found = about(manifold, traced=True), about(manifold)
    assert exact.error < 1e-14 < found.error + 1e-14

    for key in ("A", "B", "D"):
        one, other = getattr(exact, key), getattr(found, key)
        assert np.abs(one - other).max(initial=0.0) <= 1e-10 * max(1.0, np.abs(other).max(initial=0.0))

    # of outputs each by itself: sums of large terms are known less well by differences
    rough = 1e-6 if name == "floating_crane" else 1e-10
    size = np.maximum(1.0, np.abs(found.C).max(axis=1, initial=0.0, keepdims=True))
    assert np.abs((exact.C - found.C) / size).max(initial=0.0) < rough


@pytest.mark.parametrize("upper, kink", [(0.0, True), (1e-3, False)])
def test_a_stop_just_touched_is_a_kink(upper, kink):
    """Neither the slope on one side nor the mean of both is taken for the stiffness without a word."""
    bar = {"mass": 2.0, "com": [0, 0, -0.5], "inertia": [0, 0.1, 0.1]}
    joint = {"revolute": {"axis": "y"}, "between": ["ground", "bar"]}
    joint["stop"] = {"lower": -1.0, "upper": upper, "stiffness": 500.0}
    scene = Scene(name="stop", gravity=[0, 0, -9.81], body={"bar": bar}, joint={"hinge": joint})
    linear = scene.linearise(at="start")
    assert bool(linear.error > 0.1) is kink
    assert any("a kink" in text for text in linear.notices) is kink
    assert kink or abs(linear.stiffness[0, 0] / 9.81 - 1) < 1e-14


def test_the_command_shows_the_shapes_swinging(tmp_path, capsys):
    """A page of both modes of a double pendulum, one after the other; the picture; the table."""
    from mbdfmi.cli import main

    scene = mbdfmi.__path__[0] + "/../models/double_pendulum.toml"
    page, picture = tmp_path / "shapes.html", tmp_path / "shapes.png"
    assert main(["modes", scene, "--at", "equilibrium", "--view", str(page)]) == 0
    assert "0.426553" in capsys.readouterr().out
    assert page.stat().st_size > 100_000
    assert main(["modes", scene, "--at", "equilibrium", "--mode", "2", "--view", str(picture)]) == 0
    assert picture.read_bytes().startswith(b"\x89PNG")
