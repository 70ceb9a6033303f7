"""Draws the pictures of docs/sea.md by the commands that users have: the spectrum of a sea, moorings, response amplitude operators.

The decays and answers beside the reference are drawn by models/floating_wind_turbine/beside_reference.py.
"""

from pathlib import Path

from mbdfmi.cli import main

HERE = Path(__file__).parent
MODELS = HERE.parent / "models"
TURBINE = MODELS / "floating_wind_turbine" / "turbine_at_sea.toml"
SHIP = MODELS / "ship_crane" / "ship_crane.toml"
DRAWN = (
    ("sea", TURBINE, "sea_spectrum.png"),
    ("moorings", TURBINE, "moorings.png"),
    ("moorings", HERE / "line_of_sections.toml", "line_of_sections.png"),
    ("rao", SHIP, "rao.png"),
)


def draw():
    """All of them."""
    for command, scene, picture in DRAWN:
        main([command, str(scene), "--plot", str(HERE / picture)])


if __name__ == "__main__":
    draw()
