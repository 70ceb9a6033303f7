"""What a scene's table says, in SI units: numbers with their endings, axes, orientations, poses, names."""

import re
import unicodedata

import numpy as np
from scipy.spatial.transform import Rotation

UNITS = {"": 1.0, "_rad": 1.0, "_deg": np.pi / 180, "_rpm": np.pi / 30}


def cross(a, b):
    """a x b of two vectors (numpy's takes twenty times as long)."""
    return np.array([a[1] * b[2] - a[2] * b[1], a[2] * b[0] - a[0] * b[2], a[0] * b[1] - a[1] * b[0]])


def si(table, key, default=None):
    """The value of a key that may end in a unit, in SI units."""
    for ending, factor in UNITS.items():
        if table.get(key + ending) is not None:
            value = table[key + ending]
            return (
                factor * np.asarray(value, float)
                if isinstance(value, (list, tuple, np.ndarray))
                else factor * value
            )

    return default


def axis(value):
    """The unit vector (3,) of an axis: "x", "-x", ..., or a vector of any length."""
    if isinstance(value, str):
        vector = np.eye(3)["xyz".index(value[-1])]
        return -vector if value.startswith("-") else vector

    vector = np.asarray(value, float)
    return vector / np.linalg.norm(vector)


def plane_axes(normal):
    """(3, 3), by column: the x axis projected into the plane (the y axis where the normal is the x axis),
    what is normal to it and to the normal, the normal."""
    flat = np.hypot(*normal[1:]) > 1e-6
    x = np.eye(3)[0 if flat else 1]
    x = x - (x @ normal) * normal
    x /= np.linalg.norm(x)
    return np.column_stack([x, cross(normal, x), normal])


def orientation(table):
    """A (3, 3): components in the frame to components in its base,
    written in one of five ways or not at all."""
    if table.get("euler_parameters") is not None:
        return Rotation.from_quat(table["euler_parameters"]).as_matrix()

    angles = si(table, "zyx")

    if angles is not None:
        z, y, x = (Rotation.from_rotvec(angle * unit) for angle, unit in zip(angles, np.eye(3)[::-1]))
        return (z * y * x).as_matrix()

    if table.get("axis_angle") is not None:
        turn = table["axis_angle"]
        return Rotation.from_rotvec(si(turn, "angle") * axis(turn["axis"])).as_matrix()

    if table.get("axes") is not None:
        return of_two_axes(*table["axes"].items())

    return np.eye(3)


def of_two_axes(first, second):
    """A of two of its columns, as (name, axis): the first is kept, the second made normal to it,
    the third is right-handed."""
    i, j = "xyz".index(first[0]), "xyz".index(second[0])
    A = np.zeros((3, 3))
    A[:, i] = axis(first[1])
    across = axis(second[1]) - (axis(second[1]) @ A[:, i]) * A[:, i]
    A[:, j] = across / np.linalg.norm(across)
    k = 3 - i - j
    A[:, k] = cross(A[:, i], A[:, j]) * (1 if (j - i) % 3 == 1 else -1)
    return A


def pose(table):
    """(position (3,) m, A (3, 3)) of a frame in its base."""
    return np.asarray(table.get("position", (0.0, 0.0, 0.0)), float), orientation(table)


def listed(value):
    """The names in `input` or `output`, which may be one alone."""
    return [value] if isinstance(value, str) else list(value or ())


def kind_of(table, kinds):
    """Which of the kinds a table is of: the key that it has."""
    return next(kind for kind in kinds if kind in table)


def quoted(name):
    """A name as a part of a variable's: accents dropped, and in quotes where it is no identifier."""
    letters = (c for c in unicodedata.normalize("NFKD", name) if not unicodedata.combining(c))
    plain = "".join(c if " " <= c <= "~" and c != "`" else f"(U+{ord(c):04X})" for c in letters)

    if re.fullmatch(r"[A-Za-z_]\w*", plain, re.ASCII):
        return plain

    return "'" + re.sub(r"(['\"\\])", r"\\\1", plain) + "'"


def dotted(*names):
    """A variable's name of names as they are in the scene."""
    return ".".join(map(quoted, names))


class Parameters:
    """Values of parameters other than the scene's, by variable name;
    elements of arrays by their indices from 1."""

    def __init__(self, values):
        self.values = {self._named(name): float(value) for name, value in (values or {}).items()}
        self.taken = set()

    @staticmethod
    def _named(text):
        base, index = re.fullmatch(r"(.*?)((?:\[[\d,]+\])?)", text, re.DOTALL).groups()
        parts = base.split(".")
        return ".".join(part if re.fullmatch("'.*'", part) else quoted(part) for part in parts) + index

    def __call__(self, value, *names):
        """A number or an array of the scene, or what the parameter of that name says instead."""
        name = dotted(*names)

        if np.ndim(value) == 0:
            return self._taken(name, value)

        value = np.array(value, float)

        for place in np.ndindex(value.shape):
            index = ",".join(str(k + 1) for k in place)
            value[place] = self._taken(f"{name}[{index}]", value[place])

        return value

    def _taken(self, name, value):
        self.taken.add(name)
        return self.values.get(name, value)

    def check(self):
        """KeyError where a value is of no parameter;
        those of the start and of the solver concern only the package."""
        for name in self.values.keys() - self.taken:
            if not name.startswith("solver.") and not name.partition("[")[0].endswith("_start"):
                raise KeyError(f"no parameter {name}")
