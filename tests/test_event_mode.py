"""Event mode in co-simulation of FMI 3.0: state events in mid-step, time events, inputs that jump."""

from ctypes import byref, c_bool, c_double, c_size_t

import fmpy
import numpy as np
import pytest
import scipy.optimize
from fmu_host import ERROR, OK
from fmu_host3 import Instance, Library

from mbdfmi import Scene
from mbdfmi.compiler.model import compile_scene
from mbdfmi.export import export_fmu

STOP = {"lower": -1.0, "upper": 0.02, "stiffness": 1e4, "damping": 10.0}


class Evented(Instance):
    """An instance with event mode, which may return early."""

    def __init__(self, library, early=True):
        super().__init__(library, extra=(c_bool(True), c_bool(early), None, c_size_t(0)))

    def update(self):
        """An event handled; the time of the next."""
        flags, next_time = [c_bool() for _ in range(5)], c_double()
        status = self.call("fmi3UpdateDiscreteStates", *map(byref, flags), byref(next_time))
        assert status == OK and not any(flag.value for flag in flags[:4])
        assert self.call("fmi3EnterStepMode") == OK
        return next_time.value if flags[4].value else np.inf

    def begin(self):
        assert self.enter() == self.exit() == OK
        self.next_time = self.update()
        return self

    def event(self, **inputs):
        assert self.call("fmi3EnterEventMode") == OK
        if inputs:
            assert self.set({name.replace("__", "."): value for name, value in inputs.items()}) == OK
        self.next_time = self.update()

    def run(self, until, h):
        """Steps of h, events handled; the times of these."""
        t, events = 0.0, []
        while t < until - 1e-12:
            assert self.step(t, min(h, until - t)) == OK, self.log
            needed, terminated, early, t = self.told
            assert not terminated and (early is False or t < until)
            if needed:
                events.append(t)
                self.event()
        return events


def rail(**more):
    """A mass of 2 kg on a rail, at 0.5 m/s towards a stop that it meets at 0.01 s."""
    joint = {
        "prismatic": {"axis": "x"},
        "between": ["ground", "b"],
        "input": ["force"],
        "output": ["position", "speed", "acceleration"],
        "start": {"position": 0.015, "speed": 0.5},
    }
    body = {"b": {"mass": 2.0, "inertia": [1, 1, 1]}}
    return Scene(
        name="rail", gravity=[0, 0, 0], body=body, joint={"rail": joint | more.pop("joint", {})}, **more
    )


def library_of(scene, folder):
    path = export_fmu(compile_scene(scene), folder / "it.fmu", fmi=3)
    return Library(path, folder / "it")


def test_stops_are_met_in_mid_step(tmp_path):
    """The step returns early where the mass comes to the stop, and where it leaves it: the closed form's times."""
    solver = {"tolerance": 1e-10, "absolute_tolerance": 1e-12}
    fmu = Evented(library_of(rail(joint={"stop": STOP}, solver=solver), tmp_path)).begin()
    into, out = fmu.run(0.3, 0.05)
    d = 10 / (2 * 2)
    w = np.sqrt(1e4 / 2 - d * d)

    def motion(t):
        x, x1 = 0.5 / w * np.sin(w * t), 0.5 * np.cos(w * t)
        return np.exp(-d * t) * np.array([x, x1 - d * x])

    # a stop does not pull: from where it would the mass flies on
    free = scipy.optimize.brentq(lambda t: np.array([1e4, 10]) @ motion(t), 0.03, 0.0447, xtol=1e-14)
    x, speed = motion(free)
    assert into == pytest.approx(0.01, abs=1e-9)
    assert out - into == pytest.approx(free - x / speed, abs=1e-8)
    fmu.free()


@pytest.mark.parametrize("early", (True, False))
def test_results_are_those_without(early, tmp_path):
    """Events handled or not, returned early or not: the same motion, within the tolerance."""
    library = library_of(rail(joint={"stop": STOP}), tmp_path)
    fmu, plain = Evented(library, early).begin(), Instance(library).start()
    events = fmu.run(0.3, 0.05)
    assert len(events) == 2 and (early or events == pytest.approx([0.05, 0.1]))
    for k in range(6):
        assert plain.step(0.05 * k, 0.05) == OK
        assert plain.told[0] is False
    np.testing.assert_allclose(fmu.outputs(), plain.outputs(), atol=1e-5)
    fmu.free()
    plain.free()


def test_kinks_of_tables_over_time_and_place(tmp_path):
    load = {
        "table": {
            "time": [0.0, 0.13, 0.4],
            "force": [[0, 0, 0], [5, 0, 0], [0, 0, 0]],
            "interpolation": "linear",
        }
    }
    spring = {"table": {"position": [-1.0, 0.1, 1.0], "effort": [0.0, 0.0, 90.0], "interpolation": "linear"}}
    scene = rail(joint={"spring": spring}, force={"f": {"load": load, "on": "b"}})
    fmu = Evented(library_of(scene, tmp_path)).begin()
    assert fmu.next_time == 0.13
    events = fmu.run(0.3, 0.1)
    assert len(events) == 2 and 0.13 in events
    fmu.free()
    fmu = Evented(fmu.library).begin()
    other = next(t for t in events if t != 0.13)
    t = 0.0
    while t < other - 1e-9:
        assert fmu.step(t, min(0.02, other - t)) == OK
        needed, _, _, t = fmu.told
        if needed and t < other - 1e-9:
            fmu.event()
    assert fmu.outputs()[0] == pytest.approx(0.1, abs=1e-8)
    fmu.free()


def test_inputs_jump_in_event_mode(tmp_path):
    """A force that jumps at 0.12345 s, told in an event: exact."""
    fmu = Evented(library_of(rail(), tmp_path)).begin()
    assert fmu.step(0.0, 0.12345) == OK
    before = fmu.outputs()
    fmu.event(rail__force=4.0)
    assert fmu.outputs()[2] == pytest.approx(2.0) and before[2] == 0.0
    assert fmu.step(0.12345, 0.1) == OK
    assert fmu.outputs()[:2] == pytest.approx([0.015 + 0.5 * 0.22345 + 0.01, 0.7], rel=1e-9)
    fmu.free()


def test_states_of_event_mode(tmp_path):
    """Calls in their states; a state saved in event mode goes on there, and not in an instance without."""
    library = library_of(rail(joint={"stop": STOP}), tmp_path)
    fmu = Evented(library)
    assert fmu.call("fmi3EnterEventMode") == fmu.call("fmi3EnterStepMode") == ERROR
    assert fmu.enter() == fmu.exit() == OK
    assert fmu.step(0.0, 0.1) == ERROR and "event mode" in fmu.message
    for function in ("fmi3EnterContinuousTimeMode", "fmi3EnterEventMode"):
        assert fmu.call(function) == ERROR
    numbers = (c_double * 2)()
    for function in ("GetContinuousStates", "GetContinuousStateDerivatives", "GetEventIndicators"):
        assert (
            fmu.call(f"fmi3{function}", numbers, c_size_t(2)) == ERROR
            and "is for model exchange" in fmu.message
        )
    assert fmu.call("fmi3SetTime", c_double(1.0)) == ERROR
    data = fmu.serialise(fmu.save())
    fmu.update()
    assert fmu.step(0.0, 0.005) == OK

    other = Evented(library)
    status, snapshot = other.deserialise(data)
    assert status == other.restore(snapshot) == OK
    other.update()
    assert other.step(0.0, 0.005) == OK and other.outputs() == fmu.outputs()

    plain = Instance(library)
    assert plain.deserialise(data)[0] == ERROR and "this instance has none" in plain.message
    assert fmu.call("fmi3EnterEventMode") == fmu.call("fmi3Terminate") == fmu.call("fmi3Reset") == OK
    for it in (fmu, other, plain):
        it.free()


def test_fmpy_uses_it(tmp_path):
    scene = rail(joint={"stop": STOP})
    library_of(scene, tmp_path)
    run = {"fmi_type": "CoSimulation", "stop_time": 0.3, "output_interval": 0.01}
    plain = fmpy.simulate_fmu(str(tmp_path / "it.fmu"), **run)
    found = fmpy.simulate_fmu(str(tmp_path / "it.fmu"), use_event_mode=True, early_return_allowed=True, **run)
    at = found["time"][np.flatnonzero(np.diff(found["time"]) == 0)]
    assert len(at) >= 1 and at[0] == pytest.approx(0.01, abs=1e-6)
    for t in (0.05, 0.1, 0.3):
        rows = [np.flatnonzero(np.isclose(r["time"], t))[-1] for r in (plain, found)]
        assert found["rail.position"][rows[1]] == pytest.approx(plain["rail.position"][rows[0]], abs=1e-5)
