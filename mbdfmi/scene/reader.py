"""Scenes from files."""

import os
import re
import tomllib

from .errors import Problem, SceneError, show
from .schema import Scene


def read_scene(path):
    """Read a scene from a TOML file.

    path : str or path-like. Returns a `Scene`.
    Raises SceneError, with the file's name and all that is wrong in it, for whatever goes wrong.
    """
    path = os.fspath(path)
    try:
        return Scene.model_validate(_read_toml(path))
    except SceneError as error:
        raise SceneError(error.problems, file=path) from None


def _fail(text):
    raise SceneError([Problem((), text)]) from None


def _read_toml(path):
    """The tables of a TOML file as a dict; SceneError when it cannot be read."""
    try:
        with open(path, "rb") as file:
            data = file.read()
    except FileNotFoundError:
        _fail("there is no such file")
    except IsADirectoryError:
        _fail("is a folder; name a scene file in it")
    except (OSError, ValueError) as error:
        _fail(f"cannot be read: {getattr(error, 'strerror', None) or error}")

    try:
        text = data.decode("utf-8-sig")
    except UnicodeDecodeError as error:
        line = data[: error.start].count(b"\n") + 1
        _fail(f"line {line}: not UTF-8 text (byte 0x{data[error.start]:02x}); save it as UTF-8")

    try:
        return tomllib.loads(text)
    except RecursionError:
        _fail("lists or tables are nested too deeply")
    except ValueError as error:
        _fail(_syntax_text(str(error), text))


# what tomllib's messages mostly come from
HINTS = {
    "Invalid value": "a text stands in quotes, a number as 0.5 without a unit",
    "Expected newline": "a number stands as 0.5 without a unit, a comment after #",
    "Expected ']'": 'a name with spaces stands in quotes, as in [body."blade 1"]',
    "Cannot declare": "write each table once",
    "Cannot overwrite": "write each key once",
    "Invalid initial character for a key": (
        "an inline table { ... } stands on one line, without a comma at its end"
    ),
    "Invalid statement": "a line is [table] or key = value; other letters than a-z want quotes",
    "Unclosed array": "a list is closed by ], its items are parted by commas",
}


def _syntax_text(message, text):
    """What tomllib says, with the place first, the line shown, and a hint."""
    found = re.fullmatch(r"(.*) \(at (?:line (\d+), column (\d+)|end of document)\)", message, re.DOTALL)
    if not found:
        return f"not valid TOML: {message}"

    lines = text.rstrip().split("\n")
    line = int(found[2] or len(lines))
    column = f", column {found[3]}" if found[3] else ""
    # tables as the file has them, not as tuples
    what = re.sub(
        r"\(('.*?'),?\)", lambda m: "[" + ".".join(re.findall("'(.*?)'", m[1])) + "]", found[1]
    )
    hint = next(("; " + hint for start, hint in HINTS.items() if what.startswith(start)), "")

    return f"line {line}{column}: not valid TOML: {what} in {show(lines[line - 1].strip())}{hint}"
