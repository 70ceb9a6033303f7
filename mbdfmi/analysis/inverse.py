"""Inverse dynamics: given the motion of some joints over time, the efforts that make it.

The joints told are held to their motion (hybrid dynamics: their accelerations are given, all others
found), and what holds them is sought. It acts beside all else in the joint (spring, damper,
friction, stop). Where loops close, as many freedoms are told as there are. What is left can go on
freely from the scene's start: a floating base, a rod that may spin between two balls.
"""

import csv
from collections.abc import Callable, Mapping
from difflib import get_close_matches
from pathlib import Path

import numpy as np
from scipy.integrate import DOP853
from scipy.interpolate import BPoly, make_interp_spline

from ..compiler.joints import COORDINATES
from ..compiler.topology import spanning_tree
from ..compiler.variables import dotted, subscripts
from ..kernels import algebra, commands, joints, layout, outputs, project, rates
from ..kernels.status import OK
from ..run.instance import Instance, SimulationError, explain
from ..run.results import Results
from ..scene import Scene, variable_name
from ..scene.errors import listed
from ..scene.starts import PrismaticStart, RevoluteStart
from ..units import UNITS
from .mechanism import DRIVEABLE, ZERO, Mechanism

EFFORTS = {"rad": ("torque", "N.m"), "m": ("force", "N")}

# outputs of a driver or an input, which a joint told has no longer
DROPPED = ("effort", "driver_effort", "input_effort")

# of joints whose position is more than a list of numbers: quantities of a motion and their sizes
ORIENTATION = {"euler_parameters": 4, "zyx": 3, "zyx_rate": 3, "omega": 3, "alpha": 3}
POSES = {"spherical": ORIENTATION, "free": {"position": 3, "velocity": 3, "acceleration": 3} | ORIENTATION}
POSE_OUTPUTS = {
    "spherical": ["euler_parameters", "omega", "alpha"],
    "free": ["position", "euler_parameters", "velocity", "omega"],
}

# how far joints go at once (rad, or parts of the scene's length) from where the scene starts to
# where the motion does
STRIDE = 0.05

# relative and absolute tolerances of what goes on freely, and of loops that follow, which are closed
# at every time
FREE_TOLERANCE = 1e-12
TOLERANCE = 1e-9


def inverse(
    scene: Scene,
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
        motion = read_motion(motion)

    times = _times(motion, times)
    given = _given(scene, motion)

    for name in drive or ():
        if name not in given:
            raise ValueError(f"joint {name!r} is to be driven, but the motion does not tell how")

    names = list(drive or given)
    courses = {name: _courses(name, scene.joint[name], given[name], times) for name in names}
    scene = _started(_undriven(scene, names), names)
    mechanism = Mechanism(scene, names)
    told = _told(mechanism.model, courses)
    told, free = _check_freedoms(mechanism, told, isinstance(motion, Results) and not drive, hybrid)
    run = _Run(mechanism, told, times, inputs, parameters)
    return run.results(FREE_TOLERANCE if free else TOLERANCE, _notices(free), progress)


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
        name, _, unit = heading.strip().partition(" [")
        unit, factor = _unit(unit.removesuffix("]"))

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


def _quantities(joint):
    """Quantities of a joint's motion: name -> (its coordinates, 0 position 1 speed 2 acceleration).

    Of a pose the order is None.
    """
    found = {}

    for k, (position, speed, _) in enumerate(COORDINATES.get(joint.kind, ())):
        of = found.setdefault(position, ([], 0))[0]
        of.append(k)
        found[speed] = (of, 1)

    if joint.kind in DRIVEABLE:
        found["acceleration"] = ([0], 2)

    return found or {name: (list(range(size)), None) for name, size in POSES.get(joint.kind, {}).items()}


def _given(scene, motion):
    """joint -> quantity -> what the motion gives for it, a component by itself under its number."""
    known = {}

    for name, joint in scene.joint.items():
        for quantity in _quantities(joint):
            known[dotted(name, quantity)] = known[f"{name}.{quantity}"] = (name, quantity)

    given = {}

    for key in motion:
        base, _, index = key.partition("[")

        if base in known:
            name, quantity = known[base]
            values = given.setdefault(name, {})

            if index:
                values.setdefault(quantity, {})[int(index.rstrip("]"))] = motion[key]
            else:
                values[quantity] = motion[key]
        elif key != "time" and not isinstance(motion, Results):
            raise ValueError(f"the motion's {key!r} is no joint coordinate; {_meant(key, known)}")

    # a run may tell some joint's speed alone
    if isinstance(motion, Results):
        return {name: values for name, values in given.items() if _is_located(scene.joint[name], values)}

    return given


def _is_located(joint, values):
    """Whether values tell a joint's position."""
    if joint.kind in POSES:
        turned = "euler_parameters" in values or "zyx" in values
        return turned and (joint.kind == "spherical" or "position" in values)

    return any(order == 0 and quantity in values for quantity, (_, order) in _quantities(joint).items())


def _meant(name, known):
    if close := get_close_matches(name, known, n=1):
        return f"did you mean {close[0]!r}?"

    return f"there are {listed(list(known)[:12]) or 'none'}"


def _courses(name, joint, given, times):
    """[(coordinates, (n, size, 3) their values, rates and second rates)] of a joint; of a pose one, of
    all that it has.
    """
    if not _is_located(joint, given):
        told = " and ".join(given)
        raise ValueError(f"the motion tells the {told} of {name!r}, but not its position over time")

    quantities = _quantities(joint)

    if joint.kind in POSES:
        parts = [_turning(name, given, times)]

        if joint.kind == "free":
            parts.insert(0, _course(name, given, times, ("position", "velocity", "acceleration"), 3))

        return [(None, np.concatenate(parts, axis=1))]

    found = []

    for quantity, (of, order) in quantities.items():
        if order == 0 and quantity in given:
            speeds = [key for key, (other, order) in quantities.items() if other == of and order == 1]
            keys = (quantity, *speeds, "acceleration")
            found.append((of, _course(name, given, times, keys, len(of))))

    return found


def _course(name, given, times, keys, size):
    """(n, size, 3) values, rates, second rates of a quantity; `keys`: what these three are called."""
    values = given[keys[0]]

    if callable(values) and hasattr(values, "derivative"):
        courses = [values] + [values.derivative(n) for n in (1, 2)]
        columns = [_columns(name, course, times, size) for course in courses]
    else:
        columns = _columns(name, values, times, size)
        columns = [columns, *_slopes(times, columns)]

    for k in (1, 2):
        if keys[k] in given:
            columns[k] = _columns(name, given[keys[k]], times, size)

            # accelerations that nobody tells follow from the speeds that somebody does
            if k == 1 and keys[2] not in given:
                columns[2] = _slopes(times, columns[1])[0]

    return np.stack(columns, axis=2)


def _columns(name, values, times, size):
    """(n, size) of a vector: by component, or all at once as numbers, an array or a function of time."""
    if isinstance(values, dict):
        if sorted(values) != list(range(1, size + 1)):
            found = listed(map(str, sorted(values)))
            raise ValueError(f"the motion of {name!r} needs {size} components; found {found}")

        return np.column_stack([_column(name, values[k], times) for k in range(1, size + 1)])

    if size == 1:
        return _column(name, values, times)[:, None]

    if callable(values):
        values = [np.asarray(values(t), float) for t in times]

    values = np.asarray(values, float)

    if values.shape not in ((size,), (len(times), size)):
        found = f"found shape {values.shape}"
        rows = f"{size} values, or rows of them for {len(times)} times"
        raise ValueError(f"the motion of {name!r} needs {rows}; {found}")

    if not np.all(np.isfinite(values)):
        raise ValueError(f"the motion of {name!r} is not finite")

    return np.broadcast_to(values, (len(times), size))


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
        return np.zeros_like(values), np.zeros_like(values)

    degree = min(5, len(times) - 1)
    spline = make_interp_spline(times, values, k=degree if degree % 2 else degree - 1)
    return [spline.derivative(n)(times) if n <= spline.k else np.zeros_like(values) for n in (1, 2)]


def _turning(name, given, times):
    """(n, 4, 3) Euler parameters, which need no unit length, and their first two rates."""
    if "euler_parameters" in given:
        values = given["euler_parameters"]

        if not callable(values):
            values = _columns(name, values, times, 4)
            jumps = np.sum(values[1:] * values[:-1], axis=1) < 0.0
            values = values * np.append(1.0, np.where(np.cumsum(jumps) % 2 == 1, -1.0, 1.0))[:, None]

        course = _course(name, {"E": values}, times, ("E", "", ""), 4)

        if not np.all(np.linalg.norm(course[:, :, 0], axis=1) > 0.0):
            raise ValueError(f"the motion of {name!r} has Euler parameters of zero length")
    else:
        values = given["zyx"]
        values = values if callable(values) else np.unwrap(_columns(name, values, times, 3), axis=0)
        known = {"zyx": values} | {key: given[key] for key in ("zyx_rate",) if key in given}
        course = _of_zyx(_course(name, known, times, ("zyx", "zyx_rate", ""), 3))

    if "omega" in given:
        course = course / np.linalg.norm(course[:, :, 0], axis=1)[:, None, None]
        w = _columns(name, given["omega"], times, 3)
        alpha = _columns(name, given["alpha"], times, 3) if "alpha" in given else _slopes(times, w)[0]

        for E, w, alpha in zip(course, w, alpha):
            E[:, 1] = 0.5 * _product((*w, 0.0), E[:, 0])
            E[:, 2] = 0.5 * (_product((*alpha, 0.0), E[:, 0]) + _product((*w, 0.0), E[:, 1]))

    return course


def _product(a, b):
    """Product of Euler parameters (4,), scalar last."""
    return np.array(algebra.E_product(tuple(map(float, a)), tuple(map(float, b))))


def _of_zyx(angles):
    """Euler parameters and their rates (n, 4, 3) of yaw, pitch, roll and theirs (n, 3, 3): a product of
    three rotations.
    """
    course = np.empty((len(angles), 4, 3))

    for k, of in enumerate(angles):
        total = None

        for axis, (angle, rate, rate2) in zip((2, 1, 0), of):
            c, s = np.cos(0.5 * angle), np.sin(0.5 * angle)
            one = np.zeros((3, 4))
            one[:, axis] = s, 0.5 * c * rate, 0.5 * c * rate2 - 0.25 * s * rate**2
            one[:, 3] = c, -0.5 * s * rate, -0.5 * s * rate2 - 0.25 * c * rate**2
            a, b = total, one
            total = one if a is None else np.array([
                _product(a[0], b[0]),
                _product(a[1], b[0]) + _product(a[0], b[1]),
                _product(a[2], b[0]) + 2.0 * _product(a[1], b[1]) + _product(a[0], b[2]),
            ])  # fmt: skip

        course[k] = total.T

    return course


# the scene and its freedoms


def _undriven(scene, names):
    """The scene without drivers and inputs in these joints, whose motion goes out with what else did."""
    changed = {}

    for name in names:
        joint = scene.joint[name]
        wanted = POSE_OUTPUTS.get(joint.kind) or [q for row in COORDINATES[joint.kind] for q in row[:2]]
        wanted = [*dict.fromkeys(wanted), *(["acceleration"] if joint.kind in DRIVEABLE else [])]
        rest = [output for output in joint.output if output not in (*DROPPED, *wanted)]
        own = {"driver": None, "input": [], "output": [*wanted, *rest]}
        own = {key: value for key, value in own.items() if key in type(joint).model_fields}
        changed[name] = joint.model_copy(update=own)

    formulation = scene.solver.formulation
    solver = scene.solver.model_copy(
        update={"formulation": "auto" if formulation == "augmented" else formulation}
    )
    return scene.model_copy(update={"joint": scene.joint | changed, "solver": solver})


def _started(scene, names):
    """The scene with those joints that close its loops started where they are found when it is
    assembled: they will be in the tree, and others close the loops.
    """
    cuts = set(spanning_tree(scene).cuts) & {name for name in names if scene.joint[name].kind in DRIVEABLE}

    if not cuts:
        return scene

    mechanism = Mechanism(scene)
    changed = {}

    for name in cuts:
        value = mechanism.position(name)
        joint = scene.joint[name]
        start = RevoluteStart(angle=value) if joint.kind == "revolute" else PrismaticStart(position=value)
        changed[name] = joint.model_copy(update={"start": start})

    return scene.model_copy(update={"joint": scene.joint | changed})


class _Told:
    """A joint of the tree, or some coordinates of it, and their motion.

    nodes : one for each coordinate, in the joint's order; of a spherical or free joint its one.
    course : (n, size, 3) values, rates, second rates.
    """

    def __init__(self, model, nodes, course):
        tree, self.kind = model.tree, model.tree.nodes[nodes[0]].kind
        self.nodes = nodes
        self.reversed = tree.nodes[nodes[0]].reversed
        self.course = course

    @property
    def is_pose(self):
        return self.kind in POSES

    def velocities(self, m):
        """Places of its velocity coordinates in v."""
        return [m.body_v[i] + k for i in self.nodes for k in range(joints.N_V[m.body_joint[i]])]

    def positions(self, m):
        """Places of its position coordinates in q."""
        return [m.body_q[i] + k for i in self.nodes for k in range(joints.N_Q[m.body_joint[i]])]

    def put(self, m, d, values):
        """Positions and speeds of values, rates, second rates (size, 3) into the state, accelerations into
        x'; it is held.
        """
        d.held[self.nodes] = 1.0
        v = [m.n_q + k for k in self.velocities(m)]

        if not self.is_pose:
            d.x[self.positions(m)], d.x[v], d.x_rate[v] = values.T
            return

        r, E = (values[:3].T, values[3:].T) if self.kind == "free" else (np.zeros((3, 3)), values.T)
        E, w, alpha = _rotation(E)
        A = np.array(algebra.E_matrix(tuple(E)))

        # the tree needs the inverse motion where the joint's first marker is on its body
        if self.reversed:
            u = r[1] - np.cross(w, r[0])
            u_rate = r[2] - np.cross(alpha, r[0]) - np.cross(w, r[1])
            r = -np.array([A.T @ r[0], A.T @ u, A.T @ (u_rate - np.cross(w, u))])
            E, w, alpha, A = E * [-1, -1, -1, 1], -A.T @ w, -A.T @ alpha, A.T

        n = len(values) - 4
        q = self.positions(m)
        d.x[q[:n]], d.x[v[:n]], d.x_rate[v[:n]] = r[:, :n]
        d.x[q[n:]], d.x[v[n:]], d.x_rate[v[n:]] = E, A.T @ w, A.T @ alpha

    def where(self, m, d):
        """Its positions (size,) in the state."""
        q = d.x[self.positions(m)].copy()

        if not (self.is_pose and self.reversed):
            return q

        E = q[-4:] * [-1, -1, -1, 1]
        return np.append(-np.array(algebra.E_matrix(tuple(E))) @ q[:-4], E) if self.kind == "free" else E

    def effort(self, m, d):
        """What holds it, once all reactions are found: along its coordinates, or (force and) moment."""
        moment, force = d.bias_moment.reshape(-1, 3), d.bias_force.reshape(-1, 3)

        if not self.is_pose:
            borne = [(moment if m.body_joint[i] == joints.REVOLUTE else force)[i] for i in self.nodes]
            return np.sum(d.axis.reshape(-1, 3)[self.nodes] * borne, axis=1) - d.tau[self.velocities(m)]

        i = self.nodes[0]
        moment, force = moment[i], force[i]
        A = d.A.reshape(-1, 3, 3)

        if self.reversed:
            moment, force = -moment - np.cross(d.arm.reshape(-1, 3)[i] - self.root_arm(m, A), force), -force
            A = A[i]
        else:
            A = A[m.body_parent[i]] @ m.body_A.reshape(-1, 3, 3)[i]

        return np.append(A.T @ force, A.T @ moment) if self.kind == "free" else A.T @ moment

    def root_arm(self, m, A):
        """From the origin of the parent to that of the joint's frame on it (m, inertial axes)."""
        i = self.nodes[0]
        return A[m.body_parent[i]] @ m.body_r.reshape(-1, 3)[i]


def _rotation(E):
    """(unit E, w, w') of Euler parameters and their first two rates (3, 4); see drives.rotation_of_table."""
    s = 1.0 / (E[0] @ E[0])
    back = E[0] * [-1, -1, -1, 1]
    w = 2.0 * s * _product(E[1], back)[:3]
    alpha = 2.0 * s * _product(E[2], back)[:3] - 2.0 * s * (E[0] @ E[1]) * w
    return np.sqrt(s) * E[0], w, alpha


def _told(model, courses):
    """joint -> its _Told parts."""
    told = {}

    for name, parts in courses.items():
        nodes = [i for i, node in enumerate(model.tree.nodes) if i and node.joint == name]
        nodes.sort(key=lambda i: model.tree.nodes[i].coordinate)

        if not nodes:
            text = "it follows from the others; drive fewer of them"
            raise ValueError(f"the joints told close a loop at {name!r}: {text}")

        told[name] = [_Told(model, [nodes[k] for k in of] if of else nodes, course) for of, course in parts]

    return told


def _check_freedoms(mechanism, told, choose, hybrid):
    """(joints told that are needed, joints that move freely). Raises ValueError unless each takes
    freedoms of its own away and, if not `hybrid`, leaves none that a motor could move.

    choose : joints that no motor moves are left out where they follow from others.
    """
    place = mechanism.generic()
    m, kinds = mechanism.m, mechanism.scene.joint
    freedoms = place.motions.shape[1]

    def rows(names):
        parts = [part for name in names for part in told[name]]
        return [mechanism.free.index(v) for part in parts for v in part.velocities(m)]

    def taken(names, more=()):
        some = np.vstack([place.motions[rows(names)], *(row[None] for row in more)])
        return int(np.sum(np.linalg.svd(some, compute_uv=False) > 10 * ZERO)) if some.size else 0

    names = [name for name in told if kinds[name].kind in DRIVEABLE or not choose]

    for name in told:
        if name not in names and taken([*names, name]) == taken(names) + len(rows([name])):
            names.append(name)

    found = taken(names)

    if found < len(rows(names)):
        raise ValueError(
            f"the motion gives {listed(names)}, but some of these follow from the others: the scene "
            f"has {_degrees(freedoms)} of freedom; drive fewer of them (drive=[...], or --drive JOINT)"
        )

    left = freedoms - found
    could = []

    for name in mechanism.driveable(place) if left else ():
        if taken(names, [mechanism.rates(name, place) @ place.motions]) > found:
            could.append(name)

    if left and not hybrid and (could or not names):
        hint = f"of these could be driven too: {listed(could)}"
        raise ValueError(
            f"the motion of {listed(names) or 'no joint'} leaves {_degrees(left)} of "
            f"freedom undetermined; {hint if could else 'no revolute or prismatic joint moves in them'} "
            "(hybrid=True, or --hybrid, lets them go on freely from the scene's start)"
        )

    told = {name: told[name] for name in names}
    return told, _moving(mechanism, place, rows(names)) if left else []


def _moving(mechanism, place, rows):
    """Joints of the tree that can move while the coordinates told do not."""
    _, s, V = np.linalg.svd(place.motions[rows]) if rows else (0, [], np.eye(place.motions.shape[1]))
    left = place.motions @ V[int(np.sum(np.array(s) > 10 * ZERO)) :].T
    moving = {mechanism.free[k] for k in np.flatnonzero(np.linalg.norm(left, axis=1) > 1e-6)}
    m, nodes = mechanism.m, mechanism.model.tree.nodes
    owners = [(nodes[i].joint, m.body_v[i], joints.N_V[m.body_joint[i]]) for i in range(1, m.n_body)]
    return list(dict.fromkeys(name for name, v, n in owners if moving & set(range(v, v + n))))


def _notices(free):
    if not free:
        return []

    return [
        f"the motion leaves freedoms of {listed(free)} open: they go on freely from the scene's start; a "
        "spin that nothing drives stays as it starts, zero unless the scene starts with one"
    ]


def _degrees(n):
    return f"{n} degree{'s' * (n != 1)}"


# the run


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
        self.free_v = [self.m.n_q + v for v in range(self.m.n_v) if v not in held]
        places = {self.m.n_q + v for v in held} | {q for part in self.parts for q in part.positions(self.m)}
        self.loose = [k for k in range(self.m.n_x) if k not in places]
        self.between = None

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
        velocity = d.x[self.free_v].copy()
        self._approach()
        d.x[self.free_v] = velocity
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
        lengths = {"prismatic": len(part.nodes), "free": 3}.get(part.kind, 0)
        return np.append(np.full(lengths, self.length), np.ones(part.course.shape[1] - lengths))

    def _close(self):
        """Positions and velocities to where the joints told want them."""
        status = project.project(self.m, self.d)

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
        found, units = {"time": self.times}, {"time": "s"}
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
    if joint.kind in POSES:
        what = ["force", "moment"] if joint.kind == "free" else ["torque"]
        return [(dotted(name, w) + end, "N" if w == "force" else "N.m") for w in what for end in subscripts((3,))]

    names = []

    for part in parts:
        effort, unit = EFFORTS["rad" if part.kind == "revolute" else "m"]
        n = len(part.nodes)
        effort += "s" if joint.kind == "universal" else ""
        names += [(dotted(name, effort) + end, unit) for end in (subscripts((n,)) if n > 1 else [""])]

    return names


def _signals(at, inputs, times):
    """(position in u, values (n,)) of each input."""
    signals = []

    for name, values in (inputs or {}).items():
        name = variable_name(name)
        parts = [key for key in at if key.startswith(f"{name}[")] if name not in at else [name]

        if not parts:
            raise KeyError(f"no input {name!r} beside the motion; there are {', '.join(at) or 'none'}")

        values = np.asarray(values, float)
        shape = times.shape if len(parts) == 1 else (len(times), len(parts))
        columns = np.broadcast_to(values, shape).reshape(len(times), -1)
        signals += [(at[part], column) for part, column in zip(parts, columns.T)]

    return signals


def _out_of_reach(reason, time):
    return SimulationError(f"{reason}; the motion may lead out of reach (time {time:.9g} s)", time)


