"""An FMU of FMI 2.0 at work."""

from __future__ import annotations

import ctypes
from collections.abc import Sequence
from functools import partial
from pathlib import Path
from weakref import WeakValueDictionary

from fmpy import calloc, free
from fmpy.fmi2 import (
    addLoggerProxy,
    fmi2CallbackAllocateMemoryTYPE,
    fmi2CallbackFreeMemoryTYPE,
    fmi2CallbackFunctions,
    fmi2CallbackLoggerTYPE,
    printLogMessage,
)

from .errors import CouplingError, Discarded, Ended
from .signals import Signal
from .slave import DISCARD, WARNING, Slave

CO_SIMULATION = 1
LAST_SUCCESSFUL_TIME, TERMINATED = 2, 3

_slaves: WeakValueDictionary[int, Slave2] = WeakValueDictionary()
"""Environment that an FMU passes with what it logs -> the slave."""


@fmi2CallbackLoggerTYPE
def _hear(environment, name, status, category, message):
    """What any FMU logs, for the slave that it is of.

    FMPy formats what FMUs pass as variadic arguments, but keeps one logger for all: the last one, even after
    it is gone, and for its own runs too. So this is the only one, for good.
    """
    named = (slave for slave in list(_slaves.values()) if slave.name.encode() == name)
    slave = _slaves.get(environment) or next(named, None)

    if slave:
        slave.heard(status, category, message)
    else:
        printLogMessage(environment, name, status, category, message)


class Slave2(Slave):
    """One instance of an FMU of FMI 2.0."""

    version = 2
    prefix = "fmi2"
    state_word = "FMUstate"

    def _instantiate(self, logging):
        callbacks = fmi2CallbackFunctions()
        callbacks.logger = _hear
        callbacks.allocateMemory = fmi2CallbackAllocateMemoryTYPE(calloc)
        callbacks.freeMemory = fmi2CallbackFreeMemoryTYPE(free)
        callbacks.componentEnvironment = id(self)
        addLoggerProxy(ctypes.byref(callbacks))
        self._callbacks = callbacks
        _slaves[id(self)] = self

        instantiate = self.function("Instantiate")
        instantiate.restype = ctypes.c_void_p
        component = instantiate(
            self.name.encode(),
            CO_SIMULATION,
            self.description.guid.encode(),
            (Path(self.folder or "") / "resources").as_uri().encode(),
            ctypes.byref(callbacks),
            0,
            int(logging),
        )
        if not component:
            raise CouplingError(f"{self.name}: fmi2Instantiate failed" + self.last_words())

        self.component = ctypes.c_void_p(component)

    def setup(self, start, stop):
        self.call(
            "SetupExperiment",
            0,
            ctypes.c_double(0.0),
            ctypes.c_double(start),
            int(stop is not None),
            ctypes.c_double(stop or 0.0),
        )

    def initialise(self):
        self.call("EnterInitializationMode")

    def begin(self):
        self.call("ExitInitializationMode")
        self._time, self._length = ctypes.c_double(0.0), ctypes.c_double(0.0)
        self._never_before = ctypes.c_int(1)
        self._do = partial(
            self.function("DoStep"), self.component, self._time, self._length, self._never_before
        )
        self.stepper = self._stepper()

        if self.can.rollback:
            self.prepare_states()

    def stepping(self, H):
        self._length.value = H
        return self._time, self._do, self._refused

    def _stepper(self):
        at, length, do = self._time, self._length, self._do

        def step(time, H):
            self.work += 1
            at.value = time
            length.value = H
            if (status := do()) > WARNING:
                self._refused(status, time, H)

        return step

    def _refused(self, status, time, H):
        """Raises what follows of a step that was not done."""
        if status == DISCARD:
            if self._status_of("Boolean", TERMINATED, ctypes.c_int()):
                raise Ended(self.name)

            reached = self._status_of("Real", LAST_SUCCESSFUL_TIME, ctypes.c_double())
            if reached is not None and time + 1e-9 * H < reached < time + H:
                raise Discarded(self.name, reached)

        self.check(status, "fmi2DoStep", f" at {time:.9g} s, step {H:.6g} s")

    def _status_of(self, word, kind, value):
        try:
            status = self.function(f"Get{word}Status")(self.component, kind, ctypes.byref(value))
        except CouplingError:
            return None

        return value.value if status <= WARNING else None

    def derivative_feed(self, signals: Sequence[Signal], order: int, address: int) -> partial:
        """The call that sets the inputs' derivatives of the orders 1 to `order`, which stand at the address one
        order after another.
        """
        n = len(signals) * order
        references = (ctypes.c_uint * n)(*([s.reference for s in signals] * order))
        orders = (ctypes.c_int * n)(*(k + 1 for k in range(order) for _ in signals))
        values = (ctypes.c_double * n).from_address(address)
        function = self.function("SetRealInputDerivatives", keep_lock=True)
        size = ctypes.c_size_t(n)
        return partial(function, self.component, references, size, orders, values)
