"""Directional derivatives of an FMU: against closed forms and other differences, and good for what they are wanted for."""

from ctypes import c_double, c_size_t

import fmu_host3
import numpy as np
import pytest
from fmu_host import ERROR, OK, Instance, Library
from scipy.linalg import solve_continuous_are
from test_model_exchange import SCENES, Solver

from mbdfmi import Scene
from mbdfmi.compiler.model import compile_scene
from mbdfmi.export import export_fmu
from mbdfmi.scene import read_scene

M, m, L, G = 2.0, 0.5, 0.8, 9.81  # kg, kg, m, m/s2: cart, bob, massless rod


def library_of(scene, folder, fmi=2):
    model = compile_scene(scene)
    kind = fmu_host3.Library if fmi == 3 else Library
    return model, kind(export_fmu(model, folder / f"{fmi}.fmu", fmi=fmi), folder / str(fmi))


@pytest.fixture(scope="module")
def cart(tmp_path_factory):
    """A cart on a rail with a bob above it on a rod."""
    scene = Scene(
        name="cart_pole",
        gravity=[0, 0, -G],
        body={
            "cart": {"mass": M, "inertia": [1, 1, 1]},
            "bob": {"mass": m, "com": [0, 0, L], "inertia": [0, 0, 0]},
        },
        joint={
            "rail": {
                "prismatic": {"axis": "x"},
                "between": ["ground", "cart"],
                "input": "force",
                "output": ["acceleration"],
            },
            "hinge": {
                "revolute": {"axis": "y"},
                "between": ["cart", "bob"],
                "output": ["angle", "acceleration"],
            },
        },
    )
    return library_of(scene, tmp_path_factory.mktemp("cart"))[1]


STATES = ["rail.state_position", "hinge.state_angle", "rail.state_velocity", "hinge.state_omega"]
RATES = [f"der({name})" for name in STATES]


def columns(fmu, unknowns, knowns):
    found = [fmu.along(unknowns, [known], [1.0]) for known in knowns]
    assert all(status == OK for status, _ in found), fmu.log
    return np.array([column for _, column in found]).T


def test_against_the_closed_form(cart):
    """A and B of a cart with a pole, upright; inverted pendulum of any textbook."""
    solver = Solver(cart)
    A = columns(solver.fmu, RATES, STATES)
    B = columns(solver.fmu, RATES, ["rail.force"])
    expected = np.zeros((4, 4))
    expected[0, 2] = expected[1, 3] = 1
    expected[2, 1] = -m * G / M
    expected[3, 1] = (M + m) * G / (M * L)
    np.testing.assert_allclose(A, expected, rtol=1e-10, atol=1e-10)
    np.testing.assert_allclose(B[:, 0], [0, 0, 1 / M, -1 / (M * L)], rtol=1e-10, atol=1e-10)

    # along several at once, and by a parameter
    seed = [0.3, -0.2, 0.1, 0.7]
    np.testing.assert_allclose(solver.fmu.along(RATES, STATES, seed)[1], A @ seed, rtol=1e-10, atol=1e-10)
    assert solver.fmu.set({"rail.force": 1.0}) == OK
    by_mass = columns(solver.fmu, RATES, ["cart.mass"])[:, 0]
    np.testing.assert_allclose(by_mass, [0, 0, -1 / M**2, 1 / (M**2 * L)], rtol=1e-9, atol=1e-10)
    solver.fmu.free()


def test_in_co_simulation(cart):
    """Of outputs by inputs, in the middle of a run that goes on to the same bits."""
    fmu, plain = Instance(cart).start(), Instance(cart).start()
    for i in range(20):
        assert fmu.set({"rail.force": 1.0}) == plain.set({"rail.force": 1.0}) == OK
        assert fmu.step(i * 0.01, 0.01) == plain.step(i * 0.01, 0.01) == OK
        (slope,) = columns(fmu, ["rail.acceleration"], ["rail.force"])[0]
        angle = fmu.value("hinge.angle")
        assert slope == pytest.approx(1 / (M + m * np.sin(angle) ** 2), rel=1e-9)
        assert fmu.outputs() == plain.outputs()
        assert fmu.serialise(fmu.save()) == plain.serialise(plain.save())

    assert fmu.along(["rail.acceleration"], ["hinge.state_angle"], [1.0])[0] == ERROR
    assert "no state of model exchange" in fmu.message
    assert fmu.along(["rail.force"], ["rail.force"], [1.0])[0] == ERROR
    assert "is no output and no rate" in fmu.message
    assert fmu.along(["rail.acceleration"], ["rail.force"], [float("nan")])[0] == ERROR
    assert fmu.along(["rail.acceleration"], ["rail.force"], [0.0]) == (OK, [0.0])
    fmu.free(), plain.free()


def test_a_cart_pole_is_balanced_by_its_own_derivatives(cart):
    """Linear-quadratic feedback from A and B of the FMU alone; the cart starts with its pole 20 degrees off."""
    model = Solver(cart)
    A, B = columns(model.fmu, RATES, STATES), columns(model.fmu, RATES, ["rail.force"])
    weight = 0.1
    K = B.T @ solve_continuous_are(A, B, np.diag([1.0, 10, 1, 1]), [[weight]]) / weight
    model.fmu.free()

    fmu = Instance(cart)
    assert fmu.set({"hinge.angle_start": np.radians(20)}) == OK
    fmu.start()
    for i in range(1000):
        x = np.array(fmu.get(*STATES)[1])
        assert fmu.set({"rail.force": float(-(K @ x)[0])}) == fmu.step(i * 0.01, 0.01) == OK

    np.testing.assert_allclose(fmu.get(*STATES)[1], 0, atol=1e-3)
    fmu.free()


@pytest.mark.parametrize("name", ["bricard", "floating_wind_turbine", "spinning_top", "three_link_arm"])
def test_against_other_differences(name, tmp_path):
    """Of all rates by all states, along the constraints and off them, against central differences of another step."""
    scene = read_scene(next(path for path in SCENES if path.stem == name))
    solver = Solver(library_of(scene, tmp_path)[1])
    unknowns = [u.variable for u in solver.fmu.library.description.derivatives]
    x, names = solver.x, [v.derivative.name for v in unknowns]
    J = columns(solver.fmu, [v.name for v in unknowns], names)
    nominal = np.array([float(v.derivative.nominal) for v in unknowns])

    for k, size in enumerate(np.maximum(nominal, np.abs(x))):

        def difference(h, k=k):
            high, low = x.copy(), x.copy()
            high[k] += h
            low[k] -= h
            return (solver.rates(0.0, high) - solver.rates(0.0, low)) / (2 * h)

        h = 2e-4 * size
        other = (4 * difference(h) - difference(2 * h)) / 3
        scale = np.abs(J).max() + 1
        np.testing.assert_allclose(J[:, k], other, rtol=1e-6, atol=1e-8 * scale)

    solver.fmu.free()


def test_of_arrays_in_fmi_3(tmp_path):
    """The vector of forces on a body: three seeds, three accelerations."""
    body = {"b": {"mass": 4.0, "inertia": [1, 1, 1], "input": ["force"], "output": ["acceleration"]}}
    scene = Scene(name="free", body=body, joint={"j": {"free": {}, "between": ["ground", "b"]}})
    library = library_of(scene, tmp_path, 3)[1]
    fmu = fmu_host3.Instance(library).start()
    (force, one), (acceleration, _) = fmu._references(["b.force"]), fmu._references(["b.acceleration"])
    seed, result = (c_double * 3)(1.0, -2.0, 4.0), (c_double * 3)()
    given = acceleration, one, force, one, seed, c_size_t(3), result
    assert fmu.call("fmi3GetDirectionalDerivative", *given, c_size_t(3)) == OK
    np.testing.assert_allclose(list(result), [0.25, -0.5, 1.0], rtol=1e-11)
    assert fmu.call("fmi3GetDirectionalDerivative", *given, c_size_t(2)) == ERROR
    assert "2 places for 3 unknowns" in fmu.message
    fmu.free()
