"""What can be asked of the runs of a scene, and what is done to it, so that nothing is compared that is not determined."""

from dataclasses import replace
from types import SimpleNamespace

import numpy as np
import pytest

from mbdfmi import Scene
from mbdfmi.compiler.model import compile_scene

from . import compare, exactness, laws, starts, verdicts
from . import plan as plans
from .exactness import Exactness
from .findings import Count, Finding
from .telling import all_told
from .verdicts import judge
from .ways import Run, Way, model_of

BALL = {"mass": 2.0, "com": [0.1, 0.0, -0.5], "inertia": [0.1, 0.4, 0.5]}
HUNG = {
    "name": "hung", "body": {"ball": BALL}, "ground": {"motion": {"input": ["position"]}},
    "joint": {"ball": {"spherical": {}, "between": ["ground", "ball"], "start": {"zyx_deg": [10.0, 20.0, 30.0]}}},
}  # fmt: skip


def plan_of(pattern=("tiny", 2), signals=("ground.position[1]",)):
    return plans.Plan(np.array([0.0, 0.1, 0.4]), dict.fromkeys(signals)), SimpleNamespace(
        way=Way(pattern=pattern)
    )


def told(names, rows, times=None):
    """A run in which these outputs had these values."""
    times = list(range(len(rows))) if times is None else times
    return Run(Way(plain=True), list(names), times, [1] * len(rows), [np.array(row, float) for row in rows])


# rounding


def test_short_steps_make_rounding_of_commands_large():
    assert exactness._carried(*plan_of()) == pytest.approx(exactness.EPS * (0.3 / 1e-5) ** 2, rel=0.01)
    assert exactness._carried(*plan_of(signals=("ball.force[1]",))) == 0.0


def test_accelerations_are_as_good_as_forces_over_inertias():
    body = {"ball": BALL, "speck": BALL | {"mass": 0.01}}
    joint = {name: {"free": {}, "between": ["ground", name]} for name in body}
    scene = Scene.model_validate({"name": "x", "body": body, "joint": joint})
    assert exactness._lightest(scene) == pytest.approx((0.01, 0.1))
    units = {"ball.force": "N", "ball.acceleration": "m/s2", "ball.position": "m"}
    run = told(units, [[50.0, 0.0, 0.0]])
    reference = compare.Reference(run, [run], units, Exactness(lightest=(0.01, 0.1)))
    assert reference.rounding["ball.acceleration"] == pytest.approx(compare.ULPS * 5000.0, rel=0.5)
    assert reference.rounding["ball.position"] < compare.ULPS * 50.0


def test_two_points_that_are_equal_stand_still_in_smooth_tables_alone():
    def jumps(how):
        table = {"time": [0.1, 0.2, 0.3], "position": [1.0, 1.0, 1.0], "interpolation": how}
        table["position"][2] = 2.0
        return laws.jumps({"joint": {"slide": {"driver": {"table": table}}}})

    assert jumps("smooth") == {0.3}
    assert jumps("cubic") == {0.1, 0.3}
    assert jumps("linear") == {0.1, 0.2, 0.3}


def test_energy_may_jump_where_a_frame_passes_the_end_of_its_curve():
    points = [[0.0, 0.0], [1.0, 0.3], [2.0, 0.2], [3.0, 0.9]]

    def edges(kind, shape):
        joint = {
            "free": {"free": {}, "between": ["ground", "b"]},
            "on": {kind: {}, "between": ["ground.m", "b"]},
        }
        data = {
            "name": "x",
            "body": {"b": {"mass": 1.0, "inertia": [1, 1, 1]}},
            "joint": joint,
            "ground": {"marker": {"m": shape}},
        }
        return laws.edges(Scene.model_validate(data))

    curve = {"spline": {"points": points, "s": [-1.0, 0.0, 1.0, 2.0]}}
    assert edges("frame_on_curve", {"curve": curve}) == [("on.s", 0, -1.0), ("on.s", 0, 2.0)]
    assert edges("frame_on_curve", {"curve": {"spline": {"points": points, "closed": True}}}) == []
    assert edges("frame_on_curve", {"curve": {"circle": {"radius": 1.0}}}) == []
    assert edges("point_on_curve", {"curve": curve}) == []
    assert len(edges("frame_on_surface", {"surface": {"prism": {"profile": curve}}})) == 2
    grid = [[[x, y, x * x * y] for y in range(4)] for x in range(4)]
    table = {"s1": [0, 1, 2, 3], "s2": [0, 1, 2, 4], "points": grid}
    assert edges("frame_on_surface", {"surface": {"table": table}})[2:] == [
        ("on.s", 1, 0),
        ("on.s", 1, 4),
    ]

    # only the interval in which it does so
    rows = [[s, 1.0] for s in (1.0, 1.5, 1.9, 1.9, 2.1, 2.5)]
    run = SimpleNamespace(
        names=["on.s", "y"], values=rows, times=[0.0, 0.1, 0.2, 0.2, 0.3, 0.4], phases=[0, 0, 0, 1, 0, 0]
    )
    found = laws.Integrals(run, 2, edges=[("on.s", 0, 2.0)])
    found.begins, found.ends = np.array([0, 3]), np.array([2, 5])
    assert [found.is_broken(k) for k in range(2)] == [False, True]


# what is not determined


@pytest.mark.parametrize("kind, until", [("bushing", 2.0), ("linear", 2.0), ("load", np.inf)])
def test_half_a_turn_of_a_bushing_has_no_direction(kind, until):
    names = [f"mount.rotation[{k}]" for k in (1, 2, 3)]
    run = told(names, [[0.0, 0.1, 3.14], [2.0, 2.0, 0.0], [3.0, 0.932, 0.0]])
    assert exactness._until({"force": {"mount": {kind: {}}}}, run) == until


def test_a_name_of_two_parts_means_one_of_them_among_own_outputs():
    assert exactness._shared({"body": {"α1": {}, "b": {}}, "joint": {"α1": {}, "c": {}}}) == {"'(U+03B1)1'"}
    units = {"a.omega": "rad/s"}
    reference = compare.Reference(told(units, [[1.0]]), [told(units, [[1.0]])], units, Exactness())
    shared = compare.Reference(told(units, [[1.0]]), [told(units, [[1.0]])], units, Exactness(shared={"a"}))
    assert len(compare.near(reference, told(units, [[2.0]]), Count())) == 1
    assert compare.near(shared, told(units, [[2.0]]), Count()) == []


def test_starts_that_are_moved_elsewhere():
    def notices(x):
        text = (
            f"the angle of arm at the start is given as -0.2, but taken as {x}: loops leave it nothing else"
        )
        return SimpleNamespace(notices=[text, "and 3 more of this kind"])

    assert (
        starts.moved(notices(-0.4567891))
        == starts.moved(notices(-0.4567899))
        == {"the angle of arm": ["-0.457"]}
    )
    assert starts.moved(notices(-0.4)) != starts.moved(notices(-0.5))


@pytest.mark.parametrize("more, n", [(0, 1), (1, 0), (3, 0)])
def test_of_many_starts_only_the_first_are_told(more, n):
    data = {"body": {}, "joint": {"arm": {"revolute": {}, "start": {"angle": 0.2}}}}
    run = told(["arm.angle"], [[0.3]])
    run.notices = [f"and {more} more of this kind"] if more else []
    assert len(starts.kept(data, run)) == n


# what is done to a scene


def test_one_pattern_alone_is_that_pattern_to_the_bit():
    plan, _ = plan_of()
    assert plans.pieces(plan, ("union", (("tiny", 2),))) == plans.pieces(plan, ("tiny", 2))


def test_rest_lengths_left_to_the_start_are_left_alone():
    strut = {"spring_damper": {"stiffness": 3.0}, "between": ["ground", "ball.end"]}
    ball = BALL | {"marker": {"end": {"position": [0.0, 0.0, -1.0]}}}
    model = compile_scene(Scene.model_validate(HUNG | {"body": {"ball": ball}, "force": {"rope": strut}}))
    again = {name for seed in range(40) for at in plans.draw(seed, model).settings.values() for name in at}
    starts_at = {v.name: v.start for v in model.of_causality("parameter")}
    assert "rope.rest_length" in starts_at and "ball.mass" in again
    values = {
        at.get("rope.rest_length") for seed in range(40) for at in plans.draw(seed, model).settings.values()
    }
    assert starts_at["rope.rest_length"] not in values


def test_the_second_route_sees_a_ground_of_which_inputs_tell_little():
    names = [v.name for v in model_of(HUNG, Way()).of_causality("output")]
    assert "ground_seen.acceleration[3]" in names
    assert "measure" not in HUNG and "ground_seen_x" in all_told(HUNG)["measure"]
    bare = next(seed for seed in range(100) if plans.dice(seed, "bare").random() < 0.25)
    verdict = judge(HUNG, bare, until=0.2)
    assert verdict.findings == []


@pytest.mark.parametrize("names, unknown", [
    (["arm.angle_command"], True), (["arm.angle_command", "arm.speed_command"], False),
    (["ground.position[1]", "ground.omega[1]"], True), (["ground.velocity[1]", "ground.zyx[1]"], True), (["arm.torque"], False),
])  # fmt: skip
def test_speeds_of_which_nothing_is_told(names, unknown):
    for told_too in (False, True):
        signal = SimpleNamespace(told=told_too)
        plan = plans.Plan(np.array([0.0, 1.0]), dict.fromkeys(names, signal))
        assert plans.speeds_unknown(plan) == (unknown and not told_too)


def test_what_is_a_little_off_must_be_less_so_with_a_smaller_tolerance(monkeypatch):
    def converges(off, beyond, way):
        def once(data, plan, other):
            assert other in (replace(way, tolerance=1e-8), replace(way, step=0.01))
            return told(["arm.angle"], [[1.0 + off]])

        monkeypatch.setattr(verdicts, "run", once)
        finding = Finding("ways part", str(way), "arm.angle", 0, 1.1, 1.0, 0.01, beyond=beyond)
        return verdicts._converges({}, None, way, finding, Count())

    for way in (Way(tolerance=1e-6), Way(integrator="rk4", step=0.04)):
        assert converges(0.001, 10.0, way)
        assert not converges(0.05, 10.0, way)
        assert not converges(0.001, 1e4, way)


def test_a_stop_tells_nothing_where_the_motion_is_wild():
    units = {"arm.angle": "rad", "arm.power": "W"}
    far, kicked = (told(units, [[1.0, 0.0], [1.0, 0.0], [x, 0.0]]) for x in (2.0, 2.5))
    reference = compare.Reference(far, [kicked], units, Exactness())
    other = told(units, [[1.0, 0.0], [1.0, 0.0], [1.5, 300.0]])
    sooner = told(units, [[1.0, 9.0], [1.0, 0.0], [2.0, 0.0]])
    assert len(compare.near(reference, other, Count())) == 1
    assert compare.near(reference, other, Count(), kinked=True) == []
    assert len(compare.near(reference, sooner, Count(), kinked=True)) == 1
