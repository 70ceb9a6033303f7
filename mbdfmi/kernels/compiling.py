"""Kernels that numba compiles: as they are called (`MBDFMI_JIT=1`), and when the library is made."""

import ctypes
from contextlib import contextmanager
from functools import wraps

import numba
import numpy as np
from llvmlite import binding
from numba import types
from numba.core import cgutils
from numba.extending import intrinsic, overload

from ..native.sources import cache_directory, source_hash

OPTIONS = {"error_model": "numpy", "nogil": True}
KEPT = {"cache": True}  # of those that are not inlined

TYPES = {
    "boolean": types.boolean,
    "int64": types.int64,
    "float64": types.float64,
    "void": types.void,
    "REALS": types.CPointer(types.float64),
}
"""Kinds of arguments and results by their names in `signatures`; `compiled_views` adds m and d."""

_apart = {}
_loaded = set()


def type_of(kind):
    """numba's type of a kind."""
    return types.Tuple([type_of(member) for member in kind.members]) if kind.members else TYPES[kind.name]


def compiled(name):
    """What numba made of the kernel of a symbol, which is compiled now if it was not."""
    dispatcher, signature = _apart[name]
    arguments = tuple(type_of(kind) for kind in signature.args)
    dispatcher.compile(type_of(signature.return_type)(*arguments))
    return dispatcher.overloads[arguments]


@contextmanager
def _numba_cache_here():
    """numba fixes a function's cache folder when it is decorated: lend it ours for that moment.

    Named by all sources: numba's own cache does not notice a change in a callee in another file.
    """
    before = numba.config.CACHE_DIR
    numba.config.CACHE_DIR = str(cache_directory() / "jit" / source_hash())

    try:
        yield
    finally:
        numba.config.CACHE_DIR = before


def kernel(function):
    """A kernel that is compiled when it is called."""
    with _numba_cache_here():
        return numba.njit(**OPTIONS, **KEPT)(function)


def inlined(function):
    """A kernel that is always inlined."""
    return numba.njit(forceinline=True, **OPTIONS)(function)


def apart(function, signature, name):
    """A kernel that other kernels call by a symbol, which is there after `load_apart`."""
    dispatcher = kernel(function)
    _apart[name] = (dispatcher, signature)

    @wraps(function)
    def call(*arguments):
        return dispatcher(*map(_passed, arguments))

    def call_symbol(context, builder, given, values):
        kinds = [type_of(kind) for kind in signature.args]
        types_ = (type_of(signature.return_type), kinds)
        values = cgutils.unpack_tuple(builder, values[0])
        values = [context.cast(builder, *cast) for cast in zip(values, given.args[0].types, kinds)]
        callee = cgutils.get_or_insert_function(
            builder.module, context.call_conv.get_function_type(*types_), name
        )
        return context.call_conv.call_function(builder, callee, *types_, values)[1]

    @intrinsic
    def symbol(typing_context, arguments):
        return type_of(signature.return_type)(arguments), call_symbol

    @overload(call, strict=False)
    def call_in_kernels(*arguments):
        return lambda *arguments: symbol(arguments)

    return call


def _passed(argument):
    """An argument from Python as numba is to see it: an array of reals by its address."""
    if isinstance(argument, np.ndarray):
        return argument.ctypes.data_as(ctypes.POINTER(ctypes.c_double))

    return argument


def load_apart():
    """Compile, or find compiled, the kernels that stand apart, and make their symbols known in this process."""
    for name in _apart:
        if name not in _loaded:
            done = compiled(name)
            address = done.library.get_pointer_to_function(done.fndesc.llvm_func_name)
            binding.add_symbol(name, address)
            _loaded.add(name)
