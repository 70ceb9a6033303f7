"""Masters on systems with known solutions: orders of error, loops at the start, chosen steps, rollback, energy."""

import numpy as np
import pytest
from scipy.linalg import expm

import mbdfmi
from mbdfmi.cosim import CouplingError, System
from mbdfmi.cosim.march import March
from tests.coupled_blocks import Blocks, block


@pytest.fixture(scope="module")
def file(tmp_path_factory):
    """The FMU of a block."""
    return block().export(tmp_path_factory.mktemp("blocks") / "block.fmu")


def two(file):
    """Two blocks with a spring and a damper between them, of both signs."""
    numbers = np.array([1.0, 2.0]), np.array([10.0, 15.0]), np.array([0.5, 0.2]), np.array([0.1, -0.05])
    spring, damper = 8.0 * np.array([[-1.0, 1.0], [1.0, -1.0]]), np.array([[-0.4, 0.4], [0.4, -0.4]])
    return Blocks(file, *numbers, spring, damper, np.zeros((2, 2)), np.array([0.5, 0.0]))


@pytest.mark.parametrize(
    "options, order",
    [
        ({"method": "jacobi"}, 1),
        ({"method": "jacobi", "order": 1}, 2),
        ({"method": "jacobi", "order": 2}, 3),
        ({"method": "gauss-seidel"}, 1),
        ({"method": "gauss-seidel", "order": 1}, 2),
        ({"method": "gauss-seidel", "order": 2}, 3),
        ({"method": "iterate", "tolerance": 1e-10}, 2),
        ({"method": "iterate", "tolerance": 1e-10, "order": 2}, 3),
        ({"method": "newton", "tolerance": 1e-10}, 2),
        ({"method": "newton", "tolerance": 1e-10, "order": 2}, 3),
    ],
)
def test_order_of_error(file, options, order):
    blocks = two(file)
    steps = (0.04, 0.02, 0.01)
    errors = [blocks.error(blocks.system(**options).simulate(1.0, H)) for H in steps]
    found = np.log2(np.divide(errors[:-1], errors[1:]))
    assert found[-1] == pytest.approx(order, abs=0.25)


@pytest.mark.parametrize("seed", range(6))
def test_random_systems(file, seed):
    """Two to eight blocks, loops of their accelerations too: the start is exact, the error falls with the square of the step."""
    blocks = Blocks.random(file, seed, accelerations=True)
    errors = []

    for H in (0.02, 0.01):
        results = blocks.system(tolerance=1e-9).simulate(0.6, H)
        _, rows = blocks.matrix()
        start = rows @ np.concatenate([blocks.start, np.zeros(len(blocks.mass)), [1.0]])
        found = [results[f"{name}.rail.acceleration"][0] for name in blocks.names]
        np.testing.assert_allclose(found, start, rtol=1e-8, atol=1e-9)
        errors.append(blocks.error(results))

    assert errors[1] < 2e-4
    assert errors[0] / errors[1] == pytest.approx(4, rel=0.15)


@pytest.mark.parametrize("seed", range(10, 14))
@pytest.mark.parametrize("order", [0, 1, 2])
def test_random_systems_at_every_order(file, seed, order):
    """Two to eight blocks, all at once and one after another in turn, inputs continued by polynomials: the error falls as theory
    says.
    """
    blocks = Blocks.random(file, seed)
    options = {"method": ("jacobi", "gauss-seidel")[seed % 2], "order": order}
    errors = [blocks.error(blocks.system(**options).simulate(0.64, H)) for H in (0.01, 0.005)]
    assert errors[0] / errors[1] == pytest.approx(2 ** (order + 1), rel=0.2)


@pytest.fixture(scope="module")
def others(tmp_path_factory):
    """The same of FMI 3.0, which takes no polynomials: inputs are held at means."""
    return block().export(tmp_path_factory.mktemp("blocks3") / "block.fmu", fmi=3)


@pytest.mark.parametrize("fmi", [2, 3])
@pytest.mark.parametrize("order", [0, 1, 2])
@pytest.mark.parametrize("method", ["jacobi", "gauss-seidel", "auto"])
@pytest.mark.parametrize("seed", [10, 13])
def test_products_made_before_are_the_steps_themselves(file, others, fmi, order, method, seed, monkeypatch):
    """Steps of one length that products of matrices lead are those of the general way, to rounding; the last one is shorter."""
    blocks = Blocks.random(file if fmi == 2 else others, seed)
    options = {"method": method, "order": order} | ({"order": 0} if method == "auto" else {})
    runs = []

    for plainly in (True, False):
        if not plainly:
            monkeypatch.setattr(March, "_goes_plainly", False)
        runs.append(blocks.system(**options).simulate(0.2449, 0.005))

    one, other = runs
    assert len(one["time"]) == len(other["time"]) == 50

    for name in one:
        size = np.abs(other[name]).max()
        np.testing.assert_allclose(one[name], other[name], rtol=0, atol=1e-11 * max(size, 1.0), err_msg=name)

    # neither is told what the other is not
    assert one.notices == other.notices


def test_a_force_that_depends_on_its_own_acceleration(file):
    """F = 1e5 - 2 a with a = F/m, m = 1 kg: consistent is F = 1e5/3, though passes around the loop would grow."""
    system = System(
        fmu={"cart": {"file": file, "parameters": {"rail.position_start": 0.0}}},
        link=[
            {
                "source": "cart.rail.acceleration",
                "target": "cart.rail.force",
                "factor": -2.0,
                "offset": 1e5,
                "units": False,
            }
        ],
    )
    results = system.simulate(0.01, 0.001)
    assert results["cart.rail.acceleration"][0] == pytest.approx(1e5 / 3, rel=1e-9)
    assert "cart.rail.force -> cart.rail.acceleration -> cart.rail.force" in system.check()
    # 3 kg and the spring
    t = results["time"]
    A = np.array([[0, 1, 0], [-10 / 3, -0.5 / 3, 1e5 / 3], [0, 0, 0]])
    exact = [(expm(A * s) @ [0, 0, 1])[0] for s in t]
    np.testing.assert_allclose(results["cart.rail.position"], exact, rtol=1e-5, atol=1e-6)


def test_a_loop_without_a_solution_is_named(file):
    """F = 1 + m a has no solution."""
    system = System(
        fmu={"cart": {"file": file, "parameters": {"rail.position_start": 0.0}}},
        link=[
            {
                "source": "cart.rail.acceleration",
                "target": "cart.rail.force",
                "factor": 1.0,
                "offset": 1.0,
                "units": False,
            }
        ],
    )
    with pytest.raises(
        CouplingError, match="start is not consistent.*cart.rail.force -> cart.rail.acceleration"
    ):
        system.simulate(0.1, 0.01)


def test_chosen_steps_keep_the_error(file):
    blocks = two(file)
    errors, counts = [], []

    for error in (1e-2, 1e-3, 1e-4):
        results = blocks.system(error=error, order=2, tolerance=1e-7).simulate(2.0, 0.01)
        t = results["time"]
        A, _ = blocks.matrix()
        x = np.array([expm(A * s) @ [*blocks.start, 0, 0, 1] for s in t])
        found = np.column_stack([results[f"{name}.rail.position"] for name in blocks.names])
        errors.append(np.abs(found - x[:, :2]).max())
        counts.append(len(t))

    assert np.all(np.array(errors) < 0.5 * np.array([1e-2, 1e-3, 1e-4]))
    assert counts[0] < counts[1] < counts[2] < 500


def test_chosen_steps_of_masters_that_do_not_repeat(file):
    """They hold too, with more steps."""
    blocks = two(file)
    counts = []
    for options in ({"method": "jacobi"}, {"method": "gauss-seidel", "order": 1}, {}):
        results = blocks.system(error=3e-3, **options).simulate(1.0, 0.01)
        A, _ = blocks.matrix()
        x = np.array([expm(A * s) @ [*blocks.start, 0, 0, 1] for s in results["time"]])
        found = np.column_stack([results[f"{name}.rail.position"] for name in blocks.names])
        assert np.abs(found - x[:, :2]).max() < 3e-3
        counts.append(len(results["time"]))
    assert counts[0] > counts[1] > counts[2]


def motor(k=0.3, U=12.0, J=2e-4, R=1.0, L=1e-3):
    """A direct-current motor: its winding, charge as a position, and its rotor."""
    winding = mbdfmi.Scene(
        name="winding",
        gravity=[0, 0, 0],
        body={"charge": {"mass": L, "inertia": [1, 1, 1]}},
        joint={
            "circuit": {
                "prismatic": {"axis": "x"},
                "between": ["ground", "charge"],
                "damper": R,
                "input": "force",
                "output": ["speed"],
            }
        },
    )
    rotor = mbdfmi.Scene(
        name="rotor",
        gravity=[0, 0, 0],
        body={"rotor": {"mass": 1.0, "inertia": [J, J, J]}},
        joint={
            "shaft": {
                "revolute": {"axis": "x"},
                "between": ["ground", "rotor"],
                "input": "torque",
                "output": ["speed"],
            }
        },
    )
    back = {
        "source": "rotor.shaft.speed",
        "target": "winding.circuit.force",
        "factor": -k,
        "offset": U,
        "units": False,
    }
    on = {"source": "winding.circuit.speed", "target": "rotor.shaft.torque", "factor": k, "units": False}

    def run(H, names=("winding", "rotor"), told=None, **master):
        scenes = {"winding": {"scene": winding}, "rotor": {"scene": rotor}}
        fmus = {name: scenes[name] for name in names}
        results = System(fmu=fmus, link=[back, on], master=master).simulate(1.0, H)
        A = np.array([[-R / L, -k / L, U / L], [k / J, 0, 0], [0, 0, 0]])
        exact = np.array([(expm(A * t) @ [0, 0, 1])[1] for t in results["time"]])
        if told is not None:
            told += results.plan.reasons
        return np.abs(results["rotor.shaft.speed"] - exact).max(), sum(results.work.values())

    return run


def test_direct_current_motor():
    """At 10 ms, ten times the time constant of the winding, the interface Jacobian is better than Jacobi's method at 1 ms: its
    first step is done in parts, in which the current builds up.
    """
    run = motor()
    jacobi, steps = run(1e-3, method="jacobi")
    assert 11.5 < jacobi < 12.0 and steps == 2000
    newton, steps = run(1e-2, method="newton")
    assert newton < 4.1 < jacobi and steps <= 300
    assert 10 < run(1e-2, method="newton", start_in_parts=False)[0] < 11
    assert run(1e-3)[0] < 0.7
    assert run(1e-3, error=1e-4)[0] < 0.005

    with pytest.raises(CouplingError, match="diverges: .*circuit") as caught:
        run(5e-3, method="jacobi")
    partial = caught.value.results
    assert np.all(np.isfinite(partial["rotor.shaft.speed"])) and 0.01 < partial["time"][-1] < 1.0


def test_the_sequence_is_that_of_the_stiff_one_last():
    """Whatever comes first in the file: the winding, which answers to the speed within a step, before the rotor, by a trial."""
    run, told = motor(), []
    H, options = 5e-4, {"method": "gauss-seidel", "order": 1}
    best, _ = run(H, ["winding", "rotor"], told, **options)
    assert told == ["sequence: winding, rotor (others were no better in the first 25 steps)"]
    chosen, _ = run(H, ["rotor", "winding"], told, **options)
    assert (
        "sequence: winding, rotor (in the first 25 steps" in told[1]
        and "nearer than rotor, winding" in told[1]
    )
    other, _ = run(H, ["rotor", "winding"], sequence=["rotor", "winding"], **options)
    assert chosen == best < 0.15 * other


def test_energy_that_the_coupling_makes(file):
    """Two blocks that a gyrator joins: what the bond is said to make is what the energies and losses of both gain."""
    blocks = two(file)
    system = blocks.system(method="jacobi")
    names = system.fmu
    bond = System(
        fmu={name: names[name] for name in names},
        link=[
            {"source": "b0.rail.speed", "target": "b1.rail.force", "factor": 2.0, "units": False},
            {"source": "b1.rail.speed", "target": "b0.rail.force", "factor": -2.0, "units": False},
        ],
        bond={"gyrator": {"effort": "b0.rail.speed", "flow": "b1.rail.speed"}},
        master={"method": "jacobi"},
    )
    results = bond.simulate(2.0, 0.01)
    (report,) = results.bonds

    def energy(row):
        x, v = (
            np.array([results[f"{n}.rail.{q}"][row] for n in blocks.names]) for q in ("position", "speed")
        )
        return np.sum(blocks.mass * v**2 + blocks.stiffness * x**2) / 2

    v = np.column_stack([results[f"{n}.rail.speed"] for n in blocks.names])
    lost = np.trapezoid(np.sum(blocks.damper * v**2, axis=1), results["time"])
    gained = energy(-1) - energy(0) + lost
    # both links carry a force here, as in a gyrator: what the bond makes goes into both blocks
    assert abs(gained) > 1e-4
    assert report.made == pytest.approx(gained, rel=0.02)
    assert any("gyrator: the coupling made" in text for text in results.notices) == (report.part > 0.01)


def test_rollback_is_put_to_the_test(file):
    """An FMU that must not go back is stepped once."""
    blocks = two(file)
    system = blocks.system()
    system.fmu["b0"].rollback = False
    results = system.simulate(0.5, 0.01)
    assert results.work == {"b0": 50, "b1": 50}
    assert "cannot repeat steps" in system.check()

    system.master.method = "newton"
    with pytest.raises(CouplingError, match="b0 cannot go back"):
        system.simulate(0.5, 0.01)

    system.master.method, system.master.error = "auto", 1e-3
    with pytest.raises(CouplingError, match="error: .*b0 cannot go back"):
        system.simulate(0.5, 0.01)


def test_the_sequence_is_checked(file):
    for sequence, message in ((["b0", "b0"], "'b0' is there twice"), (["b7"], "no FMU 'b7'")):
        with pytest.raises(CouplingError, match=message):
            two(file).system(sequence=sequence).check()


def test_without_derivatives(file):
    """FMUs that take no derivatives see means: of order 2 all the same."""
    blocks = two(file)
    errors = []
    for H in (0.02, 0.01):
        system = blocks.system(tolerance=1e-10)
        for table in system.fmu.values():
            table.derivatives = False
        errors.append(blocks.error(system.simulate(1.0, H)))
    assert errors[0] / errors[1] == pytest.approx(4, rel=0.3)
