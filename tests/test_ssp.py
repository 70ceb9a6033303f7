"""Packages of SSP 1.0: written, validated by the standard's own schemas, read back, run by fmpy; and others' packages read."""

import zipfile

import numpy as np
import pytest
from fmpy.ssp.simulation import simulate_ssp
from fmpy.ssp.ssd import read_ssd, validate_tree
from lxml import etree

from mbdfmi.cli import main
from mbdfmi.cosim import CouplingError, System, load_system
from tests.coupled_blocks import block

SSV = "http://ssp-standard.org/SSP1/SystemStructureParameterValues"


@pytest.fixture(scope="module")
def file(tmp_path_factory):
    """The FMU of a block."""
    return block().export(tmp_path_factory.mktemp("blocks") / "block.fmu")


@pytest.fixture
def system(file):
    """Two blocks, the force of each from the other's position."""
    return System(
        name="two blocks",
        fmu={
            "a": {"file": file, "parameters": {"block.mass": 2.0}, "hold": "end"},
            "b": {"file": file, "parameters": {"rail.position_start": -0.2}},
        },
        link=[
            {"source": "a.rail.position", "target": "b.rail.force", "factor": 3.0, "units": False},
            {
                "source": "b.rail.position",
                "target": "a.rail.force",
                "factor": 2.0,
                "offset": 0.5,
                "units": False,
            },
        ],
        master={"method": "jacobi"},
        run={"stop": 1.0, "step": 0.01},
    )


def test_there_and_back(system, tmp_path):
    path = system.write_ssp(tmp_path / "two.ssp")
    again = load_system(path)
    one, other = system.simulate(), again.simulate()
    assert again.name == "two blocks" and again.fmu["a"].hold == "end" and again.run.step == 0.01
    assert list(one) == list(other)
    assert all(np.array_equal(one[name], other[name]) for name in one)
    with zipfile.ZipFile(path) as package:
        # one FMU, though two take part
        assert [name for name in package.namelist() if name.endswith(".fmu")] == ["resources/block.fmu"]


def test_the_schemas_of_the_standard(system, tmp_path):
    path = system.write_ssp(tmp_path / "two.ssp")
    description = read_ssd(str(path))  # which validates
    assert [c.name for c in description.system.elements] == ["a", "b"]
    assert {unit.name for unit in description.units} >= {"m", "N"}
    with zipfile.ZipFile(path) as package:
        root = etree.fromstring(package.read("SystemStructure.ssd"))
    sets = root.findall(f".//{{{SSV}}}ParameterSet")
    assert len(sets) == 2
    for found in sets:
        validate_tree(etree.fromstring(etree.tostring(found)), "SystemStructureParameterValues.xsd")


def test_fmpy_runs_it(file, tmp_path):
    """Without transformations and parameters, which fmpy does not know: the same up to a step's lag of its own."""
    system = System(
        fmu={"a": {"file": file}, "b": {"file": file}},
        link=[{"source": "a.rail.position", "target": "b.rail.force", "units": False}],
        master={"method": "jacobi"},
    )
    path = system.write_ssp(tmp_path / "two.ssp")
    theirs = simulate_ssp(str(path), stop_time=1.0, step_size=0.001)
    name = next(n for n in theirs.dtype.names if n.endswith("b.rail.position"))
    ours = system.simulate(1.0, 0.001)
    np.testing.assert_allclose(theirs[name], ours["b.rail.position"][1 : len(theirs) + 1], atol=2e-4)


def test_command(system, tmp_path, capsys):
    path = system.write_ssp(tmp_path / "two.ssp")
    assert main(["couple", str(path), "--check"]) == 0
    assert "a.rail.position -> b.rail.force (times 3)" in capsys.readouterr().out
    assert main(["couple", str(path), "--ssp", str(tmp_path / "again.ssp")]) == 0
    assert main(["couple", str(path), "--until", "0.1", "--csv", str(tmp_path / "run.csv")]) == 0


def test_what_ssp_cannot_say(file, tmp_path):
    system = System(
        fmu={"a": {"file": file}, "b": {"file": file}},
        link=[{"source": ["a.rail.position", "b.rail.position"], "target": "b.rail.force", "units": False}],
    )
    with pytest.raises(CouplingError, match="adds up sources"):
        system.write_ssp(tmp_path / "sum.ssp")
    assert not (tmp_path / "sum.ssp").exists()


HEAD = (
    '<ssd:SystemStructureDescription xmlns:ssd="http://ssp-standard.org/SSP1/SystemStructureDescription" '
    'xmlns:ssc="http://ssp-standard.org/SSP1/SystemStructureCommon" '
    'xmlns:ssv="http://ssp-standard.org/SSP1/SystemStructureParameterValues" '
    'xmlns:ssm="http://ssp-standard.org/SSP1/SystemStructureParameterMapping" version="1.0" name="nested">'
)

NESTED = (
    HEAD
    + """
<ssd:System name="root">
 <ssd:ParameterBindings>
  <ssd:ParameterBinding source="values.ssv">
   <ssd:ParameterMapping><ssm:ParameterMapping version="1.0">
    <ssm:MappingEntry source="m" target="inner.a.block.mass"/>
    <ssm:MappingEntry source="x" target="b.rail.position_start"><ssc:LinearTransformation factor="2" offset="0.1"/></ssm:MappingEntry>
   </ssm:ParameterMapping></ssd:ParameterMapping>
  </ssd:ParameterBinding>
 </ssd:ParameterBindings>
 <ssd:Elements>
  <ssd:System name="inner">
   <ssd:Connectors><ssd:Connector name="out" kind="output"><ssc:Real unit="m"/></ssd:Connector></ssd:Connectors>
   <ssd:Elements><ssd:Component name="a" source="resources/block.fmu">
     <ssd:Connectors><ssd:Connector name="rail.position" kind="output"><ssc:Real/></ssd:Connector></ssd:Connectors>
     <ssd:ParameterBindings><ssd:ParameterBinding><ssd:ParameterValues>
      <ssv:ParameterSet version="1.0" name="p"><ssv:Parameters>
       <ssv:Parameter name="rail.position_start"><ssv:Real value="40" unit="cm"/></ssv:Parameter>
       <ssv:Parameter name="block.mass"><ssv:Real value="7"/></ssv:Parameter>
      </ssv:Parameters></ssv:ParameterSet></ssd:ParameterValues></ssd:ParameterBinding></ssd:ParameterBindings>
   </ssd:Component></ssd:Elements>
   <ssd:Connections><ssd:Connection startElement="a" startConnector="rail.position" endConnector="out">
     <ssc:LinearTransformation factor="3" offset="0.5"/></ssd:Connection></ssd:Connections>
  </ssd:System>
  <ssd:Component name="b" source="resources/block.fmu">
   <ssd:Connectors><ssd:Connector name="rail.force" kind="input"><ssc:Real/></ssd:Connector></ssd:Connectors>
  </ssd:Component>
 </ssd:Elements>
 <ssd:Connections><ssd:Connection startElement="inner" startConnector="out" endElement="b" endConnector="rail.force"
   suppressUnitConversion="true"><ssc:LinearTransformation factor="2" offset="1"/></ssd:Connection></ssd:Connections>
</ssd:System>
<ssd:Units><ssc:Unit name="cm"><ssc:BaseUnit m="1" factor="0.01"/></ssc:Unit><ssc:Unit name="m"><ssc:BaseUnit m="1"/></ssc:Unit></ssd:Units>
<ssd:DefaultExperiment startTime="0" stopTime="2"/>
</ssd:SystemStructureDescription>"""
)

VALUES = f"""<ssv:ParameterSet xmlns:ssv="{SSV}" version="1.0" name="values"><ssv:Parameters>
<ssv:Parameter name="m"><ssv:Real value="5"/></ssv:Parameter><ssv:Parameter name="x"><ssv:Real value="0.3"/></ssv:Parameter>
</ssv:Parameters></ssv:ParameterSet>"""


def nested(file, path, text=NESTED):
    """A package of another maker's style."""
    with zipfile.ZipFile(path, "w") as package:
        package.writestr("SystemStructure.ssd", text)
        package.writestr("values.ssv", VALUES)
        package.write(file, "resources/block.fmu")
    return path


def test_systems_in_systems(file, tmp_path):
    """Transformations one after another, parameters of outer systems over inner ones, units converted, mappings done."""
    system = load_system(nested(file, tmp_path / "nested.ssp"))
    assert system.fmu["a"].parameters == {"rail.position_start": pytest.approx(0.4), "block.mass": 5.0}
    assert system.fmu["b"].parameters == {"rail.position_start": pytest.approx(0.7)}
    (link,) = system.link
    assert (link.source, link.target) == (["a.rail.position"], "b.rail.force")
    assert (link.factor, link.offset, link.units) == (6.0, 2.0, False)
    assert system.run.stop == 2.0
    assert system.simulate(0.1, 0.01)["a.rail.position"][0] == pytest.approx(0.4)


@pytest.mark.parametrize(
    "was, now, message",
    [
        ("resources/block.fmu", "resources/blok.fmu", "the package has no resources/blok.fmu"),
        ('source="resources/block.fmu"', 'source="../block.fmu"', "is no FMU in the package"),
        ('kind="input"', 'kind="sink"', "SystemStructure.ssd: line"),
        ('target="inner.a.block.mass"', 'target="outer.a.block.mass"', "no such component"),
        ('unit="cm"', 'unit="s"', "is given in s, the FMU has it in m"),
        ("</ssd:System>", "", "not valid XML"),
        ('version="1.0" name="nested"', 'name="nested"', "version"),
    ],
)
def test_bad_packages_are_told(file, tmp_path, was, now, message):
    path = nested(file, tmp_path / "bad.ssp", NESTED.replace(was, now))
    with pytest.raises(CouplingError, match=message) as caught:
        load_system(path)
    assert str(path) in str(caught.value)


def test_what_is_no_package(tmp_path):
    (tmp_path / "a.ssp").write_bytes(b"no zip")
    with pytest.raises(CouplingError, match="cannot be read"):
        load_system(tmp_path / "a.ssp")
    with pytest.raises(CouplingError, match="cannot be read"):
        load_system(tmp_path / "none.ssp")
