"""The kinds of joints: somewhere in its range each, its start as a user writes it,
and what motions it allows.

A motion is (w, v) (6,): angular velocity of the second marker in the first, and velocity of its origin,
in the first one's axes.
"""

from dataclasses import dataclass, field

import numpy as np
from scipy.linalg import null_space

from ..independent import curves
from . import shapes
from .frames import (
    HERE,
    about,
    axis,
    orientation,
    plane_axes,
    unit,
    written_orientation,
)

TREE = {
    "revolute": 1,
    "prismatic": 1,
    "screw": 1,
    "cylindrical": 2,
    "universal": 2,
    "planar": 3,
    "spherical": 3,
    "translation": 3,
    "free": 6,
    "fixed": 0,
}
CONSTRAINTS = (
    "point_on_plane", "point_on_line", "distance", "rolling_sphere", "rolling_disk", "knife_edge",
    "constant_velocity", "angle", "point_on_curve", "curve_on_curve", "point_on_surface",
    "frame_on_curve", "frame_on_surface",
)  # fmt: skip
CONTACTS = CONSTRAINTS[-3:]
MOVING = [kind for kind in TREE if kind != "fixed"]
ONE = ("revolute", "prismatic")
TOUCHING = ("surface_on_surface", "rolling_surface")


@dataclass
class Drawn:
    """A joint in the making.

    table : its keys but for ends and start. q : its coordinates by the names of the start's keys. pose : of
    the second marker in the first. motions : (n, 6), for a unit of each velocity coordinate. rows : (k, 6), m
    with m @ motion = 0.
    shapes : what the two markers must carry, by key. rate : of the only coordinate, where a driver says it;
    None: unknown.
    says : what its start may say beside its driver, "all", "place" or "". owners, world : of its two ends,
    and where these are.
    fast : a wheel, which may turn fast.
    """

    kind: str
    table: dict
    q: dict = field(default_factory=dict)
    pose: tuple = HERE
    motions: np.ndarray = field(default_factory=lambda: np.zeros((0, 6)))
    rows: np.ndarray | None = None
    shapes: tuple = ({}, {})
    rate: float | None = None
    says: str = "all"
    name: str = ""
    ends: tuple = ()
    owners: tuple = ()
    world: tuple = ()
    in_tree: bool = True
    fast: bool = False

    def __post_init__(self):
        if self.rows is None:
            self.rows = null_space(self.motions).T if len(self.motions) else np.eye(6)

    @property
    def driven(self):
        """Whether it has a driver."""
        return "driver" in self.table

    @property
    def led(self):
        """Whether a driver leads it along what is no coordinate of its own: a curve, or all six freedoms."""
        return self.driven and self.kind not in ONE

    @property
    def value(self):
        """The coordinate of a joint of one freedom."""
        return self.q["angle" if self.kind == "revolute" else "position"]


def turning(*vectors):
    """Motions (n, 6) of turns about these."""
    return np.array([[*v, 0, 0, 0] for v in vectors], float).reshape(-1, 6)


def sliding(*vectors):
    """Motions (n, 6) along these."""
    return np.array([[0, 0, 0, *v] for v in vectors], float).reshape(-1, 6)


def draw(dice, kind, size=1.0, q=None, direction=None) -> Drawn:
    """A joint of a kind; `size` of its coordinates' range; q, direction: of one of one freedom,
    as (written, unit vector)."""
    if kind in MAKERS:
        return MAKERS[kind](dice, size)

    written, a = direction or axis(dice)
    options = {} if isinstance(written, str) and written == "z" and dice.chance(0.5) else {"axis": written}

    if kind == "revolute":
        angle = _turns(dice, size) + dice.number(-1.5, 1.5) * size if q is None else q
        return Drawn(kind, {kind: options}, {"angle": angle}, (np.zeros(3), about(a, angle)), turning(a))

    if kind == "prismatic":
        x = dice.number(-0.5, 0.5) * size if q is None else q
        return Drawn(kind, {kind: options}, {"position": x}, (x * a, np.eye(3)), sliding(a))

    angle, x = _turns(dice, size) + dice.number(-1.5, 1.5) * size, dice.number(-0.5, 0.5) * size

    if kind == "screw":
        pitch = dice.signed(0.1, 1.0)
        lead = pitch / (2 * np.pi)
        motions = turning(a) + sliding(lead * a)
        return Drawn(
            kind,
            {kind: options | {"pitch": pitch}},
            {"angle": angle},
            (lead * angle * a, about(a, angle)),
            motions,
        )

    pose = (x * a, about(a, angle))
    return Drawn(
        kind, {kind: options}, {"position": x, "angle": angle}, pose, np.vstack([sliding(a), turning(a)])
    )


def _turns(dice, size):
    """rad, mostly 0, or some whole turns."""
    return 2 * np.pi * dice.pick([-3, -2, -1, 1, 2, 4]) if size == 1.0 and dice.chance(0.08) else 0.0


def _fixed(dice, size):
    return Drawn("fixed", {"fixed": {}})


def _universal(dice, size):
    if dice.chance(0.7):
        names = dice.some("xyz", 2)[:2]
        names = [dice.pick(["", "-"]) + name for name in names]
        axes = np.array([np.eye(3)["xyz".index(name[-1])] * (-1 if name[0] == "-" else 1) for name in names])
        options = {} if names == ["x", "y"] else {"axes": names}
    else:
        _, A = orientation(dice)
        axes = A[:, :2].T
        options = {"axes": axes.tolist()}

    angles = [dice.number(-1.0, 1.0) * size for _ in range(2)]
    A = about(axes[0], angles[0]) @ about(axes[1], angles[1])
    return Drawn(
        "universal",
        {"universal": options},
        {"angles": angles},
        (np.zeros(3), A),
        turning(axes[0], A @ axes[1]),
    )


def _planar(dice, size):
    written, n = axis(dice)
    axes = plane_axes(n)
    position, angle = [dice.number(-0.5, 0.5) * size for _ in range(2)], dice.number(-1.5, 1.5) * size
    options = {} if isinstance(written, str) and written == "z" and dice.chance(0.5) else {"normal": written}
    motions = np.vstack([sliding(axes[:, 0], axes[:, 1]), turning(n)])
    pose = axes[:, :2] @ position, about(n, angle)
    return Drawn("planar", {"planar": options}, {"position": position, "angle": angle}, pose, motions)


def _translation(dice, size):
    r = [dice.number(-0.5, 0.5) * size for _ in range(3)]
    return Drawn(
        "translation", {"translation": {}}, {"position": r}, (np.array(r), np.eye(3)), sliding(*np.eye(3))
    )


def _turn(dice, size):
    """(A (3, 3), its keys)"""
    if size < 1.0:
        A = about(unit(dice.vector(1.0)), 1.0 * size) if size else np.eye(3)
        return A, written_orientation(dice, A)

    keys, A = orientation(dice)
    return A, keys


def _spherical(dice, size):
    A, keys = _turn(dice, size)
    return Drawn("spherical", {"spherical": {}}, {"orientation": keys}, (np.zeros(3), A), turning(*np.eye(3)))


def _free(dice, size):
    r = [dice.number(-0.8, 0.8) * size for _ in range(3)]
    A, keys = _turn(dice, size)
    motions = np.vstack([sliding(*np.eye(3)), turning(*np.eye(3))])
    return Drawn("free", {"free": {}}, {"position": r, "orientation": keys}, (np.array(r), A), motions)


def _anywhere(dice):
    return orientation(dice)[1] if dice.chance(0.8) else np.eye(3)


def _point_on_plane(dice, size):
    written, n = axis(dice)
    r = np.cross(n, dice.vector(1.0))
    options = {} if isinstance(written, str) and written == "z" else {"normal": written}
    return Drawn("point_on_plane", {"point_on_plane": options}, {}, (r, _anywhere(dice)), rows=sliding(n))


def _point_on_line(dice, size):
    written, a = axis(dice)
    options = {} if isinstance(written, str) and written == "z" else {"axis": written}
    pose = (dice.number(-0.8, 0.8) * a, _anywhere(dice))
    return Drawn("point_on_line", {"point_on_line": options}, {}, pose, rows=sliding(*plane_axes(a)[:, :2].T))


def _distance(dice, size):
    length, direction = dice.number(0.3, 1.5), unit(dice.vector(1.0))
    options = {"length": length} if dice.chance(0.6) else {}
    return Drawn(
        "distance", {"distance": options}, {}, (length * direction, _anywhere(dice)), rows=sliding(direction)
    )


def _above(dice):
    return 1.0 if dice.chance(0.8) else -1.0


def _rolling_sphere(dice, size):
    radius, side = dice.number(0.1, 0.6), _above(dice)
    r = np.array([*dice.vector(0.5, 2), side * radius])
    rows = rolls(np.array([0, 0, -side * radius]))
    return Drawn(
        "rolling_sphere", {"rolling_sphere": {"radius": radius}}, {}, (r, _anywhere(dice)), rows=rows
    )


def rolls(arm):
    """Rows of v + w x arm = 0."""
    return np.array([[*np.cross(arm, e), *e] for e in np.eye(3)])


def _rolling_disk(dice, size):
    radius, side = dice.number(0.1, 0.6), _above(dice)
    written, a = axis(dice)
    A = _anywhere(dice)

    while np.linalg.norm(np.cross(A @ a, [0, 0, 1])) < 0.3:
        A = orientation(dice)[1]

    n = A @ a
    down = unit(-np.array([0, 0, 1.0]) + n * n[2]) * radius * side
    options = {"radius": radius} | ({} if isinstance(written, str) and written == "z" else {"axis": written})
    r = np.array([*dice.vector(0.5, 2), -down[2]])
    return Drawn("rolling_disk", {"rolling_disk": options}, {}, (r, A), rows=rolls(down))


def _knife_edge(dice, size):
    written, lateral = axis(dice)
    A = _anywhere(dice)
    options = {} if isinstance(written, str) and written == "y" else {"lateral": written}
    return Drawn(
        "knife_edge", {"knife_edge": options}, {}, (np.array(dice.vector(0.8)), A), rows=sliding(A @ lateral)
    )


def _constant_velocity(dice, size):
    written, u = axis(dice)
    options = {} if isinstance(written, str) and written == "z" else {"axis": written}
    across = plane_axes(u)[:, 0] * np.cos(turn := dice.number(-3, 3)) + plane_axes(u)[:, 1] * np.sin(turn)
    A = about(across, dice.number(-1.4, 1.4))
    rows = np.vstack([np.hstack([np.zeros((3, 3)), np.eye(3)]), [[*(u + A @ u), 0, 0, 0]]])
    return Drawn("constant_velocity", {"constant_velocity": options}, {}, (np.zeros(3), A), rows=rows)


def _angle(dice, size):
    (one, u), (two, x), A = axis(dice), axis(dice), _anywhere(dice)

    while np.linalg.norm(np.cross(A @ x, u)) < 0.3:
        A = orientation(dice)[1]

    options = {"angle_deg": float(np.degrees(np.arccos(u @ A @ x)))}
    options |= {} if (one, two) == ("z", "z") else {"axes": [one, two]}
    rows = np.array([[*np.cross(A @ x, u), 0, 0, 0]])
    return Drawn("angle", {"angle": options}, {}, (np.array(dice.vector(0.8)), A), rows=rows)


def _point_on_curve(dice, size, curve=None):
    curve = curve or shapes.curve(dice)
    rows = sliding(*plane_axes(unit(curve.t))[:, :2].T)
    return Drawn(
        "point_on_curve",
        {"point_on_curve": {}},
        {"s": curve.s},
        (curve.r, _anywhere(dice)),
        rows=rows,
        shapes=({"curve": curve.table}, {}),
    )


def _curve_on_curve(dice, size):
    first, second, pose = shapes.touching(dice)
    arm = first.r - pose[0]
    across = np.cross([0, 0, 1.0], unit(first.t))
    touch = [*np.cross(arm, across), *across]
    rows = np.vstack([turning([1, 0, 0], [0, 1, 0]), sliding([0, 0, 1]), [touch]])
    return Drawn(
        "curve_on_curve",
        {"curve_on_curve": {}},
        {"s": [first.s, second.s]},
        pose,
        rows=rows,
        shapes=({"curve": first.table}, {"curve": second.table}),
    )


def _point_on_surface(dice, size):
    surface = shapes.surface(dice)
    return Drawn(
        "point_on_surface",
        {"point_on_surface": {}},
        {"s": surface.s},
        (surface.r, _anywhere(dice)),
        rows=sliding(unit(surface.n)),
        shapes=({"surface": surface.table}, {}),
    )


def _along(u, n):
    """Axes (3, 3) with x along u and z along n."""
    i, k = unit(u), unit(n)
    return np.column_stack([i, np.cross(k, i), k])


def _framed(dice, kind, shape, r, E, turns, steps, spin, options):
    """A joint that holds a frame to E at r; turns, steps : of the frame and of its origin by each parameter; spin : the axis of E
    about which it may be free to turn.
    """
    ways = np.hstack([turns, steps])

    if dice.chance(0.33):
        options["spin"] = "free"
        ways = np.vstack([ways, turning(E[:, spin])])
        E = about(E[:, spin], dice.number(-3, 3)) @ E
    elif dice.chance(0.3):
        options["spin"] = "held"

    rows = null_space(ways).T
    key = kind.removeprefix("frame_on_")
    return Drawn(kind, {kind: options}, {"s": shape.s}, (r, E), rows=rows, shapes=({key: shape.table}, {}))


def with_driver(joint):
    """The rows of a joint on a curve whose parameter is driven: only a spin that is free is left."""
    spin = joint.pose[1][:, :1].T
    free = next(iter(joint.table.values())).get("spin") == "free"
    return null_space(turning(*spin)).T if free else np.eye(6)


def _turn_of(E, change):
    """The rate (3,) of a frame E whose columns change so."""
    return 0.5 * np.cross(E.T, change.T).sum(axis=0)


def _frame_on_curve(dice, size, shape=None):
    shape = shape or shapes.curve(dice)
    D = curves.Curve(shape.table).derivatives
    points = next(iter(shape.table.values())).get("points")
    flat = points is None or np.ptp([[*p, 0.0][2] for p in points]) < 1e-9
    side = [dice.number(-0.3, 0.3), dice.number(-0.3, 0.3), 1.0] if not flat or dice.chance(0.4) else None
    options = {} if side is None else {"side": side}
    if flat and side is None and dice.chance(0.85):
        options["side"] = "z"

    def frame(s):
        t = D(s)[1]
        return _along(t, np.cross(t, side or [0.0, 0.0, 1.0]))

    E, h = frame(shape.s), 1e-5
    change = (frame(shape.s + h) - frame(shape.s - h)) / (2 * h)
    return _framed(
        dice, "frame_on_curve", shape, shape.r, E, [_turn_of(E, change)], [D(shape.s)[1]], 0, options
    )


def _frame_on_surface(dice, size):
    shape = shapes.surface(dice)
    D = curves.Surface(shape.table).derivatives
    s, h = np.array(shape.s), 1e-5

    def frame(s):
        d = D(*s)
        return _along(d[1], np.cross(d[1], d[2]))

    E = frame(s)
    turns = [_turn_of(E, (frame(s + h * e) - frame(s - h * e)) / (2 * h)) for e in np.eye(2)]
    return _framed(dice, "frame_on_surface", shape, shape.r, E, turns, D(*s)[1:3], 2, {})


MAKERS = {
    "fixed": _fixed, "universal": _universal, "planar": _planar, "translation": _translation, "spherical":
    _spherical, "free": _free, "point_on_plane": _point_on_plane, "point_on_line": _point_on_line, "distance":
    _distance, "rolling_sphere": _rolling_sphere, "rolling_disk": _rolling_disk, "knife_edge": _knife_edge,
    "constant_velocity": _constant_velocity, "angle": _angle, "point_on_curve": _point_on_curve, "curve_on_curve": _curve_on_curve, "point_on_surface":
    _point_on_surface, "frame_on_curve": _frame_on_curve, "frame_on_surface": _frame_on_surface,
}  # fmt: skip


# starts as they are written


def start(dice, joint, v, places=True, rates=True) -> dict:
    """The start table of a joint at its coordinates and velocities v (n,): all of it,
    or where it is or how fast alone."""
    table = {}

    if places:
        table |= _places(dice, joint)

    if rates and len(v):
        table |= _rates(dice, joint, [float(x) for x in v])

    return table


def _angle(dice, key, value, ways=("", "_deg")):
    way = dice.pick(ways)
    factor = {"": 1.0, "_deg": 180 / np.pi, "_rpm": 30 / np.pi}[way]
    values = [factor * x for x in value] if isinstance(value, list) else factor * value
    return {key + way: values}


def _places(dice, joint):
    table = {}

    for key, value in joint.q.items():
        if key == "orientation":
            table |= value
        elif key in ("angle", "angles"):
            table |= _angle(dice, key, value)
        else:
            table[key] = value

    return table


def _rates(dice, joint, v):
    rates = ("", "_deg", "_rpm")

    if joint.kind == "revolute":
        return _angle(dice, "speed", v[0], rates)
    if joint.kind == "prismatic":
        return {"speed": v[0]}
    if joint.kind == "screw":
        return _angle(dice, "angular_speed", v[0], rates)
    if joint.kind == "cylindrical":
        return {"speed": v[0]} | _angle(dice, "angular_speed", v[1], rates)
    if joint.kind == "universal":
        return _angle(dice, "speeds", v)
    if joint.kind == "planar":
        return {"velocity": v[:2]} | _angle(dice, "angular_speed", v[2], rates)
    if joint.kind == "translation":
        return {"velocity": v}

    linear = {"velocity": v[:3]} if joint.kind == "free" else {}
    omega = np.array(v[-3:])
    return linear | (
        {"omega": omega.tolist()} if dice.chance(0.5) else {"omega_body": (joint.pose[1].T @ omega).tolist()}
    )


TWO = ("first", "second")
NAMES = {
    "position": "xyz", "velocity": "xyz", "omega": "xyz", "omega_body": "xyz", "angles": TWO, "speeds": TWO,
}  # fmt: skip


def in_tables(table):
    """The start table with its vectors as tables of all their components."""
    names = {key: NAMES.get(key.removesuffix("_deg")) for key in table}
    return {
        key: dict(zip(names[key], value)) if isinstance(value, list) and names[key] else value
        for key, value in table.items()
    }


def in_part(dice, joint, table):
    """The start table with some vectors given in part, and some keys not at all."""
    parted = {}

    for key, value in table.items():
        names = NAMES.get(key.removesuffix("_deg"))

        if isinstance(value, list) and names and dice.chance(0.8):
            kept = sorted(dice.some(range(len(value)), 1))
            value = {names[k]: value[k] for k in kept}

        if dice.chance(0.9):
            parted[key] = value

    return parted
