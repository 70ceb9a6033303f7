"""Sources of FMUs: they compile without a warning, hold no allocation and no recursion, and give what the binary gives."""

import re
import shutil
import subprocess
import sys
import zipfile
from functools import cache
from pathlib import Path

import fmpy
import numpy as np
import pytest
from fmpy.build import build_platform_binary

import mbdfmi
from mbdfmi.export import core, sources, specialise
from mbdfmi.kernels.math import algebra
from mbdfmi.trace.graph import Untraceable
from mbdfmi.trace.plain import plain_function
from mbdfmi.trace.program import shapes
from mbdfmi.trace.program.functions import Program
from mbdfmi.trace.program.layout_c import Line

MODELS = Path(__file__).parents[1] / "models"
HEADERS = Path(fmpy.__file__).parent / "c-code"
STRICT = ["-std=c99", "-Wall", "-Wextra", "-Wpedantic", "-Werror"]
COMPILERS = {
    "gcc": ["gcc", "-O2"],  # some of its warnings come of optimising
    "clang": ["clang"],
    "zig": [sys.executable, "-m", "ziglang", "cc"],
}


@cache
def scene(name, integrator):
    """A scene of models/ by another integrator."""
    found = mbdfmi.load(MODELS / f"{name}.toml")
    found.solver = {"integrator": integrator} | ({"step": 1e-3} if integrator == "rk4" else {})
    return found


@pytest.fixture(scope="module")
def fmus(tmp_path_factory):
    """An FMU with sources, for a version of FMI."""
    folder = tmp_path_factory.mktemp("sources")

    @cache
    def made(fmi):
        return scene("four_bar", "rk4").export(folder / f"{fmi}.fmu", fmi=fmi, with_sources=True)

    return made


LONG = pytest.mark.long


@pytest.mark.parametrize(
    ("compiler", "fmi"),
    [
        ("gcc", 2),
        pytest.param("gcc", 3, marks=LONG),
        ("clang", 3),
        pytest.param("zig", 2, marks=LONG),
        ("zig", 3),
    ],
)
def test_sources_compile_without_a_warning(compiler, fmi, fmus, tmp_path):
    if compiler != "zig" and not shutil.which(compiler):
        pytest.skip(f"{compiler} is not installed")

    with zipfile.ZipFile(fmus(fmi)) as archive:
        archive.extractall(tmp_path)

    files = [str(tmp_path / "sources" / name) for name in sources.compiled(fmi)]
    library = tmp_path / "all.so"
    includes = [f"-I{tmp_path / 'sources'}", "-isystem", str(HEADERS)]
    shared = ["-fPIC", "-shared", *files, "-lm", "-o", str(library)]
    subprocess.run([*COMPILERS[compiler], *STRICT, *includes, *shared], check=True, cwd=tmp_path)
    assert library.exists()


@pytest.mark.parametrize("fmi", [pytest.param(2, marks=LONG), 3])
def test_fmpy_compiles_and_runs_it_and_it_gives_what_the_binary_gives(fmi, fmus, tmp_path):
    if not shutil.which("cmake"):
        pytest.skip("cmake is not installed")

    binary = fmpy.simulate_fmu(str(fmus(fmi)), stop_time=1.0, output_interval=0.02, fmi_type="CoSimulation")
    folder = Path(fmpy.extract(str(fmus(fmi)), str(tmp_path / "unpacked")))
    shutil.rmtree(folder / "binaries")
    build_platform_binary(folder)
    assert list((folder / "binaries").rglob("*.so")) or sys.platform != "linux"
    made = fmpy.simulate_fmu(str(folder), stop_time=1.0, output_interval=0.02, fmi_type="CoSimulation")

    for name in binary.dtype.names:
        np.testing.assert_allclose(made[name], binary[name], rtol=1e-12, atol=1e-12)


@LONG
def test_a_cmake_file_of_its_own_builds_it(fmus, tmp_path):
    if not shutil.which("cmake"):
        pytest.skip("cmake is not installed")

    with zipfile.ZipFile(fmus(2)) as archive:
        archive.extractall(tmp_path)

    build = tmp_path / "build"
    configure = ["cmake", "-S", str(tmp_path / "sources"), "-B", str(build), f"-DFMI_HEADERS={HEADERS}"]
    subprocess.run(configure, check=True, capture_output=True)
    subprocess.run(["cmake", "--build", str(build)], check=True, capture_output=True)
    assert list(build.glob("four_bar.*"))


def test_nothing_is_allocated_and_no_stack_is_without_bound(tmp_path):
    if not shutil.which("gcc"):
        pytest.skip("gcc is not installed")

    model = scene("four_bar", "rk4").compile()
    text = core.core(model, specialise.own(model).traced)
    assert not re.search(r"\b(malloc|calloc|realloc|free|alloca|printf|fopen)\b", text)
    (tmp_path / "scene.c").write_text(text)
    command = ["gcc", "-O2", *STRICT, "-fstack-usage", "-c", "scene.c", "-o", "scene.o"]
    subprocess.run(command, check=True, cwd=tmp_path)
    frames = [line.split("\t") for line in (tmp_path / "scene.su").read_text().splitlines()]
    assert frames and {kind for _, _, kind in frames} <= {"static", "dynamic,bounded"}
    assert sum(int(size) for _, size, _ in frames) < 64 * 1024  # were each below the other


TWO = """
#include <stdio.h>
#include <stdlib.h>
#include "fmi2FunctionTypes.h"

#define CALLS(model) \\
    fmi2Component model##_fmi2Instantiate(fmi2String, fmi2Type, fmi2String, fmi2String, \\
                                          const fmi2CallbackFunctions *, fmi2Boolean, fmi2Boolean); \\
    fmi2Status model##_fmi2SetupExperiment(fmi2Component, fmi2Boolean, fmi2Real, fmi2Real, fmi2Boolean, fmi2Real); \\
    fmi2Status model##_fmi2EnterInitializationMode(fmi2Component); \\
    fmi2Status model##_fmi2ExitInitializationMode(fmi2Component); \\
    fmi2Status model##_fmi2DoStep(fmi2Component, fmi2Real, fmi2Real, fmi2Boolean); \\
    fmi2Status model##_fmi2GetReal(fmi2Component, const fmi2ValueReference *, size_t, fmi2Real *);
#define RUN(model, guid, folder, output) \\
    {{ \\
        const fmi2ValueReference at = output; \\
        double y = 0.0; \\
        fmi2Component c = model##_fmi2Instantiate("one", fmi2CoSimulation, guid, folder, &callbacks, 0, 0); \\
        if (!c || model##_fmi2SetupExperiment(c, 0, 0.0, 0.0, 0, 0.0) || model##_fmi2EnterInitializationMode(c) || \\
            model##_fmi2ExitInitializationMode(c)) return 1; \\
        for (int k = 0; k < 20; k++) if (model##_fmi2DoStep(c, 0.01 * k, 0.01, 1)) return 2; \\
        if (model##_fmi2GetReal(c, &at, 1, &y)) return 3; \\
        printf("%.17g\\n", y); \\
    }}

CALLS(four_bar)
CALLS(pendulum)

static void say(fmi2ComponentEnvironment e, fmi2String i, fmi2Status s, fmi2String c, fmi2String m, ...)
{{
    (void)e, (void)i, (void)s, (void)c, (void)m;
}}

int main(void)
{{
    const fmi2CallbackFunctions callbacks = {{say, calloc, free, 0, 0}};

    RUN(four_bar, {guids[0]}, {folders[0]}, {outputs[0]})
    RUN(pendulum, {guids[1]}, {folders[1]}, {outputs[1]})
    return 0;
}}
"""


def prefixed_headers(folder):
    """Headers that add FMI2_FUNCTION_PREFIX to names, as FMI's own do (2.1.1); those of fmpy were changed not to."""
    for path in HEADERS.glob("fmi2*.h"):
        text = path.read_text()
        plain = "#define fmi2FullName(name) name"
        pasted = "#define PASTE(a, b) a##b\n#define PASTED(a, b) PASTE(a, b)\n"
        assert path.name != "fmi2Functions.h" or plain in text
        text = text.replace(plain, f"{pasted}#define fmi2FullName(name) PASTED(FMI2_FUNCTION_PREFIX, name)")
        (folder / path.name).write_text(text)
    return folder


def test_two_of_them_go_into_one_program(fmus, tmp_path):
    """Names of their functions begin with those of the models, as FMI asks, and so do all others that files share."""
    if not shutil.which("gcc"):
        pytest.skip("gcc is not installed")

    (tmp_path / "headers").mkdir()
    headers = prefixed_headers(tmp_path / "headers")
    paths = [Path(fmus(2)), scene("pendulum", "rk4").export(tmp_path / "pendulum.fmu", with_sources=True)]
    objects, said, expected = [], {"guids": [], "folders": [], "outputs": []}, []

    for path in paths:
        folder = Path(fmpy.extract(str(path), str(tmp_path / path.stem)))
        described = fmpy.read_model_description(str(folder))
        name = described.coSimulation.modelIdentifier
        output = next(v for v in described.modelVariables if v.causality == "output")
        includes = [f"-DFMI2_FUNCTION_PREFIX={name}_", f"-I{folder / 'sources'}", "-isystem", str(headers)]

        for file in sources.compiled(2):
            objects.append(tmp_path / f"{name}_{file}.o")
            command = ["gcc", "-O1", "-std=c99", *includes, "-c", str(folder / "sources" / file), "-o"]
            subprocess.run([*command, str(objects[-1])], check=True)

        said["guids"].append(f'"{described.guid}"')
        said["folders"].append(f'"{(folder / "resources").as_uri()}"')
        said["outputs"].append(output.valueReference)
        run = fmpy.simulate_fmu(
            str(path), stop_time=0.2, output_interval=0.01, fmi_type="CoSimulation", output=[output.name]
        )
        expected.append(run[output.name][-1])

    (tmp_path / "two.c").write_text(TWO.format(**said))
    command = ["gcc", "-std=c99", "-isystem", str(headers), "two.c", *map(str, objects), "-lm", "-o", "two"]
    subprocess.run(command, check=True, cwd=tmp_path)
    told = subprocess.run([str(tmp_path / "two")], check=True, capture_output=True, text=True).stdout
    np.testing.assert_allclose([float(line) for line in told.split()], expected, rtol=1e-12, atol=1e-12)


@pytest.mark.parametrize(
    ("name", "integrator"), [("pendulum", "auto"), ("floating_wind_turbine/turbine_at_sea", "rk4")]
)
def test_code_of_a_scene_compiles_without_a_warning(name, integrator, tmp_path):
    """What clang and gcc warn of: a place added that is 0; and a wave's number that counts bodies later."""
    (tmp_path / "scene.c").write_text(core.core(scene(name, integrator).compile()), encoding="utf-8")
    command = [*COMPILERS["zig"], *STRICT, "-c", "scene.c", "-o", "scene.o"]
    told = subprocess.run(command, cwd=tmp_path, capture_output=True, text=True, check=False)
    assert told.returncode == 0, told.stderr


def test_a_function_that_calls_itself_is_refused():
    program = Program()
    function = program.add(plain_function(algebra.dot), [shapes.Tuple(None, (shapes.ANY_REAL,) * 3)] * 2)
    function.items.append(Line(f"{function.name}();"))

    with pytest.raises(Untraceable, match="calls itself"):
        program.text([function])
