"""The shared library of an FMU: C wrapper and compiled kernels, linked by zig for any platform.

The library is the same for every scene. It is built once per version and platform and kept in the
cache folder under a hash of all that it is made of.
"""

import hashlib
import os
import subprocess
import sys
import tempfile
from collections.abc import Callable
from pathlib import Path

from ..files import replacing
from ..native import library as native
from ..native import platforms
from ..native.platforms import PLATFORMS, Platform
from ..native.sources import cache_directory, source_hash
from . import aot, header, standard

FLAGS = (
    "-fPIC", "-fvisibility=hidden", "-Wl,-z,defs", "-s",
    "-std=c99", "-O2", "-ffp-contract=off", "-fno-sanitize=all",
    "-Wall", "-Wextra", "-Wno-override-module",
)  # fmt: skip


class LinkError(Exception):
    """The library could not be linked; the text is the compiler's."""


def library(platform: str, progress: Callable[[str], None] = lambda text: None) -> Path:
    """The FMU library for a platform (a key of PLATFORMS): that of the package, from the cache, or built
    into it.

    `progress` is told in a few words when something takes long. Raises aot.CompileError,
    LinkError, and ValueError for a platform that is not known.
    """
    if platform not in PLATFORMS:
        raise ValueError(f"unknown platform '{platform}': known are {', '.join(PLATFORMS)}")

    name = library_name(platform)

    for folder in native.folders():
        if (folder / name).exists():
            return folder / name

    result = cache_directory() / "fmu" / name
    halves = kernels(progress)
    progress(f"linking for {platform} (once per version)")

    with replacing(result) as file:
        link(PLATFORMS[platform], halves, file)

    return result


def library_name(platform: str) -> str:
    """What the library for a platform is called: by the sources of the kernels, and by those of the rest."""
    return f"{source_hash()}-{wrapper_hash()}-{platform}{PLATFORMS[platform].suffix}"


def wrapper_hash() -> str:
    """Hash (hex) of all that a library is made of beside the kernels."""
    return _hash(_wrapper_files(), header.layout_header())


def kernels(progress):
    """The compiled kernels (LLVM IR), from the cache or made into it."""
    names = [f"{source_hash()}-{half}.ll" for half in range(aot.HALVES)]
    files = [cache_directory() / "fmu" / name for name in names]

    if all(file.exists() for file in files):
        return files

    with native.alone(f"{source_hash()}-kernels"):
        if not all(file.exists() for file in files):
            progress("compiling the kernels (once per version: a minute or two)")

            for path, text in zip(files, aot.compile_kernels()):
                with replacing(path) as file:
                    file.write_text(text)

    return files


def wrapper_folder() -> Path:
    """The folder of the C wrapper: inside the installed package, beside it in the repository."""
    package = Path(__file__).parents[1]
    installed = package / "fmu_src"

    return installed if installed.is_dir() else package.parent / "fmu_src"


OTHERS = {2: ("fmi3",), 3: ("fmi2",)}
"""Beginnings of names of wrapper files that another version of FMI has."""


def wrapper_sources(fmi: int | None = None) -> list[Path]:
    """The C files of the wrapper, of one version of FMI or of all."""
    files = sorted(wrapper_folder().glob("*.c"))
    return [path for path in files if fmi is None or not path.name.startswith(OTHERS[fmi])]


def _headers() -> Path:
    """The folder of the FMI headers, which fmpy carries."""
    return standard.folder() / "c-code"


def _wrapper_files() -> list[Path]:
    """All that a library is made of beside the kernels."""
    wrapper = sorted(wrapper_folder().glob("*.[ch]"))
    headers = sorted(_headers().glob("fmi[23]*.h"))

    return [*wrapper, *headers, Path(__file__), Path(platforms.__file__)]


def _hash(files: list[Path], *texts: str) -> str:
    """Hash (hex) of the files' names and contents, and of the texts."""
    digest = hashlib.sha256("\0".join(texts).encode())

    for file in files:
        digest.update(b"\0" + file.name.encode() + b"\0" + file.read_bytes())

    return digest.hexdigest()[:20]


def link(
    platform: Platform,
    compiled: list[Path],
    library: Path,
    table_text: str | None = None,
    flags: tuple = (),
    wrapper_flags: tuple = (),
    fmi: int | None = None,
) -> None:
    """Links a platform's library from the wrapper and the kernels (`compiled`: LLVM IR, or C), which are
    made side by side.

    table_text : of the table of kernels, by default of all that stand apart. flags, wrapper_flags : more of
    the compiler's, for what is compiled, and for the wrapper. fmi : the version that it knows, by default all.
    """
    with tempfile.TemporaryDirectory() as name:
        folder = Path(name)
        table = folder / "table.c"
        table.write_text(table_text or header.table_of_kernels())
        objects = [folder / f"{source.stem}.o" for source in compiled]
        _zig(
            platform, folder, [(*flags, "-c", source, "-o", made) for source, made in zip(compiled, objects)]
        )

        output = folder / f"fmu{platform.suffix}"
        sources = [*wrapper_objects(platform, wrapper_flags, fmi), table, *objects]
        _zig(platform, folder, [("-shared", *platform.flags, *wrapper_flags, *sources, "-lm", "-o", output)])
        library.write_bytes(output.read_bytes())


def wrapper_objects(platform: Platform, flags: tuple, fmi: int | None) -> list[Path]:
    """The wrapper compiled for a platform, of one version of FMI or of all, made once and kept: it is the same
    for all scenes. Raises LinkError.
    """
    # the linker's would take all away from a file that by itself calls nothing
    flags = tuple(flag for flag in flags if not flag.startswith("-Wl,"))
    digest = hashlib.sha256("\0".join([wrapper_hash(), platform.target, str(fmi), *flags]).encode())
    kept = cache_directory() / "wrapper" / digest.hexdigest()[:20]
    sources = wrapper_sources(fmi)
    objects = [kept / f"{source.stem}.o" for source in sources]

    with native.alone(f"wrapper-{kept.name}"):
        if not all(path.exists() for path in objects):
            kept.mkdir(parents=True, exist_ok=True)

            with tempfile.TemporaryDirectory(dir=kept) as name:
                folder = Path(name)
                (folder / header.NAME).write_text(header.layout_header())
                given = (*flags, f"-I{folder}", f"-I{_headers()}", "-c")
                made = [folder / path.name for path in objects]
                tasks = [(*given, source, "-o", path) for source, path in zip(sources, made)]
                together = os.cpu_count() or 1

                for k in range(0, len(tasks), together):
                    _zig(platform, folder, tasks[k : k + together])

                for path, to in zip(made, objects):
                    path.replace(to)

    return objects


def _zig(platform, folder, tasks):
    """Runs zig's C compiler for each of some lists of arguments, all at once. Raises LinkError."""
    # zig keeps what it builds of a platform's C library
    environment = os.environ | {
        "ZIG_GLOBAL_CACHE_DIR": str(cache_directory() / "zig"),
        "ZIG_LOCAL_CACHE_DIR": str(folder / "zig"),
    }
    command = [sys.executable, "-m", "ziglang", "cc", "-target", platform.target, *FLAGS]
    running = [
        subprocess.Popen(
            [*command, *map(str, task)],
            env=environment,
            cwd=folder,
            stdout=subprocess.PIPE,
            stderr=subprocess.STDOUT,
            text=True,
        )
        for task in tasks
    ]
    told = [process.communicate()[0] for process in running]

    for process, text in zip(running, told):
        if process.returncode:
            raise LinkError(f"linking for {platform.target} failed:\n{text.strip()}")
