"""Commands import what they need: tables, force elements and packages of other scenes stay where they are."""

import inspect
import json
import subprocess
import sys
import typing

import pytest

import mbdfmi
from mbdfmi.scene import rare
from mbdfmi.scene.fields import Part

RARE = (
    *(
        f"mbdfmi.scene.{name}"
        for name in ("constraints", "couplings", "curves", "efforts", "end_frames", "forces", "lines")
    ),
    *(
        f"mbdfmi.scene.{name}"
        for name in ("measures", "motion", "prescribed", "sea", "surfaces", "tables", "trimming")
    ),
    *(f"mbdfmi.scene.{name}" for name in ("water", "wind", "import_")),
    *(
        f"mbdfmi.compiler.{name}"
        for name in ("hulls", "hydrodynamics", "lines", "sea_limits", "seas", "water", "wind")
    ),
    *(
        "mbdfmi.hydro.memory",
        "mbdfmi.aero",
        "mbdfmi.cosim",
        "mbdfmi.export",
        "mbdfmi.probe",
        "mbdfmi.trace",
        "mbdfmi.view",
    ),
    *("fmpy", "lxml", "llvmlite", "matplotlib", "numba", "scipy", "trimesh"),
)
"""Modules that `info` of a pendulum does not need; `check` looks at its looks too."""


def said_by(code, *arguments):
    """What a fresh interpreter prints (from JSON) that runs some lines."""
    command = [sys.executable, "-c", code, *arguments]
    done = subprocess.run(command, capture_output=True, text=True, check=True)
    return json.loads(done.stdout.splitlines()[-1])


@pytest.mark.parametrize(
    ("command", "needs"), [("info", ()), ("check", ("mbdfmi.view", "mbdfmi.compiler.hulls"))]
)
def test_a_pendulum_needs_no_rare_modules(command, needs):
    code = "import sys, json; from mbdfmi.cli import main; main(sys.argv[1:]); print(); print(json.dumps([*sys.modules]))"
    loaded = said_by(code, command, "models/pendulum.toml")
    assert "mbdfmi.scene.joints" in loaded
    assert [name for name in RARE if name in loaded and name not in needs] == []


def test_to_import_the_package_changes_no_environment():
    code = "import os, gc, json; a = dict(os.environ); import mbdfmi; mbdfmi.Scene; b = gc.get_freeze_count()"
    assert said_by(code + "; print(json.dumps([a == dict(os.environ), b, gc.get_threshold()[0]]))") == [
        True,
        0,
        700,
    ]


def test_a_command_that_a_program_calls_leaves_its_garbage_alone():
    code = "import gc, json; from mbdfmi.cli import main; main(['info', 'models/pendulum.toml']); print(); print(json.dumps(gc.get_threshold()[0]))"
    assert said_by(code) == 700


def test_what_is_rare_is_found_where_a_scene_has_it():
    """A fresh interpreter, in which nothing else has imported it."""
    code = """
import json, mbdfmi
scene = mbdfmi.Scene(
    name="float",
    sea={"density": 1000.0},
    body={"b": {"mass": 1.0, "inertia": [1, 1, 1], "marker": {"m": {"curve": {"circle": {"radius": 1.0}}}}}},
    joint={"j": {"free": {}, "between": ["ground", "b"]}},
    force={"f": {"catenary": {"length": 10.0, "mass": 1.0, "stiffness": 1e6}, "between": ["ground", "b"]}},
)
again = mbdfmi.Scene.model_validate(scene.model_dump(exclude_unset=True))
parts = scene.sea, scene.body["b"].marker["m"].curve, scene.force["f"]
print(json.dumps([type(part).__name__ for part in parts] + [again == scene]))
"""
    assert said_by(code) == ["Sea", "Circle", "Catenary", True]


def test_a_mistake_in_what_is_rare_is_told_at_its_place():
    body = {"mass": 1.0, "inertia": [1, 1, 1]}
    marker = {"m": {"curve": {"circle": {"radius": 0.0}}}}

    with pytest.raises(mbdfmi.SceneError) as error:
        mbdfmi.Scene(
            name="float",
            sea={"densty": 1.0},
            body={"b": body | {"marker": marker}},
            joint={"j": {"revolute": {}, "between": ["ground", "b"], "spring": {"stiffness": -1}}},
        )

    assert [problem.path for problem in error.value.problems] == [
        ("sea", "densty"),
        ("body", "b", "marker", "m", "curve", "circle", "radius"),
        ("joint", "j", "spring", "stiffness"),
    ]
    assert "density" in str(error.value)


def parts_of(cls):
    """All classes below one."""
    for below in cls.__subclasses__():
        yield below
        yield from parts_of(below)


def rare_in(annotation):
    """What stands for rare types in an annotation."""
    if isinstance(annotation, rare.Rare):
        return [annotation]
    return [found for part in typing.get_args(annotation) for found in rare_in(part)]


def test_fields_and_type_hints_name_the_classes_themselves():
    for cls in {mbdfmi.Scene, *parts_of(Part)}:
        fields = cls.model_fields.values()
        hints = typing.get_type_hints(cls, include_extras=True).values()
        assert not [found for field in fields for found in rare_in(field.annotation)], cls
        assert not [found for hint in hints for found in rare_in(hint)], cls


def test_rare_kinds_are_what_their_classes_say():
    from mbdfmi.scene.constraints import CONSTRAINTS
    from mbdfmi.scene.end_frames import END_FRAMES

    for kinds, classes in ((rare.CONSTRAINTS, CONSTRAINTS), (rare.END_FRAMES, END_FRAMES)):
        assert [kind.type for kind in kinds] == [*classes]
        assert [kind.kind for kind in kinds] == [cls.kind for cls in classes]


def test_the_schema_has_every_table():
    definitions = mbdfmi.Scene.model_json_schema()["$defs"]
    assert {"Sea", "Catenary", "RollingSurface", "AngularSpring", "CircleOptions"} <= {*definitions}
    assert json.dumps(definitions) == json.dumps(mbdfmi.Scene.model_json_schema()["$defs"])


def test_help_shows_keywords_before_a_scene_has_such_a_table():
    code = "import inspect, json, mbdfmi; print(json.dumps([*inspect.signature(mbdfmi.Scene).parameters]))"
    assert said_by(code) == [*inspect.signature(mbdfmi.Scene).parameters]
    assert "joint" in inspect.signature(mbdfmi.Scene).parameters
