"""Kernels on symbols: what is traced gives the bits of the kernels interpreted and compiled; derivatives are
exact.
"""

import ctypes
import re
import subprocess
import sys
from functools import cache

import numpy as np
import pytest

import mbdfmi
from mbdfmi.export.core import PREAMBLE
from mbdfmi.kernels.dynamics import rates
from mbdfmi.kernels.layout import ARRAY
from mbdfmi.native.platforms import PLATFORMS, host_platform
from mbdfmi.run.instance import Instance
from mbdfmi.trace import c99, derivatives, functions, places, searches, specialise
from mbdfmi.trace.graph import Graph, Untraceable
from mbdfmi.trace.plain import Kernels
from mbdfmi.trace.program.functions import Program
from tests import model_files

# members in waves and polygons of a hull are ten thousands of operations: in test_traced_sea
LARGE = ("moored_buoy", "ship_crane")
SCENES = [
    path
    for path in model_files.SCENES
    if "[body" in path.read_text(encoding="utf-8") and path.stem not in LARGE
]
names = pytest.mark.parametrize("path", SCENES, ids=lambda path: path.stem)


@cache
def model_of(path):
    return mbdfmi.load(path).compile()


def moved(path):
    """A run of a scene a little off its start, where nothing is zero by chance."""
    instance = Instance(model_of(path))
    instance.step(0.01)
    return instance


ENTRY = """
int64_t fallbacks;
static int32_t kernel(const Run *run)
{{
    (void)run;
    fallbacks++;
    return 0;
}}

{text}

int32_t scene(double *reals, double *state, double *work, double *u)
{{
    double once[1 + {once}] = {{0.0}};
    const Run run = {{reals, state, work, u, once}};

    return traced_rates(&run);
}}
"""


@pytest.fixture(scope="session")
def traced(tmp_path_factory):
    """Traced x' = f of all scenes, compiled: scene -> (its kernel in C as a function of m and d, the counter
    of fallbacks).
    """
    folder = tmp_path_factory.mktemp("traced")
    found = {path: specialise.trace_rates(moved(path)) for path in SCENES}
    sources = []

    for k, (path, made) in enumerate(found.items()):
        source = folder / f"scene{k}.c"
        text = ENTRY.format(text=made.text("kernel"), once=made.once[1])
        program = Program(model_of(path).ints)
        parts = [PREAMBLE, *program.text(searches.called(program, made.calls), text)]
        text = re.sub(r"\b(scene|fallbacks)\b", rf"\g<1>{k}", text)
        text = text if made.guards else text.replace("static int32_t kernel", "int32_t kernel")
        source.write_text("\n\n".join([*parts, text]))
        sources.append(source)

    library = folder / "traced.so"
    target = PLATFORMS[host_platform()].target
    warnings = ["-Wall", "-Wextra", "-Werror", "-Wno-missing-prototypes"]
    command = [sys.executable, "-m", "ziglang", "cc", "-target", target, *c99.FLAGS, *warnings]
    command += ["-fPIC", "-shared", *map(str, sources), "-lm", "-o", str(library)]
    subprocess.run(command, check=True, cwd=folder)
    loaded = ctypes.CDLL(str(library))

    def of(k):
        native = getattr(loaded, f"scene{k}")
        native.argtypes = [ctypes.c_void_p] * 4

        def call(m, d):
            buffers = (m.reals_buffer, d.state_buffer, d.work_buffer, d.u_buffer)
            return native(*(buffer.ctypes.data for buffer in buffers))

        return call, ctypes.c_int64.in_dll(loaded, f"fallbacks{k}")

    return {path: of(k) for k, path in enumerate(found)}


def scattered(instance, seed):
    """States, inputs and times about that of an instance."""
    random = np.random.default_rng(seed)
    d, x = instance.d, instance.d.x.copy()

    for size in (0.001, 0.03, 0.3):
        for _ in range(4):
            d.x[:] = x + size * random.standard_normal(len(x))
            d.input[:] = random.standard_normal(len(d.input))
            d.now[0] = abs(random.standard_normal())
            yield


@names
def test_traced_compiled_and_interpreted_kernels_give_the_same_bits(path, traced):
    native, fallbacks = traced[path]
    instance = moved(path)
    m, d = instance.m, instance.d
    interpreted = Kernels({})["dynamics.rates"].evaluate_now
    compared = 0

    for _ in scattered(instance, 1):
        x = d.x.copy()
        ends = []

        for evaluate in (rates.evaluate_now, interpreted, native):
            d.x[:] = x
            before = fallbacks.value

            with np.errstate(all="ignore"):
                status = evaluate(m, d)

            if status or fallbacks.value > before:
                break

            ends.append(np.concatenate([d.x, d.x_rate]) + 0.0)  # zeros without signs

        if len(ends) == 3:
            assert ends[0].tobytes() == ends[1].tobytes() == ends[2].tobytes()
            compared += 1

    # a hull further off has other panels in the water, a line another part on the bed: the generic kernel's
    assert compared >= (4 if path.stem in ("floating_crane", "offshore_crane", "turbine_at_sea") else 10)


@names
def test_a_traced_run_leaves_nothing_else_that_anyone_reads(path, traced):
    """Whole runs with the traced kernel in the place of the generic one, all that it does not leave
    spoiled.
    """
    native, _ = traced[path]
    instance = moved(path)
    m, d = instance.m, instance.d
    model = instance.model
    kept = places.places_of(model, (*places.KEPT_WORK, *places.GIVEN_WORK))
    work = places.places_of(model, [name for name, array in ARRAY.items() if array.buffer == "work"])
    scratch = sorted(work - kept - places.places_of(model, STEPPERS_OWN))
    before = d.work_buffer.copy()
    d.work_buffer[scratch] = np.nan
    status = native(m, d)
    found = d.x_rate.copy()
    d.work_buffer[:] = before
    assert status == 0 and np.array_equal(found, expected(instance))


STEPPERS_OWN = ("held", "weight", "weighs", "aim", "damping")


def expected(instance):
    """x' of the kernels at the state of an instance."""
    assert rates.evaluate_now(instance.m, instance.d) == 0
    return instance.d.x_rate.copy()


# derivatives

STEPS = (2e-3, 2e-5)
"""Between knots, and where functions bend much, the second, else the first: it loses fewer digits."""
WEIGHTS = {1: 4 / 5, 2: -1 / 5, 3: 4 / 105, 4: -1 / 280}


def differences(function, x, step):
    """d function / dx by central differences of order 8; step : of each of x, or of all."""
    columns = []
    step = np.broadcast_to(step, x.shape)

    for j in range(len(x)):
        column = 0.0

        for k, weight in WEIGHTS.items():
            for sign in (1, -1):
                moved_x = x.copy()
                moved_x[j] += sign * k * step[j]
                column = column + sign * weight * function(moved_x) / step[j]

        columns.append(column)

    return np.array(columns).T.reshape(-1, len(x))


def rates_of_x(instance):
    def function(x):
        instance.d.x[:] = x
        assert rates.evaluate(instance.m, instance.d, 0.0) == 0
        return instance.d.x_rate.copy()

    return function


@names
def test_derivatives_by_states_are_those_of_differences(path, check):
    instance = moved(path)
    found = functions.derivatives(instance, outputs=False)
    x = instance.d.x.copy()
    errors = [np.abs(found.A - differences(rates_of_x(instance), x, step)).max() for step in STEPS]
    check(min(errors) / np.abs(found.A).max(initial=1.0), 1e-10)


@pytest.mark.parametrize("name", ["four_bar", "three_link_arm", "floating_wind_turbine"])
def test_derivatives_by_inputs_and_parameters_are_those_of_differences(name, check):
    path = next(path for path in SCENES if path.stem == name)
    instance = moved(path)
    model = instance.model
    tunable = [v for v in model.of_causality("parameter") if "mass" in v.name or "gravity" in v.name]
    found = functions.derivatives(instance, [v.name for v in tunable])
    x, u, p = instance.d.x.copy(), instance.u[: model.n_u].copy(), instance.reals.copy()
    at = [v.index for v in tunable]

    def values(inputs, parameters):
        instance.u[: model.n_u] = inputs
        instance.reals[at] = parameters
        instance.prepare()
        instance.d.x[:] = x
        assert rates.evaluate(instance.m, instance.d, 0.0) == 0
        f = instance.d.x_rate.copy()
        instance.d.x[:] = x
        return np.concatenate([f, instance.outputs()])

    by_inputs = differences(lambda inputs: values(inputs, p[at]), u, 1.0)
    steps = 1e-2 * np.maximum(1.0, np.abs(p[at]))
    by_parameters = differences(lambda parameters: values(u, parameters), p[at], steps)
    exact_by_inputs = np.vstack([found.B, found.D])
    exact = np.vstack([found.rates_by_parameters, found.outputs_by_parameters])
    check(np.abs(exact_by_inputs - by_inputs).max() / np.abs(exact_by_inputs).max(), 1e-10)
    check(np.abs(exact - by_parameters).max() / np.abs(exact).max(), 1e-10)


@names
def test_forward_and_reverse_derivatives_on_the_graph_are_the_same(path, check):
    if path.stem in ("floating_wind_turbine", "turbine_at_sea", "offshore_crane"):
        pytest.skip("minutes in reverse; the smaller ones have all that it has")

    scene = functions.scene_graph(moved(path), outputs=False)
    graph = scene.graph
    one = graph.constant(1.0)
    columns = derivatives.forward(graph, scene.rates, [{leaf: one} for leaf in scene.states])
    some = range(0, len(scene.rates), 3)
    exact = derivatives.at_the_trace(graph, scene.rates, scene.states)

    def number(k):
        return 0.0 if k is None else graph.values[k]

    forward = np.array([[number(column[i]) for column in columns] for i in range(len(scene.rates))])
    size = np.abs(exact).max(initial=1.0)
    check(np.abs(forward - exact).max() / size, 1e-13)

    for i in some:
        row = derivatives.reverse(graph, {scene.rates[i]: one}, scene.states)
        check(np.abs(np.array([number(k) for k in row]) - exact[i]).max() / size, 1e-12)


@pytest.mark.parametrize(("name", "most"), [("double_pendulum", 4.0), ("floating_wind_turbine", 10.0)])
def test_a_whole_jacobian_costs_a_few_evaluations(name, most):
    path = next(path for path in SCENES if path.stem == name)
    scene = functions.scene_graph(moved(path), outputs=False)
    graph = scene.graph
    alone = len(graph.needed(scene.rates))
    rows = derivatives.jacobian(graph, scene.rates, scene.states)
    entries = [k for row in rows for k in row if k is not None]
    assert len(graph.needed([*scene.rates, *entries])) <= most * alone


# the graph


def test_what_is_known_folds_away():
    graph = Graph()
    x, y = graph.leaf("x", 2.0), graph.leaf("y", 3.0)
    zero, one = graph.constant(0.0), graph.constant(1.0)
    assert graph.sum(x, zero) == graph.product(one, x) == graph.quotient(x, one) == x
    assert graph.product(zero, x) == graph.difference(x, x) == graph.quotient(zero, x) == zero
    assert graph.sum(x, graph.negative(y)) == graph.difference(x, y)
    assert graph.negative(graph.difference(x, y)) == graph.difference(y, x)
    assert graph.product(graph.negative(x), y) == graph.negative(graph.product(y, x))
    assert graph.sum(x, y) == graph.sum(y, x)


def test_what_work_arrays_hold_from_before_is_not_taken_for_known():
    instance = moved(next(path for path in SCENES if path.stem == "pendulum"))
    instance.d.work_buffer[places.places(instance.model, "held")[1]] = 2.0

    with pytest.raises(Untraceable, match="work"):
        specialise.trace_rates(instance)


def test_where_a_branch_goes_otherwise_the_generic_kernel_is_called(traced):
    """A rope's redundant row that is exchanged for another: the guards on row_redundant fail."""
    path = next(path for path in SCENES if path.stem == "bricard")
    native, fallbacks = traced[path]
    instance = moved(path)
    before = fallbacks.value
    instance.d.row_redundant[:] = 1.0 - instance.d.row_redundant
    native(instance.m, instance.d)
    assert fallbacks.value == before + 1
