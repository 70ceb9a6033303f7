"""The scene as a Python user meets it: it can simulate and export itself."""

import os
from contextlib import contextmanager
from pathlib import Path

from pydantic import PrivateAttr

from . import scene as _scene
from .scene.fields import adopted, given


class Scene(_scene.SceneData):
    """A multibody scene that can be simulated, exported and looked at.

    Made by `load`, or as `Scene(name=..., body={...}, joint={...})` with the keys of a scene file. Raises
    SceneError with all that is wrong in it.

    Its parts can be changed, `scene.joint["elbow"].damper = 0.2`, added, `scene.force["rope"] = {...}`, and
    taken out, `del scene.force["rope"]`. What is assigned is checked at once, how the parts go together when
    the scene is used next.
    """

    _file: Path | None = PrivateAttr(None)
    _known: dict = PrivateAttr({})

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

    def compile(self):
        """The `Model` of the scene: arrays and variables. Raises SceneError."""
        from .compiler.model import compile_scene

        self._whole()

        with self._file_named():
            return compile_scene(self)

    def simulate(self, until, step=None, inputs=None, parameters=None, **options):
        """Run in process up to `until` (s); see `mbdfmi.run.simulate.simulate`. Returns Results, columns by
        name, that can be looked at: `results.view()`.
        """
        from .run.simulate import simulate
        from .view.show import Run

        return Run.of(simulate(self.compile(), until, step, inputs, parameters, **options))

    def show(self, path=None) -> Path:
        """The scene as it is assembled, as a page (.html) or a GLB, or, without a path, in the browser; see
        `mbdfmi.view.show.show`. Raises SimulationError where it cannot be assembled.
        """
        from .view.show import at_start, show

        return show(at_start(self.compile()), path)

    def _repr_html_(self):
        """In a notebook: the scene as it is assembled."""
        from .view.show import at_start

        return at_start(self.compile())._repr_html_()

    def inverse(self, motion, times=None, **options):
        """The efforts that a motion of joints needs; see `mbdfmi.analysis.inverse.inverse`. Returns Results,
        columns by name.
        """
        from .analysis.inverse import inverse

        return inverse(self._whole(), motion, times, **options)

    def compare_steppers(self, until, step=None, **options):
        """Error against cost of every stepper on this scene; see
        `mbdfmi.analysis.comparison.compare_steppers`.
        """
        from .analysis.comparison import compare_steppers

        return compare_steppers(self._whole(), until, step, **options)

    def structure(self):
        """Degrees of freedom, redundant equations, undetermined reactions; see
        `mbdfmi.analysis.structure.Structure`.
        """
        from .analysis.structure import structure

        return structure(self._whole())

    def export(self, path=None, platforms=None, **options) -> Path:
        """Write the scene as an FMU and return its path; see `mbdfmi.export.export_fmu`.

        path : by default `<scene's name>.fmu` in the working folder.
        platforms : e.g. ["x86_64-linux", "x86_64-windows"]; by default this machine's.
        fmi : among the options, 2 or 3; by default FMI 2.0.
        """
        from .export import export_fmu

        model = self.compile()
        path = Path(path) if path else Path(f"{model.identifier}.fmu")
        return export_fmu(model, path, platforms, scene_file=self._file, **options)


def load(path: str | os.PathLike) -> Scene:
    """Read a scene from a TOML file. Raises SceneError with the file's name and all that is wrong in it."""
    scene = _scene.read_scene(path, Scene)
    scene._file = Path(path)
    return scene
