"""What is wrong with a scene, said so that its author can mend it.

A `Problem` is one thing that is wrong: where (a path of keys into the scene) and what. A
`SceneError` carries all problems of a file. Its text reads

    arm.toml: [joint.elbow] between: no marker "elbw" on body "upper"; it has "elbow" and "tip".
    Did you mean "upper.elbow"?
"""

import json
import re
from dataclasses import dataclass
from difflib import get_close_matches

# Tables whose entries have names of their own, as [body.upper], and other tables.
NAMED_TABLES = ("body", "joint", "coupling", "force", "measure")
TABLES = ("ground", "solver", "experiment", "code", "view", "central_gravity", "sea", "wind")


@dataclass(frozen=True)
class Problem:
    """One thing that is wrong.

    path : keys (str) and 0-based list positions (int) from the scene to the place.
    text : what was found there and what would do.
    """

    path: tuple
    text: str

    def __str__(self):
        place = place_text(self.path)
        return f"{place} {self.text}" if place else self.text


class SceneError(Exception):
    """A scene cannot be read or makes no sense.

    problems : list of `Problem`.
    file : name of the file the scene came from, or None.
    errors : list of str, one complete message per problem.
    """

    def __init__(self, problems, file=None):
        self.problems = list(problems)
        self.file = file
        prefix = f"{file}: " if file else ""
        self.errors = [prefix + str(problem) for problem in self.problems]
        super().__init__("\n".join(self.errors))


def place_text(path, named=NAMED_TABLES, tables=TABLES):
    """The place of a problem as it is looked for in a file, `[body.hull] solid[2].box.size:`.

    named, tables : tables of the file whose entries have names, and others. Positions in lists count from 1, as those of
    FMU variables.
    """
    path = list(path)
    if not path:
        return ""

    in_table = path[0] in (*named, *tables)
    depth = (2 if path[0] in named else 1) if in_table else 0
    table, keys = path[:depth], path[depth:]

    words = []
    if table:
        words.append("[" + ".".join(key_text(key) for key in table) + "]")
    if keys:
        dotted = ".".join(f"[{k + 1}]" if isinstance(k, int) else key_text(k) for k in keys)
        words.append(dotted.replace(".[", "[") + ":")

    return " ".join(words)


def key_text(key):
    """A key as TOML writes it: bare where that is allowed, else quoted."""
    return key if re.fullmatch(r"[A-Za-z0-9_-]+", str(key)) else quoted(str(key))


def quoted(text):
    """A string as TOML writes it, on one line."""
    text = json.dumps(text, ensure_ascii=False).replace("\x7f", "\\u007f")
    # halves of surrogate pairs, which Python's strings may hold, cannot be printed
    return text.encode("utf-8", "backslashreplace").decode()


def show(value, limit=60):
    """A short picture of a value found in a scene, written as in TOML."""
    if value is None:
        return "nothing"
    if isinstance(value, bool):
        return str(value).lower()
    if isinstance(value, str):
        return quoted(value if len(value) <= limit else value[: limit - 3] + "...")
    if isinstance(value, dict):
        return "a table" if value else "an empty table"

    if isinstance(value, (list, tuple)):
        if not value:
            return "an empty list"
        plain = not any(isinstance(item, (list, tuple, dict)) for item in value)
        if plain and len(value) <= 9:
            text = "[" + ", ".join(show(item) for item in value) + "]"
            if len(text) <= limit:
                return text
        if all(isinstance(item, (list, tuple)) for item in value):
            lengths = sorted({len(item) for item in value})
            some = f"{lengths[0]} to {lengths[-1]}" if len(lengths) > 1 else lengths[0]
            return f"{len(value)} row{'s' * (len(value) > 1)} of {some}"
        return f"a list of {len(value)}"

    # int first: Python refuses to print very long ones, and they do not fit a float
    if isinstance(value, int) and abs(value) > 10**20:
        return "a whole number of more than 20 digits"

    text = str(value)
    return text if len(text) <= limit else text[: limit - 3] + "..."


def listed(words, joiner="and", limit=12):
    """`"a", "b" and "c"`; a long list is cut short."""
    words = [quoted(word) for word in words]
    if len(words) > limit:
        return ", ".join(words[:limit]) + f" {joiner} {len(words) - limit} more"
    if len(words) < 2:
        return "".join(words)
    return ", ".join(words[:-1]) + f" {joiner} {words[-1]}"


def nearest(word, options):
    """The options that a word that is none of them may be meant for; [] when none is near."""
    # compared in lower case, answered as written
    spelt = {option.lower(): option for option in options}
    word = str(word).lower()

    # the word itself in other case; then `mass_kg` is meant to be `mass`, `zyx` one of `zyx_deg`
    # and `zyx_rad`, `rk45` to be `rk54`, `coeff` to be `coefficient`; only after these what is
    # nearest by letters
    near = (
        [option for option in spelt if option == word]
        or [option for option in spelt if word.startswith(option + "_")]
        or [option for option in spelt if option.startswith(word + "_")]
        or [option for option in spelt if sorted(option) == sorted(word)]
        or [option for option in spelt if option.startswith(word) and len(word) > 2]
        or get_close_matches(word, list(spelt), n=1, cutoff=0.65)
    )
    return [spelt[option] for option in near]


def did_you_mean(word, options):
    """` Did you mean "x"?` for the option nearest to the word, or nothing when none is near."""
    near = nearest(word, options)
    return f" Did you mean {listed(near, 'or')}?" if near else ""
