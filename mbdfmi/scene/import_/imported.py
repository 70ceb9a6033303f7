"""What a reader of another format hands on."""

from dataclasses import dataclass, field
from textwrap import wrap

from ..writer import WIDTH


@dataclass
class Imported:
    """A model of another format as a scene.

    tables : the scene, as `Scene.model_validate` takes it.
    source : in words, what it was read from.
    decided, left_out : lines, what was decided where the file leaves it open, and what of it a scene cannot say.
    comments : {path of a table in the scene: lines to stand above it}.
    """

    tables: dict
    source: str
    decided: list[str] = field(default_factory=list)
    left_out: list[str] = field(default_factory=list)
    comments: dict[tuple, list[str]] = field(default_factory=dict)

    @property
    def notes(self):
        """All that is told (list of str)."""
        return [*self.decided, *(f"left out: {line}" for line in self.left_out)]

    def commented(self):
        """The comments of a scene file that is made of it, with one at its head, for `writer.toml_text`."""
        head = [f"Made from {self.source}."]

        for heading, lines in (("Decided:", self.decided), ("Left out:", self.left_out)):
            if lines:
                head += [heading, *(part for line in lines for part in _wrapped(line))]

        return {(): head} | self.comments


def _wrapped(line):
    """A line of a list in lines of a file."""
    return wrap(
        line,
        WIDTH,
        initial_indent="- ",
        subsequent_indent="  ",
        break_long_words=False,
        break_on_hyphens=False,
    )
