"""Shrinks a scene: the smallest that still fails, found by leaving out and by rounding.

`shrink(data, fails)` takes a scene as a dict and a function of such a dict, and returns the smallest dict
found for which it is true; `toml(data)` writes it. Scenes that are not valid do not fail. Everything is tried
in a fixed order.
"""

import copy

from mbdfmi import Scene, SceneError
from mbdfmi.scene import writer

TABLES = ("measure", "force", "coupling", "joint", "body")
ENDS = ("between", "on")
COLUMNS = ("time", "speed", "length", "position", "position_deg", "frequency", "s", "points")


def toml(data: dict) -> str:
    """A scene as the text of a TOML file, written as it is: `tomllib` gives the same dict back."""
    lines = []
    writer._write_table(lines, [], data, {})
    return "\n".join(lines).lstrip("\n") + "\n"


def shrink(data: dict, fails, tries: int = 1000) -> dict:
    """The smallest scene found with fails(scene) true, as that of `data` is,
    by at most so many calls of `fails`."""
    search = _Search(copy.deepcopy(data), fails, tries)
    before = None

    while before != search.data and search.left > 0:
        before = search.data

        for step in STEPS:
            step(search)

    return search.data


class _Search:
    """The smallest scene so far, and how many tries are left."""

    def __init__(self, data, fails, tries):
        self.data, self.fails, self.left = data, fails, tries

    def take(self, change) -> bool:
        """Keeps what `change` makes of a copy of the scene, if that still fails; whether it did."""
        if self.left <= 0:
            return False

        smaller = copy.deepcopy(self.data)
        change(smaller)

        if smaller == self.data or not _is_valid(smaller):
            return False

        self.left -= 1
        if not self.fails(copy.deepcopy(smaller)):
            return False

        self.data = smaller
        return True


def _is_valid(data):
    try:
        Scene.model_validate(data)
    except SceneError:
        return False
    return True


def _groups(items):
    """All items, then halves, quarters, … and single ones."""
    items = list(items)
    size = len(items)

    while size >= 1:
        yield from (items[k : k + size] for k in range(0, len(items), size))
        size = size // 2 if size > 1 else 0


# whole entries


def _without_entries(search):
    for table in TABLES[:-1]:
        for names in _groups(search.data.get(table, {})):
            search.take(lambda data: _remove(data, table, names))


def _remove(data, table, names):
    """Removes entries, and what cannot be without them."""
    entries = data.get(table, {})

    for name in names:
        entries.pop(name, None)

    if table == "joint":
        gone = [
            name
            for name, coupling in data.get("coupling", {}).items()
            if set(coupling["between"]) & set(names)
        ]
        _remove(data, "coupling", gone)

    if table in data and not entries:
        del data[table]

    # wind that nothing is in
    if not any("rotor" in force for force in data.get("force", {}).values()):
        data.pop("wind", None)


def _without_bodies(search):
    for names in _groups(search.data["body"]):
        # all that is on them goes; or what hangs on them hangs on the ground
        for hang in (False, True):
            search.take(lambda data: _remove_bodies(data, names, hang))


def _remove_bodies(data, names, hang):
    for name in names:
        data["body"].pop(name, None)

    gone = set(names)

    for table in ("joint", "force", "measure"):
        lost = []

        for name, entry in data.get(table, {}).items():
            ends = entry["between"] if "between" in entry else [entry["on"]]
            off = [end.split(".")[0] in gone for end in ends]

            if (
                hang
                and table == "joint"
                and sum(off) == 1
                and "ground" not in [end.split(".")[0] for end in ends]
            ):
                entry["between"] = ["ground" if is_off else end for end, is_off in zip(ends, off)]
            elif any(off):
                lost.append(name)

        _remove(data, table, lost)


# keys, items of lists, ends


def _places(value, path=()):
    """Paths of all keys below a table, outer ones first."""
    if isinstance(value, dict):
        for key in value:
            yield (*path, key)
        for key, item in value.items():
            yield from _places(item, (*path, key))
    elif isinstance(value, list):
        for k, item in enumerate(value):
            if isinstance(item, dict):
                yield from _places(item, (*path, k))


def _holder(data, path):
    """What holds the last key of a path, or None where that is no longer there."""
    for key in path[:-1]:
        try:
            data = data[key]
        except (KeyError, IndexError, TypeError):
            return None

    return data if isinstance(data, dict) and path[-1] in data else None


def _without_keys(search):
    for path in list(_places(search.data)):
        if len(path) > 1 and (holder := _holder(search.data, path)) is not None and path[-1] in holder:
            search.take(lambda data: _holder(data, path).pop(path[-1]))
        elif len(path) == 1 and path[0] not in ("name", "body"):
            search.take(lambda data: data.pop(path[0], None))


def _without_items(search):
    for path in list(_places(search.data)):
        holder = _holder(search.data, path)
        if holder is None or not isinstance(holder[path[-1]], list) or path[-1] in ENDS:
            continue

        if all(isinstance(item, (str, dict)) for item in holder[path[-1]]):
            for k in reversed(range(len(holder[path[-1]]))):
                search.take(lambda data: _holder(data, path)[path[-1]].pop(k))


def _plain_ends(search):
    """Ends on bodies' own frames, in place of markers."""
    for table in ("joint", "force", "measure"):
        for name in list(search.data.get(table, {})):
            for k in range(2):
                search.take(lambda data: _plain_end(data, table, name, k))


def _plain_end(data, table, name, k):
    entry = data.get(table, {}).get(name, {})

    if "between" in entry:
        entry["between"] = [end.split(".")[0] if i == k else end for i, end in enumerate(entry["between"])]
    elif "on" in entry:
        entry["on"] = entry["on"].split(".")[0]


# tables and numbers


def _without_points(search):
    """Fewer points of tables: the same one out of all their columns."""
    for path in list(_places(search.data)):
        holder = _holder(search.data, path)
        if holder is None or path[-1] not in COLUMNS:
            continue

        column = holder[path[-1]]
        for k in reversed(range(len(column) if isinstance(column, list) else 0)):
            search.take(lambda data: _drop_point(_holder(data, path), path[-1], k))


def _drop_point(table, key, k):
    n = len(table[key])

    if k < n:
        for name, column in table.items():
            if isinstance(column, list) and len(column) == n:
                table[name] = column[:k] + column[k + 1 :]


def _round_numbers(search):
    """Whole arrays to zeros, then numbers to 0, 1, and to few digits."""
    for path in list(_places(search.data)):
        holder = _holder(search.data, path)

        if holder is not None and isinstance(holder[path[-1]], list):
            search.take(lambda data: _holder(data, path).update({path[-1]: _zeros(holder[path[-1]])}))

    for path in list(_numbers(search.data)):
        old = _number_at(search.data, path)
        new = [0.0, 1.0, -1.0, *(round(old, digits) for digits in (0, 1, 2, 3, 6))] if old is not None else []

        for value in dict.fromkeys(new):
            # whole, small and short ones are simpler
            if _cost(value) < _cost(old) and search.take(lambda data: _set(data, path, value)):
                break


def _cost(value):
    return (value not in (0.0, 1.0, -1.0), len(repr(value)), value != 0.0, value < 0.0)


def _zeros(value):
    if isinstance(value, list):
        return [_zeros(item) for item in value]
    return 0.0 if isinstance(value, float) else value


def _numbers(value, path=()):
    """Paths of all floats."""
    if isinstance(value, float):
        yield path
    elif isinstance(value, (dict, list)):
        for key, item in value.items() if isinstance(value, dict) else enumerate(value):
            yield from _numbers(item, (*path, key))


def _number_at(data, path):
    for key in path:
        try:
            data = data[key]
        except (KeyError, IndexError, TypeError):
            return None

    return data if isinstance(data, float) else None


def _set(data, path, value):
    for key in path[:-1]:
        data = data[key]

    data[path[-1]] = value


STEPS = (
    _without_entries, _without_bodies, _without_keys, _without_items, _plain_ends, _without_points,
    _round_numbers,
)  # fmt: skip
