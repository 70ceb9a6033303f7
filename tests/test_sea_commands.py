"""mbdfmi rao, moorings and sea --plot: beside the frequency domain, runs, closed forms; what is drawn and refused."""

import numpy as np
import pytest
from scenes import assert_near
from test_hydrodynamics import INERTIA, INFINITE, MASS, STIFF, afloat, exciting, files, response

from mbdfmi import Scene
from mbdfmi.analysis.moorings import moorings
from mbdfmi.analysis.rao import rao
from mbdfmi.cli import main


@pytest.fixture(scope="module")
def database(tmp_path_factory):
    return files(tmp_path_factory.mktemp("database"))


ANSWERS = [f"position[{k}]" for k in (1, 2, 3)] + [f"zyx[{k}]" for k in (3, 2, 1)]


def test_answers_are_those_of_the_frequency_domain(database):
    """(-w^2 (M + A) + i w B + K) X = F with the true A, B, F: amplitude and phase, in six motions."""
    scene = afloat(database, outputs=[], radiation={"error": 0.001})
    scene.body["hull"].output = ["position", "zyx"]
    omega = np.array([0.3, 0.7, 0.9, 1.2, 1.8])
    found = rao(scene, omega, np.radians(30))
    inertia = np.diag([MASS] * 3 + INERTIA) + INFINITE

    for w, H, answer in zip(omega, response(omega), found.answers):
        wanted = np.linalg.solve(-w * w * inertia + 1j * w * H + STIFF, exciting(w, np.radians(30)))
        # roll, pitch, yaw are the third, second and first of the angles
        told = answer[[found.outputs.index(f"hull.{name}") for name in ANSWERS]]
        assert_near(told[:3] / np.abs(wanted[:3]).max(), wanted[:3] / np.abs(wanted[:3]).max(), 0.01)
        assert_near(told[3:] / np.abs(wanted[3:]).max(), wanted[3:] / np.abs(wanted[3:]).max(), 0.01)


def test_a_run_in_waves_comes_to_its_answer(database):
    """Heave, which is damped, in a wave of 5 cm: amplitude and phase of the last periods."""
    waves = {"regular": {"height": 0.1, "period": 7.0}}
    scene = afloat(database, sea={"waves": waves}, outputs=[])
    run = scene.simulate(140, 0.1)
    late = run["time"] >= 140 - 4 * 7.0 - 1e-9
    time, z = run["time"][late][:-1], run["hull.position"][late, 2][:-1]
    answer = 2 * np.mean(z * np.exp(-2j * np.pi * time / 7.0)) / 0.05
    found = rao(scene, [2 * np.pi / 7.0], outputs=["hull.position"])
    assert_near(found.answers[0, 2], answer, 0.01 * abs(answer))


def test_what_feels_no_waves_and_periods_that_nobody_knows_are_told(database, tmp_path, capsys):
    scene = afloat(database, outputs=[], excitation=False)
    with pytest.raises(ValueError, match="nothing in it feels waves"):
        rao(scene, [1.0])
    found = rao(afloat(database, outputs=[]), [0.01, 1.0])
    assert not any("linear answers say little" in text for text in found.notices)
    slack = afloat(database, outputs=[])
    slack.body["hull"].output = ["zyx"]
    slack.force["hold"].linear.stiffness = (STIFF * 1e-6).tolist()
    assert any("linear answers say little" in text for text in rao(slack, [0.05]).notices)
    assert any("excitation is known for periods from 0.5236 to 157.1 s" in text for text in found.notices)
    path = tmp_path / "scene.toml"
    path.write_text(afloat(database, outputs=[]).to_toml())
    out = [str(tmp_path / name) for name in ("rao.png", "rao.csv")]
    pytest.importorskip("matplotlib")
    assert main(["rao", str(path), "--plot", out[0], "--csv", out[1], "--period", "4:20:9"]) == 0
    assert "hull.position[3]" in capsys.readouterr().out
    rows = np.genfromtxt(out[1], delimiter=",", names=True)
    assert len(rows) == 9 and is_image(out[0])
    assert main(["rao", str(path), "--period", "20:4:9"]) == 1
    assert "needs periods above 0 that ascend" in capsys.readouterr().err


def is_image(path):
    """Whether a file is a PNG."""
    with open(path, "rb") as file:
        return file.read(4) == b"\x89PNG"


def moored(**line):
    """A buoy 100 m above the bed on three lines."""
    anchors = {
        f"a{k}": {"position": [300 * np.cos(b), 300 * np.sin(b), -100.0]}
        for k, b in enumerate(np.radians([0, 120, 240]))
    }
    spec = {"length": 330.0, "mass": 80.0, "diameter": 0.05, "stiffness": 3e8} | line
    return Scene.model_validate(
        {
            "name": "buoy",
            "gravity": [0, 0, -9.81],
            "sea": {"depth": 100.0},
            "ground": {"marker": anchors},
            "body": {"buoy": {"mass": 1e5, "inertia": [1e6, 1e6, 1e6]}},
            "joint": {"free": {"free": {}, "between": ["ground", "buoy"]}},
            "force": {
                name: {"catenary": spec, "between": [f"ground.{name}", "buoy"], "output": ["tension", "grounded_length"]}
                for name in anchors
            },
        }
    )  # fmt: skip


def test_lines_are_those_of_the_run_and_their_shape_leads_to_its_ends():
    """Tension and what lies on the bed as the FMU tells them; the arc's ends, its length, its slope at the top."""
    scene = moored()
    run = scene.simulate(0.01, 0.01)
    found = moorings(scene, 10.0)

    for line in found.lines:
        assert_near(line.tension, run[f"{line.name}.tension"][0], 1e-6 * line.tension)
        assert_near(line.grounded, run[f"{line.name}.grounded_length"][0], 1e-6)
        assert_near(line.shape[-1], line.upper, 1e-6)
        assert line.shape[:, 2].min() >= -100.0 - 1e-9
        way = np.diff(line.shape, axis=0)
        strain = np.hypot(line.force[0], line.force[1]) / 3e8
        assert_near(np.linalg.norm(way, axis=1).sum(), 330.0 * (1 + strain), 0.1)
        assert_near(way[-1] / np.linalg.norm(way[-1]), -line.force / line.tension, 0.03)

    # three equal lines hold the middle; the force against an offset is odd only for two-sided arrays, and grows
    middle = len(found.offsets) // 2
    assert_near(found.force[middle], 0.0, 1e-3)
    assert (np.diff(found.force) > 0.0).all()

    # the slope is that of the start, however far the curve is drawn
    slopes = [moorings(scene, offset).stiffness for offset in (0.1, 33.0, 500.0)]
    near = moorings(scene, 0.1)
    assert_near(slopes, (near.force[-1] - near.force[0]) / 0.2, 1e-4 * slopes[0])
    assert slopes[0] == slopes[1] == slopes[2]


def test_lines_of_sections_and_with_friction_are_those_of_the_run_too():
    """Beside a line of one section, in any order: ends, bed, tension, where sections meet; an offset pulls as the run would."""
    chain = {"length": 160.0, "mass": 80.0, "diameter": 0.05, "stiffness": 3e8}
    rope = {"length": 170.0, "mass": 30.0, "diameter": 0.14, "stiffness": 8e7}
    scene = moored().model_dump(exclude_unset=True)
    buoy = {"clump": {"mass": 100.0, "volume": 3.0}}
    scene["force"]["a0"]["catenary"] = {"sections": [chain | buoy, rope]}
    scene["force"]["a2"]["catenary"] = chain | {"length": 330.0, "friction": 1.0}
    scene = Scene.model_validate(scene)
    run = scene.simulate(0.01, 0.01)
    found = moorings(scene, 5.0)

    for line in found.lines:
        assert_near(line.tension, run[f"{line.name}.tension"][0], 1e-6 * line.tension)
        assert_near(line.grounded, run[f"{line.name}.grounded_length"][0], 1e-6)
        assert_near(line.shape[[0, -1]], [line.lower, line.upper], 1e-6)
        assert line.shape[:, 2].min() >= -100.0 - 1e-6
        assert line.lying.sum() == 1 and len(line.lying) == len(line.shape) - 1
        assert_near(np.linalg.norm(np.diff(line.shape, axis=0), axis=1).sum(), 330.0, 1.0)

    assert [len(line.joints) for line in found.lines] == [1, 0, 0]
    (joint,) = found.lines[0].joints
    assert joint[2] > -90.0 and (np.abs(found.lines[0].shape - joint).max(axis=1) == 0.0).any()
    assert found.lines[2].lower_tension < found.lines[1].lower_tension


def test_a_line_that_hangs_between_bodies_has_its_weight():
    scene = moored(bed=False, length=345.0)
    line = moorings(scene, 5.0).lines[0]
    weight = (80.0 - 1025 * np.pi * 0.05**2 / 4) * 9.81 * 345.0
    # the lower end bears the rest
    lower = np.sqrt(line.lower_tension**2 - np.hypot(line.force[0], line.force[1]) ** 2)
    assert_near(
        -line.upper_force[2],
        weight - lower if line.shape[:, 2].min() < -100.0 else weight + lower,
        1e-3 * weight,
    )
    assert_near(line.shape[-1], line.upper, 1e-6)


def test_commands_tell_and_draw(tmp_path, capsys):
    pytest.importorskip("matplotlib")
    path = tmp_path / "buoy.toml"
    scene = moored().model_dump(exclude_unset=True)
    scene["sea"]["waves"] = {"jonswap": {"hs": 2, "tp": 8, "spread": 5.0, "seed": 2}, "direction_deg": 40}
    path.write_text(Scene.model_validate(scene).to_toml())
    out = [str(tmp_path / name) for name in ("m.png", "m.csv", "sea.png")]
    assert main(["moorings", str(path), "--plot", out[0], "--csv", out[1], "--direction", "30"]) == 0
    told = capsys.readouterr().out
    assert "a0" in told and "stiffness against the offset" in told
    assert np.genfromtxt(out[1], delimiter=",", names=True).dtype.names == (
        "offset",
        "force",
        "a0",
        "a1",
        "a2",
    )
    assert main(["sea", str(path), "--plot", out[2]]) == 0
    assert is_image(out[0]) and is_image(out[2])
    assert main(["moorings", str(path), "--offset", "-3"]) == 1
    assert "--offset -3: needs a length above 0 m" in capsys.readouterr().err
    assert main(["moorings", str(path), "--direction", "nan"]) == 1
    assert "--direction nan: needs an angle" in capsys.readouterr().err
    assert main(["sea", str(path), "--plot", str(tmp_path / "new" / "sea.png")]) == 0
    assert is_image(tmp_path / "new" / "sea.png") and "it is made for sea.png" in capsys.readouterr().err
    scene["force"] = {}
    path.write_text(Scene.model_validate(scene).to_toml())
    assert main(["moorings", str(path)]) == 1
    assert "has no catenaries" in capsys.readouterr().err
