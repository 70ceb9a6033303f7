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
PAGES = [*sorted(ROOT.glob("*.md")), *sorted((ROOT / "docs").glob("*.md"))]


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


def anchors(page):
    """Anchors of a page's headings, as GitHub makes them."""
    text = re.sub(r"^```.*?^```", "", page.read_text(encoding="utf-8"), flags=re.M | re.S)
    found = []

    for heading in re.findall(r"^#+ (.+)$", text, re.M):
        name = re.sub(r"[^\w\- ]", "", heading.strip().lower()).replace(" ", "-")
        found.append(
            f"{name}-{count}"
            if (count := sum(re.fullmatch(f"{name}(-\\d+)?", f) is not None for f in found))
            else name
        )

    return found


@pytest.mark.parametrize("page", PAGES, ids=lambda path: path.name)
def test_links_lead_somewhere(page):
    text = re.sub(r"^```.*?^```|`[^`\n]*`", "", page.read_text(encoding="utf-8"), flags=re.M | re.S)

    for link in re.findall(r"\]\(([^)\s]+)\)", text):
        path, _, anchor = link.partition("#")

        if re.match(r"\w+:", link):
            continue

        target = page.parent / path if path else page
        assert target.exists(), link
        assert not anchor or anchor in anchors(target), link


def test_sections_of_the_theory_that_the_sources_name():
    numbers = set(
        re.findall(r"^##+ (\d+(?:\.\d+)?) ", (ROOT / "docs" / "theory.md").read_text(encoding="utf-8"), re.M)
    )

    for path in [*(ROOT / "mbdfmi").rglob("*.py"), *(ROOT / "tests").rglob("*.py"), *PAGES]:
        named = re.findall(
            r"docs/theory\.md,? (?:sections? )?(\d+(?:\.\d+)?)", path.read_text(encoding="utf-8")
        )
        assert set(named) <= numbers, path


def test_where_everything_is():
    """What the index of the architecture page names as code is in one of the files beside it."""
    page = ROOT / "docs" / "architecture.md"
    table = page.read_text(encoding="utf-8").partition("| looked for | open |")[2].partition("\n\n")[0]
    rows = [line.split("|")[1:3] for line in table.splitlines()[2:]]
    assert len(rows) > 25

    for what, where in rows:
        files = [page.parent / link for link in re.findall(r"\]\(([^)]+)\)", where)]
        assert 0 < len(files) <= 3, what
        text = "".join(path.read_text(encoding="utf-8") for path in files if path.is_file())

        for name in re.findall(r"`(\w+)`", what):
            assert re.search(rf"\b{name}\b", text), (name, where)


@pytest.mark.parametrize(
    "page", [README, *(ROOT / "docs" / f"{name}.md" for name in ("architecture", "contributing", "theory"))]
)
def test_files_that_the_documents_name(page):
    named = re.findall(
        r"`((?:mbdfmi|tests|docs|fmu_src|models|benchmarks)/[\w./]*)`", page.read_text(encoding="utf-8")
    )

    for path in named:
        assert (ROOT / path).exists(), path


def test_tests_that_the_documents_name():
    """Each is there; and each row of what the FMUs can do names one."""
    files = {path.name: path.read_text(encoding="utf-8") for path in (ROOT / "tests").rglob("*.py")}
    known = set(re.findall(r"^def (test_\w+)", "\n".join(files.values()), flags=re.M)) | {
        name.removesuffix(".py") for name in files
    }

    for page in PAGES:
        named = set(re.findall(r"\b(test_\w+)(?:\.py)?`", page.read_text(encoding="utf-8")))
        assert named <= known, (page.name, named - known)

    table = (
        (ROOT / "docs" / "fmi.md")
        .read_text(encoding="utf-8")
        .partition("held by |\n")[2]
        .partition("\n\n")[0]
    )
    rows = table.splitlines()[1:]
    assert len(rows) > 40
    assert all("`test_" in row.rpartition(" | ")[2] for row in rows), rows
