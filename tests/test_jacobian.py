"""The Jacobian of the implicit methods: its structure against differences without, its factors, and what a snapshot keeps of it."""

import numpy as np
import pytest
from loop_scenes import LOOP, random_loops, with_solver
from scenes import random_instance, random_scene
from test_closed_forms import bars
from test_integrate import instance_of

from benchmarks import choice
from mbdfmi import Scene
from mbdfmi.compiler.model import compile_scene
from mbdfmi.kernels.dynamics.projection import keep_x
from mbdfmi.kernels.dynamics.rates import evaluate, evaluate_now, store_rate
from mbdfmi.kernels.math import linear
from mbdfmi.kernels.steppers import control, radau
from mbdfmi.kernels.steppers.jacobian import INCREMENT, find_jacobian
from mbdfmi.steppers import STEPPERS

STIFF = {"integrator": "radau", "tolerance": 1e-6}


def whole_matrix(m, values):
    """(n_x, n_x) of values that stand by their elements."""
    matrix = np.zeros((m.n_x, m.n_x))

    for b in range(m.n_block):
        size = m.block_size[b]
        rows = m.place_x[m.block_place[b] : m.block_place[b] + size]

        for e in range(m.block_element[b], m.block_element[b] + m.block_elements[b]):
            width = m.element_width[e]
            at = m.block_place[m.element_block[e]] + m.element_first[e]
            value = values[m.element_value[e] : m.element_value[e] + size * width]
            matrix[np.ix_(rows, m.place_x[at : at + width])] = value.reshape(size, width)

    return matrix


def net(rows, columns, stiffness, damping, **solver):
    """`choice.net` as a scene."""
    return Scene.model_validate(
        {"name": "net", "solver": solver} | choice.net(rows, columns, stiffness, damping)
    )


def by_single_columns(m, d, x):
    """(n_x, n_x): each column by an evaluation of its own; those of angles outside the tree are zero by what they are."""
    rate = d.x_rate.copy()
    matrix = np.zeros((m.n_x, m.n_x))

    for k in range(m.n_x - m.n_turn):
        d.x[k] = x[k] + INCREMENT / m.tolerance[0] * d.x_scale[k]
        change = d.x[k] - x[k]
        assert evaluate_now(m, d) == 0
        matrix[:, k] = (d.x_rate - rate) / change
        d.x[:] = x

    return matrix


def assert_structure_holds(instance):
    """J by groups of columns has the bits of J by single ones, and both factors solve what they are of."""
    m, d = instance.m, instance.d
    x = d.x.copy()
    n = m.n_x
    assert sorted(m.place_x) == list(range(n))
    assert evaluate(m, d, 0.0) == 0
    store_rate(m, d, 0)
    control.weigh(m, d)
    wanted = by_single_columns(m, d, x)
    assert find_jacobian(m, d, 0) == 0
    J = whole_matrix(m, d.jacobian)
    assert np.array_equal(J, wanted)
    assert np.array_equal(d.x, x)

    mu = 2.0 * np.abs(J).max() ** 0.5 + 1.0
    linear.factor(m, d.jacobian, mu, d.lu_real, d.swaps_real)
    linear.factor_complex(m, d.jacobian, mu, -mu, d.lu_complex, d.swaps_complex)
    right = np.random.default_rng(1).normal(size=3 * n)
    x = right.copy()
    linear.solve(m, d.lu_real, d.swaps_real, x, 0, d.right)
    linear.solve_complex(m, d.lu_complex, d.swaps_complex, x, n, d.right)
    z = x[n : 2 * n] + 1j * x[2 * n :]
    size = np.abs(J).max() + mu
    assert np.abs((mu * np.eye(n) - J) @ x[:n] - right[:n]).max() < 1e-12 * size * np.abs(x).max()
    left = (mu - 1j * mu) * z - J @ z - right[n : 2 * n] - 1j * right[2 * n :]
    assert np.abs(left).max() < 1e-12 * size * np.abs(x).max()


@pytest.mark.parametrize("seed", range(3))
def test_factors_of_any_matrix_in_blocks(seed):
    """With no shift at all rows must be exchanged within blocks: both factors solve random systems."""
    m, d = compile_scene(Scene.model_validate(bars(3, solver=STIFF))).views()
    n = m.n_x
    rng = np.random.default_rng(seed)
    d.jacobian[:] = rng.normal(size=m.n_jacobian)
    J = whole_matrix(m, d.jacobian)
    right = rng.normal(size=3 * n)
    x = right.copy()
    linear.factor(m, d.jacobian, 0.0, d.lu_real, d.swaps_real)
    linear.factor_complex(m, d.jacobian, 0.01, 0.02, d.lu_complex, d.swaps_complex)
    assert any(swap != k for k, swap in enumerate(d.swaps_complex))
    linear.solve(m, d.lu_real, d.swaps_real, x, 0, d.right)
    linear.solve_complex(m, d.lu_complex, d.swaps_complex, x, n, d.right)
    np.testing.assert_allclose(-J @ x[:n], right[:n], atol=1e-11)
    z = x[n : 2 * n] + 1j * x[2 * n :]
    np.testing.assert_allclose((0.01 + 0.02j) * z - J @ z, right[n : 2 * n] + 1j * right[2 * n :], atol=1e-11)


@pytest.mark.parametrize("seed", range(6))
def test_structure_of_trees(seed):
    assert_structure_holds(random_instance(random_scene(seed, 4 + seed), seed))


@pytest.mark.parametrize("seed", range(4))
def test_structure_of_loops(seed):
    loops = [sorted(LOOP)[seed], "revolute"]
    assert_structure_holds(
        random_instance(with_solver(random_loops(seed, loops, couplings=1), **STIFF), seed)
    )


def test_structure_of_a_net():
    """Its Jacobian takes about as many evaluations as a body and its neighbours have columns, however many bodies there are."""
    instance = instance_of(net(3, 4, 2e4, 5.0, **STIFF))
    instance.step(0.01)
    assert_structure_holds(instance)
    works = [compile_scene(net(n, 3, 2e4, 5.0, **STIFF)).views()[0].jacobian_work[0] for n in (10, 20)]
    assert max(works) < 100


def test_factors_of_nets_grow_as_their_bodies_do():
    values = [compile_scene(net(n, 4, 2e4, 5.0, **STIFF)).n_jacobian for n in (20, 40)]
    assert values[1] < 2.1 * values[0]


def hung(rows):
    """Evaluations, and steps with those rejected, of a stiff net five wide that hangs at its rest lengths and is let go."""
    tables = choice.net(rows, 5, 2e5, 5e3)

    for force in tables["force"].values():
        # one table for all
        force["spring_damper"].pop("rest_length", None)

    solver = STIFF | {"output": ["evaluations", "steps", "rejected_steps"]}
    results = Scene.model_validate({"name": "net", "solver": solver} | tables).simulate(until=0.2, step=0.01)
    steps = results["solver.steps"][-1] + results["solver.rejected_steps"][-1]
    return results["solver.evaluations"][-1], steps


def test_longer_nets_take_no_more_steps():
    """What grows with a net is the cost of an evaluation, unless the net moves in another way (docs/auto.md)."""
    evaluations, steps = np.array(hung(32)) / hung(8)
    assert evaluations < 1.2 and steps < 1.2


def test_the_jacobian_is_that_of_central_differences():
    instance = instance_of(bars(3, solver=STIFF))
    instance.d.x[:] = np.linspace(0.3, 1.3, 6)
    instance.d.next_step[STEPPERS["radau"].number] = 1e-9
    x = instance.d.x.copy()
    instance.step(1e-9)
    found = whole_matrix(instance.m, instance.d.jacobian)
    wanted = np.empty((6, 6))

    for k in range(6):
        rates = []

        for side in (1e-5, -1e-5):
            instance.d.x[:] = x
            instance.d.x[k] += side
            assert evaluate(instance.m, instance.d, 0.0) == 0
            rates.append(instance.d.x_rate.copy())

        wanted[:, k] = (rates[0] - rates[1]) / 2e-5

    assert found == pytest.approx(wanted, abs=1e-5 * np.abs(wanted).max())


def test_a_jacobian_found_ahead_leaves_the_weights_of_the_step():
    """Errors are weighed by the state that the step begins at, with the tolerance of an estimate of order 3."""
    instance = instance_of(bars(2, solver=STIFF))
    m, d = instance.m, instance.d
    instance.step(1e-4)
    keep_x(m, d)
    radau.weigh(m, d)
    weights = d.x_scale.copy()
    d.dense[2 * m.n_x : 3 * m.n_x] = 0.2
    assert radau.find_jacobian_ahead(m, d, 0.0, 1e-3) == 0
    np.testing.assert_array_equal(d.x_scale, weights)


# snapshots


def test_a_snapshot_carries_no_matrix():
    model = compile_scene(Scene(**bars(100, solver={})))
    assert model.n_jacobian > 0
    assert 8 * model.n_state < 60e3


@pytest.mark.parametrize("driver", [{}, {"driver": {"harmonic": {"amplitude": 0.1, "frequency": 1.0}}}])
def test_a_restored_run_finds_its_jacobian_again(driver):
    """To the bit, and with the same counts, though only the state where it was found is kept."""
    scene = bars(3, solver=STIFF)
    scene["joint"]["j1"] |= driver
    scene["joint"] |= {name: scene["joint"][name] | {"damper": 1e3} for name in ("j2", "j3")}
    first, second = instance_of(scene), instance_of(scene)
    kept = 0

    for _ in range(20):
        second.d.state_buffer[:] = first.d.state_buffer
        second.d.work_buffer[:] = 0.0
        kept += first.d.jacobian_known[0]
        first.step(0.01)
        second.step(0.01)
        assert np.array_equal(first.d.state_buffer, second.d.state_buffer)

    assert kept > 3


# the choice of `auto`


def work(scene):
    """Evaluations that a run of 0.2 s costs, with those that linear systems are worth."""
    instance = instance_of(scene)

    for _ in range(4):
        instance.step(0.05)

    return instance.d.evaluations[0] + instance.d.linear_work[0]


@pytest.mark.parametrize("damping", [5.0, 50.0])
def test_auto_costs_little_more_than_the_best(damping):
    """Nets that explicit pairs do well, though at the border of stability."""
    works = {
        name: work(net(2, 3, 2e4, damping, tolerance=1e-6, integrator=name))
        for name in ("auto", "rk853", "radau")
    }
    assert works["auto"] < 1.5 * min(works["rk853"], works["radau"])


def test_auto_takes_the_implicit_method_where_it_saves_work():
    scene = {"tolerance": 1e-6, "integrator": "auto"}
    instance = instance_of(net(2, 2, 2e5, 5e3, **scene))
    instance.step(0.2)
    assert instance.d.method[0] == STEPPERS["radau"].number
    assert instance.d.evaluations[0] < 6000
    assert len(instance.notices) == 1
