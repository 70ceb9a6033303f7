"""The master, on a small FMU of ours and one by PythonFMU."""

from pathlib import Path
from time import process_time

import fmpy
import numpy as np
import pytest
from pythonfmu.builder import FmuBuilder

import mbdfmi
from mbdfmi.cosim import CouplingError, couple
from mbdfmi.cosim.rig import Rig

RAMP = """
from pythonfmu import Fmi2Causality, Fmi2Slave, Fmi2Variability, Real

PARAMETER = {"causality": Fmi2Causality.parameter, "variability": Fmi2Variability.fixed}

class Ramp(Fmi2Slave):
    def __init__(self, **kwargs):
        super().__init__(**kwargs)
        self.slope = 1.0
        self.position = 0.0
        self.time = 0.0
        self.fails_at = 1e9
        self.register_variable(Real("slope", **PARAMETER))
        self.register_variable(Real("fails_at", **PARAMETER))
        self.register_variable(Real("position", causality=Fmi2Causality.input))
        self.register_variable(Real("force", causality=Fmi2Causality.output,
                                    getter=lambda: self.slope * self.time))

    def do_step(self, time, step):
        self.time = time + step
        return self.time < self.fails_at
"""


@pytest.fixture(scope="module")
def fmus(tmp_path_factory):
    """A force that grows with time, and a sledge of 2 kg for it to push."""
    folder = tmp_path_factory.mktemp("fmus")
    script = folder / "ramp_for_test.py"
    script.write_text(RAMP)
    FmuBuilder.build_FMU(script, dest=folder / "ramp.fmu")

    sledge = mbdfmi.Scene(
        name="sledge",
        body={"sledge": {"mass": 2.0, "inertia": [1, 1, 1], "output": ["position"]}},
        joint={
            "slide": {
                "prismatic": {"axis": "x"},
                "between": ["ground", "sledge"],
                "input": "force",
                "output": ["position", "speed"],
            }
        },
    )
    return {"ramp": folder / "ramp.fmu", "sledge": sledge.export(folder / "sledge.fmu")}


PUSH = [("ramp.force", "sledge.slide.force")]


def test_inputs_run_linearly_over_a_step(fmus):
    # m x" = 3 t has x = t^3 / 4: exact however long the steps, because the ramp goes first
    run = couple(fmus, PUSH, until=2.2, step=0.5, parameters={"ramp.slope": 3.0})
    assert run["time"] == pytest.approx([0, 0.5, 1, 1.5, 2, 2.2])
    assert run["ramp.force"] == pytest.approx(3 * run["time"])
    assert run["sledge.slide.position"] == pytest.approx(run["time"] ** 3 / 4, abs=1e-7)
    assert run.units["sledge.slide.speed"] == "m/s"


def test_order_decides_what_is_known(fmus):
    # the other way round the force of the step's start is held: x' lags half a step behind
    step, other = 0.01, dict(reversed(fmus.items()))
    late = couple(other, PUSH, 1, step, method="gauss-seidel", sequence=["sledge", "ramp"])
    assert late["sledge.slide.speed"][-1] == pytest.approx((1 - step) / 4, rel=1e-6)
    # left alone, the master puts the source first
    assert couple(other, PUSH, 1, step)["sledge.slide.speed"][-1] == pytest.approx(1 / 4, rel=1e-6)


def test_an_array_feeds_an_array(fmus):
    with pytest.raises(CouplingError, match="sledge.sledge.position has 3 components, ramp.position has 1"):
        couple(fmus, [("sledge.sledge.position", "ramp.position")], 1, 0.1)


def test_what_an_fmu_logs_is_told_of_it_and_no_run_of_fmpy_is_harmed(fmus, tmp_path, capsys):
    """FMPy formats messages for one logger only, that of the FMU made last, wherever it has gone."""
    cam = mbdfmi.load(Path(__file__).parents[1] / "models/cam_follower.toml").export(tmp_path / "cam.fmu")
    run = couple({"cam": cam, **fmus}, PUSH, 0.02, 0.01)
    assert [text.split()[0] for text in run.notices if "0.0420" in text] == ["cam:"]

    capsys.readouterr()
    fmpy.simulate_fmu(str(cam), stop_time=0.02, output_interval=0.01)
    assert "taken as 0.0420" in capsys.readouterr().out


def test_a_failing_fmu_is_named(fmus):
    with pytest.raises(CouplingError, match="ramp: asks for the end of the run in the step at 0.4 s"):
        couple(fmus, PUSH, 1, 0.1, {"ramp.fails_at": 0.45})


@pytest.mark.parametrize(
    "connections, message",
    [
        ([("rmap.force", "sledge.slide.force")], "no FMU 'rmap'; did you mean 'ramp'"),
        ([("ramp.forces", "sledge.slide.force")], "no output 'forces'; did you mean 'force'"),
        ([("ramp.force", "sledge.slide.position")], "no input 'slide.position'"),
        (PUSH + PUSH, "sledge.slide.force is fed twice"),
    ],
)
def test_wrong_connections_are_told(fmus, connections, message):
    with pytest.raises(CouplingError, match=message):
        couple(fmus, connections, 1, 0.1)


@pytest.mark.parametrize("until, step", [(0, 0.1), (1, 0), (1, np.nan), (np.inf, 0.1)])
def test_senseless_times_are_refused(fmus, until, step):
    with pytest.raises(ValueError, match="must be positive"):
        couple(fmus, PUSH, until, step)


def test_what_is_no_fmu_is_named(fmus, tmp_path):
    (tmp_path / "empty.fmu").write_bytes(b"")

    for name, text in (("empty.fmu", "no FMU for co-simulation in"), ("missing.fmu", "there is no file")):
        with pytest.raises(CouplingError, match=f"ramp: {text} {tmp_path / name}"):
            couple(fmus | {"ramp": tmp_path / name}, PUSH, 1, 0.1)


def test_two_runs_are_equal(fmus):
    first, second = (couple(fmus, PUSH, 1, 0.1) for _ in range(2))
    assert all(np.array_equal(first[name], second[name]) for name in first)


def test_held_inputs_take_one_call_each_way_and_a_product(fmus, monkeypatch):
    """A macro step of FMUs that hold what they have: of each one call that sets, one that steps, one that reads, and one
    product for all links; time for it is an upper bound that no load of the machine should reach.
    """
    done = {"products": 0}
    renewing = Rig.renewing

    def counted(rig):
        renew = renewing(rig)

        def once():
            done["products"] += 1
            renew()

        return once

    monkeypatch.setattr(Rig, "renewing", counted)
    begun = process_time()
    run = couple(fmus, PUSH, 10.0, 1e-3, method="jacobi", parameters={"ramp.slope": 3.0})
    spent = process_time() - begun
    # the last step stands alone, as it may be shorter
    assert done["products"] == 9999
    assert len(run["time"]) == 10_001
    assert run.work == {"ramp": 10_000, "sledge": 10_000}
    # held over a step: half a step late
    assert run["sledge.slide.speed"][-1] == pytest.approx(3 * (10.0**2 - 10.0 * 1e-3) / 4, rel=1e-5)
    assert spent < 5.0


def test_a_failure_in_the_midst_of_held_steps_is_told_with_its_time(fmus):
    """The rows up to it are there."""
    with pytest.raises(CouplingError) as error:
        couple(fmus, [*PUSH], 10.0, 0.01, method="jacobi", limit=5.0, parameters={"ramp.slope": 3.0})

    results = error.value.results
    assert "beyond [master] limit = 5" in str(error.value)
    assert results["time"][-1] == pytest.approx(1.66, abs=0.011)
    assert results["ramp.force"] == pytest.approx(3 * results["time"])
