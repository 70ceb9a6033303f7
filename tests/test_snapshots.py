"""Snapshots of scenes with everything that has a memory of its own, taken over by an instance that was never started."""

import tomllib
from pathlib import Path

import pytest
from fmu_host import OK, Instance, Library

from mbdfmi import Scene
from mbdfmi.compiler.model import compile_scene
from mbdfmi.run.instance import Instance as InProcess

CORPUS = Path(__file__).parent / "referee" / "corpus"


def mechanism(formulation, integrator="rk853"):
    """A crank driven on a mount that a fixed joint holds, a four-bar loop with a sprung joint, and a bead on a circle."""
    bar = {"inertia": [0.01, 0.1, 0.1]}
    return Scene(
        name=f"mechanism {formulation}",
        solver={"integrator": integrator, "tolerance": 1e-9, "formulation": formulation},
        ground={"marker": {"right": {"position": [2, 0, 0]}}},
        body={
            "mount": {"mass": 5.0, "inertia": [1, 1, 1]},
            "crank": {"mass": 1.0, **bar, "marker": {"end": {"position": [0.5, 0, 0]}}},
            "coupler": {"mass": 2.0, **bar, "marker": {"end": {"position": [2, 0, 0]}}},
            "rocker": {
                "mass": 1.5,
                **bar,
                "marker": {
                    "end": {"position": [1, 0, 0]},
                    "ring": {"curve": {"circle": {"radius": 0.2}}},
                },
            },
            "bead": {"mass": 0.1, "inertia": [1e-4, 1e-4, 1e-4], "output": ["position"]},
        },
        joint={
            "bolt": {"fixed": {}, "between": ["ground", "mount"], "output": ["reaction_moment"]},
            "motor": {
                "revolute": {},
                "between": ["mount", "crank"],
                "driver": {"harmonic": {"amplitude": 0.7, "frequency": 0.8, "mean": 0.9}},
                "output": ["effort"],
            },
            "pin": {"revolute": {}, "between": ["crank.end", "coupler"], "start": {"angle": -0.4}},
            "foot": {
                "revolute": {},
                "between": ["ground.right", "rocker"],
                "start": {"angle_deg": 100},
                "spring": {"stiffness": 3.0},
                "output": ["angle", "acceleration"],
            },
            "top": {"revolute": {}, "between": ["coupler.end", "rocker.end"], "output": ["reaction_force"]},
            "carry": {"translation": {}, "between": ["ground", "bead"]},
            "wire": {
                "point_on_curve": {},
                "between": ["rocker.ring", "bead"],
                "start": {"s": 0.1},
                "output": ["s"],
            },
        },
        output=["total_energy"],
    )


@pytest.mark.parametrize("formulation", ["recursive", "embedding", "augmented"])
def test_a_fresh_instance_goes_on_where_another_was(formulation, tmp_path):
    scene = mechanism(formulation)
    library = Library(scene.export(tmp_path / "mechanism.fmu"), tmp_path / "mechanism")
    first = Instance(library).start()

    for i in range(20):
        assert first.step(i * 0.01, 0.01) == OK, first.log

    data = first.serialise(first.save())
    second = Instance(library)
    status, snapshot = second.deserialise(data)
    assert status == second.restore(snapshot) == OK, second.log
    assert second.outputs() == first.outputs()

    for i in range(20, 60):
        assert first.step(i * 0.01, 0.01) == second.step(i * 0.01, 0.01) == OK
        assert second.outputs() == first.outputs()

    first.free()
    second.free()


@pytest.mark.parametrize("integrator", ["auto", "radau", "rk54"])
def test_what_a_stepper_remembers_goes_along(integrator, tmp_path):
    """Continuous extension, Jacobian, step sizes: back and forth in one instance, and on in another, to the bit."""
    library = Library(
        mechanism("recursive", integrator).export(tmp_path / "mechanism.fmu"), tmp_path / "mechanism"
    )
    first, second = (Instance(library).start() for _ in range(2))
    t, results = 0.0, []

    for k in range(30):
        snapshot = first.save()
        assert first.step(t, 3e-3) == OK
        once = first.outputs()
        assert first.restore(snapshot) == first.step(t, 3e-3) == OK
        assert first.outputs() == once
        first.forget(snapshot)
        t += 3e-3
        results.append(once)

    for k in range(30):
        assert second.step(k * 3e-3, 3e-3) == OK
        assert second.outputs() == results[k]

    first.free()
    second.free()


def test_the_log_tells_that_a_motion_is_stiff(tmp_path):
    scene = Scene(
        name="door closer",
        body={"door": {"mass": 10.0, "inertia": [1, 1, 1]}},
        joint={
            "hinge": {
                "revolute": {},
                "between": ["ground", "door"],
                "spring": {"stiffness": 1e6},
                "damper": 1e6,
                "start": {"angle": 1.0},
                "output": ["angle"],
            }
        },
    )
    library = Library(scene.export(tmp_path / "door.fmu"), tmp_path / "door")
    door = Instance(library).start()
    door.log.clear()
    assert door.step(0.0, 3.0) == OK
    assert [entry[:2] for entry in door.log] == [(OK, "logEvents")]
    assert door.message.endswith("the motion is stiff: the implicit method goes on from here")
    assert door.step(3.0, 3.0) == OK
    assert len(door.log) == 1
    assert door.value("hinge.angle") == pytest.approx(2.718281828**-6, rel=1e-4)
    door.free()


@pytest.mark.parametrize("solver", [{}, {"integrator": "ros2", "step": 0.01}], ids=["auto", "ros2"])
@pytest.mark.parametrize("formulation", ["recursive", "embedding", "augmented"])
@pytest.mark.parametrize("name", ["not_quite_exact", "locked_by_hinges", "floating"])
def test_a_fresh_work_buffer_goes_on_to_the_same_bits(name, formulation, solver):
    """What counts from step to step stands in the state: another instance that gets that alone does the same."""
    tables = tomllib.loads((CORPUS / f"{name}.toml").read_text(encoding="utf-8"))
    tables.pop("referee", None)
    model = compile_scene(Scene.model_validate(tables | {"solver": {"formulation": formulation} | solver}))
    run = InProcess(model)

    for H in (0.05, 0.02, 0.1):
        other = InProcess(model)
        other.d.work_buffer[:] = 0.0

        for mine, kept in zip(
            (other.d.state_buffer, other.u, other.reals), (run.d.state_buffer, run.u, run.reals)
        ):
            mine[:] = kept

        run.step(H)
        other.step(H)
        assert run.d.state_buffer.tobytes() == other.d.state_buffer.tobytes()
