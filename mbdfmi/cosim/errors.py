"""What is wrong with a coupled system, or went wrong in a run of it."""

from __future__ import annotations

from typing import TYPE_CHECKING

if TYPE_CHECKING:
    from ..run.results import Results


class CouplingError(Exception):
    """FMUs that do not fit together, or one that gave up; the message says which, and when.

    errors : list of str, one complete message for each thing that is wrong.
    results : of the run up to where it stopped, or None.
    """

    def __init__(self, errors: str | list[str], results: Results | None = None):
        self.errors = [errors] if isinstance(errors, str) else list(errors)
        self.results = results
        super().__init__("\n".join(self.errors))


class Discarded(Exception):
    """An FMU did a part of a step only; `time` (s) is what it reached."""

    def __init__(self, name: str, time: float):
        super().__init__(f"{name}: reached {time:.9g} s")
        self.time = time


class Ended(Exception):
    """An FMU asks for the end of the run."""
