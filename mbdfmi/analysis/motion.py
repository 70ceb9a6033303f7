"""The motion of joints as a user gives it (columns, functions of time, parts of a run) as values, rates and
second rates of their coordinates at given times.
"""

import numpy as np
from scipy.interpolate import make_interp_spline

from ..compiler.joint_kinds import kind_of
from ..compiler.variables import array_of, dotted, hint
from ..kernels.math import algebra
from ..run.results import Results
from ..scene.errors import listed
from ..vocabulary import MEASURES, POSITION, ROTATION_OUTPUTS, VELOCITY

PLACE = (POSITION, VELOCITY, MEASURES["acceleration"])
"""What tells the place of a free joint; ROTATION_OUTPUTS what tells an orientation."""


def times_of(motion, times):
    """(n,) s"""
    times = motion.get("time") if times is None else times

    if times is None:
        raise ValueError('the motion has no "time"; give times, as in times=np.linspace(0, 1, 101)')

    times = np.atleast_1d(np.asarray(times, float))

    if times.ndim != 1 or not np.all(np.isfinite(times)) or np.any(np.diff(times) <= 0):
        raise ValueError("the motion's times must ascend")

    return times


def quantities_of(joint):
    """Quantities of a joint's motion: name -> (its coordinates, 0 position 1 speed 2 acceleration).

    Of a pose the order is None.
    """
    found: dict[str, tuple[list[int], int | None]] = {}

    if kind_of(joint).is_pose:
        place = PLACE if POSITION in _positions(joint) else ()
        return {told.name: (list(range(told.width)), None) for told in (*place, *ROTATION_OUTPUTS.values())}

    first = 0

    for coordinate in joint.coordinates:
        of = list(range(first, first + coordinate.position.width))
        found[coordinate.position.name] = of, 0
        found[coordinate.rate.name] = of, 1
        first += len(of)

    if kind_of(joint).is_one_axis:
        found["acceleration"] = ([0], 2)

    return found


def _positions(joint):
    """What a joint's positions are called."""
    return [coordinate.position for coordinate in joint.coordinates]


def given_motion(scene, motion):
    """joint -> quantity -> what the motion gives for it, a component by itself under its number."""
    known = {}

    for name, joint in scene.joint.items():
        for quantity in quantities_of(joint):
            known[dotted(name, quantity)] = known[f"{name}.{quantity}"] = (name, quantity)

    given = {}

    for key in motion:
        base = array_of(key)
        index = key.removeprefix(base).strip("[]")

        if base in known:
            name, quantity = known[base]
            values = given.setdefault(name, {})

            if index:
                values.setdefault(quantity, {})[int(index)] = motion[key]
            else:
                values[quantity] = motion[key]
        elif key != "time" and not isinstance(motion, Results):
            raise ValueError(f"the motion's {key!r} is no joint coordinate; {hint(key, known)}")

    # a run may tell some joint's speed alone
    if isinstance(motion, Results):
        return {name: values for name, values in given.items() if _is_located(scene.joint[name], values)}

    return given


def _is_located(joint, values):
    """Whether values tell a joint's position."""
    if kind_of(joint).is_pose:
        turned = "euler_parameters" in values or "zyx" in values
        return turned and (POSITION not in _positions(joint) or "position" in values)

    return any(order == 0 and quantity in values for quantity, (_, order) in quantities_of(joint).items())


def courses_of(name, joint, given, times):
    """[(coordinates, (n, size, 3) their values, rates and second rates)] of a joint; of a pose one, of
    all that it has.
    """
    if not _is_located(joint, given):
        told = " and ".join(given)
        raise ValueError(f"the motion tells the {told} of {name!r}, but not its position over time")

    quantities = quantities_of(joint)

    if kind_of(joint).is_pose:
        parts = [_turning(name, given, times)]

        if POSITION in _positions(joint):
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
        columns = [columns_of(name, course, times, size) for course in courses]
    else:
        columns = columns_of(name, values, times, size)
        columns = [columns, *_slopes(times, columns)]

    for k in (1, 2):
        if keys[k] in given:
            columns[k] = columns_of(name, given[keys[k]], times, size)

            # accelerations that nobody tells follow from the speeds that somebody does
            if k == 1 and keys[2] not in given:
                columns[2] = _slopes(times, columns[1])[0]

    return np.stack(columns, axis=2)


def columns_of(name, values, times, size):
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
            values = columns_of(name, values, times, 4)
            jumps = np.sum(values[1:] * values[:-1], axis=1) < 0.0
            values = values * np.append(1.0, np.where(np.cumsum(jumps) % 2 == 1, -1.0, 1.0))[:, None]

        course = _course(name, {"E": values}, times, ("E", "", ""), 4)

        if not np.all(np.linalg.norm(course[:, :, 0], axis=1) > 0.0):
            raise ValueError(f"the motion of {name!r} has Euler parameters of zero length")
    else:
        values = given["zyx"]
        values = values if callable(values) else np.unwrap(columns_of(name, values, times, 3), axis=0)
        known = {"zyx": values} | {key: given[key] for key in ("zyx_rate",) if key in given}
        course = _of_zyx(_course(name, known, times, ("zyx", "zyx_rate", ""), 3))

    if "omega" in given:
        course = course / np.linalg.norm(course[:, :, 0], axis=1)[:, None, None]
        w = columns_of(name, given["omega"], times, 3)
        alpha = columns_of(name, given["alpha"], times, 3) if "alpha" in given else _slopes(times, w)[0]

        for E, turning, change in zip(course, w, alpha):
            E[:, 1] = 0.5 * product_of((*turning, 0.0), E[:, 0])
            E[:, 2] = 0.5 * (product_of((*change, 0.0), E[:, 0]) + product_of((*turning, 0.0), E[:, 1]))

    return course


def product_of(a, b):
    """Product of Euler parameters (4,), scalar last."""
    return np.array(algebra.E_product(tuple(map(float, a)), tuple(map(float, b))))


def _of_zyx(angles):
    """Euler parameters and their rates (n, 4, 3) of yaw, pitch, roll and theirs (n, 3, 3): a product of
    three rotations.
    """
    course = np.empty((len(angles), 4, 3))

    for k, of in enumerate(angles):
        a, *others = (_about(axis, *turn) for axis, turn in zip((2, 1, 0), of))

        for b in others:
            a = np.array(
                [
                    product_of(a[0], b[0]),
                    product_of(a[1], b[0]) + product_of(a[0], b[1]),
                    product_of(a[2], b[0]) + 2.0 * product_of(a[1], b[1]) + product_of(a[0], b[2]),
                ]
            )

        course[k] = a.T

    return course


def _about(axis, angle, rate, rate2):
    """Euler parameters and their rates, rows (3, 4), of a turn about one axis (0, 1, 2)."""
    c, s = np.cos(0.5 * angle), np.sin(0.5 * angle)
    one = np.zeros((3, 4))
    one[:, axis] = s, 0.5 * c * rate, 0.5 * c * rate2 - 0.25 * s * rate**2
    one[:, 3] = c, -0.5 * s * rate, -0.5 * s * rate2 - 0.25 * c * rate**2
    return one
