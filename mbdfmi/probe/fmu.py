"""An unpacked FMU of any maker, and runs of it in co-simulation."""

import math
import os

import fmpy
import numpy as np
from fmpy.fmi1 import FMICallException
from fmpy.fmi2 import FMU2Slave
from fmpy.fmi3 import FMU3Slave
from lxml import etree

REAL = ("Real", "Float64")
INTEGERS = [f"{sign}Int{bits}" for sign in ("", "U") for bits in (8, 16, 32, 64)]
NUMBERS = (*REAL, "Float32", "Integer", "Enumeration", "Boolean", *INTEGERS)

STEPS = 40
"""Of a run."""


def apart(a, b) -> float:
    """The largest difference, of each column's largest value."""
    a, b = np.array(a, float), np.array(b, float)
    size = np.abs(a).max(axis=0) + 1e-12
    return float(np.nanmax(np.abs(a - b) / size, initial=0.0))


class Refused(Exception):
    """A call that must work did not; the text says which."""


class Fmu:
    """A folder with an unpacked FMU, what of it can be asked, and how it is to be run: in co-simulation.

    inputs, parameters : of type real. outputs : all that are numbers. unknowns, knowns : what derivatives are
    of and by, of type real.
    """

    kind = "CoSimulation"
    """What its flags are called in the description."""

    def __init__(self, folder):
        self.folder = str(folder)
        self.description = fmpy.read_model_description(self.folder)
        self.flags = getattr(self.description, self.kind[0].lower() + self.kind[1:])
        self.version = int(self.description.fmiVersion[0])
        element = etree.parse(os.path.join(self.folder, "modelDescription.xml")).find(self.kind)
        self.claimed = dict(element.attrib) if element is not None else {}
        variables = [v for v in self.description.modelVariables if self.size(v)]
        self.inputs = [v for v in variables if v.causality == "input" and v.type in REAL]
        self.outputs = [v for v in variables if v.causality == "output" and v.type in NUMBERS]
        self.parameters = [
            v
            for v in variables
            if v.causality == "parameter" and v.type in REAL and v.start not in (None, "")
        ]
        self.unknowns = [v for v in self.outputs if v.type in REAL]
        self.knowns = self.inputs
        experiment = self.description.defaultExperiment
        start, stop, step = (
            float(value) if (value := getattr(experiment, name, None)) else None
            for name in ("startTime", "stopTime", "stepSize")
        )
        self.start = start or 0.0
        self.held = False
        internal = getattr(self.description.coSimulation, "fixedInternalStepSize", None)
        self.step = step or float(internal or 0.01)
        self.steps = STEPS

        if stop and stop > self.start:
            self.steps = max(4, min(STEPS, round((stop - self.start) / self.step)))

    @property
    def told(self) -> str:
        """More about its steps."""
        return ""

    def new(self, name="it", starts=()) -> "Run":
        """An instance that is ready to run."""
        return Run(self, name, starts)

    def columns(self) -> list[str]:
        """Names of what a run tells, each as often as it has elements."""
        return [v.name for v in self.outputs for _ in range(self.size(v))]

    def structure(self) -> dict:
        """Name of an unknown -> the variables that it depends on; None: on all."""
        listed = [*self.description.outputs, *self.description.derivatives]
        return {u.variable.name: u.dependencies for u in listed if u.variable}

    def claims(self, *names: str) -> bool:
        """Whether a flag, as either version calls it, is true; fmpy does not tell all."""
        return any(self.claimed.get(name) in ("true", "1") for name in names)

    def size(self, variable) -> int:
        """How many numbers a variable is."""
        return math.prod(variable.shape or ())

    def start_of(self, variable) -> np.ndarray:
        """Its start values."""
        given = str(variable.start if variable.start not in (None, "") else 0.0).split()
        return np.resize(np.array([float(x) for x in given]), self.size(variable))

    def reach(self, variable) -> tuple[np.ndarray, np.ndarray]:
        """About what an input, or a parameter, moves between: by its size, within its limits."""
        start = self.start_of(variable)
        span = np.where(start == 0, float(variable.nominal or 1.0), 0.1 * np.abs(start))
        low = -np.inf if variable.min is None else float(variable.min)
        high = np.inf if variable.max is None else float(variable.max)
        return np.maximum(start - span, low), np.minimum(start + span, high)

    def inputs_at(self, t: float) -> list[float]:
        """All inputs at a time (s): smooth, each of its own, unless they are held."""
        if self.held:
            return [float(x) for v in self.inputs for x in self.start_of(v)]

        values = []

        for k, variable in enumerate(self.inputs):
            low, high = self.reach(variable)
            phase = 2 * math.pi * (t - self.start) / (self.steps * self.step)
            values += list(self.start_of(variable) + 0.5 * (high - low) * 0.9 * math.sin(phase * (1 + k % 3)))

        return values

    def times(self) -> list[float]:
        """Communication points."""
        return [self.start + k * self.step for k in range(self.steps)]


class Run:
    """An instance. A call that fails raises Refused."""

    kinds: dict[int, type] = {2: FMU2Slave, 3: FMU3Slave}

    def __init__(self, fmu: Fmu, name="it", starts=()):
        self.fmu = fmu
        description = fmu.description
        try:
            self.slave = self.kinds[fmu.version](
                guid=description.guid,
                unzipDirectory=fmu.folder,
                modelIdentifier=fmu.flags.modelIdentifier,
                instanceName=name,
            )
            self.slave.instantiate()
        except Exception as error:  # fmpy has no class of its own for a library that cannot be had
            raise Refused(f"no instance: {error}") from error

        self.begin(starts)

    def begin(self, starts=()):
        """From a new instance, or one that was reset, to the first step."""
        start = self.fmu.start

        if self.fmu.version == 2:
            self.call("setupExperiment", startTime=start)

        for variable, values in starts:
            self.set([variable], values)

        self.call("enterInitializationMode", **({"startTime": start} if self.fmu.version == 3 else {}))
        self.call("exitInitializationMode")

    def call(self, name, *arguments, **more):
        try:
            return getattr(self.slave, name)(*arguments, **more)
        except FMICallException as error:
            raise Refused(str(error)) from error

    def get(self, variables) -> list[float]:
        """Values of variables, arrays by rows."""
        return [float(x) for v in variables for x in self._call_of("get", v)(*self._key(v))]

    def set(self, variables, values):
        """All values of real variables, arrays by rows."""
        at = 0

        for v in variables:
            n = self.fmu.size(v)
            self.call(self._name("set", v), [v.valueReference], [float(x) for x in values[at : at + n]])
            at += n

    def _name(self, verb, variable):
        kind = "Integer" if self.fmu.version == 2 and variable.type == "Enumeration" else variable.type
        return verb + ("Int64" if kind == "Enumeration" else kind)

    def _call_of(self, verb, variable):
        return lambda *given: self.call(self._name(verb, variable), *given)

    def _key(self, variable):
        more = (self.fmu.size(variable),) if self.fmu.version == 3 else ()
        return ([variable.valueReference], *more)

    def put(self, variable, values):
        """All values of what derivatives are by."""
        self.set([variable], values)

    def outputs(self) -> list[float]:
        return self.get(self.fmu.outputs)

    def step(self, t, H):
        self.call("doStep", currentCommunicationPoint=t, communicationStepSize=H)

    def drive(self, first=0, last=None) -> list[list[float]]:
        """Outputs after each of some steps."""
        rows = []

        for t in self.fmu.times()[first:last]:
            self.set(self.fmu.inputs, self.fmu.inputs_at(t))
            self.step(t, self.fmu.step)
            rows.append(self.outputs())

        return rows

    # snapshots, in the words of both versions

    def _state(self, verb, *arguments):
        return self.call(verb + ("FMUstate" if self.fmu.version == 2 else "FMUState"), *arguments)

    def save(self):
        return self._state("get")

    def restore(self, state):
        self._state("set", state)

    def forget(self, state):
        self._state("free", state)

    def serialise(self, state) -> bytes:
        return self._state("serialize", state)

    def deserialise(self, data: bytes):
        return self._state("deSerialize" if self.fmu.version == 2 else "deserialize", data)

    def free(self):
        self.call("freeInstance")
