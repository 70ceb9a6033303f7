"""Scenes and runs shown: to files by their endings, in the browser, in a notebook."""

import html
import tempfile
import webbrowser
from pathlib import Path
from typing import Any

import numpy as np

from ..files import check_ending, replacing, to_standard_output
from . import browser, drawing
from .page import page, rows_of
from .picture import picture

ENDINGS = (".html", ".htm", ".glb", ".png")

NO_BROWSER = "no chromium or Chrome was found (MBDFMI_BROWSER names one): the picture is drawn without names"


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


def show(run: Any, path=None, at: float | None = None, tell=lambda text: None) -> Path:
    """Write a `Run` by the ending of the path, or open its page in the browser. Returns the path.

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


def picture_at(run: Any, at: float | None = None, tell=lambda text: None) -> bytes:
    """A picture (PNG) of a `Run` at a time (s; by default the last): by a browser where there is one.

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


def framed(text, height=480):
    """A page in a frame of its own, as notebooks want it; it is all in there, so converted notebooks keep
    it.
    """
    return (
        f'<iframe srcdoc="{html.escape(text)}" style="width: 100%; height: {height}px; border: 0" '
        'sandbox="allow-scripts" loading="lazy"></iframe>'
    )
