"""Kernels ahead of time: numba's entries -> one LLVM module, as text.

Compiling runs in a process of its own, in which numba aims at the generic processor: so the module
depends neither on this machine's vector units nor on what this process has compiled before.
"""

import importlib
import os
import subprocess
import sys
import tempfile

from llvmlite import binding

from ..kernels.language import APART, load_apart, source_hash

ENTRIES = "mbdfmi.kernels.entry:ENTRIES"
"""Where the table of entries is: name of the C function -> (numba dispatcher, signature)."""


class CompileError(Exception):
    """The kernels could not be compiled ahead of time; the text is the compiler's."""


def compile_entries() -> str:
    """LLVM IR (text, no target named) of all entries, for every platform alike.

    Raises CompileError with numba's message.
    """
    program = f"from {__name__} import print_module; print_module({ENTRIES!r}, {source_hash()!r})"

    # numba keeps no IR of what it finds compiled: let it find nothing
    with tempfile.TemporaryDirectory() as empty:
        environment = os.environ | {
            "NUMBA_CPU_NAME": "generic",
            "NUMBA_CPU_FEATURES": "",
            "NUMBA_OPT": "1",  # zig optimises after linking
            "MBDFMI_CACHE": empty,
            "MBDFMI_INTERPRETED": "",
            "PYTHONPATH": os.pathsep.join(path for path in sys.path if path),
            "PYTHONHASHSEED": "0",
        }
        command = [sys.executable, "-c", program]
        done = subprocess.run(command, env=environment, capture_output=True, text=True)

    if done.returncode:
        raise CompileError(f"the kernels ({ENTRIES}) do not compile:\n{done.stderr.strip()}")

    return done.stdout


def module_of(table: dict, inner: dict | None = None) -> str:
    """LLVM IR, one module, of a table like ENTRIES, nothing else visible; `inner`: a like table of what these call by name."""
    whole = binding.parse_assembly("")

    for name, (dispatcher, signature) in ((inner or {}) | table).items():
        dispatcher.compile(signature)
        compiled = dispatcher.overloads[signature.args]

        part = binding.parse_assembly(compiled.library.get_llvm_str())
        part.triple = ""
        part.data_layout = ""
        part.get_function(compiled.fndesc.llvm_func_name).name = name
        whole.link_in(part)

    _hide(whole, set(table))
    _drop_unused(whole)
    whole.verify()
    return str(whole)


def _hide(module, entries: set[str]) -> None:
    """Makes every definition internal but the entries, and those invisible outside the library."""
    for value in [*module.functions, *module.global_variables]:
        if value.is_declaration:
            continue
        if value.name in entries:
            value.visibility = "hidden"
        else:
            value.linkage = "internal"


def _drop_unused(module) -> None:
    """Takes out what is not called: numba's wrappers for Python, its reference counting."""
    machine = binding.Target.from_default_triple().create_target_machine()
    builder = binding.create_pass_builder(machine, binding.create_pipeline_tuning_options())
    passes = binding.create_new_module_pass_manager()
    passes.add_global_dead_code_eliminate_pass()
    passes.run(module, builder)


def print_module(entries: str, expected: str) -> None:
    """What compile_entries runs in its own process: writes the module to the standard output.

    `expected` is the hash of the sources that the caller runs with: arrays and kernels must agree.
    """
    module, table = entries.split(":")

    if source_hash() != expected:
        sys.exit("the sources of the kernels have changed since this program began: start it again")

    load_apart()
    sys.stdout.write(module_of(getattr(importlib.import_module(module), table), APART))
