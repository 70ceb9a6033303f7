"""A coupled system: from a file or from Python, checked, run."""

from __future__ import annotations

import os
import tempfile
from collections.abc import Callable, Mapping
from contextlib import ExitStack
from pathlib import Path
from typing import Any

import numpy as np
from pydantic import PrivateAttr

from ..run.results import Results
from ..run.simulate import communication_points
from ..scene.errors import SceneError, place_text
from ..scene.reader import parse_scene, read_bytes
from ..view.recorder import Recorder
from ..view.runs import Run
from .errors import CouplingError
from .graph import through
from .history import History, Seen
from .march import March
from .members import Member, read_members
from .misses import coarse, jumps, rough
from .network import Network, network
from .plan import Plan, plan
from .rig import Rig
from .schema import SystemData
from .start import initialise
from .trial import tried
from .watch import BondReport, Watch, bonds, reports


class Coupled(Run):
    """Results of a coupled run: columns by "fmu.variable".

    bonds : of each pair of links that carries power, what the coupling made of its energy. jumps : of each link, its largest
    jump at a communication point, relative to the range of its values. work : calls of doStep by FMU. plan : how it was
    done.
    """

    bonds: list[BondReport]
    jumps: dict[str, float]
    work: dict[str, int]
    plan: Plan


class _SystemType(type(SystemData)):  # type: ignore[misc]
    """Makes systems whose mistakes are told as those of their files are."""

    def __call__(cls, *arguments, **tables):
        try:
            return super().__call__(*arguments, **tables)
        except SceneError as error:
            raise _told(error, None) from None


class System(SystemData, metaclass=_SystemType):
    """FMUs and scenes that run together, of `mbdfmi.cosim.load_system` or made in Python:

        System(fmu={"motor": {"file": "motor.fmu"}, "arm": {"scene": "arm.toml"}},
               link=[("motor.torque", "arm.shoulder.torque"), ("arm.shoulder.speed", "motor.speed")])

    Raises CouplingError with all that is wrong.
    """

    _file: Path | None = PrivateAttr(None)
    # of the FMUs of a package, which lives as long as the system
    _folder: Any = PrivateAttr(None)

    def _read(self, stack: ExitStack) -> tuple[dict[str, Member], Network]:
        """Descriptions read and links resolved. Raises CouplingError."""
        try:
            members = read_members(self.fmu, stack)
            return members, network(self, members)
        except CouplingError as error:
            raise self._named(error) from error

    def _named(self, error: CouplingError) -> CouplingError:
        if self._file is None:
            return error
        return CouplingError([f"{self._file}: {text}" for text in error.errors], error.results)

    def check(self) -> str:
        """The graph in words: links, loops, order, what each FMU can do and what the master will use. Raises CouplingError."""
        from .words import told

        with ExitStack() as stack:
            members, net = self._read(stack)
            return told(self, members, net)

    def write_ssp(self, path: str | os.PathLike) -> Path:
        """Write the system, with its FMUs, as a package of SSP 1.0 (.ssp). Returns the path.

        Raises CouplingError for what SSP cannot say (sums of sources, elements of arrays of FMI 3.0), OSError.
        """
        from .ssp_writer import write_ssp

        with ExitStack() as stack:
            members, net = self._read(stack)
            return write_ssp(self, members, net, Path(path))

    def simulate(
        self,
        until: float | None = None,
        step: float | None = None,
        *,
        start: float | None = None,
        progress: Callable[[float], None] | None = None,
        view: str | None = None,
    ) -> Coupled:
        """Run to `until` (s) in communication steps of `step` (s); without them as [run] says.

        progress : called with the time reached (s). view : name of a scene among the FMUs whose states are kept, so that
        the results can be looked at.

        Returns the recorded variables at all communication points. Raises CouplingError, with the results so far where the
        run had begun; ValueError for senseless times.
        """
        start = self.run.start if start is None else start
        until = self.run.stop if until is None else until
        step = self.run.step if step is None else step
        if not (start < until < np.inf and 0 < step < np.inf):
            raise ValueError(f"until and step must be positive; found {until} and {step}")

        with ExitStack() as stack:
            members, net = self._read(stack)
            if view is not None and (view not in members or members[view].model is None):
                scenes = [name for name, m in members.items() if m.model is not None]
                raise CouplingError(
                    f"view: {view!r} is no scene of the system; there are {', '.join(scenes) or 'none'}"
                )
            # values that are no numbers are told, with the FMU that they come from
            stack.enter_context(np.errstate(over="ignore", invalid="ignore"))
            try:
                return _Simulation(self, members, net).run(start, until, step, progress, view)
            except CouplingError as error:
                raise self._named(error) from error


def load_system(path: str | os.PathLike) -> System:
    """A system of a TOML file, or of a package of SSP 1.0 (.ssp). Raises CouplingError with the file's name and all that is
    wrong in it.
    """
    path = Path(path)
    if path.suffix.lower() == ".ssp":
        return _of_package(path)
    if path.suffix.lower() == ".fmu":
        raise CouplingError(
            f'{path}: is an FMU; name it in a system file (TOML): [fmu.NAME] file = "{path.name}"'
        )
    try:
        system = parse_scene(read_bytes(path), os.fspath(path), System)
    except SceneError as error:
        raise _told(error, path) from None
    system._file = path
    return system


def _of_package(path):
    """The system of a package of SSP."""
    from .ssp_reader import read_ssp

    folder = tempfile.TemporaryDirectory(prefix="mbdfmi-", ignore_cleanup_errors=True)
    tables = read_ssp(path, Path(folder.name))
    try:
        system = System.model_validate(tables)
    except SceneError as error:
        raise _told(error, path) from None
    system._file, system._folder = path, folder
    return system


NAMED = ("fmu", "bond")
TABLES = ("master", "run")


def _told(error: SceneError, file) -> CouplingError:
    """The error of a system's tables, with the places that they have."""
    prefix = f"{file}: " if file else ""
    texts = []
    for problem in error.problems:
        place = place_text(problem.path, NAMED, TABLES)
        texts.append(prefix + (f"{place} {problem.text}" if place else problem.text))
    return CouplingError(texts)


class _Simulation:
    """One run of a system."""

    def __init__(self, system: System, members: dict[str, Member], net: Network):
        self.system, self.members, self.net = system, members, net
        self.plan = plan(net, system.master)
        self.bonds = bonds(net, system.bond)
        self.notices: list[str] = []

    def run(self, start, until, step, progress, view) -> Coupled:
        system, net = self.system, self.net
        times, steps = communication_points(start, until, step)
        fixed = [name for name, member in self.members.items() if not member.can.variable_steps]
        if fixed and abs(steps[-1] - steps[0]) > 1e-9 * steps[0]:
            names = ", ".join(fixed)
            self.notices.append(
                f"{names}: takes steps of one length, it says; the last step is {steps[-1]:.6g} s instead of {steps[0]:.6g} s"
            )
        self.plan = tried(net, self.plan, system.master, times)
        self.rig = rig = Rig(net, {name: through(net, name) for name in net.names})
        self.history = History(net, rig.y, rig.end)
        watch = Watch(self.history, system.master.limit)
        self.recorder = Recorder(self.members[view].model) if view else None
        well, begun = False, False

        try:
            rig.open(start, until)
            self.notices += initialise(rig, self.plan.rolling)
            rig.begin()
            march = self._march(watch, steps[0])
            rig.end[:] = rig.now
            self.history.add(start)
            self._look(rig, view, march)
            begun = True
            if system.master.error is None:
                march.fixed(times, float(steps[0]), progress)
            else:
                march.chosen(start, until, float(step), progress)
            watch.look()
            well = True
        except CouplingError as error:
            # an FMU may fail of what the coupling made of its inputs
            error = _diverged(watch) or error
            error.results = self._results(None) if begun and self.history.n else None
            raise error from None
        finally:
            rig.close(well)

        return self._results(march)

    def _march(self, watch, H):
        """The march, after rollback was put to the test where it will be used."""
        march = March(self.rig, self.plan, self.system.master, watch, self.history)
        untrue = march.untrue(H)
        if not untrue:
            return march

        self.notices += [
            f"{name}: going back to a saved state is not exact: {text}" for name, text in untrue.items()
        ]
        if self.system.master.method != "auto":
            return march

        self.plan = plan(self.net, self.system.master, frozenset(untrue))
        return March(self.rig, self.plan, self.system.master, watch, self.history)

    def _look(self, rig, view, march):
        """Keeps the states of a scene at each row, if they are wanted."""
        if not view:
            return
        slave, recorder = rig.by_name[view].slave, self.recorder
        assert recorder is not None
        recorder.keep(slave.serialised())
        march.after = lambda: recorder.keep(slave.serialised())

    def _results(self, march) -> Coupled:
        net, history = self.net, self.history
        columns: dict[str, Any] = {"time": history.time.copy()}
        units: dict[str, str | None] = {"time": "s"}

        for name, signal in net.record:
            title = f"{name}.{signal.name}"
            columns[title] = history.y[:, net.place(name, signal)].copy()
            units[title] = signal.unit_name

        seen = Seen(history)
        found = reports(net, self.bonds, seen)
        notices = [*self.notices]
        for port in self.rig.ports:
            notices += [f"{port.name}: {text}" for text in port.slave.told]
        if march is not None:
            notices += march.notices
        notices += [bond.told for bond in found if bond.told]
        notices += rough(net, seen)
        if self.system.master.error is None:
            notices += coarse(net, seen, self.plan.order)
        states = None
        if self.recorder is not None:
            states = self.recorder.results().states

        results = Coupled(columns, units, self.system.name, notices, states)
        results.bonds, results.jumps = found, jumps(net, seen)
        results.work, results.plan = self.rig.work, self.plan
        return results


def _diverged(watch):
    """The CouplingError of a run that diverges, or None."""
    try:
        watch.look()
    except CouplingError as error:
        return error
    return None


def couple(
    fmus: Mapping[str, str | Path],
    connections,
    until: float,
    step: float,
    parameters: Mapping[str, Any] | None = None,
    progress: Callable[[float], None] | None = None,
    **master: Any,
) -> Results:
    """Run FMUs together from 0 to `until` (s) in communication steps of `step` (s).

    fmus : files (or scenes) by a name of your choice.
    connections : (output, input) pairs, each written "name.variable", or tables of a link (`mbdfmi.cosim.schema.Link`).
        An array variable without index stands for all its components, paired in order.
    parameters : start values of parameters and inputs, by "name.variable".
    progress : called with the time reached (s) after each step.
    master : as of [master] of a system's file: method="gauss-seidel", order=1, ...

    Returns all outputs that are numbers by "name.variable", at the communication points. Raises CouplingError for names that
    do not exist, units and types that do not fit, inputs fed twice and FMUs that fail; ValueError for senseless times.
    """
    if not (0 < until < np.inf and 0 < step < np.inf):
        raise ValueError(f"until and step must be positive; found {until} and {step}")

    tables: dict[str, dict] = {name: _table(value) for name, value in fmus.items()}

    for text, value in (parameters or {}).items():
        name, _, variable = text.partition(".")
        if name not in tables:
            from ..compiler.variables import hint

            raise CouplingError(f"{text}: no FMU {name!r}; {hint(name, tables)}")
        tables[name].setdefault("parameters", {})[variable] = value

    return System(fmu=tables, link=list(connections), master=master).simulate(until, step, progress=progress)


def _table(value) -> dict:
    """The table of an FMU given by a path, or of a scene."""
    if isinstance(value, dict):
        return dict(value)
    if hasattr(value, "compile") or str(value).lower().endswith(".toml"):
        return {"scene": value}
    return {"file": value}
