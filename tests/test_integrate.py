"""Steppers: order, tolerance, memory of the step size, inputs inside a step, failures, time."""

import numpy as np
import pytest
from numpy.polynomial import Polynomial
from scenes import assert_near, random_scene
from test_closed_forms import bars, reference

from mbdfmi import Scene
from mbdfmi.compiler.model import compile_scene
from mbdfmi.run.instance import Instance, SimulationError

LOOSE = 1e30


def instance_of(scene):
    """An instance of a scene written as a dict."""
    return Instance(compile_scene(Scene.model_validate(scene)))


def cart(**solver):
    """2 kg on a prismatic joint along x, driven by a force."""
    return instance_of(
        {
            "name": "cart",
            "gravity": [0, 0, 0],
            "solver": solver,
            "body": {"cart": {"mass": 2.0, "inertia": [1, 1, 1]}},
            "joint": {"rail": {"prismatic": {"axis": "x"}, "between": ["ground", "cart"], "input": "force"}},
        }
    )


def pendulum(angle, gravity=(0, 0, -9.81), **solver):
    """A bar on a revolute joint about y, from rest."""
    body = {"mass": 1.0, "com": [0, 0, -0.5], "inertia": [1 / 12, 1 / 12, 0.001]}
    joint = {"revolute": {"axis": "y"}, "between": ["ground", "bar"], "start": {"angle": angle}}
    return instance_of(
        {"name": "p", "gravity": gravity, "body": {"bar": body}, "joint": {"j": joint}, "solver": solver}
    )


def runaway(**solver):
    """1 kg that a drag of -1000 N s/m drives: x'' = 1000 x', so x overflows some 0.71 s after x' = 1."""
    drag = np.diag([-1000.0, 0, 0, 0, 0, 0]).tolist()
    return instance_of(
        {
            "name": "runaway",
            "gravity": [0, 0, 0],
            "solver": solver,
            "body": {"cart": {"mass": 1.0, "inertia": [1, 1, 1]}},
            "joint": {
                "rail": {"prismatic": {"axis": "x"}, "between": ["ground", "cart"], "start": {"speed": 1.0}}
            },
            "force": {"drag": {"linear": {"damping": drag}, "between": ["ground", "cart"]}},
        }
    )


# accuracy


def tip_error(instance, n=1, until=1.0):
    """Largest distance of the double pendulum's end from its reference, each 0.5 s until (s), n steps a second."""
    column = reference("double_pendulum_bars")["column"]
    errors = []

    for k in range(round(2 * until)):
        for _ in range(max(1, n // 2)):
            instance.step(0.5 / max(1, n // 2))

        tip = instance.outputs()[:2]
        errors.append(np.hypot(tip[0] - column["tip_x"][k], tip[1] - column["tip_y"][k]))

    return max(errors)


def slope(h, errors):
    """Order that errors show."""
    return np.polyfit(np.log(h), np.log(errors), 1)[0]


def test_rk4_is_of_order_4():
    n_steps = np.array([200, 300, 400, 600, 800])
    errors = []

    for n in n_steps:
        instance = instance_of(bars(2, solver={"integrator": "rk4", "step": 1 / n}))
        errors.append(tip_error(instance, until=2.0))
        assert instance.d.steps[0] == 2 * n

    # a tenth for the next term of the error
    assert slope(1 / n_steps, errors) == pytest.approx(4, abs=0.1)
    assert errors[-1] < 1e-7


def test_rk54_is_of_order_5():
    """Its coefficients alone: steps that no error estimate chose, one each communication step."""
    n_steps = np.array([200, 300, 400, 600])
    errors = []

    for n in n_steps:
        instance = instance_of(bars(2, solver={"integrator": "rk54", "max_step": 1 / n}))
        instance.m.tolerance[0] = LOOSE
        instance.d.next_step[0] = 1.0
        errors.append(tip_error(instance, n, until=2.0))
        assert instance.d.steps[0] == 2 * n

    assert slope(1 / n_steps, errors) == pytest.approx(5, abs=0.2)
    assert errors[-1] < 1e-9


@pytest.mark.parametrize("integrator, order", [("rk54", 5), ("rk853", 8), ("auto", 8)])
def test_error_follows_the_tolerance(integrator, order):
    tolerances = 10.0 ** -np.arange(4, 13)
    errors, work = [], []

    for tolerance in tolerances:
        instance = instance_of(bars(2, solver={"integrator": integrator, "tolerance": tolerance}))
        errors.append(tip_error(instance))
        work.append(instance.d.evaluations[0])

    # proportional but for the unevenness of single runs; the finer runs' work grows as tolerance^(-1/order)
    assert slope(tolerances, errors) == pytest.approx(1, abs=0.2)
    assert np.all(errors < 10 * tolerances)
    assert slope(tolerances[4:], work[4:]) == pytest.approx(-1 / order, abs=0.03)


def test_absolute_tolerance_alone_bounds_small_motions():
    errors = []

    for absolute in (1e-12, 1e-6):
        instance = pendulum(1e-3, tolerance=1e-6, absolute_tolerance=absolute)
        instance.step(1.0)
        errors.append(abs(instance.d.x[0] - 1e-3 * np.cos(np.sqrt(9.81 * 1.5))))

    # an amplitude of 1e-3 shifts the phase by 1e-3^2 / 16, 1e-10 of angle
    assert errors[0] < 1e-9 < errors[1]


def test_max_step_is_kept():
    instance = pendulum(1.0, max_step=0.01)
    instance.m.tolerance[0] = LOOSE
    instance.d.next_step[:] = 1.0
    instance.step(1.0)
    assert instance.d.steps[0] == 100


def test_a_rotation_is_weighed_as_one_however_often_it_turned():
    """A pendulum that starts 10,000 turns further takes the same steps, but for its guess of the first."""
    near, far = pendulum(2.0, tolerance=1e-10), pendulum(2.0 + 2 * np.pi * 1e4, tolerance=1e-10)

    for instance in (near, far):
        instance.step(10.0)

    assert abs(near.d.steps[0] - far.d.steps[0]) <= 5

    # 6e4 rad hold 7e-12 rad
    assert far.d.x[0] - 2 * np.pi * 1e4 == pytest.approx(near.d.x[0], abs=1e-8)


def test_euler_parameters_keep_unit_length():
    for solver in ({"integrator": "rk4", "step": 0.01}, {"tolerance": 1e-4}):
        scene = random_scene(3, 5, kinds=("spherical", "free"), elements=False, added_mass=False)
        instance = instance_of(scene.model_dump(exclude_unset=True) | {"solver": solver})
        kinds = instance.m.body_joint[1:]

        for _ in range(20):
            instance.step(0.05)

            for kind, q in zip(kinds, instance.m.body_q[1:]):
                first = q + (3 if kind == 3 else 0)
                assert np.linalg.norm(instance.d.x[first : first + 4]) == pytest.approx(1, abs=4e-16)


# memory across communication steps


def steps_taken(n):
    """Inner steps over 5 s in n communication steps."""
    instance = instance_of(bars(2, solver={"integrator": "rk54", "tolerance": 1e-9}))

    for _ in range(n):
        instance.step(5.0 / n)

    return instance.d.steps[0], instance.d.rejected[0]


def test_step_size_survives_communication_steps():
    """Where inputs stay as they are, communication points cut no inner step short."""
    alone, rejected_alone = steps_taken(1)
    assert alone > 500

    for n in (10, 50, 100, 2000):
        steps, rejected = steps_taken(n)
        assert abs(steps - alone) <= 2
        assert abs(rejected - rejected_alone) <= 2


@pytest.mark.parametrize("integrator, evaluations", [("rk54", 7), ("rk853", 13), ("auto", 4)])
def test_inputs_that_jump_make_one_step_of_each_short_communication_step(integrator, evaluations):
    """And a new rate at its start. `auto` takes the pair with fewer stages, once it knows that steps are short."""
    scene = bars(2, solver={"integrator": integrator, "tolerance": 1e-6})
    scene["joint"]["j1"]["input"] = "torque"
    instance = instance_of(scene)

    def go(n):
        for k in range(n):
            instance.u[0] = (-1) ** k
            instance.step(1e-3)

        return instance.d.steps[0], instance.d.evaluations[0]

    go(20)
    before = np.array(go(20))
    rejected = instance.d.rejected[0]
    assert np.array_equal(go(100) - before, [100, 100 * evaluations])
    assert instance.d.rejected[0] == rejected


def test_rest_costs_next_to_nothing():
    """Nothing moves: one communication step of any length is a few inner steps."""
    instance = pendulum(0.0)
    instance.step(1.0)
    instance.step(1000.0)
    assert instance.d.steps[0] < 30
    assert_near(instance.d.x, [0, 0])


def test_communication_steps_do_not_change_the_result_beyond_the_tolerance():
    for n in (1, 14, 100, 3000):
        assert tip_error(instance_of(bars(2, solver={"tolerance": 1e-10})), n) < 1e-9


# inputs inside a communication step


@pytest.mark.parametrize(
    "solver", [{"integrator": "rk4", "step": 0.01}, {"integrator": "rk4", "step": 5.0}, {}]
)
def test_a_force_of_t_squared(solver):
    """F = t^2 as u = u' = 0, u'' = 2: x' = t^3 / 6, x = t^4 / 24 with 2 kg. Both methods integrate it exactly."""
    instance = cart(**solver)
    instance.u[:3] = [0, 0, 2]
    instance.step(3.0)
    assert_near(instance.d.x, [3**4 / 24, 3**3 / 6], rtol=1e-13)


@pytest.mark.parametrize("solver", [{"integrator": "rk4", "step": 0.01}, {}])
def test_inputs_are_polynomials_from_the_start_of_each_step(solver):
    """Value, first and second derivative change from step to step."""
    instance = cart(**solver)
    position, speed = 0.0, 0.0
    rng = np.random.default_rng(5)

    for H in (0.3, 1.0, 0.05, 2.0):
        u = rng.normal(size=3)
        instance.u[:3] = u
        instance.step(H)
        acceleration = Polynomial([u[0], u[1], u[2] / 2]) / 2
        position += speed * H + acceleration.integ(2)(H)
        speed += acceleration.integ(1)(H)
        assert_near(instance.d.x, [position, speed], atol=1e-13)


def test_outputs_feel_the_inputs_value_alone():
    scene = {
        "name": "cart",
        "gravity": [0, 0, 0],
        "body": {"cart": {"mass": 2.0, "inertia": [1, 1, 1]}},
        "joint": {
            "rail": {
                "prismatic": {},
                "between": ["ground", "cart"],
                "input": "force",
                "output": ["acceleration"],
            }
        },
    }
    instance = instance_of(scene)
    instance.u[:3] = [3.0, 100.0, 1e6]
    assert instance.outputs()[0] == 1.5


# failures


@pytest.mark.parametrize("solver", [{"integrator": "rk4", "step": 0.01}, {}])
@pytest.mark.parametrize("place", [0, 1, 2])
@pytest.mark.parametrize("value", [np.nan, np.inf])
def test_an_input_that_is_not_finite_leaves_the_last_state(solver, place, value):
    for before in (0, 1):
        instance = cart(**solver)
        instance.u[0] = 1.0

        for _ in range(before):
            instance.step(0.1)

        x, time = instance.d.x.copy(), instance.time
        instance.u[place] = value

        with pytest.raises(SimulationError, match="no longer finite"):
            instance.step(0.1)

        assert np.array_equal(instance.d.x, x)
        assert instance.time == time

        # and it goes on from there
        instance.u[:] = [1.0, 0, 0, 0, 0, 0]
        instance.step(0.1)
        t = 0.1 * (before + 1)
        assert_near(instance.d.x, [t**2 / 4, t / 2], atol=1e-15)


@pytest.mark.parametrize("solver", [{"integrator": "rk4", "step": 1e-4}, {"tolerance": 1e-6}])
def test_a_motion_that_overflows_stops_at_its_last_finite_state(solver):
    instance = runaway(**solver)

    with pytest.raises(SimulationError, match="no longer finite") as caught:
        instance.step(10.0)

    # x' = e^(1000 t) up to the largest number there is; the logarithm's error is that of the method
    assert caught.value.time == instance.time
    assert np.all(np.isfinite(instance.d.x))
    assert np.log(instance.d.x[1]) == pytest.approx(1000 * instance.time, rel=1e-3)
    assert 690 < 1000 * instance.time < 710


@pytest.mark.parametrize("turned", [[0, 0, 0], [10, 20, 30], [40, -20, 70]])
@pytest.mark.parametrize("com", [[0, 0, 1], [1, 2, 3], [0.1, 0.25, 0.3], [0, 0, 0]])
def test_inertia_without_a_part_is_named(turned, com):
    """A point mass on the joint's axis: no inertia about it, also where rounding leaves some."""
    scene = {
        "name": "bead",
        "ground": {"marker": {"site": {"zyx_deg": turned}}},
        "body": {"bead": {"mass": 2.0, "com": com, "inertia": [0, 0, 0]}},
        "joint": {
            "hinge": {"revolute": {"axis": com if any(com) else "x"}, "between": ["ground.site", "bead"]}
        },
    }

    with pytest.raises(SimulationError, match="inertia about the joint of bead"):
        instance_of(scene).step(0.1)


def test_a_slender_rod_is_not_singular():
    """Thirteen orders between its moments of inertia about a spherical joint are few enough."""
    rod = {"mass": 1.0, "com": [0, 0, -1], "inertia": [1e-12, 1e-12, 1e-13]}
    scene = {
        "name": "rod",
        "body": {"rod": rod},
        "joint": {"j": {"spherical": {}, "between": ["ground", "rod"]}},
    }
    instance = instance_of(scene)
    instance.step(0.1)
    assert np.all(np.isfinite(instance.d.x))


# time


@pytest.mark.parametrize("start", [0.0, 1e6])
def test_time_is_the_exact_sum_of_the_steps(start):
    """100,000 steps of 0.1 s, each of which rounds: nothing adds up."""
    instance = Instance(cart(integrator="rk4", step=0.1).model, start_time=start)

    for _ in range(100_000):
        instance.step(0.1)

    assert instance.time == pytest.approx(start + 1e4, abs=np.spacing(start + 1e4))


def test_time_after_a_failure_is_that_of_the_state():
    instance = runaway(integrator="rk4", step=1e-4)
    instance.step(0.5)

    with pytest.raises(SimulationError) as caught:
        instance.step(0.5)

    time = instance.time
    assert 0.69 < time < 0.71
    assert caught.value.time == time

    # a run that ends there has the same state
    other = runaway(integrator="rk4", step=1e-4)
    other.step(0.5)
    other.step(time - 0.5)
    assert other.d.x[1] == pytest.approx(instance.d.x[1], rel=1e-9)


def test_a_scene_that_cannot_move_keeps_time():
    body = {"mass": 1.0, "inertia": [1, 1, 1]}
    scene = {
        "name": "rock",
        "body": {"rock": body},
        "joint": {"j": {"fixed": {}, "between": ["ground", "rock"]}},
    }
    instance = instance_of(scene)
    instance.step(2.5)
    assert instance.time == 2.5
