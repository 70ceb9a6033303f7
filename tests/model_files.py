"""The scenes of models/ that tests go through: all but the parts of coupled systems, which have tests of their own."""

from pathlib import Path

MODELS = Path(__file__).parents[1] / "models"

SCENES = sorted(path for path in MODELS.rglob("*.toml") if path.parent.name != "coupled")
