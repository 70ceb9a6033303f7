"""The documents say what is so: their examples run, the reference is that of the schema."""

import importlib.util
import re
import shutil
import tomllib
from pathlib import Path

import pytest

import mbdfmi

ROOT = Path(__file__).parents[1]
README = ROOT / "README.md"
INTRODUCTION = ROOT / "docs" / "scene_introduction.md"


def blocks(path, language):
    return re.findall(rf"^```{language}\n(.*?)^```", path.read_text(encoding="utf-8"), re.M | re.S)


def test_reference_is_that_of_the_schema():
    spec = importlib.util.spec_from_file_location("reference", ROOT / "docs" / "make_scene_reference.py")
    module = importlib.util.module_from_spec(spec)
    spec.loader.exec_module(module)
    page = (ROOT / "docs" / "scene.md").read_text(encoding="utf-8")

    assert page == module.reference(), "run python docs/make_scene_reference.py"

    # every link in it leads somewhere
    headings = {line[3:].lower().replace(" ", "-") for line in page.splitlines() if line.startswith("## ")}
    assert set(re.findall(r"\(#([\w-]+)\)", page)) <= headings


@pytest.mark.parametrize("path", [README, INTRODUCTION])
def test_scenes_in_the_documents(path):
    for text in blocks(path, "toml"):
        scene = mbdfmi.Scene(**tomllib.loads(text))
        results = scene.simulate(0.1)
        assert len(results) > 1


def test_variables_in_the_readme():
    """Those in the table of the small scene are what it has."""
    text = README.read_text(encoding="utf-8")
    table = text[text.index("| variable | unit |") : text.index("More to start from")]
    (scene,) = blocks(README, "toml")
    names = {v.name for v in mbdfmi.Scene(**tomllib.loads(scene)).compile().variables}

    assert set(re.findall(r"`([a-z_.]+(?:\[\d\])?)`", table)) <= names


def test_python_in_the_readme(tmp_path, monkeypatch, capsys):
    monkeypatch.chdir(tmp_path)
    shutil.copytree(ROOT / "models", "models")
    names = {}

    for text in blocks(README, "python"):
        exec(text, names)

    assert names["results"]["lower.hand.position"].shape[1] == 3
    assert {path.name for path in Path().iterdir()} >= {"arm.csv", "arm.png", "arm.fmu"}
    assert mbdfmi.Scene(**tomllib.loads(capsys.readouterr().out)) == names["cart"]


def test_files_named_in_the_readme():
    for link in re.findall(r"\]\(([^)#]+)\)", README.read_text(encoding="utf-8")):
        assert (ROOT / link).exists(), link
