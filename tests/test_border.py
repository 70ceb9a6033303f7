"""The border between Python and C: layout.h follows the tables of the package, and no array is looked for where it is not."""

import re
from dataclasses import replace
from pathlib import Path

import pytest
from fmu_host import Instance, Library

from mbdfmi.compiler import model as compiler
from mbdfmi.export import aot, description, export_fmu, header, link
from mbdfmi.export.resource import resource
from mbdfmi.kernels import layout, status
from mbdfmi.scene import read_scene

MODELS = Path(__file__).parents[1] / "models"
C_SOURCES = sorted((Path(__file__).parents[1] / "fmu_src").glob("*.[ch]"))


@pytest.fixture(scope="module")
def model():
    return compiler.compile_scene(read_scene(MODELS / "four_bar.toml"))


@pytest.fixture(scope="module")
def library(model, tmp_path_factory):
    folder = tmp_path_factory.mktemp("four_bar")
    return Library(export_fmu(model, folder / "four_bar.fmu"), folder / "four_bar")


def enumerated(text):
    """Names of the enumerations of a header -> their values."""
    found = {}

    for body in re.findall(r"enum \{(.*?)\}", text, re.DOTALL):
        value = -1
        for name, given in re.findall(r"(\w+)(?: = (-?\d+))?", body):
            value = int(given) if given else value + 1
            found[name] = value

    return found


def refusal(library, folder, data, guid):
    """What the log says of an instance with other resources; None when it is taken."""
    folder.mkdir(exist_ok=True)
    (folder / "model.bin").write_bytes(data)
    instance = Instance(library, location=folder.as_uri().encode(), guid=guid.encode(), logging=False)

    if instance.component is None:
        return instance.message

    instance.free()
    return None


# layout.h


def test_places_of_counts_and_arrays():
    values = enumerated(header.layout_header())
    assert {f"COUNT_{name}": k for k, name in enumerate(layout.COUNTS)}.items() <= values.items()
    assert {f"AT_{name}": slot for name, slot in layout.SLOT.items()}.items() <= values.items()
    assert values["HEADER_LENGTH"] == layout.HEADER_LENGTH
    assert values["CODE_STIFF"] == status.STIFF
    assert values["N_CATEGORY"] == len(description.LOG_CATEGORIES)


def test_the_header_follows_the_table(monkeypatch):
    """Two rows exchanged, as once went unnoticed: what C reads moves with them."""
    before = enumerated(header.layout_header())
    rows = list(layout.ARRAYS)
    a, b = (rows.index(layout.ROW[name]) for name in ("notice", "start_time"))
    rows[a], rows[b] = rows[b], rows[a]
    monkeypatch.setattr(layout, "ARRAYS", tuple(rows))
    after = enumerated(header.layout_header())
    assert (after["AT_notice"], after["AT_start_time"]) == (before["AT_start_time"], before["AT_notice"])
    assert after["AT_time"] == before["AT_time"]


def test_another_header_makes_another_library(monkeypatch, tmp_path):
    monkeypatch.setenv("MBDFMI_CACHE", str(tmp_path))
    monkeypatch.setattr(aot, "compile_entries", lambda: "")
    monkeypatch.setattr(link, "_link", lambda platform, kernels, file: file.write_bytes(b"library"))
    first = link.library("x86_64-linux")
    assert link.library("x86_64-linux") == first
    text = header.layout_header()
    monkeypatch.setattr(header, "layout_header", lambda: text + "\n")
    assert link.library("x86_64-linux") != first


def test_no_place_is_written_by_hand():
    """Buffers of a model are indexed by names of layout.h."""
    for path in C_SOURCES:
        assert not re.findall(r"\b(?:ints|reals|state|work)\[\d+\]", path.read_text()), path.name


def test_one_file_alone_speaks_fmi():
    """A version of FMI is a file over what all share."""
    speaking = [
        path.name
        for path in C_SOURCES
        if re.search(r"\bfmi\d\w", re.sub(r"/\*.*?\*/", "", path.read_text(), flags=re.DOTALL))
    ]
    assert speaking == ["fmi2.c"]


# arrays of a resource file


def test_arrays_outside_their_buffers_are_refused(model, library, tmp_path):
    """Even where the GUID is that of the wrong numbers."""
    assert refusal(library, tmp_path / "good", resource(model, status.MESSAGES), model.guid) is None
    wrong = {row.name: layout.SLOT[row.name] for row in layout.ARRAYS[::7]}
    wrong |= {name: layout.SLOT[name] for name in ("time", "notices", "notice", "lu_known")}
    wrong |= {name: layout.COUNTS.index(name) for name in ("n_body", "n_u", "n_y", "n_knot")}

    for name, slot in wrong.items():
        for value in (
            -1,
            2**40,
            2**62,
            -(2**63),
            len(model.ints) + len(model.reals) + model.n_state + model.n_work,
        ):
            ints = model.ints.copy()
            ints[slot] = value
            other = replace(model, ints=ints)
            other = replace(other, guid=compiler._guid(other))
            said = refusal(library, tmp_path / "bad", resource(other, status.MESSAGES), other.guid)
            assert said and "is refused: its " in said, (name, value)
