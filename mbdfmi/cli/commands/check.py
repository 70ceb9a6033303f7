"""mbdfmi check: mistakes in a scene or an FMU."""

from pathlib import Path

from ..arguments import URDF, add_command, add_urdf
from ..paths import check_looks, load_scene
from ..terminal import doing_here, note, out


def add(commands):
    """The command and its arguments."""
    command = add_command(
        commands,
        run,
        "check",
        "look for mistakes in a scene or an FMU",
        """A scene is read and its motion started. An FMU, of any maker, is validated and
run for a few steps. All mistakes found are printed; the exit status is 1 then.""",
    )
    command.add_argument("file", metavar="SCENE|FMU", help="scene file (TOML), robot (URDF), or any FMU")
    add_urdf(command.add_argument_group(URDF))


def run(options):
    """Raises what was found."""
    path = Path(options.file)
    notes = _check_fmu(path) if path.suffix.lower() == ".fmu" else _check_scene(path, options)
    out.print(f"{path}: no mistakes found{notes}", soft_wrap=True)


def _check_fmu(path):
    """Validates an FMU and runs it for a few steps."""
    from ..fmu_check import check_fmu

    return check_fmu(path)


def _check_scene(path, options):
    """Reads a scene and starts its motion. Raises SceneError, SimulationError."""
    scene = load_scene(path, options)
    check_looks(path, scene)
    model = scene.compile()

    from ...run.instance import Instance

    with doing_here(f"{path}: starting its motion"):
        instance = Instance(model)
        instance.outputs()
        instance.step(1e-3)

    note(instance.notices)
    return ""
