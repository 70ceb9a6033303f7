"""Joints that hold a frame to the moving frame of a curve or surface: against hinges and slides, closed forms, splines of scipy."""

import numpy as np
import pytest
from fmu_host import OK, Library
from fmu_host import Instance as FmuInstance
from scenes import assert_near
from scipy.interpolate import CubicSpline
from scipy.spatial.transform import Rotation
from test_contacts import columns
from test_powers import named_outputs

from mbdfmi import Scene, SceneError
from mbdfmi.compiler.model import compile_scene
from mbdfmi.export import export_fmu
from mbdfmi.run.instance import Instance
from mbdfmi.run.simulate import simulate

formulations = pytest.mark.parametrize("formulation", ["recursive", "embedding", "augmented"])
EXACT = {"integrator": "rk853", "tolerance": 1e-11}
BODY = {
    "mass": 1.3,
    "com": [0.1, -0.2, 0.15],
    "inertia": [0.4, 0.5, 0.6],
    "output": ["position", "euler_parameters"],
}
AXES = ["tangent", "binormal", "normal"]
BENDS = [[0, 0, 0], [1, 0.4, 0], [2, 0, 0.3], [3, -0.6, 0.2], [4, 0, 0], [5, 0.3, 0.1]]


def on_shape(kind, shape, options=None, body=BODY, formulation="recursive", start=None, **tables):
    """A body that a joint holds to a frame on a ground marker; start : of the free joint, else of the parameters."""
    marker = {"m": {"position": [0.2, -0.1, 0.3], "zyx_deg": [20, -35, 50], kind.split("_")[-1]: shape}}
    hold = {kind: options or {}, "between": ["ground.m", "b.e"], "output": ["s", "s_rate", *AXES]}
    return {
        "name": "frames", "gravity": [0.5, -1, -9.81], "ground": {"marker": marker},
        "solver": EXACT | {"formulation": formulation},
        "body": {"b": body | {"marker": {"e": {"position": [0.05, 0.1, -0.1], "zyx_deg": [30, 40, -20]}}}},
        "joint": {"move": {"free": {}, "between": ["ground.m", "b.e"], "start": start or {}}, "hold": hold},
        "output": ["total_energy"],
    } | tables  # fmt: skip


def run(scene, until=0.6, step=0.1):
    return simulate(compile_scene(Scene.model_validate(scene)), until, step)


def the_same(scene, joint, tolerance=1e-8):
    """The same motion with a joint between the same markers in place of the two; returns both runs."""
    one = run(scene)
    other = scene | {"joint": {"move": joint | {"between": scene["joint"]["hold"]["between"]}}}
    two = run(other)

    for what, size in (("b.position", 3), ("b.euler_parameters", 4)):
        a, b = columns(one, what, size), columns(two, what, size)
        assert_near(a * np.sign((a * b).sum(1))[:, None] if size == 4 else a, b, tolerance)

    return one, two


@formulations
def test_on_a_circle_it_turns_as_on_a_hinge(formulation):
    """In its centre; the frame's axes lie as the angle s / R says, z outwards, x along the circle."""
    R, angle, speed = 0.7, 0.4, 1.5
    start = {"s": R * angle}
    scene = on_shape("frame_on_curve", {"circle": {"radius": R}}, None, formulation=formulation)
    scene["joint"]["hold"]["start"] = start
    # x radial, z the axis: the frame's x along the circle, y along the axis, z outwards
    turned = np.array([[0.0, 0, 1], [1, 0, 0], [0, 1, 0]])
    E = Rotation.from_matrix(Rotation.from_euler("z", angle).as_matrix() @ turned).as_quat()
    place = R * np.array([np.cos(angle), np.sin(angle), 0])
    scene["joint"]["move"]["start"] = {
        "position": place, "euler_parameters": E, "omega": [0, 0, speed],
        "velocity": speed * np.array([-place[1], place[0], 0]),
    }  # fmt: skip

    hinge = scene | {"body": {"b": scene["body"]["b"] | {"marker": scene["body"]["b"]["marker"].copy()}}}
    frame = hinge["body"]["b"]["marker"]["e"]
    A = Rotation.from_euler("ZYX", frame["zyx_deg"], degrees=True).as_matrix()
    centre = np.array(frame["position"]) + A @ (turned.T @ [-R, 0, 0])
    hinge["body"]["b"]["marker"]["c"] = {
        "position": centre, "euler_parameters": Rotation.from_matrix(A @ turned.T).as_quat(),
    }  # fmt: skip
    joint = {"revolute": {}, "between": ["ground.m", "b.c"], "start": {"angle": angle, "speed": speed},
             "output": ["angle", "speed"]}  # fmt: skip
    hinge["joint"] = {"move": joint}
    one, two = run(scene), run(hinge)
    assert_near(one["hold.s"], R * two["move.angle"], 1e-8)
    assert_near(one["hold.s_rate"], R * two["move.speed"], 1e-8)
    assert_near(columns(one, "b.position", 3), columns(two, "b.position", 3), 1e-8)
    c, s = np.cos(one["hold.s"] / R), np.sin(one["hold.s"] / R)
    assert_near(columns(one, "hold.tangent", 3), np.column_stack([-s, c, 0 * s]), 1e-12)
    assert_near(columns(one, "hold.normal", 3), np.column_stack([c, s, 0 * s]), 1e-12)
    assert_near(columns(one, "hold.binormal", 3), np.array([[0, 0, 1.0]] * len(s)), 1e-12)


@formulations
def test_on_a_line_it_slides(formulation):
    """And turns about it where its spin is free: a cylindrical joint."""
    scene = on_shape("frame_on_curve", {"line": {}}, {"spin": "free"}, formulation=formulation)
    scene["joint"]["move"]["start"] = {"velocity": [0.4, 0, 0], "omega": [1.2, 0, 0]}
    the_same(scene, {"cylindrical": {"axis": "x"}, "start": {"speed": 0.4, "angular_speed": 1.2}})
    scene["joint"]["hold"]["frame_on_curve"] = {"side": [0, 2, 0]}
    scene["joint"]["move"]["start"] = {"velocity": [0.4, 0, 0], "zyx_deg": [0, 0, 0]}
    tilted = run(scene)
    assert_near(columns(tilted, "hold.binormal", 3)[0], [0, 1, 0], 1e-12)
    assert_near(columns(tilted, "hold.normal", 3)[0], [0, 0, 1], 1e-12)
    the_same(scene, {"prismatic": {"axis": "x"}, "start": {"speed": 0.4}})


@formulations
@pytest.mark.parametrize("spin", ["held", "free"])
def test_on_a_plane(formulation, spin):
    """A body whose spin is free moves as on a planar joint, another one does not turn."""
    scene = on_shape("frame_on_surface", {"plane": {}}, {"spin": spin}, formulation=formulation)
    turn = 1.5 if spin == "free" else 0.0
    scene["joint"]["move"]["start"] = {"velocity": [0.4, -0.3, 0], "omega": [0, 0, turn]}
    planar = {"planar": {}, "start": {"velocity": [0.4, -0.3], "angular_speed": turn}}

    if spin == "free":
        the_same(scene, planar)
    else:
        results = run(scene)
        E = columns(results, "b.euler_parameters", 4)
        assert_near(E, E[[0]] + 0 * E, 1e-12)
        assert np.ptp(results["hold.s[1]"]) > 0.1


@formulations
@pytest.mark.parametrize("spin", ["held", "free"])
def test_on_a_sphere(formulation, spin):
    """With a free spin as on a ball joint in its centre, across the pole too; held, x points east."""
    R = 0.7
    scene = on_shape("frame_on_surface", {"sphere": {"radius": R}}, {"spin": spin}, formulation=formulation)
    scene["joint"]["hold"]["start"] = {"s": [0.0, 1.2]}
    east = np.array([[0.0, -np.sin(1.2), np.cos(1.2)], [1, 0, 0], [0, np.cos(1.2), np.sin(1.2)]])
    omega = np.array([0.0, -3.0, 0.0]) if spin == "free" else np.array([0.0, 0, 2.0])
    place = R * east[:, 2]
    scene["joint"]["move"]["start"] = {
        "position": place, "euler_parameters": Rotation.from_matrix(east).as_quat(),
        "omega": omega, "velocity": np.cross(omega, place),
    }  # fmt: skip

    if spin == "held":
        results = run(scene)
        longitude, latitude = results["hold.s[1]"], results["hold.s[2]"]
        assert_near(
            columns(results, "hold.tangent", 3),
            np.column_stack([-np.sin(longitude), np.cos(longitude), 0 * longitude]), 1e-12,
        )  # fmt: skip
        assert_near(columns(results, "hold.normal", 3)[:, 2], np.sin(latitude), 1e-12)
        energy = results["total_energy"]
        assert_near(energy, energy[0], 1e-8)
        return

    one = run(scene)
    frame = scene["body"]["b"]["marker"]["e"]
    A = Rotation.from_euler("ZYX", frame["zyx_deg"], degrees=True).as_matrix()
    scene["body"]["b"]["marker"]["e"] = frame | {"position": np.array(frame["position"]) - A @ [0, 0, R]}
    start = {"euler_parameters": Rotation.from_matrix(east).as_quat(), "omega": omega}
    scene["joint"] = {"move": {"spherical": {}, "between": ["ground.m", "b.e"], "start": start}}
    assert_near(columns(one, "b.position", 3), columns(run(scene), "b.position", 3), 1e-8)
    assert np.abs(one["hold.s[2]"]).max() > 1.4


@formulations
def test_a_car_on_a_track_through_a_point_of_inflection(formulation):
    """Its attitude is that of the spline's tangent and of the side; nothing is lost on the way."""
    scene = on_shape(
        "frame_on_curve", {"spline": {"points": BENDS}}, {"side": [0, 0.1, 1]}, formulation=formulation
    )
    scene["joint"]["hold"]["start"] = {"s": 0.5}
    scene["joint"]["move"]["start"] = {"velocity": [4.0, 0, 0]}
    scene["gravity"] = [0, 0, 0]
    results = run(scene, 0.9, 0.1)
    s = np.append(0, np.cumsum(np.linalg.norm(np.diff(BENDS, axis=0), axis=1)))
    tangent = CubicSpline(s, BENDS).derivative()(results["hold.s"])
    i = tangent / np.linalg.norm(tangent, axis=1)[:, None]
    k = np.cross(i, [0, 0.1, 1])
    k /= np.linalg.norm(k, axis=1)[:, None]
    j = np.cross(k, i)

    for name, axis in zip(AXES, (i, j, k)):
        assert_near(columns(results, f"hold.{name}", 3), axis, 1e-9)

    marker = Rotation.from_euler("ZYX", [20, -35, 50], degrees=True).as_matrix()
    frame = Rotation.from_euler("ZYX", [30, 40, -20], degrees=True).as_matrix()
    A = Rotation.from_quat(columns(results, "b.euler_parameters", 4)).as_matrix() @ frame
    assert_near(A, marker @ np.stack([i, j, k], axis=2), 1e-9)
    assert results["hold.s"][-1] > 3.3
    assert_near(results["total_energy"], results["total_energy"][0], 1e-7)


def test_the_reaction_of_a_car_on_a_circle():
    """A point at a steady speed: m v^2 / R inwards, and the moment that turns it, which is none."""
    body = {"mass": 1.3, "inertia": [0.4, 0.5, 0.6]}
    scene = on_shape("frame_on_curve", {"circle": {"radius": 2.0}}, body=body, gravity=[0, 0, 0])
    scene["body"]["b"]["marker"]["e"] = {}
    scene["joint"]["hold"]["output"] = ["reaction_force_body", "reaction_moment_body", "s_rate"]
    scene["joint"]["hold"]["start"] = {"s": 0.0}
    scene["joint"]["move"]["start"] = {"velocity": [0, 3.0, 0]}
    y = named_outputs(Instance(compile_scene(Scene.model_validate(scene))))
    v = y["hold.s_rate"]
    assert v > 1.0
    assert_near(y["hold.reaction_force_body"], [0, 0, -1.3 * v**2 / 2.0], 1e-9)
    assert_near(y["hold.reaction_moment_body"], 0, 1e-9)


@pytest.mark.parametrize(
    "curve, side, where",
    [
        ({"line": {}}, "x", "s = 0"),
        ({"circle": {"radius": 2}}, [1, 1, 0], "s = "),
        ({"spline": {"points": [[0, 0], [1, 0.2], [2, 0.9], [2.2, 1.5], [2, 3]]}}, "y", "s = "),
    ],
)
def test_a_side_that_the_curve_becomes_parallel_to_is_refused(curve, side, where):
    with pytest.raises(
        SceneError, match=r"frame_on_curve\.side.*is parallel to .*no normal.*farthest from"
    ) as told:
        compile_scene(Scene.model_validate(on_shape("frame_on_curve", curve, {"side": side})))

    assert where in str(told.value)


def test_axes_of_what_only_touches():
    """A point has the axes of its curve as outputs, too."""
    scene = on_shape("point_on_curve", {"parabola": {"coefficient": 0.5}})
    scene["joint"]["hold"]["start"] = {"s": 0.6}
    y = named_outputs(Instance(compile_scene(Scene.model_validate(scene))))
    length = np.hypot(1, 0.6)
    assert_near(y["hold.tangent"], [1 / length, 0.6 / length, 0], 1e-12)
    assert_near(y["hold.normal"], [0.6 / length, -1 / length, 0], 1e-12)


def test_in_an_fmu(tmp_path):
    """The same numbers as in process, and what outputs depend on."""
    scene = Scene.model_validate(on_shape("frame_on_curve", {"spline": {"points": BENDS}}, {"side": "z"}))
    scene.joint["hold"].start.s = 0.5
    model = compile_scene(scene)
    here = Instance(model)
    fmu = FmuInstance(Library(export_fmu(model, tmp_path / "frames.fmu"), tmp_path / "unpacked"))
    fmu.start()

    for k in range(3):
        assert fmu.step(0.1 * k, 0.1) == OK
        here.step(0.1)
        assert np.array_equal(fmu.outputs(), here.outputs())

    fmu.free()


# driven along the curve


def bead(formulation, driver, c=0.5, **hold):
    """A point of 1.3 kg on an upright parabola z = c x^2, driven along x."""
    curve = {"parabola": {"coefficient": c}}
    between = ["ground.m", "b"]
    output = ["s", "s_rate", "effort", "driver_power", "reaction_force"]
    inertia = [0.1] * 3 if formulation == "augmented" else [0.0] * 3
    return {
        "name": "bead", "solver": EXACT | {"formulation": formulation}, "output": ["driver_power"],
        "ground": {"marker": {"m": {"axes": {"x": "x", "y": "z"}, "curve": curve}}},
        "body": {"b": {"mass": 1.3, "inertia": inertia, "output": ["position"]}},
        "joint": {
            "move": {"translation": {}, "between": ["ground", "b"]},
            "hold": {"point_on_curve": {}, "between": between, "driver": driver, "output": output} | hold,
        },
    }  # fmt: skip


@formulations
def test_a_bead_driven_along_a_parabola(formulation):
    """Q = m (x'' (1 + 4 c^2 x^2) + 4 c^2 x x'^2 + 2 c g x), in the units of s = x; beyond a start that was nearer elsewhere."""
    driver = {"harmonic": {"amplitude": 1.2, "frequency": 0.7, "phase_deg": 50}}
    results = run(bead(formulation, driver))
    w, m, c = 2 * np.pi * 0.7, 1.3, 0.5
    phase = w * results["time"] + np.radians(50)
    x, v, a = 1.2 * np.sin(phase), 1.2 * w * np.cos(phase), -1.2 * w**2 * np.sin(phase)
    assert_near(results["hold.s"], x, 1e-13)
    assert_near(results["hold.s_rate"], v, 1e-12)
    assert_near(columns(results, "b.position", 3), np.column_stack([x, 0 * x, c * x * x]), 1e-13)
    effort = m * (a * (1 + 4 * c * c * x * x) + 4 * c * c * x * v * v + 2 * c * 9.81 * x)
    assert_near(results["hold.effort"], effort, 1e-11)
    assert_near(results["hold.driver_power"], effort * v, 1e-10)
    assert_near(results["driver_power"], effort * v, 1e-10)

    # the reaction is all that the joint exerts: Newton's law
    force = m * np.column_stack([a, 2 * c * (v * v + x * a) + 9.81])
    assert_near(columns(results, "hold.reaction_force", 3)[:, :2], force, 1e-10)


@formulations
def test_a_car_driven_around_a_circle(formulation):
    """Its inertia about the binormal turns with it, and what turns it is the force along the track."""
    scene = on_shape("frame_on_curve", {"circle": {"radius": 2.0}}, formulation=formulation)
    scene["body"]["b"] |= {"com": [0, 0, 0], "inertia": [0.4, 0.5, 0.6], "marker": {"e": {}}}
    scene["ground"]["marker"]["m"] |= {"axes": {"x": "x", "y": "z"}, "position": [0, 0, 0]}
    del scene["ground"]["marker"]["m"]["zyx_deg"]
    scene["gravity"] = [0, 0, -9.81]
    scene["joint"]["hold"] |= {
        "driver": {"polynomial": {"coefficients": [0.3, 1.5, 0.4]}}, "output": ["s", "effort", "driver_power"],
    }  # fmt: skip
    results = run(scene)
    t = results["time"]
    s, rate = 0.3 + 1.5 * t + 0.4 * t * t, 1.5 + 0.8 * t
    assert_near(results["hold.s"], s, 1e-13)
    effort = (1.3 + 0.5 / 4) * 0.8 + 1.3 * 9.81 * np.cos(s / 2)
    assert_near(results["hold.effort"], effort, 1e-11)
    assert_near(results["hold.driver_power"], effort * rate, 1e-10)


@pytest.mark.parametrize("driver", [{"constant_speed": 0.4}, {"hold": True}])
def test_drivers_that_go_on_from_the_start(driver):
    results = run(bead("recursive", driver, start={"s": 0.7}))
    assert_near(results["hold.s"], 0.7 + driver.get("constant_speed", 0.0) * results["time"], 1e-13)
    with pytest.raises(
        SceneError, match=r"\[joint\.hold\].*goes on from the parameter at the start.*start = "
    ):
        Scene.model_validate(bead("recursive", driver))


def test_what_a_driver_does_not_go_with():
    harmonic = {"harmonic": {"amplitude": 1.2, "frequency": 0.7}}
    with pytest.raises(SceneError, match="the driver says where the joint starts; drop the start"):
        Scene.model_validate(bead("recursive", harmonic, start={"s": 0.7}))

    with pytest.raises(SceneError, match='output "effort" is that of a driver, and there is none'):
        Scene.model_validate(bead("recursive", None))


def test_commanded_in_an_fmu(tmp_path):
    """The parameter follows inputs at once, so that the bodies' positions depend on them; to the bits of a run in process."""
    model = compile_scene(Scene.model_validate(bead("recursive", {"input": True}, start={"s": 0.3})))
    assert [v.name for v in model.of_causality("input")] == [
        f"hold.{x}_command" for x in ("s", "s_rate", "s_acceleration")
    ]
    told = {v.name: v for v in model.variables}
    assert told["hold.s_command"].unit == "m" and told["hold.effort"].unit == "N"
    here = Instance(model)
    fmu = FmuInstance(Library(export_fmu(model, tmp_path / "bead.fmu"), tmp_path / "unpacked"))
    fmu.start()

    for k in range(3):
        command = {
            "hold.s_command": 0.3 + 0.2 * k,
            "hold.s_rate_command": 0.2,
            "hold.s_acceleration_command": 0.0,
        }
        fmu.set(command)
        here.u[:3] = list(command.values())
        assert fmu.step(0.1 * k, 0.1) == OK
        here.step(0.1)
        assert np.array_equal(fmu.outputs(), here.outputs())

    fmu.free()


# shapes that move


@formulations
def test_a_curve_that_moves_within_its_body(formulation):
    """On a driven body without mass: a bead in a ring that is shaken against its carrier; the drive bears weight and inertia."""
    scene = {
        "name": "shaken ring", "gravity": [0, 0, 0], "solver": EXACT | {"formulation": formulation},
        "body": {
            "ring": {"mass": 0.0, "marker": {"r": {"curve": {"circle": {"radius": 0.5}}}}},
            "b": {"mass": 1.3, "inertia": [0.1, 0.1, 0.1], "output": ["position"]},
        },
        "joint": {
            "shake": {"prismatic": {"axis": "x"}, "between": ["ground", "ring"], "output": ["position", "effort"],
                      "driver": {"harmonic": {"amplitude": 0.1, "frequency": 1.1}}},
            "move": {"free": {}, "between": ["ground", "b"], "start": {"position": [0, 0.5, 0]}},
            "hold": {"frame_on_curve": {}, "between": ["ring.r", "b"], "output": ["s", "s_rate"]},
        },
    }  # fmt: skip
    results = run(scene)
    w, t = 2 * np.pi * 1.1, results["time"]
    angle, rate = results["hold.s"] / 0.5, results["hold.s_rate"] / 0.5
    lift = 0.1 * np.sin(w * t)
    assert_near(results["shake.position"], lift, 1e-14)
    place = np.column_stack([lift + 0.5 * np.cos(angle), 0.5 * np.sin(angle)])
    assert_near(columns(results, "b.position", 3)[:, :2], place, 1e-12)

    # m r^2 + I turns in the ring: (m r^2 + I) phi'' = m r x'' sin phi
    push = -0.1 * w * w * np.sin(w * t)
    faster = 1.3 * 0.5 * push * np.sin(angle) / (1.3 * 0.25 + 0.1)
    effort = 1.3 * (push - 0.5 * (np.sin(angle) * faster + np.cos(angle) * rate**2))
    assert_near(results["shake.effort"], effort, 1e-9)
    assert np.ptp(angle) > 0.05


OPEN = {"points": [[0.0, 0.0], [1.0, 0.3], [2.0, 0.2], [3.0, 0.9]], "s": [0.0, 1.0, 2.0, 3.0]}


def held(kind, shape, s, **solver):
    """A body held to a frame on a curve or surface of the ground, with nothing else that acts."""
    return Scene.model_validate({
        "name": "held", "gravity": [0, 0, 0], "solver": {"tolerance": 1e-10} | solver, "output": ["kinetic_energy"],
        "ground": {"marker": {"m": shape}},
        "body": {"b": {"mass": 2.0, "inertia": [0.3, 0.4, 0.5]}},
        "joint": {
            "free": {
                "free": {}, "between": ["ground", "b"],
                "start": {"position": [1.6, 0.25, 0.0], "velocity": [1.0, 0.0, 0.0]},
            },
            "way": {kind: {}, "between": ["ground.m", "b"], "start": {"s": s}, "output": ["s"]},
        },
    })  # fmt: skip


@formulations
@pytest.mark.parametrize("surface", [False, True])
def test_a_frame_stops_turning_where_its_curve_ends(formulation, surface):
    """Nothing pushes its origin there: its speed stays, and what it loses is the energy of its turning (about its y)."""
    shape = {"curve": {"spline": OPEN}}
    shape = {"surface": {"prism": {"profile": shape["curve"]}}} if surface else shape
    kind, s = ("frame_on_surface", [1.6, 0.0]) if surface else ("frame_on_curve", 1.6)
    results = held(kind, shape, s, formulation=formulation).simulate(4.0, 0.02)
    spline = CubicSpline(OPEN["s"], OPEN["points"])
    (x, y), (xx, yy) = spline(3.0, 1), spline(3.0, 2)
    bend = (x * yy - y * xx) / np.hypot(x, y) ** 3
    energy, way = results["kinetic_energy"], results["way.s[1]" if surface else "way.s"]
    before, after = way < 3.0, way > 3.0
    assert before.sum() > 20 and after.sum() > 20
    assert energy[before] == pytest.approx(energy[0], rel=1e-7)
    assert energy[after] == pytest.approx(energy[0] * 2.0 / (2.0 + 0.4 * bend**2), rel=1e-7)


def test_solvers_outside_stop_where_the_profile_of_a_prism_ends():
    model = compile_scene(
        held("frame_on_surface", {"surface": {"prism": {"profile": {"spline": OPEN}}}}, [1.6, 0.0])
    )
    kinks = [v.name for v in model.exchanged if "to_kink" in v.name]
    assert kinks == ["way.'s[1]'.to_kink_above", "way.'s[1]'.to_kink_below"]
