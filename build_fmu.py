#!/usr/bin/env python3
"""Build FMUs from scene files: `python build_fmu.py [SCENE ...] [-o DIR]`; without a scene, all of models/, but for the parts of
coupled systems.
"""

import argparse
import sys
from pathlib import Path

MODELS = Path(__file__).parent / "models"


def scenes_of_models() -> list[Path]:
    """All scenes of models/; those of models/coupled stand beside systems that are no scenes."""
    return sorted(path for path in MODELS.rglob("*.toml") if path.parent.name != "coupled")


def main() -> int:
    """Export the scenes named on the command line; returns the exit status."""
    parser = argparse.ArgumentParser(description="Build FMUs from scene files.")
    parser.add_argument("scenes", nargs="*", metavar="SCENE", help="scene file (default: all of models/)")
    parser.add_argument(
        "-o", "--output", default="out", metavar="DIR", help="folder for the FMUs (default: out)"
    )
    parser.add_argument("--platform", action="append", metavar="NAME", help="as of `mbdfmi export`")
    options = parser.parse_args()

    try:
        from mbdfmi import cli
    except ImportError as error:
        print(f"{error}; install mbdfmi and what it needs first: python -m pip install -e .", file=sys.stderr)
        return 1

    scenes = options.scenes or list(map(str, scenes_of_models()))
    chosen = [f"--platform={name}" for name in options.platform or []]
    return cli.main(["export", *scenes, "-o", f"{options.output}/", *chosen])


if __name__ == "__main__":
    sys.exit(main())
