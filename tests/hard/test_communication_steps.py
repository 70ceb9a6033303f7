"""Communication steps from 1e-9 s to 1e3 s, alike and mixed.

Criterion: the closed form of a pendulum at large angle (Jacobi's functions), known digits of a loop; and a
count of evaluations: a step far below the inner one costs one inner step, not a search for it.
"""

import numpy as np
import pytest
from hard import EXPLICIT, STIFF, adaptive, against, fixed, problem, run, scene_of, solvers, start
from scipy.special import ellipj, ellipk

AMPLITUDE = 2.5

# a bar of 1 m: w^2 = m g l / J
W = np.sqrt(1.5 * 9.81)
K = ellipk(np.sin(AMPLITUDE / 2) ** 2)


def pendulum():
    """A bar on a hinge, let go at AMPLITUDE."""
    bar = {"mass": 1.0, "com": [0, 0, -0.5], "inertia": [1 / 12, 1 / 12, 1e-3]}
    hinge = {"revolute": {"axis": "y"}, "between": ["ground", "bar"], "start": {"angle": AMPLITUDE}}
    hinge["output"] = ["angle", "speed"]
    return {"name": "pendulum", "gravity": [0, 0, -9.81], "body": {"bar": bar}, "joint": {"hinge": hinge}}


def motion(t):
    """Angle and speed (n, 2): sin(a / 2) = k sn(K + w t)."""
    k = np.sin(AMPLITUDE / 2)
    sn, cn, dn, _ = ellipj(K + W * np.asarray(t, float) % (4 * K), k**2)
    return np.column_stack([2 * np.arcsin(k * sn), 2 * W * k * cn])


def motion_error(instance):
    """Of angle and speed now, by the largest of each."""
    wrong = np.abs(instance.outputs() - motion([instance.time])[0])
    return (wrong / [AMPLITUDE, 2 * W * np.sin(AMPLITUDE / 2)]).max()


EACH = solvers(
    adaptive(1e-11, 1e-7),
    fixed("rk4", 1e-3, 1e-7),
    fixed("gauss", 1e-2, 1e-7),
    fixed("ros2", 1e-3, 1e-1),
)


@EACH
@pytest.mark.parametrize("H", [1e-3, 0.01, 0.37, 1.0, 20.0])
def test_even_steps_to_20_s(check, H, solver, allowed):
    instance = start(pendulum(), solver)

    for _ in range(round(20 / H)):
        instance.step(H)

    check(motion_error(instance), allowed)


@EACH
@pytest.mark.parametrize("H", [1e-9, 1e-7, 1e-5])
def test_steps_far_below_the_inner_one(check, H, solver, allowed):
    """20,000 of them, then on at large: each is one inner step, none is lost, and the inner step is found
    again.
    """
    n = 20_000
    instance = start(pendulum(), solver)

    for _ in range(200):
        instance.step(H)

    evaluations = instance.d.evaluations[0]

    for _ in range(n - 200):
        instance.step(H)

    # a radau step with its Jacobian by differences costs the most
    per_step = (instance.d.evaluations[0] - evaluations) / (n - 200)
    assert per_step <= (14 if "rk" in solver["integrator"] else 60)
    assert instance.d.rejected[0] < 20

    # rounding of each step is all that there is
    assert instance.time == pytest.approx(n * H, rel=1e-14)
    t = n * H
    speed = -(W**2) * np.sin(AMPLITUDE) * (t - W**2 * np.cos(AMPLITUDE) * t**3 / 6)

    if t < 0.01:
        assert instance.outputs()[1] == pytest.approx(
            speed, rel=1e-6 if solver["integrator"] == "ros2" else 1e-9
        )

    steps = instance.d.steps[0]
    instance.step(10 - instance.time)
    assert instance.d.steps[0] - steps < 40_000
    check(motion_error(instance), allowed)


@EACH
@pytest.mark.parametrize("seed", range(4))
def test_mixed_steps(check, seed, solver, allowed):
    """Evenly spread orders of magnitude from 1e-9 s to 10 s, to some 20 s."""
    rng = np.random.default_rng(seed)
    instance = start(pendulum(), solver)

    while instance.time < 20:
        instance.step(10 ** rng.uniform(-9, 1))

    check(motion_error(instance), allowed)


@solvers(adaptive(1e-12, 1e-6, EXPLICIT), adaptive(1e-12, 1e-3, STIFF), fixed("gauss", 5e-3, 1e-3))
def test_a_step_of_1000_s(check, solver, allowed):
    """380 swings in one step, and after it one of 1e-9 s."""
    instance = start(pendulum(), solver)
    instance.step(1000.0)
    instance.step(1e-9)
    assert instance.time == 1000.0 + 1e-9
    check(motion_error(instance), allowed)


@solvers(adaptive(1e-9, 1e-6))
def test_large_after_small_costs_no_million(check, solver, allowed):
    """A step of 1e-9 s must not leave its size to the next, of 10 s."""
    one = start(pendulum(), solver)
    one.step(20.0)
    mixed = start(pendulum(), solver)

    for _ in range(10):
        mixed.step(1e-9)
        mixed.step(2.0 - 1e-9)

    assert mixed.d.evaluations[0] < 1.5 * one.d.evaluations[0] + 2000
    assert motion_error(one) < allowed
    check(motion_error(mixed), allowed)


@solvers(
    adaptive(1e-10, 1e-6),
    fixed("rk4", 1e-3, 1e-6),
    fixed("ros2", 1e-3, 1e-2),
)
@pytest.mark.parametrize("H", [1e-7, 1e-5])
def test_a_loop_in_steps_far_below_the_inner_one(check, H, solver, allowed):
    """Projected onto its constraints 5,000 times within next to no motion; then known digits."""
    data = problem("A02_n_four_bar_N1")

    for body in data["bodies"]:
        body["inertia"] = [J or 1e-3 for J in body["inertia"][:3]]

    scene = scene_of(data, output=["constraint_gap"])
    scene["body"]["V0"]["marker"]["tip"] = {"position": [0, 0.5, 0], "output": ["position"]}
    times = np.concatenate([np.arange(5000) * H, data["t"][(data["t"] > 0) & (data["t"] <= 3)]])
    y = run(scene, times, solver)
    assert y["constraint_gap"].max() < 1e-12
    last = y["V0.tip.position"][5000:, :2]
    wanted = np.column_stack([data["column"]["B0_x"], data["column"]["B0_y"]])[1 : 1 + len(last)]
    check(against(last, wanted), allowed)
