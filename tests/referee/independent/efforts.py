"""What acts along the coordinate of a joint of one freedom: spring, damper, friction, stop."""

import numpy as np

from .interpolation import Table
from .reading import si


class Elastic:
    """An effort over a position or a speed: linear from a rest, or by a table.
    Its energy is 0 at the rest."""

    def __init__(self, factor=0.0, rest=0.0, table=None, keys=("position", "effort")):
        self.factor, self.rest, self.table = factor, rest, None

        if table is not None:
            self.table = Table(
                table.get("interpolation", "linear"), si(table, keys[0]), table[keys[1]], beyond="straight"
            )
            self.rest = self.table.first_zero()

    def __call__(self, x):
        """What it bears at x."""
        return self.factor * (x - self.rest) if self.table is None else float(self.table(x)[0])

    def energy(self, x):
        """J, stored at x."""
        if self.table is None:
            return self.factor * (x - self.rest) ** 2 / 2

        return self.table.integral(self.rest, x)


def friction(spec, speed):
    """Effort against a speed: coulomb, static fading by 1/e at the Stribeck speed, smooth about standstill,
    viscous."""
    fade = np.exp(-((speed / spec["stribeck_speed"]) ** 2))
    dry = spec["coulomb"] + (spec["static"] - spec["coulomb"]) * fade
    return dry * np.tanh(speed / spec["smoothing_speed"]) + spec["viscous"] * speed


def stop(spec, x, speed):
    """(elastic effort, damping effort) against going on beyond an end: both together push,
    and do not pull back."""
    beyond = max(0.0, x - spec["upper"]) - max(0.0, spec["lower"] - x)
    elastic = spec["stiffness"] * beyond
    total = elastic + spec["damping"] * speed

    if beyond > 0:
        return elastic, max(0.0, total) - elastic

    return (elastic, min(0.0, total) - elastic) if beyond < 0 else (0.0, 0.0)


class JointParts:
    """Spring, damper, friction and stop of a joint, and the efforts of each on the second marker."""

    def __init__(self, given, name, joint):
        keys = ("position", "effort"), ("speed", "effort")
        spring, damper = joint.get("spring"), joint.get("damper", 0.0)
        self.spring = self.damper = self.friction = self.stop = None

        if spring and spring.get("table") is not None:
            self.spring = Elastic(table=spring["table"], keys=keys[0])
        elif spring:
            self.spring = Elastic(
                given(spring["stiffness"], name, "stiffness"), given(si(spring, "rest", 0.0), name, "rest")
            )

        if isinstance(damper, dict):
            self.damper = Elastic(table=damper["table"], keys=keys[1])
        elif damper:
            self.damper = Elastic(given(damper, name, "damper"))

        if spec := joint.get("friction"):
            values = {
                "stribeck_speed": 0.1,
                "viscous": 0.0,
                "smoothing_speed": 3.7e-7,
                "static": spec["coulomb"],
            } | spec
            self.friction = {key: given(value, name, "friction", key) for key, value in values.items()}

        if spec := joint.get("stop"):
            values = {
                key: si(spec, key, default)
                for key, default in (("lower", -np.inf), ("upper", np.inf), ("damping", 0.0))
            }
            values["stiffness"] = spec["stiffness"]
            self.stop = {key: given(value, name, "stop", key) for key, value in values.items()}

    def efforts(self, x, speed):
        """Part -> effort on the second marker at a position and a speed."""
        found = {}

        if self.spring:
            found["spring"] = -self.spring(x)

        if self.damper:
            found["damper"] = -self.damper(speed)

        if self.friction:
            found["friction"] = -friction(self.friction, speed)

        if self.stop:
            found["stop"] = -sum(stop(self.stop, x, speed))

        return found

    def energy(self, x):
        """J, in spring and stop at a position."""
        energy = self.spring.energy(x) if self.spring else 0.0
        return energy + (stop(self.stop, x, 0.0)[0] ** 2 / (2 * self.stop["stiffness"]) if self.stop else 0.0)

    def dissipated(self, x, speed):
        """W, taken by damper, friction and the damping of the stop."""
        power = self.damper(speed) * speed if self.damper else 0.0
        power += friction(self.friction, speed) * speed if self.friction else 0.0
        return power + (stop(self.stop, x, speed)[1] * speed if self.stop else 0.0)
