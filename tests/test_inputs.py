"""Inputs of in-process runs: functions are followed within communication steps, arrays held, the wrong ones refused."""

import numpy as np
import pytest
from numpy.testing import assert_allclose

import mbdfmi
from mbdfmi.compiler.model import compile_scene
from mbdfmi.run.instance import Instance


def cart(**solver):
    """1 kg along x under a force; free otherwise."""
    return mbdfmi.Scene(
        name="cart",
        gravity=[0, 0, 0],
        body={"a": {"mass": 1, "inertia": [0, 0, 0]}},
        joint={
            "j": {
                "prismatic": {},
                "between": ["ground", "a"],
                "input": "force",
                "output": ["position", "speed"],
            }
        },
        solver={"output": ["evaluations"]} | solver,
    )


SMOOTH = {
    "sine": (np.sin, lambda t: t - np.sin(t), lambda t: 1 - np.cos(t)),
    "fast": (
        lambda t: 100 * np.sin(10 * t),
        lambda t: 10 * t - np.sin(10 * t),
        lambda t: 10 - 10 * np.cos(10 * t),
    ),
    "decay": (lambda t: np.exp(-t), lambda t: t - 1 + np.exp(-t), lambda t: 1 - np.exp(-t)),
    "ramp": (lambda t: 1e6 * t, lambda t: 1e6 * t**3 / 6, lambda t: 1e6 * t**2 / 2),
    "bell": (lambda t: 2 * t * np.exp(-t * t), None, lambda t: 1 - np.exp(-t * t)),
}


@pytest.mark.parametrize("step", [None, 0.1, 1.0, 10.0])
@pytest.mark.parametrize("name", SMOOTH)
def test_smooth_functions_within_a_hundred_tolerances(name, step):
    """x'' = f(t) from rest, at all communication points, with steps of any size."""
    force, position, speed = SMOOTH[name]
    results = cart().simulate(until=10, step=step, inputs={"j.force": force})
    t = results["time"]

    for key, law in (("j.position", position), ("j.speed", speed)):
        if law:
            assert_allclose(results[key], law(t), rtol=1e-6, atol=1e-6 * max(1.0, abs(law(t)).max() * 1e-2))

    assert results["j.force"] == pytest.approx(force(t))


@pytest.mark.parametrize("integrator", ["rk54", "rk853", "radau", "gauss", "ros2", "rk4"])
def test_with_every_stepper(integrator):
    fixed = {"step": 0.01} if integrator in ("gauss", "ros2", "rk4") else {}
    results = cart(integrator=integrator, **fixed).simulate(until=2, step=0.1, inputs={"j.force": np.sin})
    assert_allclose(
        results["j.position"],
        results["time"] - np.sin(results["time"]),
        atol=2e-5 if integrator == "ros2" else 1e-7,
    )


@pytest.mark.parametrize("at", [0.3, 1 / 3, 0.5, 0.9999999, 1e-7, 0.2])
@pytest.mark.parametrize("step", [0.1, 1.0])
def test_jumps_and_corners_are_found(at, step):
    """A force that is switched on, and one that sets in with a corner, anywhere in a step."""
    jump = cart().simulate(until=1, step=step, inputs={"j.force": lambda t: 0.0 if t < at else 5.0})
    after = np.maximum(jump["time"] - at, 0)
    assert_allclose(jump["j.speed"], 5 * after, atol=1e-7)
    assert_allclose(jump["j.position"], 2.5 * after**2, atol=1e-7)

    corner = cart().simulate(until=1, step=step, inputs={"j.force": lambda t: max(0.0, t - at)})
    assert_allclose(corner["j.speed"], after**2 / 2, atol=1e-8)
    assert not jump.notices and not corner.notices
    assert jump["solver.evaluations"][-1] < 1500


def test_a_square_wave_within_one_step():
    """25 pulses a step: what each adds to the speed is there."""
    results = cart().simulate(until=1, step=0.5, inputs={"j.force": lambda t: float(t * 50 % 1 < 0.3)})
    assert_allclose(results["j.speed"], [0, 0.15, 0.3], atol=1e-5)


def test_noise_is_held_and_told():
    rng = np.random.default_rng(1)
    results = cart().simulate(until=1, step=0.5, inputs={"j.force": lambda t: rng.normal()})
    assert_allclose(results["j.speed"][2], 0.5 * (results["j.force"][0] + results["j.force"][1]), rtol=1e-9)
    assert any("'j.force' is not smooth" in notice for notice in results.notices)


def test_functions_are_asked_within_the_run_alone():
    asked = []
    cart().simulate(until=2.0, start_time=0.5, step=0.3, inputs={"j.force": lambda t: asked.append(t) or 1.0})
    assert min(asked) == 0.5 and max(asked) == 2.0


def test_smooth_functions_cost_little():
    """Evaluations with a function that varies against the same held at the communication points."""
    times = np.linspace(0, 10, 501)
    smooth = cart().simulate(until=10, inputs={"j.force": np.sin})
    held = cart().simulate(until=10, inputs={"j.force": np.sin(times)})
    assert smooth["solver.evaluations"][-1] <= 2 * held["solver.evaluations"][-1]


def test_a_function_that_is_constant_costs_nothing():
    constant = cart().simulate(until=10, inputs={"j.force": lambda t: 2.0})
    number = cart().simulate(until=10, inputs={"j.force": 2.0})
    assert np.array_equal(constant["j.position"], number["j.position"])
    assert constant["solver.evaluations"][-1] == number["solver.evaluations"][-1]


def test_arrays_are_held():
    results = cart().simulate(until=1, step=0.5, inputs={"j.force": [1.0, 3.0, 100.0]})
    assert_allclose(results["j.speed"], [0, 0.5, 2.0], atol=1e-12)


def wrench():
    return mbdfmi.Scene(
        name="wrench",
        gravity=[0, 0, 0],
        body={"a": {"mass": 2, "inertia": [1, 1, 1], "input": ["force"], "output": ["velocity"]}},
        joint={"j": {"free": {}, "between": ["ground", "a"]}},
    )


def test_functions_of_arrays():
    results = wrench().simulate(until=2, step=0.5, inputs={"a.force": lambda t: [np.cos(t), 2 * t, 4.0]})
    t = results["time"]
    found = np.column_stack([results[f"a.velocity[{k}]"] for k in (1, 2, 3)])
    assert_allclose(found, np.column_stack([np.sin(t) / 2, t**2 / 2, 2 * t]), atol=1e-8)


@pytest.mark.parametrize(
    "given, said",
    [
        ("5", "'j.force' needs numbers, found '5'"),
        (None, "needs numbers"),
        ([1.0, "x", 2.0], "needs numbers"),
        ([1.0, np.nan, 2.0], "must be finite"),
        ([1.0, 2.0], "communication points; found shape (2,)"),
        (lambda t: None, "'j.force': its function must return a finite number; found None at 0 s"),
        (lambda t: [1.0, 2.0], "must return a finite number; found [1.0, 2.0] at 0 s"),
        (lambda t: "1", "must return a finite number"),
        (
            lambda t: 1.0 if t < 0.3 else np.nan,
            "'j.force': its function must return a finite number; found nan at 0.3",
        ),
        (lambda t: 1 / (0.7 - t) if t < 0.7 else np.inf, "found inf at"),
    ],
)
def test_inputs_that_are_refused(given, said):
    with pytest.raises(ValueError) as error:
        cart().simulate(until=1, step=0.5, inputs={"j.force": given})

    assert said in str(error.value)


@pytest.mark.parametrize(
    "arguments",
    [{"until": "1"}, {"until": 1, "step": "0.1"}, {"until": None}, {"until": 1, "start_time": "0"}],
)
def test_times_that_are_no_numbers(arguments):
    with pytest.raises(ValueError, match="needs a number, found"):
        cart().simulate(**arguments)


# inputs by their derivatives, step by step, as a master gives them


def follow(integrator, force, n=200, H=0.01):
    """(instance of the cart, its speeds) of n steps under a force given by its value and derivatives at the start of each."""
    instance = Instance(compile_scene(cart(integrator=integrator, tolerance=1e-8)))
    speeds = []

    for k in range(n):
        for row, value in enumerate(force(k * H)):
            instance.u[row] = value

        instance.step(H)
        speeds.append(instance.d.v[0])

    return instance, np.array(speeds)


GOING_ON = {
    "held": (lambda t: [2.0], lambda t: 2.0 * t),
    "ramp": (lambda t: [1.0 + 3.0 * t, 3.0], lambda t: t + 1.5 * t**2),
    "through zero": (lambda t: [3.0 * t - 3.0, 3.0], lambda t: 1.5 * t**2 - 3.0 * t),
    "parabola": (lambda t: [1.0 + 0.3 * t**2, 0.6 * t, 0.6], lambda t: t + 0.1 * t**3),
    "quintic": (lambda t: [t**5, 5 * t**4, 20 * t**3, 60 * t**2, 120 * t, 120.0], lambda t: t**6 / 6),
}


@pytest.mark.parametrize("integrator", ["rk54", "rk853", "auto"])
@pytest.mark.parametrize("name", GOING_ON)
def test_what_goes_on_is_no_jump(name, integrator):
    """Steps lead past communication points as they do when inputs are held; results are the closed form at each."""
    force, speed = GOING_ON[name]
    instance, speeds = follow(integrator, force)
    assert_allclose(speeds, speed(0.01 * np.arange(1, 201)), rtol=1e-8, atol=1e-7)
    assert instance.d.steps[0] < 70
    assert instance.d.evaluations[0] < 400


@pytest.mark.parametrize("integrator", ["rk54", "rk853", "auto", "radau"])
@pytest.mark.parametrize("after", [0.0, -3.0, 3.1])
def test_a_ramp_that_bends_is_followed(integrator, after):
    """It bends at 1 s, without a jump; what was computed beyond is given up."""
    instance, speeds = follow(
        integrator, lambda t: [3.0 * t, 3.0] if t < 0.999 else [3.0 + after * (t - 1.0), after]
    )
    t = 0.01 * np.arange(1, 201)
    before = 1.5 * np.minimum(t, 1.0) ** 2
    later = np.maximum(t - 1.0, 0.0)
    assert_allclose(speeds, before + 3.0 * later + 0.5 * after * later**2, atol=1e-7)


def test_derivatives_that_are_not_given_again_end():
    """They last one step: the force is held where the ramp came to."""
    instance, speeds = follow("auto", lambda t: [3.0 * t, 3.0] if t < 0.005 else [], 20)
    later = 0.01 * np.arange(20)
    assert_allclose(speeds, 1.5e-4 + 0.03 * later, atol=1e-12)


def test_smooth_functions_are_not_taken_for_polynomials_that_go_on():
    """A sine's pieces differ by their higher derivatives: steps that lead past points would be lost again and again."""
    results = {
        name: cart(integrator="rk853", tolerance=1e-8).simulate(until=5, step=0.05, inputs={"j.force": law})
        for name, law in (("sine", np.sin), ("held", np.sin(np.linspace(0, 5, 101))))
    }
    costs = {name: result["solver.evaluations"][-1] for name, result in results.items()}
    assert costs["sine"] < 1.1 * costs["held"]
