"""An unpacked FMU in model exchange, and runs of it, by the classical method of Runge and Kutta."""

import math
from collections import Counter
from ctypes import POINTER, c_double

import numpy as np
from fmpy.fmi2 import FMU2Model
from fmpy.fmi3 import FMU3Model

from .fmu import REAL, Fmu, Refused, Run, apart

PARTS = (4, 32, 256)
"""Steps of the solver in each step of a run: the first with which the next tell the same, to 1 %."""

KINDS_OF_EVENTS = ("of steps", "of time", "of states")

_DOUBLES = POINTER(c_double)

MOST_UPDATES = 100
"""Of discrete states at one event."""


class Exchanged(Fmu):
    """An FMU that gives rates; derivatives are of these too, and by its states."""

    kind = "ModelExchange"

    def __init__(self, folder):
        super().__init__(folder)
        self.rates = [u.variable for u in self.description.derivatives]
        self.states = [v.derivative for v in self.rates]
        # an output that is a state itself is no function of states
        self.unknowns = self.rates + [v for v in self.outputs if v.type in REAL and v not in self.states]
        # others may be set at events alone
        self.inputs = [v for v in self.inputs if v.variability == "continuous"]
        self.knowns = self.states + self.inputs
        self.n = sum(map(self.size, self.states))
        # FMI 3 turned the flag round
        self.completes = (
            self.claims("needsCompletedIntegratorStep")
            if self.version == 3
            else not self.claims("completedIntegratorStepNotNeeded")
        )
        self.parts = 0

    @property
    def told(self) -> str:
        return f", in {self.parts} parts each"

    def new(self, name="it", starts=()) -> "ExchangeRun":
        if not self.parts:
            self.parts = self._parts()

        return ExchangeRun(self, name, starts)

    def columns(self) -> list[str]:
        return super().columns() + [v.name for v in self.states for _ in range(self.size(v))]

    def _parts(self):
        """How many steps of the solver a step of a run takes."""
        found: list = []

        for n in PARTS if self.n else PARTS[:1]:
            self.parts = n
            try:
                rows = ExchangeRun(self, f"trial {n}").drive()
            except Refused:
                found.clear()
                continue
            if found and apart(found[-1][1], rows) < 0.01:
                return found[-1][0]
            found.append((n, rows))

        return self.parts


class ExchangeRun(Run):
    """An instance in continuous time, at time t with states x; what it does wrong on its way is in `wrong`.

    happened : how often there was an event of each kind.
    """

    fmu: "Exchanged"
    kinds = {2: FMU2Model, 3: FMU3Model}

    def begin(self, starts=()):
        super().begin(starts)
        self.t = self.fmu.start
        self.next_time = math.inf
        self.happened: Counter = Counter()
        self.wrong: set[str] = set()
        self.n_indicators = (
            self.fmu.description.numberOfEventIndicators
            if self.fmu.version == 2
            else self.call("getNumberOfEventIndicators")
        )
        self.update()

    # vectors

    def _vector(self, function, n):
        buffer = np.zeros(n)
        if n:
            self.call(function, buffer.ctypes.data_as(_DOUBLES), n)
        return buffer

    @property
    def x(self):
        return self._vector("getContinuousStates", self.fmu.n)

    def rates(self):
        name = "getDerivatives" if self.fmu.version == 2 else "getContinuousStateDerivatives"
        return self._vector(name, self.fmu.n)

    def nominals(self):
        return self._vector("getNominalsOfContinuousStates", self.fmu.n)

    def indicators(self):
        return self._vector("getEventIndicators", self.n_indicators)

    def go(self, t, x):
        """To a time and a state, with the inputs of that time."""
        self.t = t
        self.call("setTime", t)
        self.set_x(x)
        self.set(self.fmu.inputs, self.fmu.inputs_at(t))

    def set_x(self, x):
        x = np.array(x, float)
        if len(x):
            self.call("setContinuousStates", x.ctypes.data_as(_DOUBLES), len(x))

    def put(self, variable, values):
        at = 0

        for state in self.fmu.states:
            n = self.fmu.size(state)
            if state is variable:
                x = self.x
                x[at : at + n] = values
                self.set_x(x)
                return
            at += n

        super().put(variable, values)

    def outputs(self):
        return super().outputs() + list(self.x)

    # from event to event

    def update(self):
        """Discrete states until none is new, and on in continuous time."""
        for _ in range(MOST_UPDATES):
            before = self.x
            again, ended, _, changed, more, time = self.call(
                "newDiscreteStates" if self.fmu.version == 2 else "updateDiscreteStates"
            )
            if not changed and not np.array_equal(before, self.x):
                self.wrong.add("an event changes states and does not say so")
            if ended:
                raise Refused(f"it ends the simulation at {self.t:g} s")
            if not again:
                break
        else:
            raise Refused(f"discrete states are new after {MOST_UPDATES} updates at {self.t:g} s")

        self.next_time = time if more else math.inf
        if self.next_time < self.t:
            self.wrong.add(f"the next event is at {self.next_time:g} s, which was before")
        self.call("enterContinuousTimeMode")
        self.signs = self.indicators() > 0

    def event(self):
        self.call("enterEventMode")
        self.update()

    def solve(self, to):
        """A step of the solver, and the event at its end if there is one."""
        t, x = self.t, self.x
        h = to - t
        slopes = []
        for part, last in ((0.0, None), (0.5, 0), (0.5, 1), (1.0, 2)):
            self.go(t + part * h, x if last is None else x + part * h * slopes[last])
            slopes.append(self.rates())
        k1, k2, k3, k4 = slopes
        self.go(to, x + h / 6 * (k1 + 2 * k2 + 2 * k3 + k4))

        asked = False
        if self.fmu.completes:
            before = self.x
            asked, ended = self.call("completedIntegratorStep")
            if not asked and not np.array_equal(before, self.x):
                self.wrong.add("the end of a step changes states and asks for no event")
            if ended:
                raise Refused(f"it ends the simulation at {self.t:g} s")

        changed = not np.array_equal(self.signs, self.indicators() > 0)
        reasons = dict(zip(KINDS_OF_EVENTS, (asked, self.t >= self.next_time, changed)))
        self.happened.update(kind for kind, is_one in reasons.items() if is_one)
        if any(reasons.values()):
            self.event()

    def drive(self, first=0, last=None):
        """Outputs and states after each of some steps.

        It begins with an event: a state that was restored does not tell the next one.
        """
        rows = []
        times = [*self.fmu.times(), self.fmu.start + self.fmu.steps * self.fmu.step]
        until = len(times) - 1 if last is None else last
        self.t = times[first]
        self.event()

        for t, end in zip(times[first:until], times[first + 1 :]):
            for k in range(self.fmu.parts):
                to = t + (end - t) * (k + 1) / self.fmu.parts
                if self.t < self.next_time < to:
                    self.solve(self.next_time)
                self.solve(to)
            rows.append(self.outputs())

        return rows
