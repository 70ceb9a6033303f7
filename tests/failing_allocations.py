"""A process in which one allocation of an FMU after the other fails: python failing_allocations.py FOLDER FMI KIND.

Its library is that of `test_any_calls.py`, which counts. Prints how many allocations there are.
"""

import ctypes
import sys
from ctypes import byref, c_bool, c_double, c_int, c_size_t, c_uint, c_void_p
from pathlib import Path

import fmu_host
import fmu_host3
from fmu_host import DISCARD, ERROR, OK, WARNING


class Stopped(Exception):
    """A call did not succeed."""


class Session:
    """All that allocates, once; a call that does not succeed raises Stopped."""

    def __init__(self, library, version, kind):
        self.library, self.version, self.exchanges = library, version, kind == "ModelExchange"
        self.has_events = kind == "EventMode"
        variables = library.variables.values()
        self.inputs = [v.valueReference for v in variables if v.causality == "input"]
        self.outputs = [v for v in variables if v.causality == "output"]
        self.locals = [v.valueReference for v in variables if v.causality == "local"]
        self.parameters = [v.valueReference for v in variables if v.variability == "tunable"][:2]
        self.n = len(library.description.derivatives)
        self.update = fmu_host3.UPDATE(lambda *given: None)
        if version == 2:
            code = fmu_host.MODEL_EXCHANGE if self.exchanges else fmu_host.CO_SIMULATION
            self.instance = fmu_host.Instance(library, kind=code)
        else:
            kind = "CoSimulation" if self.has_events else kind
            events = c_bool(self.has_events)
            extra = None if self.exchanges else (events, events, None, c_size_t(0))
            self.instance = fmu_host3.Instance(
                library, kind=kind, extra=extra, update=None if self.exchanges else self.update
            )

    def call(self, name, *arguments):
        status = self.instance.call(f"fmi{self.version}{name}", *arguments)
        assert status in (OK, WARNING, DISCARD, ERROR), (name, status)
        if status > WARNING:
            raise Stopped(name)

    def size(self, references):
        names = {v.valueReference: v.name for v in self.library.variables.values()}
        return sum(self.library.length(names[k]) if self.version == 3 else 1 for k in references)

    def keys(self, references):
        return (c_uint * len(references))(*references), c_size_t(len(references))

    def run(self):
        """From the initialisation on; the outputs at its end."""
        start, none = c_double(0.0), c_double(0.0)
        if self.version == 2:
            self.call("SetupExperiment", 0, none, start, 0, none)
            self.call("EnterInitializationMode")
        else:
            self.call("EnterInitializationMode", c_bool(False), none, start, c_bool(False), none)
        self.call("ExitInitializationMode")
        if self.has_events:
            self.discrete()
        self.solve() if self.exchanges else self.step()
        self.snapshots()
        self.derive()
        found = self.get([v.valueReference for v in self.outputs]) + self.get(self.locals)
        self.call("Terminate")
        return found

    def get(self, references):
        n = self.size(references)
        values = (c_double * n)()
        if self.version == 2:
            self.call("GetReal", *self.keys(references), values)
        else:
            self.call("GetFloat64", *self.keys(references), values, c_size_t(n))
        return list(values)

    def step(self):
        for k in range(3):
            t, H = c_double(k * 0.01), c_double(0.01)
            if self.version == 2:
                self.call("DoStep", t, H, 1)
            else:
                told = c_bool(), c_bool(), c_bool(), c_double()
                self.call("DoStep", t, H, c_bool(True), *map(byref, told))

    def solve(self):
        self.discrete()
        n = c_size_t(self.n if self.version == 2 else self.length_of_states())
        x, rates = (c_double * (n.value + 1))(), (c_double * (n.value + 1))()
        self.call("GetContinuousStates", x, n)
        self.call("GetDerivatives" if self.version == 2 else "GetContinuousStateDerivatives", rates, n)
        for k in range(n.value):
            x[k] += 1e-3 * rates[k]
        self.call("SetTime", c_double(1e-3))
        self.call("SetContinuousStates", x, n)
        kind = c_int if self.version == 2 else c_bool
        flags = kind(), kind()
        self.call("CompletedIntegratorStep", kind(1), *map(byref, flags))
        self.call("EnterEventMode")
        self.discrete()

    def length_of_states(self):
        n = c_size_t()
        self.call("GetNumberOfContinuousStates", byref(n))
        return n.value

    def discrete(self):
        if self.version == 2:
            self.call("NewDiscreteStates", (c_double * 8)())
        else:
            flags, time = [c_bool() for _ in range(5)], c_double()
            self.call("UpdateDiscreteStates", *map(byref, flags), byref(time))
        self.call("EnterStepMode" if self.has_events else "EnterContinuousTimeMode")

    def snapshots(self):
        name = "FMUstate" if self.version == 2 else "FMUState"
        undo = "DeSerialize" if self.version == 2 else "Deserialize"
        state, copy, size = c_void_p(), c_void_p(), c_size_t()
        try:
            self.call(f"Get{name}", byref(state))
            self.call(f"Serialized{name}Size", state, byref(size))
            data = ctypes.create_string_buffer(size.value)
            self.call(f"Serialize{name}", state, data, size)
            self.call(f"{undo}{name}", data, size, byref(copy))
            self.call(f"Set{name}", copy)
        finally:
            for one in (state, copy):
                if one.value:
                    assert self.instance.call(f"fmi{self.version}Free{name}", byref(one)) == OK

    def derive(self):
        unknowns, knowns = [v.valueReference for v in self.outputs], self.inputs + self.parameters
        m, n = self.size(unknowns), self.size(knowns)
        seed, result = (c_double * (m + n))(*[1.0] * (m + n)), (c_double * (m + n))()
        ends = *self.keys(unknowns), *self.keys(knowns)
        if self.version == 2:
            self.call("GetDirectionalDerivative", *ends, seed, result)
        else:
            self.call("GetDirectionalDerivative", *ends, seed, c_size_t(n), result, c_size_t(m))
            self.call("GetAdjointDerivative", *ends, seed, c_size_t(m), result, c_size_t(n))
        if not self.exchanges:
            orders = (c_int * len(unknowns))(*[2] * len(unknowns))
            if self.version == 2:
                self.call("GetRealOutputDerivatives", *self.keys(unknowns), orders, result)
            else:
                self.call("GetOutputDerivatives", *self.keys(unknowns), orders, result, c_size_t(m))


def main(folder, version, kind):
    library = (fmu_host if version == 2 else fmu_host3).Library(None, folder)
    count = library.dll
    count.test_made.restype = count.test_alive.restype = ctypes.c_long
    whole = Session(library, version, kind)
    expected = whole.run()
    whole.instance.free()
    assert count.test_alive() == 0

    k = 0
    while True:
        k += 1
        count.test_fail_at(ctypes.c_long(k))
        session = Session(library, version, kind)

        if session.instance.component is None:
            assert session.instance.log, f"the {k}th fails, and nothing is told"
            assert count.test_alive() == 0, f"the {k}th: {count.test_alive()} blocks stay"
            continue

        try:
            found = session.run()
            assert found == expected
        except Stopped as stopped:
            assert session.instance.log, f"the {k}th fails in {stopped}, and nothing is told"

        fell = count.test_made() >= k
        count.test_fail_at(ctypes.c_long(0))
        assert session.instance.call(f"fmi{version}Reset") == OK
        assert session.run() == expected, f"the {k}th: another result after a reset"
        session.instance.free()
        assert count.test_alive() == 0, f"the {k}th: {count.test_alive()} blocks stay"
        if not fell:
            return k - 1


if __name__ == "__main__":
    print(main(Path(sys.argv[1]), int(sys.argv[2]), sys.argv[3]))
