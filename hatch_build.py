"""Packed beside files: in a wheel every platform's library, in an editable install what makes it."""

import sys
import tomllib
from pathlib import Path

from hatchling.builders.hooks.plugin.interface import BuildHookInterface

ROOT = Path(__file__).parent


class CustomBuildHook(BuildHookInterface):
    """Called by hatchling before it packs a wheel."""

    def initialize(self, version, build_data):
        """Adds the libraries, or, where kernels may change, the packages that make them."""
        if version == "editable":
            project = tomllib.loads((ROOT / "pyproject.toml").read_text(encoding="utf-8"))["project"]
            build_data["dependencies"] += project["optional-dependencies"]["build"]
            return

        sys.path.insert(0, str(ROOT))
        from mbdfmi.export.link import library
        from mbdfmi.native.platforms import PLATFORMS

        for name in PLATFORMS:
            path = library(name, lambda text: self.app.display_info(text))
            build_data["force_include"][str(path)] = f"mbdfmi/native/libraries/{path.name}"
