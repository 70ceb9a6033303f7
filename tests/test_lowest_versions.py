"""The lowest versions that pyproject.toml names are enough."""

import os
import subprocess
from pathlib import Path

import pytest

ROOT = Path(__file__).parents[1]

TESTS = "scene told tables notices names structure torsion scene_messages"
"""Tests that use what the packages offer, on interpreted kernels."""


@pytest.mark.long
def test_the_lowest_versions_are_enough(tmp_path):
    uv = pytest.importorskip("uv", reason="it finds the lowest versions").find_uv_bin()

    def run(*command, **variables):
        environment = os.environ | {"MBDFMI_CACHE": str(tmp_path / "cache")} | variables
        done = subprocess.run(
            list(map(str, command)), cwd=ROOT, env=environment, capture_output=True, text=True
        )
        assert done.returncode == 0, done.stdout + done.stderr

    scripts = tmp_path / "venv" / ("Scripts" if os.name == "nt" else "bin")
    run(uv, "venv", "--python", "3.11", tmp_path / "venv")
    run(
        uv, "pip", "install", "--python", scripts / "python", "--resolution", "lowest-direct", "-e", ".[test]"
    )

    files = [f"tests/test_{name}.py" for name in TESTS.split()]
    run(scripts / "python", "-m", "pytest", "-q", "-x", "-n", "2", *files, MBDFMI_INTERPRETED="1")

    # numba and zig of that time compile the kernels: an installation to work on has no library with it
    run(scripts / "mbdfmi", "export", "models/four_bar.toml", "-o", tmp_path / "four_bar.fmu")
    run(scripts / "mbdfmi", "check", tmp_path / "four_bar.fmu")
