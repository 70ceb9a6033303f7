"""Libraries of one scene: the same bits as the library of all scenes, smaller; where a guard fails the
generic kernel.
"""

import re
import zipfile
from functools import cache
from pathlib import Path

import fmpy
import numpy as np
import pytest
from fmu_host import ERROR, OK, Library
from fmu_host import Instance as FMU

import mbdfmi
from mbdfmi.cli import main
from mbdfmi.export import specialise
from mbdfmi.export.core import core
from mbdfmi.kernels import language
from mbdfmi.run.instance import Entries, Instance
from mbdfmi.trace.binding import bound
from mbdfmi.trace.functions import derivatives
from mbdfmi.trace.specialise import elements, trace_jacobian, trace_rates

MODELS = Path(__file__).parents[1] / "models"

pytestmark = pytest.mark.skipif(
    language.INTERPRETED or language.JIT, reason="libraries of one scene stand beside the compiled one"
)


@cache
def scene(name, integrator):
    """A scene of models/ by another integrator."""
    found = mbdfmi.load(MODELS / f"{name}.toml")
    found.solver = {"integrator": integrator} | ({"step": 1e-3} if integrator == "rk4" else {})
    return found


@cache
def libraries(name, integrator):
    """(model, library of it alone) of that."""
    model = scene(name, integrator).compile()
    return model, specialise.scene_library(model)


def zipped(path, tmp_path):
    """kB of a file in an archive."""
    with zipfile.ZipFile(tmp_path / "one.zip", "w", zipfile.ZIP_DEFLATED) as archive:
        archive.write(path)

    return (tmp_path / "one.zip").stat().st_size / 1024


SOME = [
    ("pendulum", "rk4"),
    ("four_bar", "auto"),
    pytest.param("marble_run", "rk4", marks=pytest.mark.long),
]


@pytest.mark.parametrize(("name", "integrator"), SOME)
def test_a_scene_s_own_library_gives_the_same_bits(name, integrator):
    model, library = libraries(name, integrator)
    runs = [Instance(model), Instance(model, kernels=Entries.of(library))]

    for k in range(50):
        for run in runs:
            run.u[: model.n_u] = 0.1 * (k // 10)
            run.step(0.01)

        first, second = (run.outputs().tobytes() for run in runs)
        assert first == second
        assert runs[0].d.state_buffer.tobytes() == runs[1].d.state_buffer.tobytes()

    generic = runs[1].d.generic_evaluations[0]
    assert runs[0].d.generic_evaluations[0] == 0 and generic < 0.02 * runs[1].d.evaluations[0]
    projections, _, outputs = runs[1].d.generic_calls
    assert outputs == 0 and (projections == 0 or name == "marble_run")


@pytest.mark.parametrize(
    ("name", "step", "in_a_pass"),
    [("four_bar", 0.02, 2), pytest.param("bicycle", 0.05, 1, marks=pytest.mark.long)],
)
def test_corrections_of_the_projection_go_on_in_passes(name, step, in_a_pass):
    """Long steps lead far beside the constraints: more corrections than one pass has, none left to the kernel."""
    coarse = mbdfmi.load(MODELS / f"{name}.toml")
    coarse.solver = {"integrator": "rk4", "step": step}
    model = coarse.compile()
    runs = [Instance(model), Instance(model, kernels=Entries.of(specialise.scene_library(model)))]
    corrections = []

    for _ in range(50):
        spent = runs[1].d.evaluations[0] + runs[1].m.max_evaluations[0]

        for run in runs:
            run.step(step)

        # each look at the rows is taken off the limit, the first one is before all corrections
        corrections.append(spent - runs[1].d.evaluation_limit[0] - 1)
        assert runs[0].d.state_buffer.tobytes() == runs[1].d.state_buffer.tobytes()

    assert max(corrections) > in_a_pass and runs[1].d.generic_calls[0] == 0


@pytest.mark.long
def test_newton_s_method_of_radau_has_exact_derivatives(check):
    """Its Jacobian is that of the trace, its run that of the library of all, whose Jacobian is by differences."""
    model, library = libraries("slider_crank", "radau")
    runs = [Instance(model), Instance(model, kernels=Entries.of(library))]

    for run in runs:
        for _ in range(5):
            run.step(0.01)

    m, d = runs[1].m, runs[1].d
    assert d.generic_calls[1] == 0 and d.steps[0] == runs[0].d.steps[0]
    check(np.abs(d.x - runs[0].d.x).max() / np.abs(d.x).max(), 1e-9)
    found = np.zeros((m.n_x, m.n_x))

    for (row, column), place in elements(m).items():
        found[row, column] = d.jacobian[place]

    # where it was found last
    x = d.x.copy()
    d.x[:], d.time[0] = d.jacobian_x, d.jacobian_time[0]
    exact = derivatives(runs[1], outputs=False).A
    d.x[:] = x
    check(np.abs(found - exact).max() / np.abs(exact).max(), 1e-10)


@pytest.mark.parametrize(
    ("name", "most"),
    [
        ("double_pendulum", 4),
        pytest.param("floating_wind_turbine/floating_wind_turbine", 10, marks=pytest.mark.long),
    ],
)
def test_a_jacobian_takes_few_evaluations(name, most):
    """Operations of the traced one beside those of x'."""
    instance = Instance(scene(name, "radau").compile())
    instance.step(0.01)
    assert trace_jacobian(instance).operations < most * trace_rates(instance).operations


def test_axes_that_rounding_has_bent_are_straight():
    """Bars whose markers are turned by angles: what follows of their joints' axes is exact, and costs no products."""
    tilted = {"euler_parameters": [0.0, 0.0, np.sin(0.35), np.cos(0.35)]}
    bar = {"mass": 1.0, "inertia": [0.01, 0.1, 0.1], "marker": {"a": {"position": [-0.5, 0, 0], **tilted}}}
    scene_ = mbdfmi.Scene(
        name="bar",
        ground={"marker": {"a": {"position": [0.1, 0.2, 0], **tilted}}},
        body={"bar": bar},
        joint={"j": {"revolute": {}, "between": ["ground.a", "bar.a"]}},
        solver={"integrator": "rk4", "step": 1e-3},
    )
    model = scene_.compile()
    m, _ = model.views(model.reals)
    near = m.body_A[np.abs(m.body_A - np.rint(m.body_A)) < 1e-12]
    assert np.array_equal(near, np.rint(near))


def test_parameters_stay_tunable():
    model, library = libraries("pendulum", "rk4")
    heavy = {"gravity[3]": -3.7}
    runs = [Instance(model, heavy), Instance(model, heavy, kernels=Entries.of(library))]

    for run in runs:
        run.step(1.0)

    assert runs[0].outputs().tobytes() == runs[1].outputs().tobytes()


@pytest.mark.parametrize(
    ("name", "integrator", "parameter"),
    [("pendulum", "rk4", "gravity[3]"), ("four_bar", "auto", "coupler.mass")],
)
def test_parameters_that_change_in_a_run_count_from_the_next_step_on(name, integrator, parameter):
    """What follows from them alone is computed once in a step of communication, not once in a run."""
    model, library = libraries(name, integrator)
    index = next(v.index for v in model.of_causality("parameter") if v.name == parameter)
    runs = [Instance(model), Instance(model, kernels=Entries.of(library))]

    for factor in (1.0, 0.5, 3.0, 1e-9, 1.0):
        for run in runs:
            run.reals[index] = factor * model.reals[index]
            run.prepare()
            run.step(0.05)

        assert runs[0].outputs().tobytes() == runs[1].outputs().tobytes()
        assert runs[0].d.x.tobytes() == runs[1].d.x.tobytes()


def test_a_parameter_that_was_zero_and_is_not_goes_to_the_generic_kernel():
    model, library = libraries("pendulum", "rk4")
    slant = {"gravity[1]": 1.0}
    runs = [Instance(model, slant), Instance(model, slant, kernels=Entries.of(library))]

    for run in runs:
        run.step(1.0)

    assert runs[0].outputs().tobytes() == runs[1].outputs().tobytes()
    assert runs[1].d.generic_evaluations[0] == runs[1].d.evaluations[0] > 0


@pytest.mark.parametrize(
    ("integrator", "fmi", "most"),
    [
        ("rk4", 2, 45),
        pytest.param("rk4", 3, 45, marks=pytest.mark.long),
        pytest.param("auto", 3, 70, marks=pytest.mark.long),
        pytest.param("auto", 2, 70, marks=pytest.mark.long),
    ],
)
def test_what_a_pendulum_has_no_use_for_is_not_in_its_library(integrator, fmi, most, tmp_path):
    library = specialise.scene_library(scene("pendulum", integrator).compile(), fmi=fmi)
    assert zipped(library, tmp_path) < most


def test_an_FMU_of_it_is_the_same_and_says_how_often_it_was_of_use(tmp_path, fmpy_log):
    told, logger = fmpy_log
    runs, texts = [], []

    for specialised in (False, True):
        path = scene("pendulum", "rk4").export(tmp_path / f"{specialised}.fmu", specialise=specialised)
        told.clear()
        runs.append(
            fmpy.simulate_fmu(
                str(path),
                stop_time=1.0,
                output_interval=0.05,
                fmi_type="CoSimulation",
                debug_logging=True,
                logger=logger,
            )
        )
        texts.append("\n".join(told))

    assert np.array_equal(runs[0], runs[1])
    assert "evaluations 0 were left" in texts[1] and "were left" not in texts[0]


def test_the_library_of_another_scene_is_refused(tmp_path, fmpy_log):
    told, logger = fmpy_log
    path = scene("pendulum", "rk4").export(tmp_path / "own.fmu", specialise=True)
    other = scene("two_link_arm", "rk4").export(tmp_path / "other.fmu")
    mixed = tmp_path / "mixed.fmu"

    with zipfile.ZipFile(path) as own, zipfile.ZipFile(other) as rest, zipfile.ZipFile(mixed, "w") as archive:
        library = own.read(next(name for name in own.namelist() if name.startswith("binaries/")))

        for name in rest.namelist():
            archive.writestr(name, library if name.startswith("binaries/") else rest.read(name))

    with pytest.raises(Exception, match=r"instantiate|Instantiate"):
        fmpy.simulate_fmu(str(mixed), logger=logger)

    assert any("the library is of one scene" in text for text in told)


def test_a_large_scene_keeps_its_loops():
    chain = {
        "name": "chain",
        "body": {f"b{k}": {"mass": 1.0, "inertia": [1.0, 2.0, 2.0]} for k in range(24)},
        "joint": {
            f"j{k}": {"spherical": {}, "between": [f"b{k - 1}" if k else "ground", f"b{k}"]}
            for k in range(24)
        },
    }
    found = specialise.own(mbdfmi.Scene(**chain).compile())
    assert not found.traced and "loops are faster" in found.told


def test_commands_make_and_use_it(tmp_path, capsys):
    text = (MODELS / "pendulum.toml").read_text(encoding="utf-8")
    path = tmp_path / "own.toml"
    path.write_text(text, encoding="utf-8")
    tables = []

    for more in ([], ["--specialise"]):
        table = tmp_path / f"{len(more)}.csv"
        assert main(["simulate", str(path), "--until", "1", "--csv", str(table), *more]) == 0
        tables.append(np.genfromtxt(table, delimiter=",", names=True).tolist())

    assert tables[0] == tables[1]  # but for the signs of zeros
    assert main(["export", str(path), "--specialise", "-o", str(tmp_path / "own.fmu")]) == 0


@cache
def bound_library(names):
    """(model, what is its own, its library) of the double pendulum with parameters bound."""
    model = bound(scene("double_pendulum", "rk4").compile(), names)
    found = specialise.own(model)
    return model, found, specialise.scene_library(model, found=found)


def test_bound_parameters_are_folded_and_give_the_same_bits():
    free = scene("double_pendulum", "rk4").compile()
    model, found, library = bound_library(("all",))
    before = specialise.own(free).traced[0]
    bound_ones = found.traced[0]
    # what follows from parameters alone is computed once a step where they are free, and never where they are bound
    assert bound_ones.operations < before.operations and bound_ones.once[1] < 0.2 * before.once[1]
    runs = [Instance(free), Instance(model, kernels=Entries.of(library))]

    for _ in range(50):
        for run in runs:
            run.step(0.01)

        assert runs[0].outputs().tobytes() == runs[1].outputs().tobytes()

    assert runs[1].d.generic_evaluations[0] == 0


def test_a_bound_parameter_is_shown_and_cannot_be_set(tmp_path):
    path = scene("double_pendulum", "rk4").export(tmp_path / "bound.fmu", bind=["gravity", "bar1.mass"])
    described = fmpy.read_model_description(str(path), validate=True)
    found = {v.name: v for v in described.modelVariables}

    for name in ("gravity[3]", "bar1.mass"):
        assert (found[name].causality, found[name].variability) == ("local", "constant")

    assert float(found["gravity[2]"].start) == -9.81 and found["bar2.mass"].causality == "parameter"

    fmu = FMU(Library(path, tmp_path / "unpacked"))
    assert fmu.setup() == fmu.enter() == OK
    assert fmu.get("bar1.mass") == (OK, [1.0])
    assert fmu.set({"bar1.mass": 2.0}) == ERROR and "is bound" in fmu.message
    assert fmu.set({"bar2.mass": 2.0}) == OK


def test_what_cannot_be_bound_is_refused():
    model = scene("pendulum", "rk4").compile()

    with pytest.raises(ValueError, match="tolerance"):
        bound(scene("pendulum", "auto").compile(), ["solver.tolerance"])

    with pytest.raises(KeyError, match="gravity"):
        bound(model, ["gravty"])

    with pytest.raises(ValueError, match="bound"):
        scene("pendulum", "rk4").simulate(
            0.1, parameters={"gravity[3]": -1.0}, specialise=True, bind=["gravity"]
        )


def test_the_scene_may_ask_for_it(tmp_path):
    asking = mbdfmi.load(MODELS / "pendulum.toml")
    asking.code = {"specialise": True, "bind": ["all"], "sources": True}
    path = asking.export(tmp_path / "asked.fmu")

    with zipfile.ZipFile(path) as archive:
        assert "sources/scene.c" in archive.namelist()
        described = archive.read("modelDescription.xml")

    assert b'variability="constant"' in described and b"<SourceFiles>" in described


def test_what_is_computed_once_is_forgotten_where_kernels_write_what_changes_seldom():
    """Which rows are redundant may change within a communication step: behind each such statement all is forgotten."""
    model = scene("four_bar", "rk4").compile()
    lines = [line.strip() for line in core(model, specialise.own(model).traced).splitlines()]
    writing = [
        k for k, line in enumerate(lines) if re.match(r"d_(row_redundant|lends|loose)\[[^=]*\] = ", line)
    ]
    assert len(writing) > 5 and all(lines[k + 1] == "forget_once(run);" for k in writing)
    (macro,) = (line for line in lines if line.startswith("#define forget_once"))
    kept = {
        re.search(r"run->once\[(\d+)\] == 0.0", line)[1]
        for line in lines
        if "] == 0.0) {" in line and "once" in line
    }
    assert kept == set(re.findall(r"once\[(\d+)\]", macro)) and len(kept) == 3
