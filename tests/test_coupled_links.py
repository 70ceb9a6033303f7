"""Coupled systems as they are written: links, units, types, arrays, parameters, what is recorded, and mistakes."""

import re

import numpy as np
import pytest
from pythonfmu.builder import FmuBuilder

import mbdfmi
from mbdfmi.cli import main
from mbdfmi.cosim import CouplingError, System, load_system

TYPES = """
from pythonfmu import Boolean, Fmi2Causality, Fmi2Slave, Fmi2Variability, Integer, Real, String

INPUT = {"causality": Fmi2Causality.input}
OUTPUT = {"causality": Fmi2Causality.output}
PARAMETER = {"causality": Fmi2Causality.parameter, "variability": Fmi2Variability.tunable}

class Types(Fmi2Slave):
    def __init__(self, **kwargs):
        super().__init__(**kwargs)
        self.real_in, self.whole_in, self.flag_in, self.text_in = 0.0, 0, False, ""
        self.real_out, self.whole_out, self.flag_out, self.text_out = 0.0, 0, False, ""
        self.count, self.label, self.hidden = 3, "idle", 0.0
        self.register_variable(Real("real_in", **INPUT))
        self.register_variable(Integer("whole_in", **INPUT))
        self.register_variable(Boolean("flag_in", **INPUT))
        self.register_variable(String("text_in", **INPUT))
        self.register_variable(Real("real_out", **OUTPUT))
        self.register_variable(Integer("whole_out", **OUTPUT))
        self.register_variable(Boolean("flag_out", **OUTPUT))
        self.register_variable(String("text_out", **OUTPUT))
        self.register_variable(Real("hidden", causality=Fmi2Causality.local))
        self.register_variable(Integer("count", **PARAMETER))
        self.register_variable(String("label", **PARAMETER))

    def do_step(self, time, step):
        end = time + step
        self.real_out = self.real_in
        self.whole_out = self.count + int(round(end * 10))
        self.flag_out = end > 0.45
        self.text_out = self.label + self.text_in
        self.hidden = 2.0 * end
        return True
"""


def turntable():
    """A shaft with a torque for an input, its angle in rad; and a body with a vector of forces."""
    return mbdfmi.Scene(
        name="shaft",
        gravity=[0, 0, 0],
        body={
            "rotor": {"mass": 1.0, "inertia": [2, 2, 2]},
            "ball": {
                "mass": 1.0,
                "inertia": [1, 1, 1],
                "input": ["force"],
                "output": ["position", "velocity"],
            },
        },
        joint={
            "pivot": {
                "revolute": {"axis": "z"},
                "between": ["ground", "rotor"],
                "input": "torque",
                "output": ["angle", "speed"],
                "start": {"speed": 1.0},
            },
            "float": {"free": {}, "between": ["ground", "ball"]},
        },
    )


@pytest.fixture(scope="module")
def folder(tmp_path_factory):
    """FMUs: `types` by PythonFMU, `shaft` of FMI 2.0, `shaft3` of FMI 3.0, and the scene's file."""
    folder = tmp_path_factory.mktemp("coupled")
    script = folder / "types_for_test.py"
    script.write_text(TYPES)
    FmuBuilder.build_FMU(script, dest=folder / "types.fmu")
    turntable().export(folder / "shaft.fmu")
    turntable().export(folder / "shaft3.fmu", fmi=3)
    (folder / "shaft.toml").write_text(turntable().to_toml())
    return folder


def test_types_go_from_fmu_to_fmu(folder):
    file = {"file": folder / "types.fmu"}
    system = System(
        fmu={
            "a": {**file, "parameters": {"count": 5, "label": "run"}},
            "b": {**file, "parameters": {"label": "."}},
        },
        link=[
            ("a.whole_out", "b.whole_in"),
            ("a.flag_out", "b.flag_in"),
            ("a.text_out", "b.text_in"),
            {"source": "a.whole_out", "target": "b.real_in", "factor": 0.5, "offset": 1.0},
            ("a.hidden", "a.real_in"),
        ],
        record=["a", "b.real_out", "b.whole_in", "b.flag_in", "a.hidden"],
    )
    results = system.simulate(1.0, 0.1)
    t = results["time"]
    np.testing.assert_array_equal(results["a.whole_out"][1:], 5 + np.round(10 * t[1:]))
    np.testing.assert_array_equal(results["b.whole_in"][2:], results["a.whole_out"][1:-1])
    np.testing.assert_array_equal(results["a.flag_out"][1:], t[1:] > 0.45)
    np.testing.assert_allclose(results["a.hidden"], 2 * t, atol=1e-15)
    # an Integer into a Real, scaled
    assert set(np.round(results["b.real_out"][2:] - 1 - 0.5 * results["a.whole_out"][1:-1], 12)) <= {0.0, 0.5}
    assert "a.text_out" not in results


@pytest.mark.parametrize("name", ["shaft.fmu", "shaft3.fmu"])
def test_arrays_sums_and_units(folder, name):
    """A force (vector) from the velocity of another ball, element by element; FMI 2.0 and 3.0 alike."""
    shaft = {"file": folder / name}
    start = {"parameters": {"float.velocity_start": [1.0, 2.0, 3.0]}} if name == "shaft.fmu" else {}
    system = System(
        fmu={"a": {**shaft, **start}, "b": dict(shaft)},
        link=[
            {"source": "a.ball.velocity", "target": "b.ball.force", "factor": 2.0, "units": False},
            {
                "source": ["a.pivot.angle", "b.pivot.angle"],
                "target": "b.pivot.torque",
                "factor": [1, -1],
                "units": False,
            },
            {"source": "a.ball.position[3]", "target": "a.ball.force[1]", "units": False},
        ],
        run={"stop": 0.5, "step": 0.05},
    )
    results = system.simulate()
    v = results["a.ball.velocity"]
    if start:
        # constant but for x: b is pushed by 2 v, m = 1
        np.testing.assert_allclose(results["b.ball.velocity"][:, 1], 4.0 * results["time"], atol=1e-7)
    # relative angle: phi" = (angle of a - angle of b) / 2, nothing while both are alike
    np.testing.assert_allclose(results["a.pivot.angle"], results["time"], atol=1e-8)
    np.testing.assert_allclose(results["b.pivot.angle"], results["time"], atol=1e-8)
    assert v.shape == (11, 3)


@pytest.mark.parametrize("name", ["shaft.fmu", "shaft3.fmu"])
def test_a_local_variable_is_a_source(folder, name):
    """A brake from the angular velocity of the rotor, which the scene does not show: 2 omega' = -0.8 omega, with long steps near
    what it is from the speed of the joint, of which the master knows the derivatives.
    """

    def run(source, step):
        shaft = {"file": folder / name}
        brake = {"source": f"a.{source}", "target": "a.pivot.torque", "factor": -0.8, "units": False}
        record = ["a.rotor.omega[3]", "a.pivot.speed", "a.rotor.euler_parameters"]
        return System(fmu={"a": shaft}, link=[brake], record=record).simulate(1.0, step)

    shown, told = run("pivot.speed", 0.1), run("rotor.omega[3]", 0.1)
    np.testing.assert_allclose(told["a.pivot.speed"], shown["a.pivot.speed"], rtol=0.01)
    fine = run("rotor.omega[3]", 0.002)
    np.testing.assert_allclose(fine["a.rotor.omega[3]"], np.exp(-0.4 * fine["time"]), rtol=1e-3)
    turned = (1 - np.exp(-0.4 * fine["time"])) / 0.4
    np.testing.assert_allclose(fine["a.rotor.euler_parameters"][:, 2], np.sin(turned / 2), atol=1e-3)


def test_both_versions_of_fmi_give_the_same(folder):
    def run(name):
        shaft = {"file": folder / name, "derivatives": False}
        link = [{"source": "a.pivot.angle", "target": "b.pivot.torque", "units": False}]
        return System(fmu={"a": shaft, "b": shaft}, link=link).simulate(1.0, 0.1)

    two, three = run("shaft.fmu"), run("shaft3.fmu")
    np.testing.assert_array_equal(two["b.pivot.angle"], three["b.pivot.angle"])


def test_a_scene_takes_part(folder, tmp_path):
    path = tmp_path / "two.toml"
    path.write_text(
        f'[fmu.scene]\nscene = "{folder / "shaft.toml"}"\nparameters.pivot.speed_start = 3\n'
        f'[fmu.fmu]\nfile = "{folder / "shaft.fmu"}"\n'
        '[[link]]\nsource = "scene.pivot.angle"\ntarget = "fmu.pivot.torque"\nunits = false\n[run]\nstop = 0.2\n'
    )
    system = load_system(path)
    results = system.simulate(view="scene")
    np.testing.assert_allclose(results["scene.pivot.angle"], 3 * results["time"], atol=1e-9)
    page = results.view(tmp_path / "run.html")
    assert page.stat().st_size > 50_000
    assert main(["couple", str(path), "--check"]) == 0
    assert main(["couple", str(path), "--csv", str(tmp_path / "a.csv"), "--method", "gauss-seidel"]) == 0
    assert main(["couple", str(path), "--view", str(tmp_path / "b.html"), "--until", "0.05"]) == 0


def changed_unit(folder, tmp_path, name, was, now):
    """The FMU with another unit in its description."""
    import zipfile

    path = tmp_path / "changed.fmu"
    with zipfile.ZipFile(folder / name) as old, zipfile.ZipFile(path, "w") as new:
        for item in old.infolist():
            data = old.read(item)
            if item.filename == "modelDescription.xml":
                assert was in data
                data = data.replace(was, now)
            new.writestr(item, data)
    return path


def test_units_are_converted(folder, tmp_path):
    """An angle in deg from one in rad: the declared base units say so."""
    degrees = changed_unit(
        folder,
        tmp_path,
        "shaft.fmu",
        b'<Unit name="N.m">',
        b'<Unit name="deg"><BaseUnit rad="1" factor="0.017453292519943295"/></Unit><Unit name="N.m">',
    )
    text = changed_torque_to_degrees(degrees, tmp_path)
    system = System(
        fmu={"a": {"file": folder / "shaft.fmu"}, "b": {"file": text}},
        link=[("a.pivot.angle", "b.pivot.torque")],
    )
    assert "rad to deg" in system.check()
    results = system.simulate(1.0, 0.05)
    # 2 phi" = 180/pi t
    exact = results["time"] + 180 / np.pi * results["time"] ** 3 / 12
    np.testing.assert_allclose(results["b.pivot.angle"], exact, rtol=1e-6)


def changed_torque_to_degrees(path, tmp_path):
    """The unit of `pivot.torque` made deg, which no one should do but a test."""
    import zipfile

    out = tmp_path / "degrees.fmu"
    with zipfile.ZipFile(path) as old, zipfile.ZipFile(out, "w") as new:
        for item in old.infolist():
            data = old.read(item)
            if item.filename == "modelDescription.xml":
                data = re.sub(
                    rb'(name="pivot\.torque".*?unit=")N\.m(")', rb"\1deg\2", data, count=1, flags=re.S
                )
            new.writestr(item, data)
    return out


MISTAKES = {
    "an FMU": ([("c.pivot.angle", "b.pivot.torque")], "no FMU 'c'"),
    "a variable": ([("a.pivot.angel", "b.pivot.torque")], "did you mean 'pivot.angle'"),
    "another word for a speed": ([("a.pivot.velocity", "b.pivot.torque")], "did you mean 'pivot.speed'"),
    "an input for a source": (
        [("a.pivot.torque", "b.pivot.torque")],
        "no output 'pivot.torque': it is of causality input",
    ),
    "an output for a target": (
        [("a.pivot.angle", "b.pivot.angle")],
        "no input 'pivot.angle': it is of causality output",
    ),
    "an angle into a torque": (
        [("a.pivot.angle", "b.pivot.torque")],
        "is in rad, b.pivot.torque in N.m: these measure",
    ),
    "lengths": ([("a.ball.velocity", "b.pivot.torque")], "has 3 components, b.pivot.torque has 1"),
    "no variable": ([("a", "b.pivot.torque")], 'write "a.variable"'),
}


@pytest.mark.parametrize("what", MISTAKES)
def test_wrong_links_are_told(folder, what):
    link, message = MISTAKES[what]
    shaft = {"file": folder / "shaft.fmu"}
    with pytest.raises(CouplingError, match=re.escape(message)) as caught:
        System(fmu={"a": shaft, "b": shaft}, link=link).check()
    assert "link[1]" in str(caught.value)


def test_all_mistakes_at_once(folder):
    shaft, types = {"file": folder / "shaft.fmu"}, {"file": folder / "types.fmu"}
    system = System(
        fmu={"a": shaft, "t": types},
        link=[
            ("a.pivot.angle", "t.whole_in"),
            ("t.flag_out", "t.real_in"),
            {"source": "t.whole_out", "target": "t.whole_in", "factor": 2},
            ("t.real_out", "t.real_in"),
            ("t.real_out", "t.real_in"),
        ],
        record=["a.nothing", "t.text_out"],
    )
    with pytest.raises(CouplingError) as caught:
        system.simulate(1, 0.1)
    texts = caught.value.errors
    assert "is of type real, t.whole_in of type integer" in texts[0]
    assert "is of type boolean, t.real_in of type real" in texts[1]
    assert "neither factor nor offset" in texts[2]
    assert "t.real_in is fed twice, by link[4] too" in texts[3]
    assert "record: a.nothing" in texts[4] and "is a text" in texts[5]


@pytest.mark.parametrize(
    "parameters, message",
    [
        ({"pivot.sped_start": 1}, "did you mean 'pivot.speed_start'"),
        ({"pivot.angle": 1}, "cannot be set: its value is found by the FMU"),
        ({"gravity": [0, 0]}, "takes 3 values, found 2"),
        ({"pivot.speed_start": True}, "needs a number, found true"),
        ({"pivot.speed_start": "fast"}, 'needs a number, found "fast"'),
    ],
)
def test_wrong_parameters_are_told(folder, parameters, message):
    system = System(fmu={"a": {"file": folder / "shaft.fmu", "parameters": parameters}})
    for call in (system.check, lambda: system.simulate(0.1, 0.01)):
        with pytest.raises(CouplingError, match=re.escape(message)) as caught:
            call()
        assert "[fmu.a] parameters: " + next(iter(parameters)) in str(caught.value)


TABLES = {
    "[fmu.a]\nfiel = 'a.fmu'": '[fmu.a] fiel: unknown key; there is "file"',
    "[fmu.a]\nfile = 'a.fmu'\nscene = 'b.toml'": '[fmu.a] "file" and "scene" exclude each other',
    "[fmu.a]": '[fmu.a] needs "file" or "scene"',
    "name = 'x'": "needs at least one FMU",
    "[fmu.a]\nfile = 'a.fmu'\n[master]\nmethod = 'jacoby'": '[master] method: no "jacoby" here',
    "[fmu.a]\nfile = 'a.fmu'\n[master]\nmethod = 'newton'\norder = 0": '[master] method "newton" needs order = 1 or 2',
    "[fmu.a]\nfile = 'a.fmu'\n[[link]]\nsource = 'a.x'": "link[1].target: is missing",
    "[fmu.a]\nfile = 'a.fmu'\n[run]\nstep = 0": "[run] step: must be greater than 0",
    "[fmu.a]\nfile = 'a.fmu'\n[fmu.a]": "not valid TOML",
    "[fmu.a]\nfile = 'none.fmu'": "a: there is no file",
}


@pytest.mark.parametrize("text", TABLES)
def test_wrong_tables_are_told(tmp_path, text):
    path = tmp_path / "system.toml"
    path.write_text(text)
    with pytest.raises(CouplingError, match=re.escape(TABLES[text])) as caught:
        load_system(path).check()
    assert str(caught.value).startswith(str(path))


def test_the_log_stands_in_the_message(folder):
    """The FMU says why it refuses."""
    shaft = {"file": folder / "shaft.fmu", "parameters": {"rotor.mass": -1.0}}
    with pytest.raises(CouplingError, match="a: fmi2.*; its log: .*mass"):
        System(fmu={"a": shaft}).simulate(0.1, 0.01)


def test_another_machine_is_told(folder, tmp_path):
    import zipfile

    path = tmp_path / "other.fmu"
    with zipfile.ZipFile(folder / "shaft.fmu") as old, zipfile.ZipFile(path, "w") as new:
        for item in old.infolist():
            item.filename = re.sub("^binaries/[^/]*/", "binaries/beos64/", item.filename)
            new.writestr(item, old.read(item.orig_filename))
    with pytest.raises(CouplingError, match="has no library for this machine .*; it has those for beos64"):
        System(fmu={"a": {"file": path}}).simulate(0.1, 0.01)


def test_what_is_no_system_is_told(folder):
    with pytest.raises(
        CouplingError, match=r'is an FMU; name it in a system file \(TOML\): \[fmu.NAME\] file = "types.fmu"'
    ):
        load_system(folder / "types.fmu")
    with pytest.raises(CouplingError, match="is a folder; name a file in it"):
        load_system(folder)


def test_bonds_that_cannot_be_watched_are_told():
    """A sum of sources carries no power that can be told from one of them."""
    tables = {
        "fmu": {"a": {"scene": turntable()}, "b": {"scene": turntable()}},
        "link": [
            {
                "source": ["a.pivot.speed", "b.pivot.angle"],
                "factor": -2.0,
                "target": "b.pivot.torque",
                "units": False,
            }
        ],
    }
    assert "power is watched at no link" in System(**tables).check()
    bond = {"shaft": {"effort": "a.pivot.speed", "flow": "b.pivot.speed"}}
    with pytest.raises(CouplingError, match=r"\[bond.shaft\] effort: .* no link has a.pivot.speed alone"):
        System(**tables, bond=bond).simulate(0.1, 0.01)
