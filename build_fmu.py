#!/usr/bin/env python3
"""Build FMUs from scene files: `python build_fmu.py [SCENE ...] [-o DIR]`; without a scene, all of models/."""

import argparse
import sys
from pathlib import Path

MODELS = Path(__file__).parent / "models"


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

    scenes = options.scenes or sorted(map(str, MODELS.rglob("*.toml")))
    chosen = [f"--platform={name}" for name in options.platform or []]
    return cli.main(["export", *scenes, "-o", f"{options.output}/", *chosen])


if __name__ == "__main__":
    sys.exit(main())
