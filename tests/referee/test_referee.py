"""Random scenes before the referee, and each verdict shown to be able to fail."""

import os
import re
from dataclasses import replace
from types import SimpleNamespace

import numpy as np
import pytest
from mutants.undone import UNDONE

from mbdfmi import Scene
from mbdfmi.compiler.model import compile_scene
from mbdfmi.kernels.language import INTERPRETED
from mbdfmi.run.instance import Instance

from . import commands, compare, dependence, draws, files, laws, masters, mended, route, starts
from . import plan as plans
from .__main__ import main
from .exactness import Exactness
from .findings import Count
from .generator import LONG_RUN, draw
from .interpreter import Interpreter
from .verdicts import Verdict, judge
from .ways import LEAVING, Libraries, Way, model_of, run, scene_of

# a pendulum on a sledge, hung by a ball joint; all that acts is in it
DATA = {
    "name": "sledge", "gravity": [0.0, 0.3, -9.81],
    "body": {
        "sledge": {"mass": 3.0, "com": [0.0, 0.0, 0.1], "inertia": [0.1, 0.2, 0.3]},
        "bob": {"mass": 2.0, "com": [0.1, 0.0, -0.5], "inertia": [0.1, 0.1, 0.02]},
    },
    "joint": {
        "slide": {
            "prismatic": {"axis": "x"}, "between": ["ground", "sledge"], "start": {"position": 0.2, "speed": 0.5},
            "spring": {"stiffness": 30.0}, "damper": 2.0, "input": "force",
        },
        "ball": {"spherical": {}, "between": ["sledge", "bob"], "start": {"zyx_deg": [10.0, 20.0, 30.0], "omega": [0.5, -1.0, 2.0]}},
    },
}  # fmt: skip
SEED = 3


@pytest.fixture(scope="module")
def interpreter():
    with Interpreter() as it:
        yield it


@pytest.fixture(scope="module")
def plan():
    return plans.draw(SEED, model_of(DATA, Way()), until=0.6)


@pytest.fixture(scope="module")
def ways(plan):
    return draws.draw(SEED, plan)


@pytest.fixture(scope="module")
def reference(plan, ways):
    model = model_of(DATA, Way())
    units = {v.name: v.unit for v in model.of_causality("output")}
    return compare.Reference(
        run(DATA, plan, ways.reference), [run(DATA, plan, way) for way in ways.kicked], units, Exactness()
    )


@pytest.fixture
def good(plan):
    """A run in which nothing is wrong, to break."""
    return run(DATA, plan, Way(tolerance=1e-7))


@pytest.fixture(scope="module")
def fine(plan, ways):
    return run(DATA, plan, ways.integrals)


def broken(result, name, row, change):
    """The run with another value of an output in a row."""
    values = [row.copy() for row in result.values]
    column = result.names.index(name)
    values[row][column] = change(values[row][column])
    return replace(result, values=values)


# random scenes


@pytest.mark.parametrize("seed", range(3))
def test_random_scenes_stand(seed, interpreter):
    verdict = judge(
        draw(seed, size=1 + seed % 4), seed, interpreter if seed % 4 == 0 else None, fmu=seed % 2 == 0, n=2
    )
    assert verdict.findings == []


@pytest.mark.parametrize("path", mended.CORPUS, ids=lambda path: path.stem)
def test_what_was_mended_stays_so(path):
    """A mending that is undone is found here, or by the tests in `mended.BESIDE`."""
    data, wanted = mended.read(path)
    assert mended.findings(data, wanted, lambda *arguments, **more: judge(*arguments, n=2, **more)) == []


def test_every_mending_is_watched():
    watched = {name for path in mended.CORPUS for name in mended.read(path)[1]["undone"]}
    beside, elsewhere = set(mended.BESIDE), set(mended.ELSEWHERE)
    assert watched | beside | elsewhere == {undone.name for undone in UNDONE}
    assert not watched & beside and not watched & elsewhere and not beside & elsewhere
    assert set(mended.BESIDE.values()) <= set(globals())


@pytest.mark.parametrize(
    "change, verdict",
    [
        ({"told": ["never said"]}, "not told"), ({"untold": ["is odd"]}, "told"), ({"start": {"x": 2.0}}, "start"),
        ({"refused": True}, "refused"),
    ],
)  # fmt: skip
def test_what_must_come_of_a_scene(change, verdict):
    def judged(data, seed, until, signals):
        return Verdict(seed, told=["it is odd"], first={"x": 1.0})

    wanted = {"seed": 1, "until": 1.0, "told": ["odd$"], "untold": ["even"], "start": {"x": 1.0}}
    assert mended.findings(DATA, wanted, judged) == []
    assert [finding.verdict for finding in mended.findings(DATA, wanted | change, judged)] == [verdict]


@pytest.mark.skipif(INTERPRETED, reason="takes minutes with interpreted kernels")
@pytest.mark.parametrize("seed", range(2000, 2024))
def test_small_random_scenes_stand(seed):
    """Three bodies or so, in all ways but interpreted: about 2.5 s each."""
    assert judge(draw(seed, size=3), seed).findings == []


@pytest.mark.long
@pytest.mark.parametrize("focus, seeds", LONG_RUN.items())
def test_two_thousand_scenes(focus, seeds, tmp_path_factory):
    """Goes on where it was stopped: lines of verdicts stand in referee/ in the working folder."""
    more = [] if focus is None else ["--focus", focus]
    some = ["--seed", str(seeds[0]), "--scenes", str(len(seeds))]
    assert main([*some, "--out", "referee", "--resume", "referee.jsonl", *more]) == 0


# ways against each other


def test_what_is_right_is_not_found(good, reference, plan, interpreter):
    count = Count()
    assert compare.near(reference, good, count) == []
    assert count.made > 100 and count.loose == 0
    assert compare.same(run(DATA, plan, good.way), good, "again") == []
    assert compare.near(reference, interpreter.run(DATA, plan, good.way), count, twin=good) == []


@pytest.mark.parametrize(
    "name", ["bob.position[1]", "slide.speed", "bob.alpha[2]", "ball.reaction_force[3]", "total_energy"]
)
@pytest.mark.parametrize("row", [5, -1])
def test_one_value_that_is_off(good, reference, name, row):
    off = broken(good, name, row, lambda x: x + 0.1)
    (finding,) = compare.near(reference, off, Count())
    assert finding.variable == name and finding.time == good.times[row]
    assert re.search(rf"{re.escape(name)} at .* s is .* must be", str(finding))
    assert compare.near(reference, broken(good, name, row, lambda x: np.nan), Count())


@pytest.mark.parametrize("memory", ["restore", "serialise", "reset", "second", "teased"])
def test_one_bit_that_is_off(good, plan, memory):
    other = run(DATA, plan, replace(good.way, memory=memory))
    assert compare.same(other, good, "") == []
    (finding,) = compare.same(broken(other, "slide.speed", 7, lambda x: np.nextafter(x, 9.0)), good, "")
    assert finding.variable == "slide.speed"
    assert compare.same(replace(other, values=other.values[:-1]), good, "")


@pytest.mark.skipif(INTERPRETED, reason="an FMU is compiled")
@pytest.mark.parametrize("memory", [None, "restore", "serialise", "reset", "second"])
def test_the_fmu_is_the_same_to_the_bit(good, plan, memory):
    with Libraries() as libraries:
        other = run(DATA, plan, replace(good.way, host="fmu", memory=memory), libraries)

    assert compare.same(other, good, "") == []
    assert starts.alike(good, other) == []
    assert len(starts.alike(replace(good, notices=["a notice (time 0.1 s)"]), other)) == 1


def test_a_fixed_step_is_held_to_its_own_error(reference, plan):
    way = Way(integrator="rk4", step=2e-3)
    coarse, *half = (run(DATA, plan, replace(way, step=step)) for step in (2e-3, 1e-3, 5e-4))
    assert compare.near(reference, coarse, Count(), half) == []
    assert compare.near(reference, broken(coarse, "bob.position[3]", -1, lambda x: x + 1e-5), Count(), half)


# laws


@pytest.mark.parametrize(
    "verdict, name, change",
    [
        ("not finite", "slide.speed", lambda x: np.nan),
        ("orientation", "ball.euler_parameters[2]", lambda x: x + 1e-6),
        ("constraint", "constraint_gap", lambda x: 1e-5),
        ("constraint", "constraint_rate", lambda x: 1e-3),
    ],
)
def test_laws_of_any_run(good, verdict, name, change):
    assert laws.always(good, DATA) == []
    assert [finding.verdict for finding in laws.always(broken(good, name, 4, change), DATA)] == [verdict]


@pytest.mark.parametrize("text", ["", "failure 77 at ?"])
def test_a_run_that_does_not_tell_why_it_stopped(good, text):
    assert laws.always(replace(good, stopped="the inner step became too small"), DATA) == []
    assert laws.always(replace(good, stopped=text), DATA)[0].verdict == "not told"
    assert laws.always(replace(good, crashed="KeyError"), DATA)[0].verdict == "crash"


def test_a_step_that_costs_too_much(good):
    found = laws.always(replace(good, most=1e5), DATA)
    assert [finding.verdict for finding in found] == ["work"]


def test_energy_and_momentum(fine, reference, plan):
    scene = Scene.model_validate(DATA)
    masses = laws.mass_and_gravity(scene, plan)

    def balances(result):
        integrals = laws.Integrals(result)
        found = laws.energy(integrals, reference, Count()) + laws.momentum(
            integrals, reference, Count(), *masses
        )
        return [finding.variable for finding in found]

    assert balances(fine) == []
    assert balances(broken(fine, "total_energy", -1, lambda x: x + 1e-5)) == ["total_energy"]
    assert balances(broken(fine, "linear_momentum[2]", -1, lambda x: x + 1e-5)) == ["linear_momentum"]
    assert balances(broken(fine, "angular_momentum[1]", -1, lambda x: x + 1e-5)) == ["angular_momentum"]

    swapped = replace(fine, values=[row.copy() for row in fine.values])
    column = fine.names.index("dissipated_power")

    for row in swapped.values:
        row[column] *= -1.0

    assert balances(swapped) == ["total_energy"]


def test_a_coordinate_that_loses_a_turn(fine):
    assert laws.courses(laws.Integrals(fine), Count()) == []
    lost = broken(fine, "slide.position", -1, lambda x: x + 2 * np.pi)
    assert [finding.variable for finding in laws.courses(laws.Integrals(lost), Count())] == ["slide.position"]


# starts, notices, files


@pytest.mark.parametrize(
    "name", ["slide.position", "slide.speed", "ball.euler_parameters[1]", "ball.omega[3]"]
)
def test_a_start_that_was_moved_untold(good, name):
    assert starts.kept(DATA, good) == []
    moved = broken(good, name, 0, lambda x: x + 1e-5)
    (finding,) = starts.kept(DATA, moved)
    assert finding.variable == name.partition("[")[0]
    joint = name.partition(".")[0]
    assert (
        starts.kept(DATA, replace(moved, notices=[f"the speed of {joint} at the start is given as …"])) == []
    )


@pytest.mark.parametrize(
    "table",
    [
        {"zyx_deg": [10.0, 20.0, 30.0]}, {"zyx_rad": [0.1, 0.2, 0.3]}, {"euler_parameters": [0.1, -0.1, 0.7, -0.7]},
        {"axis_angle": {"axis": [1, 2, 3], "angle_deg": 70.0}}, {"axis_angle": {"axis": "-y", "angle_rad": 1.0}},
        {"axes": {"x": [1, 1, 0], "z": "z"}}, {"axes": {"z": [1, 2, 3], "y": "-x"}},
    ],
)  # fmt: skip
def test_orientations_as_they_are_written(table):
    """As the schema reads them."""
    marker = Scene.model_validate(DATA | {"ground": {"marker": {"m": table}}}).ground.marker["m"]
    E = starts.orientation(table)
    x, y, z, w = E
    turned = 2 * np.outer(E[:3], E[:3]) + (w * w - E[:3] @ E[:3]) * np.eye(3)
    turned += 2 * w * np.array([[0, -z, y], [z, 0, -x], [-y, x, 0]])
    np.testing.assert_allclose(turned, marker.pose()[1], atol=1e-14)


def test_check_tells_what_a_run_tells(tmp_path, monkeypatch):
    scene, path = Scene.model_validate(DATA), tmp_path / "sledge.toml"
    assert starts.checked(scene, path) == []
    monkeypatch.setattr(starts, "Instance", lambda model: SimpleNamespace(notices=["the mass is odd"]))
    assert len(starts.checked(scene, path)) == 1
    monkeypatch.setattr(starts, "main", lambda arguments: 1)
    assert starts.checked(scene, path)[0].verdict == "check"


def test_a_scene_that_is_not_written_as_it_is(monkeypatch):
    assert starts.written(DATA) == []
    whole = Scene.to_toml
    monkeypatch.setattr(Scene, "to_toml", lambda scene: whole(scene).replace("damper", "# damper"))
    assert len(starts.written(DATA)) == 1


@pytest.mark.skipif(os.name == "nt", reason="links and pipes of Unix")
def test_what_users_do_with_files(tmp_path):
    assert files.used(Scene.model_validate(DATA | {"output": ["total_energy"]}), tmp_path) == []


@pytest.mark.skipif(os.name == "nt", reason="links and pipes of Unix")
@pytest.mark.parametrize("status", [0, 1])
def test_commands_that_treat_files_otherwise(tmp_path, monkeypatch, status):
    """That do nothing, or write nothing but promise to."""
    monkeypatch.setattr(files, "main", lambda arguments: status)
    monkeypatch.setattr(files, "WAITS", 0.01)
    (tmp_path / "table.csv").write_text("time\n0\n")
    text = " ".join(finding.text for finding in files.used(Scene.model_validate(DATA), tmp_path))
    words = ("number of lines", "arm.xml") + (
        ("written over", "table.png", "link points", "out of a pipe") if status == 0 else ("into a pipe",)
    )
    assert all(word in text for word in words)


# a master that misbehaves


@pytest.mark.parametrize(
    "method, change, words",
    [
        ("step", lambda whole: lambda self, H: None, ["a step of -0.001 s is taken"]),
        (
            "prepare",
            lambda whole: lambda self: None,
            ["solver.tolerance = 0.5 is taken", "sledge.com[1] = 1e+200 is taken"],
        ),
        (
            "outputs",
            lambda whole: lambda self: 1.0 * self.u,
            ["outputs with slide.force = nan are not finite"],
        ),
    ],
)
def test_an_instance_that_takes_all(monkeypatch, method, change, words):
    instance = Instance(model_of(DATA, Way()))
    assert masters.tease(instance) == []
    monkeypatch.setattr(Instance, method, change(getattr(Instance, method)))
    text = " ".join(masters.tease(instance))
    assert all(word in text for word in words)


def test_what_is_odd_on_the_way_is_found(good):
    assert [
        finding.verdict for finding in laws.always(replace(good, odd=["a step is taken back"]), DATA)
    ] == ["odd"]


def test_a_parameter_that_is_set_to_what_it_is(plan):
    """Changes nothing, not even what an implicit method keeps of its last steps."""
    way = Way(integrator="radau", tolerance=1e-5, pattern=("equal", 3))
    assert compare.same(run(DATA, plan, replace(way, memory="untouched")), run(DATA, plan, way), "") == []


# what is read off between inner steps


@pytest.mark.parametrize(
    "amplitude, tolerance, until, points, steps",
    [
        (1.9, 6e-8, 3.0, 10, 5),
        (1.8, 1e-7, 2.0, 10, 3),
        (1.5, 2e-8, 3.0, 8, 5),
        (1.8, 4e-9, 2.0, 8, 5),
        (1.9, 2e-9, 2.0, 10, 3),
    ],
)
def test_a_wheel_taken_along_by_a_one_way_clutch(amplitude, tolerance, until, points, steps):
    """It takes the shaft's peak speed at once and keeps it, at every communication point: the kink of the clutch lies between
    two of them."""
    peak, body = 2 * np.pi * amplitude, {"mass": 1.0, "inertia": [0.01, 0.01, 0.01]}
    swing = {"harmonic": {"amplitude": amplitude, "frequency": 1.0}}
    one_way = {"table": {"speed": [-10, -0.01, 0, 0.01, 10], "effort": [-1000, -1, 0, 0, 0]}}
    clutch = {"revolute": {}, "between": ["shaft", "wheel"], "start": {"speed": -peak}, "damper": one_way}
    drive = {"revolute": {}, "between": ["ground", "shaft"], "driver": swing}
    data = {
        "name": "clutch",
        "gravity": [0, 0, 0],
        "body": {"shaft": body, "wheel": body},
        "joint": {"drive": drive, "clutch": clutch},
    }
    plan = plans.Plan(np.linspace(0.0, until, points + 1), {})
    found = run(data, plan, Way(integrator="rk853", tolerance=tolerance, pattern=("equal", steps)))
    speeds = np.array(found.values)[np.array(found.times) > 0.3, found.names.index("wheel.omega[3]")]
    assert np.abs(speeds - peak).max() < 2e-4 * peak


@pytest.mark.parametrize("integrator", ["rk853", "rk54"])
@pytest.mark.parametrize("tolerance", [1e-5, 1e-6, 1e-8, 1e-10])
def test_the_true_error_is_no_more_than_the_sum_of_estimates(integrator, tolerance):
    """Of an oscillation, whose errors do not grow, at every communication point."""
    slide = {
        "prismatic": {},
        "between": ["ground", "a"],
        "start": {"position": 1.0, "speed": 0.3},
        "spring": {"stiffness": 1.0},
    }
    body = {"mass": 1.0, "inertia": [0.1, 0.1, 0.1]}
    data = {
        "name": "o",
        "gravity": [0, 0, 0],
        "body": {"a": body},
        "joint": {"j": slide},
        "solver": {"output": ["estimated_error"]},
    }
    plan = plans.Plan(np.linspace(0.0, 6.0, 7), {})
    found = run(data, plan, Way(integrator=integrator, tolerance=tolerance, pattern=("equal", 40)))
    told = dict(zip(found.names, np.array(found.values).T))
    t, off = np.array(found.times), []

    for name, a, b in (("j.position", 1.0, 0.3), ("j.speed", 0.3, -1.0)):
        right = a * np.cos(t) + b * np.sin(t)
        off.append((told[name] - right) / (1.0 + np.abs(right)))

    assert np.all(np.sqrt(np.mean(np.square(off), axis=0)) <= 1.3 * told["solver.estimated_error"] + 1e-15)


# commanded motion

GROUND = {
    "name": "over a ground",
    "gravity": [0.0, 0.0, 0.0],
    "ground": {"motion": {"input": ["position", "velocity"]}},
}
GROUND |= {"body": {"p": {"mass": 1.0, "inertia": [1, 1, 1]}, "s": {"mass": 1.0, "inertia": [1, 1, 1]}}}
GROUND["joint"] = {
    "t": {"free": {}, "between": ["ground", "p"], "start": {"velocity": [0.1, 0.2, 0.3]}},
    "j": {"prismatic": {}, "between": ["ground", "s"], "driver": {"input": ["position"]}},
}


def test_commands_are_met_and_nothing_jumps():
    """Cubics told by their values alone."""
    cubics = {f"ground.position[{k}]": [0.0, 0.3, -0.5 * k, 0.4] for k in (1, 2, 3)}
    cubics |= {f"ground.velocity[{k}]": [0.3, -1.0 * k, 1.2] for k in (1, 2, 3)}
    cubics["j.position_command"] = [0.0, -0.2, 0.7, 0.6]
    plan = plans.draw(SEED, model_of(GROUND, Way()), until=1.0).under(cubics)
    found = run(GROUND, plan, Way(pattern=("equal", 3)))
    assert commands.met(plan, found) == commands.straight(GROUND, plan, found) == []
    (finding,) = commands.met(plan, broken(found, "j.position", -1, lambda x: x + 1e-6))
    assert finding.variable == "j.position"
    (finding,) = commands.straight(GROUND, plan, broken(found, "p.position[2]", -1, lambda x: x + 1e-6))
    assert finding.variable == "p.position[2]"


# what a model says of itself


def test_a_dependence_that_is_not_declared():
    model = model_of(DATA, Way())
    instance = Instance(model)
    assert dependence.observed(model, instance, "") == []
    silent = replace(
        model,
        variables=[replace(v, depends=()) if v.name == "slide.acceleration" else v for v in model.variables],
    )
    (finding,) = dependence.observed(silent, instance, "")
    assert finding.variable == "slide.acceleration"


@pytest.mark.parametrize(
    "old, new",
    [
        (b'<Real declaredType="Acceleration" unit="m/s2"', b'<Real declaredType="Acceleration" unit="m/s"'),
        (b'name="slide.speed"', b'name="slide.rate"'),
        (b'dependencies="190 191', b'dependencies="191'),
        (b'<Unknown index="4"/>', b'<Unknown index="4" dependencies="190 191"/>'),
        (b'<Unknown index="2" dependencies="190 191 192 193 194 195 196 197 198"/>', b'<Unknown index="2"/>'),
    ],
)
def test_a_description_that_is_not_the_models(monkeypatch, old, new):
    model = model_of(DATA, Way())
    whole = dependence.description
    assert dependence.told(model) == []
    assert old in whole(model)
    monkeypatch.setattr(dependence, "description", lambda model: whole(model).replace(old, new, 1))
    assert dependence.told(model)


# the second route


@pytest.mark.parametrize(
    "name", ["bob.acceleration[1]", "ball.reaction_moment_body[2]", "slide.spring_effort", "kinetic_energy"]
)
def test_what_the_second_route_tells_otherwise(good, plan, name):
    assert route.agrees(DATA, plan, good, Exactness(), Count()) == []
    row = next(k for k, phase in enumerate(good.phases) if phase == LEAVING and good.times[k] > 0)
    (finding,) = route.agrees(DATA, plan, broken(good, name, row, lambda x: x + 1e-4), Exactness(), Count())
    assert finding.variable == name.partition("[")[0]


# plans


def test_a_scene_that_loses_a_part_keeps_its_plan(plan):
    smaller = DATA | {"joint": DATA["joint"] | {"ball": {"fixed": {}, "between": ["sledge", "bob"]}}}
    other = plans.draw(SEED, compile_scene(scene_of(smaller, Way())), until=0.6)
    np.testing.assert_array_equal(other.points, plan.points)
    np.testing.assert_array_equal(other.inputs(0.1, 0), plan.inputs(0.1, 0))
    assert any(way.host == "fmu" for way, _ in draws.draw(SEED, plan).bits) != INTERPRETED


@pytest.mark.parametrize("wave", [0, 1, 2])
def test_signals_and_their_derivatives(wave):
    """Each is the rate of the one before."""
    signal = plans.Signal(np.array([0.0]), np.array([[0.3, -1.2, 0.7, 0.4, -0.2, 0.1]]), wave=wave)
    h = 1e-3

    for k in range(5):
        values = [signal.at(0.4 + j * h, 0)[k] for j in (-2, -1, 1, 2)]
        assert signal.at(0.4, 0)[k + 1] == pytest.approx(np.dot([1, -8, 8, -1], values) / (12 * h), abs=1e-9)

    assert signal.value(0.4, 0) == pytest.approx(signal.at(0.4, 0)[0], rel=1e-14)


@pytest.mark.parametrize(
    "pattern",
    [("shared",), ("equal", 3), ("unequal", 4), ("tiny", 2), ("union", (("equal", 3), ("tiny", 2)))],
)
def test_communication_steps_meet_the_shared_points(plan, pattern):
    steps = plans.pieces(plan, pattern)
    np.testing.assert_allclose(np.cumsum([sum(own) for own in steps]), plan.points[1:], rtol=1e-12)
    assert all(H > 0 for own in steps for H in own)


def test_commands_of_one_motion_belong_together():
    """The speed's course is the position's derivative, the acceleration's the speed's."""
    driven = {"name": "d", "body": {"b": {"mass": 1.0, "inertia": [1, 1, 1]}}}
    driven["joint"] = {
        "j": {"revolute": {}, "between": ["ground", "b"], "driver": {"input": True}, "start": {"angle": 0.7}}
    }
    driven["ground"] = {"motion": {"input": ["position", "velocity", "euler_parameters", "omega"]}}

    for seed in range(8):
        values = plans.draw(seed, compile_scene(Scene.model_validate(driven))).values(0.1, 0)
        bare = values["j.speed_command"][1] == 0.0 and values["j.angle_command"][1] == 0.0

        if not bare:
            assert values["j.angle_command"][1] == pytest.approx(values["j.speed_command"][0])
            assert values["j.speed_command"][1] == pytest.approx(values["j.acceleration_command"][0])
            assert values["ground.position[2]"][1] == pytest.approx(values["ground.velocity[2]"][0])
            E = [values[f"ground.euler_parameters[{k}]"] for k in (1, 2, 3, 4)]
            assert 2 * (E[3][0] * E[2][1] - E[2][0] * E[3][1]) == pytest.approx(values["ground.omega[3]"][0])
