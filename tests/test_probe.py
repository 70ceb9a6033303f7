"""`mbdfmi check FMU --probe`: an FMU that does all well, and one that does all wrong, question by question."""

import subprocess
import sys
import zipfile
from pathlib import Path

import fmpy
import pytest

from mbdfmi.cli import main
from mbdfmi.compiler.model import compile_scene
from mbdfmi.export import export_fmu
from mbdfmi.probe import probe
from mbdfmi.probe.answers import ABSENT, FAULT, GOOD, TOLD
from mbdfmi.probe.fmu import Fmu
from mbdfmi.probe.questions import QUESTIONS
from mbdfmi.scene import read_scene

HERE = Path(__file__).parent
SCENE = HERE.parent / "models" / "two_link_arm.toml"

DESCRIPTION = """<?xml version="1.0" encoding="UTF-8"?>
<fmiModelDescription fmiVersion="2.0" modelName="small" guid="{{small}}">
  <CoSimulation modelIdentifier="small" canHandleVariableCommunicationStepSize="true"
    canInterpolateInputs="true" maxOutputDerivativeOrder="1" canGetAndSetFMUstate="true"
    canSerializeFMUstate="true" providesDirectionalDerivative="true"/>
  <DefaultExperiment startTime="0" stopTime="2" stepSize="0.05"/>
  <ModelVariables>
    <ScalarVariable name="u" valueReference="0" causality="input" variability="continuous">
      <Real start="0"/></ScalarVariable>
    <ScalarVariable name="y" valueReference="1" causality="output" variability="continuous">
      <Real/></ScalarVariable>
    <ScalarVariable name="k" valueReference="2" causality="parameter" variability="tunable" initial="exact">
      <Real start="3"/></ScalarVariable>
  </ModelVariables>
  <ModelStructure>
    <Outputs><Unknown index="2" dependencies="{dependencies}"/></Outputs>
    <InitialUnknowns><Unknown index="2"/></InitialUnknowns>
  </ModelStructure>
</fmiModelDescription>
"""


@pytest.fixture(scope="module")
def small(tmp_path_factory):
    """Paths of the good and the faulty FMU."""
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
        found[name] = folder / f"{name}.fmu"
        with zipfile.ZipFile(found[name], "w") as archive:
            archive.writestr(
                "modelDescription.xml", DESCRIPTION.format(dependencies="1" if name == "good" else "")
            )
            archive.write(library, f"binaries/{fmpy.platform}/small{fmpy.sharedLibraryExtension}")

    return found


def test_a_good_fmu(small):
    answers = list(probe(small["good"]))
    assert [(a.question, a.verdict, a.seen) for a in answers if a.verdict == FAULT] == []
    assert sum(a.verdict == GOOD for a in answers) >= len(QUESTIONS) - 3


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


@pytest.mark.parametrize("fmi", [2, 3])
def test_our_own(fmi, tmp_path):
    """In this process: all is well, and all that is claimed was asked."""
    fmu = export_fmu(compile_scene(read_scene(SCENE)), tmp_path / "arm.fmu", fmi=fmi)
    fmpy.extract(str(fmu), str(tmp_path / "arm"))
    arm = Fmu(tmp_path / "arm")
    answers = {name: question(arm) for name, question in QUESTIONS.items()}
    assert {name: a for name, a in answers.items() if a[0] == FAULT} == {}
    absent = {name for name, a in answers.items() if a[0] == ABSENT}
    assert absent == {"gives_adjoint_derivatives" if fmi == 2 else "uses_input_derivatives"}


def test_the_command(small, capsys, monkeypatch):
    monkeypatch.setattr("mbdfmi.probe.questions.QUESTIONS", {n: QUESTIONS[n] for n in ("runs", "resets")})
    assert main(["check", "--probe", str(small["faulty"])]) == 1
    told = capsys.readouterr()
    assert "After a reset it is as new" in told.out and "fault" in told.out
    assert "1 fault found" in told.err or "faults found" in told.err

    assert main(["check", "--probe", "--limit", "0", str(small["good"])]) == 1
    assert "above 0" in capsys.readouterr().err
    assert main(["check", "--probe", str(SCENE)]) == 1
    assert "for FMUs" in capsys.readouterr().err
