"""A scene as TOML."""

import os

from .errors import key_text, quoted

WIDTH = 96


def toml_text(scene):
    """The scene as the text of a TOML file: what was given, not what follows from it."""
    lines = []
    _write_table(lines, [], scene.model_dump(exclude_unset=True, exclude_none=True))
    return "\n".join(lines).lstrip("\n") + "\n"


def write_scene(scene, path):
    """Write the scene to a TOML file, whole or not at all. Raises OSError."""
    text = scene.to_toml()
    unfinished = f"{os.fspath(path)}.{os.getpid()}.tmp"
    with open(unfinished, "w", encoding="utf-8") as file:
        file.write(text)
    os.replace(unfinished, path)


def _write_table(lines, path, table):
    """Append the lines of a table: its values, then the tables that are too long for one line."""
    inline, below = {}, {}
    for key, value in table.items():
        # what has names of its own gets tables of its own
        own = isinstance(value, dict) and (not path or len(path) == 1 and path[0] != "ground")
        short = len(f"{key} = {_value(value)}") <= WIDTH
        is_below = own or (isinstance(value, dict) and value and not short)
        (below if is_below else inline)[key] = value

    if path and (inline or not below):
        lines += ["", "[" + ".".join(key_text(key) for key in path) + "]"]
    for key, value in inline.items():
        lines.append(_line(key_text(key), value))
    for key, value in below.items():
        _write_table(lines, [*path, key], value)


def _line(key, value):
    line = f"{key} = {_value(value)}"
    if len(line) <= WIDTH or not isinstance(value, (list, tuple)):
        return line
    return f"{key} = [\n" + "".join(f"    {_value(item)},\n" for item in value) + "]"


def _value(value):
    """A value on one line."""
    if isinstance(value, str):
        return quoted(value)
    if isinstance(value, dict):
        pairs = [f"{key_text(key)} = {_value(item)}" for key, item in value.items()]
        return "{ " + ", ".join(pairs) + " }" if pairs else "{}"
    if isinstance(value, (list, tuple)):
        return "[" + ", ".join(_value(item) for item in value) + "]"
    return repr(value)
