"""mbdfmi export: scenes as FMUs."""

from pathlib import Path

from ...files import check_ending, to_standard_output
from ..arguments import add_command, add_scene
from ..paths import load_scene, matching, writable
from ..terminal import doing, err, is_told, out, text_of


def add(commands):
    """The command and its arguments."""
    command = add_command(
        commands,
        run,
        "export",
        "write scenes as FMUs",
        """An FMU (FMI 2.0 or 3.0) holds all it needs: no Python and no compiler
where it runs. The first export of a version compiles the kernels, which takes
some minutes; later ones take a second.""",
        """examples:
  mbdfmi export crane.toml                      writes crane.fmu
  mbdfmi export crane.toml -o out/tower.fmu     under another name
  mbdfmi export models/*.toml -o fmus           one FMU for each, in a folder
  mbdfmi export crane.toml --fmi 3              as FMI 3.0
  mbdfmi export crane.toml --fmi 2,3            crane_fmi2.fmu and crane_fmi3.fmu
  mbdfmi export crane.toml --platform x86_64-linux --platform x86_64-windows""",
    )
    add_scene(command, "scenes", nargs="+")
    command.add_argument(
        "-o",
        "--output",
        metavar="PATH",
        help="the FMU when it ends in .fmu, - for the standard output, else a folder "
        "(default: <scene's name>.fmu here)",
    )
    command.add_argument(
        "--fmi",
        metavar="VERSION",
        default="2",
        help="2, 3, or 2,3 for a file of each (default: 2)",
    )
    command.add_argument(
        "--no-scene",
        action="store_true",
        help="keep the scene file out of the FMU (its numbers are in there all the same)",
    )
    command.add_argument(
        "--lean",
        action="store_true",
        help="without local variables: coordinates, poses and reactions that are no outputs of the scene",
    )
    command.add_argument(
        "--specialise",
        action="store_true",
        default=None,
        help="compile the kernels for this scene: a smaller and faster FMU, the same numbers "
        "(docs/specialise.md)",
    )
    command.add_argument(
        "--sources",
        action="store_true",
        default=None,
        help="put the scene's own code in C99 into the FMU too, for processors that no library is made for "
        "(docs/specialise.md)",
    )
    command.add_argument(
        "--bind",
        metavar="NAME,...",
        help="parameters that are constants of the FMU; all: but start values and those of the solver; "
        "its own code is faster still (docs/specialise.md)",
    )
    command.add_argument(
        "--at-rest",
        action="store_true",
        help="give the FMU a Boolean parameter, solver.start_at_equilibrium, false at first, that starts it "
        'at the static equilibrium; scenes with start = "equilibrium" have it anyhow, true at first',
    )
    command.add_argument(
        "--platform",
        action="append",
        metavar="NAME",
        help="x86_64-linux, aarch64-linux, x86_64-windows, x86_64-macos, aarch64-macos or all; "
        "may be repeated (default: this machine's)",
    )


def run(options):
    """Writes the FMUs, and says where; one broken scene does not keep the others from being built."""
    from ...compiler.model import c_identifier

    platforms = _platforms(options.platform)
    versions = _versions(options.fmi)
    files = [file for given in options.scenes for file in matching(given)]
    target = Path(options.output or "")
    one_file = _is_one_file(target, files, versions)
    say = err if to_standard_output(target) else out
    written, failures = {}, []

    for file in files:
        try:
            scene = load_scene(file, options)
            name = c_identifier(scene.name)
            names = [name] if len(versions) == 1 else [f"{name}_fmi{fmi}" for fmi in versions]
            paths = [writable(target if one_file else target / f"{name}.fmu", files) for name in names]

            if found := [written[path] for path in paths if path in written]:
                raise ValueError(f"{file}: has the same name as {found[0]}, so their FMUs would have too")

            for path, fmi in zip(paths, versions):
                with doing(f"{file}: exporting") as tell:
                    scene.export(
                        path,
                        platforms,
                        with_scene=not options.no_scene,
                        fmi=fmi,
                        lean=options.lean,
                        specialise=options.specialise,
                        with_sources=options.sources,
                        bind=options.bind and options.bind.split(","),
                        at_rest=options.at_rest,
                        progress=_about(file, tell),
                    )

                written[path] = file
                size = f"  ({path.stat().st_size / 1024:.0f} KB)" if path.is_file() else ""
                say.print(f"{path}{size}", soft_wrap=True)
        except Exception as error:
            if not is_told(error):
                raise

            failures.append(text_of(error))

    if failures:
        raise ValueError("\n".join(failures))


def _platforms(given):
    """Names of platforms as `export` takes them. Raises ValueError for one that is unknown."""
    from ...native.platforms import PLATFORMS

    if "all" in (given or []):
        return list(PLATFORMS)

    for name in given or []:
        if name not in PLATFORMS:
            raise ValueError(f"--platform {name}: unknown; there are {', '.join(PLATFORMS)} and all")

    return given


def _versions(given):
    """Versions of FMI, as `export` takes them, of --fmi. Raises ValueError for one that is unknown."""
    words = [word.strip() for word in given.split(",")]

    for word in words:
        if word not in ("2", "3"):
            raise ValueError(f"--fmi {given}: unknown; there are 2, 3 and 2,3")

    if len(set(words)) < len(words):
        raise ValueError(f"--fmi {given}: names a version twice; there are 2, 3 and 2,3")

    return sorted(int(word) for word in words)


def _is_one_file(target, files, versions):
    """Whether --output names the FMU itself and not a folder. Raises ValueError where it fits neither."""
    written_to = to_standard_output(target) or (target.exists() and not target.is_file())
    one_file = (target.suffix.lower() == ".fmu" or written_to) and not target.is_dir()

    if not (one_file or target.exists()):
        check_ending(target, "FMUs are to be written", ".fmu")

    if one_file and len(files) > 1:
        raise ValueError(f"--output {target}: one file cannot hold {len(files)} scenes; name a folder")

    if one_file and len(versions) > 1:
        raise ValueError(f"--output {target}: one file cannot be FMI 2 and FMI 3; name a folder")

    return one_file


def _about(file, tell):
    """`tell`, with the file's name before what is told."""
    return lambda text: tell(f"{file}: {text}")
