"""Operators break what they should; the lists of lines are true of the sources as they are."""

import ast
from pathlib import Path

import pytest

from . import draw, equivalent, operators, reach
from .hunt import THOROUGH
from .reach import PACKAGE, ROOT
from .undone import UNDONE

SCHEMA = """
class Options:
    gain: float = 1.0

def turned(a, b, shift=0.0):
    return a
"""

CASES = [
    ("sign", "def f(a, c):\n    return a + c", "return a - c"),
    ("sign", "def f(u, v):\n    return al.add(u, v)", "return al.sub(u, v)"),
    ("term dropped", "def f(a, c):\n    return a - 2 * c", "return a"),
    ("term dropped", "def f(u, v):\n    return al.axpy(2.0, u, v)", "return v"),
    ("unary minus", "def f(a):\n    return -a", "return a"),
    ("unary minus", "def f(a):\n    return al.neg(a)", "return a"),
    ("index", "def f(p):\n    return p[0]", "return p[1]"),
    ("index", "def f(p, i):\n    return p[3 * i + 2]", "return p[3 * i]"),
    ("transposed", "def f(A, u):\n    return al.mat_vec(A, u)", "return al.matT_vec(A, u)"),
    ("transposed", "def f(A, u):\n    return A.T @ u", "return A @ u"),
    ("swapped arguments", "def f(u, v):\n    return al.cross(u, v)", "return al.cross(v, u)"),
    ("swapped names", "def f(omega, alpha):\n    return omega * 3", "return alpha * 3"),
    (
        "swapped names",
        'def f(found):\n    return found["omega"] if "alpha" in found else 0',
        'return found["alpha"] if',
    ),
    ("key ignored", "def f(options):\n    return options.gain", "return 1.0"),
    ("key ignored", "def f(a, b):\n    return turned(a, b, shift=a)", "return turned(a, b)"),
    ("factor", "def f(a, c):\n    return 2.0 * (a + c)", "return (a + c)"),
    ("factor", "def f(a):\n    return a**2", "return a**3"),
    ("comparison", "def f(a, c):\n    return a < c", "return a >= c"),
    ("comparison", "def f(a, c):\n    return a and c", "return a or c"),
    ("statement dropped", "def f(p, c):\n    p[0] = c", "pass"),
    ("statement dropped", "def f(a, c):\n    a += c\n    return a", "pass"),
]


def mutants(text, file="kernels/some.py"):
    """Mutants of a text in a file, beside the schema."""
    return operators.mutants_of(file, text, operators.defaults_of({"scene/schema.py": SCHEMA}))


@pytest.mark.parametrize("kind, text, after", CASES)
def test_operators(kind, text, after):
    file = "compiler/some.py" if kind == "key ignored" else "kernels/some.py"
    found = [mutant for mutant in mutants(text, file) if mutant.kind == kind]
    assert [mutant for mutant in found if mutant.after.startswith(after)], [mutant.after for mutant in found]

    for mutant in found:
        assert operators.changes(mutant)
        assert mutant.reached_by[0] == 2 and mutant.line == 2


def test_what_a_message_says_is_left_alone():
    text = 'def f(a):\n    """a + 1 of p[0]"""\n    raise ValueError(f"{a + 1} is -{a}")\n'
    assert mutants(text) == []


def test_letters_beyond_ascii_shift_no_place():
    text = 'NAMES = {"Flügel": 1}\n\ndef f(ä, b):\n    return ä + b\n'
    found = [mutant for mutant in mutants(text) if mutant.kind == "sign"]
    assert [mutant.after for mutant in found] == ["return ä - b"]


def test_the_draw_is_that_of_its_seed():
    numbers = {"compiler": 12, "scene": 3}
    drawn = draw.draw(1, numbers)
    assert drawn == draw.draw(1, numbers)
    assert drawn != draw.draw(2, numbers)
    kinds = {mutant.kind for mutant in drawn if mutant.file.startswith("compiler")}
    assert kinds >= {"sign", "index", "transposed", "key ignored"}
    assert len({(mutant.file, mutant.line) for mutant in drawn}) == len(drawn) == 15

    for mutant in drawn:
        assert operators.changes(mutant)


def test_equivalent_mutants_are_lines_of_the_package():
    for file, before, _, why in equivalent.EQUIVALENT:
        text = " ".join((PACKAGE / file).read_text(encoding="utf-8").split())
        assert before in text and len(why) > 20, f"{file}: {before}"


@pytest.mark.parametrize("undone", UNDONE, ids=lambda undone: undone.name)
def test_mendings_can_be_undone(undone):
    text = (PACKAGE / undone.file).read_text(encoding="utf-8")
    assert text.count(undone.before) == 1
    assert ast.dump(ast.parse(text.replace(undone.before, undone.after))) != ast.dump(ast.parse(text))


def test_every_rule_is_undone():
    assert {undone.rule for undone in UNDONE} == set(range(1, 14))


def test_files_that_are_run_whole_are_there():
    """Of a mutant's subject, and the subject itself."""
    subjects = {Path(file).stem for file in reach.sources()}
    assert {name for names in THOROUGH for name in names.split()} <= subjects

    for name in " ".join(THOROUGH.values()).split():
        file, _, test = name.partition("::")
        text = (ROOT / "tests" / f"test_{file}.py").read_text(encoding="utf-8")
        assert f"def {test}(" in text or not test


def test_tests_of_undone_mendings_are_there():
    assert all((ROOT / file).exists() for undone in UNDONE for file in undone.tests.split())
