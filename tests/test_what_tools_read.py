"""What tools read in an FMU beside its variables: quantities, ranges, flanges."""

import zipfile

import fmpy
import numpy as np
import pytest
from fmpy.validation import validate_fmu
from fmu_host import OK, Instance, Library
from lxml import etree
from test_model_exchange import SCENES

from mbdfmi import Scene
from mbdfmi.compiler.model import compile_scene
from mbdfmi.export import export_fmu
from mbdfmi.export.description import description
from mbdfmi.export.description3 import description3
from mbdfmi.export.terminals import ICON, NAME, terminals
from mbdfmi.scene import read_scene
from mbdfmi.units import UNITS

WRITERS = {2: description, 3: description3}


@pytest.fixture(scope="module")
def crane():
    """Something of each: bodies with forces in both axes, a driven slide and hinge, an actuator, a stop, friction."""
    mark = {"position": [1, 0, 0], "input": ["force", "moment"], "output": ["velocity", "omega", "zyx"]}
    own = {
        "input": ["force"],
        "input_axes": "body",
        "output": ["velocity", "velocity_body", "euler_parameters"],
    }
    stop = {"lower": -1.0, "upper": 1.0, "stiffness": 1e4, "damping": 10.0}
    friction = {"coulomb": 3.0, "viscous": 0.1}
    return Scene(
        name="crane",
        gravity=[0, 0, -9.81],
        body={
            "cart": {"mass": 3, "inertia": [1, 1, 1], "marker": {"tip": mark}},
            "arm b": {"mass": 2, "inertia": [0.1, 0.2, 0.3], **own},
        },
        joint={
            "rail": {
                "prismatic": {"axis": "x"},
                "between": ["ground", "cart"],
                "input": "force",
                "stop": stop,
                "friction": friction,
                "output": ["position", "speed"],
                "start": {"speed": 0.4},
            },
            "pin": {
                "revolute": {"axis": "y"},
                "between": ["cart.tip", "arm b"],
                "input": "torque",
                "damper": 0.2,
                "spring": {"stiffness": 5.0},
                "output": ["angle", "speed"],
                "start": {"speed": -0.7},
            },
        },
        force={
            "ram": {
                "spring_damper": {"stiffness": 0},
                "between": ["ground", "cart.tip"],
                "input": "force",
                "output": ["length", "rate"],
            }
        },
        output=["input_power", "kinetic_energy"],
    )


def variables_of(root):
    """Attributes by names, those of Real within."""
    found = {}

    for element in root.find("ModelVariables"):
        real = element if element.find("Real") is None else element.find("Real")
        found[element.get("name")] = {**element.attrib, **real.attrib}

    return found


@pytest.mark.parametrize("fmi", WRITERS)
@pytest.mark.parametrize("path", SCENES, ids=lambda path: path.stem)
def test_types_and_ranges(path, fmi):
    """Every declared type is there once and has the variable's own unit; every start is in its range."""
    root = etree.fromstring(WRITERS[fmi](compile_scene(read_scene(path))))
    types = {}

    for element in root.find("TypeDefinitions"):
        (kind,) = element if fmi == 2 else [element]
        assert element.get("name") == kind.get("quantity") not in types
        types[element.get("name")] = kind.get("unit"), kind.get("displayUnit")

    used = set()
    for name, v in variables_of(root).items():
        assert name not in types
        if kind := v.get("declaredType"):
            assert types[kind] == (v["unit"], v.get("displayUnit")), name
            used.add(kind)
        else:
            assert not UNITS[v.get("unit", "1")].quantity, name
        for start in map(float, v.get("start", "").split()):
            assert float(v.get("min", "-inf")) <= start <= float(v.get("max", "inf")), name
    assert used == set(types)


def test_ranges_by_meaning(crane):
    v = variables_of(etree.fromstring(description(crane.compile())))
    least = {name: a.get("min") for name, a in v.items()}
    not_negative = (
        *(
            "cart.mass",
            "cart.inertia[1]",
            "rail.stop.stiffness",
            "rail.stop.damping",
            "rail.friction.coulomb",
        ),
        *("rail.friction.viscous", "pin.damper", "ram.length", "kinetic_energy"),
    )
    assert {least[name] for name in not_negative} == {"0.0"}
    free = (
        "cart.inertia[4]",
        "cart.com[1]",
        "gravity[3]",
        "rail.stop.lower",
        "rail.force",
        "rail.position",
        "pin.angle",
    )
    assert {least[name] for name in free} == {None}
    tip = [(v[f"cart.tip.zyx[{k}]"]["min"], v[f"cart.tip.zyx[{k}]"]["max"]) for k in (1, 2, 3)]
    half, whole = repr(np.pi / 2), repr(np.pi)
    assert tip == [("-" + whole, whole), ("-" + half, half), ("-" + whole, whole)]
    assert (v["solver.tolerance"]["min"], v["solver.tolerance"]["max"]) == ("1e-14", "0.1")

    arrays = variables_of(etree.fromstring(description3(crane.compile())))
    assert (arrays["cart.tip.zyx"]["min"], arrays["cart.tip.zyx"]["max"]) == ("-" + whole, whole)
    assert "min" not in arrays["cart.inertia"]


def test_outputs_keep_to_their_ranges(crane, tmp_path):
    """Over a run that turns over itself."""
    fmu = export_fmu(crane.compile(), tmp_path / "c.fmu")
    with zipfile.ZipFile(fmu) as archive:
        v = variables_of(etree.fromstring(archive.read("modelDescription.xml")))
    result = fmpy.simulate_fmu(str(fmu), stop_time=3, start_values={"pin.torque": 60.0}, output_interval=0.01)
    for name in result.dtype.names[1:]:
        assert result[name].min() >= float(v[name].get("min", "-inf")), name
        assert result[name].max() <= float(v[name].get("max", "inf")), name


@pytest.mark.parametrize("fmi", [2, 3])
@pytest.mark.parametrize("path", SCENES, ids=lambda path: path.stem)
def test_terminals_of_every_scene(path, fmi):
    """What they name is there: efforts are inputs, the rest are outputs; by the schema, which the writer asks."""
    model = compile_scene(read_scene(path))
    v = variables_of(etree.fromstring(WRITERS[fmi](model)))
    root = etree.fromstring(terminals(model, fmi))
    names = [t.get("name") for t in root.iter("Terminal")]
    assert len(set(names)) == len(names)
    for member in root.iter("TerminalMemberVariable"):
        signal = member.get("variableKind") == "signal"
        assert v[member.get("variableName")]["causality"] == ("output" if signal else "input")


POWERS = {"force": ("velocity_body", "velocity", "speed", "rate"), "moment": ("omega",), "torque": ("speed",)}


def test_terminals_are_ports_of_power(crane, tmp_path):
    """Efforts times rates of all terminals is the power of all inputs, axes and signs right."""
    model = crane.compile()
    fmu = export_fmu(model, tmp_path / "c.fmu")
    assert validate_fmu(str(fmu)) == []
    with zipfile.ZipFile(fmu) as archive:
        root = etree.fromstring(archive.read(NAME))
        assert archive.read(ICON).startswith(b"\x89PNG")

    instance = Instance(Library(fmu, tmp_path / "c"))
    inputs = {v.name: float(k + 1) for k, v in enumerate(model.of_causality("input"))}
    assert instance.set(inputs) == OK
    instance.start()
    for i in range(20):
        assert instance.step(0.01 * i, 0.01) == OK

    power = 0.0
    terminals_ = {t.get("name"): list(t) for t in root.iter("Terminal")}
    assert set(terminals_) == {"'arm b'", "cart.tip", "pin", "rail", "ram"}
    for owner, members in terminals_.items():
        words = {m.get("memberName").split("[")[0] for m in members}
        for m in members:
            if m.get("variableKind") == "signal":
                continue
            word, _, index = m.get("memberName").partition("[")
            (rate, *_) = [r for r in POWERS[word] if r in words]
            at = f"[{index}" if index else ""
            sign = {"inflow": 1, "outflow": -1}[m.get("variableKind")]
            power += sign * inputs[m.get("variableName")] * instance.value(f"{owner}.{rate}{at}")
    assert power == pytest.approx(instance.value("input_power"), rel=1e-12)
    instance.free()
