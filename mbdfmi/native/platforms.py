"""Platforms that libraries are made for."""

import platform as host
from typing import NamedTuple


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
    "aarch64-linux": Platform("aarch64-linux-gnu.2.17", ("aarch64-linux", "linux64"), "aarch64-linux", ".so"),
    "x86_64-windows": Platform("x86_64-windows-gnu", ("win64",), "x86_64-windows", ".dll"),
    "x86_64-macos": Platform("x86_64-macos.11.0", ("darwin64",), "x86_64-darwin", ".dylib", _MACOS),
    "aarch64-macos": Platform(
        "aarch64-macos.11.0", ("aarch64-darwin", "darwin64"), "aarch64-darwin", ".dylib", _MACOS
    ),
}
"""Platforms that a library can be linked for, on any of them.

darwin64 and linux64 are Intel's by the standard, but some tools (fmpy) look nowhere else on machines of
ARM. Where an FMU is for both processors linux64 is Intel's, and darwin64 serves both. Macs: from macOS 11 on,
the first for ARM.
"""


def this_machine() -> str:
    """This machine, as the keys of PLATFORMS are written, whether it is one of them or not."""
    machine, system = host.machine().lower(), host.system().lower()
    machine = {"amd64": "x86_64", "arm64": "aarch64"}.get(machine, machine)
    system = {"darwin": "macos"}.get(system, system)
    return f"{machine}-{system}"


def has_library() -> bool:
    """Whether libraries are made for this machine."""
    return this_machine() in PLATFORMS


def host_platform() -> str:
    """The key of PLATFORMS for this machine; ValueError when it has none."""
    name = this_machine()

    if name not in PLATFORMS:
        raise ValueError(f"no FMU can be made for {name} yet: known are {', '.join(PLATFORMS)}")

    return name
