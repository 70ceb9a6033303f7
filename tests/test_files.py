"""What commands write: an input never, links followed, pipes and devices written to, endings believed, the file named."""

import os
import stat
import subprocess
import sys
import threading
from pathlib import Path

import numpy as np
import pytest

from mbdfmi import cli, files
from mbdfmi.cli import terminal
from mbdfmi.compiler.model import compile_scene
from mbdfmi.export import export_fmu
from mbdfmi.files import replacing
from mbdfmi.run.results import Results
from mbdfmi.scene import read_scene

PENDULUM = Path(__file__).parents[1] / "models" / "pendulum.toml"
TABLE = "time [s],x\n0.0,1.0\n1.0,2.0\n"

posix = pytest.mark.skipif(os.name == "nt", reason="links, pipes and devices of Unix")


@pytest.fixture
def results():
    return Results({"time": np.array([0.0, 1.0]), "x": np.array([1.0, 2.0])}, {"time": "s", "x": None})


@pytest.fixture
def scene(tmp_path, monkeypatch):
    """A scene file in the working folder, and its text."""
    monkeypatch.chdir(tmp_path)
    path = tmp_path / "scene.toml"
    path.write_bytes(PENDULUM.read_bytes())
    return path


@pytest.fixture
def refused(capsys):
    """The message of a command that must fail, before any work."""

    def run(*arguments):
        assert cli.main([str(argument) for argument in arguments]) == 1
        printed = capsys.readouterr()
        assert not printed.out
        return printed.err

    return run


# an input is never written


def ways_to(scene):
    """The scene under other names."""
    (scene.parent / "link").symlink_to(scene)
    os.link(scene, scene.parent / "hard")
    (scene.parent / "folder").mkdir()
    return [scene, "scene.toml", "./folder/../scene.toml", "link", "hard"]


@posix
@pytest.mark.parametrize("command", ["simulate", "inverse", "export"])
def test_a_scene_is_never_overwritten(scene, refused, command):
    before = scene.read_bytes()

    for name in ways_to(scene):
        more = {
            "simulate": ["--until", 1, "--csv", name],
            "inverse": ["--motion", "motion.csv", "--csv", name],
            "export": ["-o", name],
        }[command]
        assert Path(name).name in refused(command, "scene.toml", *more)
        assert scene.read_bytes() == before


@posix
def test_the_motion_is_never_overwritten(scene, refused):
    motion = scene.parent / "motion.csv"
    motion.write_text("time,pivot.angle\n0,0\n1,1\n")
    assert "is read by this command" in refused(
        "inverse", "scene.toml", "--motion", motion, "--csv", "motion.csv"
    )
    assert motion.read_text().startswith("time,")


@posix
def test_a_scene_with_the_name_of_an_fmu(scene, refused):
    """A scene whose own name ends in .fmu is told what it is; a link of that name is not followed onto it."""
    (scene.parent / "x.fmu").symlink_to(scene)
    assert "is read by this command" in refused("export", "scene.toml", "-o", "x.fmu")
    model = compile_scene(read_scene(scene))

    with pytest.raises(ValueError, match="the scene's own file"):
        export_fmu(model, scene.parent / "x.fmu", scene_file=scene)

    assert scene.read_bytes() == PENDULUM.read_bytes()


@posix
@pytest.mark.parametrize("table, picture", [("z.png", "z.png"), ("z.csv", "z.png"), ("z.png", "z.csv")])
def test_table_and_picture_in_one_file(scene, refused, table, picture):
    if table != picture:
        (scene.parent / table).write_text("")
        (scene.parent / picture).symlink_to(table)

    assert "z." in refused("simulate", "scene.toml", "--until", 1, "--csv", table, "--plot", picture)


# endings


@pytest.mark.parametrize("ending", ["xlsx", "json", "toml", "PNG", "fmu", "gz", "parquet", "tsv"])
def test_a_table_under_another_ending(scene, refused, results, ending):
    name = f"a.{ending}"
    message = refused("simulate", "scene.toml", "--until", 1, "--csv", name)
    assert name in message and "CSV" in message and ".csv" in message

    with pytest.raises(ValueError, match="CSV"):
        results.to_csv(scene.parent / name)

    assert not (scene.parent / name).exists()


@pytest.mark.parametrize("name", ["a.csv", "a.CSV", "a.txt", "a", "a.b", "run.2024"])
def test_a_table_under_its_own_ending(scene, results, name):
    assert results.to_csv(scene.parent / name).read_text() == TABLE


@pytest.mark.parametrize("name", ["a.toml", "a.zip", "a.png"])
def test_an_fmu_under_another_ending(scene, refused, name):
    assert name in refused("export", "scene.toml", "-o", name)
    assert not Path(name).exists()


# links, pipes, devices


@posix
def test_a_link_stays(results, tmp_path):
    (tmp_path / "far").mkdir()
    target, link = tmp_path / "far" / "table.csv", tmp_path / "link.csv"

    for begin in ("missing", "old"):
        link.unlink(missing_ok=True)
        link.symlink_to(target)
        if begin == "old":
            target.write_text("old")
        results.to_csv(link)
        assert link.is_symlink() and target.read_text() == TABLE and not target.is_symlink()

    assert sorted(path.name for path in tmp_path.iterdir()) == ["far", "link.csv"]
    assert sorted(path.name for path in (tmp_path / "far").iterdir()) == ["table.csv"]


@posix
def test_a_pipe_is_written_to(results, tmp_path):
    pipe, read = tmp_path / "pipe", []
    os.mkfifo(pipe)
    reader = threading.Thread(target=lambda: read.append(pipe.read_text()))
    reader.start()
    results.to_csv(pipe)
    reader.join(10)
    assert read == [TABLE] and stat.S_ISFIFO(pipe.stat().st_mode)


@posix
def test_a_device_is_written_to(results):
    results.to_csv("/dev/null")
    assert stat.S_ISCHR(os.stat("/dev/null").st_mode)


PROGRAM = """
import sys
import numpy as np
from mbdfmi.run.results import Results
print("first", flush=True)
Results({"time": np.array([0.0, 1.0]), "x": np.array([1.0, 2.0])}, {"time": "s", "x": None}).to_csv(sys.argv[1])
print("last")
"""


def environment():
    """Of a process that finds what this one does."""
    return os.environ | {"PYTHONPATH": os.pathsep.join(sys.path)}


@posix
@pytest.mark.parametrize("name", ["-", "/dev/stdout", "/dev/fd/1", "/proc/self/fd/1"])
@pytest.mark.parametrize("to", ["pipe", "file"])
def test_standard_output(tmp_path, name, to):
    """Between what is printed before and after, also where the output is a file."""
    command = [sys.executable, "-c", PROGRAM, name]

    if to == "pipe":
        text = subprocess.run(command, env=environment(), cwd=tmp_path, capture_output=True, text=True).stdout
    else:
        with open(tmp_path / "out", "w") as out:
            subprocess.run(command, env=environment(), cwd=tmp_path, stdout=out)
        text = (tmp_path / "out").read_text()

    assert text == f"first\n{TABLE}last\n"
    assert [path.name for path in tmp_path.iterdir()] == (["out"] if to == "file" else [])


@posix
def test_a_reader_that_stops_takes_no_other_file_away(tmp_path):
    """`--csv -` into a pipe that nobody reads on: the plot is there all the same."""
    program = "from mbdfmi.cli import main; main()"
    command = [sys.executable, "-c", program, "simulate", str(PENDULUM), "--until", "1", "--csv", "-"]
    read, written = os.pipe()
    os.close(read)
    subprocess.run([*command, "--plot", "a.png"], cwd=tmp_path, stdout=written, env=environment())
    os.close(written)
    assert (tmp_path / "a.png").read_bytes().startswith(b"\x89PNG")


def test_folders_that_are_made_are_told(scene, capsys):
    assert cli.main(["simulate", str(scene), "--until", "0.1", "--csv", "out/new/a.csv"]) == 0
    assert (
        f"note: {Path('out/new')}: there is no such folder, it is made for a.csv" in capsys.readouterr().err
    )
    assert (scene.parent / "out" / "new" / "a.csv").exists()


# what goes wrong names the file


@posix
@pytest.mark.skipif(not Path("/dev/full").exists(), reason="there is no /dev/full")
def test_a_full_disk_names_the_file(results):
    with pytest.raises(OSError) as error:
        results.to_csv("/dev/full")

    assert terminal.text_of(error.value) == "/dev/full: No space left on device"


def test_an_error_in_the_middle_names_the_file_and_keeps_the_old(tmp_path):
    path = tmp_path / "a.csv"
    path.write_text("old")

    with pytest.raises(OSError) as error, replacing(path):
        raise OSError(28, "No space left on device")

    assert error.value.filename == str(path) and path.read_text() == "old"
    assert [other.name for other in tmp_path.iterdir()] == ["a.csv"]


@posix
@pytest.mark.parametrize("folder", ["/proc", "/proc/new"])
def test_a_folder_that_takes_no_files(results, folder):
    with pytest.raises(OSError) as error:
        results.to_csv(f"{folder}/a.csv")

    assert error.value.filename.startswith(folder) and ".csv." not in error.value.filename


@posix
def test_permissions_stay(results, tmp_path):
    path = tmp_path / "a.csv"
    path.write_text("")
    path.chmod(0o640)
    results.to_csv(path)
    assert stat.S_IMODE(path.stat().st_mode) == 0o640


@posix
def test_one_file_under_two_names(tmp_path):
    (tmp_path / "a").write_text("")
    (tmp_path / "b").symlink_to("a")
    os.link(tmp_path / "a", tmp_path / "c")
    assert all(files.same(tmp_path / "a", tmp_path / name) for name in "abc")
    assert files.same(tmp_path / "new", tmp_path / "x" / ".." / "new")
    assert not files.same(tmp_path / "a", tmp_path / "d") and not files.same("-", "-")
