"""Rotations against scipy's, products of vectors against numpy's, to the bit: a model's bytes follow from them."""

import warnings

import numpy as np
import pytest
from scipy.spatial.transform import Rotation as Theirs

from mbdfmi.rotations import Rotation
from mbdfmi.vectors import cross

RNG = np.random.default_rng(5)
ANGLES = np.vstack(
    [RNG.uniform(-4, 4, (300, 3)), RNG.integers(-4, 5, (100, 3)) * np.pi / 2, 1e-4 * RNG.normal(size=(20, 3))]
)
EULER_PARAMETERS = np.vstack(
    [RNG.normal(size=(300, 4)), np.eye(4), -np.eye(4), RNG.integers(-1, 2, (50, 4)) + [0, 0, 0, 0.5]]
)


def test_rotation_vectors():
    for vector in [*ANGLES, np.zeros(3), np.array([0, 0, 3e-4])]:
        np.testing.assert_array_equal(
            Rotation.from_rotvec(vector).as_quat(), Theirs.from_rotvec(vector).as_quat()
        )


@pytest.mark.parametrize("axes", ["ZYX", "ZXZ"])
def test_angles(axes):
    np.testing.assert_array_equal(
        Rotation.from_euler(axes, ANGLES).as_quat(), Theirs.from_euler(axes, ANGLES).as_quat()
    )
    degrees = 40 * ANGLES[7]
    found = Rotation.from_euler(axes, degrees, degrees=True).as_quat()
    np.testing.assert_array_equal(found, Theirs.from_euler(axes, degrees, degrees=True).as_quat())


def test_euler_parameters_and_matrices():
    theirs = Theirs.from_quat(EULER_PARAMETERS)
    np.testing.assert_array_equal(Rotation.from_quat(EULER_PARAMETERS).as_quat(), theirs.as_quat())
    np.testing.assert_array_equal(Rotation.identity().as_matrix(), np.eye(3))

    for E in EULER_PARAMETERS:
        A = Theirs.from_quat(E).as_matrix()
        np.testing.assert_array_equal(Rotation.from_quat(E).as_matrix(), A)
        np.testing.assert_allclose(
            Rotation.from_quat(E).apply(E[:3]), Theirs.from_quat(E).apply(E[:3]), atol=1e-15
        )
        np.testing.assert_array_equal(Rotation.from_matrix(A).as_quat(), Theirs.from_matrix(A).as_quat())


def test_yaw_pitch_roll():
    with warnings.catch_warnings(action="ignore"):
        for E in [*EULER_PARAMETERS, *Rotation.from_euler("ZYX", ANGLES).as_quat()]:
            np.testing.assert_array_equal(Rotation.from_quat(E).as_zyx(), Theirs.from_quat(E).as_euler("ZYX"))


def test_a_cross_product_is_numpys():
    rng = np.random.default_rng(1)

    for k in range(300):
        a, b = rng.normal(size=3), np.eye(3)[k % 3] if k % 2 else rng.normal(size=3)
        assert cross(a, b).tobytes() == np.cross(a, b).tobytes()
        assert cross(b, a).tobytes() == np.cross(b, a).tobytes()
