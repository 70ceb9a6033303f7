"""A communication step always comes back: its work is bounded, whatever is asked of it, and the state it leaves is finite."""

from pathlib import Path

import numpy as np
import pytest
from test_closed_forms import bars
from test_integrate import instance_of

import mbdfmi
from mbdfmi import Scene, SceneError
from mbdfmi.compiler.model import compile_scene
from mbdfmi.run.instance import Instance, SimulationError

MODELS = Path(__file__).parent.parent / "models"
ALL = ["rk4", "ros2", "gauss", "rk54", "rk853", "radau", "auto"]
FIXED = ["rk4", "ros2", "gauss"]

# inputs, parameters and starts of models that were never done with a step of 10 ms (the list)
ABSURD = [
    ("four_bar", "crank_pivot.torque", 1e12),
    ("satellite", "satellite.moment[1]", 1e12),
    ("satellite", "satellite.moment[1]", 1e20),
    ("cam_follower", "guide.rest", 1e12),
    ("slider_crank", "main_bearing.speed_driven", 1e12),
    ("pendulum", "pivot.speed_start", 1e30),
    ("pendulum", "pendulum.mass", 1e-30),
    ("two_link_arm", "shoulder.torque", 1e30),
]


def solver_of(integrator, **more):
    return {"integrator": integrator} | ({"step": 1e-3} if integrator in FIXED else {}) | more


@pytest.mark.parametrize("integrator", ALL)
@pytest.mark.parametrize("H", [1e2, 1e15, 1e300])
@pytest.mark.parametrize("before", [0, 1])
def test_a_step_that_costs_too_much_stops_where_it_is(integrator, H, before):
    """Also in mid-run. The state is that of the time it tells, and goes on from there."""
    most = 300
    instance = instance_of(bars(2, solver=solver_of(integrator, max_evaluations=most)))

    for _ in range(before):
        instance.step(0.01)

    evaluations, time = instance.d.evaluations[0], instance.time

    with pytest.raises(SimulationError, match="solver.max_evaluations") as caught:
        instance.step(H)

    assert np.isfinite(instance.d.x).all()
    assert time <= caught.value.time == instance.time < time + 10.0
    assert 0.8 * most < instance.d.evaluations[0] - evaluations < most + 60 * instance.m.n_x

    # the law: energy is what it was at the time told
    energy = [total_energy(instance)]
    instance.step(0.01)
    energy.append(total_energy(instance))
    assert energy == pytest.approx([0.0, 0.0], abs=1e-3)


def total_energy(instance):
    """Of two bars of 1 m and 1 kg let go from horizontal, by their angles."""
    a, b, u, v = instance.d.x
    b, v = a + b, u + v
    kinetic = (4 * u * u + v * v + 3 * u * v * np.cos(a - b)) / 6
    return kinetic + 9.81 * (1.5 * np.sin(a) + 0.5 * np.sin(b))


@pytest.mark.parametrize("integrator", ALL)
def test_a_limit_that_is_not_reached_changes_nothing(integrator):
    x = []

    for most in (3000, 1e30):
        instance = instance_of(bars(2, solver=solver_of(integrator, max_evaluations=most)))

        for _ in range(3):
            instance.step(0.05)

        x.append(instance.d.x.copy())

    assert np.array_equal(x[0], x[1])


@pytest.mark.parametrize("name, variable, value", ABSURD)
def test_absurd_values_come_back_with_finite_numbers_or_a_reason(name, variable, value):
    model = compile_scene(mbdfmi.load(MODELS / f"{name}.toml"))
    inputs = {v.name: v.index for v in model.of_causality("input")}
    given = {variable: value} if variable not in inputs else {}

    try:
        instance = Instance(model, given | {"solver.max_evaluations": 200.0})

        if variable in inputs:
            instance.u[inputs[variable]] = value

        instance.step(0.01)
    except SimulationError as error:
        assert str(error)
    else:
        assert np.isfinite(instance.d.x).all()
        assert instance.d.evaluations[0] < 200 + 60 * instance.m.n_x


@pytest.mark.parametrize("name", [path.stem for path in sorted(MODELS.glob("*.toml"))])
def test_the_default_limit_leaves_room_and_is_a_matter_of_seconds(name):
    """An evaluation costs a fraction of a microsecond to some of them (docs/speed_against_error.md)."""
    model = compile_scene(mbdfmi.load(MODELS / f"{name}.toml"))
    limit = next(v for v in model.of_causality("parameter") if v.name == "solver.max_evaluations")
    assert 1e5 < limit.start < 2e7


@pytest.mark.long
@pytest.mark.parametrize("name, variable, value", ABSURD)
def test_the_default_limit_brings_absurd_steps_back_within_10_s(name, variable, value):
    from time import process_time

    model = compile_scene(mbdfmi.load(MODELS / f"{name}.toml"))
    inputs = {v.name: v.index for v in model.of_causality("input")}
    start = process_time()

    try:
        instance = Instance(model, {variable: value} if variable not in inputs else {})

        if variable in inputs:
            instance.u[inputs[variable]] = value

        instance.step(0.01)
    except SimulationError as error:
        assert str(error)

    assert process_time() - start < 10.0


@pytest.mark.parametrize("integrator", ALL)
@pytest.mark.parametrize("H", [-0.1, np.nan, -np.inf])
def test_a_step_backwards_is_refused(integrator, H):
    instance = instance_of(bars(2, solver=solver_of(integrator)))
    instance.step(0.01)
    x = instance.d.x.copy()

    with pytest.raises(SimulationError, match="the communication step is negative or no number"):
        instance.step(H)

    assert instance.time == 0.01
    assert np.array_equal(instance.d.x, x)


# tolerances


@pytest.mark.parametrize("key", ["tolerance", "absolute_tolerance"])
@pytest.mark.parametrize("value", [0.5, 1.0, 1e30, 9e-15, 1e-20])
def test_tolerances_beyond_reason_are_refused(key, value):
    scene = bars(1, solver={key: value})

    with pytest.raises(SceneError, match=rf"\[solver\] {key}: must be from 1e-14 to 0.1, found"):
        Scene.model_validate(scene)

    model = compile_scene(Scene.model_validate(bars(1, solver={"integrator": "rk54"})))

    with pytest.raises(SimulationError, match=f"solver.{key} must be from 1e-14 to 0.1"):
        Instance(model, {f"solver.{key}": value})


@pytest.mark.parametrize("key", ["tolerance", "absolute_tolerance"])
@pytest.mark.parametrize("value", [0.1, 1e-14])
def test_tolerances_within_reason_are_taken(key, value):
    instance = instance_of(bars(1, solver={"integrator": "rk54", key: value}))
    instance.step(1e-3)
    assert instance.time == 1e-3


def test_a_limit_below_one_evaluation_is_refused():
    model = compile_scene(Scene.model_validate(bars(1)))

    with pytest.raises(SimulationError, match="solver.max_evaluations must be at least 1"):
        Instance(model, {"solver.max_evaluations": 0.0})
