"""A scene as TOML."""

from ..files import replacing
from .errors import key_text, quoted
from .fields import given

WIDTH = 96


def toml_text(scene, comments=None):
    """The scene as the text of a TOML file: what was given, not what follows from it.

    comments : {path of a table as ("joint", "elbow"), () for the file: lines to stand above it}.
    """
    lines = [f"# {text}" for text in (comments or {}).get((), ())]
    _write_table(lines, [], given(scene), comments or {})
    return "\n".join(lines).lstrip("\n") + "\n"


def write_scene(scene, path, comments=None):
    """Write the scene to a TOML file, whole or not at all; comments as of `toml_text`. Raises OSError."""
    text = toml_text(scene, comments)
    with replacing(path) as unfinished:
        unfinished.write_text(text, encoding="utf-8")


def _write_table(lines, path, table, comments):
    """Append the lines of a table: its values, then the tables below it."""
    inline, below = {}, {}
    for key, value in table.items():
        # parts with names of their own, as marker.elbow
        if isinstance(value, dict) and value and all(isinstance(v, dict) for v in value.values()):
            entries = {(key, name): item for name, item in value.items()}
        else:
            entries = {(key,): value}

        # parts keep their order: those after one that is too long for a line come below too
        under = isinstance(value, dict) and not path
        for keys, item in entries.items():
            under = under or (isinstance(item, dict) and bool(item) and len(_line(keys, item)) > WIDTH)
            (below if under else inline)[keys] = item

    above = [f"# {text}" for text in comments.get(tuple(path), ())] if path else []

    if path and (inline or above or not below):
        lines += ["", *above, "[" + ".".join(map(key_text, path)) + "]"]
    elif lines and not path:
        lines.append("")
    for keys, item in inline.items():
        lines.append(_line(keys, item))
    for keys, item in below.items():
        _write_table(lines, [*path, *keys], item, comments)


def _line(keys, value):
    start = ".".join(map(key_text, keys)) + " = "
    line = start + _value(value)
    if len(line) <= WIDTH or not isinstance(value, list):
        return line
    return start + "[\n" + "".join(f"    {_value(item)},\n" for item in value) + "]"


def _value(value):
    """A value on one line."""
    if isinstance(value, str):
        return quoted(value)
    if isinstance(value, bool):
        return str(value).lower()
    if isinstance(value, dict):
        pairs = [f"{key_text(key)} = {_value(item)}" for key, item in value.items()]
        return "{ " + ", ".join(pairs) + " }" if pairs else "{}"
    if isinstance(value, list):
        return "[" + ", ".join(_value(item) for item in value) + "]"
    return repr(value)
