"""What is shown is what was run: numbers of the GLB and of the page, read back; the page in a real browser."""

import base64
import gzip
import json
import re
import shutil
import struct
import subprocess
import zipfile
import zlib
from pathlib import Path
from types import SimpleNamespace

import numpy as np
import pytest
from scipy.spatial.transform import Rotation

import mbdfmi
from mbdfmi.cli import main
from mbdfmi.run.states import States
from mbdfmi.scene import curves as scene_curves
from mbdfmi.scene import surfaces
from mbdfmi.scene.looks import red_green_blue
from mbdfmi.view import curves, forms, glb
from mbdfmi.view import page as page_module
from mbdfmi.view.contents import PALETTE
from mbdfmi.view.curves import SURFACES
from mbdfmi.view.drawing import draw
from mbdfmi.view.picture import picture
from mbdfmi.view.runs import at_start
from tests.model_files import SCENES

ROOT = Path(__file__).parents[1]
MODELS = ROOT / "models"
TURBINE = MODELS / "floating_wind_turbine" / "floating_wind_turbine.toml"


def load(name):
    return mbdfmi.load(TURBINE if name == "turbine" else MODELS / f"{name}.toml")


def poses(data):
    """{body: (r (n, 3), A (n, 3, 3))} in the inertial frame or the ground's, and times, as the nodes of a GLB say."""
    document, arrays = glb.read(data)
    nodes = document["nodes"]
    moves, times = {}, np.zeros(1)

    for animation in document.get("animations", []):
        for channel in animation["channels"]:
            sampler = animation["samplers"][channel["sampler"]]
            times = arrays[sampler["input"]]
            moves[channel["target"]["node"], channel["target"]["path"]] = arrays[sampler["output"]].astype(
                float
            )

    found = {}

    def walk(index, r, A):
        node = nodes[index]
        own_r = moves.get((index, "translation"), np.array([node.get("translation", [0, 0, 0])]))
        own_A = Rotation.from_quat(
            moves.get((index, "rotation"), np.array([node.get("rotation", [0, 0, 0, 1])]))
        ).as_matrix()
        r, A = r + np.einsum("nij,nj->ni", A, np.broadcast_to(own_r, (len(times), 3))), A @ own_A

        if node.get("extras", {}).get("kind") == "body":
            found[node["name"]] = r, A

        for child in node.get("children", []):
            walk(child, r, A)

    (root,) = document["scenes"][0]["nodes"]
    turn = Rotation.from_quat(nodes[root]["rotation"]).as_matrix()

    for child in nodes[root]["children"]:
        walk(child, np.zeros((len(times), 3)), np.tile(np.eye(3), (len(times), 1, 1)))

    return times, found, turn


@pytest.mark.parametrize(
    "name", ["four_bar", "turbine", "bricard", "marble_run", "spinning_hoop", "satellite", "turning_track"]
)
def test_poses_in_the_glb_are_those_of_the_run(name, check):
    scene = load(name)
    results = scene.simulate(1.0, 0.05)
    shown = picture(scene, results.states)
    times, found, _ = poses(shown.glb())
    np.testing.assert_allclose(times, results["time"], atol=1e-6)
    assert set(found) == {"ground", *scene.body}
    still = scene.ground.motion and scene.view.frame != "inertial"
    base_r, base_q = results.poses("ground" if still else "inertial")
    base = Rotation.from_quat(base_q)

    for body in scene.body:
        r, q = results.poses(body)
        here_r, here_A = (np.broadcast_to(value, (len(r), *value.shape[1:])) for value in found[body])
        there_r = base.inv().apply(r - base_r)
        check(np.abs(here_r - there_r).max() / max(shown.size, np.abs(there_r).max()), 1e-6)
        check(np.abs(here_A - (base.inv() * Rotation.from_quat(q)).as_matrix()).max(), 1e-6)


def test_states_give_what_outputs_gave():
    scene = load("turbine")
    results = scene.simulate(3.0, 0.1, inputs={"shaft.torque": lambda t: -1e6 * np.sin(t)})
    r, q = results.poses("hub")
    np.testing.assert_array_equal(r, results["hub.position"])
    yaw_pitch_roll = Rotation.from_quat(results.poses("platform")[1]).as_euler("ZYX")
    np.testing.assert_allclose(yaw_pitch_roll, results["platform.zyx"], atol=1e-12)


@pytest.mark.parametrize(("wrong", "right"), [("lowr", "lower"), ("lower.hnd", "lower.hand")])
def test_poses_of_what_is_not_there_name_what_is(wrong, right):
    results = mbdfmi.load("models/two_link_arm.toml").simulate(0.01)

    with pytest.raises(KeyError, match=f"no body or marker '{wrong}'.*{right}"):
        results.poses(wrong)


def test_commanded_motion_is_drawn_where_it_was():
    scene = mbdfmi.Scene(
        name="lift",
        body={
            "car": {"mass": 1.0, "inertia": [1, 1, 1], "output": ["position"]},
            "bob": {
                "mass": 1.0,
                "inertia": [1, 1, 1],
                "marker": {"top": {"position": [0, 0, 1]}},
                "output": ["position"],
            },
        },
        joint={
            "rail": {
                "prismatic": {"axis": "z"},
                "between": ["ground", "car"],
                "driver": {"input": ["position"]},
            },
            "pin": {"revolute": {"axis": "y"}, "between": ["car", "bob.top"], "start": {"angle_deg": 20}},
        },
    )
    results = scene.simulate(2.0, 0.1, inputs={"rail.position_command": lambda t: 0.5 * np.sin(t)})
    for body in ("car", "bob"):
        np.testing.assert_allclose(results.poses(body)[0], results[f"{body}.position"], atol=1e-12)


def test_up_is_against_gravity():
    for gravity, up in (([0, 0, -9.81], "z"), ([0, -9.81, 0], "y"), ([3, 0, 0], "-x"), ([0, 9.81, 0], "-y")):
        scene = mbdfmi.Scene(
            name="up",
            gravity=gravity,
            body={"a": {"mass": 1, "inertia": [1, 1, 1]}},
            joint={"j": {"free": {}, "between": ["ground", "a"]}},
        )
        _, _, turn = poses(picture(scene, at_start(scene.compile()).states).glb())
        axis = {"x": [1, 0, 0], "y": [0, 1, 0], "z": [0, 0, 1]}[up[-1]]
        np.testing.assert_allclose(turn @ axis, [0, -1 if up[0] == "-" else 1, 0], atol=1e-6)


@pytest.mark.parametrize("surface", [
    forms.box(), forms.sphere(), forms.cylinder(), forms.tube(1, 0.5, 2), forms.capsule(1, 2), forms.cone(1, 0, 2),
    forms.cone(1, 0.5, 2), forms.rod([0, 0, 0], [1, 2, 3], 0.1),
])  # fmt: skip
def test_forms_are_closed_and_face_outwards(surface):
    trimesh = pytest.importorskip("trimesh")
    mesh = trimesh.Trimesh(surface.points.round(12), surface.faces)
    mesh.merge_vertices()
    assert mesh.is_watertight and mesh.is_winding_consistent and mesh.volume > 0
    corners = surface.points[surface.faces]
    flat = np.cross(corners[:, 1] - corners[:, 0], corners[:, 2] - corners[:, 0])
    assert ((flat[:, None] * surface.normals[surface.faces]).sum(axis=2) > 0).all()
    np.testing.assert_allclose(np.linalg.norm(surface.normals, axis=1), 1.0, atol=1e-9)


def test_a_box_of_equal_inertia_stands_for_what_has_no_shape():
    inertia = [3 * (4 + 1) / 12, 3 * (9 + 1) / 12, 3 * (9 + 4) / 12]  # of a box of 3, 2, 1 m, 3 kg
    body = {"mass": 3.0, "com": [1, 0, 0], "inertia": inertia}
    scene = mbdfmi.Scene(name="box", body={"a": body}, joint={"j": {"free": {}, "between": ["ground", "a"]}})
    (piece,) = [p for p in picture(scene, at_start(scene.compile()).states).pieces if p.opacity < 1]
    np.testing.assert_allclose(np.ptp(piece.surface.points, axis=0), [3, 2, 1], rtol=1e-9)


def parts(text):
    """What a page holds: (GLB, what is told of it)."""
    glb_text, info = (re.search(f'id="{name}">([^<]*)<', text)[1] for name in ("glb", "info"))
    return gzip.decompress(base64.b64decode(glb_text)), json.loads(gzip.decompress(base64.b64decode(info)))


def test_a_page_holds_the_run_and_is_small(tmp_path, check):
    scene = load("four_bar")
    results = scene.simulate(5.0)
    path = results.view(tmp_path / "run.html")
    text = path.read_text()
    assert path.stat().st_size < 300_000
    assert not re.search(r'(src|href)="(?!data:)', text)
    binary, info = parts(text)
    _, found, _ = poses(binary)
    for body in scene.body:
        check(np.abs(found[body][0] - results.poses(body)[0]).max() / 2.5, 1e-6)
    names = {item["name"] for item in info["plots"]["items"]}
    assert {"crank_pivot.angle", "coupler.tool.position"} <= names


def test_ten_minutes_of_the_turbine_are_less_than_two_megabytes(tmp_path):
    scene = load("turbine")
    path = scene.simulate(600.0, 0.1).view(tmp_path / "run.html")
    assert path.stat().st_size < 2_000_000


def test_a_page_of_too_few_rows_says_so(tmp_path):
    scene = mbdfmi.Scene(
        name="fan", body={"a": {"mass": 1, "inertia": [1, 1, 1]}},
        joint={"j": {"revolute": {}, "between": ["ground", "a"], "driver": {"constant_speed_rpm": 600}}},
    )  # fmt: skip
    _, info = parts(scene.simulate(1.0, 0.04).view(tmp_path / "a.html").read_text())
    assert any("a may turn further between two rows" in note for note in info["notes"])
    _, info = parts(scene.simulate(1.0, 0.01).view(tmp_path / "a.html").read_text())
    assert info["notes"] == []


def test_commands(tmp_path, capsys):
    page, run, binary = tmp_path / "a.html", tmp_path / "run.html", tmp_path / "a.glb"
    assert main(["view", str(MODELS / "four_bar.toml"), "-o", str(page)]) == 0
    assert main(["view", str(MODELS / "four_bar.toml"), "-o", str(binary)]) == 0
    assert main(["simulate", str(MODELS / "four_bar.toml"), "--until", "0.5", "--view", str(run)]) == 0
    assert parts(page.read_text())[1]["times"] is None
    assert parts(run.read_text())[1]["times"] == [0.0, 0.5]
    assert glb.read(binary.read_bytes())[0]["asset"]["version"] == "2.0"
    assert main(["view", str(MODELS / "four_bar.toml"), "-o", str(tmp_path / "a.step")]) == 1
    assert "which is no .step file" in capsys.readouterr().err
    assert main(["simulate", str(MODELS / "four_bar.toml"), "--until", "0.5", "--view", "a.view"]) == 1
    assert "let its name end in .html" in capsys.readouterr().err


def pixels(path):
    """(height, width, 3) of a PNG file as written here."""
    data = path.read_bytes()
    assert data.startswith(b"\x89PNG\r\n\x1a\n")
    width, height = struct.unpack(">II", data[16:24])
    at, found = 8, b""
    while at < len(data):
        (length,) = struct.unpack(">I", data[at : at + 4])
        found += data[at + 8 : at + 8 + length] if data[at + 4 : at + 8] == b"IDAT" else b""
        assert (
            zlib.crc32(data[at + 4 : at + 8 + length])
            == struct.unpack(">I", data[at + 8 + length : at + 12 + length])[0]
        )
        at += 12 + length
    return (
        np.frombuffer(zlib.decompress(found), np.uint8).reshape(height, -1)[:, 1:].reshape(height, width, 3)
    )


def test_a_picture_without_a_browser(tmp_path, capsys, monkeypatch):
    monkeypatch.setenv("MBDFMI_BROWSER", "/nowhere")
    file = tmp_path / "a.png"
    command = ["simulate", str(MODELS / "four_bar.toml"), "--until", "1", "--view", str(file)]
    assert main([*command, "--at", "0.5"]) == 0
    assert "without names" in capsys.readouterr().err
    # each body's colour is there
    colours = pixels(file).reshape(-1, 3) / 255
    for colour in PALETTE[:3]:
        hue = np.array(red_green_blue(colour))
        assert ((colours @ hue / np.linalg.norm(colours, axis=1) / np.linalg.norm(hue)) > 0.999).sum() > 500
    assert main([*command, "--at", "2"]) == 1
    assert "the run is from 0 to 1 s" in capsys.readouterr().err
    assert main([*command[:-1], str(tmp_path / "a.html"), "--at", "0.5"]) == 1
    assert "a time (--at) is that of a picture" in capsys.readouterr().err
    assert main([*command[:4], "--at", "0.5"]) == 1
    assert "write --view FILE.png" in capsys.readouterr().err


def test_a_sphere_is_drawn_as_a_disc_where_it_is():
    ball = {"mass": 1.0, "inertia": [1, 1, 1], "shape": {"sphere": {"radius": 0.5}}, "colour": "#ff0000"}
    scene = mbdfmi.Scene(
        name="ball", view={"ground": "none", "look_from": [0, -1, 0]}, body={"a": ball},
        joint={"j": {"free": {}, "between": ["ground", "a"]}},
    )  # fmt: skip
    shown = picture(scene, at_start(scene.compile()).states)
    image = draw(shown, 0, 200, 200).astype(float)
    red = image[:, :, 0] > image[:, :, 1] + 60
    rows, columns = np.nonzero(red)
    np.testing.assert_allclose([rows.mean(), columns.mean()], [99.5, 99.5], atol=0.6)
    # the outline of a ball at a distance D : tan of half the angle is R / sqrt(D^2 - R^2)
    distance = 0.95 * shown.reach[1] / np.sin(np.radians(17.5))
    radius = 100 / np.tan(np.radians(17.5)) * 0.5 / np.sqrt(distance**2 - 0.25)
    np.testing.assert_allclose(np.sqrt(red.sum() / np.pi), radius, rtol=0.02)


def test_what_a_plot_cannot_show_is_told(tmp_path):
    scene = load("four_bar")
    scene.view = {"plots": ["crank_pivot.angel"]}
    with pytest.raises(ValueError, match=r"\[view\] plots: no column 'crank_pivot.angel'.*crank_pivot.angle"):
        scene.simulate(0.1).view(tmp_path / "a.html")


def test_notebooks_get_the_page():
    scene = load("pendulum")
    for shown in (scene, scene.simulate(0.1)):
        text = shown._repr_html_()
        assert text.startswith("<iframe srcdoc=") and "&lt;!DOCTYPE html&gt;" in text


@pytest.mark.skipif(
    not (shutil.which("node") and (ROOT / "viewer" / "node_modules" / "gltf-validator").exists()),
    reason="node and gltf-validator are not there: cd viewer && npm install",
)
@pytest.mark.parametrize("name", ["four_bar", "turbine", "marble_run", "rolling_disk", "moored_buoy"])
def test_the_glb_is_valid(tmp_path, name):
    scene = load(name)
    path = scene.simulate(0.5).view(tmp_path / "a.glb")
    code = (
        "const v = require('gltf-validator');"
        "v.validateBytes(new Uint8Array(require('fs').readFileSync(process.argv[1]))).then(r => console.log(JSON.stringify(r.issues)))"
    )
    found = subprocess.run(
        ["node", "-e", code, str(path)], cwd=ROOT / "viewer", capture_output=True, text=True, check=True
    )
    assert json.loads(found.stdout)["messages"] == []


def test_an_fmu_carries_the_pictures_of_its_scene(tmp_path):
    load("four_bar").export(tmp_path / "a.fmu")
    with zipfile.ZipFile(tmp_path / "a.fmu") as archive:
        for name, size in (("model.png", (125, 200)), ("documentation/scene.png", (250, 400))):
            file = tmp_path / "picture.png"
            file.write_bytes(archive.read(name))
            image = pixels(file)
            assert image.shape[:2] == size
            hue = np.array(red_green_blue(PALETTE[1]))
            colours = image.reshape(-1, 3) / 255
            assert (
                (colours @ hue / np.linalg.norm(colours, axis=1) / np.linalg.norm(hue)) > 0.99
            ).sum() > 100
        assert b'src="scene.png"' in archive.read("documentation/index.html")


def test_an_fmu_of_a_scene_that_cannot_be_drawn_says_so(tmp_path):
    said = []
    scene = load("pendulum").model_copy(deep=True)
    next(iter(scene.body.values())).shape = {"mesh": {"file": str(tmp_path / "none.stl")}}
    scene.export(tmp_path / "a.fmu", progress=said.append)
    assert any("without a picture of the scene" in text and "none.stl" in text for text in said)


def test_the_gallery_has_every_scene():
    gallery = ROOT / "docs" / "gallery"
    index = (gallery / "README.md").read_text(encoding="utf-8")
    for path in SCENES:
        assert pixels(gallery / f"{path.stem}.png").shape == (300, 480, 3)
        _, info = parts((gallery / f"{path.stem}.html").read_text(encoding="utf-8"))
        assert info["title"] == mbdfmi.load(path).title
        assert f"({path.stem}.png)" in index


def test_every_kind_of_curve_and_surface_is_drawn_where_it_is():
    def kinds(module):
        return {
            cls.kind
            for cls in vars(module).values()
            if isinstance(cls, type) and isinstance(getattr(cls, "kind", None), str)
        }

    given = {
        "plane": ({}, lambda x, y, z: z),
        "sphere": ({"radius": 2.0}, lambda x, y, z: x**2 + y**2 + z**2 - 4),
        "ellipsoid": ({"semi_axes": [1.0, 2.0, 3.0]}, lambda x, y, z: x**2 + y**2 / 4 + z**2 / 9 - 1),
        "cylinder": ({"radius": 0.5}, lambda x, y, z: x**2 + y**2 - 0.25),
        "torus": ({"radius": 2.0, "tube": 0.5}, lambda x, y, z: (np.hypot(x, y) - 2) ** 2 + z**2 - 0.25),
        "disk": (
            {"radius": 1.0},
            lambda x, y, z: np.maximum(np.hypot(x, y), 1) - 1 + np.maximum(abs(z), 0.006) - 0.006,
        ),
        "prism": ({"profile": {"parabola": {"coefficient": 2.0}}}, lambda x, y, z: y - 2 * x**2),
        "table": (
            {
                "s1": [0, 1, 2, 3],
                "s2": [0, 1, 2, 3],
                "points": [[[i, j, i * j] for j in range(4)] for i in range(4)],
            },
            lambda x, y, z: z - x * y,
        ),
    }
    assert set(given) == kinds(surfaces) == set(SURFACES)
    for kind, (options, equation) in given.items():
        (shape,) = holder(surface={kind: options})
        drawn = curves.surface(shape.surface, 3.0)
        np.testing.assert_allclose(equation(*drawn.points.T), 0, atol=1e-9)

    given = {
        "line": ({}, lambda x, y, z: abs(y) + abs(z)),
        "circle": ({"radius": 2.0}, lambda x, y, z: x**2 + y**2 - 4),
        "parabola": ({"coefficient": 0.5}, lambda x, y, z: y - 0.5 * x**2),
        "cycloid": ({"radius": 1.0}, lambda x, y, z: np.abs(x) - np.arccos(1 - y) - np.sin(np.arccos(1 - y))),
        "spline": ({"points": [[0, 0, 0], [1, 1, 1], [2, 2, 2]]}, lambda x, y, z: abs(y - x) + abs(z - x)),
        "table": (
            {"s": [0, 1, 3], "points": [[0, 0, 0], [1, 0, 1], [3, 0, 3]]},
            lambda x, y, z: abs(z - x) + abs(y),
        ),
    }
    assert set(given) == kinds(scene_curves)
    for kind, (options, equation) in given.items():
        (shape,) = holder(curve={kind: options})
        np.testing.assert_allclose(equation(*curves.curve_points(shape.curve, 3.0).T), 0, atol=1e-7)


def holder(**marker):
    """The markers of a scene that has this one."""
    body = {"mass": 1.0, "inertia": [1, 1, 1], "marker": {"m": marker}}
    return (
        mbdfmi.Scene(name="m", body={"a": body}, joint={"j": {"free": {}, "between": ["ground", "a"]}})
        .body["a"]
        .marker.values()
    )


def test_a_run_of_an_fmu_by_fmpy_can_be_drawn(tmp_path):
    import fmpy

    scene = load("four_bar")
    scene.export(tmp_path / "a.fmu")
    recorder = scene.recorder()
    fmpy.simulate_fmu(str(tmp_path / "a.fmu"), stop_time=1.0, output_interval=0.05, step_finished=recorder)
    results = recorder.results()
    there = scene.simulate(1.0, 0.05)
    np.testing.assert_allclose(results["time"], there["time"][1:], atol=1e-12)
    for body in scene.body:
        np.testing.assert_allclose(results.poses(body)[0], there.poses(body)[0][1:], atol=1e-9)
    np.testing.assert_allclose(results["crank_pivot.angle"], there["crank_pivot.angle"][1:], atol=1e-9)
    assert results.view(tmp_path / "a.html").stat().st_size > 100_000
    with pytest.raises(ValueError, match="another scene"):
        load("pendulum").recorder().keep(recorder._kept[0])
    for damaged in (b"", recorder._kept[0][:60], recorder._kept[0][8:]):
        with pytest.raises(ValueError, match="no state of an FMU"):
            recorder.keep(damaged)
    with pytest.raises(ValueError, match="has format 2.*export the FMU anew"):
        recorder.keep(recorder._kept[0][:16] + b"\2" + recorder._kept[0][17:])


def test_states_of_long_runs_of_many_bodies_are_small():
    def stored(n_q, n_v, n):
        model = SimpleNamespace(n_x=n_q + n_v, n_q=n_q, n_v=n_v, n_u=0, n_command=0)
        states = States(model, n)
        return states._x.nbytes, states._x.dtype.itemsize, states.has_velocities

    # hinges: every digit; floating bodies: seven digits, no velocities
    assert stored(1000, 1000, 10_000) == (160_000_000, 8, True)
    assert stored(7000, 6000, 10_000) == (280_000_000, 4, False)


def test_a_page_of_a_very_long_run_holds_some_of_its_rows(tmp_path, monkeypatch):
    monkeypatch.setattr(page_module, "POSES", 28 * 3 * 60)
    scene = load("four_bar")
    _, info = parts(scene.simulate(1.0, 0.01).view(tmp_path / "a.html").read_text())
    assert "the picture shows 60 of the 101 rows of the run" in info["notes"]
    assert info["times"] == [0.0, 1.0]
