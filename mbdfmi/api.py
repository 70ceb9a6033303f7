"""The scene as a Python user meets it: it can simulate and export itself."""

import os
from collections.abc import Mapping
from contextlib import contextmanager
from dataclasses import replace
from pathlib import Path
from typing import Any

from pydantic import PrivateAttr

from . import scene as _scene
from .scene import SceneError as SceneError
from .scene import reader
from .scene.fields import adopted, given
from .threads import one_thread


class Scene(_scene.SceneData):
    """A multibody scene that can be simulated, exported and looked at.

    Made by `load`, or as `Scene(name=..., body={...}, joint={...})` with the keys of a scene file. Raises
    SceneError with all that is wrong in it.

    Its parts can be changed, `scene.joint["elbow"].damper = 0.2`, added, `scene.force["rope"] = {...}`, and
    taken out, `del scene.force["rope"]`. A value that is assigned is checked at once; what is put into a
    table or a list, and how the parts go together, when the scene is used next.
    """

    _file: Path | None = PrivateAttr(None)
    _known: dict = PrivateAttr({})
    _imported: Any = PrivateAttr(None)

    def model_post_init(self, context):
        """Remembers what was checked."""
        self._known = given(self)

    def _whole(self):
        """Itself, checked again if it was changed. Raises SceneError."""
        now = given(self)

        if now != self._known:
            with self._file_named():
                adopted(self, type(self).model_validate(now))

            self._known = given(self)

        return self

    @contextmanager
    def _file_named(self):
        """A SceneError names the file."""
        try:
            yield
        except _scene.SceneError as error:
            raise _scene.SceneError(error.problems, file=self._file) from None

    @property
    def imported(self):
        """What the scene was made of if it was read from a URDF file (`mbdfmi.scene.import_.Imported`), or
        None.
        """
        return self._imported

    @property
    def import_notes(self):
        """What was decided and left out when the scene was read from a URDF file (list of str); [] of
        others.
        """
        return self._imported.notes if self._imported else []

    def compile(self, as_given=False):
        """The `Model` of the scene: arrays and variables.

        as_given : with its start values as they are, whatever start the scene asks for. Raises SceneError;
        NoEquilibrium where it is to start in one and there is none, ValueError where no trim is found.
        """
        as_given = as_given or self.solver.start == "given"
        return self._compiled(self._whole()) if as_given else self._started(self._starting())

    def _compiled(self, scene):
        from .compiler.model import compile_scene

        with self._file_named():
            return compile_scene(scene)

    def _started(self, start):
        """The model of a scene with the start that it asks for (`Starting`)."""
        from .compiler.model import with_values

        return with_values(self._compiled(start.scene), start.found, start.notices)

    def _starting(self, hold=None, parameters=None, time=0.0):
        """The scene checked, with the start that it asks for (`Starting`)."""
        from .analysis.equilibrium import NoEquilibrium
        from .analysis.starting import starting

        try:
            return starting(self._whole(), hold, parameters, time)
        except (NoEquilibrium, ValueError) as error:
            raise type(error)(f"{self._file}: {error}" if self._file else str(error)) from None

    def simulate(self, until, step=None, inputs=None, parameters=None, specialise=None, bind=None, **options):
        """Run in process up to `until` (s); see `mbdfmi.run.simulate.simulate`. Returns Results, columns by
        name, that can be looked at: `results.view()`.

        specialise : by a library of this scene alone, compiled for it and kept (docs/specialise.md): the same
        numbers, faster. bind : parameters that are constants of it. By default as [code] in the scene says.
        """
        from .run.simulate import inputs_at_start, simulate
        from .view.runs import Run

        if self.solver.start == "given":
            model = self._compiled(self._whole())
        else:
            time = options.get("start_time", 0.0)
            hold = inputs_at_start(self._compiled(self._whole()), until, step, inputs, time)
            start = self._starting(hold, parameters, time)
            model, parameters = self._started(start), start.parameters

        if self.code.specialise if specialise is None else specialise:
            from .export.specialise import scene_library
            from .run.instance import Entries

            model = self._bound(model, bind)
            options["kernels"] = Entries.of(scene_library(model))

        return Run.of(simulate(model, until, step, inputs, parameters, **options))

    def _for_fmu(self, at_rest=False, progress=None):
        """(the model of its FMU, that of a scene which starts as the FMU does).

        at_rest : whether the FMU is to offer a start at rest, as it does anyhow where the scene starts so.
        """
        asked = self.solver.start == "equilibrium"

        if not (asked or at_rest):
            model = self.compile()
            return model, model

        from .analysis.equilibrium import NoEquilibrium
        from .analysis.starting import Starting, resting
        from .compiler.model import with_values

        start = Starting(self._whole(), {}, {}) if asked else self._starting()
        model = self._started(start)

        try:
            found = resting(model, start, asked)
        except NoEquilibrium as error:
            asks = '[solver] start = "equilibrium"' if asked else "at_rest (--at-rest)"
            place = f"{self._file}: " if self._file else ""
            raise NoEquilibrium(f"{place}{asks}: {error}; without it a run starts as written") from None

        offering, there, notices = found

        if asked:
            return with_values(offering, {}, notices), there

        for text in notices if progress else ():
            progress(f"at rest: {text}")

        return offering, offering

    def _bound(self, model, names):
        """The model with parameters as constants, by default those of [code] in the scene."""
        from .trace.binding import bound

        return bound(model, self.code.bind if names is None else names)

    def show(self, path=None) -> Path:
        """The scene as it is assembled, as a page (.html), GLB or PNG; without a path, in the browser; see
        `mbdfmi.view.show.show`. Raises SimulationError where it cannot be assembled.
        """
        from .view.runs import at_start
        from .view.show import show

        return show(at_start(self.compile()), path)

    def recorder(self):
        """Keeps a run of the scene's FMU by fmpy, so that it can be looked at; see
        `mbdfmi.view.recorder.Recorder`.
        """
        from .view.recorder import Recorder

        return Recorder(self._for_fmu()[0])

    def _repr_html_(self):
        """In a notebook: the scene as it is assembled."""
        from .view.runs import at_start

        return at_start(self.compile())._repr_html_()

    def inverse(self, motion, times=None, **options):
        """The efforts that a motion of joints needs; see `mbdfmi.analysis.inverse.inverse`. Returns Results,
        columns by name.
        """
        from .analysis.inverse import inverse

        return inverse(self._whole(), motion, times, **options)

    @one_thread()
    def linearise(self, inputs=None, outputs=None, at=None, **options):
        """A, B, C, D about a state, in minimal coordinates; see `mbdfmi.analysis.linearise.linearise`. Its
        `modes()` are frequencies, damping, shapes.
        """
        from .analysis.linearise import linearise

        parameters = options.pop("parameters", None)

        if parameters is not None and not isinstance(parameters, Mapping):
            names = [parameters] if isinstance(parameters, str) else parameters
            options["by"], parameters = [*options.get("by", ()), *names], None

        start = self._starting(options.pop("hold", None), parameters)
        values = {"hold": start.hold, "parameters": start.parameters}
        found = linearise(start.scene, inputs, outputs, at, **values, **options)
        told = [text for text in start.notices if text not in found.notices]

        if found.sensitivities and self.solver.start == "trim":
            told.append("derivatives by parameters are those about a trim that stays what it is")

        return replace(found, notices=[*found.notices, *told]) if told else found

    @one_thread()
    def equilibrium(self, **options):
        """The static equilibrium that it comes to from its start; see `mbdfmi.analysis.rest.equilibrium`. Its
        `scene` starts there.
        """
        from .analysis.rest import equilibrium

        return equilibrium(self._whole(), **options)

    @one_thread()
    def equilibria(self, **options):
        """All that are found from drawn starts; see `mbdfmi.analysis.rest.equilibria`."""
        from .analysis.rest import equilibria

        return equilibria(self._whole(), **options)

    @one_thread()
    def trim(self, find=None, keep=None, **options):
        """Values of inputs, parameters and start values for which conditions hold; see
        `mbdfmi.analysis.trim.trim`. Without names of what to find it is as `solver.trim` asks.
        """
        from .analysis.trim import trim

        return trim(self._whole(), find, keep, **options)

    @one_thread()
    def righting(self, hull=None, axis="x", **options):
        """The righting-arm curve of a hull that floats; see `mbdfmi.analysis.righting.righting`."""
        from .analysis.righting import righting

        return righting(self._whole(), hull, axis, **options)

    def compare_steppers(self, until, step=None, **options):
        """Error against cost of every stepper on this scene; see
        `mbdfmi.analysis.comparison.compare_steppers`.
        """
        from .analysis.comparison import compare_steppers

        return compare_steppers(self._whole(), until, step, **options)

    def equations(self, parameters=None, outputs=True, derivatives=False):
        """x' = f(t, x, u, p) and y as equations with the scene's names, `text(form)` of which writes them in
        C, numpy, sympy or casadi; see `mbdfmi.trace.equations.equations`.

        parameters : names of those that stay free; an array without index stands for its elements.
        """
        from .run.inputs import known
        from .run.instance import Instance
        from .scene import variable_name
        from .trace.equations import equations

        model = self.compile()
        names = [v.name for v in model.of_causality("parameter")]
        free = parameters and [
            part for name in parameters for part in known(variable_name(name), names, "parameter")
        ]
        return equations(Instance(model), free if parameters else parameters, outputs, derivatives)

    @one_thread()
    def structure(self):
        """Degrees of freedom, redundant equations, undetermined reactions; see
        `mbdfmi.analysis.structure.Structure`.
        """
        from .analysis.structure import structure

        return structure(self._whole())

    def export(
        self, path=None, platforms=None, *, with_scene=True, bind=None, at_rest=False, **options
    ) -> Path:
        """Write the scene as an FMU and return its path; see `mbdfmi.export.export_fmu`. Icon and page
        show the scene, where it can be assembled.

        path : by default `<scene's name>.fmu` in the working folder.
        platforms : e.g. ["x86_64-linux", "x86_64-windows"]; by default this machine's.
        with_scene : whether the file that it was read from goes with the FMU, in resources/.
        fmi : among the options, 2 or 3; by default FMI 2.0.
        specialise : among the options, True for libraries of this scene alone (docs/specialise.md).
        with_sources : among the options, True for its code in C99 too, in sources/.
        lean : among the options, True to leave out the local variables: motions of all joints and bodies, and
        what joints bear.
        bind : names of parameters that are constants of the FMU; by default these three are as [code] in the
        scene says.
        at_rest : whether it gets the Boolean parameter `solver.start_at_equilibrium`, false at first; with
        `[solver] start = "equilibrium"` it has it anyhow, true at first. Raises NoEquilibrium.
        """
        from .export import export_fmu

        model, shown = self._for_fmu(at_rest, options.get("progress"))
        model = self._bound(model, bind)

        for option, asked in (("specialise", self.code.specialise), ("with_sources", self.code.sources)):
            if options.get(option) is None:
                options[option] = asked

        path = Path(path) if path else Path(f"{model.identifier}.fmu")
        pictures = self._pictures(shown, options.get("progress"))
        file = self._file if with_scene else None
        return export_fmu(model, path, platforms, scene_file=file, pictures=pictures, **options)

    @staticmethod
    def _pictures(model, progress):
        """Pictures of the scene for its FMU, or None, and why is told."""
        from .run.instance import SimulationError
        from .view.still import still

        try:
            return still(model)
        except (SimulationError, ValueError) as error:
            if progress:
                progress(f"without a picture of the scene: {error}")

            return None


def load(path: str | os.PathLike, **options) -> Scene:
    """Read a scene from a TOML file, or a robot from a URDF file.

    options : how a URDF file is read, as `mbdfmi.scene.import_.UrdfOptions` says: base="free",
    stop_stiffness=1e4, packages={"panda": "robots/panda"}. What was decided and left out then stands in the
    scene's `import_notes`.

    Raises SceneError with the file's name and all that is wrong in it; ValueError for options that do not
    fit.
    """
    path = Path(path)
    data = reader.read_bytes(path)

    if reader.is_urdf(data, path):
        from .scene import import_

        return _imported(path, import_.read_urdf(path, import_.UrdfOptions(**options), data))
    if options:
        raise ValueError(f"{path}: is a scene file; {', '.join(options)}: for URDF files alone")

    scene = reader.parse_scene(data, os.fspath(path), Scene)
    scene._file = path
    return scene


def _imported(path, imported):
    """The scene of what was read from a file of another format."""
    try:
        scene = Scene.model_validate(imported.tables)
    except _scene.SceneError as error:
        raise _scene.SceneError(error.problems, file=path) from None

    scene._file, scene._imported = path, imported
    return scene
