"""Inverse dynamics: given the motion of some joints over time, the efforts that make it.

The joints told are held to their motion (hybrid dynamics: their accelerations are given, all others
found), and what holds them is sought. It acts beside all else in the joint (spring, damper,
friction, stop). Where loops close, as many freedoms are told as there are. What is left can go on
freely from the scene's start: a floating base, a rod that may spin between two balls.
"""

from collections.abc import Callable, Mapping
from pathlib import Path

import numpy as np
from scipy.integrate import DOP853
from scipy.interpolate import BPoly

from ..compiler.joint_kinds import kind_of, scalars
from ..compiler.variables import dotted, subscripts
from ..kernels import joints, layout, outputs
from ..kernels.dynamics import projection, rates
from ..kernels.motion import commands
from ..kernels.status import OK
from ..run.inputs import known
from ..run.instance import Instance, SimulationError, explain
from ..run.results import Results
from ..scene import SceneData, variable_name
from ..scene.errors import listed
from .driven import check_freedoms, driven_parts, started, undriven
from .mechanism import Mechanism
from .motion import courses_of, given_motion, times_of

# how far joints go at once (rad, or parts of the scene's length) from where the scene starts to
# where the motion does
STRIDE = 0.05

# relative and absolute tolerances of what goes on freely, and of loops that follow, which are closed
# at every time
FREE_TOLERANCE = 1e-12
TOLERANCE = 1e-9


def inverse(
    scene: SceneData,
    motion: str | Path | Mapping[str, float | np.ndarray | Callable[[float], float]],
    times: np.ndarray | None = None,
    drive: list[str] | None = None,
    inputs: Mapping[str, float | np.ndarray] | None = None,
    parameters: Mapping[str, float] | None = None,
    progress: Callable[[float], None] | None = None,
    hybrid: bool = False,
) -> Results:
    """The efforts that a motion needs.

    motion : the coordinates of joints by name ("shoulder.angle", "boom.position", "cardan.angles",
        of spherical and free ones "float.position", "float.euler_parameters" or "float.zyx"), at
        `times` or at its own "time": an array, a number (held), or a function of time; a vector's
        components in columns, or each by itself ("float.position[3]"). Speeds and accelerations
        ("shoulder.speed", "shoulder.acceleration", "float.velocity", "float.omega", ...) are taken
        where they are given, else from a spline through the positions (of degree 5 where there are
        points enough), or from `.derivative(n)` of a function that has it. Or the path of a CSV
        file of such columns, or Results of a run: what is no joint's coordinate there is passed
        over, and so are joints that no motor moves where they follow from the others.
    times : (n,) s, ascending; needed where functions are given and no "time".
    drive : which joints of those given in the motion to drive (default: all).
    inputs, parameters : as in `simulate`; numbers, or arrays over the times.
    progress : called with the time reached (s).
    hybrid : what the motion leaves open goes on freely from the scene's start; between the times
        the motion is then a polynomial of degree 5. Without it, this holds where no revolute or
        prismatic joint moves in what is left: a floating base, idle spins. `notices` tell it.

    Returns Results: "<joint>.torque" (N m) or "<joint>.force" (N) of each joint driven, then its
    motion and all outputs of the scene. A universal joint has "torques" about its axes, a free one
    "force" and "moment" on its second marker, about its origin and in the first one's axes. Powers
    among the outputs are those of all else. Raises ValueError where the motion does not fit the
    scene, SimulationError where the loops cannot follow it.
    """
    if isinstance(motion, (str, Path)):
        motion = Results.from_csv(motion)

    times = times_of(motion, times)
    given = given_motion(scene, motion)

    for name in drive or ():
        if name not in given:
            raise ValueError(f"joint {name!r} is to be driven, but the motion does not tell how")

    names = list(drive or given)
    courses = {name: courses_of(name, scene.joint[name], given[name], times) for name in names}
    scene = started(undriven(scene, names), names)
    mechanism = Mechanism(scene, names)
    told = driven_parts(mechanism.model, courses)
    told, free = check_freedoms(mechanism, told, isinstance(motion, Results) and not drive, hybrid)
    run = _Run(mechanism, told, times, inputs, parameters)
    return run.results(FREE_TOLERANCE if free else TOLERANCE, _notices(free), progress)


def _notices(free):
    if not free:
        return []

    return [
        f"the motion leaves freedoms of {listed(free)} open: they go on freely from the scene's start; a "
        "spin that nothing drives stays as it starts, zero unless the scene starts with one"
    ]


class _Run:
    """A model whose joints told are held to their motion."""

    def __init__(self, mechanism, told, times, inputs, parameters):
        self.scene, self.told, self.times = mechanism.scene, told, times
        self.length = mechanism.length
        self.parts = [part for parts in told.values() for part in parts]
        model = mechanism.model
        at = {v.name: v.index for v in model.of_causality("input")}
        self.signals = _signals(at, inputs, times)
        self.instance = Instance(model, parameters, times[0], {k: values[0] for k, values in self.signals})
        self.m, self.d = self.instance.m, self.instance.d
        self._ask_for_reactions(model)
        held = {v for part in self.parts for v in part.velocities(self.m)}
        self.free_v = [v for v in range(self.m.n_v) if v not in held]
        places = {self.m.n_q + v for v in held} | {q for part in self.parts for q in part.positions(self.m)}
        self.loose = [k for k in range(self.m.n_x) if k not in places]
        self.between: list[BPoly] = []

        if len(times) > 1:
            courses = [[part.course[k].T for k in range(len(times))] for part in self.parts]
            self.between = [BPoly.from_derivatives(times, course) for course in courses]

    def _ask_for_reactions(self, model):
        """Outputs are to find reactions, whichever there are; held joints count as driven ones."""
        every = sum(outputs.NEEDS)
        model.ints[layout.COUNTS.index("output_needs")] = every
        self.m.__dict__["output_needs"] = every

        for part in self.parts:
            self.m.body_drive[part.nodes] = 0

    def results(self, tolerance, notices, progress):
        """The efforts, the motion and the outputs at all times."""
        m, d, times = self.m, self.d, self.times
        velocity = d.v[self.free_v].copy()
        self._approach()
        d.v[self.free_v] = velocity
        columns = np.empty((len(times), self.instance.model.n_y))
        efforts = {name: [] for name in self.told}

        for k, t in enumerate(times):
            self._set(t, [part.course[k] for part in self.parts])
            self._close()
            columns[k] = self.instance.outputs()

            for name in self.told:
                efforts[name].append(np.concatenate([part.effort(m, d) for part in self.told[name]]))

            if k + 1 < len(times):
                self._advance(t, times[k + 1], tolerance)

                if progress:
                    progress(times[k + 1])

        return self._results(efforts, columns, notices)

    def _set(self, t, values):
        """Time, inputs and the joints told at time t (s); values : (size, 3) of each part."""
        self.d.time[:] = t, 0.0
        self.d.now[0] = t

        for position, column in self.signals:
            self.instance.u[position] = np.interp(t, self.times, column)

        commands.plan(self.m, self.d, 0.0)

        for part, value in zip(self.parts, values):
            part.put(self.m, self.d, value)

    def _approach(self):
        """From where the scene starts to where the motion does, in short strides at rest, so that
        loops stay in their branch.
        """
        m, d = self.m, self.d
        starts, spans = [], []

        for part in self.parts:
            start, end = part.where(m, d), part.course[0][:, 0]

            if part.is_pose and start[-4:] @ end[-4:] < 0.0:
                start[-4:] *= -1.0

            starts.append(start)
            spans.append(end - start)

        strides = [np.abs(span / self._units(part)).max() for part, span in zip(self.parts, spans)]
        n = int(np.ceil(max(strides, default=0.0) / STRIDE)) if m.n_row else 0

        for k in range(1, n):
            places = [start + span * k / n for start, span in zip(starts, spans)]
            at_rest = [np.column_stack([place, 0.0 * place, 0.0 * place]) for place in places]
            self._set(self.times[0], at_rest)
            self._close()

    def _units(self, part):
        """What of each of its positions compares with a radian."""
        lengths = sum(joints.N_SLIDE[self.m.body_joint[i]] for i in part.nodes)
        return np.append(np.full(lengths, self.length), np.ones(part.course.shape[1] - lengths))

    def _close(self):
        """Positions and velocities to where the joints told want them."""
        status = projection.project(self.m, self.d)

        if status != OK:
            raise _out_of_reach(explain(self.instance.model, status), self.instance.time)

    def _advance(self, t, end, tolerance):
        """What is not told, to the next of the times (s): it moves freely, or as loops lead it."""
        if not self.loose:
            return

        solver = DOP853(self._rate, t, self.d.x[self.loose].copy(), end, rtol=tolerance, atol=tolerance)

        while solver.status == "running":
            problem = solver.step()

            # the loop that does not close says more than the step that was too small
            if solver.status == "failed":
                self._see(end, solver.y)
                self._close()
                raise _out_of_reach(problem.rstrip("."), solver.t)

            self._see(solver.t, solver.y)
            self._close()

            # the projection is part of the motion; it is small beside the tolerance
            if solver.status == "running":
                solver.y = self.d.x[self.loose].copy()
                solver.f = self._rate(solver.t, solver.y)

    def _see(self, t, loose):
        """The state at time t (s) between two of the times."""
        self.d.x[self.loose] = loose
        self._set(t, [np.stack([course(t, n) for n in range(3)], axis=1) for course in self.between])

    def _rate(self, t, loose):
        self._see(t, loose)
        status = rates.evaluate(self.m, self.d, 0.0)

        if status != OK:
            raise _out_of_reach(explain(self.instance.model, status), t)

        return self.d.x_rate[self.loose].copy()

    def _results(self, efforts, columns, notices):
        """Efforts first, under the names of the inputs that would apply them."""
        found: dict[str, np.ndarray] = {"time": self.times}
        units: dict[str, str | None] = {"time": "s"}
        model = self.instance.model

        for name in self.told:
            names = _effort_names(name, self.scene.joint[name], self.told[name])

            for (variable, unit), column in zip(names, np.array(efforts[name]).T):
                found[variable], units[variable] = column, unit

        for v, column in zip(model.of_causality("output"), columns.T):
            found[v.name] = column
            units[v.name] = v.unit

        return Results(found, units, f"{model.title}: efforts", [*model.notices, *notices])


def _effort_names(name, joint, parts):
    """[(variable, unit)] of what holds a joint, in the order of its parts' efforts."""
    if kind_of(joint).is_pose:
        efforts = [coordinate.effort for coordinate in joint.coordinates]
    else:
        along = [scalar.coordinate.effort for scalar in scalars(joint)]
        efforts = [along[part.first] for part in parts]

    return [
        (dotted(name, effort.name) + ending, effort.unit)
        for effort in efforts
        for ending in subscripts(effort.shape)
    ]


def _signals(at, inputs, times):
    """(position in u, values (n,)) of each input."""
    signals = []

    for name, values in (inputs or {}).items():
        name = variable_name(name)
        parts = known(name, at, "input")
        values = np.asarray(values, float)
        shape = times.shape if len(parts) == 1 else (len(times), len(parts))
        columns = np.broadcast_to(values, shape).reshape(len(times), -1)
        signals += [(at[part], column) for part, column in zip(parts, columns.T)]

    return signals


def _out_of_reach(reason, time):
    return SimulationError(f"{reason}; the motion may lead out of reach (time {time:.9g} s)", time)
