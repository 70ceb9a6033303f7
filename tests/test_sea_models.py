"""The models that float beside the turbine: where they rest, and how they move about that."""

from pathlib import Path

import numpy as np
import pytest

import mbdfmi

MODELS = Path(__file__).parents[1] / "models"


def test_the_buoy_moves_as_the_published_one():
    """Periods of OC3-Hywind (Jonkman, NREL/TP-500-47535; OC3 final report, NREL/TP-5000-48191): surge and sway about 125 s, heave
    31 s, roll and pitch 30 s, yaw 8.2 s, here of a rigid turbine without added mass of potential flow: within 5 %."""
    modes = mbdfmi.load(MODELS / "moored_buoy.toml").linearise(at="equilibrium").modes()
    periods = sorted(1 / f for f in modes.frequencies if f > 0)
    np.testing.assert_allclose(periods, [8.2, 30, 30, 31, 125, 125], rtol=0.05)


@pytest.mark.parametrize("name", ["ship_crane", "offshore_crane"])
def test_cranes_float_level(name):
    """Their ballast is such that they do, to 0.02 degrees; and on the water line that their coefficients are about, to 2 cm."""
    rest = mbdfmi.load(MODELS / name / f"{name}.toml").equilibrium()
    assert rest.stable
    E = [rest.coordinates[f"float.euler_parameters[{k}]"] for k in (1, 2, 3)]
    assert 2 * np.linalg.norm(E) < np.radians(0.02)
    assert abs(rest.coordinates["float.position[3]"]) < 0.02
