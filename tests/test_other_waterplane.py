"""Long waves lift a body by rho g times its waterplane, and so does what carries it: told where they differ."""

import re
from pathlib import Path

import numpy as np
import pytest
from test_hydrodynamics import RHO, G, afloat, database  # noqa: F401

import mbdfmi
from mbdfmi import Scene
from mbdfmi.compiler.model import compile_scene
from mbdfmi.hydro.consistency import long_waves_lift
from mbdfmi.hydro.reading import read_coefficients

MODELS = Path(__file__).parents[1] / "models"
HULLS = {
    "floating_wind_turbine/barge.1": (9.80665, 40.0 * 40.0),
    "offshore_crane/barge.1": (9.81, 110.0 * 45.0),
}


@pytest.mark.parametrize("file", HULLS)
def test_the_longest_waves_lift_by_the_area_at_the_water_plane(file):
    """Of capytaine's boxes, from frequencies that begin at 0.05 and 0.2 rad/s: 0.3 %."""
    gravity, area = HULLS[file]
    data = read_coefficients(MODELS / file, 1025.0, gravity, 1.0).checked()[0]
    lift, doubt = long_waves_lift(data)
    assert abs(lift / (1025.0 * gravity * area) - 1) < 3e-3
    assert doubt < 0.03 * lift


def told(scene):
    return [text for text in compile_scene(scene).notices if "the area at the water plane" in text]


def test_a_box_of_another_area_is_told(database):  # noqa: F811
    """The file's body has rho g 400 m2: a box of 20 x 20 m goes with it, upright or not, one of 20 x 24 m does not."""
    for breadth, zyx, apart in (
        (20.0, [0, 0, 0], 0),
        (20.0, [30, 0, 0], 0),
        (24.0, [0, 0, 0], 16.7),
        (10.0, [0, 0, 0], 100.0),
    ):
        data = afloat(database, {"zyx_deg": zyx}, outputs=[], radiation=False).model_dump(exclude_unset=True)
        data["force"]["hold"] = {"hydrostatics": {"box": {"size": [20.0, breadth, 10.0]}}, "on": "hull"}
        found = told(Scene.model_validate(data))
        assert len(found) == (apart > 0)
        if apart:
            # a parabola leaves 2.4 % of this file's loads, whose first frequency is 0.04 rad/s
            off = float(re.search(r"water plane, and (\S+) % apart", found[0]).group(1))
            assert abs(off - apart) < 0.026 * (100 + apart) and "and hold by" in found[0]


def test_a_matrix_of_another_stiffness_is_told(database):  # noqa: F811
    for share, count in ((1.0, 0), (1.3, 1)):
        stiffness = np.diag([2e5, 2e5, share * RHO * G * 400, 3e8, 3e8, 1e8])
        data = afloat(database, outputs=[], radiation=False).model_dump(exclude_unset=True)
        data["force"]["hold"]["linear"]["stiffness"] = stiffness.tolist()
        assert len(told(Scene.model_validate(data))) == count


@pytest.mark.parametrize(
    "name", ["floating_wind_turbine/turbine_at_sea", "offshore_crane/offshore_crane", "ship_crane/ship_crane"]
)
def test_scenes_of_models_are_of_one_hull(name):
    assert not told(mbdfmi.load(MODELS / f"{name}.toml"))
