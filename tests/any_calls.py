"""Any calls in any order: python any_calls.py FOLDER FMU-VERSION KIND SEED N drives the FMU unpacked there.

KIND: ModelExchange, CoSimulation, or EventMode: co-simulation that uses it.

Statuses are those of the standard and never Fatal, values that come with OK are finite, and after all a reset makes an instance that
runs. What brings the process down is told by the process; the last calls are printed as they are made, to a file.
"""

import ctypes
import math
import random
import sys
from ctypes import byref, c_bool, c_char_p, c_double, c_int, c_size_t, c_uint, c_void_p

import fmu_host
import fmu_host3

OK, WARNING, DISCARD, ERROR, FATAL = range(5)
WILD = (math.nan, math.inf, -math.inf, 1e300, -1e300, 1e30, 1e-300, -1.0)


class Driver:
    """An instance, what was done to it, and dice."""

    def __init__(self, folder, version, kind, seed):
        self.dice = random.Random(seed)
        self.version = version
        self.exchanges, self.has_events = kind == "ModelExchange", kind == "EventMode"
        host = fmu_host if version == 2 else fmu_host3
        self.library = host.Library(None, folder)
        self.n = len(self.library.description.modelVariables) + 1
        self.references = [v.valueReference for v in self.library.variables.values()]
        self.inputs = [v.valueReference for v in self.library.variables.values() if v.causality == "input"]
        variables = self.library.variables.values()
        rates = [u.variable for u in self.library.description.derivatives]
        states = [v.derivative for v in rates] if self.exchanges else []
        self.unknowns = [v.valueReference for v in variables if v.causality == "output" or v in rates]
        self.knowns = [
            v.valueReference
            for v in variables
            if v.causality == "input" or v.variability == "tunable" or v in states
        ]
        self.states = len(rates)
        self.kept = []
        self.time = 0.0
        self.calls = 0
        self.depth = 0
        if version == 2:
            code = fmu_host.MODEL_EXCHANGE if self.exchanges else fmu_host.CO_SIMULATION
            self.instance = fmu_host.Instance(self.library, kind=code)
        else:
            kind = "CoSimulation" if self.has_events else kind
            extra = None if self.exchanges else (c_bool(self.has_events), c_bool(True), None, c_size_t(0))
            self.update = fmu_host3.UPDATE(self._at_point)
            self.instance = fmu_host3.Instance(
                self.library, kind=kind, extra=extra, update=None if self.exchanges else self.update
            )
        self.instance.after_message = self._told
        assert self.instance.component

    # what the FMU calls: anything may be called from there

    def _told(self):
        """After each message; one in ten calls back."""
        if len(self.instance.log) > 100:
            del self.instance.log[:-10]
        self._from_within(0.1)

    def _at_point(self, _, time, wants, allowed, finished, may, requested, until):
        self._from_within(0.3)
        if may and self.dice.random() < 0.1:
            requested[0], until[0] = True, self.dice.choice([time, time + 1e-4, math.nan, 1e9])

    def _from_within(self, chance):
        if self.depth == 0 and self.dice.random() < chance:
            self.depth += 1
            self.one(within=True)
            self.depth -= 1

    # dice

    def number(self):
        d = self.dice.random()
        return (
            self.dice.choice(WILD)
            if d < 0.05
            else self.dice.choice([0.0, 1.0])
            if d < 0.3
            else self.dice.gauss(0, 2)
        )

    def keys(self, most=5, pool=None):
        """Value references, mostly good; of a pool, or any."""
        n = self.dice.randrange(most)
        pool = pool or (self.references if self.dice.random() < 0.6 else self.inputs or self.references)
        keys = [
            self.dice.choice(pool) if self.dice.random() < 0.97 else self.dice.randrange(2**32)
            for _ in range(n)
        ]
        return keys, ((c_uint * n)(*keys) if self.dice.random() < 0.98 else None), c_size_t(n)

    def length(self, keys):
        """How many values are meant, mostly right."""
        by_reference = {v.valueReference: v.name for v in self.library.variables.values()}
        n = sum(
            self.library.length(by_reference[k]) if self.version == 3 and k in by_reference else 1
            for k in keys
        )
        return n if self.dice.random() < 0.97 else self.dice.randrange(8)

    def numbers(self, n):
        return (c_double * n)(*[self.number() for _ in range(n)])

    # calls

    def call(self, name, *arguments):
        self.calls += 1
        status = self.instance.call(f"fmi{self.version}{name}", *arguments)
        assert status in (OK, WARNING, DISCARD, ERROR), (name, status)
        return status

    def one(self, within=False):
        """A call."""
        of_kind = EXCHANGE if self.exchanges else STEPPING + [Driver.event] * (3 * self.has_events)
        actions = WITHIN if within else ALWAYS + of_kind
        self.dice.choice(actions)(self)

    def begin(self):
        start = self.dice.choice([0.0, 0.0, 1.5, self.number()])
        tolerance = (self.dice.random() < 0.5, self.dice.choice([1e-5, 1e-9, self.number()]))
        stop = (self.dice.random() < 0.1, start + self.dice.choice([1.0, 50.0]))
        if self.version == 2:
            given = (
                int(tolerance[0]),
                c_double(tolerance[1]),
                c_double(start),
                int(stop[0]),
                c_double(stop[1]),
            )
            self.call("SetupExperiment", *given)
            self.call("EnterInitializationMode")
        else:
            given = (
                c_bool(tolerance[0]),
                c_double(tolerance[1]),
                c_double(start),
                c_bool(stop[0]),
                c_double(stop[1]),
            )
            self.call("EnterInitializationMode", *given)

    def ready(self):
        """All the way to where it runs."""
        self.begin()
        self.call("ExitInitializationMode")
        if (self.exchanges or self.has_events) and self.dice.random() < 0.8:
            self.update_discrete()
            self.leave_event_mode()

    def initialise(self):
        self.call("ExitInitializationMode")

    def reset(self):
        if self.dice.random() < 0.3:
            self.call("Reset")
            self.ready()

    def terminate(self):
        if self.dice.random() < 0.1:
            self.call("Terminate")

    def get(self):
        keys, array, n = self.keys()
        m = self.length(keys) if self.version == 3 else len(keys)
        values = (c_double * max(m, 1))()
        if self.version == 2:
            status = self.call("GetReal", array, n, values)
        else:
            status = self.call("GetFloat64", array, n, values, c_size_t(m))
        assert status != OK or all(map(math.isfinite, values[:m])), list(values)

    def set(self):
        keys, array, n = self.keys(4)
        m = self.length(keys) if self.version == 3 else len(keys)
        given = (self.numbers(max(m, 1)),) + ((c_size_t(m),) if self.version == 3 else ())
        self.call("SetReal" if self.version == 2 else "SetFloat64", array, n, *given)

    def drive_inputs(self):
        for key in self.inputs[:3]:
            m = self.length([key])
            array = (c_uint * 1)(key), c_size_t(1)
            given = (self.numbers(max(m, 1)),) + ((c_size_t(m),) if self.version == 3 else ())
            self.call("SetReal" if self.version == 2 else "SetFloat64", *array, *given)

    def input_derivatives(self):
        if self.version == 2:
            keys, array, n = self.keys(3)
            orders = (c_int * max(len(keys), 1))(*[self.dice.randrange(-1, 8) for _ in keys])
            self.call("SetRealInputDerivatives", array, n, orders, self.numbers(max(len(keys), 1)))

    def output_derivatives(self):
        keys, array, n = self.keys(4, self.unknowns)
        orders = (c_int * max(len(keys), 1))(*[self.dice.choice([1, 1, 2, 2, 0, 3]) for _ in keys])
        if self.version == 2:
            values = (c_double * max(len(keys), 1))()
            self.call("GetRealOutputDerivatives", array, n, orders, values)
        else:
            m = self.length(keys)
            values = (c_double * max(m, 1))()
            self.call("GetOutputDerivatives", array, n, orders, values, c_size_t(m))

    def derivatives(self):
        unknown, a, n = self.keys(4, self.unknowns)
        known, b, m = self.keys(4, self.knowns)
        if self.version == 2:
            result = (c_double * max(len(unknown), 1))()
            self.call("GetDirectionalDerivative", a, n, b, m, self.numbers(max(len(known), 1)), result)
            return
        adjoint = self.dice.random() < 0.5
        seeds, places = self.length(unknown if adjoint else known), self.length(known if adjoint else unknown)
        ends = self.numbers(max(seeds, 1)), c_size_t(seeds), (c_double * max(places, 1))(), c_size_t(places)
        self.call("GetAdjointDerivative" if adjoint else "GetDirectionalDerivative", a, n, b, m, *ends)

    def other_types(self):
        _, array, n = self.keys(2)
        more = (c_size_t(1),) if self.version == 3 else ()
        name = self.dice.choice(["GetBoolean", "SetBoolean", "GetString"])
        self.call(name, array, n, (c_void_p * 8)(), *more)

    def logging(self):
        names = [
            self.dice.choice([b"logAll", b"logEvents", b"logStatusDiscard", b"nothing"]) for _ in range(2)
        ]
        n = self.dice.randrange(3)
        on = self.dice.random() < 0.5
        self.call(
            "SetDebugLogging",
            c_bool(on) if self.version == 3 else int(on),
            c_size_t(n),
            (c_char_p * 2)(*names),
        )

    # snapshots

    def _state(self, verb):
        return f"{verb}FMU{'state' if self.version == 2 else 'State'}"

    def save(self):
        state = c_void_p(self.kept.pop().value if self.kept and self.dice.random() < 0.3 else None)
        self.call(self._state("Get"), byref(state))
        if state.value:
            self.kept.append(state)
        if len(self.kept) > 5:
            self.forget()

    def restore(self):
        self.call(
            self._state("Set"),
            self.dice.choice(self.kept) if self.kept and self.dice.random() < 0.95 else None,
        )

    def forget(self):
        if self.kept:
            state = self.kept.pop(self.dice.randrange(len(self.kept)))
            # what is refused lives on
            if self.call(self._state("Free"), byref(state)) != OK:
                self.kept.append(state)

    def carry(self):
        """Serialised, mostly unharmed, and back."""
        if not self.kept:
            return
        size, state = c_size_t(), self.dice.choice(self.kept)
        serialised, back = (
            ("SerializedFMUstateSize", "DeSerializeFMUstate")
            if self.version == 2
            else ("SerializedFMUStateSize", "DeserializeFMUState")
        )
        if self.call(serialised, state, byref(size)) != OK:
            return
        data = ctypes.create_string_buffer(size.value)
        if self.call(self._state("Serialize"), state, data, size) != OK:
            return
        if self.dice.random() < 0.3:
            for _ in range(self.dice.randrange(1, 4)):
                at = self.dice.randrange(size.value)
                data[at] = bytes([data.raw[at] ^ 1 << self.dice.randrange(8)])
        length = size.value if self.dice.random() < 0.9 else self.dice.randrange(size.value)
        found = c_void_p()
        if self.call(back, data, c_size_t(length), byref(found)) == OK:
            self.kept.append(found)

    # steps

    def now(self):
        """The time that the instance is at, as far as it tells."""
        if self.version == 2:
            value = c_double()
            if self.call("GetRealStatus", fmu_host.LAST_SUCCESSFUL_TIME, byref(value)) == OK:
                self.time = value.value
        else:
            value = (c_double * 1)()
            key = (c_uint * 1)(self.library.variables["time"].valueReference)
            if self.call("GetFloat64", key, c_size_t(1), value, c_size_t(1)) == OK:
                self.time = value[0]
        return self.time

    def step(self):
        t = self.now() if self.dice.random() < 0.95 else self.number()
        H = self.dice.choice([1e-3, 1e-2, 1e-2, 0.03]) if self.dice.random() < 0.95 else self.number()
        if self.version == 2:
            self.call("DoStep", c_double(t), c_double(H), 1)
        else:
            told = c_bool(), c_bool(), c_bool(), c_double()
            self.call("DoStep", c_double(t), c_double(H), c_bool(True), *map(byref, told))

    def steps(self):
        for _ in range(3):
            self.drive_inputs()
            self.step()

    # model exchange

    def update_discrete(self):
        if self.version == 2:
            self.call("NewDiscreteStates", (c_double * 8)())
        else:
            flags, time = [c_bool() for _ in range(5)], c_double()
            self.call("UpdateDiscreteStates", *map(byref, flags), byref(time))

    def leave_event_mode(self):
        self.call("EnterStepMode" if self.has_events else "EnterContinuousTimeMode")

    def event(self):
        self.call("EnterEventMode")
        self.drive_inputs()
        self.update_discrete()
        self.leave_event_mode()

    def completed(self):
        kind = c_int if self.version == 2 else c_bool
        flags = kind(), kind()
        self.call("CompletedIntegratorStep", 1 if self.version == 2 else c_bool(True), *map(byref, flags))

    def solver(self):
        """A step of a careless solver."""
        n = self.states
        x, rates = (c_double * (n + 1))(), (c_double * (n + 1))()
        names = (
            ("GetDerivatives", "GetEventIndicators")
            if self.version == 2
            else ("GetContinuousStateDerivatives", "GetEventIndicators")
        )
        if self.call("GetContinuousStates", x, c_size_t(n)) != OK:
            return
        if self.call(names[0], rates, c_size_t(n)) == OK:
            for k in range(n):
                x[k] += 1e-3 * rates[k] + (self.number() if self.dice.random() < 0.01 else 0.0)
        self.time += 1e-3
        self.call("SetTime", c_double(self.time if self.dice.random() < 0.97 else self.number()))
        self.call("SetContinuousStates", x, c_size_t(n if self.dice.random() < 0.97 else n - 1))
        self.call(names[1], (c_double * 64)(), c_size_t(self.dice.randrange(8)))
        self.call("GetNominalsOfContinuousStates", rates, c_size_t(n))
        self.completed()

    def end(self):
        """A reset makes it good again, whatever was done."""
        self.dice.random = lambda: 0.5
        for state in self.kept:
            self.call(self._state("Free"), byref(state))
        assert self.call("Reset") == OK
        self.instance.start()
        if self.has_events:
            self.leave_event_mode()
        if not self.exchanges:
            assert self.instance.step(0.0, 0.01) == OK, self.instance.message
        self.instance.free()


WITHIN = [
    *(Driver.get, Driver.set, Driver.step, Driver.derivatives, Driver.output_derivatives, Driver.logging),
    *(Driver.save, Driver.restore, Driver.reset, Driver.terminate, Driver.begin),
]
ALWAYS = [
    *(Driver.get, Driver.get, Driver.set, Driver.drive_inputs, Driver.derivatives, Driver.other_types),
    *(Driver.save, Driver.restore, Driver.forget, Driver.carry, Driver.logging, Driver.reset, Driver.ready),
    *(Driver.begin, Driver.initialise, Driver.terminate),
]
STEPPING = [Driver.step, Driver.steps, Driver.steps, Driver.input_derivatives, Driver.output_derivatives]
EXCHANGE = [
    Driver.solver,
    Driver.solver,
    Driver.solver,
    Driver.event,
    Driver.completed,
    Driver.output_derivatives,
]


def run(folder, version, kind, seed, n):
    """Some n calls; returns how many were made."""
    driver = Driver(folder, version, kind, seed)
    driver.ready()
    while driver.calls < n:
        driver.one()
    driver.end()
    return driver.calls


if __name__ == "__main__":
    print(run(sys.argv[1], int(sys.argv[2]), sys.argv[3], int(sys.argv[4]), int(sys.argv[5])))
