"""mbdfmi import: a robot's URDF file as a scene file."""

from contextlib import nullcontext
from pathlib import Path

from ...files import check_ending, to_standard_output
from ..arguments import URDF, add_command, add_urdf
from ..paths import load_scene, writable
from ..tables import count
from ..terminal import doing, err, note, out

NO_ROBOT = "is a scene file already; import reads robots (URDF)"


def add(commands):
    """The command and its arguments."""
    command = add_command(
        commands,
        run,
        "import",
        "make a scene file of a robot (URDF)",
        """Links become bodies, or markers where they have no mass and are fixed; joints become joints
with an input for their effort and outputs of position and speed; mimic becomes a linear coupling.
What the file leaves open and what a scene cannot say is told, and stands in comments of the scene.
Other commands take a URDF file as it is; a scene file is for going on: motors, loads, water, loops.
A file of xacro is expanded first: xacro robot.urdf.xacro > robot.urdf.""",
        """examples:
  mbdfmi import panda.urdf                                     writes panda.toml
  mbdfmi import talos.urdf -o walk.toml --base free            nothing holds the base
  mbdfmi import ur5.urdf --stop-stiffness 1e4 --stop-damping 10    joints have ends
  mbdfmi import panda.urdf --package franka_description=robots/franka -o out/panda.toml
  mbdfmi import panda.urdf --faces 4000                        thinned meshes in panda_meshes/""",
    )
    command.add_argument("file", metavar="FILE", help="robot (URDF)")
    command.add_argument(
        "-o",
        "--output",
        metavar="FILE",
        help="the scene file (TOML), - for the standard output (default: the robot's file with .toml, here)",
    )
    command.add_argument(
        "--faces",
        type=int,
        metavar="N",
        help="thin meshes to about N triangles each, into a folder beside the scene file (default: they stay "
        "where and as they are)",
    )
    add_urdf(command.add_argument_group(URDF))


def run(options):
    """Writes the scene, and tells what was decided and left out."""
    from ...scene import write_scene

    if Path(options.file).suffix.lower() == ".toml":
        raise ValueError(f"{options.file}: {NO_ROBOT}")

    path = writable(options.output or Path(options.file).with_suffix(".toml").name, [options.file])
    check_ending(path, "a scene is to be written", ".toml")

    if options.faces is not None and (options.faces < 4 or to_standard_output(path)):
        what = "is for scenes in files" if options.faces >= 4 else "must be at least 4"
        raise ValueError(f"--faces {options.faces}: {what}")

    scene = load_scene(options.file, options)

    if not scene.imported:
        raise ValueError(f"{options.file}: {NO_ROBOT}")

    note(f"{options.file}: {text}" for text in scene.notices)

    placed = scene if to_standard_output(path) else _placed(scene, path, options.faces)
    write_scene(placed, path, scene.imported.commented())
    say = err if to_standard_output(path) else out
    parts = [
        count(len(scene.body), "body", "bodies"),
        count(len(scene.joint), "joint"),
        *([count(len(scene.coupling), "coupling")] if scene.coupling else []),
    ]
    say.print(f"{path}  ({', '.join(parts)})", soft_wrap=True)


def _placed(scene, path, faces):
    """The tables of the scene, with its meshes named as a scene file of that path does."""
    from ...scene import SceneData
    from ...scene.import_ import place_meshes

    with doing(f"{path}: thinning meshes") if faces else nullcontext():
        place_meshes(scene.imported, path, faces)

    return SceneData.model_validate(scene.imported.tables, context={"folder": path.parent})
