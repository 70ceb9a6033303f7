"""The text of a kernel, and what can be said of its names without knowing what they stand for."""

import ast
import inspect
import sys
from functools import cache
from types import FunctionType
from typing import NamedTuple


class Reading(NamedTuple):
    """A kernel as it is written. parameters : their names. names : these and those of variables. counters :
    names that loops alone give values to, and that are read in these loops alone.
    """

    body: list[ast.stmt]
    parameters: list[str]
    names: frozenset[str]
    counters: frozenset[str]


@cache
def _functions(module):
    """Functions of a module by name."""
    tree = ast.parse(inspect.getsource(sys.modules[module]))
    return {node.name: node for node in tree.body if isinstance(node, ast.FunctionDef)}


@cache
def reading(python: FunctionType) -> Reading:
    """The text of a kernel, read."""
    tree = _functions(python.__module__)[python.__name__]
    parameters = [argument.arg for argument in tree.args.args]
    loops: dict[str, int] = {}
    stored, others = set(), set()

    def look(node):
        name = node.id if isinstance(node, ast.Name) else ""

        if (
            isinstance(node, ast.For)
            and isinstance(node.target, ast.Name)
            and isinstance(node.iter, ast.Call)
        ):
            target = node.target.id
            stored.add(target)
            look(node.iter)
            loops[target] = loops.get(target, 0) + 1

            for statement in node.body:
                look(statement)

            loops[target] -= 1
            return

        if name and isinstance(node.ctx, ast.Store):
            stored.add(name)
            others.add(name)
        elif name and not loops.get(name):
            others.add(name)

        for each in ast.iter_child_nodes(node):
            look(each)

    for statement in tree.body:
        look(statement)

    names = stored.union(parameters)
    return Reading(tree.body, parameters, frozenset(names), frozenset(stored - others - set(parameters)))
