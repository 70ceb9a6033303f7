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
from . import browser, drawing
from .page import page, rows_of
from .picture import picture

ENDINGS = (".html", ".htm", ".glb", ".png")

# pixels of the picture in an FMU
LARGE = 400, 250

NO_BROWSER = "no chromium or Chrome was found (MBDFMI_BROWSER names one): the picture is drawn without names"


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
        return show(self, path, at)

    def _repr_html_(self):
        """In a notebook: the page."""
        if self.states is None:
            return None

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


def check_view(path, at=None):
    """Raises now the ValueError that `show` would raise later for a file's ending, or for a time without a
    picture.
    """
    check_ending(path, "a page is to be written", *ENDINGS)

    ending = Path(path).suffix.lower()

    if at is not None and ending != ".png":
        raise ValueError(f"{path}: a time (--at) is that of a picture, .png; a page holds them all")

    if ending not in ENDINGS and not to_standard_output(path):
        raise ValueError(
            f"{path}: let its name end in .html (a page), .glb (for Blender and others) or .png (a picture)"
        )


def show(run: Run, path=None, at: float | None = None, tell=lambda text: None) -> Path:
    """Write a run by the ending of the path, or open its page in the browser. Returns the path.

    at : time of a picture, s; by default the last. tell : is told what a user should know of the picture.
    """
    if path is None:
        folder = Path(tempfile.mkdtemp(prefix="mbdfmi-"))
        path = show(run, folder / "view.html")
        webbrowser.open(path.as_uri())
        return path

    check_view(path, at)
    ending = Path(path).suffix.lower()

    if ending == ".png":
        data = picture_at(run, at, tell)
    else:
        rows = None if ending == ".glb" else rows_of(run.states)
        shown = picture(run.scene, run.states, rows)
        data = shown.glb() if ending == ".glb" else page(shown, run, run.notices).encode()

    with replacing(path) as temporary:
        temporary.write_bytes(data)

    return Path(path)


def picture_at(run: Run, at: float | None = None, tell=lambda text: None) -> bytes:
    """A picture (PNG) of a run at a time (s; by default the last): by a browser where there is one.

    Raises ValueError for a time that is not within the run.
    """
    times = run["time"]
    at = float(times[-1] if at is None else at)

    if not times[0] - 1e-9 <= at <= times[-1] + 1e-9:
        raise ValueError(f"--at {at:g}: the run is from {times[0]:g} to {times[-1]:g} s")

    row = int(np.abs(times - at).argmin())
    rows = np.union1d(rows_of(run.states), [row])
    shown = picture(run.scene, run.states, rows)
    chromium = browser.find()

    if chromium is not None:
        try:
            return browser.shoot(chromium, page(shown, None, run.notices), at)
        except OSError as error:
            tell(f"{error}: the picture is drawn without names")
    else:
        tell(NO_BROWSER)

    return drawing.png(drawing.draw(shown, int(np.searchsorted(rows, row)), 1280, 800))


def still(model: Model) -> tuple[bytes, bytes]:
    """Pictures (PNG) of a model at its start, for a page and for an icon, the same on all machines.

    Raises SimulationError where it cannot be assembled, ValueError where a mesh cannot be read.
    """
    shown = picture(model.scene, at_start(model).states)
    large = drawing.draw(shown, 0, *LARGE, grid=False)
    small = large.reshape(LARGE[1] // 2, 2, LARGE[0] // 2, 2, 3).mean(axis=(1, 3)).round().astype(np.uint8)
    return drawing.png(large), drawing.png(small)


def framed(text, height=480):
    """A page in a frame of its own, as notebooks want it; it is all in there, so converted notebooks keep
    it.
    """
    return (
        f'<iframe srcdoc="{html.escape(text)}" style="width: 100%; height: {height}px; border: 0" '
        'sandbox="allow-scripts" loading="lazy"></iframe>'
    )
