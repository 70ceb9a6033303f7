"""Righting arms and the rest of what floats, against clipped sections, the wall-sided formula, and published figures."""

import numpy as np
import pytest
import trimesh
from scipy.optimize import brentq, fsolve
from test_hydrostatics import clipped, saved, section

import mbdfmi
from mbdfmi import Scene

RHO, G = 1025.0, 9.81
CRANE = mbdfmi.__path__[0] + "/../models/floating_crane.toml"


def barge(size, mass, height, **more):
    """A box that floats, its centre of mass at a height over the keel's centre, which is its origin."""
    length, breadth, depth = size
    hull = {"mass": mass, "com": [0, 0, height], "inertia": [1e9, 1e9, 1e9], "output": ["position", "zyx"]}
    return Scene.model_validate(
        {
            "name": "barge",
            "gravity": [0, 0, -G],
            "body": {"hull": hull},
            "joint": {"sea": {"free": {}, "between": ["ground", "hull"]}},
            "force": {
                "water": {
                    "hydrostatics": {"box": {"size": size}, "position": [0, 0, depth / 2]},
                    "on": "hull",
                }
            },
        }
        | more
    )


def test_a_box_has_its_righting_arm_at_every_heel():
    """The barge of 40 x 40 x 10 m, 4 m of draught, with its centre of mass 7 m over the water: by its clipped section."""
    size, draught, height = [40.0, 40.0, 10.0], 4.0, 11.0
    mass = RHO * size[0] * size[1] * draught
    found = barge(size, mass, height).righting(heel=np.arange(0, 91, 5))

    for heel, arm in zip(found.heel, found.arm):
        a = np.radians(heel)
        area = lambda z: clipped(section(a, z, size[1], size[2]))[0] - size[1] * draught
        z = brentq(area, -20, 20, xtol=1e-12)
        _, centre = clipped(section(a, z, size[1], size[2]))
        # of the centre of mass, up from the centre of the box
        right = -np.sin(a) * (height - size[2] / 2) - centre[0]
        assert abs(arm - right) < 1e-12

    assert np.abs(found.trim).max() < 1e-9
    right = draught / 2 + size[1] ** 2 / (12 * draught) - height
    assert abs(found.metacentric - right) < 1e-6
    (_, stable), (heel, lost) = found.rests()
    assert stable and not lost and abs(heel - 62.2) < 0.2
    assert abs(found.area(0, 10) - np.trapezoid(found.arm[:3], np.radians(found.heel[:3]))) < 0.01


def test_a_boat_of_triangles_rights_itself_as_a_box_does(tmp_path):
    """A box, each side of which is many triangles: the same arms, trims and draughts; a boat with sharp ends between boxes."""
    size, mass, height = [12.0, 5.0, 4.0], RHO * 12.0 * 5.0 * 1.6, 1.9
    box = trimesh.creation.box(size).subdivide().subdivide()
    heel = np.arange(0, 91, 10)
    right = barge(size, mass, height).righting(heel=heel)
    water = {"hydrostatics": saved(box, tmp_path) | {"position": [0, 0, 2.0]}, "on": "hull"}
    found = barge(size, mass, height, force={"water": water}).righting(heel=heel)
    assert np.abs(found.arm - right.arm).max() < 1e-11
    assert np.abs(found.draught - right.draught).max() < 1e-11
    assert np.abs(found.trim - right.trim).max() < 1e-8

    # prisms with the same section amidships: pointed ends take away from the waterplane, and so from GM
    plan = [(-6.0, 0.0), (-4.0, -2.5), (4.0, -2.5), (6.0, 0.0), (4.0, 2.5), (-4.0, 2.5)]
    boat = trimesh.convex.convex_hull([(x, y, z) for x, y in plan for z in (-2.0, 2.0)])
    waterplane = 12.0 * 5.0 - 4 * 0.5 * 2.0 * 2.5
    inertia = 8.0 * 5.0**3 / 12 + 4 * (2.0 * 2.5**3 / 12)
    water = {"hydrostatics": saved(boat, tmp_path, "boat.off") | {"position": [0, 0, 2.0]}, "on": "hull"}
    found = barge(size, RHO * waterplane * 1.6, height, force={"water": water}).righting(heel=[0.0, 2.0])
    assert abs(found.metacentric - (0.8 + inertia / (waterplane * 1.6) - height)) < 1e-6


def test_trim_goes_free_with_the_heel():
    """A wedge is not alike fore and aft: what holds it at a heel takes no moment across."""
    size = [60.0, 20.0, 8.0]
    scene = barge(size, RHO * 60 * 20 * 4, 5.0)
    scene.body["hull"].com = (4.0, 0.0, 5.0)
    found = scene.righting(heel=[0, 15, 30])
    # at no heel, wall-sided: the trim at which the centre of buoyancy is below that of mass
    along = lambda t: (
        60**2 / 48 * np.tan(t) - (4.0 * 1 + np.tan(t) * (5.0 - 2.0 - 60**2 / 96 * np.tan(t) ** 2))
    )
    trim = np.degrees(brentq(along, 0, 0.2, xtol=1e-15))
    assert abs(abs(found.trim[0]) - trim) < 1e-9
    assert np.abs(found.displaced / 4800 - 1).max() < 1e-12

    across = scene.righting(axis="y", heel=[trim * np.sign(found.trim[0])])
    assert abs(across.arm[0]) < 1e-9


def test_the_floating_crane_of_the_benchmark_heels_as_published():
    """A barge of 60 x 20 x 8 m and a load of 50 t that hangs at (18, 20) m from the keel's centre: 15 digits."""
    load = {
        "body": {
            "hull": {
                "mass": 4_920_000.0,
                "com": [0, 0, 5.0],
                "inertia": [1.9e8, 1.5e9, 1.6e9],
                "output": ["position", "zyx"],
                "marker": {"tip": {"position": [0, 18, 20]}, "tank": {"position": [0, -9, 1]}},
            },
            "load": {"mass": 50_000.0, "com": [0, 0, -8], "inertia": [1e5, 1e5, 1e5]},
            "ballast": {"mass": 1e-6, "inertia": [0, 0, 0]},
        },
        "joint": {
            "sea": {"free": {}, "between": ["ground", "hull"]},
            "rope": {"spherical": {}, "between": ["hull.tip", "load"]},
            "tank": {"fixed": {}, "between": ["hull.tank", "ballast"]},
        },
    }
    scene = barge([60.0, 20.0, 8.0], 1.0, 5.0, **load)
    found = scene.equilibrium()
    heel = found.outputs["hull.zyx[3]"]
    assert abs(np.degrees(abs(heel)) - 2.0240122460776635) < 1e-9
    # the draught along the barge's own centre line
    assert abs(-found.outputs["hull.position[3]"] / np.cos(heel) - 4.040650406504065) < 1e-9
    assert found.stable is None and found.error < 1e-12

    level = scene.trim({"ballast.mass": 5e4}, {"hull.zyx[3]": 0.0}, rest=True)
    assert abs(level.parameters["ballast.mass"] - 100_000.0) < 1e-4
    assert (
        abs(scene.equilibrium(parameters=level.parameters).outputs["hull.position[3]"] + 4.121951219512195)
        < 1e-9
    )


def side_lift(ballast):
    """(mass, y and z of its centre from the keel's) of the crane of models/ over the side."""
    weights = [(9.5e6, 0.0, 5.0), (2.608e6, -45.0, 60.0), (ballast, 18.0, 2.0)]
    mass = sum(weight for weight, _, _ in weights)
    y = sum(weight * at for weight, at, _ in weights) / mass
    z = sum(weight * at for weight, _, at in weights) / mass
    return mass, y, z


@pytest.mark.parametrize("time", [0.0, 180.0])
def test_the_crane_over_the_bow_rests_as_a_box_does(time):
    """Wall-sided: the centre of buoyancy is under that of mass; slewed by 2 deg it heels and trims at once."""
    scene = mbdfmi.load(CRANE)
    found = scene.equilibrium(time=time)
    angle = found.coordinates["slew.angle"]
    mass = 9.5e6 + 2.608e6 + 1.0
    weights = [
        (9.5e6, 0, 0, 5.0),
        (2.608e6, 30 + 45 * np.cos(angle), 45 * np.sin(angle), 60.0),
        (1.0, -10, 18, 2.0),
    ]
    centre = np.array([sum(w * np.array(r) for w, *r in weights)][0]) / mass
    length, breadth = 110.0, 45.0
    draught = mass / (RHO * length * breadth)

    def off(slope):
        """The centre of buoyancy is where up, seen from the barge, leads to that of mass; slope: of the water over the deck."""
        a, b = slope
        water = np.array([a * length**2 / 12, b * breadth**2 / 12, 0]) / draught
        water[2] = draught / 2 + (a * a * length**2 + b * b * breadth**2) / (24 * draught)
        up = np.array([-a, -b, 1.0])
        return np.cross(centre - water, up)[:2]

    a, b = fsolve(off, [0.0, 0.0], xtol=1e-12)
    up = np.array([-a, -b, 1.0]) / np.sqrt(1 + a * a + b * b)
    x, y, z, w = found.positions["hull"][1]
    own = np.array([2 * (x * z - y * w), 2 * (y * z + x * w), 1 - 2 * (x * x + y * y)])
    assert np.abs(own - up).max() < 1e-10

    if time == 0.0:
        assert abs(np.degrees(np.arcsin(np.linalg.norm(own[:2]))) - 2.27) < 0.005


def test_the_crane_capsizes_over_the_side_where_a_linear_stiffness_rests():
    """Through equilibria as it slews, which a slow run follows; past 65 deg there is none but upside down."""
    scene = mbdfmi.load(CRANE)
    heel = lambda time: np.degrees(scene.equilibrium(time=time).outputs["hull.zyx[3]"])
    assert 13.0 < heel(600.0) < 13.2
    assert abs(heel(960.0)) > 170.0

    mass, y, z = side_lift(0.0)
    draught = mass / (RHO * 110 * 45)
    linear = np.degrees(-y / (draught / 2 + 45**2 / (12 * draught) - z))
    assert abs(linear - 10.0) < 0.2

    arm = scene.righting(heel=np.arange(0, 61, 4.0), time=960.0)
    assert np.nanmax(arm.arm) < 0.0 and arm.metacentric > 50.0

    upright = scene.equilibrium(time=960.0, parameters={"ballast.mass": 6.52e6})
    assert abs(upright.outputs["hull.zyx[3]"]) < 1e-12

    run = scene.simulate(1000.0, 20.0)
    slow = [k for k, t in enumerate(run["time"]) if t in (240.0, 420.0, 540.0)]
    assert (
        np.abs(np.degrees(run["hull.zyx[3]"][slow]) - [heel(t) for t in (240.0, 420.0, 540.0)]).max() < 0.05
    )
    assert abs(np.degrees(run["hull.zyx[3]"][-1])) > 170.0


def test_what_has_no_hull_is_told():
    scene = mbdfmi.load(mbdfmi.__path__[0] + "/../models/pendulum.toml")

    with pytest.raises(ValueError, match="hydrostatics"):
        scene.righting()

    with pytest.raises(ValueError, match='"hull" do. Did you mean "hull"'):
        barge([60.0, 20.0, 8.0], 4.92e6, 5.0).righting("hul")


def test_the_command_draws_and_tells(tmp_path, capsys):
    from mbdfmi.cli import main

    path = tmp_path / "barge.toml"
    path.write_text(barge([60.0, 20.0, 8.0], 4.92e6, 5.0).to_toml())
    files = ["--plot", str(tmp_path / "gz.png"), "--csv", str(tmp_path / "gz.csv")]
    assert main(["gz", str(path), "--step", "10", *files]) == 0
    assert "rests: 0 deg" in capsys.readouterr().out
    assert (tmp_path / "gz.png").stat().st_size > 10_000
    assert main(["gz", str(path), "--axis", "up"]) == 1
