"""The kernels as plain Python functions that compute with symbols.

They are the functions of `mbdfmi.kernels` themselves, whatever they are compiled by in this process, with
other globals: `math`, `min` and `max` take symbols, kernels call each other as plain functions, and a few
are replaced.
"""

import sys
from collections.abc import Callable
from types import FunctionType, ModuleType, SimpleNamespace

from ..kernels import entry
from .symbols import MATH, NUMPY, maximum, minimum, whole

ROOM = entry.__name__.rpartition(".")[0]
"""The dotted name of the kernels' package."""


def plain_function(function):
    """The Python function that a kernel is written as, or None for what is no kernel."""
    function = getattr(function, "py_func", function)
    function = getattr(function, "__wrapped__", function)
    return function if isinstance(function, FunctionType) and _is_ours(function.__module__) else None


def _is_ours(module):
    return module == ROOM or module.startswith(f"{ROOM}.")


class Kernels:
    """Copies of the kernels' modules.

    replaced : "module.function", dotted below the kernels' package -> what makes another function of that
    one.
    """

    def __init__(self, replaced: dict[str, Callable]):
        self._replaced = replaced
        self._modules: dict[str, SimpleNamespace] = {}

    def __getitem__(self, name: str) -> SimpleNamespace:
        """A module by its dotted name below the kernels' package."""
        return self._module(sys.modules[f"{ROOM}.{name}"])

    def _module(self, module):
        found = self._modules.get(module.__name__)

        if found is None:
            found = self._modules[module.__name__] = SimpleNamespace()
            names = found.__dict__
            names |= {"__name__": module.__name__, "max": maximum, "min": minimum, "int": whole}
            names |= {
                name: self._copy(module, name, value)
                for name, value in vars(module).items()
                if not name.startswith("__")
            }

        return found

    def _copy(self, module, name, value):
        """What a name of a module stands for in its copy."""
        if isinstance(value, ModuleType):
            return self._module(value) if _is_ours(value.__name__) else _STAND_INS.get(value.__name__, value)

        function = plain_function(value)

        if function is None:
            return value

        if function.__module__ != module.__name__:
            return getattr(self._module(sys.modules[function.__module__]), function.__name__)

        made = FunctionType(
            function.__code__,
            self._modules[module.__name__].__dict__,
            function.__name__,
            function.__defaults__,
            function.__closure__,
        )
        replace = self._replaced.get(f"{module.__name__.removeprefix(ROOM + '.')}.{name}")
        return replace(made) if replace else made


_STAND_INS = {"math": MATH, "numpy": NUMPY}
