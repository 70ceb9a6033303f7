"""Linear couplings of any number of joints: differentials, planetary gears, tackles, against closed forms."""

import numpy as np
import pytest
from loop_scenes import random_loops
from scenes import assert_near
from test_powers import named_outputs

from mbdfmi import Scene, SceneError
from mbdfmi.compiler.model import compile_scene
from mbdfmi.run.instance import Instance, SimulationError
from mbdfmi.run.simulate import simulate

formulations = pytest.mark.parametrize("formulation", ["recursive", "embedding", "augmented"])
EXACT = {"integrator": "rk853", "tolerance": 1e-12}
OUTPUTS = ["angle", "speed", "acceleration"]


def shaft(inertia, mass=1.0):
    return {"mass": mass, "inertia": [1.0, 1.0, inertia]}


def hinge(name, base="ground", **more):
    return {"revolute": {}, "between": [base, name], "output": OUTPUTS} | more


def coupled(body, joint, coupling, formulation="recursive", **more):
    """A scene without gravity."""
    return {
        "name": "coupled", "gravity": [0, 0, 0], "output": ["total_energy", "input_power"],
        "body": body, "joint": joint, "coupling": coupling, "solver": EXACT | {"formulation": formulation},
    } | more  # fmt: skip


def started(scene):
    return Instance(compile_scene(Scene.model_validate(scene)))


def differential(formulation, constant=None, loops=False):
    """Two shafts and the cage between them, q1 + q2 - 2 q3; with `loops` the cage also hangs on a hinge that closes a loop."""
    moments = {"left": 0.3, "right": 0.5, "cage": 0.7}
    speeds = {"left": 1.0, "right": 3.0, "cage": 2.0}
    joint = {name: hinge(name, start={"speed": speeds[name]}, input="torque") for name in moments}
    between = list(moments)

    if loops:
        joint["again"] = {"revolute": {}, "between": ["ground", "cage"]}
        between = ["left", "again", "right"]

    factors = [1, -2, 1] if loops else [1, 1, -2]
    linear = {"coefficients": factors} | ({} if constant is None else {"constant": constant})
    body = {name: shaft(inertia) for name, inertia in moments.items()}
    coupling = {"bevels": {"linear": linear, "between": between, "output": ["efforts"]}}
    return coupled(body, joint, coupling, formulation)


@formulations
@pytest.mark.parametrize("loops", [False, True])
def test_a_differential(formulation, loops):
    """I q'' = tau + a lambda, a q'' = 0: accelerations, efforts, angles after 1 s; the work of the torques is the energy."""
    instance = started(differential(formulation, loops=loops))
    tau = {"left.torque": 0.4, "right.torque": -0.1, "cage.torque": 0.2}

    for v in instance.model.of_causality("input"):
        instance.u[v.index] = tau[v.name]

    energy = named_outputs(instance)["total_energy"]
    instance.step(1.0)
    y = named_outputs(instance)
    inertia, a = np.array([0.3, 0.5, 0.7]), np.array([1, 1, -2])
    torque, speed = np.array(list(tau.values())), np.array([1.0, 3.0, 2.0])
    multiplier = -(a @ (torque / inertia)) / (a @ (a / inertia))
    acceleration = (torque + a * multiplier) / inertia
    names = ("left", "right", "cage")
    assert_near([y[f"{name}.acceleration"] for name in names], acceleration, 1e-12)
    assert_near([y[f"{name}.speed"] for name in names], speed + acceleration, 1e-11)
    angles = speed + acceleration / 2
    assert_near([y[f"{name}.angle"] for name in names], angles, 1e-11)
    efforts = multiplier * a
    assert_near(y["bevels.efforts"], efforts[[0, 2, 1]] if loops else efforts, 1e-12)
    assert_near(y["total_energy"] - energy, torque @ angles, 1e-11)


@formulations
def test_a_planetary_gear(formulation):
    """Willis: 20 sun + 60 ring = 80 carrier; planets of 20 teeth. With the ring held, the torque on the sun turns all of it."""
    sun, planet, ring = 20, 20, 60
    k = sun / (sun + ring)
    arm, speed, mass, count = 0.05, 40.0, 0.2, 3
    body = {"sun": shaft(1e-3), "ring": shaft(5e-3), "carrier": shaft(2e-3)}
    joint = {
        "s": hinge("sun", input="torque", start={"speed": speed}),
        "r": hinge("ring", driver={"hold": True}) | {"output": [*OUTPUTS, "driver_effort"]},
        "c": hinge("carrier", output=[*OUTPUTS]),
    }
    coupling = {
        "willis": {"linear": {"coefficients": [sun, ring, -(sun + ring)], "constant": 0.0}, "between": ["s", "r", "c"],
                   "output": ["efforts"]}
    }  # fmt: skip
    marker = {}

    for i in range(count):
        turn = 2 * np.pi * i / count
        marker[f"p{i}"] = {"position": [arm * np.cos(turn), arm * np.sin(turn), 0]}
        body[f"planet{i}"] = shaft(1e-4, mass)
        joint[f"p{i}"] = hinge(f"planet{i}", f"carrier.p{i}")
        mesh = {"coefficients": [sun, -sun, planet], "constant": 0.0}
        coupling[f"mesh{i}"] = {"linear": mesh, "between": ["s", "c", f"p{i}"]}

    body["carrier"]["marker"] = marker
    instance = started(coupled(body, joint, coupling, formulation))
    torque = 0.7
    instance.u[0] = torque
    y = named_outputs(instance)

    # speeds by the sun's: of the carrier k, of a planet in the inertial frame `spin`
    spin = k - sun / planet * (1 - k)
    inertia = 1e-3 + k**2 * (2e-3 + count * mass * arm**2) + count * 1e-4 * spin**2
    assert_near([y["c.speed"], y["p0.speed"]], [k * speed, (spin - k) * speed], 1e-12)
    assert_near(y["s.acceleration"], torque / inertia, 1e-9)
    instance.step(0.1)
    y = named_outputs(instance)
    angle = speed * 0.1 + torque / inertia * 0.005
    assert_near([y["s.angle"], y["c.angle"]], [angle, k * angle], 1e-9)
    efforts = y["willis.efforts"]
    assert_near(efforts / efforts[0], [1, ring / sun, -(sun + ring) / sun], 1e-12)
    assert_near(y["r.driver_effort"], -efforts[1], 1e-9)
    assert_near(efforts @ [y["s.speed"], y["r.speed"], y["c.speed"]], 0.0, 1e-8)


@formulations
def test_a_tackle_lifts_what_it_does(formulation):
    """A rope over two loads and a hook below a block: x1 + x2 + 2 x3 = const. Tension T on each part, 2 T at the block."""
    masses, g = np.array([2.0, 3.0, 4.0]), 9.81
    body = {f"load{k}": {"mass": m, "inertia": [1, 1, 1]} for k, m in enumerate(masses)}
    joint = {
        f"x{k}": {"prismatic": {"axis": "z"}, "between": ["ground", f"load{k}"], "output": ["position", "acceleration"],
                  "start": {"position": 0.1 * k}}
        for k in range(3)
    }  # fmt: skip
    coupling = {
        "rope": {"linear": {"coefficients": [1, 1, 2]}, "between": ["x0", "x1", "x2"], "output": ["efforts"]}
    }
    scene = coupled(body, joint, coupling, formulation, gravity=[0, 0, -g])
    run = simulate(compile_scene(Scene.model_validate(scene)), 1.0, 0.5)
    a = np.array([1, 1, 2])
    tension = g * a.sum() / (a @ (a / masses))
    acceleration = tension * a / masses - g
    assert_near(run["rope.efforts"], np.tile(tension * a, (3, 1)), 1e-11)
    assert_near([run[f"x{k}.position"][-1] for k in range(3)], 0.1 * np.arange(3) + acceleration / 2, 1e-11)
    assert_near(run["total_energy"], run["total_energy"][0], 1e-11)


@formulations
def test_a_constant_makes_the_last_joint_follow(formulation):
    """What is given is kept, exactly, however far the one that follows has to go; what is driven also counts."""
    scene = differential(formulation, constant=0.7)
    scene["joint"]["left"]["start"] = {"angle": 4.0}
    scene["joint"]["right"]["driver"] = {"constant_speed": 3.0}
    scene["joint"]["right"]["start"] = {"angle": -9.0}
    scene["joint"]["cage"]["start"] = {}
    del scene["joint"]["right"]["input"]
    y = named_outputs(started(scene))
    assert_near([y["left.angle"], y["right.angle"], y["cage.angle"]], [4.0, -9.0, (4 - 9 - 0.7) / 2], 1e-13)


@formulations
def test_without_a_constant_all_start_as_given(formulation):
    scene = differential(formulation)

    for name, angle in (("left", 1.0), ("right", 2.5), ("cage", -4.0)):
        scene["joint"][name]["start"]["angle"] = angle

    instance = started(scene)
    instance.step(0.5)
    y = named_outputs(instance)
    assert_near(y["left.angle"] + y["right.angle"] - 2 * y["cage.angle"], 1 + 2.5 + 8, 1e-12)
    assert instance.notices == []


@formulations
def test_two_coefficients_are_a_ratio(formulation):
    """q2 = 3 q1 - 0.4, said in both ways."""
    found = []

    for linear in ({"ratio": 3, "offset": -0.4}, {"coefficients": [3, -1], "constant": 0.4}):
        body = {"a": shaft(0.2), "b": shaft(0.4)}
        joint = {"a": hinge("a", start={"angle": 0.3, "speed": 1.0}), "b": hinge("b")}
        coupling = {"c": {"linear": linear, "between": ["a", "b"], "output": ["efforts"]}}
        instance = started(coupled(body, joint, coupling, formulation))
        instance.step(0.3)
        found.append(instance.outputs().copy())

    assert np.array_equal(*found)


@pytest.mark.parametrize("seed", range(3))
def test_formulations_agree_on_random_loops(seed):
    """A coupling of all hinges and slides of a random mechanism, with a screw or hinge that closes a loop; energy stays."""
    found = []

    for formulation in ("recursive", "embedding", "augmented"):
        data = random_loops(
            seed, ["revolute", "screw"][seed % 2 :], tree=("revolute", "prismatic"), elements=False, freedoms=3,
            solver=EXACT | {"formulation": formulation},
        )  # fmt: skip
        single = [
            name for name, joint in data["joint"].items() if "revolute" in joint or "prismatic" in joint
        ]
        factors = np.random.default_rng(seed).uniform(0.5, 2, len(single)).tolist()
        data["coupling"] = {
            "all": {"linear": {"coefficients": factors}, "between": single, "output": ["efforts"]}
        }
        data["output"] = ["total_energy"]
        instance = started(data)
        energy = named_outputs(instance)["total_energy"]
        instance.step(0.2)
        y = named_outputs(instance)
        assert_near(y["total_energy"], energy, 1e-9 * max(1.0, abs(energy)))
        found.append(y["all.efforts"])
        assert np.ptp(y["all.efforts"] / factors) < 1e-9 * np.abs(y["all.efforts"]).max()

    for efforts in found[1:]:
        assert_near(efforts, found[0], 1e-8 * np.abs(found[0]).max())


def test_structure_of_a_differential():
    found = Scene.model_validate(differential("recursive")).structure()
    assert found.freedom == 2


@pytest.mark.parametrize(
    "between, linear, said",
    [
        (["left", "right", "cage"], {"ratio": 2}, "a ratio is between two joints, found 3 of them; write coefficients instead"),
        (["left", "right", "cage"], {"coefficients": [1, 1]}, "needs a coefficient for each joint, found 2 for 3 joints"),
        (["left", "right", "cage"], {"coefficients": [1, 0, 2]}, "coefficients: [2] is 0: leave its joint out"),
        (["left", "right", "cage"], {"coefficients": 2}, "coefficients: needs a number for each joint, as in [1, 1, -2]; found 2"),
        (["left", "right", "left"], {"coefficients": [1, 1, 2]}, 'two of them are "left"; a coupling is between different joints'),
        (["left"], {"coefficients": [1]}, 'needs two or more joints, as in ["left", "right", "cage"]; found ["left"]'),
        (["left", "right", "free"], {"coefficients": [1, 1, 2]},
         '"free" is not "revolute" or "prismatic", as the third joint of linear must be'),
        (["left", "right", "cags"], {"coefficients": [1, 1, 2]}, 'no joint "cags"'),
        (["left", "right"], {}, 'linear: needs "ratio" or "coefficients"'),
        (["left", "right"], {"coefficients": [1, 1], "offset": 1}, '"offset" goes with "ratio"; write "constant" instead'),
        (["left", "right"], {"ratio": 1, "constant": 1}, '"constant" goes with "coefficients"; write "offset" instead'),
    ],
)  # fmt: skip
def test_what_cannot_be_meant_is_refused(between, linear, said):
    scene = differential("recursive")
    scene["body"]["f"] = shaft(1.0)
    scene["joint"]["free"] = {"free": {}, "between": ["ground", "f"]}
    scene["coupling"]["bevels"] = {"linear": linear, "between": between}

    with pytest.raises(SceneError) as failure:
        Scene.model_validate(scene)

    assert said in str(failure.value) and "[coupling.bevels]" in str(failure.value)


def test_couplings_that_contradict_each_other_are_told():
    """Not as a loop whose ends are apart: by how much the sum of its joints' positions is off."""
    block = {"mass": 1.0, "inertia": [1, 1, 1]}
    ropes = {
        name: {"linear": {"ratio": 2.0, "offset": offset}, "between": ["left", "right"]}
        for name, offset in {"one": 0.1, "two": 0.3}.items()
    }
    scene = Scene(
        name="ropes",
        body={"a": block, "b": block},
        joint={
            "left": {"prismatic": {}, "between": ["ground", "a"], "start": {"position": 1.0}},
            "right": {"prismatic": {}, "between": ["ground", "b"], "start": {"position": 0.5}},
        },
        coupling=ropes,
    )
    said = r"one cannot be kept together with what else holds its joints; one stays off by 0\.1 .*: of left, right"

    with pytest.raises(SimulationError, match=said):
        Instance(compile_scene(scene))
