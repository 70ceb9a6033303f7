"""A master that speaks to an FMU without help: bare calls, statuses and messages as they come."""

import ctypes
from ctypes import byref, c_char_p, c_double, c_int, c_size_t, c_uint, c_void_p
from pathlib import Path

import fmpy
from fmpy.fmi2 import (
    fmi2CallbackAllocateMemoryTYPE,
    fmi2CallbackFreeMemoryTYPE,
    fmi2CallbackFunctions,
    fmi2CallbackLoggerTYPE,
    fmi2StepFinishedTYPE,
)

OK, WARNING, DISCARD, ERROR, FATAL = range(5)
MODEL_EXCHANGE, CO_SIMULATION = range(2)
DO_STEP_STATUS, PENDING_STATUS, LAST_SUCCESSFUL_TIME, TERMINATED = range(4)


class Unpacked:
    """An unpacked FMU and its shared library. fmu : None where it is unpacked already. platform : folder of the library."""

    def __init__(self, fmu: Path | None, folder: Path, platform: str):
        if fmu:
            fmpy.extract(str(fmu), str(folder))

        self.folder = Path(folder)
        self.description = fmpy.read_model_description(str(folder))
        self.variables = {v.name: v for v in self.description.modelVariables}
        identifier = self.description.coSimulation.modelIdentifier
        binary = f"binaries/{platform}/{identifier}{fmpy.sharedLibraryExtension}"
        self.dll = ctypes.CDLL(str(self.folder / binary))


class Component:
    """What instances of FMI 2.0 and 3.0 have in common; every call returns its status.

    fmi, state, undo : how functions are spelled. library, component : an `Unpacked`, what its functions know the instance by;
    None when it was refused. log : list of (status, category, message).
    """

    fmi: str
    state: str
    undo: str

    def __init__(self, library):
        self.library = library
        self.log = []

    @property
    def message(self) -> str:
        """The last message."""
        return self.log[-1][2]

    def call(self, function: str, *arguments) -> int:
        """Status of a bare call; the component comes first by itself."""
        return getattr(self.library.dll, function)(c_void_p(self.component), *arguments)

    def free(self):
        getattr(self.library.dll, f"{self.fmi}FreeInstance")(c_void_p(self.component))

    def exit(self):
        return self.call(f"{self.fmi}ExitInitializationMode")

    def save(self, snapshot: c_void_p | None = None) -> c_void_p:
        snapshot = c_void_p() if snapshot is None else snapshot
        assert self.call(f"{self.fmi}Get{self.state}", byref(snapshot)) == OK
        return snapshot

    def restore(self, snapshot: c_void_p) -> int:
        return self.call(f"{self.fmi}Set{self.state}", snapshot)

    def forget(self, snapshot: c_void_p) -> int:
        return self.call(f"{self.fmi}Free{self.state}", byref(snapshot))

    def serialise(self, snapshot: c_void_p) -> bytes:
        size = c_size_t()
        assert self.call(f"{self.fmi}Serialized{self.state}Size", snapshot, byref(size)) == OK
        data = ctypes.create_string_buffer(size.value)
        assert self.call(f"{self.fmi}Serialize{self.state}", snapshot, data, size) == OK
        return data.raw

    def deserialise(self, data: bytes) -> tuple[int, c_void_p]:
        snapshot = c_void_p()
        status = self.call(f"{self.fmi}{self.undo}{self.state}", data, c_size_t(len(data)), byref(snapshot))
        return status, snapshot


class Library(Unpacked):
    """Of FMI 2.0."""

    def __init__(self, fmu: Path | None, folder: Path):
        super().__init__(fmu, folder, fmpy.platform)
        self.dll.fmi2Instantiate.restype = c_void_p

    def reference(self, name: str) -> int:
        """Value reference of a variable."""
        return self.variables[name].valueReference

    def references(self, causality: str) -> list[int]:
        """Value references of the inputs, outputs or parameters."""
        return [v.valueReference for v in self.variables.values() if v.causality == causality]


class Instance(Component):
    """One instance. An empty guid or location is passed as NULL; the default is the right one."""

    fmi, state, undo = "fmi2", "FMUstate", "DeSerialize"

    def __init__(
        self,
        library,
        name=b"it",
        guid=None,
        location=None,
        kind=CO_SIMULATION,
        logging=True,
        callbacks=True,
    ):
        super().__init__(library)
        self.callbacks = fmi2CallbackFunctions()
        self.callbacks.logger = fmi2CallbackLoggerTYPE(self._logger)
        self.callbacks.allocateMemory = fmi2CallbackAllocateMemoryTYPE()
        self.callbacks.freeMemory = fmi2CallbackFreeMemoryTYPE()
        self.callbacks.stepFinished = fmi2StepFinishedTYPE()
        guid = library.description.guid.encode() if guid is None else guid
        if location is None:
            location = (library.folder / "resources").as_uri().encode()
        given = byref(self.callbacks) if callbacks else None
        texts = c_char_p(guid or None), c_char_p(location or None)
        self.component = library.dll.fmi2Instantiate(c_char_p(name), kind, *texts, given, 0, int(logging))

    def _logger(self, environment, name, status, category, message):
        self.log.append((status, category.decode(), message.decode()))
        self.after_message()

    def after_message(self):
        """After each message."""

    # life

    def setup(self, start=0.0, stop=None):
        stop = (0, c_double(0)) if stop is None else (1, c_double(stop))
        return self.call("fmi2SetupExperiment", 0, c_double(0), c_double(start), *stop)

    def enter(self):
        return self.call("fmi2EnterInitializationMode")

    def start(self, start=0.0, stop=None):
        """Up to the first step."""
        assert self.setup(start, stop) == self.enter() == self.exit() == OK
        return self

    def reset(self):
        return self.call("fmi2Reset")

    def terminate(self):
        return self.call("fmi2Terminate")

    # values

    def set(self, values: dict[int | str, float]) -> int:
        """By name or value reference."""
        keys = [self.library.reference(k) if isinstance(k, str) else k for k in values]
        n = len(keys)
        numbers = (c_double * n)(*values.values())
        return self.call("fmi2SetReal", (c_uint * n)(*keys), c_size_t(n), numbers)

    def set_derivatives(self, name: str | int, order: int, value: float) -> int:
        key = self.library.reference(name) if isinstance(name, str) else name
        given = (c_uint * 1)(key), c_size_t(1), (c_int * 1)(order), (c_double * 1)(value)
        return self.call("fmi2SetRealInputDerivatives", *given)

    def get(self, *keys: int | str) -> tuple[int, list[float]]:
        """Status and values."""
        keys = [self.library.reference(k) if isinstance(k, str) else k for k in keys]
        n = len(keys)
        values = (c_double * n)()
        return self.call("fmi2GetReal", (c_uint * n)(*keys), c_size_t(n), values), list(values)

    def value(self, name: str) -> float:
        status, values = self.get(name)
        assert status == OK
        return values[0]

    def outputs(self) -> list[float]:
        """All outputs; they must be had."""
        status, values = self.get(*self.library.references("output"))
        assert status == OK
        return values

    def along(self, unknowns: list[str], knowns: list[str], seed: list[float]) -> tuple[int, list[float]]:
        """Status and derivatives of unknowns by knowns along a seed."""
        ends = []

        for names in (unknowns, knowns):
            keys = [self.library.reference(name) for name in names]
            ends += [(c_uint * len(keys))(*keys), c_size_t(len(keys))]

        result = (c_double * len(unknowns))()
        given = (c_double * len(seed))(*seed)
        return self.call("fmi2GetDirectionalDerivative", *ends, given, result), list(result)

    def output_derivatives(self, names: list[str], order: int) -> tuple[int, list[float]]:
        """Status and derivatives of outputs by time."""
        keys = (c_uint * len(names))(*map(self.library.reference, names))
        result = (c_double * len(names))()
        orders = (c_int * len(names))(*[order] * len(names))
        return self.call("fmi2GetRealOutputDerivatives", keys, c_size_t(len(names)), orders, result), list(
            result
        )

    # steps

    def step(self, t: float, H: float) -> int:
        return self.call("fmi2DoStep", c_double(t), c_double(H), 0)

    def last_successful_time(self) -> tuple[int, float]:
        value = c_double(float("nan"))
        return self.call("fmi2GetRealStatus", LAST_SUCCESSFUL_TIME, byref(value)), value.value

    def terminated(self) -> tuple[int, int]:
        value = c_int(-1)
        return self.call("fmi2GetBooleanStatus", TERMINATED, byref(value)), value.value


def warnings_of_runs(fmu, H, n, chosen):
    """What `chosen` keeps of the warnings of n steps of H (s), in turn: of a run, of it again from a snapshot, and after a reset."""
    snapshot = fmu.save()

    def said():
        fmu.log.clear()
        assert all(fmu.step(H * k, H) == OK for k in range(n))
        return chosen(text for status, _, text in fmu.log if status == WARNING)

    first = said()
    assert fmu.restore(snapshot) == OK
    restored = said()
    assert fmu.reset() == OK
    fmu.start()
    return first, restored, said()
