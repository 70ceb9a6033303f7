"""The kernel language: three decorators, and where compiled kernels are kept.

With `MBDFMI_INTERPRETED=1` in the environment the kernels stay the plain Python that they are written in, for tests and for
work on them: nothing is compiled, the numbers are those of the compiled ones to rounding.

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
from functools import cache, wraps
from pathlib import Path

import numba
from llvmlite import binding
from numba.core import cgutils
from numba.extending import intrinsic, overload

OUTSIDE = ("steppers",)
"""Modules beside the kernels that these import: their numbers are frozen into the code as well."""

INTERPRETED = os.environ.get("MBDFMI_INTERPRETED", "0") not in ("", "0")
"""Whether kernels run as plain Python in this process."""


@cache
def source_hash() -> str:
    """Hash (hex) of all sources of the kernels: names a set of compiled kernels.

    numba's own cache looks at the file of one function only and does not notice a change in a callee.
    """
    digest = hashlib.sha256(numba.__version__.encode())

    folder = Path(__file__).parent
    outside = [folder.parent / f"{name}.py" for name in OUTSIDE]

    for path in [*sorted(folder.rglob("*.py")), *outside]:
        digest.update(path.relative_to(folder.parent).as_posix().encode() + b"\0" + path.read_bytes() + b"\0")

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
    if INTERPRETED:
        return function

    with _numba_cache_here():
        return numba.njit(error_model="numpy", nogil=True, cache=True)(function)


def inlined(function):
    """A kernel small enough that a call would cost more than its body: always inlined."""
    if INTERPRETED:
        return function

    return numba.njit(error_model="numpy", nogil=True, forceinline=True)(function)


APART = {}
"""Kernels that others call by a symbol: symbol -> (numba dispatcher, signature), callees first."""

_loaded = set()


def apart(signature):
    """A kernel of a fixed signature (of numba's types) that its callers call by a symbol.

    numba takes a copy of all that a kernel calls into its library and optimises it there again; this ends at kernels
    that stand apart. Their symbols are there after `load_apart`.
    """

    def decorate(function):
        if INTERPRETED:
            return function

        dispatcher = kernel(function)
        name = f"{function.__module__}.{function.__name__}".replace(".", "_")
        APART[name] = (dispatcher, signature)

        @wraps(function)
        def call(*arguments):
            return dispatcher(*arguments)

        def call_symbol(context, builder, given, values):
            of = given.args[0].types
            values = cgutils.unpack_tuple(builder, values[0])
            values = [context.cast(builder, *cast) for cast in zip(values, of, signature.args)]
            kind = context.call_conv.get_function_type(signature.return_type, signature.args)
            callee = cgutils.get_or_insert_function(builder.module, kind, name)
            types = (signature.return_type, signature.args)
            return context.call_conv.call_function(builder, callee, *types, values)[1]

        @intrinsic
        def symbol(typing_context, arguments):
            return signature.return_type(arguments), call_symbol

        @overload(call, strict=False)
        def call_in_kernels(*arguments):
            return lambda *arguments: symbol(arguments)

        return call

    return decorate


def load_apart():
    """Compile, or find compiled, the kernels that stand apart, and make their symbols known."""
    for name, (dispatcher, signature) in APART.items():
        if name not in _loaded:
            dispatcher.compile(signature)
            compiled = dispatcher.overloads[signature.args]
            address = compiled.library.get_pointer_to_function(compiled.fndesc.llvm_func_name)
            binding.add_symbol(name, address)
            _loaded.add(name)
