"""Vectors, symmetric matrices, Euler parameters, swing and twist: against numpy, scipy and differences.

Rounding is the only error, so tolerances are some 1e-15 times the size of the numbers, unless said otherwise.
"""

import numpy as np
import pytest
from numpy.testing import assert_allclose
from scenes import random_orientation, rotation
from scipy.linalg import expm
from scipy.spatial.transform import Rotation

from mbdfmi.kernels.forces import six_by_six
from mbdfmi.kernels.math import algebra as al

RNG = np.random.default_rng(1)
ORIENTATIONS = [random_orientation(RNG) for _ in range(40)]


def tuples(array):
    """A numpy array as the kernels' tuples."""
    return tuple(map(tuples, array)) if np.ndim(array) > 1 else tuple(map(float, array))


def sym(S):
    """The 6-tuple (xx, yy, zz, xy, xz, yz) of a symmetric matrix."""
    return tuples(S[[0, 1, 2, 0, 0, 1], [0, 1, 2, 1, 2, 2]])


def full(S):
    """The symmetric matrix of a 6-tuple."""
    return np.array([[S[0], S[3], S[4]], [S[3], S[1], S[5]], [S[4], S[5], S[2]]])


def B_matrix(E):
    """B of docs/theory.md 2.1."""
    E1, E2, E3, E4 = E
    return np.array([[E4, -E3, E2, -E1], [E3, E4, -E1, -E2], [-E2, E1, E4, -E3]])


def C_matrix(E):
    """C of docs/theory.md 2.1."""
    E1, E2, E3, E4 = E
    return np.array([[E4, E3, -E2, -E1], [-E3, E4, E1, -E2], [E2, -E1, E4, -E3]])


def close(actual, desired, atol=1e-14):
    assert_allclose(np.array(actual), desired, rtol=0, atol=atol)


# vectors and matrices


def test_products_equal_numpy():
    a, b = RNG.normal(size=(2, 3))
    A, B = RNG.normal(size=(2, 3, 3))
    ta, tb, tA, tB = map(tuples, (a, b, A, B))
    close(al.cross(ta, tb), np.cross(a, b))
    close(al.axpy(2.0, ta, tb), 2 * a + b)
    close(al.norm(ta), np.linalg.norm(a))
    close(al.mat_vec(tA, tb), A @ b)
    close(al.matT_vec(tA, tb), A.T @ b)
    close(al.mat_mat(tA, tB), A @ B)
    close(al.outer(ta, tb), np.outer(a, b))
    close(al.skew(ta), np.cross(a, np.eye(3)).T)
    close(al.skew(ta) @ b, np.cross(a, b))


def test_symmetric_matrices_equal_numpy():
    L, A = RNG.normal(size=(2, 3, 3))
    S = L @ L.T
    a, b = RNG.normal(size=(2, 3))
    close(full(al.sym_rotate(tuples(A), sym(S))), A @ S @ A.T, 1e-13)
    close(full(al.sym_outer(2.0, tuples(a))), 2 * np.outer(a, a))
    close(full(al.sym_of_mat(tuples(A))), (A + A.T) / 2)
    close(al.mat_of_sym(sym(S)), S)
    close(al.sym_vec(sym(S), tuples(b)), S @ b)

    # inertia of a point mass: -m c~ c~
    close(
        full(al.sym_point(3.0, tuples(a))), -3 * np.array(al.skew(tuples(a))) @ np.array(al.skew(tuples(a)))
    )


def test_symmetric_factor_solves():
    for _ in range(20):
        L = RNG.normal(size=(3, 3))
        S = L @ L.T
        b = RNG.normal(size=3)
        F = al.sym_factor(sym(S))
        x = np.array(al.sym_solve(F, tuples(b)))

        # the residual is small whatever the condition of S; pivots of LDL^T multiply to the determinant
        close(S @ x, b, 1e-14 * np.linalg.norm(S) * max(1, np.linalg.norm(x)))
        assert F[0] * F[1] * F[2] == pytest.approx(np.linalg.det(S), rel=1e-10)
        assert al.sym_is_positive(F)


def test_symmetric_factor_tells_indefinite_and_nan():
    assert not al.sym_is_positive(al.sym_factor((1.0, 1.0, 1.0, 2.0, 0.0, 0.0)))
    assert not al.sym_is_positive(al.sym_factor((1.0, 1.0, -1.0, 0.0, 0.0, 0.0)))
    assert not al.sym_is_positive(al.sym_factor((1.0, np.nan, 1.0, 0.0, 0.0, 0.0)))


# Euler parameters


@pytest.mark.parametrize("E", ORIENTATIONS[:10])
def test_identities_of_the_theory_text(E):
    B, C = B_matrix(E), C_matrix(E)
    A = np.array(al.E_matrix(tuples(E)))
    w = RNG.normal(size=3)
    close(B @ B.T, np.eye(3))
    close(C @ C.T, np.eye(3))
    close(B @ C.T, A)

    # E' = 1/2 B^T w = 1/2 C^T w_p, w = 2 B E', and no change of length
    rate = np.array(al.E_rate(tuples(E), tuples(A.T @ w)))
    close(rate, B.T @ w / 2)
    close(2 * B @ rate, w)
    close(rate @ E, 0.0)

    # A' = 2 B C'^T = w~ A
    close(2 * B @ C_matrix(rate).T, np.array(al.skew(tuples(w))) @ A)

    # body axes: w_p = A^T w = 2 C E'
    close(2 * C @ rate, A.T @ w)


@pytest.mark.parametrize("E", ORIENTATIONS)
def test_rotations_equal_scipy(E):
    F = random_orientation(RNG)
    close(al.E_matrix(tuples(E)), rotation(E).as_matrix())
    close(al.E_matrix(tuples(3 * E)), rotation(E).as_matrix())
    product = al.E_product(tuples(E), tuples(F))
    close(al.E_matrix(product), (rotation(E) * rotation(F)).as_matrix())
    close(al.E_matrix(al.E_conjugate(tuples(E))), rotation(E).as_matrix().T)


def near_edges():
    """Rotations in all branches of Shepperd's method and where they meet: by 0, pi and about all axes."""
    axes = [*np.eye(3), *-np.eye(3), *RNG.normal(size=(6, 3)), [1, 1, 0], [1, 0, 1], [0, 1, 1], [1, 1, 1]]
    angles = [0.0, 1e-9, 1e-4, 1.0, 2 * np.pi / 3, np.pi / 2, np.pi - 1e-7, np.pi, np.pi + 1e-7, 4.0]

    for axis in axes:
        for angle in angles:
            n = np.array(axis) / np.linalg.norm(axis)
            yield np.append(n * np.sin(angle / 2), np.cos(angle / 2))


def test_euler_parameters_of_a_matrix():
    branches = set()

    for E in [*near_edges(), *ORIENTATIONS]:
        found = np.array(al.matrix_E(tuples(rotation(E).as_matrix())))
        sign = np.sign(found @ E)
        close(sign * found, E, 4e-16 * 4)
        close(np.linalg.norm(found), 1.0, 4e-16)
        branches.add(np.argmax(np.abs(E)))

    assert branches == {0, 1, 2, 3}


@pytest.mark.parametrize("pitch", [-1.5707, -1.0, 0.0, 0.3, 1.5707])
def test_zyx_round_trip(pitch):
    for yaw, roll in RNG.uniform(-np.pi, np.pi, (20, 2)):
        A = Rotation.from_euler("ZYX", [yaw, pitch, roll]).as_matrix()

        # an angle of order 1e-16 is resolved to 1e-16 / cos(pitch)
        close(al.matrix_zyx(tuples(A)), [yaw, pitch, roll], 1e-15 / np.cos(pitch) + 1e-15)


@pytest.mark.parametrize("sign", [1, -1])
@pytest.mark.parametrize("off", [0.0, 1e-13, 1e-9])
def test_zyx_in_gimbal_lock_still_gives_the_orientation(sign, off):
    for yaw, roll in RNG.uniform(-np.pi, np.pi, (20, 2)):
        A = Rotation.from_euler("ZYX", [yaw, sign * (np.pi / 2 - off), roll]).as_matrix()
        angles = np.array(al.matrix_zyx(tuples(A)))
        assert np.all(np.isfinite(angles))
        assert angles[1] == pytest.approx(sign * (np.pi / 2 - off), abs=1e-12)

        # each angle alone is lost in rounding, what they say together is not
        close(Rotation.from_euler("ZYX", angles).as_matrix(), A, 1e-12)


# swing and twist


def swing_twist_matrix(r):
    """exp((rx, ry, 0)~) Rz(rz)."""
    return (Rotation.from_rotvec([r[0], r[1], 0]) * Rotation.from_rotvec([0, 0, r[2]])).as_matrix()


def swings():
    """Swings from none to nearly half a turn, twists likewise."""
    for angle in (0.0, 1e-12, 1e-7, 0.9e-3, 1.1e-3, 0.1, 1.0, 2.5, np.pi - 1e-2, np.pi - 1e-4):
        for twist in (0.0, 1e-9, -0.7, 2.0, np.pi - 1e-6):
            heading = RNG.uniform(0, 2 * np.pi)
            yield np.array([angle * np.cos(heading), angle * np.sin(heading), twist])


def test_swing_twist_round_trip():
    for r in swings():
        found, _ = six_by_six.swing_twist(tuples(swing_twist_matrix(r)))

        # near a swing by pi the twist is the angle of a vector of length cos(swing / 2)
        margin = np.cos(np.hypot(r[0], r[1]) / 2)
        close(found, r, 4e-15 / margin)


def test_swing_twist_rates():
    """G maps rates of (rx, ry, rz) to the angular velocity: against differences of order 6 of the rotation."""
    h = 1e-2

    for r in swings():
        A = swing_twist_matrix(r)
        _, columns = six_by_six.swing_twist(tuples(A))

        for k, e in enumerate(np.eye(3)):
            turns = [
                (Rotation.from_matrix(swing_twist_matrix(r + j * h * e) @ A.T)).as_rotvec()
                for j in range(-3, 4)
            ]
            rate = sum(c * (turns[3 + j] - turns[3 - j]) for j, c in ((1, 45), (2, -9), (3, 1))) / (60 * h)

            # h^6 and 1e-16 / h; where the swing itself is lost in rounding, so is its direction
            close(columns[k], rate, 2e-12 / np.cos(np.hypot(r[0], r[1]) / 2))


def test_swing_is_exp_of_its_rotation_vector():
    """The convention itself, by a route without rotation classes."""
    r = np.array([0.4, -0.9, 1.3])
    W = expm(np.array([[0, 0, r[1]], [0, 0, -r[0]], [-r[1], r[0], 0]]))
    c, s = np.cos(r[2]), np.sin(r[2])
    close(six_by_six.swing_twist(tuples(W @ [[c, -s, 0], [s, c, 0], [0, 0, 1]]))[0], r)


def test_swing_by_pi_stays_finite():
    found, _ = six_by_six.swing_twist(tuples(Rotation.from_rotvec([np.pi, 0, 0]).as_matrix()))
    assert np.hypot(found[0], found[1]) == pytest.approx(np.pi)
    assert np.all(np.isfinite(found))


def test_moment_does_the_work_of_swing_and_twist():
    """G^T moment = Q, so that moment . w = Q . (rx', ry', rz')."""
    for r in swings():
        _, columns = six_by_six.swing_twist(tuples(swing_twist_matrix(r)))
        Q = RNG.normal(size=3)
        moment = np.array(six_by_six.moment_of_swing_twist(columns, tuples(Q)))
        close(np.array(columns) @ moment, Q, 1e-14 * max(1, np.linalg.norm(moment)))
