"""What a report was measured on, and with which versions."""

import os
import platform
from datetime import UTC, datetime
from importlib.metadata import PackageNotFoundError, version
from pathlib import Path

from mbdfmi.native.sources import source_hash


def own_versions() -> dict[str, str]:
    """Of this package, and of what compiles and runs it."""
    found = {}

    for package in ("mbdfmi", "numba", "llvmlite", "numpy"):
        try:
            found[package] = version(package)
        except PackageNotFoundError:
            found[package] = "not installed"

    return found | {"python": platform.python_version(), "kernels": source_hash()}


def machine() -> dict[str, str]:
    """The processor, how many cores, the system and the date."""
    return {
        "processor": _processor(),
        "cores": f"{os.cpu_count()} cores",
        "system": platform.platform(),
        "date": datetime.now(UTC).isoformat(timespec="seconds"),
    }


def _processor():
    """The processor's name."""
    try:
        lines = Path("/proc/cpuinfo").read_text().splitlines()
        return next(line.split(": ")[1] for line in lines if line.startswith("model name"))
    except (OSError, StopIteration, IndexError):
        return platform.processor() or platform.machine()
