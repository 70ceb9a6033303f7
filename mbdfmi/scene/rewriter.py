"""Changes of a scene written into its own text, which keeps its comments and its order."""

from pathlib import Path

import tomlkit
from tomlkit.items import InlineTable, Item

from ..files import replacing
from .fields import given
from .reader import read_bytes

# tables whose numbers may be written anew
TABLES = ("joint", "force")


def rewritten(source, before, after, path) -> Path:
    """Writes the text of a scene's file with what `after` has otherwise than `before` in joints and forces. Returns
    the path.

    Both are the scene of the file `source`, the one as it is there. Raises ValueError where the text is no UTF-8.
    """
    document = tomlkit.parse(read_bytes(Path(source)).decode("utf-8-sig"))
    old, new = given(before), given(after)

    for table in TABLES:
        for name, part in new.get(table, {}).items():
            _change(document[table][_key(document[table], name)], old[table][name], part)

    with replacing(path) as temporary:
        temporary.write_text(tomlkit.dumps(document), encoding="utf-8")

    return Path(path)


def _key(table, name):
    """The key of a name, which a file may write with blanks around it."""
    return next(key for key in table if key.strip() == name)


def _change(table, old, new):
    """What is other in a table, there."""
    for key in [key for key in old if key not in new]:
        table.pop(key, None)

    for key, value in new.items():
        if key in old and old[key] == value:
            continue

        there = table.get(key)

        if isinstance(value, dict) and isinstance(there, dict) and not isinstance(there, InlineTable):
            _change(there, old.get(key) or {}, value)
            continue

        item = tomlkit.item(_item(value))

        if isinstance(there, Item):
            item.trivia.comment_ws, item.trivia.comment = there.trivia.comment_ws, there.trivia.comment

        table[key] = item


def _item(value):
    """A value as an item, tables within a line."""
    if isinstance(value, dict):
        table = tomlkit.inline_table()
        table.update({key: _item(item) for key, item in value.items()})
        return table

    return [_item(item) for item in value] if isinstance(value, (list, tuple)) else value
