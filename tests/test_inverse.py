"""Inverse dynamics: against forward dynamics, virtual work and the formulae of robot arms."""

import numpy as np
import pytest
from scipy.interpolate import CubicSpline, make_interp_spline
from test_structure import four_bar

from mbdfmi import Scene
from mbdfmi.run.instance import Instance, SimulationError
from mbdfmi.run.results import Results

TIGHT = {"tolerance": 1e-12}
TIMES = np.linspace(0.0, 1.0, 201)


def arm(n, gravity=(0, -9.81, 0), solver=TIGHT, **more):
    """n links of lengths 1, 1/2, 1/3, ... m on revolute joints q1, q2, ... about z."""
    body, joint = {}, {}

    for k in range(1, n + 1):
        marker = {"end": {"position": [1 / k, 0, 0]}}
        body[f"link{k}"] = {
            "mass": 3.0 / k,
            "com": [0.4 / k, 0, 0],
            "inertia": [0.01, 0.1 / k, 0.1 / k],
            "marker": marker,
        }
        before = f"link{k - 1}.end" if k > 1 else "ground"
        joint[f"q{k}"] = {
            "revolute": {},
            "between": [before, f"link{k}"],
            "input": "torque",
            "output": ["angle", "speed"],
        } | more

    return Scene(name="arm", gravity=gravity, body=body, joint=joint, solver=solver)


def smooth(k):
    """A function of time, and its first two derivatives."""
    w = 1.0 + 0.7 * k
    return (
        lambda t: 0.3 * k + 0.8 * np.sin(w * t + k),
        lambda t: 0.8 * w * np.cos(w * t + k),
        lambda t: -0.8 * w**2 * np.sin(w * t + k),
    )


def exact_motion(joints, quantity="angle"):
    names = (quantity, "speed", "acceleration")
    return {f"{joint}.{name}": f for k, joint in enumerate(joints, 1) for name, f in zip(names, smooth(k))}


def forward(scene, efforts, times):
    """Outputs (n, n_y) of a run with inputs that are splines over time, exact to second order over
    each step.
    """
    instance = Instance(
        scene.compile(), inputs={k: float(efforts[v.name](times[0])) for k, v in enumerate(inputs_of(scene))}
    )
    n, rows = instance.model.n_u, []

    for k, t in enumerate(times):
        for position, v in enumerate(inputs_of(scene)):
            instance.u[position::n][:3] = [efforts[v.name](t, order) for order in range(3)]

        rows.append(instance.outputs().copy())

        if k + 1 < len(times):
            instance.step(times[k + 1] - t)

    return dict(zip([v.name for v in instance.model.of_causality("output")], np.array(rows).T))


def inputs_of(scene):
    return scene.compile().of_causality("input")


# with forward dynamics


@pytest.mark.parametrize("formulation", ["recursive", "embedding", "augmented"])
def test_inverse_then_forward_gives_the_motion_back(formulation):
    scene = arm(3, solver=TIGHT | {"formulation": formulation})
    found = scene.inverse(exact_motion(["q1", "q2", "q3"]), TIMES)
    efforts = {f"q{k}.torque": make_interp_spline(TIMES, found[f"q{k}.torque"], k=5) for k in (1, 2, 3)}
    joint = {}

    for k in (1, 2, 3):
        angle, speed, _ = smooth(k)
        start = {"angle": float(angle(0)), "speed": float(speed(0))}
        joint[f"q{k}"] = scene.model_dump(exclude_unset=True)["joint"][f"q{k}"] | {"start": start}

    started = Scene(**scene.model_dump(exclude_unset=True) | {"joint": joint})
    fine = np.linspace(0.0, 1.0, 1601)  # inputs are parabolas over each step: of order 3
    moved = forward(started, efforts, fine)

    for k in (1, 2, 3):
        np.testing.assert_allclose(moved[f"q{k}.angle"], smooth(k)[0](fine), atol=1e-7)


def test_forward_then_inverse_of_a_loop_gives_the_torque_back():
    """A four-bar whose crank is turned by a known torque, its motion as it was seen: angle, speed
    and acceleration.
    """
    scene = four_bar(input="torque", output=["angle", "speed", "acceleration"]).model_dump(exclude_unset=True)
    scene = Scene(**scene, solver=TIGHT)
    torque = make_interp_spline(TIMES, 20 * np.sin(3 * TIMES), k=5)
    moved = forward(scene, {"A.torque": torque}, TIMES)
    found = scene.inverse(
        {"time": TIMES} | {name: moved[name] for name in ("A.angle", "A.speed", "A.acceleration")}
    )

    np.testing.assert_allclose(found["A.torque"], 20 * np.sin(3 * TIMES), atol=1e-6)


def test_free_motion_needs_no_effort(tmp_path):
    """The table of a run, given as it was written, with outputs that are no drive's."""
    scene = four_bar(output=["angle", "speed", "acceleration", "reaction_force"])
    results = scene.simulate(1.0)
    found = scene.inverse(results.to_csv(tmp_path / "run.csv"))

    assert np.abs(found["A.torque"]).max() < 1e-9
    np.testing.assert_allclose(
        found["A.reaction_force"][:, :2], results["A.reaction_force"][:, :2], atol=1e-5
    )


# with virtual work


def four_bar_motion(angle, speed, acceleration, lengths, span):
    """Poses, velocities, accelerations of the bars' centres by the loop's closure, solved in
    complex numbers.

    Returns for each bar (height of its centre, (x', y'), (x'', y''), angular velocity,
    acceleration).
    """
    a, b, c = lengths
    end = a * np.exp(1j * angle)
    d = abs(span - end)
    # the triangle of coupler and rocker over the line from the crank's end to the right pivot,
    # elbow up
    base = np.angle(span - end)
    coupler = base + np.arccos((d**2 + b**2 - c**2) / (2 * d * b))
    tip = end + b * np.exp(1j * coupler)
    rocker = np.angle(tip - span)

    # i a w1 e1 + i b w2 e2 = i c w3 e3, then its derivative
    e1, e2, e3 = np.exp(1j * np.array([angle, coupler, rocker]))
    J = np.array([[(b * e2).real, -(c * e3).real], [(b * e2).imag, -(c * e3).imag]])
    w2, w3 = np.linalg.solve(J, [-(a * e1 * speed).real, -(a * e1 * speed).imag])
    left = -a * e1 * (acceleration + 1j * speed**2) - 1j * b * e2 * w2**2 + 1j * c * e3 * w3**2
    z2, z3 = np.linalg.solve(J, [left.real, left.imag])
    end_rate, end_rate2 = 1j * a * e1 * speed, a * e1 * (1j * acceleration - speed**2)
    bars = []

    for start, rate, rate2, length, e, w, z in (
        (0, 0, 0, a, e1, speed, acceleration),
        (end, end_rate, end_rate2, b, e2, w2, z2),
        (span, 0, 0, c, e3, w3, z3),
    ):
        arm = 0.5 * length * e
        bars.append((start + arm, rate + 1j * w * arm, rate2 + arm * (1j * z - w**2), w, z))

    return bars


def test_driven_four_bar_against_virtual_work():
    lengths, span = (0.5, 2.0, 1.5), 2.0
    scene = four_bar(lengths, span)
    angle, speed, acceleration = (
        lambda t: 1 + 3 * t + np.sin(t),
        lambda t: 3 + np.cos(t),
        lambda t: -np.sin(t),
    )
    times = np.linspace(0, 3, 61)
    found = scene.inverse({"A.angle": angle, "A.speed": speed, "A.acceleration": acceleration}, times)
    expected = []

    for t in times:
        power = 0.0

        for length, (_, v, a, w, z) in zip(
            lengths, four_bar_motion(angle(t), speed(t), acceleration(t), lengths, span)
        ):
            power += ((a + 9.81j) * v.conjugate()).real + length**2 / 12 * z * w

        expected.append(power / speed(t))

    np.testing.assert_allclose(found["A.torque"], expected, rtol=1e-9, atol=1e-9)


def test_any_joint_of_a_loop_can_be_driven():
    """The power of the drive is the same, whichever joint has the motor; a joint that closes the
    loop too.
    """
    scene = four_bar().model_dump(exclude_unset=True)

    for joint in scene["joint"].values():
        joint["output"] = ["angle", "speed", "acceleration"]

    scene = Scene(**scene)
    times = np.linspace(0, 0.6, 31)
    found = scene.inverse({"A.angle": lambda t: 1.0 + t, "A.speed": 1.0, "A.acceleration": 0.0}, times)
    power = found["A.torque"] * found["A.speed"]

    for joint in "BCD":
        again = scene.inverse({name: found[name] for name in found if name[0] in (joint, "t")})
        np.testing.assert_allclose(again[f"{joint}.torque"] * again[f"{joint}.speed"], power, atol=1e-7)


# what acts beside the drive, and other inputs


def test_effort_comes_beside_springs_dampers_and_forces():
    plain = arm(2).inverse(exact_motion(["q1", "q2"]), TIMES)
    more = {"spring": {"stiffness": 7.0, "rest": 0.2}, "damper": 0.5}
    held = arm(2, **more).inverse(exact_motion(["q1", "q2"]), TIMES)

    for k in (1, 2):
        angle, speed, _ = smooth(k)
        extra = 7.0 * (angle(TIMES) - 0.2) + 0.5 * speed(TIMES)
        np.testing.assert_allclose(held[f"q{k}.torque"] - plain[f"q{k}.torque"], extra, atol=1e-12)


def test_other_inputs_over_time():
    """A force at the hand adds J^T F to the torques."""
    scene = arm(2).model_dump(exclude_unset=True)
    scene["body"]["link2"]["marker"]["end"] |= {"input": ["force"]}
    force = np.column_stack([np.cos(TIMES), 2 * np.sin(TIMES), 0 * TIMES])
    motion = exact_motion(["q1", "q2"])
    without = Scene(**scene).inverse(motion, TIMES)
    found = Scene(**scene).inverse(motion, TIMES, inputs={"link2.end.force": force})
    q1, q2 = (smooth(k)[0](TIMES) for k in (1, 2))
    tip = np.array([np.cos(q1) + 0.5 * np.cos(q1 + q2), np.sin(q1) + 0.5 * np.sin(q1 + q2)])
    lever = np.array([0.5 * np.cos(q1 + q2), 0.5 * np.sin(q1 + q2)])

    for name, r in (("q1.torque", tip), ("q2.torque", lever)):
        expected = -(r[0] * force[:, 1] - r[1] * force[:, 0])
        np.testing.assert_allclose(found[name] - without[name], expected, atol=1e-12)


def test_at_rest_it_is_statics():
    found = arm(1).inverse({"q1.angle": 0.3}, times=[0.0])
    assert found["q1.torque"] == pytest.approx([3 * 9.81 * 0.4 * np.cos(0.3)], rel=1e-14)


def test_start_of_the_motion_may_be_far_from_the_scenes():
    """Two turns away the loop is still in its own branch."""
    scene = four_bar()
    times = np.linspace(0, 0.5, 11)
    near = scene.inverse({"A.angle": lambda t: 1 + t}, times)
    far = scene.inverse({"A.angle": lambda t: 1 + t - 4 * np.pi}, times)
    np.testing.assert_allclose(far["A.torque"], near["A.torque"], atol=1e-9)


# where speeds and accelerations come from


def test_splines_through_the_positions():
    """Of degree 5: the accelerations' error falls with the fourth power of the step."""
    scene = arm(2)
    motion = {name: f for name, f in exact_motion(["q1", "q2"]).items() if name.endswith("angle")}
    errors = []

    for n in (21, 41):
        times = np.linspace(0, 1, n)
        exact = scene.inverse(exact_motion(["q1", "q2"]), times)["q1.torque"]
        errors.append(np.abs(scene.inverse(motion, times)["q1.torque"] - exact).max())

    assert errors[0] < 1e-2 and errors[1] < errors[0] / 8


def test_functions_with_derivatives_are_taken_at_their_word():
    spline = CubicSpline([0, 0.4, 1], [0, 1, 0.5])
    found = arm(1).inverse({"q1.angle": spline}, TIMES)
    np.testing.assert_allclose(found["q1.acceleration"], spline(TIMES, 2), atol=1e-12)


def test_units_in_a_table(tmp_path):
    table = tmp_path / "motion.csv"
    table.write_text("time [s],q1.angle [deg],q2.angle\n0,0,0\n0.5,45,0.1\n1,90,0.2\n")
    motion = Results.from_csv(table)
    np.testing.assert_allclose(motion["q1.angle"], np.radians([0, 45, 90]), rtol=1e-15)
    assert motion.units["q1.angle"] == "rad"
    np.testing.assert_allclose(arm(2).inverse(table)["q1.speed"], np.pi / 2, rtol=1e-12)


# mistakes


@pytest.mark.parametrize(
    "motion, text",
    [
        ({"q1.angle": 0.1}, r'"q1" leaves 1 degree of freedom undetermined; .* driven too: "q2"'),
        ({"q1.angel": 0.1}, r"'q1.angel' is no joint coordinate; did you mean 'q1.angle'"),
        ({"q1.speed": 0.1}, "not its position"),
        ({"q1.angle": [1, 2]}, "needs 201 values"),
        ({"q1.angle": np.nan, "q2.angle": 0}, "not finite"),
        ({}, "no joint leaves 2 degrees"),
    ],
)
def test_mistakes_are_told(motion, text):
    with pytest.raises(ValueError, match=text):
        arm(2).inverse(motion, TIMES)


def test_too_many_drives():
    with pytest.raises(ValueError, match=r'gives "A" and "C".* 1 degree of freedom; drive fewer'):
        four_bar().inverse({"A.angle": 1.0, "C.angle": 2.0}, TIMES)


def test_a_body_that_no_motor_can_hold():
    ball = {"mass": 1.0, "inertia": [1, 1, 1]}
    scene = Scene(name="ball", body={"b": ball}, joint={"j": {"free": {}, "between": ["ground", "b"]}})
    with pytest.raises(
        ValueError, match="leaves 6 degrees of freedom undetermined; no revolute or prismatic"
    ):
        scene.inverse({}, TIMES)


def test_a_motion_out_of_reach():
    """The crank of a double rocker cannot turn around."""
    with pytest.raises(SimulationError, match="cannot be closed at .* lead out of reach"):
        four_bar((1.0, 0.8, 1.0), span=2.5, angle=0.3).inverse({"A.angle": lambda t: 0.3 + 3 * t}, TIMES)


@pytest.mark.parametrize(
    "text, message",
    [
        ("time,q1.angle\n0,0\n1,one\n", r"row 3, column 'q1.angle': needs a number, found 'one'"),
        ("q1.angle\n0\n1\n", 'no column "time"'),
        ("0,0\n1,1\n", "line 1 is of numbers, '0,0', and would be lost"),
        ("time,q1.angle [gon]\n0,0\n1,1\n", "unknown unit"),
        ("time,q1.angle\n", "at least one of numbers"),
        ("time,q1.angle\n1,0\n1,0\n", "must ascend"),
    ],
)
def test_mistakes_in_a_table_are_told(tmp_path, text, message):
    table = tmp_path / "motion.csv"
    table.write_text(text)

    with pytest.raises(ValueError, match=message):
        arm(1).inverse(table)
