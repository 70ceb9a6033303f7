"""The kernel language: two decorators, and where compiled kernels are kept.

Rules of the language (they keep the native code free of Python and of allocation, and let the
kernels be called with symbolic scalars one day):

- a vector is a 3-tuple, a matrix a tuple of three rows, a symmetric matrix the 6-tuple
  (xx, yy, zz, xy, xz, yz), an orientation the 4-tuple of Euler parameters E, scalar part last;
- arrays are storage only: load a tuple, compute, store a tuple;
- a kernel writes to its `Data` alone, allocates nothing, raises nothing, prints nothing; a failure is
  a status (see `status`).
"""

import hashlib
import os
from contextlib import contextmanager
from functools import cache
from pathlib import Path

import numba


@cache
def source_hash() -> str:
    """Hash (hex) of all kernel sources: names a set of compiled kernels.

    numba's own cache looks at the file of one function only and does not notice a change in a callee.
    """
    digest = hashlib.sha256(numba.__version__.encode())

    for path in sorted(Path(__file__).parent.glob("*.py")):
        digest.update(path.name.encode() + b"\0" + path.read_bytes() + b"\0")

    return digest.hexdigest()[:20]


def cache_directory() -> Path:
    """Folder for what is compiled once and kept: $MBDFMI_CACHE, else `mbdfmi` in the user's cache."""
    if chosen := os.environ.get("MBDFMI_CACHE"):
        return Path(chosen)

    if os.name == "nt":
        base = os.environ.get("LOCALAPPDATA", Path.home() / "AppData/Local")
    else:
        base = os.environ.get("XDG_CACHE_HOME", Path.home() / ".cache")

    return Path(base) / "mbdfmi"


@contextmanager
def _numba_cache_here():
    """numba fixes a function's cache folder when it is decorated: lend it ours for that moment."""
    before = numba.config.CACHE_DIR
    numba.config.CACHE_DIR = str(cache_directory() / "jit" / source_hash())

    try:
        yield
    finally:
        numba.config.CACHE_DIR = before


def kernel(function):
    """Compile `function` with numba by the rules of the kernel language."""
    with _numba_cache_here():
        return numba.njit(error_model="numpy", nogil=True, cache=True)(function)


def inlined(function):
    """A kernel small enough that a call would cost more than its body: always inlined."""
    return numba.njit(error_model="numpy", nogil=True, forceinline=True)(function)
