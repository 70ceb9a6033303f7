"""Local variables of FMUs: how joints and bodies move and what they bear, beside the outputs of the scene."""

import re

import fmpy
import numpy as np
import pytest
from fmu_host import ERROR, OK, Instance, Library

from mbdfmi import Scene
from mbdfmi.compiler import survey
from mbdfmi.compiler.model import compile_scene
from mbdfmi.compiler.variables import array_of
from mbdfmi.export import export_fmu
from mbdfmi.scene import read_scene
from tests.model_files import SCENES

STEPS, H = 3, 0.02  # s


def exported(scene, folder, **options):
    model = compile_scene(scene)
    path = export_fmu(model, folder / f"{model.identifier}.fmu", **options)
    return model, Library(path, folder / "it")


def run(library):
    """An instance after some steps."""
    fmu = Instance(library).start()
    for k in range(STEPS):
        assert fmu.step(k * H, H) == OK
    return fmu


def words_of(model, owner):
    return sorted({array_of(v.name).rpartition(".")[2] for v in model.told_aside if v.name.startswith(owner)})


def with_outputs(scene, model):
    """The scene with outputs for locals; an undriven joint has no effort of its own to tell."""
    told = scene.model_copy(deep=True)
    for kind in (told.joint, told.body):
        for name, part in kind.items():
            found = words_of(model, f"{survey.dotted(name)}.")
            if not getattr(part, "driver", None):
                found = [word for word in found if word != "effort"]
            part.output = sorted({*part.output, *found})
    return Scene.model_validate(told.model_dump(exclude_unset=True, by_alias=True))


@pytest.mark.parametrize("path", SCENES, ids=lambda path: path.stem)
def test_they_are_what_outputs_would_be(path, tmp_path):
    """Of every scene, after some steps; angles that close loops are told without their turns."""
    scene = read_scene(path)
    (tmp_path / "plain").mkdir()
    (tmp_path / "told").mkdir()
    model, library = exported(scene, tmp_path / "plain")
    other, told = exported(with_outputs(scene, model), tmp_path / "told")
    known = {v.name for v in other.of_causality("output")}
    names = [v.name for v in model.told_aside if v.name in known]
    assert len(names) > 0.5 * len(model.told_aside) or not names

    fmu, reference = run(library), run(told)
    assert fmu.outputs() == pytest.approx(
        [reference.value(v.name) for v in model.of_causality("output")], rel=1e-9, abs=1e-9
    )
    found, expected = (np.array(it.get(*names)[1]) for it in (fmu, reference))
    angles = np.array([v.description.endswith("180 deg") for v in model.told_aside if v.name in known], bool)
    off = np.where(angles, np.remainder(found - expected + np.pi, 2 * np.pi) - np.pi, found - expected)
    size = np.maximum(1, np.abs(expected)) if not names else np.maximum(1, np.abs(expected).max())
    assert np.abs(off / size).max(initial=0) < 1e-8
    fmu.free()
    reference.free()


def pendulum(n=2, **first):
    """A chain of rods on revolute joints, with dampers."""
    body = {
        f"b{k}": {
            "mass": 1.0,
            "inertia": [0.1, 0.1, 0.1],
            "com": [0.5, 0, 0],
            "marker": {"tip": {"position": [1, 0, 0]}},
        }
        for k in range(n)
    }
    ends = ["ground", *(f"b{k}.tip" for k in range(n))]
    joint = {f"j{k}": {"revolute": {}, "between": [ends[k], f"b{k}"], "damper": 0.1} for k in range(n)}
    joint["j0"] |= first
    return Scene(name="rods", gravity=[0, -9.81, 0], body=body, joint=joint)


def test_effort_is_all_that_acts_in_a_joint_without_driver(tmp_path):
    """Spring, damper, friction and input of a joint, by numbers; of a driven one the driver's."""
    acting = {
        "spring": {"stiffness": 3.0},
        "friction": {"coulomb": 0.2, "static": 0.2},
        "input": ["torque"],
        "output": ["angle", "speed", "friction_effort"],
    }
    model, library = exported(pendulum(1, **acting), tmp_path)
    fmu = Instance(library)
    assert fmu.setup() == fmu.enter() == fmu.exit() == OK
    assert fmu.set({"j0.torque": 0.7}) == OK and fmu.step(0.0, 0.1) == OK
    angle, speed, friction, effort = fmu.get("j0.angle", "j0.speed", "j0.friction_effort", "j0.effort")[1]
    assert effort == pytest.approx(0.7 - 3.0 * angle - 0.1 * speed + friction, rel=1e-12)
    fmu.free()


def test_reactions_carry_the_rods(tmp_path):
    """At rest, hanging: each joint bears what hangs on it."""
    hang = {"start": {"angle_deg": -90}}
    model, library = exported(pendulum(3, **hang), tmp_path)
    fmu = run(library)
    for k in range(3):
        force = fmu.get(*(f"j{k}.reaction_force[{i}]" for i in (1, 2, 3)))[1]
        assert np.linalg.norm(force) == pytest.approx((3 - k) * 9.81, rel=1e-6)
    fmu.free()


@pytest.mark.parametrize("fmi", (2, 3))
def test_they_are_described(fmi, tmp_path):
    """Units, types, names from 1, no start values, arrays in FMI 3; what is an output is no local too."""
    scene = pendulum(output=["angle"])
    path = export_fmu(compile_scene(scene), tmp_path / "it.fmu", fmi=fmi)
    description = fmpy.read_model_description(str(path), validate=True)
    variables = {v.name: v for v in description.modelVariables}
    one = variables["b0.position" if fmi == 3 else "b0.position[1]"]
    assert (one.causality, one.variability, one.unit or one.declaredType.unit) == ("local", "continuous", "m")
    assert one.start is None and one.initial in (None, "calculated")
    assert variables["j1.speed"].declaredType.name == "AngularVelocity"
    assert variables["j0.angle"].causality == "output" and variables["j1.angle"].causality == "local"
    assert variables["j1.angle"].displayUnit == "deg"
    assert ("b0.euler_parameters" in variables) == (fmi == 3)
    assert all(
        re.search(r"\[1\]$", v) or f"{v[:-2]}{int(v[-2]) - 1}]" in variables
        for v in variables
        if re.search(r"\[\d\]$", v)
    )


def test_lean_leaves_them_out(tmp_path):
    scene = pendulum()
    (tmp_path / "lean").mkdir()
    whole, library = exported(scene, tmp_path)
    _, lean = exported(scene, tmp_path / "lean", lean=True)
    assert len(library.variables) == len(lean.variables) + len(whole.told_aside)
    assert "b0.position[1]" in library.variables and "b0.position[1]" not in lean.variables
    one, other = run(library), run(lean)
    names = [v.name for v in lean.description.modelVariables]
    assert one.get(*names) == other.get(*names)
    one.free()
    other.free()


def test_they_cost_nothing_unread(tmp_path):
    """A state is as long with them as without, and a step the same bits; reading changes neither."""
    scene = pendulum()
    (tmp_path / "lean").mkdir()
    model, library = exported(scene, tmp_path)
    _, lean = exported(scene, tmp_path / "lean", lean=True)
    read, unread, without = run(library), run(library), run(lean)
    assert read.get(*(v.name for v in model.told_aside))[0] == OK
    for fmu in (read, unread, without):
        assert fmu.step(STEPS * H, H) == OK
    states = [fmu.serialise(fmu.save()) for fmu in (read, unread, without)]
    assert states[0] == states[1] and len(states[1]) == len(states[2])
    for fmu in (read, unread, without):
        fmu.free()


def test_what_cannot_be_done_with_them(tmp_path):
    model, library = exported(pendulum(input=["torque"]), tmp_path)
    fmu = Instance(library)
    assert fmu.get("b0.omega[3]")[0] == ERROR
    assert fmu.setup() == fmu.enter() == fmu.exit() == OK
    assert fmu.set({"b0.omega[3]": 1.0}) == ERROR and "is calculated and cannot be set" in fmu.message
    assert fmu.get("b0.omega[3]")[0] == OK
    fmu.free()


def test_too_many_are_told_and_left_out(tmp_path, monkeypatch):
    told = []
    monkeypatch.setattr(survey, "MOST_LOCALS", 40)
    export_fmu(compile_scene(pendulum()), tmp_path / "it.fmu", progress=told.append)
    assert any("without efforts and reactions of joints" in text for text in told)
    names = {v.name for v in fmpy.read_model_description(str(tmp_path / "it.fmu")).modelVariables}
    assert "b1.omega[3]" in names and "j1.effort" not in names
    monkeypatch.setattr(survey, "MOST_LOCALS", 10)
    export_fmu(compile_scene(pendulum()), tmp_path / "it.fmu", progress=told.append)
    assert any("without local variables" in text for text in told)


def test_a_joint_and_a_body_of_one_name(tmp_path):
    """Each name is once there: the joint has it."""
    body = {"arm": {"mass": 1.0, "inertia": [0.1, 0.1, 0.1]}}
    joint = {"arm": {"prismatic": {}, "between": ["ground", "arm"]}}
    model, library = exported(Scene(name="one", body=body, joint=joint), tmp_path)
    assert fmpy.read_model_description(str(tmp_path / "one.fmu"), validate=True)
    assert (
        library.variables["arm.position"].description == "position of arm"
        and "arm.position[1]" not in library.variables
    )
    assert "arm.omega[1]" in library.variables
    fmu = run(library)
    assert fmu.value("arm.speed") == pytest.approx(-9.81 * STEPS * H)
    fmu.free()
