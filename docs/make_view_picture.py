#!/usr/bin/env python3
"""Draws docs/view.png, the page of a run with much of what it can show: `python docs/make_view_picture.py` (extra browser, a chromium)."""

import tempfile
from pathlib import Path

from playwright.sync_api import sync_playwright

import mbdfmi
from mbdfmi.view.browser import ARGUMENTS, find

HERE = Path(__file__).parent
SCENE = HERE.parent / "models" / "floating_wind_turbine" / "turbine_at_sea.toml"
SHOWN = ("joint axes", "arrows: reaction force")


def draw():
    """The turbine at sea after 40 s of 60."""
    scene = mbdfmi.load(SCENE)
    scene.view.paths = ["hub"]
    scene.view.plots = ["platform.position", "platform.zyx", "line_1.tension"]

    with tempfile.TemporaryDirectory() as folder, sync_playwright() as p:
        path = Path(folder) / "run.html"
        scene.simulate(60.0, 0.25).view(path)
        browser = p.chromium.launch(executable_path=str(find()), args=ARGUMENTS)
        page = browser.new_page(viewport={"width": 1280, "height": 700})
        page.goto(f"{path.as_uri()}#t=40")
        page.wait_for_selector('#mbdfmi[data-state="ready"]', timeout=60_000)
        page.evaluate("mbdfmi.pause(); mbdfmi.seek(40)")
        page.click("summary:has-text('show')")

        for what in SHOWN:
            page.check(f"text={what}")

        page.evaluate("mbdfmi.draw()")
        page.wait_for_timeout(1000)
        page.screenshot(path=str(HERE / "view.png"))
        browser.close()


if __name__ == "__main__":
    draw()
