#!/usr/bin/env python3
"""Writes docs/scene.md, the reference of scene files, from the schema: `python docs/make_scene_reference.py`.

What stands before the first generated section is docs/scene_introduction.md.
"""

import re
import types
import typing
from pathlib import Path

from pydantic.fields import FieldInfo
from pydantic_core import PydanticUndefined

from mbdfmi.scene import fields, geometry, looks, schema, sea, water
from mbdfmi.scene.fields import Part

FOLDER = Path(__file__).parent
KINDS = {
    fields.Number: "number",
    fields.Positive: "number > 0",
    fields.Tolerance: "number from 1e-14 to 0.1",
    fields.NotNegative: "number >= 0",
    fields.NotZero: "number, not 0",
    fields.Axis: "axis",
    schema.Text: "text",
    schema.Title: "text",
    schema.Name: "name",
    geometry.MeshName: "name of a file",
    geometry.Scale: "number, not 0, or 3 of them",
    looks.Colour: 'name of a CSS colour or `"#rrggbb"`',
    looks.Opacity: "number above 0, at most 1",
    looks.Line: "list of ends",
    looks.FrameName: "text",
    looks.Names: "list of names",
    sea.DataName: "name of a file",
    sea.Excitation: 'true, false or `"input"`',
    water.Sides: "whole number from 3 to 1000",
}


def reference() -> str:
    """The whole page (Markdown)."""
    lines = [(FOLDER / "scene_introduction.md").read_text(encoding="utf-8").rstrip()]
    seen, waiting = [], [schema.SceneData]

    # one section for each table, those of the file first, then what is in them
    while waiting:
        cls = waiting.pop(0)

        if cls not in seen and cls.model_fields:
            seen.append(cls)
            lines += _section(cls)
            waiting += [part for field in cls.model_fields.values() for part in _parts(field.annotation)]

    return "\n".join(lines) + "\n"


def _section(cls):
    lines = ["", "", f"## {_title(cls)}", ""]

    # what a table has in common with others is said of the class they share
    for base in cls.__mro__[: cls.__mro__.index(Part)]:
        for paragraph in _paragraphs(base.__doc__):
            if base is cls or paragraph.startswith("- "):
                lines += [paragraph, ""]

    if cls.needed:
        lines += ["One of these must be given: " + "; ".join(_either(keys) for keys in cls.needed) + ".", ""]

    if cls.exclusive:
        lines += ["At most one of: " + "; ".join(_either(keys) for keys in cls.exclusive) + ".", ""]

    lines += ["| key | value | default |", "|---|---|---|"]

    for key in sorted(cls.model_fields, key=lambda key: key != cls.kind):
        field = cls.model_fields[key]
        lines.append(f"| `{key}` | {_kind(field)} | {_default(cls, key, field)} |")

    return lines


def _title(cls):
    """A class's name in words: "Spherical start"."""
    return re.sub(r"(?<=[a-z])(?=[A-Z])", " ", cls.__name__.removesuffix("Data")).capitalize()


def _link(cls):
    return f"[{_title(cls).lower()}](#{_title(cls).lower().replace(' ', '-')})"


def _paragraphs(text):
    """A docstring's paragraphs, "key : meaning" lines as items of a list."""
    for paragraph in re.sub(r"\n +", "\n", text.strip()).split("\n\n"):
        lines = []

        for line in paragraph.replace("|", "\\|").split("\n"):
            item = re.match(r"((?:\w+(?: \(\w+\))?(?:, | or |$)?)+) : (.*)", line)

            if item:
                lines.append(f"- `{item[1]}`: {item[2]}")
            elif lines:
                lines[-1] += " " + line
            else:
                lines.append(line)

        yield "\n".join(lines)


def _either(keys):
    return ", ".join(f"`{key}`" for key in keys)


def _default(cls, key, field: FieldInfo):
    if key == cls.kind or field.is_required() or any(key in keys for keys in cls.needed):
        return "must be given" if field.is_required() else ""

    if field.default is PydanticUndefined or isinstance(field.default, (Part, dict)) or field.default is None:
        return ""

    value = list(field.default) if isinstance(field.default, tuple) else field.default
    return "" if value == [] else f"`{str(value).lower() if isinstance(value, bool) else _toml(value)}`"


def _toml(value):
    if isinstance(value, list):
        return "[" + ", ".join(map(_toml, value)) + "]"

    return f'"{value}"' if isinstance(value, str) else f"{value:g}"


def _kind(field):
    """What a value may be, in words."""
    annotation = typing.Annotated[(field.annotation, *field.metadata)] if field.metadata else field.annotation
    words = _words(annotation) or "see above"

    if not field.description:
        return words

    # of the ends of a joint, the description says all
    return field.description if words.startswith("a list") else f"{words}: {field.description}"


def _words(annotation):
    if annotation in KINDS:
        return KINDS[annotation]

    if isinstance(annotation, type) and issubclass(annotation, Part):
        return _link(annotation) if annotation.model_fields else "`{}`"

    origin, arguments = typing.get_origin(annotation), typing.get_args(annotation)

    if origin is dict:
        return f"tables by name, each {_words(arguments[1])}"

    if origin is typing.Annotated:
        found = next(filter(None, map(_told, arguments[1:])), None)
        kinds = [_link(part) for part in _parts(arguments[0])]
        return f"{found}: {', '.join(kinds)}" if found and kinds else found or _words(arguments[0])

    if origin in (typing.Union, types.UnionType):
        return " or ".join(dict.fromkeys(filter(None, (_words(a) for a in arguments if a is not type(None)))))

    if origin in (list, tuple):
        words = dict.fromkeys(filter(None, (_words(a) for a in arguments if a is not Ellipsis)))
        return ("one or a list of: " if origin is list else "a list: ") + ", ".join(words) if words else None

    return {bool: "true or false", float: "number", str: "text"}.get(annotation)


def _told(validator):
    """What a validator of mbdfmi.scene.fields says of the values it takes."""
    function = getattr(validator, "func", None)

    if function is None:
        return None

    known = {KINDS[kind]: kind for kind in KINDS}
    for words, kind in known.items():
        if any(getattr(item, "func", None) is function for item in typing.get_args(kind)[1:]):
            return words

    cells = dict(
        zip(function.__code__.co_freevars, (cell.cell_contents for cell in function.__closure__ or ()))
    )

    if "options" in cells:
        listed = ", ".join(f'`"{option}"`' for option in cells["options"])
        words = {"validate": "list of ", "true_or_some": "true, or list of "}
        return words.get(function.__name__, "one of ") + listed

    return cells.get("what")


def _parts(annotation):
    """The tables that a value may hold."""
    if isinstance(annotation, type) and issubclass(annotation, Part):
        return [annotation]

    return [part for argument in typing.get_args(annotation) for part in _parts(argument)]


if __name__ == "__main__":
    (FOLDER / "scene.md").write_text(reference(), encoding="utf-8")
