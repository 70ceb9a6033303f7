"""Containers of other tools, FMUs made of several: they take our FMUs, and give what our own master does."""

import fmpy
import numpy as np
import pytest
from fmpy.container_fmu.cli import create_container_fmu
from fmpy.container_fmu.config import Component, Configuration, Connection
from fmpy.model_description import (
    CoSimulation,
    DefaultExperiment,
    ModelDescription,
    ModelVariable,
    Unknown,
)

from mbdfmi.cosim import System
from tests.coupled_blocks import block

H, STOP = 0.01, 2.0
LINKS = [("left.rail.position", "right.rail.force"), ("right.rail.speed", "left.rail.force")]


@pytest.fixture(autouse=True)
def own_folder(tmp_path, monkeypatch):
    """These tools leave the process in a folder of theirs."""
    monkeypatch.chdir(tmp_path)


def exported(folder, fmi):
    """Files of two blocks on springs."""
    found = {}

    for name, stiffness, start in (("left", 10.0, 0.1), ("right", 15.0, -0.05)):
        scene = block()
        scene.name = name
        scene.joint["rail"].spring = {"stiffness": stiffness}
        scene.joint["rail"].start = {"position": start}
        found[name] = scene.export(folder / f"{name}.fmu", fmi=fmi)

    return found


def system(files):
    """Both, fed with each other's motion, all at once."""
    return System(
        name="two",
        fmu={name: {"file": str(file)} for name, file in files.items()},
        link=[{"source": a, "target": b, "units": False} for a, b in LINKS],
        master={"method": "jacobi"},
        run={"stop": STOP, "step": H},
    )


def configuration(files):
    """What fmpy's container is made of: FMI 3.0, the blocks' positions for outputs."""
    parts = {name: Component(name, file, fmpy.read_model_description(file)) for name, file in files.items()}

    def place(text):
        name, variable = text.split(".", 1)
        variables = parts[name].modelDescription.modelVariables
        return parts[name], next(v for v in variables if v.name == variable)

    def variable(name, causality):
        made = ModelVariable(type="Float64", name=name, valueReference=0, causality=causality)
        made.variability = "continuous"
        return made

    connections = []

    for source, target in LINKS:
        (giver, output), (taker, entry) = place(source), place(target)
        connections.append(Connection(giver, [output], taker, [entry]))

    shown = {variable(name, "output"): [place(f"{name}.rail.position")] for name in files}
    description = ModelDescription(
        fmiVersion="3.0",
        modelName="container",
        instantiationToken="{two blocks}",
        generationDateAndTime="2026-01-01T00:00:00Z",
        defaultExperiment=DefaultExperiment(startTime="0", stopTime=str(STOP), stepSize=str(H)),
        modelVariables=[variable("time", "independent"), *shown],
        coSimulation=CoSimulation(modelIdentifier="container_fmu", fixedInternalStepSize=H),
    )
    description.outputs += [Unknown(variable=v) for v in shown]
    description.initialUnknowns += [Unknown(variable=v) for v in shown]
    return Configuration(False, description, list(parts.values()), connections, shown)


def simulated(path, names):
    """Columns of a container's run by fmpy, at our communication points."""
    run = fmpy.simulate_fmu(str(path), stop_time=STOP, step_size=H, output_interval=H, output=names)
    return [run[name] for name in names]


def test_the_container_of_fmpy(tmp_path):
    files = exported(tmp_path, 3)
    (tmp_path / "unpacked").mkdir()
    create_container_fmu(configuration(files), tmp_path / "unpacked", tmp_path / "container.fmu")
    ours = system(files).simulate()

    for name, found in zip(files, simulated(tmp_path / "container.fmu", list(files))):
        np.testing.assert_array_equal(found, ours[f"{name}.rail.position"])


def test_the_container_of_the_manipulation_toolbox(tmp_path):
    """It reads our package of SSP."""
    assembly = pytest.importorskip("fmu_manipulation_toolbox.assembly")
    two = system(exported(tmp_path, 2))
    two.write_ssp(tmp_path / "two.ssp")
    made = assembly.Assembly("two.ssp", fmu_directory=tmp_path, default_step_size=H)
    made.make_fmu(filename="made.fmu")
    ours = two.simulate()
    names = ["left.rail.position", "right.rail.speed"]

    for name, found in zip(names, simulated(tmp_path / "made.fmu", names)):
        np.testing.assert_array_equal(found, ours[name])
