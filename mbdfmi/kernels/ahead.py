"""The kernels ahead of time: numba's IR of all that stand apart, as text, in two halves that can be made side by side.

Runs in a process of its own (`python -m mbdfmi.kernels.ahead HALF HASH`), in which numba aims at the generic processor and
MBDFMI_JIT is set: so the IR depends neither on this machine's vector units nor on what a process has compiled before.

numba by itself optimises each function and makes machine code of it as soon as it is compiled, with copies of all that it
calls: three times the work of all else. Here each function's IR is kept as it comes, and all of it optimised once.
"""

import sys

from llvmlite import binding
from numba.core import codegen, cpu

from ..native.sources import source_hash
from . import compiling

HALVES = (0, 1)

STEPPING = """
    dynamics_articulated_aba dynamics_forward_accelerate dynamics_inertia_inertias dynamics_inverse_joint_wrenches
    dynamics_projection_project dynamics_rates_evaluate dynamics_rates_evaluate_now end_frames_touching_parameter_rates
    forces_apply forces_added_mass_add mbdfmi_outputs mbdfmi_step motion_drives_prescribe motion_kinematics_kinematics
    steppers_fixed_equal_steps steppers_pairs_adaptive steppers_pairs_extend
""".split()
"""Kernels that every step of a tree calls: in one half, for from another they are not inlined, which costs small models 3 %."""


def keep_as_it_comes():
    """From now on numba makes IR of functions, and nothing more."""
    compiling.OPTIONS |= {"no_cpython_wrapper": True, "no_cfunc_wrapper": True}
    compiling.KEPT["cache"] = False
    library = codegen.JITCodeLibrary
    library.add_llvm_module = lambda self, module: self._final_module.link_in(module)
    library.finalize = lambda self: setattr(self, "_finalized", True)

    # what Python would call: never called, but numba tells functions apart by it
    cpu.CPUContext.get_executable = lambda self, library, described, environment: [].append


def half_of(symbols, half):
    """Those that every step calls, or the rest, which is about as much."""
    return sorted(s for s in symbols if (s.removeprefix("mbdfmi_kernels_") in STEPPING) == (half == 0))


def module_of(symbols) -> str:
    """LLVM IR, one module, of kernels that stand apart, nothing else visible, no target named."""
    whole, seen = binding.parse_assembly(""), set()

    for name in symbols:
        done = compiling.compiled(name)
        done.library._final_module.get_function(done.fndesc.llvm_func_name).name = name
        _link(whole, done.library, seen)

    whole.triple = whole.data_layout = ""
    _hide(whole, set(symbols))
    _simplify(whole)
    whole.verify()
    return str(whole)


def _link(whole, library, seen):
    """Adds the functions of a library, and of those that it calls, once each."""
    if library in seen:
        return

    seen.add(library)
    whole.link_in(library._final_module)

    for called in library._linking_libraries:
        _link(whole, called, seen)


def _hide(module, entries):
    """Makes every definition internal but the entries, and those invisible outside the library."""
    for value in [*module.functions, *module.global_variables]:
        if value.is_declaration:
            continue
        if value.name in entries:
            value.visibility = "hidden"
        else:
            value.linkage = "internal"


def _simplify(module):
    """Takes out what is not called (numba's reference counting), and does once what each platform would do again."""
    machine = binding.Target.from_default_triple().create_target_machine()
    options = binding.create_pipeline_tuning_options(speed_level=1)
    options.loop_vectorization = options.slp_vectorization = False
    builder = binding.create_pass_builder(machine, options)
    passes = binding.create_new_module_pass_manager()
    passes.add_global_dead_code_eliminate_pass()
    passes.run(module, builder)
    builder.getModulePassManager().run(module, builder)


def main(half: str, expected: str):
    """Writes the module of a half to the standard output.

    expected : hash of the sources that the caller runs with; arrays and kernels must agree.
    """
    if source_hash() != expected:
        sys.exit("the sources of the kernels have changed since this program began: start it again")

    keep_as_it_comes()
    from . import loops as loops  # and with them all that stand apart
    from .language import APART

    sys.stdout.write(module_of(half_of(APART, int(half))))


if __name__ == "__main__":
    main(*sys.argv[1:])
