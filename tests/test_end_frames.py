"""End frames whose motion relative to a body is prescribed: massless bodies on driven joints."""

import numpy as np
import pytest

from mbdfmi import Scene
from mbdfmi.run.instance import SimulationError

FREQUENCY = 1.5  # Hz
AMPLITUDE = 0.02  # m


def scene(formulation, frame_mass=0.0, **driver):
    """A pendulum (point mass on a rod of 1 m) whose pivot shakes vertically, as an end frame of the ground."""
    return Scene(
        name="shaken pendulum",
        gravity=[0, 0, -9.81],
        solver={"integrator": "rk853", "tolerance": 1e-11, "formulation": formulation},
        body={
            "pivot": {"mass": frame_mass, "output": ["position"]},
            "bob": {"mass": 2.0, "com": [0, 0, -1], "inertia": [0, 0, 0]},
        },
        joint={
            "shaker": {"prismatic": {"axis": "z"}, "between": ["ground", "pivot"], **driver},
            "hinge": {
                "revolute": {"axis": "y"},
                "between": ["pivot", "bob"],
                "start": {"angle_deg": 30},
                "output": ["angle", "speed", "acceleration"],
            },
        },
    )


@pytest.mark.parametrize("formulation", ["recursive", "embedding"])
def test_a_pendulum_on_a_shaken_end_frame(formulation):
    harmonic = {"amplitude": AMPLITUDE, "frequency": FREQUENCY}
    driver = {"driver": {"harmonic": harmonic}, "output": ["effort"]}
    results = scene(formulation, **driver).simulate(2.0, 0.05)
    w = 2 * np.pi * FREQUENCY
    angle, speed = results["hinge.angle"], results["hinge.speed"]
    lift = -AMPLITUDE * w**2 * np.sin(w * results["time"])

    # phi'' = -(g + z'') sin phi; the drive bears weight and inertia along z
    assert results["pivot.position[3]"] == pytest.approx(AMPLITUDE * np.sin(w * results["time"]), abs=1e-13)
    expected = -(9.81 + lift) * np.sin(angle)
    assert results["hinge.acceleration"] == pytest.approx(expected, abs=1e-9)
    rise = np.sin(angle) * results["hinge.acceleration"] + np.cos(angle) * speed**2
    assert results["shaker.effort"] == pytest.approx(2.0 * (9.81 + lift + rise), abs=1e-7)


def test_a_frame_that_nothing_moves_is_named():
    free = Scene(
        name="loose frame",
        body={"frame": {"mass": 0.0}},
        joint={"slide": {"prismatic": {}, "between": ["ground", "frame"]}},
    )

    with pytest.raises(SimulationError, match="inertia about the joint of frame"):
        free.simulate(1.0)
