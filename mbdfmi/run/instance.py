"""One run of a model in process: the same kernels as in an FMU, called as an FMU's master would."""

import re
from collections.abc import Callable, Mapping
from pathlib import Path
from typing import NamedTuple

import numpy as np

from ..compiler.model import Model
from ..kernels import entry
from ..kernels.status import MESSAGES, MOST_NOTICES, OK
from ..native.library import addresses, kernel_at
from ..scene import variable_name
from .inputs import known, numbers


class SimulationError(Exception):
    """A run stopped; the message says why and when.

    time : s, up to which the motion was found.
    """

    def __init__(self, message: str, time: float):
        super().__init__(message)
        self.time = time


class Instance:
    """One run of a model, to be driven step by step.

    m, d : the kernels' views of it; u : inputs (n_u,), then their derivatives of order 1 to 5 at the
    start of a step, which last one step; y : outputs (n_y,) after
    `outputs`. notices : what a user should be told: of the scene, of its start, and, with the time, of the
    run. The run begins with the inputs' start values, or with `inputs` (position in u -> value).
    kernels : entries of the kernels (`Entries`), those of the library of all scenes unless others are given.
    """

    def __init__(
        self,
        model: Model,
        parameters: Mapping[str, float] | None = None,
        start_time: float = 0.0,
        inputs: Mapping[int, float] | None = None,
        kernels=entry,
    ):
        self.model = model
        self._kernels = kernels
        self.notices = list(model.notices)
        self.reals = model.reals.copy()
        self._prepared: bytes | None = None
        self.m, self.d = model.views(self.reals)
        self.u = self.d.u_buffer
        self.y = np.zeros(model.n_y)
        by_name = {v.name: v for v in model.of_causality("parameter")}
        constants = {v.name for v in model.of_causality("constant")}
        constants |= {name.partition("[")[0] for name in constants}

        for position, value in (inputs or {}).items():
            self.u[position] = value

        for name, value in (parameters or {}).items():
            if name in constants:
                raise ValueError(f"parameter {name!r} is bound: a constant of the model")

            found = [by_name[part].index for part in known(variable_name(name), by_name, "parameter")]
            self.reals[found] = numbers(
                value, f"parameter {name!r}", () if len(found) == 1 else (len(found),)
            )

        self.prepare()
        status = self._kernels.initialise(self.m, self.d, start_time)
        told = self._take_notices()
        self.notices += told
        self._check(status, told)

    def prepare(self):
        """To be called after `reals` was changed; values that stand already change nothing. Raises
        SimulationError.
        """
        if self._prepared != self.reals.tobytes():
            self._prepared = None
            self._check(self._kernels.prepare(self.m, self.d))
            self._prepared = self.reals.tobytes()

    @property
    def time(self) -> float:
        """s, reached so far."""
        return float(self.d.time[0])

    def step(self, H: float):
        """Advance by H (s) with the inputs in `u`. Raises SimulationError."""
        status = self._kernels.step(self.m, self.d, H)
        told = self._take_notices()
        self.notices += [f"{text} (time {self.time:.9g} s)" for text in told]
        self._check(status, told)

    def outputs(self) -> np.ndarray:
        """Outputs (n_y,) now, a view that the next call overwrites. Raises SimulationError."""
        self._check(self._kernels.compute_outputs(self.m, self.d, self.y))
        return self.y

    def _take_notices(self):
        """The kernels' notices (kernels/status.py) in words; they are told then."""
        n = int(self.d.notices[0])
        rows = self.d.notice.reshape(-1, 3)[:n]
        self.d.notices[0] = 0.0
        texts = [explain(self.model, int(status), numbers) for status, *numbers in rows]
        return [*texts, f"and {n - MOST_NOTICES} more of this kind"] if n > MOST_NOTICES else texts

    def _check(self, status, told=()):
        if status != OK:
            text = "; ".join([explain(self.model, status), *told])
            raise SimulationError(f"{text} (time {self.time:.9g} s)", self.time)


class Entries(NamedTuple):
    """What an instance calls: kernels of `kernels.entry` in a library of their own."""

    prepare: Callable
    initialise: Callable
    step: Callable
    compute_outputs: Callable

    @classmethod
    def of(cls, path: Path) -> "Entries":
        """Those of a library of one scene."""
        found = addresses(path)
        symbols = {kernel: symbol for symbol, kernel in entry.ENTRIES.items()}
        kernels = [getattr(entry, name) for name in cls._fields]
        return cls(*(kernel_at(found[symbols[k]], k.signature, symbols[k]) for k in kernels))


def explain(model: Model, status: int, numbers=()) -> str:
    """A kernel's status in words, `%s` being the place and `%g` the numbers."""
    code, place = status % 256, status // 256
    numbers = iter(numbers)
    places = [*model.places, *(v.name for v in model.of_causality("output"))]
    words = {"%s": lambda: places[place], "%g": lambda: f"{next(numbers):.6g}"}
    return re.sub("%[sg]", lambda found: words[found[0]](), MESSAGES[code])
