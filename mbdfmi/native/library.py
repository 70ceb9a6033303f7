"""Kernels in the library that FMUs carry, called by ctypes.

The library comes with an installed package; of a checkout, whose kernels may change, it is made when it is
first needed, by a process of its own (`python -m mbdfmi.export`), and kept in the cache folder.
"""

import contextlib
import ctypes
import operator
import os
import sys
from collections.abc import Callable
from functools import cache, wraps
from pathlib import Path

import numpy as np

from .platforms import PLATFORMS, host_platform
from .sources import cache_directory, source_hash

PACKAGED = Path(__file__).parent / "libraries"
"""Where the libraries of an installed package are."""

TABLE = "mbdfmi_kernels"
"""The symbol that a library shows beside those of FMI: a table of the names and addresses of its kernels."""

# what numba gives for a place of exceptions: nothing is ever written to it
_no_exception = ctypes.c_void_p()

_NUMBERS = {"boolean": ctypes.c_uint8, "int64": ctypes.c_int64, "float64": ctypes.c_double}
_ARGUMENTS = _NUMBERS | {"REALS": ctypes.c_void_p}
_ADDRESSES = {"MODEL": 2, "DATA": 4}


class LibraryError(ImportError):
    """The library of the kernels is not there and could not be made; the text says why, and what would do."""


def folders() -> tuple[Path, Path]:
    """Where libraries are looked for."""
    return PACKAGED, cache_directory() / "fmu"


def find() -> Path | None:
    """A library of these kernels for this machine, or None.

    Of those that a checkout has made with one wrapper after another it is the newest.
    """
    platform = host_platform()
    name = f"{source_hash()}-*-{platform}{PLATFORMS[platform].suffix}"

    for folder in folders():
        if found := list(folder.glob(name)):
            return max(found, key=lambda path: path.stat().st_mtime_ns)

    return None


def ready(tell: Callable[[str], None] | None = None) -> Path:
    """The library of these kernels, made now if it is not there.

    tell : is given a few words when something takes long; by default they are written to the standard error.
    """
    found = find()

    if found is None:
        with alone(source_hash()):
            found = find() or _make(
                tell or (lambda text: print(f"mbdfmi: {text}", file=sys.stderr, flush=True))
            )

    return found


def _make(tell):
    """Makes the library, in a process of its own."""
    import subprocess

    command = [sys.executable, "-m", "mbdfmi.export", host_platform()]
    environment = os.environ | {"PYTHONPATH": os.pathsep.join(path for path in sys.path if path)}

    with subprocess.Popen(
        command, env=environment, stdout=subprocess.PIPE, stderr=subprocess.PIPE, text=True
    ) as process:
        assert process.stdout and process.stderr

        for line in process.stdout:
            tell(line.rstrip())

        failure = process.stderr.read().strip()

    found = find()

    if process.returncode or found is None:
        raise LibraryError(
            "the kernels must be compiled first, for no library is of their sources, and that fails; "
            f"MBDFMI_INTERPRETED=1 runs them as plain Python, slowly:\n{failure}"
        )

    return found


@contextlib.contextmanager
def alone(name: str):
    """Where several processes want to make the same thing in the cache, one makes it and the others wait."""
    path = cache_directory() / f"{name}.lock"
    path.parent.mkdir(parents=True, exist_ok=True)

    with open(path, "w") as file:
        _lock(file)
        yield

    with contextlib.suppress(OSError):
        path.unlink()


def _lock(file):
    """Waits until no other process holds the file; its end, or that of the process, lets it go."""
    if sys.platform == "win32":
        import msvcrt

        while True:
            with contextlib.suppress(OSError):  # it gives up after ten tries
                return msvcrt.locking(file.fileno(), msvcrt.LK_LOCK, 1)
    else:
        import fcntl

        return fcntl.flock(file, fcntl.LOCK_EX)


class _Row(ctypes.Structure):
    _fields_ = (("name", ctypes.c_char_p), ("address", ctypes.c_void_p))


@cache
def addresses(path: Path | None = None) -> dict[str, int]:
    """Symbol -> address of every kernel of a library, by default that of all scenes, which is loaded now."""
    library = ctypes.CDLL(str(path or ready()))
    table = ctypes.cast(ctypes.addressof(_Row.in_dll(library, TABLE)), ctypes.POINTER(_Row))
    found = {}

    while table[len(found)].name is not None:
        row = table[len(found)]
        found[row.name.decode()] = row.address

    return found


def apart(function, signature, symbol):
    """The kernel of a symbol, in the library, as `function`; the library is loaded by the first call."""
    native = None

    @wraps(function)
    def call(m, d, *rest):
        nonlocal native

        if native is None:
            native = kernel_at(addresses()[symbol], signature, symbol)

        return native(m, d, *rest)

    return call


def kernel_at(address, signature, symbol):
    """The kernel of a library that is at an address as a function of m, d and what else its signature
    names.
    """
    m, d, *kinds = signature.args
    arguments: list = [ctypes.c_void_p] * (2 + _ADDRESSES[m.name] + _ADDRESSES[d.name])
    arguments += [_ARGUMENTS[kind.name] for kind in kinds]
    native = ctypes.CFUNCTYPE(ctypes.c_int32, *arguments)(address)
    passed = [(k, _PASSED[kind.name]) for k, kind in enumerate(kinds) if kind.name in _PASSED]
    result, value_of = _result(signature.return_type)
    exception = ctypes.addressof(_no_exception)
    address_of = ctypes.addressof

    def call(m, d, *rest):
        others = [*rest]

        for k, pass_on in passed:
            others[k] = pass_on(others[k])

        returned = result()

        if native(address_of(returned), exception, *m.model_addresses, *d.data_addresses, *others):
            raise RuntimeError(f"{symbol} fails inside")

        return value_of(returned)

    return call


def _result(kind):
    """(the place of a result, a function that reads it)."""
    if kind.name == "void":
        return ctypes.c_void_p, lambda place: None

    if kind.members:
        fields = [(f"f{k}", _NUMBERS[member.name]) for k, member in enumerate(kind.members)]
        place = type("Place", (ctypes.Structure,), {"_fields_": fields})
        return place, lambda place: tuple(getattr(place, name) for name, _ in fields)

    if kind.name == "boolean":
        return ctypes.c_uint8, lambda place: bool(place.value & 1)

    return _NUMBERS[kind.name], lambda place: place.value


def _address(array):
    """Address of an array of reals."""
    if not isinstance(array, np.ndarray) or array.dtype != np.float64 or not array.flags.c_contiguous:
        raise TypeError("an array of float64 without gaps is needed")

    return array.ctypes.data


_PASSED = {"REALS": _address, "int64": operator.index, "boolean": bool}
"""What is done with arguments of some kinds: numpy's numbers are none to ctypes."""
