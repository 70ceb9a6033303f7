"""Packages that are imported when something of them is first asked for.

Few scenes need them, and every command would wait.
"""

from importlib import import_module


class _Lazy:
    def __init__(self, name):
        self._name = name

    def __getattr__(self, name):
        found = getattr(import_module(self._name), name)
        setattr(self, name, found)
        return found


scipy = _Lazy("scipy")
webcolors = _Lazy("webcolors")
