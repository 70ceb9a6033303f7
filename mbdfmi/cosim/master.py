"""A master for FMUs (FMI 2.0, co-simulation) with constant communication steps, on fmpy."""

import itertools
from collections.abc import Callable, Iterable, Mapping
from contextlib import ExitStack
from pathlib import Path
from shutil import rmtree

import fmpy
import numpy as np
from fmpy.fmi2 import FMU2Slave

from ..compiler.variables import hint, meant
from ..run.results import Results


class CouplingError(Exception):
    """FMUs that do not fit together, or one that gave up; the message says which, and when."""


def couple(
    fmus: Mapping[str, str | Path],
    connections: Iterable[tuple[str, str]],
    until: float,
    step: float,
    parameters: Mapping[str, float] | None = None,
    progress: Callable[[float], None] | None = None,
) -> Results:
    """Run FMUs together from 0 to `until` (s) in communication steps of `step` (s).

    fmus : files by a name of your choice. In each step they advance one after another in this order
        (Gauss-Seidel), so put an FMU behind those whose outputs it should know at the step's end.
    connections : (output, input) pairs, each written "name.variable". An array variable without
        index stands for all its components, paired in order.
    parameters : start values of parameters and inputs, by "name.variable".
    progress : called with the time reached (s) after each step.

    An input fed by an FMU further up the order runs linearly from the output's value at the start
    of the step to that at its end if its FMU can interpolate inputs, else it takes the value at the
    end. An input fed from further down holds the value at the start.

    Returns all real outputs by "name.variable", at the communication points. Raises CouplingError
    for names that do not exist, inputs fed twice and FMUs that fail; ValueError for senseless times.
    """
    if not (0 < until < np.inf and 0 < step < np.inf):
        raise ValueError(f"until and step must be positive; found {until} and {step}")

    n = max(1, int(np.ceil(until / step - 1e-6)))
    times = np.minimum(np.arange(n + 1) * step, until)

    with ExitStack() as stack:
        slaves = {name: stack.enter_context(_Slave(name, path, until)) for name, path in fmus.items()}
        order = list(slaves.values())
        for source, target in connections:
            _connect(slaves, source, target)
        for name, value in (parameters or {}).items():
            slave, (variable,) = _find(slaves, name, "parameter", "input")
            slave.set([variable.valueReference], [value])

        _initialise(order)
        rows = [np.concatenate([slave.values for slave in order])]
        for start, end in itertools.pairwise(times):
            _step(order, start, end - start)
            rows.append(np.concatenate([slave.values for slave in order]))
            if progress:
                progress(end)

    names = [f"{slave.name}.{variable.name}" for slave in order for variable in slave.outputs]
    units = [variable.unit for slave in order for variable in slave.outputs]
    columns = {"time": times} | dict(zip(names, np.array(rows).T))
    return Results(columns, {"time": "s"} | dict(zip(names, units)), " + ".join(fmus))


def _initialise(order):
    """From instances to outputs at the start."""
    for slave in order:
        slave.call("enterInitializationMode")

    # outputs may depend on inputs at once: as often as there are FMUs reaches the last one
    for _ in order:
        for slave in order:
            slave.feed()
            slave.fetch()
    for slave in order:
        slave.call("exitInitializationMode")
    for slave in order:
        slave.fetch()


def _step(order, start, H):
    """All FMUs from a time on by H (s), each knowing the outputs of those before it."""
    for slave in order:
        slave.past = slave.values
    for i, slave in enumerate(order):
        slave.feed(known=order[:i], H=H)
        slave.call("doStep", start, H)
        slave.fetch()


class _Slave:
    """An FMU at work: its outputs now and a step ago, and where its inputs come from."""

    def __init__(self, name, path, until):
        self.name = name
        # not validated: many a foreign FMU runs though a validator finds fault with its description
        try:
            self.description = fmpy.read_model_description(path, validate=False)
        except Exception as error:
            raise CouplingError(f"{name}: no FMU for co-simulation in {path}: {error}") from error
        if not self.description.coSimulation or self.description.fmiVersion != "2.0":
            raise CouplingError(f"{name}: no FMU for co-simulation in {path}: FMI 2.0 is needed")

        self.outputs = [
            v for v in self.description.modelVariables if v.causality == "output" and v.type == "Real"
        ]
        self.references = [v.valueReference for v in self.outputs]
        self.values = np.zeros(len(self.outputs))
        self.sources = {}
        self.path, self.until = path, until

    def __enter__(self):
        interface = self.description.coSimulation
        self.folder = fmpy.extract(self.path)
        try:
            self.fmu = FMU2Slave(
                guid=self.description.guid,
                unzipDirectory=self.folder,
                modelIdentifier=interface.modelIdentifier,
                instanceName=self.name,
            )
        except Exception as error:
            rmtree(self.folder, ignore_errors=True)
            raise CouplingError(f"{self.name}: its library cannot be loaded: {error}") from error

        try:
            self.call("instantiate")
            self.call("setupExperiment", startTime=0.0, stopTime=self.until)
        except CouplingError:
            rmtree(self.folder, ignore_errors=True)
            raise
        return self

    def __exit__(self, kind, *_):
        if kind is None:
            self.call("terminate")
        self.fmu.freeInstance()
        rmtree(self.folder, ignore_errors=True)

    def call(self, function, *arguments, **options):
        """Call a function of the FMU; CouplingError with its name and the time when it refuses."""
        try:
            return getattr(self.fmu, function)(*arguments, **options)
        except Exception as error:
            when = f" at {arguments[0]:.9g} s" if function == "doStep" else ""
            raise CouplingError(f"{self.name}: {function} failed{when}: {error}") from error

    def set(self, references, values):
        """Set real variables."""
        if references:
            self.call("setReal", references, values)

    def fetch(self):
        """Read the outputs."""
        self.values = np.array(self.call("getReal", self.references) if self.references else [])

    def feed(self, known=(), H=None):
        """Set the inputs from their sources' outputs; linear over a step H where both ends are known."""
        inputs, values, slopes = list(self.sources), [], []
        linear = H is not None and self.description.coSimulation.canInterpolateInputs

        for source, position in self.sources.values():
            now = source.values[position]
            past = source.past[position] if linear and source in known else now
            values.append(past)
            slopes.append((now - past) / H if linear else 0.0)

        self.set(inputs, values)
        if linear and inputs:
            self.call("setRealInputDerivatives", inputs, [1] * len(inputs), slopes)


def _connect(slaves, source, target):
    giver, outputs = _find(slaves, source, "output")
    taker, inputs = _find(slaves, target, "input")

    if len(outputs) != len(inputs):
        raise CouplingError(f"{source} has {len(outputs)} components, {target} has {len(inputs)}")

    for output, entry in zip(outputs, inputs):
        if entry.valueReference in taker.sources:
            raise CouplingError(f"{taker.name}.{entry.name} is fed twice")
        taker.sources[entry.valueReference] = giver, giver.outputs.index(output)


def _find(slaves, text, *causalities):
    """The slave and the real variables that "name.variable" stands for: one, or an array's in order."""
    name, _, variable = text.partition(".")
    if name not in slaves:
        raise CouplingError(f"{text}: no FMU {name!r}; {hint(name, slaves)}")

    fits = {
        v.name: v
        for v in slaves[name].description.modelVariables
        if v.causality in causalities and v.type == "Real"
    }
    found = meant(variable, fits)

    if not found:
        kinds = " or ".join(causalities)
        raise CouplingError(f"{text}: {name} has no {kinds} {variable!r}; {hint(variable, fits)}")

    return slaves[name], [fits[key] for key in found]
