"""What users do with files: tables over what is there, through links, into pipes, and scenes that are none."""

import contextlib
import io
import os
import stat
import threading

from mbdfmi.cli import main
from mbdfmi.compiler.model import compile_scene
from mbdfmi.run.simulate import simulate

from .findings import Finding

UNTIL, STEP = "0.05", "0.01"
WAITS = 20.0  # s that the reader of a pipe waits

OTHER_KINDS = {
    "arm.xml": ('<?xml version="1.0"?>\n<mujoco model="arm"/>', "MJCF"),
    "arm.json": ('{"body": {}}', "JSON"),
    "Arm.mo": ("model Arm\n  Real x;\nend Arm;", "Modelica"),
}


def used(scene, folder):
    """Findings where commands do not treat files as users must be able to expect. folder : an empty one."""
    path = folder / "scene"
    path.write_text(scene.to_toml(), encoding="utf-8")
    table = folder / "table.csv"
    found = [] if not _simulate(path, table) else [_finding("a table is not written")]
    wanted = table.read_bytes() if table.exists() else b""

    if len(wanted.splitlines()) != round(float(UNTIL) / float(STEP)) + 2:
        found.append(_finding("a table has another number of lines than communication points"))

    found += [
        _finding(text)
        for text in (*_kept(path, folder), *_through(scene, path, folder, wanted), *_no_scene(folder))
    ]
    return found


def _kept(path, folder):
    """A scene that is read stays; so does what promises another format."""
    before = path.read_bytes()
    os.link(path, folder / "again.csv")
    (folder / "link.csv").symlink_to(path)

    for name in ("scene", "again.csv", "link.csv"):
        if not _simulate(path, folder / name) or path.read_bytes() != before:
            yield f"the scene that is read is written over, as {name}"
            path.write_bytes(before)

    for name in ("table.png", "table.fmu", "table.xlsx"):
        if not _simulate(path, folder / name) or (folder / name).exists():
            yield f"a table is written into {name}"


def _through(scene, path, folder, wanted):
    """A table goes over an old one, where a link points, into a pipe."""
    (folder / "far").mkdir()
    far, near, pipe = folder / "far" / "table.csv", folder / "near.csv", folder / "pipe"
    far.write_text("old")
    near.symlink_to(far)

    if _simulate(path, near) or not near.is_symlink() or far.read_bytes() != wanted:
        yield "a table is not written where a link points"

    far.write_text("old")
    simulate(compile_scene(scene), float(UNTIL), float(STEP)).to_csv(near)

    if not near.is_symlink() or far.read_bytes() != wanted:
        yield "results are not written where a link points"

    os.mkfifo(pipe)
    read = []
    reader = threading.Thread(target=lambda: read.append(pipe.read_bytes()), daemon=True)
    reader.start()
    status = _simulate(path, pipe)

    if status or not stat.S_ISFIFO(pipe.stat().st_mode):
        yield "a table is not written into a pipe"
    else:
        reader.join(WAITS)

        if read != [wanted]:
            yield "what comes out of a pipe is not the table"


def _no_scene(folder):
    for name, (text, kind) in OTHER_KINDS.items():
        (folder / name).write_text(text, encoding="utf-8")
        status, said = _run("check", folder / name)

        if not status or kind not in said:
            yield f"{name} is not told to be {kind}: {said.strip()[-200:]}"


def _simulate(path, table):
    return _run("simulate", path, "--until", UNTIL, "--step", STEP, "--csv", table)[0]


def _run(*arguments):
    """(exit status, what is printed) of a command."""
    said = io.StringIO()

    with contextlib.redirect_stdout(said), contextlib.redirect_stderr(said):
        status = main([str(argument) for argument in arguments])

    return status, said.getvalue()


def _finding(text):
    return Finding("files", "mbdfmi", text=text)
