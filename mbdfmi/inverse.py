"""Inverse dynamics: given the motion of some joints over time, the efforts that make it.

Each of these joints becomes a driven one; the efforts of the drives are those sought. They act
beside all else in the joint (spring, damper, friction, stop). Where loops close, as many joints
are given as there are degrees of freedom.
"""

import csv
from collections.abc import Callable, Mapping
from difflib import get_close_matches
from pathlib import Path

import numpy as np
from scipy.interpolate import make_interp_spline

from .compiler.joints import COORDINATES
from .kernels import project
from .kernels.status import OK
from .model import compile_scene
from .results import Results
from .scene import Scene, variable_name
from .scene.errors import listed
from .scene.efforts import AngularDriver, LinearDriver
from .simulate import Instance, SimulationError, explain
from .structure import DRIVEABLE, Mechanism
from .units import UNITS
from .variables import dotted

EFFORT = {"revolute": ("torque", "N.m"), "prismatic": ("force", "N")}
QUANTITIES = ("acceleration", "speed")

# how far joints go at once (rad, or parts of the scene's length) from where the scene starts to
# where the motion does
STRIDE = 0.05


def inverse(
    scene: Scene,
    motion: str | Path | Mapping[str, float | np.ndarray | Callable[[float], float]],
    times: np.ndarray | None = None,
    drive: list[str] | None = None,
    inputs: Mapping[str, float | np.ndarray] | None = None,
    parameters: Mapping[str, float] | None = None,
    progress: Callable[[float], None] | None = None,
) -> Results:
    """The efforts that a motion needs.

    motion : the coordinates of revolute and prismatic joints by name ("shoulder.angle",
        "boom.position"), at `times` or at its own "time": an array, a number (held), or a function
        of time. Speeds and accelerations ("shoulder.speed", "shoulder.acceleration") are taken
        where they are given, else from a spline through the positions (of degree 5 where there are
        points enough), or from `.derivative(n)` of a function that has it. Or the path of a CSV
        file of such columns, or Results of a run: what is no joint's coordinate there is passed
        over.
    times : (n,) s, ascending; needed where functions are given and no "time".
    drive : which joints of those given in the motion to drive (default: all).
    inputs, parameters : as in `simulate`; numbers, or arrays over the times.
    progress : called with the time reached (s).

    Returns Results: "<joint>.torque" (N m) or "<joint>.force" (N) of each joint driven, then its
    motion and all outputs of the scene. Raises ValueError where the motion does not fit the scene,
    SimulationError where the loops cannot follow it.
    """
    if isinstance(motion, (str, Path)):
        motion = read_motion(motion)

    times = _times(motion, times)
    known, given = _coordinates(scene), {}

    for name in motion:
        if name in known:
            given.setdefault(known[name][0], {})[known[name][1]] = motion[name]
        elif name != "time" and not isinstance(motion, Results):
            raise ValueError(f"the motion's {name!r} is no joint coordinate; {_meant(name, known)}")

    for name in drive or ():
        if name not in given:
            raise ValueError(f"joint {name!r} is to be driven, but the motion does not tell how")

    joints = list(drive or given)
    courses = {name: _course(name, scene.joint[name], given[name], times) for name in joints}
    mechanism = Mechanism(scene, joints)
    _check_freedoms(mechanism, joints)
    starts = {name: mechanism.position(name) for name in joints}
    scene, length = _driven(scene, joints), mechanism.length
    return _run(scene, joints, courses, starts, times, length, inputs, parameters, progress)


# the motion


def read_motion(path) -> Results:
    """The columns of a CSV file by name, in SI units; its first row holds names, "shoulder.angle"
    or "shoulder.angle [deg]".

    Raises ValueError with the file's name, row and column.
    """
    with open(path, newline="", encoding="utf-8-sig") as file:
        lines = [line for line in csv.reader(file) if any(cell.strip() for cell in line)]

    if len(lines) < 2:
        raise ValueError(f"{path}: needs a row of names and at least one of numbers")

    columns, units = {}, {}

    for k, heading in enumerate(lines[0]):
        name, _, unit = heading.strip().removesuffix("]").partition(" [")
        unit, factor = _unit(unit)

        if unit is None and factor is None:
            raise ValueError(f"{path}: column {heading!r}: unknown unit; SI units may be left out")

        if name in columns:
            raise ValueError(f"{path}: two columns are called {name!r}")

        cells = [_cell(path, line, row, k, name) for row, line in enumerate(lines[1:], 2)]
        columns[name] = np.array(cells) / factor
        units[name] = unit

    if "time" not in columns:
        raise ValueError(f'{path}: has no column "time" (s); there are {listed(columns)}')

    return Results(columns, units, str(path))


def _cell(path, line, row, k, name):
    text = line[k].strip() if k < len(line) else ""

    try:
        value = float(text)
    except ValueError:
        value = np.nan

    if not np.isfinite(value):
        raise ValueError(f"{path}: row {row}, column {name!r}: needs a number, found {text!r}")

    return value


def _unit(text):
    """(SI unit, factor of the unit by it) of a unit's name; (None, 1) for none, (None, None) for
    an unknown one.
    """
    if not text or text in UNITS:
        return text or None, 1.0

    for name, unit in UNITS.items():
        for display, factor in unit.display:
            if display == text:
                return name, factor

    return None, None


def _times(motion, times):
    """(n,) s"""
    times = motion.get("time") if times is None else times

    if times is None:
        raise ValueError('the motion has no "time"; give times, as in times=np.linspace(0, 1, 101)')

    times = np.atleast_1d(np.asarray(times, float))

    if times.ndim != 1 or not np.all(np.isfinite(times)) or np.any(np.diff(times) <= 0):
        raise ValueError("the motion's times must ascend")

    return times


def _coordinates(scene):
    """Name of a coordinate, speed or acceleration -> (joint, which of "position", "speed",
    "acceleration").
    """
    known = {}

    for name, joint in scene.joint.items():
        if joint.kind in DRIVEABLE:
            position = COORDINATES[joint.kind][0][0]

            for quantity in (position, *QUANTITIES):
                what = "position" if quantity == position else quantity
                known[dotted(name, quantity)] = known[f"{name}.{quantity}"] = (name, what)

    return known


def _meant(name, known):
    if close := get_close_matches(name, known, n=1):
        return f"did you mean {close[0]!r}?"

    return f"there are {listed(list(known)[:12]) or 'none: no joint is revolute or prismatic'}"


def _course(name, joint, given, times):
    """(n, 3) position, speed and acceleration of a joint at the times."""
    position = given.get("position")

    if position is None:
        told = " and ".join(given)
        raise ValueError(f"the motion tells the {told} of {name!r}, but not its position over time")

    if callable(position) and hasattr(position, "derivative"):
        courses = [position] + [position.derivative(n) for n in (1, 2)]
        columns = [np.array([float(course(t)) for t in times]) for course in courses]
    else:
        values = _column(name, position, times)
        columns = [values, *_slopes(times, values)]

    for k, what in ((1, "speed"), (2, "acceleration")):
        if what in given:
            columns[k] = _column(name, given[what], times)

    return np.column_stack(columns)


def _column(name, values, times):
    """(n,) of a number, an array or a function of time."""
    values = [float(values(t)) for t in times] if callable(values) else values
    values = np.asarray(values, float)

    if values.shape not in ((), times.shape):
        found = f"found shape {values.shape}"
        raise ValueError(f"the motion of {name!r} needs {len(times)} values, one a time; {found}")

    if not np.all(np.isfinite(values)):
        raise ValueError(f"the motion of {name!r} is not finite")

    return np.broadcast_to(values, times.shape)


def _slopes(times, values):
    """First and second derivative of the spline through the points."""
    if len(times) == 1:
        return np.zeros(1), np.zeros(1)

    degree = min(5, len(times) - 1)
    spline = make_interp_spline(times, values, k=degree if degree % 2 else degree - 1)
    return [spline.derivative(n)(times) if n <= spline.k else np.zeros_like(times) for n in (1, 2)]


# the driven scene


def _driven(scene, joints):
    """The scene with these joints driven by inputs. Its outputs stay, and "effort" is added."""
    changed = {}

    for name in joints:
        joint = scene.joint[name]
        driver = (AngularDriver if joint.kind == "revolute" else LinearDriver)(input=True)
        wanted = [COORDINATES[joint.kind][0][0], *QUANTITIES[::-1]]
        outputs = [output for output in joint.output if output not in ("effort", *wanted)]
        changed[name] = joint.model_copy(
            update={"driver": driver, "input": [], "output": ["effort", *wanted, *outputs]}
        )

    formulation = scene.solver.formulation
    solver = scene.solver.model_copy(
        update={"formulation": "auto" if formulation == "augmented" else formulation}
    )
    return scene.model_copy(update={"joint": scene.joint | changed, "solver": solver})


def _command(scene, name, ending):
    """Name of the input that drives a joint; `ending` "" for its position, else "speed" or
    "acceleration".
    """
    quantity = ending or COORDINATES[scene.joint[name].kind][0][0]
    return dotted(name, f"{quantity}_command")


def _check_freedoms(mechanism, joints):
    """Raises ValueError unless drives of these joints determine the motion, and each is needed for
    it.
    """
    place = mechanism.generic()
    freedoms = place.motions.shape[1]
    taken = mechanism.driven_freedoms(place, joints)

    if taken < len(joints):
        raise ValueError(
            f"the motion gives {listed(joints)}, but some of these follow from the others: the scene "
            f"has {_degrees(freedoms)} of freedom; drive fewer of them (drive=[...], or --drive JOINT)"
        )

    if taken < freedoms:
        could = mechanism.driveable(place, joints)
        hint = f"of these could be driven too: {listed(could)}"
        raise ValueError(
            f"the motion of {listed(joints) or 'no joint'} leaves {_degrees(freedoms - taken)} of "
            f"freedom undetermined; {hint if could else 'no revolute or prismatic joint moves in them'}"
        )


def _degrees(n):
    return f"{n} degree{'s' * (n != 1)}"


# the run


def _run(scene, joints, courses, starts, times, length, inputs, parameters, progress):
    model = compile_scene(scene)
    at = {v.name: v.index for v in model.of_causality("input")}
    commands = {name: at[_command(scene, name, "")] for name in joints}
    own = {_command(scene, name, ending) for name in joints for ending in ("", *QUANTITIES)}
    signals = _signals(at, own, inputs, times)
    first = {k: values[0] for k, values in signals}
    first |= {commands[name]: starts[name] for name in joints}
    instance = Instance(model, parameters, times[0], first)
    _approach(instance, scene, joints, commands, starts, courses, length)
    columns = np.empty((len(times), model.n_y))

    for k in range(len(times)):
        for position, values in signals:
            instance.u[position] = values[k]

        for name in joints:
            instance.u[commands[name] : commands[name] + 3] = courses[name][k]

        _close(instance)
        columns[k] = instance.outputs()

        if k + 1 < len(times):
            _advance(instance, commands, courses, k, times[k + 1] - times[k])

            if progress:
                progress(instance.time)

    return _results(model, scene, joints, times, columns)


def _signals(at, commands, inputs, times):
    """(position in u, values (n,)) of each input that is no drive's."""
    signals = []

    for name, values in (inputs or {}).items():
        name = variable_name(name)
        parts = [key for key in at if key.startswith(f"{name}[")] if name not in at else [name]

        if not parts or parts[0] in commands:
            others = ", ".join(key for key in at if key not in commands)
            raise KeyError(f"no input {name!r} beside the motion; there are {others or 'none'}")

        values = np.asarray(values, float)
        shape = times.shape if len(parts) == 1 else (len(times), len(parts))
        columns = np.broadcast_to(values, shape).reshape(len(times), -1)
        signals += [(at[part], column) for part, column in zip(parts, columns.T)]

    return signals


def _approach(instance, scene, joints, commands, starts, courses, length):
    """From where the scene starts to where the motion does, in short strides at rest, so that
    loops stay in their branch.
    """
    span = {name: courses[name][0, 0] - starts[name] for name in joints}
    unit = {"revolute": 1.0, "prismatic": length}
    strides = [abs(span[name]) / unit[scene.joint[name].kind] for name in joints]
    n = int(np.ceil(max(strides, default=0.0) / STRIDE))

    for k in range(1, n):
        for name in joints:
            u = commands[name]
            instance.u[u : u + 3] = starts[name] + span[name] * k / n, 0.0, 0.0

        _close(instance)


def _close(instance):
    """Positions and velocities to where the drives want them."""
    status = project.project(instance.m, instance.d)

    if status != OK:
        raise _out_of_reach(explain(instance.model, status), instance.time)


def _advance(instance, commands, courses, k, H):
    """To the next of the times; the accelerations are those that lead to its positions."""
    for name, u in commands.items():
        position, speed, _ = courses[name][k]
        instance.u[u + 2] = 2.0 * (courses[name][k + 1][0] - position - speed * H) / H**2

    try:
        instance.step(H)
    except SimulationError as error:
        raise _out_of_reach(str(error).partition(" (time")[0], error.time) from None


def _out_of_reach(reason, time):
    return SimulationError(f"{reason}; the motion may lead out of reach (time {time:.9g} s)", time)


def _results(model, scene, joints, times, columns):
    """Efforts first, under the names of the inputs that would apply them."""
    found, units = {"time": times}, {"time": "s"}
    efforts = {}

    for name in joints:
        what, unit = EFFORT[scene.joint[name].kind]
        efforts[dotted(name, "effort")] = dotted(name, what)
        found[dotted(name, what)], units[dotted(name, what)] = None, unit

    for v, column in zip(model.of_causality("output"), columns.T):
        name = efforts.get(v.name, v.name)
        found[name] = column
        units[name] = v.unit

    return Results(found, units, f"{model.title}: efforts", model.notices)
