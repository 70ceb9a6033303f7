"""A master of FMI 3.0 that speaks to an FMU without help: bare calls, statuses and messages as they come."""

import ctypes
from ctypes import byref, c_bool, c_char_p, c_double, c_int, c_size_t, c_uint, c_void_p
from math import prod
from pathlib import Path

import fmpy
from fmu_host import OK, Component, Unpacked

_ASKED = ctypes.POINTER(c_bool), ctypes.POINTER(c_double)
UPDATE = ctypes.CFUNCTYPE(None, c_void_p, c_double, c_bool, c_bool, c_bool, c_bool, *_ASKED)
LOGGER = ctypes.CFUNCTYPE(None, c_void_p, c_int, c_char_p, c_char_p)


class Library(Unpacked):
    """Of FMI 3.0."""

    def __init__(self, fmu: Path | None, folder: Path):
        super().__init__(fmu, folder, fmpy.platform_tuple)
        self.instantiate = {
            kind: getattr(self.dll, f"fmi3Instantiate{kind}")
            for kind in ("ModelExchange", "CoSimulation", "ScheduledExecution")
        }
        for function in self.instantiate.values():
            function.restype = c_void_p

    def length(self, name: str) -> int:
        """How many values a variable has."""
        return prod(int(d.start) for d in self.variables[name].dimensions)

    def names(self, causality: str) -> list[str]:
        """Names of the inputs, outputs or parameters."""
        return [v.name for v in self.variables.values() if v.causality == causality]


class Instance(Component):
    """One instance. An empty token is passed as NULL; the default is the right one."""

    fmi, state, undo = "fmi3", "FMUState", "Deserialize"

    def __init__(
        self,
        library,
        name=b"it",
        token=None,
        path=None,
        kind="CoSimulation",
        logging=True,
        extra=None,
        update=None,
    ):
        super().__init__(library)
        self.logger = LOGGER(self._logger)
        token = library.description.guid.encode() if token is None else token
        path = f"{library.folder / 'resources'}/".encode() if path is None else path
        first = (
            c_char_p(name),
            c_char_p(token or None),
            c_char_p(path or None),
            c_bool(False),
            c_bool(logging),
        )
        own = extra or (c_bool(False), c_bool(False), None, c_size_t(0))
        last = {"ModelExchange": (), "CoSimulation": (update,), "ScheduledExecution": (None, None, None)}[
            kind
        ]
        more = own if kind == "CoSimulation" else ()
        self.component = library.instantiate[kind](*first, *more, None, self.logger, *last)

    def _logger(self, _, status, category, message):
        self.log.append((status, category.decode(), message.decode()))
        self.after_message()

    def after_message(self):
        """After each message."""

    # life

    def enter(self, start=0.0, stop=None, tolerance=None):
        end = (c_bool(stop is not None), c_double(stop or 0.0))
        given = (c_bool(tolerance is not None), c_double(tolerance or 0.0))
        return self.call("fmi3EnterInitializationMode", *given, c_double(start), *end)

    def start(self, start=0.0, stop=None):
        """Up to the first step."""
        assert self.enter(start, stop) == self.exit() == OK
        return self

    # values: arrays by rows

    def _references(self, keys):
        keys = [self.library.variables[k].valueReference if isinstance(k, str) else k for k in keys]
        return (c_uint * len(keys))(*keys), c_size_t(len(keys))

    def set(self, values: dict[int | str, float | list[float]]) -> int:
        flat = [x for value in values.values() for x in (value if isinstance(value, list) else [value])]
        numbers = (c_double * len(flat))(*flat)
        return self.call("fmi3SetFloat64", *self._references(values), numbers, c_size_t(len(flat)))

    def get(self, *keys: int | str, room=None) -> tuple[int, list[float]]:
        """Status and values."""
        if room is None:
            room = sum(self.library.length(k) if isinstance(k, str) else 1 for k in keys)

        values = (c_double * room)()
        status = self.call("fmi3GetFloat64", *self._references(keys), values, c_size_t(room))
        return status, list(values)

    def outputs(self) -> list[float]:
        """All outputs; they must be had."""
        status, values = self.get(*self.library.names("output"))
        assert status == OK
        return values

    def derivatives(
        self, kind: str, unknowns, knowns, seed: list[float], room: int
    ) -> tuple[int, list[float]]:
        """Status and values; kind: "Directional" or "Adjoint"; `room` of these."""
        given, result = (c_double * len(seed))(*seed), (c_double * room)()
        ends = *self._references(unknowns), *self._references(knowns), given, c_size_t(len(seed))
        return self.call(f"fmi3Get{kind}Derivative", *ends, result, c_size_t(room)), list(result)

    def output_derivatives(self, names: list[str], order: int) -> tuple[int, list[float]]:
        """Status and derivatives of outputs by time."""
        result = (c_double * sum(map(self.library.length, names)))()
        orders = (c_int * len(names))(*[order] * len(names))
        given = *self._references(names), orders, result, c_size_t(len(result))
        return self.call("fmi3GetOutputDerivatives", *given), list(result)

    # steps

    def step(self, t: float, H: float) -> int:
        """The status; `told` is (event, terminate, early return, time)."""
        told = c_bool(True), c_bool(True), c_bool(True), c_double(float("nan"))
        given = c_double(t), c_double(H), c_bool(True)
        status = self.call("fmi3DoStep", *given, *map(byref, told))
        self.told = tuple(place.value for place in told)
        return status
