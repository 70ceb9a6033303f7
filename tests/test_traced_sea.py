"""Seas and moorings on symbols: what a kernel sums or solves for is one operation, with derivatives that are exact."""

import numpy as np
import pytest
from fmu_host import OK
from scenes import evaluate
from test_composite_lines import BUOYED, ROUGH
from test_directional_derivatives import columns, library_of, through_points
from test_hydrodynamics import OUTPUTS, SEA, afloat, database  # noqa: F401
from test_model_exchange import Solver
from test_trace import differences
from test_waves_at_members import DRAWN, pile

import mbdfmi
from mbdfmi import Scene
from mbdfmi.analysis import linear
from mbdfmi.analysis.exact import exact
from mbdfmi.compiler.model import compile_scene
from mbdfmi.export import specialise
from mbdfmi.export.tape import NONE, tape
from mbdfmi.kernels import language
from mbdfmi.kernels.dynamics import rates
from mbdfmi.kernels.forces import solutions
from mbdfmi.run.instance import Entries, Instance
from mbdfmi.trace.functions import derivatives
from mbdfmi.trace.graph import Untraceable
from mbdfmi.trace.searches import VALUES
from mbdfmi.trace.specialise import places, trace_outputs, trace_rates, tracer_of
from tests import model_files

G = 9.80665
COMPILED = pytest.mark.skipif(
    language.INTERPRETED or language.JIT, reason="libraries of one scene stand beside the compiled one"
)
LINE = {"length": 473.3, "mass": 130.4, "diameter": 0.0809, "stiffness": 589e6}
FREE = {"sections": [{"length": 150.0, "mass": 20.0, "stiffness": 5e7}] * 2}
START = {"position": [2.0, -1.5, 0.4], "zyx_deg": [10, 4, -7], "velocity": [0.7, 0.2, -0.4]}


DEEP = {"depth": 1000}


def buoy(line, at, anchor=(0, 0, 0), sea=None, **scene):
    """A body at a place, turned, that moves, held by one line from an anchor on the ground at a marker off its middle."""
    start = {
        "position": list(at),
        "zyx_deg": [20, 5, -10],
        "velocity": [1, 2, -0.5],
        "omega": [0.1, 0.2, 0.3],
    }
    outputs = ["tension", "anchor_tension", "grounded_length", "force", "power"]
    return Scene.model_validate(
        {
            "name": "buoy",
            "gravity": [0, 0, -G],
            "output": ["total_energy", "dissipated_power"],
            "ground": {"marker": {"anchor": {"position": list(anchor)}}},
            "body": {
                "buoy": {
                    "mass": 1e4,
                    "inertia": [1e4, 2e4, 3e4],
                    "marker": {"eye": {"position": [1, 0.5, -1]}},
                }
            },
            "joint": {"sea": {"free": {}, "between": ["ground", "buoy"], "start": start}},
            "force": {
                "line": {"catenary": line, "between": ["ground.anchor", "buoy.eye"], "output": outputs}
            },
        }
        | ({"sea": sea} if sea else {})
        | scene
    )


LINES = {
    "part of it on the bed": (LINE, (440, 60, 120)),
    "steep and taut": (LINE, (60, 20, 470)),
    "all of it on the bed": (LINE, (400, 10, 0.9)),
    "slack": (LINE, (100, 10, 90)),
    "without a bed": (LINE, (300, -200, 120), (0, 0, -100), DEEP),
    "turned round": (LINE, (300, -200, -280), (0, 0, -100), DEEP),
    "sections, a buoy on the bed": (BUOYED, (440, 60, 120)),
    "sections, taut": (BUOYED, (455, 60, 170)),
    "sections, slack": (BUOYED, (250, 60, 40)),
    "sections, rough bed": (ROUGH, (440, 60, 120)),
    "sections along a rough bed": (ROUGH, (452, 20, 0.5)),
    "sections without a bed": (FREE, (200, 50, -160), (0, 0, -100), DEEP),
}


def instance_of(scene, until=0.0):
    instance = Instance(compile_scene(scene))

    if until:
        instance.step(until)

    return instance


def both(instance):
    """x' and y of an instance as a function of x."""

    def values(x):
        instance.d.x[:] = x
        found = evaluate(instance).copy()
        instance.d.x[:] = x
        return np.concatenate([found, instance.outputs()])

    return values


def off(instance, strides):
    """How far exact derivatives of x' and y by x are from differences of order 8, by the largest of each row and a part of that of all."""
    found = derivatives(instance)
    exact = np.vstack([found.A, found.C])
    x = instance.d.x.copy()
    values = np.abs(both(instance)(x))
    # the size of a tension that is none has no derivative
    none = ~np.isfinite(exact).all(axis=1)
    assert (values[none] == 0.0).all()
    exact[none] = 0.0
    size = np.abs(exact).max(axis=1) + 1e-3 * np.abs(exact).max() + 1e-3 * values
    errors = [np.abs(exact - differences(both(instance), x, h)).max(axis=1) / size for h in strides]
    instance.d.x[:] = x
    return np.min(errors, axis=0).max()


@pytest.mark.parametrize("name", LINES)
def test_derivatives_of_lines_are_exact(name, check):
    """Newton's method leaves 1e-13 of a line's length, which a stride divides."""
    check(off(instance_of(buoy(*LINES[name])), (0.2, 0.05, 0.01, 2e-3)), 1e-8)


@pytest.mark.parametrize("name", ["part of it on the bed", "steep and taut", "without a bed"])
def test_derivatives_by_a_line_s_length_mass_and_stiffness_are_exact(name, check):
    instance = instance_of(buoy(*LINES[name]))
    names = ["line.length", "line.mass", "line.stiffness"]
    found = derivatives(instance, names)
    at = [v.index for v in instance.model.of_causality("parameter") if v.name in names]
    assert len(at) == 3
    p, x = instance.reals[at].copy(), instance.d.x.copy()

    def values(parts):
        instance.reals[at] = p * parts
        instance.prepare()
        return both(instance)(x)

    exact = np.vstack([found.rates_by_parameters, found.outputs_by_parameters]) * p
    order = np.argsort(
        np.argsort([names.index(v.name) for v in instance.model.of_causality("parameter") if v.index in at])
    )
    numeric = [differences(values, np.ones(3), h)[:, order] for h in (1e-3, 1e-4, 1e-5, 1e-6)]
    size = np.abs(exact).max(axis=0) + 1e-3 * np.abs(exact).max()
    check(min(np.abs((exact - each) / size).max() for each in numeric), 1e-7)


def test_by_sections_there_are_no_derivatives_and_that_is_told():
    with pytest.raises(Untraceable, match=r"line\.length"):
        derivatives(instance_of(buoy(*LINES["sections, taut"])), ["line.length[1]"])


@pytest.mark.parametrize("options", [{}, {"position": "now"}])
def test_derivatives_in_waves_are_exact(database, options, check):  # noqa: F811
    instance = instance_of(afloat(database, START, SEA, outputs=OUTPUTS, **options), 1.3)
    check(off(instance, (2e-3, 2e-4)), 1e-10)


@pytest.mark.parametrize("stretching", [None, "wheeler"])
def test_derivatives_of_members_in_waves_are_exact(stretching, check):
    sea = {"waves": DRAWN, "depth": 30} | ({"stretching": stretching} if stretching else {})
    scene = pile(sea, {"sections": 5, "drag": 1.0, "added_mass": 1.0}, joint={"spherical": {}})
    check(off(instance_of(scene, 0.6), (2e-3, 5e-4, 1e-4)), 1e-10)


def bits(instance, seed=1):
    """How often the graph of x' gives the bits of the kernels where its guards hold, beside its place, of 8 times."""
    tracer = tracer_of(instance)
    assert tracer.run("dynamics.rates", "evaluate_now") == 0
    nodes = [tracer.node_at("work", j) for j in places(instance.model, "x_rate")]
    m, d = instance.m, instance.d
    buffers = {"reals": m.reals_buffer, "state": d.state_buffer, "work": d.work_buffer, "u": d.u_buffer}
    random, x, same = np.random.default_rng(seed), d.x.copy(), 0

    for k in range(8):
        d.x[:] = x + 10.0 ** -(2 + k % 3) * random.standard_normal(len(x))
        d.now[0] += 0.37 * k
        values = tracer.graph.values_at([*nodes, *tracer.guards], buffers | {"m": m, "d": d}, VALUES)
        found = np.array([values[node] for node in nodes]) + 0.0

        if all(bool(values[node]) == guard.holds for node, guard in tracer.guards.items()):
            assert rates.evaluate_now(m, d) == 0
            assert found.tobytes() == (d.x_rate + 0.0).tobytes()
            same += 1

    return same


@pytest.mark.parametrize("name", LINES)
def test_lines_traced_give_the_bits_of_the_kernels(name):
    assert bits(instance_of(buoy(*LINES[name]))) >= 2


@pytest.mark.parametrize("options", [{}, {"position": "now"}])
def test_waves_traced_give_the_bits_of_the_kernels(database, options):  # noqa: F811
    assert bits(instance_of(afloat(database, START, SEA, **options), 0.2)) == 8


def test_members_traced_give_the_bits_of_the_kernels():
    assert bits(instance_of(pile({"waves": DRAWN}, {"sections": 3}, joint={"spherical": {}}), 0.3)) >= 2


@pytest.mark.parametrize("name", ["moored_buoy", "ship_crane"])
def test_large_scenes_in_waves_are_traced(name, check):
    """Ten thousands of operations, which the rule of sizes leaves to the kernels' loops; derivatives and tapes are of them."""
    (path,) = (path for path in model_files.SCENES if path.stem == name)
    instance = instance_of(mbdfmi.load(path), 3.01)
    assert bits(instance) >= 2
    check(off(instance, (1e-4, 2e-5)), 1e-7)


# closed forms


def solve(instance, kind, k, *x):
    """What the kernel gives for x, and its derivatives."""
    takes, gives = solutions.WIDTHS[kind]
    y, slopes = np.zeros(gives), np.zeros(takes * gives)
    solutions.solve(instance.m, instance.d, kind, k, np.array(x, float), y)
    solutions.solve(instance.m, instance.d, solutions.N_KIND + kind, k, np.array(x, float), slopes)
    return y, slopes.reshape(gives, takes)


def test_the_stiffness_of_a_line_on_the_bed_is_that_of_the_textbook(check):
    """O. M. Faltinsen, Sea loads on ships and offshore structures, 1990, eq. 8.23: of a line that hardly stretches, w z = h."""
    instance = instance_of(buoy(LINE | {"stiffness": 1e15}, (440, 60, 120)))
    m, z = instance.m, 120.0
    w = G * m.line_mass[0]
    (H, V), slopes = solve(instance, solutions.CATENARY, 0, 440.0, z, w, LINE["length"], 1e15)
    k11 = w / (np.arccosh(1 + w * z / H) - 2 / np.sqrt(1 + 2 * H / (w * z)))
    check(abs(slopes[0, 0] / k11 - 1), 1e-7)


@pytest.mark.parametrize("kind", [solutions.BESIDE, solutions.ELEVATION])
def test_a_regular_wave_travels(database, kind, check):  # noqa: F811
    """What moves with it does not see it change: d/dt + omega / k d/dx along its way is nothing; and across it neither."""
    sea = {"waves": {"regular": {"height": 2, "period": 7}, "direction_deg": 30}, "depth": 40}
    instance = instance_of(afloat(database, START, sea, position="now"))
    y, slopes = solve(instance, kind, 0, 1.7, 3.0, -4.0)
    omega, k = 2 * np.pi / 7, instance.d.sea_wave[5]
    way = np.array([np.cos(np.pi / 6), np.sin(np.pi / 6)])
    size = np.abs(slopes).max()
    check(np.abs(slopes[:, 0] + omega / k * slopes[:, 1:] @ way).max() / size, 1e-12)
    check(np.abs(slopes[:, 1:] @ np.array([-way[1], way[0]])).max() / size, 1e-12)


@pytest.mark.parametrize(
    "kind", [solutions.AT_PLACE, solutions.BESIDE, solutions.ELEVATION, solutions.STATION]
)
def test_derivatives_of_waves_by_all_that_goes_in_are_those_of_differences(database, kind, check):  # noqa: F811
    if kind == solutions.STATION:
        instance = instance_of(pile({"waves": DRAWN, "stretching": "wheeler", "depth": 40}, {"sections": 3}))
    else:
        instance = instance_of(afloat(database, START, SEA, position="now"))

    x = np.array([1.7, 3.0, -4.0])[: solutions.WIDTHS[kind][0]]
    _, exact = solve(instance, kind, 0, *x)
    numeric = differences(lambda x: solve(instance, kind, 0, *x)[0], x, 2e-3)
    check((np.abs(exact - numeric).max(axis=1) / (np.abs(exact).max(axis=1) + 1e-12)).max(), 1e-9)


# FMUs and libraries of one scene


def exact_in_an_fmu(scene, tmp_path, bound, known=(), size=0.02):
    """Derivatives that an FMU gives along its states beside polynomials through values of it, and by some parameters."""
    model, library = library_of(scene, tmp_path)
    assert tape(model) is not NONE
    solver = Solver(library)
    wanted = [u.variable.name for u in library.description.derivatives]
    wanted += [v.name for v in model.of_causality("output")]
    x = solver.x
    names = [u.variable.derivative.name for u in library.description.derivatives]
    J = columns(solver.fmu, wanted, names)
    largest = np.abs(J).max(axis=1) + 1e-3 * np.abs(J).max()

    def moved(k, h):
        y = x.copy()
        y[k] += h
        solver.go(0.0, y)
        return np.array(solver.fmu.get(*wanted)[1])

    for k in range(0, len(x), 2):
        errors = []

        for h in (size, size / 10):
            other = through_points(lambda move, k=k: moved(k, move), h)
            errors.append(np.max(np.abs(J[:, k] - other) / largest))

        assert min(errors) < bound, (names[k], errors)

    solver.go(0.0, x)
    solver.call("fmi2EnterEventMode")

    for name in known:
        value = solver.fmu.value(name)
        (column,) = columns(solver.fmu, wanted, [name]).T

        def valued(h, name=name, value=value):
            assert solver.fmu.set({name: value + h}) == OK
            return np.array(solver.fmu.get(*wanted)[1])

        other = through_points(valued, 2e-3 * value)
        valued(0.0)
        assert np.abs(column - other).max() < 1e-6 * np.abs(other).max() > 0, name

    solver.fmu.free()


@COMPILED
@pytest.mark.parametrize("name", ["part of it on the bed", "without a bed", "sections, taut"])
def test_an_fmu_with_a_line_has_exact_derivatives(name, tmp_path):
    """By parameters of sections too, which its tape leaves to differences."""
    sections = name.startswith("sections")
    known = ["line.length[1]", "line.mass[2]"] if sections else ["line.length", "line.stiffness"]
    exact_in_an_fmu(buoy(*LINES[name]), tmp_path, 1e-7, known, size=0.1)


@COMPILED
@pytest.mark.parametrize("options", [{}, {"position": "now"}])
def test_an_fmu_in_waves_has_exact_derivatives(database, options, tmp_path):  # noqa: F811
    exact_in_an_fmu(afloat(database, START, SEA, outputs=OUTPUTS, **options), tmp_path, 1e-9)


@COMPILED
def test_an_fmu_with_a_member_in_waves_has_exact_derivatives(tmp_path):
    exact_in_an_fmu(
        pile({"waves": DRAWN}, {"sections": 3}, joint={"spherical": {}}), tmp_path, 1e-8, size=2e-3
    )


def test_linear_models_of_a_moored_body_in_waves_are_exact(database, monkeypatch):  # noqa: F811
    found = []

    def seen(*given):
        found.append(exact(*given))
        return found[-1]

    monkeypatch.setattr(linear, "exact", seen)
    afloat(database, {"zyx_deg": [3, 2, -4]}, SEA, outputs=OUTPUTS, position="now").linearise()
    buoy(*LINES["part of it on the bed"]).linearise()
    assert [each is None for each in found] == [False, False]


def alike(scene):
    """Runs by the library of all scenes and by that of one to the same bits; what that one has traced."""
    model = compile_scene(scene)
    found = specialise.own(model)
    library = specialise.scene_library(model, found=found)
    runs = [Instance(model), Instance(model, kernels=Entries.of(library))]

    for _ in range(20):
        for run in runs:
            run.step(0.05)

        assert runs[0].outputs().tobytes() == runs[1].outputs().tobytes()

    counted = runs[1].d.generic_evaluations[0]
    return found, counted / max(runs[1].d.evaluations[0], 1.0)


@COMPILED
def test_x_rates_and_outputs_in_a_library_of_the_scene_are_traced(database):  # noqa: F811
    found, left = alike(afloat(database, START, SEA, outputs=OUTPUTS, position="now"))
    assert {"traced_rates", "traced_outputs"} <= {each.name for each in found.traced}, found.told
    assert left == 0.0


@COMPILED
@pytest.mark.parametrize("name", ["without a bed", "sections, taut", "sections, rough bed"])
def test_lines_in_a_library_of_the_scene_are_traced(name):
    found, left = alike(buoy(*LINES[name]))
    assert {"traced_rates", "traced_outputs"} <= {each.name for each in found.traced}, found.told
    assert left < 0.5


@COMPILED
def test_radau_takes_the_exact_jacobian_of_a_line():
    scene = buoy(*LINES["without a bed"], solver={"integrator": "radau"})
    model = compile_scene(scene)
    found = specialise.own(model)
    assert "traced_jacobian" in {each.name for each in found.traced}, found.told
    runs = [
        Instance(model),
        Instance(model, kernels=Entries.of(specialise.scene_library(model, found=found))),
    ]
    ends = []

    for run in runs:
        run.step(1.0)
        ends.append(run.outputs())

    np.testing.assert_allclose(ends[1], ends[0], rtol=1e-6, atol=1e-6 * np.abs(ends[0]).max())


def test_that_is_one_operation_for_each(database):  # noqa: F811
    """Of a buoy on a line: what is solved for stands once in x', with the numbers that it gives."""
    instance = instance_of(buoy(*LINES["part of it on the bed"]))

    for traced, most in ((trace_rates(instance), 400), (trace_outputs(instance), 500)):
        assert "solve" in traced.calls and traced.operations < most
