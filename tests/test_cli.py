"""The command line: what it prints, what it writes, and what it says when something is wrong."""

import csv
import os
import shutil
import subprocess
import sys
import zipfile
from pathlib import Path

import fmpy
import pytest

from mbdfmi import cli
from mbdfmi.cli import terminal
from mbdfmi.kernels.language import INTERPRETED, JIT
from mbdfmi.native import library as native
from tests.model_files import SCENES

ROOT = Path(__file__).parents[1]
MODELS = ROOT / "models"
PENDULUM = MODELS / "pendulum.toml"
ARM = MODELS / "two_link_arm.toml"
FOUR_BAR = MODELS / "four_bar.toml"
TURBINE = MODELS / "floating_wind_turbine" / "floating_wind_turbine.toml"


@pytest.fixture
def command(capsys):
    """Runs the command in this process; returns (exit status, stdout, stderr)."""

    def run(*arguments):
        for stream in (terminal.out, terminal.err):
            vars(stream).pop("console", None)  # a new one, as wide as the test says

        try:
            status = cli.main([str(argument) for argument in arguments])
        except SystemExit as end:
            status = end.code

        printed = capsys.readouterr()
        return status, printed.out, printed.err

    return run


@pytest.fixture
def refused(command, tmp_path, monkeypatch):
    """Runs a command that must fail with a message and leave no file; returns the message on one line."""
    folder = tmp_path / "here"
    folder.mkdir()
    monkeypatch.chdir(folder)

    def run(*arguments, status=1):
        found, printed, message = command(*arguments)

        assert found == status, message
        assert "Traceback" not in message
        assert printed == ""
        assert list(folder.iterdir()) == []
        return " ".join(message.split())

    return run


@pytest.fixture(scope="module")
def fmu(tmp_path_factory):
    """An FMU, and the folder for damaged ones."""
    path = tmp_path_factory.mktemp("fmu") / "pendulum.fmu"
    assert cli.main(["export", str(PENDULUM), "-o", str(path)]) == 0
    return path


# what works


@pytest.mark.parametrize(
    "arguments", [[], ["export"], ["simulate"], ["inverse"], ["info"], ["check"], ["bench"], ["import"]]
)
def test_help(command, arguments, monkeypatch):
    monkeypatch.setenv("COLUMNS", "80")
    status, printed, _ = command(*arguments, "--help")

    assert status == 0
    assert printed.startswith("usage: mbdfmi")
    assert max(map(len, printed.splitlines())) <= 100


def test_version(command):
    assert command("--version")[1].startswith("mbdfmi 0")


def test_info(command, monkeypatch):
    monkeypatch.setenv("COLUMNS", "120")
    status, printed, _ = command("info", TURBINE)

    assert status == 0
    assert "7 bodies in 2 rigid parts, 7 degrees of freedom" in printed
    assert "auto, adaptive step, tolerance 1e-07 relative, 1e-07 absolute" in printed
    assert "mass, kg" in printed and "5.452e+06" in printed
    assert "platform.moment[1..3]" in printed and "N.m" in printed
    assert "hydrostatics.stiffness" not in printed

    status, printed, _ = command("info", ARM, "--parameters")
    assert "rk4, fixed step of at most 0.001 s" in printed
    assert "shoulder.angle_start" in printed and "0, -9.81, 0" in printed


def test_info_tells_what_a_loop_leaves_undetermined(command, monkeypatch):
    monkeypatch.setenv("COLUMNS", "120")
    status, printed, _ = command("info", FOUR_BAR)

    assert status == 0
    assert "3 joint coordinates less 2 independent equations (of 5): 1 degree of freedom" in printed
    assert "closing loops: rocker_pin" in printed
    assert "rocker_pin  position along z" in printed
    assert "crank_pivot   force along z, moment about x and y" in printed


def test_inverse(command, tmp_path):
    """The motion of a free run needs no torque; a table of more than the freedoms is refused with a hint."""
    run, efforts = tmp_path / "run.csv", tmp_path / "efforts.csv"
    command("simulate", FOUR_BAR, "--until", 0.5, "--csv", run)
    status, _, problem = command("inverse", FOUR_BAR, "--motion", run)
    assert (
        status == 1
        and "1 degree of freedom; drive fewer of them (drive=[...], or --drive JOINT)"
        in " ".join(problem.split())
    )

    status, printed, _ = command(
        "inverse", FOUR_BAR, "--motion", run, "--drive", "crank_pivot", "--csv", efforts
    )
    assert status == 0 and printed.split() == [str(efforts)]
    head, *rows = csv.reader(efforts.open())
    assert head[:2] == ["time [s]", "crank_pivot.torque [N.m]"]
    assert max(abs(float(row[1])) for row in rows) < 1e-8


@pytest.mark.parametrize("columns", [80, 120])
@pytest.mark.parametrize("scene", [PENDULUM, ARM, FOUR_BAR, TURBINE])
def test_info_fits_the_terminal(command, monkeypatch, scene, columns):
    monkeypatch.setenv("COLUMNS", str(columns))
    status, printed, _ = command("info", scene, "--parameters")

    assert status == 0
    assert max(map(len, printed.splitlines())) <= columns
    assert "…" not in printed


def test_simulate(command, tmp_path):
    status, printed, _ = command("simulate", PENDULUM, "--until", 0.5)
    assert status == 0
    assert "pivot.angle" in printed and "0.523599" in printed

    table, picture = tmp_path / "new" / "a.csv", tmp_path / "a.svg"
    status, printed, _ = command(
        "simulate", PENDULUM, "--until", 0.5, "--step", 0.1, "--csv", table, "--plot", picture
    )
    assert status == 0
    assert printed.split() == [str(table), str(picture)]

    head, *rows = csv.reader(table.open())
    assert head[:2] == ["time [s]", "pivot.angle [rad]"]
    assert [float(row[0]) for row in rows] == pytest.approx([0, 0.1, 0.2, 0.3, 0.4, 0.5])
    assert "<svg" in picture.read_text()


def test_set(command, tmp_path):
    """An input held, a parameter, and an array at once."""
    table = tmp_path / "a.csv"
    settings = ["--set", "shoulder.torque=5", "--set", "shoulder.angle_start=1", "--set", "gravity=0,0,-1.62"]
    status, _, message = command("simulate", ARM, "--until", 0.01, "--step", 0.01, "--csv", table, *settings)
    assert status == 0, message

    head, first, _ = csv.reader(table.open())
    row = dict(zip(head, map(float, first)))
    assert row["shoulder.torque [N.m]"] == 5
    assert row["shoulder.angle [rad]"] == 1

    # gravity along the joints' axes does not turn the arm
    still = ["--set", "shoulder.speed_start=0", "--set", "elbow.speed_start=0", "--set", "gravity=0,0,-1.62"]
    command("simulate", ARM, "--until", 0.01, "--step", 0.01, "--csv", table, *still)
    head, first, _ = csv.reader(table.open())
    row = dict(zip(head, map(float, first)))
    assert row["shoulder.acceleration [rad/s2]"] == pytest.approx(0, abs=1e-12)


def test_export(command, tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)

    assert command("export", PENDULUM)[0] == 0
    assert zipfile.is_zipfile("pendulum.fmu")

    status, printed, _ = command("export", PENDULUM, ARM, "-o", "some/folder")
    assert status == 0
    assert sorted(path.name for path in Path("some/folder").iterdir()) == ["pendulum.fmu", "two_link_arm.fmu"]
    assert "two_link_arm.fmu" in printed

    # as a shell without patterns leaves it
    assert command("export", MODELS / "*.toml", "-o", "all")[0] == 0
    assert len(list(Path("all").iterdir())) == len(list(MODELS.glob("*.toml")))


def test_export_as_fmi_3(command, refused, tmp_path):
    assert command("export", PENDULUM, "--fmi", "3", "-o", tmp_path / "three.fmu")[0] == 0
    status, printed, _ = command("export", PENDULUM, "--fmi", "2,3", "-o", tmp_path / "both")
    assert status == 0 and "pendulum_fmi3.fmu" in printed
    written = [tmp_path / "three.fmu", *sorted((tmp_path / "both").iterdir())]
    versions = [fmpy.read_model_description(str(path)).fmiVersion for path in written]
    assert [path.name for path in written[1:]] == ["pendulum_fmi2.fmu", "pendulum_fmi3.fmu"]
    assert versions == ["3.0", "2.0", "3.0"]

    assert "--fmi 4: unknown; there are 2, 3 and 2,3" in refused("export", PENDULUM, "--fmi", "4")
    assert "--fmi 3,3: names a version twice" in refused("export", PENDULUM, "--fmi", "3,3")
    assert "one file cannot be FMI 2 and FMI 3" in refused("export", PENDULUM, "--fmi", "2,3", "-o", "a.fmu")


def test_export_of_some_broken_scenes_makes_the_others(command, tmp_path):
    broken = tmp_path / "broken.toml"
    broken.write_text("name = ")
    status, printed, message = command("export", broken, PENDULUM, "nowhere.toml", "-o", tmp_path)

    assert status == 1
    assert (tmp_path / "pendulum.fmu").exists() and "pendulum.fmu" in printed
    assert "broken.toml" in message and "nowhere.toml" in message


def test_check(command, fmu):
    for path in (PENDULUM, TURBINE, fmu):
        status, printed, message = command("check", path)
        assert status == 0, message
        assert "no mistakes found" in printed


def test_build_fmu(tmp_path):
    def build(*arguments):
        return subprocess.run(
            [sys.executable, ROOT / "build_fmu.py", *arguments],
            cwd=tmp_path,
            env=os.environ | {"PYTHONPATH": str(ROOT)},
            capture_output=True,
            text=True,
        )

    assert build(PENDULUM, "-o", "one").returncode == 0
    assert [path.name for path in (tmp_path / "one").iterdir()] == ["pendulum.fmu"]

    done = build()
    assert done.returncode == 0, done.stderr
    assert len(list((tmp_path / "out").iterdir())) == len(SCENES)

    done = build("nowhere.toml")
    assert done.returncode == 1
    assert "nowhere.toml: there is no such file" in done.stderr


@pytest.mark.skipif(INTERPRETED or JIT, reason="no library is made")
def test_first_run_says_why_it_takes_long(command, monkeypatch, tmp_path):
    assert command("simulate", PENDULUM, "--until", 0.1)[2] == ""

    # with an empty cache it must be made, as if by the process that makes it; this process has it all the same
    monkeypatch.setenv("MBDFMI_CACHE", str(tmp_path))
    monkeypatch.setattr(native, "_make", lambda tell: tell("compiling the kernels (once per version)"))
    assert "compiling the kernels" in command("simulate", PENDULUM, "--until", 0.1)[2]
    assert "compiling the kernels" in command("check", PENDULUM)[2]


# what is refused


@pytest.mark.parametrize("name", ["info", "check", "export", "simulate"])
def test_scene_that_cannot_be_read(refused, tmp_path, name):
    more = ["--until", "1"] if name == "simulate" else []

    assert "nowhere.toml: there is no such file" in refused(name, "nowhere.toml", *more)
    assert "is a folder" in refused(name, tmp_path, *more)

    file = tmp_path / "broken.toml"
    file.write_text('name = "x"\n[body.a\n')
    assert "broken.toml: line 2" in refused(name, file, *more)

    file.write_bytes(b"\xff\xfe\x00")
    assert "not UTF-8" in refused(name, file, *more)

    file.write_text('name = "x"\n[body.a]\nmas = 1\n[joint.j]\nrevolut = {}\nbetween = ["ground", "b"]\n')
    message = refused(name, file, *more)
    assert 'Did you mean "mass"?' in message and 'Did you mean "revolute"?' in message
    assert "[body.a]" in message and "[joint.j]" in message


def test_motion_that_cannot_start(refused, tmp_path):
    """A scene that is well written, but whose motion has no meaning."""
    file = tmp_path / "point.toml"
    file.write_text(
        'name = "point"\n[body.a]\nmass = 1\ninertia = [0, 0, 0]\n'
        '[joint.j]\nrevolute = {}\nbetween = ["ground", "a"]\n'
    )

    assert "inertia" in refused("check", file)
    assert "inertia" in refused("simulate", file, "--until", 1)


@pytest.mark.parametrize(
    "setting, said",
    [
        ("shoulder.torqe=5", "did you mean 'shoulder.torque'?"),
        ("shoulder.angle_strat=5", "did you mean 'shoulder.angle_start'?"),
        ("nothing like it=5", "mbdfmi info SCENE --parameters"),
        ("shoulder.angle=5", "no input or parameter"),
        ("shoulder.torque", "NAME=VALUE"),
        ("shoulder.torque=", "NAME=VALUE"),
        ("shoulder.torque=five", "NAME=VALUE"),
        ("=5", "NAME=VALUE"),
        ("shoulder.torque=1,2", "takes 1 number"),
        ("gravity=1", "takes 3 numbers"),
        ("shoulder.torque=nan", "NAME=VALUE"),
        ("upper.mass=-1", "mass of upper"),
    ],
)
def test_wrong_setting(refused, setting, said):
    assert said in refused("simulate", ARM, "--until", 1, "--csv", "a.csv", "--set", setting)


@pytest.mark.parametrize(
    "arguments, said",
    [
        (["--until", "0"], "must end after it starts"),
        (["--until", "-1"], "must end after it starts"),
        (["--until", "nan"], "must end after it starts"),
        (["--until", "inf"], "must end after it starts"),
        (["--until", "1", "--step", "0"], "must be positive"),
        (["--until", "1", "--step", "-1"], "must be positive"),
        (["--until", "1", "--step", "nan"], "must be positive"),
        (["--until", "1", "--step", "1e-12"], "communication points"),
        (["--until", "1e300", "--step", "1e-300"], "communication points"),
        (["--until", "1", "--plot", "a.xyz"], "it ends in .png, .svg or .pdf"),
        (["--until", "1", "--plot", "a"], "it ends in .png, .svg or .pdf"),
        (["--until", "1", "--csv", "."], "is a folder"),
        (["--until", "1", "--csv", f"{PENDULUM}/a.csv"], "is a file and not a folder"),
    ],
)
def test_wrong_run(refused, arguments, said):
    assert said in refused("simulate", PENDULUM, *arguments)


@pytest.mark.parametrize(
    "arguments, said",
    [
        ([], "required: COMMAND"),
        (["exprot"], "invalid choice"),
        (["simulate", PENDULUM], "required: --until"),
        (["simulate", PENDULUM, "--until", "soon"], "invalid float"),
        (["export"], "required: SCENE"),
        (["info", PENDULUM, "--colour"], "unrecognized arguments"),
    ],
)
def test_wrong_command_line(refused, arguments, said):
    assert said in refused(*arguments, status=2)


def test_export_to_where_it_cannot_be(refused, tmp_path):
    assert "is a file and not a folder" in refused("export", PENDULUM, "-o", PENDULUM / "a.fmu")
    assert "is a file and not a folder" in refused("export", PENDULUM, "-o", PENDULUM)
    assert "one file cannot hold 2 scenes" in refused("export", PENDULUM, ARM, "-o", "a.fmu")

    taken = tmp_path / "pendulum.fmu"
    taken.mkdir()
    assert "is a folder" in refused("export", PENDULUM, "-o", tmp_path)


@pytest.mark.skipif(os.name == "nt" or os.geteuid() == 0, reason="root and Windows write where they like")
def test_export_to_a_folder_of_others(refused, tmp_path):
    locked = tmp_path / "locked"
    locked.mkdir(mode=0o500)
    assert "not yours to write in" in refused("export", PENDULUM, "-o", locked)


def test_unknown_platform(refused):
    message = refused("export", PENDULUM, "--platform", "amiga")
    assert "amiga" in message and "x86_64-windows" in message


def test_two_scenes_of_one_name(command, tmp_path):
    copy = tmp_path / "copy.toml"
    shutil.copy(PENDULUM, copy)
    status, printed, message = command("export", PENDULUM, copy, "-o", tmp_path / "out")

    assert status == 1
    assert "same name" in message
    assert len(list((tmp_path / "out").iterdir())) == 1


def test_fmu_where_a_scene_is_wanted(refused, fmu):
    for arguments in (["info", fmu], ["export", fmu], ["simulate", fmu, "--until", 1]):
        assert "is an FMU" in refused(*arguments)


# damaged FMUs


def rewritten(fmu, name, change):
    """A copy of an FMU of which the files are changed: change(name, data) -> data, or None to leave one out."""
    path = fmu.with_name(f"{name}.fmu")

    with zipfile.ZipFile(fmu) as old, zipfile.ZipFile(path, "w") as new:
        for entry in old.namelist():
            data = change(entry, old.read(entry))

            if data is not None:
                new.writestr(entry, data)

    return path


def test_no_fmu(refused, tmp_path, fmu):
    assert "there is no such file" in refused("check", "nowhere.fmu")
    assert "there is no such file" in refused("check", tmp_path / ".fmu")

    text = tmp_path / "text.fmu"
    text.write_text("this is no archive")
    assert "not an FMU" in refused("check", text)

    text.write_bytes(b"")
    assert "not an FMU" in refused("check", text)

    half = tmp_path / "half.fmu"
    half.write_bytes(fmu.read_bytes()[:20000])
    assert "not an FMU, or damaged" in refused("check", half)

    data = bytearray(fmu.read_bytes())
    data[len(data) // 2] ^= 0xFF
    half.write_bytes(data)
    assert "damaged" in refused("check", half)


@pytest.mark.parametrize(
    "name, change, said",
    [
        ("no_description", lambda name, data: None if name.endswith(".xml") else data, "description"),
        ("no_xml", lambda name, data: b"<a" if name.endswith(".xml") else data, "line 1"),
        ("bad_unit", lambda name, data: data.replace(b'unit="rad"', b'unit="furlong"'), "furlong"),
        ("no_library", lambda name, data: None if name.startswith("binaries") else data, "no library"),
        (
            "bad_library",
            lambda name, data: b"none" if name.startswith("binaries") else data,
            "first run fails",
        ),
        ("no_resource", lambda name, data: None if name.endswith(".bin") else data, "first run fails"),
        ("bad_resource", lambda name, data: data[:-9] if name.endswith(".bin") else data, "first run fails"),
        ("other_guid", lambda name, data: data.replace(b'guid="{', b'guid="{0'), "first run fails"),
    ],
)
def test_damaged_fmu(command, fmu, name, change, said):
    path = rewritten(fmu, name, change)
    status, printed, message = command("check", path)

    # without a library for this machine there is nothing to be run, which is no mistake
    assert status == (0 if name == "no_library" else 1)
    assert said in printed + message
    assert "Traceback" not in message
