"""The sources of the kernels by their hash, and where is kept what was compiled of them."""

import hashlib
import os
from functools import cache
from pathlib import Path

OUTSIDE = ("steppers",)
"""Modules beside the kernels that these import: their numbers are frozen into the code as well."""


KERNELS = Path(__file__).parents[1] / "kernels"


@cache
def source_hash() -> str:
    """Hash (hex) of all sources of the kernels: names a set of compiled kernels."""
    digest = hashlib.sha256()
    folder = KERNELS
    outside = [folder.parent / f"{name}.py" for name in OUTSIDE]

    for path in [*sorted(folder.rglob("*.py")), *outside]:
        digest.update(path.relative_to(folder.parent).as_posix().encode() + b"\0" + path.read_bytes() + b"\0")

    return digest.hexdigest()[:20]


def cache_directory() -> Path:
    """Folder for what is compiled once and kept: $MBDFMI_CACHE, else `mbdfmi` in the user's cache."""
    if chosen := os.environ.get("MBDFMI_CACHE"):
        return Path(chosen)

    if os.name == "nt":
        base = os.environ.get("LOCALAPPDATA", Path.home() / "AppData/Local")
    else:
        base = os.environ.get("XDG_CACHE_HOME", Path.home() / ".cache")

    return Path(base) / "mbdfmi"
