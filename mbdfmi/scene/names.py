"""Names: free text in a scene, structured names in an FMU."""

import re
import unicodedata
from functools import lru_cache
from typing import Annotated

from pydantic import BeforeValidator

from .errors import quoted, show

# Names of the structured convention (FMI 2.0.4, section 2.2.9): an identifier stays, other text is
# put in single quotes, within which these ASCII characters stand for themselves.
IDENTIFIER = re.compile(r"[A-Za-z_][A-Za-z0-9_]*")
QUOTABLE = frozenset("!#$%&()*+,-./:;<>=?@[]^{}|~ _")
ESCAPED = frozenset("'\"\\")

# Names that frames have already: that of the assembly, which a motion may be prescribed for, and
# the one at rest.
FRAMES = ("ground", "inertial")


@lru_cache(4096)
def fmi_name(text):
    """The text as one part of a structured FMI 2.0 variable name.

    `blade_1` stays; `blade 1` becomes `'blade 1'`. The convention is ASCII only, so accents are
    dropped (`Flügel` becomes `Flugel`) and other characters become their code point, `(U+03B1)`.
    """
    letters = []
    for character in unicodedata.normalize("NFKD", text):
        if unicodedata.combining(character):
            continue
        if character.isascii() and (character.isalnum() or character in QUOTABLE | ESCAPED):
            letters.append(character)
        else:
            letters.append(f"(U+{ord(character):04X})")

    plain = "".join(letters)
    if IDENTIFIER.fullmatch(plain):
        return plain
    return "'" + "".join("\\" + c if c in ESCAPED else c for c in plain) + "'"


def variable_name(text):
    """The FMI name of a variable that is written with a scene's names as they are: `Flügel.mass`, `blade 1.position[2]`.

    FMI names stay as they are.
    """
    base, subscript = re.fullmatch(r"(.*?)((?:\[[\d,]+\])?)", text, re.DOTALL).groups()
    parts = base.split(".")
    return ".".join(part if re.fullmatch("'.*'", part) else fmi_name(part) for part in parts) + subscript


def is_printable(text):
    """Whether a text has no control characters and can be written as UTF-8."""
    return all(unicodedata.category(c) not in ("Cc", "Cs", "Zl", "Zp") for c in text)


def _text(value):
    if not isinstance(value, str):
        raise ValueError(f"needs a text in quotes, found {show(value)}")
    if not is_printable(re.sub(r"[\t\n\r]", " ", value)):
        raise ValueError(f"control characters are not allowed, found {show(value)}")
    return value


def _title(value):
    value = _text(value).strip()
    if not value:
        raise ValueError("is empty; write a text of one line")
    if not is_printable(value):
        raise ValueError(f"needs one line of text, found {show(value)}")
    return value


def _name(value):
    """The name of an entry, or ValueError."""
    if not isinstance(value, str):
        raise ValueError(f"a name is a text, found {show(value)}")
    name = value.strip()
    if not name:
        raise ValueError("a name must not be empty")
    if "." in name:
        raise ValueError(f"a name has no dots, since dots join names; write {quoted(name.replace('.', '_'))}")
    if not is_printable(name):
        raise ValueError("a name has no control characters")
    if name in FRAMES:
        raise ValueError(f"{quoted(name)} is the name of a frame that is always there; use another")
    return name


# Free text; free text on one line, not empty; the name of a body, marker, joint or force.
Text = Annotated[str, BeforeValidator(_text)]
Title = Annotated[str, BeforeValidator(_title)]
Name = Annotated[str, BeforeValidator(_name)]
