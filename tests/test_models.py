"""Every scene of models/: its FMU is valid, runs, and says what an in-process run says."""

import shutil
import subprocess
import sys
import tomllib
import zipfile
from pathlib import Path

import fmpy
import numpy as np
import pytest
from fmpy.fmi2 import FMU2Slave
from fmpy.validation import validate_fmu

import mbdfmi
from tests.model_files import SCENES

MODELS = Path(__file__).parents[1] / "models"

H = 1 / 64  # s, a binary number: i*H and t += H are then the same, whoever computes them
N = 128


@pytest.fixture(params=SCENES, ids=lambda path: path.stem)
def scene(request):
    return mbdfmi.load(request.param)


@pytest.fixture(scope="session")
def folder(tmp_path_factory):
    return tmp_path_factory.mktemp("fmus")


@pytest.fixture
def fmu(scene, folder):
    path = folder / f"{scene.name}.fmu"
    return path if path.exists() else scene.export(path)


def signals(scene, n=N):
    """Unlike waves (n + 1,) for all inputs by name, as strong as a part of the scene's weight."""
    inputs = scene.compile().of_causality("input")
    weight = 9.81 * sum(body.mass_properties()[0] for body in scene.body.values())
    t = np.arange(n + 1) * H
    return {v.name: 0.03 * weight * np.sin((3 + k) * t + k) * (1 + 0.2 * t) for k, v in enumerate(inputs)}


def run(path, inputs):
    """Outputs (n + 1,) of an FMU by name, at communication points H apart."""
    description = fmpy.read_model_description(path)
    of = {c: [v for v in description.modelVariables if v.causality == c] for c in ("input", "output")}
    references = {c: [v.valueReference for v in variables] for c, variables in of.items()}
    columns = np.array([inputs[v.name] for v in of["input"]]).reshape(-1, N + 1).T
    fmu = FMU2Slave(
        guid=description.guid,
        unzipDirectory=fmpy.extract(path),
        modelIdentifier=description.coSimulation.modelIdentifier,
        instanceName="test",
    )
    fmu.instantiate()
    fmu.setupExperiment(startTime=0.0)
    fmu.enterInitializationMode()
    fmu.exitInitializationMode()
    rows = []

    for k, row in enumerate(columns):
        fmu.setReal(references["input"], row)
        rows.append(fmu.getReal(references["output"]))

        if k < N:
            fmu.doStep(k * H, H)

    fmu.terminate()
    fmu.freeInstance()
    return dict(zip([v.name for v in of["output"]], np.array(rows).T))


def fmutool_check(path):
    """What `fmutool -input FMU -check` prints."""
    program = "from fmu_manipulation_toolbox.cli.fmutool import fmutool; fmutool()"
    command = [sys.executable, "-c", program, "-input", str(path), "-check"]
    done = subprocess.run(command, capture_output=True, text=True)
    report = done.stdout + done.stderr
    assert "Semantic Checks" in report
    return report


def assert_same(found, expected, names):
    """The same bits where both use one C library, else the same to 1e-12 of the largest value."""
    assert names

    for name in names:
        assert np.all(np.isfinite(expected[name])), name

        if sys.platform == "linux":
            np.testing.assert_array_equal(found[name], expected[name], err_msg=name)
        else:
            scale = np.abs(expected[name]).max()
            np.testing.assert_allclose(
                found[name], expected[name], rtol=1e-12, atol=1e-12 * scale, err_msg=name
            )


def test_all_scenes_are_found():
    assert {path.stem for path in SCENES} >= {
        "pendulum", "double_pendulum", "two_link_arm", "spinning_top", "floating_wind_turbine", "four_bar", "bricard",
        "slider_crank", "cam_follower", "rolling_disk", "spinning_hoop", "satellite", "turntable", "turning_track",
    }  # fmt: skip


def test_no_validator_complains(fmu):
    assert validate_fmu(str(fmu)) == []
    report = fmutool_check(fmu)
    assert "ERROR" not in report and "WARNING" not in report, report


def test_fmutool_does_complain_where_something_is_wrong(fmu, tmp_path):
    """So its silence above says something."""
    broken = tmp_path / "broken.fmu"

    with zipfile.ZipFile(broken, "w") as archive:
        for name, data in _contents(fmu).items():
            archive.writestr(name, data.replace(b'variability="tunable"', b'variability="continuous"'))

    assert "ERROR" in fmutool_check(broken)


def test_fmu_gives_what_an_in_process_run_gives(scene, fmu):
    inputs = signals(scene)
    expected = scene.simulate(N * H, H, inputs)
    outputs = [v.name for v in scene.compile().of_causality("output")]

    assert_same(run(fmu, inputs), expected, outputs)

    # the inputs are felt
    if inputs:
        still = scene.simulate(N * H, H)
        assert any(np.any(still[name] != expected[name]) for name in outputs)


def test_fmpy_runs_it(scene, fmu):
    inputs = signals(scene)
    model = scene.compile()
    times = np.arange(N + 1) * H
    table = np.rec.fromarrays([times, *inputs.values()], names=["time", *inputs])
    result = fmpy.simulate_fmu(
        str(fmu), stop_time=N * H, output_interval=H, step_size=H, input=table if inputs else None
    )

    # fmpy reads outputs before it sets the next inputs, so leave out what these act on at once
    outputs = [v.name for v in model.of_causality("output") if not v.depends]
    np.testing.assert_array_equal(result["time"], times)
    assert_same(result, scene.simulate(N * H, H, inputs), outputs)


def test_start_values(tmp_path):
    """A free body starts where the scene says, or a parameter does, in process and as an FMU."""
    scene = mbdfmi.Scene(
        name="free",
        body={"box": {"solid": {"box": {"size": [1, 2, 3], "mass": 1}}, "output": ["position", "velocity"]}},
        joint={
            "j": {
                "free": {},
                "between": ["ground", "box"],
                "start": {"position": [1, 2, 3], "velocity": [4, 5, 6]},
                "output": ["position", "velocity"],
            }
        },
    )
    changed = {"j.position_start[1]": 7.0, "j.velocity_start[3]": 8.0}
    fmu = scene.export(tmp_path / "free.fmu")

    for parameters, position, velocity in (({}, [1, 2, 3], [4, 5, 6]), (changed, [7, 2, 3], [4, 5, 8])):
        results = scene.simulate(0.1, 0.1, parameters=parameters)
        table = fmpy.simulate_fmu(str(fmu), stop_time=0.1, output_interval=0.1, start_values=parameters)

        for name in ("j", "box"):
            np.testing.assert_allclose(results[f"{name}.position"][0], position, rtol=1e-15)
            np.testing.assert_allclose(results[f"{name}.velocity"][0], velocity, rtol=1e-15)
            found = [
                table[f"{name}.{quantity}[{k}]"][0]
                for quantity in ("position", "velocity")
                for k in (1, 2, 3)
            ]
            np.testing.assert_allclose(found, position + velocity, rtol=1e-15)


def test_any_step_gives_the_same_to_rounding(scene, fmu):
    """fmpy steps by the difference of two rounded times, which is not quite 0.01 s."""
    result = fmpy.simulate_fmu(str(fmu), stop_time=1.0, output_interval=0.01)
    expected = scene.simulate(1.0, 0.01)
    outputs = scene.compile().of_causality("output")

    for v in outputs:
        # a total energy is a small difference of large ones, a gap of constraints nothing but rounding of sizes about 1
        scale = max(np.abs(expected[w.name]).max() for w in outputs if w.unit == v.unit)
        atol = 1e-12 * max(scale, 1e-2)
        np.testing.assert_allclose(result[v.name], expected[v.name], rtol=1e-12, atol=atol, err_msg=v.name)


def test_scene_in_python_gives_the_same_fmu(scene, tmp_path, monkeypatch):
    """The same tables given in Python make the same FMU, byte for byte but for the scene file in it."""
    # files that tables in Python name are looked for where the program runs
    monkeypatch.chdir(scene._file.parent)
    monkeypatch.setenv("SOURCE_DATE_EPOCH", "1767225600")
    tables = tomllib.loads(scene._file.read_text(encoding="utf-8"))

    from_file = scene.export(tmp_path / "file.fmu")
    again = scene.export(tmp_path / "again.fmu")
    in_python = mbdfmi.Scene(**tables).export(tmp_path / "python.fmu")

    assert from_file.read_bytes() == again.read_bytes()

    contents = _contents(from_file)
    assert contents.pop(f"resources/{scene._file.name}") == scene._file.read_bytes()
    assert _contents(in_python) == contents


def test_written_scene_gives_the_same_model(scene, tmp_path):
    # with the files beside it that it names
    shutil.copytree(scene._file.parent, tmp_path, dirs_exist_ok=True)
    path = tmp_path / "written.toml"
    path.write_text(scene.to_toml(), encoding="utf-8")

    assert mbdfmi.load(path).compile().guid == scene.compile().guid


def _contents(path):
    with zipfile.ZipFile(path) as archive:
        return {entry.filename: archive.read(entry) for entry in archive.infolist()}
