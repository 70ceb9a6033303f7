"""End frames on curves and surfaces in motion: reference digits, closed forms, reactions, cams, assembly."""

import numpy as np
import pytest
from test_contacts import CURVES, EGG, FORMULATIONS, SOLVER, SURFACES, columns, particle, reference

from benchmarks.problem_files import problem_file
from mbdfmi import Scene
from mbdfmi.compiler.model import compile_scene
from mbdfmi.kernels.end_frames import touching
from mbdfmi.run.instance import Instance, SimulationError
from mbdfmi.run.simulate import simulate
from mbdfmi.scene import SceneError

# particles against reference digits


@pytest.mark.parametrize("formulation", FORMULATIONS)
def test_bead_on_parabola(formulation):
    marker = {"curve": CURVES["parabola"]}
    scene = particle("point_on_curve", marker, (1, 0.5, 0), formulation=formulation, gravity=[0, -9.81, 0])
    results = simulate(compile_scene(scene), until=10.0, step=0.5)
    expected = reference("bead_on_parabola")
    np.testing.assert_allclose(results["body.position[1]"][1:], expected["x"], atol=1e-10)
    np.testing.assert_allclose(results["contact.s"][1:], expected["x"], atol=1e-10)
    np.testing.assert_allclose(results["contact.s_rate"][1:], expected["xd"], atol=1e-10)


@pytest.mark.parametrize("formulation", FORMULATIONS)
def test_cycloid_isochrone(formulation):
    # the particle is put where s says
    R, arc = 0.5, 1.2
    marker = {"position": [0, -2 * R, 0], "curve": {"cycloid": {"radius": R}}}
    start = 2 * np.arcsin(arc / (4 * R))
    scene = particle("point_on_curve", marker, start=start, formulation=formulation, gravity=[0, -9.81, 0])
    results = simulate(compile_scene(scene), until=10.0, step=0.5)
    expected = reference("cycloid_isochrone")
    s = results["contact.s"][1:]
    np.testing.assert_allclose(results["body.position[1]"][1:], expected["x"], atol=1e-10)
    np.testing.assert_allclose(results["body.position[2]"][1:], expected["y"], atol=1e-10)
    np.testing.assert_allclose(4 * R * np.sin(s / 2), expected["s"], atol=1e-10)
    np.testing.assert_allclose(
        2 * R * np.cos(s / 2) * results["contact.s_rate"][1:], expected["sd"], atol=1e-10
    )


@pytest.mark.parametrize("arc", [0.01, 0.5, 1.0, 1.9])
def test_period_on_a_cycloid_does_not_depend_on_the_amplitude(arc):
    R = 0.5
    marker = {"curve": {"cycloid": {"radius": R}}}
    start = 2 * np.arcsin(arc / (4 * R))
    scene = particle("point_on_curve", marker, start=start, gravity=[0, -9.81, 0])
    period = 2 * np.pi / np.sqrt(9.81 / (4 * R))
    results = simulate(compile_scene(scene), until=3 * period, step=period)
    np.testing.assert_allclose(results["contact.s"], start, rtol=1e-8)


@pytest.mark.parametrize("formulation", FORMULATIONS)
def test_particle_on_torus(formulation):
    data = problem_file("particle_on_torus")["bodies"][0]
    marker = {"surface": {"torus": {"radius": 2.0, "tube": 0.5}}}
    scene = particle("point_on_surface", marker, data["r0"], data["v0"], formulation=formulation)
    results = simulate(compile_scene(scene), until=10.0, step=0.5)
    expected = reference("particle_on_torus")
    s, s_rate = columns(results, "contact.s", 2), columns(results, "contact.s_rate", 2)
    np.testing.assert_allclose(s[1:].T, [expected["phi"], expected["theta"]], atol=1e-8)
    np.testing.assert_allclose(s_rate[1:].T, [expected["phid"], expected["thetad"]], atol=1e-7)
    np.testing.assert_allclose(
        columns(results, "body.position", 3)[1:].T, [expected[k] for k in "xyz"], atol=1e-8
    )
    momentum = (2 + 0.5 * np.cos(s[:, 1])) ** 2 * s_rate[:, 0]
    np.testing.assert_allclose(momentum, momentum[0], rtol=1e-9)
    np.testing.assert_allclose(results["total_energy"], results["total_energy"][0], rtol=1e-9)


@pytest.mark.parametrize("formulation", FORMULATIONS)
def test_particle_on_sphere(formulation):
    marker = {"surface": {"sphere": {"radius": 1.0}}}
    scene = particle("point_on_surface", marker, (1, 0, 0), (0, 2, 0), formulation=formulation)
    results = simulate(compile_scene(scene), until=10.0, step=0.5)
    expected = reference("spherical_pendulum")
    r = np.array([expected[k] for k in "xyz"])
    v = np.array([expected[f"v{k}"] for k in "xyz"])
    np.testing.assert_allclose(columns(results, "body.position", 3)[1:].T, r, atol=1e-9)
    np.testing.assert_allclose(columns(results, "hold.velocity", 3)[1:].T, v, atol=1e-8)
    s, s_rate = columns(results, "contact.s", 2)[1:], columns(results, "contact.s_rate", 2)[1:]
    np.testing.assert_allclose(np.cos(s[:, 0]) * np.cos(s[:, 1]), r[0], atol=1e-9)
    np.testing.assert_allclose(s_rate[:, 1] * np.cos(s[:, 1]), v[2], atol=1e-8)
    assert s[-1, 0] > 2 * np.pi


def test_sphere_through_its_pole():
    # a pendulum in a plane passes the pole, where longitudes jump and the motion does not
    marker = {"surface": {"sphere": {"radius": 1.0}}}
    results = simulate(compile_scene(particle("point_on_surface", marker, (1, 0, 0))), until=5.0, step=0.1)
    pendulum = Scene.model_validate(
        {
            "name": "pendulum",
            "body": {"bob": {"mass": 1, "com": [0, 0, -1], "inertia": [0, 0, 0]}},
            "joint": {
                "pin": {
                    "revolute": {"axis": "y"},
                    "between": ["ground", "bob"],
                    "start": {"angle_deg": -90},
                    "output": ["angle"],
                }
            },
            "solver": SOLVER,
        }
    )
    angle = simulate(compile_scene(pendulum), until=5.0, step=0.1)["pin.angle"]
    np.testing.assert_allclose(results["body.position[1]"], -np.sin(angle), atol=1e-10)
    np.testing.assert_allclose(results["body.position[3]"], -np.cos(angle), atol=1e-10)


HOOP = {"axes": {"x": [1, 0, 0], "y": [0, 0, 1]}, "curve": {"circle": {"radius": 1.0}}}


def hoop_start():
    """Position and velocity of the bead at the start in the inertial frame."""
    return {"position": [np.sin(0.1), 0, -np.cos(0.1)], "velocity": [0, 5 * np.sin(0.1), 0]}


@pytest.mark.parametrize("formulation", FORMULATIONS)
def test_bead_on_a_driven_hoop(formulation):
    scene = Scene.model_validate(
        {
            "name": "hoop",
            "body": {
                "bead": {"mass": 1.0, "inertia": [0.1, 0.1, 0.1]},
                "hoop": {"mass": 2.0, "inertia": [1, 1, 1], "marker": {"wire": HOOP}},
            },
            "joint": {
                "shaft": {
                    "revolute": {},
                    "between": ["ground", "hoop"],
                    "driver": {"constant_speed": 5.0},
                },
                "hold": {"translation": {}, "between": ["ground", "bead"], "start": hoop_start()},
                "wire": {
                    "point_on_curve": {},
                    "between": ["hoop.wire", "bead"],
                    "output": ["s", "s_rate"],
                },
            },
            "solver": SOLVER | {"formulation": formulation},
        }
    )
    results = simulate(compile_scene(scene), until=10.0, step=0.5)
    expected = reference("bead_rotating_hoop")
    theta = results["wire.s"][1:] - 1.5 * np.pi
    np.testing.assert_allclose(theta, expected["theta"], atol=1e-8)
    np.testing.assert_allclose(results["wire.s_rate"][1:], expected["thetad"], atol=1e-8)


def test_bead_on_a_hoop_that_turns_with_the_ground():
    scene = Scene.model_validate(
        {
            "name": "hoop",
            "ground": {
                "motion": {"rotation": {"axis": "z", "speed": 5.0}},
                "marker": {"wire": HOOP},
            },
            "body": {"bead": {"mass": 1.0, "inertia": [0, 0, 0]}},
            "joint": {
                "hold": {
                    "translation": {},
                    "between": ["ground", "bead"],
                    "start": {"position": hoop_start()["position"]},
                },
                "wire": {
                    "point_on_curve": {},
                    "between": ["ground.wire", "bead"],
                    "output": ["s", "s_rate"],
                },
            },
            "solver": SOLVER,
        }
    )
    results = simulate(compile_scene(scene), until=10.0, step=0.5)
    expected = reference("bead_rotating_hoop")
    np.testing.assert_allclose(results["wire.s"][1:] - 1.5 * np.pi, expected["theta"], atol=1e-8)
    np.testing.assert_allclose(results["wire.s_rate"][1:], expected["thetad"], atol=1e-8)


# reactions


def test_force_on_a_bead_on_a_parabola():
    # N = m (g cos(slope) + curvature v^2), along the normal
    marker = {"curve": CURVES["parabola"]}
    scene = particle("point_on_curve", marker, (1, 0.5, 0), gravity=[0, -9.81, 0], output=["reaction_force"])
    results = simulate(compile_scene(scene), until=2.0, step=0.1)
    x, xd = results["contact.s"], results["contact.s_rate"]
    length = np.sqrt(1 + x**2)
    speed = xd * length
    normal = np.column_stack([-x, np.ones_like(x), 0 * x]) / length[:, None]
    size = 9.81 / length + speed**2 / length**3
    np.testing.assert_allclose(
        columns(results, "contact.reaction_force", 3), size[:, None] * normal, atol=1e-9
    )


def test_force_on_a_particle_on_a_sphere():
    marker = {"surface": {"sphere": {"radius": 0.8}}}
    scene = particle("point_on_surface", marker, (0.8, 0, 0), (0, 2, 0), output=["reaction_force"])
    results = simulate(compile_scene(scene), until=2.0, step=0.1)
    r, v = columns(results, "body.position", 3), columns(results, "hold.velocity", 3)
    size = (9.81 * r[:, 2] - (v**2).sum(1)) / 0.8
    np.testing.assert_allclose(
        columns(results, "contact.reaction_force", 3), size[:, None] * r / 0.8, atol=1e-9
    )


# cams


def cam_scene(cam, follower, formulation="auto", drive=True, **tables):
    """A cam that turns about the ground's z axis and a follower of 2 kg that moves along y."""
    shaft = {"revolute": {}, "between": ["ground", "cam"], "output": ["angle", "speed"]}
    shaft |= {"driver": {"constant_speed": 3.0}} if drive else {"start": {"speed": 3.0}}
    return Scene.model_validate(
        {
            "name": "cam",
            "gravity": [0, -9.81, 0],
            "body": {
                "cam": {
                    "mass": 1.0,
                    "com": [0.1, 0, 0],
                    "inertia": [0.1, 0.1, 0.2],
                    "marker": {"edge": cam},
                },
                "follower": {"mass": 2.0, "inertia": [0.1, 0.1, 0.1], "marker": {"edge": follower}},
            },
            "joint": {
                "shaft": shaft,
                "guide": {
                    "prismatic": {"axis": "y"},
                    "between": ["ground", "follower"],
                    "start": {"position": 0.6},
                    "output": ["position", "speed", "acceleration"],
                },
                "contact": {
                    "curve_on_curve": {},
                    "between": ["cam.edge", "follower.edge"],
                    "output": ["s", "s_rate", "reaction_force", "reaction_moment"],
                },
            },
            "output": ["total_energy"],
            "solver": SOLVER | {"formulation": formulation},
        }
        | tables
    )


R, ECCENTRICITY = 0.4, 0.15
ECCENTRIC = {"position": [ECCENTRICITY, 0, 0], "curve": {"circle": {"radius": R}}}


@pytest.mark.parametrize("formulation", FORMULATIONS)
def test_eccentric_cam_under_a_flat_follower(formulation):
    scene = cam_scene(ECCENTRIC, {"curve": {"line": {}}}, formulation)
    results = simulate(compile_scene(scene), until=3.0, step=0.05)
    angle = 3.0 * results["time"]
    np.testing.assert_allclose(results["guide.position"], R + ECCENTRICITY * np.sin(angle), atol=1e-11)
    np.testing.assert_allclose(results["guide.speed"], 3.0 * ECCENTRICITY * np.cos(angle), atol=1e-10)
    acceleration = -9.0 * ECCENTRICITY * np.sin(angle)
    np.testing.assert_allclose(results["guide.acceleration"], acceleration, atol=1e-9)

    # it touches above the circle's centre; in the cam's axes the circle is passed backwards
    np.testing.assert_allclose(results["contact.s[2]"], ECCENTRICITY * np.cos(angle), atol=1e-10)
    np.testing.assert_allclose(results["contact.s_rate[1]"], -3.0 * R, atol=1e-9)

    # the force is vertical and bears and accelerates the follower
    force = columns(results, "contact.reaction_force", 3)
    up = np.column_stack([np.sin(angle), np.cos(angle), 0 * angle])
    np.testing.assert_allclose(force, 2.0 * (9.81 + acceleration)[:, None] * up, atol=1e-8)


@pytest.mark.parametrize("formulation", FORMULATIONS)
def test_eccentric_cam_under_a_roller(formulation):
    r = 0.1
    scene = cam_scene(ECCENTRIC, {"curve": {"circle": {"radius": r}}}, formulation)
    results = simulate(compile_scene(scene), until=3.0, step=0.05)
    angle = 3.0 * results["time"]
    x, y = ECCENTRICITY * np.cos(angle), ECCENTRICITY * np.sin(angle)
    np.testing.assert_allclose(results["guide.position"], y + np.sqrt((R + r) ** 2 - x**2), atol=1e-11)


def test_energy_of_a_cam_that_turns_freely():
    egg = {"curve": {"spline": {"points": (0.3 * np.array(EGG)).tolist(), "closed": True}}}
    scene = cam_scene(egg, {"curve": {"circle": {"radius": 0.1}}}, drive=False)
    results = simulate(compile_scene(scene), until=3.0, step=0.05)
    np.testing.assert_allclose(results["total_energy"], results["total_energy"][0], rtol=1e-8)
    assert np.ptp(results["guide.position"]) > 0.05


def test_parabola_rocks_on_a_line():
    # the height of a parabola's vertex above its horizontal tangent
    c = 2.0
    scene = Scene.model_validate(
        {
            "name": "rocker",
            "gravity": [0, -9.81, 0],
            "ground": {"marker": {"floor": {"curve": {"line": {}}}}},
            "body": {
                "rocker": {
                    "mass": 1.5,
                    "com": [0, 0.1, 0],
                    "inertia": [0.02, 0.02, 0.03],
                    "marker": {"edge": {"curve": {"parabola": {"coefficient": c}}}},
                    "output": ["position"],
                }
            },
            "joint": {
                "plane": {
                    "planar": {},
                    "between": ["ground", "rocker"],
                    "start": {"position": [0, 0.1], "angle": 0.5, "velocity": [0.3, 0]},
                    "output": ["angle", "velocity", "angular_speed"],
                },
                "contact": {
                    "curve_on_curve": {},
                    "between": ["ground.floor", "rocker.edge"],
                    "output": ["s"],
                },
            },
            "output": ["total_energy", "linear_momentum"],
            "solver": SOLVER,
        }
    )
    results = simulate(compile_scene(scene), until=4.0, step=0.05)
    angle = results["plane.angle"]
    assert np.ptp(angle) > 0.5
    slope = -np.tan(angle)
    height = np.sin(angle) ** 2 / (4 * c * np.cos(angle))
    np.testing.assert_allclose(results["contact.s[2]"], slope / (2 * c), atol=1e-11)
    np.testing.assert_allclose(results["rocker.position[2]"], height, atol=1e-11)
    np.testing.assert_allclose(results["total_energy"], results["total_energy"][0], rtol=1e-9)
    np.testing.assert_allclose(results["linear_momentum[1]"], results["linear_momentum[1]"][0], atol=1e-9)


# assembly


def test_particle_goes_to_the_given_parameter_on_the_far_side():
    marker = {"curve": CURVES["circle"]}
    scene = particle("point_on_curve", marker, start=0.7 * np.pi)
    x = Instance(compile_scene(scene)).d.x
    np.testing.assert_allclose(x[:3], (-0.7, 0, 0), atol=1e-13)
    np.testing.assert_allclose(x[6], 0.7 * np.pi, rtol=1e-13)


def test_given_position_is_kept_and_the_parameter_found():
    marker = {"curve": CURVES["circle"]}
    scene = particle("point_on_curve", marker, (0, -0.7, 0))
    x = Instance(compile_scene(scene)).d.x
    np.testing.assert_allclose(x[:3], (0, -0.7, 0), atol=1e-13)
    np.testing.assert_allclose(x[6], 1.5 * np.pi * 0.7, rtol=1e-13)


def test_a_parameter_that_is_found_is_not_searched_for(monkeypatch):
    """Newton's method ends at rounding, which is that of the parameter's size: here of 3.3 m."""
    marker = {"curve": CURVES["circle"]}
    instance = Instance(compile_scene(particle("point_on_curve", marker, start=3.3)))
    asked, newton = [], touching.newton
    monkeypatch.setattr(touching, "newton", lambda *found: asked.append(1) or newton(*found))
    touching.find(instance.m, instance.d, 0)
    assert len(asked) <= 3


def test_contact_out_of_reach():
    # a bob on a rod of 1 m cannot get to a circle of 3 m
    scene = Scene.model_validate(
        {
            "name": "short",
            "ground": {"marker": {"shape": {"curve": {"circle": {"radius": 3.0}}}}},
            "body": {"bob": {"mass": 1, "inertia": [1, 1, 1], "marker": {"end": {"position": [1, 0, 0]}}}},
            "joint": {
                "pin": {"revolute": {}, "between": ["ground", "bob"]},
                "rim": {"point_on_curve": {}, "between": ["ground.shape", "bob.end"]},
            },
        }
    )

    with pytest.raises(SimulationError, match="cannot be closed at rim"):
        Instance(compile_scene(scene))


def test_two_lines_do_not_roll_on_each_other():
    with pytest.raises(SceneError, match="two straight lines"):
        compile_scene(cam_scene({"curve": {"line": {}}}, {"curve": {"line": {}}}))


def test_contact_given_twice_changes_nothing():
    scene = particle("point_on_curve", {"curve": CURVES["helix"]}, (1, 0, 0))
    twice = scene.model_copy(update={"joint": scene.joint | {"again": scene.joint["contact"]}})
    once, twice = (simulate(compile_scene(s), until=1.0, step=0.1) for s in (scene, twice))
    np.testing.assert_allclose(twice["contact.s"], once["contact.s"], atol=1e-10)
    np.testing.assert_allclose(twice["again.s"], once["contact.s"], atol=1e-10)


def test_units_of_parameters():
    model = compile_scene(
        particle("point_on_surface", {"surface": SURFACES["cylinder"]}, (0.7, 0, 0), start=[0.1, 0.2])
    )
    units = {v.name: v.unit for v in model.variables}
    assert [units[f"contact.s[{k}]"] for k in (1, 2)] == ["rad", "m"]
    assert [units[f"contact.s_rate[{k}]"] for k in (1, 2)] == ["rad/s", "m/s"]
    assert [units[f"contact.s_start[{k}]"] for k in (1, 2)] == ["rad", "m"]
