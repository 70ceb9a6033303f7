"""Rotations that move, as commanded ones do: angular velocities and accelerations against differences of scipy's rotations."""

import numpy as np
import pytest
from numpy.testing import assert_allclose
from scipy.spatial.transform import Rotation
from test_kernels_algebra import tuples

from mbdfmi.kernels.math import algebra as al
from mbdfmi.kernels.motion import rotations

RNG = np.random.default_rng(5)
H = 4e-3

# |phi|: on both sides of where series take over, and far from it
SIZES = [0.0, 1e-6, 0.02, 0.0999, 0.1001, 0.5, 1.7, 3.0]


def by_differences(turn):
    """(A, w, w') at t = 0 of a rotation over time, in inertial axes: logarithms of small turns, differences of order 6."""
    here = turn(0.0)
    steps = [[(turn(sign * k * H) * here.inv()).as_rotvec() for sign in (1, -1)] for k in (1, 2, 3)]
    odd = [a - b for a, b in steps]
    even = [a + b for a, b in steps]
    w = (45 * odd[0] - 9 * odd[1] + odd[2]) / (60 * H)

    # of a vector theta(t) that begins at 0, w' = theta'' there
    alpha = (270 * even[0] - 27 * even[1] + 2 * even[2]) / (180 * H * H)
    return here, w, alpha


def assert_turns(found, turn):
    E, w, alpha = found
    A, w_found, alpha_found = by_differences(turn)
    assert_allclose(np.linalg.norm(E), 1.0, atol=1e-14)
    assert_allclose(Rotation.from_quat(E).as_matrix(), A.as_matrix(), rtol=0, atol=1e-14)
    assert_allclose(w, w_found, rtol=0, atol=1e-10)
    assert_allclose(alpha, alpha_found, rtol=0, atol=1e-8)


@pytest.mark.parametrize("size", SIZES)
def test_a_rotation_vector_that_moves(size):
    for phi, rate, second in RNG.normal(size=(4, 3, 3)):
        phi *= size / np.linalg.norm(phi)
        found = rotations.rotation_of_vector(tuples(phi), tuples(rate), tuples(second))
        assert_turns(found, lambda t: Rotation.from_rotvec(phi + rate * t + second * t * t / 2))


@pytest.mark.parametrize("size", SIZES)
def test_the_rate_of_a_rotation_vector(size):
    """The inverse of the above."""
    for phi, rate in RNG.normal(size=(4, 2, 3)):
        phi *= size / np.linalg.norm(phi)
        w = rotations.rotation_of_vector(tuples(phi), tuples(rate), al.ZERO3)[1]
        assert_allclose(rotations.rate_of_rotation(tuples(phi), w), rate, rtol=0, atol=1e-13)


def test_series_meet_the_closed_forms():
    """A vector just below and just above where one takes over from the other, that spins as it likes."""
    rate, second = map(tuples, RNG.normal(size=(2, 3)))
    phi = np.array([0.6, 0.0, 0.8])
    below, above = (
        rotations.rotation_of_vector(tuples(s * phi), rate, second) for s in (0.1 - 1e-13, 0.1 + 1e-13)
    )

    for a, b in zip(below, above):
        assert_allclose(a, b, rtol=0, atol=1e-11)


@pytest.mark.parametrize("turns", [0, 1, 2])
def test_yaw_pitch_and_roll_that_move(turns):
    angles, rates, seconds = RNG.normal(size=(3, 3))
    angles[turns] += 2 * np.pi

    def turn(t):
        return Rotation.from_euler("ZYX", angles + rates * t + seconds * t * t / 2)

    assert_turns(rotations.rotation_of_zyx(tuples(angles), tuples(rates), tuples(seconds)), turn)


@pytest.mark.parametrize("length", [0.4, 1.0, 3.0])
def test_euler_parameters_of_any_length_that_move(length):
    """Their length turns nothing, nor does that it changes."""
    E, rate, second = RNG.normal(size=(3, 4))
    E *= length / np.linalg.norm(E)

    def turn(t):
        return Rotation.from_quat(E + rate * t * length + second * t * t * length / 2)

    found = rotations.rotation_of_E(tuples(E), tuples(length * rate), tuples(length * second))
    A, w, alpha = by_differences(turn)
    assert_allclose(Rotation.from_quat(found[0]).as_matrix(), A.as_matrix(), rtol=0, atol=1e-14)
    assert_allclose(found[1], w, rtol=0, atol=1e-7)
    assert_allclose(found[2], alpha, rtol=0, atol=1e-5)


def test_rotation_vectors_equal_scipy():
    for E in RNG.normal(size=(8, 4)):
        E /= np.linalg.norm(E)
        assert_allclose(
            rotations.rotation_vector(tuples(E)), Rotation.from_quat(E).as_rotvec(), rtol=0, atol=1e-14
        )

    assert rotations.rotation_vector((0.0, 0.0, 0.0, 1.0)) == (0.0, 0.0, 0.0)
    assert_allclose(rotations.rotation_vector((1e-9, 0.0, -2e-9, 1.0)), (2e-9, 0, -4e-9), rtol=1e-12)
