"""The FMU: an archive of description, library, resources, documentation and icon."""

import os
import zipfile
from collections.abc import Callable, Iterable
from pathlib import Path

from ..compiler.survey import MOST_LOCALS
from ..files import check_ending, replacing, same
from ..kernels.status import MESSAGES, ONLY_WITH
from ..native.platforms import PLATFORMS, host_platform
from . import terminals
from .description import description, generation_time
from .description3 import description3
from .documentation import documentation
from .link import library
from .resource import NAME, resource
from .tape import tape
from .universal import universal

DESCRIPTIONS = {2: description, 3: description3}
"""Who writes modelDescription.xml, by versions of FMI."""


PICTURE = "scene.png"
"""The picture beside the page of documentation."""


def export_fmu(
    model,
    path: str | os.PathLike,
    platforms: Iterable[str] | None = None,
    *,
    fmi: int = 2,
    scene_file: str | os.PathLike | None = None,
    pictures: tuple[bytes, bytes] | None = None,
    specialise: bool = False,
    with_sources: bool = False,
    lean: bool = False,
    progress: Callable[[str], None] = lambda text: None,
) -> Path:
    """Write a model as an FMU for co-simulation, and model exchange where it can, and return its path.

    platforms   keys of mbdfmi.native.platforms.PLATFORMS; default: the machine's own
    fmi         version of FMI: 2 (2.0) or 3 (3.0)
    scene_file  the file that the model was read from, to go with the FMU in resources/
    pictures    of the scene (PNG), for the page of documentation and for the icon; without them a general icon
    specialise  libraries of this scene alone, smaller and faster (docs/specialise.md); compiled for it now
    with_sources  the scene's own code in C99 too, in sources/ (docs/specialise.md)
    lean        without local variables
    progress    is told in a few words when something takes long

    The file is written whole or not at all; "-" is the standard output. With SOURCE_DATE_EPOCH set, the same
    model gives the same bytes. Raises OSError, ValueError (unknown platform or version, unfit path),
    aot.CompileError, link.LinkError and description.DescriptionError.
    """
    path = Path(path)
    check_ending(path, "an FMU is to be written", ".fmu", ".zip")

    if scene_file and same(path, scene_file):
        raise ValueError(f"{path}: is the scene's own file; write the FMU under another name")

    if fmi not in DESCRIPTIONS:
        raise ValueError(f"fmi = {fmi!r}: the versions of FMI that an FMU can be written for are 2 and 3")

    chosen = sorted(set(platforms or [host_platform()]))  # x86_64 last: it wins where folders clash

    if model.surveys.left_out and not (lean or specialise or with_sources):
        progress(f"without {model.surveys.left_out}, which would be more than {MOST_LOCALS} numbers")

    if (specialise or with_sources) and model.told_aside:
        progress("without local variables: the scene's own code is of its outputs alone")

    if lean or specialise or with_sources:
        model = model.lean(whole=specialise or with_sources)

    if not model.exchanges:
        progress(f"for co-simulation only, without model exchange: {_why_not_exchanged(model)}")

    found = None

    # what traces a whole scene is imported for scenes with code of their own alone
    if specialise or with_sources:
        from . import sources
        from .specialise import own, scene_library

        found = own(model)
        progress(found.told)

    icon = pictures[1] if pictures else (Path(__file__).parent / "model.png").read_bytes()
    texts = {
        code: text
        for code, text in MESSAGES.items()
        if code not in ONLY_WITH or getattr(model, ONLY_WITH[code])
    }
    files = {
        "modelDescription.xml": DESCRIPTIONS[fmi](model, sources.compiled(fmi) if with_sources else ()),
        "model.png": icon,
        terminals.NAME: terminals.terminals(model, fmi),
        terminals.ICON: icon,
        "documentation/index.html": documentation(model, chosen, fmi, PICTURE if pictures else None),
        "documentation/licenses/license.txt": _licence(),
        f"resources/{NAME}": resource(model, texts, tape(model)),
    }
    if pictures:
        files[f"documentation/{PICTURE}"] = pictures[0]

    if scene_file:
        files[f"resources/{Path(scene_file).name}"] = Path(scene_file).read_bytes()

    if with_sources and found:
        files |= sources.sources(model, fmi, found.traced)

    made = {
        name: (
            scene_library(model, name, progress, found, fmi) if specialise else library(name, progress)
        ).read_bytes()
        for name in chosen
    }

    for name, data in made.items():
        for folder in (PLATFORMS[name].folder3,) if fmi == 3 else PLATFORMS[name].folders:
            files[f"binaries/{folder}/{model.identifier}{PLATFORMS[name].suffix}"] = data

    macs = [name for name in chosen if name.endswith("macos")]

    if fmi == 2 and len(macs) > 1:
        files[f"binaries/darwin64/{model.identifier}.dylib"] = universal([made[name] for name in macs])

    _write_archive(path, files)
    return path


def _why_not_exchanged(model):
    """Why a model has no model exchange."""
    if model.n_command:
        return (
            "inputs command motions without their accelerations, which are found from one communication step to the next; "
            "with input = true there is model exchange too"
        )

    return (
        "too many outputs depend on too many states" if model.n_x else "nothing in the scene moves by forces"
    )


def _licence() -> bytes:
    """The licence of the library in an FMU: inside the installed package, beside it in the repository."""
    package = Path(__file__).parents[1]
    installed = package / "LICENSE"

    return (installed if installed.is_file() else package.parent / "LICENSE").read_bytes()


# from this size on (bytes) files are packed at zlib's level 5: half the time of its usual 6 for 1.5 % more, and small ones
# count where a controller keeps them
LARGE = 500_000


def _write_archive(path: Path, files: dict[str, bytes]) -> None:
    """Writes a zip file whose bytes follow from the contents and the generation time alone."""
    time = max(generation_time().timetuple()[:6], (1980, 1, 1, 0, 0, 0))  # zip knows no earlier

    with replacing(path) as temporary, zipfile.ZipFile(temporary, "w") as archive:
        for name, data in files.items():
            entry = zipfile.ZipInfo(name, time)
            entry.compress_type = zipfile.ZIP_DEFLATED
            entry.external_attr = 0o644 << 16
            archive.writestr(entry, data, compresslevel=5 if len(data) > LARGE else None)
