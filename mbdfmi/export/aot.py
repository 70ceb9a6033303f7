"""Kernels ahead of time: LLVM IR of all that stand apart, made by processes of their own side by side (kernels/ahead.py)."""

import os
import subprocess
import sys
import tempfile

from ..native.sources import source_hash

MODULE = "mbdfmi.kernels.ahead"
HALVES = 2
"""How many modules there are, whatever the machine: the library is the same everywhere."""


class CompileError(Exception):
    """The kernels could not be compiled ahead of time; the text is the compiler's."""


def compile_kernels() -> list[str]:
    """LLVM IR (texts, no target named) of all kernels that stand apart, for every platform alike.

    Raises CompileError with numba's message.
    """
    with tempfile.TemporaryDirectory() as empty:
        processes = [_compile(half, empty) for half in range(HALVES)]
        told = [process.communicate() for process in processes]

    for process, (_, failure) in zip(processes, told):
        if process.returncode:
            raise CompileError(f"the kernels do not compile:\n{failure.strip()}")

    return [text for text, _ in told]


def _compile(half, cache):
    """A process that writes the module of a half."""
    environment = os.environ | {
        "NUMBA_CPU_NAME": "generic",
        "NUMBA_CPU_FEATURES": "",
        "NUMBA_OPT": "0",
        "MBDFMI_CACHE": cache,
        "MBDFMI_INTERPRETED": "",
        "MBDFMI_JIT": "1",
        "PYTHONPATH": os.pathsep.join(path for path in sys.path if path),
        "PYTHONHASHSEED": "0",
    }
    command = [sys.executable, "-m", MODULE, str(half), source_hash()]
    return subprocess.Popen(
        command, env=environment, stdout=subprocess.PIPE, stderr=subprocess.PIPE, text=True
    )
