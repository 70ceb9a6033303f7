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
from importlib.metadata import version
from pathlib import Path
from typing import NamedTuple

import fmpy

from ..files import replacing
from ..kernels.language import cache_directory, source_hash
from . import aot, header


class Platform(NamedTuple):
    """What zig calls a platform, and where the library of an FMU for it lies."""

    target: str
    folders: tuple[str, ...]  # below binaries/ in FMI 2
    folder3: str  # in FMI 3
    suffix: str
    flags: tuple[str, ...] = ()


# what a library is called inside it: by default the path of the folder it was linked in
_MACOS = ("-Wl,-install_name,@rpath/fmu.dylib",)

PLATFORMS: dict[str, Platform] = {
    "x86_64-linux": Platform("x86_64-linux-gnu.2.17", ("linux64",), "x86_64-linux", ".so"),
    "aarch64-linux": Platform("aarch64-linux-gnu.2.17", ("aarch64-linux",), "aarch64-linux", ".so"),
    "x86_64-windows": Platform("x86_64-windows-gnu", ("win64",), "x86_64-windows", ".dll"),
    "x86_64-macos": Platform("x86_64-macos", ("darwin64",), "x86_64-darwin", ".dylib", _MACOS),
    "aarch64-macos": Platform(
        "aarch64-macos", ("aarch64-darwin", "darwin64"), "aarch64-darwin", ".dylib", _MACOS
    ),
}
"""Platforms that a library can be linked for, on any of them.

darwin64 is Intel's by the standard, but some tools look nowhere else on the newer Macs.
"""

FLAGS = (
    "-shared", "-fPIC", "-fvisibility=hidden", "-Wl,-z,defs", "-s",
    "-std=c99", "-O2", "-ffp-contract=off", "-fno-sanitize=all",
    "-Wall", "-Wextra", "-Wno-override-module",
)  # fmt: skip


class LinkError(Exception):
    """The library could not be linked; the text is the compiler's."""


def library(platform: str, progress: Callable[[str], None] = lambda text: None) -> Path:
    """The FMU library for a platform (a key of PLATFORMS): from the cache, or built into it.

    `progress` is told in a few words when something takes long. Raises aot.CompileError,
    LinkError, and ValueError for a platform that is not known.
    """
    if platform not in PLATFORMS:
        raise ValueError(f"unknown platform '{platform}': known are {', '.join(PLATFORMS)}")

    kernel_key = _hash([Path(aot.__file__)], source_hash(), f"llvmlite {version('llvmlite')}")
    key = _hash(_wrapper_files(), kernel_key, header.layout_header(), f"ziglang {version('ziglang')}")

    kernels = cache_directory() / "fmu" / f"{kernel_key}.ll"
    result = cache_directory() / "fmu" / f"{key}-{platform}{PLATFORMS[platform].suffix}"

    if not result.exists():
        if not kernels.exists():
            progress("compiling the kernels (once per version)")
            with replacing(kernels) as file:
                file.write_text(aot.compile_entries())

        progress(f"linking for {platform} (once per version)")
        with replacing(result) as file:
            _link(PLATFORMS[platform], kernels, file)

    return result


def wrapper_folder() -> Path:
    """The folder of the C wrapper: inside the installed package, beside it in the repository."""
    package = Path(__file__).parents[1]
    installed = package / "fmu_src"

    return installed if installed.is_dir() else package.parent / "fmu_src"


def _headers() -> Path:
    """The folder of the FMI headers, which fmpy carries."""
    return Path(fmpy.__file__).parent / "c-code"


def _wrapper_files() -> list[Path]:
    """All that a library is made of beside the kernels."""
    wrapper = sorted(wrapper_folder().glob("*.[ch]"))
    headers = sorted(_headers().glob("fmi[23]*.h"))

    return [*wrapper, *headers, Path(__file__)]


def _hash(files: list[Path], *texts: str) -> str:
    """Hash (hex) of the files' names and contents, and of the texts."""
    digest = hashlib.sha256("\0".join(texts).encode())

    for file in files:
        digest.update(b"\0" + file.name.encode() + b"\0" + file.read_bytes())

    return digest.hexdigest()[:20]


def _link(platform: Platform, kernels: Path, library: Path) -> None:
    """Links a platform's library from the wrapper and the kernels (LLVM IR)."""
    with tempfile.TemporaryDirectory() as folder:
        output = Path(folder) / f"fmu{platform.suffix}"
        sources = [*sorted(wrapper_folder().glob("*.c")), kernels]
        (Path(folder) / header.NAME).write_text(header.layout_header())
        command = [sys.executable, "-m", "ziglang", "cc", "-target", platform.target, *FLAGS, *platform.flags]
        command += [f"-I{folder}", f"-I{_headers()}", *map(str, sources), "-lm", "-o", str(output)]

        # zig keeps what it builds of a platform's C library
        environment = os.environ | {
            "ZIG_GLOBAL_CACHE_DIR": str(cache_directory() / "zig"),
            "ZIG_LOCAL_CACHE_DIR": str(Path(folder) / "zig"),
        }
        done = subprocess.run(command, env=environment, cwd=folder, capture_output=True, text=True)

        if done.returncode or not output.exists():
            raise LinkError(f"linking for {platform.target} failed:\n{done.stderr.strip()}")

        library.write_bytes(output.read_bytes())
