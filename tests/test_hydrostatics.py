"""Buoyancy of hulls at any angle: closed forms of boxes, prisms, caps of spheres; triangles against boxes; energy."""

import numpy as np
import pytest
import trimesh
from scenes import assert_near
from scipy.optimize import brentq

from mbdfmi import Scene, SceneError
from mbdfmi.compiler.model import compile_scene
from mbdfmi.run.instance import Instance
from mbdfmi.run.simulate import simulate

RHO, G = 1025.0, 9.80665
OUTPUTS = [
    "volume", "center_of_buoyancy", "draught", "waterplane_area", "waterplane_center", "waterplane_moments",
    "force", "moment", "power",
]  # fmt: skip


def floating(hull, position=(0, 0, 0), zyx=(0, 0, 0), mass=1e6, inertia=(1e8, 1e8, 1e8), **scene):
    """A body with a hull on a free joint."""
    start = {"position": list(position), "zyx_deg": list(zyx)} | scene.pop("start", {})
    return Scene.model_validate(
        {
            "name": "float",
            "gravity": [0, 0, -G],
            "body": {"hull": {"mass": mass, "inertia": list(inertia)}},
            "joint": {"sea": {"free": {}, "between": ["ground", "hull"], "start": start}},
            "force": {"water": {"hydrostatics": hull, "on": "hull", "output": OUTPUTS}},
        }
        | scene
    )


def of_hull(hull, position=(0, 0, 0), zyx=(0, 0, 0), **scene):
    """Outputs of a hull at a pose: by name, vectors as arrays."""
    instance = Instance(compile_scene(floating(hull, position, zyx, **scene)))
    found = {}

    for v, value in zip(instance.model.of_causality("output"), instance.outputs()):
        found.setdefault(v.name.removeprefix("water.").partition("[")[0], []).append(value)

    return {name: np.array(value) if len(value) > 1 else value[0] for name, value in found.items()}


def saved(mesh, tmp_path, name="hull.off"):
    """The options of a hull of a mesh, written with all its digits."""
    text = trimesh.exchange.off.export_off(mesh, digits=17)
    (tmp_path / name).write_text(text)
    return {"mesh": {"file": str(tmp_path / name)}}


# boxes


def clipped(corners):
    """(area, centroid) of the part below z = 0 of a polygon (n, 2) by the shoelace formula."""
    wet = []

    for a, b in zip(corners, np.roll(corners, -1, axis=0)):
        wet += [a] if a[1] <= 0 else []
        wet += [a + (b - a) * a[1] / (a[1] - b[1])] if a[1] * b[1] < 0 else []

    if not wet:
        return 0.0, np.zeros(2)

    p, q = np.array(wet), np.roll(wet, -1, axis=0)
    cross = p[:, 0] * q[:, 1] - q[:, 0] * p[:, 1]

    if not cross.any():
        return 0.0, np.zeros(2)

    return cross.sum() / 2, ((p + q) * cross[:, None]).sum(axis=0) / (3 * cross.sum())


def section(heel, z, breadth, depth):
    """Corners of a section of a box (y, z), turning left, heeled (rad) with its centre at z."""
    corners = np.array([[-1, -1], [1, -1], [1, 1], [-1, 1]]) / 2 * [breadth, depth]
    c, s = np.cos(heel), np.sin(heel)
    return corners @ np.array([[c, s], [-s, c]]) + [0, z]


@pytest.mark.parametrize("heel", range(0, 181, 5))
def test_a_box_has_the_righting_arm_of_its_clipped_section_at_every_heel(heel):
    """A barge 40 x 40 x 10 m with 4 m of draught; GZ about its centre."""
    length, breadth, depth, draught = 40.0, 40.0, 10.0, 4.0
    area = lambda z: clipped(section(np.radians(heel), z, breadth, depth))[0] - breadth * draught
    z = brentq(area, -20, 20, xtol=1e-14)
    wanted, centre = clipped(section(np.radians(heel), z, breadth, depth))
    found = of_hull({"box": {"size": [length, breadth, depth]}}, [0, 0, z], [0, 0, heel])
    assert_near(found["volume"] / length, wanted, 1e-12 * wanted)
    assert_near(found["center_of_buoyancy"], [0, *centre], 1e-12)
    assert_near(found["moment"][0] / found["force"][2], centre[0], 1e-12)
    assert_near(found["force"], [0, 0, RHO * G * found["volume"]], 1e-6)


@pytest.mark.parametrize("heel", [1.0, 5.0, 10.0, 16.0])
def test_a_box_keeps_to_the_wall_sided_formula(heel):
    """GZ = sin (GM + BM tan^2 / 2) until an edge goes under."""
    length, breadth, depth, draught = 90.0, 30.0, 12.0, 5.0
    a = np.radians(heel)
    z = -(draught - depth / 2) * np.cos(a)
    found = of_hull({"box": {"size": [length, breadth, depth]}}, [0, 0, z], [0, 0, heel])
    above = (
        depth / 2 - draught / 2
    )  # of the centre of the box, where its centre of mass is, over that of buoyancy
    metacentre = breadth**2 / (12 * draught)
    arm = np.sin(a) * (metacentre - above + metacentre * np.tan(a) ** 2 / 2)
    # heeled to starboard it sees its centre of buoyancy there, which turns it back
    assert_near(abs(found["center_of_buoyancy"][1]), arm, 1e-12)
    assert_near(found["waterplane_area"], length * breadth / np.cos(a), 1e-9)
    moments = np.array([breadth**3 * length / np.cos(a) ** 3, length**3 * breadth / np.cos(a), 0]) / 12
    assert_near(found["waterplane_moments"], moments, 1e-12 * moments.max())


@pytest.mark.parametrize("z, volume", [(20.0, 0.0), (-20.0, 6000.0), (5.0, 0.0), (-5.0, 6000.0)])
def test_a_box_in_the_air_and_under_water(z, volume):
    """Also with a face in the plane: nothing, and all of it."""
    found = of_hull({"box": {"size": [30, 20, 10]}}, [3, 4, z])
    assert_near(found["volume"], volume, 1e-11)
    assert_near(found["draught"], 5 - z, 1e-15)
    assert_near(found["waterplane_area"], 600 * (z == 5.0), 1e-12)
    assert_near(found["center_of_buoyancy"], [3, 4, z if volume else 0], 1e-13)


def test_a_hull_has_a_place_and_axes_of_its_own():
    """As on a marker that is there."""
    place = {"position": [1, 2, 3], "zyx_deg": [10, 20, 30]}
    size = {"box": {"size": [8, 5, 4]}}
    there = of_hull(size | place, [5, 6, -2.5], [40, 5, -7])
    body = {"hull": {"mass": 1, "inertia": [1, 1, 1], "marker": {"m": place}}}
    spec = floating(size, [5, 6, -2.5], [40, 5, -7]).model_dump(exclude_unset=True)
    spec["body"], spec["force"]["water"]["on"] = body, "hull.m"
    instance = Instance(compile_scene(Scene.model_validate(spec)))
    values = dict(zip([v.name for v in instance.model.of_causality("output")], instance.outputs()))
    assert_near(values["water.volume"], there["volume"], 1e-12)
    seen = [values[f"water.center_of_buoyancy[{k}]"] for k in (1, 2, 3)]
    assert_near(seen, there["center_of_buoyancy"], 1e-12)


# triangles


def test_triangles_of_one_box_displace_what_it_does(tmp_path):
    """However fine they are: its faces are put together again."""
    box = trimesh.creation.box([8.0, 5.0, 4.0])
    turns = [[0, 0, 0], [20, 30, 40], [0, 90, 5], [5, 0, 175]]
    poses = [([0, 0, z], zyx) for z in (-1.5, 0.3) for zyx in turns]

    for k in range(3):
        hull = saved(box, tmp_path, f"{k}.off")
        assert compile_scene(floating(hull)).n_polygon == 6

        for position, zyx in poses:
            wanted = of_hull({"box": {"size": [8, 5, 4]}}, position, zyx)
            found = of_hull(hull, position, zyx)

            for name in OUTPUTS:
                whole = RHO * G * 160
                size = whole if name in ("force", "moment", "power") else np.abs(wanted[name]).max()
                assert_near(found[name], wanted[name], 1e-12 * (1 + size))

        box = box.subdivide()


def of_cells(cells):
    """The mesh around unit cells, given by their lowest corners: two triangles on each outer side."""
    inside, corners, faces = set(cells), {}, []

    for cell in cells:
        for axis in range(3):
            for side in (0, 1):
                beyond = tuple(c + (2 * side - 1) * (k == axis) for k, c in enumerate(cell))

                if beyond not in inside:
                    u, v = (axis + 1) % 3, (axis + 2) % 3
                    steps = [(0, 0), (1, 0), (1, 1), (0, 1)][:: 2 * side - 1]
                    points = [np.array(cell) + side * np.eye(3)[axis] + i * np.eye(3)[u] + j * np.eye(3)[v]
                              for i, j in steps]  # fmt: skip
                    p = [corners.setdefault(tuple(point), len(corners)) for point in points]
                    faces += [[p[0], p[1], p[2]], [p[0], p[2], p[3]]]

    return trimesh.Trimesh(list(corners), faces, process=False)


DOCK = [(x, y, z) for x in range(4) for y in range(3) for z in range(2) if y == 0 or x in (0, 3)]
RING = [(x, y, z) for x in range(4) for y in range(3) for z in range(2) if y in (0, 2) or x in (0, 3)]


@pytest.mark.parametrize("cells, polygons", [(DOCK, 10), (RING, None)])
def test_faces_that_are_not_convex_or_have_holes(tmp_path, cells, polygons):
    """A dock, and a barge with a moonpool: as the sum of their cells. A face with a hole stays in triangles."""
    hull = saved(of_cells(cells), tmp_path)
    pose = [0.3, 0.2, -0.9], [30, 20, 25]
    found = of_hull(hull, *pose)
    wanted = [
        of_hull({"box": {"size": [1, 1, 1]}, "position": [c + 0.5 for c in cell]}, *pose) for cell in cells
    ]

    for key in ("volume", "waterplane_area", "force", "moment"):
        size = RHO * G if key in ("force", "moment") else 1.0
        assert_near(found[key], sum(one[key] for one in wanted), 1e-12 * size * len(cells))

    if polygons:
        assert compile_scene(floating(hull)).n_polygon == polygons


@pytest.mark.parametrize("height", [0.3, 1.0, 1.6])
def test_a_sphere_of_triangles_comes_to_the_cap(tmp_path, height):
    """V = pi h^2 (R - h / 3), A = pi h (2 R - h), the error a fourth with every halving of the triangles' size."""
    wanted = np.array([np.pi * height**2 * (1 - height / 3), np.pi * height * (2 - height)])
    errors = []

    for k in (3, 4):
        hull = saved(trimesh.creation.icosphere(k), tmp_path, f"{k}.off")
        found = of_hull(hull, [0, 0, 1 - height], [10, 20, 30])
        errors.append(np.array([found["volume"], found["waterplane_area"]]) / wanted - 1)

    assert np.abs(errors[1]).max() < 0.006
    assert_near(errors[0] / errors[1], 4.0, 0.8)


def test_a_cylinder_stands_and_lies():
    """Standing it displaces pi R^2 T; lying on its side half under, half; inclined as the wedge of a round one."""
    radius, length = 3.0, 20.0
    hull = {"cylinder": {"radius": radius, "length": length}}
    stands = of_hull(hull, [0, 0, -4])
    assert_near(stands["volume"], np.pi * radius**2 * 14, 1e-10)
    assert_near(stands["waterplane_area"], np.pi * radius**2, 1e-11)
    assert_near(stands["waterplane_moments"][:2] / (np.pi * radius**4 / 4), 1, 6e-7)
    lies = of_hull(hull, [0, 0, 0], [0, 90, 0])
    assert_near(lies["volume"], np.pi * radius**2 * length / 2, 1e-10)

    # upright and inclined: the plane cuts the side alone, and what is displaced is as much as by the axis
    inclined = of_hull(hull, [0, 0, 0], [0, 0, 30])
    assert_near(inclined["volume"], np.pi * radius**2 * length / 2, 1e-10)
    assert_near(inclined["waterplane_area"], np.pi * radius**2 / np.cos(np.radians(30)), 1e-10)


# motion


def test_small_heave_and_roll_have_the_periods_of_naval_architecture():
    """omega^2 = rho g A / m, and rho g V GM / I about the centre of mass, which is that of the box."""
    size, draught = np.array([20.0, 8.0, 4.0]), 2.5
    mass = RHO * size[0] * size[1] * draught
    height = size[1] ** 2 / 12 / draught - (size[2] / 2 - draught / 2)
    inertia = [2e6, 2e7, 2e7]
    scene = floating(
        {"box": {"size": list(size)}},
        [0, 0, size[2] / 2 - draught - 1e-4],
        [0, 0, 1e-3],
        mass,
        inertia,
        solver={"tolerance": 1e-11},
    )
    run = simulate(compile_scene(scene), 20.0, 0.1)
    heave, roll = np.sqrt(RHO * G * size[0] * size[1] / mass), np.sqrt(mass * G * height / inertia[0])
    volume = size[0] * size[1] * (draught + 1e-4 * np.cos(heave * run["time"]))
    assert_near(run["water.volume"], volume, 1e-7)  # by V phi^2 / 2 it is not heave alone
    moment = -mass * G * height * np.radians(1e-3) * np.cos(roll * run["time"])
    assert_near(run["water.moment"][:, 0], moment, 1e-4 * np.ptp(moment))


@pytest.mark.parametrize("formulation", ["recursive", "embedding", "augmented"])
def test_a_hull_that_rolls_over_keeps_its_energy(formulation):
    """Free, without anything that damps, out of the water and under it."""
    scene = floating(
        {"box": {"size": [6, 4, 3]}},
        [0, 0, 1.0],
        [20, 35, 70],
        4e4,
        [8e4, 1.3e5, 1.5e5],
        solver={"tolerance": 1e-10, "integrator": "rk54", "formulation": formulation},
        output=["total_energy", "spring_energy", "potential_energy"],
        start={"velocity": [1, 0.5, -2], "omega": [0.5, 0.2, 0.1]},
    )
    run = simulate(compile_scene(scene), 3.0, 0.05)
    energy = run["total_energy"]
    assert_near(energy, energy[0], 1e-7 * np.ptp(run["spring_energy"]))
    assert np.ptp(run["spring_energy"]) > 1e4


# mistakes


def test_gravity_that_does_not_press_water_down_is_told():
    with pytest.raises(
        SceneError, match=r"\[force.water\] hydrostatics.*along -z; found gravity \[0.0, 1.0, -9.8\]"
    ):
        floating({"box": {"size": [1, 1, 1]}}, gravity=[0, 1, -9.8])


def test_a_hull_with_a_hole_is_told(tmp_path):
    mesh = trimesh.creation.box([1, 1, 1])
    mesh.update_faces(np.arange(12) > 0)

    with pytest.raises(SceneError, match=r"hole of 3 corners.*a hull needs a closed surface"):
        floating(saved(mesh, tmp_path))


@pytest.mark.parametrize(
    "hull, words",
    [
        ({}, 'needs "box", "cylinder" or "mesh"'),
        ({"box": {"size": [1, 1, 1]}, "cylinder": {"radius": 1, "length": 1}}, "exclude each other"),
        ({"cylinder": {"radius": 1, "length": 1, "sides": 2.5}}, "whole number from 3 to 1000, found 2.5"),
        ({"boxx": {"size": [1, 1, 1]}}, 'Did you mean "box"'),
    ],
)
def test_hulls_that_are_none_are_told(hull, words):
    with pytest.raises(SceneError, match=words):
        floating(hull)
