"""A run of a system by scipy, with the motion led back onto the constraints at each communication point."""

import itertools

import numpy as np
from scipy.integrate import solve_ivp
from scipy.spatial.transform import Rotation

from .reading import dotted

TOLERANCE = 1e-11


def run(system, times, motions, inputs=None, hints=None):
    """Motions at times (n,), the first as given.

    inputs : name -> value, or a function of time (s) of all of them. hints : of the start;
    whole turns and parameters s of what follows are those of the instant before.
    """
    at = inputs if callable(inputs) else lambda t: inputs
    course = Course(system, at, hints)
    told = [motions]
    x = course.pack(motions)

    for begin, end in itertools.pairwise(times):
        course.look(begin, x)
        found = solve_ivp(course.rates, (begin, end), x, method="DOP853", rtol=TOLERANCE, atol=1e-12)

        if found.status != 0:
            raise ArithmeticError(f"no motion from {begin} s to {end} s: {found.message}")

        x = course.project(end, found.y[:, -1])
        told.append(course.unpack(x))

    return told


class Course:
    """The state x of a run: r, Euler parameters, v, w of each body in turn."""

    def __init__(self, system, inputs, hints):
        self.system, self.inputs = system, inputs
        self.hints = dict(hints or {})

    def pack(self, motions):
        """x of motions."""
        parts = (
            (r, Rotation.from_matrix(A).as_quat(), v, w)
            for r, A, v, w in (motions[b][:4] for b in self.system.bodies)
        )
        return np.concatenate([np.concatenate(part) for part in parts])

    def unpack(self, x):
        """Motions of x."""
        rows = x.reshape(-1, 13)
        return {
            body: (row[:3], Rotation.from_quat(row[3:7]).as_matrix(), row[7:10], row[10:])
            for body, row in zip(self.system.bodies, rows)
        }

    def solve(self, t, x):
        """The instant at t."""
        return self.system.solve(t, self.unpack(x), self.inputs(t), self.hints)

    def look(self, t, x):
        """Remember whole turns and parameters s at t."""
        now = self.solve(t, x)

        for name, joint in self.system.joints.items():
            angles = {}

            for k, output, _ in joint.angle_names():
                angles.setdefault(dotted(name, output), []).append(now.q[name][k])

            self.hints |= {key: values if len(values) > 1 else values[0] for key, values in angles.items()}

            if name in now.s:
                self.hints[dotted(name, "s")] = now.s[name]

        return now

    def rates(self, t, x):
        """x'."""
        now = self.look(t, x)
        rates = []

        for body, row in zip(self.system.bodies, x.reshape(-1, 13)):
            E, w = row[3:7], row[10:]
            turning = np.append(E[3] * w + np.cross(w, E[:3]), -w @ E[:3]) / 2
            a = now.x[self.system.place[body]]
            rates.append(np.concatenate([row[7:10], turning, a]))

        return np.concatenate(rates)

    def project(self, t, x):
        """x on the constraints: positions by Newton's method, then velocities,
        by the least change in the metric of the mass."""
        for _ in range(10):
            now = self.look(t, x)
            step = self._correction(now, now.residuals)

            if np.abs(step).max(initial=0.0) < 1e-14:
                break

            x = self._moved(x, step)

        now = self.look(t, x)
        change = self._correction(now, now.rates)
        rows = x.reshape(-1, 13).copy()
        rows[:, 7:] += change.reshape(-1, 6)
        return rows.ravel()

    def _correction(self, now, residuals):
        """Small displacements of the bodies (6 n,) that take residuals away."""
        if not len(residuals):
            return np.zeros(6 * len(self.system.bodies))

        n = 6 * len(self.system.bodies)
        C = now.C[:, 6:]
        size = np.diag(now.M)[6:]
        usual = np.median(size[size > 0]) if np.any(size > 0) else 1.0
        scale = 1 / np.sqrt(np.where(size > 1e-10 * usual, size, usual))
        return -(scale * np.linalg.lstsq(C * scale, residuals, rcond=1e-10)[0])[:n]

    @staticmethod
    def _moved(x, step):
        """x after small displacements."""
        rows = x.reshape(-1, 13).copy()

        for row, (dr, turn) in zip(rows, step.reshape(-1, 2, 3)):
            row[:3] += dr
            row[3:7] = (Rotation.from_rotvec(turn) * Rotation.from_quat(row[3:7])).as_quat()

        return rows.ravel()
