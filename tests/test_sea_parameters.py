"""Height, period, direction and seed of the waves as parameters of a model: the seas of scenes that have these values."""

import numpy as np
import pytest
from scenes import assert_near
from test_hydrodynamics import database  # noqa: F401  (a fixture)

from mbdfmi import Scene
from mbdfmi.compiler.model import compile_scene
from mbdfmi.kernels.math import dice
from mbdfmi.run.instance import SimulationError
from mbdfmi.run.simulate import simulate


@pytest.mark.parametrize("seed", [0, 1, 2, 12345, 2**31, 2**32 - 1])
def test_phases_are_drawn_as_numpy_draws_them(seed):
    p = np.zeros(16)
    dice.begin(p, seed)
    found = [dice.draw(p) for _ in range(20)]
    np.testing.assert_array_equal(found, np.random.default_rng(seed).random(20))


def barge(file, waves):
    """A body in potential flow, and a member, in the waves."""
    return Scene.model_validate(
        {
            "name": "barge",
            "sea": {"depth": 40.0, "waves": waves, "output": ["elevation"]},
            "solver": {"tolerance": 1e-10},
            "body": {
                "hull": {
                    "mass": 4e7 / 9.81,
                    "inertia": [1e9, 1e9, 1e9],
                    "marker": {"keel": {"position": [5, 0, -8]}, "deck": {"position": [5, 0, 6]}},
                    "output": ["elevation"],
                }
            },
            "joint": {"held": {"fixed": {}, "between": ["ground", "hull"]}},
            "force": {
                "flow": {
                    "hydrodynamics": {"file": file},
                    "on": "hull",
                    "output": ["excitation_force", "excitation_moment"],
                },
                "pile": {
                    "member": {"diameter": 2.0, "added_mass": 1.0},
                    "between": ["hull.keel", "hull.deck"],
                    "output": ["force"],
                },
            },
        }
    )


DRAWN = {"jonswap": {"hs": 2.0, "tp": 8.0, "seed": 1, "components": 40}, "direction_deg": 0}
OTHER = {"jonswap": {"hs": 3.0, "tp": 10.0, "seed": 7, "components": 40}, "direction_deg": 30}
REGULAR = {"regular": {"height": 2.0, "period": 8.0}, "direction_deg": 0}
OTHER_REGULAR = {"regular": {"height": 1.0, "period": 9.0}, "direction_deg": -40}
NAMES = ("sea.elevation", "hull.elevation", "flow.excitation_force", "flow.excitation_moment", "pile.force")


@pytest.mark.parametrize(
    "waves, other, parameters",
    [
        (DRAWN, OTHER, {"sea.hs": 3.0, "sea.tp": 10.0, "sea.direction": np.radians(30), "sea.seed": 7}),
        (REGULAR, OTHER_REGULAR, {"sea.height": 1.0, "sea.period": 9.0, "sea.direction": np.radians(-40)}),
    ],
    ids=["drawn", "regular"],
)
def test_a_sea_of_other_values_is_that_of_their_scene(database, waves, other, parameters):  # noqa: F811
    """Elevation, loads of a large body and of a member, at all points."""
    ours = simulate(compile_scene(barge(database, waves)), 6.0, 0.37, parameters=parameters)
    theirs = simulate(compile_scene(barge(database, other)), 6.0, 0.37)
    unlike = simulate(compile_scene(barge(database, waves)), 6.0, 0.37)

    for name in NAMES:
        size = np.abs(theirs[name]).max()
        assert size > 0.0
        assert_near(ours[name], theirs[name], 1e-8 * size)
        assert np.abs(unlike[name] - theirs[name]).max() > 0.1 * size


@pytest.mark.parametrize(
    "parameters", [{"sea.hs": -1.0}, {"sea.tp": 0.0}, {"sea.seed": 1.5}, {"sea.seed": -3.0}]
)
def test_what_is_no_sea_is_refused(database, parameters):  # noqa: F811
    with pytest.raises(SimulationError, match=r"sea.hs, sea.height must not be negative"):
        simulate(compile_scene(barge(database, DRAWN)), 1.0, 0.1, parameters=parameters)
