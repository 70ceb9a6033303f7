"""Inputs that jump at communication points, also in the middle of the step that an integrator would like to
take.

Criterion: exact solutions piece by piece: parabolas of a free rotor, arcs of an oscillator in the phase
plane, and with derivatives of the inputs polynomials of the fourth degree.
"""

import numpy as np
import pytest
from hard import adaptive, fixed, solvers, start
from numpy.polynomial import Polynomial

W = 3.0


def rotor(**joint):
    """2 kg m2 on a hinge that a torque drives."""
    hinge = {"revolute": {}, "between": ["ground", "rotor"], "input": "torque", "output": ["angle", "speed"]}
    return {
        "name": "rotor",
        "gravity": [0, 0, 0],
        "body": {"rotor": {"mass": 1.0, "inertia": [1, 1, 2]}},
        "joint": {"hinge": hinge | joint},
    }


def oscillator(damper=0.0):
    """x'' + 2 D x' + W^2 x = u / 2."""
    return rotor(spring={"stiffness": 2 * W**2}, damper=4 * damper)


def steps_through(instance, pieces):
    """Outputs after pieces (H s, u, u', u'')."""
    rows = []

    for H, *u in pieces:
        instance.u[:] = [*u, *[0.0] * (6 - len(u))]
        instance.step(H)
        rows.append(instance.outputs().copy())

    return np.array(rows)


def rotor_motion(pieces):
    """Exactly: angle and speed after each piece."""
    angle, speed, rows = 0.0, 0.0, []

    for H, u, *more in pieces:
        first, second = [*more, 0.0, 0.0][:2]
        acceleration = Polynomial([u, first, second / 2]) / 2
        angle += speed * H + acceleration.integ(2)(H)
        speed += acceleration.integ(1)(H)
        rows.append([angle, speed])

    return np.array(rows)


def oscillator_motion(pieces, damper=0.0):
    """Exactly: about the polynomial that follows the force, a free motion, damped or not."""
    x, v, rows = 0.0, 0.0, []
    w = np.sqrt(W**2 - damper**2)

    for H, u, *more in pieces:
        first, second = [*more, 0.0, 0.0][:2]
        a, b, c = u / 2, first / 2, second / 4

        # p = p0 + p1 t + p2 t^2 with p'' + 2 D p' + W^2 p = a + b t + c t^2
        p2 = c / W**2
        p1 = (b - 4 * damper * p2) / W**2
        p0 = (a - 2 * damper * p1 - 2 * p2) / W**2
        y, z = x - p0, v - p1
        k = (z + damper * y) / w
        fade, cos, sin = np.exp(-damper * H), np.cos(w * H), np.sin(w * H)
        x = fade * (y * cos + k * sin) + p0 + p1 * H + p2 * H**2
        v = fade * (z * cos - (damper * k + w * y) * sin) + p1 + 2 * p2 * H
        rows.append([x, v])

    return np.array(rows)


def square_wave(H, n, height=1.0):
    """n pieces of H that change sign each time."""
    return [(H, height if k % 2 == 0 else -height) for k in range(n)]


def random_pieces(seed, n, smallest=1e-3, derivatives=False):
    """Pieces of 1 ms to 1 s, forces of 1e-3 to 1e3, and derivatives."""
    rng = np.random.default_rng(seed)
    pieces = []

    for _ in range(n):
        H = smallest ** rng.random()
        u = rng.choice([-1, 1]) * 10 ** rng.uniform(-3, 3)
        more = rng.normal(size=2) * [abs(u) / H, abs(u) / H**2] if derivatives else []
        pieces.append((H, u, *more))

    return pieces


# a rotor: exact but for rounding with every integrator of order 2 and more

ROTOR = solvers(
    adaptive(1e-8, 1e-10),
    fixed("rk4", 0.07, 1e-10),
    fixed("gauss", 0.07, 1e-10),
    fixed("ros2", 0.07, 1e-10),
)


@ROTOR
@pytest.mark.parametrize("H", [1e-3, 0.01, 0.1, 0.3, 1.0, 10.0])
def test_square_wave_on_a_rotor(check, H, solver, allowed):
    pieces = square_wave(H, 200)
    instance = start(rotor(), solver)
    found, wanted = steps_through(instance, pieces), rotor_motion(pieces)
    assert instance.time == pytest.approx(200 * H, rel=1e-15)

    if "tolerance" in solver:
        assert instance.d.evaluations[0] < 200 * 120

    check(np.abs((found - wanted) / np.abs(wanted).max(axis=0)).max(), allowed)


@ROTOR
@pytest.mark.parametrize("seed", range(3))
def test_random_jumps_on_a_rotor(check, seed, solver, allowed):
    pieces = random_pieces(seed, 100)
    found, wanted = steps_through(start(rotor(), solver), pieces), rotor_motion(pieces)
    check(np.abs((found - wanted) / np.abs(wanted).max(axis=0)).max(), allowed)


@solvers(
    adaptive(1e-10, 1e-8),
    fixed("rk4", 0.07, 1e-8),
    fixed("gauss", 0.07, 1e-8),
)
@pytest.mark.parametrize("seed", range(3))
def test_random_jumps_with_derivatives_on_a_rotor(check, seed, solver, allowed):
    pieces = random_pieces(seed, 60, derivatives=True)
    found, wanted = steps_through(start(rotor(), solver), pieces), rotor_motion(pieces)
    check(np.abs((found - wanted) / np.abs(wanted).max(axis=0)).max(), allowed)


@ROTOR
def test_blows(check, solver, allowed):
    """Momenta of 1 N m s, ever shorter, in between nothing: 1e12 N m for 1e-12 s."""
    pieces = [piece for k in range(13) for piece in ((10.0**-k, 10.0**k), (0.1, 0.0))]
    found, wanted = steps_through(start(rotor(), solver), pieces), rotor_motion(pieces)
    check(np.abs((found - wanted) / wanted).max(), allowed)


# an oscillator

OSCILLATOR = solvers(
    adaptive(1e-10, 5e-7),
    fixed("rk4", 5e-3, 1e-6),
    fixed("gauss", 0.02, 1e-7),
    fixed("ros2", 2e-3, 1e-2),
)


@OSCILLATOR
@pytest.mark.parametrize("H", [1e-3, 0.013, 0.1, 1.0, 7.7])
@pytest.mark.parametrize("damper", [0.0, 0.4])
def test_square_wave_on_an_oscillator(check, damper, H, solver, allowed):
    """A step of the integrators at this tolerance is about 0.1 s: the jumps fall into it, or far apart."""
    n = min(2000, int(40 / H))
    pieces = square_wave(H, n)
    found = steps_through(start(oscillator(damper), solver), pieces)
    wanted = oscillator_motion(pieces, damper)
    check(np.abs((found - wanted) / np.abs(wanted).max(axis=0)).max(), allowed)


@OSCILLATOR
@pytest.mark.parametrize("derivatives", [False, True])
@pytest.mark.parametrize("seed", range(3))
def test_random_jumps_on_an_oscillator(check, seed, derivatives, solver, allowed):
    pieces = random_pieces(seed, 60, derivatives=derivatives)
    found = steps_through(start(oscillator(0.1), solver), pieces)
    wanted = oscillator_motion(pieces, 0.1)
    check(np.abs((found - wanted) / np.abs(wanted).max(axis=0)).max(), allowed)


@OSCILLATOR
def test_tiny_jumps(check, solver, allowed):
    """Of 1e-12 of the force."""
    pieces = [(0.05, 1.0 + 1e-12 * (-1) ** k) for k in range(400)]
    found = steps_through(start(oscillator(), solver), pieces)
    wanted = oscillator_motion(pieces)
    check(np.abs((found - wanted) / np.abs(wanted).max(axis=0)).max(), allowed)


@solvers(adaptive(1e-8, 0.0))
def test_jumps_cost_no_more_than_the_steps_they_cut(solver, allowed):
    """A jump of any size at each of 2000 communication points: one step between two is enough, or a few."""
    jumps = [(1e-3, 10.0 ** (k % 7) * (-1) ** k) for k in range(2000)]
    instance = start(oscillator(), solver)
    steps_through(instance, jumps)
    assert instance.d.steps[0] + instance.d.rejected[0] < 5 * 2000


@solvers(adaptive(1e-9, 1e-6))
def test_a_jump_after_a_long_rest(check, solver, allowed):
    """At rest the step has grown to 1000 s; the jump comes with the next communication step."""
    pieces = [(1.0, 0.0), (1000.0, 0.0), (1000.0, 0.0), (0.3, 5.0), (0.3, -5.0), (100.0, 0.0), (0.1, 1e6)]
    found = steps_through(start(oscillator(0.1), solver), pieces)
    wanted = oscillator_motion(pieces, 0.1)
    check(np.abs(found - wanted).max(axis=1)[:6].max() / 0.5, allowed)
    assert np.abs(found[6] / wanted[6] - 1).max() < allowed
