"""Scenes from files."""

import os
import re
import tomllib

from .errors import Problem, SceneError, quoted
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


def _syntax_text(message, text):
    """What tomllib says, with the line first and shown."""
    found = re.fullmatch(r"(.*) \(at line (\d+), column (\d+)\)", message, re.DOTALL)
    if not found:
        where = " (the file ends too early)" if "end of document" in message else ""
        return f"not valid TOML: {message}{where}"

    what, line, column = found[1], int(found[2]), int(found[3])
    return f"line {line}, column {column}: not valid TOML: {what}"
