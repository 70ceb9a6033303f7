"""Files that commands read and write, looked at before work starts."""

import glob
import os
from pathlib import Path

from ..files import same, to_standard_output
from .arguments import urdf_options
from .terminal import compile_first, note


def load_scene(file, options=None):
    """The scene of a file; `options` of the command line that are for URDF files. What such a file leaves
    open is told; the kernels are compiled by then. Raises SceneError; ValueError for an FMU.
    """
    from ..api import load

    if Path(file).suffix.lower() == ".fmu":
        raise ValueError(
            f"{file}: is an FMU; this command wants a scene file (TOML). For an FMU: mbdfmi check"
        )

    scene = load(file, **urdf_options(options))
    note(f"{file}: {text}" for text in scene.import_notes)
    compile_first()
    return scene


def check_looks(file, scene):
    """Raises ValueError that names the file and each place of a mesh that cannot be read."""
    from ..view.contents import check_meshes

    try:
        check_meshes(scene)
    except ValueError as error:
        raise ValueError("\n".join(f"{file}: {line}" for line in str(error).split("\n"))) from None


def matching(file):
    """A file, or those that a pattern with * stands for: Windows' shells leave patterns to the program."""
    return sorted(glob.glob(file)) if "*" in file and not Path(file).exists() else [file]


def writable(text, inputs):
    """The path of a file to be written, looked at before work starts; `inputs` are files that stay as they
    are.

    Raises ValueError that says what hinders.
    """
    path = Path(text)

    for given in inputs:
        if same(path, given):
            raise ValueError(f"{path}: is read by this command or written twice; write to another file")

    if to_standard_output(path):
        return path

    if path.is_dir():
        raise ValueError(f"{path}: is a folder; name a file in it")

    if path.exists():
        if not os.access(path, os.W_OK):
            raise ValueError(f"{path}: cannot be written, it is not yours to write")
        if not path.is_file():
            return path

    path = Path(os.path.realpath(path)) if path.is_symlink() else path

    # folders that are missing will be made
    parent = next(folder for folder in path.absolute().parents if folder.exists())

    if not parent.is_dir():
        raise ValueError(f"{path}: cannot be written, {parent} is a file and not a folder")

    if not os.access(parent, os.W_OK):
        raise ValueError(f"{path}: cannot be written, the folder {parent} is not yours to write in")

    if not path.parent.exists():
        note([f"{path.parent}: there is no such folder, it is made for {path.name}"])

    return path


def result_files(options, *inputs):
    """The files of --csv and --plot, or None, looked at before work starts."""
    from ..run.results import Results

    csv = options.csv and writable(options.csv, inputs)
    plot = options.plot and writable(options.plot, [*inputs, *([csv] if csv else [])])

    if csv:
        Results.check_csv(csv)

    if plot:
        Results.check_plot(plot)

    return csv, plot


def view_file(text, at, *inputs):
    """The file of a view, or None, looked at before work starts; inputs: files that it must not be, or
    None.
    """
    if not text:
        if at is not None:
            raise ValueError(f"--at {at:g}: is the time of a picture; write --view FILE.png")

        return None

    from ..view.show import check_view

    path = writable(text, [file for file in inputs if file])
    check_view(path, at)
    return path
