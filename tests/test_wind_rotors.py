"""Rotors in the wind by tables of coefficients: closed forms, tables, energy, mistakes."""

import numpy as np
import pytest
from scenes import assert_near

from mbdfmi import Scene, SceneError
from mbdfmi.compiler.model import compile_scene
from mbdfmi.run.instance import Instance
from mbdfmi.run.simulate import simulate

RADIUS, AIR = 60.0, 1.225
AREA = np.pi * RADIUS**2


def thrust(ratio, pitch):
    return 0.1 + 0.12 * ratio - 0.006 * ratio**2 - 1.2 * pitch + 0.05 * ratio * pitch


def torque(ratio, pitch):
    return 0.02 + 0.015 * ratio - 0.0016 * ratio**2 - 0.3 * pitch


def table(folder, ratios=None, shuffled=False):
    """A CSV file of polynomials that splines keep."""
    ratios = np.linspace(1, 13, 9) if ratios is None else ratios
    rows = [(x, p, thrust(x, p), torque(x, p)) for x in ratios for p in np.radians([0, 5, 10, 20, 30])]
    rows = rows[::-1] if shuffled else rows
    text = "\n".join(",".join(f"{value:.17g}" for value in row) for row in rows)
    (folder / "rotor.csv").write_text("ratio,pitch,C_T,C_Q\n" + text + "\n")
    return str(folder / "rotor.csv")


@pytest.fixture(scope="module")
def file(tmp_path_factory):
    return table(tmp_path_factory.mktemp("rotor"), shuffled=True)


def turbine(file, tilt=0.0, speed=1.2, pitch=0.05, wind=None, sway=0.0, inputs=(), **shaft):
    """A hub on a shaft on a mast that moves as told."""
    turned = {"zyx_deg": [0, tilt, 0]}
    return Scene.model_validate(
        {
            "name": "turbine",
            "gravity": [0, 0, 0],
            "wind": wind or {"steady": {"velocity": [11.0, 0.5, -0.3]}},
            "solver": {"tolerance": 1e-11},
            "output": ["total_energy", "load_power", "driver_power"],
            "body": {
                "mast": {
                    "mass": 1e5,
                    "inertia": [1e6, 1e6, 1e6],
                    "marker": {"top": {"position": [0, 0, 90.0]} | turned},
                },
                "hub": {"mass": 1e5, "inertia": [4e7, 2e7, 2e7]},
            },
            "joint": {
                "base": {
                    "prismatic": {"axis": "x"},
                    "between": ["ground", "mast"],
                    "driver": {"constant_speed": sway},
                },
                "shaft": {
                    "revolute": {"axis": "x"},
                    "between": ["mast.top", "hub"],
                    "start": {"speed": speed},
                    "output": ["speed"],
                }
                | shaft,
            },
            "force": {
                "rotor": {
                    "rotor": {"radius": RADIUS, "table": file, "pitch": pitch},
                    "on": "hub",
                    "output": ["thrust", "torque", "wind", "power"],
                    "input": list(inputs),
                }
            },
        }
    )


def told(scene, **inputs):
    """Outputs at the start by name."""
    instance = Instance(compile_scene(scene))
    at = {v.name: v.index for v in instance.model.of_causality("input")}

    for name, value in inputs.items():
        instance.u[at[name.replace("__", ".")]] = value

    return dict(zip([v.name for v in instance.model.of_causality("output")], instance.outputs()))


@pytest.mark.parametrize("tilt, sway", [(0.0, 0.0), (5.0, 0.0), (-3.0, 1.5)])
def test_thrust_and_torque_are_those_of_the_table(file, tilt, sway):
    """With the component along the tilted axis, less the hub's own velocity."""
    found = told(turbine(file, tilt, sway=sway))
    axis = np.array([np.cos(np.radians(tilt)), 0, -np.sin(np.radians(tilt))])
    U = (np.array([11.0, 0.5, -0.3]) - [sway, 0, 0]) @ axis
    ratio = 1.2 * RADIUS / U
    assert_near(found["rotor.wind"], U, 1e-12)
    assert_near(found["rotor.thrust"], AIR / 2 * AREA * U**2 * thrust(ratio, 0.05), 1e-6)
    assert_near(found["rotor.torque"], AIR / 2 * AREA * RADIUS * U**2 * torque(ratio, 0.05), 1e-5)
    power = found["rotor.thrust"] * sway * axis[0] + found["rotor.torque"] * 1.2
    assert_near(found["rotor.power"], power, 1e-4)


def test_edges_hold_and_wind_from_ahead_does_nothing(file):
    edge = told(turbine(file, speed=20.0, pitch=2.0, wind={"steady": {"velocity": [6, 0, 0]}}))
    assert_near(edge["rotor.thrust"], AIR / 2 * AREA * 36 * thrust(13, np.radians(30)), 1e-6)
    ahead = told(turbine(file, wind={"steady": {"velocity": [-6, 0, 0]}}))
    assert ahead["rotor.thrust"] == ahead["rotor.torque"] == 0.0


def test_wind_grows_with_height_and_comes_from_inputs(file):
    wind = {"steady": {"velocity": [10, 0, 0], "exponent": 0.14, "reference_height": 45}}
    assert_near(told(turbine(file, wind=wind))["rotor.wind"], 10 * 2**0.14, 1e-12)
    wind |= {"input": ["velocity"]}
    scene = turbine(file, wind=wind, inputs=["pitch"])
    names = {v.name: v.start for v in compile_scene(scene).of_causality("input")}
    assert names == {
        "wind.velocity[1]": 10,
        "wind.velocity[2]": 0,
        "wind.velocity[3]": 0,
        "rotor.pitch": 0.05,
    }
    found = told(scene, **{"wind__velocity[1]": 12.0, "rotor__pitch": 0.2})
    U = 12 * 2**0.14
    assert_near(found["rotor.thrust"], AIR / 2 * AREA * U**2 * thrust(1.2 * RADIUS / U, 0.2), 1e-6)


def test_powers_and_the_ground_feel_the_wind_at_once(file):
    """A rotor on what is fixed to the ground and one on a hub: power of loads and the ground's reaction depend on wind and pitch, input power on neither."""
    data = turbine(
        file, wind={"steady": {"velocity": [10, 0, 0]}, "input": ["velocity"]}, inputs=["pitch"]
    ).model_dump(exclude_unset=True)
    post = {"rotor": {"radius": 1.0, "table": file}, "on": "post", "input": ["pitch"]}
    scene = data | {"output": ["load_power", "input_power"], "ground": {"output": ["reaction_force"]}}
    scene["body"] = data["body"] | {"post": {"mass": 1.0, "inertia": [1, 1, 1]}}
    scene["joint"] = data["joint"] | {"weld": {"fixed": {}, "between": ["ground", "post"]}}
    model = compile_scene(Scene.model_validate(scene | {"force": data["force"] | {"blades": post}}))
    names = {v.index: v.name for v in model.of_causality("input")}
    felt = {v.name: {names[k] for k in v.depends} for v in model.of_causality("output")}
    wind = {"wind.velocity[1]", "wind.velocity[2]", "wind.velocity[3]"}
    assert felt["load_power"] == wind | {"rotor.pitch", "blades.pitch"}
    assert wind | {"blades.pitch"} <= felt["ground.reaction_force[1]"]
    assert not felt["input_power"] & (wind | {"rotor.pitch", "blades.pitch"})


def test_a_rotor_runs_up_by_the_power_of_the_wind(file):
    """I Omega' = torque; the energy that it gets is that of the loads."""
    run = simulate(
        compile_scene(turbine(file, speed=0.8, wind={"steady": {"velocity": [9, 0, 0]}})), 10.0, 0.05
    )
    speed, time = run["shaft.speed"], run["time"]
    slope = np.gradient(speed, time, edge_order=2)
    wanted = AIR / 2 * AREA * RADIUS * 81 * torque(speed * RADIUS / 9, 0.05) / 4e7
    assert_near(slope[2:-2], wanted[2:-2], 1e-4 * np.abs(wanted).max())
    weights = np.ones(len(time))
    weights[1:-1:2], weights[2:-1:2] = 4, 2
    gained = weights @ (run["load_power"] + run["driver_power"]) * 0.05 / 3
    assert_near(gained, run["total_energy"][-1] - run["total_energy"][0], 1e-6 * np.ptp(run["total_energy"]))


def test_a_finer_table_of_a_smooth_function_comes_nearer(tmp_path):
    """A table that is no polynomial, between its points."""
    errors = []

    for n in (8, 15):
        ratios = np.linspace(1, 13, n)
        rows = [(x, p, np.exp(-((x - 7) ** 2) / 20), 0.05) for x in ratios for p in (0.0, 0.1, 0.2, 0.3)]
        (tmp_path / "r.csv").write_text(
            "a,b,c,d\n" + "\n".join(",".join(f"{v:.17g}" for v in row) for row in rows)
        )
        found = told(turbine(str(tmp_path / "r.csv"), speed=1.0, wind={"steady": {"velocity": [10, 0, 0]}}))
        errors.append(abs(found["rotor.thrust"] / (AIR / 2 * AREA * 100) - np.exp(-1 / 20)))

    assert errors[1] < errors[0] / 2 and errors[0] < 1e-4


def test_mistakes_are_told(file, tmp_path):
    (tmp_path / "short.csv").write_text("a,b,c,d\n1,0,0.1,0.2\n2,0,0.1,0.2\n3,1,0,0\n")

    with pytest.raises(SceneError, match=r"short.csv: needs each tip speed ratio with each pitch"):
        compile_scene(turbine(str(tmp_path / "short.csv")))

    data = turbine(file).model_dump(exclude_unset=True)
    del data["wind"]

    with pytest.raises(SceneError, match=r"\[force.rotor\] rotor: a rotor needs a wind"):
        Scene.model_validate(data)

    data = turbine(file).model_dump(exclude_unset=True)
    del data["force"]

    with pytest.raises(SceneError, match=r"\[wind\].*nothing is in the wind"):
        Scene.model_validate(data)
