"""Libraries of other platforms are run: Windows' by wine, that of 64-bit ARM by qemu, of Macs their files are read.

A few scenes in every run of the tests, every scene of models/ behind `-m long`.
"""

import hashlib
import math
import os
import shutil
import struct
import subprocess
import sys
import tempfile
import warnings
import zipfile
from collections import defaultdict
from pathlib import Path
from urllib.parse import quote

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
REAL = ("Real", "Float64")
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
            # flags of the FMU's library: others would build the platform's C library anew, some hundred files
            zig = [sys.executable, "-m", "ziglang", "cc", "-target", target, "-std=c99", "-O2", "-s"]
            files = [f"-I{standard.folder() / 'c-code'}", HERE / "platform_host.c", "-o", program]
            kept = os.environ | {"ZIG_GLOBAL_CACHE_DIR": str(cache_directory() / "zig")}
            subprocess.run([*zig, *map(str, files)], check=True, env=kept)

        return [*run, str(program)]

    return command


def outputs(host, folder, platform, fmi, scheme="file:///"):
    """Outputs of an unpacked FMU at all points (STEPS, n). scheme : how an URI of its resources begins."""
    description = fmpy.read_model_description(str(folder))
    chosen = {
        causality: [v for v in description.modelVariables if v.causality == causality and v.type in REAL]
        for causality in ("input", "output")
    }
    references = [",".join(str(v.valueReference) for v in some) or "-" for some in chosen.values()]
    sizes = [sum(math.prod(v.shape or ()) for v in some) for some in chosen.values()]
    row = PLATFORMS[platform]
    place = row.folders[0] if fmi == 2 else row.folder3
    library = folder / "binaries" / place / f"{description.coSimulation.modelIdentifier}{row.suffix}"
    # wine shows the machine's files on drive Z:
    resources = f"{'Z:' if platform == 'x86_64-windows' else ''}{folder / 'resources'}/"
    resources = resources if fmi == 3 else scheme + quote(resources.removeprefix("/"), safe="/:")
    given = [fmi, library, resources, description.guid, STEPS, H, *references, *sizes]
    done = subprocess.run([*host(platform), *map(str, given)], capture_output=True, text=True)
    assert done.returncode == 0, done.stderr[-3000:]
    return np.array([[float.fromhex(number) for number in line.split()] for line in done.stdout.splitlines()])


def sizes_of(folder, rows):
    """The largest of each output of some rows, or a thousandth of the largest of its unit, or of 1."""
    variables = fmpy.read_model_description(str(folder)).modelVariables
    shown = [v for v in variables if v.causality == "output" and v.type in REAL]
    units = [v.unit for v in shown for _ in range(math.prod(v.shape or ()))]
    own, largest = np.abs(rows).max(0), defaultdict(lambda: 1.0)

    for unit, value in zip(units, own, strict=True):
        largest[unit] = max(largest[unit], value)

    return np.maximum(own, [1e-3 * largest[unit] for unit in units])


def compare(host, path, folder, platform):
    """How far apart outputs there and here are at most, in both versions of FMI: as parts of the largest of each, and at least
    of a thousandth of the largest of their unit (energies that sum to zero, gaps are rounding of what is as large).
    """
    model, found = compile_scene(read_scene(path)), []

    for fmi in (2, 3):
        place = folder / f"fmi{fmi}"
        fmu = export_fmu(model, folder / f"{fmi}.fmu", [platform, host_platform()], fmi=fmi)
        fmpy.extract(str(fmu), str(place))
        there, here = (outputs(host, place, name, fmi) for name in (platform, host_platform()))
        assert there.shape == here.shape and len(here) == STEPS
        size = sizes_of(place, here)
        found.append(np.max(np.abs(there - here) / size, initial=0.0))

    return max(found)


def hold(check, platform, error):
    """ARM gives the same bits, Windows what another library of mathematics makes of them."""
    check(error, 5e-324 if platform == "aarch64-linux" else 1e-11)


def foreign(platform):
    """Skips where the platform is this machine's own."""
    if platform == host_platform():
        pytest.skip("that is this machine's own")


@pytest.mark.parametrize(
    "chosen, fmi, folders",
    [
        (["aarch64-linux"], 2, {"aarch64-linux", "linux64"}),
        (["aarch64-linux"], 3, {"aarch64-linux"}),
        (["aarch64-linux", "x86_64-linux"], 2, {"aarch64-linux", "linux64"}),
    ],
)
def test_where_libraries_lie(chosen, fmi, folders, tmp_path, monkeypatch):
    """fmpy looks for that of ARM in linux64 (FMI 2); where there is one of Intel, that lies there."""
    for platform in chosen:
        (tmp_path / platform).write_text(platform)

    monkeypatch.setattr("mbdfmi.export.package.library", lambda name, progress: tmp_path / name)
    model = compile_scene(read_scene(next(path for path in SCENES if path.stem == "pendulum")))
    fmu = export_fmu(model, tmp_path / "a.fmu", chosen, fmi=fmi)

    with zipfile.ZipFile(fmu) as archive:
        found = {
            name.split("/")[1]: archive.read(name).decode()
            for name in archive.namelist()
            if name.startswith("binaries")
        }

    assert set(found) == folders and found["aarch64-linux"] == "aarch64-linux"
    assert found.get("linux64", chosen[-1]) == chosen[-1]


@pytest.mark.parametrize("platform", EMULATORS)
@pytest.mark.parametrize("scene", ["four_bar", "floating_wind_turbine"])
def test_some_scenes_on_other_platforms(scene, platform, host, tmp_path, check):
    foreign(platform)
    (path,) = (path for path in SCENES if path.stem == scene)
    hold(check, platform, compare(host, path, tmp_path, platform))


@pytest.mark.long
@pytest.mark.parametrize("path", SCENES, ids=lambda path: path.stem)
@pytest.mark.parametrize("platform", EMULATORS)
def test_every_scene_on_other_platforms(path, platform, host, tmp_path, check):
    """Rollback inside."""
    foreign(platform)
    hold(check, platform, compare(host, path, tmp_path, platform))


def test_addresses_of_windows(host, tmp_path):
    """One to three slashes before the drive, below a folder of odd letters."""
    foreign("x86_64-windows")
    model = compile_scene(read_scene(next(path for path in SCENES if path.stem == "pendulum")))
    folder = tmp_path / "with blanks, 100 % \u00e4\u00f6"
    fmpy.extract(str(export_fmu(model, tmp_path / "a.fmu", ["x86_64-windows"])), str(folder))
    runs = [
        outputs(host, folder, "x86_64-windows", 2, scheme)
        for scheme in ("file:///", "file://", "file:/", "file://localhost/")
    ]
    assert all(np.array_equal(run, runs[0]) for run in runs)


# Macs: their files are read


PROCESSORS = {"x86_64-macos": 0x01000007, "aarch64-macos": 0x0100000C}
COMMANDS = {"symbols": 0x2, "imports": 0xC, "name": 0xD, "signature": 0x1D, "version": 0x32}


SYSTEM = b"/usr/lib/libSystem.B.dylib"
IN_MACOS_11 = set(
    "__bzero __sincos_stret __tolower tolower acos asin asinh atan2 calloc ceil cos exp fclose floor fopen fread free fseek ftell log"
    " malloc memchr memcmp memcpy memmove memset memset_pattern16 nextafter pow sin snprintf strcmp strcpy strlen strstr"
    " strtoll tanh trunc vsnprintf bzero dyld_stub_binder fmod tan atan sinh cosh rint round log10 expm1 log1p hypot"
    " strncmp strchr".split()
)
"""What the libraries may want of the system: it was there long before."""

LINKERS = ("__dso_handle", "_mh_dylib_header")
"""Symbols that linkers add."""


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


def symbols(data, commands):
    """Names of the symbols that a library for a Mac shows to others, and of those that it wants of them."""
    (table,) = commands[COMMANDS["symbols"]]
    at, n, texts, _ = struct.unpack_from("<4I", table, 8)
    shown, wanted = set(), set()

    for k in range(n):
        name, kind, _, _, _ = struct.unpack_from("<IBBHQ", data, at + 16 * k)
        if kind & 0xE1 == 0x01:  # external, not of a debugger
            start = texts + name
            (wanted if kind & 0x0E == 0 else shown).add(
                data[start : data.index(b"\0", start)].decode().removeprefix("_")
            )

    return shown, wanted


def check_signature(data, commands):
    """That pages of a library have the hashes that its signature says (cs_blobs.h of xnu)."""
    ((_, _, at, _),) = (struct.unpack_from("<4I", given) for given in commands[COMMANDS["signature"]])
    magic, _, count = struct.unpack_from(">3I", data, at)
    assert magic == 0xFADE0CC0 and count > 0
    directory = at + struct.unpack_from(">I", data, at + 16)[0]
    magic, _, _, _, hashes, _, _, slots, limit = struct.unpack_from(">9I", data, directory)
    size, kind, _, page = struct.unpack_from(">4B", data, directory + 36)
    assert (magic, size, kind) == (0xFADE0C02, 32, 2) and limit == at  # SHA-256 of all before it
    assert slots == -(-limit // (1 << page))

    for k in range(slots):
        place = directory + hashes + 32 * k
        part = data[k << page : min((k + 1) << page, limit)]
        assert hashlib.sha256(part).digest() == data[place : place + 32], k


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

    for processor, data in found.items():
        commands = defaultdict(list)
        for command, given in load_commands(data):
            commands[command].append(given)

        (version,), (name,) = commands[COMMANDS["version"]], commands[COMMANDS["name"]]
        assert struct.unpack_from("<2I", version, 8) == (1, 11 << 16)  # macOS, 11.0
        assert b"@rpath/fmu.dylib\0" in name
        assert [given[24:].rstrip(b"\0") for given in commands[COMMANDS["imports"]]] == [SYSTEM]

        shown, wanted = symbols(data, commands)
        assert {"fmi2DoStep", "fmi3DoStep", "mbdfmi_kernels"} <= shown
        assert all(name.startswith(("fmi2", "fmi3")) for name in shown - {"mbdfmi_kernels", *LINKERS})
        assert wanted <= IN_MACOS_11, wanted - IN_MACOS_11
        assert not any(
            str(folder).encode() in data for folder in (tmp_path, cache_directory(), tempfile.gettempdir())
        )

        if processor == PROCESSORS["aarch64-macos"]:
            check_signature(data, commands)
