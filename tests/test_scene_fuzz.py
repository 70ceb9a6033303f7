"""Broken scene files: each ends in messages that name the file and the place, never in a traceback.

The damage is done to good files: to every value and every key of them in turn (systematic), to
their text and bytes, and at random. What is still a scene after it must be a sound one.
"""

import copy
import tomllib

import numpy as np
import pytest
from hypothesis import HealthCheck, given, settings
from hypothesis import strategies as st
from scene_files import ARM, GOOD, outcome

from mbdfmi import Scene
from mbdfmi.scene import SceneError

# no numpy warning either: NaN and overflow must not get that far
pytestmark = pytest.mark.filterwarnings("error")

# damage to values and keys


class Raw(str):
    """A value already written as TOML."""


WRONG_VALUES = {
    "text": "nonsense",
    "empty text": "",
    "blank text": "  ",
    "number in quotes": "2.0",
    "unit": "2 kg",
    "control character": "a\x01b",
    "long text": "x" * 10_000,
    "zero": 0,
    "minus one": -1,
    "minus tiny": -1e-300,
    "tiny": 1e-300,
    "huge": 1e300,
    "huge whole": Raw("1" + 400 * "0"),
    "huge hex": Raw("0x" + 5000 * "f"),
    "nan": np.nan,
    "inf": np.inf,
    "minus inf": -np.inf,
    "true": True,
    "date": Raw("2024-02-29"),
    "time": Raw("07:32:00"),
    "empty list": [],
    "list of a list": [[]],
    "list of text": ["a"],
    "numbers": [1, 2, 3, 4, 5],
    "nans": [np.nan] * 3,
    "huge numbers": [1e300] * 3,
    "zeros": [0, 0, 0],
    "mixed": [1, "a", []],
    "matrix": [[1, 0, 0], [0, 1, 0], [0, 0, 1]],
    "ragged": [[1, 2, 3], [4, 5], [6]],
    "empty table": {},
    "strange table": {"strange": 1},
    "tables": [{}, {}],
    "deep list": Raw("[" * 60 + "]" * 60),
    "deep table": Raw("{a=" * 60 + "1" + "}" * 60),
}


def toml(value):
    if isinstance(value, Raw):
        return str(value)
    if isinstance(value, bool):
        return str(value).lower()
    if isinstance(value, dict):
        return "{" + ", ".join(f"{toml(k)} = {toml(v)}" for k, v in value.items()) + "}"
    if isinstance(value, list):
        return "[" + ", ".join(map(toml, value)) + "]"
    if isinstance(value, str):
        return (
            '"'
            + "".join(c if c.isprintable() and c not in '"\\' else f"\\U{ord(c):08x}" for c in value)
            + '"'
        )
    return repr(value)


def document(tables):
    return "".join(f"{toml(key)} = {toml(value)}\n" for key, value in tables.items())


def places(value, path=()):
    """Paths of all values in nested tables and lists; the first number of a list stands for all."""
    if path:
        yield path
    if isinstance(value, dict):
        items = value.items()
    elif isinstance(value, list):
        alike = value and not isinstance(value[0], (str, dict))
        items = enumerate(value[:1] if alike else value)
    else:
        return
    for key, item in items:
        yield from places(item, (*path, key))


def damage(tables, path, change):
    """A copy of the tables with change(holder, key) done at the path."""
    tables = copy.deepcopy(tables)
    holder = tables
    for key in path[:-1]:
        holder = holder[key]
    change(holder, path[-1])
    return tables


def put(value):
    def change(holder, key):
        holder[key] = value

    return change


def rename(holder, old, new):
    # in place, so that the order stays
    items = [(new if key == old else key, value) for key, value in holder.items()]
    holder.clear()
    holder.update(items)


def structural_changes(holder, key, value):
    """Named changes that fit the place."""
    yield "deleted", lambda h, k: h.pop(k)
    yield "in a list", put([value])
    yield "in a table", put({str(key): value})
    if isinstance(value, list):
        yield "one more", put([*value, value[0]])
        yield "one less", put(value[:-1])
        yield "doubled", put(value * 2)
        yield "as a table", put({str(i): item for i, item in enumerate(value)})
    if isinstance(value, dict):
        yield "as a list", put(list(value.values()))
        yield "with a strange key", put({**value, "strange": 1})
    if isinstance(value, str):
        yield "misspelt text", put(value[:-1] + "q")
        yield "upper text", put(value.upper())
        yield "dotted text", put(value + "." + value)
        yield "half dotted text", put(value + ".")
    if isinstance(holder, dict):
        for what, new in {
            "letter lost": key[1:],
            "letter twice": key[0] + key,
            "letters swapped": key[::-1],
            "upper": key.upper(),
            "plural": key + "s",
            "empty": "",
            "with a dot": "a." + key,
            "with a unit": key + "_m",
            "ground": "ground",
            "control": key + "\x00",
        }.items():
            if new != key and new not in holder:
                yield f"key {what}", lambda h, k, new=new: rename(h, k, new)
        yield "copied", lambda h, k: h.update({k + "2": h[k]})


def changes():
    for name, text in GOOD.items():
        tables = tomllib.loads(text)
        for i, path in enumerate(places(tables)):
            holder = tables
            for key in path[:-1]:
                holder = holder[key]
            value = holder[path[-1]]

            # some of them at each place, in turns
            for what, wrong in list(WRONG_VALUES.items())[i % 5 :: 5]:
                yield name, tables, path, what, put(wrong)
            for what, change in list(structural_changes(holder, path[-1], value))[i % 4 :: 4]:
                yield name, tables, path, what, change


def test_damaged_values_and_keys():
    kinds, refused, done = set(), 0, 0
    for name, tables, path, what, change in changes():
        error = outcome(document(damage(tables, path, change)))
        done += 1

        if error:
            refused += 1
            # the kind of damage: what was done, to which key of which table
            keys = [key for key in path if isinstance(key, str)]
            kinds.add((what, path[0], keys[-1]))
            # the message leads to the place, or to what now misses it
            near = [*keys, "TOML", "ground"]
            assert any(key in str(error) for key in near), (path, what, str(error))

    assert len(kinds) >= 200
    assert refused > 0.8 * done


# damage to text and bytes


def text_damages(text):
    lines = text.splitlines(keepends=True)
    for end in range(0, len(text), 13):
        yield f"cut off at {end}", text[:end]
    for i, line in enumerate(lines):
        rest = "".join(lines[:i]), "".join(lines[i + 1 :])
        yield f"line {i} lost", "".join(rest)
        yield f"line {i} twice", rest[0] + line + line + rest[1]
        slips = [("=", ""), ("[", ""), ('"', ""), ("]", "}"), (".", ","), (",", "")]
        for old, new in slips[i % 2 :: 2]:
            yield f"{old} made {new} in line {i}", rest[0] + line.replace(old, new) + rest[1]
        yield f"line {i} moved up", line + "".join(rest)
    for junk in ("\x00", "\x7f", "\ufeff", "“", "]", "}", '"', "'''", "= =", "[[body]]\n"):
        for i in range(0, len(lines), 5):
            yield f"{junk!r} before line {i}", "".join(lines[:i]) + junk + "".join(lines[i:])


@pytest.mark.parametrize("name", GOOD)
def test_damaged_text(name):
    for _, text in text_damages(GOOD[name]):
        outcome(text)


@pytest.mark.parametrize(
    "content",
    [
        b"",
        b"\n\n",
        b"\x00" * 1000,
        bytes(range(256)),
        b"\x89PNG\r\n\x1a\n",
        b"PK\x03\x04",
        b"\xff\xfe",
        ARM.encode("utf-16"),
        ARM.replace("arm", "ärm").encode("latin-1"),
        b"name = '\xed\xa0\x80'",
        b"a=1\n\x0b\n\x1c",
        b"a=" + b"[" * 100_000,
        b"a=" + b"{a=" * 100_000,
        b"[" + b"a." * 5000 + b"a]",
        b"a." * 3000 + b"a=1",
        b"x=" + b"9" * 5000,
        b'{"name": "arm"}',
        b"<scene/>",
        b"name: arm\n",
    ],
    ids=lambda content: repr(content[:12]),
)
def test_files_that_are_no_scene(content):
    assert outcome(content) is not None


def test_windows_text_is_no_damage():
    assert outcome(b"\xef\xbb\xbf" + ARM.replace("\n", "\r\n").encode()) is None


# damage at random

RANDOM = settings(
    max_examples=150,
    deadline=None,
    derandomize=True,
    suppress_health_check=[HealthCheck.too_slow],
)
NAMES = st.sampled_from("mass inertia solid marker position output axis x start free name".split())
ANYTHING = st.recursive(
    st.integers() | st.floats() | st.booleans() | st.text(st.characters(codec="utf-8"), max_size=8),
    lambda inner: (
        st.lists(inner, max_size=6)
        | st.dictionaries(NAMES | st.text(st.characters(codec="utf-8"), max_size=5), inner, max_size=4)
    ),
    max_leaves=12,
)


@RANDOM
@given(st.data())
def test_anything_anywhere(data):
    tables = tomllib.loads(data.draw(st.sampled_from(list(GOOD.values()))))
    for _ in range(data.draw(st.integers(1, 3))):
        path = data.draw(st.sampled_from(list(places(tables))))
        tables = damage(tables, path, put(data.draw(ANYTHING)))
        # what was put in is written as TOML and has no places of its own
        tables = tomllib.loads(document(tables))
    outcome(document(tables))


@RANDOM
@given(st.sampled_from(list(GOOD.values())), st.data())
def test_bytes_changed_at_random(text, data):
    content = bytearray(text.encode())
    for _ in range(data.draw(st.integers(1, 4))):
        start = data.draw(st.integers(0, len(content) - 1))
        length = data.draw(st.integers(0, 30))
        content[start : start + length] = data.draw(st.binary(max_size=12))
        if not content:
            break
    outcome(bytes(content))


@RANDOM
@given(ANYTHING)
def test_anything_at_all_as_a_scene(value):
    try:
        Scene.model_validate(value)
    except SceneError as error:
        assert error.errors
