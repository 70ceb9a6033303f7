"""C and C++ beside this file, compiled for this processor when they are first needed."""

import ctypes
import hashlib
import os
import subprocess
import sys
import tempfile
from importlib.metadata import version
from pathlib import Path

from mbdfmi.files import replacing
from mbdfmi.kernels.steppers import tableaux
from mbdfmi.native.sources import cache_directory

HEADERS = ("dop853.h",)


class Missing(Exception):
    """A peer cannot be had here; the text says why and what would help."""


def compiled(name: str, *flags: str, folders=(), versions: tuple[str, ...] = ()) -> ctypes.CDLL:
    """A source beside this file as a library, kept in the cache under a hash of all that it is made of.

    folders : of headers. versions : of what these belong to. Raises Missing.
    """
    source = Path(__file__).with_name(name)
    parts = [source.read_bytes(), *(source.with_name(header).read_bytes() for header in HEADERS)]
    parts += [_tableau().encode(), repr((flags, folders, versions, version("ziglang"))).encode()]
    suffix = {"nt": "dll"}.get(os.name, "so")
    made_of = hashlib.sha256(b"".join(parts)).hexdigest()[:20]
    library = cache_directory() / "bench" / f"{source.stem}_{made_of}.{suffix}"

    if not library.exists():
        language = ["c++", "-std=c++17"] if source.suffix == ".cpp" else ["cc", "-std=c99"]

        with replacing(library) as path, tempfile.TemporaryDirectory() as made:
            (Path(made) / "tableau.h").write_text(_tableau())
            command = [
                sys.executable,
                "-m",
                "ziglang",
                *language,
                "-O3",
                "-DNDEBUG",
                "-march=native",
                "-s",
                "-w",
            ]
            command += ["-fPIC", "-shared", *flags, *(f"-I{folder}" for folder in (made, *folders))]
            done = subprocess.run([*command, str(source), "-o", str(path)], capture_output=True, text=True)

            if done.returncode:
                raise Missing(f"{name} does not compile: {done.stderr.strip().partition(chr(10))[0]}")

    return ctypes.CDLL(str(library))


def _tableau() -> str:
    """Our 8(5,3) pair as a C header: a step's stages, the last the result, and two estimates of the error."""
    n = int(tableaux.STAGE_COUNT[1])

    def rows(table):
        return ",\n".join("{" + ", ".join(repr(float(x)) for x in row) + "}" for row in table)

    return (
        f"enum {{ STAGES = {n}, FINE = 0 }};\n"
        f"static const double WEIGHTS[STAGES][STAGES] = {{\n{rows(tableaux.STAGES[1, :n, :n])}\n}};\n"
        f"static const double ERRORS[2][STAGES] = {{\n{rows(tableaux.ERRORS[1, :, :n])}\n}};\n"
    )
