"""`mbdfmi check FMU --probe`: an FMU that does all well, and one that does all wrong, question by question."""

import subprocess
import sys
import tempfile
import zipfile
from pathlib import Path

import fmpy
import pytest

from mbdfmi.cli import main
from mbdfmi.compiler.model import compile_scene
from mbdfmi.export import export_fmu
from mbdfmi.probe import probe
from mbdfmi.probe.answers import ABSENT, FAULT, GOOD, TOLD, Answer
from mbdfmi.probe.exchange import Exchanged
from mbdfmi.probe.exchange_questions import QUESTIONS as EXCHANGE
from mbdfmi.probe.fmu import Fmu
from mbdfmi.probe.questions import QUESTIONS
from mbdfmi.scene import read_scene

HERE = Path(__file__).parent
SCENE = HERE.parent / "models" / "two_link_arm.toml"
UNSEEN = {"starts_as_told", "watches_events", "tells_times_of_events", "tells_changes"}
"""What there is nothing to ask about where states follow from parameters, and nothing stops."""

DESCRIPTION = """<?xml version="1.0" encoding="UTF-8"?>
<fmiModelDescription fmiVersion="2.0" modelName="small" guid="{{small}}"{more}>
  {kind} modelIdentifier="small" canGetAndSetFMUstate="true"
    canSerializeFMUstate="true" providesDirectionalDerivative="true"/>
  <DefaultExperiment startTime="0" stopTime="2" stepSize="0.05"/>
  <ModelVariables>
    <ScalarVariable name="u" valueReference="0" causality="input" variability="continuous">
      <Real start="0"/></ScalarVariable>
    <ScalarVariable name="y" valueReference="1" causality="output" variability="continuous">
      <Real/></ScalarVariable>
    <ScalarVariable name="k" valueReference="2" causality="parameter" variability="tunable" initial="exact">
      <Real start="3"/></ScalarVariable>
    {states}
  </ModelVariables>
  <ModelStructure>
    <Outputs><Unknown index="2" dependencies="{dependencies}"/></Outputs>
    {rates}<InitialUnknowns><Unknown index="2"/></InitialUnknowns>
  </ModelStructure>
</fmiModelDescription>
"""


STEPS = {
    "kind": """<CoSimulation canHandleVariableCommunicationStepSize="true" canInterpolateInputs="true"
    maxOutputDerivativeOrder="1\"""",
    "more": "",
    "states": "",
    "rates": "",
}
RATES = {
    "kind": "<ModelExchange",
    "more": ' numberOfEventIndicators="1"',
    "states": """<ScalarVariable name="x" valueReference="3" causality="local" variability="continuous"
      initial="exact"><Real start="0"/></ScalarVariable>
    <ScalarVariable name="der(x)" valueReference="4" causality="local" variability="continuous">
      <Real derivative="4"/></ScalarVariable>""",
    "rates": '<Derivatives><Unknown index="5" dependencies="{}"/></Derivatives>\n    ',
}
"""What the descriptions of the two kinds have."""


@pytest.fixture(scope="module")
def small(tmp_path_factory):
    """Paths of the good and the faulty FMU, and of both for model exchange (`exchange-good`)."""
    folder = tmp_path_factory.mktemp("small")
    headers = Path(fmpy.__file__).parent / "c-code"
    found = {}

    for name, flags in (("good", []), ("faulty", ["-DFAULTY"])):
        library = folder / f"{name}{fmpy.sharedLibraryExtension}"
        command = [
            sys.executable,
            "-m",
            "ziglang",
            "cc",
            "-shared",
            "-fPIC",
            "-O1",
            "-fno-sanitize=all",
            *flags,
        ]
        subprocess.run(
            [*command, f"-I{headers}", HERE / "faulty_fmu.c", "-lm", "-o", library], check=True, cwd=folder
        )
        for kind, more, by in (("", STEPS, "1"), ("exchange-", RATES, "1 4")):
            found[kind + name] = folder / f"{kind}{name}.fmu"
            rates = more["rates"].format("1" if name == "good" else "")
            text = DESCRIPTION.format(**more | {"rates": rates}, dependencies=by if name == "good" else "")
            with zipfile.ZipFile(found[kind + name], "w") as archive:
                archive.writestr("modelDescription.xml", text)
                archive.write(library, f"binaries/{fmpy.platform}/small{fmpy.sharedLibraryExtension}")

    return found


def test_a_good_fmu(small):
    answers = list(probe(small["good"]))
    assert [(a.question, a.verdict, a.seen) for a in answers if a.verdict == FAULT] == []
    assert len(answers) == len(QUESTIONS)
    assert sum(a.verdict == GOOD for a in answers) >= len(QUESTIONS) - 3


def test_a_good_fmu_for_model_exchange(small, tmp_path):
    """In this process."""
    fmpy.extract(str(small["exchange-good"]), str(tmp_path))
    fmu = Exchanged(tmp_path)
    answers = {name: question(fmu) for name, question in EXCHANGE.items()}
    assert {name: a for name, a in answers.items() if a[0] not in (GOOD, ABSENT)} == {}
    assert {name for name, a in answers.items() if a[0] == ABSENT} == {
        "solved_as_in_co_simulation",
        "gives_adjoint_derivatives",
    }
    assert answers["tells_times_of_events"][1] == "4 events"


def test_every_fault_is_found(small):
    """Each question is answered by the fault that it is about; what falls or hangs is told."""
    told = {}
    answers = dict(
        zip(QUESTIONS, probe(small["faulty"], limit=15, progress=lambda text: told.update({text: 1})))
    )
    assert len(told) == len(QUESTIONS)
    expected = {
        "runs": (GOOD, "40 steps"),
        "reruns": (FAULT, "differ by"),
        "resets": (FAULT, "differ by"),
        "keeps_start_values": (FAULT, "k starts otherwise; k was lost"),
        "rolls_back": (FAULT, "differ by"),
        "travels": (FAULT, "the other process falls"),
        "counts_time": (FAULT, "differ by"),
        "takes_steps_of_any_size": (TOLD, "differs by"),
        "uses_input_derivatives": (FAULT, "off by"),
        "gives_output_derivatives": (FAULT, "not finite"),
        "gives_directional_derivatives": (FAULT, "off by 0.5"),
        "gives_adjoint_derivatives": (ABSENT, "not claimed"),
        "tells_dependencies": (FAULT, "not declared: y by u"),
        "refuses_wrong_steps": (FAULT, "accepted: backwards, from another time"),
        "refuses_a_step_of_nan": (FAULT, "no answer within 15 s"),
        "refuses_unknown_references": (FAULT, "brings its process down (SIG"),
        "is_honest_about_nan": (FAULT, "u = nan: NaN in y"),
        "runs_in_threads": (FAULT, "differ by"),
    }
    for name, (verdict, seen) in expected.items():
        assert answers[name].verdict == verdict and seen in answers[name].seen, (name, answers[name])
    assert set(expected) == set(QUESTIONS)


def test_every_fault_of_model_exchange_is_found(small):
    """In this process, but for what brings it down."""
    with tempfile.TemporaryDirectory() as folder:
        fmpy.extract(str(small["exchange-faulty"]), folder)
        fmu = Exchanged(folder)
        skipped = {"travels", "refuses_unknown_references"}
        answers = {name: question(fmu) for name, question in EXCHANGE.items() if name not in skipped}
    expected = {
        "runs": (GOOD, "40 steps of 0.05 s, in 4 parts each"),
        "reruns": (FAULT, "differ by"),
        "resets": (FAULT, "differ by"),
        "keeps_start_values": (FAULT, "k starts otherwise; k was lost"),
        "starts_as_told": (FAULT, "x starts at 0.5"),
        "rolls_back": (FAULT, "differ by"),
        "solved_as_in_co_simulation": (ABSENT, "no co-simulation"),
        "keeps_states": (FAULT, "states come back"),
        "forgets": (FAULT, "differ by"),
        "has_nominals": (FAULT, "0"),
        "watches_events": (FAULT, "events in 160 steps"),
        "tells_times_of_events": (FAULT, "which was before"),
        "completes_steps": (FAULT, "changes states and asks for no event"),
        "tells_changes": (FAULT, "changes states and does not say so"),
        "gives_directional_derivatives": (FAULT, "off by 0.5, by "),
        "gives_adjoint_derivatives": (ABSENT, "not claimed"),
        "tells_dependencies": (FAULT, "not declared: der(x) by u, y by u, y by x"),
        "refuses_other_sizes": (FAULT, "accepted"),
        "is_honest_about_nan_in_states": (FAULT, "x = nan: NaN among the rates"),
        "runs_in_threads": (FAULT, "differ by"),
    }
    for name, (verdict, seen) in expected.items():
        assert answers[name][0] == verdict and seen in answers[name][1], (name, answers[name])
    assert {*expected, *skipped} == set(EXCHANGE)


@pytest.mark.parametrize(
    "kind, questions, scene, fmi, absent",
    [
        (Fmu, QUESTIONS, "two_link_arm", 2, {"gives_adjoint_derivatives"}),
        (Fmu, QUESTIONS, "two_link_arm", 3, {"uses_input_derivatives"}),
        (Exchanged, EXCHANGE, "two_link_arm", 2, {*UNSEEN, "gives_adjoint_derivatives"}),
        (Exchanged, EXCHANGE, "four_bar", 3, UNSEEN),
    ],
)
def test_our_own(kind, questions, scene, fmi, absent, tmp_path):
    """In this process: all is well, and all that is claimed was asked."""
    path = HERE.parent / "models" / f"{scene}.toml"
    fmu = export_fmu(compile_scene(read_scene(path)), tmp_path / "it.fmu", fmi=fmi)
    fmpy.extract(str(fmu), str(tmp_path / "it"))
    it = kind(tmp_path / "it")
    answers = {name: question(it) for name, question in questions.items()}
    assert {name: a for name, a in answers.items() if a[0] == FAULT} == {}
    assert {name for name, a in answers.items() if a[0] == ABSENT} == absent


def test_the_command(small, capsys, monkeypatch):
    monkeypatch.setattr("mbdfmi.probe.questions.QUESTIONS", {n: QUESTIONS[n] for n in ("runs", "resets")})
    assert main(["check", "--probe", str(small["faulty"])]) == 1
    told = capsys.readouterr()
    assert "After a reset it is as new" in told.out and "fault" in told.out
    assert "1 fault found" in told.err or "faults found" in told.err

    chosen = {name: EXCHANGE[name] for name in ("runs", "travels", "refuses_unknown_references")}
    monkeypatch.setattr("mbdfmi.probe.kinds.KINDS", {"ModelExchange": (Exchanged, chosen)})
    assert main(["check", "--probe", str(small["exchange-faulty"])]) == 1
    told = capsys.readouterr()
    assert "in model exchange" in told.out and "the other process falls" in told.out
    assert "brings its process down" in told.out

    # each answer when it comes, not all of them at the end
    def answers(path, limit, progress):
        for n, words in enumerate(("It runs", "It falls", "It stands again")):
            assert words not in capsys.readouterr().out
            progress(words)
            yield Answer(words, FAULT if n == 1 else "good", "what was seen", "CoSimulation")
            assert words in capsys.readouterr().out

    monkeypatch.setattr("mbdfmi.probe.probe", answers)
    assert main(["check", "--probe", str(small["good"])]) == 1
    assert "1 fault found" in capsys.readouterr().err

    assert main(["check", "--probe", "--limit", "0", str(small["good"])]) == 1
    assert "above 0" in capsys.readouterr().err
    assert main(["check", "--probe", str(SCENE)]) == 1
    assert "for FMUs" in capsys.readouterr().err
