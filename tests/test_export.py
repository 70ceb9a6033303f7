"""The FMU as a file: its library, description, archive, and what validators say."""

import re
import subprocess
import sys
import zipfile
from pathlib import Path

import fmpy
import numpy as np
import pytest
from elftools.elf.elffile import ELFFile
from fmpy.validation import validate_fmu
from lxml import etree

from mbdfmi import Scene, load
from mbdfmi.compiler.model import compile_scene
from mbdfmi.compiler.variables import Variable, array_of, arrays, reference_table
from mbdfmi.export import aot, description, description3, export_fmu, package
from mbdfmi.export.link import library
from mbdfmi.native import library as native
from mbdfmi.run.simulate import simulate
from mbdfmi.scene import read_scene
from mbdfmi.units import UNITS
from tests.model_files import SCENES


@pytest.fixture(scope="module", params=SCENES, ids=lambda path: path.stem)
def exported(request, tmp_path_factory):
    """A model of models/ and its FMU."""
    model = compile_scene(read_scene(request.param))
    folder = tmp_path_factory.mktemp("fmu")
    return model, export_fmu(model, folder / f"{model.identifier}.fmu", scene_file=request.param)


@pytest.fixture(scope="module")
def pendulum():
    return compile_scene(read_scene(next(path for path in SCENES if path.stem == "pendulum")))


def parse(fmu):
    with zipfile.ZipFile(fmu) as archive:
        return etree.fromstring(archive.read("modelDescription.xml"))


# every model


def test_validators_are_silent(exported):
    _, fmu = exported
    assert validate_fmu(str(fmu)) == []

    command = [sys.executable, "-m", "fmu_manipulation_toolbox", "-input", str(fmu), "-check"]
    done = subprocess.run(command, capture_output=True, text=True)
    said = done.stdout + done.stderr
    assert done.returncode == 0
    assert not re.search("ERROR|WARNING|CRITICAL", said), said


def test_fmpy_runs_it_as_in_process(exported):
    model, fmu = exported
    H, n = 0.01, 100
    there = fmpy.simulate_fmu(str(fmu), stop_time=n * H, output_interval=H)
    inside = simulate(model, n * H, H)

    for v in model.of_causality("output"):
        scale = np.abs(inside[v.name]).max() + 1
        np.testing.assert_allclose(there[v.name], inside[v.name], rtol=1e-12, atol=1e-12 * scale)


def by_elements(results):
    """Columns of scalars from those of arrays: their names have indices from 1."""
    columns = {}

    for name in results.dtype.names:
        for k in np.ndindex(results[name].shape[1:]):
            index = f"[{','.join(str(i + 1) for i in k)}]" if k else ""
            columns[name + index] = results[name][(slice(None), *k)]

    return columns


def test_fmi_3_is_the_same_fmu(exported, tmp_path):
    """Validator silent, every variable there, dependencies those of its elements, results equal to the bit."""
    model, two = exported
    three = export_fmu(model, tmp_path / "three.fmu", fmi=3)
    assert validate_fmu(str(three)) == []

    run = {"stop_time": 0.5, "output_interval": 0.01}
    there, here = fmpy.simulate_fmu(str(three), **run), fmpy.simulate_fmu(str(two), **run)
    columns = by_elements(there)
    assert set(here.dtype.names) == set(columns)
    assert all(np.array_equal(here[name], columns[name]) for name in columns)

    description3 = fmpy.read_model_description(str(three))
    whole = {array_of(v.name) for v in model.listed}
    assert {array_of(v.name) for v in description3.modelVariables} == whole | {"time"}

    parameters = {array_of(v.name) for v in model.of_causality("parameter")}

    for unknowns, led, more in (
        (description3.outputs, True, set()),
        (description3.initialUnknowns, False, parameters),
    ):
        for unknown in unknowns:
            elements = [v for v in model.listed if array_of(v.name) == unknown.variable.name]
            known = [k for v in elements for k in (v.depends + v.led_by if led else v.depends)]
            expected = {array_of(model.listed[k].name) for k in known} | more

            all_known = {array_of(v.name) for v in model.listed if v.causality == "input"} | more
            all_known |= {array_of(v.name) for v in model.exchanged if led and v.causality == "state"}

            # states and their rates depend on all that is known at the start
            if elements[0].causality != "output":
                assert elements[0].causality in ("state", "rate") and not led
                expected = all_known

            # absent means the same
            if unknown.dependencies is None:
                assert expected == all_known != set()
            else:
                assert {array_of(v.name) for v in unknown.dependencies} == expected


def test_arrays_are_whole_or_none():
    """Elements that do not follow each other by rows, or have another array's name, stay scalars."""

    def made(*names):
        return [Variable(name, "input", "continuous", 0.0, "N", "", k) for k, name in enumerate(names)]

    def found(*names):
        return [(array.name, array.first, array.shape) for array in arrays(made(*names))]

    assert found("a", "b[1]", "b[2]", "c") == [("a", 0, ()), ("b", 1, (2,)), ("c", 3, ())]
    assert found("m[1,1]", "m[1,2]", "m[2,1]", "m[2,2]") == [("m", 0, (2, 2))]
    assert found("b[2]", "b[1]") == [("b[2]", 0, ()), ("b[1]", 1, ())]
    assert found("b[2]", "b[3]") == [("b[2]", 0, ()), ("b[3]", 1, ())]
    assert found("b[1]", "a", "b") == [("b[1]", 0, ()), ("a", 1, ()), ("b", 2, ())]
    assert list(reference_table(made("a", "b[1]", "b[2]"))["length"]) == [1, 2, 0]


def test_unknown_version(pendulum, tmp_path):
    with pytest.raises(ValueError, match="fmi = 1: the versions .* are 2 and 3"):
        export_fmu(pendulum, tmp_path / "a.fmu", fmi=1)
    assert not (tmp_path / "a.fmu").exists()


def test_variables_and_structure(exported):
    model, fmu = exported
    root = parse(fmu)
    variables = root.findall("ModelVariables/ScalarVariable")
    outputs = [i for i, v in enumerate(variables, 1) if v.get("causality") == "output"]

    assert [v.get("name") for v in variables] == [v.name for v in model.listed]
    exchanged = [k for k, v in enumerate(model.listed, 1) if v.causality in ("state", "rate")]
    assert [v.get("valueReference") for v in variables] == [str(i) for i in range(len(variables))]
    assert all(v.get("description") for v in variables)

    inputs, parameters, states = (
        [k for k, v in enumerate(model.listed) if v.causality == causality]
        for causality in ("input", "parameter", "state")
    )

    for section, more in (("Outputs", []), ("InitialUnknowns", parameters)):
        unknowns = root.findall(f"ModelStructure/{section}/Unknown")
        now = section == "Outputs"
        assert [int(u.get("index")) for u in unknowns] == outputs + ([] if now else exchanged)

        for u in unknowns:
            given = u.get("dependencies")
            variable = model.listed[int(u.get("index")) - 1]
            expected = [*variable.depends, *(variable.led_by if now else ()), *more]

            # absent means: on all that is known
            if given is None:
                known = [*inputs, *(states if now else parameters)]
                assert expected == known or (variable.causality != "output" and not now)
            else:
                assert given == given.strip()
                assert [int(k) - 1 for k in given.split()] == expected


def chain(n, **joint_keys):
    """A chain of n bodies, with positions, velocities and accelerations out."""
    output = ["position", "velocity", "acceleration", "euler_parameters"]
    end = {"marker": {"end": {"position": [1, 0, 0]}}, "output": output}
    body = {f"b{k}": {"mass": 1, "inertia": [0.01] * 3, **end} for k in range(n)}
    between = [["ground", "b0"], *([f"b{k - 1}.end", f"b{k}"] for k in range(1, n))]
    joint = {f"j{k}": {"revolute": {}, "between": between[k], **joint_keys} for k in range(n)}
    return Scene(name="chain", body=body, joint=joint)


@pytest.mark.parametrize("with_inputs", [False, True])
def test_what_is_depended_on_grows_as_the_outputs_do(with_inputs):
    """Not as outputs times parameters; Outputs keep what they depend on, where that is not all that is known."""
    size = {}

    for n in (64, 256):
        model = compile_scene(chain(n, **({"input": "torque"} if with_inputs else {})))
        root = etree.fromstring(description.description(model))
        size[n] = len(etree.tostring(root.find("ModelStructure/InitialUnknowns")))
        outputs = [u.get("dependencies") for u in root.find("ModelStructure/Outputs")]
        known = len(model.of_causality("input")) + len(model.of_causality("state"))
        exact = [[str(k + 1) for k in v.depends + v.led_by] for v in model.of_causality("output")]
        assert [given if given is None else given.split() for given in outputs] == [
            None if 0 < known == len(given) else given for given in exact
        ]
        assert with_inputs or len(exact[0]) == 2 * n

    assert size[256] < 4.5 * size[64]
    assert size[256] < 500_000


def test_initial_unknowns_of_a_small_model_are_exact():
    """A position does not feel a torque at the start: it lists all that is known but the inputs; what feels all lists nothing."""
    model = compile_scene(chain(3, input="torque"))
    root = etree.fromstring(description.description(model))
    parameters = " ".join(str(k) for k, v in enumerate(model.variables, 1) if v.causality == "parameter")
    given = {int(u.get("index")): u.get("dependencies") for u in root.find("ModelStructure/InitialUnknowns")}

    for index, found in given.items():
        if model.listed[index - 1].causality != "output":
            assert found is None
            continue

        assert found == (None if "acceleration" in model.variables[index - 1].name else parameters)


def test_only_used_units_are_defined(exported):
    model, fmu = exported
    root = parse(fmu)
    used = {real.get("unit") for real in root.iter("Real")} - {None}

    assert {unit.get("name") for unit in root.iter("Unit")} == used
    for unit in root.iter("Unit"):
        exponents = {k: int(v) for k, v in unit.find("BaseUnit").attrib.items()}
        expected = UNITS[unit.get("name")]
        assert exponents == {k: n for k in ("kg", "m", "s", "rad") if (n := getattr(expected, k))}


def test_documentation(exported):
    model, fmu = exported
    with zipfile.ZipFile(fmu) as archive:
        page = archive.read("documentation/index.html").decode()

    text = "".join(etree.HTML(page).itertext())
    for name in [*model.scene.body, *model.scene.joint, *(v.name for v in model.variables)]:
        assert name in text


# units


def test_units_are_products_of_their_parts():
    """The exponents of a unit follow from its name."""
    for name, unit in UNITS.items():
        if name == "1":
            continue
        total = np.zeros(4, int)
        for sign, part in zip((1, -1), name.split("/")):
            for factor in part.split("."):
                base, power = re.fullmatch(r"(1|[a-zA-Z]+)(\d?)", factor).groups()
                total += sign * int(power or 1) * np.array(UNITS[base][:4])
        assert tuple(total) == unit[:4], name


# description


def test_description_is_reproducible(pendulum, monkeypatch):
    monkeypatch.setenv("SOURCE_DATE_EPOCH", "86400")
    root = etree.fromstring(description.description(pendulum))

    assert root.get("generationDateAndTime") == "1970-01-02T00:00:00Z"
    assert root.get("variableNamingConvention") == "structured"
    assert root.get("guid") == pendulum.guid


def test_a_spring_without_an_input_feeds_nothing():
    """Of a reaction of the ground; once it depended on an input before the first."""
    scene = chain(1)
    scene.ground.output = ["reaction_force"]
    scene.force["spring"] = {
        "spring_damper": {"stiffness": 10, "rest_length": 0.5},
        "between": ["ground", "b0.end"],
    }
    model = scene.compile()
    assert {v.depends for v in model.of_causality("output")} == {()}


@pytest.mark.parametrize("writer", [description.description, description3.description3])
def test_experiment_and_display_units(writer):
    """What the scene proposes stands in both versions; angles are shown in degrees."""
    scene = chain(1, output=["angle", "speed"])
    default = etree.fromstring(writer(compile_scene(scene))).find("DefaultExperiment").attrib
    assert dict(default) == {"startTime": "0.0", "stopTime": "10.0", "tolerance": "1e-08", "stepSize": "0.01"}

    scene.experiment = {"start": 1, "stop": 3, "step": 0.5, "tolerance": 1e-5}
    root = etree.fromstring(writer(compile_scene(scene)))
    given = root.find("DefaultExperiment").attrib
    assert dict(given) == {"startTime": "1.0", "stopTime": "3.0", "tolerance": "1e-05", "stepSize": "0.5"}

    variables = root.find("ModelVariables")
    shown = {}

    for v in variables:
        real = v if v.find("Real") is None else v.find("Real")
        shown[v.get("name")] = real.get("unit"), real.get("displayUnit")

    assert shown["j0.angle"] == ("rad", "deg") and shown["j0.speed"] == ("rad/s", "deg/s")
    assert shown["b0.mass"] == ("kg", None)


def test_odd_names(tmp_path):
    """Names that XML, the log and the naming convention have to quote."""
    body = {"mass": 1, "inertia": [1, 1, 1], "input": ["force"], "output": ["position"]}
    joint = {"free": {}, "between": ["ground", "a <b> & 100% #1 'x' ü"]}
    scene = Scene(name="odd <name> & 5%", body={joint["between"][1]: body}, joint={"j": joint})
    fmu = export_fmu(compile_scene(scene), tmp_path / "odd.fmu")

    assert validate_fmu(str(fmu)) == []
    result = fmpy.simulate_fmu(str(fmu), stop_time=0.1, output_interval=0.01)
    assert result.dtype.names[1].startswith("'a <b> & 100%")


def test_invalid_description_is_refused(pendulum):
    class Broken:
        def __getattr__(self, name):
            return getattr(pendulum, name)

        guid = ""
        identifier = "two\nlines"
        variables = listed = []

    with pytest.raises(description.DescriptionError, match="of 'pendulum' is not valid"):
        description.description(Broken())


# archive


def test_archive(exported):
    model, fmu = exported
    with zipfile.ZipFile(fmu) as archive:
        names = archive.namelist()
        icon = archive.read("model.png")
        assert archive.testzip() is None

    assert names[0] == "modelDescription.xml"
    if fmpy.platform == "linux64":
        assert f"binaries/linux64/{model.identifier}.so" in names
    assert {"model.png", "documentation/index.html", "resources/model.bin"} < set(names)
    assert "documentation/licenses/license.txt" in names
    assert any(name.startswith("resources/") and name.endswith(".toml") for name in names)
    assert icon.startswith(b"\x89PNG\r\n")


def test_the_scene_stays_at_home_when_asked(tmp_path):
    scene = load(next(path for path in SCENES if path.stem == "pendulum"))
    files = {}

    for with_scene in (True, False):
        with zipfile.ZipFile(scene.export(tmp_path / "a.fmu", with_scene=with_scene)) as archive:
            files[with_scene] = set(archive.namelist())

    assert files[True] - files[False] == {"resources/pendulum.toml"} and files[False] < files[True]


def test_export_is_reproducible(pendulum, tmp_path, monkeypatch):
    monkeypatch.setenv("SOURCE_DATE_EPOCH", "1700000000")
    first = export_fmu(pendulum, tmp_path / "a.fmu").read_bytes()
    assert export_fmu(pendulum, tmp_path / "new" / "folder" / "b.fmu").read_bytes() == first


def test_failed_export_leaves_nothing(pendulum, tmp_path, monkeypatch):
    target = tmp_path / "a.fmu"
    target.write_bytes(b"old")

    def disk_full(*_, **__):
        raise OSError("no space left")

    monkeypatch.setattr(package.zipfile.ZipFile, "writestr", disk_full)
    with pytest.raises(OSError, match="no space left"):
        export_fmu(pendulum, target)
    assert target.read_bytes() == b"old" and list(tmp_path.iterdir()) == [target]


def test_unknown_platform(pendulum, tmp_path):
    with pytest.raises(ValueError, match="unknown platform 'amiga': known are x86_64-linux"):
        export_fmu(pendulum, tmp_path / "a.fmu", ["amiga"])
    assert not (tmp_path / "a.fmu").exists()


# library


@pytest.fixture(scope="module")
def linux_library():
    return library("x86_64-linux")


def fmi_functions():
    """Names of all functions of FMI 2.0 and 3.0, from the headers."""
    folder = Path(fmpy.__file__).parent / "c-code"
    headers = [(folder / f"fmi{k}Functions.h").read_text() for k in (2, 3)]
    return {name for text in headers for name in re.findall(r"FMI[23]_Export \w+\s+(fmi[23]\w+);", text)}


def test_only_fmi_functions_and_the_table_of_kernels_leave_the_library(linux_library):
    with linux_library.open("rb") as file:
        symbols = list(ELFFile(file).get_section_by_name(".dynsym").iter_symbols())

    exported = {s.name for s in symbols if s["st_shndx"] != "SHN_UNDEF"}
    assert exported == fmi_functions() | {native.TABLE}


def test_library_needs_only_an_old_c_library(linux_library):
    with linux_library.open("rb") as file:
        elf = ELFFile(file)
        needed = {tag.needed for tag in elf.get_section_by_name(".dynamic").iter_tags("DT_NEEDED")}
        versions = [
            version.name
            for _, auxiliaries in elf.get_section_by_name(".gnu.version_r").iter_versions()
            for version in auxiliaries
        ]

    assert needed == {"libc.so.6", "libm.so.6"}
    assert max(tuple(map(int, v.removeprefix("GLIBC_").split("."))) for v in versions) <= (2, 17)


def test_kernels_that_do_not_compile(monkeypatch):
    monkeypatch.setattr(aot, "MODULE", "mbdfmi.kernels.nowhere")
    with pytest.raises(aot.CompileError, match="No module named mbdfmi.kernels.nowhere"):
        aot.compile_kernels()


def test_kernels_that_changed_meanwhile(monkeypatch):
    monkeypatch.setattr(aot, "source_hash", lambda: "of before")
    with pytest.raises(aot.CompileError, match="have changed since this program began"):
        aot.compile_kernels()
