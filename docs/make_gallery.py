#!/usr/bin/env python3
"""Writes docs/gallery: a page and a picture of every scene in models/, `python docs/make_gallery.py [NAME ...]`."""

import sys
from pathlib import Path

import mbdfmi
from mbdfmi.view import drawing
from mbdfmi.view.picture import picture

FOLDER = Path(__file__).parent / "gallery"
MODELS = Path(__file__).parents[1] / "models"

# s, of each run, and when its picture is taken: what is not listed runs for 4 s and is shown at the start
RUNS = {
    "bicycle": (1.0, 0.5),
    "bricard": (6.0, 0.8),
    "cam_follower": (0.6, 0.1),
    "double_pendulum": (6.0, 1.2),
    "floating_crane": (660.0, 640.0),
    "floating_wind_turbine": (30.0, 1.0),
    "four_bar": (5.0, 0.4),
    "marble_run": (1.6, 0.5),
    "moored_buoy": (60.0, 45.0),
    "offshore_crane": (60.0, 25.0),
    "rolling_disk": (3.0, 0.8),
    "satellite": (30.0, 10.0),
    "rattleback": (6.0, 0.0),
    "ship_crane": (60.0, 51.0),
    "slider_crank": (0.8, 0.05),
    "spinning_top": (3.0, 0.25),
    "turbine_at_sea": (60.0, 20.0),
    "turning_track": (1.2, 0.3),
    "turntable": (1.2, 0.4),
}
WIDTH, HEIGHT = 480, 300


def scenes():
    """Name -> file of every scene of models/."""
    return {path.stem: path for path in sorted(MODELS.rglob("*.toml")) if path.parent.name != "coupled"}


def show(name, path):
    """Writes the page and the picture of a scene."""
    scene = mbdfmi.load(path)
    until, at = RUNS.get(name, (4.0, 0.0))
    results = scene.simulate(until, until / 240)
    results.view(FOLDER / f"{name}.html")
    row = int(abs(results["time"] - at).argmin())
    image = drawing.draw(picture(scene, results.states), row, WIDTH, HEIGHT)
    (FOLDER / f"{name}.png").write_bytes(drawing.png(image))


def index():
    """The text of docs/gallery/README.md."""
    rows = []

    for name, path in scenes().items():
        title = mbdfmi.load(path).title or name
        link = f"../../{path.relative_to(MODELS.parent).as_posix()}"
        rows.append(f"### {title}\n\n![{title}]({name}.png)\n\n[scene]({link}), [page]({name}.html)\n")

    head = (
        "<!-- made by docs/make_gallery.py -->\n# Gallery\n\n"
        "Every scene of [models/](../../models): the picture is that of the run, the page plays it (download it and open it in\n"
        "any browser; it needs no network). Yours: `mbdfmi simulate SCENE --until 10 --view run.html`.\n\n"
    )
    return head + "\n".join(rows)


if __name__ == "__main__":
    FOLDER.mkdir(exist_ok=True)

    for name, path in scenes().items():
        if name in sys.argv[1:] or len(sys.argv) == 1:
            show(name, path)
            print(FOLDER / f"{name}.html")

    (FOLDER / "README.md").write_text(index(), encoding="utf-8")
