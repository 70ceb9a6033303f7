"""An FMU at work, whatever the version of FMI: raw calls on buffers that are there before the run."""

from __future__ import annotations

import ctypes
import os
from collections import deque
from collections.abc import Callable, Iterable, Sequence
from contextlib import contextmanager
from functools import partial
from pathlib import Path
from shutil import rmtree
from typing import Any

import fmpy
import numpy as np

from .errors import CouplingError
from .signals import TYPES, Signal, capabilities

OK, WARNING, DISCARD = 0, 1, 2
STATUS = ("OK", "warning", "discard", "error", "fatal", "pending")

LINES = 12
"""Lines of its log that are kept."""


class Channel:
    """Signals of one group that are moved by one call, to or from `values` (as many as there are elements).

    places : of each signal, in `values`. move : the call, which returns a status.
    """

    def __init__(self, slave: Slave, verb: str, signals: Sequence[Signal], address: int | None = None):
        group = signals[0].group
        kind = next(c for _, name, c in TYPES[slave.version].values() if name == group)
        sizes = {s.reference: s.size for s in signals}
        first = dict(zip(sizes, np.cumsum([0, *sizes.values()]).tolist()))
        n = sum(sizes.values())
        self.signals = list(signals)
        self.places = [first[s.reference] + s.element for s in signals]
        self.values = (kind * n).from_address(address) if address else (kind * n)()
        self._references = (ctypes.c_uint * len(sizes))(*sizes)
        self.n = n
        function = slave.function(f"{verb}{group}", keep_lock=True)
        counts = [ctypes.c_size_t(n)] if slave.version == 3 else []
        self.call = f"{slave.prefix}{verb}{group}"
        self.move = partial(
            function,
            slave.component,
            ctypes.byref(self._references),
            ctypes.c_size_t(len(sizes)),
            ctypes.byref(self.values),
            *counts,
        )

    @staticmethod
    def elements(signals: Iterable[Signal]) -> int:
        """The number of values that a channel of these signals moves."""
        return sum({s.reference: s.size for s in signals}.values())


class Slave:
    """One instance of an FMU for co-simulation; `Slave2` and `Slave3` know the versions of FMI.

    name : in the system. can : its Capabilities. log : the last lines that it logged; logs : whether its debug log is on. work : doSteps so far.
    """

    version = 0
    prefix = ""

    def __init__(self, name: str, path: str | Path, description):
        self.name, self.path, self.description = name, Path(path), description
        self.can = capabilities(description)
        self.log: deque[str] = deque(maxlen=LINES)
        self.logs = False
        self.told: list[str] = []
        self.work = 0
        self.component: Any = None
        self.events = 0
        self._states: list[ctypes.c_void_p] = []
        self.folder: str | None = None

    # life

    def open(self, logging: bool = False):
        """Unpacks, loads and instantiates it. Raises CouplingError."""
        interface = self.description.coSimulation
        self.logs = logging
        self.folder = fmpy.extract(str(self.path))
        library = self._library(Path(self.folder), interface.modelIdentifier)
        before = os.getcwd()

        try:
            # libraries beside it are found from its own folder
            os.chdir(library.parent)
            self.dll = ctypes.CDLL(str(library))
        except OSError as error:
            raise CouplingError(f"{self.name}: its library cannot be loaded: {error}") from error
        finally:
            os.chdir(before)

        self._locked = ctypes.PyDLL(None, handle=self.dll._handle)
        self._instantiate(logging)

    def _library(self, folder, identifier):
        names = [self.folder_name, *(["darwin64"] if self.folder_name == "aarch64-darwin" else [])]
        places = [folder / "binaries" / name / f"{identifier}{fmpy.sharedLibraryExtension}" for name in names]
        found = next((place for place in places if place.is_file()), None)

        if found is None:
            there = sorted(p.name for p in (folder / "binaries").glob("*")) or ["none"]
            raise CouplingError(
                f"{self.name}: {self.path} has no library for this machine ({self.folder_name}); it has those for "
                f"{', '.join(there)}"
            )

        return found

    @property
    def folder_name(self) -> str:
        """The folder of this machine's library."""
        return fmpy.platform if self.version == 2 else fmpy.platform_tuple

    def _instantiate(self, logging):
        raise NotImplementedError

    def close(self, well: bool = True):
        """Ends it; `well`: it may be terminated as FMI wants it."""
        if self.component:
            for state in self._states:
                self.function("Free" + self.state_word)(self.component, ctypes.byref(state))
            if well:
                self.function("Terminate")(self.component)

            free = self.function("FreeInstance")
            free.restype = None
            free(self.component)
            self.component = None

        if self.folder:
            if hasattr(self, "dll"):
                fmpy.freeLibrary(self.dll._handle)
            rmtree(self.folder, ignore_errors=True)
            self.folder = None

    # calls

    def function(self, name: str, keep_lock: bool = False) -> Any:
        """A function of the FMU by its name without prefix; keep_lock: short ones need not let other threads run."""
        library = self._locked if keep_lock else self.dll

        try:
            # a fresh object, whose argument types are those of the objects that are passed
            return library[self.prefix + name]
        except AttributeError:
            raise CouplingError(f"{self.name}: its library has no function {self.prefix}{name}") from None

    def call(self, name: str, *arguments: Any):
        """Calls a function on the instance. Raises CouplingError, with the FMU's own words."""
        self.check(self.function(name)(self.component, *arguments), self.prefix + name)

    def check(self, status: int, what: str, when: str = ""):
        """Raises CouplingError for a status that is none to go on with."""
        if status > WARNING:
            word = STATUS[status] if status < len(STATUS) else f"status {status}"
            raise CouplingError(f"{self.name}: {what} failed ({word}){when}" + self.last_words())

    def last_words(self) -> str:
        """What it logged last, to follow a message."""
        if self.log:
            return "; its log: " + " | ".join(list(self.log)[-4:])
        return (
            "" if self.logs else f"; it logged nothing: [fmu.{self.name}] log = true asks for its debug log"
        )

    def heard(self, status: int, category: bytes | None, message: bytes | None):
        """Keeps a line of its log."""
        text = (message or b"").decode("utf-8", "replace").strip()
        word = STATUS[status] if 0 <= status < len(STATUS) else str(status)
        self.log.append(f"[{word}] {text}")

        if status == WARNING and text not in self.told and len(self.told) < LINES:
            self.told.append(text)

    # values

    def write(self, signal: Signal, value: Any):
        """Sets one scalar, others of its array as they are. Raises CouplingError."""
        self.write_all([signal], [value])

    def write_all(self, signals: Sequence[Signal], values: Sequence[Any]):
        """Sets scalars, by groups; of an array in part the rest stays as it is. Raises CouplingError."""
        pairs = list(zip(signals, values))

        for group in dict.fromkeys(s.group for s in signals):
            some = [(s, v) for s, v in pairs if s.group == group]
            channel = Channel(self, "Set", [s for s, _ in some])

            if channel.n > len(some):
                there = Channel(self, "Get", [s for s, _ in some])
                self.check(there.move(), there.call)
                channel.values[:] = there.values[:]

            for (_, value), place in zip(some, channel.places):
                channel.values[place] = value

            self.check(channel.move(), channel.call)

    def read_all(self, signals: Sequence[Signal]) -> list[Any]:
        """Values of scalars. Raises CouplingError."""
        found: dict[Signal, Any] = {}

        for group in dict.fromkeys(s.group for s in signals):
            some = [s for s in signals if s.group == group]
            channel = Channel(self, "Get", some)
            self.check(channel.move(), channel.call)
            found |= {s: channel.values[place] for s, place in zip(some, channel.places)}

        return [found[s] for s in signals]

    def derivatives(self, outputs: Sequence[Signal], inputs: Sequence[Signal]) -> np.ndarray | None:
        """d outputs / d inputs at this instant, by the FMU's own directional derivatives; None where it has none."""
        if self.version != 2 or not self.can.directional_derivatives:
            return None

        function = self.function("GetDirectionalDerivative")
        unknown = (ctypes.c_uint * len(outputs))(*(s.reference for s in outputs))
        values, one = (ctypes.c_double * len(outputs))(), (ctypes.c_double * 1)(1.0)
        J = np.zeros((len(outputs), len(inputs)))

        for k, signal in enumerate(inputs):
            known = (ctypes.c_uint * 1)(signal.reference)
            counts = ctypes.c_size_t(len(outputs)), ctypes.c_size_t(1)
            status = function(self.component, unknown, counts[0], known, counts[1], one, values)

            if status > WARNING or not np.all(np.isfinite(values)):
                return None

            J[:, k] = values

        return J

    # states

    state_word = ""

    _never_before: Any
    """noSetFMUStatePriorToCurrentPoint, which a doStep is told: true, as states are restored at the start of the step at the
    earliest. Some FMUs go back by themselves in each step when they are told otherwise.
    """

    @contextmanager
    def going_back(self, may: bool):
        """For steps within a step of the master: whether a state at its start may be restored yet."""
        self._never_before.value = not may

        try:
            yield
        finally:
            self._never_before.value = True

    def keep(self, slot: int = 0) -> int:
        """Saves its state; returns the status. A slot is written over by the next call."""
        while len(self._states) <= slot:
            self._states.append(ctypes.c_void_p())

        return self._keep(self.component, ctypes.byref(self._states[slot]))

    def back(self, slot: int = 0) -> int:
        """Goes back to a saved state; returns the status."""
        return self._back(self.component, self._states[slot])

    def prepare_states(self):
        """Finds the calls that save and restore."""
        self._keep = self.function("Get" + self.state_word, keep_lock=True)
        self._back = self.function("Set" + self.state_word, keep_lock=True)

    def serialised(self) -> bytes:
        """Its state now, as bytes. Raises CouplingError."""
        self.prepare_states()
        self.check(self.keep(1), "saving its state")
        state, size = self._states[1], ctypes.c_size_t()
        word = self.state_word
        self.call(f"Serialized{word}Size", state, ctypes.byref(size))
        data = ctypes.create_string_buffer(size.value)
        self.call(f"Serialize{word}", state, data, size)
        return data.raw

    # to be given by the versions

    def setup(self, start: float, stop: float | None):
        """From the instance to initialisation mode. Raises CouplingError."""
        raise NotImplementedError

    def initialise(self):
        """Into initialisation mode. Raises CouplingError."""
        raise NotImplementedError

    def begin(self):
        """From initialisation mode to steps. Raises CouplingError."""
        raise NotImplementedError

    def stepping(self, H: float) -> tuple[Any, Callable[[], int], Callable[[int, float, float], Any]]:
        """(the time of the next step, in C; a call that does one of H (s), and is not counted; what raises what follows of its
        status, a time and H).
        """
        raise NotImplementedError

    stepper: Callable[[float, float], None]
    """Advances from a time by a step (s). Raises CouplingError, Discarded, Ended."""
