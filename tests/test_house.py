"""The house: a room imports from rooms below it alone, nothing runs in a circle, no file is too long.

Read from the sources (ast), imports within functions included.
"""

import ast
from functools import cache
from graphlib import CycleError, TopologicalSorter
from pathlib import Path

import pytest

import mbdfmi.native.sources as kernel_sources

ROOT = Path(__file__).parents[1]
PACKAGE = ROOT / "mbdfmi"

FLOORS = (
    ("vocabulary", "steppers", "units", "files", "lazily", "threads", "vectors", "rotations", "native"),
    ("scene", "kernels", "hydro", "aero"),
    ("compiler",),
    ("run",),
    ("trace",),
    ("analysis", "export", "view"),
    ("cosim", "probe"),
    ("api",),
    ("__init__",),
    ("cli",),
    ("__main__",),
)
"""Rooms of the package, from the ground up; those on one floor know nothing of each other."""

LONGEST = 600
"""Lines of a source file at most."""


@cache
def modules() -> dict[str, Path]:
    """Dotted name below the package -> file; a package stands under its own name and `__init__`."""
    found = {}

    for path in sorted(PACKAGE.rglob("*.py")):
        found[".".join(path.relative_to(PACKAGE).with_suffix("").parts)] = path

    return found


def targets(module, node):
    """Modules of the package (dotted, below it) that an import statement of a module names."""
    if isinstance(node, ast.Import):
        names = [alias.name for alias in node.names]
    else:
        package = ["mbdfmi", *module.split(".")[:-1]]
        base = package[: len(package) + 1 - node.level] if node.level else []
        base = ".".join([*base, *([node.module] if node.module else [])])
        names = [f"{base}.{alias.name}" for alias in node.names]

    for name in names:
        parts = name.split(".")

        if parts[0] == "mbdfmi":
            # a module, else a name in one, else a name in a package
            inside = ".".join(parts[1:])
            candidates = (
                inside,
                f"{inside}.__init__",
                ".".join(parts[1:-1]),
                ".".join([*parts[1:-1], "__init__"]),
            )
            yield next(found for found in candidates if found in modules())


@cache
def imports() -> dict[str, set[str]]:
    """Module -> modules of the package that it imports."""
    found = {}

    for module, path in modules().items():
        tree = ast.parse(path.read_text(encoding="utf-8"))
        statements = [node for node in ast.walk(tree) if isinstance(node, (ast.Import, ast.ImportFrom))]
        found[module] = {target for node in statements for target in targets(module, node)} - {module}

    return found


def room(module):
    """The room, at the top of the package, that a module is in."""
    return module.split(".")[0]


def test_every_room_has_its_floor():
    assert {room(module) for module in modules()} - {name for floor in FLOORS for name in floor} == set()


def test_the_hash_of_the_kernels_sees_all_that_they_import():
    outside = {target for module, found in imports().items() if room(module) == "kernels" for target in found}
    assert {target for target in outside if room(target) not in ("kernels", "native")} == set(
        kernel_sources.OUTSIDE
    )


def test_a_room_imports_from_rooms_below_it_alone():
    height = {name: k for k, floor in enumerate(FLOORS) for name in floor}
    wrong = [
        f"{module} imports {target}"
        for module, found in imports().items()
        for target in found
        if room(module) != room(target) and height[room(target)] >= height[room(module)]
    ]
    assert wrong == []


def circle(graph):
    """Some nodes that stand in a circle, or None."""
    try:
        TopologicalSorter(graph).prepare()
    except CycleError as error:
        return error.args[1]


def test_no_module_imports_itself_through_others():
    """A package's own face (its `__init__`) may import what is in it."""
    assert circle(imports()) is None


def test_no_room_within_a_room_stands_in_a_circle():
    """Folders of a folder, and the modules beside them, at every depth."""
    folders = {".".join(module.split(".")[:-1]) for module in modules()} - {""}

    for folder in folders:
        prefix = f"{folder}."
        graph = {}

        for module, found in imports().items():
            if module.startswith(prefix) and not module.endswith("__init__"):
                part = module.removeprefix(prefix).split(".")[0]
                inside = {
                    target.removeprefix(prefix).split(".")[0] for target in found if target.startswith(prefix)
                }
                graph.setdefault(part, set()).update(inside - {part, "__init__"})

        assert circle(graph) is None, folder


def sources():
    """Files that people write and read: Python of the package and beside it, and C."""
    folders = {"mbdfmi": "*.py", "benchmarks": "*.py", "models": "*.py", "fmu_src": "*.[ch]"}
    return [path for folder, pattern in folders.items() for path in sorted((ROOT / folder).rglob(pattern))]


def test_no_source_file_is_too_long():
    long = {
        path.relative_to(ROOT).as_posix()
        for path in sources()
        if len(path.read_text(encoding="utf-8").splitlines()) > LONGEST
    }
    assert not long


@pytest.mark.parametrize("place", ["new.py", "motion/new.py", "motion/deep/new.py"])
def test_the_hash_of_the_kernels_sees_every_file(monkeypatch, tmp_path, place):
    """Compiled kernels are kept by it: a change that it misses would leave old ones in use."""
    monkeypatch.setattr(kernel_sources, "KERNELS", tmp_path)
    monkeypatch.setattr(kernel_sources, "OUTSIDE", ())

    def digest():
        return kernel_sources.source_hash.__wrapped__()

    (tmp_path / place).parent.mkdir(parents=True, exist_ok=True)
    (tmp_path / "sources.py").write_text("")
    before = digest()
    (tmp_path / place).write_text("a = 1\n")
    written = digest()
    (tmp_path / place).write_text("a = 2\n")
    assert len({before, written, digest()}) == 3
    (tmp_path / place).rename((tmp_path / place).with_name("other.py"))
    assert len({before, written, digest()}) == 3
