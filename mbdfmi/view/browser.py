"""A browser without a window, where there is one: pictures of pages."""

import os
import shutil
import sys
from pathlib import Path

NAMES = (
    "chromium",
    "chromium-browser",
    "google-chrome",
    "google-chrome-stable",
    "chrome",
    "msedge",
    "microsoft-edge",
)
PLACES = (
    "/Applications/Google Chrome.app/Contents/MacOS/Google Chrome",
    "/Applications/Chromium.app/Contents/MacOS/Chromium",
    "/Applications/Microsoft Edge.app/Contents/MacOS/Microsoft Edge",
    r"C:\Program Files\Google\Chrome\Application\chrome.exe",
    r"C:\Program Files (x86)\Microsoft\Edge\Application\msedge.exe",
)

# drawn by the processor where there is no graphics card; root has no sandbox
ARGUMENTS = ["--use-angle=swiftshader", "--enable-unsafe-swiftshader", "--ignore-gpu-blocklist"]

if sys.platform == "linux" and os.geteuid() == 0:
    ARGUMENTS.append("--no-sandbox")


def find() -> Path | None:
    """The program of a chromium or one of its kin: MBDFMI_BROWSER, or what is installed."""
    told = os.environ.get("MBDFMI_BROWSER")
    named = [told] if told else [*NAMES, *PLACES]
    return next((Path(path) for path in map(shutil.which, named) if path), None)
