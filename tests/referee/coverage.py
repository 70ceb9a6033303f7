"""Which keys of the schema scenes use: `all_keys()` of the schema itself, `keys_of(data)` of a scene,
a table of counts.

A key is the path to it without the names that a user gives: `body.marker.output=zyx`,
`joint.revolute.start.angle_deg`. What a kind's own table holds stands beside what the joint holds:
`joint.revolute.axis`. Behind `=` stands one of a choice of words, one of the forms that an array may have
(`inertia=3x3`), or whether an axis is a `name` or a `vector`.
"""

import typing
from collections import Counter

from mbdfmi import Scene
from mbdfmi.scene import fields
from mbdfmi.scene.efforts import ParameterDriver
from mbdfmi.scene.fields import Part
from mbdfmi.scene.prescribed import PoseDriver

LEAST = 20

LEFT_OUT = {
    "code.specialise=true": "a library of its own for each scene: tests/test_specialise.py",
    "code.sources=true": "sources for a compiler that is elsewhere: tests/test_sources.py",
    "solver.start=trim": "a start that is searched for, and mostly not there: tests/test_trim.py",
}
"""Keys that random scenes do not have: why, and where they are tested."""


class Leaf:
    """A value; options: words that it may be or hold; forms: what tells one form of it from another."""

    def __init__(self, options=(), form=None, forms=()):
        self.options, self.form, self.forms = options, form, forms

    def keys(self, path):
        return {path} | {f"{path}={option}" for option in (*self.options, *self.forms)}

    def used(self, path, value):
        found = [value] if isinstance(value, (str, bool)) else value if isinstance(value, list) else []
        told = {
            f"{path}={_word(item)}"
            for item in found
            if isinstance(item, (str, bool)) and _word(item) in self.options
        }
        return {path} | told | ({f"{path}={self.form(value)}"} if self.form else set())


class Table:
    """A table with keys of its own, in which that of a kind lies open."""

    def __init__(self, cls):
        self.kind = _kind(cls)
        self.below = {key: build(field) for key, field in cls.model_fields.items()}

    def _path(self, path, key):
        return path if key == self.kind else f"{path}.{key}"

    def keys(self, path):
        return {path}.union(*(node.keys(self._path(path, key)) for key, node in self.below.items()))

    def used(self, path, value):
        return {path}.union(
            *(self.below[key].used(self._path(path, key), item) for key, item in value.items())
        )


class Kinds:
    """A table of one of several kinds."""

    def __init__(self, classes):
        self.of = {_kind(cls): Table(cls) for cls in classes}

    def keys(self, path):
        return {path}.union(*(table.keys(f"{path}.{kind}") for kind, table in self.of.items()))

    def used(self, path, value):
        kind = next(key for key in value if key in self.of)
        return {path} | self.of[kind].used(f"{path}.{kind}", value)


class Named:
    """Tables by name."""

    def __init__(self, node):
        self.node = node

    def keys(self, path):
        return self.node.keys(path)

    def used(self, path, value):
        return {path}.union(*(self.node.used(path, item) for item in value.values()))


class Parts:
    """An array that may be given in part: by names of components."""

    def __init__(self, names):
        self.names = names

    def keys(self, path):
        return {path} | {f"{path}.{name}" for name in self.names}

    def used(self, path, value):
        return {path} | ({f"{path}.{name}" for name in value} if isinstance(value, dict) else set())


class Either:
    """A table, a list of such, or a plain value."""

    def __init__(self, leaf, table):
        self.leaf, self.table = leaf, table

    def keys(self, path):
        return self.leaf.keys(path) | self.table.keys(path)

    def used(self, path, value):
        if isinstance(value, list) and value and isinstance(value[0], dict):
            return {path}.union(*(self.table.used(path, item) for item in value))
        return (self.table if isinstance(value, dict) else self.leaf).used(path, value)


def _kind(cls):
    """The key that tells a table's kind, or None."""
    return cls.kind if isinstance(cls.kind, str) else None


def _word(value):
    return str(value).lower() if isinstance(value, bool) else value


def _shape(value):
    """ "3" or "3x3" """
    return f"{len(value)}x{len(value[0])}" if isinstance(value[0], list) else str(len(value))


def _axis(value):
    first = value[0] if isinstance(value, list) and not isinstance(value[0], (int, float)) else value
    return "name" if isinstance(first, str) else "vector"


def build(field):
    """The node of a field of the schema."""
    found = [*_pieces(field.annotation), *(piece for item in field.metadata for piece in _told(item))]
    classes = [piece for piece in found if isinstance(piece, type)]
    facts = [piece for piece in found if isinstance(piece, tuple)]

    for what, value in facts:
        if what == "named":
            return Named(value)
        if what == "components":
            return Parts(value)

    leaf = _leaf(dict(facts))
    if not classes:
        return leaf

    # these drivers are those of joints of one coordinate, whose keys are counted there
    if classes[0] is ParameterDriver:
        return leaf

    if classes[0] is PoseDriver:
        return Parts(tuple(PoseDriver.model_fields))

    table = Kinds(classes) if _kind(classes[0]) else Table(classes[0])
    return Either(leaf, table)


def _leaf(facts):
    if "options" in facts:
        return Leaf(options=facts["options"])
    if "shapes" in facts:
        return Leaf(form=_shape, forms=["x".join(map(str, shape)) for shape in facts["shapes"]])
    return Leaf(form=_axis, forms=("name", "vector")) if "axis" in facts else Leaf()


def _pieces(annotation):
    """What an annotation is made of: classes of tables, and facts (what, value)."""
    if isinstance(annotation, type) and issubclass(annotation, Part):
        return [annotation] if annotation.model_fields else []

    origin, arguments = typing.get_origin(annotation), typing.get_args(annotation)

    if origin is dict and not any("components" in piece for piece in map(str, arguments)):
        inner = [piece for piece in _pieces(arguments[1]) if isinstance(piece, type)]
        if inner:
            return [("named", Kinds(inner) if _kind(inner[0]) else Table(inner[0]))]
        options = dict(piece for piece in _pieces(arguments[0]) if isinstance(piece, tuple))
        return [("components", options["options"])] if "options" in options else []

    return [piece for item in arguments for piece in (*_pieces(item), *_told(item))]


def _told(validator):
    """What a validator of the schema says of its values, as facts."""
    function = getattr(validator, "func", None)

    if function is None:
        return []
    if function is fields.axis:
        return [("axis", True)]
    if function is typing.get_args(fields.Boolean)[1].func:
        return [("options", ("true", "false"))]
    if function is typing.get_args(fields.Flag)[1].func:
        return [("options", ("true",))]

    cells = dict(
        zip(function.__code__.co_freevars, (cell.cell_contents for cell in function.__closure__ or ()))
    )

    if "options" in cells:
        also = ("true",) if function.__name__ == "true_or_some" else ()
        return [("options", (*cells["options"], *also))]
    if "names" in cells:
        return [("components", tuple(cells["names"]))]
    if len(cells.get("shapes", ())) > 1:
        return [("shapes", cells["shapes"])]
    return []


SCHEMA = Table(Scene)


def _plain(keys):
    return {key.removeprefix(".") for key in keys} - {""}


def all_keys() -> set[str]:
    """Every key of the schema."""
    return _plain(SCHEMA.keys(""))


def keys_of(data: dict) -> set[str]:
    """The keys that a scene uses."""
    return _plain(SCHEMA.used("", data))


def count(scenes) -> Counter:
    """In how many scenes each key of the schema is."""
    counts = Counter(dict.fromkeys(all_keys() - LEFT_OUT.keys(), 0))

    for data in scenes:
        counts.update(keys_of(data))

    return counts


def table(counts: Counter, least: int = LEAST) -> str:
    """The counts as text, keys that are in fewer scenes than `least` marked and named again at the end."""
    width = max(map(len, counts))
    lines = [f"{key:{width}} {n:6}{'' if n >= least else '  *'}" for key, n in sorted(counts.items())]
    rare = [key for key, n in sorted(counts.items()) if n < least]
    lines.append(f"{len(counts)} keys, {len(rare)} of them in fewer than {least} scenes")
    return "\n".join([*lines, *(f"    {key}" for key in rare)])
