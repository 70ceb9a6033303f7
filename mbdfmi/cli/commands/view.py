"""mbdfmi view: a scene to look at."""

from ...files import to_standard_output
from ..arguments import add_command, add_scene, add_settings
from ..paths import check_looks, load_scene, view_file
from ..settings import settings_of
from ..terminal import doing_here, err, note, out


def add(commands):
    """The command and its arguments."""
    command = add_command(
        commands,
        run,
        "view",
        "look at a scene as it is assembled",
        """The bodies in three dimensions at the start, with names, frames and axes. The page is one
file that works offline. Bodies without a shape or a solid are drawn as half-transparent
boxes of equal inertia, with sticks from joint to joint. For a motion: mbdfmi simulate --view.""",
        """examples:
  mbdfmi view crane.toml                        in the browser
  mbdfmi view crane.toml -o crane.html          a page
  mbdfmi view crane.toml -o crane.glb           for Blender and others
  mbdfmi view crane.toml -o crane.png           a picture
  mbdfmi view crane.toml --set boom.angle_start=0.5""",
    )
    add_scene(command)
    command.add_argument(
        "-o", "--output", metavar="FILE", help=".html, .glb or .png (default: opens the browser)"
    )
    add_settings(command)


def run(options):
    """Assembles it and shows it."""
    path = view_file(options.output, None, options.scene)
    scene = load_scene(options.scene, options)
    check_looks(options.scene, scene)
    model = scene.compile()
    inputs, parameters = settings_of(model, options.set)

    from ...view.runs import at_start
    from ...view.show import show

    with doing_here(f"{options.scene}: assembling it"):
        found = at_start(model, parameters, inputs)

    note(found.notices)
    say = err if path and to_standard_output(path) else out
    say.print(str(show(found, path, tell=lambda text: note([text]))), soft_wrap=True)
