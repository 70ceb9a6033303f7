"""Rotors in the wind by splines of their tables, and bodies that make waves."""

from pathlib import Path

import numpy as np
from scipy.interpolate import RectBivariateSpline
from scipy.spatial.transform import Rotation

from .elements import Six, matrix6
from .interpolation import Table


class Blades:
    """A rotor. wind : the scene's table of that."""

    kind = "rotor"
    energy = 0.0

    def __init__(self, given, name, force, wind):
        spec, steady = force["rotor"], wind["steady"]
        self.name, self.ends = name, [force["on"]]
        self.radius = spec["radius"]
        self.density = wind.get("density", 1.225)
        self.turned = None if force.get("input") else given(spec.get("pitch", 0.0), name, "pitch")
        velocity = np.array(steady["velocity"], float)
        self.wind = None if wind.get("input") else given(velocity, "wind", "velocity")
        self.profile = steady.get("exponent", 0.0), steady.get("reference_height", 90.0)
        self.gust = _gust(wind.get("gust"), np.array(steady["velocity"], float), self.profile[1])
        rows = np.loadtxt(Path(spec["table"]), delimiter=",", skiprows=1)
        grid = [np.unique(rows[:, k]) for k in (0, 1)]
        order = np.lexsort((rows[:, 1], rows[:, 0]))
        self.edges = [(x[0], x[-1]) for x in grid]
        self.tables = [
            RectBivariateSpline(*grid, rows[order, k].reshape(*map(len, grid)), s=0) for k in (2, 3)
        ]

    def act(self, now):
        """At an instant."""
        r, A, v, w = now.frame(self.ends[0])
        wind = now.inputs("wind", "velocity", size=3)[0] if self.wind is None else self.wind
        pitch = now.inputs(self.name, "pitch")[0] if self.turned is None else self.turned
        exponent, height = self.profile
        axis = A[:, 0]
        U = (wind * (max(r[2], 0.1) / height) ** exponent + self.gust(now.t) - v) @ axis
        thrust = torque = 0.0

        if U > 0.0:
            at = [np.clip(x, *edge) for x, edge in zip((w @ axis * self.radius / U, pitch), self.edges)]
            size = self.density / 2 * np.pi * self.radius**2 * U * U
            thrust, torque = (size * float(table(*at)[0, 0]) for table in self.tables)
            torque *= self.radius

        power = now.push(self.ends[0], thrust * axis, torque * axis)
        now.load_power += power
        self.now = {"thrust": thrust, "torque": torque, "wind": U, "power": power}


# IEC 61400-1: extreme wind of a year (m/s) by class, turbulence by category
OF_A_YEAR = {"I": 56.0, "II": 47.6, "III": 42.0}
TURBULENCE = {"A+": 0.18, "A": 0.16, "B": 0.14, "C": 0.12}


def _gust(spec, steady, height):
    """What is added to the wind (m/s), as a function of time."""
    if not spec:
        return lambda t: np.zeros(3)

    if "table" in spec:
        table = spec["table"]
        read = table.get("interpolation", "linear")
        columns = [Table(read, table["time"], c, beyond="hold") for c in np.array(table["velocity"], float).T]
        return lambda t: np.array([column(t)[0] for column in columns])

    if "step" in spec:
        step = spec["step"]
        rise, change = step.get("rise", 0.0), np.array(step["velocity"], float)

        if rise == 0.0:
            return lambda t: change * (t >= step["start"])
        return lambda t: change * (1 - np.cos(np.pi * np.clip((t - step["start"]) / rise, 0, 1))) / 2

    eog = spec["eog"]
    period, speed = eog.get("period", 10.5), np.linalg.norm(steady)
    size = eog.get("amplitude")

    if size is None:
        deviation = TURBULENCE[eog.get("turbulence", "B")] * (0.75 * speed + 5.6)
        eddies = 42.0 if height >= 60.0 else 0.7 * height
        size = 3.3 * deviation / (1 + 0.1 * eog["diameter"] / eddies)
        size = min(size, 1.35 * (OF_A_YEAR[eog["turbine_class"]] - speed))

    def blows(t):
        x = np.pi * np.clip((t - eog["start"]) / period, 0, 1)
        return -0.37 * size * np.sin(3 * x) * (1 - np.cos(2 * x)) * steady / speed

    return blows


class WaveMaker(Six):
    """A body in potential flow: its added mass at infinite frequency from WAMIT's file. What waves do to it stands in states that no
    output of a body shows: it is taken from what is told."""

    kind = "hydrodynamics"

    def __init__(self, given, name, force, sea):
        spec = force["hydrodynamics"]
        table = {
            "added_mass": self._infinite(spec, sea.get("density", 1025.0)),
            "axes": spec.get("axes", "first"),
        }
        super().__init__(given, f"{name} water", {"linear": table, "between": ["inertial", force["on"]]})
        self.name, self.kind, self.spec = name, "hydrodynamics", spec
        self.resists = [
            given(matrix6(spec.get(key)), name, key) if key in spec else np.zeros((6, 6))
            for key in ("damping", "quadratic")
        ]

    def _infinite(self, spec, density):
        scale, added = spec.get("scale", 1.0) * spec.get("froude", 1.0), np.zeros((6, 6))

        for line in Path(spec["file"]).read_text().splitlines():
            period, i, j, value, *_ = map(float, line.split())
            if period == 0.0:
                i, j = int(i) - 1, int(j) - 1
                added[i, j] = density * value * scale ** (3 + (i > 2) + (j > 2))

        return added

    def act(self, now):
        """At an instant."""
        now.add_six(self)
        self.told = {}
        _, A, v, w = now.frame(self.ends[1])
        _, _, z, real = Rotation.from_matrix(A).as_quat()
        own = np.kron(np.eye(2), self.own_axes(A, 2 * np.arctan2(z, real)))
        V = own.T @ np.concatenate([v, w])
        force, moment = np.split(own @ (-self.resists[0] @ V - self.resists[1] @ (np.abs(V) * V)), 2)
        power = now.push(self.ends[1], force, moment)
        now.dissipated -= power
        self.told = {"damping_force": force, "damping_moment": moment, "damping_power": power}

        if self.spec.get("excitation") == "input":
            force, moment = (
                now.inputs(self.name, f"excitation_{what}", size=3)[0] for what in ("force", "moment")
            )
            now.input_power += now.push(self.ends[1], force, moment)

        for what in ("radiation", "excitation"):
            force, moment = (now.hints(self.name, f"{what}_{part}") for part in ("force", "moment"))
            if force is not None and moment is not None:
                self.told[f"{what}_power"] = power = now.push(self.ends[1], force, moment)
                now.dissipated -= power if what == "radiation" else 0.0
                now.load_power += power if what == "excitation" else 0.0
