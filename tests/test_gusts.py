"""Gusts: what is added to the wind over time, against closed forms, and where it has kinks."""

import numpy as np
import pytest
from scenes import assert_near

from mbdfmi import Scene, SceneError
from mbdfmi.compiler.model import compile_scene
from mbdfmi.kernels import exchange
from mbdfmi.run.simulate import simulate


def mill(folder, gust, steady=None, **wind):
    """A disc of one thrust coefficient that may be blown along, and one held 40 m up."""
    rows = [f"{r},{p},0.8,0.0" for r in (-1, 0, 1, 2) for p in (0, 1, 2, 3)]
    (folder / "rotor.csv").write_text("\n".join(["tip speed ratio,pitch,C_T,C_Q", *rows]))
    rotor = {"radius": 2.0, "table": str(folder / "rotor.csv")}
    body = {"mass": 50.0, "inertia": [1, 1, 1], "output": ["position"]}
    return Scene.model_validate(
        {
            "name": "mill",
            "gravity": [0, 0, 0],
            "output": ["kinetic_energy", "load_power", "total_energy"],
            "solver": {"tolerance": 1e-11},
            "wind": {"density": 1.2, "steady": steady or {"velocity": [8.0, 0, 0]}, "gust": gust} | wind,
            "body": {
                "kite": body,
                "mast": {"mass": 1.0, "inertia": [1, 1, 1], "marker": {"top": {"position": [0, 0, 40.0]}}},
            },
            "joint": {
                "rail": {
                    "prismatic": {"axis": "x"},
                    "between": ["ground", "kite"],
                    "output": ["position", "speed"],
                },
                "foot": {"fixed": {}, "between": ["ground", "mast"]},
            },
            "force": {
                "sail": {"rotor": rotor, "on": "kite", "output": ["wind", "thrust"]},
                "still": {"rotor": rotor, "on": "mast.top", "output": ["wind"]},
            },
        }
    )


def operating(time, size, start, period=10.5):
    """IEC 61400-1, 6.3.2.2."""
    t = np.clip(time - start, 0.0, period)
    return -0.37 * size * np.sin(3 * np.pi * t / period) * (1 - np.cos(2 * np.pi * t / period))


def kinks(scene):
    m, d = compile_scene(scene).views()
    d.time[0], found = -1.0, []

    while (kink := exchange.next_kink(m, d)) < np.inf:
        found.append(kink)
        d.time[0] = kink

    return found


def test_an_operating_gust_dips_rises_and_dips(tmp_path):
    """Along the steady wind at all heights alike, and without kinks: value, slope and second slope go on at its ends
    (there but for rounding)."""
    scene = mill(
        tmp_path,
        {"eog": {"start": 2.0, "amplitude": 6.0}},
        {"velocity": [8.0, 3.0, 0], "exponent": 0.2, "reference_height": 40.0},
    )
    run = simulate(compile_scene(scene), 14.0, 0.1)
    gust = operating(run["time"], 6.0, 2.0)
    assert_near(run["still.wind"], 8.0 + 8.0 / np.hypot(8, 3) * gust, 1e-8)
    assert gust.max() > 2.0 and gust.min() < -1.0
    low = 8.0 * (0.1 / 40.0) ** 0.2
    assert_near(run["sail.wind"] + run["rail.speed"], low + 8.0 / np.hypot(8, 3) * gust, 1e-8)
    assert set(kinks(scene)) <= {2.0, 12.5}


@pytest.mark.parametrize(
    "turbine, speed, height, size",
    [
        # class I A, 25 m/s at the hub: sigma = 0.16 (0.75 25 + 5.6), V_e1 = 56 m/s
        (
            {"turbine_class": "I", "turbulence": "A", "diameter": 126.0},
            25.0,
            90.0,
            3.3 * 3.896 / (1 + 12.6 / 42),
        ),
        # low hubs have smaller eddies
        (
            {"turbine_class": "III", "turbulence": "C", "diameter": 20.0},
            10.0,
            30.0,
            3.3 * 1.572 / (1 + 2.0 / 21),
        ),
        # near the extreme wind of a year, 42 m/s in class III, what is left to that
        ({"turbine_class": "III", "turbulence": "A+", "diameter": 20.0}, 41.0, 60.0, 1.35),
    ],
)
def test_its_size_is_that_of_the_turbines_class(tmp_path, turbine, speed, height, size):
    steady = {"velocity": [speed, 0, 0], "reference_height": height}
    run = simulate(compile_scene(mill(tmp_path, {"eog": turbine | {"start": 0.0}}, steady)), 10.5, 0.05)
    assert_near(run["still.wind"], speed + operating(run["time"], size, 0.0), 1e-8)


def test_a_step_comes_smoothly_or_at_once(tmp_path):
    """Both are there in the end; where the rise has corners of the second slope, or the wind jumps, solvers outside stop."""
    change = {"velocity": [4.0, 1.0, 0], "start": 3.0}
    run = simulate(compile_scene(mill(tmp_path, {"step": change | {"rise": 5.0}})), 10.0, 0.1)
    risen = np.clip((run["time"] - 3.0) / 5.0, 0.0, 1.0)
    assert_near(run["still.wind"], 8.0 + 2.0 * (1 - np.cos(np.pi * risen)), 1e-8)
    assert_near(kinks(mill(tmp_path, {"step": change | {"rise": 5.0}})), [3.0, 8.0], 1e-12)

    run = simulate(compile_scene(mill(tmp_path, {"step": change})), 10.0, 0.3)
    assert_near(run["still.wind"], 8.0 + 4.0 * (run["time"] >= 3.0 - 1e-9), 1e-12)
    assert kinks(mill(tmp_path, {"step": change})) == [3.0]


def test_a_table_over_time_moves_what_is_in_it(tmp_path):
    """A disc with C_T = 0.8 on a rail in still air and gusts by a table: m v' = c (u - v)^2, energy is that of the load."""
    table = {"time": [0.0, 4.0, 10.0], "velocity": [[2.0, 0, 0], [9.0, 0, 0], [9.0, 0, 0]]}
    scene = mill(tmp_path, {"table": table}, {"velocity": [0, 0, 0]})
    run = simulate(compile_scene(scene), 10.0, 0.02)
    c = 0.5 * 1.2 * np.pi * 4.0 * 0.8
    wind = np.interp(run["time"], table["time"], [2.0, 9.0, 9.0])
    assert_near(run["still.wind"], wind, 1e-12)
    # from 4 s on the wind is 9 m/s: 9 - v = w / (1 + c w (t - 4) / m)
    w = 9.0 - run["rail.speed"][200]
    late = run["time"][200:] - 4.0
    assert_near(9.0 - run["rail.speed"][200:], w / (1 + c * w * late / 50.0), 1e-8)
    work = np.trapezoid(run["load_power"], run["time"])
    assert_near(work, run["kinetic_energy"][-1] - run["kinetic_energy"][0], 1e-4 * work)
    assert kinks(scene) == [0.0, 4.0]


def test_a_gust_is_added_to_a_wind_from_outside(tmp_path):
    scene = mill(tmp_path, {"eog": {"start": 0.0, "amplitude": 3.0}}, input=["velocity"])
    run = simulate(compile_scene(scene), 5.0, 0.1, inputs={"wind.velocity": [11.0, 0, 0]})
    assert_near(run["still.wind"], 11.0 + operating(run["time"], 3.0, 0.0), 1e-8)


def test_a_rest_knows_no_gust_unless_asked(tmp_path):
    data = mill(tmp_path, {"step": {"velocity": [4.0, 0, 0], "start": 0.0}}).model_dump(exclude_unset=True)
    data["joint"]["rail"]["spring"] = {"stiffness": 100.0}
    scene = Scene.model_validate(data)
    assert abs(scene.equilibrium().coordinates["rail.position"]) < 1e-12
    windy = scene.equilibrium(weather=True)
    assert_near(100.0 * windy.coordinates["rail.position"], 0.5 * 1.2 * np.pi * 4 * 0.8 * 144, 1e-6)


@pytest.mark.parametrize(
    "gust, steady, words",
    [
        ({"eog": {"start": 0.0, "amplitude": 3.0}}, [0, 0, 0], "has no direction"),
        (
            {"eog": {"start": 0.0, "turbine_class": "III", "diameter": 90.0}},
            [43.0, 0, 0],
            "class III has no operating gust in 43 m/s",
        ),
        ({"eog": {"start": 0.0, "turbine_class": "IV"}}, [9.0, 0, 0], 'no "IV" here; there is "I", "II"'),
        ({"eog": {"start": 0.0, "turbine_class": "I"}}, [9.0, 0, 0], "needs the diameter of the rotor"),
        ({"eog": {"start": 0.0, "amplitude": 3.0, "diameter": 3.0}}, [9.0, 0, 0], "amplitude says it all"),
        ({"eog": {"start": 0.0}}, [9.0, 0, 0], '"amplitude" or "turbine_class"'),
        ({"step": {"start": 0.0}}, [9.0, 0, 0], "velocity"),
        ({"table": {"time": [0, 1], "velocity": [[1, 0, 0]] * 3}}, [9.0, 0, 0], "2 values"),
        ({}, [9.0, 0, 0], '"eog", "step" or "table"'),
    ],
)
def test_what_is_no_gust_is_told(tmp_path, gust, steady, words):
    with pytest.raises(SceneError, match=r"wind") as told:
        mill(tmp_path, gust, {"velocity": steady})
    assert words in str(told.value)
