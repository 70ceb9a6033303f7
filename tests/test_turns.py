"""Angles of joints outside the tree: on the right turn at any speed, step and communication step."""

import numpy as np
import pytest
from fmu_host import OK, Library
from fmu_host import Instance as Hosted

from mbdfmi import Scene
from mbdfmi.compiler.model import compile_scene
from mbdfmi.run.instance import Instance

FORMULATIONS = ["recursive", "embedding", "augmented"]
formulations = pytest.mark.parametrize("formulation", FORMULATIONS)

# each with the longest step at which it is to be tried
SOLVERS = {
    "auto": {},
    "rk54": {},
    "rk853": {},
    "radau": {},
    "rk4": {"step": 0.25},
    "ros2": {"step": 0.25},
    "gauss": {"step": 0.25},
}
solvers = pytest.mark.parametrize("integrator", SOLVERS)


def body(inertia=1e-2, **more):
    """A body of 1 kg."""
    return {"mass": 1.0, "inertia": [inertia] * 3} | more


def gear_in_a_loop(carrier=10.0, sun=40.0, ratio=-1.0, **solver):
    """A gear on a hinge between carrier and sun, which closes a loop. Nothing acts: all speeds stay."""
    return Scene(
        name="gear in a loop",
        gravity=[0, 0, 0],
        solver=solver,
        body={"carrier": body(), "sun": body(1e-3), "planet": body(1e-3)},
        joint={
            "carrier": {
                "revolute": {},
                "between": ["ground", "carrier"],
                "start": {"speed": carrier},
                "output": ["angle"],
            },
            "planet": {"revolute": {}, "between": ["carrier", "planet"], "output": ["angle"]},
            "sun": {
                "revolute": {},
                "between": ["ground", "sun"],
                "start": {"speed": sun},
                "output": ["angle"],
            },
            "between": {"revolute": {}, "between": ["carrier", "sun"], "output": ["angle"]},
        },
        coupling={"mesh": {"gear": {"ratio": ratio}, "between": ["between", "planet"]}},
    )


@solvers
@pytest.mark.parametrize("carrier, sun, ratio", [(10.0, 40.0, -1.0), (-60.0, 250.0, 2.5)])
def test_a_gear_in_a_loop_keeps_its_speeds(integrator, carrier, sun, ratio):
    scene = gear_in_a_loop(carrier, sun, ratio, integrator=integrator, **SOLVERS[integrator])
    r = scene.simulate(until=4.0, step=1.0)
    t = r["time"]
    seen = [r[f"{name}.angle"] for name in ("carrier", "sun", "between", "planet")]
    right = [carrier * t, sun * t, (sun - carrier) * t, ratio * (sun - carrier) * t]
    np.testing.assert_allclose(seen, right, atol=1e-6)


@pytest.mark.parametrize("integrator", ["auto", "radau"])
def test_the_same_in_absolute_coordinates(integrator):
    scene = gear_in_a_loop(integrator=integrator, formulation="augmented", tolerance=1e-7)
    r = scene.simulate(until=2.0, step=1.0)
    seen = [r[f"{name}.angle"] for name in ("carrier", "sun", "between", "planet")]
    np.testing.assert_allclose(seen, np.outer([10, 40, 30, -30], r["time"]), atol=1e-4)


# what acts along such an angle


def rotors(joint, outside, **tables):
    """Two rotors on one axis, the second also on a hinge with the first: that hinge is outside the tree, or the second's own."""
    between = {
        "revolute": {},
        "between": ["one", "two"],
        "output": ["angle", "speed", "acceleration"],
    } | joint
    ground = {
        "one": {"revolute": {}, "between": ["ground", "one"], "start": {"speed": 5}, "output": ["angle"]},
        "two": {"revolute": {}, "between": ["ground", "two"], "start": {"speed": 45}, "output": ["angle"]},
    }
    order = ground | {"hinge": between} if outside else {"hinge": between | {"start": {"speed": 40}}} | ground
    scene = {"name": "rotors", "gravity": [0, -9.81, 0], "joint": order}
    scene["body"] = {"one": body(2e-2, com=[0.02, 0, 0]), "two": body(1e-2, com=[0, 0.01, 0])}
    return Scene.model_validate(scene | tables)


ELEMENTS = {
    "spring": {"spring": {"stiffness": 0.02, "rest": 7.0}},
    "hardening": {"spring": {"table": {"position": [-40, 0, 10, 60], "effort": [-1, 0, 0.3, 2.0]}}},
    "stop": {"stop": {"lower": -3.0, "upper": 22.0, "stiffness": 5.0, "damping": 0.01}},
    "friction": {"friction": {"coulomb": 0.05, "smoothing_speed": 0.5}},
    "damper": {"damper": 0.005, "spring": {"stiffness": 0.01}},
}


@pytest.mark.parametrize("element", ELEMENTS)
def test_what_acts_there_is_what_acts_in_the_tree(element):
    runs = []

    for outside in (True, False):
        scene = rotors(ELEMENTS[element], outside, output=["total_energy"])
        assert ("hinge" in compile_scene(scene).tree.cuts) == outside
        runs.append(scene.simulate(until=3.0, step=0.5))

    for name in ("hinge.angle", "hinge.speed", "one.angle", "total_energy"):
        np.testing.assert_allclose(runs[0][name], runs[1][name], atol=1e-3)

    assert np.ptp(runs[0]["hinge.angle"]) > 4 * np.pi


@pytest.mark.parametrize("integrator", ["auto", "radau"])
def test_a_spring_wound_over_many_turns(integrator):
    """Two rotors on a soft spring: the angle between them is a sine of 40 rad / s over its frequency, in closed form."""
    scene = rotors(
        {"spring": {"stiffness": 0.02}}, True, solver={"integrator": integrator}, gravity=[0, 0, 0]
    )
    one, two = 2e-2 + 0.02**2, 1e-2 + 0.01**2
    w = np.sqrt(0.02 * (1 / one + 1 / two))
    r = scene.simulate(until=8.0, step=1.0)
    np.testing.assert_allclose(r["hinge.angle"], 40 / w * np.sin(w * r["time"]), atol=1e-4)


DRIVERS = {
    "constant_speed": ({"constant_speed": 40.0}, lambda t: 40.0 * t),
    "harmonic": (
        {"harmonic": {"amplitude": 30.0, "frequency": 0.5, "mean": 100.0}},
        lambda t: 100 + 30 * np.sin(np.pi * t),
    ),
}


@pytest.mark.parametrize("driver", DRIVERS)
def test_a_driven_hinge_outside_the_tree(driver):
    spec, right = DRIVERS[driver]
    joint = {"revolute": {}, "between": ["ground", "a"], "driver": spec, "output": ["angle"]}
    scene = Scene(
        name="driven",
        body={"a": body()},
        joint={"j": joint},
        solver={"formulation": "augmented", "tolerance": 1e-6},
    )
    r = scene.simulate(until=1.5, step=0.5)
    np.testing.assert_allclose(r["j.angle"], right(r["time"]), atol=1e-9)


KINDS = {
    "cylindrical": ({"start": {"angular_speed": 40.0}}, "angle"),
    "screw": ({"start": {"angular_speed": 40.0}}, "angle"),
    "planar": ({"start": {"angular_speed": 40.0}}, "angle"),
    "universal": ({"start": {"speeds": [0.0, 40.0]}}, "angles[2]"),
}


@pytest.mark.parametrize("kind", KINDS)
def test_angles_of_other_joints(kind):
    """A round body that spins on: 40 rad/s times the time."""
    more, name = KINDS[kind]
    options = {"pitch": 0.01} if kind == "screw" else {}
    joint = {kind: options, "between": ["ground", "a"], "output": [name.partition("[")[0]]} | more
    solver = {"formulation": "augmented", "tolerance": 1e-7}
    scene = Scene(name=kind, gravity=[0, 0, 0], body={"a": body()}, joint={"j": joint}, solver=solver)
    r = scene.simulate(until=2.0, step=1.0)
    np.testing.assert_allclose(r[f"j.{name}"], 40.0 * r["time"], atol=1e-4)


# starts


@formulations
@pytest.mark.parametrize("first, second", [(30.0, 300.0), (1800.0, 90.0), (-75.0, 1234.0)])
def test_starts_beyond_a_turn(formulation, first, second):
    scene = Scene(
        name="pair",
        gravity=[0, 0, 0],
        solver={"formulation": formulation},
        body={"a": body(), "b": body()},
        joint={
            "a": {
                "revolute": {},
                "between": ["ground", "a"],
                "start": {"angle_deg": first, "speed": 4},
                "output": ["angle"],
            },
            "b": {
                "revolute": {},
                "between": ["ground", "b"],
                "start": {"angle_deg": second},
                "output": ["angle"],
            },
        },
        coupling={"mesh": {"gear": {"ratio": 10.0}, "between": ["a", "b"]}},
    )
    r = scene.simulate(until=1.0, step=0.5)
    np.testing.assert_allclose(r["a.angle"], np.radians(first) + 4 * r["time"], atol=1e-6)
    np.testing.assert_allclose(r["b.angle"], np.radians(second) + 40 * r["time"], atol=1e-5)
    assert scene.structure().freedom == 1


@formulations
def test_a_coupled_joint_without_a_start_is_found_turns_away(formulation):
    """The coupling's offset and the first joint's start say where the second stands, more than a turn from zero."""
    scene = Scene(
        name="pair",
        gravity=[0, 0, 0],
        solver={"formulation": formulation},
        body={"a": body(), "b": body()},
        joint={
            "a": {"revolute": {}, "between": ["ground", "a"], "start": {"angle": 1.0}, "output": ["angle"]},
            "b": {"revolute": {}, "between": ["ground", "b"], "output": ["angle"]},
        },
        coupling={"mesh": {"gear": {"ratio": 3.0, "offset": 8.0}, "between": ["a", "b"]}},
    )
    r = scene.simulate(until=0.1)
    assert abs(r["a.angle"][0] - 1.0) < 1e-9
    assert abs(r["b.angle"][0] - 11.0) < 1e-9


# snapshots


@pytest.mark.parametrize("integrator", ["auto", "radau", "gauss"])
def test_the_turn_is_part_of_the_state(integrator):
    """A state goes on to the same bits in an instance that was never there."""
    solver = {"integrator": integrator, **SOLVERS[integrator]}
    model = compile_scene(rotors(ELEMENTS["spring"], True, solver=solver))
    first, second = Instance(model), Instance(model)
    first.step(1.0)
    first.step(0.37)
    second.d.state_buffer[:] = first.d.state_buffer
    assert np.abs(first.outputs()).max() > 4 * np.pi

    for _ in range(3):
        first.step(0.5)
        second.step(0.5)
        assert (first.outputs() == second.outputs()).all()


def test_an_fmu_goes_back_to_the_right_turn(tmp_path):
    """Saved, taken on, restored: the same again, and in process; reset: as at first."""
    scene = rotors(ELEMENTS["spring"], True)
    library = Library(scene.export(tmp_path / "rotors.fmu"), tmp_path / "rotors")
    fmu = Hosted(library).start()
    assert fmu.step(0.0, 1.0) == OK
    snapshot = fmu.save()
    seen = []

    for _ in range(2):
        assert fmu.step(1.0, 1.0) == fmu.step(2.0, 1.0) == OK
        seen.append(fmu.outputs())
        assert fmu.restore(snapshot) == OK

    assert seen[0] == seen[1]
    fmu.free()


# parameters of contacts turn as well


SHAPES = {
    "sphere": {"sphere": {"radius": 0.5}},
    "cylinder": {"cylinder": {"radius": 0.5}},
    "torus": {"torus": {"radius": 0.4, "tube": 0.1}},
}


@pytest.mark.parametrize("shape", SHAPES)
@pytest.mark.parametrize("speed", [40.0, -250.0])
def test_parameters_of_a_turning_surface(shape, speed):
    """A rotor turns under a point at rest: the point's longitude on it falls by the rotor's angle."""
    scene = Scene(
        name=shape,
        gravity=[0, 0, 0],
        ground={"marker": {"p": {"position": [0.5, 0, 0]}}},
        body={
            "rotor": body(marker={"s": {"surface": SHAPES[shape]}}),
            "point": body(),
        },
        joint={
            "rotor": {"revolute": {}, "between": ["ground", "rotor"], "start": {"speed": speed}},
            "hold": {"prismatic": {"axis": "x"}, "between": ["ground.p", "point"]},
            "touch": {"point_on_surface": {}, "between": ["rotor.s", "point"], "output": ["s"]},
        },
    )
    r = scene.simulate(until=2.0, step=1.0)
    np.testing.assert_allclose(r["touch.s"][:, 0], -speed * r["time"], atol=1e-4)


def test_the_parameter_of_a_turning_ring():
    """The same of a circle: its parameter is the way along it."""
    scene = Scene(
        name="ring",
        gravity=[0, 0, 0],
        body={"rotor": body(marker={"s": {"curve": {"circle": {"radius": 0.5}}}}), "point": body()},
        joint={
            "rotor": {"revolute": {}, "between": ["ground", "rotor"], "start": {"speed": 100.0}},
            "hold": {"prismatic": {"axis": "x"}, "between": ["ground", "point"], "start": {"position": 0.5}},
            "touch": {"point_on_curve": {}, "between": ["rotor.s", "point"], "output": ["s"]},
        },
    )
    r = scene.simulate(until=2.0, step=1.0)
    np.testing.assert_allclose(r["touch.s"], -50.0 * r["time"], atol=1e-4)
