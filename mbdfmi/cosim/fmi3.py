"""An FMU of FMI 3.0 at work: with events within a step, and steps that return early."""

from __future__ import annotations

import ctypes
import os
from functools import partial
from pathlib import Path

from fmpy.fmi3 import fmi3IntermediateUpdateCallback, fmi3LogMessageCallback

from .errors import CouplingError, Discarded, Ended
from .slave import DISCARD, WARNING, Slave

ROUNDS = 1000
"""Early returns, or rounds of an event, that one step may have."""


class Slave3(Slave):
    """One instance of an FMU of FMI 3.0."""

    version = 3
    prefix = "fmi3"
    state_word = "FMUState"

    def _instantiate(self, logging):
        self._callback = fmi3LogMessageCallback(
            lambda _environment, status, category, message: self.heard(status, category, message)
        )
        instantiate = self.function("InstantiateCoSimulation")
        instantiate.restype = ctypes.c_void_p
        boolean = ctypes.c_bool
        component = instantiate(
            self.name.encode(),
            self.description.instantiationToken.encode(),
            (str(Path(self.folder or "") / "resources") + os.sep).encode(),
            boolean(False),
            boolean(logging),
            boolean(self.can.event_mode),
            boolean(self.can.event_mode),
            None,
            ctypes.c_size_t(0),
            None,
            self._callback,
            fmi3IntermediateUpdateCallback(),
        )
        if not component:
            raise CouplingError(f"{self.name}: fmi3InstantiateCoSimulation failed" + self.last_words())

        self.component = ctypes.c_void_p(component)

    def setup(self, start, stop):
        self._span = start, stop

    def initialise(self):
        start, stop = self._span
        self.call(
            "EnterInitializationMode",
            ctypes.c_bool(False),
            ctypes.c_double(0.0),
            ctypes.c_double(start),
            ctypes.c_bool(stop is not None),
            ctypes.c_double(stop or 0.0),
        )

    def begin(self):
        self.call("ExitInitializationMode")

        if self.can.event_mode:
            self._events()
            self.call("EnterStepMode")

        self._time, self._length = ctypes.c_double(0.0), ctypes.c_double(0.0)
        self._event, self._end, self._early = ctypes.c_bool(), ctypes.c_bool(), ctypes.c_bool()
        self._reached = ctypes.c_double()
        self._never_before = ctypes.c_bool(True)
        told = self._event, self._end, self._early, self._reached
        self._do = partial(
            self.function("DoStep"),
            self.component,
            self._time,
            self._length,
            self._never_before,
            *(ctypes.byref(value) for value in told),
        )

        if self.can.rollback:
            self.prepare_states()

    def stepping(self, H):
        self._length.value = H

        def do():
            self.work -= 1
            self.stepper(self._time.value, H)
            return 0

        return self._time, do, self.check

    def stepper(self, time, H):
        self.work += 1
        self._time.value = time
        self._length.value = H
        self._early.value = self._event.value = self._end.value = False
        status = self._do()

        if status > WARNING:
            if status == DISCARD and time + 1e-9 * H < self._reached.value < time + H:
                raise Discarded(self.name, self._reached.value)

            self.check(status, "fmi3DoStep", f" at {time:.9g} s, step {H:.6g} s")

        if self._end.value:
            raise Ended(self.name)
        if self._event.value or self._early.value:
            self._go_on(time, H)

    def _go_on(self, time, H):
        """What is left of a step after an early return, events on the way handled."""
        end = time + H

        for _ in range(ROUNDS):
            if self._event.value and self.can.event_mode:
                self.events += 1
                self.call("EnterEventMode")
                self._events()
                self.call("EnterStepMode")

            reached = self._reached.value
            if not self._early.value or end - reached <= 1e-12 * max(1.0, abs(end)):
                return

            self.work += 1
            self._time.value, self._length.value = reached, end - reached
            self._early.value = self._event.value = False
            with self.going_back(self.can.rollback):
                self.check(self._do(), "fmi3DoStep", f" at {reached:.9g} s")

            if self._end.value:
                raise Ended(self.name)

        raise CouplingError(
            f"{self.name}: returned early {ROUNDS} times between {time:.9g} and {end:.9g} s"
            + self.last_words()
        )

    def _events(self):
        """Discrete states brought up to date. Raises CouplingError."""
        again, end = ctypes.c_bool(True), ctypes.c_bool()
        nominals, values, defined = ctypes.c_bool(), ctypes.c_bool(), ctypes.c_bool()
        following = ctypes.c_double()
        told = again, end, nominals, values, defined, following

        for _ in range(ROUNDS):
            self.call("UpdateDiscreteStates", *(ctypes.byref(value) for value in told))

            if end.value:
                raise Ended(self.name)
            if not again.value:
                return

        raise CouplingError(f"{self.name}: an event has no end" + self.last_words())
