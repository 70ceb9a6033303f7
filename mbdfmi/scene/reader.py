"""Scenes from files."""

import os
import re
import tomllib

from .errors import Problem, SceneError, show
from .schema import SceneData


def read_scene(path, kind=SceneData):
    """Read a scene from a TOML file.

    path : str or path-like. Returns a scene of the class `kind`.
    Raises SceneError, with the file's name and all that is wrong in it, for whatever goes wrong.
    """
    return parse_scene(read_bytes(path), os.fspath(path), kind)


def read_bytes(path):
    """The bytes of a file. Raises SceneError where it cannot be read."""
    path = os.fspath(path)
    try:
        with open(path, "rb") as file:
            return file.read()
    except FileNotFoundError:
        text = "there is no such file"
    except IsADirectoryError:
        text = "is a folder; name a file in it"
    except (OSError, ValueError) as error:
        text = f"cannot be read: {getattr(error, 'strerror', None) or error}"

    raise SceneError([Problem((), text)], file=path)


def parse_scene(data, file=None, kind=SceneData):
    """A scene from the bytes of a TOML file, with the name that messages give the file, or None.

    Raises SceneError with all that is wrong.
    """
    if other := _other_kind(data):
        raise SceneError([Problem((), f"is {other}, not a scene file (TOML)")], file=file)

    try:
        # names of files in it start at its own folder
        folder = os.path.dirname(file) if file else "."
        return kind.model_validate(tomllib.loads(data.decode("utf-8-sig")), context={"folder": folder})
    except SceneError as error:
        problems = error.problems
    except UnicodeDecodeError as error:
        line = data[: error.start].count(b"\n") + 1
        text = f"line {line}: not UTF-8 text (byte 0x{data[error.start]:02x}); save it as UTF-8"
        problems = [Problem((), text)]
    except RecursionError:
        problems = [Problem((), "lists or tables are nested too deeply")]
    except ValueError as error:
        text = _syntax_text(str(error), data.decode("utf-8-sig"))
        problems = [Problem((), text)]

    raise SceneError(problems, file=file)


# how files of other kinds begin, blanks and comments of XML left out, and what they are
BEGINNINGS = {
    rb"ISO-10303-21\s*;": "a STEP file (CAD geometry)",
    rb"<robot\b": "a URDF file (a robot, XML)",
    rb"<mujoco\b": "an MJCF file (a model of MuJoCo, XML)",
    rb"<sdf\b": "an SDF file (a world of Gazebo, XML)",
    rb"<fmiModelDescription\b": "the modelDescription.xml of an FMU",
    rb"<\w+:SystemStructureDescription\b": "an SSP file (a system of FMUs, XML)",
    rb"<(!DOCTYPE )?html\b": "a web page (HTML)",
    rb"<svg\b": "a picture (SVG)",
    rb"<": "an XML file",
    rb"PK\x03\x04": "a zip archive, as FMUs and spreadsheets are",
    rb"(within\b[^;]*;\s*)?(partial\s+)?(model|package|block)\s+\w+": "a Modelica file",
    rb"OndselSolver": "an assembly of OndselSolver (.asmt)",
    rb"solid\b[^\n]*\s+facet\b": "an STL file (a surface of triangles)",
    rb"%PDF": "a PDF file",
    rb"\x89PNG|\xff\xd8\xff|GIF8[79]a": "a picture",
    rb"\x7fELF|MZ[\x00-\x08\x80-\xff]": "a program or library",
    rb"\x1f\x8b|BZh[1-9]1AY|7z\xbc|\xfd7zXZ": "a compressed file",
    rb"\x89HDF|MATLAB 5": "a file of arrays (HDF5, MATLAB)",
    rb"%YAML|---\s": "a YAML file",
    rb"\{|\[\s*\{": "a JSON file",
    rb"(#!.*python|import \w+|from [\w.]+ import )": "a Python program; run it with python",
}


def is_urdf(data, path):
    """Whether bytes of a file are those of a URDF file, by what they say or by how its name ends."""
    return (
        os.fspath(path).lower().endswith((".urdf", ".xacro")) or _other_kind(data) == BEGINNINGS[rb"<robot\b"]
    )


def _other_kind(data):
    """What a file is that plainly is no TOML file, in words, or None."""
    start = data[:4096].removeprefix(b"\xef\xbb\xbf").lstrip()

    # an XML file tells what it is by its first element
    while prologue := re.match(rb"<\?.*?\?>|<!--.*?-->|<!DOCTYPE (?!html)[^>]*>", start, re.DOTALL):
        start = start[prologue.end() :].lstrip() or b"<"

    return next((what for begins, what in BEGINNINGS.items() if re.match(begins, start)), None)


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
    place = r"\(at (?:line (\d+), column (\d+)|end of document)\)"
    found = re.fullmatch(rf"(.*) {place}", message, re.DOTALL)
    if not found:
        return f"not valid TOML: {message}"

    line = int(found[2] or text.rstrip().count("\n") + 1)
    shown = show(text.split("\n")[line - 1].strip())
    column = f", column {found[3]}" if found[3] else ""
    # tables as the file has them, not as tuples
    what = re.sub(r"\(('.*?'),?\)", lambda m: "[" + ".".join(re.findall("'(.*?)'", m[1])) + "]", found[1])
    hint = next(("; " + hint for start, hint in HINTS.items() if what.startswith(start)), "")

    return f"line {line}{column}: not valid TOML: {what} in {shown}{hint}"
