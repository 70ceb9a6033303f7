"""Every stepper on one scene: the error told is the error, the best choice is the best, and the command says so."""

import csv
from dataclasses import replace

import numpy as np
import pytest

import mbdfmi
from mbdfmi import cli
from mbdfmi.analysis import comparison
from mbdfmi.analysis.comparison import Comparison, Run, Setting, compare_steppers, short
from mbdfmi.steppers import ADAPTIVE, FIXED_STEP

OMEGA = 3.0  # rad/s
START = 0.4  # m


def oscillator(stiffness=OMEGA**2, **more):
    """1 kg on a spring of 9 N/m: x = 0.4 m cos(3 t)."""
    tables = {
        "name": "oscillator",
        "gravity": [0, 0, 0],
        "body": {"a": {"mass": 1, "inertia": [0, 0, 0]}},
        "joint": {
            "j": {
                "prismatic": {},
                "between": ["ground", "a"],
                "spring": {"stiffness": stiffness},
                "start": {"position": START},
                "input": "force",
                "output": ["position", "speed"],
            }
        },
    }
    return mbdfmi.Scene(**(tables | more))


@pytest.fixture
def few(monkeypatch):
    """Few settings, so that interpreted kernels are quick."""
    monkeypatch.setattr(comparison, "TOLERANCES", (1e-4, 1e-7))
    monkeypatch.setattr(comparison, "PARTS", (1, 4))
    monkeypatch.setattr(comparison, "REFERENCE", (1e-12, 1e-11))


@pytest.fixture
def found(few):
    return compare_steppers(oscillator(), 2.0, 0.1)


def test_the_error_told_is_that_against_the_closed_form(found):
    """The same solver by `simulate`, against x = x0 cos(w t) and its speed, each by its size."""
    assert found.doubt < 1e-9
    assert {run.setting.integrator for run in found.done} == {*ADAPTIVE, *FIXED_STEP}
    assert all(run.reason == comparison.NEEDLESS for run in found.runs if run not in found.done)
    errors = []

    for run in found.done:
        solver = {"integrator": run.setting.integrator, run.setting.key: run.setting.value}
        results = oscillator(solver=solver).simulate(2.0, 0.1)
        t = results["time"]
        x, v = START * np.cos(OMEGA * t), -OMEGA * START * np.sin(OMEGA * t)
        true = max(
            abs(results["j.position"] - x).max() / abs(x).max(),
            abs(results["j.speed"] - v).max() / abs(v).max(),
        )
        assert run.error == pytest.approx(true, rel=1e-3, abs=5e-10), run.setting
        assert run.worst in ("j.position", "j.speed")
        assert run.evaluations > 0 and run.cpu > 0.0
        errors.append(true)

    assert max(errors) > 1e-3 and min(errors) < 1e-7


def test_the_scenes_own_solver_is_one_of_them(few):
    own = {"integrator": "rk4", "step": 0.05}
    found = compare_steppers(oscillator(solver=own), 1.0, 0.1, steppers=["rk54"])
    assert found.own.setting == Setting("rk4", 0.05)
    assert found.own in found.runs and len(found.runs) == 3


def test_inputs_and_parameters_count(few):
    """A constant force of k x0 holds the mass where it starts: nothing moves; so does a start at rest without a force."""
    held = [({"j.force": OMEGA**2 * START}, None), (None, {"j.position_start": 0.0})]

    for inputs, parameters in held:
        found = compare_steppers(oscillator(), 1.0, 0.1, inputs, parameters, steppers=["rk4"])
        assert all(run.error < 1e-12 for run in found.done)


@pytest.mark.parametrize(
    "arguments, says",
    [
        ({"parameters": {"solver.tolerance": 1e-3}}, "solver.tolerance is what is varied"),
        ({"steppers": ["rk45"]}, "no stepper 'rk45'; there are auto, rk54"),
        ({"until": -1.0}, "must end after it starts"),
        ({"inputs": {"j.force": [1.0, 2.0]}}, "needs a number"),
    ],
)
def test_what_cannot_be_compared(few, arguments, says):
    with pytest.raises(ValueError, match=says):
        compare_steppers(oscillator(), **({"until": 1.0} | arguments))


def test_a_scene_without_outputs_of_motion(few):
    scene = oscillator(joint={"j": {"prismatic": {}, "between": ["ground", "a"]}}, output=["constraint_gap"])

    with pytest.raises(ValueError, match="no outputs that could be compared; ask for some"):
        compare_steppers(scene, 1.0)


def test_what_fails_is_told(few, monkeypatch):
    """A spring so stiff that steps of rk4 blow up; the reference is not looked for."""
    zeros = np.zeros((201, 2))
    monkeypatch.setattr(comparison, "_reference", lambda trial: (Setting("auto", 1e-12), zeros, 0.0))
    found = compare_steppers(
        oscillator(1e12, solver={"integrator": "rk4", "step": 0.1}), 20.0, 0.1, steppers=["rk4"]
    )
    blown = [run for run in found.runs if run.setting.integrator == "rk4"]
    assert all("finite" in run.reason or "fast" in run.reason for run in blown), blown
    assert found.best(1e9, ["rk4"]) is None


def test_a_run_that_takes_too_long_ends_the_tighter_ones(few, monkeypatch):
    slow = []

    def run(self, setting):
        slow.append(setting)
        raise mbdfmi.run.instance.SimulationError("takes more than 1 s of CPU: stopped at 0.1 s", 0.1)

    trial = comparison._Trial(oscillator(), np.linspace(0, 1, 11), None, None, 1.0)
    monkeypatch.setattr(comparison._Trial, "run", run)
    runs = []

    for setting in (
        Setting("auto", 1e-8),
        Setting("rk54", 1e-4),
        Setting("rk54", 1e-5),
        Setting("rk54", 1e-6),
    ):
        reason = comparison._left_out(setting, runs, 0.0, 1.0)
        runs.append(Run(setting, reason=reason) if reason else comparison._compared(trial, setting, None)[0])

    assert slow == [Setting("auto", 1e-8), Setting("rk54", 1e-4)]
    assert all("more than 1 s" in run.reason for run in runs)


def test_shorter_steps_that_are_needless_or_too_long_are_left_out():
    own = Run(Setting("auto", 1e-8), 1e-8, "x", 1.0)
    exact, slow = Run(Setting("gauss", 0.1), 1e-13, "x", 1.0), Run(Setting("rk4", 0.1), 1e-3, "x", 1.0)
    left_out = comparison._left_out
    assert "as exact as the reference" in left_out(Setting("gauss", 0.025), [own, exact], 1e-12, 10.0)
    assert left_out(Setting("rk4", 0.025), [own, slow], 1e-12, 10.0) == ""
    assert "more than 3 s" in left_out(Setting("rk4", 0.025), [own, slow], 1e-12, 3.0)
    needless = Run(Setting("gauss", 0.025), reason=comparison.NEEDLESS)
    assert left_out(Setting("gauss", 0.00625), [own, exact, needless], 1e-12, 10.0) == comparison.NEEDLESS


class Output:
    """A variable, as far as errors look at it."""

    def __init__(self, name, unit):
        self.name, self.unit = name, unit


def test_sizes_are_those_of_arrays_and_not_of_rounding():
    """A component that stays zero is measured by its array; an output of rounding by the largest of its unit."""
    variables = [
        Output("p[1]", "m"),
        Output("p[2]", "m"),
        Output("gap", "m"),
        Output("angle", "rad"),
        Output("z", None),
    ]
    reference = np.array([[3.0, 0.0, 1e-12, 0.5, 0.0], [-4.0, 1e-17, 0.0, -0.25, 0.0]])
    assert comparison._sizes(variables, reference) == pytest.approx([4.0, 4.0, 4e-6, 0.5, 1.0])


def test_whole_turns_and_signs_of_orientations_are_no_errors():
    names = [
        "b.zyx[1]",
        "b.zyx[2]",
        "b.zyx[3]",
        *(f"b.euler_parameters[{k}]" for k in range(1, 5)),
        "j.angle",
    ]
    variables = [Output(name, None) for name in names]
    reference = np.array([[np.pi, 0.1, 0.2, 0.5, 0.5, 0.5, 0.5, 3.0]])
    rows = np.array([[-np.pi + 1e-3, 0.1, 0.2, -0.5, -0.5, -0.5, -0.5, 3.0 + 2 * np.pi]])
    difference = comparison._difference(variables, rows, reference)
    assert difference == pytest.approx(np.array([[1e-3, 0, 0, 0, 0, 0, 0, 2 * np.pi]]))


def made(*figures):
    """A Comparison of runs (stepper, value, error, cpu)."""
    runs = [Run(Setting(name, value), error, "x", cpu) for name, value, error, cpu in figures]
    return Comparison("t", 1.0, 0.1, runs, runs[-1], Setting("auto", 1e-13), 1e-12, ["x"])


def test_the_front_and_the_best():
    found = made(
        ("rk54", 1e-4, 1e-3, 1.0),
        ("rk4", 0.1, 1e-2, 1.5),
        ("gauss", 0.1, 1e-7, 2.0),
        ("rk853", 1e-9, 1e-8, 3.0),
    )
    assert [run.setting.integrator for run in found.front] == ["rk54", "gauss", "rk853"]
    assert found.best(1e-3).setting.integrator == "rk54"
    assert found.best(1e-6).setting.integrator == "gauss"
    assert found.best(1e-6, ADAPTIVE).setting.integrator == "rk853"
    assert found.best(1e-9) is None
    assert replace(found, runs=[]).front == []


@pytest.mark.parametrize(
    "number, text",
    [(1e-7, "1e-7"), (2.5e-4, "2.5e-4"), (0.025, "0.025"), (9.765625e-5, "9.766e-5"), (1.0, "1")],
)
def test_short_numbers(number, text):
    assert short(number) == text


# the command


@pytest.fixture
def command(tmp_path, monkeypatch, few, capfd):
    """Runs `mbdfmi bench` on the oscillator; returns (status, stdout on one line, stderr)."""
    monkeypatch.chdir(tmp_path)
    monkeypatch.setenv("COLUMNS", "200")
    (tmp_path / "oscillator.toml").write_text(oscillator().to_toml())

    def run(*arguments):
        status = cli.main(["bench", "oscillator.toml", *arguments])
        printed = capfd.readouterr()
        return status, " ".join(printed.out.split()), " ".join(printed.err.split())

    return run


def test_the_command_tells_the_best_choice(command, tmp_path):
    pytest.importorskip("matplotlib")
    status, printed, message = command("--until", "1", "--step", "0.1", "--plot", "a.png", "--csv", "a.csv")
    assert status == 0, message
    assert "2 outputs compared with auto, tolerance 1e-12" in printed
    assert "for an error of 1e-3:" in printed and "for an error of 1e-6:" in printed
    assert "the scene's own solver (*): auto, tolerance 1e-8" in printed
    assert (tmp_path / "a.png").read_bytes().startswith(b"\x89PNG")

    with open(tmp_path / "a.csv", newline="") as file:
        rows = list(csv.DictReader(file))

    assert len(rows) == 15
    assert {row["integrator"] for row in rows} == {*ADAPTIVE, *FIXED_STEP}
    done = [row for row in rows if not row["failure"]]
    assert len(done) >= 12 and all(float(row["error"]) > 0.0 for row in done)
    assert [float(row["cpu [s]"]) for row in done] == sorted(float(row["cpu [s]"]) for row in done)


def test_the_table_goes_to_the_standard_output_alone(command):
    status, printed, message = command("--until", "1", "--step", "0.1", "--stepper", "rk54", "--csv", "-")
    assert status == 0
    assert printed.startswith("integrator,setting,value,error") and "compared" not in printed
    assert "outputs compared" in message


@pytest.mark.parametrize(
    "arguments, says",
    [
        (["--until", "0"], "must end after"),
        (["--until", "1", "--stepper", "euler"], "no stepper 'euler'; there are"),
        (["--until", "1", "--set", "solver.tolerance=1"], "is what is varied here"),
        (["--until", "1", "--plot", "a.docx"], "no picture's name"),
    ],
)
def test_the_command_refuses(command, arguments, says):
    status, printed, message = command(*arguments)
    assert status == 1 and printed == ""
    assert says in message
