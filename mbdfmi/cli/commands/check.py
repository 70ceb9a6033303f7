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
run for a few steps; with --probe it is asked what no validator sees: whether a
second run, a reset, a restored state are as they should be, derivatives and
dependencies true, wrong calls refused. Each question has a process of its own, so
that an FMU that falls is told. All mistakes found are printed; the exit status is 1
then.""",
    )
    command.add_argument("file", metavar="SCENE|FMU", help="scene file (TOML), robot (URDF), or any FMU")
    group = command.add_argument_group("an FMU")
    group.add_argument("--probe", action="store_true", help="ask it what no validator sees")
    group.add_argument(
        "--limit", type=float, metavar="S", help="seconds that a question of --probe may take (default: 30)"
    )
    add_urdf(command.add_argument_group(URDF))


def run(options):
    """Raises what was found."""
    path = Path(options.file)
    is_fmu = path.suffix.lower() == ".fmu"

    if not is_fmu and (options.probe or options.limit is not None):
        raise ValueError(f"{path}: --probe and --limit are for FMUs; export the scene first")

    notes = _check_fmu(path, options) if is_fmu else _check_scene(path, options)
    out.print(f"{path}: no mistakes found{notes}", soft_wrap=True)


def _check_fmu(path, options):
    """Validates an FMU, runs it for a few steps, and probes it when asked to."""
    from ..fmu_check import check_fmu, probe_fmu

    if options.limit is not None and not (options.probe and options.limit > 0):
        raise ValueError("--limit: a number of seconds above 0, with --probe")

    return probe_fmu(path, options.limit) if options.probe else check_fmu(path)


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
