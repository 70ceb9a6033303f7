"""Any calls in any order, in all four kinds of both versions: no process falls, no sanitizer speaks, and a reset makes good again.

The C of the wrapper is compiled by gcc with its sanitizers of addresses and of undefined behaviour, where there is a gcc, and calls
the kernels of the library that an FMU has; else that library is driven as it is.
"""

import os
import re
import shutil
import subprocess
import sys
import warnings
from pathlib import Path

import fmpy
import pytest

from mbdfmi.compiler.model import compile_scene
from mbdfmi.export import export_fmu, header, link, standard
from mbdfmi.native.platforms import host_platform
from mbdfmi.scene import read_scene

HERE = Path(__file__).parent
MODELS = HERE.parent / "models"
KINDS = [(fmi, kind) for fmi in (2, 3) for kind in ("CoSimulation", "ModelExchange")]

SHIM = """/* The entries of the kernels, from the library that an FMU has. */
#include <dlfcn.h>
#include <stdlib.h>
#include <string.h>

#include "kernels.h"

typedef struct {{
    const char *name;
    void (*kernel)(void);
}} Row;

static void *find(const char *name)
{{
    static const Row *table;

    if (!table) table = dlsym(dlopen("{library}", RTLD_NOW | RTLD_LOCAL), "mbdfmi_kernels");
    for (const Row *row = table; row->name; row++)
        if (strcmp(row->name, name) == 0) return (void *)row->kernel;
    abort();
}}
"""


def shim(library: Path) -> str:
    """C that passes each entry on."""
    text = SHIM.format(library=library)
    text += '\nextern const char mbdfmi_only_guid[];\nconst char mbdfmi_only_guid[] = "";\n'

    for result, name, given in re.findall(
        r"^(int32_t) (mbdfmi_\w+)\((.*)\);$", header.layout_header(), re.MULTILINE
    ):
        names = ", ".join(re.findall(r"(\w+)(?:,|$)", given))
        text += f'\n{result} {name}({given})\n{{\n    return (({result} (*)({given}))find("{name}"))({names});\n}}\n'

    return text


@pytest.fixture(scope="module")
def sanitized(tmp_path_factory):
    """(library, environment) to drive an FMU with; (None, {}) where there is no gcc."""
    gcc = shutil.which("gcc")

    if not gcc or sys.platform != "linux":
        warnings.warn("no gcc: the wrapper is driven WITHOUT sanitizers", stacklevel=1)
        return None, {}

    folder = tmp_path_factory.mktemp("sanitized")
    (folder / header.NAME).write_text(header.layout_header())
    (folder / "shim.c").write_text(shim(link.library(host_platform())))
    wrapper = link.wrapper_folder()
    library = folder / "fmu.so"
    subprocess.run(
        [gcc, "-shared", "-fPIC", "-g", "-O1", "-std=gnu99", "-fsanitize=address,undefined"]
        + ["-fno-sanitize-recover=all", f"-I{folder}", f"-I{wrapper}", f"-I{standard.folder() / 'c-code'}"]
        + [*map(str, sorted(wrapper.glob("*.c"))), str(folder / "shim.c"), "-lm", "-ldl", "-o", str(library)],
        check=True,
    )
    asan = subprocess.run([gcc, "-print-file-name=libasan.so"], capture_output=True, text=True, check=True)
    options = "detect_leaks=0:abort_on_error=0:exitcode=99"
    return library, {
        "LD_PRELOAD": asan.stdout.strip(),
        "ASAN_OPTIONS": options,
        "UBSAN_OPTIONS": "print_stacktrace=1",
    }


def drive(scene, fmi, kind, seed, n, sanitized, folder):
    """Some n calls of the FMU of a scene, in a process of its own."""
    library, environment = sanitized
    (path,) = MODELS.rglob(f"{scene}.toml")
    model = compile_scene(read_scene(path))
    fmpy.extract(str(export_fmu(model, folder / "a.fmu", fmi=fmi)), str(folder / "a"))

    if library:
        (binary,) = (folder / "a" / "binaries").rglob("*.so")
        shutil.copy(library, binary)

    command = [
        sys.executable,
        str(HERE / "any_calls.py"),
        str(folder / "a"),
        str(fmi),
        kind,
        str(seed),
        str(n),
    ]
    done = subprocess.run(
        command, capture_output=True, text=True, errors="replace", env=os.environ | environment, cwd=HERE
    )
    told = f"seed {seed}, status {done.returncode}:\n{done.stdout[-2000:]}\n{done.stderr[-6000:]}"
    assert done.returncode == 0, told
    assert int(done.stdout) >= n


@pytest.mark.parametrize("fmi, kind", KINDS)
def test_a_few_thousand_calls(fmi, kind, sanitized, tmp_path):
    drive("four_bar", fmi, kind, 1, 3000, sanitized, tmp_path)


@pytest.mark.long
@pytest.mark.parametrize("scene", ["pendulum", "four_bar", "marble_run", "cam_follower", "satellite"])
@pytest.mark.parametrize("fmi, kind", KINDS)
def test_a_million_calls(scene, fmi, kind, sanitized, tmp_path):
    """50,000 in each of twenty."""
    drive(scene, fmi, kind, 7, 50_000, sanitized, tmp_path)
