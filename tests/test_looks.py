"""Looks move no number; what a mesh encloses has the mass properties of the solid that it is."""

import numpy as np
import pytest
import trimesh

import mbdfmi
from mbdfmi.scene import SceneError

BODY = {"mass": 1.0, "inertia": [1.0, 1.0, 1.0]}
FREE = {"j": {"free": {}, "between": ["ground", "a"]}}


def scene(**body):
    return mbdfmi.Scene(name="looks", body={"a": body}, joint=FREE)


def box_mesh(path, faces=None):
    """A box of 200 x 300 x 500 mm away from the origin as a file; `faces`: how many of its 12 triangles."""
    mesh = trimesh.creation.box(
        extents=[200, 300, 500], transform=trimesh.transformations.translation_matrix([50, 60, 70])
    )
    mesh.update_faces(np.arange(12) < (faces or 12))
    mesh.export(path)
    return str(path)


@pytest.mark.parametrize("ending", ["stl", "obj", "ply", "glb"])
def test_a_mesh_weighs_what_the_solid_weighs(tmp_path, ending):
    file = box_mesh(tmp_path / f"box.{ending}")
    place = {"position": [1, 2, 3], "zyx_deg": [10, 20, 30]}
    mesh = scene(solid={"mesh": {"file": file, "scale": 0.001, "density": 700}} | place).body["a"]
    # the box at its centre, within the mesh's frame
    frame = mbdfmi.Scene(name="f", body={"a": BODY | {"marker": {"m": place}}}, joint=FREE).marker_pose("a.m")
    centre = frame[1] + frame[2] @ [0.05, 0.06, 0.07]
    solid = scene(
        solid={"box": {"size": [0.2, 0.3, 0.5], "density": 700}} | place | {"position": centre}
    ).body["a"]

    for one, other in zip(mesh.mass_properties(), solid.mass_properties()):
        np.testing.assert_allclose(one, other, rtol=1e-6, atol=1e-7)


def test_a_mirrored_mesh_has_positive_mass(tmp_path):
    file = box_mesh(tmp_path / "box.stl")
    mass, com, _ = (
        scene(solid={"mesh": {"file": file, "scale": [0.001, 0.001, -0.001], "density": 700}})
        .body["a"]
        .mass_properties()
    )
    assert np.isclose(mass, 700 * 0.2 * 0.3 * 0.5)
    np.testing.assert_allclose(com, [0.05, 0.06, -0.07], atol=1e-9)


def test_a_mesh_with_a_hole_is_refused_and_the_hole_named(tmp_path):
    file = box_mesh(tmp_path / "box.stl", faces=10)

    with pytest.raises(SceneError) as refused:
        scene(solid={"mesh": {"file": file, "scale": 0.001, "density": 700}})

    (text,) = refused.value.errors
    assert text.startswith(f"[body.a] solid.mesh: {file}: has a hole of 4 corners around [")
    assert text.endswith("a solid needs a closed surface (as a look it will do)")


@pytest.mark.parametrize("content", [b"", b"solid x\nendsolid x\n", b"nonsense" * 40])
def test_a_file_that_is_no_mesh_is_named(tmp_path, content):
    file = tmp_path / "bad.stl"
    file.write_bytes(content)

    with pytest.raises(SceneError, match="bad.stl: (is no mesh|holds no triangles)"):
        scene(solid={"mesh": {"file": str(file), "mass": 1}})


def test_files_start_at_the_folder_of_the_scene(tmp_path, monkeypatch):
    (tmp_path / "parts").mkdir()
    box_mesh(tmp_path / "parts" / "box.stl")
    text = (
        scene(**BODY)
        .to_toml()
        .replace(
            "mass = 1.0\ninertia = [1.0, 1.0, 1.0]", 'solid = { mesh = { file = "parts/box.stl", mass = 2 } }'
        )
    )
    (tmp_path / "a.toml").write_text(text)
    made = mbdfmi.load(tmp_path / "a.toml")
    assert made.body["a"].mass_properties()[0] == 2

    # also when it is checked again, elsewhere
    monkeypatch.chdir("/")
    made.body["a"].solid[0].mesh.mass = 3
    made.compile()
    assert made.body["a"].mass_properties()[0] == 3
    assert '"parts/box.stl"' in made.to_toml()


def test_looks_are_no_part_of_the_model():
    plain = scene(**BODY)
    looks = mbdfmi.Scene(
        name="looks",
        view={"up": "y", "water": 1.0, "frame": "a", "paths": ["a"], "plots": ["x"]},
        ground={"colour": "grey", "shape": {"box": {"size": [1, 1, 1]}}},
        body={
            "a": BODY | {"colour": "red", "shape": [{"mesh": {"file": "nowhere.stl"}}, {"line": ["a", "a"]}]}
        },
        joint=FREE,
    )
    assert looks.compile().guid == plain.compile().guid


def test_parts_of_a_mesh_have_their_own_colours_and_textures_are_none(tmp_path):
    """Materials of two parts, in a file whose other part has none."""
    from mbdfmi.view.contents import pieces

    red = trimesh.visual.material.PBRMaterial(baseColorFactor=[255, 0, 0, 255])
    blue = trimesh.visual.material.PBRMaterial(baseColorFactor=[0, 51, 255, 255])
    boxes = []
    for k, material in enumerate((red, blue, None)):
        box = trimesh.creation.box(transform=trimesh.transformations.translation_matrix([2 * k, 0, 0]))
        if material:
            box.visual = trimesh.visual.TextureVisuals(uv=np.zeros((8, 2)), material=material)
        boxes.append(box)
    file = str(tmp_path / "parts.glb")
    trimesh.Scene(boxes).export(file)

    def colours(**more):
        made = scene(**BODY, shape={"mesh": {"file": file}} | more, colour="#00ff00")
        return {
            round(p.surface.points[:, 0].mean() / 2): p.colour for p in pieces(made, 1.0) if p.body == "a"
        }

    assert colours() == {0: (1, 0, 0), 1: (0, 0.2, 1), 2: (0, 1, 0)}
    assert set(colours(colour="white").values()) == {(1, 1, 1)}

    # corners of an OBJ file with places in a picture, and no picture
    (tmp_path / "parts.obj").write_text("v 0 0 0\nv 1 0 0\nv 0 1 0\nvt 0 0\nvt 1 0\nvt 0 1\nf 1/1 2/2 3/3\n")
    file = str(tmp_path / "parts.obj")
    assert set(colours().values()) == {(0, 1, 0)}


@pytest.mark.parametrize("command", ["check", "view", "simulate"])
def test_a_look_that_cannot_be_read_is_told_with_its_place(tmp_path, capsys, command):
    from mbdfmi.cli import main

    made = scene(
        **BODY,
        shape=[{"sphere": {"radius": 1}}, {"mesh": {"file": "no.stl"}}],
        marker={"m": {"shape": {"mesh": {"file": "nor.stl"}}}},
    )
    file = tmp_path / "a.toml"
    file.write_text(made.to_toml())
    more = {
        "check": [],
        "view": ["-o", str(tmp_path / "a.html")],
        "simulate": ["--until", "1", "--view", str(tmp_path / "a.html")],
    }
    assert main([command, str(file), *more[command]]) == 1
    told = capsys.readouterr().err
    assert f"{file}: [body.a] shape[2].mesh: {tmp_path / 'no.stl'}: No such file" in told
    assert f"{file}: [body.a.marker.m] shape.mesh: {tmp_path / 'nor.stl'}: No such file" in told


def test_import_of_a_scene_says_that_it_is_one(tmp_path, capsys, monkeypatch):
    from mbdfmi.cli import main

    (tmp_path / "a.toml").write_text(scene(**BODY).to_toml())
    monkeypatch.chdir(tmp_path)
    assert main(["import", "a.toml"]) == 1
    assert "is a scene file already" in capsys.readouterr().err
