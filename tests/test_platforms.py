"""Libraries of other platforms are run: Windows' by wine, that of 64-bit ARM by qemu, of Macs their files are read."""

import os
import shutil
import struct
import subprocess
import sys
import warnings
from pathlib import Path

import fmpy
import numpy as np
import pytest

from mbdfmi.compiler.model import compile_scene
from mbdfmi.export import export_fmu, standard
from mbdfmi.export.universal import universal
from mbdfmi.native.platforms import PLATFORMS, host_platform
from mbdfmi.native.sources import cache_directory
from mbdfmi.scene import read_scene
from tests.model_files import SCENES

HERE = Path(__file__).parent
STEPS, H = 40, 0.0125  # s
ARM_ROOT = Path("/usr/aarch64-linux-gnu")  # of Debian's libc6-arm64-cross


def wine():
    """The command that runs Windows' programs here, or None."""
    found = shutil.which("wine64") or shutil.which("wine")
    debian = Path("/usr/lib/wine/wine64")
    return [found] if found else [str(debian)] if debian.exists() else None


def qemu():
    """The command that runs programs of 64-bit ARM here, or None."""
    found = shutil.which("qemu-aarch64")
    return [found, "-L", str(ARM_ROOT)] if found and ARM_ROOT.exists() else None


EMULATORS = {"x86_64-windows": wine, "aarch64-linux": qemu}
PACKAGES = {"x86_64-windows": "wine64", "aarch64-linux": "qemu-user libc6-arm64-cross"}


@pytest.fixture(scope="session")
def host(tmp_path_factory):
    """A function of a platform: the command that runs the test's master there. Skipped aloud where there is none."""
    folder = tmp_path_factory.mktemp("hosts")
    # wine keeps its drives and registry there; the first start makes them
    os.environ.setdefault("WINEPREFIX", str(folder / "wine"))
    os.environ.setdefault("WINEDEBUG", "-all")

    def command(platform):
        run = [] if platform == host_platform() else EMULATORS[platform]()

        if run is None:
            text = f"{platform} is NOT RUN: apt-get install {PACKAGES[platform]}"
            warnings.warn(text, stacklevel=2)
            pytest.skip(text)

        program = folder / f"{platform}.exe"

        if not program.exists():
            target = PLATFORMS[platform].target
            zig = [sys.executable, "-m", "ziglang", "cc", "-target", target, "-std=c99", "-O1"]
            files = [f"-I{standard.folder() / 'c-code'}", HERE / "platform_host.c", "-o", program]
            # where zig has built the platform's C library for the FMU
            kept = os.environ | {"ZIG_GLOBAL_CACHE_DIR": str(cache_directory() / "zig")}
            subprocess.run([*zig, *map(str, files)], check=True, env=kept)

        return [*run, str(program)]

    return command


def outputs(host, fmu, folder, platform):
    """Outputs of an unpacked FMU at all points (STEPS, n)."""
    description = fmpy.read_model_description(str(fmu))
    references = {
        causality: ",".join(
            str(v.valueReference) for v in description.modelVariables if v.causality == causality
        )
        for causality in ("input", "output")
    }
    place, suffix = PLATFORMS[platform].folders[0], PLATFORMS[platform].suffix
    library = folder / "binaries" / place / f"{description.coSimulation.modelIdentifier}{suffix}"
    # wine shows the machine's files on drive Z:, as an URI of a share would be
    uri = (folder / "resources").as_uri()
    uri = uri.replace("file://", "file:///Z:") if platform == "x86_64-windows" else uri
    given = [library, uri, description.guid, STEPS, H, references["input"] or "-", references["output"]]
    done = subprocess.run([*host(platform), *map(str, given)], capture_output=True, text=True)
    assert done.returncode == 0, done.stderr[-3000:]
    return np.array([[float.fromhex(number) for number in line.split()] for line in done.stdout.splitlines()])


def compare(host, path, folder, platform):
    """Outputs there and here, as parts of the largest of each, and of 1e-3 of their unit (gaps are rounding): how far apart."""
    fmu = export_fmu(compile_scene(read_scene(path)), folder / "a.fmu", [platform, host_platform()])
    fmpy.extract(str(fmu), str(folder / "a"))
    there, here = (outputs(host, fmu, folder / "a", name) for name in (platform, host_platform()))
    assert there.shape == here.shape and len(here) == STEPS
    return np.max(np.abs(there - here) / np.maximum(np.abs(here).max(0), 1e-3))


@pytest.mark.long
@pytest.mark.parametrize("path", SCENES, ids=lambda path: path.stem)
@pytest.mark.parametrize("platform", EMULATORS)
def test_every_scene_on_other_platforms(path, platform, host, tmp_path, check):
    """ARM gives the same bits, Windows what another library of mathematics makes of them; rollback inside."""
    if platform == host_platform():
        pytest.skip("that is this machine's own")

    check(compare(host, path, tmp_path, platform), 5e-324 if platform == "aarch64-linux" else 1e-11)


# Macs: their files are read


PROCESSORS = {"x86_64-macos": 0x01000007, "aarch64-macos": 0x0100000C}
COMMANDS = {"version": 0x32, "name": 0xD, "signature": 0x1D}


def slices(data):
    """Processor -> the library for it, of a file for several."""
    magic, n = struct.unpack_from(">2I", data)
    assert magic == 0xCAFEBABE
    rows = [struct.unpack_from(">5I", data, 8 + 20 * k) for k in range(n)]
    assert all(at % (1 << align) == 0 for _, _, at, _, align in rows)
    return {processor: data[at : at + size] for processor, _, at, size, _ in rows}


def load_commands(data):
    """(command, its bytes) of a library for a Mac."""
    magic, _, _, kind, n = struct.unpack_from("<5I", data)
    assert (magic, kind) == (0xFEEDFACF, 6)  # 64 bits, a dylib
    at = 32

    for _ in range(n):
        command, size = struct.unpack_from("<2I", data, at)
        yield command & 0x7FFFFFFF, data[at : at + size]
        at += size


def test_one_file_for_two_processors():
    """Slices of any length come out as they went in; what is no library for a Mac is refused."""
    given = {
        processor: struct.pack("<3I", 0xFEEDFACF, processor, 3) + bytes(range(k, 99))
        for k, processor in enumerate(PROCESSORS.values())
    }
    assert slices(universal(list(given.values()))) == given

    with pytest.raises(ValueError, match="no library for a Mac"):
        universal([b"\x7fELF" + bytes(20)])


@pytest.mark.long
def test_libraries_for_macs(tmp_path):
    """darwin64 serves both processors, from macOS 11 on, under a name that has no folder of ours in it; signed for ARM."""
    path = next(path for path in SCENES if path.stem == "pendulum")
    fmu = export_fmu(compile_scene(read_scene(path)), tmp_path / "a.fmu", list(PROCESSORS))
    fmpy.extract(str(fmu), str(tmp_path / "a"))
    (both,) = (tmp_path / "a" / "binaries" / "darwin64").iterdir()
    (arm,) = (tmp_path / "a" / "binaries" / "aarch64-darwin").iterdir()
    found = slices(both.read_bytes())
    assert set(found) == set(PROCESSORS.values())
    assert found[PROCESSORS["aarch64-macos"]] == arm.read_bytes()

    for data in found.values():
        commands = dict(load_commands(data))
        assert struct.unpack_from("<I", commands[COMMANDS["version"]], 12)[0] >> 16 == 11
        assert b"@rpath/fmu.dylib\0" in commands[COMMANDS["name"]]
        assert b"fmi2DoStep" in data and str(tmp_path).encode() not in data

    assert COMMANDS["signature"] in dict(load_commands(arm.read_bytes()))
