"""Tables: what stands between their points and beyond them, by closed forms, scipy's splines and the laws of each reading."""

import itertools

import numpy as np
import pytest
from hypothesis import example, given, settings
from hypothesis import strategies as st
from scenes import assert_near, evaluate
from scipy.integrate import quad
from scipy.interpolate import CubicSpline, PchipInterpolator, make_interp_spline

import mbdfmi
from mbdfmi.compiler.interpolation import curve
from mbdfmi.compiler.model import compile_scene
from mbdfmi.kernels import exchange, forces
from mbdfmi.kernels.math import tables
from mbdfmi.run.instance import Instance

INERTIA = [0.01] * 3
READINGS = {
    "linear": lambda x, y: make_interp_spline(x, y, 1),
    "monotone": PchipInterpolator,
    "cubic": CubicSpline,
}


def block(solver=None, **joint):
    """A block of 1 kg on a slide."""
    slide = {
        "prismatic": {},
        "between": ["ground", "block"],
        "output": ["position", "speed", "acceleration"],
    } | joint
    return mbdfmi.Scene(
        name="block",
        gravity=[0, 0, 0],
        solver=solver or {},
        body={"block": {"mass": 1, "inertia": INERTIA}},
        joint={"slide": slide},
    )


def drive(time, position, **table):
    """A block that is driven by a table."""
    return block(driver={"table": {"time": time, "position": position} | table})


def pieces(p, points=101):
    """Values of a curve within each of its pieces (n - 1, points), both ends included, each by its own polynomial."""
    s = np.linspace(0, 1, points)
    h = np.diff(p.x)[:, None] * s
    return sum(c[:, None] * h**k for k, c in enumerate(p.c[::-1]))


# springs, dampers, loads


@pytest.mark.parametrize("interpolation", READINGS)
def test_a_spring_is_read_as_it_says_and_goes_on_straight(interpolation):
    """Its energy is the integral of that."""
    x, y = np.array([-1.0, -0.2, 0.1, 0.5, 2.0]), np.array([-3.0, -1.0, 0.5, 0.5, 4.0])
    table = {"position": x, "effort": y, "interpolation": interpolation}
    instance = Instance(compile_scene(block(spring={"table": table})))
    law = READINGS[interpolation](x, y)
    ends = law.derivative()(x[[0, -1]])

    def expected(at):
        if at < x[0] or at > x[-1]:
            k = 0 if at < x[0] else -1
            return y[k] + ends[k] * (at - x[k])

        return law(at)

    slack = instance.m.joint_rest[0]
    assert_near(law(slack), 0.0, 1e-15)

    for at in np.linspace(-2, 3, 31):
        assert_near(tables.evaluate(instance.m, 0, at)[0], expected(at), 1e-14)
        instance.d.x[0] = at
        energy = quad(
            expected, slack, at, points=[p for p in x if min(slack, at) < p < max(slack, at)] or None
        )[0]
        assert_near(forces.stored_energy(instance.m, instance.d), energy, 1e-13)


tables_of_numbers = st.lists(st.tuples(st.floats(0.01, 10), st.floats(-100, 100)), min_size=2, max_size=8)


@settings(max_examples=25, deadline=None)
@given(tables_of_numbers, st.floats(-5, 60))
def test_forces_lie_on_straight_lines_unless_told_otherwise(points, at):
    """Of springs, dampers and struts: between the points, and on the outer lines beyond them."""
    x, y = np.cumsum([h for h, _ in points]), np.array([y for _, y in points])
    k = np.clip(np.searchsorted(x, at) - 1, 0, len(x) - 2)
    expected = y[k] + (y[k + 1] - y[k]) / (x[k + 1] - x[k]) * (at - x[k])
    strut = {
        "spring_damper": {"stiffness": 0, "damping": {"table": {"speed": x, "force": y}}},
        "between": ["ground.far", "block"],
    }
    spring = block(spring={"table": {"position": x, "effort": y}}, start={"position": at})
    damper = block(damper={"table": {"speed": x, "effort": y}}, start={"speed": at})
    pull = damper.model_dump(exclude_unset=True) | {"force": {"strut": strut}}
    pull["joint"]["slide"] |= {"damper": 0.0}
    pull["ground"] = {"marker": {"far": {"position": [0, 0, -1e3]}}}

    for scene in (spring, damper, mbdfmi.Scene.model_validate(pull)):
        assert_near(evaluate(Instance(compile_scene(scene)))[-1], -expected, 1e-9 * (1 + np.abs(y).max()))


def test_a_spring_of_straight_lines_keeps_its_energy():
    x, y = [-1, -0.1, 0.1, 0.4, 1], [-20, -1, 1, 1, 30]
    scene = block(
        {"tolerance": 1e-10}, spring={"table": {"position": x, "effort": y}}, start={"position": 0.9}
    )
    energy = mbdfmi.Scene.model_validate(scene.model_dump(exclude_unset=True) | {"output": ["total_energy"]})
    run = energy.simulate(until=10, step=0.1)["total_energy"]
    assert_near(run, run[0], 5e-6)


@pytest.mark.parametrize("interpolation", ["linear", "steps", "monotone", "cubic"])
def test_a_load_is_read_as_it_says_and_keeps_its_end_values(interpolation):
    t, f = np.array([0.5, 1.0, 2.0, 2.5]), np.array([1.0, 3.0, -2.0, 4.0])
    load = {"table": {"time": t, "force": np.outer(f, [0, 0, 1]), "interpolation": interpolation}}
    scene = mbdfmi.Scene.model_validate(
        block({"tolerance": 1e-10}).model_dump(exclude_unset=True)
        | {"force": {"push": {"load": load, "on": "block"}}}
    )
    run = scene.simulate(until=3, step=0.25)
    now = np.clip(run["time"], t[0], t[-1])
    law = READINGS.get(interpolation, lambda x, y: lambda at: y[np.searchsorted(x, at, side="right") - 1])(
        t, f
    )
    assert_near(run["slide.acceleration"], law(now), 1e-12)


# motions


def test_a_sampled_sine_is_driven_as_the_sine_itself(check):
    """0.1 m at 10 rad/s by 3,001 points: position, speed and acceleration, and the evaluations that a motion on it takes."""
    t = np.linspace(0, 10, 3001)

    for phase in (0.0, 0.7, 1.6):
        p = curve("smooth", t, 0.1 * np.sin(10 * t + phase))
        fine = np.linspace(0, 10, 50_001)
        check(np.abs(p(fine) - 0.1 * np.sin(10 * fine + phase)).max(), 1e-12)
        check(np.abs(p(fine, 1) - np.cos(10 * fine + phase)).max(), 1e-9)
        check(np.abs(p(fine, 2) + 10 * np.sin(10 * fine + phase)).max() / 10, 1e-7)


def pendulum_on_a_slide(driver):
    return mbdfmi.Scene(
        name="swing",
        solver={"tolerance": 1e-11, "output": ["evaluations"]},
        body={
            "cart": {"mass": 1, "inertia": INERTIA},
            "bob": {"mass": 1, "com": [0, 0, -0.5], "inertia": [0.1, 0.1, 0.01]},
        },
        joint={
            "slide": {
                "prismatic": {"axis": "x"},
                "between": ["ground", "cart"],
                "driver": driver,
                "output": ["position", "acceleration"],
            },
            "hinge": {"revolute": {"axis": "y"}, "between": ["cart", "bob"], "output": ["angle"]},
        },
    )


def test_steppers_cross_the_points_of_a_sampled_sine(check):
    """The evaluations are not many more than those of the exact drive; of cubic pieces they were 180 times as many."""
    t = np.linspace(0, 10, 3001)
    exact = pendulum_on_a_slide({"harmonic": {"amplitude": 0.1, "frequency": 5 / np.pi}}).simulate(
        until=10, step=0.5
    )
    table = {"time": t, "position": 0.1 * np.sin(10 * t)}
    found = pendulum_on_a_slide({"table": table}).simulate(until=10, step=0.5)
    check(np.abs(found["slide.position"] - exact["slide.position"]).max(), 1e-12)
    check(np.abs(found["slide.acceleration"] - exact["slide.acceleration"]).max() / 10, 1e-7)
    check(np.abs(found["hinge.angle"] - exact["hinge.angle"]).max(), 1e-7)
    check(found["solver.evaluations"][-1] / exact["solver.evaluations"][-1], 3)


@pytest.mark.parametrize(
    "time, position",
    [
        ([0, 1, 2, 3], [0, 0, 1, 1]),
        ([0, 2, 3, 10], [-5, -5, -15, -15]),
        ([0, 1, 2], [0, 0, 1]),
        ([0, 1, 2, 3], [0, 0.9, 1, 1]),
        ([0, 1, 2, 3, 4, 5], [0, 1, 2, 3, 3, 3]),
        ([0, 1, 1.01, 3, 4], [0, 0, 1, 1, 0]),
        ([0, 1, 2, 3], [-5, -5.0001, -15, -15]),
    ],
)
def test_a_driven_joint_stays_between_the_points_where_it_is_told_to_stand(time, position):
    run = drive(time, position).simulate(until=time[-1] + 1, step=0.01)
    x = run["slide.position"]
    assert min(position) - 1e-9 < x.min() and x.max() < max(position) + 1e-9

    for (a, b), (c, d) in zip(itertools.pairwise(time), itertools.pairwise(position)):
        within = (run["time"] > a + 1e-9) & (run["time"] < b - 1e-9)

        if c == d:
            assert np.all(x[within] == c)
            assert np.all(run["slide.speed"][within] == 0) and np.all(run["slide.acceleration"][within] == 0)

    beyond = run["time"] > time[-1] + 1e-9
    assert np.all(x[beyond] == position[-1]) and np.all(run["slide.speed"][beyond] == 0)


values = st.one_of(st.sampled_from([0.0, 1.0, -1.0, 2.0]), st.floats(-1, 1), st.floats(-1e6, 1e6))
spacings = st.one_of(st.just(1.0), st.floats(1e-3, 1e3))


@settings(max_examples=200, deadline=None)
@given(st.lists(st.tuples(spacings, values), min_size=2, max_size=24))
@example([(1.0, y) for y in (0, 0, 0, 0, 1, 1, 1, 1, 1, 1)])
@example([(1.0, y) for y in (0, 0, 0, 1, 0, 0, 0)])
@example([(1.0, y) for y in (0, 1, 0, 1, 0, 1, 0, 1, 0)])
@example([(1.0, y) for y in (0, 1, 1.0001, 0)])
@example([(1.0, y) for y in (0, 0, 1, 1.0001, 0, 0)])
@example([(1e-3, 0), (1e3, 1), (1e-3, 2), (1e3, 0), (1.0, 0)])
def test_smooth_curves_of_rough_tables(points):
    """They go through the points, have two continuous derivatives, stand still between equal values, and leave the values around
    by at most 3/16 of the second difference there."""
    x, y = np.cumsum([h for h, _ in points]), np.array([float(y) for _, y in points])
    p = curve("smooth", x, y)
    h, inside, size = np.diff(x), pieces(p), np.abs(y).max()
    assert_near(inside[:, 0], y[:-1])
    assert_near(inside[:, -1], y[1:], 1e-11 * size + 1e-300)

    for order in (1, 2):
        q = p.derivative(order)
        terms = np.abs(q.c) * h ** np.arange(len(q.c))[::-1, None]
        assert np.all(np.abs(pieces(q, 2)[:-1, -1] - q.c[-1, 1:]) <= 1e-8 * terms.sum(axis=0)[:-1] + 1e-300)

    if len(x) < 12:
        still = y[1:] == y[:-1]
        assert np.all(inside[still] == y[:-1][still, None])

    if len(x) < 4:
        bow = np.zeros(len(h))
    else:
        slopes = np.diff(y) / h
        second = 2 * np.abs(np.diff(slopes) / (h[1:] + h[:-1]))
        second = np.concatenate([second[:1], np.minimum(second[1:], second[:-1]), second[-1:]])
        bow = 3 / 16 * h**2 * second

    lowest, highest = np.minimum(y[1:], y[:-1]), np.maximum(y[1:], y[:-1])
    leaves = np.maximum(lowest - inside.min(axis=1), inside.max(axis=1) - highest)
    assert np.all(leaves <= bow + 1e-10 * size + 1e-300)


@pytest.mark.parametrize("points_a_period", [20, 30, 100])
def test_equal_samples_on_both_sides_of_a_peak_do_not_stand_still(points_a_period):
    """A sine sampled symmetrically about its peaks."""
    w = 2 * np.pi
    t = (np.arange(3 * points_a_period) + 0.5) / points_a_period
    y = np.sin(w * t + np.pi / 2)
    middle = points_a_period // 2
    y[middle] = y[middle - 1]
    p = curve("smooth", t, y)
    fine = np.linspace(t[5], t[-6], 5001)
    assert_near(p(fine), np.cos(w * fine), 8 / points_a_period**6)
    assert_near(p(fine, 2), -w * w * np.cos(w * fine), 600 / points_a_period**4)


def test_splines_of_motions_are_those_of_scipy():
    """Cubic by itself; quintic inside, where the conditions at its ends no longer matter."""
    rng = np.random.default_rng(1)
    x, y = np.cumsum(rng.uniform(0.5, 2, 80)), rng.normal(size=80)
    fine = np.linspace(x[30], x[50], 501)
    assert_near(curve("cubic", x, y)(fine), CubicSpline(x, y)(fine), 1e-13)
    assert_near(curve("quintic", x, y)(fine), make_interp_spline(x, y, 5)(fine), 1e-8)

    for n in range(2, 7):
        polynomial = np.polynomial.Polynomial.fit(x[:n], y[:n], n - 1)
        fine = np.linspace(x[0], x[n - 1], 101)
        assert_near(curve("quintic", x[:n], y[:n])(fine), polynomial(fine), 1e-10)


def test_a_ground_by_table_stands_and_turns_as_it_is_told():
    """It stands, turns by 90 degrees about z while it moves, and stands again; a body fixed to it is there."""
    table = {
        "time": [0, 1, 2, 3],
        "position": [[0, 0, 0]] * 2 + [[2, 0, 0]] * 2,
        "zyx_deg": [[0, 0, 0]] * 2 + [[90, 0, 0]] * 2,
    }
    scene = mbdfmi.Scene(
        name="table",
        gravity=[0, 0, 0],
        ground={"motion": {"table": table}},
        body={"b": {"mass": 1, "inertia": INERTIA, "output": ["position", "zyx", "omega"]}},
        joint={"j": {"fixed": {}, "between": ["ground", "b"]}},
    )
    run = scene.simulate(until=4, step=0.05)
    t, x, yaw = run["time"], run["b.position"][:, 0], run["b.zyx"][:, 0]
    assert np.all(x[t < 1] == 0) and np.all(x[t > 2] == 2) and np.all(run["b.omega"][(t < 1) | (t > 2)] == 0)
    assert np.all(np.diff(x) >= 0) and np.all(np.diff(yaw) >= -1e-15)
    assert_near(yaw[t > 2], np.pi / 2, 1e-15)
    assert_near(x[np.isclose(t, 1.5)], 1.0, 1e-14)
    assert_near(yaw[np.isclose(t, 1.5)], np.pi / 4, 1e-14)


# what is written


@pytest.mark.parametrize(
    "joint, wrong, meant, known",
    [
        (
            {"spring": {"table": {"position": [0, 1], "effort": [0, 1]}}},
            "liner",
            "linear",
            ["monotone", "cubic"],
        ),
        (
            {"damper": {"table": {"speed": [0, 1], "effort": [0, 1]}}},
            "monoton",
            "monotone",
            ["linear", "cubic"],
        ),
        (
            {"driver": {"table": {"time": [0, 1], "position": [0, 1]}}},
            "smoth",
            "smooth",
            ["quintic", "cubic", "linear"],
        ),
    ],
)
def test_unknown_readings_are_refused(joint, wrong, meant, known):
    key, part = next(iter(joint.items()))
    part["table"]["interpolation"] = wrong

    with pytest.raises(mbdfmi.SceneError) as caught:
        block(**joint)

    text = str(caught.value)
    assert f'{key}.table.interpolation: no "{wrong}" here' in text and f'Did you mean "{meant}"?' in text
    assert all(f'"{name}"' in text for name in known)


# where they have kinks


@pytest.mark.parametrize(
    "interpolation, force, kinks",
    [
        ("linear", [1, 3, 4, 2], [0, 1, 3, 5]),
        ("linear", [1, 1, 2, 2], [1, 3]),
        ("linear", [1, 2, 4, 6], [0, 5]),
        ("steps", [1, 3, 3, 2], [1, 5]),
        ("cubic", [1, 3, 4, 2], [0, 5]),
    ],
)
def test_where_tables_have_kinks(interpolation, force, kinks):
    """A load is held before its first point and after its last: there its slope jumps, unless it was level."""
    table = {"time": [0, 1, 3, 5], "force": [[x, 0, 0] for x in force], "interpolation": interpolation}
    scene = mbdfmi.Scene(
        name="pushed",
        body={"block": {"mass": 1, "inertia": INERTIA}},
        joint={"slide": {"prismatic": {}, "between": ["ground", "block"]}},
        force={"f": {"load": {"table": table}, "on": "block"}},
    )
    m, d = compile_scene(scene).views()
    d.time[0], found = -1.0, []

    while (kink := exchange.next_kink(m, d)) < np.inf:
        found.append(kink)
        d.time[0] = kink

    assert found == kinks
