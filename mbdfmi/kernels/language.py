"""The kernel language: three decorators, and what they make of a kernel in this process.

Ordinarily a kernel stays the plain Python that it is written in, but for those that stand apart: they are called in the
library that FMUs carry (`native.library`), with all that they call. With `MBDFMI_INTERPRETED=1` in the environment all of it is plain
Python, for tests and for work on kernels; with `MBDFMI_JIT=1` numba compiles kernels as they are called (`compiling`), for
work on them and for those who measure single ones. The numbers are the same to rounding, those of the library and numba's to
the bit.

Rules of the language (they keep the native code free of Python and of allocation, and let the
kernels be called with symbolic scalars, as the room `trace` does):

- a vector is a 3-tuple, a matrix a tuple of three rows, a symmetric matrix the 6-tuple
  (xx, yy, zz, xy, xz, yz), an orientation the 4-tuple of Euler parameters E, scalar part last;
- arrays are storage only: load a tuple, compute, store a tuple;
- a kernel writes to its `Data` alone, allocates nothing, raises nothing, prints nothing; a failure is
  a status (see `status`).
"""

import os

from ..native.platforms import has_library


def _is_set(variable):
    """Whether a variable of the environment asks for something."""
    return os.environ.get(variable, "0") not in ("", "0")


INTERPRETED = _is_set("MBDFMI_INTERPRETED")
"""Whether kernels run as plain Python in this process."""

JIT = not INTERPRETED and (_is_set("MBDFMI_JIT") or not has_library())
"""Whether numba compiles kernels as they are called: asked for, or on a machine that no library is made for."""

if JIT:
    from . import compiling as _way
elif not INTERPRETED:
    from ..native import library as _way

APART = {}
"""Kernels that stand apart: symbol -> kernel, whose attribute `signature` says what it takes; callees first."""


def kernel(function):
    """A kernel."""
    return _way.kernel(function) if JIT else function


def inlined(function):
    """A kernel small enough that a call would cost more than its body: always inlined."""
    return _way.inlined(function) if JIT else function


def apart(signature, symbol=None):
    """A kernel of a fixed signature (see `signatures`) that is called by a symbol, from Python and by other kernels.

    numba takes a copy of all that a kernel calls into its library and optimises it there again; this ends at kernels
    that stand apart. symbol : what it is called in the library, by default after its module.
    """

    def decorate(function):
        name = symbol or f"{function.__module__}.{function.__name__}".replace(".", "_")
        made = function if INTERPRETED else _way.apart(function, signature, name)
        made.signature = signature
        APART[name] = made
        return made

    return decorate
