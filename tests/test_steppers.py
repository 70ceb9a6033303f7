"""Steppers one by one: order, stiffness, `auto`, the continuous extension, what they remember and tell."""

import numpy as np
import pytest
from test_closed_forms import bars
from test_integrate import instance_of, slope

from mbdfmi import Scene
from mbdfmi.compiler.model import compile_scene
from mbdfmi.run.instance import Instance, SimulationError
from mbdfmi.steppers import RK32, RKC, STEPPERS

OMEGA = 3.0
ADAPTIVE = ["rk54", "rk853", "radau", "auto"]


def oscillator(solver, stiffness=OMEGA**2, damper=0.0, start=1.0, **joint):
    """1 kg on a spring and damper along x; x = 1 m at the start; one input, the force."""
    rail = {"prismatic": {"axis": "x"}, "between": ["ground", "cart"], "spring": {"stiffness": stiffness}}
    rail |= {"damper": damper, "start": {"position": start}, "input": "force"} | joint
    body = {"cart": {"mass": 1.0, "inertia": [1, 1, 1]}}
    return instance_of(
        {"name": "o", "gravity": [0, 0, 0], "solver": solver, "body": body, "joint": {"rail": rail}}
    )


def test_numbers_tell_steppers_apart():
    numbers = [record.number for record in (*STEPPERS.values(), RK32, RKC)]
    assert sorted(numbers) == list(range(len(numbers)))


# order


@pytest.mark.parametrize(
    "integrator, order, n_steps",
    [
        ("rk54", 5, [20, 30, 40]),
        ("rk853", 8, [10, 15, 20]),
        ("radau", 5, [20, 30, 40]),
        ("ros2", 2, [100, 150, 200]),
        ("gauss", 8, [7, 10, 14]),
    ],
)
def test_order(integrator, order, n_steps):
    """Equal steps over 3 s; of the adaptive ones such that no error estimate chose: it is given no weight."""
    errors = []

    for n in n_steps:
        step = 3 / n
        adaptive = {"max_step": step, "tolerance": 1e-12}
        instance = oscillator(
            {"integrator": integrator} | (adaptive if integrator in ADAPTIVE else {"step": step})
        )
        instance.m.absolute_tolerance[0] = 1e30
        instance.d.next_step[:] = step
        instance.step(3.0)
        exact = np.array([np.cos(3 * OMEGA), -OMEGA * np.sin(3 * OMEGA)])
        errors.append(np.linalg.norm((instance.d.x - exact) / [1, OMEGA]))
        assert instance.d.steps[0] == n

    assert slope(1 / np.array(n_steps), errors) == pytest.approx(order, abs=0.25)


# stiffness


@pytest.mark.parametrize("integrator", ["radau", "auto"])
@pytest.mark.parametrize("damper", [1e3, 1e6, 1e9])
def test_heavy_damping_costs_no_more_steps(integrator, damper):
    """x'' = -c x' - k x with roots near -c and -k / c: against the exact sum of two exponentials."""
    stiffness = damper
    instance = oscillator({"integrator": integrator, "tolerance": 1e-8}, stiffness, damper)
    root = np.sqrt(damper**2 - 4 * stiffness)
    fast, slow = -(damper + root) / 2, -2 * stiffness / (damper + root)

    for k in range(5):
        instance.step(1.0)
        t = instance.time
        exact = (slow * np.exp(fast * t) - fast * np.exp(slow * t)) / (slow - fast)
        assert instance.d.x[0] == pytest.approx(exact, abs=1e-7)

    assert instance.d.steps[0] < 400


def test_auto_says_that_the_motion_is_stiff_and_that_it_no_longer_is():
    scene = {"integrator": "auto", "tolerance": 1e-6}
    instance = oscillator(scene, 1e6, 1e6)
    instance.step(3.0)
    assert len(instance.notices) == 1
    assert "stiff: the implicit method goes on from here (time 3 s)" in instance.notices[0]
    evaluations = instance.d.evaluations[0]

    # a parameter set between two steps: the damper breaks
    names = {v.name: v.index for v in instance.model.of_causality("parameter")}
    instance.reals[names["rail.damper"]] = 0.0
    instance.reals[names["rail.stiffness"]] = 1.0
    instance.prepare()
    instance.d.x[:2] = [1.0, 0.0]
    instance.step(20.0)
    assert "no longer pays" in instance.notices[1]
    assert instance.d.x[0] == pytest.approx(np.cos(20.0), abs=1e-4)
    assert instance.d.evaluations[0] - evaluations < 1000


@pytest.mark.parametrize("tolerance", [1e-4, 1e-8, 1e-12])
def test_auto_takes_fast_oscillation_for_what_it_is(tolerance):
    """Undamped, with its energy in it: it must be followed, and the explicit pair does that best."""
    instance = oscillator({"integrator": "auto", "tolerance": tolerance}, 1e8)
    instance.step(0.1)
    assert not instance.notices
    assert instance.d.x[0] == pytest.approx(np.cos(1e3), abs=1e4 * tolerance)


@pytest.mark.parametrize("step", [1e-3, 0.1])
def test_ros2_damps_what_its_step_cannot_resolve(step):
    """A spring of 1e8 N/m with a damper, from 1 m off: explicit steps would have to be 1e-4 s."""
    instance = oscillator({"integrator": "ros2", "step": step}, 1e8, 1e4)
    instance.step(20.0)
    assert np.abs(instance.d.x).max() < 1e-6
    assert instance.d.evaluations[0] == round(20 / step) * (instance.model.n_x + 2)


def test_gauss_says_that_it_is_not_for_stiff_motions():
    instance = oscillator({"integrator": "gauss", "step": 0.1}, 1e8, 1e4)

    with pytest.raises(SimulationError, match='take integrator = "auto"') as caught:
        instance.step(1.0)

    assert caught.value.time == 0.0
    assert instance.d.x[0] == 1.0


# the long run


def test_gauss_keeps_the_energy_of_an_oscillator_to_rounding():
    """A quadratic invariant; 1,000 periods of 20 steps."""
    instance = oscillator({"integrator": "gauss", "step": 2 * np.pi / OMEGA / 20})
    instance.step(1000 * 2 * np.pi / OMEGA)
    x, v = instance.d.x
    assert v**2 + OMEGA**2 * x**2 == pytest.approx(OMEGA**2, rel=1e-12)


# the continuous extension


@pytest.mark.parametrize("integrator", ["rk54", "rk853", "auto"])
@pytest.mark.parametrize("H", [1e-3, 0.013, 0.1])
def test_states_between_inner_steps_are_as_good_as_those_at_their_ends(integrator, H):
    instance = oscillator({"integrator": integrator, "tolerance": 1e-9})
    errors = []

    while instance.time < 5.0:
        instance.step(H)
        t = instance.time
        exact = [np.cos(OMEGA * t), -OMEGA * np.sin(OMEGA * t)]
        errors.append(np.abs(instance.d.x - exact).max())

    assert max(errors) < 3e-8

    if H == 1e-3:
        assert instance.d.evaluations[0] < 2000


@pytest.mark.parametrize("integrator", ADAPTIVE)
def test_an_input_that_jumps_is_felt_at_once_however_far_the_front_is(integrator):
    """A force that is switched each 0.1 s while inner steps could be longer: exact by pieces."""
    instance = oscillator({"integrator": integrator, "tolerance": 1e-10})
    x, v = 1.0, 0.0

    for k in range(40):
        # some without a jump, so that the front goes ahead
        instance.u[0] = force = float(k // 3 % 2) * 5.0
        instance.step(0.1)
        rest = force / OMEGA**2
        c, s = np.cos(0.1 * OMEGA), np.sin(0.1 * OMEGA)
        x, v = rest + (x - rest) * c + v / OMEGA * s, v * c - (x - rest) * OMEGA * s
        assert instance.d.x[:2] == pytest.approx([x, v], abs=1e-8)


@pytest.mark.parametrize("integrator", ADAPTIVE)
def test_a_parameter_that_changes_is_felt_at_once(integrator):
    instance = oscillator({"integrator": integrator, "tolerance": 1e-10})
    instance.step(0.01)
    instance.step(0.01)
    index = next(v.index for v in instance.model.variables if v.name == "rail.stiffness")
    instance.reals[index] = 4 * OMEGA**2
    instance.prepare()
    x0, v0 = instance.d.x
    instance.step(0.5)
    w = 2 * OMEGA
    assert instance.d.x[0] == pytest.approx(x0 * np.cos(0.5 * w) + v0 / w * np.sin(0.5 * w), abs=1e-9)


# what they tell


@pytest.mark.parametrize("integrator", ADAPTIVE)
def test_outputs_of_the_solver(integrator):
    """The estimated error is of the size of the tolerance times the steps at most."""
    output = ["steps", "rejected_steps", "evaluations", "estimated_error"]
    solver = {"integrator": integrator, "tolerance": 1e-6, "output": output}
    instance = instance_of(bars(2, solver=solver))
    instance.step(2.0)
    names = [v.name for v in instance.model.of_causality("output")]
    told = dict(zip(names, instance.outputs()))
    assert told["solver.steps"] == instance.d.steps[0] > 10
    assert told["solver.rejected_steps"] == instance.d.rejected[0]
    assert told["solver.evaluations"] == instance.d.evaluations[0] > told["solver.steps"]
    assert 0.01 * told["solver.steps"] < told["solver.estimated_error"] / 1e-6 <= told["solver.steps"]


@pytest.mark.parametrize("integrator", sorted(STEPPERS))
@pytest.mark.parametrize(
    "driver", [{"constant_speed": 3.0}, {"harmonic": {"amplitude": 0.8, "frequency": 0.7}}]
)
def test_driven_loops_stay_closed(integrator, driver):
    """At every communication point the loop is closed where its drive is then, whatever stages a method has."""

    def bar(length):
        return {"mass": 1.0, "inertia": [0.1, 0.1, 0.1], "marker": {"end": {"position": [length, 0, 0]}}}

    hinge = {"revolute": {"axis": "y"}}
    solver = {"integrator": integrator} | ({"step": 0.01} if integrator in ("rk4", "ros2", "gauss") else {})
    scene = Scene(
        name="driven",
        solver=solver,
        output=["constraint_gap", "constraint_rate"],
        ground={"marker": {"far": {"position": [2, 0, 0]}}},
        body={"a": bar(0.5), "b": bar(2.0), "c": bar(1.0)},
        joint={
            "1": hinge | {"between": ["ground", "a"], "driver": driver},
            "2": hinge | {"between": ["a.end", "b"]},
            "3": hinge | {"between": ["b.end", "c"]},
            "4": hinge | {"between": ["c.end", "ground.far"], "start": {"angle_deg": -60}},
        },
    )
    instance = Instance(compile_scene(scene))

    for _ in range(20):
        instance.step(0.025)
        assert max(instance.outputs()) < 1e-12
