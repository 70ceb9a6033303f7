"""Motion commanded by inputs: of joints and of the ground, at the communication points a master would choose."""

import numpy as np
import pytest
from numpy.testing import assert_allclose
from scipy.spatial.transform import Rotation

import mbdfmi
from mbdfmi.kernels.language import INTERPRETED
from mbdfmi.run.instance import Instance
from mbdfmi.scene import SceneError

POINT = {"mass": 1.0, "inertia": [0, 0, 0]}


class Run:
    """A scene driven as a master drives its FMU: inputs by name before, outputs after each step."""

    def __init__(self, scene, **first):
        model = scene.compile()
        self.input = {v.name: v.index for v in model.of_causality("input")}
        self.n_u = model.n_u
        self.instance = Instance(model, inputs={self.input[name]: value for name, value in first.items()})
        self.names = [v.name for v in model.of_causality("output")]

    def set(self, values, order=0):
        """Inputs, or their derivatives of some order; arrays by the name without index."""
        for name, value in values.items():
            if np.ndim(value):
                self.set({f"{name}[{k}]": x for k, x in enumerate(value, 1)}, order)
            else:
                self.instance.u[order * self.n_u + self.input[name]] = value

    def step(self, H):
        self.instance.step(H)

    def get(self, name):
        values = dict(zip(self.names, self.instance.outputs()))
        return values[name] if name in values else np.array([values[f"{name}[{k}]"] for k in (1, 2, 3)])


def slider(told, **more):
    """A slider whose motion along x is commanded."""
    return mbdfmi.Scene(
        name="slider",
        gravity=[0, 0, 0],
        body={"a": POINT},
        joint={
            "j": {
                "prismatic": {"axis": "x"},
                "between": ["ground", "a"],
                "driver": {"input": told},
                "output": ["position", "speed", "acceleration", "effort"],
            }
        },
        **more,
    )


def moving_ground(told, velocity=(0, 0, 0)):
    """A particle free to go anywhere, seen from the inertial frame, on a ground that inputs move."""
    return mbdfmi.Scene(
        name="ground",
        gravity=[0, 0, 0],
        ground={"motion": {"input": told}},
        body={"p": POINT | {"output": ["position"]}},
        joint={"t": {"translation": {}, "between": ["ground", "p"], "start": {"velocity": velocity}}},
    )


def swing(t, amplitude=1.0, w=2.0, phase=0.3):
    """Position, speed and acceleration of a sine."""
    return amplitude * np.array(
        [np.sin(w * t + phase), w * np.cos(w * t + phase), -w * w * np.sin(w * t + phase)]
    )


NAMES = ("position", "speed", "acceleration")
COMMANDS = [f"j.{name}_command" for name in NAMES]


# what is told goes in once


@pytest.mark.parametrize("powers", [[0, 0, 1.0], [0.3, -1, 0.5, 2.0]])
@pytest.mark.parametrize("told", [1, 2, 3])
@pytest.mark.parametrize("orders", [0, 1, 2])
def test_polynomials_with_derivatives_of_all_inputs(powers, told, orders):
    """A cubic is met exactly where the commands and their derivatives tell it wholly; nothing is counted twice."""
    law = [np.polynomial.Polynomial(powers).deriv(k) for k in range(6)]
    run = Run(slider(list(NAMES[:told])))
    degree = len(powers) - 1

    for k in range(10):
        t = 0.1 * k

        for order in range(orders + 1):
            run.set({COMMANDS[i]: law[i + order](t) for i in range(told)}, order)

        run.step(0.1)

        if (orders == 0 and k > degree) or told - 1 + orders >= degree:
            found = [run.get(f"j.{name}") for name in NAMES[:2]]
            assert_allclose(found, [law[i](t + 0.1) for i in range(2)], rtol=1e-9, atol=1e-9)


@pytest.mark.parametrize("orders", [0, 1])
@pytest.mark.parametrize("told", [1, 2, 3])
def test_steps_as_short_as_rounding_spoil_nothing(told, orders):
    """Masters make tiny steps at events: the differences of commands over them are rounding, and tell no curvature of the steps
    after. What is off then is that of a course not known to be curved: x'' H^2 / 2 of the one step, led back in the next."""
    law = [np.polynomial.Polynomial([0.3, 0.7, 0.5, 1 / 6]).deriv(k) for k in range(4)]
    run = Run(slider(list(NAMES[:told])))
    t = 0.0

    for H in (0.1, 0.1, 0.1, 1e-6, 1e-6, 0.1, 1e-8, 1e-8, 0.1, 1e-9, 1e-9, 1e-9, 0.1, 0.1, 0.1, 0.1):
        for order in range(orders + 1):
            run.set({COMMANDS[i]: law[i + order](t) for i in range(told)}, order)

        run.step(H)
        t += H
        off = [run.get(f"j.{name}") - law[i](t) for i, name in enumerate(NAMES[:2])]
        assert np.max(np.abs(off)) < (1.0, 0.2, 0.02, 1e-9)[told - 1 + orders], (H, off)


@pytest.mark.parametrize("told", [1, 2, 3])
def test_outputs_are_those_of_the_new_commands(told):
    run = Run(slider(list(NAMES[:told])))

    for k in range(12):
        values = swing(0.05 * k)
        run.set(dict(zip(COMMANDS[:told], values)))
        found = np.array([run.get(f"j.{name}") for name in NAMES])
        assert np.array_equal(found[:told], values[:told])

        # the rest is found: of order 2 or better
        if k > 5:
            assert_allclose(found, values, atol=0.05)

        run.step(0.05)


# order


@pytest.mark.parametrize(
    "told, order, allowed",
    [
        (True, 2.8, 2e-3),
        (["position", "velocity"], 2.8, 4e-3),
        (["position", "speed"], 2.8, 4e-3),
        (["position"], 1.9, 0.06),
    ],
)
def test_a_free_particle_stays_where_it_is(told, order, allowed):
    """Over a ground that swings by 1 m, with equal and with unequal steps."""
    for uneven in (0.0, 0.6):
        worst = []

        for H in (0.1, 0.05):
            run = Run(moving_ground(told, velocity=[-swing(0.0, phase=0.0)[1], 0, 0]))
            t, far = 0.0, 0.0

            for k in range(round(4 / H)):
                h = H * (1 + uneven * np.sin(5.0 * k))

                for end in (False, True):
                    p, v, a = swing(t, phase=0.0)
                    commands = {"ground.position[1]": p, "ground.velocity[1]": v, "ground.acceleration[1]": a}
                    run.set({name: value for name, value in commands.items() if name in run.input})

                    if not end:
                        run.step(h)
                        t += h

                far = max(far, abs(run.get("p.position")[0]))

            worst.append(far)

        assert worst[0] < allowed * (1 + uneven) ** 3
        assert np.log2(worst[0] / worst[1]) > (order if not uneven else order - 0.6)
        assert not run.instance.notices


def tumbling(t):
    """A turn about a changing axis: ZYX angles, then Euler parameters, w, w' by differences of high order."""
    return np.array([0.7 * np.sin(1.3 * t) + 0.5 * t, 0.4 * np.sin(0.9 * t + 1), 0.5 * np.cos(1.7 * t)])


def turn(t):
    """(E, w, w', angles) of `tumbling`, from the angles' rates by the chain rule."""
    angles = tumbling(t)
    rate = np.array([0.91 * np.cos(1.3 * t) + 0.5, 0.36 * np.cos(0.9 * t + 1), -0.85 * np.sin(1.7 * t)])
    second = np.array([-1.183 * np.sin(1.3 * t), -0.324 * np.sin(0.9 * t + 1), -1.445 * np.cos(1.7 * t)])

    def axes(angles):
        yaw, pitch = Rotation.from_euler("z", angles[0]), Rotation.from_euler("y", angles[1])
        return np.array([[0, 0, 1], yaw.apply([0, 1, 0]), (yaw * pitch).apply([1, 0, 0])])

    K = axes(angles)
    w = rate @ K
    K_rate = np.array([[0, 0, 0], np.cross(rate[0] * K[0], K[1]), np.cross(rate[:2] @ K[:2], K[2])])
    return Rotation.from_euler("ZYX", angles).as_quat(), w, second @ K + rate @ K_rate, angles


@pytest.mark.parametrize(
    "told, order",
    [
        (["position", "velocity", "acceleration", "euler_parameters", "omega", "alpha"], 2.8),
        (True, 2.8),
        (["zyx", "omega", "alpha"], 2.8),
        (["euler_parameters", "omega"], 2.8),
        (["zyx", "omega"], 2.8),
        (["zyx"], 1.7),
        (["euler_parameters"], 1.7),
    ],
)
@pytest.mark.parametrize("beside", ["nothing", "a constraint"])
def test_a_free_particle_over_a_ground_that_turns(told, order, beside):
    """A particle 1 m from the origin stays where it is, though the ground tumbles; signs of E and what is beside it do not matter.

    Where the angular velocity is not told, the derivatives of the first orientation are: how else should the start be known.
    """
    place = np.array([1.0, 0.2, -0.4])
    E, w, _, _ = turn(0.0)
    A = Rotation.from_quat(E)
    scene = moving_ground(told, velocity=list(A.inv().apply(-np.cross(w, place))))
    table = scene.model_dump(exclude_unset=True)
    table["joint"]["t"]["start"]["position"] = list(A.inv().apply(place))

    if beside == "a constraint":
        table["body"]["hung"] = POINT
        table["joint"] |= {"hung": {"free": {}, "between": ["ground", "hung"]}}
        table["joint"] |= {"eye": {"spherical": {}, "between": ["ground", "hung"]}}

    worst = []

    for H in (0.1, 0.05):
        run = Run(mbdfmi.Scene(**table))
        far = 0.0

        for k in range(round(3 / H)):
            for n in (k, k + 1):
                E, w, alpha, angles = turn(n * H)
                commands = {
                    "ground.euler_parameters": E * (-1) ** (n // 3),
                    "ground.omega": w,
                    "ground.alpha": alpha,
                    "ground.zyx": angles,
                }
                run.set({name: value for name, value in commands.items() if f"{name}[1]" in run.input})

                if n == k:
                    if k == 0 and order < 2:
                        E, angles = ((turn(1e-4)[i] - turn(-1e-4)[i]) / 2e-4 for i in (0, 3))
                        rates = {"ground.euler_parameters": E, "ground.zyx": angles}
                        run.set(
                            {name: value for name, value in rates.items() if f"{name}[1]" in run.input}, 1
                        )

                    run.step(H)

            far = max(far, np.linalg.norm(run.get("p.position") - place))

        worst.append(far)

    assert worst[0] < (5e-3 if order > 2 else 0.2)
    assert np.log2(worst[0] / worst[1]) > order
    assert not run.instance.notices


def test_a_uniform_rotation_is_met_whatever_the_step():
    """40 rad/s about z at H = 1 s: 6.4 turns a step; a mass on a spring radially out settles nowhere else than with a driver."""
    run = Run(moving_ground(["euler_parameters", "omega"], velocity=[0, -40.0, 0]))
    run.instance.d.x[7:10] = [1.0, 0, 0]

    for k in range(3):
        run.set(
            {
                "ground.euler_parameters": [0, 0, np.sin(20.0 * k), np.cos(20.0 * k)],
                "ground.omega": [0, 0, 40.0],
            }
        )
        run.step(1.0)

    angle = 120.0
    run.set(
        {
            "ground.euler_parameters": [0, 0, np.sin(angle / 2), np.cos(angle / 2)],
            "ground.omega": [0, 0, 40.0],
        }
    )
    assert_allclose(run.get("p.position"), [1, 0, 0], atol=1e-6)
    assert not run.instance.notices


# what is not told is found


def base_with_mass(told):
    """10 kg carried by a base that heaves; the effort is that of the base's drive."""
    return mbdfmi.Scene(
        name="base",
        gravity=[0, 0, 0],
        body={"base": POINT | {"mass": 0.0}, "load": POINT | {"mass": 10.0}},
        joint={
            "heave": {
                "prismatic": {"axis": "z"},
                "between": ["ground", "base"],
                "driver": {"input": told},
                "output": ["effort"],
            },
            "weld": {"fixed": {}, "between": ["base", "load"]},
        },
    )


@pytest.mark.parametrize("told", [["position"], ["position", "speed"], True])
@pytest.mark.parametrize("derivatives", [0, 1, 2])
def test_force_of_a_base_that_heaves(told, derivatives):
    """10 kg times 1 m, 2 rad/s squared: 40 N, whatever is told of the motion, with input derivatives or without."""
    run = Run(base_with_mass(told))
    H, n = 0.05, len(told) if isinstance(told, list) else 3
    law = [lambda t, k=k: 2.0**k * np.sin(2 * t + 0.4 + k * np.pi / 2) for k in range(6)]

    for k in range(60):
        t = H * k
        run.set({f"heave.{NAMES[i]}_command": law[i](t) for i in range(n)})

        if k > 4:
            assert abs(run.get("heave.effort") - 10 * law[2](t)) < 2.0

        for order in range(1, derivatives + 1):
            run.set({f"heave.{NAMES[i]}_command": law[i + order](t) for i in range(n)}, order)

        run.step(H)

    assert not run.instance.notices


def test_inputs_that_a_master_interpolates():
    """Values at the start of each step and the slope to those at its end, as a Gauss-Seidel master gives them."""
    for told, allowed in ((["position"], 1e-3), (["position", "speed"], 1e-4), (True, 1e-4)):
        run = Run(slider(told))
        n, H = len(told) if isinstance(told, list) else 3, 0.05

        for k in range(60):
            now, then = swing(k * H), swing(k * H + H)
            run.set(dict(zip(COMMANDS[:n], now)))
            run.set(dict(zip(COMMANDS[:n], (then - now) / H)), 1)
            run.step(H)

            if k > 4:
                assert abs(run.get("j.position") - then[0]) < allowed
                assert abs(run.get("j.speed") - then[1]) < 30 * allowed


def quarter_car(**driver):
    """A body of 300 kg on a wheel of 40 kg over a road whose height is prescribed."""
    link = {"between": ["ground", "wheel"], "prismatic": {"axis": "z"}, "output": ["position"]}
    return mbdfmi.Scene(
        name="car",
        gravity=[0, 0, 0],
        body={"road": POINT, "wheel": POINT | {"mass": 40}, "car": POINT | {"mass": 300}},
        joint={
            "road": {"between": ["ground", "road"], "prismatic": {"axis": "z"}, **driver},
            "wheel": link,
            "car": link | {"between": ["ground", "car"], "output": ["position", "acceleration"]},
        },
        force={
            "tyre": {
                "spring_damper": {"stiffness": 2e5, "damping": 100, "rest_length": 0},
                "between": ["road", "wheel"],
            },
            "strut": {
                "spring_damper": {"stiffness": 2e4, "damping": 1500, "rest_length": 0},
                "between": ["wheel", "car"],
            },
        },
    )


def quarter_car_by_hand(road, road_speed, t):
    """Position of wheel and car by an integration of its own."""
    from scipy.integrate import solve_ivp

    def rate(t, x):
        z, zc, v, vc = x
        strut = 2e4 * (zc - z) + 1500 * (vc - v)
        tyre = 2e5 * (z - road(t)) + 100 * (v - road_speed(t))
        return v, vc, (strut - tyre) / 40, -strut / 300

    return solve_ivp(rate, (0, t[-1]), [0, 0, 0, 0], t_eval=t, rtol=1e-9, atol=1e-11, max_step=0.01).y


@pytest.mark.parametrize("frequency", [1.0, 8.0])
def test_quarter_car_by_the_position_of_the_road_alone(frequency):
    """Within 2 % of the largest at H = 1 ms: car and wheel, over a sine that begins at once."""
    w = 2 * np.pi * frequency
    scene = quarter_car(driver={"input": ["position"]})
    run = Run(scene)
    t = np.arange(401) * 1e-3
    right = quarter_car_by_hand(lambda t: 0.02 * np.sin(w * t), lambda t: 0.02 * w * np.cos(w * t), t)
    found = [[0, 0]]

    for k in range(400):
        run.set({"road.position_command": 0.02 * np.sin(w * t[k])})
        run.step(1e-3)
        run.set({"road.position_command": 0.02 * np.sin(w * t[k + 1])})
        found.append([run.get("wheel.position"), run.get("car.position")])

    error = abs(np.array(found).T - right[:2]).max(axis=1) / abs(right[:2]).max(axis=1)
    assert np.all(error < 0.02)


def test_a_kerb_is_not_climbed_twice():
    """A position that jumps by 1 m: what follows does not go beyond it by more than the way there."""
    run = Run(slider(["position"]))
    reached = []

    for k in range(30):
        run.set({"j.position_command": 0.0 if k < 10 else 1.0})
        run.step(0.01)
        reached.append(run.get("j.position"))

    assert_allclose(reached, [0.0] * 10 + [1.0] * 20, atol=1e-9)


def test_an_angle_that_wraps_does_not_spin():
    """Commands within half a turn either way, as atan2 gives them, of a joint that turns on: a disk on it feels no jump."""
    scene = mbdfmi.Scene(
        name="wrap",
        gravity=[0, 0, 0],
        body={"a": {"mass": 1, "inertia": [1, 1, 1]}, "b": {"mass": 1, "inertia": [1, 1, 1]}},
        joint={
            "j": {"revolute": {}, "between": ["ground", "a"], "driver": {"input": ["angle"]}},
            "k": {"revolute": {}, "between": ["a", "b"], "start": {"speed": -3.0}, "output": ["speed"]},
        },
    )
    run = Run(scene)

    for k in range(100):
        run.set({"j.angle_command": (0.15 * k + np.pi) % (2 * np.pi) - np.pi})
        run.step(0.05)
        assert run.get("k.speed") == pytest.approx(-3.0, abs=1e-6)


# contradictions


@pytest.mark.parametrize(
    "speed, acceleration, wrong",
    [
        (1.0, 1.0, False),
        (0.0, 0.0, True),
        (2.0, 1.0, True),
        (-1.0, 1.0, True),
        (1.0, 0.0, True),
        (np.pi / 180, np.pi / 180, True),
    ],
)
def test_what_contradicts_the_position_is_told_once(speed, acceleration, wrong):
    run = Run(slider(True))

    for k in range(40):
        run.set(dict(zip(COMMANDS, swing(0.05 * k) * (1, speed, acceleration))))
        run.step(0.05)

    told = [notice for notice in run.instance.notices if "contradicts itself" in notice]
    assert len(told) == wrong
    assert not wrong or "commanded for a contradicts" in told[0]


def test_a_ground_that_turns_against_its_orientation_is_told():
    run = Run(moving_ground(["zyx", "omega"]))

    for k in range(10):
        run.set({"ground.zyx": [0.1 * k, 0, 0], "ground.omega": [0, 0, -1.0]})
        run.step(0.1)

    assert len(run.instance.notices) == 1 and "ground" in run.instance.notices[0]


# runs in process


@pytest.mark.parametrize("step", [0.5, 0.1])
@pytest.mark.parametrize("told", [1, 2, 3])
def test_commands_as_functions(told, step):
    """A particle on the commanded slider stays where it is: functions are followed in between."""
    table = slider(list(NAMES[:told])).model_dump(exclude_unset=True)
    table["body"]["p"] = POINT | {"output": ["position"]}
    table["joint"]["free"] = {
        "prismatic": {"axis": "x"},
        "between": ["a", "p"],
        "start": {"speed": -swing(0.0)[1]},
    }
    inputs = {name: lambda t, k=k: swing(t)[k] for k, name in enumerate(COMMANDS[:told])}
    results = mbdfmi.Scene(**table).simulate(until=4, step=step, inputs=inputs)
    t = results["time"]
    found = np.array([results[f"j.{name}"] for name in NAMES])
    assert_allclose(found, swing(t), atol=1e-4 if told == 1 else 1e-6)
    assert_allclose(results["p.position[1]"], swing(0.0)[0], atol=1e-6)
    assert not results.notices


def test_commands_as_arrays():
    t = np.linspace(0, 4, 81)
    inputs = dict(zip(COMMANDS, swing(t)))
    results = slider(True).simulate(until=4, step=0.05, inputs=inputs)
    assert_allclose([results[f"j.{name}"] for name in NAMES], swing(t), atol=1e-12)


# scenes


@pytest.mark.parametrize(
    "told, said",
    [
        (["speed"], 'true, ["position", "speed"]'),
        (["position", "acceleration"], "tells the position, or position and speed"),
        ([], "needs at least one of"),
        ("position", "needs true or a list"),
        (False, "can only be true"),
        (["position", "position"], "listed twice"),
        (["place"], 'no "place" here'),
    ],
)
def test_drivers_that_are_refused(told, said):
    with pytest.raises(SceneError, match="driver.input") as error:
        slider(told)

    assert said in str(error.value)


@pytest.mark.parametrize(
    "told, said",
    [
        (["velocity"], '"velocity" needs "position" beside it'),
        (["position", "acceleration"], '"acceleration" needs "velocity" beside it'),
        (["omega"], '"omega" needs "euler_parameters" or "zyx" beside it'),
        (["zyx", "alpha"], '"alpha" needs "omega" beside it'),
        (["zyx", "euler_parameters"], "tell the same"),
        (["position", "speed", "velocity"], "one and the same"),
    ],
)
def test_grounds_that_are_refused(told, said):
    with pytest.raises(SceneError) as error:
        moving_ground(told)

    assert said in str(error.value)


def test_descriptions_say_what_belongs_together():
    about = {v.name: v.description for v in slider(["position", "speed"]).compile().of_causality("input")}
    assert "set together with j.speed_command" in about["j.position_command"]
    assert "acceleration found from the last commands" in about["j.position_command"]
    about = {
        v.name: v.description for v in moving_ground(["position", "zyx"]).compile().of_causality("input")
    }
    assert "angular velocity and angular acceleration found" in about["ground.zyx[1]"]
    assert "velocity and acceleration found" in about["ground.position[1]"]


# FMUs


SCENES = {
    "slider": lambda: slider(["position", "speed"]),
    "position": lambda: slider(["position"]),
    "all": lambda: moving_ground(True),
    "zyx": lambda: moving_ground(["position", "velocity", "zyx", "omega"]),
    "turn": lambda: moving_ground(["euler_parameters"]),
}


@pytest.mark.skipif(INTERPRETED, reason="interpreted kernels agree to rounding alone")
@pytest.mark.parametrize("name", SCENES)
def test_an_fmu_is_the_run_in_process(name, tmp_path):
    """To the bit, after every step, before and after new inputs: random commands, derivatives, steps, and a rollback."""
    from fmu_host import OK, Library
    from fmu_host import Instance as Slave

    scene = SCENES[name]()
    model = scene.compile()
    inside = Instance(model)
    slave = Slave(Library(scene.export(tmp_path / "x.fmu"), tmp_path / "x")).start()
    names = [v.name for v in model.of_causality("input")]
    rng = np.random.default_rng(3)
    t, snapshot, saved = 0.0, None, None

    def compare():
        u = inside.u.reshape(6, -1)
        assert slave.get(*names)[1] == list(u[0])
        assert slave.outputs() == list(inside.outputs())
        assert slave.get(*names)[1] == list(u[0])

    for k in range(12):
        if k == 7:
            assert slave.save() and slave.restore(snapshot) == OK
            state, inside.u[:], t = saved
            inside.d.state_buffer[:] = state

        u = inside.u.reshape(6, -1)

        for i, variable in enumerate(names):
            if rng.random() < 0.7:
                u[0, i] = rng.normal()
                assert slave.set({variable: u[0, i]}) == OK

            for order in range(1, 6):
                if rng.random() < 0.3:
                    u[order, i] = rng.normal()
                    assert slave.set_derivatives(variable, order, u[order, i]) == OK

        if k == 4:
            snapshot, saved = slave.save(), (inside.d.state_buffer.copy(), inside.u.copy(), t)

        H = float(rng.uniform(0.01, 0.2))
        inside.step(H)
        assert slave.step(t, H) == OK
        t += H
        compare()

    slave.free()
    warned = [entry for entry in slave.log if "contradicts" in entry[2]]
    assert all(category == "logStatusWarning" for _, category, _ in warned)
    assert len(warned) == len([notice for notice in inside.notices if "contradicts" in notice])


def test_commands_set_in_an_fmu_with_derivatives(tmp_path):
    """x = t^2 with exact input derivatives is met exactly."""
    from fmu_host import OK, Library
    from fmu_host import Instance as Slave

    slave = Slave(Library(slider(True).export(tmp_path / "x.fmu"), tmp_path / "x")).start()

    for k in range(10):
        t = 0.1 * k
        assert slave.set(dict(zip(COMMANDS, (t * t, 2 * t, 2.0)))) == OK

        for order, values in enumerate([(2 * t, 2.0, 0.0), (2.0, 0.0, 0.0)], 1):
            for variable, value in zip(COMMANDS, values):
                assert slave.set_derivatives(variable, order, value) == OK

        assert slave.step(t, 0.1) == OK
        assert_allclose(
            [slave.value(f"j.{name}") for name in NAMES], [(t + 0.1) ** 2, 2 * t + 0.2, 2.0], rtol=1e-12
        )

    slave.free()
