"""Names of links and joints as names of a scene."""

import unicodedata

from ..errors import quoted
from ..names import FRAMES


class Names:
    """Gives names of a file their names in a scene, each once.

    what : "link", "joint". changed : {name of the file: that of the scene} where these differ.
    """

    def __init__(self, what, taken=()):
        self.what = what
        self.taken = set(taken)
        self.changed = {}

    def all_of(self, names):
        """{name of the file: name in the scene}; those that a scene may have stay what they are."""
        fit = [name for name in names if self._fit(name) == name]
        found = {name: self.new(name) for name in fit}
        self.changed = {name: self.new(self._fit(name)) for name in names if name not in found}
        return {name: (found | self.changed)[name] for name in names}

    def new(self, name, suffix=""):
        """The name, or where it is taken the first like it that is free."""
        options = [name, *([name + suffix] if suffix else [])]
        options += [f"{name}{suffix}_{k}" for k in range(2, len(self.taken) + 3)]
        free = next(option for option in options if option not in self.taken)
        self.taken.add(free)
        return free

    def told(self):
        """Lines that tell what was changed."""
        pairs = ", ".join(f"{quoted(name)} is {quoted(plain)}" for name, plain in self.changed.items())
        return [f"names of {self.what}s that a scene does not have: {pairs}"] if pairs else []

    def _fit(self, name):
        """The name as a scene may have it."""
        plain = "".join(c for c in name if unicodedata.category(c) not in ("Cc", "Cs", "Zl", "Zp"))
        plain = plain.strip().replace(".", "_") or self.what
        return f"{plain}_{self.what}" if plain in FRAMES else plain
