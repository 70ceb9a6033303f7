"""The report of speed against error: its problems, that all contestants run the same physics, and that it is
written whole. No time is judged.
"""

import io
import json
from dataclasses import replace

import numpy as np
import pytest
from rich.console import Console

from benchmarks import __main__ as benchmarks
from benchmarks import contests, evaluation, speed_against_error
from benchmarks.contests import Cannot, Limits, Setting, contest, cpu_at, front_of
from benchmarks.native import Missing
from benchmarks.peers_by_hand import SYSTEMS, ByHand
from benchmarks.peers_exudyn import ExudynMotion
from benchmarks.peers_mujoco import MuJoCoMotion
from benchmarks.peers_pinocchio import PinocchioMotion
from benchmarks.problem_files import pose_of
from benchmarks.problems import PROBLEMS
from benchmarks.spanning import motion_of, spanning_tree, start_of
from benchmarks.steppers import STEPPERS
from mbdfmi.scene.fields import LEAST_TOLERANCE

problems = pytest.mark.parametrize("problem", PROBLEMS, ids=lambda problem: problem.name)
trees = [problem for problem in PROBLEMS if not problem.scene]


def stepper(name):
    return next(stepper for stepper in STEPPERS if stepper.name == name)


def short(problem, n=2):
    """The problem up to its n-th reference time."""
    return replace(problem, until=float(problem.times[min(n, len(problem.times)) - 1]))


# what our steppers reach in double precision, where that is less than nine digits: singular positions, an
# unstable axis
REACHED = {"A02_n_four_bar_N2": 1e-8, "dzhanibekov_jacobi": 1e-8}

# the tolerance below which steps would be as short as rounding asks for: positions of 60 m, whose last digit
# changes accelerations by 1e-8
TIGHT = {"scissor_lift_100": 1e-9}


@problems
def test_references_are_reproduced(problem, record_property):
    tolerance = TIGHT.get(problem.name, max(LEAST_TOLERANCE, 1e-13 * problem.sharper))
    tight = Setting("tight", {"tolerance": tolerance}, 0)
    _, table = stepper("rk853").prepare(problem, tight).run()
    error = problem.error(table)
    record_property("error", float(error))
    assert error < REACHED.get(problem.name, 1e-9)


@pytest.mark.parametrize("name", [stepper.name for stepper in STEPPERS])
def test_every_stepper_converges(name):
    known, missing = speed_against_error.known_steppers()

    if name in missing:
        pytest.skip(f"{name}: {missing[name]}")

    problem = next(problem for problem in PROBLEMS if problem.name == "double_pendulum_bars")
    problem = short(problem)
    settings = stepper(name).settings(problem)
    errors = [
        problem.error(stepper(name).prepare(problem, setting).run()[1])
        for setting in (settings[0], settings[3])
    ]
    assert len(settings) == 5
    assert errors[1] < 1e-2 * errors[0]


@pytest.mark.parametrize("problem", trees, ids=lambda problem: problem.name)
def test_a_spanning_tree_starts_as_the_file_says(problem):
    data = problem.data
    tree, loops = spanning_tree(data)
    assert len(tree) == len(data["bodies"])
    assert len(tree) + len(loops) == len(data["joints"]) + sum(joint.kind == "free" for joint in tree)
    table = motion_of(data, tree, *start_of(data, tree))

    for body, row in zip(data["bodies"], table):
        r, _ = pose_of(body)
        q = np.roll(body.get("q0", [1, 0, 0, 0]), -1)
        np.testing.assert_allclose(row[:3], r, atol=1e-14)
        np.testing.assert_allclose(row[3:7] * np.sign(row[3:7] @ q), q, atol=1e-14)
        np.testing.assert_allclose(row[10:], body.get("w0", [0, 0, 0]), atol=1e-14)

        if "v0" in body:
            np.testing.assert_allclose(row[7:10], body["v0"], atol=1e-14)


# how far a peer is from the reference after two of its times: less where constraints are soft, or the order
# is 2
NEAR = {"MuJoCo": 2e-4, "Exudyn": 2e-3, "Pinocchio": 1e-5}


@pytest.mark.parametrize("problem", trees, ids=lambda problem: problem.name)
@pytest.mark.parametrize(
    "peer, module",
    [
        (MuJoCoMotion, "mujoco"),
        (ExudynMotion, "exudyn"),
        pytest.param(PinocchioMotion, "pinocchio", marks=pytest.mark.long),
    ],
)
def test_peers_move_as_the_reference(peer, module, problem):
    pytest.importorskip(module)

    if problem.name == "A05_flyball_governor" and module == "mujoco":
        pytest.skip("stiff: needs steps too short for a test")

    problem = short(problem)
    errors = []

    for setting in peer().settings(problem):
        if setting.level in (1, 2):
            try:
                errors.append(problem.error(peer().prepare(problem, setting).run()[1]))
            except Cannot as why:
                reason = str(why)

    if not errors and module == "pinocchio":
        assert "loops" in reason or "loads" in reason
        return

    assert min(errors) < NEAR[peer.name]


@pytest.mark.parametrize("name", SYSTEMS)
def test_equations_by_hand_are_those_of_the_problem(name):
    problem = next(problem for problem in PROBLEMS if problem.name == name)
    problem = short(problem, 4)
    errors = [problem.error(ByHand().prepare(problem, s).run()[1]) for s in ByHand().settings(problem)]
    assert errors[-1] < 2e-10 and errors[1] > 100 * errors[-1]


@pytest.mark.parametrize("peer, module", [(MuJoCoMotion, "mujoco"), (ExudynMotion, "exudyn")])
def test_what_a_peer_cannot_is_told(peer, module):
    pytest.importorskip(module)
    problem = next(problem for problem in PROBLEMS if problem.name == "rolling_disk_thin")
    points = contest(problem, [peer()], Limits(rounds=1), lambda text: None)[peer.name]
    assert len(points) == 1
    assert points[0]["cpu_s"] is None and "rolling" in points[0]["reason"]


# contests


class Made:
    """A contestant whose runs take what its settings say: (CPU seconds, error as a shift of x, reason)."""

    name, how, kind = "made", "", "ours"

    def __init__(self, *plans):
        self.plans = plans
        self.runs = 0

    def settings(self, problem):
        return [Setting(f"setting {k}", {"plan": plan}, k) for k, plan in enumerate(self.plans)]

    def prepare(self, problem, setting):
        self.problem, self.plan = problem, setting.values["plan"]
        return MadeRun(problem, *self.plan)


class MadeRun:
    def __init__(self, problem, seconds, shift, reason=None):
        self.seconds, self.shift, self.reason = seconds, shift, reason
        self.table = np.zeros((len(problem.times), 1, 13))
        self.table[:, 0, 6] = 1.0
        self.table[:, 0, 0] = problem.data["column"]["x"] + shift * np.abs(problem.data["column"]["x"]).max()
        self.table[:, 0, 7] = problem.data["column"]["xd"]

    def run(self):
        if self.reason:
            raise Cannot(self.reason)

        return self.seconds, self.table


def bead():
    return next(problem for problem in PROBLEMS if problem.name == "bead_on_parabola")


def test_a_contest_takes_errors_times_and_reasons():
    made = Made((0.1, 1e-3), (0.2, 0.0, "it breaks"), (0.3, np.nan), (5.0, 1e-6), (9.0, 1e-9))
    points = contest(bead(), [made], Limits(rounds=3, longest=2.0, enough=0.25), lambda text: None)["made"]
    assert points[0]["error"] == pytest.approx(1e-3)
    assert points[0]["cpu_s"] == 0.1 and points[0]["rounds"] == 3
    assert points[1]["reason"] == "it breaks"
    assert "not finite" in points[2]["reason"]
    assert points[3]["rounds"] == 1
    assert points[4]["reason"] == "not run: setting 3 took 5.0 s"


def test_times_at_an_error_are_read_along_the_front():
    points = [{"cpu_s": s, "error": e} for s, e in ((1.0, 1e-4), (2.0, 1e-3), (10.0, 1e-8), (100.0, 1e-12))]
    points.append({"cpu_s": None, "error": None})
    assert [p["cpu_s"] for p in front_of(points[:4])] == [1.0, 10.0, 100.0]
    assert cpu_at(points, 1e-6) == pytest.approx(10**0.5)
    assert cpu_at(points, 1e-8) == pytest.approx(10.0)
    assert cpu_at(points, 1e-10) == pytest.approx(10**1.5)
    assert cpu_at(points, 1e-2) == 1.0
    assert cpu_at(points, 1e-13) is None
    assert cpu_at(points[4:], 1e-3) is None


def test_errors_forget_signs_of_quaternions_and_full_turns():
    tumbling = next(problem for problem in PROBLEMS if problem.name == "torque_free_axisymmetric")
    _, table = stepper("rk853").prepare(tumbling, Setting("", {"tolerance": 1e-12}, 0)).run()
    error = tumbling.error(table)
    table[::2, :, 3:7] *= -1
    assert tumbling.error(table) == error

    table[3, 0, 3] += 0.01
    assert tumbling.error(table) > 1e-3


# the report


def test_the_report_is_written_whole(monkeypatch, tmp_path):
    monkeypatch.setattr(evaluation, "QUICK_SIZES", (8, 16))
    monkeypatch.setattr(speed_against_error, "QUICK_PEERS", (Absent, ByHand))
    chosen = speed_against_error.chosen_problems(["double_pendulum_bars", "four_bar"], True)
    monkeypatch.setattr(speed_against_error, "chosen_problems", lambda names, quick: chosen)
    seen = []
    report = speed_against_error.run_report(True, progress=lambda done, text: seen.append(done))
    written = report.save(tmp_path)
    assert seen == sorted(seen) and seen[-1] == 1.0
    figures = json.loads((tmp_path / "speed_against_error.json").read_text())
    assert figures == json.loads(json.dumps(report.as_dict()))
    assert [row["name"] for row in figures["problems"]] == ["double_pendulum_bars", "four_bar"]
    assert figures["missing"]["absent"] == "not here (pip install absent)"

    for row in figures["problems"]:
        assert set(row["results"]) == set(figures["contestants"])
        assert all(
            point["cpu_s"] or point["reason"] for points in row["results"].values() for point in points
        )

    assert figures["at"]["1e-08"]["four_bar"]["rk853"] > 0
    standing = report.standing(1e-8, "four_bar")
    assert standing["limit"][0] == "by hand" and standing["peer"] is None and standing["limit_ratio"] > 0
    text = (tmp_path / "speed_against_error.md").read_text()

    for words in (
        "error of 1e-8",
        "Error against CPU time",
        "could not be run",
        "What an FMU adds",
        "reference digits",
    ):
        assert words in text

    for path in written:
        assert path.stat().st_size > 0

    for name in ("speed_against_error.png", "evaluation_cost.png"):
        assert (tmp_path / name in written) == (f"({name})" in text)

    console = Console(file=io.StringIO(), width=120)
    console.print(report)
    assert "four-bar" in console.file.getvalue() and "pip install absent" in console.file.getvalue()


class Absent:
    name, how, kind, preparing = "absent", "", "package", "looking for it"

    @classmethod
    def version(cls):
        raise Missing("not here (pip install absent)")


def test_an_unknown_problem_is_told_with_those_there_are():
    with pytest.raises(ValueError, match="no problem top; there are .*heavy_top_bruls"):
        speed_against_error.chosen_problems(["top"], quick=False)


def test_quick_ones_are_some_of_all():
    some = speed_against_error.chosen_problems([], quick=True)
    assert 0 < len(some) < len(PROBLEMS)
    assert len(speed_against_error.chosen_problems([], quick=False)) == len(PROBLEMS)
    assert set(contests.QUICK.levels) < set(range(5))


# the command line


def test_the_command_measures_one_problem(capsys, tmp_path):
    assert benchmarks.main(["--quick", "--problem", "double_pendulum_bars", "-o", str(tmp_path)]) == 0
    printed = capsys.readouterr().out
    assert "double pendulum" in printed and "bodies" not in printed  # nothing else is measured
    figures = json.loads((tmp_path / "speed_against_error.json").read_text())
    assert figures["problems"] and figures["evaluation"] is None
    assert "What an FMU adds" not in (tmp_path / "speed_against_error.md").read_text()


@pytest.mark.parametrize(
    "arguments, says",
    [
        (["--problem", "top"], ["no problem top", "heavy_top_bruls"]),
        (["--problem", "heavy_top_bruls", "--long-run"], ["leave out one of them"]),
    ],
)
def test_the_command_refuses_what_it_cannot_measure(capsys, tmp_path, arguments, says):
    assert benchmarks.main(["--quick", *arguments, "-o", str(tmp_path)]) == 1
    message = " ".join(capsys.readouterr().err.split())
    assert all(text in message for text in says)


def test_the_command_tells_its_arguments(capsys):
    with pytest.raises(SystemExit) as end:
        benchmarks.main(["--help"])

    assert end.value.code == 0
    assert "python -m benchmarks --quick" in capsys.readouterr().out
