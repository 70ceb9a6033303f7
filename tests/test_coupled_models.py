"""The coupled systems of models/coupled: beside their monolithic solutions, in the plot, as packages, with their notices."""

import importlib.util
import sys

import numpy as np
import pytest

from mbdfmi.cli import main
from mbdfmi.cosim import load_system
from tests.test_models import MODELS

FOLDER = MODELS / "coupled"


@pytest.fixture(scope="module")
def examples():
    """models/coupled/run.py as a module."""
    known = [*sys.path]
    sys.path.insert(0, str(FOLDER))
    spec = importlib.util.spec_from_file_location("coupled_examples", FOLDER / "run.py")
    module = importlib.util.module_from_spec(spec)
    spec.loader.exec_module(module)
    yield module
    sys.path[:] = known


# largest difference of each curve from the monolithic solution
BOUNDS = {
    "truck": {"chassis": 2.5e-3, "wheel": 5e-4},
    "pendulum": {"upper rod": 1.5e-4, "lower rod": 3e-4},
    "crane": {"boom": 5e-4, "pressure below the piston": 0.01},
    "arm": {"shoulder": 2e-3, "elbow": 3e-3, "current of the shoulder": 0.02},
}


@pytest.mark.parametrize("name", BOUNDS)
def test_beside_the_monolithic_solution(examples, name):
    run, curves = examples.EXAMPLES[name]()
    assert {
        label: np.abs(ours - theirs).max() < BOUNDS[name][label]
        for label, (_, ours, theirs) in curves.items()
    } == dict.fromkeys(curves, True)
    assert run.notices == []
    # what goes out of one FMU comes into the other
    assert run.bonds and all(bond.part < 1e-3 for bond in run.bonds)


def test_a_turbine_and_its_controller_beside_one_loop(examples):
    """Asked eight times as often the controller changes little; asked as often as by the master, nothing."""
    run, curves = examples.turbine()
    bounds = {"rotor speed": 0.01, "pitch of the blades": 0.04, "thrust": 0.01}
    for label, (_, ours, theirs) in curves.items():
        assert 1e-6 < np.abs(ours - theirs).max() < bounds[label], label
    assert run.notices == []

    system = examples.at_sea.voyage(wind=14.0, hs=4.0, tp=9.0, seed=2)
    run = system.simulate(until=20.0)
    speed, pitch, thrust = examples.whole_turbine(system, run["time"], parts=1)
    assert np.abs(run["turbine.shaft.speed"] - speed).max() < 1e-12
    assert np.abs(run["controller.blade_pitch"] - pitch).max() < 1e-12
    assert np.abs(run["turbine.rotor.thrust"] - thrust).max() < 1e-6


def test_two_machines_on_an_arm_at_fixed_steps(examples):
    """Steps of 8 ms, four times the time constant of the shoulder's motor, which is switched on in the first one."""
    _, curves = examples.arm(0.008, order=1, error=None)
    assert all(np.abs(ours - theirs).max() < 5e-3 for _, ours, theirs in list(curves.values())[:2])


def test_parabolas(examples):
    """The truck, at the figure of the literature's best master (0.9 %), and the split pendulum."""
    _, curves = examples.truck(order=2)
    assert np.abs(curves["chassis"][1] - curves["chassis"][2]).max() < 0.006 * 0.1
    _, curves = examples.pendulum(order=2)
    assert np.abs(curves["lower rod"][1] - curves["lower rod"][2]).max() < 2e-5


@pytest.mark.parametrize(
    "options", [{"method": "jacobi", "step": 4e-3}, {"method": "gauss-seidel", "step": 8e-3}]
)
def test_a_poor_master_is_told(examples, options):
    """What masters without rollback make of the stiff oil is of no use, and is said to be."""
    examples.build()
    system = load_system(FOLDER / "hydraulic_crane.toml")
    system.master.method = options["method"]
    results = system.simulate(step=options["step"])
    assert any("too long for the master" in text or "the coupling made" in text for text in results.notices)


def test_the_picture(examples, tmp_path, monkeypatch, capsys):
    monkeypatch.setattr(sys, "argv", ["run.py", "truck", "--out", str(tmp_path / "a.png")])
    examples.main()
    assert (tmp_path / "a.png").stat().st_size > 20_000
    assert "chassis is off by" in capsys.readouterr().out


def test_packages(examples, tmp_path):
    examples.build()
    for name in ("quarter_truck", "hydraulic_crane"):
        system = load_system(FOLDER / f"{name}.toml")
        again = load_system(system.write_ssp(tmp_path / f"{name}.ssp"))
        one, other = system.simulate(until=0.1), again.simulate(until=0.1)
        assert all(np.array_equal(one[key], other[key]) for key in one)


def test_commands(tmp_path, capsys):
    file = str(FOLDER / "dc_motor.toml")
    assert main(["couple", file, "--check"]) == 0
    told = capsys.readouterr().out
    assert "winding, rotor (they feed each other)" in told and "interface Jacobian" in told
    assert main(["couple", file, "--until", "0.05"]) == 0
    assert "steps of the FMUs: winding" in capsys.readouterr().out
    assert main(["couple", file, "--method", "jacobi", "--csv", str(tmp_path / "part.csv")]) == 1
    assert "diverges" in capsys.readouterr().err
    assert (tmp_path / "part.csv").stat().st_size > 1000
    assert main(["couple", file, "--view", str(tmp_path / "a.html")]) == 1
    assert "say which by --scene NAME" in capsys.readouterr().err
    assert main(["couple", file, "--method", "jacoby"]) == 1
    assert (
        main(["couple", file, "--until", "0.05", "--view", str(tmp_path / "a.html"), "--scene", "rotor"]) == 0
    )
