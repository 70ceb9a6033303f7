"""What an FMU proposes for a run of it. No number of the simulation depends on it."""

from pydantic import model_validator

from .fields import Number, Part, Positive, Tolerance


class Experiment(Part):
    """What an FMU proposes to tools for a run: its DefaultExperiment. Tools may do otherwise.

    start, stop : s.
    step : s, from one communication point to the next.
    tolerance : relative; the solver's own when left out, as far as it has one. A tool that takes it up gives it to its own
        solver in model exchange, and to the scene's in co-simulation, where it then counts instead of `solver.tolerance`.
    """

    start: Number = 0.0
    stop: Number = 10.0
    step: Positive = 0.01
    tolerance: Tolerance | None = None

    @model_validator(mode="after")
    def _check_order(self):
        if not self.stop > self.start:
            raise ValueError(f"stop must be after start ({self.start:g}), found {self.stop:g}")
        return self
