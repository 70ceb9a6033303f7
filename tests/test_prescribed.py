"""A joint whose six coordinates are prescribed: poses in closed form, efforts by Newton's and Euler's laws and by energy."""

import numpy as np
import pytest
from fmu_host import OK, Library
from fmu_host import Instance as FmuInstance
from scenes import assert_near
from scipy.spatial.transform import Rotation
from test_contacts import columns

from mbdfmi import Scene, SceneError
from mbdfmi.compiler.model import compile_scene
from mbdfmi.export import export_fmu
from mbdfmi.run.instance import Instance
from mbdfmi.run.simulate import simulate

formulations = pytest.mark.parametrize("formulation", ["recursive", "embedding", "augmented"])
EXACT = {"integrator": "rk853", "tolerance": 1e-11}
BODY = {"mass": 2.0, "inertia": [0.3, 0.4, 0.5], "com": [0.1, 0.2, 0.3]}
OUTPUT = [
    "position",
    "velocity",
    "zyx_rate",
    "euler_parameters",
    "driver_force",
    "driver_torque",
    "reaction_force",
    "reaction_moment",
]
DRIVER = {
    "x": {"harmonic": {"amplitude": 0.3, "frequency": 0.7}},
    "y": {"ramp": {"time": [0.1, 0.5], "position": [0.2, -0.1]}},
    "yaw": {"polynomial": {"coefficients": [0.2, 1.0, 0.5]}},
    "pitch": {"harmonic": {"amplitude_deg": 110, "frequency": 0.8}},
    "roll": {"constant_speed": 0.6},
}
START = {"position": [0, 0, 1.0], "zyx_deg": [0, 0, 30]}


def platform(formulation="recursive", between=("ground", "p"), driver=None, **tables):
    joint = {"prescribed": {}, "between": between, "driver": driver or DRIVER, "output": OUTPUT}
    joint |= {} if driver else {"start": START}
    body = {"p": BODY | {"output": ["acceleration", "omega_body", "alpha_body", "euler_parameters"]}}
    return {
        "name": "platform", "solver": EXACT | {"formulation": formulation}, "body": body, "joint": {"move": joint},
        "output": ["total_energy", "driver_power"],
    } | tables  # fmt: skip


def run(scene, until=0.6, step=0.05):
    return simulate(compile_scene(Scene.model_validate(scene)), until, step)


def told(t):
    """Positions (n, 3) and yaw, pitch, roll (n, 3) that DRIVER asks for."""
    s = np.clip((t - 0.1) / 0.4, 0, 1)
    y = 0.2 - 0.3 * (10 * s**3 - 15 * s**4 + 6 * s**5)
    place = np.column_stack([0.3 * np.sin(2 * np.pi * 0.7 * t), y, 1.0 + 0 * t])
    turn = [0.2 + t + 0.5 * t * t, np.radians(110) * np.sin(2 * np.pi * 0.8 * t), np.pi / 6 + 0.6 * t]
    return place, np.column_stack(turn)


@formulations
@pytest.mark.parametrize("backwards", [False, True])
def test_the_pose_is_as_told_and_what_drives_it_bears_the_body(formulation, backwards):
    """Also past a pitch of 90 deg, and where the tree leads through the joint backwards."""
    results = run(platform(formulation, ("p", "ground") if backwards else ("ground", "p")))
    place, turn = told(results["time"])
    A = Rotation.from_euler("ZYX", turn).as_matrix()
    assert_near(columns(results, "move.position", 3), place, 1e-13)
    assert_near(Rotation.from_quat(columns(results, "move.euler_parameters", 4)).as_matrix(), A, 1e-13)

    # Newton's law of the body, about the second marker's origin; what acts on the first is the contrary
    B = Rotation.from_quat(columns(results, "p.euler_parameters", 4)).as_matrix()
    w, alpha = columns(results, "p.omega_body", 3), columns(results, "p.alpha_body", 3)
    lever = np.cross(alpha, BODY["com"]) + np.cross(w, np.cross(w, BODY["com"]))
    force = 2.0 * (columns(results, "p.acceleration", 3) + np.einsum("nij,nj->ni", B, lever) + [0, 0, 9.81])
    force = -np.einsum("nji,nj->ni", B, force) if backwards else force
    assert_near(columns(results, "move.reaction_force", 3), force, 1e-9)
    assert_near(columns(results, "move.driver_force", 3), force, 1e-9)

    # efforts are along the coordinates: their power is that of the drivers
    rates = np.einsum(
        "nij,nj->ni",
        np.array(
            [
                [
                    [0, -np.sin(a), np.cos(a) * np.cos(b)],
                    [0, np.cos(a), np.sin(a) * np.cos(b)],
                    [1, 0, -np.sin(b)],
                ]
                for a, b, _ in turn
            ]
        ).transpose(0, 2, 1),
        columns(results, "move.reaction_moment", 3),
    )
    assert_near(columns(results, "move.driver_torque", 3), rates, 1e-9)


@formulations
def test_what_hangs_on_it_feels_it_and_energy_is_kept(formulation):
    """The change of energy is what the drivers supply."""
    scene = platform(formulation)
    scene["body"]["p"]["marker"] = {"m": {"position": [0.3, 0.1, 0.2]}}
    scene["body"]["q"] = {"mass": 1.0, "inertia": [0.1, 0.2, 0.3], "com": [0, 0, -0.5]}
    hinge = {"revolute": {"axis": "y"}, "between": ["p.m", "q"], "start": {"angle": 0.3}, "output": ["angle"]}
    scene["joint"]["hinge"] = hinge
    results = run(scene, 0.32, 0.01)
    energy, power = results["total_energy"], results["driver_power"]
    # Simpson's rule over pairs of steps
    supplied = np.cumsum((power[:-2:2] + 4 * power[1:-1:2] + power[2::2]) * 0.01 / 3)
    assert_near(energy[2::2] - energy[0], supplied, 2e-4 * np.abs(supplied).max())
    assert np.ptp(results["hinge.angle"]) > 0.05


@formulations
def test_an_end_frame_without_mass_carries_a_curve(formulation):
    """A curve that moves in its body: a bead slides on a ring that spins about the vertical, ever faster."""
    curve = {"curve": {"circle": {"radius": 0.5}}, "axes": {"x": "x", "y": "z"}}
    scene = platform(formulation, driver={"yaw": {"polynomial": {"coefficients": [0, 1.0, 2.0]}}})
    scene["body"] = {
        "p": {"mass": 0.0, "marker": {"ring": curve}},
        "b": {"mass": 1.3, "inertia": [0.1, 0.1, 0.1]},
    }
    scene["joint"] |= {
        "free": {"free": {}, "between": ["p", "b"], "start": {"position": [0.5, 0, 0]}},
        "bead": {"point_on_curve": {}, "between": ["p.ring", "b"], "output": ["s", "s_rate"]},
        "turn": {"translation": {}, "between": ["ground", "b"]},
    }
    del scene["joint"]["free"]
    results = run(scene, 0.3, 0.05)
    angle, rate = results["bead.s"] / 0.5, results["bead.s_rate"] / 0.5
    t = results["time"]
    w = 1.0 + 4.0 * t
    assert_near(results["move.zyx_rate[1]"], w, 1e-12)

    # about the vertical: d/dt(m r^2 cos^2 phi w), and the energy supplied is that times w
    inertia = 1.3 * 0.25 * np.cos(angle) ** 2
    torque = inertia * 4.0 - 2 * 1.3 * 0.25 * np.cos(angle) * np.sin(angle) * rate * w
    assert_near(results["move.driver_torque[1]"], torque, 1e-9)
    assert_near(results["driver_power"], torque * w, 1e-8)


def test_all_that_is_not_driven_is_held():
    results = run(platform(driver={"z": {"harmonic": {"amplitude": 0.1, "frequency": 1}}}), 0.2, 0.1)
    assert_near(columns(results, "move.position", 3)[:, :2], 0, 1e-15)
    assert_near(columns(results, "move.euler_parameters", 4)[:, :3], 0, 1e-15)


def test_what_is_refused():
    with pytest.raises(SceneError, match='needs one of "x", "y"'):
        Scene.model_validate(
            platform() | {"joint": {"move": {"prescribed": {}, "between": ["ground", "p"], "driver": {}}}}
        )

    scene = platform()
    scene["joint"]["move"]["start"] = {"position": [0.1, 0, 0]}
    with pytest.raises(SceneError, match='the driver of "x" says where it starts; drop it from the start'):
        Scene.model_validate(scene)

    scene = platform()
    scene["joint"]["again"] = scene["joint"]["move"]
    with pytest.raises(SceneError, match=r"\[joint\.again\] all joints of this loop are prescribed"):
        compile_scene(Scene.model_validate(scene))


def test_commanded_in_an_fmu(tmp_path):
    """Each coordinate by inputs of its own; to the bits of a run in process."""
    driver = {"x": {"input": ["position"]}, "yaw": {"input": ["position", "speed"]}}
    model = compile_scene(Scene.model_validate(platform(driver=driver)))
    names = ["move.x.position_command", "move.yaw.angle_command", "move.yaw.speed_command"]
    assert [v.name for v in model.of_causality("input")] == names
    here = Instance(model)
    fmu = FmuInstance(Library(export_fmu(model, tmp_path / "platform.fmu"), tmp_path / "unpacked"))
    fmu.start()

    for k in range(3):
        command = dict(zip(names, [0.02 * k, 0.1 * k, 1.0]))
        fmu.set(command)
        here.u[: len(names)] = list(command.values())
        assert fmu.step(0.1 * k, 0.1) == OK
        here.step(0.1)
        assert np.array_equal(fmu.outputs(), here.outputs())

    fmu.free()
