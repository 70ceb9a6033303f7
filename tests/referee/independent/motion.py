"""What drivers ask of a joint, and how the ground moves, as positions, rates and second rates."""

import numpy as np
from scipy.optimize import brentq
from scipy.spatial.transform import Rotation

from .interpolation import Table
from .reading import axis, cross, dotted, orientation, plane_axes, si

ZERO = np.zeros(3)

# what inputs may tell of the ground, and of a joint
GROUND = ("position", "velocity", "acceleration", "euler_parameters", "omega", "alpha")
JOINT = ("position", "speed", "acceleration")


class Inputs:
    """Inputs by variable name: numbers, or arrays whose first axis is the order of the derivative, 0 to 5."""

    def __init__(self, values):
        self.values = values or {}

    def __call__(self, *names, size=None):
        """(orders, size) of an input's value and derivatives, at least three, zeros where not given;
        size None: a scalar."""
        name = dotted(*names)
        found = self.values.get(name, self.values.get(".".join(names)))

        if found is None and size and f"{name}[1]" in self.values:
            found = np.stack(
                [np.atleast_1d(np.asarray(self.values[f"{name}[{k + 1}]"], float)) for k in range(size)],
                axis=-1,
            )

        found = np.zeros(size or 1) if found is None else np.asarray(found, float)
        found = found.reshape(-1, size or 1)
        found = np.vstack([found, np.zeros((3, size or 1))])
        return found if size else found[:, 0]

    def orders(self, *names):
        """How many of a scalar input's value and derivatives are given."""
        return np.size(self.values.get(dotted(*names), self.values.get(".".join(names), 0.0)))


def commanded(spec, everything, names):
    """What inputs command of a motion: nothing, `everything` (true), or what is listed, by its name in `names`."""
    told = spec.get("input") or ()
    return everything if told is True else [names.get(what, what) for what in told]


class Driver:
    """The motion that a driver asks of a coordinate. path : names of what it drives, as in its variables. quantity : what it is
    a position, an angle, s."""

    def __init__(self, given, path, spec, quantity):
        self.path, self.spec, self.quantity = path, spec, quantity
        self.starts_here = (
            any(key in spec for key in ("hold", "speed_table")) or si(spec, "constant_speed") is not None
        )

        if si(spec, "constant_speed") is not None:
            self.speed = given(si(spec, "constant_speed"), *path, "speed_driven")
        elif wave := spec.get("harmonic", spec.get("harmonics")):
            self._waves(given, wave)
        elif "polynomial" in spec:
            self.powers = given(
                np.array(si(spec["polynomial"], "coefficients")), *path, "driver", "coefficients"
            )
        elif "ramp" in spec:
            time, place = spec["ramp"]["time"], si(spec["ramp"], "position")
            self.ramp = [
                [
                    given(values[k], *path, "driver", f"{what}_{end}")
                    for what, values in (("time", time), (quantity, place))
                ]
                for k, end in enumerate(("begin", "end"))
            ]
        elif table := spec.get("table", spec.get("speed_table")):
            key = "position" if "table" in spec else "speed"
            self.table = Table(
                table.get("interpolation", "smooth"), table["time"], si(table, key), beyond="hold"
            )

    def _waves(self, given, wave):
        """One wave or several: a parameter of several has indices."""
        count = np.size(wave["frequency"])
        many = np.ndim(wave["frequency"]) > 0
        phases = si(wave, "phase", np.zeros(count) if many else 0.0)
        columns = {"amplitude": si(wave, "amplitude"), "frequency": wave["frequency"], "phase": phases}
        columns = {
            key: given(np.array(value) if many else value, *self.path, "driver", key)
            for key, value in columns.items()
        }
        self.mean = given(si(wave, "mean", 0.0), *self.path, "driver", "mean")
        self.waves = np.column_stack(
            [np.atleast_1d(columns[key]) for key in ("amplitude", "frequency", "phase")]
        )

    @property
    def told(self):
        """What inputs command: some of JOINT."""
        return commanded(self.spec, JOINT, {"angle": "position"})

    def target(self, t, start, inputs, seen):
        """(position, rate, second rate) at t; None where inputs tell too little.

        start : (position, time) there. seen : the same three, for what inputs do not tell.
        """
        spec = self.spec

        if si(spec, "constant_speed") is not None:
            return start[0] + self.speed * (t - start[1]), self.speed, 0.0

        if "hold" in spec:
            return start[0], 0.0, 0.0

        if "harmonic" in spec or "harmonics" in spec:
            amplitude, frequency, phase = self.waves.T
            w = 2 * np.pi * frequency
            swings = [amplitude * w**k * np.sin(w * t + phase + k * np.pi / 2) for k in range(3)]
            return self.mean + swings[0].sum(), swings[1].sum(), swings[2].sum()

        if "polynomial" in spec:
            p = np.polynomial.Polynomial(np.atleast_1d(self.powers))
            return p(t), p.deriv()(t), p.deriv(2)(t)

        if "ramp" in spec:
            (t0, x0), (t1, x1) = self.ramp
            s = np.clip((t - t0) / (t1 - t0), 0, 1)
            way = np.polynomial.Polynomial([0, 0, 0, 10, -15, 6])
            found = [(x1 - x0) * way.deriv(k)(s) / (t1 - t0) ** k for k in range(3)]
            return x0 + found[0], found[1], found[2]

        if "table" in spec:
            return self.table(t)

        if "speed_table" in spec:
            speed, slope, _ = self.table(t)
            return start[0] + self.table.integral(start[1], t), speed, slope

        return self._commanded(inputs, seen)

    def _commanded(self, inputs, seen):
        """What is told holds exactly; the rest is as seen, or the derivatives of the last thing told,
        where these are given."""
        names = {"position": self.quantity} | (
            {"speed": "s_rate", "acceleration": "s_acceleration"} if self.quantity == "s" else {}
        )
        found = []

        for k, what in enumerate(JOINT):
            if what in self.told:
                command = *self.path, f"{names.get(what, what)}_command"
                found.append(inputs(*command)[0])
                order = 0
            else:
                order += 1
                derivative = inputs(*command)[order] if inputs.orders(*command) > order else None
                found.append(derivative if seen[k] is None else seen[k])

        return tuple(found)


def rotation_of(E, rate, second):
    """(A, w, alpha) of Euler parameters of any length and their derivatives: w = 2 Im(E' E^-1)."""
    size = np.linalg.norm(E)
    q = E / size

    # of the parameters scaled to unit length
    q1 = rate / size - q * (q @ rate) / size
    along = q @ rate / size
    across = (q1 @ rate + q @ second) / size
    q2 = second / size - 2 * along * q1 - q * across
    w = 2 * times_conjugate(q1, q)
    return Rotation.from_quat(q).as_matrix(), w, 2 * times_conjugate(q2, q)


def times_conjugate(p, q):
    """Vector part of p q*, Euler parameters with the scalar last."""
    return -p[3] * q[:3] + q[3] * p[:3] - cross(p[:3], q[:3])


def rotation_of_zyx(angles, rates, seconds):
    """(A, w, alpha) of yaw, pitch, roll and their derivatives."""
    turns = [Rotation.from_rotvec(angle * unit) for angle, unit in zip(angles, np.eye(3)[::-1])]
    A, w, alpha = np.eye(3), np.zeros(3), np.zeros(3)

    for turn, unit, rate, second in zip(turns, np.eye(3)[::-1], rates, seconds):
        about = A @ unit
        alpha = alpha + second * about + rate * cross(w, about)
        w = w + rate * about
        A = A @ turn.as_matrix()

    return A, w, alpha


def turning_axes(angles):
    """(3, 3): the axes about which yaw, pitch and roll turn, by column."""
    yawed, pitched = (rotation_of_zyx([*angles[:k], *[0.0] * (3 - k)], *np.zeros((2, 3)))[0] for k in (1, 2))
    return np.column_stack([[0, 0, 1], yawed[:, 1], pitched[:, 0]])


def zyx(A, near):
    """Yaw, pitch, roll of A = Rz Ry Rx from -pi to pi, of which either may be told:
    the one nearer to the hint."""
    angles = [
        np.arctan2(A[1, 0], A[0, 0]),
        np.arctan2(-A[2, 0], np.hypot(A[0, 0], A[1, 0])),
        np.arctan2(A[2, 1], A[2, 2]),
    ]

    if near is not None:
        angles = [
            a + 2 * np.pi * np.round((b - a) / (2 * np.pi)) if abs(b) < 3.2 else a
            for a, b in zip(angles, near)
        ]

    return np.array(angles)


class Ground:
    """The motion of the ground in the inertial frame: (r, A, v, w, a, alpha) at a time."""

    def __init__(self, spec):
        self.spec = spec or {}

        if table := self.spec.get("table"):
            self._tables(table)

    def _tables(self, table):
        time = np.array(table["time"], float)
        place = np.array(table.get("position", np.zeros((len(time), 3))), float)
        angles = si(table, "zyx")

        if table.get("euler_parameters") is not None:
            E = np.array(table["euler_parameters"], float)
            E = E / np.linalg.norm(E, axis=1)[:, None]
        elif angles is not None:
            E = np.array([Rotation.from_matrix(orientation({"zyx_rad": row})).as_quat() for row in angles])
        else:
            E = np.tile([0.0, 0, 0, 1], (len(time), 1))

        # no jumps in sign
        for k in range(1, len(E)):
            E[k] *= -1 if E[k] @ E[k - 1] < 0 else 1

        read = table.get("interpolation", "smooth")
        self.tables = [Table(read, time, column, beyond="hold") for column in np.hstack([place, E]).T]

    @property
    def told(self):
        """What inputs command."""
        return commanded(self.spec, GROUND, {"speed": "velocity"})

    def at(self, t, inputs, seen=None):
        """The motion at t. seen : a motion (r, A, v, w, a, alpha),
        of which what inputs do not tell is taken."""
        if "acceleration" in self.spec:
            a, v, r = (
                np.array(self.spec.get(key, ZERO), float) for key in ("acceleration", "velocity", "position")
            )
            return r + v * t + a * t * t / 2, np.eye(3), v + a * t, ZERO, a, ZERO

        if "rotation" in self.spec:
            return self._rotation(self.spec["rotation"], t)

        if "orbit" in self.spec:
            return self._orbit(self.spec["orbit"], t)

        if "elliptic_orbit" in self.spec:
            return self._ellipse(self.spec["elliptic_orbit"], t)

        if "table" in self.spec:
            columns = np.array([table(t) for table in self.tables]).T
            (r, v, a), E = columns[:, :3], columns[:, 3:]
            A, w, alpha = rotation_of(*E)
            return r, A, v, w, a, alpha

        if "input" in self.spec:
            return self._commanded(inputs, seen)

        return ZERO, np.eye(3), ZERO, ZERO, ZERO, ZERO

    def _rotation(self, spec, t):
        speed, u = si(spec, "speed"), axis(spec.get("axis", "z"))
        A = Rotation.from_rotvec((si(spec, "angle", 0.0) + speed * t) * u).as_matrix()
        point = np.array(spec.get("point", ZERO), float)
        r, w = point - A @ point, speed * u
        v = cross(w, r - point)
        return r, A, v, w, cross(w, v), ZERO

    def _orbit(self, spec, t):
        axes = plane_axes(axis(spec.get("normal", "z")))
        angle = si(spec, "phase", 0.0) + spec["rate"] * t
        A = axes @ Rotation.from_rotvec([0, 0, angle]).as_matrix()
        r, w = spec["radius"] * A[:, 0], spec["rate"] * axes[:, 2]
        v = cross(w, r)
        pointing = spec.get("pointing", True)
        return r, A if pointing else np.eye(3), v, w if pointing else ZERO, cross(w, v), ZERO

    def _ellipse(self, spec, t):
        """By the true anomaly nu: r = p / (1 + e cos nu), r^2 nu' = h."""
        a, e = spec["semi_major_axis"], spec["eccentricity"]
        n = 2 * np.pi / spec["period"] if "period" in spec else np.sqrt(spec["mu"] / a**3)
        p, start = a * (1 - e * e), si(spec, "mean_anomaly", 0.0)

        if "true_anomaly_deg" in spec:
            nu = si(spec, "true_anomaly")
            E = 2 * np.arctan2(np.sqrt(1 - e) * np.sin(nu / 2), np.sqrt(1 + e) * np.cos(nu / 2))
            start = E - e * np.sin(E)

        M = start + n * t
        E = brentq(lambda E: E - e * np.sin(E) - M, M - 1.1, M + 1.1, xtol=1e-15, rtol=1e-15)
        nu = 2 * np.arctan2(np.sqrt(1 + e) * np.sin(E / 2), np.sqrt(1 - e) * np.cos(E / 2))
        angles = [si(spec, key, 0.0) for key in ("node", "inclination", "periapsis")]
        axes = Rotation.from_euler("ZXZ", angles).as_matrix()
        speed, distance = n * a**1.5 / np.sqrt(p), p / (1 + e * np.cos(nu))
        r = distance * (axes @ [np.cos(nu), np.sin(nu), 0.0])
        v = speed * (axes @ [-np.sin(nu), e + np.cos(nu), 0.0])
        acceleration = -(n**2) * a**3 / distance**3 * r

        if not spec.get("pointing", True):
            return r, np.eye(3), v, ZERO, acceleration, ZERO

        rate = speed * p / distance**2
        second = -2 * rate * speed * e * np.sin(nu) / distance
        A = axes @ Rotation.from_rotvec([0, 0, nu]).as_matrix()
        return r, A, v, rate * axes[:, 2], acceleration, second * axes[:, 2]

    def _commanded(self, inputs, seen):
        """What is told holds exactly; the rest is as seen, or the derivatives of the last thing told."""
        told = self.told
        place = [None if seen is None else seen[k] for k in (0, 2, 4)]
        turn = [None if seen is None else seen[k] for k in (1, 3, 5)]
        last = np.zeros((3, 3))
        order = 0

        for k, what in enumerate(("position", "velocity", "acceleration")):
            if what in told:
                last, order = inputs("ground", what, size=3), 0
                place[k] = last[0]
            elif place[k] is None:
                place[k] = last[order]
            order += 1

        course = None

        if "zyx" in told:
            course = rotation_of_zyx(*inputs("ground", "zyx", size=3)[:3])
        elif "euler_parameters" in told:
            course = rotation_of(*inputs("ground", "euler_parameters", size=4)[:3])

        course = course or (np.eye(3), ZERO, ZERO)
        turn[0] = course[0]
        turn[1:] = [course[k] if turn[k] is None else turn[k] for k in (1, 2)]

        if "omega" in told:
            omega = inputs("ground", "omega", size=3)
            turn[1] = omega[0]
            turn[2] = omega[1] if seen is None else turn[2]

        if "alpha" in told:
            turn[2] = inputs("ground", "alpha", size=3)[0]

        return place[0], turn[0], place[1], turn[1], place[2], turn[2]
