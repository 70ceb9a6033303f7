"""The border between Python and C: layout.h follows the tables of the package, and what a resource file says is checked, then believed."""

import hashlib
import re
import struct
import zlib
from ctypes import c_double, c_size_t, c_uint
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest
from fmu_host import ERROR, OK, Instance, Library

from mbdfmi.compiler import model as compiler
from mbdfmi.compiler.model import SEALED_SIZES, sealed
from mbdfmi.compiler.variables import TABLE
from mbdfmi.export import aot, description, export_fmu, header, link
from mbdfmi.export.resource import GUID_SIZE, SIZES, VERSION, resource
from mbdfmi.export.tape import tape
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


def placed(library, folder, data, guid):
    """An instance with other resources, or one that is refused."""
    folder.mkdir(exist_ok=True)
    (folder / "model.bin").write_bytes(data)
    return Instance(library, location=folder.as_uri().encode(), guid=guid.encode(), logging=False)


def refusal(library, folder, data, guid):
    """What the log says of an instance with other resources; None when it is taken."""
    instance = placed(library, folder, data, guid)

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
    a, b = (rows.index(layout.ARRAY[name]) for name in ("notice", "start_time"))
    rows[a], rows[b] = rows[b], rows[a]
    monkeypatch.setattr(layout, "ARRAYS", tuple(rows))
    after = enumerated(header.layout_header())
    assert (after["AT_notice"], after["AT_start_time"]) == (before["AT_start_time"], before["AT_notice"])
    assert after["AT_time"] == before["AT_time"]


def test_another_header_makes_another_library(monkeypatch, tmp_path):
    monkeypatch.setenv("MBDFMI_CACHE", str(tmp_path))
    monkeypatch.setattr(aot, "compile_kernels", lambda: ["", ""])
    monkeypatch.setattr(link, "link", lambda platform, kernels, file: file.write_bytes(b"library"))
    first = link.library("x86_64-linux")
    assert link.library("x86_64-linux") == first
    text = header.layout_header()
    monkeypatch.setattr(header, "layout_header", lambda: text + "\n")
    assert link.library("x86_64-linux") != first


def test_no_place_is_written_by_hand():
    """Buffers of a model are indexed by names of layout.h."""
    for path in C_SOURCES:
        assert not re.findall(r"\b(?:ints|reals|state|work)\[\d+\]", path.read_text()), path.name


def test_files_of_a_version_alone_speak_its_fmi():
    """A version of FMI is a few files, named by it, over what all share."""
    spoken = {
        path.name: set(
            re.findall(r"\bfmi\d(?=\w)", re.sub(r"/\*.*?\*/", "", path.read_text(), flags=re.DOTALL))
        )
        for path in C_SOURCES
    }
    named = {name: set(re.findall(r"^fmi\d", name)) for name in spoken}
    assert spoken == named
    assert {version for versions in named.values() for version in versions} == {"fmi2", "fmi3"}


# arrays of a resource file


def test_arrays_outside_their_buffers_are_refused(model, library, tmp_path):
    """Even where the GUID is that of the wrong numbers."""
    assert refusal(library, tmp_path / "good", resource(model, status.MESSAGES), model.guid) is None
    wrong = {row.name: layout.SLOT[row.name] for row in layout.ARRAYS[::7]}
    wrong |= {name: layout.SLOT[name] for name in ("time", "notices", "notice", "lu_known", "stages_here")}
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
            said = refusal(library, tmp_path / "bad", resource(other, status.MESSAGES), other.guid)
            assert said and "is refused: its " in said, (name, value)


# the table of value references


def test_value_references_come_in_any_order(library, tmp_path):
    """The table alone says what they are: with the variables in another order all is as before."""
    model = compiler.compile_scene(read_scene(MODELS / "two_link_arm.toml"))
    order = np.random.default_rng(3).permutation(len(model.variables))
    other = replace(model, variables=[model.variables[k] for k in order])
    rows = []

    for case in (model, other):
        instance = placed(library, tmp_path / "arm", resource(case, status.MESSAGES), case.guid)
        reference = {v.name: k for k, v in enumerate(case.variables)}
        fixed = next(v.name for v in model.variables if v.variability == "fixed")
        torque, output = reference["shoulder.torque"], reference["shoulder.angle"]
        assert instance.set({reference["upper.mass"]: 2.5, torque: 0.25}) == OK
        instance.start()
        assert instance.set_derivatives(torque, 1, 3.0) == instance.step(0.0, 0.1) == OK
        assert instance.set({reference[fixed]: 1.0}) == instance.set({output: 1.0}) == ERROR
        assert instance.set_derivatives(output, 1, 3.0) == ERROR and "'shoulder.angle'" in instance.message
        assert instance.step(0.1, 0.1) == OK
        rows.append(instance.get(*(reference[v.name] for v in model.variables)))
        assert rows[-1][0] == OK
        instance.free()

    assert rows[0] == rows[1]


START = 8 * len(SIZES) + GUID_SIZE
"""Where the numbers of a resource file begin, behind its head."""


def resealed(body):
    """A resource file of this body, with the GUID and the checksum that go with it."""
    n = dict(zip(SEALED_SIZES, struct.unpack_from(f"<{len(SEALED_SIZES)}q", body), strict=True))
    numbers = n["ints"] + n["reals"] + n["u"] + 3 * n["variables"] + n["survey_ints"] + n["survey_reals"]
    start, end = START, START + 8 * numbers + 32
    h = hashlib.sha256(body[: 8 * len(n)] + body[start:end]).hexdigest()
    guid = f"{{{h[:8]}-{h[8:12]}-{h[12:16]}-{h[16:20]}-{h[20:32]}}}"
    body = body[: 8 * len(SIZES)] + guid.encode().ljust(GUID_SIZE, b"\0") + body[start:]
    return b"mbdfmi\0\1" + struct.pack("<IIQ", VERSION, zlib.crc32(body), len(body)) + body, guid


def test_a_broken_table_is_refused_or_harmless(model, library, tmp_path):
    """Bits flipped in it, with a GUID and a checksum that agree: a message that names the variable, or values all the same."""
    body = resource(model, status.MESSAGES)[24:]
    assert resealed(body) == (resource(model, status.MESSAGES), model.guid)
    table = START + 8 * (len(model.ints) + len(model.reals) + model.n_u)
    rng = np.random.default_rng(5)
    refused = 0

    for _ in range(500):
        damaged = bytearray(body)
        damaged[table + int(rng.integers(TABLE.itemsize * len(model.variables)))] ^= 1 << int(rng.integers(8))
        instance = placed(library, tmp_path / "flipped", *resealed(bytes(damaged)))

        if instance.component is None:
            assert re.search(
                "is refused: its (variable|array) '.+' (is of no kind|lies outside)", instance.message
            )
            refused += 1
            continue

        instance.start()
        assert instance.step(0.0, 0.01) == OK
        instance.get(*range(len(model.variables)))
        instance.free()

    assert 300 < refused < 500


def test_a_broken_tape_is_refused_or_harmless(model, library, tmp_path):
    """Bits flipped in what derivatives are found by, with a checksum that agrees: a message, or numbers, whichever."""
    line = tape(model)
    body = resource(model, status.MESSAGES, line)[24:]
    first, rng, refused = START + len(sealed(model)[1]), np.random.default_rng(6), 0
    kinds = [v.causality for v in model.listed]
    mass = next(k for k, v in enumerate(model.listed) if v.name.endswith(".mass"))
    keys = [(c_uint * 1)(k) for k in (kinds.index("output"), kinds.index("input"), mass)]
    result, one = (c_double * 1)(), (c_double * 1)(1.0)

    for _ in range(300):
        damaged = bytearray(body)
        damaged[first + int(rng.integers(len(line.data())))] ^= 1 << int(rng.integers(8))
        instance = placed(library, tmp_path / "flipped", *resealed(bytes(damaged)))

        if instance.component is None:
            assert "its tape is damaged" in instance.message
            refused += 1
            continue

        instance.start()
        for known in keys[1:]:
            given = keys[0], c_size_t(1), known, c_size_t(1), one, result
            assert instance.call("fmi2GetDirectionalDerivative", *given) in (OK, ERROR)
        instance.free()

    assert 50 < refused < 250
