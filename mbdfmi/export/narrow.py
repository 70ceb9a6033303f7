"""The kernels of one scene: their LLVM IR with the scene's structure for constant, and what it does not
reach taken out.

A kernel finds what a scene is made of in `ints`. Where that is a constant of the module, the compiler knows
every count, kind and offset: loops have their lengths, and steppers, elements and joint kinds that are not
there go. Numbers stay the same to the bit: nothing but control flow and addresses is known better.
"""

import re
from functools import cache
from pathlib import Path

import llvmlite.binding as llvm

from ..files import replacing
from ..kernels.entry import ENTRIES
from ..kernels.language import APART
from ..kernels.layout import ARRAY, COUNTS, SLOT, array_length
from ..kernels.signatures import DATA, MODEL
from ..kernels.views import DataView, ModelView
from ..native.sources import cache_directory, source_hash

INNER = "_of_any_scene"
"""What stands behind the name of a kernel that is called with the scene's structure for `ints`."""

_TYPES = {"float64": "double", "int64": "i64", "boolean": "i1", "REALS": "ptr"}
_VIEWS = {MODEL: ModelView, DATA: DataView}


def narrowed(files: list[Path], ints, kernel: str, generic: str | None) -> str:
    """LLVM IR (no target named) of the entries with the structure `ints` (int64 array) bound.

    files : IR of all kernels. kernel : symbol of one that another object may define: then that of any scene
    is called `generic`, else None.
    """
    _initialise()
    module = llvm.parse_bitcode(_whole(files, kernel))
    module.link_in(llvm.parse_assembly(_outside(ints, kernel, generic)))

    for function in module.functions:
        if function.name.endswith(INNER) or (function.name == kernel and not generic):
            function.linkage = "internal"

    module = _folded(module, ints)
    module.triple = module.data_layout = ""
    module.verify()
    return str(module)


def _whole(files: list[Path], kernel: str) -> bytes:
    """All kernels as one module (bitcode), made once: only the entries and `kernel` are visible, under inner
    names.
    """
    path = cache_directory() / "fmu" / f"{source_hash()}-{kernel}.bc"

    if not path.exists():
        halves = [_renamed(file.read_text(), [*ENTRIES, kernel], kernel) for file in files]
        module = llvm.parse_assembly(halves[0])

        for half in halves[1:]:
            module.link_in(llvm.parse_assembly(half))

        for value in [*module.functions, *module.global_variables]:
            if not value.is_declaration and not value.name.endswith(INNER):
                value.linkage = "internal"

        with replacing(path) as temporary:
            temporary.write_bytes(module.as_bitcode())

    return path.read_bytes()


def _renamed(text, names, kernel):
    """A half with its definitions of some kernels under inner names; whoever calls `kernel` still calls
    that.
    """
    for name in names:
        heads = re.compile(rf"^define hidden ([^\n]*@){name}\(", re.MULTILINE)
        text, defined = heads.subn(rf"define hidden \g<1>{name}{INNER}(", text)

        if defined and name == kernel and f"@{name}(" in text:
            kinds = ", ".join(kind for kind, _ in _arguments(name))
            text += f"\ndeclare i32 @{name}({kinds})\n"
        elif name != kernel:
            text = text.replace(f"@{name}(", f"@{name}{INNER}(")

    return text


def _folded(module, ints):
    """The module with the structure taken up, what is not reached taken out, and the rest optimised as a
    library is.
    """
    machine = llvm.Target.from_default_triple().create_target_machine(opt=2)
    options = llvm.create_pipeline_tuning_options(speed_level=2)
    options.loop_vectorization = options.slp_vectorization = False
    builder = llvm.create_pass_builder(machine, options)

    # first cheaply, so that little is left to be optimised
    first = llvm.create_new_module_pass_manager()
    first.add_ipsccp_pass()
    first.add_global_dead_code_eliminate_pass()
    first.run(module, builder)
    module = llvm.parse_assembly(_with_kinds_that_are_there(str(module), ints))
    module.verify()
    second = llvm.create_new_module_pass_manager()
    second.add_ipsccp_pass()
    second.add_simplify_cfg_pass()
    second.add_instruction_combine_pass()
    second.add_simplify_cfg_pass()
    second.add_ipsccp_pass()
    second.add_global_dead_code_eliminate_pass()
    second.run(module, builder)
    builder.getModulePassManager().run(module, builder)
    return module


_PLACE = re.compile(
    r"^  (%\S+) = getelementptr i64, ptr "
    r"(?:getelementptr inbounds nuw \(i8, ptr )?@scene(?:, i64 (\d+)\))?, i64 %\S+",
    re.MULTILINE,
)


def _with_kinds_that_are_there(text, ints) -> str:
    """IR in which a number read from an array of the structure, wherever in that, is none that is nowhere in
    the array.

    So a loop over outputs, or bodies, has only the branches of kinds that there are.
    """
    values = _values_of_arrays(ints)
    functions = re.split(r"^(?=define )", text, flags=re.MULTILINE)
    return functions[0] + "".join(_with_values(function, values) for function in functions[1:])


def _values_of_arrays(ints):
    """Place in `ints` -> the values in the array that begins there."""
    counts = dict(zip(COUNTS, ints.tolist()))
    found = {}

    for name, array in ARRAY.items():
        length = array_length(array, counts)

        if array.buffer == "ints" and length:
            first = int(ints[SLOT[name]])
            found[first] = set(ints[first : first + length].tolist())

    return found


_LOAD = re.compile(r"^  (%\S+) = load i64, ptr (%[^\s,]+),", re.MULTILINE)
_SWITCH = re.compile(r"switch i64 (%[\w.]+), label \S+ \[([^\]]*)\]")
_CASE = re.compile(r"^ +i64 (-?\d+), label %(\S+)\n", re.MULTILINE)
_BLOCK = re.compile(r"^(?=\S+:(?: |$))", re.MULTILINE)
_USE = re.compile(r"%[\w.]++(?! =)")
_COMPARED = re.compile(r"icmp (eq|ne) i64 (%[\w.]+), (-?\d+)")


def _with_values(function, values):
    """One function in which numbers read from arrays are among their values."""
    places = {place: values.get(int(byte or 0) // 8) for place, byte in _PLACE.findall(function)}
    there = {number: places[place] for number, place in _LOAD.findall(function) if places.get(place)}

    if not there:
        return function

    single = {number: str(next(iter(some))) for number, some in there.items() if len(some) == 1}

    def compared(found):
        never = int(found[3]) not in there.get(found[2], {int(found[3])})
        return f"icmp {found[1]} i64 0, 1" if never else found[0]

    function = _COMPARED.sub(compared, function)
    function = _without_cases(function, there)
    return _USE.sub(lambda found: single.get(found[0], found[0]), function)


def _without_cases(function, there):
    """A function whose switches have no cases of numbers that are not there.

    A block counts where its numbers come from, so each edge that goes comes from a block of its own that
    nothing leads to.
    """
    head, *blocks = _BLOCK.split(function)
    labels = [block.partition(":")[0] for block in blocks]
    at = {label: k for k, label in enumerate(labels)}
    dead = []

    for k, label in enumerate(labels):
        switch = _SWITCH.search(blocks[k])

        if switch is None or switch[1] not in there:
            continue

        for value, target in _CASE.findall(switch[2]):
            if int(value) not in there[switch[1]]:
                blocks[k] = blocks[k].replace(f"    i64 {value}, label %{target}\n", "", 1)
                name = f"dead.{len(dead)}"
                dead.append(f"\n{name}:\n  br label %{target}\n")
                blocks[at[target]] = _from_another(blocks[at[target]], label, name)

    body, end, rest = "".join(blocks).rpartition("\n}")
    return head + body + "".join(dead) + end + rest if dead else function


def _from_another(block, before, name):
    """A block one of whose edges from block `before` comes from block `name` instead."""
    return re.sub(
        r"^(  %\S+ = phi .*)$",
        lambda found: found[0].replace(f", %{before} ]", f", %{name} ]", 1),
        block,
        flags=re.MULTILINE,
    )


@cache
def _initialise():
    llvm.initialize_native_target()
    llvm.initialize_native_asmprinter()


def _outside(ints, kernel, generic) -> str:
    """The module that binds the structure: a constant, and each entry, called with it."""
    numbers = ", ".join(f"i64 {value}" for value in ints.tolist())
    lines = [f"@scene = internal constant [{len(ints)} x i64] [{numbers}]"]
    shown = {name: name for name in ENTRIES} | {kernel: generic or kernel}

    for name, outer in shown.items():
        given = _arguments(name)
        listed = ", ".join(f"{kind} %a{k}" for k, (kind, _) in enumerate(given))
        passed = ", ".join(
            "ptr @scene" if buffer == "ints" else f"{kind} %a{k}" for k, (kind, buffer) in enumerate(given)
        )
        lines += [
            f"declare i32 @{name}{INNER}({', '.join(kind for kind, _ in given)})",
            f"define hidden i32 @{outer}({listed}) {{",
            f"  %r = call i32 @{name}{INNER}({passed})",
            "  ret i32 %r",
            "}",
        ]

    return "\n".join(lines) + "\n"


def _arguments(name):
    """(type, buffer or "") of each argument of a kernel in the library: result, exception, buffers,
    others.
    """
    found = [("ptr", ""), ("ptr", "")]

    for kind in APART[name].signature.args:
        if kind in _VIEWS:
            found += [("ptr", buffer) for buffer in _VIEWS[kind].buffer_names]
        else:
            found.append((_TYPES[kind.name], ""))

    return found
