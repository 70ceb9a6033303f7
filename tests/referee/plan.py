"""What is done to a scene: inputs over time, parameters set in mid-run,
the communication points that all ways share.

Inputs are polynomials of time of degree at most 5, whose derivatives a master can give, so that every way,
whatever its communication points, runs under the same inputs to the bit. Forces jump at the shared points;
commands of a motion are one smooth function, its speed and its acceleration.
"""

import math
import re
import zlib
from dataclasses import dataclass, field, replace

import numpy as np

N_DERIVATIVE = 6

# parameters that may change in mid-run by themselves: no table loses its symmetry, no loop its ends
CHANGEABLE = re.compile(
    r"(\.mass|\.com\[\d\]|^gravity\[\d\]|\.stiffness|\.damper|\.damping|\.rest|\.rest_length|\.force\[\d\])$"
)
LEFT = "left as it is, the length at the start"
COMMANDS = {
    "position_command": 0, "angle_command": 0, "s_command": 0, "speed_command": 1, "s_rate_command": 1,
    "acceleration_command": 2, "s_acceleration_command": 2,
}  # fmt: skip
GROUND = {
    "position": 0, "velocity": 1, "acceleration": 2, "euler_parameters": 0, "zyx": 0, "omega": 1, "alpha": 2,
}  # fmt: skip
TURNS = ("zyx", "euler_parameters", "omega", "alpha")


def dice(seed, *names):
    """Random numbers that belong to a seed and some names, whatever else is drawn."""
    return np.random.default_rng([seed, *(zlib.crc32(str(name).encode()) for name in names)])


FALLING = np.array(
    [[math.perm(k, i) if k >= i else 0 for k in range(N_DERIVATIVE)] for i in range(N_DERIVATIVE)]
)
POWER = np.clip(np.arange(N_DERIVATIVE) - np.arange(N_DERIVATIVE)[:, None], 0, None)
FACTORIAL = np.array([math.factorial(k) for k in range(N_DERIVATIVE)])


@dataclass(frozen=True)
class Signal:
    """An input over time.

    begin : s, of its pieces; the last goes on. coefficients : (n, 6) of the powers of time since then,
    one row a piece.
    told : whether its derivatives are given to the kernels.
    wave : 1 or 2 for the sine or cosine of half the polynomial, as Euler parameters are.
    """

    begin: np.ndarray
    coefficients: np.ndarray
    told: bool = True
    wave: int = 0

    def at(self, t, piece):
        """Value and derivatives of order 1 to 5 at t (s) in the piece that begins at shared point `piece`."""
        k = min(piece, len(self.begin) - 1)
        values = (FALLING * (t - self.begin[k]) ** POWER) @ self.coefficients[k]

        if self.wave:
            values = _half_angle(values)[self.wave - 1]

        if not self.told:
            values[1:] = 0.0

        return values

    def value(self, t, piece):
        """The value alone, at less cost."""
        k = min(piece, len(self.begin) - 1)
        h, value = t - self.begin[k], 0.0

        for c in self.coefficients[k][::-1].tolist():
            value = value * h + c

        return (value, math.sin(0.5 * value), math.cos(0.5 * value))[self.wave]


def _half_angle(angle):
    """Derivatives of order 0 to 5 of the sine and the cosine of half an angle, from those of the angle."""
    half = 0.5 * angle / FACTORIAL
    s, c = np.zeros((2, N_DERIVATIVE))
    s[0], c[0] = math.sin(half[0]), math.cos(half[0])

    for k in range(N_DERIVATIVE - 1):
        rates = np.arange(1, k + 2) * half[1 : k + 2]
        s[k + 1] = rates @ c[k::-1] / (k + 1)
        c[k + 1] = -rates @ s[k::-1] / (k + 1)

    return s * FACTORIAL, c * FACTORIAL


@dataclass(frozen=True)
class Plan:
    """What is done to a scene.

    points : s, communication points that all ways share, the first is the start.
    signals : input variable -> `Signal`.
    settings : shared point -> {parameter: value}, set there. steady : these are the values that stand anyway.
    bound : the motion depends on the communication points themselves (commands without derivatives):
    all ways share one pattern.
    """

    points: np.ndarray
    signals: dict[str, Signal]
    settings: dict[int, dict[str, float]] = field(default_factory=dict)
    bound: bool = False
    steady: bool = True

    @property
    def until(self):
        """s, end of the run."""
        return float(self.points[-1])

    def inputs(self, t, piece):
        """Values and derivatives (6, n) of the inputs, in their order, at t (s)."""
        return np.array([signal.at(t, piece) for signal in self.signals.values()]).reshape(-1, N_DERIVATIVE).T

    def under(self, signals):
        """The plan with other inputs, name -> coefficients of the powers of time, whose derivatives are not told."""
        if not signals:
            return self

        others = {
            name: Signal(
                self.points[:1], np.pad(np.atleast_2d(c), ((0, 0), (0, N_DERIVATIVE - len(c)))), False
            )
            for name, c in signals.items()
        }
        return replace(self, signals=self.signals | others, bound=True)

    def values(self, t, piece):
        """Input variable -> (value, derivatives of order 1 to 5)."""
        return {name: signal.at(t, piece) for name, signal in self.signals.items()}


def draw(seed, model, until=None):
    """The plan of a model; names alone tell how its variables fare,
    so that a smaller scene keeps its plan."""
    rng = dice(seed, "points")
    until = until or float(np.exp(rng.uniform(np.log(0.2), np.log(4.0))))
    n = int(rng.integers(5, 11))
    shares = np.ones(n) if rng.random() < 0.5 else rng.uniform(0.2, 1.0, n)
    points = np.append(0.0, np.cumsum(shares) / shares.sum() * until)
    points[-1] = until
    inputs = model.of_causality("input")
    commanded = any(order_of(v.name) is not None for v in inputs)
    bare = commanded and (dice(seed, "bare").random() < 0.25)
    signals = {v.name: _signal(seed, v, points, bare) for v in inputs}
    # of Euler parameters alone five derivatives are not all
    told = {v.name.partition("[")[0] for v in inputs}
    bound = bare or ("ground.euler_parameters" in told and "ground.omega" not in told)
    settings = _settings(seed, model, points)
    starts = {v.name: v.start for v in model.of_causality("parameter")}
    steady = all(value == starts[name] for own in settings.values() for name, value in own.items())
    return Plan(points, signals, settings, bound, steady)


def order_of(name):
    """Of an input that commands a motion: the order of the derivative it tells, else None."""
    owner, _, quantity = name.partition("[")[0].rpartition(".")
    return GROUND.get(quantity) if owner == "ground" else COMMANDS.get(quantity)


def speeds_unknown(plan):
    """Whether inputs command positions, and neither their speeds nor any derivatives: the speed is known from the
    second communication point on, where it jumps."""
    orders = {}

    for name, signal in plan.signals.items():
        owner, _, quantity = name.partition("[")[0].rpartition(".")

        if order_of(name) is not None and not signal.told:
            orders.setdefault((owner, quantity in TURNS), set()).add(order_of(name))

    return any(1 not in told for told in orders.values())


def _signal(seed, v, points, bare):
    order = order_of(v.name)

    if order is None:
        return _force(dice(seed, v.name), v, points)

    name = v.name.partition("[")[0]
    owner, _, quantity = name.rpartition(".")
    index = v.name[len(name) :]
    told = not bare

    # the ground turns about its z axis alone where it is told by Euler parameters or omega: then all is one
    # polynomial's
    turning = owner == "ground" and quantity in TURNS
    axis = _axis(quantity, index)
    wave = 0

    if quantity == "euler_parameters":
        wave = {"z": 1, "w": 2}.get(axis, 0)
        axis = "z" if wave else axis

    motion = _motion(dice(seed, owner, turning, axis), points[-1], 0.3 if turning else 0.5)
    motion = 0.0 * motion if turning and axis != "z" else motion
    coefficients = np.zeros((1, N_DERIVATIVE))
    coefficients[0, : N_DERIVATIVE - order] = (FALLING[order] * motion)[order:]
    coefficients[0, 0] += v.start if order == 0 and not wave else 0.0
    return Signal(points[:1], coefficients, told, wave)


def _motion(rng, until, size):
    """Coefficients (6,) of a smooth motion from 0 on."""
    motion = np.zeros(N_DERIVATIVE)
    motion[1:4] = size * rng.normal(size=3) / until ** np.arange(1, 4)
    return motion


def _axis(quantity, index):
    """Which axis a component belongs to: of zyx the first is yaw."""
    return ("zyx" if quantity == "zyx" else "xyzw")[int(index[1]) - 1] if index else ""


def _force(rng, v, points):
    """Held between shared points, or a polynomial that jumps at some of them, or nothing at all."""
    n = len(points) - 1
    how = rng.integers(4)
    coefficients = np.zeros((n, N_DERIVATIVE))
    coefficients[:, 0] = v.start

    if how == 1:
        coefficients[:, 0] = rng.normal(size=n)
    elif how == 2:
        lengths = np.diff(points)
        degree = int(rng.integers(1, 6))
        scale = np.array([math.factorial(k) for k in range(degree + 1)])
        coefficients[:, : degree + 1] = (
            rng.normal(size=(n, degree + 1)) / scale / lengths[:, None] ** np.arange(degree + 1)
        )
    elif how == 3:
        coefficients[:, 0] = np.where(rng.random(n) < 0.3, rng.normal(), 0.0)

    return Signal(points[:-1], coefficients)


def _settings(seed, model, points):
    """A few parameters that change at shared points, and one that is set to what it is at each."""
    names = [
        v for v in model.of_causality("parameter") if v.variability == "tunable" and CHANGEABLE.search(v.name)
    ]
    settings = {}

    if names and dice(seed, "settings").random() < 0.4:
        # the names with the least lots, so that others that are not there do not matter
        lots = sorted(names, key=lambda v: dice(seed, "lot", v.name).random())[:2]

        for v in lots:
            rng = dice(seed, "setting", v.name)
            k = int(rng.integers(1, len(points) - 1))
            value = v.start * rng.uniform(0.7, 1.4) if v.start else 0.0
            settings.setdefault(k, {})[v.name] = float(value)

    # what is left to the start stays so where it is set to its own value, which each formulation finds for itself
    names = [v for v in names if LEFT not in v.description]

    if names:
        again = min(names, key=lambda v: dice(seed, "again", v.name).random())
        standing = again.start

        for k in range(1, len(points) - 1):
            standing = settings.setdefault(k, {}).setdefault(again.name, standing)

    return settings


def pieces(plan, pattern):
    """Communication steps (s) of a pattern, for each of the shared intervals a list.

    pattern : ("shared",), ("equal", n), ("unequal", n), ("tiny", n): n steps of 1e-4 of the interval each
    before its rest; ("union", patterns): the points of all of them. Steps that are equal but for rounding are
    equal, as a master's are.
    """
    kind, *n = pattern

    # to the bit the steps of that one pattern
    if kind == "union" and len(n[0]) == 1:
        return pieces(plan, n[0][0])

    result, last = [], 0.0

    for k, length in enumerate(np.diff(plan.points)):
        if kind == "shared":
            shares = [1.0]
        elif kind == "equal":
            shares = [1 / n[0]] * n[0]
        elif kind == "tiny":
            shares = [1e-4] * n[0] + [1.0 - 1e-4 * n[0]]
        elif kind == "union":
            ends = np.sort(np.concatenate([np.cumsum(pieces(plan, p)[k]) / length for p in n[0]]))
            ends = ends[np.diff(ends, prepend=0.0) > 1e-9]
            shares = np.diff(ends, prepend=0.0)
        else:
            shares = dice(k, "unequal").uniform(0.05, 1.0, n[0])
            shares = shares / shares.sum()

        steps = []

        for share in shares:
            step = float(share * length)
            step = last if abs(step - last) <= 1e-12 * step else step
            steps.append(step)
            last = step

        result.append(steps)

    return result
