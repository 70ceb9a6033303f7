"""Results of runs that can be looked at; what draws them is imported when they are."""

from pathlib import Path

import numpy as np

from ..compiler.model import Model
from ..run.instance import Instance
from ..run.results import Results
from ..run.states import States


class Run(Results):
    """Results of a run of a scene, which can be looked at."""

    @classmethod
    def of(cls, results: Results) -> "Run":
        """The same results."""
        run = cls.__new__(cls)
        run.__dict__ |= results.__dict__
        return run

    @property
    def scene(self):
        """That was run. Raises ValueError for a table that is no run of a scene."""
        if self.states is None:
            raise ValueError("these are columns alone, without the states of a run: there is nothing to draw")

        return self.states.model.scene

    def view(self, path=None, at: float | None = None) -> Path:
        """Write the run as a page (.html) that plays it, as an animated GLB, or as a picture (.png) at a time
        (s; by default the last); without a path, open the page.

        Returns the path. Raises ValueError for another ending, and where a mesh cannot be read.
        """
        from .show import show

        return show(self, path, at)

    def _repr_html_(self):
        """In a notebook: the page."""
        if self.states is None:
            return None

        from .page import page, rows_of
        from .picture import picture
        from .show import framed

        return framed(page(picture(self.scene, self.states, rows_of(self.states)), self, self.notices))


def at_start(model: Model, parameters=None, inputs=None) -> Run:
    """A run of no length: the scene assembled; inputs and parameters by name. Raises SimulationError where
    it cannot be.
    """
    place = {v.name: v.index for v in model.of_causality("input")}
    instance = Instance(
        model, parameters, inputs={place[name]: value for name, value in (inputs or {}).items()}
    )
    instance.outputs()
    states = States(model, 1)
    states.keep(0, instance)
    return Run({"time": np.zeros(1)}, {"time": "s"}, model.title, instance.notices, states)
