"""Scenes and runs shown: to files by their endings, in the browser, in a notebook."""

import html
import tempfile
import webbrowser
from pathlib import Path

import numpy as np

from ..compiler.model import Model
from ..files import check_ending, replacing, to_standard_output
from ..run.instance import Instance
from ..run.results import Results
from ..run.states import States
from .page import page
from .picture import picture

ENDINGS = (".html", ".htm", ".glb")


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

    def view(self, path=None) -> Path:
        """Write the run as a page (.html) that plays it, or as an animated GLB; without a path, open it.

        Returns the path. Raises ValueError for another ending, and where a mesh cannot be read.
        """
        return show(self, path)

    def _repr_html_(self):
        """In a notebook: the page."""
        return framed(page(picture(self.scene, self.states), self, self.notices)) if self.states else None


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


def check_view(path):
    """Raises now the ValueError that `show` would raise later for a file's ending."""
    check_ending(path, "a page is to be written", *ENDINGS)

    if Path(path).suffix.lower() not in ENDINGS and not to_standard_output(path):
        raise ValueError(f"{path}: let its name end in .html (a page) or .glb (for Blender and others)")


def show(run: Run, path=None) -> Path:
    """Write a run by the ending of the path, or open its page in the browser. Returns the path."""
    if path is None:
        folder = Path(tempfile.mkdtemp(prefix="mbdfmi-"))
        path = show(run, folder / "view.html")
        webbrowser.open(path.as_uri())
        return path

    check_view(path)
    shown = picture(run.scene, run.states)
    data = shown.glb() if Path(path).suffix.lower() == ".glb" else page(shown, run, run.notices).encode()

    with replacing(path) as temporary:
        temporary.write_bytes(data)

    return Path(path)


def framed(text, height=480):
    """A page in a frame of its own, as notebooks want it; it is all in there, so converted notebooks keep
    it.
    """
    return (
        f'<iframe srcdoc="{html.escape(text)}" style="width: 100%; height: {height}px; border: 0" '
        'sandbox="allow-scripts" loading="lazy"></iframe>'
    )
