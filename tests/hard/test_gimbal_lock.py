"""Gimbal lock: pitch passes 90 degrees, where yaw and roll cannot be told apart.

In Euler parameters nothing happens there: criterion the exact orientation, a constant angular velocity. In a
gimbal, three hinges on rings, the mass matrix loses rank there: as long as it misses the lock the body turns
as if free, for the rings have no mass; on the lock itself the run may stop, and then says of what.
"""

import numpy as np
import pytest
from hard import adaptive, drift, fixed, problem, run, solvers, start, try_run
from scipy.spatial.transform import Rotation

EACH = solvers(
    adaptive(1e-11, 1e-8),
    fixed("rk4", 1e-3, 1e-8),
    fixed("gauss", 2e-2, 1e-8),
    fixed("ros2", 1e-3, 1e-4),
)


def attitude_error(E, wanted):
    """Largest difference of Euler parameters (n, 4), whatever their sign."""
    return np.abs(E * np.sign(np.sum(E * wanted, axis=1))[:, None] - wanted).max()


@EACH
@pytest.mark.parametrize("kind", ["free", "spherical"])
def test_a_free_body_passes_the_lock(check, kind, solver, allowed):
    """The angles go out finite, and tell the orientation, in the lock too."""
    data = problem("gimbal_lock_pass")
    body = data["bodies"][0]
    begin = {"euler_parameters": np.roll(body["q0"], -1).tolist(), "omega": body["w0"]}
    scene = {
        "name": "lock",
        "gravity": [0, 0, 0],
        "body": {"body": {"mass": 1.0, "inertia": [1, 1, 1], "output": ["euler_parameters", "zyx"]}},
        "joint": {"joint": {kind: {}, "between": ["ground", "body"], "start": begin, "output": ["zyx"]}},
    }
    y = run(scene, data["t"], solver)
    wanted = np.column_stack([data["column"][q] for q in ("q1", "q2", "q3", "q0")])

    for name in ("body.zyx", "joint.zyx"):
        told = Rotation.from_euler("ZYX", y[name]).as_quat()
        assert attitude_error(told, y["body.euler_parameters"]) < 1e-7

    check(attitude_error(y["body.euler_parameters"], wanted), allowed)


@pytest.mark.parametrize("near", [0.0, 1e-16, 1e-12, 1e-9, 1e-8, 1e-7, 1e-4])
@pytest.mark.parametrize("sign", [-1, 1])
def test_angles_at_and_near_the_lock_tell_the_orientation(near, sign):
    """Where the sine of pitch rounds to 1, too."""
    rng = np.random.default_rng(4)

    for yaw, roll in rng.uniform(-3, 3, (20, 2)):
        angles = [yaw, sign * (np.pi / 2 - near), roll]
        E = Rotation.from_euler("ZYX", angles).as_quat()
        scene = {
            "name": "lock",
            "gravity": [0, 0, 0],
            "body": {"body": {"mass": 1.0, "inertia": [1, 1, 1], "output": ["zyx"]}},
            "joint": {
                "joint": {
                    "free": {},
                    "between": ["ground", "body"],
                    "start": {"euler_parameters": E.tolist()},
                }
            },
        }
        told = Rotation.from_euler("ZYX", start(scene).outputs()).as_quat()
        assert attitude_error(told[None], E[None]) < 3e-8


# in a gimbal

HINGES = {"yaw": "z", "pitch": "y", "roll": "x"}


def gimbal(omega, ring):
    """A ball in two rings on three hinges; at the start their axes are normal to each other."""
    rings = {"mass": ring, "inertia": [ring] * 3}
    names = ["ground", "outer", "inner", "ball"]
    joints = {
        hinge: {
            "revolute": {"axis": axis},
            "between": [names[k], names[k + 1]],
            "start": {"speed": omega["xyz".index(axis)]},
            "output": ["angle", "speed"],
        }
        for k, (hinge, axis) in enumerate(HINGES.items())
    }
    ball = {"mass": 1.0, "inertia": [1, 1, 1], "output": ["euler_parameters", "omega"]}
    return {
        "name": "gimbal",
        "gravity": [0, 0, 0],
        "body": {"outer": rings, "inner": rings, "ball": ball},
        "joint": joints,
        "output": ["kinetic_energy", "angular_momentum"],
    }


def free_attitude(omega, t):
    """Euler parameters (n, 4) of a constant angular velocity."""
    return Rotation.from_rotvec(np.outer(t, omega)).as_quat()


@solvers(
    adaptive(1e-10, 1e-6),
    fixed("rk4", 1e-4, 1e-5),
    fixed("gauss", 1e-3, 1e-5),
)
@pytest.mark.parametrize("miss", [0.3, 0.03])
def test_a_ball_in_massless_rings_turns_as_if_free(check, miss, solver, allowed):
    """It misses the lock by this angle, and there yaw and roll turn by half a turn, the faster the nearer."""
    omega = np.array([miss, 1.0, 0.0])
    t = np.linspace(0, 4, 41)
    y = run(gimbal(omega, 0.0), t, solver)
    assert np.abs(y["pitch.angle"]).max() > 1.5 - 2 * miss
    assert np.abs(y["yaw.speed"]).max() > 0.1
    check(attitude_error(y["ball.euler_parameters"], free_attitude(omega, t)), allowed)


@solvers(adaptive(1e-9, 1e-4))
@pytest.mark.parametrize("ring", [0.0, 1e-12, 1e-6])
@pytest.mark.parametrize("miss", [0.0, 1e-12, 1e-6, 1e-3])
def test_a_gimbal_that_all_but_locks_passes_or_stops(check, miss, ring, solver, allowed):
    """Rings with some inertia take energy of the ball's: what stays is all energy, and momentum about the yaw
    hinge.
    """
    omega = np.array([miss, 1.0, 0.0])
    t = np.linspace(0, 4, 17)
    found = try_run(gimbal(omega, ring), t, solver)

    if found.stop is not None:
        assert found.stop.time == pytest.approx(np.pi / 2, abs=0.01)
        assert "inertia" in str(found.stop) or "step became too small" in str(found.stop)

    if ring == 0.0:
        wrong = attitude_error(found["ball.euler_parameters"], free_attitude(omega, found.t))
        assert wrong < 1e-6 + 20 * miss

    momentum = np.abs(found["angular_momentum"][:, 2]).max()
    check(max(drift(found["kinetic_energy"]), momentum), allowed)
