"""The FMUs of a system before they run: descriptions, signals, what they can do."""

from __future__ import annotations

import tempfile
from contextlib import ExitStack
from dataclasses import dataclass, replace
from pathlib import Path
from typing import Any

import fmpy

from ..scene.errors import SceneError
from .conversions import Made
from .errors import CouplingError
from .schema import Fmu
from .signals import Capabilities, Signal, Structure, capabilities, signals_of, structure_of, version_of


@dataclass(frozen=True)
class Member:
    """An FMU of a system. model : of a scene that takes part as one, else None."""

    name: str
    table: Fmu
    path: Path
    description: Any
    signals: dict[str, Signal]
    structure: Structure
    can: Capabilities
    model: Any = None

    @property
    def version(self) -> int:
        """Of FMI: 2 or 3."""
        return version_of(self.description)

    def depends(self, output: Signal, at_start: bool = False) -> tuple[str, ...] | None:
        """Names of the inputs that a signal depends on at once; None: it is not told, perhaps all."""
        if isinstance(output, Made):
            found = [self.depends(source, at_start) for source in output.sources]
            names = [name for told in found for name in told or ()]
            return None if None in found else tuple(dict.fromkeys(names))

        told = self.structure.at_start if at_start else self.structure.during
        if output.name in told:
            return told[output.name]

        # what is no output and no unknown of the start is told of nowhere
        return None

    @property
    def is_told(self) -> bool:
        """Whether it tells what its outputs depend on."""
        return any(names is not None for names in self.structure.during.values())


def read_member(name: str, table: Fmu, stack: ExitStack) -> Member:
    """The FMU of a table; that of a scene lives as long as the stack. Raises CouplingError."""
    model, path = (None, Path(table.file)) if table.file else _of_scene(name, table.scene, stack)

    if not path.is_file():
        raise CouplingError(f"{name}: there is no file {path}")
    try:
        # not validated: many a foreign FMU runs though a validator finds fault with its description
        description = fmpy.read_model_description(path, validate=False)
    except Exception as error:
        raise CouplingError(f"{name}: no FMU for co-simulation in {path}: {error}") from error

    if str(description.fmiVersion).split(".")[0] not in ("2", "3"):
        raise CouplingError(
            f"{name}: no FMU for co-simulation in {path}: FMI 2.0 or 3.0 is needed, it is of FMI {description.fmiVersion}"
        )
    if not description.coSimulation:
        kinds = "model exchange only" if description.modelExchange else "scheduled execution only"
        raise CouplingError(f"{name}: no FMU for co-simulation in {path}: it is for {kinds}")

    signals = signals_of(description)
    can = capabilities(description)
    can = replace(
        can,
        rollback=can.rollback and table.rollback,
        input_derivatives=can.input_derivatives and table.derivatives,
    )
    return Member(name, table, path, description, signals, structure_of(description, signals), can, model)


def _of_scene(name, scene, stack):
    """(model, path of its FMU) of a scene or a scene's file."""
    from ..export import export_fmu

    try:
        model = scene.compile() if hasattr(scene, "compile") else _started(scene)
    except SceneError as error:
        raise CouplingError([f"{name}: {text}" for text in error.errors]) from error
    except ValueError as error:
        raise CouplingError(f"{name}: {scene}: {error}") from error

    folder = stack.enter_context(tempfile.TemporaryDirectory(prefix="mbdfmi-", ignore_cleanup_errors=True))
    return model, export_fmu(model, Path(folder) / f"{model.identifier}.fmu")


def _started(path):
    """The model of a scene's file, with the start that it asks for."""
    from ..analysis.starting import starting
    from ..compiler.model import compile_scene, with_values
    from ..scene import read_scene

    start = starting(read_scene(path))
    return with_values(compile_scene(start.scene), start.found, start.notices)


def read_members(tables: dict[str, Fmu], stack: ExitStack) -> dict[str, Member]:
    """All FMUs by name. Raises CouplingError with all that is wrong."""
    members, errors = {}, []

    for name, table in tables.items():
        try:
            members[name] = read_member(name, table, stack)
        except CouplingError as error:
            errors += error.errors

    if errors:
        raise CouplingError(errors)

    _check_once(members)
    return members


def _check_once(members):
    """Raises CouplingError for an FMU that may be there once only, and is there twice."""
    seen = {}

    for member in members.values():
        key = member.description.guid
        if key in seen and member.description.coSimulation.canBeInstantiatedOnlyOncePerProcess:
            raise CouplingError(
                f"{member.name}: its FMU is {seen[key]}'s too, and it can be instantiated once per process only"
            )
        seen[key] = member.name
