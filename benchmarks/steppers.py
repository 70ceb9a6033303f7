"""Our own steppers as contestants: every integrator a scene can name, on the scene of a problem."""

import time
from dataclasses import dataclass

import numpy as np

from mbdfmi import Scene, steppers
from mbdfmi.compiler.model import compile_scene
from mbdfmi.kernels import entry
from mbdfmi.kernels.status import OK
from mbdfmi.run.follow import follow
from mbdfmi.run.instance import Instance, explain
from mbdfmi.scene import SceneError

from .contests import Cannot, Setting
from .problems import MOTION_SIZE, Problem


@dataclass(frozen=True)
class Stepper:
    """An integrator of ours as a contestant.

    name : in a scene's `solver`.  fixed : whether it takes a step rather than a tolerance.
    """

    name: str
    how: str
    fixed: bool = False
    kind = "ours"

    def settings(self, problem: Problem) -> list[Setting]:
        """From loose to tight."""
        key, values = ("step", problem.steps) if self.fixed else ("tolerance", problem.tolerances)
        return [Setting(f"{key} {value:.3g}", {key: value}, level) for level, value in enumerate(values)]

    def prepare(self, problem: Problem, setting: Setting) -> "OurRun":
        """A run to be timed. Raises Cannot."""
        solver = {"integrator": self.name} | setting.values

        try:
            scene = Scene.model_validate(problem.scene_tables(solver))
        except SceneError as error:
            raise Cannot(str(error).splitlines()[0]) from None

        inputs = problem.inputs(problem.data) if problem.inputs else None
        return OurRun(scene, problem.times, inputs)


STEPPERS = tuple(Stepper(record.name, record.words, record.fixed) for record in steppers.STEPPERS.values())


class OurRun:
    """A scene and the times to stop at. The loop over these is compiled, but for one that sets inputs.

    inputs : (s that each row is held for, rows (n, n_u)), or None.
    """

    def __init__(self, scene: Scene, times: np.ndarray, inputs: tuple[float, np.ndarray] | None = None):
        self.instance = Instance(compile_scene(scene))
        self.times, self.inputs = times, inputs
        self.rows = np.zeros((len(times), self.instance.model.n_y))

        # over no times: the loop is compiled, or its compiled form found, before anything is timed
        follow(self.instance.m, self.instance.d, times[:0], self.instance.y, self.rows)

    def run(self) -> tuple[float, np.ndarray]:
        """CPU seconds of the steps and outputs, and the motion (n_t, n_body, MOTION_SIZE). Raises Cannot."""
        m, d = self.instance.m, self.instance.d
        failure = entry.initialise(m, d, 0.0)
        start = time.process_time()
        failure = failure or (self._follow_inputs() if self.inputs else self._follow())
        seconds = time.process_time() - start

        if failure != OK:
            raise Cannot(explain(self.instance.model, failure))

        return seconds, self.rows.reshape(len(self.times), -1, MOTION_SIZE).copy()

    def _follow(self):
        return follow(self.instance.m, self.instance.d, self.times, self.instance.y, self.rows)

    def _follow_inputs(self):
        """A communication step for each row of inputs, from Python; outputs where a reference time is."""
        m, d, (step, values) = self.instance.m, self.instance.d, self.inputs
        u, row = self.instance.u[: values.shape[1]], 0

        for k, value in enumerate(values, 1):
            u[:] = value

            if failure := entry.step(m, d, k * step - self.instance.time):
                return failure

            if k * step > self.times[row] - 0.5 * step:
                entry.compute_outputs(m, d, self.rows[row])
                row += 1

        return OK

    @property
    def effort(self) -> dict[str, int]:
        """Steps taken, steps rejected and evaluations of the accelerations of the last run."""
        d = self.instance.d
        return {
            "steps": int(d.steps[0]),
            "rejected": int(d.rejected[0]),
            "evaluations": int(d.evaluations[0]),
        }
