"""VDMCheck2, the strictest of the validators of FMI 2: the standard's rules in VDM, run over a model's description.

It is a Java program of Maven Central: `apt-get install maven` brings what fetches and runs it. Without that, and where
nothing can be fetched, these tests are skipped, and say so.
"""

import shutil
import subprocess
import zipfile
from pathlib import Path

import pytest

from mbdfmi.compiler.model import compile_scene
from mbdfmi.export import export_fmu
from mbdfmi.scene import read_scene
from tests.model_files import SCENES

QUICK = {"double_pendulum", "four_bar", "marble_run"}  # the rest, 6 s of CPU each, when long tests run

PROJECT = """<project xmlns="http://maven.apache.org/POM/4.0.0">
  <modelVersion>4.0.0</modelVersion>
  <groupId>mbdfmi.tests</groupId><artifactId>vdmcheck</artifactId><version>1</version><packaging>pom</packaging>
  <dependencies><dependency>
    <groupId>org.into-cps.vdmcheck.fmi2</groupId><artifactId>vdmcheck2</artifactId><version>1.1.3</version>
  </dependency></dependencies>
</project>
"""
FETCH = "org.apache.maven.plugins:maven-dependency-plugin:3.6.1:copy-dependencies"


@pytest.fixture(scope="module")
def vdmcheck(tmp_path_factory) -> Path:
    """The folder with `vdmcheck2.jar`, the jars it looks for by their plain names and its rules unpacked beside them."""
    maven = shutil.which("mvn")
    if maven is None or shutil.which("java") is None:
        pytest.skip("VDMCHECK2 IS NOT RUN: no Maven here (apt-get install maven)")
    folder = tmp_path_factory.mktemp("vdmcheck")
    (folder / "pom.xml").write_text(PROJECT)
    command = [maven, "-q", "-B", FETCH, f"-DoutputDirectory={folder}", "-Dmdep.stripVersion=true"]
    try:
        done = subprocess.run(command, cwd=folder, capture_output=True, text=True, timeout=400)
    except subprocess.TimeoutExpired:
        pytest.skip("VDMCHECK2 IS NOT RUN: Maven had not fetched it after 400 s")
    if done.returncode or not (folder / "vdmcheck2.jar").exists():
        pytest.skip(f"VDMCHECK2 IS NOT RUN: Maven could not fetch it: {(done.stdout + done.stderr)[-300:]}")
    for jar in ("vdmcheck2", "rule-model", "static-model"):
        with zipfile.ZipFile(folder / f"{jar}.jar") as archive:
            archive.extractall(folder)
    return folder


def findings(folder: Path, fmu: Path) -> str:
    """What VDMCheck2 says of an FMU, its closing line "No errors found." included."""
    command = ["java", "-Xmx1g", "-jar", "vdmcheck2.jar", str(fmu)]
    return subprocess.run(command, cwd=folder, capture_output=True, text=True, timeout=600).stdout.strip()


@pytest.mark.parametrize(
    "path", [pytest.param(s, id=s.stem, marks=[] if s.stem in QUICK else pytest.mark.long) for s in SCENES]
)
def test_no_rule_of_fmi_2_is_broken(vdmcheck, path, tmp_path):
    fmu = export_fmu(compile_scene(read_scene(path)), tmp_path / f"{path.stem}.fmu")
    assert findings(vdmcheck, fmu) == "No errors found."


def test_it_finds_what_is_wrong(vdmcheck, tmp_path):
    """A description without its InitialUnknowns is valid XML and breaks a rule: the validator does look."""
    path = next(scene for scene in SCENES if scene.stem == "double_pendulum")
    fmu = export_fmu(compile_scene(read_scene(path)), tmp_path / "whole.fmu")
    with zipfile.ZipFile(fmu) as archive:
        description = archive.read("modelDescription.xml").decode()
    start, end = description.index("<InitialUnknowns>"), description.index("</InitialUnknowns>")
    broken = description[:start] + description[end + len("</InitialUnknowns>") :]
    (tmp_path / "modelDescription.xml").write_text(broken)
    assert "No errors found." not in findings(vdmcheck, tmp_path / "modelDescription.xml")
