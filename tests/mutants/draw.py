"""The mutants of a seed: as many of each part of the package as asked, of all kinds in turn.

A mutant's lot is a hash of the seed and of what it changes,
so a change of the package elsewhere draws the others again.
"""

import hashlib
from itertools import count

from .operators import Mutant, changes, defaults_of, mutants_of
from .reach import sources

UNTOUCHED = (
    "kernels/language.py", "kernels/compiling.py", "kernels/compiled_views.py", "kernels/ahead.py",
    "kernels/layout.py", "kernels/status.py", "scene/errors.py", "scene/messages.py",
)  # fmt: skip
"""What compiles the kernels, names of arrays, and texts of messages."""


def name_of(mutant: Mutant) -> str:
    """A name that stays while the line does: file, function, and a hash of what changes."""
    return f"{mutant.file}:{mutant.function}:{_lot(0, mutant)[:6]}"


def _lot(seed, mutant):
    what = (mutant.file, mutant.function, mutant.kind, mutant.before, mutant.after)
    return hashlib.sha256(repr((seed, what)).encode()).hexdigest()


def draw(seed: int, numbers: dict[str, int]) -> list[Mutant]:
    """As many mutants of each part as `numbers` says, at most one of a line."""
    texts = sources()
    defaults = defaults_of(texts)
    drawn = []

    for part, number in numbers.items():
        by_kind = {}

        for file, text in texts.items():
            if file.startswith(f"{part}/") and file not in UNTOUCHED:
                for mutant in mutants_of(file, text, defaults):
                    by_kind.setdefault(mutant.kind, []).append(mutant)

        for found in by_kind.values():
            found.sort(key=lambda mutant: _lot(seed, mutant))

        kinds = sorted(by_kind, key=lambda kind: _lot(seed, by_kind[kind][0]))
        taken, places = [], set()

        for k in count():
            found = by_kind[kinds[k % len(kinds)]]

            while found and ((found[0].file, found[0].line) in places or not changes(found[0])):
                found.pop(0)

            if found:
                taken.append(found.pop(0))
                places.add((taken[-1].file, taken[-1].line))

            if len(taken) == number or not any(by_kind.values()):
                break

        drawn += taken

    return drawn
