"""Directional derivatives of an FMU: against closed forms and other differences, and good for what they are wanted for."""

import time
from ctypes import c_double, c_size_t, c_uint

import fmu_host3
import numpy as np
import pytest
from fmu_host import ERROR, OK, Instance, Library
from numpy.polynomial import chebyshev
from scipy.linalg import expm, solve_continuous_are, solve_discrete_are
from test_model_exchange import SCENES, Solver

from mbdfmi import Scene
from mbdfmi.compiler.model import compile_scene
from mbdfmi.export import export_fmu
from mbdfmi.export.tape import NONE, tape
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
                "output": ["position", "acceleration"],
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


def test_a_cart_pole_is_balanced_by_what_it_shows(cart):
    """A controller designed from A, B, C, D of the FMU alone: states are estimated from three sensors, one of which (an
    accelerometer) feels the force at once. It balances the FMU itself, 15 degrees off at first, which it is not told.
    """
    shown, h = ["rail.position", "hinge.angle", "rail.acceleration"], 0.01
    model = Solver(cart)
    A, B = columns(model.fmu, RATES, STATES), columns(model.fmu, RATES, ["rail.force"])
    C, D = columns(model.fmu, shown, STATES), columns(model.fmu, shown, ["rail.force"])
    model.fmu.free()
    np.testing.assert_allclose(C, [[1, 0, 0, 0], [0, 1, 0, 0], [0, -m * G / M, 0, 0]], rtol=1e-10, atol=1e-10)
    np.testing.assert_allclose(D, [[0], [0], [1 / M]], rtol=1e-10, atol=1e-10)

    # from one communication point to the next, the force held
    both = expm(h * np.block([[A, B], [np.zeros((1, 5))]]))
    F, H = both[:4, :4], both[:4, 4:]
    P = solve_discrete_are(F, H, np.diag([1.0, 10, 1, 1]), [[0.1]])
    K = np.linalg.solve(0.1 + H.T @ P @ H, H.T @ P @ F)
    noise = np.diag([1e-6, 1e-6, 1e-2])
    S = solve_discrete_are(F.T, C.T, 1e-6 * np.eye(4), noise)
    gain = S @ C.T @ np.linalg.inv(C @ S @ C.T + noise)

    fmu, guess, force = Instance(cart), np.zeros(4), 0.0
    assert fmu.set({"hinge.angle_start": np.radians(15)}) == OK
    fmu.start()
    for i in range(1500):
        seen = np.array(fmu.get(*shown)[1])
        guess = guess + gain @ (seen - C @ guess - D[:, 0] * force)
        force = float(-(K @ guess)[0])
        assert fmu.set({"rail.force": force}) == fmu.step(i * h, h) == OK
        guess = F @ guess + H[:, 0] * force

    np.testing.assert_allclose(fmu.get(*STATES)[1], 0, atol=1e-3)
    np.testing.assert_allclose(guess, 0, atol=1e-3)
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
    np.testing.assert_allclose(list(result), [0.25, -0.5, 1.0], rtol=1e-15)
    assert fmu.call("fmi3GetDirectionalDerivative", *given, c_size_t(2)) == ERROR
    assert "2 places for 3 unknowns" in fmu.message
    assert fmu.call("fmi3GetAdjointDerivative", *given, c_size_t(2)) == ERROR
    assert "2 places for 3 knowns" in fmu.message
    status, back = fmu.derivatives("Adjoint", ["b.acceleration"], ["b.force"], list(seed), 3)
    assert status == OK
    np.testing.assert_allclose(back, [0.25, -0.5, 1.0], rtol=1e-15)
    fmu.free()


def hinges(n):
    """Bodies on hinges, each driven, that move; bent so that nothing is small."""
    body, joint = {}, {}
    for k in range(n):
        mark = {"end": {"position": [0.4, 0, 0]}}
        body[f"b{k}"] = {"mass": 1 + k, "com": [0.2, 0, 0.1], "inertia": [0.1, 0.2, 0.3], "marker": mark}
        joint[f"j{k}"] = {
            "revolute": {"axis": "xyz"[k % 3]},
            "between": [f"b{k - 1}.end" if k else "ground", f"b{k}"],
            "start": {"angle": 0.3 + 0.1 * k, "speed": 0.5 - 0.2 * k},
            "damper": 0.1,
            "input": "torque",
            "output": ["acceleration", "angle"],
        }
    return Scene(name="chain", gravity=[0, 0, -9.81], body=body, joint=joint)


@pytest.fixture(scope="module")
def chain(tmp_path_factory):
    """Eight of them, in FMI 2 and 3."""
    scene = hinges(8)
    folder = tmp_path_factory.mktemp("chain")
    return library_of(scene, folder)[1], library_of(scene, folder, 3)[1]


def knowns_of(description, exchanges=True):
    names = [v.name for v in description.modelVariables if v.causality == "input"]
    return (
        names
        + ["b3.mass", "j2.damper"]
        + [u.variable.derivative.name for u in description.derivatives] * exchanges
    )


def through_points(function, size):
    """The derivative at 0 of an analytic function, by the polynomial through its values at Chebyshev's points in +-size."""
    at = np.cos((np.arange(25) + 0.5) * np.pi / 25)
    values = np.array([function(size * place) for place in at])
    found = chebyshev.chebfit(at, values, len(at) - 1)
    return chebyshev.chebval(0.0, chebyshev.chebder(found)) / size


@pytest.mark.parametrize(
    "name", ["bricard", "four_bar", "satellite", "spinning_top", "three_link_arm", "bicycle"]
)
def test_exact(name, tmp_path):
    """Rates and outputs by states to 1e-10, against polynomials of degree 24."""
    scene = read_scene(next(path for path in SCENES if path.stem == name))
    model, library = library_of(scene, tmp_path)
    assert tape(model) is not NONE
    solver = Solver(library)
    x = solver.x + 1e-2 * np.random.default_rng(3).normal(size=solver.n)
    solver.go(0.0, x)
    solver.call("fmi2EnterEventMode")
    solver.update()  # onto the constraints
    x = solver.x
    unknowns = [u.variable for u in library.description.derivatives]
    names = [v.derivative.name for v in unknowns]
    wanted = [v.name for v in unknowns] + [v.name for v in model.of_causality("output")]

    def moved(k, h):
        y = x.copy()
        y[k] += h
        solver.go(0.0, y)
        return np.array(solver.fmu.get(*wanted)[1])

    J = columns(solver.fmu, wanted, names)
    nominal = np.array([float(v.derivative.nominal) for v in unknowns])
    size = np.maximum(nominal, np.abs(x))
    values = np.abs(moved(0, 0.0))
    largest = np.abs(J).max(1) + 1e-3 * np.abs(J).max()

    # Newton's method of the projection takes another iteration in the midst of some of these intervals, where it jumps by rounding
    for k in range(len(x)):
        error = []
        for part in (0.05, 0.02, 0.01, 0.005):
            h = part * size[k]
            other = through_points(lambda move, k=k: moved(k, move), h)
            error.append(np.max(np.abs(J[:, k] - other) / (largest + 1e-4 * values / h)))
        assert min(error) < 1e-10, (names[k], error)

    solver.fmu.free()


def test_exact_by_parameters(tmp_path):
    """What follows from parameters (inertias) inside, against polynomials through values that are set."""
    library = library_of(hinges(8), tmp_path)[1]
    fmu = Instance(library).start()
    wanted = [f"j{k}.acceleration" for k in range(8)]
    given = {"b3.mass": 4.0, "b3.com[1]": 0.2, "b3.inertia[2]": 0.2, "j2.damper": 0.1, "gravity[3]": -9.81}
    J = columns(fmu, wanted, list(given))

    for k, (name, value) in enumerate(given.items()):

        def moved(h, name=name, value=value):
            assert fmu.set({name: value + h}) == OK
            return np.array(fmu.get(*wanted)[1])

        other = through_points(moved, 0.2 * abs(value))
        moved(0.0)
        assert np.max(np.abs(J[:, k] - other)) < 1e-10 * np.abs(J[:, k]).max(), name

    fmu.free()


def test_a_tape_that_does_not_hold_is_not_used(tmp_path):
    """A product of inertia that was zero when the scene was traced is another structure: differences then, and true."""
    library = library_of(hinges(3), tmp_path)[1]
    fmu = Instance(library).start()
    wanted = [f"j{k}.acceleration" for k in range(3)]
    zero = "b1.com[2]"
    found = columns(fmu, wanted, [zero, "b1.com[1]"])

    def moved(h):
        assert fmu.set({zero: h}) == OK
        return np.array(fmu.get(*wanted)[1])

    np.testing.assert_allclose(found[:, 0], through_points(moved, 0.01), rtol=1e-7)
    assert fmu.set({zero: 0.03}) == OK
    again = columns(fmu, wanted, [zero, "b1.com[1]"])
    assert np.abs(again - found).max() > 1e-3
    np.testing.assert_allclose(again[:, 0], through_points(lambda h: moved(0.03 + h), 0.01), rtol=1e-8)
    fmu.free()


def test_adjoints_are_transposed(chain):
    """Co-simulation and model exchange, outputs and rates: s J e by the rows and by the columns."""
    rng = np.random.default_rng(0)
    for kind in ("CoSimulation", "ModelExchange"):
        fmu = fmu_host3.Instance(chain[1], kind=kind).start()
        knowns = knowns_of(chain[1].description, kind == "ModelExchange")
        rates = [u.variable.name for u in chain[1].description.derivatives]
        unknowns = chain[1].names("output") + rates
        seed, weight = rng.normal(size=len(knowns)), rng.normal(size=len(unknowns))
        status, down = fmu.derivatives("Directional", unknowns, knowns, list(seed), len(unknowns))
        assert status == OK
        status, up = fmu.derivatives("Adjoint", unknowns, knowns, list(weight), len(knowns))
        assert status == OK
        assert weight @ down == pytest.approx(seed @ up, rel=1e-10)

        # column by column it is the same Jacobian, to the bit
        each = [fmu.derivatives("Directional", unknowns, [name], [1.0], len(unknowns))[1] for name in knowns]
        np.testing.assert_allclose(weight @ np.transpose(each), up, rtol=1e-13, atol=1e-13)
        assert fmu.derivatives("Adjoint", unknowns, ["j1.angle"], list(weight), 1)[0] == ERROR
        fmu.free()


def test_what_was_found_is_kept_until_something_changes(chain):
    """None of it is stale, whatever was changed; and what is changed back gives the same bits."""
    solver = Solver(chain[0])
    fmu, x = solver.fmu, solver.x
    rates = [u.variable.name for u in chain[0].description.derivatives]

    def jacobian():
        return columns(fmu, rates, knowns_of(chain[0].description))

    found = jacobian()
    np.testing.assert_array_equal(jacobian(), found)
    solver.go(0.0, x + 0.1)
    assert np.abs(jacobian() - found).max() > 1e-3
    solver.go(0.0, x)
    np.testing.assert_array_equal(jacobian(), found)
    solver.call("fmi2EnterEventMode")
    assert fmu.set({"b3.mass": 40.0}) == OK
    assert np.abs(jacobian() - found).max() > 1e-3
    assert fmu.set({"b3.mass": 4.0}) == OK
    np.testing.assert_allclose(jacobian(), found, rtol=1e-12, atol=1e-12)
    fmu.free()


def test_a_kept_jacobian_costs_nothing(tmp_path):
    """All 64 columns of a chain of 32, one by one, again."""
    library = library_of(hinges(32), tmp_path)[1]
    solver = Solver(library)
    x, states = solver.x, [u.variable.derivative.name for u in library.description.derivatives]
    rates = [f"der({name})" for name in states]

    rows = (c_uint * len(rates))(*map(library.reference, rates))
    known = [(c_uint * 1)(library.reference(name)) for name in states]
    one, result = (c_double * 1)(1.0), (c_double * len(rates))()

    def timed():
        start = time.process_time()
        for key in known:
            given = rows, c_size_t(len(rates)), key, c_size_t(1), one, result
            assert solver.fmu.call("fmi2GetDirectionalDerivative", *given) == OK
        return time.process_time() - start

    first, again = [], []
    for k in range(4):
        solver.go(0.0, x + 1e-3 * k)
        first.append(timed())
        again.append(timed())

    assert min(again) < min(first) / 2  # what is left is Python
    solver.fmu.free()


def test_along_many_at_once(chain):
    """However often one asks: the same as the sum of the columns, first by evaluations along the seed, then from what is kept."""
    solver = Solver(chain[0])
    knowns, rates = (
        knowns_of(chain[0].description),
        [u.variable.name for u in chain[0].description.derivatives],
    )
    rng = np.random.default_rng(1)
    seeds = rng.normal(size=(3 * len(knowns), len(knowns)))
    found = [solver.fmu.along(rates, knowns, list(seed))[1] for seed in seeds]
    J = columns(solver.fmu, rates, knowns)
    np.testing.assert_allclose(found, seeds @ J.T, rtol=1e-9, atol=1e-9 * np.abs(J).max())
    solver.fmu.free()


def test_efforts_to_the_last_digits(tmp_path):
    """A newton on 1000 t that weigh 1e7 N: 1e-6 m/s2, which differences of a newton would know to three digits."""
    body = {
        "b": {
            "mass": 1e6,
            "com": [0, 0, 0],
            "inertia": [1e6] * 3,
            "input": ["force"],
            "output": ["acceleration"],
        }
    }
    scene = Scene(
        name="heavy", gravity=[0, 0, -9.81], body=body, joint={"j": {"free": {}, "between": ["ground", "b"]}}
    )
    fmu = Instance(library_of(scene, tmp_path)[1]).start()
    outputs = [f"b.acceleration[{k}]" for k in (1, 2, 3)]
    J = columns(fmu, outputs, [f"b.force[{k}]" for k in (1, 2, 3)])
    np.testing.assert_allclose(J, np.eye(3) / 1e6, rtol=1e-14, atol=1e-21)

    # a parameter that is zero, and one that is nothing but rounding beside its fellows
    assert fmu.set({"b.force[1]": 3e6}) == OK
    by_com = columns(fmu, ["b.acceleration[2]"], ["b.com[2]"])
    assert abs(by_com[0, 0]) < 1e-9
    fmu.free()


def test_parameters_at_the_end_of_their_range(tmp_path):
    """A mass of zero can only grow: derivatives by it are of that side."""
    scene = Scene(
        name="bare",
        body={"b": {"mass": 0.0, "inertia": [0, 0, 2.0], "com": [0.5, 0, 0]}},
        joint={
            "j": {
                "revolute": {"axis": "z"},
                "between": ["ground", "b"],
                "start": {"speed": 3.0},
                "input": "torque",
                "output": ["acceleration"],
            }
        },
    )
    fmu = Instance(library_of(scene, tmp_path)[1]).start()
    assert fmu.set({"j.torque": 8.0}) == OK  # 4 rad/s2
    assert fmu.along(["j.acceleration"], ["b.mass"], [1.0])[1] == pytest.approx([-8 * 0.25 / 4], rel=1e-9)
    assert fmu.along(["j.acceleration"], ["b.mass"], [-2.0])[1] == pytest.approx([2 * 8 * 0.25 / 4], rel=1e-9)
    fmu.free()


# derivatives of outputs by time


def test_output_derivatives_of_a_closed_form(tmp_path):
    """A slide on a spring, driven: position, speed and acceleration after some steps, both versions."""
    k, m, amplitude = 40.0, 1.6, 0.3
    scene = Scene(
        name="slide",
        body={"b": {"mass": m, "inertia": [1, 1, 1]}},
        joint={
            "j": {
                "prismatic": {"axis": "x"},
                "between": ["ground", "b"],
                "spring": {"stiffness": k},
                "start": {"position": amplitude},
                "output": ["position", "speed", "acceleration"],
                "input": "force",
            }
        },
        solver={"tolerance": 1e-13},
    )
    w = np.sqrt(k / m)
    names = ["j.position", "j.speed", "j.acceleration"]
    for fmi, host in ((2, Instance), (3, fmu_host3.Instance)):
        fmu = host(library_of(scene, tmp_path, fmi)[1]).start()
        for i in range(7):
            assert fmu.step(i * 0.1, 0.1) == OK

        x = amplitude * np.cos(w * 0.7 + np.arange(5) * np.pi / 2) * w ** np.arange(5)  # and its rates
        before = fmu.serialise(fmu.save())
        np.testing.assert_allclose(fmu.output_derivatives(names, 1)[1], x[1:4], rtol=1e-10)
        np.testing.assert_allclose(fmu.output_derivatives(names, 2)[1], x[2:5], rtol=1e-8)
        assert fmu.serialise(fmu.save()) == before
        for names_, order in ((["j.position"], 3), (["j.position"], 0), (["j.force"], 1)):
            assert fmu.output_derivatives(names_, order)[0] == ERROR

        if fmi == 2:
            # the force ahead belongs to it: m a' = -k v + F'
            assert fmu.set_derivatives("j.force", 1, 3.2) == OK
            assert fmu.output_derivatives(["j.acceleration"], 1)[1][0] == pytest.approx(x[3] + 2.0, rel=1e-9)
        fmu.free()


@pytest.mark.parametrize(
    "name", ["four_bar", "floating_wind_turbine", "satellite", "marble_run", "spinning_top"]
)
def test_output_derivatives_against_steps(name, tmp_path):
    """Differences of the outputs of tight steps before and after, loops and contacts inside."""
    scene = read_scene(next(path for path in SCENES if path.stem == name))
    model, library = library_of(scene, tmp_path)
    names = [v.name for v in model.of_causality("output")]
    fmu = Instance(library)
    tolerances = {f"solver.{n}": 1e-13 for n in ("tolerance", "absolute_tolerance")}
    assert fmu.set(tolerances if "solver.tolerance" in library.variables else {"solver.step": 1e-4}) == OK
    fmu.start()
    assert fmu.step(0.0, 0.3) == OK
    h = 1e-3 if name != "spinning_top" else 1e-4
    samples = [fmu.outputs()]
    first, second = (fmu.output_derivatives(names, order)[1] for order in (1, 2))
    for i in range(8):
        assert fmu.step(0.3 + i * h, h) == OK
        samples.append(fmu.outputs())

    # the polynomial through the samples ahead; what rounding of the samples makes of it, both ways
    powers = np.vander(np.arange(9.0), increasing=True)
    c = np.linalg.solve(powers, np.array(samples))
    scale = np.abs(samples).max(0) + 1

    for k, name in enumerate(names):
        if not name.startswith("constraint"):
            noise = 1e-14 * max(scale[k], 7e6 if "flight" in name else 0)  # m, from the middle of the earth
            assert first[k] == pytest.approx(c[1][k] / h, rel=1e-6, abs=10 * noise / h), name
            assert second[k] == pytest.approx(2 * c[2][k] / h**2, rel=1e-4, abs=100 * noise / h**2), name

    fmu.free()


def test_commanded_motions_have_no_output_derivatives(tmp_path):
    scene = Scene(
        name="led",
        body={"b": {"mass": 1, "inertia": [1, 1, 1]}},
        joint={
            "j": {
                "prismatic": {"axis": "x"},
                "between": ["ground", "b"],
                "driver": {"input": ["position"]},
                "output": ["position"],
            }
        },
    )
    library = library_of(scene, tmp_path)[1]
    assert library.description.coSimulation.maxOutputDerivativeOrder == 0
    fmu = Instance(library).start()
    assert fmu.output_derivatives(["j.position"], 1)[0] == ERROR and "maxOutputDerivativeOrder" in fmu.message
    fmu.free()
