"""A browser without a window, where there is one: pictures of pages."""

import os
import shutil
import subprocess
import sys
import tempfile
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

# s, that drawing a picture may take, and ms that a page has for it
PATIENCE = 60
DRAWING = 8000


def find() -> Path | None:
    """The program of a chromium or one of its kin: MBDFMI_BROWSER, or what is installed."""
    told = os.environ.get("MBDFMI_BROWSER")
    named = [told] if told else [*NAMES, *PLACES]
    return next((Path(path) for path in map(shutil.which, named) if path), None)


def shoot(browser: Path, page: str, at: float, width: int = 1280, height: int = 800) -> bytes:
    """A page at a time (s) as a PNG. Raises OSError where the browser does not manage."""
    with tempfile.TemporaryDirectory(prefix="mbdfmi-") as folder:
        file, picture = Path(folder) / "page.html", Path(folder) / "page.png"
        file.write_text(page, encoding="utf-8")
        command = [
            str(browser),
            "--headless=new",
            *ARGUMENTS,
            "--hide-scrollbars",
            "--disable-extensions",
            f"--user-data-dir={folder}/profile",
            f"--window-size={width},{height}",
            f"--virtual-time-budget={DRAWING}",
            f"--screenshot={picture}",
            f"{file.as_uri()}#picture&t={at!r}",
        ]

        try:
            subprocess.run(command, capture_output=True, timeout=PATIENCE, check=True)
            return picture.read_bytes()
        except subprocess.SubprocessError as error:
            raise OSError(f"{browser}: made no picture ({type(error).__name__})") from error
