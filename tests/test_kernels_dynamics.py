"""Kinematics, RNEA, CRBA, ABA and the forces on random trees: independent routes agree.

Tolerances are relative to what the numbers are made of. Roundings of 1e-16 grow with the condition of the mass matrix,
which trees of 30 bodies can raise to 1e7 and more.
"""

import numpy as np
import pytest
from hypothesis import given
from numpy.testing import assert_allclose
from referee.independent import System
from scenes import (
    body_motion,
    energies,
    evaluate,
    examples,
    inputs_of,
    inverse_dynamics,
    mass_matrix,
    momenta,
    random_instance,
    random_scene,
    trees,
    velocities,
)

from mbdfmi.scene import fmi_name


def second_route(scene, inputs):
    """(motions at the start, what is told there) by the independent route."""
    system = System(scene.model_dump(exclude_unset=True))
    motions = system.start_motions()
    return motions, system.evaluate(0.0, motions, inputs)


def assert_close(actual, desired, relative, *others):
    """Equal to within `relative` of the largest number around."""
    size = max(np.max(np.abs(x), initial=1.0) for x in (actual, desired, *others))
    assert_allclose(actual, desired, rtol=0, atol=relative * size)


@examples
@given(trees())
def test_kinematics_equals_absolute_coordinates(case):
    scene = case.scene()
    instance = random_instance(scene)
    motion = body_motion(instance)
    expected = System(scene.model_dump(exclude_unset=True)).start_motions()

    for name in scene.body:
        r, A, w, v_com = motion[name]
        R, B, V, W = expected[name]
        arm = B @ scene.body[name].mass_properties()[1]
        assert_close(r, R, 1e-13)
        assert_close(A, B, 1e-13)
        assert_close(w, W, 1e-13)
        assert_close(v_com, V + np.cross(W, arm), 1e-13)


@examples
@given(trees(symmetric=False))
def test_aba_equals_absolute_coordinates(case):
    """Every force element, input and joint kind, against Newton-Euler with constraints and multipliers."""
    scene = case.scene()
    instance = random_instance(scene)
    evaluate(instance)
    motion = body_motion(instance, accelerated=True)
    motions, told = second_route(scene, inputs_of(instance))
    expected = {}

    for name, body in scene.body.items():
        _, A, _, w = motions[name]
        arm = A @ body.mass_properties()[1]
        alpha, a = (told[f"{fmi_name(name)}.{key}"] for key in ("alpha", "acceleration"))
        expected[name] = alpha, a + np.cross(alpha, arm) + np.cross(w, np.cross(w, arm))

    largest = max(np.abs(pair).max() for pair in expected.values())

    for name in scene.body:
        for found, reference in zip(motion[name][4:], expected[name]):
            assert_close(found, reference, 1e-10, largest)


@examples
@given(trees())
def test_rnea_inverts_aba(case):
    instance = random_instance(case.scene())
    evaluate(instance)
    m, d = instance.m, instance.d
    accelerations_ = d.x_rate[m.n_q :].copy()
    tau = d.tau.copy()

    # the terms that cancel in tau
    sizes = np.abs(mass_matrix(instance)) @ np.abs(accelerations_)
    assert_close(inverse_dynamics(instance, accelerations_), tau, 2e-14, sizes)


@examples
@given(trees())
def test_crba_equals_rnea_columns(case):
    instance = random_instance(case.scene())
    M = mass_matrix(instance)
    n = len(M)
    bias = inverse_dynamics(instance, np.zeros(n))

    for k, unit in enumerate(np.eye(n)):
        assert_close(inverse_dynamics(instance, unit) - bias, M[:, k], 1e-13, bias, M)


@examples
@given(trees())
def test_crba_is_positive_definite_and_gives_aba(case):
    instance = random_instance(case.scene())
    rates = evaluate(instance)[instance.m.n_q :]
    tau = instance.d.tau.copy()
    M = mass_matrix(instance)
    bias = inverse_dynamics(instance, np.zeros(len(M)))

    # an exact copy above and below the diagonal, which Cholesky then takes
    assert np.array_equal(M, M.T)
    L = np.linalg.cholesky(M)
    condition = np.linalg.cond(M) if len(M) else 1.0
    expected = np.linalg.solve(L.T, np.linalg.solve(L, tau - bias))
    assert_close(rates, expected, 2e-15 * max(condition, 100.0))


@examples
@given(trees())
def test_kinetic_energy_is_that_of_the_mass_matrix(case):
    instance = random_instance(case.scene())
    M = mass_matrix(instance)
    v = velocities(instance)
    kinetic = energies(instance)[0]
    assert kinetic == pytest.approx(0.5 * v @ M @ v, rel=1e-12)


@examples
@given(trees())
def test_energy_changes_by_the_power_of_inputs_and_dampers(case):
    """dE/dt along x' equals the power that the second route finds; nothing else makes or takes energy."""
    scene = case.scene()
    instance = random_instance(scene)
    x = instance.d.x.copy()
    rate = evaluate(instance)
    _, told = second_route(scene, inputs_of(instance))
    power = told["input_power"] - told["dissipated_power"]

    # differences of order 6 along the motion; the step keeps x within 1e-2 of where it is
    h = 1e-2 / max(1.0, np.abs(rate).max(initial=0.0))
    change = size = 0.0

    for j, weight in ((1, 45), (2, -9), (3, 1)):
        for sign in (1, -1):
            instance.d.x[:] = x + sign * j * h * rate
            kinetic, potential = energies(instance)
            change += sign * weight * (kinetic + potential) / (60 * h)
            size = max(size, kinetic, abs(potential))

    # truncation h^6 and the rounding of E / h
    assert change == pytest.approx(power, rel=1e-8, abs=1e-8 * size + 1e-14 * size / h)


@examples
@given(trees(floating=True, gravity=False, added_mass=False))
def test_forces_inside_a_free_system_change_no_momentum(case):
    """Rates of linear and angular momentum at an instant, from the bodies' accelerations."""
    scene = case.scene()
    instance = random_instance(scene)
    evaluate(instance)
    linear, angular, sizes = np.zeros(3), np.zeros(3), []

    for name, (r, A, w, _, alpha, a) in body_motion(instance, accelerated=True).items():
        mass, com, inertia = scene.body[name].mass_properties()
        J = A @ inertia @ A.T
        terms = np.cross(r + A @ com, mass * a), J @ alpha, np.cross(w, J @ w)
        linear += mass * a
        angular += sum(terms)
        sizes += [mass * a, *terms]

    assert_close(linear, np.zeros(3), 1e-10, *sizes)
    assert_close(angular, np.zeros(3), 1e-10, *sizes)


@pytest.mark.parametrize("seed", range(8))
def test_free_systems_keep_their_momenta(seed):
    """Weightless, on free joints, with inner springs, dampers and driven joints: over a second of motion."""
    scene = random_scene(seed, 1 + 2 * seed, floating=True, gravity=False, added_mass=False, linear=False)
    instance = random_instance(scene, seed)
    before = momenta(instance)

    for _ in range(10):
        instance.step(0.1)

    # the integrator's tolerance of 1e-8 for each coordinate and step
    for found, expected in zip(momenta(instance), before):
        assert_close(found, expected, 1e-6)
