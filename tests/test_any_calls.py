"""Any calls in any order, in all kinds of both versions: no process falls, no sanitizer speaks, and a reset makes good again.

The C of the wrapper is compiled by gcc with its sanitizers of addresses and of undefined behaviour, where there is a gcc, and calls
the kernels of the library that an FMU has; else that library is driven as it is.
"""

import math
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
KINDS = [(fmi, kind) for fmi in (2, 3) for kind in ("CoSimulation", "ModelExchange")] + [(3, "EventMode")]

ALLOCATIONS = """/* The wrapper's allocations: counted, and one of them fails when it is told so. */
#undef malloc
#undef calloc
#undef free
#include <stddef.h>
#include <stdlib.h>

static long made, failing, alive;

/* The k-th from now on fails; 0: none. */
void test_fail_at(long k)
{
    made = 0;
    failing = k;
}

/* How many there were since. */
long test_made(void)
{
    return made;
}

/* How many were not freed. */
long test_alive(void)
{
    return alive;
}

static void *counted(void *block)
{
    if (block) alive++;
    return block;
}

void *test_malloc(size_t size)
{
    return ++made == failing ? NULL : counted(malloc(size));
}

void *test_calloc(size_t n, size_t size)
{
    return ++made == failing ? NULL : counted(calloc(n, size));
}

void test_free(void *block)
{
    if (block) alive--;
    free(block);
}
"""

SHIM = """/* The entries of the kernels, from the library that an FMU has. */
#include <dlfcn.h>
#include <stdlib.h>
#include <string.h>

#include "kernels.h"

typedef struct {{
    const char *name;
    void (*kernel)(void);
}} Row;

static const Row *table;

__attribute__((constructor)) static void open_table(void)
{{
    table = dlsym(dlopen("{library}", RTLD_NOW | RTLD_LOCAL), "mbdfmi_kernels");
}}

static void *find(const char *name)
{{
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


def build(gcc, folder, flags, sources, output):
    """Compiles the wrapper and some sources beside it."""
    (folder / header.NAME).write_text(header.layout_header())
    (folder / "shim.c").write_text(shim(link.library(host_platform())))
    wrapper = link.wrapper_folder()
    subprocess.run(
        [gcc, "-fPIC", "-g", "-O1", "-std=gnu99", *flags]
        + [f"-I{folder}", f"-I{wrapper}", f"-I{standard.folder() / 'c-code'}"]
        + [*map(str, [*sorted(wrapper.glob("*.c")), folder / "shim.c", *sources])]
        + ["-lm", "-ldl", "-o", str(output)],
        check=True,
    )
    return output


@pytest.fixture(scope="module")
def sanitized(tmp_path_factory):
    """(library, environment) to drive an FMU with; (None, {}) where there is no gcc."""
    gcc = shutil.which("gcc")

    if not gcc or sys.platform != "linux":
        warnings.warn("no gcc: the wrapper is driven WITHOUT sanitizers", stacklevel=1)
        return None, {}

    folder = tmp_path_factory.mktemp("sanitized")
    (folder / "allocations.c").write_text(ALLOCATIONS)
    flags = ["-shared", "-fsanitize=address,undefined", "-fno-sanitize-recover=all"]
    flags += [f"-D{name}=test_{name}" for name in ("malloc", "calloc", "free")]
    library = build(gcc, folder, flags, [folder / "allocations.c"], folder / "fmu.so")
    asan = subprocess.run([gcc, "-print-file-name=libasan.so"], capture_output=True, text=True, check=True)
    options = "detect_leaks=0:abort_on_error=0:exitcode=99"
    return library, {
        "LD_PRELOAD": asan.stdout.strip(),
        "ASAN_OPTIONS": options,
        "UBSAN_OPTIONS": "print_stacktrace=1",
    }


def drive(scene, fmi, kind, seed, n, sanitized, folder):
    """Some n calls of the FMU of a scene, in a process of its own."""
    done = run("any_calls.py", scene, fmi, kind, [seed, n], sanitized, folder)
    told = f"seed {seed}, status {done.returncode}:\n{done.stdout[-2000:]}\n{done.stderr[-6000:]}"
    assert done.returncode == 0, told
    assert int(done.stdout) >= n


def run(program, scene, fmi, kind, given, sanitized, folder):
    """A program of the tests with the FMU of a scene, in a process of its own."""
    library, environment = sanitized
    (path,) = MODELS.rglob(f"{scene}.toml")
    model = compile_scene(read_scene(path))
    fmpy.extract(str(export_fmu(model, folder / "a.fmu", fmi=fmi)), str(folder / "a"))

    if library:
        (binary,) = (folder / "a" / "binaries").rglob("*.so")
        shutil.copy(library, binary)

    command = [sys.executable, HERE / program, folder / "a", fmi, kind, *given]
    return subprocess.run(
        [*map(str, command)],
        capture_output=True,
        text=True,
        errors="replace",
        env=os.environ | environment,
        cwd=HERE,
    )


def fail_allocations(scene, fmi, kind, sanitized, folder):
    if not sanitized[0]:
        pytest.skip("NOT TESTED: no gcc")

    done = run("failing_allocations.py", scene, fmi, kind, [], sanitized, folder)
    assert done.returncode == 0, f"{done.stdout[-2000:]}\n{done.stderr[-6000:]}"
    assert int(done.stdout) > 25


@pytest.mark.parametrize("fmi, kind", [KINDS[0], KINDS[3]])
def test_each_allocation_fails_once(fmi, kind, sanitized, tmp_path):
    """It is told, nothing is lost or leaks, and a reset makes good."""
    fail_allocations("four_bar", fmi, kind, sanitized, tmp_path)


@pytest.mark.long
@pytest.mark.parametrize("scene", ["four_bar", "marble_run", "cam_follower", "satellite", "bricard"])
@pytest.mark.parametrize("fmi, kind", KINDS)
def test_each_allocation_of_more_scenes_fails_once(scene, fmi, kind, sanitized, tmp_path):
    fail_allocations(scene, fmi, kind, sanitized, tmp_path)


@pytest.mark.parametrize("fmi, kind", KINDS)
def test_a_few_thousand_calls(fmi, kind, sanitized, tmp_path):
    drive("four_bar", fmi, kind, 1, 3000, sanitized, tmp_path)


@pytest.mark.long
@pytest.mark.parametrize("scene", ["pendulum", "four_bar", "marble_run", "cam_follower", "satellite"])
@pytest.mark.parametrize("fmi, kind", KINDS)
def test_a_million_calls(scene, fmi, kind, sanitized, tmp_path):
    """50,000 in each of twenty-five."""
    drive(scene, fmi, kind, 7, 50_000, sanitized, tmp_path)


@pytest.mark.long
@pytest.mark.parametrize("scene", ["pendulum", "four_bar", "marble_run", "cam_follower", "satellite"])
def test_eight_threads(scene, tmp_path):
    """Under gcc's sanitizer of threads: all four kinds at once, twice each."""
    gcc = shutil.which("gcc")
    if not gcc or sys.platform != "linux":
        pytest.skip("NOT TESTED: no gcc")

    (path,) = MODELS.rglob(f"{scene}.toml")
    model = compile_scene(read_scene(path))
    shown = {}
    for fmi in (2, 3):
        folder = tmp_path / str(fmi)
        fmpy.extract(str(export_fmu(model, tmp_path / f"{fmi}.fmu", fmi=fmi)), str(folder))
        description = fmpy.read_model_description(str(folder))
        shown[fmi] = [v for v in description.modelVariables if v.causality == "output"]

    host = build(gcc, tmp_path, ["-fsanitize=thread"], [HERE / "threads_host.c"], tmp_path / "host")
    keys = [",".join(str(v.valueReference) for v in shown[fmi]) for fmi in (2, 3)]
    resources = tmp_path / "2" / "resources"
    given = [resources.as_uri(), f"{resources}/", description.guid, model.n_x, *keys]
    given.append(sum(math.prod(v.shape or ()) for v in shown[3]))
    # the sanitizer wants its places in memory where they are by default
    aside = ["setarch", "-R"] if shutil.which("setarch") else []
    done = subprocess.run(
        [*aside, *map(str, [host, *given])], capture_output=True, text=True, errors="replace"
    )
    assert done.returncode == 0 and done.stdout == "as one\n", done.stderr[-6000:]
