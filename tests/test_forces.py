"""Forces in joints and between markers, loads and central gravity, against closed forms."""

import numpy as np
import pytest
from scenes import assert_near, energies, evaluate, rows, velocities
from scipy.special import ellipk

from mbdfmi import Scene
from mbdfmi.compiler.model import compile_scene
from mbdfmi.kernels.forces import friction as dry_friction
from mbdfmi.kernels.forces import loads, struts
from mbdfmi.run.instance import Instance, SimulationError
from mbdfmi.run.simulate import simulate

TIGHT = {"tolerance": 1e-12}


def slider(force=None, *, mass=2.0, axis="x", gravity=(0, 0, 0), solver=TIGHT, **joint):
    """A block on a prismatic joint; `force` acts on it along the joint."""
    joint = {
        "prismatic": {"axis": axis},
        "between": ["ground", "block"],
        "output": ["position", "speed"],
    } | joint
    spec = {
        "name": "slider",
        "gravity": gravity,
        "solver": solver,
        "output": ["total_energy", "spring_energy"],
        "body": {"block": {"mass": mass, "inertia": [1, 1, 1]}},
        "joint": {"slide": joint},
    }

    if force:
        spec["force"] = {"push": {"load": {"force": [force, 0, 0]}, "on": "block"}}

    return compile_scene(Scene.model_validate(spec))


# tables


def test_two_points_make_a_linear_spring():
    m, k = 2.0, 50.0
    model = slider(
        spring={"table": {"position": [-1, 1], "effort": [-k, k]}}, start={"position": 2.5}, mass=m
    )
    run = simulate(model, 3.0, 0.1)
    assert_near(run["slide.position"], 2.5 * np.cos(np.sqrt(k / m) * run["time"]), 1e-9)


def test_cubic_spring_by_table_has_the_period_of_its_polynomial():
    """x'' = -x^3: the period is 4 K(m = 1/2) / amplitude."""
    x = np.linspace(-1.2, 1.2, 1201)
    table = {"position": x, "effort": 2 * x**3, "interpolation": "cubic"}

    # a spline is no smoother than a method of order 5 can use
    solver = TIGHT | {"integrator": "rk54"}
    model = slider(spring={"table": table}, start={"position": 1.0}, solver=solver)
    period = 4 * ellipk(0.5)
    run = simulate(model, period, period / 4)
    assert_near(run["slide.position"], [1, 0, -1, 0, 1], 2e-6)
    assert_near(run["total_energy"], run["total_energy"][0], 1e-8)


def test_damper_table_is_odd_where_its_points_are():
    """v' = -c v^2 / m by a table: v = v0 / (1 + c v0 t / m)."""
    v = np.linspace(0, 3, 601)
    table = {"speed": np.concatenate([-v[:0:-1], v]), "effort": np.concatenate([-(v[:0:-1] ** 2), v**2])}
    table["interpolation"] = "monotone"
    run = simulate(slider(damper={"table": table}, start={"speed": -3.0}), 4.0, 0.5)
    assert_near(run["slide.speed"], -3 / (1 + 3 * run["time"] / 2), 1e-6)


# friction


def test_stick_and_slip():
    """Below the static effort a block creeps, above it slides as under Coulomb's alone."""
    friction = {"coulomb": 4.0, "static": 6.0, "stribeck_speed": 0.05, "smoothing_speed": 1e-5}
    sticks = simulate(slider(5.9, friction=friction), 2.0, 0.01)
    assert np.abs(sticks["slide.speed"]).max() < 4e-5

    slips = simulate(slider(6.1, friction=friction), 2.0, 0.01)
    late = slips["time"] > 1.5
    acceleration = np.polyfit(slips["time"][late], slips["slide.speed"][late], 1)[0]
    assert_near(acceleration, (6.1 - 4.0) / 2.0, 1e-6)


@pytest.mark.parametrize("load", [0.1, 0.5, 0.9, 0.99])
def test_what_sticks_creeps_by_a_micrometre_a_second_at_most(load):
    """1e-6 m/s times load by capacity, at all times, by the default."""
    run = simulate(slider(6.0 * load, friction={"coulomb": 4.0, "static": 6.0}), 2.0, 0.02)
    assert np.abs(run["slide.speed"]).max() <= 1e-6 * load
    assert_near(run["slide.position"][-1], 3.7e-7 * np.arctanh(load) * 2.0, 1e-9)


def stick_slip(smoothing):
    """A block that a spring pulls over a belt: evaluations for 6 s."""
    friction = {"coulomb": 3.0, "static": 6.0} | smoothing
    slide = {"prismatic": {"axis": "x"}}
    block = {"mass": 1, "inertia": [0.01] * 3}
    scene = Scene(
        name="belt",
        gravity=[0, 0, 0],
        solver={"output": ["evaluations"]},
        body={"belt": block, "block": block},
        ground={"marker": {"far": {"position": [-1, 0, 0]}}},
        joint={
            "belt": slide | {"between": ["ground", "belt"], "driver": {"constant_speed": 0.2}},
            "rub": slide | {"between": ["belt", "block"], "friction": friction},
        },
        force={
            "spring": {
                "spring_damper": {"stiffness": 50, "rest_length": 1},
                "between": ["ground.far", "block"],
            }
        },
    )
    return simulate(compile_scene(scene), 6.0, 0.05)["solver.evaluations"][-1]


def turning_back(smoothing):
    """A block on a spring that comes to rest by friction: evaluations for 6 s."""
    solver = {"output": ["evaluations"]}
    friction = {"coulomb": 1.0} | smoothing
    model = slider(
        mass=1.0, spring={"stiffness": 100}, friction=friction, start={"position": 0.205}, solver=solver
    )
    return simulate(model, 6.0, 0.05)["solver.evaluations"][-1]


@pytest.mark.parametrize("evaluations", [stick_slip, turning_back])
def test_the_cost_of_sticking(evaluations, check):
    """Not much more than with a creep of millimetres a second."""
    check(evaluations({}) / evaluations({"smoothing_speed": 1e-3}), 1.8)


def test_coulomb_friction_takes_the_same_from_every_cycle():
    """Amplitude A - 4 F / k after a cycle, in the same time as without friction."""
    F, k, m, A = 1.0, 100.0, 1.0, 1.0
    friction = {"coulomb": F, "smoothing_speed": 1e-6}
    period = 2 * np.pi * np.sqrt(m / k)
    model = slider(mass=m, spring={"stiffness": k}, friction=friction, start={"position": A})
    run = simulate(model, 5 * period, period)
    assert_near(run["slide.position"], A - 4 * F / k * np.arange(6), 1e-6)


def test_stribeck_and_viscous_friction():
    """The effort at a speed, read off the acceleration."""
    friction = {"coulomb": 2.0, "static": 5.0, "stribeck_speed": 0.3, "viscous": 0.7, "smoothing_speed": 0.01}
    instance = Instance(slider(friction=friction))

    for v in (-2.0, -0.2, -0.004, 0.0, 0.004, 0.2, 2.0):
        velocities(instance)[0] = v
        expected = (2 + 3 * np.exp(-((v / 0.3) ** 2))) * np.tanh(v / 0.01) + 0.7 * v
        assert_near(evaluate(instance)[1], -expected / 2.0, 1e-15)


# stops


def test_a_ball_on_a_stop_keeps_its_energy():
    stop = {"lower": 0.0, "upper": 3.0, "stiffness": 1e4}
    model = slider(axis="z", gravity=(0, 0, -9.81), stop=stop, start={"position": 1.0})
    run = simulate(model, 5.0, 0.01)
    assert_near(run["total_energy"], run["total_energy"][0], 1e-8)
    assert run["slide.position"].min() > -0.1
    assert_near(run["slide.position"].max(), 1.0, 1e-6)

    # falls for t1, is in touch for as long as the spring takes, rises for t1
    g, w = 9.81, np.sqrt(1e4 / 2.0)
    t1 = np.sqrt(2 / g)
    touch = 2 * (np.pi - np.arctan(w * t1)) / w
    back = simulate(model, 2 * t1 + touch, (2 * t1 + touch) / 2)
    assert_near(back["slide.position"][-1], 1.0, 1e-9)


@pytest.mark.parametrize("side", [-1, 1])
def test_damped_stop_gives_back_what_its_restitution_says(side):
    """m x'' + c x' + k x = 0 until the force is zero: the stop does not pull."""
    m, k, zeta = 2.0, 800.0, 0.2
    w = np.sqrt(k / m)
    angle = np.pi - np.arctan(2 * zeta * np.sqrt(1 - zeta**2) / (1 - 2 * zeta**2))
    t = angle / (w * np.sqrt(1 - zeta**2))
    speed = np.exp(-zeta * w * t) * (np.cos(angle) - zeta / np.sqrt(1 - zeta**2) * np.sin(angle))
    stop = {"lower" if side < 0 else "upper": side * 0.5, "stiffness": k, "damping": 2 * zeta * w * m}
    run = simulate(slider(stop=stop, start={"speed": side * 2.0}), 1.0, 0.05)
    assert_near(run["slide.speed"][-1], side * 2.0 * speed, 1e-8)


# forces between markers, loads


def two_blocks(strut, **more):
    """Two blocks on the x axis, a strut between them."""
    joints = {
        name: {
            "prismatic": {"axis": "x"},
            "between": ["ground", name],
            "start": start,
            "output": ["acceleration"],
        }
        for name, start in (("a", {"position": -1.0, "speed": 0.3}), ("b", {"position": 0.5, "speed": -0.4}))
    }
    return compile_scene(
        Scene.model_validate(
            {
                "name": "two blocks",
                "gravity": [0, 0, 0],
                "body": {"a": {"mass": 2.0, "inertia": [0, 0, 0]}, "b": {"mass": 3.0, "inertia": [0, 0, 0]}},
                "joint": {f"slide {name}": joint for name, joint in joints.items()},
                "force": {"strut": {"spring_damper": strut, "between": ["a", "b"]} | more},
            }
        )
    )


def test_strut_by_table_with_actuator():
    strut = {
        "table": {"length": [1.0, 1.4, 2.0], "force": [-20.0, 1.0, 9.0]},
        "damping": {"table": {"speed": [-1.0, 0.0, 1.0], "force": [-3.0, 0.0, 8.0]}},
    }
    model = two_blocks(strut, input=["force"], output=["length", "rate"])
    instance = Instance(model)
    instance.u[0] = 7.5
    length, rate = 1.5, -0.7
    tension = np.interp(length, [1.0, 1.4, 2.0], [-20.0, 1.0, 9.0])
    tension += np.interp(rate, [-1.0, 0.0, 1.0], [-3.0, 0.0, 8.0]) + 7.5
    assert_near(instance.outputs(), [tension / 2, -tension / 3, length, rate], 1e-13)


def test_tension_feels_its_own_input_at_once():
    model = two_blocks({"stiffness": 3.0, "rest_length": 1.0}, output=["length", "force"])
    assert all(v.depends == () for v in model.of_causality("output") if v.name.startswith("strut"))
    assert_near(Instance(model).outputs()[-1], 1.5, 1e-15)


def floating(**load):
    """A free body, its load at its centre of mass."""
    return compile_scene(
        Scene.model_validate(
            {
                "name": "craft",
                "gravity": [0, 0, 0],
                "solver": TIGHT,
                "body": {
                    "craft": {
                        "mass": 2.0,
                        "inertia": [1, 2, 2.5],
                        "output": ["position", "velocity", "omega"],
                    }
                },
                "joint": {
                    "free": {"free": {}, "between": ["ground", "craft"], "start": {"omega": [0, 0, 0.8]}}
                },
                "force": {"thrust": {"load": load, "on": "craft"}},
            }
        )
    )


def test_thruster_that_follows_a_spinning_body():
    F, m, w = 3.0, 2.0, 0.8
    run = simulate(floating(force=[F, 0, 0], axes="body"), 10.0, 0.5)
    t, size = run["time"], F / (m * w * w)
    assert_near(run["craft.position[1]"], size * (1 - np.cos(w * t)), 1e-9)
    assert_near(run["craft.position[2]"], size * (w * t - np.sin(w * t)), 1e-9)


def test_constant_load_is_a_parameter():
    run = simulate(floating(force=[0, 4, 0], moment=[0, 0, 5]), 2.0, 1.0, parameters={"thrust.force[2]": 6.0})
    assert_near(run["craft.position[2]"][-1], 0.5 * 3.0 * 4.0, 1e-12)
    assert_near(run["craft.omega[3]"][-1], 0.8 + 5.0 / 2.5 * 2.0, 1e-12)


def test_load_over_time():
    """A ramp from 1 s to 2 s, held beyond its ends, also where the master's steps do not meet its corners."""
    table = {"time": [1, 2], "force": [[1, 0, 0], [7, 0, 0]], "moment": [[0, 0, 0], [0, 0, 5]]}
    run = simulate(floating(table=table), 3.0, 0.3)
    assert_near(run["craft.velocity[1]"][-1], (1 + 4 + 7) / 2.0, 1e-9)
    assert_near(run["craft.omega[3]"][-1], 0.8 + (2.5 + 5) / 2.5, 1e-9)


def test_load_over_time_counts_from_time_zero():
    table = {"time": [1, 2], "force": [[0, 0, 0], [6, 0, 0]]}
    run = simulate(floating(table=table), 2.0, 0.1, start_time=1.5)
    assert_near(run["craft.velocity[1]"][-1], (3 + 6) / 2 * 0.5 / 2.0, 1e-9)


# central gravity


def test_kepler_orbit():
    """Eccentricity 0.6 about mu = 1: after 2 pi back at the start; energy -m mu / 2a, momentum m sqrt(mu a (1 - e^2))."""
    e, m = 0.6, 3.0
    scene = Scene.model_validate(
        {
            "name": "orbit",
            "central_gravity": {"mu": 1.0},
            "solver": {"integrator": "rk853", "tolerance": 1e-13},
            "output": ["total_energy", "angular_momentum"],
            "body": {
                "moon": {"mass": m, "inertia": [0.1, 0.1, 0.1], "com": [0.1, 0, 0], "output": ["position"]}
            },
            "joint": {
                "free": {
                    "free": {},
                    "between": ["ground", "moon"],
                    "start": {
                        "position": [1 - e - 0.1, 0, 0],
                        "velocity": [0, np.sqrt((1 + e) / (1 - e)), 0],
                    },
                }
            },
        }
    )
    run = simulate(compile_scene(scene), 2 * np.pi, np.pi / 50)
    x, y = run["moon.position[1]"] + 0.1, run["moon.position[2]"]
    assert_near([x[-1], y[-1]], [1 - e, 0], 1e-10)
    assert_near((x + e) ** 2 + y**2 / (1 - e * e), 1.0, 1e-10)
    assert_near(run["total_energy"], -m / 2, 1e-11)
    assert_near(run["angular_momentum[3]"], m * np.sqrt(1 - e * e), 1e-11)


# energy


def test_energy_goes_where_dampers_and_friction_take_it():
    """A double pendulum with everything in it: d(energy)/dt is the power of what dissipates and of what drives."""
    rng = np.random.default_rng(2)
    x = np.linspace(-2, 2, 9)
    law = {"table": {"position": x, "effort": np.sinh(x)}}
    drag = {"table": {"speed": x, "effort": x**3 + x}}
    friction = {"coulomb": 0.4, "static": 0.7, "viscous": 0.1, "smoothing_speed": 0.05}
    stop = {"lower": -0.2, "upper": 0.3, "stiffness": 40.0}
    scene = Scene.model_validate(
        {
            "name": "all",
            "output": ["total_energy"],
            "solver": TIGHT,
            "body": {
                name: {
                    "mass": 1.0,
                    "com": [0, 0, -0.4],
                    "inertia": [0.1, 0.1, 0.1],
                    "marker": {"m": {"position": [0, 0, -0.8]}},
                }
                for name in ("a", "b")
            },
            "joint": {
                "j1": {
                    "revolute": {"axis": "y"},
                    "between": ["ground", "a"],
                    "spring": law,
                    "damper": drag,
                    "stop": stop,
                },
                "j2": {
                    "revolute": {"axis": "x"},
                    "between": ["a.m", "b"],
                    "friction": friction,
                    "spring": law,
                },
            },
            "force": {
                "strut": {
                    "spring_damper": {"table": {"length": [0.2, 1, 2], "force": [-2, 0, 5]}, "damping": 0.3},
                    "between": ["ground", "b.m"],
                },
                "load": {"load": {"force": [1, 2, 3], "moment": [3, 2, 1], "axes": "body"}, "on": "b.m"},
            },
        }
    )
    instance = Instance(compile_scene(scene))
    m, d = instance.m, instance.d

    for _ in range(20):
        q, v = rng.uniform(-1, 1, (2, 2))
        start = np.concatenate([q, v])
        d.x[:] = start
        slope = evaluate(instance)
        _, stretch, direction, tension = struts.pull(m, d, 0)
        moment, force = loads.wrench(m, d, 0)
        w, rd = rows(d.w, 3)[2], rows(d.rd, 3)[2]
        arm = rows(d.A, 3, 3)[2] @ rows(m.marker_r, 3)[m.load_marker[0]]
        rate = np.dot(force, rd + np.cross(w, arm)) + np.dot(moment, w)
        rate -= (
            np.interp(v[0], x, x**3 + x) * v[0]
            + dry_friction.resistance(m, 0, v[1]) * v[1]
            + 0.3 * stretch**2
        )

        # the energy's slope along x'
        h = 1e-3
        energy = []

        for k in (-2, -1, 1, 2):
            d.x[:] = start + k * h * slope
            energy.append(sum(energies(instance)))

        assert_near(np.dot([1, -8, 8, -1], energy) / (12 * h), rate, 1e-8)


@pytest.mark.parametrize("tolerance", [1e-3, 1e-4, 1e-6])
def test_what_sticks_stays(tolerance):
    """Half the friction moves nothing but by creeping, and the stages of an implicit step do not slip by extrapolation."""
    instance = block_with_friction("radau", tolerance)
    instance.u[0] = 0.5

    for _ in range(8):
        instance.step(0.04)
        assert 0 <= instance.outputs()[0] < 1e-6


@pytest.mark.parametrize("before, after", [(0.0, 1.5), (0.5, 1.5), (0.9, 1.3), (-0.5, 1.5), (0.98, 1.02)])
@pytest.mark.parametrize("tolerance", [1e-2, 1e-3, 1e-4, 1e-5, 1e-6, 1e-8])
def test_what_slips_goes_at_once_and_comes_to_rest(tolerance, before, after):
    """More than the friction gives the rest over the mass from the jump on; with no force it stops after as long as it takes.

    A Jacobian of what sticks lets the stages creep a little in each iteration: small changes must not pass for convergence.
    """
    instance = block_with_friction("radau", tolerance)
    forces = [before] * 3 + [after] * 5 + [0.0] * 15
    speeds = []

    for force in forces:
        instance.u[0] = force
        instance.step(0.04)
        speeds.append(float(instance.outputs()[0]))

    gained = 0.04 * (after - 1.0) * np.arange(1, 6)
    left = np.maximum(0.0, gained[-1] - 0.04 * np.arange(1, 16))
    creeping = 5e-7 + 3.7e-7 * np.arctanh(abs(before))
    assert_near(speeds[2:8], [speeds[2], *gained], tolerance + creeping)
    assert_near(speeds[8:], left, 2 * tolerance + creeping)
    assert instance.d.evaluations[0] < 1500


def block_with_friction(integrator, tolerance):
    """1 kg that slides with a friction of 1 N under a force that is input, and tells its speed."""
    slide = {
        "prismatic": {},
        "between": ["ground", "b"],
        "friction": {"coulomb": 1.0},
        "input": "force",
        "output": ["speed"],
    }
    scene = Scene(
        name="block",
        gravity=[0, 0, 0],
        solver={"integrator": integrator, "tolerance": tolerance, "absolute_tolerance": tolerance},
        body={"b": {"mass": 1.0, "inertia": [0, 0, 0]}},
        joint={"slide": slide},
    )
    return Instance(compile_scene(scene))


# constants that no scene may have


@pytest.mark.parametrize(
    "parameter, value",
    [
        ("slide.stiffness", -1.0), ("slide.damper", -1.0), ("slide.stop.stiffness", -1.0),
        ("slide.stop.damping", -1.0), ("slide.friction.coulomb", -1.0), ("slide.friction.smoothing_speed", 0.0),
        ("strut.stiffness", -1.0), ("strut.damping", -1.0), ("twist.stiffness", -1.0), ("twist.damping", -1.0),
    ],
)  # fmt: skip
def test_a_parameter_that_a_scene_would_refuse_is_told(parameter, value):
    scene = Scene(
        name="block",
        body={"block": {"mass": 1.0, "inertia": [1, 1, 1]}},
        joint={
            "slide": {
                "prismatic": {}, "between": ["ground", "block"], "spring": {"stiffness": 2.0}, "damper": 1.0,
                "stop": {"upper": 1.0, "stiffness": 10.0, "damping": 1.0}, "friction": {"coulomb": 1.0},
            },
        },
        force={
            "strut": {
                "spring_damper": {"stiffness": 1.0, "damping": 1.0, "rest_length": 1.0},
                "between": ["inertial", "block"],
            },
            "twist": {"torsion": {"stiffness": 1.0, "damping": 1.0}, "between": ["ground", "block"]},
        },
    )  # fmt: skip
    model = compile_scene(scene)

    with pytest.raises(SimulationError, match="acts on block has a constant that is negative or no number"):
        Instance(model, parameters={parameter: value})
